//! Error-controlled variational shape approximation: as few regions of nearly one normal as a tolerance allows.
//!
//! A region i with faces T of areas a and unit normals n has the proxy N = S/|S|, S = Σ a n, and the error E = Σ a |n − N|² = 2 (Σ a − |S|).

mod flood;
mod regions;

use std::sync::Arc;

use flood::Flood;
use regions::Regions;

use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Regions that one step merges at most, where a higher tolerance asks for fewer.
const MERGES: usize = 8;

/// Options of a [`VsaFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VsaParams {
    /// Largest error of a region, as a fraction of the surface's area. The paper gives none; its first charts need .004 to .007. Smaller: more charts, whose
    /// borders merging has more choice among, and longer merging. Larger: charts that do not flatten and have to be split.
    pub tolerance: f64,
    /// Regions are not made beyond this number, whatever their errors.
    pub max_charts: usize,
    /// Rounds of flooding and fitting about each new region.
    pub rounds: usize,
    /// The same for all regions in the end.
    pub final_rounds: usize,
    /// New regions between two looks for a pair that is better merged; 0 for never.
    pub teleport_every: usize,
}

impl Default for VsaParams {
    fn default() -> Self {
        Self { tolerance: 0.005, max_charts: 5000, rounds: 3, final_rounds: 20, teleport_every: 10 }
    }
}

impl VsaParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        // An error of 4 is the most that there can be: opposite normals everywhere.
        SolveError::within("flatness tolerance", self.tolerance, 1e-6, 4.0)?;
        SolveError::within("number of charts", self.max_charts as f64, 1.0, 1e6)?;
        SolveError::within("rounds", self.rounds as f64, 1.0, 100.0)?;
        SolveError::within("final rounds", self.final_rounds as f64, 0.0, 1000.0)
    }
}

/// What a flow is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VsaPhase {
    /// New regions where errors are largest.
    #[default]
    Growing,
    /// Regions are merged: the tolerance was raised.
    Merging,
    /// All regions are flooded and fitted.
    Settling,
    /// Nothing is left to do.
    Done,
}

/// Charts: every face has one, each hangs together.
#[derive(Clone, Debug, PartialEq)]
pub struct VsaState {
    /// Chart of every face.
    pub face_charts: Vec<u32>,
    /// Number of charts.
    pub count: usize,
    /// Largest error of a chart, as a fraction of the area.
    pub worst: f64,
    /// Sum of all errors, as a fraction of the area.
    pub total: f64,
    /// What comes next.
    pub phase: VsaPhase,
}

/// Regions of nearly one normal, one bounded step at a time.
///
/// **Minimises** Σ E, with as many regions as it takes for max E ≤ tolerance · area. **Step** one new region, with `rounds` rounds in its neighbourhood;
/// in the end one round of all regions. The sum of errors may rise from step to step: flooding does not minimise it exactly. **Ends** `Converged` when
/// regions stay as they are or `final_rounds` are done; `StepLimit` if there are `max_charts` regions.
/// **Costs** O(n log n) for each round of all regions, and in the neighbourhood of a new region as much as there are faces in it.
/// **From** [LPFB] §4.1, after Cohen-Steiner, Alliez, Desbrun 2004. **Differs**: rounds about a new region leave regions that do not touch it alone, which the
/// rounds at the end make up for.
pub struct VsaFlow {
    mesh: Arc<Mesh>,
    params: VsaParams,
    flood: Flood,
    progress: Progress,
}

/// Where a [`VsaFlow`] can go back to.
#[derive(Clone)]
pub struct VsaCheckpoint(Progress);

#[derive(Clone)]
struct Progress {
    regions: Regions,
    state: VsaState,
    inserted: usize,
    settled: usize,
    steps: usize,
    status: Status,
}

impl VsaFlow {
    /// Begins with one region for each connected part.
    ///
    /// **Takes** a surface of any scale. **Fails** on options out of range.
    pub fn new(
        mesh: Arc<Mesh>,
        geometry: &Geometry,
        params: VsaParams,
    ) -> Result<Self, SolveError> {
        let labels = vec![0; mesh.face_count()];
        Self::from_labels(mesh, geometry, &labels, params)
    }

    /// Begins with given regions: faces of one label that hang together are one.
    ///
    /// **Takes** a label for each face.
    pub fn from_labels(
        mesh: Arc<Mesh>,
        geometry: &Geometry,
        labels: &[u32],
        params: VsaParams,
    ) -> Result<Self, SolveError> {
        params.validate()?;
        let flood = Flood::new(&mesh, geometry);
        let regions = Regions::of_labels(&flood, labels);
        let state = VsaState {
            face_charts: Vec::new(),
            count: 0,
            worst: 0.0,
            total: 0.0,
            phase: VsaPhase::Growing,
        };
        let progress =
            Progress { regions, state, inserted: 0, settled: 0, steps: 0, status: Status::Running };
        let mut flow = Self { mesh, params, flood, progress };
        flow.publish();
        Ok(flow)
    }

    /// What is needed to go on from here.
    pub fn checkpoint(&self) -> VsaCheckpoint {
        VsaCheckpoint(self.progress.clone())
    }

    /// Goes back to a checkpoint of a flow on the same surface.
    pub fn restore(&mut self, checkpoint: &VsaCheckpoint) {
        self.progress = checkpoint.0.clone();
    }

    /// Options in force.
    pub fn params(&self) -> &VsaParams {
        &self.params
    }

    /// Goes on with other options from the regions that there are: a lower tolerance makes more, a higher one merges some.
    pub fn set_params(&mut self, params: VsaParams) -> Result<(), SolveError> {
        params.validate()?;
        if params == self.params {
            return Ok(());
        }
        let is_higher = params.tolerance > self.params.tolerance;
        self.params = params;
        self.progress.state.phase = if is_higher { VsaPhase::Merging } else { VsaPhase::Growing };
        self.progress.settled = 0;
        self.progress.status = Status::Running;
        Ok(())
    }

    /// Accepted steps so far.
    pub fn steps(&self) -> usize {
        self.progress.steps
    }

    /// Whether there is more to do.
    pub fn status(&self) -> Status {
        self.progress.status
    }

    /// For each face |n − N|², N the mean normal of its chart: from 0 to 4.
    pub fn face_errors(&self) -> Vec<f64> {
        let regions = &self.progress.regions;
        let error = |f: FaceId| self.flood.distance(f.0, &regions.proxies[regions.of(f.0)]);
        self.mesh.faces().map(error).collect()
    }

    fn publish(&mut self) {
        let area = self.flood.total_area;
        let Progress { regions, state, .. } = &mut self.progress;
        state.face_charts.clone_from(&regions.charts);
        state.count = regions.count();
        state.worst = regions.errors().fold(0.0, f64::max) / area;
        state.total = regions.errors().sum::<f64>() / area;
    }

    /// One more region, where the error is largest.
    fn grow(&mut self) {
        let limit = self.params.tolerance * self.flood.total_area;
        let progress = &mut self.progress;
        let regions = &mut progress.regions;
        let is_full = regions.count() >= self.params.max_charts;
        let worst = regions.worst().filter(|&region| regions.error(region) > limit && !is_full);
        let Some(seed) = worst.and_then(|region| regions.farthest(&self.flood, region)) else {
            progress.state.phase = VsaPhase::Settling;
            return;
        };
        regions.insert(&mut self.flood, seed, self.params.rounds);
        progress.inserted += 1;
        let every = self.params.teleport_every;
        if every > 0 && progress.inserted.is_multiple_of(every) {
            // A pair that is nearly one makes room for a region where it is needed more.
            if let Some((pair, increase)) = regions.nearest_pair(&self.flood)
                && let Some(worst) = regions.worst()
                && increase < 0.5 * regions.error(worst)
                && !pair.contains(&worst)
                && let Some(seed) = regions.farthest(&self.flood, worst)
            {
                regions.teleport(&mut self.flood, pair, seed, self.params.rounds);
            }
            regions.round(&mut self.flood);
        }
    }

    /// Fewer regions, where the least is lost.
    fn merge(&mut self) {
        let limit = self.params.tolerance * self.flood.total_area;
        let regions = &mut self.progress.regions;
        for _ in 0..MERGES {
            let Some(pair) = regions.best_merge(&self.flood, limit) else {
                self.progress.state.phase = VsaPhase::Settling;
                return;
            };
            regions.merge(pair);
        }
    }

    /// One round of all regions.
    fn settle(&mut self) {
        let progress = &mut self.progress;
        if progress.settled < self.params.final_rounds {
            progress.settled += 1;
            if progress.regions.round(&mut self.flood) {
                return;
            }
        }
        progress.state.phase = VsaPhase::Done;
        let is_full = progress.regions.count() >= self.params.max_charts;
        progress.status = if is_full { Status::StepLimit } else { Status::Converged };
    }
}

impl Flow for VsaFlow {
    type State = VsaState;

    fn state(&self) -> &VsaState {
        &self.progress.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.progress.status == Status::Running {
            match self.progress.state.phase {
                VsaPhase::Growing => self.grow(),
                VsaPhase::Merging => self.merge(),
                VsaPhase::Settling | VsaPhase::Done => self.settle(),
            }
            self.progress.steps += 1;
            self.publish();
        }
        let Progress { state, steps, status, .. } = &self.progress;
        let worst = state.worst / self.params.tolerance;
        Ok(StepReport {
            step: *steps,
            energy: vec![("error", state.total), ("worst", state.worst)],
            residual: worst,
            progress: None,
            status: *status,
        })
    }
}
