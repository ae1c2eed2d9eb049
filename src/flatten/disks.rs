//! What the baselines share: which patches can be flattened, and how places become charts of the right size.
//!
//! Every method here solves for places of all patches at once, in one system whose rows are vertices; patches without a chart stand
//! aside with rows of their own. Conformal maps have no size: each chart gets the area of its patch.

use nalgebra::Point2;

use super::{Flattening, NoChart, rims, small};
use crate::geometry::Geometry;
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh, VertexId};
use std::sync::Arc;

/// Smallest area ratio that a log scale is taken of: a chart that is a point there is as good as one of 1e-10 of its size.
const NO_AREA: f64 = 1e-20;

/// The patches of an opened mesh that are disks of usable faces.
pub(super) struct Disks<'a> {
    pub opened: &'a OpenedMesh,
    pub geometry: &'a Geometry,
    pub charts: Vec<Result<Vec<HalfedgeId>, NoChart>>,
    pub vertex_patches: &'a [u32],
}

impl<'a> Disks<'a> {
    pub fn new(opened: &'a OpenedMesh, geometry: &'a Geometry) -> Self {
        let mut charts = rims(opened);
        refuse_degenerate(opened, geometry, &mut charts);
        Self { opened, geometry, charts, vertex_patches: opened.vertex_patches() }
    }

    /// Whether a vertex belongs to a patch with a chart.
    pub fn is_in(&self, v: VertexId) -> bool {
        self.opened.mesh.halfedge(v).is_some()
            && self.charts[self.vertex_patches[v.index()] as usize].is_ok()
    }

    /// Whether a face belongs to a patch with a chart.
    pub fn has_face(&self, f: FaceId) -> bool {
        self.charts[self.opened.face_patches[f.index()] as usize].is_ok()
    }

    /// Takes the patch of a vertex at which its system breaks down out of the problem.
    pub fn break_down(&mut self, vertex: VertexId) {
        self.charts[self.vertex_patches[vertex.index()] as usize] =
            Err(NoChart::Singular { vertex });
    }

    /// Takes a patch out of the problem.
    pub fn give_up(&mut self, patch: u32) {
        let face = self.opened.face_patches.iter().position(|&p| p == patch).unwrap_or(0);
        self.charts[patch as usize] = Err(NoChart::Degenerate { face: FaceId::from(face) });
    }

    /// Factors the matrix that `assemble` makes. The patch of a row that is not positive definite (extreme slivers) is given up, and the
    /// others go on.
    ///
    /// **Takes** rows that belong to vertex `row % V`. **Gives** the factor and the values that it is of.
    pub fn factor(
        &mut self,
        assemble: impl Fn(&Self) -> (Pattern, Vec<f64>),
    ) -> Result<(Factor, Vec<f64>), LinalgError> {
        loop {
            let (pattern, values) = assemble(self);
            match Factor::new(Arc::new(Analysis::new(pattern)?), &values) {
                Err(LinalgError::NotPositiveDefinite { row }) => {
                    let v = VertexId::from(row % self.opened.mesh.vertex_count());
                    if !self.is_in(v) {
                        return Err(LinalgError::NotPositiveDefinite { row });
                    }
                    self.break_down(v);
                }
                result => return result.map(|factor| (factor, values)),
            }
        }
    }

    /// Charts from places: of the area of their patches, with log scales.
    ///
    /// **Takes** a place for every vertex of a chart, counter-clockwise up to flips. Charts whose places are not finite or have no positive
    /// area become [`NoChart::Degenerate`]. And the residual of the solve that gave them.
    pub fn finish(mut self, mut uv: Vec<Point2<f64>>, residual: f64) -> Flattening {
        let mesh = &self.opened.mesh;
        let mut flat = vec![0.0; self.charts.len()];
        let mut curved = vec![0.0; self.charts.len()];
        for f in mesh.faces().filter(|&f| self.has_face(f)) {
            let patch = self.opened.face_patches[f.index()] as usize;
            flat[patch] += signed_area(mesh.face_vertices(f).map(|v| uv[v.index()]));
            curved[patch] += self.geometry.face_areas[f.index()];
        }
        for patch in 0..self.charts.len() {
            let ratio: f64 = curved[patch] / flat[patch];
            if self.charts[patch].is_ok() && !(ratio > 0.0 && ratio.is_finite()) {
                self.give_up(small(patch));
            }
        }
        for v in mesh.vertices() {
            let patch = self.vertex_patches[v.index()] as usize;
            uv[v.index()] = if self.is_in(v) {
                uv[v.index()] * (curved[patch] / flat[patch]).sqrt()
            } else {
                Point2::new(f64::NAN, f64::NAN)
            };
        }
        let u = log_scales(self.opened, self.geometry, &uv);
        let charts = self.charts;
        Flattening::of_places(charts, uv, u, false, residual)
    }
}

/// Marks the charts that have a face without shape.
pub(super) fn refuse_degenerate(
    opened: &OpenedMesh,
    geometry: &Geometry,
    charts: &mut [Result<Vec<HalfedgeId>, NoChart>],
) {
    let mesh = &opened.mesh;
    for face in mesh.faces() {
        let cotangents = geometry.corner_cotangents[face.index()];
        let usable = cotangents.iter().all(|c| c.is_finite())
            && mesh.face_halfedges(face).iter().all(|h| geometry.edge_length(h.edge()) > 0.0);
        let chart = &mut charts[opened.face_patches[face.index()] as usize];
        if !usable && chart.is_ok() {
            *chart = Err(NoChart::Degenerate { face });
        }
    }
}

/// Log of the length ratio chart : surface at each vertex, from the areas of the faces around it, turned over or not; NaN without place.
pub(super) fn log_scales(opened: &OpenedMesh, geometry: &Geometry, uv: &[Point2<f64>]) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; uv.len()];
    for f in opened.mesh.faces() {
        let corners = opened.mesh.face_vertices(f);
        let flat = signed_area(corners.map(|v| uv[v.index()])).abs();
        for v in corners {
            sums[v.index()][0] += flat;
            sums[v.index()][1] += geometry.face_areas[f.index()];
        }
    }
    // `max` would turn NaN, which says that there is no place, into a number.
    let log = |[flat, curved]: [f64; 2]| {
        let ratio = flat / curved;
        0.5 * if ratio < NO_AREA { NO_AREA } else { ratio }.ln()
    };
    sums.into_iter().map(log).collect()
}

/// Signed area of a triangle.
pub(super) fn signed_area([a, b, c]: [Point2<f64>; 3]) -> f64 {
    0.5 * (b - a).perp(&(c - a))
}
