//! First pieces for quasi-developable patches [LPFB]: regions of nearly one normal, with borders along creases.
//!
//! [`VsaFlow`] parts a surface into charts that are as flat as a tolerance asks, [`tighten`] moves the border of two charts by a least cut, and
//! [`smoothed`] takes the zigzag out of all borders on a copy of the surface. What charts are worth in the plane is the business of
//! [`crate::flatten::merging`], which merges them.
//!
//! Guaranteed: every face has a chart, and every chart hangs together, at any moment. Not guaranteed: that charts are disks.

mod smooth;
mod tighten;
mod vsa;

pub use smooth::{SmoothParams, smoothed};
pub use tighten::{TightenParams, tighten};
pub use vsa::{VsaCheckpoint, VsaFlow, VsaParams, VsaPhase, VsaState};
