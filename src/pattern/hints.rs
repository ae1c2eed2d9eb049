//! What a person should expect of a piece: how much the material is stretched, how tightly it is bent, and what is eased in at seams.
//!
//! The map of a face from the surface to the plane has singular values σ₁ ≥ σ₂: the largest and the smallest factor by which lengths grow.
//! Curvature is measured by the tensor of edges [CSM03]: over the faces about a vertex of total area A,
//! T = 1/A Σ β ℓ e eᵀ with the turn β, the length ℓ and the direction e of each edge, half of it for each of its two faces. Its
//! eigenvalue of largest size is 1 / R with R the smallest radius of bending.
//!
//! From: \[CSM03\] Cohen-Steiner, Morvan: *Restricted Delaunay Triangulations and Normal Cycle*, 2003.

use std::fmt;

use nalgebra::{Matrix3, Point2};

use super::laid::LaidSurface;
use super::piece::{Pattern, Piece, piece_name};
use super::seam::Partner;
use crate::flatten::overlap::orientation;
use crate::mesh::FaceId;

/// What counts as a bend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HintParams {
    /// Edges that turn by more are folds and not bends, radians.
    pub fold_angle: f64,
}

impl Default for HintParams {
    fn default() -> Self {
        Self { fold_angle: 30f64.to_radians() }
    }
}

/// Hints for all pieces and all seams.
#[derive(Clone, Debug, PartialEq)]
pub struct Hints {
    /// For each piece of the pattern.
    pub pieces: Vec<PieceHints>,
    /// For each seam both of whose sides are there, by number.
    pub seams: Vec<Ease>,
}

/// What becomes of a piece when it is made into the surface. Positive percentages: longer, or larger, in the plane than on the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct PieceHints {
    /// Name of the piece.
    pub name: String,
    /// Mean of ½ (|σ₁ − 1| + |σ₂ − 1|) over the area, in percent.
    pub mean_percent: f64,
    /// Largest σ₁ − 1, in percent: how much too long the plane is anywhere.
    pub longest_percent: f64,
    /// Smallest σ₂ − 1, in percent: how much too short it is anywhere.
    pub shortest_percent: f64,
    /// Area in the plane over area on the surface, less 1, in percent.
    pub area_percent: f64,
    /// Smallest radius of bending, mm, edges that are folded and the tightest 2 % of the area left out; ∞ where the piece stays flat.
    pub radius_mm: f64,
}

/// Lengths of the two sides of a seam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ease {
    /// Number of the seam.
    pub number: usize,
    /// The patches on its two sides, the one met first in front.
    pub patches: [usize; 2],
    /// Whether it joins a piece to itself.
    pub is_own: bool,
    /// Length of either side in the plane, mm.
    pub lengths_mm: [f64; 2],
    /// Length on the surface, mm.
    pub surface_length_mm: f64,
}

impl Ease {
    /// By how much the first side is longer, mm.
    pub fn difference_mm(&self) -> f64 {
        self.lengths_mm[0] - self.lengths_mm[1]
    }

    /// The difference over the length on the surface, in percent.
    pub fn percent(&self) -> f64 {
        100.0 * self.difference_mm() / self.surface_length_mm
    }
}

/// Faces below this part of the mean area are slivers of the cut and not counted for extremes.
const SLIVER: f64 = 1e-6;
/// Part of a piece that may be bent more tightly than is told. Smaller: slivers speak; larger: narrow rolls are passed over.
const TIGHTEST: f64 = 0.02;

/// Measures pieces and seams.
///
/// **Takes** what the pattern was made of. **Gives** finite numbers, except an infinite radius for flat pieces; 0 where a piece has no face that
/// can be measured. **Costs** O(n).
pub fn hints(surface: &LaidSurface, pattern: &Pattern, params: &HintParams) -> Hints {
    let mesh = &surface.opened.mesh;
    let mut faces: Vec<Vec<FaceId>> = vec![Vec::new(); surface.opened.patch_count];
    for face in mesh.faces() {
        faces[surface.opened.face_patches[face.index()] as usize].push(face);
    }
    let radii = radii(surface, params);
    let piece =
        |piece: &Piece| piece_hints(surface, piece, &faces[piece.patch], radii[piece.patch]);
    let mut seams = Vec::new();
    for (p, piece) in pattern.pieces.iter().enumerate() {
        for (s, seam) in piece.seams.iter().enumerate().filter(|(_, seam)| !seam.is_second) {
            let Some((q, t)) = pattern.across(p, s) else { continue };
            seams.push(Ease {
                number: seam.number,
                patches: [p, q].map(|p| pattern.pieces[p].patch),
                is_own: matches!(seam.partner, Partner::Own { .. }),
                lengths_mm: [seam.length_mm, pattern.pieces[q].seams[t].length_mm],
                surface_length_mm: seam.surface_length_mm,
            });
        }
    }
    seams.sort_by_key(|ease| ease.number);
    Hints { pieces: pattern.pieces.iter().map(piece).collect(), seams }
}

fn piece_hints(surface: &LaidSurface, piece: &Piece, faces: &[FaceId], radius: f64) -> PieceHints {
    let maps: Vec<FaceMap> = faces.iter().map(|&face| FaceMap::new(surface, face)).collect();
    let total: f64 = maps.iter().map(|map| map.area).sum();
    let least = SLIVER * total / maps.len().max(1) as f64;
    let counted = || maps.iter().filter(|map| map.area > least);
    let weight: f64 = counted().map(|map| map.area).sum();
    let mean = |value: &dyn Fn(&FaceMap) -> f64| {
        let sum: f64 = counted().map(|map| map.area * value(map)).sum();
        if weight > 0.0 { 100.0 * sum / weight } else { 0.0 }
    };
    let extremes = counted().map(|map| map.sigma);
    let (longest, shortest) =
        extremes.fold((1.0_f64, 1.0_f64), |(l, s), [a, b]| (l.max(a), s.min(b)));
    PieceHints {
        name: piece.name.clone(),
        mean_percent: mean(&|map| 0.5 * map.sigma.iter().map(|s| (s - 1.0).abs()).sum::<f64>()),
        longest_percent: 100.0 * (longest - 1.0),
        shortest_percent: 100.0 * (shortest - 1.0),
        area_percent: mean(&|map| map.sigma[0] * map.sigma[1] - 1.0),
        radius_mm: radius * surface.mm_per_unit,
    }
}

/// How a face is mapped.
struct FaceMap {
    /// Area on the surface; 0 where the map has no sense.
    area: f64,
    /// σ₁ and σ₂, the latter negative where the face is turned over.
    sigma: [f64; 2],
}

impl FaceMap {
    fn new(surface: &LaidSurface, face: FaceId) -> Self {
        let vertices = surface.opened.mesh.face_vertices(face);
        let [a, b, c] = vertices.map(|v| surface.position(v));
        let [p, q, r] = vertices.map(|v| Point2::from(surface.charts[v.index()]));
        let (u, v) = (b - a, c - a);
        let (base, area) = (u.norm(), 0.5 * u.cross(&v).norm());
        // Corners in the plane of the face: 0, (base, 0), (x, y).
        let (x, y) = (u.dot(&v) / base, 2.0 * area / base);
        let along = (q - p) / base;
        let across = ((r - p) - along * x) / y;
        // ‖J‖² and det J give (σ₁ ± σ₂)² = ‖J‖² ± 2 det J.
        let squared = along.norm_squared() + across.norm_squared();
        let determinant = orientation(p, q, r) / (2.0 * area);
        let sum = (squared + 2.0 * determinant).max(0.0).sqrt();
        let difference = (squared - 2.0 * determinant).max(0.0).sqrt();
        let sigma = [0.5 * (sum + difference), 0.5 * (sum - difference)];
        let is_sound = sigma.iter().all(|s| s.is_finite()) && area > 0.0;
        if is_sound { Self { area, sigma } } else { Self { area: 0.0, sigma: [1.0; 2] } }
    }
}

/// The smallest radius of bending in each patch, in units of the surface.
fn radii(surface: &LaidSurface, params: &HintParams) -> Vec<f64> {
    let opened = surface.opened;
    let mesh = &opened.mesh;
    let mut tensors = vec![(0.0, Matrix3::zeros()); mesh.vertex_count()];
    let mut totals = vec![(0.0, 0); opened.patch_count];
    for face in mesh.faces() {
        let area = 0.5 * surface.doubled_normal(face).norm();
        let mut tensor = Matrix3::zeros();
        for h in mesh.face_halfedges(face).into_iter().filter(|h| mesh.face(h.twin()).is_some()) {
            let turn = surface.turn(h).filter(|turn| turn.abs() <= params.fold_angle);
            let e = surface.position(mesh.tip(h)) - surface.position(mesh.tail(h));
            let length = e.norm();
            if let Some(turn) = turn.filter(|_| length > 0.0) {
                tensor += e * e.transpose() * (0.5 * turn / length);
            }
        }
        for v in mesh.face_vertices(face) {
            tensors[v.index()].0 += area;
            tensors[v.index()].1 += tensor;
        }
        let total = &mut totals[opened.face_patches[face.index()] as usize];
        *total = (total.0 + area, total.1 + 1);
    }
    // Every vertex with its curvature and the area that it stands for.
    let mut bends: Vec<Vec<(f64, f64)>> = vec![Vec::new(); opened.patch_count];
    let mut patches = vec![None; mesh.vertex_count()];
    for face in mesh.faces() {
        for v in mesh.face_vertices(face) {
            patches[v.index()] = Some(opened.face_patches[face.index()] as usize);
        }
    }
    for (patch, (area, tensor)) in patches.iter().zip(tensors) {
        if let Some(patch) = patch.filter(|_| area > 0.0) {
            bends[patch].push(((tensor / area).symmetric_eigenvalues().amax(), area));
        }
    }
    let radius = |(mut bends, (total, _)): (Vec<(f64, f64)>, (f64, u32))| {
        bends.sort_by(|a, b| b.0.total_cmp(&a.0));
        let all: f64 = bends.iter().map(|(_, area)| area).sum();
        // Slivers beside a cut bend as rounding wants them to: the tightest part that is seen.
        let mut above = 0.0;
        let tightest = bends.into_iter().find(|(_, area)| {
            above += area;
            above >= TIGHTEST * all
        });
        let curvature = tightest.map_or(0.0, |(curvature, _)| curvature);
        // Rounding bends a flat piece a little: a radius of a million times its size is flat.
        if curvature * total.sqrt() > 1e-6 { 1.0 / curvature } else { f64::INFINITY }
    };
    bends.into_iter().zip(totals).map(radius).collect()
}

impl fmt::Display for PieceHints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "stretch {:.1} % (at most {} / {} %), area {} %",
            self.mean_percent,
            signed(self.longest_percent),
            signed(self.shortest_percent),
            signed(self.area_percent)
        )?;
        if self.radius_mm.is_finite() {
            let digits = usize::from(self.radius_mm < 10.0);
            write!(f, ", bends to R {:.digits$} mm", self.radius_mm)?;
        }
        Ok(())
    }
}

impl fmt::Display for Ease {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let difference = self.difference_mm();
        let longer = usize::from(difference < 0.0);
        let name = |side: usize| match self.is_own {
            true => format!("{}{}", self.number, ["a", "b"][side]),
            false => piece_name(self.patches[side]),
        };
        if difference.abs() < 0.05 {
            return write!(f, "seam {}: equally long", self.number);
        }
        let (a, b) = (name(longer), name(1 - longer));
        let (mm, percent) = (difference.abs(), self.percent().abs());
        write!(f, "seam {}: {a} {mm:.1} mm ({percent:.1} %) longer than {b}", self.number)
    }
}

/// With a sign and one decimal; no −0.0.
fn signed(x: f64) -> String {
    let text = format!("{x:+.1}");
    if text == "-0.0" { "+0.0".into() } else { text }
}
