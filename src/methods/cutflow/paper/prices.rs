//! What the objective pays for, face by face and label by label: all that the paper's flow needs to know of its terms.

use nalgebra::Vector2;

use super::super::energy::{Problem, Weights};
use crate::mesh::{FaceId, VertexId};

/// K in Δu = −K on a face, within the region of a label.
pub(super) fn source(problem: &Problem, _weights: &Weights, f: FaceId, _label: u32) -> f64 {
    problem.face_curvatures[f.index()]
}

/// Scale a of the Dirichlet energy ∫a|∇u|² on a face.
pub(super) fn scale(_problem: &Problem, _weights: &Weights, _f: FaceId) -> f64 {
    1.0
}

/// Derivatives of the mean of b(u) over a triangle by the values at its corners.
pub(super) fn pointwise_slopes(_weights: &Weights, values: [f64; 3]) -> [f64; 3] {
    let sum: f64 = values.iter().sum();
    values.map(|u| (u + sum) / 6.0)
}

/// Price of a unit of cut in a face.
pub(super) fn length_price(_problem: &Problem, weights: &Weights, _f: FaceId) -> f64 {
    weights.length
}

/// How that price changes from place to place, in the face's frame.
pub(super) fn price_slope(_problem: &Problem, _weights: &Weights, _f: FaceId) -> Vector2<f64> {
    Vector2::zeros()
}

/// What a region gains with each unit of area.
pub(super) fn reward(_weights: &Weights, _label: u32) -> f64 {
    0.0
}

/// How far a vertex holds the cut beside it, from 0 to 1.
pub(super) fn hold(_problem: &Problem, _v: VertexId) -> f64 {
    0.0
}

/// Whether p is a solve of its own and not a multiple of u.
pub(super) fn has_own_adjoint(weights: &Weights) -> bool {
    weights.hencky > 0.0
}
