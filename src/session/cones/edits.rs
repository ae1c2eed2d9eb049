//! What a person does to cones by hand.

use super::super::text::Problem;
use super::{ConeKind, UsedCone};
use crate::mesh::VertexId;

/// Cones by hand: those that the optimum has to reckon with, and changes of its result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Edits {
    /// Cones that were put somewhere; the optimum is found with them.
    pub placed: Vec<Placed>,
    /// All cones, once one of the result was moved, turned to another angle or taken away: then the optimum is left.
    pub changed: Option<Vec<UsedCone>>,
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

/// A cone that is not there.
pub fn no_such_cone(cone: usize, count: usize) -> Problem {
    Problem::new(
        format!("There is no cone {}: there are {count}.", cone + 1),
        "In the change of a cone.",
        "Choose one of the cones in the table.",
    )
}
