//! Folding: what developable pieces come back to, what others do, what the flow promises.

use std::f64::consts::{PI, TAU};

use cutflow::flatten::{Flattening, FoldFlow, FoldParams, bff};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, Mesh, OpenedMesh};
use cutflow::methods::cutflow::Initial;
use cutflow::methods::flow::{Flow, SolveError, Status};
use nalgebra::{Point3, Rotation3, Vector3};

use crate::surfaces::{Surface, cut_by_flow, grid};

/// A cut surface with its charts.
struct Case {
    opened: OpenedMesh,
    points: Vec<Point3<f64>>,
    charts: Flattening,
}

impl Case {
    fn new(points: Vec<Point3<f64>>, opened: OpenedMesh) -> Self {
        let places = opened.vertex_points.iter().map(|&p| points[p as usize]).collect();
        let charts = bff(&opened, &Geometry::measure(&opened.mesh, places)).unwrap();
        Self { opened, points, charts }
    }

    fn along_edges(
        points: Vec<Point3<f64>>,
        triangles: &[[u32; 3]],
        cut_edges: Vec<[u32; 2]>,
    ) -> Self {
        let mut cut = CutMesh::uncut(&Mesh::new(points.len(), triangles).unwrap());
        cut.cut_edges = cut_edges;
        let opened = cut.open().unwrap();
        Self::new(points, opened)
    }

    /// A surface after some steps of the cut flow, its patches cut to disks.
    fn of_flow(surface: Surface, initial: &Initial, hencky: f64, steps: usize) -> Self {
        let (cut, points) = cut_by_flow(surface, initial, hencky, steps);
        let opened = cut.open().unwrap();
        Self::new(points, opened)
    }

    fn fold(&self, params: FoldParams) -> FoldFlow {
        FoldFlow::new(&self.opened, &self.points, &self.charts, params).unwrap()
    }
}

fn equator() -> Initial {
    Initial::Plane { point: Point3::origin(), normal: Vector3::z() }
}

fn clusters() -> Initial {
    Initial::NormalClusters { angle: 60f64.to_radians(), regions: 10 }
}

/// Nothing but lengths.
fn bare() -> FoldParams {
    FoldParams { bending: 0.0, pull: 0.0, kick: 0.0, ..FoldParams::default() }
}

/// A closed tube of `rows` rows around the z axis, slit along one column.
fn tube(around: u32, rows: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> Case {
    let (points, triangles, _) = grid([around, rows], true, place);
    let at = |i: u32, j: u32| j * around + i;
    Case::along_edges(points, &triangles, (0..rows).map(|j| [at(5, j), at(5, j + 1)]).collect())
}

/// A cube of 6 n² squares, opened to a cross: seven of its twelve edges are cut.
fn cube(n: u32) -> Case {
    let (mut points, mut numbers) = (Vec::new(), std::collections::BTreeMap::new());
    let mut number = |p: [u32; 3]| {
        *numbers.entry(p).or_insert_with(|| {
            points.push(Point3::from(p.map(|x| f64::from(x) / f64::from(n))));
            points.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[u, v]| {
                        let mut p = [0; 3];
                        p[axis] = side;
                        p[(axis + 1) % 3] = u;
                        p[(axis + 2) % 3] = v;
                        number(p)
                    });
                    let [a, b, c, d] = corners;
                    let [a, b, c, d] = if side == 0 { [a, d, c, b] } else { [a, b, c, d] };
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    let mut cuts = Vec::new();
    for i in 0..n {
        // The four edges of the lid but one, and the four upright ones.
        for p in [[[i, 0], [i + 1, 0]], [[i, n], [i + 1, n]], [[0, i], [0, i + 1]]] {
            cuts.push(p.map(|[x, y]| number([x, y, n])));
        }
        for [x, y] in [[0, 0], [n, 0], [n, n], [0, n]] {
            cuts.push([[x, y, i], [x, y, i + 1]].map(&mut number));
        }
    }
    Case::along_edges(points, &triangles, cuts)
}

fn developables() -> Vec<(&'static str, Case)> {
    let cylinder = tube(24, 10, |s, r| [0.3 * (TAU * s).cos(), 0.3 * (TAU * s).sin(), r]);
    // Without its tip: near it paper is infinitely curved.
    let cone = tube(24, 10, |s, r| {
        let radius = 0.15 + 0.35 * r;
        [radius * (TAU * s).cos(), radius * (TAU * s).sin(), -0.8 * r]
    });
    vec![("cylinder", cylinder), ("cone", cone), ("cube", cube(6))]
}

/// Steps until the flow ends or the number is reached, and checks what every step promises.
fn run_checked(flow: &mut FoldFlow, steps: usize) {
    let mut total = flow.state().energy().total;
    for _ in 0..steps {
        let before = flow.steps();
        let report = flow.step().unwrap();
        assert!(report.energy[0].1 <= total, "E rose from {total} in step {}", report.step);
        assert!(report.residual < 1e-9, "residual {}", report.residual);
        assert!(report.step - before <= 1, "a step is one iteration");
        let terms: f64 = report.energy[1..].iter().map(|e| e.1).sum();
        assert!((terms - report.energy[0].1).abs() <= 1e-12 * terms);
        assert!(flow.positions().iter().all(|p| p.iter().all(|x| x.is_finite())));
        total = report.energy[0].1;
        if report.status != Status::Running {
            break;
        }
    }
}

#[test]
fn a_developable_surface_is_its_own_preview() {
    for (name, case) in developables() {
        assert!(case.charts.charts.iter().all(Result::is_ok) && case.opened.patch_count == 1);
        // By its lengths alone it stays where it is, to the rounding of its charts.
        let flow = case.fold(bare());
        assert_eq!(flow.status(), Status::Converged, "{name}: {:?}", flow.state().energy());
        let measures = flow.measures();
        assert!(measures.stretch < 1e-9 && measures.distance_max < 1e-9, "{name}: {measures:?}");
        // As paper, disturbed. Seams fold freely, so a closed tube gets a slight keel along its seam, like a drop: that
        // is what paper does, and a stronger pull undoes it. Bending stretches it by about β / r², 1e-5.
        for (pull, near) in [(0.01, 5e-3), (1.0, 1e-3)] {
            let mut flow = case.fold(FoldParams { pull, ..FoldParams::default() });
            let start = flow.state().energy().total;
            run_checked(&mut flow, 300);
            let measures = flow.measures();
            eprintln!("{name}, pull {pull}: {measures:?} after {} steps", flow.steps());
            assert!(flow.state().energy().total < 0.5 * start, "{name}");
            assert!(
                measures.stretch < 2e-3 && measures.distance_mean < near,
                "{name}: {measures:?}"
            );
        }
    }
}

/// Each half of a sphere flattens to a disk with the equator's length: radius R, and the point at polar angle θ goes to
/// R tan (θ/2). Two such disks sewn along their rims are a flat pillow case.
#[test]
fn the_halves_of_a_sphere_make_a_flat_double_disk() {
    let case = Case::of_flow(Surface::sphere(16), &equator(), 0.0, 0);
    let mut flow = case.fold(FoldParams {
        pull: 0.0,
        bending: 1e-6,
        tolerance: 1e-4,
        ..FoldParams::default()
    });
    let (start, before) = (flow.state().energy().total, flow.measures());
    run_checked(&mut flow, 400);
    let (end, after) = (flow.state().energy(), flow.measures());
    eprintln!("from {start:.3e} {before:?}\nto {end:?} {after:?}");
    assert!(end.total < 1e-3 * start, "{end:?}");
    // The charts' rims are polygons and the halves' triangles chords: 0.3 % of length at this size.
    assert!(after.stretch < 0.02 * before.stretch, "{before:?} {after:?}");
    let radius = 1.0 / (4.0 * PI).sqrt();
    let mut worst = [0.0f64; 2];
    for (from, to) in case.points.iter().zip(flow.positions()) {
        let theta = (from.z.abs() / radius).min(1.0).acos();
        let flat = to.x.hypot(to.y);
        worst[0] = worst[0].max((flat - radius * (theta / 2.0).tan()).abs() / radius);
        worst[1] = worst[1].max(to.z.abs() / radius);
    }
    eprintln!("radius off by {:.4}, height {:.4}", worst[0], worst[1]);
    // Vertices of the coarse sphere's charts are off by the square of an edge, half a percent; slack is what the tolerance
    // leaves, ten times less.
    assert!(worst[0] < 0.01 && worst[1] < 0.01, "{worst:?}");
}

/// Stuffed, the two disks have more rim than room: the equator is drawn in and lies in pleats.
#[test]
fn a_stuffed_double_disk_wrinkles_along_its_seam() {
    let case = Case::of_flow(Surface::sphere(16), &equator(), 0.0, 0);
    let mut flow = case.fold(FoldParams::default());
    let before = flow.measures();
    run_checked(&mut flow, 200);
    let after = flow.measures();
    // Mean distance from the axis in a band beside the seam, sector by sector of 6 degrees.
    let radius = 1.0 / (4.0 * PI).sqrt();
    let mut sectors = [(0.0, 0.0); 60];
    for (from, to) in case.points.iter().zip(flow.positions()) {
        if from.z > 0.1 * radius && from.z < 0.3 * radius {
            let turn = (from.y.atan2(from.x) / TAU).rem_euclid(1.0);
            let (sum, count) = &mut sectors[(turn * 60.0) as usize % 60];
            *sum += to.x.hypot(to.y) / radius;
            *count += 1.0;
        }
    }
    let distances = sectors.map(|(sum, count): (f64, f64)| sum / count);
    let mean = distances.iter().sum::<f64>() / 60.0;
    // Ridges and valleys by turns, each at least 2 % of the radius off the mean.
    let sides: Vec<bool> =
        distances.iter().filter(|d| (*d - mean).abs() > 0.02).map(|d| *d > mean).collect();
    let pleats = (0..sides.len()).filter(|&i| sides[i] && !sides[(i + 1) % sides.len()]).count();
    eprintln!("{pleats} pleats, {before:?} {after:?} after {} steps", flow.steps());
    assert!(pleats >= 4 && mean < 0.97, "{pleats} {mean}");
    assert!(after.stretch < 0.1 * before.stretch, "{before:?} {after:?}");
}

#[test]
fn a_pull_keeps_the_sphere_nearer_and_costs_stretch() {
    let case = Case::of_flow(Surface::sphere(12), &equator(), 0.0, 0);
    let [slack, taut] = [0.01, 0.3].map(|pull| {
        let mut flow = case.fold(FoldParams { pull, ..FoldParams::default() });
        run_checked(&mut flow, 200);
        flow.measures()
    });
    assert!(taut.distance_mean < 0.95 * slack.distance_mean, "{slack:?} {taut:?}");
    assert!(taut.stretch > slack.stretch, "{slack:?} {taut:?}");
}

#[test]
fn the_gradient_is_the_derivative_of_the_energy() {
    let mut cases = vec![Case::of_flow(Surface::sphere(6), &equator(), 0.0, 0)];
    cases.push(Case::of_flow(Surface::sample("rounded_box"), &clusters(), 500.0, 3));
    for case in cases {
        // Large enough weights that every term shows.
        let params = FoldParams { bending: 1e-4, pull: 1.0, kick: 0.5, ..FoldParams::default() };
        let mut flow = case.fold(params);
        for _ in 0..3 {
            flow.step().unwrap();
        }
        for mode in 0..4u32 {
            let direction = |p: usize| {
                let phase = p as f64 * 0.01;
                match mode {
                    0 => [1.0, 0.0, 0.0],
                    1 => case.points[p].coords.into(),
                    2 => [phase.sin(), (2.0 * phase).cos(), (3.0 * phase).sin()],
                    _ => [0, 1, 2].map(|i| ((p * 7919 + i * 104_729) % 1013) as f64 / 506.0 - 1.0),
                }
            };
            // Slivers are 1e-6 of an edge high: a step must be small even beside those.
            let length = 1e-9;
            let (predicted, ahead) = flow.directional_derivative(direction, length);
            let (_, behind) = flow.directional_derivative(direction, -length);
            let actual = (ahead - behind) / (2.0 * length);
            let scale = predicted.abs().max(1e-2 * flow.state().energy().total);
            assert!((actual - predicted).abs() < 1e-3 * scale, "{mode}: {predicted} {actual}");
        }
    }
}

#[test]
fn a_run_repeats_bit_for_bit_goes_on_from_a_checkpoint_and_ends_quietly() {
    let case = Case::of_flow(Surface::sphere(8), &equator(), 0.0, 2);
    let params = FoldParams { tolerance: 0.02, ..FoldParams::default() };
    let (mut whole, mut split) = (case.fold(params), case.fold(params));
    for _ in 0..10 {
        whole.step().unwrap();
    }
    for _ in 0..4 {
        split.step().unwrap();
    }
    let checkpoint = split.checkpoint();
    let mut other = case.fold(params);
    other.step().unwrap();
    other.restore(&checkpoint);
    assert_eq!(other.state(), split.state());
    for _ in 0..6 {
        other.step().unwrap();
    }
    assert_eq!((whole.steps(), whole.state()), (other.steps(), other.state()));
    run_checked(&mut whole, 500);
    assert_eq!(whole.status(), Status::Converged);
    let (end, state) = (whole.steps(), whole.state().clone());
    let report = whole.step().unwrap();
    assert_eq!((report.step, whole.state()), (end, &state));
}

#[test]
fn rigid_motion_and_scale_change_nothing_but_the_unit() {
    let case = Case::of_flow(Surface::sphere(6), &equator(), 0.0, 0);
    let params = FoldParams { kick: 0.0, ..FoldParams::default() };
    let run = |case: &Case| {
        let mut flow = case.fold(params);
        for _ in 0..3 {
            flow.step().unwrap();
        }
        (flow.state().energy(), flow.measures())
    };
    let (energy, measures) = run(&case);
    for scale in [1e-6, 1.0, 1e6] {
        let turn = Rotation3::from_euler_angles(1.0, 2.0, 3.0);
        let move_ = |p: &Point3<f64>| turn * p * scale + Vector3::new(scale, 0.0, 0.0);
        let moved = Case::new(case.points.iter().map(move_).collect(), case.opened.clone());
        let (e, m) = run(&moved);
        for (a, b) in [
            (e.total, energy.total),
            (e.isometry, energy.isometry),
            (e.bending, energy.bending),
            (m.stretch, measures.stretch),
            (m.distance_mean, measures.distance_mean),
        ] {
            // Slivers of 1e-6 leave their heights ten digits, and steps pass that on.
            assert!((a - b).abs() < 1e-6 * b.abs(), "{scale}: {a} {b}");
        }
    }
}

#[test]
fn patches_without_charts_keep_their_lengths() {
    let case = tube(24, 10, |s, r| [0.3 * (TAU * s).cos(), 0.3 * (TAU * s).sin(), r]);
    let mut charts = case.charts.clone();
    charts.uv.iter_mut().for_each(|p| p.x = f64::NAN);
    let flow = FoldFlow::new(&case.opened, &case.points, &charts, bare()).unwrap();
    assert_eq!(flow.status(), Status::Converged);
    assert!(flow.measures().stretch < 1e-14);
}

#[test]
fn nonsense_is_refused_with_its_reason() {
    let case = Case::of_flow(Surface::sphere(4), &equator(), 0.0, 0);
    let new = |points: &[Point3<f64>], params| {
        FoldFlow::new(&case.opened, points, &case.charts, params).err().unwrap()
    };
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let error = new(&case.points, FoldParams { bending: bad, ..FoldParams::default() });
        assert!(matches!(error, SolveError::Parameter { name: "bending stiffness", .. }));
    }
    let mut points = case.points.clone();
    points[3].y = f64::NAN;
    assert_eq!(new(&points, FoldParams::default()), SolveError::NotFinite);
    let heap = vec![Point3::origin(); points.len()];
    assert_eq!(new(&heap, FoldParams::default()), SolveError::NotFinite);
}

#[test]
fn real_models_cut_by_normals_fold_without_exploding() {
    for name in ["spot.obj", "chair.obj"] {
        let Some(surface) = Surface::shared(name) else { continue };
        let case = Case::of_flow(surface, &clusters(), 500.0, 5);
        let mut flow = case.fold(FoldParams::default());
        let (start, before) = (flow.state().energy().total, flow.measures());
        run_checked(&mut flow, 60);
        let (end, after) = (flow.state().energy().total, flow.measures());
        eprintln!("{name}: {start:.3e} {before:?}\n  {end:.3e} {after:?}");
        assert!(end < 0.5 * start && after.stretch < before.stretch, "{name}");
        // The preview of a model resembles the model: no point leaves its neighbourhood.
        assert!(after.distance_mean < 0.05 && after.distance_max < 0.5, "{name}: {after:?}");
    }
}
