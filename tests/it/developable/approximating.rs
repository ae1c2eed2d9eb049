//! Variational shape approximation: exact charts, bounds, the contract of flows.

use std::f64::consts::TAU;

use cutflow::geometry::Geometry;
use cutflow::mesh::{FaceId, Mesh};
use cutflow::methods::developable::{
    SeamMeasure, VsaFlow, VsaParams, VsaPhase, seam_curves, start_faces,
};
use cutflow::methods::flow::{SolveError, Status};
use nalgebra::Point3;

use super::*;
use crate::surfaces::{cube, cylinder, grid};

fn with(tolerance: f64) -> VsaParams {
    VsaParams { tolerance, ..VsaParams::default() }
}

/// A cube of n × n squares a side, each divided.
fn fine_cube(n: u32) -> Shape {
    let mut numbers = std::collections::BTreeMap::new();
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [0, n] {
            for (i, j) in (0..n * n).map(|k| (k % n, k / n)) {
                let [a, b, c, d] =
                    [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| {
                        let mut p = [side; 3];
                        p[(axis + 1) % 3] = i;
                        p[(axis + 2) % 3] = j;
                        *numbers.entry(p).or_insert_with(|| {
                            points.push(Point3::from(p.map(f64::from)));
                            points.len() as u32 - 1
                        })
                    });
                let pair = [[a, b, c], [a, c, d]];
                triangles
                    .extend(pair.map(|[a, b, c]| if side == 0 { [a, c, b] } else { [a, b, c] }));
            }
        }
    }
    let mesh = Mesh::new(points.len(), &triangles).unwrap();
    let geometry = Geometry::new(&mesh, points).unwrap();
    (Arc::new(mesh), Arc::new(geometry))
}

#[test]
fn a_cube_has_six_charts_with_seams_along_its_edges() {
    for (mesh, geometry) in [shape(Surface::from_soup("cube", &cube())), fine_cube(7)] {
        let flow = approximate(&(mesh.clone(), geometry.clone()), with(1e-6));
        let state = flow.state();
        assert_eq!((flow.status(), state.charts.len()), (Status::Converged, 6));
        assert_complete(&mesh, &state.face_charts);
        // Rounding of normals, squared.
        assert!(state.error < 1e-28, "{}", state.error);
        let side = (geometry.total_area() / 6.0).sqrt();
        let curves = seam_curves(&mesh, &geometry, &state.face_charts);
        let measure = SeamMeasure::new(&mesh, &geometry, &curves);
        assert_eq!((curves.len(), measure.zigzags), (12, 0));
        // Sums of a few lengths.
        assert!(curves.iter().all(|c| (c.length - side).abs() < 1e-12 * side));
    }
}

#[test]
fn a_cylinder_is_divided_along_its_length_only() {
    // Tall, with rows of faces that have the same normals all along.
    let (points, triangles, _) =
        grid([64, 4], true, |x, y| [(TAU * x).cos(), (TAU * x).sin(), 6.0 * y]);
    let mesh = Mesh::new(points.len(), &triangles).unwrap();
    let geometry = Geometry::new(&mesh, points).unwrap();
    let flow = approximate(&(Arc::new(mesh.clone()), Arc::new(geometry.clone())), with(0.01));
    let state = flow.state();
    let count = assert_complete(&mesh, &state.face_charts);
    // n equal sectors of a circle have the errors 2 (1/n − sin(π/n)/π): .0150 for six, .0095 for seven. What begins at single faces is not equal.
    assert!((7..=12).contains(&count), "{count}");
    let ring = TAU;
    let curves = seam_curves(&mesh, &geometry, &state.face_charts);
    let length = SeamMeasure::new(&mesh, &geometry, &curves).length;
    // One line of length 6 between each two, and next to nothing of it across.
    assert!(length < 6.0 * count as f64 + ring, "{length} for {count} charts");
}

#[test]
fn charts_are_as_flat_as_asked_for_whatever_the_surface() {
    for surface in Surface::zoo() {
        let name = surface.name.clone();
        let surface = shape(surface);
        for tolerance in [0.1, 0.01] {
            let flow = approximate(&surface, with(tolerance));
            let state = flow.state();
            assert_complete(&surface.0, &state.face_charts);
            assert_eq!(flow.status(), Status::Converged, "{name}");
            assert!(state.worst <= tolerance, "{name}");
            let normals = surface.1.face_normals(&surface.0);
            let mut worst = 0.0f64;
            for chart in &state.charts {
                let error = chart.faces.iter().map(|f| {
                    surface.1.face_areas[f.index()]
                        * (normals[f.index()] - chart.proxy).norm_squared()
                });
                worst = worst.max(error.sum());
            }
            // The same sum in the same order, over the area.
            assert!((worst / surface.1.total_area() - state.worst).abs() < 1e-14, "{name}");
        }
    }
}

#[test]
fn every_component_and_every_part_of_a_stroke_begins_a_chart() {
    // Three flat sheets that do not touch.
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..3u32 {
        let first = points.len() as u32;
        for i in 0..8u32 {
            points.push(Point3::new(f64::from(i / 2), f64::from(i % 2), f64::from(k)));
        }
        for i in [0, 2, 4] {
            let [a, b, c, d] = [i, i + 2, i + 3, i + 1].map(|v| first + v);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let mesh = Arc::new(Mesh::new(points.len(), &triangles).unwrap());
    let geometry = Arc::new(Geometry::new(&mesh, points).unwrap());
    let flow = approximate(&(mesh.clone(), geometry.clone()), with(0.005));
    assert_eq!(assert_complete(&mesh, &flow.state().face_charts), 3);

    // One label in two parts on the first sheet, another on the second.
    let mut strokes = vec![None; mesh.face_count()];
    (strokes[0], strokes[5], strokes[8]) = (Some(0), Some(0), Some(u32::MAX));
    let flow = VsaFlow::from_strokes(mesh.clone(), geometry, with(0.005), &strokes).unwrap();
    let state = flow.state();
    assert_eq!(assert_complete(&mesh, &state.face_charts), 4);
    assert_ne!(state.face_charts[0], state.face_charts[5]);
}

#[test]
fn labels_for_all_faces_are_charts_to_go_on_from() {
    let surface = shape(Surface::sphere(6));
    let (mesh, geometry) = &surface;
    // As hostile as can be: neighbours hardly ever share a label.
    let strokes: Vec<Option<u32>> =
        (0..mesh.face_count() as u32).map(|f| Some(f.wrapping_mul(2_654_435_761) >> 29)).collect();
    let params = with(0.05);
    let mut flow = VsaFlow::from_strokes(mesh.clone(), geometry.clone(), params, &strokes).unwrap();
    let begun = assert_complete(mesh, &flow.state().face_charts);
    assert!(begun > 100);
    // Fewer charts allowed: pairs are joined.
    flow.set_params(VsaParams { max_charts: 20, ..params }).unwrap();
    finish(&mut flow);
    let count = assert_complete(mesh, &flow.state().face_charts);
    assert!((2..=20).contains(&count) && flow.state().worst <= 0.05, "{count}");
}

#[test]
fn a_run_repeats_bit_for_bit_descends_goes_on_from_a_checkpoint_and_ends_quietly() {
    let (mesh, geometry) = shape(Surface::sphere(9));
    // A patch of area a of a sphere of area 1 has the error a², so that there are more than 1/√ε.
    let params = with(0.0008);
    let new = || VsaFlow::new(mesh.clone(), geometry.clone(), params).unwrap();
    let (mut whole, mut errors, mut total) = (new(), vec![f64::INFINITY], 0);
    while whole.status() == Status::Running {
        let report = whole.step().unwrap();
        errors.push(report.energy[0].1);
        total = report.step;
        assert_complete(&mesh, &whole.state().face_charts);
        assert_eq!(report.energy[2].1, whole.state().charts.len() as f64);
    }
    assert!(errors.windows(2).all(|e| e[1] <= e[0]), "{errors:?}");
    assert!(whole.state().charts.len() > 30, "teleports had their turn");
    for split in [1, total / 2, total - 1] {
        let mut first = new();
        for _ in 0..split {
            first.step().unwrap();
        }
        let mut second = new();
        second.step().unwrap();
        second.restore(&first.checkpoint());
        assert_eq!(first.state(), second.state());
        finish(&mut second);
        assert_eq!(second.state(), whole.state(), "{split}");
    }
    let checkpoint = whole.checkpoint();
    assert_eq!(whole.step().unwrap().step, total);
    assert_eq!(whole.checkpoint(), checkpoint);
}

#[test]
fn a_live_tolerance_adds_charts_or_joins_them() {
    let (mesh, geometry) = shape(Surface::sphere(9));
    let mut flow = approximate(&(mesh.clone(), geometry), with(0.02));
    let few = flow.state().charts.len();
    flow.set_params(with(0.005)).unwrap();
    assert_eq!(flow.state().phase, VsaPhase::Grow);
    finish(&mut flow);
    let many = assert_complete(&mesh, &flow.state().face_charts);
    assert!(many > 2 * few && flow.state().worst <= 0.005, "{few} {many}");
    flow.set_params(with(0.02)).unwrap();
    while flow.status() == Status::Running {
        flow.step().unwrap();
        assert_complete(&mesh, &flow.state().face_charts);
    }
    let again = flow.state().charts.len();
    // Joining pairs is greedy: within half as many again of what growing finds.
    assert!(2 * again <= 3 * few && flow.state().worst <= 0.02, "{few} {again}");
    let checkpoint = flow.checkpoint();
    flow.set_params(*flow.params()).unwrap();
    assert_eq!(flow.checkpoint(), checkpoint);
    let refused = flow.set_params(with(0.0));
    assert!(matches!(refused, Err(SolveError::Parameter { name: "tolerance of charts", .. })));
    assert_eq!(flow.checkpoint(), checkpoint);
}

#[test]
fn scale_and_place_do_not_matter() {
    let surface = Surface::sample("torus");
    let base = approximate(&shape(Surface::sample("torus")), with(0.01));
    // A power of two and a turn by a quarter: no bit of a normal or of a quotient of areas changes.
    let points = surface.geometry.positions.iter().map(|p| Point3::new(-p.y, p.x, p.z) * 1024.0);
    let geometry = Geometry::new(&surface.mesh, points.collect()).unwrap();
    let moved = approximate(&(Arc::new(surface.mesh), Arc::new(geometry)), with(0.01));
    assert_eq!(base.state().face_charts, moved.state().face_charts);
}

#[test]
fn starts_are_different_faces_far_apart() {
    let (mesh, geometry) = fine_cube(4);
    let starts = start_faces(&mesh, &geometry, FaceId(5), 6);
    assert_eq!((starts.len(), starts[0]), (6, FaceId(5)));
    let centre = |f: FaceId| {
        let corners = mesh.face_vertices(f).map(|v| geometry.positions[v.index()].coords);
        (corners[0] + corners[1] + corners[2]) / 3.0
    };
    for (i, &f) in starts.iter().enumerate() {
        // Six points on a cube of side 4 can be farther apart than half a side.
        assert!(starts[..i].iter().all(|&g| (centre(f) - centre(g)).norm() > 2.0));
    }
    assert_eq!(start_faces(&mesh, &geometry, FaceId(0), 1000).len(), mesh.face_count());
    assert!(start_faces(&mesh, &geometry, FaceId(9999), 3).is_empty());
}

#[test]
fn what_is_out_of_range_is_refused() {
    let (mesh, geometry) = shape(Surface::from_soup("cylinder", &cylinder(12, 3)));
    let new = |params| VsaFlow::new(mesh.clone(), geometry.clone(), params).err();
    for (params, wanted) in [
        (with(f64::NAN), "tolerance of charts"),
        (VsaParams { max_charts: 0, ..with(0.1) }, "most charts"),
        (VsaParams { lloyd: 0, ..with(0.1) }, "floods about a chart"),
        (VsaParams { seed_face: FaceId(999), ..with(0.1) }, "first face"),
    ] {
        let error = new(params);
        assert!(
            matches!(error, Some(SolveError::Parameter { name, .. }) if name == wanted),
            "{error:?}"
        );
    }
    let few =
        approximate(&(mesh.clone(), geometry.clone()), VsaParams { max_charts: 2, ..with(1e-3) });
    assert_eq!((few.status(), few.state().charts.len()), (Status::Stalled, 2));
}

/// The notes ask for about 60 charts on a bunny between .004 and .007; the paper had 61 on its own.
#[test]
fn shared_surfaces_have_as_many_charts_as_the_paper_lets_expect() {
    for (name, tolerance, range) in [
        // Counted once; a change of more than a fifth is a change of method.
        ("spot.obj", 0.005, 50..=74),
        ("fandisk.obj", 0.005, 21..=31),
        ("homer.obj", 0.005, 48..=70),
    ] {
        let Some(surface) = Surface::shared(name) else { continue };
        let surface = shape(surface);
        let flow = approximate(&surface, with(tolerance));
        let count = assert_complete(&surface.0, &flow.state().face_charts);
        assert!(range.contains(&count), "{name}: {count}");
        if name == "fandisk.obj" {
            flat_faces_are_in_one_chart(&surface, &flow);
        }
    }
}

/// Coplanar faces that hang together and are at least a hundredth of the surface have one chart, all but a fringe.
fn flat_faces_are_in_one_chart((mesh, geometry): &Shape, flow: &VsaFlow) {
    let normals = geometry.face_normals(mesh);
    let charts = &flow.state().face_charts;
    let mut seen = vec![false; mesh.face_count()];
    let mut planes = 0;
    for seed in mesh.faces() {
        if std::mem::replace(&mut seen[seed.index()], true) {
            continue;
        }
        let mut plane = vec![seed];
        let mut next = 0;
        while let Some(&f) = plane.get(next) {
            next += 1;
            for h in mesh.face_halfedges(f) {
                let Some(g) = mesh.face(h.twin()) else { continue };
                // The file has seven digits: planes are flat to 1e-3.
                let is_flat = (normals[g.index()] - normals[seed.index()]).norm() < 1e-3;
                if is_flat && !std::mem::replace(&mut seen[g.index()], true) {
                    plane.push(g);
                }
            }
        }
        let area = |faces: &mut dyn Iterator<Item = &FaceId>| -> f64 {
            faces.map(|f| geometry.face_areas[f.index()]).sum()
        };
        let whole = area(&mut plane.iter());
        if whole < 0.01 * geometry.total_area() {
            continue;
        }
        planes += 1;
        let most = (0..flow.state().charts.len() as u32)
            .map(|c| area(&mut plane.iter().filter(|f| charts[f.index()] == c)))
            .fold(0.0, f64::max);
        assert!(most > 0.98 * whole, "plane of face {}: {}", seed.0, most / whole);
    }
    assert!(planes >= 6, "{planes}");
}
