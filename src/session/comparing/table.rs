//! Results as a table: a column for each, a line for each measure, and what is best in it.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::message::{Row, Value};
use super::super::method::Method;
use super::{Kept, tidy};

/// All results of a mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ResultTable {
    /// In the order in which they were kept.
    pub results: Vec<ResultCard>,
    /// Measures, a value for each result.
    pub rows: Vec<ResultRow>,
    /// The result that stands now.
    pub current: Option<usize>,
    /// Of a comparison that is under way.
    pub progress: Option<ResultProgress>,
}

/// One result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResultCard {
    /// Its number, as long as the session lasts.
    pub id: usize,
    /// What it is called.
    pub name: String,
    /// Identifier of the method.
    pub method: String,
    /// What a person reads of it.
    pub method_label: String,
    /// Parameters that differ from those of the mesh when it was opened.
    pub settings: Vec<ChangedSetting>,
    /// Whether it can be shown again; a run that failed cannot.
    pub has_result: bool,
    /// Steps made.
    pub steps: Option<usize>,
    /// What the status line said.
    pub status: String,
    /// Solving and flattening, where the driver measured it.
    pub seconds: Option<f64>,
    /// What a person should know; why it failed.
    pub note: Option<String>,
    /// Its measures, by identifier. Those it cannot have are left out.
    pub measures: BTreeMap<String, f64>,
}

/// A parameter that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChangedSetting {
    /// Stable identifier.
    pub id: String,
    /// What a person reads.
    pub label: String,
    /// Its value.
    pub value: Value,
    /// The value as a person reads it, with its unit.
    pub text: String,
}

/// A measure of all results.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResultRow {
    /// Stable identifier.
    pub id: String,
    /// Row header.
    pub label: String,
    /// Unit, or empty.
    pub unit: String,
    /// One for each result; none where it cannot have it.
    pub values: Vec<Option<f64>>,
    /// Whether it is the best of at least two that differ.
    pub best: Vec<bool>,
    /// What the best is called: `fewest shortest least fastest`; empty where none is.
    pub word: &'static str,
}

/// How far a comparison has come.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResultProgress {
    /// The run at work, the first being 1.
    pub at: usize,
    /// Runs.
    pub of: usize,
    /// What the run is called.
    pub label: String,
    /// Whether it waits until Run.
    pub is_held: bool,
    /// The result that the driver wants to look at before the next run, if it waits for that.
    pub waits_for: Option<usize>,
}

impl ResultCard {
    pub(super) fn new(method: Method, name: &str, settings: Vec<ChangedSetting>) -> Self {
        let name = tidy(name);
        let label = method.label().to_owned();
        Self {
            id: 0,
            name: if name.is_empty() { label.clone() } else { name },
            method: method.id().into(),
            method_label: label,
            settings,
            has_result: false,
            steps: None,
            status: String::new(),
            seconds: None,
            note: None,
            measures: BTreeMap::new(),
        }
    }
}

/// Measures of which less is better, and what the least is called. The others are facts.
const LESS_IS_BETTER: [(&str, &str); 10] = [
    ("pieces", "fewest"),
    ("cut_length", "shortest"),
    ("area_distortion", "least"),
    ("angle_distortion", "least"),
    ("flipped", "fewest"),
    ("overlaps", "fewest"),
    ("hencky", "least"),
    ("dirichlet", "least"),
    ("int_u2", "least"),
    ("seconds", "fastest"),
];

pub(super) fn table(entries: &[Kept], current: Option<usize>) -> ResultTable {
    let mut rows: Vec<Row> = Vec::new();
    for row in entries.iter().flat_map(|entry| &entry.rows) {
        if !rows.iter().any(|known| known.id == row.id) {
            rows.push(row.clone());
        }
    }
    let measured = rows.iter().map(|row| {
        let of = |entry: &Kept| entry.rows.iter().find(|own| own.id == row.id)?.now;
        line(&row.id, &row.label, &row.unit, entries.iter().map(of).collect())
    });
    let steps = |entry: &Kept| entry.card.steps.map(|steps| steps as f64);
    let driven = [
        line("steps", "Steps", "", entries.iter().map(steps).collect()),
        line("seconds", "Time", "s", entries.iter().map(|entry| entry.card.seconds).collect()),
    ];
    let rows =
        measured.chain(driven).filter(|row| row.values.iter().any(Option::is_some)).collect();
    let results = entries
        .iter()
        .map(|entry| {
            let value = |row: &Row| Some((row.id.clone(), row.now?));
            ResultCard {
                measures: entry.rows.iter().filter_map(value).collect(),
                ..entry.card.clone()
            }
        })
        .collect();
    ResultTable { results, rows, current, progress: None }
}

fn line(id: &str, label: &str, unit: &str, values: Vec<Option<f64>>) -> ResultRow {
    let word = LESS_IS_BETTER.iter().find(|(known, _)| *known == id).map_or("", |(_, word)| word);
    let known = || values.iter().flatten().copied();
    let (least, most) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::MIN, f64::max));
    let best = values
        .iter()
        .map(|value| !word.is_empty() && least < most && value.is_some_and(|x| x <= least))
        .collect();
    ResultRow { id: id.into(), label: label.into(), unit: unit.into(), values, best, word }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_is_marked_only_where_values_differ_and_less_is_better() {
        let best = |id: &str, values: &[Option<f64>]| line(id, "", "", values.to_vec()).best;
        assert_eq!(best("pieces", &[Some(2.0), None, Some(1.0)]), [false, false, true]);
        assert_eq!(best("pieces", &[Some(2.0), Some(2.0)]), [false, false]);
        assert_eq!(best("flipped", &[Some(0.0), Some(0.0), Some(3.0)]), [true, true, false]);
        assert_eq!(best("seconds", &[Some(1.0), None]), [false, false], "nothing to beat");
        assert_eq!(best("steps", &[Some(1.0), Some(2.0)]), [false, false], "a fact");
    }
}
