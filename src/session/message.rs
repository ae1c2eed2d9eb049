//! What goes into a session and what comes out of it: plain values that serialise.

use serde::{Deserialize, Serialize};

use super::comparing::ResultTable;
use super::cones::{ConeComparisonRow, ConePathPoint, ConeTable};
use super::patterning::PatternView;
use super::segmenting::{DevelopTable, SegmentTree};

/// What a person can ask for. Meshes come with their bytes through [`super::Session::open`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Command {
    /// Says what there is: samples, history.
    Hello,
    /// Opens one of the generated surfaces.
    OpenSample {
        /// Its identifier.
        name: String,
    },
    /// Changes a parameter of the method.
    SetParameter {
        /// Its identifier.
        id: String,
        /// Number, text or truth value, as its kind asks.
        value: Value,
    },
    /// A control is held, or let go: what would make its next move wait is put off meanwhile.
    Hold {
        /// Whether it is held.
        is_held: bool,
    },
    /// Steps until the flow ends or is paused.
    Run,
    /// Stops stepping.
    Pause,
    /// One step, then a pause.
    Step,
    /// Back to the initial cut.
    Reset,
    /// Chooses the field that is painted on the surface; `pieces` for none.
    ShowField {
        /// Its identifier.
        id: String,
    },
    /// Takes the last change back.
    Undo,
    /// Makes it again.
    Redo,
    /// Puts the cut of the mesh before on the one that is open, by nearest points.
    KeepCut,
    /// Takes back, or makes again, several changes at once.
    Travel {
        /// How many: negative ones are taken back, positive ones are made again.
        changes: i32,
    },
    /// Shows the document again after an error.
    DismissError,
    /// Marks what a finding names on the surface; `None` goes back to the pieces.
    ShowFinding {
        /// Its identifier.
        id: Option<String>,
    },
    /// One repair that a finding offers.
    Repair {
        /// Its identifier.
        id: String,
    },
    /// All repairs that stand between the mesh and a cut.
    RepairAll,
    /// Says what one unit of the file is.
    SetUnit {
        /// One of `none mm cm m in`.
        id: String,
    },
    /// Says how long the model is along one axis; the other axes follow.
    SetSize {
        /// 0, 1 or 2 for x, y or z.
        axis: usize,
        /// In the display unit.
        value: f64,
    },
    /// Makes other triangles for the surface.
    Prepare {
        /// Identifier of the tool.
        tool: String,
        /// Its parameters, by identifier; those left out have their defaults.
        #[serde(default)]
        values: std::collections::BTreeMap<String, f64>,
    },
    /// Stops a preparation; the document stays as it was.
    Cancel,
    /// Sets the parameters for a purpose.
    ApplyPreset {
        /// Its identifier.
        id: String,
    },
    /// One dab of the brush. Places and radii are those of the scene, whose surface fits the unit ball.
    Paint {
        /// What is painted: `region seed penalty heat pin`.
        channel: String,
        /// The face of the mesh under the brush.
        face: u32,
        /// Its middle.
        place: [f64; 3],
        /// How far it reaches.
        radius: f64,
        /// An amount from 0 (erases) to 1, or a label; for seeds 0 takes the nearest one away.
        value: f64,
        /// Whether a stroke begins: strokes are what Undo takes back.
        #[serde(default)]
        begins: bool,
    },
    /// The stroke has ended. Regions that it painted are where the flow starts from then on.
    EndStroke,
    /// Takes all paint of one kind away.
    ClearPaint {
        /// What was painted.
        channel: String,
    },
    /// Starts from a circle around a place.
    PlaceCircle {
        /// The face of the mesh there.
        face: u32,
        /// The place in the scene.
        place: [f64; 3],
    },
    /// Makes cuts dear where they are seen.
    HideFromCamera {
        /// Where from, in the scene.
        eye: [f64; 3],
    },
    /// Looks for mirror planes and axes.
    FindSymmetries,
    /// Keeps the cut symmetric.
    SetSymmetry {
        /// Identifiers of those that are wanted; none sets the cut free.
        ids: Vec<String>,
    },
    /// Rebuilds the surface from the flat pieces.
    Fold,
    /// Shows the surface itself again.
    Unfold,
    /// Chooses the method; what the other one made stays.
    SetMethod {
        /// `cutflow`, `cones`, `phasefield` or `developable`.
        id: String,
    },
    /// Shows a segment of the hierarchy.
    SelectSegment {
        /// Its number.
        node: usize,
    },
    /// What is to become of the seam between two pieces of developable patches.
    Sew {
        /// The pieces.
        patches: [usize; 2],
        /// Whether they are to be one; otherwise they are to stay two.
        joins: bool,
    },
    /// Goes on with the cut flow from the pieces that there are.
    HandOver,
    /// Shows the sheet of the pattern and follows its changes, or stops doing so.
    ShowPattern {
        /// Whether it is shown.
        is_shown: bool,
    },
    /// Looks for a better layout of the pieces on the sheet, until it is paused.
    Nest,
    /// Sets what a trade usually asks of a pattern.
    ApplyTrade {
        /// Its identifier.
        id: String,
    },
    /// Gives a seam an allowance of its own, as long as the cut stays as it is.
    SetSeamAllowance {
        /// Number of the seam.
        seam: usize,
        /// In millimetres; without one it has what all have.
        #[serde(default)]
        mm: Option<f64>,
    },
    /// Puts a cone where a person wants one.
    AddCone {
        /// The face of the mesh there.
        face: u32,
        /// The place in the scene.
        place: [f64; 3],
        /// Its angle in radians; without one it takes the angle that is best.
        #[serde(default)]
        angle: Option<f64>,
    },
    /// Moves a cone.
    MoveCone {
        /// Its number in [`Event::Cones`].
        cone: usize,
        /// The face of the mesh there.
        face: u32,
        /// The place in the scene.
        place: [f64; 3],
    },
    /// Gives a cone an angle; the others make up for it.
    SetConeAngle {
        /// Its number in [`Event::Cones`].
        cone: usize,
        /// In radians; without one it takes the angle that is best.
        angle: Option<f64>,
    },
    /// Takes a cone away; the others make up for it.
    RemoveCone {
        /// Its number in [`Event::Cones`].
        cone: usize,
    },
    /// Takes back what was done to cones by hand.
    ClearCones,
    /// Solves for the whole range of λ.
    TracePath,
    /// Sets the greedy strategy of older work beside the optimum.
    CompareCones,
    /// Keeps what stands now as a result to compare.
    KeepResult {
        /// What it is called; without one by its method.
        #[serde(default)]
        name: Option<String>,
        /// Time that it took, where the driver measured it.
        #[serde(default)]
        seconds: Option<f64>,
    },
    /// Makes a result what stands now.
    RestoreResult {
        /// Its number.
        id: usize,
    },
    /// Takes a result out of the comparison.
    RemoveResult {
        /// Its number.
        id: usize,
    },
    /// Gives a result another name.
    RenameResult {
        /// Its number.
        id: usize,
        /// What it is called.
        name: String,
    },
    /// Runs methods or settings in turn on the mesh as it is, and keeps the result of each. The document stays what it was.
    Compare {
        /// What to run; every method with the present parameters without any.
        #[serde(default)]
        runs: Vec<RunRequest>,
        /// Steps after which a flow is stopped. Cones are solved to the end.
        #[serde(default)]
        steps: Option<usize>,
        /// Whether to wait for [`Command::NextResult`] after each result.
        #[serde(default)]
        waits: bool,
    },
    /// The last result has been seen: the next run may begin.
    NextResult,
    /// Measures between two places of the surface.
    Measure {
        /// One end.
        from: Spot,
        /// The other.
        to: Spot,
    },
}

/// A run of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunRequest {
    /// `cutflow`, `cones`, `phasefield` or `developable`.
    pub method: String,
    /// Parameters that are to differ from the present ones.
    #[serde(default)]
    pub values: std::collections::BTreeMap<String, Value>,
    /// What the result is called; without one by its method.
    #[serde(default)]
    pub name: Option<String>,
}

/// A place of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spot {
    /// The face of the mesh there.
    pub face: u32,
    /// The place in the scene.
    pub place: [f64; 3],
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// Of a switch.
    Truth(bool),
    /// Of a number.
    Number(f64),
    /// Of a choice: the option's identifier.
    Text(String),
}

/// What a session tells.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Event {
    /// The samples that can be opened.
    Samples {
        /// All of them.
        options: Vec<SampleChoice>,
        /// The open one.
        current: Option<String>,
    },
    /// A mesh was opened.
    Mesh(MeshSummary),
    /// The parameters and their values.
    Parameters {
        /// Identifier of the method.
        method: String,
        /// All parameters, in the order of the panel.
        specs: Vec<ParamSpec>,
        /// Value of each, by identifier.
        values: std::collections::BTreeMap<String, Value>,
    },
    /// The status line.
    Status {
        /// One of `ready running paused converged stalled step_limit preparing error`.
        state: String,
        /// Accepted steps.
        step: usize,
        /// What the line says.
        text: String,
    },
    /// The objective after a step; step 0 starts a new curve.
    Energy {
        /// Accepted steps.
        step: usize,
        /// J.
        total: f64,
        /// Its weighted terms.
        terms: Vec<Term>,
    },
    /// Numbers of the current cut and its flattening.
    Measures {
        /// The table.
        rows: Vec<Row>,
        /// One for each piece.
        pieces: Vec<PieceRow>,
        /// Size of the layout at its real size.
        pattern: Option<PatternSize>,
        /// What a person should know of how the cut was finished.
        note: Option<String>,
    },
    /// The fields that can be painted.
    Fields {
        /// The one that is.
        current: String,
        /// All of them, `pieces` first.
        options: Vec<Choice>,
    },
    /// What Undo and Redo would do.
    History {
        /// The changes that Undo goes through, the last one first.
        done: Vec<ChangeName>,
        /// The changes that Redo goes through, the next one first.
        undone: Vec<ChangeName>,
        /// The change that Undo would take back.
        undo: Option<String>,
        /// The change that Redo would make again.
        redo: Option<String>,
    },
    /// The mesh took the place of another file whose cut can be kept.
    KeepOffer {
        /// The name of the mesh before.
        from: String,
    },
    /// Something could not be done; the document is as it was.
    Error {
        /// What is wrong.
        what: String,
        /// Where.
        #[serde(rename = "where")]
        place: String,
        /// What to do about it.
        what_to_do: String,
    },
    /// What was found in the mesh.
    Doctor(DoctorReport),
    /// What other triangles can be made.
    Tools {
        /// All tools.
        options: Vec<ToolSpec>,
    },
    /// The real size of the model.
    Size {
        /// What one unit of the file is.
        unit: String,
        /// All that it can be.
        units: Vec<Choice>,
        /// The unit of `boxes`.
        display_unit: String,
        /// Width, height and depth.
        boxes: [f64; 3],
        /// The same in units of the file.
        file: [f64; 3],
        /// Whether nobody has said how large it is.
        is_assumed: bool,
    },
    /// How far a preparation has come.
    Progress {
        /// What is done.
        label: String,
        /// Part that is done, where it can be told.
        fraction: Option<f32>,
    },
    /// The presets.
    Presets {
        /// All of them.
        options: Vec<PresetChoice>,
        /// The one whose settings are in force.
        current: Option<String>,
    },
    /// What the brush can paint.
    PaintChannels {
        /// All of it.
        options: Vec<PaintChannel>,
    },
    /// Symmetries of the surface.
    Symmetries {
        /// Whether anybody has looked.
        is_searched: bool,
        /// What was found, the most exact first.
        options: Vec<SymmetryChoice>,
    },
    /// The surface rebuilt from the flat pieces. Lengths for a surface of unit area.
    Fold {
        /// Whether it is shown.
        is_on: bool,
        /// Steps so far.
        step: usize,
        /// Mean distance from the surface.
        distance_mean: f64,
        /// Largest distance.
        distance_max: f64,
        /// Root mean square of the logs of lengths that are still wrong.
        stretch: f64,
    },
    /// One step of the flow in numbers, stage by stage.
    Stages {
        /// The step that it would be.
        step: usize,
        /// By stage.
        stages: Vec<StageNumbers>,
    },
    /// The methods that there are.
    Methods {
        /// The one at work.
        current: String,
        /// All of them.
        options: Vec<MethodChoice>,
    },
    /// The cones as they are now.
    Cones(ConeTable),
    /// What is known of the optimum as a function of λ, λ descending.
    ConePath {
        /// Where it was computed.
        points: Vec<ConePathPoint>,
        /// Whether the whole range was.
        is_complete: bool,
    },
    /// Ways to choose as many cones, side by side.
    ConeComparison {
        /// The optimum first.
        rows: Vec<ConeComparisonRow>,
    },
    /// The hierarchy of a phase field.
    Segments(SegmentTree),
    /// How developable patches come about.
    Patches(DevelopTable),
    /// The trades whose usual settings can be had for patterns.
    Trades {
        /// All of them.
        options: Vec<TradeChoice>,
        /// The one whose settings are in force.
        current: Option<String>,
    },
    /// The sheet of the pattern as it would be written now.
    Pattern(PatternView),
    /// Results side by side, and how far runs have come that give more.
    Comparison(ResultTable),
    /// How far two places are from each other.
    Measured {
        /// Along the straight line between them, in millimetres.
        straight_mm: f64,
        /// Along the surface; none where no way along it joins them.
        along_mm: Option<f64>,
        /// The way along the surface, in the scene.
        path: Vec<[f64; 3]>,
    },
    /// A new scene is there.
    Scene,
}

/// A method.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MethodChoice {
    /// Stable identifier.
    pub id: String,
    /// What a person reads.
    pub label: String,
}

/// A trade.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TradeChoice {
    /// Stable identifier.
    pub id: String,
    /// What a person reads.
    pub label: String,
    /// What it asks for.
    pub help: String,
}

/// Settings for a purpose.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PresetChoice {
    /// Stable identifier.
    pub id: String,
    /// What a person reads.
    pub label: String,
    /// What it is for.
    pub help: String,
    /// The sample that it is made for.
    pub sample: String,
}

/// Something that the brush paints.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PaintChannel {
    /// Stable identifier.
    pub id: String,
    /// What a person reads.
    pub label: String,
    /// What it does.
    pub help: String,
    /// `amount`, `label` or `place`.
    pub kind: &'static str,
    /// Whether there is none of it.
    pub is_empty: bool,
}

/// A symmetry of the surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SymmetryChoice {
    /// Stable identifier.
    pub id: String,
    /// What a person reads.
    pub label: String,
    /// How far the surface is from it, as a fraction of its size.
    pub deviation: f64,
    /// Whether the cut is kept symmetric.
    pub on: bool,
}

/// What one stage of a step came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageNumbers {
    /// Stable identifier.
    pub id: String,
    /// Its numbers.
    pub numbers: Vec<StageNumber>,
}

/// A number of a stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageNumber {
    /// What it is.
    pub label: String,
    /// Its value, none where there is none.
    pub value: Option<f64>,
    /// Unit, or empty.
    pub unit: String,
}

/// Something to choose.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Choice {
    /// Stable identifier.
    pub id: String,
    /// What a person reads.
    pub label: String,
}

impl Choice {
    /// An option.
    pub fn new(id: &str, label: &str) -> Self {
        Self { id: id.into(), label: label.into() }
    }
}

/// A generated surface.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SampleChoice {
    /// Stable identifier.
    pub name: String,
    /// What a person reads.
    pub label: String,
    /// What it is good for.
    pub description: String,
}

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

/// A parameter: slider, command-line option and help text are made from it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParamSpec {
    /// Stable identifier.
    pub id: String,
    /// Its name.
    pub label: String,
    /// Its letter in the papers, or empty; `w_H` has an index.
    pub symbol: String,
    /// Unit, or empty.
    pub unit: String,
    /// Heading that it stands under.
    pub group: String,
    /// One or two sentences.
    pub help: String,
    /// Whether it is folded away.
    pub advanced: bool,
    /// What it takes.
    pub kind: ParamKind,
    /// Its value at first.
    pub default: Value,
    /// Shown only while another parameter has one of these values.
    pub visible_if: Option<Condition>,
}

/// What a parameter takes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ParamKind {
    /// A number within bounds.
    Number {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
        /// Smallest change.
        step: f64,
        /// Whether the slider moves by ratios.
        logarithmic: bool,
        /// Whether only whole numbers are allowed.
        integer: bool,
    },
    /// One of several.
    Choice {
        /// All of them.
        options: Vec<Choice>,
    },
    /// On or off.
    Switch,
}

/// A parameter has one of these values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// The parameter.
    pub id: String,
    /// The values.
    pub one_of: Vec<String>,
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
