//! Nesting: how to lay pieces on cloth, paper or metal so that little is wasted.
//!
//! Given n polygons Pᵢ with holes, find motions gᵢ (turns that the grain allows, shifts, perhaps mirrored) so that
//! dist(gᵢPᵢ, gⱼPⱼ) ≥ gap for all i ≠ j on the same sheet and every gᵢPᵢ lies within its sheet less a margin; and the length
//! used of a roll, the number of sheets, or the side of a square is small. The problem is NP-hard already for squares.
//!
//! A first layout is made at once, each piece as low as it goes on a raster; then the stock is made a
//! little shorter again and again, and pieces that now overlap are moved, one at a time, to where they overlap least, with
//! weights that grow while two pieces do not come apart. That is the guided local search for strip packing (Umetani and others
//! 2009; Elkeran 2013; Gardeyn, Vanden Berghe, Wauters 2025), with signed distance fields of outlines as the measure of overlap:
//! inscribed disks and points of the rim of one piece against the field of the other.
//!
//! Guaranteed: every layout that is shown has passed [`check`], which knows nothing of how it was made; equal input and seed give
//! equal layouts. Not guaranteed: a shortest layout, nor a bound on what is lost.

mod check;
mod field;
mod flow;
mod part;
mod placed;
mod plane;
mod probe;
mod raster;
mod room;
mod separate;
mod shelf;
mod state;
mod uv;

use std::fmt;

pub use check::{CHECK_TOLERANCE_MM, NestFault, check};
pub use flow::NestFlow;
pub use state::NestState;
pub use uv::{UvPackParams, UvPacking, pack_uv};

use crate::methods::flow::SolveError;
use plane::Turn;

/// A piece to be laid: what is cut, with allowance, flaps and notches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NestShape {
    /// The outer outline counter-clockwise, then holes clockwise, mm; first points not repeated. None for a piece that is not there.
    pub outlines: Vec<Vec<[f64; 2]>>,
    /// Radians that the piece is turned by so that its grain runs along the stock (up the page). The turns of
    /// [`NestParams::rotations`] come on top.
    pub upright: f64,
    /// Whether it may be turned over: the material has no right side, or this is the second of a pair.
    pub may_mirror: bool,
}

/// What pieces are cut from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stock {
    /// A roll, across the page; its length runs up.
    Roll {
        /// Width, mm.
        width_mm: f64,
    },
    /// Sheets of one size.
    Sheet {
        /// Width, mm.
        width_mm: f64,
        /// Height, mm.
        height_mm: f64,
        /// How many there are. What does not fit on them is laid on further ones, and told.
        most: usize,
    },
    /// No limit: as small a square as may be.
    Free,
}

/// Turns that the material allows, counter-clockwise from [`NestShape::upright`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rotations {
    /// Cloth with a nap or a print: none.
    Nap,
    /// Woven cloth: 0° and 180°.
    Woven,
    /// The cross grain too: multiples of 90°.
    Cross,
    /// Multiples of so many degrees, from 1 to 360.
    Steps(f64),
    /// Any: felt, leather, paper, metal.
    Free,
}

/// What is asked of a layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NestParams {
    /// What pieces are cut from.
    pub stock: Stock,
    /// Least distance of two pieces, mm.
    pub gap_mm: f64,
    /// Least distance from the edge of the stock, mm.
    pub margin_mm: f64,
    /// Turns allowed.
    pub rotations: Rotations,
    /// How far a piece may be off an allowed turn, degrees.
    pub tolerance_deg: f64,
    /// For the random choices.
    pub seed: u64,
    /// Steps after which the flow ends.
    pub step_limit: usize,
    /// Cell of the raster of the first layouts, mm; 0 finds one. A finer one lays closer and takes longer.
    pub resolution_mm: f64,
}

impl Default for NestParams {
    fn default() -> Self {
        Self {
            stock: Stock::Free,
            gap_mm: 5.0,
            margin_mm: 10.0,
            rotations: Rotations::Woven,
            tolerance_deg: 0.0,
            seed: 0,
            step_limit: 400,
            resolution_mm: 0.0,
        }
    }
}

/// Where a piece lies: mirrored (x to −x) if so, then turned, then shifted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NestPose {
    /// Counter-clockwise, radians.
    pub angle: f64,
    /// From the lower left corner of the sheet, mm.
    pub shift: [f64; 2],
    /// Whether it is turned over.
    pub is_mirrored: bool,
    /// The sheet, counted from 0; a roll is one sheet.
    pub sheet: usize,
    /// Whether it fits on no sheet of the stock: it stands alone on this one, which is as large as it needs.
    pub is_too_large: bool,
}

/// What a person should know of a layout. Shapes are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NestNotice {
    /// The piece fits on the stock in no turn that is allowed.
    TooLarge {
        /// The piece.
        shape: usize,
    },
    /// The sheets that there are were full; the piece lies on a further one.
    NoRoom {
        /// The piece.
        shape: usize,
    },
    /// The piece has no outline of finite points, or none with area. It is not laid.
    NoOutline {
        /// The piece.
        shape: usize,
    },
}

impl fmt::Display for NestNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge { shape } => {
                write!(f, "piece {} is too large for the stock; it lies outside", shape + 1)
            }
            Self::NoRoom { shape } => {
                write!(f, "the sheets are full: piece {} needs a further one", shape + 1)
            }
            Self::NoOutline { shape } => {
                write!(f, "piece {} is not laid: it has no outline with area", shape + 1)
            }
        }
    }
}

impl NestPose {
    /// Where a point of the piece comes to lie.
    pub fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y] = Turn::new(self.angle, self.is_mirrored).apply(p);
        [x + self.shift[0], y + self.shift[1]]
    }
}

impl NestParams {
    /// **Fails** with the parameter that is out of its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let most = 1e9;
        SolveError::within("gap_mm", self.gap_mm, 0.0, most)?;
        SolveError::within("margin_mm", self.margin_mm, 0.0, most)?;
        SolveError::within("tolerance_deg", self.tolerance_deg, 0.0, 180.0)?;
        SolveError::within("resolution_mm", self.resolution_mm, 0.0, most)?;
        if let Rotations::Steps(degrees) = self.rotations {
            SolveError::within("rotation steps", degrees, 1.0, 360.0)?;
        }
        // Something must be left between the margins.
        let least = (2.0 * self.margin_mm + 1e-6) * (1.0 + 1e-9);
        match self.stock {
            Stock::Roll { width_mm } => SolveError::within("width_mm", width_mm, least, most),
            Stock::Sheet { width_mm, height_mm, .. } => {
                SolveError::within("width_mm", width_mm, least, most)?;
                SolveError::within("height_mm", height_mm, least, most)
            }
            Stock::Free => Ok(()),
        }
    }
}

impl Rotations {
    /// The turns, radians from upright; `None` where all are allowed.
    fn turns(self) -> Option<Vec<f64>> {
        let step = match self {
            Self::Nap => 360.0,
            Self::Woven => 180.0,
            Self::Cross => 90.0,
            Self::Steps(degrees) => degrees,
            Self::Free => return None,
        };
        let turns = (0..360).map(|k| f64::from(k) * step);
        Some(turns.take_while(|degrees| *degrees < 360.0 - 1e-9).map(f64::to_radians).collect())
    }

    /// Radians from an angle to the nearest turn that is allowed.
    fn off(self, angle: f64) -> f64 {
        let whole = std::f64::consts::TAU;
        let off = |turn: &f64| {
            let rest = (angle - turn).rem_euclid(whole);
            rest.min(whole - rest)
        };
        let turns = self.turns();
        turns.map_or(0.0, |turns| turns.iter().map(off).fold(f64::INFINITY, f64::min))
    }
}
