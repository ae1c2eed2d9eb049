//! Rows of the table in the notes: cones on real surfaces.

use super::*;

/// Price, whether clusters are merged, steps, and whether faces end on their backs before the repair.
type Row = (f64, bool, usize, bool);

/// Every claim about charts of a surface with cones, from coordinates alone.
fn check(name: &str, surface: &Surface, cones: &[Cone], found: &Conformal) {
    let report = &found.report;
    assert!(report.angle_error < 1e-10 && report.degenerate == 0, "{name} {report:?}");
    assert!(report.closure < 1e-10, "{name} {report:?}");
    assert!(found.flattening.seams_equal && found.flattening.angles_exact);
    // One factorisation to a step, and as many again would be shifts of a matrix that is not positive definite.
    assert!(2 * report.factorisations <= 3 * report.newton_steps, "{name} {report:?}");
    check_charts(found, 0);
    let mut wanted = vec![TAU; found.cut.points.len()];
    for cone in cones {
        wanted[cone.vertex.index()] -= cone.angle;
    }
    for (p, (sum, wanted)) in angle_sums(found).into_iter().zip(wanted).enumerate() {
        if p < surface.mesh.vertex_count() && surface.mesh.is_boundary_vertex(VertexId(p as u32)) {
            continue;
        }
        // Angles of thin triangles from coordinates: 1e-15 of the diameter over edges of a thousandth of a thousandth.
        assert!((sum - wanted).abs() < 1e-8, "{name} point {p}: {sum} {wanted}");
    }
    assert_eq!(found.cut.points.len() - surface.mesh.vertex_count(), report.points_inserted);
    for (&point, &place) in found.cut.points.iter().zip(&found.positions) {
        assert!((surface.geometry.locate(&surface.mesh, point) - place).norm() < 1e-14);
    }
}

fn check_rows(name: &str, rows: &[Row]) {
    let Some(surface) = Surface::shared(name) else { return };
    for &(lambda, merged, steps, has_flips) in rows {
        let cones = cones_of(&surface, lambda, merged);
        let found = with_cones(&surface, &cones, &RimCondition::Isometric);
        check(name, &surface, &cones, &found);
        let report = &found.report;
        // Which cones are merged where may differ from the notes: a step more or less.
        assert!(report.newton_steps.abs_diff(steps) <= 1, "{name} {lambda} {report:?}");
        assert_eq!(report.flipped_before > 0, has_flips, "{name} {lambda} {report:?}");
        assert_eq!(report.points_inserted > 0, has_flips, "{name} {lambda} {report:?}");
    }
}

#[test]
fn rows_of_spot_come_out() {
    check_rows(
        "spot.obj",
        &[(0.01, false, 4, false), (0.01, true, 5, false), (0.001, true, 6, false)],
    );
}

#[test]
fn rows_of_cheburashka_come_out_and_faces_on_their_backs_are_turned_over() {
    check_rows("cheburashka.obj", &[(0.01, true, 7, true), (0.00042, true, 6, true)]);
}

#[test]
fn rows_with_a_boundary_and_with_a_handle_come_out() {
    check_rows("face.obj", &[(0.001, true, 6, false)]);
    check_rows("rocker-arm.obj", &[(0.001, true, 6, false)]);
}

#[test]
fn a_rectangle_of_a_face_has_four_right_angles_and_straight_sides() {
    let Some(surface) = Surface::shared("face.obj") else { return };
    let mesh = &surface.mesh;
    let rim: Vec<VertexId> =
        mesh.boundary_loop(mesh.boundary_loops()[0]).map(|h| mesh.tail(h)).collect();
    let mut turns = vec![0.0; mesh.vertex_count()];
    for k in 0..4 {
        turns[rim[k * rim.len() / 4].index()] = FRAC_PI_2;
    }
    let found = with_cones(&surface, &[], &RimCondition::ExteriorAngles(turns.clone()));
    check(&surface.name, &surface, &[], &found);
    assert!(found.report.newton_steps <= 6, "{:?}", found.report);
    let outline = found.flattening.outline(&found.opened, 0);
    for (turn, h) in turning(&outline).into_iter().zip(found.flattening.charts[0].as_ref().unwrap())
    {
        let wanted = turns[found.opened.mesh.tail(*h).index()];
        // The ragged boundary has edges of 1e-4 of the diameter.
        assert!((turn - wanted).abs() < 1e-9, "{turn} {wanted}");
    }
    // Free in size: as large as the surface, whose area is 1.
    let area: f64 = shoelace(&outline);
    assert!((area - 1.0).abs() < 1e-9, "{area}");
}

/// Cones of 4π and 6π at vertices beside the boundary, compensated nowhere: the boundary has to bend.
#[test]
fn strong_cones_beside_a_boundary_are_solved_with_the_mirror_image() {
    let Some(surface) = Surface::shared("face.obj") else { return };
    let mesh = &surface.mesh;
    let rim: Vec<VertexId> =
        mesh.boundary_loop(mesh.boundary_loops()[0]).map(|h| mesh.tail(h)).collect();
    let cones: Vec<Cone> = (0..9)
        .filter_map(|k| {
            let v = rim[k * rim.len() / 9];
            let inner = |v: &VertexId| !mesh.is_boundary_vertex(*v);
            let vertex = mesh.outgoing(v).map(|h| mesh.tip(h)).find(inner)?;
            Some(Cone { vertex, angle: if k % 2 == 0 { -TAU } else { -2.0 * TAU } })
        })
        .collect();
    assert!(cones.len() >= 7);
    let found = with_cones(&surface, &cones, &RimCondition::Isometric);
    let report = &found.report;
    assert_eq!((report.doubled, report.degenerate), (1, 0), "{report:?}");
    assert!(report.angle_error < 1e-10 && report.closure < 1e-10, "{report:?}");
    assert!(found.flattening.charts[0].is_ok() && report.flipped_after == 0, "{report:?}");
}

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
        ("bunny-closed.obj", 0.0005, false),
        ("bunny-closed.obj", 0.0005, true),
        ("face.obj", 0.01, false),
        ("face.obj", 0.001, false),
        ("face.obj", 0.001, true),
        ("rocker-arm.obj", 0.001, true),
        ("stanford-bunny.obj", 0.002, true),
        ("armadillo.obj", 0.002, true),
    ] {
        let Some(surface) = Surface::shared(name) else { return };
        let cones = cones_of(&surface, lambda, merged);
        let found = with_cones(&surface, &cones, &RimCondition::Isometric);
        print(&format!("{name} {lambda} {merged} {}", cones.len()), &found);
        check(name, &surface, &cones, &found);
        assert!(found.report.newton_steps <= 8);
    }
}

#[test]
#[ignore = "cones that nobody would ask for, for the figures"]
fn extreme_rows() {
    for (name, sharp) in
        [("spot.obj", 40), ("cheburashka.obj", 40), ("fandisk.obj", 30), ("homer.obj", 12)]
    {
        let Some(surface) = Surface::shared(name) else { return };
        let n = surface.mesh.vertex_count();
        let mut state = 12345u64;
        let mut taken = vec![false; n];
        let mut draw = || loop {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let v = (state >> 33) as usize % n;
            if !std::mem::replace(&mut taken[v], true) {
                return VertexId(v as u32);
            }
        };
        let mut cones: Vec<Cone> =
            (0..sharp).map(|_| Cone { vertex: draw(), angle: 1.9 * PI }).collect();
        let rest = (4.0 * PI - 1.9 * PI * f64::from(sharp)) / f64::from(sharp);
        cones.extend((0..sharp).map(|_| Cone { vertex: draw(), angle: rest }));
        let found = with_cones(&surface, &cones, &RimCondition::Isometric);
        print(&format!("{name} {}", cones.len()), &found);
    }
}
