//! Helvetica as every reader of PDF has it: which characters, and how wide they are.

use super::super::stroke_font;

/// Height of capitals over the size of the font.
pub(super) const CAPITALS: f64 = 0.718;

/// Widths of ASCII from the space on, in thousandths of the size.
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// The byte of a character in WinAnsi, and its width.
fn letter(c: char) -> Option<(u8, u16)> {
    let byte = match c {
        ' '..='~' => return Some((c as u8, WIDTHS[c as usize - 32])),
        '\u{a0}'..='\u{ff}' => c as u8,
        '€' => 0x80,
        '…' => 0x85,
        'Š' => 0x8a,
        'Œ' => 0x8c,
        'Ž' => 0x8e,
        '‘' => 0x91,
        '’' => 0x92,
        '“' => 0x93,
        '”' => 0x94,
        '•' => 0x95,
        '–' => 0x96,
        '—' => 0x97,
        'š' => 0x9a,
        'œ' => 0x9c,
        'ž' => 0x9e,
        'Ÿ' => 0x9f,
        _ => return None,
    };
    let like = |c: char| WIDTHS[c as usize - 32];
    let width = match c {
        'À'..='Å' | 'Ÿ' | 'Ý' | 'Þ' => 667,
        'Æ' | 'Œ' | '—' | '…' => 1000,
        'Ç' | 'Ð' | 'Ñ' | 'Ù'..='Ü' => 722,
        'È'..='Ë' | 'Š' => 667,
        'Ì'..='Ï' | 'ì'..='ï' | '·' => 278,
        'Ò'..='Ö' | 'Ø' => 778,
        'Ž' | 'ß' | 'ø' => 611,
        'æ' => 889,
        'œ' => 944,
        'ç' | 'ý' | 'ÿ' | 'š' | 'ž' => 500,
        '×' | '÷' | '±' | '¬' => 584,
        '°' => 400,
        '²' | '³' | '¹' | '´' | '¨' | '¸' | '¯' | '\u{ad}' => 333,
        '½' | '¼' | '¾' => 834,
        '©' | '®' => 737,
        '‘' | '’' => 222,
        '“' | '”' => 333,
        '•' => 350,
        '¡' => 333,
        '¿' => 611,
        'ª' => 370,
        'º' => 365,
        '¦' => 260,
        '¶' => 537,
        'µ' => like('u'),
        _ => 556,
    };
    Some((byte, width))
}

/// A text in WinAnsi, if it can be written so.
pub(super) fn encode(text: &str) -> Option<Vec<u8>> {
    let shown = text.chars().filter(|c| !c.is_control());
    shown.map(|c| letter(c).map(|(byte, _)| byte)).collect()
}

/// Width of a text of that height of capitals, as it will be drawn: in Helvetica, or in strokes if it has other characters.
pub(super) fn width(text: &str, height: f64) -> f64 {
    let shown = || text.chars().filter(|c| !c.is_control());
    let sum: Option<f64> = shown().map(|c| letter(c).map(|(_, width)| f64::from(width))).sum();
    sum.map_or_else(|| stroke_font::width(text, height), |sum| sum / 1000.0 * height / CAPITALS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_outside_of_the_font_are_told() {
        assert_eq!(encode("Größe – ½ 50 mm × 3°").map(|b| b.len()), Some(20));
        assert_eq!(encode("€…\n"), Some(vec![0x80, 0x85]));
        assert_eq!(encode("Łódź"), None);
        assert!((width("AB", 0.718) - 1.334).abs() < 1e-12);
        assert!(width("Łódź", 5.0) > 5.0);
    }
}
