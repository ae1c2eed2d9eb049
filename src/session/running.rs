//! Driving the flow: run, pause, step, reset, and the steps themselves.

use super::inputs::Layers;
use super::message::Event;
use super::method::Method;
use super::report::HistoryRow;
use super::text::Problem;
use super::work::{Work, energy_event, start_flow};
use super::{Session, nothing_open};
use crate::methods::cutflow::CutFlow;
use crate::methods::flow::{Flow, Status};

impl Session {
    pub(super) fn run(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        if self.method() == Method::Cones {
            return self.cones_run(events);
        }
        if self.is_segmenting() {
            return self.segment_run(events);
        }
        let first = self.first_flow()?;
        self.unmark(events);
        if first.is_none() && self.is_at_end() {
            events.push(self.status());
            return Ok(());
        }
        if !self.is_running {
            let step = self.work.as_ref().map_or(0, Work::step);
            self.remember(&format!("run from step {step}"), "run");
        }
        if self.work.as_ref().is_some_and(|work| work.fold.is_some()) {
            self.unfold(events)?;
        }
        self.begin_first(first, events);
        self.is_running = true;
        events.push(self.history_event());
        events.push(self.status());
        Ok(())
    }

    pub(super) fn pause(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.is_running = false;
        if self.is_nesting() {
            self.stop_nesting();
            self.tell_pattern(events);
        }
        self.cones_pause();
        if let Some(fold) = self.work.as_mut().and_then(|work| work.fold.as_mut()) {
            fold.is_running = false;
        }
        if let Some(refinement) = self.work.as_mut().and_then(|work| work.refinement.as_mut()) {
            refinement.is_running = false;
        }
        if self.work.as_ref().is_some_and(|work| !work.is_settled) {
            self.settle(events);
        }
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    pub(super) fn step(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        if self.method() == Method::Cones {
            return self.cones_step(events);
        }
        if self.is_segmenting() {
            return self.segment_step(events);
        }
        let first = self.first_flow()?;
        self.unmark(events);
        self.is_running = false;
        let has_ended =
            |work: &Work| work.flow.as_ref().is_some_and(|f| f.status() != Status::Running);
        if self.work.as_ref().is_some_and(has_ended) {
            events.push(self.status());
            return Ok(());
        }
        let step = self.work.as_ref().map_or(0, Work::step);
        self.remember(&format!("step {}", step + 1), "step");
        self.begin_first(first, events);
        self.one_step(events)?;
        self.is_running = false;
        self.settle(events);
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    pub(super) fn reset(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.is_running = false;
        if self.method() == Method::Cones {
            return self.cones_reset(events);
        }
        if self.is_segmenting() {
            return self.segment_reset(events);
        }
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let flow = work.new_flow(None)?;
        self.remember("reset", "reset");
        if let Some(work) = &mut self.work {
            work.begin(flow);
        }
        self.push_energy(events);
        self.settle(events);
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// Starts again with other layers.
    pub(super) fn restart_with(
        &mut self,
        layers: Layers,
        label: &str,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let flow = start_flow(&work.document, &work.settings, &layers, None)?;
        self.remember(label, label);
        if let Some(work) = &mut self.work {
            work.layers = layers;
            work.begin(flow);
        }
        self.push_energy(events);
        self.settle(events);
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// Whether Run has nothing left to do.
    fn is_at_end(&self) -> bool {
        self.work.as_ref().is_some_and(|work| {
            let flow = work.flow.as_ref();
            work.step() as f64 >= work.settings.number("steps")
                || flow.is_some_and(|flow| flow.status() != Status::Running)
        })
    }

    /// The flow of a surface that has none yet, or why there is none. Undo of what comes leads back to the surface without it.
    fn first_flow(&self) -> Result<Option<CutFlow>, Problem> {
        let work = self.work.as_ref().ok_or_else(nothing_open)?;
        work.flow.is_none().then(|| work.new_flow(None)).transpose()
    }

    fn begin_first(&mut self, first: Option<CutFlow>, events: &mut Vec<Event>) {
        if let (Some(flow), Some(work)) = (first, &mut self.work) {
            work.begin(flow);
            self.push_energy(events);
            self.settle(events);
        }
    }

    pub(super) fn one_step(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.end_stroke();
        if self.is_behind() {
            self.catch_up(events)?;
        }
        let Some(work) = &mut self.work else { return Ok(()) };
        let limit = work.settings.number("steps");
        let Some(flow) = &mut work.flow else {
            self.is_running = false;
            return Ok(());
        };
        let before = flow.steps();
        let document = work.document.clone();
        let report = flow.step().map_err(|error| document.unsolved(&error))?;
        if report.step > before {
            let energy = flow.state().energy();
            // By the weights that a schedule has reached now, as all rows are told when they are measured anew.
            let weights = flow.params().weights_at(report.step);
            let row = HistoryRow::new(report.step, &energy, &weights);
            work.history.push(row);
            work.is_settled = false;
            work.drop_given();
            work.stages = None;
            work.fold = None;
            self.scene_is_new = true;
            events.push(energy_event(&row));
        }
        if report.status != Status::Running || report.step as f64 >= limit {
            self.is_running = false;
        }
        Ok(())
    }
}
