//! Vertices as graphics cards and PLY have them: one for each point with its place in the map and its normal, where OBJ numbers
//! the three apart.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes; normals are written in 32 bits"
)]

use super::attributes::Normals;
use super::obj::CutSurface;

/// "None" for a link.
const END: u32 = u32::MAX;

/// The corners of the refined triangles without repetition.
pub(super) struct Split {
    /// The vertex of the opened surface that each vertex is, in the order in which the triangles use them first.
    pub vertices: Vec<u32>,
    /// For each triangle of the cut its vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals of the vertices; empty where the file has none. Where only some corners have one, the others get that of
    /// their triangles.
    pub normals: Vec<[f32; 3]>,
}

impl Split {
    /// **Costs** O(F), and for each vertex the square of its different normals.
    pub fn new(surface: &CutSurface) -> Self {
        let CutSurface { soup, opened, .. } = *surface;
        let normals = Normals::new(surface);
        let normal = |face, corner| {
            let number = normals.corner(face, corner)?;
            let normal = soup.normals.get(number);
            unit(*normal.or_else(|| normals.new.get(number - soup.normals.len()))?)
        };
        let has_normals = !soup.normal_corners.is_empty() && !surface.face_polygons.is_empty();
        // Vertices that are the same vertex of the opened surface, as chains.
        let mut firsts = vec![END; opened.mesh.vertex_count()];
        let mut nexts: Vec<u32> = Vec::new();
        let mut own: Vec<Option<[f32; 3]>> = Vec::new();
        let mut vertices: Vec<u32> = Vec::new();
        let mut triangles = Vec::with_capacity(opened.mesh.face_count());
        for (face, corners) in opened.mesh.triangles().iter().enumerate() {
            let mut triangle = [0; 3];
            for (corner, v) in corners.iter().enumerate() {
                let normal = normal(face, corner);
                let mut at = firsts[v.index()];
                while at != END && own[at as usize] != normal {
                    at = nexts[at as usize];
                }
                if at == END {
                    at = vertices.len() as u32;
                    nexts.push(std::mem::replace(&mut firsts[v.index()], at));
                    own.push(normal);
                    vertices.push(v.0);
                }
                triangle[corner] = at;
            }
            triangles.push(triangle);
        }
        let mut split = Self { vertices, triangles, normals: Vec::new() };
        if has_normals {
            let of_faces = split.face_normals(surface);
            split.normals =
                own.iter().zip(of_faces).map(|(own, face)| own.unwrap_or(face)).collect();
        }
        split
    }

    /// Where each vertex lies in the coordinates of the file.
    pub fn places(&self, surface: &CutSurface) -> Vec<[f64; 3]> {
        let point = |&v: &u32| surface.opened.vertex_points[v as usize];
        self.vertices.iter().map(|v| surface.place(surface.cut.points[point(v) as usize])).collect()
    }

    /// The vertex of the file of each vertex, counted from 0; vertices on the cut go on from the last.
    pub fn source_vertices(&self, surface: &CutSurface) -> Vec<usize> {
        let point = |&v: &u32| surface.opened.vertex_points[v as usize];
        self.vertices.iter().map(|v| surface.point_number(point(v)) - 1).collect()
    }

    /// For each vertex the mean normal of its triangles, by their areas; up where they have none.
    fn face_normals(&self, surface: &CutSurface) -> Vec<[f32; 3]> {
        let places = self.places(surface);
        let mut sums = vec![[0.0; 3]; places.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| places[v as usize]);
            let (s, t) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
            let cross = [0, 1, 2].map(|i| {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                s[j] * t[k] - s[k] * t[j]
            });
            for &v in triangle {
                for (sum, x) in sums[v as usize].iter_mut().zip(cross) {
                    *sum += x;
                }
            }
        }
        sums.into_iter().map(|sum| unit(sum).unwrap_or([0.0, 0.0, 1.0])).collect()
    }
}

/// The direction of a vector in single precision; none for one that is too short or too long to have one.
fn unit(vector: [f64; 3]) -> Option<[f32; 3]> {
    let largest = vector.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    // Divided first: squares of extreme numbers are nothing or infinite.
    let scaled = vector.map(|x| x / largest);
    let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Adding 0 makes −0 a 0, so that equal normals have equal bits.
    (length.is_finite() && largest > 1e-12).then(|| scaled.map(|x| (x / length) as f32 + 0.0))
}
