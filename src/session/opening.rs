//! Opening: bytes, samples and changed meshes become the document at hand, with its first cut.

use std::rc::Rc;

use super::inputs::Layers;
use super::text::shown_name;
use super::work::start_flow;
use super::{
    Brought, Command, Document, Entry, Event, Log, Method, NoticeText, Problem, Replay, Session,
    Settings, Value, Work, cones, cut_file, error_event, no_initial_cut, project, size,
};

/// Triangles beyond which a mesh is shown before its first cut is made.
const SHOWN_FIRST: usize = 50_000;

impl Session {
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
    pub(super) fn adopt(
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
    pub(super) fn adopt_with(
        &mut self,
        document: Document,
        settings: Settings,
        events: &mut Vec<Event>,
    ) {
        let label = format!("open {}", document.name);
        self.change_to(document, settings, &label, events);
    }

    /// Makes another document the current one, with its initial cut; Undo goes back.
    pub(super) fn change_to(
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
        if !label.starts_with("open ") && settings.text("phase_start") == "painted" {
            settings.put("phase_start", Value::Text("axes".into()));
            let text = "What was painted belonged to the mesh before: divisions start along the axes of inertia.";
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
    pub(super) fn install(&mut self, mut work: Work, events: &mut Vec<Event>) {
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
}
