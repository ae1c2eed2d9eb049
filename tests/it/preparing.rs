//! Subdivision, remeshing, decimation: what stays, what gets better, and the contract of flows.

use std::f64::consts::TAU;

use cutflow::geometry::{Geometry, angle_defects, polygon};
use cutflow::mesh::read::obj;
use cutflow::mesh::{FaceId, Mesh, Soup, Topology};
use cutflow::methods::flow::{Flow, SolveError, Status};
use cutflow::methods::prepare::{
    DecimateFlow, DecimateParams, EdgeTarget, Prepared, RemeshFlow, RemeshParams, SubdivideFlow,
    SubdivideParams, SubdivideRule, Surface, TOO_COARSE, coarseness,
};
use nalgebra::Point3;

use crate::surfaces::{cube, cylinder, tetrahedron};

fn surface(soup: &Soup) -> Surface {
    let (mut triangles, mut polygons) = (Vec::new(), Vec::new());
    for i in 0..soup.polygon_count() {
        polygon::triangulate(&soup.positions, soup.polygon(i), &mut triangles);
        polygons.resize(triangles.len(), i as u32);
    }
    Surface::new(soup, &triangles, &polygons).unwrap()
}

fn shared(name: &str) -> Option<Surface> {
    let path = format!("{}/../shared/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    let Ok(bytes) = std::fs::read(path) else {
        let text = format!("SKIPPED: {name} needs ../shared/meshes, which is not there\n");
        std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes()).unwrap();
        return None;
    };
    Some(surface(&obj::read(&bytes).unwrap().soup))
}

/// A flat square of n × n quads bent up into a wave, with the identity for a texture cut along the middle column, and a
/// material for each quadrant.
fn wave(n: u32) -> Surface {
    let mut soup = Soup { starts: vec![0], ..Soup::default() };
    let at = |k: u32| f64::from(k) / f64::from(n);
    for j in 0..=n {
        for i in 0..=n {
            soup.positions.push([at(i), at(j), 0.1 * (TAU * at(i)).sin() * (3.0 * at(j)).cos()]);
        }
    }
    // The right half lies elsewhere in the texture.
    for shift in [0.0, 3.0] {
        for j in 0..=n {
            for i in 0..=n {
                soup.texture_coordinates.push([at(i) + shift, at(j)]);
            }
        }
    }
    for j in 0..n {
        for i in 0..n {
            let quad =
                [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| i + (n + 1) * j);
            let half = u32::from(2 * i >= n);
            soup.corners.extend(quad);
            soup.texture_corners.extend(quad.map(|v| v + half * (n + 1) * (n + 1)));
            soup.starts.push(soup.corners.len() as u32);
            soup.polygon_materials.push(half + 2 * u32::from(2 * j >= n));
            soup.polygon_groups.push(0);
        }
    }
    soup.materials = ["a", "b", "c", "d"].map(str::to_owned).to_vec();
    soup.groups = vec!["sheet".to_owned()];
    surface(&soup)
}

fn sphere(n: u32) -> Surface {
    surface(&cutflow::session::samples::icosphere(n))
}

/// Two spheres, far apart.
fn two_spheres() -> Surface {
    let ball = cutflow::session::samples::icosphere(4);
    let mut triangles: Vec<[u32; 3]> = ball.corners.chunks(3).map(|t| [t[0], t[1], t[2]]).collect();
    let count = ball.positions.len() as u32;
    triangles.extend(triangles.clone().iter().map(|t| t.map(|v| v + count)));
    let mut positions = ball.positions.clone();
    positions.extend(ball.positions.iter().map(|p| [p[0] + 5.0, p[1], p[2]]));
    surface(&Soup::from_triangles(positions, &triangles))
}

fn strip() -> Surface {
    let positions = (0..14).map(|i| [f64::from(i / 2), f64::from(i % 2), 0.0]).collect();
    let triangles: Vec<[u32; 3]> = (0..6)
        .flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]])
        .collect();
    surface(&Soup::from_triangles(positions, &triangles))
}

fn triangle() -> Surface {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    surface(&Soup::from_triangles(positions, &[[0, 1, 2]]))
}

fn zoo() -> Vec<(&'static str, Surface)> {
    vec![
        ("triangle", triangle()),
        ("tetrahedron", surface(&tetrahedron())),
        ("cube", surface(&cube())),
        ("strip", strip()),
        ("cylinder", surface(&cylinder(24, 9))),
        ("two spheres", two_spheres()),
        ("wave", wave(16)),
    ]
}

fn run<F: Flow>(mut flow: F) -> (F, Status) {
    for _ in 0..2000 {
        let report = flow.step().unwrap();
        assert!(report.progress.is_none_or(|p| (0.0..=1.0).contains(&p)));
        if report.status != Status::Running {
            return (flow, report.status);
        }
    }
    panic!("no end");
}

fn subdivide(surface: &Surface, rule: SubdivideRule) -> Prepared {
    let params = SubdivideParams { rule, max_faces: 100_000 };
    let (flow, status) = run(SubdivideFlow::new(surface.clone(), &params).unwrap());
    assert_eq!(status, Status::Converged);
    flow.state().clone()
}

fn remesh(surface: &Surface, multiple: f64) -> Prepared {
    let params =
        RemeshParams { target: EdgeTarget::MeanEdges(multiple), ..RemeshParams::default() };
    run(RemeshFlow::new(surface.clone(), &params).unwrap()).0.state().clone()
}

fn decimate(surface: &Surface, target_faces: usize) -> (Prepared, Status) {
    let params = DecimateParams { target_faces, ..DecimateParams::default() };
    let (flow, status) = run(DecimateFlow::new(surface.clone(), &params).unwrap());
    (flow.state().clone(), status)
}

fn all_tools(surface: &Surface) -> Vec<(&'static str, Prepared)> {
    vec![
        ("midpoint", subdivide(surface, SubdivideRule::Midpoint { rounds: 2 })),
        ("curvature", subdivide(surface, SubdivideRule::Curvature { tolerance: 0.4 })),
        ("remesh", remesh(surface, 1.0)),
        ("remesh finer", remesh(surface, 0.5)),
        ("remesh coarser", remesh(surface, 2.0)),
        ("decimate", decimate(surface, surface.mesh.face_count().div_ceil(4)).0),
    ]
}

fn geometry(surface: &Surface) -> Geometry {
    Geometry::measure(&surface.mesh, surface.positions.clone())
}

fn smallest_angle(surface: &Surface) -> f64 {
    geometry(surface).corner_angles.iter().flatten().copied().fold(f64::INFINITY, f64::min)
}

fn shape(mesh: &Mesh) -> (usize, usize, i64, usize) {
    let Topology { components, boundary_loops, euler, genus, .. } = mesh.topology();
    (components, boundary_loops, euler, genus)
}

fn all_finite(surface: &Surface) -> bool {
    surface.positions.iter().all(|p| p.iter().all(|x| x.is_finite()))
}

/// Signed area in the texture of the faces of each material.
fn texture_areas(surface: &Surface) -> Vec<f64> {
    let attributes = &surface.attributes;
    let mut areas = vec![0.0; attributes.materials.len().max(1)];
    for (f, uvs) in attributes.corner_uvs.iter().enumerate() {
        let [a, b, c] = uvs.map(|uv| uv.unwrap());
        let material = attributes.face_materials.get(f).map_or(0, |&m| m as usize);
        areas[material] += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    }
    areas
}

/// Distance of a point from the nearest of many segments.
fn distance_to_lines(p: Point3<f64>, lines: &[[Point3<f64>; 2]]) -> f64 {
    let distance = |&[a, b]: &[Point3<f64>; 2]| {
        let t = ((p - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
        (a + (b - a) * t - p).norm()
    };
    lines.iter().map(distance).fold(f64::INFINITY, f64::min)
}

/// Edges whose faces turn by more than an angle, and the boundary.
fn sharp_lines(surface: &Surface, angle: f64) -> Vec<[Point3<f64>; 2]> {
    let mesh = &surface.mesh;
    let normals = geometry(surface).face_normals(mesh);
    mesh.edges()
        .filter(|e| match [e.halfedge(), e.halfedge().twin()].map(|h| mesh.face(h)) {
            [Some(f), Some(g)] => normals[f.index()].angle(&normals[g.index()]) > angle,
            _ => true,
        })
        .map(|e| mesh.edge_vertices(e).map(|v| surface.positions[v.index()]))
        .collect()
}

#[test]
fn no_tool_changes_the_topology_and_old_vertices_stay_bit_for_bit_and_come_first() {
    for (name, given) in zoo() {
        for (tool, made) in all_tools(&given) {
            let what = format!("{name}, {tool}");
            assert_eq!(shape(&made.surface.mesh), shape(&given.mesh), "{what}");
            assert_eq!(made.ancestors.len(), made.surface.mesh.vertex_count(), "{what}");
            let old: Vec<_> = made.ancestors.iter().map_while(|a| *a).collect();
            assert!(old.is_sorted_by(|a, b| a < b), "{what}");
            assert!(made.ancestors[old.len()..].iter().all(Option::is_none), "{what}");
            for (v, a) in old.iter().enumerate() {
                let (new, old) = (made.surface.positions[v], given.positions[a.index()]);
                assert!([0, 1, 2].iter().all(|&i| new[i].to_bits() == old[i].to_bits()), "{what}");
            }
            assert!(all_finite(&made.surface), "{what}");
            let faces = made.surface.mesh.face_count();
            let attributes = &made.surface.attributes;
            for length in [
                attributes.corner_uvs.len(),
                attributes.face_groups.len(),
                attributes.face_materials.len(),
            ] {
                assert!(length == 0 || length == faces, "{what}");
            }
        }
    }
}

#[test]
fn subdivision_leaves_area_defects_and_texture_as_they_are() {
    for (name, given) in zoo() {
        let rules = [
            SubdivideRule::Midpoint { rounds: 1 },
            SubdivideRule::Midpoint { rounds: 3 },
            SubdivideRule::Curvature { tolerance: 0.3 },
        ];
        for rule in rules {
            let made = subdivide(&given, rule).surface;
            let (before, after) = (geometry(&given), geometry(&made));
            // Rounding of sums of thousands of areas.
            assert!((after.total_area() / before.total_area() - 1.0).abs() < 1e-12, "{name}");
            let defects = angle_defects(&given.mesh, &before);
            for (v, defect) in angle_defects(&made.mesh, &after).into_iter().enumerate() {
                let old = defects.get(v).copied().unwrap_or(0.0);
                assert!((defect - old).abs() < 1e-11, "{name}: {defect} instead of {old}");
            }
            for (a, b) in texture_areas(&given).into_iter().zip(texture_areas(&made)) {
                assert!((a - b).abs() < 1e-12, "{name}: {b} instead of {a}");
            }
        }
    }
}

#[test]
fn curvature_is_met_everywhere_and_no_angle_falls_below_half_the_smallest() {
    for (name, given, tolerance) in [
        ("sphere", sphere(2), 0.2),
        ("tetrahedron", surface(&tetrahedron()), 0.2),
        ("wave", wave(16), 0.03),
    ] {
        let made = subdivide(&given, SubdivideRule::Curvature { tolerance }).surface;
        assert!(made.mesh.face_count() > given.mesh.face_count(), "{name}");
        // Rivara's bound; a part in a million for rounding.
        assert!(smallest_angle(&made) > 0.499_999 * smallest_angle(&given), "{name}");
    }
    let fine = subdivide(&sphere(2), SubdivideRule::Curvature { tolerance: 0.2 }).surface;
    // Radius 1: no edge may span more than the tolerance. The polyhedron's curvature is off by a few percent.
    let longest = geometry(&fine).edge_lengths.iter().copied().fold(0.0, f64::max);
    assert!(longest < 0.21, "{longest}");
}

#[test]
fn subdivision_stops_at_the_largest_number_of_faces() {
    for rule in
        [SubdivideRule::Midpoint { rounds: 9 }, SubdivideRule::Curvature { tolerance: 0.01 }]
    {
        let params = SubdivideParams { rule, max_faces: 5000 };
        let (flow, status) = run(SubdivideFlow::new(sphere(3), &params).unwrap());
        let faces = flow.state().surface.mesh.face_count();
        assert!(status == Status::StepLimit && faces > 1250 && faces <= 5000, "{status:?} {faces}");
    }
}

#[test]
fn remeshing_keeps_texture_materials_and_outline() {
    let given = wave(24);
    for multiple in [0.6, 1.0, 1.7] {
        let made = remesh(&given, multiple).surface;
        assert_eq!(made.attributes.materials, given.attributes.materials);
        assert!(made.attributes.face_groups.iter().all(|&g| g == 0));
        for (a, b) in texture_areas(&given).into_iter().zip(texture_areas(&made)) {
            // Outline and seams are straight in the texture and points on them exact.
            assert!((a - b).abs() < 1e-9, "{multiple}: {b} instead of {a}");
        }
        for (f, uvs) in made.attributes.corner_uvs.iter().enumerate() {
            let right = made.attributes.face_materials[f] % 2 == 1;
            let vertices = made.mesh.face_vertices(FaceId::from(f));
            for (uv, v) in uvs.iter().zip(vertices) {
                let p = made.positions[v.index()];
                let [x, y] = uv.unwrap();
                let shift = if right { 3.0 } else { 0.0 };
                // The texture is the place seen from above; vertices lie on the given surface.
                assert!((x - shift - p.x).abs() + (y - p.y).abs() < 1e-9, "{x} {y} {p}");
            }
        }
    }
}

#[test]
fn remeshing_keeps_every_edge_of_a_cube() {
    let given = subdivide(&surface(&cube()), SubdivideRule::Midpoint { rounds: 3 }).surface;
    let made = remesh(&given, 0.8).surface;
    let area = geometry(&made).total_area();
    // Faces stay flat and edges straight, so that nothing is lost.
    assert!((area / 24.0 - 1.0).abs() < 1e-12, "{area}");
    let lines = sharp_lines(&made, 1.0);
    let length: f64 = lines.iter().map(|[a, b]| (b - a).norm()).sum();
    assert!((length / 24.0 - 1.0).abs() < 1e-12, "{length}");
}

#[test]
fn remeshed_triangles_are_even() {
    let mut surfaces = vec![("sphere", sphere(12)), ("cylinder", surface(&cylinder(48, 20)))];
    surfaces.extend(shared("torus.obj").map(|s| ("torus", s)));
    for (name, given) in surfaces {
        let made = remesh(&given, 1.0).surface;
        let smallest = smallest_angle(&made).to_degrees();
        assert!(smallest > 25.0, "{name}: {smallest}");
        let geometry = geometry(&made);
        let mean = geometry.mean_edge_length();
        let off = geometry.edge_lengths.iter().map(|l| (l / mean - 1.0).powi(2)).sum::<f64>()
            / geometry.edge_lengths.len() as f64;
        // Splitting and collapsing alone leave about 0.25.
        assert!(off.sqrt() < 0.2, "{name}: {}", off.sqrt());
    }
}

#[test]
fn sharp_edges_of_a_machine_part_stay_where_they_are() {
    let Some(given) = shared("fandisk.obj") else { return };
    let angle = RemeshParams::default().feature_angle;
    let made = remesh(&given, 1.0).surface;
    let (old, new) = (sharp_lines(&given, angle), sharp_lines(&made, 1.05 * angle));
    let length =
        |lines: &[[Point3<f64>; 2]]| lines.iter().map(|[a, b]| (b - a).norm()).sum::<f64>();
    assert!(!new.is_empty());
    // Vertices lie on the lines; chords of the round ones are shorter than the arcs.
    let ends = new.iter().flatten();
    let far = ends.map(|&p| distance_to_lines(p, &old)).fold(0.0, f64::max);
    assert!(far < 1e-9, "{far}");
    let share = length(&new) / length(&old);
    assert!(share > 0.9 && share < 1.001, "{share}");
}

#[test]
fn decimation_keeps_flat_sides_straight_edges_and_texture() {
    let given = subdivide(&surface(&cube()), SubdivideRule::Midpoint { rounds: 4 }).surface;
    let (made, status) = decimate(&given, 100);
    assert_eq!(status, Status::Converged);
    assert!(made.surface.mesh.face_count() <= 100);
    let area = geometry(&made.surface).total_area();
    // The pull towards the given vertices, a thousandth of the planes' weight, rounds edges by next to nothing.
    assert!((area / 24.0 - 1.0).abs() < 1e-2, "{area}");
    let given = wave(24);
    let (made, _) = decimate(&given, 200);
    for (a, b) in texture_areas(&given).into_iter().zip(texture_areas(&made.surface)) {
        // Outline and seams are straight in the texture, and collapsed along themselves; only the corners of the outline might
        // be cut, by some thousandths of an edge.
        assert!((a - b).abs() < 1e-5, "{b} instead of {a}");
    }
}

#[test]
fn decimation_stalls_where_nothing_legal_is_left() {
    for (name, given) in zoo() {
        let (made, status) = decimate(&given, 1);
        let faces = made.surface.mesh.face_count();
        assert!(status == Status::Stalled || faces <= 1, "{name}: {status:?}");
        assert_eq!(shape(&made.surface.mesh), shape(&given.mesh), "{name}");
    }
    let (made, status) = decimate(&surface(&tetrahedron()), 2);
    assert!(status == Status::Stalled && made.surface.mesh.face_count() == 4);
}

#[test]
fn decimation_stays_near_the_surface() {
    let (made, status) = decimate(&sphere(24), 1000);
    assert_eq!(status, Status::Converged);
    for p in &made.surface.positions {
        // Faces of 1000 on a sphere are off by about h²/8 = 0.4 %.
        assert!((p.coords.norm() - 1.0).abs() < 0.01, "{}", p.coords.norm());
    }
    assert!(smallest_angle(&made.surface).to_degrees() > 10.0);
}

/// Another machine, or another build of the same program, rounds in another way.
#[test]
fn decimation_of_an_even_surface_does_not_hang_on_last_digits() {
    let ball = sphere(24);
    let faces = |seed: u64| {
        let mut noisy = ball.clone();
        let mut state = seed;
        for x in noisy.positions.iter_mut().flat_map(|p| p.iter_mut()) {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            *x *= 1.0 + (((state >> 33) % 9) as f64 - 4.0) * f64::EPSILON;
        }
        assert_ne!(noisy.positions, ball.positions);
        decimate(&noisy, 1200).0.surface.mesh
    };
    let plain = decimate(&ball, 1200).0.surface.mesh;
    for seed in 1..5 {
        assert_eq!(faces(seed), plain, "seed {seed}");
    }
}

#[test]
fn flows_repeat_bit_for_bit_and_end_quietly() {
    fn check<F: Flow<State = Prepared>>(make: impl Fn() -> F) {
        let (mut first, status) = run(make());
        let (second, _) = run(make());
        assert_eq!(first.state(), second.state());
        let last = first.state().clone();
        let report = first.step().unwrap();
        assert_eq!(report, first.step().unwrap(), "quiet at the end");
        assert_eq!(report.status, status);
        assert_eq!(first.state(), &last);
    }
    let given = wave(20);
    check(|| SubdivideFlow::new(given.clone(), &SubdivideParams::default()).unwrap());
    let params = RemeshParams { iterations: 3, adaptivity: 1.0, ..RemeshParams::default() };
    check(|| RemeshFlow::new(given.clone(), &params).unwrap());
    let params = DecimateParams { target_faces: 300, ..DecimateParams::default() };
    check(|| DecimateFlow::new(given.clone(), &params).unwrap());
}

#[test]
fn every_state_on_the_way_is_complete() {
    let given = two_spheres();
    let mut flow = RemeshFlow::new(given.clone(), &RemeshParams::default()).unwrap();
    loop {
        let state = flow.state();
        assert_eq!(shape(&state.surface.mesh), shape(&given.mesh));
        assert_eq!(state.surface.positions.len(), state.ancestors.len());
        if flow.step().unwrap().status != Status::Running {
            break;
        }
    }
}

#[test]
fn degenerate_triangles_far_places_and_tiny_scales_do_no_harm() {
    let thin = |scale: f64, shift: f64| {
        let mut soup = cylinder(12, 5);
        for p in &mut soup.positions {
            *p = p.map(|x| x * scale + shift);
        }
        // Three corners on a line: faces without area.
        soup.positions[20] = soup.positions[21];
        surface(&soup)
    };
    for (scale, shift) in [(1.0, 0.0), (1e-12, 0.0), (1e12, 0.0), (1.0, 1e8)] {
        let given = thin(scale, shift);
        for (tool, made) in all_tools(&given) {
            assert_eq!(shape(&made.surface.mesh), shape(&given.mesh), "{tool} {scale} {shift}");
            assert!(all_finite(&made.surface), "{tool} {scale} {shift}");
        }
    }
    let mut broken = triangle();
    broken.positions[1].x = f64::NAN;
    let fails = SubdivideFlow::new(broken, &SubdivideParams::default());
    assert_eq!(fails.err(), Some(SolveError::NotFinite));
}

#[test]
fn options_out_of_range_are_refused_by_name() {
    let params = RemeshParams { target: EdgeTarget::Length(1e-9), ..RemeshParams::default() };
    let error = RemeshFlow::new(sphere(3), &params).err();
    assert!(matches!(error, Some(SolveError::Parameter { name: "edge length", .. })), "{error:?}");
    let rule = SubdivideRule::Curvature { tolerance: f64::NAN };
    assert!(SubdivideParams { rule, max_faces: 10 }.validate().is_err());
    assert!(DecimateParams { target_faces: 0, ..DecimateParams::default() }.validate().is_err());
}

#[test]
fn a_surface_goes_to_a_soup_and_back() {
    let given = wave(6);
    let soup = given.clone().into_soup();
    let polygons: Vec<u32> = (0..soup.polygon_count() as u32).collect();
    let triangles: Vec<[u32; 3]> = soup.corners.chunks(3).map(|t| [t[0], t[1], t[2]]).collect();
    assert_eq!(Surface::new(&soup, &triangles, &polygons).unwrap(), given);
    // 49 vertices, 7 of them on the seam.
    assert_eq!(soup.texture_coordinates.len(), 56);
}

#[test]
fn coarseness_is_the_angle_of_an_edge_on_a_sphere_and_nothing_on_a_plane() {
    for n in [4, 8, 16] {
        let given = sphere(n);
        let longest = geometry(&given).edge_lengths.iter().copied().fold(0.0, f64::max);
        let value = coarseness(&given.mesh, &given.positions);
        // 95 % of the area has edges up to the longest; curvature of the polyhedron is off by a few percent.
        assert!(value > 0.85 * longest && value < 1.1 * longest, "{n}: {value} {longest}");
    }
    let flat = strip();
    assert!(coarseness(&flat.mesh, &flat.positions) < 1e-6);
    let cylinder = surface(&cylinder(24, 9));
    assert!(coarseness(&cylinder.mesh, &cylinder.positions) < 1e-6);
    let tetrahedron = surface(&tetrahedron());
    assert!(coarseness(&tetrahedron.mesh, &tetrahedron.positions) > TOO_COARSE);
}
