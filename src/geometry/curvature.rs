//! Curvature of a polyhedral metric.

use std::f64::consts::{PI, TAU};

use super::Geometry;
use crate::mesh::{FaceId, Mesh};

/// Sum of the corner angles at each vertex, radians.
pub fn angle_sums(mesh: &Mesh, geometry: &Geometry) -> Vec<f64> {
    let mut sums = vec![0.0; mesh.vertex_count()];
    for (f, angles) in geometry.corner_angles.iter().enumerate() {
        for (v, angle) in mesh.face_vertices(FaceId::from(f)).iter().zip(angles) {
            sums[v.index()] += angle;
        }
    }
    sums
}

/// Integrated Gaussian curvature: 2π − Θ inside, geodesic curvature π − Θ on the boundary, 0 at isolated vertices.
///
/// **Means** integrated; the sum is 2πχ (Gauss–Bonnet).
pub fn angle_defects(mesh: &Mesh, geometry: &Geometry) -> Vec<f64> {
    let sums = angle_sums(mesh, geometry);
    mesh.vertices()
        .map(|v| match mesh.halfedge(v) {
            None => 0.0,
            Some(_) if mesh.is_boundary_vertex(v) => PI - sums[v.index()],
            Some(_) => TAU - sums[v.index()],
        })
        .collect()
}

/// Gaussian curvature of each face, K_f = (Σ a′ − π) / A_f with augmented angles a′ = 2π a / Θ (a′ = a on the boundary).
///
/// **Means** pointwise; ∑ K_f A_f over a closed surface is 2πχ. **From** [VSC] eq. 24. **Differs**: the sign of the paper's
/// eq. 24 is reversed, so that it fits Δu = −K with a sphere of positive curvature.
pub fn face_curvatures(mesh: &Mesh, geometry: &Geometry) -> Vec<f64> {
    let sums = angle_sums(mesh, geometry);
    mesh.faces()
        .map(|f| {
            let angles = geometry.corner_angles[f.index()];
            let augmented: f64 = mesh
                .face_vertices(f)
                .iter()
                .zip(angles)
                .map(
                    |(&v, a)| {
                        if mesh.is_boundary_vertex(v) { a } else { TAU * a / sums[v.index()] }
                    },
                )
                .sum();
            (augmented - PI) / geometry.face_areas[f.index()]
        })
        .collect()
}
