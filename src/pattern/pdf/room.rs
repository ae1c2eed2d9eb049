//! Where on a page least is drawn.

use super::super::piece::{Bounds, length};

/// Side of the cells in which ink is counted, mm.
const CELL: f64 = 2.0;

/// Ink in the cells of a window, summed from the lower left corner.
pub(super) struct Room {
    low: [f64; 2],
    columns: usize,
    rows: usize,
    /// Counts while ink is added, sums afterwards; one row and column more than cells.
    sums: Vec<u32>,
}

impl Room {
    pub fn new(window: &Bounds) -> Self {
        let [columns, rows] = [0, 1].map(|a| whole((window.high[a] - window.low[a]) / CELL));
        Self { low: window.low, columns, rows, sums: vec![0; (columns + 1) * (rows + 1)] }
    }

    fn add(&mut self, p: [f64; 2], weight: u32) {
        let [x, y] = [0, 1].map(|a| (p[a] - self.low[a]) / CELL);
        if x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64 {
            let at = (whole(y) + 1) * (self.columns + 1) + whole(x) + 1;
            self.sums[at] = self.sums[at].saturating_add(weight);
        }
    }

    /// A line, by points no farther apart than half a cell.
    pub fn add_line(&mut self, [a, b]: [[f64; 2]; 2]) {
        let steps = (length(&[a, b]) / (0.5 * CELL)).ceil().clamp(1.0, 1e5);
        let mut k = 0.0;
        while k <= steps {
            let t = k / steps;
            self.add([0, 1].map(|i| a[i] + t * (b[i] - a[i])), 1);
            k += 1.0;
        }
    }

    /// A rectangle that should stay readable.
    pub fn add_box(&mut self, bounds: &Bounds) {
        let mut y = bounds.low[1];
        while y < bounds.high[1] + 0.5 * CELL {
            let mut x = bounds.low[0];
            while x < bounds.high[0] + 0.5 * CELL {
                self.add([x, y], 20);
                x += 0.5 * CELL;
            }
            y += 0.5 * CELL;
        }
    }

    /// The lower left corner of the square in which least is drawn, the lowest and then the leftmost of such. `None` if the
    /// window is smaller.
    pub fn least(mut self, side: f64) -> Option<[f64; 2]> {
        let width = self.columns + 1;
        for row in 1..=self.rows {
            for column in 1..=self.columns {
                let at = row * width + column;
                let before = self.sums[at - 1] + self.sums[at - width];
                self.sums[at] = self.sums[at].saturating_add(before - self.sums[at - width - 1]);
            }
        }
        let cells = whole((side / CELL).ceil());
        let mut best = None;
        for row in 0..(self.rows + 1).saturating_sub(cells) {
            for column in 0..(self.columns + 1).saturating_sub(cells) {
                let sum = |r: usize, c: usize| i64::from(self.sums[r * width + c]);
                let (r, c) = (row + cells, column + cells);
                let ink = sum(r, c) + sum(row, column) - sum(row, c) - sum(r, column);
                if best.is_none_or(|(least, _, _)| ink < least) {
                    best = Some((ink, row, column));
                }
            }
        }
        best.map(|(_, row, column)| {
            [self.low[0] + CELL * column as f64, self.low[1] + CELL * row as f64]
        })
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "lengths of pages")]
fn whole(x: f64) -> usize {
    x.clamp(0.0, 1e4) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_lies_where_nothing_is_drawn() {
        let window = Bounds { low: [10.0, 10.0], high: [200.0, 110.0] };
        let mut room = Room::new(&window);
        // Lines all over the left part, a text in the right one.
        for k in 0..12 {
            let x = 10.0 + 8.0 * f64::from(k);
            room.add_line([[x, 0.0], [x, 120.0]]);
        }
        room.add_box(&Bounds { low: [150.0, 20.0], high: [190.0, 24.0] });
        let [x, y] = room.least(54.0).unwrap();
        // Beyond the last line and the text, to a cell.
        assert!(x >= 98.0 && x + 54.0 <= 200.0 && y >= 24.0 && y + 54.0 <= 110.0, "{x} {y}");
        assert_eq!(Room::new(&window).least(120.0), None);
    }
}
