//! Cuts that turn every patch of a cut surface into a disk.
//!
//! Let S be a patch: a connected surface with boundary ∂S. A graph G of interior edges *cuts S to a disk* when S opened along
//! G is one. Two trees give such a graph: T, of edges, reaches every interior vertex from ∂S; C joins all faces across edges
//! that are not in T. Opened along everything that C does not cross, S is faces glued along a tree: a disk. It remains one when
//! branches of T that end inside are sewn up again. What is left are 1 − χ(S) edges in neither tree and the paths
//! in T from their ends to ∂S. Looked for is a short G.
//!
//! * **Boundary**: the greedy system of arcs. T is the forest of shortest paths from ∂S, of length d. An edge uv off T closes the arc
//!   path(u) + uv + path(v) of length d(u) + |uv| + d(v). C is a maximum spanning tree by that length, so the arcs left are,
//!   taken one by one, the shortest that leave S connected.
//! * **No boundary, handles**: the same from one vertex instead of ∂S (greedy system of loops, 2g of them). The path from that
//!   vertex may end inside and is sewn up too. Several base vertices are tried.
//! * **Sphere**: a path between two far vertices.
//!
//! Arcs share edges and G is not the shortest graph (finding that is NP-hard). Where there are handles each stretch of G
//! between two junctions is then taken out, which leaves an annulus, and the annulus is cut along its shortest crossing. Where
//! there are only holes the arcs are a shortest spanning tree of the boundary loops, and nothing was ever gained.
//!
//! Guaranteed: every patch is a disk afterwards; no edge of the mesh's boundary or of the cut that was there is touched; the
//! same input gives the same cut. Not guaranteed: a shortest cut; a cut shorter than one along edges of the triangulation.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Point3;

use crate::mesh::{
    CutMesh, EdgeId, FaceId, HalfedgeId, Mesh, MeshError, OpenedMesh, VertexId, chains,
};

/// What [`cut_to_disks`] added.
#[derive(Clone, Debug)]
pub struct DiskCuts {
    /// The surface opened along old and new cuts: every patch a disk.
    pub opened: OpenedMesh,
    /// The edges added, as pairs of points: the last ones of [`CutMesh::cut_edges`].
    pub edges: Vec<[u32; 2]>,
    /// Their length, in the unit of the positions.
    pub length: f64,
    /// Number of patches that were no disks.
    pub patches: usize,
}

/// How many base vertices are tried on a closed patch with handles. One leaves cuts 1 % longer (rocker arm) and, by luck, far
/// more on other surfaces; twelve gain nothing that replacing stretches does not find as well.
const BASES: usize = 4;

/// How many times each stretch of a cut is replaced by a shorter one at most. The first round gains up to 20 % (armchair), the
/// second 3 % and the third 1 % (double torus), three more nothing.
const ROUNDS: usize = 3;

/// Adds cuts until every patch is a disk: Euler characteristic 1, one boundary loop.
///
/// **Takes** a refined mesh, cut or not, and where its points lie in space, in any unit. A dangling cut should have two edges
/// or more (one alone opens nothing).
/// **Gives** the cuts added, also appended to `cut.cut_edges`. They run along edges of the triangulation, begin and end on
/// the boundary of their patch or on each other, and never run along it.
/// **Fails** if the triangles form no manifold. **Costs** O(n log n) for a patch without handles, else O(n log n) for each of its
/// arcs; no more than opening where all patches are disks already.
/// **From** [EW05] (Erickson, Whittlesey: Greedy optimal homotopy and homology generators). **Differs**: arcs from the whole boundary
/// at once, and the replacing of stretches.
///
/// ```
/// use cutflow::mesh::{CutMesh, Mesh};
/// use cutflow::methods::cutgraph::cut_to_disks;
/// use nalgebra::Point3;
/// // The octahedron is a sphere: two edges cut it to a disk.
/// let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
/// let mut cut = CutMesh::uncut(&Mesh::new(6, &faces)?);
/// let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
/// let added = cut_to_disks(&mut cut, &[x, -x, y, -y, z, -z])?;
/// assert_eq!(added.edges.len(), 2);
/// assert_eq!(added.opened.patch_shapes(), [(1, 1)]);
/// # Ok::<(), cutflow::mesh::MeshError>(())
/// ```
pub fn cut_to_disks(cut: &mut CutMesh, positions: &[Point3<f64>]) -> Result<DiskCuts, MeshError> {
    assert_eq!(positions.len(), cut.points.len());
    let opened = cut.open()?;
    let shapes = opened.patch_shapes();
    let mut faces: Vec<Vec<FaceId>> = vec![Vec::new(); shapes.len()];
    for (f, &patch) in opened.face_patches.iter().enumerate() {
        if shapes[patch as usize] != (1, 1) {
            faces[patch as usize].push(FaceId::from(f));
        }
    }
    let patches = faces.iter().filter(|faces| !faces.is_empty()).count();
    if patches == 0 {
        return Ok(DiskCuts { opened, edges: Vec::new(), length: 0.0, patches });
    }
    let point = |v: VertexId| opened.vertex_points[v.index()];
    let mut surgeon = Surgeon::new(&opened.mesh, |v| positions[point(v) as usize]);
    let mut added = Vec::new();
    for (faces, shape) in faces.into_iter().zip(shapes).filter(|(faces, _)| !faces.is_empty()) {
        let patch = Patch::new(&opened.mesh, faces);
        added.extend(match shape {
            (2, 0) => surgeon.slit(&patch),
            (_, 0) => surgeon.cut_closed(&patch),
            (euler, loops) => surgeon.cut_bounded(&patch, euler + loops as i64 != 2),
        });
    }
    let length = surgeon.total_length(&added);
    let edges: Vec<[u32; 2]> =
        added.into_iter().map(|e| opened.mesh.edge_vertices(e).map(point)).collect();
    cut.cut_edges.extend_from_slice(&edges);
    let opened = cut.open()?;
    Ok(DiskCuts { opened, edges, length, patches })
}

/// One component of the opened surface.
struct Patch {
    faces: Vec<FaceId>,
    /// Ascending.
    vertices: Vec<VertexId>,
    /// Those between two faces, ascending.
    inner_edges: Vec<EdgeId>,
}

impl Patch {
    fn new(mesh: &Mesh, faces: Vec<FaceId>) -> Self {
        let mut vertices: Vec<VertexId> =
            faces.iter().flat_map(|&f| mesh.face_vertices(f)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut inner_edges: Vec<EdgeId> = faces
            .iter()
            .flat_map(|&f| mesh.face_halfedges(f))
            .map(HalfedgeId::edge)
            .filter(|&e| !mesh.is_boundary_edge(e))
            .collect();
        inner_edges.sort_unstable();
        inner_edges.dedup();
        Self { faces, vertices, inner_edges }
    }
}

/// Marks cuts on the opened surface, with memory for all patches.
struct Surgeon<'a> {
    mesh: &'a Mesh,
    /// Of every edge.
    lengths: Vec<f64>,
    /// For every edge whether a cut was added along it.
    is_cut: Vec<bool>,
    /// For every vertex the length of the shortest path to it from the sources.
    distances: Vec<f64>,
    /// For every vertex the last halfedge of that path.
    arrivals: Vec<Option<HalfedgeId>>,
    /// For every edge whether the faces beside it may be joined.
    is_open: Vec<bool>,
    /// For every face its parent in a set of faces that hang together.
    parents: Vec<FaceId>,
    heap: BinaryHeap<Reverse<(u64, VertexId)>>,
}

impl<'a> Surgeon<'a> {
    fn new(mesh: &'a Mesh, place: impl Fn(VertexId) -> Point3<f64>) -> Self {
        let length = |e| {
            let [a, b] = mesh.edge_vertices(e);
            (place(b) - place(a)).norm()
        };
        Self {
            mesh,
            lengths: mesh.edges().map(length).collect(),
            is_cut: vec![false; mesh.edge_count()],
            distances: vec![f64::INFINITY; mesh.vertex_count()],
            arrivals: vec![None; mesh.vertex_count()],
            is_open: vec![false; mesh.edge_count()],
            parents: mesh.faces().collect(),
            heap: BinaryHeap::new(),
        }
    }

    /// Cuts a patch that has a boundary.
    fn cut_bounded(&mut self, patch: &Patch, has_handles: bool) -> Vec<EdgeId> {
        self.cut_greedily(patch, None);
        if has_handles {
            self.shorten(patch);
        }
        self.take_cuts(patch)
    }

    /// Cuts a closed patch that has handles.
    fn cut_closed(&mut self, patch: &Patch) -> Vec<EdgeId> {
        let mut best: Option<(f64, Vec<EdgeId>)> = None;
        // Distance to the nearest base so far, so that the next one is far from all.
        let mut nearest = vec![f64::INFINITY; patch.vertices.len()];
        let mut base = patch.vertices[0];
        for trial in 0..BASES {
            self.cut_greedily(patch, Some(base));
            for (near, v) in nearest.iter_mut().zip(&patch.vertices) {
                *near = near.min(self.distances[v.index()]);
            }
            base = patch.vertices[farthest(&nearest)];
            if trial == 0 {
                // The first base only leads to a far vertex, where a second look is worth more.
                nearest.fill(f64::INFINITY);
            }
            self.prune(patch);
            let loops = self.take_cuts(patch);
            let length = self.total_length(&loops);
            if best.as_ref().is_none_or(|&(shortest, _)| length < shortest) {
                best = Some((length, loops));
            }
        }
        if let Some((_, loops)) = best {
            self.mark(&loops, true);
        }
        self.shorten(patch);
        self.take_cuts(patch)
    }

    /// Cuts a sphere along a path between two far vertices.
    fn slit(&mut self, patch: &Patch) -> Vec<EdgeId> {
        let mut ends = [patch.vertices[0]; 2];
        for _ in 0..2 {
            self.measure(patch, Some(ends[1]));
            let distances: Vec<f64> =
                patch.vertices.iter().map(|v| self.distances[v.index()]).collect();
            ends = [ends[1], patch.vertices[farthest(&distances)]];
        }
        let mesh = self.mesh;
        let mut path = Vec::new();
        let mut v = ends[1];
        while let Some(h) = self.arrivals[v.index()] {
            path.push(h.edge());
            v = mesh.tail(h);
        }
        if let [edge] = path[..] {
            // An edge alone has no vertex that opens: go on along another one.
            path.extend(mesh.outgoing(ends[1]).map(HalfedgeId::edge).find(|&e| e != edge));
        }
        path
    }

    /// Cuts the patch, as it is cut now, to a disk.
    ///
    /// **Takes** a patch with boundary, or else a base vertex to stand for it.
    fn cut_greedily(&mut self, patch: &Patch, base: Option<VertexId>) {
        self.measure(patch, base);
        let mesh = self.mesh;
        for e in &patch.inner_edges {
            self.is_open[e.index()] = !self.is_cut[e.index()];
        }
        for v in &patch.vertices {
            if let Some(h) = self.arrivals[v.index()] {
                self.is_open[h.edge().index()] = false;
            }
        }
        self.close_branches(patch);
        // Kruskal's algorithm, longest arc first; ties by number.
        let mut candidates: Vec<(Reverse<u64>, EdgeId)> = Vec::new();
        for &e in patch.inner_edges.iter().filter(|e| self.is_open[e.index()]) {
            let [u, v] = mesh.edge_vertices(e).map(|v| self.distances[v.index()]);
            candidates.push((Reverse((u + self.lengths[e.index()] + v).to_bits()), e));
        }
        candidates.sort_unstable();
        for &f in &patch.faces {
            self.parents[f.index()] = f;
        }
        for (_, e) in candidates {
            let h = e.halfedge();
            if let (Some(f), Some(g)) = (mesh.face(h), mesh.face(h.twin()))
                && !self.join(f, g)
            {
                self.cut_arc(e);
            }
        }
    }

    /// Cuts along an edge and the shortest paths to its ends.
    fn cut_arc(&mut self, e: EdgeId) {
        self.is_cut[e.index()] = true;
        for v in self.mesh.edge_vertices(e) {
            let mut v = v;
            while let Some(h) = self.arrivals[v.index()]
                && !self.is_cut[h.edge().index()]
            {
                self.is_cut[h.edge().index()] = true;
                v = self.mesh.tail(h);
            }
        }
    }

    /// Closes the open edges that lie on no cycle of the dual graph's branches: only the few others are left to choose from.
    fn close_branches(&mut self, patch: &Patch) {
        let mesh = self.mesh;
        let is_leaf = |is_open: &[bool], f: FaceId| {
            mesh.face_halfedges(f).into_iter().filter(|h| is_open[h.edge().index()]).count() == 1
        };
        let mut leaves: Vec<FaceId> =
            patch.faces.iter().copied().filter(|&f| is_leaf(&self.is_open, f)).collect();
        while let Some(f) = leaves.pop() {
            let open = mesh.face_halfedges(f).into_iter().find(|h| self.is_open[h.edge().index()]);
            if let Some(h) = open {
                self.is_open[h.edge().index()] = false;
                leaves.extend(mesh.face(h.twin()).filter(|&g| is_leaf(&self.is_open, g)));
            }
        }
    }

    /// Shortest paths (Dijkstra) to the vertices of a patch from its boundary and cuts, or from a base vertex as well.
    fn measure(&mut self, patch: &Patch, base: Option<VertexId>) {
        let mesh = self.mesh;
        for &v in &patch.vertices {
            let is_source = mesh.is_boundary_vertex(v) || Some(v) == base;
            self.distances[v.index()] = if is_source { 0.0 } else { f64::INFINITY };
            self.arrivals[v.index()] = None;
        }
        for e in patch.inner_edges.iter().filter(|e| self.is_cut[e.index()]) {
            for v in mesh.edge_vertices(*e) {
                self.distances[v.index()] = 0.0;
            }
        }
        let sources = patch.vertices.iter().filter(|v| self.distances[v.index()] == 0.0);
        self.heap.extend(sources.map(|&v| Reverse((0, v))));
        while let Some(Reverse((bits, v))) = self.heap.pop() {
            // Numbers that are not negative are ordered as their bits are.
            let distance = f64::from_bits(bits);
            if distance > self.distances[v.index()] {
                continue;
            }
            for h in mesh.outgoing(v) {
                let tip = mesh.tip(h);
                let candidate = distance + self.lengths[h.edge().index()];
                if candidate < self.distances[tip.index()] {
                    self.distances[tip.index()] = candidate;
                    self.arrivals[tip.index()] = Some(h);
                    self.heap.push(Reverse((candidate.to_bits(), tip)));
                }
            }
        }
    }

    /// Joins the sets of two faces; false where they are one already.
    fn join(&mut self, f: FaceId, g: FaceId) -> bool {
        let [f, g] = [f, g].map(|face| {
            let mut face = face;
            while self.parents[face.index()] != face {
                let above = self.parents[self.parents[face.index()].index()];
                self.parents[face.index()] = above;
                face = above;
            }
            face
        });
        self.parents[f.max(g).index()] = f.min(g);
        f != g
    }

    /// Replaces each stretch of the patch's cut by a shorter one where there is one.
    fn shorten(&mut self, patch: &Patch) {
        let mut cuts = self.cuts(patch);
        let mut length = self.total_length(&cuts);
        for _ in 0..ROUNDS {
            let mut has_gained = false;
            for stretch in self.stretches(&cuts) {
                if !stretch.iter().all(|e| self.is_cut[e.index()]) {
                    continue;
                }
                // What is left makes an annulus of the patch.
                self.mark(&stretch, false);
                self.prune(patch);
                self.cut_greedily(patch, None);
                let others = self.cuts(patch);
                let other_length = self.total_length(&others);
                if other_length < length * (1.0 - 1e-9) {
                    (cuts, length) = (others, other_length);
                    has_gained = true;
                } else {
                    self.mark(&others, false);
                    self.mark(&cuts, true);
                }
            }
            if !has_gained {
                break;
            }
        }
    }

    /// Cuts between junctions, the longest first.
    fn stretches(&self, cuts: &[EdgeId]) -> Vec<Vec<EdgeId>> {
        let mesh = self.mesh;
        let pairs: Vec<[u32; 2]> =
            cuts.iter().map(|&e| mesh.edge_vertices(e).map(|v| v.0)).collect();
        let edge = |pair: &[u32]| {
            let tip = VertexId(pair[1]);
            mesh.outgoing(VertexId(pair[0])).find(|&h| mesh.tip(h) == tip).map(HalfedgeId::edge)
        };
        let mut stretches: Vec<Vec<EdgeId>> =
            chains(&pairs, |v| mesh.is_boundary_vertex(VertexId(v)))
                .into_iter()
                .map(|chain| chain.windows(2).filter_map(edge).collect())
                .collect();
        stretches.sort_by(|a, b| self.total_length(b).total_cmp(&self.total_length(a)));
        stretches
    }

    /// Takes back cuts that end inside the patch.
    fn prune(&mut self, patch: &Patch) {
        let mesh = self.mesh;
        let is_tip = |surgeon: &Self, v: VertexId| {
            let is_cut = |h: &HalfedgeId| surgeon.is_cut[h.edge().index()];
            !mesh.is_boundary_vertex(v) && mesh.outgoing(v).filter(is_cut).count() == 1
        };
        let mut tips: Vec<VertexId> =
            self.cuts(patch).into_iter().flat_map(|e| mesh.edge_vertices(e)).collect();
        tips.retain(|&v| is_tip(self, v));
        while let Some(v) = tips.pop() {
            // Two tips may have met: then nothing is left here.
            if let Some(h) = mesh.outgoing(v).find(|h| self.is_cut[h.edge().index()]) {
                self.is_cut[h.edge().index()] = false;
                tips.extend(Some(mesh.tip(h)).filter(|&v| is_tip(self, v)));
            }
        }
    }

    /// The cuts of a patch, ascending.
    fn cuts(&self, patch: &Patch) -> Vec<EdgeId> {
        patch.inner_edges.iter().copied().filter(|e| self.is_cut[e.index()]).collect()
    }

    /// The cuts of a patch, which are taken back.
    fn take_cuts(&mut self, patch: &Patch) -> Vec<EdgeId> {
        let cuts = self.cuts(patch);
        self.mark(&cuts, false);
        cuts
    }

    fn mark(&mut self, edges: &[EdgeId], is_cut: bool) {
        for e in edges {
            self.is_cut[e.index()] = is_cut;
        }
    }

    fn total_length(&self, edges: &[EdgeId]) -> f64 {
        edges.iter().map(|e| self.lengths[e.index()]).sum()
    }
}

/// Index of the largest finite number, the first of equals.
fn farthest(distances: &[f64]) -> usize {
    let finite = distances.iter().enumerate().filter(|(_, d)| d.is_finite()).rev();
    finite.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(i, _)| i)
}
