//! Sums of squared distances from planes and points.

use nalgebra::{Matrix3, Vector3};

/// q(x) = xᵀ A x + 2 bᵀ x + c, A symmetric and positive semi-definite.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    /// xx, xy, xz, yy, yz, zz.
    a: [f64; 6],
    b: Vector3<f64>,
    c: f64,
}

impl Quadric {
    /// The weighted squared distance from a plane through a point, with a unit normal.
    pub fn plane(n: Vector3<f64>, point: Vector3<f64>, weight: f64) -> Self {
        let d = -n.dot(&point);
        Self {
            a: [n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z]
                .map(|entry| entry * weight),
            b: n * (d * weight),
            c: d * d * weight,
        }
    }

    /// The weighted squared distance from a point.
    pub fn point(p: Vector3<f64>, weight: f64) -> Self {
        let a = [weight, 0.0, 0.0, weight, 0.0, weight];
        Self { a, b: -p * weight, c: p.norm_squared() * weight }
    }

    /// The sum of two.
    pub fn plus(&self, other: &Self) -> Self {
        let mut a = self.a;
        for (entry, more) in a.iter_mut().zip(other.a) {
            *entry += more;
        }
        Self { a, b: self.b + other.b, c: self.c + other.c }
    }

    fn times(&self, x: Vector3<f64>) -> Vector3<f64> {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        Vector3::new(
            xx * x.x + xy * x.y + xz * x.z,
            xy * x.x + yy * x.y + yz * x.z,
            xz * x.x + yz * x.y + zz * x.z,
        )
    }

    /// The value at a point, no less than 0 by rounding.
    pub fn at(&self, x: Vector3<f64>) -> f64 {
        (x.dot(&(self.times(x) + self.b * 2.0)) + self.c).max(0.0)
    }

    /// Where it is least, none where that is not a point to working precision.
    pub fn least(&self) -> Option<Vector3<f64>> {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let scale = xx + yy + zz;
        // Cubes of areas leave the range of numbers where areas do not.
        let a = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) / scale;
        let x = a.cholesky()?.solve(&(self.b / -scale));
        x.iter().all(|x| x.is_finite()).then_some(x)
    }

    /// How far from `from` (0) to `to` (1) it is least, halfway where it is the same everywhere.
    pub fn least_along(&self, from: Vector3<f64>, to: Vector3<f64>) -> f64 {
        let d = to - from;
        let t = -d.dot(&(self.times(from) + self.b)) / d.dot(&self.times(d));
        if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 }
    }
}
