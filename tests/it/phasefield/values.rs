//! The values of the notes.

use super::*;
use cutflow::methods::phasefield::Start;

#[test]
#[ignore = "prints"]
fn table() {
    for (n, epsilon, start) in [
        (16, 0.12, Start::Random),
        (16, 0.12, Start::Axes),
        (32, 0.12, Start::Random),
        (32, 0.12, Start::Axes),
        (32, 0.06, Start::Random),
    ] {
        let clock = std::time::Instant::now();
        let surface = Surface::sphere(n);
        let params = PhaseFieldParams {
            epsilon,
            start: start.clone(),
            starts: 1,
            ..PhaseFieldParams::default()
        };
        let flow = run(&surface, params);
        let node = &flow.state().tree()[0];
        let m = flow.measure(0).unwrap();
        println!(
            "{} {epsilon} {start:?}: steps {} {:?} P {:.4} len {:.4} comp {:?} sharp {:?} err {:.1e} in {:.2?}",
            surface.mesh.vertex_count(),
            flow.steps(),
            flow.status(),
            node.terms.perimeter,
            m.length,
            m.components,
            m.sharp,
            node.terms.area_error,
            clock.elapsed()
        );
    }
}

#[test]
#[ignore = "prints"]
fn hierarchy() {
    let clock = std::time::Instant::now();
    let surface = Surface::sphere(32);
    let params = PhaseFieldParams { epsilon: 0.08, levels: 3, ..PhaseFieldParams::default() };
    let flow = run(&surface, params);
    for (i, node) in flow.state().tree().iter().enumerate().filter(|n| n.1.children.is_some()) {
        let m = flow.measure(i).unwrap();
        println!(
            "{i} level {} P {:.4} len {:.4} {:?} obj {:.4} {:?} its {} conn {:.2e}",
            node.level,
            node.terms.perimeter,
            m.length,
            m.components,
            node.objective,
            node.status,
            node.history.len(),
            node.terms.connectedness
        );
    }
    println!("{:?} {} steps {:.2?}", flow.status(), flow.steps(), clock.elapsed());
}

#[test]
#[ignore = "prints"]
fn omega() {
    for omega in [0.0, 1.0, 5.0] {
        for start in [Start::Axes, Start::Random] {
            let clock = std::time::Instant::now();
            let surface = Surface::sphere(16);
            let params = PhaseFieldParams {
                omega,
                start: start.clone(),
                starts: 1,
                ..PhaseFieldParams::default()
            };
            let flow = run(
                &surface,
                PhaseFieldParams { omega: if omega == 0.0 { 1e-9 } else { omega }, ..params },
            );
            let node = &flow.state().tree()[0];
            let m = flow.measure(0).unwrap();
            println!(
                "w {omega} {start:?} steps {} {:?} P {:.3} len {:.3} J {:.3} {:?} conn {:.2e} sharp {:?} {:.2?}",
                flow.steps(),
                flow.status(),
                node.terms.perimeter,
                m.length,
                node.terms.yamabe,
                m.components,
                node.terms.connectedness,
                m.sharp,
                clock.elapsed()
            );
        }
    }
}

#[test]
#[ignore = "prints"]
fn figures() {
    use cutflow::geometry::Laplacian;
    use cutflow::linalg::{Analysis, Factor};
    use std::time::Instant;
    for n in [32, 64] {
        let surface = Surface::sphere(n);
        let laplacian = Laplacian::new(&surface.mesh, &surface.geometry);
        let x: Vec<f64> = (0..surface.mesh.vertex_count()).map(|i| (i as f64).sin()).collect();
        let mut y = x.clone();
        let clock = Instant::now();
        for _ in 0..200 {
            laplacian.pattern.multiply(&laplacian.values, &x, &mut y);
        }
        let matvec = clock.elapsed().as_secs_f64() / 200.0;
        let mut values = laplacian.values.clone();
        for v in 0..x.len() {
            values[laplacian.pattern.diagonal(v)] += 0.01;
        }
        let analysis = std::sync::Arc::new(Analysis::new(laplacian.pattern).unwrap());
        let mut factor = Factor::new(analysis, &values).unwrap();
        let clock = Instant::now();
        for _ in 0..10 {
            factor.refactor(&values).unwrap();
        }
        let numeric = clock.elapsed().as_secs_f64() / 10.0;
        let clock = Instant::now();
        for _ in 0..10 {
            factor.solve(&mut y, 1);
        }
        let solve = clock.elapsed().as_secs_f64() / 10.0;
        println!(
            "n {n}: matvec {:.3} ms, factorisation {:.2} ms, solve {:.2} ms",
            matvec * 1e3,
            numeric * 1e3,
            solve * 1e3
        );
        for (name, omega, is_connected) in
            [("plain", 0.0, false), ("connected", 0.0, true), ("yamabe", 1.0, false)]
        {
            let params = PhaseFieldParams {
                omega,
                is_connected,
                start: Start::Random,
                warm_up: 20,
                starts: 1,
                tolerance: 0.0,
                ..PhaseFieldParams::default()
            };
            let mut flow =
                PhaseFieldFlow::new(surface.mesh.clone(), surface.geometry.clone(), params)
                    .unwrap();
            for _ in 0..40 {
                flow.step().unwrap();
            }
            let (before, f0) = (flow.evaluations(), flow.factorisations());
            let clock = Instant::now();
            for _ in 0..40 {
                flow.step().unwrap();
            }
            let step = clock.elapsed().as_secs_f64() / 40.0;
            println!(
                "{name}: step {:.3} ms = {:.1} matvecs; evaluations {} factorisations {}",
                step * 1e3,
                step / matvec,
                flow.evaluations() - before,
                flow.factorisations() - f0
            );
        }
    }
}

#[test]
#[ignore = "prints"]
fn islands() {
    for (omega, n) in [(2.0, 12), (5.0, 12), (10.0, 12)] {
        for seed in 1..4 {
            for is_connected in [false, true] {
                let surface = Surface::sphere(n);
                let params = PhaseFieldParams { epsilon: 0.2, omega, seed, start: Start::Random, starts: 1, is_connected, ..PhaseFieldParams::default() };
                let flow = run(&surface, params);
                let node = &flow.state().tree()[0];
                let m = flow.measure(0).unwrap();
                println!("w {omega} seed {seed} {is_connected} steps {} {:?} len {:.3} J {:.3} {:?} conn {:.2e}", flow.steps(), flow.status(), m.length, node.terms.yamabe, m.components, node.terms.connectedness);
            }
        }
    }
}

#[test]
#[ignore = "prints"]
fn torus() {
    use crate::surfaces::grid;
    let tau = std::f64::consts::TAU;
    let (points, triangles, _) = grid([120, 48], true, |s, t| {
        let (a, b) = (tau * s, tau * t);
        let r = 2.5 + b.cos();
        [r * a.cos(), r * a.sin(), b.sin()]
    });
    let _ = (points, triangles);
    for seed in 1..4 {
        for start in [Start::Random, Start::Axes] {
            for is_connected in [false, true] {
                let surface = Surface::sample("torus");
                let params = PhaseFieldParams { epsilon: 0.15, seed, start: start.clone(), starts: 1, is_connected, ..PhaseFieldParams::default() };
                let Ok(_) = PhaseFieldFlow::new(surface.mesh.clone(), surface.geometry.clone(), params.clone()) else { println!("eps"); continue };
                let flow = run(&surface, params);
                let m = flow.measure(0).unwrap();
                println!("{} {start:?} {is_connected} steps {} {:?} {:?} len {:.4} {:?}", surface.mesh.vertex_count(), flow.steps(), flow.status(), flow.epsilon_notice(), m.length, m.components);
            }
        }
    }
}
