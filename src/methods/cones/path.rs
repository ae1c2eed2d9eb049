//! The path over λ: what a price buys.

use super::flow::{ConeCheckpoint, ConeFlow};
use crate::methods::flow::{Flow, SolveError, Status};

/// One optimum on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// Price of one radian of cone angle.
    pub lambda: f64,
    /// Number of cones.
    pub count: usize,
    /// Σ|μ|, radians.
    pub total_angle: f64,
    /// ∫u².
    pub int_u2: f64,
}

/// Optima for prices from λ_max down, evenly spaced in logarithms.
///
/// **Step** one step of the flow, which is lent for it and comes back, at the end, as it was, with more Green's functions and λ_max known.
/// **Ends** after the last sample.
#[derive(Clone, Debug)]
pub struct ConePath {
    samples: usize,
    least: f64,
    most_cones: usize,
    /// λ_max, once it is known.
    most: Option<f64>,
    /// Samples that were begun.
    begun: usize,
    points: Vec<PathPoint>,
    home: Option<ConeCheckpoint>,
    is_complete: bool,
}

impl ConePath {
    /// **Takes** the number of samples (at least 2), the smallest λ as a fraction of λ_max, and the number of cones beyond which no further
    /// sample is begun.
    pub fn new(samples: usize, least: f64, most_cones: usize) -> Result<Self, SolveError> {
        let within = SolveError::within;
        within("number of samples", samples as f64, 2.0, 1000.0)?;
        within("smallest λ", least, 1e-6, 1.0)?;
        Ok(Self {
            samples,
            least,
            most_cones,
            most: None,
            begun: 0,
            points: Vec::new(),
            home: None,
            is_complete: false,
        })
    }

    /// What has been found so far, λ descending.
    pub fn points(&self) -> &[PathPoint] {
        &self.points
    }

    /// Whether all samples are there.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// One bounded step; gives whether the path is complete.
    ///
    /// **Takes** the same flow every time, not stepped by anybody else in between. A sample whose optimum cannot be certified is left out.
    pub fn step(&mut self, flow: &mut ConeFlow) -> Result<bool, SolveError> {
        if self.is_complete {
            return Ok(true);
        }
        if self.home.is_none() {
            self.home = Some(flow.checkpoint());
            if flow.lambda_max() <= 0.0 {
                // Nothing depends on λ.
                return self.finish(flow);
            }
            flow.set_lambda(flow.lambda_max())?;
        }
        if flow.step()?.status == Status::Running {
            return Ok(false);
        }
        // On a closed surface λ_max is known only after the first optimum.
        let most = *self.most.get_or_insert(flow.lambda_max());
        if self.begun > 0 && flow.status() == Status::Converged {
            let state = flow.state();
            self.points.push(PathPoint {
                lambda: state.lambda,
                count: state.cones.len(),
                total_angle: state.total_angle,
                int_u2: state.int_u2,
            });
        }
        let is_full = self.points.last().is_some_and(|point| point.count > self.most_cones);
        if most <= 0.0 || self.begun == self.samples || is_full {
            return self.finish(flow);
        }
        let share = self.begun as f64 / (self.samples - 1) as f64;
        flow.set_lambda(most * self.least.powf(share))?;
        self.begun += 1;
        Ok(false)
    }

    /// Gives up; the flow is as it was, and knows more.
    pub fn abandon(&mut self, flow: &mut ConeFlow) {
        if let Some(home) = self.home.take() {
            let most = flow.lambda_max.clone();
            flow.return_to(&home);
            // What the way has told of it stays true.
            flow.lambda_max = most;
        }
        self.is_complete = true;
    }

    fn finish(&mut self, flow: &mut ConeFlow) -> Result<bool, SolveError> {
        self.abandon(flow);
        Ok(true)
    }
}
