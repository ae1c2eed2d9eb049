//! The dialect for machines and drawing programs.

use super::groups::Groups;
use super::{cutting_order, lines_of, names, piece_bounds};
use crate::pattern::drawn::drawn;
use crate::pattern::piece::Bounds;
use crate::pattern::sheet::{Layer, Line, Sheet, Text};
use crate::pattern::style::style;

/// Side of the control square.
const SQUARE: f64 = 50.0;
/// Texts are no lower than this, unless they were meant to be.
const SMALLEST_TEXT: f64 = 2.0;
/// Readers' fonts are up to as wide as high; texts have room for 0.8 of that.
const NARROWER: f64 = 0.8;

/// Dash, gap, …: lines of these types are drawn so by readers.
const LINE_TYPES: [(&str, &str, &[f64]); 3] = [
    ("CONTINUOUS", "Solid line", &[]),
    ("DASHED", "__ __ __ __", &[6.0, -3.0]),
    ("DASHDOT", "__ . __ . __", &[6.0, -2.0, 0.0, -2.0]),
];

/// Colour number and line type.
fn look(layer: Layer) -> (usize, &'static str) {
    match layer {
        Layer::Cut => (1, "CONTINUOUS"),
        Layer::Sew => (5, "DASHED"),
        Layer::Notch => (3, "CONTINUOUS"),
        Layer::Grain => (4, "CONTINUOUS"),
        Layer::FoldMountain => (6, "DASHDOT"),
        Layer::FoldValley => (30, "DASHED"),
        Layer::Score => (5, "CONTINUOUS"),
        Layer::Drill => (2, "CONTINUOUS"),
        Layer::Internal | Layer::Control => (8, "CONTINUOUS"),
        Layer::Text => (7, "CONTINUOUS"),
    }
}

pub(super) fn write(sheet: &Sheet, is_exploded: bool, is_strict: bool) -> Vec<u8> {
    let mut groups = Groups::default();
    header(&mut groups, sheet, is_strict);
    tables(&mut groups);
    let cuts = cutting_order(sheet);
    let count = sheet.pattern.pieces.len();
    let texts = |piece: Option<usize>| sheet.texts.iter().filter(move |t| t.piece == piece);
    let names: Vec<String> = sheet.pattern.pieces.iter().map(|piece| piece.name.clone()).collect();
    let names = names::unique(&names);
    // Where each piece lies; none for those of which nothing is drawn.
    let bases: Vec<Option<[f64; 2]>> =
        (0..count).map(|piece| piece_bounds(sheet, piece).map(|bounds| bounds.low)).collect();
    groups.open_section("BLOCKS");
    for (piece, name) in names.iter().enumerate().filter(|_| !is_exploded) {
        let Some(base) = bases[piece] else { continue };
        groups.open_block("0", name);
        for line in lines_of(sheet, &cuts, Some(piece)) {
            write_line(&mut groups, line, base);
        }
        texts(Some(piece)).for_each(|text| write_text(&mut groups, text, base));
        groups.close_block("0");
    }
    groups.close_section();
    groups.open_section("ENTITIES");
    for (piece, name) in names.iter().enumerate() {
        let Some(base) = bases[piece] else { continue };
        if !is_exploded {
            groups.insert("0", name, base);
            continue;
        }
        for line in lines_of(sheet, &cuts, Some(piece)) {
            write_line(&mut groups, line, [0.0; 2]);
        }
        texts(Some(piece)).for_each(|text| write_text(&mut groups, text, [0.0; 2]));
    }
    // What belongs to no piece, or to none that is drawn.
    let is_loose = |piece: Option<usize>| piece.and_then(|p| *bases.get(p)?).is_none();
    for line in sheet.lines.iter().filter(|line| is_loose(line.piece)) {
        write_line(&mut groups, line, [0.0; 2]);
    }
    for text in sheet.texts.iter().filter(|text| is_loose(text.piece)) {
        write_text(&mut groups, text, [0.0; 2]);
    }
    if let Some(square) = own_square(sheet) {
        let [[x, y], [u, v]] = [square.low, square.high];
        groups.polyline("CONTROL", &[[x, y], [u, y], [u, v], [x, v]], true);
        groups.text("CONTROL", [x + 10.0, y + 0.5 * SQUARE], 3.0, "50 MM");
    }
    groups.close_section();
    groups.finish();
    groups.bytes()
}

/// A control square below the sheet, if the sheet has none.
fn own_square(sheet: &Sheet) -> Option<Bounds> {
    let has_own = sheet.lines.iter().any(|line| line.id == "control-square");
    let low = [0.0, -10.0 - SQUARE];
    (!has_own).then(|| Bounds { low, high: low.map(|x| x + SQUARE) })
}

fn header(groups: &mut Groups, sheet: &Sheet, is_strict: bool) {
    let strokes = sheet.lines.iter().flat_map(drawn);
    let square = own_square(sheet).into_iter().flat_map(|square| [square.low, square.high]);
    let points: Vec<[f64; 2]> = strokes.flat_map(|stroke| stroke.points).chain(square).collect();
    let bounds = Bounds::around(points);
    groups.open_section("HEADER");
    groups.word(9, "$ACADVER").word(1, "AC1009");
    groups.word(9, "$INSBASE").place(10, [0.0; 2]);
    groups.word(9, "$EXTMIN").place(10, bounds.low);
    groups.word(9, "$EXTMAX").place(10, bounds.high);
    groups.word(9, "$LUNITS").integer(70, 2);
    groups.word(9, "$LTSCALE").number(40, 1.0);
    if !is_strict {
        groups.word(9, "$MEASUREMENT").integer(70, 1);
        groups.word(9, "$INSUNITS").integer(70, 4);
    }
    groups.close_section();
}

fn tables(groups: &mut Groups) {
    groups.open_section("TABLES");
    groups.word(0, "TABLE").word(2, "LTYPE").integer(70, LINE_TYPES.len());
    for (name, drawing, dashes) in LINE_TYPES {
        groups.word(0, "LTYPE").word(2, name).integer(70, 0).word(3, drawing);
        groups.integer(72, 65).integer(73, dashes.len());
        groups.number(40, dashes.iter().map(|dash| dash.abs()).sum());
        for &dash in dashes {
            groups.number(49, dash);
        }
    }
    groups.word(0, "ENDTAB");
    groups.word(0, "TABLE").word(2, "LAYER").integer(70, Layer::ALL.len() + 1);
    let mut layer = |name: &str, colour: usize, line_type: &str| {
        groups.word(0, "LAYER").word(2, name).integer(70, 0);
        groups.integer(62, colour).word(6, line_type);
    };
    layer("0", 7, "CONTINUOUS");
    for each in Layer::ALL {
        let (colour, line_type) = look(each);
        layer(style(each).label, colour, line_type);
    }
    groups.word(0, "ENDTAB");
    groups.word(0, "TABLE").word(2, "STYLE").integer(70, 1);
    groups.word(0, "STYLE").word(2, "STANDARD").integer(70, 0).number(40, 0.0).number(41, 1.0);
    groups.number(50, 0.0).integer(71, 0).number(42, 2.5).word(3, "txt").word(4, "");
    groups.word(0, "ENDTAB");
    groups.close_section();
}

fn write_line(groups: &mut Groups, line: &Line, base: [f64; 2]) {
    let layer = style(line.layer).label;
    for stroke in drawn(line) {
        let points: Vec<[f64; 2]> =
            stroke.points.iter().map(|p| [p[0] - base[0], p[1] - base[1]]).collect();
        match points[..] {
            [from, to] => groups.line(layer, [from, to]),
            _ => groups.polyline(layer, &points, stroke.is_closed),
        }
    }
}

fn write_text(groups: &mut Groups, text: &Text, base: [f64; 2]) {
    if text.text.trim().is_empty() {
        return;
    }
    let words = if text.id == "control-label" { "50 MM" } else { text.text.as_str() };
    let height = text.height.min((NARROWER * text.height).max(SMALLEST_TEXT));
    let count = crate::pattern::transliterate::to_ascii(words).len() as f64;
    let left = if text.is_left { 0.0 } else { 0.5 * height * count };
    let [x, y] = text.at;
    let at = [x - base[0] - left, y - base[1] - 0.5 * height];
    groups.text(style(text.layer).label, at, height, words);
}
