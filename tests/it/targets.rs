//! Rims that are told what to be: angles and lengths are kept, shapes are what they are called, and what cannot be is refused.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use cutflow::flatten::{
    Interior, RimTarget, TargetChart, TargetError, TargetSolver, bff, flatten_sphere,
};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, FaceId, Mesh, OpenedMesh, VertexId};
use cutflow::methods::cutgraph::cut_through;
use nalgebra::{Point2, Point3};

use super::surfaces::{Surface, cylinder};

/// A surface with boundary, opened along nothing.
struct Patch {
    opened: OpenedMesh,
    geometry: Geometry,
}

impl Patch {
    fn new(mesh: &Mesh, positions: Vec<Point3<f64>>) -> Self {
        let opened = CutMesh::uncut(mesh).open().unwrap();
        let geometry = Geometry::measure(&opened.mesh, positions);
        Self { opened, geometry }
    }

    /// Rings of 6 i vertices about a centre, put in space.
    fn disk(n: u32, lift: impl Fn(f64, f64) -> [f64; 3]) -> Self {
        let start = |i: u32| if i == 0 { 0 } else { 1 + 3 * i * (i - 1) };
        let mut positions = vec![Point3::from(lift(0.0, 0.0))];
        for i in 1..=n {
            for k in 0..6 * i {
                let (sin, cos) = (TAU * f64::from(k) / f64::from(6 * i)).sin_cos();
                let r = f64::from(i) / f64::from(n);
                positions.push(Point3::from(lift(r * cos, r * sin)));
            }
        }
        let mut triangles = Vec::new();
        for i in 1..=n {
            let outer = |k: u32| start(i) + k % (6 * i);
            let inner = |k: u32| if i == 1 { 0 } else { start(i - 1) + k % (6 * (i - 1)) };
            for side in 0..6 {
                for k in 0..i {
                    let (o, p) = (side * i + k, side * (i - 1) + k);
                    triangles.push([outer(o), outer(o + 1), inner(p)]);
                    if k + 1 < i {
                        triangles.push([inner(p), outer(o + 1), inner(p + 1)]);
                    }
                }
            }
        }
        Self::new(&Mesh::new(positions.len(), &triangles).unwrap(), positions)
    }

    fn hemisphere(n: u32) -> Self {
        Self::disk(n, |x, y| {
            let (r, angle) = (x.hypot(y), y.atan2(x));
            let polar = r * FRAC_PI_2;
            [polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos()]
        })
    }

    /// Neither flat nor symmetric.
    fn bumpy(n: u32) -> Self {
        Self::disk(n, |x, y| {
            let up = 0.4 * (1.0 - x * x - y * y) + 0.1 * (5.0 * x + 1.0).sin() * (4.0 * y).cos();
            [1.3 * x + 0.1 * y * y, y, up]
        })
    }

    fn solver(&self) -> TargetSolver<'_> {
        TargetSolver::new(&self.opened, &self.geometry, 0).unwrap()
    }
}

/// What holds for any chart: its cost, and counter-clockwise faces.
fn flatten(solver: &mut TargetSolver<'_>, target: &RimTarget) -> TargetChart {
    let chart = solver.flatten(target, Interior::Harmonic).unwrap();
    assert!(chart.effort.factorisations <= 2 && chart.effort.solves <= 8, "{:?}", chart.effort);
    chart
}

/// Places of the rim, in order.
fn rim(patch: &Patch, solver: &TargetSolver<'_>, chart: &TargetChart) -> Vec<Point2<f64>> {
    let place = |v: VertexId| chart.places[solver.vertices().binary_search(&v).unwrap()];
    solver.rim().iter().map(|&h| place(patch.opened.mesh.tail(h))).collect()
}

/// The turn at each corner of a closed polygon.
fn turns(rim: &[Point2<f64>]) -> Vec<f64> {
    let n = rim.len();
    (0..n)
        .map(|i| {
            let (from, to) = (rim[i] - rim[(i + n - 1) % n], rim[(i + 1) % n] - rim[i]);
            from.perp(&to).atan2(from.dot(&to))
        })
        .collect()
}

fn flipped(patch: &Patch, chart: &TargetChart) -> usize {
    // The patch is the whole mesh: names are numbers.
    let area = |t: &[VertexId; 3]| {
        let [a, b, c] = t.map(|v| chart.places[v.index()]);
        (b - a).perp(&(c - a))
    };
    patch.opened.mesh.triangles().iter().filter(|t| !(area(t) > 0.0)).count()
}

#[test]
fn the_disk_of_a_hemisphere_is_its_stereographic_image() {
    let mut errors = Vec::new();
    for n in [8, 16, 32] {
        let patch = Patch::hemisphere(n);
        let mut solver = patch.solver();
        let exact = |v: usize| -(1.0 + patch.geometry.positions[v].z).ln();
        // The equator keeps its length in the plane: u = 0 there.
        let isometric = flatten(&mut solver, &RimTarget::Isometric);
        let disk = flatten(&mut solver, &RimTarget::Disk);
        assert_eq!(flipped(&patch, &disk), 0);
        println!("{n}: {}", disk.change);
        assert!(disk.change < 1e-7, "{}", disk.change);
        let radii: Vec<f64> = rim(&patch, &solver, &disk).iter().map(|p| p.coords.norm()).collect();
        let spread = radii.iter().fold(0.0, |m: f64, r| m.max((r / radii[0] - 1.0).abs()));
        assert!(spread < 1e-12, "round whatever the triangles: {spread}");
        let count = patch.opened.mesh.vertex_count();
        let u_error = (0..count).map(|v| (isometric.u[v] - exact(v)).abs()).fold(0.0, f64::max);
        let shift = disk.u[0] - exact(0);
        let disk_error =
            (0..count).map(|v| (disk.u[v] - exact(v) - shift).abs()).fold(0.0, f64::max);
        let image_error = (0..count)
            .map(|v| {
                let p = patch.geometry.positions[v];
                let r = p.x.hypot(p.y) / (1.0 + p.z);
                (disk.places[v].coords.norm() / radii[0] - r).abs()
            })
            .fold(0.0, f64::max);
        errors.push([u_error, disk_error, image_error]);
    }
    for pair in errors.windows(2) {
        for (coarse, fine) in pair[0].iter().zip(pair[1]) {
            // Second order.
            assert!(coarse / fine > 3.2, "{errors:?}");
        }
    }
    assert!(errors[2].iter().all(|&e| e < 2e-3), "{errors:?}");
}

#[test]
fn rectangles_have_right_angles_and_straight_sides() {
    let mut patches = vec![Patch::bumpy(14), Patch::hemisphere(10)];
    if let Some(face) = Surface::shared("face.obj") {
        patches.push(Patch::new(&face.mesh, face.geometry.positions.clone()));
    }
    for patch in &patches {
        let mut solver = patch.solver();
        let n = solver.rim().len();
        let at = |i: usize| patch.opened.mesh.tail(solver.rim()[i]);
        let positions = [0, n / 5, n / 2, 4 * n / 5];
        let target = RimTarget::Rectangle(positions.map(at).to_vec());
        let chart = flatten(&mut solver, &target);
        assert_eq!(chart.effort.factorisations, 2);
        assert_eq!(chart.effort.solves, 3);
        let rim = rim(patch, &solver, &chart);
        for (i, turn) in turns(&rim).into_iter().enumerate() {
            let wanted = if positions.contains(&i) { FRAC_PI_2 } else { 0.0 };
            // Rounding of places, over the shortest side.
            assert!((turn - wanted).abs() < 1e-9, "{turn} at {i}");
        }
        // Straight sides as a whole, too.
        for k in 0..4 {
            let (from, to) = (positions[k], if k == 3 { n } else { positions[k + 1] });
            let along = rim[to % n] - rim[from];
            let off = (from..to).map(|i| along.normalize().perp(&(rim[i] - rim[from])).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9 * along.norm());
        }
        let flips = flipped(patch, &chart);
        assert!(flips <= 3, "{flips}");
        // Least area distortion: no other size is better.
        let distortion = |scale: f64| -> f64 {
            let of_face = |f: FaceId| {
                let [a, b, c] =
                    patch.opened.mesh.face_vertices(f).map(|v| chart.places[v.index()] * scale);
                let area = 0.5 * (b - a).perp(&(c - a)).abs();
                let own = patch.geometry.face_areas[f.index()];
                own * (0.5 * (area / own).ln()).powi(2)
            };
            patch.opened.mesh.faces().map(of_face).sum()
        };
        if flips == 0 {
            assert!(distortion(1.0) <= distortion(1.001));
            assert!(distortion(1.0) <= distortion(0.999));
        }
    }
}

#[test]
fn polygons_and_free_angles_turn_as_they_are_told() {
    let patch = Patch::bumpy(10);
    let mut solver = patch.solver();
    let n = solver.rim().len();
    let at = |solver: &TargetSolver<'_>, i: usize| patch.opened.mesh.tail(solver.rim()[i]);
    // A triangle, an L and a wavy outline.
    let triangle = [(3, TAU / 3.0), (25, TAU / 3.0), (44, TAU / 3.0)];
    let l = [(0, 1.0), (9, 1.0), (20, 1.0), (30, -1.0), (39, 1.0), (50, 1.0)]
        .map(|(i, turns)| (i, FRAC_PI_2 * turns));
    for corners in [&triangle[..], &l[..]] {
        let named = corners.iter().map(|&(i, angle)| (at(&solver, i), angle)).collect();
        let chart = flatten(&mut solver, &RimTarget::Polygon(named));
        let found = turns(&rim(&patch, &solver, &chart));
        for (i, turn) in found.into_iter().enumerate() {
            let wanted = corners.iter().find(|c| c.0 == i).map_or(0.0, |c| c.1);
            assert!((turn - wanted).abs() < 1e-9);
        }
    }
    let wave = |i: usize| TAU / n as f64 + 0.1 * (TAU * 3.0 * i as f64 / n as f64).sin();
    let angles: Vec<f64> = (0..n).map(wave).collect();
    let chart = flatten(&mut solver, &RimTarget::Angles(angles.clone()));
    assert_eq!(chart.effort.factorisations, 0, "both factors are there already");
    for (turn, wanted) in turns(&rim(&patch, &solver, &chart)).iter().zip(&angles) {
        assert!((turn - wanted).abs() < 1e-9);
    }
    assert_eq!(flipped(&patch, &chart), 0);
    // Angles that scale factors made give these back.
    let scales: Vec<f64> = (0..n).map(|i| 0.2 * (TAU * i as f64 / n as f64).cos()).collect();
    let scaled = flatten(&mut solver, &RimTarget::Scales(scales.clone()));
    let back = flatten(&mut solver, &RimTarget::Angles(scaled.exterior_angles.clone()));
    let shift = back.u[0] - scaled.u[0];
    let worst = back.u.iter().zip(&scaled.u).map(|(a, b)| (a - b - shift).abs());
    // Two solves with condition numbers of a few thousand.
    assert!(worst.fold(0.0, f64::max) < 1e-11);
}

#[test]
fn lengths_are_kept_and_a_free_rim_has_the_best_size() {
    let patch = Patch::bumpy(12);
    let mut solver = patch.solver();
    let own: Vec<f64> = solver.rim().iter().map(|h| patch.geometry.edge_length(h.edge())).collect();
    let isometric = flatten(&mut solver, &RimTarget::Isometric);
    let twice = own.iter().map(|l| 2.0 * l).collect();
    let doubled = flatten(&mut solver, &RimTarget::Lengths(twice));
    for (a, b) in isometric.places.iter().zip(&doubled.places) {
        assert!((b - a * 2.0).norm() < 1e-12);
    }
    let n = own.len();
    let ease = |i: usize| own[i] * (1.0 + 0.3 * (TAU * 2.0 * i as f64 / n as f64).sin());
    let lengths: Vec<f64> = (0..n).map(ease).collect();
    let chart = flatten(&mut solver, &RimTarget::Lengths(lengths.clone()));
    let corners = rim(&patch, &solver, &chart);
    assert!(chart.closing < 0.02, "{}", chart.closing);
    for (i, length) in lengths.iter().enumerate() {
        let ratio = (corners[(i + 1) % n] - corners[i]).norm() / length;
        assert!(ratio.ln().abs() < chart.closing + 1e-12);
    }
    let free = flatten(&mut solver, &RimTarget::Free);
    let factor = free.places[0].coords.norm() / isometric.places[0].coords.norm();
    for (a, b) in isometric.places.iter().zip(&free.places) {
        assert!((b - a * factor).norm() < 1e-12, "the same but for its size");
    }
}

#[test]
fn flat_surfaces_come_back_unchanged_by_every_way() {
    // A flat patch without symmetry, rim and all.
    let patch = Patch::disk(9, |x, y| [1.2 * x + 0.2 * y * y, y + 0.15 * (3.0 * x).sin(), 0.0]);
    let flat = |v: usize| Point2::new(patch.geometry.positions[v].x, patch.geometry.positions[v].y);
    let count = patch.opened.mesh.vertex_count();
    let mut solver = patch.solver();
    let n = solver.rim().len();
    let outline: Vec<Point2<f64>> =
        solver.rim().iter().map(|&h| flat(patch.opened.mesh.tail(h).index())).collect();
    let lengths = (0..n).map(|i| (outline[(i + 1) % n] - outline[i]).norm()).collect();
    for target in [
        RimTarget::Isometric,
        RimTarget::Free,
        RimTarget::Scales(vec![0.0; n]),
        RimTarget::Lengths(lengths),
        RimTarget::Angles(turns(&outline)),
    ] {
        let interiors = match target {
            RimTarget::Angles(_) => &[Interior::Harmonic][..],
            _ => &[Interior::Harmonic, Interior::Conjugate],
        };
        for &interior in interiors {
            let chart = solver.flatten(&target, interior).unwrap();
            let mut worst = 0.0f64;
            for v in (0..count).step_by(7) {
                for w in (0..v).step_by(5) {
                    let (a, b) = (chart.places[v] - chart.places[w], flat(v) - flat(w));
                    worst = worst.max((a.norm() - b.norm()).abs());
                }
            }
            assert!(worst < 1e-10, "{target:?} {interior:?}: {worst}");
            assert!(chart.u.iter().all(|u| u.abs() < 1e-10));
            assert_eq!(flipped(&patch, &chart), 0);
        }
    }
}

#[test]
fn a_conjugate_coordinate_agrees_with_a_harmonic_one_ever_better() {
    let mut errors = Vec::new();
    for n in [8, 16, 32] {
        let patch = Patch::bumpy(n);
        let mut solver = patch.solver();
        let [harmonic, conjugate] = [Interior::Harmonic, Interior::Conjugate].map(|interior| {
            let chart = solver.flatten(&RimTarget::Isometric, interior).unwrap();
            assert!(chart.effort.factorisations <= 2 && chart.effort.solves <= 8);
            assert_eq!(flipped(&patch, &chart), 0);
            chart
        });
        // Both begin in the origin.
        let off = harmonic.places.iter().zip(&conjugate.places).map(|(a, b)| (a - b).norm());
        errors.push(off.fold(0.0, f64::max));
    }
    // First order at least: the ends of the rim's sides stand for it.
    assert!(errors[0] / errors[1] > 1.8 && errors[1] / errors[2] > 1.8, "{errors:?}");
    assert!(errors[2] < 0.01, "{errors:?}");
}

#[test]
fn scale_factors_that_partners_share_keep_them_equal() {
    // A sphere slit through three cones: both sides of the seams lie on one rim.
    let surface = Surface::sphere(7);
    let cones = [VertexId(0), VertexId(100), VertexId(300)];
    let seams = cut_through(&surface.mesh, &surface.geometry, &cones, &[]).unwrap();
    let place = |&p: &u32| surface.geometry.positions[p as usize];
    let places = seams.opened.vertex_points.iter().map(place).collect();
    let geometry = Geometry::measure(&seams.opened.mesh, places);
    let mut solver = TargetSolver::new(&seams.opened, &geometry, 0).unwrap();
    let mesh = &seams.opened.mesh;
    let point = |v: VertexId| seams.opened.vertex_points[v.index()];
    let scales: Vec<f64> =
        solver.rim().iter().map(|&h| 0.3 * f64::from(point(mesh.tail(h))).sin()).collect();
    for target in [RimTarget::Isometric, RimTarget::Scales(scales)] {
        let chart = flatten(&mut solver, &target);
        let place = |v: VertexId| chart.places[v.index()];
        let length = |h| (place(mesh.tip(h)) - place(mesh.tail(h))).norm();
        for &h in solver.rim() {
            let ratio = length(h) / length(seams.opened.partner(h).unwrap());
            assert!((ratio - 1.0).abs() < 1e-10, "{ratio}");
        }
        let mut flattening = bff(&seams.opened, &geometry).unwrap();
        solver.put(&chart, &target, &mut flattening);
        assert!(flattening.seams_equal);
    }
    let disk = flatten(&mut solver, &RimTarget::Disk);
    let mut flattening = bff(&seams.opened, &geometry).unwrap();
    solver.put(&disk, &RimTarget::Disk, &mut flattening);
    assert!(!flattening.seams_equal && !flattening.angles_exact);
}

#[test]
fn closed_surfaces_become_centred_spheres() {
    let mut surfaces = vec![Surface::sphere(6), Surface::sphere(12)];
    for (name, stretch) in [("ellipsoid", [1.0, 1.5, 0.6]), ("egg", [1.0, 1.0, 2.0])] {
        let ball = Surface::sphere(14);
        let places: Vec<[f64; 3]> = ball
            .geometry
            .positions
            .iter()
            .map(|p| [p.x * stretch[0], p.y * stretch[1], p.z * stretch[2] * (1.0 + p.z)])
            .collect();
        let (geometry, _) = Geometry::unit_area(&ball.mesh, &places).unwrap();
        surfaces.push(Surface { name: name.to_owned(), geometry, mesh: ball.mesh });
    }
    surfaces.extend(Surface::shared("bunny-closed.obj"));
    surfaces.extend(Surface::shared("spot.obj"));
    // Slender: harmonic coordinates turn 41 triangles over.
    surfaces.extend(Surface::shared("cheburashka.obj"));
    for Surface { name, mesh, geometry } in &surfaces {
        let map = flatten_sphere(mesh, geometry).unwrap();
        // Up to three rounds of raised weights.
        let raised = map.effort.factorisations.saturating_sub(2);
        assert!(raised <= 3 && map.effort.solves <= 8 + 2 * raised, "{name}: {:?}", map.effort);
        assert!(raised == 0 || !name.starts_with("sphere"));
        assert!(map.off_centre < 1e-10, "{name}: {}", map.off_centre);
        let areas = geometry.vertex_dual_areas(mesh);
        let centre = map.positions.iter().zip(&areas).map(|(p, m)| p * *m);
        assert!(centre.sum::<nalgebra::Vector3<f64>>().norm() < 1e-10);
        assert!(map.positions.iter().all(|p| (p.norm() - 1.0).abs() < 1e-12));
        let inward = mesh.triangles().iter().filter(|t| {
            let [a, b, c] = t.map(|v| map.positions[v.index()]);
            !(a.dot(&b.cross(&c)) > 0.0)
        });
        let inward = inward.count();
        assert_eq!((map.flipped.len(), inward), (0, 0), "{name}");
        // A sphere is itself, up to a rotation: distances stay, to second order.
        if name.starts_with("sphere") {
            let radius = geometry.positions[0].coords.norm();
            let worst = mesh
                .edges()
                .map(|e| {
                    let [a, b] = mesh.edge_vertices(e).map(|v| v.index());
                    let own = (geometry.positions[a] - geometry.positions[b]).norm() / radius;
                    ((map.positions[a] - map.positions[b]).norm() / own).ln().abs()
                })
                .fold(0.0, f64::max);
            println!("{name}: {worst}");
            assert!(worst < 0.15, "{name}: {worst}");
        }
    }
    let torus = Surface::sample("torus");
    let refused = flatten_sphere(&torus.mesh, &torus.geometry).err();
    let expected = TargetError::NotASphere { euler: 0, boundary_loops: 0, components: 1 };
    assert_eq!(refused, Some(expected));
}

#[test]
fn no_face_turns_over_inside_a_circle_however_thin_faces_are() {
    let mut raised = 0;
    for height in [0.0, 0.5, 2.0, 8.0] {
        let patch = Patch::disk(14, |x, y| [x, y, height * (11.0 * x).sin() * (9.0 * y).cos()]);
        let mut solver = patch.solver();
        let chart = solver.flatten(&RimTarget::Disk, Interior::Harmonic).unwrap();
        let place = |v: VertexId| chart.places[solver.vertices().binary_search(&v).unwrap()];
        let over = patch.opened.mesh.triangles().iter().filter(|t| {
            let [a, b, c] = t.map(place);
            !((b - a).perp(&(c - a)) > 0.0)
        });
        assert_eq!(over.count(), 0, "{height}");
        raised += usize::from(chart.is_raised);
        assert!(height > 0.0 || !chart.is_raised, "nothing is changed without need");
        // The factor of the true weights is still there: the same again costs solves only, where weights stayed.
        let again = solver.flatten(&RimTarget::Disk, Interior::Harmonic).unwrap();
        assert_eq!(again.places, chart.places);
        assert!(chart.is_raised || again.effort.factorisations == 0);
    }
    assert!(raised > 0);
}

#[test]
fn targets_that_cannot_be_are_refused_with_the_nearest_that_can() {
    let patch = Patch::bumpy(6);
    let mut solver = patch.solver();
    let n = solver.rim().len();
    let rim: Vec<VertexId> = solver.rim().iter().map(|&h| patch.opened.mesh.tail(h)).collect();
    let mut refused =
        |target: RimTarget| solver.flatten(&target, Interior::Harmonic).err().unwrap();
    let angles = vec![0.3; n];
    match refused(RimTarget::Angles(angles.clone())) {
        TargetError::AngleSum { given, shift, count } => {
            assert!((given - 0.3 * n as f64).abs() < 1e-9 && count == n);
            let nearest: f64 = angles.iter().map(|a| a - shift).sum();
            assert!((nearest - TAU).abs() < 1e-9);
        }
        other => panic!("{other}"),
    }
    let mut sharp = vec![(TAU - 3.2) / (n - 1) as f64; n];
    sharp[5] = 3.2;
    assert_eq!(
        refused(RimTarget::Angles(sharp)),
        TargetError::AngleTooLarge { vertex: rim[5], angle: 3.2 }
    );
    assert_eq!(
        refused(RimTarget::Rectangle(rim[..3].to_vec())),
        TargetError::Corners { given: 3, needed: 4 }
    );
    assert_eq!(
        refused(RimTarget::Polygon(vec![(rim[0], PI / 2.0), (rim[3], PI / 2.0)])),
        TargetError::Corners { given: 2, needed: 3 }
    );
    let inside = VertexId(0);
    assert_eq!(
        refused(RimTarget::Rectangle(vec![rim[0], rim[4], inside, rim[9]])),
        TargetError::NoCorner { vertex: inside }
    );
    assert_eq!(
        refused(RimTarget::Rectangle(vec![rim[0], rim[4], rim[4], rim[9]])),
        TargetError::NoCorner { vertex: rim[4] }
    );
    assert_eq!(
        refused(RimTarget::Scales(vec![0.0; 3])),
        TargetError::Count { given: 3, needed: n }
    );
    let mut lengths = vec![1.0; n];
    lengths[7] = -2.0;
    assert_eq!(
        refused(RimTarget::Lengths(lengths)),
        TargetError::Value { position: 7, value: -2.0 }
    );
    let conjugate = solver.flatten(&RimTarget::Disk, Interior::Conjugate).err();
    assert_eq!(conjugate, Some(TargetError::NoConjugate));
    // No disk, no chart.
    let ring = Surface::from_soup("cylinder", &cylinder(12, 4));
    let patch = Patch::new(&ring.mesh, ring.geometry.positions.clone());
    let no_disk = TargetSolver::new(&patch.opened, &patch.geometry, 0).err().unwrap();
    assert!(no_disk.to_string().contains("no disk"), "{no_disk}");
}

#[test]
fn the_ragged_boundary_of_a_scanned_face_takes_every_shape() {
    let Some(face) = Surface::shared("face.obj") else { return };
    let patch = Patch::new(&face.mesh, face.geometry.positions.clone());
    let mut solver = patch.solver();
    for target in [RimTarget::Isometric, RimTarget::Free, RimTarget::Disk] {
        let chart = flatten(&mut solver, &target);
        let flips = flipped(&patch, &chart);
        println!("{target:?}: {flips} flips, change {}, closing {}", chart.change, chart.closing);
        assert!(flips <= 5, "{target:?}: {flips}");
    }
}
