//! Charts of quasi-developable segmentation: about planes, along minimum cuts, without noise.

mod approximating;
mod denoising;
mod refining;

use std::sync::Arc;

use cutflow::geometry::Geometry;
use cutflow::mesh::{EdgeId, Mesh};
use cutflow::methods::developable::{VsaFlow, VsaParams, connected_charts};
use cutflow::methods::flow::{Flow, Status};

use crate::surfaces::Surface;

type Shape = (Arc<Mesh>, Arc<Geometry>);

fn shape(surface: Surface) -> Shape {
    (Arc::new(surface.mesh), Arc::new(surface.geometry))
}

fn approximate((mesh, geometry): &Shape, params: VsaParams) -> VsaFlow {
    let mut flow = VsaFlow::new(mesh.clone(), geometry.clone(), params).unwrap();
    finish(&mut flow);
    flow
}

/// Steps until the end, which must come.
fn finish(flow: &mut VsaFlow) {
    for _ in 0..20_000 {
        if flow.step().unwrap().status != Status::Running {
            return;
        }
    }
    panic!("no end after 20 000 steps");
}

/// Every face has a chart, charts are connected and numbered without gaps. Gives their number.
fn assert_complete(mesh: &Mesh, charts: &[u32]) -> usize {
    let count = charts.iter().max().unwrap() + 1;
    let (_, parts) = connected_charts(mesh, charts);
    let mut occurs = vec![false; count as usize];
    charts.iter().for_each(|&c| occurs[c as usize] = true);
    assert!(occurs.iter().all(|&o| o), "a chart without faces");
    assert_eq!(parts, count as usize, "a chart in several parts");
    parts
}

/// Edges between charts.
fn seams<'a>(mesh: &'a Mesh, charts: &'a [u32]) -> impl Iterator<Item = EdgeId> + 'a {
    mesh.edges().filter(|e| {
        let [a, b] = [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h));
        matches!((a, b), (Some(a), Some(b)) if charts[a.index()] != charts[b.index()])
    })
}
