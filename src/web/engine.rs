//! The engine for JavaScript: a [`Session`] behind plain objects. Runs in a worker; knows no page and no pictures.

use js_sys::{Array, Float32Array, Object, Reflect, Uint8Array, Uint32Array};
use serde::Serialize;
use wasm_bindgen::prelude::*;

use crate::session::scene::{LayerScene, PatchScene};
use crate::session::{Command, Event, Problem, Scene, Session};

#[wasm_bindgen]
extern "C" {
    /// The worker's clock, milliseconds.
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn now() -> f64;
}

/// One session of cutting.
#[wasm_bindgen]
pub struct Engine {
    session: Session,
}

#[wasm_bindgen]
impl Engine {
    /// An engine without a document.
    #[wasm_bindgen(constructor)]
    #[expect(clippy::new_without_default, reason = "JavaScript constructs it")]
    pub fn new() -> Self {
        console_error_panic_hook::set_once();
        Self { session: Session::new() }
    }

    /// Runs a tiny problem, so that the browser compiles the solvers while the page loads.
    pub fn warm_up(&self) {
        let mut session = Session::new();
        let soup = crate::session::samples::icosphere(4);
        let mut text = String::new();
        for [x, y, z] in &soup.positions {
            text += &format!("v {x} {y} {z}\n");
        }
        for i in 0..soup.polygon_count() {
            let corners: Vec<String> =
                soup.polygon(i).iter().map(|v| (v + 1).to_string()).collect();
            text += &format!("f {}\n", corners.join(" "));
        }
        session.open("warm-up.obj", text.as_bytes());
        session.handle(Command::Step);
        session.scene();
    }

    /// Handles a command; gives an array of events.
    pub fn handle(&mut self, command: JsValue) -> Result<JsValue, JsValue> {
        match serde_wasm_bindgen::from_value::<Command>(command) {
            Ok(command) => events(&self.session.handle(command)),
            Err(error) => Err(refusal(Problem::new(
                format!("The command was not understood: {error}."),
                "Between page and engine.",
                "Reload the page.",
            ))),
        }
    }

    /// Opens a file; gives an array of events.
    pub fn open(&mut self, name: &str, bytes: &[u8]) -> Result<JsValue, JsValue> {
        events(&self.session.open(name, bytes))
    }

    /// Steps the running flow for about that long; gives an array of events.
    pub fn advance(&mut self, milliseconds: f64) -> Result<JsValue, JsValue> {
        let start = now();
        let told = self.session.advance(&mut || now() < start + milliseconds);
        self.session.spend((now() - start) / 1000.0);
        events(&told)
    }

    /// Whether there is anything to advance.
    pub fn is_running(&self) -> bool {
        self.session.is_running()
    }

    /// The newest scene as an object of typed arrays, undefined if it was taken already.
    pub fn scene(&mut self) -> Result<JsValue, JsValue> {
        match self.session.scene() {
            Some(scene) => scene_object(&scene),
            None => Ok(JsValue::UNDEFINED),
        }
    }

    /// What making the last scene had to tell; gives an array of events.
    pub fn late(&mut self) -> Result<JsValue, JsValue> {
        events(&self.session.take_late())
    }

    /// The bytes of an export; throws `{ what, where, what_to_do }`.
    pub fn export_file(&mut self, kind: &str) -> Result<JsValue, JsValue> {
        let file = self.session.export(kind).map_err(refusal)?;
        let object = Object::new();
        set(&object, "name", &file.name.into())?;
        set(&object, "mime", &file.mime.into())?;
        set(&object, "bytes", &Uint8Array::from(file.bytes.as_slice()))?;
        Ok(object.into())
    }
}

fn set(object: &Object, key: &str, value: &JsValue) -> Result<(), JsValue> {
    Reflect::set(object, &key.into(), value).map(|_| ())
}

fn plain<T: Serialize + ?Sized>(value: &T) -> Result<JsValue, JsValue> {
    let serializer = serde_wasm_bindgen::Serializer::json_compatible();
    value.serialize(&serializer).map_err(JsValue::from)
}

fn events(events: &[Event]) -> Result<JsValue, JsValue> {
    plain(events)
}

fn refusal(problem: Problem) -> JsValue {
    let object = Object::new();
    let parts =
        [("what", problem.what), ("where", problem.place), ("what_to_do", problem.what_to_do)];
    for (key, text) in parts {
        // A fresh plain object takes any key.
        let _ = set(&object, key, &text.into());
    }
    object.into()
}

fn scene_object(scene: &Scene) -> Result<JsValue, JsValue> {
    let object = Object::new();
    for (key, values) in [
        ("positions", &scene.positions),
        ("normals", &scene.normals),
        ("charts", &scene.charts),
        ("values", &scene.values),
        ("mark_points", &scene.mark_points),
        ("mark_segments", &scene.mark_segments),
        ("cone_points", &scene.cone_points),
        ("cone_angles", &scene.cone_angles),
    ] {
        set(&object, key, &Float32Array::from(values.as_slice()))?;
    }
    for (key, values) in [
        ("vertex_patches", &scene.vertex_patches),
        ("triangles", &scene.triangles),
        ("triangle_faces", &scene.triangle_faces),
        ("rims", &scene.rims),
        ("rim_partners", &scene.rim_partners),
        ("cone_charts", &scene.cone_charts),
    ] {
        set(&object, key, &Uint32Array::from(values.as_slice()))?;
    }
    set(&object, "patches", &patch_objects(&scene.patches)?)?;
    set(&object, "layers", &scene.layers.as_ref().map_or(Ok(JsValue::NULL), layers_object)?)?;
    set(&object, "sheet", &numbers(&scene.sheet))?;
    set(&object, "is_folded", &scene.is_folded.into())?;
    set(&object, "revision", &scene.revision.into())?;
    let field = match &scene.field {
        None => JsValue::NULL,
        Some(field) => {
            let item = Object::new();
            set(&item, "id", &field.id.as_str().into())?;
            set(&item, "label", &field.label.as_str().into())?;
            set(&item, "unit", &field.unit.as_str().into())?;
            set(&item, "range", &numbers(&field.range))?;
            set(&item, "mean", &field.mean.into())?;
            set(&item, "extremes", &numbers(&field.extremes))?;
            set(&item, "signed", &field.signed.into())?;
            set(&item, "histogram", &numbers(&field.histogram))?;
            item.into()
        }
    };
    set(&object, "field", &field)?;
    Ok(object.into())
}

fn patch_objects(patches: &[PatchScene]) -> Result<JsValue, JsValue> {
    let items = Array::new();
    for patch in patches {
        let item = Object::new();
        set(&item, "color", &patch.color.into())?;
        set(&item, "area_fraction", &patch.area_fraction.into())?;
        set(&item, "anchor", &numbers(&patch.anchor))?;
        set(&item, "flipped", &patch.flipped.into())?;
        set(&item, "has_chart", &patch.has_chart.into())?;
        items.push(&item);
    }
    Ok(items.into())
}

fn layers_object(layers: &LayerScene) -> Result<JsValue, JsValue> {
    let object = Object::new();
    for (key, values) in [
        ("positions", &layers.positions),
        ("normals", &layers.normals),
        ("uvs", &layers.uvs),
        ("places", &layers.places),
        ("weights", &layers.weights),
    ] {
        set(&object, key, &Float32Array::from(values.as_slice()))?;
    }
    for (key, values) in [
        ("vertex_charts", &layers.vertex_charts),
        ("triangles", &layers.triangles),
        ("rims", &layers.rims),
    ] {
        set(&object, key, &Uint32Array::from(values.as_slice()))?;
    }
    set(&object, "charts", &patch_objects(&layers.charts)?)?;
    set(&object, "sheet", &numbers(&layers.sheet))?;
    Ok(object.into())
}

fn numbers(values: &[f32]) -> JsValue {
    values.iter().map(|&x| JsValue::from(x)).collect::<Array>().into()
}
