//! Phase-field segmentation: values, the contract of flows, hierarchies, cuts.

mod values;

use cutflow::geometry::Geometry;
use cutflow::mesh::Mesh;
use cutflow::methods::flow::{Flow, Status};
use cutflow::methods::phasefield::{PhaseFieldFlow, PhaseFieldParams};

use crate::surfaces::Surface;

/// The flow on a surface, run to its end.
fn run(surface: &Surface, params: PhaseFieldParams) -> PhaseFieldFlow {
    let (mesh, geometry): (Mesh, Geometry) = (surface.mesh.clone(), surface.geometry.clone());
    let mut flow = PhaseFieldFlow::new(mesh, geometry, params).unwrap();
    while flow.step().unwrap().status == Status::Running {}
    flow
}
