//! Atlases of overlapping charts: weights that add up, disks, charts that agree where they overlap.

use std::collections::BTreeMap;

use cutflow::flatten::atlas::{Atlas, AtlasError, AtlasMethod, AtlasNotice, AtlasParams};
use cutflow::flatten::largest_weights;
use cutflow::geometry::Geometry;
use cutflow::mesh::{FaceId, Mesh, VertexId};
use nalgebra::{Point2, Rotation2, Vector3};

use super::surfaces::{Surface, cylinder, grid};

/// A partition of unity by squared amounts above 0, divided by their sum.
fn partition(geometry: &Geometry, amounts: &[&dyn Fn(Vector3<f64>) -> f64]) -> Vec<Vec<f64>> {
    let places = || geometry.positions.iter().map(|p| p.coords);
    let sums: Vec<f64> =
        places().map(|p| amounts.iter().map(|a| a(p).max(0.0).powi(2)).sum()).collect();
    let array = |a: &&dyn Fn(Vector3<f64>) -> f64| {
        places().zip(&sums).map(|(p, sum)| a(p).max(0.0).powi(2) / sum).collect()
    };
    amounts.iter().map(array).collect()
}

/// Caps of a sphere about directions, up to an angle given by its cosine.
fn caps(geometry: &Geometry, directions: &[[f64; 3]], cosine: f64) -> Vec<Vec<f64>> {
    let caps: Vec<Box<dyn Fn(Vector3<f64>) -> f64>> = directions
        .iter()
        .map(|&d| -> Box<dyn Fn(Vector3<f64>) -> f64> {
            let d = Vector3::from(d).normalize();
            Box::new(move |p| p.normalize().dot(&d) - cosine)
        })
        .collect();
    let refs: Vec<&dyn Fn(Vector3<f64>) -> f64> = caps.iter().map(AsRef::as_ref).collect();
    partition(geometry, &refs)
}

/// Poles, corners of a tetrahedron, corners of a cube, with caps wide enough to cover the sphere.
fn patches_of_a_sphere(geometry: &Geometry, count: usize) -> Vec<Vec<f64>> {
    let cube: Vec<[f64; 3]> =
        (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
    match count {
        2 => caps(geometry, &[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], -0.3),
        4 => caps(geometry, &[cube[0], cube[3], cube[5], cube[6]], -0.05),
        _ => caps(geometry, &cube, 0.3),
    }
}

fn atlas(surface: &Surface, weights: &[Vec<f64>]) -> Atlas {
    let params = AtlasParams::default();
    Atlas::new(&surface.mesh, &surface.geometry, weights, &params).unwrap()
}

/// What holds for every atlas: weights of each corner of each face add up to 1, charts are disks and repeat the faces of the surface.
fn check(mesh: &Mesh, atlas: &Atlas) {
    let mut sums = vec![[0.0; 3]; mesh.face_count()];
    for chart in &atlas.charts {
        assert_eq!(chart.faces.len(), chart.triangles.len());
        assert!(chart.weights.iter().all(|&w| (0.0..=1.0).contains(&w)));
        for (f, t) in chart.faces.iter().zip(&chart.triangles) {
            assert_eq!(t.map(|v| chart.vertices[v as usize]), mesh.face_vertices(*f));
            for (sum, v) in sums[f.index()].iter_mut().zip(t) {
                *sum += chart.weights[*v as usize];
            }
        }
    }
    for sum in sums.into_iter().flatten() {
        assert!((sum - 1.0).abs() <= 1e-14, "weights add up to {sum}");
    }
    assert!(atlas.opened.patch_shapes().iter().all(|&shape| shape == (1, 1)), "disks");
    assert_eq!(atlas.opened.patch_count, atlas.charts.len());
    let share: f64 = atlas.charts.iter().map(|chart| chart.share).sum();
    // What was too small to be seen is not counted: a few weights of up to 0.002 at each place.
    assert!((share - 1.0).abs() < 0.01, "shares add up to {share}");
}

/// E and Σ a of the doc comment, from what the atlas gives.
fn energy(geometry: &Geometry, atlas: &Atlas) -> (f64, f64) {
    type Weighted = [(Point2<f64>, f64); 3];
    let mut corners: BTreeMap<FaceId, Vec<Weighted>> = BTreeMap::new();
    for chart in &atlas.charts {
        for (f, t) in chart.faces.iter().zip(&chart.triangles) {
            let corner = |v: u32| (chart.uv[v as usize], chart.weights[v as usize]);
            corners.entry(*f).or_default().push(t.map(corner));
        }
    }
    let (mut sum, mut weight) = (0.0, 0.0);
    for (f, charts) in corners {
        for (i, first) in charts.iter().enumerate() {
            for (a, b) in charts[i + 1..].iter().flat_map(|second| first.iter().zip(second)) {
                let w = geometry.face_areas[f.index()] / 3.0 * a.1 * b.1;
                sum += w * (a.0 - b.0).norm_squared();
                weight += w;
            }
        }
    }
    (sum, weight)
}

#[test]
fn smooth_patches_of_a_sphere_become_valid_charts_whose_weights_add_up() {
    let surface = Surface::sphere(16);
    for count in [2, 4, 8] {
        let weights = patches_of_a_sphere(&surface.geometry, count);
        let atlas = atlas(&surface, &weights);
        check(&surface.mesh, &atlas);
        assert_eq!(atlas.charts.len(), count);
        assert_eq!(atlas.notices, []);
        for chart in &atlas.charts {
            let measures = chart.measures.as_ref().unwrap();
            assert!(chart.validity.unwrap().is_valid(), "{count}: {:?}", chart.validity);
            // Rims run along edges of the mesh in zigzag; triangles there shear, all others are conformal.
            assert!(measures.angle_distortion < 1.05, "{count}: {}", measures.angle_distortion);
            // The given weights are kept up to what nobody sees.
            for (v, w) in chart.vertices.iter().zip(&chart.weights) {
                assert!((w - weights[chart.source][v.index()]).abs() <= 0.01);
            }
        }
    }
}

#[test]
fn charts_of_a_plane_become_one_map() {
    let (points, triangles, _) = grid([24, 18], false, |x, y| [2.0 * x, 1.5 * y, 0.0]);
    let mesh = Mesh::new(points.len(), &triangles).unwrap();
    let geometry = Geometry::new(&mesh, points).unwrap();
    let centres = [0, 7, 212, 330, 474].map(|v: usize| geometry.positions[v].coords);
    let amounts: Vec<_> =
        centres.iter().map(|c| move |p: Vector3<f64>| 1.4 - (p - c).norm()).collect();
    let refs: Vec<&dyn Fn(Vector3<f64>) -> f64> = amounts.iter().map(|a| a as _).collect();
    let weights = partition(&geometry, &refs);
    for method in [AtlasMethod::Bff, AtlasMethod::Lscm] {
        let params = AtlasParams { method, ..AtlasParams::default() };
        let atlas = Atlas::new(&mesh, &geometry, &weights, &params).unwrap();
        check(&mesh, &atlas);
        assert_eq!(atlas.charts.len(), 5);
        // Isometric charts have one frame in common: what is left is rounding of the solvers, and lengths are about 1.
        assert!(atlas.misfit < 1e-9, "{method:?}: {}", atlas.misfit);
        let mut places = vec![None; mesh.vertex_count()];
        for chart in &atlas.charts {
            for (v, &p) in chart.vertices.iter().zip(&chart.uv) {
                let first = *places[v.index()].get_or_insert(p);
                assert!((first - p).norm() < 1e-8, "{method:?}: {first} and {p}");
            }
        }
        let first = places[0].unwrap();
        let p = places[474].unwrap();
        // The diagonal of the rectangle.
        assert!(((p - first).norm() - 2.5).abs() < 1e-8);
    }
}

#[test]
fn no_chart_agrees_better_with_the_others_when_it_is_turned_or_shifted() {
    let surface = Surface::sphere(12);
    let geometry = &surface.geometry;
    let atlas = atlas(&surface, &patches_of_a_sphere(geometry, 8));
    let (least, weight) = energy(geometry, &atlas);
    assert!((atlas.misfit - (least / weight).sqrt()).abs() < 1e-9, "{} {least}", atlas.misfit);
    // Three charts meet at a cap of π / 2 of curvature: they cannot agree, but by less than their own size.
    assert!(atlas.misfit > 1e-3 && atlas.misfit < 0.3, "{}", atlas.misfit);
    for chart in 0..8 {
        for (angle, shift) in
            [(0.02, [0.0; 2]), (-0.02, [0.0; 2]), (0.0, [0.01, 0.0]), (0.0, [0.0, -0.01])]
        {
            let mut moved = atlas.clone();
            for p in &mut moved.charts[chart].uv {
                *p = Rotation2::new(angle) * *p + nalgebra::Vector2::from(shift);
            }
            // The rounds end where E falls by less than a millionth of itself.
            assert!(energy(geometry, &moved).0 > least * (1.0 - 1e-5), "chart {chart}");
        }
    }
}

#[test]
fn charts_that_wrap_around_are_cut_open() {
    let tube = Surface::from_soup("cylinder", &cylinder(32, 20));
    let height = tube.geometry.positions.iter().map(|p| p.z).fold(0.0, f64::max);
    let [low, high]: [&dyn Fn(Vector3<f64>) -> f64; 2] =
        [&|p| 0.3 * height - p.z, &|p| 0.3 * height + p.z];
    let tube_atlas = atlas(&tube, &partition(&tube.geometry, &[low, high]));
    check(&tube.mesh, &tube_atlas);
    assert_eq!(tube_atlas.charts.len(), 2);
    for (i, notice) in tube_atlas.notices.iter().enumerate() {
        let &AtlasNotice::CutOpen { chart, length } = notice else { panic!("{notice:?}") };
        assert_eq!(chart, i);
        // From the rim of the tube to the far end of the domain, 0.65 of the tube's height, along edges in zigzag at 45°.
        let whole = 2.0 * height;
        assert!(length > 0.6 * whole && length < 1.0 * whole, "{length} of {whole}");
    }
    assert_eq!(tube_atlas.notices.len(), 2);
    for chart in &tube_atlas.charts {
        // A tube is developable.
        assert!(chart.validity.unwrap().is_valid());
        let measures = chart.measures.as_ref().unwrap();
        assert!(measures.symmetric_dirichlet < 1.0 + 1e-9, "{}", measures.symmetric_dirichlet);
    }

    let torus = Surface::sample("torus");
    let around = |turn: f64| {
        move |p: Vector3<f64>| {
            let longest = |axis: usize| torus_axis(p, axis);
            (longest(0).atan2(longest(1)) - turn).cos() + 0.2
        }
    };
    let third = std::f64::consts::TAU / 3.0;
    let [a, b, c] = [around(0.0), around(third), around(2.0 * third)];
    let torus_atlas = atlas(&torus, &partition(&torus.geometry, &[&a, &b, &c]));
    check(&torus.mesh, &torus_atlas);
    let cut = |n: &&AtlasNotice| matches!(n, AtlasNotice::CutOpen { .. });
    assert_eq!(torus_atlas.notices.iter().filter(cut).count(), 3, "{:?}", torus_atlas.notices);
    assert_eq!(torus_atlas.charts.len(), 3);
    for chart in &torus_atlas.charts {
        assert_eq!(chart.measures.as_ref().unwrap().flipped, 0);
    }

    // One chart for all of it: the handle is cut as well.
    let whole = atlas(&torus, &[vec![1.0; torus.mesh.vertex_count()]]);
    check(&torus.mesh, &whole);
    assert_eq!((whole.charts.len(), whole.misfit), (1, 0.0));
}

/// A coordinate across the axis of the sample torus, which is y.
fn torus_axis(p: Vector3<f64>, axis: usize) -> f64 {
    if axis == 0 { p.x } else { p.z }
}

#[test]
fn weights_that_vanish_come_apart_or_are_specks_are_told_and_the_rest_makes_up_for_them() {
    let surface = Surface::sphere(12);
    let count = surface.mesh.vertex_count();
    let mut weights = patches_of_a_sphere(&surface.geometry, 4);
    // Nothing, and next to nothing.
    weights.push(vec![0.0; count]);
    weights.push(vec![1e-3; count]);
    for v in 0..count {
        let rest: f64 = weights[..4].iter().map(|array| array[v]).sum();
        weights[..4].iter_mut().for_each(|array| array[v] *= (1.0 - 1e-3) / rest);
    }
    let four = atlas(&surface, &weights);
    check(&surface.mesh, &four);
    assert_eq!(four.charts.len(), 4);
    assert_eq!(four.notices, [4, 5].map(|source| AtlasNotice::Vanished { source }));

    // Two caps in one array, and a speck of the other array on one of them.
    let mut two = patches_of_a_sphere(&surface.geometry, 2);
    let belt: Vec<f64> = surface
        .geometry
        .positions
        .iter()
        .map(|p| {
            let z = p.coords.normalize().z;
            (1.5 - 3.0 * z * z).clamp(0.0, 1.0)
        })
        .collect();
    let top = (0..count).max_by(|&a, &b| {
        let z = |v: usize| surface.geometry.positions[v].z;
        z(a).total_cmp(&z(b))
    });
    two[0] = belt.iter().map(|w| 1.0 - w).collect();
    two[1] = belt;
    two[0][top.unwrap()] = 0.6;
    two[1][top.unwrap()] = 0.4;
    let three = atlas(&surface, &two);
    check(&surface.mesh, &three);
    assert_eq!(three.charts.iter().map(|c| c.source).collect::<Vec<_>>(), [0, 0, 1]);
    assert!(three.notices.contains(&AtlasNotice::Parted { source: 0, charts: 2 }));
    let is_speck = |n: &AtlasNotice| matches!(n, AtlasNotice::GaveUp { source: 1, components: 1, share } if *share < 1e-3);
    assert!(three.notices.iter().any(is_speck), "{:?}", three.notices);

    // A speck that nothing else covers stays.
    two[0][top.unwrap()] = 0.0;
    two[1][top.unwrap()] = 1.0;
    let four = atlas(&surface, &two);
    check(&surface.mesh, &four);
    assert_eq!(four.charts.iter().map(|c| c.source).collect::<Vec<_>>(), [0, 0, 1, 1]);
}

#[test]
fn the_same_weights_give_the_same_bits_and_larger_surfaces_larger_charts() {
    let surface = Surface::sphere(8);
    let weights = patches_of_a_sphere(&surface.geometry, 4);
    let [one, other] = [(); 2].map(|()| atlas(&surface, &weights));
    let large = Geometry::new(
        &surface.mesh,
        surface.geometry.positions.iter().map(|p| p * 1024.0).collect(),
    )
    .unwrap();
    let large = Atlas::new(&surface.mesh, &large, &weights, &AtlasParams::default()).unwrap();
    for ((a, b), c) in one.charts.iter().zip(&other.charts).zip(&large.charts) {
        assert_eq!((&a.uv, &a.weights), (&b.uv, &b.weights));
        for (p, q) in a.uv.iter().zip(&c.uv) {
            // Powers of two commute with rounding but for thresholds; a thousandth of a millionth of a chart is rounding.
            assert!((p.coords * 1024.0 - q.coords).norm() < 1e-6, "{p} {q}");
        }
    }
}

#[test]
fn what_is_no_partition_of_unity_is_refused_with_its_place() {
    let surface = Surface::sphere(3);
    let (mesh, geometry) = (&surface.mesh, &surface.geometry);
    let count = mesh.vertex_count();
    let make = |weights: &[Vec<f64>]| {
        Atlas::new(mesh, geometry, weights, &AtlasParams::default()).map(|_| ()).unwrap_err()
    };
    let none = AtlasError::Length { chart: 0, found: 0, expected: count };
    assert_eq!(make(&[]), none);
    let short = AtlasError::Length { chart: 1, found: 5, expected: count };
    assert_eq!(make(&[vec![1.0; count], vec![0.0; 5]]), short);
    let vertex = VertexId(7);
    for weight in [-0.25, f64::INFINITY] {
        let mut weights = [vec![1.0; count], vec![0.0; count]];
        weights[1][7] = weight;
        assert_eq!(make(&weights), AtlasError::Weight { chart: 1, vertex, weight });
    }
    let mut weights = [vec![0.5; count], vec![0.5; count]];
    weights[1][7] = 0.25;
    assert_eq!(make(&weights), AtlasError::NoPartition { vertex, sum: 0.75 });
    weights[1][7] = f64::NAN;
    assert!(matches!(make(&weights), AtlasError::Weight { chart: 1, .. }));
    let params = AtlasParams { least_weight: 0.5, ..AtlasParams::default() };
    let refused = Atlas::new(mesh, geometry, &weights, &params).map(|_| ()).unwrap_err();
    assert_eq!(refused, AtlasError::Parameter { name: "least_weight", value: 0.5 });
}

#[test]
fn the_largest_weight_names_the_chart_and_the_first_of_equal_ones_wins() {
    let weights = [vec![0.5, 0.2, 0.3], vec![0.5, 0.5, 0.3], vec![0.0, 0.3, 0.4]];
    assert_eq!(largest_weights(&weights, 3), [0, 1, 2]);
}
