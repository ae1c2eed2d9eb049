//! A font of single strokes: text as lines that a pen, a laser or a knife can follow.
//!
//! Fonts differ from machine to machine, and the outlines of letters cost a laser twice the way. The glyphs here are lines and
//! quarters of ellipses; letters that the font lacks are written by those that stand for them (ä as ae), anything
//! else as an empty box.

mod glyphs;

use std::f64::consts::FRAC_PI_2;

use super::transliterate::ascii;

/// Height of capitals in the units of the glyphs.
const CAPITAL: f64 = 9.0;
/// The glyphs are drawn wide; this brings a text to about 0.7 of its height per character.
const NARROW: f64 = 0.86;
/// Between two characters.
const SPACE: f64 = 2.2;
/// Chords per quarter of an ellipse: off by 0.9 % of the radius, 0.02 mm in letters of 5 mm.
const CHORDS: u32 = 6;

/// Width and strokes of the glyphs of a text.
fn glyphs(text: &str) -> Vec<(f64, &'static str)> {
    let mut out = Vec::with_capacity(text.len());
    let plain = |b: u8| glyphs::ASCII[usize::from(b - b' ')];
    for c in text.chars() {
        if let ' '..='~' = c {
            out.push(glyphs::ASCII[c as usize - 32]);
        } else if let Some(&(_, width, strokes)) = glyphs::MORE.iter().find(|row| row.0 == c) {
            out.push((width, strokes));
        } else if let Some(letters) = ascii(c) {
            out.extend(letters.bytes().map(plain));
        } else if !c.is_control() {
            out.push(glyphs::MISSING);
        }
    }
    out
}

/// Width of a text whose capitals are `height` high.
pub fn width(text: &str, height: f64) -> f64 {
    let glyphs = glyphs(text);
    let own: f64 = glyphs.iter().map(|glyph| glyph.0).sum();
    let gaps = SPACE * glyphs.len().saturating_sub(1) as f64;
    (own + gaps) * NARROW * height / CAPITAL
}

/// The strokes of a text, upright.
///
/// **Takes** the text, the middle of it or of its left end (half way up the capitals), the height of capitals, and which
/// of the two `at` is. **Gives** polylines of two points or more; round strokes are chords, off by no more than 0.4 % of the
/// height.
pub fn strokes(text: &str, at: [f64; 2], height: f64, is_left: bool) -> Vec<Vec<[f64; 2]>> {
    let scale = height / CAPITAL;
    let left = if is_left { at[0] } else { at[0] - 0.5 * width(text, height) };
    let base = at[1] - 0.5 * height;
    let mut out = Vec::new();
    let mut x = 0.0;
    for (advance, strokes) in glyphs(text) {
        for stroke in strokes.split(';').filter(|stroke| !stroke.is_empty()) {
            let points = flatten(stroke).into_iter();
            let place = |[px, py]: [f64; 2]| [left + (x + px) * NARROW * scale, base + py * scale];
            out.push(points.map(place).collect());
        }
        x += advance + SPACE;
    }
    out
}

/// One stroke in the units of the glyphs.
fn flatten(stroke: &str) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut arc = None;
    for token in stroke.split_whitespace() {
        let Some((x, y)) = token.split_once(',') else {
            arc = Some(token == "h");
            continue;
        };
        let (Ok(x), Ok(y)) = (x.parse::<f64>(), y.parse::<f64>()) else { continue };
        if let (Some(is_horizontal), Some(&[px, py])) = (arc.take(), points.last()) {
            for k in 1..CHORDS {
                let (sin, cos) = (FRAC_PI_2 * f64::from(k) / f64::from(CHORDS)).sin_cos();
                let (along, across) = (sin, 1.0 - cos);
                let [s, t] = if is_horizontal { [along, across] } else { [across, along] };
                points.push([px + s * (x - px), py + t * (y - py)]);
            }
        }
        points.push([x, y]);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_glyph_is_strokes_within_its_box() {
        let all = (b' '..=b'~').map(char::from).chain(['×', '°', '±', '·', '–']);
        for c in all {
            let (width, drawing) = glyphs(&c.to_string())[0];
            assert_eq!(drawing.is_empty(), c == ' ');
            // All that stands in the table is a point or an arc between two points.
            for stroke in drawing.split(';').filter(|s| !s.is_empty()) {
                let tokens: Vec<&str> = stroke.split_whitespace().collect();
                let points = tokens.iter().filter(|t| t.contains(',')).count();
                let is_point =
                    |t: &str| t.split(',').filter(|n| n.parse::<f64>().is_ok()).count() == 2;
                assert!(tokens.iter().all(|t| is_point(t) || matches!(*t, "h" | "v")), "{c}");
                assert!(points >= 2 && is_point(tokens[0]) && is_point(tokens[tokens.len() - 1]));
                assert!(tokens.windows(2).all(|w| is_point(w[0]) || is_point(w[1])), "{c}");
                for [x, y] in flatten(stroke) {
                    assert!(
                        (0.0..=width).contains(&x) && (-3.0..=10.0).contains(&y),
                        "{c} {x} {y}"
                    );
                }
                assert!(
                    flatten(stroke)
                        .windows(2)
                        .all(|w| (w[0][0] - w[1][0]).hypot(w[0][1] - w[1][1]) > 1e-3),
                    "{c}"
                );
            }
        }
    }

    #[test]
    fn glyphs_differ_from_one_another() {
        let mut drawings: Vec<&str> = glyphs::ASCII.iter().map(|g| g.1).collect();
        drawings.sort_unstable();
        assert!(drawings.windows(2).all(|w| w[0] != w[1]));
    }

    #[test]
    fn text_stands_where_it_is_asked_to() {
        let lines = strokes("HxH", [100.0, 50.0], 9.0, false);
        let all = || lines.iter().flatten();
        let low = all().map(|p| p[0]).fold(f64::INFINITY, f64::min);
        let high = all().map(|p| p[0]).fold(f64::NEG_INFINITY, f64::max);
        // Rounding of sums about 100.
        assert!((low + high - 200.0).abs() < 1e-9 && (high - low - width("HxH", 9.0)).abs() < 1e-9);
        let top = all().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max);
        let bottom = all().map(|p| p[1]).fold(f64::INFINITY, f64::min);
        assert!((top - 54.5).abs() < 1e-9 && (bottom - 45.5).abs() < 1e-9);
        let left = strokes("H", [100.0, 50.0], 9.0, true);
        assert!(left.iter().flatten().all(|p| p[0] >= 100.0));
    }

    #[test]
    fn letters_that_are_missing_are_written_by_others() {
        let at = [0.0; 2];
        assert_eq!(strokes("ä", at, 1.0, true), strokes("ae", at, 1.0, true));
        assert_eq!(strokes("模", at, 1.0, true).len(), 1);
        assert!(strokes("\u{1}\n", at, 1.0, true).is_empty());
        assert!(width("", 3.0).abs() < 1e-12);
    }
}
