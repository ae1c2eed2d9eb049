//! How far angles are from the optimum, without knowing it.
//!
//! Every φ bounds the objective from below by Ωᵀφ − ½ (L φ)ᵀM⁻¹(L φ) − Σ h_i(φ_i), where h_i(φ) = sup {φ μ − t_i |μ| : low ≤ μ ≤ high}
//! is 0 as long as |φ_i| ≤ t_i. The gap between that and the objective is 0 at the optimum only. Where nothing bounds an angle,
//! h is infinite as soon as φ exceeds t: that excess is reported on its own and left out of the sum.

use super::problem::{ActiveSet, Problem, Stance};
use super::system::Response;

/// See [`super::ConeState`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Certificate {
    pub objective: f64,
    /// ½ uᵀM u with the weights of the distortion.
    pub distortion: f64,
    pub gap: f64,
    pub violation: f64,
    /// Largest |φ − ± t| at free angles, in λ.
    pub support: f64,
}

impl Certificate {
    pub fn residual(&self) -> f64 {
        self.gap.max(self.violation).max(self.support)
    }
}

pub(super) fn certify(problem: &mut Problem, set: &ActiveSet, response: &Response) -> Certificate {
    let mut phi = response.phi.clone();
    problem.shift(set, &mut phi);
    let lambda = problem.params.lambda;
    let mut certificate = Certificate::default();
    let (mut price, mut dual) = (0.0, 0.0);
    for (i, &phi) in phi.iter().enumerate() {
        let t = problem.price(i);
        let mu = set.angles[i];
        price += t * mu.abs();
        dual += problem.system.curvatures[i] * phi;
        let (low, high) = match set.stances[i] {
            Stance::Held => (mu, mu),
            _ => (problem.low[i], problem.high[i]),
        };
        // The best μ is a bound or 0.
        let worth = |mu: f64| if mu.is_finite() { phi * mu - t * mu.abs() } else { f64::MIN };
        let between = if low <= 0.0 && high >= 0.0 { 0.0 } else { f64::MIN };
        dual -= worth(low).max(worth(high)).max(between);
        let (excess, _) = problem.excess(set, i, phi);
        certificate.violation = certificate.violation.max(excess / lambda);
        if set.stances[i] == Stance::Free {
            let off = (phi - problem.target(set, i)).abs() / lambda;
            certificate.support = certificate.support.max(off);
        }
    }
    let mut scale = vec![0.0; problem.system.mass.len()];
    problem.system.scale_of(&phi, &mut scale);
    let half_square = |u: &[f64]| -> f64 {
        0.5 * u.iter().zip(&problem.system.mass).map(|(u, m)| m * u * u).sum::<f64>()
    };
    dual -= half_square(&scale);
    certificate.distortion = half_square(&response.u);
    certificate.objective = certificate.distortion + price;
    let size = certificate.objective.max(f64::MIN_POSITIVE);
    certificate.gap = ((certificate.objective - dual) / size).abs();
    certificate
}
