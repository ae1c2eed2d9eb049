//! Short lines at the ends of seams, and triangles where closed ones begin.

use crate::pattern::labels::unit;
use crate::pattern::piece::{Piece, length};

/// Length of the ticks where seams end.
const TICK: f64 = 2.0;

/// Outline and point of every end of a seam, and the beginnings of closed seams.
pub(in super::super) fn seam_ends(piece: &Piece) -> Vec<(usize, usize)> {
    let mut ends = Vec::new();
    for seam in &piece.seams {
        let n = piece.outlines[seam.outline].points.len();
        ends.push((seam.outline, seam.first));
        ends.push((seam.outline, (seam.first + seam.sides) % n));
    }
    ends.sort_unstable();
    ends.dedup();
    ends
}

/// The direction into the piece that halves the angle of an outline at a point.
pub(super) fn inwards(points: &[[f64; 2]], at: usize) -> [f64; 2] {
    let n = points.len();
    let p = points[at];
    // Directions over a distance, because an outline may have steps far smaller than what is drawn.
    let far = |step: usize| {
        let mut others = (1..n).map(|k| points[(at + k * step) % n]);
        let is_far = |q: &[f64; 2]| length(&[p, *q]) > 0.5 * TICK;
        others.clone().find(is_far).or_else(|| others.next_back()).unwrap_or(p)
    };
    let (into, out) = (unit(far(n - 1), p), unit(p, far(1)));
    // Sum of the left normals; where the outline turns back on itself (tip of a slit) straight on.
    let sum = [-(into[1] + out[1]), into[0] + out[0]];
    let size = sum[0].hypot(sum[1]);
    if size > 1e-6 { sum.map(|s| s / size) } else { into }
}

/// A short line from a point of an outline into the piece, halving the angle there.
pub(in super::super) fn tick(points: &[[f64; 2]], at: usize) -> Vec<[f64; 2]> {
    let p = points[at];
    let [x, y] = inwards(points, at);
    vec![p, [p[0] + TICK * x, p[1] + TICK * y]]
}

/// A triangle with its tip on a point of an outline and its base inside.
pub(super) fn start(points: &[[f64; 2]], at: usize) -> Vec<[f64; 2]> {
    let p = points[at];
    let [x, y] = inwards(points, at);
    let base = |side: f64| {
        let (up, aside) = (1.5 * TICK, side * 0.5 * TICK);
        [p[0] + up * x - aside * y, p[1] + up * y + aside * x]
    };
    vec![p, base(-1.0), base(1.0)]
}
