//! Borders without zigzag, on a copy of the surface.

use nalgebra::{Point3, Vector3};

use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Options of [`smoothed`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothParams {
    /// Rounds over all border vertices. Ten take the zigzag out of borders; many more move corners of charts along.
    pub sweeps: usize,
    /// λ in units of 1 / (2 · valence), the largest that cannot overshoot.
    pub strength: f64,
}

impl Default for SmoothParams {
    fn default() -> Self {
        Self { sweeps: 8, strength: 1.0 }
    }
}

impl SmoothParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        SolveError::within("sweeps", self.sweeps as f64, 0.0, 1000.0)?;
        SolveError::within("strength", self.strength, 0.0, 1.0)
    }
}

/// Positions with the vertices between charts moved towards the planes of both: v ← v + λ Σ_w Σ_f n_f n_fᵀ (w − v), over neighbours w and the faces f at the edge
/// to w, with the mean normals n of their charts.
///
/// **Takes** a chart for each face. **Gives** new positions; vertices inside charts and on the surface's own boundary stay.
/// **Costs** O(n) for each sweep. **From** [LPFB] §4.2. **Differs** in that λ is given relative to the bound that keeps a sweep from overshooting.
pub fn smoothed(
    mesh: &Mesh,
    geometry: &Geometry,
    charts: &[u32],
    params: &SmoothParams,
) -> Result<Vec<Point3<f64>>, SolveError> {
    params.validate()?;
    let count = charts.iter().max().map_or(0, |&most| most as usize + 1);
    let mut normals = vec![Vector3::zeros(); count];
    let face_normals = geometry.face_normals(mesh);
    for f in mesh.faces() {
        let n: Vector3<f64> = face_normals[f.index()] * geometry.face_areas[f.index()];
        if n.norm().is_finite() {
            normals[charts[f.index()] as usize] += n;
        }
    }
    for n in &mut normals {
        *n = n.try_normalize(0.0).unwrap_or_else(Vector3::zeros);
    }
    let is_border = |v: &VertexId| {
        let mut around = mesh.outgoing(*v).filter_map(|h| mesh.face(h)).map(|f| charts[f.index()]);
        let first = around.next();
        !mesh.is_boundary_vertex(*v) && around.any(|chart| Some(chart) != first)
    };
    let border: Vec<VertexId> =
        mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()).filter(is_border).collect();
    let mut positions = geometry.positions.clone();
    for _ in 0..params.sweeps {
        let moves: Vec<Vector3<f64>> = border
            .iter()
            .map(|&v| {
                let (mut sum, mut valence) = (Vector3::zeros(), 0.0);
                for h in mesh.outgoing(v) {
                    valence += 1.0;
                    let to: Vector3<f64> = positions[mesh.tip(h).index()] - positions[v.index()];
                    for f in [h, h.twin()].into_iter().filter_map(|h| mesh.face(h)) {
                        let n = normals[charts[f.index()] as usize];
                        sum += n * n.dot(&to);
                    }
                }
                sum * (params.strength / (2.0 * valence))
            })
            .collect();
        for (v, by) in border.iter().zip(moves) {
            positions[v.index()] += by;
        }
    }
    Ok(positions)
}
