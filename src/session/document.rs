//! An opened mesh, checked and measured.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::message::{MeshSummary, NoticeText};
use super::samples;
use super::scene::{PatchScene, Scene};
use super::text::{Problem, plural};
use crate::geometry::{Geometry, GeometryError, UnitFrame, face_curvatures, polygon};
use crate::mesh::{Mesh, MeshError, Soup, VertexId, read};

/// A surface that methods can work on, and the file that it came from.
#[derive(Clone, Debug)]
pub struct Document {
    /// File or sample.
    pub name: String,
    /// The sample, if it is one.
    pub sample: Option<String>,
    /// The file as it was read.
    pub soup: Soup,
    /// For each vertex of the mesh its vertex of the file.
    pub soup_vertices: Vec<u32>,
    /// Connectivity of the used vertices.
    pub mesh: Mesh,
    /// Measured at unit area.
    pub geometry: Geometry,
    /// From unit area back to the file.
    pub frame: UnitFrame,
    /// Unit normals of the vertices.
    pub vertex_normals: Vec<Vector3<f64>>,
    /// Gaussian curvature at the vertices: mean over the faces.
    pub vertex_curvatures: Vec<f64>,
    /// What was found.
    pub summary: MeshSummary,
}

/// A mesh that was refused, and what of it can be shown.
#[derive(Clone, Debug)]
pub struct Refusal {
    /// Why.
    pub problem: Problem,
    /// The mesh with the bad places marked, where it could be read.
    pub scene: Option<Box<Scene>>,
}

impl From<Problem> for Refusal {
    fn from(problem: Problem) -> Self {
        Self { problem, scene: None }
    }
}

impl Document {
    /// Opens a generated surface.
    pub fn from_sample(name: &str) -> Result<Self, Refusal> {
        let Some(soup) = samples::generate(name) else {
            let known = samples::SAMPLES.iter().map(|s| s.name).collect::<Vec<_>>().join(", ");
            return Err(Problem::new(
                format!("There is no sample called “{name}”."),
                "In the choice of a sample.",
                format!("Choose one of {known}."),
            )
            .into());
        };
        let label = samples::SAMPLES.iter().find(|s| s.name == name).map_or(name, |s| s.label);
        let mut document = Self::from_soup(label, soup, Vec::new())?;
        document.sample = Some(name.to_owned());
        Ok(document)
    }

    /// Reads a file.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, Refusal> {
        let content = read::read(name, bytes).map_err(|error| Problem::read(name, &error))?;
        let notices = content
            .notices
            .iter()
            .map(|notice| NoticeText {
                kind: notice.kind.to_owned(),
                count: notice.count,
                text: notice.to_string(),
            })
            .collect();
        Self::from_soup(name, content.soup, notices)
    }

    fn from_soup(name: &str, soup: Soup, mut notices: Vec<NoticeText>) -> Result<Self, Refusal> {
        let mut triangles = Vec::with_capacity(soup.corners.len());
        let mut polygons = 0;
        for i in 0..soup.polygon_count() {
            polygons += usize::from(soup.polygon(i).len() > 3);
            polygon::triangulate(&soup.positions, soup.polygon(i), &mut triangles);
        }
        if polygons > 0 {
            notices.push(NoticeText {
                kind: "polygons".into(),
                count: polygons,
                text: format!("{} were divided into triangles.", plural(polygons, "polygon")),
            });
        }
        let all = triangles.len();
        triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        if triangles.len() < all {
            let count = all - triangles.len();
            notices.push(NoticeText {
                kind: "repeated_vertices".into(),
                count,
                text: format!("{} that use a vertex twice were left out.", plural(count, "face")),
            });
        }

        // Number the used vertices in the order of the file.
        let mut numbers = vec![u32::MAX; soup.positions.len()];
        for v in triangles.iter().flatten() {
            numbers[*v as usize] = 0;
        }
        let mut soup_vertices = Vec::new();
        for (v, number) in numbers.iter_mut().enumerate().filter(|(_, n)| **n == 0) {
            *number = soup_vertices.len() as u32;
            soup_vertices.push(v as u32);
        }
        for v in triangles.iter_mut().flatten() {
            *v = numbers[*v as usize];
        }
        let isolated_vertices = soup.positions.len() - soup_vertices.len();
        if isolated_vertices > 0 {
            let verb = if isolated_vertices == 1 { "is" } else { "are" };
            notices.push(NoticeText {
                kind: "isolated_vertices".into(),
                count: isolated_vertices,
                text: format!(
                    "{} {verb} used by no face: ignored here, kept in exports.",
                    plural(isolated_vertices, "vertex")
                ),
            });
        }
        let positions: Vec<[f64; 3]> =
            soup_vertices.iter().map(|&v| soup.positions[v as usize]).collect();
        let in_file = |v: usize| soup_vertices.get(v).map_or(v, |&s| s as usize);

        if looks_inwards(&positions, &triangles) {
            for triangle in &mut triangles {
                triangle.swap(1, 2);
            }
            notices.push(NoticeText {
                kind: "inside_out".into(),
                count: triangles.len(),
                text: "All faces looked inwards and were turned around.".into(),
            });
        }
        let mesh = Mesh::new(positions.len(), &triangles).map_err(|error| Refusal {
            // What was passed over in reading may be the reason.
            problem: Problem::mesh(name, &error, in_file).after(&notices),
            scene: rejected_scene(&positions, &triangles, &Marks::of_mesh(&error)),
        })?;
        let (geometry, frame) =
            Geometry::unit_area(&mesh, &positions).map_err(|error| Refusal {
                problem: Problem::geometry(name, &error, in_file),
                scene: rejected_scene(
                    &positions,
                    &triangles,
                    &Marks::of_geometry(&error, &triangles),
                ),
            })?;
        let topology = mesh.topology();
        let summary = MeshSummary {
            name: name.to_owned(),
            vertices: soup.positions.len(),
            faces: mesh.face_count(),
            components: topology.components,
            boundary_loops: topology.boundary_loops,
            genus: topology.genus,
            euler: topology.euler,
            area: 1.0 / (frame.scale * frame.scale),
            isolated_vertices,
            notices,
        };
        let vertex_normals = geometry.vertex_normals(&mesh);
        let vertex_curvatures =
            face_to_vertex(&mesh, &geometry, &face_curvatures(&mesh, &geometry));
        Ok(Self {
            name: name.to_owned(),
            sample: None,
            soup,
            soup_vertices,
            mesh,
            geometry,
            frame,
            vertex_normals,
            vertex_curvatures,
            summary,
        })
    }

    /// The mesh's vertex of a vertex of the file.
    pub fn mesh_vertex(&self, soup_vertex: usize) -> Option<VertexId> {
        let wanted = u32::try_from(soup_vertex).ok()?;
        self.soup_vertices.binary_search(&wanted).ok().map(VertexId::from)
    }

    /// The mesh's vertex of a vertex of the file, or of the next one that a face uses.
    pub fn mesh_vertex_from(&self, soup_vertex: usize) -> Option<VertexId> {
        if soup_vertex >= self.soup.positions.len() {
            return None;
        }
        let next = self.soup_vertices.partition_point(|&v| (v as usize) < soup_vertex);
        Some(VertexId::from(next.min(self.soup_vertices.len() - 1)))
    }

    /// Longest side of the bounding box, unit area.
    pub fn largest_side(&self) -> f64 {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        for p in &self.geometry.positions {
            low = low.inf(&p.coords);
            high = high.sup(&p.coords);
        }
        (high - low).max()
    }

    /// Radius of the smallest ball about the origin that holds the surface, unit area.
    pub fn radius(&self) -> f64 {
        self.geometry.positions.iter().fold(0.0, |r: f64, p| r.max(p.coords.norm()))
    }
}

/// Whether triangles enclose a negative volume without a rim: a closed surface that is inside out.
fn looks_inwards(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> bool {
    let Ok(mesh) = Mesh::new(positions.len(), triangles) else { return false };
    if !mesh.boundary_loops().is_empty() || triangles.is_empty() {
        return false;
    }
    // About a point of the surface: the volume of a closed surface does not depend on it, the digits do.
    let origin = Vector3::from(positions[triangles[0][0] as usize]);
    let volume: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| Vector3::from(positions[v as usize]) - origin);
            a.dot(&b.cross(&c))
        })
        .sum();
    volume < 0.0
}

/// Area-weighted mean of a face quantity at the vertices.
pub(super) fn face_to_vertex(mesh: &Mesh, geometry: &Geometry, values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; mesh.vertex_count()];
    let mut areas = vec![0.0; mesh.vertex_count()];
    for f in mesh.faces() {
        let (value, area) = (values[f.index()], geometry.face_areas[f.index()]);
        if value.is_finite() {
            for v in mesh.face_vertices(f) {
                sums[v.index()] += value * area;
                areas[v.index()] += area;
            }
        }
    }
    sums.iter().zip(&areas).map(|(s, a)| if *a > 0.0 { s / a } else { f64::NAN }).collect()
}

/// Vertices of the mesh to point at.
#[derive(Default)]
struct Marks {
    points: Vec<u32>,
    segments: Vec<[u32; 2]>,
}

impl Marks {
    fn of_mesh(error: &MeshError) -> Self {
        let pairs = |edges: &[[VertexId; 2]]| edges.iter().map(|e| e.map(|v| v.0)).collect();
        match error {
            MeshError::NonManifoldEdges { edges, .. }
            | MeshError::InconsistentOrientation { edges } => {
                Self { segments: pairs(edges), ..Self::default() }
            }
            MeshError::NonManifoldVertices { vertices } => {
                Self { points: vertices.iter().map(|v| v.0).collect(), ..Self::default() }
            }
            MeshError::NoFaces
            | MeshError::TooLarge { .. }
            | MeshError::RepeatedVertices { .. } => Self::default(),
        }
    }

    fn of_geometry(error: &GeometryError, triangles: &[[u32; 3]]) -> Self {
        match error {
            GeometryError::DegenerateFaces { faces } => Self {
                segments: faces
                    .iter()
                    .flat_map(|f| {
                        let [a, b, c] = triangles[f.index()];
                        [[a, b], [b, c], [c, a]]
                    })
                    .collect(),
                ..Self::default()
            },
            GeometryError::NotFinite { .. } | GeometryError::NoExtent => Self::default(),
        }
    }
}

/// A picture of triangles that are no surface, without charts and colours; none if there is nothing to see.
fn rejected_scene(
    positions: &[[f64; 3]],
    triangles: &[[u32; 3]],
    marks: &Marks,
) -> Option<Box<Scene>> {
    if triangles.is_empty() || !positions.iter().flatten().all(|x| x.is_finite()) {
        return None;
    }
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    for &p in positions {
        low = low.inf(&p.into());
        high = high.sup(&p.into());
    }
    let centre = (low + high) / 2.0;
    let radius = (high - low).norm() / 2.0;
    if !(radius > 1e-100 && radius < 1e100) {
        return None;
    }
    let places: Vec<Point3<f64>> =
        positions.iter().map(|&p| Point3::from((Vector3::from(p) - centre) / radius)).collect();
    let mut normals = vec![Vector3::zeros(); places.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| places[v as usize]);
        for v in t {
            normals[*v as usize] += (b - a).cross(&(c - a));
        }
    }
    let flat = |p: Vector3<f64>| [p.x as f32, p.y as f32, p.z as f32];
    let at = |v: u32| flat(places[v as usize].coords);
    Some(Box::new(Scene {
        positions: places.iter().flat_map(|p| flat(p.coords)).collect(),
        normals: normals
            .iter()
            .flat_map(|n| flat(n.try_normalize(1e-300).unwrap_or_else(Vector3::z)))
            .collect(),
        charts: vec![f32::NAN; 2 * places.len()],
        vertex_patches: vec![0; places.len()],
        triangles: triangles.concat(),
        triangle_faces: (0..triangles.len() as u32).collect(),
        patches: vec![PatchScene {
            color: PatchScene::NEUTRAL,
            area_fraction: 1.0,
            anchor: [f32::NAN; 2],
            ..PatchScene::default()
        }],
        mark_points: marks.points.iter().flat_map(|&v| at(v)).collect(),
        mark_segments: marks.segments.iter().flatten().flat_map(|&v| at(v)).collect(),
        ..Scene::default()
    }))
}
