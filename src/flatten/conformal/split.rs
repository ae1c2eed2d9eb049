//! Points on edges of a cut surface: each edge in two, its faces in as many as it takes.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::Point3;

use crate::mesh::{CutMesh, FaceId, Mesh, SurfacePoint, VertexId};

/// Where a corner of the refined surface comes from. Corner and side `3 f + i` belong to face `f`; the side begins at the corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    Corner(usize),
    Side(usize),
}

/// A refined cut surface.
pub(super) struct Refined {
    pub cut: CutMesh,
    pub positions: Vec<Point3<f64>>,
    /// For each corner of each triangle.
    pub origins: Vec<[Origin; 3]>,
    pub points_added: usize,
}

/// Puts points on edges of a triangulation.
///
/// **Takes** the mesh that the cut mesh refines, the cut mesh with the places of its points and its own connectivity, and for each edge
/// of that where a point is to be, between 0 and 1 from the tail of the edge's first halfedge. **Gives** triangles in the order of those
/// that they are parts of. An edge stays whole if its ends lie in no common face, which no cut mesh has.
pub(super) fn split(
    base: &Mesh,
    cut: &CutMesh,
    positions: &[Point3<f64>],
    whole: &Mesh,
    at: &[Option<f64>],
) -> Refined {
    let mut refined = Refined {
        cut: CutMesh { points: cut.points.clone(), ..CutMesh::default() },
        positions: positions.to_vec(),
        origins: Vec::with_capacity(whole.face_count()),
        points_added: 0,
    };
    let mut middle = vec![None; whole.edge_count()];
    for e in whole.edges() {
        let Some(t) = at[e.index()] else { continue };
        let Some(face) = whole.face(e.halfedge()).or_else(|| whole.face(e.halfedge().twin()))
        else {
            continue;
        };
        let [a, b] = whole.edge_vertices(e);
        let ends = [a, b].map(|v| cut.points[v.index()]);
        let Some(point) = between(base, cut.triangle_faces[face.index()], ends, t) else {
            continue;
        };
        middle[e.index()] = Some(refined.cut.points.len() as u32);
        refined.cut.points.push(point);
        let [a, b] = [a, b].map(|v| positions[v.index()]);
        refined.positions.push(a + (b - a) * t);
        refined.points_added += 1;
    }
    for f in whole.faces() {
        let corners = whole.face_vertices(f).map(|v| v.0);
        let middles = whole.face_halfedges(f).map(|h| middle[h.edge().index()]);
        let at = |p: u32| refined.positions[p as usize];
        let triangles = divide(corners, middles, |a, b| (at(a) - at(b)).norm_squared());
        for triangle in triangles {
            let own = |p: u32| match corners.iter().position(|&c| c == p) {
                Some(i) => Origin::Corner(3 * f.index() + i),
                None => {
                    let i = middles.iter().position(|&m| m == Some(p)).unwrap_or(0);
                    Origin::Side(3 * f.index() + i)
                }
            };
            refined.origins.push(triangle.map(own));
            refined.cut.triangles.push(triangle);
            refined.cut.triangle_faces.push(cut.triangle_faces[f.index()]);
        }
    }
    for &[a, b] in &cut.cut_edges {
        let edge = whole.outgoing(VertexId(a)).find(|&h| whole.tip(h) == VertexId(b));
        match edge.and_then(|h| middle[h.edge().index()]) {
            Some(m) => refined.cut.cut_edges.extend([[a, m], [m, b]]),
            None => refined.cut.cut_edges.push([a, b]),
        }
    }
    refined
}

/// The parts of a triangle whose sides have points on them; side `i` begins at corner `i`.
fn divide(
    corners: [u32; 3],
    middles: [Option<u32>; 3],
    squared: impl Fn(u32, u32) -> f64,
) -> Vec<[u32; 3]> {
    let count = middles.iter().flatten().count();
    // The first of the divided sides that follow an undivided one.
    let first = (0..3).find(|&i| middles[i].is_some() && middles[(i + 2) % 3].is_none());
    let i = first.unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
    let [ab, bc, ca] = [0, 1, 2].map(|k| middles[(i + k) % 3]);
    match (count, ab, bc, ca) {
        (1, Some(m), _, _) => vec![[a, m, c], [m, b, c]],
        (2, Some(m), Some(n), _) => {
            let mut triangles = vec![[m, b, n]];
            if squared(a, n) < squared(m, c) {
                triangles.extend([[a, m, n], [a, n, c]]);
            } else {
                triangles.extend([[a, m, c], [m, n, c]]);
            }
            triangles
        }
        (3, Some(m), Some(n), Some(o)) => vec![[a, m, o], [m, b, n], [o, n, c], [m, n, o]],
        _ => vec![corners],
    }
}

/// The point (1 − t) a + t b of a face.
fn between(base: &Mesh, face: FaceId, [a, b]: [SurfacePoint; 2], t: f64) -> Option<SurfacePoint> {
    let (a, b) = (weights(base, face, a)?, weights(base, face, b)?);
    let w = [0, 1, 2].map(|i| (1.0 - t) * a[i] + t * b[i]);
    let Some(k) = (0..3).find(|&k| w[k] == 0.0) else { return Some(SurfacePoint::Face(face, w)) };
    let [p, q] = [(k + 1) % 3, (k + 2) % 3];
    let h = base.face_halfedges(face)[p];
    let along = w[q] / (w[p] + w[q]);
    let along = if h == h.edge().halfedge() { along } else { 1.0 - along };
    (along > 0.0 && along < 1.0).then(|| SurfacePoint::Edge(h.edge(), along))
}

/// Barycentric coordinates of a point in a face that it belongs to.
fn weights(base: &Mesh, face: FaceId, point: SurfacePoint) -> Option<[f64; 3]> {
    let mut w = [0.0; 3];
    match point {
        SurfacePoint::Vertex(v) => {
            w[base.face_vertices(face).iter().position(|&c| c == v)?] = 1.0;
        }
        SurfacePoint::Edge(e, t) => {
            let sides = base.face_halfedges(face);
            let i = sides.iter().position(|h| h.edge() == e)?;
            let t = if sides[i] == e.halfedge() { t } else { 1.0 - t };
            (w[i], w[(i + 1) % 3]) = (1.0 - t, t);
        }
        SurfacePoint::Face(f, own) if f == face => w = own,
        SurfacePoint::Face(..) => return None,
    }
    Some(w)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every division of a triangle keeps its orientation and area and uses all points.
    #[test]
    fn a_triangle_is_divided_whole_whatever_sides_have_points() {
        let places: [[f64; 2]; 6] =
            [[0.0, 0.0], [3.0, 0.0], [1.0, 2.0], [1.2, 0.0], [2.0, 1.0], [0.4, 0.8]];
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|p| places[p as usize]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        };
        for mask in 0..8u32 {
            let middles = [0, 1, 2].map(|i| (mask >> i & 1 == 1).then_some(3 + i));
            let squared = |a: u32, b: u32| {
                let [a, b] = [a, b].map(|p| places[p as usize]);
                (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
            };
            let parts = divide([0, 1, 2], middles, squared);
            assert_eq!(parts.len(), 1 + mask.count_ones() as usize, "{mask}");
            assert!(parts.iter().all(|t| area(t) > 0.0), "{mask} {parts:?}");
            let sum: f64 = parts.iter().map(area).sum();
            assert!((sum - 3.0).abs() < 1e-15, "{mask} {sum}");
            for m in middles.iter().flatten() {
                assert!(parts.iter().flatten().any(|p| p == m));
            }
        }
    }
}
