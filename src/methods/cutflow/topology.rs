//! Which vertices may change their label in one step.
//!
//! A vertex is *simple* for a change if its link meets the old and the new label in one arc each: then neither patch is torn,
//! joined or pierced. Changes are made one after the other, so that the guarantee holds for all of them together. A vertex may
//! only take a label that stood across a crossed edge before the step: the cut never jumps more than one edge.
//!
//! Where patches may merge, the new label may meet the link in several arcs, and the old one too as long as its arcs are joined
//! elsewhere: the patch that is left stays in one piece.

use std::collections::{BTreeMap, VecDeque};

use super::band::LevelSets;
use super::params::Topology;
use crate::mesh::{Mesh, VertexId};

/// Passes over the refused changes: one change can make room for the next.
const PASSES: usize = 6;

/// A refused vertex is put back this far inside its patch, in mean edge lengths, or as far as the trial moved the cut if that
/// is less. Much less on a full step makes a neck so thin that it throttles every later step; the full distance on a short
/// trial would keep J from falling however short the trial is.
const MARGIN: f64 = 0.1;

/// Refuses the changes from `old` to `levels.labels` that the topology forbids, and puts those vertices back.
///
/// **Takes** `vanish`: whether the last vertex of a patch may go (needed with many patches); how far the cut `moved` at most.
pub(super) fn keep_simple(
    mesh: &Mesh,
    old: &[u32],
    levels: &mut LevelSets,
    topology: Topology,
    vanish: bool,
    mean_edge: f64,
    moved: f64,
) {
    let mut waiting: Vec<(VertexId, u32, f64)> = levels
        .band()
        .filter(|v| levels.labels[v.index()] != old[v.index()])
        .map(|v| {
            let wanted = levels.labels[v.index()];
            (v, wanted, levels.value(v, wanted).abs())
        })
        .collect();
    // Deepest first: those are the changes that the flow is surest of.
    waiting.sort_by(|a, b| b.2.total_cmp(&a.2).then(a.0.cmp(&b.0)));
    let mut labels = old.to_vec();
    for _ in 0..PASSES {
        let before = waiting.len();
        waiting.retain(|&(v, wanted, _)| {
            let reachable = mesh.outgoing(v).any(|h| old[mesh.tip(h).index()] == wanted);
            let allowed = reachable
                && match topology {
                    Topology::Preserve | Topology::Adaptive => {
                        is_simple(mesh, &labels, v, wanted, vanish)
                    }
                    Topology::Merge => {
                        is_simple(mesh, &labels, v, wanted, true)
                            || (arcs(mesh, &labels, v, wanted) > 0
                                && keeps_together(mesh, &labels, v))
                    }
                    Topology::Free => true,
                };
            if allowed {
                labels[v.index()] = wanted;
            }
            !allowed
        });
        if waiting.is_empty() || waiting.len() == before {
            break;
        }
    }
    for &(v, _, _) in &waiting {
        levels.put_back(v, old[v.index()], moved.min(MARGIN * mean_edge));
    }
}

/// Whether giving `v` the label `wanted` changes no patch's topology.
pub(super) fn is_simple(
    mesh: &Mesh,
    labels: &[u32],
    v: VertexId,
    wanted: u32,
    vanish: bool,
) -> bool {
    let old_arcs = arcs(mesh, labels, v, labels[v.index()]);
    arcs(mesh, labels, v, wanted) == 1 && (old_arcs == 1 || (vanish && old_arcs == 0))
}

/// In how many arcs the link of a vertex meets a label.
fn arcs(mesh: &Mesh, labels: &[u32], v: VertexId, label: u32) -> usize {
    let (mut first, mut last, mut count) = (None, false, 0);
    for h in mesh.outgoing(v) {
        let inside = labels[mesh.tip(h).index()] == label;
        count += usize::from(inside && !last);
        first.get_or_insert(inside);
        last = inside;
    }
    // Around an interior vertex the last arc may continue in the first.
    let wraps = !mesh.is_boundary_vertex(v) && first == Some(true) && last;
    if wraps && count > 1 { count - 1 } else { count }
}

/// Whether the patch of a vertex stays in one piece without it: all its neighbours of the same label reach each other.
///
/// Searches from all of them in turn, until they have met or one has nowhere left to go. **Costs** the size of the smaller part
/// where the patch would be torn; of the way around where it would not. Few vertices need it.
fn keeps_together(mesh: &Mesh, labels: &[u32], v: VertexId) -> bool {
    let own = labels[v.index()];
    let around = |w: VertexId| {
        mesh.outgoing(w).map(|h| mesh.tip(h)).filter(|&x| x != v && labels[x.index()] == own)
    };
    let mut queues: Vec<VecDeque<VertexId>> = around(v).map(|w| VecDeque::from([w])).collect();
    // Which search came to a vertex first, and which searches have met: each names one that it belongs to.
    let mut owners: BTreeMap<VertexId, usize> =
        queues.iter().enumerate().map(|(i, queue)| (queue[0], i)).collect();
    let mut groups: Vec<usize> = (0..queues.len()).collect();
    let root = |groups: &[usize], mut i: usize| {
        while groups[i] != i {
            i = groups[i];
        }
        i
    };
    let mut left = queues.len();
    while left > 1 {
        for i in 0..queues.len() {
            let Some(w) = queues[i].pop_front() else { continue };
            for x in around(w) {
                let &mut other = owners.entry(x).or_insert_with(|| {
                    queues[i].push_back(x);
                    i
                });
                let (a, b) = (root(&groups, i), root(&groups, other));
                if a != b {
                    groups[a] = b;
                    left -= 1;
                }
            }
        }
        // A group whose searches have all ended is a part of its own.
        let is_alive = |group: usize| {
            (0..queues.len()).any(|i| root(&groups, i) == group && !queues[i].is_empty())
        };
        if left > 1 && !(0..groups.len()).filter(|&i| groups[i] == i).all(is_alive) {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wheel: hub 0, rim 1..=n.
    fn wheel(n: u32) -> Mesh {
        let triangles: Vec<[u32; 3]> = (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect();
        Mesh::new(n as usize + 1, &triangles).unwrap()
    }

    #[test]
    fn one_arc_each_is_simple_and_anything_else_is_not() {
        let mesh = wheel(6);
        let hub = VertexId(0);
        let simple = |rim: [u32; 6], vanish: bool| {
            let mut labels = vec![0];
            labels.extend(rim);
            is_simple(&mesh, &labels, hub, 1, vanish)
        };
        assert!(simple([0, 0, 1, 1, 0, 0], false), "arcs may wrap around");
        assert!(simple([1, 0, 0, 0, 1, 1], false));
        assert!(simple([0, 2, 1, 1, 2, 2], false), "other labels may lie anywhere");
        assert!(!simple([0, 1, 0, 0, 1, 0], false), "would join two arms and tear the other patch");
        assert!(!simple([0, 0, 0, 0, 0, 0], false), "would start an island");
        assert!(!simple([1, 1, 1, 1, 1, 1], false), "would end a patch");
        assert!(simple([1, 1, 1, 1, 1, 1], true));
        assert!(!simple([1, 2, 1, 2, 2, 2], true), "would join two arms over a dying patch");
    }

    #[test]
    fn a_patch_keeps_together_where_there_is_a_way_around() {
        // A hub with two rings of six.
        let mut triangles: Vec<[u32; 3]> = Vec::new();
        for i in 0..6 {
            let [a, b] = [i, (i + 1) % 6].map(|k| 1 + k);
            triangles.extend([[0, a, b], [a, a + 6, b], [b, a + 6, b + 6]]);
        }
        let mesh = Mesh::new(13, &triangles).unwrap();
        let keeps = |inner: [u32; 6], outer: [u32; 6]| {
            let labels: Vec<u32> = [&[0], &inner[..], &outer[..]].concat();
            keeps_together(&mesh, &labels, VertexId(0))
        };
        assert!(keeps([0, 0, 1, 1, 1, 1], [1; 6]), "one arc");
        assert!(keeps([1; 6], [0; 6]), "the last one of its piece tears nothing");
        assert!(!keeps([0, 1, 1, 0, 1, 1], [1; 6]), "two arms");
        assert!(keeps([0, 1, 1, 0, 1, 1], [0; 6]), "two arms that meet outside");
        assert!(!keeps([0, 1, 0, 1, 0, 1], [0, 0, 0, 1, 0, 1]), "two of three meet");
        assert!(keeps([0, 1, 0, 1, 0, 1], [0, 0, 0, 0, 0, 1]), "all three meet");
    }
}
