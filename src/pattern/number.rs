//! Numbers as text: a point for the decimals whatever the locale, never `NaN`.

/// Appends a number so that reading it gives the same bits.
pub(super) fn exact(out: &mut String, x: f64) {
    debug_assert!(x.is_finite());
    let size = x.abs();
    // The shortest digits that read back as x; all of them in full would be hundreds for extreme numbers.
    *out += &if size != 0.0 && !(1e-5..1e15).contains(&size) {
        format!("{x:e}")
    } else {
        format!("{x}")
    };
}

/// Appends a length in millimetres: at most four decimals, no trailing zeros, no −0.
pub(super) fn millimetres(out: &mut String, x: f64) {
    debug_assert!(x.is_finite());
    // In whole units of the last decimal, ten times as fast as the formatting of numbers; beyond 2⁵³ of them there are no
    // decimals.
    let units = (x.abs() * 1e4).round();
    if units >= 9e15 {
        *out += &format!("{x:.0}");
        return;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 2⁵³")]
    let units = units as u64;
    let (whole, mut part) = (units / 10_000, units % 10_000);
    if x < 0.0 && units > 0 {
        out.push('-');
    }
    let digit = |x: u64| char::from(b'0' + u8::try_from(x % 10).unwrap_or(0));
    let mut place = 1;
    while whole / place >= 10 {
        place *= 10;
    }
    while place > 0 {
        out.push(digit(whole / place));
        place /= 10;
    }
    let mut place = 1000;
    if part > 0 {
        out.push('.');
    }
    while part > 0 {
        out.push(digit(part / place));
        part %= place;
        place /= 10;
    }
}

/// A length in millimetres as [`millimetres`] writes it.
pub(super) fn millimetre_text(x: f64) -> String {
    let mut text = String::new();
    millimetres(&mut text, x);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_numbers_read_back_bit_for_bit() {
        let mut bits = 0x9e37_79b9_7f4a_7c15_u64;
        let mut numbers = vec![
            0.0,
            -0.0,
            1.0,
            -2.5,
            0.1,
            f64::MIN_POSITIVE,
            5e-324,
            f64::MAX,
            1e15,
            1e-5,
            123456.789,
        ];
        for _ in 0..10_000 {
            bits = bits
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            numbers.push(f64::from_bits(bits));
        }
        for x in numbers.into_iter().filter(|x| x.is_finite()) {
            let mut text = String::new();
            exact(&mut text, x);
            assert_eq!(text.parse::<f64>().unwrap().to_bits(), x.to_bits(), "{text}");
            assert!(text.len() < 26, "{text}");
        }
    }

    #[test]
    fn millimetres_are_short() {
        let cases = [
            (0.0, "0"),
            (-0.00001, "0"),
            (50.0, "50"),
            (1.25, "1.25"),
            (0.00016, "0.0002"),
            (-3.5, "-3.5"),
            (100.0, "100"),
            (-1_234_567.890_12, "-1234567.8901"),
            (9.999_96, "10"),
            (-0.05, "-0.05"),
            (1e20, "100000000000000000000"),
        ];
        for (x, text) in cases {
            assert_eq!(millimetre_text(x), text);
        }
    }
}
