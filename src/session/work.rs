//! A document at work: its parameters, its cut, and what is made of both for tables, pictures and files.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::rc::Rc;

use super::comparing::ResultCard;
use super::cones::{ConeComparisonRow, Cones, Edits, KnownPath};
use super::document::Document;
use super::folding::Fold;
use super::inputs::{self, Layers};
use super::layout::Layout;
use super::message::{Event, PatternSize, PieceRow, Row, Term};
use super::method::Method;
use super::params::Settings;
use super::patterning::Patterning;
use super::project::Log;
use super::refining::Refinement;
use super::report::{CutReport, FlattenReport, HistoryRow, patch_reports};
use super::scene::LayerScene;
use super::segmenting::{DevelopCheckpoint, Developable, PhaseCheckpoint, PhaseField};
use super::surface::Surface;
use super::text::Problem;
use super::{picture, size};
use crate::geometry::Symmetry;
use crate::mesh::CutMesh;
use crate::methods::cutflow::{Checkpoint, CutFields, CutFlow, Pointwise, Stages};
use crate::methods::flow::{Flow, Status};

/// What was painted since the flow last looked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Pending {
    /// Nothing.
    #[default]
    None,
    /// Sources, penalties, pins: the next step acts on them.
    Fields,
    /// Where the flow starts, and the stroke goes on: there is no hurry.
    Stroke,
    /// Where the flow starts.
    Restart,
}

/// A document, its parameters and its cut.
pub(super) struct Work {
    pub document: Rc<Document>,
    pub method: Method,
    pub settings: Settings,
    pub layers: Layers,
    pub pending: Pending,
    /// Symmetries that were found, once somebody looked.
    pub symmetries: Option<Rc<Vec<Symmetry>>>,
    /// One step of the paper's flow from the current cut, for whoever wants to see it.
    pub stages: Option<Stages>,
    pub fold: Option<Fold>,
    /// Charts at rest that are evened out.
    pub refinement: Option<Refinement>,
    pub flow: Option<CutFlow>,
    pub history: Vec<HistoryRow>,
    pub layout: Option<Layout>,
    /// Overlapping charts of the segments at rest, once they were looked at.
    pub atlas: Option<LayerScene>,
    /// The pattern of the layout at rest, once somebody asked for it.
    pub patterning: Option<Patterning>,
    /// Allowances of single seams of that layout, mm.
    pub seam_allowances: BTreeMap<usize, f64>,
    /// The cut that those seams belong to.
    pub seam_edges: Vec<[u32; 2]>,
    /// A cut from a file that is laid out as it is, until the flow makes another.
    pub given: Option<CutMesh>,
    /// The layout at rest is of the current cut.
    pub is_settled: bool,
    /// But its charts are as they come: they may overlap themselves, or be missing.
    pub is_sketched: bool,
    /// Shown, but not cut yet.
    pub first_cut_is_due: bool,
    pub start: Option<Vec<Row>>,
    /// Optimal cones.
    pub cones: Cones,
    /// A phase field.
    pub phase: PhaseField,
    /// Developable patches.
    pub develop: Developable,
    /// Results beside this one, for the report.
    pub compared: Vec<ResultCard>,
    /// What other methods show, for coming back to them.
    pub shelf: BTreeMap<Method, Shelf>,
    pub revision: u32,
}

/// What a method shows.
pub(super) struct Shelf {
    pub field: String,
    layout: Option<Layout>,
    pub is_settled: bool,
    start: Option<Vec<Row>>,
    seam_allowances: BTreeMap<usize, f64>,
    seam_edges: Vec<[u32; 2]>,
}

/// What Undo goes back to.
#[derive(Clone)]
pub(super) struct Snapshot {
    /// The change that came after.
    pub label: String,
    /// What Undo calls a run of the same kind of changes; those are taken back together.
    pub kind: String,
    pub document: Rc<Document>,
    pub method: Method,
    pub settings: Settings,
    pub layers: Layers,
    pub edits: Edits,
    /// The path over λ, and cones compared with others: results of the document as it was.
    pub path: KnownPath,
    pub cone_comparison: Vec<ConeComparisonRow>,
    /// Whether somebody had stopped their solver on its way.
    pub were_cones_paused: bool,
    pub pending: Pending,
    pub symmetries: Option<Rc<Vec<Symmetry>>>,
    pub checkpoint: Option<Checkpoint>,
    pub phase: Option<PhaseCheckpoint>,
    pub develop: Option<DevelopCheckpoint>,
    pub first_cut_is_due: bool,
    pub history: Vec<HistoryRow>,
    pub start: Option<Vec<Row>>,
    /// Allowances of single seams, and the edges of the cut whose seams have these numbers.
    pub seam_allowances: BTreeMap<usize, f64>,
    pub seam_edges: Vec<[u32; 2]>,
    /// What had been done until then.
    pub log: Log,
    pub was_running: bool,
    /// Whether the surface was shown folded from its pieces, which Undo does not show again.
    pub was_folded: bool,
}

impl Work {
    pub fn step(&self) -> usize {
        match self.method {
            Method::CutFlow => self.flow.as_ref().map_or(0, CutFlow::steps),
            Method::Cones => self.cones.rounds,
            Method::PhaseField | Method::Developable => {
                self.segmentation().map_or(0, |segmentation| segmentation.steps())
            }
        }
    }

    /// Shows another method; what this one shows is kept beside it.
    ///
    /// **Takes** the field that is painted. **Gives** the one that the other method had painted, if it was shown before.
    pub fn change_method(&mut self, method: Method, field: &str) -> Option<String> {
        // What is evened out half begins again when it is shown again.
        let is_unfinished = self.refinement.take().is_some_and(|refinement| refinement.is_running);
        // What is sketched is made whole, or sketched anew, when it is shown again.
        let is_sketched = std::mem::take(&mut self.is_sketched);
        let shelf = Shelf {
            field: field.to_owned(),
            layout: self.layout.take(),
            is_settled: std::mem::take(&mut self.is_settled) && !is_unfinished && !is_sketched,
            start: self.start.take(),
            seam_allowances: std::mem::take(&mut self.seam_allowances),
            seam_edges: std::mem::take(&mut self.seam_edges),
        };
        self.drop_pattern();
        self.shelf.insert(self.method, shelf);
        self.method = method;
        self.fold = None;
        let other = self.shelf.remove(&method)?;
        self.layout = other.layout;
        self.is_settled = other.is_settled;
        self.start = other.start;
        self.seam_allowances = other.seam_allowances;
        self.seam_edges = other.seam_edges;
        Some(other.field)
    }

    pub fn labels(&self) -> Vec<u32> {
        let labels = match (&self.flow, self.method) {
            (Some(flow), Method::CutFlow) => Some(flow.state().labels().to_vec()),
            _ => self.segmentation().and_then(|segmentation| segmentation.labels()),
        };
        labels.unwrap_or_else(|| vec![0; self.vertex_count()])
    }

    pub fn u(&self) -> Vec<f64> {
        match (&self.flow, self.method) {
            (Some(flow), Method::CutFlow) => flow.state().u().to_vec(),
            _ => vec![0.0; self.vertex_count()],
        }
    }

    /// A flow from the initial cut, or from a checkpoint.
    pub fn new_flow(&self, checkpoint: Option<&Checkpoint>) -> Result<CutFlow, Problem> {
        start_flow(&self.document, &self.settings, &self.layers, checkpoint)
    }

    /// Sources, penalties and pins as they are now.
    pub fn fields(&self) -> CutFields {
        inputs::fields(&self.settings, &self.layers, self.vertex_count())
    }

    /// Tells the curve by what the flow measures now: the steps before by the new weights too, as far as their terms were
    /// measured; from the current cut on where they were not.
    pub fn remeasure(&mut self) {
        let Some(flow) = &self.flow else { return };
        let weights = *flow.weights();
        let params = *flow.params();
        let now = HistoryRow::new(flow.steps(), &flow.state().energy(), &weights);
        match self.history.last() {
            Some(last) if last.weights.measures_like(&weights) => {
                for row in &mut self.history {
                    // With a schedule every step has an α of its own.
                    *row = row.reweighted(&params.weights_at(row.step));
                }
            }
            _ => self.history.clear(),
        }
        self.history.pop();
        self.history.push(now);
        self.stages = None;
        if now.step == 0 {
            // The start is measured by the new weights.
            self.start = self.is_settled.then(|| self.rows());
        }
    }

    /// Tells the flow the parameters and what was painted.
    pub fn tell_flow(&mut self) -> Result<(), Problem> {
        let fields = self.fields();
        let params = self.settings.flow_params();
        let name = &self.document.name;
        let wrong = |error| Problem::solve(name, &error);
        if let Some(flow) = &mut self.flow {
            flow.set_params(params).map_err(wrong)?;
            flow.set_fields(&fields).map_err(wrong)?;
            self.remeasure();
        }
        Ok(())
    }

    /// Another method has heard of what was painted: the cut flow that stands aside hears of it too, as it does when Undo makes it anew.
    pub fn tell_flow_aside(&mut self) -> Result<(), Problem> {
        match std::mem::take(&mut self.pending) {
            Pending::Fields => self.tell_flow(),
            _ => Ok(()),
        }
    }

    fn vertex_count(&self) -> usize {
        self.document.surface.as_ref().map_or(0, |surface| surface.mesh.vertex_count())
    }

    /// The current cut on the surface as it was given; none at all without a flow.
    pub fn cut_mesh(&self, surface: &Surface) -> CutMesh {
        if let Some(segmentation) = self.segmentation() {
            return segmentation.cut(surface).unwrap_or_else(|| CutMesh::uncut(&surface.mesh));
        }
        match &self.flow {
            _ if self.given.is_some() => {
                self.given.clone().unwrap_or_else(|| CutMesh::uncut(&surface.mesh))
            }
            None => CutMesh::uncut(&surface.mesh),
            Some(flow) if surface.solving.is_some() => {
                flow.cut_mesh_on(&surface.mesh, &surface.geometry)
            }
            Some(flow) => flow.cut_mesh(),
        }
    }

    /// Whether there is a cut to show.
    pub fn has_cut(&self) -> bool {
        match self.segmentation() {
            Some(segmentation) => segmentation.status().is_some(),
            None => self.method == Method::CutFlow && self.flow.is_some(),
        }
    }

    /// J and its terms at every step so far.
    pub fn energy_curve(&self) -> Vec<Event> {
        match self.segmentation() {
            Some(segmentation) => segmentation.curve().to_vec(),
            None => self.history.iter().map(energy_event).collect(),
        }
    }

    pub fn snapshot(&self, label: &str, kind: &str) -> Snapshot {
        Snapshot {
            label: label.to_owned(),
            kind: kind.to_owned(),
            document: self.document.clone(),
            method: self.method,
            settings: self.settings.clone(),
            layers: self.layers.clone(),
            edits: self.cones.edits.clone(),
            path: self.cones.path.clone(),
            cone_comparison: self.cones.comparison.clone(),
            were_cones_paused: self.cones.is_stale && self.cones.is_held,
            pending: self.pending,
            symmetries: self.symmetries.clone(),
            checkpoint: self.flow.as_ref().map(CutFlow::checkpoint),
            phase: self.phase.checkpoint(),
            develop: self.develop.checkpoint(),
            first_cut_is_due: self.first_cut_is_due,
            history: self.history.clone(),
            start: self.start.clone(),
            seam_allowances: self.seam_allowances.clone(),
            seam_edges: self.seam_edges.clone(),
            log: Log::default(),
            was_running: false,
            was_folded: self.fold.is_some(),
        }
    }

    /// A document at the start of a flow; without one the surface is shown whole.
    pub fn new(document: Rc<Document>, settings: Settings, flow: Option<CutFlow>) -> Self {
        let history = flow.iter().map(first_row).collect();
        Self {
            document,
            method: Method::CutFlow,
            settings,
            layers: Layers::default(),
            pending: Pending::None,
            symmetries: None,
            stages: None,
            fold: None,
            refinement: None,
            flow,
            history,
            layout: None,
            atlas: None,
            patterning: None,
            seam_allowances: BTreeMap::new(),
            seam_edges: Vec::new(),
            given: None,
            is_settled: false,
            is_sketched: false,
            first_cut_is_due: false,
            start: None,
            cones: Cones::default(),
            phase: PhaseField::default(),
            develop: Developable::default(),
            compared: Vec::new(),
            shelf: BTreeMap::new(),
            revision: 0,
        }
    }

    /// Goes on with another flow from its start.
    pub fn begin(&mut self, flow: CutFlow) {
        self.history = vec![first_row(&flow)];
        self.given = None;
        self.flow = Some(flow);
        self.pending = Pending::None;
        // Whatever seams there will be, they are others.
        if self.method == Method::CutFlow {
            self.seam_allowances.clear();
        } else if let Some(shelf) = self.shelf.get_mut(&Method::CutFlow) {
            shelf.seam_allowances.clear();
            shelf.is_settled = false;
        }
        self.fold = None;
        self.stages = None;
        self.first_cut_is_due = false;
        self.start = None;
        self.is_settled = false;
    }

    /// The flow has made another cut than the one that was given.
    pub fn drop_given(&mut self) {
        self.given = None;
    }

    /// Millimetres per √area.
    pub fn mm_per_unit(&self) -> f64 {
        let unit = self.document.surface.as_ref().map_or(1.0, |s| s.frame.scale);
        size::mm_per_file_unit(&self.document, &self.settings) / unit
    }

    /// The rows of the table of measures, without their starts.
    pub fn rows(&self) -> Vec<Row> {
        let Some(layout) = &self.layout else { return Vec::new() };
        let totals = &layout.measures.totals;
        let mut rows = vec![
            Row::new("pieces", "Pieces", "", layout.opened.patch_count as f64),
            Row::new("cut_length", "Cut length", "√A", layout.cut_length()),
            Row::new("area_distortion", "Area distortion", "", totals.area_distortion),
            Row::new("angle_distortion", "Angle distortion", "", totals.angle_distortion),
            Row::new("stretch", "Stretch L²", "", totals.l2_stretch),
            Row::new("flipped", "Flipped triangles", "", totals.flipped as f64),
            Row::new("overlaps", "Overlaps", "", layout.overlaps() as f64),
        ];
        if let Some(set) = self.cones.set.as_ref().filter(|_| self.method == Method::Cones) {
            rows.push(Row::new("cones", "Cones", "", set.count() as f64));
            rows.push(Row::new("total_angle", "Total angle Φ", "π", set.total_angle / PI));
            rows.push(Row::new("int_u2", "Distortion ∫u²", "", set.int_u2));
        }
        let flow = self.flow.as_ref().filter(|_| self.method == Method::CutFlow);
        if let Some(flow) = flow {
            let energy = flow.state().energy();
            rows.push(Row::new("dirichlet", "Dirichlet ∫|∇u|²", "", energy.dirichlet));
            rows.push(Row::new("hencky", "Hencky ∫u²", "", energy.hencky));
        }
        if let Some(segmentation) = self.segmentation() {
            rows.extend(segmentation.rows(self.is_settled.then_some(layout)));
        }
        if let Some(flow) = flow.filter(|flow| flow.params().schedule.is_some()) {
            rows.push(Row::new("alpha", "Length weight α now", "/√A", flow.weights().length));
        }
        if layout.disk_cut_length > 0.0 {
            rows.push(Row::new("disk_cuts", "Added for disks", "√A", layout.disk_cut_length));
        }
        rows
    }

    pub fn measures(&self) -> Event {
        let mut rows = self.rows();
        for row in &mut rows {
            let start = self.start.iter().flatten().find(|s| s.id == row.id);
            row.start = start.and_then(|s| s.now);
        }
        let Some(layout) = &self.layout else {
            return Event::Measures { rows, pieces: Vec::new(), pattern: None, note: None };
        };
        let colours = picture::patch_colours(layout, &self.labels());
        let areas = layout.patch_areas();
        let seams = layout.seam_lengths();
        let total: f64 = areas.iter().sum();
        let pieces = (0..layout.opened.patch_count)
            .map(|patch| {
                let measures = layout.measures.charts[patch].as_ref();
                let flipped = measures.map_or(0, |m| m.flipped);
                let overlaps = measures.map_or(0, |m| m.overlaps);
                let note = layout.note(patch).unwrap_or_default();
                PieceRow {
                    patch,
                    color: colours[patch],
                    area_fraction: areas[patch] / total,
                    seam_length: seams[patch],
                    // A piece without area has none.
                    rms_u: measures.map(|m| (m.hencky / m.area).sqrt()).filter(|x| x.is_finite()),
                    flipped,
                    overlaps,
                    has_chart: measures.is_some(),
                    note,
                }
            })
            .collect();
        let mm = self.mm_per_unit();
        let sheet = layout.packing.sheet;
        let charts = layout.measures.charts.iter().flatten();
        let flat: f64 =
            charts.map(|m| m.area * (1.0 + m.area_change)).filter(|area| area.is_finite()).sum();
        let pattern = (sheet.x > 0.0).then(|| PatternSize {
            width: sheet.x * mm,
            height: sheet.y * mm,
            unit: "mm".into(),
            filled: flat / (sheet.x * sheet.y),
            // Scenes have radius 1.
            unit_length: self.document.surface.as_ref().map_or(1.0, Surface::radius) * mm,
            overlaps: layout.overlaps(),
        });
        Event::Measures { rows, pieces, pattern, note: self.note(layout) }
    }

    pub fn cut_report(&self, seconds: Option<f64>) -> Result<CutReport, Problem> {
        let (Some(layout), Some(flow)) = (&self.layout, &self.flow) else {
            // What stands in its way says itself when it is begun again.
            let begun = start_flow(&self.document, &self.settings, &self.layers, None);
            return Err(begun.err().unwrap_or_else(|| {
                Problem::new(
                    "There is no cut to report on.",
                    format!("{}, initial cut.", self.document.name),
                    "Choose another initial cut.",
                )
            }));
        };
        let energy = flow.state().energy();
        let mut labels = self.labels();
        labels.sort_unstable();
        labels.dedup();
        let steps = flow.steps();
        Ok(CutReport {
            vertices: self.document.summary.vertices,
            faces: self.document.summary.faces,
            regions: labels.len(),
            steps,
            status: match flow.status() {
                Status::Converged => "converged",
                Status::Stalled => "stalled",
                Status::Infeasible => "infeasible",
                Status::StepLimit => "step_limit",
                Status::Running if steps as f64 >= self.settings.number("steps") => "step_limit",
                Status::Running => "paused",
            },
            history: self.history.clone(),
            // Not −0, which is the sum of nothing.
            cut_length: energy.length + 0.0,
            disk_cut_length: layout.disk_cut_length,
            hencky: energy.hencky,
            dirichlet: energy.dirichlet,
            residual: flow.state().residual(),
            patches: patch_reports(layout),
            flattening: FlattenReport::new(layout, None),
            mm_per_unit: size::mm_per_file_unit(&self.document, &self.settings),
            penalty: energy.penalty,
            region_area: energy.area,
            notices: self.notices(layout),
            symmetry: self.layers.symmetry.ids.clone(),
            fold: None,
            seconds,
            seconds_per_step: seconds.filter(|_| steps > 0).map(|s| s / steps as f64),
        })
    }
}

/// A flow from the initial cut that the parameters ask for, or from a checkpoint.
pub(super) fn start_flow(
    document: &Document,
    settings: &Settings,
    layers: &Layers,
    checkpoint: Option<&Checkpoint>,
) -> Result<CutFlow, Problem> {
    let wrong = |error| document.unsolved(&error);
    let surface = document.surface()?;
    let (mesh, geometry) = surface.solving_shared();
    let fields = inputs::fields(settings, layers, mesh.vertex_count());
    let params = settings.flow_params();
    match checkpoint {
        Some(checkpoint) => CutFlow::resume(mesh, geometry, checkpoint, params, &fields),
        None => {
            let initial = inputs::initial(settings, layers, surface)?;
            CutFlow::with_fields(mesh, geometry, &initial, params, &fields)
        }
    }
    .map_err(wrong)
}

/// The history's row of a flow that has just begun.
pub(super) fn first_row(flow: &CutFlow) -> HistoryRow {
    HistoryRow::new(flow.steps(), &flow.state().energy(), flow.weights())
}

/// A point of the energy plot.
pub(super) fn energy_event(row: &HistoryRow) -> Event {
    let weights = &row.weights;
    let distortion = match (weights.dirichlet > 0.0, weights.hencky > 0.0) {
        (true, false) => "Dirichlet",
        (false, true) if weights.pointwise == Pointwise::Square => "Hencky",
        _ => "Distortion",
    };
    let energy = &row.energy;
    let term = |name: &str, value: f64| Term { name: name.into(), value };
    let mut terms =
        vec![term("Length α|γ|", weights.length * energy.length), term(distortion, row.distortion)];
    if energy.penalty > 0.0 && weights.penalty > 0.0 {
        terms.push(term("Penalty", weights.penalty * energy.penalty));
    }
    if weights.area > 0.0 {
        terms.push(term("Growth", -weights.area * energy.area));
    }
    Event::Energy { step: row.step, total: row.total, terms }
}
