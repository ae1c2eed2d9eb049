//! A polyline as a smooth curve.

use nalgebra::Point2;

use super::cubic::{Cubic, Samples, chords, errors, fitted, length, point};
use crate::flatten::overlap;
use crate::pattern::plane::{along, direction, distance, minus};

/// A curve, and the polyline that stands for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fitted {
    /// Cubic Bézier curves, each by two control points and its end; the first begins at `points[0]`. A closed one ends there.
    pub curve: Vec<[[f64; 2]; 3]>,
    /// Points of the curve; chords between them are off it by no more than 0.05 mm, and no more than the tolerance. A closed curve's
    /// first point is not repeated.
    pub points: Vec<[f64; 2]>,
    /// Index in `points` of each corner that was to be kept, in their order.
    pub corners: Vec<usize>,
    /// How many parts between corners stayed polylines.
    pub kept: usize,
    /// Length of the curve less that of the polyline it was made from, mm.
    pub longer_mm: f64,
}

/// Chords of the flattened curve are off by no more than this, mm.
const CHORD_MM: f64 = 0.05;
/// A fitted curve is as long as its polyline to this, mm: two partners then agree to twice as much.
const LENGTH_MM: f64 = 0.05;
/// A part that is too long or too short is fitted again with half the tolerance, so many times.
const FINER: usize = 4;
/// Of points, against 1 for middles of sides: with 2 a circle is as long as its polygon to fourth order, away from its ends.
const WEIGHT: f64 = 2.0;
/// Tries with other weights, if the length is not far off.
const BALANCING: usize = 6;

/// A stretch between two corners.
struct Part {
    /// First point and number of sides.
    first: usize,
    sides: usize,
    /// Directions at its ends if it goes on smoothly there.
    smooth: [Option<[f64; 2]>; 2],
    curve: Vec<Cubic>,
    is_kept: bool,
}

/// Fits a smooth curve to a polyline.
///
/// **Takes** points in order (those of a closed polyline without the first one again), the indices of corners, which are kept exactly and where
/// the curve may turn, and the tolerance. **Gives** a curve through the first point, all corners and, if it is open, the last point; smooth (G1) elsewhere but where a part
/// stayed a polyline. With less than 2 points, or a tolerance that is not positive, the polyline itself.
/// **Costs** O(n log n) distances for n points.
pub fn fit(points: &[[f64; 2]], is_closed: bool, corners: &[usize], tolerance_mm: f64) -> Fitted {
    let n = points.len();
    let sides = if is_closed { n } else { n.saturating_sub(1) };
    if n < 2 || points.iter().flatten().any(|x| !x.is_finite()) {
        return Fitted { points: points.to_vec(), ..Fitted::default() };
    }
    let mut corners: Vec<usize> = corners.iter().copied().filter(|&c| c < n).collect();
    corners.sort_unstable();
    corners.dedup();
    // Every curve begins at point 0: a closed one goes on smoothly there unless it is a corner.
    let mut breaks = corners.clone();
    breaks.extend([0, sides]);
    breaks.sort_unstable();
    breaks.dedup();
    let is_seamless = is_closed && corners.first() != Some(&0);
    let seam = if is_seamless { tangent(points, is_closed, 0) } else { None };
    let mut parts: Vec<Part> = breaks
        .windows(2)
        .map(|b| {
            let start = seam.filter(|_| b[0] == 0);
            let end = seam.filter(|_| b[1] == sides);
            Part {
                first: b[0],
                sides: b[1] - b[0],
                smooth: [start, end],
                curve: Vec::new(),
                is_kept: false,
            }
        })
        .collect();
    let total: f64 = (0..sides).map(|i| distance(points[i], points[(i + 1) % n])).sum();
    for part in &mut parts {
        part.fit(points, tolerance_mm, LENGTH_MM / total);
    }
    // No crossing that the polyline has not: parts that cross stay as they were.
    let allowed = crossings(points, is_closed).len();
    loop {
        let (flat, owners) = flatten(&parts, is_closed, tolerance_mm);
        let found = crossings(&flat, is_closed);
        let mut changed = false;
        if found.len() > allowed {
            for side in found.into_iter().flatten() {
                let part = &mut parts[owners[side]];
                if !part.is_kept {
                    part.keep(points);
                    changed = true;
                }
            }
        }
        if !changed {
            let mut places = Vec::new();
            let mut at = 0;
            for (k, part) in parts.iter().enumerate() {
                places.push((part.first, at));
                at += owners.iter().filter(|&&owner| owner == k).count();
            }
            places.push((sides, at));
            let corners = corners
                .iter()
                .filter_map(|c| places.iter().find(|p| p.0 == *c).map(|p| p.1))
                .collect();
            let cubics = || parts.iter().flat_map(|part| &part.curve);
            return Fitted {
                curve: cubics().map(|c| [c[1], c[2], c[3]]).collect(),
                longer_mm: cubics().map(length).sum::<f64>() - total,
                kept: parts.iter().filter(|part| part.is_kept).count(),
                points: flat,
                corners,
            };
        }
    }
}

impl Part {
    fn points(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        (self.first..=self.first + self.sides).map(|i| points[i % points.len()]).collect()
    }

    fn fit(&mut self, points: &[[f64; 2]], tolerance: f64, per_mm: f64) {
        let mut own = self.points(points);
        own.dedup();
        let long: f64 = own.windows(2).map(|p| distance(p[0], p[1])).sum();
        let mut finer = tolerance;
        for _ in 0..=FINER {
            if own.len() < 3 || !(finer > 0.0) {
                break;
            }
            // The more the points weigh against the middles of sides, the farther out the curve lies in bends, and the longer it
            // is: halved between bounds until its length is right.
            let (mut weight, mut bounds) = (WEIGHT, [WEIGHT / 16.0, WEIGHT * 64.0]);
            for _ in 0..BALANCING {
                let mut curve = Vec::new();
                if !divide(&own, self.smooth, (finer, weight), &mut curve) {
                    break;
                }
                let error = (curve.iter().map(length).sum::<f64>() - long) / (per_mm * long);
                if error.abs() <= 1.0 {
                    self.curve = curve;
                    return;
                }
                if error.abs() > 20.0 {
                    break;
                }
                bounds[usize::from(error > 0.0)] = weight;
                weight = (bounds[0] * bounds[1]).sqrt();
            }
            finer *= 0.5;
        }
        // A single side loses nothing by being a straight curve.
        self.is_kept = self.sides > 1;
        self.straight(&own);
    }

    fn keep(&mut self, points: &[[f64; 2]]) {
        self.is_kept = true;
        let mut own = self.points(points);
        own.dedup();
        self.straight(&own);
    }

    fn straight(&mut self, own: &[[f64; 2]]) {
        let third = |p: [f64; 2], q: [f64; 2], s: f64| along(p, s / 3.0, minus(q, p));
        self.curve = own
            .windows(2)
            .map(|p| [p[0], third(p[0], p[1], 1.0), third(p[0], p[1], 2.0), p[1]])
            .collect();
    }
}

/// Fits a polyline by one cubic, or divides it; whether it could be done.
fn divide(
    points: &[[f64; 2]],
    smooth: [Option<[f64; 2]>; 2],
    (tolerance, weight): (f64, f64),
    curve: &mut Vec<Cubic>,
) -> bool {
    let n = points.len();
    // Where nothing is prescribed the curve leaves as a parabola through the first three points does.
    let free = |i: usize| tangent(points, false, i);
    let (Some(u), Some(v)) = (smooth[0].or_else(|| free(0)), smooth[1].or_else(|| free(n - 1)))
    else {
        return false;
    };
    let cubic = fitted(&Samples::of(points, weight), [u, v.map(|x| -x)]);
    let (worst, off, back) = errors(&cubic, points, tolerance);
    if off.max(back) <= tolerance {
        curve.push(cubic);
        return true;
    }
    if n < 3 {
        return false;
    }
    // At the worst point, but never a sliver.
    let least = (n / 8).max(1);
    let at = if off >= 0.5 * back { worst } else { n / 2 }.clamp(least, n - 1 - least);
    let Some(middle) = tangent(points, false, at) else { return false };
    divide(&points[..=at], [smooth[0].or(Some(u)), Some(middle)], (tolerance, weight), curve)
        && divide(&points[at..], [Some(middle), smooth[1].or(Some(v))], (tolerance, weight), curve)
}

/// Direction of the parabola through a point and its neighbours; at an end through the two next ones.
fn tangent(points: &[[f64; 2]], is_closed: bool, at: usize) -> Option<[f64; 2]> {
    let n = points.len();
    if n < 3 {
        return direction(minus(points[n - 1], points[0]));
    }
    let (a, b, c, place) = if is_closed || (at > 0 && at + 1 < n) {
        (points[(at + n - 1) % n], points[at], points[(at + 1) % n], 0.0)
    } else if at == 0 {
        (points[0], points[1], points[2], -1.0)
    } else {
        (points[n - 3], points[n - 2], points[n - 1], 1.0)
    };
    let (d, e) = (direction(minus(b, a))?, direction(minus(c, b))?);
    let (h, k) = (distance(a, b), distance(b, c));
    // Slope at b, and its change towards the ends.
    let middle = [0, 1].map(|i| (d[i] * k + e[i] * h) / (h + k));
    let bend = minus(e, d).map(|x| 2.0 * x / (h + k));
    let step = if place < 0.0 { -h } else { place * k };
    direction(along(middle, step, bend))
}

/// The polyline that stands for the curve, and the part that each of its sides belongs to.
fn flatten(parts: &[Part], is_closed: bool, tolerance: f64) -> (Vec<[f64; 2]>, Vec<usize>) {
    let tolerance = CHORD_MM.min(if tolerance > 0.0 { tolerance } else { CHORD_MM });
    let (mut points, mut owners) = (Vec::new(), Vec::new());
    for (k, part) in parts.iter().enumerate() {
        for cubic in &part.curve {
            // A straight one has second differences of rounding only.
            let count = chords(cubic, tolerance);
            for i in 0..count {
                let t = f64::from(i) / f64::from(count);
                points.push(if i == 0 { cubic[0] } else { point(cubic, t) });
                owners.push(k);
            }
        }
    }
    if let (false, Some(last)) = (is_closed, parts.last().and_then(|part| part.curve.last())) {
        points.push(last[3]);
    }
    (points, owners)
}

/// Pairs of sides that cross; the closing side of an open polyline does not count.
fn crossings(points: &[[f64; 2]], is_closed: bool) -> Vec<[usize; 2]> {
    let corners: Vec<Point2<f64>> = points.iter().copied().map(Point2::from).collect();
    let pairs = overlap::crossings(&[&corners]);
    let pairs = pairs.into_iter().map(|pair| pair.map(|side| side.side as usize));
    pairs.filter(|pair| is_closed || pair.iter().all(|&s| s + 1 < points.len())).collect()
}
