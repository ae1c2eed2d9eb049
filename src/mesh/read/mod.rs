//! Reading mesh files: bytes to polygon soup, whatever program they came from.
//!
//! Guaranteed, whatever the bytes are: an answer in linear time, without a panic, with memory of a few times the input
//! (nothing is reserved because a file promises it); coordinates finite and within the range of `f32`; every index of the
//! soup in range; vertices and polygons in the order of the file.
//!
//! Not guaranteed: that the polygons make a surface. A polygon may name a vertex twice, have no area, or share an edge with
//! five others; the doctor finds that out.

pub mod gltf;
pub mod stl;

use std::fmt;

use thiserror::Error;

use super::Soup;

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
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => Ok(()),
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
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
    /// Something of STL alone.
    #[error(transparent)]
    Stl(#[from] stl::StlFault),
    /// Something of glTF alone.
    #[error(transparent)]
    Gltf(#[from] gltf::GltfFault),
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
