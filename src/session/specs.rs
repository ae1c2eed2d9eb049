//! The table of parameters: sliders, command-line options and help are made from it.

use super::message::{Choice, Condition, ParamKind, ParamSpec, Value};
use super::method::Method;
use super::size::{RANGE_MM, UNITS};
use super::{charting, cones, patterning, segmenting};

/// The group of unit and size, which the page shows in a panel of their own.
const SIZE: &str = "Size";

pub(super) fn number(
    id: &str,
    label: &str,
    symbol: &str,
    unit: &str,
    range: [f64; 3],
    default: f64,
    help: &str,
) -> ParamSpec {
    let [min, max, step] = range;
    ParamSpec {
        id: id.into(),
        label: label.into(),
        symbol: symbol.into(),
        unit: unit.into(),
        group: String::new(),
        help: help.into(),
        advanced: false,
        kind: ParamKind::Number { min, max, step, logarithmic: false, integer: false },
        default: Value::Number(default),
        visible_if: None,
    }
}

impl ParamSpec {
    pub(super) fn group(mut self, group: &str) -> Self {
        self.group = group.into();
        self
    }

    pub(super) fn logarithmic(mut self) -> Self {
        if let ParamKind::Number { logarithmic, .. } = &mut self.kind {
            *logarithmic = true;
        }
        self
    }

    pub(super) fn integer(mut self) -> Self {
        if let ParamKind::Number { integer, .. } = &mut self.kind {
            *integer = true;
        }
        self
    }

    pub(super) fn advanced(mut self) -> Self {
        self.advanced = true;
        self
    }

    pub(super) fn only_if(mut self, id: &str, one_of: &[&str]) -> Self {
        self.visible_if =
            Some(Condition { id: id.into(), one_of: one_of.iter().map(|&v| v.into()).collect() });
        self
    }
}

/// The parameters of the cut flow, in the order of the panel.
pub fn specs() -> Vec<ParamSpec> {
    [start(), energy(), cut(), finish(), charting::specs(), size(), steps()].concat()
}

/// The parameters of a method, in the order of the panel.
pub fn specs_of(method: Method) -> Vec<ParamSpec> {
    let mut all = match method {
        Method::CutFlow => specs(),
        Method::Cones => {
            // Cones decide what the outline is.
            let mut charts = charting::specs();
            charts.retain(|spec| spec.id != "outline");
            [cones::specs(), charts, size()].concat()
        }
        Method::PhaseField => {
            [segmenting::phase_specs(), finish(), charting::specs(), size()].concat()
        }
        Method::Developable => [segmenting::develop_specs(), charting::specs(), size()].concat(),
    };
    all.extend(patterning::specs());
    all
}

/// The parameters of all methods, each once.
pub fn all_specs() -> Vec<ParamSpec> {
    [
        specs(),
        cones::specs(),
        segmenting::phase_specs(),
        segmenting::develop_specs(),
        patterning::specs(),
    ]
    .concat()
}

pub(super) fn choice(
    group: &str,
    id: &str,
    label: &str,
    options: &[(&str, &str)],
    help: &str,
) -> ParamSpec {
    ParamSpec {
        id: id.into(),
        label: label.into(),
        symbol: String::new(),
        unit: String::new(),
        group: group.into(),
        help: help.into(),
        advanced: false,
        kind: ParamKind::Choice {
            options: options.iter().map(|(id, label)| Choice::new(id, label)).collect(),
        },
        default: Value::Text(options[0].0.into()),
        visible_if: None,
    }
}

pub(super) fn switch(group: &str, id: &str, label: &str, default: bool, help: &str) -> ParamSpec {
    ParamSpec {
        kind: ParamKind::Switch,
        default: Value::Truth(default),
        ..choice(group, id, label, &[("", "")], help)
    }
}

/// Where the cut starts.
fn start() -> Vec<ParamSpec> {
    let start = "Start";
    vec![
        choice(
            start,
            "init",
            "Initial cut",
            &[
                ("normals", "Normal clusters"),
                ("plane", "Plane"),
                ("circle", "Circle"),
                ("curvature", "Curvature bands"),
                ("random", "Random cells"),
                ("seeds", "Cells around seeds"),
                ("painted", "Painted regions"),
                ("uv", "UV seams of the mesh"),
                ("groups", "Groups of the mesh"),
                ("materials", "Materials of the mesh"),
                ("volleyball", "Volleyball panels"),
                ("file", "Another cut"),
                ("handed", "Pieces of another method"),
            ],
            "Where the cut starts. Normal clusters give many pieces, a plane or a circle two regions; seeds and regions are set with the brush.",
        ),
        number("angle", "Cluster angle", "", "°", [10.0, 120.0, 1.0], 60.0,
            "Largest angle between a vertex's normal and that of its cluster's first vertex. Smaller angles give more pieces.")
            .group(start).only_if("init", &["normals"]),
        number("regions", "Labels", "N", "", [2.0, 64.0, 1.0], 10.0,
            "Number of labels that the pieces share; pieces that are near one another never have the same.")
            .group(start).integer().only_if("init", &["normals", "curvature", "random"]),
        number("cells", "Cells", "", "", [2.0, 400.0, 1.0], 30.0,
            "Number of random cells; the seed chooses where they are.")
            .group(start).integer().logarithmic().only_if("init", &["random"]),
        choice(start, "axis", "Across", &[("x", "x"), ("y", "y"), ("z", "z")],
            "The axis that the plane is perpendicular to.")
            .only_if("init", &["plane"]),
        number("offset", "Offset", "", "%", [-49.0, 49.0, 1.0], 0.0,
            "Where the plane cuts its axis: 0 is the middle of the model, ±50 its ends.")
            .group(start).only_if("init", &["plane"]),
        number("vertex", "Centre vertex", "", "", [0.0, 1e7, 1.0], 0.0,
            "The vertex that the circle is drawn around, counted from 0 in the file's order; the next one if no face uses it.")
            .group(start).integer().only_if("init", &["circle"]),
        number("radius", "Radius", "", "√A", [0.02, 1.0, 0.01], 0.3,
            "Geodesic radius of the circle; 1 is the side of a square of the surface's area.")
            .group(start).only_if("init", &["circle"]),
    ]
}

/// What distortion costs.
fn energy() -> Vec<ParamSpec> {
    let energy = "Energy";
    vec![
        number("hencky", "Hencky distortion", "w_H", "", [0.0, 1e7, 10.0], 3000.0,
            "Weight of ∫b(u): with b = u² the squared log of stretching, what cloth and sheet feel. 0 leaves it out.")
            .group(energy).logarithmic(),
        choice(energy, "energy_b", "Price b(u)",
            &[
                ("square", "u² (Hencky)"),
                ("fourth", "u⁴: no worst places"),
                ("power", "|u|ᵖ"),
                ("stretch", "Only where charts are too large"),
                ("compress", "Only where charts are too small"),
            ],
            "What a log scale u costs. Material that can stretch but not shrink pays on one side only.")
            .advanced(),
        number("power", "Power", "p", "", [1.1, 12.0, 0.1], 3.0,
            "The larger, the more the worst places count.")
            .group(energy).advanced().only_if("energy_b", &["power"]),
        number("dirichlet", "Dirichlet distortion", "w_D", "", [0.0, 1e5, 0.1], 0.0,
            "Weight of ∫|∇u|², the change of stretching. Works alone or with the Hencky term.")
            .group(energy).logarithmic(),
        switch(energy, "rescaled", "Rescale by feature size", false,
            "Multiplies |∇u|² by the cube of the local feature size, so that tightly curved places do not rule the flow. Wants weights about a hundred times larger.")
            .advanced(),
        choice(energy, "source", "Source of u",
            &[
                ("curvature", "Curvature (flattening)"),
                ("uniform", "Uniform (even density)"),
                ("heat", "Painted heat"),
            ],
            "Curvature makes u the scale of the flattening. A uniform source makes cuts of even density, painted heat a cooling element.")
            .advanced(),
        number("heat", "Heat where painted", "", "×", [1.0, 1000.0, 1.0], 10.0,
            "How many times more heat there is where it was painted than elsewhere.")
            .group(energy).logarithmic().advanced().only_if("source", &["heat"]),
        switch(energy, "one_sided", "One side only", false,
            "Distortion counts inside the first region only: a patch on a surface, such as a bandage.")
            .advanced(),
        number("area", "Growth", "w_A", "", [0.0, 1000.0, 0.5], 0.0,
            "Reward of the first region's area: makes a patch grow until its distortion holds it back.")
            .group(energy).logarithmic().advanced(),
    ]
}

/// What the cut itself costs, and what it may do.
fn cut() -> Vec<ParamSpec> {
    let cut = "Cut";
    vec![
        number("length", "Cut length", "α", "/√A", [0.0, 20.0, 0.05], 2.0,
            "Weight of the cut's length. Larger gives shorter, smoother cuts and more distortion; acts on the next step.")
            .group(cut).logarithmic(),
        choice(cut, "schedule", "Over the steps",
            &[("constant", "Constant"), ("changing", "Changing")],
            "A length weight that falls lets the cut grow slowly, for curves that fill the surface.")
            .advanced(),
        number("length_end", "Cut length at the end", "α", "/√A", [0.001, 20.0, 0.001], 0.1,
            "The weight that the schedule ends with.")
            .group(cut).logarithmic().advanced().only_if("schedule", &["changing"]),
        number("length_steps", "Steps until then", "", "", [1.0, 2000.0, 1.0], 150.0,
            "Every step changes the weight by the same factor.")
            .group(cut).integer().logarithmic().advanced().only_if("schedule", &["changing"]),
        number("eta", "Penalty", "w_η", "/√A", [0.0, 100.0, 0.1], 6.0,
            "What a cut costs, for each unit of its length, where the surface was painted to be spared or is seen from the camera.")
            .group(cut).logarithmic().advanced(),
        choice(cut, "topology", "Topology",
            &[
                ("adaptive", "Automatic"),
                ("preserve", "Preserve"),
                ("merge", "May merge"),
                ("free", "Free"),
            ],
            "Preserve: pieces are neither torn, joined nor pierced. May merge: neighbouring pieces of one label may grow together. \
             Automatic: preserved with two regions, merging with more, which then reach better cuts.")
            .advanced(),
    ]
}

/// What is done to a cut that rests.
fn finish() -> Vec<ParamSpec> {
    let finish = "Finish";
    vec![
        switch(finish, "straighten", "Straighten outlines", true,
            "Takes the zigzag out of cuts at rest: crossings slide along their edges, cuts that only open handles become straightest paths. Pinned places stay.")
            .advanced(),
        switch(finish, "snap", "Snap to mesh edges", false,
            "The cut follows edges of the mesh: no new vertices, but coarser outlines.")
            .advanced(),
    ]
}

/// The real size: of every method.
pub(super) fn size() -> Vec<ParamSpec> {
    vec![
        choice(SIZE, "unit", "Unit", &UNITS.map(|(id, label, _)| (id, label)),
            "What one unit of the file is. Without one the size is what you say."),
        number("size", "Largest side", "", "mm", [RANGE_MM[0], RANGE_MM[1], 0.1], 300.0,
            "The longest side of the model's bounding box at its real size: sets the scale of patterns.")
            .group(SIZE).logarithmic(),
    ]
}

fn steps() -> Vec<ParamSpec> {
    let steps = "Steps";
    vec![
        choice(steps, "scheme", "Scheme",
            &[("fast", "Exact descent"), ("paper", "The paper's flow")],
            "Exact descent is faster and gets lower; the paper's flow is what Learn explains stage by stage.")
            .advanced(),
        number("cap", "Largest move", "", "edges", [0.1, 1.5, 0.05], 1.0,
            "Largest move of the cut in one step, in mean edge lengths. Half is safer and takes twice the steps.")
            .group(steps).advanced(),
        number("steps", "Step limit", "", "", [1.0, 5000.0, 1.0], 300.0,
            "Run stops after this many steps even if the cut still improves.")
            .group(steps).integer().logarithmic().advanced(),
        number("tolerance", "Tolerance", "", "", [1e-7, 1e-2, 1e-7], 1e-4,
            "The run has converged when ten steps together lower the energy by less than this fraction.")
            .group(steps).logarithmic().advanced(),
        switch(steps, "coarse", "Coarse to fine", true,
            "Makes the first steps on a coarser copy of the surface: far fewer steps on the fine one.")
            .advanced(),
        number("kick", "Initial disturbance", "", "edges", [0.0, 1.0, 0.05], 0.5,
            "Smooth random disturbance of the first step. It leads a symmetric start away from its saddle.")
            .group(steps).advanced(),
        number("saddle_tests", "Saddle tests", "", "", [0.0, 5.0, 1.0], 1.0,
            "How often a cut that has converged is disturbed again to see whether there is a better one beside it.")
            .group(steps).integer().advanced(),
        number("seed", "Seed", "", "", [0.0, 1e6, 1.0], 1.0,
            "Chooses the disturbance, and with it which of several good cuts a symmetric start finds; also where random cells are.")
            .group(steps).integer().advanced(),
    ]
}
