//! The parameters in which a result differs from what its mesh was opened with.

use super::super::document::Document;
use super::super::message::{ParamKind, ParamSpec, Value};
use super::super::method::Method;
use super::super::params::Settings;
use super::super::size::settings_for;
use super::super::specs::specs_of;
use super::ChangedSetting;

/// Groups of parameters that change the pattern only, which results do not measure.
const PATTERN: &str = "Pattern: ";

/// What differs, in the order of the panel. Left out is what has no say beside the others' values, and what changes only sizes and patterns.
pub(super) fn changed(
    document: &Document,
    method: Method,
    settings: &Settings,
) -> Vec<ChangedSetting> {
    let usual = settings_for(document).values();
    let now = settings.values();
    specs_of(method)
        .iter()
        .filter(|spec| !spec.group.starts_with(PATTERN) && !["size", "unit"].contains(&&*spec.id))
        .filter(|spec| spec.visible_if.as_ref().is_none_or(|c| settings.meets(c)))
        .filter_map(|spec| {
            let value = now.get(&spec.id)?;
            (usual.get(&spec.id) != Some(value)).then(|| ChangedSetting {
                id: spec.id.clone(),
                label: spec.label.clone(),
                value: value.clone(),
                text: text(spec, value),
            })
        })
        .collect()
}

/// A value as a person reads it.
fn text(spec: &ParamSpec, value: &Value) -> String {
    match (value, &spec.kind) {
        (Value::Truth(true), _) => "on".into(),
        (Value::Truth(false), _) => "off".into(),
        (Value::Text(id), ParamKind::Choice { options }) => {
            let known = options.iter().find(|option| option.id == *id);
            known.map_or_else(|| id.clone(), |option| option.label.clone())
        }
        (Value::Text(text), _) => text.clone(),
        (Value::Number(x), _) => format!("{} {}", short(*x), spec.unit).trim_end().to_owned(),
    }
}

/// Four digits that mean something.
fn short(x: f64) -> String {
    let digits: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    if digits.abs() > 0.0 && !(1e-4..1e7).contains(&digits.abs()) {
        format!("{digits:e}")
    } else {
        digits.to_string()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn numbers_are_written_with_the_digits_that_matter() {
        for (x, text) in [(0.123_456, "0.1235"), (3.0, "3"), (0.0, "0"), (1e-6, "1e-6")] {
            assert_eq!(super::short(x), text);
        }
    }
}
