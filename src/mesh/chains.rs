//! Edges to polylines.

/// Joins edges to chains that run as far as they can.
///
/// **Takes** pairs of different indices, each pair once, and which indices end a chain whatever meets there. **Gives** each
/// edge in exactly one chain. A chain ends where other than two edges meet or where it is told to; one that meets no such
/// place is closed and repeats its first index at its end. Chains are ordered, begun and directed by their first edge.
/// **Costs** O(n log n) in the number of edges, whatever the indices are.
///
/// ```
/// # use cutflow::mesh::chains;
/// // A square and a line that leaves it at 2.
/// let edges = [[0, 1], [1, 2], [2, 3], [3, 0], [2, 7], [7, 8]];
/// assert_eq!(chains(&edges, |_| false), [vec![2, 3, 0, 1, 2], vec![2, 7, 8]]);
/// ```
pub fn chains(edges: &[[u32; 2]], ends_at: impl Fn(u32) -> bool) -> Vec<Vec<u32>> {
    // Edge ends sorted by index: the edges at an index stand side by side.
    let mut ends: Vec<(u32, u32)> = Vec::with_capacity(2 * edges.len());
    for (edge, pair) in (0u32..).zip(edges) {
        ends.extend(pair.map(|v| (v, edge)));
    }
    ends.sort_unstable();
    let edges_at = |v: u32| {
        let first = ends.partition_point(|&(w, _)| w < v);
        let rest = &ends[first..];
        &rest[..rest.partition_point(|&(w, _)| w == v)]
    };
    // The edge that continues `edge` at its end `v`.
    let continuation = |v: u32, edge: u32| match edges_at(v) {
        &[(_, a), (_, b)] if !ends_at(v) => Some(if a == edge { b } else { a }),
        _ => None,
    };
    let other_end = |v: u32, edge: u32| {
        let [a, b] = edges[edge as usize];
        if a == v { b } else { a }
    };

    let mut chains = Vec::new();
    let mut seen = vec![false; edges.len()];
    for (seed, &[mut start, _]) in (0u32..).zip(edges) {
        if seen[seed as usize] {
            continue;
        }
        // Back to where the chain begins, or once around.
        let mut first = seed;
        while let Some(before) = continuation(start, first).filter(|&e| e != seed) {
            start = other_end(start, before);
            first = before;
        }
        let mut chain = vec![start];
        let (mut v, mut edge) = (start, first);
        loop {
            seen[edge as usize] = true;
            v = other_end(v, edge);
            chain.push(v);
            match continuation(v, edge) {
                Some(next) if !seen[next as usize] => edge = next,
                _ => break,
            }
        }
        chains.push(chain);
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_is_closed_unless_it_is_told_to_end() {
        let ring = [[5, 9], [9, 7], [7, 5]];
        assert_eq!(chains(&ring, |_| false), [vec![9, 7, 5, 9]]);
        assert_eq!(chains(&ring, |v| v == 7), [vec![7, 5, 9, 7]]);
        assert_eq!(chains(&ring, |_| true), [vec![5, 9], vec![9, 7], vec![7, 5]]);
    }

    #[test]
    fn a_path_given_in_any_order_is_one_chain() {
        let path = [[3, 4], [1, 2], [4, 5], [3, 2]];
        assert_eq!(chains(&path, |_| false), [vec![1, 2, 3, 4, 5]]);
        assert!(chains(&[], |_| false).is_empty());
    }

    #[test]
    fn a_junction_ends_every_chain() {
        let edges = [[0, 1], [0, 2], [0, 3], [3, 4]];
        assert_eq!(chains(&edges, |_| false), [vec![0, 1], vec![0, 2], vec![0, 3, 4]]);
    }
}
