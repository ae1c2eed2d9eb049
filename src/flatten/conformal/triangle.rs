//! A triangle given by the logarithms of its sides, evaluated without loss of digits.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, SQRT_2};

use super::lobachevsky::lobachevsky;
use crate::linalg::widely;

/// Angles and cotangents of a triangle; entry `i` is at the corner opposite side `i`. Where the triangle inequality fails, π lies
/// opposite the longest side, and the other angles and all cotangents are 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub angles: [f64; 3],
    pub cotangents: [f64; 3],
}

impl Triangle {
    /// The triangle with these logarithms of side lengths. NaN goes in and out.
    pub fn new(x: [f64; 3]) -> Self {
        let largest = x[0].max(x[1]).max(x[2]);
        Self::of_lengths(x.map(|x| (x - largest).exp()))
    }

    /// The triangle with these side lengths, finite and positive; what is none of these comes out as NaN.
    pub fn of_lengths(lengths: [f64; 3]) -> Self {
        let mut triangle = Self::of_half_tangents(lengths);
        twice_arctangents(&mut triangle.angles);
        triangle
    }

    /// The same with the tangents of half the angles in place of the angles: many are turned into angles at once.
    ///
    /// tan of half the angle opposite side e is √(g₀ g₁ g₂ / s) / (s − e), g the differences s − e of the semiperimeter,
    /// with Kahan's parentheses.
    #[inline]
    pub fn of_half_tangents(lengths: [f64; 3]) -> Self {
        let [a, b, c] = lengths;
        // Shapes have no size: products of lengths stay within the range of numbers.
        let unit = 1.0 / a.max(b).max(c);
        let [a, b, c] = [a * unit, b * unit, c * unit];
        let high = a.max(b).max(c);
        let low = a.min(b).min(c);
        let middle = a.min(b).max(a.max(b).min(c));
        let s = 0.5 * (high + (middle + low));
        // Minima and maxima pass over what is no number; sums do not.
        if !(a + b + c <= 3.0) {
            return Self { angles: [f64::NAN; 3], cotangents: [f64::NAN; 3] };
        }
        let g = [
            0.5 * (low - (high - middle)),
            0.5 * (low + (high - middle)),
            0.5 * (high + (middle - low)),
        ];
        let mut triangle = Self { angles: [0.0; 3], cotangents: [0.0; 3] };
        if g[0] <= 0.0 {
            triangle.angles[if a >= high {
                0
            } else if b >= high {
                1
            } else {
                2
            }] = f64::INFINITY;
            return triangle;
        }
        let radius = (g[0] * g[1] * g[2] / s).sqrt();
        let inverse = 1.0 / radius;
        // All three by themselves: the rest of π, whose f64 is too small, would make sums of thousands drift.
        let tangents = g.map(|g| radius / g);
        // (1 − t²) / 2t, with 1/t at hand: divisions are what this costs.
        let cotangents = [0, 1, 2].map(|i| 0.5 * (g[i] * inverse - tangents[i]));
        // No sorting: sides of one length have one angle.
        for (i, side) in [a, b, c].into_iter().enumerate() {
            let rank = if side >= high {
                0
            } else if side <= low {
                2
            } else {
                1
            };
            triangle.angles[i] = tangents[rank];
            triangle.cotangents[i] = cotangents[rank];
        }
        triangle
    }
}

/// 2 arctan t for numbers t ≥ 0, ∞ included, in place: within two units in the last place, and not biased.
///
/// The library's function is called for one number after the other, and takes half of an evaluation; here several are computed side by
/// side. Like it, NaN goes in and out. Beyond tan π/8 and tan 3π/8 by arctan t = π/4 + arctan (t − 1) / (t + 1) = π/2 − arctan 1/t.
pub(super) fn twice_arctangents(values: &mut [f64]) {
    /// (arctan x / x − 1) / x² by powers of x² up to tan² π/8, interpolated at Chebyshev points: 5e-18 of arctan x / x at most.
    const SERIES: [f64; 11] = [
        -0.333_333_333_333_333_3,
        0.199_999_999_999_955_16,
        -0.142_857_142_846_656_82,
        0.111_111_110_151_870_18,
        -0.090_909_045_753_062_9,
        0.076_921_831_253_768_92,
        -0.066_645_105_255_089_36,
        0.058_581_409_048_663_28,
        -0.050_854_078_345_894_844,
        0.039_230_447_784_793_09,
        -0.019_175_404_711_104_935,
    ];
    /// π/2 and π/4 less their f64.
    const RESTS: [f64; 2] = [6.123_233_995_736_766e-17, 3.061_616_997_868_383e-17];
    let turn = |t: f64| {
        let (is_steep, is_flat) = (t > 1.0 + SQRT_2, t <= SQRT_2 - 1.0);
        let above = if is_steep { -1.0 } else { t - 1.0 };
        let below = if is_steep { t } else { t + 1.0 };
        let (above, below) = if is_flat { (t, 1.0) } else { (above, below) };
        let [base, rest] = if is_steep { [FRAC_PI_2, RESTS[0]] } else { [FRAC_PI_4, RESTS[1]] };
        let [base, rest] = if is_flat { [0.0; 2] } else { [base, rest] };
        let x = above / below;
        let square = x * x;
        let sum = SERIES.iter().rev().fold(0.0, |sum, c| sum * square + c);
        2.0 * (base + (x + (x * square * sum + rest)))
    };
    widely(
        #[inline(always)]
        || values.iter_mut().for_each(|t| *t = turn(*t)),
    );
}

/// A triangle's share of the energy by its angles and log sides: 2 Σ (θ x + Л(θ)) − π Σ x, linear where the triangle is degenerate.
pub(super) fn face_energy(angles: [f64; 3], x: [f64; 3]) -> f64 {
    let turns: f64 = (0..3).map(|i| (2.0 * angles[i] - PI) * x[i]).sum();
    turns + 2.0 * lobachevsky(angles).iter().sum::<f64>()
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
        assert_eq!(cap.angles.map(f64::to_bits), [0.0, 0.0, PI].map(f64::to_bits));
    }

    #[test]
    fn arctangents_are_those_of_the_library() {
        let mut values: Vec<f64> = (-4000..4000).map(|k| (0.01 * f64::from(k)).exp()).collect();
        values.extend([0.0, 1e-300, SQRT_2 - 1.0, 1.0, 1.0 + SQRT_2, f64::INFINITY]);
        let expected: Vec<f64> = values.iter().map(|t| 2.0 * t.atan()).collect();
        twice_arctangents(&mut values);
        let error = |(a, b): (&f64, &f64)| (a - b) / b.max(f64::MIN_POSITIVE);
        let errors: Vec<f64> = values.iter().zip(&expected).map(error).collect();
        assert!(errors.iter().all(|e| e.abs() <= 6e-16));
        // A bias would add up over a surface.
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(mean.abs() < 3e-18, "{mean}");
        assert_eq!(values.last(), Some(&PI));
    }

    #[test]
    fn the_energy_of_a_triangle_has_the_slope_of_its_angles() {
        let h = 1e-6;
        for x in [[0.1, -0.3, 0.2], [0.0, 0.0, -3.0], [0.0, 0.0, 1.0], [2.0, 1.9, 2.4]] {
            let at = |x| face_energy(Triangle::new(x).angles, x);
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
