//! From patches to charts: flat pieces, how far they are from isometric, and where they lie on a sheet.
//!
//! A patch is a surface with boundary in space, a *chart* its image in the plane. [`bff`] flattens every patch of an opened
//! mesh at once with as little stretching of the rims as conformality allows, [`bff_scaled`] with given scale factors there, so that
//! cones on seams get exact angles; [`measures`] says what the result is worth;
//! [`conformal`] takes exact angles for granted and never turns a face over; [`targets`] makes rims what they are told to be, and closed
//! surfaces spheres; [`lscm`] and [`abf`] are the baselines of the papers, [`fixed`] fills given rims in, [`isometric`] refines charts
//! towards true lengths; [`overlap`] finds where outlines cross and triangles overlap, [`validity`] what is wrong with charts, and
//! [`split`] cuts those that overlap themselves; [`atlas`] makes overlapping charts of a partition of unity; [`pack`] lays the charts side by side; [`fold`] sews them together again in space.
//!
//! Guaranteed: seam partners are equally long in both charts ([`Flattening::seams_equal`]); charts are counter-clockwise.
//! Not guaranteed by flattening: freedom from flips and overlaps, which are counted exactly and never hidden.
//!
//! Everything here is unitless: charts have the unit of the positions that they were made from.

pub mod abf;
pub mod atlas;
pub mod bff;
mod closing;
pub mod comparison;
pub mod conformal;
mod disks;
pub mod fixed;
pub mod fold;
pub mod isometric;
pub mod lpfb;
pub mod lscm;
pub mod measures;
pub mod merging;
pub mod overlap;
pub mod pack;
pub mod split;
pub mod targets;
pub mod validity;

use nalgebra::{Point2, Vector2};

use crate::mesh::{FaceId, HalfedgeId, OpenedMesh, VertexId};

pub use abf::abf;
pub use atlas::{Atlas, AtlasMethod, AtlasParams, largest_weights};
pub use bff::{bff, bff_scaled, bff_with};
pub use fixed::fixed_rim;
pub use fold::{FoldFlow, FoldParams};
pub use isometric::{IsometricFlow, IsometricParams};
pub use lpfb::{LpfbReport, lpfb};
pub use lscm::{dcp, lscm};
pub use measures::{ChartMeasures, Measures, measure};
pub use pack::{Packing, Pose, Shape, pack};
pub use split::{Flip, Flips, Split, SplitParams, split_overlaps};
pub use targets::{
    Interior, RimTarget, SphereMap, TargetChart, TargetError, TargetSolver, flatten_sphere,
};
pub use validity::{ChartValidity, FacePair, Validity, validate};

/// Why a patch has no chart.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoChart {
    /// Only disks can be flattened; this patch has another shape.
    #[error("the patch is no disk (Euler characteristic {euler}, {boundary_loops} boundary loops)")]
    NotADisk {
        /// V − E + F of the patch.
        euler: i64,
        /// Number of boundary loops.
        boundary_loops: usize,
    },
    /// A face has a side of length 0 or coordinates that are not finite, or is part of a system that cannot be solved.
    #[error("face {} of the cut surface has no usable shape", .face.0)]
    Degenerate {
        /// The face, of the opened mesh.
        face: FaceId,
    },
    /// The system of the patch broke down: elimination met a pivot that is not positive, or places are no numbers.
    #[error("the equations of the patch break down at vertex {} of the cut surface: triangles about it are too thin", .vertex.0)]
    Singular {
        /// The vertex, of the opened mesh.
        vertex: VertexId,
    },
    /// Nobody has asked for it yet.
    #[error("the chart waits until the cut rests")]
    Waiting,
    /// No flat metric with the angles asked for was found.
    #[error("no flat metric was found: angles are off by {angle_error} still")]
    NotConverged {
        /// What was reached: the largest error of an angle sum, radians.
        angle_error: f64,
    },
}

/// Charts of the patches of an opened mesh, each in a frame of its own.
#[derive(Clone, Debug)]
pub struct Flattening {
    /// For each patch its rim, or why it has no chart. The rim is counter-clockwise, by halfedges inside faces.
    pub charts: Vec<Result<Vec<HalfedgeId>, NoChart>>,
    /// Place of every vertex in its chart; NaN without chart.
    pub uv: Vec<Point2<f64>>,
    /// Log of the length ratio chart : surface that the method aimed at, as given on rims (0 if nothing was); NaN without chart.
    pub u: Vec<f64>,
    /// Whether seam partners are equally long. False where the charts could only be closed each for itself.
    pub seams_equal: bool,
    /// Whether the angles about points on seams are those of u (see [`bff_scaled`]). Never with isometric rims ([`bff`]), where
    /// curvature is left all along the seams.
    pub angles_exact: bool,
    /// By how much rims had to give way to be closed: the largest log ratio of lengths or turn of a direction, radians, where partners
    /// closed together; 0 where nothing had to.
    pub closing: f64,
    /// Largest relative residual of the linear solves that gave the places ([`crate::linalg::Factor::solve_measured`]); 0 where there are none, or
    /// where another measure says how good they are.
    pub residual: f64,
}

impl Flattening {
    /// No charts: for a cut that moves on at once.
    pub fn waiting(opened: &OpenedMesh) -> Self {
        let count = opened.mesh.vertex_count();
        Self {
            charts: vec![Err(NoChart::Waiting); opened.patch_count],
            uv: vec![Point2::new(f64::NAN, f64::NAN); count],
            u: vec![f64::NAN; count],
            seams_equal: true,
            angles_exact: false,
            closing: 0.0,
            residual: 0.0,
        }
    }

    /// Charts of given places, whose rims were neither closed nor follow a cone metric.
    fn of_places(
        charts: Vec<Result<Vec<HalfedgeId>, NoChart>>,
        uv: Vec<Point2<f64>>,
        u: Vec<f64>,
        seams_equal: bool,
        residual: f64,
    ) -> Self {
        Self { charts, uv, u, seams_equal, angles_exact: false, closing: 0.0, residual }
    }

    /// The outline of a chart, counter-clockwise; empty without chart.
    pub fn outline(&self, opened: &OpenedMesh, patch: usize) -> Vec<Point2<f64>> {
        let rim = self.charts[patch].as_deref().unwrap_or_default();
        rim.iter().map(|&h| self.uv[opened.mesh.tail(h).index()]).collect()
    }

    /// Number of faces that are turned over or have no area in the plane, by exact predicates.
    pub fn flipped(&self, opened: &OpenedMesh) -> usize {
        let is_flipped = |f: &FaceId| {
            let [a, b, c] = validity::face_places(opened, &self.uv, *f);
            a.x.is_finite() && !(overlap::orientation(a, b, c) > 0.0)
        };
        opened.mesh.faces().filter(is_flipped).count()
    }

    /// Lays the copies of a point on a seam on each other where they are no farther apart than that: both sides of a slit in a flat
    /// part then run along the very same line, instead of crossing each other within rounding.
    pub fn close_slits(&mut self, opened: &OpenedMesh, distance: f64) {
        let mesh = &opened.mesh;
        let patches = opened.vertex_patches();
        let mut first: Vec<usize> = (0..self.uv.len()).collect();
        let root = |first: &[usize], mut v: usize| {
            while first[v] != v {
                v = first[v];
            }
            v
        };
        for rim in self.charts.iter().flatten() {
            for &h in rim {
                let Some(partner) = opened.partner(h) else { continue };
                let pairs = [(mesh.tail(h), mesh.tip(partner)), (mesh.tip(h), mesh.tail(partner))];
                for (a, b) in pairs {
                    let [a, b] = [a, b].map(|v| root(&first, v.index()));
                    // Charts of different patches lie in frames of their own.
                    let is_one = patches[a] == patches[b];
                    if a != b && is_one && (self.uv[a] - self.uv[b]).norm() <= distance {
                        first[a.max(b)] = a.min(b);
                    }
                }
            }
        }
        for v in 0..first.len() {
            self.uv[v] = self.uv[root(&first, v)];
        }
    }

    /// Lays the charts out on a sheet.
    ///
    /// **Takes** the number of the surface's own vertices: opened vertices below it keep their names while a cut moves, and
    /// hold the layout still from one picture to the next (see [`pack`]); the gap between charts; the last layout, if any.
    /// **Gives** one pose for each patch (the identity without chart).
    pub fn pack(
        &self,
        opened: &OpenedMesh,
        own_vertices: usize,
        gap: f64,
        previous: Option<&Packing>,
    ) -> Packing {
        let patch_count = self.charts.len();
        let outlines: Vec<_> = (0..patch_count).map(|p| self.outline(opened, p)).collect();
        let patches = opened.vertex_patches();
        let mut counts = vec![0; patch_count];
        for &patch in patches.iter().take(own_vertices) {
            counts[patch as usize] += 1;
        }
        let mut landmarks: Vec<_> = counts.into_iter().map(Vec::with_capacity).collect();
        for (v, place) in self.uv.iter().enumerate().take(own_vertices) {
            if place.x.is_finite() {
                landmarks[patches[v] as usize].push((small(v), *place));
            }
        }
        let shapes: Vec<Shape> = outlines
            .iter()
            .zip(&landmarks)
            .map(|(outline, landmarks)| Shape { outline, landmarks })
            .collect();
        pack(&shapes, gap, previous)
    }

    /// Place of every vertex on the sheet of a layout; NaN without chart.
    pub fn place(&self, opened: &OpenedMesh, packing: &Packing) -> Vec<Point2<f64>> {
        let turns: Vec<_> = packing.poses.iter().map(Pose::turn).collect();
        let place = |(&p, &i): (&Point2<f64>, &u32)| {
            turns[i as usize] * p + packing.poses[i as usize].shift
        };
        self.uv.iter().zip(opened.vertex_patches()).map(place).collect()
    }
}

/// The rim of every patch that is a disk, counter-clockwise, by halfedges inside faces.
pub fn rims(opened: &OpenedMesh) -> Vec<Result<Vec<HalfedgeId>, NoChart>> {
    let mesh = &opened.mesh;
    let mut rims: Vec<_> = opened
        .patch_shapes()
        .into_iter()
        .map(|shape| match shape {
            (1, 1) => Ok(Vec::new()),
            (euler, boundary_loops) => Err(NoChart::NotADisk { euler, boundary_loops }),
        })
        .collect();
    for &start in mesh.boundary_loops() {
        let Some(face) = mesh.face(start.twin()) else { continue };
        if let Ok(rim) = &mut rims[opened.face_patches[face.index()] as usize] {
            // Boundary loops run clockwise, outside.
            rim.extend(mesh.boundary_loop(start).map(HalfedgeId::twin));
            rim.reverse();
        }
    }
    rims
}

/// An index as a `u32`: meshes number fewer elements than that.
#[expect(clippy::cast_possible_truncation, reason = "Mesh::new refuses larger meshes")]
fn small(index: usize) -> u32 {
    index as u32
}

/// A quarter turn counter-clockwise.
fn turned(v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}
