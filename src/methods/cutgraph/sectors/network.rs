//! Seams with the sectors that they leave, and the ways to divide those.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{PI, TAU};

use super::super::Seams;
use super::WIDEST;
use crate::geometry::Geometry;
use crate::mesh::{EdgeId, FaceId, HalfedgeId, Mesh, VertexId};

/// A sector is divided between these fractions of it, by the shortest path that there is; closer to the middle, and paths get longer.
const MIDDLE: [f64; 2] = [0.3, 0.7];

/// How many ends of a path are tried before a chart is parted for good.
const TRIES: usize = 16;

/// How much longer than the shortest path another one may be that saves a chart.
const DETOUR: f64 = 5.0;

/// Where a path may end.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ends {
    /// On seams that are no stretches of the cone's own.
    Beyond,
    /// There, or on the boundary of the surface.
    BeyondOrBoundary,
    /// On any seam or boundary.
    Any,
}

/// The faces at a vertex between two seams.
pub(super) struct Sector {
    /// The first is the seam at its beginning, if it has one.
    halfedges: Vec<HalfedgeId>,
    /// For each of them the angle, in the flat metric, of the face that follows.
    angles: Vec<f64>,
}

impl Sector {
    pub fn angle(&self) -> f64 {
        self.angles.iter().sum()
    }
}

/// The seams of a mesh.
pub(super) struct Network<'a> {
    mesh: &'a Mesh,
    geometry: &'a Geometry,
    prices: Vec<f64>,
    pub is_cut: Vec<bool>,
    /// How many seams end at each vertex.
    degrees: Vec<u32>,
    /// For each vertex its angle in the flat metric if it is a cone.
    cone_angles: Vec<Option<f64>>,
}

impl<'a> Network<'a> {
    pub fn new(
        mesh: &'a Mesh,
        geometry: &'a Geometry,
        seams: &Seams,
        cones: &[(VertexId, f64)],
        cost: &[f64],
    ) -> Self {
        let price = |v: VertexId| cost.get(v.index()).copied().unwrap_or(0.0);
        let prices = mesh
            .edges()
            .map(|e| {
                let [a, b] = mesh.edge_vertices(e).map(price);
                geometry.edge_length(e) * (1.0 + 0.5 * (a + b))
            })
            .collect();
        let mut cone_angles = vec![None; mesh.vertex_count()];
        for &(v, curvature) in cones {
            let flat = if mesh.is_boundary_vertex(v) { PI } else { TAU };
            cone_angles[v.index()] = Some(flat - curvature);
        }
        let mut network = Self {
            mesh,
            geometry,
            prices,
            is_cut: vec![false; mesh.edge_count()],
            degrees: vec![0; mesh.vertex_count()],
            cone_angles,
        };
        for &[a, b] in &seams.cut.cut_edges {
            let h = mesh.outgoing(VertexId(a)).find(|&h| mesh.tip(h) == VertexId(b));
            if let Some(h) = h {
                network.mark(&[h.edge()], true);
            }
        }
        network
    }

    fn mark(&mut self, edges: &[EdgeId], is_cut: bool) {
        for &e in edges {
            if self.is_cut[e.index()] != is_cut && !self.mesh.is_boundary_edge(e) {
                self.is_cut[e.index()] = is_cut;
                for v in self.mesh.edge_vertices(e) {
                    let degree = &mut self.degrees[v.index()];
                    *degree = if is_cut { *degree + 1 } else { *degree - 1 };
                }
            }
        }
    }

    /// Angle about a cone; 0 about other vertices.
    pub fn total(&self, v: VertexId) -> f64 {
        self.cone_angles[v.index()].unwrap_or(0.0)
    }

    /// The sectors about a cone.
    pub fn sectors(&self, v: VertexId) -> Vec<Sector> {
        let mesh = self.mesh;
        let mut turn: Vec<(HalfedgeId, f64)> = Vec::new();
        for h in mesh.outgoing(v) {
            let Some(f) = mesh.face(h) else { continue };
            let corner = mesh.face_vertices(f).iter().position(|&w| w == v).unwrap_or(0);
            turn.push((h, self.geometry.corner_angles[f.index()][corner]));
        }
        if !mesh.is_boundary_vertex(v) {
            let first = turn.iter().position(|(h, _)| self.is_cut[h.edge().index()]);
            turn.rotate_left(first.unwrap_or(0));
        }
        let scale = self.total(v) / turn.iter().map(|t| t.1).sum::<f64>();
        let mut sectors: Vec<Sector> = Vec::new();
        for (i, (h, angle)) in turn.into_iter().enumerate() {
            if i == 0 || self.is_cut[h.edge().index()] {
                sectors.push(Sector { halfedges: Vec::new(), angles: Vec::new() });
            }
            if let Some(sector) = sectors.last_mut() {
                sector.halfedges.push(h);
                sector.angles.push(angle * scale);
            }
        }
        sectors
    }

    /// Whether all sectors about a vertex are narrow enough, if it is a cone that can be too wide.
    pub fn is_parted(&self, v: VertexId) -> bool {
        self.total(v) <= TAU * (1.0 + 1e-9) || self.sectors(v).iter().all(|s| s.angle() <= WIDEST)
    }

    /// Divides the widest sector about a cone. **Gives** whether the parts could be joined elsewhere; nothing where no path divides it.
    ///
    /// A path to seams beyond the cone's own stretches closes a cycle that may have another stretch to give up. If the nearest has none,
    /// farther ones are tried, on other stretches each; at last two charts are made of one.
    pub fn divide(&mut self, v: VertexId) -> Option<bool> {
        let mut longest = f64::INFINITY;
        for ends in [Ends::Beyond, Ends::BeyondOrBoundary] {
            let mut is_end = self.ends(v, ends);
            for _ in 0..TRIES {
                let Some(path) = self.dividing_path(v, &is_end) else { break };
                let price: f64 = path.iter().map(|h| self.prices[h.edge().index()]).sum();
                longest = longest.min(DETOUR * price);
                if price > longest {
                    break;
                }
                if self.lead_through(v, &path) {
                    return Some(true);
                }
                let edges: Vec<EdgeId> = path.iter().map(|h| h.edge()).collect();
                self.mark(&edges, false);
                let Some(last) = path.last() else { break };
                self.exclude_stretch(self.mesh.tip(*last), &mut is_end);
            }
        }
        // A path back to the cone's own stretch divides it in its neighbourhood only: what is around that winds about it still.
        let mut paths = [Ends::BeyondOrBoundary, Ends::Any]
            .into_iter()
            .filter_map(|ends| self.dividing_path(v, &self.ends(v, ends)));
        let path = paths.next()?;
        drop(paths);
        Some(self.lead_through(v, &path))
    }

    /// Lets no path end on the stretch that a vertex is on.
    fn exclude_stretch(&self, w: VertexId, is_end: &mut [bool]) {
        is_end[w.index()] = false;
        let mut stack = vec![w];
        while let Some(x) = stack.pop().filter(|&x| !self.is_stop(x)) {
            for h in self.mesh.outgoing(x).filter(|h| self.is_cut[h.edge().index()]) {
                let tip = self.mesh.tip(h);
                if is_end[tip.index()] && !self.is_stop(tip) {
                    is_end[tip.index()] = false;
                    stack.push(tip);
                }
            }
        }
    }

    /// A shortest path that divides the widest sector about a cone; none where all are narrow enough, or no edge divides it.
    fn dividing_path(&self, v: VertexId, is_end: &[bool]) -> Option<Vec<HalfedgeId>> {
        // Without seams the one sector has no borders, and a path could end anywhere.
        if self.is_parted(v) || (self.degrees[v.index()] == 0 && !self.mesh.is_boundary_vertex(v)) {
            return None;
        }
        let sectors = self.sectors(v);
        let widest = sectors.iter().max_by(|a, b| a.angle().total_cmp(&b.angle()))?;
        let whole = widest.angle();
        let mut before = 0.0;
        // Where each edge of the sector divides it.
        let mut parts: Vec<(HalfedgeId, f64)> = Vec::new();
        for (h, angle) in widest.halfedges.iter().zip(&widest.angles) {
            if before > 0.0 {
                parts.push((*h, before / whole));
            }
            before += angle;
        }
        let is_middle = |part: f64| (MIDDLE[0]..=MIDDLE[1]).contains(&part);
        // Between one and two full turns only the middle is narrow enough on both sides.
        let is_narrow = |part: f64| part.max(1.0 - part) * whole <= WIDEST;
        let rules: [&dyn Fn(f64) -> bool; 2] =
            [&|part| is_middle(part) && is_narrow(part), &is_middle];
        for rule in rules {
            let starts: Vec<HalfedgeId> =
                parts.iter().filter(|(_, part)| rule(*part)).map(|(h, _)| *h).collect();
            if let Some(path) = self.shortest_path(is_end, v, &starts) {
                return Some(path);
            }
        }
        let off = |part: f64| (part - 0.5).abs();
        let (nearest, _) = parts.iter().min_by(|a, b| off(a.1).total_cmp(&off(b.1)))?;
        self.shortest_path(is_end, v, &[*nearest])
    }

    /// For each vertex whether a path from a cone may end there.
    fn ends(&self, v: VertexId, ends: Ends) -> Vec<bool> {
        let mesh = self.mesh;
        let mut is_end: Vec<bool> = mesh
            .vertices()
            .map(|w| self.degrees[w.index()] > 0 || mesh.is_boundary_vertex(w))
            .collect();
        if ends == Ends::Any {
            return is_end;
        }
        if ends == Ends::Beyond {
            mesh.vertices()
                .filter(|&w| mesh.is_boundary_vertex(w))
                .for_each(|w| is_end[w.index()] = false);
        }
        for start in mesh.outgoing(v).filter(|h| self.is_cut[h.edge().index()]) {
            let mut last = start;
            loop {
                is_end[mesh.tip(last).index()] = false;
                if self.is_stop(mesh.tip(last)) {
                    break;
                }
                let on = mesh
                    .outgoing(mesh.tip(last))
                    .find(|h| h.edge() != last.edge() && self.is_cut[h.edge().index()]);
                let Some(next) = on else { break };
                last = next;
            }
        }
        is_end
    }

    /// The shortest path from a vertex to an end, beginning with one of some halfedges, that meets no seam or boundary on its way.
    fn shortest_path(
        &self,
        is_end: &[bool],
        from: VertexId,
        starts: &[HalfedgeId],
    ) -> Option<Vec<HalfedgeId>> {
        let mesh = self.mesh;
        let mut distances = vec![f64::INFINITY; mesh.vertex_count()];
        let mut arrivals: Vec<Option<HalfedgeId>> = vec![None; mesh.vertex_count()];
        let mut heap: BinaryHeap<Reverse<(u64, VertexId)>> = BinaryHeap::new();
        distances[from.index()] = 0.0;
        let mut go =
            |h: HalfedgeId, distance: f64, heap: &mut BinaryHeap<_>, distances: &mut [f64]| {
                let tip = mesh.tip(h);
                let candidate = distance + self.prices[h.edge().index()];
                if candidate < distances[tip.index()] {
                    distances[tip.index()] = candidate;
                    arrivals[tip.index()] = Some(h);
                    heap.push(Reverse((candidate.to_bits(), tip)));
                }
            };
        for &h in starts.iter().filter(|h| !mesh.is_boundary_edge(h.edge())) {
            go(h, 0.0, &mut heap, &mut distances);
        }
        let mut end = None;
        while let Some(Reverse((bits, v))) = heap.pop() {
            let distance = f64::from_bits(bits);
            if distance > distances[v.index()] {
                continue;
            }
            if is_end[v.index()] {
                end = Some(v);
                break;
            }
            if self.degrees[v.index()] > 0 || mesh.is_boundary_vertex(v) {
                continue;
            }
            for h in mesh.outgoing(v) {
                go(h, distance, &mut heap, &mut distances);
            }
        }
        let mut path = Vec::new();
        let mut v = end?;
        while let Some(h) = arrivals[v.index()] {
            path.push(h);
            v = mesh.tail(h);
        }
        path.reverse();
        (!path.is_empty()).then_some(path)
    }

    /// Adds a path of seams, and gives up the dearest stretch that is needed no more. **Gives** whether there was one.
    fn lead_through(&mut self, v: VertexId, path: &[HalfedgeId]) -> bool {
        let edges: Vec<EdgeId> = path.iter().map(|h| h.edge()).collect();
        self.mark(&edges, true);
        let Some(first) = path.first() else { return false };
        let mesh = self.mesh;
        let sides = [*first, first.twin()].map(|h| mesh.face(h));
        let [Some(left), Some(right)] = sides else { return false };
        let is_left = self.part_of(left);
        if is_left[right.index()] {
            // Nothing was parted: the path came to another component of the boundary.
            return true;
        }
        let is_right = self.part_of(right);
        let is_between = |e: EdgeId| {
            let faces = [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h));
            let [Some(f), Some(g)] = faces else { return false };
            (is_left[f.index()] && is_right[g.index()])
                || (is_left[g.index()] && is_right[f.index()])
        };
        let mut stretches = self.stretches_where(is_between);
        stretches.retain(|stretch| !stretch.iter().any(|h| edges.contains(&h.edge())));
        let price = |stretch: &Vec<HalfedgeId>| -> f64 {
            stretch.iter().map(|h| self.prices[h.edge().index()]).sum()
        };
        let mut order: Vec<(u64, usize)> = stretches
            .iter()
            .enumerate()
            .map(|(i, stretch)| (price(stretch).to_bits(), i))
            .collect();
        order.sort_unstable_by_key(|&(bits, i)| (Reverse(bits), i));
        for (_, i) in order {
            let stretch: Vec<EdgeId> = stretches[i].iter().map(|h| h.edge()).collect();
            let (Some(start), Some(end)) = (stretches[i].first(), stretches[i].last()) else {
                continue;
            };
            self.mark(&stretch, false);
            let is_fine = [mesh.tail(*start), mesh.tip(*end)].into_iter().all(|w| {
                let is_cone = self.cone_angles[w.index()].is_some();
                let is_on_rim = self.degrees[w.index()] > 0 || mesh.is_boundary_vertex(w);
                (!is_cone || is_on_rim)
                    && (self.is_parted(w) || w != v && self.was_wide(w, &stretch))
            });
            if is_fine {
                return true;
            }
            self.mark(&stretch, true);
        }
        false
    }

    /// Whether a cone was too wide with a stretch as well, and ends of seams that it had are enough to be divided later.
    fn was_wide(&mut self, w: VertexId, stretch: &[EdgeId]) -> bool {
        self.mark(stretch, true);
        let was_parted = self.is_parted(w);
        self.mark(stretch, false);
        !was_parted
    }

    /// The faces that hang together with one.
    fn part_of(&self, face: FaceId) -> Vec<bool> {
        let mesh = self.mesh;
        let mut is_in = vec![false; mesh.face_count()];
        is_in[face.index()] = true;
        let mut stack = vec![face];
        while let Some(f) = stack.pop() {
            for h in mesh.face_halfedges(f) {
                if self.is_cut[h.edge().index()] {
                    continue;
                }
                if let Some(g) = mesh.face(h.twin()).filter(|g| !is_in[g.index()]) {
                    is_in[g.index()] = true;
                    stack.push(g);
                }
            }
        }
        is_in
    }

    /// Whether a seam cannot go on past a vertex without notice: a cone, a junction, an end, the boundary.
    fn is_stop(&self, v: VertexId) -> bool {
        self.degrees[v.index()] != 2
            || self.cone_angles[v.index()].is_some()
            || self.mesh.is_boundary_vertex(v)
    }

    /// Stretches of seam between stops, of edges with a property that all edges of a stretch share.
    fn stretches_where(&self, has: impl Fn(EdgeId) -> bool) -> Vec<Vec<HalfedgeId>> {
        let mesh = self.mesh;
        let mut is_done = vec![false; mesh.edge_count()];
        let mut stretches = Vec::new();
        for v in mesh.vertices().filter(|&v| self.degrees[v.index()] > 0 && self.is_stop(v)) {
            for start in mesh.outgoing(v) {
                let e = start.edge();
                if !self.is_cut[e.index()] || is_done[e.index()] || !has(e) {
                    continue;
                }
                let mut stretch = vec![start];
                is_done[e.index()] = true;
                let mut last = start;
                while !self.is_stop(mesh.tip(last)) {
                    let on = mesh
                        .outgoing(mesh.tip(last))
                        .find(|h| h.edge() != last.edge() && self.is_cut[h.edge().index()]);
                    let Some(next) = on.filter(|h| !is_done[h.edge().index()]) else { break };
                    is_done[next.edge().index()] = true;
                    stretch.push(next);
                    last = next;
                }
                stretches.push(stretch);
            }
        }
        stretches
    }
}
