//! Commands in, events out: what page, command line and tests drive.
//!
//! A [`Session`] holds at most one [`Document`] and one running [`CutFlow`]. [`Session::handle`] is short and never steps;
//! [`Session::advance`] steps the running flow while the driver says so. Pictures, tables and exports are made from a
//! [`Layout`] of the current cut: a preview while the flow runs, the whole truth (every patch cut to disks) at rest.
//!
//! Guaranteed: after an error the document is what it was; a step that fails leaves the last cut; the same commands with the
//! same number of steps between them give the same bytes. Not guaranteed: a chart for every patch while a flow runs.
//!
//! This is the only floor that serialises. It reads no clock: drivers measure time and hand in budgets.

mod blending;
mod brought;
mod charting;
mod comparing;
mod cones;
mod cut_file;
mod digest;
mod doctor;
mod document;
mod folding;
mod inputs;
mod keeping;
mod layout;
mod measuring;
mod message;
mod method;
mod notices;
mod outlines;
mod overlays;
mod paint;
mod params;
mod patterning;
mod picture;
mod preparing;
mod presets;
mod project;
mod refining;
mod regions;
mod report;
mod running;
pub mod samples;
pub mod scene;
mod segmenting;
mod size;
mod specs;
mod surface;
mod symmetric;
mod text;
mod undo;
mod work;

use std::rc::Rc;

use crate::methods::cutflow::CutFlow;
use crate::methods::flow::Status;
use comparing::Comparing;
use inputs::Layers;
use keeping::Kept;
use preparing::Preparation;
use project::{Entry, Gift, Log, Replay};
use work::{Pending, Snapshot, Work, start_flow};

pub use crate::flatten::comparison::Compared;
pub use brought::Brought;
pub use charting::{Charting, FlattenBy};
pub use comparing::{ChangedSetting, ResultCard, ResultProgress, ResultRow, ResultTable};
pub use cones::{
    ConeComparisonRow, ConePathPoint, ConeReport, ConeRow, ConeTable, ConesReport, RoundedReport,
};
pub use cut_file::{cut_from_json, cut_from_uv, specimen, sphere_obj, surface_layout};
pub use document::Document;
pub use layout::Layout;
pub use message::{
    ChangeName, Choice, Command, Condition, DoctorReport, Event, File, FindingText, MeshSummary,
    MethodChoice, NoticeText, PaintChannel, ParamKind, ParamSpec, PatternSize, PieceRow,
    PresetChoice, RepairChoice, Row, RunRequest, SampleChoice, Spot, StageNumber, StageNumbers,
    SymmetryChoice, Term, ToolParam, ToolSpec, Value,
};
pub use method::Method;
pub use outlines::Outline;
pub use params::{Effect, Settings};
pub use patterning::{PageView, PatternPieceReport, PatternReport, PatternSeamReport, PatternView};
pub use regions::FaceSource;
pub use report::{
    ComparisonReport, CutReport, FlattenReport, FoldReport, HistoryRow, InfoReport, RefinedReport,
};
pub use scene::Scene;
pub use segmenting::{
    DevelopReport, DevelopSeconds, DevelopStage, DevelopTable, PhaseFieldReport, Segment,
    SegmentTree,
};
pub use size::settings_for;
pub use specs::{all_specs, specs, specs_of};
pub use surface::Surface;
use text::{plural, shown_name};

pub use text::Problem;

/// Triangles beyond which a mesh is shown before its first cut is made.
const SHOWN_FIRST: usize = 50_000;

/// The export that holds everything.
const PROJECT: &str = "Project (JSON)";

/// Results side by side.
const COMPARISON: &str = "Comparison (CSV)";

/// All files that there are of a cut.
const ARCHIVE: &str = "All files (ZIP)";

/// One open mesh, its cut, and the way back.
#[derive(Default)]
pub struct Session {
    work: Option<Work>,
    is_running: bool,
    field: String,
    /// The finding that is marked on the surface.
    shown: Option<String>,
    preparation: Option<Preparation>,
    undo: Vec<Snapshot>,
    redo: Vec<Snapshot>,
    scene_is_new: bool,
    late: Vec<Event>,
    /// The method of the next mesh.
    wanted_method: Method,
    /// The method of the mesh that is being opened, where that decides.
    opening: Option<Method>,
    /// What was done since the mesh was opened.
    log: Log,
    /// What is to be done again of a project.
    replay: Replay,
    /// The cut of the mesh before, which may be kept.
    kept: Option<Kept>,
    /// Whether a control is held.
    is_held: bool,
    /// Whether somebody looks at the sheet of the pattern.
    is_pattern_shown: bool,
    /// Results side by side.
    comparing: Comparing,
}

impl Session {
    /// An empty session.
    pub fn new() -> Self {
        Self { field: "pieces".into(), ..Self::default() }
    }

    /// Does what a person asks for, in short time.
    pub fn handle(&mut self, command: Command) -> Vec<Event> {
        // A project that is still being opened goes no further once somebody takes over.
        let is_looking = matches!(command, Command::Hold { .. } | Command::EndStroke);
        let is_other = matches!(
            command,
            Command::OpenSample { .. }
                | Command::KeepCut
                | Command::Compare { .. }
                | Command::RestoreResult { .. }
        ) || is_travel(&command);
        if project::is_kept(&command) && !is_looking || is_other {
            self.replay = Replay::default();
        }
        self.do_again(command)
    }

    fn do_again(&mut self, command: Command) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.late);
        let entry = project::is_kept(&command).then(|| Entry::Do(command.clone()));
        self.heed_comparison(&command, &mut events);
        let was_folded = self.is_folded();
        let mut has_ended = false;
        if !goes_along_with_preparing(&command) && self.preparation.take().is_some() {
            has_ended = true;
            events.push(self.status());
        }
        if !matches!(command, Command::Paint { .. }) && !is_travel(&command) {
            has_ended |= self.is_stroke_open();
            self.end_stroke();
        }
        if has_ended && entry.is_none() {
            // What the command put an end to is at an end in a replay too, where the command itself is not done again.
            self.log.push(Entry::Do(Command::EndStroke));
        }
        let result = match command {
            Command::EndStroke => Ok(()),
            Command::Hello => {
                events.push(self.samples());
                events.push(self.methods());
                events.push(self.presets());
                Ok(())
            }
            Command::OpenSample { name } => self.adopt(Document::from_sample(&name), &mut events),
            Command::SetParameter { id, value } => self.set_parameter(&id, value, &mut events),
            Command::Hold { is_held } => {
                self.is_held = is_held;
                Ok(())
            }
            Command::Run => self.run(&mut events),
            Command::Pause => self.pause(&mut events),
            Command::Step => self.step(&mut events),
            Command::Reset => self.reset(&mut events),
            Command::ShowField { id } => {
                if picture::fields(self.method()).iter().any(|f| f.id == id) {
                    self.field = id;
                    self.scene_is_new = true;
                }
                events.push(self.fields());
                events.push(Event::Scene);
                Ok(())
            }
            Command::Undo => self.travel(-1, &mut events),
            Command::Redo => self.travel(1, &mut events),
            Command::Travel { changes } => self.travel(changes, &mut events),
            Command::DismissError => {
                events.push(self.status());
                Ok(())
            }
            // What was being prepared has been dropped above.
            Command::Cancel => {
                if let Some(work) = &mut self.work {
                    work.first_cut_is_due = false;
                }
                events.push(self.status());
                events.push(Event::Scene);
                Ok(())
            }
            Command::ShowFinding { id } => self.show_finding(id, &mut events),
            Command::Repair { id } => self.repair(Some(&id), &mut events),
            Command::RepairAll => self.repair(None, &mut events),
            Command::SetUnit { id } => {
                let id = if id == "inch" { "in".into() } else { id };
                self.set_parameter("unit", Value::Text(id), &mut events)
            }
            Command::SetSize { axis, value } => self.set_side(axis, value, &mut events),
            Command::Prepare { tool, values } => self.prepare(&tool, &values, &mut events),
            Command::ApplyPreset { id } => self.apply_preset(&id, &mut events),
            Command::Paint { channel, face, place, radius, value, begins } => {
                self.paint(&channel, face, place, radius, value, begins, &mut events)
            }
            Command::ClearPaint { channel } => self.clear_paint(&channel, &mut events),
            Command::PlaceCircle { face, place } => self.place_circle(face, place, &mut events),
            Command::HideFromCamera { eye } => self.hide_from_camera(eye, &mut events),
            Command::FindSymmetries => self.find_symmetries(&mut events),
            Command::SetSymmetry { ids } => self.set_symmetry(&ids, &mut events),
            Command::Fold => self.fold(&mut events),
            Command::Unfold => self.unfold(&mut events),
            Command::SetMethod { id } => self.set_method(&id, &mut events),
            Command::AddCone { face, place, angle } => {
                self.add_cone(face, place, angle, &mut events)
            }
            Command::MoveCone { cone, face, place } => {
                self.move_cone(cone, face, place, &mut events)
            }
            Command::SetConeAngle { cone, angle } => self.set_cone_angle(cone, angle, &mut events),
            Command::RemoveCone { cone } => self.remove_cone(cone, &mut events),
            Command::ClearCones => self.clear_cones(&mut events),
            Command::TracePath => self.trace_path(&mut events),
            Command::CompareCones => self.compare_cones(&mut events),
            Command::Measure { from, to } => self.measure(from, to, &mut events),
            Command::SelectSegment { node } => self.select_segment(node, &mut events),
            Command::Sew { patches, joins } => self.sew(patches, joins, &mut events),
            Command::HandOver => self.hand_over(&mut events),
            Command::KeepCut => self.keep_cut(&mut events),
            Command::ShowPattern { is_shown } => self.show_pattern(is_shown, &mut events),
            Command::Nest => self.nest(&mut events),
            Command::ApplyTrade { id } => self.apply_trade(&id, &mut events),
            Command::SetSeamAllowance { seam, mm } => {
                self.set_seam_allowance(seam, mm, &mut events)
            }
            Command::KeepResult { name, seconds } => {
                self.keep_result(name.as_deref(), seconds, &mut events)
            }
            Command::RestoreResult { id } => self.restore_result(id, &mut events),
            Command::RemoveResult { id } => self.remove_result(id, &mut events),
            Command::RenameResult { id, name } => self.rename_result(id, &name, &mut events),
            Command::Compare { runs, steps, waits } => {
                self.compare(&runs, steps, waits, &mut events)
            }
            Command::NextResult => {
                self.next_result(&mut events);
                Ok(())
            }
        };
        match (result, entry) {
            (Ok(()), Some(entry)) => self.log.push(entry),
            (Ok(()), None) => {}
            (Err(problem), entry) => {
                if has_ended && entry.is_some() {
                    self.log.push(Entry::Do(Command::EndStroke));
                }
                self.refuse(problem, &mut events);
                // What was asked for is not in force: controls go back to what is.
                events.push(self.parameters());
            }
        }
        self.tell_unfolded(was_folded, &mut events);
        self.tell_current(&mut events);
        events
    }

    /// Opens a file. What was open stays open if the file cannot be used.
    pub fn open(&mut self, name: &str, bytes: &[u8]) -> Vec<Event> {
        let name = &shown_name(name);
        if self.preparation.take().is_some() {
            // A replay gives it up as well.
            self.log.push(Entry::Do(Command::EndStroke));
        }
        if self.work.is_some() && cut_file::is_cut_file(bytes) {
            let mut events = self.handle(Command::SetMethod { id: Method::CutFlow.id().into() });
            events.extend(self.bring(Brought::Cut { name, bytes }));
            return events;
        }
        if self.work.is_some() && cones::is_cones_file(bytes) {
            let mut events = self.handle(Command::SetMethod { id: Method::Cones.id().into() });
            events.extend(self.bring(Brought::Cones { name, bytes }));
            return events;
        }
        let mut events = std::mem::take(&mut self.late);
        self.replay = Replay::default();
        let is_project = project::is_project_file(bytes);
        let kept = self.cut_at_hand().filter(|_| !is_project);
        let opened = if is_project {
            self.open_project(name, bytes, &mut events)
        } else {
            self.adopt(Document::from_bytes(name, bytes), &mut events)
        };
        match opened {
            Ok(()) => self.offer_to_keep(kept, &mut events),
            Err(problem) => self.refuse(problem, &mut events),
        }
        events
    }

    /// Steps the running flow while `go_on` says so, at least once.
    pub fn advance(&mut self, go_on: &mut dyn FnMut() -> bool) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.late);
        let was_folded = self.is_folded();
        while self.is_running() {
            if self.is_comparing() && self.replay.is_over() {
                if self.compare_on(&mut events) || !go_on() {
                    break;
                }
                continue;
            }
            let stepped = if self.replay.is_over() {
                self.log.step();
                self.step_once(&mut events)
            } else {
                self.replay_on(&mut events)
            };
            if let Err(problem) = stepped {
                self.replay = Replay::default();
                self.give_up(problem, &mut events);
                break;
            }
            if !go_on() {
                break;
            }
        }
        self.rest(&mut events);
        self.tell_unfolded(was_folded, &mut events);
        events.push(self.status());
        events.push(Event::Scene);
        events
    }

    /// A step that cannot be made ends what was going on.
    fn give_up(&mut self, problem: Problem, events: &mut Vec<Event>) {
        self.is_running = false;
        self.preparation = None;
        self.refuse(problem, events);
    }

    /// One step of what has most need of one.
    fn step_once(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        // A mesh that is being made anew needs no cut before.
        if self.preparation.is_some() {
            self.prepare_on(events)
        } else if self.is_behind() {
            self.catch_up(events)
        } else if self.cones_have_work() {
            self.cones_advance(events)
        } else if self.is_folding() {
            self.fold_on(events)
        } else if self.is_refining() {
            self.refine_on(events)
        } else if self.first_cut_is_due() {
            self.make_first_cut(events);
            Ok(())
        } else if self.is_nesting() {
            self.nest_on(events)
        } else if self.method() == Method::Cones {
            self.is_running = false;
            Ok(())
        } else if self.is_segmenting() {
            self.segment_on(events)
        } else {
            self.one_step(events)
        }
    }

    /// Flattens what has come to rest.
    fn rest(&mut self, events: &mut Vec<Event>) {
        let is_comparing = self.is_comparing();
        if let Some(work) = &mut self.work
            && !is_comparing
            && !self.is_running
            && self.preparation.is_none()
            && !work.first_cut_is_due
            && work.pending == Pending::None
            && work.method != Method::Cones
            && !work.is_settled
        {
            self.settle(events);
        }
    }

    /// Whether [`Session::advance`] has anything to do.
    pub fn is_running(&self) -> bool {
        !self.replay.is_over() || self.comparison_is_due() || self.has_work()
    }

    fn has_work(&self) -> bool {
        self.is_running
            || self.preparation.is_some()
            || self.first_cut_is_due()
            || self.is_behind()
            || self.is_folding()
            || self.is_refining()
            || self.cones_have_work()
            || self.is_nesting()
    }

    /// Whether something was painted that the flow does not know yet.
    pub(super) fn is_behind(&self) -> bool {
        let is_due = |work: &Work| !matches!(work.pending, Pending::None | Pending::Stroke);
        self.work.as_ref().is_some_and(is_due)
    }

    /// What was told of since the last answer: by pictures that were made meanwhile.
    pub fn take_late(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.late)
    }

    fn is_stroke_open(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.pending == Pending::Stroke)
    }

    /// The stroke has ended: what it painted is where the flow starts.
    pub(super) fn end_stroke(&mut self) {
        if let Some(work) = self.work.as_mut().filter(|work| work.pending == Pending::Stroke) {
            work.pending = Pending::Restart;
        }
    }

    fn first_cut_is_due(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.first_cut_is_due)
    }

    /// Makes the initial cut of a mesh that has only been shown so far.
    fn make_first_cut(&mut self, events: &mut Vec<Event>) {
        let Some(work) = &mut self.work else { return };
        work.first_cut_is_due = false;
        match work.new_flow(None) {
            Ok(flow) => work.begin(flow),
            Err(problem) => {
                // As with small meshes: opened all the same, with a notice. What Undo holds as well stays as it is.
                match Rc::get_mut(&mut work.document) {
                    Some(document) => {
                        document.summary.notices.push(no_initial_cut(&problem));
                        events.push(Event::Mesh(document.summary.clone()));
                        events.extend(self.mesh_events());
                    }
                    None => events.push(error_event(problem)),
                }
            }
        }
        self.push_energy(events);
        self.settle(events);
        events.push(self.status());
        events.push(Event::Scene);
    }

    /// The newest picture, if there is one that was not taken yet. Made here, when somebody wants to see it.
    pub fn scene(&mut self) -> Option<Scene> {
        if !std::mem::take(&mut self.scene_is_new) {
            return None;
        }
        let work = self.work.as_mut()?;
        let is_uncut = work.layout.is_none() && !work.has_cut();
        if work.document.surface.is_none() || is_uncut || self.shown.is_some() {
            let scene = doctor::scene(&work.document, self.shown.as_deref(), work.revision);
            work.revision += 1;
            return Some(scene);
        }
        if !work.is_settled && work.has_cut() {
            match work.preview() {
                Ok(()) => self.late.push(work.measures()),
                Err(problem) => {
                    // The flow itself goes on; the picture stays the last one.
                    self.late.push(error_event(problem));
                    return None;
                }
            }
        }
        let values = match work.vertex_field(&self.field) {
            Ok(values) => values,
            Err(problem) => {
                self.late.push(error_event(problem));
                None
            }
        };
        self.late.extend(work.stage_numbers(&self.field));
        let layout = work.layout.as_ref()?;
        let surface = work.document.surface.as_ref()?;
        let labels = work.labels();
        let colours = picture::patch_colours(layout, &labels);
        let folded = work.fold.as_ref().map(|fold| fold.flow.positions());
        let field = values.as_deref().map(|values| picture::Painted::new(&self.field, values));
        let u = work.u();
        let is_heated = self.field == "u"
            && work.method == Method::CutFlow
            && work.settings.text("source") != "curvature";
        let mut scene = picture::scene(
            surface,
            layout,
            &colours,
            &u,
            if is_heated { picture::TEMPERATURE } else { &self.field },
            field,
            folded,
            work.revision,
        );
        if let Some(set) = work.cones.set.as_ref().filter(|_| work.method == Method::Cones) {
            picture::put_cones(&mut scene, surface, layout, set, folded);
        }
        let is_flat = folded.is_none();
        if is_flat && !self.is_running {
            scene.layers = work.atlas_layers();
        }
        work.revision += 1;
        Some(scene)
    }

    /// The bytes of an export, by the name of its menu item.
    pub fn export(&mut self, kind: &str) -> Result<File, Problem> {
        if kind == PROJECT {
            return self.project();
        }
        if kind == COMPARISON {
            return self.comparison_file();
        }
        if kind != work::MESH {
            self.settled()?;
        }
        let compared = self.compared_results();
        if kind == ARCHIVE {
            let mut files = vec![self.project()?];
            if !compared.is_empty() {
                files.push(self.comparison_file()?);
            }
            let Some(work) = &mut self.work else { return Err(nothing_open()) };
            work.compared = compared;
            return work.archive(files);
        }
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.compared = compared;
        work.export(kind)
    }

    /// The open document.
    pub fn document(&self) -> Option<&Document> {
        self.work.as_ref().map(|work| &*work.document)
    }

    /// The report of `cutflow info`.
    pub fn info_report(&self) -> Option<InfoReport> {
        self.document().map(InfoReport::new)
    }

    /// The report of `cutflow cut`. **Takes** the time that the driver measured.
    pub fn cut_report(&mut self, seconds: Option<f64>) -> Result<CutReport, Problem> {
        self.settled()?.cut_report(seconds)
    }

    /// The report of `cutflow cones`. **Takes** the time that the driver measured.
    pub fn cones_report(&mut self, seconds: Option<f64>) -> Result<ConesReport, Problem> {
        self.settled()?.cones_report(seconds)
    }

    /// The layout at rest, of the current cut.
    pub fn layout(&mut self) -> Result<&Layout, Problem> {
        self.settled()?.layout.as_ref().ok_or_else(nothing_open)
    }

    /// Lays out the very cut of a `cut.json`, without making it the start of a flow: what a pattern of it is made of.
    pub fn lay_out_cut(&mut self, name: &str, bytes: &[u8]) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let cut = cut_from_json(work.document.surface()?, name, bytes)?;
        work.lay_out(cut)?;
        let text = String::from_utf8_lossy(bytes).into_owned();
        self.log.push(Entry::LayOut { name: name.to_owned(), cut: text });
        Ok(())
    }

    /// Lays out the very UV seams of the mesh, along its edges: a flow that starts from them follows them within half an edge.
    pub fn lay_out_uv_seams(&mut self) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let cut = cut_from_uv(work.document.surface()?)?;
        work.lay_out(cut)?;
        self.log.push(Entry::LayOutUvSeams);
        Ok(())
    }

    /// The work with a cut that is flattened whole.
    fn settled(&mut self) -> Result<&mut Work, Problem> {
        if self.first_cut_is_due() {
            let mut events = Vec::new();
            self.make_first_cut(&mut events);
            self.late.extend(events);
        }
        if self.is_stroke_open() {
            self.end_stroke();
            self.log.push(Entry::Do(Command::EndStroke));
        }
        if self.is_behind() {
            let mut events = Vec::new();
            // What a step would have done is a step of the project too.
            self.log.step();
            self.catch_up(&mut events)?;
            self.late.extend(events);
        }
        if self.method() == Method::Cones {
            self.settled_cones()?;
        }
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        if !work.is_settled {
            work.settle()?;
        }
        work.finish_refinement()?;
        Ok(work)
    }

    /// Labels of the mesh's vertices now.
    pub fn labels(&self) -> Vec<u32> {
        self.work.as_ref().map_or_else(Vec::new, Work::labels)
    }

    /// The running flow's energies so far.
    pub fn history(&self) -> &[HistoryRow] {
        self.work.as_ref().map_or(&[], |work| &work.history)
    }

    fn refuse(&self, problem: Problem, events: &mut Vec<Event>) {
        let text = format!("Error: {}", problem.what);
        events.push(error_event(problem));
        let step = self.work.as_ref().map_or(0, Work::step);
        events.push(Event::Status { state: "error".into(), step, text });
    }

    /// Opens a document with parameters of the driver's choice.
    pub fn open_with(
        &mut self,
        document: Result<Document, Problem>,
        settings: Settings,
    ) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.late);
        match document {
            Ok(document) => self.adopt_with(document, settings, &mut events),
            Err(problem) => self.refuse(problem, &mut events),
        }
        events
    }

    /// Takes a new document in, if it could be made, with the parameters that suit it.
    fn adopt(
        &mut self,
        document: Result<Document, Problem>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let document = document?;
        let settings = size::settings_for(&document);
        self.adopt_with(document, settings, events);
        Ok(())
    }

    /// A mesh that the initial cut does not suit is opened all the same, and says so.
    fn adopt_with(&mut self, document: Document, settings: Settings, events: &mut Vec<Event>) {
        let label = format!("open {}", document.name);
        self.change_to(document, settings, &label, events);
    }

    /// Makes another document the current one, with its initial cut; Undo goes back.
    fn change_to(
        &mut self,
        mut document: Document,
        mut settings: Settings,
        label: &str,
        events: &mut Vec<Event>,
    ) {
        self.end_comparison(events);
        // What was painted belongs to the triangles before.
        let is_made = self
            .work
            .as_ref()
            .is_some_and(|work| work.settings.text("init") == settings.text("init"));
        if is_made
            && !label.starts_with("open ")
            && ["painted", "seeds", "file", "handed"].contains(&settings.text("init"))
        {
            settings.put("init", Value::Text("normals".into()));
            let text = "What was painted belonged to the mesh before: the cut starts from normal clusters.";
            document.summary.notices.push(NoticeText::new("paint_dropped", 1, text));
        }
        let method = self.opening.take().unwrap_or(self.method());
        let is_cut_flow = method == Method::CutFlow;
        let is_large = document.surface.is_some() && document.triangles.len() > SHOWN_FIRST;
        let flow = match (is_cut_flow && !is_large)
            .then(|| start_flow(&document, &settings, &Layers::default(), None))
            .transpose()
        {
            Ok(flow) => flow,
            Err(_) if document.surface.is_none() => None,
            Err(problem) => {
                document.summary.notices.push(no_initial_cut(&problem));
                None
            }
        };
        self.remember(label, label);
        let document = Rc::new(document);
        if label.starts_with("open ") {
            self.log = Log::new(document.clone(), method, settings.clone());
        }
        let mut work = Work::new(document, settings, flow);
        work.first_cut_is_due = is_large && is_cut_flow;
        work.method = method;
        work.cones.is_stale = true;
        self.install(work, events);
    }

    /// Makes a document, its parameters and a place in its run the current ones.
    fn install(&mut self, mut work: Work, events: &mut Vec<Event>) {
        self.is_running = false;
        let old = self.work.take().filter(|old| Rc::ptr_eq(&old.document, &work.document));
        let is_other = old.is_none();
        if let Some(old) = old {
            work.revision = old.revision.max(1);
            if old.method == work.method {
                work.layout = old.layout;
                work.shelf = old.shelf;
            } else {
                self.field = work.method.first_field().into();
            }
            work.symmetries = old.symmetries.or(work.symmetries);
            work.cones.keep_solver(old.cones);
            work.phase.keep(old.phase);
        }
        if is_other {
            events.push(Event::Mesh(work.document.summary.clone()));
        }
        self.work = Some(work);
        if is_other {
            self.shown = None;
            events.push(self.forget_results());
            events.push(self.samples());
            events.extend(self.mesh_events());
        }
        events.push(self.methods());
        events.push(self.parameters());
        events.push(self.presets());
        events.push(self.paint_channels());
        events.push(self.symmetries());
        events.push(self.fields());
        if self.method() == Method::Cones {
            events.extend(self.work.as_ref().map(|work| work.cones.path_event()));
        }
        if self.is_segmenting()
            && self.work.as_ref().is_some_and(|work| work.document.surface.is_some())
            && let Err(problem) = self.segment_prepare(events)
        {
            events.push(error_event(problem));
        }
        if !is_other {
            events.extend(self.size_event());
        }
        self.push_energy(events);
        self.settle(events);
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
    }

    fn set_parameter(
        &mut self,
        id: &str,
        value: Value,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let mut settings = work.settings.clone();
        let Some(effect) = settings.set(id, value)? else {
            events.push(self.parameters());
            return Ok(());
        };
        if id == "unit" {
            size::follow_unit(&work.document, &mut settings)?;
        }
        self.apply(id, settings, effect, events)
    }

    fn set_side(
        &mut self,
        axis: usize,
        value: f64,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let mut settings = work.settings.clone();
        size::set_side(&work.document, &mut settings, axis, value)?;
        self.apply("size", settings, Effect::Export, events)
    }

    /// Puts changed settings in force.
    fn apply(
        &mut self,
        id: &str,
        settings: Settings,
        effect: Effect,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        // Try before anything changes.
        let params = settings.flow_params();
        params.validate().map_err(|error| Problem::solve(&work.document.name, &error))?;
        let restarted = match effect {
            Effect::Restart if work.document.surface.is_some() => {
                Some(start_flow(&work.document, &settings, &work.layers, None)?)
            }
            _ => None,
        };
        let label = all_specs().into_iter().find(|s| s.id == id).map_or_else(
            || format!("change {id}"),
            |spec| format!("change {}", spec.label.to_lowercase()),
        );
        let label = if id.starts_with("preset ") { id.to_owned() } else { label };
        let depth = self.undo.len();
        let redo = std::mem::take(&mut self.redo);
        self.remember(&label, &format!("set {id}"));
        let Some(work) = &mut self.work else { return Ok(()) };
        let before = std::mem::replace(&mut work.settings, settings);
        if let Err(problem) = self.follow_settings(id, effect, restarted, events) {
            // What cannot be followed is not in force.
            if let Some(work) = &mut self.work {
                work.settings = before;
            }
            self.undo.truncate(depth);
            self.redo = redo;
            return Err(problem);
        }
        events.push(self.parameters());
        events.push(self.presets());
        events.extend(self.size_event());
        events.push(self.history_event());
        events.push(self.status());
        if matches!(effect, Effect::Export | Effect::Pattern) {
            self.tell_pattern(events);
        }
        Ok(())
    }

    /// Does what changed settings ask for.
    fn follow_settings(
        &mut self,
        id: &str,
        effect: Effect,
        restarted: Option<CutFlow>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        match (effect, restarted) {
            (_, Some(flow)) => {
                work.begin(flow);
                self.push_energy(events);
                self.settle(events);
                events.push(Event::Scene);
            }
            (Effect::NextStep | Effect::Restart, None) => {
                let name = &work.document.name;
                let fields = work.fields();
                let params = work.settings.flow_params();
                if let Some(flow) = &mut work.flow {
                    flow.set_params(params).map_err(|e| Problem::solve(name, &e))?;
                    if ["source", "heat"].contains(&id) {
                        flow.set_fields(&fields).map_err(|e| Problem::solve(name, &e))?;
                    }
                    work.remeasure();
                    self.push_energy(events);
                }
                events.extend(self.work.as_ref().map(Work::measures));
            }
            (Effect::Finish, None) => {
                work.is_settled = false;
                if !self.is_running {
                    self.settle(events);
                    events.push(Event::Scene);
                }
            }
            (Effect::Export, None) => {
                work.drop_pattern();
                events.push(work.measures());
            }
            (Effect::Pattern, None) => {
                if patterning::makes_other_pieces(id) {
                    work.drop_pattern();
                }
                events.push(self.trades_event());
            }
            (Effect::Cones, None) => self.cones_are_due(),
            (Effect::ConeSet, None) => self.use_cones_anew(),
            (Effect::Segments, None) => {
                // Those of the other segmentation wait until it is at work.
                let is_own = specs_of(self.method()).iter().any(|spec| spec.id == id);
                if self.is_segmenting() && is_own {
                    self.segment_follow(events)?;
                }
            }
        }
        Ok(())
    }

    fn doctor_event(&self) -> Option<Event> {
        let work = self.work.as_ref()?;
        Some(Event::Doctor(doctor::report(&work.document, self.shown.as_deref())))
    }

    /// What follows the facts of a mesh: findings, tools, size.
    fn mesh_events(&self) -> impl Iterator<Item = Event> + use<> {
        let tools = self.work.as_ref().map(|work| preparing::tools(&work.document));
        let tools = tools.map(|options| Event::Tools { options });
        [self.doctor_event(), tools, self.size_event()].into_iter().flatten()
    }

    fn size_event(&self) -> Option<Event> {
        let work = self.work.as_ref()?;
        Some(size::event(&work.document, &work.settings))
    }

    /// Flattens the current cut whole.
    fn settle(&mut self, events: &mut Vec<Event>) {
        let Some(work) = &mut self.work else { return };
        if work.document.surface.is_none() || work.first_cut_is_due {
            // Nothing is flat yet; the doctor's picture is what there is to see.
            events.push(work.measures());
            self.scene_is_new = true;
            return;
        }
        if work.method == Method::Cones && (work.cones.is_due() || !work.cones.is_solved()) {
            events.push(work.measures());
            self.scene_is_new = true;
            return;
        }
        if work.segmentation().is_some() && !work.has_cut() {
            // Nothing was divided: there is a reason, which was told.
            work.layout = None;
            events.push(work.measures());
            self.scene_is_new = true;
            return;
        }
        let was_folded = work.fold.is_some();
        match work.settle() {
            Ok(()) => {
                events.push(work.measures());
                if was_folded {
                    events.push(self.fold_event());
                }
                self.scene_is_new = true;
            }
            Err(problem) => self.refuse(problem, events),
        }
    }

    /// The curve from the start.
    fn push_energy(&self, events: &mut Vec<Event>) {
        if let Some(work) = &self.work {
            events.extend(work.energy_curve());
        }
    }

    fn samples(&self) -> Event {
        Event::Samples {
            options: samples::SAMPLES
                .iter()
                .map(|s| SampleChoice {
                    name: s.name.into(),
                    label: s.label.into(),
                    description: s.description.into(),
                })
                .collect(),
            current: self.document().and_then(|d| d.sample.clone()),
        }
    }

    fn fields(&self) -> Event {
        Event::Fields { current: self.field.clone(), options: picture::fields(self.method()) }
    }

    fn parameters(&self) -> Event {
        let specs = specs_of(self.method());
        let mut values = self.work.as_ref().map(|w| w.settings.values()).unwrap_or_default();
        values.retain(|id, _| specs.iter().any(|spec| spec.id == *id));
        Event::Parameters { method: self.method().id().into(), specs, values }
    }

    /// The method at work.
    pub fn method(&self) -> Method {
        self.work.as_ref().map_or(self.wanted_method, |work| work.method)
    }

    fn history_event(&self) -> Event {
        // The way back is the document's, which is put aside while a comparison runs.
        let is_here = !self.is_comparing();
        let [done, undone] = [&self.undo, &self.redo]
            .map(|list| if is_here { self.changes(list) } else { Vec::new() });
        let label = |list: &[ChangeName]| list.first().map(|change| change.label.clone());
        Event::History { undo: label(&done), redo: label(&undone), done, undone }
    }

    fn status(&self) -> Event {
        if let Some(event) = self.comparison_status() {
            return event;
        }
        let Some(work) = &self.work else {
            let text = "Ready: open a mesh or choose a sample".into();
            return Event::Status { state: "ready".into(), step: 0, text };
        };
        let step = work.step();
        let limit = work.settings.number("steps");
        let folding = work.fold.as_ref().filter(|fold| fold.is_running);
        let refining = work.refinement.as_ref().filter(|_| self.is_refining());
        let (state, text) = if !self.replay.is_over() {
            ("preparing", self.replay.status())
        } else if let Some(text) = self.nesting_text() {
            ("running", text)
        } else if let Some(refinement) = refining {
            ("running", format!("Running step {} of evening out", refinement.steps() + 1))
        } else if let Some(fold) = folding {
            ("running", format!("Running step {} of the fold preview", fold.flow.steps()))
        } else if let Some(preparation) = &self.preparation {
            ("preparing", preparation.status())
        } else if work.first_cut_is_due {
            ("preparing", format!("Loading {}: making the first cut", work.document.name))
        } else if work.document.surface.is_none() {
            ("ready", "Ready: the mesh needs repair before it can be cut".to_owned())
        } else if work.method == Method::Cones {
            self.cones_status(work)
        } else if self.is_segmenting() {
            self.segment_text(work)
        } else if self.is_running {
            let is_testing = work.flow.as_ref().is_some_and(CutFlow::is_testing);
            let what = if is_testing { ": is there a better cut beside it?" } else { "" };
            ("running", format!("Running step {step}{what}"))
        } else {
            match work.flow.as_ref().map(CutFlow::status) {
                None => ("ready", "Ready: not cut yet".to_owned()),
                Some(Status::Converged) => {
                    ("converged", format!("Converged after {}", plural(step, "step")))
                }
                // Every direction was tried at every length: as good an end as the other.
                Some(Status::Stalled) => (
                    "stalled",
                    format!(
                        "Converged after {}: no search lowers the energy further",
                        plural(step, "step")
                    ),
                ),
                Some(_) if step as f64 >= limit => {
                    ("step_limit", format!("Paused at step {step}: step limit reached"))
                }
                Some(_) if step == 0 => ("ready", "Ready".to_owned()),
                Some(_) => ("paused", format!("Paused at step {step}")),
            }
        };
        Event::Status { state: state.into(), step, text }
    }
}

fn error_event(problem: Problem) -> Event {
    Event::Error { what: problem.what, place: problem.place, what_to_do: problem.what_to_do }
}

/// Whether a command goes along the history.
fn is_travel(command: &Command) -> bool {
    matches!(command, Command::Undo | Command::Redo | Command::Travel { .. })
}

/// Whether a preparation goes on beside a command: looks, and parameters of what comes after it.
fn goes_along_with_preparing(command: &Command) -> bool {
    matches!(
        command,
        Command::Hello
            | Command::ShowField { .. }
            | Command::ShowFinding { .. }
            | Command::SetParameter { .. }
            | Command::Hold { .. }
            | Command::SetUnit { .. }
            | Command::SetSize { .. }
            | Command::DismissError
            | Command::RenameResult { .. }
            | Command::RemoveResult { .. }
            | Command::Measure { .. }
    )
}

fn no_initial_cut(problem: &Problem) -> NoticeText {
    NoticeText::new("no_initial_cut", 1, format!("{} {}", problem.what, problem.what_to_do))
}

fn nothing_open() -> Problem {
    Problem::new("No mesh is open.", "In the document.", "Open a mesh or choose a sample first.")
}
