//! What a person should know of cut lines.

use std::fmt;

use crate::pattern::piece_name;

/// What is not as it was asked for. Patches are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum CutNotice {
    /// An allowance is negative, not a number or absurd; it counts as 0.
    BadWidth {
        /// The patch.
        patch: usize,
        /// The first such side: its outline,
        outline: usize,
        /// and its number there.
        side: usize,
    },
    /// The allowances fill a hole: it is not cut.
    HoleClosed {
        /// The patch.
        patch: usize,
        /// The outline.
        outline: usize,
        /// Its widest allowance.
        allowance_mm: f64,
    },
    /// Sides face each other so closely that their allowances overlap: the gap between them is filled.
    Crowded {
        /// The patch.
        patch: usize,
        /// Where the gap is narrowest.
        at: [f64; 2],
        /// How wide it is there.
        gap_mm: f64,
        /// The allowance there.
        allowance_mm: f64,
        /// Length of sew line without an allowance of its own.
        length_mm: f64,
    },
    /// The cut line comes closer to the sew line than the allowance.
    TooClose {
        /// The patch.
        patch: usize,
        /// Where it is worst.
        at: [f64; 2],
        /// The distance there.
        distance_mm: f64,
        /// What was asked for.
        allowance_mm: f64,
    },
    /// The cut line enters the piece.
    EntersPiece {
        /// The patch.
        patch: usize,
        /// Where first.
        at: [f64; 2],
    },
    /// The cut line crosses itself.
    CrossesItself {
        /// The patch.
        patch: usize,
        /// Where first.
        at: [f64; 2],
    },
    /// The piece with its allowance is not one part; the largest is drawn.
    NotOnePiece {
        /// The patch.
        patch: usize,
        /// How many parts.
        parts: usize,
    },
}

impl CutNotice {
    /// The patch that it is about.
    pub fn patch(&self) -> usize {
        match *self {
            Self::BadWidth { patch, .. }
            | Self::HoleClosed { patch, .. }
            | Self::Crowded { patch, .. }
            | Self::TooClose { patch, .. }
            | Self::EntersPiece { patch, .. }
            | Self::CrossesItself { patch, .. }
            | Self::NotOnePiece { patch, .. } => patch,
        }
    }
}

impl fmt::Display for CutNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = piece_name(self.patch());
        match *self {
            Self::BadWidth { outline, side, .. } => {
                write!(
                    f,
                    "piece {name}: an allowance is no sensible width (outline {outline}, side {side}); "
                )?;
                write!(f, "nothing is added there")
            }
            Self::HoleClosed { outline, allowance_mm, .. } => {
                write!(
                    f,
                    "allowance larger than the piece can hold: {allowance_mm:.1} mm close hole {outline} "
                )?;
                write!(f, "of piece {name}, which is not cut")
            }
            Self::Crowded { at: [x, y], gap_mm, allowance_mm, length_mm, .. } => {
                write!(
                    f,
                    "allowance larger than the piece can hold: in piece {name}, about {x:.1}, {y:.1} mm, "
                )?;
                write!(
                    f,
                    "sides face each other at {gap_mm:.1} mm, with {allowance_mm:.1} mm of allowance each; "
                )?;
                write!(
                    f,
                    "the gap is filled, and {length_mm:.0} mm of seam have no edge of their own"
                )
            }
            Self::TooClose { at: [x, y], distance_mm, allowance_mm, .. } => {
                write!(
                    f,
                    "piece {name}: the allowance is {distance_mm:.2} mm instead of {allowance_mm:.1} mm "
                )?;
                write!(f, "at {x:.1}, {y:.1} mm")
            }
            Self::EntersPiece { at: [x, y], .. } => {
                write!(f, "piece {name}: the cut line enters the piece at {x:.1}, {y:.1} mm")
            }
            Self::CrossesItself { at: [x, y], .. } => {
                write!(f, "piece {name}: the cut line crosses itself at {x:.1}, {y:.1} mm")
            }
            Self::NotOnePiece { parts, .. } => {
                write!(
                    f,
                    "piece {name} with its allowance is {parts} parts, not one; the largest is drawn"
                )
            }
        }
    }
}
