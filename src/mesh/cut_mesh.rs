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
    vertex_patches: Vec<u32>,
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

    /// The face of the mesh that a triangle is, if the cut leaves that face whole.
    pub fn undivided(&self, mesh: &Mesh, triangle: FaceId) -> Option<FaceId> {
        let face = self.triangle_faces[triangle.index()];
        let corners = mesh.face_vertices(face).map(|v| v.0);
        (self.triangles[triangle.index()] == corners).then_some(face)
    }

    /// Opens the surface along its cut edges.
    ///
    /// **Takes** cut edges that are edges of the triangulation. A cut may end inside a patch or be closed; the opened surface
    /// is a manifold either way, because each fan of triangles between cut edges gets a vertex of its own.
    /// **Fails** if the triangles were no manifold to begin with. **Costs** O(V + F).
    pub fn open(&self) -> Result<OpenedMesh, MeshError> {
        let corners = CutCorners::new(self);
        // Each fan of corners between cut edges becomes a vertex; the first fan keeps the point's number.
        let mut corner_vertices = self.triangles.clone();
        let mut vertex_points: Vec<u32> = (0..self.points.len() as u32).collect();
        let mut turn = Vec::new();
        for point in 0..self.points.len() as u32 {
            if !corners.turn(point, &mut turn) {
                // No manifold there: the triangles as they are tell what is wrong.
                Mesh::new(self.points.len(), &self.triangles)?;
                return Err(MeshError::NonManifoldVertices { vertices: vec![VertexId(point)] });
            }
            let mut current = point;
            for (i, corner) in turn.iter().enumerate() {
                if i > 0 && corner.is_cut {
                    current = vertex_points.len() as u32;
                    vertex_points.push(point);
                }
                corner_vertices[corner.face as usize][corner.index as usize] = current;
            }
        }
        let mesh = Mesh::new(vertex_points.len(), &corner_vertices)?;

        let mut partners = vec![NONE; mesh.halfedge_count()];
        let side =
            |corner: &Corner| mesh.face_halfedges(FaceId(corner.face))[corner.index as usize];
        for point in 0..self.points.len() as u32 {
            for corner in corners.at(point).iter().filter(|corner| corner.is_cut) {
                let across = corners.at(corner.next).iter().find(|other| other.next == point);
                if let Some(across) = across {
                    partners[side(corner).index()] = side(across).0;
                }
            }
        }
        let topology = mesh.topology();
        let face_patches = topology.face_components;
        let mut vertex_patches = vec![0; mesh.vertex_count()];
        for (vertices, &patch) in mesh.triangles().iter().zip(&face_patches) {
            for v in vertices {
                vertex_patches[v.index()] = patch;
            }
        }
        let patch_count = topology.components;
        Ok(OpenedMesh { mesh, vertex_points, face_patches, patch_count, vertex_patches, partners })
    }
}

/// The corner of a triangle at a point on a cut.
#[derive(Clone, Copy, Default)]
struct Corner {
    face: u32,
    /// Which of the triangle's three.
    index: u8,
    /// The points after and before it in the triangle.
    next: u32,
    last: u32,
    /// Whether the surface is cut along the side towards `next`.
    is_cut: bool,
}

/// The corners at all points on cuts: the only place where opening changes anything.
struct CutCorners {
    /// Where each point's corners begin, and the number of all.
    starts: Vec<u32>,
    /// In the order of the faces for each point.
    corners: Vec<Corner>,
}

impl CutCorners {
    fn new(cut: &CutMesh) -> Self {
        let mut on_cut = vec![false; cut.points.len()];
        for &p in cut.cut_edges.iter().flatten() {
            on_cut[p as usize] = true;
        }
        let mut ends = vec![0u32; cut.points.len() + 1];
        for &p in cut.triangles.iter().flatten().filter(|&&p| on_cut[p as usize]) {
            ends[p as usize + 1] += 1;
        }
        for p in 0..cut.points.len() {
            ends[p + 1] += ends[p];
        }
        let starts = ends.clone();
        let mut corners = vec![Corner::default(); starts[cut.points.len()] as usize];
        for (face, triangle) in cut.triangles.iter().enumerate() {
            for i in 0..3 {
                let point = triangle[i] as usize;
                if on_cut[point] {
                    let (next, last) = (triangle[(i + 1) % 3], triangle[(i + 2) % 3]);
                    let (face, index) = (face as u32, i as u8);
                    corners[ends[point] as usize] =
                        Corner { face, index, next, last, is_cut: false };
                    ends[point] += 1;
                }
            }
        }
        let mut result = Self { starts, corners };
        for &[a, b] in &cut.cut_edges {
            // The surface's own boundary is open already.
            let at = result.at(a);
            let is_inside = at.iter().any(|c| c.next == b) && at.iter().any(|c| c.last == b);
            debug_assert!(
                at.iter().any(|c| c.next == b || c.last == b),
                "cut edge {a}-{b} is no edge of the triangulation"
            );
            if is_inside {
                for (from, to) in [(a, b), (b, a)] {
                    let range = result.range(from);
                    let along = result.corners[range].iter_mut().filter(|c| c.next == to);
                    along.for_each(|c| c.is_cut = true);
                }
            }
        }
        result
    }

    fn range(&self, point: u32) -> std::ops::Range<usize> {
        self.starts[point as usize] as usize..self.starts[point as usize + 1] as usize
    }

    fn at(&self, point: u32) -> &[Corner] {
        &self.corners[self.range(point)]
    }

    /// The corners at a point in one turn, counter-clockwise: from a cut, so that no fan is met in two parts, or from the
    /// surface's own boundary. **Gives** false where one turn does not meet them all.
    fn turn(&self, point: u32, turn: &mut Vec<Corner>) -> bool {
        turn.clear();
        let at = self.at(point);
        let Some(last) = at.last() else { return true };
        let after = |corner: &Corner| at.iter().find(|c| c.next == corner.last);
        let rim = at.iter().find(|corner| at.iter().all(|c| c.last != corner.next));
        let start = rim.unwrap_or(last);
        let mut corner = start;
        loop {
            turn.push(*corner);
            match after(corner) {
                Some(next) if turn.len() < at.len() && !std::ptr::eq(next, start) => corner = next,
                // Once around, or from one rim to the other.
                end => {
                    let is_whole = rim.is_some() == end.is_none()
                        && end.is_none_or(|end| std::ptr::eq(end, start));
                    if rim.is_none() {
                        let first = turn.iter().position(|c| c.is_cut).unwrap_or(0);
                        turn.rotate_left(first);
                    }
                    return is_whole && turn.len() == at.len();
                }
            }
        }
    }
}

impl OpenedMesh {
    /// The halfedge across the cut, for a halfedge inside a face.
    pub fn partner(&self, h: HalfedgeId) -> Option<HalfedgeId> {
        let partner = self.partners[h.index()];
        (partner != NONE).then_some(HalfedgeId(partner))
    }

    /// Patch of every vertex (isolated vertices: none exist in an opened mesh of used points).
    pub fn vertex_patches(&self) -> &[u32] {
        &self.vertex_patches
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
    fn a_cut_through_a_point_where_parts_only_touch_is_refused_by_its_number() {
        // Two fans of two triangles that share point 0.
        let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 4, 5], [0, 5, 6]];
        let count = 7;
        let cut = CutMesh {
            points: (0..count).map(|v| SurfacePoint::Vertex(VertexId(v))).collect(),
            triangle_faces: (0..4).map(FaceId).collect(),
            triangles,
            cut_edges: vec![[0, 2], [0, 5]],
        };
        let error = cut.open().unwrap_err();
        assert_eq!(error, MeshError::NonManifoldVertices { vertices: vec![VertexId(0)] });
        let mut twice = grid(1);
        twice.triangles.push(twice.triangles[0]);
        twice.triangle_faces.push(FaceId(0));
        twice.cut_edges = vec![[0, 3]];
        assert!(matches!(twice.open(), Err(MeshError::NonManifoldEdges { .. })));
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
