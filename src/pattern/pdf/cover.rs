//! The first page: how to print, how to join, what is on it.

use super::super::piece::{Bounds, piece_name};
use super::super::sheet::{Layer, Sheet};
use super::super::style::{WIDTH, style};
use super::assembly::extent;
use super::canvas::{Align, BLACK, Canvas, GREY, Map, PALE, Rgb};
use super::tile_page::control_square;
use super::tiles::Grid;
use super::{Orientation, Paper, PdfParams, letters};

/// Two inches.
const INCHES: f64 = 50.8;
/// Pages that are printed, on the map.
const USED: Rgb = [0xf1, 0xee, 0xe3];

pub(super) fn cover(sheet: &Sheet, params: &PdfParams, grid: &Grid, page: [f64; 2]) -> Canvas {
    let margin = params.margin_mm.clamp(6.35, 25.0);
    let (left, right) = (margin, page[0] - margin);
    let width = right - left;
    let mut canvas = Canvas::new();
    let mut y = page[1] - margin;

    canvas.fitted([left, y - 4.0], 7.0, Align::Left, BLACK, &sheet.title, width);
    y -= 13.0;
    canvas.fitted([left, y], 2.6, Align::Left, GREY, &summary(sheet, params, grid), width);
    y -= 8.0;
    canvas.bold([left, y], 3.2, BLACK, "Print at 100 %, actual size. Do not fit to the page.");
    y -= 6.0;
    let check = "Measure a square before you cut: its sides are as long as is written in it.";
    canvas.fitted([left, y], 2.3, Align::Left, BLACK, check, width);
    for words in joining(params, grid) {
        y -= 4.6;
        canvas.fitted([left, y], 2.3, Align::Left, BLACK, words, width);
    }
    for words in params.notes.iter().take(6) {
        y -= 4.6;
        canvas.fitted([left, y], 2.3, Align::Left, GREY, words, width);
    }
    y -= 7.0;

    control_square(&mut canvas, [left, y - 50.0], 50.0, "50 mm");
    control_square(&mut canvas, [left + 56.0, y - INCHES], INCHES, "2 in");
    if let Some(picture) = &params.picture {
        let frame = Bounds { low: [left + 114.0, y - INCHES], high: [right, y] };
        let [w, h] = [picture.width, picture.height].map(f64::from);
        let scale = ((frame.high[0] - frame.low[0]) / w).min(INCHES / h);
        let middle = [0, 1].map(|a| 0.5 * (frame.low[a] + frame.high[a]));
        let half = [0.5 * scale * w, 0.5 * scale * h];
        canvas.picture(&Bounds {
            low: [0, 1].map(|a| middle[a] - half[a]),
            high: [0, 1].map(|a| middle[a] + half[a]),
        });
    }
    y -= INCHES + 9.0;

    // The map on the left, the legend on the right, the cut list in what is left below.
    let split = left + 0.56 * width;
    canvas.bold([left, y], 3.0, BLACK, if grid.has_frame { "Pages" } else { "The sheet" });
    canvas.bold([split + 6.0, y], 3.0, BLACK, "Lines");
    y -= 5.0;
    let drawn_to = map(&mut canvas, sheet, grid, [left, split], [y, y - 0.34 * page[1]]);
    let legend_to = legend(&mut canvas, sheet, params, [split + 6.0, right], y);
    y = drawn_to.min(legend_to) - 8.0;
    cut_list(&mut canvas, sheet, params, [left, right], [y, margin]);
    canvas
}

/// How much of what.
fn summary(sheet: &Sheet, params: &PdfParams, grid: &Grid) -> String {
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    let [width, height] = sheet.size;
    let pieces = count(sheet.pattern.pieces.len(), "piece");
    let pages = count(grid.tiles().len(), "page");
    let paper = match params.paper {
        Paper::A4 => "A4".to_owned(),
        Paper::A3 => "A3".to_owned(),
        Paper::Letter => "Letter".to_owned(),
        Paper::Legal => "Legal".to_owned(),
        Paper::Tabloid => "Tabloid".to_owned(),
        Paper::OnePage | Paper::Roll { .. } => {
            format!("{:.0} × {:.0} mm", grid.page[0], grid.page[1])
        }
    };
    let way = match (params.paper, super::assembly::lying(grid.page)) {
        (Paper::OnePage | Paper::Roll { .. }, _) => "",
        (_, Orientation::Landscape) => " landscape",
        _ => " portrait",
    };
    format!("{pieces}, sheet {width:.0} × {height:.0} mm, {pages} {paper}{way}. Outer side up.")
}

/// How pages are joined.
fn joining(params: &PdfParams, grid: &Grid) -> &'static [&'static str] {
    if !grid.is_joined || grid.rows * grid.columns < 2 {
        &[]
    } else if params.overlap_mm > 0.0 {
        &[
            "To join: cut each page along the right and the lower side of its frame,",
            "lay it over the next pages so that diamonds with the same letters meet, and glue.",
        ]
    } else {
        &[
            "To join: cut each page along all four sides of its frame,",
            "set the pages edge to edge so that diamonds with the same letters meet, and tape.",
        ]
    }
}

/// The pages in their places with the pieces on them. Gives where it ends below.
fn map(canvas: &mut Canvas, sheet: &Sheet, grid: &Grid, x: [f64; 2], y: [f64; 2]) -> f64 {
    let (first, last) = (grid.own(grid.rows - 1, 0), grid.own(0, grid.columns - 1));
    let whole = Bounds { low: first.low, high: last.high };
    let frame = Bounds { low: [x[0], y[1]], high: [x[1], y[0]] };
    let mut map = Map::fit(&whole, &frame);
    // To the upper left.
    map.shift = [x[0] - map.scale * whole.low[0], y[0] - map.scale * whole.high[1]];
    let placed =
        |bounds: Bounds| Bounds { low: map.place(bounds.low), high: map.place(bounds.high) };
    let cells = || (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |c| (row, c)));
    for (row, column) in cells().filter(|&(row, column)| grid.is_printed(row, column)) {
        let Bounds { low: [x, y], high: [u, v] } = placed(grid.own(row, column));
        canvas.fill(&[[x, y], [u, y], [u, v], [x, v]], USED);
        canvas.pen(0.15, GREY, &[]);
        canvas.rectangle(&Bounds { low: [x, y], high: [u, v] });
    }
    canvas.pen(0.12, BLACK, &[]);
    canvas.open_clip(&placed(whole));
    for line in sheet.lines.iter().filter(|line| line.layer == Layer::Cut) {
        canvas.line(line, map);
    }
    canvas.close_clip();
    for (row, column) in cells().filter(|&(row, column)| grid.is_printed(row, column)) {
        if !grid.has_frame {
            continue;
        }
        let Bounds { low, high } = placed(grid.own(row, column));
        let name = format!("{}{}", piece_name(row), column + 1);
        let height = (0.3 * (high[1] - low[1])).min(3.0);
        let height = height.min(0.8 * (high[0] - low[0]) / letters::width(&name, 1.0));
        canvas.text([low[0] + 0.6 * height, high[1] - height], height, Align::Left, GREY, &name);
    }
    let bottom = placed(whole).low[1];
    if bottom.is_finite() { bottom.max(y[1]) } else { y[1] }
}

/// A sample of each kind of line that is drawn. Gives where it ends below.
fn legend(canvas: &mut Canvas, sheet: &Sheet, params: &PdfParams, x: [f64; 2], mut y: f64) -> f64 {
    for layer in Layer::ALL {
        let is_drawn = sheet.lines.iter().any(|line| line.layer == layer);
        if !is_drawn || !params.layers.contains(&layer) || layer == Layer::Control {
            continue;
        }
        let style = style(layer);
        canvas.pen(WIDTH, style.rgb, style.dashes);
        if layer == Layer::Drill {
            let (x, r) = (x[0] + 11.0, 1.5);
            canvas.stroke(&[[x - r, y], [x + r, y]], false);
            canvas.stroke(&[[x, y - r], [x, y + r]], false);
        } else {
            canvas.stroke(&[[x[0], y], [x[0] + 22.0, y]], false);
        }
        let at = [x[0] + 26.0, y];
        canvas.fitted(at, 2.2, Align::Left, BLACK, style.meaning, x[1] - at[0]);
        y -= 5.0;
    }
    if sheet.pattern.pieces.iter().any(|piece| !piece.seams.is_empty()) {
        let words = "3 > B: seam 3, joined to piece B";
        canvas.fitted([x[0], y - 1.0], 2.2, Align::Left, BLACK, words, x[1] - x[0]);
        y -= 6.0;
    }
    y
}

/// How often each piece is cut, as far as there is room.
fn cut_list(canvas: &mut Canvas, sheet: &Sheet, params: &PdfParams, x: [f64; 2], y: [f64; 2]) {
    const ROW: f64 = 4.4;
    let count = sheet.pattern.pieces.len();
    if count == 0 || y[0] - y[1] < 3.0 * ROW {
        return;
    }
    canvas.bold([x[0], y[0]], 3.0, BLACK, "Cut list");
    let top = y[0] - 6.0;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
    let high = (((top - y[1]) / ROW) as usize).max(1);
    let columns = 3;
    let width = (x[1] - x[0]) / columns as f64;
    let is_all = count <= high * columns;
    let shown = if is_all { count } else { high * columns - 1 };
    let per_column = if is_all { count.div_ceil(columns).max(high.min(8)) } else { high };
    for index in 0..count.min(shown + 1) {
        let at = [
            x[0] + width * (index / per_column) as f64,
            top - ROW * (index % per_column) as f64 - 0.5 * ROW,
        ];
        if index == shown {
            let more = format!("and {} more: see the assembly sheet", count - shown);
            canvas.fitted(at, 2.1, Align::Left, GREY, &more, width - 3.0);
            break;
        }
        let (times, _) = params.note(index);
        let name = &sheet.pattern.pieces[index].name;
        let words = format!("{name}   cut {times}   {} mm", extent(sheet, index));
        canvas.fitted(at, 2.1, Align::Left, BLACK, &words, width - 3.0);
    }
    canvas.pen(0.1, PALE, &[]);
    canvas.stroke(&[[x[0], top + 1.0], [x[1], top + 1.0]], false);
}
