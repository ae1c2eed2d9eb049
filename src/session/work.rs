//! A document at work: its parameters, its cut, and what is made of both for tables, pictures and files.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::rc::Rc;

use super::charting::{Charting, FlattenBy};
use super::comparing::ResultCard;
use super::cones::{ConeComparisonRow, Cones, ConesReport, Edits, KnownPath};
use super::document::Document;
use super::folding::Fold;
use super::inputs::{self, Layers};
use super::layout::{Finish, Layout};
use super::message::{Event, File, PatternSize, PieceRow, Row, Term};
use super::method::Method;
use super::params::Settings;
use super::patterning::Patterning;
use super::project::Log;
use super::refining::Refinement;
use super::report::{CutReport, FlattenReport, HistoryRow, InfoReport, patch_reports};
use super::scene::LayerScene;
use super::segmenting::{
    DevelopCheckpoint, DevelopReport, Developable, PhaseCheckpoint, PhaseField, PhaseFieldReport,
    SHOWN_FLAT,
};
use super::surface::Surface;
use super::text::Problem;
use super::{nothing_open, picture, size};
use crate::geometry::Symmetry;
use crate::mesh::CutMesh;
use crate::methods::cutflow::{Checkpoint, CutFields, CutFlow, Pointwise, Stages};
use crate::methods::flow::{Flow, Status};
use crate::pattern;

/// The export that needs no cut.
pub(super) const MESH: &str = "Mesh (OBJ)";

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
    given: Option<CutMesh>,
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
    is_settled: bool,
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
    fn cut_mesh(&self, surface: &Surface) -> CutMesh {
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

    /// The layout of a running flow: with the flow's own factor where all patches are disks, whole otherwise.
    pub fn preview(&mut self) -> Result<(), Problem> {
        if self.method == Method::Cones {
            // The charts of the cones before stay until there is time for new ones.
            return Ok(());
        }
        let surface = self.document.surface()?;
        let wrong = |error| Problem::solve(&surface.name, &error);
        if self.segmentation().is_some() {
            let layout = self.sketched(surface)?;
            self.put_layout(layout);
            return Ok(());
        }
        let packing = self.layout.as_ref().map(|l| &l.packing);
        // The flow's factor belongs to the triangles that it solves on.
        if let Some(flow) = self.flow.as_mut().filter(|_| surface.solving.is_none()) {
            let cut = flow.cut_mesh();
            let factor = flow.factor().map_err(|error| wrong(error.into()))?;
            let layout = Layout::preview(surface, cut, factor, packing).map_err(wrong)?;
            if layout.is_complete() {
                self.put_layout(layout);
                return Ok(());
            }
        }
        // Nothing is repaired while the cut moves: that would be another cut.
        let by = FlattenBy::Bff;
        let charting = Charting { by, splits: false, ..Charting::default() };
        let layout = Layout::full(surface, self.cut_mesh(surface), &charting, packing)
            .map_err(|error| error.problem(&surface.name))?;
        self.put_layout(layout);
        Ok(())
    }

    /// The pieces of a segmentation with charts as they come, or without where there are many.
    fn sketched(&self, surface: &Surface) -> Result<Layout, Problem> {
        let packing = self.layout.as_ref().map(|l| &l.packing);
        let by = FlattenBy::Bff;
        let charting = Charting { by, splits: false, ..Charting::default() };
        Layout::sketch(surface, self.cut_mesh(surface), &charting, SHOWN_FLAT, packing)
            .map_err(|error| error.problem(&surface.name))
    }

    /// A layout at rest for those who only look: whoever wants a pattern or a file has it made whole.
    pub fn sketch(&mut self) -> Result<(), Problem> {
        let layout = self.sketched(self.document.surface()?)?;
        // Allowances belong to the seams of the whole one.
        self.show(layout);
        (self.is_settled, self.is_sketched) = (true, true);
        Ok(())
    }

    fn put_layout(&mut self, layout: Layout) {
        // Seams of another cut have other numbers.
        if self.seam_edges != layout.cut.cut_edges {
            self.seam_allowances.clear();
            self.seam_edges.clone_from(&layout.cut.cut_edges);
        }
        self.show(layout);
    }

    /// A fold belongs to the layout that it was made of, and so does a refinement.
    fn show(&mut self, layout: Layout) {
        self.layout = Some(layout);
        self.drop_pattern();
        self.atlas = None;
        self.fold = None;
        self.refinement = None;
    }

    /// Whether the cut is that of developable pieces whose first borders are still being found.
    pub fn has_first_pieces_only(&self) -> bool {
        let is_first = self.develop.stage() == Some("vsa");
        self.method == Method::Developable && self.given.is_none() && is_first
    }

    pub fn settle(&mut self) -> Result<(), Problem> {
        let surface = self.document.surface()?;
        self.is_sketched = false;
        if self.method == Method::Cones {
            let packing = self.layout.as_ref().map(|l| &l.packing);
            let Some(set) = &self.cones.set else { return Ok(()) };
            let charting = Charting::of(&self.settings);
            let layout = Layout::of_cones(surface, set, &self.seam_cost(), &charting, packing)
                .map_err(|error| error.problem(&surface.name))?;
            self.put_layout(layout);
            self.is_settled = true;
            self.begin_refinement();
            return Ok(());
        }
        if self.method == Method::Developable
            && Charting::of(&self.settings).by == FlattenBy::Auto
            && let Some((cut, opened, flattening)) = self.develop.maps()
        {
            // The very maps that pieces were accepted with.
            let packing = self.layout.as_ref().map(|l| &l.packing);
            let layout = Layout::of_maps(surface, cut, opened, flattening, packing);
            self.put_layout(layout);
            self.is_settled = true;
            if self.start.is_none() {
                self.start = Some(self.rows());
            }
            self.begin_refinement();
            return Ok(());
        }
        // The whole layout takes the most memory of all: what it does not need makes room for it.
        if let Some(flow) = &mut self.flow {
            flow.rest();
        }
        let cut = self.cut_mesh(surface);
        let packing = self.layout.take().map(|layout| layout.packing);
        // Patches of triangles end at edges of the mesh as it is.
        let is_free = self.method != Method::Developable && self.given.is_none();
        let mut charting = Charting::of(&self.settings);
        // First pieces are often too far from flat for rims of true length.
        let is_nearly_flat = self.method == Method::Developable && !self.has_first_pieces_only();
        if is_nearly_flat && charting.by == FlattenBy::Auto {
            charting.by = FlattenBy::Lpfb;
        }
        let finish = Finish {
            straighten: is_free && self.settings.is_on("straighten"),
            snap: is_free && self.settings.is_on("snap"),
            pins: &self.layers.pin,
            charting,
        };
        let layout = Layout::finished(surface, cut, &finish, packing.as_ref())
            .map_err(|error| error.problem(&surface.name))?;
        self.put_layout(layout);
        self.is_settled = true;
        // Before there are patches the uncut surface is no start to compare with.
        if self.start.is_none() && self.method != Method::Developable {
            self.start = Some(self.rows());
        }
        self.begin_refinement();
        Ok(())
    }

    /// Cuts are finished another way: what was laid out is laid out anew, also what other methods show.
    pub fn finish_anew(&mut self) {
        self.is_settled = false;
        self.shelf.values_mut().for_each(|shelf| shelf.is_settled = false);
    }

    /// The flow has made another cut than the one that was given.
    pub fn drop_given(&mut self) {
        self.given = None;
    }

    /// Flattens a cut as it is.
    pub fn lay_out(&mut self, cut: CutMesh) -> Result<(), Problem> {
        self.given = Some(cut);
        self.first_cut_is_due = false;
        self.settle()
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
            rows.extend(segmentation.rows());
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

    pub fn export(&mut self, kind: &str) -> Result<File, Problem> {
        if let Some(made) = self.pattern_export(kind) {
            return made;
        }
        let document = &*self.document;
        if kind == MESH {
            let mm = size::stated(document, &self.settings);
            return Ok(File {
                name: format!("{}-mesh.obj", stem(&document.name)),
                mime: "model/obj",
                bytes: pattern::mesh_obj(&document.soup, mm),
            });
        }
        let given = document.surface()?;
        let Some(layout) = &self.layout else { return Err(nothing_open()) };
        let scale = size::mm_per_file_unit(document, &self.settings);
        let surface = layout.surface(given, Some(scale));
        let stem = stem(&document.name);
        let file =
            |suffix: &str, mime, bytes| File { name: format!("{stem}-{suffix}"), mime, bytes };
        match kind {
            "Cut curves (OBJ)" => Ok(file("cut.obj", "model/obj", pattern::cut_obj(&surface))),
            "Cut (JSON)" => {
                let bytes = pattern::cut_json(&surface, &layout.labels(&self.labels()));
                Ok(file("cut.json", "application/json", bytes))
            }
            "Folded surface (OBJ)" => {
                let Some(fold) = &self.fold else {
                    return Err(Problem::new(
                        "The surface has not been folded.",
                        format!("{}.", document.name),
                        "Choose Fold preview first.",
                    ));
                };
                let unit = 1.0 / given.frame.scale;
                let places: Vec<[f64; 3]> = fold
                    .flow
                    .positions()
                    .iter()
                    .map(|p| (given.frame.centre + p.coords * unit).into())
                    .collect();
                Ok(file("folded.obj", "model/obj", folded_obj(layout, &places)))
            }
            "Cones (JSON)" if self.method == Method::Cones => {
                let bytes = self.cones_file()?;
                Ok(file("cones.json", "application/json", bytes))
            }
            "Report (JSON)" => {
                #[derive(serde::Serialize)]
                struct Whole {
                    info: InfoReport,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    cut: Option<CutReport>,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    cones: Option<ConesReport>,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    phasefield: Option<PhaseFieldReport>,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    develop: Option<DevelopReport>,
                    #[serde(skip_serializing_if = "Vec::is_empty")]
                    comparison: Vec<ResultCard>,
                }
                let info = InfoReport::new(document);
                let mut whole = Whole {
                    info,
                    cut: None,
                    cones: None,
                    phasefield: None,
                    develop: None,
                    comparison: self.compared.clone(),
                };
                match self.method {
                    Method::CutFlow => whole.cut = Some(self.cut_report(None)?),
                    Method::Cones => whole.cones = Some(self.cones_report(None)?),
                    Method::PhaseField => whole.phasefield = Some(self.phase_report(None)?),
                    Method::Developable => whole.develop = Some(self.develop_report(None)?),
                }
                let bytes = self.json(&whole)?;
                Ok(file("report.json", "application/json", bytes))
            }
            _ => Err(Problem::new(
                format!("There is no export called “{kind}”."),
                "In the choice of an export.",
                "Choose Mesh (OBJ), UV mesh (OBJ), UV mesh (GLB), Flat mesh (OBJ), Cut surface (PLY), Cut curves (OBJ), Cut (JSON), Cones (JSON), \
                 Pattern (SVG), Pattern (DXF), Pattern (PDF), Report (JSON), Project (JSON) or All files (ZIP).",
            )),
        }
    }

    pub(super) fn json(&self, value: &impl serde::Serialize) -> Result<Vec<u8>, Problem> {
        serde_json::to_vec_pretty(value).map_err(|error| {
            Problem::new(
                format!("The report could not be written: {error}."),
                format!("{}.", self.document.name),
                "Reset the run and try again.",
            )
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

/// A folded surface with its texture coordinates left out: points of the cut surface, seams sewn.
fn folded_obj(layout: &Layout, places: &[[f64; 3]]) -> Vec<u8> {
    let mut text = String::from("# the surface rebuilt from its flat pieces\n");
    for [x, y, z] in places {
        text += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c] in &layout.cut.triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

/// A file name without its folders.
pub(super) fn base_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// A file name without its ending, safe to offer for saving.
pub(super) fn stem(name: &str) -> String {
    let base = base_name(name);
    let stem = base.rsplit_once('.').map_or(base, |(stem, _)| stem);
    let clean: String = stem
        .chars()
        .map(|c| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' })
        .collect();
    // What is appended must fit into the 255 bytes that a file's name may have.
    let end = clean.char_indices().map(|(at, c)| at + c.len_utf8()).take_while(|&end| end <= 80);
    let clean = clean[..end.last().unwrap_or(0)].trim().replace(' ', "-");
    if clean.is_empty() { "cutflow".into() } else { clean }
}
