//! Where outlines cross, and which triangles overlap.
//!
//! A chart without flips is injective if its outline is a simple curve; charts on a sheet whose outlines do not meet, nor contain
//! each other, do not overlap. Crossings of outlines are cheap to find, but outlines that touch, or run along each other, may bound charts
//! that overlap or not: there, and where pairs and areas are asked for, triangles decide ([`overlapping_triangles`]).
//!
//! Everything is decided by exact predicates, so a count of zero is a fact about the given coordinates.

mod tree;
mod triangles;

use nalgebra::Point2;
use robust::{Coord, orient2d};

use super::small;

pub(super) use tree::{Bounds, Tree};
pub(super) use triangles::for_overlapping;
pub use triangles::{TrianglePair, overlapping_triangles};

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
/// Outlines that only touch, or run along each other, do not cross: see [`contacts`].
///
/// **Takes** closed outlines by their corners, all coordinates finite. **Costs** O(n log n) for n sides, plus the crossings.
///
/// ```
/// # use cutflow::flatten::overlap::crossings;
/// # use nalgebra::Point2;
/// let eight = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(Point2::from);
/// assert_eq!(crossings(&[&eight]).len(), 1);
/// ```
pub fn crossings(outlines: &[&[Point2<f64>]]) -> Vec<[Side; 2]> {
    contacts(outlines).crossings
}

/// How outlines meet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Pairs of sides that cross in a point inside both, in increasing order.
    pub crossings: Vec<[Side; 2]>,
    /// Pairs of sides that have points in common but do not cross, in increasing order. For two sides that follow each other
    /// the corner between them does not count.
    pub touches: Vec<[Side; 2]>,
}

/// All pairs of sides that meet. Without any, all outlines are simple curves that do not meet each other.
///
/// **Takes** closed outlines by their corners, all coordinates finite. **Costs** O(n log n) for n sides, plus the pairs.
pub fn contacts(outlines: &[&[Point2<f64>]]) -> Contacts {
    let mut sides = Vec::new();
    for (outline, corners) in outlines.iter().enumerate() {
        for i in 0..corners.len() {
            let name = Side { outline: small(outline), side: small(i) };
            sides.push((name, [corners[i], corners[(i + 1) % corners.len()]]));
        }
    }
    let follows = |s: Side, t: Side| {
        let count = outlines[s.outline as usize].len();
        s.outline == t.outline && (s.side as usize + 1) % count == t.side as usize
    };
    let boxes: Vec<Bounds> = sides.iter().map(|(_, ends)| Bounds::of(ends)).collect();
    let mut contacts = Contacts::default();
    Tree::new(&boxes).for_pairs(|i, j| {
        let ((s, [a, b]), (t, [c, d])) = (sides[i as usize], sides[j as usize]);
        // Signs at both ends: of different sign, they lie on both sides.
        let ends = [turn(a, b, c), turn(a, b, d)];
        let apart = |[x, y]: [f64; 2]| (x > 0.0 && y > 0.0) || (x < 0.0 && y < 0.0);
        if apart(ends) {
            return;
        }
        let others = [turn(c, d, a), turn(c, d, b)];
        if apart(others) {
            return;
        }
        let is_zero = |x: &f64| !(x.abs() > 0.0);
        if !ends.iter().chain(&others).any(is_zero) {
            contacts.crossings.push([s, t]);
            return;
        }
        // On one line, or an end of one side on the other one: their boxes meet, so they do.
        let touches = match (follows(s, t), follows(t, s)) {
            (true, true) => true,
            (true, false) => folds(a, b, d),
            (false, true) => folds(c, d, b),
            (false, false) => true,
        };
        if touches {
            contacts.touches.push([s, t]);
        }
    });
    contacts.crossings.sort_unstable();
    contacts.touches.sort_unstable();
    contacts
}

/// Whether the way from a to b goes back on itself towards c.
fn folds(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> bool {
    let (back, on) = (a - b, c - b);
    // The larger coordinate of a direction decides, and its sign is exact.
    let axis = usize::from(back.y.abs() > back.x.abs());
    let is_on_line = !(turn(a, b, c).abs() > 0.0);
    is_on_line && back[axis].signum() * on[axis] > 0.0
}

/// How often an outline winds about a point that does not lie on it, counter-clockwise.
pub fn winding(outline: &[Point2<f64>], point: Point2<f64>) -> i32 {
    let mut winding = 0;
    for (i, &a) in outline.iter().enumerate() {
        let b = outline[(i + 1) % outline.len()];
        if a.y <= point.y && b.y > point.y && turn(a, b, point) > 0.0 {
            winding += 1;
        } else if a.y > point.y && b.y <= point.y && turn(a, b, point) < 0.0 {
            winding -= 1;
        }
    }
    winding
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

/// The sign of [`orientation`], for long loops over easy cases.
#[inline]
fn turn(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> f64 {
    let (left, right) = ((a.x - c.x) * (b.y - c.y), (a.y - c.y) * (b.x - c.x));
    let turn = left - right;
    // Twice Shewchuk's bound of the rounding error.
    if turn.abs() > 6.7e-16 * (left.abs() + right.abs()) {
        turn
    } else if a == c || b == c || a == b {
        0.0
    } else {
        orientation(a, b, c)
    }
}
