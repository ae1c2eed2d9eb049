//! Shorter networks of seams by local exchange.
//!
//! The greedy arcs between terminals (boundary loops, and points that seams have to reach) are a shortest spanning tree of them, at
//! most twice as long as the shortest network. Two exchanges lead on from there:
//!
//! * a **stretch** between two junctions or terminals is taken out, which leaves two parts, and the parts are joined along a shortest
//!   path between any of their vertices: so junctions arise;
//! * a **junction** of three stretches is taken out with them, and the three parts are joined at the best vertex.
//!
//! Both only look as far as what was taken out is long. A stretch on a cycle (around a handle) leaves one part and two rims, which
//! the greedy arcs of the whole patch join. The patch stays a disk: without a bridge it is an annulus, without a junction
//! of three bridges a disk with two holes, and paths that meet the network at their ends only cut those to disks again.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::surgeon::{Patch, Surgeon};
use crate::mesh::{EdgeId, HalfedgeId, VertexId};

/// How many rounds of exchanges there are at most. With 40 to 1 200 cones (spot, face, rocker arm, igea) the second round gains .1 to 1 %,
/// the third less than .1 %, and the fourth or fifth nothing.
const EXCHANGES: usize = 6;

/// How many stretches on cycles are tried in a round, the longest first. Each costs a look at the whole patch.
const CYCLE_TRIALS: usize = 24;

/// In how many rounds.
const CYCLE_ROUNDS: usize = 2;

/// How far along the network from where a stretch began another one may begin, in lengths of the stretch. Without a limit 1 200 cones
/// on 134 000 vertices take eight times as long, for seams .05 % shorter.
const REACH: f64 = 3.0;

/// Mark of vertices in the part that is to be joined where no path may begin.
const OWN: u8 = 4;

/// An exchange has to gain this fraction, so that rounding never goes in circles.
const GAIN: f64 = 1e-9;

/// A part of the network without junctions and terminals inside.
struct Stretch {
    ends: [VertexId; 2],
    edges: Vec<EdgeId>,
    length: f64,
}

/// What came of an exchange.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    Gained,
    Kept,
    /// The stretch lies on a cycle.
    OnCycle,
}

/// What the growth of a front does at a vertex that it has come to.
enum Growth {
    Go,
    Block,
    Stop,
}

/// Shortest paths from some vertices, as far as wanted, with memory that is cleared as it was filled.
struct Front {
    distances: Vec<f64>,
    arrivals: Vec<Option<HalfedgeId>>,
    reached: Vec<VertexId>,
    heap: BinaryHeap<Reverse<(u64, VertexId)>>,
}

impl Front {
    fn new(vertices: usize) -> Self {
        Self {
            distances: vec![f64::INFINITY; vertices],
            arrivals: vec![None; vertices],
            reached: Vec::new(),
            heap: BinaryHeap::new(),
        }
    }

    /// Grows to all vertices nearer than `bound`. **Gives** the vertex where it was told to stop.
    fn grow(
        &mut self,
        surgeon: &Surgeon,
        sources: &[VertexId],
        bound: f64,
        growth: impl Fn(VertexId) -> Growth,
    ) -> Option<VertexId> {
        self.heap.clear();
        for v in self.reached.drain(..) {
            self.distances[v.index()] = f64::INFINITY;
            self.arrivals[v.index()] = None;
        }
        for &v in sources.iter() {
            self.distances[v.index()] = 0.0;
            self.reached.push(v);
            self.heap.push(Reverse((0, v)));
        }
        while let Some(Reverse((bits, v))) = self.heap.pop() {
            // Numbers that are not negative are ordered as their bits are.
            let distance = f64::from_bits(bits);
            if distance > self.distances[v.index()] {
                continue;
            }
            match growth(v) {
                Growth::Go => {}
                Growth::Block => continue,
                Growth::Stop => return Some(v),
            }
            for h in surgeon.mesh.outgoing(v) {
                let tip = surgeon.mesh.tip(h);
                let candidate = distance + surgeon.lengths[h.edge().index()];
                if candidate < bound && candidate < self.distances[tip.index()] {
                    if self.distances[tip.index()] == f64::INFINITY {
                        self.reached.push(tip);
                    }
                    self.distances[tip.index()] = candidate;
                    self.arrivals[tip.index()] = Some(h);
                    self.heap.push(Reverse((candidate.to_bits(), tip)));
                }
            }
        }
        None
    }

    /// The halfedges from a source to a vertex, the last one first.
    fn path(&self, surgeon: &Surgeon, mut v: VertexId) -> Vec<HalfedgeId> {
        let mut path = Vec::new();
        while let Some(h) = self.arrivals[v.index()] {
            path.push(h);
            v = surgeon.mesh.tail(h);
        }
        path
    }
}

/// Memory for exchanges.
struct Exchange<'s, 'a> {
    surgeon: &'s mut Surgeon<'a>,
    fronts: [Front; 3],
    /// For every vertex the part that it was found in: 0 none, else 1 and up.
    parts: Vec<u8>,
    marked: Vec<VertexId>,
}

impl Surgeon<'_> {
    /// Shortens the cuts of a patch by local exchanges, keeping it a disk that has all terminals on its rim.
    ///
    /// **Takes** cuts that make a disk of the patch; whether cuts and boundary loops form a tree (no handles).
    pub fn exchange(&mut self, patch: &Patch, is_tree: bool) {
        let vertices = self.mesh.vertex_count();
        let mut exchange = Exchange {
            surgeon: self,
            fronts: [0; 3].map(|_| Front::new(vertices)),
            parts: vec![0; vertices],
            marked: Vec::new(),
        };
        for round in 0..EXCHANGES {
            let mut has_gained = false;
            let cuts = exchange.surgeon.cuts(patch);
            let mut on_cycles = Vec::new();
            for stretch in exchange.surgeon.stretches(&cuts) {
                match exchange.reconnect(stretch[0], is_tree) {
                    Outcome::Gained => has_gained = true,
                    Outcome::Kept => {}
                    Outcome::OnCycle => on_cycles.push(stretch),
                }
            }
            let mut cuts = exchange.surgeon.cuts(patch);
            let mut length = exchange.surgeon.total_length(&cuts);
            let trials = if round < CYCLE_ROUNDS { CYCLE_TRIALS } else { 0 };
            for stretch in on_cycles.iter().take(trials) {
                has_gained |=
                    exchange.surgeon.replace_stretch(patch, stretch, &mut cuts, &mut length);
            }
            let mut ends: Vec<VertexId> =
                cuts.iter().flat_map(|&e| exchange.surgeon.mesh.edge_vertices(e)).collect();
            ends.sort_unstable();
            ends.dedup();
            for v in ends {
                has_gained |= exchange.relocate(v, is_tree);
            }
            if !has_gained {
                break;
            }
        }
    }

    fn cuts_at(&self, v: VertexId) -> impl Iterator<Item = HalfedgeId> + '_ {
        self.mesh.outgoing(v).filter(|h| self.is_cut[h.edge().index()])
    }

    /// The stretch that runs through a cut edge; none where it is a loop without terminal.
    fn stretch_through(&self, seed: EdgeId) -> Option<Stretch> {
        let mut edges = vec![seed];
        let mut ends = self.mesh.edge_vertices(seed);
        for end in &mut ends {
            let mut last = seed;
            while !self.is_stop(*end) {
                let mut others = self.cuts_at(*end).filter(|h| h.edge() != last);
                let (Some(h), None) = (others.next(), others.next()) else { break };
                if h.edge() == seed {
                    return None;
                }
                last = h.edge();
                edges.push(last);
                *end = self.mesh.tip(h);
            }
        }
        let length = self.total_length(&edges);
        Some(Stretch { ends, edges, length })
    }

    fn is_on_network(&self, v: VertexId) -> bool {
        self.is_stop(v) || self.cuts_at(v).next().is_some()
    }
}

impl Exchange<'_, '_> {
    fn put(&mut self, v: VertexId, part: u8) {
        self.parts[v.index()] = part;
        self.marked.push(v);
    }

    fn clear_parts(&mut self) {
        for v in self.marked.drain(..) {
            self.parts[v.index()] = 0;
        }
    }

    /// The smaller of the two parts of the network that two vertices lie in, marked as part 1 (the other one in places as part 2); none
    /// where it is one part. **Costs** as much as the smaller part.
    fn smaller_part(&mut self, ends: [VertexId; 2]) -> Option<Vec<VertexId>> {
        self.clear_parts();
        if ends[0] == ends[1] {
            return None;
        }
        let mut found = ends.map(|v| vec![v]);
        self.put(ends[0], 1);
        self.put(ends[1], 2);
        let mut next = [0; 2];
        loop {
            for side in 0..2 {
                let own = if side == 0 { 1 } else { 2 };
                let Some(&v) = found[side].get(next[side]) else {
                    let part = std::mem::take(&mut found[side]);
                    for &v in &part {
                        self.parts[v.index()] = 1;
                    }
                    for &v in &found[1 - side] {
                        self.parts[v.index()] = 2;
                    }
                    return Some(part);
                };
                next[side] += 1;
                let mesh = self.surgeon.mesh;
                for h in mesh.outgoing(v) {
                    let is_joined =
                        self.surgeon.is_cut[h.edge().index()] || mesh.is_boundary_edge(h.edge());
                    let tip = mesh.tip(h);
                    let part = self.parts[tip.index()];
                    if !is_joined || part == own {
                        continue;
                    }
                    if part != 0 {
                        return None;
                    }
                    self.put(tip, own);
                    found[side].push(tip);
                }
            }
        }
    }

    /// Takes the stretch through a cut edge out, and joins the parts along a shortest path.
    fn reconnect(&mut self, seed: EdgeId, is_tree: bool) -> Outcome {
        if !self.surgeon.is_cut[seed.index()] {
            return Outcome::Kept;
        }
        let Some(stretch) = self.surgeon.stretch_through(seed) else { return Outcome::OnCycle };
        self.surgeon.mark(&stretch.edges, false);
        let Some(part) = self.smaller_part(stretch.ends) else {
            debug_assert!(!is_tree);
            self.surgeon.mark(&stretch.edges, true);
            return Outcome::OnCycle;
        };
        let start = stretch.ends[usize::from(self.parts[stretch.ends[0].index()] != 1)];
        for &v in &part {
            self.parts[v.index()] = OWN;
        }
        let sources = self.near_part(start, REACH * stretch.length, 1);
        let (surgeon, parts) = (&*self.surgeon, &self.parts);
        let bound = stretch.length * (1.0 - GAIN);
        let end = self.fronts[0].grow(surgeon, &sources, bound, |v| match parts[v.index()] {
            1 => Growth::Go,
            OWN => Growth::Block,
            _ if surgeon.is_on_network(v) => Growth::Stop,
            _ => Growth::Go,
        });
        let path = end.map(|v| self.fronts[0].path(surgeon, v));
        match path {
            Some(path) => {
                for h in path {
                    self.surgeon.is_cut[h.edge().index()] = true;
                }
                Outcome::Gained
            }
            None => {
                self.surgeon.mark(&stretch.edges, true);
                Outcome::Kept
            }
        }
    }

    /// Takes a junction of three stretches out, and joins the parts at the best vertex.
    fn relocate(&mut self, junction: VertexId, is_tree: bool) -> bool {
        let surgeon = &*self.surgeon;
        if surgeon.is_stop(junction) || surgeon.cuts_at(junction).count() != 3 {
            return false;
        }
        let stretches: Vec<Stretch> =
            surgeon.cuts_at(junction).filter_map(|h| surgeon.stretch_through(h.edge())).collect();
        let [a, b, c] = &stretches[..] else { return false };
        let total: f64 = a.length + b.length + c.length;
        let ends = [a, b, c].map(|s| if s.ends[0] == junction { s.ends[1] } else { s.ends[0] });
        for s in &stretches {
            self.surgeon.mark(&s.edges, false);
        }
        let pairs = [[0, 1], [1, 2], [2, 0]];
        let is_apart =
            is_tree || pairs.iter().all(|p| self.smaller_part(p.map(|i: usize| ends[i])).is_some());
        let paths = if is_apart { self.join_at_best(ends, total) } else { None };
        match paths {
            Some(paths) => {
                for h in paths {
                    self.surgeon.is_cut[h.edge().index()] = true;
                }
                true
            }
            None => {
                for s in &stretches {
                    self.surgeon.mark(&s.edges, true);
                }
                false
            }
        }
    }

    /// Paths from one vertex to three parts, together shorter than `total`.
    fn join_at_best(&mut self, ends: [VertexId; 3], total: f64) -> Option<Vec<HalfedgeId>> {
        self.clear_parts();
        for (part, end) in (1u8..).zip(ends) {
            let sources = self.near_part(end, total, part);
            let (surgeon, parts) = (&*self.surgeon, &self.parts);
            self.fronts[usize::from(part) - 1].grow(surgeon, &sources, total, |v| {
                let is_foreign = parts[v.index()] != part && surgeon.is_on_network(v);
                if is_foreign { Growth::Block } else { Growth::Go }
            });
        }
        let surgeon = &*self.surgeon;
        let mut best: Option<(f64, VertexId)> = None;
        for &v in &self.fronts[0].reached {
            let sum: f64 = self.fronts.iter().map(|front| front.distances[v.index()]).sum();
            let is_better = best.is_none_or(|(least, w)| sum < least || sum <= least && v < w);
            // On the network only where a front began: beyond, the way back along the network would close a cycle.
            let is_free = self.parts[v.index()] != 0 || !surgeon.is_on_network(v);
            if sum < total * (1.0 - GAIN) && is_better && is_free {
                best = Some((sum, v));
            }
        }
        let (_, at) = best?;
        let paths: Vec<HalfedgeId> =
            self.fronts.iter().flat_map(|front| front.path(surgeon, at)).collect();
        // With edges of length 0 two paths may meet before the end.
        let mut tails: Vec<VertexId> = paths.iter().map(|&h| surgeon.mesh.tail(h)).collect();
        tails.sort_unstable();
        let is_tree = tails.windows(2).all(|w| w[0] != w[1]) && !tails.contains(&at);
        is_tree.then_some(paths)
    }

    /// The vertices of the network no farther from a vertex than `reach`, along the network, marked.
    fn near_part(&mut self, start: VertexId, reach: f64, part: u8) -> Vec<VertexId> {
        let mut found = vec![(start, 0.0)];
        self.put(start, part);
        let mesh = self.surgeon.mesh;
        let mut next = 0;
        while let Some(&(v, walked)) = found.get(next) {
            next += 1;
            for h in mesh.outgoing(v) {
                let e = h.edge();
                let is_joined = self.surgeon.is_cut[e.index()] || mesh.is_boundary_edge(e);
                let tip = mesh.tip(h);
                let further = walked + self.surgeon.lengths[e.index()];
                let is_new = matches!(self.parts[tip.index()], 0 | OWN);
                if is_joined && further <= reach && is_new {
                    self.put(tip, part);
                    found.push((tip, further));
                }
            }
        }
        found.into_iter().map(|(v, _)| v).collect()
    }
}
