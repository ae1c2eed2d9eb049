//! Fold lines: ridges and grooves, where they lie, and what is left flat.

use std::f64::consts::{FRAC_PI_2, PI};

use cutflow::pattern::{
    FoldParams, LaidSurface, Layer, Pattern, fold_layer, fold_shortening_mm, folds,
};

use crate::patterns::{Example, box_with_lid, slit_prism};

impl Example {
    pub(crate) fn laid(&self, mm_per_unit: f64) -> LaidSurface<'_> {
        LaidSurface {
            opened: &self.opened,
            charts: &self.charts,
            positions: &self.positions,
            mm_per_unit,
        }
    }
}

/// A strip of squares of side 1, folded between each two by an angle, positive upwards; the outer side is the upper one.
pub(crate) fn strip(angles: &[f64]) -> Example {
    let (mut x, mut z, mut angle) = (0.0, 0.0, 0.0_f64);
    let mut positions = vec![[x, 0.0, z], [x, 1.0, z]];
    for turn in [0.0].iter().chain(angles) {
        angle += turn;
        x += angle.cos();
        z += angle.sin();
        positions.extend([[x, 0.0, z], [x, 1.0, z]]);
    }
    let triangles = (0..=angles.len() as u32)
        .flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 3], [2 * i, 2 * i + 3, 2 * i + 1]]);
    Example::new(positions, &Vec::from_iter(triangles), &[])
}

fn is_on_outline(pattern: &Pattern, piece: usize, p: [f64; 2]) -> bool {
    pattern.pieces[piece].outlines.iter().any(|outline| outline.points.contains(&p))
}

#[test]
fn a_cross_has_four_mountains_and_its_diagonals_are_no_folds() {
    let example = box_with_lid();
    let (pattern, _) = example.pattern(100.0);
    let folds = folds(&example.laid(100.0), &pattern, &FoldParams::default());
    assert_eq!(folds.iter().map(Vec::len).collect::<Vec<_>>(), [4, 0]);
    for fold in &folds[0] {
        assert_eq!(fold.points.len(), 2);
        assert!(fold.is_mountain() && fold.layer() == Layer::FoldMountain);
        // Rounding of a right angle.
        assert!((fold.angle - FRAC_PI_2).abs() < 1e-12, "{}", fold.angle);
        assert!((fold.length_mm() - 100.0).abs() < 1e-9);
        assert!(fold.points.iter().all(|&p| is_on_outline(&pattern, 0, p)), "bit for bit");
    }
}

#[test]
fn ridges_are_mountains_and_grooves_are_valleys() {
    // Seen from above a strip that turns down has a ridge.
    let example = strip(&[-0.7, 0.4, -0.02]);
    let (pattern, _) = example.pattern(10.0);
    let laid = example.laid(10.0);
    let found = folds(&laid, &pattern, &FoldParams::default());
    let angles: Vec<f64> = found[0].iter().map(|fold| fold.angle).collect();
    assert_eq!(angles.len(), 2, "one degree is hidden: {angles:?}");
    assert!((angles[0] - 0.7).abs() < 1e-12 && (angles[1] + 0.4).abs() < 1e-12, "{angles:?}");
    assert_eq!([0, 1].map(|i| found[0][i].layer()), [Layer::FoldMountain, Layer::FoldValley]);
    let all = FoldParams { least_angle: 0.01, ..FoldParams::default() };
    assert_eq!(folds(&laid, &pattern, &all)[0].len(), 3);
    assert_eq!(
        [0.0, 0.05, -0.05, 0.2, -0.2].map(|angle| fold_layer(angle, 0.1)),
        [Layer::Score, Layer::Score, Layer::Score, Layer::FoldMountain, Layer::FoldValley]
    );
}

#[test]
fn edges_in_a_row_are_one_fold_in_the_frame_of_the_outlines() {
    let example = slit_prism();
    for mm in [10.0, 1e-3, 1e4] {
        let (pattern, _) = example.pattern(mm);
        let folds = folds(&example.laid(mm), &pattern, &FoldParams::default());
        // Twelve standing edges of four parts, one of them cut through, one slit to the middle.
        let mut lengths: Vec<f64> = folds[0].iter().map(|f| f.length_mm() / mm).collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths.len(), 11);
        // Rounding about the size of the piece.
        assert!((lengths[0] - 1.0).abs() < 1e-12);
        assert!(lengths[1..].iter().all(|l| (l - 2.0).abs() < 1e-12));
        assert!(folds[0].iter().all(|f| (f.angle - PI / 6.0).abs() < 1e-9 && f.points.len() == 2));
        for p in folds[0].iter().flat_map(|f| &f.points) {
            let piece = &pattern.pieces[0];
            let within = |axis: usize| {
                let slack = 1e-9 * mm;
                (piece.bounds.low[axis] - slack..=piece.bounds.high[axis] + slack)
                    .contains(&p[axis])
            };
            assert!(within(0) && within(1));
        }
        let flat = FoldParams { least_angle: PI / 5.9, ..FoldParams::default() };
        assert!(cutflow::pattern::folds(&example.laid(mm), &pattern, &flat)[0].is_empty());
    }
}

#[test]
fn folds_of_unlike_angles_are_not_joined() {
    // A fan of four faces about a point on a ridge that gets sharper there.
    let up = |x: f64| if x > 0.0 { 1.0 } else { 0.4 };
    let positions = vec![
        [0.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [-1.0, 1.0, -up(-1.0)],
        [1.0, 1.0, -up(1.0)],
        [-1.0, -1.0, -up(-1.0)],
        [1.0, -1.0, -up(1.0)],
    ];
    let triangles = [[0, 2, 4], [0, 4, 3], [0, 3, 1], [0, 1, 5], [0, 5, 6], [0, 6, 2]];
    let example = Example::new(positions, &triangles, &[[0, 3], [0, 5]]);
    let (pattern, notices) = example.pattern(10.0);
    assert!(notices.is_empty(), "{notices:?}");
    let folds = folds(&example.laid(10.0), &pattern, &FoldParams::default());
    let all = || folds.iter().flatten();
    assert!(all().all(|fold| fold.points.len() == 2), "{folds:?}");
    // Slopes of 0.4 and 1 on both sides of the ridge.
    for slope in [0.4_f64, 1.0] {
        let angle = 2.0 * slope.atan();
        assert!(all().any(|fold| (fold.angle - angle).abs() < 1e-9), "{folds:?}");
    }
}

#[test]
fn seams_turn_as_the_surface_does_across_them() {
    let example = box_with_lid();
    let (pattern, _) = example.pattern(100.0);
    let laid = example.laid(100.0);
    for piece in &pattern.pieces {
        let turns = laid.seam_turns(piece);
        assert_eq!(turns.len(), piece.seams.len());
        for (turns, seam) in turns.iter().zip(&piece.seams) {
            assert_eq!(turns.len(), seam.sides);
            assert!(turns.iter().all(|turn| (turn - FRAC_PI_2).abs() < 1e-12));
        }
    }
    // Thick material: half of the thickness at a right angle; nothing for paper.
    assert_eq!(fold_shortening_mm(0.3, 1.0), None);
    assert_eq!(fold_shortening_mm(f64::NAN, 1.0), None);
    assert_eq!(fold_shortening_mm(1.0, 3.1), None);
    assert_eq!(fold_shortening_mm(1.0, -FRAC_PI_2), fold_shortening_mm(1.0, FRAC_PI_2));
}
