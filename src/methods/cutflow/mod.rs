//! [VSC] Variational surface cutting: move a cut so that its pieces flatten with less distortion.
//!
//! **Minimises** J(γ) = w_D Σ ∫|∇u|² + w_H Σ ∫b(u) + α |γ| + w_η ∫_γ η − w_A |P₀| over cuts γ of a surface of unit area, where on
//! every patch Δu = −K and u = 0 on its rim: u is the log scale factor of the patch's conformal flattening with isometric
//! boundary, and b(u) = u² unless another price is chosen. The mesh's own boundary belongs to the rims and never to γ.
//!
//! **Step**: scheme B, exact descent on the discrete J. The derivative of the discrete objective with respect to the
//! crossings of the cut is exact; it is turned into a direction in an H¹ metric on the curve (steepest descent with two
//! regions, L-BFGS with more), a trial moves the level sets, and is taken if J falls. One numeric factorisation per trial,
//! one symbolic analysis per run.
//!
//! [`Scheme::Paper`] is the paper's own flow instead, on the same J.
//!
//! Guaranteed: J never rises; in a step of the search no vertex changes its label unless its neighbour across the cut had that
//! label, so the cut never jumps more than one edge (the first step is a disturbance and up to three descents: up to four edges;
//! steps made on a coarse surface and the leap beyond a saddle are many such steps in one, and of the former only the number
//! of regions is compared); patches are neither torn, joined nor pierced unless [`Topology`] allows it; with
//! more than two regions a patch may shrink away, and where nothing else is chosen patches of one label may join. A [`Schedule`] that changes α changes what J means, between steps. Not guaranteed: the global minimum, and patches that are disks (see [`super::cutgraph`]).

mod band;
mod candidates;
mod coarse;
pub(super) mod cut;
mod energy;
mod init;
mod memory;
mod metric;
mod paper;
mod params;
mod probe;
mod search;
mod symmetric;
mod terms;
mod topology;

use band::{LevelSets, Response};
use coarse::{Coarse, SavedCoarse};
use cut::{Cut, Frames, NONE};
use energy::{Problem, SharedFactor, Solution};
use memory::Memory;
use probe::{Probe, SavedProbe};
use symmetric::Symmetric;

pub(super) use init::uniform;
pub use init::{Initial, Start, initial_labels};
pub use paper::Stages;
pub use params::{CutFlowParams, Schedule, Scheme, Topology};
pub use terms::{CutFields, Energy, Pointwise, Source, Weights};

use std::sync::Arc;

use nalgebra::Point3;

use super::flow::{Flow, SolveError, Status, StepReport};
use crate::geometry::Geometry;
use crate::linalg::{Factor, LinalgError, dot};
use crate::mesh::{CutMesh, EdgeId, Mesh, VertexId};

/// A labelled surface and what is known of its cut.
pub struct CutState {
    levels: LevelSets,
    response: Response,
    cut: Cut,
    solution: Solution,
}

impl CutState {
    /// The label of every vertex.
    pub fn labels(&self) -> &[u32] {
        &self.levels.labels
    }

    /// The objective and its terms.
    pub fn energy(&self) -> Energy {
        self.solution.energy
    }

    /// Log scale factor at the vertices; 0 on cut and boundary.
    pub fn u(&self) -> &[f64] {
        &self.solution.u
    }

    /// Relative residual of the solve that gave u.
    pub fn residual(&self) -> f64 {
        self.solution.residual
    }

    /// Number of points where the cut crosses an edge.
    pub fn crossing_count(&self) -> usize {
        self.cut.crossings.len()
    }

    /// Number of faces in which three regions meet.
    pub fn triple_point_count(&self) -> usize {
        self.cut.centres.len()
    }
}

/// What a step remembers for the next one, apart from the state.
#[derive(Clone, Debug, Default)]
struct Progress {
    step: usize,
    /// Step length that the next steepest-descent search starts with; 0 for the cap.
    scale: f64,
    /// Time step that the next step of the paper's flow starts with; 0 for the longest.
    time_step: f64,
    failures: usize,
    /// Decrease of J that the last direction promised for a step of full length.
    promise: f64,
    memory: Memory,
    /// J after every step, for the test of convergence.
    history: Vec<f64>,
    /// Saddle tests made so far.
    probes: usize,
}

/// The flow. Made from a mesh of unit area and an initial labelling.
pub struct CutFlow {
    problem: Problem,
    params: CutFlowParams,
    /// Those of the parameters, with the length weight of the step.
    weights: Weights,
    mean_edge: f64,
    state: CutState,
    progress: Progress,
    status: Status,
    probe: Option<Probe>,
    coarse: Option<Coarse>,
    fields: CutFields,
    symmetric: Symmetric,
    /// Memory of the solution before, reused by the next trial.
    spare: Option<Solution>,
    shared: SharedFactor,
    edge_crossings: Vec<u32>,
}

/// Everything needed to go on from a step: a copy of the accepted level sets and the memory of the search.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    levels: LevelSets,
    /// The length weight that acted: a schedule changes it at the beginning of a step.
    length: f64,
    progress: Progress,
    status: Status,
    probe: Option<SavedProbe>,
    coarse: Option<SavedCoarse>,
    symmetric: Symmetric,
}

impl Checkpoint {
    /// The label of each vertex there.
    pub fn labels(&self) -> &[u32] {
        &self.levels.labels
    }
}

impl CutFlow {
    /// Prepares a run: analyses the mesh once and evaluates the initial cut.
    ///
    /// **Takes** a surface, which it shares with whoever else holds it, of unit area and one label for each vertex, or an implicit function (see [`Initial`]).
    /// **Fails** if parameters are out of range, if the labels do not cut anything, or if a factorisation fails.
    pub fn new(
        mesh: impl Into<Arc<Mesh>>,
        geometry: impl Into<Arc<Geometry>>,
        initial: &Initial,
        params: CutFlowParams,
    ) -> Result<Self, SolveError> {
        Self::with_fields(mesh, geometry, initial, params, &CutFields::default())
    }

    /// The same with sources, penalties and pins of its own.
    ///
    /// **Fails** also if these have the wrong shape or values out of range.
    pub fn with_fields(
        mesh: impl Into<Arc<Mesh>>,
        geometry: impl Into<Arc<Geometry>>,
        initial: &Initial,
        params: CutFlowParams,
        fields: &CutFields,
    ) -> Result<Self, SolveError> {
        let (mesh, geometry) = (mesh.into(), geometry.into());
        params.validate()?;
        fields.validate(mesh.vertex_count())?;
        let start = initial_labels(&mesh, &geometry, initial)?;
        if params.weights.one_sided && !start.labels.contains(&0) {
            return Err(SolveError::NoFirstRegion);
        }
        Self::from_start(mesh, geometry, start, params, fields)
    }

    /// A flow as a checkpoint left it, whatever it started from.
    ///
    /// **Takes** the surface, options and fields of then.
    pub fn resume(
        mesh: impl Into<Arc<Mesh>>,
        geometry: impl Into<Arc<Geometry>>,
        checkpoint: &Checkpoint,
        params: CutFlowParams,
        fields: &CutFields,
    ) -> Result<Self, SolveError> {
        let (mesh, geometry) = (mesh.into(), geometry.into());
        params.validate()?;
        fields.validate(mesh.vertex_count())?;
        let start = Start::of_labels(checkpoint.levels.labels.clone());
        // The cut is symmetric already, and what its symmetries do to labels is known.
        let without = CutFields { symmetry: Arc::default(), ..fields.clone() };
        let mut flow = Self::from_start(mesh, geometry, start, params, &without)?;
        flow.fields = fields.clone();
        flow.restore(checkpoint)?;
        Ok(flow)
    }

    /// The same from labels and level sets.
    fn from_start(
        mesh: Arc<Mesh>,
        geometry: Arc<Geometry>,
        start: Start,
        params: CutFlowParams,
        fields: &CutFields,
    ) -> Result<Self, SolveError> {
        let mean_edge = geometry.mean_edge_length();
        let (symmetric, start) =
            Symmetric::new(&mesh, &geometry, &fields.symmetry, start, &params.weights)?;
        let mut problem = Problem::new(mesh, geometry)?;
        problem.set_fields(fields);
        problem.prepare_rescaling(&params.weights)?;
        let mut edge_crossings = vec![NONE; problem.mesh.edge_count()];
        let cut = first_cut(&problem, &start, mean_edge, &mut edge_crossings);
        if cut.crossings.is_empty() && problem.mesh.boundary_loops().is_empty() {
            return Err(SolveError::EmptyCut { vertices: problem.mesh.vertex_count() });
        }
        problem.rest_uncut_components(&cut);
        let weights = params.weights_at(0);
        let mut shared = SharedFactor::default();
        let state = first_state(&problem, &start, cut, mean_edge, &weights, None, &mut shared)?;
        if !state.solution.energy.total.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let history = vec![state.solution.energy.total];
        Ok(Self {
            problem,
            params,
            weights,
            mean_edge,
            state,
            progress: Progress { history, ..Progress::default() },
            status: Status::Running,
            probe: None,
            coarse: None,
            fields: fields.clone(),
            symmetric,
            spare: None,
            shared,
            edge_crossings,
        })
    }

    /// Another state from labels and level sets; `None` if it cannot be used.
    fn state_from(&mut self, start: &Start) -> Option<CutState> {
        let cut = first_cut(&self.problem, start, self.mean_edge, &mut self.edge_crossings);
        if self.problem.misses_a_component(&cut) {
            return None;
        }
        let spare = self.spare.take();
        let (problem, shared) = (&self.problem, &mut self.shared);
        first_state(problem, start, cut, self.mean_edge, &self.weights, spare, shared)
            .ok()
            .filter(|state| state.solution.energy.total.is_finite())
    }

    /// The mesh that is cut.
    pub fn mesh(&self) -> &Mesh {
        &self.problem.mesh
    }

    /// Number of closed components that the initial cut left whole: they take no part.
    pub fn resting_components(&self) -> usize {
        self.problem.resting
    }

    /// Where its vertices lie.
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.problem.geometry.positions
    }

    /// The unit of displacements.
    pub fn mean_edge_length(&self) -> f64 {
        self.mean_edge
    }

    /// Options in use.
    pub fn params(&self) -> &CutFlowParams {
        &self.params
    }

    /// Accepted steps so far.
    pub fn steps(&self) -> usize {
        self.progress.step
    }

    /// Whether there is more to do.
    pub fn status(&self) -> Status {
        self.status
    }

    /// The weights that act now: a schedule may have changed the length weight.
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Changes options between steps; they act from the next step on. J is measured anew, and a run that had ended goes on.
    /// **Fails** without any change if an option is out of range.
    pub fn set_params(&mut self, params: CutFlowParams) -> Result<(), SolveError> {
        params.validate()?;
        if params == self.params {
            return Ok(());
        }
        self.problem.prepare_rescaling(&params.weights)?;
        self.params = params;
        self.progress.probes = 0;
        self.progress.failures = 0;
        self.probe = None;
        self.coarse = None;
        self.status = Status::Running;
        let weights = params.weights_at(self.progress.step);
        if weights == self.weights {
            return Ok(());
        }
        let is_new = !weights.measures_like(&self.weights);
        self.weights = weights;
        if is_new {
            return self.measure_anew();
        }
        self.weigh_anew();
        Ok(())
    }

    /// Changes sources, penalties and pins between steps, as [`CutFlow::set_params`] does options.
    pub fn set_fields(&mut self, fields: &CutFields) -> Result<(), SolveError> {
        fields.validate(self.problem.mesh.vertex_count())?;
        self.problem.set_fields(fields);
        self.fields = fields.clone();
        self.progress.probes = 0;
        self.progress.failures = 0;
        self.probe = None;
        self.coarse = None;
        self.status = Status::Running;
        self.measure_anew()
    }

    /// The state under new weights of the terms that were measured.
    fn weigh_anew(&mut self) {
        let energy = &mut self.state.solution.energy;
        energy.total = self.weights.total(energy);
        self.forget();
    }

    /// The state under terms that were not measured yet.
    fn measure_anew(&mut self) -> Result<(), SolveError> {
        let levels = self.state.levels.clone();
        let (cut, solution) = self.evaluate(&levels)?;
        self.accept(levels, cut, solution);
        self.forget();
        Ok(())
    }

    /// Begins the search anew: what it has learned belongs to another J.
    fn forget(&mut self) {
        self.progress.history = vec![self.state.solution.energy.total];
        self.progress.memory.clear();
        self.progress.scale = 0.0;
        self.progress.time_step = 0.0;
    }

    /// The adjoint q at the vertices, with A q = 2 w_D A_a u + w_H ∫b′(u). The paper's p is −q.
    pub fn adjoint(&mut self) -> Result<Vec<f64>, SolveError> {
        let CutState { cut, solution, .. } = &mut self.state;
        Ok(self.problem.adjoint(cut, &self.weights, solution, &mut self.shared)?)
    }

    /// φ of every vertex's own region, negative inside, as far as it is stored: within a few rings of the cut.
    pub fn level(&self, v: VertexId) -> Option<f64> {
        let levels = &self.state.levels;
        levels.entry(v, levels.labels[v.index()]).map(|entry| levels.values[entry])
    }

    /// The surface refined along the cut: points `0..V` are the vertices, then the crossings, then the triple points.
    pub fn cut_mesh(&self) -> CutMesh {
        self.state.cut.refine(&self.problem.mesh, &self.problem.frames)
    }

    /// The same cut on another triangulation of the same surface with the same vertices: where its level sets, linear along
    /// *those* edges, change sign.
    ///
    /// **Differs** from [`CutFlow::cut_mesh`] by the order of an edge squared, and only where the edges differ.
    pub fn cut_mesh_on(&self, mesh: &Mesh, geometry: &Geometry) -> CutMesh {
        let frames = Frames::new(mesh, geometry);
        let levels = &self.state.levels;
        let difference = |v, lower, upper| levels.difference(v, lower, upper);
        let mut edge_crossings = vec![NONE; mesh.edge_count()];
        Cut::find(mesh, &frames, &levels.labels, difference, &mut edge_crossings)
            .refine(mesh, &frames)
    }

    /// The factor of the cut surface's Laplacian over the mesh's vertices (identity rows where u = 0 is prescribed).
    ///
    /// **Costs** nothing after a step that was taken; a factorisation where the last trial was refused or the flow
    /// [rests](CutFlow::rest).
    pub fn factor(&mut self) -> Result<&mut Factor, LinalgError> {
        self.shared.of(&self.problem.analysis, &mut self.state.solution)
    }

    /// Gives back what can be made anew, which is most of the memory of a flow. The next step **costs** one factorisation more
    /// and gives the same bits.
    pub fn rest(&mut self) {
        self.shared.release();
        self.spare = None;
        if let Some(coarse) = &mut self.coarse {
            coarse.rest();
        }
    }

    /// Numeric factorisations of the surface's Laplacian so far, all by one analysis: one for each trial, and one for the
    /// disturbance.
    pub fn factorisations(&self) -> usize {
        self.problem.analysis.factorisation_count()
    }

    /// What is needed to go on from here.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            levels: self.state.levels.clone(),
            length: self.weights.length,
            progress: self.progress.clone(),
            status: self.status,
            probe: self.probe.as_ref().map(Probe::save),
            coarse: self.coarse.as_ref().map(Coarse::save),
            symmetric: self.symmetric.clone(),
        }
    }

    /// Goes back to a checkpoint of a flow on the same surface. Later steps repeat bit for bit.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), SolveError> {
        self.weights = Weights { length: checkpoint.length, ..self.params.weights };
        self.symmetric = checkpoint.symmetric.clone();
        let probe = match &checkpoint.probe {
            Some(saved) => Some(saved.revive(self)?),
            None => None,
        };
        let coarse = match &checkpoint.coarse {
            Some(saved) => self.revive_coarse(saved)?,
            None => None,
        };
        let (cut, solution) = self.evaluate(&checkpoint.levels)?;
        self.accept(checkpoint.levels.clone(), cut, solution);
        self.probe = probe;
        self.coarse = coarse;
        self.progress = checkpoint.progress.clone();
        self.status = checkpoint.status;
        Ok(())
    }

    /// dJ along normal displacements of the crossings by the exact derivative, and J after a displacement by `length`: what
    /// a test compares.
    pub fn directional_derivative(
        &mut self,
        displacement: impl Fn(usize) -> f64,
        length: f64,
    ) -> Result<(f64, f64), SolveError> {
        let gradient = self.gradient()?;
        let direction: Vec<f64> = (0..gradient.len()).map(displacement).collect();
        Ok((dot(&gradient, &direction), self.energy_beside(&direction, length)?))
    }

    /// J after normal displacements of the crossings by `length` times these, one for each crossing: one trial of a line search.
    pub fn energy_beside(&mut self, displacements: &[f64], length: f64) -> Result<f64, SolveError> {
        assert_eq!(displacements.len(), self.state.cut.crossings.len());
        let mut levels = self.state.levels.clone();
        self.state.response.apply(displacements, length, &mut levels.values);
        levels.project();
        let (_, solution) = self.evaluate(&levels)?;
        let total = solution.energy.total;
        self.spare = Some(solution);
        Ok(total)
    }

    /// Whether regions may vanish and L-BFGS is used: more than two labels.
    fn has_many_regions(&self) -> bool {
        self.state.levels.labels.iter().any(|&label| label > 1)
    }

    fn evaluate(&mut self, levels: &LevelSets) -> Result<(Cut, Solution), LinalgError> {
        let cut = Cut::find(
            &self.problem.mesh,
            &self.problem.frames,
            &levels.labels,
            |v, lower, upper| levels.difference(v, lower, upper),
            &mut self.edge_crossings,
        );
        clear(&mut self.edge_crossings, &cut);
        let spare = self.spare.take();
        let shared = &mut self.shared;
        let solution = self.problem.solve(&cut, &levels.labels, &self.weights, spare, shared)?;
        Ok((cut, solution))
    }

    fn report(&self) -> StepReport {
        let energy = &self.state.solution.energy;
        let weights = &self.weights;
        StepReport {
            step: self.progress.step,
            energy: vec![
                ("total", energy.total),
                ("distortion", weights.distortion(energy)),
                ("length", weights.length * energy.length),
                ("penalty", weights.penalty * energy.penalty),
                ("area", -weights.area * energy.area),
            ],
            residual: self.state.solution.residual,
            progress: None,
            status: self.status,
        }
    }

    /// Puts the length weight of the coming step in force.
    fn follow_schedule(&mut self) {
        let weights = self.params.weights_at(self.progress.step);
        if weights != self.weights {
            self.weights = weights;
            let energy = &mut self.state.solution.energy;
            energy.total = weights.total(energy);
            // J under another α is another J: convergence is judged anew.
            self.progress.history = vec![energy.total];
        }
    }

    /// One step of the scheme from the current state to a J below `ceiling`; a failed search changes the way of searching and is
    /// followed by another.
    fn search(&mut self, ceiling: f64) -> Result<bool, SolveError> {
        if self.params.scheme == Scheme::Paper {
            return self.paper_step(ceiling);
        }
        while self.progress.failures <= search::RETRIES.len() {
            if self.descend(ceiling)? {
                self.progress.failures = 0;
                return Ok(true);
            }
            self.progress.memory.clear();
            self.progress.scale = 0.0;
            self.progress.failures += 1;
        }
        Ok(false)
    }

    /// Counts an accepted step and looks whether it was one of the last.
    fn count_step(&mut self) -> Option<Status> {
        self.progress.step += 1;
        let total = self.state.solution.energy.total;
        self.progress.history.push(total);
        let count = self.progress.history.len();
        if count <= 10 || self.params.is_changing_at(self.progress.step) {
            return None;
        }
        let before = self.progress.history[count - 11];
        (before - total < self.params.tolerance * before.abs()).then_some(Status::Converged)
    }
}

impl Flow for CutFlow {
    type State = CutState;

    fn state(&self) -> &CutState {
        &self.state
    }

    /// One step down. A failed line search changes nothing but the search itself and counts as part of this step.
    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status != Status::Running {
            return Ok(self.report());
        }
        if self.probe.is_some() {
            self.step_probe()?;
            return Ok(self.report());
        }
        self.follow_schedule();
        let ceiling = self.state.solution.energy.total;
        if self.progress.step == 0 && self.wants_coarse() {
            // Whatever a coarse surface cannot do, the fine one can do without it.
            self.coarse = self.make_coarse(false).unwrap_or(None);
        }
        let mut moved = self.coarse.is_some() && self.step_coarse();
        if !moved && self.progress.step == 0 && self.params.kick > 0.0 {
            let start = self.checkpoint();
            let result = self.kick_and_descend(ceiling);
            moved = result.is_ok() && self.state.solution.energy.total < ceiling;
            if !moved {
                self.restore(&start)?;
            }
            result?;
        }
        moved = moved || self.search(ceiling)?;
        let end = if moved {
            self.count_step()
        } else if self.params.is_changing_at(self.progress.step) {
            // Nothing to gain under this α; the next one is another problem.
            self.progress.failures = 0;
            self.count_step()
        } else {
            // Nothing to gain in any direction is an end like the other; a promise that no step keeps is not.
            let total = self.state.solution.energy.total;
            let is_flat = self.progress.promise <= self.params.tolerance * total.abs();
            Some(if is_flat { Status::Converged } else { Status::Stalled })
        };
        if let Some(end) = end {
            self.end_or_probe(end)?;
        }
        Ok(self.report())
    }
}

/// The cut of a start.
fn first_cut(problem: &Problem, start: &Start, mean_edge: f64, edge_crossings: &mut [u32]) -> Cut {
    let level = |v, label| start.level(v, label, mean_edge);
    let difference = |v, lower, upper| level(v, lower) - level(v, upper);
    let cut = Cut::find(&problem.mesh, &problem.frames, &start.labels, difference, edge_crossings);
    clear(edge_crossings, &cut);
    cut
}

/// The state of a start with its cut.
fn first_state(
    problem: &Problem,
    start: &Start,
    cut: Cut,
    mean_edge: f64,
    weights: &Weights,
    spare: Option<Solution>,
    shared: &mut SharedFactor,
) -> Result<CutState, SolveError> {
    let level = |v, label| start.level(v, label, mean_edge);
    let levels = LevelSets::around(problem, &cut, start.labels.clone(), level, mean_edge);
    let (levels, response) = LevelSets::rebuild(problem, &cut, levels, mean_edge);
    let solution = problem.solve(&cut, &levels.labels, weights, spare, shared)?;
    Ok(CutState { levels, response, cut, solution })
}

/// The surface refined along the borders of labels, without a flow.
///
/// **Takes** one label for each vertex, and for an edge between two labels, told by its ends, where the cut crosses it
/// (from the first end, within (0, 1)); the middle where it does not say.
pub fn labelled_cut(
    mesh: &Mesh,
    geometry: &Geometry,
    labels: &[u32],
    place: impl Fn([VertexId; 2]) -> Option<f64>,
) -> CutMesh {
    let frames = Frames::new(mesh, geometry);
    let place = |e: EdgeId| place(mesh.edge_vertices(e)).unwrap_or(0.5);
    Cut::of_labels(mesh, &frames, labels, place).refine(mesh, &frames)
}

/// Empties the lookup that [`Cut::find`] filled.
fn clear(edge_crossings: &mut [u32], cut: &Cut) {
    for crossing in &cut.crossings {
        edge_crossings[crossing.edge.index()] = NONE;
    }
}
