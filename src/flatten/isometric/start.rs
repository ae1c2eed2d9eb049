//! Injective starts: given charts without flips as they are, others from a disk.

use std::f64::consts::TAU;

use nalgebra::{Complex, Point2};

use super::face::Face;
use crate::flatten::fixed::{Interior, fixed_rim};
use crate::flatten::overlap::orientation;
use crate::flatten::{Flattening, NoChart};
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{OpenedMesh, VertexId};

/// What the refinement of a patch began with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// The given chart.
    Given,
    /// The given chart had flips: its rim was laid on a circle by its lengths, and the interior filled in by mean values.
    Disk {
        /// Flips of the given chart.
        flipped: usize,
    },
    /// The given chart has flips, and in double precision the disk has some too (slivers): it stays as it was given.
    Refused {
        /// Flips of the given chart.
        flipped: usize,
    },
    /// There is no chart to refine.
    NoChart(NoChart),
}

impl Start {
    /// Whether the chart takes part.
    pub fn is_refined(self) -> bool {
        matches!(self, Self::Given | Self::Disk { .. })
    }
}

/// Places to start from, and what each patch's are.
pub(super) fn starts(
    opened: &OpenedMesh,
    geometry: &Geometry,
    given: &Flattening,
    rest: impl Fn(usize) -> Face,
) -> Result<(Vec<Point2<f64>>, Vec<Start>), LinalgError> {
    let mesh = &opened.mesh;
    let patches = opened.vertex_patches();
    let flipped = flips(opened, &given.uv);
    let mut uv = given.uv.clone();
    let mut starts: Vec<Start> = (0..opened.patch_count)
        .map(|p| match (&given.charts[p], flipped[p]) {
            (Err(reason), _) => Start::NoChart(*reason),
            (Ok(_), 0) => Start::Given,
            (Ok(_), flipped) => Start::Disk { flipped },
        })
        .collect();
    if !starts.iter().any(|s| matches!(s, Start::Disk { .. })) {
        return Ok((uv, starts));
    }
    // Rims of all other patches stay nowhere, which keeps those out of the system.
    let mut circles = vec![Point2::new(f64::NAN, f64::NAN); uv.len()];
    for (p, rim) in given.charts.iter().enumerate() {
        let (Start::Disk { .. }, Ok(rim)) = (starts[p], rim) else { continue };
        let lengths: Vec<f64> = rim.iter().map(|h| geometry.edge_length(h.edge())).collect();
        let total: f64 = lengths.iter().sum();
        let mut walked = 0.0;
        for (&h, length) in rim.iter().zip(&lengths) {
            let (sin, cos) = (TAU * walked / total).sin_cos();
            circles[mesh.tail(h).index()] = Point2::new(cos, sin) * (total / TAU);
            walked += length;
        }
    }
    let disks = fixed_rim(opened, geometry, &circles, &[Interior::MeanValue])?;
    for p in 0..starts.len() {
        if let Start::Disk { flipped } = starts[p]
            && (disks.interiors[p].is_none() || disks.flipped[p] > 0)
        {
            starts[p] = Start::Refused { flipped };
        }
    }
    // The size at which Σ (σ₁² + σ₂²) s² + (σ₁⁻² + σ₂⁻²) s⁻² is least.
    let mut sums = vec![[0.0; 2]; starts.len()];
    let places: Vec<_> = disks.uv.iter().map(|p| Complex::new(p.x, p.y)).collect();
    for f in mesh.faces() {
        let p = opened.face_patches[f.index()] as usize;
        if matches!(starts[p], Start::Disk { .. }) {
            let face = rest(f.index());
            for s in face.singular_values(&places) {
                sums[p][0] += face.weight * s * s;
                sums[p][1] += face.weight / (s * s);
            }
        }
    }
    for v in mesh.vertices() {
        let p = patches[v.index()] as usize;
        if matches!(starts[p], Start::Disk { .. }) && mesh.halfedge(v).is_some() {
            uv[v.index()] = disks.uv[v.index()] * (sums[p][1] / sums[p][0]).powf(0.25);
        }
    }
    // Scaling may round.
    for (p, count) in flips(opened, &uv).into_iter().enumerate() {
        if let Start::Disk { flipped } = starts[p]
            && count > 0
        {
            starts[p] = Start::Refused { flipped };
        }
    }
    for v in (0..uv.len()).map(VertexId::from) {
        if matches!(starts[patches[v.index()] as usize], Start::Refused { .. }) {
            uv[v.index()] = given.uv[v.index()];
        }
    }
    Ok((uv, starts))
}

/// Faces of each patch that are turned over, have no area, or no place.
pub(super) fn flips(opened: &OpenedMesh, uv: &[Point2<f64>]) -> Vec<usize> {
    let mut flipped = vec![0; opened.patch_count];
    for f in opened.mesh.faces() {
        let [a, b, c] = opened.mesh.face_vertices(f).map(|v| uv[v.index()]);
        let is_finite = [a, b, c].iter().all(|p| (p.x + p.y).is_finite());
        let upright = is_finite && orientation(a, b, c) > 0.0;
        flipped[opened.face_patches[f.index()] as usize] += usize::from(!upright);
    }
    flipped
}
