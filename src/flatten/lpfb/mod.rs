//! Length-preserved free boundary [LPFB]: the rim of a chart is found first, with true lengths, from angles alone.
//!
//! Among all closed polygons with the side lengths of a patch's rim, the one whose angles are nearest to those of the surface
//! (see [`boundary`]). The interior is filled in afterwards between fixed rims ([`super::fixed`]). Patches with several loops are walked along
//! *virtual cuts*, shortest paths between the loops that are constrained to close.
//!
//! Guaranteed: rims keep their lengths to rounding, so that seam partners are equal; every report carries its certificates; developable
//! patches become isometric charts to rounding; a patch that fails costs no other patch its chart. Not guaranteed: freedom
//! from flips and crossings, which are counted.

pub mod boundary;
pub mod interior;
pub mod patch;

use std::f64::consts::PI;

use nalgebra::Point2;

use super::disks::{log_scales, refuse_degenerate};
use super::fixed::{Interior, fixed_rim};
use super::{Flattening, NoChart};
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh};
use crate::methods::flow::Status;

use boundary::{BoundaryOutcome, BoundarySolver};
use patch::{Opener, Patch};

/// What became of one patch, with the proofs that its boundary is what it should be.
#[derive(Clone, Debug, PartialEq)]
pub struct LpfbReport {
    /// How the boundary problem ended; none where there was nothing to solve, because virtual cuts do not make the patch a disk.
    pub boundary: Option<BoundaryOutcome>,
    /// Π_L: mean of |l − l⁰| over the rim's sides, in the chart against on the surface.
    pub length_error: f64,
    /// Largest |l − l⁰| / l⁰.
    pub length_error_max: f64,
    /// Number of sides of the rim, all loops together.
    pub sides: usize,
    /// Loops with the patch on the left, the outer one first.
    pub loops: Vec<Vec<HalfedgeId>>,
    /// Edges of virtual cuts.
    pub virtual_edges: usize,
    /// The interior that the chart got.
    pub interior: Option<Interior>,
    /// Faces that are turned over or have no area in the plane.
    pub flipped: usize,
    /// Proper crossings of the loops with themselves and each other.
    pub crossings: usize,
}

/// Flattens every patch with a length-preserved boundary.
///
/// **Takes** an opened surface and its measures. **Gives** charts of disks and of patches with several loops, in frames of their own, counter-clockwise,
/// and a report for each patch. The rim of a chart is the outer loop; holes are in its report. The interior is harmonic (cotangents), or
/// mean values where that turns faces over; the report says which.
/// **Fails** for lack of memory only; patches that cannot be flattened say so one by one.
/// **Costs** O(n) for each of some ten iterations, one factorisation and one solve of two columns, and a factorisation over two-rings where
/// faces turn over. **From** [LPFB] §3. **Differs**: virtual cuts are constrained by angles, which leaves full rank (see [`boundary`]).
pub fn lpfb(
    opened: &OpenedMesh,
    geometry: &Geometry,
) -> Result<(Flattening, Vec<LpfbReport>), LinalgError> {
    lpfb_with(opened, geometry, &[Interior::Harmonic, Interior::MeanValue])
}

/// [`lpfb`] with interiors of one's choice, tried in this order until one has no flips (see [`fixed_rim`]).
pub fn lpfb_with(
    opened: &OpenedMesh,
    geometry: &Geometry,
    order: &[Interior],
) -> Result<(Flattening, Vec<LpfbReport>), LinalgError> {
    let mesh = &opened.mesh;
    let mut groups: Vec<Vec<FaceId>> = vec![Vec::new(); opened.patch_count];
    for f in mesh.faces() {
        groups[opened.face_patches[f.index()] as usize].push(f);
    }
    let no_cut = vec![false; mesh.edge_count()];
    let nowhere = Point2::new(f64::NAN, f64::NAN);
    let mut places = vec![nowhere; mesh.vertex_count()];
    let mut opener = Opener::default();
    let mut charts = Vec::with_capacity(groups.len());
    let mut reports = Vec::with_capacity(groups.len());
    for faces in &groups {
        let rims = opener.rims(mesh, geometry, faces, &no_cut);
        let mut outline = opener.outline(mesh, geometry, &no_cut, &rims);
        let patch = opener.fill(mesh, faces, &no_cut, rims);
        outline.iter_mut().for_each(|outline| opener.name(outline));
        let mut report = LpfbReport::new(&patch);
        let chart = match outline.as_ref().filter(|_| patch.is_opened_by_virtual_cuts()) {
            None => Err(not_a_disk(&patch)),
            Some(outline) => {
                report.virtual_edges = outline.problem.cuts.len();
                let mut solver = BoundarySolver::new(&outline.problem);
                let outcome = solver.solve();
                let rim = outline.spread(&solver.places(), patch.vertices.len());
                report.boundary = Some(outcome);
                if outcome.status == Status::Infeasible {
                    Err(NoChart::NotConverged { angle_error: outcome.angle_error })
                } else {
                    for (v, place) in patch.vertices.iter().zip(&rim) {
                        places[v.index()] = *place;
                    }
                    Ok(patch.loops[0].clone())
                }
            }
        };
        charts.push(chart);
        reports.push(report);
    }
    refuse_degenerate(opened, geometry, &mut charts);
    let map = fixed_rim(opened, geometry, &places, order)?;
    let patches = opened.vertex_patches();
    for (patch, chart) in charts.iter_mut().enumerate() {
        if chart.is_ok() && map.interiors[patch].is_none() {
            let face = opened.face_patches.iter().position(|&p| p as usize == patch).unwrap_or(0);
            *chart = Err(match map.singular[patch] {
                Some(vertex) => NoChart::Singular { vertex },
                None => NoChart::Degenerate { face: FaceId::from(face) },
            });
        }
    }
    let uv: Vec<Point2<f64>> = mesh
        .vertices()
        .map(|v| match mesh.halfedge(v) {
            Some(_) if charts[patches[v.index()] as usize].is_ok() => map.uv[v.index()],
            _ => nowhere,
        })
        .collect();
    for (patch, report) in reports.iter_mut().enumerate().filter(|(p, _)| charts[*p].is_ok()) {
        report.interior = map.interiors[patch];
        report.flipped = map.flipped[patch];
        report.certify(opened, geometry, &uv);
    }
    let u = log_scales(opened, geometry, &uv);
    let residual = map.residual;
    Ok((Flattening::of_places(charts, uv, u, true, residual), reports))
}

/// Why a patch that virtual cuts cannot open has no chart.
fn not_a_disk(patch: &Patch) -> NoChart {
    NoChart::NotADisk { euler: patch.euler, boundary_loops: patch.loops.len() }
}

impl LpfbReport {
    fn new(patch: &Patch) -> Self {
        Self {
            boundary: None,
            length_error: f64::NAN,
            length_error_max: f64::NAN,
            sides: patch.loops.iter().map(Vec::len).sum(),
            loops: patch.loops.clone(),
            virtual_edges: 0,
            interior: None,
            flipped: 0,
            crossings: 0,
        }
    }

    /// Π_θ as the paper has it: the mean over the rim's own corners in the chart, virtual cuts aside.
    pub fn angle_error(&self, opened: &OpenedMesh, geometry: &Geometry, uv: &[Point2<f64>]) -> f64 {
        rim_errors(opened, geometry, uv, &self.loops)[1]
    }

    fn certify(&mut self, opened: &OpenedMesh, geometry: &Geometry, uv: &[Point2<f64>]) {
        self.length_error = rim_errors(opened, geometry, uv, &self.loops)[0];
        self.length_error_max = 0.0;
        for &h in self.loops.iter().flatten() {
            let [a, b] = [opened.mesh.tail(h), opened.mesh.tip(h)].map(|v| uv[v.index()]);
            let length = geometry.edge_length(h.edge());
            let off = ((b - a).norm() - length).abs() / length;
            self.length_error_max = self.length_error_max.max(off);
        }
        let outlines: Vec<Vec<Point2<f64>>> = self
            .loops
            .iter()
            .map(|rim| rim.iter().map(|&h| uv[opened.mesh.tail(h).index()]).collect())
            .collect();
        let outlines: Vec<&[Point2<f64>]> = outlines.iter().map(Vec::as_slice).collect();
        self.crossings = super::overlap::crossings(&outlines).len();
    }
}

/// Π_L and Π_θ of some loops of a chart: means of |l − l⁰| over sides and of |θ − a| over corners, θ the angle in the chart and a that on the
/// surface.
pub fn rim_errors(
    opened: &OpenedMesh,
    geometry: &Geometry,
    uv: &[Point2<f64>],
    loops: &[Vec<HalfedgeId>],
) -> [f64; 2] {
    let mesh = &opened.mesh;
    let (mut lengths, mut angles, mut count) = (0.0, 0.0, 0.0);
    for rim in loops {
        for (i, &h) in rim.iter().enumerate() {
            let before = rim[(i + rim.len() - 1) % rim.len()];
            let [a, b, c] = [mesh.tail(before), mesh.tail(h), mesh.tip(h)].map(|v| uv[v.index()]);
            lengths += ((c - b).norm() - geometry.edge_length(h.edge())).abs();
            let surface = patch::angle_at(mesh, geometry, h, |g| mesh.face(g.twin()).is_none());
            let (back, on) = (a - b, c - b);
            let turn = on.perp(&back).atan2(on.dot(&back)).rem_euclid(2.0 * PI);
            // Angles are told up to full turns: the nearest counts.
            let off = (turn - surface).rem_euclid(2.0 * PI);
            angles += off.min(2.0 * PI - off);
            count += 1.0;
        }
    }
    [lengths / count, angles / count]
}
