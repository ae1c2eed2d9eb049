//! `cones.json`: cones as they are used, to be taken up again.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::super::brought::vertex_of;
use super::super::message::{Command, Event, Value};
use super::super::surface::Surface;
use super::super::text::Problem;
use super::super::work::Work;
use super::super::{Session, nothing_open};
use super::edits::{Edits, too_large};
use super::report::ConeReport;
use super::{ConeKind, UsedCone};
use crate::mesh::VertexId;
use crate::methods::cones::Cone;

/// The kind of file.
const FORMAT: &str = "cutflow cones 1";

/// Content of the file.
#[derive(Debug, Serialize, Deserialize)]
struct ConesFile {
    format: String,
    /// Vertices of the mesh's file.
    vertices: usize,
    /// What the boundary was asked to be.
    boundary: String,
    /// Corners of the boundary included.
    cones: Vec<ConeReport>,
}

/// A vertex that faces use. **Fails** on others.
fn used_vertex(surface: &Surface, x: f64, place: &str) -> Result<VertexId, Problem> {
    let vertex = vertex_of(surface, x, place)?;
    let is_itself = f64::from(surface.soup_vertices[vertex.index()]).to_bits() == x.to_bits();
    is_itself.then_some(vertex).ok_or_else(|| {
        Problem::new(format!("No face uses vertex {x}."), place, "Choose a vertex of the surface.")
    })
}

/// Whether a file says that it holds cones.
pub fn is_cones_file(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]);
    head.contains("\"format\"") && head.contains("cutflow cones")
}

/// Cones from the bytes of a file.
fn cones_from_json(
    surface: &Surface,
    name: &str,
    bytes: &[u8],
) -> Result<(Vec<Cone>, String), Problem> {
    let wrong = |what: String, advice: &str| Problem::new(what, format!("{name}."), advice);
    let file: ConesFile = serde_json::from_slice(bytes).map_err(|error| {
        wrong(
            format!("The cones cannot be read: {error}."),
            "Choose a cones.json that Cutflow wrote.",
        )
    })?;
    if !file.format.starts_with(FORMAT) {
        return Err(wrong(
            format!("The file says that it is “{}”.", file.format),
            "Choose a cones.json that Cutflow wrote.",
        ));
    }
    let count = surface.soup.positions.len();
    if file.vertices != count {
        return Err(wrong(
            format!(
                "The cones are of a mesh of {} vertices, and this one has {count}.",
                file.vertices
            ),
            "Open the mesh that they were made for first.",
        ));
    }
    let cone = |cone: &ConeReport| {
        if !(cone.angle.abs() < TAU) {
            return Err(too_large(format!("{name}, vertex {}.", cone.vertex), cone.angle));
        }
        let vertex = used_vertex(surface, f64::from(cone.vertex), &format!("{name}."))?;
        Ok(Cone { vertex, angle: cone.angle })
    };
    let mut cones = file.cones.iter().map(cone).collect::<Result<Vec<_>, _>>()?;
    cones.sort_by_key(|cone| cone.vertex);
    if let Some(pair) = cones.windows(2).find(|pair| pair[0].vertex == pair[1].vertex) {
        let vertex = surface.soup_vertices[pair[0].vertex.index()];
        return Err(wrong(
            format!("Vertex {vertex} is a cone twice."),
            "Leave one of the two out.",
        ));
    }
    Ok((cones, file.boundary))
}

impl Session {
    /// Uses the cones of a file as they are.
    pub(in super::super) fn bring_cones(
        &mut self,
        name: &str,
        bytes: &[u8],
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let work = self.cones_at_work()?;
        let (cones, boundary) = cones_from_json(work.document.surface()?, name, bytes)?;
        if work.settings.text("boundary") != boundary {
            let value = Value::Text(boundary);
            events.extend(self.handle(Command::SetParameter { id: "boundary".into(), value }));
        }
        let bring = |_: &mut Work| {
            let used = |cone| UsedCone { cone, kind: ConeKind::Fixed, members: 1 };
            let changed: Vec<UsedCone> = cones.into_iter().map(used).collect();
            Ok(Edits { changed: Some(changed), ..Edits::default() })
        };
        self.change_cones("bring cones", bring, events)
    }

    /// Puts a cone at a vertex of the file.
    pub(in super::super) fn bring_cone(
        &mut self,
        vertex: f64,
        angle: Option<f64>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let bring = |work: &mut Work| {
            let surface = work.document.surface()?;
            let place = format!("Vertex {vertex}, cones by hand.");
            let vertex = used_vertex(surface, vertex, &place)?;
            if work.cones.edits.placed_at(vertex).is_some() {
                return Err(Problem::new(
                    "There is a cone by hand there already.",
                    place,
                    "Name every vertex once.",
                ));
            }
            work.with_cone(vertex, angle)
        };
        self.change_cones("add a cone", bring, events)
    }
}

impl Work {
    /// The bytes of `cones.json`.
    pub(in super::super) fn cones_file(&self) -> Result<Vec<u8>, Problem> {
        let (Some(set), Some(surface)) = (&self.cones.set, &self.document.surface) else {
            return Err(nothing_open());
        };
        let report = |used: &UsedCone| ConeReport {
            vertex: surface.soup_vertices[used.cone.vertex.index()],
            angle: used.cone.angle,
        };
        self.json(&ConesFile {
            format: FORMAT.into(),
            vertices: surface.soup.positions.len(),
            boundary: self.settings.text("boundary").into(),
            cones: set.cones.iter().map(report).collect(),
        })
    }
}
