//! Results of several methods or settings on one mesh, side by side.
//!
//! A result is what stood when it was kept: method, parameters, measures, and a snapshot that brings it back. Runs of a comparison
//! ([`runs`]) start from the document as it is, each afresh, and leave it as it was.
//!
//! Guaranteed: numbers of a result are those of its method run alone with its parameters; a run that fails becomes a result with a
//! note, and the others go on. Results go with their mesh. What a project holds is how its document came about, so results are not in it;
//! showing one again takes over the log that led to it, and a project saved then replays to that result.
//!
//! Not guaranteed: the last digits of cones that were kept after moves of a slider. They are solved again from nothing when they are
//! shown, to the same optimum within the solver's tolerance.

mod csv;
mod runs;
mod settings;
mod table;

use super::exporting::stem;
use super::message::{Command, Event, File};
use super::method::Method;
use super::project::{Entry, Log};
use super::text::Problem;
use super::work::{Snapshot, Work};
use super::{Session, nothing_open};

pub(super) use runs::Queue;
pub use table::{ChangedSetting, ResultCard, ResultProgress, ResultRow, ResultTable};

/// Results of one mesh. Each holds a copy of a flow's state, and cards beyond that are not looked at.
const MOST: usize = 24;

/// Longest name, in characters.
const LONGEST: usize = 80;

/// Results, and the runs that are still to give some.
#[derive(Default)]
pub(super) struct Comparing {
    entries: Vec<Kept>,
    next: usize,
    queue: Option<Queue>,
    /// The result that the driver was told stands now.
    told: Option<usize>,
}

/// A result.
struct Kept {
    card: ResultCard,
    rows: Vec<super::message::Row>,
    /// What brings it back; a run that failed has nothing.
    snapshot: Option<Snapshot>,
}

impl Comparing {
    fn find(&self, id: usize) -> Result<usize, Problem> {
        self.entries.iter().position(|entry| entry.card.id == id).ok_or_else(|| {
            Problem::new(
                format!("There is no result {id}."),
                "Comparison.",
                "Choose one of those that are there.",
            )
        })
    }

    /// The result that has this very history.
    fn current(&self, log: &Log) -> Option<usize> {
        let is_it = |entry: &&Kept| entry.snapshot.as_ref().is_some_and(|s| s.log.is_same(log));
        self.entries.iter().rev().find(is_it).map(|entry| entry.card.id)
    }

    fn has_room(&self, wanted: usize) -> Result<(), Problem> {
        if self.entries.len() + wanted <= MOST {
            return Ok(());
        }
        Err(Problem::new(
            format!("A comparison holds {MOST} results at most."),
            "Comparison.",
            "Remove some first.",
        ))
    }

    fn add(&mut self, mut entry: Kept) -> usize {
        entry.card.id = self.next;
        entry.card.name = self.free_name(&entry.card.name);
        self.next += 1;
        self.entries.push(entry);
        self.next - 1
    }

    /// A name that no result has yet.
    fn free_name(&self, wanted: &str) -> String {
        let is_taken = |name: &str| self.entries.iter().any(|entry| entry.card.name == name);
        let numbered = (2..).map(|n| format!("{wanted} {n}"));
        let mut names = std::iter::once(wanted.to_owned()).chain(numbered);
        names.find(|name| !is_taken(name)).unwrap_or_default()
    }
}

/// A name as it is kept: without what would break a line, not too long.
fn tidy(name: &str) -> String {
    let clean: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    clean.trim().chars().take(LONGEST).collect()
}

/// Whether a command changes nothing that a run of the comparison, or the document behind it, depends on.
fn goes_along(command: &Command) -> bool {
    matches!(
        command,
        Command::Hello
            | Command::Run
            | Command::Pause
            | Command::Step
            | Command::ShowField { .. }
            | Command::Hold { .. }
            | Command::EndStroke
            | Command::DismissError
            | Command::RenameResult { .. }
            | Command::RemoveResult { .. }
            | Command::NextResult
    )
}

impl Session {
    /// What a command means to a comparison that is under way: most end it, the document comes back first.
    pub(super) fn heed_comparison(&mut self, command: &Command, events: &mut Vec<Event>) {
        let Some(queue) = &mut self.comparing.queue else { return };
        match command {
            Command::Pause | Command::Step => queue.is_held = true,
            Command::Run => queue.is_held = false,
            command if goes_along(command) => return,
            _ => return self.end_comparison(events),
        }
        events.push(self.comparison());
    }

    /// Tells of it when another result, or none, is what stands now.
    pub(super) fn tell_current(&mut self, events: &mut Vec<Event>) {
        if self.current_result() != self.comparing.told {
            events.push(self.comparison());
        }
    }

    fn current_result(&self) -> Option<usize> {
        // What stands behind a comparison under way is not what is seen.
        self.comparing.queue.is_none().then(|| self.comparing.current(&self.log)).flatten()
    }

    /// All results, as a driver shows them.
    pub(super) fn comparison(&mut self) -> Event {
        self.comparing.told = self.current_result();
        Event::Comparison(self.result_table())
    }

    /// The results of the open mesh.
    pub fn result_table(&self) -> ResultTable {
        let comparing = &self.comparing;
        let progress = comparing.queue.as_ref().map(Queue::progress);
        let mut table = table::table(&comparing.entries, self.current_result());
        table.progress = progress;
        table
    }

    /// Another mesh: its results are yet to come.
    pub(super) fn forget_results(&mut self) -> Event {
        self.comparing = Comparing { next: self.comparing.next, ..Comparing::default() };
        self.comparison()
    }

    /// Keeps what stands now as a result. **Takes** the time that the driver measured, if it did.
    pub(super) fn keep_result(
        &mut self,
        name: Option<&str>,
        seconds: Option<f64>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        self.comparing.has_room(1)?;
        self.work.as_ref().ok_or_else(nothing_open)?.document.surface()?;
        if self.has_work() {
            let told = self.do_again(Command::Pause);
            events.extend(told);
        }
        self.settled()?;
        let entry = self.result_now(name.unwrap_or_default(), seconds)?;
        self.comparing.add(entry);
        // Whoever takes its picture waits for the next one.
        self.scene_is_new = true;
        events.extend(self.work.as_ref().map(Work::measures));
        events.push(self.comparison());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// What stands now, settled, as a result.
    fn result_now(&mut self, name: &str, seconds: Option<f64>) -> Result<Kept, Problem> {
        let Event::Status { text: status, .. } = self.status() else { return Err(nothing_open()) };
        let work = self.work.as_ref().ok_or_else(nothing_open)?;
        if work.layout.is_none() || !(work.has_cut() || work.method == Method::Cones) {
            let notes = work.segmentation().map(|s| s.notes().join(" ")).unwrap_or_default();
            return Err(Problem::new(
                "There is nothing to keep: the surface has not been cut.",
                format!("{}.", work.document.name),
                if notes.is_empty() { "Run the method first.".into() } else { notes },
            ));
        }
        let mut snapshot = work.snapshot("", "");
        snapshot.log = self.log.clone();
        let Event::Measures { rows, note, .. } = work.measures() else {
            return Err(nothing_open());
        };
        let changed = settings::changed(&work.document, work.method, &work.settings);
        let mut card = ResultCard::new(work.method, name, changed);
        card.has_result = true;
        card.steps = Some(work.step());
        card.status = status;
        card.note = note;
        card.seconds = seconds.filter(|s| s.is_finite() && *s >= 0.0);
        Ok(Kept { card, rows, snapshot: Some(snapshot) })
    }

    /// Shows a result again: it is what stands now.
    pub(super) fn restore_result(
        &mut self,
        id: usize,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let entry = &self.comparing.entries[self.comparing.find(id)?];
        let Some(snapshot) = entry.snapshot.clone() else {
            return Err(Problem::new(
                format!("“{}” gave no result that could be shown.", entry.card.name),
                "Comparison.",
                "Choose another one, or change its parameters and run it again.",
            ));
        };
        let label = format!("show {}", entry.card.name);
        let work = Work::back(&snapshot)?;
        self.unmark(events);
        self.remember(&label, "restore");
        if let Some(old) = &mut self.work {
            // Cones are solved from nothing, as they were: what a solver knows would show in the last digits.
            old.cones = super::cones::Cones::default();
        }
        self.log = snapshot.log.clone();
        if snapshot.was_folded {
            // It is shown flat.
            self.log.push(Entry::Do(Command::Unfold));
        }
        let allowances = snapshot.seam_allowances;
        self.field = work.method.first_field().into();
        self.wanted_method = work.method;
        self.install(work, events);
        if let Some(work) = &mut self.work {
            work.seam_allowances = allowances;
            work.drop_pattern();
        }
        self.tell_pattern(events);
        events.extend(self.cones_event());
        events.push(self.comparison());
        Ok(())
    }

    pub(super) fn remove_result(
        &mut self,
        id: usize,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let at = self.comparing.find(id)?;
        self.comparing.entries.remove(at);
        events.push(self.comparison());
        Ok(())
    }

    pub(super) fn rename_result(
        &mut self,
        id: usize,
        name: &str,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let at = self.comparing.find(id)?;
        let name = tidy(name);
        if name.is_empty() {
            return Err(Problem::new(
                "A result needs a name.",
                "Comparison.",
                "Type at least one letter.",
            ));
        }
        self.comparing.entries[at].card.name = name;
        events.push(self.comparison());
        Ok(())
    }

    /// The table as a file: one line for each result.
    pub(super) fn comparison_file(&self) -> Result<File, Problem> {
        let work = self.work.as_ref().ok_or_else(nothing_open)?;
        let table = self.result_table();
        if table.results.is_empty() {
            return Err(Problem::new(
                "There is nothing to compare yet.",
                format!("{}.", work.document.name),
                "Keep a result, or compare methods.",
            ));
        }
        Ok(File {
            name: format!("{}-comparison.csv", stem(&work.document.name)),
            mime: "text/csv",
            bytes: csv::csv(&table).into_bytes(),
        })
    }

    /// The results as reports name them; none are left out of a report without any.
    pub(super) fn compared_results(&self) -> Vec<ResultCard> {
        self.result_table().results
    }
}
