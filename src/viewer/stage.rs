//! What is to be drawn: the newest scene, two cameras, the switches. No graphics device.
//!
//! Each thing that a graphics device holds a copy of is a [`Part`] with a stamp. A setter only moves
//! stamps; bytes are made when a view is drawn, so that a scene which is overtaken by a newer one
//! before the next frame costs next to nothing.

mod looking;
mod pointing;

pub use looking::{Clip, ClipAxis};
pub use pointing::{MOST_PINS, PinLabel, Pointed, Seam};

use super::arrays::{self, NONE, RimChoice, SceneError};
use super::brush::{self, Stroke};
use super::camera::{Orbit, Projection, Ray, Sheet, Viewport};
use super::color::{self, Theme};
use super::cones::{self, Drag, Glyph, Marks};
use super::layers::{self, LayerMode};
use super::occlusion::{self, Occlusion};
use super::pick::{Hierarchy, Hit};
use super::pixels::Pixels;
use crate::session::scene::{PatchScene, Scene};
use glam::{Vec2, Vec3};

/// Smallest disc, as a radius in CSS pixels, that a chart's number fits into.
const NUMBER_ROOM: f32 = 9.0;
/// Cells of the texture along the side of a square of the surface's area: about ten across one of a dozen
/// pieces. Twice as many are noise at the size of a laptop's window, half as many show too little of a
/// chart's change of scale.
const TEXTURE_CELLS: f32 = 35.0;
/// Cones of the surface view that may have a label: more would hide the surface.
const CONE_LABELS: usize = 48;
/// Pixels of the colour map.
pub const RAMP_PIXELS: usize = 256;

/// One of the two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// The surface in space.
    Surface,
    /// The charts on their sheet.
    Flat,
}

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

impl View {
    /// Both, in the order of their indices.
    pub const ALL: [Self; 2] = [Self::Surface, Self::Flat];
}

/// Something that a graphics device holds a copy of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Places, normals and openness of all vertices.
    Geometry,
    /// Colours and values of all vertices.
    Paint,
    /// Places of all vertices on the sheet.
    Charts,
    /// Triangles of the surface.
    Triangles,
    /// Triangles of the charts that stand as they should.
    ChartTriangles,
    /// Triangles of the charts that are turned over.
    FlippedTriangles,
    /// Cuts and boundary on the surface.
    Cuts,
    /// Rims of the charts.
    ChartRims,
    /// Cuts of what is hidden beside the one piece that is shown.
    Ghost,
    /// Rim of the patch under the pointer, on the surface.
    Outline,
    /// The same on the sheet.
    ChartOutline,
    /// Edges on the surface.
    Wires,
    /// Edges of the charts.
    ChartWires,
    /// Points that an error points at.
    MarkPoints,
    /// Lines that an error points at.
    MarkSegments,
    /// The colour map.
    Ramp,
    /// The ring of the brush.
    Brush,
    /// On the surface, the place under the pointer that is over the sheet.
    Marker,
    /// The other way round.
    ChartMarker,
    /// The seam beside the pointer, on the surface.
    Seam,
    /// Both its sides on the sheet.
    ChartSeam,
    /// The bow between them.
    SeamThread,
    /// A measured way along the surface.
    Path,
    /// The straight line between its ends on the sheet.
    ChartPath,
    /// The ends on the surface.
    PathEnds,
    /// The ends on the sheet.
    ChartPathEnds,
    /// Cones on the surface.
    Cones,
    /// Cones on the sheet.
    ChartCones,
    /// The shadow on the ground.
    Shadow,
    /// Vertices of overlapping charts.
    LayerVertices,
    /// Their triangles.
    LayerTriangles,
    /// Those of them that have a place on the sheet.
    LayerChartTriangles,
    /// Their rims on the sheet.
    LayerRims,
    /// The pixels of the texture.
    Pixels,
}

impl Part {
    /// Number of parts.
    pub const COUNT: usize = Self::Pixels as usize + 1;
}

/// What lies under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Its patch.
    pub patch: u32,
    /// Its scene triangle.
    pub triangle: u32,
    /// The input face that the triangle is a part of.
    pub face: u32,
    /// The place on the surface, also when picked on a chart.
    pub place: Vec3,
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

    fn stamp(&mut self, has_changed: bool, parts: &[Part]) {
        for &part in parts.iter().filter(|_| has_changed) {
            self.stamps[part as usize] += 1;
        }
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
    fn bounds(&self) -> [f32; 4] {
        let layers = self.scene.layers.as_ref().filter(|_| self.shows_layers());
        layers.map_or(self.scene.sheet, |layers| layers.sheet)
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

    /// Size of a view. What nobody has moved is fitted again.
    pub fn resize(&mut self, view: View, viewport: Viewport) {
        let was_empty = self.viewport(view).is_empty();
        if viewport == self.viewport(view) {
            return;
        }
        self.viewports[view as usize] = viewport;
        self.dirty[view as usize] = true;
        self.stamp(true, &[Part::Cones, Part::ChartCones]);
        if viewport.is_empty() {
            return;
        }
        match view {
            View::Surface if was_empty || self.orbit_is_fitted => self.fit_orbit(),
            View::Flat if was_empty || self.sheet_is_fitted => {
                self.sheet.fit(self.bounds(), viewport);
            }
            _ => {}
        }
    }

    /// Size of a view.
    pub fn viewport(&self, view: View) -> Viewport {
        self.viewports[view as usize]
    }

    /// Turns the surface by a movement in CSS pixels.
    pub fn rotate(&mut self, movement: Vec2) {
        if let Some(viewport) = self.usable(View::Surface, movement) {
            self.orbit.rotate(movement, viewport);
        }
    }

    /// Moves a picture with the pointer.
    pub fn pan(&mut self, view: View, movement: Vec2) {
        let Some(viewport) = self.usable(view, movement) else { return };
        match view {
            View::Surface => {
                self.orbit.pan(movement, viewport);
                self.orbit_is_fitted = false;
            }
            View::Flat => {
                self.sheet.pan(movement);
                self.sheet_is_fitted = false;
            }
        }
    }

    /// Magnifies a picture by `factor` about a place of the screen.
    pub fn zoom(&mut self, view: View, factor: f32, css: Vec2) {
        let Some(viewport) = self.usable(view, css) else { return };
        if !(factor.is_finite() && factor > 0.0) {
            return;
        }
        match view {
            View::Surface => {
                let pivot = match self.pick(view, css) {
                    Some(pick) => pick.place,
                    None => self.orbit.beside_target(css, viewport),
                };
                self.orbit.zoom(factor, pivot);
                self.orbit_is_fitted = false;
            }
            View::Flat => {
                self.sheet.zoom(factor, css, viewport);
                self.sheet_is_fitted = false;
            }
        }
    }

    /// Frames everything; the surface keeps its direction.
    pub fn fit(&mut self, view: View) {
        let Some(viewport) = self.usable(view, Vec2::ZERO) else { return };
        match view {
            View::Surface => self.fit_orbit(),
            View::Flat => {
                self.sheet.fit(self.bounds(), viewport);
                self.sheet_is_fitted = true;
            }
        }
    }

    /// Where the camera of the surface stands, see [`Orbit::pose`].
    pub fn pose(&self) -> [f32; 6] {
        let mut framed = self.orbit;
        if !self.orbit_is_fitted {
            framed.fit(self.points(), self.viewport(View::Surface));
        }
        self.orbit.pose(&framed)
    }

    /// Puts the camera of the surface somewhere.
    pub fn set_pose(&mut self, pose: [f32; 6]) {
        if self.usable(View::Surface, Vec2::ZERO).is_none() || !pose.iter().all(|x| x.is_finite()) {
            return;
        }
        // What frames everything is another distance for each pitch.
        self.orbit.set_pose(pose);
        self.fit_orbit();
        self.orbit.set_pose(pose);
        self.orbit_is_fitted = pose[2..] == [1.0, 0.0, 0.0, 0.0];
    }

    fn points(&self) -> impl Iterator<Item = Vec3> + Clone {
        self.scene.positions.as_chunks().0.iter().copied().map(Vec3::from_array)
    }

    fn fit_orbit(&mut self) {
        let viewport = self.viewport(View::Surface);
        if !viewport.is_empty() {
            let mut orbit = self.orbit;
            self.frame_shown(&mut orbit);
            self.orbit = orbit;
            self.orbit_is_fitted = true;
        }
    }

    /// The viewport of a view that is about to move, marked dirty; none for an empty view or a
    /// movement that is no number.
    fn usable(&mut self, view: View, movement: Vec2) -> Option<Viewport> {
        let viewport = self.viewport(view);
        if viewport.is_empty() || !movement.is_finite() {
            return None;
        }
        self.dirty[view as usize] = true;
        self.looking.end_flight(view);
        // What hides a cone depends on where one looks from.
        self.stamp(view == View::Surface, &[Part::Cones]);
        Some(viewport)
    }

    /// What lies under a place of the screen.
    pub fn pick(&mut self, view: View, css: Vec2) -> Option<Pick> {
        let hit = self.hit(view, css)?;
        Some(self.pick_of(hit))
    }

    fn pick_of(&self, hit: Hit) -> Pick {
        let scene = &self.scene;
        let corners = arrays::triangles(scene)[hit.triangle as usize];
        Pick {
            patch: scene.vertex_patches[corners[0] as usize],
            triangle: hit.triangle,
            face: scene.triangle_faces[hit.triangle as usize],
            place: self.on_surface(hit),
        }
    }

    /// The triangle under a place of the screen.
    fn hit(&mut self, view: View, css: Vec2) -> Option<Hit> {
        let viewport = self.viewport(view);
        // Overlapping charts are no pieces: there is nothing to point at.
        let has_pieces = view == View::Surface || !self.shows_layers();
        if viewport.is_empty() || !css.is_finite() || !has_pieces {
            return None;
        }
        let ray = match view {
            View::Surface => self.orbit.ray(css, viewport),
            View::Flat => {
                let origin = self.sheet.to_sheet(css, viewport).extend(1.0);
                Ray { origin, direction: Vec3::NEG_Z }
            }
        };
        self.cast(view, ray)
    }

    /// What a ray meets in a view.
    fn cast(&mut self, view: View, ray: Ray) -> Option<Hit> {
        let scene = &self.scene;
        let triangles = arrays::triangles(scene);
        let place: &dyn Fn(u32) -> Vec3 = match view {
            View::Surface => &|vertex| arrays::position(scene, vertex),
            View::Flat => &|vertex| arrays::chart(scene, vertex),
        };
        self.hierarchies[view as usize].get_or_insert_with(|| Hierarchy::new(triangles, place));
        let hierarchy = self.hierarchies[view as usize].as_ref()?;
        hierarchy.cast_where(ray, triangles, place, |hit| {
            // Through what is cut away or hidden one sees what is behind it.
            let met = ray.origin + ray.direction * hit.distance;
            view == View::Flat || (self.keeps(met) && self.shows_patch_of(hit))
        })
    }

    /// The place on the surface of a hit in either view.
    fn on_surface(&self, hit: Hit) -> Vec3 {
        let corners = arrays::triangles(&self.scene)[hit.triangle as usize];
        let point = |(vertex, weight)| arrays::position(&self.scene, vertex) * weight;
        corners.into_iter().zip(hit.weights).map(point).sum()
    }

    /// Where the eye stands, in the frame of the scene.
    pub fn eye(&self) -> Vec3 {
        self.projection(View::Surface).eye
    }

    /// Lays the brush on what is under a place of the screen; a radius that is not above 0 takes it away.
    ///
    /// **Gives** whether it lies anywhere.
    pub fn set_brush(&mut self, css: Vec2, radius: f32) -> bool {
        let pick = if radius > 0.0 { self.pick(View::Surface, css) } else { None };
        let ring = match pick {
            Some(pick) => {
                let corners = arrays::triangles(&self.scene)[pick.triangle as usize];
                let normal = corners.map(|v| arrays::normal(&self.scene, v)).into_iter().sum();
                brush::ring(pick.place, normal, radius, |ray| {
                    let hit = self.cast(View::Surface, ray)?;
                    Some((hit.distance, self.on_surface(hit)))
                })
            }
            None => Vec::new(),
        };
        if ring != self.ring {
            self.ring = ring;
            self.stamp(true, &[Part::Brush]);
            self.dirty[View::Surface as usize] = true;
        }
        !self.ring.is_empty()
    }

    /// Draws the brush to a place of the screen, or puts it down there where a stroke `begins`.
    ///
    /// **Gives** the dabs that this adds, in order; see [`brush`].
    pub fn stroke(&mut self, css: Vec2, radius: f32, begins: bool) -> Vec<Pick> {
        if !css.is_finite() {
            return Vec::new();
        }
        let mut stroke = self.stroke.take().filter(|_| !begins).unwrap_or(Stroke::new(css));
        let place = self.pick(View::Surface, css).map_or(Vec3::ZERO, |pick| pick.place);
        let scale = self.viewport(View::Surface).scale;
        let pixels = brush::pixels(radius, place, &self.projection(View::Surface), scale);
        let dabs = stroke.extend(css, radius, pixels, |css| {
            self.pick(View::Surface, css).map(|pick| (pick.place, pick))
        });
        self.stroke = Some(stroke);
        dabs
    }

    /// Marks cones in both views.
    pub fn set_cone_marks(&mut self, marks: Marks) {
        if marks != self.cone_marks {
            self.cone_marks = marks;
            self.redraw_cones();
        }
    }

    fn redraw_cones(&mut self) {
        self.stamp(true, &[Part::Cones, Part::ChartCones]);
        self.dirty = [true; 2];
    }

    fn glyphs(&self, view: View) -> Vec<Glyph> {
        match view {
            View::Surface => {
                let mut glyphs = cones::on_surface(&self.scene, self.drag);
                if let Some(patch) = self.isolated() {
                    let is_there = |&&[vertex, _]: &&[u32; 2]| {
                        self.scene.vertex_patches[vertex as usize] == patch
                    };
                    let places: &[[u32; 2]] = self.scene.cone_charts.as_chunks().0;
                    let there: Vec<u32> =
                        places.iter().filter(is_there).map(|&[_, cone]| cone).collect();
                    glyphs.retain(|glyph| there.contains(&glyph.cone));
                }
                glyphs
            }
            View::Flat => cones::on_charts(&self.scene, self.drag),
        }
    }

    /// The glyphs of the surface view without those that the surface hides, as far as it is worth to look at each.
    fn glyphs_in_sight(&mut self) -> Vec<Glyph> {
        let mut glyphs = self.glyphs(View::Surface);
        glyphs.sort_by(|a, b| {
            let size = |glyph: &Glyph| cones::angle(&self.scene, glyph.cone).abs();
            size(b).total_cmp(&size(a))
        });
        let far = glyphs.split_off(glyphs.len().min(cones::LOOKED_AT));
        glyphs.retain_mut(|glyph| {
            glyph.is_seen = self.glyph_on_screen(View::Surface, glyph).is_some();
            glyph.is_seen
        });
        glyphs.extend(far);
        glyphs
    }

    /// Where a glyph is seen, and the radius of its disc, in CSS pixels; none where the surface hides it.
    fn glyph_on_screen(&mut self, view: View, glyph: &Glyph) -> Option<(Vec2, f32)> {
        let (projection, viewport) = (self.projection(view), self.viewport(view));
        let angle = cones::angle(&self.scene, glyph.cone);
        let css = cones::to_screen(glyph.place, &projection, viewport)?;
        if view == View::Surface {
            let direction = glyph.place - projection.eye;
            let is_behind =
                |hit: Hit| hit.distance < 1.0 - cones::dent(angle, &projection, viewport);
            let ray = Ray { origin: projection.eye, direction };
            let is_turned = !cones::faces(glyph, projection.eye);
            if is_turned || !self.keeps(glyph.place) || self.cast(view, ray).is_some_and(is_behind)
            {
                return None;
            }
        }
        Some((css, cones::radius(angle, viewport)))
    }

    /// The cone whose glyph is seen within `slop` CSS pixels of a place of the screen, the nearest of several.
    pub fn pick_cone(&mut self, view: View, css: Vec2, slop: f32) -> Option<u32> {
        let (projection, viewport) = (self.projection(view), self.viewport(view));
        if viewport.is_empty() || !css.is_finite() {
            return None;
        }
        let mut near: Vec<(f32, Glyph)> = self
            .glyphs(view)
            .into_iter()
            .filter_map(|glyph| {
                let distance = cones::to_screen(glyph.place, &projection, viewport)?.distance(css);
                let reach = cones::radius(cones::angle(&self.scene, glyph.cone), viewport) + slop;
                (distance <= reach).then_some((distance, glyph))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.into_iter()
            .map(|(_, glyph)| glyph)
            .find(|glyph| self.glyph_on_screen(view, glyph).is_some())
            .map(|glyph| glyph.cone)
    }

    /// Draws a cone at a place of the screen, until a scene has other cones or it is dropped.
    ///
    /// **Gives** what lies there; where there is nothing, the cone stays where it was drawn last.
    pub fn drag_cone(&mut self, cone: u32, view: View, css: Vec2) -> Option<Pick> {
        let hit = self.hit(view, css)?;
        let pick = self.pick_of(hit);
        let corners = arrays::triangles(&self.scene)[pick.triangle as usize];
        let weighted = |place: &dyn Fn(u32) -> Vec3| -> Vec3 {
            corners.into_iter().zip(hit.weights).map(|(v, weight)| place(v) * weight).sum()
        };
        let normal = weighted(&|vertex| arrays::normal(&self.scene, vertex));
        let chart = weighted(&|vertex| arrays::chart(&self.scene, vertex)).truncate();
        self.drag = Some(Drag { cone, place: pick.place, normal, chart });
        self.redraw_cones();
        Some(pick)
    }

    /// Draws all cones where the scene has them again.
    pub fn drop_cone(&mut self) {
        if self.drag.take().is_some() {
            self.redraw_cones();
        }
    }

    /// `[cone, x, y, radius]` in CSS pixels of the glyphs that are seen and may have a label, the most important first:
    /// marked ones, then, on the surface, the largest.
    pub fn cone_labels(&mut self, view: View) -> Vec<[f32; 4]> {
        let viewport = self.viewport(view);
        let marks = self.cone_marks;
        let is_marked = |glyph: &Glyph| [marks.hover, marks.selected].contains(&glyph.cone);
        let mut glyphs = self.glyphs(view);
        glyphs.sort_by(|a, b| {
            let size = |glyph: &Glyph| cones::angle(&self.scene, glyph.cone).abs();
            is_marked(b).cmp(&is_marked(a)).then(size(b).total_cmp(&size(a)))
        });
        let most = if view == View::Surface { CONE_LABELS } else { 0 };
        let mut labels = Vec::new();
        for (i, glyph) in glyphs.iter().enumerate() {
            if i >= most && !is_marked(glyph) {
                break;
            }
            if let Some((css, radius)) = self.glyph_on_screen(view, glyph)
                && css.cmpge(Vec2::ZERO).all()
                && css.cmple(viewport.size).all()
            {
                labels.push([glyph.cone as f32, css.x, css.y, radius]);
            }
        }
        labels
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

    /// The camera of a view.
    pub fn projection(&self, view: View) -> Projection {
        match view {
            View::Surface => self.orbit.projection(self.viewport(view)),
            View::Flat => self.sheet.projection(self.viewport(view)),
        }
    }

    /// Colours of the ground and of the outline.
    pub fn theme(&self) -> Theme {
        Theme::new(self.is_dark)
    }

    /// Whether colours come from a field.
    pub fn shows_field(&self) -> bool {
        self.scene.field.is_some() && !self.scene.values.is_empty()
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

    /// Changes whenever [`Stage::bytes`] of the part does.
    pub fn stamp_of(&self, part: Part) -> u64 {
        self.stamps[part as usize]
    }

    /// The bytes that a graphics device is to hold of a part.
    pub fn bytes(&mut self, part: Part) -> Vec<u8> {
        let scene = &self.scene;
        let rims =
            |choice, on_charts| arrays::rim_ribbons(scene, &self.neighbours, choice, on_charts);
        // A seam beside the pointer is shown in place of the whole outline.
        let hovered = RimChoice::Patch(if self.pointing.has_seam() { NONE } else { self.hover });
        let isolated = self.isolated();
        match part {
            Part::Geometry => match &mut self.occlusion {
                Some(occlusion) => arrays::geometry(scene, occlusion),
                None => Vec::new(),
            },
            Part::Paint => arrays::paint(scene),
            Part::Charts => arrays::charts(scene),
            Part::Triangles => self.shown_triangles(),
            Part::ChartTriangles => arrays::indices(&arrays::chart_triangles(scene)[0]),
            Part::FlippedTriangles => arrays::indices(&arrays::chart_triangles(scene)[1]),
            Part::Cuts => rims(isolated.map_or(RimChoice::Cuts, RimChoice::Patch), false),
            Part::Ghost if isolated.is_some() => rims(RimChoice::Cuts, false),
            Part::Ghost => Vec::new(),
            Part::ChartRims => rims(RimChoice::All, true),
            Part::Outline => rims(hovered, false),
            Part::ChartOutline => rims(hovered, true),
            Part::Wires => arrays::wire_ribbons(scene, false, isolated),
            Part::ChartWires => arrays::wire_ribbons(scene, true, None),
            Part::MarkPoints => arrays::mark_point_ribbons(scene),
            Part::MarkSegments => arrays::mark_segment_ribbons(scene),
            Part::Brush => arrays::ring_ribbons(&self.ring),
            Part::Marker
            | Part::ChartMarker
            | Part::Seam
            | Part::ChartSeam
            | Part::SeamThread
            | Part::Path
            | Part::ChartPath
            | Part::PathEnds
            | Part::ChartPathEnds => self.pointed_bytes(part),
            Part::Cones => {
                let glyphs = self.glyphs_in_sight();
                cones::bytes(&self.scene, glyphs, self.cone_marks, self.viewport(View::Surface))
            }
            Part::ChartCones => cones::bytes(
                scene,
                self.glyphs(View::Flat),
                self.cone_marks,
                self.viewport(View::Flat),
            ),
            Part::Ramp => match &scene.field {
                Some(field) if arrays::is_labels(field) => color::label_ramp(RAMP_PIXELS),
                field => color::ramp(field.as_ref().is_some_and(|f| f.signed), RAMP_PIXELS),
            },
            Part::Shadow => match &self.occlusion {
                Some(occlusion) => occlusion.ground_shadow(),
                None => vec![0; occlusion::SHADOW_PIXELS.pow(2)],
            },
            Part::LayerVertices => match &mut self.occlusion {
                Some(occlusion) => layers::vertices(scene, occlusion),
                None => Vec::new(),
            },
            Part::LayerTriangles => layers::triangles(scene, false),
            Part::LayerChartTriangles => layers::triangles(scene, true),
            Part::LayerRims => layers::rim_ribbons(scene),
            Part::Pixels => {
                let levels = self.pixels().map(|pixels| pixels.levels.iter());
                levels.into_iter().flatten().flat_map(|(_, _, bytes)| bytes).copied().collect()
            }
        }
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
mod tests {
    use super::super::fixtures::{overlapping_squares, two_squares, unit_ball};
    use super::*;
    use crate::session::scene::FieldScene;

    pub(super) fn stage(scene: Scene) -> Stage {
        let mut stage = Stage::default();
        for view in View::ALL {
            stage.resize(view, Viewport { size: Vec2::new(500.0, 300.0), scale: 1.0 });
        }
        stage.set_scene(scene).expect("a good scene");
        stage
    }

    fn changed(stage: &mut Stage, scene: Scene) -> Vec<usize> {
        let before = stage.stamps;
        stage.set_scene(scene).expect("a good scene");
        (0..Part::COUNT).filter(|&part| before[part] != stage.stamps[part]).collect()
    }

    #[test]
    fn only_what_changed_is_made_again() {
        let mut stage = stage(two_squares());
        let mut scene = Scene { revision: 1, ..two_squares() };
        // NaN is no change.
        scene.charts[0] = f32::NAN;
        scene.patches[0].anchor = [f32::NAN; 2];
        stage.set_scene(scene.clone()).expect("a good scene");
        assert_eq!(changed(&mut stage, scene.clone()), [0; 0]);

        scene.values = vec![0.5; 8];
        scene.field = Some(FieldScene::default());
        assert_eq!(
            changed(&mut stage, scene.clone()),
            [Part::Paint, Part::Ramp].map(|part| part as usize)
        );
        assert!(stage.shows_field());

        scene.positions[2] = 0.125;
        // What hides a cone lies elsewhere as well.
        let moved = [Part::Geometry, Part::Cuts, Part::Outline, Part::Wires, Part::Cones]
            .map(|part| part as usize);
        assert_eq!(changed(&mut stage, scene.clone()), moved);

        stage.set_hover(Some(1));
        stage.set_hover(Some(1));
        assert_eq!(changed(&mut stage, scene), [0; 0]);
    }

    #[test]
    fn the_camera_returns_with_the_first_scene_of_a_mesh_and_with_no_other() {
        let mut stage = stage(two_squares());
        let first = stage.orbit;
        stage.rotate(Vec2::new(30.0, 10.0));
        stage.pan(View::Flat, Vec2::new(5.0, 0.0));
        let (turned, moved) = (stage.orbit, stage.sheet);
        stage.set_scene(Scene { revision: 7, ..two_squares() }).expect("a good scene");
        assert_eq!((stage.orbit, stage.sheet), (turned, moved));
        stage.set_scene(Scene { revision: 2, ..two_squares() }).expect("a good scene");
        assert_eq!(stage.orbit, first);
        assert_ne!(stage.sheet, moved);
    }

    #[test]
    fn the_sheet_follows_the_layout_until_it_is_moved() {
        let mut stage = stage(two_squares());
        let scene =
            |width, revision| Scene { sheet: [0.0, 0.0, width, 1.0], revision, ..two_squares() };
        stage.set_scene(scene(9.0, 1)).expect("a good scene");
        let fitted = stage.chart_pixels_per_unit();
        assert!((fitted - 492.0 / 9.0).abs() < 1e-3);
        stage.zoom(View::Flat, 2.0, Vec2::new(1.0, 1.0));
        stage.set_scene(scene(2.0, 2)).expect("a good scene");
        assert!((stage.chart_pixels_per_unit() - 2.0 * fitted).abs() < 1e-3);
        stage.fit(View::Flat);
        assert!((stage.chart_pixels_per_unit() - 492.0 / 2.0).abs() < 1e-3);
    }

    #[test]
    fn pointing_at_the_middle_of_a_ball_meets_its_near_side() {
        let mut stage = stage(unit_ball(3, 0));
        let pick = stage.pick(View::Surface, Vec2::new(250.0, 150.0)).expect("the ball");
        assert!((pick.place.length() - 1.0).abs() < 0.02);
        let eye = stage.projection(View::Surface).eye;
        assert!(pick.place.normalize().dot(eye.normalize()) > 0.999);
        assert_eq!(pick.face, pick.triangle);
        assert_eq!(stage.pick(View::Surface, Vec2::new(3.0, 3.0)), None);
        // It has no charts.
        assert_eq!(stage.pick(View::Flat, Vec2::new(250.0, 150.0)), None);
    }

    #[test]
    fn the_brush_lies_where_it_points_and_is_drawn_anew_only_when_it_moves() {
        let mut stage = stage(unit_ball(3, 0));
        let middle = Vec2::new(250.0, 150.0);
        assert!(stage.set_brush(middle, 0.2));
        assert_eq!(stage.bytes(Part::Brush).len(), stage.ring.len() * 60);
        let towards_eye = stage.eye().normalize();
        for point in &stage.ring {
            // A facet of the ball lies up to a fiftieth inside it.
            assert!((point.length() - 1.0).abs() < 0.03);
            assert!((point.reject_from(towards_eye).length() - 0.2).abs() < 0.02);
        }
        let stamp = stage.stamp_of(Part::Brush);
        stage.take_dirty(View::Surface);
        stage.set_brush(middle, 0.2);
        assert_eq!((stage.stamp_of(Part::Brush), stage.take_dirty(View::Surface)), (stamp, false));
        assert!(!stage.set_brush(Vec2::new(3.0, 3.0), 0.2));
        assert!(stage.take_dirty(View::Surface) && stage.bytes(Part::Brush).is_empty());
    }

    #[test]
    fn a_stroke_across_the_ball_stays_on_it() {
        let mut stage = stage(unit_ball(3, 0));
        let mut dabs = stage.stroke(Vec2::new(250.0, 150.0), 0.1, true);
        assert_eq!(dabs.len(), 1);
        dabs.extend(stage.stroke(Vec2::new(300.0, 150.0), 0.1, false));
        assert!(dabs.len() > 3);
        for pair in dabs.windows(2) {
            assert!(pair[0].place.distance(pair[1].place) < 0.1, "a gap");
        }
        assert!(dabs.iter().all(|dab| (dab.place.length() - 1.0).abs() < 0.03));
        assert_eq!(stage.stroke(Vec2::new(3.0, 3.0), 0.1, true), []);
        assert_eq!(stage.stroke(Vec2::NAN, 0.1, false), []);
    }

    /// The ball with a cone at each pole: one looks at the eye from above the middle, one is behind.
    fn ball_with_cones() -> Scene {
        let ball = unit_ball(3, 0);
        let at = |place: Vec3| {
            let points: &[[f32; 3]] = ball.positions.as_chunks().0;
            (0..)
                .zip(points)
                .find(|(_, p)| Vec3::from_array(**p).distance(place) < 1e-5)
                .expect("a pole")
                .0
        };
        Scene {
            cone_points: vec![0.0, 0.0, 1.0, 0.0, 0.0, -1.0],
            cone_angles: vec![1.0, -2.0],
            cone_charts: vec![at(Vec3::Z), 0, at(Vec3::NEG_Z), 1],
            ..ball
        }
    }

    #[test]
    fn a_cone_is_picked_where_it_is_seen_and_not_through_the_surface() {
        let mut stage = stage(ball_with_cones());
        let (projection, viewport) =
            (stage.projection(View::Surface), stage.viewport(View::Surface));
        let near = cones::to_screen(Vec3::Z, &projection, viewport).expect("in front");
        let far = cones::to_screen(Vec3::NEG_Z, &projection, viewport).expect("in front");
        assert_eq!(stage.pick_cone(View::Surface, near + Vec2::new(3.0, 0.0), 2.0), Some(0));
        assert_eq!(stage.pick_cone(View::Surface, near + Vec2::new(30.0, 0.0), 2.0), None);
        assert_eq!(stage.pick_cone(View::Surface, far, 2.0), None);
        assert_eq!(stage.pick_cone(View::Surface, Vec2::NAN, 2.0), None);
        // It has no charts.
        assert_eq!(stage.pick_cone(View::Flat, near, 500.0), None);
        let labels = stage.cone_labels(View::Surface);
        assert_eq!(labels.len(), 1, "the cone behind has no label: {labels:?}");
        assert_eq!(stage.bytes(Part::Cones).len(), 28, "and no glyph");
        assert!(labels[0][0] < 0.5 && Vec2::new(labels[0][1], labels[0][2]).distance(near) < 1e-3);
    }

    #[test]
    fn a_cone_behind_comes_into_sight_as_the_surface_turns() {
        let mut stage = stage(ball_with_cones());
        let front = stage.bytes(Part::Cones);
        let stamp = stage.stamp_of(Part::Cones);
        // Half a turn for the shorter side of the view.
        stage.rotate(Vec2::new(300.0, 0.0));
        assert_ne!(stage.stamp_of(Part::Cones), stamp);
        let back = stage.bytes(Part::Cones);
        assert!(back.len() == 28 && back != front, "the other cone alone");
        assert!(stage.cone_labels(View::Surface)[0][0] > 0.5, "its label is that of cone 1");
    }

    #[test]
    fn a_dragged_cone_follows_and_returns_when_it_is_dropped() {
        let mut stage = stage(ball_with_cones());
        let still = stage.bytes(Part::Cones);
        let pick = stage.drag_cone(0, View::Surface, Vec2::new(250.0, 150.0)).expect("the ball");
        assert_eq!(stage.glyphs(View::Surface)[0].place, pick.place);
        assert_eq!(stage.drag_cone(0, View::Surface, Vec2::new(3.0, 3.0)), None);
        assert_ne!(
            stage.bytes(Part::Cones),
            still,
            "beside the surface it stays where it was last"
        );
        // A scene that says nothing new of the cones leaves the hand alone.
        stage.set_scene(Scene { revision: 1, ..ball_with_cones() }).expect("a good scene");
        assert_ne!(stage.bytes(Part::Cones), still);
        stage.drop_cone();
        assert_eq!(stage.bytes(Part::Cones), still);
        stage.drag_cone(0, View::Surface, Vec2::new(250.0, 150.0));
        let mut moved = Scene { revision: 2, ..ball_with_cones() };
        moved.cone_points[0] = 0.25;
        stage.set_scene(moved).expect("a good scene");
        assert!((stage.glyphs(View::Surface)[0].place.x - 0.25).abs() < 1e-6);
    }

    #[test]
    fn marks_on_cones_are_drawn_once_and_come_first_among_labels() {
        let mut stage = stage(ball_with_cones());
        let stamp = stage.stamp_of(Part::ChartCones);
        let marks = Marks { selected: 0, ..Marks::default() };
        stage.set_cone_marks(marks);
        stage.set_cone_marks(marks);
        assert_eq!(stage.stamp_of(Part::ChartCones), stamp + 1);
        assert!(!stage.cone_labels(View::Surface).is_empty());
    }

    #[test]
    fn pointing_at_a_chart_gives_the_place_on_the_surface() {
        let mut stage = stage(two_squares());
        let css = stage.sheet.to_screen(Vec2::new(1.75, 0.25), stage.viewport(View::Flat));
        let pick = stage.pick(View::Flat, css).expect("the second square");
        assert_eq!((pick.patch, pick.triangle, pick.face), (1, 2, 1));
        assert!(pick.place.distance(Vec3::new(0.5, 0.25, 0.0)) < 1e-4);
    }

    #[test]
    fn numbers_stand_on_their_charts_and_hide_where_they_do_not_fit() {
        let mut stage = stage(two_squares());
        let anchors = stage.anchors();
        let scale = stage.chart_pixels_per_unit();
        let expected = stage.sheet.to_screen(Vec2::splat(0.5), stage.viewport(View::Flat));
        assert!(Vec2::new(anchors[0], anchors[1]).distance(expected) < 1e-3);
        assert!((anchors[2] - scale).abs() < 1e-2);
        stage.zoom(View::Flat, 0.08, Vec2::new(250.0, 150.0));
        assert!(stage.anchors().iter().all(|x| x.is_nan()));
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the same number comes back")]
    fn cells_have_the_size_that_is_asked_for_and_else_one_that_suits_the_surface() {
        let mut stage = stage(two_squares());
        let usual = 2.0_f32.sqrt() / TEXTURE_CELLS;
        assert!((stage.usual_cell() - usual).abs() < 1e-6);
        for senseless in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e-9] {
            stage.set_texture(Texture::Grid, senseless);
            assert_eq!(stage.cell(), stage.usual_cell(), "{senseless}");
        }
        stage.set_texture(Texture::Circles, 0.125);
        assert_eq!((stage.texture(), stage.cell()), (Texture::Circles, 0.125));
        assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [true, true]);
        stage.set_texture(Texture::Circles, 0.125);
        assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [false, false]);
        assert_eq!(Texture::from_name("houndstooth"), None);
    }

    #[test]
    fn overlapping_charts_take_the_place_of_pieces_until_a_field_is_shown_or_pieces_are_wanted() {
        let mut stage = stage(two_squares());
        let pieces = stage.chart_pixels_per_unit();
        assert!(!stage.shows_layers());
        let scene = Scene { revision: 1, ..overlapping_squares() };
        let parts = changed(&mut stage, scene.clone());
        let layers =
            [Part::LayerVertices, Part::LayerTriangles, Part::LayerChartTriangles, Part::LayerRims];
        assert_eq!(parts, layers.map(|part| part as usize));
        assert_eq!(changed(&mut stage, scene.clone()), [0; 0]);
        // Another sheet is shown, and its charts are no pieces to point at.
        assert!(stage.shows_layers() && stage.chart_pixels_per_unit() < pieces);
        assert_eq!(stage.pick(View::Flat, Vec2::new(250.0, 150.0)), None);
        assert_eq!(stage.anchors().len(), 6);
        stage.set_layer_mode(LayerMode::Hard);
        assert!(stage.shows_layers());
        stage.set_layer_mode(LayerMode::Pieces);
        assert!(!stage.shows_layers());
        assert!((stage.chart_pixels_per_unit() - pieces).abs() < 1e-3);
        stage.set_layer_mode(LayerMode::Blended);
        let field = Some(FieldScene::default());
        stage.set_scene(Scene { values: vec![0.5; 8], field, ..scene }).expect("a good scene");
        assert!(!stage.shows_layers());
        assert!((stage.chart_pixels_per_unit() - pieces).abs() < 1e-3);
    }

    #[test]
    fn pixels_are_made_when_they_are_wanted_and_an_image_waits_for_its_own() {
        let mut stage = stage(two_squares());
        assert_eq!(stage.pixels(), None);
        stage.set_texture(Texture::Image, 0.1);
        assert_eq!((stage.texture(), stage.pixels()), (Texture::None, None));
        let image = Pixels::from_rgba(2, 1, &[9; 8]).expect("an image");
        let stamp = stage.stamp_of(Part::Pixels);
        stage.set_image(image.clone());
        assert_eq!((stage.texture(), stage.pixels()), (Texture::Image, Some(&image)));
        assert!(stage.stamp_of(Part::Pixels) > stamp);
        assert_eq!(stage.bytes(Part::Pixels).len(), 12);
        stage.set_texture(Texture::Spots, 0.1);
        assert_ne!(stage.pixels(), Some(&image));
        assert_eq!(stage.texture(), Texture::Spots);
        let stamp = stage.stamp_of(Part::Pixels);
        stage.set_texture(Texture::Spots, 0.2);
        assert_eq!(stage.stamp_of(Part::Pixels), stamp);
    }

    #[test]
    fn a_view_is_dirty_once_and_only_where_something_moved() {
        let mut stage = stage(two_squares());
        assert!(View::ALL.map(|view| stage.take_dirty(view)).iter().all(|&dirty| dirty));
        stage.rotate(Vec2::new(1.0, 0.0));
        assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [true, false]);
        stage.rotate(Vec2::new(f32::NAN, 0.0));
        assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [false, false]);
    }

    #[test]
    fn a_broken_scene_leaves_the_stage_as_it_was() {
        let mut stage = stage(two_squares());
        let broken = Scene { triangles: vec![0, 1, 77], ..two_squares() };
        assert!(stage.set_scene(broken).is_err());
        assert_eq!(*stage.scene(), two_squares());
    }
}
