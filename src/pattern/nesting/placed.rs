//! Shapes on their sheets, and how near or deep in each other they lie.

use super::plane::{self, meet, orientation, segment_distance, sides, size, winding};
use super::{NestPose, NestShape};
use crate::pattern::piece::Bounds;

/// A shape on its sheet.
pub(super) struct Placed {
    pub shape: usize,
    pub sheet: usize,
    pub outlines: Vec<Vec<[f64; 2]>>,
    pub bounds: Bounds,
}

impl Placed {
    pub fn new(shape: usize, polygon: &NestShape, pose: &NestPose) -> Self {
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

    pub fn contains(&self, p: [f64; 2]) -> bool {
        winding(&self.outlines, p) != 0
    }

    /// How deep a point lies within; negative outside.
    fn depth(&self, p: [f64; 2]) -> f64 {
        let squared = |s| plane::squared_distance(p, s);
        let distance = self.sides().map(squared).fold(f64::INFINITY, f64::min).sqrt();
        if self.contains(p) { distance } else { -distance }
    }
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
pub(super) fn rim_distance(a: &Placed, b: &Placed, reach: f64) -> (f64, [f64; 2]) {
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
pub(super) fn overlap(a: &Placed, b: &Placed, deepest: f64) -> Option<[f64; 2]> {
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
