//! Merging in both images of a symmetry, or in neither.

use std::collections::BTreeMap;

use crate::flatten::small;
use crate::mesh::{EdgeId, FaceId, Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Where a symmetry of order two maps faces and edges.
///
/// Quadrilaterals whose images are divided along the other diagonal count as wholes: their two faces go to the two faces of the image, and the
/// diagonal goes nowhere.
#[derive(Clone, Debug)]
pub struct Mirror {
    faces: Vec<FaceId>,
    edges: Vec<Option<EdgeId>>,
    /// Faces of the quadrilaterals that count as wholes.
    quads: Vec<[FaceId; 2]>,
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

/// Whether vertices go where a symmetry of order two of the mesh would take them, triangles to triangles, but for diagonals of quadrilaterals.
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
        let image = |v: VertexId| vertices[v.index()];
        let between = |a: VertexId, b: VertexId| mesh.outgoing(a).find(|&h| mesh.tip(h) == b);
        let edge_image = |e: EdgeId| {
            let [a, b] = mesh.edge_vertices(e).map(image);
            Some(between(a, b)?.edge())
        };
        let edges: Vec<Option<EdgeId>> = mesh.edges().map(edge_image).collect();
        let sorted = |mut corners: [VertexId; 3]| {
            corners.sort_unstable();
            corners
        };
        let mut by_corners = BTreeMap::new();
        for f in mesh.faces() {
            by_corners.insert(sorted(mesh.face_vertices(f)), f);
        }
        let found = |f: FaceId| by_corners.get(&sorted(mesh.face_vertices(f).map(image))).copied();
        let mut faces: Vec<Option<FaceId>> = mesh.faces().map(found).collect();
        // The two faces at an edge and their corners opposite it.
        let sides = |e: EdgeId| {
            let both = [e.halfedge(), e.halfedge().twin()];
            let [f, g] = [mesh.face(both[0])?, mesh.face(both[1])?];
            let mut faces = [f, g];
            faces.sort_unstable();
            Some((faces, both.map(|h| mesh.tip(mesh.next(h)))))
        };
        let mut quads = Vec::new();
        for e in mesh.edges().filter(|e| edges[e.index()].is_none()) {
            let quad = || {
                let (own, [c, d]) = sides(e)?;
                let other = between(image(c), image(d))?.edge();
                let (its, corners) = sides(other)?;
                let ends = mesh.edge_vertices(e).map(image);
                let is_image = corners == ends || corners == [ends[1], ends[0]];
                let is_free = own.iter().all(|f| faces[f.index()].is_none());
                (is_image && is_free).then_some((own, its))
            };
            let (own, its) = quad().ok_or(SolveError::NotSymmetric)?;
            own.iter().zip(its).for_each(|(f, image)| faces[f.index()] = Some(image));
            quads.push(own);
        }
        let faces: Option<Vec<FaceId>> = faces.into_iter().collect();
        let is_involution = |faces: &Vec<FaceId>| {
            faces.iter().enumerate().all(|(f, image)| faces[image.index()].index() == f)
        };
        let faces = faces.filter(is_involution).ok_or(SolveError::NotSymmetric)?;
        Ok(Self { faces, edges, quads })
    }

    /// Image of a face.
    pub fn face(&self, f: FaceId) -> FaceId {
        self.faces[f.index()]
    }

    /// Image of an edge; a diagonal of a quadrilateral that counts as a whole may have none.
    pub fn edge(&self, e: EdgeId) -> Option<EdgeId> {
        self.edges[e.index()]
    }

    /// Images of edges, if all have one.
    pub fn edges(&self, edges: &[EdgeId]) -> Option<Vec<EdgeId>> {
        edges.iter().map(|e| self.edges[e.index()]).collect()
    }

    /// Labels of faces, both of a quadrilateral that counts as a whole with that of the first.
    pub fn whole_labels(&self, labels: &[u32]) -> Vec<u32> {
        let mut whole = labels.to_vec();
        for [f, g] in &self.quads {
            whole[g.index()] = whole[f.index()];
        }
        whole
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
