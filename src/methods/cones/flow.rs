//! The flow: one round after another until the optimum is certified, for one λ after another.

use super::aim::Search;
use super::certificate::Certificate;
use super::coarse::Coarse;
use super::error::{ConeConflict, ConeError};
use super::extent::{self, Extent};
use super::greens::{self, Dictionary};
use super::newton::Descent;
use super::params::{Cone, ConeEvaluation, ConeFields, ConeParams, ConeState, ConeTarget};
use super::problem::{ActiveSet, Problem};
use super::system::{NONE, Response};
use super::two_ring::TwoRing;
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Ratio of two prices up to which the cones of one are a start for Newton's method at the other.
const NEAR: f64 = 1.5;

/// Green's functions that are remembered beyond those in use: k² numbers, 32 MB.
const MOST_REMEMBERED: usize = 2048;

/// Optimal cones, one bounded step at a time.
///
/// **Minimises** ½ ∫ w_E u² + λ Σ w_R |μ|, exactly. **Step** one round of the active set (a few Green's functions, a small dense
/// problem, one solve for φ) or one Newton step (one factorisation, the first also an analysis). Every state in the range of Green's functions is feasible, and
/// the objective falls from step to step; Newton's steps may rise. **Ends** `Converged` at the certified optimum; `Infeasible` when [`ConeFlow::aim`]
/// cannot be met (the state is then the nearest); `Stalled` where rounding ends progress before the certificate is good.
pub struct ConeFlow {
    pub(super) mesh: Mesh,
    pub(super) geometry: Geometry,
    pub(super) fields: ConeFields,
    pub(super) problem: Problem,
    pub(super) dictionary: Dictionary,
    /// The two-ring matrix, once it is needed.
    pub(super) two_ring: Option<TwoRing>,
    pub(super) coarse: Option<Coarse>,
    pub(super) progress: Progress,
    pub(super) response: Response,
    pub(super) certificate: Certificate,
    pub(super) lambda_max: Vec<Extent>,
    pub(super) state: ConeState,
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
    /// Columns computed since λ was changed.
    pub columns: usize,
    /// Whether the angles at hand are near an optimum.
    pub is_warm: bool,
    /// Where Newton's method is, if it is at work.
    pub descent: Option<Descent>,
    /// Whether Newton's method has given up on this λ.
    pub is_lost: bool,
    /// Whether the coarse surface has said what it can.
    pub is_fine: bool,
    pub search: Option<Search>,
}

/// Where a [`ConeFlow`] can go back to.
#[derive(Clone, Debug, PartialEq)]
pub struct ConeCheckpoint {
    lambda: f64,
    progress: Progress,
    history: Vec<Vec<u32>>,
    lambda_max: Vec<Extent>,
    /// Steps of the coarse stage, if it was under way.
    coarse_steps: Option<usize>,
    response: Response,
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
        let (response, certificate) = problem.assess(&set);
        if !certificate.objective.is_finite() {
            return Err(SolveError::NotFinite);
        }
        let lambda_max = extent::estimate(&mut problem, &response.phi);
        let mut flow = Self {
            mesh: mesh.clone(),
            geometry: geometry.clone(),
            fields: fields.clone(),
            problem,
            dictionary,
            two_ring: None,
            coarse: None,
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
        self.lambda_max.iter().map(|extent| extent.value).fold(0.0, f64::max)
    }

    /// Whether [`ConeFlow::lambda_max`] is more than an estimate.
    pub fn knows_lambda_max(&self) -> bool {
        self.lambda_max.iter().all(|extent| extent.is_exact)
    }

    /// λ_max, solved for where it is an estimate; all else stays as it is. **Costs** an optimum with as few cones as there can be.
    pub fn find_lambda_max(&mut self) -> Result<f64, SolveError> {
        if !self.knows_lambda_max() {
            let home = self.checkpoint();
            let mut walk = || -> Result<(), SolveError> {
                self.set_lambda(self.lambda_max())?;
                while self.step()?.status == Status::Running {}
                Ok(())
            };
            let walked = walk();
            let found = self.lambda_max.clone();
            self.return_to(&home);
            self.lambda_max = found;
            walked?;
        }
        Ok(self.lambda_max())
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

    pub(super) fn change_lambda(&mut self, lambda: f64) {
        let ratio = lambda / self.problem.params.lambda;
        self.progress.is_warm &= (1.0 / NEAR..=NEAR).contains(&ratio);
        self.problem.params.lambda = lambda;
        self.progress.wake();
        let order = &self.progress.set.order;
        if self.dictionary.len() > MOST_REMEMBERED.max(2 * order.len()) {
            self.dictionary.retain(&mut self.problem, order);
        }
        let set = &self.progress.set;
        self.certificate = super::certificate::certify(&mut self.problem, set, &self.response);
        self.picture();
    }

    /// Goes on with other options. A new price or method goes on from the cones that there are; anything else starts anew, with the Green's functions
    /// known so far unless the boundary mode changed. After `Err` everything is as it was.
    pub fn set_params(&mut self, params: &ConeParams) -> Result<(), SolveError> {
        params.validate()?;
        let old = self.problem.params;
        if params.boundary != old.boundary {
            *self = Self::new(&self.mesh, &self.geometry, params, &self.fields)?;
        } else if params.bounds.map(f64::to_bits) != old.bounds.map(f64::to_bits)
            || params.boundary_cost.to_bits() != old.boundary_cost.to_bits()
        {
            let fields = self.fields.clone();
            self.start_anew(params, &fields)?;
        } else {
            self.problem.params = *params;
            self.progress.search = None;
            self.change_lambda(params.lambda);
        }
        Ok(())
    }

    /// Starts anew with other fields, with the Green's functions known so far unless distortion weights changed. After `Err` everything
    /// is as it was.
    pub fn set_fields(&mut self, fields: &ConeFields) -> Result<(), SolveError> {
        let params = self.problem.params;
        if fields.distortion_weight == self.fields.distortion_weight {
            self.start_anew(&params, fields)
        } else {
            *self = Self::new(&self.mesh, &self.geometry, &params, fields)?;
            Ok(())
        }
    }

    fn start_anew(&mut self, params: &ConeParams, fields: &ConeFields) -> Result<(), SolveError> {
        self.problem.ask(params, fields)?;
        self.fields = fields.clone();
        self.coarse = None;
        let steps = self.progress.steps;
        self.progress = Progress { steps, ..Progress::new(self.problem.start.clone()) };
        let set = &self.progress.set;
        (self.response, self.certificate) = self.problem.assess(set);
        self.lambda_max = extent::estimate(&mut self.problem, &self.response.phi);
        self.picture();
        Ok(())
    }

    /// The surface's metric.
    pub(super) fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Goes on until the optimum has what is asked for.
    pub fn aim(&mut self, target: ConeTarget) -> Result<(), SolveError> {
        match target {
            ConeTarget::Lambda(lambda) => return self.set_lambda(lambda),
            ConeTarget::Count(_) | ConeTarget::Merged(_) => {}
            ConeTarget::TotalAngle(value) if (0.0..f64::INFINITY).contains(&value) => {}
            ConeTarget::Distortion(value) if (0.0..f64::INFINITY).contains(&value) => {}
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
            coarse_steps: self.coarse.as_ref().map(|coarse| coarse.steps),
            response: self.response.clone(),
        }
    }

    /// Goes back to a checkpoint of a flow on the same surface with the same options and fields. Later steps repeat bit for bit: Green's
    /// functions that were not known then are forgotten, others computed as they were. **Costs** a response, and the coarse stage anew
    /// if that was under way.
    pub fn restore(&mut self, checkpoint: &ConeCheckpoint) -> Result<(), SolveError> {
        self.coarse = None;
        if let Some(steps) = checkpoint.coarse_steps {
            self.coarse = Coarse::new(&self.mesh, &self.geometry);
            for _ in 0..steps {
                self.coarse_step()?;
            }
        }
        self.dictionary.recall(&mut self.problem, &checkpoint.history);
        self.return_to(checkpoint);
        Ok(())
    }

    /// Goes back to a checkpoint of this very flow and keeps the Green's functions found since.
    pub(super) fn return_to(&mut self, checkpoint: &ConeCheckpoint) {
        self.problem.params.lambda = checkpoint.lambda;
        self.progress = checkpoint.progress.clone();
        self.lambda_max.clone_from(&checkpoint.lambda_max);
        let set = &self.progress.set;
        self.response.clone_from(&checkpoint.response);
        self.certificate = super::certificate::certify(&mut self.problem, set, &self.response);
        self.picture();
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
        let response = self.problem.exact_response(&angles, &self.response);
        let total_angle =
            angles.iter().zip(&self.problem.is_inside).filter(|p| *p.1).map(|p| p.0.abs()).sum();
        let u: Vec<f64> = response.u.iter().map(|u| -u).collect();
        Ok(ConeEvaluation { int_u2: self.int_u2(&u), u, total_angle })
    }

    fn int_u2(&self, u: &[f64]) -> f64 {
        u.iter().zip(&self.problem.system.plain_mass).map(|(u, m)| m * u * u).sum()
    }

    /// Makes the public state from what is known.
    pub(super) fn picture(&mut self) {
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
            // Not `sum`, which is −0 of nothing.
            total_angle: cones.iter().fold(0.0, |sum, c| sum + c.angle.abs()),
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
            columns: 0,
            is_warm: false,
            descent: None,
            is_lost: false,
            is_fine: false,
            search: None,
        }
    }

    /// Forgets that an optimum was found.
    fn wake(&mut self) {
        self.status = Status::Running;
        self.is_settled = self.set.order.is_empty();
        self.is_stuck = false;
        self.polished = 0;
        self.columns = 0;
        self.descent = None;
        self.is_lost = false;
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
            if !self.progress.is_fine && self.coarse.is_none() {
                self.progress.is_fine = true;
                if self.problem.params.multiresolution && !self.problem.is_convex {
                    self.coarse = Coarse::new(&self.mesh, &self.geometry);
                    self.progress.is_fine = self.coarse.is_none();
                }
            }
            if self.coarse.is_some() {
                self.coarse_step()?;
            } else if self.progress.descent.is_some() || self.prefers_newton() {
                self.newton_round()?;
            } else {
                self.greens_round()?;
            }
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
