//! Lists on pages of text: lines from the top, over as many pages as they take.

use super::canvas::{Align, BLACK, Canvas, GREY, PALE};

/// From one row of a table to the next.
const ROW: f64 = 4.4;
/// Height of its letters.
const LETTERS: f64 = 2.0;
/// Between columns of a table, and of a page.
const GAP: f64 = 2.0;
const GUTTER: f64 = 8.0;

/// A column: its head, its part of the width, and how it is held.
pub(super) struct Column {
    pub head: &'static str,
    pub part: f64,
    pub align: Align,
}

/// Pages of text while they are filled.
pub(super) struct Text {
    pages: Vec<Canvas>,
    size: [f64; 2],
    margin: f64,
    title: String,
    /// The next line is below this.
    pub y: f64,
}

impl Text {
    pub fn new(size: [f64; 2], margin: f64, title: String) -> Self {
        let mut text = Self { pages: Vec::new(), size, margin, title, y: 0.0 };
        text.next_page();
        text
    }

    fn next_page(&mut self) {
        let mut canvas = Canvas::new();
        let [width, height] = self.size;
        self.y = height - self.margin;
        let number = format!("{}", self.pages.len() + 1);
        let y = self.y - 2.0;
        canvas.fitted(
            [self.margin, y],
            4.0,
            Align::Left,
            BLACK,
            &self.title,
            width - 2.0 * self.margin - 12.0,
        );
        canvas.text([width - self.margin, y], 2.5, Align::Right, GREY, &number);
        self.y -= 9.0;
        self.pages.push(canvas);
    }

    pub fn finish(self) -> Vec<Canvas> {
        self.pages
    }

    pub fn width(&self) -> f64 {
        self.size[0] - 2.0 * self.margin
    }

    /// Free space down to the margin.
    pub fn room(&self) -> f64 {
        self.y - self.margin
    }

    /// The page that is being filled.
    pub fn canvas(&mut self) -> &mut Canvas {
        let last = self.pages.len() - 1;
        &mut self.pages[last]
    }

    /// A heading that is not left alone at the end of a page.
    pub fn heading(&mut self, words: &str) {
        if self.room() < 9.0 + 4.0 * ROW {
            self.next_page();
        }
        let at = [self.margin, self.y - 4.0];
        self.canvas().bold(at, 3.0, BLACK, words);
        self.y -= 9.0;
    }

    /// A table in as many columns of the page as asked for; full columns first, what is left evenly.
    pub fn table(&mut self, columns: &[Column], rows: &[Vec<String>], abreast: usize) {
        let mut rest = rows;
        let width = (self.width() - GUTTER * (abreast - 1) as f64) / abreast as f64;
        while !rest.is_empty() {
            if self.room() < 3.0 * ROW {
                self.next_page();
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
            let fitting = (self.room() / ROW) as usize - 1;
            let high = fitting.min(rest.len().div_ceil(abreast)).max(1);
            let top = self.y;
            let mut lowest = top;
            for k in 0..abreast {
                let (now, later) = rest.split_at(high.min(rest.len()));
                if now.is_empty() {
                    break;
                }
                rest = later;
                let left = self.margin + k as f64 * (width + GUTTER);
                self.y = top;
                self.rows(columns, now, left, width);
                lowest = lowest.min(self.y);
            }
            self.y = lowest - GAP;
        }
    }

    fn rows(&mut self, columns: &[Column], rows: &[Vec<String>], left: f64, width: f64) {
        let total: f64 = columns.iter().map(|column| column.part).sum();
        let heads = columns.iter().map(|column| column.head.to_owned()).collect();
        for (k, row) in std::iter::once(&heads).chain(rows).enumerate() {
            let y = self.y - 0.5 * ROW;
            let mut x = left;
            for (column, cell) in columns.iter().zip(row) {
                let own = width * column.part / total;
                let at = match column.align {
                    Align::Left => [x, y],
                    Align::Middle => [x + 0.5 * (own - GAP), y],
                    Align::Right => [x + own - GAP, y],
                };
                let rgb = if k == 0 { GREY } else { BLACK };
                self.canvas().fitted(at, LETTERS, column.align, rgb, cell, own - GAP);
                x += own;
            }
            self.y -= ROW;
            let y = self.y;
            let canvas = self.canvas();
            canvas.pen(0.1, PALE, &[]);
            canvas.stroke(&[[left, y], [left + width, y]], false);
        }
    }
}
