//! Faces that lie on their backs, and the points on edges that turn them over.
//!
//! A face turns over only where the flat metric wants the other diagonal of a quad. One point where the two diagonals cross, on the edge
//! that is there, makes four faces of two, and each of them lies right: nothing else changes, and the surface least of all.

use nalgebra::{Complex, Point2, Point3};

use super::develop::unit;
use super::place::side_of_halfedges;
use crate::flatten::overlap::orientation;
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh};

/// New points keep this share of the edge or diagonal from its ends: any place between would do, and slivers help nobody.
const MARGIN: f64 = 0.01;

/// A point to put on the edge of a side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Insertion {
    /// The side `3 f + i`.
    pub side: usize,
    /// Where on the surface, from the tail of the side.
    pub t: f64,
    /// The side across, and the place of the point seen from here and from there.
    pub across: usize,
    pub places: [Point2<f64>; 2],
}

/// A side of a face with what lies across, in one chart.
struct Quad {
    across: usize,
    /// Tail and tip of the side, the corner opposite, the corner across.
    corners: [Point2<f64>; 4],
    /// The same corners as points of the surface.
    points: [u32; 4],
    /// What takes the chart across to this one: p ↦ turn p + shift.
    turn: Complex<f64>,
    shift: Complex<f64>,
}

/// Points that turn flipped faces over, one for each pair of faces, and the faces that none was found for.
///
/// Greedy, face by face: of the three edges the one whose exchange leaves the larger of the smaller of two areas.
pub(super) fn plan(
    opened: &OpenedMesh,
    uv: &[Point2<f64>],
    positions: &[Point3<f64>],
    flipped: &[FaceId],
) -> (Vec<Insertion>, Vec<FaceId>) {
    let sides = side_of_halfedges(&opened.mesh);
    let mut is_used = vec![false; opened.mesh.face_count()];
    let mut insertions = Vec::new();
    let mut left = Vec::new();
    for &face in flipped {
        if is_used[face.index()] {
            continue;
        }
        let mut best: Option<(f64, usize, Quad)> = None;
        for (i, h) in opened.mesh.face_halfedges(face).into_iter().enumerate() {
            let Some(quad) = Quad::new(opened, uv, &sides, h) else { continue };
            if is_used[quad.across / 3] || quad.across / 3 == face.index() {
                continue;
            }
            let [a, b, k, l] = quad.corners;
            let area = orientation(l, b, k).min(orientation(k, a, l));
            if area > best.as_ref().map_or(0.0, |best| best.0) {
                best = Some((area, 3 * face.index() + i, quad));
            }
        }
        let Some((_, side, quad)) = best else {
            left.push(face);
            continue;
        };
        is_used[face.index()] = true;
        is_used[quad.across / 3] = true;
        insertions.push(quad.insertion(side, positions));
    }
    // A face left over may have been turned over as the other one of a pair.
    left.retain(|f| !is_used[f.index()]);
    (insertions, left)
}

impl Quad {
    fn new(
        opened: &OpenedMesh,
        uv: &[Point2<f64>],
        sides: &[usize],
        h: HalfedgeId,
    ) -> Option<Self> {
        let mesh = &opened.mesh;
        let (other, is_seam) = match opened.partner(h) {
            Some(partner) => (partner, true),
            None => (h.twin(), false),
        };
        mesh.face(other)?;
        let at = |h: HalfedgeId| as_complex(uv[mesh.tail(h).index()]);
        let (a, b, k) = (at(h), at(mesh.next(h)), at(mesh.prev(h)));
        let (mut turn, mut shift) = (Complex::new(1.0, 0.0), Complex::new(0.0, 0.0));
        if is_seam {
            let (far_b, far_a) = (at(other), at(mesh.next(other)));
            turn = unit((b - a) * (far_b - far_a).conj());
            shift = a - turn * far_a;
        }
        let l = turn * at(mesh.prev(other)) + shift;
        let corners = [a, b, k, l].map(|z| Point2::new(z.re, z.im));
        corners.iter().all(|p| (p.x + p.y).is_finite()).then_some(())?;
        let point = |h: HalfedgeId| opened.vertex_points[mesh.tail(h).index()];
        let points = [point(h), point(mesh.next(h)), point(mesh.prev(h)), point(mesh.prev(other))];
        Some(Self { across: sides[other.index()], corners, points, turn, shift })
    }

    /// Where the two diagonals cross after the projective map that keeps circumcircles.
    fn insertion(&self, side: usize, positions: &[Point3<f64>]) -> Insertion {
        let share = |[ak, al, bk, bl]: [f64; 4]| {
            let t = (ak * al) / (ak * al + bk * bl);
            if t.is_finite() { t.clamp(MARGIN, 1.0 - MARGIN) } else { 0.5 }
        };
        let [a, b, k, l] = self.points.map(|p| positions[p as usize]);
        let lengths = [(k - a), (l - a), (k - b), (l - b)].map(|d| d.norm());
        let t = share(lengths);
        let [a, b, k, l] = self.corners;
        let s = share([(k - a).norm(), (k - b).norm(), (l - a).norm(), (l - b).norm()]);
        let here = k + (l - k) * s;
        let there = (as_complex(here) - self.shift) * self.turn.conj();
        Insertion { side, t, across: self.across, places: [here, Point2::new(there.re, there.im)] }
    }
}

fn as_complex(p: Point2<f64>) -> Complex<f64> {
    Complex::new(p.x, p.y)
}
