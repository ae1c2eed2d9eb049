//! What a person can do with cones, and what is told of them.

use std::f64::consts::PI;

use super::super::inputs::Layers;
use super::super::layout::Layout;
use super::super::message::Event;
use super::super::method::Method;
use super::super::paint::Dab;
use super::super::text::{Problem, plural};
use super::super::work::{Pending, Work};
use super::super::{Session, nothing_open};
use super::edits::{Edits, Placed, edit_problem, no_such_cone};
use super::table::{ConeRow, ConeTable};
use super::{ConeKind, ConeSet, UsedCone, measures, place_of, problem};
use crate::mesh::VertexId;
use crate::methods::cones::{Cone, ConeEdit, PlacedCone, debias, edit_cones};
use crate::methods::flow::{Flow, Status};

/// ∫u² may change by this fraction before merging is worth a word.
const WORTH_A_WORD: f64 = 0.01;

impl Session {
    /// Whether the cones are at work and there is something to do for them.
    pub(in super::super) fn cones_have_work(&self) -> bool {
        self.work.as_ref().is_some_and(|work| {
            work.method == Method::Cones
                && work.document.surface.is_some()
                && (work.cones.is_due
                    || work.cones.tracing.is_some()
                    || (work.cones.is_solved() && !work.is_settled))
        })
    }

    /// One bounded piece of that.
    pub(in super::super) fn cones_advance(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        if work.cones.is_due {
            return self.cones_round(events);
        }
        if !work.is_settled {
            self.settle(events);
            // What cannot be flattened is not tried again and again.
            if let Some(work) = &mut self.work {
                work.is_settled = true;
            }
            return Ok(());
        }
        let name = work.document.name.clone();
        if work.cones.trace().map_err(|error| Problem::solve(&name, &error))? {
            events.push(work.cones.path_event());
        }
        Ok(())
    }

    fn cones_round(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        let (document, settings, layers) = (&work.document, &work.settings, &work.layers);
        match work.cones.round(document, settings, layers) {
            Ok(false) => {}
            Ok(true) => {
                work.cones.is_due = false;
                self.is_running = false;
            }
            Err(problem) => {
                work.cones.is_due = false;
                return Err(problem);
            }
        }
        self.after_cones_changed(events);
        Ok(())
    }

    /// One round by hand.
    pub(in super::super) fn cones_step(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        self.cones_round(events)?;
        if let Some(work) = &mut self.work {
            work.cones.is_due = false;
        }
        self.is_running = false;
        Ok(())
    }

    pub(in super::super) fn cones_run(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.document.surface()?;
        let is_at_end = work.cones.is_solved()
            && work.cones.status().is_some_and(|status| status != Status::Running);
        work.cones.is_due |= !is_at_end;
        self.is_running = !is_at_end;
        self.unmark(events);
        events.push(self.status());
        Ok(())
    }

    pub(in super::super) fn cones_pause(&mut self) {
        if let Some(work) = &mut self.work {
            work.cones.is_due = false;
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
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    /// The status line while cones are at work.
    pub(in super::super) fn cones_status(&self, work: &Work) -> (&'static str, String) {
        let cones = &work.cones;
        let rounds = cones.rounds;
        if cones.is_due {
            return ("running", format!("Running step {}", rounds + 1));
        }
        if cones.tracing.is_some() {
            return (
                "running",
                format!("Running step {}: tracing the path over λ", cones.path.len()),
            );
        }
        match cones.status() {
            _ if !cones.is_solved() => ("ready", "Ready".into()),
            Some(Status::Running) => ("paused", format!("Paused at step {rounds}")),
            Some(Status::Converged) => ("converged", format!("Converged after {rounds} steps")),
            Some(Status::Infeasible) => {
                ("stalled", format!("Converged after {rounds} steps: the target cannot be reached"))
            }
            _ => ("stalled", format!("Paused at step {rounds}: no more progress")),
        }
    }

    /// Merging, refitting or seams are wanted another way.
    pub(in super::super) fn use_cones_anew(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        if work.method != Method::Cones || !work.cones.is_solved() {
            return Ok(());
        }
        let (document, settings) = (work.document.clone(), work.settings.clone());
        work.cones.use_cones(&document, &settings)?;
        self.after_cones_changed(events);
        Ok(())
    }

    /// Brings the cones up to what was painted.
    pub(in super::super) fn cones_catch_up(&mut self) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Ok(()) };
        work.pending = Pending::None;
        let fields = problem::fields(
            &work.settings,
            &work.layers,
            &work.cones.edits,
            work.document.surface()?,
        );
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
    fn after_cones_changed(&mut self, events: &mut Vec<Event>) {
        let Some(work) = &mut self.work else { return };
        work.is_settled = false;
        work.follow_target();
        self.scene_is_new = true;
        if work.settings.text("choose_by") != "lambda" {
            events.push(self.parameters());
        }
        events.extend(self.cones_event());
    }

    /// The parameters have changed: solve when there is time.
    pub(in super::super) fn cones_are_due(&mut self) {
        let Some(work) = &mut self.work else { return };
        if work.method != Method::Cones {
            return;
        }
        work.cones.has_dropped = work.cones.edits.changed.take().is_some();
        work.cones.comparison.clear();
        work.cones.is_due = true;
        self.is_running = true;
    }

    /// Other cones by hand.
    pub(super) fn change_cones(
        &mut self,
        label: &str,
        change: impl FnOnce(&mut Work) -> Result<Edits, Problem>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.document.surface()?;
        let edits = change(work)?;
        // Try before anything changes.
        let is_optimum = edits.changed.is_none();
        self.remember(label, label);
        let Some(work) = &mut self.work else { return Ok(()) };
        let needs_solution = is_optimum || edits.placed != work.cones.edits.placed;
        work.cones.edits = edits;
        work.cones.has_dropped = false;
        work.cones.comparison.clear();
        if needs_solution {
            work.cones.is_due = true;
            self.is_running = true;
        } else {
            let (document, settings) = (work.document.clone(), work.settings.clone());
            work.cones.use_cones(&document, &settings)?;
            self.after_cones_changed(events);
        }
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }

    pub(in super::super) fn add_cone(
        &mut self,
        face: u32,
        place: [f64; 3],
        angle: Option<f64>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let add = |work: &mut Work| {
            let vertex = work.vertex_near(face, place)?;
            let mut edits = work.cones.edits.clone();
            match &mut edits.changed {
                None => match edits.placed_at(vertex) {
                    Some(i) => edits.placed[i].angle = angle,
                    None => edits.placed.push(Placed { vertex, angle }),
                },
                Some(changed) => {
                    let kind = if angle.is_some() { ConeKind::Fixed } else { ConeKind::Free };
                    *changed =
                        work.edited(changed, vertex, kind, ConeEdit::Add { vertex, angle })?;
                    if angle.is_none() {
                        work.refit(changed)?;
                    }
                }
            }
            Ok(edits)
        };
        self.change_cones("add a cone", add, events)
    }

    pub(in super::super) fn move_cone(
        &mut self,
        cone: usize,
        face: u32,
        place: [f64; 3],
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let shift = |work: &mut Work| {
            let vertex = work.vertex_near(face, place)?;
            let from = work.cone(cone)?.cone.vertex;
            let mut edits = work.cones.edits.clone();
            if let (None, Some(i)) = (&edits.changed, edits.placed_at(from)) {
                edits.placed[i].vertex = vertex;
                return Ok(edits);
            }
            let now = work.used_cones();
            let kind = match now[cone].kind {
                ConeKind::Optimal | ConeKind::Merged => ConeKind::Moved,
                kind => kind,
            };
            let edit = ConeEdit::Move { from, to: vertex };
            edits.changed = Some(work.edited(&now, vertex, kind, edit)?);
            Ok(edits)
        };
        self.change_cones("move a cone", shift, events)
    }

    pub(in super::super) fn set_cone_angle(
        &mut self,
        cone: usize,
        angle: Option<f64>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let turn = |work: &mut Work| {
            let vertex = work.cone(cone)?.cone.vertex;
            let mut edits = work.cones.edits.clone();
            if let (None, Some(i)) = (&edits.changed, edits.placed_at(vertex)) {
                edits.placed[i].angle = angle;
                return Ok(edits);
            }
            let mut now = work.used_cones();
            match angle {
                Some(angle) => {
                    let edit = ConeEdit::SetAngle { vertex, angle };
                    now = work.edited(&now, vertex, ConeKind::Fixed, edit)?;
                }
                None => {
                    now[cone].kind = ConeKind::Free;
                    work.refit(&mut now)?;
                }
            }
            edits.changed = Some(now);
            Ok(edits)
        };
        self.change_cones("change a cone's angle", turn, events)
    }

    pub(in super::super) fn remove_cone(
        &mut self,
        cone: usize,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let remove = |work: &mut Work| {
            let vertex = work.cone(cone)?.cone.vertex;
            let mut edits = work.cones.edits.clone();
            if let (None, Some(i)) = (&edits.changed, edits.placed_at(vertex)) {
                edits.placed.remove(i);
                return Ok(edits);
            }
            let now = work.used_cones();
            let edit = ConeEdit::Remove { vertex };
            edits.changed = Some(work.edited(&now, vertex, ConeKind::Fixed, edit)?);
            Ok(edits)
        };
        self.change_cones("remove a cone", remove, events)
    }

    pub(in super::super) fn clear_cones(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        if self.work.as_ref().is_some_and(|work| work.cones.edits.is_empty()) {
            return Ok(());
        }
        self.change_cones("drop changes by hand", |_| Ok(Edits::default()), events)
    }

    pub(in super::super) fn trace_path(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let (document, settings, layers) = (&work.document, &work.settings, &work.layers);
        work.cones.prepare(document, settings, layers)?;
        work.cones.begin_path();
        events.push(work.cones.path_event());
        events.push(self.status());
        Ok(())
    }

    pub(in super::super) fn compare_cones(
        &mut self,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        self.settled_cones()?;
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.compare()?;
        events.push(Event::ConeComparison { rows: work.cones.comparison.clone() });
        Ok(())
    }

    /// The whole table, while cones are at work.
    pub(in super::super) fn cones_event(&self) -> Option<Event> {
        let work = self.work.as_ref().filter(|work| work.method == Method::Cones)?;
        work.cone_table().map(Event::Cones)
    }

    /// Solves and flattens to the end.
    pub(in super::super) fn settled_cones(&mut self) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let (document, layers) = (work.document.clone(), work.layers.clone());
        while work.cones.is_due || !work.cones.is_solved() {
            let settings = work.settings.clone();
            work.cones.is_due = !work.cones.round(&document, &settings, &layers)?;
            work.follow_target();
            work.is_settled = false;
        }
        self.is_running = false;
        Ok(())
    }
}

impl Work {
    /// λ as it was found for another target.
    fn follow_target(&mut self) {
        if let Some(flow) = self.cones.flow()
            && self.settings.text("choose_by") != "lambda"
            && flow.status() != Status::Running
        {
            self.settings.put("lambda", super::super::message::Value::Number(flow.state().lambda));
        }
    }

    /// The vertex of the mesh next to a place of the scene.
    fn vertex_near(&self, face: u32, place: [f64; 3]) -> Result<VertexId, Problem> {
        let surface = self.document.surface()?;
        Ok(Dab::new(surface, face, place, 1.0)?.nearest(surface))
    }

    fn used_cones(&self) -> Vec<UsedCone> {
        self.cones.set.as_ref().map_or_else(Vec::new, |set| set.cones.clone())
    }

    fn cone(&self, cone: usize) -> Result<UsedCone, Problem> {
        let cones = self.used_cones();
        cones.get(cone).cloned().ok_or_else(|| no_such_cone(cone, cones.len()))
    }

    /// What a person should know of the cones.
    pub(in super::super) fn cones_note(&self) -> Option<String> {
        let flow = self.cones.flow()?;
        let set = self.cones.set.as_ref()?;
        let state = flow.state();
        let mut notes: Vec<String> = Vec::new();
        if self.cones.has_dropped {
            let text = "These cones are the optimum again; Undo brings the changes by hand back.";
            notes.push(text.into());
        }
        if state.is_convex {
            notes.push(
                "The surface is convex everywhere: the optimum is its own curvature at every vertex, whatever the cost. \
                 Limit the angles, exclude places, or add cones by hand and refit their angles."
                    .into(),
            );
        } else if state.cones.is_empty() && flow.status() == Status::Converged {
            let most = flow.lambda_max();
            notes.push(if most > 0.0 {
                format!("No cones at this cost: the first appears below λ = {most:.4}.")
            } else {
                "The surface is flat already: it needs no cones.".into()
            });
        }
        if flow.status() == Status::Infeasible {
            notes.push(format!(
                "There is no optimum like that: these {} of total angle {:.3} π are as near as it gets.",
                plural(set.cones.len(), "cone"),
                set.total_angle / PI
            ));
        }
        if self.cones.edits.changed.is_none()
            && set.cones.len() < state.cones.len()
            && set.change.is_some()
            && !self.settings.is_on("debias")
        {
            let change = set.int_u2 / state.int_u2.max(f64::MIN_POSITIVE) - 1.0;
            if change.abs() > WORTH_A_WORD {
                notes.push(format!(
                    "Merging {} to {} changes ∫u² by {:+.1} %.",
                    plural(state.cones.len(), "vertex"),
                    plural(set.cones.len(), "cone"),
                    100.0 * change
                ));
            }
        }
        (!notes.is_empty()).then(|| notes.join(" "))
    }

    fn cone_table(&self) -> Option<ConeTable> {
        let surface = self.document.surface.as_ref()?;
        let flow = self.cones.flow()?;
        let state = flow.state();
        let set = self.cones.set.as_ref()?;
        let partners = self.partners(set);
        let row = |(cone, used): (usize, &UsedCone)| ConeRow {
            cone,
            vertex: surface.soup_vertices[used.cone.vertex.index()],
            place: place_of(surface, &used.cone),
            angle: used.cone.angle,
            kind: match used.kind {
                ConeKind::Optimal => "optimal",
                ConeKind::Merged => "merged",
                ConeKind::Free => "free",
                ConeKind::Moved => "moved",
                ConeKind::Fixed => "fixed",
            },
            members: used.members,
            partner: partners[cone],
        };
        Some(ConeTable {
            lambda: state.lambda,
            lambda_max: flow.lambda_max(),
            is_edited: !self.cones.edits.is_empty(),
            raw_count: state.cones.len(),
            raw_int_u2: state.int_u2,
            int_u2: set.int_u2,
            total_angle: set.total_angle,
            kkt_residual: state.residual,
            gap: state.gap,
            cones: set.cones.iter().enumerate().map(row).collect(),
            note: self.cones_note(),
        })
    }

    /// For each cone the other one that a mirror plane that was found maps it to.
    fn partners(&self, set: &ConeSet) -> Vec<Option<usize>> {
        let mut partners = vec![None; set.cones.len()];
        let (Some(symmetries), Some(surface)) = (&self.symmetries, &self.document.surface) else {
            return partners;
        };
        let Some(mirror) = symmetries.first() else { return partners };
        let place = |used: &UsedCone| surface.geometry.positions[used.cone.vertex.index()];
        // Two edges of the mesh: clusters are merged on either side on their own.
        let near = 2.0 * surface.geometry.mean_edge_length();
        for (i, used) in set.cones.iter().enumerate() {
            let image = mirror.image(place(used));
            let distance = |j: &usize| (place(&set.cones[*j]) - image).norm();
            partners[i] = (0..set.cones.len())
                .filter(|&j| j != i)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .filter(|j| distance(j) < near);
        }
        partners
    }

    /// The greedy strategy with as many cones beside those that are used, charts included.
    fn compare(&mut self) -> Result<(), Problem> {
        let document = self.document.clone();
        let surface = document.surface()?;
        let wrong = |error| Problem::solve(&document.name, &error);
        let cost = self.seam_cost();
        let Some(set) = &self.cones.set else { return Err(nothing_open()) };
        let mut rows = vec![measures::row("Optimal cones".into(), set)];
        let count = set.cones.len();
        let mut layouts = vec![Layout::of_cones(surface, set, &cost, None).map_err(wrong)?];
        if count > 0 {
            let greedy = measures::greedy(surface, count).map_err(wrong)?;
            rows.push(measures::row("Greedy, as many cones".into(), &greedy));
            layouts.push(Layout::of_cones(surface, &greedy, &cost, None).map_err(wrong)?);
        }
        for (row, layout) in rows.iter_mut().zip(&layouts) {
            let totals = &layout.measures.totals;
            row.chart_angle = Some(totals.angle_distortion).filter(|x| x.is_finite());
            row.chart_area = Some(totals.area_distortion).filter(|x| x.is_finite());
        }
        self.cones.comparison = rows;
        Ok(())
    }

    /// All cones after one was changed by hand; those that were not fixed make up for it.
    ///
    /// **Takes** the vertex of the changed cone, and how it came about from then on.
    fn edited(
        &self,
        now: &[UsedCone],
        vertex: VertexId,
        kind: ConeKind,
        edit: ConeEdit,
    ) -> Result<Vec<UsedCone>, Problem> {
        let surface = self.document.surface()?;
        let placed = |used: &UsedCone| PlacedCone {
            cone: used.cone,
            is_fixed: used.kind == ConeKind::Fixed,
        };
        let before: Vec<PlacedCone> = now.iter().map(placed).collect();
        let after = edit_cones(&surface.mesh, &before, edit)
            .map_err(|error| edit_problem(surface, &error))?;
        let used = |placed: PlacedCone| {
            let old = now.iter().find(|used| used.cone.vertex == placed.cone.vertex);
            match old.filter(|_| placed.cone.vertex != vertex) {
                Some(old) => UsedCone { cone: placed.cone, ..old.clone() },
                None => UsedCone { cone: placed.cone, kind, members: 1 },
            }
        };
        Ok(after.into_iter().map(used).collect())
    }

    /// Gives cones that were not fixed by hand the angles that distort least.
    fn refit(&mut self, now: &mut [UsedCone]) -> Result<(), Problem> {
        let name = self.document.name.clone();
        let Some(flow) = self.cones.flow_mut() else { return Err(nothing_open()) };
        let cones: Vec<Cone> = now.iter().map(|used| used.cone).collect();
        let is_held = |used: &&UsedCone| used.kind == ConeKind::Fixed;
        let held: Vec<VertexId> = now.iter().filter(is_held).map(|used| used.cone.vertex).collect();
        let fitted = debias(flow, &cones, &held).map_err(|error| Problem::solve(&name, &error))?;
        now.iter_mut().zip(fitted).for_each(|(used, cone)| used.cone = cone);
        Ok(())
    }

    /// Finds out whether there is a flattening with these cones.
    pub(super) fn try_cones(&mut self, cones: &[UsedCone]) -> Result<(), Problem> {
        let (document, settings, layers) =
            (self.document.clone(), self.settings.clone(), self.layers.clone());
        let flow = self.cones.prepare(&document, &settings, &layers)?;
        let cones: Vec<Cone> = cones.iter().map(|used| used.cone).collect();
        flow.evaluate(&cones).map_err(|error| Problem::solve(&document.name, &error))?;
        Ok(())
    }

    /// What seams cost at each vertex beyond their length.
    pub(in super::super) fn seam_cost(&self) -> Vec<f64> {
        let factor = self.settings.number("seam_hiding");
        let Layers { penalty, .. } = &self.layers;
        penalty.iter().map(|p| factor * p).collect()
    }
}
