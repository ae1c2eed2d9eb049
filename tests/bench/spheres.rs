//! One closed curve on 40 962 vertices, for every weight and cap, to the end: too long for the tests.

use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial, Topology};
use cutflow::methods::flow::{Flow, Status};
use nalgebra::{Point3, Vector3};

use crate::{Row, params, sphere};

/// Connected regions of equal label; two on a sphere have one closed curve between them.
fn regions(flow: &CutFlow) -> usize {
    let (mesh, labels) = (flow.mesh(), flow.state().labels());
    let mut seen = vec![false; labels.len()];
    let mut count = 0;
    for start in mesh.vertices() {
        if std::mem::replace(&mut seen[start.index()], true) {
            continue;
        }
        count += 1;
        let mut stack = vec![start];
        while let Some(v) = stack.pop() {
            for w in mesh.outgoing(v).map(|h| mesh.tip(h)) {
                let is_new = labels[w.index()] == labels[v.index()] && !seen[w.index()];
                if is_new {
                    seen[w.index()] = true;
                    stack.push(w);
                }
            }
        }
    }
    count
}

/// The largest number of curves that any step of any run had.
pub fn rows() -> Vec<Row> {
    let (mesh, geometry) = sphere(64);
    let mut rows = Vec::new();
    for [dirichlet, length] in [[3.0, 2.0], [3.0, 4.0], [10.0, 2.0]] {
        for (cap, most) in [(0.1, 150), (1.0, 80), (2.0, 80)] {
            let plane = Initial::Plane { point: Point3::origin(), normal: Vector3::z() };
            let mut params = params(dirichlet, 0.0);
            params.weights.length = length;
            let params =
                CutFlowParams { cap, topology: Topology::Preserve, tolerance: 1e-4, ..params };
            let mut flow = CutFlow::new(mesh.clone(), geometry.clone(), &plane, params)
                .expect("a sphere can be cut");
            let mut curves = 0;
            for _ in 0..most {
                let status = flow.step().expect("as above").status;
                curves = curves.max(regions(&flow) - 1);
                if status != Status::Running {
                    break;
                }
            }
            rows.push(Row {
                name: format!(
                    "curves, 40962 vertices, w_D {dirichlet}, α {length}, cap {cap}, {} steps",
                    flow.steps()
                ),
                value: curves as f64,
                unit: "",
                limit: Some(1.0),
            });
        }
    }
    rows
}
