//! The parameters of the cut flow: one table for sliders, command-line options and help.

#![expect(
    clippy::cast_possible_truncation,
    reason = "numbers that count are whole and within 32 bits by their ranges"
)]

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use super::message::{Choice, Condition, ParamKind, ParamSpec, Value};
use super::size::{RANGE_MM, UNITS};
use super::surface::Surface;
use super::text::Problem;
use crate::methods::cutflow::{CutFlowParams, Initial, Weights};

/// Values of all parameters of the cut flow.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    values: BTreeMap<&'static str, Value>,
}

/// The group of unit and size, which the page shows in a panel of their own.
const SIZE: &str = "Size";

/// What a change of a parameter asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// A new initial cut.
    Restart,
    /// The next step acts on it.
    NextStep,
    /// Only exports change.
    Export,
}

fn number(
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
    fn group(mut self, group: &str) -> Self {
        self.group = group.into();
        self
    }

    fn logarithmic(mut self) -> Self {
        if let ParamKind::Number { logarithmic, .. } = &mut self.kind {
            *logarithmic = true;
        }
        self
    }

    fn integer(mut self) -> Self {
        if let ParamKind::Number { integer, .. } = &mut self.kind {
            *integer = true;
        }
        self
    }

    fn advanced(mut self) -> Self {
        self.advanced = true;
        self
    }

    fn only_if(mut self, id: &str, one_of: &[&str]) -> Self {
        self.visible_if =
            Some(Condition { id: id.into(), one_of: one_of.iter().map(|&v| v.into()).collect() });
        self
    }
}

/// The table.
pub fn specs() -> Vec<ParamSpec> {
    let start = "Start";
    let weights = "Weights";
    let steps = "Steps";
    let choice = |id: &str, label: &str, options: &[(&str, &str)], help: &str| ParamSpec {
        id: id.into(),
        label: label.into(),
        symbol: String::new(),
        unit: String::new(),
        group: start.into(),
        help: help.into(),
        advanced: false,
        kind: ParamKind::Choice {
            options: options.iter().map(|(id, label)| Choice::new(id, label)).collect(),
        },
        default: Value::Text(options[0].0.into()),
        visible_if: None,
    };
    vec![
        choice(
            "init",
            "Initial cut",
            &[("normals", "Normal clusters"), ("plane", "Plane"), ("circle", "Circle")],
            "Where the cut starts. Normal clusters give many pieces, a plane or a circle two regions.",
        ),
        number("angle", "Cluster angle", "", "°", [10.0, 120.0, 1.0], 60.0,
            "Largest angle between a vertex's normal and that of its cluster's first vertex. Smaller angles give more pieces.")
            .group(start).only_if("init", &["normals"]),
        number("regions", "Labels", "N", "", [4.0, 64.0, 1.0], 10.0,
            "Number of labels that the clusters share; pieces that are near one another never have the same.")
            .group(start).integer().only_if("init", &["normals"]),
        choice(
            "axis",
            "Across",
            &[("x", "x"), ("y", "y"), ("z", "z")],
            "The axis that the plane is perpendicular to.",
        )
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
        number("hencky", "Hencky distortion", "w_H", "", [0.0, 20_000.0, 10.0], 3000.0,
            "Weight of ∫u², the squared log of stretching: what cloth and sheet feel. 0 leaves it out.")
            .group(weights).logarithmic(),
        number("dirichlet", "Dirichlet distortion", "w_D", "", [0.0, 100.0, 0.1], 0.0,
            "Weight of ∫|∇u|², the change of stretching. Works alone or with the Hencky term.")
            .group(weights).logarithmic(),
        number("length", "Cut length", "α", "/√A", [0.0, 20.0, 0.05], 2.0,
            "Weight of the cut's length. Larger gives shorter, smoother cuts and more distortion; acts on the next step.")
            .group(weights).logarithmic(),
        ParamSpec {
            group: SIZE.into(),
            ..choice(
                "unit",
                "Unit",
                &UNITS.map(|(id, label, _)| (id, label)),
                "What one unit of the file is. Without one the size is what you say.",
            )
        },
        number("size", "Largest side", "", "mm", [RANGE_MM[0], RANGE_MM[1], 0.1], 300.0,
            "The longest side of the model's bounding box at its real size: sets the scale of patterns.")
            .group(SIZE).logarithmic(),
        number("cap", "Largest move", "", "edges", [0.1, 1.5, 0.05], 1.0,
            "Largest move of the cut in one step, in mean edge lengths. Half is safer and takes twice the steps.")
            .group(steps).advanced(),
        number("steps", "Step limit", "", "", [1.0, 5000.0, 1.0], 300.0,
            "Run stops after this many steps even if the cut still improves.")
            .group(steps).integer().logarithmic().advanced(),
        number("tolerance", "Tolerance", "", "", [1e-7, 1e-2, 1e-7], 1e-4,
            "The run has converged when ten steps together lower the energy by less than this fraction.")
            .group(steps).logarithmic().advanced(),
        number("kick", "Initial disturbance", "", "edges", [0.0, 1.0, 0.05], 0.5,
            "Smooth random disturbance of the first step. It leads a symmetric start away from its saddle.")
            .group(steps).advanced(),
        number("seed", "Seed", "", "", [0.0, 1e6, 1.0], 1.0,
            "Chooses the disturbance, and with it which of several good cuts a symmetric start finds.")
            .group(steps).integer().advanced(),
    ]
}

impl Settings {
    /// What is good for a designer's mesh: many pieces, Hencky distortion. Samples have defaults of their own.
    pub fn for_sample(sample: Option<&str>) -> Self {
        let mut settings = Self { values: BTreeMap::new() };
        for spec in specs() {
            if let Some(id) = IDS.iter().find(|id| **id == spec.id) {
                settings.values.insert(id, spec.default);
            }
        }
        let two_regions: &[(&'static str, Value)] = match sample {
            // The tennis ball.
            Some("ball") => &[
                ("dirichlet", Value::Number(3.0)),
                ("hencky", Value::Number(0.0)),
                ("size", Value::Number(67.0)),
            ],
            // Open sheets whose normals differ too little for clusters: a seam across.
            Some("car_hood") => {
                &[("axis", Value::Text("x".into())), ("size", Value::Number(1400.0))]
            }
            Some("sinusoidal_sheet") => &[("axis", Value::Text("x".into()))],
            _ => &[],
        };
        let size = match sample {
            Some("tennis_ball") => 67.0,
            Some("volleyball") => 210.0,
            Some("armchair") => 900.0,
            Some("plush_bear") => 350.0,
            _ => settings.number("size"),
        };
        settings.put("size", Value::Number(size));
        if !two_regions.is_empty() {
            settings.values.insert("init", Value::Text("plane".into()));
            settings.values.insert("axis", Value::Text("y".into()));
        }
        for (id, value) in two_regions {
            settings.values.insert(id, value.clone());
        }
        settings
    }

    /// Value of every parameter, by identifier.
    pub fn values(&self) -> BTreeMap<String, Value> {
        self.values.iter().map(|(id, value)| ((*id).to_owned(), value.clone())).collect()
    }

    /// Puts in a value that is known to be in range.
    pub(super) fn put(&mut self, id: &'static str, value: Value) {
        self.values.insert(id, value);
    }

    /// A number.
    pub fn number(&self, id: &str) -> f64 {
        match self.values.get(id) {
            Some(Value::Number(x)) => *x,
            _ => 0.0,
        }
    }

    /// The identifier of the chosen option.
    pub fn text(&self, id: &str) -> &str {
        match self.values.get(id) {
            Some(Value::Text(text)) => text,
            _ => "",
        }
    }

    /// Changes a value.
    ///
    /// **Gives** what has to follow, or `None` if nothing changed. **Fails** on unknown parameters and values out of range.
    pub fn set(&mut self, id: &str, value: Value) -> Result<Option<Effect>, Problem> {
        let all = specs();
        let Some((spec, key)) =
            all.iter().find(|s| s.id == id).zip(IDS.iter().find(|known| **known == id))
        else {
            let known = all.iter().map(|s| s.id.as_str()).collect::<Vec<_>>().join(", ");
            return Err(Problem::new(
                format!("There is no parameter called “{id}”."),
                "In the change of a parameter.",
                format!("Use one of {known}."),
            ));
        };
        let place = format!("{}.", spec.label);
        match (&spec.kind, &value) {
            (ParamKind::Number { min, max, integer, .. }, Value::Number(x)) => {
                if !(x >= min && x <= max) {
                    return Err(Problem::new(
                        format!("{x} is out of range."),
                        place,
                        format!("Choose a number from {min} to {max}."),
                    ));
                }
                if *integer && x.fract().abs() > 0.0 {
                    return Err(Problem::new(
                        format!("{x} is not a whole number."),
                        place,
                        "Choose a whole number.",
                    ));
                }
            }
            (ParamKind::Choice { options }, Value::Text(text))
                if options.iter().any(|o| o.id == *text) => {}
            (ParamKind::Choice { options }, _) => {
                let known = options.iter().map(|o| o.id.as_str()).collect::<Vec<_>>().join(", ");
                return Err(Problem::new(
                    "There is no such option.",
                    place,
                    format!("Choose one of {known}."),
                ));
            }
            (ParamKind::Switch, Value::Truth(_)) => {}
            _ => {
                return Err(Problem::new(
                    "The value has the wrong kind.",
                    place,
                    "Give a number for numbers, a text for choices.",
                ));
            }
        }
        if self.values.get(key) == Some(&value) {
            return Ok(None);
        }
        self.values.insert(key, value);
        Ok(Some(match *key {
            "size" | "unit" => Effect::Export,
            "init" | "angle" | "regions" | "axis" | "offset" | "vertex" | "radius" => {
                Effect::Restart
            }
            _ => Effect::NextStep,
        }))
    }

    /// The options of the flow.
    pub fn flow_params(&self) -> CutFlowParams {
        CutFlowParams {
            weights: Weights {
                dirichlet: self.number("dirichlet"),
                hencky: self.number("hencky"),
                length: self.number("length"),
                ..Weights::default()
            },
            cap: self.number("cap"),
            kick: self.number("kick"),
            seed: self.number("seed") as u64,
            tolerance: self.number("tolerance"),
            ..CutFlowParams::default()
        }
    }

    /// The initial cut on a surface.
    pub fn initial(&self, surface: &Surface) -> Result<Initial, Problem> {
        let (mesh, geometry) = surface.solving();
        Ok(match self.text("init") {
            "plane" => {
                let axis = match self.text("axis") {
                    "x" => 0,
                    "y" => 1,
                    _ => 2,
                };
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
                    let x = geometry.positions[v.index()][axis];
                    low = low.min(x);
                    high = high.max(x);
                }
                let mut point = Point3::origin();
                point[axis] = low + (high - low) * (0.5 + self.number("offset") / 100.0);
                let mut normal = Vector3::zeros();
                normal[axis] = 1.0;
                Initial::Plane { point, normal }
            }
            "circle" => {
                let wanted = self.number("vertex");
                let Some(vertex) = surface.mesh_vertex_from(wanted as usize) else {
                    let count = surface.soup.positions.len();
                    return Err(Problem::new(
                        format!("There is no vertex {wanted}: the mesh has {count}."),
                        "Centre vertex of the initial circle.",
                        format!("Choose a number from 0 to {}.", count - 1),
                    ));
                };
                Initial::Circle { vertex, radius: self.number("radius") }
            }
            _ => Initial::NormalClusters {
                angle: self.number("angle").to_radians(),
                regions: self.number("regions") as u32,
            },
        })
    }
}

/// Identifiers of all parameters.
const IDS: &[&str] = &[
    "init",
    "angle",
    "regions",
    "axis",
    "offset",
    "vertex",
    "radius",
    "hencky",
    "dirichlet",
    "length",
    "unit",
    "size",
    "cap",
    "steps",
    "tolerance",
    "kick",
    "seed",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_has_a_default_within_its_range() {
        let mut settings = Settings::for_sample(None);
        assert_eq!(settings.values().len(), specs().len());
        for spec in specs() {
            assert_eq!(settings.set(&spec.id, spec.default.clone()), Ok(None), "{}", spec.id);
        }
    }

    #[test]
    fn values_out_of_range_are_refused_in_three_parts_and_change_nothing() {
        let mut settings = Settings::for_sample(None);
        let before = settings.clone();
        for (id, value) in [
            ("length", Value::Number(-1.0)),
            ("length", Value::Number(f64::NAN)),
            ("length", Value::Text("much".into())),
            ("init", Value::Text("magic".into())),
            ("regions", Value::Number(7.5)),
            ("nonsense", Value::Number(1.0)),
        ] {
            let problem = settings.set(id, value).unwrap_err();
            assert!(
                ![&problem.what, &problem.place, &problem.what_to_do].iter().any(|t| t.is_empty())
            );
        }
        assert_eq!(settings, before);
    }
}
