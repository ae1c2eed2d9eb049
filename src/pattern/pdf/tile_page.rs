//! One page of the sheet.

use super::super::labels::{is_met, meet};
use super::super::piece::Bounds;
use super::super::sheet::{Layer, Line, Sheet};
use super::super::style::{WIDTH, style};
use super::PdfParams;
use super::canvas::{Align, BLACK, Canvas, GREY, Map, PALE};
use super::ink::{is_footer, text_box};
use super::letters;
use super::marks::{LETTER_HEIGHT, Mark};
use super::room::Room;
use super::tiles::{BAND, Grid, Tile};

/// Side of the control square.
const SQUARE: f64 = 50.0;
/// Free space around it, if there is any.
const GAP: f64 = 2.0;

/// A page: which one it is of how many.
pub(super) struct TilePage<'a> {
    pub grid: &'a Grid,
    pub tile: &'a Tile,
    pub marks: &'a [Mark],
    pub number: usize,
    pub count: usize,
}

impl TilePage<'_> {
    pub fn draw(&self, sheet: &Sheet, params: &PdfParams, page_layer: usize) -> Canvas {
        let mut canvas = Canvas::new();
        let shown = Bounds { low: self.tile.low, high: self.tile.high };
        let window = self.grid.window;
        let map = Map { scale: 1.0, shift: [0, 1].map(|a| window.low[a] - shown.low[a]) };
        canvas.open_clip(&window);
        for (index, &layer) in Layer::ALL.iter().enumerate() {
            if !params.layers.contains(&layer) {
                continue;
            }
            let is_kept =
                |id: &str| !(self.grid.has_frame && layer == Layer::Control && is_footer(id));
            let lines = sheet.lines.iter().filter(|line| line.layer == layer && is_kept(&line.id));
            let lines: Vec<&Line> = lines.filter(|line| meet(&around(line), &shown)).collect();
            let texts = sheet.texts.iter().filter(|t| t.layer == layer && is_kept(&t.id));
            let texts: Vec<_> = texts.filter(|text| meet(&text_box(text), &shown)).collect();
            if lines.is_empty() && texts.is_empty() {
                continue;
            }
            let style = style(layer);
            canvas.open_layer(index);
            canvas.pen(WIDTH, style.rgb, style.dashes);
            for line in lines {
                canvas.line(line, map);
            }
            for text in texts {
                canvas.sheet_text(text, map, style.rgb);
            }
            canvas.close_layer();
        }
        canvas.close_clip();
        canvas.open_layer(page_layer);
        if self.grid.has_frame {
            self.frame(&mut canvas, sheet, map);
        }
        let has_own = !self.grid.has_frame
            && params.layers.contains(&Layer::Control)
            && sheet.lines.iter().any(|line| line.id == "control-square");
        if !has_own {
            self.square(&mut canvas, sheet, params, map);
        }
        canvas.close_layer();
        canvas
    }

    fn frame(&self, canvas: &mut Canvas, sheet: &Sheet, map: Map) {
        let (grid, tile, window) = (self.grid, self.tile, self.grid.window);
        canvas.open_clip(&window);
        for mark in self.marks {
            let [x, y] = map.place(mark.at);
            let h = mark.half;
            canvas.pen(0.15, GREY, &[]);
            canvas.stroke(&[[x - h, y], [x, y - h], [x + h, y], [x, y + h]], true);
            canvas.stroke(&[[x - h, y], [x + h, y]], false);
            canvas.stroke(&[[x, y - h], [x, y + h]], false);
            let beside = map.place(mark.beside);
            canvas.text(beside, LETTER_HEIGHT, Align::Middle, GREY, &mark.letters);
        }
        canvas.close_clip();
        canvas.pen(0.15, GREY, &[]);
        canvas.rectangle(&window);
        let y = window.high[1] + 0.5 * BAND;
        let mut x = window.low[0];
        canvas.bold([x, y], 5.0, BLACK, &tile.name);
        x += 1.15 * letters::width(&tile.name, 5.0) + 4.0;
        let place = format!(
            "row {}/{}   column {}/{}   sheet {}/{}",
            tile.row + 1,
            grid.rows,
            tile.column + 1,
            grid.columns,
            self.number,
            self.count
        );
        canvas.text([x, y], 2.3, Align::Left, BLACK, &place);
        x += letters::width(&place, 2.3) + 6.0;
        let hint = "100 %, do not fit";
        let right = window.high[0];
        canvas.text([right, y], 2.3, Align::Right, GREY, hint);
        let room = right - letters::width(hint, 2.3) - 4.0 - x;
        if room > 10.0 {
            canvas.fitted([x, y], 2.3, Align::Left, GREY, &sheet.title, room);
        }
    }

    /// The control square where least is drawn.
    fn square(&self, canvas: &mut Canvas, sheet: &Sheet, params: &PdfParams, map: Map) {
        let window = self.grid.window;
        let shown = Bounds { low: self.tile.low, high: self.tile.high };
        let lines = sheet.lines.iter().filter(|line| params.layers.contains(&line.layer));
        let mut room = Room::new(&window);
        for line in lines.filter(|line| meet(&around(line), &shown)) {
            let joint = line.is_closed.then(|| line.points.first().copied()).flatten();
            let points: Vec<[f64; 2]> =
                line.points.iter().copied().chain(joint).map(|p| map.place(p)).collect();
            let near = points.windows(2).filter(|side| is_met(&window, side[0], side[1]));
            near.for_each(|side| room.add_line([side[0], side[1]]));
        }
        let texts = sheet.texts.iter().filter(|text| params.layers.contains(&text.layer));
        for bounds in texts.map(text_box).filter(|bounds| meet(bounds, &shown)) {
            room.add_box(&Bounds { low: map.place(bounds.low), high: map.place(bounds.high) });
        }
        for mark in self.marks {
            let reach = mark.half + 2.0 * LETTER_HEIGHT;
            let at = map.place(mark.at);
            room.add_box(&Bounds { low: at.map(|x| x - reach), high: at.map(|x| x + reach) });
        }
        if let Some(low) = room.least(SQUARE + 2.0 * GAP).map(|low| low.map(|x| x + GAP)) {
            control_square(canvas, low, SQUARE, "50 mm");
        }
    }
}

/// A square to be measured, with its side written inside near the lower edge.
pub(super) fn control_square(canvas: &mut Canvas, low: [f64; 2], side: f64, name: &str) {
    canvas.pen(WIDTH, PALE, &[]);
    let high = low.map(|x| x + side);
    canvas.rectangle(&Bounds { low, high });
    canvas.text([low[0] + 2.0, low[1] + 3.5], 2.5, Align::Left, GREY, name);
}

/// Bounds of a line, and of the control points of its curves.
fn around(line: &Line) -> Bounds {
    Bounds::around(line.points.iter().chain(line.curve.iter().flatten()).copied())
}
