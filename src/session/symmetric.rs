//! Symmetries of the surface: finding them, choosing some, keeping the cut symmetric.

use std::rc::Rc;
use std::sync::Arc;

use super::message::{Event, SymmetryChoice};
use super::text::Problem;
use super::{Session, nothing_open};
use crate::geometry::{
    Symmetry, SymmetryError, SymmetryKind, SymmetryMap, find_symmetries, symmetry_group,
};

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
        let kept = self.work.as_ref().map(|work| work.layers.symmetry.clone()).unwrap_or_default();
        let options = named(found.as_deref().map_or(&[], Vec::as_slice))
            .map(|(id, label, symmetry)| SymmetryChoice {
                on: kept.ids.contains(&id),
                deviation: symmetry.deviation,
                id,
                label,
            })
            .collect();
        Event::Symmetries { is_searched: found.is_some(), options }
    }

    /// Keeps the cut symmetric from a new start on.
    pub(super) fn set_symmetry(
        &mut self,
        ids: &[String],
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        self.find_symmetries(events)?;
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let surface = work.document.surface()?;
        let found = work.symmetries.clone().unwrap_or_default();
        let mut chosen = Vec::new();
        for id in ids {
            let Some((.., symmetry)) = named(&found).find(|(known, ..)| known == id) else {
                let known: Vec<String> = named(&found).map(|(id, ..)| id).collect();
                return Err(Problem::new(
                    format!("The surface has no symmetry “{id}”."),
                    format!("{}, symmetry.", work.document.name),
                    match known.is_empty() {
                        true => "None was found: run without.".to_owned(),
                        false => format!("Choose from {}.", known.join(", ")),
                    },
                ));
            };
            chosen.push(*symmetry);
        }
        let maps = if chosen.is_empty() {
            Vec::new()
        } else {
            symmetry_group(&surface.mesh, &surface.geometry, &chosen, MOST)
                .map_err(|error| refused(&work.document.name, &error))?
        };
        let mut layers = work.layers.clone();
        layers.symmetry = Rc::new(Kept { ids: ids.to_vec(), maps: Arc::new(maps) });
        self.restart_with(layers, "change symmetry", events)?;
        events.push(self.symmetries());
        Ok(())
    }
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

fn refused(name: &str, error: &SymmetryError) -> Problem {
    Problem::new(
        format!("These symmetries do not go together: {error}."),
        format!("{name}, symmetry."),
        "Choose fewer of them.",
    )
}
