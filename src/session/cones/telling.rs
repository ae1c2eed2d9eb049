//! What is told of cones: the table, and what a person should know.

use std::f64::consts::PI;

use super::super::Session;
use super::super::message::Event;
use super::super::method::Method;
use super::super::text::plural;
use super::super::work::Work;
use super::table::{ConeRow, ConeTable};
use super::{ConeKind, ConeSet, UsedCone, place_of};
use crate::geometry::SymmetryKind;
use crate::methods::flow::Status;

/// Relative change of u by merging from which there is something to do about it.
const MUCH: f64 = 0.25;

impl Session {
    /// The whole table, while cones are at work.
    pub(in super::super) fn cones_event(&self) -> Option<Event> {
        let work = self.work.as_ref().filter(|work| work.method == Method::Cones)?;
        work.cone_table().map(Event::Cones)
    }
}

impl Work {
    /// What a person should know of the cones.
    pub(in super::super) fn cones_note(&self) -> Option<String> {
        let flow = self.cones.flow()?;
        let set = self.cones.set.as_ref()?;
        let state = self.cones.optimum.as_ref()?;
        let is_over = !self.cones.is_stale;
        let mut notes: Vec<String> = Vec::new();
        if self.cones.edits.has_dropped {
            let text = "These cones are the optimum again; Undo brings the changes by hand back.";
            notes.push(text.into());
        }
        if self.cones.is_placed() {
            if set.count() > 0 {
                notes.push(format!(
                    "{} where local search found them to distort least: ∫u² is {:.4} at a total angle of {:.3} π. Other places may be better still.",
                    plural(set.count(), "cone"),
                    set.int_u2,
                    set.total_angle / PI
                ));
            }
            let wanted = self.settings.number("exact_count");
            if (set.count() as f64) < wanted {
                notes.push(format!("Less than {wanted}: more would not lower the distortion."));
            }
        } else if state.is_convex {
            notes.push(
                "The surface is convex everywhere: the optimum is its own curvature at every vertex, whatever the cost. \
                 Paint No cones over all but the places where cones may be: the curvature is then gathered there."
                    .into(),
            );
        } else if state.cones.is_empty() && set.cones.is_empty() && is_over {
            let most = flow.lambda_max();
            notes.push(if most > 0.0 {
                format!("No cones at this cost: the first appears below λ = {most:.4}.")
            } else {
                "The surface is flat already: it needs no cones.".into()
            });
        }
        if is_over && flow.status() == Status::Infeasible {
            notes.push(format!(
                "There is no optimum like that: these {} of total angle {:.3} π are as near as it gets.",
                plural(set.cones.len(), "cone"),
                set.total_angle / PI
            ));
        }
        if self.cones.edits.changed.is_none()
            && let Some(change) = set.change
        {
            let merged = format!(
                "{} merged to {}",
                plural(state.cones.len(), "vertex"),
                plural(set.count(), "cone")
            );
            let what = match (set.count() < state.cones.len(), self.settings.is_on("debias")) {
                (true, true) => format!("{merged}, angles refitted"),
                (true, false) => merged,
                (false, _) => "Angles refitted".into(),
            };
            let angles = match (set.total_angle - state.total_angle).abs() > 1e-6 {
                true => format!(
                    ", the total angle {:.3} π where it has {:.3} π",
                    set.total_angle / PI,
                    state.total_angle / PI
                ),
                false => String::new(),
            };
            let advice = match change > MUCH && !self.settings.is_on("debias") {
                true => " That is much: refit the angles, or leave the clusters as they are.",
                false => "",
            };
            // Where the optimum leaves nothing there is nothing to compare with.
            let differs = match change.is_finite() {
                true => format!("; u differs by {:.1} % (root mean square)", 100.0 * change),
                false => String::new(),
            };
            notes.push(format!(
                "{what}: ∫u² is {:.4} where the optimum has {:.4}{angles}{differs}.{advice}",
                set.int_u2, state.int_u2,
            ));
        }
        if let Some(changed) = &self.cones.edits.changed {
            let has_free = changed.iter().any(|used| used.kind == ConeKind::Free);
            let fitted = match has_free {
                true => {
                    " With the free ones, all angles that are not fixed were fitted to distort least."
                }
                false => "",
            };
            notes.push(format!(
                "Changed by hand: ∫u² is {:.4} where the optimum for this λ has {:.4}.{fitted}",
                set.int_u2, state.int_u2
            ));
        }
        (!notes.is_empty()).then(|| notes.join(" "))
    }

    fn cone_table(&self) -> Option<ConeTable> {
        let surface = self.document.surface.as_ref()?;
        let (Some(flow), Some(state), Some(set)) =
            (self.cones.flow(), &self.cones.optimum, &self.cones.set)
        else {
            // After a reset: none are there.
            let lambda = self.settings.number("lambda");
            return Some(ConeTable { lambda, ..ConeTable::default() });
        };
        let partners = self.partners(set);
        let row = |(cone, used): (usize, &UsedCone)| ConeRow {
            cone,
            vertex: surface.soup_vertices[used.cone.vertex.index()],
            place: place_of(surface, &used.cone),
            angle: used.cone.angle,
            kind: match used.kind {
                ConeKind::Optimal => "optimal",
                ConeKind::Merged => "merged",
                ConeKind::Placed => "placed",
                ConeKind::Free => "free",
                ConeKind::Moved => "moved",
                ConeKind::Corner => "corner",
                ConeKind::Fixed => "fixed",
            },
            members: used.members,
            partner: partners[cone],
        };
        Some(ConeTable {
            lambda: state.lambda,
            lambda_max: flow.lambda_max(),
            is_lambda_max_exact: flow.knows_lambda_max(),
            is_edited: self.cones.edits.changed.is_some(),
            is_placed: self.cones.is_placed(),
            has_placed: !self.cones.edits.placed.is_empty(),
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
        let mirror = symmetries.iter().find(|symmetry| symmetry.kind == SymmetryKind::Mirror);
        let Some(mirror) = mirror else { return partners };
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
}
