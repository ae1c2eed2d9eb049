//! Which triangles overlap, exactly.
//!
//! The insides of two triangles are disjoint if and only if the line through a side of one of them has the other one on its outer
//! side (sides of the Minkowski difference are sides of the two). So signs of orientations decide, whatever the triangles share: nothing
//! is special about neighbours, nor about triangles that meet in a corner.

use nalgebra::{Point2, Vector2};

use super::super::small;
use super::tree::{Bounds, Tree};
use super::{orientation, turn};

/// Two triangles whose insides have points in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePair {
    /// The triangles, in increasing order.
    pub triangles: [u32; 2],
    /// Area of what they have in common, to rounding.
    pub area: f64,
}

/// All pairs of triangles whose insides have a point in common, in increasing order.
///
/// **Takes** triangles with finite corners, of either orientation, so large or small that products of three coordinates neither
/// overflow nor vanish. One without area has no inside. **Gives** exact pairs; areas to rounding. **Costs** O(n log n), and the pairs.
///
/// ```
/// # use cutflow::flatten::overlap::overlapping_triangles;
/// # use nalgebra::Point2;
/// let [o, x, y, xy] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(Point2::from);
/// // Neighbours across a side do not overlap; one that is turned over covers half of the other.
/// assert!(overlapping_triangles(&[[o, x, y], [y, x, xy]]).is_empty());
/// let pairs = overlapping_triangles(&[[o, x, y], [o, xy, x]]);
/// assert_eq!((pairs.len(), pairs[0].area), (1, 0.25));
/// ```
pub fn overlapping_triangles(triangles: &[[Point2<f64>; 3]]) -> Vec<TrianglePair> {
    let mut pairs = Vec::new();
    for_overlapping(triangles, |_, _| true, |pair| pairs.push(pair));
    pairs.sort_unstable_by_key(|pair| pair.triangles);
    pairs
}

/// Calls with each pair of triangles that overlap among those wanted, in an order that depends on the triangles only.
pub(in super::super) fn for_overlapping(
    triangles: &[[Point2<f64>; 3]],
    is_wanted: impl Fn(u32, u32) -> bool,
    mut call: impl FnMut(TrianglePair),
) {
    let mut names = Vec::with_capacity(triangles.len());
    let mut turned = Vec::with_capacity(triangles.len());
    for (i, &[a, b, c]) in triangles.iter().enumerate() {
        let sign = orientation(a, b, c);
        if sign.abs() > 0.0 {
            names.push(small(i));
            turned.push(if sign > 0.0 { [a, b, c] } else { [a, c, b] });
        }
    }
    let boxes: Vec<Bounds> = turned.iter().map(|t| Bounds::of(t)).collect();
    Tree::new(&boxes).for_pairs(|i, j| {
        let pair = [names[i as usize], names[j as usize]];
        let (s, t) = (i as usize, j as usize);
        if is_wanted(pair[0], pair[1])
            && boxes[s].overlaps(&boxes[t])
            && !has_outside(&turned[s], &turned[t])
            && !has_outside(&turned[t], &turned[s])
        {
            call(TrianglePair { triangles: pair, area: common_area(&turned[s], &turned[t]) });
        }
    });
}

/// Whether a side of the first triangle has all of the second one on its outer side, or on itself.
fn has_outside(s: &[Point2<f64>; 3], t: &[Point2<f64>; 3]) -> bool {
    (0..3).any(|i| t.iter().all(|&p| turn(s[i], s[(i + 1) % 3], p) <= 0.0))
}

/// Area of the intersection of two counter-clockwise triangles: one is clipped at the sides of the other.
fn common_area(s: &[Point2<f64>; 3], t: &[Point2<f64>; 3]) -> f64 {
    let origin = s[0];
    let corner = |p: &Point2<f64>| p - origin;
    // A triangle clipped three times has six corners at most.
    let mut polygon = [Vector2::zeros(); 9];
    let mut count = 3;
    for (corner_of, p) in polygon.iter_mut().zip(t) {
        *corner_of = corner(p);
    }
    for i in 0..3 {
        let (a, b) = (corner(&s[i]), corner(&s[(i + 1) % 3]));
        let height = |p: &Vector2<f64>| (b - a).perp(&(p - a));
        let before = polygon;
        let had = count;
        count = 0;
        for k in 0..had {
            let (p, q) = (before[k], before[(k + 1) % had]);
            let (from, to) = (height(&p), height(&q));
            if from >= 0.0 {
                polygon[count] = p;
                count += 1;
            }
            // Rounding may find more crossings than two.
            if (from > 0.0 && to < 0.0 || from < 0.0 && to > 0.0) && count < polygon.len() {
                polygon[count] = p + (q - p) * (from / (from - to));
                count += 1;
            }
            if count == polygon.len() {
                break;
            }
        }
    }
    let doubled: f64 = (1..count.saturating_sub(1))
        .map(|k| (polygon[k] - polygon[0]).perp(&(polygon[k + 1] - polygon[0])))
        .sum();
    (0.5 * doubled).max(0.0)
}
