//! What `cutflow cones` reports.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::super::nothing_open;
use super::super::report::FlattenReport;
use super::super::text::Problem;
use super::super::work::Work;
use super::edits::cone_problem;
use super::table::{ConeComparisonRow, ConePathPoint};
use crate::methods::cones::Cone;
use crate::methods::flow::Status;

/// Report of optimal cones. Lengths over √area.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConesReport {
    /// Vertices of the file.
    pub vertices: usize,
    /// Faces of the file.
    pub faces: usize,
    /// Price of angle on the surface of unit area.
    pub lambda: f64,
    /// From here on a higher price changes nothing.
    pub lambda_max: f64,
    /// The optimum.
    pub cones: Vec<ConeReport>,
    /// Corners of the flattened boundary, where its curvature is part of the problem.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub corners: Vec<ConeReport>,
    /// Σ|angle| / π of the optimum.
    pub total_angle_over_pi: f64,
    /// ∫u² of the optimum.
    pub int_u2: f64,
    /// How far it is from its conditions, relative: the larger of gap and violation.
    pub kkt_residual: f64,
    /// Primal minus dual value, relative.
    pub gap: f64,
    /// How far |φ| exceeds its bound anywhere, over λ.
    pub violation: f64,
    /// The cones as they are used.
    pub rounded: RoundedReport,
    /// `converged`, `infeasible`, `stalled`, `convex`, `paused`, or `placed` where an exact number of cones was put where they do most.
    pub status: &'static str,
    /// Rounds of the solver.
    pub rounds: usize,
    /// Numeric factorisations.
    pub factorisations: usize,
    /// Right-hand sides that were solved for.
    pub solves: usize,
    /// Length of the seams that join the cones.
    pub cut_length: f64,
    /// Whether the charts have exactly the angles of the cones.
    pub angles_exact: bool,
    /// Its charts.
    pub flattening: FlattenReport,
    /// The optimum over λ, where it was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub path: Vec<ConePathPoint>,
    /// The greedy strategy beside the optimum, where it was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub comparison: Vec<ConeComparisonRow>,
    /// What a person should know.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Solving time, where the driver measured it.
    pub seconds: Option<f64>,
}

/// A cone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConeReport {
    /// Index in the input file, from 0.
    pub vertex: u32,
    /// Radians.
    pub angle: f64,
}

/// Cones as they are used.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoundedReport {
    /// All of them.
    pub cones: Vec<ConeReport>,
    /// Σ|angle| / π.
    pub total_angle_over_pi: f64,
    /// ∫u².
    pub int_u2: f64,
    /// ‖u − u*‖ / ‖u*‖ against the optimum u*; none where they are the optimum or were changed by hand.
    pub change: Option<f64>,
}

impl Work {
    /// The report of `cutflow cones`.
    pub(in super::super) fn find_lambda_max(&mut self) -> Result<f64, Problem> {
        let surface = self.document.surface()?;
        let flow = self.cones.flow_mut().ok_or_else(nothing_open)?;
        flow.find_lambda_max().map_err(|error| cone_problem(surface, &error))
    }

    pub(in super::super) fn cones_report(
        &self,
        seconds: Option<f64>,
    ) -> Result<ConesReport, Problem> {
        let cones = &self.cones;
        let (Some(layout), Some(flow), Some(state), Some(set), Some(surface)) =
            (&self.layout, cones.flow(), &cones.optimum, &cones.set, &self.document.surface)
        else {
            return Err(Problem::new(
                "There are no cones to report on.",
                format!("{}, cones.", self.document.name),
                "Choose Run.",
            ));
        };
        let report = |cone: &Cone| ConeReport {
            vertex: surface.soup_vertices[cone.vertex.index()],
            angle: cone.angle,
        };
        let [factorisations, solves] = self.cones.costs().unwrap_or_default();
        Ok(ConesReport {
            vertices: self.document.summary.vertices,
            faces: self.document.summary.faces,
            lambda: state.lambda,
            lambda_max: flow.lambda_max(),
            cones: state.cones.iter().map(report).collect(),
            corners: state.corners.iter().map(report).collect(),
            total_angle_over_pi: state.total_angle / PI,
            int_u2: state.int_u2,
            kkt_residual: state.residual,
            gap: state.gap,
            violation: state.violation,
            rounded: RoundedReport {
                cones: set.cones.iter().map(|used| report(&used.cone)).collect(),
                total_angle_over_pi: set.total_angle / PI,
                int_u2: set.int_u2,
                change: set.change,
            },
            status: match flow.status() {
                _ if self.cones.is_placed() => "placed",
                Status::Converged if state.is_convex => "convex",
                Status::Converged => "converged",
                Status::Infeasible => "infeasible",
                Status::Stalled => "stalled",
                Status::StepLimit => "step_limit",
                Status::Running => "paused",
            },
            rounds: self.cones.rounds,
            factorisations,
            solves,
            cut_length: layout.cut_length(),
            angles_exact: layout.flattening.angles_exact,
            flattening: FlattenReport::new(layout, None),
            path: self.cones.path_points(),
            comparison: self.cones.comparison.clone(),
            note: self.cones_note(),
            seconds,
        })
    }
}
