//! Options of a shape approximation, and what comes out.

use nalgebra::Vector3;

use crate::mesh::FaceId;
use crate::methods::flow::SolveError;

/// Options of a [`super::VsaFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VsaParams {
    /// Largest error of a chart, as a fraction of the surface's area. 2 for a chart that closes up; half of it, and about √2 times as many charts come out.
    pub tolerance: f64,
    /// No more charts than this are made.
    pub max_charts: usize,
    /// Floods about a chart that was added.
    pub lloyd: usize,
    /// Floods of the whole surface in the end, at most.
    pub final_iterations: usize,
    /// How many charts are added between two tries to join a pair and use its plane elsewhere; 0 for never.
    pub teleport_every: usize,
    /// Where the first chart begins.
    pub seed_face: FaceId,
}

impl Default for VsaParams {
    fn default() -> Self {
        Self {
            tolerance: 0.002,
            max_charts: 2000,
            lloyd: 3,
            final_iterations: 20,
            teleport_every: 10,
            seed_face: FaceId(0),
        }
    }
}

impl VsaParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        // Below 1e-9 rounding of normals counts; at 2 any chart will do.
        within("tolerance of charts", self.tolerance, 1e-9, 2.0)?;
        within("most charts", self.max_charts as f64, 1.0, 1e6)?;
        within("floods about a chart", self.lloyd as f64, 1.0, 100.0)?;
        within("floods in the end", self.final_iterations as f64, 0.0, 1000.0)
    }
}

/// A chart: faces that face nearly one way.
#[derive(Clone, Debug, PartialEq)]
pub struct VsaChart {
    /// Direction of Σ a n, unit length.
    pub proxy: Vector3<f64>,
    /// Sum of the faces' areas.
    pub area: f64,
    /// Σ a |n − proxy|², in the unit of areas.
    pub error: f64,
    /// The face where the next flood begins: the one that fits best.
    pub seed: FaceId,
    /// Its faces in the order of the flood.
    pub faces: Vec<FaceId>,
}

/// What a step does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VsaPhase {
    /// Charts are joined, because the tolerance was raised.
    Merge,
    /// Charts are added.
    #[default]
    Grow,
    /// All charts are flooded anew.
    Polish,
    /// Nothing any more.
    Done,
}

/// The charts so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VsaState {
    /// For each face its chart.
    pub face_charts: Vec<u32>,
    /// The charts.
    pub charts: Vec<VsaChart>,
    /// Sum of the charts' errors over the surface's area.
    pub error: f64,
    /// The largest error of a chart over the surface's area.
    pub worst: f64,
    /// What the next step does.
    pub phase: VsaPhase,
}
