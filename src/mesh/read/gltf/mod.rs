//! Reading glTF 2: a scene of meshes in their places, as GLB or as JSON with its buffers inside.
//!
//! Guaranteed, besides what [`super`] promises: nothing outside the file is opened; every accessor is compared with its
//! bytes before it is read; nodes are followed without recursion, each at most once; what a small file draws many times is
//! bounded, 4 million triangles and one more for every two bytes of the file (some hundred bytes of memory each). A mesh
//! is welded exactly by its own coordinates over all its primitives, before it is moved: copies of a mesh stay apart, and
//! a node that flattens joins nothing. A node that mirrors has its triangles turned, so that outside stays outside.
//! Texture coordinates have their origin at the bottom left, as in OBJ (glTF counts v from the top).
//!
//! Not guaranteed: that parts which touch are joined. Skins, morph targets, animations, cameras, lights and textures are
//! passed over; of the sets of texture coordinates the first is read.

mod accessors;
mod container;
mod nodes;
mod primitives;
mod version;

use std::collections::{BTreeMap, HashMap};

use gltf::json::Root;
use thiserror::Error;

use self::container::Buffers;
use self::nodes::{Draw, cross, dot};
use self::primitives::{NONE, Source, Triangles};
use super::number::{LARGEST, name as printable};
use super::{Content, Format, Place, ReadError, ReadFault, ReadNotice, to_u32};
use crate::mesh::Soup;

/// What is wrong with a glTF file that was refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GltfFault {
    /// Neither a GLB nor JSON with an `asset`.
    #[error("not a glTF file")]
    NotGltf,
    /// Another version of glTF.
    #[error("glTF {version} is not supported")]
    Version {
        /// The version as it stands in the file.
        version: String,
    },
    /// A GLB that is shorter than it says.
    #[error("file is {found} bytes, header says {promised}")]
    Length {
        /// Bytes that are there.
        found: u64,
        /// Bytes that were promised.
        promised: u64,
    },
    /// A chunk of a GLB that does not fit in it.
    #[error("chunk of {promised} bytes where {found} are left")]
    Chunk {
        /// Bytes that are there.
        found: u64,
        /// Bytes that were promised.
        promised: u32,
    },
    /// A GLB without JSON.
    #[error("no JSON chunk")]
    NoJson,
    /// JSON that cannot be parsed, or is not as glTF has it.
    #[error("{part}: {text}")]
    Json {
        /// `JSON chunk` or `JSON`.
        part: &'static str,
        /// What is wrong, in the words of the parser.
        text: String,
    },
    /// More JSON than memory should be spent on.
    #[error("{objects} JSON objects, more than {most}")]
    TooManyObjects {
        /// Number of opening braces.
        objects: usize,
        /// Number that is read.
        most: usize,
    },
    /// More triangles than the size of the file allows for.
    #[error("draws {triangles} triangles, more than {most} for a file of this size")]
    TooManyTriangles {
        /// Number of triangles, repeated meshes counted as often as they are drawn.
        triangles: u64,
        /// Number that is read.
        most: u64,
    },
    /// More sparse elements than the size of the file allows for.
    #[error("too many sparse elements for a file of this size")]
    TooManySparse,
    /// A buffer in a file of its own.
    #[error("buffer {buffer} is in another file, {uri}")]
    External {
        /// The buffer.
        buffer: usize,
        /// The name of the file.
        uri: String,
    },
    /// An element of the file that contradicts itself or others.
    #[error("{kind} {index}: {problem}")]
    Element {
        /// `accessor`, `buffer view`, `buffer`, `node`, `scene`, `mesh`.
        kind: &'static str,
        /// Its number, counted from 0.
        index: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// A node that is below itself, or below two others.
    #[error("node {node} is reached twice: a cycle, or two parents")]
    Cycle {
        /// The node.
        node: usize,
    },
    /// A primitive that is drawn in no known way.
    #[error("mesh {mesh}, primitive {primitive}: unknown mode")]
    Mode {
        /// The mesh.
        mesh: usize,
        /// The primitive of the mesh.
        primitive: usize,
    },
    /// A face uses a vertex that does not exist.
    #[error("mesh {mesh}, primitive {primitive}: face {face} uses vertex {vertex} of {vertices}")]
    Index {
        /// The mesh.
        mesh: usize,
        /// The primitive of the mesh.
        primitive: usize,
        /// The face of the primitive.
        face: usize,
        /// The index.
        vertex: usize,
        /// Number of vertices that the index could have named.
        vertices: usize,
    },
    /// A coordinate that is infinite or not a number.
    #[error(
        "mesh {mesh}, primitive {primitive}: vertex {vertex}: coordinate {text} is not a finite number"
    )]
    Coordinate {
        /// The mesh.
        mesh: usize,
        /// The primitive of the mesh.
        primitive: usize,
        /// The vertex.
        vertex: u32,
        /// The coordinate.
        text: String,
    },
    /// Nothing that has an area.
    #[error("no triangles{}", only(*.points_and_lines, *.without_area))]
    NoTriangles {
        /// Number of primitives of points or lines.
        points_and_lines: usize,
        /// Number of triangles without area, all in nodes that flatten.
        without_area: usize,
    },
}

fn only(points_and_lines: usize, without_area: usize) -> &'static str {
    match (points_and_lines, without_area) {
        (0, 0) => "",
        (_, 0) => ", only points or lines",
        _ => ", only faces without area",
    }
}

impl GltfFault {
    /// What a person can do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::NotGltf => {
                "Choose a .glb or .gltf file; if this was a download, check what the link gives."
            }
            Self::Version { .. } => {
                "Export as glTF 2.0; files of glTF 1 can be opened and exported again by most programs."
            }
            Self::Length { .. } | Self::Chunk { .. } | Self::NoJson => {
                "Export or download the file again: a part of it is missing."
            }
            Self::External { .. } => {
                "Export as one .glb file, or as .gltf with embedded buffers: no other file is opened."
            }
            Self::TooManyObjects { .. } | Self::TooManyTriangles { .. } | Self::TooManySparse => {
                "Export only the part that you want to cut, or fewer copies of it."
            }
            Self::NoTriangles { .. } => {
                "Export a surface mesh with faces: points and lines alone cannot be cut or flattened."
            }
            Self::Coordinate { .. } => {
                "Remove the broken vertex in a modelling program and export the file again."
            }
            Self::Json { .. }
            | Self::Element { .. }
            | Self::Cycle { .. }
            | Self::Mode { .. }
            | Self::Index { .. } => {
                "Export the file again, or with another program: this one contradicts itself or is damaged."
            }
        }
    }

    fn anywhere(self) -> ReadError {
        ReadError { place: Place::File, fault: self.into() }
    }

    fn at_byte(self, byte: u64) -> ReadError {
        ReadError { place: Place::Byte(byte), fault: self.into() }
    }

    fn element(kind: &'static str, index: usize, problem: String) -> ReadError {
        Self::Element { kind, index, problem }.anywhere()
    }
}

/// What a person can do about a file that needs an extension of glTF.
pub fn extension_advice(feature: &str) -> Option<&'static str> {
    if feature.ends_with("_compression") {
        Some(
            "Export again without compression (in Blender: no Compression box), \
             or unpack it: gltf-transform copy in.glb out.glb.",
        )
    } else if feature.starts_with("KHR_") || feature.starts_with("EXT_") {
        Some("Export the file again without this extension, or in another format.")
    } else {
        None
    }
}

/// What was passed over or changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum GltfNote {
    Welded,
    NoArea,
    PointsAndLines,
    WithoutPositions,
    LeftOver,
    OutsideScene,
    Skins,
    Morphs,
    Animations,
    Instancing,
    TextureUnreadable,
    TextureNotFinite,
    NormalsUnreadable,
    NormalNotFinite,
    TrailingBytes,
}

/// Counts of what was passed over or changed.
#[derive(Default)]
struct Notes(BTreeMap<GltfNote, usize>);

impl Notes {
    fn add(&mut self, note: GltfNote, count: usize) {
        if count > 0 {
            *self.0.entry(note).or_default() += count;
        }
    }

    fn count(&self, note: GltfNote) -> usize {
        self.0.get(&note).copied().unwrap_or(0)
    }

    /// **Takes** number of places that vertices were welded to.
    fn into_notices(self, places: usize) -> Vec<ReadNotice> {
        let notice = |(note, n): (GltfNote, usize)| {
            let s = if n == 1 { "" } else { "s" };
            let (kind, text) = match note {
                GltfNote::Welded => ("welded", format!("{n} vertices at {places} places")),
                GltfNote::NoArea => ("no_area", format!("{n} face{s} without area left out")),
                GltfNote::PointsAndLines => {
                    ("points_and_lines", format!("{n} primitive{s} of points or lines left out"))
                }
                GltfNote::WithoutPositions => {
                    ("no_positions", format!("{n} primitive{s} without positions left out"))
                }
                GltfNote::LeftOver => (
                    "incomplete_face",
                    format!("an incomplete last face left out in {n} primitive{s}"),
                ),
                GltfNote::OutsideScene => {
                    ("outside_scene", format!("{n} node{s} with a mesh left out, not in the scene"))
                }
                GltfNote::Skins => {
                    ("skin", format!("{n} skin{s} ignored, the mesh is as it was bound"))
                }
                GltfNote::Morphs => {
                    ("morph_targets", format!("morph targets of {n} primitive{s} ignored"))
                }
                GltfNote::Animations => ("animation", format!("{n} animation{s} ignored")),
                GltfNote::Instancing => {
                    ("instancing", "copies by EXT_mesh_gpu_instancing left out".into())
                }
                GltfNote::TextureUnreadable => (
                    "texture_unreadable",
                    format!("texture coordinates of {n} primitive{s} unreadable, ignored"),
                ),
                GltfNote::NormalsUnreadable => (
                    "normals_unreadable",
                    format!("normals of {n} primitive{s} unreadable, ignored"),
                ),
                GltfNote::TextureNotFinite => (
                    "texture_not_finite",
                    format!("{n} texture coordinate{s} not a number, ignored"),
                ),
                GltfNote::NormalNotFinite => {
                    ("normal_not_finite", format!("{n} normal{s} not a number, ignored"))
                }
                GltfNote::TrailingBytes => {
                    ("trailing_bytes", format!("{n} byte{s} after the end ignored"))
                }
            };
            ReadNotice { kind, count: 1, place: Place::File, text }
        };
        self.0.into_iter().map(notice).collect()
    }
}

/// Reads a glTF 2 file, GLB or JSON.
///
/// **Gives** groups named after nodes, or their meshes; triangles in the order of the scene.
/// **Fails** with [`ReadFault::Empty`], [`ReadFault::EndsEarly`], [`ReadFault::Unsupported`] or a [`GltfFault`].
/// **Costs** time and memory linear in the file and in the triangles that it draws.
pub fn read(bytes: &[u8]) -> Result<Content, ReadError> {
    if bytes.is_empty() {
        return Err(ReadFault::Empty.anywhere());
    }
    let mut notes = Notes::default();
    let parts = container::split(bytes, &mut notes)?;
    let root = container::parse(&parts)?;
    let most = 4_000_000 + bytes.len() as u64 / 2;
    let buffers = Buffers::new(&root, parts.binary, most);
    let source = Source { root: &root, buffers: &buffers, file_bytes: bytes.len() };
    let draws = nodes::draws(&root, &mut notes)?;
    let mut uses = vec![0_u32; root.meshes.len()];
    for draw in &draws {
        uses[draw.mesh] += 1;
    }
    let (mut triangles, mut has_texture, mut has_normals) = (0_u64, false, false);
    for (mesh, &uses) in uses.iter().enumerate().filter(|(_, uses)| **uses > 0) {
        let survey = source.survey(mesh)?;
        triangles = triangles.saturating_add(survey.triangles.saturating_mul(u64::from(uses)));
        has_texture |= survey.has_texture;
        has_normals |= survey.has_normals;
        notes.add(GltfNote::PointsAndLines, survey.points_and_lines);
        notes.add(GltfNote::WithoutPositions, survey.without_positions);
        notes.add(GltfNote::Morphs, survey.morphs);
    }
    // Corners are numbered in 32 bits.
    let most = most.min(u64::from(u32::MAX / 4));
    if triangles > most {
        return Err(GltfFault::TooManyTriangles { triangles, most }.anywhere());
    }
    let mut scene = Scene::new(&root, has_texture, has_normals);
    let mut scratch = Vec::new();
    // Meshes that are drawn again: what they are, and where their texture coordinates begin in the soup.
    let mut meshes: Vec<Option<(Triangles, u32)>> = root.meshes.iter().map(|_| None).collect();
    for draw in &draws {
        let (triangles, texture) = match meshes[draw.mesh].take() {
            Some(mesh) => mesh,
            None => {
                let triangles = source.triangles(draw.mesh, &mut scratch, &mut notes)?;
                notes.add(GltfNote::Welded, triangles.stored);
                scene.places += triangles.positions.len();
                let texture = scene.add_texture(&triangles);
                (triangles, texture)
            }
        };
        scene.add(draw, &triangles, texture, &mut notes)?;
        uses[draw.mesh] -= 1;
        if uses[draw.mesh] > 0 {
            meshes[draw.mesh] = Some((triangles, texture));
        }
    }
    notes.add(GltfNote::Animations, root.animations.len());
    notes.add(GltfNote::Instancing, usize::from(container::uses(&root, "EXT_mesh_gpu_instancing")));
    if scene.soup.polygon_count() == 0 {
        let points_and_lines = notes.count(GltfNote::PointsAndLines);
        let without_area = notes.count(GltfNote::NoArea);
        return Err(GltfFault::NoTriangles { points_and_lines, without_area }.anywhere());
    }
    let places = scene.places;
    if notes.count(GltfNote::Welded) == places {
        notes.0.remove(&GltfNote::Welded);
    }
    Ok(Content { format: Format::Gltf, soup: scene.soup, notices: notes.into_notices(places) })
}

/// The soup as it grows.
struct Scene<'a> {
    root: &'a Root,
    soup: Soup,
    has_texture: bool,
    has_normals: bool,
    groups: HashMap<String, u32>,
    /// For each material of the file its number in the soup.
    materials: Vec<u32>,
    /// Number of places that the vertices of all meshes have, each mesh counted once.
    places: usize,
}

impl<'a> Scene<'a> {
    fn new(root: &'a Root, has_texture: bool, has_normals: bool) -> Self {
        let soup = Soup { starts: vec![0], ..Soup::default() };
        let materials = vec![NONE; root.materials.len()];
        Self { root, soup, has_texture, has_normals, groups: HashMap::new(), materials, places: 0 }
    }

    /// The texture coordinates of a mesh: copies share them. Gives where they begin.
    fn add_texture(&mut self, mesh: &Triangles) -> u32 {
        let first = to_u32(self.soup.texture_coordinates.len());
        self.soup.texture_coordinates.extend(&mesh.texture_coordinates);
        first
    }

    /// Adds a mesh in its place.
    fn add(
        &mut self,
        draw: &Draw,
        mesh: &Triangles,
        texture: u32,
        notes: &mut Notes,
    ) -> Result<(), ReadError> {
        if mesh.corners.is_empty() {
            return Ok(());
        }
        let group = self.group(draw);
        let side = draw.transform.side();
        let first_vertex = to_u32(self.soup.positions.len());
        for &position in &mesh.positions {
            let position = draw.transform.point(position);
            if !position.iter().all(|c| c.abs() <= LARGEST) {
                let problem = "moves a vertex beyond 3.4e38".into();
                return Err(match draw.node {
                    Some(node) => GltfFault::element("node", node, problem),
                    None => GltfFault::element("mesh", draw.mesh, problem),
                });
            }
            // Adding 0 makes 0 of −0.
            self.soup.positions.push(position.map(|c| c + 0.0));
        }
        let first_normal = to_u32(self.soup.normals.len());
        let is_normal = self.add_normals(draw, mesh);
        let (corners, faces) = (mesh.corners.len(), mesh.corners.len() / 3);
        self.soup.corners.reserve(corners);
        self.soup.texture_corners.reserve(if self.has_texture { corners } else { 0 });
        self.soup.normal_corners.reserve(if self.has_normals { corners } else { 0 });
        self.soup.starts.reserve(faces);
        self.soup.polygon_groups.reserve(faces);
        self.soup.polygon_materials.reserve(faces);
        let mut primitives = mesh.materials.iter();
        let (mut end, mut material) = (0, NONE);
        for (face, corners) in mesh.corners.chunks_exact(3).enumerate() {
            while face >= end {
                let Some(&(next, index)) = primitives.next() else { break };
                end = next;
                material = self.material(index);
            }
            if side.is_none() && self.has_no_area(first_vertex, corners) {
                notes.add(GltfNote::NoArea, 1);
                continue;
            }
            let order = if side == Some(true) { [0, 2, 1] } else { [0, 1, 2] };
            let soup = &mut self.soup;
            let shifted = |i: u32, first: u32| if i == NONE { NONE } else { first + i };
            for corner in order {
                let at = 3 * face + corner;
                soup.corners.push(first_vertex + mesh.corners[at]);
                if self.has_texture {
                    soup.texture_corners.push(shifted(mesh.texture_corners[at], texture));
                }
                if self.has_normals {
                    let normal = mesh.normal_corners[at];
                    let normal = if is_normal { shifted(normal, first_normal) } else { NONE };
                    soup.normal_corners.push(normal);
                }
            }
            soup.starts.push(to_u32(soup.corners.len()));
            soup.polygon_groups.push(group);
            soup.polygon_materials.push(material);
        }
        Ok(())
    }

    /// Adds the normals of a mesh, moved; gives whether there is a way to move them.
    fn add_normals(&mut self, draw: &Draw, mesh: &Triangles) -> bool {
        let Some([x, y, z]) = draw.transform.for_normals() else { return false };
        for normal in &mesh.normals {
            let moved = [0, 1, 2].map(|k| x[k] * normal[0] + y[k] * normal[1] + z[k] * normal[2]);
            let length = dot(&moved, &moved).sqrt();
            // A normal of length 0 stays one.
            let is_usable = length > 0.0 && length.is_finite();
            self.soup.normals.push(moved.map(|c| if is_usable { c / length } else { 0.0 }));
        }
        true
    }

    fn has_no_area(&self, first_vertex: u32, corners: &[u32]) -> bool {
        let place = |i: usize| self.soup.positions[(first_vertex + corners[i]) as usize];
        let (a, b, c) = (place(0), place(1), place(2));
        let minus = |p: [f64; 3], q: [f64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let (u, v, w) = (minus(b, a), minus(c, a), minus(c, b));
        let normal = cross(&u, &v);
        let longest = dot(&u, &u).max(dot(&v, &v)).max(dot(&w, &w));
        // A flat map leaves some 1e-16 of the lengths by rounding, where it should leave a line or a point.
        dot(&normal, &normal).sqrt() <= 1e-12 * longest
    }

    fn group(&mut self, draw: &Draw) -> u32 {
        let node_name = draw.node.and_then(|n| self.root.nodes[n].name.as_deref());
        let name = node_name.or(self.root.meshes[draw.mesh].name.as_deref());
        let name = match (name.filter(|n| !n.is_empty()), draw.node) {
            (Some(name), _) => printable(name.as_bytes()),
            (None, Some(node)) => format!("node {node}"),
            (None, None) => format!("mesh {}", draw.mesh),
        };
        let groups = &mut self.soup.groups;
        *self.groups.entry(name).or_insert_with_key(|name| {
            groups.push(name.clone());
            to_u32(groups.len() - 1)
        })
    }

    /// The number of a material of the file; one that does not exist is none.
    fn material(&mut self, index: Option<usize>) -> u32 {
        let Some((index, number)) = index.and_then(|i| Some((i, self.materials.get_mut(i)?)))
        else {
            return NONE;
        };
        if *number == NONE {
            let name = self.root.materials[index].name.as_deref().filter(|n| !n.is_empty());
            *number = to_u32(self.soup.materials.len());
            self.soup
                .materials
                .push(name.map_or(format!("material {index}"), |n| printable(n.as_bytes())));
        }
        *number
    }
}
