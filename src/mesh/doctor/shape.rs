//! The shape of a soup: components, fans, orientation, boundary.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use super::{Groups, Sides};
use crate::mesh::Soup;

const NONE: u32 = u32::MAX;

/// A chain of boundary sides.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loop {
    /// The vertices in the order of the walk, each once; a chain that is not closed has one more than sides.
    pub vertices: Vec<u32>,
    /// The sides in the order of the walk, by their corners. The first is walked in its own direction.
    pub sides: Vec<u32>,
    /// `false` for chains that end at an edge of three or more sides.
    pub is_closed: bool,
}

/// How the polygons of a soup hang together. Polygons must not repeat a vertex in a row.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Number of vertices that polygons use.
    pub used_vertices: usize,
    /// For each polygon its component (by common edges), numbered by first polygon.
    pub face_components: Vec<u32>,
    /// Number of components.
    pub components: usize,
    /// Edges with one side.
    pub boundary: Vec<u32>,
    /// Edges with three or more sides.
    pub crowded: Vec<u32>,
    /// Vertices with more than one fan.
    pub bow_ties: Vec<u32>,
    /// For each polygon its patch (by common edges with two sides), numbered by first polygon.
    pub face_patches: Vec<u32>,
    /// For each patch whether it can be oriented.
    pub patch_is_orientable: Vec<bool>,
    /// Per polygon: the fewest in each orientable patch whose turning lets neighbours agree; none in others.
    pub turned: Vec<bool>,
    /// Edges where orientation fails whatever is turned: cutting them makes their patches orientable.
    pub conflicts: Vec<u32>,
    /// Edges of orientable patches that both neighbours run through in the same direction.
    pub disagreeing: Vec<u32>,
    /// The boundary, each edge once.
    pub loops: Vec<Loop>,
}

impl Shape {
    /// Looks at a soup. **Costs** O(n log n).
    pub fn new(soup: &Soup, sides: &Sides) -> Self {
        let (face_components, components) = components(soup, sides);
        let with = |test: fn(usize) -> bool| {
            let edges = 0..sides.edges.len();
            Vec::from_iter(edges.filter(|&e| test(sides.of(e).len())).map(|e| e as u32))
        };
        let boundary = with(|count| count == 1);
        let mut fans = fans(soup, sides, &sides.edge_of);
        let mut first_fans = vec![NONE; soup.positions.len()];
        let mut bow_ties = Vec::new();
        for (corner, &v) in soup.corners.iter().enumerate() {
            let fan = fans.root(corner as u32);
            if first_fans[v as usize] == NONE {
                first_fans[v as usize] = fan;
            } else if first_fans[v as usize] != fan {
                bow_ties.push(v);
            }
        }
        bow_ties.sort_unstable();
        bow_ties.dedup();
        let loops = loops(soup, sides, &boundary, &mut fans);
        let mut shape = Self {
            used_vertices: first_fans.iter().filter(|&&fan| fan != NONE).count(),
            face_components,
            components,
            boundary,
            crowded: with(|count| count > 2),
            bow_ties,
            face_patches: vec![NONE; soup.polygon_count()],
            patch_is_orientable: Vec::new(),
            turned: vec![false; soup.polygon_count()],
            conflicts: Vec::new(),
            disagreeing: Vec::new(),
            loops,
        };
        shape.orient(soup, sides);
        shape
    }

    /// Whether every edge has at most two sides and every vertex one fan.
    pub fn is_manifold(&self) -> bool {
        self.crowded.is_empty() && self.bow_ties.is_empty()
    }

    /// Vertices − edges + polygons.
    pub fn euler(&self, sides: &Sides) -> i64 {
        self.used_vertices as i64 - sides.edges.len() as i64 + self.turned.len() as i64
    }

    /// Walks over each patch and turns what disagrees with its start, then the rest instead where that is less.
    fn orient(&mut self, soup: &Soup, sides: &Sides) {
        let mut queue = Vec::new();
        for seed in 0..soup.polygon_count() {
            if self.face_patches[seed] != NONE {
                continue;
            }
            let patch = self.patch_is_orientable.len() as u32;
            self.patch_is_orientable.push(true);
            self.face_patches[seed] = patch;
            queue.clear();
            queue.push(seed as u32);
            let mut turned = 0;
            let mut at = 0;
            while let Some(&polygon) = queue.get(at) {
                at += 1;
                let is_turned = self.turned[polygon as usize];
                turned += usize::from(is_turned);
                for side in soup.starts[polygon as usize]..soup.starts[polygon as usize + 1] {
                    let &[s, t] = sides.of(sides.edge_of[side as usize] as usize) else { continue };
                    let other = sides.polygons[if s == side { t } else { s } as usize] as usize;
                    let agree = sides.is_forward(soup, s) != sides.is_forward(soup, t);
                    if self.face_patches[other] == NONE {
                        self.face_patches[other] = patch;
                        self.turned[other] = is_turned == agree;
                        queue.push(other as u32);
                    } else if (self.turned[other] == is_turned) != agree {
                        self.patch_is_orientable[patch as usize] = false;
                        self.conflicts.push(sides.edge_of[side as usize]);
                    }
                }
            }
            if !self.patch_is_orientable[patch as usize] {
                // What is turned against what has no meaning here.
                queue.iter().for_each(|&polygon| self.turned[polygon as usize] = false);
            } else if 2 * turned > queue.len() {
                for &polygon in &queue {
                    self.turned[polygon as usize] ^= true;
                }
            }
        }
        self.conflicts.sort_unstable();
        self.conflicts.dedup();
        for edge in 0..sides.edges.len() {
            let &[s, t] = sides.of(edge) else { continue };
            let patch = self.face_patches[sides.polygons[s as usize] as usize];
            if self.patch_is_orientable[patch as usize]
                && sides.is_forward(soup, s) == sides.is_forward(soup, t)
            {
                self.disagreeing.push(edge as u32);
            }
        }
    }
}

fn components(soup: &Soup, sides: &Sides) -> (Vec<u32>, usize) {
    let mut groups = Groups::new(soup.polygon_count());
    for edge in 0..sides.edges.len() {
        for pair in sides.of(edge).windows(2) {
            groups.join(sides.polygons[pair[0] as usize], sides.polygons[pair[1] as usize]);
        }
    }
    // Roots are the first of their groups, so they come before the rest.
    let mut numbers = vec![0; soup.polygon_count()];
    let mut count = 0;
    for polygon in 0..soup.polygon_count() {
        let root = groups.root(polygon as u32) as usize;
        if root == polygon {
            numbers[polygon] = count;
            count += 1;
        } else {
            numbers[polygon] = numbers[root];
        }
    }
    (numbers, count as usize)
}

/// Joins the corners of each vertex across sides of the same edge and the same class.
pub(super) fn fans(soup: &Soup, sides: &Sides, classes: &[u32]) -> Groups {
    let mut fans = Groups::new(soup.corners.len());
    let mut sorted = Vec::new();
    for edge in 0..sides.edges.len() {
        sorted.clear();
        sorted.extend_from_slice(sides.of(edge));
        sorted.sort_by_key(|&side| classes[side as usize]);
        for pair in sorted.windows(2) {
            if classes[pair[0] as usize] == classes[pair[1] as usize] {
                let ([a, b], [c, d]) = (sides.ends(soup, pair[0]), sides.ends(soup, pair[1]));
                fans.join(a, c);
                fans.join(b, d);
            }
        }
    }
    fans
}

/// Chains the boundary. Where it passes through a vertex it goes on at the other end of the same fan, so that loops are
/// those of the surface with its bow-ties split.
fn loops(soup: &Soup, sides: &Sides, boundary: &[u32], fans: &mut Groups) -> Vec<Loop> {
    let own: Vec<u32> = boundary.iter().map(|&edge| sides.of(edge as usize)[0]).collect();
    // Ends of boundary sides: 2i where the i-th begins, 2i + 1 where it ends.
    let corner = |end: u32| {
        let side = own[end as usize / 2];
        if end.is_multiple_of(2) { side } else { sides.next[side as usize] }
    };
    let mut ends: Vec<(u32, u32)> =
        (0..2 * own.len() as u32).map(|end| (fans.root(corner(end)), end)).collect();
    ends.sort_unstable();
    let mut mates = vec![NONE; ends.len()];
    for fan in ends.chunk_by(|a, b| a.0 == b.0) {
        for pair in fan.chunks_exact(2) {
            mates[pair[0].1 as usize] = pair[1].1;
            mates[pair[1].1 as usize] = pair[0].1;
        }
    }
    let mut seen = vec![false; own.len()];
    let mut loops = Vec::new();
    for seed in 0..own.len() as u32 {
        if seen[seed as usize] {
            continue;
        }
        // Back to where the chain begins, or once around.
        let mut start = 2 * seed;
        while mates[start as usize] != NONE && mates[start as usize] / 2 != seed {
            start = mates[start as usize] ^ 1;
        }
        let is_closed = mates[start as usize] != NONE;
        if is_closed {
            start = 2 * seed;
        }
        let mut chain = Loop { vertices: Vec::new(), sides: Vec::new(), is_closed };
        let mut end = start;
        while end != NONE && !seen[end as usize / 2] {
            seen[end as usize / 2] = true;
            chain.sides.push(own[end as usize / 2]);
            chain.vertices.push(soup.corners[corner(end) as usize]);
            end ^= 1;
            if !is_closed && mates[end as usize] == NONE {
                chain.vertices.push(soup.corners[corner(end) as usize]);
            }
            end = mates[end as usize];
        }
        loops.push(chain);
    }
    loops
}
