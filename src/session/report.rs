//! Reports for machines: the fields of `--json` and of the page's report, lengths divided by √area and areas by area.

use serde::Serialize;

use super::document::Document;
use super::layout::Layout;
use super::message::NoticeText;
use crate::flatten::comparison::ComparisonRow;
use crate::flatten::conformal::ConformalReport;
use crate::flatten::{ChartMeasures, validate};
use crate::methods::cutflow::{Energy, Weights};

/// `cutflow info`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InfoReport {
    /// Vertices of the file.
    pub vertices: usize,
    /// Polygons of the file.
    pub faces: usize,
    /// Triangles that the polygons are divided into.
    pub triangles: usize,
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundary_loops: usize,
    /// Sum of the genera; `null` where the faces do not form an orientable surface.
    pub genus: Option<usize>,
    /// V − E + F over used vertices.
    pub euler: i64,
    /// In the file's unit squared.
    pub area: f64,
    /// Sides of the bounding box of the used vertices, in the file's unit.
    pub size: [f64; 3],
    /// Whether methods can work on it without repair.
    pub solvable: bool,
    /// What was found.
    pub notices: Vec<NoticeText>,
}

/// `cutflow cut`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CutReport {
    /// Vertices of the file.
    pub vertices: usize,
    /// Triangles.
    pub faces: usize,
    /// Labels in use.
    pub regions: usize,
    /// Accepted steps.
    pub steps: usize,
    /// `running`, `paused`, `converged`, `stalled` or `step_limit`.
    pub status: &'static str,
    /// One entry for each step, the initial cut first.
    pub history: Vec<HistoryRow>,
    /// Length of the cut, each stretch counted once; cuts added for disks not included.
    pub cut_length: f64,
    /// Length of the cuts added to make disks.
    pub disk_cut_length: f64,
    /// Σ ∫u², unweighted.
    pub hencky: f64,
    /// Σ ∫|∇u|², unweighted.
    pub dirichlet: f64,
    /// Relative residual of the last solve.
    pub residual: f64,
    /// One entry for each patch, after cutting to disks.
    pub patches: Vec<PatchReport>,
    /// The charts.
    pub flattening: FlattenReport,
    /// Real size: millimetres of one unit of the file.
    pub mm_per_unit: f64,
    /// ∫_γ η, unweighted; 0 without a penalty.
    pub penalty: f64,
    /// Area of the first region, where its growth is rewarded.
    pub region_area: f64,
    /// What a person should know of the cut as a whole.
    pub notices: Vec<NoticeText>,
    /// Symmetries that the cut keeps.
    pub symmetry: Vec<String>,
    /// The surface rebuilt from the flat pieces, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fold: Option<FoldReport>,
    /// Solving time, where the driver measured it.
    pub seconds: Option<f64>,
    /// Solving time over steps; `null` without steps.
    pub seconds_per_step: Option<f64>,
}

/// The developable preview. Lengths over √area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FoldReport {
    /// Steps made.
    pub steps: usize,
    /// Mean distance from the surface.
    pub distance_mean: f64,
    /// Largest distance.
    pub distance_max: f64,
    /// Root mean square of the logs of lengths that are still wrong.
    pub stretch: f64,
}

/// One step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HistoryRow {
    /// Accepted steps.
    pub step: usize,
    /// Weighted distortion: J without length, penalty and growth.
    pub distortion: f64,
    /// |γ|.
    pub length: f64,
    /// J.
    pub total: f64,
    /// Its terms, from which it follows for other weights.
    #[serde(skip)]
    pub(super) energy: Energy,
    /// The weights that it was measured with.
    #[serde(skip)]
    pub(super) weights: Weights,
}

/// One patch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PatchReport {
    /// Triangles of the refined surface.
    pub faces: usize,
    /// Fraction of the area.
    pub area: f64,
    /// 1 for disks.
    pub euler: i64,
    /// 1 for disks.
    pub boundary_loops: usize,
}

/// `cutflow flatten`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FlattenReport {
    /// One entry for each chart; `null` where a patch has none.
    pub charts: Vec<Option<ChartReport>>,
    /// All charts together.
    pub totals: ChartReport,
    /// How: `bff`, `conformal`, `lpfb`, `lscm`, `dcp` or `abf`.
    pub method: &'static str,
    /// Whether both sides of every seam are equally long in the charts.
    pub seams_equal: bool,
    /// Whether the charts have the cones' angles; no isometric rim has.
    pub angles_exact: bool,
    /// Proof that nothing is turned over or covered twice, or the worst there is.
    pub validity: ValidityReport,
    /// Triangles that boundary first flattening had turned over, where conformal equivalence took over for that.
    #[serde(skip_serializing_if = "is_zero")]
    pub bff_flipped: usize,
    /// What conformal equivalence did, where it did it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conformal: Option<EquivalenceReport>,
    /// Largest relative residual of the linear solves behind the charts; 0 where conformal equivalence or merged patches have measures of their own.
    pub residual: f64,
    /// What became of charts that overlapped themselves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub split: Option<SplitReport>,
    /// What evening out did.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refined: Option<RefinedReport>,
    /// Solving time, where the driver measured it.
    pub seconds: Option<f64>,
}

/// A row of `cutflow compare --flattenings`: all patches by one method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparisonReport {
    /// The method.
    pub method: &'static str,
    /// Triangles that have a chart.
    pub faces: usize,
    /// Sides of all rims.
    pub rim_sides: usize,
    /// Mean error of a rim side's length, over their mean length.
    pub length_error: f64,
    /// Mean error of a rim corner's angle, radians.
    pub angle_error: f64,
    /// Σ(A′ − A)/ΣA.
    pub area_change: f64,
    /// Σ|A′ − A|/ΣA.
    pub area_change_abs: f64,
    /// Raw L² stretch.
    pub l2_stretch: f64,
    /// L² stretch with the charts' area brought to that of the patches.
    pub l2_stretch_normalized: f64,
    /// Turned-over triangles.
    pub flipped: usize,
    /// Crossings of outlines with themselves.
    pub overlaps: usize,
    /// Solving time, which the driver measured.
    pub seconds: f64,
}

impl ComparisonReport {
    /// **Takes** the time that the driver measured.
    pub fn new(row: &ComparisonRow, seconds: f64) -> Self {
        Self {
            method: row.method.name(),
            faces: row.faces,
            rim_sides: row.rim_sides,
            length_error: row.length_error,
            angle_error: row.angle_error,
            area_change: row.area_change,
            area_change_abs: row.area_change_abs,
            l2_stretch: row.l2_stretch,
            l2_stretch_normalized: row.l2_stretch_normalized,
            flipped: row.flipped,
            overlaps: row.overlaps,
            seconds,
        }
    }
}

/// Distortion of one chart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ChartReport {
    /// Triangles.
    pub faces: usize,
    /// Turned-over triangles.
    pub flipped: usize,
    /// Crossings of the outline with itself; in the totals also of different charts on the sheet.
    pub overlaps: usize,
    /// Mean σ₁/σ₂.
    pub angle_distortion: f64,
    /// Largest σ₁/σ₂.
    pub angle_distortion_max: f64,
    /// RMS of the log scale around its mean.
    pub area_distortion: f64,
    /// Σ(A′ − A)/ΣA.
    pub area_change: f64,
    /// Σ|A′ − A|/ΣA.
    pub area_change_abs: f64,
    /// Raw L² stretch.
    pub l2_stretch: f64,
    /// L² stretch with the chart's area brought to that of the patch.
    pub l2_stretch_normalized: f64,
    /// Raw L^∞ stretch.
    pub linf_stretch: f64,
    /// L^∞ stretch with the chart's area brought to that of the patch.
    pub linf_stretch_normalized: f64,
    /// Symmetric Dirichlet energy; 1 is isometric.
    pub symmetric_dirichlet: f64,
    /// Smallest signed area of a triangle in the plane; `null` without triangles.
    pub smallest_signed_area: Option<f64>,
}

/// All faces and all pairs of faces of all charts on the sheet, by exact predicates. Areas over the area of the surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidityReport {
    /// Triangles that are turned over or have no area.
    pub flipped: usize,
    /// Pairs of triangles that overlap, in one chart or between two.
    pub overlapping_pairs: usize,
    /// What they have in common.
    pub overlapping_area: f64,
    /// The triangle of the cut surface with the smallest signed area.
    pub smallest: Option<SmallestReport>,
    /// The pair that has most in common.
    pub worst_pair: Option<PairReport>,
}

/// A triangle of the cut surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SmallestReport {
    /// Its number.
    pub triangle: u32,
    /// Its signed area in the plane.
    pub signed_area: f64,
}

/// Two triangles of the cut surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairReport {
    /// Their numbers.
    pub triangles: [u32; 2],
    /// What they have in common.
    pub area: f64,
}

/// Conformal equivalence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EquivalenceReport {
    /// Steps of Newton's method.
    pub newton_steps: usize,
    /// Numeric factorisations.
    pub factorisations: usize,
    /// Flips of edges towards a Delaunay triangulation of the surface.
    pub surface_flips: usize,
    /// Flips of edges on the way.
    pub conformal_flips: usize,
    /// Largest error of an angle, radians.
    pub angle_error: f64,
    /// By how much charts do not close, over their diameters.
    pub closure: f64,
    /// Triangles on their backs before the repair.
    pub flipped_before: usize,
    /// Points on edges that the repair added.
    pub points_inserted: usize,
    /// Least and largest log scale factor.
    pub scale_range: [f64; 2],
}

/// Charts that overlapped themselves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SplitReport {
    /// Charts more than before.
    pub charts_added: usize,
    /// Length of the cuts between them.
    pub length: f64,
    /// Triangles that were turned over and are pieces of their own now.
    pub triangles_cut_out: usize,
}

/// Charts evened out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RefinedReport {
    /// `dirichlet`.
    pub energy: &'static str,
    /// Steps made.
    pub steps: usize,
    /// Distortion before; 0 is isometric.
    pub before: f64,
    /// Distortion after.
    pub after: f64,
    /// Largest relative difference of the lengths of partners.
    pub seam_difference: f64,
    /// Whether that is within a tenth of a millimetre in a metre.
    pub seams_met: bool,
}

impl InfoReport {
    /// Of an opened mesh.
    pub fn new(document: &Document) -> Self {
        let s = &document.summary;
        Self {
            vertices: s.vertices,
            faces: s.faces,
            triangles: s.triangles,
            components: s.components,
            boundary_loops: s.boundary_loops,
            genus: s.genus,
            euler: s.euler,
            area: s.area,
            size: document.size(),
            solvable: s.solvable,
            notices: s.notices.clone(),
        }
    }
}

impl HistoryRow {
    /// Of an energy after a step.
    pub fn new(step: usize, energy: &Energy, weights: &Weights) -> Self {
        let distortion = weights.distortion(energy);
        let total = weights.total(energy);
        Self { step, distortion, length: energy.length, total, energy: *energy, weights: *weights }
    }

    /// The same step measured with other weights.
    pub fn reweighted(&self, weights: &Weights) -> Self {
        Self::new(self.step, &self.energy, weights)
    }
}

impl ChartReport {
    fn new(m: &ChartMeasures) -> Self {
        Self {
            faces: m.faces,
            flipped: m.flipped,
            overlaps: m.overlaps,
            angle_distortion: m.angle_distortion,
            angle_distortion_max: m.angle_distortion_max,
            area_distortion: m.area_distortion,
            area_change: m.area_change,
            area_change_abs: m.area_change_abs,
            l2_stretch: m.l2_stretch,
            l2_stretch_normalized: m.l2_stretch_normalized,
            linf_stretch: m.linf_stretch,
            linf_stretch_normalized: m.linf_stretch_normalized,
            symmetric_dirichlet: m.symmetric_dirichlet,
            smallest_signed_area: Some(m.smallest_signed_area).filter(|a| a.is_finite()),
        }
    }
}

impl FlattenReport {
    /// Of a layout.
    pub fn new(layout: &Layout, seconds: Option<f64>) -> Self {
        let charts = &layout.measures.charts;
        let mut totals = ChartReport::new(&layout.measures.totals);
        totals.overlaps = layout.overlaps();
        Self {
            charts: charts.iter().map(|m| m.as_ref().map(ChartReport::new)).collect(),
            totals,
            method: layout.made.method,
            seams_equal: layout.flattening.seams_equal,
            angles_exact: layout.flattening.angles_exact,
            validity: ValidityReport::new(layout),
            bff_flipped: layout.made.bff_flipped,
            conformal: layout.made.conformal.as_ref().map(EquivalenceReport::new),
            residual: layout.flattening.residual,
            split: SplitReport::new(layout),
            refined: layout.refined,
            seconds,
        }
    }
}

/// Says to serde what is left out.
fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl ValidityReport {
    fn new(layout: &Layout) -> Self {
        let found = validate(&layout.opened, &layout.flattening, Some(&layout.packing)).totals;
        Self {
            flipped: found.flipped,
            overlapping_pairs: found.pairs,
            overlapping_area: found.overlapping_area,
            smallest: found
                .smallest
                .map(|(face, signed_area)| SmallestReport { triangle: face.0, signed_area }),
            worst_pair: found
                .worst
                .map(|pair| PairReport { triangles: pair.faces.map(|f| f.0), area: pair.area }),
        }
    }
}

impl EquivalenceReport {
    fn new(report: &ConformalReport) -> Self {
        Self {
            newton_steps: report.newton_steps,
            factorisations: report.factorisations,
            surface_flips: report.surface_flips,
            conformal_flips: report.conformal_flips,
            angle_error: report.angle_error,
            closure: report.closure,
            flipped_before: report.flipped_before,
            points_inserted: report.points_inserted,
            scale_range: report.scale_range,
        }
    }
}

impl SplitReport {
    fn new(layout: &Layout) -> Option<Self> {
        let made = &layout.made;
        (made.charts_added > 0 || made.cut_out > 0).then_some(Self {
            charts_added: made.charts_added,
            length: made.split_length,
            triangles_cut_out: made.cut_out,
        })
    }
}

/// One entry for each patch of a layout.
pub fn patch_reports(layout: &Layout) -> Vec<PatchReport> {
    let mut faces = vec![0; layout.opened.patch_count];
    for &patch in &layout.opened.face_patches {
        faces[patch as usize] += 1;
    }
    let areas = layout.patch_areas();
    let total: f64 = areas.iter().sum();
    layout
        .opened
        .patch_shapes()
        .into_iter()
        .enumerate()
        .map(|(patch, (euler, boundary_loops))| PatchReport {
            faces: faces[patch],
            area: areas[patch] / total,
            euler,
            boundary_loops,
        })
        .collect()
}
