//! Texture coordinates of a remeshed surface, read off the given one.

use super::RemeshFlow;
use crate::mesh::FaceId;
use crate::methods::prepare::features::Place;
use crate::methods::prepare::{NONE, Uv};

impl RemeshFlow {
    /// The texture coordinates of a face.
    pub(super) fn uvs(&self, f: u32) -> [Uv; 3] {
        self.triangles.faces[f as usize].map(|v| match self.places[v as usize] {
            Place::Free(on) => {
                let uvs = self.given.attributes.corner_uvs[on as usize];
                let weights = self.weights[v as usize];
                let [a, b, c] = uvs;
                let (a, b, c) = (a?, b?, c?);
                Some([0, 1].map(|i| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i]))
            }
            _ => self.uv_on_line(f, v),
        })
    }

    /// The texture coordinate at a vertex on a line, on the side that a face is on: clockwise from the face comes a line.
    fn uv_on_line(&self, mut f: u32, v: u32) -> Uv {
        for _ in 0..self.triangles.fans[v as usize].len() {
            let i = self.triangles.corner(f, v);
            let (mark, w) = (
                self.triangles.marks[f as usize][i],
                self.triangles.faces[f as usize][(i + 1) % 3],
            );
            if mark == NONE {
                let faces = self.triangles.edge_faces(v, w);
                f = faces.as_slice().iter().copied().find(|&g| g != f)?;
                continue;
            }
            let curve = &self.features.curves[mark as usize];
            let (from, to) = (self.arc(mark, v), self.arc(mark, w));
            let (segment, t) = curve.segment(from);
            let on = FaceId(curve.face(segment, to > from)?);
            let corners = self.given.mesh.face_vertices(on);
            let uv = |v: u32| {
                let i = corners.iter().position(|w| w.0 == v)?;
                self.given.attributes.corner_uvs[on.index()][i]
            };
            let (a, b) = (uv(curve.vertices[segment]), uv(curve.vertices[segment + 1]));
            return match t {
                0.0 => a,
                1.0 => b,
                _ => a.zip(b).map(|(a, b)| [0, 1].map(|i| (1.0 - t) * a[i] + t * b[i])),
            };
        }
        None
    }
}
