//! Cuts that files bring: `cut.json`, and the seams of a texture map.

use serde::Deserialize;

use super::charting::{ChartError, Charting, measure_opened};
use super::layout::Layout;
use super::refining::Refinement;
use super::surface::Surface;
use super::text::Problem;
use crate::flatten::comparison::Specimen;
use crate::flatten::flatten_sphere;
use crate::mesh::{CutMesh, MeshError, SurfacePoint, VertexId, uv_seams};
use crate::methods::cutflow::labelled_cut;
use crate::pattern;

#[derive(Deserialize)]
struct CutFile {
    cutflow_cut: u32,
    vertices: usize,
    points: Vec<Point>,
    vertex_labels: Vec<Option<u32>>,
}

#[derive(Deserialize)]
struct Point {
    edge: Option<[usize; 2]>,
    t: Option<f64>,
}

/// Whether a file is one of ours that describes a cut.
pub fn is_cut_file(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(200)];
    String::from_utf8_lossy(head).contains("\"cutflow_cut\"")
}

/// The labels of the vertices in a `cut.json`.
pub fn labels_from_json(surface: &Surface, name: &str, bytes: &[u8]) -> Result<Vec<u32>, Problem> {
    Ok(parse(surface, name, bytes)?.1)
}

fn refused(name: &str, what: String) -> Problem {
    Problem::new(what, format!("{name}."), "Use a cut.json that was written for this very mesh.")
}

/// The file and the labels of the surface's vertices.
fn parse(surface: &Surface, name: &str, bytes: &[u8]) -> Result<(CutFile, Vec<u32>), Problem> {
    let wrong = |what: String| refused(name, what);
    let file: CutFile = serde_json::from_slice(bytes)
        .map_err(|error| wrong(format!("This is not a cut file: {error}.")))?;
    if file.cutflow_cut != 1 {
        return Err(Problem::new(
            format!("The cut file has version {}; version 1 is understood.", file.cutflow_cut),
            format!("{name}."),
            "Update Cutflow, or write the cut again with this version.",
        ));
    }
    let vertices = surface.soup.positions.len();
    if file.vertices != vertices || file.vertex_labels.len() != vertices {
        let count = file.vertices;
        return Err(wrong(format!(
            "The cut is of a mesh of {count} vertices, this one has {vertices}."
        )));
    }
    let labels: Vec<u32> = surface
        .soup_vertices
        .iter()
        .map(|&v| {
            file.vertex_labels[v as usize].ok_or_else(|| wrong(format!("Vertex {v} has no label.")))
        })
        .collect::<Result<_, _>>()?;
    Ok((file, labels))
}

/// The cut that a `cut.json` describes, on the mesh that it was made for. Cuts that only turned patches into disks are
/// not part of it: they are made again.
pub fn cut_from_json(surface: &Surface, name: &str, bytes: &[u8]) -> Result<CutMesh, Problem> {
    let wrong = |what: String| refused(name, what);
    let (file, labels) = parse(surface, name, bytes)?;
    let mut crossings: Vec<([VertexId; 2], f64)> = Vec::new();
    for point in &file.points {
        let (Some([a, b]), Some(t)) = (point.edge, point.t) else { continue };
        let (Some(a), Some(b)) = (surface.mesh_vertex(a), surface.mesh_vertex(b)) else {
            return Err(wrong(format!("There is no edge from vertex {a} to vertex {b}.")));
        };
        if !(t > 0.0 && t < 1.0) {
            return Err(wrong(format!(
                "The place {t} on the edge from {} to {} is out of range.",
                a.0, b.0
            )));
        }
        crossings.push(if a < b { ([a, b], t) } else { ([b, a], 1.0 - t) });
    }
    crossings.sort_by_key(|(ends, _)| *ends);
    let place = |ends: [VertexId; 2]| {
        let sorted = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let found = crossings.binary_search_by_key(&sorted, |(ends, _)| *ends).ok()?;
        let t = crossings[found].1;
        Some(if sorted == ends { t } else { 1.0 - t })
    };
    Ok(labelled_cut(&surface.mesh, &surface.geometry, &labels, place))
}

/// The cut along the seams of the mesh's own texture map, exactly: along its edges, slits inside an island included. What
/// `UV mesh (OBJ)` writes comes back as the very cut that it was written with.
pub fn cut_from_uv(surface: &Surface) -> Result<CutMesh, Problem> {
    let seams = uv_seams(&surface.soup).ok_or_else(|| {
        Problem::new(
            "The mesh has no texture coordinates to cut along.",
            format!("{}.", surface.name),
            "Choose another cut, or export the mesh with texture coordinates.",
        )
    })?;
    let mesh = &surface.mesh;
    let mut cut = CutMesh::uncut(mesh);
    for [a, b] in seams {
        let ends = [a, b].map(|v| surface.mesh_vertex(v as usize));
        let [Some(a), Some(b)] = ends else { continue };
        // A side of polygons that were left out, or of three that a repair parted, is no edge any more.
        if let Some(h) = mesh.outgoing(a).find(|&h| mesh.tip(h) == b)
            && !mesh.is_boundary_edge(h.edge())
        {
            cut.cut_edges.push([a.0, b.0]);
        }
    }
    Ok(cut)
}

/// A closed surface without handles on the unit sphere: an OBJ with the file's vertices, in their order, and its triangles.
pub fn sphere_obj(surface: &Surface) -> Result<Vec<u8>, Problem> {
    let map = flatten_sphere(&surface.mesh, &surface.geometry)
        .map_err(|error| ChartError::from(error).problem(&surface.name))?;
    let mut places = vec![[0.0; 3]; surface.soup.positions.len()];
    for (v, place) in map.positions.iter().enumerate() {
        places[surface.soup_vertices[v] as usize] = (*place).into();
    }
    let mut text = String::from("# Cutflow: the surface on the unit sphere, conformally\n");
    for [x, y, z] in places {
        text += &format!("v {x} {y} {z}\n");
    }
    for corners in surface.mesh.triangles() {
        let [a, b, c] = corners.map(|v| surface.soup_vertices[v.index()] + 1);
        text += &format!("f {a} {b} {c}\n");
    }
    Ok(text.into_bytes())
}

/// A surface opened along a cut, to be flattened by several methods side by side.
pub fn specimen(surface: &Surface, cut: Option<CutMesh>) -> Result<Specimen, Problem> {
    let wrong = |error: MeshError| Problem::solve(&surface.name, &error.into());
    let cut = cut.unwrap_or_else(|| CutMesh::uncut(&surface.mesh));
    let opened = cut.open().map_err(wrong)?;
    let place = |&p: &SurfacePoint| surface.geometry.locate(&surface.mesh, p);
    let points: Vec<_> = cut.points.iter().map(place).collect();
    let geometry = measure_opened(&opened, &points);
    Specimen::new(opened, geometry).map_err(wrong)
}

/// Flattens a surface along a cut, or along cuts to disks only. **Takes** what to even out: `none` or `dirichlet`.
/// **Gives** the layout and the bytes of `uv.obj`.
pub fn surface_layout(
    surface: &Surface,
    cut: Option<CutMesh>,
    charting: &Charting,
    refine: &str,
) -> Result<(Layout, Vec<u8>), Problem> {
    let cut = cut.unwrap_or_else(|| CutMesh::uncut(&surface.mesh));
    let mut layout =
        Layout::full(surface, cut, charting, None).map_err(|error| error.problem(&surface.name))?;
    let wrong = |error| Problem::solve(&surface.name, &error);
    if let Some(mut refinement) = Refinement::begin(&layout, refine, &[]).map_err(wrong)? {
        refinement.finish(surface, &mut layout);
    }
    let bytes =
        pattern::uv_obj(&layout.surface(surface, None), &layout.charts, 1.0 / surface.frame.scale);
    Ok((layout, bytes))
}
