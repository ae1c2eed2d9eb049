//! Steps: what is done between two commands, in bounded pieces, and what a run leaves when it rests.

use std::rc::Rc;

use super::work::Pending;
use super::{Event, Method, Problem, Replay, Session, Work, error_event, no_initial_cut};

impl Session {
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
            // Charts take longest: what cones there are is told before.
            if self.are_charts_due() || !go_on() {
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
    pub(super) fn give_up(&mut self, problem: Problem, events: &mut Vec<Event>) {
        self.is_running = false;
        self.preparation = None;
        self.refuse(problem, events);
    }

    /// One step of what has most need of one.
    pub(super) fn step_once(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
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
    pub(super) fn rest(&mut self, events: &mut Vec<Event>) {
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

    pub(super) fn has_work(&self) -> bool {
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
    pub fn is_behind(&self) -> bool {
        let is_due = |work: &Work| !matches!(work.pending, Pending::None | Pending::Stroke);
        self.work.as_ref().is_some_and(is_due)
    }

    /// What was told of since the last answer: by pictures that were made meanwhile.
    pub fn take_late(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.late)
    }

    pub(super) fn is_stroke_open(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.pending == Pending::Stroke)
    }

    /// The stroke has ended: what it painted is where the flow starts.
    pub(super) fn end_stroke(&mut self) {
        if let Some(work) = self.work.as_mut().filter(|work| work.pending == Pending::Stroke) {
            work.pending = Pending::Restart;
        }
    }

    pub(super) fn first_cut_is_due(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.first_cut_is_due)
    }

    /// Makes the initial cut of a mesh that has only been shown so far.
    pub(super) fn make_first_cut(&mut self, events: &mut Vec<Event>) {
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

    /// Flattens the current cut whole, first pieces of developable patches as they come.
    pub(super) fn settle(&mut self, events: &mut Vec<Event>) {
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
        // First pieces are far from flat: to part them until nothing overlaps takes long, and is done for those who want a pattern or a file.
        let is_sketch = work.has_first_pieces_only() && !self.is_pattern_shown;
        match if is_sketch { work.sketch() } else { work.settle() } {
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
}
