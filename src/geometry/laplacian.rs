//! The cotan Laplacian.

use super::Geometry;
use crate::linalg::Pattern;
use crate::mesh::Mesh;

/// The weak, positive semi-definite cotan Laplacian of a surface: uᵀLu = ∫|∇u|².
///
/// **Gives** V × V, symmetric, rows sum to zero, unitless; a Poisson problem reads L u = M f.
#[derive(Clone, Debug)]
pub struct Laplacian {
    /// Diagonal and one entry for each edge.
    pub pattern: Pattern,
    /// Where each edge's off-diagonal entry stands.
    pub edge_slots: Vec<u32>,
    /// The entries.
    pub values: Vec<f64>,
    /// The ends of every edge.
    pub edge_ends: Vec<[u32; 2]>,
}

impl Laplacian {
    /// Assembles L from corner cotangents: entry ij = −½ (cot α + cot β). **Costs** O(V + F).
    pub fn new(mesh: &Mesh, geometry: &Geometry) -> Self {
        let pairs: Vec<[u32; 2]> =
            mesh.edges().map(|e| mesh.edge_vertices(e).map(|v| v.0)).collect();
        let (pattern, edge_slots) = Pattern::new(mesh.vertex_count(), &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        for f in mesh.faces() {
            let cotangents = geometry.corner_cotangents[f.index()];
            let vertices = mesh.face_vertices(f);
            for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
                let weight = 0.5 * cotangents[(i + 2) % 3];
                values[edge_slots[h.edge().index()] as usize] -= weight;
                values[pattern.diagonal(vertices[i].index())] += weight;
                values[pattern.diagonal(vertices[(i + 1) % 3].index())] += weight;
            }
        }
        Self { pattern, edge_slots, values, edge_ends: pairs }
    }
}
