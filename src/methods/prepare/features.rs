//! Lines that must stay: which edges they are, and curves to slide along.
//!
//! A *feature edge* lies on the boundary, on a seam of the texture, between materials or groups, or its faces meet at a sharp angle.
//! Feature edges form a graph. Its *corners*, where not two of them meet or a line turns sharply, must stay where they are; between
//! corners run *curves*, each a polyline with its arc length. A point on a curve is told by its arc length alone, so that what
//! slides along a feature is on it exactly, and which side a face lies on stays known.
//!
//! Guaranteed: both ends of a curve are corners, and not the same one (closed lines get up to three corners of their own), so that
//! an edge of a new mesh along a curve stands for one stretch of it only.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::{Point3, Vector3};

use super::{NONE, Surface};
use crate::mesh::{EdgeId, HalfedgeId, Mesh, VertexId};

/// Why an edge must stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Feature {
    /// It need not.
    None,
    /// Its faces meet at a sharp angle.
    Sharp,
    /// Boundary, seam of the texture, or between materials or groups.
    Hard,
}

/// Sorts the edges of a surface. `angle` is the largest turn of the normal across an edge that counts as smooth.
pub(super) fn feature_edges(surface: &Surface, angle: f64) -> Vec<Feature> {
    let mesh = &surface.mesh;
    let attributes = &surface.attributes;
    let normals: Vec<Vector3<f64>> = surface
        .face_vectors()
        .into_iter()
        .map(|v| v.try_normalize(0.0).filter(|n| n.x.is_finite()).unwrap_or_default())
        .collect();
    let differ = |list: &[u32], f: usize, g: usize| !list.is_empty() && list[f] != list[g];
    // The texture coordinates at both ends of a halfedge, in its own face.
    let ends = |h: HalfedgeId, f: usize| {
        let uvs = attributes.corner_uvs[f];
        let face = mesh.face_vertices(f.into());
        let at = |v: VertexId| face.iter().zip(uvs).find(|(w, _)| **w == v).and_then(|(_, uv)| uv);
        [at(mesh.tail(h)), at(mesh.tip(h))]
    };
    let is_seam = |h: HalfedgeId, f: usize, g: usize| {
        if attributes.corner_uvs.is_empty() {
            return false;
        }
        let ([a, b], [c, d]) = (ends(h, f), ends(h.twin(), g));
        a != d || b != c
    };
    mesh.edges()
        .map(|e| {
            let h = e.halfedge();
            let (Some(f), Some(g)) = (mesh.face(h), mesh.face(h.twin())) else {
                return Feature::Hard;
            };
            let (f, g) = (f.index(), g.index());
            if differ(&attributes.face_groups, f, g)
                || differ(&attributes.face_materials, f, g)
                || is_seam(h, f, g)
            {
                return Feature::Hard;
            }
            // A face without area turns nothing.
            let (m, n) = (normals[f], normals[g]);
            let turn = m.cross(&n).norm().atan2(m.dot(&n));
            let measured = m != Vector3::zeros() && n != Vector3::zeros();
            if measured && turn > angle { Feature::Sharp } else { Feature::None }
        })
        .collect()
}

/// Fewer sharp edges than this in one connected bunch, without any other feature, are noise of a scan. They would only pin vertices:
/// on a scanned hand the smallest angle falls from 37° to 21°.
const BUNCH: usize = 5;

/// Which edges are features, small bunches left out.
fn lasting(mesh: &Mesh, features: &[Feature]) -> Vec<bool> {
    let mut is_feature: Vec<bool> = features.iter().map(|f| *f != Feature::None).collect();
    let mut seen = vec![false; features.len()];
    for seed in mesh.edges().filter(|e| features[e.index()] != Feature::None) {
        let mut bunch = vec![seed];
        let mut next = 0;
        if std::mem::replace(&mut seen[seed.index()], true) {
            continue;
        }
        while let Some(&e) = bunch.get(next) {
            next += 1;
            for h in mesh.edge_vertices(e).into_iter().flat_map(|v| mesh.outgoing(v)) {
                let e = h.edge();
                if features[e.index()] != Feature::None
                    && !std::mem::replace(&mut seen[e.index()], true)
                {
                    bunch.push(e);
                }
            }
        }
        if bunch.len() < BUNCH && bunch.iter().all(|e| features[e.index()] == Feature::Sharp) {
            for e in bunch {
                is_feature[e.index()] = false;
            }
        }
    }
    is_feature
}

/// A polyline of feature edges between two corners.
pub(super) struct Curve {
    /// Vertices of the given surface, in order.
    pub vertices: Vec<u32>,
    points: Vec<Point3<f64>>,
    arcs: Vec<f64>,
    /// For each segment the given surface's faces on its left and right, `NONE` outside.
    faces: Vec<[u32; 2]>,
}

impl Curve {
    /// Length of the whole.
    pub fn length(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }

    /// The segment at an arc length, and how far along it.
    pub fn segment(&self, arc: f64) -> (usize, f64) {
        let last = self.faces.len() - 1;
        let i = self.arcs.partition_point(|&a| a <= arc).saturating_sub(1).min(last);
        let t = (arc - self.arcs[i]) / (self.arcs[i + 1] - self.arcs[i]);
        (i, if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 })
    }

    /// The point at an arc length.
    pub fn at(&self, arc: f64) -> Point3<f64> {
        let (i, t) = self.segment(arc);
        let (a, b) = (self.points[i], self.points[i + 1]);
        if t >= 1.0 { b } else { a + (b - a) * t }
    }

    /// The face of the given surface on the left or right of a segment.
    pub fn face(&self, segment: usize, is_left: bool) -> Option<u32> {
        Some(self.faces[segment][usize::from(!is_left)]).filter(|&f| f != NONE)
    }

    /// The arc length of one of the two corners.
    pub fn end(&self, v: u32) -> f64 {
        if v == self.vertices[0] { 0.0 } else { self.length() }
    }
}

/// Where a vertex may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// Anywhere on the surface. The face of the given surface that it was last seen on, or near.
    Free(u32),
    /// Along a curve: its number and the arc length.
    Curve(u32, f64),
    /// Nowhere.
    Corner,
}

/// All curves of a surface.
pub(super) struct Features {
    /// The curves.
    pub curves: Vec<Curve>,
    /// For each edge its curve, `NONE` for ordinary ones.
    pub edge_curves: Vec<u32>,
    /// For each vertex where it may go.
    pub places: Vec<Place>,
}

impl Features {
    /// Chains the feature edges.
    pub fn new(surface: &Surface, angle: f64) -> Self {
        let mesh = &surface.mesh;
        let is_feature = lasting(mesh, &feature_edges(surface, angle));
        let place_of = |v: VertexId| surface.positions[v.index()];
        let lines = |v: VertexId| -> Vec<HalfedgeId> {
            mesh.outgoing(v).filter(|h| is_feature[h.edge().index()]).collect()
        };
        let is_corner: Vec<bool> = mesh
            .vertices()
            .map(|v| match lines(v)[..] {
                [] => false,
                [a, b] => {
                    let along = |h: HalfedgeId| place_of(mesh.tip(h)) - place_of(v);
                    let (u, w) = (-along(a), along(b));
                    u.cross(&w).norm().atan2(u.dot(&w)) > angle
                }
                _ => true,
            })
            .collect();
        let places = mesh
            .vertices()
            .map(|v| match mesh.outgoing(v).find_map(|h| mesh.face(h)) {
                Some(f) if !is_corner[v.index()] => Place::Free(f.0),
                _ => Place::Corner,
            })
            .collect();
        let mut features =
            Self { curves: Vec::new(), edge_curves: vec![NONE; mesh.edge_count()], places };
        let walk = |start: HalfedgeId| {
            let mut chain = vec![start];
            let mut h = start;
            while !is_corner[mesh.tip(h).index()] {
                let ahead = lines(mesh.tip(h)).into_iter().find(|&n| n != h.twin());
                match ahead {
                    Some(next) if next != start => h = next,
                    _ => break,
                }
                chain.push(h);
            }
            chain
        };
        let from_corners = mesh.vertices().filter(|&v| is_corner[v.index()]).flat_map(lines);
        // Then what is left: closed lines without a corner.
        let all = mesh.edges().filter(|e| is_feature[e.index()]).map(EdgeId::halfedge);
        for start in from_corners.chain(all) {
            if features.edge_curves[start.edge().index()] == NONE {
                features.add(surface, &walk(start));
            }
        }
        features
    }

    /// Takes a chain over, a closed one in up to three parts.
    fn add(&mut self, surface: &Surface, chain: &[HalfedgeId]) {
        let mesh = &surface.mesh;
        let (first, last) = (chain[0], chain[chain.len() - 1]);
        let parts = if mesh.tail(first) == mesh.tip(last) { 3 } else { 1 };
        let mut ends = Vec::new();
        for chain in chain.chunks(chain.len().div_ceil(parts)) {
            let curve = self.curves.len() as u32;
            let mut vertices = vec![mesh.tail(chain[0]).0];
            vertices.extend(chain.iter().map(|&h| mesh.tip(h).0));
            let points: Vec<Point3<f64>> =
                vertices.iter().map(|&v| surface.positions[v as usize]).collect();
            let mut arcs = vec![0.0];
            let mut arc = 0.0;
            for pair in points.windows(2) {
                arc += (pair[1] - pair[0]).norm();
                arcs.push(arc);
            }
            for (&v, &arc) in vertices.iter().zip(&arcs) {
                self.places[v as usize] = Place::Curve(curve, arc);
            }
            let face = |h: HalfedgeId| mesh.face(h).map_or(NONE, |f| f.0);
            let faces = chain.iter().map(|&h| [face(h), face(h.twin())]).collect();
            for h in chain {
                self.edge_curves[h.edge().index()] = curve;
            }
            // The ends last: a neighbouring part must not take them for inner points.
            ends.extend([vertices[0], vertices[vertices.len() - 1]]);
            self.curves.push(Curve { vertices, points, arcs, faces });
        }
        for v in ends {
            self.places[v as usize] = Place::Corner;
        }
    }
}
