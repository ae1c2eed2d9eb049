//! What a seam along each edge costs.

use crate::geometry::Geometry;
use crate::mesh::{HalfedgeId, Mesh};

/// What a seam along each edge costs, and how long it is.
#[derive(Clone)]
pub(super) struct Capacities {
    pub edge_costs: Vec<f64>,
    pub lengths: Vec<f64>,
}

impl Capacities {
    /// Length · price / (1 + d / mean d) with the angular distance d = η (1 − cos β), β the angle between the normals of the edge's faces, η = 1
    /// at concave edges and `convex` at convex ones: seams like creases, and valleys best.
    ///
    /// **From** [KT03, §4]. **Differs**: costs are multiplied with lengths, and the mean is weighted with them, so that neither depends on how finely a
    /// surface is divided.
    pub fn new(mesh: &Mesh, geometry: &Geometry, convex: f64, prices: &[f64]) -> Self {
        let normals = geometry.face_normals(mesh);
        let far = |h: HalfedgeId| geometry.positions[mesh.tip(mesh.next(h)).index()];
        let distances: Vec<f64> = mesh
            .edges()
            .map(|e| {
                let h = e.halfedge();
                let (Some(f), Some(g)) = (mesh.face(h), mesh.face(h.twin())) else { return 0.0 };
                let [n, m] = [f, g].map(|f| normals[f.index()]);
                let is_concave = n.dot(&(far(h.twin()) - far(h))) > 0.0;
                (if is_concave { 1.0 } else { convex }) * (1.0 - n.dot(&m)).max(0.0)
            })
            .collect();
        let lengths = geometry.edge_lengths.clone();
        let (mut sum, mut total) = (0.0, 0.0);
        for e in mesh.edges().filter(|&e| !mesh.is_boundary_edge(e)) {
            sum += distances[e.index()] * lengths[e.index()];
            total += lengths[e.index()];
        }
        // On a flat surface only lengths count.
        let mean = if sum > 0.0 { sum / total } else { 1.0 };
        let edge_costs = mesh
            .edges()
            .map(|e| {
                let price = prices.get(e.index()).copied().unwrap_or(1.0);
                lengths[e.index()] * price / (1.0 + distances[e.index()] / mean)
            })
            .collect();
        Self { edge_costs, lengths }
    }
}
