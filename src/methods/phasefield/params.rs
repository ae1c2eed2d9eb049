//! Options of a phase-field segmentation.

use std::sync::Arc;

use super::super::flow::SolveError;
use super::profile::{indicator, reach};

/// How firmly the diffuse scale factor is held at 0 outside of its phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Screening {
    /// λ = 1/ε, as the paper has it: the rim yields, and the loss converges like 1 / log(1/ε) only.
    #[default]
    Paper,
    /// λ = 1/ε²: nearer to the sharp loss. With this and [`Screening::Paper`] a field may lower the loss by turning grey at spikes and rims,
    /// where that little of the other phase holds s at 0, in place of moving the border; the stronger λ is, the more it does.
    Sharp,
    /// λ = 1/ε², and what belongs to a phase's flattening falls off about the middle of the interface only (not in [PF]): nothing is gained
    /// by grey, borders move. On a rocker arm the sharp loss goes from 15.5 to 1.5 with ω = 1; with [`Screening::Paper`] to 14.1, with
    /// [`Screening::Sharp`] it rises.
    Outside,
}

/// Where the search for a split begins.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Start {
    /// Across the segment's longest axis of inertia first, then from noise and across the other axes in turn.
    #[default]
    Auto,
    /// ±1 on every face by a seed, smoothed.
    Random,
    /// Across an axis of inertia: the longest first, the others with further starts, then noise.
    Axes,
    /// By the side that normals point to, along the direction in which they vary most; the two others with further starts,
    /// then noise.
    Normals,
    /// The first split from a value for each vertex, positive for the first phase (painted, or another method's); further starts and
    /// splits as [`Start::Auto`].
    Values(Arc<Vec<f64>>),
}

/// Options of a [`super::PhaseFieldFlow`]. Lengths are those of the surface scaled to area 4π, as the unit sphere has,
/// whatever the area of the geometry handed in.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseFieldParams {
    /// Width of the interface ε. Below twice the mean edge length ([`super::epsilon_floor`]) it sticks to the triangles.
    pub epsilon: f64,
    /// Power of the price of unconnected phases: ε^−κ.
    pub kappa: f64,
    /// Price of distortion ω; 0 leaves it out.
    pub omega: f64,
    /// Share of a segment's area that its positive part gets, at every split.
    pub fraction: f64,
    /// Number of levels of splits: 2 to this power segments.
    pub levels: usize,
    /// Starts of every split; the best result is kept.
    pub starts: usize,
    /// What they are.
    pub start: Start,
    /// Whether phases in several parts cost.
    pub is_connected: bool,
    /// Whether all levels are relaxed together in the end; otherwise a segment stays as it was when it was split.
    pub is_joint: bool,
    /// How the diffuse scale factor is held outside of its phase.
    pub screening: Screening,
    /// Iterations of each start before unconnected phases cost.
    pub warm_up: usize,
    /// Seed of noise.
    pub seed: u64,
    /// A start has converged when its last ten iterations together lowered the objective by less than this fraction.
    pub tolerance: f64,
    /// Most iterations of one start.
    pub max_steps: usize,
}

impl Default for PhaseFieldParams {
    fn default() -> Self {
        Self {
            epsilon: 0.12,
            kappa: 1.0,
            omega: 0.0,
            fraction: 0.5,
            levels: 1,
            starts: 2,
            start: Start::Auto,
            is_connected: true,
            is_joint: false,
            screening: Screening::Paper,
            warm_up: 30,
            seed: 1,
            tolerance: 1e-6,
            max_steps: 2000,
        }
    }
}

impl PhaseFieldParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        // Beyond ½ an interface fills half of a hemisphere.
        within("interface width", self.epsilon, 1e-3, 0.5)?;
        within("connectedness power", self.kappa, 0.0, 4.0)?;
        within("distortion weight", self.omega, 0.0, 1e6)?;
        within("area fraction", self.fraction, 0.02, 0.98)?;
        within("levels", self.levels as f64, 1.0, 5.0)?;
        within("starts", self.starts as f64, 1.0, 20.0)?;
        within("warm-up", self.warm_up as f64, 0.0, 1e4)?;
        within("tolerance", self.tolerance, 0.0, 1.0)?;
        within("largest number of steps", self.max_steps as f64, 1.0, 1e6)?;
        if let Start::Values(values) = &self.start
            && let Some(bad) = values.iter().find(|x| !x.is_finite())
        {
            return Err(SolveError::Parameter {
                name: "start value",
                value: *bad,
                min: f64::MIN,
                max: f64::MAX,
            });
        }
        Ok(())
    }

    /// λ of the diffuse scale factor.
    pub(super) fn lambda(&self) -> f64 {
        match self.screening {
            Screening::Paper => 1.0 / self.epsilon,
            Screening::Sharp | Screening::Outside => 1.0 / (self.epsilon * self.epsilon),
        }
    }

    /// How much of a vertex belongs to the flattening of the positive phase, by its value, and the derivative.
    pub(super) fn reach(&self) -> fn(f64) -> (f64, f64) {
        match self.screening {
            Screening::Paper | Screening::Sharp => indicator,
            Screening::Outside => reach,
        }
    }

    /// Whether fields that are optimal for `other` are so for these: only what the hierarchy is made of differs.
    pub(super) fn measures_like(&self, other: &Self) -> bool {
        let neutral = |p: &Self| Self {
            levels: 1,
            starts: 1,
            start: Start::Auto,
            warm_up: 0,
            seed: 0,
            max_steps: 1,
            is_joint: false,
            ..p.clone()
        };
        neutral(self) == neutral(other)
    }
}
