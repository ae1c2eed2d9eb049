//! Nearly flat charts: the first three stages of quasi-developable segmentation \[LPFB\].
//!
//! Wanted is a partition of the faces into few connected charts each of which deviates from a plane by little, with seams that run
//! well. [`VsaFlow`] grows charts about planes until each one's error is within a tolerance; [`RefineFlow`] moves the seam between two charts
//! to where a cut is cheapest; [`DenoiseFlow`] takes noise out of the seams' vertices. Merging the charts into patches that flatten is
//! a matter of the floor above. [`seam_curves`] says how charts lie beside each other.
//!
//! Guaranteed: at any moment every face has a chart, charts are connected and numbered from 0 without gaps; the same input gives the same
//! charts. Not guaranteed: that charts are disks, or the fewest of them.

mod curves;
mod denoise;
mod refine;
mod vsa;

pub use curves::{SeamCurve, SeamMeasure, connected_charts, parted_charts, seam_curves};
pub use denoise::{DenoiseFlow, DenoiseParams, DenoiseState, chart_normals};
pub use refine::{RefineCheckpoint, RefineFlow, RefineParams, RefineState};
pub use vsa::{VsaChart, VsaCheckpoint, VsaFlow, VsaParams, VsaPhase, VsaState, start_faces};

/// An index as a `u32`: meshes number fewer elements than that.
#[expect(clippy::cast_possible_truncation, reason = "Mesh::new refuses larger meshes")]
fn small(index: usize) -> u32 {
    index as u32
}
