//! Motions, distances and outlines in the plane.

use nalgebra::Point2;
use robust::{Coord, orient2d};

use crate::flatten::pack;
use crate::pattern::piece::Bounds;

/// A turn about the origin after a mirroring x to −x or none: an orthogonal matrix by rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    /// Radians.
    pub angle: f64,
    pub is_mirrored: bool,
    matrix: [f64; 4],
}

impl Turn {
    pub fn new(angle: f64, is_mirrored: bool) -> Self {
        let quarters = angle / std::f64::consts::FRAC_PI_2;
        let whole = quarters.round();
        // Quarter turns without rounding, so that straight sides stay straight.
        let (sin, cos) = if (quarters - whole).abs() < 1e-12 {
            match whole.rem_euclid(4.0) {
                x if x < 0.5 => (0.0, 1.0),
                x if x < 1.5 => (1.0, 0.0),
                x if x < 2.5 => (0.0, -1.0),
                _ => (-1.0, 0.0),
            }
        } else {
            angle.sin_cos()
        };
        let m = if is_mirrored { -1.0 } else { 1.0 };
        Self { angle, is_mirrored, matrix: [cos * m, -sin, sin * m, cos] }
    }

    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, c, d] = self.matrix;
        [a * x + b * y, c * x + d * y]
    }

    /// The inverse, which is the transpose.
    pub fn undo(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, c, d] = self.matrix;
        [a * x + c * y, b * x + d * y]
    }

    /// The matrix of this turn and then the inverse of another.
    pub fn relative_to(&self, other: &Self) -> [f64; 4] {
        let [a, b, c, d] = self.matrix;
        let [[p, r], [q, s]] = [other.undo([a, c]), other.undo([b, d])];
        [p, q, r, s]
    }

    pub fn bounds(&self, points: &[[f64; 2]]) -> Bounds {
        Bounds::around(points.iter().map(|&p| self.apply(p)))
    }
}

/// Random numbers: the generator SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub(super) struct Dice(pub u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + self.unit() * (high - low)
    }

    /// One of 0 … n − 1; 0 for n = 0.
    pub fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() % n.max(1) as u64).unwrap_or(0)
    }
}

/// Pairs of consecutive points of a closed outline.
pub(super) fn sides(points: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(&a, &b)| [a, b])
}

pub(super) fn area(points: &[[f64; 2]]) -> f64 {
    let Some(&o) = points.first() else { return 0.0 };
    0.5 * sides(points).map(|[a, b]| cross(minus(a, o), minus(b, o))).sum::<f64>()
}

pub(super) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn size(a: [f64; 2]) -> f64 {
    a[0].hypot(a[1])
}

/// The point of a segment nearest to a point.
pub(super) fn nearest(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    let along = minus(b, a);
    let squared = dot(along, along);
    let t = if squared > 0.0 { (dot(minus(p, a), along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    [a[0] + t * along[0], a[1] + t * along[1]]
}

pub(super) fn squared_distance(p: [f64; 2], segment: [[f64; 2]; 2]) -> f64 {
    let away = minus(p, nearest(p, segment));
    dot(away, away)
}

/// Positive where a, b, c turn to the left; the sign is exact.
pub(super) fn orientation(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

/// Whether two segments have a point in common; exact.
pub(super) fn meet([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> bool {
    let [s, t] = [orientation(a, b, c), orientation(a, b, d)];
    let [u, v] = [orientation(c, d, a), orientation(c, d, b)];
    let apart = |s: f64, t: f64| (s > 0.0 && t > 0.0) || (s < 0.0 && t < 0.0);
    if apart(s, t) || apart(u, v) {
        return false;
    }
    // On one line they meet if their extents do; otherwise the extents do if they meet.
    (0..2).all(|k| a[k].max(b[k]) >= c[k].min(d[k]) && c[k].max(d[k]) >= a[k].min(b[k]))
}

/// Distance of two segments and the place on the first.
pub(super) fn segment_distance(s: [[f64; 2]; 2], t: [[f64; 2]; 2]) -> (f64, [f64; 2]) {
    if meet(s, t) {
        let [u, v] = s.map(|p| orientation(t[0], t[1], p).abs());
        let part = if u + v > 0.0 { u / (u + v) } else { 0.0 };
        let along = minus(s[1], s[0]);
        return (0.0, [s[0][0] + part * along[0], s[0][1] + part * along[1]]);
    }
    let of = |p, segment| size(minus(p, nearest(p, segment)));
    let mut best = (f64::INFINITY, s[0]);
    for p in s {
        let d = of(p, t);
        if d < best.0 {
            best = (d, p);
        }
    }
    for p in t {
        let d = of(p, s);
        if d < best.0 {
            best = (d, nearest(p, s));
        }
    }
    best
}

/// How often closed outlines wind around a point; exact off the outlines.
pub(super) fn winding<'a>(
    outlines: impl IntoIterator<Item = &'a Vec<[f64; 2]>>,
    p: [f64; 2],
) -> i32 {
    let mut turns = 0;
    for [a, b] in outlines.into_iter().flat_map(|outline| sides(outline)) {
        if (a[1] <= p[1]) != (b[1] <= p[1]) {
            let side = orientation(a, b, p);
            if a[1] <= p[1] && side > 0.0 {
                turns += 1;
            } else if a[1] > p[1] && side < 0.0 {
                turns -= 1;
            }
        }
    }
    turns
}

/// Corners of the convex hull, counter-clockwise.
pub(super) fn convex_hull(points: impl IntoIterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let points: Vec<Point2<f64>> = points.into_iter().map(Point2::from).collect();
    pack::convex_hull(&points).into_iter().map(Into::into).collect()
}

/// A closed outline with fewer points, none of the left out ones farther than a tolerance from its new side (Douglas and Peucker
/// 1973, from the two points farthest apart along x and y).
pub(super) fn simplify(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let n = points.len();
    if n < 4 {
        return points.to_vec();
    }
    let by = |i: &usize, j: &usize| {
        let [p, q] = [points[*i], points[*j]];
        (p[0] + p[1]).total_cmp(&(q[0] + q[1]))
    };
    let first = (0..n).min_by(by).unwrap_or(0);
    let last = (0..n).max_by(by).unwrap_or(n / 2);
    let mut is_kept = vec![false; n];
    is_kept[first] = true;
    is_kept[last] = true;
    // Ranges of indices that may run past the end.
    let (i, j) = (first.min(last), first.max(last));
    let mut ranges = vec![(i, j), (j, i + n)];
    while let Some((i, j)) = ranges.pop() {
        let segment = [points[i % n], points[j % n]];
        let mut far = (tolerance * tolerance, 0);
        for k in i + 1..j {
            let d = squared_distance(points[k % n], segment);
            if d > far.0 {
                far = (d, k);
            }
        }
        if far.1 > 0 {
            is_kept[far.1 % n] = true;
            ranges.extend([(i, far.1), (far.1, j)]);
        }
    }
    let kept: Vec<_> = (0..n).filter(|&i| is_kept[i]).map(|i| points[i]).collect();
    // A flat outline keeps its points.
    if kept.len() < 3 { points.to_vec() } else { kept }
}
