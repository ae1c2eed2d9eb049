//! Small surfaces of every kind, and surfaces that hardly are any.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use cutflow::session::samples;

/// A mesh on its way to a file: points and polygons.
#[derive(Clone, Default)]
pub struct Shape {
    pub points: Vec<[f64; 3]>,
    pub faces: Vec<Vec<u32>>,
}

impl Shape {
    pub fn triangles(points: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Self {
        Self { points, faces: triangles.iter().map(|t| t.to_vec()).collect() }
    }

    /// Both, side by side, nothing shared.
    pub fn with(mut self, other: &Self) -> Self {
        let shift = self.points.len() as u32;
        self.points.extend(&other.points);
        self.faces.extend(other.faces.iter().map(|f| f.iter().map(|v| v + shift).collect()));
        self
    }

    pub fn moved(&self, place: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        Self { points: self.points.iter().map(|&p| place(p)).collect(), faces: self.faces.clone() }
    }

    pub fn obj(&self) -> Vec<u8> {
        let mut text = String::new();
        for [x, y, z] in &self.points {
            text += &format!("v {x:?} {y:?} {z:?}\n");
        }
        for face in &self.faces {
            let corners: Vec<String> = face.iter().map(|v| (v + 1).to_string()).collect();
            text += &format!("f {}\n", corners.join(" "));
        }
        text.into_bytes()
    }
}

pub fn ball(n: u32) -> Shape {
    let soup = samples::icosphere(n);
    let faces = (0..soup.polygon_count()).map(|i| soup.polygon(i).to_vec()).collect();
    Shape { points: soup.positions, faces }
}

pub fn triangle() -> Shape {
    Shape::triangles(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])
}

pub fn two_triangles() -> Shape {
    let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [1.0, 1.0, 0.0], [0.0, 1.0, 0.3]];
    Shape::triangles(points, &[[0, 1, 2], [0, 2, 3]])
}

pub fn tetrahedron() -> Shape {
    let points = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    Shape::triangles(points, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
}

/// A sheet of n × m squares, each two triangles.
pub fn sheet(n: u32, m: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> Shape {
    let mut shape = Shape::default();
    for (j, i) in (0..=m).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        shape.points.push(place(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m)));
    }
    for (j, i) in (0..m).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let a = j * (n + 1) + i;
        shape.faces.push(vec![a, a + 1, a + n + 2]);
        shape.faces.push(vec![a, a + n + 2, a + n + 1]);
    }
    shape
}

/// An open tube of radius 1.
pub fn tube(around: u32, rows: u32) -> Shape {
    let mut shape = Shape::default();
    for (j, i) in (0..=rows).flat_map(|j| (0..around).map(move |i| (j, i))) {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
        shape.points.push([cos, sin, 2.0 * f64::from(j) / f64::from(rows)]);
    }
    for (j, i) in (0..rows).flat_map(|j| (0..around).map(move |i| (j, i))) {
        let (a, b) = (j * around + i, j * around + (i + 1) % around);
        shape.faces.push(vec![a, b, b + around]);
        shape.faces.push(vec![a, b + around, a + around]);
    }
    shape
}

/// A ring of squares.
pub fn torus(n: u32, m: u32) -> Shape {
    let mut shape = Shape::default();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let (s, c) = (TAU * f64::from(i) / f64::from(n)).sin_cos();
        let (t, d) = (TAU * f64::from(j) / f64::from(m)).sin_cos();
        shape.points.push([(1.0 + 0.4 * d) * c, (1.0 + 0.4 * d) * s, 0.4 * t]);
        let at = |i: u32, j: u32| i % n * m + j % m;
        shape.faces.push(vec![at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    shape
}

/// A plate of cubes with a row of holes: a closed surface of that genus, its faces divided.
pub fn plate(genus: u32) -> Shape {
    let is_solid = |i: i64, j: i64, k: i64| {
        let length = 2 * i64::from(genus) + 1;
        (0..length).contains(&i)
            && (0..3).contains(&j)
            && k == 0
            && !(j == 1 && i.rem_euclid(2) == 1)
    };
    let mut numbers: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut shape = Shape::default();
    let faces: [([i64; 3], [[i64; 3]; 4]); 6] = [
        ([1, 0, 0], [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]),
        ([-1, 0, 0], [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]]),
        ([0, 1, 0], [[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]]),
        ([0, -1, 0], [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]),
        ([0, 0, 1], [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]),
        ([0, 0, -1], [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]]),
    ];
    for (i, j) in (0..2 * i64::from(genus) + 1).flat_map(|i| (0..3).map(move |j| (i, j))) {
        if !is_solid(i, j, 0) {
            continue;
        }
        for (out, corners) in &faces {
            if is_solid(i + out[0], j + out[1], out[2]) {
                continue;
            }
            let quad = corners.map(|c| {
                let key = [i + c[0], j + c[1], c[2]];
                *numbers.entry(key).or_insert_with(|| {
                    shape.points.push(key.map(|x| x as f64));
                    shape.points.len() as u32 - 1
                })
            });
            shape.faces.push(vec![quad[0], quad[1], quad[2]]);
            shape.faces.push(vec![quad[0], quad[2], quad[3]]);
        }
    }
    shape
}

/// Three triangles at an edge: no surface, until it is repaired.
pub fn fan() -> Shape {
    let points =
        vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.5], [-0.5, 0.8, 0.5], [-0.5, -0.8, 0.5]];
    Shape::triangles(points, &[[0, 1, 2], [0, 1, 3], [0, 1, 4]])
}

/// The same kinds with some tens of triangles: sequences of commands on them take fractions of a second.
pub fn tiny() -> Vec<(&'static str, Vec<u8>)> {
    let wave = |x: f64, y: f64| [x, y, 0.15 * (TAU * x).sin() * (TAU * y).cos()];
    let far = |p: [f64; 3]| [p[0] + 4.0, p[1], 0.7 * p[2]];
    let thin = |p: [f64; 3]| [p[0], 0.05 * p[1], p[2]];
    let parts = ball(1).with(&tube(4, 1).moved(far)).with(&triangle().moved(|p| [p[0], p[1], 9.0]));
    vec![
        ("ball.obj", ball(1).obj()),
        ("triangle.obj", triangle().obj()),
        ("two.obj", two_triangles().obj()),
        ("tetrahedron.obj", tetrahedron().obj()),
        ("sheet.obj", sheet(4, 3, wave).obj()),
        ("flat.obj", sheet(3, 2, |x, y| [x, y, 0.0]).obj()),
        ("tube.obj", tube(5, 2).obj()),
        ("torus.obj", torus(5, 4).obj()),
        ("plate.obj", plate(1).obj()),
        ("parts.obj", parts.obj()),
        ("thin.obj", ball(2).moved(thin).obj()),
        ("finer.obj", ball(2).obj()),
        ("fan.obj", fan().obj()),
    ]
}

/// The documents that random commands are given to, now and then.
pub fn small() -> Vec<(&'static str, Vec<u8>)> {
    let wave = |x: f64, y: f64| [x, y, 0.15 * (TAU * x).sin() * (TAU * y).cos()];
    let far = |p: [f64; 3]| [p[0] + 4.0, p[1], 0.7 * p[2]];
    let thin = |p: [f64; 3]| [p[0], 0.05 * p[1], p[2]];
    let parts = ball(2).with(&tube(6, 2).moved(far)).with(&triangle().moved(|p| [p[0], p[1], 9.0]));
    vec![
        ("ball.obj", ball(2).obj()),
        ("triangle.obj", triangle().obj()),
        ("two.obj", two_triangles().obj()),
        ("tetrahedron.obj", tetrahedron().obj()),
        ("sheet.obj", sheet(6, 6, wave).obj()),
        ("flat.obj", sheet(3, 2, |x, y| [x, y, 0.0]).obj()),
        ("tube.obj", tube(8, 3).obj()),
        ("torus.obj", torus(8, 6).obj()),
        ("plate.obj", plate(2).obj()),
        ("parts.obj", parts.obj()),
        ("thin.obj", ball(3).moved(thin).obj()),
        ("finer.obj", ball(4).obj()),
        ("fan.obj", fan().obj()),
    ]
}
