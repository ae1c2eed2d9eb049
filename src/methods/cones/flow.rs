//! The flow: one round after another until the optimum is certified, for one λ after another.

use super::aim::Search;
use super::certificate::Certificate;
use super::error::{ConeConflict, ConeError};
use super::extent;
use super::greens::{self, Dictionary};
use super::params::{Cone, ConeEvaluation, ConeFields, ConeParams, ConeState, ConeTarget};
use super::problem::{ActiveSet, Problem};
use super::system::{NONE, Response};
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Excess of |φ| over λ w, in λ, that is none. Rounding in φ is about 1e-13 of its size, and φ is of the size of λ_max.
const TOLERANCE: f64 = 1e-10;

/// Residual above which a finished optimum is polished further, as long as that helps.
const POLISHED: f64 = 1e-10;

/// Angles let free in one round: at least so many, and a share of those that are free already. With fewer there are more rounds,
/// with more there are columns that nobody needs.
const FEWEST_NEW: usize = 6;

/// Optimal cones, one bounded step at a time.
///
/// **Minimises** ½ ∫ w_E u² + λ Σ w_R |μ|, exactly. **Step** one round of the active set (a few Green's functions, a small dense
/// problem, one solve for φ) or one Newton step (one factorisation). Every state in the range of Green's functions is feasible, and
/// the objective falls from step to step; Newton's steps may rise. **Ends** `Converged` at the certified optimum; `Infeasible` when [`ConeFlow::aim`]
/// cannot be met (the state is then the nearest); `Stalled` where rounding ends progress before the certificate is good.
pub struct ConeFlow {
    pub(super) problem: Problem,
    pub(super) fields: ConeFields,
    pub(super) dictionary: Dictionary,
    pub(super) progress: Progress,
    response: Response,
    certificate: Certificate,
    lambda_max: Vec<f64>,
    state: ConeState,
}

/// All that a step depends on besides the problem.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Progress {
    pub set: ActiveSet,
    pub status: Status,
    pub steps: usize,
    /// Whether nothing is left to move within the dictionary at this λ.
    pub is_settled: bool,
    /// Whether u and φ were refined.
    pub is_refined: bool,
    /// Whether the last round moved nothing although several angles were let free.
    pub is_stuck: bool,
    /// Rounds that polished.
    pub polished: usize,
    pub search: Option<Search>,
}

/// Where a [`ConeFlow`] can go back to.
#[derive(Clone, Debug, PartialEq)]
pub struct ConeCheckpoint {
    lambda: f64,
    progress: Progress,
    history: Vec<Vec<u32>>,
    lambda_max: Vec<f64>,
}

impl ConeFlow {
    /// Assembles, factors and looks at the surface without cones.
    ///
    /// **Takes** any surface; λ is meant for unit area. **Fails** on parameters out of range, on fields of wrong length or value, on
    /// prescribed cones that contradict each other, and where the bounds exclude what Gauss–Bonnet asks for.
    /// **Costs** one factorisation and two responses.
    pub fn new(
        mesh: &Mesh,
        geometry: &Geometry,
        params: &ConeParams,
        fields: &ConeFields,
    ) -> Result<Self, SolveError> {
        let mut problem = Problem::new(mesh, geometry, params, fields)?;
        let dictionary = Dictionary::new(problem.system.len());
        let set = problem.start.clone();
        let (response, certificate) = problem.assess(&set, false);
        if !certificate.objective.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let lambda_max = extent::estimate(&mut problem, &response.phi);
        let mut flow = Self {
            problem,
            fields: fields.clone(),
            dictionary,
            progress: Progress::new(set),
            response,
            certificate,
            lambda_max,
            state: ConeState::default(),
        };
        flow.picture();
        Ok(flow)
    }

    /// The price from which on nothing changes: above it there are no cones, or, on a closed surface with χ ≠ 0, as little total
    /// angle as there can be. Exact for surfaces with boundary and for tori whose cones are not free; on other closed surfaces an estimate
    /// until an optimum above it has been found. 0 on convex closed surfaces.
    pub fn lambda_max(&self) -> f64 {
        self.lambda_max.iter().copied().fold(0.0, f64::max)
    }

    /// Options in force.
    pub fn params(&self) -> &ConeParams {
        &self.problem.params
    }

    /// How it stands.
    pub fn status(&self) -> Status {
        self.progress.status
    }

    /// Accepted steps since it was made.
    pub fn steps(&self) -> usize {
        self.progress.steps
    }

    /// Right-hand sides solved for since it was made.
    pub fn solves(&self) -> usize {
        self.problem.system.solves
    }

    /// Numeric factorisations since it was made.
    pub fn factorisations(&self) -> usize {
        self.problem.system.factorisations
    }

    /// Goes on with another price, from the cones that there are. **Fails** on a price out of range.
    pub fn set_lambda(&mut self, lambda: f64) -> Result<(), SolveError> {
        ConeParams { lambda, ..self.problem.params }.validate()?;
        self.progress.search = None;
        self.change_lambda(lambda);
        Ok(())
    }

    fn change_lambda(&mut self, lambda: f64) {
        self.problem.params.lambda = lambda;
        self.progress.wake();
        let set = &self.progress.set;
        self.certificate = super::certificate::certify(&mut self.problem, set, &self.response);
        self.picture();
    }

    /// Goes on until the optimum has what is asked for.
    pub fn aim(&mut self, target: ConeTarget) -> Result<(), SolveError> {
        match target {
            ConeTarget::Lambda(lambda) => return self.set_lambda(lambda),
            ConeTarget::Count(_) => {}
            ConeTarget::TotalAngle(value) if value >= 0.0 && value < f64::INFINITY => {}
            ConeTarget::Distortion(value) if value >= 0.0 && value < f64::INFINITY => {}
            ConeTarget::TotalAngle(value) => {
                return Err(out_of_range("total cone angle", value));
            }
            ConeTarget::Distortion(value) => return Err(out_of_range("distortion", value)),
        }
        self.progress.search = Some(Search::new(target));
        if self.progress.status != Status::Running {
            // Looks at the optimum at hand first.
            self.progress.status = Status::Running;
        }
        Ok(())
    }

    /// What it takes to come back to where it is: cones and the names of the Green's functions, not these themselves.
    pub fn checkpoint(&self) -> ConeCheckpoint {
        ConeCheckpoint {
            lambda: self.problem.params.lambda,
            progress: self.progress.clone(),
            history: self.dictionary.history(),
            lambda_max: self.lambda_max.clone(),
        }
    }

    /// Goes back to a checkpoint of a flow on the same surface with the same fields. Later steps repeat bit for bit.
    pub fn restore(&mut self, checkpoint: &ConeCheckpoint) -> Result<(), SolveError> {
        self.problem.params.lambda = checkpoint.lambda;
        self.progress = checkpoint.progress.clone();
        self.dictionary.recall(&mut self.problem, &checkpoint.history);
        self.lambda_max.clone_from(&checkpoint.lambda_max);
        let set = &self.progress.set;
        (self.response, self.certificate) = self.problem.assess(set, self.progress.is_refined);
        self.picture();
        Ok(())
    }

    /// What other cones are worth.
    ///
    /// **Takes** cones (repeated vertices add up) whose angles add up to 2πχ on every closed component. Where the boundary's curvature
    /// is an unknown, cones on the boundary are its corners; if there are none, those of the present state stay.
    /// **Fails** where Gauss–Bonnet is missed by more than 1e-6, and on cones where none can be. **Costs** one response.
    pub fn evaluate(&mut self, cones: &[Cone]) -> Result<ConeEvaluation, SolveError> {
        let vertices = self.problem.system.mass.len();
        let mut angles = vec![0.0; self.problem.system.len()];
        let mut has_corners = false;
        for &Cone { vertex, angle } in cones {
            if vertex.index() >= vertices {
                return Err(SolveError::NoSuchVertex { vertex, vertices });
            }
            match self.problem.system.dof_of[vertex.index()] {
                NONE => {
                    let conflict = ConeConflict::Boundary;
                    return Err(ConeError::Conflict { vertex, angle, conflict }.into());
                }
                i => {
                    angles[i as usize] += angle;
                    has_corners |= !self.problem.is_inside[i as usize];
                }
            }
        }
        if !has_corners {
            for (i, angle) in angles.iter_mut().enumerate() {
                if !self.problem.is_inside[i] {
                    *angle = self.progress.set.angles[i];
                }
            }
        }
        for (c, component) in self.problem.system.components.iter().enumerate() {
            let members =
                (0..angles.len()).filter(|&i| self.problem.system.component_of[i] as usize == c);
            let total: f64 = members.clone().map(|i| angles[i]).sum();
            if component.is_floating && !((total - component.total).abs() < 1e-6) {
                let vertex = members
                    .map(|i| VertexId(self.problem.system.dofs[i]))
                    .next()
                    .unwrap_or_default();
                return Err(
                    ConeError::GaussBonnet { vertex, total, needed: component.total }.into()
                );
            }
        }
        let response = self.problem.system.respond(&angles, true);
        let total_angle =
            angles.iter().zip(&self.problem.is_inside).filter(|p| *p.1).map(|p| p.0.abs()).sum();
        let u: Vec<f64> = response.u.iter().map(|u| -u).collect();
        Ok(ConeEvaluation { int_u2: self.int_u2(&u), u, total_angle })
    }

    fn int_u2(&self, u: &[f64]) -> f64 {
        u.iter().zip(&self.problem.system.plain_mass).map(|(u, m)| m * u * u).sum()
    }

    /// Makes the public state from what is known.
    fn picture(&mut self) {
        let system = &self.problem.system;
        let set = &self.progress.set;
        let (mut cones, mut corners) = (Vec::new(), Vec::new());
        for (i, &angle) in set.angles.iter().enumerate() {
            if angle != 0.0 {
                let cone = Cone { vertex: VertexId(system.dofs[i]), angle };
                if self.problem.is_inside[i] { &mut cones } else { &mut corners }.push(cone);
            }
        }
        let shifted = greens::shifted(&self.problem, set, &self.response);
        let mut phi = vec![0.0; system.mass.len()];
        for (&v, value) in system.dofs.iter().zip(shifted) {
            phi[v as usize] = value;
        }
        let u: Vec<f64> = self.response.u.iter().map(|u| -u).collect();
        let certificate = self.certificate;
        self.state = ConeState {
            lambda: self.problem.params.lambda,
            total_angle: cones.iter().map(|c| c.angle.abs()).sum(),
            int_u2: self.int_u2(&u),
            cones,
            corners,
            u,
            phi,
            objective: certificate.objective,
            gap: certificate.gap,
            violation: certificate.violation,
            residual: certificate.residual(),
            is_convex: self.problem.is_convex,
        };
    }

    fn tolerance(&self) -> f64 {
        TOLERANCE * self.problem.params.lambda
    }

    /// One round over Green's functions.
    fn greens_round(&mut self) -> Result<(), SolveError> {
        let tolerance = self.tolerance();
        let mut set = self.progress.set.clone();
        let phi = greens::shifted(&self.problem, &set, &self.response);
        let free = set.order.len();
        if self.progress.is_settled {
            let limit = if self.progress.is_stuck { 1 } else { FEWEST_NEW.max(free / 2) };
            let entering = greens::entering(&self.problem, &set, &phi, tolerance, limit);
            if entering.is_empty() {
                return self.polish();
            }
            for (i, sign) in entering {
                set.release(i, sign);
            }
        }
        let order = set.order.clone();
        self.dictionary.add(&mut self.problem, &order);
        let entered = order.len() - free;
        let settled = greens::settle(&self.problem, &self.dictionary, &mut set, &phi, tolerance);
        let (response, certificate) = self.problem.assess(&set, false);
        if !certificate.objective.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let is_still = settled.moved == 0.0;
        if is_still && entered == 1 {
            // The one angle whose direction is certain did not move: rounding.
            return self.polish();
        }
        self.progress.is_stuck = is_still && entered > 1;
        self.progress.is_settled = settled.is_done;
        self.progress.is_refined = false;
        self.progress.set = set;
        self.response = response;
        self.certificate = certificate;
        Ok(())
    }

    /// Nothing is left to be let free: refine, and end if that changes nothing.
    fn polish(&mut self) -> Result<(), SolveError> {
        if !self.progress.is_refined {
            let set = &self.progress.set;
            (self.response, self.certificate) = self.problem.assess(set, true);
            self.progress.is_refined = true;
            if self.certificate.violation > TOLERANCE && self.progress.polished < 3 {
                self.progress.polished += 1;
                return Ok(());
            }
        }
        if self.certificate.support > POLISHED && self.progress.polished < 3 {
            self.progress.polished += 1;
            self.progress.is_settled = false;
            return Ok(());
        }
        self.progress.status =
            if self.certificate.residual() < 1e-7 { Status::Converged } else { Status::Stalled };
        Ok(())
    }

    /// Learns λ_max from an optimum, and goes on to the next λ of a search.
    fn conclude(&mut self) {
        let set = &self.progress.set;
        let phi = greens::shifted(&self.problem, set, &self.response);
        let told = extent::from_optimum(&self.problem, set, &phi);
        for (old, new) in self.lambda_max.iter_mut().zip(told) {
            *old = new.unwrap_or(*old);
        }
        let most = self.lambda_max().max(f64::MIN_POSITIVE);
        if let Some(mut search) = self.progress.search.take() {
            // Above λ_max nothing changes; far below, every vertex is a cone.
            let next = search.next(&self.state, [1e-6 * most, most]);
            match next {
                Some(lambda) => {
                    self.progress.search = Some(search);
                    self.change_lambda(lambda);
                }
                None if !search.is_reached => self.progress.status = Status::Infeasible,
                None => {}
            }
        }
    }
}

impl Progress {
    pub fn new(set: ActiveSet) -> Self {
        Self {
            is_settled: set.order.is_empty(),
            set,
            status: Status::Running,
            steps: 0,
            is_refined: false,
            is_stuck: false,
            polished: 0,
            search: None,
        }
    }

    /// Forgets that an optimum was found.
    fn wake(&mut self) {
        self.status = Status::Running;
        self.is_settled = self.set.order.is_empty();
        self.is_stuck = false;
        self.polished = 0;
    }
}

fn out_of_range(name: &'static str, value: f64) -> SolveError {
    SolveError::Parameter { name, value, min: 0.0, max: f64::MAX }
}

impl Flow for ConeFlow {
    type State = ConeState;

    fn state(&self) -> &ConeState {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.progress.status == Status::Running {
            self.greens_round()?;
            self.progress.steps += 1;
            self.picture();
            if self.progress.status == Status::Converged {
                self.conclude();
            }
        }
        let state = &self.state;
        Ok(StepReport {
            step: self.progress.steps,
            energy: vec![
                ("objective", state.objective),
                ("½∫u²", self.certificate.distortion),
                ("λ·total angle", state.objective - self.certificate.distortion),
            ],
            residual: state.residual,
            progress: None,
            status: self.progress.status,
        })
    }
}
