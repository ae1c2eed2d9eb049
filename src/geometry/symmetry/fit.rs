//! A surface prepared for being compared with its images.

use nalgebra::{Matrix3, Matrix6, Point3, SymmetricEigen, Vector3, Vector6};

use super::{EXACT, Symmetry, SymmetryKind, linear_part};
use crate::geometry::{Geometry, Hit, Nearest};
use crate::mesh::{FaceId, Mesh, VertexId};

/// Points that a symmetry is checked at. Fewer miss a missing arm, more take longer than they tell.
const CHECKED: usize = 2000;

/// Points that a symmetry is fitted to.
const FITTED: usize = 128;

/// Points of a first look.
const ROUGH: usize = 48;

/// Share of the points whose distance counts; the rest may lie anywhere.
const COUNTED: f64 = 0.98;

/// Share of the points that may look elsewhere than the surface near them, by more than 60°.
const TWISTED: f64 = 0.05;

/// A surface with a tree and points spread over it by area.
pub(super) struct Shape<'a> {
    mesh: &'a Mesh,
    pub positions: &'a [Point3<f64>],
    tree: Nearest,
    vertex_normals: Vec<Vector3<f64>>,
    face_normals: Vec<Vector3<f64>>,
    /// Whether there are sides to tell: an open surface may be mapped to its own back.
    has_inside: bool,
    /// Vertices so that every beginning of the list is spread evenly by area.
    pub samples: Vec<VertexId>,
    /// Centroid of the surface.
    pub centre: Point3<f64>,
    pub diameter: f64,
}

impl<'a> Shape<'a> {
    /// None where the surface has no extent.
    pub fn new(mesh: &'a Mesh, geometry: &'a Geometry) -> Option<Self> {
        let positions = &geometry.positions;
        let mut moment = Vector3::zeros();
        for (t, area) in mesh.triangles().iter().zip(&geometry.face_areas) {
            moment +=
                t.iter().map(|v| positions[v.index()].coords).sum::<Vector3<f64>>() * (area / 3.0);
        }
        let centre = Point3::from(moment / geometry.total_area());
        let farthest = |from: Point3<f64>| {
            let mut best = (0.0, from);
            for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
                let distance = (positions[v.index()] - from).norm();
                if distance > best.0 {
                    best = (distance, positions[v.index()]);
                }
            }
            best
        };
        let diameter = farthest(farthest(centre).1).0;
        if !(diameter > 0.0 && diameter.is_finite() && centre.iter().all(|x| x.is_finite())) {
            return None;
        }
        Some(Self {
            mesh,
            positions,
            tree: Nearest::new(mesh, positions),
            vertex_normals: geometry.vertex_normals(mesh),
            face_normals: geometry.face_normals(mesh),
            has_inside: mesh.boundary_loops().is_empty(),
            samples: spread(mesh, geometry),
            centre,
            diameter,
        })
    }

    /// Whether all points lie at one distance from the centre.
    pub fn is_round(&self, tolerance: f64) -> bool {
        let radius = |v: &VertexId| (self.positions[v.index()] - self.centre).norm();
        let mut radii: Vec<f64> = self.samples.iter().map(radius).collect();
        radii.sort_by(f64::total_cmp);
        let skip = radii.len() / 100;
        radii[radii.len() - 1 - skip] - radii[skip] <= tolerance * self.diameter
    }

    /// The point of the surface nearest to the image of a vertex, on faces that look the way that the image does.
    pub fn image(
        &self,
        v: VertexId,
        matrix: &Matrix3<f64>,
        centre: Point3<f64>,
        hint: Option<FaceId>,
    ) -> Option<Hit> {
        let point = centre + matrix * (self.positions[v.index()] - centre);
        if !self.has_inside {
            return self.tree.find_among(point, hint, |_| true);
        }
        let normal = matrix * self.vertex_normals[v.index()];
        let looks = |f: FaceId| !(self.face_normals[f.index()].dot(&normal) < 0.0);
        self.tree.find_among(point, hint, looks).or_else(|| self.tree.find(point))
    }

    fn is_twisted(&self, v: VertexId, matrix: &Matrix3<f64>, hit: &Hit) -> bool {
        let corners = self.mesh.face_vertices(hit.face);
        let normal: Vector3<f64> =
            (0..3).map(|i| self.vertex_normals[corners[i].index()] * hit.weights[i]).sum();
        let cosine = normal.dot(&(matrix * self.vertex_normals[v.index()]));
        let cosine = if self.has_inside { cosine } else { cosine.abs() };
        cosine < 0.5 * normal.norm()
    }

    /// Deviation at the first `count` samples; infinite where too many look elsewhere or more than allowed lie beyond `limit`.
    fn deviation(
        &self,
        matrix: &Matrix3<f64>,
        centre: Point3<f64>,
        count: usize,
        limit: f64,
    ) -> f64 {
        let samples = &self.samples[..count.min(self.samples.len())];
        let allowed = (samples.len() as f64 * (1.0 - COUNTED)).floor();
        let (mut beyond, mut twisted) = (0.0, 0.0);
        let mut distances = Vec::with_capacity(samples.len());
        for &v in samples {
            let Some(hit) = self.image(v, matrix, centre, None) else { return f64::INFINITY };
            let distance = hit.squared.sqrt() / self.diameter;
            beyond += f64::from(u8::from(!(distance <= limit)));
            twisted += f64::from(u8::from(self.is_twisted(v, matrix, &hit)));
            if beyond > allowed || twisted > (TWISTED * samples.len() as f64).max(1.0) {
                return f64::INFINITY;
            }
            distances.push(distance);
        }
        distances.sort_by(f64::total_cmp);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count of at most 2000"
        )]
        let outliers = allowed as usize;
        distances.get(distances.len().wrapping_sub(1 + outliers)).copied().unwrap_or(f64::INFINITY)
    }

    /// Deviation at a few points about the centre, infinite beyond thrice the tolerance.
    pub fn rough_deviation(
        &self,
        kind: SymmetryKind,
        direction: Vector3<f64>,
        tolerance: f64,
    ) -> f64 {
        let matrix = linear_part(kind, direction);
        self.deviation(&matrix, self.centre, ROUGH, 3.0 * tolerance)
    }

    /// Mean distance of a few mapped points, capped so that single ones do not decide.
    pub fn score(&self, kind: SymmetryKind, direction: Vector3<f64>) -> f64 {
        const LOOKED_AT: usize = 32;
        let matrix = linear_part(kind, direction);
        let cap = 0.1 * self.diameter;
        let samples = &self.samples[..LOOKED_AT.min(self.samples.len())];
        let distance = |&v: &VertexId| {
            self.image(v, &matrix, self.centre, None).map_or(cap, |hit| hit.squared.sqrt().min(cap))
        };
        samples.iter().map(distance).sum::<f64>() / (samples.len() as f64 * self.diameter)
    }

    /// The symmetry of that kind near a direction, none where the fit leaves more than the tolerance.
    pub fn fit(
        &self,
        kind: SymmetryKind,
        direction: Vector3<f64>,
        tolerance: f64,
    ) -> Option<Symmetry> {
        let mut best = (direction, self.centre, self.rough_deviation(kind, direction, 0.1));
        if best.2 > EXACT {
            if tolerance <= EXACT {
                return None;
            }
            let (direction, point) = self.refined(kind, direction, tolerance)?;
            let matrix = linear_part(kind, direction);
            let fitted = self.deviation(&matrix, point, ROUGH, 3.0 * tolerance);
            if fitted < best.2 {
                best = (direction, point, fitted);
            }
            if !(best.2 <= 3.0 * tolerance) {
                return None;
            }
        }
        let (direction, point, _) = best;
        let matrix = linear_part(kind, direction);
        let deviation = self.deviation(&matrix, point, CHECKED, tolerance);
        if !(deviation <= tolerance) || self.stays(&matrix, point, tolerance) {
            return None;
        }
        let offset = self.centre - point;
        let along = direction * offset.dot(&direction);
        let point = match kind {
            SymmetryKind::Mirror => self.centre - along,
            SymmetryKind::Rotation { .. } => point + along,
        };
        // One of the two signs, by the first large component.
        let sign = direction.iter().find(|x| x.abs() > 0.5).map_or(1.0, |x| x.signum());
        Some(Symmetry { kind, point, direction: direction * sign, deviation })
    }

    /// Whether nothing moves: a flat sheet in its own plane.
    fn stays(&self, matrix: &Matrix3<f64>, centre: Point3<f64>, tolerance: f64) -> bool {
        self.samples.iter().take(ROUGH).all(|v| {
            let arm = self.positions[v.index()] - centre;
            (matrix * arm - arm).norm() <= 2.0 * tolerance * self.diameter
        })
    }

    /// Draws the image of the surface to the tangent planes of the surface: S′ = T S T⁻¹ with a small motion T = (ω, t) moves
    /// the image s = S p by ω × s − S (ω × p) + (1 − S) t, in coordinates about the centre.
    ///
    /// **Gives** none where three rounds leave half of the points thrice the tolerance away.
    fn refined(
        &self,
        kind: SymmetryKind,
        direction: Vector3<f64>,
        tolerance: f64,
    ) -> Option<(Vector3<f64>, Point3<f64>)> {
        let (mut direction, mut centre) = (direction, self.centre);
        for round in 0..10 {
            let matrix = linear_part(kind, direction);
            let samples = self.samples.iter().take(FITTED);
            let mut hits: Vec<(VertexId, Hit)> =
                samples.filter_map(|&v| Some((v, self.image(v, &matrix, centre, None)?))).collect();
            let far = 3.0 * tolerance * self.diameter;
            let near = hits.iter().filter(|(_, hit)| hit.squared <= far * far).count();
            if round >= 3 && 2 * near < hits.len() {
                return None;
            }
            // The worst tenth does not vote: what has no counterpart.
            hits.sort_by(|a, b| a.1.squared.total_cmp(&b.1.squared).then(a.0.cmp(&b.0)));
            hits.truncate(hits.len() * 9 / 10);
            let mut normal_matrix = Matrix6::zeros();
            let mut right = Vector6::zeros();
            for (v, hit) in &hits {
                let p = (self.positions[v.index()] - centre) / self.diameter;
                let s = matrix * p;
                let m = self.face_normals[hit.face.index()];
                let back = matrix.transpose() * m;
                let turn = s.cross(&m) - p.cross(&back);
                let shift = m - back;
                let row = Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z);
                let gap = (hit.point - centre) / self.diameter - s;
                normal_matrix += row * row.transpose();
                right += row * m.dot(&gap);
            }
            // Directions that hardly show (turns about the axis; all turns of a ball) are left alone.
            let eigen = SymmetricEigen::new(normal_matrix);
            let floor = 1e-3 * hits.len() as f64;
            let mut step = Vector6::zeros();
            for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
                if *value > floor {
                    step += vector * (vector.dot(&right) / value);
                }
            }
            let length = step.norm();
            if !length.is_finite() {
                break;
            }
            // Tangent planes are good for a tenth of a radian.
            step *= (0.1 / length).min(1.0);
            let turn = Vector3::new(step[0], step[1], step[2]);
            direction = (direction + turn.cross(&direction)).normalize();
            centre += Vector3::new(step[3], step[4], step[5]) * self.diameter;
            if length < 1e-8 {
                break;
            }
        }
        Some((direction, centre))
    }
}

/// Vertices at equal steps of area; each beginning of the list is spread too, because it runs by the golden section.
fn spread(mesh: &Mesh, geometry: &Geometry) -> Vec<VertexId> {
    let mut sums = Vec::with_capacity(mesh.vertex_count());
    let mut sum = 0.0;
    for area in geometry.vertex_dual_areas(mesh) {
        sum += area;
        sums.push(sum);
    }
    let used = mesh.vertices().filter(|&v| mesh.halfedge(v).is_some());
    if mesh.vertex_count() <= CHECKED {
        // Few enough to take each once, in the same scattered order.
        let mut all: Vec<(f64, VertexId)> = used
            .enumerate()
            .map(|(i, v)| ((i as f64 * 0.618_033_988_749_895).fract(), v))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        return all.into_iter().map(|(_, v)| v).collect();
    }
    let mut samples = Vec::with_capacity(CHECKED);
    for i in 0..CHECKED {
        let at = ((i as f64 + 0.5) * 0.618_033_988_749_895).fract() * sum;
        let index = sums.partition_point(|&s| s <= at).min(sums.len() - 1);
        samples.push(VertexId::from(index));
    }
    samples
}
