//! Charts, and the curves between them, as merging wants them.

use crate::geometry::Geometry;
use crate::mesh::{EdgeId, Mesh};
use crate::methods::developable::{self, seam_curves};

/// A maximal chain of edges between one pair of charts, from junction to junction.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The charts, in increasing order.
    pub charts: [u32; 2],
    /// Its edges, in increasing order.
    pub edges: Vec<EdgeId>,
    /// Their length.
    pub length: f64,
}

/// Numbers the parts of equal label that hang together otherwise than across edges that `parts` accepts, by first face. **Gives** a chart for each
/// face, and the label of each chart.
pub fn connected_charts(
    mesh: &Mesh,
    labels: &[u32],
    parts: impl Fn(EdgeId) -> bool,
) -> (Vec<u32>, Vec<u32>) {
    let (charts, count) = developable::parted_charts(mesh, labels, parts);
    let mut chart_labels = vec![0; count];
    for (&chart, &label) in charts.iter().zip(labels) {
        chart_labels[chart as usize] = label;
    }
    (charts, chart_labels)
}

/// All curves between charts, by first edge.
pub fn curves(mesh: &Mesh, geometry: &Geometry, charts: &[u32]) -> Vec<Curve> {
    let curve = |seam: developable::SeamCurve| {
        let mut edges: Vec<EdgeId> = seam.halfedges.iter().map(|h| h.edge()).collect();
        edges.sort_unstable();
        Curve { charts: seam.pair, edges, length: seam.length }
    };
    seam_curves(mesh, geometry, charts).into_iter().map(curve).collect()
}
