//! Cones as the page reads them.

use serde::Serialize;

/// Cones and their certificate. Angles in radians, lengths for a surface of unit area.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ConeTable {
    /// Price of angle.
    pub lambda: f64,
    /// From here on a higher price changes nothing.
    pub lambda_max: f64,
    /// Whether that is more than an estimate.
    pub is_lambda_max_exact: bool,
    /// Whether cones were changed by hand after the optimum.
    pub is_edited: bool,
    /// Whether an exact number of cones was put where local search found them to do most: no price led to them.
    pub is_placed: bool,
    /// Whether the optimum was asked for with cones that were placed by hand.
    pub has_placed: bool,
    /// Vertices that are cones in the optimum.
    pub raw_count: usize,
    /// ∫u² of the optimum.
    pub raw_int_u2: f64,
    /// ∫u² with the cones below.
    pub int_u2: f64,
    /// Σ|angle| of the cones below.
    pub total_angle: f64,
    /// How far the optimum is from its conditions, relative.
    pub kkt_residual: f64,
    /// Primal minus dual value, relative.
    pub gap: f64,
    /// Cones as they are used.
    pub cones: Vec<ConeRow>,
    /// What a person should know of them.
    pub note: Option<String>,
}

/// A cone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConeRow {
    /// Its number.
    pub cone: usize,
    /// Index in the input file.
    pub vertex: u32,
    /// In the scene.
    pub place: [f64; 3],
    /// Curvature that is gathered there, radians.
    pub angle: f64,
    /// `optimal`, `merged` (of several vertices), `corner` (of the flattened boundary), `placed` (of an exact number), or by hand `free`, `moved` or `fixed`.
    pub kind: &'static str,
    /// Vertices of the optimum that it stands for.
    pub members: usize,
    /// The cone that it mirrors, if there is one.
    pub partner: Option<usize>,
}

/// The optimum for one λ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ConePathPoint {
    /// Price of angle.
    pub lambda: f64,
    /// Cones.
    pub count: usize,
    /// Σ|angle|, radians.
    pub total_angle: f64,
    /// ∫u².
    pub int_u2: f64,
}

/// One way to choose cones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ConeComparisonRow {
    /// What it is.
    pub label: String,
    /// Cones.
    pub count: usize,
    /// Σ|angle|, radians.
    pub total_angle: f64,
    /// ∫u².
    pub int_u2: f64,
    /// √(∫u² / area).
    pub rms_u: f64,
    /// Largest |u|.
    pub max_abs_u: f64,
    /// Mean σ₁/σ₂ of the charts, where they were made.
    pub chart_angle: Option<f64>,
    /// RMS of the charts' log scale, where they were made.
    pub chart_area: Option<f64>,
}
