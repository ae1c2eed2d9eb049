//! Drawings as files: what stands in the bytes, token by token.

mod dxf;
mod pdf;
mod refusing;
mod sheets;
mod svg;

use cutflow::pattern::{Sheet, SvgParams};

use sheets::round_pieces;

pub fn small() -> Sheet {
    round_pieces(3, 2, 60.0, 72)
}

pub fn drawing(sheet: &Sheet, params: &SvgParams) -> String {
    String::from_utf8(cutflow::pattern::svg(sheet, params).unwrap()).unwrap()
}

/// The attribute of an element.
pub fn attribute<'a>(element: &'a str, key: &str) -> Option<&'a str> {
    let from = element.find(&format!(" {key}=\""))? + key.len() + 3;
    let rest = &element[from..];
    Some(&rest[..rest.find('"')?])
}

/// A square frame of cut lines with nothing inside.
pub fn hollow(side: f64) -> Sheet {
    let mut sheet = round_pieces(1, 1, 0.5 * side, 24);
    sheet.texts.clear();
    sheet.lines.retain(|line| line.id == "A-cut");
    let [x, y] = [10.0, 80.0];
    sheet.lines[0].points = vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
    sheet
}
