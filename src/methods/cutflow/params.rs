//! Options of a cut flow.

use super::terms::{Pointwise, Weights};
use crate::methods::flow::SolveError;

/// How a step moves the cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scheme {
    /// Exact descent on the discrete J in an H¹ metric.
    #[default]
    Fast,
    /// The paper's flow: a flux is recovered on the cut, extended to the surface, and level sets follow it.
    Paper,
}

/// Which changes of topology a step may make.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Topology {
    /// With two regions as [`Topology::Preserve`], with more as [`Topology::Merge`]: many patches hem each other in, and the
    /// minima that they reach without ever growing together are two percent higher.
    #[default]
    Adaptive,
    /// None: patches are neither torn, joined nor pierced. With more than two regions a patch may shrink away.
    Preserve,
    /// Patches of one label may grow together, and patches may shrink away; none is torn in two.
    Merge,
    /// Any.
    Free,
}

impl Topology {
    /// What it means for a cut with more than two regions, or with no more.
    pub(super) fn resolved(self, many: bool) -> Self {
        match (self, many) {
            (Self::Adaptive, true) => Self::Merge,
            (Self::Adaptive, false) => Self::Preserve,
            (chosen, _) => chosen,
        }
    }
}

/// A length weight that changes while the flow runs: α falls (or rises) by the same factor in every step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// α at the end.
    pub length_end: f64,
    /// Steps until then.
    pub steps: usize,
}

/// Options of a [`super::CutFlow`]. All are for a surface of unit area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutFlowParams {
    /// Weights of the objective.
    pub weights: Weights,
    /// How a step moves the cut.
    pub scheme: Scheme,
    /// Which changes of topology it may make.
    pub topology: Topology,
    /// How the length weight changes, if it does.
    pub schedule: Option<Schedule>,
    /// Largest displacement of the cut in one step, in mean edge lengths. ½ is safe and takes twice the steps; 2 is worse
    /// with many patches, 4 fails.
    pub cap: f64,
    /// Amplitude of the seeded smooth disturbance of the first step, in mean edge lengths. It leaves saddles, and it chooses
    /// the minimum: a symmetric start without it waits for rounding errors to grow.
    pub kick: f64,
    /// Seed of that disturbance.
    pub seed: u64,
    /// The run has converged when the last ten steps together lowered J by less than this fraction.
    pub tolerance: f64,
    /// How often a cut that has converged is disturbed again, to see whether it was a saddle; the better one is kept.
    pub saddle_tests: usize,
    /// Whether the first steps are made on a coarser surface.
    pub coarse_to_fine: bool,
}

impl Default for CutFlowParams {
    fn default() -> Self {
        Self {
            weights: Weights { dirichlet: 10.0, length: 2.0, ..Weights::default() },
            scheme: Scheme::Fast,
            topology: Topology::Adaptive,
            schedule: None,
            cap: 1.0,
            kick: 0.5,
            seed: 1,
            tolerance: 1e-5,
            saddle_tests: 0,
            coarse_to_fine: false,
        }
    }
}

impl CutFlowParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        let weights = &self.weights;
        within("Dirichlet weight", weights.dirichlet, 0.0, 1e8)?;
        within("Hencky weight", weights.hencky, 0.0, 1e10)?;
        within("cut length weight", weights.length, 0.0, 1e6)?;
        within("penalty weight", weights.penalty, 0.0, 1e6)?;
        within("area weight", weights.area, 0.0, 1e8)?;
        if let Pointwise::Power(power) = weights.pointwise {
            // With less than 1.1 b′ jumps at 0; beyond 12 only the worst triangle counts.
            within("power of |u|", power, 1.1, 12.0)?;
        }
        if let Some(schedule) = self.schedule {
            within("cut length weight at the end", schedule.length_end, 1e-6, 1e6)?;
            within("cut length weight of a schedule", weights.length, 1e-6, 1e6)?;
            within("steps of the schedule", schedule.steps as f64, 1.0, 1e6)?;
        }
        within("step cap", self.cap, 0.01, 2.0)?;
        within("kick", self.kick, 0.0, 2.0)?;
        within("tolerance", self.tolerance, 0.0, 1.0)?;
        within("saddle tests", self.saddle_tests as f64, 0.0, 10.0)?;
        if weights.dirichlet + weights.hencky > 0.0 { Ok(()) } else { Err(SolveError::NoEnergy) }
    }

    /// The weights that act on a step.
    pub fn weights_at(&self, step: usize) -> Weights {
        let mut weights = self.weights;
        if let Some(schedule) = self.schedule {
            let done = (step as f64 / schedule.steps as f64).min(1.0);
            weights.length *= (schedule.length_end / weights.length).powf(done);
        }
        weights
    }

    /// Whether the weights still change.
    pub(super) fn is_changing_at(&self, step: usize) -> bool {
        self.schedule.is_some_and(|schedule| step < schedule.steps)
    }
}
