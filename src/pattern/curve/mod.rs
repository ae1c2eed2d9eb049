//! Smooth curves through outlines: cubic Béziers within a stated tolerance, in place of hundreds of short sides.
//!
//! A polyline is divided at its corners; each part becomes one or more cubics that join smoothly. Each cubic solves
//! min Σ wᵢ |B(tᵢ) − pᵢ|² over the lengths of its two handles, whose directions are given, with the points of the polyline and the middles of
//! its sides, weighted so that the curve gets the length of the polyline. Where the
//! tolerance is not met the part is divided at its worst point and fitted again.
//!
//! Guaranteed, because measured before a curve is given back: every point of the polyline lies within the tolerance of the curve and
//! the curve within the tolerance of the polyline; corners are met to the last bit; the curve is as long as the polyline to 0.05 mm
//! in all, so that partner seams of equal length stay so to 0.1 mm; it crosses itself no more often than the polyline does. Where
//! one of these fails the part stays a polyline. Not guaranteed: that curves of different outlines, or of outlines closer to
//! each other than twice the tolerance, keep apart.

mod corners;
mod cubic;
mod fit;

pub(crate) use corners::reach;
pub use corners::{CORNER, corners, turns};
pub use fit::{Fitted, fit};
