//! Segments by where they lie: those near a place are found without looking at all of them.

use super::piece::Bounds;

/// Square cells with the segments whose boxes meet them.
pub(super) struct Grid {
    low: [f64; 2],
    cell: f64,
    size: [usize; 2],
    /// Where the list of each cell begins in `items`.
    first: Vec<usize>,
    items: Vec<usize>,
    boxes: Vec<Bounds>,
}

impl Grid {
    /// **Costs** O(n): about as many cells as segments.
    pub fn new(segments: &[[[f64; 2]; 2]]) -> Self {
        let boxes: Vec<Bounds> = segments.iter().map(|s| Bounds::around(*s)).collect();
        let all = Bounds::around(segments.iter().flatten().copied());
        let extent = [0, 1].map(|a| all.high[a] - all.low[a]);
        let count = (segments.len().max(1)) as f64;
        // Cells of the mean size of a segment's share of the boundary; never more than 4 n in all.
        let around = (extent[0] + extent[1]).max(f64::MIN_POSITIVE);
        let area = (extent[0] * extent[1] / (2.0 * count)).sqrt();
        let cell = area.max(around / (2.0 * count)).max(around * 1e-6);
        let size = extent.map(|x| index(x / cell, usize::MAX) + 1);
        let mut grid =
            Self { low: all.low, cell, size, first: Vec::new(), items: Vec::new(), boxes };
        let mut counts = vec![0; size[0] * size[1] + 1];
        for i in 0..grid.boxes.len() {
            grid.cells(&grid.boxes[i], |c| counts[c + 1] += 1);
        }
        for c in 1..counts.len() {
            counts[c] += counts[c - 1];
        }
        let mut at = counts.clone();
        let mut items = vec![0; counts[counts.len() - 1]];
        for i in 0..grid.boxes.len() {
            grid.cells(&grid.boxes[i], |c| {
                items[at[c]] = i;
                at[c] += 1;
            });
        }
        grid.first = counts;
        grid.items = items;
        grid
    }

    fn range(&self, bounds: &Bounds) -> [[usize; 2]; 2] {
        [0, 1].map(|a| {
            let at = |x: f64| index((x - self.low[a]) / self.cell, self.size[a] - 1);
            [at(bounds.low[a]), at(bounds.high[a])]
        })
    }

    fn cells(&self, bounds: &Bounds, mut call: impl FnMut(usize)) {
        let [[x0, x1], [y0, y1]] = self.range(bounds);
        for y in y0..=y1 {
            for x in x0..=x1 {
                call(y * self.size[0] + x);
            }
        }
    }

    /// Calls with each segment once whose box is no farther from that of a segment than a distance, and maybe with some others.
    pub fn near(&self, segment: [[f64; 2]; 2], far: f64, mut call: impl FnMut(usize)) {
        let Bounds { low, high } = Bounds::around(segment);
        let bounds = Bounds { low: low.map(|x| x - far), high: high.map(|x| x + far) };
        let [[x0, _], [y0, _]] = self.range(&bounds);
        self.cells(&bounds, |c| {
            let (x, y) = (c % self.size[0], c / self.size[0]);
            for &i in &self.items[self.first[c]..self.first[c + 1]] {
                let other = &self.boxes[i];
                // In the first common cell only.
                let [[a0, _], [b0, _]] = self.range(other);
                let meets = (0..2)
                    .all(|a| other.low[a] <= bounds.high[a] && bounds.low[a] <= other.high[a]);
                if meets && x == a0.max(x0) && y == b0.max(y0) {
                    call(i);
                }
            }
        });
    }
}

/// A number of cells from below, within what there are.
fn index(x: f64, largest: usize) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative, and far below what a usize holds"
    )]
    let whole = x.clamp(0.0, 1e9) as usize;
    whole.min(largest)
}
