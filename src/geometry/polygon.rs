//! Polygons to triangles.
//!
//! A polygon of n corners in space becomes n − 2 triangles on its corners alone. It is seen in the plane of
//! its Newell normal N = Σ pᵢ × pᵢ₊₁ (for a flat polygon its own plane, otherwise the one in which its
//! shadow is largest); which corners are convex and which triangles are empty is decided there by exact
//! predicates, and the quality of a triangle is measured in space.
//!
//! Guaranteed for every input with finite coordinates: n − 2 triangles that together have the polygon's
//! boundary, wound as the polygon is. Guaranteed where the shadow is a simple polygon, however concave: the
//! shadows of the triangles do not overlap. Not guaranteed: anything about the shape of the result where the
//! shadow crosses itself; nor the best triangulation, only a good one (ears are cut best first).

use nalgebra::Vector3;
use robust::{Coord, orient2d};

/// Appends the triangles of one polygon: n − 2 of them, none for fewer than three corners.
///
/// A triangle passes through as it is. A quadrilateral is split along the diagonal with the larger smallest
/// angle, never along one that lies outside. A larger polygon loses its best ear until four corners are left.
///
/// A polygon may pass through a place twice (as around a hole with a bridge to it). Corners repeated one
/// after the other are not removed: each makes one triangle without area, which the caller who does not want
/// it avoids by removing the repetition first. Without a normal (all corners on a line, or the two halves of a
/// figure eight in balance) the result is a fan.
///
/// **Costs** O(n²) time for n corners at worst.
///
/// ```
/// # use cutflow::geometry::polygon::triangulate;
/// // A dart: the diagonal from 1 to 3 would lie outside.
/// let positions = [[0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [0.5, 0.0, 0.0], [2.0, 1.0, 0.0]];
/// let mut triangles = Vec::new();
/// triangulate(&positions, &[0, 1, 2, 3], &mut triangles);
/// assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
/// ```
pub fn triangulate(positions: &[[f64; 3]], polygon: &[u32], out: &mut Vec<[u32; 3]>) {
    match *polygon {
        [] | [_] | [_, _] => return,
        [a, b, c] => return out.push([a, b, c]),
        _ => {}
    }
    let push = |t: [usize; 3]| out.push(t.map(|corner| polygon[corner]));
    let Some(outline) = Outline::new(positions, polygon) else {
        return (2..polygon.len()).map(|i| [0, i - 1, i]).for_each(push);
    };
    if polygon.len() == 4 {
        outline.split_quad([0, 1, 2, 3]).into_iter().for_each(push);
    } else {
        Ears::new(&outline).cut_all(push);
    }
}

/// A polygon in space and its shadow; corners are numbered from 0.
struct Outline {
    /// About the first corner, of size about 1.
    points: Vec<Vector3<f64>>,
    /// In the plane of the Newell normal, where the polygon runs counter-clockwise.
    shadow: Vec<Coord<f64>>,
}

impl Outline {
    /// `None` where there is no normal.
    fn new(positions: &[[f64; 3]], polygon: &[u32]) -> Option<Self> {
        let at = |&v: &u32| Vector3::from(positions[v as usize]);
        let origin = at(&polygon[0]);
        let mut points = Vec::from_iter(polygon.iter().map(|v| at(v) - origin));
        // Neither far away nor tiny polygons shall lose digits in the products below.
        let size = points.iter().fold(0.0, |size: f64, p| size.max(p.amax()));
        if size == 0.0 {
            return None;
        }
        points.iter_mut().for_each(|p| *p /= size);
        let newell: Vector3<f64> = (2..points.len()).map(|i| points[i - 1].cross(&points[i])).sum();
        // Below the rounding of the sum the normal points anywhere.
        let rounding = f64::EPSILON * points.len() as f64;
        let normal = newell.try_normalize(rounding)?;
        let [right, up] = plane_axes(normal);
        let shadow = points.iter().map(|p| Coord { x: p.dot(&right), y: p.dot(&up) }).collect();
        Some(Self { points, shadow })
    }

    /// Positive where the triangle runs counter-clockwise in the shadow; the sign is exact.
    fn orientation(&self, [a, b, c]: [usize; 3]) -> f64 {
        orient2d(self.shadow[a], self.shadow[b], self.shadow[c])
    }

    /// The smallest angle in space; 0 for a triangle without shadow and −1 for one turned over.
    fn quality(&self, triangle: [usize; 3]) -> f64 {
        let orientation = self.orientation(triangle);
        if orientation > 0.0 {
            smallest_angle(triangle.map(|corner| self.points[corner]))
        } else if orientation < 0.0 {
            -1.0
        } else {
            0.0
        }
    }

    /// The better of the two ways to split four corners.
    fn split_quad(&self, [a, b, c, d]: [usize; 4]) -> [[usize; 3]; 2] {
        let worse = |[s, t]: [[usize; 3]; 2]| self.quality(s).min(self.quality(t));
        let (ac, bd) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
        if worse(bd) > worse(ac) { bd } else { ac }
    }
}

/// The ring of corners that is left while ears are cut off.
struct Ears<'a> {
    outline: &'a Outline,
    previous: Vec<usize>,
    next: Vec<usize>,
    /// For each corner in the ring, [`Outline::quality`] of the triangle that it is the tip of.
    quality: Vec<f64>,
    /// The corners that were not convex at the start: if any corner is in the way of an ear, one of these is.
    reflex: Vec<usize>,
    /// Whether a corner is in the ring and not convex. Once false it stays so: cutting makes angles smaller.
    is_reflex: Vec<bool>,
    /// For each corner, how many of `reflex` are known not to be in its way. This keeps the whole linear for
    /// each corner and shape of its ear, so that all is O(n²).
    cleared: Vec<usize>,
}

impl<'a> Ears<'a> {
    fn new(outline: &'a Outline) -> Self {
        let n = outline.points.len();
        let previous = Vec::from_iter((0..n).map(|i| (i + n - 1) % n));
        let next = Vec::from_iter((0..n).map(|i| (i + 1) % n));
        let quality = Vec::from_iter((0..n).map(|i| outline.quality([previous[i], i, next[i]])));
        let is_reflex = Vec::from_iter(quality.iter().map(|&q| q <= 0.0));
        let reflex = (0..n).filter(|&i| is_reflex[i]).collect();
        Self { outline, previous, next, quality, reflex, is_reflex, cleared: vec![0; n] }
    }

    fn cut_all(mut self, mut push: impl FnMut([usize; 3])) {
        let mut corner = 0;
        for left in (5..=self.next.len()).rev() {
            let tip = self.best_ear(corner, left);
            push(self.triangle(tip));
            corner = self.cut(tip);
        }
        let [a, c] = [corner, self.next[self.next[corner]]];
        self.outline.split_quad([a, self.next[a], c, self.next[c]]).into_iter().for_each(push);
    }

    fn triangle(&self, tip: usize) -> [usize; 3] {
        [self.previous[tip], tip, self.next[tip]]
    }

    /// The ear with the largest smallest angle among the `left` corners from `start` on.
    fn best_ear(&mut self, start: usize, left: usize) -> usize {
        let (mut best, mut best_quality) = (None, 0.0);
        // A simple polygon has an ear. In another one take a corner without area, which does no harm, else a
        // convex one, else any.
        let (mut makeshift, mut makeshift_quality) = (start, f64::NEG_INFINITY);
        let mut corner = start;
        for _ in 0..left {
            let quality = self.quality[corner];
            if quality > best_quality && self.is_ear(corner) {
                (best, best_quality) = (Some(corner), quality);
            }
            let makes_do = if quality == 0.0 { f64::INFINITY } else { quality };
            if makes_do > makeshift_quality {
                (makeshift, makeshift_quality) = (corner, makes_do);
            }
            corner = self.next[corner];
        }
        best.unwrap_or(makeshift)
    }

    /// Whether nothing is in the way of cutting the convex corner `tip` off.
    fn is_ear(&mut self, tip: usize) -> bool {
        let triangle = self.triangle(tip);
        while let Some(&p) = self.reflex.get(self.cleared[tip]) {
            let counts = self.is_reflex[p] && !triangle.contains(&p);
            if counts && self.is_in_the_way(triangle, p) {
                return false;
            }
            self.cleared[tip] += 1;
        }
        true
    }

    /// Whether corner `p`, not one of the triangle's own, forbids to cut the counter-clockwise triangle `abc`
    /// off: it lies inside or on its rim, or at its tip `b` and has an edge that enters it.
    fn is_in_the_way(&self, [a, b, c]: [usize; 3], p: usize) -> bool {
        let orientation = |triangle| self.outline.orientation(triangle);
        let is_at = |q: usize| self.outline.shadow[p] == self.outline.shadow[q];
        if is_at(b) {
            let enters = |q| orientation([a, b, q]) > 0.0 && orientation([b, c, q]) > 0.0;
            return enters(self.previous[p]) || enters(self.next[p]);
        }
        // What enters the triangle at `a` or `c` cannot leave it across the edges of the polygon: some other
        // corner of it is inside, and found there.
        !is_at(a)
            && !is_at(c)
            && [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|t| orientation(t) >= 0.0)
    }

    /// Takes a corner out of the ring and gives its successor.
    fn cut(&mut self, tip: usize) -> usize {
        let [previous, _, next] = self.triangle(tip);
        self.next[previous] = next;
        self.previous[next] = previous;
        self.is_reflex[tip] = false;
        for corner in [previous, next] {
            self.quality[corner] = self.outline.quality(self.triangle(corner));
            self.is_reflex[corner] &= self.quality[corner] <= 0.0;
            self.cleared[corner] = 0;
        }
        next
    }
}

/// Two unit vectors that complete a unit normal to a right-handed frame (Duff et al. 2017). For a normal along
/// a coordinate axis they are axes too, so that coordinates of axis-parallel polygons stay exact.
fn plane_axes(n: Vector3<f64>) -> [Vector3<f64>; 2] {
    let sign = 1.0_f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    [
        Vector3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
        Vector3::new(b, sign + n.y * n.y * a, -n.y),
    ]
}

/// The smallest angle of a triangle: the one across its shortest side.
fn smallest_angle(p: [Vector3<f64>; 3]) -> f64 {
    let side = |i: usize| p[(i + 2) % 3] - p[(i + 1) % 3];
    let squared = [0, 1, 2].map(|i| side(i).norm_squared());
    let tip = if squared[0] <= squared[1] && squared[0] <= squared[2] {
        0
    } else if squared[1] <= squared[2] {
        1
    } else {
        2
    };
    let (u, v) = (p[(tip + 1) % 3] - p[tip], p[(tip + 2) % 3] - p[tip]);
    u.cross(&v).norm().atan2(u.dot(&v))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_3, PI, TAU};

    use super::*;

    type Points = Vec<[f64; 3]>;

    fn flat(points: impl IntoIterator<Item = [f64; 2]>) -> Points {
        points.into_iter().map(|[x, y]| [x, y, 0.0]).collect()
    }

    fn triangles_of(points: &Points) -> Vec<[u32; 3]> {
        let polygon = Vec::from_iter((0..).take(points.len()));
        let mut out = Vec::new();
        triangulate(points, &polygon, &mut out);
        out
    }

    fn normal_of(points: &Points, triangle: [u32; 3]) -> Vector3<f64> {
        let [a, b, c] = triangle.map(|v| Vector3::from(points[v as usize]));
        (b - a).cross(&(c - a)) / 2.0
    }

    /// The triangles fill the flat polygon exactly once: as many as there must be, all of them turned as the
    /// polygon is, and the areas add up.
    fn assert_fills(points: &Points) -> Vec<[u32; 3]> {
        let triangles = triangles_of(points);
        assert_eq!(triangles.len(), points.len() - 2);
        let p = |i: usize| Vector3::from(points[i % points.len()]) - Vector3::from(points[0]);
        let newell: Vector3<f64> = (0..points.len()).map(|i| p(i).cross(&p(i + 1)) / 2.0).sum();
        let unit = newell.normalize();
        let areas = Vec::from_iter(triangles.iter().map(|&t| normal_of(points, t).dot(&unit)));
        assert!(areas.iter().all(|&a| a > 0.0), "a triangle is turned over or empty");
        let sum: f64 = areas.iter().sum();
        // Rounding of n products of numbers of the polygon's size.
        assert!((sum - newell.norm()).abs() < 1e-12 * newell.norm(), "{sum} {}", newell.norm());
        let mut used = Vec::from_iter(triangles.concat());
        used.sort_unstable();
        used.dedup();
        assert_eq!(used.len(), points.len(), "a corner is unused");
        triangles
    }

    fn smallest(points: &Points, triangles: &[[u32; 3]]) -> f64 {
        let angle = |t: &[u32; 3]| smallest_angle(t.map(|v| Vector3::from(points[v as usize])));
        triangles.iter().map(angle).fold(f64::INFINITY, f64::min)
    }

    fn star(tips: usize, inner: f64) -> Points {
        flat((0..2 * tips).map(|i| {
            let r = if i % 2 == 0 { 1.0 } else { inner };
            let t = PI * i as f64 / tips as f64;
            [r * t.cos(), r * t.sin()]
        }))
    }

    fn comb(teeth: usize) -> Points {
        let mut points = vec![[0.0, 0.0], [2.0 * teeth as f64 - 1.0, 0.0]];
        for i in (0..teeth).rev() {
            let x = 2.0 * i as f64;
            points.extend([[x + 1.0, 9.0], [x, 9.0]]);
            if i > 0 {
                points.extend([[x, 0.1], [x - 1.0, 0.1]]);
            }
        }
        flat(points)
    }

    fn spiral(corners: usize, turns: f64) -> Points {
        let half = corners / 2;
        let at = |i: usize, shift: f64| {
            let s = i as f64 / half as f64;
            let (r, t) = (0.1 + s + shift, TAU * turns * s);
            [r * t.cos(), r * t.sin()]
        };
        // Out along one wall, back along the other; the wall is thinner than the gap.
        let out = (0..half).map(|i| at(i, 0.4 / turns));
        let back = (0..half).rev().map(|i| at(i, 0.0));
        flat(out.chain(back))
    }

    fn tilted(points: &Points) -> Points {
        let axis = nalgebra::Unit::new_normalize(Vector3::new(1.0, 2.0, -0.5));
        let turn = nalgebra::Rotation3::from_axis_angle(&axis, 1.1);
        let place = |p: &[f64; 3]| (turn * Vector3::from(*p) * 37.0).add_scalar(1000.0).into();
        points.iter().map(place).collect()
    }

    #[test]
    fn fewer_than_three_corners_make_no_triangle() {
        for n in 0..3 {
            assert!(triangles_of(&flat((0..n).map(|i| [f64::from(i), 0.0]))).is_empty());
        }
    }

    #[test]
    fn a_triangle_passes_through_even_without_area() {
        let mut out = vec![[7, 8, 9]];
        triangulate(&[[0.0; 3]; 9], &[5, 5, 3], &mut out);
        assert_eq!(out, [[7, 8, 9], [5, 5, 3]]);
    }

    #[test]
    fn a_quad_takes_its_better_diagonal() {
        let kite = flat([[0.0, 0.0], [1.0, -0.3], [2.0, 0.0], [1.0, 0.3]]);
        assert_eq!(triangles_of(&kite), [[0, 1, 3], [1, 2, 3]]);
        let square = flat([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(triangles_of(&square), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_concave_quad_is_never_folded_wherever_it_begins() {
        let dart = [[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]];
        for shift in 0..4 {
            let mut dart = dart;
            dart.rotate_left(shift);
            assert_fills(&flat(dart));
            assert_fills(&tilted(&flat(dart)));
            dart.reverse();
            assert_fills(&flat(dart));
        }
    }

    #[test]
    fn a_quad_with_three_corners_on_a_line_has_no_empty_triangle() {
        for shift in 0..4 {
            let mut quad = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]];
            quad.rotate_left(shift);
            assert_fills(&flat(quad));
        }
    }

    #[test]
    fn concave_polygons_are_filled_exactly_once() {
        for points in [
            star(5, 0.3),
            star(9, 0.02),
            comb(2),
            comb(13),
            spiral(80, 3.0),
            spiral(600, 12.0),
            star(500, 0.9),
        ] {
            assert_fills(&points);
            assert_fills(&tilted(&points));
            let mut clockwise = points;
            clockwise.reverse();
            assert_fills(&clockwise);
        }
    }

    #[test]
    fn corners_on_a_straight_side_get_triangles_with_area() {
        // A triangle with 30 corners on each side.
        let tips = [[0.0, 0.0], [32.0, 0.0], [0.0, 32.0]];
        let side = |i: usize| {
            let ([ax, ay], [bx, by]): ([f64; 2], [f64; 2]) = (tips[i], tips[(i + 1) % 3]);
            (0..32)
                .map(move |k| f64::from(k) / 32.0)
                .map(move |t| [ax + t * (bx - ax), ay + t * (by - ay)])
        };
        assert_fills(&flat((0..3).flat_map(side)));
    }

    #[test]
    fn good_ears_are_cut_first() {
        // A regular hexagon has triangulations with angles of 30°, and none better.
        let hexagon = star(3, 1.0);
        let triangles = assert_fills(&hexagon);
        assert!(smallest(&hexagon, &triangles) > 0.999 * FRAC_PI_3 / 2.0);
        // A fan over a strip of squares has angles of 1/20; ears need not fall below 30°.
        let strip = (0..=20).map(|i| [f64::from(i), 0.0]);
        let strip = flat(strip.chain((0..=20).rev().map(|i| [f64::from(i), 1.0])));
        let triangles = assert_fills(&strip);
        assert!(smallest(&strip, &triangles) > 0.5, "{}", smallest(&strip, &triangles));
    }

    #[test]
    fn a_hole_with_a_bridge_is_left_open() {
        // A square of side 6 with a square hole of side 2: the bridge is walked twice.
        let points = flat([
            [0.0, 0.0],
            [6.0, 0.0],
            [6.0, 6.0],
            [0.0, 6.0],
            [2.0, 2.0],
            [2.0, 4.0],
            [4.0, 4.0],
            [4.0, 2.0],
        ]);
        let polygon = [0, 1, 2, 3, 0, 4, 5, 6, 7, 4];
        let mut out = Vec::new();
        triangulate(&points, &polygon, &mut out);
        let areas = Vec::from_iter(out.iter().map(|&t| normal_of(&points, t).z));
        assert_eq!(out.len(), 8);
        assert!(areas.iter().all(|&a| a > 0.0), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 32.0).abs() < 1e-12);
    }

    #[test]
    fn a_bent_polygon_keeps_its_corners_and_its_side() {
        let wave = Vec::from_iter((0..12).map(|i| {
            let t = TAU * f64::from(i) / 12.0;
            [t.cos(), t.sin(), 0.5 * (3.0 * t).cos()]
        }));
        let triangles = triangles_of(&wave);
        assert_eq!(triangles.len(), 10);
        assert!(triangles.iter().all(|&t| normal_of(&wave, t).z > 0.0));
    }

    #[test]
    fn scale_and_place_do_not_change_the_triangles() {
        let points = spiral(80, 3.0);
        let expected = triangles_of(&points);
        // Powers of two scale without rounding.
        for scale in [2.0_f64.powi(-900), 2.0_f64.powi(120)] {
            let scaled = points.iter().map(|p| p.map(|x| x * scale)).collect();
            assert_eq!(triangles_of(&scaled), expected);
        }
    }

    #[test]
    fn degenerate_polygons_give_all_their_triangles() {
        let point = vec![[1.0; 3]; 7];
        let line = flat((0..9).map(|i| [f64::from(i), f64::from(i)]));
        let bow_tie = flat([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
        let there_and_back = flat((0..9).map(|i: i32| [f64::from((i - 4).abs()), 0.0]));
        let crossing = flat((0..15).map(|i| {
            let t = TAU * 7.0 * f64::from(i) / 15.0;
            [t.cos(), t.sin()]
        }));
        let doubled =
            flat([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0], [0.0, 1.0]]);
        let broken = vec![[f64::NAN; 3]; 6];
        for points in [point, line, bow_tie, there_and_back, crossing, doubled, broken] {
            assert_eq!(triangles_of(&points).len(), points.len() - 2);
        }
    }
}
