//! Which of many boxes meet.
//!
//! Boxes are sorted along a space-filling curve and joined two by two into a tree of larger boxes, so that neither their sizes nor
//! their density matter: charts with strong cones have triangles that differ by factors of thousands.

use nalgebra::Point2;

use super::super::small;

/// An axis-parallel box: the lowest and the highest corner.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    /// The box about some points.
    pub fn of(points: &[Point2<f64>]) -> Self {
        let mut bounds = Self::EMPTY;
        for p in points {
            bounds = bounds.union(&Self { low: [p.x, p.y], high: [p.x, p.y] });
        }
        bounds
    }

    const EMPTY: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    fn union(&self, other: &Self) -> Self {
        Self {
            low: [self.low[0].min(other.low[0]), self.low[1].min(other.low[1])],
            high: [self.high[0].max(other.high[0]), self.high[1].max(other.high[1])],
        }
    }

    /// Whether two boxes have a point in common, on their sides or inside.
    fn meets(&self, other: &Self) -> bool {
        // All four at once: a branch for each would be guessed wrong too often.
        (self.low[0] <= other.high[0])
            & (other.low[0] <= self.high[0])
            & (self.low[1] <= other.high[1])
            & (other.low[1] <= self.high[1])
    }

    /// Whether the insides of two boxes have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low[0] < other.high[0]
            && other.low[0] < self.high[0]
            && self.low[1] < other.high[1]
            && other.low[1] < self.high[1]
    }

    fn centre(&self) -> [f64; 2] {
        [0, 1].map(|i| 0.5 * self.low[i] + 0.5 * self.high[i])
    }
}

/// Boxes in a leaf: fewer make the tree deeper, more make pairs that do not meet.
const LEAF: usize = 4;

/// A perfect binary tree of boxes.
pub(in super::super) struct Tree<'a> {
    boxes: &'a [Bounds],
    /// Numbers of the boxes along the curve.
    order: Vec<u32>,
    leaves: usize,
    /// Node 1 is the root, 2 i and 2 i + 1 are the children of i; leaves come last.
    nodes: Vec<Bounds>,
}

impl<'a> Tree<'a> {
    /// **Takes** boxes with finite corners. **Costs** O(n log n).
    pub fn new(boxes: &'a [Bounds]) -> Self {
        let all = boxes.iter().fold(Bounds::EMPTY, |all, b| all.union(b));
        let scale = [0, 1].map(|i| f64::from(u32::MAX) / (all.high[i] - all.low[i]));
        let mut codes: Vec<(u64, u32)> = Vec::with_capacity(boxes.len());
        for (i, b) in boxes.iter().enumerate() {
            let centre = b.centre();
            let [x, y] = [0, 1].map(|i| spread(quantised((centre[i] - all.low[i]) * scale[i])));
            codes.push((x | y << 1, small(i)));
        }
        codes.sort_unstable();
        let leaves = boxes.len().div_ceil(LEAF).max(1).next_power_of_two();
        let mut tree = Self {
            boxes,
            order: codes.into_iter().map(|(_, i)| i).collect(),
            leaves,
            nodes: vec![Bounds::EMPTY; 2 * leaves],
        };
        for leaf in 0..leaves {
            let bounds = tree.leaf(leaf).iter().map(|&i| boxes[i as usize]);
            tree.nodes[leaves + leaf] = bounds.fold(Bounds::EMPTY, |all, b| all.union(&b));
        }
        for node in (1..leaves).rev() {
            tree.nodes[node] = tree.nodes[2 * node].union(&tree.nodes[2 * node + 1]);
        }
        tree
    }

    fn leaf(&self, leaf: usize) -> &[u32] {
        let start = |leaf: usize| leaf * self.order.len() / self.leaves;
        &self.order[start(leaf)..start(leaf + 1)]
    }

    /// Calls once with each pair of boxes that meet, the smaller number first. **Costs** O(n) and what is found, for boxes that
    /// lie side by side.
    pub fn for_pairs(&self, mut call: impl FnMut(u32, u32)) {
        let mut stack = vec![[1, 1]];
        while let Some([a, b]) = stack.pop() {
            if a >= self.leaves {
                let (here, there) = (self.leaf(a - self.leaves), self.leaf(b - self.leaves));
                for (rank, &i) in here.iter().enumerate() {
                    let others = if a == b { &there[rank + 1..] } else { there };
                    for &j in others {
                        if self.boxes[i as usize].meets(&self.boxes[j as usize]) {
                            call(i.min(j), i.max(j));
                        }
                    }
                }
                continue;
            }
            let pairs =
                [[2 * a, 2 * b], [2 * a + 1, 2 * b + 1], [2 * a, 2 * b + 1], [2 * a + 1, 2 * b]];
            // A node and itself have three pairs of children.
            for &[c, d] in &pairs[..if a == b { 3 } else { 4 }] {
                if c == d || self.nodes[c].meets(&self.nodes[d]) {
                    stack.push([c, d]);
                }
            }
        }
    }
}

/// A whole number; 0 where the extent is.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
fn quantised(x: f64) -> u32 {
    x as u32
}

/// The bits of a number at the even places.
fn spread(x: u32) -> u64 {
    let mut x = u64::from(x);
    x = (x | x << 16) & 0x0000_ffff_0000_ffff;
    x = (x | x << 8) & 0x00ff_00ff_00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333_3333_3333;
    (x | x << 1) & 0x5555_5555_5555_5555
}
