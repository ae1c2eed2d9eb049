//! Identities of the geometry floor over the zoo.

use std::f64::consts::{PI, TAU};

use cutflow::geometry::{
    Geometry, GeometryError, Laplacian, angle_defects, face_curvatures, geodesic_distances,
};
use cutflow::mesh::{FaceId, Mesh, VertexId};
use nalgebra::Point3;

use crate::surfaces::{Surface, cube, tetrahedron};

#[test]
fn curvature_sums_to_the_euler_characteristic() {
    for Surface { name, mesh, geometry } in Surface::zoo() {
        let expected = TAU * mesh.topology().euler as f64;
        let sum: f64 = angle_defects(&mesh, &geometry).iter().sum();
        // Rounding of up to 60 000 angles.
        assert!((sum - expected).abs() < 1e-8, "{name}: {sum} instead of {expected}");
        if mesh.boundary_loops().is_empty() {
            let curvatures = face_curvatures(&mesh, &geometry);
            let sum: f64 = curvatures.iter().zip(&geometry.face_areas).map(|(k, a)| k * a).sum();
            assert!((sum - expected).abs() < 1e-8, "{name}: faces give {sum}");
        }
    }
}

#[test]
fn the_laplacian_knows_constants_areas_and_symmetry() {
    for Surface { name, mesh, geometry } in Surface::zoo() {
        let l = Laplacian::new(&mesh, &geometry);
        let n = mesh.vertex_count();
        let mut product = vec![0.0; n];
        l.pattern.multiply(&l.values, &vec![1.0; n], &mut product);
        let largest = product.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(largest < 1e-11, "{name}: L 1 = {largest}");
        // Σ over coordinates of ∫|∇x|² is twice the area: one of the ways to an area.
        let mut twice = 0.0;
        for axis in 0..3 {
            let x: Vec<f64> = geometry.positions.iter().map(|p| p[axis]).collect();
            l.pattern.multiply(&l.values, &x, &mut product);
            twice += x.iter().zip(&product).map(|(a, b)| a * b).sum::<f64>();
        }
        assert!((twice - 2.0).abs() < 1e-10, "{name}: {twice}");
        let dual: f64 = geometry.vertex_dual_areas(&mesh).iter().sum();
        assert!((dual - 1.0).abs() < 1e-12 && (geometry.total_area() - 1.0).abs() < 1e-12);
        let cross: f64 = mesh
            .triangles()
            .iter()
            .map(|&t| {
                let [a, b, c] = t.map(|v| geometry.positions[v.index()]);
                (b - a).cross(&(c - a)).norm() / 2.0
            })
            .sum();
        assert!((cross - 1.0).abs() < 1e-12, "{name}: {cross}");
    }
}

#[test]
fn regular_solids_have_their_textbook_angles() {
    let solid = Surface::from_soup("tetrahedron", &tetrahedron());
    for defect in angle_defects(&solid.mesh, &solid.geometry) {
        assert!((defect - PI).abs() < 1e-14);
    }
    let solid = Surface::from_soup("cube", &cube());
    for defect in angle_defects(&solid.mesh, &solid.geometry) {
        assert!((defect - PI / 2.0).abs() < 1e-14);
    }
    assert_eq!((solid.mesh.edge_count(), solid.mesh.face_count()), (18, 12));
}

#[test]
fn measures_do_not_depend_on_place_size_or_numbering() {
    let base = Surface::sphere(6);
    let soup = cutflow::session::samples::icosphere(6);
    let triangles: Vec<[u32; 3]> =
        (0..soup.polygon_count()).map(|i| [0, 1, 2].map(|k| soup.polygon(i)[k])).collect();
    let n = soup.positions.len() as u32;
    // 5 has no factor in common with 362: a permutation.
    let renumbered = |v: u32| (5 * v + 17) % n;
    let mut positions = vec![[0.0; 3]; n as usize];
    for (v, p) in soup.positions.iter().enumerate() {
        positions[renumbered(v as u32) as usize] = *p;
    }
    let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(renumbered)).collect();
    let mesh = Mesh::new(n as usize, &triangles).unwrap();
    // Far away, a double has fewer digits left for the shape.
    for (scale, offset, tolerance) in
        [(1e-6, 0.0, 1e-13), (1.0, 3.0, 1e-13), (1e6, -1e6, 1e-13), (1.0, 1e6, 1e-8)]
    {
        let moved: Vec<[f64; 3]> =
            positions.iter().map(|p| [p[1], p[2], p[0]].map(|x| x * scale + offset)).collect();
        let (geometry, _) = Geometry::unit_area(&mesh, &moved).unwrap();
        for f in base.mesh.faces() {
            let (a, b) =
                (base.geometry.corner_angles[f.index()], geometry.corner_angles[f.index()]);
            for k in 0..3 {
                assert!((a[k] - b[k]).abs() < tolerance, "scale {scale}, offset {offset}");
            }
        }
        let mean = base.geometry.mean_edge_length();
        assert!((geometry.mean_edge_length() - mean).abs() < tolerance * mean);
    }
}

#[test]
fn defects_of_the_metric_are_named() {
    let mesh = Mesh::new(4, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let point = |x: f64, y: f64| Point3::new(x, y, 0.0);
    let good = [point(0.0, 0.0), point(1.0, 0.0), point(1.0, 1.0), point(0.0, 1.0)];
    let with = |v: usize, p: Point3<f64>| {
        let mut positions = good.to_vec();
        positions[v] = p;
        Geometry::new(&mesh, positions)
    };
    assert!(with(0, good[0]).is_ok());
    let bad = with(1, point(f64::NAN, 0.0)).unwrap_err();
    assert_eq!(bad, GeometryError::NotFinite { vertices: vec![VertexId(1)] });
    let bad = with(1, point(0.5, 0.5)).unwrap_err();
    assert!(matches!(bad, GeometryError::DegenerateFaces { faces } if faces.len() == 1));
    // Corners on a slanted line: only rounding keeps them from having no height.
    let single = Mesh::new(3, &[[0, 1, 2]]).unwrap();
    for i in 1..200 {
        let t = f64::from(i) / 200.0;
        let (a, b) = (Point3::new(0.1, -0.37, 0.73), Point3::new(0.9, 0.11 * t, -0.3));
        let error = Geometry::new(&single, vec![a, b, a + (b - a) * t]).unwrap_err();
        assert_eq!(error, GeometryError::DegenerateFaces { faces: vec![FaceId(0)] });
    }
    let all = vec![point(2.0, 3.0); 4];
    assert_eq!(Geometry::new(&mesh, all).unwrap_err(), GeometryError::NoExtent);
}

#[test]
fn geodesic_distance_on_the_sphere_converges() {
    let error = |n: u32| {
        let Surface { mesh, geometry, .. } = Surface::sphere(n);
        let radius = 1.0 / (2.0 * PI.sqrt());
        let pole = geometry.positions[0].coords.normalize();
        let distances = geodesic_distances(&mesh, &geometry, &[VertexId(0)]);
        let errors = geometry.positions.iter().zip(distances).map(|(p, d)| {
            let exact = radius * p.coords.normalize().dot(&pole).clamp(-1.0, 1.0).acos();
            (d - exact).abs()
        });
        errors.fold(0.0, f64::max) / (PI * radius)
    };
    let (coarse, fine) = (error(8), error(32));
    // First order with a logarithm: a quarter of the edge, well under half the error.
    assert!(fine < 0.01 && fine < 0.5 * coarse, "{coarse} {fine}");
}
