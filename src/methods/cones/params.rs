//! Options of a cone flow, what is painted on the surface, and what comes out.

use std::f64::consts::TAU;

use super::error::ConeError;
use crate::mesh::VertexId;
use crate::methods::flow::SolveError;

/// What the boundary may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConeBoundary {
    /// It keeps its lengths: u = 0.
    #[default]
    Isometric,
    /// Its scale factors are chosen so that the distortion is least.
    Optimal,
    /// Straight but for few corners, whose angles cost like cones.
    Polygonal,
    /// Nowhere curved inwards; curvature costs nothing.
    Convex,
    /// A convex polygon.
    PolygonalConvex,
}

impl ConeBoundary {
    /// Whether the curvature of the boundary is unknown of its own, so that scale factors are fixed up to a constant only.
    pub fn has_corners(self) -> bool {
        matches!(self, Self::Polygonal | Self::Convex | Self::PolygonalConvex)
    }
}

/// How the optimum is found. Both ways lead to the same cones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ConeMethod {
    /// Whichever is predicted to be faster.
    #[default]
    Auto,
    /// Active set over Green's functions: best for few cones.
    Greens,
    /// Semismooth Newton on the two-ring system: best for hundreds of cones.
    Newton,
}

/// Options of a [`super::ConeFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeParams {
    /// Price λ of one radian of cone angle. It has the unit of an area: meant for surfaces of unit area, where it is useful
    /// from .001 to .05.
    pub lambda: f64,
    /// What the boundary may do.
    pub boundary: ConeBoundary,
    /// Price of a radian of corner of a polygonal boundary, in λ.
    pub boundary_cost: f64,
    /// Least and largest angle of a cone inside, radians. 0 lies between them.
    pub bounds: [f64; 2],
    /// How the optimum is found.
    pub method: ConeMethod,
    /// Whether a coarser surface says first where the cones will be.
    pub multiresolution: bool,
}

impl Default for ConeParams {
    fn default() -> Self {
        Self {
            lambda: 0.005,
            boundary: ConeBoundary::Isometric,
            boundary_cost: 1.0,
            bounds: [f64::NEG_INFINITY, f64::INFINITY],
            method: ConeMethod::Auto,
            multiresolution: false,
        }
    }
}

impl ConeParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        // Below 1e-9 of the area the cones are the curvature itself; above 1e9 nothing changes any more.
        within("price of cone angle λ", self.lambda, 1e-12, 1e12)?;
        within("price of boundary corners", self.boundary_cost, 1e-3, 1e3)?;
        within("least cone angle", self.bounds[0], f64::NEG_INFINITY, 0.0)?;
        within("largest cone angle", self.bounds[1], 0.0, f64::INFINITY)
    }
}

/// A vertex whose neighbourhood becomes a cone: the flat metric has the angle 2π − `angle` around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Where.
    pub vertex: VertexId,
    /// Curvature of the flat metric there, radians.
    pub angle: f64,
}

/// What is asked for place by place. Empty lists say nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConeFields {
    /// How much distortion counts at every vertex, w_E ≥ 0. Below [`LEAST_WEIGHT`] of the largest it counts as that.
    pub distortion_weight: Vec<f64>,
    /// How much cone angle costs at every vertex, w_R ≥ 0, in λ.
    pub cone_cost: Vec<f64>,
    /// Where no cones may be.
    pub excluded: Vec<bool>,
    /// Cones that cost nothing and take the angle that suits best, within (−2π, 2π).
    pub free: Vec<VertexId>,
    /// Cones with their angles.
    pub fixed: Vec<(VertexId, f64)>,
}

/// Smallest distortion weight, as a fraction of the largest. Where distortion counts nothing at all the optimum is not unique; less
/// than 1e-6 cannot be told from nothing and only costs digits.
pub const LEAST_WEIGHT: f64 = 1e-6;

/// Bound of the angle of a free cone: without one, a free cone would collect 4π, with 2π its neighbourhood would have no angle left.
pub(super) const FREE_BOUND: f64 = TAU * (1.0 - 1e-6);

impl ConeFields {
    /// Checks lengths, values and vertices.
    pub(super) fn validate(&self, vertices: usize) -> Result<(), SolveError> {
        for (name, field) in
            [("distortion weight", &self.distortion_weight), ("cone cost", &self.cone_cost)]
        {
            if !field.is_empty() && field.len() != vertices {
                return Err(ConeError::FieldLength { name, given: field.len(), vertices }.into());
            }
            if let Some((v, &value)) =
                field.iter().enumerate().find(|(_, x)| !(x.is_finite() && **x >= 0.0))
            {
                return Err(ConeError::FieldValue { name, vertex: VertexId::from(v), value }.into());
            }
        }
        if !self.excluded.is_empty() && self.excluded.len() != vertices {
            let given = self.excluded.len();
            return Err(
                ConeError::FieldLength { name: "excluded vertices", given, vertices }.into()
            );
        }
        let asked = self.free.iter().copied().chain(self.fixed.iter().map(|f| f.0));
        for vertex in asked {
            if vertex.index() >= vertices {
                return Err(SolveError::NoSuchVertex { vertex, vertices });
            }
        }
        Ok(())
    }
}

/// What the path over λ is searched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConeTarget {
    /// This λ.
    Lambda(f64),
    /// The smallest λ at which there are at most so many cones, up to a thousandth.
    Count(usize),
    /// The smallest λ at which there are at most so many cones once clusters are merged by [`super::round_clusters`], up to a
    /// thousandth.
    Merged(usize),
    /// The λ at which the total angle Σ|μ| is this, radians.
    TotalAngle(f64),
    /// The λ at which the distortion ∫u² is this.
    Distortion(f64),
}

/// The optimum, or how far it has come.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConeState {
    /// Price of one radian of cone angle.
    pub lambda: f64,
    /// Cones inside, by ascending vertex; prescribed ones included.
    pub cones: Vec<Cone>,
    /// Curvature of the flattened boundary where it is not zero, by ascending vertex, where the boundary's curvature is an unknown.
    pub corners: Vec<Cone>,
    /// Log scale factor of the flattening at every vertex.
    pub u: Vec<f64>,
    /// The dual variable at every vertex: ±λ w_R at cones.
    pub phi: Vec<f64>,
    /// Σ|μ| over the cones, radians.
    pub total_angle: f64,
    /// ∫u², lumped, every vertex counting alike.
    pub int_u2: f64,
    /// ½ ∫ w_E u² + λ Σ w_R |μ|.
    pub objective: f64,
    /// Relative gap between the objective and the dual objective.
    pub gap: f64,
    /// By how much |φ| exceeds what it may be, in λ.
    pub violation: f64,
    /// The largest of gap, violation and the distance of φ from ±λ w_R at cones, in λ.
    pub residual: f64,
    /// Whether cones as small as the curvature itself are optimal for every λ, because the surface is closed and convex: then μ = Ω, u = 0.
    pub is_convex: bool,
}

/// What a given set of cones is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct ConeEvaluation {
    /// Log scale factor at every vertex.
    pub u: Vec<f64>,
    /// ∫u², lumped, every vertex counting alike.
    pub int_u2: f64,
    /// Σ|μ| over the cones inside, radians.
    pub total_angle: f64,
}
