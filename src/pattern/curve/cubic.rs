//! One cubic Bézier curve.

use crate::pattern::plane::{along, distance, dot, minus, nearest, squared};

/// Start, two control points, end.
pub(super) type Cubic = [[f64; 2]; 4];

/// The point at a parameter 0 … 1; the ends to the last bit.
pub(super) fn point(c: &Cubic, t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    [0, 1].map(|a| (0..4).map(|i| weights[i] * c[i][a]).sum())
}

/// First and second derivative.
fn derivatives(c: &Cubic, t: f64) -> [[f64; 2]; 2] {
    let s = 1.0 - t;
    let d = [0, 1, 2].map(|i| minus(c[i + 1], c[i]).map(|x| 3.0 * x));
    let e = [0, 1].map(|i| minus(d[i + 1], d[i]).map(|x| 2.0 * x));
    let first = [0, 1].map(|a| s * s * d[0][a] + 2.0 * s * t * d[1][a] + t * t * d[2][a]);
    [first, [0, 1].map(|a| s * e[0][a] + t * e[1][a])]
}

/// Number of chords, equal in parameter, that are off the curve by no more than a tolerance: the second derivative is at most
/// 6 max|second difference|, and a chord over h is off by no more than h²/8 of it.
pub(super) fn chords(c: &Cubic, tolerance: f64) -> u32 {
    let second = |i: usize| {
        let [p, q, r] = [c[i], c[i + 1], c[i + 2]];
        (p[0] - 2.0 * q[0] + r[0]).hypot(p[1] - 2.0 * q[1] + r[1])
    };
    let most = second(0).max(second(1));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let count = (0.75 * most / tolerance).sqrt().ceil().clamp(1.0, 10_000.0) as u32;
    count
}

/// Length to about 1e-9 of itself for curves without cusps: Gauss quadrature of five points on eight parts.
pub(super) fn length(c: &Cubic) -> f64 {
    const NODES: [[f64; 2]; 3] = [
        [0.0, 0.568_888_888_888_888_9],
        [0.538_469_310_105_683_1, 0.478_628_670_499_366_47],
        [0.906_179_845_938_664, 0.236_926_885_056_189_08],
    ];
    let speed = |t: f64| {
        let [x, y] = derivatives(c, t)[0];
        x.hypot(y)
    };
    let mut sum = 0.0;
    for k in 0..8 {
        let (middle, half) = ((f64::from(k) + 0.5) / 8.0, 1.0 / 16.0);
        for [x, w] in NODES {
            let both = if x > 0.0 { speed(middle - half * x) } else { 0.0 };
            sum += w * half * (speed(middle + half * x) + both);
        }
    }
    sum
}

/// Points to be fitted: places with weights.
pub(super) struct Samples {
    pub places: Vec<[f64; 2]>,
    pub weights: Vec<f64>,
}

impl Samples {
    /// The points of a polyline, and the middles of its sides with weight 1.
    pub fn of(points: &[[f64; 2]], weight: f64) -> Self {
        let mut samples = Self { places: Vec::new(), weights: Vec::new() };
        for (i, &p) in points.iter().enumerate() {
            samples.places.push(p);
            samples.weights.push(weight);
            if let Some(&q) = points.get(i + 1) {
                samples.places.push(along(p, 0.5, minus(q, p)));
                samples.weights.push(1.0);
            }
        }
        samples
    }
}

/// The cubic from the first sample to the last with given directions at both ends (into the curve) that is nearest to the samples in
/// the mean.
pub(super) fn fitted(samples: &Samples, directions: [[f64; 2]; 2]) -> Cubic {
    let places = &samples.places;
    let (first, last) = (places[0], places[places.len() - 1]);
    let mut arcs = vec![0.0];
    for p in places.windows(2) {
        arcs.push(arcs[arcs.len() - 1] + distance(p[0], p[1]));
    }
    let total = arcs[arcs.len() - 1];
    let mut parameters: Vec<f64> = arcs.iter().map(|a| a / total).collect();
    let mut cubic = handles(samples, &parameters, directions, total);
    for _ in 0..4 {
        // One step of Newton for the nearest point of each sample.
        for (t, &p) in parameters.iter_mut().zip(places) {
            let off = minus(point(&cubic, *t), p);
            let [d, e] = derivatives(&cubic, *t);
            let slope = dot(d, d) + dot(off, e);
            if slope > 0.0 {
                *t = (*t - dot(off, d) / slope).clamp(0.0, 1.0);
            }
        }
        cubic = handles(samples, &parameters, directions, total);
    }
    cubic[0] = first;
    cubic[3] = last;
    cubic
}

/// Solves the two equations for the lengths of the handles.
fn handles(samples: &Samples, ts: &[f64], [u, v]: [[f64; 2]; 2], total: f64) -> Cubic {
    let places = &samples.places;
    let (p, q) = (places[0], places[places.len() - 1]);
    let (mut a, mut b, mut c, mut x, mut y) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for ((&t, &place), &w) in ts.iter().zip(places).zip(&samples.weights) {
        let s = 1.0 - t;
        let (b1, b2) = (3.0 * s * s * t, 3.0 * s * t * t);
        let start = s * s * s + b1;
        let rest = minus(place, [0, 1].map(|k| start * p[k] + (1.0 - start) * q[k]));
        a += w * b1 * b1;
        b += w * b1 * b2 * dot(u, v);
        c += w * b2 * b2;
        x += w * b1 * dot(rest, u);
        y += w * b2 * dot(rest, v);
    }
    let size = a * c - b * b;
    let (mut alpha, mut beta) = ((x * c - y * b) / size, (a * y - b * x) / size);
    let chord = distance(p, q);
    let is_sound = |h: f64| h > 1e-3 * chord && h < 2.0 * total;
    if !is_sound(alpha) || !is_sound(beta) {
        (alpha, beta) = (total / 3.0, total / 3.0);
    }
    [p, along(p, alpha, u), along(q, beta, v), q]
}

/// The worst distances between a cubic and the polyline that it stands for: the point of the polyline that is farthest off (its
/// index and distance), and the farthest that the curve is off (not looked for if the first is beyond the tolerance). Never smaller than they are, but for what lies between samples
/// a fiftieth of the tolerance off their chords.
pub(super) fn errors(c: &Cubic, points: &[[f64; 2]], tolerance: f64) -> (usize, f64, f64) {
    let parts = chords(c, 0.02 * tolerance).max(8);
    let curve: Vec<[f64; 2]> =
        (0..=parts).map(|k| point(c, f64::from(k) / f64::from(parts))).collect();
    let (arcs, other) = (shares(points), shares(&curve));
    let mut worst = (0, 0.0);
    for i in 1..points.len().saturating_sub(1) {
        let off = off(points[i], arcs[i], &curve, &other);
        if off > worst.1 {
            worst = (i, off);
        }
    }
    if worst.1 > tolerance {
        return (worst.0, worst.1, 0.0);
    }
    let back = curve.iter().zip(&other).map(|(&p, &share)| off(p, share, points, &arcs));
    (worst.0, worst.1, back.fold(0.0, f64::max))
}

/// How far along a polyline each point lies, from 0 to 1.
fn shares(points: &[[f64; 2]]) -> Vec<f64> {
    let mut arcs = vec![0.0];
    for p in points.windows(2) {
        arcs.push(arcs[arcs.len() - 1] + distance(p[0], p[1]));
    }
    let total = arcs[arcs.len() - 1];
    arcs.iter().map(|a| if total > 0.0 { a / total } else { 0.0 }).collect()
}

/// Distance to the stretch of a polyline about a share of its length: both run side by side, or the fit is a bad one.
fn off(p: [f64; 2], share: f64, points: &[[f64; 2]], shares: &[f64]) -> f64 {
    const STRETCH: f64 = 0.06;
    let from = shares.partition_point(|&s| s < share - STRETCH).saturating_sub(1);
    let to = (shares.partition_point(|&s| s <= share + STRETCH) + 1).min(points.len());
    let sides = points[from..to].windows(2);
    let least = sides.map(|s| squared(nearest(p, s[0], s[1]).0, p)).fold(f64::INFINITY, f64::min);
    least.sqrt()
}
