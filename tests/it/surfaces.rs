//! Surfaces for tests: the zoo, and files of the shared folder where it is at hand.

use cutflow::geometry::{Geometry, polygon};
use cutflow::mesh::read::obj;
use cutflow::mesh::{CutMesh, Mesh, Soup};
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial, Weights};
use cutflow::methods::cutgraph::cut_to_disks;
use cutflow::methods::flow::Flow;
use cutflow::session::samples;
use nalgebra::{Point3, Rotation3};

/// A mesh of unit area.
pub struct Surface {
    pub name: String,
    pub mesh: Mesh,
    pub geometry: Geometry,
}

impl Surface {
    /// Triangulates, leaves unused vertices out, measures.
    pub fn from_soup(name: &str, soup: &Soup) -> Self {
        let mut triangles = Vec::new();
        for i in 0..soup.polygon_count() {
            polygon::triangulate(&soup.positions, soup.polygon(i), &mut triangles);
        }
        let mut numbers = vec![u32::MAX; soup.positions.len()];
        let mut positions = Vec::new();
        for v in triangles.iter_mut().flatten() {
            let number = &mut numbers[*v as usize];
            if *number == u32::MAX {
                *number = positions.len() as u32;
                positions.push(soup.positions[*v as usize]);
            }
            *v = *number;
        }
        let mesh = Mesh::new(positions.len(), &triangles).unwrap();
        let (geometry, _) = Geometry::unit_area(&mesh, &positions).unwrap();
        Self { name: name.to_owned(), mesh, geometry }
    }

    /// A geodesic sphere of 10 n² + 2 vertices.
    pub fn sphere(n: u32) -> Self {
        Self::from_soup(&format!("sphere {n}"), &samples::icosphere(n))
    }

    /// A generated sample.
    pub fn sample(name: &str) -> Self {
        Self::from_soup(name, &samples::generate(name).unwrap())
    }

    /// A mesh of the shared folder; says so and gives nothing where that is absent.
    pub fn shared(name: &str) -> Option<Self> {
        let path = format!("{}/../shared/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
        #[expect(clippy::disallowed_methods, reason = "tests read their files")]
        match std::fs::read(&path) {
            Ok(bytes) => Some(Self::from_soup(name, &obj::read(&bytes).unwrap().soup)),
            Err(_) => {
                // Straight to the terminal: what a passing test prints is not shown.
                let text = format!("SKIPPED: {name} needs ../shared/meshes, which is not there\n");
                std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes()).unwrap();
                None
            }
        }
    }

    /// The open and closed surfaces that identities are checked on.
    pub fn zoo() -> Vec<Self> {
        let mut zoo = vec![Self::sphere(1), Self::sphere(9)];
        zoo.extend(samples::SAMPLES.iter().map(|s| Self::sample(s.name)));
        zoo.push(Self::from_soup("tetrahedron", &tetrahedron()));
        zoo.push(Self::from_soup("cube", &cube()));
        zoo.push(Self::from_soup("cylinder", &cylinder(24, 9)));
        zoo
    }
}

/// Regular, edge √8.
pub fn tetrahedron() -> Soup {
    let positions = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    Soup::from_triangles(positions, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
}

/// Side 2, quadrilateral faces.
pub fn cube() -> Soup {
    let positions =
        (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 })).collect();
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Soup {
        positions,
        corners: faces.concat(),
        starts: (0..=6).map(|i| 4 * i).collect(),
        ..Soup::default()
    }
}

/// An open cylinder of radius 1 and height 2.
pub fn cylinder(around: u32, rows: u32) -> Soup {
    let mut positions = Vec::new();
    for j in 0..=rows {
        for i in 0..around {
            let angle =
                std::f64::consts::TAU * (f64::from(i) + 0.5 * f64::from(j)) / f64::from(around);
            positions.push([angle.cos(), angle.sin(), 2.0 * f64::from(j) / f64::from(rows)]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..around {
            let [a, b] = [i, (i + 1) % around].map(|i| j * around + i);
            let [c, d] = [i, (i + around - 1) % around].map(|i| (j + 1) * around + i);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Soup::from_triangles(positions, &triangles)
}

/// A grid of `n` × `m` squares, each divided, tilted out of all axes; its columns close if asked to. **Gives** points, triangles, and how
/// many points a row has.
pub fn grid(
    [n, m]: [u32; 2],
    closed: bool,
    place: impl Fn(f64, f64) -> [f64; 3],
) -> (Vec<Point3<f64>>, Vec<[u32; 3]>, u32) {
    let columns = if closed { n } else { n + 1 };
    let tilt = Rotation3::from_euler_angles(0.4, -0.2, 1.0);
    let mut points = Vec::new();
    for j in 0..=m {
        for i in 0..columns {
            let p = place(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m));
            points.push(tilt * Point3::from(p));
        }
    }
    let at = |i: u32, j: u32| j * columns + i % columns;
    let mut triangles = Vec::new();
    for j in 0..m {
        for i in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend(if (i + j) % 2 == 0 {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            });
        }
    }
    (points, triangles, columns)
}

/// The cut of a surface after some steps of the flow, its patches cut to disks, and where its points lie.
pub fn cut_by_flow(
    surface: Surface,
    initial: &Initial,
    hencky: f64,
    steps: usize,
) -> (CutMesh, Vec<Point3<f64>>) {
    let Surface { mesh, geometry, .. } = surface;
    let weights = Weights { dirichlet: 1.0, hencky, length: 2.0, ..Weights::default() };
    let params = CutFlowParams { weights, ..CutFlowParams::default() };
    let mut flow = CutFlow::new(mesh.clone(), geometry.clone(), initial, params).unwrap();
    for _ in 0..steps {
        flow.step().unwrap();
    }
    let mut cut = flow.cut_mesh();
    let points: Vec<_> = cut.points.iter().map(|&p| geometry.locate(&mesh, p)).collect();
    cut_to_disks(&mut cut, &points).unwrap();
    (cut, points)
}
