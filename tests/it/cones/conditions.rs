//! The conditions of the optimum on surfaces of all kinds, and what must not matter.

use std::f64::consts::{PI, TAU};

use cutflow::mesh::VertexId;
use cutflow::methods::cones::{
    Cone, ConeBoundary, ConeConflict, ConeError, ConeMethod, feature_size_weights,
};
use cutflow::methods::flow::SolveError;

use super::*;

/// Solves in both ways, checks both against the conditions, compares them, and gives one.
fn solved_twice(
    (mesh, geometry): &(Mesh, Geometry),
    params: &ConeParams,
    fields: &ConeFields,
) -> ConeState {
    let mut states = Vec::new();
    for method in [ConeMethod::Greens, ConeMethod::Newton] {
        let mut flow = flow(mesh, geometry, &ConeParams { method, ..*params }, fields);
        let state = solve(&mut flow).clone();
        check(mesh, geometry, params, fields, &state);
        states.push(state);
    }
    let places = |s: &ConeState| s.cones.iter().map(|c| c.vertex).collect::<Vec<_>>();
    assert_eq!(places(&states[0]), places(&states[1]), "{params:?}");
    assert!((states[0].int_u2 - states[1].int_u2).abs() <= 1e-7 * states[0].int_u2 + 1e-15);
    assert!((states[0].total_angle - states[1].total_angle).abs() < 1e-7);
    states.remove(0)
}

fn build((positions, triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>)) -> (Mesh, Geometry) {
    unit(&positions, &triangles)
}

const MODES: [ConeBoundary; 5] = [
    ConeBoundary::Isometric,
    ConeBoundary::Optimal,
    ConeBoundary::Polygonal,
    ConeBoundary::Convex,
    ConeBoundary::PolygonalConvex,
];

#[test]
fn both_solvers_meet_the_conditions_in_every_boundary_mode_with_and_without_bounds() {
    let surface = build(sheet(12));
    for boundary in MODES {
        for bounds in [[f64::NEG_INFINITY, f64::INFINITY], [-0.2, 0.5], [0.0, f64::INFINITY]] {
            let params = ConeParams { boundary, bounds, ..at(0.003) };
            let state = solved_twice(&surface, &params, &ConeFields::default());
            assert!(!state.cones.is_empty());
            if boundary == ConeBoundary::Convex || boundary == ConeBoundary::PolygonalConvex {
                let sum: f64 = state.cones.iter().chain(&state.corners).map(|c| c.angle).sum();
                assert!((sum - TAU).abs() < 1e-9, "the flat disk turns once");
            }
        }
    }
}

#[test]
fn closed_open_and_convex_parts_are_solved_side_by_side() {
    let (positions, triangles) = both(both(sheet(9), blob(5)), both(ring(12, 20), sheet(6)));
    let sphere = cutflow::session::samples::icosphere(3);
    let sphere = (
        sphere.positions.clone(),
        (0..sphere.polygon_count()).map(|i| sphere.polygon(i).try_into().unwrap()).collect(),
    );
    let surface = build(both(
        (positions.iter().map(|p| [p[0], p[1] + 9.0, p[2]]).collect(), triangles),
        sphere,
    ));
    for boundary in MODES {
        let params = ConeParams { boundary, ..at(5e-5) };
        let state = solved_twice(&surface, &params, &ConeFields::default());
        assert!(!state.is_convex, "only one of the parts is");
        // Every vertex of the sphere is a cone of its own curvature.
        assert!(
            state
                .cones
                .iter()
                .filter(|c| c.vertex.index() >= surface.0.vertex_count() - 92)
                .count()
                == 92
        );
    }
}

#[test]
fn weights_exclusions_free_and_fixed_cones_keep_the_conditions() {
    for surface in [build(sheet(10)), build(blob(6)), build(ring(14, 30))] {
        let (mesh, geometry) = &surface;
        let n = mesh.vertex_count();
        let lambda = price(mesh, geometry, 0.1);
        let wave = |v: usize, k: f64| 1.0 + 0.8 * (k * geometry.positions[v].x * 9.0).sin();
        let distortion_weight: Vec<f64> = (0..n).map(|v| wave(v, 1.0)).collect();
        let cone_cost: Vec<f64> = (0..n).map(|v| wave(v, -0.7)).collect();
        let excluded: Vec<bool> = (0..n).map(|v| geometry.positions[v].y > 0.1).collect();
        let inside: Vec<VertexId> = mesh
            .vertices()
            .filter(|&v| !mesh.is_boundary_vertex(v) && !excluded[v.index()])
            .collect();
        let fields = [
            ConeFields { distortion_weight: distortion_weight.clone(), ..ConeFields::default() },
            ConeFields { cone_cost: cone_cost.clone(), ..ConeFields::default() },
            ConeFields { excluded: excluded.clone(), ..ConeFields::default() },
            ConeFields { free: vec![inside[3], inside[40]], ..ConeFields::default() },
            ConeFields {
                fixed: vec![(inside[7], 0.5), (inside[50], -0.25)],
                ..ConeFields::default()
            },
            ConeFields {
                distortion_weight,
                cone_cost,
                excluded,
                free: vec![inside[11]],
                fixed: vec![(inside[30], PI / 2.0)],
            },
        ];
        for fields in &fields {
            let state = solved_twice(&surface, &at(lambda), fields);
            for &(vertex, angle) in &fields.fixed {
                assert!(state.cones.contains(&Cone { vertex, angle }));
            }
            let is_out = |c: &Cone| fields.excluded.get(c.vertex.index()) == Some(&true);
            assert!(!state.cones.iter().any(is_out));
        }
        let (distortion_weight, cone_cost) = feature_size_weights(mesh, geometry, 0.5);
        let logs: f64 = distortion_weight.iter().map(|w| w.ln()).sum();
        assert!(logs.abs() < 1e-9 * n as f64, "the geometric mean is 1");
        let fields = ConeFields { distortion_weight, cone_cost, ..ConeFields::default() };
        solved_twice(&surface, &at(lambda), &fields);
    }
}

#[test]
fn a_hemisphere_without_cones_shrinks_to_half_at_its_pole() {
    let lift = |x: f64, y: f64| {
        let (r, angle) = (x.hypot(y), y.atan2(x));
        let polar = r * PI / 2.0;
        [polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()]
    };
    let (mesh, geometry) = build(disk(30, lift));
    let mut flow = flow(&mesh, &geometry, &at(0.07), &ConeFields::default());
    assert!((flow.lambda_max() - 0.0589).abs() < 3e-4, "{}", flow.lambda_max());
    let state = solve(&mut flow);
    assert!(state.cones.is_empty());
    // The triangles are an 80th of the radius: second order leaves 1e-3.
    let least = state.u.iter().copied().fold(0.0, f64::min);
    let most = state.u.iter().copied().fold(0.0, f64::max);
    assert!((most - 2f64.ln()).abs() < 2e-3 || (least + 2f64.ln()).abs() < 2e-3, "{least} {most}");
    assert!((state.int_u2 - 0.188317).abs() < 1e-3, "{}", state.int_u2);
}

#[test]
fn a_convex_closed_surface_is_its_own_cones_and_a_free_cone_changes_that() {
    let (mesh, geometry) = build({
        let sphere = cutflow::session::samples::icosphere(6);
        let triangles =
            (0..sphere.polygon_count()).map(|i| sphere.polygon(i).try_into().unwrap()).collect();
        (sphere.positions.clone(), triangles)
    });
    let mut all = flow(&mesh, &geometry, &at(0.01), &ConeFields::default());
    let state = solve(&mut all);
    assert!(state.is_convex && state.cones.len() == mesh.vertex_count());
    assert!(state.int_u2 < 1e-20 && (state.total_angle - 2.0 * TAU).abs() < 1e-9);
    let fields = ConeFields { free: vec![VertexId(0)], ..ConeFields::default() };
    let surface = (mesh, geometry);
    let state = solved_twice(&surface, &at(0.01), &fields);
    let (mesh, _) = &surface;
    assert!(!state.is_convex && state.cones.len() < mesh.vertex_count());
    let free = state.cones.iter().find(|c| c.vertex.0 == 0).unwrap().angle;
    assert!(free > PI && free < TAU, "{free}");
}

#[test]
fn a_torus_needs_no_cones_above_its_price_and_cones_of_sum_zero_below() {
    let (mesh, geometry) = build(ring(20, 40));
    let mut flow = flow(&mesh, &geometry, &at(1.0), &ConeFields::default());
    let most = flow.lambda_max();
    for (factor, has_cones) in [(1.001, false), (0.999, true), (0.2, true)] {
        flow.set_lambda(factor * most).unwrap();
        let state = solve(&mut flow).clone();
        check(&mesh, &geometry, &at(factor * most), &ConeFields::default(), &state);
        assert_eq!(!state.cones.is_empty(), has_cones, "{factor}");
        let sum: f64 = state.cones.iter().map(|c| c.angle).sum();
        assert!(sum.abs() < 1e-9);
    }
}

#[test]
fn the_price_from_which_on_a_closed_surface_keeps_its_cones_is_found_and_nothing_else_changes() {
    let (mesh, geometry) = build(blob(8));
    let mut flow = flow(&mesh, &geometry, &at(1e-3), &ConeFields::default());
    assert!(!flow.knows_lambda_max(), "without an optimum it is an estimate");
    let before = solve(&mut flow).clone();
    let most = flow.find_lambda_max().unwrap();
    assert!(flow.knows_lambda_max());
    assert_eq!(*flow.state(), before);
    flow.set_lambda(1.001 * most).unwrap();
    let saturated = solve(&mut flow).total_angle;
    assert!((saturated - 4.0 * PI).abs() < 1e-9, "{saturated}");
    flow.set_lambda(0.99 * most).unwrap();
    assert!(solve(&mut flow).total_angle > saturated + 1e-6);
}

#[test]
fn scale_motion_and_numbering_do_not_matter() {
    for (positions, triangles) in [sheet(10), blob(6)] {
        let mesh = Mesh::new(positions.len(), &triangles).unwrap();
        let as_it_is = |p: &[f64; 3]| nalgebra::Point3::from(*p);
        let geometry = Geometry::new(&mesh, positions.iter().map(as_it_is).collect()).unwrap();
        let (unit_mesh, unit_geometry) = unit(&positions, &triangles);
        let params = at(price(&unit_mesh, &unit_geometry, 0.2) * geometry.total_area());
        let mut first = flow(&mesh, &geometry, &params, &ConeFields::default());
        let first = solve(&mut first).clone();
        for scale in [1e-3, 1.0, 1e3] {
            // Turned, moved, scaled, and numbered backwards.
            let n = positions.len() as u32;
            let turned = positions.iter().rev().map(|p| {
                let (s, c) = 0.7f64.sin_cos();
                nalgebra::Point3::new(c * p[0] - s * p[1] + 2.0, s * p[0] + c * p[1], p[2] - 1.0)
                    * scale
            });
            let numbered: Vec<[u32; 3]> =
                triangles.iter().rev().map(|t| t.map(|v| n - 1 - v)).collect();
            let mesh = Mesh::new(positions.len(), &numbered).unwrap();
            let geometry = Geometry::new(&mesh, turned.collect()).unwrap();
            let params = at(params.lambda * scale * scale);
            let mut other = flow(&mesh, &geometry, &params, &ConeFields::default());
            let other = solve(&mut other);
            assert_eq!(first.cones.len(), other.cones.len());
            for (a, b) in first.cones.iter().zip(other.cones.iter().rev()) {
                assert_eq!(a.vertex.0, n - 1 - b.vertex.0);
                // Rounding of positions (1e-16 of the offset), times the condition of the angles.
                assert!((a.angle - b.angle).abs() < 1e-7, "{} {}", a.angle, b.angle);
            }
            assert!(close(other.int_u2, first.int_u2 * scale * scale, 1e-8));
        }
    }
}

#[test]
fn what_cannot_be_is_refused_with_numbers() {
    let (mesh, geometry) = build(blob(4));
    let new = |params: &ConeParams, fields: &ConeFields| {
        ConeFlow::new(&mesh, &geometry, params, fields).err()
    };
    let none = ConeFields::default();
    for lambda in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(new(&at(lambda), &none), Some(SolveError::Parameter { .. })));
    }
    let tight = ConeParams { bounds: [-1.0, 0.01], ..at(0.01) };
    let Some(SolveError::Cones(ConeError::OutOfBounds { needed, most, .. })) = new(&tight, &none)
    else {
        panic!("162 cones of .01 are less than 4π");
    };
    assert!((needed - 2.0 * TAU).abs() < 1e-9 && (most - 1.62).abs() < 1e-9);
    let conflict =
        |fields: ConeFields, bounds| match new(&ConeParams { bounds, ..at(0.01) }, &fields) {
            Some(SolveError::Cones(ConeError::Conflict { vertex, conflict, .. })) => {
                Some((vertex.0, conflict))
            }
            _ => None,
        };
    let free = [f64::NEG_INFINITY, f64::INFINITY];
    let fixed = |list: &[(u32, f64)]| ConeFields {
        fixed: list.iter().map(|&(v, a)| (VertexId(v), a)).collect(),
        ..ConeFields::default()
    };
    assert_eq!(conflict(fixed(&[(3, 1.0), (3, 1.0)]), free), Some((3, ConeConflict::Twice)));
    assert_eq!(conflict(fixed(&[(5, 2.0)]), [-1.0, 1.0]), Some((5, ConeConflict::Bounds)));
    let mut excluded = fixed(&[(7, 1.0)]);
    excluded.excluded = (0..mesh.vertex_count()).map(|v| v == 7).collect();
    assert_eq!(conflict(excluded, free), Some((7, ConeConflict::Excluded)));
    let short = ConeFields { cone_cost: vec![1.0; 3], ..ConeFields::default() };
    assert!(matches!(
        new(&at(0.01), &short),
        Some(SolveError::Cones(ConeError::FieldLength { given: 3, .. }))
    ));
    let (mesh, geometry) = build(sheet(4));
    let rim = mesh.vertices().find(|&v| mesh.is_boundary_vertex(v)).unwrap();
    let on_rim = ConeFields { fixed: vec![(rim, 1.0)], ..ConeFields::default() };
    assert!(matches!(
        ConeFlow::new(&mesh, &geometry, &at(0.01), &on_rim).err(),
        Some(SolveError::Cones(ConeError::Conflict { conflict: ConeConflict::Boundary, .. }))
    ));
}

#[test]
fn other_triangles_noise_and_spikes_leave_cones_where_they_are() {
    // Angle near each hill, and where its centre is.
    let look = |(positions, triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>)| {
        let (mesh, geometry) = unit(&positions, &triangles);
        let mut flow = flow(&mesh, &geometry, &at(0.004), &ConeFields::default());
        let state = solve(&mut flow).clone();
        [[0.35, 0.2], [-0.4, 0.1]].map(|hill| {
            let (mut angle, mut centre) = (0.0, [0.0; 2]);
            for cone in &state.cones {
                let p = positions[cone.vertex.index()];
                if (p[0] - hill[0]).hypot(p[1] - hill[1]) < 0.15 && cone.angle > 0.0 {
                    angle += cone.angle;
                    centre = [centre[0] + cone.angle * p[0], centre[1] + cone.angle * p[1]];
                }
            }
            (angle, centre.map(|x| x / angle))
        })
    };
    let place = |x: f64, y: f64| [x, y, hills(x, y)];
    let noise =
        |x: f64, y: f64| 0.003 * ((x * 917.3).sin() * 43.7 + (y * 611.9).sin() * 91.1).sin();
    let mut spiky = sheet(24);
    for v in [300, 700, 1100] {
        spiky.0[v][2] += 0.05;
    }
    let expected = look(sheet(40));
    for (name, other) in [
        ("coarse", sheet(20)),
        ("noisy", disk(30, |x, y| [x, y, hills(x, y) + noise(x, y)])),
        ("stretched", disk(30, |x, y| place(x, y * y.abs().powf(0.6)))),
        (
            "uneven",
            disk(36, |x, y| place(x * (0.4 + 0.6 * x.hypot(y)), y * (0.4 + 0.6 * x.hypot(y)))),
        ),
        ("spiky", spiky),
    ] {
        for (a, b) in expected.iter().zip(look(other)) {
            let off = (a.1[0] - b.1[0]).hypot(a.1[1] - b.1[1]);
            // An edge is .03 to .07 long; noise also takes some of the angle.
            assert!(off < 0.05, "{name}: cones moved by {off}");
            assert!((a.0 - b.0).abs() < 0.15 * a.0, "{name}: {} {}", a.0, b.0);
        }
    }
}
