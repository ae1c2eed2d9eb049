//! Glue flaps for paper and card: trapezoids on one side of each seam.
//!
//! A seam is cut into nearly straight stretches of length L, so that curved seams get teeth. A stretch gets a flap of depth
//! d = min(depth, 0.4 L) with base angles α; its top is L − 2 d / tan α, and it ends in a point where that is below 1 mm. At either end
//! α is at most the interior angle of the partner there less 1°, so that the glued flap does not stick out, and two flaps at one vertex
//! share 360° less the interior angle less 2°. Then flaps are tested against what is there: made slimmer, lower, put on the partner, and
//! what still has no room is told.
//!
//! Guaranteed, decided by exact predicates: no flap meets an outline of its piece or another flap of it elsewhere than in the ends of its
//! base; no flap lies within its piece; each stretch has a flap on one side unless a notice or [`FlapSide::Both`] says otherwise. Not
//! guaranteed: that flaps of different pieces do not overlap on the sheet, or that no two flaps lie on each other under one face.

mod cut;
mod fit;
mod labels;
mod notice;
mod plan;
mod shape;
mod stretches;

pub use self::cut::cut_with_flaps;
pub use self::labels::{FlapLabel, flap_labels};
pub use self::notice::FlapNotice;
pub(super) use self::shape::turn_left;

use self::fit::Places;
use self::plan::plan;
use self::stretches::{Joint, joints};
use super::folds::Fold;
use super::laid::LaidSurface;
use super::piece::{Pattern, Piece};

/// Where flaps are, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlapParams {
    /// Depth where there is room, mm: 5 to 10.
    pub depth_mm: f64,
    /// Angle between flap and seam where there is room, radians: 45° to 60°.
    pub angle: f64,
    /// Which side of a seam has them.
    pub side: FlapSide,
    /// How far a seam may run beside the chord of a stretch, mm. Smaller: more and smaller teeth.
    pub tolerance_mm: f64,
    /// Stretches shorter than this have no flap, mm.
    pub least_length_mm: f64,
    /// Folds that turn by more end a stretch, and no flap is glued across them, radians. Paper follows weaker ones.
    pub fold_angle: f64,
}

impl Default for FlapParams {
    fn default() -> Self {
        Self {
            depth_mm: 7.0,
            angle: 50f64.to_radians(),
            side: FlapSide::Alternate,
            tolerance_mm: 0.3,
            least_length_mm: 2.0,
            fold_angle: 20f64.to_radians(),
        }
    }
}

/// The side of a seam that has the flap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlapSide {
    /// Seams that follow each other around a piece take turns, as far as that can be.
    Alternate,
    /// The side met first.
    First,
    /// The piece of smaller area.
    SmallerPiece,
    /// Teeth of one seam take turns; a seam with one flap is as in `Alternate`.
    Zigzag,
    /// Both: flaps that are glued to each other.
    Both,
}

/// A glue flap.
#[derive(Clone, Debug, PartialEq)]
pub struct Flap {
    /// Number of the seam.
    pub number: usize,
    /// Which of the stretches of the seam, counted from 1 along the side met first, and how many there are.
    pub stretch: (usize, usize),
    /// The part of an outline that it stands on.
    pub base: Base,
    /// What it is glued to; `None` where that piece is missing.
    pub partner: Option<Base>,
    /// From the first point of the base around the flap to its last: three or four places, mm, in the frame of the outlines.
    pub points: Vec<[f64; 2]>,
    /// Height over the base, mm.
    pub depth_mm: f64,
    /// By how much it is folded along its base, radians, as [`Fold::angle`].
    pub angle: f64,
}

/// A nearly straight stretch of a seam on one of its sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Base {
    /// Index of the piece.
    pub piece: usize,
    /// Index of the seam in it.
    pub seam: usize,
    /// Index of the outline.
    pub outline: usize,
    /// The first side of the outline.
    pub first: usize,
    /// Number of sides.
    pub sides: usize,
}

impl Base {
    /// Its points, ends included.
    pub fn points(&self, pattern: &Pattern) -> Vec<[f64; 2]> {
        self.points_in(&pattern.pieces[self.piece])
    }

    fn points_in(&self, piece: &Piece) -> Vec<[f64; 2]> {
        piece.outlines[self.outline].run(self.first, self.sides)
    }

    /// Indices of its first and last point in the outline.
    fn ends(&self, piece: &Piece) -> [usize; 2] {
        let n = piece.outlines[self.outline].points.len();
        [self.first % n, (self.first + self.sides) % n]
    }

    /// First and last point.
    fn chord(&self, piece: &Piece) -> [[f64; 2]; 2] {
        self.ends(piece).map(|i| piece.outlines[self.outline].points[i])
    }
}

/// Flaps for all seams of a pattern: a list for each piece, in the order of its seams, and what has none.
///
/// **Takes** what the pattern was made of and the folds of its pieces ([`super::folds`]), in the frame of the outlines. **Costs** O(k n) for k flaps and
/// n sides of the outlines.
pub fn flaps(
    surface: &LaidSurface,
    pattern: &Pattern,
    folds: &[Vec<Fold>],
    params: &FlapParams,
) -> (Vec<Vec<Flap>>, Vec<FlapNotice>) {
    let joints = joints(surface, pattern, folds, params);
    let sides = plan(pattern, &joints, params);
    let mut places = Places::new(pattern, folds, &joints, &sides, params);
    let mut notices = Vec::new();
    for (joint, sides) in joints.iter().zip(&sides) {
        let mut short = (0, 0.0);
        let is_long = |k: usize| joint.stretches[k].length_mm >= params.least_length_mm;
        let wanted: Vec<usize> = (0..joint.stretches.len()).filter(|&k| is_long(k)).collect();
        for stretch in joint.stretches.iter().filter(|s| !(s.length_mm >= params.least_length_mm)) {
            short = (short.0 + 1, short.1 + stretch.length_mm);
        }
        if short.0 > 0 {
            let (count, length_mm) = short;
            notices.push(FlapNotice::TooShort { number: joint.number, count, length_mm });
        }
        if params.side == FlapSide::Both {
            for &k in &wanted {
                for side in 0..2 {
                    if joint.stretches[k].bases[side].is_some() && !places.add(joint, k, side) {
                        notices.push(no_room(joint, k));
                    }
                }
            }
            continue;
        }
        if places.add_all(joint, &wanted, |k| sides[k])
            || places.add_all(joint, &wanted, |k| 1 - sides[k])
        {
            continue;
        }
        let mut moved = 0;
        for &k in &wanted {
            if places.add(joint, k, sides[k]) {
                continue;
            }
            if places.add(joint, k, 1 - sides[k]) {
                moved += 1;
            } else {
                notices.push(no_room(joint, k));
            }
        }
        if moved > 0 {
            notices.push(FlapNotice::Moved { number: joint.number, count: moved });
        }
    }
    (places.into_flaps(), notices)
}

fn no_room(joint: &Joint, stretch: usize) -> FlapNotice {
    let Joint { number, patches, .. } = *joint;
    FlapNotice::NoRoom { number, patches, length_mm: joint.stretches[stretch].length_mm }
}
