//! A surface together with its charts: what folds, marks and hints are measured on.

use nalgebra::{Point3, Vector3};

use super::piece::{Pattern, Piece};
use super::seam::{Partner, Seam};
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh, VertexId};

/// What [`Pattern::new`] takes, under one name.
#[derive(Clone, Copy, Debug)]
pub struct LaidSurface<'a> {
    /// The opened surface.
    pub opened: &'a OpenedMesh,
    /// A place for each of its vertices, NaN where a patch has none.
    pub charts: &'a [[f64; 2]],
    /// The points of the surface, in the unit of the charts.
    pub positions: &'a [Point3<f64>],
    /// Millimetres per unit of both.
    pub mm_per_unit: f64,
}

impl LaidSurface<'_> {
    /// Where a vertex lies in space.
    pub fn position(&self, v: VertexId) -> Point3<f64> {
        self.positions[self.opened.vertex_points[v.index()] as usize]
    }

    /// Twice the area of a face along its outer normal, square units.
    pub fn doubled_normal(&self, face: FaceId) -> Vector3<f64> {
        let [a, b, c] = self.opened.mesh.face_vertices(face).map(|v| self.position(v));
        (b - a).cross(&(c - a))
    }

    /// How far the surface turns from the face of a halfedge to the face beyond its edge, across a cut too.
    ///
    /// β = atan2(e · (m × n), m · n) with the normals m, n of the two faces and the direction e of the halfedge. **Gives** radians
    /// from −π to π, positive where the edge is a ridge seen from outside (a mountain), negative in a groove (a valley); `None` at
    /// the rim of the surface and where a face has no area.
    pub fn turn(&self, h: HalfedgeId) -> Option<f64> {
        let mesh = &self.opened.mesh;
        let face = mesh.face(h)?;
        let beyond = mesh.face(h.twin()).or_else(|| mesh.face(self.opened.partner(h)?))?;
        let (m, n) = (self.doubled_normal(face), self.doubled_normal(beyond));
        let along = self.position(mesh.tip(h)) - self.position(mesh.tail(h));
        let (m, n) = (m.try_normalize(0.0)?, n.try_normalize(0.0)?);
        let along = along.try_normalize(0.0)?;
        let (sin, cos) = (along.dot(&m.cross(&n)), m.dot(&n));
        // Folded flat, rounding would choose the sign: a ridge.
        let turn = if cos < 0.0 && sin.abs() < 1e-9 { cos.acos() } else { sin.atan2(cos) };
        turn.is_finite().then_some(turn)
    }

    /// How far the surface turns at each side of each seam: a list of a piece for each of its seams, with one angle for each side of that
    /// seam, as [`LaidSurface::turn`] has it; 0 where that has none.
    pub fn seam_turns(&self, piece: &Piece) -> Vec<Vec<f64>> {
        let mesh = &self.opened.mesh;
        let side = |seam: &Seam, i: usize| {
            let vertices = &piece.outlines[seam.outline].vertices;
            let n = vertices.len();
            let (tail, tip) = (vertices[(seam.first + i) % n], vertices[(seam.first + i + 1) % n]);
            mesh.outgoing(tail).find(|&h| mesh.tip(h) == tip && mesh.face(h).is_some())
        };
        let turns = |seam: &Seam| {
            (0..seam.sides)
                .map(|i| side(seam, i).and_then(|h| self.turn(h)).unwrap_or(0.0))
                .collect()
        };
        piece.seams.iter().map(turns).collect()
    }
}

impl Pattern {
    /// The other side of a seam: indices of its piece and of the seam in it. `None` where that piece is missing.
    pub fn across(&self, piece: usize, seam: usize) -> Option<(usize, usize)> {
        let this = &self.pieces[piece].seams[seam];
        let is_it = |p: usize, s: usize, other: &Seam| {
            other.number == this.number && (p, s) != (piece, seam)
        };
        let partner = match this.partner {
            Partner::Own { .. } => piece,
            Partner::Patch(patch) => self.pieces.iter().position(|p| p.patch == patch)?,
        };
        let seams = &self.pieces[partner].seams;
        let found = seams.iter().enumerate().position(|(s, other)| is_it(partner, s, other))?;
        Some((partner, found))
    }
}
