//! Shortest cuts between two sets of faces: a maximum flow on the dual graph.
//!
//! Faces are nodes, a side that two of them share is an edge whose capacity is what a cut along it costs. The flow goes along shortest
//! paths whose lengths are kept up to date where they change only (Ahuja and Orlin's improved shortest augmenting paths): where sheets
//! are some hundred faces apart, measuring all of them again for each length takes ten times as long. Capacities are whole numbers, so that
//! sums are exact and the same everywhere.

/// No neighbour, not reached.
const NONE: u32 = u32::MAX;

/// An index as a `u32`: meshes number fewer elements than that.
#[expect(clippy::cast_possible_truncation, reason = "Mesh::new refuses larger meshes")]
fn small(index: usize) -> u32 {
    index as u32
}

/// A graph of faces with at most three neighbours each.
pub(crate) struct Network {
    /// For each node its arcs; arc 2 k and arc 2 k + 1 are the two directions of edge k.
    arcs: Vec<[u32; 3]>,
    /// Where each arc leads to.
    heads: Vec<u32>,
    /// What each arc can still carry.
    room: Vec<u64>,
    /// At least as many arcs lead from each node to a sink; with as many as there are nodes there is no way.
    distances: Vec<u32>,
    /// How many nodes have each distance.
    counts: Vec<u32>,
    /// How many of its arcs each node has tried since its distance changed.
    tried: Vec<u8>,
}

impl Network {
    /// So many nodes without edges.
    pub fn new(nodes: usize) -> Self {
        Self {
            arcs: vec![[NONE; 3]; nodes],
            heads: Vec::new(),
            room: Vec::new(),
            distances: Vec::new(),
            counts: Vec::new(),
            tried: vec![0; nodes],
        }
    }

    /// Joins two nodes, each of which has two edges at most so far.
    pub fn join(&mut self, a: u32, b: u32, capacity: u64) {
        for (from, to) in [(a, b), (b, a)] {
            let arc = small(self.heads.len());
            self.heads.push(to);
            self.room.push(capacity);
            if let Some(slot) = self.arcs[from as usize].iter_mut().find(|slot| **slot == NONE) {
                *slot = arc;
            }
        }
    }

    /// For each node whether it is on the sources' side of the least cut, the one next to the sources if there are several.
    ///
    /// **Takes** disjoint sets. **Costs** O(n d) at worst for sets that are d faces apart along the longest path that is needed, and in
    /// practice a few times n.
    pub fn cut(&mut self, sources: &[u32], sinks: &[u32]) -> Vec<bool> {
        self.measure(sinks);
        for &s in sources {
            self.send(s);
        }
        let mut is_reached = vec![false; self.arcs.len()];
        let mut stack = sources.to_vec();
        for &s in sources {
            is_reached[s as usize] = true;
        }
        while let Some(node) = stack.pop() {
            for arc in self.arcs[node as usize].into_iter().filter(|&arc| arc != NONE) {
                let head = self.heads[arc as usize];
                if self.room[arc as usize] > 0
                    && !std::mem::replace(&mut is_reached[head as usize], true)
                {
                    stack.push(head);
                }
            }
        }
        is_reached
    }

    /// Distances to the sinks, before anything flows: arcs have room both ways or not at all.
    fn measure(&mut self, sinks: &[u32]) {
        let nodes = self.arcs.len();
        self.distances = vec![small(nodes); nodes];
        for &t in sinks {
            self.distances[t as usize] = 0;
        }
        let mut queue = sinks.to_vec();
        let mut next = 0;
        while let Some(&node) = queue.get(next) {
            next += 1;
            for arc in self.arcs[node as usize].into_iter().filter(|&arc| arc != NONE) {
                let head = self.heads[arc as usize] as usize;
                if self.room[(arc ^ 1) as usize] > 0 && self.distances[head] as usize == nodes {
                    self.distances[head] = self.distances[node as usize] + 1;
                    queue.push(self.heads[arc as usize]);
                }
            }
        }
        self.counts = vec![0; nodes + 1];
        for &distance in &self.distances {
            self.counts[distance as usize] += 1;
        }
        self.tried.fill(0);
    }

    /// Sends as much from a source to the sinks as there is room for.
    fn send(&mut self, source: u32) {
        let nodes = small(self.arcs.len());
        let mut path: Vec<u32> = Vec::new();
        let mut node = source;
        while self.distances[source as usize] < nodes {
            if self.distances[node as usize] == 0 {
                let amount = path.iter().map(|&arc| self.room[arc as usize]).min().unwrap_or(0);
                for arc in &path {
                    self.room[*arc as usize] -= amount;
                    self.room[(*arc ^ 1) as usize] += amount;
                }
                // The next path begins where this one is blocked now.
                let blocked = path.iter().position(|&arc| self.room[arc as usize] == 0);
                let Some(blocked) = blocked else { return };
                node = self.heads[(path[blocked] ^ 1) as usize];
                path.truncate(blocked);
                continue;
            }
            let distance = self.distances[node as usize];
            let arcs = self.arcs[node as usize];
            let open = |network: &Self, arc: u32| arc != NONE && network.room[arc as usize] > 0;
            let leads_on = |network: &Self, arc: u32| {
                open(network, arc)
                    && network.distances[network.heads[arc as usize] as usize] + 1 == distance
            };
            let first = usize::from(self.tried[node as usize]);
            if let Some(i) = (first..3).find(|&i| leads_on(self, arcs[i])) {
                self.tried[node as usize] = [0, 1, 2][i];
                path.push(arcs[i]);
                node = self.heads[arcs[i] as usize];
                continue;
            }
            // No way from here is that short any more.
            let nearest = arcs
                .into_iter()
                .filter(|&arc| open(self, arc))
                .map(|arc| self.distances[self.heads[arc as usize] as usize] + 1)
                .min();
            let longer = nearest.unwrap_or(nodes).min(nodes);
            self.counts[distance as usize] -= 1;
            self.counts[longer as usize] += 1;
            self.distances[node as usize] = longer;
            self.tried[node as usize] = 0;
            if self.counts[distance as usize] == 0 {
                // No node is that far any more: whatever is farther, this source among it, has no way.
                return;
            }
            if let Some(arc) = path.pop() {
                node = self.heads[(arc ^ 1) as usize];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_cut_of_a_ladder_is_its_narrowest_place() {
        // Two rows of ten nodes, joined by rungs; the rails are 5 wide but for one place.
        let mut network = Network::new(20);
        for i in 0..10 {
            network.join(2 * i, 2 * i + 1, 3);
            if i < 9 {
                let width = if i == 6 { [1, 2] } else { [5, 4] };
                network.join(2 * i, 2 * i + 2, width[0]);
                network.join(2 * i + 1, 2 * i + 3, width[1]);
            }
        }
        let side = network.cut(&[0, 1], &[19]);
        let expected: Vec<bool> = (0..20).map(|i| i < 14).collect();
        assert_eq!(side, expected);
    }

    #[test]
    fn least_cuts_of_small_graphs_are_those_of_trying_all() {
        // The dual of a strip that is closed to a ring, with capacities without pattern.
        let mut state = 1u64;
        for _ in 0..200 {
            let mut edges = Vec::new();
            let mut add = |a: u32, b: u32| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                edges.push((a, b, 1 + (state >> 33) % 9));
            };
            for i in 0..5u32 {
                add(2 * i, 2 * i + 1);
                add(2 * i, (2 * i + 2) % 10);
                add(2 * i + 1, (2 * i + 3) % 10);
            }
            let mut network = Network::new(10);
            edges.iter().for_each(|&(a, b, c)| network.join(a, b, c));
            let side = network.cut(&[0], &[5, 7]);
            assert!(side[0] && !side[5] && !side[7]);
            let value = |is_in: &dyn Fn(u32) -> bool| -> u64 {
                edges.iter().filter(|e| is_in(e.0) != is_in(e.1)).map(|e| e.2).sum()
            };
            let least = (0..1024u32)
                .filter(|set| set & 1 == 1 && set & (1 << 5 | 1 << 7) == 0)
                .map(|set| value(&|i| set >> i & 1 == 1))
                .min();
            assert_eq!(Some(value(&|i| side[i as usize])), least);
        }
    }
}
