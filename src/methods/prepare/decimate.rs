//! Fewer triangles.

use super::{Prepared, Surface, check};
use crate::methods::flow::{Flow, SolveError, StepReport};

/// Options of [`DecimateFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecimateParams {
    /// Number of faces aimed at.
    pub target_faces: usize,
    /// Edges whose faces turn by more than this, in radians, are held where they are as far as possible.
    pub feature_angle: f64,
}

impl Default for DecimateParams {
    fn default() -> Self {
        Self { target_faces: 20_000, feature_angle: 40f64.to_radians() }
    }
}

impl DecimateParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        check("target faces", self.target_faces as f64, 1.0, 1e9)?;
        check("feature angle", self.feature_angle, 0.0, std::f64::consts::PI)
    }
}

/// Fewer triangles on nearly the same surface.
pub struct DecimateFlow {
    state: Prepared,
}

impl DecimateFlow {
    /// Ready to run.
    pub fn new(surface: Surface, params: &DecimateParams) -> Result<Self, SolveError> {
        params.validate()?;
        Ok(Self { state: Prepared { surface, ancestors: Vec::new() } })
    }
}

impl Flow for DecimateFlow {
    type State = Prepared;

    fn state(&self) -> &Prepared {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        Err(SolveError::NoEnergy)
    }
}
