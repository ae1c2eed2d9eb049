//! Charts on a sheet: apart, squarish, still while they change, and the same whatever their last digits are.

use std::f64::consts::TAU;

use cutflow::flatten::{Packing, Shape, pack};
use cutflow::session::{Command, Session, Value, samples};
use nalgebra::{Point2, Vector2};

use crate::scripts::set;

/// Ellipses and wedges of many sizes, each turned somehow.
fn shapes(count: u32, time: f64) -> Vec<Vec<Point2<f64>>> {
    (0..count)
        .map(|i| {
            let f = f64::from(i);
            let size = 0.05 + 0.4 * (f * 0.37).sin().powi(2) + 0.02 * (time + f).sin();
            let flatness = 0.3 + 0.6 * (f * 0.71).cos().powi(2);
            (0..40)
                .map(|k| {
                    let t = TAU * f64::from(k) / 40.0;
                    let p = Vector2::new(
                        size * t.cos(),
                        size * flatness * t.sin() * (1.0 + 0.3 * t.cos()),
                    );
                    Point2::from(nalgebra::Rotation2::new(f + 0.3 * time) * p)
                })
                .collect()
        })
        .collect()
}

fn pack_outlines(outlines: &[Vec<Point2<f64>>], previous: Option<&Packing>) -> Packing {
    // Outline points double as landmarks here; in a flow those are the surface's own vertices.
    let landmarks: Vec<Vec<(u32, Point2<f64>)>> = outlines
        .iter()
        .enumerate()
        .map(|(i, o)| (0u32..).zip(o).map(|(k, &p)| (1000 * i as u32 + k, p)).collect())
        .collect();
    let shapes: Vec<Shape> = outlines
        .iter()
        .zip(&landmarks)
        .map(|(outline, landmarks)| Shape { outline, landmarks })
        .collect();
    pack(&shapes, 0.02, previous)
}

fn assert_lies_on_sheet(outlines: &[Vec<Point2<f64>>], packing: &Packing) {
    let tolerance = 1e-12;
    for (i, outline) in outlines.iter().enumerate() {
        let own = packing.boxes[i];
        let high = own.low + own.size;
        assert!(own.low.x >= -tolerance && own.low.y >= -tolerance);
        assert!(high.x <= packing.sheet.x + tolerance && high.y <= packing.sheet.y + tolerance);
        for &p in outline {
            let p = packing.poses[i].apply(p);
            assert!(p.x >= own.low.x - tolerance && p.x <= high.x + tolerance);
            assert!(p.y >= own.low.y - tolerance && p.y <= high.y + tolerance);
        }
        for other in &packing.boxes[..i] {
            let apart = |axis: usize| {
                let gap = (own.low[axis] - other.low[axis] - other.size[axis])
                    .max(other.low[axis] - own.low[axis] - own.size[axis]);
                gap >= 0.02 - tolerance
            };
            assert!(apart(0) || apart(1), "boxes overlap");
        }
    }
}

#[test]
fn of_a_chart_that_parts_the_larger_part_stays() {
    // Sizes about the number of landmarks from which on not all are looked at.
    for [large, small] in [[1000u32, 600], [2000, 999], [5000, 990]] {
        let strip = |from: u32, to: u32| -> Vec<(u32, Point2<f64>)> {
            let place = |i: u32| Point2::new(f64::from(i), f64::from(i * 7 % 100));
            (from..to).map(|i| (i, place(i))).collect()
        };
        let outline = |from: u32, to: u32| {
            let [a, b] = [f64::from(from), f64::from(to)];
            [[a, 0.0], [b, 0.0], [b, 100.0], [a, 100.0]].map(Point2::from)
        };
        let (all, whole) = (strip(0, large + small), outline(0, large + small));
        let before = pack(&[Shape { outline: &whole, landmarks: &all }], 1.0, None);
        let cuts = [(0, small), (small, large + small)];
        let parts = cuts.map(|(from, to)| (outline(from, to), strip(from, to)));
        let shapes = parts.each_ref().map(|(o, l)| Shape { outline: o, landmarks: l });
        let after = pack(&shapes, 1.0, Some(&before));
        // Known landmarks turn the larger part as the whole was; the other one lies as if it were new.
        assert!((after.poses[1].angle - before.poses[0].angle).abs() < 1e-9, "{large} {small}");
        assert!(after.boxes[1].low.coords.norm() < 1e-9, "{large} {small}: {:?}", after.boxes);
    }
}

#[test]
fn packed_charts_keep_their_gap_and_fill_a_squarish_sheet() {
    for count in [1, 2, 3, 7, 30, 200] {
        let outlines = shapes(count, 0.0);
        let packing = pack_outlines(&outlines, None);
        assert_lies_on_sheet(&outlines, &packing);
        assert_eq!(packing, pack_outlines(&outlines, None), "deterministic");
        let boxes: f64 = packing.boxes.iter().map(|b| b.size.product()).sum();
        let side = packing.sheet.max();
        if count >= 7 {
            assert!(boxes / (side * side) > 0.6, "{count}: {}", boxes / (side * side));
        }
    }
}

#[test]
fn the_smallest_rectangle_is_found_whatever_the_direction() {
    let mut outline: Vec<Point2<f64>> = Vec::new();
    for k in 0..50 {
        let t = TAU * f64::from(k) / 50.0;
        outline.push(Point2::new(3.0 * t.cos().powi(3), t.sin()));
    }
    outline.extend([[3.0, 1.0], [3.0, -1.0], [-3.0, -1.0], [-3.0, 1.0]].map(Point2::from));
    for k in 0..40 {
        let turned: Vec<Point2<f64>> = outline
            .iter()
            .map(|p| nalgebra::Rotation2::new(0.1 + f64::from(k) * 0.17) * p)
            .collect();
        let packing = pack_outlines(&[turned], None);
        assert!((packing.sheet - Vector2::new(6.0, 2.0)).norm() < 1e-12, "{}", packing.sheet);
    }
}

#[test]
fn charts_do_not_jump_while_they_change() {
    let mut previous: Option<(Packing, Vec<Vec<Point2<f64>>>)> = None;
    let mut jumps = 0;
    for frame in 0..120 {
        let outlines = shapes(25, 0.05 * f64::from(frame));
        let packing = pack_outlines(&outlines, previous.as_ref().map(|(packing, _)| packing));
        assert_lies_on_sheet(&outlines, &packing);
        if let Some((last, last_outlines)) = &previous {
            let moved = (0..25)
                .flat_map(|i| outlines[i].iter().zip(&last_outlines[i]).map(move |pair| (i, pair)))
                .map(|(i, (p, q))| (packing.poses[i].apply(*p) - last.poses[i].apply(*q)).norm())
                .fold(0.0, f64::max);
            // Shapes change by 0.001 a frame and turn by 0.015; neighbours add up, and a turn is at most 4°.
            jumps += usize::from(moved > 0.1);
        }
        previous = Some((packing, outlines));
    }
    assert!(jumps <= 1, "{jumps} jumps in 120 frames");
    // The same charts again: nothing moves at all.
    let (packing, outlines) = previous.unwrap();
    let again = pack_outlines(&outlines, Some(&packing));
    for (a, b) in packing.poses.iter().zip(&again.poses) {
        assert!((a.shift - b.shift).norm() < 1e-12 && (a.angle - b.angle).abs() < 1e-9);
    }
    // One chart less and one more: the others stay near.
    let mut fewer = outlines.clone();
    fewer.remove(24);
    let fewer = pack_outlines(&fewer, Some(&packing));
    for i in 0..24 {
        assert!((packing.boxes[i].low - fewer.boxes[i].low).norm() < 0.5);
    }
}

#[test]
fn symmetric_charts_lie_the_same_way_whatever_their_last_digits() {
    // Disks, an ellipse and a square with as many smallest rectangles as they have sides, two of a size.
    let exact: Vec<Vec<Point2<f64>>> = [(1.0, 1.0), (1.0, 1.0), (1.0, 0.5), (0.7, 0.7)]
        .iter()
        .enumerate()
        .map(|(i, (a, b))| {
            let sides = if i == 3 { 4 } else { 48 };
            let angle = |k: u32| TAU * f64::from(k) / f64::from(sides);
            let turn = nalgebra::Rotation2::new(0.4 * i as f64);
            (0..sides).map(|k| turn * Point2::new(a * angle(k).cos(), b * angle(k).sin())).collect()
        })
        .collect();
    let wanted = pack_outlines(&exact, None);
    for round in 1..40 {
        let noise =
            |i: usize, k: usize| f64::from(((i * 97 + k * 13 + round * 31) % 17) as u8) - 8.0;
        let noisy: Vec<Vec<Point2<f64>>> = exact
            .iter()
            .enumerate()
            .map(|(i, outline)| {
                let shaken = |(k, p): (usize, &Point2<f64>)| {
                    p + 1e-14 * Vector2::new(noise(i, k), noise(i, 3 * k + 1))
                };
                // The frame of the flattening is its own: turned, too.
                let turn = nalgebra::Rotation2::new(0.2 * round as f64);
                outline.iter().enumerate().map(shaken).map(|p| turn * p).collect()
            })
            .collect();
        let found = pack_outlines(&noisy, None);
        for (i, (one, other)) in exact.iter().zip(&noisy).enumerate() {
            for (p, q) in one.iter().zip(other) {
                let off = (wanted.poses[i].apply(*p) - found.poses[i].apply(*q)).norm();
                assert!(off < 1e-11, "round {round}, chart {i}: {off}");
            }
        }
    }
}

/// The ball as a file, every coordinate off by some units of the last place.
fn shaken_ball(round: u32) -> Vec<u8> {
    let soup = samples::generate("ball").unwrap();
    let mut text = String::new();
    for (i, place) in soup.positions.iter().enumerate() {
        let shaken = [0, 1, 2].map(|k| {
            let noise = (i as u32 * 7 + k * 13 + round * 31) * u32::from(round > 0) % 17;
            place[k as usize] * (1.0 + f64::EPSILON * (f64::from(noise) - 8.0))
        });
        text += &format!("v {} {} {}\n", shaken[0], shaken[1], shaken[2]);
    }
    for i in 0..soup.polygon_count() {
        let corners = soup.polygon(i);
        text += &format!("f {} {} {}\n", corners[0] + 1, corners[1] + 1, corners[2] + 1);
    }
    text.into_bytes()
}

#[test]
fn the_layout_of_a_symmetric_flow_is_the_same_whatever_its_last_digits() {
    let steps = |round: u32| -> Vec<Vec<[f32; 2]>> {
        let mut session = Session::new();
        session.open("ball.obj", &shaken_ball(round));
        set(&mut session, "coarse", Value::Truth(false));
        set(&mut session, "init", Value::Text("plane".into()));
        let step = |_| {
            session.handle(Command::Step);
            let scene = session.scene().unwrap();
            scene.charts.as_chunks().0[..1000].to_vec()
        };
        (0..8).map(step).collect()
    };
    let wanted = steps(0);
    for round in 1..4 {
        for (step, (wanted, found)) in wanted.iter().zip(steps(round)).enumerate() {
            // Vertices on the cut itself may lie on either side of it.
            let off = |(p, q): (&[f32; 2], &[f32; 2])| (p[0] - q[0]).hypot(p[1] - q[1]);
            let away = wanted.iter().zip(&found).filter(|&pair| off(pair) > 0.01).count();
            assert!(away < 20, "round {round}, step {step}: {away} of {}", wanted.len());
        }
    }
}
