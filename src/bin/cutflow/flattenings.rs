//! `cutflow compare --flattenings`: several flattenings of the same patches side by side, with times. Table 1 of [LPFB] on any mesh.

use cutflow::session::{Compared, ComparisonReport, Problem, cut_from_json, specimen};

use super::compare::CompareArgs;
use super::{clock, open, read, write_json, writes_to_stdout};

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
        rows.push(ComparisonReport::new(&specimen.row(method, &charts), seconds));
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
