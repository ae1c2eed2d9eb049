//! Symmetries of the surface: finding them, choosing some, keeping the cut symmetric, or developable patches.

use std::rc::Rc;
use std::sync::Arc;

use super::inputs::Layers;
use super::message::{Event, SymmetryChoice};
use super::method::Method;
use super::text::Problem;
use super::work::Work;
use super::{Session, nothing_open};
use nalgebra::Matrix3;

use crate::flatten::merging::maps_triangles;
use crate::geometry::{Symmetry, SymmetryKind, SymmetryMap, find_symmetries, symmetry_group};
use crate::mesh::VertexId;

/// Largest deviation that still counts as symmetric, as a fraction of the size: a model that was made by hand.
const TOLERANCE: f64 = 0.02;

/// Most elements of a group: all of the icosahedron.
const MOST: usize = 120;

/// The symmetries that the cut keeps.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// Their identifiers.
    pub ids: Vec<String>,
    /// The group that they make, without the identity.
    pub maps: Arc<Vec<SymmetryMap>>,
}

/// The symmetry that developable patches keep: a mirror plane or a half turn, by which triangles go to triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeptByPatches {
    /// Its identifier, if there is one.
    pub ids: Vec<String>,
    /// Where each vertex goes; empty without one.
    pub vertices: Vec<VertexId>,
}

impl Session {
    /// Looks for symmetries, once for each surface.
    pub(super) fn find_symmetries(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let surface = work.document.surface()?;
        if work.symmetries.is_none() {
            let found = find_symmetries(&surface.mesh, &surface.geometry, TOLERANCE);
            work.symmetries = Some(Rc::new(found));
        }
        events.push(self.symmetries());
        // Cones are told with their partners.
        events.extend(self.cones_event());
        Ok(())
    }

    /// What was found.
    pub fn symmetry_choices(&self) -> Vec<SymmetryChoice> {
        match self.symmetries() {
            Event::Symmetries { options, .. } => options,
            _ => Vec::new(),
        }
    }

    pub(super) fn symmetries(&self) -> Event {
        let found = self.work.as_ref().and_then(|work| work.symmetries.clone());
        let kept = self.work.as_ref().map_or(&[][..], Work::kept_symmetries);
        let method = self.method();
        let options = named(found.as_deref().map_or(&[], Vec::as_slice))
            .filter(|(.., symmetry)| is_of_use(method, symmetry))
            .map(|(id, label, symmetry)| SymmetryChoice {
                on: kept.contains(&id),
                deviation: symmetry.deviation,
                id,
                label,
            })
            .collect();
        let serves = match method {
            Method::CutFlow => "cut",
            Method::Cones => "pairs",
            Method::Developable => "patches",
            Method::PhaseField => "nothing",
        };
        Event::Symmetries { serves, is_searched: found.is_some(), options }
    }

    /// Keeps the cut symmetric from a new start on, or developable patches.
    pub(super) fn set_symmetry(
        &mut self,
        ids: &[String],
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        self.find_symmetries(events)?;
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        match work.method {
            Method::Developable => {
                let kept = work.kept_by_patches(ids)?;
                self.remember("change symmetry", "change symmetry");
                if let Some(work) = &mut self.work {
                    work.layers.patch_symmetry = Rc::new(kept);
                }
                self.segment_follow(events)?;
                events.push(self.history_event());
                events.push(self.status());
            }
            _ => {
                let kept = work.kept_by_cut(ids)?;
                let layers = Layers { symmetry: Rc::new(kept), ..work.layers.clone() };
                self.restart_with(layers, "change symmetry", events)?;
            }
        }
        events.push(self.symmetries());
        Ok(())
    }
}

impl Work {
    /// Identifiers of the symmetries that the method at work keeps.
    pub(super) fn kept_symmetries(&self) -> &[String] {
        match self.method {
            Method::Developable => &self.layers.patch_symmetry.ids,
            _ => &self.layers.symmetry.ids,
        }
    }

    /// The group that some symmetries make.
    fn group_of(&self, ids: &[String]) -> Result<Vec<SymmetryMap>, Problem> {
        let surface = self.document.surface()?;
        let found = self.symmetries.clone().unwrap_or_default();
        let mut chosen = Vec::new();
        for id in ids {
            let Some((.., symmetry)) = named(&found).find(|(known, ..)| known == id) else {
                let known = named(&found).filter(|(.., s)| is_of_use(self.method, s));
                let known: Vec<String> = known.map(|(id, ..)| id).collect();
                return Err(self.refused(
                    format!("The surface has no symmetry “{id}”."),
                    match known.is_empty() {
                        true => "None was found: run without.".to_owned(),
                        false => format!("Choose from {}.", known.join(", ")),
                    },
                ));
            };
            chosen.push(*symmetry);
        }
        if chosen.is_empty() {
            return Ok(Vec::new());
        }
        symmetry_group(&surface.mesh, &surface.geometry, &chosen, MOST).map_err(|error| {
            let what = format!("These symmetries do not go together: {error}.");
            self.refused(what, "Choose fewer of them.")
        })
    }

    fn kept_by_cut(&self, ids: &[String]) -> Result<Kept, Problem> {
        Ok(Kept { ids: ids.to_vec(), maps: Arc::new(self.group_of(ids)?) })
    }

    fn kept_by_patches(&self, ids: &[String]) -> Result<KeptByPatches, Problem> {
        if ids.len() > 1 {
            return Err(self.refused(
                "Developable patches keep one symmetry at a time.",
                "Choose one mirror plane, or one axis of even order.",
            ));
        }
        let group = self.group_of(ids)?;
        if group.is_empty() {
            return Ok(KeptByPatches::default());
        }
        let mesh = &self.document.surface()?.mesh;
        // Where the image is a vertex, one of the weights is 1.
        let nearest = |map: &SymmetryMap, v| {
            let (corners, weights) = map.image(v);
            corners[(0..3).max_by(|&i, &j| weights[i].total_cmp(&weights[j])).unwrap_or(0)]
        };
        let images = |map: &SymmetryMap| -> Vec<VertexId> {
            mesh.vertices().map(|v| nearest(map, v)).collect()
        };
        // Of a mirror plane itself, of an axis its half turn.
        let kept = group.iter().find(|map| is_own_inverse(&map.matrix));
        let Some(vertices) = kept.map(images) else {
            return Err(self.refused(
                "Developable patches keep mirror planes and half turns, and this axis has none.",
                "Choose a mirror plane, or an axis of even order.",
            ));
        };
        if !maps_triangles(mesh, &vertices) {
            return Err(self.refused(
                "The surface is symmetric, but its triangles are not: pieces are made of triangles.",
                "Choose a mesh whose triangles have images too, or join pieces and keep them apart by hand.",
            ));
        }
        Ok(KeptByPatches { ids: ids.to_vec(), vertices })
    }

    fn refused(&self, what: impl Into<String>, advice: impl Into<String>) -> Problem {
        Problem::new(what, format!("{}, symmetry.", self.document.name), advice)
    }
}

/// Whether a method has a use for a symmetry: cones have partners across a plane, patches keep planes and half turns.
fn is_of_use(method: Method, symmetry: &Symmetry) -> bool {
    match (method, symmetry.kind) {
        (_, SymmetryKind::Mirror) => true,
        (Method::Cones, _) => false,
        (Method::Developable, SymmetryKind::Rotation { order }) => order % 2 == 0,
        (Method::CutFlow | Method::PhaseField, _) => true,
    }
}

fn is_own_inverse(matrix: &Matrix3<f64>) -> bool {
    (matrix * matrix - Matrix3::identity()).norm() < 1e-6
}

/// Identifiers and names: mirrors and axes are counted by themselves.
fn named(found: &[Symmetry]) -> impl Iterator<Item = (String, String, &Symmetry)> {
    let mut counts = std::collections::BTreeMap::<u32, usize>::new();
    found.iter().map(move |symmetry| {
        let order = match symmetry.kind {
            SymmetryKind::Mirror => 0,
            SymmetryKind::Rotation { order } => order,
        };
        let count = counts.entry(order).or_default();
        *count += 1;
        let id =
            if order == 0 { format!("mirror-{count}") } else { format!("axis{order}-{count}") };
        let label = match order {
            0 => format!("Mirror plane {count}"),
            _ => format!("{order}-fold axis {count}"),
        };
        (id, label, symmetry)
    })
}
