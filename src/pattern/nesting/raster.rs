//! First layouts: each part as low as it goes, then as far to the left, on a raster.
//!
//! A part grown by half the gap covers all cells that it touches; parts that cover no cell in common keep the gap. Rows of the
//! raster are lists of covered stretches, so that all places of a row are tried at once. Where one copy of a part found no place
//! the next will find none either, as nothing is taken away: it goes on from there.

use std::collections::BTreeMap;

use super::part::{Fit, Part, Spot};
use super::plane::{minus, sides, size};

/// Covered stretches of a row: first cell, and the one after the last.
type Row = Vec<[i32; 2]>;

/// Touching a cell by less than this part of its side is rounding.
const TOUCH: f64 = 1e-9;

/// What parts are laid on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Board {
    /// Between the margins; the height may be infinite.
    pub inner: [f64; 2],
    pub gap: f64,
    pub margin: f64,
    /// Side of a cell.
    pub cell: f64,
}

/// The cells that a part covers in one turn, from the lower left.
struct Mask {
    rows: Vec<Row>,
    /// The longest stretch of each row.
    longest: Vec<i32>,
    /// Rows in an order that finds what is in the way early.
    order: Vec<usize>,
}

/// Cells covered by parts that lie already.
#[derive(Default)]
struct Covered {
    rows: Vec<Row>,
    /// The longest stretch of each row that is free.
    free: Vec<i32>,
    columns: i32,
}

/// Lays parts one after the other. `None` if one goes nowhere, which its having fits excludes.
pub(super) fn fill(parts: &[Part], order: &[usize], board: &Board) -> Option<Vec<Spot>> {
    let slack = parts.iter().map(|part| part.slack).fold(0.0, f64::max);
    let reach = 0.5 * board.gap + slack;
    let widest = parts.iter().flat_map(|p| &p.fits).map(|f| f.size()[0]).fold(0.0, f64::max);
    let columns = whole(((board.inner[0].max(widest) + 2.0 * reach) / board.cell).ceil() + 1.0);
    let mut sheets: Vec<Covered> = Vec::new();
    let mut spots: Vec<Option<Spot>> = vec![None; parts.len()];
    let originals = originals(parts);
    let mut all_masks: Vec<Option<Vec<Mask>>> = parts.iter().map(|_| None).collect();
    // For each original and sheet the row from which on each turn may have a place.
    let mut all_lows: Vec<Vec<Vec<i32>>> = vec![Vec::new(); parts.len()];
    for &i in order {
        let part = &parts[i];
        let masks = all_masks[originals[i]].get_or_insert_with(|| {
            part.fits.iter().map(|fit| Mask::new(part, fit, board, reach)).collect()
        });
        let lows = &mut all_lows[originals[i]];
        let mut sheet = 0;
        let (turn, x, y) = loop {
            let is_new = sheet == sheets.len();
            if is_new {
                sheets.push(Covered { columns, ..Covered::default() });
            }
            if lows.len() == sheet {
                lows.push(vec![0; masks.len()]);
            }
            if let Some(found) = lowest(&sheets[sheet], part, masks, &mut lows[sheet], board) {
                break found;
            }
            if is_new {
                return None;
            }
            sheet += 1;
        };
        sheets[sheet].add(&masks[turn], x, y);
        let corner = [x, y].map(|k| board.margin + f64::from(k) * board.cell);
        spots[i] = Some(Spot::new(sheet, &part.fits[turn], corner));
    }
    Some(spots.into_iter().flatten().collect())
}

/// For each part the first one that is the same: copies are.
fn originals(parts: &[Part]) -> Vec<usize> {
    let mut firsts: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    let mut original = |(i, part): (usize, &Part)| {
        let alike = firsts.entry(part.area.to_bits()).or_default();
        let found = alike.iter().copied().find(|&j| part.is_copy_of(&parts[j]));
        found.unwrap_or_else(|| {
            alike.push(i);
            i
        })
    };
    parts.iter().enumerate().map(&mut original).collect()
}

/// The turn and cell with the lowest top, then the lowest place, then the one farthest left.
///
/// **Takes** for each turn a row below which it has no place, which is brought up to what is found.
fn lowest(
    covered: &Covered,
    part: &Part,
    masks: &[Mask],
    lows: &mut [i32],
    board: &Board,
) -> Option<(usize, i32, i32)> {
    let mut best: Option<(f64, usize, i32, i32)> = None;
    for (turn, (fit, mask)) in part.fits.iter().zip(masks).enumerate() {
        let [width, height] = fit.size();
        let room = |inner: f64, size: f64| ((inner - size) / board.cell + TOUCH).floor().max(0.0);
        if width > board.inner[0] * (1.0 + 1e-12) || height > board.inner[1] * (1.0 + 1e-12) {
            continue;
        }
        let last_x = whole(room(board.inner[0], width));
        let limit = match best {
            Some((top, ..)) if top < height => continue,
            Some((top, ..)) => room(board.inner[1].min(top), height),
            None => room(board.inner[1], height),
        };
        let last_y = whole(limit.min(covered.rows.len() as f64));
        let found = covered.place(mask, last_x, [lows[turn], last_y]);
        lows[turn] = found.map_or(lows[turn].max(last_y + 1), |[_, y]| y);
        if let Some([x, y]) = found {
            let top = f64::from(y) * board.cell + height;
            // Of two turns with about the same top the one farther left.
            let is_better = best.is_none_or(|(t, _, best_x, _)| {
                top < t - 0.5 * board.cell || (top < t + 0.5 * board.cell && x < best_x)
            });
            if is_better {
                best = Some((top, turn, x, y));
            }
        }
    }
    best.map(|(_, turn, x, y)| (turn, x, y))
}

#[expect(clippy::cast_possible_truncation, reason = "saturates")]
fn whole(x: f64) -> i32 {
    x as i32
}

impl Covered {
    /// The lowest free place of a mask in some rows, then the one farthest left.
    fn place(&self, mask: &Mask, last_x: i32, [first_y, last_y]: [i32; 2]) -> Option<[i32; 2]> {
        let places = usize::try_from(last_x).unwrap_or(0) + 1;
        let mut taken = vec![0_u64; places.div_ceil(64)];
        'rows: for y in first_y..=last_y {
            let from = usize::try_from(y).unwrap_or(0);
            let beside = |j: &usize| *j + from < self.rows.len();
            if mask
                .order
                .iter()
                .filter(|j| beside(j))
                .any(|&j| self.free[from + j] < mask.longest[j])
            {
                continue;
            }
            taken.fill(0);
            // Places behind the last one count as taken.
            if places % 64 > 0
                && let Some(last) = taken.last_mut()
            {
                *last = !0 << (places % 64);
            }
            for &j in mask.order.iter().filter(|j| beside(j)) {
                let covered = &self.rows[from + j];
                for [a, b] in &mask.rows[j] {
                    for [c, d] in covered {
                        let (low, high) = ((c - b + 1).max(0), (d - a - 1).min(last_x));
                        if low <= high {
                            set(&mut taken, low, high);
                        }
                    }
                }
                if taken.iter().all(|word| *word == !0) {
                    continue 'rows;
                }
            }
            let x = taken.iter().zip(0..).find(|(word, _)| **word != !0);
            return x.map(|(word, k)| [64 * k + word.trailing_ones().cast_signed(), y]);
        }
        None
    }

    fn add(&mut self, mask: &Mask, x: i32, y: i32) {
        let from = usize::try_from(y).unwrap_or(0);
        let needed = from + mask.rows.len();
        while self.rows.len() < needed {
            self.rows.push(Row::new());
            self.free.push(self.columns);
        }
        for (j, row) in mask.rows.iter().enumerate() {
            let covered = &mut self.rows[from + j];
            covered.extend(row.iter().map(|[a, b]| [a + x, b + x]));
            merge(covered);
            let mut end = 0;
            let mut longest = 0;
            for [a, b] in covered {
                longest = longest.max(*a - end);
                end = *b;
            }
            self.free[from + j] = longest.max(self.columns - end);
        }
    }
}

/// Sets bits from `low` to `high`.
fn set(words: &mut [u64], low: i32, high: i32) {
    let [low, high] = [low, high].map(|x| usize::try_from(x).unwrap_or(0));
    let (first, last) = (low / 64, high / 64);
    let head = !0_u64 << (low % 64);
    let tail = !0_u64 >> (63 - high % 64);
    if first == last {
        words[first] |= head & tail;
        return;
    }
    words[first] |= head;
    words[first + 1..last].fill(!0);
    words[last] |= tail;
}

/// Sorts stretches and joins those that meet.
fn merge(row: &mut Row) {
    row.sort_unstable();
    let mut joined: Row = Vec::with_capacity(row.len());
    for &[a, b] in row.iter() {
        match joined.last_mut() {
            Some(last) if a <= last[1] => last[1] = last[1].max(b),
            _ => joined.push([a, b]),
        }
    }
    *row = joined;
}

impl Mask {
    /// Cells are counted from the low corner of the extent less `reach`, which all masks have in common.
    fn new(part: &Part, fit: &Fit, board: &Board, reach: f64) -> Self {
        let cell = board.cell;
        let radius = 0.5 * board.gap + part.slack;
        let place = |&p: &[f64; 2]| {
            let p = minus(fit.turn.apply(p), fit.bounds.low);
            p.map(|x| (x + reach) / cell)
        };
        let outlines: Vec<Vec<[f64; 2]>> =
            part.rim.iter().map(|outline| outline.iter().map(place).collect()).collect();
        // From here on in cells.
        let radius = radius / cell;
        let height = (fit.size()[1] + 2.0 * reach) / cell;
        let count = usize::try_from(whole((height - TOUCH).ceil())).unwrap_or(1).max(1);
        let mut rows: Vec<Row> = vec![Row::new(); count];
        let at = |y: f64| usize::try_from(whole(y.floor())).unwrap_or(0).min(count - 1);
        for [a, b] in outlines.iter().flat_map(|outline| sides(outline)) {
            let (low, high) = (a[1].min(b[1]), a[1].max(b[1]));
            let capsule = Capsule::new(a, b, radius);
            for j in at(low - radius)..=at(high + radius) {
                let band = [j as f64 + TOUCH, (j + 1) as f64 - TOUCH];
                if let Some([x, y]) = capsule.extent(band) {
                    let stretch = [whole((x + TOUCH).floor()), whole((y - TOUCH).ceil())];
                    if stretch[0] < stretch[1] {
                        rows[j].push([stretch[0].max(0), stretch[1]]);
                    }
                }
            }
        }
        let mut crossings: Vec<Vec<(f64, i32)>> = vec![Vec::new(); count];
        for [a, b] in outlines.iter().flat_map(|outline| sides(outline)) {
            let (low, high) = (a[1].min(b[1]), a[1].max(b[1]));
            let first = usize::try_from(whole((low - 0.5).ceil())).unwrap_or(0);
            for (j, row) in crossings.iter_mut().enumerate().skip(first) {
                let y = j as f64 + 0.5;
                if y >= high {
                    break;
                }
                let x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
                row.push((x, if a[1] <= y { 1 } else { -1 }));
            }
        }
        for (row, mut crossings) in rows.iter_mut().zip(crossings) {
            crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut turns = 0;
            for pair in crossings.windows(2) {
                turns += pair[0].1;
                let [a, b] = [pair[0].0, pair[1].0].map(|x| whole((x - 0.5).ceil()));
                if turns != 0 && a < b {
                    row.push([a, b]);
                }
            }
            merge(row);
        }
        let longest: Vec<i32> =
            rows.iter().map(|row| row.iter().map(|[a, b]| b - a).max().unwrap_or(0)).collect();
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|&j| (-longest[j], j));
        Self { rows, longest, order }
    }
}

/// All points within a radius of a segment.
struct Capsule {
    ends: [[f64; 2]; 2],
    radius: f64,
    corners: [[f64; 2]; 4],
}

impl Capsule {
    fn new(a: [f64; 2], b: [f64; 2], radius: f64) -> Self {
        let along = minus(b, a);
        let length = size(along);
        let [x, y] = if length > 0.0 { along.map(|x| radius * x / length) } else { [0.0; 2] };
        let corners = [
            [a[0] - y, a[1] + x],
            [a[0] + y, a[1] - x],
            [b[0] + y, b[1] - x],
            [b[0] - y, b[1] + x],
        ];
        Self { ends: [a, b], radius, corners }
    }

    /// Least and greatest x within a band of y.
    fn extent(&self, [low, high]: [f64; 2]) -> Option<[f64; 2]> {
        let mut extent: Option<[f64; 2]> = None;
        let mut add = |x: f64, y: f64| {
            let [a, b] = extent.unwrap_or([x, y]);
            extent = Some([a.min(x), b.max(y)]);
        };
        for c in self.ends {
            let off = (low - c[1]).max(c[1] - high).max(0.0);
            if off <= self.radius {
                let half = (self.radius * self.radius - off * off).max(0.0).sqrt();
                add(c[0] - half, c[0] + half);
            }
        }
        for [a, b] in sides(&self.corners) {
            let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            if b[1] < low || a[1] > high {
                continue;
            }
            let x = |y: f64| {
                if b[1] > a[1] { a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) } else { a[0] }
            };
            let ends =
                if b[1] > a[1] { [x(low.max(a[1])), x(high.min(b[1]))] } else { [a[0], b[0]] };
            add(ends[0].min(ends[1]), ends[0].max(ends[1]));
        }
        extent
    }
}
