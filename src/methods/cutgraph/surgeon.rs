//! Cuts on one component after another, marked on its edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::mesh::{EdgeId, FaceId, HalfedgeId, Mesh, VertexId, chains};

/// How many base vertices are tried on a closed patch with handles. One leaves cuts 1 % longer (rocker arm) and, by luck, far
/// more on other surfaces; twelve gain nothing that replacing stretches does not find as well.
const BASES: usize = 4;

/// How many times each stretch of a cut is replaced by a shorter one at most. The first round gains up to 20 % (armchair), the
/// second 3 % and the third 1 % (double torus), three more nothing.
const ROUNDS: usize = 3;

/// One component of the opened surface.
pub(super) struct Patch {
    pub faces: Vec<FaceId>,
    /// Ascending.
    pub vertices: Vec<VertexId>,
    /// Those between two faces, ascending.
    pub inner_edges: Vec<EdgeId>,
}

impl Patch {
    pub fn new(mesh: &Mesh, faces: Vec<FaceId>) -> Self {
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
pub(super) struct Surgeon<'a> {
    pub mesh: &'a Mesh,
    /// Of every edge, or what a cut along it costs.
    pub lengths: Vec<f64>,
    /// For every edge whether a cut was added along it.
    pub is_cut: Vec<bool>,
    /// For every vertex whether cuts have to reach it.
    pub is_terminal: Vec<bool>,
    /// For every vertex the length of the shortest path to it from the sources.
    pub distances: Vec<f64>,
    /// For every vertex the last halfedge of that path.
    pub arrivals: Vec<Option<HalfedgeId>>,
    /// For every edge whether the faces beside it may be joined.
    is_open: Vec<bool>,
    /// For every face its parent in a set of faces that hang together.
    parents: Vec<FaceId>,
    pub heap: BinaryHeap<Reverse<(u64, VertexId)>>,
}

impl<'a> Surgeon<'a> {
    pub fn new(mesh: &'a Mesh, lengths: Vec<f64>) -> Self {
        Self {
            mesh,
            lengths,
            is_cut: vec![false; mesh.edge_count()],
            is_terminal: vec![false; mesh.vertex_count()],
            distances: vec![f64::INFINITY; mesh.vertex_count()],
            arrivals: vec![None; mesh.vertex_count()],
            is_open: vec![false; mesh.edge_count()],
            parents: mesh.faces().collect(),
            heap: BinaryHeap::new(),
        }
    }

    /// Cuts a patch of Euler characteristic χ with some boundary loops to a disk, through its terminals.
    pub fn cut(&mut self, patch: &Patch, (euler, loops): (i64, usize)) -> Vec<EdgeId> {
        let mut terminals = patch.vertices.iter().filter(|v| self.is_terminal[v.index()]);
        let has_handles = euler + loops as i64 != 2;
        match (terminals.next(), terminals.next(), loops) {
            (None, _, 0) if has_handles => self.cut_closed(patch),
            (None, _, 0) => self.slit(patch, None),
            (None, _, 1) if !has_handles => Vec::new(),
            (None, ..) => self.cut_bounded(patch, has_handles),
            (Some(&v), None, 0) if !has_handles => self.slit(patch, Some(v)),
            (Some(_), _, loops) => {
                self.cut_greedily(patch, None);
                self.exchange(patch, !has_handles);
                let mut cuts = self.take_cuts(patch);
                if loops == 0 {
                    self.lengthen(&mut cuts);
                }
                cuts
            }
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

    /// Cuts a sphere along a path between two far vertices, or from one to a vertex far from it.
    fn slit(&mut self, patch: &Patch, from: Option<VertexId>) -> Vec<EdgeId> {
        let mut ends = [from.unwrap_or(patch.vertices[0]); 2];
        for _ in 0..if from.is_some() { 1 } else { 2 } {
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
        self.lengthen(&mut path);
        path
    }

    /// Goes on along another edge where a cut inside is one edge: alone it has no vertex that opens.
    fn lengthen(&self, cut: &mut Vec<EdgeId>) {
        if let [edge] = cut[..] {
            let [_, tip] = self.mesh.edge_vertices(edge);
            let others = self.mesh.outgoing(tip).map(HalfedgeId::edge).filter(|&e| e != edge);
            let length = |e: &EdgeId| self.lengths[e.index()];
            cut.extend(others.min_by(|a, b| length(a).total_cmp(&length(b))));
        }
    }

    /// Whether cuts end at a vertex whatever meets there.
    pub fn is_stop(&self, v: VertexId) -> bool {
        self.mesh.is_boundary_vertex(v) || self.is_terminal[v.index()]
    }

    /// Cuts the patch, as it is cut now, to a disk.
    ///
    /// **Takes** a patch with boundary or terminals, or else a base vertex to stand for them.
    pub fn cut_greedily(&mut self, patch: &Patch, base: Option<VertexId>) {
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

    /// Shortest paths (Dijkstra) to the vertices of a patch from its boundary, cuts and terminals, or from a base vertex as well.
    pub fn measure(&mut self, patch: &Patch, base: Option<VertexId>) {
        let mesh = self.mesh;
        for &v in &patch.vertices {
            let is_source = self.is_stop(v) || Some(v) == base;
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
    pub fn shorten(&mut self, patch: &Patch) {
        let mut cuts = self.cuts(patch);
        let mut length = self.total_length(&cuts);
        for _ in 0..ROUNDS {
            let mut has_gained = false;
            for stretch in self.stretches(&cuts) {
                has_gained |= self.replace_stretch(patch, &stretch, &mut cuts, &mut length);
            }
            if !has_gained {
                break;
            }
        }
    }

    /// Replaces a stretch of the patch's cut, as far as it is still one, if that makes the cut shorter.
    pub fn replace_stretch(
        &mut self,
        patch: &Patch,
        stretch: &[EdgeId],
        cuts: &mut Vec<EdgeId>,
        length: &mut f64,
    ) -> bool {
        if !stretch.iter().all(|e| self.is_cut[e.index()]) {
            return false;
        }
        // What is left makes an annulus of the patch.
        self.mark(stretch, false);
        self.prune(patch);
        self.cut_greedily(patch, None);
        let others = self.cuts(patch);
        let other_length = self.total_length(&others);
        let is_shorter = other_length < *length * (1.0 - 1e-9);
        if is_shorter {
            (*cuts, *length) = (others, other_length);
        } else {
            self.mark(&others, false);
            self.mark(cuts, true);
        }
        is_shorter
    }

    /// Cuts between junctions and terminals, the longest first.
    pub fn stretches(&self, cuts: &[EdgeId]) -> Vec<Vec<EdgeId>> {
        let mesh = self.mesh;
        let pairs: Vec<[u32; 2]> =
            cuts.iter().map(|&e| mesh.edge_vertices(e).map(|v| v.0)).collect();
        let edge = |pair: &[u32]| {
            let tip = VertexId(pair[1]);
            mesh.outgoing(VertexId(pair[0])).find(|&h| mesh.tip(h) == tip).map(HalfedgeId::edge)
        };
        let mut stretches: Vec<Vec<EdgeId>> = chains(&pairs, |v| self.is_stop(VertexId(v)))
            .into_iter()
            .map(|chain| chain.windows(2).filter_map(edge).collect())
            .collect();
        stretches.sort_by(|a, b| self.total_length(b).total_cmp(&self.total_length(a)));
        stretches
    }

    /// Takes back cuts that end inside the patch.
    pub fn prune(&mut self, patch: &Patch) {
        let mesh = self.mesh;
        let is_tip = |surgeon: &Self, v: VertexId| {
            let is_cut = |h: &HalfedgeId| surgeon.is_cut[h.edge().index()];
            !surgeon.is_stop(v) && mesh.outgoing(v).filter(is_cut).count() == 1
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
    pub fn cuts(&self, patch: &Patch) -> Vec<EdgeId> {
        patch.inner_edges.iter().copied().filter(|e| self.is_cut[e.index()]).collect()
    }

    /// The cuts of a patch, which are taken back.
    pub fn take_cuts(&mut self, patch: &Patch) -> Vec<EdgeId> {
        let cuts = self.cuts(patch);
        self.mark(&cuts, false);
        cuts
    }

    pub fn mark(&mut self, edges: &[EdgeId], is_cut: bool) {
        for e in edges {
            self.is_cut[e.index()] = is_cut;
        }
    }

    pub fn total_length(&self, edges: &[EdgeId]) -> f64 {
        edges.iter().map(|e| self.lengths[e.index()]).sum()
    }
}

/// Index of the largest finite number, the first of equals.
fn farthest(distances: &[f64]) -> usize {
    let finite = distances.iter().enumerate().filter(|(_, d)| d.is_finite()).rev();
    finite.max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(i, _)| i)
}
