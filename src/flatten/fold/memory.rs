//! Limited-memory BFGS about a metric that is solved with.

use std::collections::VecDeque;

use crate::linalg::{add, dot};

/// Pairs kept. Three take half again as many steps, twelve hardly fewer and more time each.
const PAIRS: usize = 6;

/// The last steps and the changes of gradient along them.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    pairs: VecDeque<(Vec<f64>, Vec<f64>, f64)>,
}

impl Memory {
    pub fn clear(&mut self) {
        self.pairs.clear();
    }

    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Remembers a step, unless the energy did not curve upwards along it: then nothing is known that helps descent.
    pub fn record(&mut self, step: Vec<f64>, change: Vec<f64>) {
        let curvature = dot(&step, &change);
        if curvature > 1e-10 * (dot(&step, &step) * dot(&change, &change)).sqrt() {
            if self.pairs.len() == PAIRS {
                self.pairs.pop_front();
            }
            self.pairs.push_back((step, change, 1.0 / curvature));
        }
    }

    /// −H g by the two-loop recursion, where `solve` is what H is without memory.
    pub fn direction<E>(
        &self,
        gradient: &[f64],
        solve: impl FnOnce(&mut [f64]) -> Result<(), E>,
    ) -> Result<Vec<f64>, E> {
        let mut d: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let mut alphas = Vec::with_capacity(self.pairs.len());
        for (s, y, rho) in self.pairs.iter().rev() {
            let alpha = rho * dot(s, &d);
            add(&mut d, -alpha, y);
            alphas.push(alpha);
        }
        solve(&mut d)?;
        for ((s, y, rho), alpha) in self.pairs.iter().zip(alphas.into_iter().rev()) {
            let beta = rho * dot(y, &d);
            add(&mut d, alpha - beta, s);
        }
        Ok(d)
    }
}
