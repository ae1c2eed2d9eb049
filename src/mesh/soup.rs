//! Polygon soup: what a file says, before anything is checked.

/// Vertices and polygons as they stand in a file: order kept, nothing merged, nothing dropped.
///
/// The coordinates are carried along as opaque payload: nothing in [`crate::mesh`] measures with them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Soup {
    /// One place for each vertex of the file, in its order.
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices of all polygons, one polygon after the other.
    pub corners: Vec<u32>,
    /// Where each polygon begins in `corners`, and `corners.len()` at the end: one more entry than polygons.
    pub starts: Vec<u32>,
    /// The line of the file that each polygon stands on, counted from 1; empty for generated and binary input.
    pub lines: Vec<u32>,
    /// Texture coordinates of the file, in its order; empty where it has none.
    pub texture_coordinates: Vec<[f64; 2]>,
    /// For each entry of `corners` its index into `texture_coordinates`, `u32::MAX` for none; empty where the file
    /// has none.
    pub texture_corners: Vec<u32>,
    /// Normals of the file, in its order; empty where it has none.
    pub normals: Vec<[f64; 3]>,
    /// For each entry of `corners` its index into `normals`, `u32::MAX` for none; empty where the file has none.
    pub normal_corners: Vec<u32>,
    /// Names of groups, objects or nodes, in order of first use; empty where the file has none.
    pub groups: Vec<String>,
    /// For each polygon its index into `groups`, `u32::MAX` for none; empty where the file has none.
    pub polygon_groups: Vec<u32>,
    /// Names of materials, in order of first use; empty where the file has none.
    pub materials: Vec<String>,
    /// For each polygon its index into `materials`, `u32::MAX` for none; empty where the file has none.
    pub polygon_materials: Vec<u32>,
}

impl Soup {
    /// A soup of triangles.
    pub fn from_triangles(positions: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Self {
        let starts = (0..).step_by(3).take(triangles.len() + 1).collect();
        Self { positions, corners: triangles.concat(), starts, ..Self::default() }
    }

    /// Number of polygons.
    pub fn polygon_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The vertices of polygon `i`.
    pub fn polygon(&self, i: usize) -> &[u32] {
        &self.corners[self.starts[i] as usize..self.starts[i + 1] as usize]
    }
}
