//! Edges with three or more sides: which two continue each other.
//!
//! Around the edge every polygon leaves at an angle. Where the directions of the sides alternate around it, the polygons
//! bound solids that meet in the edge, and each solid keeps its two. Otherwise two polygons of opposite direction that run
//! nearly straight on keep each other (the wall under a fin), and the rest gets edges of its own.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use nalgebra::Vector3;

use super::surface::Surface;
use crate::mesh::Soup;
use crate::mesh::doctor::{Corner, Rebuild, Shape, Sides, separate};

/// The largest bend, radians, at which a polygon still continues another: half of a right angle and a little. Larger, and
/// walls would be joined round corners; smaller, and coarse round surfaces would open under their fins.
const STRAIGHT: f64 = 0.9;
/// By how much less than any other choice a pair must bend to be clear, radians.
const CLEAR: f64 = 0.17;
/// The largest bend of pairs whose directions say nothing about each other.
const VERY_STRAIGHT: f64 = 0.5;
/// More sides than this at one edge are no surface: none is paired. Keeps the search for pairs linear.
const MOST: usize = 32;

/// One side at a crowded edge.
struct Leaf {
    side: u32,
    patch: u32,
    /// Whether the polygon, oriented as its patch is, runs from the smaller to the larger vertex.
    is_forward: bool,
    /// At which angle around the edge the polygon leaves; `None` for one without area.
    angle: Option<f64>,
}

/// Leaves each edge of three or more sides to the polygons that continue each other there, and gives the others copies of
/// its vertices; counts these edges.
///
/// Where both ends of an edge are each still one fan, sides that shall not meet get a vertex in the middle, so that
/// the edges differ.
pub fn split_edges(soup: &Soup) -> (Soup, usize) {
    let sides = Sides::new(soup);
    let shape = Shape::new(soup, &sides);
    if shape.crowded.is_empty() {
        return (soup.clone(), 0);
    }
    let surface = Surface::new(soup);
    let mut classes = sides.edge_of.clone();
    let mut fresh = sides.edges.len() as u32;
    let mut ends = Vec::new();
    for &edge in &shape.crowded {
        ends.extend(sides.edges[edge as usize]);
        let mut leaves = leaves(soup, &sides, &shape, &surface, edge as usize);
        for pair in pairs(&mut leaves) {
            for k in pair {
                classes[leaves[k].side as usize] = fresh;
            }
            fresh += 1;
        }
        for leaf in &leaves {
            if classes[leaf.side as usize] == edge {
                classes[leaf.side as usize] = fresh;
                fresh += 1;
            }
        }
    }
    ends.sort_unstable();
    let is_split = |v: u32| ends.binary_search(&v).is_ok();
    let (result, _) = separate(soup, &sides, &classes, is_split);
    (tell_apart(&result, &classes), shape.crowded.len())
}

fn leaves(soup: &Soup, sides: &Sides, shape: &Shape, surface: &Surface, edge: usize) -> Vec<Leaf> {
    let [a, b] = sides.edges[edge].map(|v| surface.points[v as usize]);
    let along = (b - a).try_normalize(0.0);
    let mut reference: Option<[Vector3<f64>; 2]> = None;
    let leaf = |&side: &u32| {
        let polygon = sides.polygons[side as usize] as usize;
        let runs_forward = sides.is_forward(soup, side);
        let angle = along.and_then(|along| {
            let normal = surface.normal(soup, polygon).try_normalize(0.0)?;
            let inward = normal.cross(&if runs_forward { along } else { -along });
            let inward = inward.try_normalize(1e-6)?;
            let [x, y] = *reference.get_or_insert([inward, along.cross(&inward)]);
            Some(inward.dot(&y).atan2(inward.dot(&x)))
        });
        let is_forward = runs_forward != shape.turned[polygon];
        Leaf { side, patch: shape.face_patches[polygon], is_forward, angle }
    };
    sides.of(edge).iter().map(leaf).collect()
}

/// Who keeps whom, by numbers in the list, which is sorted by angle.
fn pairs(leaves: &mut [Leaf]) -> Vec<[usize; 2]> {
    let key = |leaf: &Leaf| leaf.angle.unwrap_or(f64::INFINITY);
    leaves.sort_by(|a, b| key(a).total_cmp(&key(b)).then(a.side.cmp(&b.side)));
    let n = leaves.len();
    if n > MOST {
        return Vec::new();
    }
    let alternates = leaves.iter().all(|leaf| leaf.angle.is_some())
        && (0..n).all(|i| leaves[i].is_forward != leaves[(i + 1) % n].is_forward);
    if alternates {
        // The inside is clockwise of a polygon that runs forward.
        let forward = (0..n).filter(|&i| leaves[i].is_forward);
        return forward.map(|i| [(i + n - 1) % n, i]).collect();
    }
    let bend = |i: usize, j: usize| {
        let (Some(a), Some(b)) = (leaves[i].angle, leaves[j].angle) else { return f64::INFINITY };
        let apart = (a - b).abs();
        (std::f64::consts::PI - apart).abs()
    };
    let mut found: Vec<[usize; 2]> = Vec::new();
    for limit in [STRAIGHT, VERY_STRAIGHT] {
        let agrees = |i: usize, j: usize| {
            let is_opposite = leaves[i].is_forward != leaves[j].is_forward;
            if limit == STRAIGHT { is_opposite } else { leaves[i].patch != leaves[j].patch }
        };
        loop {
            let is_free = |i: &usize| !found.iter().flatten().any(|j| j == i);
            let free = Vec::from_iter((0..n).filter(is_free));
            let choices = free.iter().flat_map(|&i| free.iter().map(move |&j| [i, j]));
            let mut choices = Vec::from_iter(
                choices.filter(|&[i, j]| i < j && agrees(i, j)).map(|[i, j]| (bend(i, j), [i, j])),
            );
            choices.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let Some(&(least, best)) = choices.first().filter(|choice| choice.0 < limit) else {
                break;
            };
            let rival = choices[1..].iter().find(|(_, pair)| pair.iter().any(|i| best.contains(i)));
            if rival.is_some_and(|&(other, _)| other < least + CLEAR) {
                break;
            }
            found.push(best);
        }
    }
    found
}

/// Gives sides that name the same edge without being of the same class a vertex in the middle, all but the first class.
fn tell_apart(soup: &Soup, classes: &[u32]) -> Soup {
    let sides = Sides::new(soup);
    // Sides to be halved with the class that shares the new vertex.
    let mut halved: Vec<(u32, u32)> = Vec::new();
    for edge in 0..sides.edges.len() {
        let own = sides.of(edge);
        let kept = classes[own[0] as usize];
        let others = own.iter().map(|&side| (side, classes[side as usize]));
        halved.extend(others.filter(|&(_, class)| class != kept));
    }
    if halved.is_empty() {
        return soup.clone();
    }
    halved.sort_unstable();
    let mut rebuild = Rebuild::new(soup);
    let mut middles = std::collections::BTreeMap::new();
    let mut next = halved.iter().copied().peekable();
    for i in 0..soup.polygon_count() {
        if next.peek().is_none_or(|&(side, _)| side >= soup.starts[i + 1]) {
            rebuild.keep(i);
            continue;
        }
        let mut corners = Vec::new();
        for side in soup.starts[i]..soup.starts[i + 1] {
            let corner = Corner::of(soup, side as usize);
            corners.push(corner);
            if let Some((_, class)) = next.next_if(|&(halved, _)| halved == side) {
                let end = Corner::of(soup, sides.next[side as usize] as usize);
                let [p, q] = [corner, end].map(|c| soup.positions[c.vertex as usize]);
                let vertex = *middles.entry(class).or_insert_with(|| {
                    rebuild.add_vertex([0, 1, 2].map(|k| p[k] + 0.5 * (q[k] - p[k])))
                });
                corners.push(rebuild.between(corner, end, 0.5, vertex));
            }
        }
        rebuild.polygon(i, corners);
    }
    rebuild.finish()
}
