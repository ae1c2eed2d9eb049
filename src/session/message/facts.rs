//! What a session has found out: facts of a mesh, findings, energies, measures, pieces; and files.

use serde::Serialize;

/// Facts of an opened mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshSummary {
    /// File or sample.
    pub name: String,
    /// `OBJ`, `PLY`, `STL`, `OFF`, `glTF` or `sample`.
    pub format: String,
    /// Vertices of the file.
    pub vertices: usize,
    /// Polygons of the file.
    pub faces: usize,
    /// Triangles that the polygons are divided into.
    pub triangles: usize,
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundary_loops: usize,
    /// Sum of the components' genera; none where the faces do not form an orientable surface.
    pub genus: Option<usize>,
    /// V − E + F over the used vertices.
    pub euler: i64,
    /// In the file's unit squared.
    pub area: f64,
    /// Vertices that no face uses.
    pub isolated_vertices: usize,
    /// Whether methods can work on it as it is.
    pub solvable: bool,
    /// What was found and passed over.
    pub notices: Vec<NoticeText>,
}

/// The doctor's report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DoctorReport {
    /// Whether methods can work on the mesh as it is.
    pub solvable: bool,
    /// One sentence.
    pub headline: String,
    /// What [`Command::RepairAll`] would do; empty where nothing stands in the way.
    pub repair_all: Vec<String>,
    /// The finding that is marked on the surface.
    pub shown: Option<String>,
    /// The gravest first.
    pub findings: Vec<FindingText>,
}

/// A finding as a person reads it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FindingText {
    /// Stable identifier.
    pub id: String,
    /// `blocks`, `warning` or `note`.
    pub severity: &'static str,
    /// How many places.
    pub count: usize,
    /// A sentence.
    pub text: String,
    /// Where, by the numbers of the file counted from 0; may be empty.
    pub place: String,
    /// Whether there is something to mark on the surface.
    pub can_show: bool,
    /// What can be done about it, the best first.
    pub repairs: Vec<RepairChoice>,
}

/// A repair that is offered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RepairChoice {
    /// Stable identifier.
    pub id: String,
    /// What the button says.
    pub label: String,
    /// What it does, in a sentence.
    pub help: String,
}

/// A tool that makes other triangles.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ToolSpec {
    /// Stable identifier.
    pub id: String,
    /// Its name.
    pub label: String,
    /// One or two sentences.
    pub help: String,
    /// Why it is recommended for this mesh, if it is.
    pub advice: Option<String>,
    /// Its parameters.
    pub params: Vec<ToolParam>,
}

/// A number that a tool takes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ToolParam {
    /// Stable identifier.
    pub id: String,
    /// Its name.
    pub label: String,
    /// Unit, or empty.
    pub unit: String,
    /// One or two sentences.
    pub help: String,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Smallest change.
    pub step: f64,
    /// Its value at first.
    pub default: f64,
    /// Whether the slider moves by ratios.
    pub logarithmic: bool,
    /// Whether only whole numbers are allowed.
    pub integer: bool,
}

/// Something found in a mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoticeText {
    /// Stable identifier.
    pub kind: String,
    /// How often.
    pub count: usize,
    /// A sentence.
    pub text: String,
    /// Identifiers of the repairs on offer.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub repairs: Vec<String>,
}

impl NoticeText {
    /// A notice that nothing can be done about.
    pub fn new(kind: &str, count: usize, text: impl Into<String>) -> Self {
        Self { kind: kind.to_owned(), count, text: text.into(), repairs: Vec::new() }
    }
}

/// A term of the objective.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Term {
    /// What the plot calls it.
    pub name: String,
    /// Its weighted value.
    pub value: f64,
}

/// A row of the table of measures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Stable identifier.
    pub id: String,
    /// Row header.
    pub label: String,
    /// Unit, or empty.
    pub unit: String,
    /// Now.
    pub now: Option<f64>,
    /// At the initial cut.
    pub start: Option<f64>,
}

impl Row {
    /// A row without its start; values that are not finite are none.
    pub fn new(id: &str, label: &str, unit: &str, now: f64) -> Self {
        Self {
            id: id.into(),
            label: label.into(),
            unit: unit.into(),
            now: now.is_finite().then_some(now),
            start: None,
        }
    }
}

/// A piece in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PieceRow {
    /// Index of the patch.
    pub patch: usize,
    /// Index into the palette.
    pub color: u8,
    /// Fraction of the area.
    pub area_fraction: f64,
    /// Length of its seams, √area = 1.
    pub seam_length: f64,
    /// Root mean square of the log scale factor that its chart really has.
    pub rms_u: Option<f64>,
    /// Turned-over triangles.
    pub flipped: usize,
    /// Crossings of its outline with itself.
    pub overlaps: usize,
    /// Whether it has a chart.
    pub has_chart: bool,
    /// What a person should know, or empty.
    pub note: String,
}

/// Size of the layout.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatternSize {
    /// In `unit`.
    pub width: f64,
    /// In `unit`.
    pub height: f64,
    /// `mm`.
    pub unit: String,
    /// Fraction of the sheet that pieces cover.
    pub filled: f64,
    /// Length of one unit of the scene, in `unit`.
    pub unit_length: f64,
    /// Crossings of outlines, with themselves and with each other.
    pub overlaps: usize,
}

/// A change in the history.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ChangeName {
    /// What Undo and Redo call it.
    pub label: String,
    /// Whether the mesh before it is another one than the mesh after it.
    pub is_other_mesh: bool,
}

/// Bytes to be saved.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    /// Name to offer.
    pub name: String,
    /// Media type.
    pub mime: &'static str,
    /// Content.
    pub bytes: Vec<u8>,
}
