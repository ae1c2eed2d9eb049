//! The project file: a mesh, the parameters that it was opened with, and everything that was done to it since.
//!
//! ```json
//! {
//!   "cutflow_project": 2,
//!   "mesh": {"name": "bunny.obj", "format": "OBJ", "obj": "v 0 0 0\n…"},
//!   "method": "cutflow",
//!   "parameters": {"length": 2.0},
//!   "log": [{"do": {"type": "run"}}, {"steps": 38}, {"do": {"type": "pause"}}]
//! }
//! ```
//!
//! A project is replayed: as steps are deterministic, the same bytes come out on the same target. What Undo took back is not in it.
//!
//! Guaranteed: coordinates, order and names of the mesh survive bit for bit; unknown keys are passed over. Not guaranteed: that what was shown
//! (camera, painted field) or compared comes back; that another target gives the same last digits.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use super::brought::Brought;
use super::document::Document;
use super::exporting::stem;
use super::message::{Command, Event, File, Value};
use super::method::Method;
use super::params::Settings;
use super::size;
use super::text::Problem;
use super::{Session, nothing_open};
use crate::pattern;

/// The version of the format that is written; all before it are read. The second one knows of rounds and of symmetric patches.
const VERSION: u32 = 2;

/// One thing that was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Entry {
    /// What a person asked for.
    Do(Command),
    /// What a driver brought along.
    Bring(Gift),
    /// A cut.json that was laid out as it is.
    LayOut { name: String, cut: String },
    /// The UV seams of the mesh, laid out as they are.
    LayOutUvSeams,
    /// Steps of whatever was running.
    Steps(usize),
    /// Rounds of the solver of cones, which had not come to its end. After Undo it needs others than in a replay: there may be fewer.
    Rounds(usize),
    /// Cones were solved, in however many rounds.
    Solved,
    /// Their charts were made.
    LaidOut,
    /// Everything that waited was brought to rest at once, for a file or a pattern.
    Settle,
}

/// What [`Brought`] borrows, to keep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Gift {
    Layer { channel: String, values: Vec<f64> },
    Seeds(Vec<f64>),
    Cut { name: String, text: String },
    Eye([f64; 3]),
    Cones { name: String, text: String },
    Cone { vertex: f64, angle: Option<f64> },
}

impl Gift {
    pub fn of(brought: &Brought) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        match *brought {
            Brought::Layer { channel, values } => {
                Self::Layer { channel: channel.into(), values: values.to_vec() }
            }
            Brought::Seeds(seeds) => Self::Seeds(seeds.to_vec()),
            Brought::Cut { name, bytes } => Self::Cut { name: name.into(), text: text(bytes) },
            Brought::Eye(eye) => Self::Eye(eye),
            Brought::Cones { name, bytes } => Self::Cones { name: name.into(), text: text(bytes) },
            Brought::Cone { vertex, angle } => Self::Cone { vertex, angle },
        }
    }

    fn brought(&self) -> Brought<'_> {
        match self {
            Self::Layer { channel, values } => Brought::Layer { channel, values },
            Self::Seeds(seeds) => Brought::Seeds(seeds),
            Self::Cut { name, text } => Brought::Cut { name, bytes: text.as_bytes() },
            Self::Eye(eye) => Brought::Eye(*eye),
            Self::Cones { name, text } => Brought::Cones { name, bytes: text.as_bytes() },
            Self::Cone { vertex, angle } => Brought::Cone { vertex: *vertex, angle: *angle },
        }
    }
}

/// What happened to a document since it was opened. Clones share what they have in common: Undo keeps one for each change.
#[derive(Clone, Default)]
pub(super) struct Log {
    origin: Option<Rc<Origin>>,
    /// The last page, and how much of it belongs to this log: what follows was done after a clone went another way.
    page: Option<(Rc<Page>, usize)>,
    /// Another one after each thing that was done, coming to rest apart.
    done: Option<Rc<()>>,
    /// Steps since the last entry, or rounds of the solver of cones since then and since the last step.
    steps: usize,
    rounds: usize,
}

/// A document as it was opened.
struct Origin {
    document: Rc<Document>,
    method: Method,
    settings: Settings,
}

/// Bytes of a page. Entries live as long as the document: scattered one by one over a heap they would keep it from being used again
/// for what comes and goes, and wasm's would grow for ever.
const PAGE: usize = 16 << 10;

/// Entries, each a line of JSON.
struct Page {
    text: RefCell<String>,
    before: Option<(Rc<Page>, usize)>,
}

impl Drop for Page {
    // Not one call deeper for each page.
    fn drop(&mut self) {
        let mut next = self.before.take();
        while let Some(mut page) = next.and_then(|(page, _)| Rc::try_unwrap(page).ok()) {
            next = page.before.take();
        }
    }
}

impl Log {
    pub fn new(document: Rc<Document>, method: Method, settings: Settings) -> Self {
        let origin = Origin { document, method, settings };
        Self { origin: Some(Rc::new(origin)), ..Self::default() }
    }

    /// One step of whatever is running.
    pub fn step(&mut self) {
        self.steps += 1;
    }

    /// The step that was made last was none.
    pub fn take_back_step(&mut self) {
        self.steps = self.steps.saturating_sub(1);
    }

    /// The step that was made last was a round of the solver of cones.
    pub fn round(&mut self) {
        self.take_back_step();
        if self.steps > 0 {
            self.close_steps();
        }
        self.rounds += 1;
    }

    /// The step that was made last was the last round of the solver of cones.
    pub fn solved(&mut self) {
        self.round();
        self.rounds = 0;
        self.push(Entry::Solved);
    }

    /// The step that was made last has made the charts of cones.
    pub fn laid_out(&mut self) {
        self.take_back_step();
        self.push(Entry::LaidOut);
    }

    pub fn push(&mut self, entry: Entry) {
        self.close_steps();
        self.link(entry);
    }

    /// What is done from now on is apart from the steps before.
    pub fn close_steps(&mut self) {
        for entry in self.open_steps() {
            self.link(entry);
        }
        (self.rounds, self.steps) = (0, 0);
    }

    fn link(&mut self, entry: Entry) {
        use Entry::{LaidOut, Rounds, Settle, Solved, Steps};
        if !matches!(entry, Steps(_) | Rounds(_) | Solved | LaidOut | Settle) {
            self.done = Some(Rc::new(()));
        }
        let mut line = written(&entry);
        line.push('\n');
        if let Some((page, length)) = &mut self.page {
            let mut text = page.text.borrow_mut();
            if text.len() == *length && text.capacity() - *length >= line.len() {
                text.push_str(&line);
                *length = text.len();
                return;
            }
        }
        let mut text = String::with_capacity(line.len().max(PAGE));
        text.push_str(&line);
        let before = self.page.take();
        self.page = Some((Rc::new(Page { text: RefCell::new(text), before }), line.len()));
    }

    /// Entries of the rounds and steps since the last one. A step after a round belongs to what comes after the solution.
    fn open_steps(&self) -> Vec<Entry> {
        let rounds = (self.rounds > 0).then_some(Entry::Rounds(self.rounds));
        let steps = (self.steps > 0).then_some(Entry::Steps(self.steps));
        rounds.into_iter().chain(steps).collect()
    }

    /// Whether the same things were done, whatever has come to rest by itself since.
    pub fn is_same(&self, other: &Self) -> bool {
        let is_one = match (&self.done, &other.done) {
            (Some(own), Some(its)) => Rc::ptr_eq(own, its),
            (own, its) => own.is_none() && its.is_none(),
        };
        let origins = self.origin.as_ref().zip(other.origin.as_ref());
        is_one && origins.is_some_and(|(own, its)| Rc::ptr_eq(own, its))
    }

    /// All entries as they are written.
    fn lines(&self) -> Vec<String> {
        let mut pages = Vec::new();
        let mut next = self.page.as_ref();
        while let Some((page, length)) = next {
            pages.push((page, *length));
            next = page.before.as_ref();
        }
        let mut all = Vec::new();
        for (page, length) in pages.into_iter().rev() {
            all.extend(page.text.borrow()[..length].lines().map(str::to_owned));
        }
        all.extend(self.open_steps().iter().map(written));
        all
    }
}

/// An entry as a line of JSON.
fn written(entry: &Entry) -> String {
    serde_json::to_string(entry).expect("plain values can be written")
}

/// Whether a command changes what a project holds. What opens a mesh begins another one.
pub(super) fn is_kept(command: &Command) -> bool {
    !matches!(
        command,
        Command::Hello
            | Command::OpenSample { .. }
            | Command::ShowField { .. }
            | Command::ShowFinding { .. }
            | Command::ShowPattern { .. }
            | Command::DismissError
            | Command::Measure { .. }
            | Command::Undo
            | Command::Redo
            | Command::Travel { .. }
            // What it brings along is kept in its place.
            | Command::KeepCut
            | Command::KeepResult { .. }
            | Command::RestoreResult { .. }
            | Command::RemoveResult { .. }
            | Command::RenameResult { .. }
            | Command::Compare { .. }
            | Command::NextResult
    )
}

/// A project; its log as entries, or as they are written.
#[derive(Serialize, Deserialize)]
struct ProjectFile<E = Entry> {
    cutflow_project: u32,
    mesh: MeshText,
    #[serde(default)]
    method: String,
    #[serde(default)]
    parameters: BTreeMap<String, Value>,
    #[serde(default = "Vec::new")]
    log: Vec<E>,
}

#[derive(Serialize, Deserialize)]
struct MeshText {
    name: String,
    #[serde(default)]
    format: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sample: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    obj: Option<String>,
}

/// Whether a file is a project.
pub(super) fn is_project_file(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(200)];
    String::from_utf8_lossy(head).contains("\"cutflow_project\"")
}

/// What is still to be done of a project that was opened.
#[derive(Default)]
pub(super) struct Replay {
    entries: VecDeque<Entry>,
    done: usize,
    name: String,
}

impl Replay {
    pub fn is_over(&self) -> bool {
        self.entries.is_empty()
    }

    /// What the status line says.
    pub fn status(&self) -> String {
        let steps = |entry: &Entry| match entry {
            Entry::Steps(n) | Entry::Rounds(n) => *n,
            _ => 1,
        };
        // A file may say whatever it likes.
        let all = self.entries.iter().map(steps).fold(self.done, usize::saturating_add);
        format!("Loading {}: {} of {all} steps done again", self.name, self.done)
    }
}

fn refused(name: &str, what: impl Into<String>) -> Problem {
    Problem::new(
        what,
        format!("{name}."),
        "Choose a project that was saved by Cutflow, or open the mesh itself.",
    )
}

/// The document and the parameters that a project begins with.
fn beginning(name: &str, file: &ProjectFile) -> Result<(Document, Settings), Problem> {
    let mesh = &file.mesh;
    let mut document = match (&mesh.sample, &mesh.obj) {
        (Some(sample), _) => Document::from_sample(sample)?,
        (None, Some(obj)) => Document::from_bytes(&mesh.name, obj.as_bytes())?,
        (None, None) => return Err(refused(name, "The project holds no mesh.")),
    };
    document.restore_format(&mesh.format);
    let mut settings = size::settings_for(&document);
    for (id, value) in &file.parameters {
        // A parameter that is unknown here belongs to another version: what it changed is told by what differs, not by refusing all.
        if Settings::knows(id) {
            settings.set(id, value.clone())?;
        }
    }
    Ok((document, settings))
}

impl Session {
    /// Opens the mesh of a project; what was done to it since is done again as the session advances.
    pub(super) fn open_project(
        &mut self,
        name: &str,
        bytes: &[u8],
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        #[derive(Deserialize)]
        struct Head {
            cutflow_project: u32,
        }
        let broken =
            |error| refused(name, format!("This is not a complete project file: {error}."));
        let head: Head = serde_json::from_slice(bytes).map_err(broken)?;
        if head.cutflow_project > VERSION {
            return Err(Problem::new(
                format!(
                    "The project was saved by a newer Cutflow: it has version {}, and version {VERSION} is understood.",
                    head.cutflow_project
                ),
                format!("{name}."),
                "Open it with a newer Cutflow.",
            ));
        }
        let file: ProjectFile = serde_json::from_slice(bytes).map_err(broken)?;
        let (document, settings) = beginning(name, &file)?;
        self.opening = Method::from_id(&file.method);
        self.adopt_with(document, settings, events);
        self.replay = Replay { entries: file.log.into(), done: 0, name: name.to_owned() };
        events.push(self.status());
        Ok(())
    }

    /// One more thing, or one more step, of what a project holds.
    pub(super) fn replay_on(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(entry) = self.replay.entries.pop_front() else { return Ok(()) };
        self.replay.done += 1;
        let told = match entry {
            Entry::Do(command) => self.do_again(command),
            Entry::Bring(gift) => self.bring(gift.brought()),
            Entry::LayOut { name, cut } => {
                self.lay_out_cut(&name, cut.as_bytes())?;
                Vec::new()
            }
            Entry::LayOutUvSeams => {
                self.lay_out_uv_seams()?;
                Vec::new()
            }
            Entry::Rounds(count) => {
                if self.are_cones_due() && self.step_again(events) && count > 1 {
                    self.replay.entries.push_front(Entry::Rounds(count - 1));
                }
                Vec::new()
            }
            Entry::Solved => {
                if self.are_cones_due() && self.step_again(events) {
                    self.replay.entries.push_front(Entry::Solved);
                }
                Vec::new()
            }
            Entry::LaidOut => {
                if self.are_charts_due() {
                    self.step_again(events);
                }
                Vec::new()
            }
            Entry::Settle => {
                // Where it failed, what was asked for was refused; what came after was done all the same.
                let _ = self.settled();
                Vec::new()
            }
            Entry::Steps(count) => {
                if self.has_work() {
                    self.step_again(events);
                    if count > 1 {
                        self.replay.entries.push_front(Entry::Steps(count - 1));
                    }
                }
                Vec::new()
            }
        };
        events.extend(told);
        self.rest(events);
        if self.replay.is_over() && self.is_running {
            // It was saved in the middle of a run: that is for a person to go on with.
            self.pause(events)?;
            self.log.push(Entry::Do(Command::Pause));
        }
        Ok(())
    }

    /// One step. **Gives** whether it could be made.
    fn step_again(&mut self, events: &mut Vec<Event>) -> bool {
        self.log.step();
        // Where it failed, it failed when it was made, and what came after was done all the same.
        self.step_once(events).map_err(|problem| self.give_up(problem, events)).is_ok()
    }

    /// The bytes of the project.
    pub(super) fn project(&self) -> Result<File, Problem> {
        let done = self.document_log();
        let Some(origin) = &done.origin else { return Err(nothing_open()) };
        let document = &origin.document;
        let obj = document.sample.is_none().then(|| {
            String::from_utf8_lossy(&pattern::mesh_obj(&document.soup, document.mm_per_unit))
                .into_owned()
        });
        // What is still to be done again belongs to it.
        let lines = done.lines().into_iter().chain(self.replay.entries.iter().map(written));
        let log: Result<Vec<_>, _> = lines.map(RawValue::from_string).collect();
        let unwritten =
            |error| refused(&document.name, format!("The project could not be written: {error}."));
        let file = ProjectFile {
            cutflow_project: VERSION,
            mesh: MeshText {
                name: document.name.clone(),
                format: document.format.to_owned(),
                sample: document.sample.clone(),
                obj,
            },
            method: origin.method.id().to_owned(),
            parameters: origin.settings.values(),
            log: log.map_err(unwritten)?,
        };
        let bytes = serde_json::to_vec(&file).map_err(unwritten)?;
        let name = format!("{}-project.json", stem(&document.name));
        Ok(File { name, mime: "application/json", bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cone(vertex: usize) -> Entry {
        Entry::Bring(Gift::Cone { vertex: vertex as f64, angle: Some(0.1) })
    }

    #[test]
    fn logs_that_part_share_what_they_have_in_common_and_nothing_else() {
        let document = Document::from_sample("ball").unwrap();
        let settings = size::settings_for(&document);
        let mut log = Log::new(Rc::new(document), Method::Cones, settings);
        let mut all = Vec::new();
        for i in 0..3000 {
            log.push(cone(i));
            all.push(cone(i));
        }
        let mut other = log.clone();
        // Coming to rest is nothing that was done.
        other.step();
        other.push(Entry::Settle);
        assert!(log.is_same(&other));
        other = log.clone();
        let long = Entry::LayOut { name: "a\nb".into(), cut: "x\u{2028}".repeat(PAGE) };
        log.push(long.clone());
        other.step();
        other.push(cone(7));
        log.step();
        assert!(!log.is_same(&other));
        let entries = |log: &Log| -> Vec<Entry> {
            log.lines().iter().map(|line| serde_json::from_str(line).unwrap()).collect()
        };
        assert_eq!(entries(&log), [&all[..], &[long.clone(), Entry::Steps(1)]].concat());
        assert_eq!(entries(&other), [&all[..], &[Entry::Steps(1), cone(7)]].concat());
        // Pages, not entries, are what lies about in memory: one for some hundreds.
        let mut pages = 0;
        let mut next = other.page.clone();
        while let Some((page, _)) = next {
            pages += 1;
            next = page.before.clone();
        }
        assert!((2..20).contains(&pages), "{pages}");
    }
}
