//! Where an outline has corners, whatever small steps it is made of.

use crate::pattern::Piece;
use crate::pattern::piece::length;
use crate::pattern::plane::{Walk, distance, turning};

/// Turning that makes a corner, 30°: what pattern makers call a turn point.
pub const CORNER: f64 = std::f64::consts::FRAC_PI_6;

/// The distance over which turning is measured: 1 mm, and no more than 1/48 of the polyline. Larger, a round hole of a few
/// millimetres would have corners (a circle turns by 7.5° over a 48th); smaller, every step of a noisy outline were one.
pub(crate) fn reach(points: &[[f64; 2]], is_closed: bool) -> f64 {
    let closing = match points {
        [first, .., last] if is_closed => distance(*first, *last),
        _ => 0.0,
    };
    ((length(points) + closing) / 48.0).min(1.0)
}

/// Points where a polyline turns by more than [`CORNER`], directions taken over [`reach`]; of several within that distance the
/// one that turns most. The ends of an open polyline are none. **Costs** O(n k) for k points within reach.
pub fn turns(points: &[[f64; 2]], is_closed: bool) -> Vec<usize> {
    let far = reach(points, is_closed);
    let walk = Walk { points, is_closed };
    let n = points.len();
    let inner = |i: usize| is_closed || (i > 0 && i + 1 < n);
    let angle = |i: usize| walk.directions(i, far).map_or(0.0, |d| turning(d).abs());
    let angles: Vec<f64> = (0..n).map(|i| if inner(i) { angle(i) } else { 0.0 }).collect();
    let is_most = |i: usize| {
        // Neighbours within reach, before and after; the first of equals is taken.
        let beaten = |step: usize, is_before: bool| {
            let (mut at, mut gone) = (i, 0.0);
            for _ in 1..n {
                let next = (at + step) % n;
                let wraps = if is_before { at == 0 } else { at + 1 == n };
                gone += distance(points[at], points[next]);
                if gone > far || (wraps && !is_closed) {
                    break;
                }
                let is_first = if is_before { angles[next] >= angles[i] } else { false };
                if angles[next] > angles[i] + 1e-9 || (is_first && angles[next] > angles[i] - 1e-9)
                {
                    return true;
                }
                at = next;
            }
            false
        };
        n > 1 && !beaten(n - 1, true) && !beaten(1, false)
    };
    (0..n).filter(|&i| angles[i] > CORNER && is_most(i)).collect()
}

/// Points of an outline of a piece that must stay where they are: its turns, and the ends of its seams. In increasing order.
pub fn corners(piece: &Piece, outline: usize) -> Vec<usize> {
    let points = &piece.outlines[outline].points;
    let mut corners = turns(points, true);
    for seam in piece.seams.iter().filter(|seam| seam.outline == outline) {
        corners.extend([seam.first, (seam.first + seam.sides) % points.len()]);
    }
    corners.sort_unstable();
    corners.dedup();
    corners
}
