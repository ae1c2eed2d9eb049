//! Merging in both images of a symmetry, or in neither.

use std::collections::BTreeMap;

use crate::flatten::small;
use crate::mesh::{EdgeId, FaceId, Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Where a symmetry of order two maps faces and edges.
#[derive(Clone, Debug)]
pub struct Mirror {
    faces: Vec<FaceId>,
    edges: Vec<EdgeId>,
}

/// Whether two lists hold the same edges.
pub(super) fn same_edges(a: &[EdgeId], b: &[EdgeId]) -> bool {
    let sorted = |edges: &[EdgeId]| {
        let mut sorted = edges.to_vec();
        sorted.sort_unstable();
        sorted
    };
    sorted(a) == sorted(b)
}

/// Whether vertices go where a symmetry of order two of the mesh would take them, triangles to triangles.
pub fn maps_triangles(mesh: &Mesh, vertices: &[VertexId]) -> bool {
    Mirror::new(mesh, vertices).is_ok()
}

impl Mirror {
    /// **Fails** where the vertices are no symmetry of order two of the mesh.
    pub fn new(mesh: &Mesh, vertices: &[VertexId]) -> Result<Self, SolveError> {
        let count = mesh.vertex_count();
        let is_involution = vertices.len() == count
            && vertices
                .iter()
                .enumerate()
                .all(|(v, w)| vertices.get(w.index()).is_some_and(|back| back.index() == v));
        if !is_involution {
            return Err(SolveError::NotSymmetric);
        }
        let sorted = |mut corners: [VertexId; 3]| {
            corners.sort_unstable();
            corners
        };
        let mut by_corners = BTreeMap::new();
        for f in mesh.faces() {
            by_corners.insert(sorted(mesh.face_vertices(f)), f);
        }
        let image = |v: VertexId| vertices[v.index()];
        let mut faces = Vec::with_capacity(mesh.face_count());
        for f in mesh.faces() {
            let found = by_corners.get(&sorted(mesh.face_vertices(f).map(image)));
            faces.push(*found.ok_or(SolveError::NotSymmetric)?);
        }
        let mut edges = Vec::with_capacity(mesh.edge_count());
        for e in mesh.edges() {
            let [a, b] = mesh.edge_vertices(e).map(image);
            let found = mesh.outgoing(a).find(|&h| mesh.tip(h) == b);
            edges.push(found.ok_or(SolveError::NotSymmetric)?.edge());
        }
        Ok(Self { faces, edges })
    }

    /// Image of a face.
    pub fn face(&self, f: FaceId) -> FaceId {
        self.faces[f.index()]
    }

    /// Images of edges.
    pub fn edges(&self, edges: &[EdgeId]) -> Vec<EdgeId> {
        edges.iter().map(|e| self.edges[e.index()]).collect()
    }

    /// The coarsest labels that refine the given ones and that the symmetry maps to each other: pairs of a face's label and that of its image.
    pub fn common_labels(&self, labels: &[u32]) -> (Vec<u32>, Vec<u32>) {
        let mut numbers: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut firsts = Vec::new();
        let fine = labels
            .iter()
            .zip(&self.faces)
            .map(|(&label, image)| {
                *numbers.entry([label, labels[image.index()]]).or_insert_with(|| {
                    firsts.push(label);
                    small(firsts.len() - 1)
                })
            })
            .collect();
        (fine, firsts)
    }
}
