//! `cut.json`: the cut as points on the edges of the input, with labels.
//!
//! ```json
//! {
//!   "cutflow_cut": 1,
//!   "vertices": 2930,
//!   "patches": 7,
//!   "mm_per_unit": 3.5,
//!   "points": [
//!     {"vertex": 17},
//!     {"edge": [17, 42], "t": 0.25},
//!     {"face": [17, 42, 3], "weights": [0.2, 0.3, 0.5]}
//!   ],
//!   "segments": [[0, 1, 4, 5]],
//!   "vertex_labels": [0, 2, null]
//! }
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `cutflow_cut` | version of this format: 1 |
//! | `vertices` | number of vertices of the input file; all vertex indices count from 0 in its order |
//! | `patches` | number of pieces, counted from 0 |
//! | `mm_per_unit` | real size: millimetres of one unit of the input; left out where it is not known |
//! | `points` | places on the input: a vertex; (1 − t) a + t b on the edge `[a, b]` with 0 < t < 1; Σ weights · corners in a face |
//! | `segments` | `[i, j, left, right]`: the cut runs from point i to point j within one face or along one edge, with patch `left` on its left seen from outside. Both are the same where a cut only opens a patch |
//! | `vertex_labels` | for each vertex of the input the label of its region, `null` where no face uses it |
//!
//! Numbers read back bit for bit. Points not on the cut are not listed.

use super::number::exact;
use super::obj::CutSurface;
use crate::mesh::{SurfacePoint, VertexId};

/// The bytes of `cut.json`.
///
/// **Takes** the label of the region of each vertex of the mesh.
pub fn cut_json(surface: &CutSurface, vertex_labels: &[u32]) -> Vec<u8> {
    let CutSurface { soup, mesh, cut, opened, .. } = *surface;
    assert_eq!(vertex_labels.len(), mesh.vertex_count());
    let mut points: Vec<u32> = cut.cut_edges.concat();
    points.sort_unstable();
    points.dedup();
    let number = |point: u32| points.partition_point(|&p| p < point);

    let mut out = String::from("{\n\"cutflow_cut\": 1,\n");
    out += &format!("\"vertices\": {},\n", soup.positions.len());
    out += &format!("\"patches\": {},\n", opened.patch_count);
    if let Some(mm) = surface.mm_per_unit {
        out += "\"mm_per_unit\": ";
        exact(&mut out, mm);
        out += ",\n";
    }
    let texts = points.iter().map(|&p| point_text(surface, cut.points[p as usize]));
    write_array(&mut out, "points", ",\n", texts);
    out += ",\n";

    // The patch on the left of each directed edge of the cut.
    let mut left_patches: Vec<([u32; 2], u32)> = Vec::with_capacity(2 * cut.cut_edges.len());
    for f in opened.mesh.faces() {
        for h in opened.mesh.face_halfedges(f).into_iter().filter(|&h| opened.partner(h).is_some())
        {
            let ends = [opened.mesh.tail(h), opened.mesh.tip(h)];
            let ends = ends.map(|v| opened.vertex_points[v.index()]);
            left_patches.push((ends, opened.face_patches[f.index()]));
        }
    }
    left_patches.sort_unstable();
    let left = |ends: [u32; 2]| {
        let at = left_patches.binary_search_by_key(&ends, |&(e, _)| e).ok()?;
        Some(left_patches[at].1)
    };
    // An edge of the surface's own rim has one side only and opens nothing.
    let segments = cut.cut_edges.iter().filter_map(|&[a, b]| {
        let (left, right) = (left([a, b])?, left([b, a])?);
        Some(format!("[{}, {}, {left}, {right}]", number(a), number(b)))
    });
    write_array(&mut out, "segments", ",\n", segments);
    out += ",\n";

    let mut labels = vec![None; soup.positions.len()];
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        labels[surface.soup_vertex(v.index())] = Some(vertex_labels[v.index()]);
    }
    let labels = labels.iter().map(|label| label.map_or("null".into(), |label| label.to_string()));
    write_array(&mut out, "vertex_labels", ", ", labels);
    out += "\n}\n";
    out.into_bytes()
}

fn point_text(surface: &CutSurface, point: SurfacePoint) -> String {
    let vertex = |v: VertexId| surface.soup_vertex(v.index());
    let mut text = String::new();
    match point {
        SurfacePoint::Vertex(v) => text += &format!("{{\"vertex\": {}}}", vertex(v)),
        SurfacePoint::Edge(e, t) => {
            let [a, b] = surface.mesh.edge_vertices(e).map(vertex);
            text += &format!("{{\"edge\": [{a}, {b}], \"t\": ");
            exact(&mut text, t);
            text.push('}');
        }
        SurfacePoint::Face(f, weights) => {
            let [a, b, c] = surface.mesh.face_vertices(f).map(vertex);
            text += &format!("{{\"face\": [{a}, {b}, {c}], \"weights\": [");
            for (i, w) in weights.into_iter().enumerate() {
                text += if i > 0 { ", " } else { "" };
                exact(&mut text, w);
            }
            text += "]}";
        }
    }
    text
}

fn write_array(out: &mut String, key: &str, separator: &str, items: impl Iterator<Item = String>) {
    *out += &format!("\"{key}\": [");
    let is_long = separator.ends_with('\n');
    *out += if is_long { "\n" } else { "" };
    for (i, item) in items.enumerate() {
        *out += if i > 0 { separator } else { "" };
        *out += &item;
    }
    *out += if is_long { "\n]" } else { "]" };
}
