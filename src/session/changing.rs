//! Changed settings: tried first, then put in force, with what follows from them.

use super::work::start_flow;
use super::{
    Effect, Event, Problem, Session, Settings, Value, Work, all_specs, nothing_open, patterning,
    size, specs_of,
};
use crate::methods::cutflow::CutFlow;

impl Session {
    pub(super) fn set_parameter(
        &mut self,
        id: &str,
        value: Value,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let mut settings = work.settings.clone();
        let Some(effect) = settings.set(id, value)? else {
            events.push(self.parameters());
            return Ok(());
        };
        if id == "unit" {
            size::follow_unit(&work.document, &mut settings)?;
        }
        self.apply(id, settings, effect, events)
    }

    pub(super) fn set_side(
        &mut self,
        axis: usize,
        value: f64,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let mut settings = work.settings.clone();
        size::set_side(&work.document, &mut settings, axis, value)?;
        self.apply("size", settings, Effect::Export, events)
    }

    /// Puts changed settings in force.
    pub(super) fn apply(
        &mut self,
        id: &str,
        settings: Settings,
        effect: Effect,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        // Try before anything changes.
        let params = settings.flow_params();
        params.validate().map_err(|error| Problem::solve(&work.document.name, &error))?;
        let restarted = match effect {
            Effect::Restart if work.document.surface.is_some() => {
                Some(start_flow(&work.document, &settings, &work.layers, None)?)
            }
            _ => None,
        };
        let label = all_specs().into_iter().find(|s| s.id == id).map_or_else(
            || format!("change {id}"),
            |spec| format!("change {}", spec.label.to_lowercase()),
        );
        let label = if id.starts_with("preset ") { id.to_owned() } else { label };
        let depth = self.undo.len();
        let redo = std::mem::take(&mut self.redo);
        self.remember(&label, &format!("set {id}"));
        let Some(work) = &mut self.work else { return Ok(()) };
        let before = std::mem::replace(&mut work.settings, settings);
        if let Err(problem) = self.follow_settings(id, effect, restarted, events) {
            // What cannot be followed is not in force.
            if let Some(work) = &mut self.work {
                work.settings = before;
            }
            self.undo.truncate(depth);
            self.redo = redo;
            return Err(problem);
        }
        events.push(self.parameters());
        events.push(self.presets());
        events.extend(self.size_event());
        events.push(self.history_event());
        events.push(self.status());
        if matches!(effect, Effect::Export | Effect::Pattern) {
            self.tell_pattern(events);
        }
        Ok(())
    }

    /// Does what changed settings ask for.
    pub(super) fn follow_settings(
        &mut self,
        id: &str,
        effect: Effect,
        restarted: Option<CutFlow>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        match (effect, restarted) {
            (_, Some(flow)) => {
                work.begin(flow);
                if id.starts_with("preset ") {
                    // It says how charts are made too.
                    work.finish_anew();
                }
                self.push_energy(events);
                self.settle(events);
                events.push(Event::Scene);
            }
            (Effect::NextStep | Effect::Restart, None) => {
                let name = &work.document.name;
                let fields = work.fields();
                let params = work.settings.flow_params();
                if let Some(flow) = &mut work.flow {
                    flow.set_params(params).map_err(|e| Problem::solve(name, &e))?;
                    if ["source", "heat"].contains(&id) {
                        flow.set_fields(&fields).map_err(|e| Problem::solve(name, &e))?;
                    }
                    work.remeasure();
                    self.push_energy(events);
                }
                events.extend(self.work.as_ref().map(Work::measures));
            }
            (Effect::Finish, None) => {
                work.finish_anew();
                if !self.is_running {
                    self.settle(events);
                    events.push(Event::Scene);
                }
            }
            (Effect::Export, None) => {
                work.drop_pattern();
                events.push(work.measures());
            }
            (Effect::Pattern, None) => {
                if patterning::makes_other_pieces(id) {
                    work.drop_pattern();
                }
                events.push(self.trades_event());
            }
            (Effect::Cones, None) => self.cones_are_due(),
            (Effect::ConeSet, None) => self.use_cones_anew(),
            (Effect::Segments, None) => {
                // Those of the other segmentation wait until it is at work.
                let is_own = specs_of(self.method()).iter().any(|spec| spec.id == id);
                if self.is_segmenting() && is_own {
                    self.segment_follow(events)?;
                }
            }
        }
        Ok(())
    }
}
