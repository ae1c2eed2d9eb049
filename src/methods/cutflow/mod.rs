//! [VSC] Variational surface cutting: move a cut so that its pieces flatten with less distortion.
//!
//! **Minimises** J(γ) = w_D Σ ∫|∇u|² + w_H Σ ∫u² + α |γ| over cuts γ of a surface of unit area, where on every patch
//! Δu = −K and u = 0 on its rim: u is the log scale factor of the patch's conformal flattening with isometric boundary.
//! The mesh's own boundary belongs to the rims and never to γ.
//!
//! **Step**: scheme B, exact descent on the discrete J. The derivative of the discrete objective with respect to the
//! crossings of the cut is exact; it is turned into a direction in an H¹ metric on the curve (steepest descent with two
//! regions, L-BFGS with more), a trial moves the level sets, and is taken if J falls. One numeric factorisation per trial,
//! one symbolic analysis per run.
//!
//! Guaranteed: J never rises; no vertex changes its label unless its neighbour across the cut had that label, so the cut
//! never jumps more than one edge (the first step is a disturbance and up to three descents: up to four edges); patches are neither torn, joined nor pierced; with more than two regions a patch may
//! shrink away. Not guaranteed: the global minimum, and patches that are disks (see [`super::cutgraph`]).

mod band;
mod cut;
mod energy;
mod init;
mod memory;
mod metric;
mod paper;
mod topology;

use band::{LevelSets, Response};
use cut::{Cut, Frames, NONE};
use energy::{Problem, Solution};
use memory::Memory;
use metric::{CurveMetric, dot};

pub use energy::{Energy, Weights};
pub use init::{Initial, initial_labels};
pub use paper::Stages;

use super::flow::{Flow, SolveError, Status, StepReport};
use crate::geometry::Geometry;
use crate::linalg::{Factor, LinalgError};
use crate::mesh::{CutMesh, EdgeId, Mesh, VertexId};

/// Options of a [`CutFlow`]. All are for a surface of unit area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutFlowParams {
    /// Weights of the objective.
    pub weights: Weights,
    /// Largest displacement of the cut in one step, in mean edge lengths. ½ is safe and takes twice the steps; 2 is worse
    /// with many patches, 4 fails.
    pub cap: f64,
    /// Amplitude of the seeded smooth disturbance of the first step, in mean edge lengths. It leaves saddles, and it chooses
    /// the minimum: a symmetric start without it waits for rounding errors to grow.
    pub kick: f64,
    /// Seed of that disturbance.
    pub seed: u64,
    /// The run has converged when the last ten steps together lowered J by less than this fraction.
    pub tolerance: f64,
}

impl Default for CutFlowParams {
    fn default() -> Self {
        Self {
            weights: Weights { dirichlet: 10.0, hencky: 0.0, length: 2.0 },
            cap: 1.0,
            kick: 0.5,
            seed: 1,
            tolerance: 1e-5,
        }
    }
}

impl CutFlowParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = |name, value: f64, min: f64, max: f64| {
            if value >= min && value <= max {
                Ok(())
            } else {
                Err(SolveError::Parameter { name, value, min, max })
            }
        };
        within("Dirichlet weight", self.weights.dirichlet, 0.0, 1e6)?;
        within("Hencky weight", self.weights.hencky, 0.0, 1e8)?;
        within("cut length weight", self.weights.length, 0.0, 1e6)?;
        within("step cap", self.cap, 0.01, 2.0)?;
        within("kick", self.kick, 0.0, 2.0)?;
        within("tolerance", self.tolerance, 0.0, 1.0)?;
        if self.weights.dirichlet + self.weights.hencky > 0.0 {
            Ok(())
        } else {
            Err(SolveError::NoEnergy)
        }
    }
}

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

/// How (ℓ, clip) change after each failed line search in a row; when all have failed the run ends.
const RETRIES: [(Smoothing, f64); 5] = [
    (Smoothing::Edges(2.0), 3.0),
    (Smoothing::Edges(2.0), 1.0),
    (Smoothing::Edges(8.0), 3.0),
    (Smoothing::Edges(2.0), 0.5),
    (Smoothing::Edges(1.0), 1.5),
];

/// Trials of one line search.
const TRIALS: usize = 12;

/// Smoothing length of the metric.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Smoothing {
    /// For a surface of unit area.
    Absolute(f64),
    /// In mean edge lengths.
    Edges(f64),
}

/// What a step remembers for the next one, apart from the state.
#[derive(Clone, Debug, Default)]
struct Progress {
    step: usize,
    /// Step length that the next steepest-descent search starts with; 0 for the cap.
    scale: f64,
    failures: usize,
    /// Decrease of J that the last direction promised for a step of full length.
    promise: f64,
    memory: Memory,
    /// J after every step, for the test of convergence.
    history: Vec<f64>,
}

/// The flow. Made from a mesh of unit area and an initial labelling.
pub struct CutFlow {
    problem: Problem,
    params: CutFlowParams,
    mean_edge: f64,
    state: CutState,
    progress: Progress,
    status: Status,
    /// Memory of the solution before, reused by the next trial.
    spare: Option<Solution>,
    edge_crossings: Vec<u32>,
}

/// Everything needed to go on from a step: a copy of the accepted level sets and the memory of the search.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    levels: LevelSets,
    progress: Progress,
    status: Status,
}

impl CutFlow {
    /// Prepares a run: analyses the mesh once and evaluates the initial cut.
    ///
    /// **Takes** a geometry of unit area and one label for each vertex, or an implicit function (see [`Initial`]).
    /// **Fails** if parameters are out of range, if the labels do not cut anything, or if a factorisation fails.
    pub fn new(
        mesh: Mesh,
        geometry: Geometry,
        initial: &Initial,
        params: CutFlowParams,
    ) -> Result<Self, SolveError> {
        params.validate()?;
        let start = initial_labels(&mesh, &geometry, initial)?;
        let mean_edge = geometry.mean_edge_length();
        let mut problem = Problem::new(mesh, geometry)?;
        let mut edge_crossings = vec![NONE; problem.mesh.edge_count()];
        let cut = Cut::find(
            &problem.mesh,
            &problem.frames,
            &start.labels,
            |v, lower, _| {
                let sign = if start.labels[v.index()] == lower { -2.0 } else { 2.0 };
                sign * start.magnitude(v, mean_edge)
            },
            &mut edge_crossings,
        );
        clear(&mut edge_crossings, &cut);
        if cut.crossings.is_empty() && problem.mesh.boundary_loops().is_empty() {
            return Err(SolveError::EmptyCut { vertices: problem.mesh.vertex_count() });
        }
        problem.rest_uncut_components(&cut);
        let levels = LevelSets::around(
            &problem,
            &cut,
            start.labels.clone(),
            |v| start.magnitude(v, mean_edge),
            mean_edge,
        );
        let (levels, response) = LevelSets::rebuild(&problem, &cut, levels, mean_edge);
        let solution = problem.solve(&cut, &params.weights, None)?;
        if !solution.energy.total.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let progress = Progress { history: vec![solution.energy.total], ..Progress::default() };
        Ok(Self {
            problem,
            params,
            mean_edge,
            state: CutState { levels, response, cut, solution },
            progress,
            status: Status::Running,
            spare: None,
            edge_crossings,
        })
    }

    /// The mesh that is cut.
    pub fn mesh(&self) -> &Mesh {
        &self.problem.mesh
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

    /// Changes options between steps; they act from the next step on. J is measured anew, and a run that had ended goes on.
    pub fn set_params(&mut self, params: CutFlowParams) -> Result<(), SolveError> {
        params.validate()?;
        if params == self.params {
            return Ok(());
        }
        if params.weights != self.params.weights {
            let energy = &mut self.state.solution.energy;
            energy.total = params.weights.dirichlet * energy.dirichlet
                + params.weights.hencky * energy.hencky
                + params.weights.length * energy.length;
            self.progress.history = vec![energy.total];
            self.progress.memory.clear();
            self.progress.scale = 0.0;
        }
        self.params = params;
        self.progress.failures = 0;
        self.status = Status::Running;
        Ok(())
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
    pub fn factor(&mut self) -> &mut Factor {
        self.state.solution.factor()
    }

    /// What is needed to go on from here.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            levels: self.state.levels.clone(),
            progress: self.progress.clone(),
            status: self.status,
        }
    }

    /// Goes back to a checkpoint of a flow on the same surface. Later steps repeat bit for bit.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), SolveError> {
        let (cut, solution) = self.evaluate(&checkpoint.levels)?;
        let (levels, response) =
            LevelSets::rebuild(&self.problem, &cut, checkpoint.levels.clone(), self.mean_edge);
        self.spare = Some(
            std::mem::replace(&mut self.state, CutState { levels, response, cut, solution })
                .solution,
        );
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
        let gradient = self.gradient();
        let direction: Vec<f64> = (0..gradient.len()).map(displacement).collect();
        let mut levels = self.state.levels.clone();
        self.state.response.apply(&direction, length, &mut levels.values);
        levels.project();
        let (_, solution) = self.evaluate(&levels)?;
        let total = solution.energy.total;
        self.spare = Some(solution);
        Ok((dot(&gradient, &direction), total))
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
        let solution = self.problem.solve(&cut, &self.params.weights, spare)?;
        Ok((cut, solution))
    }

    fn gradient(&mut self) -> Vec<f64> {
        let mut forces = Vec::new();
        let CutState { levels, response, cut, solution } = &mut self.state;
        self.problem.crossing_forces(cut, &self.params.weights, solution, &mut forces);
        response.pull_back(&self.problem, cut, levels, &forces)
    }

    /// Moves the level sets by `scale` · `direction` and evaluates; `None` if the result cannot be used at all.
    fn try_move(
        &mut self,
        direction: &[f64],
        scale: f64,
    ) -> Result<Option<(LevelSets, Cut, Solution)>, SolveError> {
        let mut levels = self.state.levels.clone();
        self.state.response.apply(direction, scale, &mut levels.values);
        let moved = scale * direction.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        self.settle(levels, moved)
    }

    /// Projects level sets that have moved, keeps the patches' topology and evaluates; `None` if the result cannot be used at
    /// all. **Takes** how far the cut `moved` at most.
    fn settle(
        &mut self,
        mut levels: LevelSets,
        moved: f64,
    ) -> Result<Option<(LevelSets, Cut, Solution)>, SolveError> {
        levels.project();
        let vanish = self.has_many_regions();
        topology::keep_simple(
            &self.problem.mesh,
            &self.state.levels.labels,
            &mut levels,
            vanish,
            self.mean_edge,
            moved,
        );
        match self.evaluate(&levels) {
            // A closed component that lost its cut would look like a bargain: nothing is left to pay for.
            Ok((cut, solution))
                if solution.energy.total.is_finite() && !self.problem.misses_a_component(&cut) =>
            {
                Ok(Some((levels, cut, solution)))
            }
            Ok((_, solution)) => {
                self.spare = Some(solution);
                Ok(None)
            }
            // As above, or a sliver lost its area: a trial to be refused like any other.
            Err(LinalgError::NotPositiveDefinite { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn accept(&mut self, levels: LevelSets, cut: Cut, solution: Solution) {
        let (levels, response) = LevelSets::rebuild(&self.problem, &cut, levels, self.mean_edge);
        let old = std::mem::replace(&mut self.state, CutState { levels, response, cut, solution });
        self.spare = Some(old.solution);
    }

    /// The seeded smooth disturbance.
    fn kick(&mut self) -> Result<(), SolveError> {
        let field = init::smooth_noise(
            &self.problem.mesh,
            &self.problem.geometry,
            &self.problem.analysis,
            self.params.seed,
        )?;
        let mesh = &self.problem.mesh;
        let mut displacement: Vec<f64> = self
            .state
            .cut
            .crossings
            .iter()
            .map(|c| {
                let [a, b] = mesh.edge_vertices(c.edge).map(|v| field[v.index()]);
                a + (b - a) * c.t
            })
            .collect();
        let largest = displacement.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        if largest > 0.0 {
            for d in &mut displacement {
                *d *= self.params.kick * self.mean_edge / largest;
            }
            if let Some((levels, cut, solution)) = self.try_move(&displacement, 1.0)? {
                self.accept(levels, cut, solution);
            }
        }
        Ok(())
    }

    /// The first step: the disturbance, and descents until J is below `ceiling`, three at most. What it leaves is to be taken
    /// back if J is not.
    fn kick_and_descend(&mut self, ceiling: f64) -> Result<(), SolveError> {
        self.kick()?;
        for _ in 0..3 {
            if !self.descend(f64::INFINITY)? || self.state.solution.energy.total < ceiling {
                break;
            }
        }
        Ok(())
    }

    /// One descent step from the current state to a J below `ceiling`.
    fn descend(&mut self, ceiling: f64) -> Result<bool, SolveError> {
        self.progress.promise = 0.0;
        if self.state.cut.crossings.is_empty() {
            return Ok(false);
        }
        let many = self.has_many_regions();
        let failures = self.progress.failures;
        let (smoothing, clip) = if failures == 0 {
            (if many { Smoothing::Edges(2.0) } else { Smoothing::Absolute(0.085) }, 3.0)
        } else {
            RETRIES[failures - 1]
        };
        let smoothing = match smoothing {
            Smoothing::Absolute(length) => length,
            Smoothing::Edges(count) => count * self.mean_edge,
        };
        let mut metric = CurveMetric::new(&self.state.cut, smoothing, self.mean_edge)?;
        let mut gradient = self.gradient();
        metric.clip(&mut gradient, clip, self.mean_edge);
        let z = metric.raise(&gradient);

        let mut direction: Vec<f64> = z.iter().map(|z| -z).collect();
        let mut is_quasi_newton = false;
        if many {
            self.progress.memory.transport(&self.problem, &self.state.cut, &metric, &z);
            if !self.progress.memory.is_empty() {
                let candidate = self.progress.memory.direction(&metric, &z);
                let slope = dot(&gradient, &candidate);
                let size = (dot(&metric.lower(&candidate), &candidate) * dot(&gradient, &z)).sqrt();
                if slope < -1e-3 * size {
                    direction = candidate;
                    is_quasi_newton = true;
                }
            }
        }
        let slope = dot(&gradient, &direction);
        let largest = direction.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        if !(slope < 0.0 && largest > 0.0 && largest.is_finite()) {
            return Ok(false);
        }
        let capped = self.params.cap * self.mean_edge / largest;
        // Only a quasi-Newton direction has a length of its own.
        let mut scale = if is_quasi_newton {
            capped.min(1.0)
        } else if self.progress.scale > 0.0 {
            capped.min(self.progress.scale)
        } else {
            capped
        };
        let start = self.state.solution.energy.total;
        self.progress.promise = -slope * capped;
        for _ in 0..TRIALS {
            if let Some((levels, cut, solution)) = self.try_move(&direction, scale)? {
                let total = solution.energy.total;
                if total < ceiling.min(start + 1e-4 * scale * slope) {
                    if many {
                        let step = direction.iter().map(|d| d * scale).collect();
                        self.progress.memory.record(&self.problem, &self.state.cut, step, z);
                    }
                    self.accept(levels, cut, solution);
                    self.progress.scale = 1.6 * scale;
                    return Ok(true);
                }
                self.spare = Some(solution);
            }
            scale *= 0.4;
        }
        Ok(false)
    }

    fn report(&self) -> StepReport {
        let energy = self.state.solution.energy;
        let weights = &self.params.weights;
        StepReport {
            step: self.progress.step,
            energy: vec![
                ("total", energy.total),
                ("dirichlet", weights.dirichlet * energy.dirichlet),
                ("hencky", weights.hencky * energy.hencky),
                ("length", weights.length * energy.length),
            ],
            residual: self.state.solution.residual,
            progress: None,
            status: self.status,
        }
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
        let ceiling = self.state.solution.energy.total;
        let mut moved = false;
        if self.progress.step == 0 && self.params.kick > 0.0 {
            let start = self.checkpoint();
            let result = self.kick_and_descend(ceiling);
            moved = result.is_ok() && self.state.solution.energy.total < ceiling;
            if !moved {
                self.restore(&start)?;
            }
            result?;
        }
        while !moved && self.progress.failures <= RETRIES.len() {
            moved = self.descend(ceiling)?;
            if !moved {
                self.progress.memory.clear();
                self.progress.scale = 0.0;
                self.progress.failures += 1;
            }
        }
        if moved {
            self.progress.failures = 0;
            self.progress.step += 1;
            let total = self.state.solution.energy.total;
            self.progress.history.push(total);
            let count = self.progress.history.len();
            if count > 10 {
                let before = self.progress.history[count - 11];
                if before - total < self.params.tolerance * before.abs() {
                    self.status = Status::Converged;
                }
            }
        } else {
            // Nothing to gain in any direction is an end like the other; a promise that no step keeps is not.
            let total = self.state.solution.energy.total;
            let is_flat = self.progress.promise <= self.params.tolerance * total.abs();
            self.status = if is_flat { Status::Converged } else { Status::Stalled };
        }
        Ok(self.report())
    }
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
