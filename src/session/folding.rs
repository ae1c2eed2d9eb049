//! The developable preview: the surface that the flat pieces make when they are sewn together.

use super::message::Event;
use super::report::FoldReport;
use super::text::Problem;
use super::{Session, nothing_open};
use crate::flatten::fold::{FoldFlow, FoldParams};
use crate::methods::flow::{Flow, Status};

/// Steps after which a preview rests whatever is left: wrinkles have settled long before.
const STEPS: usize = 400;

/// A preview at work or at rest.
pub(super) struct Fold {
    pub flow: FoldFlow,
    /// Whether there is more to do.
    pub is_running: bool,
}

impl Session {
    /// Begins a preview of the cut at rest. A running flow is paused.
    pub(super) fn fold(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.is_running = false;
        // Charts may be made, or evened out, for it.
        let measures = self.settled()?.measures();
        events.push(measures);
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let Some(layout) = &work.layout else { return Err(nothing_open()) };
        let wrong = |error| Problem::solve(&work.document.name, &error);
        let params = FoldParams::default();
        let flow = FoldFlow::new(&layout.opened, &layout.points, &layout.flattening, params)
            .map_err(wrong)?;
        work.fold = Some(Fold { flow, is_running: true });
        self.scene_is_new = true;
        events.push(self.fold_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// Shows the surface itself again.
    pub(super) fn unfold(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        if let Some(work) = &mut self.work {
            work.fold = None;
        }
        self.scene_is_new = true;
        events.push(self.fold_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    pub(super) fn is_folded(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.fold.is_some())
    }

    /// Says so when a change of the cut has ended a preview.
    pub(super) fn tell_unfolded(&self, was_folded: bool, events: &mut Vec<Event>) {
        if was_folded && !self.is_folded() {
            events.push(self.fold_event());
        }
    }

    pub(super) fn is_folding(&self) -> bool {
        let fold = self.work.as_ref().and_then(|work| work.fold.as_ref());
        fold.is_some_and(|fold| fold.is_running)
    }

    pub(super) fn fold_on(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        let Some(fold) = &mut work.fold else { return Ok(()) };
        let result = fold.flow.step();
        let is_over = !matches!(&result, Ok(report) if report.status == Status::Running);
        if is_over || fold.flow.steps() >= STEPS {
            fold.is_running = false;
        }
        result.map_err(|error| Problem::solve(&work.document.name, &error))?;
        self.scene_is_new = true;
        events.push(self.fold_event());
        Ok(())
    }

    /// The report of `cutflow cut --fold`.
    pub fn fold_report(&self) -> Result<FoldReport, Problem> {
        let fold =
            self.work.as_ref().and_then(|work| work.fold.as_ref()).ok_or_else(nothing_open)?;
        let measures = fold.flow.measures();
        Ok(FoldReport {
            steps: fold.flow.steps(),
            distance_mean: measures.distance_mean,
            distance_max: measures.distance_max,
            stretch: measures.stretch,
        })
    }

    pub(super) fn fold_event(&self) -> Event {
        let fold = self.work.as_ref().and_then(|work| work.fold.as_ref());
        let measures = fold.map(|fold| fold.flow.measures());
        Event::Fold {
            is_on: fold.is_some(),
            step: fold.map_or(0, |fold| fold.flow.steps()),
            distance_mean: measures.map_or(0.0, |m| m.distance_mean),
            distance_max: measures.map_or(0.0, |m| m.distance_max),
            stretch: measures.map_or(0.0, |m| m.stretch),
        }
    }
}
