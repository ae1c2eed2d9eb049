//! The contents of a page, in millimetres from its lower left corner.

use std::fmt::Write;

use super::super::number::millimetres;
use super::super::piece::Bounds;
use super::super::sheet::{Line, Text};
use super::super::{drawn::drawn, stroke_font};
use super::letters;

pub(super) type Rgb = [u8; 3];
pub(super) const BLACK: Rgb = [0; 3];
pub(super) const GREY: Rgb = [0x70, 0x76, 0x80];
pub(super) const PALE: Rgb = [0xb4, 0xb9, 0xc2];

/// Points per millimetre.
pub(super) const POINTS: f64 = 72.0 / 25.4;

/// Where a text is held.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Align {
    Left,
    Middle,
    Right,
}

/// From the sheet to the page: scale, then shift.
#[derive(Clone, Copy)]
pub(super) struct Map {
    pub scale: f64,
    pub shift: [f64; 2],
}

impl Map {
    pub fn place(&self, p: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|a| self.scale * p[a] + self.shift[a])
    }

    /// What fits bounds into others, centred, no larger than life.
    pub fn fit(inner: &Bounds, outer: &Bounds) -> Self {
        let size = |bounds: &Bounds, a: usize| bounds.high[a] - bounds.low[a];
        let ratio = |a: usize| size(outer, a) / size(inner, a).max(1e-9);
        let scale = ratio(0).min(ratio(1)).min(1.0);
        let middle = |bounds: &Bounds, a: usize| 0.5 * (bounds.low[a] + bounds.high[a]);
        Self { scale, shift: [0, 1].map(|a| middle(outer, a) - scale * middle(inner, a)) }
    }
}

/// Operators of one page.
pub(super) struct Canvas {
    out: String,
}

impl Canvas {
    pub fn new() -> Self {
        // Everything below is in millimetres.
        Self { out: format!("{POINTS:.9} 0 0 {POINTS:.9} 0 0 cm\n1 J 1 j\n") }
    }

    pub fn bytes(&self) -> &[u8] {
        self.out.as_bytes()
    }

    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        for x in numbers {
            millimetres(&mut self.out, x);
            self.out.push(' ');
        }
    }

    fn operator(&mut self, numbers: impl IntoIterator<Item = f64>, name: &str) {
        self.numbers(numbers);
        self.out += name;
        self.out.push('\n');
    }

    /// Until [`Canvas::close_clip`] nothing is drawn outside of a rectangle.
    pub fn open_clip(&mut self, bounds: &Bounds) {
        let Bounds { low, high } = *bounds;
        self.out += "q\n";
        self.operator([low[0], low[1], high[0] - low[0], high[1] - low[1]], "re W n");
    }

    pub fn close_clip(&mut self) {
        self.out += "Q\n";
    }

    /// What follows can be switched off by a reader.
    pub fn open_layer(&mut self, index: usize) {
        let _ = writeln!(self.out, "/OC /OC{index} BDC");
    }

    pub fn close_layer(&mut self) {
        self.out += "EMC\n";
    }

    fn colour(&mut self, rgb: Rgb, operator: &str) {
        self.operator(rgb.map(|x| f64::from(x) / 255.0), operator);
    }

    pub fn pen(&mut self, width: f64, rgb: Rgb, dashes: &[f64]) {
        self.operator([width], "w");
        self.colour(rgb, "RG");
        self.out.push('[');
        self.numbers(dashes.iter().copied());
        self.out += "] 0 d\n";
    }

    fn path(&mut self, points: &[[f64; 2]]) {
        for (i, &p) in points.iter().enumerate() {
            self.operator(p, if i == 0 { "m" } else { "l" });
        }
    }

    pub fn stroke(&mut self, points: &[[f64; 2]], is_closed: bool) {
        self.path(points);
        self.out += if is_closed { "s\n" } else { "S\n" };
    }

    pub fn fill(&mut self, points: &[[f64; 2]], rgb: Rgb) {
        self.colour(rgb, "rg");
        self.path(points);
        self.out += "f\n";
    }

    pub fn rectangle(&mut self, bounds: &Bounds) {
        let Bounds { low: [x, y], high: [u, v] } = *bounds;
        self.stroke(&[[x, y], [u, y], [u, v], [x, v]], true);
    }

    /// A line of the sheet, curves as curves.
    pub fn line(&mut self, line: &Line, map: Map) {
        if line.curve.is_empty() {
            for stroke in drawn(line) {
                let points: Vec<[f64; 2]> = stroke.points.iter().map(|&p| map.place(p)).collect();
                self.stroke(&points, stroke.is_closed);
            }
        } else if let Some(&start) = line.points.first() {
            self.operator(map.place(start), "m");
            for curve in &line.curve {
                let places = curve.map(|p| map.place(p));
                self.operator(places.into_iter().flatten(), "c");
            }
            self.out += if line.is_closed { "s\n" } else { "S\n" };
        }
    }

    /// A picture in the resources of the page, over a rectangle.
    pub fn picture(&mut self, bounds: &Bounds) {
        let Bounds { low, high } = *bounds;
        self.out += "q\n";
        self.operator([high[0] - low[0], 0.0, 0.0, high[1] - low[1], low[0], low[1]], "cm");
        self.out += "/Im0 Do\nQ\n";
    }

    /// A line of text, held half way up its capitals.
    pub fn text(&mut self, at: [f64; 2], height: f64, align: Align, rgb: Rgb, text: &str) {
        self.any_text(at, height, align, rgb, text, "F0");
    }

    /// The same in bold letters; a little wider than [`letters::width`] says.
    pub fn bold(&mut self, at: [f64; 2], height: f64, rgb: Rgb, text: &str) {
        self.any_text(at, height, Align::Left, rgb, text, "F1");
    }

    fn any_text(
        &mut self,
        at: [f64; 2],
        height: f64,
        align: Align,
        rgb: Rgb,
        text: &str,
        font: &str,
    ) {
        let width = letters::width(text, height);
        let left = match align {
            Align::Left => at[0],
            Align::Middle => at[0] - 0.5 * width,
            Align::Right => at[0] - width,
        };
        let Some(bytes) = letters::encode(text) else {
            self.pen(0.1 * height, rgb, &[]);
            for stroke in stroke_font::strokes(text, [left, at[1]], height, true) {
                self.stroke(&stroke, false);
            }
            return;
        };
        if bytes.iter().all(|&b| b == b' ') {
            return;
        }
        self.colour(rgb, "rg");
        let _ = write!(self.out, "BT /{font} ");
        self.operator([height / letters::CAPITALS], "Tf");
        self.operator([left, at[1] - 0.5 * height], "Td");
        self.out.push('<');
        for byte in bytes {
            let _ = write!(self.out, "{byte:02x}");
        }
        self.out += "> Tj ET\n";
    }

    /// A text no wider than given: smaller if need be, then shortened.
    pub fn fitted(
        &mut self,
        at: [f64; 2],
        height: f64,
        align: Align,
        rgb: Rgb,
        text: &str,
        most: f64,
    ) {
        let (text, height) = fit(text, height, most);
        self.text(at, height, align, rgb, &text);
    }

    /// A text of the sheet.
    pub fn sheet_text(&mut self, text: &Text, map: Map, rgb: Rgb) {
        let align = if text.is_left { Align::Left } else { Align::Middle };
        self.text(map.place(text.at), map.scale * text.height, align, rgb, &text.text);
    }
}

/// Text and height that are no wider than given: up to a third smaller, then cut short.
pub(super) fn fit(text: &str, height: f64, most: f64) -> (String, f64) {
    let width = letters::width(text, height);
    if width <= most {
        return (text.to_owned(), height);
    }
    let smaller = (height * most / width).max(height / 1.5);
    if letters::width(text, smaller) <= most * (1.0 + 1e-9) {
        return (text.to_owned(), smaller);
    }
    let mut short: Vec<char> = text.chars().collect();
    loop {
        short.pop();
        let candidate: String = short.iter().collect::<String>().trim_end().to_owned() + "…";
        if short.is_empty() || letters::width(&candidate, smaller) <= most {
            return (candidate, smaller);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_is_too_wide_becomes_smaller_and_then_shorter() {
        assert!(matches!(fit("abc", 3.0, 100.0), (text, 3.0) if text == "abc"));
        let (text, height) = fit("abcdefgh", 3.0, 15.0);
        assert!(text == "abcdefgh" && (2.0..3.0).contains(&height));
        let (text, height) = fit("abcdefgh abcdefgh abcdefgh", 3.0, 15.0);
        assert!(text.ends_with('…') && letters::width(&text, height) <= 15.0, "{text}");
        assert_eq!(fit("abc", 3.0, 0.1).0, "…");
    }

    #[test]
    fn bounds_are_fitted_into_others() {
        let bounds = |low, high| Bounds { low, high };
        let map = Map::fit(&bounds([0.0; 2], [200.0, 100.0]), &bounds([10.0; 2], [60.0, 60.0]));
        let near = |p: [f64; 2], q: [f64; 2]| (0..2).all(|a| (p[a] - q[a]).abs() < 1e-12);
        assert!(near(map.place([0.0, 0.0]), [10.0, 22.5]));
        assert!(near(map.place([200.0, 100.0]), [60.0, 47.5]));
    }
}
