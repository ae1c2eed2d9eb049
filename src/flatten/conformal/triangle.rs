//! A triangle given by the logarithms of its sides, evaluated without loss of digits.

use std::f64::consts::PI;

use super::lobachevsky::lobachevsky;

/// Angles and cotangents of a triangle; entry `i` is at the corner opposite side `i`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub angles: [f64; 3],
    pub cotangents: [f64; 3],
    /// Whether the triangle inequality fails: then π lies opposite the longest side, and cotangents are 0.
    pub is_degenerate: bool,
}

impl Triangle {
    /// The triangle with these logarithms of side lengths.
    ///
    /// tan of half the angle opposite side e is √(g₀ g₁ g₂ / s) / (s − e), g the differences s − e of the semiperimeter,
    /// with Kahan's parentheses. NaN goes in and out.
    pub fn new(x: [f64; 3]) -> Self {
        let largest = x[0].max(x[1]).max(x[2]);
        let lengths = x.map(|x| (x - largest).exp());
        let mut order = [0, 1, 2];
        order.sort_unstable_by(|&a, &b| lengths[b].total_cmp(&lengths[a]));
        let [high, middle, low] = order.map(|i| lengths[i]);
        let s = 0.5 * (high + (middle + low));
        let g = [
            0.5 * (low - (high - middle)),
            0.5 * (low + (high - middle)),
            0.5 * (high + (middle - low)),
        ];
        let mut triangle =
            Self { angles: [0.0; 3], cotangents: [0.0; 3], is_degenerate: g[0] <= 0.0 };
        if triangle.is_degenerate {
            triangle.angles[order[0]] = PI;
            return triangle;
        }
        let radius = (g[0] * g[1] * g[2] / s).sqrt();
        for (i, g) in order.into_iter().zip(g) {
            let tangent = radius / g;
            triangle.angles[i] = 2.0 * tangent.atan();
            triangle.cotangents[i] = (1.0 - tangent) * (1.0 + tangent) / (2.0 * tangent);
        }
        triangle
    }

    /// The triangle's share of the energy: 2 Σ (θ x + Л(θ)) − π Σ x, linear where the triangle is degenerate.
    pub fn energy(&self, x: [f64; 3]) -> f64 {
        let volume: f64 = match self.is_degenerate {
            true => 0.0,
            false => self.angles.iter().map(|&t| lobachevsky(t)).sum(),
        };
        let turns: f64 = (0..3).map(|i| (2.0 * self.angles[i] - PI) * x[i]).sum();
        turns + 2.0 * volume
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_regular_and_thin_triangles_have_their_angles() {
        let of = |sides: [f64; 3]| Triangle::new(sides.map(f64::ln));
        let right = of([3.0, 4.0, 5.0]);
        assert!((right.angles[2] - 0.5 * PI).abs() < 1e-15 && right.cotangents[2].abs() < 1e-15);
        assert!((right.cotangents[0] - 4.0 / 3.0).abs() < 1e-15);
        let regular = of([7.0; 3]);
        assert!(regular.angles.iter().all(|a| (a - PI / 3.0).abs() < 1e-15));
        // Isosceles with a tip of 1e-9 radians: chord 2 sin ½t.
        let needle = of([1.0, 1.0, 1e-9]);
        assert!((needle.angles[2] / 1e-9 - 1.0).abs() < 1e-14);
        assert!((needle.cotangents[2] * 1e-9 - 1.0).abs() < 1e-14);
        let cap = of([1.0, 1.0, 2.5]);
        assert!(cap.is_degenerate);
        assert_eq!(cap.angles.map(f64::to_bits), [0.0, 0.0, PI].map(f64::to_bits));
    }

    #[test]
    fn the_energy_of_a_triangle_has_the_slope_of_its_angles() {
        let h = 1e-6;
        for x in [[0.1, -0.3, 0.2], [0.0, 0.0, -3.0], [0.0, 0.0, 1.0], [2.0, 1.9, 2.4]] {
            let at = |x| Triangle::new(x).energy(x);
            for i in 0..3 {
                let (mut above, mut below) = (x, x);
                above[i] += h;
                below[i] -= h;
                let slope = (at(above) - at(below)) / (2.0 * h);
                let expected = 2.0 * Triangle::new(x).angles[i] - PI;
                // Central differences: h² and rounding over h.
                assert!((slope - expected).abs() < 1e-8, "{x:?} {i}: {slope} {expected}");
            }
        }
    }
}
