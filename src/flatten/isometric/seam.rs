//! Seam partners: the difference of their lengths, its gradient and Hessian.
//!
//! Of partners with lengths a and b in their charts and l on the surface, e = (a − b) / l. Each costs c e² + μ e: a spring, and the multiplier
//! that in the end takes over what the spring alone would only reach at infinite stiffness.

use nalgebra::Complex;

/// Two sides of charts that are sewn together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seam {
    /// Tail and tip of either side.
    pub ends: [u32; 4],
    pub length: f64,
    /// c, before the flow's stiffness.
    pub weight: f64,
}

impl Seam {
    fn lengths(&self, x: &[Complex<f64>]) -> [f64; 2] {
        let [a, b, c, d] = self.ends.map(|v| x[v as usize]);
        [(b - a).norm(), (d - c).norm()]
    }

    /// e.
    pub fn difference(&self, x: &[Complex<f64>]) -> f64 {
        let [a, b] = self.lengths(x);
        (a - b) / self.length
    }

    /// |a − b| / ½ (a + b), what tailors measure.
    pub fn relative_difference(&self, x: &[Complex<f64>]) -> f64 {
        let [a, b] = self.lengths(x);
        let sum = a + b;
        if sum > 0.0 { 2.0 * (a - b).abs() / sum } else { 0.0 }
    }

    /// Adds the gradient, and gives the Hessian: row 2 i + c is coordinate c of end i.
    ///
    /// **Takes** c and μ, and whether the Hessian is to be positive semi-definite: then sides under pressure lose the curvature that would let
    /// them turn away.
    pub fn derivatives(
        &self,
        x: &[Complex<f64>],
        [stiffness, multiplier]: [f64; 2],
        convex: bool,
        gradient: &mut [Complex<f64>],
    ) -> [[f64; 8]; 8] {
        let lengths = self.lengths(x);
        let slope = 2.0 * stiffness * self.difference(x) + multiplier;
        let mut d = [0.0; 8];
        let mut hessian = [[0.0; 8]; 8];
        for side in 0..2 {
            let [tail, tip] = [self.ends[2 * side], self.ends[2 * side + 1]];
            let length = lengths[side];
            // A side that has shrunk to a point has no direction to pull in.
            let unit = if length > 0.0 {
                (x[tip as usize] - x[tail as usize]) / length
            } else {
                Complex::default()
            };
            let pull = unit * if side == 0 { 1.0 / self.length } else { -1.0 / self.length };
            gradient[tip as usize] += pull * slope;
            gradient[tail as usize] -= pull * slope;
            let i = 4 * side;
            (d[i], d[i + 1], d[i + 2], d[i + 3]) = (-pull.re, -pull.im, pull.re, pull.im);
            // The second derivative of a length acts across the side.
            let tension = if side == 0 { slope } else { -slope } / self.length;
            let tension = if convex { tension.max(0.0) } else { tension };
            if length > 0.0 {
                let across = [-unit.im, unit.re];
                for r in 0..4 {
                    for c in 0..4 {
                        let sign = if (r < 2) == (c < 2) { 1.0 } else { -1.0 };
                        hessian[i + r][i + c] +=
                            sign * tension / length * across[r % 2] * across[c % 2];
                    }
                }
            }
        }
        for r in 0..8 {
            for c in 0..8 {
                hessian[r][c] += 2.0 * stiffness * d[r] * d[c];
            }
        }
        hessian
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradient_and_hessian_are_those_of_central_differences() {
        let seam = Seam { ends: [0, 1, 2, 3], length: 0.8, weight: 1.0 };
        let places = [[0.0, 0.1], [0.9, 0.4], [2.0, -0.3], [1.6, 0.2]];
        let x = places.map(|[x, y]| Complex::new(x, y));
        let parts = [3.0, 0.7];
        let energy = |x: &[Complex<f64>]| {
            let e = seam.difference(x);
            parts[0] * e * e + parts[1] * e
        };
        let mut gradient = [Complex::default(); 4];
        let hessian = seam.derivatives(&x, parts, false, &mut gradient);
        let convex = seam.derivatives(&x, parts, true, &mut [Complex::default(); 4]);
        let step = 1e-5;
        for r in 0..8 {
            let moved = |step: f64| {
                let mut x = x;
                let d = if r % 2 == 0 { Complex::new(step, 0.0) } else { Complex::new(0.0, step) };
                x[r / 2] += d;
                let mut g = [Complex::default(); 4];
                seam.derivatives(&x, parts, false, &mut g);
                (energy(&x), g)
            };
            let (ahead, behind) = (moved(step), moved(-step));
            let own = if r % 2 == 0 { gradient[r / 2].re } else { gradient[r / 2].im };
            // Third derivatives of about 10 times step².
            assert!(((ahead.0 - behind.0) / (2.0 * step) - own).abs() < 1e-7);
            for c in 0..8 {
                let change = (ahead.1[c / 2] - behind.1[c / 2]) / (2.0 * step);
                let change = if c % 2 == 0 { change.re } else { change.im };
                assert!((change - hessian[r][c]).abs() < 1e-7, "{r} {c}");
            }
        }
        let low = nalgebra::SMatrix::<f64, 8, 8>::from_fn(|r, c| convex[r][c]);
        assert!(low.symmetric_eigenvalues().min() > -1e-12);
    }
}
