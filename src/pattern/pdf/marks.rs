//! Marks on the line where two pages meet: the same on both.

use super::super::piece::piece_name;
use super::tiles::Grid;

/// Half the size of a mark; smaller where pages overlap by less.
const HALF: f64 = 3.0;
/// Height of the letters beside it.
const LETTERS: f64 = 2.5;
/// On longer edges there are more marks than one.
const APART: f64 = 200.0;

/// A mark on one page.
#[derive(Debug)]
pub(super) struct Mark {
    /// Its middle, on the sheet.
    pub at: [f64; 2],
    /// From there to its corners.
    pub half: f64,
    /// The letters that the page across has too.
    pub letters: String,
    /// Where they stand, on the sheet.
    pub beside: [f64; 2],
}

pub(super) const LETTER_HEIGHT: f64 = LETTERS;

/// The marks of each printed page, in the order of [`Grid::tiles`]. Only where the page across is printed.
pub(super) fn marks(grid: &Grid) -> Vec<Vec<Mark>> {
    let tiles = grid.tiles();
    if !grid.is_joined {
        return tiles.iter().map(|_| Vec::new()).collect();
    }
    let mut out: Vec<Vec<Mark>> = tiles.iter().map(|_| Vec::new()).collect();
    let index = |row: usize, column: usize| {
        tiles.iter().position(|tile| (tile.row, tile.column) == (row, column))
    };
    let is_butt = grid.overlap <= 0.0;
    let half = if is_butt { HALF } else { HALF.min(0.5 * grid.overlap) };
    let mut number = 0;
    for (k, tile) in tiles.iter().enumerate() {
        let right = index(tile.row, tile.column + 1).map(|other| (other, 0));
        let below = index(tile.row + 1, tile.column).map(|other| (other, 1));
        for (other, axis) in [right, below].into_iter().flatten() {
            let middle = if axis == 0 {
                tile.high[0] - 0.5 * grid.overlap
            } else {
                tile.low[1] + 0.5 * grid.overlap
            };
            let (from, to) = (tile.low[1 - axis], tile.high[1 - axis]);
            let count = ((to - from) / APART).round().max(1.0);
            let mut place = 0.5;
            while place < count {
                let along = from + (to - from) * place / count;
                place += 1.0;
                let at = if axis == 0 { [middle, along] } else { [along, middle] };
                let letters = piece_name(number).to_lowercase();
                number += 1;
                // Beside the mark along the edge; each on its own page where the edge is cut.
                let beside = |aside: f64| {
                    let mut p = at;
                    p[1 - axis] += half + 0.8 * LETTERS * if axis == 0 { 1.0 } else { 1.3 };
                    p[axis] += aside;
                    p
                };
                let own =
                    |aside| Mark { at, half, letters: letters.clone(), beside: beside(aside) };
                let aside = match (is_butt, axis) {
                    (false, _) => 0.0,
                    (true, 0) => -LETTERS,
                    (true, _) => LETTERS,
                };
                out[k].push(own(aside));
                out[other].push(own(-aside));
            }
        }
    }
    out
}
