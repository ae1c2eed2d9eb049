//! Commands in, events out: what page, command line and tests drive.
//!
//! A [`Session`] holds at most one [`Document`] and one running [`crate::methods::cutflow::CutFlow`]. [`Session::handle`] is short and never steps;
//! [`Session::advance`] steps the running flow while the driver says so. Pictures, tables and exports are made from a
//! [`Layout`] of the current cut: a preview while the flow runs, the whole truth (every patch cut to disks) at rest.
//!
//! Guaranteed: after an error the document is what it was; a step that fails leaves the last cut; the same commands with the
//! same number of steps between them give the same bytes. Not guaranteed: a chart for every patch while a flow runs.
//!
//! This is the only floor that serialises. It reads no clock: drivers measure time and hand in budgets.

mod answers;
mod blending;
mod brought;
mod changing;
mod charting;
mod comparing;
mod cones;
mod cut_file;
mod digest;
mod doctor;
mod document;
mod exporting;
mod folding;
mod inputs;
mod keeping;
mod laying;
mod layout;
mod measuring;
mod message;
mod method;
mod notices;
mod opening;
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
mod stepping;
mod surface;
mod symmetric;
mod telling;
mod text;
mod undo;
mod work;

use comparing::Comparing;
use keeping::Kept;
use preparing::Preparation;
use project::{Entry, Log, Replay};
use work::{Snapshot, Work};

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

pub use text::Problem;

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
            if self.is_stroke_open() && !matches!(command, Command::EndStroke) {
                // What it painted is taken up before the command is done.
                self.log.push(Entry::Do(Command::EndStroke));
            }
            self.end_stroke();
        }
        if has_ended && entry.is_none() {
            // What the command put an end to is at an end in a replay too, where the command itself is not done again.
            self.log.push(Entry::Do(Command::EndStroke));
        }
        let goes_on_painting =
            matches!(command, Command::Paint { .. } | Command::EndStroke | Command::Hold { .. });
        if entry.is_some() && !goes_on_painting {
            self.take_up();
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

    /// The method at work.
    pub fn method(&self) -> Method {
        self.work.as_ref().map_or(self.wanted_method, |work| work.method)
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
