//! Pairs of code and value, two lines each.

use crate::pattern::number::millimetres;
use crate::pattern::transliterate::to_ascii;

/// Longest string of release 12.
const LONGEST: usize = 255;

/// A DXF file while it is written.
#[derive(Default)]
pub(super) struct Groups {
    out: String,
}

impl Groups {
    pub fn bytes(self) -> Vec<u8> {
        self.out.into_bytes()
    }

    pub fn word(&mut self, code: u16, value: &str) -> &mut Self {
        self.code(code);
        self.out += value;
        self.out += "\r\n";
        self
    }

    /// Right-aligned in three columns.
    fn code(&mut self, code: u16) {
        for (limit, digit) in [(100, 100), (10, 10), (0, 1)] {
            let digit = char::from_digit(u32::from(code / digit % 10), 10).unwrap_or('0');
            self.out.push(if code >= limit { digit } else { ' ' });
        }
        self.out += "\r\n";
    }

    /// A string of the user's, in ASCII.
    pub fn string(&mut self, code: u16, value: &str) -> &mut Self {
        let mut value = to_ascii(value);
        value.truncate(LONGEST);
        self.word(code, &value)
    }

    pub fn integer(&mut self, code: u16, value: usize) -> &mut Self {
        self.word(code, &value.to_string())
    }

    /// Fixed point, four decimals at most, one at least.
    pub fn number(&mut self, code: u16, value: f64) -> &mut Self {
        self.code(code);
        let from = self.out.len();
        millimetres(&mut self.out, value);
        if !self.out[from..].contains('.') {
            self.out += ".0";
        }
        self.out += "\r\n";
        self
    }

    /// A place, its codes from `code` in steps of ten, with height 0.
    pub fn place(&mut self, code: u16, [x, y]: [f64; 2]) -> &mut Self {
        self.number(code, x).number(code + 10, y).number(code + 20, 0.0)
    }

    pub fn open_section(&mut self, name: &str) {
        self.word(0, "SECTION").word(2, name);
    }

    pub fn close_section(&mut self) {
        self.word(0, "ENDSEC");
    }

    pub fn finish(&mut self) {
        self.word(0, "EOF");
    }

    pub fn polyline(&mut self, layer: &str, points: &[[f64; 2]], is_closed: bool) {
        self.word(0, "POLYLINE").word(8, layer).integer(66, 1).place(10, [0.0; 2]);
        self.integer(70, usize::from(is_closed));
        for &point in points {
            self.word(0, "VERTEX").word(8, layer).place(10, point);
        }
        self.word(0, "SEQEND").word(8, layer);
    }

    pub fn line(&mut self, layer: &str, [from, to]: [[f64; 2]; 2]) {
        self.word(0, "LINE").word(8, layer).place(10, from).place(11, to);
    }

    pub fn point(&mut self, layer: &str, at: [f64; 2]) {
        self.word(0, "POINT").word(8, layer).place(10, at);
    }

    /// A text whose baseline begins at a place.
    pub fn text(&mut self, layer: &str, at: [f64; 2], height: f64, words: &str) {
        self.word(0, "TEXT").word(8, layer).place(10, at).number(40, height).string(1, words);
    }

    pub fn open_block(&mut self, layer: &str, name: &str) {
        self.word(0, "BLOCK").word(8, layer).word(2, name).integer(70, 0);
        self.place(10, [0.0; 2]).word(3, name);
    }

    pub fn close_block(&mut self, layer: &str) {
        self.word(0, "ENDBLK").word(8, layer);
    }

    pub fn insert(&mut self, layer: &str, name: &str, at: [f64; 2]) {
        self.word(0, "INSERT").word(8, layer).word(2, name).place(10, at);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_fixed_point_with_one_decimal_at_least() {
        let mut groups = Groups::default();
        for x in [50.0, -0.000_01, 1.25, -3.5, 123_456.789_06, 1e-9, 0.100_04, 100.0] {
            groups.number(10, x);
        }
        let text = String::from_utf8(groups.bytes()).unwrap();
        let values: Vec<&str> = text.split("\r\n").skip(1).step_by(2).collect();
        let expected = ["50.0", "0.0", "1.25", "-3.5", "123456.7891", "0.0", "0.1", "100.0"];
        assert_eq!(values, expected);
        assert!(text.starts_with(" 10\r\n50.0\r\n"));
    }
}
