//! Borders of charts moved to least cuts, pair by pair, where the charts stay as flat as they were.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::network::curves;
use super::params::MergeParams;
use super::trial::{Bench, Limits};
use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh};
use crate::methods::developable::{TightenParams, tighten};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Rounding in a sum of changes of area.
const SAME: f64 = 1e-12;

/// Charts, and what tightening has done to them.
#[derive(Clone, Debug, PartialEq)]
pub struct TightenState {
    /// Chart of every face.
    pub face_charts: Vec<u32>,
    /// Length of all borders.
    pub seam_length: f64,
    /// Pairs looked at.
    pub tried: usize,
    /// Borders that were moved.
    pub moved: usize,
}

/// Moves the border of each pair of charts to a least cut nearby, one pair a step.
///
/// **Minimises** what borders cost (see [`tighten`]), pair by pair, once each. A border is moved only if both charts still have maps without flips and overlaps
/// whose changes of area keep the limit, or were beyond it before and are no more so, and if Σ A_abs · area does not grow. **Step** one pair.
/// **Ends** `Converged` after the last pair. **From** [LPFB] §4.2. **Differs** by that gate: least cuts alone make charts that cannot be flattened.
pub struct TightenFlow {
    bench: Bench,
    params: TightenParams,
    limits: Limits,
    area_limit: f64,
    /// What an edge costs beyond its length.
    factors: Vec<f64>,
    pairs: Vec<[u32; 2]>,
    progress: Progress,
}

/// Where a [`TightenFlow`] can go back to.
#[derive(Clone)]
pub struct TightenCheckpoint(Progress);

#[derive(Clone)]
struct Progress {
    state: TightenState,
    /// For each chart A_abs and A_abs · area, once it is known; `None` in it for a chart without a map.
    worth: Vec<Option<Option<[f64; 2]>>>,
    status: Status,
}

impl TightenFlow {
    /// **Takes** a surface, a chart for each face (numbers without gaps), the limits of the merging that comes after, and a price for each edge beyond its length (a factor; empty
    /// for 1).
    pub fn new(
        mesh: Arc<Mesh>,
        geometry: Arc<Geometry>,
        charts: &[u32],
        params: TightenParams,
        limits: &MergeParams,
        factors: &[f64],
    ) -> Self {
        let pairs: BTreeSet<[u32; 2]> = mesh
            .edges()
            .filter_map(|e| {
                let h = e.halfedge();
                let (f, g) = (mesh.face(h)?, mesh.face(h.twin())?);
                let (a, b) = (charts[f.index()], charts[g.index()]);
                (a != b).then_some([a.min(b), a.max(b)])
            })
            .collect();
        let count = charts.iter().max().map_or(0, |&most| most as usize + 1);
        let state = TightenState {
            face_charts: charts.to_vec(),
            seam_length: seam_length(&mesh, &geometry, charts),
            tried: 0,
            moved: 0,
        };
        let status = if pairs.is_empty() { Status::Converged } else { Status::Running };
        Self {
            bench: Bench::new(mesh, geometry),
            params,
            limits: Limits::none(limits),
            area_limit: limits.split_limit.min(limits.area_limit),
            factors: factors.to_vec(),
            pairs: pairs.into_iter().collect(),
            progress: Progress { state, worth: vec![None; count], status },
        }
    }

    /// What is needed to go on from here.
    pub fn checkpoint(&self) -> TightenCheckpoint {
        TightenCheckpoint(self.progress.clone())
    }

    /// Goes back to a checkpoint of a flow with the same charts and options.
    pub fn restore(&mut self, checkpoint: &TightenCheckpoint) {
        self.progress = checkpoint.0.clone();
    }

    /// Whether there is more to do.
    pub fn status(&self) -> Status {
        self.progress.status
    }

    /// Number of pairs.
    pub fn pair_count(&self) -> usize {
        self.pairs.len()
    }

    /// A_abs of a chart and A_abs · area; `None` if it has no map.
    fn weigh(&mut self, charts: &[u32], chart: u32) -> Option<[f64; 2]> {
        let mesh = self.bench.mesh.clone();
        let faces: Vec<FaceId> = mesh.faces().filter(|f| charts[f.index()] == chart).collect();
        let area: f64 = faces.iter().map(|f| self.bench.geometry.face_areas[f.index()]).sum();
        let map = self.bench.flatten(&faces, &self.limits).ok()?;
        let change = self.limits.area_of(&map.measures);
        Some([change, map.measures.area_absolute * area])
    }

    /// Whether a chart is worth no less than before.
    fn is_no_worse(&self, before: Option<[f64; 2]>, after: Option<[f64; 2]>) -> bool {
        match (before, after) {
            (_, Some([change, _])) if change <= self.area_limit => true,
            (Some([old, _]), Some([new, _])) => new <= old + SAME,
            (None, Some(_)) => true,
            (_, None) => false,
        }
    }

    fn try_pair(&mut self, pair: [u32; 2]) {
        let (mesh, geometry) = (self.bench.mesh.clone(), self.bench.geometry.clone());
        let charts = self.progress.state.face_charts.clone();
        let moved = tighten(&mesh, &geometry, &charts, pair, &self.factors, &self.params);
        if moved.is_empty() {
            return;
        }
        let before = pair.map(|chart| match self.progress.worth[chart as usize] {
            Some(known) => known,
            None => {
                let found = self.weigh(&charts, chart);
                self.progress.worth[chart as usize] = Some(found);
                found
            }
        });
        let mut other = charts;
        moved.iter().for_each(|(f, chart)| other[f.index()] = *chart);
        let after = pair.map(|chart| self.weigh(&other, chart));
        let sum =
            |worth: [Option<[f64; 2]>; 2]| -> Option<f64> { Some(worth[0]?[1] + worth[1]?[1]) };
        let is_less = match (sum(before), sum(after)) {
            (Some(before), Some(after)) => after <= before + SAME,
            (None, after) => after.is_some(),
            (Some(_), None) => false,
        };
        if is_less && (0..2).all(|i| self.is_no_worse(before[i], after[i])) {
            for (chart, worth) in pair.into_iter().zip(after) {
                self.progress.worth[chart as usize] = Some(worth);
            }
            let state = &mut self.progress.state;
            state.seam_length = seam_length(&mesh, &geometry, &other);
            state.face_charts = other;
            state.moved += 1;
        }
    }
}

fn seam_length(mesh: &Mesh, geometry: &Geometry, charts: &[u32]) -> f64 {
    curves(mesh, geometry, charts).iter().map(|curve| curve.length).sum()
}

impl Flow for TightenFlow {
    type State = TightenState;

    fn state(&self) -> &TightenState {
        &self.progress.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.progress.status == Status::Running {
            if let Some(&pair) = self.pairs.get(self.progress.state.tried) {
                self.try_pair(pair);
                self.progress.state.tried += 1;
            }
            if self.progress.state.tried == self.pairs.len() {
                self.progress.status = Status::Converged;
            }
        }
        let state = &self.progress.state;
        #[expect(clippy::cast_precision_loss, reason = "shown as a bar")]
        let progress = state.tried as f32 / self.pairs.len().max(1) as f32;
        Ok(StepReport {
            step: state.tried,
            energy: vec![("seam", state.seam_length)],
            residual: 0.0,
            progress: Some(progress),
            status: self.progress.status,
        })
    }
}
