//! Repairs that need connectivity only. Each gives the soup and how many places it changed.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use std::collections::VecDeque;

use super::shape::fans;
use super::{Corner, Groups, Rebuild, Shape, Sides};
use crate::mesh::Soup;

const NONE: u32 = u32::MAX;

/// The polygons that name a vertex twice in a row, run out to a vertex and straight back, or have fewer than three corners.
pub fn repeated(soup: &Soup) -> Vec<u32> {
    (0..soup.polygon_count() as u32).filter(|&i| is_repeated(soup.polygon(i as usize))).collect()
}

fn is_repeated(polygon: &[u32]) -> bool {
    let n = polygon.len();
    n < 3
        || (0..n).any(|i| polygon[i] == polygon[(i + 1) % n] || polygon[i] == polygon[(i + 2) % n])
}

/// Takes repetitions and spikes out of polygons; what has fewer than three corners then is dropped.
pub fn drop_repeated(soup: &Soup) -> (Soup, usize) {
    let faults = repeated(soup);
    (without_repetitions(soup, &faults).0, faults.len())
}

/// Takes repetitions and spikes out of the polygons of an increasing list, and drops what has fewer than three corners
/// then. **Gives** the soup, and for each of its polygons which it was.
pub fn without_repetitions(soup: &Soup, faults: &[u32]) -> (Soup, Vec<u32>) {
    let mut rebuild = Rebuild::new(soup);
    let mut origins = Vec::with_capacity(soup.polygon_count());
    let mut faulty = faults.iter().copied().peekable();
    for i in 0..soup.polygon_count() {
        if faulty.next_if_eq(&(i as u32)).is_none() {
            rebuild.keep(i);
            origins.push(i as u32);
            continue;
        }
        let corners = unspiked(soup, i);
        if corners.len() >= 3 {
            rebuild.polygon(i, corners);
            origins.push(i as u32);
        }
    }
    (rebuild.finish(), origins)
}

/// The corners of a polygon without repetitions and spikes.
fn unspiked(soup: &Soup, polygon: usize) -> Vec<Corner> {
    let mut left = VecDeque::<Corner>::new();
    for corner in soup.starts[polygon]..soup.starts[polygon + 1] {
        let corner = Corner::of(soup, corner as usize);
        let before = |k: usize| left.len().checked_sub(k).map(|i| left[i].vertex);
        if before(1) == Some(corner.vertex) {
            continue;
        }
        if before(2) == Some(corner.vertex) {
            left.pop_back();
            continue;
        }
        left.push_back(corner);
    }
    // The same across the end of the list.
    loop {
        let at = |i: usize| left.get(i).map(|c| c.vertex);
        let last = |k: usize| left.len().checked_sub(k).and_then(at);
        if left.len() < 3 {
            break left.into();
        } else if last(1) == at(0) {
            left.pop_back();
        } else if last(2) == at(0) {
            left.pop_back();
            left.pop_back();
        } else if last(1) == at(1) {
            left.pop_front();
            left.pop_front();
        } else {
            break left.into();
        }
    }
}

/// The polygons that an earlier one repeats, begun anywhere and turned either way.
pub fn duplicates(soup: &Soup) -> Vec<u32> {
    // Polygons with the same vertices have the same key; few others have.
    let mut keys: Vec<([u64; 3], u32)> = (0..soup.polygon_count())
        .map(|i| {
            let polygon = soup.polygon(i);
            let low = polygon.iter().min().copied().unwrap_or(0);
            let high = polygon.iter().max().copied().unwrap_or(0);
            let sum = polygon.iter().map(|&v| u64::from(v)).sum();
            ([(u64::from(low) << 32) | u64::from(high), polygon.len() as u64, sum], i as u32)
        })
        .collect();
    keys.sort_unstable();
    let mut found = Vec::new();
    for same in keys.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
        let mut rings: Vec<(Vec<u32>, u32)> =
            same.iter().map(|&(_, i)| (ring(soup.polygon(i as usize)), i)).collect();
        rings.sort_unstable();
        let pairs = rings.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        found.extend(pairs.map(|pair| pair[1].1));
    }
    found.sort_unstable();
    found
}

/// The same list for a polygon wherever it begins and whichever way it turns: begun at its smallest vertex, the smaller
/// list of both directions. Only the first visits of that vertex are tried, lest a hostile polygon cost n².
fn ring(polygon: &[u32]) -> Vec<u32> {
    const VISITS: usize = 8;
    let n = polygon.len();
    let low = polygon.iter().min();
    let starts = (0..n).filter(|&i| Some(&polygon[i]) == low).take(VISITS);
    let turns = starts.flat_map(|i| {
        let forward = Vec::from_iter((0..n).map(|k| polygon[(i + k) % n]));
        let backward = Vec::from_iter((0..n).map(|k| polygon[(i + n - k) % n]));
        [forward, backward]
    });
    turns.min().unwrap_or_default()
}

/// Drops the polygons that an earlier one repeats.
pub fn drop_duplicates(soup: &Soup) -> (Soup, usize) {
    let faults = duplicates(soup);
    (keep_polygons(soup, |i| faults.binary_search(&i).is_err()), faults.len())
}

/// The soup with some of its polygons only; vertices stay.
pub fn keep_polygons(soup: &Soup, is_kept: impl Fn(u32) -> bool) -> Soup {
    let mut rebuild = Rebuild::new(soup);
    (0..soup.polygon_count()).filter(|&i| is_kept(i as u32)).for_each(|i| rebuild.keep(i));
    rebuild.finish()
}

/// The soup with some of its polygons turned; each keeps its first corner.
pub fn turn(soup: &Soup, is_turned: impl Fn(u32) -> bool) -> Soup {
    let mut result = soup.clone();
    for i in (0..soup.polygon_count()).filter(|&i| is_turned(i as u32)) {
        let tail = soup.starts[i] as usize + 1..soup.starts[i + 1] as usize;
        for list in [&mut result.corners, &mut result.texture_corners, &mut result.normal_corners] {
            if let Some(tail) = list.get_mut(tail.clone()) {
                tail.reverse();
            }
        }
    }
    result
}

/// Gives every fan but one its own copy of the vertex, where fans reach across sides of the same edge and class only.
///
/// **Takes** a class for every side, and which vertices may be copied. **Gives** the soup, in which the largest fan keeps
/// the vertex, and the number of copies. Sides of an edge in different classes still name the same vertices where both
/// of its ends are the same fan.
pub fn separate(
    soup: &Soup,
    sides: &Sides,
    classes: &[u32],
    may_copy: impl Fn(u32) -> bool,
) -> (Soup, usize) {
    let mut fans: Groups = fans(soup, sides, classes);
    let roots: Vec<u32> = (0..soup.corners.len() as u32).map(|c| fans.root(c)).collect();
    let mut sizes = vec![0u32; roots.len()];
    for &root in &roots {
        sizes[root as usize] += 1;
    }
    let mut keepers = vec![NONE; soup.positions.len()];
    for (&v, &root) in soup.corners.iter().zip(&roots) {
        let keeper = &mut keepers[v as usize];
        if *keeper == NONE || sizes[root as usize] > sizes[*keeper as usize] {
            *keeper = root;
        }
    }
    let mut result = soup.clone();
    let mut copies = vec![NONE; roots.len()];
    for (corner, &root) in roots.iter().enumerate() {
        let v = soup.corners[corner];
        if keepers[v as usize] == root || !may_copy(v) {
            continue;
        }
        if copies[root as usize] == NONE {
            copies[root as usize] = result.positions.len() as u32;
            result.positions.push(soup.positions[v as usize]);
        }
        result.corners[corner] = copies[root as usize];
    }
    let count = result.positions.len() - soup.positions.len();
    (result, count)
}

/// Splits every vertex with more than one fan; counts these vertices.
pub fn split_vertices(soup: &Soup) -> (Soup, usize) {
    let sides = Sides::new(soup);
    let shape = Shape::new(soup, &sides);
    let is_split = |v: u32| shape.bow_ties.binary_search(&v).is_ok();
    (separate(soup, &sides, &sides.edge_of, is_split).0, shape.bow_ties.len())
}

/// Cuts the surface along the edges where its orientation fails, so that every part has two sides; counts the edges.
///
/// At an inner vertex such edges meet in even number, and cut its fan into as many; at a boundary vertex k of them cut it
/// into k + 1. So both sides of a cut edge get different ends, unless a third side at another edge holds them together:
/// such edges are to be split before.
pub fn open_one_sided(soup: &Soup) -> (Soup, usize) {
    let sides = Sides::new(soup);
    let shape = Shape::new(soup, &sides);
    let mut classes = sides.edge_of.clone();
    let mut ends = Vec::new();
    for (i, &edge) in shape.conflicts.iter().enumerate() {
        classes[sides.of(edge as usize)[1] as usize] = (sides.edges.len() + i) as u32;
        ends.extend(sides.edges[edge as usize]);
    }
    ends.sort_unstable();
    let is_split = |v: u32| ends.binary_search(&v).is_ok();
    (separate(soup, &sides, &classes, is_split).0, shape.conflicts.len())
}

/// Removes the vertices that no polygon uses and renumbers the others in their order; counts the removed.
pub fn drop_isolated(soup: &Soup) -> (Soup, usize) {
    let mut is_used = vec![false; soup.positions.len()];
    for &v in &soup.corners {
        is_used[v as usize] = true;
    }
    let mut result = soup.clone();
    result.positions.clear();
    let mut numbers = vec![0; soup.positions.len()];
    for (v, &position) in soup.positions.iter().enumerate().filter(|&(v, _)| is_used[v]) {
        numbers[v] = result.positions.len() as u32;
        result.positions.push(position);
    }
    for v in &mut result.corners {
        *v = numbers[*v as usize];
    }
    let count = soup.positions.len() - result.positions.len();
    (result, count)
}
