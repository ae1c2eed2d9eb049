//! Where charts lie in the unit square: one scale for all, so that real sizes can be told from it.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::piece::Bounds;
use crate::mesh::OpenedMesh;

/// Charts fitted into the unit square, low corner at the origin, as far as one scale for all allows.
pub(super) struct UvMap {
    /// For each patch whether every corner of it has a place.
    pub has_chart: Vec<bool>,
    /// Vertices of the opened surface in patches with a chart, in their order: those with a place in the square.
    pub placed: Vec<u32>,
    /// The low corner of all charts.
    pub low: [f64; 2],
    /// Side of the unit square in units of the charts.
    pub extent: f64,
}

impl UvMap {
    /// **Takes** a place for each vertex of the opened surface, NaN in patches without a chart.
    pub fn new(opened: &OpenedMesh, charts: &[[f64; 2]]) -> Self {
        assert_eq!(charts.len(), opened.mesh.vertex_count());
        let corners = || opened.mesh.triangles().iter().zip(&opened.face_patches);
        let mut has_chart = vec![true; opened.patch_count];
        for (triangle, &patch) in corners() {
            let is_placed = |v: usize| charts[v].iter().all(|x| x.is_finite());
            has_chart[patch as usize] &= triangle.iter().all(|v| is_placed(v.index()));
        }
        let mut is_used = vec![false; charts.len()];
        for (triangle, &patch) in corners() {
            for v in triangle {
                is_used[v.index()] |= has_chart[patch as usize];
            }
        }
        let placed: Vec<u32> =
            (0..charts.len()).filter(|&v| is_used[v]).map(|v| v as u32).collect();
        let Bounds { low, high } = Bounds::around(placed.iter().map(|&v| charts[v as usize]));
        let extent = (high[0] - low[0]).max(high[1] - low[1]);
        let extent = if extent > 0.0 { extent } else { 1.0 };
        Self { has_chart, placed, low, extent }
    }

    /// A place in the unit square, v up.
    pub fn uv(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        // Subtraction and division are monotonic: nothing leaves the unit square by rounding.
        [(x - self.low[0]) / self.extent, (y - self.low[1]) / self.extent]
    }
}

/// The faces of each patch, in their order.
pub(super) fn faces_by_patch(opened: &OpenedMesh) -> Vec<Vec<usize>> {
    let mut faces = vec![Vec::new(); opened.patch_count];
    for (face, &patch) in opened.face_patches.iter().enumerate() {
        faces[patch as usize].push(face);
    }
    faces
}
