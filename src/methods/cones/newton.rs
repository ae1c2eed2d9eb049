//! The dense range: a semismooth Newton method on the dual variable.
//!
//! The dual of the problem, with the angles regularised by ½ γ |μ|², is to minimise
//!
//! J(φ) = ½ φᵀB φ − Ωᵀφ + Σ h(φ_i), h′ = μ_γ(φ) = clip(P_t(φ) / γ, low, high), P_t(φ) = φ − clip(φ, −t, t).
//!
//! J has a continuous gradient and a piecewise constant Hessian B + D, D = 1/γ where μ_γ follows φ. γ falls by factors of 100; with
//! each, a few Newton steps with an exact line search. At last γ = 0: φ = ±t is prescribed on the active set, the rest follows from
//! one factorisation without these rows, and the active set is corrected by signs until it stands. One analysis of B's pattern serves all
//! factorisations.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::certificate::certify;
use super::greens::entering;
use super::problem::{ActiveSet, Problem, Stance};
use super::two_ring::TwoRing;
use crate::linalg::LinalgError;

/// First γ, as a fraction of the area, when nothing is known; from the curvature alone a smaller one needs more steps, not fewer.
const FIRST: f64 = 1.0;
/// γ after which the exact active set is looked for. With smaller ones the line searches take over, and the exact stage alone is faster.
const LAST: f64 = 1e-6;
/// Newton steps for one γ: none is worth solving exactly, it only leads to the next.
const STEPS: usize = 3;
/// Corrections of the exact active set in all, and in a row without fewer changes than ever before.
const CORRECTIONS: usize = 40;
const PATIENCE: usize = 10;
/// Excess of |φ| over t, as a fraction of t, that is let in everywhere and not at its peaks only. With larger ones whole surroundings of
/// cones come in and have to be peeled off again.
const SMALL: f64 = 0.01;
/// Such corrections after which the set goes in circles.
const CIRCLES: usize = 3;

/// Where Newton's method is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Descent {
    pub phi: Vec<f64>,
    gamma: f64,
    /// Newton steps with this γ.
    tries: usize,
    exact: Option<Exact>,
}

/// The stage with γ = 0.
#[derive(Clone, Debug, PartialEq)]
struct Exact {
    set: ActiveSet,
    corrections: usize,
    /// Fewest changes that a correction made, and corrections since.
    fewest: usize,
    since: usize,
}

impl Exact {
    fn new(set: ActiveSet) -> Self {
        Self { set, corrections: 0, fewest: usize::MAX, since: 0 }
    }
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
    /// From nothing. **Takes** φ at every dof, shifted.
    pub fn cold(phi: Vec<f64>) -> Self {
        Self { phi, gamma: FIRST, tries: 0, exact: None }
    }

    /// From angles that are near the optimum already: the exact stage alone.
    pub fn warm(phi: Vec<f64>, set: ActiveSet) -> Self {
        Self { phi, gamma: FIRST, tries: 0, exact: Some(Exact::new(set)) }
    }

    /// One factorisation and what follows from it.
    pub fn step(
        &mut self,
        problem: &mut Problem,
        two_ring: &mut TwoRing,
    ) -> Result<Outcome, LinalgError> {
        match self.exact.take() {
            None => self.smooth_step(problem, two_ring),
            Some(exact) => self.exact_step(problem, two_ring, exact),
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
        let mut direction = regular.gradient(problem, &self.phi);
        direction.iter_mut().for_each(|g| *g = -*g);
        two_ring.solve(&mut direction, 1);
        let fraction = regular.line_search(problem, &self.phi, &direction);
        self.phi.iter_mut().zip(&direction).for_each(|(p, d)| *p += fraction * d);
        let guess = regular.active_set(problem, &self.phi);
        // A whole step that leaves every piece as it was has found the minimum of J.
        let is_over = fraction >= 1.0
            && (0..n)
                .all(|i| regular.slope(problem, i, self.phi[i]).to_bits() == slopes[i].to_bits());
        self.tries += 1;
        if is_over || self.tries >= STEPS {
            self.tries = 0;
            self.gamma *= 0.01;
            if self.gamma < 0.5 * LAST {
                self.exact = Some(Exact::new(peaks(problem, &guess, &self.phi)));
            }
        }
        Ok(Outcome::Guess(guess))
    }

    /// φ = ±t on the free angles, μ = 0 (or a bound) elsewhere; then the signs are looked at.
    fn exact_step(
        &mut self,
        problem: &mut Problem,
        two_ring: &mut TwoRing,
        exact: Exact,
    ) -> Result<Outcome, LinalgError> {
        let Exact { mut set, corrections, mut fewest, mut since } = exact;
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
        for i in (0..n).filter(|&i| is_free[i]) {
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
        }
        // When it goes in circles, angles are let free only where all others have the right sign.
        if changes == 0 || since < CIRCLES {
            // What was taken out just now has φ = ±t: no excess.
            for (i, sign) in entering(problem, &set, &phi, tolerance, usize::MAX) {
                set.release(i, sign);
                changes += 1;
            }
            // Where φ is almost right already, peaks alone would grow wide patches of cones one vertex at a time.
            for i in 0..n {
                let (excess, sign) = problem.excess(&set, i, phi[i]);
                if excess > tolerance && excess < SMALL * problem.price(i) {
                    set.release(i as u32, sign);
                    changes += 1;
                }
            }
        }
        if changes == 0 {
            let set = self.finish(problem, two_ring, solved);
            return Ok(Outcome::Optimum(set));
        }
        since = if changes < fewest { 0 } else { since + 1 };
        fewest = fewest.min(changes);
        self.phi = phi;
        if corrections < CORRECTIONS && since < PATIENCE {
            let guess = set.clone();
            self.exact = Some(Exact { set, corrections: corrections + 1, fewest, since });
            return Ok(Outcome::Guess(guess));
        }
        Ok(Outcome::Lost)
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
        let mut response = problem.system.respond(&set.angles);
        for _ in 0..4 {
            response = problem.exact_response(&set.angles, &response);
            let certificate = certify(problem, &set, &response);
            if certificate.support < best.0 {
                best = (certificate.support, set.clone());
            }
            if certificate.support < 1e-12 {
                break;
            }
            let mut phi = response.phi.clone();
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

/// The angles of a regularised optimum at peaks only: of every patch that γ has spread a cone over, its middle.
fn peaks(problem: &Problem, guess: &ActiveSet, phi: &[f64]) -> ActiveSet {
    let mut set = guess.clone();
    set.order.clear();
    for i in 0..phi.len() {
        if set.stances[i] == Stance::Free {
            set.stances[i] = Stance::Zero;
            set.angles[i] = 0.0;
        }
    }
    for (i, sign) in entering(problem, &set, phi, 0.0, usize::MAX) {
        set.release(i, sign);
    }
    set
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

    fn gradient(&self, problem: &mut Problem, phi: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; phi.len()];
        problem.curvature_of_dual(phi, &mut gradient);
        for (i, g) in gradient.iter_mut().enumerate() {
            *g += self.angle(problem, i, phi[i]) - problem.system.curvatures[i];
        }
        gradient
    }

    /// The fraction of a step, at most 1, at which J is least along it: its derivative there is monotone and costs O(V) once B is
    /// applied to both ends.
    fn line_search(&self, problem: &mut Problem, phi: &[f64], direction: &[f64]) -> f64 {
        let mut product = vec![0.0; phi.len()];
        let square = problem.curvature_of_dual(direction, &mut product);
        let linear: f64 = (0..phi.len())
            .map(|i| product[i] * phi[i] - problem.system.curvatures[i] * direction[i])
            .sum();
        let derivative = |x: f64| -> f64 {
            let bent = |i: usize| self.angle(problem, i, phi[i] + x * direction[i]) * direction[i];
            linear + x * square + (0..phi.len()).map(bent).sum::<f64>()
        };
        if derivative(1.0) <= 1e-9 * derivative(0.0).abs() {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if derivative(middle) > 0.0 { high = middle } else { low = middle }
        }
        high
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
            if miss(0.0).abs() <= 0.0 {
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
