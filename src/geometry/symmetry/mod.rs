//! Symmetries of a surface: mirror planes and rotation axes, found within a tolerance, and the groups that they generate.
//!
//! A symmetry is an isometry S of space with S(surface) = surface. *Within a tolerance* means that nearly all of the surface,
//! mapped by S, lies near the surface and looks the same way there. Triangles need not be symmetric: points are compared
//! with the surface, never vertices with vertices.
//!
//! Guaranteed: every symmetry given was checked at up to 2000 points spread by area; the same input gives the same bits; scale and
//! place do not matter. Not guaranteed: that all symmetries are found where the axes of inertia do not tell (nearly equal
//! moments), though all of the cube's and the icosahedron's are; of a surface of revolution and of a ball only a few are given.

mod candidates;
mod fit;
mod group;

use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

use super::Geometry;
use crate::mesh::Mesh;
use candidates::{Inertia, landmark_directions};
use fit::Shape;

pub use group::{SymmetryError, SymmetryMap, symmetry_group};

/// Deviation up to which a symmetry is one of the vertices too: a thousandfold of the rounding of sines and of files with seven digits.
pub(crate) const EXACT: f64 = 1e-6;

/// Directions closer than this (3°) are one plane or axis. Mirrors of a 16-fold vase are 11° apart.
const SAME: f64 = 0.9986;

/// The highest order of an axis that is looked for. More leaves nothing to tell from a surface of revolution.
const MOST_ORDER: u32 = 12;

/// The longest list: room for the 15 planes and 31 axes of the icosahedron, the largest group that is not one of revolution.
const MOST: usize = 64;

/// What a symmetry does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymmetryKind {
    /// Reflection in a plane.
    Mirror,
    /// Turns by multiples of 2π / `order`.
    Rotation {
        /// How many turns make a whole one, at least 2.
        order: u32,
    },
}

/// A mirror plane or a rotation axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Symmetry {
    /// What it does.
    pub kind: SymmetryKind,
    /// The point of the plane or axis nearest to the centroid of the surface.
    pub point: Point3<f64>,
    /// Unit normal of the plane, or direction of the axis.
    pub direction: Vector3<f64>,
    /// Distance of the mapped surface from the surface that all but 2 % of the area stay below, over the surface's diameter.
    pub deviation: f64,
}

impl Symmetry {
    /// The orthogonal matrix of the reflection, or of the turn by 2π / order.
    pub fn matrix(&self) -> Matrix3<f64> {
        linear_part(self.kind, self.direction)
    }

    /// Where it maps a point.
    pub fn image(&self, p: Point3<f64>) -> Point3<f64> {
        self.point + self.matrix() * (p - self.point)
    }
}

fn linear_part(kind: SymmetryKind, direction: Vector3<f64>) -> Matrix3<f64> {
    match kind {
        SymmetryKind::Mirror => Matrix3::identity() - direction * direction.transpose() * 2.0,
        SymmetryKind::Rotation { order } => {
            let angle = std::f64::consts::TAU / f64::from(order);
            Rotation3::from_axis_angle(&Unit::new_unchecked(direction), angle).into_inner()
        }
    }
}

/// The mirror planes and rotation axes of a surface, best first, at most 64.
///
/// Candidates are the axes of inertia and, where two or three moments are nearly equal, directions given by vertices of rare
/// valence, by a scan of the half circle or of the half sphere, and by planes and axes found before. Each is fitted (points
/// of the mapped surface are drawn to the tangent planes of the surface) and checked.
///
/// An axis is given once, with the highest order up to 12 that the vertices have; where they have none, that the surface has.
/// Of a ball whose vertices have no symmetry its axes of inertia are given, of a surface of revolution the axis and a few planes through it.
///
/// **Takes** a tolerance for [`Symmetry::deviation`], at most 0.1: with 0.01 small differences between the sides of a figure
/// pass, with 0.05 a head turned aside. **Gives** those within [`EXACT`] first; of these, mirrors before axes, axes of high order
/// before low. **Costs** O(V + F log F), tenths of a second.
pub fn find_symmetries(mesh: &Mesh, geometry: &Geometry, tolerance: f64) -> Vec<Symmetry> {
    let tolerance = if tolerance > 0.0 { tolerance.min(0.1) } else { EXACT };
    let Some(shape) = Shape::new(mesh, geometry) else { return Vec::new() };
    let inertia = Inertia::new(mesh, geometry, shape.centre);
    let mut found = Found { shape: &shape, tolerance, list: Vec::new() };
    if inertia.is_distinct() {
        found.try_mirrors(&inertia.axes);
        found.try_axes(&inertia.axes);
        return found.sorted();
    }
    let landmarks = landmark_directions(&shape, mesh);
    if shape.is_round(tolerance) {
        // All directions fit: those count that the vertices share.
        found.tolerance = tolerance.min(EXACT);
        found.try_mirrors(&landmarks);
        found.try_axes(&landmarks);
        found.try_derived();
        if found.list.is_empty() {
            found.tolerance = tolerance;
            found.try_mirrors(&inertia.axes);
            found.try_axes(&inertia.axes);
        }
        return found.sorted();
    }
    found.try_mirrors(&landmarks);
    found.try_axes(&landmarks);
    found.try_mirrors(&inertia.axes);
    found.try_axes(&inertia.axes);
    let two = SymmetryKind::Rotation { order: 2 };
    match inertia.single() {
        Some(axis) => {
            found.try_axes(&[axis]);
            let (meridian, across) = shape.meridian(axis);
            found.try_mirrors(&[meridian, across, axis]);
            found.try_axes(&[meridian, across]);
            for kind in [SymmetryKind::Mirror, two] {
                match shape.scan_circle(kind, axis, tolerance) {
                    Some(directions) => found.try_kind(kind, &directions),
                    // A surface of revolution: more planes and axes would tell nothing new.
                    None => return found.sorted(),
                }
            }
        }
        None => {
            for kind in [SymmetryKind::Mirror, two, SymmetryKind::Rotation { order: 3 }] {
                let directions = shape.scan_sphere(kind);
                found.try_kind(kind, &directions);
            }
        }
    }
    found.try_derived();
    found.sorted()
}

/// What was found so far.
struct Found<'a> {
    shape: &'a Shape<'a>,
    tolerance: f64,
    list: Vec<Symmetry>,
}

impl Found<'_> {
    fn try_kind(&mut self, kind: SymmetryKind, directions: &[Vector3<f64>]) {
        match kind {
            SymmetryKind::Mirror => self.try_mirrors(directions),
            SymmetryKind::Rotation { order } => {
                // The scan is rough: fitted at the order that it was made for, other orders are tried on the result.
                for &direction in directions {
                    let fitted = self.shape.fit(kind, direction, self.tolerance);
                    if let Some(symmetry) = fitted {
                        self.try_axes(&[symmetry.direction]);
                        let near = |s: &Symmetry| is_axis(s) && same(s.direction, direction);
                        if order > 1 && !self.list.iter().any(near) {
                            self.keep(symmetry);
                        }
                    }
                }
            }
        }
    }

    fn try_mirrors(&mut self, directions: &[Vector3<f64>]) {
        for &direction in directions {
            if self.is_known(SymmetryKind::Mirror, direction) {
                continue;
            }
            if let Some(symmetry) = self.shape.fit(SymmetryKind::Mirror, direction, self.tolerance)
            {
                self.keep(symmetry);
            }
        }
    }

    fn try_axes(&mut self, directions: &[Vector3<f64>]) {
        for &direction in directions {
            if self.is_known(SymmetryKind::Rotation { order: 2 }, direction) {
                continue;
            }
            // Orders that the vertices have come before those that only the surface has; the highest first.
            let mut orders: Vec<(bool, u32)> = (2..=MOST_ORDER)
                .filter_map(|order| {
                    let kind = SymmetryKind::Rotation { order };
                    let rough = self.shape.rough_deviation(kind, direction, self.tolerance);
                    (rough < 3.0 * self.tolerance).then_some((rough <= EXACT, order))
                })
                .collect();
            orders.sort_unstable_by(|a, b| b.cmp(a));
            let fitted = orders.into_iter().find_map(|(_, order)| {
                self.shape.fit(SymmetryKind::Rotation { order }, direction, self.tolerance)
            });
            if let Some(symmetry) = fitted {
                self.keep(symmetry);
            }
        }
    }

    /// Axes where mirrors meet, and planes and axes between and across those found.
    fn try_derived(&mut self) {
        for _ in 0..2 {
            let before = self.list.len();
            let best = self.sorted_list();
            // Two axes of one kind generate the rest; more only cost time.
            let known: Vec<Vector3<f64>> = best.iter().take(16).map(|s| s.direction).collect();
            let mut directions = known.clone();
            for (i, a) in known.iter().enumerate() {
                for b in &known[..i] {
                    directions.extend([a.cross(b), a + b, a - b].into_iter().filter_map(unit));
                }
            }
            let directions = distinct(directions);
            self.try_mirrors(&directions);
            self.try_axes(&directions);
            if self.list.len() == before {
                break;
            }
        }
    }

    /// Whether there is already an exact one of this direction.
    fn is_known(&self, kind: SymmetryKind, direction: Vector3<f64>) -> bool {
        self.list.iter().any(|s| {
            is_axis(s) == (kind != SymmetryKind::Mirror)
                && s.deviation <= EXACT
                && same(s.direction, direction)
        })
    }

    /// Keeps the better of two of the same kind and direction.
    fn keep(&mut self, symmetry: Symmetry) {
        let rival = self
            .list
            .iter_mut()
            .find(|s| is_axis(s) == is_axis(&symmetry) && same(s.direction, symmetry.direction));
        match rival {
            Some(rival) if rank(&symmetry) < rank(rival) => *rival = symmetry,
            Some(_) => {}
            None => self.list.push(symmetry),
        }
    }

    fn sorted_list(&self) -> Vec<Symmetry> {
        let mut list = self.list.clone();
        list.sort_by(|a, b| {
            let ([a, c, e], [b, d, f]) = (rank(a), rank(b));
            a.total_cmp(&b).then(c.total_cmp(&d)).then(e.total_cmp(&f))
        });
        list
    }

    fn sorted(self) -> Vec<Symmetry> {
        let mut list = self.sorted_list();
        list.truncate(MOST);
        list
    }
}

/// Smaller is better: deviation in steps beyond rounding, mirrors before axes, high orders before low.
fn rank(s: &Symmetry) -> [f64; 3] {
    let deviation = if s.deviation <= EXACT { 0.0 } else { s.deviation };
    let order = match s.kind {
        SymmetryKind::Mirror => 0.0,
        SymmetryKind::Rotation { order } => 1.0 / f64::from(order),
    };
    [deviation, order, s.deviation]
}

fn is_axis(s: &Symmetry) -> bool {
    s.kind != SymmetryKind::Mirror
}

fn same(a: Vector3<f64>, b: Vector3<f64>) -> bool {
    a.dot(&b).abs() > SAME
}

/// The vector at length 1, none for those that are nearly nothing.
fn unit(v: Vector3<f64>) -> Option<Vector3<f64>> {
    let length = v.norm();
    (length > 1e-6).then(|| v / length)
}

/// The directions without repeats, signs aside.
fn distinct(directions: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
    let mut kept: Vec<Vector3<f64>> = Vec::new();
    for d in directions {
        if !kept.iter().any(|k| k.cross(&d).norm_squared() < 1e-12) {
            kept.push(d);
        }
    }
    kept
}
