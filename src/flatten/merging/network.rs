//! Charts, and the curves between them.

use std::collections::BTreeMap;

use crate::flatten::small;
use crate::geometry::Geometry;
use crate::mesh::{EdgeId, Mesh, VertexId};

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

/// Numbers the connected parts of equal label, by first face. **Gives** a chart for each face, and the label of each chart.
pub fn connected_charts(mesh: &Mesh, labels: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut charts = vec![u32::MAX; labels.len()];
    let mut chart_labels = Vec::new();
    let mut stack = Vec::new();
    for start in mesh.faces() {
        if charts[start.index()] != u32::MAX {
            continue;
        }
        let chart = small(chart_labels.len());
        chart_labels.push(labels[start.index()]);
        charts[start.index()] = chart;
        stack.push(start);
        while let Some(f) = stack.pop() {
            for g in mesh.face_halfedges(f).into_iter().filter_map(|h| mesh.face(h.twin())) {
                if charts[g.index()] == u32::MAX && labels[g.index()] == labels[f.index()] {
                    charts[g.index()] = chart;
                    stack.push(g);
                }
            }
        }
    }
    (charts, chart_labels)
}

/// The charts on both sides of an edge, if there are two.
fn sides(mesh: &Mesh, charts: &[u32], e: EdgeId) -> Option<[u32; 2]> {
    let h = e.halfedge();
    let (f, g) = (mesh.face(h)?, mesh.face(h.twin())?);
    let (a, b) = (charts[f.index()], charts[g.index()]);
    (a != b).then_some([a.min(b), a.max(b)])
}

/// All curves between charts, by first edge. **Costs** O(E log E).
pub fn curves(mesh: &Mesh, geometry: &Geometry, charts: &[u32]) -> Vec<Curve> {
    let pairs: Vec<Option<[u32; 2]>> = mesh.edges().map(|e| sides(mesh, charts, e)).collect();
    let mut roots: Vec<u32> = (0..small(pairs.len())).collect();
    let mut at: Vec<[u32; 3]> = vec![[0, 0, 0]; mesh.vertex_count()];
    for e in mesh.edges().filter(|e| pairs[e.index()].is_some()) {
        for v in mesh.edge_vertices(e) {
            let [count, first, second] = &mut at[v.index()];
            match *count {
                0 => *first = e.0,
                1 => *second = e.0,
                _ => {}
            }
            *count += 1;
        }
    }
    for (v, &[count, first, second]) in at.iter().enumerate() {
        let goes_on = count == 2
            && pairs[first as usize] == pairs[second as usize]
            && !mesh.is_boundary_vertex(VertexId::from(v));
        if goes_on {
            let (a, b) = (root(&mut roots, first), root(&mut roots, second));
            roots[a.max(b) as usize] = a.min(b);
        }
    }
    let mut found: BTreeMap<u32, Curve> = BTreeMap::new();
    for e in mesh.edges() {
        let Some(charts) = pairs[e.index()] else { continue };
        let curve = found.entry(root(&mut roots, e.0)).or_insert_with(|| Curve {
            charts,
            edges: Vec::new(),
            length: 0.0,
        });
        curve.edges.push(e);
        curve.length += geometry.edge_length(e);
    }
    found.into_values().collect()
}

fn root(roots: &mut [u32], mut i: u32) -> u32 {
    while roots[i as usize] != i {
        roots[i as usize] = roots[roots[i as usize] as usize];
        i = roots[i as usize];
    }
    i
}
