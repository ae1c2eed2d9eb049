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
mod seam;
mod start;

use std::sync::Arc;

use nalgebra::{Complex, Point2};

use super::disks::log_scales;
use super::overlap::{Side, crossings};
use super::{Flattening, NoChart};
use crate::geometry::Geometry;
use crate::linalg::{Analysis, Factor};
use crate::mesh::{HalfedgeId, OpenedMesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

use model::{Forces, Model, Pin, rest_face};

pub use face::Distortion;
pub use start::Start;

/// Options of an [`IsometricFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsometricParams {
    /// What distortion costs.
    pub distortion: Distortion,
    /// γ: how stiff seams are to begin with. At 10 springs alone leave differences of some thousandths, and one or two updates of multipliers reach
    /// a tolerance of 1e-4; much stiffer ones slow every step along the curved set of charts with equal seams, much
    /// softer ones need more updates. 0 lets partners go their own ways.
    pub seam_weight: f64,
    /// Largest relative difference of seam partners at the end: a tenth of a millimetre in a metre.
    pub seam_tolerance: f64,
    /// κ: how strongly pins pull.
    pub pin_weight: f64,
    /// Whether rims may not come to cross themselves.
    pub guard_rims: bool,
    /// The run has converged when a step promises less than this fraction of the distortion, or five together gained less.
    pub tolerance: f64,
}

impl Default for IsometricParams {
    fn default() -> Self {
        Self {
            distortion: Distortion::SymmetricDirichlet,
            seam_weight: 10.0,
            seam_tolerance: 1e-4,
            pin_weight: 1e4,
            guard_rims: true,
            tolerance: 1e-5,
        }
    }
}

impl IsometricParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = |name, value: f64, min: f64, max: f64| {
            if value >= min && value <= max {
                Ok(())
            } else {
                Err(SolveError::Parameter { name, value, min, max })
            }
        };
        within("seam weight", self.seam_weight, 0.0, 1e6)?;
        within("seam tolerance", self.seam_tolerance, 1e-9, 1.0)?;
        within("pin weight", self.pin_weight, 0.0, 1e8)?;
        within("tolerance", self.tolerance, 0.0, 1.0)
    }
}

/// The energy of places and its terms, weights included, without unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IsometricEnergy {
    /// Sum of the terms.
    pub total: f64,
    /// Mean of the distortion over the area: 0 for isometric charts.
    pub distortion: f64,
    /// Of seams: springs and multipliers, less what keeps it continuous where multipliers change. May be negative.
    pub seam: f64,
    /// Of pins that are not where they are pulled to.
    pub pins: f64,
}

/// Refined charts.
#[derive(Clone, Debug, PartialEq)]
pub struct IsometricState {
    places: Vec<Complex<f64>>,
    energy: IsometricEnergy,
    seam_difference: f64,
    pin_distance: f64,
    step_length: f64,
}

impl IsometricState {
    /// Place of a vertex in its chart.
    pub fn place(&self, v: VertexId) -> Point2<f64> {
        let z = self.places[v.index()];
        Point2::new(z.re, z.im)
    }

    /// The energy and its terms.
    pub fn energy(&self) -> IsometricEnergy {
        self.energy
    }

    /// Largest |a − b| / ½ (a + b) over seam partners of lengths a, b in the charts.
    pub fn seam_difference(&self) -> f64 {
        self.seam_difference
    }

    /// Largest distance of a pinned vertex from where it is pulled to, in units of the model.
    pub fn pin_distance(&self) -> f64 {
        self.pin_distance
    }

    /// Length of the last accepted step; 1 is Newton's.
    pub fn step_length(&self) -> f64 {
        self.step_length
    }
}

/// Distortion below this is rounding of coordinates: strains of 1e-11.
const NOTHING: f64 = 1e-21;

/// How far a step may go on the way to the first triangle without area.
const CAP: f64 = 0.9;

/// Trials of one line search: a millionth of a step is none.
const TRIALS: usize = 20;

/// Decrease that a trial must reach, as a fraction of what the slope promises.
const ARMIJO: f64 = 1e-4;

/// The steps whose progress tells convergence.
const WINDOW: usize = 5;

/// Updates of multipliers; each leaves a tenth or less of the difference.
const UPDATES: usize = 12;

/// Halvings of a step that would make rims cross before the vertices there are held instead: so near rims come to each other.
const CLOSER: usize = 2;

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

/// What a line search found.
enum Search {
    Moved,
    /// Nothing lower: rounding hides what is left.
    Nothing,
    /// Lower, but only with rims that cross: their vertices are held from now on.
    Touched,
    /// Lower, but only with rims that cross, and holding their vertices did not help.
    Blocked,
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
        Flattening { charts: self.charts.clone(), uv, u, seams_equal, angles_exact: false }
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
        let distance = |p: &Pin| (x[p.vertex as usize] - p.place).norm();
        self.state.pin_distance = self.forces.pins.iter().map(distance).fold(0.0, f64::max);
    }

    fn seams_are_equal(&self) -> bool {
        self.params.seam_weight <= 0.0 || self.state.seam_difference <= self.params.seam_tolerance
    }

    /// Crossings of each chart's outline with itself: pairs of sides.
    fn rim_crossings(&self, x: &[Complex<f64>]) -> Vec<Vec<[Side; 2]>> {
        let place = |h: &HalfedgeId| {
            let z = x[self.opened.mesh.tail(*h).index()];
            Point2::new(z.re, z.im)
        };
        self.charts
            .iter()
            .zip(&self.starts)
            .map(|(rim, start)| match rim {
                Ok(rim) if start.is_refined() => {
                    let outline: Vec<_> = rim.iter().map(place).collect();
                    crossings(&[&outline])
                }
                _ => Vec::new(),
            })
            .collect()
    }

    /// Rim vertices that have to be held lest charts cross themselves more often: the ends of sides that cross anew there.
    fn new_contacts(&self, before: &[Vec<[Side; 2]>], now: &[Vec<[Side; 2]>]) -> Vec<u32> {
        let mut contacts = Vec::new();
        for (patch, rim) in self.charts.iter().enumerate() {
            let Ok(rim) = rim else { continue };
            if now[patch].len() <= before[patch].len() {
                continue;
            }
            for pair in now[patch].iter().filter(|p| before[patch].binary_search(p).is_err()) {
                for side in pair {
                    let h = rim[side.side as usize];
                    contacts.extend([self.opened.mesh.tail(h).0, self.opened.mesh.tip(h).0]);
                }
            }
        }
        contacts
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

    /// Looks for a place along a direction that is lower, upright and, if asked for, does not cross.
    fn search(&mut self, d: &[Complex<f64>], slope: f64) -> Search {
        // Not `>=`: a slope that is no number is none.
        if !(slope < 0.0) {
            return Search::Nothing;
        }
        let before = self.state.energy.total;
        let mut length = (CAP * self.model.largest_step(&self.state.places, d)).min(1.0);
        let mut known = None;
        let mut blocked = 0;
        for _ in 0..TRIALS {
            let x = along(&self.state.places, d, length);
            let energy = self.model.energy(&x, &self.forces);
            let is_lower = energy.total < before && energy.total <= before + ARMIJO * length * slope;
            if is_lower && self.model.is_upright(&x) {
                let contacts = if self.params.guard_rims {
                    let known = known.get_or_insert_with(|| self.rim_crossings(&self.state.places));
                    self.new_contacts(known, &self.rim_crossings(&x))
                } else {
                    Vec::new()
                };
                if contacts.is_empty() {
                    self.state.places = x;
                    self.state.step_length = length;
                    self.measure();
                    return Search::Moved;
                }
                blocked += 1;
                if blocked > CLOSER && self.touch(contacts) {
                    return Search::Touched;
                }
            }
            length *= 0.5;
        }
        if blocked > 0 { Search::Blocked } else { Search::Nothing }
    }

    /// Holds more vertices. **Gives** whether there were any that were not held yet.
    fn touch(&mut self, contacts: Vec<u32>) -> bool {
        let touching = &mut self.forces.touching;
        let known = touching.len();
        touching.extend(contacts);
        touching.sort_unstable();
        touching.dedup();
        touching.len() > known
    }

    /// The run is at the minimum for its multipliers and contacts: updates them, or ends.
    fn settle(&mut self) {
        if !self.forces.touching.is_empty() && self.progress.releases < RELEASES {
            self.forces.touching.clear();
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
