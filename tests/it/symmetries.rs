//! Symmetries and visibility of surfaces whose answers are known.

use cutflow::geometry::{
    Geometry, Nearest, Symmetry, SymmetryError, SymmetryKind, find_symmetries, symmetry_group,
    visibility,
};
use cutflow::mesh::{FaceId, Mesh, Soup};
use nalgebra::{Point3, Rotation3, Vector3};

use crate::surfaces::{Surface, cube};

const TOLERANCE: f64 = 0.01;

fn found(s: &Surface) -> Vec<Symmetry> {
    find_symmetries(&s.mesh, &s.geometry, TOLERANCE)
}

fn mirrors(list: &[Symmetry]) -> Vec<Symmetry> {
    list.iter().copied().filter(|s| s.kind == SymmetryKind::Mirror).collect()
}

fn axes(list: &[Symmetry], order: u32) -> usize {
    list.iter().filter(|s| s.kind == SymmetryKind::Rotation { order }).count()
}

/// A function without any symmetry.
fn odd(p: &Point3<f64>) -> f64 {
    (3.0 * p.x + 0.4).sin() + p.y * (2.0 + p.z) + 5.0 * p.x * p.y * p.z
}

/// A cow-like body, mirrored in x, with the triangles of the right side divided finer than those of the left.
fn lopsided(frequency: u32) -> Surface {
    let ball = cutflow::session::samples::icosphere(frequency);
    let bend = |[x, y, z]: [f64; 3]| {
        // Points are drawn to one side along the surface, so that no two vertices are images of each other.
        let p = Vector3::new(x + 0.3 * (1.0 - x * x) + 0.1 * z * y, y, z + 0.05 * x).normalize();
        let r = 1.0 + 0.3 * p.y + 0.2 * p.z * p.z + 0.15 * p.x * p.x * p.z;
        [p.x * r, 1.6 * p.y * r + 0.2 * p.z, 0.8 * p.z * r]
    };
    let mut soup = ball;
    soup.positions = soup.positions.iter().copied().map(bend).collect();
    Surface::from_soup("lopsided", &soup)
}

#[test]
fn an_icosphere_has_fifteen_planes_and_thirty_one_axes() {
    let sphere = Surface::sphere(8);
    let list = found(&sphere);
    assert_eq!(mirrors(&list).len(), 15);
    assert_eq!([axes(&list, 5), axes(&list, 3), axes(&list, 2)], [6, 10, 15]);
    // Sines and square roots of coordinates of size 1.
    assert!(list.iter().all(|s| s.deviation < 1e-12));
    let group = symmetry_group(&sphere.mesh, &sphere.geometry, &mirrors(&list), 120).unwrap();
    assert_eq!(group.len(), 119);
    assert!(group.iter().all(|map| map.is_exact()));
    let too_small = symmetry_group(&sphere.mesh, &sphere.geometry, &mirrors(&list), 119)
        .map(|group| group.len());
    assert_eq!(too_small.unwrap_err(), SymmetryError::TooLarge { most: 119 });
    // The images are where the matrices say.
    for map in &group {
        for v in sphere.mesh.vertices() {
            let (corners, weights) = map.image(v);
            let place =
                |i: usize| sphere.geometry.positions[corners[i].index()].coords * weights[i];
            let image =
                map.centre + map.matrix * (sphere.geometry.positions[v.index()] - map.centre);
            assert!((place(0) + place(1) + place(2) - image.coords).norm() < 1e-9);
        }
    }
}

#[test]
fn an_average_over_a_group_is_invariant() {
    let sphere = Surface::sphere(8);
    let group =
        symmetry_group(&sphere.mesh, &sphere.geometry, &mirrors(&found(&sphere)), 120).unwrap();
    let values: Vec<f64> = sphere.geometry.positions.iter().map(odd).collect();
    let average: Vec<f64> = sphere
        .mesh
        .vertices()
        .map(|v| {
            let sum: f64 = group.iter().map(|map| map.pull(&values, v)).sum();
            (sum + values[v.index()]) / 120.0
        })
        .collect();
    let spread = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    assert!(spread > 1.0);
    for map in &group {
        for v in sphere.mesh.vertices() {
            // Sums of 120 numbers of size 1 in different orders.
            assert!((map.pull(&average, v) - average[v.index()]).abs() < 1e-12);
        }
    }
}

#[test]
fn a_cube_has_forty_eight_symmetries_and_one_mirror_makes_two() {
    for surface in [Surface::from_soup("cube", &cube()), Surface::sample("volleyball")] {
        let list = found(&surface);
        assert_eq!(mirrors(&list).len(), 9, "{}", surface.name);
        assert_eq!([axes(&list, 4), axes(&list, 3), axes(&list, 2)], [3, 4, 6]);
        let group = symmetry_group(&surface.mesh, &surface.geometry, &list, 120).unwrap();
        assert_eq!(group.len() + 1, 48);
        let pair = symmetry_group(&surface.mesh, &surface.geometry, &list[..1], 2).unwrap();
        assert_eq!(pair.len() + 1, 2);
    }
}

#[test]
fn figures_have_their_plane_and_no_other() {
    for name in ["armchair", "plush_bear", "car_hood"] {
        let list = found(&Surface::sample(name));
        assert_eq!(list.len(), 1, "{name}: {list:?}");
        assert!(list[0].direction.x.abs() > 0.9999 && list[0].kind == SymmetryKind::Mirror);
    }
    for name in ["chair.obj", "spot.obj"] {
        let Some(surface) = Surface::shared(name) else { continue };
        let list = found(&surface);
        assert_eq!(list.len(), 1, "{name}: {list:?}");
        assert!(list[0].direction.x.abs() > 0.9999 && list[0].kind == SymmetryKind::Mirror);
    }
    for name in ["stanford-bunny.obj", "rocker-arm.obj"] {
        let Some(surface) = Surface::shared(name) else { continue };
        assert_eq!(found(&surface), [], "{name}");
    }
}

#[test]
fn a_tennis_ball_has_two_planes_and_three_half_turns() {
    let ball = Surface::sample("tennis_ball");
    let list = found(&ball);
    assert_eq!((mirrors(&list).len(), axes(&list, 2), list.len()), (2, 3, 5));
    let group = symmetry_group(&ball.mesh, &ball.geometry, &list, 120).unwrap();
    assert_eq!(group.len() + 1, 8);
}

#[test]
fn a_ring_has_a_short_list_with_its_axis() {
    let list = found(&Surface::sample("torus"));
    assert!(list.len() < 12, "{list:?}");
    let is_upright = |s: &&Symmetry| s.direction.y.abs() > 0.9999;
    // The plane of the ring and its axis.
    assert_eq!(list.iter().filter(is_upright).count(), 2, "{list:?}");
    assert!(mirrors(&list).len() >= 3);
}

#[test]
fn a_plane_is_found_without_symmetric_triangles() {
    let surface = lopsided(24);
    let list = found(&surface);
    assert_eq!(list.len(), 1, "{list:?}");
    assert_eq!(list[0].kind, SymmetryKind::Mirror);
    // Chords of triangles of edge h = 0.02 of the diameter miss the surface by h²/8, the plane turns by about that.
    assert!(list[0].direction.x.abs() > 1.0 - 1e-5 && list[0].deviation < 2e-3, "{list:?}");
    let group = symmetry_group(&surface.mesh, &surface.geometry, &list, 120).unwrap();
    let [map] = &group[..] else { panic!("a mirror and the identity") };
    assert!(!map.is_exact());
    let values: Vec<f64> = surface.geometry.positions.iter().map(odd).collect();
    let average: Vec<f64> =
        surface.mesh.vertices().map(|v| 0.5 * (values[v.index()] + map.pull(&values, v))).collect();
    let gap = |f: &[f64]| {
        surface.mesh.vertices().fold(0.0f64, |m, v| m.max((map.pull(f, v) - f[v.index()]).abs()))
    };
    // Interpolation is off by h² |f″| / 8, about 1e-3 here.
    assert!(gap(&average) < 5e-3 && gap(&values) > 0.5, "{} {}", gap(&average), gap(&values));
}

#[test]
fn scale_and_place_do_not_matter_and_repeats_give_the_same_bits() {
    let surface = lopsided(20);
    let list = found(&surface);
    assert_eq!(list, found(&surface));
    let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.0);
    for scale in [1e-3, 1e4] {
        let moved: Vec<Point3<f64>> = surface
            .geometry
            .positions
            .iter()
            .map(|p| Point3::from((turn * p).coords * scale + Vector3::new(3.0, -1.0, 2.0) * scale))
            .collect();
        let geometry = Geometry::new(&surface.mesh, moved).unwrap();
        let again = find_symmetries(&surface.mesh, &geometry, TOLERANCE);
        assert_eq!(list.len(), again.len());
        for (a, b) in list.iter().zip(&again) {
            // Scans run in another frame, and the worst tenth that does not vote may be another one: the fit wanders by
            // a small part of the deviation of the triangles, 1e-3 here.
            let (cosine, change) =
                ((turn * a.direction).dot(&b.direction), a.deviation - b.deviation);
            assert!(cosine.abs() > 1.0 - 1e-6 && change.abs() < 3e-4, "{cosine} {change}");
        }
    }
}

#[test]
fn planes_that_do_not_meet_or_generate_too_much_are_refused() {
    let sphere = Surface::sphere(4);
    let at = |point: Point3<f64>, angle: f64| Symmetry {
        kind: SymmetryKind::Mirror,
        point,
        direction: Vector3::new(angle.cos(), angle.sin(), 0.0),
        deviation: 0.0,
    };
    let make = |list: &[Symmetry]| {
        symmetry_group(&sphere.mesh, &sphere.geometry, list, 60).map(|group| group.len())
    };
    let apart = make(&[at(Point3::origin(), 0.0), at(Point3::new(0.2, 0.0, 0.0), 0.0)]);
    assert!(matches!(apart, Err(SymmetryError::NoCentre { .. })));
    // The golden section of a half turn: its multiples return to within 4° after 55 turns only.
    let skew = make(&[at(Point3::origin(), 0.0), at(Point3::origin(), 1.941_611_038_725_466)]);
    assert_eq!(skew.unwrap_err(), SymmetryError::TooLarge { most: 60 });
    assert_eq!(make(&[]).unwrap_err(), SymmetryError::None);
    let mut bad = at(Point3::origin(), 0.0);
    bad.direction *= 2.0;
    assert_eq!(make(&[bad]).unwrap_err(), SymmetryError::Malformed { generator: 0 });
}

#[test]
fn the_tree_finds_what_a_search_through_all_faces_finds() {
    let Surface { mesh, geometry, .. } = Surface::sample("torus");
    let tree = Nearest::new(&mesh, &geometry.positions);
    let places = |f: FaceId| mesh.face_vertices(f).map(|v| geometry.positions[v.index()]);
    for i in 0..40 {
        let t = f64::from(i);
        let p = Point3::new((t * 1.3).sin(), (t * 0.7).cos(), (t * 2.1).sin()) * 0.4;
        let all = mesh.faces().map(|f| {
            let (_, q) = cutflow::geometry::closest(&places(f), p);
            (q - p).norm_squared()
        });
        let least = all.fold(f64::INFINITY, f64::min);
        assert_eq!(tree.find(p).unwrap().squared, least);
        let d = Vector3::new((t * 3.3).cos(), (t * 1.9).sin(), (t * 0.3).cos());
        // By signed volumes, the other way to the same answer; generic rays meet no edge.
        let is_met = mesh.faces().any(|f| {
            let [a, b, c] = places(f).map(|q| q - p);
            let s = [d.dot(&a.cross(&b)), d.dot(&b.cross(&c)), d.dot(&c.cross(&a))];
            let inside = s.iter().all(|x| *x > 0.0) || s.iter().all(|x| *x < 0.0);
            let n = (b - a).cross(&(c - a));
            inside && n.dot(&a) / n.dot(&d) > 0.0
        });
        assert_eq!(tree.is_hit(p, d, 0.0, f64::INFINITY, |_| false), is_met, "ray {i}");
    }
}

#[test]
fn a_ball_shows_the_cap_in_front_and_the_cosine_there() {
    let sphere = Surface::sphere(16);
    let radius = sphere.geometry.positions[0].coords.norm();
    let eye = Point3::new(0.3, 0.5, 1.0) * (4.0 * radius);
    let values = visibility(&sphere.mesh, &sphere.geometry, eye);
    for v in sphere.mesh.vertices() {
        let p = sphere.geometry.positions[v.index()];
        let cosine = p.coords.normalize().dot(&(eye - p).normalize());
        let value = values[v.index()];
        assert!((0.0..=1.0).contains(&value));
        // The smoothing reaches two or three widths of two edges (0.07 radius each), 8 half widths of decay to 1e-3.
        if cosine > 0.6 {
            assert!((value - cosine).abs() < 0.02, "{value} instead of {cosine}");
        }
        assert!(value <= cosine.max(0.0) + 1e-2);
    }
}

/// Copies of a ball of radius 1 at several places.
fn balls(centres: &[[f64; 3]], scales: &[f64]) -> Surface {
    let ball = cutflow::session::samples::icosphere(12);
    let count = ball.positions.len() as u32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (i, (c, s)) in centres.iter().zip(scales).enumerate() {
        positions.extend(ball.positions.iter().map(|p| [0, 1, 2].map(|k| p[k] * s + c[k])));
        triangles.extend(
            ball.corners.chunks(3).map(|t| [t[0], t[1], t[2]].map(|v| v + count * i as u32)),
        );
    }
    Surface::from_soup("balls", &Soup::from_triangles(positions, &triangles))
}

#[test]
fn one_ball_hides_the_other() {
    let pair = balls(&[[0.0, 0.0, 0.0], [0.0, 0.0, 4.0]], &[1.0, 1.5]);
    // Centre and scale of the unit-area copy come from the vertices.
    let half = pair.mesh.vertex_count() / 2;
    let z = |v: usize| pair.geometry.positions[v].z;
    let (low, high) =
        (0..2 * half).fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(z(v)), b.max(z(v))));
    let values =
        visibility(&pair.mesh, &pair.geometry, Point3::new(0.0, 0.0, high + 3.0 * (high - low)));
    let sum = |side: bool| -> f64 {
        (0..2 * half)
            .filter(|&v| (z(v) > 0.5 * (low + high) - 0.05 * (high - low)) == side)
            .map(|v| values[v])
            .sum()
    };
    assert!(sum(true) > 100.0);
    // Nothing of the small ball is seen from straight behind the large one.
    assert!(sum(false) < 1e-3, "{}", sum(false));
}

#[test]
fn a_ring_is_seen_through_its_hole_and_a_sheet_from_behind() {
    let ring = Surface::sample("torus");
    let reach = ring.geometry.positions.iter().fold(0.0f64, |m, p| m.max(p.coords.norm()));
    let eye = Point3::new(0.0, 3.0 * reach, 0.0);
    let values = visibility(&ring.mesh, &ring.geometry, eye);
    let normals = ring.geometry.vertex_normals(&ring.mesh);
    for v in ring.mesh.vertices() {
        let p = ring.geometry.positions[v.index()];
        let cosine = normals[v.index()].dot(&(eye - p).normalize());
        // Away from the horizon all that looks up is seen, the slope into the hole too, and nothing else.
        if cosine > 0.4 {
            assert!((values[v.index()] - cosine).abs() < 0.03);
        }
        if cosine < -0.2 {
            assert!(values[v.index()] <= 0.0);
        }
    }
    // From far behind along the ring's plane, the far inner wall is hidden by the near part.
    let side = visibility(&ring.mesh, &ring.geometry, Point3::new(20.0 * reach, 0.0, 0.0));
    let inner = ring.mesh.vertices().filter(|v| {
        let p = ring.geometry.positions[v.index()];
        p.x < -0.2 * reach
            && p.y.abs() < 0.05 * reach
            && p.z.abs() < 0.1 * reach
            && p.x > -0.6 * reach
    });
    for v in inner {
        assert!(side[v.index()] < 1e-2);
    }
    let sheet = Mesh::new(4, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let geometry = Geometry::new(&sheet, corners.map(Point3::from).to_vec()).unwrap();
    for z in [10.0, -10.0] {
        let values = visibility(&sheet, &geometry, Point3::new(0.5, 0.5, z));
        // 10 / √(10² + ½) at all corners.
        assert!(values.iter().all(|x| (x - 10.0 / 100.5f64.sqrt()).abs() < 1e-12));
    }
}
