//! What is measured on the given surface before remeshing begins.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use crate::geometry::Geometry;
use crate::mesh::Mesh;
use crate::methods::prepare::NONE;
use crate::methods::prepare::coarseness::vertex_bends;

/// The parts of a surface between lines: for each face its part, for each part its first face.
pub(super) fn split_parts(mesh: &Mesh, edge_curves: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut face_parts = vec![NONE; mesh.face_count()];
    let mut parts = Vec::new();
    let mut stack = Vec::new();
    for seed in mesh.faces() {
        if face_parts[seed.index()] != NONE {
            continue;
        }
        let part = parts.len() as u32;
        parts.push(seed.0);
        face_parts[seed.index()] = part;
        stack.push(seed);
        while let Some(f) = stack.pop() {
            for h in mesh.face_halfedges(f) {
                if edge_curves[h.edge().index()] == NONE
                    && let Some(g) = mesh.face(h.twin())
                    && face_parts[g.index()] == NONE
                {
                    face_parts[g.index()] = part;
                    stack.push(g);
                }
            }
        }
    }
    (face_parts, parts)
}

/// Length wanted at each vertex, in multiples of the length for the whole: mean bend over bend, to the power of `adaptivity`.
/// Empty for 0. Evened out over neighbours, so that lengths change slowly.
pub(super) fn length_scales(mesh: &Mesh, geometry: &Geometry, adaptivity: f64) -> Vec<f64> {
    if adaptivity <= 0.0 {
        return Vec::new();
    }
    let bends = vertex_bends(mesh, geometry);
    let areas = geometry.vertex_dual_areas(mesh);
    let mean = bends.iter().zip(&areas).map(|(b, a)| b * a).sum::<f64>() / geometry.total_area();
    let scale = |&bend: &f64| {
        let ratio = mean / bend.max(0.01 * mean);
        if ratio.is_finite() { ratio.clamp(0.25, 2.0).powf(adaptivity) } else { 1.0 }
    };
    let mut scales: Vec<f64> = bends.iter().map(scale).collect();
    // Six rounds reach as far as the largest triangle wanted next to the smallest ones.
    for _ in 0..6 {
        let mut sums: Vec<(f64, f64)> = scales.iter().map(|&s| (s, 1.0)).collect();
        for e in mesh.edges() {
            let [a, b] = mesh.edge_vertices(e).map(|v| v.index());
            for (to, from) in [(a, b), (b, a)] {
                sums[to].0 += scales[from];
                sums[to].1 += 1.0;
            }
        }
        scales = sums.into_iter().map(|(sum, count)| sum / count).collect();
    }
    scales
}
