//! The values of the cut flow's parameters.

#![expect(
    clippy::cast_possible_truncation,
    reason = "numbers that count are whole and within 32 bits by their ranges"
)]

use std::collections::BTreeMap;

use super::message::{Condition, ParamKind, Value};
use super::method::Method;
use super::specs::{all_specs, specs_of};
use super::text::Problem;
use super::{cones, patterning, segmenting};
use crate::methods::cutflow::{CutFlowParams, Pointwise, Schedule, Scheme, Topology, Weights};

/// Values of all parameters of the cut flow.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    values: BTreeMap<&'static str, Value>,
}

/// What a change of a parameter asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// A new initial cut.
    Restart,
    /// The next step acts on it.
    NextStep,
    /// The cut at rest is finished another way.
    Finish,
    /// Only measures and files in millimetres change.
    Export,
    /// Only the pattern changes.
    Pattern,
    /// Cones are found anew.
    Cones,
    /// The same cones are used another way.
    ConeSet,
    /// A segmentation acts on it from the next step on.
    Segments,
}

impl Settings {
    /// What is good for a designer's mesh: many pieces, Hencky distortion. Samples have defaults of their own.
    pub fn for_sample(sample: Option<&str>) -> Self {
        let mut settings = Self { values: BTreeMap::new() };
        for spec in all_specs() {
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
            // Its symmetric seam is the best one only where length is dear enough.
            Some("tennis_ball") => &[
                ("dirichlet", Value::Number(3.0)),
                ("hencky", Value::Number(0.0)),
                ("length", Value::Number(4.0)),
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

    /// Value of every parameter of all methods, by identifier.
    pub fn values(&self) -> BTreeMap<String, Value> {
        self.values.iter().map(|(id, value)| ((*id).to_owned(), value.clone())).collect()
    }

    /// Puts in a value that is known to be in range.
    pub(super) fn put(&mut self, id: &'static str, value: Value) {
        self.values.insert(id, value);
    }

    /// Takes all values over from other settings but those that are named.
    pub(super) fn copy_unless(&mut self, is_own: impl Fn(&str) -> bool, from: &Self) {
        for (id, value) in from.values.iter().filter(|(id, _)| !is_own(id)) {
            self.values.insert(id, value.clone());
        }
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

    /// Whether there is such a parameter.
    pub fn knows(id: &str) -> bool {
        IDS.contains(&id)
    }

    /// Changes a value.
    ///
    /// **Gives** what has to follow, or `None` if nothing changed. **Fails** on unknown parameters and values out of range.
    pub fn set(&mut self, id: &str, value: Value) -> Result<Option<Effect>, Problem> {
        let all = all_specs();
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
                    let unit = if spec.unit.is_empty() {
                        String::new()
                    } else {
                        format!(" {}", spec.unit)
                    };
                    return Err(Problem::new(
                        format!("{x} is out of range."),
                        place,
                        format!("Choose a number from {min} to {max}{unit}."),
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
            id if patterning::specs().iter().any(|spec| spec.id == id) => Effect::Pattern,
            "init" | "angle" | "regions" | "cells" | "axis" | "offset" | "vertex" | "radius" => {
                Effect::Restart
            }
            // Decides where cells are, too.
            "seed" if self.text("init") == "random" => Effect::Restart,
            "coarse" => Effect::Restart,
            "straighten" | "snap" | "flatten" | "outline" | "split" | "refine" => Effect::Finish,
            "round" if self.text("choose_by") == "count" => Effect::Cones,
            "round" | "debias" | "seam_hiding" => Effect::ConeSet,
            id if cones::specs().iter().any(|spec| spec.id == id) => Effect::Cones,
            id if segmenting::phase_specs().iter().any(|spec| spec.id == id) => Effect::Segments,
            id if segmenting::develop_specs().iter().any(|spec| spec.id == id) => Effect::Segments,
            _ => Effect::NextStep,
        }))
    }

    /// Whether a switch is on.
    pub fn is_on(&self, id: &str) -> bool {
        self.values.get(id) == Some(&Value::Truth(true))
    }

    /// Whether a parameter has the value that another one asks for.
    pub(super) fn meets(&self, condition: &Condition) -> bool {
        let value = match self.values.get(condition.id.as_str()) {
            Some(Value::Text(text)) => text.clone(),
            Some(Value::Truth(is_on)) => is_on.to_string(),
            Some(Value::Number(x)) => x.to_string(),
            None => return false,
        };
        condition.one_of.contains(&value)
    }

    /// Whether a parameter that was given has a say in a method, beside the others' values. **Fails** with what it would need.
    pub fn check_effect(&self, method: Method, id: &str) -> Result<(), Problem> {
        let Some(spec) = specs_of(method).into_iter().find(|spec| spec.id == id) else {
            return Err(Problem::new(
                format!("The parameter “{id}” does not belong to this method."),
                "Among what was given.",
                "Leave it out; --set help lists what this method takes.",
            ));
        };
        match spec.visible_if {
            Some(condition) if !self.meets(&condition) => Err(Problem::new(
                format!("{} ({id}) would change nothing here.", spec.label),
                "Among what was given.",
                format!(
                    "Leave it out, or let {} be {}.",
                    condition.id,
                    condition.one_of.join(" or ")
                ),
            )),
            _ => Ok(()),
        }
    }

    /// The options of the flow.
    pub fn flow_params(&self) -> CutFlowParams {
        CutFlowParams {
            weights: Weights {
                dirichlet: self.number("dirichlet"),
                hencky: self.number("hencky"),
                length: self.number("length"),
                pointwise: match self.text("energy_b") {
                    "fourth" => Pointwise::Fourth,
                    "power" => Pointwise::Power(self.number("power")),
                    "stretch" => Pointwise::Stretch,
                    "compress" => Pointwise::Compress,
                    _ => Pointwise::Square,
                },
                rescaled: self.is_on("rescaled"),
                penalty: self.number("eta"),
                area: self.number("area"),
                one_sided: self.is_on("one_sided"),
            },
            scheme: if self.text("scheme") == "paper" { Scheme::Paper } else { Scheme::Fast },
            topology: match self.text("topology") {
                "merge" => Topology::Merge,
                "free" => Topology::Free,
                "preserve" => Topology::Preserve,
                _ => Topology::Adaptive,
            },
            schedule: (self.text("schedule") == "changing").then(|| Schedule {
                length_end: self.number("length_end"),
                steps: self.number("length_steps") as usize,
            }),
            cap: self.number("cap"),
            kick: self.number("kick"),
            seed: self.number("seed") as u64,
            tolerance: self.number("tolerance"),
            saddle_tests: self.number("saddle_tests") as usize,
            coarse_to_fine: self.is_on("coarse"),
        }
    }
}

/// A parameter that counts.
#[expect(clippy::cast_sign_loss, reason = "counts are not negative by their ranges")]
pub(super) fn whole(x: f64) -> usize {
    x as usize
}

/// Identifiers of all parameters.
const IDS: &[&str] = &[
    "init",
    "angle",
    "regions",
    "cells",
    "axis",
    "offset",
    "vertex",
    "radius",
    "hencky",
    "energy_b",
    "power",
    "dirichlet",
    "rescaled",
    "source",
    "heat",
    "one_sided",
    "area",
    "length",
    "schedule",
    "length_end",
    "length_steps",
    "eta",
    "topology",
    "straighten",
    "snap",
    "unit",
    "size",
    "scheme",
    "cap",
    "steps",
    "tolerance",
    "coarse",
    "kick",
    "saddle_tests",
    "seed",
    "choose_by",
    "lambda",
    "cone_count",
    "exact_count",
    "angle_target",
    "distortion_target",
    "bounds",
    "angle_min",
    "angle_max",
    "importance",
    "dear_cones",
    "feature_weight",
    "boundary",
    "corner_cost",
    "round",
    "debias",
    "seam_hiding",
    "cone_method",
    "multiresolution",
    "flatten",
    "refine",
    "outline",
    "split",
    "levels",
    "fraction",
    "phase_start",
    "starts",
    "phase_seed",
    "epsilon",
    "omega",
    "connected",
    "kappa",
    "screening",
    "relax",
    "warm_up",
    "vsa_tolerance",
    "min_cut",
    "denoise",
    "merge_measure",
    "area_limit",
    "stretch_limit",
    "patch_limit",
    "darts",
    "merge_strategy",
    "improvements",
    "seam_price",
    "allowance",
    "rim_allowance",
    "corner",
    "notches",
    "notch_spacing",
    "seam_labels",
    "piece_labels",
    "marks",
    "hints",
    "grain",
    "folds",
    "fold_angle",
    "flaps",
    "flap_depth",
    "flap_angle",
    "copies",
    "mirrored",
    "outlines",
    "curve_tolerance",
    "kerf",
    "stock",
    "stock_width",
    "stock_height",
    "gap",
    "stock_margin",
    "turns",
    "svg_profile",
    "dxf_profile",
    "dxf_unit",
    "paper",
    "page_overlap",
    "uv_texture",
    "uv_pixels",
    "uv_margin",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_parameter_has_a_default_within_its_range() {
        let mut settings = Settings::for_sample(None);
        assert_eq!(settings.values().len(), all_specs().len());
        for spec in all_specs() {
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

    #[test]
    fn what_would_change_nothing_is_told_with_what_it_would_need() {
        let mut settings = Settings::for_sample(None);
        settings.set("init", Value::Text("plane".into())).expect("a start");
        assert_eq!(settings.check_effect(Method::CutFlow, "offset"), Ok(()));
        assert_eq!(settings.check_effect(Method::CutFlow, "hencky"), Ok(()));
        let radius = settings.check_effect(Method::CutFlow, "radius").unwrap_err();
        assert!(radius.what_to_do.contains("init be circle"), "{}", radius.what_to_do);
        let other = settings.check_effect(Method::CutFlow, "lambda").unwrap_err();
        assert!(other.what.contains("lambda"), "{}", other.what);
        assert_eq!(settings.check_effect(Method::Cones, "lambda"), Ok(()));
    }
}
