//! What the objective pays for, face by face and label by label: all that the paper's flow needs to know of its terms.

use nalgebra::Vector2;

use super::super::energy::Problem;
use super::super::terms::Weights;
use crate::mesh::{FaceId, VertexId};

/// K in Δu = −K on a face, within the region of a label.
pub(super) fn source(problem: &Problem, weights: &Weights, f: FaceId, label: u32) -> f64 {
    if weights.one_sided && label != 0 { 0.0 } else { problem.face_sources[f.index()] }
}

/// Scale a of the Dirichlet energy ∫a|∇u|² on a face.
pub(super) fn scale(problem: &Problem, weights: &Weights, f: FaceId) -> f64 {
    if weights.rescaled { problem.scales[f.index()] } else { 1.0 }
}

/// Derivatives of the mean of b(u) over a triangle by the values at its corners.
pub(super) fn pointwise_slopes(weights: &Weights, values: [f64; 3]) -> [f64; 3] {
    weights.pointwise.mean(values).1
}

/// η at the corners of a face, if there is any.
fn penalties(problem: &Problem, weights: &Weights, f: FaceId) -> Option<[f64; 3]> {
    (weights.penalty > 0.0 && !problem.penalty.is_empty())
        .then(|| problem.mesh.face_vertices(f).map(|v| problem.penalty[v.index()]))
}

/// Price of a unit of cut in a face: its mean.
pub(super) fn length_price(problem: &Problem, weights: &Weights, f: FaceId) -> f64 {
    let mean = penalties(problem, weights, f).map_or(0.0, |eta| eta.iter().sum::<f64>() / 3.0);
    weights.length + weights.penalty * mean
}

/// The highest price of a unit of cut.
pub(super) fn highest_price(problem: &Problem, weights: &Weights) -> f64 {
    weights.length + weights.penalty * problem.penalty.iter().fold(0.0f64, |m, eta| m.max(*eta))
}

/// How that price changes from place to place, in the face's frame.
pub(super) fn price_slope(problem: &Problem, weights: &Weights, f: FaceId) -> Vector2<f64> {
    let Some(eta) = penalties(problem, weights, f) else { return Vector2::zeros() };
    let corners = problem.frames.corners(f);
    let double = 2.0 * problem.geometry.face_areas[f.index()];
    let mut slope = Vector2::zeros();
    for i in 0..3 {
        let side = corners[(i + 2) % 3] - corners[(i + 1) % 3];
        slope += Vector2::new(-side.y, side.x) * (eta[i] / double);
    }
    slope * weights.penalty
}

/// What a region gains with each unit of area.
pub(super) fn reward(weights: &Weights, label: u32) -> f64 {
    if label == 0 { weights.area } else { 0.0 }
}

/// How far a vertex holds the cut beside it, from 0 to 1.
pub(super) fn hold(problem: &Problem, v: VertexId) -> f64 {
    problem.pins.get(v.index()).copied().unwrap_or(0.0)
}

/// Whether p is a solve of its own and not a multiple of u.
pub(super) fn has_own_adjoint(weights: &Weights) -> bool {
    weights.hencky > 0.0 || weights.rescaled
}
