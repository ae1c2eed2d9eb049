//! The events that say how the session stands.

use super::text::plural;
use super::{
    ChangeName, Event, Method, Problem, SampleChoice, Session, Work, doctor, error_event, picture,
    preparing, samples, size, specs_of,
};
use crate::methods::cutflow::CutFlow;
use crate::methods::flow::Status;

impl Session {
    pub(super) fn refuse(&self, problem: Problem, events: &mut Vec<Event>) {
        let text = format!("Error: {}", problem.what);
        events.push(error_event(problem));
        let step = self.work.as_ref().map_or(0, Work::step);
        events.push(Event::Status { state: "error".into(), step, text });
    }

    pub(super) fn doctor_event(&self) -> Option<Event> {
        let work = self.work.as_ref()?;
        Some(Event::Doctor(doctor::report(&work.document, self.shown.as_deref())))
    }

    /// What follows the facts of a mesh: findings, tools, size.
    pub(super) fn mesh_events(&self) -> impl Iterator<Item = Event> + use<> {
        let tools = self.work.as_ref().map(|work| preparing::tools(&work.document));
        let tools = tools.map(|options| Event::Tools { options });
        [self.doctor_event(), tools, self.size_event()].into_iter().flatten()
    }

    pub(super) fn size_event(&self) -> Option<Event> {
        let work = self.work.as_ref()?;
        Some(size::event(&work.document, &work.settings))
    }

    /// The curve from the start.
    pub(super) fn push_energy(&self, events: &mut Vec<Event>) {
        if let Some(work) = &self.work {
            events.extend(work.energy_curve());
        }
    }

    pub(super) fn samples(&self) -> Event {
        Event::Samples {
            options: samples::SAMPLES
                .iter()
                .map(|s| SampleChoice {
                    name: s.name.into(),
                    label: s.label.into(),
                    description: s.description.into(),
                })
                .collect(),
            current: self.document().and_then(|d| d.sample.clone()),
        }
    }

    pub(super) fn fields(&self) -> Event {
        Event::Fields { current: self.field.clone(), options: picture::fields(self.method()) }
    }

    pub(super) fn parameters(&self) -> Event {
        let specs = specs_of(self.method());
        let mut values = self.work.as_ref().map(|w| w.settings.values()).unwrap_or_default();
        values.retain(|id, _| specs.iter().any(|spec| spec.id == *id));
        Event::Parameters { method: self.method().id().into(), specs, values }
    }

    pub(super) fn history_event(&self) -> Event {
        // The way back is the document's, which is put aside while a comparison runs.
        let is_here = !self.is_comparing();
        let [done, undone] = [&self.undo, &self.redo]
            .map(|list| if is_here { self.changes(list) } else { Vec::new() });
        let label = |list: &[ChangeName]| list.first().map(|change| change.label.clone());
        Event::History { undo: label(&done), redo: label(&undone), done, undone }
    }

    pub(super) fn status(&self) -> Event {
        if let Some(event) = self.comparison_status() {
            return event;
        }
        let Some(work) = &self.work else {
            let text = "Ready: open a mesh or choose a sample".into();
            return Event::Status { state: "ready".into(), step: 0, text };
        };
        let step = work.step();
        let limit = work.settings.number("steps");
        let folding = work.fold.as_ref().filter(|fold| fold.is_running);
        let refining = work.refinement.as_ref().filter(|_| self.is_refining());
        let (state, text) = if !self.replay.is_over() {
            ("preparing", self.replay.status())
        } else if let Some(text) = self.nesting_text() {
            ("running", text)
        } else if let Some(refinement) = refining {
            ("running", format!("Running step {} of evening out", refinement.steps() + 1))
        } else if let Some(fold) = folding {
            ("running", format!("Running step {} of the fold preview", fold.flow.steps()))
        } else if let Some(preparation) = &self.preparation {
            ("preparing", preparation.status())
        } else if work.first_cut_is_due {
            ("preparing", format!("Loading {}: making the first cut", work.document.name))
        } else if work.document.surface.is_none() {
            ("ready", "Ready: the mesh needs repair before it can be cut".to_owned())
        } else if work.method == Method::Cones {
            self.cones_status(work)
        } else if self.is_segmenting() {
            self.segment_text(work)
        } else if self.is_running {
            let is_testing = work.flow.as_ref().is_some_and(CutFlow::is_testing);
            let what = if is_testing { ": is there a better cut beside it?" } else { "" };
            ("running", format!("Running step {step}{what}"))
        } else {
            match work.flow.as_ref().map(CutFlow::status) {
                None => ("ready", "Ready: not cut yet".to_owned()),
                Some(Status::Converged) => {
                    ("converged", format!("Converged after {}", plural(step, "step")))
                }
                // Every direction was tried at every length: as good an end as the other.
                Some(Status::Stalled) => (
                    "stalled",
                    format!(
                        "Converged after {}: no search lowers the energy further",
                        plural(step, "step")
                    ),
                ),
                Some(_) if step as f64 >= limit => {
                    ("step_limit", format!("Paused at step {step}: step limit reached"))
                }
                Some(_) if step == 0 => ("ready", "Ready".to_owned()),
                Some(_) => ("paused", format!("Paused at step {step}")),
            }
        };
        Event::Status { state: state.into(), step, text }
    }
}
