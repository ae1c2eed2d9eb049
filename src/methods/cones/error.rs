//! What can be wrong with what is asked of cones.

use crate::mesh::VertexId;

/// What a prescribed cone contradicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConeConflict {
    /// The vertex has a prescribed cone already.
    Twice,
    /// No cones are allowed there.
    Excluded,
    /// The angle lies outside the bounds.
    Bounds,
    /// Cones cannot lie on a boundary that keeps its lengths, or whose lengths are chosen.
    Boundary,
}

impl std::fmt::Display for ConeConflict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Twice => "that vertex has a prescribed cone already",
            Self::Excluded => "cones are excluded there",
            Self::Bounds => "it lies outside the bounds of the angles",
            Self::Boundary => "the vertex lies on the boundary, whose curvature is not prescribed",
        })
    }
}

/// Why cones cannot be as they were asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConeError {
    /// A field that has not one value for each vertex.
    #[error("{name} has {given} values for {vertices} vertices")]
    FieldLength {
        /// Its name.
        name: &'static str,
        /// Number of values.
        given: usize,
        /// Number of vertices of the surface.
        vertices: usize,
    },
    /// A value of a field that cannot be used.
    #[error("{name} is {value} at vertex {}; it must be finite and at least 0", .vertex.0)]
    FieldValue {
        /// Its name.
        name: &'static str,
        /// Where.
        vertex: VertexId,
        /// What was given.
        value: f64,
    },
    /// No set of cones within the bounds has the total angle that this part of the surface must have.
    #[error(
        "the cones on the part of vertex {} must add up to {needed} (Gauss–Bonnet), and the bounds allow {least} to {most}",
        .vertex.0
    )]
    OutOfBounds {
        /// A vertex of the connected component.
        vertex: VertexId,
        /// What the angles add up to, radians.
        needed: f64,
        /// Least total that the bounds allow.
        least: f64,
        /// Largest total that they allow.
        most: f64,
    },
    /// So few cones cannot have the total angle that the surface must have.
    #[error(
        "{count} cones cannot have the total angle that the surface must have (Gauss–Bonnet): {needed} can"
    )]
    TooFew {
        /// What was asked for.
        count: usize,
        /// The fewest that can.
        needed: usize,
    },
    /// A prescribed cone that contradicts something else that was asked for.
    #[error("the cone of angle {angle} at vertex {} cannot be: {conflict}", .vertex.0)]
    Conflict {
        /// Its vertex.
        vertex: VertexId,
        /// Its angle, radians.
        angle: f64,
        /// With what.
        conflict: ConeConflict,
    },
    /// Cones whose angles do not add up to what the surface must have.
    #[error("the cones on the part of vertex {} add up to {total}, not to {needed} (Gauss–Bonnet)", .vertex.0)]
    GaussBonnet {
        /// A vertex of the connected component.
        vertex: VertexId,
        /// What was given, radians.
        total: f64,
        /// What is needed, radians.
        needed: f64,
    },
}
