//! How charts lie beside each other: the curves between them.

use std::f64::consts::FRAC_PI_6;

use super::small;
use crate::geometry::Geometry;
use crate::mesh::{EdgeId, HalfedgeId, Mesh, VertexId};

/// No chart yet.
const NONE: u32 = u32::MAX;

/// Turns to alternating sides that are at least so sharp make a zigzag. Along the edges of regular triangles a straight line at an angle to
/// them turns by π/3 at every step; smooth seams on fine meshes turn by less than half of that.
const SHARP: f64 = FRAC_PI_6;

/// A maximal chain of seam edges between one pair of charts.
///
/// It ends at junctions: vertices where other than two seam edges meet, and at the surface's boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct SeamCurve {
    /// The charts, the smaller number first.
    pub pair: [u32; 2],
    /// Its edges in order, directed so that the first chart lies on the left.
    pub halfedges: Vec<HalfedgeId>,
    /// Sum of the edges' lengths.
    pub length: f64,
    /// Whether it meets no junction and ends where it begins.
    pub is_closed: bool,
}

impl SeamCurve {
    /// Its vertices in order; the first once more at the end of a closed curve.
    pub fn vertices(&self, mesh: &Mesh) -> Vec<VertexId> {
        let first = self.halfedges.first().map(|&h| mesh.tail(h));
        first.into_iter().chain(self.halfedges.iter().map(|&h| mesh.tip(h))).collect()
    }
}

/// Length and smoothness of all seams.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeamMeasure {
    /// Number of curves.
    pub curves: usize,
    /// Sum of their lengths.
    pub length: f64,
    /// Sum of |turn| inside curves, radians, measured within the surface: half the difference of the angles on both sides.
    pub turning: f64,
    /// How often a curve turns sharply to one side right after it has turned sharply to the other.
    pub zigzags: usize,
}

impl SeamMeasure {
    /// Measures curves. **Costs** their edges times the valence.
    pub fn new(mesh: &Mesh, geometry: &Geometry, curves: &[SeamCurve]) -> Self {
        let mut measure = Self { curves: curves.len(), ..Self::default() };
        for curve in curves {
            measure.length += curve.length;
            let count = curve.halfedges.len();
            let mut before = 0.0;
            let inner = if curve.is_closed { count } else { count.saturating_sub(1) };
            for i in 0..inner {
                let turn =
                    turn(mesh, geometry, curve.halfedges[i], curve.halfedges[(i + 1) % count]);
                measure.turning += turn.abs();
                let is_sharp = turn.abs() >= SHARP;
                measure.zigzags += usize::from(is_sharp && turn * before < 0.0);
                before = if is_sharp { turn } else { 0.0 };
            }
        }
        measure
    }
}

/// By how much a curve turns to the left from one halfedge to the next, at an interior vertex: half of what the angle on its right
/// exceeds that on its left by, which is 0 for a straightest geodesic.
fn turn(mesh: &Mesh, geometry: &Geometry, from: HalfedgeId, to: HalfedgeId) -> f64 {
    let back = from.twin();
    // Counter-clockwise from the way on to the way back lies the left side.
    let (mut left, mut right) = (0.0, 0.0);
    let mut h = to;
    let mut is_left = true;
    loop {
        let Some(f) = mesh.face(h) else { return 0.0 };
        let corner = mesh.face_halfedges(f).iter().position(|&side| side == h).unwrap_or(0);
        let angle = geometry.corner_angles[f.index()][corner];
        *if is_left { &mut left } else { &mut right } += angle;
        h = mesh.prev(h).twin();
        if h == back {
            is_left = false;
        }
        if h == to {
            return 0.5 * (right - left);
        }
    }
}

/// The curves between charts, ordered by their first edge.
///
/// **Takes** a chart for each face, any numbers. **Gives** each edge between different charts in exactly one curve; the surface's own
/// boundary is no seam. **Costs** O(E).
///
/// ```
/// # use cutflow::geometry::Geometry;
/// # use cutflow::mesh::Mesh;
/// # use cutflow::methods::developable::seam_curves;
/// # use nalgebra::Point3;
/// // A square of two charts.
/// let mesh = Mesh::new(4, &[[0, 1, 2], [0, 2, 3]])?;
/// let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// let geometry = Geometry::new(&mesh, corners.map(|[x, y]| Point3::new(x, y, 0.0)).to_vec())?;
/// let curves = seam_curves(&mesh, &geometry, &[7, 4]);
/// assert_eq!((curves.len(), curves[0].pair, curves[0].length), (1, [4, 7], 2f64.sqrt()));
/// // From corner 0 to corner 2 the second face, of chart 4, lies on the left.
/// assert_eq!(curves[0].vertices(&mesh).iter().map(|v| v.0).collect::<Vec<_>>(), [0, 2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn seam_curves(mesh: &Mesh, geometry: &Geometry, face_charts: &[u32]) -> Vec<SeamCurve> {
    assert_eq!(face_charts.len(), mesh.face_count());
    // For each edge its halfedge with the smaller chart on the left.
    let directed = |h: HalfedgeId| {
        let [a, b] = [mesh.face(h)?, mesh.face(h.twin())?].map(|f| face_charts[f.index()]);
        (a != b).then(|| if a < b { (h, [a, b]) } else { (h.twin(), [b, a]) })
    };
    // The only other seam edge at a vertex inside, leaving it.
    let on = |h: HalfedgeId, v: VertexId| {
        if mesh.is_boundary_vertex(v) {
            return None;
        }
        let mut others =
            mesh.outgoing(v).filter(|o| o.edge() != h.edge() && directed(*o).is_some());
        let other = others.next()?;
        others.next().is_none().then_some(other)
    };
    let mut is_seen = vec![false; mesh.edge_count()];
    let mut curves = Vec::new();
    for e in mesh.edges() {
        let Some((start, pair)) = directed(e.halfedge()).filter(|_| !is_seen[e.index()]) else {
            continue;
        };
        // Back to where it begins, or once around.
        let mut first = start;
        let mut is_closed = false;
        while let Some(before) = on(first, mesh.tail(first)) {
            if before.edge() == e {
                is_closed = true;
                first = start;
                break;
            }
            first = before.twin();
        }
        let mut halfedges = vec![first];
        is_seen[first.edge().index()] = true;
        let mut h = first;
        while let Some(next) = on(h, mesh.tip(h)) {
            if std::mem::replace(&mut is_seen[next.edge().index()], true) {
                break;
            }
            halfedges.push(next);
            h = next;
        }
        // Not `sum`, which is −0 of nothing.
        let length = halfedges.iter().fold(0.0, |sum, h| sum + geometry.edge_length(h.edge()));
        curves.push(SeamCurve { pair, halfedges, length, is_closed });
    }
    curves
}

/// Numbers the connected parts of the faces of each label, by their first face.
///
/// **Gives** a chart for each face, and their number. **Costs** O(F).
pub fn connected_charts(mesh: &Mesh, labels: &[u32]) -> (Vec<u32>, usize) {
    parted_charts(mesh, labels, |_| false)
}

/// The same, where edges that `parts` accepts connect nothing.
pub fn parted_charts(
    mesh: &Mesh,
    labels: &[u32],
    parts: impl Fn(EdgeId) -> bool,
) -> (Vec<u32>, usize) {
    assert_eq!(labels.len(), mesh.face_count());
    let mut charts = vec![NONE; labels.len()];
    let mut count = 0;
    let mut stack = Vec::new();
    for seed in mesh.faces() {
        if charts[seed.index()] != NONE {
            continue;
        }
        charts[seed.index()] = small(count);
        stack.push(seed);
        while let Some(f) = stack.pop() {
            for h in mesh.face_halfedges(f) {
                let Some(g) = mesh.face(h.twin()) else { continue };
                let is_same = labels[g.index()] == labels[f.index()];
                if charts[g.index()] == NONE && is_same && !parts(h.edge()) {
                    charts[g.index()] = small(count);
                    stack.push(g);
                }
            }
        }
        count += 1;
    }
    (charts, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// A grid of n × n squares, each divided.
    fn grid(n: u32) -> (Mesh, Geometry) {
        let mut points = Vec::new();
        for j in 0..=n {
            for i in 0..=n {
                points.push(Point3::new(f64::from(i), f64::from(j), 0.0));
            }
        }
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let mut triangles = Vec::new();
        for j in 0..n {
            for i in 0..n {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let mesh = Mesh::new(points.len(), &triangles).unwrap();
        let geometry = Geometry::new(&mesh, points).unwrap();
        (mesh, geometry)
    }

    #[test]
    fn charts_in_quarters_meet_in_four_curves_and_an_island_in_a_closed_one() {
        let (mesh, geometry) = grid(6);
        let cell = |f: usize| [(f / 2) % 6, f / 12];
        let quarters: Vec<u32> = (0..mesh.face_count())
            .map(|f| cell(f).map(|i| u32::from(i >= 3)))
            .map(|[i, j]| i + 2 * j)
            .collect();
        let curves = seam_curves(&mesh, &geometry, &quarters);
        let mut pairs: Vec<_> = curves.iter().map(|c| (c.pair, c.length, c.is_closed)).collect();
        pairs.sort_by_key(|c| c.0);
        let straight = |a, b| ([a, b], 3.0, false);
        assert_eq!(pairs, [straight(0, 1), straight(0, 2), straight(1, 3), straight(2, 3)]);
        let measure = SeamMeasure::new(&mesh, &geometry, &curves);
        // A sum of angles of π.
        assert!(measure.turning < 1e-14 && measure.zigzags == 0);

        let island: Vec<u32> = (0..mesh.face_count())
            .map(|f| u32::from(cell(f).iter().all(|i| (2..4).contains(i))))
            .collect();
        let curves = seam_curves(&mesh, &geometry, &island);
        assert_eq!((curves.len(), curves[0].length, curves[0].is_closed), (1, 8.0, true));
        for &h in &curves[0].halfedges {
            assert_eq!(mesh.face(h).map(|f| island[f.index()]), Some(0));
        }
        let vertices = curves[0].vertices(&mesh);
        assert_eq!((vertices.len(), vertices[0]), (9, vertices[8]));
        let measure = SeamMeasure::new(&mesh, &geometry, &curves);
        assert!((measure.turning - std::f64::consts::TAU).abs() < 1e-14, "{measure:?}");
        assert_eq!(measure.zigzags, 0);
    }

    #[test]
    fn stairs_are_zigzags_and_a_checkerboard_ends_at_every_corner() {
        let (mesh, geometry) = grid(6);
        // The anti-diagonal in steps of one square.
        let stairs: Vec<u32> =
            (0..mesh.face_count()).map(|f| u32::from((f / 2) % 6 + f / 12 >= 6)).collect();
        let curves = seam_curves(&mesh, &geometry, &stairs);
        assert_eq!((curves.len(), curves[0].halfedges.len()), (1, 10));
        // The first of nine turns has none before it.
        assert_eq!(SeamMeasure::new(&mesh, &geometry, &curves).zigzags, 8);
        let board: Vec<u32> =
            (0..mesh.face_count()).map(|f| u32::from(((f / 2) % 6 + f / 12) % 2 == 1)).collect();
        let curves = seam_curves(&mesh, &geometry, &board);
        assert_eq!(curves.len(), 60);
        assert!(curves.iter().all(|c| c.halfedges.len() == 1 && !c.is_closed));
    }
}
