//! What is minimised: prices, bounds and the state of every candidate, and how far a set of angles is from the optimum.
//!
//! ½ uᵀM u + Σ t_i |μ_i|, t = λ w, low ≤ μ ≤ high. At the optimum φ_i = t_i sgn μ_i where 0 ≠ μ_i lies within its bounds, |φ_i| ≤ t_i
//! where μ_i = 0 (only on the side to which μ_i may move), φ_i ≥ t_i where μ_i = high_i, φ_i ≤ −t_i where μ_i = low_i.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::certificate::{Certificate, certify};
use super::error::{ConeConflict, ConeError};
use super::params::{ConeBoundary, ConeFields, ConeParams, FREE_BOUND};
use super::system::{NONE, Response, System};
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Change of u, relative to u, whose errors are nobody's business: a solve leaves 1e-12 of it or less.
const SMALL: f64 = 0.1;

/// How an angle stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Stance {
    /// 0.
    #[default]
    Zero,
    /// Whatever makes φ = ± t.
    Free,
    /// At its lower bound, which is below 0.
    Low,
    /// At its upper bound, which is above 0.
    High,
    /// Not to be changed.
    Held,
}

/// Angles and how they stand, at every dof.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ActiveSet {
    pub angles: Vec<f64>,
    pub stances: Vec<Stance>,
    /// On which side of 0 a free angle is: ±1.
    pub signs: Vec<f64>,
    /// The free angles, in the order in which they became so.
    pub order: Vec<u32>,
}

impl ActiveSet {
    /// Lets an angle free on one side of 0.
    pub fn release(&mut self, i: u32, sign: f64) {
        self.stances[i as usize] = Stance::Free;
        self.signs[i as usize] = sign;
        self.order.push(i);
    }
}

/// The surface, its operators and what is asked for.
pub(super) struct Problem {
    pub system: System,
    pub params: ConeParams,
    /// Price of every dof at λ = 1.
    pub prices: Vec<f64>,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Whether a dof lies inside the surface: a cone, no corner.
    pub is_inside: Vec<bool>,
    /// Where to begin.
    pub start: ActiveSet,
    /// Components on which μ = Ω is optimal for every λ.
    pub settled: Vec<bool>,
    /// Whether that are all of them.
    pub is_convex: bool,
}

impl Problem {
    pub fn new(
        mesh: &Mesh,
        geometry: &Geometry,
        params: &ConeParams,
        fields: &ConeFields,
    ) -> Result<Self, SolveError> {
        params.validate()?;
        fields.validate(mesh.vertex_count())?;
        let system = System::new(mesh, geometry, params.boundary, &fields.distortion_weight)?;
        let is_inside = system.dofs.iter().map(|&v| !system.is_boundary[v as usize]).collect();
        let mut problem = Self {
            system,
            params: *params,
            prices: Vec::new(),
            low: Vec::new(),
            high: Vec::new(),
            is_inside,
            start: ActiveSet::default(),
            settled: Vec::new(),
            is_convex: false,
        };
        problem.ask(params, fields)?;
        Ok(problem)
    }

    /// Sets prices, bounds and the start anew. **Takes** the boundary and distortion weights that the system was made with.
    pub fn ask(&mut self, params: &ConeParams, fields: &ConeFields) -> Result<(), SolveError> {
        let n = self.system.len();
        let convex =
            matches!(params.boundary, ConeBoundary::Convex | ConeBoundary::PolygonalConvex);
        let (mut prices, mut low, mut high) = (vec![1.0; n], vec![0.0; n], vec![0.0; n]);
        let mut stances = vec![Stance::Zero; n];
        let mut angles = vec![0.0; n];
        for i in 0..n {
            let v = self.system.dofs[i] as usize;
            if let Some(w) = fields.cone_cost.get(v) {
                prices[i] = *w;
            }
            if self.is_inside[i] {
                [low[i], high[i]] = params.bounds;
                if fields.excluded.get(v) == Some(&true) {
                    stances[i] = Stance::Held;
                }
            } else {
                [low[i], high[i]] = [if convex { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY];
                prices[i] *= params.boundary_cost;
                if params.boundary == ConeBoundary::Convex {
                    prices[i] = 0.0;
                }
            }
            if low[i] == 0.0 && high[i] == 0.0 {
                stances[i] = Stance::Held;
            }
        }
        let mut is_prescribed = vec![false; n];
        let dof = |vertex: VertexId, angle: f64| match self.system.dof_of[vertex.index()] {
            NONE => Err(ConeError::Conflict { vertex, angle, conflict: ConeConflict::Boundary }),
            i => Ok(i as usize),
        };
        for &(vertex, angle) in &fields.fixed {
            let i = dof(vertex, angle)?;
            let conflict = |conflict| Err(ConeError::Conflict { vertex, angle, conflict }.into());
            if is_prescribed[i] {
                return conflict(ConeConflict::Twice);
            }
            if fields.excluded.get(vertex.index()) == Some(&true) {
                return conflict(ConeConflict::Excluded);
            }
            if !(angle >= low[i] && angle <= high[i] && angle.abs() < 1e3) {
                return conflict(ConeConflict::Bounds);
            }
            is_prescribed[i] = true;
            stances[i] = Stance::Held;
            angles[i] = angle;
        }
        for &vertex in &fields.free {
            let i = dof(vertex, 0.0)?;
            let conflict =
                |conflict| Err(ConeError::Conflict { vertex, angle: 0.0, conflict }.into());
            if is_prescribed[i] {
                return conflict(ConeConflict::Twice);
            }
            if fields.excluded.get(vertex.index()) == Some(&true) {
                return conflict(ConeConflict::Excluded);
            }
            is_prescribed[i] = true;
            prices[i] = 0.0;
            (low[i], high[i]) = (low[i].max(-FREE_BOUND), high[i].min(FREE_BOUND));
        }
        let old = (
            std::mem::replace(&mut self.prices, prices),
            std::mem::replace(&mut self.low, low),
            std::mem::replace(&mut self.high, high),
            std::mem::replace(&mut self.params, *params),
            std::mem::take(&mut self.start),
            std::mem::take(&mut self.settled),
            self.is_convex,
        );
        self.start = ActiveSet { angles, stances, signs: vec![0.0; n], order: Vec::new() };
        self.settle_convex_parts();
        let result = self.make_feasible();
        if result.is_err() {
            (
                self.prices,
                self.low,
                self.high,
                self.params,
                self.start,
                self.settled,
                self.is_convex,
            ) = old;
        }
        result
    }

    /// On closed components whose curvature is nowhere negative (or nowhere positive) and may be its own cone everywhere at one price,
    /// μ = Ω makes u = 0 at the least total angle that Gauss–Bonnet allows: no λ can do better.
    fn settle_convex_parts(&mut self) {
        let system = &self.system;
        let parts = system.components.len();
        let mut is_convex: Vec<bool> =
            system.components.iter().map(|c| c.is_floating && !c.has_boundary).collect();
        let mut price = vec![None; parts];
        for i in 0..system.len() {
            let c = system.component_of[i] as usize;
            let k = system.curvatures[i];
            let same = *price[c].get_or_insert(self.prices[i]);
            // Flat vertices have curvature by rounding only.
            is_convex[c] &= self.start.stances[i] == Stance::Zero
                && self.prices[i].to_bits() == f64::to_bits(same)
                && (k * system.components[c].total > 0.0 || k.abs() < 1e-12)
                && k >= self.low[i]
                && k <= self.high[i];
        }
        for i in 0..system.len() {
            if is_convex[system.component_of[i] as usize] {
                self.start.stances[i] = Stance::Held;
                let k = system.curvatures[i];
                self.start.angles[i] = if k.abs() < 1e-12 { 0.0 } else { k };
            }
        }
        self.is_convex = !is_convex.is_empty() && is_convex.iter().all(|c| *c);
        self.settled = is_convex;
    }

    /// Angles within the bounds that add up to what Gauss–Bonnet asks for on every floating component: as few as will do, where
    /// the curvature is largest.
    fn make_feasible(&mut self) -> Result<(), SolveError> {
        let system = &self.system;
        for (c, component) in system.components.iter().enumerate() {
            if !component.is_floating || self.settled[c] {
                continue;
            }
            let members: Vec<usize> =
                (0..system.len()).filter(|&i| system.component_of[i] as usize == c).collect();
            let held: f64 = members.iter().map(|&i| self.start.angles[i]).sum();
            let mut rest = component.total - held;
            let mut candidates: Vec<usize> = members
                .iter()
                .copied()
                .filter(|&i| self.start.stances[i] == Stance::Zero)
                .collect();
            let limit = |bounds: &[f64]| candidates.iter().map(|&i| bounds[i]).sum::<f64>();
            let (least, most) = (limit(&self.low), limit(&self.high));
            // Curvatures add up to a multiple of 2π with the rounding errors of all corners.
            let slack = 1e-9;
            if rest > most + slack || rest < least - slack {
                return Err(ConeError::OutOfBounds {
                    vertex: VertexId(system.dofs[members[0]]),
                    needed: component.total,
                    least: held + least,
                    most: held + most,
                }
                .into());
            }
            if rest.abs() < slack {
                continue;
            }
            let sign = rest.signum();
            if self.params.boundary == ConeBoundary::Convex && component.has_boundary && rest > 0.0
            {
                // Curvature of the boundary is free of charge: begin with its own.
                let own = |&&i: &&usize| !self.is_inside[i] && system.curvatures[i] > 0.0;
                let sum: f64 = candidates.iter().filter(own).map(|&i| system.curvatures[i]).sum();
                if sum > 0.0 {
                    for &i in candidates.iter().filter(own) {
                        self.start.angles[i] = system.curvatures[i] * rest / sum;
                        self.start.release(i as u32, 1.0);
                    }
                    continue;
                }
            }
            candidates.sort_by(|&a, &b| {
                (sign * system.curvatures[b])
                    .total_cmp(&(sign * system.curvatures[a]))
                    .then(a.cmp(&b))
            });
            for i in candidates {
                let bound = if sign > 0.0 { self.high[i] } else { self.low[i] };
                if bound == 0.0 {
                    continue;
                }
                if rest.abs() < bound.abs() {
                    self.start.angles[i] = rest;
                    self.start.release(i as u32, sign);
                    break;
                }
                self.start.angles[i] = bound;
                self.start.stances[i] = if sign > 0.0 { Stance::High } else { Stance::Low };
                rest -= bound;
                if rest.abs() < slack {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Price of dof `i` now.
    #[inline]
    pub fn price(&self, i: usize) -> f64 {
        self.params.lambda * self.prices[i]
    }

    /// What φ is to be at a free angle.
    #[inline]
    pub fn target(&self, set: &ActiveSet, i: usize) -> f64 {
        self.price(i) * set.signs[i]
    }

    /// The interval that a free angle may move in without changing its sign.
    #[inline]
    pub fn interval(&self, set: &ActiveSet, i: usize) -> [f64; 2] {
        if self.prices[i] == 0.0 {
            [self.low[i], self.high[i]]
        } else if set.signs[i] > 0.0 {
            [0.0, self.high[i]]
        } else {
            [self.low[i], 0.0]
        }
    }

    /// By how much φ is wrong at an angle that is not free, and to which side the angle would have to be let free.
    #[inline]
    pub fn excess(&self, set: &ActiveSet, i: usize, phi: f64) -> (f64, f64) {
        let t = self.price(i);
        match set.stances[i] {
            Stance::Zero if self.high[i] > 0.0 && phi > t => (phi - t, 1.0),
            Stance::Zero if self.low[i] < 0.0 && phi < -t => (-t - phi, -1.0),
            Stance::High if phi < t => (t - phi, 1.0),
            Stance::Low if phi > -t => (phi + t, -1.0),
            _ => (0.0, 0.0),
        }
    }

    /// Adds to φ, on every floating component, the constant that the free angles ask for, or where there are none the one that
    /// leaves the least to be desired.
    pub fn shift(&self, set: &ActiveSet, phi: &mut [f64]) {
        let parts = self.system.components.len();
        let mut sums = vec![(0.0, 0usize); parts];
        let mut range = vec![(f64::NEG_INFINITY, f64::INFINITY); parts];
        for i in 0..phi.len() {
            let c = self.system.component_of[i] as usize;
            let t = self.price(i);
            let (least, most) = &mut range[c];
            match set.stances[i] {
                Stance::Free => {
                    sums[c].0 += self.target(set, i) - phi[i];
                    sums[c].1 += 1;
                }
                Stance::Zero => {
                    if self.high[i] > 0.0 {
                        *most = most.min(t - phi[i]);
                    }
                    if self.low[i] < 0.0 {
                        *least = least.max(-t - phi[i]);
                    }
                }
                Stance::High => *least = least.max(t - phi[i]),
                Stance::Low => *most = most.min(-t - phi[i]),
                Stance::Held => {}
            }
        }
        let shifts: Vec<f64> = (0..parts)
            .map(|c| {
                let component = &self.system.components[c];
                let (least, most) = range[c];
                match sums[c] {
                    _ if !component.is_floating => 0.0,
                    _ if self.settled[c] => {
                        self.params.lambda * self.settled_price(c) * component.total.signum()
                    }
                    (sum, n) if n > 0 => sum / n as f64,
                    _ if least.is_finite() && most.is_finite() => 0.5 * (least + most),
                    _ if least.is_finite() => least,
                    _ if most.is_finite() => most,
                    _ => 0.0,
                }
            })
            .collect();
        for (i, phi) in phi.iter_mut().enumerate() {
            *phi += shifts[self.system.component_of[i] as usize];
        }
    }

    /// The one price on a component whose cones are its curvature.
    fn settled_price(&self, c: usize) -> f64 {
        (0..self.prices.len())
            .find(|&i| self.system.component_of[i] as usize == c)
            .map_or(1.0, |i| self.prices[i])
    }

    /// Response and certificate of a set of angles.
    pub fn assess(&mut self, set: &ActiveSet) -> (Response, Certificate) {
        let response = self.system.respond(&set.angles);
        let certificate = certify(self, set, &response);
        (response, certificate)
    }

    /// The same from the response to angles before; says whether the change was so small that nothing is left to refine.
    pub fn reassess(&mut self, set: &ActiveSet, old: &Response) -> (Response, Certificate, bool) {
        let (response, change) = self.system.follow(&set.angles, old);
        let certificate = certify(self, set, &response);
        (response, certificate, change < SMALL)
    }

    /// Response of any angles, refined.
    pub fn exact_response(&mut self, angles: &[f64], old: &Response) -> Response {
        let (response, change) = self.system.follow(angles, old);
        if change < SMALL { response } else { self.system.follow(angles, &response).0 }
    }
}
