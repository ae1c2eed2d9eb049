//! Variational shape approximation with a bound on the error of every chart \[CAD04\].
//!
//! Let chart i have faces of areas a and unit normals n. Its *proxy* is the direction N that its faces fit best, its error
//! E = Σ a |n − N|² (the metric L^{2,1}), least for N = Σ a n / |Σ a n|, where it is 2 (Σ a − |Σ a n|). Looked for are few connected charts
//! with E ≤ ε A each, A the surface's area. From one chart on, the worst face of the worst chart begins a new one, which takes faces
//! from its neighbours by *flooding*: faces join one by one the chart beside them that they fit best. From time to time the pair of charts that costs
//! least is joined and its plane used where the error is largest (a *teleport*); in the end all charts are flooded together, and those that lie in one
//! plane are joined.
//!
//! Only a new chart and those about the one that it came from are flooded; charts farther away would hardly change, and the time of an insertion is
//! that of its neighbourhood.
//!
//! Guaranteed: every face has a chart, every chart is connected and has faces, at any moment; the error falls from step to
//! step while charts are added, and E ≤ ε A in the end unless there are as many charts as allowed. Not guaranteed: the fewest charts.

mod params;
mod regions;
mod starts;

use std::sync::Arc;

use super::connected_charts;
use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh};
use crate::methods::developable::small;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};
pub use params::{VsaChart, VsaParams, VsaPhase, VsaState};
use regions::{Faces, NONE};
pub use starts::start_faces;

/// Floods in the end must lower the error by this fraction to count: less is rounding.
const GAIN: f64 = 1e-12;

/// Pairs whose union has this fraction of the surface's area more error lie in one plane, and are joined in the end.
const COPLANAR: f64 = 1e-9;

/// Charts about planes, one bounded step at a time.
///
/// **Minimises** Σ E under max E ≤ ε A, with few charts. **Step** one chart more and its floods; after the last, one flood of everything. Where the tolerance
/// was raised, first one pair joined a step: only then does the error rise. **Ends** `Converged`; `Stalled` where more charts than allowed would be needed.
/// **From** [CAD04], [LPFB §2]. **Differs**: only the neighbourhood of a new chart is flooded; a chart begins at the face that fits
/// best in direction, not by direction times area, which would prefer slivers.
#[derive(Clone)]
pub struct VsaFlow {
    mesh: Arc<Mesh>,
    geometry: Arc<Geometry>,
    params: VsaParams,
    faces: Faces,
    progress: VsaCheckpoint,
}

/// Where a [`VsaFlow`] can go back to.
#[derive(Clone, Debug, PartialEq)]
pub struct VsaCheckpoint {
    state: VsaState,
    step: usize,
    /// Charts added since the last teleport was tried.
    inserted: usize,
    /// Floods of everything since the last chart was added.
    polished: usize,
    status: Status,
}

impl VsaFlow {
    /// Begins with one chart for each component of the surface.
    ///
    /// **Fails** on parameters out of range, a first face that is not there, and a surface without area.
    /// **Costs** a flood.
    pub fn new(
        mesh: Arc<Mesh>,
        geometry: Arc<Geometry>,
        params: VsaParams,
    ) -> Result<Self, SolveError> {
        let none = vec![None; mesh.face_count()];
        Self::from_strokes(mesh, geometry, params, &none)
    }

    /// Begins with what a user has painted.
    ///
    /// **Takes** for each face a label or none. Faces of one label that hang together begin one chart; the first floods start from all of them, with their
    /// plane, and later ones may move the chart. Labels for all faces are charts to go on from.
    /// **Fails** and **Costs** like [`VsaFlow::new`].
    pub fn from_strokes(
        mesh: Arc<Mesh>,
        geometry: Arc<Geometry>,
        params: VsaParams,
        strokes: &[Option<u32>],
    ) -> Result<Self, SolveError> {
        params.validate()?;
        assert_eq!(strokes.len(), mesh.face_count());
        let (value, max) = (f64::from(params.seed_face.0), mesh.face_count() as f64 - 1.0);
        SolveError::within("first face", value, 0.0, max)?;
        let mut faces = Faces::new(&mesh, &geometry);
        if !(faces.total_area > 0.0 && faces.total_area.is_finite()) {
            return Err(SolveError::NotFinite);
        }
        let state = first_charts(&mesh, &mut faces, params.seed_face, strokes);
        let progress =
            VsaCheckpoint { state, step: 0, inserted: 0, polished: 0, status: Status::Running };
        let mut flow = Self { mesh, geometry, params, faces, progress };
        flow.sum_up();
        Ok(flow)
    }

    /// Options in force.
    pub fn params(&self) -> &VsaParams {
        &self.params
    }

    /// How it stands.
    pub fn status(&self) -> Status {
        self.progress.status
    }

    /// The surface.
    pub fn surface(&self) -> (&Arc<Mesh>, &Arc<Geometry>) {
        (&self.mesh, &self.geometry)
    }

    /// Goes on with other options from the charts that there are: with a lower tolerance more are added, with a higher one or with fewer
    /// charts allowed pairs are joined. A new first face has no effect any more. After `Err` everything is as it was.
    pub fn set_params(&mut self, params: VsaParams) -> Result<(), SolveError> {
        params.validate()?;
        let old = std::mem::replace(&mut self.params, params);
        if old == params {
            return Ok(());
        }
        let fewer = params.tolerance > old.tolerance
            || self.progress.state.charts.len() > params.max_charts;
        self.progress.state.phase = if fewer { VsaPhase::Merge } else { VsaPhase::Grow };
        self.progress.polished = 0;
        self.progress.status = Status::Running;
        Ok(())
    }

    /// What it takes to come back to where it is.
    pub fn checkpoint(&self) -> VsaCheckpoint {
        self.progress.clone()
    }

    /// Goes back to a checkpoint of a flow on the same surface with the same options. Later steps repeat bit for bit.
    pub fn restore(&mut self, checkpoint: &VsaCheckpoint) {
        self.progress = checkpoint.clone();
    }

    fn sum_up(&mut self) {
        let state = &mut self.progress.state;
        let area = self.faces.total_area;
        state.error = state.charts.iter().fold(0.0, |sum, c| sum + c.error) / area;
        state.worst = state.charts.iter().fold(0.0, |worst: f64, c| worst.max(c.error)) / area;
    }

    /// The chart with the largest error, the first of several.
    fn worst(&self) -> u32 {
        let charts = &self.progress.state.charts;
        let mut worst = 0;
        for (i, chart) in charts.iter().enumerate() {
            if chart.error > charts[worst].error {
                worst = i;
            }
        }
        small(worst)
    }

    /// One chart more, if one is needed and allowed.
    fn grow(&mut self) -> bool {
        let state = &self.progress.state;
        if state.worst <= self.params.tolerance || state.charts.len() >= self.params.max_charts {
            return false;
        }
        let (worst, slot) = (self.worst(), small(state.charts.len()));
        let lloyd = self.params.lloyd;
        if !self.faces.insert(&mut self.progress.state, worst, slot, lloyd) {
            return false;
        }
        self.sum_up();
        self.progress.polished = 0;
        self.progress.inserted += 1;
        let every = self.params.teleport_every;
        if every > 0 && self.progress.inserted >= every {
            self.progress.inserted = 0;
            self.polish();
            self.teleport();
        }
        true
    }

    /// Floods everything once. **Gives** whether that lowered the error; where it did not, nothing has changed.
    fn polish(&mut self) -> bool {
        let before = self.progress.state.clone();
        let all: Vec<u32> = (0..small(before.charts.len())).collect();
        self.faces.flood(&mut self.progress.state, &all);
        self.sum_up();
        let is_better = self.progress.state.error < before.error * (1.0 - GAIN);
        if !is_better {
            self.progress.state = before;
        }
        is_better
    }

    /// Joins the pair that costs least and begins its second chart anew where the error is largest, if that lowers both the error and its maximum.
    fn teleport(&mut self) {
        let before = self.progress.state.clone();
        let limit = 0.5 * before.worst * self.faces.total_area;
        let Some(pair) = self.faces.cheapest_pair(&before, |increase, _| increase < limit) else {
            return;
        };
        self.faces.join(&mut self.progress.state, pair);
        // Its error would be counted with that of the union.
        self.progress.state.charts[pair[1] as usize].error = 0.0;
        let worst = self.worst();
        let lloyd = self.params.lloyd;
        let done = self.faces.insert(&mut self.progress.state, worst, pair[1], lloyd);
        self.sum_up();
        let state = &self.progress.state;
        if !(done && state.error < before.error && state.worst <= before.worst) {
            self.progress.state = before;
        }
    }

    /// Joins the pair that costs least, if the tolerance lets it or there are too many.
    fn merge(&mut self) -> bool {
        let limit = self.params.tolerance * self.faces.total_area;
        let too_many = self.progress.state.charts.len() > self.params.max_charts;
        self.join_cheapest(|_, error| too_many || error <= limit)
    }

    /// Joins two charts that lie in one plane.
    fn tidy(&mut self) -> bool {
        let limit = self.params.tolerance * self.faces.total_area;
        let nothing = COPLANAR * self.faces.total_area;
        self.join_cheapest(|increase, error| increase <= nothing && error <= limit)
    }

    fn join_cheapest(&mut self, may: impl Fn(f64, f64) -> bool) -> bool {
        let pair = self.faces.cheapest_pair(&self.progress.state, may);
        let Some([a, b]) = pair else { return false };
        let state = &mut self.progress.state;
        self.faces.join(state, [a, b]);
        // The last chart takes the free number.
        state.charts.swap_remove(b as usize);
        if let Some(moved) = state.charts.get(b as usize) {
            for f in &moved.faces {
                state.face_charts[f.index()] = b;
            }
        }
        self.sum_up();
        true
    }

    fn advance(&mut self) {
        if self.progress.state.phase == VsaPhase::Merge {
            if self.merge() {
                return;
            }
            self.progress.state.phase = VsaPhase::Grow;
        }
        if self.progress.state.phase == VsaPhase::Grow {
            if self.grow() {
                return;
            }
            self.progress.state.phase = VsaPhase::Polish;
        }
        let goes_on = self.progress.polished < self.params.final_iterations && self.polish();
        if goes_on {
            self.progress.polished += 1;
            return;
        }
        if self.tidy() {
            return;
        }
        let state = &mut self.progress.state;
        let is_met = state.worst <= self.params.tolerance;
        if is_met || state.charts.len() >= self.params.max_charts {
            state.phase = VsaPhase::Done;
            self.progress.status = if is_met { Status::Converged } else { Status::Stalled };
        } else {
            // Flooding has raised the largest error again.
            state.phase = VsaPhase::Grow;
            if !self.grow() {
                self.progress.state.phase = VsaPhase::Done;
                self.progress.status = Status::Stalled;
            }
        }
    }
}

/// Charts from strokes, and one for each component without.
fn first_charts(
    mesh: &Mesh,
    faces: &mut Faces,
    seed_face: FaceId,
    strokes: &[Option<u32>],
) -> VsaState {
    // Unpainted faces count as one label more, before all others.
    let mut names: Vec<Option<u32>> = strokes.to_vec();
    names.sort_unstable();
    names.dedup();
    let labels: Vec<u32> =
        strokes.iter().map(|s| small(names.partition_point(|name| name < s))).collect();
    let (pieces, count) = connected_charts(mesh, &labels);
    let mut numbers = vec![NONE; count];
    let mut state = VsaState { face_charts: vec![NONE; labels.len()], ..VsaState::default() };
    for f in mesh.faces().filter(|f| strokes[f.index()].is_some()) {
        let number = &mut numbers[pieces[f.index()] as usize];
        if *number == NONE {
            *number = small(state.charts.len());
            state.charts.push(faces.chart(f));
        }
        state.charts[*number as usize].faces.push(f);
        state.face_charts[f.index()] = *number;
    }
    for chart in &mut state.charts {
        faces.fit(chart);
    }
    let topology = mesh.topology();
    let component = |f: FaceId| topology.face_components[f.index()] as usize;
    let mut has_chart = vec![false; topology.components];
    for chart in &state.charts {
        has_chart[component(chart.seed)] = true;
    }
    for f in std::iter::once(seed_face).chain(mesh.faces()) {
        if !std::mem::replace(&mut has_chart[component(f)], true) {
            state.face_charts[f.index()] = small(state.charts.len());
            let mut chart = faces.chart(f);
            chart.faces.push(f);
            state.charts.push(chart);
        }
    }
    let all: Vec<u32> = (0..small(state.charts.len())).collect();
    faces.spread(&mut state, &all);
    for chart in &mut state.charts {
        faces.fit(chart);
    }
    state
}

impl Flow for VsaFlow {
    type State = VsaState;

    fn state(&self) -> &VsaState {
        &self.progress.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.progress.status == Status::Running {
            self.advance();
            self.progress.step += 1;
        }
        let state = &self.progress.state;
        if !state.error.is_finite() {
            return Err(SolveError::NotFinite);
        }
        #[expect(clippy::cast_possible_truncation, reason = "a fraction")]
        let progress = match state.phase {
            VsaPhase::Done => 1.0,
            _ => (self.params.tolerance / state.worst.max(self.params.tolerance)) as f32 * 0.95,
        };
        Ok(StepReport {
            step: self.progress.step,
            energy: vec![
                ("Σ error", state.error),
                ("worst chart", state.worst),
                ("charts", state.charts.len() as f64),
            ],
            residual: 0.0,
            progress: Some(progress),
            status: self.progress.status,
        })
    }
}
