//! Under `preserve` a sphere that starts with one closed curve ends with one, on every mesh, with every weight and cap.

use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Topology};
use cutflow::methods::flow::{Flow, Status};

use crate::cutting::{flow, plane, regions, weights};
use crate::surfaces::Surface;

/// Tennis ball, the symmetric one, and a weight that makes the seam wind.
const WEIGHTS: [[f64; 2]; 3] = [[3.0, 2.0], [3.0, 4.0], [10.0, 2.0]];

/// The smallest cap that the page offers, the default, the largest that the flow takes.
const CAPS: [f64; 3] = [0.1, 1.0, 2.0];

/// Two connected regions on a sphere have one closed curve between them.
fn run(mut flow: CutFlow, steps: usize, name: &str) -> CutFlow {
    assert_eq!(regions(&flow), 2, "{name}");
    for _ in 0..steps {
        let report = flow.step().unwrap();
        assert_eq!(regions(&flow), 2, "{name}, step {}", report.step);
        if report.status != Status::Running {
            break;
        }
    }
    flow
}

fn all(frequency: u32, coarse_to_fine: bool, steps: impl Fn(f64) -> usize) {
    for [dirichlet, length] in WEIGHTS {
        for cap in CAPS {
            let base = weights(dirichlet, 0.0, length);
            let topology = Topology::Preserve;
            let params = CutFlowParams { cap, topology, coarse_to_fine, tolerance: 1e-4, ..base };
            let surface = Surface::sphere(frequency);
            let name = format!("{}, w_D {dirichlet}, α {length}, cap {cap}", surface.name);
            // Symmetric starts are the hard ones: they pass through saddles.
            let start = flow(surface, &plane(0.0, 0.0, 1.0), params);
            let before = start.state().energy().total;
            let end = run(start, steps(cap), &name);
            assert!(end.state().energy().total < before, "{name}");
        }
    }
}

#[test]
fn one_closed_curve_on_2562_vertices_to_the_end_of_every_run() {
    all(16, false, |cap| if cap < 0.5 { 150 } else { 60 });
}

#[test]
fn one_closed_curve_on_10242_vertices_for_many_steps() {
    all(32, false, |cap| if cap < 0.5 { 15 } else { 25 });
}

/// Coarse surfaces make the long way; `cargo xtask bench` also runs these without them, to the end.
#[test]
fn one_closed_curve_on_40962_vertices_from_coarse_to_fine() {
    all(64, true, |_| 2);
}
