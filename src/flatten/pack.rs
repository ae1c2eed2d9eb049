//! Charts side by side on a sheet, standing still while they change.
//!
//! Each chart is turned into its smallest bounding rectangle; the rectangles are laid along a skyline, largest first, on a
//! sheet about as high as wide. While a cut moves, the next layout is made from the last one: a chart is turned as it was,
//! as far as its rectangle stays small, and keeps its neighbours: what was left of it stays left, what was below stays below,
//! and the layout only breathes with the sizes. A fresh layout replaces it when that has become clearly smaller.
//!
//! Guaranteed: rectangles do not overlap and keep the gap; the same input gives the same bits. Not guaranteed: a smallest
//! sheet; nesting of outlines.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Point2, Rotation2, Vector2};

use super::overlap::orientation;
use super::{small, turned};

/// A chart to be placed.
#[derive(Clone, Copy, Debug)]
pub struct Shape<'a> {
    /// Its outline; empty for a chart that is not there.
    pub outline: &'a [Point2<f64>],
    /// Points of the chart with names that last from one layout to the next and belong to no other chart.
    pub landmarks: &'a [(u32, Point2<f64>)],
}

/// A rotation about the origin, then a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Counter-clockwise, radians.
    pub angle: f64,
    /// In the unit of the charts.
    pub shift: Vector2<f64>,
}

impl Pose {
    /// Where a point of the chart comes to lie.
    pub fn apply(&self, p: Point2<f64>) -> Point2<f64> {
        self.turn() * p + self.shift
    }

    /// The rotation, for many points.
    pub(super) fn turn(&self) -> Rotation2<f64> {
        Rotation2::new(self.angle)
    }
}

/// A layout of charts, and what the next one needs to stay like it.
#[derive(Clone, Debug, PartialEq)]
pub struct Packing {
    /// One for each shape.
    pub poses: Vec<Pose>,
    /// Rectangle of each shape on the sheet; without area for a shape without outline.
    pub boxes: Vec<Rectangle>,
    /// The sheet, with a corner in the origin.
    pub sheet: Vector2<f64>,
    /// For each landmark name its shape and place on the sheet.
    landmarks: Vec<Option<(u32, Point2<f64>)>>,
}

/// A rectangle along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Lower left corner.
    pub low: Point2<f64>,
    /// Width and height.
    pub size: Vector2<f64>,
}

/// A chart keeps its direction while its rectangle is at most this much larger than its smallest one. Less, and charts sway
/// with every change of their outline; more, and the sheet fills badly.
const KEEP_ANGLE: f64 = 1.05;
/// Beyond that it turns towards the smallest rectangle by at most this angle (4°) a layout: slow enough to follow with the eye.
const TURN: f64 = 0.07;
/// Sizes are alike within this share: less decides nothing, since rounding would decide.
const ALIKE: f64 = 1e-3;
/// Where the first landmark goes if nothing else decides: askew, so that symmetric charts have it clearly nearer one way.
const TOWARDS: [f64; 2] = [0.94, 0.34];
/// A layout is kept while its sheet is at most this much longer than a fresh one's. Less, and charts change places often
/// while a cut moves; more, and they shrink on the screen.
const KEEP_LAYOUT: f64 = 1.2;

/// Landmarks of a chart that are looked at to recognise it and to turn it: more tell nothing new.
const LANDMARKS: usize = 1000;

/// For how many landmarks of a shape one stands.
fn stride(shape: &Shape) -> usize {
    shape.landmarks.len() / LANDMARKS + 1
}

/// Some landmarks of a shape, evenly from all.
fn some_landmarks<'a>(shape: &Shape<'a>) -> impl Iterator<Item = &'a (u32, Point2<f64>)> + use<'a> {
    shape.landmarks.iter().step_by(stride(shape))
}

/// Lays charts out on a sheet.
///
/// **Takes** shapes; the gap between them; the last layout, if the next is to stay like it. Charts are recognised by their
/// landmarks. **Costs** O(n log n) for n outline points and O(k²) for k charts.
///
/// ```
/// # use cutflow::flatten::{Shape, pack};
/// # use nalgebra::Point2;
/// let standing = [[0.0, 0.0], [1.0, 0.0], [1.0, 3.0], [0.0, 3.0]].map(Point2::from);
/// let packing = pack(&[Shape { outline: &standing, landmarks: &[] }], 0.0, None);
/// assert!((packing.sheet.x - 3.0).abs() < 1e-14 && (packing.sheet.y - 1.0).abs() < 1e-14);
/// ```
pub fn pack(shapes: &[Shape], gap: f64, previous: Option<&Packing>) -> Packing {
    let ancestors = match previous {
        Some(previous) => ancestors(shapes, previous),
        None => vec![None; shapes.len()],
    };
    let mut poses = vec![Pose { angle: 0.0, shift: Vector2::zeros() }; shapes.len()];
    let mut lows = vec![Point2::origin(); shapes.len()];
    let mut sizes = vec![Vector2::zeros(); shapes.len()];
    for (i, shape) in shapes.iter().enumerate().filter(|(_, shape)| !shape.outline.is_empty()) {
        let hull = convex_hull(shape.outline);
        let last = previous
            .zip(ancestors[i])
            .and_then(|(previous, _)| last_angle(shape, i, &ancestors, previous));
        poses[i].angle = choose_angle(shape, &hull, last);
        let (low, high) = bounds(&hull, poses[i].angle);
        (lows[i], sizes[i]) = (low, high - low);
    }

    // Half the gap on each side of every rectangle.
    let placed: Vec<usize> = (0..shapes.len()).filter(|&i| !shapes[i].outline.is_empty()).collect();
    let tiles: Vec<Vector2<f64>> = placed.iter().map(|&i| sizes[i].add_scalar(gap)).collect();
    let fresh = skyline(&tiles);
    let kept = previous.and_then(|previous| {
        let old: Vec<Option<Rectangle>> =
            placed.iter().map(|&i| ancestors[i].map(|a| previous.boxes[a as usize])).collect();
        keep_neighbours(&tiles, &old, gap)
    });
    let side = |corners: &[Point2<f64>]| extent(corners, &tiles).max();
    let corners = match kept {
        Some(kept) if side(&kept) <= KEEP_LAYOUT * side(&fresh) => kept,
        _ => fresh,
    };

    let mut boxes = vec![Rectangle { low: Point2::origin(), size: Vector2::zeros() }; shapes.len()];
    for (&i, &corner) in placed.iter().zip(&corners) {
        boxes[i] = Rectangle { low: corner, size: sizes[i] };
        poses[i].shift = corner - lows[i];
    }
    let sheet = if placed.is_empty() {
        Vector2::zeros()
    } else {
        extent(&corners, &tiles).add_scalar(-gap)
    };
    let mut landmarks = Vec::with_capacity(shapes.iter().map(|s| s.landmarks.len()).sum());
    for (i, shape) in shapes.iter().enumerate() {
        let turn = poses[i].turn();
        for &(name, p) in shape.landmarks {
            if landmarks.len() <= name as usize {
                landmarks.resize(name as usize + 1, None);
            }
            landmarks[name as usize] = Some((small(i), turn * p + poses[i].shift));
        }
    }
    Packing { poses, boxes, sheet, landmarks }
}

/// For each shape the shape of the last layout that it shares most landmarks with; each of those once.
fn ancestors(shapes: &[Shape], previous: &Packing) -> Vec<Option<u32>> {
    let mut votes = Vec::new();
    for (i, shape) in shapes.iter().enumerate() {
        let mut counts = vec![0usize; previous.poses.len()];
        for (name, _) in some_landmarks(shape) {
            if let Some(Some((ancestor, _))) = previous.landmarks.get(*name as usize) {
                counts[*ancestor as usize] += stride(shape);
            }
        }
        let found = counts.iter().enumerate().filter(|(_, count)| **count > 0);
        votes.extend(found.map(|(ancestor, &count)| (usize::MAX - count, i, ancestor)));
    }
    votes.sort_unstable();
    let mut result = vec![None; shapes.len()];
    let mut taken = vec![false; previous.poses.len()];
    for (_, i, ancestor) in votes {
        let there = !shapes[i].outline.is_empty() && previous.boxes[ancestor].size.x > 0.0;
        if there && result[i].is_none() && !taken[ancestor] {
            result[i] = Some(small(ancestor));
            taken[ancestor] = true;
        }
    }
    result
}

/// The angle that turns a shape's landmarks best onto their last places (least squares).
fn last_angle(
    shape: &Shape,
    i: usize,
    ancestors: &[Option<u32>],
    previous: &Packing,
) -> Option<f64> {
    let common: Vec<(Vector2<f64>, Vector2<f64>)> = some_landmarks(shape)
        .filter_map(|(name, p)| {
            let (ancestor, last) = (*previous.landmarks.get(*name as usize)?)?;
            (Some(ancestor) == ancestors[i]).then_some((p.coords, last.coords))
        })
        .collect();
    let count = common.len() as f64;
    let mean =
        common.iter().fold((Vector2::zeros(), Vector2::zeros()), |m, (p, q)| (m.0 + p, m.1 + q));
    let (mut cos, mut sin) = (0.0, 0.0);
    for (p, q) in &common {
        let (p, q) = (p - mean.0 / count, q - mean.1 / count);
        cos += p.dot(&q);
        sin += p.perp(&q);
    }
    (common.len() > 1 && cos.hypot(sin) > 0.0).then(|| sin.atan2(cos))
}

/// The angle to place a hull at, given the one that it had.
fn choose_angle(shape: &Shape, hull: &[Point2<f64>], last: Option<f64>) -> f64 {
    let along_sides = rectangles(hull);
    let smallest = |r: &&Along, s: &&Along| r.size.product().total_cmp(&s.size.product());
    let Some(smallest) = along_sides.iter().min_by(smallest) else { return last.unwrap_or(0.0) };
    let limit = smallest.size.product() * (1.0 + ALIKE);
    let as_small = along_sides.iter().filter(|along| along.size.product() <= limit);
    let Some(last) = last else { return fresh_angle(shape, hull, as_small) };
    let (low, high) = bounds(hull, last);
    if (high - low).product() <= KEEP_ANGLE * smallest.size.product() {
        return last;
    }
    let away = |along: &Along| {
        let away = along.angle - last;
        away - (away / FRAC_PI_2).round() * FRAC_PI_2
    };
    // Of two that are as near, the one counter-clockwise.
    let effort = |turn: &f64| turn.abs() + if *turn < 0.0 { ALIKE } else { 0.0 };
    let nearest = as_small.map(away).min_by(|a, b| effort(a).total_cmp(&effort(b)));
    last + nearest.unwrap_or(0.0).clamp(-TURN, TURN)
}

/// In a rectangle as good as the smallest, lying, with the heavier half down; of several such angles the one that turns the first
/// landmark nearest to [`TOWARDS`]. A symmetric chart lies the same way whatever its last digits are.
fn fresh_angle<'a>(
    shape: &Shape,
    hull: &[Point2<f64>],
    as_small: impl Iterator<Item = &'a Along>,
) -> f64 {
    let centre = centroid(hull);
    let reach = hull.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let arm = shape.landmarks.iter().map(|(_, p)| p - centre).find(|arm| arm.norm() > 0.5 * reach);
    let angles = as_small
        .flat_map(|along| (0..4).map(|quarter| along.turned(quarter)))
        .filter(|along| along.size.y <= along.size.x * (1.0 + ALIKE))
        .filter(|along| along.lean.y <= along.size.y * ALIKE)
        .map(|along| along.angle);
    let off = |angle: f64| match arm {
        Some(arm) => -(Rotation2::new(angle) * arm).dot(&Vector2::from(TOWARDS)),
        None => 0.0,
    };
    angles.min_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0.0)
}

/// Lower left and upper right corner of a hull after a rotation.
fn bounds(hull: &[Point2<f64>], angle: f64) -> (Point2<f64>, Point2<f64>) {
    let turn = Rotation2::new(angle);
    let mut turned = hull.iter().map(|p| turn * p);
    let first = turned.next().unwrap_or_else(Point2::origin);
    turned.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)))
}

/// Corners of the convex hull, counter-clockwise, none on a side (monotone chain).
pub(crate) fn convex_hull(points: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let mut sorted = points.to_vec();
    sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let mut hull: Vec<Point2<f64>> = Vec::new();
    let mut chain = |points: &mut dyn Iterator<Item = &Point2<f64>>| {
        let start = hull.len();
        for &p in points {
            while hull.len() >= start + 2
                && orientation(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        // The other chain begins with it.
        hull.pop();
    };
    chain(&mut sorted.iter());
    chain(&mut sorted.iter().rev());
    hull
}

/// A bounding rectangle with a side along a side of the hull.
struct Along {
    /// Turns that side to the right.
    angle: f64,
    /// Width and height after that turn.
    size: Vector2<f64>,
    /// From the middle of the rectangle to the hull's centroid.
    lean: Vector2<f64>,
}

impl Along {
    /// The same after so many quarters of a turn more.
    fn turned(&self, quarters: u8) -> Self {
        let turn = |along: Self| Self {
            angle: along.angle + FRAC_PI_2,
            size: along.size.yx(),
            lean: turned(along.lean),
        };
        let own = Self { angle: self.angle, size: self.size, lean: self.lean };
        (0..quarters).fold(own, |along, _| turn(along))
    }
}

/// The bounding rectangles along all sides of a hull, the smallest of all among them: four calipers go round once.
fn rectangles(hull: &[Point2<f64>]) -> Vec<Along> {
    let n = hull.len();
    if n < 2 {
        return Vec::new();
    }
    let centre = centroid(hull);
    let side = |i: usize| hull[(i + 1) % n] - hull[i % n];
    let (mut right, mut top, mut left) = (1, 1, 1);
    let around = |i: usize| {
        let along = side(i).normalize();
        let up = turned(along);
        // Each caliper moves on while the hull still goes its way.
        right = right.max(i + 1);
        while right < i + n && side(right).dot(&along) > 0.0 {
            right += 1;
        }
        top = top.max(right);
        while top < i + n && side(top).dot(&up) > 0.0 {
            top += 1;
        }
        left = left.max(top);
        while left < i + n && side(left).dot(&along) < 0.0 {
            left += 1;
        }
        let at = |j: usize| hull[j % n] - hull[i];
        let (left, right) = (at(left).dot(&along), at(right).dot(&along));
        let size = Vector2::new(right - left, at(top).dot(&up));
        let own = centre - hull[i];
        let lean =
            Vector2::new(own.dot(&along) - 0.5 * (left + right), own.dot(&up) - 0.5 * size.y);
        Along { angle: -along.y.atan2(along.x), size, lean }
    };
    (0..n).map(around).collect()
}

/// Centroid of a hull's area; the mean of its corners where it has none.
fn centroid(hull: &[Point2<f64>]) -> Point2<f64> {
    let Some(&first) = hull.first() else { return Point2::origin() };
    let mean = hull.iter().map(|p| p - first).sum::<Vector2<f64>>() / hull.len() as f64;
    let fan = hull.windows(2).map(|pair| (pair[0] - first, pair[1] - first));
    let (area, moment) = fan.fold((0.0, Vector2::zeros()), |(area, moment), (p, q)| {
        (area + p.perp(&q), moment + (p + q) * (p.perp(&q) / 3.0))
    });
    first + if area > 0.0 { moment / area } else { mean }
}

/// Upper right corner of all tiles.
fn extent(corners: &[Point2<f64>], tiles: &[Vector2<f64>]) -> Vector2<f64> {
    corners
        .iter()
        .zip(tiles)
        .fold(Vector2::zeros(), |sup, (corner, tile)| sup.sup(&(corner.coords + tile)))
}

/// Lower left corners of tiles on the squarest of several sheets.
fn skyline(tiles: &[Vector2<f64>]) -> Vec<Point2<f64>> {
    let mut order: Vec<usize> = (0..tiles.len()).collect();
    order.sort_by(|&a, &b| tiles[b].product().total_cmp(&tiles[a].product()));
    let is_alike = |&a: &usize, &b: &usize| tiles[b].product() > (1.0 - ALIKE) * tiles[a].product();
    order.chunk_by_mut(is_alike).for_each(<[usize]>::sort_unstable);
    let area: f64 = tiles.iter().map(|t| t.product()).sum();
    let widest = tiles.iter().fold(0.0, |m: f64, t| m.max(t.x));
    let mut best = (f64::INFINITY, Vec::new());
    for step in 0..12 {
        // From a sheet without waste to one half wasted.
        let width = widest.max((area * (1.0 + f64::from(step) / 12.0)).sqrt());
        let corners = skyline_of_width(tiles, &order, width * (1.0 + 1e-9));
        let side = extent(&corners, tiles).max();
        if side < best.0 * (1.0 - ALIKE) {
            best = (side, corners);
        }
    }
    best.1
}

/// Each tile as low as possible, then as far left as possible, upon those before it; what is hardly lower is not lower.
fn skyline_of_width(tiles: &[Vector2<f64>], order: &[usize], width: f64) -> Vec<Point2<f64>> {
    let mut corners = vec![Point2::origin(); tiles.len()];
    // A tile as wide as the one below it rests on that one, whatever their last digits are.
    let slack = 1e-13 * width;
    // Where each level begins, and its height.
    let mut line = vec![Point2::new(0.0, 0.0)];
    for &tile in order {
        let size = tiles[tile];
        let mut best = Point2::new(0.0, f64::INFINITY);
        for (i, level) in line.iter().enumerate() {
            let end = level.x + size.x;
            if end > width {
                break;
            }
            let below = line[i..].iter().take_while(|l| l.x < end - slack);
            let y = below.fold(0.0, |m: f64, l| m.max(l.y));
            if y < best.y - ALIKE * size.y {
                best = Point2::new(level.x, y);
            }
        }
        corners[tile] = best;
        let end = best.x + size.x;
        // The level that the tile ends on goes on behind it.
        let last = line.iter().rposition(|l| l.x < end - slack).unwrap_or(0);
        let behind = line[last].y;
        let goes_on = line.get(last + 1).map_or(width, |next| next.x) > end + slack;
        line.retain(|l| l.x < best.x || l.x >= end - slack);
        let at = line.partition_point(|l| l.x < best.x);
        line.insert(at, Point2::new(best.x, best.y + size.y));
        if goes_on {
            line.insert(at + 1, Point2::new(end, behind));
        }
    }
    corners
}

/// Tiles in the places of the last layout, moved no more than their sizes demand: what was to the left of a tile stays there,
/// what was below stays below. New tiles stand in a row on top. None where no tile has a last place.
fn keep_neighbours(
    tiles: &[Vector2<f64>],
    old: &[Option<Rectangle>],
    gap: f64,
) -> Option<Vec<Point2<f64>>> {
    let slack = 1e-9 * old.iter().flatten().fold(0.0, |m: f64, r| m.max(r.size.max()));
    let mut corners = vec![Point2::origin(); tiles.len()];
    for axis in 0..2 {
        let mut order: Vec<(usize, Rectangle)> =
            old.iter().enumerate().filter_map(|(i, r)| Some((i, (*r)?))).collect();
        order.sort_by(|(_, r), (_, s)| r.low[axis].total_cmp(&s.low[axis]));
        for (rank, &(i, rectangle)) in order.iter().enumerate() {
            let before = order[..rank].iter().filter(|(_, other)| {
                other.low[axis] + other.size[axis] + gap <= rectangle.low[axis] + slack
            });
            corners[i][axis] =
                before.fold(0.0, |m: f64, &(j, _)| m.max(corners[j][axis] + tiles[j][axis]));
        }
    }
    let known: Vec<usize> = (0..tiles.len()).filter(|&i| old[i].is_some()).collect();
    if known.is_empty() {
        return None;
    }
    let size = known
        .iter()
        .fold(Vector2::zeros(), |sup: Vector2<f64>, &i| sup.sup(&(corners[i].coords + tiles[i])));
    let mut row = Point2::new(0.0, size.y);
    let mut height = 0.0f64;
    for i in (0..tiles.len()).filter(|&i| old[i].is_none()) {
        if row.x > 0.0 && row.x + tiles[i].x > size.x {
            row = Point2::new(0.0, row.y + height);
            height = 0.0;
        }
        corners[i] = row;
        row.x += tiles[i].x;
        height = height.max(tiles[i].y);
    }
    Some(corners)
}
