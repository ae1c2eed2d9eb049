//! Developable preview: the surface that the flat pieces make when they are sewn together again.
//!
//! **Minimises**, over places x of the points of a cut surface in space,
//! E(x) = 1/A Σ |t| ‖∇x_t − R_t‖² + β Σ 3/(|s| + |t|) ‖K x‖² + μ/A² Σ a_p ‖x_p − x⁰_p‖².
//! *Isometry*: ∇x_t is the map of the flat triangle t to space, R_t the isometry nearest to it, so that the term is
//! Σ|t| ((σ₁ − 1)² + (σ₂ − 1)²) with the singular values σ of ∇x_t; it vanishes where the pieces keep all their lengths. Both
//! sides of a seam share their points. *Bending*: over hinges between triangles s, t inside a piece; ‖Kx‖ is length × angle of the
//! fold. Pieces are flat at rest and seams fold freely. *Pull*: a weak spring from each point to its place on the original.
//! Many shapes have the same lengths (a sheet of paper has any number): the pull chooses the one nearest to the original, and
//! it is what makes surplus length wrinkle instead of sagging. Everything is divided by the area A: weights have no unit.
//!
//! **Step**: with all R_t held fixed E is a quadratic form that lies above E and touches it; its matrix is factored once.
//! That metric turns the gradient of E into a direction, L-BFGS improves it, and a line search takes it if E falls. One
//! solve with three right-hand sides for each step, two where the memory has failed.
//!
//! **Ends** when ten steps together lower E by less than a fraction.
//!
//! Guaranteed: E never rises; rigid motion is taken out ([`FoldFlow::positions`] lie as near the original as turning and
//! shifting each component allows); slivers along cuts neither stop the flow nor hold it (their weight is bounded). Not
//! guaranteed: the global minimum (there are many: each pattern of wrinkles is one); freedom from self-intersection: paper
//! passes through paper.
//!
//! **From** the developable surfaces of [VSC] (Fig. 6, 15); Sorkine, Alexa: *As-Rigid-As-Possible Surface Modeling*, 2007;
//! Bergou et al.: *A Quadratic Bending Model for Inextensible Surfaces*, 2006; Liu, Bouaziz, Kavan: *Quasi-Newton Methods for
//! Real-Time Simulation of Hyperelastic Materials*, 2017.

mod memory;
mod place;
mod sheet;

use std::sync::Arc;

use nalgebra::Point3;

use super::Flattening;
use crate::linalg::{Analysis, Factor, add, dot};
use crate::mesh::OpenedMesh;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

use memory::Memory;
use sheet::Sheet;

pub use place::FoldMeasures;

/// Options of a [`FoldFlow`]. All are for a surface of unit area; other surfaces behave as if they were scaled to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldParams {
    /// β: stiffness against bending inside pieces, that of a sheet √(12 β) thick. Much less lets wrinkles shrink to single
    /// edges, much more irons them out.
    pub bending: f64,
    /// μ: pull of every point towards its original place. 0 leaves the pieces to themselves, and they settle like slack
    /// paper: the halves of a sphere become a flat pillow case. At 0.3 they are a stuffed ball with pleats around its seam and
    /// 1 % of stretch, at 1 a rounder one with 3 %.
    pub pull: f64,
    /// Largest seeded disturbance of the start along the normals, in mean edge lengths. A perfectly even shape under
    /// pressure does not know where to buckle.
    pub kick: f64,
    /// Seed of that disturbance.
    pub seed: u64,
    /// The run has converged when the last ten steps together lowered E by less than this fraction.
    pub tolerance: f64,
}

impl Default for FoldParams {
    fn default() -> Self {
        Self { bending: 1e-7, pull: 0.3, kick: 0.05, seed: 1, tolerance: 1e-3 }
    }
}

impl FoldParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        within("bending stiffness", self.bending, 0.0, 1.0)?;
        within("pull", self.pull, 0.0, 1e3)?;
        within("kick", self.kick, 0.0, 2.0)?;
        within("tolerance", self.tolerance, 0.0, 1.0)
    }
}

/// The energy of a placing and its terms, weights included, without unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoldEnergy {
    /// Sum of the terms.
    pub total: f64,
    /// Mean of (σ₁ − 1)² + (σ₂ − 1)² over the flat area.
    pub isometry: f64,
    /// Of hinges inside pieces.
    pub bending: f64,
    /// Of distances from the original.
    pub pull: f64,
}

/// A folded surface.
#[derive(Clone, Debug, PartialEq)]
pub struct FoldState {
    positions: Vec<Point3<f64>>,
    energy: FoldEnergy,
}

impl FoldState {
    /// Place of every point, each component as near the original as rigid motion allows.
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.positions
    }

    /// The energy and its terms.
    pub fn energy(&self) -> FoldEnergy {
        self.energy
    }
}

/// An energy below this is rounding of coordinates: strains of 1e-10.
const NOTHING: f64 = 1e-20;

/// Trials of one line search. A step of full length lowers E unless the memory misleads; 2⁻⁶ of a misled step is none.
const TRIALS: usize = 7;

/// Steps without memory may be doubled so many times: away from a saddle the metric takes small ones.
const DOUBLINGS: usize = 3;

/// The steps whose progress tells convergence.
const WINDOW: usize = 10;

/// The flow. Made from a cut surface and its charts.
pub struct FoldFlow {
    params: FoldParams,
    sheet: Sheet,
    factor: Factor,
    metric: Vec<f64>,
    /// Coordinate by coordinate, before alignment.
    x: Vec<f64>,
    gradient: Vec<f64>,
    state: FoldState,
    progress: Progress,
    status: Status,
}

/// What a step remembers for the next one, apart from the state.
#[derive(Clone, Debug, Default)]
struct Progress {
    step: usize,
    memory: Memory,
    residual: f64,
    /// E after every step, for the test of convergence.
    history: Vec<f64>,
}

/// Everything needed to go on from a step.
#[derive(Clone, Debug)]
pub struct FoldCheckpoint {
    x: Vec<f64>,
    progress: Progress,
    status: Status,
}

impl FoldFlow {
    /// Prepares a run: lays every triangle flat, factors the metric, disturbs the start.
    ///
    /// **Takes** a cut surface; the original place of each of its points; charts in the same unit. Triangles of patches without
    /// chart keep their lengths in space. Points without triangles stay where they are.
    /// **Fails** if parameters are out of range, if places that are used are not finite or make no surface, or if the
    /// factorisation fails. **Costs** one analysis and one factorisation of V rows, a dozen entries each.
    pub fn new(
        opened: &OpenedMesh,
        points: &[Point3<f64>],
        flattening: &Flattening,
        params: FoldParams,
    ) -> Result<Self, SolveError> {
        params.validate()?;
        assert_eq!(flattening.uv.len(), opened.mesh.vertex_count());
        assert!(opened.vertex_points.iter().all(|&p| (p as usize) < points.len()));
        let sheet = Sheet::new(opened, points, flattening, &params);
        // An area that overflows or vanishes has no scale to divide by.
        if !(sheet.area > 1e-200 && sheet.area < 1e200)
            || sheet.origin.iter().any(|x| !x.is_finite())
        {
            return Err(SolveError::NotFinite);
        }
        let (pattern, metric) = sheet.majorizer();
        let factor = Factor::new(Arc::new(Analysis::new(pattern)?), &metric)?;
        let mut x = sheet.origin.clone();
        disturb(&sheet, &params, &mut x);
        let mut flow = Self {
            params,
            sheet,
            factor,
            metric,
            gradient: vec![0.0; x.len()],
            x,
            state: FoldState { positions: Vec::new(), energy: FoldEnergy::default() },
            progress: Progress::default(),
            status: Status::Running,
        };
        flow.evaluate();
        let total = flow.state.energy.total;
        if !total.is_finite() {
            return Err(SolveError::NotFinite);
        }
        flow.progress.history = vec![total];
        if total < NOTHING {
            flow.status = Status::Converged;
        }
        Ok(flow)
    }

    /// Place of every point, each component as near the original as rigid motion allows.
    pub fn positions(&self) -> &[Point3<f64>] {
        &self.state.positions
    }

    /// How far the folded surface is from the original, and what stretch is left. **Costs** O(V + F).
    pub fn measures(&self) -> FoldMeasures {
        let [distance_mean, distance_max] = place::distances(&self.sheet, &self.state.positions);
        FoldMeasures { stretch: self.sheet.stretch(&self.x), distance_mean, distance_max }
    }

    /// Options in use.
    pub fn params(&self) -> &FoldParams {
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

    /// What is needed to go on from here.
    pub fn checkpoint(&self) -> FoldCheckpoint {
        FoldCheckpoint { x: self.x.clone(), progress: self.progress.clone(), status: self.status }
    }

    /// Goes back to a checkpoint of a flow on the same surface. Later steps repeat bit for bit.
    pub fn restore(&mut self, checkpoint: &FoldCheckpoint) {
        assert_eq!(checkpoint.x.len(), self.x.len(), "a checkpoint of another surface");
        self.x.clone_from(&checkpoint.x);
        self.progress = checkpoint.progress.clone();
        self.status = checkpoint.status;
        self.evaluate();
    }

    /// dE along a displacement of each point by the gradient that steps use, and E after a displacement by `length`
    /// times it: what tests compare.
    pub fn directional_derivative(
        &self,
        direction: impl Fn(usize) -> [f64; 3],
        length: f64,
    ) -> (f64, f64) {
        let n = self.state.positions.len();
        let mut d = vec![0.0; 3 * n];
        for p in 0..n {
            for (axis, value) in direction(p).into_iter().enumerate() {
                d[axis * n + p] = value;
            }
        }
        let predicted = dot(&self.gradient, &d);
        let mut moved = self.x.clone();
        add(&mut moved, length, &d);
        (predicted, self.sheet.energy(&moved, None).total)
    }

    /// Energy, gradient and aligned places of the accepted coordinates.
    fn evaluate(&mut self) {
        self.state.energy = self.sheet.energy(&self.x, Some(&mut self.gradient));
        self.state.positions = place::align(&self.sheet, &self.x);
    }

    /// A direction that descends, and the slope along it.
    fn direction(&mut self) -> Result<(Vec<f64>, f64), SolveError> {
        let Self { factor, metric, gradient, progress, .. } = self;
        let Progress { memory, residual, .. } = progress;
        let n = gradient.len() / 3;
        let d = memory.direction(gradient, |rhs| {
            let wanted = rhs.to_vec();
            factor.solve(rhs, 3);
            *residual = relative_residual(factor, metric, rhs, &wanted, n);
            if residual.is_finite() { Ok(()) } else { Err(SolveError::NotFinite) }
        })?;
        let slope = dot(&d, gradient);
        Ok((d, slope))
    }

    /// Tries one direction. **Gives** whether E fell.
    fn descend(&mut self) -> Result<bool, SolveError> {
        let is_plain = self.progress.memory.is_empty();
        let (direction, slope) = self.direction()?;
        // Not `>=`: a slope that is no number is none.
        if !(slope < 0.0) {
            return Ok(false);
        }
        let before = self.state.energy.total;
        let mut gradient = vec![0.0; self.x.len()];
        let mut x = self.x.clone();
        let mut length = 1.0;
        let trial = |length: f64, x: &mut Vec<f64>, gradient: &mut Vec<f64>| {
            x.copy_from_slice(&self.x);
            add(x, length, &direction);
            self.sheet.energy(x, Some(gradient))
        };
        let mut energy = trial(length, &mut x, &mut gradient);
        for _ in 1..TRIALS {
            if energy.total < before + 1e-4 * length * slope {
                break;
            }
            length *= 0.5;
            energy = trial(length, &mut x, &mut gradient);
        }
        if !(energy.total < before) {
            return Ok(false);
        }
        if is_plain && length > 0.9 {
            let (mut wider, mut wider_gradient) = (x.clone(), gradient.clone());
            for _ in 0..DOUBLINGS {
                let next = trial(2.0 * length, &mut wider, &mut wider_gradient);
                if !(next.total < energy.total) {
                    break;
                }
                length *= 2.0;
                energy = next;
                std::mem::swap(&mut x, &mut wider);
                std::mem::swap(&mut gradient, &mut wider_gradient);
            }
        }
        let step: Vec<f64> = x.iter().zip(&self.x).map(|(new, old)| new - old).collect();
        let change: Vec<f64> =
            gradient.iter().zip(&self.gradient).map(|(new, old)| new - old).collect();
        self.progress.memory.record(step, change);
        self.x = x;
        self.gradient = gradient;
        self.state = FoldState { positions: place::align(&self.sheet, &self.x), energy };
        Ok(true)
    }

    fn report(&self) -> StepReport {
        let energy = self.state.energy;
        StepReport {
            step: self.progress.step,
            energy: vec![
                ("total", energy.total),
                ("isometry", energy.isometry),
                ("bending", energy.bending),
                ("pull", energy.pull),
            ],
            residual: self.progress.residual,
            progress: None,
            status: self.status,
        }
    }
}

impl Flow for FoldFlow {
    type State = FoldState;

    fn state(&self) -> &FoldState {
        &self.state
    }

    /// One step down. A memory that misleads is forgotten within the step.
    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status != Status::Running {
            return Ok(self.report());
        }
        let mut moved = self.descend()?;
        if !moved && !self.progress.memory.is_empty() {
            self.progress.memory.clear();
            moved = self.descend()?;
        }
        if !moved {
            // The metric's own step lowers E unless rounding hides what is left.
            self.status = Status::Converged;
            return Ok(self.report());
        }
        let total = self.state.energy.total;
        self.progress.step += 1;
        if self.progress.history.len() > WINDOW {
            self.progress.history.remove(0);
        }
        self.progress.history.push(total);
        if self.progress.history.len() > WINDOW {
            let before = self.progress.history[0];
            if before - total < self.params.tolerance * before {
                self.status = Status::Converged;
            }
        }
        if total < NOTHING {
            self.status = Status::Converged;
        }
        Ok(self.report())
    }
}

/// ‖A x − b‖ / ‖b‖ over three right-hand sides.
fn relative_residual(factor: &Factor, metric: &[f64], x: &[f64], b: &[f64], n: usize) -> f64 {
    let mut product = vec![0.0; n];
    let (mut error, mut size) = (0.0, 0.0);
    for (x, b) in x.chunks_exact(n).zip(b.chunks_exact(n)) {
        factor.analysis().pattern().multiply(metric, x, &mut product);
        error += product.iter().zip(b).map(|(p, b)| (p - b) * (p - b)).sum::<f64>();
        size += dot(b, b);
    }
    if size > 0.0 { (error / size).sqrt() } else { 0.0 }
}

/// Moves every point along its normal by a seeded amount, even between − and + the kick.
fn disturb(sheet: &Sheet, params: &FoldParams, x: &mut [f64]) {
    if params.kick > 0.0 {
        let n = x.len() / 3;
        let size = params.kick * sheet.mean_edge();
        for (p, normal) in sheet.normals().into_iter().enumerate() {
            let amount = size * noise(params.seed, p as u64);
            for axis in 0..3 {
                x[axis * n + p] += amount * normal[axis];
            }
        }
    }
}

/// A number between −1 and 1 for each index, by the mixing steps of SplitMix64 (Steele, Lea, Flood 2014).
fn noise(seed: u64, index: u64) -> f64 {
    let mut z = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
