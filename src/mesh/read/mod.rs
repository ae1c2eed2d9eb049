//! Reading mesh files: bytes to polygon soup, whatever program they came from.
//!
//! What a file is, its content says; only where that says nothing does the name count ([`read`]).
//!
//! Guaranteed, whatever the bytes are: an answer in linear time, without a panic, with memory of a few times the input
//! (nothing is reserved because a file promises it; most where numbers take one byte each); coordinates correctly
//! rounded, finite and within the range of `f32`; every index of the soup in range; vertices and polygons in the order
//! of the file. What is wrong with texture coordinates and normals is forgiven: it becomes a [`ReadNotice`].
//!
//! Not guaranteed: that the polygons make a surface. A polygon may name a vertex twice, have no area, or share an edge with
//! five others; the doctor finds that out.

mod attributes;
mod detect;
pub mod gltf;
mod number;
pub mod obj;
pub mod off;
pub mod ply;
pub mod stl;
mod words;

use std::fmt;

use thiserror::Error;

pub use detect::sniff;

use super::Soup;

/// The polygons of a mesh file of any known [`Format`].
///
/// **Takes** the name of the file, whose extension decides where the content does not, and its bytes.
/// **Fails** with the first fault in the file.
/// **Costs** time linear in `bytes.len()`.
pub fn read(name: &str, bytes: &[u8]) -> Result<Content, ReadError> {
    check_length(bytes)?;
    match detect::detect(name, bytes)? {
        Format::Obj => obj::read(bytes),
        Format::Ply => ply::read(bytes),
        Format::Stl => stl::read(bytes),
        Format::Off => off::read(bytes),
        Format::Gltf => gltf::read(bytes),
    }
}

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ, text.
    Obj,
    /// Stanford PLY, text or binary.
    Ply,
    /// STL, text or binary.
    Stl,
    /// Object file format, with its variants COFF, NOFF, STOFF, …
    Off,
    /// glTF 2, as GLB or JSON.
    Gltf,
}

impl Format {
    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
            Self::Off => "OFF",
            Self::Gltf => "glTF",
        }
    }
}

/// Where in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of text, counted from 1.
    Line(u32),
    /// A byte of a binary file, counted from 0.
    Byte(u64),
    /// A vertex of a binary file, counted from 0.
    Vertex(u64),
    /// A face of a binary file, counted from 0.
    Face(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
            Self::Vertex(vertex) => write!(f, "vertex {vertex}"),
            Self::Face(face) => write!(f, "face {face}"),
        }
    }
}

/// Why a file was refused: what is wrong ([`ReadError::fault`], displayed), where, and what to do
/// ([`ReadFault::advice`]).
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}{fault}", prefix(*place))]
pub struct ReadError {
    /// Where.
    pub place: Place,
    /// What is wrong.
    pub fault: ReadFault,
}

/// What is wrong with a file that was refused. Texts are quoted from the file, shortened and printable.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReadFault {
    /// No bytes at all.
    #[error("the file is empty")]
    Empty,
    /// A feature of the format that is not understood.
    #[error("needs {feature}, not supported")]
    Unsupported {
        /// Its name, such as `KHR_draco_mesh_compression`.
        feature: String,
    },
    /// The file ends before what it promised.
    #[error("ends early: {found} of {promised} {what}")]
    EndsEarly {
        /// `vertices`, `faces`, `facets`, `bytes`.
        what: &'static str,
        /// Number that is there, whole.
        found: u64,
        /// Number that was promised.
        promised: u64,
    },
    /// Lines and indices are counted in 32 bits.
    #[error("the file has {bytes} bytes, more than 4 GiB")]
    TooLong {
        /// Length of the file.
        bytes: usize,
    },
    /// Something else, by its first bytes.
    #[error("not a mesh file that can be read (looks like {looks_like})")]
    NotAMesh {
        /// What it seems to be.
        looks_like: &'static str,
    },
    /// The first line is not that of the format.
    #[error("no {} header", .format.name())]
    NoHeader {
        /// The format that the name of the file promised.
        format: Format,
    },
    /// A PLY file whose header does not end.
    #[error("header has no end_header")]
    NoEndHeader,
    /// A PLY file that does not say how its numbers are written.
    #[error("header has no format line")]
    NoFormatLine,
    /// A line of a header that has no meaning.
    #[error("header line “{text}” is not understood")]
    HeaderLine {
        /// The line.
        text: String,
    },
    /// Elements of a PLY file that lack something.
    #[error("the element {element} has no property {property}")]
    MissingProperty {
        /// `vertex`, `face`, `tristrips`.
        element: &'static str,
        /// `x`, `vertex_indices`.
        property: &'static str,
    },
    /// There is no vertex.
    #[error("no vertices, {}", if *.faces == 0 { "no faces".into() } else { count(*.faces, "face") })]
    NoVertices {
        /// Number of faces, which can have no meaning.
        faces: usize,
    },
    /// There are vertices, and no word of faces.
    #[error("no faces (point cloud)")]
    PointCloud,
    /// There is no face with three corners.
    #[error("no faces, only {}", list_of_the_rest(*.vertices, *.lines_and_points, *.incomplete_faces))]
    NoFaces {
        /// Number of vertices.
        vertices: usize,
        /// Number of line and point elements.
        lines_and_points: usize,
        /// Number of faces with fewer than three corners.
        incomplete_faces: usize,
    },
    /// The line of a vertex ends early.
    #[error("vertex with {found} of 3 coordinates")]
    MissingCoordinate {
        /// Number of coordinates there.
        found: usize,
    },
    /// A coordinate cannot be read.
    #[error("{text} is not a number{}", if .text.contains(',') { " (decimal comma?)" } else { "" })]
    NotANumber {
        /// The coordinate.
        text: String,
    },
    /// A count cannot be read.
    #[error("{text} is not a count")]
    NotACount {
        /// The count.
        text: String,
    },
    /// A coordinate is infinite or not a number.
    #[error("coordinate {text} is not a finite number")]
    NotFinite {
        /// The coordinate.
        text: String,
    },
    /// A coordinate is finite but cannot be drawn.
    #[error("coordinate {text} is too large (more than 3.4e38)")]
    TooLarge {
        /// The coordinate.
        text: String,
    },
    /// A corner of a face has none of the forms `1`, `1/2`, `1//3`, `1/2/3`.
    #[error("{text} is not a face corner")]
    NotACorner {
        /// The corner.
        text: String,
    },
    /// A face uses a vertex that does not exist.
    #[error("vertex {index} of {vertices}")]
    VertexOutOfRange {
        /// The index as it stands in the file: OBJ counts from 1, or backwards from −1, others from 0.
        index: String,
        /// Number of vertices that the index could have named.
        vertices: usize,
    },
    /// Something of STL alone.
    #[error(transparent)]
    Stl(#[from] stl::StlFault),
    /// Something of glTF alone.
    #[error(transparent)]
    Gltf(#[from] gltf::GltfFault),
}

impl ReadFault {
    /// What a person can do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::Empty => "Export or download the file again, or choose another one.",
            Self::Unsupported { feature } => gltf::extension_advice(feature).unwrap_or(
                "Export the file again without this feature, or in another format (OBJ, PLY, STL, OFF, glTF).",
            ),
            Self::Stl(fault) => fault.advice(),
            Self::Gltf(fault) => fault.advice(),
            Self::EndsEarly { .. } => {
                "Export or download the file again: it is cut short, or its counts are wrong."
            }
            Self::TooLong { .. } => "Reduce the mesh in a modelling program and export it again.",
            Self::NotAMesh { looks_like } if looks_like.contains("archive") => {
                "Unpack it first, then open the mesh file in it: OBJ, PLY, STL, OFF or glTF."
            }
            Self::NotAMesh { .. } | Self::NoHeader { .. } => {
                "Choose an OBJ, PLY, STL, OFF or glTF file (.obj, .ply, .stl, .off, .glb, .gltf). \
                 If this was a download, check what the link gives."
            }
            Self::NoEndHeader
            | Self::NoFormatLine
            | Self::HeaderLine { .. }
            | Self::MissingProperty { .. } => {
                "Export the file again, or in another format: its header is damaged or not usual."
            }
            Self::NoVertices { .. } => {
                "Choose a file that holds a mesh; this one may be a material file, or cut short."
            }
            Self::PointCloud | Self::NoFaces { .. } => {
                "Export a surface mesh with faces: points and lines alone cannot be cut or flattened."
            }
            Self::MissingCoordinate { .. } => {
                "Write three numbers for each vertex; the file may be cut short or damaged here."
            }
            Self::NotANumber { text } if text.contains(',') => {
                "Export with a decimal point, not a comma: many programs follow the language of the system."
            }
            Self::NotANumber { .. } | Self::NotACount { .. } => {
                "Correct this place, or export the file again."
            }
            Self::NotFinite { .. } | Self::TooLarge { .. } => {
                "Remove the broken vertex in a modelling program and export the file again."
            }
            Self::NotACorner { .. } => {
                "Write each corner as a vertex number, with texture and normal numbers after slashes if at all."
            }
            Self::VertexOutOfRange { .. } => {
                "Export the file again: vertices are missing, or the file was put together from several."
            }
        }
    }

    /// This fault in a line.
    fn at(self, line: u32) -> ReadError {
        ReadError { place: Place::Line(line), fault: self }
    }

    /// This fault of the whole file.
    fn anywhere(self) -> ReadError {
        ReadError { place: Place::File, fault: self }
    }
}

/// Something in a file that was passed over or changed in reading, and how often.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadNotice {
    /// Stable identifier such as `incomplete_face`.
    pub kind: &'static str,
    /// How many times.
    pub count: usize,
    /// Where the first time.
    pub place: Place,
    /// A sentence for people without full stop, such as `face with 1 corner ignored`.
    pub text: String,
}

impl fmt::Display for ReadNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", prefix(self.place), self.text)?;
        match self.count {
            0 | 1 => Ok(()),
            n => write!(f, " (and {} more)", n - 1),
        }
    }
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Content {
    /// How it was understood.
    pub format: Format,
    /// Vertices and polygons.
    pub soup: Soup,
    /// What was passed over or changed, in order of places.
    pub notices: Vec<ReadNotice>,
}

fn prefix(place: Place) -> String {
    match place {
        Place::File => String::new(),
        place => format!("{place}: "),
    }
}

/// Whether there is something to read, and not more than 32 bits can count.
fn check_length(bytes: &[u8]) -> Result<(), ReadError> {
    if bytes.is_empty() {
        return Err(ReadFault::Empty.anywhere());
    }
    if u32::try_from(bytes.len()).is_err() {
        return Err(ReadFault::TooLong { bytes: bytes.len() }.anywhere());
    }
    Ok(())
}

/// Adds one to a notice, made when it is the first.
fn note(
    notice: &mut Option<ReadNotice>,
    kind: &'static str,
    place: Place,
    text: impl FnOnce() -> String,
) {
    notice.get_or_insert_with(|| ReadNotice { kind, count: 0, place, text: text() }).count += 1;
}

/// Notes a face that was left out because it has fewer than three corners.
fn note_incomplete_face(notice: &mut Option<ReadNotice>, place: Place, corners: usize) {
    note(notice, "incomplete_face", place, || {
        format!("face with {} ignored", count(corners, "corner"))
    });
}

/// `1 face`, `2 faces`.
fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

fn list_of_the_rest(vertices: usize, lines_and_points: usize, incomplete_faces: usize) -> String {
    let mut list = format!("{vertices} {}", if vertices == 1 { "vertex" } else { "vertices" });
    if lines_and_points > 0 {
        list += &format!(" and {}", count(lines_and_points, "line or point element"));
    }
    if incomplete_faces > 0 {
        list += &format!(" and {}", count(incomplete_faces, "incomplete face"));
    }
    list
}

/// Counts of things in a file, which has at most `u32::MAX` bytes and more bytes than things.
fn to_u32(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}
