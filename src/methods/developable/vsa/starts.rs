//! Where several runs may begin.

use nalgebra::Vector3;

use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh};

/// Faces that lie far from each other, to begin several runs at: greedy methods scatter with their start, and the best of a few runs is better than any one.
///
/// **Gives** `first`, then faces each of which is the farthest in space from those before, the first of several; no more than there are different places.
/// **Costs** O(F) each.
pub fn start_faces(mesh: &Mesh, geometry: &Geometry, first: FaceId, count: usize) -> Vec<FaceId> {
    let centre = |f: FaceId| {
        mesh.face_vertices(f)
            .iter()
            .fold(Vector3::zeros(), |sum, v| sum + geometry.positions[v.index()].coords / 3.0)
    };
    let mut nearest = vec![f64::INFINITY; mesh.face_count()];
    let mut starts = Vec::new();
    let mut next = Some(first).filter(|f| f.index() < mesh.face_count());
    while let Some(start) = next.filter(|_| starts.len() < count) {
        starts.push(start);
        let at = centre(start);
        let mut farthest = (0.0, None);
        for f in mesh.faces() {
            let distance = nearest[f.index()].min((centre(f) - at).norm_squared());
            nearest[f.index()] = distance;
            if distance > farthest.0 {
                farthest = (distance, Some(f));
            }
        }
        next = farthest.1;
    }
    starts
}
