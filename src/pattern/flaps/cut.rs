//! Outlines with flaps: what is cut.

use super::Flap;
use crate::pattern::piece::Piece;

/// The outlines of a piece with its flaps, in the order of [`Piece::outlines`]: between the ends of its base the outline goes around the flap.
///
/// Every other point stays what it was, bit for bit. **Takes** flaps of this piece, whose bases do not overlap, in its frame.
pub fn cut_with_flaps(piece: &Piece, flaps: &[Flap]) -> Vec<Vec<[f64; 2]>> {
    let with_flaps = |(index, outline): (usize, &crate::pattern::Outline)| {
        let n = outline.points.len();
        // The flap that begins at each point, and the points within bases.
        let mut begins: Vec<Option<&Flap>> = vec![None; n];
        let mut is_inner = vec![false; n];
        for flap in flaps.iter().filter(|flap| flap.base.outline == index) {
            let base = flap.base;
            begins[base.first % n] = Some(flap);
            for i in base.first + 1..base.first + base.sides {
                is_inner[i % n] = true;
            }
        }
        let mut points = Vec::with_capacity(n);
        for i in (0..n).filter(|&i| !is_inner[i]) {
            points.push(outline.points[i]);
            if let Some(flap) = begins[i] {
                points.extend(&flap.points[1..flap.points.len() - 1]);
            }
        }
        points
    };
    piece.outlines.iter().enumerate().map(with_flaps).collect()
}
