//! A document's work as files: meshes, cuts, cones, reports.

use super::comparing::ResultCard;
use super::cones::ConesReport;
use super::layout::Layout;
use super::message::File;
use super::method::Method;
use super::report::{CutReport, InfoReport};
use super::segmenting::{DevelopReport, PhaseFieldReport};
use super::text::Problem;
use super::work::Work;
use super::{nothing_open, size};
use crate::pattern;

/// The export that needs no cut.
pub(super) const MESH: &str = "Mesh (OBJ)";

impl Work {
    pub fn export(&mut self, kind: &str) -> Result<File, Problem> {
        if let Some(made) = self.pattern_export(kind) {
            return made;
        }
        let document = &*self.document;
        if kind == MESH {
            let mm = size::stated(document, &self.settings);
            return Ok(File {
                name: format!("{}-mesh.obj", stem(&document.name)),
                mime: "model/obj",
                bytes: pattern::mesh_obj(&document.soup, mm),
            });
        }
        let given = document.surface()?;
        let Some(layout) = &self.layout else { return Err(nothing_open()) };
        let scale = size::mm_per_file_unit(document, &self.settings);
        let surface = layout.surface(given, Some(scale));
        let stem = stem(&document.name);
        let file =
            |suffix: &str, mime, bytes| File { name: format!("{stem}-{suffix}"), mime, bytes };
        match kind {
            "Cut curves (OBJ)" => Ok(file("cut.obj", "model/obj", pattern::cut_obj(&surface))),
            "Cut (JSON)" => {
                let bytes = pattern::cut_json(&surface, &layout.labels(&self.labels()));
                Ok(file("cut.json", "application/json", bytes))
            }
            "Folded surface (OBJ)" => {
                let Some(fold) = &self.fold else {
                    return Err(Problem::new(
                        "The surface has not been folded.",
                        format!("{}.", document.name),
                        "Choose Fold preview first.",
                    ));
                };
                let unit = 1.0 / given.frame.scale;
                let places: Vec<[f64; 3]> = fold
                    .flow
                    .positions()
                    .iter()
                    .map(|p| (given.frame.centre + p.coords * unit).into())
                    .collect();
                Ok(file("folded.obj", "model/obj", folded_obj(layout, &places)))
            }
            "Cones (JSON)" if self.method == Method::Cones => {
                let bytes = self.cones_file()?;
                Ok(file("cones.json", "application/json", bytes))
            }
            "Report (JSON)" => {
                #[derive(serde::Serialize)]
                struct Whole {
                    info: InfoReport,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    cut: Option<CutReport>,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    cones: Option<ConesReport>,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    phasefield: Option<PhaseFieldReport>,
                    #[serde(skip_serializing_if = "Option::is_none")]
                    develop: Option<DevelopReport>,
                    #[serde(skip_serializing_if = "Vec::is_empty")]
                    comparison: Vec<ResultCard>,
                }
                let info = InfoReport::new(document);
                let mut whole = Whole {
                    info,
                    cut: None,
                    cones: None,
                    phasefield: None,
                    develop: None,
                    comparison: self.compared.clone(),
                };
                match self.method {
                    Method::CutFlow => whole.cut = Some(self.cut_report(None)?),
                    Method::Cones => whole.cones = Some(self.cones_report(None)?),
                    Method::PhaseField => whole.phasefield = Some(self.phase_report(None)?),
                    Method::Developable => whole.develop = Some(self.develop_report(None)?),
                }
                let bytes = self.json(&whole)?;
                Ok(file("report.json", "application/json", bytes))
            }
            _ => Err(Problem::new(
                format!("There is no export called “{kind}”."),
                "In the choice of an export.",
                "Choose Mesh (OBJ), UV mesh (OBJ), UV mesh (GLB), Flat mesh (OBJ), Cut surface (PLY), Cut curves (OBJ), Cut (JSON), Cones (JSON), \
                 Pattern (SVG), Pattern (DXF), Pattern (PDF), Report (JSON), Project (JSON) or All files (ZIP).",
            )),
        }
    }

    pub(super) fn json(&self, value: &impl serde::Serialize) -> Result<Vec<u8>, Problem> {
        serde_json::to_vec_pretty(value).map_err(|error| {
            Problem::new(
                format!("The report could not be written: {error}."),
                format!("{}.", self.document.name),
                "Reset the run and try again.",
            )
        })
    }
}

/// A folded surface with its texture coordinates left out: points of the cut surface, seams sewn.
fn folded_obj(layout: &Layout, places: &[[f64; 3]]) -> Vec<u8> {
    let mut text = String::from("# the surface rebuilt from its flat pieces\n");
    for [x, y, z] in places {
        text += &format!("v {x} {y} {z}\n");
    }
    for [a, b, c] in &layout.cut.triangles {
        text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

/// A file name without its folders.
pub(super) fn base_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or(name)
}

/// A file name without its ending, safe to offer for saving.
pub(super) fn stem(name: &str) -> String {
    let base = base_name(name);
    let stem = base.rsplit_once('.').map_or(base, |(stem, _)| stem);
    let clean: String = stem
        .chars()
        .map(|c| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' })
        .collect();
    // What is appended must fit into the 255 bytes that a file's name may have.
    let end = clean.char_indices().map(|(at, c)| at + c.len_utf8()).take_while(|&end| end <= 80);
    let clean = clean[..end.last().unwrap_or(0)].trim().replace(' ', "-");
    if clean.is_empty() { "cutflow".into() } else { clean }
}
