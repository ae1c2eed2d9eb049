//! `cutflow compare`: several flattenings of the same patches side by side, with times. Table 1 of [LPFB] on any mesh.

use std::path::PathBuf;

use clap::Args;
use cutflow::session::{Compared, ComparisonRow, Problem, cut_from_json, specimen};
use serde::Serialize;

use super::{MeshArgs, Report, clock, open, read, write_json, writes_to_stdout};

#[derive(Args)]
pub struct CompareArgs {
    #[command(flatten)]
    mesh: MeshArgs,
    /// A cut.json. Without it the surface is taken as it is: it needs a boundary then.
    #[arg(long, value_name = "FILE")]
    cut: Option<PathBuf>,
    #[command(flatten)]
    pub report: Report,
}

/// A row of the table.
#[derive(Serialize)]
struct Row {
    method: &'static str,
    faces: usize,
    rim_sides: usize,
    /// Mean error of a rim side's length, over their mean length.
    length_error: f64,
    /// Mean error of a rim corner's angle, radians.
    angle_error: f64,
    area_change: f64,
    area_change_abs: f64,
    l2_stretch: f64,
    l2_stretch_normalized: f64,
    flipped: usize,
    overlaps: usize,
    seconds: f64,
}

impl Row {
    fn new(row: &ComparisonRow, seconds: f64) -> Self {
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

pub fn run(args: &CompareArgs) -> Result<(), Problem> {
    let document = open(&args.mesh)?;
    let surface = document.surface()?;
    let cut = match &args.cut {
        None => None,
        Some(path) => Some(cut_from_json(surface, &path.display().to_string(), &read(path)?)?),
    };
    let specimen = specimen(surface, cut)?;
    let mut rows = Vec::new();
    for method in Compared::ALL {
        let clock = clock();
        let charts = method
            .flatten(&specimen)
            .map_err(|error| Problem::solve(&document.name, &error.into()))?;
        let seconds = clock.elapsed().as_secs_f64();
        rows.push(Row::new(&specimen.row(method, &charts), seconds));
    }
    if !writes_to_stdout(&args.report) {
        say!(
            "{:16} {:>9} {:>9} {:>9} {:>9} {:>8} {:>8} {:>6} {:>8} {:>9}",
            "",
            "length",
            "angle",
            "area",
            "|area|",
            "L²",
            "L² norm",
            "flips",
            "overlaps",
            "seconds"
        );
        for row in &rows {
            say!(
                "{:16} {:9.2e} {:9.2e} {:8.3}% {:8.3}% {:8.4} {:8.4} {:6} {:8} {:9.4}",
                row.method,
                row.length_error,
                row.angle_error,
                100.0 * row.area_change,
                100.0 * row.area_change_abs,
                row.l2_stretch,
                row.l2_stretch_normalized,
                row.flipped,
                row.overlaps,
                row.seconds
            );
        }
    }
    write_json(&args.report, &rows)
}
