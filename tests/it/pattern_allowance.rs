//! Cut lines keep what they promise: away from the sew line by the allowance, never in the piece, one simple outline.
#![allow(clippy::float_cmp, reason = "what must be equal to the last bit is compared so")]

use std::f64::consts::TAU;

use cutflow::pattern::allowance::{
    AllowanceParams, Corner, CutLines, CutNotice, cut_lines, darts, draw_clips, draw_darts,
};
use cutflow::pattern::{Bounds, Layer, Outline, Partner, Piece, Seam};

use super::patterns::{box_with_lid, cut_square, pillow, slit_prism};

/// A piece with the given outlines and no seams.
pub(super) fn piece(outlines: &[Vec<[f64; 2]>]) -> Piece {
    let outlines: Vec<Outline> = outlines
        .iter()
        .map(|points| Outline { points: points.clone(), vertices: Vec::new() })
        .collect();
    Piece {
        patch: 0,
        name: "A".into(),
        seams: Vec::new(),
        area_mm2: outlines.iter().map(Outline::area_mm2).sum(),
        bounds: Bounds::around(outlines.iter().flat_map(|o| o.points.iter().copied())),
        centre: [0.0; 2],
        room_mm: 0.0,
        crossings: 0,
        outlines,
    }
}

/// A seam along a run of an outline of a piece, as long on the surface as in the plane.
pub(super) fn seam(
    piece: &Piece,
    number: usize,
    partner: Partner,
    first: usize,
    sides: usize,
) -> Seam {
    let points = piece.outlines[0].run(first, sides);
    let mut arcs_mm = vec![0.0];
    for p in points.windows(2) {
        arcs_mm.push(arcs_mm[arcs_mm.len() - 1] + (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]));
    }
    let length_mm = arcs_mm[sides];
    Seam {
        number,
        partner,
        outline: 0,
        first,
        sides,
        is_closed: sides == piece.outlines[0].points.len(),
        is_second: partner == Partner::Own { is_second: true },
        length_mm,
        surface_length_mm: length_mm,
        arcs_mm,
    }
}

fn rectangle(low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 2]> {
    vec![low, [high[0], low[1]], high, [low[0], high[1]]]
}

pub(super) fn circle(n: usize, centre: [f64; 2], r: f64) -> Vec<[f64; 2]> {
    let at = |i: usize| TAU * i as f64 / n as f64;
    (0..n).map(|i| [centre[0] + r * at(i).cos(), centre[1] + r * at(i).sin()]).collect()
}

fn backwards(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.reverse();
    points
}

pub(super) fn uniform(piece: &Piece, w: f64) -> Vec<Vec<f64>> {
    piece.outlines.iter().map(|o| vec![w; o.points.len()]).collect()
}

fn area(cut: &CutLines) -> f64 {
    let outline = |points: &Vec<[f64; 2]>| {
        Outline { points: points.clone(), vertices: Vec::new() }.area_mm2()
    };
    cut.outlines.iter().map(outline).sum()
}

/// Distance of a point from a polyline's sides.
fn off(p: [f64; 2], outlines: &[Vec<[f64; 2]>]) -> f64 {
    let mut least = f64::INFINITY;
    for points in outlines {
        for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
            let d = [b[0] - a[0], b[1] - a[1]];
            let t = ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]);
            let t = t.clamp(0.0, 1.0);
            least = least.min((p[0] - a[0] - t * d[0]).hypot(p[1] - a[1] - t * d[1]));
        }
    }
    least
}

/// Samples of a closed polyline.
fn samples(points: &[[f64; 2]]) -> impl Iterator<Item = [f64; 2]> + '_ {
    points.iter().zip(points.iter().cycle().skip(1)).flat_map(|(a, b)| {
        (0..3).map(move |k| f64::from(k) / 3.0).map(|t| [0, 1].map(|i| a[i] + t * (b[i] - a[i])))
    })
}

/// Measures a cut line with one width against its piece, by samples and by nothing of the code under test.
fn measure(piece: &Piece, cut: &CutLines, w: f64, farthest: f64) {
    assert!(cut.notices.is_empty(), "{:?}", cut.notices);
    let sew: Vec<Vec<[f64; 2]>> = piece.outlines.iter().map(|o| o.points.clone()).collect();
    for p in cut.outlines.iter().flat_map(|c| samples(c)) {
        let far = off(p, &sew);
        assert!(far > w - 1e-6 && far < farthest, "{p:?} is {far} from the sew line");
    }
    for p in sew.iter().flat_map(|c| samples(c)) {
        assert!(off(p, &cut.outlines) > w - 1e-6);
    }
    assert!(Outline { points: cut.outlines[0].clone(), vertices: Vec::new() }.area_mm2() > 0.0);
}

#[test]
fn the_corners_of_a_square_are_mitred_rounded_or_cut_off() {
    let square = piece(&[rectangle([10.0, 20.0], [60.0, 70.0])]);
    let make = |corner| {
        let params = AllowanceParams { corner, ..AllowanceParams::default() };
        cut_lines(&square, &uniform(&square, 10.0), &params)
    };
    let mitre = make(Corner::Mitre);
    measure(&square, &mitre, 10.0, 10.0 * 2.0_f64.sqrt() + 1e-9);
    assert_eq!(mitre.outlines.len(), 1);
    assert_eq!(mitre.outlines[0].len(), 4);
    // Rounding on a grid of 2^-44 of 80 mm.
    assert!((area(&mitre) - 70.0 * 70.0).abs() < 1e-8);
    let round = make(Corner::Round);
    // Outside the circle by no more than the tolerance.
    measure(&square, &round, 10.0, 10.051);
    let exact = 2500.0 + 2000.0 + TAU / 2.0 * 100.0;
    assert!(area(&round) > exact && area(&round) < exact + 2.0);
    let cut_off = make(Corner::Square);
    measure(&square, &cut_off, 10.0, 10.0 / (TAU / 16.0).cos() + 1e-9);
    assert_eq!(cut_off.outlines[0].len(), 8);
}

#[test]
fn without_allowance_the_cut_line_is_the_outline_bit_for_bit() {
    let ring = piece(&[circle(400, [0.1, 0.7], 31.3), backwards(circle(60, [0.0, 0.0], 7.7))]);
    let cut = cut_lines(&ring, &uniform(&ring, 0.0), &AllowanceParams::default());
    assert!(cut.notices.is_empty() && cut.slits.is_empty());
    for (cut, outline) in cut.outlines.iter().zip(&ring.outlines) {
        assert_eq!(cut, &outline.points);
    }
    // Missing widths count as none.
    assert_eq!(cut_lines(&ring, &[], &AllowanceParams::default()), cut);
}

#[test]
fn where_there_is_no_allowance_the_points_of_the_sew_line_stay() {
    let mut points = circle(101, [33.0, 1.0 / 3.0], 20.0 / 3.0);
    for p in &mut points {
        p[0] += 0.1;
    }
    let disk = piece(&[points.clone()]);
    let mut widths = uniform(&disk, 6.0);
    for w in &mut widths[0][20..60] {
        *w = 0.0;
    }
    let cut = cut_lines(&disk, &widths, &AllowanceParams::default());
    assert!(cut.notices.is_empty(), "{:?}", cut.notices);
    assert_eq!(cut.outlines.len(), 1);
    let start = cut.outlines[0].iter().position(|p| *p == points[20]).unwrap();
    for k in 0..=40 {
        let n = cut.outlines[0].len();
        assert_eq!(cut.outlines[0][(start + k) % n], points[20 + k]);
    }
    // At both ends a step square to the side that has the allowance.
    let [x, y] = cut.outlines[0][(start + 41) % cut.outlines[0].len()];
    let step = (x - points[60][0]).hypot(y - points[60][1]);
    assert!((step - 6.0).abs() < 1e-6, "{step}");
}

#[test]
fn corners_between_different_allowances_meet_where_both_are_kept() {
    let quad = vec![[0.0, 0.0], [80.0, 10.0], [70.0, 60.0], [-10.0, 50.0]];
    let shape = piece(std::slice::from_ref(&quad));
    let widths = vec![vec![15.0, 6.0, 10.0, 8.0]];
    let cut = cut_lines(&shape, &widths, &AllowanceParams::default());
    assert!(cut.notices.is_empty());
    assert_eq!(cut.outlines[0].len(), 4);
    for i in 0..4 {
        let [a, b] = [quad[i], quad[(i + 1) % 4]];
        let size = (b[0] - a[0]).hypot(b[1] - a[1]);
        let n = [(b[1] - a[1]) / size, (a[0] - b[0]) / size];
        // Two corners lie on the far edge of each side.
        let on = cut.outlines[0]
            .iter()
            .filter(|p| ((p[0] - a[0]) * n[0] + (p[1] - a[1]) * n[1] - widths[0][i]).abs() < 1e-9);
        assert_eq!(on.count(), 2);
    }
}

#[test]
fn edges_that_go_straight_on_with_another_allowance_have_a_square_step() {
    let shape = piece(&[vec![[0.0, 0.0], [40.0, 0.0], [80.0, 0.0], [80.0, 50.0], [0.0, 50.0]]]);
    let widths = vec![vec![10.0, 5.0, 5.0, 5.0, 5.0]];
    let cut = cut_lines(&shape, &widths, &AllowanceParams::default());
    assert!(cut.notices.is_empty());
    for corner in [[40.0, -10.0], [40.0, -5.0], [-5.0, -10.0], [85.0, -5.0]] {
        let is_there = |p: &[f64; 2]| (p[0] - corner[0]).hypot(p[1] - corner[1]) < 1e-9;
        assert!(cut.outlines[0].iter().any(is_there), "{corner:?} in {:?}", cut.outlines[0]);
    }
    assert_eq!(cut.outlines[0].len(), 6);
}

#[test]
fn far_tips_are_cut_off_and_keep_the_allowance() {
    // A blade of 10 degrees: its mitre would reach 11 allowances.
    let blade = piece(&[vec![[0.0, -5.25], [60.0, 0.0], [0.0, 5.25]]]);
    let cut = cut_lines(&blade, &uniform(&blade, 6.0), &AllowanceParams::default());
    // Cut off square at 15 mm: its ends are a little farther.
    measure(&blade, &cut, 6.0, 16.0);
    let tip = cut.outlines[0].iter().map(|p| p[0]).fold(0.0, f64::max);
    assert!((tip - 75.0).abs() < 1e-9, "{tip}");
}

#[test]
fn inward_corners_and_clips_of_an_l() {
    let l = vec![[0.0, 0.0], [60.0, 0.0], [60.0, 30.0], [30.0, 30.0], [30.0, 60.0], [0.0, 60.0]];
    let shape = piece(&[l]);
    let widths = uniform(&shape, 8.0);
    let cut = cut_lines(&shape, &widths, &AllowanceParams::default());
    measure(&shape, &cut, 8.0, 8.0 * 2.0_f64.sqrt() + 1e-9);
    assert_eq!(cut.outlines[0].len(), 6);
    let clips = draw_clips(3, &shape, &widths, &cut);
    assert_eq!(clips.len(), 1);
    assert_eq!((clips[0].layer, clips[0].piece), (Layer::Internal, Some(3)));
    let [from, to] = clips[0].points[..] else { panic!("two points") };
    assert!((from[0] - 38.0).abs() < 1e-9 && (from[1] - 38.0).abs() < 1e-9);
    assert!(((to[0] - 30.0).hypot(to[1] - 30.0) - 2.0).abs() < 1e-9);
}

#[test]
fn circles_of_many_points_stay_round() {
    for (n, r, w) in [(400, 50.0, 10.0), (400, 0.5, 10.0), (400, 2500.0, 15.0), (24, 30.0, 6.0)] {
        let disk = piece(&[circle(n, [r, r], r)]);
        let cut = cut_lines(&disk, &uniform(&disk, w), &AllowanceParams::default());
        // The polygon about the circle of radius r + w, or the arcs about its corners.
        measure(&disk, &cut, w, w + 0.11);
        assert!(cut.outlines[0].len() <= 2 * n, "{}", cut.outlines[0].len());
        let exact = TAU / 2.0 * (r + w) * (r + w);
        assert!((area(&cut) / exact - 1.0).abs() < 0.03);
    }
}

#[test]
fn noise_makes_no_spikes() {
    for seed in 1..4_u64 {
        let mut state = seed;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0
        };
        // Steps of 0.2 mm along a square, off by up to 0.1 mm across: kinks of a right angle everywhere.
        let corners = rectangle([0.0, 0.0], [30.0, 30.0]);
        let mut points = Vec::new();
        for i in 0..4 {
            let [a, b] = [corners[i], corners[(i + 1) % 4]];
            for k in 0..150 {
                let t = f64::from(k) / 150.0;
                let across = [(b[1] - a[1]) / 30.0, (a[0] - b[0]) / 30.0];
                let far = if k == 0 { 0.0 } else { 0.1 * noise() };
                points.push([0, 1].map(|j| a[j] + t * (b[j] - a[j]) + far * across[j]));
            }
        }
        let rough = piece(&[points]);
        let cut = cut_lines(&rough, &uniform(&rough, 6.0), &AllowanceParams::default());
        measure(&rough, &cut, 6.0, 6.0 * 2.0_f64.sqrt() + 0.9);
        // Along the sides nothing sticks out further than the noise and the arcs do.
        for p in &cut.outlines[0] {
            let is_corner = p.iter().all(|x| *x < 0.0 || *x > 30.0);
            let out = [p[0], p[1], 30.0 - p[0], 30.0 - p[1]].into_iter().fold(0.0, f64::min);
            assert!(is_corner || out > -6.2, "{p:?}");
        }
        // The four corners are still corners.
        let out = |p: &[f64; 2]| p.iter().all(|x| *x < -5.5 || *x > 35.5);
        assert!(cut.outlines[0].iter().filter(|p| out(p)).count() >= 4);
    }
}

#[test]
fn holes_shrink_and_small_ones_close_with_a_notice() {
    let plate = vec![
        rectangle([0.0, 0.0], [200.0, 100.0]),
        backwards(rectangle([20.0, 20.0], [60.0, 60.0])),
        backwards(circle(40, [150.0, 50.0], 8.0)),
    ];
    let plate = piece(&plate);
    let cut = cut_lines(&plate, &uniform(&plate, 10.0), &AllowanceParams::default());
    assert_eq!(cut.notices, [CutNotice::HoleClosed { patch: 0, outline: 2, allowance_mm: 10.0 }]);
    assert_eq!(cut.outlines.len(), 2);
    assert!((area(&cut) - (220.0 * 120.0 - 400.0)).abs() < 1e-8, "a hole of 20 mm is left");
    assert!(cut.notices[0].to_string().starts_with("allowance larger than the piece can hold"));
}

#[test]
fn thin_necks_are_never_entered_and_narrow_gaps_are_told() {
    // Two squares joined by a neck of 2 mm: the cut line stays outside.
    let dumbbell = vec![
        [0.0, 0.0],
        [40.0, 0.0],
        [40.0, 19.0],
        [100.0, 19.0],
        [100.0, 0.0],
        [140.0, 0.0],
        [140.0, 40.0],
        [100.0, 40.0],
        [100.0, 21.0],
        [40.0, 21.0],
        [40.0, 40.0],
        [0.0, 40.0],
    ];
    let shape = piece(&[dumbbell]);
    let cut = cut_lines(&shape, &uniform(&shape, 10.0), &AllowanceParams::default());
    measure(&shape, &cut, 10.0, 10.0 * 2.0_f64.sqrt() + 1e-9);
    // A U with a gap of 12 mm between arms, 10 mm of allowance each.
    let u = vec![
        [0.0, 0.0],
        [112.0, 0.0],
        [112.0, 120.0],
        [62.0, 120.0],
        [62.0, 20.0],
        [50.0, 20.0],
        [50.0, 120.0],
        [0.0, 120.0],
    ];
    let shape = piece(&[u]);
    let cut = cut_lines(&shape, &uniform(&shape, 10.0), &AllowanceParams::default());
    let [CutNotice::Crowded { gap_mm, allowance_mm, .. }] = cut.notices[..] else {
        panic!("{:?}", cut.notices)
    };
    assert!((gap_mm - 12.0).abs() < 1e-9 && (allowance_mm - 10.0).abs() < 1e-9);
    assert!(cut.notices[0].to_string().starts_with("allowance larger than the piece can hold"));
    // With 5 mm there is room.
    let cut = cut_lines(&shape, &uniform(&shape, 5.0), &AllowanceParams::default());
    measure(&shape, &cut, 5.0, 5.0 * 2.0_f64.sqrt() + 1e-9);
}

/// A rectangle with a dart of that base from below, legs of 60 mm height.
fn with_dart(base: f64) -> Piece {
    let half = 0.5 * base;
    let mut shape = piece(&[vec![
        [-80.0, 0.0],
        [-half, 0.0],
        [0.0, 60.0],
        [half, 0.0],
        [80.0, 0.0],
        [80.0, 100.0],
        [-80.0, 100.0],
    ]]);
    shape.seams = vec![
        seam(&shape, 1, Partner::Own { is_second: false }, 1, 1),
        seam(&shape, 1, Partner::Own { is_second: true }, 2, 1),
    ];
    shape
}

#[test]
fn wide_darts_are_cut_with_less_and_less_allowance() {
    let shape = with_dart(40.0);
    let widths = uniform(&shape, 10.0);
    let found = darts(&shape, &widths);
    assert_eq!(found.len(), 1);
    assert!(
        found[0].is_cut && found[0].ends == [1, 2, 3] && (found[0].base_mm - 40.0).abs() < 1e-9
    );
    let cut = cut_lines(&shape, &widths, &AllowanceParams::default());
    assert!(cut.notices.is_empty(), "{:?}", cut.notices);
    // The cut reaches the tip itself.
    assert!(off([0.0, 60.0], &cut.outlines) < 1e-6);
    // Half way up the leg half of the allowance.
    let (x, y) = (-10.0, 30.0);
    let n = [60.0 / 4000.0_f64.sqrt(), -20.0 / 4000.0_f64.sqrt()];
    let slope = (1.0_f64 + (10.0 / 4000.0_f64.sqrt()).powi(2)).sqrt();
    let reached = off([x, y], &cut.outlines) * slope;
    assert!((reached - 5.0).abs() < 1e-6, "{reached}");
    assert!(off([x + 5.0 * n[0], y + 5.0 * n[1]], &cut.outlines) < 1e-6);
    assert_eq!(draw_darts(0, &shape, &found).len(), 2, "the tip only");
}

#[test]
fn narrow_darts_are_marked_and_capped() {
    let shape = with_dart(16.0);
    let widths = uniform(&shape, 10.0);
    let found = darts(&shape, &widths);
    assert!(!found[0].is_cut);
    let cut = cut_lines(&shape, &widths, &AllowanceParams::default());
    assert!(cut.notices.is_empty(), "{:?}", cut.notices);
    assert_eq!(cut.outlines.len(), 1);
    // No cut comes near the tip, and on the middle line the edge is where the one beside the dart comes to lie: mirrored over
    // a leg, the point there has the same distance from the tip, and lies 10 mm below the base line of its side.
    assert!(off([0.0, 60.0], &cut.outlines) > 49.9, "the upper edge is nearest");
    let lowest = |at: f64| {
        let on = cut.outlines[0].iter().filter(|p| (p[0] - at).abs() < 1e-6);
        on.map(|p| p[1]).fold(f64::INFINITY, f64::min)
    };
    let cap = lowest(0.0);
    let leg = [8.0 / 3664.0_f64.sqrt(), -60.0 / 3664.0_f64.sqrt()];
    let v = [0.0, cap - 60.0];
    let s = 2.0 * (v[0] * leg[0] + v[1] * leg[1]);
    let mirrored = [s * leg[0] - v[0], 60.0 + s * leg[1] - v[1]];
    assert!((mirrored[1] + 10.0).abs() < 1e-6 && mirrored[0] > 8.0, "{cap} {mirrored:?}");
    let marks = draw_darts(0, &shape, &found);
    assert_eq!(marks.iter().filter(|l| l.layer == Layer::Internal).count(), 2);
    assert_eq!(marks.iter().filter(|l| l.layer == Layer::Drill).count(), 2);
}

#[test]
fn the_examples_get_allowances_of_every_size() {
    for (name, example) in [
        ("box", box_with_lid()),
        ("pillow", pillow()),
        ("prism", slit_prism()),
        ("square", cut_square()),
    ] {
        let (pattern, _) = example.pattern(100.0);
        for w in [0.5, 3.0, 10.0, 25.0] {
            for piece in &pattern.pieces {
                let widths = uniform(piece, w);
                let cut = cut_lines(piece, &widths, &AllowanceParams::default());
                assert!(cut.notices.is_empty(), "{name} {w}: {:?}", cut.notices);
                assert_eq!(cut.outlines.len(), 1);
                // Slits are darts without a base: all of them marked, none cut.
                let darts = darts(piece, &widths);
                assert!(darts.iter().all(|d| !d.is_cut && d.base_mm < 1e-9));
                assert_eq!(
                    darts.len(),
                    match name {
                        "prism" => 1,
                        "square" => piece.seams.len() / 3,
                        _ => 0,
                    }
                );
            }
        }
    }
}

#[test]
fn a_slit_without_allowance_is_cut_as_a_line() {
    let (pattern, _) = slit_prism().pattern(100.0);
    let piece = &pattern.pieces[0];
    let mut widths = uniform(piece, 10.0);
    let found = darts(piece, &widths);
    for leg in found[0].legs {
        let seam = &piece.seams[leg];
        let n = widths[0].len();
        for k in 0..seam.sides {
            widths[0][(seam.first + k) % n] = 0.0;
        }
    }
    let cut = cut_lines(piece, &widths, &AllowanceParams::default());
    assert_eq!((cut.outlines.len(), cut.slits.len()), (1, 1));
    let slit = &cut.slits[0];
    let tip = piece.outlines[0].points[found[0].ends[1]];
    assert_eq!(slit[slit.len() - 1], tip);
    assert!(off(slit[0], &cut.outlines) < 1e-6, "it begins on the cut line");
}

#[test]
fn extreme_sizes_hold() {
    // A piece of 1 mm with an allowance of 10 mm, and one of 5 m.
    let tiny = piece(&[rectangle([0.0, 0.0], [1.0, 1.0])]);
    let cut = cut_lines(&tiny, &uniform(&tiny, 10.0), &AllowanceParams::default());
    measure(&tiny, &cut, 10.0, 10.0 * 2.0_f64.sqrt() + 1e-6);
    assert!((area(&cut) - 441.0).abs() < 1e-6);
    let large = piece(&[rectangle([0.0, 0.0], [5000.0, 3000.0])]);
    let cut = cut_lines(&large, &uniform(&large, 10.0), &AllowanceParams::default());
    measure(&large, &cut, 10.0, 10.0 * 2.0_f64.sqrt() + 1e-6);
    // Widths that are none.
    for w in [-1.0, f64::NAN, f64::INFINITY, 1e12] {
        let mut widths = uniform(&large, 5.0);
        widths[0][2] = w;
        let cut = cut_lines(&large, &widths, &AllowanceParams::default());
        assert_eq!(cut.notices, [CutNotice::BadWidth { patch: 0, outline: 0, side: 2 }]);
        assert!(cut.outlines.iter().flatten().flatten().all(|x| x.is_finite()));
    }
}

#[test]
fn outlines_that_cross_themselves_are_told_and_do_not_stop_the_tool() {
    let eight = piece(&[vec![[0.0, 0.0], [50.0, 50.0], [50.0, 0.0], [0.0, 60.0]]]);
    let cut = cut_lines(&eight, &uniform(&eight, 5.0), &AllowanceParams::default());
    assert!(!cut.notices.is_empty());
    assert!(!cut.outlines.is_empty());
}

#[test]
fn equal_input_gives_equal_cut_lines() {
    let disk = piece(&[circle(300, [3.0, 4.0], 40.0)]);
    let make = || cut_lines(&disk, &uniform(&disk, 7.0), &AllowanceParams::default());
    assert_eq!(make(), make());
}
