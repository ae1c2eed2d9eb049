//! Identities of the energy, of flips and of taking them back, on surfaces whose edges flip in hundreds.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, Point3};

use super::develop::rewind;
use super::part::{Limits, Part, components};
use super::solver::{Progress, Solver};
use super::targets::Condition;
use super::triangulation::Keeps;
use crate::linalg::dot;
use crate::mesh::Mesh;

const LIMITS: Limits = Limits { tolerance: 1e-10, most_steps: 50 };

/// A torus with a dented tube and oblong, sheared quads: far from Delaunay.
fn torus(around: u32, along: u32) -> (Mesh, Vec<Point3<f64>>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..along {
        for j in 0..around {
            let a = TAU * f64::from(i) / f64::from(along);
            let b = TAU * f64::from(j) / f64::from(around) + 1.5 * a.sin();
            let tube = 0.4 + 0.15 * (2.0 * a).cos() + 0.05 * (3.0 * b).sin();
            let r = 1.0 + tube * b.cos();
            positions.push(Point3::new(r * a.cos(), r * a.sin(), tube * b.sin()));
            let at = |i: u32, j: u32| (i % along) * around + j % around;
            let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[p, q, r], [p, r, s]]);
        }
    }
    (Mesh::new(positions.len(), &triangles).unwrap(), positions)
}

/// The one part of a mesh, with a curvature at every vertex.
fn part(mesh: &Mesh, positions: &[Point3<f64>], cones: &[f64], limits: Limits) -> Part {
    let lengths: Vec<f64> = mesh
        .edges()
        .map(|e| {
            let [a, b] = mesh.edge_vertices(e).map(|v| positions[v.index()]);
            (b - a).norm()
        })
        .collect();
    let flat = |v| if mesh.is_boundary_vertex(v) { PI } else { TAU };
    let conditions: Vec<Condition> =
        mesh.vertices().map(|v| Condition::Angle(flat(v) - cones[v.index()])).collect();
    let start = vec![0.0; conditions.len()];
    let faces = components(mesh).remove(0);
    Part::new(mesh, faces, &lengths, 0.0, &conditions, &start, limits, None)
}

fn solver_on_torus() -> Solver {
    let (mesh, positions) = torus(12, 30);
    let mut cones = vec![0.0; mesh.vertex_count()];
    (cones[40], cones[200], cones[300]) = (PI, 0.5 * PI, -1.5 * PI);
    part(&mesh, &positions, &cones, LIMITS).solver.unwrap()
}

/// Numbers between −1 and 1 without any order.
fn noise(n: usize) -> Vec<f64> {
    (0..n).map(|i| 2.0 * ((i as f64 * 0.618_033_988_749_895 * 7.0) % 1.0) - 1.0).collect()
}

fn along(solver: &Solver, direction: &[f64], t: f64) -> Vec<f64> {
    solver.v.iter().zip(direction).map(|(v, d)| v + t * d).collect()
}

fn energy_at(solver: &Solver, v: &[f64]) -> f64 {
    solver.energy(&solver.evaluate(v), v)
}

/// A direction of the vertices that are sought.
fn direction(solver: &Solver) -> Vec<f64> {
    let noise = noise(solver.v.len());
    (0..noise.len()).map(|i| if solver.is_sought(i) { noise[i] } else { 0.0 }).collect()
}

#[test]
fn gradient_and_hessian_are_derivatives_of_the_energy() {
    let solver = solver_on_torus();
    let d = direction(&solver);
    let h = 1e-5;
    let [low, high] = [-h, h].map(|t| along(&solver, &d, t));
    let slope = (energy_at(&solver, &high) - energy_at(&solver, &low)) / (2.0 * h);
    let exact = dot(&solver.evaluation.gradient, &d);
    // E is 1e3 with rounding 1e-13 over 2e-5, and h² of its third derivative.
    assert!((slope / exact - 1.0).abs() < 1e-6, "{slope} {exact}");
    let product = solver.hessian_times(&d);
    let (above, below) = (solver.evaluate(&high).gradient, solver.evaluate(&low).gradient);
    let size = product.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
    for i in (0..d.len()).filter(|&i| solver.is_sought(i)) {
        let change = (above[i] - below[i]) / (2.0 * h);
        // h² of third derivatives, cotangents of 10 to the third.
        assert!((change - product[i]).abs() < 1e-6 * size, "{i}: {change} {}", product[i]);
    }
}

#[test]
fn energy_and_slope_agree_along_a_line_with_hundreds_of_flips_and_the_slope_only_rises() {
    let mut solver = solver_on_torus();
    let d: Vec<f64> = direction(&solver).iter().map(|d| 2.0 * d).collect();
    let before = solver.triangulation.flipped.len();
    let intervals = 2000;
    let (mut sum, mut last) = (0.0, f64::NEG_INFINITY);
    let mut ends = [0.0; 2];
    for k in 0..=intervals {
        let v = along(&solver, &d, f64::from(k) / f64::from(intervals));
        assert!(solver.triangulation.make_delaunay(&v, Keeps::Conformal));
        let slope = dot(&solver.evaluate(&v).gradient, &d);
        assert!(slope >= last, "convex: {slope} after {last}");
        last = slope;
        let weight = if k == 0 || k == intervals { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        sum += weight * slope / (3.0 * f64::from(intervals));
        if k == 0 {
            ends[0] = energy_at(&solver, &v);
        } else if k == intervals {
            ends[1] = energy_at(&solver, &v);
        }
    }
    assert!(solver.triangulation.flipped.len() - before > 300);
    let difference = ends[1] - ends[0];
    // Slopes have kinks in their second derivative at flips: third order of 1 / 2000 there.
    assert!((sum / difference - 1.0).abs() < 1e-9, "{sum} {difference}");
}

#[test]
fn every_step_lowers_the_energy_and_one_that_does_not_is_told_from_one_that_does() {
    let mut solver = solver_on_torus();
    let d = direction(&solver);
    solver.v = along(&solver, &d, 3.0);
    let start = solver.v.clone();
    solver.triangulation.make_delaunay(&start, Keeps::Conformal);
    solver.evaluation = solver.evaluate(&start);
    // Along the gradient E falls, against it it rises.
    let gradient = solver.evaluation.gradient.clone();
    let slope = 1e-3 * dot(&gradient, &gradient);
    let up = along(&solver, &gradient, 1e-3);
    assert!(solver.where_lower(&up, -1e-4 * slope).is_none());
    let down = along(&solver, &gradient, -1e-3);
    let there = solver.where_lower(&down, -1e-4 * slope).unwrap();
    assert!(there.error < solver.evaluation.error);
    assert!(solver.triangulation.make_delaunay(&start, Keeps::Conformal));
    let mut energy = energy_at(&solver, &start);
    let mut steps = 0;
    while solver.progress == Progress::Running {
        solver.step().unwrap();
        let v = solver.v.clone();
        let now = energy_at(&solver, &v);
        // Rounding of a sum of hundreds.
        assert!(now <= energy + 1e-10, "{now} after {energy}");
        energy = now;
        steps += 1;
    }
    assert!(solver.progress == Progress::Done && steps > 3, "{steps}");
}

#[test]
fn angles_do_not_depend_on_the_way_flips_were_made() {
    let mut wandering = solver_on_torus();
    let direct = wandering.clone();
    let d: Vec<f64> = direction(&wandering).iter().map(|d| 2.0 * d).collect();
    for t in [0.3, -0.5, 0.8, 0.1, 1.0] {
        let v = along(&direct, &d, t);
        assert!(wandering.triangulation.make_delaunay(&v, Keeps::Conformal));
    }
    let v = along(&direct, &d, 1.0);
    let mut straight = direct;
    assert!(straight.triangulation.make_delaunay(&v, Keeps::Conformal));
    let detour = wandering.triangulation.flipped.len() - straight.triangulation.flipped.len();
    assert!(detour > 300, "{detour}");
    let (a, b) = (wandering.evaluate(&v).gradient, straight.evaluate(&v).gradient);
    for (a, b) in a.iter().zip(&b) {
        // A rounding of 1e-16 for each of some flips, times cotangents.
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn flips_taken_back_give_the_triangles_of_the_surface_with_the_angles_asked_for() {
    let mut solver = solver_on_torus();
    while solver.progress == Progress::Running {
        solver.step().unwrap();
    }
    assert_eq!(solver.progress, Progress::Done);
    assert!(solver.steps <= 8 && solver.degenerate_faces() == 0, "{}", solver.steps);
    let mut tri = solver.triangulation.clone();
    let flips = tri.flipped.len();
    assert!(flips > 100 && tri.surface_flips > 0 && tri.surface_flips < flips);
    let sides = rewind(&tri, &solver.v);
    while let Some(h) = tri.flipped.pop() {
        tri.unflip(h);
    }
    let (mesh, _) = torus(12, 30);
    let mut sums = vec![0.0; solver.v.len()];
    for f in 0..tri.face_count() {
        let own = tri.sides(f);
        let z = own.map(|h| sides[h as usize].z);
        let around: Complex<f64> = z.iter().sum();
        assert!(around.norm() < 1e-13 * z.iter().map(|z| z.norm()).sum::<f64>());
        let mut corners = own.map(|h| tri.tail[h as usize]);
        corners.sort_unstable();
        let mut given = mesh.face_vertices((f).into()).map(|v| v.0);
        given.sort_unstable();
        assert_eq!(corners, given, "face {f}");
        for i in 0..3 {
            // From this side to the one before, turned around: signed.
            let angle = (-z[(i + 2) % 3] / z[i]).arg();
            sums[tri.tail[own[i] as usize] as usize] += angle;
        }
    }
    for e in 0..tri.edge_count() {
        let [h, t] = [sides[2 * e], sides[2 * e + 1]];
        assert!((h.z.norm() / t.z.norm() - 1.0).abs() < 1e-12);
        assert!((h.z + h.r * t.z).norm() < 1e-12 * h.z.norm(), "r takes one to the other");
        assert!((h.r * t.r - 1.0).norm() < 1e-14 && (h.r.norm() - 1.0).abs() < 1e-13);
    }
    for (sum, target) in sums.iter().zip(&solver.targets) {
        // At a corner on its back the argument is one turn less.
        let turns = (sum - target) / TAU;
        assert!((turns - turns.round()).abs() < 1e-12, "{sum} {target}");
    }
}

#[test]
fn a_step_that_goes_wrong_leaves_the_state_where_it_was() {
    let mut solver = solver_on_torus();
    solver.v[7] = f64::NAN;
    solver.evaluation = solver.evaluate(&solver.v);
    assert!(solver.evaluation.error.is_nan());
    solver.step().unwrap();
    assert_eq!((solver.progress, solver.steps), (Progress::Failed, 0));
}
