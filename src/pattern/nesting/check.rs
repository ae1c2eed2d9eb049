//! Whether a layout may be cut as it stands: by distances of outlines alone, whatever made it.

use std::fmt;

use super::plane::{self, meet, orientation, segment_distance, sides, size, winding};
use super::{NestParams, NestPose, NestShape, Stock};
use crate::pattern::piece::Bounds;

/// Distances may fall short by this much, mm: a thousandth of what any cutter knows, and a million times the rounding of a
/// metre. Without it pieces that touch would fail by their last digit.
pub const CHECK_TOLERANCE_MM: f64 = 1e-6;

/// A turn may be off by this much, radians: rounding.
const TURN_TOLERANCE: f64 = 1e-9;

/// What is wrong with a layout. Shapes are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NestFault {
    /// There is not one pose for each shape.
    Count {
        /// Shapes.
        shapes: usize,
        /// Poses.
        poses: usize,
    },
    /// A pose is not finite.
    NotFinite {
        /// The shape.
        shape: usize,
    },
    /// The grain does not allow the turn.
    Turned {
        /// The shape.
        shape: usize,
        /// Degrees from the nearest turn that is allowed.
        by_deg: f64,
    },
    /// The shape must not be turned over.
    Mirrored {
        /// The shape.
        shape: usize,
    },
    /// The shape reaches over the margin.
    Outside {
        /// The shape.
        shape: usize,
        /// How far.
        by_mm: f64,
    },
    /// A roll, or stock without limit, has one sheet.
    NoSuchSheet {
        /// The shape.
        shape: usize,
        /// Where it lies.
        sheet: usize,
    },
    /// A shape that is too large for the stock is not alone on its sheet.
    NotAlone {
        /// The shape.
        shape: usize,
        /// Another on its sheet.
        other: usize,
    },
    /// Two shapes are closer than the gap.
    TooClose {
        /// The shapes.
        shapes: [usize; 2],
        /// Their distance.
        distance_mm: f64,
        /// Where, on the sheet.
        at: [f64; 2],
    },
    /// Two shapes overlap.
    Overlap {
        /// The shapes.
        shapes: [usize; 2],
        /// Where, on the sheet.
        at: [f64; 2],
    },
}

impl fmt::Display for NestFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Count { shapes, poses } => write!(f, "{poses} poses for {shapes} pieces"),
            Self::NotFinite { shape } => write!(f, "piece {} lies nowhere", shape + 1),
            Self::Turned { shape, by_deg } => {
                write!(f, "piece {} is turned {by_deg:.3}° off its grain", shape + 1)
            }
            Self::Mirrored { shape } => write!(f, "piece {} is turned over", shape + 1),
            Self::Outside { shape, by_mm } => {
                write!(f, "piece {} reaches {by_mm:.3} mm over the margin", shape + 1)
            }
            Self::NoSuchSheet { shape, sheet } => {
                write!(f, "piece {} lies on sheet {} of one", shape + 1, sheet + 1)
            }
            Self::NotAlone { shape, other } => {
                write!(f, "piece {} is too large, but shares a sheet with {}", shape + 1, other + 1)
            }
            Self::TooClose { shapes: [a, b], distance_mm, at: [x, y] } => write!(
                f,
                "pieces {} and {} are {distance_mm:.3} mm apart at {x:.1}, {y:.1} mm",
                a + 1,
                b + 1
            ),
            Self::Overlap { shapes: [a, b], at: [x, y] } => {
                write!(f, "pieces {} and {} overlap at {x:.1}, {y:.1} mm", a + 1, b + 1)
            }
        }
    }
}

/// Whether all shapes keep the gap, the margin and the grain, to [`CHECK_TOLERANCE_MM`]; a shape may lie in a hole of another.
///
/// **Takes** shapes as nested, and a pose for each; shapes without a finite outline are passed over. **Gives** the first fault by
/// number of shape. Crossings are decided by exact predicates on the rounded places of points. Where the gap is 0 and outlines may
/// touch, depth of overlap is measured at their points, at where they come within reach of one another, and at three places
/// between. **Costs** about O(n log n) for outlines that are near each other only here and there.
pub fn check(
    shapes: &[NestShape],
    poses: &[NestPose],
    params: &NestParams,
) -> Result<(), NestFault> {
    if shapes.len() != poses.len() {
        return Err(NestFault::Count { shapes: shapes.len(), poses: poses.len() });
    }
    let mut placed = Vec::new();
    for (shape, (polygon, pose)) in shapes.iter().zip(poses).enumerate() {
        if polygon.is_laid() {
            check_pose(shape, polygon, pose, params)?;
            let placed_shape = Placed::new(shape, polygon, pose);
            check_margin(&placed_shape, pose, params)?;
            placed.push(placed_shape);
        }
    }
    placed.sort_by(|a, b| a.sheet.cmp(&b.sheet).then(a.bounds.low[0].total_cmp(&b.bounds.low[0])));
    let mut first: Option<NestFault> = None;
    let mut order = [usize::MAX; 2];
    for (i, a) in placed.iter().enumerate() {
        let beside = placed[i + 1..].iter().take_while(|b| b.sheet == a.sheet);
        for b in beside {
            let (a, b) = if a.shape < b.shape { (a, b) } else { (b, a) };
            if [a.shape, b.shape] < order
                && let Some(fault) = check_pair(a, b, poses, params.gap_mm)
            {
                first = Some(fault);
                order = [a.shape, b.shape];
            }
        }
    }
    first.map_or(Ok(()), Err)
}

impl NestShape {
    /// Whether it can be laid at all: points, all of them finite.
    pub(super) fn is_laid(&self) -> bool {
        let is_finite = self.outlines.iter().flatten().flatten().all(|x| x.is_finite());
        is_finite && self.upright.is_finite() && self.area() > 0.0
    }

    /// Area within the outlines, mm².
    pub fn area(&self) -> f64 {
        self.outlines.iter().map(|outline| plane::area(outline)).sum()
    }
}

/// A shape on its sheet.
struct Placed {
    shape: usize,
    sheet: usize,
    outlines: Vec<Vec<[f64; 2]>>,
    bounds: Bounds,
}

impl Placed {
    fn new(shape: usize, polygon: &NestShape, pose: &NestPose) -> Self {
        let turn = plane::Turn::new(pose.angle, pose.is_mirrored);
        let place = |&p: &[f64; 2]| {
            let [x, y] = turn.apply(p);
            [x + pose.shift[0], y + pose.shift[1]]
        };
        let mut outlines: Vec<Vec<[f64; 2]>> =
            polygon.outlines.iter().map(|outline| outline.iter().map(place).collect()).collect();
        outlines.retain(|outline| !outline.is_empty());
        let bounds = Bounds::around(outlines.iter().flatten().copied());
        Self { shape, sheet: pose.sheet, outlines, bounds }
    }

    fn sides(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        self.outlines.iter().flat_map(|outline| sides(outline))
    }

    /// The sides that reach into a rectangle.
    fn sides_in(&self, bounds: Bounds) -> Vec<[[f64; 2]; 2]> {
        let reaches = |[a, b]: &[[f64; 2]; 2]| {
            (0..2).all(|k| a[k].max(b[k]) >= bounds.low[k] && a[k].min(b[k]) <= bounds.high[k])
        };
        self.sides().filter(reaches).collect()
    }

    fn contains(&self, p: [f64; 2]) -> bool {
        winding(&self.outlines, p) != 0
    }

    /// How deep a point lies within; negative outside.
    fn depth(&self, p: [f64; 2]) -> f64 {
        let squared = |s| plane::squared_distance(p, s);
        let distance = self.sides().map(squared).fold(f64::INFINITY, f64::min).sqrt();
        if self.contains(p) { distance } else { -distance }
    }
}

fn check_pose(
    shape: usize,
    polygon: &NestShape,
    pose: &NestPose,
    params: &NestParams,
) -> Result<(), NestFault> {
    if !pose.angle.is_finite() || !pose.shift.iter().all(|x| x.is_finite()) {
        return Err(NestFault::NotFinite { shape });
    }
    if pose.is_mirrored && !polygon.may_mirror {
        return Err(NestFault::Mirrored { shape });
    }
    // Grain along φ from up is along −φ in the mirror.
    let upright = if pose.is_mirrored { -polygon.upright } else { polygon.upright };
    let off = params.rotations.off(pose.angle - upright);
    if off > params.tolerance_deg.to_radians() + TURN_TOLERANCE {
        return Err(NestFault::Turned { shape, by_deg: off.to_degrees() });
    }
    Ok(())
}

fn check_margin(placed: &Placed, pose: &NestPose, params: &NestParams) -> Result<(), NestFault> {
    if pose.is_too_large {
        return Ok(());
    }
    if pose.sheet > 0 && !matches!(params.stock, Stock::Sheet { .. }) {
        return Err(NestFault::NoSuchSheet { shape: placed.shape, sheet: pose.sheet });
    }
    let margin = params.margin_mm;
    let high = match params.stock {
        Stock::Roll { width_mm } => [width_mm, f64::INFINITY],
        Stock::Sheet { width_mm, height_mm, .. } => [width_mm, height_mm],
        Stock::Free => [f64::INFINITY; 2],
    };
    let Bounds { low, high: top } = placed.bounds;
    let over = (0..2).map(|k| (margin - low[k]).max(top[k] - (high[k] - margin)));
    let by_mm = over.fold(0.0, f64::max);
    if by_mm > CHECK_TOLERANCE_MM {
        return Err(NestFault::Outside { shape: placed.shape, by_mm });
    }
    Ok(())
}

fn check_pair(a: &Placed, b: &Placed, poses: &[NestPose], gap: f64) -> Option<NestFault> {
    let shapes = [a.shape, b.shape];
    for (shape, other) in [(a.shape, b.shape), (b.shape, a.shape)] {
        if poses[shape].is_too_large {
            return Some(NestFault::NotAlone { shape, other });
        }
    }
    let is_apart = |k: usize| {
        a.bounds.low[k] >= b.bounds.high[k] + gap || b.bounds.low[k] >= a.bounds.high[k] + gap
    };
    if is_apart(0) || is_apart(1) {
        return None;
    }
    let least = gap - CHECK_TOLERANCE_MM;
    if least <= 0.0 {
        let deepest = -least;
        return overlap(a, b, deepest).map(|at| NestFault::Overlap { shapes, at });
    }
    let (distance_mm, at) = rim_distance(a, b, gap);
    if distance_mm >= least {
        // The rims are apart, so that a point tells for all: outer outlines come first.
        let within = [(a, b), (b, a)].into_iter().find_map(|(a, b)| {
            let p = a.outlines[0][0];
            b.contains(p).then_some(p)
        });
        return within.map(|at| NestFault::Overlap { shapes, at });
    }
    Some(if distance_mm > 0.0 {
        NestFault::TooClose { shapes, distance_mm, at }
    } else {
        NestFault::Overlap { shapes, at }
    })
}

/// Calls for every pair of sides of two shapes with extents that come closer than a reach.
fn near_sides(
    a: &Placed,
    b: &Placed,
    reach: f64,
    mut call: impl FnMut([[f64; 2]; 2], [[f64; 2]; 2]),
) {
    let common = Bounds {
        low: [0, 1].map(|k| a.bounds.low[k].max(b.bounds.low[k]) - reach),
        high: [0, 1].map(|k| a.bounds.high[k].min(b.bounds.high[k]) + reach),
    };
    let of_a = a.sides_in(common);
    let mut of_b = b.sides_in(common);
    let left = |s: &[[f64; 2]; 2]| s[0][0].min(s[1][0]);
    of_b.sort_by(|s, t| left(s).total_cmp(&left(t)));
    let widest = of_b.iter().fold(0.0, |w: f64, [p, q]| w.max((p[0] - q[0]).abs()));
    for s in of_a {
        let extent = |k: usize| [s[0][k].min(s[1][k]) - reach, s[0][k].max(s[1][k]) + reach];
        let [x, y] = [extent(0), extent(1)];
        let from = of_b.partition_point(|t| left(t) < x[0] - widest);
        for &t in of_b[from..].iter().take_while(|t| left(t) <= x[1]) {
            if t[0][1].max(t[1][1]) >= y[0] && t[0][1].min(t[1][1]) <= y[1] {
                call(s, t);
            }
        }
    }
}

/// Distance of the rims of two shapes, where it is less than a reach, and where.
fn rim_distance(a: &Placed, b: &Placed, reach: f64) -> (f64, [f64; 2]) {
    let mut best = (f64::INFINITY, [0.0; 2]);
    near_sides(a, b, reach, |s, t| {
        let found = segment_distance(s, t);
        if found.0 < best.0 {
            best = found;
        }
    });
    best
}

/// A place where two shapes overlap deeper than allowed.
///
/// What they have in common is bounded by parts of the rim of one within the other, or by rims that lie on each other; in that last
/// case one lies within the other, and any point inside of it tells.
fn overlap(a: &Placed, b: &Placed, deepest: f64) -> Option<[f64; 2]> {
    for (a, b) in [(a, b), (b, a)] {
        // For every side of the one the parts at which it meets the other.
        let mut cuts: Vec<([[f64; 2]; 2], f64)> = Vec::new();
        near_sides(a, b, deepest, |s, t| {
            let along = plane::minus(s[1], s[0]);
            let squared = plane::dot(along, along);
            if squared > 0.0 {
                if meet(s, t) {
                    let [u, v] = s.map(|p| orientation(t[0], t[1], p).abs());
                    if u + v > 0.0 {
                        cuts.push((s, u / (u + v)));
                    }
                }
                for p in t {
                    if size(plane::minus(p, plane::nearest(p, s))) <= deepest {
                        cuts.push((s, plane::dot(plane::minus(p, s[0]), along) / squared));
                    }
                }
            }
        });
        cuts.sort_by(|(s, t), (u, v)| {
            let key = |s: &[[f64; 2]; 2], t: f64| [s[0][0], s[0][1], s[1][0], s[1][1], t];
            let (k, l) = (key(s, *t), key(u, *v));
            k.iter()
                .zip(l)
                .map(|(x, y)| x.total_cmp(&y))
                .find(|o| o.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        let is_deep = |p: &[f64; 2]| b.depth(*p) > deepest;
        // Points and sides that meet nothing.
        let all = a.sides().flat_map(|[p, q]| [p, [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]]);
        let within =
            |p: &[f64; 2]| (0..2).all(|k| p[k] > b.bounds.low[k] && p[k] < b.bounds.high[k]);
        if let Some(p) = all.filter(within).find(is_deep) {
            return Some(p);
        }
        let mut from = 0;
        while from < cuts.len() {
            let side = cuts[from].0;
            let to = from + cuts[from..].iter().take_while(|(s, _)| *s == side).count();
            let inner = cuts[from..to].iter().map(|&(_, t)| t.clamp(0.0, 1.0));
            let ends: Vec<f64> =
                std::iter::once(0.0).chain(inner).chain(std::iter::once(1.0)).collect();
            let place = |t: f64| [0, 1].map(|k| side[0][k] + t * (side[1][k] - side[0][k]));
            let parts = ends
                .windows(2)
                .flat_map(|w| [0.25, 0.5, 0.75].map(|part| place(w[0] + part * (w[1] - w[0]))));
            if let Some(p) = parts.into_iter().filter(within).find(is_deep) {
                return Some(p);
            }
            from = to;
        }
    }
    [(a, b), (b, a)].into_iter().find_map(|(a, b)| {
        let p = inner_point(a)?;
        (b.depth(p) > deepest && a.depth(p) > deepest).then_some(p)
    })
}

/// A point well inside of a shape: the middle of the widest stretch of three lines across it.
fn inner_point(placed: &Placed) -> Option<[f64; 2]> {
    let Bounds { low, high } = placed.bounds;
    let mut best: (f64, Option<[f64; 2]>) = (0.0, None);
    // Unlikely parts, so that lines run through no corners of tidy shapes.
    for part in [0.2713, 0.5171, 0.7639] {
        let y = low[1] + part * (high[1] - low[1]);
        let crossing = |[a, b]: [[f64; 2]; 2]| {
            ((a[1] > y) != (b[1] > y)).then(|| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
        };
        let mut xs: Vec<f64> = placed.sides().filter_map(crossing).collect();
        xs.sort_by(f64::total_cmp);
        for w in xs.windows(2) {
            let p = [0.5 * (w[0] + w[1]), y];
            if w[1] - w[0] > best.0 && placed.contains(p) {
                best = (w[1] - w[0], Some(p));
            }
        }
    }
    best.1
}
