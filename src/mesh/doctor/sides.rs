//! Which sides of polygons name the same edge.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use crate::mesh::Soup;

/// The edges of a soup. A side is named by the corner that it starts at: an index into [`Soup::corners`].
#[derive(Clone, Debug)]
pub struct Sides {
    /// For each side the corner that it ends at.
    pub next: Vec<u32>,
    /// For each side its polygon.
    pub polygons: Vec<u32>,
    /// For each side its edge.
    pub edge_of: Vec<u32>,
    /// End vertices of the edges, smaller first, in increasing order. Equal where a polygon repeats a vertex.
    pub edges: Vec<[u32; 2]>,
    starts: Vec<u32>,
    sides: Vec<u32>,
}

impl Sides {
    /// Finds equal sides by buckets of the smaller vertex. **Costs** O(n log d) for d sides at a vertex.
    pub fn new(soup: &Soup) -> Self {
        let count = soup.corners.len();
        let mut next = Vec::with_capacity(count);
        let mut polygons = Vec::with_capacity(count);
        for (polygon, ends) in soup.starts.windows(2).enumerate() {
            for corner in ends[0]..ends[1] {
                next.push(if corner + 1 == ends[1] { ends[0] } else { corner + 1 });
                polygons.push(polygon as u32);
            }
        }
        let name = |side: u32| {
            let a = soup.corners[side as usize];
            let b = soup.corners[next[side as usize] as usize];
            [a.min(b), a.max(b)]
        };
        let mut ends = vec![0u32; soup.positions.len() + 1];
        for side in 0..count as u32 {
            ends[name(side)[0] as usize + 1] += 1;
        }
        for v in 0..soup.positions.len() {
            ends[v + 1] += ends[v];
        }
        let mut sides = vec![0u32; count];
        for side in 0..count as u32 {
            let slot = &mut ends[name(side)[0] as usize];
            sides[*slot as usize] = side;
            *slot += 1;
        }
        let mut edges = Vec::new();
        let mut starts = Vec::new();
        let mut edge_of = vec![0u32; count];
        let mut begin = 0;
        for &end in &ends[..soup.positions.len()] {
            let bucket = &mut sides[begin..end as usize];
            bucket.sort_unstable_by_key(|&side| (name(side)[1], side));
            for (i, &side) in bucket.iter().enumerate() {
                if i == 0 || name(bucket[i - 1]) != name(side) {
                    starts.push((begin + i) as u32);
                    edges.push(name(side));
                }
                edge_of[side as usize] = (edges.len() - 1) as u32;
            }
            begin = end as usize;
        }
        starts.push(count as u32);
        Self { next, polygons, edge_of, edges, starts, sides }
    }

    /// The sides of an edge, in increasing order.
    pub fn of(&self, edge: usize) -> &[u32] {
        &self.sides[self.starts[edge] as usize..self.starts[edge + 1] as usize]
    }

    /// Whether a side runs from the smaller to the larger vertex of its edge.
    pub fn is_forward(&self, soup: &Soup, side: u32) -> bool {
        soup.corners[side as usize] == self.edges[self.edge_of[side as usize] as usize][0]
    }

    /// The corners of a side at the smaller and at the larger vertex of its edge.
    pub fn ends(&self, soup: &Soup, side: u32) -> [u32; 2] {
        let next = self.next[side as usize];
        if self.is_forward(soup, side) { [side, next] } else { [next, side] }
    }

    /// The edge between two vertices.
    pub fn find(&self, a: u32, b: u32) -> Option<usize> {
        self.edges.binary_search(&[a.min(b), a.max(b)]).ok()
    }
}

/// Sets of elements that grow together.
#[derive(Clone, Debug)]
pub struct Groups {
    parents: Vec<u32>,
}

impl Groups {
    /// Every element by itself.
    pub fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    /// The smallest element of the set.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.parents[i as usize] != i {
            let above = self.parents[self.parents[i as usize] as usize];
            self.parents[i as usize] = above;
            i = above;
        }
        i
    }

    /// Makes two sets one; `false` if they were.
    pub fn join(&mut self, i: u32, j: u32) -> bool {
        let (i, j) = (self.root(i), self.root(j));
        self.parents[i.max(j) as usize] = i.min(j);
        i != j
    }
}
