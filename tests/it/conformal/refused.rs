//! What no flat surface has: refused before the start, with the number that is wrong.

use super::*;

fn attempt(
    surface: &Surface,
    cut: &CutMesh,
    cones: &[Cone],
    rim: &RimCondition,
) -> Result<Conformal, ConformalError> {
    let params = ConformalParams::default();
    conformal_with_cones(&surface.mesh, cut, &surface.geometry.positions, cones, rim, &params)
}

fn cone(vertex: u32, angle: f64) -> Cone {
    Cone { vertex: VertexId(vertex), angle }
}

#[test]
fn cones_that_do_not_add_up_are_refused_with_what_is_missing() {
    let ball = Surface::sphere(4);
    let vertices = [0, 20, 80].map(VertexId);
    let seams = cut_through(&ball.mesh, &ball.geometry, &vertices, &[]).unwrap();
    let free = RimCondition::Isometric;
    let cones = [cone(0, PI), cone(20, PI), cone(80, PI)];
    let error = attempt(&ball, &seams.cut, &cones, &free).unwrap_err();
    let ConformalError::GaussBonnet { total, needed, .. } = error else { panic!("{error}") };
    assert!((total - 3.0 * PI).abs() < 1e-12 && (needed - 4.0 * PI).abs() < 1e-12);
    assert!(error.to_string().contains("too small"), "{error}");
    // A few digits are rounding and are shared out.
    let third = 4.0 * PI / 3.0;
    let cones = [cone(0, third), cone(20, third), cone(80, third - 1e-8)];
    let found = attempt(&ball, &seams.cut, &cones, &free).unwrap();
    assert!(found.report.angle_error < 1e-10 && found.flattening.charts[0].is_ok());
    check_charts(&found, 0);
    // Equilateral cones, free in size: as large as the surface.
    let area = shoelace(&found.flattening.outline(&found.opened, 0));
    assert!((area - 1.0).abs() < 1e-9, "{area}");
}

#[test]
fn a_cone_of_a_whole_turn_is_refused_and_capped_cones_are_not() {
    let ball = Surface::sphere(4);
    let sharp = [cone(0, TAU), cone(20, PI), cone(80, PI)];
    let vertices = sharp.map(|c| c.vertex);
    let seams = cut_through(&ball.mesh, &ball.geometry, &vertices, &[]).unwrap();
    let error = attempt(&ball, &seams.cut, &sharp, &RimCondition::Isometric).unwrap_err();
    let ConformalError::ConeTooSharp { vertex, angle, largest } = error else { panic!("{error}") };
    assert_eq!((vertex, angle, largest), (VertexId(0), TAU, SHARPEST_CONE));

    let capped = cap_cones(&ball.mesh, &ball.geometry, &sharp, SHARPEST_CONE);
    assert_eq!(capped.len(), 4);
    assert!((capped.iter().map(|c| c.angle).sum::<f64>() - 4.0 * PI).abs() < 1e-12);
    let added = capped.iter().find(|c| !vertices.contains(&c.vertex)).unwrap();
    assert!(ball.mesh.outgoing(VertexId(0)).any(|h| ball.mesh.tip(h) == added.vertex));
    let found = with_cones(&ball, &capped, &RimCondition::Isometric);
    assert!(found.report.angle_error < 1e-10, "{:?}", found.report);
    check_charts(&found, 0);
    // What is blunt enough stays.
    assert_eq!(cap_cones(&ball.mesh, &ball.geometry, &sharp[1..], SHARPEST_CONE), sharp[1..]);
}

#[test]
fn cones_off_the_seams_twice_or_nowhere_are_refused() {
    let ball = Surface::sphere(4);
    let seams = cut_through(&ball.mesh, &ball.geometry, &[0, 20].map(VertexId), &[]).unwrap();
    let free = RimCondition::Isometric;
    let refused = |cones: &[Cone]| attempt(&ball, &seams.cut, cones, &free).unwrap_err();
    let off = (0..ball.mesh.vertex_count() as u32)
        .find(|&v| !seams.opened.mesh.is_boundary_vertex(VertexId(v)))
        .unwrap();
    let all = [cone(0, PI), cone(20, PI), cone(off, TAU - 0.1)];
    assert_eq!(refused(&all), ConformalError::ConeOffSeam { vertex: VertexId(off) });
    let twice = [cone(0, PI), cone(0, PI)];
    assert_eq!(refused(&twice), ConformalError::Twice { vertex: VertexId(0) });
    assert!(matches!(refused(&[cone(9999, PI)]), ConformalError::NoSuchVertex { .. }));
    let wrong = RimCondition::LogScales(vec![0.0; 3]);
    let error = attempt(&ball, &seams.cut, &[], &wrong).unwrap_err();
    assert!(matches!(error, ConformalError::WrongLength { given: 3, .. }), "{error}");
    let error = attempt(&ball, &seams.cut, &[cone(0, f64::NAN)], &free).unwrap_err();
    assert!(matches!(error, ConformalError::NotFinite { .. }), "{error}");
}

#[test]
fn outlines_that_cannot_be_are_refused() {
    let sheet = Surface::sample("sinusoidal_sheet");
    let cut = CutMesh::uncut(&sheet.mesh);
    let n = sheet.mesh.vertex_count();
    let rim = sheet.mesh.boundary_loops()[0];
    let corner = sheet.mesh.tail(rim);
    let mut turns = vec![0.0; n];
    turns[corner.index()] = PI;
    let angles = RimCondition::ExteriorAngles(turns.clone());
    let error = attempt(&sheet, &cut, &[], &angles).unwrap_err();
    let ConformalError::CornerTooSharp { vertex, angle, largest } = error else {
        panic!("{error}")
    };
    assert!(vertex == corner && angle == PI && largest < PI);
    turns[corner.index()] = 1.0;
    let error = attempt(&sheet, &cut, &[], &RimCondition::ExteriorAngles(turns)).unwrap_err();
    let ConformalError::GaussBonnet { total, needed, .. } = error else { panic!("{error}") };
    assert!((total - 1.0).abs() < 1e-9 && (needed - TAU).abs() < 1e-9);
    let on_rim = [Cone { vertex: corner, angle: 0.5 }];
    let error = attempt(&sheet, &cut, &on_rim, &RimCondition::Isometric).unwrap_err();
    assert_eq!(error, ConformalError::ConeOnBoundary { vertex: corner });
}

#[test]
fn a_surface_beyond_all_digits_says_how_far_it_got() {
    let Some(surface) = Surface::shared("bad/anisotropic.obj") else { return };
    let n = surface.mesh.vertex_count() as u32;
    let cones = [0, n / 4, n / 2, 3 * n / 4].map(|v| cone(v, PI));
    let vertices = cones.map(|c| c.vertex);
    let seams = cut_through(&surface.mesh, &surface.geometry, &vertices, &[]).unwrap();
    let found = attempt(&surface, &seams.cut, &cones, &RimCondition::Isometric).unwrap();
    match found.flattening.charts[0] {
        // 1e8 : 1 in side lengths: no digit of some angles is known.
        Err(NoChart::NotConverged { angle_error }) => assert!(angle_error > 1e-10),
        Err(reason) => panic!("{reason}"),
        Ok(_) => assert!(found.report.angle_error < 1e-8),
    }
}
