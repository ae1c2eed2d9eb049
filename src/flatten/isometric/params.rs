//! Options of the refinement.

use super::face::Distortion;
use crate::methods::flow::SolveError;

/// Options of an [`IsometricFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsometricParams {
    /// What distortion costs.
    pub distortion: Distortion,
    /// γ: how stiff seams are to begin with. At 10 springs alone leave differences of some thousandths, and one or two updates of multipliers reach
    /// a tolerance of 1e-4; much stiffer ones slow every step along the curved set of charts with equal seams, much
    /// softer ones need more updates. 0 lets partners go their own ways.
    pub seam_weight: f64,
    /// Largest relative difference of seam partners at the end: a tenth of a millimetre in a metre.
    pub seam_tolerance: f64,
    /// κ: how strongly pins pull.
    pub pin_weight: f64,
    /// Whether rims may not come to cross themselves.
    pub guard_rims: bool,
    /// The run has converged when a step promises less than this fraction of the distortion, or five together gained less.
    pub tolerance: f64,
}

impl Default for IsometricParams {
    fn default() -> Self {
        Self {
            distortion: Distortion::SymmetricDirichlet,
            seam_weight: 10.0,
            seam_tolerance: 1e-4,
            pin_weight: 1e4,
            guard_rims: true,
            tolerance: 1e-5,
        }
    }
}

impl IsometricParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        within("seam weight", self.seam_weight, 0.0, 1e6)?;
        within("seam tolerance", self.seam_tolerance, 1e-9, 1.0)?;
        within("pin weight", self.pin_weight, 0.0, 1e8)?;
        within("tolerance", self.tolerance, 0.0, 1.0)
    }
}
