//! Straightening: curves become as short as they can be without anything else changing.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use cutflow::flatten::{bff, measure};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, Mesh, Soup, SurfacePoint, VertexId};
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial};
use cutflow::methods::cutgraph::cut_to_disks;
use cutflow::methods::flow::Flow;
use cutflow::methods::straighten::{
    StraightenParams, Straightened, length, snap_to_edges, straighten,
};
use nalgebra::Point3;

use crate::surfaces::{Surface, cube};

/// Everything free, nothing a feature.
fn free() -> StraightenParams {
    StraightenParams { free_from: 0, feature_angle: 4.0, ..StraightenParams::default() }
}

fn places(s: &Surface, cut: &CutMesh) -> Vec<Point3<f64>> {
    cut.points.iter().map(|&p| s.geometry.locate(&s.mesh, p)).collect()
}

/// Straightens and checks what is promised of any surface.
fn checked(s: &Surface, cut: &CutMesh, params: &StraightenParams, pins: &[f64]) -> Straightened {
    let straight = straighten(&s.mesh, &s.geometry, cut, params, pins).unwrap();
    assert_eq!(straight.unchanged, None, "{}", s.name);
    let new = &straight.cut;
    for (i, p) in new.points.iter().take(s.mesh.vertex_count()).enumerate() {
        assert_eq!(*p, SurfacePoint::Vertex(VertexId(i as u32)), "{}: vertices come first", s.name);
    }
    let at = places(s, new);
    let mut areas = vec![0.0; s.mesh.face_count()];
    for (t, f) in new.triangles.iter().zip(&new.triangle_faces) {
        let [a, b, c] = t.map(|p| at[p as usize]);
        let area = 0.5 * (b - a).cross(&(c - a)).norm();
        assert!(area > 0.0, "{}: a triangle of face {} has no area", s.name, f.0);
        areas[f.index()] += area;
    }
    for (area, whole) in areas.iter().zip(&s.geometry.face_areas) {
        // A triangle turned over or left out would show; coordinates are of size 1 and areas of 1e-4.
        assert!((area - whole).abs() < 1e-9 * whole, "{}: {area} {whole}", s.name);
    }
    let shapes = |cut: &CutMesh| {
        let mut shapes = cut.open().unwrap().patch_shapes();
        shapes.sort_unstable();
        shapes
    };
    assert_eq!(shapes(new), shapes(cut), "{}", s.name);
    let distinct: BTreeSet<[u32; 2]> =
        new.cut_edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    assert_eq!(distinct.len(), new.cut_edges.len(), "{}: each edge once", s.name);
    let again = straighten(&s.mesh, &s.geometry, cut, params, pins).unwrap();
    assert!(again.cut == straight.cut, "{}: deterministic", s.name);
    straight
}

/// Flipped triangles of all charts; every patch must have one.
fn flips(s: &Surface, cut: &CutMesh) -> usize {
    let at = places(s, cut);
    let opened = cut.open().unwrap();
    let positions = opened.vertex_points.iter().map(|&p| at[p as usize]).collect();
    let geometry = Geometry::measure(&opened.mesh, positions);
    let flat = bff(&opened, &geometry).unwrap();
    assert!(flat.charts.iter().all(Result::is_ok), "{}", s.name);
    measure(&opened, &geometry, &flat).totals.flipped
}

/// A path of mesh edges from one vertex to another, each vertex the neighbour nearest to the goal in space: as jagged as the mesh is.
fn greedy_path(s: &Surface, from: u32, to: u32) -> Vec<[u32; 2]> {
    let at = |v: u32| s.geometry.positions[v as usize];
    let (mut path, mut v) = (Vec::new(), from);
    while v != to {
        let next = s.mesh.outgoing(VertexId(v)).map(|h| s.mesh.tip(h).0);
        let next = next
            .min_by(|&a, &b| (at(a) - at(to)).norm().total_cmp(&(at(b) - at(to)).norm()))
            .unwrap();
        path.push([v, next]);
        v = next;
        assert!(path.len() < 1000);
    }
    path
}

fn nearest(s: &Surface, p: [f64; 3]) -> u32 {
    let far = |v: &u32| (s.geometry.positions[*v as usize] - Point3::from(p)).norm();
    (0..s.mesh.vertex_count() as u32).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()
}

/// n × m squares put in space, the diagonals alternating or not; nothing is welded.
fn sheet([n, m]: [u32; 2], place: impl Fn(f64, f64) -> [f64; 3]) -> Soup {
    let at = |i: u32, j: u32| i * (m + 1) + j;
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    let corners = (0..=n).flat_map(|i| (0..=m).map(move |j| (f64::from(i), f64::from(j))));
    Soup::from_triangles(corners.map(|(i, j)| place(i, j)).collect(), &triangles)
}

/// A prism over a regular polygon, open at both ends, side strips of m squares.
fn prism(n: u32, m: u32) -> Soup {
    let mut triangles = Vec::new();
    let at = |i: u32, j: u32| (i % n) * (m + 1) + j;
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    let corners = (0..n).flat_map(|i| (0..=m).map(move |j| (f64::from(i), f64::from(j))));
    let place = |(i, j): (f64, f64)| {
        let a = TAU * i / f64::from(n);
        [a.cos(), a.sin(), 3.0 * j / f64::from(m)]
    };
    Soup::from_triangles(corners.map(place).collect(), &triangles)
}

#[test]
fn a_jagged_arc_on_a_sphere_becomes_a_great_arc_with_the_square_of_the_edge() {
    let mut errors = Vec::new();
    for n in [8, 16, 32] {
        let s = Surface::sphere(n);
        let radius = s.geometry.positions[0].coords.norm();
        let (from, to) =
            (nearest(&s, [0.1, 0.2, radius]), nearest(&s, [0.9 * radius, -0.1, -0.1 * radius]));
        let mut cut = CutMesh::uncut(&s.mesh);
        cut.cut_edges = greedy_path(&s, from, to);
        let straight = checked(&s, &cut, &free(), &[]);
        let [p, q] = [from, to].map(|v| s.geometry.positions[v as usize].coords / radius);
        let exact = radius * p.dot(&q).acos();
        assert!(
            straight.lengths[0] > 1.02 * exact,
            "jagged before: {}",
            straight.lengths[0] / exact
        );
        errors.push((straight.lengths[1] / exact - 1.0).abs());
    }
    // Chords lie inside the sphere by h²/8.
    assert!(
        errors[0] < 5e-3 && errors[1] < 0.35 * errors[0] && errors[2] < 0.35 * errors[1],
        "{errors:?}"
    );
}

#[test]
fn on_a_prism_the_curve_is_the_straight_line_of_the_unrolled_sheet() {
    let s = Surface::from_soup("prism", &prism(24, 20));
    let mut cut = CutMesh::uncut(&s.mesh);
    let at = |p: [f64; 3]| {
        // The soup's first vertex is (1, 0, 0); unit area scales all alike.
        let scale = s.geometry.total_area() / (24.0 * 2.0 * (TAU / 48.0).sin() * 3.0);
        nearest(&s, [p[0] * scale.sqrt(), p[1] * scale.sqrt(), (p[2] - 1.5) * scale.sqrt()])
    };
    let (from, to) = (at([1.0, 0.0, 0.3]), at([(TAU / 4.0).cos(), (TAU / 4.0).sin(), 2.55]));
    cut.cut_edges = greedy_path(&s, from, to);
    let straight = checked(&s, &cut, &free(), &[]);
    let scale = (1.0 / (24.0 * 2.0 * (TAU / 48.0).sin() * 3.0)).sqrt();
    let exact = scale * (6.0 * 2.0 * (TAU / 48.0).sin()).hypot(2.25);
    // The gap of a thousandth of an edge at each vertex that the line passes through, squared.
    assert!((straight.lengths[1] / exact - 1.0).abs() < 1e-5, "{} {exact}", straight.lengths[1]);

    // From rim to rim both ends slide: the height is left.
    let mut cut = CutMesh::uncut(&s.mesh);
    cut.cut_edges = greedy_path(&s, at([1.0, 0.0, 0.0]), at([0.0, 1.0, 3.0]));
    let straight = checked(&s, &cut, &free(), &[]);
    assert!((straight.lengths[1] / (3.0 * scale) - 1.0).abs() < 1e-5, "{}", straight.lengths[1]);
    assert_eq!(straight.cut.open().unwrap().patch_shapes(), [(1, 1)]);
}

#[test]
fn over_an_edge_of_a_cube_the_curve_is_straight_when_unfolded() {
    let n = 12;
    // Two sides of a cube: the sheet is bent by a right angle in its middle.
    let bend = |i: f64, j: f64| {
        let x = i - f64::from(n);
        if x <= 0.0 { [x, j, 0.0] } else { [0.0, j, -x] }
    };
    let s = Surface::from_soup("bend", &sheet([2 * n, n], bend));
    let number = |i: u32, j: u32| {
        let scale = (1.0 / f64::from(2 * n * n)).sqrt();
        let p = bend(f64::from(i), f64::from(j));
        let low = bend(0.0, 0.0);
        let high = [0.0, f64::from(n), -f64::from(n)];
        nearest(
            &s,
            [0, 1, 2].map(|k| scale * (p[k] - 0.5 * (low[k].min(high[k]) + low[k].max(high[k])))),
        )
    };
    let mut cut = CutMesh::uncut(&s.mesh);
    let (from, to) = (number(3, 9), number(20, 2));
    cut.cut_edges = greedy_path(&s, from, to);
    let straight = checked(&s, &cut, &free(), &[]);
    let exact = 17f64.hypot(7.0) / f64::from(2 * n * n).sqrt();
    assert!((straight.lengths[1] / exact - 1.0).abs() < 1e-6, "{} {exact}", straight.lengths[1]);

    // Cut along the sharp edge it stays, and so does all that meets it.
    let mut cut = CutMesh::uncut(&s.mesh);
    cut.cut_edges = (0..n).map(|j| [number(n, j), number(n, j + 1)]).collect();
    let straight = checked(&s, &cut, &StraightenParams::default(), &[]);
    assert_eq!(straight.cut.points.len(), s.mesh.vertex_count());
    assert_eq!(straight.cut.cut_edges.len(), n as usize);
}

#[test]
fn three_curves_meet_at_120_degrees() {
    let s = Surface::from_soup("sheet", &sheet([30, 30], |i, j| [i, j, 0.0]));
    let at = |i: f64, j: f64| nearest(&s, [(i - 15.0) / 30.0, (j - 15.0) / 30.0, 0.0]);
    let tips = [[4.0, 5.0], [26.0, 7.0], [13.0, 27.0]];
    let mut edges = BTreeSet::new();
    for [i, j] in tips {
        for [a, b] in greedy_path(&s, at(i, j), at(9.0, 9.0)) {
            edges.insert([a.min(b), a.max(b)]);
        }
    }
    let mut cut = CutMesh::uncut(&s.mesh);
    cut.cut_edges = edges.into_iter().collect();
    let straight = checked(&s, &cut, &free(), &[]);
    // The Fermat point's distances: (Σ a² + 4 √3 A) / 2, squared.
    let side = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    let [a, b, c] = tips;
    let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
    let sum = side(a, b) + side(b, c) + side(c, a);
    let exact = (0.5 * sum + 2.0 * 3f64.sqrt() * area).sqrt() / 30.0;
    assert!((straight.lengths[1] / exact - 1.0).abs() < 1e-5, "{} {exact}", straight.lengths[1]);
}

#[test]
fn pinned_vertices_stay_on_their_curve() {
    let s = Surface::from_soup("sheet", &sheet([20, 20], |i, j| [i, j, 0.0]));
    let at = |i: f64, j: f64| nearest(&s, [(i - 10.0) / 20.0, (j - 10.0) / 20.0, 0.0]);
    let middle = at(10.0, 16.0);
    let mut cut = CutMesh::uncut(&s.mesh);
    cut.cut_edges = greedy_path(&s, at(2.0, 14.0), middle);
    cut.cut_edges.extend(greedy_path(&s, middle, at(18.0, 5.0)));
    let mut pins = vec![0.0; s.mesh.vertex_count()];
    pins[middle as usize] = 1.0;
    let straight = checked(&s, &cut, &free(), &pins);
    assert!(straight.cut.cut_edges.iter().flatten().any(|&p| p == middle));
    let exact = (8f64.hypot(2.0) + 8f64.hypot(11.0)) / 20.0;
    assert!((straight.lengths[1] / exact - 1.0).abs() < 1e-5, "{} {exact}", straight.lengths[1]);
}

#[test]
fn disk_cuts_of_handles_become_short_and_still_open_to_disks_that_flatten() {
    for (name, euler) in [("torus", 0), ("double_torus", -2)] {
        let s = Surface::sample(name);
        let mut cut = CutMesh::uncut(&s.mesh);
        let at = places(&s, &cut);
        let added = cut_to_disks(&mut cut, &at).unwrap();
        assert!(added.opened.patch_shapes() == [(1, 1)], "{euler}");
        let before = flips(&s, &cut);
        let straight = checked(&s, &cut, &free(), &[]);
        // Edges of even meshes leave a detour of at least 4 % on average.
        let gain = straight.lengths[1] / straight.lengths[0];
        assert!(gain < 0.99, "{name}: {gain}");
        let after = flips(&s, &straight.cut);
        println!("{name}: {:?}, {before} flips, then {after}", straight.lengths);
        assert!(after <= before, "{name}: {after} flips");
    }
}

/// A flow's cut after some steps.
fn flowed(s: &Surface, degrees: f64, steps: usize) -> CutMesh {
    let initial = Initial::NormalClusters { angle: f64::to_radians(degrees), regions: 10 };
    let params = CutFlowParams::default();
    let mut flow = CutFlow::new(s.mesh.clone(), s.geometry.clone(), &initial, params).unwrap();
    for _ in 0..steps {
        flow.step().unwrap();
    }
    flow.cut_mesh()
}

/// Sum of the turns of the outlines in the charts of all patches, radians.
fn turning(s: &Surface, cut: &CutMesh) -> f64 {
    let at = places(s, cut);
    let opened = cut.open().unwrap();
    let positions = opened.vertex_points.iter().map(|&p| at[p as usize]).collect();
    let geometry = Geometry::measure(&opened.mesh, positions);
    let flat = bff(&opened, &geometry).unwrap();
    (0..opened.patch_count)
        .map(|patch| {
            let outline = flat.outline(&opened, patch);
            let n = outline.len();
            (0..n)
                .map(|i| {
                    let a = outline[(i + 1) % n] - outline[i];
                    let b = outline[(i + 2) % n] - outline[(i + 1) % n];
                    a.perp(&b).atan2(a.dot(&b)).abs()
                })
                .sum::<f64>()
        })
        .sum()
}

#[test]
fn the_outlines_of_a_flow_lose_their_zigzag_and_nothing_else() {
    for name in ["spot.obj", "rocker-arm.obj"] {
        let Some(s) = Surface::shared(name) else { continue };
        let mut cut = flowed(&s, 60.0, 15);
        let held = cut.cut_edges.len();
        let at = places(&s, &cut);
        cut_to_disks(&mut cut, &at).unwrap();
        let params = StraightenParams { free_from: held, ..StraightenParams::default() };
        let straight = checked(&s, &cut, &params, &[]);
        let (before, after) = (turning(&s, &cut), turning(&s, &straight.cut));
        println!("{name}: turning {before} then {after}, length {:?}", straight.lengths);
        assert!(after < 0.7 * before, "{name}: {before} {after}");
        assert!(straight.lengths[1] < straight.lengths[0]);
        let (before, after) = (flips(&s, &cut), flips(&s, &straight.cut));
        // BFF rules none out; which shapes a flow has after 15 steps is a matter of rounding.
        assert!(after <= before + cut.triangles.len() / 1000, "{name}: {before}, then {after}");
        // Areas of patches may change by what a band of half an edge along the cut holds, and do by far less.
        let areas = |cut: &CutMesh| {
            let (at, opened) = (places(&s, cut), cut.open().unwrap());
            let mut areas = vec![0.0; opened.patch_count];
            for (t, &patch) in cut.triangles.iter().zip(&opened.face_patches) {
                let [a, b, c] = t.map(|p| at[p as usize]);
                areas[patch as usize] += 0.5 * (b - a).cross(&(c - a)).norm();
            }
            areas.sort_by(f64::total_cmp);
            areas
        };
        for (a, b) in areas(&cut).into_iter().zip(areas(&straight.cut)) {
            assert!((a - b).abs() < 0.005, "{name}: {a} {b}");
        }
    }
}

#[test]
fn snapped_cuts_run_along_edges_of_the_mesh_and_keep_their_patches() {
    for name in ["spot.obj", "rocker-arm.obj"] {
        let Some(s) = Surface::shared(name) else { continue };
        let cut = flowed(&s, 60.0, 15);
        let snapped = snap_to_edges(&s.mesh, &s.geometry, &cut).unwrap();
        // A ring of a patch may be thinner than a face somewhere, so that shapes may change; none is lost.
        assert!(snapped.lost.is_empty(), "{name}");
        let count = |cut: &CutMesh| cut.open().unwrap().patch_count;
        assert_eq!(count(&snapped.cut), count(&cut), "{name}");
        assert_eq!(snapped.cut.points.len(), s.mesh.vertex_count());
        assert_eq!(snapped.cut.triangles.len(), s.mesh.face_count());
        let is_edge =
            |[a, b]: [u32; 2]| s.mesh.outgoing(VertexId(a)).any(|h| s.mesh.tip(h) == VertexId(b));
        assert!(snapped.cut.cut_edges.iter().all(|&e| is_edge(e)));
        let [before, after] = [&cut, &snapped.cut].map(|c| length(&s.mesh, &s.geometry, c));
        // A staircase along edges of an even mesh is at most 2/√3 times as long as its line, and a little more where it turns.
        assert!(after < 1.4 * before, "{name}: {before} {after}");
    }
}

#[test]
fn snapping_the_equator_of_a_sphere_keeps_two_disks() {
    let s = Surface::sphere(16);
    let levels = s.geometry.positions.iter().map(|p| p.z + 0.1 * p.x + 0.011).collect();
    let flow = CutFlow::new(
        s.mesh.clone(),
        s.geometry.clone(),
        &Initial::Levels(levels),
        CutFlowParams::default(),
    );
    let cut = flow.unwrap().cut_mesh();
    let snapped = snap_to_edges(&s.mesh, &s.geometry, &cut).unwrap();
    assert!(snapped.keeps_shapes && snapped.lost.is_empty());
    assert_eq!(snapped.cut.open().unwrap().patch_shapes(), [(1, 1), (1, 1)]);
    let [before, after] = [&cut, &snapped.cut].map(|c| length(&s.mesh, &s.geometry, c));
    assert!(after < 1.25 * before, "{before} {after}");
}

#[test]
fn a_mesh_without_a_cut_is_left_alone() {
    let s = Surface::from_soup("cube", &cube());
    let cut = CutMesh::uncut(&s.mesh);
    let straight = straighten(&s.mesh, &s.geometry, &cut, &free(), &[]).unwrap();
    assert!(straight.unchanged.is_some() && straight.cut == cut);
    let _: &Mesh = &s.mesh;
}
