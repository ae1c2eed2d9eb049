//! Fold lines: where a piece of paper, card or sheet metal is folded.
//!
//! At an edge between two faces the surface turns by an angle β, seen from outside positive at a ridge (mountain fold) and
//! negative in a groove (valley fold). Edges that turn by less than a least angle are left flat; the others are joined to
//! lines where they go straight on with the same sign and nearly the same angle.
//!
//! Guaranteed: each edge that turns by at least the least angle lies on exactly one fold, each fold on a path of such edges of one
//! sign. Not guaranteed: that paper can be folded so, or that folds of one piece do not cross in a chart that overlaps itself.

mod chains;

use self::chains::join;
pub(super) use self::chains::{simplified, split};
use super::laid::LaidSurface;
use super::piece::{Pattern, Piece, length};
use super::sheet::Layer;
use crate::mesh::VertexId;

/// Which edges are folds, and which of them make one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoldParams {
    /// Edges that turn by less are not shown, radians. Smaller: lines all over curved parts; larger: paper that bulges.
    pub least_angle: f64,
    /// Edges whose angles differ by more do not make one line, radians.
    pub difference: f64,
    /// Edges whose directions in the plane differ by more do not make one line, radians.
    pub bend: f64,
    /// How far a line may run beside the points that it leaves out, mm.
    pub tolerance_mm: f64,
}

impl Default for FoldParams {
    fn default() -> Self {
        Self {
            least_angle: 5f64.to_radians(),
            difference: 15f64.to_radians(),
            bend: 15f64.to_radians(),
            tolerance_mm: 0.02,
        }
    }
}

/// A line along which a piece is folded.
#[derive(Clone, Debug, PartialEq)]
pub struct Fold {
    /// Places, mm, in the frame of the piece's outlines.
    pub points: Vec<[f64; 2]>,
    /// The vertex of the opened surface at each point.
    pub vertices: Vec<VertexId>,
    /// By how much the surface turns, the mean over the length: radians, positive for a mountain, seen from the outer side.
    pub angle: f64,
}

impl Fold {
    /// Whether the two sides are folded away from a person who looks at the outer side.
    pub fn is_mountain(&self) -> bool {
        self.angle > 0.0
    }

    /// [`Layer::FoldMountain`] or [`Layer::FoldValley`].
    pub fn layer(&self) -> Layer {
        fold_layer(self.angle, 0.0)
    }

    /// Length, mm.
    pub fn length_mm(&self) -> f64 {
        length(&self.points)
    }
}

/// The layer of a line that is folded by an angle; [`Layer::Score`] where that is less than the least angle, as at the base of a flap
/// that goes on flat.
pub fn fold_layer(angle: f64, least_angle: f64) -> Layer {
    match angle {
        angle if angle.abs() < least_angle => Layer::Score,
        angle if angle > 0.0 => Layer::FoldMountain,
        _ => Layer::FoldValley,
    }
}

/// The fold lines inside the pieces: one list for each piece of the pattern.
///
/// **Takes** what the pattern was made of; its pieces may have been moved since, but not turned. **Gives** folds in the frame of the outlines,
/// with ends on the very points of an outline where they end there; ordered by their first edges. **Costs** O(n log n).
pub fn folds(surface: &LaidSurface, pattern: &Pattern, params: &FoldParams) -> Vec<Vec<Fold>> {
    let mesh = &surface.opened.mesh;
    let mut edges: Vec<Vec<Edge>> = vec![Vec::new(); surface.opened.patch_count];
    for edge in mesh.edges().filter(|&e| !mesh.is_boundary_edge(e)) {
        let h = edge.halfedge();
        let (Some(angle), Some(face)) = (surface.turn(h), mesh.face(h)) else { continue };
        if angle.abs() >= params.least_angle {
            let patch = surface.opened.face_patches[face.index()] as usize;
            edges[patch].push(Edge { ends: mesh.edge_vertices(edge), angle });
        }
    }
    let frames = pattern.pieces.iter().map(|piece| Frame::new(surface, piece));
    let pieces = pattern.pieces.iter().zip(frames);
    pieces.map(|(piece, frame)| join(&edges[piece.patch], &frame, params)).collect()
}

/// An edge that is folded.
#[derive(Clone, Debug)]
struct Edge {
    ends: [VertexId; 2],
    angle: f64,
}

/// Places of a piece's vertices where the piece lies now.
struct Frame<'a> {
    surface: &'a LaidSurface<'a>,
    shift: [f64; 2],
    /// The points of the outlines, by vertex: bit for bit.
    rim: Vec<(VertexId, [f64; 2])>,
}

impl<'a> Frame<'a> {
    fn new(surface: &'a LaidSurface<'a>, piece: &Piece) -> Self {
        let outlines = piece.outlines.iter();
        let mut rim: Vec<(VertexId, [f64; 2])> = outlines
            .flat_map(|outline| outline.vertices.iter().copied().zip(outline.points.clone()))
            .collect();
        rim.sort_by_key(|&(v, _)| v);
        let mut frame = Self { surface, shift: [0.0; 2], rim };
        if let Some(&(v, p)) = frame.rim.first() {
            let chart = frame.chart(v);
            frame.shift = [p[0] - chart[0], p[1] - chart[1]];
        }
        frame
    }

    fn chart(&self, v: VertexId) -> [f64; 2] {
        self.surface.charts[v.index()].map(|x| x * self.surface.mm_per_unit)
    }

    fn place(&self, v: VertexId) -> [f64; 2] {
        if let Ok(i) = self.rim.binary_search_by_key(&v, |&(w, _)| w) {
            return self.rim[i].1;
        }
        let [x, y] = self.chart(v);
        [x + self.shift[0], y + self.shift[1]]
    }
}

/// By how much each of the two faces at a fold is shortened for the thickness t of the material: (t / 2) tan(β / 2), mm.
///
/// **Takes** the thickness in mm and the angle by which the material is turned. **Gives** `None` for material up to 0.3 mm, where it
/// does not matter, and for folds of more than 170°, where the formula has no sense.
///
/// ```
/// # use cutflow::pattern::fold_shortening_mm;
/// # use std::f64::consts::FRAC_PI_2;
/// assert_eq!(fold_shortening_mm(0.2, FRAC_PI_2), None);
/// assert!((fold_shortening_mm(2.0, FRAC_PI_2).unwrap() - 1.0).abs() < 1e-12);
/// ```
pub fn fold_shortening_mm(thickness_mm: f64, angle: f64) -> Option<f64> {
    let is_thick = thickness_mm > 0.3 && thickness_mm.is_finite();
    let is_open = angle.abs() < 170f64.to_radians();
    (is_thick && is_open).then(|| 0.5 * thickness_mm * (0.5 * angle.abs()).tan())
}
