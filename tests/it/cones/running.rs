//! The contract of flows, the path over λ, and aiming on it.

use cutflow::methods::cones::{Cone, ConeBoundary, ConeError, ConeMethod, ConePath, ConeTarget};
use cutflow::methods::flow::SolveError;

use super::*;

fn build((positions, triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>)) -> (Mesh, Geometry) {
    unit(&positions, &triangles)
}

#[test]
fn a_run_repeats_bit_for_bit_descends_goes_on_from_a_checkpoint_and_ends_quietly() {
    let auto = at(6e-5);
    let newton = ConeParams { method: ConeMethod::Newton, ..auto };
    let coarse = ConeParams { multiresolution: true, ..auto };
    let polygonal = ConeParams { boundary: ConeBoundary::Polygonal, ..at(0.0015) };
    for (surface, params) in [
        (build(blob(7)), auto),
        (build(blob(7)), newton),
        (build(blob(21)), coarse),
        (build(sheet(12)), polygonal),
    ] {
        let new = || flow(&surface.0, &surface.1, &params, &ConeFields::default());
        let (mut whole, mut energies) = (new(), Vec::new());
        for _ in 0..400 {
            let report = whole.step().unwrap();
            energies.push(report.energy[0].1);
            if report.status != Status::Running {
                break;
            }
        }
        assert_eq!(whole.status(), Status::Converged);
        // Rounding of a sum of hundreds of terms.
        assert!(energies.windows(2).all(|e| e[1] <= e[0] * (1.0 + 1e-10)), "{energies:?}");
        let total = whole.steps();
        for split in [1, total / 3, total - 1] {
            let mut first = new();
            for _ in 0..split {
                first.step().unwrap();
            }
            let checkpoint = first.checkpoint();
            let mut second = new();
            second.step().unwrap();
            second.restore(&checkpoint).unwrap();
            assert_eq!(first.state(), second.state());
            while second.step().unwrap().status == Status::Running {}
            assert_eq!((second.steps(), second.state()), (total, whole.state()), "{split}");
        }
        let state = whole.state().clone();
        let report = whole.step().unwrap();
        assert_eq!((report.step, whole.state()), (total, &state));
    }
}

#[test]
fn on_the_path_angle_falls_and_distortion_grows_with_the_price() {
    for surface in [build(sheet(12)), build(blob(7)), build(ring(14, 30))] {
        let (mesh, geometry) = &surface;
        let lambda = price(mesh, geometry, 0.3);
        let mut flow = flow(mesh, geometry, &at(lambda), &ConeFields::default());
        let home = solve(&mut flow).clone();
        let mut path = ConePath::new(9, 0.02, usize::MAX).unwrap();
        while !path.step(&mut flow).unwrap() {}
        assert_eq!(path.points().len(), 9);
        assert_eq!(flow.state(), &home, "the flow is where it was");
        for pair in path.points().windows(2) {
            assert!(pair[1].lambda < pair[0].lambda);
            assert!(pair[1].total_angle >= pair[0].total_angle - 1e-9);
            assert!(pair[1].int_u2 <= pair[0].int_u2 + 1e-9);
        }
        for point in &path.points()[..6] {
            let mut single =
                ConeFlow::new(mesh, geometry, &at(point.lambda), &ConeFields::default()).unwrap();
            let state = solve(&mut single);
            assert!(close(state.int_u2, point.int_u2, 1e-8));
            assert!((state.total_angle - point.total_angle).abs() < 1e-8);
        }
    }
}

#[test]
fn a_number_of_cones_an_angle_or_a_distortion_is_found_on_the_path() {
    let (mesh, geometry) = build(blob(8));
    let most = price(&mesh, &geometry, 1.0);
    let mut flow = flow(&mesh, &geometry, &at(0.2 * most), &ConeFields::default());
    let there = solve(&mut flow).clone();
    flow.set_lambda(most).unwrap();
    solve(&mut flow);
    flow.aim(ConeTarget::TotalAngle(there.total_angle)).unwrap();
    assert!(close(solve(&mut flow).total_angle, there.total_angle, 1.1e-4));
    flow.set_lambda(0.05 * most).unwrap();
    flow.aim(ConeTarget::Distortion(there.int_u2)).unwrap();
    assert!(close(solve(&mut flow).int_u2, there.int_u2, 1.1e-4));
    for limit in [120, 100, there.cones.len()] {
        // As many as the last one asks for are there at once: that price is not the smallest.
        flow.set_lambda(there.lambda).unwrap();
        solve(&mut flow);
        flow.aim(ConeTarget::Count(limit)).unwrap();
        let (count, lambda) = (solve(&mut flow).cones.len(), flow.state().lambda);
        assert!(count <= limit);
        assert!(limit != there.cones.len() || lambda <= there.lambda);
        flow.set_lambda(lambda * 0.995).unwrap();
        assert!(solve(&mut flow).cones.len() > limit);
    }
    // Gauss–Bonnet asks for 4π.
    flow.aim(ConeTarget::TotalAngle(1.0)).unwrap();
    let mut status = Status::Running;
    while status == Status::Running {
        status = flow.step().unwrap().status;
    }
    assert_eq!(status, Status::Infeasible);
    assert!((flow.state().total_angle - 2.0 * TAU).abs() < 1e-9);
}

#[test]
fn a_coarse_start_changes_nothing_in_the_result() {
    let surface = build(blob(21));
    let params = at(6e-5);
    let solved = |params: &ConeParams| {
        let mut flow = flow(&surface.0, &surface.1, params, &ConeFields::default());
        solve(&mut flow).clone()
    };
    let direct = solved(&params);
    for method in [ConeMethod::Greens, ConeMethod::Newton] {
        let state = solved(&ConeParams { multiresolution: true, method, ..params });
        let places = |s: &ConeState| s.cones.iter().map(|c| c.vertex).collect::<Vec<_>>();
        assert_eq!(places(&state), places(&direct));
        assert!(close(state.int_u2, direct.int_u2, 1e-9));
        assert!(close(state.total_angle, direct.total_angle, 1e-9));
    }
}

#[test]
fn given_cones_are_worth_what_the_optimum_says() {
    for (surface, boundary) in [
        (build(blob(7)), ConeBoundary::Isometric),
        (build(sheet(10)), ConeBoundary::Isometric),
        (build(sheet(10)), ConeBoundary::Optimal),
        (build(sheet(10)), ConeBoundary::Polygonal),
    ] {
        let lambda = price(&surface.0, &surface.1, 0.2);
        let params = ConeParams { boundary, ..at(lambda) };
        let mut flow = flow(&surface.0, &surface.1, &params, &ConeFields::default());
        let state = solve(&mut flow).clone();
        let evaluation = flow.evaluate(&state.cones).unwrap();
        assert!(close(evaluation.int_u2, state.int_u2, 1e-10));
        assert!(close(evaluation.total_angle, state.total_angle, 1e-12));
        let worst = evaluation.u.iter().zip(&state.u).map(|(a, b)| (a - b).abs());
        assert!(worst.fold(0.0, f64::max) < 1e-9);
    }
    let (mesh, geometry) = build(blob(5));
    let mut flow = flow(&mesh, &geometry, &at(0.01), &ConeFields::default());
    let Err(SolveError::Cones(ConeError::GaussBonnet { total, needed, .. })) =
        flow.evaluate(&[Cone { vertex: VertexId(0), angle: TAU }])
    else {
        panic!("a sphere needs 4π");
    };
    assert!((total - TAU).abs() < 1e-12 && (needed - 2.0 * TAU).abs() < 1e-9);
}

#[test]
fn fields_and_options_changed_under_way_give_what_a_new_flow_gives() {
    let (mesh, geometry) = build(blob(7));
    let mut old = flow(&mesh, &geometry, &at(1e-4), &ConeFields::default());
    solve(&mut old);
    let fields = ConeFields { free: vec![VertexId(5)], ..ConeFields::default() };
    old.set_fields(&fields).unwrap();
    let params = ConeParams { bounds: [-0.5, 1.2], ..at(6e-5) };
    old.set_params(&params).unwrap();
    let mut new = flow(&mesh, &geometry, &params, &fields);
    let (a, b) = (solve(&mut old).clone(), solve(&mut new));
    assert!(close(a.int_u2, b.int_u2, 1e-9));
    assert_eq!(a.cones.len(), b.cones.len());
    // What is refused leaves everything as it was.
    let wrong = ConeFields { fixed: vec![(VertexId(5), 9.0)], ..ConeFields::default() };
    assert!(old.set_fields(&wrong).is_err());
    assert_eq!(old.state(), &a);
}
