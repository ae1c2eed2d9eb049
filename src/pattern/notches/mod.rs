//! Balance notches: marks at the same places of both sides of a seam, so that it can only be sewn as it was meant.
//!
//! A seam has a length on the surface that both of its sides share; notches stand at distances along it, in groups of one, two or three
//! marks. On the flat pieces the sides may differ in length (the ease); the notches still lie on the same points
//! of the surface. Guaranteed, by a search and checked again by [`conflicts`]: read along either side, the groups of a seam differ
//! from the same groups read backwards, and from those of every other seam of similar length on the same pieces, wherever
//! there is room for such a choice; where there is none, the plan says so.

mod draw;
mod outward;
mod place;
mod plan;
mod sequence;

pub use draw::draw;
pub use outward::with_outward;
pub use place::place;
pub use plan::{NotchNotice, NotchPlan, SeamNotches, plan};
pub use sequence::{Conflict, Group, conflicts, is_unambiguous};

/// How a notch is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotchStyle {
    /// A cut from the cut line inward, square to it.
    Slit,
    /// A triangle: cut inward, or standing out where the allowance is below 8 mm.
    V,
    /// A slit with a bar at its end.
    T,
}

/// Where notches stand and what they look like. Lengths are for pieces whose longest seam has [`NotchParams::FULL_MM`] and more, and
/// are reduced for smaller ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotchParams {
    /// From one group to the next, along the surface: 60–100 for garments, 25–50 for plush.
    pub spacing_mm: f64,
    /// No group is closer to a corner, to the end of a seam, or to another group; on short seams a fifth of their length.
    pub clear_mm: f64,
    /// Between the marks of one group.
    pub pair_mm: f64,
    /// Longer seams have at least one notch.
    pub shortest_mm: f64,
    /// Their look.
    pub style: NotchStyle,
}

impl Default for NotchParams {
    fn default() -> Self {
        Self {
            spacing_mm: 80.0,
            clear_mm: 15.0,
            pair_mm: 6.0,
            shortest_mm: 40.0,
            style: NotchStyle::Slit,
        }
    }
}

impl NotchParams {
    /// Longest seam of a model whose notches are not reduced.
    pub const FULL_MM: f64 = 160.0;
    /// Notches are never reduced below this: marks 1.5 mm apart can still be told apart.
    pub(crate) const SMALLEST: f64 = 0.25;

    /// For soft toys: many small pieces.
    pub fn plush() -> Self {
        Self { spacing_mm: 40.0, style: NotchStyle::V, ..Self::default() }
    }

    /// All lengths in proportion to the longest seam of a small model; and the factor.
    fn reduced(&self, longest_mm: f64) -> (Self, f64) {
        let factor = (longest_mm / Self::FULL_MM).clamp(Self::SMALLEST, 1.0);
        let sound =
            |x: f64, default: f64| factor * if x > 0.0 && x.is_finite() { x } else { default };
        let default = Self::default();
        let reduced = Self {
            spacing_mm: sound(self.spacing_mm, default.spacing_mm),
            clear_mm: sound(self.clear_mm, default.clear_mm),
            pair_mm: sound(self.pair_mm, default.pair_mm),
            shortest_mm: sound(self.shortest_mm, default.shortest_mm),
            style: self.style,
        };
        (reduced, factor)
    }
}
