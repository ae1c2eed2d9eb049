//! Tighter borders: a least cut in a band about the border of two charts.
//!
//! An edge costs |e| / (1 + d / d̄) with d = η (1 − cos β) for the angle β between its faces' normals, d̄ the mean over the band: short borders along creases,
//! hollow ones before convex ones.

use crate::geometry::Geometry;
use crate::mesh::{EdgeId, FaceId, Mesh};
use crate::methods::maxflow::Network;

/// Capacities are whole numbers: the whole band costs about this many.
const FINE: f64 = (1u64 << 44) as f64;

/// Options of [`tighten`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TightenParams {
    /// Rings of faces on either side of a border that may change sides. Fewer: borders stay where they are; more: small charts are only band.
    pub rings: u32,
    /// η of convex edges; hollow ones have 1. People see seams in hollows less.
    pub convex: f64,
}

impl Default for TightenParams {
    fn default() -> Self {
        Self { rings: 3, convex: 0.2 }
    }
}

/// Where the border of two charts is cheapest, near where it is.
///
/// **Takes** a chart for each face, two of them, and what an edge costs beyond its length (a factor for each edge; empty for 1). **Gives** the
/// faces that change sides with their new charts; empty where the border is best already, and where a chart would fall apart or vanish.
/// **Costs** O(n) to find the band among all faces, and a maximum flow on it. **From** [LPFB] §4.2, after Katz, Tal 2003.
pub fn tighten(
    mesh: &Mesh,
    geometry: &Geometry,
    charts: &[u32],
    pair: [u32; 2],
    factors: &[f64],
    params: &TightenParams,
) -> Vec<(FaceId, u32)> {
    let Some(band) = Band::new(mesh, charts, pair, params.rings) else { return Vec::new() };
    let prices = band.prices(mesh, geometry, factors, params.convex);
    let total: f64 = prices.iter().map(|(_, price)| price).sum();
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let mut network = Network::new(band.faces.len());
    for &([a, b], price) in &prices {
        network.join(a, b, capacity(price / total));
    }
    let is_first = network.cut(&band.ends[0], &band.ends[1]);
    let sides = band.faces.iter().zip(is_first);
    let moved: Vec<(FaceId, u32)> = sides
        .map(|(&f, first)| (f, pair[usize::from(!first)]))
        .filter(|(f, chart)| charts[f.index()] != *chart)
        .collect();
    if moved.is_empty() || !hang_together(mesh, charts, pair, &moved) {
        return Vec::new();
    }
    moved
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a fraction of FINE")]
fn capacity(fraction: f64) -> u64 {
    // Nothing is free: of all least cuts the one with the fewest edges is taken.
    (fraction * FINE) as u64 + 1
}

/// Faces about a border.
struct Band {
    faces: Vec<FaceId>,
    /// Number in the band of every face, `u32::MAX` outside.
    numbers: Vec<u32>,
    /// The faces that stay with each chart: those farthest from the border.
    ends: [Vec<u32>; 2],
}

impl Band {
    fn new(mesh: &Mesh, charts: &[u32], pair: [u32; 2], rings: u32) -> Option<Self> {
        let mut numbers = vec![u32::MAX; charts.len()];
        let mut faces = Vec::new();
        let mut ring = Vec::new();
        let across =
            |f: FaceId| mesh.face_halfedges(f).into_iter().filter_map(|h| mesh.face(h.twin()));
        for f in mesh.faces().filter(|f| pair.contains(&charts[f.index()])) {
            let other = pair[usize::from(charts[f.index()] == pair[0])];
            if across(f).any(|g| charts[g.index()] == other) {
                numbers[f.index()] = u32::try_from(faces.len()).ok()?;
                faces.push(f);
                ring.push(0);
            }
        }
        let mut next = 0;
        while let Some(&f) = faces.get(next) {
            let depth: u32 = ring[next];
            next += 1;
            if depth >= rings {
                continue;
            }
            for g in across(f) {
                if charts[g.index()] == charts[f.index()] && numbers[g.index()] == u32::MAX {
                    numbers[g.index()] = u32::try_from(faces.len()).ok()?;
                    faces.push(g);
                    ring.push(depth + 1);
                }
            }
        }
        let ends = pair.map(|chart| {
            let own = |i: &usize| charts[faces[*i].index()] == chart;
            let deepest = (0..faces.len()).filter(own).map(|i| ring[i]).max().unwrap_or(0);
            let end = (0..faces.len()).filter(|i| own(i) && ring[*i] == deepest);
            end.filter_map(|i| u32::try_from(i).ok()).collect::<Vec<u32>>()
        });
        // A chart that is nothing but border has nothing to give.
        let is_wide = |end: &Vec<u32>| end.first().is_some_and(|&i| ring[i as usize] > 0);
        ends.iter().all(is_wide).then_some(Self { faces, numbers, ends })
    }

    /// Edges between faces of the band with their prices.
    fn prices(
        &self,
        mesh: &Mesh,
        geometry: &Geometry,
        factors: &[f64],
        convex: f64,
    ) -> Vec<([u32; 2], f64)> {
        let mut edges: Vec<([u32; 2], EdgeId, f64)> = Vec::new();
        for &f in &self.faces {
            for h in mesh.face_halfedges(f) {
                let Some(g) = mesh.face(h.twin()) else { continue };
                let [a, b] = [f, g].map(|f| self.numbers[f.index()]);
                if b != u32::MAX && a < b {
                    edges.push(([a, b], h.edge(), crease(mesh, geometry, h.edge(), convex)));
                }
            }
        }
        let mean = edges.iter().map(|(.., d)| d).sum::<f64>() / edges.len().max(1) as f64;
        let price = |([a, b], e, d): ([u32; 2], EdgeId, f64)| {
            let share = if mean > 0.0 { d / mean } else { 0.0 };
            let factor = factors.get(e.index()).copied().unwrap_or(1.0);
            ([a, b], factor * geometry.edge_length(e) / (1.0 + share))
        };
        edges.into_iter().map(price).collect()
    }
}

/// η (1 − cos β) of an edge inside the surface.
fn crease(mesh: &Mesh, geometry: &Geometry, e: EdgeId, convex: f64) -> f64 {
    let h = e.halfedge();
    let place = |v: crate::mesh::VertexId| geometry.positions[v.index()];
    let (a, b) = (place(mesh.tail(h)), place(mesh.tip(h)));
    let [c, d] = [h, h.twin()].map(|h| place(mesh.tip(mesh.next(h))));
    let (left, right) = ((b - a).cross(&(c - a)), (a - b).cross(&(d - b)));
    let size = left.norm() * right.norm();
    if !(size > 0.0 && size.is_finite()) {
        return 0.0;
    }
    let turn = (1.0 - left.dot(&right) / size).max(0.0);
    // The far corner of one face lies below the other one's plane where the edge is convex.
    let eta = if (d - a).dot(&left) < 0.0 { convex } else { 1.0 };
    eta * turn
}

/// Whether both charts are there in one piece each after some faces have changed sides.
fn hang_together(mesh: &Mesh, charts: &[u32], pair: [u32; 2], moved: &[(FaceId, u32)]) -> bool {
    let mut after = charts.to_vec();
    moved.iter().for_each(|(f, chart)| after[f.index()] = *chart);
    pair.into_iter().all(|chart| {
        let count = after.iter().filter(|c| **c == chart).count();
        let Some(first) = mesh.faces().find(|f| after[f.index()] == chart) else { return false };
        let mut reached = 1;
        after[first.index()] = u32::MAX;
        let mut stack = vec![first];
        while let Some(f) = stack.pop() {
            for g in mesh.face_halfedges(f).into_iter().filter_map(|h| mesh.face(h.twin())) {
                if after[g.index()] == chart {
                    after[g.index()] = u32::MAX;
                    reached += 1;
                    stack.push(g);
                }
            }
        }
        reached == count
    })
}
