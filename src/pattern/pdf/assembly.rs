//! What is sewn to what: a picture of all pieces, and lists of pieces and seams.

use std::collections::BTreeMap;

use super::super::piece::{Bounds, Piece, length};
use super::super::seam::Seam;
use super::super::sheet::{Layer, Sheet};
use super::PdfParams;
use super::canvas::{Align, BLACK, Canvas, GREY, Map, PALE};
use super::ink::Ink;
use super::table::{Column, Text};
use super::{Orientation, letters};

/// The assembly sheets.
pub(super) fn assembly(sheet: &Sheet, params: &PdfParams, page: [f64; 2]) -> Vec<Canvas> {
    let title = format!("Assembly: {}", sheet.title);
    let mut text = Text::new(page, params.margin_mm.clamp(6.35, 25.0), title);
    let ink = Ink::new(sheet, &PICTURED, false);
    let left = 0.5 * (page[0] - text.width());
    let most = Bounds {
        low: [left, text.y - (0.45 * page[1]).min(text.width())],
        high: [left + text.width(), text.y],
    };
    let high = Map::fit(&ink.bounds, &most).scale * (ink.bounds.high[1] - ink.bounds.low[1]);
    let frame = Bounds { low: [left, text.y - high], high: most.high };
    all_pieces(text.canvas(), sheet, Map::fit(&ink.bounds, &frame));
    text.y -= high + 5.0;

    let column = |head, part, align| Column { head, part, align };
    text.heading("Pieces");
    let mut columns = vec![
        column("Piece", 16.0, Align::Left),
        column("Cut", 26.0, Align::Left),
        column("Size mm", 28.0, Align::Right),
        column("Area cm²", 20.0, Align::Right),
        column("Seams", 14.0, Align::Right),
    ];
    let mut rows: Vec<Vec<String>> =
        (0..sheet.pattern.pieces.len()).map(|index| piece_row(sheet, params, index)).collect();
    if rows.iter().all(|row| row[columns.len()].is_empty()) {
        rows.iter_mut().for_each(|row| row.truncate(columns.len()));
        text.table(&columns, &rows, 2);
    } else {
        columns.push(column("Notes", 86.0, Align::Left));
        text.table(&columns, &rows, 1);
    }

    let rows = seam_rows(sheet);
    if !rows.is_empty() {
        text.heading("Seams: lengths in the plane; ease is what the second side is longer by");
        let columns = [
            column("Seam", 11.0, Align::Right),
            column("Pieces", 22.0, Align::Left),
            column("First mm", 19.0, Align::Right),
            column("Second mm", 19.0, Align::Right),
            column("Ease mm", 22.0, Align::Right),
        ];
        text.table(&columns, &rows, 2);
    }
    text.finish()
}

/// What is in the list of pieces, notes last.
fn piece_row(sheet: &Sheet, params: &PdfParams, index: usize) -> Vec<String> {
    let piece = &sheet.pattern.pieces[index];
    let (count, note) = params.note(index);
    let mut notes = vec![note];
    if piece.crossings > 0 {
        notes.push("outline crosses itself");
    }
    notes.retain(|note| !note.is_empty());
    vec![
        piece.name.clone(),
        count.to_owned(),
        extent(sheet, index),
        format!("{:.1}", piece.area_mm2 / 100.0),
        piece.seams.len().to_string(),
        notes.join("; "),
    ]
}

/// Width and height of what is cut out for a piece.
pub(super) fn extent(sheet: &Sheet, piece: usize) -> String {
    let cuts = sheet.lines.iter().filter(|l| l.piece == Some(piece) && l.layer == Layer::Cut);
    let points: Vec<[f64; 2]> = cuts.flat_map(|line| line.points.iter().copied()).collect();
    let bounds =
        if points.is_empty() { sheet.pattern.pieces[piece].bounds } else { Bounds::around(points) };
    let [width, height] = [0, 1].map(|a| bounds.high[a] - bounds.low[a]);
    format!("{width:.0} × {height:.0}")
}

/// What is in the picture of all pieces.
const PICTURED: [Layer; 3] = [Layer::FoldMountain, Layer::FoldValley, Layer::Cut];

/// Outlines and folds of everything, small, the names of the pieces, and the numbers of seams.
fn all_pieces(canvas: &mut Canvas, sheet: &Sheet, map: Map) {
    for layer in PICTURED {
        let (rgb, width) = if layer == Layer::Cut { (BLACK, 0.2) } else { (PALE, 0.1) };
        canvas.pen(width, rgb, &[]);
        for line in sheet.lines.iter().filter(|line| line.layer == layer) {
            canvas.line(line, map);
        }
    }
    for piece in &sheet.pattern.pieces {
        let room = map.scale * piece.room_mm;
        // As high as the piece has room for, and as can be read.
        let most = 0.9 * room / letters::width(&piece.name, 1.0).max(1.0);
        let height = most.clamp(1.0, 5.0);
        canvas.text(map.place(piece.centre), height, Align::Middle, BLACK, &piece.name);
        for seam in &piece.seams {
            number(canvas, piece, seam, map);
        }
    }
}

/// The number of a seam inside the piece, where there is room for it.
fn number(canvas: &mut Canvas, piece: &Piece, seam: &Seam, map: Map) {
    const HEIGHT: f64 = 1.6;
    let drawn = map.scale * seam.length_mm;
    if drawn < 8.0
        || map.scale * piece.room_mm < 6.0
        || piece.outlines.get(seam.outline).is_none_or(|outline| outline.points.is_empty())
    {
        return;
    }
    let points = piece.seam_points(seam);
    let mut rest = 0.5 * seam.length_mm;
    for side in points.windows(2) {
        let step = length(side);
        if rest > step {
            rest -= step;
            continue;
        }
        if step <= 0.0 {
            continue;
        }
        let t = rest / step;
        let [a, b] = [side[0], side[1]];
        let at = map.place([0, 1].map(|i| a[i] + t * (b[i] - a[i])));
        let aside = 1.6 + 0.5 * HEIGHT;
        let at = [at[0] - aside * (b[1] - a[1]) / step, at[1] + aside * (b[0] - a[0]) / step];
        canvas.text(at, HEIGHT, Align::Middle, GREY, &seam.number.to_string());
        return;
    }
}

/// A row for each seam: number, pieces, both lengths, and their difference.
fn seam_rows(sheet: &Sheet) -> Vec<Vec<String>> {
    let mut sides: BTreeMap<usize, Vec<(&Piece, &Seam)>> = BTreeMap::new();
    for piece in &sheet.pattern.pieces {
        for seam in &piece.seams {
            sides.entry(seam.number).or_default().push((piece, seam));
        }
    }
    let row = |(number, sides): (usize, Vec<(&Piece, &Seam)>)| {
        let first = sides.iter().find(|side| !side.1.is_second).or(sides.first());
        let second = sides.iter().find(|side| side.1.is_second);
        let name = |side: Option<&(&Piece, &Seam)>| {
            side.map_or_else(|| "–".to_owned(), |side| side.0.name.clone())
        };
        let length = |side: Option<&(&Piece, &Seam)>| {
            side.map_or_else(|| "–".to_owned(), |side| format!("{:.1}", side.1.length_mm))
        };
        let ease = match (first, second) {
            (Some((_, a)), Some((_, b))) if a.is_second != b.is_second => {
                let ease = b.length_mm - a.length_mm;
                let part = 100.0 * ease / a.length_mm.max(1e-9);
                // Rounded so that no −0.0 is shown.
                if ease.abs() < 0.05 {
                    "0.0".to_owned()
                } else {
                    format!("{ease:+.1} ({part:+.1} %)")
                }
            }
            _ => "–".to_owned(),
        };
        let pieces = format!("{} – {}", name(first), name(second));
        vec![number.to_string(), pieces, length(first), length(second), ease]
    };
    sides.into_iter().map(row).collect()
}

/// How the pages lie, in words.
pub(super) fn lying(page: [f64; 2]) -> Orientation {
    if page[0] > page[1] { Orientation::Landscape } else { Orientation::Portrait }
}
