//! The flow: one round after another until the optimum is certified, for one λ after another.

use super::aim::Search;
use super::certificate::Certificate;
use super::coarse::{Coarse, Stage};
use super::error::{ConeConflict, ConeError};
use super::extent;
use super::greens::{self, Dictionary};
use super::newton::{Descent, Outcome};
use super::params::{
    Cone, ConeEvaluation, ConeFields, ConeMethod, ConeParams, ConeState, ConeTarget,
};
use super::problem::{ActiveSet, Problem};
use super::rounding::{RoundParams, round_clusters};
use super::system::{NONE, Response};
use super::two_ring::TwoRing;
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Excess of |φ| over λ w, in λ, that is none. Rounding in φ is about 1e-13 of its size, and φ is of the size of λ_max.
const TOLERANCE: f64 = 1e-10;

/// Residual above which a finished optimum is polished further, as long as that helps.
const POLISHED: f64 = 1e-10;

/// Rounding of φ, as a fraction of its size, which is that of λ_max.
const ROUNDING: f64 = 1e-14;

/// Residual of an optimum. Rounding leaves 1e-13 to 1e-10; a wrong vertex in the support leaves 1e-5.
const GOOD: f64 = 1e-8;

/// Angles let free in one round: at least so many, and a share of those that are free already. With fewer there are more rounds,
/// with more there are columns that nobody needs.
const FEWEST_NEW: usize = 6;

/// Ratio of two prices up to which the cones of one are a start for Newton's method at the other.
const NEAR: f64 = 1.5;

/// Green's functions computed in one step: what keeps a step short.
const MOST_COLUMNS: usize = 64;

/// Green's functions that are remembered beyond those in use: k² numbers, 32 MB.
const MOST_REMEMBERED: usize = 2048;

/// Optimal cones, one bounded step at a time.
///
/// **Minimises** ½ ∫ w_E u² + λ Σ w_R |μ|, exactly. **Step** one round of the active set (a few Green's functions, a small dense
/// problem, one solve for φ) or one Newton step (one factorisation, the first also an analysis). Every state in the range of Green's functions is feasible, and
/// the objective falls from step to step; Newton's steps may rise. **Ends** `Converged` at the certified optimum; `Infeasible` when [`ConeFlow::aim`]
/// cannot be met (the state is then the nearest); `Stalled` where rounding ends progress before the certificate is good.
pub struct ConeFlow {
    mesh: Mesh,
    geometry: Geometry,
    fields: ConeFields,
    pub(super) problem: Problem,
    pub(super) dictionary: Dictionary,
    /// The two-ring matrix, once it is needed.
    two_ring: Option<TwoRing>,
    coarse: Option<Coarse>,
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
    lambda_max: Vec<f64>,
    /// Steps of the coarse stage, if it was under way.
    coarse_steps: Option<usize>,
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
        (self.response, self.certificate) = self.problem.assess(set, false);
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
        (self.response, self.certificate) = self.problem.assess(set, self.progress.is_refined);
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

    /// Excess that is rounding.
    fn tolerance(&self) -> f64 {
        TOLERANCE * self.problem.params.lambda + ROUNDING * self.lambda_max()
    }

    /// Residual that an optimum may have: with a price far below λ_max, rounding of φ is no longer small against it.
    fn good(&self) -> f64 {
        GOOD.max(100.0 * self.tolerance() / self.problem.params.lambda)
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
        let entered = set.order.len() - free;
        let missing = self.dictionary.missing(&set.order);
        self.progress.columns += missing.len().min(MOST_COLUMNS);
        if missing.len() > MOST_COLUMNS {
            // The rest in further steps: the angles stay as they are.
            self.dictionary.add(&mut self.problem, &missing[..MOST_COLUMNS]);
            return Ok(());
        }
        self.dictionary.add(&mut self.problem, &missing);
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
        self.accept(set, response, certificate);
        Ok(())
    }

    /// One step on the coarse surface; at its end its cones are where to begin, if they are better than what there is.
    fn coarse_step(&mut self) -> Result<(), SolveError> {
        let Some(coarse) = &mut self.coarse else { return Ok(()) };
        let stage = coarse.step(&self.mesh, &self.geometry, &self.problem, &self.fields)?;
        if let Stage::Over(start) = stage {
            self.coarse = None;
            self.progress.is_fine = true;
            if let Some(set) = start {
                let (response, certificate) = self.problem.assess(&set, false);
                if certificate.objective < self.certificate.objective {
                    self.progress.is_warm = true;
                    self.progress.is_settled = set.order.is_empty();
                    self.accept(set, response, certificate);
                }
            }
        }
        Ok(())
    }

    fn accept(&mut self, set: ActiveSet, response: Response, certificate: Certificate) {
        self.progress.set = set;
        self.progress.is_refined = false;
        self.response = response;
        self.certificate = certificate;
    }

    /// Whether Newton's method is predicted to be faster from here.
    ///
    /// Solves move data, factorisations compute: an entry of a factor takes about as long in a solve as 16 operations in a factorisation.
    /// How many cones there will be is not known, so Green's functions go on until they have cost what Newton's method
    /// would: at worst the two together cost twice the better one.
    fn prefers_newton(&self) -> bool {
        match self.problem.params.method {
            _ if self.progress.is_lost => return false,
            ConeMethod::Greens => return false,
            ConeMethod::Newton => return true,
            ConeMethod::Auto => {}
        }
        let n = self.problem.system.len() as f64;
        let (entries, solves) = self.problem.system.factor_size();
        let entries = entries as f64;
        // The factor of the two-ring matrix has about four times the entries of L's, and entries² / n · 2 operations.
        let (large, small) =
            if solves == 1 { (entries, entries) } else { (4.0 * entries, entries) };
        let factorisations = if self.progress.is_warm { 8.0 } else { 18.0 };
        let newton = factorisations * 2.0 * large * large / n;
        let missing = self.dictionary.missing(&self.progress.set.order).len();
        let columns = (self.progress.columns + missing) as f64;
        let free = self.progress.set.order.len() as f64;
        // A column is solves; with it come about four moves of the dense problem.
        let greens = columns * (64.0 * solves as f64 * small + 8.0 * free * free);
        greens > newton
    }

    fn newton_round(&mut self) -> Result<(), SolveError> {
        if self.two_ring.is_none() {
            self.two_ring = Some(match self.problem.system.two_ring() {
                Some(own) => own.sibling(),
                None => TwoRing::new(&self.problem.system)?,
            });
        }
        let Some(two_ring) = &mut self.two_ring else { return Ok(()) };
        let progress = &mut self.progress;
        if progress.descent.is_none() {
            let phi = greens::shifted(&self.problem, &progress.set, &self.response);
            progress.is_warm |= progress.columns > 0;
            progress.descent = Some(if progress.is_warm {
                Descent::warm(phi, progress.set.clone())
            } else {
                Descent::cold(phi)
            });
        }
        let Some(descent) = &mut progress.descent else { return Ok(()) };
        let mut trial = descent.clone();
        match trial.step(&mut self.problem, two_ring)? {
            Outcome::Guess(mut set) => {
                *descent = trial;
                if self.problem.repair(&mut set) {
                    let (response, certificate) = self.problem.assess(&set, false);
                    if certificate.objective < self.certificate.objective {
                        self.accept(set, response, certificate);
                    }
                }
            }
            Outcome::Optimum(set) => {
                progress.descent = None;
                let (response, certificate) = self.problem.assess(&set, true);
                self.accept(set, response, certificate);
                self.progress.is_refined = true;
                self.progress.is_settled = true;
                if certificate.residual() < self.good() {
                    self.progress.status = Status::Converged;
                } else {
                    self.progress.is_lost = true;
                }
            }
            Outcome::Lost => {
                // From the beginning, or else by Green's functions, which cannot go in circles.
                progress.descent = None;
                progress.is_lost = !progress.is_warm;
                progress.is_warm = false;
                progress.columns = 0;
                progress.is_settled = progress.set.order.is_empty();
            }
        }
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
        self.progress.status = if self.certificate.residual() < self.good() {
            Status::Converged
        } else {
            Status::Stalled
        };
        Ok(())
    }

    /// How many cones are left when clusters are merged.
    fn merged_count(&self) -> usize {
        let params = RoundParams { bounds: self.problem.params.bounds, ..RoundParams::default() };
        round_clusters(&self.mesh, &self.geometry, &self.state.cones, &params).cones.len()
    }

    /// Learns λ_max from an optimum, and goes on to the next λ of a search.
    fn conclude(&mut self) {
        self.progress.is_warm = true;
        let set = &self.progress.set;
        let phi = greens::shifted(&self.problem, set, &self.response);
        let told = extent::from_optimum(&self.problem, set, &phi);
        for (old, new) in self.lambda_max.iter_mut().zip(told) {
            *old = new.unwrap_or(*old);
        }
        let most = self.lambda_max().max(f64::MIN_POSITIVE);
        if let Some(mut search) = self.progress.search.take() {
            // Above λ_max nothing changes; below a thousandth of it every vertex is about to become a cone.
            let cones = match search.is_merged() {
                true => self.merged_count(),
                false => self.state.cones.len(),
            };
            let next = search.next(&self.state, cones, [1e-3 * most, most]);
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
