//! What a person can ask for.

use serde::{Deserialize, Serialize};

/// What a person can ask for. Meshes come with their bytes through [`crate::session::Session::open`].
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
    /// Keeps the cut symmetric, or developable patches while that method is at work.
    SetSymmetry {
        /// Identifiers of those that are wanted; none sets cut or patches free.
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
