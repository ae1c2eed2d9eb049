//! Solid bodies as functions: negative inside, about the distance from the surface near it. Smooth unions join them.
//!
//! Made of + − × ÷ and √ alone, so that the same bits come out on all targets.

use nalgebra::Vector3;

/// A box with half sides `half` about the origin, edges rounded by `radius`.
pub(super) fn rounded_block(p: Vector3<f64>, half: [f64; 3], radius: f64) -> f64 {
    let q = p.abs() - Vector3::from(half).add_scalar(-radius);
    q.map(|x| x.max(0.0)).norm() + q.max().min(0.0) - radius
}

/// An ellipsoid of half axes `radii` about the origin. The distance is exact on the surface to first order only.
pub(super) fn ellipsoid(p: Vector3<f64>, radii: [f64; 3]) -> f64 {
    let radii = Vector3::from(radii);
    let once = p.component_div(&radii);
    let twice = once.component_div(&radii);
    let reach = once.norm();
    // The bound is met at the centre only, where any negative number serves.
    reach * (reach - 1.0) / twice.norm().max(1e-9) - if reach < 1e-9 { radii.min() } else { 0.0 }
}

/// The ball-ended rod between two points, of radius `r` at the first and `s` at the second.
pub(super) fn rod(p: Vector3<f64>, ends: [[f64; 3]; 2], r: f64, s: f64) -> f64 {
    let [a, b] = ends.map(Vector3::from);
    let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
    (p - a - (b - a) * t).norm() - (r + (s - r) * t)
}

/// A ring about the y axis.
pub(super) fn ring(p: Vector3<f64>, major: f64, minor: f64) -> f64 {
    let across = (p.x * p.x + p.z * p.z).sqrt() - major;
    (across * across + p.y * p.y).sqrt() - minor
}

/// The union of two bodies with a fillet of about `width`.
pub(super) fn union(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (width - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * width)
}

/// What is left of a body without another, with an edge rounded by about `width`.
pub(super) fn without(a: f64, b: f64, width: f64) -> f64 {
    -union(-a, b, width)
}

/// The point as seen by a body that leans back: turned about the x axis by an angle of tangent `slope`.
pub(super) fn leaning(p: Vector3<f64>, slope: f64) -> Vector3<f64> {
    let length = (1.0 + slope * slope).sqrt();
    let (cos, sin) = (1.0 / length, slope / length);
    Vector3::new(p.x, cos * p.y - sin * p.z, sin * p.y + cos * p.z)
}

/// The mirror image on the side of positive x.
pub(super) fn right(p: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(p.x.abs(), p.y, p.z)
}

/// 0 up to `from`, 1 from `to` on, smooth in between.
pub(super) fn rise(x: f64, from: f64, to: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
