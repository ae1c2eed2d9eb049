//! What a person should know of the flaps.

use std::fmt;

use crate::pattern::piece::piece_name;

/// Why a seam has no flap, or has flaps on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlapNotice {
    /// A stretch has no flap, because there is no room on either side.
    NoRoom {
        /// Number of the seam.
        number: usize,
        /// The patches that it joins.
        patches: [usize; 2],
        /// Length of the stretch, mm.
        length_mm: f64,
    },
    /// Some stretches have their flap on the other side than the rest of their seam.
    Moved {
        /// Number of the seam.
        number: usize,
        /// How many stretches.
        count: usize,
    },
    /// Some stretches are too short for a flap.
    TooShort {
        /// Number of the seam.
        number: usize,
        /// How many stretches.
        count: usize,
        /// Their length in all, mm.
        length_mm: f64,
    },
}

impl fmt::Display for FlapNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = |count: usize| if count == 1 { "" } else { "es" };
        match *self {
            Self::NoRoom { number, patches: [a, b], length_mm } => {
                let [a, b] = [a, b].map(piece_name);
                write!(
                    f,
                    "seam {number} between {a} and {b}: no room for a flap along {length_mm:.1} mm, use tape there"
                )
            }
            Self::Moved { number, count } => {
                write!(
                    f,
                    "seam {number}: {count} stretch{} with the flap on the other side",
                    plural(count)
                )
            }
            Self::TooShort { number, count, length_mm } => {
                write!(
                    f,
                    "seam {number}: {count} stretch{} without flap, {length_mm:.1} mm in all, too short",
                    plural(count)
                )
            }
        }
    }
}
