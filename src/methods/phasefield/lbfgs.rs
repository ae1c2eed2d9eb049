//! Limited-memory BFGS with a strong Wolfe search, one iteration at a time.

use super::domain::Domain;
use super::objective::{Evaluation, Objective};
use crate::linalg::{LinalgError, add, dot, sums};

/// Pairs kept: each costs four passes over two vectors in every iteration.
const PAIRS: usize = 7;

/// Evaluations of one search.
const TRIALS: usize = 20;

/// A trial may change no value by more than this: fields live between −1 and 1, and one that jumps over the well does not come back.
const LARGEST_CHANGE: f64 = 1.0;

/// Fraction of the promised decrease that is asked for, and of the slope that may be left.
const DECREASE: f64 = 1e-4;
const SLOPE: f64 = 0.9;

/// Where the search is.
#[derive(Clone)]
pub(super) struct Descent {
    pub at: Evaluation,
    /// Gradient of F without constraint, by the directions.
    gradient: Vec<f64>,
    directions: Vec<f64>,
    /// Inverse of what the search measures gradients with.
    inverse: Vec<f64>,
    /// Steps s, changes of gradient y, 1 / sᵀy.
    pairs: Vec<(Vec<f64>, Vec<f64>, f64)>,
    /// Evaluations so far.
    pub evaluations: usize,
}

/// What a trial found.
struct Trial {
    t: f64,
    slope: f64,
    at: Evaluation,
    gradient: Vec<f64>,
}

impl Descent {
    /// Begins at fields, which get their areas along the directions given.
    pub fn new(
        domain: &Domain,
        objective: &mut Objective,
        u: &[f64],
        directions: &[f64],
    ) -> Result<Self, LinalgError> {
        let at = objective.evaluate(domain, u, directions)?;
        let directions = objective.directions(&at);
        let gradient = objective.reduce(domain, &at, &directions);
        let inverse = objective.diagonal(domain, &at).iter().map(|d| 1.0 / d).collect();
        Ok(Self { at, gradient, directions, inverse, pairs: Vec::new(), evaluations: 1 })
    }

    /// Goes on with another objective from where it is.
    pub fn renew(&mut self, domain: &Domain, objective: &mut Objective) -> Result<(), LinalgError> {
        let evaluations = self.evaluations;
        let (u, directions) = (self.at.u.clone(), self.directions.clone());
        *self = Self::new(domain, objective, &u, &directions)?;
        self.evaluations += evaluations;
        Ok(())
    }

    /// Squared norm of the gradient in the metric of the search: twice what a quadratic with that curvature promises.
    pub fn gradient_norm(&self) -> f64 {
        self.size(&self.gradient)
    }

    /// gᵀ D⁻¹ g.
    fn size(&self, g: &[f64]) -> f64 {
        let (g, inverse) = (&g[..self.inverse.len()], &self.inverse[..]);
        let [size] = sums(g.len(), |i| [g[i] * g[i] * inverse[i]]);
        size
    }

    /// One iteration; false, and nothing changed, where no step was found.
    pub fn iterate(
        &mut self,
        domain: &Domain,
        objective: &mut Objective,
    ) -> Result<bool, LinalgError> {
        loop {
            let direction = self.direction();
            if let Some(trial) = self.search(domain, objective, &direction)? {
                self.accept(domain, objective, &direction, trial);
                return Ok(true);
            }
            if self.pairs.is_empty() {
                return Ok(false);
            }
            self.pairs.clear();
        }
    }

    /// −H g by the two-loop recursion, from the inverse of the diagonal.
    fn direction(&self) -> Vec<f64> {
        let mut d: Vec<f64> = self.gradient.iter().map(|g| -g).collect();
        let mut alphas = vec![0.0; self.pairs.len()];
        for (i, (s, y, rho)) in self.pairs.iter().enumerate().rev() {
            alphas[i] = rho * dot(s, &d);
            add(&mut d, -alphas[i], y);
        }
        let gamma = self.pairs.last().map_or(1.0, |(_, y, rho)| 1.0 / (rho * self.size(y)));
        for (d, inverse) in d.iter_mut().zip(&self.inverse) {
            *d *= gamma * inverse;
        }
        for (i, (s, y, rho)) in self.pairs.iter().enumerate() {
            let beta = rho * dot(y, &d);
            add(&mut d, alphas[i] - beta, s);
        }
        d
    }

    /// A step length that satisfies the strong Wolfe conditions, or at least lowers F.
    fn search(
        &mut self,
        domain: &Domain,
        objective: &mut Objective,
        direction: &[f64],
    ) -> Result<Option<Trial>, LinalgError> {
        let slope = dot(&self.gradient, direction);
        let largest = direction.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        if !(slope < 0.0 && largest.is_finite()) {
            return Ok(None);
        }
        let (value, most) = (self.at.value, LARGEST_CHANGE / largest);
        let enough = |t: f64, f: f64| f <= value + DECREASE * t * slope;
        // Of the bracket's end with the lower value, and of the other one.
        let (mut low, mut high) = ((0.0, value, slope), None::<(f64, f64, f64)>);
        let mut best: Option<Trial> = None;
        let mut t = most.min(1.0);
        for _ in 0..TRIALS {
            let trial = self.attempt(domain, objective, direction, t)?;
            let (f, g) = (trial.at.value, trial.slope);
            let point = (t, f, g);
            if !(f.is_finite() && f < low.1 && enough(t, f)) {
                high = Some(point);
            } else {
                let is_flat = g.abs() <= -SLOPE * slope;
                let goes_back = match high {
                    Some(high) => g * (high.0 - low.0) >= 0.0,
                    None => g >= 0.0,
                };
                if goes_back {
                    high = Some(low);
                }
                low = point;
                best = Some(trial);
                if is_flat || (high.is_none() && t >= most) {
                    return Ok(best);
                }
            }
            t = match high {
                None => (2.0 * t).min(most),
                Some(high) => between(low, high),
            };
            if let Some(high) = high
                && (high.0 - low.0).abs() <= 1e-10 * low.0.max(high.0)
            {
                break;
            }
        }
        Ok(best)
    }

    fn attempt(
        &mut self,
        domain: &Domain,
        objective: &mut Objective,
        direction: &[f64],
        t: f64,
    ) -> Result<Trial, LinalgError> {
        let fields: Vec<f64> = self.at.u.iter().zip(direction).map(|(u, d)| u + t * d).collect();
        let at = objective.evaluate(domain, &fields, &self.directions)?;
        self.evaluations += 1;
        let gradient = objective.reduce(domain, &at, &self.directions);
        Ok(Trial { t, slope: dot(&gradient, direction), at, gradient })
    }

    fn accept(&mut self, domain: &Domain, objective: &Objective, direction: &[f64], trial: Trial) {
        let s: Vec<f64> = direction.iter().map(|d| trial.t * d).collect();
        let y: Vec<f64> = trial.gradient.iter().zip(&self.gradient).map(|(a, b)| a - b).collect();
        let size = |x: &[f64]| -> f64 { dot(x, x) };
        let product = dot(&s, &y);
        if product > 1e-10 * (size(&s) * size(&y)).sqrt() {
            if self.pairs.len() == PAIRS {
                self.pairs.remove(0);
            }
            self.pairs.push((s, y, 1.0 / product));
        }
        self.at = trial.at;
        self.directions = objective.directions(&self.at);
        self.gradient = objective.reduce(domain, &self.at, &self.directions);
    }
}

/// The minimum of the cubic through two ends with their slopes, kept away from both.
fn between(low: (f64, f64, f64), high: (f64, f64, f64)) -> f64 {
    let (a, fa, ga) = low;
    let (b, fb, gb) = high;
    let middle = 0.5 * (a + b);
    if !(fb.is_finite() && gb.is_finite()) {
        return a + 0.1 * (b - a);
    }
    let d1 = ga + gb - 3.0 * (fa - fb) / (a - b);
    let inside = d1 * d1 - ga * gb;
    if !(inside >= 0.0) {
        return middle;
    }
    let d2 = (b - a).signum() * inside.sqrt();
    let t = b - (b - a) * (gb + d2 - d1) / (gb - ga + 2.0 * d2);
    let margin = 0.1 * (b - a).abs();
    let (from, to) = (a.min(b) + margin, a.max(b) - margin);
    if t.is_finite() { t.clamp(from, to) } else { middle }
}
