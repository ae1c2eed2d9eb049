//! The viewer for JavaScript: a thin skin over [`viewer`](crate::viewer).

#![expect(clippy::cast_possible_truncation, reason = "JavaScript has f64 alone; `as` saturates")]

use crate::session::scene::{FieldScene, LayerScene, PatchScene, Scene};
use crate::viewer::arrays::NONE;
use crate::viewer::camera::{Side, Viewport};
use crate::viewer::canvas::{Backend, Canvas};
use crate::viewer::cones::Marks;
use crate::viewer::layers::LayerMode;
use crate::viewer::pixels::Pixels;
use crate::viewer::stage::{Clip, ClipAxis, Pick, Stage, Texture, View};
use glam::{Vec2, Vec3};
use js_sys::{Array, Float32Array, Object, Reflect, Uint32Array};
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

/// Both pictures of the page. Places and movements are in CSS pixels; `view` is 0 for the surface
/// and 1 for the charts.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Viewer {
    stage: Stage,
    canvases: [Canvas; 2],
    backend: Backend,
}

#[wasm_bindgen]
impl Viewer {
    /// `webgpu` if a device can really be had, else `webgl2`, else throws.
    pub async fn probe() -> Result<String, JsError> {
        console_error_panic_hook::set_once();
        Ok(Backend::probe().await?.name().into())
    }

    /// Opens two canvases that nothing has touched before.
    pub async fn create(
        surface: HtmlCanvasElement,
        flat: HtmlCanvasElement,
        backend: String,
    ) -> Result<Viewer, JsError> {
        console_error_panic_hook::set_once();
        let backend = Backend::from_name(&backend)
            .ok_or_else(|| JsError::new(&format!("no backend is called {backend}")))?;
        let canvases = backend.open([surface, flat]).await?;
        Ok(Self { stage: Stage::default(), canvases, backend })
    }

    /// `webgpu` or `webgl2`.
    #[wasm_bindgen(getter)]
    pub fn backend(&self) -> String {
        self.backend.name().into()
    }

    /// Takes a newer scene; throws and keeps the old one if it is broken.
    pub fn set_scene(&mut self, scene: &JsValue) -> Result<(), JsError> {
        Ok(self.stage.set_scene(read_scene(scene)?)?)
    }

    /// Light or dark. Always draws again, which is what a picture for export needs.
    pub fn set_theme(&mut self, dark: bool) {
        self.stage.set_theme(dark);
    }

    /// `none`, `checkerboard`, `grid`, `circles`, `spots`, `marble` or `image` on every piece, and the side of a cell in the unit of the
    /// charts: 0 for one that suits the surface.
    pub fn set_texture(&mut self, name: &str, cell: f32) -> Result<(), JsError> {
        let texture = Texture::from_name(name)
            .ok_or_else(|| JsError::new(&format!("no texture is called {name}")))?;
        self.stage.set_texture(texture, cell);
        Ok(())
    }

    /// `[width, height]` that an image of so many pixels has to be scaled to before it is handed over; throws where it has none.
    pub fn image_size(width: u32, height: u32) -> Result<Vec<u32>, JsError> {
        Ok(Pixels::fit(width, height)?.to_vec())
    }

    /// Takes the image of the texture `image`: four bytes RGBA a pixel, row by row from the top. Throws, and keeps the old one,
    /// where it is none.
    pub fn set_image(&mut self, width: u32, height: u32, rgba: &[u8]) -> Result<(), JsError> {
        self.stage.set_image(Pixels::from_rgba(width, height, rgba)?);
        Ok(())
    }

    /// How overlapping charts are shown, where the scene has some: `pieces` (not at all), `blended` or `hard`.
    pub fn set_layers(&mut self, name: &str) -> Result<(), JsError> {
        let mode = LayerMode::from_name(name)
            .ok_or_else(|| JsError::new(&format!("layers cannot be shown {name}")))?;
        self.stage.set_layer_mode(mode);
        Ok(())
    }

    /// Side of a texture's cell that suits the surface, in the unit of the charts.
    pub fn usual_cell(&self) -> f32 {
        self.stage.usual_cell()
    }

    /// The edges of all triangles.
    pub fn set_wireframe(&mut self, on: bool) {
        self.stage.set_wireframe(on);
    }

    /// Outlines a patch in both views; -1 for none.
    pub fn set_hover(&mut self, patch: i32) {
        self.stage.set_hover(u32::try_from(patch).ok());
    }

    /// Size of a view.
    pub fn resize(&mut self, view: u32, css_width: f32, css_height: f32, pixel_ratio: f32) {
        let viewport = Viewport { size: Vec2::new(css_width, css_height), scale: pixel_ratio };
        self.stage.resize(at(view), viewport);
    }

    /// Has the next picture shaded whole: of a large mesh that is new some vertices are shaded with each picture.
    pub fn shade_whole(&mut self) {
        self.stage.shade_whole();
    }

    /// Draws what has changed; true if there was something.
    pub fn draw(&mut self) -> bool {
        let [surface, flat] = &mut self.canvases;
        // Both, whether or not the first one had something to draw.
        surface.draw(&mut self.stage) | flat.draw(&mut self.stage)
    }

    /// Turns the surface.
    pub fn rotate(&mut self, dx: f32, dy: f32) {
        self.stage.rotate(Vec2::new(dx, dy));
    }

    /// Moves a picture with the pointer.
    pub fn pan(&mut self, view: u32, dx: f32, dy: f32) {
        self.stage.pan(at(view), Vec2::new(dx, dy));
    }

    /// Magnifies a picture by `factor` about a place.
    pub fn zoom(&mut self, view: u32, factor: f32, x: f32, y: f32) {
        self.stage.zoom(at(view), factor, Vec2::new(x, y));
    }

    /// Frames everything.
    pub fn fit(&mut self, view: u32) {
        self.stage.fit(at(view));
    }

    /// `{patch, triangle, face, x, y, z}` under a place, or undefined. The place is on the
    /// surface in both views.
    pub fn pick(&mut self, view: u32, x: f32, y: f32) -> JsValue {
        self.stage.pick(at(view), Vec2::new(x, y)).map_or(JsValue::UNDEFINED, pick_object)
    }

    /// Points at a place: what lies there is marked in the other view, and a seam within `reach` pixels in both. Gives an object like
    /// that of `pick`, without its members where there is nothing, with `value` (NaN where there is no field), and `seam` beside it:
    /// `{a, b, length}`, two patches and a length in the unit of the scene.
    pub fn point(&mut self, view: u32, x: f32, y: f32, reach: f32) -> JsValue {
        let pointed = self.stage.point(at(view), Vec2::new(x, y), reach);
        let object = pointed.pick.map_or_else(|| Object::new().into(), pick_object);
        set(&object, "value", f64::from(pointed.value));
        if let Some(seam) = pointed.seam {
            let item = Object::new().into();
            set(&item, "a", f64::from(seam.patches[0]));
            set(&item, "b", f64::from(seam.patches[1]));
            set(&item, "length", f64::from(seam.length));
            let _ = Reflect::set(&object, &"seam".into(), &item);
        }
        object
    }

    /// Points at nothing.
    pub fn point_away(&mut self) {
        self.stage.point_away();
    }

    /// Pins the value of the field at a place. Gives the pin's number, -1 where there is nothing to pin.
    pub fn add_pin(&mut self, view: u32, x: f32, y: f32) -> i32 {
        let pin = self.stage.add_pin(at(view), Vec2::new(x, y));
        pin.and_then(|pin| i32::try_from(pin).ok()).unwrap_or(-1)
    }

    /// Takes a pin away.
    pub fn remove_pin(&mut self, pin: u32) {
        self.stage.remove_pin(pin);
    }

    /// `[pin, x, y, value, 1 where the surface hides the point]` of the pins within a view.
    pub fn pin_labels(&mut self, view: u32) -> Vec<f32> {
        let labels = self.stage.pin_labels(at(view)).into_iter().map(|label| {
            let is_hidden = f32::from(u8::from(label.is_hidden));
            [label.pin as f32, label.place.x, label.place.y, label.value, is_hidden]
        });
        labels.flatten().collect()
    }

    /// Sets an end of what is to be measured; a third one begins anew. Gives what lies there, as `pick` does.
    pub fn add_end(&mut self, view: u32, x: f32, y: f32) -> JsValue {
        self.stage.add_end(at(view), Vec2::new(x, y)).map_or(JsValue::UNDEFINED, pick_object)
    }

    /// How many ends of what is measured there are: a new scene may lose some.
    pub fn end_count(&self) -> u32 {
        self.stage.end_count() as u32
    }

    /// The way along the surface between both ends: x, y, z of each of its points.
    pub fn set_path(&mut self, points: &[f32]) {
        let points: &[[f32; 3]] = points.as_chunks().0;
        self.stage.set_path(points.iter().copied().map(Vec3::from_array).collect());
    }

    /// Measures nothing.
    pub fn clear_measure(&mut self) {
        self.stage.clear_measure();
    }

    /// Length of the straight line between both ends on one chart, in the unit of the scene; NaN where they lie on two.
    pub fn chart_length(&self) -> f32 {
        self.stage.chart_length()
    }

    /// `[x, y]` of the label of what is measured, empty where a view has none.
    pub fn measure_label(&self, view: u32) -> Vec<f32> {
        self.stage.measure_label(at(view)).map_or_else(Vec::new, |css| css.to_array().to_vec())
    }

    /// Parallel lines of sight on the surface.
    pub fn set_orthographic(&mut self, on: bool) {
        self.stage.set_orthographic(on);
    }

    /// Sends the camera to `front`, `back`, `left`, `right`, `top` or `bottom`; `fly` takes it there.
    pub fn fly_to_side(&mut self, name: &str) -> Result<(), JsError> {
        let side = Side::from_name(name)
            .ok_or_else(|| JsError::new(&format!("no side is called {name}")))?;
        self.stage.fly_to_side(side);
        Ok(())
    }

    /// Sends both cameras to a piece; false where there is no such piece.
    pub fn fly_to_patch(&mut self, patch: u32) -> bool {
        self.stage.fly_to_patch(patch)
    }

    /// Sends the camera of a view to where it frames everything.
    pub fn fly_home(&mut self, view: u32) {
        self.stage.fly_home(at(view));
    }

    /// Takes the cameras to a part of their way, 0 to 1; true while there is more of it.
    pub fn fly(&mut self, part: f32) -> bool {
        self.stage.fly(part)
    }

    /// Shows one piece alone on the surface; -1 for all.
    pub fn set_isolated(&mut self, patch: i32) {
        self.stage.set_isolated(u32::try_from(patch).ok());
    }

    /// The piece that is shown alone, -1 for none.
    pub fn isolated(&self) -> i32 {
        self.stage.isolated().and_then(|patch| i32::try_from(patch).ok()).unwrap_or(-1)
    }

    /// Cuts a part of the surface away by a plane straight to `x`, `y`, `z` or `view`; `none` for nothing. `kept` of the extent
    /// stays, 0 to 1; `is_turned` keeps the other side.
    pub fn set_clip(&mut self, axis: &str, kept: f32, is_turned: bool) {
        let clip = ClipAxis::from_name(axis).map(|axis| Clip { axis, kept, is_turned });
        self.stage.set_clip(clip);
    }

    /// Lays the ring of the brush around what is under a place of the surface view; true if there is something.
    /// A radius of 0 takes it away.
    pub fn set_brush(&mut self, x: f32, y: f32, radius: f32) -> bool {
        self.stage.set_brush(Vec2::new(x, y), radius)
    }

    /// Draws the brush on to a place of the surface view. Gives the dabs that this adds, in order, as
    /// objects like those of `pick`.
    pub fn stroke(&mut self, x: f32, y: f32, radius: f32, begins: bool) -> Array {
        self.stage.stroke(Vec2::new(x, y), radius, begins).into_iter().map(pick_object).collect()
    }

    /// Marks the cone under the pointer and the chosen one in both views; -1 for none.
    pub fn set_cone_marks(&mut self, hover: i32, selected: i32) {
        let [hover, selected] = [hover, selected].map(|cone| u32::try_from(cone).unwrap_or(NONE));
        self.stage.set_cone_marks(Marks { hover, selected });
    }

    /// The cone whose glyph is seen within `slop` pixels of a place, -1 for none.
    pub fn pick_cone(&mut self, view: u32, x: f32, y: f32, slop: f32) -> i32 {
        let cone = self.stage.pick_cone(at(view), Vec2::new(x, y), slop);
        cone.and_then(|cone| i32::try_from(cone).ok()).unwrap_or(-1)
    }

    /// Draws a cone at a place of a view until the next scene moves it or [`Viewer::drop_cone`] is called. Gives what
    /// lies there, as `pick` does, undefined where there is nothing; then the cone stays where it was drawn last.
    pub fn drag_cone(&mut self, cone: u32, view: u32, x: f32, y: f32) -> JsValue {
        let pick = self.stage.drag_cone(cone, at(view), Vec2::new(x, y));
        pick.map_or(JsValue::UNDEFINED, pick_object)
    }

    /// Draws all cones where the scene has them again.
    pub fn drop_cone(&mut self) {
        self.stage.drop_cone();
    }

    /// `[cone, x, y, radius]` of glyphs that are seen and may have a label, the most important first: marked ones, then,
    /// on the surface, the largest.
    pub fn cone_labels(&mut self, view: u32) -> Vec<f32> {
        self.stage.cone_labels(at(view)).concat()
    }

    /// `[x, y, z]` of the eye in the frame of the scene, whose surface fits the unit ball.
    pub fn eye(&self) -> Vec<f32> {
        self.stage.eye().to_array().to_vec()
    }

    /// Six numbers of where the camera of the surface stands, to come back to with `set_pose`.
    pub fn pose(&self) -> Vec<f32> {
        self.stage.pose().to_vec()
    }

    /// Puts the camera of the surface there; what are no six numbers changes nothing.
    pub fn set_pose(&mut self, pose: &[f32]) {
        if let Ok(pose) = pose.try_into() {
            self.stage.set_pose(pose);
        }
    }

    /// `[x, y, size]` for each patch: where its number stands on the flattened view and the
    /// diameter of the room for it; NaN where it is hidden.
    pub fn anchors(&self) -> Vec<f32> {
        self.stage.anchors()
    }

    /// CSS pixels per unit of the charts, for the ruler.
    pub fn chart_pixels_per_unit(&self) -> f32 {
        self.stage.chart_pixels_per_unit()
    }

    /// Whether a device or a context is gone: then new canvases and a new viewer are needed.
    pub fn is_lost(&self) -> bool {
        self.canvases.iter().any(Canvas::is_lost)
    }
}

fn pick_object(pick: Pick) -> JsValue {
    let object = Object::new();
    for (name, value) in [
        ("patch", f64::from(pick.patch)),
        ("triangle", f64::from(pick.triangle)),
        ("face", f64::from(pick.face)),
        ("x", f64::from(pick.place.x)),
        ("y", f64::from(pick.place.y)),
        ("z", f64::from(pick.place.z)),
    ] {
        // Cannot fail on an object made just now.
        let _ = Reflect::set(&object, &name.into(), &value.into());
    }
    object.into()
}

fn set(object: &JsValue, name: &str, value: f64) {
    // Cannot fail on an object made just now.
    let _ = Reflect::set(object, &name.into(), &value.into());
}

fn at(view: u32) -> View {
    if view == 0 { View::Surface } else { View::Flat }
}

/// Reads the object that the worker posts: the fields of [`Scene`] as typed arrays.
///
/// Shapes are checked here, lengths and indices by the stage.
fn read_scene(object: &JsValue) -> Result<Scene, JsError> {
    let floats = |name: &str| floats_of(object, name);
    let integers = |name: &str| integers_of(object, name);
    let field = get(object, "field")?;
    let layers = get(object, "layers")?;
    let is_none = |value: &JsValue| value.is_null() || value.is_undefined();
    Ok(Scene {
        positions: floats("positions")?,
        normals: floats("normals")?,
        charts: floats("charts")?,
        values: floats("values")?,
        vertex_patches: integers("vertex_patches")?,
        triangles: integers("triangles")?,
        triangle_faces: integers("triangle_faces")?,
        rims: integers("rims")?,
        rim_partners: integers("rim_partners")?,
        patches: read_patches(object, "patches")?,
        sheet: numbers(object, "sheet")?,
        field: if is_none(&field) { None } else { Some(read_field(&field)?) },
        mark_points: floats("mark_points")?,
        mark_segments: floats("mark_segments")?,
        cone_points: floats("cone_points")?,
        cone_angles: floats("cone_angles")?,
        cone_charts: integers("cone_charts")?,
        is_folded: get(object, "is_folded")?.is_truthy(),
        revision: number(object, "revision")? as u32,
        layers: if is_none(&layers) { None } else { Some(read_layers(&layers)?) },
    })
}

fn read_layers(object: &JsValue) -> Result<LayerScene, JsError> {
    Ok(LayerScene {
        positions: floats_of(object, "positions")?,
        normals: floats_of(object, "normals")?,
        uvs: floats_of(object, "uvs")?,
        places: floats_of(object, "places")?,
        weights: floats_of(object, "weights")?,
        vertex_charts: integers_of(object, "vertex_charts")?,
        triangles: integers_of(object, "triangles")?,
        rims: integers_of(object, "rims")?,
        charts: read_patches(object, "charts")?,
        sheet: numbers(object, "sheet")?,
    })
}

fn floats_of(object: &JsValue, name: &str) -> Result<Vec<f32>, JsError> {
    match get(object, name)?.dyn_ref::<Float32Array>() {
        Some(array) => Ok(array.to_vec()),
        None => Err(wrong(name, "a Float32Array")),
    }
}

fn integers_of(object: &JsValue, name: &str) -> Result<Vec<u32>, JsError> {
    match get(object, name)?.dyn_ref::<Uint32Array>() {
        Some(array) => Ok(array.to_vec()),
        None => Err(wrong(name, "a Uint32Array")),
    }
}

fn read_patches(object: &JsValue, name: &str) -> Result<Vec<PatchScene>, JsError> {
    let patches = get(object, name)?;
    let patches = patches.dyn_ref::<Array>().ok_or_else(|| wrong(name, "an array"))?;
    patches.iter().map(|patch| read_patch(&patch)).collect()
}

fn read_patch(object: &JsValue) -> Result<PatchScene, JsError> {
    Ok(PatchScene {
        color: number(object, "color")? as u8,
        area_fraction: number(object, "area_fraction")? as f32,
        anchor: numbers(object, "anchor")?,
        flipped: number(object, "flipped")? as u32,
        has_chart: get(object, "has_chart")?.is_truthy(),
    })
}

fn read_field(object: &JsValue) -> Result<FieldScene, JsError> {
    let text = |name| get(object, name).map(|value| value.as_string().unwrap_or_default());
    Ok(FieldScene {
        id: text("id")?,
        label: text("label")?,
        unit: text("unit")?,
        range: numbers(object, "range")?,
        mean: number(object, "mean")? as f32,
        extremes: numbers(object, "extremes")?,
        signed: get(object, "signed")?.is_truthy(),
        // The page draws the legend; the viewer has no use for the histogram.
        histogram: Vec::new(),
    })
}

fn get(object: &JsValue, name: &str) -> Result<JsValue, JsError> {
    Reflect::get(object, &name.into()).map_err(|_| wrong("the scene", "an object"))
}

/// A number; null is NaN, because JSON has no other way to say it.
fn number(object: &JsValue, name: &str) -> Result<f64, JsError> {
    let value = get(object, name)?;
    if value.is_null() {
        return Ok(f64::NAN);
    }
    value.as_f64().ok_or_else(|| wrong(name, "a number"))
}

fn numbers<const N: usize>(object: &JsValue, name: &str) -> Result<[f32; N], JsError> {
    let list = get(object, name)?;
    let mut numbers = [f32::NAN; N];
    for (i, slot) in (0..).zip(&mut numbers) {
        let item = Reflect::get_u32(&list, i).map_err(|_| wrong(name, "a list of numbers"))?;
        if !item.is_null() {
            *slot = item.as_f64().ok_or_else(|| wrong(name, "a list of numbers"))? as f32;
        }
    }
    Ok(numbers)
}

fn wrong(name: &str, expected: &str) -> JsError {
    JsError::new(&format!("scene: `{name}` is not {expected}"))
}
