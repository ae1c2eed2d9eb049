//! What a session offers: methods, presets, symmetries, samples, parameters.

use serde::Serialize;

use super::Value;

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
    /// Whether the cut, or the patches, are kept symmetric.
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
