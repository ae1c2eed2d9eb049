//! Which side of each stretch gets the flap, before anything is tested.

use super::stretches::Joint;
use super::{Base, FlapParams, FlapSide};
use crate::pattern::piece::Pattern;

/// For each seam and each of its stretches the side that gets the flap: 0 for the side met first, 1 for the other.
pub(super) fn plan(pattern: &Pattern, joints: &[Joint], params: &FlapParams) -> Vec<Vec<usize>> {
    // Which seams of each piece have flaps so far.
    let mut has_flaps: Vec<Vec<bool>> =
        pattern.pieces.iter().map(|piece| vec![false; piece.seams.len()]).collect();
    let mut sides = Vec::new();
    for joint in joints {
        let bases = joint.stretches.first().map_or([None; 2], |stretch| stretch.bases);
        let area = |side: usize| {
            bases[side].map_or(f64::INFINITY, |base: Base| pattern.pieces[base.piece].area_mm2)
        };
        // How many neighbours around the piece have flaps, then how many of all its seams.
        let load = |side: usize| match bases[side] {
            None => (usize::MAX, usize::MAX),
            Some(base) => {
                let taken = &has_flaps[base.piece];
                let near = neighbours(pattern, base).filter(|&s| taken[s]).count();
                (near, taken.iter().filter(|&&is| is).count())
            }
        };
        let side = match params.side {
            FlapSide::First | FlapSide::Both => usize::from(bases[0].is_none()),
            FlapSide::SmallerPiece => usize::from(area(1) < area(0)),
            FlapSide::Alternate | FlapSide::Zigzag => usize::from(load(1) < load(0)),
        };
        let is_zigzag = params.side == FlapSide::Zigzag && bases.iter().all(Option::is_some);
        for (k, base) in bases.iter().enumerate() {
            let is_used = k == side || params.side == FlapSide::Both;
            let is_used = is_used || (is_zigzag && joint.stretches.len() > 1);
            if let Some(base) = base.filter(|_| is_used) {
                has_flaps[base.piece][base.seam] = true;
            }
        }
        let take_turns = |k: usize| if is_zigzag && k % 2 == 1 { 1 - side } else { side };
        sides.push((0..joint.stretches.len()).map(take_turns).collect());
    }
    sides
}

/// The seams of the piece that begin where another one ends, and the other way round.
fn neighbours(pattern: &Pattern, base: Base) -> impl Iterator<Item = usize> {
    let piece = &pattern.pieces[base.piece];
    let seam = &piece.seams[base.seam];
    let n = piece.outlines[seam.outline].points.len();
    let [start, end] = [seam.first % n, (seam.first + seam.sides) % n];
    piece.seams.iter().enumerate().filter_map(move |(s, other)| {
        let touches = other.first % n == end || (other.first + other.sides) % n == start;
        (s != base.seam && other.outline == seam.outline && touches).then_some(s)
    })
}
