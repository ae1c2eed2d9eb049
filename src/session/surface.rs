//! The surface that methods work on, and what it has to do with the file that it came from.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::rc::Rc;
use std::sync::Arc;

use nalgebra::Vector3;

use super::text::Problem;
use crate::geometry::{Geometry, Intrinsic, UnitFrame, face_curvatures, without_slivers};
use crate::mesh::{Mesh, Soup, Topology, VertexId};
use crate::methods::prepare::coarseness;

/// An oriented manifold of unit area.
#[derive(Clone, Debug)]
pub struct Surface {
    /// What errors call it.
    pub name: String,
    /// The file as it was read and repaired.
    pub soup: Rc<Soup>,
    /// For each vertex of the mesh its vertex of the file.
    pub soup_vertices: Vec<u32>,
    /// For each face the polygon of the file that it is a part of.
    pub face_polygons: Vec<u32>,
    /// Connectivity of the used vertices.
    pub mesh: Arc<Mesh>,
    /// Its shape in numbers.
    pub topology: Topology,
    /// Measured at unit area.
    pub geometry: Arc<Geometry>,
    /// From unit area back to the file.
    pub frame: UnitFrame,
    /// The same surface divided without slivers, where it has any: what methods solve on. Same vertices.
    pub solving: Option<Intrinsic>,
    /// Unit normals of the vertices.
    pub vertex_normals: Vec<Vector3<f64>>,
    /// Gaussian curvature at the vertices: mean over the faces.
    pub vertex_curvatures: Vec<f64>,
    /// How large its triangles are against its curvature: see [`coarseness`].
    pub coarseness: f64,
}

impl Surface {
    /// Measures triangles that are known to form an oriented manifold.
    ///
    /// **Takes** triangles over the soup's vertices, facing outwards, and their polygons. **Fails** if they do not, or have no extent.
    pub fn new(
        name: &str,
        soup: Rc<Soup>,
        mut triangles: Vec<[u32; 3]>,
        face_polygons: Vec<u32>,
    ) -> Result<Self, Problem> {
        let soup_vertices = renumber(soup.positions.len(), &mut triangles);
        let in_file = |v: usize| soup_vertices.get(v).map_or(v, |&s| s as usize);
        let mesh = Mesh::new(soup_vertices.len(), &triangles)
            .map_err(|error| Problem::mesh(name, &error, in_file))?;
        let positions: Vec<[f64; 3]> =
            soup_vertices.iter().map(|&v| soup.positions[v as usize]).collect();
        let (geometry, frame) = Geometry::unit_area(&mesh, &positions)
            .map_err(|error| Problem::geometry(name, &error, in_file))?;
        let solving = without_slivers(&mesh, &geometry)
            .map_err(|error| Problem::mesh(name, &error, in_file))?;
        let (solved_mesh, solved) =
            solving.as_ref().map_or((&mesh, &geometry), |s| (&s.mesh, &s.geometry));
        let vertex_curvatures =
            face_to_vertex(solved_mesh, solved, &face_curvatures(solved_mesh, solved));
        let vertex_normals = geometry.vertex_normals(&mesh);
        let topology = mesh.topology();
        let coarseness = coarseness(&mesh, &geometry.positions);
        Ok(Self {
            name: name.to_owned(),
            soup,
            soup_vertices,
            face_polygons,
            mesh: Arc::new(mesh),
            topology,
            geometry: Arc::new(geometry),
            frame,
            solving,
            vertex_normals,
            vertex_curvatures,
            coarseness,
        })
    }

    /// The mesh and the metric to solve on.
    pub fn solving(&self) -> (&Mesh, &Geometry) {
        match &self.solving {
            Some(better) => (&better.mesh, &better.geometry),
            None => (&*self.mesh, &*self.geometry),
        }
    }

    /// The same for a method that keeps them.
    pub fn solving_shared(&self) -> (Arc<Mesh>, Arc<Geometry>) {
        match &self.solving {
            Some(better) => (Arc::new(better.mesh.clone()), Arc::new(better.geometry.clone())),
            None => (self.mesh.clone(), self.geometry.clone()),
        }
    }

    /// The mesh and the metric that cones are found on: the given triangles, whose cotangents charts will have too, unless some of them
    /// have no area.
    pub fn given_or_mended(&self) -> (&Mesh, &Geometry) {
        match &self.solving {
            Some(better) if better.mollified > 0.0 => (&better.mesh, &better.geometry),
            _ => (&self.mesh, &self.geometry),
        }
    }

    /// The mesh's vertex of a vertex of the file.
    pub fn mesh_vertex(&self, soup_vertex: usize) -> Option<VertexId> {
        let wanted = u32::try_from(soup_vertex).ok()?;
        self.soup_vertices.binary_search(&wanted).ok().map(VertexId::from)
    }

    /// Four different vertices of the file on the boundary, to be the corners of a rectangle.
    pub fn corners(&self, soup_vertices: &[usize]) -> Result<[VertexId; 4], Problem> {
        let on_rim = |&v: &usize| {
            self.mesh_vertex(v).filter(|&v| self.mesh.is_boundary_vertex(v)).ok_or_else(|| {
                Problem::new(
                    format!("Vertex {v} is not on the boundary."),
                    format!("{}, corners of a rectangle.", self.name),
                    "Choose four vertices on the boundary, counted from 0.",
                )
            })
        };
        let corners: Vec<VertexId> = soup_vertices.iter().map(on_rim).collect::<Result<_, _>>()?;
        corners.try_into().map_err(|given: Vec<VertexId>| {
            Problem::new(
                format!("{} corners were given.", given.len()),
                format!("{}, corners of a rectangle.", self.name),
                "Choose four.",
            )
        })
    }

    /// The mesh's vertex of a vertex of the file, or of the next one that a face uses.
    pub fn mesh_vertex_from(&self, soup_vertex: usize) -> Option<VertexId> {
        if soup_vertex >= self.soup.positions.len() {
            return None;
        }
        let next = self.soup_vertices.partition_point(|&v| (v as usize) < soup_vertex);
        Some(VertexId::from(next.min(self.soup_vertices.len() - 1)))
    }

    /// Radius of the smallest ball about the origin that holds the surface, unit area.
    pub fn radius(&self) -> f64 {
        self.geometry.positions.iter().fold(0.0, |r: f64, p| r.max(p.coords.norm()))
    }
}

/// Numbers the used vertices in the order of the file. **Gives** for each its old number.
fn renumber(vertex_count: usize, triangles: &mut [[u32; 3]]) -> Vec<u32> {
    let mut numbers = vec![u32::MAX; vertex_count];
    for v in triangles.iter().flatten() {
        numbers[*v as usize] = 0;
    }
    let mut old = Vec::new();
    for (v, number) in numbers.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
        *number = old.len() as u32;
        old.push(v as u32);
    }
    for v in triangles.iter_mut().flatten() {
        *v = numbers[*v as usize];
    }
    old
}

/// Area-weighted mean of a face quantity at the vertices.
pub(super) fn face_to_vertex(mesh: &Mesh, geometry: &Geometry, values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; mesh.vertex_count()];
    let mut areas = vec![0.0; mesh.vertex_count()];
    for f in mesh.faces() {
        let (value, area) = (values[f.index()], geometry.face_areas[f.index()]);
        if value.is_finite() {
            for v in mesh.face_vertices(f) {
                sums[v.index()] += value * area;
                areas[v.index()] += area;
            }
        }
    }
    sums.iter().zip(&areas).map(|(s, a)| if *a > 0.0 { s / a } else { f64::NAN }).collect()
}
