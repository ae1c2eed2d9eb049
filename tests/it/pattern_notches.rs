//! Notches stand on the same points of the surface on both pieces, clear of corners, and no seam can be taken for another.
#![allow(clippy::float_cmp, reason = "what must be equal to the last bit is compared so")]

use std::collections::BTreeSet;

use cutflow::pattern::allowance::{AllowanceParams, cut_lines};
use cutflow::pattern::notches::{
    Group, NotchNotice, NotchParams, NotchPlan, NotchStyle, conflicts, draw, is_unambiguous, place,
    plan, with_outward,
};
use cutflow::pattern::{Bounds, Layer, Partner, Pattern, Piece};

use super::pattern_allowance::{circle, piece, seam, uniform};
use super::patterns::{box_with_lid, pillow, slit_prism};

/// A pattern of pieces with the same outline, each side of one sewn to the side of the next with the same number.
fn twins(points: &[[f64; 2]], sides_per_seam: usize) -> Pattern {
    let n = points.len();
    let mut mirrored: Vec<[f64; 2]> = points.iter().map(|p| [-p[0], p[1]]).collect();
    mirrored.reverse();
    let pieces: Vec<Piece> = [points.to_vec(), mirrored]
        .into_iter()
        .enumerate()
        .map(|(p, points)| {
            let mut piece = piece(&[points]);
            (piece.patch, piece.name) = (p, ["A", "B"][p].into());
            let seams = n / sides_per_seam;
            for k in 0..seams {
                let first = k * sides_per_seam;
                // Side i of the first is side n − 2 − i of the mirrored one.
                let first = if p == 0 { first } else { (2 * n - 1 - first - sides_per_seam) % n };
                let mut seam = seam(&piece, k + 1, Partner::Patch(1 - p), first, sides_per_seam);
                seam.is_second = p == 1;
                piece.seams.push(seam);
            }
            piece
        })
        .collect();
    let bounds = Bounds::around(pieces.iter().flat_map(|p| [p.bounds.low, p.bounds.high]));
    Pattern { pieces, patch_count: 2, bounds }
}

/// Both properties, told by another code than the one under test: sequences of counts and places within 5 mm (1/20 of the
/// seam on short ones).
fn check_sequences(pattern: &Pattern, plan: &NotchPlan) {
    let on = |number: usize| -> BTreeSet<usize> {
        let pieces = pattern.pieces.iter().enumerate();
        pieces.filter(|(_, p)| p.seams.iter().any(|s| s.number == number)).map(|p| p.0).collect()
    };
    let is_same = |a: &[Group], b: &[Group], near: f64| {
        a.len() == b.len()
            && a.iter()
                .zip(b)
                .all(|(g, h)| g.count == h.count && (g.arc_mm - h.arc_mm).abs() < near)
    };
    let reversed = |groups: &[Group], long: f64| -> Vec<Group> {
        groups.iter().rev().map(|g| Group { arc_mm: long - g.arc_mm, count: g.count }).collect()
    };
    let marked: Vec<_> =
        plan.seams.iter().filter(|s| !s.groups.is_empty() && !s.is_closed).collect();
    for a in &marked {
        let near = 5.0_f64.min(0.05 * a.length_mm);
        let back = reversed(&a.groups, a.length_mm);
        assert!(!is_same(&a.groups, &back, near), "seam {} reads the same backwards", a.number);
        for b in &marked {
            let is_similar = (a.length_mm / b.length_mm - 1.0).abs() < 0.05;
            if a.number != b.number && is_similar && !on(a.number).is_disjoint(&on(b.number)) {
                assert!(!is_same(&a.groups, &b.groups, near), "{} and {}", a.number, b.number);
                assert!(
                    !is_same(&back, &b.groups, near),
                    "{} and {} backwards",
                    a.number,
                    b.number
                );
            }
        }
    }
}

#[test]
fn both_sides_carry_the_notches_at_the_same_points_of_the_surface() {
    for example in [box_with_lid(), pillow(), slit_prism()] {
        let (pattern, _) = example.pattern(250.0);
        let plan = plan(&pattern, &NotchParams::default());
        assert!(plan.notices.is_empty(), "{:?}", plan.notices);
        assert!(is_unambiguous(&pattern, &plan));
        check_sequences(&pattern, &plan);
        for notches in &plan.seams {
            assert!(!notches.groups.is_empty());
            for arc in notches.marks(plan.pair_mm) {
                let mut places = Vec::new();
                for piece in &pattern.pieces {
                    for (s, seam) in piece.seams.iter().enumerate() {
                        if seam.number != notches.number {
                            continue;
                        }
                        let (at, normal) = place(piece, s, arc).unwrap();
                        assert!((normal[0].hypot(normal[1]) - 1.0).abs() < 1e-12);
                        // Measured along the flat seam, which is as long as the surface here.
                        let points = piece.seam_points(seam);
                        let mut gone = 0.0;
                        let found = points.windows(2).find_map(|p| {
                            let side = (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1]);
                            let far = (at[0] - p[0][0]).hypot(at[1] - p[0][1]);
                            let rest = (p[1][0] - at[0]).hypot(p[1][1] - at[1]);
                            gone += side;
                            (far + rest - side < 1e-9).then_some(gone - side + far)
                        });
                        places.push(seam.shared_arc(found.unwrap()));
                    }
                }
                assert_eq!(places.len(), 2);
                assert!((places[0] - places[1]).abs() < 1e-9, "{places:?}");
                assert!((places[0] - arc).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn spacing_clearance_and_groups_are_as_asked() {
    let points = vec![[0.0, 0.0], [500.0, 0.0], [500.0, 45.0], [460.0, 300.0], [0.0, 180.0]];
    let pattern = twins(&points, 1);
    for params in [NotchParams::default(), NotchParams::plush()] {
        let plan = plan(&pattern, &params);
        assert!(plan.notices.is_empty() && plan.factor == 1.0);
        for seam in &plan.seams {
            assert!(!seam.groups.is_empty(), "all are longer than 40 mm");
            let clear = params.clear_mm.min(0.2 * seam.length_mm) - 1e-9;
            let marks = seam.marks(plan.pair_mm);
            assert!(marks.iter().all(|m| *m >= clear && *m <= seam.length_mm - clear));
            let half = |g: &Group| 0.5 * (g.count as f64 - 1.0) * 6.0;
            for g in seam.groups.windows(2) {
                let apart = g[1].arc_mm - g[0].arc_mm;
                assert!(
                    apart - half(&g[0]) - half(&g[1]) >= clear && apart < 2.0 * params.spacing_mm
                );
            }
        }
        check_sequences(&pattern, &plan);
    }
}

#[test]
fn dozens_of_equal_seams_are_all_told_apart() {
    for (n, long) in [(3, 60.0), (8, 50.0), (12, 90.0), (24, 120.0), (40, 200.0), (30, 800.0)] {
        let r = 0.5 * long / (std::f64::consts::PI / n as f64).sin();
        let pattern = twins(&circle(n, [0.0; 2], r), 1);
        let plan = plan(&pattern, &NotchParams::default());
        assert!(plan.notices.is_empty(), "{n} of {long}: {:?}", plan.notices);
        assert!(is_unambiguous(&pattern, &plan));
        check_sequences(&pattern, &plan);
    }
}

#[test]
fn where_there_is_no_room_for_a_choice_the_plan_says_so() {
    // 200 equal seams of 41 mm on two pieces.
    let r = 0.5 * 41.0 / (std::f64::consts::PI / 200.0).sin();
    let mut pattern = twins(&circle(200, [0.0; 2], r), 1);
    // A long one elsewhere, so that lengths are not reduced.
    let mut other = piece(&[vec![[0.0, 0.0], [400.0, 0.0], [400.0, 400.0]]]);
    other.patch = 2;
    other.seams = vec![seam(&other, 201, Partner::Patch(3), 0, 1)];
    pattern.pieces.push(other);
    let plan = plan(&pattern, &NotchParams::default());
    let told: BTreeSet<usize> = plan
        .notices
        .iter()
        .map(|n| match n {
            NotchNotice::Ambiguous { number } | NotchNotice::NearCorner { number } => *number,
        })
        .collect();
    assert!(!told.is_empty());
    assert!(plan.seams.iter().all(|s| !s.groups.is_empty()), "marked all the same");
    // Every conflict is told at one of its seams.
    for conflict in conflicts(&pattern, &plan) {
        use cutflow::pattern::notches::Conflict::{Reverse, Same};
        match conflict {
            Reverse { number } => assert!(told.contains(&number)),
            Same { number, other } => assert!(told.contains(&number) || told.contains(&other)),
        }
    }
    assert!(!is_unambiguous(&pattern, &plan));
}

#[test]
fn a_plan_that_reads_the_same_backwards_is_found_out() {
    let pattern = twins(&[[0.0, 0.0], [300.0, 0.0], [300.0, 300.0]], 1);
    let mut plan = plan(&pattern, &NotchParams::default());
    assert!(is_unambiguous(&pattern, &plan));
    plan.seams[0].groups = [100.0, 200.0].map(|arc_mm| Group { arc_mm, count: 1 }).to_vec();
    assert!(!is_unambiguous(&pattern, &plan));
    // Seams 1 and 2 are equally long: the notches of one, turned around, on the other.
    plan.seams[0].groups =
        vec![Group { arc_mm: 100.0, count: 1 }, Group { arc_mm: 200.0, count: 2 }];
    plan.seams[1].groups =
        vec![Group { arc_mm: 100.0, count: 2 }, Group { arc_mm: 200.0, count: 1 }];
    assert_eq!(conflicts(&pattern, &plan).len(), 1);
}

#[test]
fn closed_seams_have_a_start_mark_of_three_and_a_direction() {
    for n in [60, 400] {
        for r in [8.0, 25.0, 60.0, 400.0] {
            let pattern = twins(&circle(n, [0.0; 2], r), n);
            let plan = plan(&pattern, &NotchParams::default());
            assert!(plan.notices.is_empty(), "{r}: {:?}", plan.notices);
            let seam = &plan.seams[0];
            assert!(seam.is_closed && seam.groups[0].count == 3);
            assert!(seam.groups.len() > 1 && seam.groups[1..].iter().all(|g| g.count < 3));
            assert!(is_unambiguous(&pattern, &plan));
            let marks = seam.marks(plan.pair_mm);
            assert!(marks.iter().all(|m| (0.0..seam.length_mm).contains(m)));
        }
    }
}

#[test]
fn notches_keep_away_from_corners_within_a_seam() {
    // One seam around three sides of a square.
    let mut pattern = twins(&[[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]], 4);
    for piece in &mut pattern.pieces {
        piece.seams[0].is_closed = true;
    }
    let plan = plan(&pattern, &NotchParams::default());
    for mark in plan.seams[0].marks(plan.pair_mm) {
        let off = mark.rem_euclid(100.0);
        assert!(off.min(100.0 - off) > 15.0 - 1e-9, "{mark}");
    }
    check_sequences(&pattern, &plan);
}

#[test]
fn small_models_get_smaller_notches() {
    let pattern = twins(&[[0.0, 0.0], [30.0, 0.0], [30.0, 20.0], [0.0, 20.0]], 1);
    let plan = plan(&pattern, &NotchParams::default());
    assert_eq!(plan.factor, 0.25);
    assert_eq!(plan.pair_mm, 1.5);
    assert!(plan.seams.iter().all(|s| !s.groups.is_empty()));
    check_sequences(&pattern, &plan);
}

fn size(line: &[[f64; 2]]) -> f64 {
    let [a, b] = [line[0], line[1]];
    (b[0] - a[0]).hypot(b[1] - a[1])
}

#[test]
fn slits_start_on_the_cut_line_and_leave_room_to_the_sew_line() {
    let pattern = twins(&[[0.0, 0.0], [300.0, 0.0], [300.0, 200.0], [0.0, 200.0]], 1);
    let params = NotchParams::default();
    let plan = plan(&pattern, &params);
    // Lower side of the first piece: cut line at y = −a.
    for (a, depth) in [(20.0, 6.0), (10.0, 5.0), (8.0, 4.0), (5.0, 2.0), (4.0, 4.0 / 3.0)] {
        let piece = &pattern.pieces[0];
        let cut = cut_lines(piece, &uniform(piece, a), &AllowanceParams::default());
        let lines = draw(0, piece, &plan, &cut, &params);
        let marks: usize = plan.seams.iter().map(|s| s.marks(plan.pair_mm).len()).sum();
        assert_eq!(lines.len(), marks);
        let ids: BTreeSet<&str> = lines.iter().map(|l| l.id.as_str()).collect();
        assert!(ids.len() == marks && ids.contains("A-notch-1-1"));
        for line in lines.iter().filter(|l| l.seam == Some(0)) {
            assert!((line.layer, line.piece) == (Layer::Notch, Some(0)));
            assert!((line.points[0][1] + a).abs() < 1e-6, "{:?}", line.points);
            assert!(
                (size(&line.points) - depth).abs() < 1e-6 && line.points[1][0] == line.points[0][0]
            );
        }
        // Without allowance ticks into the piece.
        let cut = cut_lines(piece, &[], &AllowanceParams::default());
        for line in draw(0, piece, &plan, &cut, &params).iter().filter(|l| l.seam == Some(0)) {
            assert_eq!((line.points[0][1], line.points[1][1]), (0.0, 3.0));
        }
    }
}

#[test]
fn vs_are_cut_in_or_stand_out() {
    let pattern = twins(&[[0.0, 0.0], [300.0, 0.0], [300.0, 200.0], [0.0, 200.0]], 1);
    let params = NotchParams { style: NotchStyle::V, ..NotchParams::default() };
    let plan = plan(&pattern, &params);
    let piece = &pattern.pieces[0];
    let area = |outline: &[[f64; 2]]| {
        cutflow::pattern::Outline { points: outline.to_vec(), vertices: Vec::new() }.area_mm2()
    };
    let cut = cut_lines(piece, &uniform(piece, 12.0), &AllowanceParams::default());
    let lines = draw(0, piece, &plan, &cut, &params);
    assert_eq!(with_outward(piece, &plan, &cut, &params), cut);
    let v = &lines.iter().find(|l| l.seam == Some(0)).unwrap().points;
    assert!((v[0][1] + 12.0).abs() < 1e-6 && (v[1][1] + 8.0).abs() < 1e-6 && v.len() == 3);
    assert!(((v[2][0] - v[0][0]).abs() - 5.0).abs() < 1e-6);
    // Narrow: triangles of 6 by 5 are added to the outline, and no lines are drawn.
    let cut = cut_lines(piece, &uniform(piece, 5.0), &AllowanceParams::default());
    assert!(draw(0, piece, &plan, &cut, &params).is_empty());
    let out = with_outward(piece, &plan, &cut, &params);
    assert_eq!(out.outlines.len(), 1);
    let groups = |count: usize| {
        plan.seams.iter().flat_map(|s| &s.groups).filter(|g| g.count == count).count() as f64
    };
    // Two of a group are 6 mm apart and just touch.
    let marks = groups(1) + 2.0 * groups(2) + 3.0 * groups(3);
    let more = area(&out.outlines[0]) - area(&cut.outlines[0]);
    assert!((more - 15.0 * marks).abs() < 1e-6, "{more} {marks}");
}

#[test]
fn notches_of_round_pieces_stand_square_to_the_cut_line() {
    let pattern = twins(&circle(400, [0.0; 2], 80.0), 400);
    for style in [NotchStyle::Slit, NotchStyle::T, NotchStyle::V] {
        let params = NotchParams { style, ..NotchParams::default() };
        let plan = plan(&pattern, &params);
        let piece = &pattern.pieces[0];
        let cut = cut_lines(piece, &uniform(piece, 10.0), &AllowanceParams::default());
        let lines = draw(0, piece, &plan, &cut, &params);
        assert_eq!(lines.len(), plan.seams[0].marks(plan.pair_mm).len());
        for line in &lines {
            let radii: Vec<f64> = line.points.iter().map(|p| p[0].hypot(p[1])).collect();
            // The polygon about the circle is off by 0.003 mm, a V's feet lie on it too.
            assert!((radii[0] - 90.0).abs() < 0.01, "{radii:?}");
            let depth = if style == NotchStyle::V { 4.0 } else { 5.0 };
            assert!((radii[1] - 90.0 + depth).abs() < 0.01, "{radii:?}");
        }
    }
}

#[test]
fn notches_of_filled_darts_are_ticks_on_the_sew_line() {
    let (pattern, _) = slit_prism().pattern(200.0);
    let params = NotchParams::default();
    let plan = plan(&pattern, &params);
    let piece = &pattern.pieces[0];
    let cut = cut_lines(piece, &uniform(piece, 10.0), &AllowanceParams::default());
    let slit = piece.seams.iter().map(|s| s.sides).min().unwrap();
    let lines = draw(0, piece, &plan, &cut, &params);
    let ids: BTreeSet<&str> = lines.iter().map(|l| l.id.as_str()).collect();
    assert_eq!(ids.len(), lines.len(), "both sides of a seam have their own names");
    for line in &lines {
        let seam = &piece.seams[line.seam.unwrap()];
        let long = size(&line.points);
        assert!((long - if seam.sides == slit { 3.0 } else { 5.0 }).abs() < 1e-6, "{}", line.id);
    }
}
