//! The contract of flows, options that change under way, and what is refused.

use cutflow::methods::flow::SolveError;
use cutflow::methods::phasefield::{Screening, epsilon_floor};

use super::*;

#[test]
fn a_run_repeats_bit_for_bit_descends_goes_on_from_a_checkpoint_and_ends_quietly() {
    let surface = Surface::sphere(8);
    for params in [
        PhaseFieldParams { levels: 2, start: Start::Random, warm_up: 5, ..coarse() },
        PhaseFieldParams { levels: 2, is_joint: true, ..coarse() },
        PhaseFieldParams { omega: 1.0, starts: 1, screening: Screening::Sharp, ..coarse() },
        PhaseFieldParams { omega: 1.0, levels: 2, screening: Screening::Outside, ..coarse() },
    ] {
        let whole = run(&surface, params.clone());
        assert_eq!(whole.status(), Status::Converged);
        for node in whole.state().tree().iter().filter(|n| n.children.is_some()) {
            // One rise is told of: where unconnected phases begin to cost.
            let rises = node.history.windows(2).filter(|e| e[1] > e[0] * (1.0 + 1e-12)).count();
            assert!(rises <= 1, "{:?}", node.history);
        }
        let total = whole.steps();
        for split in [1, total / 3, total / 2, total - 1] {
            let mut first = flow(&surface, params.clone());
            for _ in 0..split {
                first.step().unwrap();
            }
            let checkpoint = first.checkpoint();
            let mut second = flow(&surface, params.clone());
            second.step().unwrap();
            second.restore(&checkpoint);
            assert_eq!(first.state(), second.state());
            finish(&mut second);
            assert_eq!((second.steps(), second.state()), (total, whole.state()), "{split}");
            let (mesh, geometry) = (surface.mesh.clone(), surface.geometry.clone());
            let mut third =
                PhaseFieldFlow::resume(mesh, geometry, &checkpoint, params.clone()).unwrap();
            finish(&mut third);
            assert_eq!(third.state(), whole.state(), "{split}");
        }
        let mut whole = whole;
        let state = whole.state().clone();
        let report = whole.step().unwrap();
        assert_eq!((report.step, whole.state()), (total, &state));
    }
}

#[test]
fn the_objective_of_one_start_never_rises_and_areas_are_kept_at_every_step() {
    let surface = Surface::sphere(8);
    let params = PhaseFieldParams {
        start: Start::Random,
        starts: 1,
        warm_up: 0,
        omega: 2.0,
        fraction: 0.3,
        ..coarse()
    };
    let mut flow = flow(&surface, params);
    let mut before = f64::INFINITY;
    loop {
        let report = flow.step().unwrap();
        // Sums of hundreds of terms.
        assert!(report.energy[0].1 <= before * (1.0 + 1e-12));
        before = report.energy[0].1;
        let sum: f64 = report.energy[1..].iter().map(|e| e.1).sum();
        assert!((sum - before).abs() < 1e-12 * before, "terms add up");
        let terms = flow.state().tree()[0].terms;
        assert!(terms.area_error < 1e-12 && (terms.area_fraction - 0.3).abs() < 1e-12);
        if report.status != Status::Running {
            break;
        }
    }
    assert_eq!(flow.status(), Status::Converged);
}

#[test]
fn options_change_under_way_and_after_the_end() {
    let surface = Surface::sphere(10);
    let params = coarse();
    let mut flow = flow(&surface, params.clone());
    for _ in 0..3 {
        flow.step().unwrap();
    }
    // Before the end: another width and another share.
    let wider = PhaseFieldParams { epsilon: 0.35, fraction: 0.25, ..params };
    flow.set_params(wider.clone()).unwrap();
    finish(&mut flow);
    let node = &flow.state().tree()[0];
    assert!((node.terms.area_fraction - 0.25).abs() < 1e-12);
    // A cap of a quarter of the area has a rim of length 2π sin 60°; the share is that of the diffuse phase, the mesh coarse.
    let length = flow.measure(0).unwrap().length;
    assert!((length - 5.441).abs() < 0.05, "{length}");
    // More levels split on and leave the first split alone.
    let root = node.u.clone();
    let deeper = PhaseFieldParams { levels: 3, ..wider.clone() };
    flow.set_params(deeper).unwrap();
    assert_eq!(flow.status(), Status::Running);
    finish(&mut flow);
    assert_eq!(flow.state().leaves().len(), 8);
    assert_eq!(flow.state().tree()[0].u, root);
    // Distortion on: everything moves, from the root down, from where it is.
    let two = PhaseFieldParams { levels: 2, ..wider };
    flow.set_params(two.clone()).unwrap();
    assert_eq!((flow.state().leaves().len(), flow.status()), (4, Status::Converged));
    assert_eq!(flow.state().tree()[0].u, root);
    let before = flow.steps();
    flow.set_params(PhaseFieldParams { omega: 0.5, ..two.clone() }).unwrap();
    finish(&mut flow);
    assert!(flow.steps() > before && flow.state().tree()[0].u != root);
    // Refused options change nothing.
    let state = flow.state().clone();
    let thin = PhaseFieldParams { epsilon: 0.01, ..two };
    assert!(matches!(flow.set_params(thin), Err(SolveError::EpsilonTooSmall { .. })));
    assert_eq!(flow.state(), &state);
}

#[test]
fn another_share_moves_interfaces_of_all_levels_and_they_stay_interfaces() {
    let surface = Surface::sphere(10);
    let params = |fraction| PhaseFieldParams {
        levels: 2,
        omega: 1.0,
        screening: Screening::Outside,
        fraction,
        ..coarse()
    };
    let mut flow = run(&surface, params(0.5));
    let halved = flow.costs().iter().sum::<f64>();
    for fraction in [0.25, 0.5, 0.1, 0.6] {
        flow.set_params(params(fraction)).unwrap();
        finish(&mut flow);
        assert_eq!(flow.status(), Status::Converged);
        for node in flow.state().tree().iter().filter(|n| n.children.is_some()) {
            assert!((node.terms.area_fraction - fraction).abs() < 1e-10);
            // A little beyond ±1 is what curved interfaces have.
            assert!(node.u.iter().all(|u| u.abs() < 1.3), "{fraction}: no phase beyond ±1");
        }
        let fresh = run(&surface, params(fraction)).costs().iter().sum::<f64>();
        let found = flow.costs().iter().sum::<f64>();
        // Local minima differ.
        assert!(found < 1.08 * fresh, "{fraction}: {found} and {fresh}");
        let is_half = (fraction - 0.5f64).abs() < 1e-9;
        assert!(!is_half || found < 1.1 * halved);
    }
}

#[test]
fn segments_of_a_hand_have_their_areas_after_its_finger_tips_were_given_up() {
    let Some(surface) = Surface::shared("hand.obj") else { return };
    let params = PhaseFieldParams {
        epsilon: 0.08,
        omega: 1.0,
        screening: Screening::Sharp,
        starts: 1,
        max_steps: 60,
        ..PhaseFieldParams::default()
    };
    let flow = run(&surface, params);
    let areas = surface.geometry.vertex_dual_areas(&surface.mesh);
    let whole: f64 = areas.iter().sum();
    for weight in flow.state().leaf_weights() {
        let share: f64 = weight.iter().zip(&areas).map(|(w, a)| w * a).sum::<f64>() / whole;
        assert!((share - 0.5).abs() < 1e-4, "{share}");
    }
    assert_eq!(flow.measure(0).unwrap().components, [1, 1]);
}

#[test]
fn chart_weights_add_up_and_leave_no_tails_along_borders_of_ancestors() {
    let surface = Surface::sphere(12);
    let flow = run(&surface, PhaseFieldParams { levels: 2, epsilon: 0.2, ..coarse() });
    let (state, labels) = (flow.state(), flow.state().labels());
    let weights = state.chart_weights();
    assert!((0..labels.len()).all(|v| {
        let sum: f64 = weights.iter().map(|w| w[v]).sum();
        (sum - 1.0).abs() < 1e-14 && weights.iter().all(|w| w[v] >= 0.0)
    }));
    // A quarter of the sphere's border is two half circles; tails would follow the whole first circle, up to its far side.
    let positions = &surface.geometry.positions;
    for (leaf, weight) in weights.iter().enumerate() {
        let own: Vec<usize> = (0..labels.len()).filter(|&v| labels[v] as usize == leaf).collect();
        let reached = (0..labels.len()).filter(|&v| weight[v] > 0.0);
        for v in reached {
            let nearest = own.iter().map(|&w| (positions[v] - positions[w]).norm());
            // Within the interface, 2 ε on either side, at area 1.
            assert!(nearest.fold(f64::INFINITY, f64::min) < 0.113, "leaf {leaf}, vertex {v}");
        }
    }
}

#[test]
fn all_levels_relaxed_together_are_no_worse_than_one_after_the_other() {
    let surface = Surface::sample("rounded_box");
    let floor = epsilon_floor(&surface.geometry);
    let params = PhaseFieldParams {
        epsilon: floor.max(0.15),
        levels: 2,
        starts: 1,
        ..PhaseFieldParams::default()
    };
    let alone = run(&surface, params.clone());
    let together = run(&surface, PhaseFieldParams { is_joint: true, ..params });
    let total =
        |flow: &PhaseFieldFlow| -> f64 { flow.state().tree().iter().map(|n| n.objective).sum() };
    assert!(total(&together) < total(&alone), "{} {}", total(&together), total(&alone));
    for node in together.state().tree().iter().filter(|n| n.children.is_some()) {
        assert!(node.terms.area_error < 1e-12);
    }
}

#[test]
fn what_makes_no_sense_is_refused_with_names_and_numbers() {
    let surface = Surface::sphere(12);
    let new = |params| {
        PhaseFieldFlow::new(surface.mesh.clone(), surface.geometry.clone(), params).err().unwrap()
    };
    let floor = epsilon_floor(&surface.geometry);
    let named = |name: &str, params: PhaseFieldParams| match new(params) {
        SolveError::Parameter { name: found, .. } => assert_eq!(found, name),
        other => panic!("{name}: {other}"),
    };
    let base = PhaseFieldParams { epsilon: floor, ..PhaseFieldParams::default() };
    named("interface width", PhaseFieldParams { epsilon: f64::NAN, ..base.clone() });
    named("area fraction", PhaseFieldParams { fraction: 1.0, ..base.clone() });
    named("levels", PhaseFieldParams { levels: 0, ..base.clone() });
    named("levels", PhaseFieldParams { levels: 6, ..base.clone() });
    named("starts", PhaseFieldParams { starts: 0, ..base.clone() });
    named("distortion weight", PhaseFieldParams { omega: -1.0, ..base.clone() });
    let values = |values: Vec<f64>| Start::Values(Arc::new(values));
    named(
        "number of start values",
        PhaseFieldParams { start: values(vec![1.0; 3]), ..base.clone() },
    );
    let bad = PhaseFieldParams {
        start: values(vec![f64::NAN; surface.mesh.vertex_count()]),
        ..base.clone()
    };
    named("start value", bad);
    let thin = PhaseFieldParams { epsilon: 0.2 * floor, ..base.clone() };
    assert_eq!(new(thin), SolveError::EpsilonTooSmall { epsilon: 0.2 * floor, floor });
    let narrow = PhaseFieldParams { epsilon: 0.8 * floor, ..base.clone() };
    let notice = flow(&surface, narrow).epsilon_notice().unwrap();
    assert_eq!(notice.floor, floor);
    assert!(flow(&surface, base).epsilon_notice().is_none());
}

#[test]
fn size_and_place_of_a_surface_do_not_matter() {
    let surface = Surface::sphere(8);
    let lengths = [1.0, 1e3].map(|size| {
        let positions = surface.geometry.positions.iter().map(|p| p * size).collect();
        let geometry = cutflow::geometry::Geometry::new(&surface.mesh, positions).unwrap();
        let mut flow = PhaseFieldFlow::new(surface.mesh.clone(), geometry, coarse()).unwrap();
        finish(&mut flow);
        flow.measure(0).unwrap().length
    });
    // Both stop where ten iterations gained 1e-6.
    assert!((lengths[0] - lengths[1]).abs() < 1e-3, "{lengths:?}");
}
