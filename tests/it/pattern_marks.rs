//! Marks, hints and grain lines of pieces.

use std::f64::consts::TAU;

use cutflow::pattern::{
    GrainParams, HintParams, Layer, Mark, MarkKind, MarkParams, Outline, Pattern, PieceHints,
    darts, grain, hints, marks,
};

use crate::pattern_folds::strip;
use crate::patterns::{Example, box_with_lid, pillow, slit_prism};

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// A cone of rays of length 1 that lacks an angle in the plane, cut along a ray.
fn cone(lacking: f64) -> Example {
    let n = 24;
    let radius = 1.0 - lacking / TAU;
    let height = (1.0 - radius * radius).sqrt();
    let mut positions = vec![[0.0, 0.0, height]];
    for ring in [0.5, 1.0] {
        for i in 0..n {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
            positions.push([ring * radius * cos, ring * radius * sin, height * (1.0 - ring)]);
        }
    }
    let at = |ring: u32, i: u32| 1 + ring * n + i % n;
    let triangles = (0..n).flat_map(|i| {
        [
            [0, at(0, i), at(0, i + 1)],
            [at(0, i), at(1, i), at(1, i + 1)],
            [at(0, i), at(1, i + 1), at(0, i + 1)],
        ]
    });
    Example::new(positions, &Vec::from_iter(triangles), &[[0, at(0, 0)], [at(0, 0), at(1, 0)]])
}

fn of_kind(marks: &[Mark], kind: MarkKind) -> Vec<&Mark> {
    marks.iter().filter(|mark| mark.kind == kind).collect()
}

fn centre(mark: &Mark) -> [f64; 2] {
    let (_, line) = &mark.lines[0];
    [0, 1].map(|a| 0.5 * (line[0][a] + line[1][a]))
}

fn all(example: &Example, mm: f64, params: &MarkParams) -> (Pattern, Vec<Vec<Mark>>) {
    let (pattern, _) = example.pattern(mm);
    let marks = marks(&example.laid(mm), &pattern, params);
    (pattern, marks)
}

#[test]
fn a_dart_is_found_and_its_tip_marked_as_far_from_it_as_asked() {
    let lacking = 40f64.to_radians();
    let example = cone(lacking);
    let (pattern, found) = all(&example, 100.0, &MarkParams::default());
    let piece = &pattern.pieces[0];
    let [dart] = darts(piece)[..] else { panic!("one dart") };
    // Chords of the 24 sides lie a little inside the circle: the missing angle is not quite what the round cone lacks.
    assert!((dart.opening - lacking).abs() < 0.05, "{}", dart.opening.to_degrees());
    assert!((dart.length_mm - 100.0).abs() < 1e-9);
    assert!((dart.width_mm - 200.0 * (0.5 * dart.opening).sin()).abs() < 1e-9);
    let tip = piece.outlines[0].points[dart.tip];
    let [mark] = of_kind(&found[0], MarkKind::Tip)[..] else { panic!("one tip") };
    assert!(mark.layer == Layer::Drill && distance(centre(mark), tip) < 1e-9);
    assert!(mark.lines.iter().all(|(_, line)| (distance(line[0], line[1]) - 3.0).abs() < 1e-9));
    let short = MarkParams { drill_short_mm: 4.0, ..MarkParams::default() };
    let (_, found) = all(&example, 100.0, &short);
    let [mark] = of_kind(&found[0], MarkKind::Tip)[..] else { panic!("one tip") };
    let at = centre(mark);
    assert!((distance(at, tip) - 4.0).abs() < 1e-9);
    // Halfway between the legs: the same distance from both open ends.
    let ends = dart.legs.map(|leg| piece.seam_points(&piece.seams[leg]));
    let ends = [ends[0][0], ends[1][ends[1].len() - 1]];
    assert!((distance(at, ends[0]) - distance(at, ends[1])).abs() < 1e-6);
    assert!(distance(at, ends[0]) < distance(tip, ends[0]), "towards the open end");
    // A wide one is a corner.
    let narrow = MarkParams { widest_dart: 0.3, ..MarkParams::default() };
    assert!(of_kind(&all(&example, 100.0, &narrow).1[0], MarkKind::Tip).is_empty());
}

#[test]
fn slits_are_darts_without_width() {
    let (pattern, found) = all(&slit_prism(), 20.0, &MarkParams::default());
    let found_darts = darts(&pattern.pieces[0]);
    let [dart] = found_darts[..] else { panic!("{found_darts:?}") };
    assert!(dart.opening.abs() < 1e-6 && dart.width_mm < 1e-6);
    assert_eq!(of_kind(&found[0], MarkKind::Tip).len(), 1);
    // Two seams: six ends at five points, one of them the tip.
    assert_eq!(of_kind(&found[0], MarkKind::End).len(), 7);
}

#[test]
fn corners_where_three_seams_meet_have_one_letter_on_all_pieces() {
    let (pattern, found) = all(&box_with_lid(), 100.0, &MarkParams::default());
    let letters = |piece: usize| {
        let mut letters: Vec<String> = of_kind(&found[piece], MarkKind::Junction)
            .iter()
            .map(|mark| mark.text.clone().unwrap().2)
            .collect();
        letters.sort();
        letters
    };
    assert_eq!(letters(1), ["a", "b", "c", "d"]);
    assert_eq!(letters(0), ["a", "a", "b", "b", "c", "c", "d", "d"]);
    // The letters stand at the same point of the surface.
    let example = box_with_lid();
    for (piece, marks) in pattern.pieces.iter().zip(&found) {
        for mark in of_kind(marks, MarkKind::Junction) {
            let (outline, at) = mark.at;
            let point = |piece: &cutflow::pattern::Piece, (o, i): (usize, usize)| {
                example.opened.vertex_points[piece.outlines[o].vertices[i].index()]
            };
            let letter = mark.text.clone().unwrap().2;
            let same = found[1]
                .iter()
                .find(|other| other.text.as_ref().is_some_and(|text| text.2 == letter));
            assert_eq!(point(piece, (outline, at)), point(&pattern.pieces[1], same.unwrap().at));
            // Near the corner, within 5 mm of it.
            let p = piece.outlines[outline].points[at];
            assert!(distance(mark.text.as_ref().unwrap().0, p) < 6.0);
            assert_eq!(mark.layer, Layer::Internal);
        }
    }
}

#[test]
fn closed_seams_begin_at_triangles_on_both_pieces() {
    let (_, found) = all(&pillow(), 50.0, &MarkParams::default());
    for marks in &found {
        let starts = of_kind(marks, MarkKind::Start);
        assert_eq!((starts.len(), marks.len()), (1, 1));
        let (is_closed, points) = &starts[0].lines[0];
        assert!(*is_closed && points.len() == 3);
    }
}

#[test]
fn pieces_without_distortion_have_no_stretch_and_flat_ones_no_radius() {
    let example = box_with_lid();
    let (pattern, _) = example.pattern(100.0);
    let found = hints(&example.laid(100.0), &pattern, &HintParams::default());
    for piece in &found.pieces {
        let PieceHints { mean_percent, longest_percent, shortest_percent, area_percent, .. } =
            piece;
        for percent in [mean_percent, longest_percent, shortest_percent, area_percent] {
            // Square roots of rounding.
            assert!(percent.abs() < 1e-5, "{piece:?}");
        }
        assert!(piece.radius_mm.is_infinite(), "folds are not bends");
        assert_eq!(piece.to_string(), "stretch 0.0 % (at most +0.0 / +0.0 %), area +0.0 %");
    }
    assert_eq!(found.seams.len(), 8);
    assert!(found.seams.iter().all(|ease| ease.difference_mm().abs() < 1e-9));
    assert_eq!(found.seams[0].to_string(), format!("seam {}: equally long", found.seams[0].number));
}

#[test]
fn stretch_area_and_ease_are_those_of_the_chart() {
    let mut example = box_with_lid();
    // The lid, which comes last, 10 % wider and 20 % lower.
    let lid = example.opened.mesh.triangles()[2];
    let patches = example.opened.vertex_patches();
    let own = patches[lid[0].index()];
    for (p, patch) in example.charts.iter_mut().zip(patches) {
        if *patch == own {
            *p = [1.1 * p[0], 0.8 * p[1]];
        }
    }
    let (pattern, _) = example.pattern(100.0);
    let found = hints(&example.laid(100.0), &pattern, &HintParams::default());
    let lid = &found.pieces[1];
    for (value, expected) in [
        (lid.mean_percent, 15.0),
        (lid.longest_percent, 10.0),
        (lid.shortest_percent, -20.0),
        (lid.area_percent, -12.0),
    ] {
        assert!((value - expected).abs() < 1e-9, "{lid:?}");
    }
    assert_eq!(lid.to_string(), "stretch 15.0 % (at most +10.0 / -20.0 %), area -12.0 %");
    let mut eases: Vec<String> = found
        .seams
        .iter()
        .filter(|ease| ease.difference_mm().abs() > 1e-6)
        .map(|ease| ease.to_string().split_once(": ").unwrap().1.to_owned())
        .collect();
    eases.sort();
    let [wide, low] = ["B 10.0 mm (10.0 %) longer than A", "A 20.0 mm (20.0 %) longer than B"];
    assert_eq!(eases, [low, low, wide, wide]);
}

#[test]
fn the_smallest_radius_is_that_of_the_cylinder_or_of_the_tightest_bend() {
    let example = slit_prism();
    let params = HintParams { fold_angle: 0.6 };
    let (pattern, _) = example.pattern(50.0);
    let found = hints(&example.laid(50.0), &pattern, &params);
    // Twelve sides: the turn over the width of a side is 1 / 0.989 R.
    let expected = 50.0 * 2.0 * (TAU / 24.0).sin() / (TAU / 12.0);
    assert!((found.pieces[0].radius_mm - expected).abs() < 1e-6, "{}", found.pieces[0].radius_mm);
    assert!(found.pieces[0].to_string().ends_with("bends to R 49 mm"));
    // A strip of squares of 10 mm that turns by 0.1 each, more sharply in the middle; at both ends it is straight.
    let example = strip(&[0.0, 0.1, 0.1, 0.2, 0.2, 0.2, 0.1, 0.0]);
    let (pattern, _) = example.pattern(10.0);
    let found = hints(&example.laid(10.0), &pattern, &params);
    // About 10 mm over 0.2; the rim of the strip is all there is of its vertices.
    assert!((found.pieces[0].radius_mm / 50.0 - 1.0).abs() < 0.2, "{}", found.pieces[0].radius_mm);
}

fn outline(points: &[[f64; 2]]) -> Outline {
    Outline { points: points.to_vec(), vertices: Vec::new() }
}

#[test]
fn the_grain_line_goes_upright_through_the_centre() {
    let piece = outline(&[[0.0, 0.0], [60.0, 0.0], [60.0, 100.0], [0.0, 100.0]]);
    let line = grain(std::slice::from_ref(&piece), [30.0, 50.0], &GrainParams::default()).unwrap();
    assert!(line.is_long && line.is_double);
    assert!(line.from[0] == 30.0 && line.to[0] == 30.0 && line.to[1] > line.from[1]);
    assert!((50.0..=96.0).contains(&distance(line.from, line.to)));
    assert_eq!(line.lines().len(), 3);
    // One head for nap, in the direction asked for.
    let params = GrainParams { direction: [2.0, 0.0], has_nap: true };
    let line = grain(&[piece], [30.0, 50.0], &params).unwrap();
    assert!(line.from[1] == 50.0 && line.to[1] == 50.0 && line.to[0] > line.from[0]);
    assert_eq!(line.lines().len(), 2);
    assert_eq!(line.lines()[1][1], line.to);
}

#[test]
fn the_grain_line_stays_inside_and_moves_aside_where_the_centre_has_no_room() {
    // A frame: the centre of its widest part is low; the hole is in the way above it.
    let pieces = [
        outline(&[[0.0, 0.0], [60.0, 0.0], [60.0, 100.0], [0.0, 100.0]]),
        outline(&[[15.0, 30.0], [15.0, 90.0], [45.0, 90.0], [45.0, 30.0]]),
    ];
    let line = grain(&pieces, [30.0, 15.0], &GrainParams::default()).unwrap();
    assert!(line.is_long && !(13.0..=47.0).contains(&line.from[0]), "{line:?}");
    assert!(line.from[1] >= 2.0 && line.to[1] <= 98.0);
    // A triangle on its tip: the head's room counts, too.
    let tip = outline(&[[0.0, 0.0], [20.0, 60.0], [-20.0, 60.0]]);
    let line = grain(&[tip], [0.0, 45.0], &GrainParams::default()).unwrap();
    for [x, y] in line.lines().concat() {
        assert!(x.abs() < y / 3.0 && y < 60.0);
    }
    let crumb = outline(&[[0.0, 0.0], [5.0, 0.0], [5.0, 5.0], [0.0, 5.0]]);
    assert_eq!(grain(&[crumb], [2.5, 2.5], &GrainParams::default()), None);
    assert_eq!(grain(&[], [0.0; 2], &GrainParams::default()), None);
    let nowhere = GrainParams { direction: [0.0; 2], has_nap: false };
    assert_eq!(grain(&pieces, [30.0, 15.0], &nowhere), None);
}
