//! Cutting patches to disks: every shape of patch becomes a disk, along short cuts that leave all else alone.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "tests may panic and read files, are small, and compare what must be equal"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use cutflow::geometry::Geometry;
use cutflow::geometry::polygon::triangulate;
use cutflow::mesh::read::obj;
use cutflow::mesh::{CutMesh, FaceId, HalfedgeId, Mesh};
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial};
use cutflow::methods::cutgraph::{DiskCuts, cut_to_disks};
use cutflow::session::samples;
use nalgebra::{Point3, Vector3};

/// A surface in space.
struct Surface {
    cut: CutMesh,
    positions: Vec<Point3<f64>>,
}

impl Surface {
    fn new(positions: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Self {
        // Vertices in use only, in their order.
        let mut used: Vec<u32> = triangles.concat();
        used.sort_unstable();
        used.dedup();
        let triangles = Vec::from_iter(
            triangles.iter().map(|t| t.map(|v| used.partition_point(|&w| w < v) as u32)),
        );
        let positions = Vec::from_iter(used.iter().map(|&v| Point3::from(positions[v as usize])));
        let mesh = Mesh::new(used.len(), &triangles).unwrap();
        Self { cut: CutMesh::uncut(&mesh), positions }
    }

    /// Triangles of a polygon file.
    fn read(name: &str) -> Option<Self> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/meshes/").to_owned() + name;
        let Ok(bytes) = std::fs::read(path) else {
            eprintln!("skipped: ../shared/meshes/{name} is not there");
            return None;
        };
        let soup = obj::read(&bytes).unwrap().soup;
        let mut triangles = Vec::new();
        for i in 0..soup.polygon_count() {
            triangulate(&soup.positions, soup.polygon(i), &mut triangles);
        }
        Some(Self::new(soup.positions, &triangles))
    }

    fn length(&self, [a, b]: [u32; 2]) -> f64 {
        (self.positions[a as usize] - self.positions[b as usize]).norm()
    }

    /// Cuts to disks and checks everything that is promised of any surface.
    fn cut_to_disks(&mut self) -> DiskCuts {
        let before = self.cut.clone();
        let rim = rim(&before);
        let added = cut_to_disks(&mut self.cut, &self.positions).unwrap();

        let shapes = added.opened.patch_shapes();
        assert!(shapes.iter().all(|&shape| shape == (1, 1)), "{shapes:?}");
        assert_eq!(added.opened.patch_count, before.open().unwrap().patch_count);
        let (old, new) = self.cut.cut_edges.split_at(before.cut_edges.len());
        assert_eq!((old, new), (&before.cut_edges[..], &added.edges[..]));
        assert_eq!(self.cut.triangles, before.triangles);
        let length: f64 = new.iter().map(|&edge| self.length(edge)).sum();
        assert!(
            (added.length - length).abs() <= 1e-12 * length,
            "only the order of adding differs"
        );
        let distinct: BTreeSet<[u32; 2]> = new.iter().map(sorted).collect();
        assert_eq!(distinct.len(), new.len(), "each edge once");
        assert!(distinct.iter().all(|edge| !rim.contains(edge)), "never along a rim");

        let mut again = before;
        let repeated = cut_to_disks(&mut again, &self.positions).unwrap();
        assert_eq!(repeated.edges, added.edges, "deterministic");
        let nothing = cut_to_disks(&mut self.cut, &self.positions).unwrap();
        assert_eq!((nothing.edges.len(), nothing.patches), (0, 0));
        added
    }
}

/// The edges of a patch's boundary: cuts, and edges of one triangle.
fn rim(cut: &CutMesh) -> BTreeSet<[u32; 2]> {
    let mut counts = BTreeMap::new();
    for t in &cut.triangles {
        for i in 0..3 {
            *counts.entry(sorted(&[t[i], t[(i + 1) % 3]])).or_insert(0) += 1;
        }
    }
    let single = counts.into_iter().filter(|&(_, count)| count == 1).map(|(edge, _)| edge);
    single.chain(cut.cut_edges.iter().map(sorted)).collect()
}

fn sorted(edge: &[u32; 2]) -> [u32; 2] {
    [edge[0].min(edge[1]), edge[0].max(edge[1])]
}

/// The n × m squares of a rectangle that are wanted, halved, put in space by their corners' numbers.
fn sheet(
    [n, m]: [u32; 2],
    is_wanted: impl Fn(u32, u32) -> bool,
    place: impl Fn(f64, f64) -> [f64; 3],
) -> Surface {
    let at = |i: u32, j: u32| i * (m + 1) + j;
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).filter(|&(i, j)| is_wanted(i, j))
    {
        triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    let corners = (0..=n).flat_map(|i| (0..=m).map(move |j| (f64::from(i), f64::from(j))));
    Surface::new(corners.map(|(i, j)| place(i, j)).collect(), &triangles)
}

/// n × m squares around a ring; closed the other way as well if the tube is.
fn ring([n, m]: [u32; 2], is_tube: bool, place: impl Fn(f64, f64) -> [f64; 3]) -> Surface {
    let rows = if is_tube { m } else { m + 1 };
    let at = |i: u32, j: u32| (i % n) * rows + j % rows;
    let mut triangles = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    let corners = (0..n).flat_map(|i| (0..rows).map(move |j| (f64::from(i), f64::from(j))));
    Surface::new(corners.map(|(i, j)| place(i, j)).collect(), &triangles)
}

fn torus(n: u32, m: u32, radius: f64) -> Surface {
    ring([n, m], true, |i, j| {
        let (u, v) = (TAU * i / f64::from(n), TAU * j / f64::from(m));
        let r = 1.0 + radius * v.cos();
        [r * u.cos(), r * u.sin(), radius * v.sin()]
    })
}

/// The surface of the unit cubes of a block that are filled, each side k × k squares, but for the sides left out.
fn cubes(
    size: [i32; 3],
    k: i32,
    is_filled: impl Fn([i32; 3]) -> bool,
    is_left_out: impl Fn([i32; 3], usize) -> bool,
) -> Surface {
    let inside = |c: [i32; 3]| (0..3).all(|a| (0..size[a]).contains(&c[a])) && is_filled(c);
    let mut numbers = BTreeMap::new();
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let cells = (0..size[0])
        .flat_map(|x| (0..size[1]).flat_map(move |y| (0..size[2]).map(move |z| [x, y, z])));
    for cell in cells.filter(|&c| inside(c)) {
        for side in 0..6 {
            let (axis, is_upper) = (side / 2, side % 2 == 1);
            let mut neighbour = cell;
            neighbour[axis] += if is_upper { 1 } else { -1 };
            if inside(neighbour) || is_left_out(cell, side) {
                continue;
            }
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut corner = |i: i32, j: i32| {
                let mut place = cell.map(|x| x * k);
                place[axis] += if is_upper { k } else { 0 };
                place[b] += i;
                place[c] += j;
                *numbers.entry(place).or_insert_with(|| {
                    positions.push(place.map(|x| f64::from(x) / f64::from(k)));
                    positions.len() as u32 - 1
                })
            };
            for (i, j) in (0..k).flat_map(|i| (0..k).map(move |j| (i, j))) {
                let mut quad =
                    [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                if !is_upper {
                    quad.reverse();
                }
                triangles.push([quad[0], quad[1], quad[2]]);
                triangles.push([quad[0], quad[2], quad[3]]);
            }
        }
    }
    Surface::new(positions, &triangles)
}

#[test]
fn an_annulus_is_cut_along_its_shortest_crossing() {
    // From radius 1 to 3; squares are halved, so a radial line is a path of edges.
    let mut annulus = ring([96, 24], false, |i, j| {
        let (angle, r) = (TAU * i / 96.0, 1.0 + j / 12.0);
        [r * angle.cos(), -r * angle.sin(), 0.0]
    });
    let added = annulus.cut_to_disks();
    assert!((added.length - 2.0).abs() < 1e-9, "{}", added.length);
    assert_eq!(added.patches, 1);
}

#[test]
fn an_eccentric_annulus_is_cut_where_it_is_narrow() {
    // Between the unit circle and one of radius 1.6 about (0.4, 0): 0.2 apart on the left.
    let mut annulus = ring([90, 30], false, |i, j| {
        let (angle, t) = (TAU * i / 90.0, j / 30.0);
        [(1.0 + 0.6 * t) * angle.cos() + 0.4 * t, -(1.0 + 0.6 * t) * angle.sin(), 0.0]
    });
    let added = annulus.cut_to_disks();
    assert!(added.length >= 0.2 - 1e-12 && added.length < 1.1 * 0.2, "{}", added.length);
}

#[test]
fn a_disk_with_five_holes_becomes_a_disk() {
    let holes = [[3, 3], [14, 3], [8, 9], [3, 15], [15, 14]];
    let is_wanted =
        |i, j| !holes.iter().any(|&[x, y]| (x..x + 3).contains(&i) && (y..y + 3).contains(&j));
    let mut sieve = sheet([20, 20], is_wanted, |i, j| [i, j, 0.0]);
    assert_eq!(sieve.cut.open().unwrap().patch_shapes(), [(-4, 6)]);
    let added = sieve.cut_to_disks();
    // The four outer holes are 3, 3, 2 and 2 from the rim, the middle one 3 + 2 from the nearest hole: along lattice
    // lines, or diagonals where they help.
    assert!(added.length <= 3.0 + 3.0 + 2.0 + 2.0 + 5.0 + 1e-9, "{}", added.length);
    assert!(added.length >= 3.0 + 3.0 + 2.0 + 2.0 + 8.0_f64.sqrt() - 1e-9, "{}", added.length);
}

#[test]
fn a_torus_is_cut_around_and_along() {
    let mut surface = torus(96, 40, 0.4);
    let added = surface.cut_to_disks();
    // Once around the tube (0.4) and once around the hole (0.6), polygons both.
    let around = TAU * 0.4 + TAU * 0.6;
    assert!(added.length < around * 1.001, "{} of {around}", added.length);
    assert!(added.length > around * 0.99, "{} of {around}", added.length);
}

#[test]
fn a_torus_without_a_disk_is_cut_from_its_rim() {
    let mut surface = torus(60, 30, 0.4);
    let out = BTreeSet::from_iter(surface.cut.triangles[600..602].iter().flatten().copied());
    let kept: Vec<[u32; 3]> = surface
        .cut
        .triangles
        .iter()
        .filter(|t| !t.iter().any(|v| out.contains(v)))
        .copied()
        .collect();
    let positions = surface.positions.iter().map(|p| [p.x, p.y, p.z]).collect();
    surface = Surface::new(positions, &kept);
    assert_eq!(surface.cut.open().unwrap().patch_shapes(), [(-1, 1)]);
    let added = surface.cut_to_disks();
    assert!(added.length < TAU, "{}", added.length);
}

#[test]
fn frames_with_windows_are_cut_at_every_handle() {
    for windows in 1..=3 {
        let size = [2 * windows + 1, 3, 1];
        let is_filled = |[x, y, _]: [i32; 3]| !(x % 2 == 1 && y == 1);
        let mut frame = cubes(size, 4, is_filled, |_, _| false);
        let euler = 2 - 2 * i64::from(windows);
        assert_eq!(frame.cut.open().unwrap().patch_shapes(), [(euler, 0)]);
        let added = frame.cut_to_disks();
        // Each window needs a loop through it around a bar (4) and one around it (4 at its inner edge), in one piece.
        assert!(added.length <= 8.5 * f64::from(windows), "{windows}: {}", added.length);
        // A side left out on top: the same handles, from a rim.
        let mut lamp = cubes(size, 4, is_filled, |c, side| c == [0, 0, 0] && side == 5);
        assert_eq!(lamp.cut.open().unwrap().patch_shapes(), [(euler - 1, 1)]);
        lamp.cut_to_disks();
    }
}

#[test]
fn a_sphere_is_slit_from_end_to_end() {
    let ball = samples::icosphere(12);
    let triangles = Vec::from_iter((0..ball.polygon_count()).map(|i| {
        let t = ball.polygon(i);
        [t[0], t[1], t[2]]
    }));
    let mut surface = Surface::new(ball.positions, &triangles);
    let added = surface.cut_to_disks();
    // Antipodes are π apart; edge paths are a little longer, at most by 2/√3.
    assert!(added.length > 3.0 && added.length < 3.7, "{}", added.length);
    // A tetrahedron's vertices are all neighbours.
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut small = Surface::new(corners, &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]);
    assert_eq!(small.cut_to_disks().edges.len(), 2);
}

#[test]
fn the_torus_of_seven_vertices_is_cut() {
    // Möbius's torus: every two vertices are neighbours.
    let triangles = Vec::from_iter(
        (0..7).flat_map(|i| [[i, (i + 1) % 7, (i + 3) % 7], [i, (i + 3) % 7, (i + 2) % 7]]),
    );
    let corners = (0..7).map(|i| [f64::from(i), f64::from(i * i % 7), f64::from(i * i * i % 7)]);
    let mut surface = Surface::new(corners.collect(), &triangles);
    assert_eq!(surface.cut.open().unwrap().patch_shapes(), [(0, 0)]);
    surface.cut_to_disks();
}

#[test]
fn a_cylinder_with_a_slit_keeps_the_slit_and_gets_a_shorter_cut() {
    let mut cylinder = ring([40, 20], false, |i, j| {
        let angle = TAU * i / 40.0;
        [angle.cos(), angle.sin(), j / 10.0]
    });
    // From height 0.5 to 1.5: two crossings of 0.5 remain.
    cylinder.cut.cut_edges = (5..15).map(|j| [j, j + 1]).collect();
    assert_eq!(cylinder.cut.open().unwrap().patch_shapes(), [(-1, 3)]);
    let added = cylinder.cut_to_disks();
    assert!((added.length - 1.0).abs() < 1e-9, "{}", added.length);
}

#[test]
fn several_patches_are_cut_at_once_and_disks_are_left_alone() {
    // A torus cut twice around the tube and once lengthwise on one of the two halves: an annulus and a disk.
    let mut surface = torus(60, 30, 0.4);
    let meridian = |i: u32| (0..30).map(move |j| [30 * i + j, 30 * i + (j + 1) % 30]);
    surface.cut.cut_edges = meridian(0).chain(meridian(20)).collect();
    surface.cut.cut_edges.extend((0..20).map(|i| [30 * i, 30 * (i + 1)]));
    let opened = surface.cut.open().unwrap();
    assert_eq!(opened.patch_shapes(), [(1, 1), (0, 2)]);
    let added = surface.cut_to_disks();
    assert_eq!(added.patches, 1);
    // Two thirds of the way around the hole.
    assert!(added.length < TAU * 0.6 * 2.0 / 3.0 * 1.001, "{}", added.length);
    // Four annuli.
    surface.cut.cut_edges = [0, 11, 29, 44].into_iter().flat_map(meridian).collect();
    let added = surface.cut_to_disks();
    assert_eq!((added.patches, added.opened.patch_count), (4, 4));
    assert!(added.length < TAU * 0.6 * 1.001, "{}", added.length);
}

/// Cuts a surface into random connected regions, and returns the shapes of its patches.
fn split_at_random(surface: &mut Surface, regions: usize, seed: u64) -> Vec<(i64, usize)> {
    let mut state = seed;
    let mut random = |n: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let mesh = Mesh::new(surface.positions.len(), &surface.cut.triangles).unwrap();
    let mut labels = vec![None; mesh.face_count()];
    let mut front = Vec::new();
    for region in 0..regions {
        front.push((FaceId::from(random(mesh.face_count())), region));
    }
    // Any face of the front next: ragged regions of all shapes.
    while !front.is_empty() {
        let (face, region) = front.swap_remove(random(front.len()));
        if labels[face.index()].is_none() {
            labels[face.index()] = Some(region);
            let neighbours = mesh.face_halfedges(face).map(|h| mesh.face(h.twin()));
            front.extend(neighbours.into_iter().flatten().map(|neighbour| (neighbour, region)));
        }
    }
    let label = |h: HalfedgeId| mesh.face(h).map(|f| labels[f.index()]);
    let cut = mesh.edges().filter(|e| {
        let h = e.halfedge();
        !mesh.is_boundary_edge(*e) && label(h) != label(h.twin())
    });
    surface.cut.cut_edges = cut.map(|e| mesh.edge_vertices(e).map(|v| v.0)).collect();
    surface.cut.open().unwrap().patch_shapes()
}

#[test]
fn ragged_patches_of_any_shape_become_disks() {
    let mut shapes = BTreeSet::new();
    for seed in 0..60 {
        let windows = 1 + (seed % 3) as i32;
        let is_filled = |[x, y, _]: [i32; 3]| !(x % 2 == 1 && y == 1);
        let is_left_out = |c: [i32; 3], side| seed % 2 == 1 && c == [0, 0, 0] && side == 5;
        let mut frame = cubes([2 * windows + 1, 3, 1], 2, is_filled, is_left_out);
        shapes.extend(split_at_random(&mut frame, 1 + (seed % 7) as usize, seed));
        frame.cut_to_disks();
    }
    // With handles, with many loops, closed: all were met.
    assert!(shapes.iter().any(|&(euler, loops)| loops > 0 && euler + (loops as i64) < 2));
    assert!(shapes.iter().any(|&(_, loops)| loops >= 4), "{shapes:?}");
    assert!(shapes.iter().any(|&(_, loops)| loops == 0));
}

#[test]
fn stretching_a_surface_evenly_changes_no_cut() {
    let mut surface = torus(40, 24, 0.4);
    let edges = surface.cut_to_disks().edges;
    // Powers of two scale without rounding.
    for scale in [2.0_f64.powi(-20), 2.0_f64.powi(20)] {
        let mut scaled = torus(40, 24, 0.4);
        scaled.positions.iter_mut().for_each(|p| *p *= scale);
        assert_eq!(scaled.cut_to_disks().edges, edges);
    }
}

#[test]
fn cuts_through_faces_are_refined_to_disks() {
    // Planes through the hole leave two tubes or two rings; one beside it a disk and a torus without a disk.
    let soup = samples::generate("torus").unwrap();
    let triangles = Vec::from_iter((0..soup.polygon_count()).map(|i| {
        let t = soup.polygon(i);
        [t[0], t[1], t[2]]
    }));
    let mesh = Mesh::new(soup.positions.len(), &triangles).unwrap();
    let (geometry, frame) = Geometry::unit_area(&mesh, &soup.positions).unwrap();
    let mut shapes = Vec::new();
    for (offset, normal) in
        [(0.02, Vector3::x()), (1.2, Vector3::x()), (0.01, Vector3::y()), (-1.1, Vector3::z())]
    {
        let point = Point3::from(normal * offset * frame.scale);
        let start = Initial::Plane { point, normal };
        let flow =
            CutFlow::new(mesh.clone(), geometry.clone(), &start, CutFlowParams::default()).unwrap();
        let cut = flow.cut_mesh();
        let positions = cut.points.iter().map(|&p| geometry.locate(&mesh, p)).collect();
        let mut surface = Surface { cut, positions };
        shapes.push(surface.cut.open().unwrap().patch_shapes());
        surface.cut_to_disks();
    }
    assert!(shapes.iter().flatten().any(|&shape| shape == (0, 2)), "{shapes:?}");
    assert!(shapes.iter().flatten().any(|&shape| shape == (-1, 1)), "{shapes:?}");
}

#[test]
fn real_surfaces_become_disks() {
    // Name, shape before, and how much longer than √area the cut may be: what was reached, and 2 % more.
    for (name, shape, reached) in [
        ("torus.obj", (0, 0), 1.5814),
        ("rocker-arm.obj", (0, 0), 1.3238),
        ("double-torus.obj", (-2, 0), 2.9918),
        ("chair.obj", (-2, 0), 2.1560),
        ("stanford-bunny.obj", (-3, 5), 0.2874),
        ("beetle.obj", (-9, 11), 0.6648),
        ("hood.obj", (0, 2), 0.2609),
        ("spot.obj", (2, 0), 1.0609),
    ] {
        let Some(mut surface) = Surface::read(name) else { continue };
        assert_eq!(surface.cut.open().unwrap().patch_shapes(), [shape], "{name}");
        let area = surface.cut.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| surface.positions[v as usize]);
            (b - a).cross(&(c - a)).norm() / 2.0
        });
        let side = area.sum::<f64>().sqrt();
        let length = surface.cut_to_disks().length / side;
        assert!(length < 1.02 * reached, "{name}: {length}");
    }
}
