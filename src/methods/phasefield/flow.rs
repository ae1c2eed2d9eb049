//! The flow: one L-BFGS iteration after another, one start after another, one split after another.

use std::sync::Arc;

use super::cut::PhaseMeasures;
use super::domain::{Domain, scale_of};
use super::lbfgs::Descent;
use super::objective::{Member, Objective, Prices, SplitTerms};
use super::params::{PhaseFieldParams, Start};
use super::start;
use super::state::{PhaseFieldState, PhaseNode};
use super::terms::connected::edge;
use super::terms::yamabe::Yamabe;
use crate::geometry::Geometry;
use crate::linalg::dot;
use crate::mesh::{CutMesh, Mesh};
use crate::methods::cutflow::Initial;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Iterations over which convergence is judged.
const WINDOW: usize = 10;

/// How often islands are given up: areas are kept by moving the interface, which may leave others.
const ISLANDS: usize = 4;

/// Share of the whole area below which a segment is not split.
const SMALLEST: f64 = 1e-6;

/// An interface thinner than the mesh can carry well: remesh, or raise ε.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EpsilonTooSmall {
    /// ε in use.
    pub epsilon: f64,
    /// Smallest ε that fits.
    pub floor: f64,
}

/// The smallest ε that fits a mesh: twice the mean edge length, at area 4π.
pub fn epsilon_floor(geometry: &Geometry) -> f64 {
    2.0 * geometry.mean_edge_length() * length_scale(geometry)
}

/// Length at area 4π, in which ε and results are told, of a length of this geometry.
pub fn length_scale(geometry: &Geometry) -> f64 {
    scale_of(geometry)
}

/// A phase-field segmentation, one bounded step at a time.
///
/// **Minimises** what the [module](super) says, split by split from the root down; with [`PhaseFieldParams::is_joint`] all splits together in the
/// end. **Step** one iteration of L-BFGS with a strong Wolfe search: without ω one product of matrix and vector for each trial, with it two
/// factorisations and four solves; without ω the last step of a split costs two factorisations and two solves more, for J as it came out. The objective reported is that of the start at hand: it falls from step to step of one start, is another one with the next
/// start or split, and rises where the price of unconnected phases comes in, and at the end of a split where islands are given up. **Ends** `Converged` when every split has; `StepLimit` where one ran
/// out of iterations, `Stalled` where one found no step.
pub struct PhaseFieldFlow {
    domain: Arc<Domain>,
    params: PhaseFieldParams,
    progress: Progress,
    /// Of the job at hand.
    objective: Option<Objective>,
}

/// All that a step depends on besides surface and options.
#[derive(Clone)]
struct Progress {
    state: PhaseFieldState,
    steps: usize,
    status: Status,
    job: Option<Job>,
    /// Whether all levels were relaxed together.
    is_joint: bool,
    joint_end: Status,
}

/// A search under way.
#[derive(Clone)]
struct Job {
    /// The splits that it moves: one, or all.
    members: Vec<usize>,
    attempt: usize,
    /// Whether it goes on from fields at hand, with one start.
    is_warm: bool,
    iteration: usize,
    /// Whether unconnected phases cost already.
    is_connected: bool,
    descent: Descent,
    /// The objective after every iteration, and how many of them belong to another one, before unconnected phases cost.
    history: Vec<f64>,
    earlier: usize,
    best: Option<Best>,
}

/// The best start so far.
#[derive(Clone)]
struct Best {
    value: f64,
    u: Vec<f64>,
    terms: Vec<SplitTerms>,
    history: Vec<f64>,
    end: Status,
}

/// Where a [`PhaseFieldFlow`] can go back to.
#[derive(Clone)]
pub struct PhaseFieldCheckpoint(Progress);

impl PhaseFieldCheckpoint {
    /// The segments there.
    pub fn state(&self) -> &PhaseFieldState {
        &self.0.state
    }
}

impl PhaseFieldFlow {
    /// Analyses the mesh once and evaluates the first start.
    ///
    /// **Takes** a surface of any area, which it shares. **Fails** on options out of range, on an ε below the mean edge length, on start values of
    /// the wrong number, and if a factorisation fails.
    pub fn new(
        mesh: impl Into<Arc<Mesh>>,
        geometry: impl Into<Arc<Geometry>>,
        params: PhaseFieldParams,
    ) -> Result<Self, SolveError> {
        let (mesh, geometry) = (mesh.into(), geometry.into());
        check(&mesh, &geometry, &params)?;
        let progress = Progress {
            state: PhaseFieldState::whole(mesh.vertex_count()),
            steps: 0,
            status: Status::Running,
            job: None,
            is_joint: false,
            joint_end: Status::Converged,
        };
        let domain = Arc::new(Domain::new(mesh, geometry)?);
        let mut flow = Self { domain, params, progress, objective: None };
        flow.begin_next()?;
        Ok(flow)
    }

    /// A flow as a checkpoint left it.
    ///
    /// **Takes** the surface and options of then. **Fails** like [`PhaseFieldFlow::new`].
    pub fn resume(
        mesh: impl Into<Arc<Mesh>>,
        geometry: impl Into<Arc<Geometry>>,
        checkpoint: &PhaseFieldCheckpoint,
        params: PhaseFieldParams,
    ) -> Result<Self, SolveError> {
        let (mesh, geometry) = (mesh.into(), geometry.into());
        check(&mesh, &geometry, &params)?;
        let domain = Arc::new(Domain::new(mesh, geometry)?);
        let mut flow = Self { domain, params, progress: checkpoint.0.clone(), objective: None };
        flow.objective = flow.current_objective();
        Ok(flow)
    }

    /// What is needed to go on from here.
    pub fn checkpoint(&self) -> PhaseFieldCheckpoint {
        PhaseFieldCheckpoint(self.progress.clone())
    }

    /// Goes back to a checkpoint of a flow on the same surface with the same options. Later steps repeat bit for bit.
    pub fn restore(&mut self, checkpoint: &PhaseFieldCheckpoint) {
        self.progress = checkpoint.0.clone();
        self.objective = self.current_objective();
    }

    /// Options in use.
    pub fn params(&self) -> &PhaseFieldParams {
        &self.params
    }

    /// Changes options between steps, at any time, and goes on from the fields at hand: another ε, ω, κ, fraction, screening or tolerance moves
    /// them from the root down with one start each; more levels split on, fewer take splits away. **Fails** without any
    /// change like [`PhaseFieldFlow::new`].
    pub fn set_params(&mut self, params: PhaseFieldParams) -> Result<(), SolveError> {
        check(&self.domain.mesh, &self.domain.geometry, &params)?;
        if params == self.params {
            return Ok(());
        }
        let before = (self.params.clone(), self.progress.clone());
        let is_same = params.measures_like(&self.params);
        let progress = &mut self.progress;
        let levels = params.levels;
        let is_cut_off =
            |job: &Job| job.members.iter().any(|&node| progress.state.nodes[node].level >= levels);
        let keeps_job = is_same && !progress.job.as_ref().is_some_and(is_cut_off);
        progress.state.prune(levels);
        if !is_same {
            for node in &mut progress.state.nodes {
                node.is_settled = false;
                node.status = Status::Running;
            }
        }
        if !is_same || levels != self.params.levels || params.is_joint != self.params.is_joint {
            progress.is_joint = false;
        }
        progress.status = Status::Running;
        self.params = params;
        if !keeps_job {
            progress.job = None;
        }
        if self.progress.job.is_none()
            && let Err(error) = self.begin_next()
        {
            (self.params, self.progress) = before;
            self.objective = self.current_objective();
            return Err(error);
        }
        Ok(())
    }

    /// What ε lacks for this mesh, if it does: below [`epsilon_floor`] the interface sticks to triangles.
    pub fn epsilon_notice(&self) -> Option<EpsilonTooSmall> {
        let floor = 2.0 * self.domain.mean_edge;
        let epsilon = self.params.epsilon;
        (epsilon < floor).then_some(EpsilonTooSmall { epsilon, floor })
    }

    /// The mesh that is split.
    pub fn mesh(&self) -> &Mesh {
        &self.domain.mesh
    }

    /// Accepted steps so far.
    pub fn steps(&self) -> usize {
        self.progress.steps
    }

    /// Whether there is more to do.
    pub fn status(&self) -> Status {
        self.progress.status
    }

    /// The split under way and the number of its start; the first of them where all are relaxed together. `None` at the end.
    pub fn current(&self) -> Option<(usize, usize)> {
        self.progress.job.as_ref().map(|job| (job.members[0], job.attempt))
    }

    /// Evaluations of the objective in the start under way: one and a little for each step.
    pub fn evaluations(&self) -> usize {
        self.progress.job.as_ref().map_or(0, |job| job.descent.evaluations)
    }

    /// Numeric factorisations so far, all by one analysis.
    pub fn factorisations(&self) -> usize {
        self.domain.analysis.factorisation_count()
    }

    /// Length, parts and sharp losses of a split as it is now; zeros for a segment that is not split.
    ///
    /// **Costs** one factorisation and one solve.
    pub fn measure(&self, node: usize) -> Result<PhaseMeasures, SolveError> {
        Ok(self.progress.state.measure(&self.domain, node)?)
    }

    /// Log scale factor of the flattening of both sides of a split by the diffuse problem, one value for each vertex: that of either side, held near 0 outside of it, in sum.
    /// Zeros for a segment that is not split.
    ///
    /// **Costs** two factorisations and two solves.
    pub fn scale_factors(&self, node: usize) -> Result<Vec<f64>, SolveError> {
        let mut sum = vec![0.0; self.domain.len()];
        if self.progress.state.nodes.get(node).is_some_and(|n| n.children.is_some()) {
            for s in self.side_scales(node)? {
                sum.iter_mut().zip(s).for_each(|(sum, s)| *sum -= s);
            }
        }
        Ok(sum)
    }

    /// Minus the log scale factor of each side of a split.
    fn side_scales(&self, node: usize) -> Result<[Vec<f64>; 2], SolveError> {
        let domain = &self.domain;
        let split = &self.progress.state.nodes[node];
        let mut solver = Yamabe::default();
        let reach = self.params.reach();
        let (u_faces, w_faces) = (domain.face_means(&split.u), domain.face_means(&split.weight));
        let mut side = |sign: f64| {
            let indicated = |u: &[f64], w: &[f64]| -> Vec<f64> {
                u.iter().zip(w).map(|(u, w)| w * reach(sign * u).0).collect()
            };
            let y = indicated(&split.u, &split.weight);
            let y_faces = indicated(&u_faces, &w_faces);
            solver.solve(domain, [&y, &y_faces], self.params.lambda())
        };
        Ok([side(1.0)?, side(-1.0)?])
    }

    /// The surface refined along the borders of the leaves: points `0..V` are the vertices.
    pub fn cut_mesh(&self) -> CutMesh {
        self.progress.state.cut_mesh_on(&self.domain.mesh, &self.domain.geometry)
    }

    /// The same cut on another triangulation of the same surface with the same vertices.
    pub fn cut_mesh_on(&self, mesh: &Mesh, geometry: &Geometry) -> CutMesh {
        self.progress.state.cut_mesh_on(mesh, geometry)
    }

    /// The leaves as the start of a cut flow.
    pub fn cut_start(&self) -> Initial {
        self.progress.state.cut_start(&self.domain.mesh, self.params.epsilon / self.domain.scale)
    }

    /// What all splits so far cost, under the options as they are now: the interface, distortion, and parts that are not connected. Their sum
    /// is the objective.
    pub fn costs(&self) -> [f64; 3] {
        let prices = self.prices(true);
        let splits = self.progress.state.nodes.iter().filter(|node| node.children.is_some());
        splits.fold([0.0; 3], |[interface, distortion, parts], PhaseNode { terms, .. }| {
            [
                interface + terms.perimeter + terms.penalty,
                distortion + prices.omega * terms.yamabe,
                parts + prices.parts * terms.connectedness,
            ]
        })
    }

    fn prices(&self, is_connected: bool) -> Prices {
        Prices::new(&self.params, is_connected && self.params.is_connected)
    }

    /// The functional of some splits: below one another where several move together.
    fn objective_of(&self, nodes: &[usize], is_connected: bool) -> Objective {
        let tree = &self.progress.state.nodes;
        let members = nodes
            .iter()
            .map(|&node| {
                let above = tree[node].parent.and_then(|parent| {
                    let place = nodes.iter().position(|&n| n == parent)?;
                    let is_positive = tree[parent].children.is_some_and(|c| c[0] == node);
                    Some((place, if is_positive { 1.0 } else { -1.0 }))
                });
                match above {
                    Some((parent, sign)) => Member::below(parent, sign),
                    None => Member::given(tree[node].weight.to_vec()),
                }
            })
            .collect();
        Objective::new(&self.domain, members, self.prices(is_connected))
    }

    fn current_objective(&self) -> Option<Objective> {
        let job = self.progress.job.as_ref()?;
        Some(self.objective_of(&job.members, job.is_connected))
    }

    /// Begins the next search, or ends.
    fn begin_next(&mut self) -> Result<(), SolveError> {
        let whole: f64 = self.domain.mass.iter().sum();
        let nodes = &self.progress.state.nodes;
        let is_worth_it = |weight: &[f64]| dot(weight, &self.domain.mass) > SMALLEST * whole;
        let next = nodes.iter().position(|node| {
            node.level < self.params.levels && !node.is_settled && is_worth_it(&node.weight)
        });
        if let Some(node) = next {
            let is_warm = nodes[node].children.is_some();
            return self.begin(vec![node], 0, is_warm, None);
        }
        let splits: Vec<usize> =
            (0..nodes.len()).filter(|&node| nodes[node].children.is_some()).collect();
        if self.params.is_joint && !self.progress.is_joint && splits.len() > 1 {
            return self.begin(splits, 0, true, None);
        }
        let ends = nodes.iter().filter(|n| n.children.is_some()).map(|n| n.status);
        let mut end = self.progress.joint_end;
        for status in ends {
            if status == Status::Stalled || end == Status::Converged {
                end = status;
            }
        }
        self.progress.status = end;
        self.progress.job = None;
        self.objective = None;
        Ok(())
    }

    /// Begins one start of a search.
    fn begin(
        &mut self,
        members: Vec<usize>,
        attempt: usize,
        is_warm: bool,
        best: Option<Best>,
    ) -> Result<(), SolveError> {
        let nodes = &self.progress.state.nodes;
        let is_connected = is_warm || self.params.warm_up == 0;
        let mut objective = self.objective_of(&members, is_connected);
        let (mut fields, mut directions) = (Vec::new(), Vec::new());
        for &node in &members {
            let weight = &nodes[node].weight;
            let at_hand = is_warm
                .then(|| start::moved(&self.domain, &self.params, weight, &nodes[node].u))
                .flatten();
            match at_hand {
                Some(field) => fields.extend(field),
                None => {
                    let field = start::field(&self.domain, &self.params, weight, node, attempt)?;
                    fields.extend(field);
                }
            }
            let u = &fields[fields.len() - weight.len()..];
            directions.extend(Objective::direction(u, weight));
        }
        let descent = Descent::new(&self.domain, &mut objective, &fields, &directions)?;
        if !descent.at.value.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let history = vec![descent.at.value];
        let job = Job {
            members,
            attempt,
            is_warm,
            iteration: 0,
            is_connected,
            descent,
            history,
            earlier: 0,
            best,
        };
        self.objective = Some(objective);
        self.progress.job = Some(job);
        self.publish();
        Ok(())
    }

    /// Shows the fields of the search under way.
    fn publish(&mut self) {
        let Some(job) = &self.progress.job else { return };
        let n = self.domain.len();
        for (i, &node) in job.members.iter().enumerate() {
            self.progress.state.put(node, &job.descent.at.u[i * n..(i + 1) * n]);
            let node = &mut self.progress.state.nodes[node];
            node.terms = job.descent.at.terms[i];
            node.objective = value_of(&node.terms, &self.params);
        }
    }

    /// One iteration of the search under way. **Gives** how it ended, if it did.
    fn iterate(&mut self) -> Result<Option<Status>, SolveError> {
        let (Some(job), Some(objective)) = (&mut self.progress.job, &mut self.objective) else {
            return Ok(None);
        };
        let moved = job.descent.iterate(&self.domain, objective)?;
        job.iteration += 1;
        if moved {
            job.history.push(job.descent.at.value);
        }
        let value = job.descent.at.value.abs();
        let tolerance = self.params.tolerance;
        let count = job.history.len();
        let is_settled = count > job.earlier + WINDOW
            && job.history[count - 1 - WINDOW] - job.history[count - 1] < tolerance * value;
        Ok(if is_settled {
            Some(Status::Converged)
        } else if !moved {
            // Nothing to gain in any direction is an end like the other; a promise that no step keeps is not.
            let is_flat = job.descent.gradient_norm() <= tolerance * value;
            Some(if is_flat { Status::Converged } else { Status::Stalled })
        } else if job.iteration >= self.params.max_steps {
            Some(Status::StepLimit)
        } else {
            None
        })
    }

    /// Lets unconnected phases cost from here on, if that is due. **Gives** whether it was.
    fn connect(&mut self, is_over: bool) -> Result<bool, SolveError> {
        let Some(job) = &self.progress.job else { return Ok(false) };
        let is_due = is_over || job.iteration >= self.params.warm_up;
        if job.is_connected || !self.params.is_connected || !is_due {
            return Ok(false);
        }
        let mut objective = self.objective_of(&job.members, true);
        let mut descent = job.descent.clone();
        descent.renew(&self.domain, &mut objective)?;
        let Some(job) = &mut self.progress.job else { return Ok(false) };
        job.descent = descent;
        job.is_connected = true;
        job.earlier = job.history.len();
        job.history.push(job.descent.at.value);
        self.objective = Some(objective);
        Ok(true)
    }

    /// Keeps the better of this start and the best before, and begins the next one, the next split, or nothing.
    fn conclude(&mut self, end: Status) -> Result<(), SolveError> {
        let Some(job) = &mut self.progress.job else { return Ok(()) };
        let value = job.descent.at.value;
        let is_better = job.best.as_ref().is_none_or(|best| value < best.value);
        if is_better {
            job.best = Some(Best {
                value,
                u: job.descent.at.u.clone(),
                terms: job.descent.at.terms.clone(),
                history: job.history.clone(),
                end,
            });
        }
        let (members, attempt) = (job.members.clone(), job.attempt + 1);
        if !job.is_warm && attempt < self.params.starts {
            let best = job.best.take();
            return self.begin(members, attempt, false, best);
        }
        let Some(mut best) = job.best.take() else { return Ok(()) };
        if self.params.is_connected {
            self.give_up_islands(&members, &mut best)?;
        }
        let n = self.domain.len();
        let is_single = members.len() == 1;
        for (i, &node) in members.iter().enumerate() {
            self.progress.state.put(node, &best.u[i * n..(i + 1) * n]);
        }
        for (i, &node) in members.iter().enumerate() {
            if !(self.params.omega > 0.0) {
                // What it costs nothing is worth knowing all the same.
                let mass = &self.domain.mass;
                let loss =
                    |s: Vec<f64>| -> f64 { s.iter().zip(mass).map(|(s, m)| s * s * m).sum() };
                best.terms[i].yamabe = self.side_scales(node)?.map(loss).iter().sum();
            }
            let node = &mut self.progress.state.nodes[node];
            node.terms = best.terms[i];
            node.objective = value_of(&node.terms, &self.params);
            node.is_settled = true;
            if is_single {
                node.history.clone_from(&best.history);
                node.status = best.end;
            }
        }
        if is_single {
            self.progress.is_joint = false;
        } else {
            self.progress.is_joint = true;
            self.progress.joint_end = best.end;
        }
        self.begin_next()
    }

    /// Gives up the islands of finished splits; their areas stay what was asked for.
    fn give_up_islands(&mut self, members: &[usize], best: &mut Best) -> Result<(), SolveError> {
        let n = self.domain.len();
        let e1 = edge(self.params.epsilon);
        for _ in 0..ISLANDS {
            let mut is_changed = false;
            let mut directions = Vec::with_capacity(best.u.len());
            for (&node, u) in members.iter().zip(best.u.chunks_mut(n)) {
                let state = &mut self.progress.state;
                state.put(node, u);
                if let Some(without) = state.give_up_islands(&self.domain.mesh, node, e1) {
                    u.copy_from_slice(&without);
                    is_changed = true;
                }
                directions.extend(Objective::direction(u, &state.nodes[node].weight));
            }
            let Some(objective) = self.objective.as_mut().filter(|_| is_changed) else { break };
            let at = objective.evaluate(&self.domain, &best.u, &directions)?;
            (best.u, best.terms) = (at.u, at.terms);
        }
        Ok(())
    }

    fn report(&self) -> StepReport {
        let nodes = &self.progress.state.nodes;
        let shown: Vec<usize> = match &self.progress.job {
            Some(job) => job.members.clone(),
            None => (0..nodes.len()).filter(|&n| nodes[n].children.is_some()).collect(),
        };
        let sum = |term: fn(&SplitTerms) -> f64| -> f64 {
            shown.iter().map(|&n| term(&nodes[n].terms)).sum()
        };
        let prices = self.prices(true);
        let value = match &self.progress.job {
            Some(job) => job.descent.at.value,
            None => shown.iter().map(|&n| nodes[n].objective).sum(),
        };
        let worst = shown.iter().map(|&n| nodes[n].terms.area_error).fold(0.0, f64::max);
        let splits = (1usize << self.params.levels) - 1;
        let done = nodes.iter().filter(|n| n.is_settled).count();
        StepReport {
            step: self.progress.steps,
            energy: vec![
                ("objective", value),
                ("perimeter", sum(|t| t.perimeter)),
                ("outside", sum(|t| t.penalty)),
                ("connectedness", prices.parts * sum(|t| t.connectedness)),
                ("distortion", prices.omega * sum(|t| t.yamabe)),
            ],
            residual: worst,
            progress: Some((done as f32 / splits as f32).min(1.0)),
            status: self.progress.status,
        }
    }
}

/// The objective of one split.
fn value_of(terms: &SplitTerms, params: &PhaseFieldParams) -> f64 {
    let prices = Prices::new(params, params.is_connected);
    terms.perimeter
        + terms.penalty
        + prices.omega * terms.yamabe
        + prices.parts * terms.connectedness
}

/// Refuses options that do not go with a surface.
fn check(mesh: &Mesh, geometry: &Geometry, params: &PhaseFieldParams) -> Result<(), SolveError> {
    params.validate()?;
    if let Start::Values(values) = &params.start
        && values.len() != mesh.vertex_count()
    {
        let count = mesh.vertex_count() as f64;
        let (name, value) = ("number of start values", values.len() as f64);
        return Err(SolveError::Parameter { name, value, min: count, max: count });
    }
    let (epsilon, floor) = (params.epsilon, epsilon_floor(geometry));
    // Below one edge the interface does not move any more.
    if epsilon < 0.5 * floor {
        return Err(SolveError::EpsilonTooSmall { epsilon, floor });
    }
    Ok(())
}

impl Flow for PhaseFieldFlow {
    type State = PhaseFieldState;

    fn state(&self) -> &PhaseFieldState {
        &self.progress.state
    }

    /// One iteration; with it may go the end of a start and the evaluation of the next one. After an error the state is the last accepted one.
    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.progress.status != Status::Running {
            return Ok(self.report());
        }
        self.advance()?;
        Ok(self.report())
    }
}

impl PhaseFieldFlow {
    fn advance(&mut self) -> Result<(), SolveError> {
        self.connect(false)?;
        let end = self.iterate()?;
        self.progress.steps += 1;
        self.publish();
        if let Some(end) = end
            && !(end != Status::StepLimit && self.connect(true)?)
        {
            let before = self.progress.clone();
            if let Err(error) = self.conclude(end) {
                self.progress = before;
                self.objective = self.current_objective();
                return Err(error);
            }
        }
        Ok(())
    }
}
