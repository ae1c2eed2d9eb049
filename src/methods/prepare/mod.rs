//! Surfaces made ready for cutting: finer, more even, or lighter.
//!
//! Methods that solve for a function on the vertices need triangles that are small against the curvature and well shaped.
//! [`subdivide`] splits triangles and leaves the surface where it is, [`remesh`] draws new, even triangles on the old
//! surface, [`decimate`] takes triangles away where they tell least; [`coarseness`] says whether one of them is called for.
//!
//! Guaranteed by all three: the topology stays (components, boundary loops, genus); seams of the texture and borders of
//! materials and groups stay closed lines of edges with the same faces on either side; vertices that survive keep their
//! coordinates bit for bit and come first, in their old order; the same input gives the same bits. Every state can be drawn.
//!
//! Not guaranteed: that the surface does not run through itself, before or after; that a target is reached; triangles
//! without area stay such where no legal operation removes them.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

mod coarseness;
mod decimate;
mod features;
mod quadric;
mod remesh;
mod subdivide;
mod triangles;

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::flow::SolveError;
use crate::mesh::{Mesh, MeshError, Soup, VertexId};

pub use coarseness::{TOO_COARSE, coarseness};
pub use decimate::{DecimateFlow, DecimateParams};
pub use remesh::{EdgeTarget, RemeshFlow, RemeshParams};
pub use subdivide::{SubdivideFlow, SubdivideParams, SubdivideRule};

/// A texture coordinate, none where the file gives none.
pub type Uv = Option<[f64; 2]>;

const NONE: u32 = u32::MAX;

/// What faces and their corners carry besides their place. A list is empty where the surface has none of its kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Texture coordinates at the corners of every face. An edge whose two sides disagree is a seam.
    pub corner_uvs: Vec<[Uv; 3]>,
    /// For each face its index into `groups`, `u32::MAX` for none.
    pub face_groups: Vec<u32>,
    /// For each face its index into `materials`, `u32::MAX` for none.
    pub face_materials: Vec<u32>,
    /// Names of groups.
    pub groups: Vec<String>,
    /// Names of materials.
    pub materials: Vec<String>,
}

/// A triangulated surface with everything that preparing must carry along.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Connectivity.
    pub mesh: Mesh,
    /// Place of every vertex, in any unit.
    pub positions: Vec<Point3<f64>>,
    /// What faces and corners carry.
    pub attributes: Attributes,
}

/// A surface on its way, and where its vertices came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The surface. Vertices without a face are left out.
    pub surface: Surface,
    /// For each vertex the vertex of the given surface that it is, none where it is new or was moved. Those that are old come
    /// first, in increasing order.
    pub ancestors: Vec<Option<VertexId>>,
}

impl Surface {
    /// Connects triangles over a soup's vertices and takes over texture coordinates, groups and materials.
    ///
    /// **Takes** triangles whose indices lie within `soup.positions`, and for each of them the polygon that it was cut from. A
    /// corner takes the texture coordinate of the polygon's corner at the same vertex, or, where vertices were welded, at
    /// the nearest. **Fails** if the triangles form no manifold. **Costs** O(V + F).
    pub fn new(
        soup: &Soup,
        triangles: &[[u32; 3]],
        triangle_polygons: &[u32],
    ) -> Result<Self, MeshError> {
        assert_eq!(triangles.len(), triangle_polygons.len());
        let mesh = Mesh::new(soup.positions.len(), triangles)?;
        let positions = soup.positions.iter().copied().map(Point3::from).collect();
        let of_polygons = |list: &[u32]| -> Vec<u32> {
            let get = |&p: &u32| list.get(p as usize).copied().unwrap_or(NONE);
            if list.is_empty() { Vec::new() } else { triangle_polygons.iter().map(get).collect() }
        };
        let corner_uvs = if soup.texture_corners.is_empty() {
            Vec::new()
        } else {
            let uv = |polygon: u32, v: u32| {
                let corner = nearest_corner(soup, polygon as usize, v)?;
                let index = *soup.texture_corners.get(corner)?;
                soup.texture_coordinates.get(index as usize).copied()
            };
            let of_triangle = |(t, &p): (&[u32; 3], &u32)| t.map(|v| uv(p, v));
            triangles.iter().zip(triangle_polygons).map(of_triangle).collect()
        };
        let attributes = Attributes {
            corner_uvs,
            face_groups: of_polygons(&soup.polygon_groups),
            face_materials: of_polygons(&soup.polygon_materials),
            groups: soup.groups.clone(),
            materials: soup.materials.clone(),
        };
        Ok(Self { mesh, positions, attributes })
    }

    /// The surface as a soup of triangles: vertex and face numbers stay. Carried are texture coordinates, groups and
    /// materials; normals of the file no longer fit and are not.
    pub fn into_soup(self) -> Soup {
        let triangles: Vec<[u32; 3]> =
            self.mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect();
        let mut soup = Soup::from_triangles(
            self.positions.iter().map(|p| [p.x, p.y, p.z]).collect(),
            &triangles,
        );
        let Attributes { corner_uvs, face_groups, face_materials, groups, materials } =
            self.attributes;
        // One texture coordinate for all corners of a vertex that agree, so that seams can be told from smooth edges.
        let mut numbers: HashMap<(u32, u64, u64), u32> = HashMap::new();
        for (triangle, uvs) in triangles.iter().zip(&corner_uvs) {
            for (v, uv) in triangle.iter().zip(uvs) {
                let index = uv.map_or(NONE, |[x, y]| {
                    *numbers.entry((*v, x.to_bits(), y.to_bits())).or_insert_with(|| {
                        soup.texture_coordinates.push([x, y]);
                        soup.texture_coordinates.len() as u32 - 1
                    })
                });
                soup.texture_corners.push(index);
            }
        }
        soup.polygon_groups = face_groups;
        soup.polygon_materials = face_materials;
        soup.groups = groups;
        soup.materials = materials;
        soup
    }

    /// Refuses coordinates that no length can be computed from.
    fn check_finite(&self) -> Result<(), SolveError> {
        let is_finite = |p: &Point3<f64>| p.iter().all(|x| x.is_finite());
        if self.positions.iter().all(is_finite) { Ok(()) } else { Err(SolveError::NotFinite) }
    }

    /// Twice the area times the unit normal of every face.
    fn face_vectors(&self) -> Vec<Vector3<f64>> {
        let vector = |t: &[VertexId; 3]| {
            let [a, b, c] = t.map(|v| self.positions[v.index()]);
            (b - a).cross(&(c - a))
        };
        self.mesh.triangles().iter().map(vector).collect()
    }
}

/// The entry of `soup.corners` that stands for vertex `v` in a polygon.
fn nearest_corner(soup: &Soup, polygon: usize, v: u32) -> Option<usize> {
    if polygon >= soup.polygon_count() {
        return None;
    }
    let corners = soup.starts[polygon] as usize..soup.starts[polygon + 1] as usize;
    let same = corners.clone().find(|&i| soup.corners[i] == v);
    let place = |v: u32| Vector3::from(soup.positions[v as usize]);
    let distance = |&i: &usize| (place(soup.corners[i]) - place(v)).norm_squared();
    same.or_else(|| corners.min_by(|i, j| distance(i).total_cmp(&distance(j))))
}

/// A parameter within its range.
fn check(name: &'static str, value: f64, min: f64, max: f64) -> Result<(), SolveError> {
    if value >= min && value <= max {
        Ok(())
    } else {
        Err(SolveError::Parameter { name, value, min, max })
    }
}
