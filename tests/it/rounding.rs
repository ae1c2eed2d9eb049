//! What becomes of optimal cones: clusters rounded, angles debiased, cones placed greedily for comparison and edited by hand.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use cutflow::geometry::{Geometry, angle_defects, polygon};
use cutflow::mesh::read::obj;
use cutflow::mesh::{Mesh, Soup, VertexId};
use cutflow::methods::cones::{
    Cone, ConeConflict, ConeEdit, ConeError, ConeFields, ConeFlow, ConeParams, EditError,
    PlacedCone, RoundParams, debias, edit_cones, greedy_cones, round_clusters,
};
use cutflow::methods::flow::{Flow, SolveError, Status};

use crate::surfaces::{Surface, cylinder};

fn flow(surface: &Surface, lambda: f64) -> ConeFlow {
    let params = ConeParams { lambda, ..ConeParams::default() };
    let mut flow =
        ConeFlow::new(&surface.mesh, &surface.geometry, &params, &ConeFields::default()).unwrap();
    for _ in 0..300 {
        if flow.status() != Status::Running {
            break;
        }
        flow.step().unwrap();
    }
    assert_eq!(flow.status(), Status::Converged);
    flow
}

/// A mesh of the shared folder with its vertices numbered as in the file.
fn numbered(name: &str) -> Option<Surface> {
    // Says so where it is absent.
    Surface::shared(name)?;
    let path = format!("{}/../shared/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    let soup = obj::read(&std::fs::read(path).unwrap()).unwrap().soup;
    let mut triangles = Vec::new();
    for i in 0..soup.polygon_count() {
        polygon::triangulate(&soup.positions, soup.polygon(i), &mut triangles);
    }
    let mesh = Mesh::new(soup.positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &soup.positions).unwrap();
    Some(Surface { name: name.to_owned(), mesh, geometry })
}

fn sum(cones: &[Cone]) -> f64 {
    cones.iter().map(|c| c.angle).sum()
}

/// A flat sheet of n × n squares of side 1 / n; vertex (i, j) is number i (n + 1) + j.
fn sheet(n: u32) -> Surface {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            positions.push([f64::from(i) / f64::from(n), f64::from(j) / f64::from(n), 0.0]);
            if i < n && j < n {
                let [a, b] = [i * (n + 1) + j, (i + 1) * (n + 1) + j];
                triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
            }
        }
    }
    let mesh = Mesh::new(positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &positions).unwrap();
    Surface { name: "sheet".into(), mesh, geometry }
}

fn at(n: u32, i: u32, j: u32) -> VertexId {
    VertexId(i * (n + 1) + j)
}

#[test]
fn clusters_become_few_cones_at_their_vertices_and_the_sum_stays() {
    let mut merged = 0;
    for (name, lambda) in
        [("plush_bear", 0.003), ("double_torus", 0.003), ("sinusoidal_sheet", 0.002)]
    {
        let surface = Surface::sample(name);
        let mut flow = flow(&surface, lambda);
        let state = flow.state().clone();
        let rounded =
            round_clusters(&surface.mesh, &surface.geometry, &state.cones, &RoundParams::default());
        assert_eq!(rounded.cones.len(), rounded.clusters.len());
        assert!(rounded.cones.is_sorted_by(|a, b| a.vertex < b.vertex));
        assert!((sum(&rounded.cones) - sum(&state.cones)).abs() < 1e-12, "{name}");
        let angle = |v: &VertexId| state.cones.iter().find(|c| c.vertex == *v).unwrap().angle;
        let mut seen = Vec::new();
        for (cone, members) in rounded.cones.iter().zip(&rounded.clusters) {
            assert!(members.contains(&cone.vertex));
            let total: f64 = members.iter().map(angle).sum();
            assert!((total - cone.angle).abs() < 1e-13, "{name}");
            assert!(members.iter().all(|v| (angle(v) > 0.0) == (cone.angle > 0.0)));
            assert!(cone.angle.abs() < TAU);
            if members.len() > 1 {
                assert!(cone.angle.abs() <= PI);
                merged += members.len();
            }
            seen.extend(members.iter().copied());
        }
        seen.sort_unstable();
        let places: Vec<VertexId> = state.cones.iter().map(|c| c.vertex).collect();
        assert_eq!(seen, places, "{name}: each cone in one cluster");
        // Long clusters at so small a λ cost up to 5 %.
        let e = flow.evaluate(&rounded.cones).unwrap().int_u2;
        assert!(e < state.int_u2 * 1.06, "{name}: {e} {}", state.int_u2);
    }
    assert!(merged > 20, "{merged}");
}

#[test]
fn small_clusters_of_spot_cost_less_than_a_hundredth_and_are_counted_as_in_the_reference() {
    let path = format!("{}/../shared/reference/cones.json", env!("CARGO_MANIFEST_DIR"));
    let Ok(text) = std::fs::read_to_string(path) else {
        eprintln!("skipped: ../shared/reference is not there");
        return;
    };
    let reference: serde_json::Value = serde_json::from_str(&text).unwrap();
    let mut surfaces: Vec<Surface> = Vec::new();
    for case in reference["cases"].as_array().unwrap() {
        let name = case["mesh"].as_str().unwrap();
        if !surfaces.iter().any(|s| s.name == name) {
            let Some(surface) = numbered(name) else { return };
            surfaces.push(surface);
        }
        let surface = surfaces.iter().find(|s| s.name == name).unwrap();
        let cones: Vec<Cone> = case["cones"]
            .as_array()
            .unwrap()
            .iter()
            .map(|c| Cone {
                vertex: VertexId(c["vertex"].as_u64().unwrap() as u32),
                angle: c["angle"].as_f64().unwrap(),
            })
            .collect();
        // Clusters by hand: how many, and the angle of each.
        let mut totals: Vec<f64> = Vec::new();
        let mut rest: Vec<Cone> = cones.clone();
        while let Some(first) = rest.pop() {
            let mut cluster = vec![first];
            let mut next = 0;
            while next < cluster.len() {
                let ring: Vec<VertexId> = surface
                    .mesh
                    .outgoing(cluster[next].vertex)
                    .map(|h| surface.mesh.tip(h))
                    .collect();
                let (found, others) = rest.into_iter().partition(|c| ring.contains(&c.vertex));
                rest = others;
                cluster.extend::<Vec<Cone>>(found);
                next += 1;
            }
            totals.push(cluster.iter().map(|c| c.angle.abs()).sum());
        }
        let clusters = case["clusters"].as_u64().unwrap() as usize;
        let lambda = case["lambda_unit"].as_f64().unwrap();
        assert_eq!(totals.len(), clusters, "{name} {lambda}");
        // They are of one sign: without limits each becomes one cone, unless it has 2π or more.
        let endless = RoundParams {
            small: f64::INFINITY,
            small_angle: f64::INFINITY,
            part_angle: f64::INFINITY,
            ..RoundParams::default()
        };
        let rounded = round_clusters(&surface.mesh, &surface.geometry, &cones, &endless);
        let least: usize = totals.iter().map(|t| 1 + (t / TAU) as usize).sum();
        let found = rounded.cones.len();
        // Parts of a giant need not be filled evenly.
        let most = if least == clusters { clusters } else { least + 3 };
        assert!((least..=most).contains(&found), "{name} {lambda}: {least} {found}");

        let rounded =
            round_clusters(&surface.mesh, &surface.geometry, &cones, &RoundParams::default());
        assert!(rounded.cones.len() >= clusters);
        assert!((sum(&rounded.cones) - sum(&cones)).abs() < 1e-11);
        if name == "spot.obj" && lambda == 0.01 {
            assert_eq!((cones.len(), rounded.cones.len()), (21, 9));
            let mut flow = flow(surface, lambda);
            let before = flow.state().int_u2;
            let after = flow.evaluate(&rounded.cones).unwrap().int_u2;
            assert!(after > before && after < 1.01 * before, "{before} {after}");
        }
    }
}

#[test]
fn long_curves_are_parted_along_their_length_and_rings_too() {
    let n = 40;
    let surface = sheet(n);
    let line: Vec<Cone> = (4..=36).map(|i| Cone { vertex: at(n, i, 20), angle: -0.125 }).collect();
    let ring: Vec<Cone> = surface
        .mesh
        .vertices()
        .filter(|v| {
            let p = surface.geometry.positions[v.index()];
            let r = (p.x * p.x + p.y * p.y).sqrt();
            (0.29..0.33).contains(&r)
        })
        .map(|vertex| Cone { vertex, angle: 0.1 })
        .collect();
    for cones in [line, ring] {
        let rounded = round_clusters(
            &surface.mesh,
            &surface.geometry,
            &cones,
            &RoundParams { part_angle: FRAC_PI_2, ..RoundParams::default() },
        );
        let total = sum(&cones).abs();
        let least = (total / FRAC_PI_2).ceil() as usize;
        assert!((least..=least + 2).contains(&rounded.cones.len()), "{least} {rounded:?}");
        assert!((sum(&rounded.cones).abs() - total).abs() < 1e-12);
        for (cone, members) in rounded.cones.iter().zip(&rounded.clusters) {
            assert!(cone.angle.abs() <= FRAC_PI_2 + 1e-12);
            // A part hangs together: it is no longer than its share of the whole, generously.
            let place = |v: VertexId| surface.geometry.positions[v.index()];
            let reach =
                members.iter().map(|&v| (place(v) - place(cone.vertex)).norm()).fold(0.0, f64::max);
            assert!(reach < 0.25, "{reach}");
        }
    }
}

#[test]
fn opposite_neighbours_stay_apart_and_angles_that_cannot_be_are_shared_out() {
    let n = 12;
    let surface = sheet(n);
    let round = |cones: &[Cone], params: &RoundParams| {
        round_clusters(&surface.mesh, &surface.geometry, cones, params)
    };
    let dipole = [
        Cone { vertex: at(n, 5, 5), angle: 0.5 },
        Cone { vertex: at(n, 5, 6), angle: -0.4 },
        Cone { vertex: at(n, 5, 7), angle: -0.1 },
    ];
    let rounded = round(&dipole, &RoundParams { small: 0.2, ..RoundParams::default() });
    assert_eq!(rounded.cones.len(), 2);
    assert_eq!(rounded.cones[0], dipole[0]);
    assert_eq!(rounded.cones[1], Cone { vertex: at(n, 5, 6), angle: -0.5 });
    assert_eq!(rounded.clusters[1], [at(n, 5, 6), at(n, 5, 7)]);

    for angle in [TAU, -3.2 * TAU] {
        let rounded = round(&[Cone { vertex: at(n, 6, 6), angle }], &RoundParams::default());
        assert!(rounded.cones.len() as f64 >= (angle.abs() / PI).floor());
        assert!(rounded.cones.iter().all(|c| c.angle.abs() <= PI + 1e-12));
        assert!((sum(&rounded.cones) - angle).abs() < 1e-12);
        assert!(rounded.clusters.iter().all(|c| *c == [at(n, 6, 6)]));
    }

    // Bounds of the flow bind merged cones, and lone ones that break them stay.
    let row: Vec<Cone> = (3..9).map(|i| Cone { vertex: at(n, i, 4), angle: 0.2 }).collect();
    let bounded = RoundParams { small: 1.0, bounds: [-1.0, 0.45], ..RoundParams::default() };
    let rounded = round(&row, &bounded);
    assert!(rounded.cones.iter().all(|c| c.angle <= 0.45) && rounded.cones.len() == 3);
    let lone = [Cone { vertex: at(n, 3, 3), angle: 0.9 }];
    assert_eq!(round(&lone, &bounded).cones, lone);

    // Cones on the boundary and inside are two clusters; a corner keeps below π.
    let corner: Vec<Cone> = (0..5)
        .map(|j| Cone { vertex: at(n, 0, j), angle: 0.7 })
        .chain([Cone { vertex: at(n, 1, 2), angle: 0.3 }])
        .collect();
    let merged = round(&corner, &RoundParams { small: 1.0, small_angle: 6.0, ..bounded });
    assert!(merged.cones.contains(&corner[5]));
    let loose = RoundParams { small: 1.0, small_angle: 6.0, ..RoundParams::default() };
    let rounded = round(&corner, &loose);
    assert!(rounded.cones.iter().all(|c| c.angle < PI) && rounded.cones.len() >= 3);
    assert!(round(&[], &loose).cones.is_empty());
}

#[test]
fn debiased_angles_are_the_best_at_their_places() {
    for (name, lambda, has_boundary) in
        [("plush_bear", 0.01, false), ("double_torus", 0.005, false), ("wavy_vase", 0.005, true)]
    {
        let surface = Surface::sample(name);
        let mut flow = flow(&surface, lambda);
        let state = flow.state().clone();
        let rounded =
            round_clusters(&surface.mesh, &surface.geometry, &state.cones, &RoundParams::default());
        assert!(rounded.cones.len() > 1, "{name}");
        let before = flow.evaluate(&rounded.cones).unwrap();
        let best = debias(&mut flow, &rounded.cones, &[]).unwrap();
        let after = flow.evaluate(&best).unwrap();
        assert_eq!(best.len(), rounded.cones.len());
        assert!(best.iter().zip(&rounded.cones).all(|(a, b)| a.vertex == b.vertex));
        assert!(after.int_u2 <= before.int_u2 * (1.0 + 1e-12), "{name}");
        assert!(best.iter().all(|c| c.angle > -TAU && c.angle <= 1.5 * PI));
        // The flow stands as it stood.
        assert_eq!(*flow.state(), state);
        if !has_boundary {
            assert!((sum(&best) - sum(&rounded.cones)).abs() < 1e-9, "{name}");
        }
        // No change of one angle (of two, against each other) is better: the first derivative vanishes.
        let free: Vec<usize> =
            (0..best.len()).filter(|&i| best[i].angle < 1.5 * PI - 1e-9).collect();
        for pair in free.windows(2).take(3) {
            let mut values = [0.0; 2];
            for (value, step) in values.iter_mut().zip([1e-3, -1e-3]) {
                let mut cones = best.clone();
                cones[pair[0]].angle += step;
                if !has_boundary {
                    cones[pair[1]].angle -= step;
                }
                *value = flow.evaluate(&cones).unwrap().int_u2;
                // Strictly convex: by second order more.
                assert!(*value > after.int_u2, "{name}");
            }
            let slope = (values[0] - values[1]) / 2e-3;
            assert!(slope.abs() < 1e-7, "{name}: {slope:e}");
        }
        // Held angles stay.
        let held = [best[0].vertex];
        let again = debias(&mut flow, &rounded.cones, &held).unwrap();
        assert_eq!(again[0].angle, rounded.cones[0].angle);
        let held_value = flow.evaluate(&again).unwrap().int_u2;
        assert!(
            held_value >= after.int_u2 * (1.0 - 1e-12)
                && held_value <= before.int_u2 * (1.0 + 1e-12)
        );
    }
}

#[test]
fn debiasing_keeps_bounds_and_refuses_what_cannot_be() {
    let surface = Surface::sample("plush_bear");
    let params = ConeParams { lambda: 0.01, bounds: [-0.2, FRAC_PI_2], ..ConeParams::default() };
    let mut flow =
        ConeFlow::new(&surface.mesh, &surface.geometry, &params, &ConeFields::default()).unwrap();
    while flow.status() == Status::Running {
        flow.step().unwrap();
    }
    let cones = flow.state().cones.clone();
    let bounded = RoundParams { bounds: params.bounds, ..RoundParams::default() };
    let rounded = round_clusters(&surface.mesh, &surface.geometry, &cones, &bounded).cones;
    let best = debias(&mut flow, &rounded, &[]).unwrap();
    assert!(best.iter().all(|c| c.angle > -0.2 - 1e-9 && c.angle < FRAC_PI_2 + 1e-9));
    assert!(best.iter().any(|c| c.angle > FRAC_PI_2 - 1e-9), "the bound is reached");
    let before = flow.evaluate(&rounded).unwrap().int_u2;
    assert!(flow.evaluate(&best).unwrap().int_u2 < before);

    let mut unbalanced = rounded.clone();
    unbalanced[0].angle += 0.1;
    assert!(matches!(
        debias(&mut flow, &unbalanced, &[]),
        Err(SolveError::Cones(ConeError::GaussBonnet { .. }))
    ));
    let vase = Surface::sample("wavy_vase");
    let rim = vase.mesh.tail(vase.mesh.boundary_loops()[0]);
    let mut flow =
        ConeFlow::new(&vase.mesh, &vase.geometry, &ConeParams::default(), &ConeFields::default())
            .unwrap();
    assert!(matches!(
        debias(&mut flow, &[Cone { vertex: rim, angle: 0.1 }], &[]),
        Err(SolveError::Cones(ConeError::Conflict { conflict: ConeConflict::Boundary, .. }))
    ));
}

#[test]
fn greedy_cones_have_no_scale_where_they_are_and_are_worth_what_the_flow_says() {
    for (name, count) in [("plush_bear", 9), ("torus", 5), ("wavy_vase", 6)] {
        let surface = Surface::sample(name);
        let greedy = greedy_cones(&surface.mesh, &surface.geometry, count).unwrap();
        assert_eq!(greedy.cones.len(), count, "{name}");
        let topology = surface.mesh.topology();
        if topology.boundary_loops == 0 {
            let needed = TAU * topology.euler as f64;
            assert!((sum(&greedy.cones) - needed).abs() < 1e-9);
            let defects = angle_defects(&surface.mesh, &surface.geometry);
            let most = defects.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
            assert_eq!(defects[greedy.history[0].vertex.index()].abs(), most);
        }
        // u is one constant at all cones, 0 with a boundary.
        let level = greedy.u[greedy.cones[0].vertex.index()];
        assert!(greedy.cones.iter().all(|c| (greedy.u[c.vertex.index()] - level).abs() < 1e-10));
        let mut flow = flow(&surface, 1.0);
        let value = flow.evaluate(&greedy.cones).unwrap();
        let last = greedy.history.last().unwrap();
        assert_eq!(last.count, count);
        assert!((value.int_u2 - last.int_u2).abs() < 1e-9 * value.int_u2, "{name}");
        assert!((value.total_angle - last.total_angle).abs() < 1e-12);
        for (a, b) in value.u.iter().zip(&greedy.u) {
            assert!((a - b).abs() < 1e-8, "{name}");
        }
        // A later cone lies where |u| was largest: steps are a prefix of longer runs.
        let fewer = greedy_cones(&surface.mesh, &surface.geometry, count - 1).unwrap();
        assert_eq!(fewer.history[..], greedy.history[..greedy.history.len() - 1]);
        let left = fewer.u.iter().zip(0..).map(|(u, v): (&f64, usize)| {
            let base = fewer.u[fewer.cones[0].vertex.index()];
            ((u - base).abs(), v)
        });
        let worst = left.fold((0.0, 0), |m, x| if x.0 > m.0 { x } else { m });
        assert_eq!(last.vertex, VertexId::from(worst.1), "{name}");
    }
    // Nothing to do on a developable surface.
    let tube = Surface::from_soup("cylinder", &cylinder(24, 9));
    assert!(greedy_cones(&tube.mesh, &tube.geometry, 5).unwrap().cones.is_empty());
}

#[test]
fn at_equal_total_angle_the_optimum_beats_eight_greedy_cones() {
    let Some(face) = numbered("face.obj") else { return };
    let greedy = greedy_cones(&face.mesh, &face.geometry, 8).unwrap();
    let last = greedy.history.last().unwrap();
    // From the notes on the method.
    assert!((last.int_u2.sqrt() - 0.499).abs() < 1e-3, "{}", last.int_u2.sqrt());
    let flow = flow(&face, 0.0017);
    let state = flow.state();
    assert!(state.total_angle <= last.total_angle, "{} {}", state.total_angle, last.total_angle);
    assert!(state.int_u2.sqrt() < 0.22, "{}", state.int_u2.sqrt());
}

fn placed(cones: &[(u32, f64, bool)]) -> Vec<PlacedCone> {
    let one = |&(v, angle, is_fixed): &(u32, f64, bool)| PlacedCone {
        cone: Cone { vertex: VertexId(v), angle },
        is_fixed,
    };
    cones.iter().map(one).collect()
}

fn angle_of(cones: &[PlacedCone], v: u32) -> f64 {
    cones.iter().find(|c| c.cone.vertex.0 == v).unwrap().cone.angle
}

#[test]
fn edits_keep_gauss_bonnet_on_closed_surfaces_by_shares_in_proportion() {
    let mesh = Surface::sphere(4).mesh;
    let start =
        placed(&[(3, 1.5 * PI, false), (20, 1.5 * PI, false), (60, PI, true), (80, 0.0, false)]);
    let total = |cones: &[PlacedCone]| cones.iter().map(|c| c.cone.angle).sum::<f64>();

    let added = edit_cones(&mesh, &start, ConeEdit::Add { vertex: VertexId(40), angle: Some(1.0) })
        .unwrap();
    assert!((total(&added) - 2.0 * TAU).abs() < 1e-12);
    assert_eq!((angle_of(&added, 40), angle_of(&added, 60), angle_of(&added, 80)), (1.0, PI, 0.0));
    assert!((angle_of(&added, 3) - (1.5 * PI - 0.5)).abs() < 1e-12);
    assert!(added.iter().find(|c| c.cone.vertex.0 == 40).unwrap().is_fixed);

    let free =
        edit_cones(&mesh, &start, ConeEdit::Add { vertex: VertexId(40), angle: None }).unwrap();
    assert_eq!(angle_of(&free, 40), 0.0);
    assert_eq!(angle_of(&free, 3), 1.5 * PI);

    let set = ConeEdit::SetAngle { vertex: VertexId(3), angle: 1.2 * PI };
    let set = edit_cones(&mesh, &start, set).unwrap();
    assert!((angle_of(&set, 20) - 1.8 * PI).abs() < 1e-12);
    assert_eq!((angle_of(&set, 3), angle_of(&set, 60)), (1.2 * PI, PI));
    // Now 3 and 60 are fixed, and 20 alone must take it all: too much.
    let much = ConeEdit::SetAngle { vertex: VertexId(60), angle: -1.0 };
    let refused = edit_cones(&mesh, &set, much).unwrap_err();
    assert!(
        matches!(refused, EditError::OutOfRange { vertex: VertexId(20), angle, most, .. }
            if angle > TAU && most == TAU),
        "{refused}"
    );
    let released = edit_cones(&mesh, &set, ConeEdit::Release { vertex: VertexId(3) }).unwrap();
    assert!(!released.iter().find(|c| c.cone.vertex.0 == 3).unwrap().is_fixed);

    let moved =
        edit_cones(&mesh, &start, ConeEdit::Move { from: VertexId(60), to: VertexId(61) }).unwrap();
    assert_eq!((angle_of(&moved, 61), moved.len()), (PI, 4));
    assert!((total(&moved) - 2.0 * TAU).abs() < 1e-12);

    // Of (1.5π, 1.5π, π fixed) the first goes: 20 would need 3π.
    let gone = edit_cones(&mesh, &start, ConeEdit::Remove { vertex: VertexId(3) }).unwrap_err();
    assert!(matches!(gone, EditError::OutOfRange { vertex: VertexId(20), .. }));
    let fine = edit_cones(&mesh, &start, ConeEdit::Remove { vertex: VertexId(60) });
    assert!(
        matches!(fine, Err(EditError::OutOfRange { angle, .. }) if (angle - TAU).abs() < 1e-12)
    );
    let many = placed(&[(3, PI, false), (20, PI, false), (60, PI, true), (80, PI, false)]);
    let fewer = edit_cones(&mesh, &many, ConeEdit::Remove { vertex: VertexId(60) }).unwrap();
    assert!(fewer.iter().all(|c| (c.cone.angle - 2.0 * TAU / 3.0).abs() < 1e-12));

    let all = placed(&[(3, TAU * 0.9, true), (20, TAU * 0.9, true), (60, TAU * 0.2, true)]);
    let stuck = ConeEdit::SetAngle { vertex: VertexId(60), angle: 0.0 };
    assert!(matches!(
        edit_cones(&mesh, &all, stuck),
        Err(EditError::AllFixed { total, needed, .. })
            if (total - 3.6 * PI).abs() < 1e-12 && (needed - 4.0 * PI).abs() < 1e-12
    ));
}

#[test]
fn edits_on_a_surface_with_boundary_change_one_cone_and_bad_ones_say_why() {
    let vase = Surface::sample("wavy_vase");
    let mesh = &vase.mesh;
    let inside: Vec<u32> =
        mesh.vertices().filter(|&v| !mesh.is_boundary_vertex(v)).map(|v| v.0).collect();
    let [a, b, c] = [inside[10], inside[200], inside[400]];
    let start = placed(&[(a, 1.0, false), (b, -0.5, false)]);
    let added =
        edit_cones(mesh, &start, ConeEdit::Add { vertex: VertexId(c), angle: Some(0.25) }).unwrap();
    assert_eq!((angle_of(&added, a), angle_of(&added, b)), (1.0, -0.5));
    let removed = edit_cones(mesh, &added, ConeEdit::Remove { vertex: VertexId(a) }).unwrap();
    assert_eq!((removed.len(), angle_of(&removed, c)), (2, 0.25));

    let refuse = |edit| edit_cones(mesh, &start, edit).unwrap_err();
    let add = |vertex, angle| ConeEdit::Add { vertex, angle };
    let count = mesh.vertex_count();
    let beyond = VertexId::from(count);
    assert_eq!(
        refuse(add(beyond, None)),
        EditError::NoSuchVertex { vertex: beyond, vertices: count }
    );
    assert_eq!(refuse(add(VertexId(a), None)), EditError::Occupied { vertex: VertexId(a) });
    assert_eq!(
        refuse(ConeEdit::Move { from: VertexId(a), to: VertexId(b) }),
        EditError::Occupied { vertex: VertexId(b) }
    );
    assert_eq!(
        refuse(ConeEdit::Remove { vertex: VertexId(c) }),
        EditError::NoCone { vertex: VertexId(c) }
    );
    for angle in [TAU, -TAU, 9.0, f64::NAN] {
        let refused = refuse(ConeEdit::SetAngle { vertex: VertexId(a), angle });
        assert!(matches!(refused, EditError::OutOfRange { vertex, .. } if vertex.0 == a));
    }
    // With a corner the component balances: corners take their share, and a corner keeps below π.
    let rim: Vec<VertexId> =
        mesh.boundary_loop(mesh.boundary_loops()[0]).map(|h| mesh.tail(h)).collect();
    assert!(
        matches!(refuse(add(rim[0], Some(PI))), EditError::OutOfRange { most, .. } if most == PI)
    );
    let disk = sheet(6);
    let corners = placed(&[
        (at(6, 0, 0).0, FRAC_PI_2, false),
        (at(6, 6, 0).0, FRAC_PI_2, false),
        (at(6, 6, 6).0, FRAC_PI_2, false),
        (at(6, 0, 6).0, FRAC_PI_2, true),
    ]);
    let edited =
        edit_cones(&disk.mesh, &corners, ConeEdit::Add { vertex: at(6, 3, 3), angle: Some(0.3) })
            .unwrap();
    assert!((edited.iter().map(|c| c.cone.angle).sum::<f64>() - TAU).abs() < 1e-12);
    assert!((angle_of(&edited, at(6, 6, 0).0) - (FRAC_PI_2 - 0.1)).abs() < 1e-12);
    assert_eq!(angle_of(&edited, at(6, 0, 6).0), FRAC_PI_2);
    // Each component for itself.
    let mut two = Soup::from_triangles(
        Surface::sphere(2).geometry.positions.iter().map(|p| [p.x, p.y, p.z]).collect(),
        &Surface::sphere(2).mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect::<Vec<_>>(),
    );
    let half = two.positions.len() as u32;
    let copy: Vec<[f64; 3]> = two.positions.iter().map(|p| [p[0] + 2.0, p[1], p[2]]).collect();
    two.positions.extend(copy);
    let triangles: Vec<[u32; 3]> = Surface::sphere(2)
        .mesh
        .triangles()
        .iter()
        .flat_map(|t| [t.map(|v| v.0), t.map(|v| v.0 + half)])
        .collect();
    let mesh = Mesh::new(two.positions.len(), &triangles).unwrap();
    let third = 2.0 * TAU / 3.0;
    let cones: Vec<(u32, f64, bool)> =
        [1, 5, 9].into_iter().flat_map(|v| [(v, third, false), (v + half, third, false)]).collect();
    let edit = ConeEdit::SetAngle { vertex: VertexId(5), angle: third - 0.2 };
    let edited = edit_cones(&mesh, &placed(&cones), edit).unwrap();
    assert!((angle_of(&edited, 1) - third - 0.1).abs() < 1e-12);
    assert_eq!(angle_of(&edited, 1 + half), third);
}
