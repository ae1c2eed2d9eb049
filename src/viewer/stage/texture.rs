//! What pieces carry: textures, and charts that overlap.

use super::super::layers::LayerMode;
use super::super::pixels::Pixels;
use super::{Part, Stage, View};

/// A pattern through the coordinates of the charts: what becomes of its cells on the surface is what
/// flattening does, read backwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Texture {
    /// Plain pieces.
    #[default]
    None,
    /// Squares, each second one darker.
    Checkerboard,
    /// Lines from cell to cell.
    Grid,
    /// A disc in each cell: ellipses show angles that change, sizes show areas.
    Circles,
    /// The coat of a leopard.
    Spots,
    /// Veined stone.
    Marble,
    /// What a person has chosen; plain pieces until then.
    Image,
}

impl Texture {
    /// From what the page calls it.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "none" => Self::None,
            "checkerboard" => Self::Checkerboard,
            "grid" => Self::Grid,
            "circles" => Self::Circles,
            "spots" => Self::Spots,
            "marble" => Self::Marble,
            "image" => Self::Image,
            _ => return None,
        })
    }

    /// What shaders know it by.
    pub fn number(self) -> f32 {
        f32::from(self as u8)
    }
}

impl Stage {
    /// What pieces carry in both views, and the side of its cells in the unit of the charts;
    /// [`Self::usual_cell`] where that is not a number above 0.
    pub fn set_texture(&mut self, texture: Texture, cell: f32) {
        if self.texture != texture {
            self.texture = texture;
            match texture {
                Texture::Spots => {
                    self.generated[0].get_or_insert_with(Pixels::spots);
                }
                Texture::Marble => {
                    self.generated[1].get_or_insert_with(Pixels::marble);
                }
                _ => {}
            }
            self.stamp(true, &[Part::Pixels]);
            self.dirty = [true; 2];
        }
        if self.cell.to_bits() != cell.to_bits() {
            self.cell = cell;
            self.dirty = [true; 2];
        }
    }

    /// What pieces carry where the texture is [`Texture::Image`].
    pub fn set_image(&mut self, image: Pixels) {
        self.image = Some(image);
        self.stamp(true, &[Part::Pixels]);
        self.dirty = [true; 2];
    }

    /// The pixels of the texture, where it is made of some and they are there.
    pub fn pixels(&self) -> Option<&Pixels> {
        match self.texture {
            Texture::Spots => self.generated[0].as_ref(),
            Texture::Marble => self.generated[1].as_ref(),
            Texture::Image => self.image.as_ref(),
            _ => None,
        }
    }

    /// What pieces carry.
    pub fn texture(&self) -> Texture {
        let is_waiting = self.texture == Texture::Image && self.image.is_none();
        if is_waiting { Texture::None } else { self.texture }
    }

    /// Side of a cell of the texture, the same on all charts, so that unequal cells on the surface
    /// show unequal scale.
    pub fn cell(&self) -> f32 {
        // Smaller than this the numbers of cells across the charts lose their fractions.
        if self.cell > 1e-4 && self.cell.is_finite() { self.cell } else { self.usual_cell }
    }

    /// Side of a cell that suits the surface, in the unit of the charts.
    pub fn usual_cell(&self) -> f32 {
        self.usual_cell
    }

    /// How overlapping charts are shown, where there are any.
    pub fn set_layer_mode(&mut self, mode: LayerMode) {
        if mode == self.layer_mode {
            return;
        }
        let had_layers = self.shows_layers();
        self.layer_mode = mode;
        if had_layers != self.shows_layers() {
            self.stamp_isolation();
            self.sheet_is_fitted = true;
            self.sheet.fit(self.bounds(), self.viewport(View::Flat));
        }
        self.dirty = [true; 2];
    }

    /// How overlapping charts are shown.
    pub fn layer_mode(&self) -> LayerMode {
        self.layer_mode
    }

    /// Whether overlapping charts are shown in place of pieces. A field is one value for each place: it is shown on the pieces.
    pub fn shows_layers(&self) -> bool {
        self.layer_mode != LayerMode::Pieces && self.scene.layers.is_some() && !self.shows_field()
    }

    /// The extent of the sheet that is shown.
    pub(super) fn bounds(&self) -> [f32; 4] {
        let layers = self.scene.layers.as_ref().filter(|_| self.shows_layers());
        layers.map_or(self.scene.sheet, |layers| layers.sheet)
    }
}
