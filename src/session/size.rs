//! How large the model really is: the unit of the file, and the three sides of the model in millimetres.

use super::document::Document;
use super::message::{Choice, Event, Value};
use super::params::Settings;
use super::text::Problem;

/// Identifier, name and millimetres of every unit; a file without one has the size that a person gives it.
pub const UNITS: [(&str, &str, Option<f64>); 5] = [
    ("none", "no unit", None),
    ("mm", "mm", Some(1.0)),
    ("cm", "cm", Some(10.0)),
    ("m", "m", Some(1000.0)),
    ("in", "inch", Some(25.4)),
];

/// Sizes that a thing with a pattern can have, millimetres; also the range of the parameter.
pub const RANGE_MM: [f64; 2] = [0.1, 1e5];

/// Sizes that are believed when the unit is only customary for the format.
const BELIEVED_MM: std::ops::RangeInclusive<f64> = 5.0..=2e4;

/// Millimetres of one unit, none for `none` and unknown units.
fn millimetres(unit: &str) -> Option<f64> {
    UNITS.iter().find(|(id, ..)| *id == unit).and_then(|(_, _, mm)| *mm)
}

/// The parameters that suit a newly opened mesh, with the unit and the size that it is taken to have: metres for glTF, which says so, millimetres for
/// STL, which means it, where the result is of a size that things have.
pub fn settings_for(document: &Document) -> Settings {
    let mut settings = Settings::for_sample(document.sample.as_deref());
    if let Some(mm) = document.mm_per_unit {
        let size = mm * document.largest_side();
        settings.put("size", Value::Number(size.clamp(RANGE_MM[0], RANGE_MM[1])));
        return settings;
    }
    let unit = match document.format {
        "glTF" => "m",
        "STL" => "mm",
        _ => return settings,
    };
    let size = document.largest_side() * millimetres(unit).unwrap_or(1.0);
    if BELIEVED_MM.contains(&size) {
        settings.put("unit", Value::Text(unit.into()));
        settings.put("size", Value::Number(size));
    }
    settings
}

/// Keeps the real size of a unit of the file when the mesh becomes another one, as after a repair that drops parts.
pub fn keep(old: &Document, new: &Document, settings: &mut Settings) {
    let size = mm_per_file_unit(old, settings) * new.largest_side();
    settings.put("size", Value::Number(size.clamp(RANGE_MM[0], RANGE_MM[1])));
}

/// Millimetres of one unit of the file where somebody has said so: the file's unit is known, or the size is not the one that
/// everything has at first.
pub fn stated(document: &Document, settings: &Settings) -> Option<f64> {
    let first = Settings::for_sample(None).number("size");
    let is_stated = settings.text("unit") != "none"
        || document.sample.is_some()
        || document.mm_per_unit.is_some()
        || (settings.number("size") - first).abs() > 0.0;
    is_stated.then(|| mm_per_file_unit(document, settings))
}

/// Gives the model the size that the unit of the file says. **Fails** if that is no thing that can be made.
pub fn follow_unit(document: &Document, settings: &mut Settings) -> Result<(), Problem> {
    match millimetres(settings.text("unit")) {
        Some(mm) => set_largest(settings, document.largest_side() * mm),
        None => Ok(()),
    }
}

/// Makes the model so long along an axis, in the display unit. **Fails** on sides without length and sizes out of range.
pub fn set_side(
    document: &Document,
    settings: &mut Settings,
    axis: usize,
    value: f64,
) -> Result<(), Problem> {
    let side = document.size().get(axis).copied().unwrap_or(0.0);
    if !(side > 0.0) {
        return Err(Problem::new(
            "The model has no extent along this axis.",
            "Size.",
            "Give its size along another axis.",
        ));
    }
    let (_, mm) = display_unit(settings);
    set_largest(settings, value * mm * document.largest_side() / side)
}

fn set_largest(settings: &mut Settings, size: f64) -> Result<(), Problem> {
    let [min, max] = RANGE_MM;
    if !(size >= min && size <= max) {
        return Err(Problem::new(
            format!("The largest side would be {size:.3e} mm long."),
            "Size.",
            format!("Choose a size for which it is between {min} mm and {} m.", max / 1000.0),
        ));
    }
    settings.put("size", Value::Number(size));
    Ok(())
}

/// The unit that sizes are shown in, and its millimetres.
fn display_unit(settings: &Settings) -> (&'static str, f64) {
    let unit = UNITS.iter().find(|(id, ..)| *id == settings.text("unit"));
    match unit {
        Some((_, label, Some(mm))) => (label, *mm),
        _ => ("mm", 1.0),
    }
}

/// Millimetres of one unit of the file.
pub fn mm_per_file_unit(document: &Document, settings: &Settings) -> f64 {
    settings.number("size") / document.largest_side().max(1e-300)
}

/// What the page shows.
pub fn event(document: &Document, settings: &Settings) -> Event {
    let (display, mm) = display_unit(settings);
    let scale = mm_per_file_unit(document, settings) / mm;
    let file = document.size();
    Event::Size {
        unit: settings.text("unit").to_owned(),
        units: UNITS.iter().map(|(id, label, _)| Choice::new(id, label)).collect(),
        display_unit: display.to_owned(),
        boxes: file.map(|x| x * scale),
        file,
        is_assumed: stated(document, settings).is_none(),
    }
}
