//! What the flow reaches on two meshes with many patches: energies after so many steps, from normal clusters.

use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial, Topology};
use cutflow::methods::flow::{Flow, Status};

use crate::{Row, params, shared};

/// All of them; limits are one percent above the best that is known.
pub fn rows() -> Vec<Row> {
    let mut rows = Vec::new();
    for (name, limits) in [
        ("spot.obj", [(50, 24.9 * 1.01), (130, 24.1 * 1.01)]),
        ("rocker-arm.obj", [(50, 22.8 * 1.01), (120, 20.9 * 1.01)]),
    ] {
        let Some((mesh, geometry)) = shared(name) else { continue };
        let clusters = Initial::NormalClusters { angle: 60f64.to_radians(), regions: 10 };
        let params =
            CutFlowParams { topology: Topology::Free, coarse_to_fine: true, ..params(0.0, 3000.0) };
        let mut flow =
            CutFlow::new(mesh, geometry, &clusters, params).expect("the surface can be cut");
        for (steps, limit) in limits {
            while flow.steps() < steps && flow.status() == Status::Running {
                flow.step().expect("the surface can be cut");
            }
            rows.push(Row {
                name: format!("J of {name}, normal clusters, w_H 3000, after {steps} steps"),
                value: flow.state().energy().total,
                unit: "",
                limit: Some(limit),
            });
        }
    }
    rows
}
