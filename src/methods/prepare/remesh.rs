//! Isotropic remeshing.

use super::{Prepared, Surface, check};
use crate::methods::flow::{Flow, SolveError, StepReport};

/// How long the new edges shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeTarget {
    /// In multiples of the mean edge length of the given surface.
    MeanEdges(f64),
    /// In the unit of the positions.
    Length(f64),
}

/// Options of [`RemeshFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshParams {
    /// Edge length aimed at.
    pub target: EdgeTarget,
    /// Rounds of splitting, collapsing, flipping and smoothing. Five make most triangles good; ten settle the last ones.
    pub iterations: u32,
    /// Edges whose faces turn by more than this, in radians, are kept, and so are corners of lines that turn by more.
    pub feature_angle: f64,
    /// 0: the same length everywhere. 1: length inversely proportional to curvature, between a quarter and twice the target.
    pub adaptivity: f64,
}

impl Default for RemeshParams {
    fn default() -> Self {
        Self {
            target: EdgeTarget::MeanEdges(1.0),
            iterations: 8,
            feature_angle: 40f64.to_radians(),
            adaptivity: 0.0,
        }
    }
}

impl RemeshParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        match self.target {
            EdgeTarget::MeanEdges(multiple) => check("edge length", multiple, 0.05, 100.0)?,
            EdgeTarget::Length(length) => check("edge length", length, 1e-100, 1e100)?,
        }
        check("iterations", f64::from(self.iterations), 1.0, 100.0)?;
        check("feature angle", self.feature_angle, 0.0, std::f64::consts::PI)?;
        check("adaptivity", self.adaptivity, 0.0, 1.0)
    }
}

/// Even triangles on an old surface.
pub struct RemeshFlow {
    state: Prepared,
}

impl RemeshFlow {
    /// Ready to run.
    pub fn new(surface: Surface, params: &RemeshParams) -> Result<Self, SolveError> {
        params.validate()?;
        Ok(Self { state: Prepared { surface, ancestors: Vec::new() } })
    }
}

impl Flow for RemeshFlow {
    type State = Prepared;

    fn state(&self) -> &Prepared {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        Err(SolveError::NoEnergy)
    }
}
