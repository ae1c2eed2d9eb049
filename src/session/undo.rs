//! The way back and forth: changes with the documents, parameters and cuts that they were made to.

use std::rc::Rc;

use super::document::Document;
use super::message::{ChangeName, Command, Event};
use super::method::Method;
use super::text::Problem;
use super::work::{Snapshot, Work, start_flow};
use super::{Entry, Session};

/// Changes that Undo can take back.
const DEPTH: usize = 40;

/// Documents that Undo can go back to, the open one included.
const DOCUMENTS: usize = 3;

impl Session {
    /// Whether something goes on that Undo puts an end to.
    fn is_at_work(&self) -> bool {
        let asks_more = self.work.as_ref().is_some_and(|work| work.cones.asks_more());
        self.is_running || self.is_nesting() || asks_more
    }

    /// What waits, such as paint that a flow does not know yet, is taken up: Undo and Redo lead to nothing unfinished.
    pub(super) fn take_up(&mut self) {
        if !self.is_behind() {
            return;
        }
        // What a step would have done is a step of the project too.
        self.log.step();
        let mut events = Vec::new();
        if let Err(problem) = self.catch_up(&mut events) {
            self.refuse(problem, &mut events);
        }
        self.late.extend(events);
    }

    /// Keeps what is there now under the name of the change that comes.
    pub(super) fn remember(&mut self, label: &str, kind: &str) {
        self.take_up();
        let Some(work) = &self.work else { return };
        self.redo.clear();
        // Moving one slider is one change, unless the cut flow made steps meanwhile.
        let is_same = |last: &Snapshot| {
            last.kind == kind
                && kind.starts_with("set ")
                && last.history.len() == work.history.len()
        };
        if self.undo.last().is_some_and(is_same) {
            return;
        }
        let mut snapshot = work.snapshot(label, kind);
        snapshot.log = self.log.clone();
        snapshot.was_running = self.is_at_work();
        self.undo.push(snapshot);
        if self.undo.len() > DEPTH {
            self.undo.remove(0);
        }
        // Documents are what takes memory.
        let mut documents: Vec<*const Document> = vec![Rc::as_ptr(&work.document)];
        let keeps = |snapshot: &Snapshot| {
            let document = Rc::as_ptr(&snapshot.document);
            if !documents.contains(&document) {
                documents.push(document);
            }
            documents.len() <= DOCUMENTS
        };
        let kept = self.undo.iter().rev().map(keeps).take_while(|&keep| keep).count();
        self.undo.drain(..self.undo.len() - kept);
    }

    /// Undo (negative) or redo of so many changes at once, or of all that there are. What lies between is passed over: only
    /// where the way ends a cut is laid out.
    pub(super) fn travel(&mut self, changes: i32, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.take_up();
        let is_at_work = self.is_at_work();
        let (from, to) = if changes < 0 {
            (&mut self.undo, &mut self.redo)
        } else {
            (&mut self.redo, &mut self.undo)
        };
        let count = from.len().min(changes.unsigned_abs() as usize);
        let end = from.len() - count;
        let Some(target) = from.get(end) else { return Ok(()) };
        let work = Work::back(target)?;
        let Some(now) = &self.work else { return Ok(()) };
        let mut passed = now.snapshot("", "");
        passed.log = self.log.clone();
        passed.was_running = is_at_work;
        // A change keeps its name while what is on its other side takes its place.
        for next in from.drain(end..).rev() {
            passed.label.clone_from(&next.label);
            passed.kind.clone_from(&next.kind);
            to.push(std::mem::replace(&mut passed, next));
        }
        let target = passed;
        self.log = target.log;
        self.log.close_steps();
        if target.was_running {
            // Nothing runs after Undo.
            self.log.push(Entry::Do(Command::Pause));
            if target.method == Method::Cones {
                // But cones are solved as soon as there is time.
                self.log.push(Entry::Do(Command::Run));
            }
        }
        if target.was_folded {
            // Nor is anything folded.
            self.log.push(Entry::Do(Command::Unfold));
        }
        let allowances = target.seam_allowances;
        self.install(work, events);
        if let Some(work) = &mut self.work {
            work.seam_allowances = allowances;
            work.drop_pattern();
        }
        self.tell_pattern(events);
        Ok(())
    }

    /// The names along the way back or forth, nearest first.
    pub(super) fn changes(&self, list: &[Snapshot]) -> Vec<ChangeName> {
        let mut here = self.work.as_ref().map(|work| Rc::as_ptr(&work.document));
        let name = |snapshot: &Snapshot| {
            let there = Some(Rc::as_ptr(&snapshot.document));
            let is_other_mesh = std::mem::replace(&mut here, there) != there;
            ChangeName { label: snapshot.label.clone(), is_other_mesh }
        };
        list.iter().rev().map(name).collect()
    }
}

impl Work {
    /// The work of a snapshot.
    pub(super) fn back(target: &Snapshot) -> Result<Self, Problem> {
        let resume = |checkpoint| {
            start_flow(&target.document, &target.settings, &target.layers, Some(checkpoint))
        };
        let flow = target.checkpoint.as_ref().map(resume).transpose()?;
        let mut work = Self::new(target.document.clone(), target.settings.clone(), flow);
        work.take_over(target);
        Ok(work)
    }

    /// What a snapshot holds besides the document, its parameters and the cut flow.
    pub(super) fn take_over(&mut self, target: &Snapshot) {
        self.method = target.method;
        self.cones.edits = target.edits.clone();
        self.cones.path = target.path.clone();
        self.cones.comparison.clone_from(&target.cone_comparison);
        self.cones.is_stale = true;
        self.cones.is_held = target.were_cones_paused;
        self.phase.put_back(target.phase.clone());
        self.develop.put_back(target.develop.clone());
        self.layers = target.layers.clone();
        self.pending = target.pending;
        self.seam_edges.clone_from(&target.seam_edges);
        self.symmetries.clone_from(&target.symmetries);
        self.history.clone_from(&target.history);
        self.start.clone_from(&target.start);
        self.first_cut_is_due = target.first_cut_is_due;
    }
}
