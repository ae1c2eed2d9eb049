//! Notches that stand out of the cut line.

use super::draw::marks;
use super::{NotchParams, NotchPlan};
use crate::pattern::Piece;
use crate::pattern::allowance::{CutLines, union};

/// The cut lines with the notches that stand out of them: those of style V where the allowance is below 8 mm. The same cut lines if there
/// are none. A triangle that would run into another part of the piece is left to [`super::draw`].
///
/// **Takes** the cut lines that [`super::draw`] takes too. **Costs** O(n log n) and O(n) for each mark.
pub fn with_outward(
    piece: &Piece,
    plan: &NotchPlan,
    cut: &CutLines,
    params: &NotchParams,
) -> CutLines {
    let factor = plan.factor.clamp(NotchParams::SMALLEST, 1.0);
    let marks = marks(piece, plan, cut);
    let marks = marks.iter().filter(|mark| mark.is_outward(params.style));
    let added: Vec<[[f64; 2]; 4]> =
        marks.filter_map(|mark| mark.outward(piece, cut, factor)).collect();
    if added.is_empty() {
        return cut.clone();
    }
    let contours =
        cut.outlines.iter().map(Vec::as_slice).chain(added.iter().map(<[_; 4]>::as_slice));
    let kept = cut.outlines.iter().flatten().copied();
    match union(contours, kept).into_iter().next() {
        Some(outlines) => CutLines { outlines, ..cut.clone() },
        None => cut.clone(),
    }
}
