//! Kerf: the beam takes away material on both sides of its line, so the line is moved outwards by half of its width.

use i_overlay::mesh::float::outline::offset::OutlineOffset;
use i_overlay::mesh::float::style::{LineJoin, OutlineStyle};

use super::folds::simplified;

/// Corners sharper than this are cut off, radians: their tip would lie far beyond the piece.
const SHARPEST: f64 = std::f64::consts::PI / 6.0;
/// Turns up to this keep one point, radians. Rounder corners would get two points less than a nanometre apart.
const STRAIGHT: f64 = 1e-6;
/// Points that lie beside a side by less than this are left out, mm.
const ROUNDING_MM: f64 = 1e-5;

/// Outlines of what is left when a beam of width k runs along them: outer outlines grow by k / 2, holes shrink by it.
///
/// **Takes** the outlines of one piece, outer ones counter-clockwise, holes clockwise, and the width in mm. **Gives** closed outlines of the same
/// orientations, corners kept sharp down to 30°; each outer one is followed by its holes. Where k is not positive, or anything not
/// finite, the outlines as they were. **Costs** O(n log n). **Differs** from moving each side by itself: holes narrower than k vanish,
/// and so do slits, which the beam could not leave open. Coordinates are rounded to about 1e-9 of the extent.
pub fn kerf(outlines: &[Vec<[f64; 2]>], width_mm: f64) -> Vec<Vec<[f64; 2]>> {
    let is_finite = outlines.iter().flatten().flatten().all(|x| x.is_finite());
    let is_wanted = width_mm > 0.0 && width_mm.is_finite();
    let has_area = outlines.iter().any(|outline| outline.len() > 2);
    if !(is_finite && is_wanted && has_area) {
        return outlines.to_vec();
    }
    let style = OutlineStyle::new(0.5 * width_mm)
        .line_join(LineJoin::Miter(SHARPEST))
        .miter_min_turn(STRAIGHT);
    let shapes = outlines.to_vec().outline_as::<i64>(&style);
    shapes.into_iter().flatten().map(|ring| without_straight(&ring)).collect()
}

/// Joins leave points on straight sides, off by rounding.
fn without_straight(ring: &[[f64; 2]]) -> Vec<[f64; 2]> {
    // The lowest point of a ring is a corner of it.
    let low = |&i: &usize| (ring[i][1], ring[i][0]);
    let by_height = |a: &usize, b: &usize| {
        let (a, b) = (low(a), low(b));
        a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
    };
    let Some(first) = (0..ring.len()).min_by(by_height) else { return Vec::new() };
    let around: Vec<[f64; 2]> = (0..=ring.len()).map(|i| ring[(first + i) % ring.len()]).collect();
    let kept = simplified(&around, ROUNDING_MM);
    kept[..kept.len() - 1].iter().map(|&i| around[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[[f64; 2]]) -> f64 {
        let n = points.len();
        let cross = |i: usize| {
            let (a, b) = (points[i], points[(i + 1) % n]);
            a[0] * b[1] - a[1] * b[0]
        };
        0.5 * (0..n).map(cross).sum::<f64>()
    }

    #[test]
    fn a_frame_grows_outside_and_its_hole_shrinks() {
        let outer = vec![[0.0, 0.0], [100.0, 0.0], [100.0, 50.0], [0.0, 50.0]];
        let hole = vec![[10.0, 10.0], [10.0, 40.0], [90.0, 40.0], [90.0, 10.0]];
        let cut = kerf(&[outer.clone(), hole.clone()], 0.2);
        assert_eq!(cut.len(), 2);
        // Coordinates are rounded to about 1e-9 of 100 mm.
        assert!((area(&cut[0]) - 100.2 * 50.2).abs() < 1e-3, "{}", area(&cut[0]));
        assert!((area(&cut[1]) + 79.8 * 29.8).abs() < 1e-3, "{}", area(&cut[1]));
        assert!(cut.iter().all(|outline| outline.len() == 4), "{cut:?}");
        for width in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(kerf(&[outer.clone(), hole.clone()], width), [outer.clone(), hole.clone()]);
        }
        // A beam wider than the hole cannot leave it open.
        assert_eq!(kerf(&[outer, hole], 31.0).len(), 1);
        assert!(kerf(&[], 0.2).is_empty());
    }

    #[test]
    fn a_round_outline_keeps_its_number_of_points_and_its_distance() {
        let n = 720;
        let circle: Vec<[f64; 2]> = (0..n)
            .map(|i| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / f64::from(n)).sin_cos();
                [50.0 * cos, 50.0 * sin]
            })
            .collect();
        let cut = kerf(&[circle], 0.3);
        assert_eq!((cut.len(), cut[0].len()), (1, 720));
        // A mitre over half a degree adds a part of 1e-5 of 0.15 mm; rounding less.
        assert!(cut[0].iter().all(|p| (p[0].hypot(p[1]) - 50.15).abs() < 1e-4));
    }
}
