//! Phase-field segmentation: values, the contract of flows, hierarchies, cuts.

mod cuts;
mod running;
mod values;

use std::sync::Arc;

use cutflow::methods::flow::{Flow, Status};
use cutflow::methods::phasefield::{PhaseFieldFlow, PhaseFieldParams, Start};

use crate::surfaces::Surface;

fn flow(surface: &Surface, params: PhaseFieldParams) -> PhaseFieldFlow {
    PhaseFieldFlow::new(surface.mesh.clone(), surface.geometry.clone(), params).unwrap()
}

fn finish(flow: &mut PhaseFieldFlow) {
    while flow.step().unwrap().status == Status::Running {}
}

/// The flow on a surface, run to its end.
fn run(surface: &Surface, params: PhaseFieldParams) -> PhaseFieldFlow {
    let mut flow = flow(surface, params);
    finish(&mut flow);
    flow
}

/// Options for a small sphere.
fn coarse() -> PhaseFieldParams {
    PhaseFieldParams { epsilon: 0.3, ..PhaseFieldParams::default() }
}

/// A start with the sign of a function of places.
fn by(surface: &Surface, f: impl Fn([f64; 3]) -> f64) -> Start {
    let values = surface.geometry.positions.iter().map(|p| f([p.x, p.y, p.z])).collect();
    Start::Values(Arc::new(values))
}
