//! Where the public implementation of variational surface cutting falls down, one test for each: what it got wrong, we do not.
//!
//! Numbers in comments are that program's, measured on the same surfaces.

use std::f64::consts::{PI, TAU};

use cutflow::geometry::Geometry;
use cutflow::mesh::Soup;
use cutflow::methods::cutflow::{CutFlow, CutFlowParams};
use cutflow::methods::flow::{Flow, Status};
use cutflow::methods::straighten::{StraightenParams, straighten};
use cutflow::session::{
    Charting, Command, Document, FlattenBy, FlattenReport, Session, Value, samples, surface_layout,
};
use nalgebra::Point3;

use crate::cutting::{clusters, flow, plane, regions, weights};
use crate::surfaces::Surface;

/// A number in [−1, 1] that looks like chance.
fn noise(seed: u32) -> f64 {
    let x = seed.wrapping_mul(2_654_435_761).wrapping_add(0x9e37_79b9);
    let x = (x ^ (x >> 15)).wrapping_mul(2_246_822_519);
    f64::from(x ^ (x >> 13)) / f64::from(u32::MAX) * 2.0 - 1.0
}

/// A sphere whose vertices have been pushed about by a third of an edge.
fn uneven_sphere(n: u32) -> Surface {
    Surface::from_soup("uneven sphere", &uneven_ball(n))
}

fn uneven_ball(n: u32) -> Soup {
    let mut soup = samples::icosphere(n);
    for (v, p) in soup.positions.iter_mut().enumerate() {
        let moved = [0, 1, 2].map(|i| p[i] + 0.35 * noise(3 * v as u32 + i as u32) / f64::from(n));
        let length = moved.iter().map(|x| x * x).sum::<f64>().sqrt();
        *p = moved.map(|x| x / length);
    }
    soup
}

/// A closed surface of revolution about z, from the bottom pole to the top one.
fn revolved(around: u32, profile: &[[f64; 2]]) -> Soup {
    let mut positions = vec![[0.0, 0.0, profile[0][1]]];
    let rings = profile.len() as u32 - 2;
    for (j, [r, z]) in profile[1..profile.len() - 1].iter().enumerate() {
        for i in 0..around {
            let angle = TAU * (f64::from(i) + 0.5 * j as f64) / f64::from(around);
            positions.push([r * angle.cos(), r * angle.sin(), *z]);
        }
    }
    positions.push([0.0, 0.0, profile[profile.len() - 1][1]]);
    let at = |j: u32, i: u32| 1 + j * around + i % around;
    let top = rings * around + 1;
    let mut triangles = Vec::new();
    for i in 0..around {
        triangles.push([0, at(0, i + 1), at(0, i)]);
        triangles.push([top, at(rings - 1, i), at(rings - 1, i + 1)]);
        for j in 0..rings - 1 {
            triangles.push([at(j, i), at(j, i + 1), at(j + 1, i)]);
            triangles.push([at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)]);
        }
    }
    Soup::from_triangles(positions, &triangles)
}

/// It adds 1e-4 to every diagonal of the Laplacian: E_H is off by 1.9, 7.6 and 26 % at these sizes, more the finer.
#[test]
fn weakness_1_the_hencky_energy_is_not_screened_and_gets_better_with_every_refinement() {
    let ln2 = 2f64.ln();
    let exact = 2.0 * ln2 * ln2 - 4.0 * ln2 + 2.0;
    let errors = [16, 32, 64].map(|n| {
        let surface = Surface::sphere(n);
        let energy = flow(surface, &plane(0.0, 0.0, 1.0), weights(0.0, 1.0, 1.0)).state().energy();
        (energy.hencky / exact - 1.0).abs()
    });
    assert!(errors[0] < 1e-3 && errors[2] < 5e-5, "{errors:?}");
    // Second order, with a margin for the irregular vertices.
    assert!(errors[0] > 3.3 * errors[1] && errors[1] > 3.3 * errors[2], "{errors:?}");
}

/// Distance of a point from a segment.
fn distance(p: Point3<f64>, [a, b]: [Point3<f64>; 2]) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(&along) / along.norm_squared().max(1e-300)).clamp(0.0, 1.0);
    (p - (a + along * t)).norm()
}

/// The segments of a flow's cut in space.
fn segments(flow: &CutFlow, geometry: &Geometry) -> Vec<[Point3<f64>; 2]> {
    let cut = flow.cut_mesh();
    let at = |p: u32| geometry.locate(flow.mesh(), cut.points[p as usize]);
    cut.cut_edges.iter().map(|e| e.map(at)).collect()
}

/// In one step its cut jumps by up to 54 edges and its objective rises fourfold.
#[test]
fn weakness_2_a_step_moves_the_cut_by_an_edge_at_most_and_never_raises_the_energy() {
    for (surface, initial, params) in [
        (Surface::sphere(16), plane(0.0, 0.0, 1.0), weights(10.0, 0.0, 2.0)),
        (uneven_sphere(16), plane(0.1, 0.0, 1.0), weights(0.0, 3000.0, 2.0)),
        (Surface::sample("rounded_box"), clusters(), weights(0.0, 3000.0, 2.0)),
    ] {
        let (name, geometry) = (surface.name.clone(), surface.geometry.clone());
        let longest = surface.mesh.edges().map(|e| geometry.edge_length(e)).fold(0.0, f64::max);
        let mut flow = flow(surface, &initial, params);
        // The disturbance and the first descents add up: that step is another promise.
        flow.step().unwrap();
        let mut old = segments(&flow, &geometry);
        let mut total = flow.state().energy().total;
        for _ in 0..25 {
            let report = flow.step().unwrap();
            let new = segments(&flow, &geometry);
            let energy = flow.state().energy().total;
            assert!(energy <= total, "{name}: J rose from {total} to {energy}");
            for &[p, _] in &new {
                let moved = old.iter().map(|s| distance(p, *s)).fold(f64::INFINITY, f64::min);
                // Along the edges of one triangle to the next: no vertex further than one edge from the old cut changes sides.
                assert!(moved < 1.5 * longest, "{name}, step {}: {moved} {longest}", report.step);
            }
            (old, total) = (new, energy);
            if report.status != Status::Running {
                break;
            }
        }
    }
}

/// Its thin parts lose their cuts for good.
#[test]
fn weakness_2_a_thin_part_keeps_its_cut() {
    // A ball with a horn: radius 1 and 0.12, the horn 2 long with edges a sixth of those of the ball.
    let mut profile: Vec<[f64; 2]> = Vec::new();
    let neck = 0.12f64.asin();
    for i in 0..=16 {
        let angle = (PI - neck) * f64::from(i) / 16.0;
        profile.push([angle.sin(), -angle.cos()]);
    }
    for i in 1..=30 {
        profile.push([0.12 - 0.002 * f64::from(i), neck.cos() + f64::from(i) / 15.0]);
    }
    let tip = neck.cos() + 2.0;
    profile.push([0.03, tip + 0.04]);
    profile.push([0.0, tip + 0.05]);
    for w in [weights(10.0, 0.0, 2.0), weights(0.0, 3000.0, 2.0)] {
        let surface = Surface::from_soup("horn", &revolved(16, &profile));
        let places = surface.geometry.positions.clone();
        let (low, high) = places
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.z), b.max(p.z)));
        let unit = (high - low) / (tip + 0.05 + 1.0);
        let height = |p: &Point3<f64>| (p.z - low) / unit - 1.0;
        let mut flow = flow(surface, &plane(0.2, 1.0, 0.0), w);
        for _ in 0..60 {
            if flow.step().unwrap().status != Status::Running {
                break;
            }
            for slice in 0..9 {
                let bottom = 1.05 + 0.2 * f64::from(slice);
                let inside = |p: &Point3<f64>| (bottom..bottom + 0.2).contains(&height(p));
                let labels = flow.state().labels();
                let side =
                    |label: u32| places.iter().zip(labels).any(|(p, l)| inside(p) && *l == label);
                assert!(side(0) && side(1), "the horn lost its cut at {bottom}");
            }
        }
        assert_eq!(regions(&flow), 2);
    }
}

/// Every search of its line search ends at the last halving.
#[test]
fn weakness_3_most_trials_are_taken_and_a_run_goes_on_until_it_is_done() {
    for (surface, initial, params, most) in [
        (Surface::sphere(16), plane(0.0, 0.0, 1.0), weights(3.0, 0.0, 2.0), 1.6),
        (Surface::sphere(16), plane(0.0, 0.0, 1.0), weights(10.0, 0.0, 2.0), 1.6),
        (Surface::sample("rounded_box"), clusters(), weights(0.0, 3000.0, 2.0), 3.2),
        (Surface::sample("wavy_vase"), clusters(), weights(0.0, 3000.0, 2.0), 3.2),
    ] {
        let name = surface.name.clone();
        let mut flow = flow(surface, &initial, params);
        let mut rows = vec![(flow.state().energy().total, flow.factorisations())];
        for _ in 0..40 {
            if flow.step().unwrap().status != Status::Running {
                break;
            }
            rows.push((flow.state().energy().total, flow.factorisations()));
        }
        let (first, last) = (rows[0].0, rows[rows.len() - 1].0);
        assert!(last < 0.95 * first, "{name}: {first} {last}");
        // At the end of a run searches must fail: that is how it is told that there is nothing left.
        let done = rows.iter().position(|r| r.0 <= last + 0.01 * (first - last)).unwrap();
        let trials = (rows[done].1 - rows[0].1) as f64 / done as f64;
        println!("{name}: {trials:.2} factorisations a step, {done} steps");
        assert!(trials < most, "{name}: {trials} trials a step");
    }
}

/// Its number of patches depends on triangulation and time step: a sphere falls into two to four.
#[test]
fn weakness_4_the_topology_is_that_of_the_start_on_any_mesh_and_with_any_step() {
    for (surface, cap, tilt) in [
        (Surface::sphere(14), 0.3, 0.0),
        (Surface::sphere(14), 1.5, 0.0),
        (Surface::sphere(22), 1.0, 0.3),
        (uneven_sphere(16), 0.5, 0.0),
        (uneven_sphere(16), 1.5, 0.2),
    ] {
        let name = format!("{}, {cap}", surface.name);
        let params = CutFlowParams { cap, tolerance: 1e-4, ..weights(3.0, 0.0, 2.0) };
        let mut flow = flow(surface, &plane(tilt, 0.0, 1.0), params);
        for _ in 0..160 {
            let status = flow.step().unwrap().status;
            assert_eq!(regions(&flow), 2, "{name}");
            if status != Status::Running {
                break;
            }
        }
        let total = flow.state().energy().total;
        // The symmetric seam is at 10.574, the less symmetric ones at 10.41; long steps on large triangles may end in a valley beside.
        assert!(total > 10.3 && total < 11.0, "{name}: {total}");
    }
}

/// It flattens a torus without a disk to 1 528 flipped triangles and says nothing.
#[test]
fn weakness_5_a_handle_is_cut_open_and_flattens_without_a_flipped_triangle() {
    for name in ["torus", "double_torus"] {
        let whole = samples::generate(name).unwrap();
        let centre = whole.positions[whole.polygon(0)[0] as usize];
        let far =
            |p: [f64; 3]| (0..3).map(|i| (p[i] - centre[i]).powi(2)).sum::<f64>().sqrt() > 0.25;
        let mut text = String::new();
        for [x, y, z] in &whole.positions {
            text += &format!("v {x} {y} {z}\n");
        }
        let mut left_out = 0;
        for i in 0..whole.polygon_count() {
            let corners = whole.polygon(i);
            if corners.iter().all(|&v| far(whole.positions[v as usize])) {
                let words: Vec<String> = corners.iter().map(|v| (v + 1).to_string()).collect();
                text += &format!("f {}\n", words.join(" "));
            } else {
                left_out += 1;
            }
        }
        assert!(left_out > 4, "{name}: a disk is missing");
        let document = Document::from_bytes("handle.obj", text.as_bytes()).unwrap();
        let surface = document.surface().unwrap();
        assert_eq!(surface.topology.genus, if name == "torus" { 1 } else { 2 });
        let (layout, _) = surface_layout(
            surface,
            None,
            &Charting { by: FlattenBy::Bff, splits: false, ..Charting::default() },
            "none",
        )
        .unwrap();
        let report = FlattenReport::new(&layout, None);
        assert_eq!(report.totals.flipped, 0, "{name}");
        assert!(report.charts.iter().all(Option::is_some) && report.seams_equal, "{name}");
    }
}

/// It factors the same matrix eleven times for each patch and step, and keeps ten labels everywhere.
#[test]
fn weakness_6_one_factorisation_for_each_trial_and_level_sets_beside_the_cut_only() {
    let surface = Surface::sphere(32);
    let count = surface.mesh.vertex_count();
    let mut flow = flow(surface, &plane(0.0, 0.0, 1.0), weights(10.0, 300.0, 2.0));
    // The start: one.
    assert_eq!(flow.factorisations(), 1);
    for _ in 0..15 {
        flow.step().unwrap();
    }
    // Values, gradient with its adjoint, and the flattening preview all use that one.
    flow.adjoint().unwrap();
    let per_step = (flow.factorisations() - 1) as f64 / 15.0;
    assert!(per_step < 1.7, "{per_step} factorisations a step, the first one with its disturbance");
    let stored = flow.mesh().vertices().filter(|&v| flow.level(v).is_some()).count();
    // The curve is some four times as long as the sphere is wide; its band is seven rings of vertices.
    assert!(stored < count / 3, "{stored} of {count} vertices carry level sets");
}

fn obj(soup: &Soup, scale: f64, groups: bool) -> String {
    let mut text = String::new();
    for p in &soup.positions {
        let [x, y, z] = p.map(|c| c * scale);
        text += &format!("v {x} {y} {z}\n");
    }
    for i in 0..soup.polygon_count() {
        if groups && i % 100 == 0 {
            text += &format!("g part{}\nusemtl paint{}\n", i / 100 % 3, i / 200 % 2);
        }
        let words: Vec<String> = soup.polygon(i).iter().map(|v| (v + 1).to_string()).collect();
        text += &format!("f {}\n", words.join(" "));
    }
    text
}

/// Its constants depend on the unit of the file.
#[test]
fn weakness_7_the_unit_of_the_file_changes_nothing() {
    let run = |soup: &Soup, init: &str, scale: f64| {
        let mut session = Session::new();
        session.open("thing.obj", obj(soup, scale, false).as_bytes());
        let value = Value::Text(init.into());
        session.handle(Command::SetParameter { id: "init".into(), value });
        for _ in 0..8 {
            session.handle(Command::Step);
        }
        let totals: Vec<f64> = session.history().iter().map(|row| row.total).collect();
        (session.labels(), totals)
    };
    // Powers of two round nothing: bit for bit the same.
    let even = samples::generate("rounded_box").unwrap();
    let expected = run(&even, "normals", 1.0);
    assert_eq!(expected.1.len(), 9);
    for scale in [1.0 / 1024.0, 1024.0] {
        assert!(run(&even, "normals", scale) == expected, "{scale}");
    }
    // Others round, which may decide ties: on a surface that has none.
    let uneven = uneven_ball(16);
    let (labels, totals) = run(&uneven, "plane", 1.0);
    for scale in [1e-3, 1e3] {
        let (other, its_totals) = run(&uneven, "plane", scale);
        for (a, b) in totals.iter().zip(&its_totals) {
            // Decimals of the file round differently; eight steps make little of it.
            assert!((a - b).abs() < 1e-9 * a, "{scale}: {totals:?} {its_totals:?}");
        }
        assert!(labels == other, "{scale}: another cut");
    }
}

/// It writes up to 2.2 times as many faces, in an order of its own, without groups and materials.
#[test]
fn weakness_7_vertices_groups_and_materials_are_kept_and_few_triangles_are_added() {
    let soup = samples::generate("rounded_box").unwrap();
    let given = obj(&soup, 1.0, true);
    let mut session = Session::new();
    session.open("box.obj", given.as_bytes());
    for _ in 0..6 {
        session.handle(Command::Step);
    }
    let file = session.export("UV mesh (OBJ)").unwrap();
    let text = String::from_utf8(file.bytes).unwrap();
    let places = |text: &str| -> Vec<[f64; 3]> {
        let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
        lines
            .map(|line| {
                let mut words = line.split(' ').map(|word| word.parse().unwrap());
                [0; 3].map(|_| words.next().unwrap())
            })
            .collect()
    };
    let (old, new) = (places(&given), places(&text));
    assert!(
        new.len() > old.len() && new[..old.len()] == old[..],
        "vertices come first, as they were"
    );
    let faces = |text: &str| text.lines().filter(|line| line.starts_with("f ")).count();
    let growth = faces(&text) as f64 / soup.polygon_count() as f64;
    let polygons: usize = (0..soup.polygon_count()).map(|i| soup.polygon(i).len() - 2).sum();
    let triangles = faces(&text) as f64 / polygons as f64;
    assert!(triangles < 1.25, "{triangles} times the triangles, {growth} times the faces");
    for name in ["part0", "part1", "part2", "paint0", "paint1"] {
        assert!(text.lines().any(|line| line.contains(name)), "{name} is lost");
    }
}

/// Its outlines zigzag over the triangles.
#[test]
fn weakness_7_outlines_are_straight_where_the_raw_cut_zigzags() {
    // An equator that passes through an uneven mesh, disturbed by half an edge: the shortest closed curve near it is known.
    let surface = uneven_sphere(16);
    let labels = surface
        .geometry
        .positions
        .iter()
        .enumerate()
        .map(|(v, p)| u32::from(p.z > 0.012 * noise(v as u32)))
        .collect();
    let (mesh, geometry) = (surface.mesh.clone(), surface.geometry.clone());
    let initial = cutflow::methods::cutflow::Initial::Labels(labels);
    let cut = flow(surface, &initial, weights(3.0, 0.0, 2.0)).cut_mesh();
    let params = StraightenParams::default();
    let straight = straighten(&mesh, &geometry, &cut, &params, &[]).unwrap();
    let [raw, smooth] = straight.lengths;
    assert!(smooth < 0.97 * raw, "{raw} {smooth}");
    // The great circle: 2πR of a sphere of unit area.
    let circle = TAU / (4.0 * PI).sqrt();
    // Points slide along their edges: the curve keeps to its strip of triangles, and those are what winds now.
    assert!(smooth < 1.03 * circle, "{smooth} {circle}");
}
