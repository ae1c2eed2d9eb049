//! The shape of a flap over its base, and exact tests of where it lies.

use std::f64::consts::TAU;

use nalgebra::Point2;

use crate::flatten::overlap::{orientation, winding};

/// A top shorter than this is a point, mm.
const POINT_MM: f64 = 1.0;

/// A trapezoid or a triangle on a base, on its right: places from one end of the base to the other.
///
/// **Takes** the ends p, q of the base with the piece on the left, the angles α at p and q, and the depth d. **Gives** p, a, b, q with
/// |ab| = L − d / tan α_p − d / tan α_q, or p, a, q where that is below 1 mm, and the height over the base.
pub(super) fn trapezoid(
    [p, q]: [[f64; 2]; 2],
    [at_p, at_q]: [f64; 2],
    depth: f64,
) -> (Vec<[f64; 2]>, f64) {
    let base = (q[0] - p[0]).hypot(q[1] - p[1]);
    let along = [(q[0] - p[0]) / base, (q[1] - p[1]) / base];
    let place =
        |x: f64, y: f64| [p[0] + x * along[0] + y * along[1], p[1] + x * along[1] - y * along[0]];
    let cotangents = [at_p, at_q].map(|angle| 1.0 / angle.tan());
    let [left, right] = cotangents.map(|c| depth * c);
    if base - left - right < POINT_MM {
        let height = base / (cotangents[0] + cotangents[1]);
        return (vec![p, place(height * cotangents[0], height), q], height);
    }
    (vec![p, place(left, depth), place(base - right, depth), q], depth)
}

/// By how much one direction must be turned left to become another, from 0 to 2π.
pub(in super::super) fn turn_left(from: [f64; 2], to: [f64; 2]) -> f64 {
    let (sin, cos) = (from[0] * to[1] - from[1] * to[0], from[0] * to[0] + from[1] * to[1]);
    let turn = sin.atan2(cos);
    if turn < 0.0 { turn + TAU } else { turn }
}

/// Whether two segments have a point in common; one end that both have does not count by itself.
pub(super) fn meet(s: [[f64; 2]; 2], t: [[f64; 2]; 2]) -> bool {
    let apart = |axis: usize| {
        let range = |u: [[f64; 2]; 2]| (u[0][axis].min(u[1][axis]), u[0][axis].max(u[1][axis]));
        let (s, t) = (range(s), range(t));
        s.1 < t.0 || t.1 < s.0
    };
    if apart(0) || apart(1) {
        return false;
    }
    let [a, b, c, d] = [s[0], s[1], t[0], t[1]].map(Point2::from);
    // A common end first: then the others must lie on one line with it, and on one side.
    for (common, far) in [(a, b), (b, a)] {
        for (other, beyond) in [(c, d), (d, c)] {
            if common == other {
                let is_on_line = !(orientation(common, far, beyond).abs() > 0.0);
                return is_on_line && (far - common).dot(&(beyond - common)) > 0.0;
            }
        }
    }
    let same = |x: f64, y: f64| (x > 0.0 && y > 0.0) || (x < 0.0 && y < 0.0);
    !same(orientation(a, b, c), orientation(a, b, d))
        && !same(orientation(c, d, a), orientation(c, d, b))
}

/// Whether a point lies within a closed polygon.
pub(super) fn contains(polygon: &[[f64; 2]], point: [f64; 2]) -> bool {
    let corners: Vec<Point2<f64>> = polygon.iter().copied().map(Point2::from).collect();
    winding(&corners, Point2::from(point)) != 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

    #[test]
    fn a_flap_is_a_trapezoid_on_the_right_of_its_base_or_a_triangle() {
        let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
        let base = [[0.0, 0.0], [20.0, 0.0]];
        let (points, height) = trapezoid(base, [FRAC_PI_4, FRAC_PI_2], 5.0);
        assert!(
            near(points[1], [5.0, -5.0])
                && near(points[2], [20.0, -5.0])
                && (height - 5.0).abs() < 1e-12
        );
        let (points, height) = trapezoid(base, [FRAC_PI_4; 2], 9.8);
        assert!(points.len() == 3 && near(points[1], [10.0, -10.0]), "{points:?}");
        assert!((height - 10.0).abs() < 1e-12);
    }

    #[test]
    fn segments_meet_in_points_that_are_no_common_end() {
        let cases = [
            ([[0.0, 0.0], [2.0, 0.0]], [[1.0, -1.0], [1.0, 1.0]], true),
            ([[0.0, 0.0], [2.0, 0.0]], [[1.0, 0.0], [1.0, 1.0]], true),
            ([[0.0, 0.0], [2.0, 0.0]], [[2.0, 0.0], [3.0, 1.0]], false),
            ([[0.0, 0.0], [2.0, 0.0]], [[2.0, 0.0], [1.0, 0.0]], true),
            ([[0.0, 0.0], [2.0, 0.0]], [[2.0, 0.0], [3.0, 0.0]], false),
            ([[0.0, 0.0], [2.0, 0.0]], [[0.0, 0.0], [2.0, 0.0]], true),
            ([[0.0, 0.0], [2.0, 0.0]], [[3.0, 0.0], [4.0, 0.0]], false),
            ([[0.0, 0.0], [2.0, 2.0]], [[1.0, 1.5], [0.0, 1.0]], false),
        ];
        for (s, t, expected) in cases {
            for (s, t) in [(s, t), (t, s), ([s[1], s[0]], t), (t, [s[1], s[0]])] {
                assert_eq!(meet(s, t), expected, "{s:?} {t:?}");
            }
        }
    }
}
