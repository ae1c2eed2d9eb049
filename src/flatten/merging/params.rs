//! Options of merging, and what the user asks for beside them.

use crate::mesh::{EdgeId, VertexId};
use crate::methods::flow::SolveError;

/// In which order patches are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MergeStrategy {
    /// A single pass over all curves, those between the largest patches first, each removed alone. The paper's.
    Paper,
    /// The best of all merges that pass, again and again; curves one by one and all of a pair at once, tips zipped, darts where they help.
    #[default]
    BestFirst,
}

/// Which change of area decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AreaMeasure {
    /// |Σ (A′ − A)| / Σ A: the paper's. What grows here and shrinks there cancels.
    Total,
    /// Σ |A′ − A| / Σ A.
    #[default]
    Absolute,
}

/// Options of a [`super::MergeFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergeParams {
    /// In which order.
    pub strategy: MergeStrategy,
    /// Which change of area decides.
    pub measure: AreaMeasure,
    /// Largest change of area of a patch.
    pub area_limit: f64,
    /// Largest raw L² stretch of a patch.
    pub l2_limit: f64,
    /// Darts that one merge may cut where the change of area is too large; best first only.
    pub darts: usize,
    /// Largest patch, as a fraction of the surface's area.
    pub max_patch_area: f64,
    /// Steps towards true lengths inside, after the harmonic map. 0 for the paper's interior.
    pub rigid_steps: usize,
    /// Charts to begin with are split until their change of area is at most this.
    pub split_limit: f64,
    /// Rounds of improvements once nothing more can be merged: each dissolves every patch of up to a dozen charts once, gives its charts to others, and keeps
    /// what has fewer patches or less seam.
    pub improvements: usize,
    /// Trials that one step makes at most, some more where a pair of patches shares many curves.
    pub trials_per_step: usize,
}

impl Default for MergeParams {
    fn default() -> Self {
        Self {
            strategy: MergeStrategy::default(),
            measure: AreaMeasure::default(),
            area_limit: 0.10,
            l2_limit: 2.0,
            darts: 2,
            max_patch_area: 1.0,
            rigid_steps: 3,
            split_limit: 0.05,
            improvements: 1,
            trials_per_step: 32,
        }
    }
}

impl MergeParams {
    /// Checks all ranges.
    pub fn validate(&self) -> Result<(), SolveError> {
        SolveError::within("area limit", self.area_limit, 0.0, 1.0)?;
        SolveError::within("stretch limit", self.l2_limit, 1.0, 100.0)?;
        SolveError::within("number of darts", self.darts as f64, 0.0, 8.0)?;
        SolveError::within("largest patch", self.max_patch_area, 0.0, 1.0)?;
        SolveError::within("rigid steps", self.rigid_steps as f64, 0.0, 100.0)?;
        SolveError::within("split limit", self.split_limit, 0.0, 1.0)?;
        SolveError::within("rounds of improvements", self.improvements as f64, 0.0, 100.0)?;
        SolveError::within("trials in a step", self.trials_per_step as f64, 1.0, 1e6)
    }

    /// Whether everything that passes `other` passes these as well, and nothing else changed.
    pub(super) fn loosens(&self, other: &Self) -> bool {
        let same = Self {
            area_limit: other.area_limit,
            l2_limit: other.l2_limit,
            darts: other.darts,
            max_patch_area: other.max_patch_area,
            improvements: other.improvements,
            trials_per_step: other.trials_per_step,
            ..*self
        };
        same == *other
            && self.area_limit >= other.area_limit
            && self.l2_limit >= other.l2_limit
            && self.darts >= other.darts
            && self.improvements >= other.improvements
            && self.max_patch_area >= other.max_patch_area
    }
}

/// What the user asks for. Charts are named by the labels that the flow was given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MergeWishes {
    /// Pairs of labels that never come into one patch.
    pub apart: Vec<[u32; 2]>,
    /// Pairs of labels that are merged first whatever the limits say, as long as there is a map without flips and crossings.
    pub together: Vec<[u32; 2]>,
    /// Edges that stay cut, also where they part a chart. Those that end inside a chart that does not lie flat with them open are given up
    /// ([`MergeState::released`](super::MergeState::released)).
    pub kept_edges: Vec<EdgeId>,
    /// What a seam along each edge costs beyond its length, a factor ≥ 0 for each; empty for 1. Dear seams are removed first.
    pub prices: Vec<f64>,
    /// Where a symmetry of order two maps each vertex. Patches are then merged in both images or in neither.
    pub symmetry: Option<Vec<VertexId>>,
}
