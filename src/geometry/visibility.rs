//! How well each point of a surface can be seen from one place: a penalty that keeps cuts out of sight.
//!
//! Guaranteed: values from 0 to 1, whatever the mesh. Not guaranteed: anything about points between vertices; thin parts in front
//! of a vertex hide it whole or not at all, up to the smoothing.

use nalgebra::Point3;

use super::{Geometry, Laplacian, Nearest};
use crate::linalg::dot;
use crate::mesh::{Mesh, VertexId};

/// Width of the transition from seen to hidden, in mean edge lengths. With 1 the staircase of the 0/1 visibility along triangles
/// stays and pulls at cuts; with 4 parts as thin as a finger are half seen from behind.
const WIDTH: f64 = 2.0;

/// How visible each vertex is from `eye`: η = s max(0, n · E).
///
/// E is the unit vector to the eye, n the vertex normal, s the visibility (1 where the segment to the eye meets no face except
/// those at the vertex, else 0) after implicit diffusion over a length ℓ of two mean edges, (M + ℓ² L) s = M s₀. Components with a
/// boundary are seen from both sides: |n · E| there.
///
/// **Gives** values from 0 to 1 for each vertex, 0 at isolated ones and where `eye` lies. **Means** pointwise. **Costs** O(V log F).
/// **From** \[VSC\] section 6, fig. 11. **Differs**: the paper does not say how it smooths.
pub fn visibility(mesh: &Mesh, geometry: &Geometry, eye: Point3<f64>) -> Vec<f64> {
    let tree = Nearest::new(mesh, &geometry.positions);
    let normals = geometry.vertex_normals(mesh);
    let has_back = seen_from_both_sides(mesh);
    let mut cosines = vec![0.0; mesh.vertex_count()];
    let mut seen = vec![0.0; mesh.vertex_count()];
    for v in mesh.vertices() {
        let i = v.index();
        let to_eye = eye - geometry.positions[i];
        let cosine = normals[i].dot(&to_eye) / to_eye.norm();
        if mesh.halfedge(v).is_none() || !cosine.is_finite() {
            continue;
        }
        cosines[i] = if has_back[i] { cosine.abs() } else { cosine.max(0.0) }.min(1.0);
        // Asked for back sides too: what is hidden there must not take from what is seen beside it more than the truth.
        let around = |f| mesh.face_vertices(f).contains(&v);
        let is_hidden = tree.is_hit(geometry.positions[i], to_eye, 0.0, 1.0, around);
        seen[i] = if is_hidden { 0.0 } else { 1.0 };
    }
    let length = WIDTH * geometry.mean_edge_length();
    diffuse(mesh, geometry, &mut seen, length);
    seen.iter().zip(&cosines).map(|(s, c)| s.clamp(0.0, 1.0) * c).collect()
}

/// For each vertex whether its component has a boundary.
fn seen_from_both_sides(mesh: &Mesh) -> Vec<bool> {
    let mut is_open = vec![false; mesh.vertex_count()];
    let mut stack: Vec<VertexId> =
        mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v)).collect();
    for v in &stack {
        is_open[v.index()] = true;
    }
    while let Some(v) = stack.pop() {
        for w in mesh.outgoing(v).map(|h| mesh.tip(h)) {
            if !std::mem::replace(&mut is_open[w.index()], true) {
                stack.push(w);
            }
        }
    }
    is_open
}

/// Solves (M + ℓ² L) s = M s₀ in place by conjugate gradients with the diagonal as preconditioner.
///
/// The spread of the matrix is that of M + 4 h² L, about 30 to 1 on even triangles, so that a dozen rounds give the four digits
/// that a penalty needs: a fifth of the price of a factorisation that would be used once.
fn diffuse(mesh: &Mesh, geometry: &Geometry, values: &mut [f64], length: f64) {
    const ROUNDS: usize = 100;
    const RESIDUAL: f64 = 1e-5;
    let Laplacian { pattern, values: mut matrix, .. } = Laplacian::new(mesh, geometry);
    // A vertex whose faces have no area, or that has none, must not make a row of zeros.
    let least = 1e-9 * geometry.total_area() / mesh.vertex_count() as f64;
    let masses: Vec<f64> =
        geometry.vertex_dual_areas(mesh).into_iter().map(|m| m.max(least)).collect();
    matrix.iter_mut().for_each(|x| *x *= length * length);
    for (i, mass) in masses.iter().enumerate() {
        matrix[pattern.diagonal(i)] += mass;
    }
    let mut product = vec![0.0; values.len()];
    pattern.multiply(&matrix, values, &mut product);
    let right: Vec<f64> = values.iter().zip(&masses).map(|(s, m)| s * m).collect();
    let mut residual: Vec<f64> = right.iter().zip(&product).map(|(b, a)| b - a).collect();
    let scaled = |r: &[f64]| -> Vec<f64> {
        r.iter().enumerate().map(|(i, x)| x / matrix[pattern.diagonal(i)]).collect()
    };
    let mut scaled_residual = scaled(&residual);
    let mut direction = scaled_residual.clone();
    let mut norm = dot(&residual, &scaled_residual);
    let enough = RESIDUAL * RESIDUAL * dot(&right, &scaled(&right));
    for _ in 0..ROUNDS {
        if !(norm > enough) {
            break;
        }
        pattern.multiply(&matrix, &direction, &mut product);
        let step = norm / dot(&direction, &product);
        for i in 0..values.len() {
            values[i] += step * direction[i];
            residual[i] -= step * product[i];
        }
        scaled_residual = scaled(&residual);
        let next = dot(&residual, &scaled_residual);
        for (d, z) in direction.iter_mut().zip(&scaled_residual) {
            *d = z + next / norm * *d;
        }
        norm = next;
    }
}
