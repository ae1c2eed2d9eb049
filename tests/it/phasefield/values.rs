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
        let params = PhaseFieldParams { epsilon, start: start.clone(), starts: 1, ..PhaseFieldParams::default() };
        let flow = run(&surface, params);
        let node = &flow.state().tree()[0];
        let m = flow.measure(0).unwrap();
        println!(
            "{} {epsilon} {start:?}: steps {} {:?} P {:.4} len {:.4} comp {:?} sharp {:?} err {:.1e} in {:.2?}",
            surface.mesh.vertex_count(), flow.steps(), flow.status(), node.terms.perimeter, m.length, m.components, m.sharp,
            node.terms.area_error, clock.elapsed()
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
        println!("{i} level {} P {:.4} len {:.4} {:?} obj {:.4} {:?} its {} conn {:.2e}", node.level, node.terms.perimeter, m.length, m.components, node.objective, node.status, node.history.len(), node.terms.connectedness);
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
            let params = PhaseFieldParams { omega, start: start.clone(), starts: 1, ..PhaseFieldParams::default() };
            let flow = run(&surface, PhaseFieldParams { omega: if omega == 0.0 { 1e-9 } else { omega }, ..params });
            let node = &flow.state().tree()[0];
            let m = flow.measure(0).unwrap();
            println!("w {omega} {start:?} steps {} {:?} P {:.3} len {:.3} J {:.3} {:?} conn {:.2e} sharp {:?} {:.2?}", flow.steps(), flow.status(), node.terms.perimeter, m.length, node.terms.yamabe, m.components, node.terms.connectedness, m.sharp, clock.elapsed());
        }
    }
}
