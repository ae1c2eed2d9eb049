//! Isometric refinement: charts of true size whose triangles are as little distorted as they can be.
//!
//! **Minimises**, over places x of all vertices in the plane,
//! E(x) = 1/A Σ m_t |t| f(∇x_t) + Σ (γ l / √A) e² + μ e + κ/A Σ |x_p − x⁰_p|².
//! *Distortion* f of each triangle t by its singular values (see [`Distortion`]), 0 where the chart is isometric; size is not free: charts go to the size of
//! the surface. m are weights of the material, 1 if none are given. *Seams*: partners of length l on the surface and a, b in the charts have e = (a − b)/l. Their springs are stiff, and
//! multipliers μ take over what springs leave, until all partners are equal to a tolerance. *Pins* pull vertices to places and hold those
//! that are there. All weights are without unit.
//!
//! **Step**: Newton with each element's Hessian made positive semi-definite (closed forms, see the sources of `face` and `seam`), one factorisation of
//! 2 V rows; a line search (Armijo) that begins at most at nine tenths of the way to where the first triangle would lose its area. If
//! asked to, it refuses places in which the rim of a chart crosses itself more often than before; vertices of sides that would cross are then held where they are,
//! close together, and let go when all else is done.
//!
//! **Ends** when the decrease that Newton's model promises, or that of five steps together, is a small fraction of the distortion, and seams are equal to their
//! tolerance. Where they are not yet, multipliers are updated first; the seams' energy is then counted on from where it was, so that E never rises.
//!
//! Guaranteed: no triangle ever turns over (exact predicates); E never rises; rims cross themselves no more often than at the start (with
//! [`IsometricParams::guard_rims`]). Not guaranteed: the global minimum; that rims which have come to touch slide along each other: they stay where
//! they met.
//!
//! **From** Smith, Schaefer: *Bijective Parameterization with Free Boundaries*, 2015 (steps without flips); Smith, de Goes, Kim 2019 (eigenvalues); Rabinovich et al.:
//! *Scalable Locally Injective Mappings*, 2017 (the energies compared).

mod face;
mod model;
mod params;
mod seam;
mod search;
mod start;
mod state;

use std::sync::Arc;

use nalgebra::{Complex, Point2};

use super::disks::log_scales;
use super::{Flattening, NoChart};
use crate::geometry::Geometry;
use crate::linalg::{Analysis, Factor};
use crate::mesh::{HalfedgeId, OpenedMesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

use model::{Forces, Model, Pin, rest_face};
use search::Search;

pub use face::Distortion;
pub use params::IsometricParams;
pub use start::Start;
pub use state::{IsometricEnergy, IsometricState};

/// Distortion below this is rounding of coordinates: strains of 1e-11.
const NOTHING: f64 = 1e-21;

/// The steps whose progress tells convergence.
const WINDOW: usize = 5;

/// Updates of multipliers; each leaves a tenth or less of the difference.
const UPDATES: usize = 12;

/// How often held vertices are let go again when nothing else is left to gain: contacts of a passing shape.
const RELEASES: usize = 2;

/// Pins nearer to their places than this fraction of √A are there.
const THERE: f64 = 1e-10;

/// The flow. Made from a cut surface and charts to begin with.
pub struct IsometricFlow {
    params: IsometricParams,
    opened: OpenedMesh,
    geometry: Geometry,
    charts: Vec<Result<Vec<HalfedgeId>, NoChart>>,
    starts: Vec<Start>,
    model: Model,
    factor: Option<Factor>,
    analysis: Arc<Analysis>,
    state: IsometricState,
    forces: Forces,
    progress: Progress,
    status: Status,
}

/// What a step remembers for the next one, apart from the state.
#[derive(Clone, Debug, Default)]
struct Progress {
    step: usize,
    residual: f64,
    updates: usize,
    releases: usize,
    /// Difference of seams at the last update.
    difference: f64,
    /// E after each of the last steps.
    history: Vec<f64>,
}

/// Everything needed to go on from a step. Weights of the material belong to the flow, not to it.
#[derive(Clone, Debug)]
pub struct IsometricCheckpoint {
    state: IsometricState,
    forces: Forces,
    progress: Progress,
    status: Status,
}

impl IsometricFlow {
    /// Prepares a run.
    ///
    /// **Takes** a cut surface, its measures, and charts in the same unit. Charts with flips are not refined as they are: they start from a
    /// disk instead, or stay out ([`IsometricFlow::starts`] says so).
    /// **Fails** if parameters are out of range or the surface has no area, or if the system cannot be factored. **Costs** one analysis of 2 V rows, 14 entries each.
    pub fn new(
        opened: &OpenedMesh,
        geometry: &Geometry,
        start: &Flattening,
        params: IsometricParams,
    ) -> Result<Self, SolveError> {
        params.validate()?;
        assert_eq!(start.uv.len(), opened.mesh.vertex_count());
        let area = geometry.total_area();
        if !(area > 1e-200 && area < 1e200) {
            return Err(SolveError::NotFinite);
        }
        let rest = |f| rest_face(opened, geometry, f, area);
        let (uv, starts) = start::starts(opened, geometry, start, rest)?;
        let model = Model::new(opened, geometry, &starts, &params);
        let analysis = Arc::new(Analysis::new(model.pattern.clone())?);
        let forces = Forces {
            multipliers: vec![0.0; model.seams.len()],
            stiffness: 1.0,
            ..Forces::default()
        };
        let state = IsometricState {
            places: uv.iter().map(|p| Complex::new(p.x, p.y)).collect(),
            energy: IsometricEnergy::default(),
            seam_difference: 0.0,
            pin_distance: 0.0,
            step_length: 0.0,
            contacts: 0,
        };
        let mut flow = Self {
            params,
            opened: opened.clone(),
            geometry: geometry.clone(),
            charts: start.charts.clone(),
            starts,
            model,
            factor: None,
            analysis,
            state,
            forces,
            progress: Progress::default(),
            status: Status::Running,
        };
        flow.begin();
        if !flow.state.energy.total.is_finite() {
            return Err(SolveError::NotFinite);
        }
        Ok(flow)
    }

    /// What each patch began with.
    pub fn starts(&self) -> &[Start] {
        &self.starts
    }

    /// Options in use.
    pub fn params(&self) -> &IsometricParams {
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

    /// Pins vertices to places, in place of all pins before. A vertex that is there already does not move any more; others are pulled there, and the
    /// charts follow. A flow that had ended goes on.
    ///
    /// **Fails** if there is no such vertex, or none in a chart that is refined, or if it is pinned twice, or a place is not finite; then nothing changes.
    pub fn set_pins(&mut self, pins: &[(VertexId, Point2<f64>)]) -> Result<(), SolveError> {
        let mut is_pinned = vec![false; self.state.places.len()];
        for &(vertex, place) in pins {
            if !self.model.has(vertex) {
                let vertices = self.state.places.len();
                return Err(SolveError::NoSuchVertex { vertex, vertices });
            }
            if std::mem::replace(&mut is_pinned[vertex.index()], true) {
                return Err(SolveError::SeedTwice { vertex });
            }
            if !(place.x + place.y).is_finite() {
                return Err(SolveError::NotFinite);
            }
        }
        let near = THERE * self.model.area.sqrt();
        self.forces.pins = pins
            .iter()
            .map(|&(vertex, place)| {
                let place = Complex::new(place.x, place.y);
                let is_held = (self.state.places[vertex.index()] - place).norm() <= near;
                Pin { vertex: vertex.0, place, is_held }
            })
            .collect();
        self.begin();
        Ok(())
    }

    /// Weights of the material for each face of the opened mesh: faces of twice the weight are distorted less. A flow that had ended goes on.
    ///
    /// **Fails** if a weight is not positive and finite; then nothing changes.
    pub fn set_face_weights(&mut self, weights: &[f64]) -> Result<(), SolveError> {
        assert_eq!(weights.len(), self.opened.mesh.face_count());
        if let Some(&value) = weights.iter().find(|w| !(**w >= 1e-6 && **w <= 1e6)) {
            return Err(SolveError::Parameter { name: "face weight", value, min: 1e-6, max: 1e6 });
        }
        self.model.set_materials(weights);
        self.begin();
        Ok(())
    }

    /// The charts as they are. `u` is estimated from areas; [`Flattening::seams_equal`] is true only if partners are equal to nine digits, whatever
    /// the tolerance.
    pub fn flattening(&self) -> Flattening {
        let uv: Vec<_> = self.opened.mesh.vertices().map(|v| self.state.place(v)).collect();
        let u = log_scales(&self.opened, &self.geometry, &uv);
        let seams_equal = super::fixed::seam_difference(&self.opened, &uv) < 1e-9;
        let (charts, residual) = (self.charts.clone(), self.progress.residual);
        Flattening::of_places(charts, uv, u, seams_equal, residual)
    }

    /// What is needed to go on from here.
    pub fn checkpoint(&self) -> IsometricCheckpoint {
        IsometricCheckpoint {
            state: self.state.clone(),
            forces: self.forces.clone(),
            progress: self.progress.clone(),
            status: self.status,
        }
    }

    /// Goes back to a checkpoint of a flow on the same surface. Later steps repeat bit for bit.
    pub fn restore(&mut self, checkpoint: &IsometricCheckpoint) {
        let same = checkpoint.state.places.len() == self.state.places.len();
        assert!(same, "a checkpoint of another surface");
        self.state = checkpoint.state.clone();
        self.forces = checkpoint.forces.clone();
        self.progress = checkpoint.progress.clone();
        self.status = checkpoint.status;
    }

    /// dE along a displacement of each vertex by the gradient that steps use, and E after a displacement by `length` times it:
    /// what tests compare.
    pub fn directional_derivative(
        &self,
        direction: impl Fn(usize) -> [f64; 2],
        length: f64,
    ) -> (f64, f64) {
        let moves = self.model.moves(&self.forces);
        let d: Vec<Complex<f64>> = (0..moves.len())
            .map(|v| {
                let [x, y] = if moves[v] { direction(v) } else { [0.0; 2] };
                Complex::new(x, y)
            })
            .collect();
        let (gradient, _) = self.model.derivatives(&self.state.places, &self.forces);
        let moved = along(&self.state.places, &d, length);
        (slope(&gradient, &d), self.model.energy(&moved, &self.forces).total)
    }

    /// Starts counting anew at the present places.
    fn begin(&mut self) {
        self.status = Status::Running;
        self.progress.updates = 0;
        self.progress.releases = 0;
        self.forces.touching.clear();
        self.progress.difference = f64::INFINITY;
        self.measure();
        self.progress.history = vec![self.state.energy.total];
        if self.state.energy.distortion < NOTHING
            && self.state.energy.pins < NOTHING
            && self.seams_are_equal()
        {
            self.status = Status::Converged;
        }
    }

    /// Everything about the places that the state tells.
    fn measure(&mut self) {
        let x = &self.state.places;
        self.state.energy = self.model.energy(x, &self.forces);
        self.state.seam_difference = self.model.seam_difference(x);
        self.state.contacts = self.forces.touching.len();
        let distance = |p: &Pin| (x[p.vertex as usize] - p.place).norm();
        self.state.pin_distance = self.forces.pins.iter().map(distance).fold(0.0, f64::max);
    }

    fn seams_are_equal(&self) -> bool {
        self.params.seam_weight <= 0.0 || self.state.seam_difference <= self.params.seam_tolerance
    }

    /// Newton's direction and the slope along it.
    fn direction(&mut self) -> Result<(Vec<Complex<f64>>, f64), SolveError> {
        let (gradient, values) = self.model.derivatives(&self.state.places, &self.forces);
        match &mut self.factor {
            Some(factor) => factor.refactor(&values)?,
            none => *none = Some(Factor::new(self.analysis.clone(), &values)?),
        }
        let wanted: Vec<f64> = gradient.iter().flat_map(|g| [-g.re, -g.im]).collect();
        let mut d = wanted.clone();
        if let Some(factor) = &mut self.factor {
            factor.solve(&mut d, 1);
        }
        let mut product = vec![0.0; d.len()];
        self.model.pattern.multiply(&values, &d, &mut product);
        let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
        let error = norm(&mut product.iter().zip(&wanted).map(|(p, w)| p - w));
        let size = norm(&mut wanted.iter().copied());
        self.progress.residual = if size > 0.0 { error / size } else { 0.0 };
        if !self.progress.residual.is_finite() {
            // The factor of such a matrix is not to be used again.
            self.factor = None;
            return Err(SolveError::NotFinite);
        }
        let d: Vec<_> = d.chunks_exact(2).map(|z| Complex::new(z[0], z[1])).collect();
        let slope = slope(&gradient, &d);
        Ok((d, slope))
    }

    /// The run is at the minimum for its multipliers and contacts: updates them, or ends.
    fn settle(&mut self) {
        if !self.forces.touching.is_empty() && self.progress.releases < RELEASES {
            self.forces.touching.clear();
            self.state.contacts = 0;
            self.progress.releases += 1;
            self.progress.history = vec![self.state.energy.total];
            return;
        }
        if self.seams_are_equal() {
            self.status = Status::Converged;
            return;
        }
        if self.progress.updates == UPDATES {
            self.status = Status::Stalled;
            return;
        }
        let x = &self.state.places;
        let counted = self.state.energy.seam;
        for (seam, mu) in self.model.seams.iter().zip(&mut self.forces.multipliers) {
            *mu += 2.0 * self.forces.stiffness * seam.weight * seam.difference(x);
        }
        // Multipliers that do not help enough need stiffer springs beside them.
        if self.state.seam_difference > 0.25 * self.progress.difference {
            self.forces.stiffness *= 4.0;
        }
        self.progress.difference = self.state.seam_difference;
        self.progress.updates += 1;
        self.forces.offset = self.model.seam_energy(x, &self.forces) - counted;
        self.measure();
        self.progress.history = vec![self.state.energy.total];
    }

    fn report(&self) -> StepReport {
        let energy = self.state.energy;
        StepReport {
            step: self.progress.step,
            energy: vec![
                ("total", energy.total),
                ("distortion", energy.distortion),
                ("seam", energy.seam),
                ("pins", energy.pins),
            ],
            residual: self.progress.residual,
            progress: None,
            status: self.status,
        }
    }
}

impl Flow for IsometricFlow {
    type State = IsometricState;

    fn state(&self) -> &IsometricState {
        &self.state
    }

    /// One Newton step, or a change of what is held or of multipliers where there is nothing to gain without.
    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status != Status::Running {
            return Ok(self.report());
        }
        let (d, slope) = self.direction()?;
        let small = self.params.tolerance * self.state.energy.distortion + NOTHING;
        if -0.5 * slope <= small {
            self.settle();
            return Ok(self.report());
        }
        match self.search(&d, slope) {
            Search::Moved => {
                self.progress.step += 1;
                let history = &mut self.progress.history;
                history.push(self.state.energy.total);
                if history.len() > WINDOW + 1 {
                    history.remove(0);
                }
                if history.len() > WINDOW && history[0] - history[WINDOW] <= small {
                    self.settle();
                }
            }
            Search::Nothing => self.settle(),
            Search::Touched => {}
            Search::Blocked => self.status = Status::Stalled,
        }
        Ok(self.report())
    }
}

/// x + length · d.
fn along(x: &[Complex<f64>], d: &[Complex<f64>], length: f64) -> Vec<Complex<f64>> {
    x.iter().zip(d).map(|(x, d)| x + d * length).collect()
}

/// dE along d.
fn slope(gradient: &[Complex<f64>], d: &[Complex<f64>]) -> f64 {
    gradient.iter().zip(d).map(|(g, d)| g.re * d.re + g.im * d.im).sum()
}
