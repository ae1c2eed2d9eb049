//! The tree of segments.

use std::sync::Arc;

use super::super::flow::Status;
use super::objective::SplitTerms;
use super::profile::indicator;
use crate::mesh::{Mesh, VertexId};

/// A segment, and how it is split if it is.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseNode {
    /// The segment that it is a side of; the whole surface has none.
    pub parent: Option<usize>,
    /// Its sides {u > 0} and {u < 0}, if it is split.
    pub children: Option<[usize; 2]>,
    /// Number of splits above it.
    pub level: usize,
    /// The phase field that splits it, one value for each vertex; empty if it is not split.
    pub u: Arc<Vec<f64>>,
    /// Its diffuse indicator χ^α at each vertex.
    pub weight: Arc<Vec<f64>>,
    /// The terms of its split.
    pub terms: SplitTerms,
    /// The objective of its split.
    pub objective: f64,
    /// The objective after every iteration of the best start.
    pub history: Vec<f64>,
    /// How the search for its split ended, or `Running`.
    pub status: Status,
    /// Whether its split is done.
    pub(super) is_settled: bool,
}

/// All segments.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseFieldState {
    pub(super) nodes: Vec<PhaseNode>,
}

impl PhaseNode {
    fn leaf(parent: Option<usize>, level: usize, weight: Vec<f64>) -> Self {
        Self {
            parent,
            children: None,
            level,
            u: Arc::default(),
            weight: Arc::new(weight),
            terms: SplitTerms::default(),
            objective: 0.0,
            history: Vec::new(),
            status: Status::Running,
            is_settled: false,
        }
    }
}

impl PhaseFieldState {
    /// The whole surface, unsplit.
    pub(super) fn whole(vertices: usize) -> Self {
        Self { nodes: vec![PhaseNode::leaf(None, 0, vec![1.0; vertices])] }
    }

    /// Segments, parents before their sides; the first is the whole surface.
    pub fn tree(&self) -> &[PhaseNode] {
        &self.nodes
    }

    /// The segments that are not split, in the order of a walk through the tree, positive sides first: a segment's place is its label.
    pub fn leaves(&self) -> Vec<usize> {
        let (mut leaves, mut stack) = (Vec::new(), vec![0]);
        while let Some(node) = stack.pop() {
            match self.nodes[node].children {
                Some([positive, negative]) => stack.extend([negative, positive]),
                None => leaves.push(node),
            }
        }
        leaves
    }

    /// Diffuse indicators of the leaves: they add up to 1 at every vertex.
    pub fn leaf_weights(&self) -> Vec<&[f64]> {
        self.leaves().into_iter().map(|leaf| self.nodes[leaf].weight.as_slice()).collect()
    }

    /// The same without what is small beside the largest at a vertex: weights of overlapping charts.
    ///
    /// A field is near 0 outside of its segment, so that both its sides keep a little weight all along the segment's border; domains of all
    /// that is positive would have long tails there. **Gives** weights that add up to 1.
    pub fn chart_weights(&self) -> Vec<Vec<f64>> {
        let mut weights: Vec<Vec<f64>> =
            self.leaf_weights().into_iter().map(<[f64]>::to_vec).collect();
        for v in 0..self.nodes[0].weight.len() {
            let most = weights.iter().map(|w| w[v]).fold(0.0, f64::max);
            weights.iter_mut().for_each(|w| w[v] = (w[v] - TAIL * most).max(0.0));
            let sum: f64 = weights.iter().map(|w| w[v]).sum();
            weights.iter_mut().for_each(|w| w[v] /= sum);
        }
        weights
    }

    /// For each vertex the leaf that it lies in by the sides of the fields, as its place among [`PhaseFieldState::leaves`].
    pub fn labels(&self) -> Vec<u32> {
        let mut label_of = vec![0; self.nodes.len()];
        for (label, leaf) in (0u32..).zip(self.leaves()) {
            label_of[leaf] = label;
        }
        (0..self.nodes[0].weight.len()).map(|v| label_of[self.leaf_of(v)]).collect()
    }

    fn leaf_of(&self, v: usize) -> usize {
        let mut node = 0;
        while let Some(children) = self.nodes[node].children {
            node = children[usize::from(!self.is_positive(node, v))];
        }
        node
    }

    pub(super) fn is_positive(&self, node: usize, v: usize) -> bool {
        self.nodes[node].u[v] >= 0.0
    }

    /// The splits above a segment, each with whether the segment lies on its positive side.
    pub(super) fn path(&self, mut node: usize) -> Vec<(usize, bool)> {
        let mut path = Vec::new();
        while let Some(parent) = self.nodes[node].parent {
            let is_positive = self.nodes[parent].children.is_some_and(|c| c[0] == node);
            path.push((parent, is_positive));
            node = parent;
        }
        path
    }

    /// For each vertex the side of a split that it lies in (0 positive, 1 negative), 2 outside of the segment.
    pub(super) fn sides(&self, node: usize) -> Vec<u32> {
        let path = self.path(node);
        (0..self.nodes[0].weight.len())
            .map(|v| {
                if path.iter().any(|&(at, side)| self.is_positive(at, v) != side) {
                    2
                } else {
                    u32::from(!self.is_positive(node, v))
                }
            })
            .collect()
    }

    /// The split that puts two vertices on different sides, the first on their way down the tree.
    pub(super) fn parting(&self, [a, b]: [usize; 2]) -> Option<usize> {
        let mut node = 0;
        while let Some(children) = self.nodes[node].children {
            let side = self.is_positive(node, a);
            if side != self.is_positive(node, b) {
                return Some(node);
            }
            node = children[usize::from(!side)];
        }
        None
    }

    /// Where an edge between two leaves crosses from one to the other, from its first end.
    pub(super) fn crossing(&self, [a, b]: [usize; 2]) -> Option<f64> {
        let u = &self.nodes[self.parting([a, b])?].u;
        Some(u[a] / (u[a] - u[b]))
    }

    /// Sets the field of a split; its sides are made if there are none.
    pub(super) fn put(&mut self, node: usize, u: &[f64]) {
        self.nodes[node].u = Arc::new(u.to_vec());
        if self.nodes[node].children.is_none() {
            let level = self.nodes[node].level + 1;
            let first = self.nodes.len();
            for _ in 0..2 {
                self.nodes.push(PhaseNode::leaf(Some(node), level, Vec::new()));
            }
            self.nodes[node].children = Some([first, first + 1]);
        }
        self.weigh_below(node);
    }

    /// Computes the weights of everything below a split.
    fn weigh_below(&mut self, node: usize) {
        let mut stack = vec![node];
        while let Some(node) = stack.pop() {
            let Some(children) = self.nodes[node].children else { continue };
            let (w, u) = (self.nodes[node].weight.clone(), self.nodes[node].u.clone());
            let mut positive = Vec::with_capacity(u.len());
            let mut negative = Vec::with_capacity(u.len());
            for (w, &u) in w.iter().zip(&*u) {
                let chi = indicator(u).0;
                positive.push(w * chi);
                negative.push(w * (1.0 - chi));
            }
            for (child, weight) in children.into_iter().zip([positive, negative]) {
                self.nodes[child].weight = Arc::new(weight);
            }
            stack.extend(children);
        }
    }

    /// Gives islands in which the field of a split reaches neither phase to what lies around them: there it changes its sign.
    ///
    /// Connected phases are asked for above e₁ only: where a field passes 0 a little and comes back, as over the tip of a finger, nothing
    /// draws that together. **Takes** e₁. **Gives** the field where there were any.
    pub(super) fn give_up_islands(
        &mut self,
        mesh: &Mesh,
        node: usize,
        e1: f64,
    ) -> Option<Vec<f64>> {
        let mut given_up = None;
        for _ in 0..ISLANDS_IN_ISLANDS {
            let faint = faint_parts(mesh, &self.sides(node), &self.nodes[node].u, e1);
            if !faint.contains(&true) {
                break;
            }
            let mut u = self.nodes[node].u.to_vec();
            for (u, _) in u.iter_mut().zip(faint).filter(|(_, is_faint)| *is_faint) {
                // 0 is positive.
                *u = if *u >= 0.0 { -u.max(f64::MIN_POSITIVE) } else { -*u };
            }
            self.put(node, &u);
            given_up = Some(u);
        }
        given_up
    }

    /// Leaves no more than a number of levels of splits.
    pub(super) fn prune(&mut self, levels: usize) {
        // Parents come before their sides, and levels one after the other.
        let keep = self.nodes.iter().position(|n| n.level > levels).unwrap_or(self.nodes.len());
        self.nodes.truncate(keep);
        for node in self.nodes.iter_mut().filter(|n| n.level == levels) {
            let weight = std::mem::take(&mut node.weight);
            *node = PhaseNode { weight, ..PhaseNode::leaf(node.parent, levels, Vec::new()) };
        }
    }
}

/// Share of the largest weight at a vertex up to which others are tails: along the border of a segment of constant field they reach
/// some .12.
const TAIL: f64 = 0.2;

/// How often islands are looked for again, after those in them were given up.
const ISLANDS_IN_ISLANDS: usize = 4;

/// The vertices of parts of either side where the mean of u is on no face beyond e₁, as connectedness sees it, and that may change sides: not the
/// largest part of a side, and no two that touch.
fn faint_parts(mesh: &Mesh, sides: &[u32], u: &[f64], e1: f64) -> Vec<bool> {
    let is_within = |v: VertexId| sides[v.index()] < 2 && mesh.halfedge(v).is_some();
    let mut part_of = vec![usize::MAX; sides.len()];
    // For each part its side, its vertices and the largest |u| of a face.
    let mut parts: Vec<(u32, usize, f64)> = Vec::new();
    let mut stack = Vec::new();
    for start in mesh.vertices().filter(|&v| is_within(v)) {
        if part_of[start.index()] != usize::MAX {
            continue;
        }
        let side = sides[start.index()];
        let mut count = 0;
        part_of[start.index()] = parts.len();
        stack.push(start);
        while let Some(v) = stack.pop() {
            count += 1;
            for w in mesh.outgoing(v).map(|h| mesh.tip(h)) {
                if sides[w.index()] == side && part_of[w.index()] == usize::MAX {
                    part_of[w.index()] = parts.len();
                    stack.push(w);
                }
            }
        }
        parts.push((side, count, 0.0));
    }
    for corners in mesh.triangles().iter().map(|t| t.map(|v| v.index())) {
        let mean = corners.iter().map(|&v| u[v]).sum::<f64>() / 3.0;
        let toward = |v: usize| if mean < 0.0 { -u[v] } else { u[v] };
        let [a, b, c] = corners;
        let far = [b, c].into_iter().fold(a, |v, w| if toward(w) > toward(v) { w } else { v });
        if let Some((_, _, most)) = parts.get_mut(part_of[far]) {
            *most = most.max(mean.abs());
        }
    }
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
    for e in mesh.edges() {
        let [p, q] = mesh.edge_vertices(e).map(|v| part_of[v.index()]);
        if p != q && p != usize::MAX && q != usize::MAX {
            around[p].push(q);
            around[q].push(p);
        }
    }
    let largest = [0, 1].map(|side| {
        let own = (0..parts.len()).filter(|&p| parts[p].0 == side);
        own.max_by_key(|&p| (parts[p].1, std::cmp::Reverse(p)))
    });
    let may_go =
        |p: usize| !(parts[p].2 > e1) && !around[p].is_empty() && !largest.contains(&Some(p));
    let mut order: Vec<usize> = (0..parts.len()).filter(|&p| may_go(p)).collect();
    order.sort_by_key(|&p| (parts[p].1, p));
    let mut goes = vec![false; parts.len()];
    for p in order {
        goes[p] = !around[p].iter().any(|&q| goes[q]);
    }
    part_of.iter().map(|&p| p != usize::MAX && goes[p]).collect()
}
