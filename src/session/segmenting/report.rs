//! What `cutflow phasefield` and `cutflow develop` report: lengths over √area, areas over the area of the surface, unless said otherwise.

use serde::Serialize;

use super::super::Session;
use super::super::message::NoticeText;
use super::super::report::FlattenReport;
use super::super::text::Problem;
use super::super::work::Work;
use super::tree::Segment;
use crate::methods::flow::Status;

/// `cutflow phasefield`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseFieldReport {
    /// Vertices of the file.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Width of the interface, on the surface scaled to area 4π.
    pub epsilon: f64,
    /// Divisions asked for.
    pub levels: usize,
    /// Weight of distortion.
    pub omega: f64,
    /// Length of all interfaces: of the level sets u = 0.
    pub perimeter: f64,
    /// The first part's share of the area at the first division, by the phase field.
    pub area_fraction: f64,
    /// Parts that hang together, of all leaves.
    pub components: usize,
    /// Diffuse Yamabe energy of all divisions, on the surface scaled to area 4π.
    pub yamabe: f64,
    /// Steps made.
    pub steps: usize,
    /// `converged`, `stalled`, `step_limit` or `paused`.
    pub status: &'static str,
    /// The hierarchy.
    pub segments: Vec<Segment>,
    /// The objective after every step.
    pub history: Vec<[f64; 2]>,
    /// The charts of the leaves as pieces.
    pub flattening: FlattenReport,
    /// What a person should know.
    pub notices: Vec<NoticeText>,
    /// Solving time, where the driver measured it.
    pub seconds: Option<f64>,
}

/// `cutflow develop`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DevelopReport {
    /// Vertices of the file.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Pieces before merging.
    pub vsa_charts: usize,
    /// Pieces as they are.
    pub patches: Vec<PatchRow>,
    /// Length of all seams, darts included, each counted once.
    pub seam_length: f64,
    /// Length of the cuts inside pieces.
    pub dart_length: f64,
    /// Steps made.
    pub steps: usize,
    /// `converged` or `paused`.
    pub status: &'static str,
    /// The symmetry that pieces are merged by, if any.
    pub symmetry: Vec<String>,
    /// The charts.
    pub flattening: FlattenReport,
    /// What a person should know.
    pub notices: Vec<NoticeText>,
    /// Solving time, where the driver measured it.
    pub seconds: Option<DevelopSeconds>,
}

/// A piece that nearly lies flat.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PatchRow {
    /// Triangles.
    pub faces: usize,
    /// Fraction of the area of the surface.
    pub area: f64,
    /// |ΣA′ − ΣA| / ΣA.
    pub area_change: f64,
    /// Σ|A′ − A| / ΣA.
    pub area_change_abs: f64,
    /// Raw L² stretch.
    pub l2_stretch: f64,
    /// Whether its outline overlaps itself.
    pub overlap: bool,
    /// Boundary loops.
    pub loops: usize,
}

/// Seconds of each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DevelopSeconds {
    /// First pieces.
    pub vsa: f64,
    /// Tighter seams.
    pub refine: f64,
    /// Smoother seams.
    pub denoise: f64,
    /// Merging.
    pub merge: f64,
}

impl DevelopSeconds {
    /// Adds time to a stage, by its identifier; to none where there is none.
    pub fn add(&mut self, stage: Option<&str>, seconds: f64) {
        match stage {
            Some("vsa") => self.vsa += seconds,
            Some("refine") => self.refine += seconds,
            Some("denoise") => self.denoise += seconds,
            Some("merge") => self.merge += seconds,
            _ => {}
        }
    }
}

/// How a flow stands, in a word.
pub(super) fn status_word(status: Option<Status>) -> &'static str {
    match status {
        Some(Status::Converged) => "converged",
        Some(Status::Stalled) => "stalled",
        Some(Status::StepLimit) => "step_limit",
        Some(Status::Infeasible) => "infeasible",
        Some(Status::Running) | None => "paused",
    }
}

/// There is nothing to report on.
pub(super) fn not_divided(work: &Work) -> Problem {
    Problem::new(
        "The surface has not been divided.",
        format!("{}.", work.document.name),
        "Choose the method and run it first.",
    )
}

impl Session {
    /// The report of `cutflow phasefield`. **Takes** the time that the driver measured.
    pub fn phase_report(&mut self, seconds: Option<f64>) -> Result<PhaseFieldReport, Problem> {
        self.settled()?.phase_report(seconds)
    }

    /// The report of `cutflow develop`. **Takes** the time that the driver measured.
    pub fn develop_report(
        &mut self,
        seconds: Option<DevelopSeconds>,
    ) -> Result<DevelopReport, Problem> {
        self.settled()?.develop_report(seconds)
    }

    /// The stage of developable patches that the next step belongs to.
    pub fn develop_stage(&self) -> Option<&'static str> {
        self.work.as_ref()?.develop.stage()
    }
}
