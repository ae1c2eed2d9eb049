//! Where outlines cross.
//!
//! A chart without flips whose outline does not cross itself is injective; charts on a sheet whose outlines do not cross
//! either (nor contain each other) do not overlap. Crossings are decided by exact predicates, so a count of zero is a
//! fact about the given coordinates. Outlines that only touch, or run along each other, do not cross.

use nalgebra::{Point2, Vector2};
use robust::{Coord, orient2d};

use super::small;

/// A side of an outline: from corner `side` to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Side {
    /// Which outline.
    pub outline: u32,
    /// Which of its sides.
    pub side: u32,
}

/// All pairs of sides that cross in a point inside both, in increasing order.
///
/// **Takes** closed outlines by their corners, all coordinates finite. **Costs** O(n) for n sides of similar lengths, plus
/// the crossings; a uniform grid finds the candidates.
///
/// ```
/// # use cutflow::flatten::overlap::crossings;
/// # use nalgebra::Point2;
/// let eight = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(Point2::from);
/// assert_eq!(crossings(&[&eight]).len(), 1);
/// ```
pub fn crossings(outlines: &[&[Point2<f64>]]) -> Vec<[Side; 2]> {
    let mut sides = Vec::new();
    for (outline, corners) in outlines.iter().enumerate() {
        for i in 0..corners.len() {
            let name = Side { outline: small(outline), side: small(i) };
            sides.push((name, corners[i], corners[(i + 1) % corners.len()]));
        }
    }
    let Some(grid) = Grid::new(&sides) else { return Vec::new() };
    let mut found = Vec::new();
    for cell in 0..grid.cell_count() {
        let here = grid.sides_in(cell);
        for (i, &s) in here.iter().enumerate() {
            for &t in &here[i + 1..] {
                let (s, t) = (&sides[s as usize], &sides[t as usize]);
                // A pair shares a rectangle of cells; it is looked at in the lower left one.
                if grid.meeting_cell(s, t) == Some(cell) && cross([s.1, s.2], [t.1, t.2]) {
                    found.push([s.0, t.0]);
                }
            }
        }
    }
    found.sort_unstable();
    found
}

/// Whether two segments cross in a point inside both.
pub fn cross(s: [Point2<f64>; 2], t: [Point2<f64>; 2]) -> bool {
    let apart = |[a, b]: [Point2<f64>; 2], [c, d]: [Point2<f64>; 2]| {
        let (left, right) = (orientation(a, b, c), orientation(a, b, d));
        (left > 0.0 && right < 0.0) || (left < 0.0 && right > 0.0)
    };
    apart(s, t) && apart(t, s)
}

/// Positive if a, b, c turn left, negative if right, 0 if exactly on a line.
pub fn orientation(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
}

/// How many whole cells fit into an extent.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
fn cells(extent: f64, cell: f64) -> usize {
    (extent / cell) as usize
}

type Segment = (Side, Point2<f64>, Point2<f64>);

/// Square cells about as wide as a side is long, each with the sides whose boxes touch it.
struct Grid {
    low: Point2<f64>,
    cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    sides: Vec<u32>,
}

impl Grid {
    fn new(sides: &[Segment]) -> Option<Self> {
        let (_, first, _) = sides.first()?;
        let (mut low, mut high, mut total) = (*first, *first, 0.0);
        for (_, a, b) in sides {
            low = low.inf(a);
            high = high.sup(a);
            total += (b - a).norm();
        }
        // As wide as the mean side, but no more cells than four for each side.
        let extent: Vector2<f64> = high - low;
        let count = sides.len() as f64;
        let cell = (total / count)
            .max((extent.x * extent.y / (4.0 * count)).sqrt())
            .max((extent.x + extent.y) / (2.0 * count));
        if !(cell > 0.0 && cell.is_finite()) {
            return None;
        }
        let [columns, rows] = [extent.x, extent.y].map(|e| cells(e, cell) + 1);
        let mut grid = Self {
            low,
            cell,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            sides: Vec::new(),
        };
        let mut entries = Vec::new();
        for (i, side) in sides.iter().enumerate() {
            let [[x, y], [to_x, to_y]] = grid.range(side);
            for row in y..=to_y {
                for column in x..=to_x {
                    entries.push((row * columns + column, small(i)));
                    grid.starts[row * columns + column + 1] += 1;
                }
            }
        }
        for cell in 0..grid.cell_count() {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        grid.sides = vec![0; entries.len()];
        let mut next = grid.starts.clone();
        for (cell, side) in entries {
            grid.sides[next[cell] as usize] = side;
            next[cell] += 1;
        }
        Some(grid)
    }

    fn cell_count(&self) -> usize {
        self.columns * self.rows
    }

    fn sides_in(&self, cell: usize) -> &[u32] {
        &self.sides[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// First and last column and row of a side's box.
    fn range(&self, (_, a, b): &Segment) -> [[usize; 2]; 2] {
        let cell = |x: f64, low: f64, count: usize| cells(x - low, self.cell).min(count - 1);
        [a.inf(b), a.sup(b)]
            .map(|p| [cell(p.x, self.low.x, self.columns), cell(p.y, self.low.y, self.rows)])
    }

    /// The lower left cell that both boxes touch.
    fn meeting_cell(&self, s: &Segment, t: &Segment) -> Option<usize> {
        let ([from, to], [other_from, other_to]) = (self.range(s), self.range(t));
        let [x, y] = [0, 1].map(|i| from[i].max(other_from[i]));
        let meets = x <= to[0].min(other_to[0]) && y <= to[1].min(other_to[1]);
        meets.then_some(y * self.columns + x)
    }
}
