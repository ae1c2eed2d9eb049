//! Faces laid out flat, and places in them.

use nalgebra::Vector2;

use crate::geometry::Geometry;
use crate::mesh::{EdgeId, FaceId, HalfedgeId, Mesh, VertexId};

/// Where a node lies. A place in a face is told in the face's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    Vertex(VertexId),
    Edge(EdgeId, f64),
    Face(FaceId, Vector2<f64>),
}

/// Every face in a frame of its own: corner 0 at the origin, corner 1 on the x axis, corner 2 above it.
pub(super) struct Flat<'a> {
    pub mesh: &'a Mesh,
    pub lengths: &'a [f64],
    corners: Vec<[Vector2<f64>; 3]>,
    /// Sum of the corner angles at every vertex.
    pub angle_sums: Vec<f64>,
}

impl<'a> Flat<'a> {
    pub fn new(mesh: &'a Mesh, geometry: &'a Geometry) -> Self {
        let corners = mesh.faces().map(|f| {
            let [base, _, side] = mesh.face_halfedges(f).map(|h| geometry.edge_length(h.edge()));
            let angle = geometry.corner_angles[f.index()][0];
            [
                Vector2::zeros(),
                Vector2::new(base, 0.0),
                Vector2::new(side * angle.cos(), side * angle.sin()),
            ]
        });
        let mut angle_sums = vec![0.0; mesh.vertex_count()];
        for f in mesh.faces() {
            for (v, angle) in mesh.face_vertices(f).iter().zip(geometry.corner_angles[f.index()]) {
                angle_sums[v.index()] += angle;
            }
        }
        let corners = corners.collect();
        Self { mesh, lengths: &geometry.edge_lengths, corners, angle_sums }
    }

    pub fn length(&self, e: EdgeId) -> f64 {
        self.lengths[e.index()]
    }

    pub fn corners(&self, f: FaceId) -> [Vector2<f64>; 3] {
        self.corners[f.index()]
    }

    /// Number of an edge among the sides of a face.
    pub fn side(&self, f: FaceId, e: EdgeId) -> Option<usize> {
        self.mesh.face_halfedges(f).iter().position(|h| h.edge() == e)
    }

    /// A place in the frame of a face that holds it; the first corner where the face does not.
    pub fn at(&self, f: FaceId, place: Place) -> Vector2<f64> {
        let corners = self.corners(f);
        match place {
            Place::Face(_, x) => x,
            Place::Vertex(v) => {
                let corner = self.mesh.face_vertices(f).iter().position(|&w| w == v);
                debug_assert!(corner.is_some(), "vertex {} is no corner of face {}", v.0, f.0);
                corners[corner.unwrap_or(0)]
            }
            Place::Edge(e, t) => {
                let side = self.side(f, e);
                debug_assert!(side.is_some(), "edge {} is no side of face {}", e.0, f.0);
                let i = side.unwrap_or(0);
                let s = along(self.mesh.face_halfedges(f)[i], t);
                corners[i] + (corners[(i + 1) % 3] - corners[i]) * s
            }
        }
    }

    /// A place seen from a side of its face: how far along the edge, from the tail of the edge's first halfedge, and how far away.
    pub fn beside(&self, f: FaceId, e: EdgeId, place: Place) -> [f64; 2] {
        let Some(i) = self.side(f, e) else { return [0.0; 2] };
        let corners = self.corners(f);
        let side = corners[(i + 1) % 3] - corners[i];
        let length = side.norm().max(1e-300);
        let d = self.at(f, place) - corners[i];
        let (x, y) = (d.dot(&side) / length, (side.perp(&d) / length).max(0.0));
        [if self.mesh.face_halfedges(f)[i].0 & 1 == 0 { x } else { length - x }, y]
    }

    /// Barycentric coordinates of a place in the frame of a face.
    pub fn weights(&self, f: FaceId, x: Vector2<f64>) -> [f64; 3] {
        let [a, b, c] = self.corners(f);
        let area = (b - a).perp(&(c - a));
        let weights = [(c - b).perp(&(x - b)), (a - c).perp(&(x - c)), (b - a).perp(&(x - a))];
        weights.map(|w| if area > 0.0 { w / area } else { 1.0 / 3.0 })
    }

    pub fn place_of_weights(&self, f: FaceId, weights: [f64; 3]) -> Vector2<f64> {
        let [a, b, c] = self.corners(f);
        a * weights[0] + b * weights[1] + c * weights[2]
    }

    /// Angle at a vertex of a face between a side that leaves it and the direction to a place in the face.
    pub fn angle(&self, f: FaceId, v: VertexId, e: EdgeId, place: Place) -> f64 {
        let origin = self.at(f, Place::Vertex(v));
        let far = self.mesh.edge_vertices(e).into_iter().find(|&w| w != v).unwrap_or(v);
        let (a, b) = (self.at(f, Place::Vertex(far)) - origin, self.at(f, place) - origin);
        a.perp(&b).abs().atan2(a.dot(&b))
    }
}

/// A parameter of an edge as seen from a halfedge, or back.
pub(super) fn along(h: HalfedgeId, t: f64) -> f64 {
    if h.0 & 1 == 0 { t } else { 1.0 - t }
}

/// Whether two segments of a plane cross or touch.
pub(super) fn meet(s: [Vector2<f64>; 2], t: [Vector2<f64>; 2]) -> bool {
    let turn = |a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>| (b - a).perp(&(c - a));
    turn(s[0], s[1], t[0]) * turn(s[0], s[1], t[1]) <= 0.0
        && turn(t[0], t[1], s[0]) * turn(t[0], t[1], s[1]) <= 0.0
}
