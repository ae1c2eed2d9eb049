//! The energy of places in the plane: triangles, seams, pins; its gradient, and the matrix of a Newton step.

use nalgebra::{Complex, Point2};

use super::face::{Distortion, Face, largest_step};
use super::seam::Seam;
use super::start::Start;
use super::{IsometricEnergy, IsometricParams};
use crate::flatten::small;
use crate::geometry::Geometry;
use crate::linalg::Pattern;
use crate::mesh::{OpenedMesh, VertexId};

/// Height of a triangle at rest over its longest side below which it gets this height: see [`Geometry::measure`].
const THIN: f64 = 1e-8;

/// What every vertex' own stiffness is raised by in a step, as a fraction: rigid motion of charts and turning of triangles have none.
/// It holds steps back by that little, and changes no energy.
const OWN: f64 = 1e-9;

/// A vertex pulled to a place, or held there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pin {
    pub vertex: u32,
    pub place: Complex<f64>,
    /// Whether the vertex is there: then it does not move at all.
    pub is_held: bool,
}

/// What may change between steps, apart from places.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Forces {
    /// μ of each seam.
    pub multipliers: Vec<f64>,
    /// By how much seams are stiffer than their weights.
    pub stiffness: f64,
    /// Taken from the seams' energy, so that it does not jump where multipliers change.
    pub offset: f64,
    pub pins: Vec<Pin>,
    /// Rim vertices that are held because they would come to lie across a rim.
    pub touching: Vec<u32>,
}

/// Triangles, seams and the pattern of their Hessian.
pub(super) struct Model {
    pub area: f64,
    distortion: Distortion,
    pin_weight: f64,
    faces: Vec<Face>,
    pub seams: Vec<Seam>,
    /// For each face in the plane its number on the surface.
    face_numbers: Vec<u32>,
    shares: Vec<f64>,
    pub is_free: Vec<bool>,
    pub pattern: Pattern,
    face_slots: Vec<[u32; 15]>,
    seam_slots: Vec<[u32; 28]>,
}

/// A face at rest.
pub(super) fn rest_face(opened: &OpenedMesh, geometry: &Geometry, f: usize, area: f64) -> Face {
    let f = crate::mesh::FaceId::from(f);
    let sides = opened.mesh.face_halfedges(f).map(|h| geometry.edge_length(h.edge()));
    let longest = sides.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    let (sin, cos) = geometry.corner_angles[f.index()][0].sin_cos();
    let height = (sides[2] * sin).max(THIN * longest * longest / sides[0].max(THIN * longest));
    let rest = [
        Complex::new(0.0, 0.0),
        Complex::new(sides[0].max(THIN * longest), 0.0),
        Complex::new(sides[2] * cos, height),
    ];
    let corners = opened.mesh.face_vertices(f).map(|v| v.0);
    Face::new(corners, rest, geometry.face_areas[f.index()] / area)
}

impl Model {
    pub fn new(
        opened: &OpenedMesh,
        geometry: &Geometry,
        starts: &[Start],
        params: &IsometricParams,
    ) -> Self {
        let mesh = &opened.mesh;
        let patches = opened.vertex_patches();
        let area = geometry.total_area();
        let is_free: Vec<bool> = mesh
            .vertices()
            .map(|v| mesh.halfedge(v).is_some() && starts[patches[v.index()] as usize].is_refined())
            .collect();
        let refined =
            |f: &crate::mesh::FaceId| starts[opened.face_patches[f.index()] as usize].is_refined();
        let numbers: Vec<_> = mesh.faces().filter(refined).collect();
        let faces: Vec<Face> =
            numbers.iter().map(|f| rest_face(opened, geometry, f.index(), area)).collect();
        let mut seams = Vec::new();
        for f in &numbers {
            for h in mesh.face_halfedges(*f) {
                let Some(partner) = opened.partner(h).filter(|p| h < *p) else { continue };
                let ends = [mesh.tail(h), mesh.tip(h), mesh.tail(partner), mesh.tip(partner)];
                let length = geometry.edge_length(h.edge());
                if ends.iter().all(|v| is_free[v.index()]) && length > 0.0 {
                    let weight = params.seam_weight * length / area.sqrt();
                    seams.push(Seam { ends: ends.map(|v| v.0), length, weight });
                }
            }
        }
        let mut pairs = Vec::new();
        for face in &faces {
            for_pairs::<6>(&face.corners, |a, b, _| pairs.push([a, b]));
        }
        for seam in &seams {
            for_pairs::<8>(&seam.ends, |a, b, _| pairs.push([a, b]));
        }
        // An entry of two equal rows stands on the diagonal; it has no pair, but a slot.
        let different: Vec<[u32; 2]> = pairs.iter().filter(|p| p[0] != p[1]).copied().collect();
        let (pattern, slots) = Pattern::new(2 * is_free.len(), &different);
        let mut slots = slots.into_iter();
        let mut next = |[a, b]: [u32; 2]| {
            if a == b { small(pattern.diagonal(a as usize)) } else { slots.next().unwrap_or(0) }
        };
        let mut pairs = pairs.into_iter();
        let mut take = || pairs.next().map_or(0, &mut next);
        let face_slots = faces.iter().map(|_| std::array::from_fn(|_| take())).collect();
        let seam_slots = seams.iter().map(|_| std::array::from_fn(|_| take())).collect();
        Self {
            area,
            distortion: params.distortion,
            pin_weight: params.pin_weight / area,
            shares: faces.iter().map(|f| f.weight).collect(),
            face_numbers: numbers.iter().map(|f| f.0).collect(),
            faces,
            seams,
            is_free,
            pattern,
            face_slots,
            seam_slots,
        }
    }

    /// Multiplies the weight of each face of the surface.
    pub fn set_materials(&mut self, weights: &[f64]) {
        for ((face, share), &number) in
            self.faces.iter_mut().zip(&self.shares).zip(&self.face_numbers)
        {
            face.weight = share * weights[number as usize];
        }
    }

    /// The energy of places; infinite where a triangle is turned over.
    pub fn energy(&self, x: &[Complex<f64>], forces: &Forces) -> IsometricEnergy {
        let distortion: f64 = self.faces.iter().map(|f| f.energy(self.distortion, x)).sum();
        let seam = self.seam_energy(x, forces) - forces.offset;
        let pins = forces.pins.iter().filter(|p| !p.is_held);
        let pins: f64 =
            pins.map(|p| self.pin_weight * (x[p.vertex as usize] - p.place).norm_sqr()).sum();
        IsometricEnergy { total: distortion + seam + pins, distortion, seam, pins }
    }

    /// Σ c e² + μ e.
    pub fn seam_energy(&self, x: &[Complex<f64>], forces: &Forces) -> f64 {
        let energy = |(seam, mu): (&Seam, &f64)| {
            let e = seam.difference(x);
            (forces.stiffness * seam.weight * e + mu) * e
        };
        self.seams.iter().zip(&forces.multipliers).map(energy).sum()
    }

    /// Largest relative difference of seam partners.
    pub fn seam_difference(&self, x: &[Complex<f64>]) -> f64 {
        self.seams.iter().map(|s| s.relative_difference(x)).fold(0.0, f64::max)
    }

    /// Gradient and matrix of a step, rows 2 v + c. Rows of vertices that do not move are those of the identity.
    ///
    /// **Gives** positive definite values.
    pub fn derivatives(
        &self,
        x: &[Complex<f64>],
        forces: &Forces,
    ) -> (Vec<Complex<f64>>, Vec<f64>) {
        let n = x.len();
        let mut gradient = vec![Complex::new(0.0, 0.0); n];
        let mut values = vec![0.0; self.pattern.entry_count()];
        for (face, slots) in self.faces.iter().zip(&self.face_slots) {
            let h = face.derivatives(self.distortion, x, true, &mut gradient);
            self.scatter(&mut values, &face.corners, slots, &h);
        }
        for ((seam, slots), mu) in self.seams.iter().zip(&self.seam_slots).zip(&forces.multipliers)
        {
            let parts = [forces.stiffness * seam.weight, *mu];
            let h = seam.derivatives(x, parts, true, &mut gradient);
            self.scatter(&mut values, &seam.ends, slots, &h);
        }
        for pin in &forces.pins {
            let v = pin.vertex as usize;
            gradient[v] += (x[v] - pin.place) * (2.0 * self.pin_weight);
            for row in [2 * v, 2 * v + 1] {
                values[self.pattern.diagonal(row)] += 2.0 * self.pin_weight;
            }
        }
        let moves = self.moves(forces);
        for v in 0..n {
            for row in [2 * v, 2 * v + 1] {
                let diagonal = &mut values[self.pattern.diagonal(row)];
                *diagonal += OWN * (*diagonal + 1e-3 / self.area);
            }
            if !moves[v] {
                gradient[v] = Complex::new(0.0, 0.0);
            }
        }
        self.isolate(&moves, &mut values);
        (gradient, values)
    }

    /// Which vertices can move.
    pub fn moves(&self, forces: &Forces) -> Vec<bool> {
        let mut moves = self.is_free.clone();
        for pin in forces.pins.iter().filter(|p| p.is_held) {
            moves[pin.vertex as usize] = false;
        }
        for &v in &forces.touching {
            moves[v as usize] = false;
        }
        moves
    }

    /// Makes rows of vertices that do not move those of the identity.
    fn isolate(&self, moves: &[bool], values: &mut [f64]) {
        let mut cut = |a: u32, b: u32, slot: u32| {
            let still = |row: u32| !moves[row as usize / 2];
            if a != b && (still(a) || still(b)) {
                values[slot as usize] = 0.0;
            }
        };
        for (face, slots) in self.faces.iter().zip(&self.face_slots) {
            for_pairs::<6>(&face.corners, |a, b, i| cut(a, b, slots[i]));
        }
        for (seam, slots) in self.seams.iter().zip(&self.seam_slots) {
            for_pairs::<8>(&seam.ends, |a, b, i| cut(a, b, slots[i]));
        }
        for v in (0..moves.len()).filter(|&v| !moves[v]) {
            values[self.pattern.diagonal(2 * v)] = 1.0;
            values[self.pattern.diagonal(2 * v + 1)] = 1.0;
        }
    }

    /// Adds an element's Hessian.
    fn scatter<const ROWS: usize>(
        &self,
        values: &mut [f64],
        corners: &[u32],
        slots: &[u32],
        hessian: &[[f64; ROWS]; ROWS],
    ) {
        for r in 0..ROWS {
            let row = 2 * corners[r / 2] as usize + r % 2;
            values[self.pattern.diagonal(row)] += hessian[r][r];
        }
        let mut local = (1..ROWS).flat_map(|r| (0..r).map(move |c| (r, c)));
        for_pairs::<ROWS>(corners, |a, b, i| {
            if let Some((r, c)) = local.next() {
                // Two corners that are one vertex: both entries of the pair land on the diagonal.
                values[slots[i] as usize] += if a == b { 2.0 } else { 1.0 } * hessian[r][c];
            }
        });
    }

    /// The largest step along d for which no triangle loses its area.
    pub fn largest_step(&self, x: &[Complex<f64>], d: &[Complex<f64>]) -> f64 {
        self.faces.iter().map(|f| largest_step(f.corners, x, d)).fold(f64::INFINITY, f64::min)
    }

    /// Whether every triangle is counter-clockwise, by exact predicates.
    pub fn is_upright(&self, x: &[Complex<f64>]) -> bool {
        self.faces.iter().all(|f| {
            let [a, b, c] = f.corners.map(|v| {
                let z = x[v as usize];
                Point2::new(z.re, z.im)
            });
            crate::flatten::overlap::orientation(a, b, c) > 0.0
        })
    }

    /// Whether a vertex belongs to a chart that is refined.
    pub fn has(&self, v: VertexId) -> bool {
        self.is_free.get(v.index()).copied().unwrap_or(false)
    }
}

/// Calls with the rows of every off-diagonal entry of an element below its diagonal, and the entry's number.
fn for_pairs<const ROWS: usize>(corners: &[u32], mut call: impl FnMut(u32, u32, usize)) {
    let row = |r: usize| 2 * corners[r / 2] + small(r % 2);
    let mut number = 0;
    for r in 1..ROWS {
        for c in 0..r {
            call(row(r), row(c), number);
            number += 1;
        }
    }
}
