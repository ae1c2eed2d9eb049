//! The brush: regions, seeds, penalties, heat and pins that a person paints on the surface.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "labels are checked to be whole and small; `as` saturates"
)]

use std::rc::Rc;

use nalgebra::{Point3, Vector3};

use super::inputs::Layers;
use super::message::{Event, PaintChannel, Value};
use super::method::Method;
use super::surface::Surface;
use super::text::Problem;
use super::work::{Pending, energy_event};
use super::{Session, nothing_open, presets};
use crate::geometry::visibility;
use crate::mesh::{FaceId, VertexId};

/// Largest label that can be painted.
const MOST_LABELS: f64 = 255.0;

/// Identifier, label, kind and help of what can be painted for cut flows.
const CHANNELS: [[&str; 4]; 5] = [
    [
        "region",
        "Regions",
        "label",
        "Regions that the cut starts between. The first stroke goes on from the cut that is there.",
    ],
    [
        "seed",
        "Seeds",
        "place",
        "Every click sets a seed; the cut starts between the cells around them.",
    ],
    ["penalty", "Hide", "amount", "Cuts avoid what is painted: faces, logos, what is in sight."],
    ["heat", "Heat", "amount", "Where more heat has to be led away: the cut gets denser there."],
    ["pin", "Pin", "amount", "The cut stays where it is."],
];

/// The same for cones.
const CONE_CHANNELS: [[&str; 4]; 5] = [
    [
        "importance",
        "Importance",
        "amount",
        "Distortion counts more where it is painted: cones move so that these places stay true.",
    ],
    [
        "unimportant",
        "Unimportant",
        "amount",
        "Distortion counts less, in the end not at all: ends that are cut off, backs, undersides.",
    ],
    [
        "cone_cost",
        "Dear cones",
        "amount",
        "Cones cost more where it is painted: they go elsewhere if they can.",
    ],
    ["excluded", "No cones", "amount", "There are no cones where it is painted."],
    [
        "penalty",
        "Hide seams",
        "amount",
        "Seams avoid what is painted: faces, logos, what is in sight.",
    ],
];

/// The same for phase fields.
const PHASE_CHANNELS: [[&str; 4]; 1] = [[
    "region",
    "Regions",
    "label",
    "What the first division starts from: the first region on one side, all others on the other.",
]];

/// The same for developable patches.
const DEVELOP_CHANNELS: [[&str; 4]; 3] = [
    [
        "penalty",
        "Hide seams",
        "amount",
        "Seams avoid what is painted: faces, logos, what is in sight.",
    ],
    [
        "seam_paint",
        "Keep seams",
        "amount",
        "Seams that run through what is painted stay: pieces are not merged across them.",
    ],
    [
        "drawn_seam",
        "Draw seams",
        "amount",
        "A seam is cut along the middle of each stroke, and stays. Draw on to the next seam, or all the way around.",
    ],
];

/// What can be painted.
fn channels(method: Method) -> &'static [[&'static str; 4]] {
    match method {
        Method::CutFlow => &CHANNELS,
        Method::Cones => &CONE_CHANNELS,
        Method::PhaseField => &PHASE_CHANNELS,
        Method::Developable => &DEVELOP_CHANNELS,
    }
}

impl Session {
    pub(super) fn paint_channels(&self) -> Event {
        let layers = self.work.as_ref().map(|work| work.layers.clone()).unwrap_or_default();
        let option = |[id, label, kind, help]: [&'static str; 4]| PaintChannel {
            id: id.into(),
            label: label.into(),
            help: help.into(),
            kind,
            is_empty: match id {
                "region" => layers.regions.is_empty(),
                "seed" => layers.seeds.is_empty(),
                "penalty" => layers.penalty.is_empty(),
                "heat" => layers.heat.is_empty(),
                "importance" => layers.importance.is_empty(),
                "unimportant" => layers.unimportant.is_empty(),
                "cone_cost" => layers.cone_cost.is_empty(),
                "excluded" => layers.excluded.is_empty(),
                "seam_paint" => layers.seams.is_empty(),
                "drawn_seam" => layers.drawn.is_empty(),
                _ => layers.pin.is_empty(),
            },
        };
        let options = channels(self.method()).iter().copied().map(option).collect();
        Event::PaintChannels { options }
    }

    #[expect(clippy::too_many_arguments, reason = "the parts of one command")]
    pub(super) fn paint(
        &mut self,
        channel: &str,
        face: u32,
        place: [f64; 3],
        radius: f64,
        value: f64,
        begins: bool,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let label = known(channel, self.method())?;
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let surface = work.document.surface()?;
        let dab = Dab::new(surface, face, place, radius)?;
        let most = if channel == "region" { MOST_LABELS } else { 1.0 };
        let is_whole = channel != "region" || value.fract().abs() <= 0.0;
        if !(value >= 0.0 && value <= most && is_whole) {
            return Err(Problem::new(
                format!("{value} cannot be painted."),
                format!("Brush, {label}."),
                match channel {
                    "region" => format!("Choose a whole number from 0 to {most}."),
                    _ => format!("Choose a value from 0 to {most}."),
                },
            ));
        }
        let mut layers = work.layers.clone();
        let count = surface.mesh.vertex_count();
        let pending = match channel {
            "region" => {
                let start = work.settings.text(start_parameter(work.method));
                if layers.regions.is_empty() || start != "painted" {
                    layers.regions = Rc::new(work.labels());
                }
                let regions = Rc::make_mut(&mut layers.regions);
                for (v, _) in dab.vertices(surface) {
                    regions[v.index()] = value as u32;
                }
                Pending::Stroke
            }
            "seed" => {
                let seeds = Rc::make_mut(&mut layers.seeds);
                if value > 0.0 {
                    let nearest = dab.nearest(surface);
                    if !seeds.contains(&nearest) {
                        seeds.push(nearest);
                    }
                } else {
                    let at =
                        |v: &VertexId| (surface.geometry.positions[v.index()] - dab.place).norm();
                    let closest =
                        (0..seeds.len()).min_by(|&a, &b| at(&seeds[a]).total_cmp(&at(&seeds[b])));
                    if let Some(i) = closest {
                        seeds.remove(i);
                    }
                }
                // Without seeds the cut that is there stays.
                if seeds.is_empty() { Pending::None } else { Pending::Restart }
            }
            _ => {
                let layer = layers.amounts(channel);
                let amounts = Rc::make_mut(layer);
                amounts.resize(count, 0.0);
                for (v, weight) in dab.vertices(surface) {
                    let x = &mut amounts[v.index()];
                    *x = if value > 0.0 { x.max(value * weight) } else { x.min(1.0 - weight) };
                }
                if amounts.iter().all(|x| *x <= 0.0) {
                    layer_clear(layer);
                }
                Pending::Fields
            }
        };
        // A stroke that goes on after Undo is another one.
        if begins || self.undo.last().is_none_or(|last| last.kind != "paint") {
            self.remember(&format!("paint {}", label.to_lowercase()), "paint");
        }
        if self.is_folded() {
            self.unfold(events)?;
        }
        let channel = if channel == "seed" && pending == Pending::None { "" } else { channel };
        self.put_layers(channel, layers, pending, events);
        Ok(())
    }

    pub(super) fn clear_paint(
        &mut self,
        channel: &str,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let label = known(channel, self.method())?;
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let mut layers = work.layers.clone();
        let pending = match channel {
            "region" => {
                layers.regions = Rc::default();
                Pending::None
            }
            "seed" => {
                layers.seeds = Rc::default();
                Pending::None
            }
            _ => {
                layer_clear(layers.amounts(channel));
                Pending::Fields
            }
        };
        self.remember(&format!("clear {}", label.to_lowercase()), "clear");
        self.put_layers("", layers, pending, events);
        Ok(())
    }

    pub(super) fn place_circle(
        &mut self,
        face: u32,
        place: [f64; 3],
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let surface = work.document.surface()?;
        let nearest = Dab::new(surface, face, place, 1.0)?.nearest(surface);
        let mut settings = work.settings.clone();
        settings.set("init", Value::Text("circle".into()))?;
        let vertex = f64::from(surface.soup_vertices[nearest.index()]);
        settings.set("vertex", Value::Number(vertex))?;
        self.apply("vertex", settings, super::Effect::Restart, events)
    }

    pub(super) fn hide_from_camera(
        &mut self,
        eye: [f64; 3],
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let surface = work.document.surface()?;
        if !eye.iter().all(|x| x.is_finite()) {
            return Err(Problem::new(
                "The camera is nowhere.",
                "Hide seams from here.",
                "Fit the surface into its view and try again.",
            ));
        }
        let eye = Point3::from(Vector3::from(eye) * surface.radius());
        let mut layers = work.layers.clone();
        let seen = visibility(&surface.mesh, &surface.geometry, eye);
        if work.method == Method::Cones {
            layers.cone_cost = Rc::new(with_paint(&layers.cone_cost, seen.clone()));
        }
        layers.penalty = Rc::new(with_paint(&layers.penalty, seen));
        let label = match work.method {
            Method::Cones => "hide cones and seams from the camera",
            _ => "hide seams from the camera",
        };
        self.remember(label, "hide");
        self.put_layers("penalty", layers, Pending::Fields, events);
        Ok(())
    }

    /// Puts painted layers in force, and the parameters that they need.
    fn put_layers(
        &mut self,
        channel: &str,
        layers: Layers,
        pending: Pending,
        events: &mut Vec<Event>,
    ) {
        let Some(work) = &mut self.work else { return };
        if work.layers.pin != layers.pin {
            // Straightening leaves pinned places where they are.
            work.finish_anew();
        }
        work.layers = layers;
        work.pending = work.pending.max(pending);
        let has_start = match work.settings.text("init") {
            "painted" => !work.layers.regions.is_empty(),
            "seeds" => !work.layers.seeds.is_empty(),
            _ => true,
        };
        if !has_start && work.pending > Pending::Fields && pending <= Pending::Fields {
            work.pending = Pending::Fields;
        }
        let before = work.settings.clone();
        let init = work.settings.text("init");
        let is_phase_painted = work.settings.text("phase_start") == "painted";
        let wanted = match channel {
            "region" => Some((start_parameter(work.method), "painted")),
            "seed" if !work.layers.seeds.is_empty() => Some(("init", "seeds")),
            // Nothing to start from is left; the cut that is there stays.
            _ if init == "seeds" && work.layers.seeds.is_empty() => Some(("init", "normals")),
            _ if init == "painted" && work.layers.regions.is_empty() => Some(("init", "normals")),
            _ if is_phase_painted && work.layers.regions.is_empty() => {
                Some(("phase_start", "axes"))
            }
            "heat" => Some(("source", "heat")),
            _ => None,
        };
        if let Some((id, text)) = wanted {
            work.settings.put(id, Value::Text(text.into()));
        }
        if channel == "penalty" && work.settings.number("eta") <= 0.0 {
            work.settings.put("eta", Value::Number(6.0));
        }
        if work.settings != before {
            events.push(self.parameters());
            events.push(self.presets());
        }
        self.scene_is_new = true;
        events.push(self.paint_channels());
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
    }

    /// Brings the flow up to what was painted.
    pub(super) fn catch_up(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        if self.method() == Method::Cones {
            return self.cones_catch_up();
        }
        if self.is_segmenting() {
            return self.segment_follow(events);
        }
        let Some(work) = &mut self.work else { return Ok(()) };
        match std::mem::take(&mut work.pending) {
            Pending::None => {}
            Pending::Stroke | Pending::Restart => {
                let flow = work.new_flow(None)?;
                work.begin(flow);
            }
            Pending::Fields => work.tell_flow()?,
        }
        self.scene_is_new = true;
        // A restart has one row, other changes concern the last one.
        let last = self.work.as_ref().and_then(|work| work.history.last());
        events.extend(last.map(energy_event));
        events.extend(self.work.as_ref().map(super::work::Work::measures));
        events.push(self.fold_event());
        Ok(())
    }

    pub(super) fn presets(&self) -> Event {
        match self.method() {
            Method::CutFlow => presets::event(self.work.as_ref().map(|work| &work.settings)),
            _ => Event::Presets { options: Vec::new(), current: None },
        }
    }

    pub(super) fn apply_preset(
        &mut self,
        id: &str,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let label = presets::label(id)?;
        let mut settings = work.settings.with_preset(id)?;
        if settings.text("init") == "circle"
            && let Some(surface) = &work.document.surface
        {
            let vertex = f64::from(surface.soup_vertices[facing(surface).index()]);
            settings.put("vertex", Value::Number(vertex));
        }
        self.apply(&format!("preset {label}"), settings, super::Effect::Restart, events)
    }
}

/// The vertex in the middle of what is seen of a surface at first: three quarters from the front, a little from above.
fn facing(surface: &Surface) -> VertexId {
    let towards = Vector3::new(0.505, 0.257, 0.824);
    let score = |v: VertexId| {
        let place = surface.geometry.positions[v.index()].coords;
        let depth = place.dot(&towards);
        // Ten times as far from the axis of sight as nearer to the eye is too far.
        depth - 10.0 * (place - towards * depth).norm()
    };
    let vertices = surface.mesh.vertices().filter(|&v| surface.mesh.halfedge(v).is_some());
    vertices.max_by(|&a, &b| score(a).total_cmp(&score(b))).unwrap_or(VertexId(0))
}

impl Layers {
    /// The layer of an amount.
    pub(super) fn amounts(&mut self, channel: &str) -> &mut Rc<Vec<f64>> {
        match channel {
            "penalty" => &mut self.penalty,
            "heat" => &mut self.heat,
            "importance" => &mut self.importance,
            "unimportant" => &mut self.unimportant,
            "cone_cost" => &mut self.cone_cost,
            "excluded" => &mut self.excluded,
            "seam_paint" => &mut self.seams,
            "drawn_seam" => &mut self.drawn,
            _ => &mut self.pin,
        }
    }
}

/// The parameter that says what a method starts from.
pub(super) fn start_parameter(method: Method) -> &'static str {
    if method == Method::PhaseField { "phase_start" } else { "init" }
}

/// What is seen, and what was painted already: the larger of both.
pub(super) fn with_paint(painted: &[f64], mut seen: Vec<f64>) -> Vec<f64> {
    seen.iter_mut().zip(painted).for_each(|(seen, painted)| *seen = seen.max(*painted));
    seen
}

fn layer_clear(layer: &mut Rc<Vec<f64>>) {
    *layer = Rc::default();
}

/// The label of a channel. **Fails** if there is none of that name.
fn known(channel: &str, method: Method) -> Result<&'static str, Problem> {
    let channels = channels(method);
    channels.iter().find(|c| c[0] == channel).map(|c| c[1]).ok_or_else(|| {
        Problem::new(
            format!("“{channel}” cannot be painted."),
            "Brush.",
            format!(
                "Choose one of {}.",
                channels.iter().map(|c| c[0]).collect::<Vec<_>>().join(", ")
            ),
        )
    })
}

/// A place on the surface and what is near it.
pub(super) struct Dab {
    face: FaceId,
    place: Point3<f64>,
    radius: f64,
}

impl Dab {
    /// **Takes** a place and a radius in the frame of the scene.
    pub(super) fn new(
        surface: &Surface,
        face: u32,
        place: [f64; 3],
        radius: f64,
    ) -> Result<Self, Problem> {
        let scale = surface.radius();
        let is_there = (face as usize) < surface.mesh.face_count()
            && place.iter().all(|x| x.is_finite())
            && radius > 0.0
            && radius.is_finite();
        if !is_there {
            return Err(Problem::new(
                "There is no such place on the surface.",
                format!("{}, face {face}.", surface.name),
                "Point at the surface.",
            ));
        }
        let place = Point3::from(Vector3::from(place) * scale);
        Ok(Self { face: FaceId(face), place, radius: radius * scale })
    }

    /// The corner of the face next to the place.
    pub(super) fn nearest(&self, surface: &Surface) -> VertexId {
        let distance = |v: &VertexId| (surface.geometry.positions[v.index()] - self.place).norm();
        let [a, b, c] = surface.mesh.face_vertices(self.face);
        [b, c].into_iter().fold(a, |x, y| if distance(&y) < distance(&x) { y } else { x })
    }

    /// The vertices that the brush reaches along the surface, with its strength there: 1 in the middle, 0 at the rim. Where it is
    /// smaller than a face, the nearest vertex.
    fn vertices(&self, surface: &Surface) -> Vec<(VertexId, f64)> {
        let weight = |v: VertexId| {
            let d = (surface.geometry.positions[v.index()] - self.place).norm() / self.radius;
            // Flat within half the radius: a dab covers.
            (1.0 - ((d - 0.5) / 0.5).max(0.0).powi(2)).max(0.0)
        };
        let mut seen = vec![false; surface.mesh.vertex_count()];
        let mut queue: Vec<VertexId> = surface.mesh.face_vertices(self.face).into();
        let mut reached = Vec::new();
        queue.iter().for_each(|v| seen[v.index()] = true);
        while let Some(v) = queue.pop() {
            let w = weight(v);
            if w <= 0.0 {
                continue;
            }
            reached.push((v, w));
            for h in surface.mesh.outgoing(v) {
                let next = surface.mesh.tip(h);
                if !std::mem::replace(&mut seen[next.index()], true) {
                    queue.push(next);
                }
            }
        }
        if reached.is_empty() {
            reached.push((self.nearest(surface), 1.0));
        }
        reached
    }
}
