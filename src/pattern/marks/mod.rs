//! Marks on pieces that help to put them together: ends of seams, beginnings of closed seams, tips of darts, and points where three or more
//! seams meet.
//!
//! A **dart** is a seam whose two sides leave the same point of an outline: it ends inside the surface, at its tip. A **junction** is a
//! point of the surface where at least three seams end; it gets the same small letter on all pieces that have it. Closed seams have no
//! ends; a triangle marks the point where both sides begin.

mod darts;
mod junctions;
mod ticks;

pub use self::darts::{Dart, darts};
pub(super) use self::ticks::{seam_ends, tick};

use self::junctions::junctions;
use self::ticks::start;
use super::laid::LaidSurface;
use super::piece::{Pattern, Piece, piece_name};
use super::sheet::Layer;

/// Which marks are made, and how large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkParams {
    /// How far the mark of a dart's tip lies from the tip, towards the open end of the dart, mm: 0 where the dart is cut out, 3 to 5 for punches
    /// where it is folded, so that the seam hides the hole.
    pub drill_short_mm: f64,
    /// Darts that open wider than this are corners and have no mark at the tip, radians.
    pub widest_dart: f64,
}

impl Default for MarkParams {
    fn default() -> Self {
        Self { drill_short_mm: 0.0, widest_dart: 60f64.to_radians() }
    }
}

/// What a mark is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkKind {
    /// The end of a seam.
    End,
    /// The beginning of a closed seam.
    Start,
    /// The tip of a dart.
    Tip,
    /// Where three or more seams meet.
    Junction,
}

/// A mark on a piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// What it is for.
    pub kind: MarkKind,
    /// [`Layer::Internal`], or [`Layer::Drill`] for tips.
    pub layer: Layer,
    /// Outline and point that it belongs to.
    pub at: (usize, usize),
    /// Its lines; whether each is closed.
    pub lines: Vec<(bool, Vec<[f64; 2]>)>,
    /// What is written beside it: the middle, the height in mm, and the letters.
    pub text: Option<([f64; 2], f64, String)>,
}

/// The marks of each piece: ends, starts, tips, junctions, each in the order of the outlines.
///
/// **Takes** what the pattern was made of, for the points of the surface that its pieces share. **Gives** marks in the frame of the outlines. Ticks are
/// as they always were; a junction's letter stands as near to its corner as it fits. **Costs** O(n) for each mark.
pub fn marks(surface: &LaidSurface, pattern: &Pattern, params: &MarkParams) -> Vec<Vec<Mark>> {
    let junctions = junctions(surface, pattern);
    let of_piece = |(piece, junctions): (&Piece, Vec<(usize, usize, usize)>)| {
        let mut marks = Vec::new();
        let starts: Vec<(usize, usize)> =
            piece.seams.iter().filter(|s| s.is_closed).map(|s| (s.outline, s.first)).collect();
        let internal =
            |kind, at, lines, text| Mark { kind, layer: Layer::Internal, at, lines, text };
        for at in seam_ends(piece).into_iter().filter(|at| !starts.contains(at)) {
            let line = tick(&piece.outlines[at.0].points, at.1);
            marks.push(internal(MarkKind::End, at, vec![(false, line)], None));
        }
        for &at in &starts {
            let lines = vec![(true, start(&piece.outlines[at.0].points, at.1))];
            marks.push(internal(MarkKind::Start, at, lines, None));
        }
        for dart in darts(piece).iter().filter(|dart| dart.opening <= params.widest_dart) {
            marks.push(Mark {
                kind: MarkKind::Tip,
                layer: Layer::Drill,
                at: (dart.outline, dart.tip),
                lines: dart.cross(piece, params.drill_short_mm),
                text: None,
            });
        }
        for (outline, point, junction) in junctions {
            let letters = piece_name(junction).to_lowercase();
            let (diamond, text) = junctions::mark(piece, (outline, point), &letters);
            let lines = vec![(true, diamond)];
            marks.push(internal(MarkKind::Junction, (outline, point), lines, Some(text)));
        }
        marks
    };
    pattern.pieces.iter().zip(junctions).map(of_piece).collect()
}
