//! The table of the notes.

use super::*;

#[test]
#[ignore = "all rows of the table, for the figures"]
fn the_whole_table() {
    for (name, lambda, merged) in [
        ("spot.obj", 0.01, false),
        ("spot.obj", 0.01, true),
        ("spot.obj", 0.001, false),
        ("spot.obj", 0.001, true),
        ("cheburashka.obj", 0.01, false),
        ("cheburashka.obj", 0.01, true),
        ("cheburashka.obj", 0.00042, false),
        ("cheburashka.obj", 0.00042, true),
        ("bunny-closed.obj", 0.005, false),
        ("bunny-closed.obj", 0.005, true),
        ("bunny-closed.obj", 0.0005, true),
        ("face.obj", 0.01, false),
        ("face.obj", 0.001, true),
        ("rocker-arm.obj", 0.001, true),
        ("stanford-bunny.obj", 0.002, true),
        ("armadillo.obj", 0.002, true),
    ] {
        let Some(surface) = Surface::shared(name) else { return };
        let cones = cones_of(&surface, lambda, merged);
        let at = std::time::Instant::now();
        let found = with_cones(&surface, &cones, &RimCondition::Isometric);
        let r = &found.report;
        let positions =
            found.opened.vertex_points.iter().map(|&p| found.positions[p as usize]).collect();
        let geometry = Geometry::measure(&found.opened.mesh, positions);
        let measures = measure(&found.opened, &geometry, &found.flattening);
        println!(
            "{name} {lambda} {merged} n {} C/pi {:.2}..{:.2} steps {} fact {} ana {} rej {} flips {}+{} err {:.1e} deg {} clos {:.1e} part {:.1e} flipped {} {} ins {} rounds {} v {:.2?} dbl {} QC {:.4} {:.2} ms {} {:?}",
            cones.len(),
            cones.iter().map(|c| c.angle / PI).fold(9.0, f64::min),
            cones.iter().map(|c| c.angle / PI).fold(-9.0, f64::max),
            r.newton_steps,
            r.factorisations,
            r.analyses,
            r.rejected,
            r.surface_flips,
            r.conformal_flips,
            r.angle_error,
            r.degenerate,
            r.closure,
            r.partner_mismatch,
            r.flipped_before,
            r.flipped_after,
            r.points_inserted,
            r.rounds,
            r.scale_range,
            r.doubled,
            measures.totals.angle_distortion,
            measures.totals.angle_distortion_max,
            at.elapsed().as_millis(),
            found.flattening.charts.iter().map(|c| c.is_ok()).collect::<Vec<_>>(),
        );
    }
}
