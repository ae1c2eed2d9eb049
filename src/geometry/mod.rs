//! Metric quantities of a triangulated surface: lengths, angles, areas, curvature, the cotan Laplacian.
//!
//! A metric is given by edge lengths; positions in space only serve to measure them and to draw. Everything that flattening
//! and cutting need is intrinsic and computed from lengths, so that it also works on metrics that live nowhere in space.
//!
//! Guaranteed: finite results for every [`Geometry`] that [`Geometry::new`] made, which refuses coordinates that are not
//! finite and triangles without area; [`Geometry::unit_area`] lets single ones through, whose normals are zero and whose
//! curvature is none. Not guaranteed: good conditioning; slivers give large cotangents, and [`without_slivers`] finds triangles
//! of the same surface that do not.

mod centre_line;
mod curvature;
mod distance;
pub mod doctor;
mod intrinsic;
mod laplacian;
mod nearest;
mod path;
pub mod polygon;
pub mod symmetry;
mod visibility;

use nalgebra::{Point3, Vector3};

use crate::mesh::{EdgeId, FaceId, HalfedgeId, Mesh, SurfacePoint, VertexId};

pub use centre_line::centre_lines;
pub use curvature::{angle_defects, angle_sums, face_curvatures};
pub use distance::{GeodesicFront, geodesic_distances, geodesic_distances_from};
pub use intrinsic::{Intrinsic, mollification, without_slivers};
pub use laplacian::Laplacian;
pub use nearest::{Hit, Nearest, closest};
pub use path::{SurfacePath, shortest_path};
pub use symmetry::{
    Symmetry, SymmetryError, SymmetryKind, SymmetryMap, find_symmetries, symmetry_group,
};
pub use visibility::visibility;

/// Why a surface has no usable metric.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// Coordinates that are NaN or infinite.
    #[error("{} vertices have coordinates that are not finite, the first is vertex {}", .vertices.len(), .vertices[0].0)]
    NotFinite {
        /// The vertices.
        vertices: Vec<VertexId>,
    },
    /// All points coincide, or the extent is too small or large to square.
    #[error("the surface has no extent that can be computed with")]
    NoExtent,
    /// Triangles whose corners lie on a line.
    #[error("{} faces have no area, the first is face {}", .faces.len(), .faces[0].0)]
    DegenerateFaces {
        /// The triangles.
        faces: Vec<FaceId>,
    },
}

/// A surface in space with the lengths, angles and areas that everything else is made of.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// Vertex positions.
    pub positions: Vec<Point3<f64>>,
    /// Length of every edge.
    pub edge_lengths: Vec<f64>,
    /// Area of every face.
    pub face_areas: Vec<f64>,
    /// Angle at every corner of every face, radians.
    pub corner_angles: Vec<[f64; 3]>,
    /// Cotangent of the angle at every corner of every face.
    pub corner_cotangents: Vec<[f64; 3]>,
}

/// How a model was moved and scaled to unit area about the origin: `model = centre + unit / scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitFrame {
    /// Centre of the bounding box, in model units.
    pub centre: Point3<f64>,
    /// Unit-area length per model length.
    pub scale: f64,
}

/// Height of a triangle over its longest side below which it has no area: angles there are rounding noise.
pub const FLAT: f64 = 1e-12;

impl Geometry {
    /// Measures a surface. Isolated vertices may lie anywhere.
    ///
    /// **Fails** on coordinates that are not finite and on faces without area (height below [`FLAT`] of the longest side). **Costs** O(V + F).
    pub fn new(mesh: &Mesh, positions: Vec<Point3<f64>>) -> Result<Self, GeometryError> {
        assert_eq!(positions.len(), mesh.vertex_count());
        check_finite(mesh, |v| positions[v.index()].iter().all(|x| x.is_finite()))?;
        let geometry = Self::measure(mesh, positions);
        let longest = geometry.edge_lengths.iter().fold(0.0, |m: f64, &l| m.max(l));
        if !(longest > 1e-100 && longest < 1e100) {
            return Err(GeometryError::NoExtent);
        }
        let degenerate: Vec<FaceId> = mesh
            .faces()
            .filter(|&f| {
                let side = |h: HalfedgeId| geometry.edge_length(h.edge());
                let longest = mesh.face_halfedges(f).map(side).into_iter().fold(0.0, f64::max);
                !(2.0 * geometry.face_areas[f.index()] > FLAT * longest * longest)
            })
            .collect();
        if !degenerate.is_empty() {
            return Err(GeometryError::DegenerateFaces { faces: degenerate });
        }
        Ok(geometry)
    }

    /// Measures the pieces of a cut surface: slivers are legal there, so nothing is refused.
    ///
    /// Angles and cotangents come from positions, because side lengths alone lose half the digits of a flat triangle's
    /// height. A face flatter than 1e-8 of its longest side gets the cotangents of that height: larger ones would cost the
    /// Laplacian more digits than the sliver's shape is worth; scaling a face's cotangents keeps the Laplacian semi-definite.
    ///
    /// **Gives** finite values unless a position is not finite; a side of length 0 makes angles that do not sum to π.
    /// **Costs** O(V + F).
    pub fn measure(mesh: &Mesh, positions: Vec<Point3<f64>>) -> Self {
        Self::measure_parts(mesh, positions, |_| None)
    }

    /// The same for a refinement of a surface that was measured so: faces that were not divided are not measured again.
    ///
    /// **Takes** for each face the face of `whole` with the same corners in the same order, where there is one.
    pub fn measure_refined(
        mesh: &Mesh,
        positions: Vec<Point3<f64>>,
        whole: &Self,
        same: impl Fn(FaceId) -> Option<FaceId>,
    ) -> Self {
        Self::measure_parts(mesh, positions, |f| {
            let f = same(f)?.index();
            Some((whole.face_areas[f], whole.corner_angles[f], whole.corner_cotangents[f]))
        })
    }

    fn measure_parts(
        mesh: &Mesh,
        positions: Vec<Point3<f64>>,
        known: impl Fn(FaceId) -> Option<(f64, [f64; 3], [f64; 3])>,
    ) -> Self {
        assert_eq!(positions.len(), mesh.vertex_count());
        let edge_lengths = mesh
            .edges()
            .map(|e| {
                let [a, b] = mesh.edge_vertices(e);
                (positions[a.index()] - positions[b.index()]).norm()
            })
            .collect();
        let mut face_areas = Vec::with_capacity(mesh.face_count());
        let mut corner_angles = Vec::with_capacity(mesh.face_count());
        let mut corner_cotangents = Vec::with_capacity(mesh.face_count());
        for (f, &vertices) in mesh.triangles().iter().enumerate() {
            if let Some((area, angles, cotangents)) = known(FaceId::from(f)) {
                face_areas.push(area);
                corner_angles.push(angles);
                corner_cotangents.push(cotangents);
                continue;
            }
            let [a, b, c] = vertices.map(|v| positions[v.index()]);
            let sides = [b - a, c - b, a - c];
            let doubled = sides[0].cross(&sides[1]).norm();
            let longest =
                sides.iter().fold(f64::MIN_POSITIVE, |m, side| m.max(side.norm_squared()));
            let dots = [0, 1, 2].map(|i| -sides[i].dot(&sides[(i + 2) % 3]));
            face_areas.push(0.5 * doubled);
            corner_angles.push(dots.map(|dot| doubled.atan2(dot)));
            corner_cotangents.push(dots.map(|dot| dot / doubled.max(1e-8 * longest)));
        }
        Self { positions, edge_lengths, face_areas, corner_angles, corner_cotangents }
    }

    /// The metric that edge lengths give; positions only go along with it.
    ///
    /// **Takes** lengths that satisfy the triangle inequality. **Costs** O(V + F).
    pub fn from_lengths(mesh: &Mesh, positions: Vec<Point3<f64>>, edge_lengths: Vec<f64>) -> Self {
        assert_eq!(edge_lengths.len(), mesh.edge_count());
        let mut face_areas = Vec::with_capacity(mesh.face_count());
        let mut corner_angles = Vec::with_capacity(mesh.face_count());
        let mut corner_cotangents = Vec::with_capacity(mesh.face_count());
        for f in mesh.faces() {
            let sides = mesh.face_halfedges(f).map(|h| edge_lengths[h.edge().index()]);
            let (angles, area) = intrinsic::angles_of(sides);
            face_areas.push(area);
            corner_angles.push(angles);
            corner_cotangents.push([0, 1, 2].map(|i| {
                let (next, prev, far) = (sides[i], sides[(i + 2) % 3], sides[(i + 1) % 3]);
                (next * next + prev * prev - far * far) / (4.0 * area)
            }));
        }
        Self { positions, edge_lengths, face_areas, corner_angles, corner_cotangents }
    }

    /// Measures a surface after moving its bounding box to the origin and scaling it to area 1.
    ///
    /// The scale is found in two stages so that neither areas of 1e-100 nor coordinates of 1e9 lose digits. Single faces
    /// without area are let through, with the clamped cotangents of [`Geometry::measure`]: see [`without_slivers`].
    /// **Fails** on coordinates that are not finite, without extent, and where no face has an area.
    pub fn unit_area(
        mesh: &Mesh,
        positions: &[[f64; 3]],
    ) -> Result<(Self, UnitFrame), GeometryError> {
        check_finite(mesh, |v| positions[v.index()].iter().all(|x| x.is_finite()))?;
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
            let p = Vector3::from(positions[v.index()]);
            low = low.inf(&p);
            high = high.sup(&p);
        }
        let extent = (high - low).max();
        if !(extent > 1e-100 && extent < 1e100) {
            return Err(GeometryError::NoExtent);
        }
        let centre = (low + high) / 2.0;
        let place = |scale: f64| -> Vec<Point3<f64>> {
            positions.iter().map(|&p| Point3::from((Vector3::from(p) - centre) * scale)).collect()
        };
        let boxed = place(1.0 / extent);
        let mut area = 0.0;
        let mut all_flat = true;
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|v| boxed[v.index()]);
            let sides = [b - a, c - b, a - c];
            let doubled = sides[0].cross(&sides[1]).norm();
            let longest = sides.iter().fold(0.0, |m: f64, side| m.max(side.norm_squared()));
            all_flat &= !(doubled > FLAT * longest);
            area += 0.5 * doubled;
        }
        if all_flat {
            return Err(GeometryError::DegenerateFaces { faces: mesh.faces().collect() });
        }
        let scale = 1.0 / (extent * area.sqrt());
        Ok((Self::measure(mesh, place(scale)), UnitFrame { centre: Point3::from(centre), scale }))
    }

    /// Sum of the face areas.
    pub fn total_area(&self) -> f64 {
        self.face_areas.iter().sum()
    }

    /// Mean of the edge lengths, the yardstick of steps and widths.
    pub fn mean_edge_length(&self) -> f64 {
        self.edge_lengths.iter().sum::<f64>() / self.edge_lengths.len() as f64
    }

    /// Length of an edge.
    #[inline]
    pub fn edge_length(&self, e: EdgeId) -> f64 {
        self.edge_lengths[e.index()]
    }

    /// Unit normals of the faces; zero for faces without area.
    pub fn face_normals(&self, mesh: &Mesh) -> Vec<Vector3<f64>> {
        mesh.triangles()
            .iter()
            .map(|&[a, b, c]| {
                let [a, b, c] = [a, b, c].map(|v| self.positions[v.index()]);
                let normal = (b - a).cross(&(c - a));
                let length = normal.norm();
                if length > 0.0 { normal / length } else { Vector3::zeros() }
            })
            .collect()
    }

    /// Unit normals of the vertices: mean of the face normals weighted by corner angle; z at isolated vertices.
    pub fn vertex_normals(&self, mesh: &Mesh) -> Vec<Vector3<f64>> {
        let mut normals = vec![Vector3::zeros(); mesh.vertex_count()];
        for (f, normal) in self.face_normals(mesh).into_iter().enumerate() {
            let corners = mesh.face_vertices(FaceId::from(f)).into_iter();
            for (v, angle) in corners.zip(self.corner_angles[f]).filter(|_| normal.norm() > 0.0) {
                normals[v.index()] += normal * angle;
            }
        }
        for normal in &mut normals {
            // Not `<=`: angles of faces without area may be anything but finite.
            let length = normal.norm();
            *normal = if length > 1e-300 { *normal / length } else { Vector3::z() };
        }
        normals
    }

    /// A third of the area of the faces at each vertex.
    pub fn vertex_dual_areas(&self, mesh: &Mesh) -> Vec<f64> {
        let mut areas = vec![0.0; mesh.vertex_count()];
        for (f, vertices) in mesh.triangles().iter().enumerate() {
            for v in vertices {
                areas[v.index()] += self.face_areas[f] / 3.0;
            }
        }
        areas
    }

    /// Where a point of the surface lies in space.
    pub fn locate(&self, mesh: &Mesh, point: SurfacePoint) -> Point3<f64> {
        match point {
            SurfacePoint::Vertex(v) => self.positions[v.index()],
            SurfacePoint::Edge(e, t) => {
                let [a, b] = mesh.edge_vertices(e).map(|v| self.positions[v.index()]);
                a + (b - a) * t
            }
            SurfacePoint::Face(f, weights) => {
                let corners = mesh.face_vertices(f).map(|v| self.positions[v.index()].coords);
                Point3::from(
                    corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2],
                )
            }
        }
    }
}

/// Names the vertices whose coordinates are not finite.
fn check_finite(mesh: &Mesh, is_finite: impl Fn(VertexId) -> bool) -> Result<(), GeometryError> {
    let vertices: Vec<VertexId> = mesh.vertices().filter(|&v| !is_finite(v)).collect();
    if vertices.is_empty() { Ok(()) } else { Err(GeometryError::NotFinite { vertices }) }
}
