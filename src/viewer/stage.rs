//! What is to be drawn: the newest scene, two cameras, the switches. No graphics device.
//!
//! Each thing that a graphics device holds a copy of is a [`Part`] with a stamp. A setter only moves
//! stamps; bytes are made when a view is drawn, so that a scene which is overtaken by a newer one
//! before the next frame costs next to nothing.

mod glyphs;
mod looking;
mod moving;
mod part;
mod picking;
mod pointing;
mod texture;

pub use looking::{Clip, ClipAxis};
pub use part::{Part, RAMP_PIXELS};
pub use picking::Pick;
pub use pointing::{MOST_PINS, PinLabel, Pointed, Seam};
pub use texture::Texture;

use super::arrays::{self, NONE, SceneError};
use super::brush::Stroke;
use super::camera::{Orbit, Sheet, Viewport};
use super::color::Theme;
use super::cones::{Drag, Marks};
use super::layers::LayerMode;
use super::occlusion::Occlusion;
use super::pick::Hierarchy;
use super::pixels::Pixels;
use crate::session::scene::{PatchScene, Scene};
use glam::{Vec2, Vec3};

/// Smallest disc, as a radius in CSS pixels, that a chart's number fits into.
const NUMBER_ROOM: f32 = 9.0;
/// Cells of the texture along the side of a square of the surface's area: about ten across one of a dozen
/// pieces. Twice as many are noise at the size of a laptop's window, half as many show too little of a
/// chart's change of scale.
const TEXTURE_CELLS: f32 = 35.0;

/// One of the two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// The surface in space.
    Surface,
    /// The charts on their sheet.
    Flat,
}

impl View {
    /// Both, in the order of their indices.
    pub const ALL: [Self; 2] = [Self::Surface, Self::Flat];
}

/// Everything that a picture depends on.
#[derive(Debug)]
pub struct Stage {
    scene: Scene,
    neighbours: Vec<[u32; 2]>,
    rooms: Vec<f32>,
    occlusion: Option<Occlusion>,
    usual_cell: f32,
    hierarchies: [Option<Hierarchy>; 2],
    orbit: Orbit,
    /// Whether nobody has moved the orbit since it was fitted: then it follows the size of the view.
    orbit_is_fitted: bool,
    sheet: Sheet,
    /// The same of the sheet, which then follows the layout as well.
    sheet_is_fitted: bool,
    viewports: [Viewport; 2],
    is_dark: bool,
    texture: Texture,
    cell: f32,
    /// The generated textures, made when they are first wanted.
    generated: [Option<Pixels>; 2],
    image: Option<Pixels>,
    layer_mode: LayerMode,
    wireframe: bool,
    hover: u32,
    /// Where the brush lies; empty where it does not.
    ring: Vec<Vec3>,
    stroke: Option<Stroke>,
    cone_marks: Marks,
    /// The cone that is on its way to another place.
    drag: Option<Drag>,
    looking: looking::Looking,
    pointing: pointing::Pointing,
    stamps: [u64; Part::COUNT],
    dirty: [bool; 2],
}

impl Default for Stage {
    fn default() -> Self {
        Self {
            scene: Scene::default(),
            neighbours: Vec::new(),
            rooms: Vec::new(),
            occlusion: None,
            usual_cell: 1.0,
            hierarchies: [None, None],
            orbit: Orbit::default(),
            orbit_is_fitted: true,
            sheet: Sheet::default(),
            sheet_is_fitted: true,
            viewports: [Viewport::default(); 2],
            is_dark: false,
            texture: Texture::None,
            cell: f32::NAN,
            generated: [None, None],
            image: None,
            layer_mode: LayerMode::default(),
            wireframe: false,
            hover: NONE,
            ring: Vec::new(),
            stroke: None,
            cone_marks: Marks::default(),
            drag: None,
            looking: looking::Looking::default(),
            pointing: pointing::Pointing::default(),
            stamps: [1; Part::COUNT],
            dirty: [true; 2],
        }
    }
}

impl Stage {
    /// Takes a newer scene, or refuses a broken one and stays as it is.
    ///
    /// Cameras return to their first places with the first scene of a mesh; later ones leave the orbit
    /// alone, and the sheet follows the layout until somebody moves it.
    pub fn set_scene(&mut self, scene: Scene) -> Result<(), SceneError> {
        arrays::check(&scene)?;
        let old = std::mem::replace(&mut self.scene, scene);
        let new = &self.scene;
        let places = old.positions != new.positions || old.normals != new.normals;
        let charts = !same_values(&old.charts, &new.charts);
        let triangles = old.triangles != new.triangles;
        let rims = old.rims != new.rims || old.rim_partners != new.rim_partners;
        let patches = old.vertex_patches != new.vertex_patches || !same_looks(&old, new);
        let field = old.field != new.field;
        let values = field || !same_values(&old.values, &new.values);
        let marks = old.mark_points != new.mark_points || old.mark_segments != new.mark_segments;
        let cones = old.cone_points != new.cone_points
            || old.cone_angles != new.cone_angles
            || old.cone_charts != new.cone_charts;
        let layers = old.layers != new.layers;
        let had_layers = old.layers.is_some() && old.field.is_none();
        // A viewer may miss the very first scene of a mesh: a count that falls tells as well.
        let is_first = new.revision == 0 || new.revision < old.revision;
        let is_new_mesh = is_first || self.occlusion.is_none();

        if rims || old.vertex_count() != new.vertex_count() {
            self.neighbours = arrays::rim_neighbours(new);
        }
        self.rooms = arrays::anchor_rooms(new);
        if is_new_mesh {
            self.occlusion = Some(Occlusion::new(new));
            self.usual_cell = arrays::area(new).sqrt().max(1e-3) / TEXTURE_CELLS;
        }
        self.stamp(is_new_mesh || places, &[Part::Geometry, Part::Wires]);
        self.stamp(is_new_mesh, &[Part::Shadow]);
        self.stamp(patches || values, &[Part::Paint]);
        self.stamp(charts, &[Part::Charts]);
        self.stamp(triangles, &[Part::Triangles, Part::Wires]);
        let isolates = (patches || rims || places) && self.looking.isolated != NONE;
        self.stamp(isolates, &[Part::Triangles, Part::Wires, Part::Ghost]);
        self.stamp(charts || triangles, &[Part::ChartTriangles, Part::FlippedTriangles]);
        self.stamp(charts || triangles, &[Part::ChartWires]);
        self.stamp(places || rims || patches, &[Part::Cuts, Part::Outline]);
        self.stamp(charts || rims || patches, &[Part::ChartRims, Part::ChartOutline]);
        self.stamp(marks, &[Part::MarkPoints, Part::MarkSegments]);
        self.stamp(field, &[Part::Ramp]);
        self.stamp(cones || rims || places || triangles, &[Part::Cones]);
        self.stamp(cones || charts, &[Part::ChartCones]);
        self.stamp(
            layers || is_new_mesh,
            &[
                Part::LayerVertices,
                Part::LayerTriangles,
                Part::LayerChartTriangles,
                Part::LayerRims,
            ],
        );
        if cones || is_new_mesh {
            self.drag = None;
        }
        if places || triangles {
            self.hierarchies[View::Surface as usize] = None;
        }
        if charts || triangles {
            self.hierarchies[View::Flat as usize] = None;
        }
        if is_first {
            self.orbit = Orbit::default();
            self.fit_orbit();
            self.sheet_is_fitted = true;
        }
        if places || charts || triangles || rims || is_first {
            self.point_at_scene(is_first, triangles, rims);
        }
        self.look_at_scene(is_first);
        if had_layers != (self.scene.layers.is_some() && self.scene.field.is_none())
            && self.layer_mode != LayerMode::Pieces
        {
            // Another sheet altogether.
            self.sheet_is_fitted = true;
        }
        if self.sheet_is_fitted {
            self.sheet.fit(self.bounds(), self.viewport(View::Flat));
        }
        self.dirty = [true; 2];
        Ok(())
    }

    /// The newest scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Whether the ground is dark.
    pub fn is_dark(&self) -> bool {
        self.is_dark
    }

    /// Light or dark.
    pub fn set_theme(&mut self, is_dark: bool) {
        self.is_dark = is_dark;
        self.dirty = [true; 2];
    }

    /// Whether edges are drawn.
    pub fn set_wireframe(&mut self, on: bool) {
        self.wireframe = on;
        self.dirty = [true; 2];
    }

    /// The patch to outline.
    pub fn set_hover(&mut self, patch: Option<u32>) {
        let patch = patch.unwrap_or(NONE);
        if patch != self.hover {
            self.hover = patch;
            self.stamp(true, &[Part::Outline, Part::ChartOutline]);
            self.dirty = [true; 2];
        }
    }

    /// For each patch the place of its number on the flattened view and the diameter of the room
    /// around it, in CSS pixels; NaN where the number does not fit or is out of sight.
    pub fn anchors(&self) -> Vec<f32> {
        let viewport = self.viewport(View::Flat);
        let layers = self.scene.layers.as_ref().filter(|_| self.shows_layers());
        let patches = layers.map_or(&self.scene.patches, |layers| &layers.charts);
        let rooms = match layers {
            // Charts that reach far beyond where they weigh anything have room.
            Some(layers) => vec![f32::MAX; layers.charts.len()],
            None => self.rooms.clone(),
        };
        let anchor = |(patch, &room): (usize, &f32)| {
            let place = Vec2::from_array(patches[patch].anchor);
            let css = self.sheet.to_screen(place, viewport);
            let room = room * self.sheet.pixels_per_unit();
            let is_inside = css.cmpge(Vec2::ZERO).all() && css.cmple(viewport.size).all();
            if room >= NUMBER_ROOM && is_inside {
                [css.x, css.y, 2.0 * room]
            } else {
                [f32::NAN; 3]
            }
        };
        rooms.iter().enumerate().flat_map(anchor).collect()
    }

    /// CSS pixels per unit of the charts.
    pub fn chart_pixels_per_unit(&self) -> f32 {
        self.sheet.pixels_per_unit()
    }

    /// Colours of the ground and of the outline.
    pub fn theme(&self) -> Theme {
        Theme::new(self.is_dark)
    }

    /// Whether colours come from a field.
    pub fn shows_field(&self) -> bool {
        self.scene.field.is_some() && !self.scene.values.is_empty()
    }

    /// Whether edges are drawn.
    pub fn shows_wireframe(&self) -> bool {
        self.wireframe
    }

    /// Height of the ground.
    pub fn ground(&self) -> f32 {
        self.occlusion.as_ref().map_or(-1.0, Occlusion::ground)
    }

    /// Whether a view differs from what was drawn last; afterwards it does not.
    pub fn take_dirty(&mut self, view: View) -> bool {
        std::mem::take(&mut self.dirty[view as usize])
    }

    /// Says that a view must be drawn again, since it could not be drawn or its canvas is new.
    pub fn set_dirty(&mut self, view: View) {
        self.dirty[view as usize] = true;
    }
}

/// Whether two fields agree, NaN with NaN.
fn same_values(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

/// Whether the patches of two scenes are painted alike, whatever else is said of them.
fn same_looks(a: &Scene, b: &Scene) -> bool {
    let look = |patch: &PatchScene| (patch.color, patch.has_chart);
    a.patches.iter().map(look).eq(b.patches.iter().map(look))
}

#[cfg(test)]
mod tests;
