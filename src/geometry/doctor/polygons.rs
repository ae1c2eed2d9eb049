//! Polygons whose triangles do not fit the rest.
//!
//! A diagonal of a polygon is an edge of two triangles. It must not join vertices that a side or another diagonal joins too,
//! because edges are told apart by their ends; and no triangle may name a vertex twice.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use std::collections::BTreeSet;

use super::surface::{Surface, doubled_normal};
use crate::mesh::Soup;
use crate::mesh::doctor::{Corner, Rebuild, Sides};

/// A polygon whose triangles do not fit, and the diagonals at fault by their corners, the smaller first.
pub(super) struct Folded {
    pub polygon: u32,
    diagonals: Vec<[u32; 2]>,
}

/// Finds the polygons whose triangles do not fit, in increasing order.
pub(super) fn folded(soup: &Soup, sides: &Sides, surface: &Surface) -> Vec<Folded> {
    let diagonals = diagonals(soup, sides, surface);
    let mut faults: Vec<(u32, Option<[u32; 2]>)> = Vec::new();
    for same in diagonals.chunk_by(|a, b| a.0 == b.0) {
        // The first may stay if no side has this name.
        let [a, b] = same[0].0;
        let stays = usize::from(a != b && sides.find(a, b).is_none());
        faults.extend(same[stays..].iter().map(|&(_, polygon, corners)| (polygon, Some(corners))));
    }
    for polygon in (0..soup.polygon_count()).filter(|&i| soup.polygon(i).len() > 3) {
        let names = |t: &[u32; 3]| t.map(|corner| soup.corners[corner as usize]);
        if surface.of(polygon).iter().map(names).any(|[a, b, c]| a == b || b == c || c == a) {
            faults.push((polygon as u32, None));
        }
    }
    faults.sort_unstable();
    let same = faults.chunk_by(|a, b| a.0 == b.0);
    same.map(|faults| Folded {
        polygon: faults[0].0,
        diagonals: faults.iter().filter_map(|fault| fault.1).collect(),
    })
    .collect()
}

/// All diagonals: end vertices, polygon, end corners; in increasing order.
fn diagonals(soup: &Soup, sides: &Sides, surface: &Surface) -> Vec<([u32; 2], u32, [u32; 2])> {
    let mut found = Vec::new();
    for polygon in (0..soup.polygon_count()).filter(|&i| soup.polygon(i).len() > 3) {
        for t in surface.of(polygon) {
            for [c, d] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                // Each diagonal is met twice, once in each direction.
                if c < d && sides.next[c as usize] != d && sides.next[d as usize] != c {
                    let [v, w] = [c, d].map(|corner| soup.corners[corner as usize]);
                    found.push(([v.min(w), v.max(w)], polygon as u32, [c, d]));
                }
            }
        }
    }
    found.sort_unstable();
    found
}

/// Replaces polygons whose triangles do not fit by triangles that do; counts the polygons.
///
/// A quadrilateral is split along the other diagonal where that is sound; otherwise the diagonals at fault get a vertex
/// in the middle. A polygon that visits a vertex several times gets copies of it first: the surface opens there.
pub fn split_polygons(soup: &Soup) -> (Soup, usize) {
    // Once for copies, once for diagonals; a third time finds nothing.
    const PASSES: usize = 4;
    let mut result = soup.clone();
    let mut count = 0;
    for _ in 0..PASSES {
        let sides = Sides::new(&result);
        let surface = Surface::new(&result);
        let faults = folded(&result, &sides, &surface);
        if faults.is_empty() {
            break;
        }
        count = count.max(faults.len());
        result = split(&result, &sides, &surface, &faults);
    }
    (result, count)
}

fn split(soup: &Soup, sides: &Sides, surface: &Surface, faults: &[Folded]) -> Soup {
    let mut taken: BTreeSet<[u32; 2]> =
        diagonals(soup, sides, surface).into_iter().map(|diagonal| diagonal.0).collect();
    let mut rebuild = Rebuild::new(soup);
    let mut faulty = faults.iter().peekable();
    for i in 0..soup.polygon_count() {
        let Some(fault) = faulty.next_if(|fault| fault.polygon as usize == i) else {
            rebuild.keep(i);
            continue;
        };
        let corners = Vec::from_iter(soup.starts[i]..soup.starts[i + 1]);
        if visits_again(soup.polygon(i)) {
            let separated = separate_visits(&mut rebuild, soup, &corners);
            rebuild.polygon(i, separated);
        } else if let Some(triangles) = other_diagonal(soup, sides, surface, &corners, &taken) {
            let [a, b] = [triangles[0][0], triangles[0][2]].map(|c| soup.corners[c as usize]);
            let name = [a.min(b), a.max(b)];
            taken.insert(name);
            for t in triangles {
                rebuild.polygon(i, t.map(|corner| Corner::of(soup, corner as usize)));
            }
        } else {
            halve_diagonals(&mut rebuild, soup, surface, i, &fault.diagonals);
        }
    }
    rebuild.finish()
}

fn visits_again(polygon: &[u32]) -> bool {
    let mut sorted = polygon.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).any(|pair| pair[0] == pair[1])
}

/// The corners of a polygon with a copy of the vertex for each later visit.
fn separate_visits(rebuild: &mut Rebuild, soup: &Soup, corners: &[u32]) -> Vec<Corner> {
    let mut seen = BTreeSet::new();
    let separated = corners.iter().map(|&corner| {
        let mut corner = Corner::of(soup, corner as usize);
        if !seen.insert(corner.vertex) {
            corner.vertex = rebuild.add_vertex(soup.positions[corner.vertex as usize]);
        }
        corner
    });
    separated.collect()
}

/// A quadrilateral split along the diagonal that [`crate::geometry::polygon::triangulate`] does not take, if nothing
/// else joins its ends and both triangles face where the polygon does.
fn other_diagonal(
    soup: &Soup,
    sides: &Sides,
    surface: &Surface,
    corners: &[u32],
    taken: &BTreeSet<[u32; 2]>,
) -> Option<[[u32; 3]; 2]> {
    let &[a, b, c, d] = corners else { return None };
    let polygon = sides.polygons[a as usize] as usize;
    let used_ac = surface.of(polygon).iter().all(|t| t.contains(&a) && t.contains(&c));
    let split = if used_ac { [[b, c, d], [d, a, b]] } else { [[a, b, c], [c, d, a]] };
    let [v, w] = [split[0][0], split[0][2]].map(|corner| soup.corners[corner as usize]);
    let is_free = sides.find(v, w).is_none() && !taken.contains(&[v.min(w), v.max(w)]);
    let normal = surface.normal(soup, polygon);
    let is_sound = split.iter().all(|&t| {
        let own = doubled_normal(surface.corners(soup, t));
        // Half a degree off edge-on: the triangle is no sliver for want of a vertex.
        own.dot(&normal) > 0.01 * own.norm() * normal.norm()
    });
    (is_free && is_sound).then_some(split)
}

/// Appends the triangles of a polygon with a vertex in the middle of the diagonals at fault.
fn halve_diagonals(
    rebuild: &mut Rebuild,
    soup: &Soup,
    surface: &Surface,
    polygon: usize,
    faults: &[[u32; 2]],
) {
    let mut middles = Vec::with_capacity(faults.len());
    for &[c, d] in faults {
        let (c, d) = (Corner::of(soup, c as usize), Corner::of(soup, d as usize));
        let [p, q] = [c, d].map(|corner| soup.positions[corner.vertex as usize]);
        let vertex = rebuild.add_vertex([0, 1, 2].map(|k| p[k] + 0.5 * (q[k] - p[k])));
        middles.push(rebuild.between(c, d, 0.5, vertex));
    }
    for &t in surface.of(polygon) {
        let corners = t.map(|corner| Corner::of(soup, corner as usize));
        let middle = |k: usize| {
            let [c, d] = [t[k], t[(k + 1) % 3]];
            faults.binary_search(&[c.min(d), c.max(d)]).ok().map(|i| middles[i])
        };
        // The side that follows the last whole one comes first: one case for each number of halved sides.
        let halves = [middle(0), middle(1), middle(2)];
        let first = (0..3).find(|&k| halves[k].is_some() && halves[(k + 2) % 3].is_none());
        let k = first.unwrap_or(0);
        let [a, b, c] = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]];
        let pieces = match [halves[k], halves[(k + 1) % 3], halves[(k + 2) % 3]] {
            [Some(m), Some(n), Some(o)] => vec![[a, m, o], [b, n, m], [c, o, n], [m, n, o]],
            [Some(m), Some(n), None] => vec![[m, b, n], [a, m, n], [a, n, c]],
            [Some(m), None, None] => vec![[a, m, c], [m, b, c]],
            _ => vec![corners],
        };
        for piece in pieces {
            rebuild.polygon(polygon, piece);
        }
    }
}
