//! Surfaces refined along a cut, and opened there.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::{EdgeId, FaceId, HalfedgeId, Mesh, MeshError, VertexId};

/// A point of a surface, told by the elements of its mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SurfacePoint {
    /// A vertex.
    Vertex(VertexId),
    /// The point (1 − t) tail + t tip of the edge's first halfedge, 0 < t < 1.
    Edge(EdgeId, f64),
    /// The point with these barycentric coordinates in a face.
    Face(FaceId, [f64; 3]),
}

/// A triangulation that refines a mesh so that a cut runs along its edges.
///
/// Points `0..V` are the mesh's own vertices in their order; new points follow. Triangles keep the orientation of the face
/// that they lie in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CutMesh {
    /// Where each point lies on the mesh.
    pub points: Vec<SurfacePoint>,
    /// Counter-clockwise point triples.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the face of the mesh that it lies in.
    pub triangle_faces: Vec<FaceId>,
    /// The edges that the cut runs along, each once, as pairs of points.
    pub cut_edges: Vec<[u32; 2]>,
}

/// A [`CutMesh`] after opening: every patch a component of its own, every cut edge a pair of boundary edges.
///
/// Face `i` is triangle `i` of the cut mesh. The first vertices are one copy of each point, in the points' order; further
/// copies of points on cuts follow.
#[derive(Clone, Debug)]
pub struct OpenedMesh {
    /// Connectivity of the opened surface.
    pub mesh: Mesh,
    /// For each vertex the point that it is a copy of.
    pub vertex_points: Vec<u32>,
    /// For each face its patch (component), numbered by first face.
    pub face_patches: Vec<u32>,
    /// Number of patches.
    pub patch_count: usize,
    /// For each halfedge inside a face whose edge lies on a cut, the halfedge inside a face across the cut (which runs
    /// the other way); `None` elsewhere, on the surface's own boundary too.
    partners: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl CutMesh {
    /// The refinement that leaves a mesh as it is, with no cut.
    pub fn uncut(mesh: &Mesh) -> Self {
        Self {
            points: mesh.vertices().map(SurfacePoint::Vertex).collect(),
            triangles: mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect(),
            triangle_faces: mesh.faces().collect(),
            cut_edges: Vec::new(),
        }
    }

    /// Opens the surface along its cut edges.
    ///
    /// **Takes** cut edges that are edges of the triangulation. A cut may end inside a patch or be closed; the opened surface
    /// is a manifold either way, because each fan of triangles between cut edges gets a vertex of its own.
    /// **Fails** if the triangles were no manifold to begin with. **Costs** O(V + F).
    pub fn open(&self) -> Result<OpenedMesh, MeshError> {
        let whole = Mesh::new(self.points.len(), &self.triangles)?;
        let mut is_cut = vec![false; whole.edge_count()];
        for &[a, b] in &self.cut_edges {
            let h = whole.outgoing(VertexId(a)).find(|&h| whole.tip(h) == VertexId(b));
            debug_assert!(h.is_some(), "cut edge {a}-{b} is no edge of the triangulation");
            if let Some(h) = h {
                is_cut[h.edge().index()] = !whole.is_boundary_edge(h.edge());
            }
        }

        // Each fan of corners between cut edges becomes a vertex; the first fan keeps the point's number.
        let mut corner_vertices = self.triangles.clone();
        let mut vertex_points: Vec<u32> = (0..self.points.len() as u32).collect();
        let mut on_cut = vec![false; self.points.len()];
        for e in whole.edges().filter(|e| is_cut[e.index()]) {
            for v in whole.edge_vertices(e) {
                on_cut[v.index()] = true;
            }
        }
        for v in whole.vertices().filter(|v| on_cut[v.index()]) {
            let mut turn: Vec<(HalfedgeId, FaceId)> =
                whole.outgoing(v).filter_map(|h| Some((h, whole.face(h)?))).collect();
            if !whole.is_boundary_vertex(v) {
                // Start at a cut, so that no fan is met in two parts.
                let first = turn.iter().position(|(h, _)| is_cut[h.edge().index()]).unwrap_or(0);
                turn.rotate_left(first);
            }
            let mut current = v.0;
            for (i, &(h, face)) in turn.iter().enumerate() {
                if i > 0 && is_cut[h.edge().index()] {
                    current = vertex_points.len() as u32;
                    vertex_points.push(v.0);
                }
                let corner = whole.face_vertices(face).iter().position(|&w| w == v).unwrap_or(0);
                corner_vertices[face.index()][corner] = current;
            }
        }
        let mesh = Mesh::new(vertex_points.len(), &corner_vertices)?;

        let mut partners = vec![NONE; mesh.halfedge_count()];
        for edge in whole.edges().filter(|e| is_cut[e.index()]) {
            let h = edge.halfedge();
            if let (Some(left), Some(right)) =
                (side(&whole, &mesh, h), side(&whole, &mesh, h.twin()))
            {
                partners[left.index()] = right.0;
                partners[right.index()] = left.0;
            }
        }
        let topology = mesh.topology();
        Ok(OpenedMesh {
            mesh,
            vertex_points,
            face_patches: topology.face_components,
            patch_count: topology.components,
            partners,
        })
    }
}

/// The halfedge of the opened mesh that is side `h` of the same face.
fn side(whole: &Mesh, opened: &Mesh, h: HalfedgeId) -> Option<HalfedgeId> {
    let face = whole.face(h)?;
    let i = whole.face_halfedges(face).iter().position(|&g| g == h)?;
    Some(opened.face_halfedges(face)[i])
}

impl OpenedMesh {
    /// The halfedge across the cut, for a halfedge inside a face.
    pub fn partner(&self, h: HalfedgeId) -> Option<HalfedgeId> {
        let partner = self.partners[h.index()];
        (partner != NONE).then_some(HalfedgeId(partner))
    }

    /// Patch of every vertex (isolated vertices: none exist in an opened mesh of used points).
    pub fn vertex_patches(&self) -> Vec<u32> {
        let mut patches = vec![0; self.mesh.vertex_count()];
        for (face, vertices) in self.mesh.triangles().iter().enumerate() {
            for v in vertices {
                patches[v.index()] = self.face_patches[face];
            }
        }
        patches
    }

    /// Euler characteristic and number of boundary loops of each patch. A disk has (1, 1).
    pub fn patch_shapes(&self) -> Vec<(i64, usize)> {
        let mut shapes = vec![(0i64, 0usize); self.patch_count];
        let patches = self.vertex_patches();
        for v in self.mesh.vertices().filter(|&v| self.mesh.halfedge(v).is_some()) {
            shapes[patches[v.index()] as usize].0 += 1;
        }
        for e in self.mesh.edges() {
            shapes[patches[self.mesh.tail(e.halfedge()).index()] as usize].0 -= 1;
        }
        for &patch in &self.face_patches {
            shapes[patch as usize].0 += 1;
        }
        for &h in self.mesh.boundary_loops() {
            shapes[patches[self.mesh.tail(h).index()] as usize].1 += 1;
        }
        shapes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An n × n grid of squares, two triangles each.
    fn grid(n: u32) -> CutMesh {
        let at = |i: u32, j: u32| i * (n + 1) + j;
        let mut triangles = Vec::new();
        for i in 0..n {
            for j in 0..n {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        CutMesh::uncut(&Mesh::new(((n + 1) * (n + 1)) as usize, &triangles).unwrap())
    }

    #[test]
    fn a_cut_across_makes_two_disks_whose_rims_are_partners() {
        let mut cut = grid(4);
        cut.cut_edges = (0..4).map(|j| [2 * 5 + j, 2 * 5 + j + 1]).collect();
        let opened = cut.open().unwrap();
        assert_eq!(opened.patch_count, 2);
        assert_eq!(opened.patch_shapes(), [(1, 1), (1, 1)]);
        assert_eq!(opened.mesh.vertex_count(), 25 + 5);
        let mut pairs = 0;
        for f in opened.mesh.faces() {
            for h in opened.mesh.face_halfedges(f) {
                let Some(partner) = opened.partner(h) else { continue };
                assert_eq!(opened.partner(partner), Some(h));
                let point = |v: VertexId| opened.vertex_points[v.index()];
                assert_eq!(
                    point(opened.mesh.tail(h)),
                    point(opened.mesh.tip(partner)),
                    "partners run in opposite directions"
                );
                pairs += 1;
            }
        }
        assert_eq!(pairs, 2 * 4);
    }

    #[test]
    fn a_slit_doubles_its_inner_points_and_keeps_its_tips() {
        let mut cut = grid(4);
        cut.cut_edges = (1..3).map(|j| [2 * 5 + j, 2 * 5 + j + 1]).collect();
        let opened = cut.open().unwrap();
        assert_eq!(opened.mesh.vertex_count(), 25 + 1);
        assert_eq!(opened.patch_shapes(), [(0, 2)], "an annulus: rim and slit");
        // From the rim inwards the tip outside is doubled as well.
        cut.cut_edges.push([2 * 5, 2 * 5 + 1]);
        let opened = cut.open().unwrap();
        assert_eq!(opened.patch_shapes(), [(1, 1)]);
        assert_eq!(opened.mesh.vertex_count(), 25 + 3);
    }

    #[test]
    fn junctions_get_one_vertex_for_each_sector() {
        let mut cut = grid(4);
        let centre = 2 * 5 + 2;
        for step in [1i64, -1, 5, -5] {
            let mid = (centre as i64 + step) as u32;
            cut.cut_edges.push([centre, mid]);
            cut.cut_edges.push([mid, (mid as i64 + step) as u32]);
        }
        let opened = cut.open().unwrap();
        assert_eq!(opened.patch_count, 4);
        assert_eq!(opened.vertex_points.iter().filter(|&&p| p == centre).count(), 4);
        assert!(opened.patch_shapes().iter().all(|&s| s == (1, 1)));
    }
}
