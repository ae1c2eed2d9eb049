//! What can be wrong with what is asked of a conformal flattening.

use crate::mesh::{MeshError, VertexId};
use crate::methods::flow::SolveError;

/// Why a surface cannot be flattened as it was asked for, with the number that is wrong and the nearest one that is not.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConformalError {
    /// Cone and boundary angles of a connected part do not add up to 2πχ.
    #[error(
        "the angles on the part of vertex {} add up to {total}, and a flat surface of this shape has {needed} (Gauss–Bonnet): they are {} too {}",
        .vertex.0, (.total - .needed).abs(), if .total > .needed { "large" } else { "small" }
    )]
    GaussBonnet {
        /// A vertex of the part.
        vertex: VertexId,
        /// Sum of what was asked for, radians.
        total: f64,
        /// 2πχ.
        needed: f64,
    },
    /// A cone that leaves no angle about its point.
    #[error(
        "the cone at vertex {} has the angle {angle}: no flat surface has 2π or more; the largest that is of use is {largest}",
        .vertex.0
    )]
    ConeTooSharp {
        /// Its vertex.
        vertex: VertexId,
        /// What was asked for, radians.
        angle: f64,
        /// What [`super::cap_cones`] would leave there.
        largest: f64,
    },
    /// A corner of the outline that leaves no angle inside.
    #[error(
        "the outline turns by {angle} at vertex {}: it must be less than π; the largest that is of use is {largest}",
        .vertex.0
    )]
    CornerTooSharp {
        /// Its vertex.
        vertex: VertexId,
        /// What was asked for, radians.
        angle: f64,
        /// The nearest that can be.
        largest: f64,
    },
    /// A number that is none.
    #[error("{name} at vertex {} is {value}", .vertex.0)]
    NotFinite {
        /// What it was to be.
        name: &'static str,
        /// Where.
        vertex: VertexId,
        /// What was given.
        value: f64,
    },
    /// A list that has not one number for each vertex.
    #[error("{name} are {given} numbers for {vertices} vertices")]
    WrongLength {
        /// What they were to be.
        name: &'static str,
        /// How many were given.
        given: usize,
        /// How many there must be.
        vertices: usize,
    },
    /// A cone at a vertex that is not there, or has none.
    #[error("there is no vertex {} among {vertices} for a cone", .vertex.0)]
    NoSuchVertex {
        /// What was asked for.
        vertex: VertexId,
        /// Number of vertices.
        vertices: usize,
    },
    /// Two cones at one vertex.
    #[error("vertex {} has two cones", .vertex.0)]
    Twice {
        /// The vertex.
        vertex: VertexId,
    },
    /// A cone on the boundary, where turning angles are asked for instead.
    #[error("the cone at vertex {} lies on the boundary: ask for a turn of the outline there", .vertex.0)]
    ConeOnBoundary {
        /// Its vertex.
        vertex: VertexId,
    },
    /// A cone inside a chart: no seam leads to it, and it cannot lie flat.
    #[error("no seam passes through the cone at vertex {}", .vertex.0)]
    ConeOffSeam {
        /// Its vertex.
        vertex: VertexId,
    },
    /// Options out of range.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// The cut surface is no manifold.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
