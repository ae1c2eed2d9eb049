//! A network back to a triangulation that it runs along.
//!
//! Crossings divide the sides of a face, segments divide its inside: a planar graph that hangs together, because every segment
//! leads to a side in the end. Its cells are traced and each is triangulated. Turns are taken in coordinates in which the face
//! is the triangle (0,0) (1,0) (0,1) and crossings are rounded so that those on one side lie on one line exactly.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::Vector2;
use robust::{Coord, orient2d};

use super::flat::{Place, along};
use super::network::Network;
use crate::geometry::polygon::triangulate;
use crate::mesh::{CutMesh, FaceId, SurfacePoint};

/// Crossings are multiples of this.
const GRID: f64 = 1.0 / (1u64 << 40) as f64;

/// The refined mesh: the curves that stay near their place first, then the free ones. **Gives** also how many cut edges the first
/// ones have; `None` where a face could not be divided into triangles with area.
pub(super) fn refine(net: &mut Network) -> Option<(CutMesh, usize)> {
    let mesh = net.flat.mesh;
    for list in 0..net.edge_nodes.len() {
        for i in 0..net.edge_nodes[list].len() {
            let n = net.edge_nodes[list][i];
            if let Place::Edge(_, t) = net.place(n) {
                net.set_t(n, (t / GRID).round() * GRID);
            }
        }
    }
    let mut points: Vec<SurfacePoint> = mesh.vertices().map(SurfacePoint::Vertex).collect();
    let mut numbers = vec![u32::MAX; net.nodes.len()];
    for (i, n) in net.nodes.iter().enumerate().filter(|(_, n)| n.is_alive) {
        numbers[i] = points.len() as u32;
        match n.place {
            Place::Vertex(v) => numbers[i] = v.0,
            Place::Edge(e, t) => points.push(SurfacePoint::Edge(e, t)),
            Place::Face(f, x) => points.push(SurfacePoint::Face(f, net.flat.weights(f, x))),
        }
    }
    let mut cut = CutMesh { points, ..CutMesh::default() };
    for f in mesh.faces() {
        let is_whole = net.face_segments[f.index()].is_empty()
            && mesh.face_halfedges(f).iter().all(|h| net.edge_nodes[h.edge().index()].is_empty());
        if is_whole {
            cut.triangles.push(mesh.face_vertices(f).map(|v| v.0));
        } else {
            let triangles = divide(net, f, &numbers)?;
            cut.triangles.extend(triangles);
        }
        cut.triangle_faces.resize(cut.triangles.len(), f);
    }
    let mut held = 0;
    for free in [false, true] {
        for &(e, _) in net.walls.iter().filter(|w| w.1 == free) {
            cut.cut_edges.push(mesh.edge_vertices(e).map(|v| v.0));
        }
        for s in net.segments.iter().filter(|s| s.is_alive && s.is_free == free) {
            cut.cut_edges.push(s.ends.map(|n| numbers[n as usize]));
        }
        if !free {
            held = cut.cut_edges.len();
        }
    }
    Some((cut, held))
}

/// Triangles of a face that segments cross.
fn divide(net: &Network, f: FaceId, numbers: &[u32]) -> Option<Vec<[u32; 3]>> {
    let mesh = net.flat.mesh;
    let halfedges = mesh.face_halfedges(f);
    // Corners and crossings around the face, then what lies inside. For each its number, exact place and true place.
    let mut names: Vec<u32> = Vec::new();
    let mut exact: Vec<Vector2<f64>> = Vec::new();
    let mut places: Vec<[f64; 3]> = Vec::new();
    let mut add = |name: u32, weights: [f64; 3]| {
        names.push(name);
        exact.push(Vector2::new(weights[1], weights[2]));
        let x = net.flat.place_of_weights(f, weights);
        places.push([x.x, x.y, 0.0]);
    };
    for i in 0..3 {
        let mut corner = [0.0; 3];
        corner[i] = 1.0;
        add(mesh.tail(halfedges[i]).0, corner);
        let list = &net.edge_nodes[halfedges[i].edge().index()];
        let mut side: Vec<(f64, u32)> = list
            .iter()
            .filter_map(|&n| match net.place(n) {
                Place::Edge(_, t) => Some((along(halfedges[i], t), n)),
                _ => None,
            })
            .collect();
        side.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (s, n) in side {
            let mut weights = [0.0; 3];
            weights[i] = 1.0 - s;
            weights[(i + 1) % 3] = s;
            add(numbers[n as usize], weights);
        }
    }
    for &s in &net.face_segments[f.index()] {
        for n in net.segments[s as usize].ends {
            if let Place::Face(_, x) = net.place(n) {
                add(numbers[n as usize], net.flat.weights(f, x));
            }
        }
    }
    // Junctions have several segments.
    let around = names.len();
    let (mut kept_names, mut kept) = (Vec::new(), Vec::new());
    for i in 0..around {
        if !kept_names.contains(&names[i]) {
            kept_names.push(names[i]);
            kept.push(i);
        }
    }
    let exact: Vec<Vector2<f64>> = kept.iter().map(|&i| exact[i]).collect();
    let places: Vec<[f64; 3]> = kept.iter().map(|&i| places[i]).collect();
    let names = kept_names;
    let rim = 3 + halfedges.iter().map(|h| net.edge_nodes[h.edge().index()].len()).sum::<usize>();

    let local = |n: u32| names.iter().position(|&m| m == numbers[n as usize]);
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); names.len()];
    for i in 0..rim {
        neighbours[i].push((i + 1) % rim);
        neighbours[(i + 1) % rim].push(i);
    }
    for &s in &net.face_segments[f.index()] {
        let [a, b] = net.segments[s as usize].ends;
        let (a, b) = (local(a)?, local(b)?);
        neighbours[a].push(b);
        neighbours[b].push(a);
    }
    for (i, list) in neighbours.iter_mut().enumerate() {
        let angle = |j: usize| {
            let d = exact[j] - exact[i];
            d.y.atan2(d.x)
        };
        list.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
    }
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for cell in cells(&neighbours, rim) {
        let cell: Vec<u32> = cell.into_iter().map(|i| i as u32).collect();
        let mut own = Vec::new();
        triangulate(&places, &cell, &mut own);
        if !own.iter().all(|&t| is_positive(&exact, t)) {
            // In true coordinates the crossings of one side lie on one line up to rounding only.
            let flat: Vec<[f64; 3]> = exact.iter().map(|x| [x.x, x.y, 0.0]).collect();
            own.clear();
            triangulate(&flat, &cell, &mut own);
            if !own.iter().all(|&t| is_positive(&exact, t)) {
                return None;
            }
        }
        triangles.extend(own.into_iter().map(|t| t.map(|i| names[i as usize])));
    }
    Some(triangles)
}

fn is_positive(exact: &[Vector2<f64>], t: [u32; 3]) -> bool {
    let [a, b, c] = t.map(|i| Coord { x: exact[i as usize].x, y: exact[i as usize].y });
    orient2d(a, b, c) > 0.0
}

/// The inner cells of a plane graph, counter-clockwise. **Takes** for each point its neighbours counter-clockwise; the first `rim`
/// points are the outline.
fn cells(neighbours: &[Vec<usize>], rim: usize) -> Vec<Vec<usize>> {
    let mut seen: Vec<Vec<bool>> = neighbours.iter().map(|list| vec![false; list.len()]).collect();
    let mut cells = Vec::new();
    for start in 0..neighbours.len() {
        for slot in 0..neighbours[start].len() {
            // The outline backwards is the outside.
            let next = neighbours[start][slot];
            let is_outside = start < rim && next < rim && (next + 1) % rim == start;
            if seen[start][slot] || is_outside {
                continue;
            }
            let (mut cell, mut at, mut out) = (Vec::new(), start, slot);
            while !seen[at][out] {
                seen[at][out] = true;
                cell.push(at);
                let next = neighbours[at][out];
                // The next edge clockwise from the way back.
                let list = &neighbours[next];
                let back = list.iter().position(|&n| n == at).unwrap_or(0);
                out = (back + list.len() - 1) % list.len();
                at = next;
            }
            cells.push(cell);
        }
    }
    cells
}
