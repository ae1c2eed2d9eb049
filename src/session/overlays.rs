//! Fields of the flow for looking at: what was painted, the adjoint, and the stages of one step.

use super::message::{Event, StageNumber, StageNumbers};
use super::method::Method;
use super::text::Problem;
use super::work::Work;
use crate::methods::cutflow::Stages;

/// Rings of vertices beside the cut on which values of the cut are painted.
const RINGS: usize = 3;

/// Fields that show a stage of the paper's step.
const STAGES: [&str; 6] = ["flux", "velocity", "extension", "level", "moved", "redistanced"];

impl Work {
    /// One value for each vertex of a field that the layout does not know; `None` for other fields and where there is none.
    pub fn vertex_field(&mut self, id: &str) -> Result<Option<Vec<f64>>, Problem> {
        let count = self.labels().len();
        let layer =
            |layer: &[f64]| Some(if layer.is_empty() { vec![0.0; count] } else { layer.to_vec() });
        match id {
            "penalty" => return Ok(layer(&self.layers.penalty)),
            "heat" => return Ok(layer(&self.layers.heat)),
            "pin" => return Ok(layer(&self.layers.pin)),
            "importance" => return Ok(layer(&self.layers.importance)),
            "unimportant" => return Ok(layer(&self.layers.unimportant)),
            "cone_cost" => return Ok(layer(&self.layers.cone_cost)),
            "excluded" => return Ok(layer(&self.layers.excluded)),
            "u" if self.method == Method::Cones => {
                // Without cones on a convex surface it is the chart that has scale factors.
                let set = self.cones.set.as_ref().filter(|set| set.is_of_cones());
                return Ok(set.map(|set| set.u.clone()));
            }
            "phase" | "weight" | "yamabe" | "normal_error" => {
                let Some(segmentation) = self.segmentation() else { return Ok(None) };
                let name = &self.document.name;
                return segmentation.field(id).map_err(|error| Problem::solve(name, &error));
            }
            "seam_paint" => return Ok(layer(&self.layers.seams)),
            "drawn_seam" => return Ok(layer(&self.layers.drawn)),
            "phi" => return Ok(self.cones.optimum.as_ref().map(|state| state.phi.clone())),
            "regions" => {
                // A stroke goes on from the cut that is there, unless regions were painted before.
                let start = self.settings.text(super::paint::start_parameter(self.method));
                let is_painted = start == "painted" && !self.layers.regions.is_empty();
                let labels = match is_painted {
                    false => self.labels(),
                    true => self.layers.regions.to_vec(),
                };
                return Ok(Some(labels.into_iter().map(f64::from).collect()));
            }
            "adjoint" => {
                let Some(flow) = &mut self.flow else { return Ok(None) };
                let name = &self.document.name;
                let q = flow.adjoint().map_err(|error| Problem::solve(name, &error))?;
                // p = −q.
                return Ok(Some(q.into_iter().map(|q| -q).collect()));
            }
            id if STAGES.contains(&id) => {}
            _ => return Ok(None),
        }
        let Some(flow) = &mut self.flow else { return Ok(None) };
        if self.stages.is_none() {
            let name = &self.document.name;
            let stages = flow.stages().map_err(|error| Problem::solve(name, &error))?;
            self.stages = Some(stages);
        }
        let Some(stages) = &self.stages else { return Ok(None) };
        let labels = &crate::methods::flow::Flow::state(flow).labels().to_vec();
        Ok(Some(match id {
            "flux" => stages.flux_on_vertices(flow.mesh(), labels, RINGS),
            "velocity" => stages.speed_on_vertices(flow.mesh(), labels, RINGS),
            "extension" => stages.extension.clone(),
            "level" => stages.level.clone(),
            "moved" => stages.moved.clone(),
            _ => stages.redistanced.clone(),
        }))
    }

    /// The numbers of the stages, while one of them is shown.
    pub fn stage_numbers(&self, field: &str) -> Option<Event> {
        if !STAGES.contains(&field) {
            return None;
        }
        let stages = self.stages.as_ref()?;
        Some(Event::Stages { step: self.step() + 1, stages: numbers(stages) })
    }
}

fn numbers(stages: &Stages) -> Vec<StageNumbers> {
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        values.filter(|x| x.is_finite()).fold(0.0f64, |m, x| m.max(x.abs()))
    };
    let number = |label: &str, value: f64, unit: &str| StageNumber {
        label: label.into(),
        value: value.is_finite().then_some(value),
        unit: unit.into(),
    };
    let stage = |id: &str, numbers: Vec<StageNumber>| StageNumbers { id: id.into(), numbers };
    let pair = stages.fastest_crossing.map(|c| stages.labels[c]);
    let mut speeds = vec![number("Fastest cut", stages.fastest, "")];
    if let Some([a, b]) = pair {
        speeds.push(number("between region", f64::from(a) + 1.0, ""));
        speeds.push(number("and region", f64::from(b) + 1.0, ""));
    }
    let changes = stages.moved.iter().filter(|x| **x > 0.0).count();
    vec![
        stage(
            "flux",
            vec![
                number(
                    "Largest |∂u/∂n|",
                    largest(&mut stages.flux.iter().flatten().copied()),
                    "1/√A",
                ),
                number("Crossings of the cut", stages.edges.len() as f64, ""),
                number("Solves, one factor", stages.solves as f64, ""),
            ],
        ),
        stage("velocity", speeds),
        stage(
            "extension",
            vec![number("Largest velocity", largest(&mut stages.extension.iter().copied()), "")],
        ),
        stage(
            "moved",
            vec![
                number("Time step τ", stages.step, ""),
                number("Steps tried", stages.trials as f64, ""),
                number("Vertices that change region", changes as f64, ""),
            ],
        ),
        stage("redistanced", vec![number("Largest move", stages.largest_move, "edges")]),
        stage(
            "check",
            vec![
                number("Predicted change of J", stages.predicted, ""),
                number("J before", stages.energy_before, ""),
                number("J after", stages.energy_after, ""),
            ],
        ),
    ]
}
