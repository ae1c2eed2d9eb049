//! The objective of one split, or of several splits at once, as a function without constraints.
//!
//! F = Σ over splits of P + penalty + ω J + ε^−κ (C[u] + C[−u]), where the weight of a split below another one is that one's
//! indicator. Fields are moved to their prescribed areas first ([`area::project`]), from the top down; the gradient comes back from the
//! bottom up.

use super::domain::Domain;
use super::params::PhaseFieldParams;
use super::profile::indicator;
use super::terms::connected::{Parts, Proof};
use super::terms::perimeter::Perimeter;
use super::terms::yamabe::Yamabe;
use super::terms::{area, connected};
use crate::linalg::{LinalgError, dot};

/// A split that takes part.
#[derive(Clone)]
pub(super) struct Member {
    /// The member that made this one's segment, and the sign of its side; otherwise `weight` is given.
    pub parent: Option<(usize, f64)>,
    /// w, where it is given.
    pub weight: Vec<f64>,
    perimeter: Option<Perimeter>,
    /// m w and its sum, where w is given.
    measure: (Vec<f64>, f64),
}

/// The terms of one split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SplitTerms {
    /// Diffuse perimeter P, about √2 times the length of the interface.
    pub perimeter: f64,
    /// The penalty that keeps the field at 0 outside of the segment.
    pub penalty: f64,
    /// C[u] + C[−u]: 0 where both phases are connected, or while it is left out.
    pub connectedness: f64,
    /// Diffuse distortion J of both phases; with ω = 0 measured at the end of a split, 0 before.
    pub yamabe: f64,
    /// Share of the segment's area in the positive phase.
    pub area_fraction: f64,
    /// What the share misses of what was asked for.
    pub area_error: f64,
}

/// A point of the search: fields, terms and gradient.
#[derive(Clone, Default)]
pub(super) struct Evaluation {
    /// F.
    pub value: f64,
    /// The fields one after the other, with their areas.
    pub u: Vec<f64>,
    pub terms: Vec<SplitTerms>,
    /// Derivative of F by each field, others and areas apart.
    by_field: Vec<f64>,
    /// The same by each weight.
    by_weight: Vec<f64>,
    /// The weights that were used.
    weights: Vec<f64>,
}

/// Which terms count how much.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prices {
    pub epsilon: f64,
    pub sigma: f64,
    pub fraction: f64,
    pub omega: f64,
    pub lambda: f64,
    /// Of distortion: see [`PhaseFieldParams::reach`].
    pub reach: fn(f64) -> (f64, f64),
    /// Of unconnected phases.
    pub parts: f64,
}

impl Prices {
    pub fn new(params: &PhaseFieldParams, is_connected: bool) -> Self {
        let epsilon = params.epsilon;
        Self {
            epsilon,
            // As wide as the interface: less would press the field down inside the segment, more lets it leak out.
            sigma: epsilon,
            fraction: params.fraction,
            omega: params.omega,
            lambda: params.lambda(),
            reach: params.reach(),
            parts: if is_connected { epsilon.powf(-params.kappa) } else { 0.0 },
        }
    }
}

impl Member {
    /// A split of a segment with this weight.
    pub fn given(weight: Vec<f64>) -> Self {
        Self { parent: None, weight, perimeter: None, measure: Default::default() }
    }

    /// A split of a side of another member.
    pub fn below(parent: usize, sign: f64) -> Self {
        Self {
            parent: Some((parent, sign)),
            weight: Vec::new(),
            perimeter: None,
            measure: Default::default(),
        }
    }
}

/// F and the memory to evaluate it again and again.
pub(super) struct Objective {
    pub members: Vec<Member>,
    pub prices: Prices,
    yamabe: Yamabe,
    /// Of each member's phases.
    proofs: Vec<Proof>,
}

impl Objective {
    /// Assembles what does not change.
    pub fn new(domain: &Domain, mut members: Vec<Member>, prices: Prices) -> Self {
        for member in members.iter_mut().filter(|m| m.parent.is_none()) {
            let Prices { epsilon, sigma, .. } = prices;
            member.perimeter = Some(Perimeter::new(domain, &member.weight, epsilon, sigma));
            member.measure = measure(&domain.mass, &member.weight);
        }
        let proofs = vec![Proof::default(); members.len()];
        Self { members, prices, yamabe: Yamabe::default(), proofs }
    }

    /// F at trial fields, which are moved to their areas along `directions`.
    pub fn evaluate(
        &mut self,
        domain: &Domain,
        trial: &[f64],
        directions: &[f64],
    ) -> Result<Evaluation, LinalgError> {
        let n = domain.len();
        let mut u = trial.to_vec();
        let mut weights = vec![0.0; u.len()];
        let mut by_field = vec![0.0; u.len()];
        // Nobody asks for it where all weights are given.
        let is_free = self.members.len() > 1;
        let mut by_weight = vec![0.0; if is_free { u.len() } else { 0 }];
        let (mut value, mut terms) = (0.0, Vec::with_capacity(self.members.len()));
        for i in 0..self.members.len() {
            let own = i * n..(i + 1) * n;
            match self.members[i].parent {
                None => weights[own.clone()].copy_from_slice(&self.members[i].weight),
                Some((parent, sign)) => {
                    for v in 0..n {
                        let at = parent * n + v;
                        weights[own.start + v] = weights[at] * indicator(sign * u[at]).0;
                    }
                }
            }
            let w = &weights[own.clone()];
            let made;
            let (mw, whole) = if self.members[i].parent.is_none() {
                &self.members[i].measure
            } else {
                made = measure(&domain.mass, w);
                &made
            };
            let whole = *whole;
            let target = self.prices.fraction * whole;
            let field = &mut u[own.clone()];
            let excess = area::project(mw, [whole, target], &directions[own.clone()], field);
            let by_own = if is_free { &mut by_weight[own.clone()] } else { &mut [][..] };
            let gradients = [&mut by_field[own.clone()], by_own];
            let mut split = self.add_terms(domain, i, field, w, gradients)?;
            split.area_error = (excess / whole).abs();
            split.area_fraction = self.prices.fraction + excess / whole;
            let Prices { omega, parts, .. } = self.prices;
            value += split.perimeter
                + split.penalty
                + omega * split.yamabe
                + parts * split.connectedness;
            terms.push(split);
        }
        Ok(Evaluation { value, u, terms, by_field, by_weight, weights })
    }

    /// The terms of one split with their gradients.
    fn add_terms(
        &mut self,
        domain: &Domain,
        member: usize,
        u: &[f64],
        w: &[f64],
        [by_field, by_weight]: [&mut [f64]; 2],
    ) -> Result<SplitTerms, LinalgError> {
        let Prices { epsilon, sigma, omega, lambda, reach, parts, .. } = self.prices;
        let mut split = SplitTerms::default();
        let is_free = self.members[member].parent.is_some();
        let made;
        let perimeter = match &self.members[member].perimeter {
            Some(perimeter) => perimeter,
            None => {
                made = Perimeter::new(domain, w, epsilon, sigma);
                &made
            }
        };
        [split.perimeter, split.penalty] = perimeter.add(domain, u, by_field);
        if is_free {
            Perimeter::add_by_weight(domain, u, epsilon, sigma, by_weight);
        }
        if !(omega > 0.0 || parts > 0.0) {
            return Ok(split);
        }
        let e1 = connected::edge(epsilon);
        let proof = &mut self.proofs[member];
        let is_whole = parts <= 0.0 || proof.holds(|f| domain.face_mean(f, u), e1, domain);
        if !(omega > 0.0) && is_whole {
            return Ok(split);
        }
        let u_faces = domain.face_means(u);
        let pieces = (!is_whole).then(|| Parts::new(domain, &u_faces, e1));
        if pieces.as_ref().is_some_and(|p| p.counts.iter().all(|&c| c < 2)) {
            proof.renew(&u_faces, e1, domain);
            if !(omega > 0.0) {
                return Ok(split);
            }
        }
        let w_faces = domain.face_means(w);
        let mut face_gradients = [vec![0.0; u_faces.len()], vec![0.0; u_faces.len()]];
        for sign in [1.0, -1.0] {
            let [by_u, by_w] = &mut face_gradients;
            if let Some(pieces) = &pieces {
                split.connectedness += connected::add(
                    domain,
                    [&u_faces, &w_faces],
                    pieces,
                    sign,
                    epsilon,
                    parts,
                    [by_u, by_w],
                );
            }
            if omega > 0.0 {
                let y: Vec<f64> = u.iter().zip(w).map(|(u, w)| w * reach(sign * u).0).collect();
                let chi: Vec<_> = u_faces.iter().map(|u| reach(sign * u)).collect();
                let y_faces: Vec<f64> = chi.iter().zip(&w_faces).map(|(c, w)| c.0 * w).collect();
                let mut by_y = vec![0.0; y.len()];
                let mut by_y_face = vec![0.0; y_faces.len()];
                split.yamabe += self.yamabe.add(
                    domain,
                    [&y, &y_faces],
                    lambda,
                    omega,
                    [&mut by_y, &mut by_y_face],
                )?;
                for (v, g) in by_y.iter().enumerate() {
                    let (chi, slope) = reach(sign * u[v]);
                    by_field[v] += g * w[v] * sign * slope;
                    if let Some(by_weight) = by_weight.get_mut(v) {
                        *by_weight += g * chi;
                    }
                }
                for (f, g) in by_y_face.iter().enumerate() {
                    by_u[f] += g * w_faces[f] * sign * chi[f].1;
                    by_w[f] += g * chi[f].0;
                }
            }
        }
        let [by_u, by_w] = &face_gradients;
        for (f, t) in domain.triangles.iter().enumerate() {
            for &v in t {
                by_field[v as usize] += by_u[f] / 3.0;
                if let Some(by_weight) = by_weight.get_mut(v as usize) {
                    *by_weight += by_w[f] / 3.0;
                }
            }
        }
        Ok(split)
    }

    /// Directions w χ′(u) along which fields are moved to their areas from there.
    pub fn directions(&self, at: &Evaluation) -> Vec<f64> {
        Self::direction(&at.u, &at.weights).collect()
    }

    /// The direction of one field with the weight of its segment.
    pub fn direction(u: &[f64], w: &[f64]) -> impl Iterator<Item = f64> {
        // A little everywhere: a field of ±1 alone must be able to move as well.
        u.iter().zip(w).map(|(&u, w)| w * (indicator(u).1 + 0.01))
    }

    /// The gradient of F by trial fields at the fields of an evaluation, when areas are kept along `directions`.
    pub fn reduce(&self, domain: &Domain, at: &Evaluation, directions: &[f64]) -> Vec<f64> {
        let n = domain.len();
        let (mut gradient, mut by_weight) = (at.by_field.clone(), at.by_weight.clone());
        for i in (0..self.members.len()).rev() {
            let own = i * n..(i + 1) * n;
            let (u, w) = (&at.u[own.clone()], &at.weights[own.clone()]);
            let direction = &directions[own.clone()];
            let slopes: Vec<f64> =
                (0..n).map(|v| domain.mass[v] * w[v] * indicator(u[v]).1).collect();
            let across = dot(&slopes, direction);
            let g = &mut gradient[own.clone()];
            let multiplier = if across > 0.0 { -dot(g, direction) / across } else { 0.0 };
            for (g, a) in g.iter_mut().zip(&slopes) {
                *g += multiplier * a;
            }
            let Some((parent, sign)) = self.members[i].parent else { continue };
            for v in 0..n {
                let chi = indicator(u[v]).0;
                let by = by_weight[own.start + v]
                    + multiplier * domain.mass[v] * (chi - self.prices.fraction);
                let at_parent = parent * n + v;
                let (chi, slope) = indicator(sign * at.u[at_parent]);
                gradient[at_parent] += by * at.weights[at_parent] * sign * slope;
                by_weight[at_parent] += by * chi;
            }
        }
        gradient
    }

    /// The diagonal that L-BFGS measures gradients with: the curvature of the perimeter term in the phases.
    pub fn diagonal(&self, domain: &Domain, at: &Evaluation) -> Vec<f64> {
        let n = domain.len();
        let mut diagonal = vec![1.0; at.u.len()];
        for (i, member) in self.members.iter().enumerate() {
            let Prices { epsilon, sigma, .. } = self.prices;
            let w = &at.weights[i * n..(i + 1) * n];
            let made;
            let perimeter = match &member.perimeter {
                Some(perimeter) => perimeter,
                None => {
                    made = Perimeter::new(domain, w, epsilon, sigma);
                    &made
                }
            };
            for v in 0..n {
                let curvature = perimeter.curvature(domain, v);
                if curvature > 0.0 {
                    diagonal[i * n + v] = curvature;
                }
            }
        }
        diagonal
    }
}

/// Products entry by entry, and their sum.
fn measure(mass: &[f64], weight: &[f64]) -> (Vec<f64>, f64) {
    (mass.iter().zip(weight).map(|(m, w)| m * w).collect(), dot(mass, weight))
}
