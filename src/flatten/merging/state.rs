//! What merging shows of itself.

use crate::mesh::EdgeId;

/// What a flow is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MergePhase {
    /// Merges patches.
    #[default]
    Merging,
    /// Dissolves single patches and gives their charts to others.
    Improving,
    /// Removes cuts inside patches that are not needed.
    Zipping,
    /// Flattens all patches anew.
    Checking,
    /// Nothing is left to do.
    Done,
}

/// One patch and what its map is worth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchInfo {
    /// Number of faces.
    pub faces: usize,
    /// Area on the surface, as a fraction of it all.
    pub area: f64,
    /// A_tot.
    pub area_total: f64,
    /// A_abs.
    pub area_absolute: f64,
    /// Raw L² stretch.
    pub l2_stretch: f64,
    /// L² stretch times √(Σ A′ / Σ A).
    pub l2_stretch_normalized: f64,
    /// Π_θ, radians.
    pub angle_error: f64,
    /// Largest distance that the boundary is open by, over its length.
    pub closure_error: f64,
    /// Loops of its boundary.
    pub loops: usize,
    /// Length of cuts inside.
    pub dart_length: f64,
    /// Charts that it is made of.
    pub charts: usize,
    /// Whether limits were waived because the user wanted its charts together.
    pub is_forced: bool,
    /// Whether it has a map without flips, crossings and overlaps. False only for charts that cannot be split any further.
    pub is_flat: bool,
}

/// A segmentation that is valid at any moment: every patch has a map within the limits, unless its [`PatchInfo`] says otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MergeState {
    /// What the flow is at.
    pub phase: MergePhase,
    /// Chart of every face: the charts given, by connected parts, split where they failed.
    pub face_charts: Vec<u32>,
    /// Patch of every face, numbered by first face.
    pub face_patches: Vec<u32>,
    /// Edges that are cut, in increasing order; those with the same patch on both sides are darts.
    pub cut_edges: Vec<EdgeId>,
    /// All patches.
    pub patches: Vec<PatchInfo>,
    /// Length of all cut edges, darts included.
    pub seam_length: f64,
    /// Length of the cut edges inside patches.
    pub dart_length: f64,
    /// Charts that were split because they failed.
    pub splits: usize,
    /// Edges that were to stay cut but end inside a chart that does not lie flat with them open.
    pub released: usize,
    /// Merges accepted.
    pub merges: usize,
    /// Trials made.
    pub trials: usize,
    /// Pairs that the user wanted together and that have no map without flips and crossings.
    pub refused: Vec<[u32; 2]>,
}
