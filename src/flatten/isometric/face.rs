//! The distortion of one triangle: value, gradient and Hessian in closed form.
//!
//! A linear map of the plane is w = a z + b z̄ with complex a and b; p = |a|, q = |b| give the singular values σ₁ = p + q and σ₂ = p − q, and a
//! distortion h(σ₁) + h(σ₂) is a function of p and q alone. In the frame â, i â, b̂, i b̂ its Hessian is
//! h″(σ₁) (â + b̂)² + h″(σ₂) (â − b̂)² + (2 (h′(σ₁) + h′(σ₂)) / (σ₁ + σ₂)) (i â)² + (2 (h′(σ₁) − h′(σ₂)) / (σ₁ − σ₂)) (i b̂)²,
//! squares meaning d dᵀ: four eigenvalues, of which only the third, that of turning, can be negative. No decomposition is needed, and
//! the last quotient is a polynomial.
//!
//! **From** Smith, de Goes, Kim: *Analytic Eigensystems for Isotropic Distortion Energies*, 2019.

use nalgebra::Complex;

/// What a triangle's map costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Distortion {
    /// σ₁² + σ₁⁻² + σ₂² + σ₂⁻² − 4: shrinking costs as much as stretching, and collapse is infinitely dear.
    #[default]
    SymmetricDirichlet,
    /// (σ₁ − 1)² + (σ₂ − 1)²: as rigid as possible. Softer where it must be soft; only the line search keeps triangles from turning over.
    Arap,
}

/// h, h′, h″ at both singular values, and the eigenvalues of turning and shearing.
struct Values {
    value: f64,
    slopes: [f64; 2],
    curvatures: [f64; 2],
    turning: f64,
    shearing: f64,
}

impl Distortion {
    fn values(self, s: f64, t: f64) -> Values {
        match self {
            Self::SymmetricDirichlet => {
                let slope = |s: f64| 2.0 * (s - 1.0 / s.powi(3));
                let (sum, product) = (s * s + s * t + t * t, (s * t).powi(3));
                Values {
                    value: (s - 1.0 / s).powi(2) + (t - 1.0 / t).powi(2),
                    slopes: [slope(s), slope(t)],
                    curvatures: [s, t].map(|s| 2.0 + 6.0 / s.powi(4)),
                    turning: 2.0 * (slope(s) + slope(t)) / (s + t),
                    shearing: 4.0 + 4.0 * sum / product,
                }
            }
            Self::Arap => Values {
                value: (s - 1.0).powi(2) + (t - 1.0).powi(2),
                slopes: [s, t].map(|s| 2.0 * (s - 1.0)),
                curvatures: [2.0; 2],
                turning: 4.0 - 8.0 / (s + t),
                shearing: 4.0,
            },
        }
    }
}

/// A triangle with what it weighs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub corners: [u32; 3],
    /// ∂φ/∂z of the hat function of each corner on the triangle at rest: a = Σ c w, b = Σ c̄ w.
    coefficients: [Complex<f64>; 3],
    /// Share of the whole area, times the material's weight.
    pub weight: f64,
}

impl Face {
    /// **Takes** the corners of the triangle at rest, counter-clockwise.
    pub fn new(corners: [u32; 3], rest: [Complex<f64>; 3], weight: f64) -> Self {
        let [u, v] = [rest[1] - rest[0], rest[2] - rest[0]];
        let doubled = u.re * v.im - u.im * v.re;
        let coefficients = [0, 1, 2].map(|i| {
            let opposite = rest[(i + 2) % 3] - rest[(i + 1) % 3];
            // The gradient is the opposite side, turned inwards, over the doubled area; half its conjugate is ∂φ/∂z.
            (opposite * Complex::new(0.0, 1.0) / doubled).conj() * 0.5
        });
        Self { corners, coefficients, weight }
    }

    /// a and b of the map to these places.
    pub fn map(&self, x: &[Complex<f64>]) -> [Complex<f64>; 2] {
        let (mut a, mut b) = (Complex::default(), Complex::default());
        for (c, &v) in self.coefficients.iter().zip(&self.corners) {
            a += c * x[v as usize];
            b += c.conj() * x[v as usize];
        }
        [a, b]
    }

    /// Singular values, the second negative where the triangle is turned over.
    pub fn singular_values(&self, x: &[Complex<f64>]) -> [f64; 2] {
        let [p, q] = self.map(x).map(|z| z.norm());
        [p + q, p - q]
    }

    /// Infinite where the triangle is turned over.
    pub fn energy(&self, distortion: Distortion, x: &[Complex<f64>]) -> f64 {
        let [s, t] = self.singular_values(x);
        // Not `<=`: what is no number is as bad.
        if !(t > 0.0) {
            return f64::INFINITY;
        }
        self.weight * distortion.values(s, t).value
    }

    /// Adds the gradient, and gives the Hessian: row 2 i + c is coordinate c of corner i.
    ///
    /// **Takes** whether the Hessian is to be positive semi-definite: the eigenvalue of turning is taken as 0 where it is negative.
    pub fn derivatives(
        &self,
        distortion: Distortion,
        x: &[Complex<f64>],
        convex: bool,
        gradient: &mut [Complex<f64>],
    ) -> [[f64; 6]; 6] {
        let [a, b] = self.map(x);
        let [p, q] = [a.norm(), b.norm()];
        let unit = |z: Complex<f64>, r: f64| if r > 0.0 { z / r } else { Complex::new(1.0, 0.0) };
        let (along, across) = (unit(a, p), unit(b, q));
        let v = distortion.values(p + q, p - q);
        let [s, t] = v.slopes;
        for (c, &corner) in self.coefficients.iter().zip(&self.corners) {
            gradient[corner as usize] +=
                (c.conj() * along * (s + t) + c * across * (s - t)) * self.weight;
        }
        let (i, none) = (Complex::new(0.0, 1.0), Complex::new(0.0, 0.0));
        let turning = if convex { v.turning.max(0.0) } else { v.turning };
        let parts = [
            (v.curvatures[0], along, across),
            (v.curvatures[1], along, -across),
            (turning, i * along, none),
            (v.shearing, none, i * across),
        ];
        let mut hessian = [[0.0; 6]; 6];
        for (lambda, on_a, on_b) in parts {
            let mut d = [0.0; 6];
            for (k, c) in self.coefficients.iter().enumerate() {
                let z = c.conj() * on_a + c * on_b;
                (d[2 * k], d[2 * k + 1]) = (z.re, z.im);
            }
            for r in 0..6 {
                for c in 0..6 {
                    hessian[r][c] += self.weight * lambda * d[r] * d[c];
                }
            }
        }
        hessian
    }
}

/// The largest step s along d for which no triangle loses its area: the smallest positive root of area (x + s d); infinite without root.
pub(super) fn largest_step(corners: [u32; 3], x: &[Complex<f64>], d: &[Complex<f64>]) -> f64 {
    let [i, j, k] = corners.map(|v| v as usize);
    let (u, v, du, dv) = (x[j] - x[i], x[k] - x[i], d[j] - d[i], d[k] - d[i]);
    let cross = |a: Complex<f64>, b: Complex<f64>| a.re * b.im - a.im * b.re;
    smallest_root(cross(du, dv), cross(du, v) + cross(u, dv), cross(u, v))
}

/// Smallest s > 0 with a s² + b s + c = 0 where c > 0.
fn smallest_root(a: f64, b: f64, c: f64) -> f64 {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    // c over the sum of like signs: no cancellation, and right also where a vanishes.
    let sum = -0.5 * (b + discriminant.sqrt().copysign(b));
    [sum / a, c / sum].into_iter().filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn z(x: f64, y: f64) -> Complex<f64> {
        Complex::new(x, y)
    }

    fn face() -> Face {
        Face::new([0, 1, 2], [z(0.1, 0.2), z(1.3, 0.1), z(0.4, 0.9)], 0.7)
    }

    /// Stretched, sheared and turned; nearly isometric; shrunk, where turning has a negative eigenvalue.
    fn images() -> Vec<[Complex<f64>; 3]> {
        vec![
            [z(0.0, 0.0), z(0.5, 1.7), z(-0.9, 0.3)],
            [z(0.1, 0.2), z(1.3, 0.1), z(0.4, 0.9001)],
            [z(0.0, 0.0), z(0.3, 0.1), z(0.1, 0.2)],
        ]
    }

    #[test]
    fn a_turned_copy_costs_nothing() {
        let turn = Complex::from_polar(1.0, 2.0);
        let x = [z(0.1, 0.2), z(1.3, 0.1), z(0.4, 0.9)].map(|p| p * turn + z(5.0, 1.0));
        for distortion in [Distortion::SymmetricDirichlet, Distortion::Arap] {
            assert!(face().energy(distortion, &x) < 1e-28);
            let mut gradient = [Complex::default(); 3];
            face().derivatives(distortion, &x, false, &mut gradient);
            assert!(gradient.iter().all(|g| g.norm() < 1e-13));
        }
        let mirrored = x.map(|p| p.conj());
        assert!(face().energy(Distortion::SymmetricDirichlet, &mirrored).is_infinite());
    }

    #[test]
    fn gradient_and_hessian_are_those_of_central_differences() {
        let step = 1e-5;
        for distortion in [Distortion::SymmetricDirichlet, Distortion::Arap] {
            for x in images() {
                let mut gradient = [Complex::default(); 3];
                let hessian = face().derivatives(distortion, &x, false, &mut gradient);
                let largest = hessian.iter().flatten().fold(0.0, |m: f64, h| m.max(h.abs()));
                for r in 0..6 {
                    let moved = |step: f64| {
                        let mut x = x;
                        x[r / 2] += if r % 2 == 0 { z(step, 0.0) } else { z(0.0, step) };
                        let mut g = [Complex::default(); 3];
                        face().derivatives(distortion, &x, false, &mut g);
                        (face().energy(distortion, &x), g)
                    };
                    let (ahead, behind) = (moved(step), moved(-step));
                    let own = if r % 2 == 0 { gradient[r / 2].re } else { gradient[r / 2].im };
                    let slope = (ahead.0 - behind.0) / (2.0 * step);
                    // Third derivatives times step², against second derivatives.
                    assert!((slope - own).abs() < 1e-7 * largest, "{distortion:?} {slope} {own}");
                    for c in 0..6 {
                        let change = (ahead.1[c / 2] - behind.1[c / 2]) / (2.0 * step);
                        let change = if c % 2 == 0 { change.re } else { change.im };
                        let error = (change - hessian[r][c]).abs();
                        assert!(error < 1e-6 * largest, "{r} {c}: {change} {}", hessian[r][c]);
                    }
                }
            }
        }
    }

    #[test]
    fn the_convex_hessian_lies_above_and_is_never_negative() {
        for distortion in [Distortion::SymmetricDirichlet, Distortion::Arap] {
            for x in images() {
                let mut g = [Complex::default(); 3];
                let exact = face().derivatives(distortion, &x, false, &mut g);
                let convex = face().derivatives(distortion, &x, true, &mut g);
                let to_matrix = |h: [[f64; 6]; 6]| nalgebra::Matrix6::from_fn(|r, c| h[r][c]);
                let (exact, convex) = (to_matrix(exact), to_matrix(convex));
                let low = |m: nalgebra::Matrix6<f64>| m.symmetric_eigenvalues().min();
                let slack = 1e-12 * convex.norm();
                assert!(low(convex) > -slack && low(convex - exact) > -slack);
            }
            // The shrunk image is where the two differ.
            let mut g = [Complex::default(); 3];
            let exact = face().derivatives(distortion, &images()[2], false, &mut g);
            let m = nalgebra::Matrix6::from_fn(|r, c| exact[r][c]);
            assert!(m.symmetric_eigenvalues().min() < -1e-3 * m.norm());
        }
    }

    #[test]
    fn the_largest_step_ends_where_the_area_does() {
        for x in images() {
            for seed in 0..20 {
                let noise = |k: u32| f64::from((seed * 7919 + k * 104_729) % 1013) / 506.0 - 1.0;
                let d = [0, 1, 2].map(|k| z(noise(2 * k), noise(2 * k + 1)));
                let area = |s: f64| {
                    let [a, b, c] = [0, 1, 2].map(|i| x[i] + d[i] * s);
                    ((b - a).conj() * (c - a)).im
                };
                let s = largest_step([0, 1, 2], &x, &d);
                let until = s.min(1e3);
                assert!((1..100).all(|i| area(until * f64::from(i) / 100.0) > 0.0));
                assert!(s.is_infinite() || area(s).abs() < 1e-9 * (1.0 + s * s));
            }
        }
        // A translation, and a shrinking that ends in a point.
        assert!(smallest_root(0.0, 0.0, 1.0).is_infinite());
        assert!((smallest_root(1.0, -2.0, 1.0) - 1.0).abs() < 1e-7);
        assert!((smallest_root(0.0, -4.0, 1.0) - 0.25).abs() < 1e-15);
    }
}
