//! The stock: what fits, how much of it a layout uses, and what is left to try.

use super::part::{Part, Spot};
use super::{NestParams, Stock};

/// Stock between margins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Room {
    pub stock: Stock,
    pub gap: f64,
    pub margin: f64,
}

/// Stock that a layout is to do with: sheets of one size, the last one lower.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bins {
    pub sheets: usize,
    pub width: f64,
    pub height: f64,
    pub last: f64,
}

impl Bins {
    pub fn height_of(&self, sheet: usize) -> f64 {
        if sheet + 1 == self.sheets { self.last } else { self.height }
    }
}

impl Room {
    pub fn new(params: &NestParams) -> Self {
        Self { stock: params.stock, gap: params.gap_mm, margin: params.margin_mm }
    }

    /// Width and height between the margins.
    pub fn inner(&self) -> [f64; 2] {
        let inner = |x: f64| x - 2.0 * self.margin;
        match self.stock {
            Stock::Roll { width_mm } => [inner(width_mm), f64::INFINITY],
            Stock::Sheet { width_mm, height_mm, .. } => [inner(width_mm), inner(height_mm)],
            Stock::Free => [f64::INFINITY; 2],
        }
    }

    /// Whether an extent fits between the margins, up to rounding.
    pub fn fits(&self, size: [f64; 2]) -> bool {
        let inner = self.inner();
        (0..2).all(|k| size[k] <= inner[k] * (1.0 + 1e-12))
    }

    /// What is to be made small: the length used of a roll; for sheets the heights of all, of the last one only what is used; the
    /// side of a square.
    pub fn cost(&self, spots: &[Spot]) -> f64 {
        let last = spots.iter().map(|s| s.sheet).max().unwrap_or(0);
        let on_last = spots.iter().filter(|s| s.sheet == last);
        let [x, y] = [0, 1].map(|k| {
            let high = on_last.clone().map(|s| s.bounds.high[k]).fold(f64::NEG_INFINITY, f64::max);
            if high.is_finite() { high + self.margin } else { 0.0 }
        });
        match self.stock {
            Stock::Roll { .. } => y,
            Stock::Sheet { height_mm, .. } => last as f64 * height_mm + y,
            Stock::Free => x.max(y),
        }
    }

    /// The stock of a cost.
    pub fn bins(&self, cost: f64, least_height: f64) -> Bins {
        match self.stock {
            Stock::Roll { width_mm } => {
                Bins { sheets: 1, width: width_mm, height: cost, last: cost }
            }
            Stock::Free => Bins { sheets: 1, width: cost, height: cost, last: cost },
            Stock::Sheet { width_mm, height_mm, .. } => {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "at most as many as there are pieces"
                )]
                let full = (cost / height_mm).max(0.0) as usize;
                let rest = cost - full as f64 * height_mm;
                let bins = |sheets, last| Bins { sheets, width: width_mm, height: height_mm, last };
                // Nothing would fit into less.
                if full > 0 && rest < least_height + 2.0 * self.margin {
                    bins(full, height_mm)
                } else {
                    bins(full + 1, rest)
                }
            }
        }
    }

    /// A cost that no layout can be below.
    ///
    /// Parts grown by half the gap have no point in common and lie in the stock grown by as much; by Brunn and Minkowski a shape of
    /// area A grown by r has area (√A + √π r)² or more.
    pub fn least_cost(&self, parts: &[Part]) -> f64 {
        let grown = |part: &Part| {
            let side = part.area.sqrt() + 0.5 * std::f64::consts::PI.sqrt() * self.gap;
            side * side
        };
        let area: f64 = parts.iter().map(grown).sum();
        let extents = parts.iter().map(Part::least_extent);
        let [height, side] = extents.fold([0.0_f64; 2], |m, e| [0, 1].map(|k| m[k].max(e[k])));
        let [width, full] = self.inner().map(|x| x + self.gap);
        let margins = 2.0 * self.margin;
        match self.stock {
            Stock::Roll { .. } => height.max(area / width - self.gap) + margins,
            Stock::Free => side.max(area.sqrt() - self.gap) + margins,
            Stock::Sheet { height_mm, .. } => {
                let least = parts.iter().map(|p| p.least_extent()[0]);
                let least = least.fold(f64::INFINITY, f64::min);
                let sheets = ((area / (width * full)).ceil() - 1.0).max(0.0);
                let rest = area / width - sheets * full - self.gap;
                // With one sheet it holds the highest part.
                let rest = if sheets > 0.0 { rest.max(least) } else { rest.max(height) };
                sheets * height_mm + rest + margins
            }
        }
    }
}
