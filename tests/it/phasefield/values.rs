//! The values of the notes. Lengths are those of the unit sphere.

use std::f64::consts::PI;

use cutflow::methods::phasefield::Screening;

use super::*;

/// Perimeter and length of the root's interface.
fn lengths(flow: &PhaseFieldFlow) -> [f64; 2] {
    [flow.state().tree()[0].terms.perimeter, flow.measure(0).unwrap().length]
}

fn is_near(value: f64, expected: f64, relative: f64) -> bool {
    (value - expected).abs() < relative * expected
}

#[test]
fn a_sphere_is_halved_along_a_great_circle_with_the_energy_of_the_notes() {
    // Half a percent for the grid's orientation, a tenth for the length.
    for (n, epsilon, perimeter) in [(16, 0.12, 8.742), (32, 0.12, 8.8386), (32, 0.06, 8.7674)] {
        for start in [Start::Axes, Start::Random] {
            let params =
                PhaseFieldParams { epsilon, start, starts: 1, ..PhaseFieldParams::default() };
            let flow = run(&Surface::sphere(n), params);
            let [p, length] = lengths(&flow);
            assert!(is_near(p, perimeter, 5e-3), "{n} {epsilon}: P {p}");
            assert!(is_near(length, 2.0 * PI, 1e-3), "{n} {epsilon}: length {length}");
            assert_eq!(flow.measure(0).unwrap().components, [1, 1]);
        }
    }
}

#[test]
fn a_fine_sphere_has_the_energy_of_the_notes() {
    for start in [Start::Axes, Start::Random] {
        let params =
            PhaseFieldParams { epsilon: 0.06, start, starts: 1, ..PhaseFieldParams::default() };
        let flow = run(&Surface::sphere(64), params);
        let [p, length] = lengths(&flow);
        assert!(is_near(p, 8.8521, 5e-3), "P {p}");
        assert!(is_near(length, 2.0 * PI, 1e-3), "length {length}");
    }
}

#[test]
fn the_sharp_loss_of_a_hemisphere_is_the_exact_one() {
    let surface = Surface::sphere(32);
    let params = PhaseFieldParams { start: by(&surface, |p| p[2]), ..PhaseFieldParams::default() };
    for loss in flow(&surface, params).measure(0).unwrap().sharp {
        // Second order: 1e-3 at 2 562 vertices, 2.5e-4 here.
        assert!(is_near(loss, 1.183233, 1e-3), "{loss}");
    }
}

#[test]
fn the_second_split_of_a_sphere_is_a_half_circle() {
    let params =
        PhaseFieldParams { epsilon: 0.08, levels: 2, starts: 1, ..PhaseFieldParams::default() };
    let flow = run(&Surface::sphere(32), params);
    for (node, exact) in [(0, 2.0 * PI), (1, PI), (2, PI)] {
        let length = flow.measure(node).unwrap().length;
        // The level-set length of the notes.
        assert!(is_near(length, exact, 1e-3), "{node}: {length}");
    }
}

#[test]
fn a_torus_is_halved_along_two_minor_circles() {
    let surface = Surface::sample("torus");
    let scale = cutflow::methods::phasefield::length_scale(&surface.geometry);
    // The tube's radius: half the extent along the axis, the shortest of the three.
    let extent = (0..3)
        .map(|k| {
            let xs = surface.geometry.positions.iter().map(|p| p[k]);
            xs.clone().fold(f64::MIN, f64::max) - xs.fold(f64::MAX, f64::min)
        })
        .fold(f64::MAX, f64::min);
    let exact = 2.0 * PI * extent * scale;
    for start in [Start::Axes, Start::Random] {
        let params =
            PhaseFieldParams { epsilon: 0.15, start, starts: 1, ..PhaseFieldParams::default() };
        let flow = run(&surface, params);
        let measures = flow.measure(0).unwrap();
        assert_eq!(measures.components, [1, 1]);
        // A polygon of 72 sides is 3e-4 short; on the outer side circles may lean.
        assert!(is_near(measures.length, exact, 2e-3), "{} {exact}", measures.length);
    }
}

#[test]
fn distortion_lengthens_the_interface_and_its_price_connects_what_would_be_islands() {
    let surface = Surface::sphere(12);
    let solved = |omega, is_connected| {
        let params = PhaseFieldParams {
            epsilon: 0.2,
            omega,
            is_connected,
            start: Start::Random,
            starts: 1,
            ..PhaseFieldParams::default()
        };
        let flow = run(&surface, params);
        flow.measure(0).unwrap()
    };
    let plain = solved(0.0, true);
    let apart = solved(5.0, false);
    let joined = solved(5.0, true);
    assert!(is_near(plain.length, 2.0 * PI, 1e-2) && joined.length > 2.0 * plain.length);
    assert!(joined.sharp.iter().sum::<f64>() < 0.2 * plain.sharp.iter().sum::<f64>());
    assert!(apart.components.iter().any(|&c| c > 1), "{apart:?}");
    assert_eq!(joined.components, [1, 1]);
}

#[test]
fn distortion_of_the_sphere_is_that_of_the_notes() {
    let surface = Surface::sphere(16);
    // Bands: local minima differ.
    for (omega, length, loss) in [(0.0, 2.0 * PI, 23.3), (1.0, 11.2, 5.9), (5.0, 15.0, 2.1)] {
        let params = PhaseFieldParams {
            omega,
            start: Start::Axes,
            starts: 1,
            ..PhaseFieldParams::default()
        };
        let flow = run(&surface, params);
        let found = flow.state().tree()[0].terms.yamabe;
        assert!(is_near(lengths(&flow)[1], length, 0.05), "{omega}: {:?}", lengths(&flow));
        assert!(is_near(found, loss, 0.05), "{omega}: {found}");
    }
}

#[test]
fn halves_of_the_sphere_have_the_diffuse_losses_of_the_notes() {
    let surface = Surface::sphere(32);
    for (screening, epsilon, expected) in [
        (Screening::Paper, 0.12, 23.93),
        (Screening::Paper, 0.06, 19.15),
        (Screening::Sharp, 0.12, 4.58),
        (Screening::Sharp, 0.06, 3.37),
    ] {
        let params = PhaseFieldParams { epsilon, screening, ..PhaseFieldParams::default() };
        let flow = run(&surface, params);
        // Without a price it is measured at the end. The notes do not name their mesh; ours are within 2 %.
        let found = flow.state().tree()[0].terms.yamabe;
        assert!(is_near(found, expected, 0.02), "{screening:?} {epsilon}: {found}");
    }
}

#[test]
fn a_price_on_distortion_moves_the_border_where_grey_gains_nothing() {
    let surface = Surface::sphere(16);
    let sharp = |screening| {
        // From noise: the great circle that axes of inertia give is a saddle.
        let start = Start::Random;
        let params = PhaseFieldParams {
            omega: 5.0,
            start,
            starts: 1,
            screening,
            ..PhaseFieldParams::default()
        };
        run(&surface, params).measure(0).unwrap().sharp.iter().sum::<f64>()
    };
    // Of hemispheres, where grey rims pay, and of the two bands of a tennis ball.
    assert!((sharp(Screening::Sharp) - 2.366).abs() < 0.05);
    let moved = sharp(Screening::Outside);
    assert!(moved < 0.3, "{moved}");
}
