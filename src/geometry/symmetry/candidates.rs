//! Directions that planes and axes of symmetry may have.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use super::fit::Shape;
use super::{SymmetryKind, distinct, unit};
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};

/// Difference of moments, over the largest, below which they are equal. With less, axes of inertia turn far with small
/// differences between the sides of a figure; with more, most figures are scanned.
const EQUAL: f64 = 0.1;

/// The most vertices of one signature that pairs are made of.
const RARE: usize = 48;

/// The most directions that a scan gives.
const MOST_MINIMA: usize = 24;

/// Mean distance over the diameter from which a minimum of the scan cannot be fitted: half a step beside a symmetry it is 0.02.
const HOPELESS: f64 = 0.04;

/// Axes of inertia of a surface.
pub(super) struct Inertia {
    /// Unit vectors.
    pub axes: [Vector3<f64>; 3],
    /// Whether the moments of axes (1, 2), (2, 0), (0, 1) are nearly equal.
    equal: [bool; 3],
}

impl Inertia {
    pub fn new(mesh: &Mesh, geometry: &Geometry, centre: Point3<f64>) -> Self {
        let mut moments = Matrix3::zeros();
        for (t, area) in mesh.triangles().iter().zip(&geometry.face_areas) {
            let arms = t.map(|v| geometry.positions[v.index()] - centre);
            let sum = arms[0] + arms[1] + arms[2];
            let outer = arms.iter().map(|a| a * a.transpose()).sum::<Matrix3<f64>>();
            moments += (outer + sum * sum.transpose()) * (area / 12.0);
        }
        let eigen = SymmetricEigen::new(moments);
        let values = eigen.eigenvalues;
        let largest = values.max();
        let axes = [0, 1, 2].map(|i| eigen.eigenvectors.column(i).into_owned().normalize());
        let equal =
            [0, 1, 2].map(|i| (values[(i + 1) % 3] - values[(i + 2) % 3]).abs() < EQUAL * largest);
        Self { axes, equal }
    }

    pub fn is_distinct(&self) -> bool {
        !self.equal.contains(&true)
    }

    /// The axis whose moment differs from two equal ones.
    pub fn single(&self) -> Option<Vector3<f64>> {
        let mut pairs = (0..3).filter(|&i| self.equal[i]);
        let first = pairs.next()?;
        pairs.next().is_none().then(|| self.axes[first])
    }
}

/// Directions from the centre to, between and across vertices of rare valence at one distance.
pub(super) fn landmark_directions(shape: &Shape, mesh: &Mesh) -> Vec<Vector3<f64>> {
    let mut marks: Vec<(usize, f64, VertexId)> = mesh
        .vertices()
        .filter(|&v| mesh.halfedge(v).is_some())
        .map(|v| {
            let ring = if mesh.is_boundary_vertex(v) { 1000 } else { 0 };
            let radius = (shape.positions[v.index()] - shape.centre).norm() / shape.diameter;
            (ring + mesh.outgoing(v).count(), radius, v)
        })
        .filter(|&(valence, ..)| valence != 6 && valence != 1004)
        .collect();
    marks.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    let groups = marks.chunk_by(|a, b| a.0 == b.0 && b.1 - a.1 < 1e-6);
    let mut rare: Vec<_> = groups.filter(|g| (2..=RARE).contains(&g.len())).collect();
    rare.sort_by_key(|g| g.len());
    let mut directions = Vec::new();
    let mut sum = 0;
    for group in rare {
        sum += group.len();
        if sum > RARE {
            break;
        }
        let arms: Vec<Vector3<f64>> = group
            .iter()
            .filter_map(|&(.., v)| unit(shape.positions[v.index()] - shape.centre))
            .collect();
        directions.extend(&arms);
        for (i, a) in arms.iter().enumerate() {
            for b in &arms[..i] {
                directions.extend([a - b, a + b, a.cross(b)].into_iter().filter_map(unit));
            }
        }
    }
    distinct(directions)
}

impl Shape<'_> {
    /// Normals of the plane through an axis and the vertex farthest from it, and of the plane across that one.
    pub fn meridian(&self, axis: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let mut best = (0.0, axis.cross(&orthogonal(axis)));
        for &v in &self.samples {
            let arm = self.positions[v.index()] - self.centre;
            let arm = arm - axis * arm.dot(&axis);
            // Equal but for rounding: the first.
            if arm.norm() > best.0 * (1.0 + 1e-9) {
                best = (arm.norm(), arm);
            }
        }
        let across = best.1.normalize();
        (axis.cross(&across), across)
    }

    /// Directions across an axis that fit better than those beside them; none where all fit (a surface of revolution).
    pub fn scan_circle(
        &self,
        kind: SymmetryKind,
        axis: Vector3<f64>,
        tolerance: f64,
    ) -> Option<Vec<Vector3<f64>>> {
        const STEPS: usize = 90;
        let (x, y) = (orthogonal(axis), axis.cross(&orthogonal(axis)));
        let directions: Vec<Vector3<f64>> = (0..STEPS)
            .map(|i| {
                let (sin, cos) = (i as f64 * std::f64::consts::PI / STEPS as f64).sin_cos();
                x * cos + y * sin
            })
            .collect();
        let scores: Vec<f64> = directions.iter().map(|&d| self.score(kind, d)).collect();
        if scores.iter().all(|&s| s < 0.5 * tolerance) {
            return None;
        }
        let near = |i: usize| [(i + 1) % STEPS, (i + STEPS - 1) % STEPS];
        Some(minima(&directions, &scores, near))
    }

    /// Directions of the half sphere that fit better than those around them.
    pub fn scan_sphere(&self, kind: SymmetryKind) -> Vec<Vector3<f64>> {
        // About 7° apart: the fit draws in from a tenth of a radian.
        const POINTS: usize = 400;
        const AROUND: f64 = 0.978;
        let directions: Vec<Vector3<f64>> = (0..POINTS)
            .map(|i| {
                let z = (i as f64 + 0.5) / POINTS as f64;
                let (sin, cos) = (i as f64 * 2.399_963_229_728_653).sin_cos();
                let r = (1.0 - z * z).sqrt();
                Vector3::new(r * cos, r * sin, z)
            })
            .collect();
        let scores: Vec<f64> = directions.iter().map(|&d| self.score(kind, d)).collect();
        minima(&directions, &scores, |i| {
            let here = directions[i];
            let near = move |(_, d): &(usize, &Vector3<f64>)| d.dot(&here).abs() > AROUND;
            directions.iter().enumerate().filter(near).map(|(j, _)| j)
        })
    }
}

/// The directions with scores no higher than those near them, best first.
fn minima<I: IntoIterator<Item = usize>>(
    directions: &[Vector3<f64>],
    scores: &[f64],
    near: impl Fn(usize) -> I,
) -> Vec<Vector3<f64>> {
    let mut found: Vec<usize> = (0..directions.len())
        .filter(|&i| scores[i] < HOPELESS && near(i).into_iter().all(|j| scores[i] <= scores[j]))
        .collect();
    found.sort_by(|&i, &j| scores[i].total_cmp(&scores[j]).then(i.cmp(&j)));
    found.truncate(MOST_MINIMA);
    found.into_iter().map(|i| directions[i]).collect()
}

/// A unit vector across another.
fn orthogonal(v: Vector3<f64>) -> Vector3<f64> {
    let mut least = Vector3::zeros();
    least[v.iamin()] = 1.0;
    v.cross(&least).normalize()
}
