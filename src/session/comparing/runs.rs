//! The runs of a comparison, one after the other, each on the mesh as it was opened up to now.
//!
//! Every run is driven by the commands that a person would give: parameters, method, reset, run. So its result has a log that a project can
//! replay. The document itself is put aside meanwhile and comes back as it was, with its way back.

use std::collections::{BTreeMap, VecDeque};

use super::super::message::{Command, Event, RunRequest, Value};
use super::super::method::Method;
use super::super::project::Log;
use super::super::text::Problem;
use super::super::work::{Snapshot, Work};
use super::super::{Session, nothing_open};
use super::{Kept, ResultCard, ResultProgress};

/// Runs that are still to come, and what comes back after them.
pub(in super::super) struct Queue {
    runs: VecDeque<Plan>,
    total: usize,
    /// Steps after which a flow is stopped.
    steps: Option<usize>,
    /// Whether the driver looks at each result before the next run.
    waits: bool,
    waits_for: Option<usize>,
    pub is_held: bool,
    now: Option<Plan>,
    /// What the run is called that is at work, or was last.
    label: String,
    failed: Option<Problem>,
    seconds: Option<f64>,
    /// The result that was made last, as long as no other run has begun.
    last: Option<usize>,
    aside: Box<Aside>,
}

/// One run.
#[derive(Clone)]
struct Plan {
    method: Method,
    values: BTreeMap<String, Value>,
    name: String,
}

/// The document while others run.
struct Aside {
    work: Work,
    /// Where every run begins.
    start: Snapshot,
    undo: Vec<Snapshot>,
    redo: Vec<Snapshot>,
    log: Log,
    wanted_method: Method,
    field: String,
}

impl Queue {
    pub fn progress(&self) -> ResultProgress {
        ResultProgress {
            at: (self.total - self.runs.len()).max(1),
            of: self.total,
            label: self.label.clone(),
            is_held: self.is_held,
            waits_for: self.waits_for,
        }
    }

    /// Whether there is something to do.
    fn is_due(&self) -> bool {
        !self.is_held && self.waits_for.is_none()
    }
}

impl Session {
    /// Whether runs of a comparison are under way: the document is put aside meanwhile.
    pub fn is_comparing(&self) -> bool {
        self.comparing.queue.is_some()
    }

    /// Whether a comparison has something to do now.
    pub(in super::super) fn comparison_is_due(&self) -> bool {
        self.comparing.queue.as_ref().is_some_and(Queue::is_due)
    }

    /// Begins runs of several methods or settings.
    ///
    /// **Takes** no runs for one of every method, steps after which flows are stopped (cones are solved to the end), and whether to wait for
    /// [`Command::NextResult`] after each.
    pub(in super::super) fn compare(
        &mut self,
        runs: &[RunRequest],
        steps: Option<usize>,
        waits: bool,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let work = self.work.as_ref().ok_or_else(nothing_open)?;
        work.document.surface()?;
        let plans = self.plans(runs)?;
        self.comparing.has_room(plans.len())?;
        if self.has_work() {
            let told = self.do_again(Command::Pause);
            events.extend(told);
        }
        if self.is_folded() {
            let told = self.do_again(Command::Unfold);
            events.extend(told);
        }
        let work = self.work.as_ref().ok_or_else(nothing_open)?;
        let start = work.snapshot("", "");
        let mut fresh = bare(&start);
        fresh.revision = work.revision;
        let Some(work) = self.work.replace(fresh) else { return Err(nothing_open()) };
        let aside = Aside {
            work,
            start,
            undo: std::mem::take(&mut self.undo),
            redo: std::mem::take(&mut self.redo),
            log: self.log.clone(),
            wanted_method: self.wanted_method,
            field: std::mem::replace(&mut self.field, "pieces".into()),
        };
        self.comparing.queue = Some(Queue {
            label: plans.front().map(|plan| plan.name.clone()).unwrap_or_default(),
            total: plans.len(),
            runs: plans,
            steps: steps.map(|n| n.max(1)),
            waits,
            waits_for: None,
            is_held: false,
            now: None,
            failed: None,
            seconds: None,
            last: None,
            aside: Box::new(aside),
        });
        events.push(self.history_event());
        events.push(self.comparison());
        events.push(self.status());
        Ok(())
    }

    /// What is asked for, checked before anything is put aside.
    fn plans(&self, runs: &[RunRequest]) -> Result<VecDeque<Plan>, Problem> {
        let all = Method::ALL
            .map(|method| RunRequest { method: method.id().into(), ..RunRequest::default() });
        let runs = if runs.is_empty() { &all[..] } else { runs };
        let Some(work) = &self.work else { return Err(nothing_open()) };
        runs.iter()
            .map(|run| {
                let method = Method::from_id(&run.method).ok_or_else(|| {
                    Problem::new(
                        format!("There is no method called “{}”.", run.method),
                        "In the runs of a comparison.",
                        format!("Choose one of {}.", Method::known()),
                    )
                })?;
                let mut settings = work.settings.clone();
                for (id, value) in &run.values {
                    settings.set(id, value.clone())?;
                }
                settings
                    .flow_params()
                    .validate()
                    .map_err(|error| Problem::solve(&work.document.name, &error))?;
                let name = super::tidy(run.name.as_deref().unwrap_or_default());
                let name = if name.is_empty() { method.label().to_owned() } else { name };
                Ok(Plan { method, values: run.values.clone(), name })
            })
            .collect()
    }

    /// The driver has seen the last result.
    pub(in super::super) fn next_result(&mut self, events: &mut Vec<Event>) {
        if let Some(queue) = &mut self.comparing.queue {
            queue.waits_for = None;
        }
        events.push(self.status());
    }

    /// Adds time to the run at work, or to the result that it has just given. Drivers call it after every
    /// [`Session::advance`]; results of others than runs of a comparison are not concerned.
    pub fn spend(&mut self, seconds: f64) {
        let Some(queue) = self.comparing.queue.as_mut() else { return };
        if !(seconds >= 0.0 && seconds.is_finite()) {
            return;
        }
        let spent = queue.seconds.unwrap_or(0.0) + seconds;
        queue.seconds = Some(spent);
        let last = queue.last;
        if let Some(entry) = self.comparing.entries.iter_mut().find(|e| Some(e.card.id) == last) {
            entry.card.seconds = Some(spent);
        }
    }

    /// One bounded piece of a comparison. **Gives** whether a run has begun or ended: its time is to be told apart from the others'.
    pub(in super::super) fn compare_on(&mut self, events: &mut Vec<Event>) -> bool {
        let Some(queue) = &self.comparing.queue else { return true };
        let Some(plan) = &queue.now else {
            self.begin_run(events);
            return true;
        };
        let limit = queue.steps.filter(|_| plan.method != Method::Cones);
        let step = self.work.as_ref().map_or(0, Work::step);
        let is_stopped = limit.is_some_and(|limit| step >= limit);
        if queue.failed.is_some() || is_stopped || (!queue.is_held && !self.has_work()) {
            self.end_run(events);
            return true;
        }
        self.log.step();
        let mut told = Vec::new();
        if let Err(problem) = self.step_once(&mut told) {
            self.is_running = false;
            self.fail(problem);
        }
        self.pass_on(told, events);
        false
    }

    fn fail(&mut self, problem: Problem) {
        if let Some(queue) = &mut self.comparing.queue {
            queue.failed.get_or_insert(problem);
        }
    }

    /// What a run tells goes on, except for what is about the document: its way back, its errors, its status.
    fn pass_on(&mut self, told: Vec<Event>, events: &mut Vec<Event>) {
        for event in told {
            match event {
                Event::Error { what, place, what_to_do } => {
                    self.fail(Problem { what, place, what_to_do });
                }
                Event::Status { .. } | Event::History { .. } | Event::Comparison(_) => {}
                event => events.push(event),
            }
        }
    }

    /// Gives a command as a person would.
    fn drive(&mut self, command: Command, events: &mut Vec<Event>) {
        let Some(queue) = self.comparing.queue.take() else { return };
        let told = self.do_again(command);
        self.comparing.queue = Some(queue);
        self.pass_on(told, events);
    }

    fn begin_run(&mut self, events: &mut Vec<Event>) {
        let Some(queue) = &mut self.comparing.queue else { return };
        let Some(plan) = queue.runs.pop_front() else {
            self.end_comparison(events);
            return;
        };
        queue.now = Some(plan.clone());
        queue.label.clone_from(&plan.name);
        (queue.seconds, queue.last, queue.failed) = (None, None, None);
        let mut work = bare(&queue.aside.start);
        self.log = queue.aside.log.clone();
        work.revision = self.work.as_ref().map_or(1, |work| work.revision.max(1));
        self.work = Some(work);
        self.undo.clear();
        self.field = "pieces".into();
        for (id, value) in plan.values {
            self.drive(Command::SetParameter { id, value }, events);
        }
        self.drive(Command::SetMethod { id: plan.method.id().into() }, events);
        self.field = "pieces".into();
        self.drive(Command::Reset, events);
        if self.comparing.queue.as_ref().is_some_and(|queue| queue.failed.is_none()) {
            self.drive(Command::Run, events);
        }
        events.push(self.methods());
        events.push(self.parameters());
        events.push(self.fields());
        events.push(self.comparison());
    }

    /// The run has come to its end: its result is kept.
    fn end_run(&mut self, events: &mut Vec<Event>) {
        if self.has_work() {
            // Stopped at its limit.
            self.drive(Command::Pause, events);
        }
        let Some(mut queue) = self.comparing.queue.take() else { return };
        let Some(plan) = queue.now.take() else { return };
        self.is_running = false;
        let made = match queue.failed.take() {
            Some(problem) => Err(problem),
            None => self.settled().map(|_| ()),
        };
        let made = made.and_then(|()| self.result_now(&plan.name, queue.seconds));
        let has_result = made.is_ok();
        let entry = made.map_or_else(
            |problem| failure(&plan, &queue.aside.start, &problem, queue.seconds),
            |mut entry| {
                if let Some(snapshot) =
                    entry.snapshot.as_mut().filter(|_| plan.method != Method::CutFlow)
                {
                    // The other methods leave the cut flow where it was.
                    snapshot.checkpoint.clone_from(&queue.aside.start.checkpoint);
                    snapshot.history.clone_from(&queue.aside.start.history);
                }
                entry
            },
        );
        let id = self.comparing.add(entry);
        queue.last = Some(id);
        queue.waits_for = (queue.waits && has_result).then_some(id);
        self.comparing.queue = Some(queue);
        self.scene_is_new |= has_result;
        events.extend(self.work.as_ref().map(Work::measures));
        events.push(self.comparison());
        events.push(Event::Scene);
    }

    /// What was done to the document; while a comparison runs to the one that is put aside.
    pub(in super::super) fn document_log(&self) -> &Log {
        self.comparing.queue.as_ref().map_or(&self.log, |queue| &queue.aside.log)
    }

    /// No more runs: the document comes back as it was.
    pub(in super::super) fn end_comparison(&mut self, events: &mut Vec<Event>) {
        let Some(queue) = self.comparing.queue.take() else { return };
        let mut aside = *queue.aside;
        let revision = self.work.as_ref().map_or(1, |work| work.revision);
        self.is_running = false;
        aside.work.revision = revision.max(aside.work.revision);
        self.work = Some(aside.work);
        (self.undo, self.redo) = (aside.undo, aside.redo);
        (self.log, self.wanted_method, self.field) = (aside.log, aside.wanted_method, aside.field);
        self.scene_is_new = true;
        events.push(self.methods());
        events.push(self.parameters());
        events.push(self.presets());
        events.push(self.paint_channels());
        events.push(self.symmetries());
        events.push(self.fields());
        self.push_energy(events);
        if self.method() == Method::Cones {
            events.extend(self.work.as_ref().map(|work| work.cones.path_event()));
        }
        events.extend(self.cones_event());
        let work = self.work.as_ref();
        events.extend(work.and_then(Work::segmentation).and_then(|s| s.told()));
        events.extend(work.map(Work::measures));
        events.push(self.history_event());
        events.push(self.comparison());
        events.push(self.status());
        events.push(Event::Scene);
    }

    /// The status line while runs are under way.
    pub(in super::super) fn comparison_status(&self) -> Option<Event> {
        let progress = self.comparing.queue.as_ref()?.progress();
        let step = self.work.as_ref().map_or(0, Work::step);
        let ResultProgress { at, of, label, is_held, .. } = progress;
        let (state, verb) = if is_held { ("paused", "Paused at") } else { ("running", "Running") };
        let text = format!("{verb} step {step}: comparing, {label}, {at} of {of}");
        Some(Event::Status { state: state.into(), step, text })
    }
}

/// A run that gave nothing.
fn failure(plan: &Plan, start: &Snapshot, problem: &Problem, seconds: Option<f64>) -> Kept {
    let mut settings = start.settings.clone();
    for (id, value) in &plan.values {
        // They were found to be fine when the comparison began.
        let _ = settings.set(id, value.clone());
    }
    let changed = super::settings::changed(&start.document, plan.method, &settings);
    let mut card = ResultCard::new(plan.method, &plan.name, changed);
    card.status = "Failed".into();
    card.seconds = seconds;
    card.note = Some(format!("{} {}", problem.what, problem.what_to_do));
    Kept { card, rows: Vec::new(), snapshot: None }
}

/// The document where all runs begin, without the cut flow: each makes the flow that it needs.
fn bare(start: &Snapshot) -> Work {
    let mut work = Work::new(start.document.clone(), start.settings.clone(), None);
    work.take_over(start);
    work.history.clear();
    work.first_cut_is_due = false;
    work
}
