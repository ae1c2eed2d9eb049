//! Samples cut from smooth bodies: a double torus, a hood, an armchair, a plush bear. A half (of the torus an
//! eighth) is made and mirrored, so that they are symmetric to the last bit.

use nalgebra::Vector3;

use super::fields::{ellipsoid, leaning, right, ring, rise, rod, rounded_block, union, without};
use super::implicit::Shape;
use crate::mesh::Soup;

type Point = Vector3<f64>;

/// Where x, y or z is negative: the walls that a half is cut at.
fn left(p: Point) -> f64 {
    -p.x
}

fn below(p: Point) -> f64 {
    -p.y
}

fn behind(p: Point) -> f64 {
    -p.z
}

/// Two rings side by side, grown together.
pub(super) fn double_torus() -> Soup {
    let field = |p: Point| {
        let [a, b] = [-0.66, 0.66].map(|x| ring(p - Point::new(x, 0.0, 0.0), 0.52, 0.24));
        union(a, b, 0.3)
    };
    let shape = Shape {
        field: &field,
        walls: &[&left, &below, &behind],
        bounds: [[0.7, 0.15, 0.4], [0.8, 0.2, 0.5]],
    };
    let eighth = shape.triangulate(0.0335);
    eighth.mirror(0, 0).mirror(1, 1).mirror(2, 2).into_soup()
}

/// The hood of a car: wider at the windscreen, two creases that run together towards the nose, and a scoop between
/// them with a slot in its front.
pub(super) fn car_hood() -> Soup {
    let field = |p: Point| {
        let (x, z) = (p.x.abs(), p.z);
        let nose = (z - 0.1).max(0.0);
        let flank = (x - 0.75).max(0.0);
        let crown = 0.06 - 0.1 * x * x - 0.04 * z * z - 0.3 * nose * nose - 0.9 * flank * flank;
        let crease = 0.05 * rise(0.5 - 0.14 * z - x, -0.045, 0.045);
        let scoop = rise(x, 0.36, 0.22) * rise(z, 0.34, 0.2) * rise(z, -0.75, 0.15);
        p.y - (crown + crease + 0.12 * scoop)
    };
    let outline = |p: Point| {
        let (x, z) = (p.x.abs(), p.z);
        let side = x - (1.0 - 0.09 * z - 0.07 * z * z);
        let front = z - (1.06 - 0.2 * x * x);
        let back = -0.92 + 0.1 * x * x - z;
        -union(-side, union(-front, -back, 0.1), 0.2)
    };
    // In the front of the scoop, as seen from above.
    let slot =
        |p: Point| -rounded_block(Point::new(p.x, 0.0, p.z - 0.275), [0.2, 1.0, 0.045], 0.045);
    let shape = Shape {
        field: &field,
        walls: &[&left, &outline, &slot],
        bounds: [[0.6, -0.1, 0.05], [0.7, 0.6, 1.15]],
    };
    shape.triangulate(0.021).mirror(0, 0).into_soup()
}

/// An upholstered chair on four feet, with a buttoned back.
pub(super) fn armchair() -> Soup {
    const BUTTONS: [[f64; 2]; 5] = [[0.0, 0.4], [0.32, 0.4], [0.16, 0.2], [0.0, 0.0], [0.32, 0.0]];
    let field = |p: Point| {
        let q = right(p);
        let base = rounded_block(p - Point::new(0.0, -0.42, 0.0), [0.74, 0.2, 0.62], 0.07);
        // Cushions are blocks that swell towards the middle.
        let c = p - Point::new(0.0, -0.12, 0.1);
        let cushion = rounded_block(c, [0.6, 0.15, 0.62], 0.1) - 0.06 * hill([c.x, c.z], 0.62);
        let b = leaning(p - Point::new(0.0, 0.38, -0.48), 0.2);
        let mut back = rounded_block(b, [0.63, 0.66, 0.17], 0.15) - 0.08 * hill([b.x, b.y], 0.8);
        if b.z > 0.0 {
            let pulls = BUTTONS.map(|[x, y]| hill([b.x.abs() - x, b.y - y], 0.12));
            back += 0.055 * pulls.iter().sum::<f64>();
        }
        let panel = rounded_block(q - Point::new(0.7, -0.24, 0.02), [0.13, 0.38, 0.68], 0.08);
        let roll = rod(q, [[0.71, 0.17, -0.48], [0.71, 0.14, 0.54]], 0.18, 0.19);
        let foot = |z: f64| rod(q, [[0.62, -0.6, z], [0.65, -0.88, z * 1.06]], 0.085, 0.06);
        let arms = union(panel, roll, 0.08);
        let body = union(union(union(base, arms, 0.05), back, 0.06), cushion, 0.07);
        union(body, foot(0.5).min(foot(-0.5)), 0.03)
    };
    half(&field, [[0.55, 0.05, 0.0], [0.65, 1.15, 1.0]], 0.034)
}

/// 1 at the origin, 0 from `radius` on, round and smooth.
fn hill([x, y]: [f64; 2], radius: f64) -> f64 {
    let inside = (1.0 - (x * x + y * y) / (radius * radius)).max(0.0);
    inside * inside
}

/// A bear that sits.
pub(super) fn plush_bear() -> Soup {
    let field = |p: Point| {
        let q = right(p);
        let at = |x: f64, y: f64, z: f64| Point::new(x, y, z);
        let belly = ellipsoid(p - at(0.0, -0.38, 0.0), [0.5, 0.56, 0.45]);
        let head = ellipsoid(p - at(0.0, 0.46, 0.06), [0.46, 0.41, 0.4]);
        let muzzle = ellipsoid(p - at(0.0, 0.36, 0.42), [0.2, 0.155, 0.15]);
        let nose = ellipsoid(p - at(0.0, 0.43, 0.56), [0.075, 0.05, 0.05]);
        let eye = ellipsoid(q - at(0.165, 0.55, 0.4), [0.055, 0.055, 0.05]);
        let ear = ellipsoid(q - at(0.36, 0.82, 0.02), [0.18, 0.18, 0.1]);
        let hollow = ellipsoid(q - at(0.36, 0.82, 0.13), [0.1, 0.1, 0.07]);
        let arm = rod(q, [[0.4, -0.08, 0.05], [0.66, -0.42, 0.3]], 0.15, 0.165);
        let leg = rod(q, [[0.28, -0.72, 0.1], [0.46, -0.76, 0.6]], 0.2, 0.17);
        let sole = ellipsoid(q - at(0.48, -0.7, 0.7), [0.19, 0.23, 0.14]);
        let tail = (p - at(0.0, -0.68, -0.45)).norm() - 0.13;
        let ears = without(ear, hollow, 0.05);
        let face = union(union(union(head, muzzle, 0.06), nose, 0.02), eye, 0.02);
        let body = union(union(belly, arm, 0.06), union(leg, sole, 0.06), 0.06);
        union(union(union(face, ears, 0.04), body, 0.06), tail, 0.04)
    };
    half(&field, [[0.45, 0.0, 0.1], [0.55, 1.1, 0.95]], 0.0275)
}

/// The right half of a body and its mirror image.
fn half(field: &dyn Fn(Point) -> f64, bounds: [[f64; 3]; 2], step: f64) -> Soup {
    Shape { field, walls: &[&left], bounds }.triangulate(step).mirror(0, 0).into_soup()
}
