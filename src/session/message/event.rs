//! What a session tells.

use serde::Serialize;

use super::super::comparing::ResultTable;
use super::super::cones::{ConeComparisonRow, ConePathPoint, ConeTable};
use super::super::patterning::PatternView;
use super::super::segmenting::{DevelopTable, SegmentTree};
use super::{
    ChangeName, Choice, DoctorReport, MeshSummary, MethodChoice, PaintChannel, ParamSpec,
    PatternSize, PieceRow, PresetChoice, Row, SampleChoice, StageNumbers, SymmetryChoice, Term,
    ToolSpec, TradeChoice, Value,
};

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
        /// What the method at work uses them for: `cut` keeps any, `patches` keep one at a time, `pairs` are shown, `nothing`.
        serves: &'static str,
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
