//! Where a point of a seam lies on its pieces.

use crate::pattern::Piece;
use crate::pattern::plane::{Walk, along, direction, minus, right};

/// The point of a piece's sew line at a distance along a seam, counted from the seam's own beginning on the surface, and the direction out
/// of the piece there.
///
/// The direction is that of the outline over 1 mm to both sides (less on short seams), not of one small side. **Takes** an index into
/// the piece's seams; distances beyond the ends give the ends, those of closed seams go around.
/// **Gives** none if there is no such seam or it has no length.
pub fn place(piece: &Piece, seam: usize, shared_arc_mm: f64) -> Option<([f64; 2], [f64; 2])> {
    let seam = piece.seams.get(seam)?;
    let long = seam.surface_length_mm;
    if !(long > 0.0) || !shared_arc_mm.is_finite() {
        return None;
    }
    let mut arc = seam.shared_arc(shared_arc_mm);
    arc = if seam.is_closed { arc.rem_euclid(long) } else { arc.clamp(0.0, long) };
    let after = seam.arcs_mm.partition_point(|&a| a <= arc).clamp(1, seam.sides);
    let (from, to) = (seam.arcs_mm[after - 1], seam.arcs_mm[after]);
    let t = if to > from { (arc - from) / (to - from) } else { 0.0 };
    let points = piece.seam_points(seam);
    let at = along(points[after - 1], t, minus(points[after], points[after - 1]));
    // The seam with the point itself in it, walked to both sides.
    let mut line = points;
    line.insert(after, at);
    let walk = Walk { points: &line, is_closed: false };
    let far = 1.0_f64.min(0.05 * seam.length_mm);
    let normal = right(direction(minus(walk.from(after, 1, far), walk.from(after, -1, far)))?);
    Some((at, normal))
}
