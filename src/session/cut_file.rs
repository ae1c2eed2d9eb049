//! Cuts that files bring: `cut.json`, and the seams of a texture map.

use serde::Deserialize;

use super::charting::{ChartError, Charting, measure_opened};
use super::layout::Layout;
use super::refining::Refinement;
use super::surface::Surface;
use super::text::Problem;
use crate::flatten::comparison::Specimen;
use crate::flatten::flatten_sphere;
use crate::mesh::{CutMesh, HalfedgeId, MeshError, SurfacePoint, VertexId, uv_seams};
use crate::methods::straighten::cut_along;
use crate::pattern;

#[derive(Deserialize)]
struct CutFile {
    cutflow_cut: u32,
    vertices: usize,
    points: Vec<Point>,
    /// Two points, and the pieces on their left and right.
    segments: Option<Vec<[u32; 4]>>,
    vertex_labels: Vec<Option<u32>>,
}

#[derive(Deserialize)]
struct Point {
    vertex: Option<usize>,
    edge: Option<[usize; 2]>,
    t: Option<f64>,
    face: Option<[usize; 3]>,
    weights: Option<[f64; 3]>,
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

/// The very cut of a `cut.json`, on the mesh that it was made for: cuts that only opened pieces into disks and seams that end inside a
/// piece are part of it.
pub fn cut_from_json(surface: &Surface, name: &str, bytes: &[u8]) -> Result<CutMesh, Problem> {
    let (file, _) = parse(surface, name, bytes)?;
    let places: Vec<SurfacePoint> = file
        .points
        .iter()
        .map(|p| place(surface, p).map_err(|what| refused(name, what)))
        .collect::<Result<_, _>>()?;
    let segments = file
        .segments
        .as_ref()
        .ok_or_else(|| refused(name, "The file does not say where the cut runs.".to_owned()))?;
    let pieces: Vec<[u32; 2]> = segments.iter().map(|&[a, b, ..]| [a, b]).collect();
    cut_along(&surface.mesh, &surface.geometry, &places, &pieces).ok_or_else(|| {
        refused(name, "The lines of this cut cross, or do not lie on the mesh.".to_owned())
    })
}

/// Where a point of the file lies; else what is wrong with it.
fn place(surface: &Surface, point: &Point) -> Result<SurfacePoint, String> {
    let mesh = &surface.mesh;
    let vertex =
        |v: usize| surface.mesh_vertex(v).ok_or_else(|| format!("There is no vertex {v}."));
    let halfedge = |[a, b]: [usize; 2]| {
        let ends = [vertex(a)?, vertex(b)?];
        let find = |[a, b]: [VertexId; 2]| mesh.outgoing(a).find(|&h| mesh.tip(h) == b);
        find(ends)
            .or_else(|| find([ends[1], ends[0]]).map(HalfedgeId::twin))
            .ok_or_else(|| format!("There is no edge from vertex {a} to vertex {b}."))
    };
    match *point {
        Point { vertex: Some(v), .. } => Ok(SurfacePoint::Vertex(vertex(v)?)),
        Point { edge: Some([a, b]), t: Some(t), .. } => {
            let h = halfedge([a, b])?;
            if !(t > 0.0 && t < 1.0) {
                return Err(format!("The place {t} on the edge from {a} to {b} is out of range."));
            }
            let first = mesh.edge_vertices(h.edge())[0] == vertex(a)?;
            Ok(SurfacePoint::Edge(h.edge(), if first { t } else { 1.0 - t }))
        }
        Point { face: Some(corners), weights: Some(weights), .. } => {
            let [a, b, c] = corners;
            let h = halfedge([a, b])?;
            let third = vertex(c)?;
            let named = [vertex(a)?, vertex(b)?, third];
            let face = [h, h.twin()]
                .into_iter()
                .filter_map(|h| mesh.face(h))
                .find(|&f| mesh.face_vertices(f).contains(&third))
                .ok_or_else(|| format!("There is no face of the vertices {a}, {b} and {c}."))?;
            let sum: f64 = weights.iter().sum();
            if !(weights.iter().all(|w| *w > 0.0) && (sum - 1.0).abs() < 1e-9) {
                return Err(format!("The weights {weights:?} are of no place inside a face."));
            }
            let own = mesh
                .face_vertices(face)
                .map(|v| named.iter().position(|&n| n == v).map_or(0.0, |i| weights[i]));
            Ok(SurfacePoint::Face(face, own))
        }
        _ => Err("A point of the cut has no place.".to_owned()),
    }
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

/// A closed surface without handles on the unit sphere: an OBJ with the file's vertices, in their order, and its triangles. With it the number
/// of triangles that are turned over.
pub fn sphere_obj(surface: &Surface) -> Result<(Vec<u8>, usize), Problem> {
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
    Ok((text.into_bytes(), map.flipped.len()))
}

/// A surface opened along a cut, to be flattened by several methods side by side.
pub fn specimen(surface: &Surface, cut: Option<CutMesh>) -> Result<Specimen, Problem> {
    let wrong = |error: MeshError| Problem::solve(&surface.name, &error.into());
    let cut = cut.unwrap_or_else(|| CutMesh::uncut(&surface.mesh));
    let opened = cut.open().map_err(wrong)?;
    if opened.mesh.boundary_loops().is_empty() {
        return Err(Problem::new(
            "The surface is closed and has no cut: there is nothing to lay flat.",
            format!("{}.", surface.name),
            "Bring a cut.json, or choose a surface with a boundary.",
        ));
    }
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
