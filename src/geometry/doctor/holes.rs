//! Holes closed by one polygon each.

use std::collections::BTreeSet;

use super::surface::{Surface, doubled_normal, is_flat, local_triangles};
use crate::mesh::Soup;
use crate::mesh::doctor::{Corner, Rebuild, Shape, Sides};

/// Cosine between the faces on both sides of a hole's edge below which the new one would lie on the old one's back:
/// the rim of a flat sheet is no hole.
const BACK_TO_BACK: f64 = -0.99;

/// The most edges of a hole that is closed: triangulating costs the square of it, and so large a flat lid helps nobody.
const MOST: usize = 4096;

/// Closes the boundary loops that have at most so many edges (and never more than 4096), if a polygon on their vertices is sound; counts them.
///
/// Sound: the sides around the loop agree in direction, no vertex comes twice, every triangle has area and faces where the
/// whole does, none lies on the back of its neighbour, and no diagonal joins vertices that an edge joins already. The
/// polygon has group and material of the polygon across its first side, and neither texture coordinates nor normals.
pub fn fill_holes(soup: &Soup, max_edges: Option<u32>) -> (Soup, usize) {
    let sides = Sides::new(soup);
    let shape = Shape::new(soup, &sides);
    let surface = Surface::new(soup);
    let mut rebuild = Rebuild::new(soup);
    (0..soup.polygon_count()).for_each(|i| rebuild.keep(i));
    let mut taken = BTreeSet::new();
    let mut count = 0;
    for hole in &shape.loops {
        let most = max_edges.map_or(MOST, |most| MOST.min(most as usize));
        let agrees =
            hole.sides.iter().zip(&hole.vertices).all(|(&s, &v)| soup.corners[s as usize] == v);
        if !hole.is_closed || hole.sides.len() > most || !agrees {
            continue;
        }
        let lid = Vec::from_iter(hole.vertices.iter().rev().copied());
        let Some(diagonals) = diagonals_if_sound(soup, &sides, &surface, &lid) else { continue };
        if diagonals.iter().any(|name| taken.contains(name)) {
            continue;
        }
        taken.extend(diagonals);
        let like = sides.polygons[hole.sides[0] as usize] as usize;
        rebuild.polygon(like, lid.into_iter().map(Corner::bare));
        count += 1;
    }
    (rebuild.finish(), count)
}

/// The diagonals that a new polygon would have, if it is sound.
fn diagonals_if_sound(
    soup: &Soup,
    sides: &Sides,
    surface: &Surface,
    lid: &[u32],
) -> Option<Vec<[u32; 2]>> {
    let distinct = BTreeSet::from_iter(lid);
    if lid.len() < 3 || distinct.len() < lid.len() {
        return None;
    }
    let n = lid.len();
    let triangles = local_triangles(soup, lid);
    let corners = |t: [u32; 3]| t.map(|k| surface.points[lid[k as usize] as usize]);
    let whole: nalgebra::Vector3<f64> = triangles.iter().map(|&t| doubled_normal(corners(t))).sum();
    let mut diagonals = Vec::with_capacity(2 * n);
    for &t in &triangles {
        let normal = doubled_normal(corners(t));
        if is_flat(corners(t)) || normal.dot(&whole) <= 0.0 {
            return None;
        }
        for [i, j] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
            let [v, w] = [lid[i as usize], lid[j as usize]];
            if (i as usize + 1) % n == j as usize {
                let edge = sides.find(v, w)?;
                let across = sides.polygons[sides.of(edge)[0] as usize] as usize;
                let other = surface.normal(soup, across);
                let lies_on = |own: nalgebra::Vector3<f64>| {
                    own.dot(&other) < BACK_TO_BACK * own.norm() * other.norm()
                };
                if lies_on(normal) || lies_on(whole) {
                    return None;
                }
            } else if sides.find(v, w).is_some() {
                return None;
            } else if i < j {
                diagonals.push([v.min(w), v.max(w)]);
            }
        }
    }
    diagonals.sort_unstable();
    diagonals.dedup();
    // Without one of each the polygon would need the same diagonal twice.
    (diagonals.len() == n - 3).then_some(diagonals)
}
