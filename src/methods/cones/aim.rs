//! Finding the λ at which the optimum has a wanted number of cones, total angle or distortion.
//!
//! Along the path the total angle falls with λ and the distortion grows; the number of cones falls by and large. The search steps
//! by factors until the target lies between two λ, then halves that interval in logarithms, by secants where the quantity is
//! continuous.

use super::params::{ConeState, ConeTarget};

/// Relative accuracy of what is continuous.
const CLOSE: f64 = 1e-4;
/// Ratio of two λ between which the number of cones is not looked into any more.
const NARROW: f64 = 1.001;
/// Trials after which the nearest is as good as it gets.
const TRIALS: usize = 60;

/// A search under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Search {
    target: ConeTarget,
    /// Largest λ known to be too small, with what was found there.
    below: Option<(f64, f64)>,
    /// Smallest λ known to be large enough.
    above: Option<(f64, f64)>,
    trials: usize,
    /// Whether the next optimum is taken as it is.
    is_last: bool,
    pub is_reached: bool,
}

impl Search {
    /// Whether clusters count as one cone.
    pub fn is_merged(&self) -> bool {
        matches!(self.target, ConeTarget::Merged(_))
    }

    pub fn new(target: ConeTarget) -> Self {
        Self { target, below: None, above: None, trials: 0, is_last: false, is_reached: true }
    }

    /// What is searched for, as a function that falls with λ.
    fn miss(&self, state: &ConeState, cones: usize) -> f64 {
        match self.target {
            ConeTarget::Lambda(_) => 0.0,
            ConeTarget::Count(count) | ConeTarget::Merged(count) => cones as f64 - count as f64,
            ConeTarget::TotalAngle(angle) => state.total_angle - angle,
            ConeTarget::Distortion(distortion) => distortion - state.int_u2,
        }
    }

    /// The λ to be solved for next; none when the search has ended at the optimum handed in.
    ///
    /// **Takes** the optimum at `state.lambda`, how many cones it counts for, and the range that λ may lie in.
    pub fn next(&mut self, state: &ConeState, cones: usize, range: [f64; 2]) -> Option<f64> {
        if let ConeTarget::Lambda(lambda) = self.target {
            return (lambda.to_bits() != state.lambda.to_bits()).then_some(lambda);
        }
        if self.is_last {
            return None;
        }
        let miss = self.miss(state, cones);
        let is_count = matches!(self.target, ConeTarget::Count(_) | ConeTarget::Merged(_));
        let scale = match self.target {
            ConeTarget::TotalAngle(x) | ConeTarget::Distortion(x) => x.abs(),
            _ => 0.0,
        };
        // As many cones as asked for may be had for less.
        if !is_count && miss.abs() <= CLOSE * scale {
            return None;
        }
        let lambda = state.lambda;
        if miss > 0.0 {
            self.below = Some((lambda, miss));
        } else {
            self.above = Some((lambda, miss));
        }
        self.trials += 1;
        let next = match (self.below, self.above) {
            (Some((low, _)), None) => {
                if low >= range[1] {
                    // Less distortion than asked for, at the highest price that matters: that is what was asked for.
                    self.is_reached = matches!(self.target, ConeTarget::Distortion(_));
                    return None;
                }
                (2.0 * low).min(range[1])
            }
            (None, Some((high, _))) => {
                if high <= range[0] {
                    self.is_reached = is_count;
                    return None;
                }
                (0.5 * high).max(range[0])
            }
            (Some((low, a)), Some((high, b))) => {
                let ratio = high / low;
                if ratio < if is_count { NARROW } else { 1.0 + 1e-9 } || self.trials > TRIALS {
                    // At `high` there are few enough.
                    self.is_last = true;
                    return (lambda.to_bits() != high.to_bits()).then_some(high);
                }
                let share =
                    if is_count || self.trials.is_multiple_of(3) { 0.5 } else { a / (a - b) };
                low * ratio.powf(share.clamp(0.02, 0.98))
            }
            (None, None) => return None,
        };
        Some(next)
    }
}
