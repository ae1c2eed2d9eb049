//! Triangles that can be split, collapsed and flipped.
//!
//! Faces hold their vertices, vertices their faces. Each side of a face has a mark, the same from both faces at an edge:
//! `NONE` for an ordinary edge, a number for one that must stay an edge. What makes a manifold is kept by every operation whose
//! conditions were asked for first; measuring is left to the caller.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::{Attributes, NONE, Prepared, Surface, Uv};
use crate::mesh::{EdgeId, Mesh, MeshError, VertexId};

/// A surface at work.
pub(super) struct Triangles {
    pub positions: Vec<Point3<f64>>,
    /// Corners of the faces; a face that is gone has `NONE`.
    pub faces: Vec<[u32; 3]>,
    /// Marks of the sides; side i runs from corner i to the next.
    pub marks: Vec<[u32; 3]>,
    /// Texture coordinates of the corners, empty where there are none.
    pub uvs: Vec<[Uv; 3]>,
    /// What the maker wants to know of each face; passed on to the parts of it.
    pub tags: Vec<u32>,
    /// The faces at each vertex, in no order.
    pub fans: Vec<Vec<u32>>,
    /// Number of faces that are not gone.
    pub face_count: usize,
    /// Whether each vertex is one of the given surface at its old place.
    pub is_old: Vec<bool>,
}

/// The faces at an edge: at most two.
#[derive(Clone, Copy)]
pub(super) struct EdgeFaces {
    faces: [u32; 2],
    count: usize,
}

impl EdgeFaces {
    /// One or two face numbers.
    pub fn as_slice(&self) -> &[u32] {
        &self.faces[..self.count]
    }
}

impl Triangles {
    /// All faces unmarked, tag i for face i.
    pub fn new(surface: &Surface) -> Self {
        let mesh = &surface.mesh;
        let faces: Vec<[u32; 3]> = mesh.triangles().iter().map(|t| t.map(|v| v.0)).collect();
        let mut degrees = vec![0usize; mesh.vertex_count()];
        for &v in faces.iter().flatten() {
            degrees[v as usize] += 1;
        }
        let mut fans: Vec<Vec<u32>> = degrees.iter().map(|&d| Vec::with_capacity(d + 2)).collect();
        for (f, vertices) in faces.iter().enumerate() {
            for &v in vertices {
                fans[v as usize].push(f as u32);
            }
        }
        Self {
            positions: surface.positions.clone(),
            marks: vec![[NONE; 3]; faces.len()],
            uvs: surface.attributes.corner_uvs.clone(),
            tags: (0..faces.len() as u32).collect(),
            face_count: faces.len(),
            is_old: vec![true; mesh.vertex_count()],
            faces,
            fans,
        }
    }

    /// Marks an edge of the mesh that these triangles were made from.
    pub fn mark_edge(&mut self, mesh: &Mesh, e: EdgeId, mark: u32) {
        let [a, b] = mesh.edge_vertices(e).map(|v| v.0);
        self.set_mark(a, b, mark);
    }

    /// Whether a face is there.
    pub fn is_alive(&self, f: u32) -> bool {
        self.faces[f as usize][0] != NONE
    }

    /// The faces at the edge between two vertices.
    pub fn edge_faces(&self, a: u32, b: u32) -> EdgeFaces {
        let mut found = EdgeFaces { faces: [NONE; 2], count: 0 };
        for &f in &self.fans[a as usize] {
            if found.count < 2 && self.faces[f as usize].contains(&b) {
                found.faces[found.count] = f;
                found.count += 1;
            }
        }
        found
    }

    /// Which corner of a face a vertex is.
    pub fn corner(&self, f: u32, v: u32) -> usize {
        let face = self.faces[f as usize];
        if face[0] == v {
            0
        } else if face[1] == v {
            1
        } else {
            debug_assert_eq!(face[2], v);
            2
        }
    }

    /// Which side of a face joins two of its vertices.
    pub fn side(&self, f: u32, a: u32, b: u32) -> usize {
        let (i, j) = (self.corner(f, a), self.corner(f, b));
        if j == (i + 1) % 3 { i } else { j }
    }

    /// The corner of a face that is neither of two others.
    pub fn third(&self, f: u32, a: u32, b: u32) -> u32 {
        let i = self.side(f, a, b);
        self.faces[f as usize][(i + 2) % 3]
    }

    /// The mark of an edge.
    pub fn mark(&self, a: u32, b: u32) -> u32 {
        let faces = self.edge_faces(a, b);
        faces.as_slice().first().map_or(NONE, |&f| self.marks[f as usize][self.side(f, a, b)])
    }

    /// Marks an edge on both sides.
    pub fn set_mark(&mut self, a: u32, b: u32, mark: u32) {
        for &f in self.edge_faces(a, b).as_slice() {
            let side = self.side(f, a, b);
            self.marks[f as usize][side] = mark;
        }
    }

    /// The corners of a face in space.
    pub fn points(&self, f: u32) -> [Point3<f64>; 3] {
        self.faces[f as usize].map(|v| self.positions[v as usize])
    }

    /// The vertices joined to a vertex by an edge, each once, in increasing order.
    pub fn neighbours(&self, v: u32, into: &mut Vec<u32>) {
        into.clear();
        let fan = &self.fans[v as usize];
        into.extend(fan.iter().flat_map(|&f| self.faces[f as usize]).filter(|&w| w != v));
        into.sort_unstable();
        into.dedup();
    }

    /// All edges by their ends, the smaller first, in increasing order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.face_count * 3 / 2 + 16);
        for face in self.faces.iter().filter(|face| face[0] != NONE) {
            for i in 0..3 {
                let (a, b) = (face[i], face[(i + 1) % 3]);
                edges.push([a.min(b), a.max(b)]);
            }
        }
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Puts a vertex on an edge: every face there becomes two. Gives its number; new faces are the last ones.
    pub fn split(&mut self, a: u32, b: u32, place: Point3<f64>) -> u32 {
        let m = self.positions.len() as u32;
        self.positions.push(place);
        self.is_old.push(false);
        let mut fan = Vec::with_capacity(6);
        for &f in self.edge_faces(a, b).as_slice() {
            let i = self.side(f, a, b);
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let g = self.faces.len() as u32;
            let old = self.faces[f as usize];
            let (mut second, mut second_marks) = (old, self.marks[f as usize]);
            second[i] = m;
            second_marks[k] = NONE;
            self.faces[f as usize][j] = m;
            self.marks[f as usize][j] = NONE;
            self.faces.push(second);
            self.marks.push(second_marks);
            self.tags.push(self.tags[f as usize]);
            if let Some(uvs) = self.uvs.get_mut(f as usize) {
                let mut second = *uvs;
                let middle = midway(uvs[i], uvs[j]);
                uvs[j] = middle;
                second[i] = middle;
                self.uvs.push(second);
            }
            for slot in self.fans[old[j] as usize].iter_mut().filter(|slot| **slot == f) {
                *slot = g;
            }
            self.fans[old[k] as usize].push(g);
            fan.extend([f, g]);
            self.face_count += 1;
        }
        self.fans.push(fan);
        m
    }

    /// Whether `gone` can be drawn into `kept` without a change of topology and without two marked lines running into one:
    /// the link condition, in terms of neighbours. Marks of `gone` itself are the caller's business.
    pub fn can_collapse(&self, gone: u32, kept: u32, scratch: &mut [Vec<u32>; 2]) -> bool {
        let at = self.edge_faces(gone, kept);
        let [ring, other] = scratch;
        self.neighbours(gone, ring);
        self.neighbours(kept, other);
        let common = other.iter().filter(|v| ring.binary_search(v).is_ok()).count();
        if at.count == 0 || common != at.count {
            return false;
        }
        at.as_slice().iter().all(|&f| {
            let c = self.third(f, gone, kept);
            let marks = self.marks[f as usize];
            let both =
                [self.side(f, gone, c), self.side(f, kept, c)].iter().all(|&s| marks[s] != NONE);
            self.neighbours(c, other);
            let degree = self.fans[c as usize].len();
            // On a rim there is one neighbour more than faces; there two faces suffice, else four.
            let enough = if other.len() > degree { 2 } else { 4 };
            degree >= enough && !both
        })
    }

    /// Draws `gone` into `kept`, whose place and texture coordinates stay as they are.
    pub fn collapse(&mut self, gone: u32, kept: u32) {
        let dying = self.edge_faces(gone, kept);
        let mut lines = [(NONE, NONE); 2];
        for (line, &f) in lines.iter_mut().zip(dying.as_slice()) {
            let c = self.third(f, gone, kept);
            let marks = self.marks[f as usize];
            // At most one of the two is marked.
            *line = (c, marks[self.side(f, gone, c)].min(marks[self.side(f, kept, c)]));
            for v in [kept, c] {
                self.fans[v as usize].retain(|&g| g != f);
            }
            self.faces[f as usize] = [NONE; 3];
            self.face_count -= 1;
        }
        let fan = std::mem::take(&mut self.fans[gone as usize]);
        for f in fan {
            if self.is_alive(f) {
                let corner = self.corner(f, gone);
                self.faces[f as usize][corner] = kept;
                self.fans[kept as usize].push(f);
            }
        }
        for (c, mark) in lines {
            if c != NONE {
                self.set_mark(c, kept, mark);
            }
        }
    }

    /// Turns the edge between two faces, gives whether that was possible: it is not on the boundary, at marks, or where the
    /// other diagonal is an edge already. Texture coordinates must be absent.
    pub fn flip(&mut self, a: u32, b: u32) -> bool {
        debug_assert!(self.uvs.is_empty());
        let faces = self.edge_faces(a, b);
        let &[f, g] = faces.as_slice() else { return false };
        // f has the edge from a to b.
        let (f, g) =
            if self.faces[f as usize][(self.corner(f, a) + 1) % 3] == b { (f, g) } else { (g, f) };
        let (c, d) = (self.third(f, a, b), self.third(g, a, b));
        if self.marks[f as usize][self.side(f, a, b)] != NONE || self.edge_faces(c, d).count > 0 {
            return false;
        }
        let mark = |f: u32, a: u32, b: u32| self.marks[f as usize][self.side(f, a, b)];
        let first = [mark(g, a, d), NONE, mark(f, c, a)];
        let second = [mark(g, d, b), mark(f, b, c), NONE];
        (self.faces[f as usize], self.marks[f as usize]) = ([a, d, c], first);
        (self.faces[g as usize], self.marks[g as usize]) = ([d, b, c], second);
        self.fans[a as usize].retain(|&h| h != g);
        self.fans[b as usize].retain(|&h| h != f);
        self.fans[c as usize].push(g);
        self.fans[d as usize].push(f);
        true
    }

    /// The surface as it stands. `face_source` names for a face the given surface's face whose group and material it has, `uvs`
    /// its texture coordinates. **Costs** O(F) and the connecting of the mesh.
    pub fn export(
        &self,
        attributes: &Attributes,
        face_source: impl Fn(u32) -> u32,
        uvs: impl Fn(u32) -> [Uv; 3],
    ) -> Result<Prepared, MeshError> {
        let used: Vec<u32> = (0..self.positions.len() as u32)
            .filter(|&v| !self.fans[v as usize].is_empty())
            .collect();
        let (mut order, new): (Vec<u32>, Vec<u32>) =
            used.into_iter().partition(|&v| self.is_old[v as usize]);
        let old = order.len();
        order.extend(new);
        let mut numbers = vec![NONE; self.positions.len()];
        for (number, &v) in order.iter().enumerate() {
            numbers[v as usize] = number as u32;
        }
        let faces: Vec<u32> = (0..self.faces.len() as u32).filter(|&f| self.is_alive(f)).collect();
        let triangles: Vec<[u32; 3]> =
            faces.iter().map(|&f| self.faces[f as usize].map(|v| numbers[v as usize])).collect();
        let mesh = Mesh::new(order.len(), &triangles)?;
        let pick = |list: &[u32]| -> Vec<u32> {
            let get = |&f: &u32| list.get(face_source(f) as usize).copied().unwrap_or(NONE);
            if list.is_empty() { Vec::new() } else { faces.iter().map(get).collect() }
        };
        let corner_uvs = if attributes.corner_uvs.is_empty() {
            Vec::new()
        } else {
            faces.iter().map(|&f| uvs(f)).collect()
        };
        let attributes = Attributes {
            corner_uvs,
            face_groups: pick(&attributes.face_groups),
            face_materials: pick(&attributes.face_materials),
            groups: attributes.groups.clone(),
            materials: attributes.materials.clone(),
        };
        let positions = order.iter().map(|&v| self.positions[v as usize]).collect();
        let ancestor = |(i, &v): (usize, &u32)| (i < old).then_some(VertexId(v));
        let ancestors = order.iter().enumerate().map(ancestor).collect();
        Ok(Prepared { surface: Surface { mesh, positions, attributes }, ancestors })
    }
}

/// The texture coordinate in the middle of an edge.
pub(super) fn midway(a: Uv, b: Uv) -> Uv {
    let (a, b) = (a?, b?);
    Some([0, 1].map(|i| 0.5 * a[i] + 0.5 * b[i]))
}

/// Twice the area times the normal of a triangle.
pub(super) fn vector([a, b, c]: [Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}

/// Whether a face turns by more than the angle of a cosine, or loses its area. One without area may do anything.
pub(super) fn turns_over(old: Vector3<f64>, new: Vector3<f64>, cosine: f64) -> bool {
    let norm = old.norm();
    norm > 0.0 && !(old.dot(&new) > cosine * norm * new.norm())
}

/// 1 for an equilateral triangle, 0 for one without area: 2√3 |n| / Σ l².
pub(super) fn shape([a, b, c]: [Point3<f64>; 3]) -> f64 {
    let sides = (b - a).norm_squared() + (c - b).norm_squared() + (a - c).norm_squared();
    2.0 * 3f64.sqrt() * vector([a, b, c]).norm() / sides.max(f64::MIN_POSITIVE)
}
