//! The dense range: a semismooth Newton method on the dual variable.
//!
//! The dual of the problem, with the angles regularised by ½ γ |μ|², is to minimise
//!
//! J(φ) = ½ φᵀB φ − Ωᵀφ + Σ h(φ_i), h′ = μ_γ(φ) = clip(P_t(φ) / γ, low, high), P_t(φ) = φ − clip(φ, −t, t).
//!
//! J has a continuous gradient and a piecewise constant Hessian B + D, D = 1/γ where μ_γ follows φ. γ falls by factors of 100; with
//! each, a few Newton steps with Armijo's rule. At last γ = 0: φ = ±t is prescribed on the active set, the rest follows from
//! one factorisation without these rows, and the active set is corrected by signs until it stands. One analysis of B's pattern serves all
//! factorisations.

use super::problem::{ActiveSet, Problem, Stance};
use super::two_ring::TwoRing;
use crate::linalg::LinalgError;

/// First γ, as a fraction of the area; from the curvature alone a smaller one needs more steps, not fewer.
pub(super) const COLD: f64 = 1.0;
/// First γ when cones are known already.
pub(super) const WARM: f64 = 1e-4;
/// γ at which the exact active set is first looked for, and one hundredth of the smallest that helps.
const LAST: f64 = 1e-6;
const SMALLEST: f64 = 1e-12;
/// Newton steps for one γ: the early ones only lead to the next.
const EARLY_STEPS: usize = 3;
const LATE_STEPS: usize = 12;
/// Corrections of the exact active set before γ is lowered once more.
const CORRECTIONS: usize = 6;

/// Where Newton's method is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Descent {
    pub phi: Vec<f64>,
    gamma: f64,
    /// Newton steps with this γ.
    tries: usize,
    /// The active set of the exact stage, and how often it has been corrected.
    exact: Option<(ActiveSet, usize)>,
}

/// What a Newton step came to.
pub(super) enum Outcome {
    /// Angles to be looked at; they need not add up to what Gauss–Bonnet asks for.
    Guess(ActiveSet),
    /// The exact optimum.
    Optimum(ActiveSet),
    /// No γ helps.
    Lost,
}

impl Descent {
    /// **Takes** φ at every dof, shifted, and the first γ.
    pub fn new(phi: Vec<f64>, gamma: f64) -> Self {
        Self { phi, gamma, tries: 0, exact: None }
    }

    /// One factorisation and what follows from it.
    pub fn step(
        &mut self,
        problem: &mut Problem,
        two_ring: &mut TwoRing,
    ) -> Result<Outcome, LinalgError> {
        match self.exact.take() {
            None => self.smooth_step(problem, two_ring),
            Some((set, corrections)) => self.exact_step(problem, two_ring, set, corrections),
        }
    }

    fn smooth_step(
        &mut self,
        problem: &mut Problem,
        two_ring: &mut TwoRing,
    ) -> Result<Outcome, LinalgError> {
        let gamma = self.gamma * problem.area();
        let regular = Regularised { gamma };
        regular.choose_constants(problem, &mut self.phi);
        let n = self.phi.len();
        let slopes: Vec<f64> = (0..n).map(|i| regular.slope(problem, i, self.phi[i])).collect();
        let is_out = problem.empty_grounds(|i| slopes[i] > 0.0);
        two_ring.factor(&slopes, &is_out)?;
        problem.system.factorisations += 1;
        let (value, gradient) = regular.value(problem, &self.phi);
        let mut direction: Vec<f64> = gradient.iter().map(|g| -g).collect();
        two_ring.solve(&mut direction, 1);
        let descent: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let mut fraction = 1.0;
        let mut is_over = false;
        loop {
            let trial: Vec<f64> =
                self.phi.iter().zip(&direction).map(|(p, d)| p + fraction * d).collect();
            let (new, _) = regular.value(problem, &trial);
            if new <= value + 1e-4 * fraction * descent {
                self.phi = trial;
                break;
            }
            fraction *= 0.5;
            if fraction < 1e-6 {
                // Rounding is all that is left at this γ.
                is_over = true;
                break;
            }
        }
        // A whole step that leaves every piece as it was has found the minimum of J.
        is_over |= fraction == 1.0
            && (0..n)
                .all(|i| regular.slope(problem, i, self.phi[i]).to_bits() == slopes[i].to_bits());
        self.tries += 1;
        let guess = regular.active_set(problem, &self.phi);
        let limit = if self.gamma > LAST { EARLY_STEPS } else { LATE_STEPS };
        if is_over || self.tries >= limit {
            self.tries = 0;
            if self.gamma <= LAST {
                self.exact = Some((guess.clone(), 0));
            }
            self.gamma *= 0.01;
        }
        Ok(Outcome::Guess(guess))
    }

    /// φ = ±t on the free angles, μ = 0 (or a bound) elsewhere; then the signs are looked at.
    fn exact_step(
        &mut self,
        problem: &mut Problem,
        two_ring: &mut TwoRing,
        mut set: ActiveSet,
        corrections: usize,
    ) -> Result<Outcome, LinalgError> {
        let n = self.phi.len();
        let is_free: Vec<bool> = (0..n).map(|i| set.stances[i] == Stance::Free).collect();
        let mut is_out = problem.empty_grounds(|i| is_free[i]);
        for i in 0..n {
            is_out[i] |= is_free[i];
        }
        two_ring.factor(&vec![0.0; n], &is_out)?;
        problem.system.factorisations += 1;
        let mut phi = self.phi.clone();
        for i in (0..n).filter(|&i| is_free[i]) {
            phi[i] = problem.target(&set, i);
        }
        let mut rest = vec![0.0; n];
        // The first solve leaves what B's condition makes of rounding; two more clear that away.
        for _ in 0..3 {
            problem.remainder(&set, &phi, &mut rest);
            two_ring.solve(&mut rest, 1);
            phi.iter_mut().zip(&rest).for_each(|(p, d)| *p += d);
        }
        problem.remainder(&set, &phi, &mut rest);
        for i in (0..n).filter(|&i| is_free[i]) {
            set.angles[i] += rest[i];
        }
        problem.shift(&set, &mut phi);
        let solved = set.clone();
        let tolerance = 1e-9 * problem.params.lambda;
        let mut changes = 0;
        set.order.clear();
        for i in 0..n {
            if is_free[i] {
                let [low, high] = problem.interval(&set, i);
                let angle = set.angles[i];
                if angle < low || angle > high {
                    let bound = if angle < low { low } else { high };
                    set.angles[i] = bound;
                    set.stances[i] = problem.stance_at(i, bound);
                    changes += 1;
                } else {
                    set.order.push(i as u32);
                }
            } else {
                let (excess, sign) = problem.excess(&set, i, phi[i]);
                if excess > tolerance {
                    set.release(i as u32, sign);
                    changes += 1;
                }
            }
        }
        if changes == 0 {
            let set = self.finish(problem, two_ring, solved);
            return Ok(Outcome::Optimum(set));
        }
        if corrections < CORRECTIONS {
            self.exact = Some((set, corrections + 1));
            self.phi = phi;
            return Ok(Outcome::Guess(solved));
        }
        if self.gamma < SMALLEST { Ok(Outcome::Lost) } else { Ok(Outcome::Guess(solved)) }
    }

    /// Brings φ of the very angles, by accurate solves, to its targets.
    ///
    /// **Takes** the factor without the rows of the free angles.
    fn finish(
        &self,
        problem: &mut Problem,
        two_ring: &mut TwoRing,
        mut set: ActiveSet,
    ) -> ActiveSet {
        let n = self.phi.len();
        let mut best = (f64::INFINITY, set.clone());
        for _ in 0..4 {
            let (response, certificate) = problem.assess(&set, true);
            if certificate.support < best.0 {
                best = (certificate.support, set.clone());
            }
            if certificate.support < 1e-12 {
                break;
            }
            let mut phi = response.phi;
            problem.shift(&set, &mut phi);
            // A change of φ that is what is missing at free angles and takes no angle elsewhere.
            let mut change = vec![0.0; n];
            for &i in &set.order {
                change[i as usize] = problem.target(&set, i as usize) - phi[i as usize];
            }
            let mut rest = vec![0.0; n];
            for _ in 0..2 {
                problem.curvature_of_dual(&change, &mut rest);
                rest.iter_mut().for_each(|r| *r = -*r);
                two_ring.solve(&mut rest, 1);
                change.iter_mut().zip(&rest).for_each(|(c, d)| *c += d);
            }
            problem.curvature_of_dual(&change, &mut rest);
            for &i in &set.order {
                set.angles[i as usize] -= rest[i as usize];
            }
        }
        best.1
    }
}

/// J for one γ.
struct Regularised {
    gamma: f64,
}

impl Regularised {
    fn angle(&self, problem: &Problem, i: usize, phi: f64) -> f64 {
        if problem.start.stances[i] == Stance::Held {
            return problem.start.angles[i];
        }
        let t = problem.price(i);
        ((phi - phi.clamp(-t, t)) / self.gamma).clamp(problem.low[i], problem.high[i])
    }

    /// h at φ: sup of φ μ − t |μ| − ½ γ μ², taken at μ_γ(φ).
    fn worth(&self, problem: &Problem, i: usize, phi: f64) -> f64 {
        let mu = self.angle(problem, i, phi);
        phi * mu - problem.price(i) * mu.abs() - 0.5 * self.gamma * mu * mu
    }

    fn slope(&self, problem: &Problem, i: usize, phi: f64) -> f64 {
        if problem.start.stances[i] == Stance::Held {
            return 0.0;
        }
        let t = problem.price(i);
        let mu = (phi - phi.clamp(-t, t)) / self.gamma;
        let is_open = mu > problem.low[i] && mu < problem.high[i];
        // Where nothing is to be paid there is no dead zone.
        if is_open && (mu != 0.0 || t == 0.0) { 1.0 / self.gamma } else { 0.0 }
    }

    fn value(&self, problem: &mut Problem, phi: &[f64]) -> (f64, Vec<f64>) {
        let mut gradient = vec![0.0; phi.len()];
        let square = problem.curvature_of_dual(phi, &mut gradient);
        let mut value = 0.5 * square;
        for i in 0..phi.len() {
            let k = problem.system.curvatures[i];
            value += self.worth(problem, i, phi[i]) - k * phi[i];
            gradient[i] += self.angle(problem, i, phi[i]) - k;
        }
        (value, gradient)
    }

    /// Shifts φ on floating components to where J is least: there μ_γ adds up to what Gauss–Bonnet asks for.
    fn choose_constants(&self, problem: &Problem, phi: &mut [f64]) {
        for (c, component) in problem.system.components.iter().enumerate() {
            if !component.is_floating {
                continue;
            }
            let members: Vec<usize> =
                (0..phi.len()).filter(|&i| problem.system.component_of[i] as usize == c).collect();
            let miss = |shift: f64| -> f64 {
                let sum: f64 =
                    members.iter().map(|&i| self.angle(problem, i, phi[i] + shift)).sum();
                sum - component.total
            };
            let reach = members.iter().fold(self.gamma * component.total.abs(), |m: f64, &i| {
                m.max(phi[i].abs() + problem.price(i))
            });
            let (mut low, mut high) = (-2.0 * reach, 2.0 * reach);
            if miss(0.0) == 0.0 {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if miss(middle) > 0.0 { high = middle } else { low = middle }
            }
            let shift = 0.5 * (low + high);
            members.iter().for_each(|&i| phi[i] += shift);
        }
    }

    /// The angles of φ and how they stand.
    fn active_set(&self, problem: &Problem, phi: &[f64]) -> ActiveSet {
        let n = phi.len();
        let mut set = ActiveSet {
            angles: (0..n).map(|i| self.angle(problem, i, phi[i])).collect(),
            stances: problem.start.stances.clone(),
            signs: vec![0.0; n],
            order: Vec::new(),
        };
        for i in 0..n {
            if set.stances[i] == Stance::Held {
                continue;
            }
            if self.slope(problem, i, phi[i]) > 0.0 {
                set.release(i as u32, if phi[i] > 0.0 { 1.0 } else { -1.0 });
            } else {
                set.stances[i] = problem.stance_at(i, set.angles[i]);
            }
        }
        set
    }
}

impl Problem {
    /// Sum of the weighted masses: the unit of γ.
    fn area(&self) -> f64 {
        self.system.mass.iter().sum()
    }

    /// B φ at every dof, and φᵀB φ.
    fn curvature_of_dual(&mut self, phi: &[f64], f: &mut [f64]) -> f64 {
        let mut u = vec![0.0; self.system.mass.len()];
        self.system.scale_of(phi, &mut u);
        self.system.curvature_of(&u, f);
        u.iter().zip(&self.system.mass).map(|(u, m)| m * u * u).sum()
    }

    /// Ω − μ − B φ.
    fn remainder(&mut self, set: &ActiveSet, phi: &[f64], rest: &mut [f64]) {
        self.curvature_of_dual(phi, rest);
        for (i, r) in rest.iter_mut().enumerate() {
            *r = self.system.curvatures[i] - set.angles[i] - *r;
        }
    }

    /// The grounds of the floating components where no dof is `held` in place.
    fn empty_grounds(&self, held: impl Fn(usize) -> bool) -> Vec<bool> {
        let mut is_empty = vec![true; self.system.components.len()];
        for i in (0..self.system.len()).filter(|&i| held(i)) {
            is_empty[self.system.component_of[i] as usize] = false;
        }
        let mut out = vec![false; self.system.len()];
        for (component, _) in
            self.system.components.iter().zip(&is_empty).filter(|(c, e)| c.is_floating && **e)
        {
            out[component.ground as usize] = true;
        }
        out
    }

    /// How an angle stands that is not free.
    pub fn stance_at(&self, i: usize, angle: f64) -> Stance {
        if angle > 0.0 && angle >= self.high[i] {
            Stance::High
        } else if angle < 0.0 && angle <= self.low[i] {
            Stance::Low
        } else {
            Stance::Zero
        }
    }

    /// Repairs angles that do not quite add up to what Gauss–Bonnet asks for: what is missing goes where angles are largest.
    /// Says whether that was possible.
    pub fn repair(&self, set: &mut ActiveSet) -> bool {
        for (c, component) in self.system.components.iter().enumerate() {
            if !component.is_floating {
                continue;
            }
            let members: Vec<usize> = (0..self.system.len())
                .filter(|&i| self.system.component_of[i] as usize == c)
                .collect();
            let miss = component.total - members.iter().map(|&i| set.angles[i]).sum::<f64>();
            let place = members
                .iter()
                .copied()
                .filter(|&i| set.stances[i] == Stance::Free)
                .filter(|&i| {
                    let [low, high] = self.interval(set, i);
                    let angle = set.angles[i] + miss;
                    angle >= low && angle <= high
                })
                .max_by(|&a, &b| {
                    set.angles[a].abs().total_cmp(&set.angles[b].abs()).then(b.cmp(&a))
                });
            match place {
                Some(i) => set.angles[i] += miss,
                None if miss.abs() > 1e-9 => return false,
                None => {}
            }
        }
        true
    }
}
