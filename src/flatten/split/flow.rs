//! Shortest cuts between two sets of faces: a maximum flow on the dual graph.
//!
//! Faces are nodes, a side that two of them share is an edge whose capacity is what a cut along it costs. The flow is found in phases
//! (Dinic): distances from the sources, then paths along increasing distances until all are blocked. Capacities are whole numbers, so
//! that sums are exact and the same everywhere.

/// No neighbour, not reached.
const NONE: u32 = u32::MAX;

/// A graph of faces with at most three neighbours each.
pub(super) struct Network {
    /// For each node its arcs; arc 2 k and arc 2 k + 1 are the two directions of edge k.
    arcs: Vec<[u32; 3]>,
    /// Where each arc leads to.
    heads: Vec<u32>,
    /// What each arc can still carry.
    room: Vec<u64>,
    levels: Vec<u32>,
    /// How many of its arcs each node has tried in this phase.
    tried: Vec<u8>,
}

impl Network {
    pub fn new(nodes: usize) -> Self {
        Self {
            arcs: vec![[NONE; 3]; nodes],
            heads: Vec::new(),
            room: Vec::new(),
            levels: vec![NONE; nodes],
            tried: vec![0; nodes],
        }
    }

    /// Joins two nodes, each of which has two edges at most so far.
    pub fn join(&mut self, a: u32, b: u32, capacity: u64) {
        for (from, to) in [(a, b), (b, a)] {
            let arc = super::super::small(self.heads.len());
            self.heads.push(to);
            self.room.push(capacity);
            if let Some(slot) = self.arcs[from as usize].iter_mut().find(|slot| **slot == NONE) {
                *slot = arc;
            }
        }
    }

    /// For each node whether it is on the sources' side of the least cut, the one next to the sources if there are several.
    ///
    /// **Takes** disjoint sets. **Costs** O(n) for each of the phases, whose number grows with the length of detours.
    pub fn cut(&mut self, sources: &[u32], sinks: &[u32]) -> Vec<bool> {
        let mut is_sink = vec![false; self.arcs.len()];
        for &t in sinks {
            is_sink[t as usize] = true;
        }
        while self.measure(sources, &is_sink) {
            self.tried.fill(0);
            for &s in sources {
                while self.augment(s, &is_sink) {}
            }
        }
        self.levels.iter().map(|&level| level != NONE).collect()
    }

    /// Distances from the sources along arcs that have room. **Gives** whether a sink was reached.
    fn measure(&mut self, sources: &[u32], is_sink: &[bool]) -> bool {
        self.levels.fill(NONE);
        for &s in sources {
            self.levels[s as usize] = 0;
        }
        let mut queue = sources.to_vec();
        let mut next = 0;
        let mut reaches = false;
        while let Some(&node) = queue.get(next) {
            next += 1;
            if is_sink[node as usize] {
                reaches = true;
                continue;
            }
            for &arc in self.arcs[node as usize].iter().filter(|&&arc| arc != NONE) {
                let head = self.heads[arc as usize];
                if self.room[arc as usize] > 0 && self.levels[head as usize] == NONE {
                    self.levels[head as usize] = self.levels[node as usize] + 1;
                    queue.push(head);
                }
            }
        }
        reaches
    }

    /// Sends as much as one path from a source to some sink can carry. **Gives** false where no path is left.
    fn augment(&mut self, source: u32, is_sink: &[bool]) -> bool {
        let mut path: Vec<u32> = Vec::new();
        let mut node = source;
        while !is_sink[node as usize] {
            let tried = usize::from(self.tried[node as usize]);
            if tried == 3 {
                // A dead end: go back, and do not come again.
                let Some(arc) = path.pop() else { return false };
                node = self.heads[(arc ^ 1) as usize];
                self.tried[node as usize] += 1;
                continue;
            }
            let arc = self.arcs[node as usize][tried];
            let leads_on = arc != NONE && self.room[arc as usize] > 0 && {
                let level = self.levels[self.heads[arc as usize] as usize];
                level != NONE && level == self.levels[node as usize] + 1
            };
            if leads_on {
                path.push(arc);
                node = self.heads[arc as usize];
            } else {
                self.tried[node as usize] += 1;
            }
        }
        let amount = path.iter().map(|&arc| self.room[arc as usize]).min().unwrap_or(0);
        for arc in &path {
            self.room[*arc as usize] -= amount;
            self.room[(*arc ^ 1) as usize] += amount;
        }
        amount > 0
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
