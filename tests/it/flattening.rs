//! Flattening: isometry where it is possible, convergence where it is not, counts that are exact.

#![allow(clippy::unwrap_used, reason = "tests, helpers included")]
#![allow(clippy::cast_possible_truncation, reason = "small meshes")]

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use cutflow::flatten::overlap::crossings;
use cutflow::flatten::{Flattening, Measures, NoChart, Packing, bff, bff_with, measure, measures};
use cutflow::geometry::{Geometry, angle_defects};
use cutflow::linalg::{Analysis, Factor, Pattern};
use cutflow::mesh::{CutMesh, EdgeId, FaceId, Mesh, OpenedMesh, SurfacePoint, VertexId};
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial, Weights};
use cutflow::methods::flow::Flow;
use nalgebra::{Point2, Point3, Rotation3, Vector2, Vector3};

/// A surface, opened along a cut.
struct Case {
    own_vertices: usize,
    opened: OpenedMesh,
    geometry: Geometry,
}

impl Case {
    fn new(mesh: &Mesh, positions: &[Point3<f64>], cut: &CutMesh) -> Self {
        let opened = cut.open().unwrap();
        let place = |&p: &u32| match cut.points[p as usize] {
            SurfacePoint::Vertex(v) => positions[v.index()],
            SurfacePoint::Edge(e, t) => {
                let [a, b] = mesh.edge_vertices(e).map(|v| positions[v.index()]);
                a + (b - a) * t
            }
            SurfacePoint::Face(f, weights) => {
                let corners = mesh.face_vertices(f).map(|v| positions[v.index()].coords);
                Point3::from((0..3).map(|i| corners[i] * weights[i]).sum::<Vector3<f64>>())
            }
        };
        let points = opened.vertex_points.iter().map(place).collect();
        let geometry = Geometry::measure(&opened.mesh, points);
        Self { own_vertices: mesh.vertex_count(), opened, geometry }
    }

    /// Cut along the mesh edges between faces of different labels, and along further edges.
    fn along_edges(
        positions: &[Point3<f64>],
        triangles: &[[u32; 3]],
        label: impl Fn(Point3<f64>) -> u32,
        further: &[[u32; 2]],
    ) -> Self {
        let mesh = Mesh::new(positions.len(), triangles).unwrap();
        let labels: Vec<u32> = triangles
            .iter()
            .map(|t| {
                let sum: Vector3<f64> = t.iter().map(|&v| positions[v as usize].coords).sum();
                label(Point3::from(sum / 3.0))
            })
            .collect();
        let mut cut = CutMesh::uncut(&mesh);
        for e in mesh.edges() {
            let sides = [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h));
            if let [Some(f), Some(g)] = sides
                && labels[f.index()] != labels[g.index()]
            {
                cut.cut_edges.push(mesh.edge_vertices(e).map(|v| v.0));
            }
        }
        cut.cut_edges.extend(further);
        Self::new(&mesh, positions, &cut)
    }

    /// Cut along the zero set of a function, through faces.
    fn along_level(
        positions: &[Point3<f64>],
        triangles: &[[u32; 3]],
        level: impl Fn(Point3<f64>) -> f64,
    ) -> Self {
        let mesh = Mesh::new(positions.len(), triangles).unwrap();
        let values: Vec<f64> = positions.iter().map(|&p| level(p)).collect();
        Self::new(&mesh, positions, &level_cut(&mesh, positions, &values))
    }

    fn flatten(&self) -> Flattening {
        bff(&self.opened, &self.geometry).unwrap()
    }

    fn measures(&self) -> Measures {
        measure(&self.opened, &self.geometry, &self.flatten())
    }
}

/// Cuts crossed faces into a triangle and a quad, the quad by its Delaunay diagonal.
fn level_cut(mesh: &Mesh, positions: &[Point3<f64>], values: &[f64]) -> CutMesh {
    let mut cut = CutMesh::uncut(mesh);
    cut.triangles.clear();
    cut.triangle_faces.clear();
    let mut places = positions.to_vec();
    let mut crossing_points = HashMap::new();
    let mut crossing = |cut: &mut CutMesh, places: &mut Vec<Point3<f64>>, e: EdgeId| -> u32 {
        *crossing_points.entry(e).or_insert_with(|| {
            let [a, b] = mesh.edge_vertices(e).map(|v| v.index());
            let t = (values[a] / (values[a] - values[b])).clamp(1e-6, 1.0 - 1e-6);
            cut.points.push(SurfacePoint::Edge(e, t));
            places.push(positions[a] + (positions[b] - positions[a]) * t);
            cut.points.len() as u32 - 1
        })
    };
    for f in mesh.faces() {
        let corners = mesh.face_vertices(f);
        let inside = corners.map(|v| values[v.index()] > 0.0);
        let Some(lone) =
            (0..3).find(|&i| inside[i] != inside[(i + 1) % 3] && inside[i] != inside[(i + 2) % 3])
        else {
            cut.triangles.push(corners.map(|v| v.0));
            cut.triangle_faces.push(f);
            continue;
        };
        let [a, b, c] = [0, 1, 2].map(|i| corners[(lone + i) % 3].0);
        let sides = mesh.face_halfedges(f);
        let x = crossing(&mut cut, &mut places, sides[lone].edge());
        let y = crossing(&mut cut, &mut places, sides[(lone + 2) % 3].edge());
        let cot = |tip: u32, l: u32, r: u32| {
            let [tip, l, r] = [tip, l, r].map(|p| places[p as usize]);
            (l - tip).dot(&(r - tip)) / (l - tip).cross(&(r - tip)).norm()
        };
        cut.triangles.push([a, x, y]);
        if cot(b, x, c) + cot(y, x, c) > cot(x, b, y) + cot(c, b, y) {
            cut.triangles.extend([[x, b, c], [x, c, y]]);
        } else {
            cut.triangles.extend([[x, b, y], [b, c, y]]);
        }
        cut.triangle_faces.extend([f; 3]);
        cut.cut_edges.push([x, y]);
    }
    cut
}

type Soup = (Vec<Point3<f64>>, Vec<[u32; 3]>);

/// An n × m grid of squares, placed by a function of (i / n, j / m); columns may close.
fn grid(n: u32, m: u32, closed: bool, place: impl Fn(f64, f64) -> Point3<f64>) -> Soup {
    let columns = if closed { n } else { n + 1 };
    let mut positions = Vec::new();
    for j in 0..=m {
        for i in 0..columns {
            positions.push(place(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
        }
    }
    let at = |i: u32, j: u32| j * columns + i % columns;
    let mut triangles = Vec::new();
    for j in 0..m {
        for i in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    (positions, triangles)
}

/// A sphere of area 1 by subdivision of the icosahedron, turned so that it lies askew to the axes.
fn icosphere(levels: u32) -> Soup {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for s in [-1.0, 1.0] {
        for t in [-g, g] {
            positions.extend([[0.0, s, t], [s, t, 0.0], [t, 0.0, s]]);
        }
    }
    let mut positions: Vec<Vector3<f64>> =
        positions.into_iter().map(|p| Vector3::from(p).normalize()).collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let near = |a: usize, b: usize| (positions[a] - positions[b]).norm() < 1.1;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let out = positions[a].cross(&positions[b]).dot(&positions[c]) > 0.0;
                    let [a, b, c] = [a, b, c].map(|v| v as u32);
                    triangles.push(if out { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut finer = Vec::new();
        for t in &triangles {
            let m = [0, 1, 2].map(|i| {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    positions.len() as u32 - 1
                })
            });
            finer.extend([[t[0], m[0], m[2]], [t[1], m[1], m[0]], [t[2], m[2], m[1]], m]);
        }
        triangles = finer;
    }
    let askew = Rotation3::from_euler_angles(0.3, 1.1, -0.7);
    let radius = 1.0 / (4.0 * PI).sqrt();
    (positions.into_iter().map(|p| Point3::from(askew * p * radius)).collect(), triangles)
}

/// Largest deviation of a length in the charts from its length on the surface.
fn worst_length_error(case: &Case, flattening: &Flattening) -> f64 {
    let mesh = &case.opened.mesh;
    mesh.edges()
        .map(|e| {
            let [a, b] = mesh.edge_vertices(e).map(|v| flattening.uv[v.index()]);
            ((a - b).norm() - case.geometry.edge_length(e)).abs()
        })
        .fold(0.0, f64::max)
}

fn assert_partners_are_equal(case: &Case, flattening: &Flattening) -> usize {
    let mesh = &case.opened.mesh;
    let length = |h: cutflow::mesh::HalfedgeId| {
        (flattening.uv[mesh.tip(h).index()] - flattening.uv[mesh.tail(h).index()]).norm()
    };
    let mut pairs = 0;
    for h in flattening.charts.iter().flatten().flatten() {
        let Some(partner) = case.opened.partner(*h).filter(|&p| !length(p).is_nan()) else {
            continue;
        };
        // Closing holds one number for both; only adding up coordinates of size 1 separates them.
        assert!((length(*h) - length(partner)).abs() < 1e-14);
        pairs += 1;
    }
    pairs / 2
}

/// Developable surfaces and what they are cut along.
fn developables() -> Vec<(&'static str, Case)> {
    let tilt = Rotation3::from_euler_angles(0.4, -0.2, 1.0);
    let whole = |_| 0;
    let (p, t) = grid(13, 9, false, |s, r| {
        // Jittered: angles of all kinds, some weights negative.
        let jitter = |x: f64| 0.03 * (137.0 * x).sin();
        tilt * Point3::new(s + jitter(3.0 * s + 7.0 * r), 0.7 * r + jitter(5.0 * s - r), 0.0)
    });
    let plane = Case::along_edges(&p, &t, whole, &[]);
    let (p, t) = grid(24, 10, true, |s, r| {
        tilt * Point3::new(0.3 * (TAU * s).cos(), 0.3 * (TAU * s).sin(), r)
    });
    let down: Vec<[u32; 2]> = (0..10).map(|j| [24 * j + 5, 24 * (j + 1) + 5]).collect();
    let cylinder = Case::along_edges(&p, &t, whole, &down);
    let (p, t) = cone(15, 8);
    let to_apex: Vec<[u32; 2]> =
        (0..8).map(|j| [1 + 15 * j, if j == 0 { 0 } else { 1 + 15 * (j - 1) }]).collect();
    let cone = Case::along_edges(&p, &t, whole, &to_apex);
    vec![("plane", plane), ("cylinder", cylinder), ("cone", cone)]
}

/// A cone of n flat sectors with its apex as vertex 0.
fn cone(n: u32, rings: u32) -> Soup {
    let mut positions = vec![Point3::new(0.0, 0.0, 0.8)];
    for j in 1..=rings {
        for i in 0..n {
            let (r, t) = (f64::from(j) / f64::from(rings), TAU * f64::from(i) / f64::from(n));
            positions.push(Point3::new(0.6 * r * t.cos(), 0.6 * r * t.sin(), 0.8 * (1.0 - r)));
        }
    }
    let at = |i: u32, j: u32| 1 + (j - 1) * n + i % n;
    let mut triangles = Vec::new();
    for i in 0..n {
        triangles.push([0, at(i, 1), at(i + 1, 1)]);
        for j in 1..rings {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    (positions, triangles)
}

#[test]
fn developable_surfaces_become_isometric_charts() {
    for (name, case) in developables() {
        let flattening = case.flatten();
        assert!(flattening.seams_equal && flattening.charts[0].is_ok(), "{name}");
        // Rounding of coordinates of size 1, magnified by the condition of the systems (about 1e3).
        let error = worst_length_error(&case, &flattening);
        assert!(error < 1e-11, "{name}: {error:e}");
        assert!(flattening.u.iter().all(|u| u.abs() < 1e-11), "{name}");
        let measures = case.measures();
        let chart = measures.charts[0].as_ref().unwrap();
        assert_eq!(
            (chart.flipped, chart.overlaps, chart.faces),
            (0, 0, case.opened.mesh.face_count())
        );
        assert!((chart.angle_distortion_max - 1.0).abs() < 1e-9, "{name}");
        assert!((chart.l2_stretch - 1.0).abs() < 1e-9 && chart.area_change_abs < 1e-9, "{name}");
        assert!(chart.area_distortion < 1e-9 && chart.hencky < 1e-9, "{name}");
        assert_eq!(*chart, measures.totals);
    }
}

#[test]
fn both_sides_of_a_slit_stay_equally_long() {
    let cases = developables();
    assert_eq!(assert_partners_are_equal(&cases[1].1, &cases[1].1.flatten()), 10);
    assert_eq!(assert_partners_are_equal(&cases[2].1, &cases[2].1.flatten()), 8);
}

#[test]
fn a_triangle_and_a_strip_are_their_own_charts() {
    let triangle = [[0.0, 0.0, 0.0], [3.0, 0.0, 1.0], [0.0, 4.0, 2.0]].map(Point3::from);
    let (strip, strip_triangles) =
        grid(9, 1, false, |s, r| Point3::new((4.0 * s).cos(), r, (4.0 * s).sin()));
    for case in [
        Case::along_edges(&triangle, &[[0, 1, 2]], |_| 0, &[]),
        Case::along_edges(&strip, &strip_triangles, |_| 0, &[]),
    ] {
        let flattening = case.flatten();
        assert!(worst_length_error(&case, &flattening) < 1e-14);
        assert_eq!(case.measures().totals.flipped, 0, "counter-clockwise");
    }
}

#[test]
fn the_hemispheres_converge_to_the_exact_map_with_the_square_of_the_edge_length() {
    let axis = Vector3::new(0.2, -0.5, 1.0).normalize();
    let radius = 1.0 / (4.0 * PI).sqrt();
    // e^u = 1 / (1 + cos t): disks of half the hemispheres' areas, Σ ∫u² = ∫₁² ln²s ds.
    let hencky = 2.0 * (2f64.ln() - 1.0).powi(2);
    let mut errors = Vec::new();
    for level in [3, 4, 5] {
        let (p, t) = icosphere(level);
        let case = Case::along_level(&p, &t, |p| p.coords.dot(&axis));
        let flattening = case.flatten();
        assert!(flattening.seams_equal && flattening.charts.iter().all(Result::is_ok));
        assert!(assert_partners_are_equal(&case, &flattening) > 30);
        let u_error = (0..case.own_vertices)
            .map(|v| {
                let cos = (case.geometry.positions[v].coords.dot(&axis) / radius).abs();
                (flattening.u[v] + (1.0 + cos).ln()).abs()
            })
            .fold(0.0, f64::max);
        let totals = case.measures().totals;
        assert_eq!((totals.flipped, totals.overlaps), (0, 0), "level {level}");
        errors.push([
            u_error,
            totals.angle_distortion - 1.0,
            (totals.area_change + 0.5).abs(),
            (totals.hencky - hencky).abs(),
        ]);
    }
    eprintln!("u, angle distortion, area change, Hencky: {errors:?}");
    for pair in errors.windows(2) {
        // Areas and energies converge with h² (ratio 4), the angle distortion of a face with h.
        assert!(pair[0][0] > 3.0 * pair[1][0], "u: {errors:?}");
        assert!(pair[0][1] > 1.6 * pair[1][1], "angles: {errors:?}");
        assert!(pair[0][3] > 3.0 * pair[1][3], "Hencky: {errors:?}");
    }
    let last = errors[2];
    assert!(last[0] < 2e-3 && last[1] < 0.02 && last[2] < 2e-3 && last[3] < 5e-4, "{last:?}");
}

#[test]
fn angles_of_the_charts_add_up() {
    let (p, t) = icosphere(3);
    let case = Case::along_edges(&p, &t, octant, &[]);
    let flattening = case.flatten();
    assert_eq!(flattening.charts.len(), 8);
    assert!(flattening.seams_equal);
    assert_eq!(
        assert_partners_are_equal(&case, &flattening),
        case.opened.mesh.edges().filter(|&e| case.opened.mesh.is_boundary_edge(e)).count() / 2
    );
    // The charts are flat surfaces: measured as such, they have no curvature inside and 2π at each rim.
    let flat = flattening.uv.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
    let flat = Geometry::measure(&case.opened.mesh, flat);
    let defects = angle_defects(&case.opened.mesh, &flat);
    let mut turning = [0.0; 8];
    for (v, &patch) in case.opened.mesh.vertices().zip(case.opened.vertex_patches()) {
        if case.opened.mesh.is_boundary_vertex(v) {
            turning[patch as usize] += defects[v.index()];
        } else {
            assert!(defects[v.index()].abs() < 1e-10);
        }
    }
    assert!(turning.iter().all(|t| (t - TAU).abs() < 1e-10), "{turning:?}");
}

fn octant(p: Point3<f64>) -> u32 {
    u32::from(p.x > 0.0) + 2 * u32::from(p.y > 0.0) + 4 * u32::from(p.z > 0.0)
}

#[test]
fn a_factor_on_the_uncut_mesh_gives_the_same_charts() {
    let (p, t) = icosphere(3);
    let case = Case::along_level(&p, &t, |p| 0.1 * (20.0 * p.x).sin() + p.z);
    // What a cut flow factors: the mesh's own vertices, all of them inside some patch.
    let mesh = &case.opened.mesh;
    let inside = |v: VertexId| v.index() < case.own_vertices;
    let edges: Vec<EdgeId> =
        mesh.edges().filter(|&e| mesh.edge_vertices(e).iter().any(|&v| inside(v))).collect();
    let pairs: Vec<[u32; 2]> = edges
        .iter()
        .map(|&e| mesh.edge_vertices(e).map(|v| v.0))
        .filter(|ends| ends.iter().all(|&v| inside(VertexId(v))))
        .collect();
    let (pattern, slots) = Pattern::new(case.own_vertices, &pairs);
    let mut values = vec![0.0; pattern.entry_count()];
    let mut slots = slots.iter();
    for &e in &edges {
        let ends = mesh.edge_vertices(e);
        let weight: f64 = [e.halfedge(), e.halfedge().twin()]
            .into_iter()
            .filter_map(|h| Some((mesh.face(h)?, h)))
            .map(|(f, h)| {
                let i = mesh.face_halfedges(f).iter().position(|&g| g == h).unwrap();
                0.5 * case.geometry.corner_cotangents[f.index()][(i + 2) % 3]
            })
            .sum();
        for v in ends.into_iter().filter(|&v| inside(v)) {
            values[pattern.diagonal(v.index())] += weight;
        }
        if ends.iter().all(|&v| inside(v)) {
            values[*slots.next().unwrap() as usize] -= weight;
        }
    }
    let mut factor = Factor::new(Arc::new(Analysis::new(pattern).unwrap()), &values).unwrap();
    let preview = bff_with(&case.opened, &case.geometry, &mut factor).unwrap();
    let full = case.flatten();
    for (a, b) in preview.uv.iter().zip(&full.uv) {
        assert!((a - b).norm() < 1e-10, "{a} {b}");
    }
}

#[test]
fn patches_that_are_no_disks_or_defective_leave_the_others_alone() {
    // A cylinder cut across: the lower part stays an annulus, the upper one is slit.
    let (mut p, t) =
        grid(24, 10, true, |s, r| Point3::new((TAU * s).cos(), (TAU * s).sin(), 6.0 * r));
    let slit: Vec<[u32; 2]> = (5..10).map(|j| [24 * j, 24 * (j + 1)]).collect();
    let case = Case::along_edges(&p, &t, |p| u32::from(p.z > 3.0), &slit);
    let flattening = case.flatten();
    assert_eq!(flattening.charts[0], Err(NoChart::NotADisk { euler: 0, boundary_loops: 2 }));
    assert!(flattening.charts[1].is_ok());
    let patches = case.opened.vertex_patches();
    for (v, uv) in flattening.uv.iter().enumerate() {
        assert_eq!(uv.x.is_nan(), patches[v] == 0);
        assert_eq!(flattening.u[v].is_nan(), patches[v] == 0);
    }
    let measures = measure(&case.opened, &case.geometry, &flattening);
    assert!(measures.charts[0].is_none() && (measures.totals.angle_distortion - 1.0).abs() < 1e-9);

    // A vertex pulled onto its neighbour, in one of two disks.
    let both: Vec<[u32; 2]> = (0..10).map(|j| [24 * j, 24 * (j + 1)]).collect();
    p[24 * 2 + 7] = p[24 * 2 + 8];
    let case = Case::along_edges(&p, &t, |p| u32::from(p.z > 3.0), &both);
    let flattening = case.flatten();
    assert!(matches!(flattening.charts[0], Err(NoChart::Degenerate { .. })));
    assert!(flattening.charts[1].is_ok());
    p[24 * 2 + 7].x = f64::NAN;
    let case = Case::along_edges(&p, &t, |p| u32::from(p.z > 3.0), &both);
    let flattening = case.flatten();
    assert!(matches!(flattening.charts[0], Err(NoChart::Degenerate { .. })));
    assert!(flattening.charts[1].is_ok());
}

#[test]
fn slivers_along_a_cut_do_no_harm() {
    // The plane runs through vertices and a hair beside them: crossings at 1e-6 of an edge on many edges.
    for shift in [0.0, 1e-9, 1e-7, 1e-4] {
        let (p, t) = grid(20, 20, false, |s, r| Point3::new(s, r, 0.0));
        let case = Case::along_level(&p, &t, |p| p.x + 0.5 * p.y - 0.75 - shift);
        let flattening = case.flatten();
        assert_eq!(flattening.charts.len(), 2);
        assert!(worst_length_error(&case, &flattening) < 1e-10, "shift {shift}");
        assert_eq!(case.measures().totals.flipped, 0, "shift {shift}");
    }
}

#[test]
fn rigid_motion_and_scale_change_nothing_but_the_unit() {
    let (p, t) = icosphere(2);
    let reference = Case::along_edges(&p, &t, octant, &[]).measures().totals;
    for scale in [1e-6, 1e6] {
        let turn = Rotation3::from_euler_angles(1.0, 2.0, 3.0);
        let case = Case::along_edges(&p, &t, octant, &[]);
        let moved = case
            .geometry
            .positions
            .iter()
            .map(|q| turn * q * scale + Vector3::new(scale, 0.0, 0.0));
        let geometry = Geometry::measure(&case.opened.mesh, moved.collect());
        let flattening = bff(&case.opened, &geometry).unwrap();
        let totals = measure(&case.opened, &geometry, &flattening).totals;
        for (a, b) in [
            (totals.angle_distortion, reference.angle_distortion),
            (totals.area_distortion, reference.area_distortion),
            (totals.area_change, reference.area_change),
            (totals.l2_stretch, reference.l2_stretch),
            (totals.hencky / (scale * scale), reference.hencky),
        ] {
            assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{a} {b}");
        }
    }
}

#[test]
fn measures_of_known_linear_maps_are_exact() {
    // Two faces, stretched by 2 along x and by 3 along y; then the second one is turned over.
    let square =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
    let case = Case::along_edges(&square, &[[0, 1, 2], [0, 2, 3]], |_| 0, &[]);
    let mut flattening = case.flatten();
    flattening.uv = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]].map(Point2::from).to_vec();
    let all = measure(&case.opened, &case.geometry, &flattening);
    let chart = all.charts[0].as_ref().unwrap();
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-14 * b.abs().max(1.0), "{a} {b}");
    close(chart.angle_distortion, 1.5);
    close(chart.angle_distortion_max, 1.5);
    close(chart.area_change, 5.0);
    close(chart.area_change_abs, 5.0);
    close(chart.l2_stretch, ((0.25 + 1.0 / 9.0) / 2.0f64).sqrt());
    close(chart.hencky, (0.5 * 6f64.ln()).powi(2));
    assert!(chart.area_distortion < 1e-7, "one scale everywhere");
    close(all.face_log_scales[1], 0.5 * 6f64.ln());
    assert_eq!(chart.flipped, 0);

    // Corner 3 reflected in the diagonal: face 1 is turned over.
    flattening.uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.9, 0.1]].map(Point2::from).to_vec();
    let chart = measure(&case.opened, &case.geometry, &flattening).charts[0].clone().unwrap();
    assert_eq!(chart.flipped, 1);
    close(chart.angle_distortion, 1.0);
    // Collapsed onto the diagonal: no area is a flip too, by exact predicates.
    flattening.uv[3] = Point2::new(0.5, 0.5);
    let chart = measure(&case.opened, &case.geometry, &flattening).charts[0].clone().unwrap();
    assert_eq!(chart.flipped, 1);
}

#[test]
fn crossings_of_outlines_are_counted_exactly() {
    // A band along a spiral is simple while its turns keep apart; a band along a ring run through twice crosses itself.
    let band = |turns: f64, pitch: f64| -> Vec<Point2<f64>> {
        let at = |s: f64, side: f64| {
            let r = 1.0 + pitch * s * turns + side;
            Point2::new(r * (TAU * turns * s).cos(), r * (TAU * turns * s).sin())
        };
        let out = (0..=400).map(|i| at(f64::from(i) / 400.0, -0.1));
        out.chain((0..=400).rev().map(|i| at(f64::from(i) / 400.0, 0.1))).collect()
    };
    assert!(crossings(&[&band(3.0, 0.3)]).is_empty());
    let crossed = crossings(&[&band(1.2, -0.15)]);
    // The end of the band enters over one border of its beginning.
    assert!(!crossed.is_empty() && crossed.len().is_multiple_of(2), "{}", crossed.len());
    for [s, t] in &crossed {
        assert!(s < t && (t.side - s.side) > 1);
    }
    // The grid finds what all pairs find.
    let mut scribble = Vec::new();
    let mut state = 1u64;
    for _ in 0..300 {
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f64 / 16777216.0
        };
        scribble.push(Point2::new(random(), 0.2 * random()));
    }
    let side = |i: usize| [scribble[i], scribble[(i + 1) % 300]];
    let mut count = 0;
    for i in 0..300 {
        for j in i + 1..300 {
            count += usize::from(cutflow::flatten::overlap::cross(side(i), side(j)));
        }
    }
    assert_eq!(crossings(&[&scribble]).len(), count);
    // Touching is no crossing; crossing another outline is.
    let square = |x: f64| {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[a, b]| Point2::new(a + x, b))
    };
    assert!(crossings(&[&square(0.0), &square(1.0)]).is_empty());
    let shifted = square(0.5).map(|p| p + Vector2::new(0.0, 0.5));
    let found = crossings(&[&square(0.0), &shifted]);
    assert_eq!(found.len(), 2);
    assert!(found.iter().all(|[s, t]| (s.outline, t.outline) == (0, 1)));
}

#[test]
fn charts_of_a_surface_lie_apart_on_the_sheet() {
    let (p, t) = icosphere(3);
    let case = Case::along_edges(&p, &t, octant, &[]);
    let flattening = case.flatten();
    let packing = flattening.pack(&case.opened, case.own_vertices, 0.02, None);
    assert_eq!(measures::overlaps_across(&case.opened, &flattening, &packing), 0);
    let placed = flattening.place(&case.opened, &packing);
    assert!(placed.iter().all(|p| p.x > -1e-12 && p.y > -1e-12));
    assert!(placed.iter().all(|p| p.x < packing.sheet.x + 1e-12 && p.y < packing.sheet.y + 1e-12));
    // Every face lies where its own chart does, counter-clockwise.
    for f in (0..case.opened.mesh.face_count()).map(FaceId::from) {
        let [a, b, c] = case.opened.mesh.face_vertices(f).map(|v| placed[v.index()]);
        assert!((b - a).perp(&(c - a)) > 0.0);
    }
}

/// A mesh of the shared collection, scaled to area 1; none where it is absent.
fn shared_mesh(name: &str) -> Option<Soup> {
    let path = format!("{}/../shared/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    #[expect(clippy::disallowed_methods, reason = "tests open files")]
    let bytes = std::fs::read(&path);
    let Ok(bytes) = bytes else {
        eprintln!("skipped: {path} is absent");
        return None;
    };
    let soup = cutflow::mesh::read::obj::read(&bytes).unwrap().soup;
    let mut triangles = Vec::new();
    for i in 0..soup.polygon_count() {
        let polygon = soup.polygon(i);
        triangles.extend((2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]));
    }
    let mesh = Mesh::new(soup.positions.len(), &triangles).unwrap();
    let (geometry, _) = Geometry::unit_area(&mesh, &soup.positions).unwrap();
    Some((geometry.positions, triangles))
}

#[test]
fn a_cow_cut_along_its_plane_of_symmetry_keeps_its_seams_equal() {
    let Some((p, t)) = shared_mesh("spot.obj") else { return };
    // Both halves have the same rim: the case that closing with lengths alone cannot do.
    let case = Case::along_level(&p, &t, |p| p.x);
    let flattening = case.flatten();
    assert!(flattening.seams_equal);
    assert!(assert_partners_are_equal(&case, &flattening) > 100);
    let mesh = &case.opened.mesh;
    for h in flattening.charts.iter().flatten().flatten() {
        let [a, b] = [mesh.tail(*h), mesh.tip(*h)].map(|v| flattening.uv[v.index()]);
        let ratio = (a - b).norm() / case.geometry.edge_length(h.edge());
        assert!(ratio.ln().abs() < 0.005, "rims keep their lengths: {ratio}");
    }
    let totals = measure(&case.opened, &case.geometry, &flattening).totals;
    assert_eq!((totals.flipped, totals.overlaps), (0, 0));
    assert!(totals.angle_distortion < 1.12, "{}", totals.angle_distortion);
}

#[test]
fn real_surfaces_in_many_pieces_flatten_without_flips() {
    for name in ["spot.obj", "bunny-closed.obj", "rocker-arm.obj"] {
        let Some((p, t)) = shared_mesh(name) else { continue };
        for size in [0.1, 0.25] {
            // Cubes of space: many pieces with ragged rims, a few of them no disks.
            let cube = |x: f64| (x / size + 50.37).floor() as u32;
            let label = |q: Point3<f64>| cube(q.x) + 1000 * cube(q.y) + 1_000_000 * cube(q.z);
            let case = Case::along_edges(&p, &t, label, &[]);
            let flattening = case.flatten();
            assert!(flattening.seams_equal, "{name} {size}");
            let charts = flattening.charts.iter().filter(|c| c.is_ok()).count();
            assert!(charts * 10 > flattening.charts.len() * 7, "{name} {size}: {charts}");
            assert!(assert_partners_are_equal(&case, &flattening) > 0);
            let totals = measure(&case.opened, &case.geometry, &flattening).totals;
            assert_eq!(totals.flipped, 0, "{name} {size}");
            assert!(totals.angle_distortion < 1.2, "{name} {size}: {}", totals.angle_distortion);
        }
    }
}

#[test]
fn the_preview_of_a_running_flow_is_the_full_flattening_and_moves_gently() {
    let Some((p, t)) = shared_mesh("spot.obj") else { return };
    let mesh = Mesh::new(p.len(), &t).unwrap();
    let geometry = Geometry::new(&mesh, p).unwrap();
    let start = Initial::NormalClusters { angle: PI / 3.0, regions: 10 };
    let params = CutFlowParams {
        weights: Weights { hencky: 3000.0, length: 2.0, ..Weights::default() },
        ..CutFlowParams::default()
    };
    let mut flow = CutFlow::new(mesh.clone(), geometry.clone(), &start, params).unwrap();
    let mut last: Option<(Packing, Vec<Point2<f64>>)> = None;
    let mut jumps = 0;
    let mut flips = Vec::new();
    for step in 0..40 {
        let cut = flow.cut_mesh();
        let case = Case::new(&mesh, &geometry.positions, &cut);
        let places = case.geometry.positions.clone();
        let refined = Geometry::measure_refined(&case.opened.mesh, places, &geometry, |f| {
            cut.undivided(&mesh, f)
        });
        assert_eq!(refined.corner_angles, case.geometry.corner_angles);
        assert_eq!(refined.corner_cotangents, case.geometry.corner_cotangents);
        assert_eq!(refined.face_areas, case.geometry.face_areas);
        let preview = bff_with(&case.opened, &case.geometry, flow.factor().unwrap()).unwrap();
        let full = case.flatten();
        assert_eq!(preview.charts, full.charts);
        for (a, b) in preview.uv.iter().zip(&full.uv).filter(|(a, _)| !a.x.is_nan()) {
            // Two factorisations of the same numbers in two orders.
            assert!((a - b).norm() < 1e-7, "step {step}: {a} {b}");
        }
        let totals = measure(&case.opened, &case.geometry, &preview).totals;
        // Rounding decides which way a flow goes, and now and then a triangle turns over on it, which BFF does not rule out.
        flips.push(totals.flipped);
        let previous = last.as_ref().map(|(packing, _)| packing);
        let packing = preview.pack(&case.opened, case.own_vertices, 0.02, previous);
        assert_eq!(measures::overlaps_across(&case.opened, &preview, &packing), 0);
        let mut placed = preview.place(&case.opened, &packing);
        placed.truncate(case.own_vertices);
        if let Some((_, before)) = &last {
            let mut moves: Vec<f64> = placed
                .iter()
                .zip(before)
                .map(|(a, b)| (a - b).norm())
                .filter(|d| d.is_finite())
                .collect();
            moves.sort_unstable_by(f64::total_cmp);
            let median = moves[moves.len() / 2];
            jumps += usize::from(median > 0.1);
        }
        last = Some((packing, placed));
        flow.step().unwrap();
    }
    let turned = flips.iter().filter(|&&count| count > 0).count();
    assert!(turned <= 6 && flips.iter().all(|&count| count <= 2), "{flips:?}");
    // About 0.005 a step; a layout made anew moves half of all points by 0.3 and more.
    assert!(jumps <= 1, "the layout was made anew {jumps} times in 40 steps");
}
