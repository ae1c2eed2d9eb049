//! Darts: seams that end inside the surface.

use std::f64::consts::TAU;

use super::ticks::inwards;
use crate::pattern::flaps::turn_left;
use crate::pattern::piece::{Piece, length};
use crate::pattern::seam::{Partner, Seam};

/// Half the length of the lines of a cross.
const HALF_CROSS: f64 = 1.5;

/// A seam of a piece with itself whose two sides leave one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dart {
    /// Index of the outline.
    pub outline: usize,
    /// The point of the outline at the tip.
    pub tip: usize,
    /// Indices of the seams that end and begin at the tip: the legs.
    pub legs: [usize; 2],
    /// Angle between the legs, radians: what is cut out or folded away. Measured from tip to open end.
    pub opening: f64,
    /// Distance between the open ends, mm.
    pub width_mm: f64,
    /// The length of a leg in the plane, the mean of both, mm.
    pub length_mm: f64,
}

impl Dart {
    /// A cross at the tip, or short of it: towards the open end.
    pub(super) fn cross(&self, piece: &Piece, short_mm: f64) -> Vec<(bool, Vec<[f64; 2]>)> {
        let points = &piece.outlines[self.outline].points;
        let p = points[self.tip];
        let [x, y] = inwards(points, self.tip);
        // Never beyond the open end.
        let short = short_mm.clamp(0.0, 0.5 * self.length_mm);
        let centre = [p[0] - short * x, p[1] - short * y];
        let stroke = |[dx, dy]: [f64; 2]| {
            let end = |s: f64| [centre[0] + s * HALF_CROSS * dx, centre[1] + s * HALF_CROSS * dy];
            (false, vec![end(-1.0), end(1.0)])
        };
        vec![stroke([x, y]), stroke([-y, x])]
    }
}

/// The darts of a piece, by outline and tip. A slit that has tips at both ends is two darts.
pub fn darts(piece: &Piece) -> Vec<Dart> {
    let mut darts = Vec::new();
    for (a, first) in piece.seams.iter().enumerate() {
        let points = &piece.outlines[first.outline].points;
        let n = points.len();
        let tip = (first.first + first.sides) % n;
        let is_partner = |other: &Seam| {
            matches!(other.partner, Partner::Own { .. })
                && other.number == first.number
                && other.outline == first.outline
                && other.first % n == tip
        };
        if first.is_closed || !matches!(first.partner, Partner::Own { .. }) {
            continue;
        }
        let Some(b) = (0..piece.seams.len()).find(|&b| b != a && is_partner(&piece.seams[b]))
        else {
            continue;
        };
        let second = &piece.seams[b];
        let [from, to] = [first.first, second.first + second.sides].map(|i| points[i % n]);
        let away = |q: [f64; 2]| [q[0] - points[tip][0], q[1] - points[tip][1]];
        // A slit that has tips at both ends leaves nothing out.
        let is_whole = first.sides + second.sides == n;
        let opening = if is_whole { 0.0 } else { turn_left(away(from), away(to)) };
        darts.push(Dart {
            outline: first.outline,
            tip,
            legs: [a, b],
            // Rounding turns nothing into a whole turn.
            opening: if opening > TAU - 0.01 { 0.0 } else { opening },
            width_mm: length(&[from, to]),
            length_mm: 0.5 * (first.length_mm + second.length_mm),
        });
    }
    darts.sort_by_key(|dart| (dart.outline, dart.tip));
    darts
}
