//! Driving the solver: rounds, pause, reset, the path over λ, the comparison. Everything long is done in bounded pieces.

use super::super::charting::Charting;
use super::super::layout::Layout;
use super::super::message::{Event, Value};
use super::super::method::Method;
use super::super::text::{Problem, plural};
use super::super::work::Work;
use super::super::{Session, nothing_open};
use super::{ConeSet, Wanted, measures};
use crate::methods::flow::{Flow, Status};

/// Prices that the parameter takes.
const PRICES: [f64; 2] = [1e-4, 0.2];

/// More cones than that are not compared: the greedy strategy keeps a Green's function for each.
const MOST_COMPARED: usize = 200;

impl Session {
    /// Whether the cones are at work and there is something to do for them.
    pub(in super::super) fn cones_have_work(&self) -> bool {
        self.work.as_ref().is_some_and(|work| {
            let cones = &work.cones;
            work.method == Method::Cones
                && work.document.surface.is_some()
                && (cones.is_due()
                    || cones.tracing.is_some()
                    || (cones.is_solved()
                        && (self.is_settling_due(work) || cones.wanted != Wanted::Nothing)))
        })
    }

    /// Whether the solver has rounds to make.
    pub(in super::super) fn are_cones_due(&self) -> bool {
        let is_due = |work: &Work| {
            work.method == Method::Cones && work.document.surface.is_some() && work.cones.is_due()
        };
        self.work.as_ref().is_some_and(is_due)
    }

    /// Whether it has none, and the charts are not those of its cones.
    pub(in super::super) fn are_charts_due(&self) -> bool {
        let is_due = |work| self.is_settling_due(work);
        self.cones_have_work() && !self.are_cones_due() && self.work.as_ref().is_some_and(is_due)
    }

    /// Whether charts are to be made. While a slider is held the next move comes soon, and would wait for them.
    fn is_settling_due(&self, work: &Work) -> bool {
        !work.is_settled && !self.is_held
    }

    /// One bounded piece of that.
    pub(in super::super) fn cones_advance(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        if self.are_cones_due() {
            let result = self.cones_round(events);
            if self.are_cones_due() || result.is_err() {
                self.log.round();
            } else {
                self.log.solved();
            }
            return result;
        }
        if self.work.as_ref().is_some_and(|work| self.is_settling_due(work)) {
            self.settle(events);
            // What cannot be flattened is not tried again and again.
            if let Some(work) = &mut self.work {
                work.is_settled = true;
            }
            self.log.laid_out();
            return Ok(());
        }
        let Some(work) = &mut self.work else { return Ok(()) };
        match std::mem::take(&mut work.cones.wanted) {
            Wanted::Path => {
                work.cones.begin_path();
                events.push(work.cones.path_event());
                return Ok(());
            }
            Wanted::Comparison => {
                work.compare()?;
                events.push(Event::ConeComparison { rows: work.cones.comparison.clone() });
                return Ok(());
            }
            Wanted::Nothing => {}
        }
        let name = work.document.name.clone();
        match work.cones.trace() {
            Ok(is_news) => {
                if is_news {
                    events.push(work.cones.path_event());
                }
                // A path that begins at the largest λ has made that known.
                if work.cones.tracing.is_none() {
                    events.extend(self.cones_event());
                }
                Ok(())
            }
            Err(error) => {
                work.cones.abandon_path();
                events.push(work.cones.path_event());
                Err(Problem::solve(&name, &error))
            }
        }
    }

    fn cones_round(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        let shown = work.cones.pictures;
        let (document, settings, layers) = (&work.document, &work.settings, &work.layers);
        let had_path = work.cones.has_path();
        let result = work.cones.round(document, settings, layers);
        if had_path && !work.cones.has_path() {
            events.push(work.cones.path_event());
        }
        match result {
            Ok(is_over) => self.is_running &= !is_over,
            Err(problem) => {
                // The cones before stay; they are not those that were asked for.
                work.cones.is_held = true;
                self.is_running = false;
                return Err(problem);
            }
        }
        if self.work.as_ref().is_some_and(|work| work.cones.pictures != shown) {
            self.after_cones_changed(events);
        }
        Ok(())
    }

    /// One round by hand.
    pub(in super::super) fn cones_step(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.document.surface()?;
        if work.cones.is_stale {
            let shown = work.cones.pictures;
            self.cones_round(events)?;
            let work = self.cones_at_work()?;
            if work.cones.pictures == shown {
                // Whoever steps wants to see every round.
                let (document, settings) = (work.document.clone(), work.settings.clone());
                work.cones.use_cones(document.surface()?, &settings)?;
                self.after_cones_changed(events);
            }
        }
        self.cones_pause();
        self.is_running = false;
        self.unmark(events);
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    pub(in super::super) fn cones_run(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.document.surface()?;
        work.cones.is_held = false;
        self.is_running = work.cones.is_stale;
        self.unmark(events);
        events.push(self.status());
        Ok(())
    }

    pub(in super::super) fn cones_pause(&mut self) {
        if let Some(work) = self.work.as_mut().filter(|work| work.method == Method::Cones) {
            work.cones.is_held = true;
            work.cones.wanted = Wanted::Nothing;
            work.cones.abandon_path();
        }
    }

    /// Back to a surface without cones.
    pub(in super::super) fn cones_reset(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.document.surface()?;
        self.remember("reset", "reset");
        let Some(work) = &mut self.work else { return Ok(()) };
        work.cones.begin_again();
        work.layout = None;
        work.is_settled = false;
        self.scene_is_new = true;
        events.push(work.cones.path_event());
        events.push(work.measures());
        events.extend(self.cones_event());
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// The status line while cones are at work.
    pub(in super::super) fn cones_status(&self, work: &Work) -> (&'static str, String) {
        let cones = &work.cones;
        let rounds = cones.rounds;
        if cones.is_due() {
            return ("running", format!("Running step {}", rounds + 1));
        }
        if cones.tracing.is_some() || cones.wanted == Wanted::Path {
            let count = cones.path.len();
            return ("running", format!("Running step {count}: tracing the path over λ"));
        }
        if cones.wanted == Wanted::Comparison {
            return ("running", format!("Running step {rounds}: comparing with greedy cones"));
        }
        match cones.status() {
            _ if !cones.is_solved() => ("ready", "Ready".into()),
            _ if !cones.is_stale && self.is_settling_due(work) => {
                ("running", format!("Running step {rounds}: making charts"))
            }
            _ if cones.is_stale => ("paused", format!("Paused at step {rounds}")),
            _ if cones.is_placed() => {
                ("converged", format!("Converged after {}", plural(rounds, "step")))
            }
            Some(Status::Infeasible) => (
                "stalled",
                format!("Converged after {}: the target cannot be reached", plural(rounds, "step")),
            ),
            Some(Status::Stalled) => {
                ("stalled", format!("Paused at step {rounds}: rounding ends progress"))
            }
            _ => ("converged", format!("Converged after {}", plural(rounds, "step"))),
        }
    }

    /// Merging, refitting or seams are wanted another way.
    pub(in super::super) fn use_cones_anew(&mut self) {
        if let Some(work) = self.work.as_mut().filter(|work| work.method == Method::Cones) {
            // The solution is there: this takes one look at it.
            work.cones.ask_again();
            self.is_running = true;
        }
    }

    /// Brings the cones up to what was painted.
    pub(in super::super) fn cones_catch_up(&mut self) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        work.tell_flow_aside()?;
        let fields = work.cone_fields()?;
        work.is_settled = false;
        if work.cones.is_for(&fields) {
            // Only seams are concerned.
            self.scene_is_new = true;
        } else {
            self.cones_are_due();
        }
        Ok(())
    }

    /// Tells of cones that have changed; their charts follow when there is time.
    pub(super) fn after_cones_changed(&mut self, events: &mut Vec<Event>) {
        let Some(work) = &mut self.work else { return };
        work.is_settled = false;
        work.follow_target();
        self.scene_is_new = true;
        if work.settings.text("choose_by") != "lambda" {
            events.push(self.parameters());
        }
        events.extend(self.cones_event());
        // Undo brings back what they were compared with; it is shown beside the cones that it belongs to.
        if let Some(work) = self.work.as_ref().filter(|work| !work.cones.comparison.is_empty()) {
            events.push(Event::ConeComparison { rows: work.cones.comparison.clone() });
        }
    }

    /// The problem has changed: solve when there is time.
    pub(in super::super) fn cones_are_due(&mut self) {
        let Some(work) = self.work.as_mut().filter(|work| work.method == Method::Cones) else {
            return;
        };
        work.cones.edits.has_dropped |= work.cones.edits.changed.take().is_some();
        work.cones.ask_again();
        self.is_running = true;
    }

    pub(in super::super) fn trace_path(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.want(Wanted::Path, events)
    }

    pub(in super::super) fn compare_cones(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let work = self.cones_at_work()?;
        let count = work.cones.set.as_ref().map_or(0, |set| set.cones.len());
        if count > MOST_COMPARED {
            return Err(Problem::new(
                format!("{count} cones are too many to compare."),
                "Compare with greedy.",
                format!("Raise λ or merge clusters until there are at most {MOST_COMPARED}."),
            ));
        }
        self.want(Wanted::Comparison, events)
    }

    fn want(&mut self, wanted: Wanted, events: &mut Vec<Event>) -> Result<(), Problem> {
        let work = self.cones_at_work()?;
        work.cones.abandon_path();
        work.cones.wanted = wanted;
        // Either needs a solution first.
        work.cones.is_stale |= !work.cones.is_solved();
        work.cones.is_held = false;
        events.push(self.status());
        Ok(())
    }

    /// The work, where cones are at work on a surface.
    pub(super) fn cones_at_work(&mut self) -> Result<&mut Work, Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.document.surface()?;
        if work.method == Method::Cones {
            Ok(work)
        } else {
            Err(Problem::new(
                "Another method is at work.",
                "Cones.",
                "Choose the method Cones first.",
            ))
        }
    }

    /// Solves to the end.
    pub(in super::super) fn settled_cones(&mut self) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.cones.abandon_path();
        work.cones.is_stale |= !work.cones.is_solved();
        let mut events = Vec::new();
        while self.work.as_ref().is_some_and(|work| work.cones.is_stale) {
            self.cones_round(&mut events)?;
        }
        self.late.extend(events);
        self.is_running = false;
        Ok(())
    }
}

impl Work {
    /// λ as it was found for another target.
    fn follow_target(&mut self) {
        if let Some(flow) = self.cones.flow()
            && !["lambda", "exactly"].contains(&self.settings.text("choose_by"))
            && flow.status() != Status::Running
        {
            let [least, most] = PRICES;
            let lambda = flow.state().lambda.clamp(least, most);
            self.settings.put("lambda", Value::Number(lambda));
        }
    }

    /// The greedy strategy with as many cones beside those that are used, and these with their angles refitted; charts included.
    fn compare(&mut self) -> Result<(), Problem> {
        let document = self.document.clone();
        let surface = document.surface()?;
        let wrong = |error| Problem::solve(&document.name, &error);
        let cost = self.seam_cost();
        let charting = Charting::of(&self.settings);
        let charts = |set: &ConeSet| {
            Layout::of_cones(surface, set, &cost, &charting, None)
                .map_err(|error| error.problem(&document.name))
        };
        let Some(set) = &self.cones.set else { return Err(nothing_open()) };
        let label = match self.cones.edits.changed {
            Some(_) => "By hand",
            None if self.cones.is_placed() => "Best places",
            None => "Optimal",
        };
        let mut rows = vec![measures::row(label.into(), set)];
        let (count, used) = (set.count(), set.cones.clone());
        let mut layouts = vec![charts(set)?];
        if count > 0 {
            let greedy = measures::greedy(surface, count).map_err(wrong)?;
            rows.push(measures::row("Greedy".into(), &greedy));
            layouts.push(charts(&greedy)?);
        }
        // Best places have their best angles.
        if count > 0
            && !self.cones.is_placed()
            && let Some(flow) = self.cones.flow_mut()
        {
            // Greedy cones take whatever angle is best where they are: so may these.
            let fitted = measures::refitted(flow, used).map_err(wrong)?;
            rows.push(measures::row("Refitted".into(), &fitted));
            layouts.push(charts(&fitted)?);
        }
        for (row, layout) in rows.iter_mut().zip(&layouts) {
            let totals = &layout.measures.totals;
            row.chart_angle = Some(totals.angle_distortion).filter(|x| x.is_finite());
            row.chart_area = Some(totals.area_distortion).filter(|x| x.is_finite());
        }
        self.cones.comparison = rows;
        Ok(())
    }

    /// What seams cost at each vertex beyond their length.
    pub(in super::super) fn seam_cost(&self) -> Vec<f64> {
        let factor = self.settings.number("seam_hiding");
        self.layers.penalty.iter().map(|p| factor * p).collect()
    }
}
