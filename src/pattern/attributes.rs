//! What the file says of its faces besides their shape, carried over to the faces of the refined surface: normals, groups,
//! materials.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::obj::CutSurface;
use crate::mesh::{FaceId, SurfacePoint, VertexId};

/// "None", as the soup has it.
const NONE: u32 = u32::MAX;

/// Normals at the corners of the refined triangles.
pub(super) struct Normals {
    /// Normals that are not in the file: at points on the cut, mixed of those at the corners of their face, unit length.
    pub new: Vec<[f64; 3]>,
    /// For each corner of each triangle the index of its normal, the file's first and then the new ones; `u32::MAX` for none.
    corners: Vec<[u32; 3]>,
}

impl Normals {
    /// Empty where the file has no normals.
    pub fn new(surface: &CutSurface) -> Self {
        let mut result = Self { new: Vec::new(), corners: Vec::new() };
        if surface.soup.normal_corners.is_empty() || surface.face_polygons.is_empty() {
            return result;
        }
        for (triangle, &face) in surface.cut.triangles.iter().zip(&surface.cut.triangle_faces) {
            let own = corner_normals(surface, face);
            let numbers =
                triangle.map(|point| result.at(surface, face, &own, surface.cut.points[point as usize]));
            result.corners.push(numbers);
        }
        result
    }

    /// The normal of a corner, counted from 0.
    pub fn corner(&self, triangle: usize, corner: usize) -> Option<usize> {
        let number = self.corners.get(triangle)?[corner];
        (number != NONE).then_some(number as usize)
    }

    fn at(
        &mut self,
        surface: &CutSurface,
        face: FaceId,
        own: &[u32; 3],
        point: SurfacePoint,
    ) -> u32 {
        let vertices = surface.mesh.face_vertices(face);
        let place = |v: VertexId| vertices.iter().position(|&w| w == v);
        let mut weights = [0.0; 3];
        match point {
            SurfacePoint::Vertex(v) => return place(v).map_or(NONE, |i| own[i]),
            SurfacePoint::Edge(e, t) => {
                for (v, weight) in surface.mesh.edge_vertices(e).into_iter().zip([1.0 - t, t]) {
                    if let Some(i) = place(v) {
                        weights[i] = weight;
                    }
                }
            }
            SurfacePoint::Face(_, w) => weights = w,
        }
        let mut sum = [0.0; 3];
        for (&number, weight) in own.iter().zip(weights).filter(|(_, w)| *w > 0.0) {
            let Some(normal) = surface.soup.normals.get(number as usize) else { return NONE };
            for (s, n) in sum.iter_mut().zip(normal) {
                *s += weight * n;
            }
        }
        let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length > 1e-12) {
            return NONE;
        }
        self.new.push(sum.map(|x| x / length));
        (surface.soup.normals.len() + self.new.len() - 1) as u32
    }
}

/// The normals that the file gives to the corners of a face.
fn corner_normals(surface: &CutSurface, face: FaceId) -> [u32; 3] {
    let soup = surface.soup;
    let polygon = surface.face_polygons[face.index()] as usize;
    let first = soup.starts[polygon] as usize;
    surface.mesh.face_vertices(face).map(|v| {
        let vertex = surface.soup_vertex(v.index()) as u32;
        let corner = soup.polygon(polygon).iter().position(|&w| w == vertex);
        corner.map_or(NONE, |corner| soup.normal_corners[first + corner])
    })
}

/// The material and the group of the polygon that a triangle lies in.
pub(super) fn names<'a>(surface: &CutSurface<'a>, triangle: usize) -> [Option<&'a str>; 2] {
    let soup = surface.soup;
    let face = surface.cut.triangle_faces[triangle];
    let Some(&polygon) = surface.face_polygons.get(face.index()) else { return [None; 2] };
    let name = |numbers: &[u32], names: &'a [String]| {
        let number = *numbers.get(polygon as usize)?;
        names.get(number as usize).map(String::as_str)
    };
    [name(&soup.polygon_materials, &soup.materials), name(&soup.polygon_groups, &soup.groups)]
}

/// A name as one word of an OBJ line.
pub(super) fn word(name: &str) -> String {
    name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect()
}

/// A name that ends with its line.
pub(super) fn line(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { '_' } else { c }).collect()
}
