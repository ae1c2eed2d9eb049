//! One triangle, told by its side lengths: side `i` runs from corner `i` to corner `i + 1`, so it faces corner `i + 2`.

/// Area by Kahan's ordering of Heron's formula, accurate for slivers too; 0 where the triangle inequality fails.
///
/// ```
/// # use cutflow::geometry::triangle;
/// assert_eq!(triangle::area([3.0, 4.0, 5.0]), 6.0);
/// assert_eq!(triangle::area([1.0, 1.0, 3.0]), 0.0);
/// ```
pub fn area(sides: [f64; 3]) -> f64 {
    let [mut a, mut b, mut c] = sides;
    if a < b {
        std::mem::swap(&mut a, &mut b);
    }
    if b < c {
        std::mem::swap(&mut b, &mut c);
    }
    if a < b {
        std::mem::swap(&mut a, &mut b);
    }
    let product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
    0.25 * product.max(0.0).sqrt()
}

/// Angles at the three corners, radians, from half-angle tangents: accurate where a cosine is not. Where the triangle
/// inequality fails the angle that faces the too long side is π.
pub fn angles(sides: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = sides;
    let s = [(b + (c - a)).max(0.0), (c + (a - b)).max(0.0), (a + (b - c)).max(0.0)];
    let sum = a + b + c;
    // tan²(angle / 2) facing side i = s_j s_k / (sum s_i).
    let facing =
        |i: usize| 2.0 * (s[(i + 1) % 3] * s[(i + 2) % 3]).sqrt().atan2((sum * s[i]).sqrt());
    [facing(1), facing(2), facing(0)]
}

/// Cotangents of the angles at the three corners: (l_j² + l_k² − l_i²) / (4 area), side `i` facing the corner.
pub fn cotangents(sides: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = sides;
    let quarter = 1.0 / (4.0 * area(sides));
    // Differences of squares as products keep digits when two sides nearly agree.
    let facing = |l: f64, m: f64, n: f64| ((m - l) * (m + l) + n * n) * quarter;
    [facing(b, c, a), facing(c, a, b), facing(a, b, c)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_sum_to_half_a_turn_and_agree_with_cotangents_for_slivers_too() {
        for sides in [[1.0, 1.0, 1.0], [3.0, 5.0, 4.0], [1.0, 1.0, 1e-6], [1.0, 1.0, 1.999_999]] {
            let angles = angles(sides);
            // Rounding of three atan2.
            assert!((angles.iter().sum::<f64>() - std::f64::consts::PI).abs() < 1e-14);
            for (angle, cot) in angles.iter().zip(cotangents(sides)) {
                assert!((1.0 / angle.tan() - cot).abs() <= 1e-9 * (1.0 + cot.abs()), "{sides:?}");
            }
        }
        let right = angles([3.0, 4.0, 5.0]);
        assert!((right[1] - std::f64::consts::FRAC_PI_2).abs() < 1e-15, "corner 1 faces side 2");
    }
}
