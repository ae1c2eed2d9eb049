//! Unions of polygons that keep the points they were made of.
//!
//! Coordinates are rounded to a grid of a power of two, 2⁻⁴⁴ of the largest coordinate (6·10⁻¹² mm on a sheet of 100 mm), and the
//! union is computed on it with integers. (The float interface of the same crate rounds to 29 bits by default, 2·10⁻⁷ mm on that sheet, and
//! gives back points that are no longer those it was given.) A point of the result that was a point of the input is that very
//! point again, to the last bit.

use std::collections::BTreeMap;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

use crate::pattern::plane::{area, cross, distance, minus};

/// Bits of the largest coordinate on the grid; the engine takes up to 61.
const BITS: i32 = 44;
/// Points of the result nearer to each other than this, or to the line through their neighbours, are dropped, mm.
const FINE_MM: f64 = 1e-6;

/// A polygon with holes: the outer contour counter-clockwise first, then the holes clockwise.
pub(crate) type Shape = Vec<Vec<[f64; 2]>>;

/// Everything about which the contours wind (nonzero), largest part first.
///
/// **Takes** closed contours, finite; points that must not be dropped from the result, `kept`. **Costs** O(n log n) for contours that
/// cross little.
pub(crate) fn union<'a>(
    contours: impl Iterator<Item = &'a [[f64; 2]]> + Clone,
    kept: impl Iterator<Item = [f64; 2]>,
) -> Vec<Shape> {
    let largest = contours.clone().flatten().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return Vec::new();
    }
    // A power of two: scaling rounds nothing.
    let exponent = BITS - 1 - exponent(largest);
    let (scale, back) = (2.0_f64.powi(exponent), 2.0_f64.powi(-exponent));
    #[expect(clippy::cast_possible_truncation, reason = "within 2^44 by the choice of the scale")]
    let grid = |p: [f64; 2]| p.map(|x| (x * scale).round() as i64);
    let mut known = BTreeMap::new();
    let mut fixed = BTreeMap::new();
    for p in kept {
        known.entry(grid(p)).or_insert(p);
        fixed.insert(grid(p), ());
    }
    let options = IntOverlayOptions {
        preserve_input_collinear: true,
        preserve_output_collinear: true,
        ..IntOverlayOptions::default()
    };
    let count = contours.clone().map(<[_]>::len).sum();
    let mut overlay = Overlay::<i64>::new_custom(count, options, Default::default());
    for contour in contours {
        for &p in contour {
            known.entry(grid(p)).or_insert(p);
        }
        let points = contour.iter().map(|&p| {
            let [x, y] = grid(p);
            IntPoint::new(x, y)
        });
        overlay.add_path_iter(points, ShapeType::Subject);
    }
    #[expect(clippy::cast_precision_loss, reason = "within 2^44")]
    let place = |p: &IntPoint<i64>| {
        let key = [p.x, p.y];
        let place = known.get(&key).copied().unwrap_or([p.x as f64 * back, p.y as f64 * back]);
        (place, fixed.contains_key(&key))
    };
    let shapes = overlay.overlay(OverlayRule::Subject, FillRule::NonZero);
    let shapes = shapes.iter().map(|shape| {
        let contours = shape.iter().map(|c| tidy(c.iter().map(place).collect()));
        contours.filter(|c| c.len() > 2).collect::<Shape>()
    });
    let mut shapes: Vec<Shape> = shapes.filter(|shape| !shape.is_empty()).collect();
    shapes.sort_by(|a, b| area(&b[0]).total_cmp(&area(&a[0])));
    shapes
}

/// The exponent e with 2^(e − 1) ≤ x < 2^e or so: never too small.
fn exponent(x: f64) -> i32 {
    let mut e = 0;
    let mut power = 1.0;
    while power <= x {
        power *= 2.0;
        e += 1;
    }
    while power > 2.0 * x && e > -60 {
        power *= 0.5;
        e -= 1;
    }
    e
}

/// Drops what the eye of a machine does not see: points on each other, and points on the line between their neighbours.
/// Points marked as fixed stay.
fn tidy(points: Vec<([f64; 2], bool)>) -> Vec<[f64; 2]> {
    let mut out: Vec<([f64; 2], bool)> = Vec::with_capacity(points.len());
    for &(p, is_fixed) in &points {
        if let Some(&(q, was_fixed)) = out.last()
            && distance(p, q) < FINE_MM
        {
            match (was_fixed, is_fixed) {
                (_, false) => continue,
                (false, true) => {
                    out.pop();
                }
                (true, true) => {}
            }
        }
        out.push((p, is_fixed));
    }
    while out.len() > 1 && distance(out[0].0, out[out.len() - 1].0) < FINE_MM {
        let last = out.len() - 1;
        if !out[last].1 {
            out.pop();
        } else if !out[0].1 {
            out.remove(0);
        } else {
            break;
        }
    }
    // Against the last point that was kept, so that a run of tiny steps on a curve does not vanish as a whole.
    let n = out.len();
    let mut kept: Vec<[f64; 2]> = Vec::with_capacity(n);
    for i in 0..n {
        let (p, is_fixed) = out[i];
        let before = kept.last().copied().unwrap_or(out[n - 1].0);
        let after = out[(i + 1) % n].0;
        let chord = minus(after, before);
        let off = cross(chord, minus(p, before)).abs();
        if is_fixed || !(off <= FINE_MM * chord[0].hypot(chord[1])) {
            kept.push(p);
        }
    }
    kept
}
