//! Boundary vertices at one place, or nearly, made one.
//!
//! Files that store triangles one by one, or a vertex once for each of its texture coordinates, fall apart along edges
//! that lie on each other. Only boundary vertices are looked at, and only such are merged as close an edge: what merely
//! touches stays apart.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits; cells of a box are counted in 64"
)]

use std::collections::HashMap;

use nalgebra::Vector3;

use super::surface::Surface;
use crate::mesh::Soup;
use crate::mesh::doctor::{Sides, drop_repeated};

/// The least tolerance that is looked for, in parts of the diagonal: places are compared in the box of the surface, where
/// they are rounded to 10⁻¹⁶ of it. Cells of less would crowd as many places as one likes into one, or have no number.
const LEAST: f64 = 1e-15;

/// What a weld would do.
pub(super) struct Weld {
    /// Vertices and what each becomes, another vertex with a smaller number; in increasing order.
    pub merges: Vec<[u32; 2]>,
    /// How many boundary edges it closes.
    pub closable: usize,
    /// How many boundary edges there are.
    pub boundary: usize,
}

/// Finds the boundary vertices whose merging closes edges.
///
/// **Takes** a tolerance in parts of the diagonal of the bounding box; below [`LEAST`] only what is equal is near. Each
/// vertex joins the first one before it within the tolerance that did not itself join another: places do not chain up.
pub(super) fn plan(soup: &Soup, sides: &Sides, surface: &Surface, tolerance: f64) -> Weld {
    let boundary: Vec<[u32; 2]> = (0..sides.edges.len())
        .filter(|&e| sides.of(e).len() == 1)
        .map(|e| sides.edges[e])
        .collect();
    let mut vertices = boundary.concat();
    vertices.sort_unstable();
    vertices.dedup();
    // What is equal is near: only one vertex of each place needs a search.
    let mut firsts = equal(&vertices, soup);
    if tolerance >= LEAST && surface.extent > 0.0 {
        let mut places = firsts.clone();
        places.sort_unstable();
        places.dedup();
        let nears = nearby(&places, surface, tolerance * surface.diagonal / surface.extent);
        for first in &mut firsts {
            if let Ok(i) = places.binary_search(first) {
                *first = nears[i];
            }
        }
    }
    let first = |v: u32| match vertices.binary_search(&v) {
        Ok(i) => firsts[i],
        Err(_) => v,
    };

    let mut names: Vec<([u32; 2], [u32; 2])> = boundary
        .iter()
        .map(|&edge| {
            let [a, b] = edge.map(first);
            ([a.min(b), a.max(b)], edge)
        })
        .filter(|&([a, b], _)| a != b)
        .collect();
    names.sort_unstable();
    let mut weld = Weld { merges: Vec::new(), closable: 0, boundary: boundary.len() };
    for same in names.chunk_by(|a, b| a.0 == b.0) {
        let [a, b] = same[0].0;
        let is_inside = sides.find(a, b).is_some_and(|edge| sides.of(edge).len() > 1);
        if same.len() == 2 && !is_inside {
            weld.closable += 2;
            let ends = same.iter().flat_map(|(_, edge)| edge);
            weld.merges.extend(ends.map(|&v| [v, first(v)]).filter(|[v, first]| v != first));
        }
    }
    weld.merges.sort_unstable();
    weld.merges.dedup();
    weld
}

/// For each of the vertices the first at the same place.
fn equal(vertices: &[u32], soup: &Soup) -> Vec<u32> {
    // Adding 0 makes −0 and 0 the same.
    let bits = |v: u32| soup.positions[v as usize].map(|x| (x + 0.0).to_bits());
    let mut firsts = HashMap::with_capacity(vertices.len());
    vertices.iter().map(|&v| *firsts.entry(bits(v)).or_insert(v)).collect()
}

/// For each of the vertices the first within the tolerance that has none before it.
fn nearby(vertices: &[u32], surface: &Surface, tolerance: f64) -> Vec<u32> {
    // Cells of twice the tolerance: a ball reaches into two of them along each axis. Chains of firsts per cell.
    let cell = 2.0 * tolerance;
    let place = |p: &Vector3<f64>| [p.x, p.y, p.z].map(|x| (x / cell).floor() as i64);
    let mut heads: HashMap<[i64; 3], u32> = HashMap::with_capacity(vertices.len());
    let mut nexts = vec![u32::MAX; vertices.len()];
    let mut firsts = Vec::with_capacity(vertices.len());
    for (i, &v) in vertices.iter().enumerate() {
        let p = surface.points[v as usize];
        let shifted = |sign: f64| place(&p.add_scalar(sign * tolerance));
        let (low, high) = (shifted(-1.0), shifted(1.0));
        let mut found: Option<u32> = None;
        for corner in 0..8 {
            let key = [0, 1, 2].map(|k| if corner >> k & 1 == 0 { low[k] } else { high[k] });
            if (0..3).any(|k| corner >> k & 1 == 1 && low[k] == high[k]) {
                continue;
            }
            let mut at = heads.get(&key).copied().unwrap_or(u32::MAX);
            while at != u32::MAX {
                let other = vertices[at as usize];
                if (surface.points[other as usize] - p).norm() <= tolerance {
                    found = Some(found.map_or(other, |best| best.min(other)));
                }
                at = nexts[at as usize];
            }
        }
        if found.is_none() {
            let head = heads.entry(place(&p)).or_insert(u32::MAX);
            nexts[i] = *head;
            *head = i as u32;
        }
        firsts.push(found.unwrap_or(v));
    }
    firsts
}

/// Merges boundary vertices within a part of the bounding box diagonal where that closes edges; counts the vertices that
/// became another. Polygons that shrink to less than three corners are dropped.
pub fn weld(soup: &Soup, tolerance: f64) -> (Soup, usize) {
    let weld = plan(soup, &Sides::new(soup), &Surface::new(soup), tolerance);
    if weld.merges.is_empty() {
        return (soup.clone(), 0);
    }
    let mut names = Vec::from_iter(0..soup.positions.len() as u32);
    for &[v, first] in &weld.merges {
        names[v as usize] = first;
    }
    (drop_repeated(&renamed(soup, &names)).0, weld.merges.len())
}

/// The soup with each vertex called as the list says.
pub(super) fn renamed(soup: &Soup, names: &[u32]) -> Soup {
    let mut result = soup.clone();
    for v in &mut result.corners {
        *v = names[*v as usize];
    }
    result
}
