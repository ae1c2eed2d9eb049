//! Limited-memory BFGS about a metric that is solved with.

use std::collections::VecDeque;

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

/// Σ aᵢ bᵢ, in four sums side by side: one alone waits for itself.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a4.zip(b4) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// a += factor · b.
pub(super) fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += factor * b;
    }
}
