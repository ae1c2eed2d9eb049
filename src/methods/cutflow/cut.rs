//! The cut as the zero set of labels' level sets: crossings on edges, segments and triple points in faces.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::Vector2;

use crate::geometry::Geometry;
use crate::mesh::{CutMesh, EdgeId, FaceId, Mesh, SurfacePoint, VertexId};

/// No crossing, no entry.
pub(in super::super) const NONE: u32 = u32::MAX;

/// Crossings keep this relative distance from vertices, so that sub-triangles keep an area. Larger values move the cut:
/// snapping to [.01, .99] raises the error of the flux twentyfold; smaller ones lose the areas to rounding.
const CLAMP: f64 = 1e-6;

/// A point where the cut crosses an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Crossing {
    pub edge: EdgeId,
    /// Position from the tail of the edge's first halfedge.
    pub t: f64,
    /// The two labels, smaller first.
    pub labels: [u32; 2],
    /// d = φ_lower − φ_upper at tail and tip; t = d₀ / (d₀ − d₁).
    pub d: [f64; 2],
}

/// One end of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Node {
    Crossing(u32),
    Centre(u32),
}

/// A straight piece of the cut inside a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct Segment {
    pub ends: [Node; 2],
    pub face: FaceId,
    /// The two labels that it separates, smaller first.
    pub labels: [u32; 2],
    pub length: f64,
    /// In the face's frame, pointing from the smaller label to the larger one.
    pub normal: Vector2<f64>,
}

/// A face that the cut runs through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct CrossedFace {
    pub face: FaceId,
    /// The crossing on each side, [`NONE`] where there is none.
    pub crossings: [u32; 3],
    /// The corner that differs from the other two; 3 if all differ.
    pub lone: u8,
    /// Index among the triple points, if `lone` is 3.
    pub centre: u32,
    /// Index of the first of its one or three segments.
    pub first_segment: u32,
}

/// A corner of a sub-triangle of a crossed face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum Corner {
    /// Corner `i` of the face.
    Vertex(usize),
    /// The crossing on side `i`.
    Side(usize),
    /// The triple point.
    Centre,
}

/// The whole cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in super::super) struct Cut {
    pub crossings: Vec<Crossing>,
    /// The faces with triple points, each the mean of its three crossings.
    pub centres: Vec<u32>,
    pub segments: Vec<Segment>,
    pub faces: Vec<CrossedFace>,
    /// Sum of the segment lengths.
    pub length: f64,
}

/// Faces laid out flat: corner 0 at the origin, corner 1 on the x axis, corner 2 above it.
#[derive(Clone, Debug)]
pub(in super::super) struct Frames(Vec<[f64; 3]>);

impl Frames {
    pub fn new(mesh: &Mesh, geometry: &Geometry) -> Self {
        Self(
            mesh.faces()
                .map(|f| {
                    let [base, _, side] =
                        mesh.face_halfedges(f).map(|h| geometry.edge_length(h.edge()));
                    let height = 2.0 * geometry.face_areas[f.index()] / base;
                    let angle = geometry.corner_angles[f.index()][0];
                    [base, side * angle.cos(), height]
                })
                .collect(),
        )
    }

    /// The corners of a face in its frame.
    pub fn corners(&self, f: FaceId) -> [Vector2<f64>; 3] {
        let [x1, x2, y2] = self.0[f.index()];
        [Vector2::zeros(), Vector2::new(x1, 0.0), Vector2::new(x2, y2)]
    }
}

impl Cut {
    /// Finds the cut of labelled vertices.
    ///
    /// **Takes** `difference(v, lower, upper)` = φ_lower(v) − φ_upper(v), negative where `lower` wins; `edge_crossings` is
    /// scratch, [`NONE`] for every edge, and is left as the lookup from edges to crossings.
    pub fn find(
        mesh: &Mesh,
        frames: &Frames,
        labels: &[u32],
        difference: impl Fn(VertexId, u32, u32) -> f64,
        edge_crossings: &mut [u32],
    ) -> Self {
        let mut cut = Self::default();
        for e in mesh.edges() {
            let [tail, tip] = mesh.edge_vertices(e);
            let (a, b) = (labels[tail.index()], labels[tip.index()]);
            if a == b {
                continue;
            }
            let pair = [a.min(b), a.max(b)];
            // The winner of each end fixes the sign, whatever rounding says.
            let sign = |at: u32| if at == pair[0] { -1.0 } else { 1.0 };
            let at = |v: VertexId, own: u32| {
                sign(own) * (sign(own) * difference(v, pair[0], pair[1])).max(1e-300)
            };
            let d = [at(tail, a), at(tip, b)];
            let t = (d[0] / (d[0] - d[1])).clamp(CLAMP, 1.0 - CLAMP);
            edge_crossings[e.index()] = cut.crossings.len() as u32;
            cut.crossings.push(Crossing { edge: e, t, labels: pair, d });
        }
        cut.add_faces(mesh, frames, labels, edge_crossings);
        cut
    }

    /// The cut of labelled vertices with crossings at given places.
    pub fn of_labels(
        mesh: &Mesh,
        frames: &Frames,
        labels: &[u32],
        place: impl Fn(EdgeId) -> f64,
    ) -> Self {
        let mut cut = Self::default();
        let mut edge_crossings = vec![NONE; mesh.edge_count()];
        for e in mesh.edges() {
            let [a, b] = mesh.edge_vertices(e).map(|v| labels[v.index()]);
            if a != b {
                let t = place(e).clamp(CLAMP, 1.0 - CLAMP);
                let d = if a < b { [-t, 1.0 - t] } else { [t, t - 1.0] };
                edge_crossings[e.index()] = cut.crossings.len() as u32;
                cut.crossings.push(Crossing { edge: e, t, labels: [a.min(b), a.max(b)], d });
            }
        }
        cut.add_faces(mesh, frames, labels, &edge_crossings);
        cut
    }

    fn add_faces(&mut self, mesh: &Mesh, frames: &Frames, labels: &[u32], edge_crossings: &[u32]) {
        for f in mesh.faces() {
            let crossings = mesh.face_halfedges(f).map(|h| edge_crossings[h.edge().index()]);
            let lone = match crossings.map(|c| c != NONE) {
                [false, false, false] => continue,
                // The corner between the two crossed sides.
                [true, true, false] => 1,
                [false, true, true] => 2,
                [true, false, true] => 0,
                _ => 3,
            };
            self.add_face(mesh, frames, f, crossings, lone, labels);
        }
        self.length = self.segments.iter().map(|s| s.length).sum();
    }

    fn add_face(
        &mut self,
        mesh: &Mesh,
        frames: &Frames,
        face: FaceId,
        crossings: [u32; 3],
        lone: u8,
        labels: &[u32],
    ) {
        let centre = if lone == 3 { self.centres.len() as u32 } else { NONE };
        if lone == 3 {
            self.centres.push(self.faces.len() as u32);
        }
        let crossed = CrossedFace {
            face,
            crossings,
            lone,
            centre,
            first_segment: self.segments.len() as u32,
        };
        self.faces.push(crossed);
        let corners = frames.corners(face);
        let points = self.face_points(mesh, frames, &crossed);
        let vertices = mesh.face_vertices(face);
        let mut add = |ends: [Node; 2], from: Vector2<f64>, to: Vector2<f64>, sides: [usize; 2]| {
            let [a, b] = sides.map(|corner| labels[vertices[corner].index()]);
            let tangent = to - from;
            let length = tangent.norm();
            let upward = if a < b {
                corners[sides[1]] - corners[sides[0]]
            } else {
                corners[sides[0]] - corners[sides[1]]
            };
            let mut normal = Vector2::new(-tangent.y, tangent.x) / length.max(1e-300);
            if normal.dot(&upward) < 0.0 {
                normal = -normal;
            }
            self.segments.push(Segment {
                ends,
                face,
                labels: [a.min(b), a.max(b)],
                length,
                normal,
            });
        };
        if lone == 3 {
            for side in 0..3 {
                let ends = [Node::Crossing(crossings[side]), Node::Centre(centre)];
                add(ends, points.sides[side], points.centre, [side, (side + 1) % 3]);
            }
        } else {
            let own = lone as usize;
            let (x, z) = (own, (own + 2) % 3);
            let ends = [Node::Crossing(crossings[x]), Node::Crossing(crossings[z])];
            add(ends, points.sides[x], points.sides[z], [own, (own + 1) % 3]);
        }
    }

    /// The places of a crossed face's points in its frame.
    pub fn face_points(&self, mesh: &Mesh, frames: &Frames, crossed: &CrossedFace) -> FacePoints {
        let corners = frames.corners(crossed.face);
        let halfedges = mesh.face_halfedges(crossed.face);
        let mut sides = [Vector2::zeros(); 3];
        for i in 0..3 {
            if crossed.crossings[i] == NONE {
                continue;
            }
            let t = self.crossings[crossed.crossings[i] as usize].t;
            let from_corner = if halfedges[i].0 & 1 == 0 { t } else { 1.0 - t };
            sides[i] = corners[i] + (corners[(i + 1) % 3] - corners[i]) * from_corner;
        }
        FacePoints { corners, sides, centre: (sides[0] + sides[1] + sides[2]) / 3.0 }
    }

    /// The surface refined along the cut: points `V..` are the crossings in order, then the triple points.
    pub fn refine(&self, mesh: &Mesh, frames: &Frames) -> CutMesh {
        let base = mesh.vertex_count() as u32;
        let centre_base = base + self.crossings.len() as u32;
        let mut result = CutMesh {
            points: mesh.vertices().map(SurfacePoint::Vertex).collect(),
            ..CutMesh::default()
        };
        result.points.extend(self.crossings.iter().map(|c| SurfacePoint::Edge(c.edge, c.t)));
        for &face in &self.centres {
            let crossed = &self.faces[face as usize];
            let mut weights = [0.0; 3];
            for (i, h) in mesh.face_halfedges(crossed.face).into_iter().enumerate() {
                let t = self.crossings[crossed.crossings[i] as usize].t;
                let from_corner = if h.0 & 1 == 0 { t } else { 1.0 - t };
                weights[i] += (1.0 - from_corner) / 3.0;
                weights[(i + 1) % 3] += from_corner / 3.0;
            }
            result.points.push(SurfacePoint::Face(crossed.face, weights));
        }
        let mut next_crossed = self.faces.iter().peekable();
        for f in mesh.faces() {
            let vertices = mesh.face_vertices(f);
            if next_crossed.peek().is_none_or(|c| c.face != f) {
                result.triangles.push(vertices.map(|v| v.0));
                result.triangle_faces.push(f);
                continue;
            }
            let Some(crossed) = next_crossed.next() else { continue };
            let points = self.face_points(mesh, frames, crossed);
            for (triangle, _) in points.triangles(crossed.lone) {
                result.triangles.push(triangle.map(|corner| match corner {
                    Corner::Vertex(i) => vertices[i].0,
                    Corner::Side(i) => base + crossed.crossings[i],
                    Corner::Centre => centre_base + crossed.centre,
                }));
                result.triangle_faces.push(f);
            }
        }
        result.cut_edges = self
            .segments
            .iter()
            .map(|s| {
                s.ends.map(|end| match end {
                    Node::Crossing(c) => base + c,
                    Node::Centre(c) => centre_base + c,
                })
            })
            .collect();
        result
    }
}

/// Places of corners, crossings and triple point of one face in its frame.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct FacePoints {
    pub corners: [Vector2<f64>; 3],
    pub sides: [Vector2<f64>; 3],
    pub centre: Vector2<f64>,
}

impl FacePoints {
    pub fn at(&self, corner: Corner) -> Vector2<f64> {
        match corner {
            Corner::Vertex(i) => self.corners[i],
            Corner::Side(i) => self.sides[i],
            Corner::Centre => self.centre,
        }
    }

    /// Area of a sub-triangle.
    pub fn area(&self, triangle: [Corner; 3]) -> f64 {
        let [a, b, c] = triangle.map(|corner| self.at(corner));
        0.5 * (b - a).perp(&(c - a))
    }

    /// The sub-triangles of a crossed face, counter-clockwise. The quadrilateral of a face with two labels is split by its
    /// Delaunay diagonal: of the two that gives the smaller Dirichlet energy, which is continuous where the diagonal changes.
    pub fn triangles(&self, lone: u8) -> SubTriangles {
        if lone == 3 {
            return self.spokes();
        }
        let (a, b, c, x, z) = around(lone);
        let (pb, pc, px, pz) = (self.corners[b], self.corners[c], self.at(x), self.at(z));
        // Angles at x and c face the diagonal b z; it is Delaunay if they sum to at most π.
        let turn = |o: Vector2<f64>, p: Vector2<f64>, q: Vector2<f64>| {
            let (p, q) = (p - o, q - o);
            (p.dot(&q), p.perp(&q))
        };
        let (cos_x, sin_x) = turn(px, pb, pz);
        let (cos_c, sin_c) = turn(pc, pz, pb);
        let [bz, xc] = halves(lone);
        // Evenly divided faces make exact ties, which rounding must not decide differently on different machines.
        let size = (cos_x.abs() + sin_x.abs()) * (cos_c.abs() + sin_c.abs());
        let quad = if sin_x * cos_c + cos_x * sin_c >= -1e-12 * size { bz } else { xc };
        let lone_triangle = [Corner::Vertex(a), x, z];
        let mut all = [(lone_triangle, 1.0); 6];
        all[1].0 = quad[0];
        all[2].0 = quad[1];
        SubTriangles { all, count: 3, next: 0 }
    }

    /// Triangles with weights for integrals of u and u²: the mean over both diagonals of the quadrilateral. With one diagonal
    /// alone these integrals, and J with them, would jump where the diagonal changes.
    pub fn weighted_triangles(&self, lone: u8) -> SubTriangles {
        if lone == 3 {
            return self.spokes();
        }
        let (a, _, _, x, z) = around(lone);
        let mut all = [([Corner::Vertex(a), x, z], 1.0); 6];
        for (i, triangle) in halves(lone).into_iter().flatten().enumerate() {
            all[1 + i] = (triangle, 0.5);
        }
        SubTriangles { all, count: 5, next: 0 }
    }

    /// The six triangles around a triple point.
    fn spokes(&self) -> SubTriangles {
        use Corner::{Centre, Side, Vertex};
        let mut all = [([Centre; 3], 1.0); 6];
        for a in 0..3 {
            all[2 * a].0 = [Vertex(a), Side(a), Centre];
            all[2 * a + 1].0 = [Vertex(a), Centre, Side((a + 2) % 3)];
        }
        SubTriangles { all, count: 6, next: 0 }
    }
}

/// The lone corner, the two others counter-clockwise, and the crossings on the sides after and before it.
fn around(lone: u8) -> (usize, usize, usize, Corner, Corner) {
    let a = lone as usize;
    (a, (a + 1) % 3, (a + 2) % 3, Corner::Side(a), Corner::Side((a + 2) % 3))
}

/// The two ways to split the quadrilateral x b c z: by b z and by x c.
fn halves(lone: u8) -> [[[Corner; 3]; 2]; 2] {
    let (_, b, c, x, z) = around(lone);
    let (b, c) = (Corner::Vertex(b), Corner::Vertex(c));
    [[[x, b, z], [b, c, z]], [[x, b, c], [x, c, z]]]
}

/// Up to six sub-triangles with their weights, without allocation.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct SubTriangles {
    all: [([Corner; 3], f64); 6],
    count: usize,
    next: usize,
}

impl Iterator for SubTriangles {
    type Item = ([Corner; 3], f64);

    fn next(&mut self) -> Option<Self::Item> {
        let item = (self.next < self.count).then(|| self.all[self.next]);
        self.next += 1;
        item
    }
}
