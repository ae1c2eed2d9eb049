//! Fitted curves stay within their tolerance both ways, meet corners exactly, keep lengths, and cross nothing new.
#![allow(clippy::float_cmp, reason = "what must be equal to the last bit is compared so")]

use std::f64::consts::TAU;

use cutflow::pattern::Outline;
use cutflow::pattern::curve::{Fitted, corners, fit, turns};

use super::pattern_allowance::{circle, piece};
use super::patterns::{box_with_lid, pillow, slit_prism};

fn point(c: [[f64; 2]; 4], t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    let w = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    [0, 1].map(|a| (0..4).map(|i| w[i] * c[i][a]).sum())
}

/// Samples of the curve, each cubic by as many chords.
fn samples(fitted: &Fitted, parts: u32) -> Vec<[f64; 2]> {
    let mut at = fitted.points[0];
    let mut out = vec![at];
    for c in &fitted.curve {
        out.extend(
            (1..=parts).map(|k| point([at, c[0], c[1], c[2]], f64::from(k) / f64::from(parts))),
        );
        at = c[2];
    }
    out
}

fn off(p: [f64; 2], line: &[[f64; 2]]) -> f64 {
    let side = |s: &[[f64; 2]]| {
        let d = [s[1][0] - s[0][0], s[1][1] - s[0][1]];
        let size = (d[0] * d[0] + d[1] * d[1]).max(1e-300);
        let t = (((p[0] - s[0][0]) * d[0] + (p[1] - s[0][1]) * d[1]) / size).clamp(0.0, 1.0);
        (p[0] - s[0][0] - t * d[0]).hypot(p[1] - s[0][1] - t * d[1])
    };
    line.windows(2).map(side).fold(f64::INFINITY, f64::min)
}

fn length(line: &[[f64; 2]]) -> f64 {
    line.windows(2).map(|s| (s[1][0] - s[0][0]).hypot(s[1][1] - s[0][1])).sum()
}

/// Everything that is promised, by samples.
fn check(points: &[[f64; 2]], is_closed: bool, kept: &[usize], tolerance: f64) -> Fitted {
    let fitted = fit(points, is_closed, kept, tolerance);
    let mut line = points.to_vec();
    if is_closed {
        line.push(points[0]);
    }
    let curve = samples(&fitted, 100);
    // The chords of the samples are off by far less than this.
    let most = tolerance * 1.001 + 1e-9;
    for &p in &line {
        assert!(off(p, &curve) <= most, "{p:?} is {} off the curve", off(p, &curve));
    }
    for &p in &curve {
        assert!(off(p, &line) <= most, "the curve is {} off at {p:?}", off(p, &line));
    }
    // The flattening lies on the curve and its chords are near it.
    let mut flat = fitted.points.clone();
    if is_closed {
        flat.push(flat[0]);
    }
    for &p in &curve {
        assert!(off(p, &flat) <= 0.05_f64.min(tolerance) + 1e-9);
    }
    for (corner, at) in kept.iter().zip(&fitted.corners) {
        assert_eq!(points[*corner], fitted.points[*at]);
    }
    assert_eq!(kept.len(), fitted.corners.len());
    assert_eq!(fitted.points[0], points[0]);
    // Chords of these samples lose 2e-8 of a bend of one radian.
    let longer = length(&samples(&fitted, 2000)) - length(&line);
    assert!(longer.abs() < 0.0501 && (longer - fitted.longer_mm).abs() < 1e-3, "{longer}");
    fitted
}

/// Largest turn between one cubic and the next, corners left out.
fn kink(fitted: &Fitted, is_closed: bool) -> f64 {
    let mut at = fitted.points[0];
    let mut ends = Vec::new();
    for c in &fitted.curve {
        ends.push((
            [c[0][0] - at[0], c[0][1] - at[1]],
            [c[2][0] - c[1][0], c[2][1] - c[1][1]],
            c[2],
        ));
        at = c[2];
    }
    let n = ends.len();
    let corner = |p: [f64; 2]| fitted.corners.iter().any(|&c| fitted.points[c] == p);
    let joints = if is_closed { n } else { n - 1 };
    (0..joints)
        .filter(|&i| !corner(ends[i].2))
        .map(|i| {
            let (u, v) = (ends[i].1, ends[(i + 1) % n].0);
            (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1]).abs()
        })
        .fold(0.0, f64::max)
}

#[test]
fn circles_become_a_few_smooth_cubics() {
    for (n, r, tolerance) in
        [(400, 50.0, 0.1), (60, 30.0, 0.2), (400, 0.5, 0.01), (400, 2500.0, 0.1)]
    {
        let fitted = check(&circle(n, [r, -r], r), true, &[], tolerance);
        assert_eq!(fitted.kept, 0, "{n} {r}");
        assert!(fitted.curve.len() <= 64, "{}", fitted.curve.len());
        assert!(kink(&fitted, true) < 1e-6);
    }
}

#[test]
fn straight_sides_and_corners_stay_exact() {
    let square: Vec<[f64; 2]> = (0..400)
        .map(|i| {
            let t = f64::from(i % 100) * 0.37;
            [[t, 0.0], [37.0, t], [37.0 - t, 37.0], [0.0, 37.0 - t]][i as usize / 100]
        })
        .collect();
    assert_eq!(turns(&square, true), [0, 100, 200, 300]);
    let fitted = check(&square, true, &[0, 100, 200, 300], 0.1);
    assert_eq!((fitted.curve.len(), fitted.points.len(), fitted.kept), (4, 4, 0));
}

#[test]
fn open_runs_with_bends_of_all_sizes_are_fitted() {
    let wave: Vec<[f64; 2]> = (0..=300)
        .map(f64::from)
        .map(|x| [x, 20.0 * (x / 30.0).sin() + 3.0 * (x / 11.0).cos()])
        .collect();
    for tolerance in [0.5, 0.1, 0.02] {
        let fitted = check(&wave, false, &[], tolerance);
        assert_eq!(fitted.kept, 0, "{tolerance}");
        assert!(fitted.curve.len() < 60, "{}", fitted.curve.len());
        assert!(kink(&fitted, false) < 1e-6);
        assert_eq!(fitted.points[fitted.points.len() - 1], wave[300]);
    }
}

#[test]
fn noise_beyond_the_lengths_of_seams_stays_a_polyline() {
    let zigzag: Vec<[f64; 2]> =
        (0..200).map(|i| [f64::from(i), if i % 2 == 0 { 0.0 } else { 0.4 }]).collect();
    let fitted = check(&zigzag, false, &[], 0.5);
    assert_eq!((fitted.kept, fitted.points.len()), (1, 200));
    assert_eq!(fitted.points, zigzag);
}

#[test]
fn partners_of_equal_length_keep_it_to_a_tenth() {
    // Two sides of a seam of a ball: the same lengths of sides, bent differently, started elsewhere.
    let sides = 240;
    let make = |bend: f64, wobble: f64| {
        let (mut at, mut angle) = ([0.0, 0.0], 0.0_f64);
        let mut points = vec![at];
        for i in 0..sides {
            let s = f64::from(i) / f64::from(sides);
            let step = 1.3 + 0.3 * (TAU * 3.0 * s).sin();
            angle += bend * TAU / f64::from(sides) * (1.0 + wobble * (TAU * 5.0 * s).cos());
            at = [at[0] + step * angle.cos(), at[1] + step * angle.sin()];
            points.push(at);
        }
        points
    };
    for (a, b) in [((0.9, 0.5), (-0.7, 0.3)), ((0.5, 2.0), (0.1, 0.0)), ((-0.95, 1.0), (0.9, -1.0))]
    {
        for tolerance in [0.3, 0.1, 0.05] {
            let [p, q] =
                [a, b].map(|(bend, wobble)| check(&make(bend, wobble), false, &[], tolerance));
            assert_eq!((p.kept, q.kept), (0, 0));
            let [long, other] = [&p, &q].map(|f| length(&samples(f, 400)));
            assert!((long - other).abs() < 0.1, "{long} {other}");
        }
    }
}

#[test]
fn a_thin_strip_gets_no_crossing() {
    // A hairpin of 0.3 mm: a tolerance of 1 mm would let its sides cross.
    let mut points: Vec<[f64; 2]> =
        (0..=60).map(f64::from).map(|x| [x, 4.0 * (x / 6.0).sin()]).collect();
    let back: Vec<[f64; 2]> = points.iter().rev().map(|p| [p[0], p[1] + 0.3]).collect();
    let ends = [0, 60, 61, 121];
    points.extend(back);
    let fitted = fit(&points, true, &ends, 1.0);
    let shape = piece(std::slice::from_ref(&fitted.points));
    let sides: Vec<_> = shape.outlines[0].sides().collect();
    let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    for (i, s) in sides.iter().enumerate() {
        for t in &sides[i + 1..] {
            let apart = |s: &([f64; 2], [f64; 2]), t: &([f64; 2], [f64; 2])| {
                cross(s.0, s.1, t.0) * cross(s.0, s.1, t.1) >= 0.0
            };
            assert!(apart(s, t) || apart(t, s), "{s:?} {t:?}");
        }
    }
}

#[test]
fn examples_keep_their_corners_and_ends_of_seams() {
    for example in [box_with_lid(), pillow(), slit_prism()] {
        let (pattern, _) = example.pattern(80.0);
        for piece in &pattern.pieces {
            for (o, outline) in piece.outlines.iter().enumerate() {
                let kept = corners(piece, o);
                for seam in piece.seams.iter().filter(|s| s.outline == o) {
                    assert!(kept.contains(&seam.first));
                }
                check(&outline.points, true, &kept, 0.2);
            }
        }
    }
}

#[test]
fn corners_are_found_in_noise_and_not_on_circles() {
    assert!(turns(&circle(400, [0.0; 2], 50.0), true).is_empty());
    assert!(turns(&circle(400, [0.0; 2], 0.2), true).is_empty());
    assert_eq!(turns(&circle(6, [0.0; 2], 50.0), true).len(), 6);
    assert_eq!(turns(&[[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]], false), [1]);
    // Steps of 0.02 mm across a straight line are none.
    let steps: Vec<[f64; 2]> =
        (0..500).map(|i| [0.1 * f64::from(i), 0.02 * f64::from(i % 2)]).collect();
    assert!(turns(&steps, false).is_empty());
}

#[test]
fn what_is_no_polyline_comes_back_as_it_is() {
    assert_eq!(fit(&[], true, &[], 0.1).points, Vec::<[f64; 2]>::new());
    assert_eq!(fit(&[[1.0, 2.0]], false, &[0], 0.1).points, [[1.0, 2.0]]);
    let triangle = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]];
    for tolerance in [0.0, -1.0, f64::NAN] {
        let fitted = fit(&triangle, true, &[0, 1, 2, 99], tolerance);
        assert_eq!(fitted.points, triangle);
    }
    // Points on each other.
    let twice = [[0.0, 0.0], [0.0, 0.0], [3.0, 0.0], [3.0, 0.0], [0.0, 4.0]];
    let fitted = fit(&twice, true, &[], 0.1);
    assert!(fitted.curve.iter().flatten().flatten().all(|x| x.is_finite()));
    assert!(Outline { points: fitted.points, vertices: Vec::new() }.area_mm2() > 5.0);
}
