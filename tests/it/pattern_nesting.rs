//! Nesting: the check, the contract of flows, layouts with a known optimum, charts in a texture.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use cutflow::flatten::{self, pack};
use cutflow::methods::flow::{Flow, SolveError, Status};
use cutflow::pattern::nesting::check;
use cutflow::pattern::{
    CHECK_TOLERANCE_MM, NestFault, NestFlow, NestNotice, NestParams, NestPose, NestShape,
    Rotations, Stock, UvPackParams, pack_uv,
};
use nalgebra::Point2;

type Outline = Vec<[f64; 2]>;

fn shape(outline: impl Into<Outline>) -> NestShape {
    NestShape { outlines: vec![outline.into()], ..NestShape::default() }
}

fn rectangle(width: f64, height: f64) -> Outline {
    vec![[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]
}

/// Five unit squares' worth of corner: 20 by 20 less 10 by 10.
fn corner() -> Outline {
    vec![[0.0, 0.0], [20.0, 0.0], [20.0, 10.0], [10.0, 10.0], [10.0, 20.0], [0.0, 20.0]]
}

/// Long outlines with hollows, all different.
fn blobs(count: usize, points: usize) -> Vec<NestShape> {
    let mut state = 1u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..count)
        .map(|k| {
            let waves: Vec<[f64; 3]> = (2..6)
                .map(|n| [f64::from(n), 0.35 * next() / (f64::from(n) - 0.8), TAU * next()])
                .collect();
            let longer = 0.6 + 0.8 * next();
            let size = 40.0 + 60.0 * k as f64 / count as f64;
            let point = |i: usize| {
                let t = TAU * i as f64 / points as f64;
                let wave = waves.iter().map(|[n, a, phase]| a * (n * t + phase).cos());
                let r = size * (1.0 + wave.sum::<f64>()).max(0.15);
                [r * t.cos() * longer, r * t.sin() / longer]
            };
            shape((0..points).map(point).collect::<Outline>())
        })
        .collect()
}

fn roll(width_mm: f64) -> NestParams {
    NestParams { stock: Stock::Roll { width_mm }, ..NestParams::default() }
}

/// Without gap and margin.
fn tight(stock: Stock) -> NestParams {
    NestParams { stock, gap_mm: 0.0, margin_mm: 0.0, ..NestParams::default() }
}

fn run(shapes: &[NestShape], params: &NestParams, steps: usize) -> NestFlow {
    let mut flow = NestFlow::new(shapes, params).unwrap();
    for _ in 0..steps {
        if flow.step().unwrap().status != Status::Running {
            break;
        }
    }
    check(shapes, &flow.state().poses, params).unwrap();
    flow
}

fn at(x: f64, y: f64) -> NestPose {
    NestPose { shift: [x, y], ..NestPose::default() }
}

#[test]
fn a_nest_keeps_the_contract_of_flows() {
    let shapes = blobs(6, 24);
    let sheet = Stock::Sheet { width_mm: 400.0, height_mm: 300.0, most: 9 };
    for (stock, rotations) in [
        (Stock::Roll { width_mm: 400.0 }, Rotations::Woven),
        (sheet, Rotations::Cross),
        (Stock::Free, Rotations::Free),
    ] {
        let params =
            NestParams { stock, rotations, step_limit: 8, seed: 5, ..NestParams::default() };
        let mut flow = NestFlow::new(&shapes, &params).unwrap();
        let mut twin = flow.clone();
        let mut cost = flow.state().cost_mm;
        check(&shapes, &flow.state().poses, &params).unwrap();
        let mut steps = 0;
        loop {
            let report = flow.step().unwrap();
            steps += 1;
            // A clone taken on the way goes the same way: a checkpoint.
            if steps == 4 {
                twin = twin.clone();
            }
            assert_eq!(report, twin.step().unwrap());
            assert_eq!(flow.state(), twin.state(), "the same every time");
            assert_eq!(report.energy[0].1.to_bits(), flow.state().cost_mm.to_bits());
            assert!(flow.state().cost_mm <= cost, "it never gets longer");
            cost = flow.state().cost_mm;
            check(&shapes, &flow.state().poses, &params).unwrap();
            if report.status != Status::Running {
                break;
            }
        }
        assert!(steps <= 8 && flow.state().notices.is_empty());
        let end = flow.state().clone();
        let report = flow.step().unwrap();
        assert_eq!((flow.state(), report.status), (&end, flow.status()), "quiet at its end");
    }
}

#[test]
fn other_seeds_give_other_layouts_in_the_search() {
    let shapes = blobs(5, 30);
    let ends =
        [1, 2].map(|seed| run(&shapes, &NestParams { seed, ..roll(350.0) }, 8).state().clone());
    let firsts =
        [1, 2].map(|seed| run(&shapes, &NestParams { seed, ..roll(350.0) }, 1).state().clone());
    assert_eq!(firsts[0], firsts[1], "the first layout draws no random number");
    assert_ne!(ends[0].poses, ends[1].poses);
}

#[test]
fn the_check_finds_what_is_planted() {
    let square = shape(rectangle(10.0, 10.0));
    let pair = [square.clone(), square.clone()];
    let params = NestParams { margin_mm: 2.0, gap_mm: 3.0, ..roll(40.0) };
    let faults = |poses: [NestPose; 2]| check(&pair, &poses, &params);
    let good = [at(2.0, 2.0), at(15.0, 2.0)];
    assert_eq!(faults(good), Ok(()));
    assert_eq!(check(&pair, &good[..1], &params), Err(NestFault::Count { shapes: 2, poses: 1 }));
    // By twice the tolerance too close, by half of it not.
    let near = |by: f64| faults([at(2.0, 2.0), at(15.0 - by * CHECK_TOLERANCE_MM, 2.0)]);
    assert_eq!(near(0.5), Ok(()));
    assert!(matches!(near(2.0), Err(NestFault::TooClose { shapes: [0, 1], .. })));
    // Corner to corner the distance is along the diagonal: 3 − 2√2 > 0.
    let corners = |by: f64| faults([at(2.0, 2.0), at(12.0 + by, 12.0 + by)]);
    assert_eq!(corners(2.2), Ok(()));
    assert!(matches!(corners(2.0), Err(NestFault::TooClose { .. })));
    assert!(matches!(faults([at(2.0, 2.0), at(8.0, 2.0)]), Err(NestFault::Overlap { .. })));
    assert!(matches!(faults([at(1.9, 2.0), good[1]]), Err(NestFault::Outside { shape: 0, .. })));
    assert!(matches!(faults([good[0], at(28.1, 2.0)]), Err(NestFault::Outside { shape: 1, .. })));
    assert_eq!(faults([good[0], at(15.0, f64::NAN)]), Err(NestFault::NotFinite { shape: 1 }));
    let sheet = NestPose { sheet: 1, ..good[1] };
    assert_eq!(faults([good[0], sheet]), Err(NestFault::NoSuchSheet { shape: 1, sheet: 1 }));
    let turned = NestPose { angle: FRAC_PI_2, ..at(30.0, 2.0) };
    assert!(matches!(faults([good[0], turned]), Err(NestFault::Turned { shape: 1, .. })));
    let mirrored = NestPose { is_mirrored: true, ..at(30.0, 2.0) };
    assert_eq!(faults([good[0], mirrored]), Err(NestFault::Mirrored { shape: 1 }));
    let large = NestPose { is_too_large: true, ..good[1] };
    assert_eq!(faults([good[0], large]), Err(NestFault::NotAlone { shape: 1, other: 0 }));
    // Wholly within the other, its rim far away.
    let nested = [shape(rectangle(36.0, 36.0)), square.clone()];
    let within = check(&nested, &[at(2.0, 2.0), at(15.0, 15.0)], &params);
    assert!(matches!(within, Err(NestFault::Overlap { shapes: [0, 1], .. })));
}

#[test]
fn the_check_lets_pieces_touch_where_the_gap_is_nothing_and_no_more() {
    let params = tight(Stock::Free);
    let square = || shape(rectangle(10.0, 10.0));
    let pair = |a: NestShape, b: NestShape, x: f64, y: f64| {
        check(&[a, b], &[at(20.0, 20.0), at(20.0 + x, 20.0 + y)], &params)
    };
    assert_eq!(pair(square(), square(), 10.0, 3.0), Ok(()));
    assert_eq!(pair(square(), square(), 10.0 - 1e-13, 0.0), Ok(()), "rounding");
    for (x, y) in [(0.0, 0.0), (5.0, 0.0), (0.0, 1e-5), (9.99, 9.99), (10.0 - 1e-5, 0.0)] {
        let fault = pair(square(), square(), x, y);
        assert!(matches!(fault, Err(NestFault::Overlap { .. })), "{x} {y} {fault:?}");
    }
    // A cross: no corner of either bar lies in the other.
    let cross = pair(shape(rectangle(30.0, 2.0)), shape(rectangle(2.0, 30.0)), 14.0, -14.0);
    assert!(matches!(cross, Err(NestFault::Overlap { .. })));
    // Corners that fit into each other.
    let turned = NestPose { angle: PI, ..at(50.0, 40.0) };
    let corners = [shape(corner()), shape(corner())];
    assert_eq!(check(&corners, &[at(20.0, 20.0), turned], &params), Ok(()));
    // Through a hole there is room, and none beside it.
    let frame = || NestShape {
        outlines: vec![
            rectangle(30.0, 30.0),
            vec![[10.0, 10.0], [10.0, 20.0], [20.0, 20.0], [20.0, 10.0]],
        ],
        ..NestShape::default()
    };
    assert_eq!(pair(frame(), square(), 10.0, 10.0), Ok(()));
    assert!(matches!(pair(frame(), square(), 10.1, 10.0), Err(NestFault::Overlap { .. })));
}

#[test]
fn no_piece_and_one_piece_are_laid_too() {
    let none = NestFlow::new(&[], &roll(500.0)).unwrap();
    assert_eq!((none.status(), none.state().sheets), (Status::Converged, 0));
    assert_eq!(none.state().cost_mm, 0.0);
    let one = run(&[shape(rectangle(80.0, 30.0))], &roll(500.0), 2);
    assert_eq!(one.status(), Status::Converged);
    assert_eq!(one.state().poses[0].apply([0.0, 0.0]).map(f64::round), [10.0, 10.0]);
    // Its height and both margins, up to rounding.
    assert!((one.state().cost_mm - 50.0).abs() < 1e-9);
    assert!((one.state().utilisation - 2400.0 / (500.0 * 50.0)).abs() < 1e-12);
    // What has no area is no piece.
    let broken = [
        NestShape::default(),
        shape([[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]]),
        shape([[0.0, 0.0], [1.0, 0.0]]),
        shape(rectangle(5.0, 5.0)),
    ];
    let flow = run(&broken, &roll(500.0), 2);
    let told: Vec<NestNotice> = (0..3).map(|shape| NestNotice::NoOutline { shape }).collect();
    assert_eq!((&flow.state().notices, flow.state().sheets), (&told, 1));
}

#[test]
fn small_squares_and_corners_fill_the_roll_at_the_first_step() {
    let squares = vec![shape(rectangle(5.0, 5.0)); 200];
    let flow = run(&squares, &tight(Stock::Roll { width_mm: 50.0 }), 1);
    // Optimal: nothing is wasted, up to rounding of places.
    assert!((flow.state().cost_mm - 100.0).abs() < 1e-9);
    assert_eq!(flow.status(), Status::Converged);
    // Two corners make a rectangle of 30 by 20.
    let corners = vec![shape(corner()); 24];
    let flow = run(&corners, &tight(Stock::Roll { width_mm: 60.0 }), 1);
    assert!((flow.state().utilisation - 1.0).abs() < 1e-9, "{}", flow.state().utilisation);
    // Sheets of 10 × 10 squares: exactly two.
    let sheet = Stock::Sheet { width_mm: 50.0, height_mm: 50.0, most: 2 };
    let flow = run(&squares, &tight(sheet), 1);
    assert_eq!((flow.state().sheets, flow.state().notices.len()), (2, 0));
}

#[test]
fn triangles_find_their_partners() {
    let triangles = vec![shape([[0.0, 0.0], [30.0, 0.0], [0.0, 30.0]]); 8];
    let params = tight(Stock::Roll { width_mm: 60.0 });
    let flow = run(&triangles, &params, 150);
    // The optimum is 60 mm, each row of rest would be 30 more: within 2 % of it, because the search keeps a hair of air.
    assert!(flow.state().cost_mm < 61.2, "{}", flow.state().cost_mm);
    assert!(flow.state().cost_mm >= 60.0 - 1e-6, "no layout can be shorter");
}

#[test]
fn the_search_shortens_what_the_raster_lays() {
    let shapes = blobs(8, 60);
    let mut flow = NestFlow::new(&shapes, &roll(450.0)).unwrap();
    let rows = flow.state().cost_mm;
    flow.step().unwrap();
    let first = flow.state().cost_mm;
    assert!(first < 0.95 * rows, "{first} {rows}");
    let end = run(&shapes, &roll(450.0), 24).state().cost_mm;
    assert!(end < 0.97 * first, "{end} {first}");
}

#[test]
fn a_strip_longer_than_the_sheet_is_told_and_the_others_are_nested() {
    let sheet = Stock::Sheet { width_mm: 400.0, height_mm: 300.0, most: 3 };
    let mut shapes = vec![shape(rectangle(60.0, 40.0)); 5];
    shapes.insert(2, shape(rectangle(1000.0, 10.0)));
    let params = NestParams { stock: sheet, rotations: Rotations::Free, ..NestParams::default() };
    let flow = run(&shapes, &params, 6);
    let state = flow.state();
    assert_eq!(state.notices, [NestNotice::TooLarge { shape: 2 }]);
    assert_eq!(state.sheets, 1);
    assert!(state.poses[2].is_too_large && state.poses[2].sheet == 1);
    assert!((0..6).filter(|&i| i != 2).all(|i| state.poses[i].sheet == 0));
    // One of 450 mm fits along the diagonal of 380 by 280, if it may turn.
    shapes[2] = shape(rectangle(450.0, 5.0));
    assert!(run(&shapes, &params, 3).state().notices.is_empty());
    let woven = NestParams { rotations: Rotations::Woven, ..params };
    assert_eq!(run(&shapes, &woven, 3).state().notices, [NestNotice::TooLarge { shape: 2 }]);
    // As wide as the stock between its margins.
    let exact = vec![shape(rectangle(380.0, 280.0)); 2];
    assert_eq!(run(&exact, &params, 3).state().sheets, 2);
}

#[test]
fn sheets_that_are_full_are_told() {
    let sheet = Stock::Sheet { width_mm: 100.0, height_mm: 100.0, most: 1 };
    let shapes = vec![shape(rectangle(70.0, 60.0)); 3];
    let params = NestParams { stock: sheet, ..NestParams::default() };
    let state = run(&shapes, &params, 2).state().clone();
    assert_eq!(state.sheets, 3);
    assert_eq!(state.notices.len(), 2);
    assert!(state.notices.iter().all(|n| matches!(n, NestNotice::NoRoom { .. })));
}

#[test]
fn a_small_piece_lies_in_the_hole_of_a_large_one() {
    let hole = vec![[20.0, 20.0], [20.0, 80.0], [80.0, 80.0], [80.0, 20.0]];
    let frame = NestShape { outlines: vec![rectangle(100.0, 100.0), hole], ..NestShape::default() };
    let shapes = [frame, shape(rectangle(40.0, 40.0))];
    let state = run(&shapes, &NestParams { margin_mm: 0.0, ..roll(110.0) }, 1).state().clone();
    assert!((state.cost_mm - 100.0).abs() < 1e-9, "{}", state.cost_mm);
}

#[test]
fn the_grain_is_kept() {
    let mut shapes = blobs(5, 30);
    for (k, shape) in shapes.iter_mut().enumerate() {
        shape.upright = 0.3 * k as f64;
        shape.may_mirror = k % 2 == 0;
    }
    for (rotations, tolerance_deg, turn) in [
        (Rotations::Nap, 0.0, TAU),
        (Rotations::Woven, 0.0, PI),
        (Rotations::Woven, 3.0, PI),
        (Rotations::Steps(45.0), 0.0, FRAC_PI_2 / 2.0),
    ] {
        let params = NestParams { rotations, tolerance_deg, ..roll(400.0) };
        let flow = run(&shapes, &params, 7);
        for (pose, shape) in flow.state().poses.iter().zip(&shapes) {
            assert!(!pose.is_mirrored || shape.may_mirror);
            let upright = if pose.is_mirrored { -shape.upright } else { shape.upright };
            let off = (pose.angle - upright) / turn;
            let off = (off - off.round()).abs() * turn;
            // Rounding of sums of angles.
            assert!(off <= tolerance_deg.to_radians() + 1e-12, "{off}");
        }
    }
    // A mirrored chevron: where it points stays up.
    let pose = NestPose { is_mirrored: true, angle: -0.3, ..NestPose::default() };
    let up = pose.apply([(0.3_f64).sin(), (0.3_f64).cos()]);
    assert!((up[0] - 0.0).abs() < 1e-15 && (up[1] - 1.0).abs() < 1e-15, "{up:?}");
}

#[test]
fn a_layout_scales_with_its_pieces() {
    let shapes = blobs(5, 30);
    let state = |scale: f64| {
        let scaled: Vec<NestShape> = shapes
            .iter()
            .map(|s| shape(s.outlines[0].iter().map(|p| p.map(|x| x * scale)).collect::<Outline>()))
            .collect();
        let params = NestParams {
            stock: Stock::Roll { width_mm: 350.0 * scale },
            gap_mm: 5.0 * scale,
            margin_mm: 10.0 * scale,
            ..NestParams::default()
        };
        run(&scaled, &params, 8).state().clone()
    };
    let own = state(1.0);
    // Powers of two scale without rounding, so that all choices are the same.
    for scale in [0.125, 8.0] {
        let other = state(scale);
        assert_eq!(other.cost_mm, own.cost_mm * scale);
        for (a, b) in own.poses.iter().zip(&other.poses) {
            assert_eq!((a.angle, a.shift.map(|x| x * scale)), (b.angle, b.shift));
        }
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let refused = |params: NestParams, word: &str| match NestFlow::new(&[], &params) {
        Err(SolveError::Parameter { name, .. }) => assert_eq!(name, word),
        other => panic!("{word}: {:?}", other.map(|flow| flow.status())),
    };
    refused(NestParams { gap_mm: -1.0, ..roll(100.0) }, "gap_mm");
    refused(NestParams { margin_mm: f64::NAN, ..roll(100.0) }, "margin_mm");
    refused(NestParams { margin_mm: 50.0, ..roll(100.0) }, "width_mm");
    refused(roll(f64::INFINITY), "width_mm");
    refused(NestParams { rotations: Rotations::Steps(0.0), ..roll(100.0) }, "rotation steps");
    let sheet = Stock::Sheet { width_mm: 100.0, height_mm: 10.0, most: 1 };
    refused(NestParams { stock: sheet, ..NestParams::default() }, "height_mm");
}

/// Distance of two closed polylines by all pairs of points and sides: apart ones have it at a point of one of them.
fn distance(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let of = |points: &[[f64; 2]], outline: &[[f64; 2]]| {
        let mut least = f64::INFINITY;
        for &[x, y] in points {
            for (k, &[px, py]) in outline.iter().enumerate() {
                let [qx, qy] = outline[(k + 1) % outline.len()];
                let (dx, dy) = (qx - px, qy - py);
                let t = ((x - px) * dx + (y - py) * dy) / (dx * dx + dy * dy);
                let t = t.clamp(0.0, 1.0);
                least = least.min((x - px - t * dx).hypot(y - py - t * dy));
            }
        }
        least
    };
    of(a, b).min(of(b, a))
}

#[test]
fn charts_fill_a_texture_with_margins_in_texels_better_than_a_skyline() {
    let shapes: Vec<NestShape> = blobs(20, 60)
        .iter()
        .map(|s| shape(s.outlines[0].iter().map(|p| p.map(|x| x * 1e-4)).collect::<Outline>()))
        .collect();
    let params = UvPackParams { pixels: 1024, margin_px: 6, steps: 4, seed: 0 };
    let packing = pack_uv(&shapes, &params).unwrap();
    let placed: Vec<Outline> = shapes
        .iter()
        .enumerate()
        .map(|(k, s)| s.outlines[0].iter().map(|&p| packing.apply(k, p)).collect())
        .collect();
    let texel = 1.0 / 1024.0;
    for (k, a) in placed.iter().enumerate() {
        let inside = a.iter().flatten().all(|x| (3.0 * texel..=1.0 - 3.0 * texel).contains(x));
        assert!(inside, "half the margin to the edge");
        for b in &placed[..k] {
            assert!(distance(a, b) >= 6.0 * texel, "{}", distance(a, b) / texel);
        }
    }
    let covered: f64 = shapes.iter().map(NestShape::area).sum::<f64>() * packing.scale.powi(2);
    assert!((covered - packing.utilisation).abs() < 1e-12);
    // The skyline of rectangles with the same margin, by a few rounds for its own scale.
    let outlines: Vec<Vec<Point2<f64>>> =
        shapes.iter().map(|s| s.outlines[0].iter().copied().map(Point2::from).collect()).collect();
    let rectangles: Vec<flatten::Shape> =
        outlines.iter().map(|outline| flatten::Shape { outline, landmarks: &[] }).collect();
    let mut side = 1.0;
    for _ in 0..20 {
        let gap = 6.0 * side * texel;
        side = pack(&rectangles, gap, None).sheet.max() + gap;
    }
    let skyline = shapes.iter().map(NestShape::area).sum::<f64>() / (side * side);
    assert!(packing.utilisation > 1.1 * skyline, "{} {skyline}", packing.utilisation);
}

#[test]
fn margins_that_take_up_the_whole_texture_are_refused() {
    let shapes = vec![shape(rectangle(1.0, 1.0)); 20];
    let params = UvPackParams { pixels: 16, margin_px: 8, steps: 0, seed: 0 };
    let refused = pack_uv(&shapes, &params);
    assert!(matches!(refused, Err(SolveError::Parameter { name: "margin_px", .. })), "{refused:?}");
    let none = pack_uv(&[], &params).unwrap();
    assert!(none.poses.is_empty() && none.scale == 1.0);
    // One square, and half a margin on each side.
    let one = pack_uv(&shapes[..1], &UvPackParams { pixels: 16, margin_px: 2, ..params }).unwrap();
    assert!((one.scale - 14.0 / 16.0).abs() < 0.02, "{}", one.scale);
}

/// What a digit too many in one coordinate makes of three charts. A stock as narrow as they are wide has rows without end.
#[test]
fn needles_of_a_million_millions_are_packed_on_few_rows() {
    let needles = [[1.8e12, 0.7], [3.6e12, 0.4], [1.8e12, 0.07]];
    let shapes = needles.map(|[long, wide]| shape(rectangle(long, wide)));
    let params = UvPackParams { pixels: 1024, margin_px: 8, steps: 0, seed: 0 };
    // That it comes to an end is what is tested: it took hours.
    let packing = pack_uv(&shapes, &params).unwrap();
    assert!(packing.scale > 0.0 && packing.scale < 1e-12, "{}", packing.scale);
}
