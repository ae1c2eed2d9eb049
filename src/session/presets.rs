//! Settings for a purpose, a click each.

use super::message::{Event, PresetChoice, Value};
use super::params::Settings;
use super::specs::specs;
use super::text::Problem;

/// Parameters for one purpose. Parameters that a preset does not name have their defaults, except the size of things.
struct Preset {
    id: &'static str,
    label: &'static str,
    help: &'static str,
    /// The sample that it is made for.
    sample: &'static str,
    texts: &'static [(&'static str, &'static str)],
    numbers: &'static [(&'static str, f64)],
    switches: &'static [(&'static str, bool)],
}

const PRESETS: &[Preset] = &[
    Preset {
        id: "ball",
        label: "Ball",
        help: "One closed seam on a ball, of even stress: the tennis ball comes out by itself.",
        sample: "ball",
        texts: &[("init", "plane"), ("axis", "y")],
        numbers: &[
            ("dirichlet", 3.0),
            ("hencky", 0.0),
            ("length", 2.0),
            ("saddle_tests", 2.0),
            ("tolerance", 1e-5),
        ],
        // Slower, but the same on every target: coarse surfaces of a ball differ by rounding, and with them the valley found.
        switches: &[("coarse", false)],
    },
    Preset {
        id: "upholstery",
        label: "Upholstery",
        help: "Panels of cloth or leather that are stretched little, with short seams.",
        sample: "armchair",
        texts: &[("init", "normals")],
        numbers: &[("angle", 60.0), ("hencky", 3000.0), ("length", 2.0)],
        switches: &[],
    },
    Preset {
        id: "plush",
        label: "Plush",
        help: "Few pieces for stretchy plush, with short seams.",
        sample: "plush_bear",
        texts: &[("init", "normals")],
        numbers: &[("angle", 75.0), ("hencky", 1200.0), ("length", 3.0)],
        switches: &[],
    },
    Preset {
        id: "bandage",
        label: "Bandage",
        help: "A patch that grows around a place as far as it can lie flat. Choose the place with Circle start.",
        sample: "plush_bear",
        texts: &[("init", "circle")],
        numbers: &[("radius", 0.12), ("hencky", 3000.0), ("area", 25.0), ("length", 0.6)],
        switches: &[("one_sided", true), ("coarse", false)],
    },
    Preset {
        id: "vase",
        label: "Space-filling vase",
        help: "A single curve of even density that fills the surface while its length gets cheaper.",
        sample: "wavy_vase",
        texts: &[("init", "circle"), ("source", "uniform"), ("schedule", "changing")],
        numbers: &[
            ("radius", 0.2),
            ("dirichlet", 3.0),
            ("hencky", 0.0),
            ("length", 2.0),
            ("length_end", 0.04),
            ("length_steps", 160.0),
        ],
        switches: &[("coarse", false)],
    },
    Preset {
        id: "heat",
        label: "Heat element",
        help: "A cooling line that is denser where more heat is painted. Paint with Brush, Heat.",
        sample: "car_hood",
        texts: &[("init", "plane"), ("axis", "x"), ("source", "heat"), ("schedule", "changing")],
        numbers: &[
            ("heat", 10.0),
            ("dirichlet", 3.0),
            ("hencky", 0.0),
            ("length", 1.0),
            ("length_end", 0.04),
            ("length_steps", 160.0),
        ],
        switches: &[("coarse", false)],
    },
    Preset {
        id: "atlas",
        label: "Atlas",
        help: "A texture atlas: few charts with short seams, distortion spread out.",
        sample: "plush_bear",
        texts: &[("init", "normals")],
        numbers: &[("angle", 95.0), ("hencky", 600.0), ("length", 8.0)],
        switches: &[],
    },
];

impl Preset {
    fn values(&self) -> impl Iterator<Item = (&'static str, Value)> {
        let texts = self.texts.iter().map(|&(id, text)| (id, Value::Text(text.to_owned())));
        let numbers = self.numbers.iter().map(|&(id, x)| (id, Value::Number(x)));
        texts.chain(numbers).chain(self.switches.iter().map(|&(id, on)| (id, Value::Truth(on))))
    }

    /// The settings of a document with this purpose: those of other methods stay, and so do unit and size.
    fn settings(&self, old: &Settings) -> Settings {
        let mut settings = Settings::for_sample(None);
        let own = specs();
        let is_own =
            |id: &str| own.iter().any(|spec| spec.id == id) && !["unit", "size"].contains(&id);
        settings.copy_unless(is_own, old);
        for (id, value) in self.values() {
            settings.put(id, value);
        }
        settings
    }
}

impl Settings {
    /// The settings for a purpose; unit and size stay.
    pub fn with_preset(&self, id: &str) -> Result<Self, Problem> {
        Ok(preset(id)?.settings(self))
    }
}

/// What Undo calls it.
pub fn label(id: &str) -> Result<&'static str, Problem> {
    Ok(preset(id)?.label)
}

fn preset(id: &str) -> Result<&'static Preset, Problem> {
    PRESETS.iter().find(|p| p.id == id).ok_or_else(|| {
        let known = PRESETS.iter().map(|p| p.id).collect::<Vec<_>>().join(", ");
        Problem::new(
            format!("There is no preset called “{id}”."),
            "In the choice of a preset.",
            format!("Choose one of {known}."),
        )
    })
}

/// All presets, and the one that is in force: all it asks for is set, whatever the numbers of steps.
pub fn event(settings: Option<&Settings>) -> Event {
    let steps: Vec<String> =
        specs().into_iter().filter(|s| s.group == "Steps").map(|s| s.id).collect();
    let is_in_force = |preset: &Preset| {
        settings.is_some_and(|now| {
            let wanted = preset.settings(now).values();
            let now = now.values();
            // Where a circle lies is told by the surface.
            let is_free = |id: &String| steps.contains(id) || id == "vertex";
            wanted.iter().all(|(id, value)| is_free(id) || now.get(id) == Some(value))
        })
    };
    Event::Presets {
        options: PRESETS
            .iter()
            .map(|p| PresetChoice {
                id: p.id.into(),
                label: p.label.into(),
                help: p.help.into(),
                sample: p.sample.into(),
            })
            .collect(),
        current: PRESETS.iter().find(|p| is_in_force(p)).map(|p| p.id.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_names_parameters_in_range_and_a_sample_that_exists() {
        for preset in PRESETS {
            let mut settings = Settings::for_sample(None);
            for (id, value) in preset.values() {
                settings.set(id, value).unwrap_or_else(|e| panic!("{}: {}", preset.id, e.what));
            }
            settings.flow_params().validate().unwrap();
            assert!(super::super::samples::generate(preset.sample).is_some(), "{}", preset.id);
            let Event::Presets { current, .. } = event(Some(&settings)) else { unreachable!() };
            assert_eq!(current.as_deref(), Some(preset.id));
        }
    }

    #[test]
    fn a_preset_leaves_the_parameters_of_other_methods_alone() {
        let mut before = Settings::for_sample(None);
        before.set("choose_by", Value::Text("count".into())).unwrap();
        before.set("omega", Value::Number(2.0)).unwrap();
        before.set("length", Value::Number(7.0)).unwrap();
        for preset in PRESETS {
            let after = before.with_preset(preset.id).unwrap();
            for (id, kept) in [("choose_by", true), ("omega", true), ("length", false)] {
                assert_eq!(after.values()[id] == before.values()[id], kept, "{}: {id}", preset.id);
            }
        }
    }
}
