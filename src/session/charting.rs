//! How a cut at rest becomes charts that can be trusted: which flattening, and what is done about flips and overlaps.
//!
//! The automatic way begins with boundary first flattening, which is fast. Where that turns triangles over or misses the angles of cones,
//! discrete conformal equivalence takes its place, which does neither. What overlaps itself is split. What cannot be had that way is
//! told and counted.

use std::f64::consts::TAU;

use nalgebra::Point3;

use super::message::ParamSpec;
use super::outlines::Outline;
use super::params::Settings;
use super::specs::{choice, switch};
use super::text::{Problem, capital, plural};
use crate::flatten::abf::abf;
use crate::flatten::conformal::{
    Conformal, ConformalError, ConformalParams, ConformalReport, RimCondition, conformal,
    conformal_with_cones,
};
use crate::flatten::lpfb::lpfb;
use crate::flatten::lscm::{dcp, lscm};
use crate::flatten::split::{Flips, SplitParams, split_overlaps};
use crate::flatten::{Flattening, TargetError, bff, bff_scaled};
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{CutMesh, Mesh, MeshError, OpenedMesh, VertexId};
use crate::methods::cones::Cone;
use crate::methods::flow::SolveError;

/// Copies of a point that are no farther apart in the plane lie on each other, √area = 1: ten nanometres on a pattern of a metre. Slits
/// of cones with angles below 1e-6 open by as little, or close by as little too much.
const SLIT: f64 = 1e-8;

/// How much the rims of a cone metric may give way to be closed, as log ratio or radians, before conformal equivalence is tried.
const MOST_CLOSING: f64 = 0.1;

/// The parameters of charts: of every method.
pub(super) fn specs() -> Vec<ParamSpec> {
    let charts = "Charts";
    vec![
        choice(
            charts,
            "flatten",
            "Flatten by",
            &[
                ("auto", "Automatic"),
                ("bff", "Boundary first"),
                ("conformal", "Conformal"),
                ("lpfb", "Length-preserved boundary"),
                ("lscm", "LSCM"),
                ("dcp", "DCP"),
                ("abf", "ABF++"),
            ],
            "Automatic takes boundary first flattening, and conformal equivalence with intrinsic flips where that turns triangles over or misses the cones' angles; developable patches keep the maps that they were merged by. Length-preserved boundaries (LPFB) have true lengths at the rim exactly, and a harmonic inside. Least squares (LSCM), spectral (DCP) and angle based (ABF++) maps are there for comparison: they do not keep seams equally long.",
        ),
        choice(
            charts,
            "refine",
            "Even out",
            &[
                ("none", "Off"),
                ("dirichlet", "Symmetric Dirichlet"),
            ],
            "Trades angles for lengths, as cloth, leather and sheet metal want it, by symmetric Dirichlet energy. No triangle turns over, seams stay equally long; painted pins stay where they are.",
        ),
        choice(charts, "outline", "Outline",
            &[("length", "True length"), ("disk", "Circle"), ("rectangle", "Rectangle")],
            "Of every chart. Anything but true length makes seams of unequal length: for textures and for looking, not for sewing.")
            .advanced().only_if("flatten", &["auto", "bff"]),
        switch(
            charts,
            "split",
            "Split overlaps",
            true,
            "Charts that overlap themselves are cut apart along the shortest way.",
        )
        .advanced(),
    ]
}

/// How charts are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Charting {
    /// Which flattening.
    pub by: FlattenBy,
    /// Whether charts that overlap themselves are split.
    pub splits: bool,
    /// What outlines are to be. Cones keep theirs.
    pub outline: Outline,
    /// The corners of a rectangle, vertices on the surface's own boundary; chosen by shape if none are given.
    pub corners: Option<[VertexId; 4]>,
}

/// Which flattening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FlattenBy {
    /// BFF, and conformal equivalence where that is not enough.
    #[default]
    Auto,
    /// Boundary first flattening.
    Bff,
    /// Discrete conformal equivalence.
    Conformal,
    /// Length-preserved free boundary.
    Lpfb,
    /// Least squares conformal maps.
    Lscm,
    /// Discrete conformal parameterisation, spectral.
    Dcp,
    /// Angle based flattening.
    Abf,
}

impl FlattenBy {
    /// By the identifier of the option.
    pub fn of(id: &str) -> Self {
        match id {
            "bff" => Self::Bff,
            "conformal" => Self::Conformal,
            "lpfb" => Self::Lpfb,
            "lscm" => Self::Lscm,
            "dcp" => Self::Dcp,
            "abf" => Self::Abf,
            _ => Self::Auto,
        }
    }
}

impl Default for Charting {
    fn default() -> Self {
        Self { by: FlattenBy::Auto, splits: true, outline: Outline::TrueLength, corners: None }
    }
}

impl Charting {
    /// As the parameters say.
    pub fn of(settings: &Settings) -> Self {
        let by = FlattenBy::of(settings.text("flatten"));
        // The other ways have outlines of their own.
        let outline = match by {
            FlattenBy::Auto | FlattenBy::Bff => Outline::of(settings.text("outline")),
            _ => Outline::TrueLength,
        };
        Self { by, splits: settings.is_on("split"), outline, corners: None }
    }
}

/// Why there are no charts.
#[derive(Clone, Debug, thiserror::Error)]
pub enum ChartError {
    /// A solve that could not be done.
    #[error(transparent)]
    Solve(#[from] SolveError),
    /// Angles that no flat surface has.
    #[error(transparent)]
    Conformal(#[from] ConformalError),
    /// An outline that no chart has.
    #[error(transparent)]
    Target(#[from] TargetError),
}

impl From<LinalgError> for ChartError {
    fn from(error: LinalgError) -> Self {
        Self::Solve(error.into())
    }
}

impl From<MeshError> for ChartError {
    fn from(error: MeshError) -> Self {
        Self::Solve(error.into())
    }
}

impl ChartError {
    /// As a person reads it.
    pub fn problem(&self, name: &str) -> Problem {
        match self {
            Self::Target(error) => Problem::new(
                format!("{}.", capital(&error.to_string())),
                format!("{name}, outline of a chart."),
                "Choose another outline.",
            ),
            Self::Solve(error) | Self::Conformal(ConformalError::Solve(error)) => {
                Problem::solve(name, error)
            }
            Self::Conformal(error) => Problem::new(
                format!("{}.", capital(&error.to_string())),
                format!("{name}, conformal flattening."),
                "Change the angles of the cones, or flatten by boundary first flattening.",
            ),
        }
    }
}

/// How the charts of a layout came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Made {
    /// `bff`, `conformal`, `lscm`, `dcp` or `abf`.
    pub method: &'static str,
    /// What conformal equivalence has to say.
    pub conformal: Option<ConformalReport>,
    /// Triangles that boundary first flattening turned over, where conformal equivalence took over for that.
    pub bff_flipped: usize,
    /// Why conformal equivalence did not take over, where it was tried.
    pub refusal: Option<String>,
    /// Charts more than before, because charts overlapped themselves.
    pub charts_added: usize,
    /// Length of the cuts between them.
    pub split_length: f64,
    /// Triangles that were cut out and mirrored because nothing else turned them over.
    pub cut_out: usize,
    /// What an outline that was asked for did to triangles.
    pub outline: Option<String>,
    /// What a person should know.
    pub notice: Option<String>,
}

/// A cut surface and its charts.
pub struct Charted {
    /// The mesh refined along the cut.
    pub cut: CutMesh,
    /// Where its points lie.
    pub points: Vec<Point3<f64>>,
    /// Opened.
    pub opened: OpenedMesh,
    /// Measured.
    pub geometry: Geometry,
    /// Its charts.
    pub flattening: Flattening,
    /// How they came about.
    pub made: Made,
}

/// The measures of an opened surface whose points lie there.
pub fn measure_opened(opened: &OpenedMesh, points: &[Point3<f64>]) -> Geometry {
    let positions = opened.vertex_points.iter().map(|&p| points[p as usize]).collect();
    Geometry::measure(&opened.mesh, positions)
}

/// What there is to flatten.
pub struct Patches<'a> {
    /// The surface.
    pub mesh: &'a Mesh,
    /// Its cut.
    pub cut: CutMesh,
    /// Where the cut's points lie.
    pub points: Vec<Point3<f64>>,
    /// Opened.
    pub opened: OpenedMesh,
    /// What seams cost at each vertex of the surface beyond their length; empty for nothing.
    pub seam_cost: &'a [f64],
}

/// Cones on a surface and the scale factors that belong to them.
pub struct ConeMetric<'a> {
    /// Cones.
    pub cones: Vec<Cone>,
    /// Log scale factor at every vertex.
    pub u: &'a [f64],
}

impl Patches<'_> {
    /// Charts of the patches; of a cone metric, where there is one.
    pub fn chart(
        self,
        charting: &Charting,
        metric: Option<&ConeMetric>,
    ) -> Result<Charted, ChartError> {
        let seam_cost = self.seam_cost;
        let is_shaped = metric.is_none() && charting.outline != Outline::TrueLength;
        let mut charted = match charting.by {
            FlattenBy::Auto | FlattenBy::Bff if is_shaped => {
                let geometry = measure_opened(&self.opened, &self.points);
                let mut flattening = bff(&self.opened, &geometry)?;
                // The first copy of a vertex keeps its number.
                let corners = charting.corners.as_ref().map_or(&[][..], |corners| corners);
                let warning =
                    charting.outline.shape(&self.opened, &geometry, &mut flattening, corners)?;
                let mut charted = self.charted(geometry, flattening, "bff");
                charted.made.outline = warning;
                charted.made.notice = notice_of(&charted.made);
                charted
            }
            FlattenBy::Auto => self.best(metric)?,
            FlattenBy::Conformal => {
                let conformal = self.conformal(metric)?;
                Charted::of_conformal(conformal)
            }
            by => {
                let geometry = measure_opened(&self.opened, &self.points);
                let (method, flattening) = match by {
                    FlattenBy::Lpfb => ("lpfb", lpfb(&self.opened, &geometry)?.0),
                    FlattenBy::Lscm => ("lscm", lscm(&self.opened, &geometry)?),
                    FlattenBy::Dcp => ("dcp", dcp(&self.opened, &geometry)?),
                    FlattenBy::Abf => ("abf", abf(&self.opened, &geometry)?),
                    _ => ("bff", self.bff(&geometry, metric)?),
                };
                self.charted(geometry, flattening, method)
            }
        };
        charted.flattening.close_slits(&charted.opened, SLIT);
        if charting.splits { charted.split(seam_cost) } else { Ok(charted) }
    }

    fn charted(self, geometry: Geometry, flattening: Flattening, method: &'static str) -> Charted {
        let Self { cut, points, opened, .. } = self;
        let made = Made { method, ..Made::default() };
        Charted { cut, points, opened, geometry, flattening, made }
    }

    fn bff(
        &self,
        geometry: &Geometry,
        metric: Option<&ConeMetric>,
    ) -> Result<Flattening, LinalgError> {
        let Some(metric) = metric else { return bff(&self.opened, geometry) };
        let points = self.opened.vertex_points.iter();
        let rim_u: Vec<f64> = points.map(|&p| metric.u[p as usize]).collect();
        bff_scaled(&self.opened, geometry, &rim_u)
    }

    fn conformal(&self, metric: Option<&ConeMetric>) -> Result<Conformal, ConformalError> {
        let params = ConformalParams::default();
        let Some(metric) = metric else {
            let rim = RimCondition::Isometric;
            return conformal(self.mesh, &self.cut, &self.points, &rim, &params);
        };
        // On the boundary the cones' own scale factors are what is asked for, its corners included.
        let rim = RimCondition::LogScales(metric.u.to_vec());
        let inside = |cone: &&Cone| !self.mesh.is_boundary_vertex(cone.vertex);
        let cones: Vec<Cone> = metric.cones.iter().filter(inside).copied().collect();
        conformal_with_cones(self.mesh, &self.cut, &self.points, &cones, &rim, &params)
    }

    /// Boundary first flattening, or conformal equivalence where that is better.
    fn best(self, metric: Option<&ConeMetric>) -> Result<Charted, ChartError> {
        let geometry = measure_opened(&self.opened, &self.points);
        let flattening = self.bff(&geometry, metric)?;
        let flipped = flattening.flipped(&self.opened);
        // A rim that had to give way much shears what lies inside it.
        let is_exact =
            metric.is_none() || flattening.angles_exact && flattening.closing <= MOST_CLOSING;
        let too_sharp = metric.is_some_and(|m| m.cones.iter().any(|c| !(c.angle < TAU)));
        if (flipped == 0 && is_exact) || too_sharp {
            return Ok(self.charted(geometry, flattening, "bff"));
        }
        let charts = |flattening: &Flattening| flattening.charts.iter().flatten().count();
        let refusal = match self.conformal(metric) {
            Ok(conformal)
                if charts(&conformal.flattening) >= charts(&flattening)
                    && (conformal.report.flipped_after < flipped
                        || (conformal.report.flipped_after == flipped && !is_exact)) =>
            {
                let mut charted = Charted::of_conformal(conformal);
                charted.made.bff_flipped = flipped;
                charted.made.notice = notice_of(&charted.made);
                return Ok(charted);
            }
            Ok(_) => "it would not do better".to_owned(),
            Err(error) => error.to_string(),
        };
        // What conformal equivalence cannot do is no reason to have no charts at all.
        let mut charted = self.charted(geometry, flattening, "bff");
        charted.made.refusal = Some(refusal);
        charted.made.notice = notice_of(&charted.made);
        Ok(charted)
    }
}

impl Charted {
    fn of_conformal(conformal: Conformal) -> Self {
        let Conformal { cut, positions, opened, flattening, report } = conformal;
        let geometry = measure_opened(&opened, &positions);
        let made = Made { method: "conformal", conformal: Some(report), ..Made::default() };
        Self { cut, points: positions, opened, geometry, flattening, made }
    }

    /// Parts charts until none overlaps itself.
    fn split(self, seam_cost: &[f64]) -> Result<Self, ChartError> {
        let flipped = self.flattening.flipped(&self.opened);
        // Points between vertices cost what nothing hides.
        let mut cost = seam_cost.to_vec();
        if !cost.is_empty() {
            cost.resize(self.cut.points.len(), 0.0);
        }
        let params = SplitParams {
            // Slits are closed: nothing overlaps by rounding alone.
            tolerance: 0.0,
            flips: if flipped > 0 { Flips::CutOut } else { Flips::Leave },
            ..SplitParams::default()
        };
        let split = split_overlaps(
            &self.cut,
            &self.opened,
            &self.geometry,
            &self.flattening,
            &cost,
            &params,
        )?;
        if split.added == 0 && flipped == 0 {
            return Ok(self);
        }
        let mut made = self.made;
        made.charts_added = split.added;
        made.split_length = split.length;
        made.cut_out = flipped - split.flips.len().min(flipped);
        made.notice = notice_of(&made);
        let geometry = measure_opened(&split.opened, &self.points);
        Ok(Self {
            cut: split.cut,
            points: self.points,
            opened: split.opened,
            geometry,
            flattening: split.flattening,
            made,
        })
    }
}

/// What a person should know of how charts came about.
fn notice_of(made: &Made) -> Option<String> {
    let turned = match &made.refusal {
        Some(reason) => Some(format!("Conformal equivalence could not take over: {reason}.")),
        None => (made.bff_flipped > 0).then(|| {
            let triangles = plural(made.bff_flipped, "triangle");
            format!(
                "Conformal equivalence took over: boundary first flattening turned {triangles} over."
            )
        }),
    };
    let split = (made.charts_added > 0).then(|| {
        let added = plural(made.charts_added, "piece");
        match made.cut_out {
            0 => format!("Pieces overlapped themselves in the plane: splitting them added {added}."),
            n => format!(
                "Pieces overlapped themselves in the plane or had triangles that turn over: splitting them added {added}, and {} cut out.",
                if n == 1 { "1 triangle is".to_owned() } else { format!("{n} triangles are") }
            ),
        }
    });
    let all: Vec<String> = [made.outline.clone(), turned, split].into_iter().flatten().collect();
    (!all.is_empty()).then(|| all.join(" "))
}
