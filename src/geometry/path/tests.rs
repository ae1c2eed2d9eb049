//! Ways against what is known of them: straight lines, corners, nets of a cube, great circles.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "faces are chosen by fractions of their number"
)]

use super::*;
use nalgebra::Vector3;

/// A flat grid of `n` squares a side, without those that `is_hole` takes; diagonals turn from square to square.
fn grid(n: usize, is_hole: impl Fn(usize, usize) -> bool) -> (Mesh, Geometry) {
    let row = n + 1;
    let points: Vec<Point3<f64>> = (0..row * row)
        .map(|i| Point3::new((i % row) as f64 / n as f64, (i / row) as f64 / n as f64, 0.0))
        .collect();
    let mut triangles = Vec::new();
    for (x, y) in (0..n * n).map(|i| (i % n, i / n)).filter(|&(x, y)| !is_hole(x, y)) {
        let at = |dx, dy| u32::try_from((y + dy) * row + x + dx).expect("a small grid");
        let [a, b, c, d] = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
        if (x + y) % 2 == 0 {
            triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            triangles.extend([[a, b, d], [b, c, d]]);
        }
    }
    measured(points, &triangles)
}

fn measured(points: Vec<Point3<f64>>, triangles: &[[u32; 3]]) -> (Mesh, Geometry) {
    let mesh = Mesh::new(points.len(), triangles).expect("a manifold");
    let geometry = Geometry::new(&mesh, points).expect("triangles with area");
    (mesh, geometry)
}

/// A ball of radius 1 from an octahedron, each face divided `n` times into four.
fn ball(n: u32) -> (Mesh, Geometry) {
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut triangles = vec![[x, y, z], [y, -x, z], [-x, -y, z], [-y, x, z]];
    triangles.extend([[y, x, -z], [-x, y, -z], [-y, -x, -z], [x, -y, -z]]);
    for _ in 0..n {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]: [Vector3<f64>; 3]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(|v| v.normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let mut points: Vec<Point3<f64>> = Vec::new();
    let mut index = |v: Vector3<f64>| {
        let at = points.iter().position(|p| (p.coords - v).norm() < 1e-9).unwrap_or_else(|| {
            points.push(v.into());
            points.len() - 1
        });
        u32::try_from(at).expect("a small ball")
    };
    let triangles: Vec<[u32; 3]> = triangles.into_iter().map(|t| t.map(&mut index)).collect();
    measured(points, &triangles)
}

/// Pairs of points, spread over the faces by a rule.
fn pairs(mesh: &Mesh, count: usize) -> Vec<[(FaceId, [f64; 3]); 2]> {
    let fraction = |i: usize, step: f64| (i as f64 * step).fract();
    let point = |i: usize| {
        let face = (fraction(i, 0.618_033_988_7) * mesh.face_count() as f64) as usize;
        let (u, v) = (fraction(i, 0.754_877_666), fraction(i, 0.569_840_291));
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        (FaceId::from(face.min(mesh.face_count() - 1)), [1.0 - u - v, u, v])
    };
    (0..count).map(|i| [point(2 * i + 1), point(2 * i + 2)]).collect()
}

fn place(mesh: &Mesh, geometry: &Geometry, (face, weights): (FaceId, [f64; 3])) -> Point3<f64> {
    End::new(mesh, geometry, face, weights).place
}

/// The length of the chain through the points.
fn chain(path: &SurfacePath) -> f64 {
    path.points.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

#[test]
fn on_a_flat_convex_surface_the_way_is_the_straight_line() {
    let (mesh, geometry) = grid(9, |_, _| false);
    for [from, to] in pairs(&mesh, 60) {
        let path = shortest_path(&mesh, &geometry, from, to).expect("one surface");
        let [a, b] = [from, to].map(|end| place(&mesh, &geometry, end));
        assert!((path.length - (b - a).norm()).abs() < 1e-9, "{from:?} {to:?}");
        assert!((chain(&path) - path.length).abs() < 1e-9);
        assert_eq!((path.points[0], *path.points.last().expect("points")), (a, b));
    }
}

#[test]
fn around_a_corner_the_way_bends_at_the_corner() {
    // The upper right quarter is missing.
    let (mesh, geometry) = grid(8, |x, y| x >= 4 && y >= 4);
    let corner = Point3::new(0.5, 0.5, 0.0);
    let mut bent = 0;
    for [from, to] in pairs(&mesh, 80) {
        let path = shortest_path(&mesh, &geometry, from, to).expect("one surface");
        let [a, b] = [from, to].map(|end| place(&mesh, &geometry, end));
        let (left, right) = if a.x < b.x { (a, b) } else { (b, a) };
        let is_hidden =
            left.y > 0.5 && right.x > 0.5 && (right - left).perp_xy(&(corner - left)) < 0.0;
        bent += usize::from(is_hidden);
        let expected =
            if is_hidden { (corner - a).norm() + (b - corner).norm() } else { (b - a).norm() };
        assert!(
            (path.length - expected).abs() < 1e-8,
            "{a} to {b}: {} for {expected}",
            path.length
        );
        assert!((chain(&path) - path.length).abs() < 1e-8);
    }
    assert!(bent > 3, "only {bent} pairs bend");
}

trait PerpXy {
    fn perp_xy(&self, other: &Self) -> f64;
}

impl PerpXy for Vector3<f64> {
    fn perp_xy(&self, other: &Self) -> f64 {
        self.x * other.y - self.y * other.x
    }
}

#[test]
fn from_corner_to_corner_of_a_cube_the_way_is_that_of_its_net() {
    let points: Vec<Point3<f64>> = (0..8u8)
        .map(|i| Point3::new(f64::from(i & 1), f64::from((i >> 1) & 1), f64::from(i >> 2)))
        .collect();
    let squares =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> =
        squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let (mesh, geometry) = measured(points, &triangles);
    let at = |corner: usize| {
        let face = mesh.faces().find(|&f| mesh.face_vertices(f).contains(&VertexId::from(corner)));
        let face = face.expect("a face");
        let is_it = |v: VertexId| f64::from(u8::from(v == VertexId::from(corner)));
        (face, mesh.face_vertices(face).map(is_it))
    };
    let path = shortest_path(&mesh, &geometry, at(0), at(7)).expect("one surface");
    assert!((path.length - 5.0_f64.sqrt()).abs() < 1e-6, "{}", path.length);
    let face = |[x, y, z]: [f64; 3]| Point3::new(x, y, z);
    // Across one edge: from the middle of one side to that of the next.
    let path = shortest_path(&mesh, &geometry, at(1), at(6)).expect("one surface");
    assert!((path.length - 5.0_f64.sqrt()).abs() < 1e-6, "{}", path.length);
    assert!((path.points[0] - face([1.0, 0.0, 0.0])).norm() < 1e-6);
}

#[test]
fn on_a_ball_the_way_is_a_great_circle_within_the_error_of_its_facets() {
    for (n, allowed) in [(2, 0.06), (4, 0.004)] {
        let (mesh, geometry) = ball(n);
        for [from, to] in pairs(&mesh, 60) {
            let path = shortest_path(&mesh, &geometry, from, to).expect("one surface");
            let [a, b] = [from, to].map(|end| place(&mesh, &geometry, end).coords);
            let circle = a.cross(&b).norm().atan2(a.dot(&b));
            // Facets lie inside the ball by up to h²/6, h the length of an edge: ways are shorter by that much at most.
            let off = path.length / circle - 1.0;
            assert!(off.abs() < allowed, "{n}: off by {off} of {circle}");
            assert!((chain(&path) - path.length).abs() < 1e-9);
            assert!(path.length + 1e-12 >= (b - a).norm(), "not shorter than straight through");
        }
    }
}

#[test]
fn the_way_back_is_as_long_and_runs_through_the_same_points() {
    let (mesh, geometry) = ball(3);
    for [from, to] in pairs(&mesh, 40) {
        let there = shortest_path(&mesh, &geometry, from, to).expect("one surface");
        let back = shortest_path(&mesh, &geometry, to, from).expect("one surface");
        assert!((there.length / back.length - 1.0).abs() < 1e-9, "{from:?} {to:?}");
        let pairs = there.points.iter().zip(back.points.iter().rev());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).norm() < 1e-6), "{from:?} {to:?}");
    }
}

#[test]
fn parts_that_are_apart_have_no_way_between_them() {
    let points = [0.0, 3.0]
        .iter()
        .flat_map(|&x| [[x, 0.0], [x + 1.0, 0.0], [x, 1.0]])
        .map(|[x, y]| Point3::new(x, y, 0.0))
        .collect();
    let (mesh, geometry) = measured(points, &[[0, 1, 2], [3, 4, 5]]);
    let third = [1.0 / 3.0; 3];
    assert_eq!(shortest_path(&mesh, &geometry, (FaceId(0), third), (FaceId(1), third)), None);
    let [from, to] = [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1]].map(|weights| (FaceId(1), weights));
    let path = shortest_path(&mesh, &geometry, from, to).expect("the same face");
    assert!((path.length - 0.7).abs() < 1e-7 && path.points.len() == 2);
}
