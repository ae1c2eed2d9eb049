//! The gate of seam refinement: a seam is moved only if both charts flatten as well as before.

use std::sync::Arc;

use super::params::MergeParams;
use super::trial::{Bench, Limits};
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{FaceId, Mesh};

/// Answers the questions of [`crate::methods::developable::RefineFlow::step_if`].
///
/// It accepts where both charts are within [`MergeParams::split_limit`] and the other limits, or were not before, and where A_abs times area does not grow in sum;
/// a chart without a map within the limits counts with all its area. Ungated minimum cuts make charts that have to be split again.
#[derive(Clone)]
pub struct ChartGate {
    bench: Bench,
    limits: Limits,
    /// For each chart A_abs times area.
    costs: Vec<f64>,
    is_flat: Vec<bool>,
}

impl ChartGate {
    /// Flattens all charts.
    ///
    /// **Takes** connected charts, numbered from 0, those of the state of the flow that asks. **Fails** for lack of memory. **Costs** a trial for each.
    pub fn new(
        mesh: Arc<Mesh>,
        geometry: Arc<Geometry>,
        face_charts: &[u32],
        params: &MergeParams,
    ) -> Result<Self, LinalgError> {
        let limits =
            Limits { area: params.split_limit.min(params.area_limit), ..Limits::of(params) };
        let count = face_charts.iter().max().map_or(0, |&c| c as usize + 1);
        let mut faces = vec![Vec::new(); count];
        for f in mesh.faces() {
            faces[face_charts[f.index()] as usize].push(f);
        }
        let bench = Bench::new(mesh, geometry)?;
        let mut gate = Self { bench, limits, costs: Vec::new(), is_flat: Vec::new() };
        for faces in &faces {
            let (cost, is_flat) = gate.look(faces);
            gate.costs.push(cost);
            gate.is_flat.push(is_flat);
        }
        Ok(gate)
    }

    /// How many charts are within the limits.
    pub fn flat_charts(&self) -> usize {
        self.is_flat.iter().filter(|&&is_flat| is_flat).count()
    }

    /// Σ A_abs · area over the charts; those that are not within the limits count with all their area.
    pub fn cost(&self) -> f64 {
        self.costs.iter().fold(0.0, |sum, cost| sum + cost)
    }

    /// Whether the charts of a pair may become what they are in `face_charts`; if so they are remembered. **Costs** two trials.
    pub fn accepts(&mut self, face_charts: &[u32], pair: [u32; 2]) -> bool {
        let mesh = self.bench.mesh.clone();
        let looks = pair.map(|chart| {
            let faces: Vec<FaceId> =
                mesh.faces().filter(|f| face_charts[f.index()] == chart).collect();
            self.look(&faces)
        });
        let old = pair.map(|c| (self.costs[c as usize], self.is_flat[c as usize]));
        // Where nothing is distorted, sums differ by rounding.
        let is_no_worse = looks[0].0 + looks[1].0
            <= old[0].0 + old[1].0 + 1e-9 * self.bench.geometry.total_area();
        let stay_flat = looks.iter().zip(old).all(|(new, old)| new.1 || !old.1);
        if is_no_worse && stay_flat {
            for (chart, (cost, is_flat)) in pair.into_iter().zip(looks) {
                self.costs[chart as usize] = cost;
                self.is_flat[chart as usize] = is_flat;
            }
        }
        is_no_worse && stay_flat
    }

    fn look(&mut self, faces: &[FaceId]) -> (f64, bool) {
        let area: f64 = faces.iter().map(|f| self.bench.geometry.face_areas[f.index()]).sum();
        match self.bench.flatten(faces, &self.limits) {
            Ok(map) => (map.measures.area_absolute * area, true),
            Err(_) => (area, false),
        }
    }
}
