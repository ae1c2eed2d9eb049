//! What a person does to cones by hand.

use std::f64::consts::PI;

use super::super::surface::Surface;
use super::super::text::{Problem, plural};
use super::{ConeKind, UsedCone};
use crate::mesh::VertexId;
use crate::methods::cones::{ConeConflict, ConeError, EditError};
use crate::methods::flow::SolveError;

/// Cones by hand: those that the optimum has to reckon with, and changes of its result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edits {
    /// Cones that were put somewhere; the optimum is found with them.
    pub placed: Vec<Placed>,
    /// All cones, once one of the result was moved, turned to another angle or taken away: then the optimum is left.
    pub changed: Option<Vec<UsedCone>>,
    /// Whether such changes were given up since, because another optimum was asked for.
    pub has_dropped: bool,
}

/// A cone that was put somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Where.
    pub vertex: VertexId,
    /// Its angle; without one the optimum finds it.
    pub angle: Option<f64>,
}

impl Edits {
    /// Puts a cone where none was placed yet.
    pub fn place(&mut self, placed: Placed) {
        self.placed.retain(|other| other.vertex != placed.vertex);
        self.placed.push(placed);
    }

    /// Whether nothing was done by hand.
    pub fn is_empty(&self) -> bool {
        self.placed.is_empty() && self.changed.is_none()
    }

    /// The cone that was placed at a vertex.
    pub fn placed_at(&self, vertex: VertexId) -> Option<usize> {
        self.placed.iter().position(|placed| placed.vertex == vertex)
    }

    /// How a cone at a vertex of the optimum came about.
    pub fn kind(&self, vertex: VertexId, members: usize) -> ConeKind {
        match self.placed_at(vertex).map(|i| self.placed[i].angle) {
            Some(Some(_)) => ConeKind::Fixed,
            Some(None) => ConeKind::Free,
            None if members > 1 => ConeKind::Merged,
            None => ConeKind::Optimal,
        }
    }
}

/// Why cones cannot be as they were asked for, with the numbers of the file.
pub fn cone_problem(surface: &Surface, error: &SolveError) -> Problem {
    let SolveError::Cones(error) = error else { return Problem::solve(&surface.name, error) };
    let name = |v: VertexId| surface.soup_vertices.get(v.index()).copied().unwrap_or(v.0);
    let in_pi = |x: f64| format!("{:.4} π", x / PI);
    let at = |v: VertexId| format!("{}, vertex {} (counted from 0).", surface.name, name(v));
    let part = |v: VertexId| format!("{}, the part of vertex {}.", surface.name, name(v));
    match error {
        ConeError::OutOfBounds { vertex, needed, least, most } => Problem::new(
            format!(
                "No cones within the bounds are enough: their angles have to add up to {} (Gauss–Bonnet), and the bounds allow {} to {}.",
                in_pi(*needed),
                in_pi(*least),
                in_pi(*most)
            ),
            part(*vertex),
            "Widen the bounds, exclude less, or fix fewer cones.",
        ),
        ConeError::TooFew { count, needed } => Problem::new(
            format!(
                "{} cannot have the total angle that this surface must have (Gauss–Bonnet): at least {needed} are needed.",
                plural(*count, "cone")
            ),
            format!("{}, exact number of cones.", surface.name),
            format!(
                "Ask for {needed} or more, or allow larger angles. Without a bound a cone has half a turn at most here, with one up to 3π/2."
            ),
        ),
        ConeError::GaussBonnet { vertex, total, needed } => Problem::new(
            format!(
                "The angles add up to {}, and on this surface they have to add up to {} (Gauss–Bonnet).",
                in_pi(*total),
                in_pi(*needed)
            ),
            part(*vertex),
            "Change one of the angles by the difference, or leave one cone free.",
        ),
        ConeError::Conflict { vertex, angle, conflict } => {
            let (what, advice) = match conflict {
                ConeConflict::Twice => {
                    ("There is a cone by hand there already.".into(), "Change that one.")
                }
                ConeConflict::Excluded => (
                    "Cones are forbidden there.".into(),
                    "Choose another place, or erase what forbids them.",
                ),
                ConeConflict::Bounds => (
                    format!("A cone of {} lies outside the bounds of the angles.", in_pi(*angle)),
                    "Widen the bounds, or choose another angle.",
                ),
                ConeConflict::Boundary => (
                    "A cone cannot lie on this boundary: its curvature follows from its lengths."
                        .into(),
                    "Choose a place inside, or a polygonal boundary, which has corners.",
                ),
            };
            Problem::new(what, at(*vertex), advice)
        }
        _ => Problem::new(
            format!("The cones cannot be as asked for: {error}."),
            format!("{}, cones.", surface.name),
            "Change what was painted or placed by hand.",
        ),
    }
}

/// An angle that no flat surface has around a point.
pub fn too_large(place: String, angle: f64) -> Problem {
    Problem::new(
        format!("A cone of {:.4} π takes more than the full turn there is.", angle / PI),
        place,
        "Choose an angle between −2 π and 2 π.",
    )
}

/// Why a change by hand cannot be made, with the numbers of the file.
pub fn edit_problem(surface: &Surface, error: &EditError) -> Problem {
    let name = |v: VertexId| surface.soup_vertices.get(v.index()).copied().unwrap_or(v.0);
    let in_pi = |x: f64| {
        let text = format!("{:.4}", (x / PI).abs());
        let sign = if x < 0.0 { "−" } else { "" };
        format!("{sign}{} π", text.trim_end_matches('0').trim_end_matches('.'))
    };
    let place = |v: VertexId| format!("{}, vertex {} (counted from 0).", surface.name, name(v));
    match *error {
        EditError::NoSuchVertex { vertex, vertices } => Problem::new(
            format!("There is no vertex {}: the surface has {vertices}.", vertex.0),
            format!("{}, cones by hand.", surface.name),
            "Point at the surface.",
        ),
        EditError::NoCone { vertex } => Problem::new(
            "There is no cone there.",
            place(vertex),
            "Choose one of the cones in the table.",
        ),
        EditError::Occupied { vertex } => Problem::new(
            "There is a cone there already.",
            place(vertex),
            "Change that one, or choose another place.",
        ),
        EditError::OutOfRange { vertex, angle, least, most } => Problem::new(
            if angle < 0.0 {
                format!(
                    "A cone would have the angle {}: more than a turn too much around it.",
                    in_pi(angle)
                )
            } else {
                format!(
                    "A cone would have the angle {}: nothing could be flat around it.",
                    in_pi(angle)
                )
            },
            place(vertex),
            format!(
                "Its angle has to lie between {} and {}; choose a smaller change, or set other cones free.",
                in_pi(least),
                in_pi(most)
            ),
        ),
        EditError::AllFixed { vertex, total, needed } => Problem::new(
            format!(
                "The angles would add up to {}, and on this surface they have to add up to {} (Gauss–Bonnet); \
                 no cone is free to make up for it.",
                in_pi(total),
                in_pi(needed)
            ),
            format!("{}, the part of vertex {}.", surface.name, name(vertex)),
            "Set another cone free, or add one.",
        ),
    }
}

/// A cone that is not there.
pub fn no_such_cone(cone: usize, count: usize) -> Problem {
    Problem::new(
        format!("There is no cone {}: there are {count}.", cone.saturating_add(1)),
        "In the change of a cone.",
        "Choose one of the cones in the table.",
    )
}
