//! Signed distance to outlines, fast: exact near them, interpolated far off.

use super::plane::{cross, dot, minus, sides, squared_distance, winding};
use crate::pattern::piece::Bounds;

/// Cells along the longer side of a shape. Fewer, and cells hold many sides; more, and they cost more to fill than they save.
const CELLS: f64 = 64.0;

/// A grid of square cells around outlines. A cell that may hold points at the distances that must be exact lists the sides that can
/// be nearest to any of its points; in others the distances at their corners are interpolated, off by less than half a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Field {
    low: [f64; 2],
    per_unit: f64,
    columns: usize,
    rows: usize,
    /// At the corners of cells, row by row; negative inside.
    corners: Vec<f64>,
    /// Where the sides of each cell begin in `lists`.
    starts: Vec<u32>,
    lists: Vec<u32>,
    sides: Vec<Side>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    ends: [[f64; 2]; 2],
    along: [f64; 2],
    /// One over the square of its length.
    inverse: f64,
    /// Out of the shape at its inside and at its ends; of any length.
    out: [[f64; 2]; 3],
}

impl Field {
    /// **Takes** outlines with the shape on their left; between what distances the field is to be exact, and how far it must reach.
    pub fn new(outlines: &[Vec<[f64; 2]>], exact: [f64; 2], reach: f64) -> Self {
        let all = outer_sides(outlines);
        let bounds = Bounds::around(outlines.iter().flatten().copied());
        let extent = [0, 1].map(|k| bounds.high[k] - bounds.low[k]);
        let reach = reach.max(exact[1]);
        let longest = extent[0].max(extent[1]) + 2.0 * reach;
        let cell = longest / CELLS;
        let low = bounds.low.map(|x| x - reach);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "about CELLS")]
        let [columns, rows] = extent.map(|e| ((e + 2.0 * reach) / cell).ceil().max(1.0) as usize);
        let place = |i: usize, j: usize, half: f64| {
            [low[0] + (i as f64 + half) * cell, low[1] + (j as f64 + half) * cell]
        };
        let mut corners = Vec::with_capacity((columns + 1) * (rows + 1));
        for j in 0..=rows {
            for i in 0..=columns {
                let p = place(i, j, 0.0);
                let squared = all.iter().map(|s| squared_distance(p, s.ends));
                let distance = squared.fold(f64::INFINITY, f64::min).sqrt();
                corners.push(if winding(outlines, p) != 0 { -distance } else { distance });
            }
        }
        let diagonal = cell * std::f64::consts::SQRT_2;
        let mut starts = vec![0];
        let mut lists = Vec::new();
        for j in 0..rows {
            for i in 0..columns {
                // Distances of two points of a cell differ by no more than a diagonal.
                let d = corners[j * (columns + 1) + i];
                let is_near = |d: f64, by: f64| d > exact[0] - by && d < exact[1] + by;
                if !is_near(d, diagonal) {
                    starts.push(u32::try_from(lists.len()).unwrap_or(u32::MAX));
                    continue;
                }
                let centre = place(i, j, 0.5);
                let distances = all.iter().map(|s| squared_distance(centre, s.ends).sqrt());
                let nearest = distances.clone().fold(f64::INFINITY, f64::min);
                // Where the rim may be in the cell, the centre may be on its either side.
                let is_rim = nearest < 0.5 * diagonal && exact[0] < diagonal;
                if is_rim || is_near(nearest * d.signum(), 0.5 * diagonal) {
                    let within = distances.zip(0..).filter(|(d, _)| *d <= nearest + diagonal);
                    lists.extend(within.map(|(_, k)| k));
                }
                starts.push(u32::try_from(lists.len()).unwrap_or(u32::MAX));
            }
        }
        Self { low, per_unit: 1.0 / cell, columns, rows, corners, starts, lists, sides: all }
    }

    /// Distance to the rim, negative inside; infinite off the grid.
    pub fn distance(&self, p: [f64; 2]) -> f64 {
        self.look_up::<false>(p).0
    }

    /// Distance to the rim, and the direction in which it grows; its length is 1, or near it.
    pub fn slope(&self, p: [f64; 2]) -> (f64, [f64; 2]) {
        self.look_up::<true>(p)
    }

    fn look_up<const WITH_SLOPE: bool>(&self, p: [f64; 2]) -> (f64, [f64; 2]) {
        let x = (p[0] - self.low[0]) * self.per_unit;
        let y = (p[1] - self.low[1]) * self.per_unit;
        if !(x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64) {
            return (f64::INFINITY, [0.0; 2]);
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "just bounded")]
        let (i, j) = (x as usize, y as usize);
        let cell = j * self.columns + i;
        let list = self.starts[cell] as usize..self.starts[cell + 1] as usize;
        if list.is_empty() {
            let (s, t) = (x - i as f64, y - j as f64);
            let at = j * (self.columns + 1) + i;
            let above = at + self.columns + 1;
            let [a, b] = [self.corners[at], self.corners[at + 1]];
            let [c, d] = [self.corners[above], self.corners[above + 1]];
            let (lower, upper) = (a + (b - a) * s, c + (d - c) * s);
            let slope = if WITH_SLOPE {
                [((b - a) * (1.0 - t) + (d - c) * t), upper - lower].map(|x| x * self.per_unit)
            } else {
                [0.0; 2]
            };
            return (lower + (upper - lower) * t, slope);
        }
        let mut best = (f64::INFINITY, [0.0; 2], [0.0; 2]);
        for &k in &self.lists[list] {
            let side = &self.sides[k as usize];
            let from = minus(p, side.ends[0]);
            let t = (dot(from, side.along) * side.inverse).clamp(0.0, 1.0);
            let away = [from[0] - t * side.along[0], from[1] - t * side.along[1]];
            let squared = dot(away, away);
            if squared < best.0 {
                let kind = if t <= 0.0 {
                    1
                } else if t >= 1.0 {
                    2
                } else {
                    0
                };
                best = (squared, away, side.out[kind]);
            }
        }
        let (squared, away, out) = best;
        let distance = if dot(away, out) < 0.0 { -squared.sqrt() } else { squared.sqrt() };
        let slope = if WITH_SLOPE {
            // On the rim itself straight out.
            let [along, length] = if squared > 0.0 {
                [away, [distance; 2]]
            } else {
                [out, [dot(out, out).sqrt(); 2]]
            };
            [along[0] / length[0], along[1] / length[1]]
        } else {
            [0.0; 2]
        };
        (distance, slope)
    }

    /// Disks within the shape that together fill most of it, the largest first: centres at corners of cells, and radii.
    pub fn disks(&self, most: usize) -> Vec<([f64; 2], f64)> {
        let cell = 1.0 / self.per_unit;
        let mut inner: Vec<([f64; 2], f64)> = Vec::new();
        for (at, &distance) in self.corners.iter().enumerate() {
            if distance < 0.0 {
                let (i, j) = (at % (self.columns + 1), at / (self.columns + 1));
                let p = [self.low[0] + i as f64 * cell, self.low[1] + j as f64 * cell];
                inner.push((p, -distance));
            }
        }
        // Stable: of equals the lowest stays first.
        inner.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let mut disks: Vec<([f64; 2], f64)> = Vec::new();
        for (p, r) in inner {
            let is_covered = |(q, s): &([f64; 2], f64)| {
                let away = minus(p, *q);
                dot(away, away) < s * s
            };
            let is_small = disks.first().is_some_and(|(_, largest)| r < 0.1 * largest);
            if disks.len() >= most || is_small {
                break;
            }
            if !disks.iter().any(is_covered) {
                disks.push((p, r));
            }
        }
        disks
    }
}

/// The sides of all outlines with directions out of the shape.
fn outer_sides(outlines: &[Vec<[f64; 2]>]) -> Vec<Side> {
    // Long enough for its square to be a number.
    let is_proper = |[a, b]: &[[f64; 2]; 2]| dot(minus(*b, *a), minus(*b, *a)) > 0.0;
    let mut all = Vec::new();
    for outline in outlines {
        let proper: Vec<[[f64; 2]; 2]> = sides(outline).filter(is_proper).collect();
        let out = |k: usize| {
            let [a, b] = proper[k % proper.len()];
            let [x, y] = minus(b, a);
            let length = x.hypot(y);
            [y / length, -x / length]
        };
        let n = proper.len();
        for k in 0..n {
            let [before, own, after] = [out(k + n - 1), out(k), out(k + 1)];
            // Where an outline turns back on itself both sides of its tip are outside.
            let sum = |s: [f64; 2], t: [f64; 2]| {
                let sum = [s[0] + t[0], s[1] + t[1]];
                if dot(sum, sum) > 1e-20 {
                    sum
                } else {
                    [-s[1], s[0]].map(|x| x * cross(s, t).signum())
                }
            };
            let out = [own, sum(before, own), sum(own, after)];
            let along = minus(proper[k][1], proper[k][0]);
            all.push(Side { ends: proper[k], along, inverse: 1.0 / dot(along, along), out });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::nesting::plane::Dice;

    #[test]
    fn distances_are_exact_where_they_must_be_and_near_elsewhere() {
        // A star with sharp tips and hollows, and a hole.
        let star = |tips: usize, inner: f64, outer: f64, sign: f64| -> Vec<[f64; 2]> {
            let point = |i: usize| {
                let t = sign * std::f64::consts::PI * i as f64 / tips as f64;
                let r = if i.is_multiple_of(2) { outer } else { inner };
                [r * t.cos(), r * t.sin()]
            };
            (0..2 * tips).map(point).collect()
        };
        let outlines = vec![star(7, 30.0, 60.0, 1.0), star(4, 8.0, 12.0, -1.0)];
        for gap in [0.0, 4.0] {
            let field = Field::new(&outlines, [gap, gap + 0.5], 20.0);
            let mut dice = Dice(3);
            let mut exact = 0;
            for _ in 0..4000 {
                let p = [dice.between(-70.0, 70.0), dice.between(-70.0, 70.0)];
                let squared =
                    outlines.iter().flat_map(|o| sides(o)).map(|s| squared_distance(p, s));
                let distance = squared.fold(f64::INFINITY, f64::min).sqrt();
                let signed = if winding(&outlines, p) != 0 { -distance } else { distance };
                let (found, slope) = field.slope(p);
                // Rounding in the band; half a cell of 160 / 64 beyond, where distances are interpolated.
                let tolerance = if (gap..gap + 0.5).contains(&signed) { 1e-12 } else { 1.25 };
                assert!((found - signed).abs() < tolerance, "{p:?} {found} {signed}");
                if tolerance < 1.0 {
                    exact += 1;
                    assert!((slope[0].hypot(slope[1]) - 1.0).abs() < 1e-9);
                    let ahead = [0, 1].map(|k| p[k] + 1e-3 * slope[k]);
                    assert!(field.distance(ahead) > found, "the slope points out");
                }
            }
            assert!(exact > 20, "{exact}");
        }
    }

    #[test]
    fn disks_lie_within_and_fill_a_rectangle() {
        let field =
            Field::new(&[vec![[0.0, 0.0], [40.0, 0.0], [40.0, 10.0], [0.0, 10.0]]], [1.0; 2], 2.0);
        let disks = field.disks(12);
        assert!(disks.len() > 3);
        for ([x, y], r) in disks {
            let room = x.min(40.0 - x).min(y).min(10.0 - y);
            assert!((room - r).abs() < 1e-12, "{x} {y} {r}");
        }
    }
}
