//! How each layer looks in print: the same in every format that has colours.

use super::sheet::Layer;

/// Names and looks of a layer.
pub(super) struct Style {
    /// As an id.
    pub id: &'static str,
    /// As people read it in a list of layers, and as DXF has it.
    pub label: &'static str,
    /// In a legend.
    pub meaning: &'static str,
    pub rgb: [u8; 3],
    /// Dash, gap, dash, gap, … in millimetres; nothing for a solid line.
    pub dashes: &'static [f64],
}

/// Width of all lines in print, mm.
pub(super) const WIDTH: f64 = 0.25;

pub(super) fn style(layer: Layer) -> Style {
    const BLACK: [u8; 3] = [0; 3];
    const GREY: [u8; 3] = [0x5b, 0x61, 0x6c];
    let (id, label, meaning, rgb, dashes): (_, _, _, _, &[f64]) = match layer {
        Layer::Cut => ("cut", "CUT", "Cut", BLACK, &[]),
        Layer::Sew => ("sew", "SEW", "Sew or glue", [0x2f, 0x6f, 0xb5], &[3.0, 1.5]),
        Layer::Notch => ("notch", "NOTCH", "Notch: matches its partner", BLACK, &[]),
        Layer::Grain => ("grain", "GRAIN", "Grain of the material", GREY, &[]),
        Layer::FoldMountain => {
            ("fold_m", "FOLD_M", "Mountain fold", [0xa3, 0x3a, 0x2c], &[6.0, 2.0, 0.1, 2.0])
        }
        Layer::FoldValley => ("fold_v", "FOLD_V", "Valley fold", [0x2c, 0x6b, 0x3f], &[4.0, 2.0]),
        Layer::Score => ("score", "SCORE", "Score", [0x7a, 0x4f, 0xa0], &[2.0, 1.0]),
        Layer::Drill => ("drill", "DRILL", "Drill or punch", BLACK, &[]),
        Layer::Internal => ("internal", "INTERNAL", "Marks inside a piece", GREY, &[]),
        Layer::Text => ("text", "TEXT", "Names and notes", [0x1b, 0x1d, 0x22], &[]),
        Layer::Control => ("control", "CONTROL", "Control of size", GREY, &[]),
    };
    Style { id, label, meaning, rgb, dashes }
}

impl Layer {
    /// Short and unique: as an id in files and settings.
    pub fn id(self) -> &'static str {
        style(self).id
    }

    /// What it is, in a few words.
    pub fn meaning(self) -> &'static str {
        style(self).meaning
    }
}
