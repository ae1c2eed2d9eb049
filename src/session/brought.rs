//! What a driver brings along for a surface: layers from files, seeds by number, a cut, a place to hide from.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers are checked to be whole and in range; `as` saturates"
)]

use std::rc::Rc;

use nalgebra::Point3;

use super::cut_file::labels_from_json;
use super::message::{Event, Value};
use super::method::Method;
use super::paint::with_paint;
use super::project::Gift;
use super::surface::Surface;
use super::text::Problem;
use super::work::{Pending, start_flow};
use super::{Entry, Session, nothing_open};
use crate::geometry::visibility;
use crate::mesh::VertexId;
use crate::methods::cutflow::CutFlow;

/// Something to bring, by the numbers and units of the file.
#[derive(Clone, Copy, Debug)]
pub enum Brought<'a> {
    /// One number for each vertex of the file.
    Layer {
        /// What it is: `region penalty heat pin importance unimportant cone_cost excluded seam_paint drawn_seam`.
        channel: &'a str,
        /// Labels, or amounts from 0 to 1.
        values: &'a [f64],
    },
    /// Vertices that cells are drawn around.
    Seeds(&'a [f64]),
    /// The bytes of a `cut.json`.
    Cut {
        /// Its name, for errors.
        name: &'a str,
        /// Its content.
        bytes: &'a [u8],
    },
    /// A place that cuts hide from; cones as well while they are at work.
    Eye([f64; 3]),
    /// The bytes of a `cones.json`: these cones are used as they are.
    Cones {
        /// Its name, for errors.
        name: &'a str,
        /// Its content.
        bytes: &'a [u8],
    },
    /// A cone at a vertex, with an angle in radians or with the one that is best.
    Cone {
        /// Number of the vertex in the file.
        vertex: f64,
        /// Radians.
        angle: Option<f64>,
    },
}

impl Session {
    /// Takes something in; the flow starts from it, or acts on it from the next step on.
    pub fn bring(&mut self, what: Brought) -> Vec<Event> {
        let mut events = std::mem::take(&mut self.late);
        self.end_comparison(&mut events);
        self.take_up();
        match self.bring_in(what, &mut events) {
            Ok(()) => self.log.push(Entry::Bring(Gift::of(&what))),
            Err(problem) => self.refuse(problem, &mut events),
        }
        events
    }

    fn bring_in(&mut self, what: Brought, events: &mut Vec<Event>) -> Result<(), Problem> {
        match what {
            Brought::Cones { name, bytes } => return self.bring_cones(name, bytes, events),
            Brought::Cone { vertex, angle } => return self.bring_cone(vertex, angle, events),
            _ => {}
        }
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let surface = work.document.surface()?;
        let mut layers = work.layers.clone();
        let mut settings = work.settings.clone();
        let label = match what {
            Brought::Cut { .. } => "bring a cut",
            _ => "bring a layer",
        };
        let (pending, init) = match what {
            Brought::Layer { channel, values } => {
                let values = of_vertices(surface, channel, values)?;
                match channel {
                    "region" => {
                        layers.regions = Rc::new(values.iter().map(|&x| x as u32).collect());
                        match work.method {
                            Method::PhaseField => {
                                settings.put("phase_start", Value::Text("painted".into()));
                                (Pending::Fields, None)
                            }
                            _ => (Pending::Restart, Some("painted")),
                        }
                    }
                    _ => {
                        *layers.amounts(channel) = Rc::new(values);
                        if channel == "heat" {
                            settings.put("source", Value::Text("heat".into()));
                        }
                        (Pending::Fields, None)
                    }
                }
            }
            Brought::Seeds(seeds) => {
                let vertices = seeds
                    .iter()
                    .map(|&x| vertex_of(surface, x, "Seeds."))
                    .collect::<Result<Vec<_>, _>>()?;
                // Here the numbers are still those of the file.
                if let Some(i) = (1..vertices.len()).find(|&i| vertices[..i].contains(&vertices[i]))
                {
                    return Err(Problem::new(
                        format!("Vertex {} is a seed twice.", seeds[i]),
                        "Seeds.",
                        "Leave one of the two out.",
                    ));
                }
                layers.seeds = Rc::new(vertices);
                (Pending::Restart, Some("seeds"))
            }
            Brought::Cut { name, bytes } => {
                layers.brought = Rc::new(labels_from_json(surface, name, bytes)?);
                (Pending::Restart, Some("file"))
            }
            Brought::Eye(place) => {
                if !place.iter().all(|x| x.is_finite()) {
                    return Err(Problem::new(
                        "The place to hide from is not a point.",
                        "Hide seams from a place.",
                        "Give three finite numbers in units of the file.",
                    ));
                }
                let eye = (Point3::from(place) - surface.frame.centre) * surface.frame.scale;
                let seen = visibility(&surface.mesh, &surface.geometry, Point3::from(eye));
                if work.method == Method::Cones {
                    layers.cone_cost = Rc::new(with_paint(&layers.cone_cost, seen.clone()));
                }
                layers.penalty = Rc::new(with_paint(&layers.penalty, seen));
                (Pending::Fields, None)
            }
            // Taken in above.
            Brought::Cones { .. } | Brought::Cone { .. } => return Ok(()),
        };
        if let Some(init) = init {
            settings.put("init", Value::Text(init.into()));
        }
        // Try before anything changes.
        let flow = match pending {
            Pending::Restart => Some(start_flow(&work.document, &settings, &layers, None)?),
            _ => None,
        };
        let depth = self.undo.len();
        let redo = std::mem::take(&mut self.redo);
        self.remember(label, label);
        let Some(work) = &mut self.work else { return Ok(()) };
        let layers = std::mem::replace(&mut work.layers, layers);
        let settings = std::mem::replace(&mut work.settings, settings);
        let was_pending = work.pending;
        match flow {
            Some(flow) => {
                work.begin(flow);
                self.push_energy(events);
            }
            None => {
                let before = work.flow.as_ref().map(CutFlow::checkpoint);
                work.pending = work.pending.max(pending);
                if let Err(problem) = self.catch_up(events) {
                    // What cannot be followed is not in force.
                    self.undo.truncate(depth);
                    self.redo = redo;
                    if let Some(work) = &mut self.work {
                        work.layers = layers;
                        work.settings = settings;
                        work.pending = was_pending;
                        // A cut flow that stands aside may know it already.
                        work.tell_flow()?;
                        if let Some((flow, before)) = work.flow.as_mut().zip(before) {
                            let name = &work.document.name;
                            flow.restore(&before).map_err(|error| Problem::solve(name, &error))?;
                        }
                    }
                    return Err(problem);
                }
            }
        }
        events.push(self.history_event());
        events.push(self.parameters());
        events.push(self.presets());
        events.push(self.paint_channels());
        self.settle(events);
        events.push(self.history_event());
        events.push(self.status());
        events.push(Event::Scene);
        Ok(())
    }
}

/// The mesh's vertex of a number of the file.
pub(super) fn vertex_of(surface: &Surface, x: f64, place: &str) -> Result<VertexId, Problem> {
    let whole = x >= 0.0 && x.fract().abs() <= 0.0;
    surface.mesh_vertex_from(x as usize).filter(|_| whole).ok_or_else(|| {
        let count = surface.soup.positions.len();
        Problem::new(
            format!("There is no vertex {x}: the mesh has {count}."),
            place,
            format!("Choose numbers from 0 to {}.", count - 1),
        )
    })
}

/// Numbers of the file's vertices at the mesh's.
fn of_vertices(surface: &Surface, channel: &str, values: &[f64]) -> Result<Vec<f64>, Problem> {
    let most = match channel {
        "region" => 255.0,
        "penalty" | "heat" | "pin" | "importance" | "unimportant" | "cone_cost" | "excluded"
        | "seam_paint" | "drawn_seam" => 1.0,
        _ => {
            return Err(Problem::new(
                format!("“{channel}” cannot be painted."),
                "Layers.",
                "Choose one of region, penalty, heat, pin, importance, unimportant, cone_cost, excluded, seam_paint, drawn_seam.",
            ));
        }
    };
    let place = || format!("{}, layer {channel}.", surface.name);
    let count = surface.soup.positions.len();
    if values.len() != count {
        return Err(Problem::new(
            format!("There are {} numbers for {count} vertices.", values.len()),
            place(),
            "Write one number for each vertex of the file, in its order.",
        ));
    }
    let is_fine = |x: f64| x >= 0.0 && x <= most && (channel != "region" || x.fract().abs() <= 0.0);
    if let Some((v, x)) = values.iter().enumerate().find(|(_, x)| !is_fine(**x)) {
        return Err(Problem::new(
            format!("{x} is out of range at vertex {v}."),
            place(),
            format!("Choose numbers from 0 to {most}."),
        ));
    }
    Ok(surface.soup_vertices.iter().map(|&v| values[v as usize]).collect())
}
