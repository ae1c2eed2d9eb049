//! Polygons without area, taken out so that no hole opens.
//!
//! A triangle without area is a needle, two of whose corners (nearly) coincide, or a cap, one of whose corners lies on the
//! opposite side. The two corners of a needle become one; a cap hands the corner on its longest side to the polygon
//! beyond, whose side then has the two short ones of the cap as its parts. What hangs on edges that have enough other
//! polygons is just dropped.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use super::surface::Surface;
use super::weld::renamed;
use crate::mesh::Soup;
use crate::mesh::doctor::{Corner, Rebuild, Sides, drop_repeated, keep_polygons, repeated};

/// How near to an end of its longest side, in parts of it, the tip of a needle lies.
const NEEDLE: f64 = 1e-9;
/// Rounds after which what is left is dropped as it is. Neighbours wait for each other, so crowded places need several.
const ROUNDS: usize = 64;
/// Rounds after which each must rid the mesh of a tenth of what is left, lest thousands around one vertex cost a round each.
const PATIENCE: usize = 12;

/// The polygons without area.
pub(super) fn degenerate(soup: &Soup, surface: &Surface) -> Vec<u32> {
    let polygons = 0..soup.polygon_count();
    polygons.filter(|&i| surface.is_degenerate(soup, i)).map(|i| i as u32).collect()
}

/// Those of a list of polygons that may be dropped one after the other without an edge losing its last or last but one
/// other side.
pub(super) fn harmless(soup: &Soup, sides: &Sides, faults: &[u32]) -> Vec<u32> {
    let mut gone = vec![0u32; if faults.is_empty() { 0 } else { sides.edges.len() }];
    let mut found = Vec::new();
    for &fault in faults {
        let own = soup.starts[fault as usize]..soup.starts[fault as usize + 1];
        let edges = Vec::from_iter(own.map(|side| sides.edge_of[side as usize] as usize));
        if edges.iter().all(|&e| sides.of(e).len() as u32 - gone[e] != 2) {
            edges.iter().for_each(|&e| gone[e] += 1);
            found.push(fault);
        }
    }
    found
}

/// Takes out all polygons without area; counts them. Nothing is left where none has any.
pub fn drop_degenerate(soup: &Soup) -> (Soup, usize) {
    let mut result = soup.clone();
    let mut count = 0;
    let mut before = usize::MAX;
    for round in 0..=ROUNDS {
        if !repeated(&result).is_empty() {
            result = drop_repeated(&result).0;
        }
        let surface = Surface::new(&result);
        let faults = degenerate(&result, &surface);
        count = count.max(faults.len());
        if faults.is_empty() {
            break;
        }
        let is_slow = round > PATIENCE && faults.len() > before / 10 * 9;
        let is_last = round == ROUNDS || is_slow || faults.len() == result.polygon_count();
        before = faults.len();
        result = if is_last {
            keep_polygons(&result, |i| faults.binary_search(&i).is_err())
        } else {
            Round::new(&result, &surface).take_out(&faults)
        };
    }
    (result, count)
}

/// What one round does to which polygon. Polygons around a place that changes are locked until the next round.
struct Round<'a> {
    soup: &'a Soup,
    surface: &'a Surface,
    sides: Sides,
    /// The corners of each vertex.
    stars: Vec<u32>,
    star_starts: Vec<u32>,
    is_locked: Vec<bool>,
    names: Vec<u32>,
    is_dropped: Vec<bool>,
    /// Sides that get a corner: side, the corner of the cap, where on the side.
    inserted: Vec<(u32, u32, f64)>,
}

impl<'a> Round<'a> {
    fn new(soup: &'a Soup, surface: &'a Surface) -> Self {
        let mut star_starts = vec![0u32; soup.positions.len() + 1];
        for &v in &soup.corners {
            star_starts[v as usize + 1] += 1;
        }
        for v in 0..soup.positions.len() {
            star_starts[v + 1] += star_starts[v];
        }
        let mut slots = star_starts.clone();
        let mut stars = vec![0; soup.corners.len()];
        for (corner, &v) in soup.corners.iter().enumerate() {
            stars[slots[v as usize] as usize] = corner as u32;
            slots[v as usize] += 1;
        }
        Self {
            soup,
            surface,
            sides: Sides::new(soup),
            stars,
            star_starts,
            is_locked: vec![false; soup.polygon_count()],
            names: (0..soup.positions.len() as u32).collect(),
            is_dropped: vec![false; soup.polygon_count()],
            inserted: Vec::new(),
        }
    }

    fn star(&self, v: u32) -> &[u32] {
        &self.stars
            [self.star_starts[v as usize] as usize..self.star_starts[v as usize + 1] as usize]
    }

    /// Whether no polygon at these vertices has changed; if so, they are locked.
    fn lock(&mut self, vertices: &[u32]) -> bool {
        let corners = || vertices.iter().flat_map(|&v| self.star(v));
        let polygons = || corners().map(|&c| self.sides.polygons[c as usize] as usize);
        if polygons().any(|i| self.is_locked[i]) {
            return false;
        }
        for i in Vec::from_iter(polygons()) {
            self.is_locked[i] = true;
        }
        true
    }

    fn take_out(mut self, faults: &[u32]) -> Soup {
        for fault in harmless(self.soup, &self.sides, faults) {
            self.is_dropped[fault as usize] = true;
            self.is_locked[fault as usize] = true;
        }
        let mut split = Vec::new();
        for &fault in faults {
            if self.is_dropped[fault as usize] {
                continue;
            }
            if self.soup.polygon(fault as usize).len() > 3 {
                split.push(fault);
            } else if self.lock(self.soup.polygon(fault as usize)) {
                self.triangle(fault as usize);
            }
        }
        self.inserted.sort_by_key(|&(side, ..)| side);
        self.rebuild(&split)
    }

    fn triangle(&mut self, fault: usize) {
        let begin = self.soup.starts[fault];
        let corner = |k: usize| begin + (k % 3) as u32;
        let vertex = |k: usize| self.soup.corners[corner(k) as usize];
        let point = |k: usize| self.surface.points[vertex(k) as usize];
        let squared = |k: usize| (point(k + 1) - point(k)).norm_squared();
        let mut longest = 0;
        for k in 1..3 {
            if squared(k) > squared(longest) {
                longest = k;
            }
        }
        // Where the tip stands on the longest side.
        let (a, b, tip) = (point(longest), point(longest + 1), point(longest + 2));
        let t = (tip - a).dot(&(b - a)) / squared(longest);
        let (own, tip) = (corner(longest), vertex(longest + 2));
        let near = if t < 0.5 { vertex(longest) } else { vertex(longest + 1) };
        if !(t.min(1.0 - t) > NEEDLE) {
            if self.may_merge(near, tip) {
                self.names[near.max(tip) as usize] = near.min(tip);
            } else {
                self.is_dropped[fault] = true;
            }
            return;
        }
        self.is_dropped[fault] = true;
        let others = self.sides.of(self.sides.edge_of[own as usize] as usize);
        let Some(&beyond) = others.iter().find(|&&side| side != own) else { return };
        let polygon = self.sides.polygons[beyond as usize] as usize;
        if !self.soup.polygon(polygon).contains(&tip) {
            let is_along = self.soup.corners[beyond as usize] == self.soup.corners[own as usize];
            self.inserted.push((beyond, corner(longest + 2), if is_along { t } else { 1.0 - t }));
        }
    }

    /// Whether making one vertex of two leaves a surface: their common neighbours are those across from their edge, and a
    /// surface of two boundaries is not pinched between them.
    fn may_merge(&self, v: u32, w: u32) -> bool {
        let Some(edge) = self.sides.find(v, w) else { return false };
        let neighbours = |v: u32| {
            let around = self.star(v).iter().flat_map(|&corner| {
                let polygon = self.soup.polygon(self.sides.polygons[corner as usize] as usize);
                let at = (corner - self.soup.starts[self.sides.polygons[corner as usize] as usize])
                    as usize;
                [
                    polygon[(at + 1) % polygon.len()],
                    polygon[(at + polygon.len() - 1) % polygon.len()],
                ]
            });
            let mut around = Vec::from_iter(around);
            around.sort_unstable();
            around.dedup();
            around
        };
        let beyond = neighbours(w);
        let common = neighbours(v).into_iter().filter(|u| beyond.binary_search(u).is_ok());
        let across = self.sides.of(edge).iter().filter_map(|&side| {
            let polygon = self.soup.polygon(self.sides.polygons[side as usize] as usize);
            polygon.iter().copied().find(|&u| polygon.len() == 3 && u != v && u != w)
        });
        let mut across = Vec::from_iter(across);
        across.sort_unstable();
        across.dedup();
        let is_rim = |v: u32| {
            self.star(v).iter().any(|&corner| {
                let polygon = self.sides.polygons[corner as usize] as usize;
                let own = self.soup.starts[polygon]..self.soup.starts[polygon + 1];
                own.into_iter().any(|side| {
                    let edge = self.sides.edge_of[side as usize] as usize;
                    self.sides.edges[edge].contains(&v) && self.sides.of(edge).len() == 1
                })
            })
        };
        common.eq(across) && (self.sides.of(edge).len() == 1 || !(is_rim(v) && is_rim(w)))
    }

    /// The triangles of a polygon without area. Two caps back to back become a quadrilateral, which the longer diagonal
    /// would make two caps again.
    fn pieces(&self, polygon: usize) -> Vec<[u32; 3]> {
        let corners = Vec::from_iter(self.soup.starts[polygon]..self.soup.starts[polygon + 1]);
        let &[a, b, c, d] = &corners[..] else { return self.surface.of(polygon).to_vec() };
        let point = |corner: u32| self.surface.points[self.soup.corners[corner as usize] as usize];
        if (point(c) - point(a)).norm() < (point(d) - point(b)).norm() {
            vec![[a, b, c], [c, d, a]]
        } else {
            vec![[b, c, d], [d, a, b]]
        }
    }

    fn rebuild(&self, split: &[u32]) -> Soup {
        let mut rebuild = Rebuild::new(self.soup);
        let mut next = self.inserted.iter().copied().peekable();
        for i in 0..self.soup.polygon_count() {
            if self.is_dropped[i] {
                continue;
            }
            if split.binary_search(&(i as u32)).is_ok() {
                for t in self.pieces(i) {
                    rebuild.polygon(i, t.map(|corner| Corner::of(self.soup, corner as usize)));
                }
                continue;
            }
            let mut corners = Vec::with_capacity(4);
            for side in self.soup.starts[i]..self.soup.starts[i + 1] {
                let corner = Corner::of(self.soup, side as usize);
                corners.push(corner);
                if let Some((_, tip, t)) = next.next_if(|&(at, ..)| at == side) {
                    let end = Corner::of(self.soup, self.sides.next[side as usize] as usize);
                    let vertex = self.soup.corners[tip as usize];
                    corners.push(rebuild.between(corner, end, t, vertex));
                }
            }
            rebuild.polygon(i, corners);
        }
        renamed(&rebuild.finish(), &self.names)
    }
}
