//! Errors as a person reads them: what is wrong, where, what to do.

use crate::geometry::GeometryError;
use crate::linalg::LinalgError;
use crate::mesh::MeshError;
use crate::mesh::read::{Place, ReadError};
use crate::methods::flow::SolveError;

/// Something that could not be done, in three parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// What is wrong.
    pub what: String,
    /// Where.
    pub place: String,
    /// What to do about it.
    pub what_to_do: String,
}

impl Problem {
    /// From three texts.
    pub fn new(
        what: impl Into<String>,
        place: impl Into<String>,
        what_to_do: impl Into<String>,
    ) -> Self {
        Self { what: what.into(), place: place.into(), what_to_do: what_to_do.into() }
    }

    /// The text of a file that could not be read.
    pub fn read(name: &str, error: &ReadError) -> Self {
        let fault = capital(&error.fault.to_string());
        let place = match error.place {
            Place::File => format!("{name}."),
            Place::Line(_) => format!("{name}, {}.", error.place),
            place => format!("{name}, {place} (counted from 0)."),
        };
        Self::new(format!("{fault}."), place, error.fault.advice())
    }

    /// The text of triangles that form no surface. `vertex` gives the file's index of a vertex of the mesh.
    pub fn mesh(name: &str, error: &MeshError, vertex: impl Fn(usize) -> usize) -> Self {
        let edges = |edges: &[[crate::mesh::VertexId; 2]]| {
            let [a, b] = edges[0].map(|v| vertex(v.index()));
            let more = match edges.len() {
                1 => String::new(),
                n => format!(" and {} more", n - 1),
            };
            format!("{name}, edge from vertex {a} to vertex {b}{more} (counted from 0).")
        };
        match error {
            MeshError::NoFaces => Self::new(
                "The mesh has no faces.",
                format!("{name}."),
                "Export a surface with faces: points and lines cannot be cut.",
            ),
            MeshError::TooLarge { faces } => Self::new(
                format!("The mesh has {faces} faces, more than can be numbered."),
                format!("{name}."),
                "Reduce it in a modelling program first.",
            ),
            MeshError::RepeatedVertices { faces } => Self::new(
                format!("{} a vertex twice.", subject(faces.len(), "face", "use")),
                format!("{name}, first face {} (counted from 0).", faces[0].0),
                "Remove degenerate faces in a modelling program.",
            ),
            MeshError::NonManifoldEdges { edges: list, .. } => Self::new(
                format!(
                    "{} to three or more faces, so that the mesh is not a surface there.",
                    subject(list.len(), "edge", "belong")
                ),
                edges(list),
                "Remove inner walls and fins in a modelling program (Blender: Select › All by Trait › Non Manifold).",
            ),
            MeshError::InconsistentOrientation { edges: list } => Self::new(
                format!(
                    "{} faces that look in opposite directions.",
                    subject(list.len(), "edge", "join")
                ),
                edges(list),
                "Let a modelling program make the normals consistent (Blender: Mesh › Normals › Recalculate Outside). If that cannot be done, the surface is one-sided.",
            ),
            MeshError::NonManifoldVertices { vertices } => Self::new(
                format!(
                    "{} parts that touch in that point only.",
                    subject(vertices.len(), "vertex", "join")
                ),
                format!(
                    "{name}, vertex {} (counted from 0){}.",
                    vertex(vertices[0].index()),
                    match vertices.len() {
                        1 => String::new(),
                        n => format!(" and {} more", n - 1),
                    }
                ),
                "Split these vertices in a modelling program.",
            ),
        }
    }

    /// The text of a surface that cannot be measured.
    pub fn geometry(name: &str, error: &GeometryError, vertex: impl Fn(usize) -> usize) -> Self {
        match error {
            GeometryError::NotFinite { vertices } => Self::new(
                format!("Coordinates of {} are not finite.", plural(vertices.len(), "vertex")),
                format!("{name}, first vertex {} (counted from 0).", vertex(vertices[0].index())),
                "Remove the broken vertices and export the file again.",
            ),
            GeometryError::NoExtent => Self::new(
                "The mesh has no extent: all its points coincide.",
                format!("{name}."),
                "Check the export; the scale may have been lost.",
            ),
            GeometryError::DegenerateFaces { faces } => Self::new(
                match faces.len() {
                    1 => "The only face has zero area.".to_owned(),
                    n => format!("All {n} faces have zero area: the points lie on one line."),
                },
                format!("{name}."),
                "Check the export; one of the directions may have been lost.",
            ),
        }
    }

    /// The text of a solve whose unknowns are the vertices of a surface. `vertex` gives the file's index of a vertex.
    pub fn solve_at(name: &str, error: &SolveError, vertex: impl Fn(usize) -> Option<u32>) -> Self {
        let problem = Self::solve(name, error);
        let SolveError::Linalg(LinalgError::NotPositiveDefinite { row }) = error else {
            return problem;
        };
        match vertex(*row) {
            Some(v) => {
                Self { place: format!("{name}, at vertex {v} (counted from 0)."), ..problem }
            }
            None => problem,
        }
    }

    /// The text of a solve that could not be done.
    pub fn solve(name: &str, error: &SolveError) -> Self {
        match error {
            SolveError::EmptyCut { .. } => Self::new(
                "The initial cut is empty: the whole surface lies on one side of it.",
                format!("{name}, initial cut."),
                "Move the plane into the model, change the radius of the circle, or lower the cluster angle.",
            ),
            SolveError::NoSuchVertex { vertex, vertices } => Self::new(
                format!("There is no vertex {}: the surface has {vertices}.", vertex.0),
                format!("{name}, initial cut."),
                format!("Choose a number from 0 to {}.", vertices.saturating_sub(1)),
            ),
            SolveError::SeedTwice { vertex } => Self::new(
                format!("Vertex {} is a seed twice.", vertex.0),
                format!("{name}, initial cut."),
                "Leave one of the two out.",
            ),
            SolveError::Parameter { name: parameter, value, min, max } => Self::new(
                format!("The {parameter} is {value}."),
                format!("{name}, parameters."),
                if *max < 1e300 {
                    format!("Choose a value from {min} to {max}.")
                } else {
                    format!("Choose a value of at least {min}.")
                },
            ),
            SolveError::NoEnergy => Self::new(
                "Both distortion weights are 0, so that nothing keeps the cut from shrinking away.",
                "Weights.",
                "Give the Hencky or the Dirichlet distortion a weight.",
            ),
            SolveError::NoFirstRegion => Self::new(
                "Distortion is to count in the first region only, and the initial cut has none.",
                format!("{name}, initial cut."),
                "Paint something with the first colour, choose a circle, or switch One side only off.",
            ),
            SolveError::NotSymmetric => Self::new(
                "The initial cut cannot be made symmetric: on average nothing is left of it.",
                format!("{name}, symmetry."),
                "Choose fewer symmetries, or a start that suits them: normal clusters always do.",
            ),
            SolveError::NoSource => Self::new(
                "The surface is heated nowhere: there is nothing for the cut to cool.",
                format!("{name}, heat source."),
                "Paint where the heat is, or raise the heat of the rest.",
            ),
            SolveError::Linalg(LinalgError::NotPositiveDefinite { .. }) => Self::new(
                "The distortion cannot be computed: the surface is too degenerate.",
                format!("{name}, along the cut."),
                "Remesh the surface with more even triangles and open it again.",
            ),
            SolveError::Linalg(LinalgError::OutOfMemory { size }) => Self::new(
                format!("There is not enough memory to solve with {size} unknowns."),
                format!("{name}."),
                "Reduce the mesh and open it again.",
            ),
            SolveError::Mesh(error) => Self::new(
                format!("The cut surface is no surface any more: {error}."),
                format!("{name}, along the cut."),
                "Undo the last step and choose another initial cut.",
            ),
            SolveError::Cones(error) => Self::new(
                format!("The cones cannot be as asked for: {error}."),
                format!("{name}, cones."),
                "Change the prescribed cones, the excluded region or the bounds.",
            ),
            SolveError::EpsilonTooSmall { epsilon, floor } => Self::new(
                format!("An interface of width {epsilon:.3} is too thin for the triangles."),
                format!("{name}, interface width."),
                if *floor > 0.5 {
                    "Remesh the surface with shorter edges first, under Prepare or by the command prepare.".to_owned()
                } else {
                    format!("Choose {floor:.3} or more, or remesh the surface with shorter edges.")
                },
            ),
            SolveError::PatchCheck { face } => Self::new(
                format!(
                    "The patch of face {} does not keep its limits when it is flattened anew.",
                    face.0
                ),
                format!("{name}, check of the patches."),
                "Change a limit a little and merge again.",
            ),
            SolveError::NotFinite => Self::new(
                "The energy of the cut is not a finite number.",
                format!("{name}."),
                "Remesh the surface with more even triangles and open it again.",
            ),
        }
    }
}

/// Letters of a name that are shown.
const MOST_LETTERS: usize = 120;

/// A file's name as it is shown and written: without control characters and without those that turn the direction of text, cut where it
/// gets too long; its ending stays.
pub fn shown_name(name: &str) -> String {
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let clean: Vec<char> = name.chars().filter(|&c| !c.is_control() && !turns(c)).collect();
    match clean.len() {
        0 => "mesh".into(),
        n if n <= MOST_LETTERS => clean.into_iter().collect(),
        n => clean[..MOST_LETTERS - 12].iter().chain(&['…']).chain(&clean[n - 11..]).collect(),
    }
}

/// Count and noun, with the plural where it is due.
pub fn plural(count: usize, noun: &str) -> String {
    match (count, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "vertex") => format!("{count} vertices"),
        _ => format!("{count} {noun}s"),
    }
}

/// Count, noun and verb.
fn subject(count: usize, noun: &str, verb: &str) -> String {
    let ending = if count == 1 { "s" } else { "" };
    format!("{} {verb}{ending}", plural(count, noun))
}

/// With a capital at its beginning.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}
