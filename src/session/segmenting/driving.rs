//! Driving a segmentation: run, step, reset, parameters that act while it runs.

use super::super::message::Event;
use super::super::method::Method;
use super::super::text::{Problem, plural};
use super::super::work::Work;
use super::super::{Session, nothing_open};
use crate::methods::flow::Status;

impl Session {
    /// Whether the method at work is a segmentation.
    pub(in super::super) fn is_segmenting(&self) -> bool {
        matches!(self.method(), Method::PhaseField | Method::Developable)
    }

    /// Runs until the flow ends or is paused.
    pub(in super::super) fn segment_run(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.segment_prepare(events)?;
        self.unmark(events);
        let has_more = self.segment_status() == Some(Status::Running);
        if has_more && !self.is_running {
            let step = self.work.as_ref().map_or(0, Work::step);
            self.remember(&format!("run from step {step}"), "run");
        }
        if self.work.as_ref().is_some_and(|work| work.fold.is_some()) {
            self.unfold(events)?;
        }
        self.is_running = has_more;
        events.push(self.history_event());
        events.push(self.status());
        Ok(())
    }

    /// One step by hand.
    pub(in super::super) fn segment_step(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        self.segment_prepare(events)?;
        self.unmark(events);
        self.is_running = false;
        if self.segment_status() == Some(Status::Running) {
            let step = self.work.as_ref().map_or(0, Work::step);
            self.remember(&format!("step {}", step + 1), "step");
            self.segment_on(events)?;
            self.is_running = false;
            self.settle(events);
        }
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// Back to the start.
    pub(in super::super) fn segment_reset(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        self.work.as_ref().ok_or_else(nothing_open)?.document.surface()?;
        self.remember("reset", "reset");
        if let Some((segmentation, _)) =
            self.work.as_mut().and_then(|work| work.segmentation_mut().transpose()).transpose()?
        {
            segmentation.begin_again();
        }
        self.segment_prepare(events)?;
        self.settle(events);
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// One bounded piece of a run.
    pub(in super::super) fn segment_on(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let Some((segmentation, inputs)) = work.segmentation_mut()? else { return Ok(()) };
        if segmentation.status().is_none() {
            segmentation.prepare(&inputs)?;
        }
        let told = segmentation.curve().len();
        segmentation.step(&inputs)?;
        let goes_on = segmentation.status() == Some(Status::Running);
        events.extend(segmentation.curve().get(told..).into_iter().flatten().cloned());
        events.extend(segmentation.told());
        work.is_settled = false;
        work.fold = None;
        self.is_running &= goes_on;
        self.scene_is_new = true;
        Ok(())
    }

    /// The flow takes parameters and paint over. One that has run goes on from where it is; one that has not shows its new start.
    pub(in super::super) fn segment_follow(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let had_run = self.work.as_ref().is_some_and(|work| work.step() > 0);
        self.segment_prepare(events)?;
        if had_run && self.segment_status() == Some(Status::Running) {
            self.is_running = true;
        } else if !self.is_running {
            self.settle(events);
        }
        events.push(Event::Scene);
        Ok(())
    }

    /// Sees to it that there is a flow and that it is up to parameters and paint.
    pub(in super::super) fn segment_prepare(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.tell_flow_aside()?;
        let Some((segmentation, inputs)) = work.segmentation_mut()? else { return Ok(()) };
        if segmentation.prepare(&inputs)? {
            events.extend(segmentation.curve().iter().cloned());
            events.extend(segmentation.told());
            let is_start = segmentation.steps() == 0;
            work.is_settled = false;
            work.fold = None;
            if is_start {
                work.start = None;
            }
        }
        self.scene_is_new = true;
        Ok(())
    }

    fn segment_status(&self) -> Option<Status> {
        self.work.as_ref()?.segmentation()?.status()
    }

    /// The status line.
    pub(in super::super) fn segment_text(&self, work: &Work) -> (&'static str, String) {
        let Some(segmentation) = work.segmentation() else { return ("ready", "Ready".into()) };
        let step = segmentation.steps();
        if self.is_running {
            let doing = segmentation.doing();
            let colon = if doing.is_empty() { "" } else { ": " };
            return ("running", format!("Running step {step}{colon}{doing}"));
        }
        match segmentation.status() {
            None => ("ready", "Ready".into()),
            Some(Status::Running) if step == 0 => ("ready", "Ready".into()),
            Some(Status::Running) => ("paused", format!("Paused at step {step}")),
            Some(Status::StepLimit) => {
                ("step_limit", format!("Paused at step {step}: step limit reached"))
            }
            Some(Status::Infeasible) => {
                ("stalled", format!("Paused at step {step}: {}", segmentation.doing()))
            }
            Some(Status::Converged | Status::Stalled) => {
                ("converged", format!("Converged after {}", plural(step, "step")))
            }
        }
    }
}
