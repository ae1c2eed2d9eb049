//! Numbers of text files, correctly rounded and fast; and words of files as people may see them.
//!
//! Guaranteed: [`parse`] gives the double nearest to the decimal number, as `str::parse` does. Not guaranteed: anything
//! about numbers in other forms (hexadecimal, decimal commas, Fortran's `1d5`): they are no numbers.

use super::ReadFault;

/// Coordinates beyond this become infinite on the way to the graphics card.
pub(super) const LARGEST: f64 = f32::MAX as f64;

/// The powers of ten that are doubles.
const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// The double nearest to a decimal number; infinite or NaN where the word says so; `None` where it is no number.
///
/// Most numbers in files are a whole number below 2⁵³ times or over a power of ten up to 10²²: both are doubles, so that one
/// multiplication or division rounds correctly. The rest goes to the standard library.
pub(super) fn parse(word: &[u8]) -> Option<f64> {
    match parse_exactly(word) {
        Some(x) => Some(x),
        None => std::str::from_utf8(word).ok()?.parse().ok(),
    }
}

/// [`parse`] for the numbers that one rounding can make.
fn parse_exactly(word: &[u8]) -> Option<f64> {
    let (is_negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    // More bytes could overflow the mantissa before it is looked at.
    if digits.len() > 24 {
        return None;
    }
    let mut mantissa = 0u64;
    let mut digit_count = 0;
    let mut after_point = None;
    let mut exponent = 0i32;
    for (i, &b) in digits.iter().enumerate() {
        let digit = b.wrapping_sub(b'0');
        if digit <= 9 {
            digit_count += 1;
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        } else if b == b'.' && after_point.is_none() {
            after_point = Some(digit_count);
        } else if matches!(b, b'e' | b'E') {
            exponent = small_exponent(&digits[i + 1..])?;
            break;
        } else {
            return None;
        }
    }
    // Nineteen digits always fit 64 bits.
    if digit_count == 0 || digit_count > 19 || mantissa > 1 << 53 {
        return None;
    }
    let power = exponent - after_point.map_or(0, |before| digit_count - before);
    let factor = *POWERS_OF_TEN.get(power.unsigned_abs() as usize)?;
    let x = mantissa as f64;
    let x = if power < 0 { x / factor } else { x * factor };
    Some(if is_negative { -x } else { x })
}

/// An exponent of at most three digits.
fn small_exponent(text: &[u8]) -> Option<i32> {
    let (sign, digits) = match text {
        [b'-', digits @ ..] => (-1, digits),
        [b'+', digits @ ..] => (1, digits),
        digits => (1, digits),
    };
    if digits.is_empty() || digits.len() > 3 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(sign * digits.iter().fold(0, |sum, &b| 10 * sum + i32::from(b - b'0')))
}

/// A coordinate of a text file.
pub(super) fn coordinate(word: &[u8]) -> Result<f64, ReadFault> {
    match parse(word) {
        Some(x) if x.abs() <= LARGEST => Ok(x),
        Some(x) if x.is_finite() => Err(ReadFault::TooLarge { text: quote(word) }),
        Some(_) => Err(ReadFault::NotFinite { text: quote(word) }),
        // Old Microsoft libraries write `1.#INF` and `-1.#IND`.
        None if word.windows(2).any(|pair| pair == b".#") => {
            Err(ReadFault::NotFinite { text: quote(word) })
        }
        None => Err(ReadFault::NotANumber { text: quote(word) }),
    }
}

/// The next words as coordinates, if there are so many and all are such.
pub(super) fn numbers<'a, const N: usize>(
    mut words: impl Iterator<Item = &'a [u8]>,
) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for x in &mut numbers {
        *x = coordinate(words.next()?).ok()?;
    }
    Some(numbers)
}

/// A coordinate of a binary file.
pub(super) fn finite(x: f64) -> Result<f64, ReadFault> {
    if x.abs() <= LARGEST {
        Ok(x)
    } else if x.is_finite() {
        Err(ReadFault::TooLarge { text: format!("{x:e}") })
    } else {
        Err(ReadFault::NotFinite { text: x.to_string() })
    }
}

/// A whole number without sign, saturated; `None` where the word is none.
pub(super) fn whole(word: &[u8]) -> Option<u64> {
    if word.is_empty() {
        return None;
    }
    let mut value = 0u64;
    for digit in word {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value.saturating_mul(10).saturating_add(u64::from(digit));
    }
    Some(value)
}

/// A word of the file that can be shown: printable and short.
pub(super) fn quote(word: &[u8]) -> String {
    shorten(word, 40)
}

/// A name of a group or a material: printable, and short enough for a list.
pub(super) fn name(word: &[u8]) -> String {
    shorten(word, 120)
}

fn shorten(word: &[u8], longest: usize) -> String {
    let start = &word[..word.len().min(4 * longest)];
    let mut text = String::new();
    for (i, c) in String::from_utf8_lossy(start).chars().enumerate() {
        if i == longest {
            text.push('…');
            break;
        }
        text.push(if c.is_control() { char::REPLACEMENT_CHARACTER } else { c });
    }
    text
}

#[cfg(test)]
#[expect(clippy::cast_possible_truncation, reason = "random numbers, cut to size")]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_standard_library_bit_by_bit() {
        let words = [
            "0",
            "-0",
            "+0.0",
            "1.",
            ".5",
            "-.5e1",
            "0.1",
            "9007199254740993",
            "9007199254740992",
            "1e22",
            "1e23",
            "1e-22",
            "123456789012345678901234567890",
            "0.30000000000000004",
            "1.7976931348623157e308",
            "4.9e-324",
            "1e400",
            "nan",
            "-inf",
            "Infinity",
            "1e+5",
            "1E5",
            "00000000000000000000000.5",
            "0.000000000000000000001",
            "1e0022",
            "18446744073709551616.",
            "99999999999999999999",
            "9999999999999999999",
            "0.12345678901234567",
        ];
        for word in words {
            let expected: f64 = word.parse().unwrap();
            let x = parse(word.as_bytes()).unwrap();
            assert!(x.to_bits() == expected.to_bits() || x.is_nan() && expected.is_nan(), "{word}");
        }
        let not_numbers = [
            "", ".", "-", "+", "e5", ".e5", "1e", "1e+", "1.2.3", "--1", "1_0", "0x10", "1,5",
            "1d5",
        ];
        for word in not_numbers {
            assert_eq!(parse(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn random_decimals_are_read_as_the_standard_library_reads_them() {
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 16
        };
        for _ in 0..100_000 {
            let digits = (random() << 20 ^ random()) % 10u64.pow((random() % 19) as u32 + 1);
            let mut text = digits.to_string();
            if random() % 4 > 0 {
                text.insert((random() as usize) % (text.len() + 1), '.');
            }
            if random() % 3 == 0 {
                text += &format!("e{}", random() as i64 % 30 - 15);
            }
            let expected: Option<f64> = text.parse().ok();
            assert_eq!(
                parse(text.as_bytes()).map(f64::to_bits),
                expected.map(f64::to_bits),
                "{text}"
            );
        }
    }
}
