//! Cones by hand: added, moved, turned, removed. A change is tried before it is made.

use super::super::message::Event;
use super::super::paint::Dab;
use super::super::text::Problem;
use super::super::work::Work;
use super::super::{Session, nothing_open};
use super::edits::{Edits, Placed, cone_problem, edit_problem, no_such_cone};
use super::{ConeKind, UsedCone, measures, problem};
use crate::mesh::VertexId;
use crate::methods::cones::{Cone, ConeEdit, ConeFields, PlacedCone, debias, edit_cones};

impl Session {
    /// Other cones by hand, tried before anything changes.
    pub(super) fn change_cones(
        &mut self,
        label: &str,
        change: impl FnOnce(&mut Work) -> Result<Edits, Problem>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let work = self.cones_at_work()?;
        let document = work.document.clone();
        let surface = document.surface()?;
        work.cones.abandon_path();
        let edits = change(work)?;
        let set = match &edits.changed {
            // Only the result changes: its scale factors are one solve away.
            Some(changed) => {
                let (settings, layers) = (work.settings.clone(), work.layers.clone());
                let flow = work.cones.prepare(&document, &settings, &layers)?;
                let set = measures::evaluated(flow, changed.clone());
                Some(set.map_err(|error| cone_problem(surface, &error))?)
            }
            None => {
                if work.cones.flow().is_none() {
                    // Nothing was solved yet. Where there can be no solver at all, the solution says why.
                    let (settings, layers) = (work.settings.clone(), work.layers.clone());
                    let _ = work.cones.prepare(&document, &settings, &layers);
                }
                let fields = problem::fields(&work.settings, &work.layers, &edits, surface);
                work.cones.try_fields(surface, &fields)?;
                None
            }
        };
        self.remember(label, label);
        let work = self.cones_at_work()?;
        work.cones.edits = Edits { has_dropped: false, ..edits };
        work.cones.comparison.clear();
        match set {
            Some(set) => {
                work.cones.put(set);
                let fields = &work.cone_fields()?;
                if !work.cones.is_for(fields) {
                    // The optimum beside them is that without what was placed before.
                    work.cones.ask_again();
                    self.is_running = true;
                }
                self.after_cones_changed(events);
            }
            None => {
                work.cones.ask_again();
                self.is_running = true;
            }
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
            work.with_cone(vertex, angle)
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
                let angle = edits.placed.remove(i).angle;
                edits.place(Placed { vertex, angle });
                return Ok(edits);
            }
            let now = work.used_cones();
            let kind = match now[cone].kind {
                ConeKind::Optimal | ConeKind::Merged | ConeKind::Placed => ConeKind::Moved,
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
}

impl Work {
    /// The vertex of the mesh next to a place of the scene.
    fn vertex_near(&self, face: u32, place: [f64; 3]) -> Result<VertexId, Problem> {
        let surface = self.document.surface()?;
        Ok(Dab::new(surface, face, place, 1.0)?.nearest(surface))
    }

    /// What the solver has to reckon with.
    pub(super) fn cone_fields(&self) -> Result<ConeFields, Problem> {
        let surface = self.document.surface()?;
        Ok(problem::fields(&self.settings, &self.layers, &self.cones.edits, surface))
    }

    fn used_cones(&self) -> Vec<UsedCone> {
        self.cones.set.as_ref().map_or_else(Vec::new, |set| set.cones.clone())
    }

    fn cone(&self, cone: usize) -> Result<UsedCone, Problem> {
        if self.cones.is_set_passed {
            return Err(Problem::new(
                "The cones after Undo are not there yet.",
                "In the change of a cone.",
                "Change it once they are solved; press Run if the solver waits.",
            ));
        }
        let cones = self.used_cones();
        cones.get(cone).cloned().ok_or_else(|| no_such_cone(cone, cones.len()))
    }

    /// The changes by hand with one cone more: a wish for the solver, or one of the cones that are used as they are.
    pub(super) fn with_cone(
        &mut self,
        vertex: VertexId,
        angle: Option<f64>,
    ) -> Result<Edits, Problem> {
        let mut edits = self.cones.edits.clone();
        match &mut edits.changed {
            None => edits.place(Placed { vertex, angle }),
            Some(changed) => {
                let kind = if angle.is_some() { ConeKind::Fixed } else { ConeKind::Free };
                *changed = self.edited(changed, vertex, kind, ConeEdit::Add { vertex, angle })?;
                if angle.is_none() {
                    self.refit(changed)?;
                }
            }
        }
        Ok(edits)
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
}
