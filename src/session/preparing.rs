//! Tools that make other triangles for the open surface, run step by step like a flow.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "numbers that count are whole and within 32 bits by their ranges"
)]

use std::collections::BTreeMap;

use super::document::Document;
use super::message::{Command, Event, NoticeText, ToolParam, ToolSpec};
use super::text::Problem;
use super::{Entry, Session, nothing_open, size};
use crate::mesh::Soup;
use crate::mesh::doctor::FindingKind;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};
use crate::methods::prepare::{
    DecimateFlow, DecimateParams, EdgeTarget, Prepared, RemeshFlow, RemeshParams, SubdivideFlow,
    SubdivideParams, SubdivideRule, Surface, TOO_COARSE,
};

/// Faces beyond which the page has trouble with memory.
const MOST_FACES: f64 = 1e6;

/// Faces beyond which a cut takes noticeably long and decimation is offered.
const MANY_FACES: usize = 120_000;

/// A tool at work.
pub(super) struct Preparation {
    /// What Undo calls it.
    pub label: &'static str,
    tool: Tool,
    fraction: Option<f32>,
}

enum Tool {
    Subdivide(Box<SubdivideFlow>),
    Remesh(Box<RemeshFlow>),
    Decimate(Box<DecimateFlow>),
}

/// Identifier, name, what Undo and the status line call it, and help of every tool.
const TOOLS: [[&str; 4]; 4] = [
    [
        "subdivide",
        "Subdivide",
        "Subdividing",
        "Splits every triangle into four. The surface stays exactly where it is.",
    ],
    [
        "refine",
        "Refine where curved",
        "Refining",
        "Halves triangles that are large against the curvature. The surface stays exactly where it is.",
    ],
    [
        "remesh",
        "Remesh evenly",
        "Remeshing",
        "Draws new, even triangles on the surface. Sharp edges, rims, texture seams and borders of materials are kept.",
    ],
    [
        "decimate",
        "Reduce",
        "Reducing",
        "Takes triangles away where they tell least about the shape.",
    ],
];

impl Preparation {
    /// A tool for the surface of a document.
    pub fn new(
        document: &Document,
        id: &str,
        values: &BTreeMap<String, f64>,
    ) -> Result<Self, Problem> {
        let Some([_, _, label, _]) = TOOLS.iter().find(|tool| tool[0] == id) else {
            let known = TOOLS.map(|tool| tool[0]).join(", ");
            return Err(Problem::new(
                format!("There is no tool called “{id}”."),
                "In the choice of a tool.",
                format!("Choose one of {known}."),
            ));
        };
        let number = values_of(document, id, values)?;
        let wrong = |error: SolveError| Problem::solve(&document.name, &error);
        let given = document.surface()?;
        if id == "remesh" {
            // Equilateral triangles of the new edge length; finer where curved, at most four times as many on the whole.
            let edge = number("edge") * given.geometry.mean_edge_length();
            let faces = given.geometry.total_area() / (0.433 * edge * edge);
            let faces = faces * (1.0 + 3.0 * number("adaptivity"));
            if faces > MOST_FACES {
                return Err(Problem::new(
                    format!(
                        "Edges that short would make about {faces:.0} triangles, more than {MOST_FACES}."
                    ),
                    "Edge length.",
                    "Choose longer edges.",
                ));
            }
        }
        let surface =
            Surface::new(&document.soup, &document.triangles, &document.triangle_polygons)
                .map_err(|error| wrong(error.into()))?;
        let feature_angle = number("crease").to_radians();
        let tool = match id {
            "remesh" => {
                let params = RemeshParams {
                    target: EdgeTarget::MeanEdges(number("edge")),
                    feature_angle,
                    adaptivity: number("adaptivity"),
                    ..RemeshParams::default()
                };
                Tool::Remesh(Box::new(RemeshFlow::new(surface, &params).map_err(wrong)?))
            }
            "decimate" => {
                let target_faces = number("faces") as usize;
                let params = DecimateParams { target_faces, feature_angle };
                Tool::Decimate(Box::new(DecimateFlow::new(surface, &params).map_err(wrong)?))
            }
            _ => {
                let rule = if id == "refine" {
                    SubdivideRule::Curvature { tolerance: number("tolerance").to_radians() }
                } else {
                    SubdivideRule::Midpoint { rounds: number("rounds") as u32 }
                };
                let params = SubdivideParams { rule, max_faces: MOST_FACES as usize };
                Tool::Subdivide(Box::new(SubdivideFlow::new(surface, &params).map_err(wrong)?))
            }
        };
        Ok(Self { label, tool, fraction: None })
    }

    /// What the status line says.
    pub fn status(&self) -> String {
        match self.fraction {
            Some(part) => format!("{}: {:.0} %", self.label, 100.0 * part),
            None => format!("{} …", self.label),
        }
    }

    /// How far it has come.
    pub fn progress(&self) -> Event {
        Event::Progress { label: self.label.to_owned(), fraction: self.fraction }
    }

    /// One bounded piece of work.
    pub fn step(&mut self) -> Result<StepReport, SolveError> {
        let report = match &mut self.tool {
            Tool::Subdivide(flow) => flow.step(),
            Tool::Remesh(flow) => flow.step(),
            Tool::Decimate(flow) => flow.step(),
        }?;
        self.fraction = report.progress;
        Ok(report)
    }

    /// The new mesh; what ended the work is told with it, if it was not that the work was done.
    pub fn finish(self, status: Status) -> (Soup, Option<&'static str>) {
        let state: Prepared = match self.tool {
            Tool::Subdivide(flow) => flow.state().clone(),
            Tool::Remesh(flow) => flow.state().clone(),
            Tool::Decimate(flow) => flow.state().clone(),
        };
        let note = match status {
            Status::Stalled => Some(
                "No further triangle can go without changing the shape's topology or folding it.",
            ),
            Status::StepLimit => Some("Stopped at the largest number of faces."),
            _ => None,
        };
        (state.surface.into_soup(), note)
    }
}

/// The parameters of a tool, checked against their ranges.
fn values_of(
    document: &Document,
    id: &str,
    values: &BTreeMap<String, f64>,
) -> Result<impl Fn(&str) -> f64, Problem> {
    let specs = tools(document);
    let params =
        specs.into_iter().find(|tool| tool.id == id).map_or(Vec::new(), |tool| tool.params);
    if let Some(unknown) = values.keys().find(|key| params.iter().all(|p| p.id != **key)) {
        let known = params.iter().map(|p| p.id.as_str()).collect::<Vec<_>>().join(", ");
        return Err(Problem::new(
            format!("This tool has no parameter called “{unknown}”."),
            "In the parameters of the tool.",
            format!("Use {known}."),
        ));
    }
    let mut chosen = BTreeMap::new();
    for param in params {
        let value = values.get(&param.id).copied().unwrap_or(param.default);
        if !(value >= param.min && value <= param.max) {
            return Err(Problem::new(
                format!("{value} is out of range."),
                format!("{}.", param.label),
                format!("Choose a number from {} to {}.", param.min, param.max),
            ));
        }
        if param.integer && value.fract().abs() > 0.0 {
            return Err(Problem::new(
                format!("{value} is not a whole number."),
                format!("{}.", param.label),
                "Choose a whole number.",
            ));
        }
        chosen.insert(param.id, value);
    }
    Ok(move |id: &str| chosen.get(id).copied().unwrap_or(0.0))
}

/// All tools, with advice for a document; none for one that needs repair.
pub fn tools(document: &Document) -> Vec<ToolSpec> {
    let Some(surface) = &document.surface else { return Vec::new() };
    let coarse = surface.coarseness;
    let faces = document.triangles.len();
    let number =
        |id: &str, label: &str, unit: &str, range: [f64; 3], default: f64, help: &str| ToolParam {
            id: id.into(),
            label: label.into(),
            unit: unit.into(),
            help: help.into(),
            min: range[0],
            max: range[1],
            step: range[2],
            default,
            logarithmic: false,
            integer: false,
        };
    let crease = || {
        number(
            "crease",
            "Creases from",
            "°",
            [5.0, 180.0, 1.0],
            40.0,
            "Edges whose faces turn by more than this are kept where they are.",
        )
    };
    TOOLS
        .iter()
        .map(|&[id, label, _, help]| {
            let (params, advice) = match id {
                "subdivide" => (
                    vec![ToolParam {
                        integer: true,
                        ..number("rounds", "Rounds", "", [1.0, 4.0, 1.0], 1.0, "How many times each triangle becomes four.")
                    }],
                    None,
                ),
                "refine" => (
                    vec![number("tolerance", "Angle of an edge", "°", [2.0, 60.0, 1.0], TOO_COARSE.to_degrees().round(),
                        "About the angle over which an edge may bend away from the surface that the mesh stands for.")],
                    (coarse > TOO_COARSE).then(|| format!(
                        "Edges span {:.0}° of curvature, more than {:.0}°: cuts and measures will be rough. Refine first.",
                        coarse.to_degrees(), TOO_COARSE.to_degrees()
                    )),
                ),
                "remesh" => (
                    vec![
                        ToolParam { logarithmic: true, ..number("edge", "Edge length", "mean edges", [0.25, 8.0, 0.05], 1.0,
                            "Length of the new edges; 1 is the mean of the present ones.") },
                        crease(),
                        number("adaptivity", "Finer where curved", "", [0.0, 1.0, 0.1], 0.0,
                            "0: the same length everywhere. 1: edges as long as the curvature allows."),
                    ],
                    document.examination.find(FindingKind::Slivers).map(|_| {
                        "Some triangles are slivers; even ones give more reliable cuts.".to_owned()
                    }),
                ),
                _ => (
                    vec![
                        ToolParam { logarithmic: true, integer: true, ..number("faces", "Faces", "", [4.0, MOST_FACES, 1.0],
                            (faces as f64 / 2.0).round().clamp(4.0, 40_000.0), "Number of triangles to come down to.") },
                        crease(),
                    ],
                    (faces > MANY_FACES).then(|| format!(
                        "{faces} triangles make each step slow; 40000 show the same cut."
                    )),
                ),
            };
            ToolSpec { id: id.into(), label: label.into(), help: help.into(), advice, params }
        })
        .collect()
}

impl Session {
    /// Starts a preparation; [`Session::advance`] goes on with it.
    pub(super) fn prepare(
        &mut self,
        tool: &str,
        values: &BTreeMap<String, f64>,
        events: &mut Vec<Event>,
    ) -> Result<(), Problem> {
        let Some(work) = &self.work else { return Err(nothing_open()) };
        let preparation = Preparation::new(&work.document, tool, values)?;
        if self.is_running {
            self.pause(events)?;
        }
        events.push(preparation.progress());
        self.preparation = Some(preparation);
        events.push(self.status());
        Ok(())
    }

    /// One step of the preparation; its result becomes the document at the end.
    pub(super) fn prepare_on(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let (Some(work), Some(mut preparation)) = (&self.work, self.preparation.take()) else {
            return Ok(());
        };
        let report =
            preparation.step().map_err(|error| Problem::solve(&work.document.name, &error))?;
        events.push(preparation.progress());
        if report.status == Status::Running {
            self.preparation = Some(preparation);
            return Ok(());
        }
        let label = preparation.label.to_lowercase();
        let (soup, note) = preparation.finish(report.status);
        if soup.positions == work.document.soup.positions {
            return Err(Problem::new(
                "The tool changed nothing: the mesh is already as asked for.",
                format!("{}.", work.document.name),
                note.unwrap_or("Choose other parameters."),
            ));
        }
        let mut document = work.document.with_soup(soup)?;
        if let Some(note) = note {
            document.summary.notices.push(NoticeText::new("prepared", 1, note));
        }
        let mut settings = work.settings.clone();
        size::keep(&work.document, &document, &mut settings);
        self.change_to(document, settings, &label, events);
        if let Some(before) = self.undo.last_mut() {
            // What Undo goes back to has not come to this end.
            before.log.take_back_step();
            before.log.push(Entry::Do(Command::EndStroke));
        }
        Ok(())
    }
}
