//! λ_max: the price from which on nothing changes.
//!
//! On grounded components, and on floating ones whose angles add up to 0, no cones are worth it above λ_max = min over constants c of
//! max |φ + c| / w, with φ of the surface without cones. On other closed components there must be cones; once all have the same
//! sign their total angle cannot fall any more. From such a *saturated* optimum λ_max follows exactly; before one is known, the
//! spread of φ for cones spread evenly stands in for it.

use super::problem::{ActiveSet, Problem, Stance};

/// λ_max of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extent {
    pub value: f64,
    /// Whether it is more than an estimate.
    pub is_exact: bool,
}

/// For every component its λ_max, as well as can be said without an optimum. **Costs** one response where a component is closed and has χ ≠ 0.
pub(super) fn estimate(problem: &mut Problem, phi: &[f64]) -> Vec<Extent> {
    let n = problem.system.len();
    let components = problem.system.components.clone();
    let part: Vec<usize> = problem.system.component_of.iter().map(|&c| c as usize).collect();
    let must_have = |c: usize| components[c].is_floating && components[c].total.abs() > 1e-6;
    let mut phi = phi.to_vec();
    if (0..components.len()).any(|c| must_have(c) && !problem.settled[c]) {
        let even: Vec<f64> = (0..n)
            .map(|i| {
                let component = &components[part[i]];
                let mass = problem.system.mass[problem.system.dofs[i] as usize];
                if component.is_floating { component.total * mass / component.mass } else { 0.0 }
            })
            .collect();
        let response = problem.system.respond(&even);
        for i in 0..n {
            if must_have(part[i]) {
                phi[i] = response.phi[i];
            }
        }
    }
    (0..components.len())
        .map(|c| {
            if problem.settled[c] {
                return Extent { value: 0.0, is_exact: true };
            }
            let members: Vec<usize> = (0..n).filter(|&i| part[i] == c).collect();
            let value = least(problem, &members, &phi, components[c].is_floating, must_have(c));
            // Angles that are free of charge are not in φ yet.
            let is_priced =
                |&i: &usize| problem.prices[i] > 0.0 || problem.start.stances[i] == Stance::Held;
            Extent { value, is_exact: members.iter().all(is_priced) && !must_have(c) }
        })
        .collect()
}

/// min over c (0 if not floating) of the largest |φ + c| / w at candidates that may move to that side.
fn least(
    problem: &Problem,
    members: &[usize],
    phi: &[f64],
    is_floating: bool,
    is_even: bool,
) -> f64 {
    let candidates: Vec<usize> = members
        .iter()
        .copied()
        .filter(|&i| problem.prices[i] > 0.0)
        .filter(|&i| is_even || problem.start.stances[i] != Stance::Held)
        .collect();
    let worth = |c: f64| -> f64 {
        candidates.iter().fold(0.0, |m: f64, &i| {
            let x = (phi[i] + c) / problem.prices[i];
            let side = if x > 0.0 { problem.high[i] > 0.0 } else { problem.low[i] < 0.0 };
            if side || is_even { m.max(x.abs()) } else { m }
        })
    };
    if !is_floating {
        return worth(0.0);
    }
    // Convex in c.
    let (mut low, mut high) =
        members.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| {
            (low.min(-phi[i]), high.max(-phi[i]))
        });
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if worth(a) <= worth(b) { high = b } else { low = a }
    }
    worth(0.5 * (low + high))
}

/// λ_max of every component for which the optimum at hand tells it: no priced angle is open to change, or all have one sign and price.
///
/// **Takes** the optimum with its φ, shifted.
pub(super) fn from_optimum(problem: &Problem, set: &ActiveSet, phi: &[f64]) -> Vec<Option<f64>> {
    let parts = problem.system.components.len();
    // Price and sign of the priced angles that are not 0; NaN where they differ.
    let mut seen: Vec<Option<[f64; 2]>> = vec![None; parts];
    let mut is_told: Vec<bool> = (0..parts).map(|c| !problem.settled[c]).collect();
    for i in 0..phi.len() {
        let c = problem.system.component_of[i] as usize;
        if set.stances[i] == Stance::Held || set.angles[i] == 0.0 {
            continue;
        }
        let own = [problem.prices[i], set.angles[i].signum()];
        let same = |a: [f64; 2]| a.map(f64::to_bits) == own.map(f64::to_bits);
        match seen[c] {
            // Free of charge next to priced ones: the path goes on for ever, in principle.
            Some(other) if !same(other) => is_told[c] = false,
            _ => seen[c] = Some(own),
        }
    }
    let lambda = problem.params.lambda;
    let mut found: Vec<f64> = vec![0.0; parts];
    for i in 0..phi.len() {
        let c = problem.system.component_of[i] as usize;
        if set.stances[i] != Stance::Zero || problem.prices[i] == 0.0 {
            continue;
        }
        let [price, sign] = seen[c].unwrap_or([0.0, 1.0]);
        if price > 0.0 && !problem.system.components[c].is_floating {
            is_told[c] = false;
        }
        // φ at λ′ is `rest` + λ′ · price, seen from the side of the cones.
        let rest = sign * phi[i] - lambda * price;
        let own = problem.prices[i];
        let (up, down) = if sign > 0.0 {
            (problem.high[i] > 0.0, problem.low[i] < 0.0)
        } else {
            (problem.low[i] < 0.0, problem.high[i] > 0.0)
        };
        if up && own > price {
            found[c] = found[c].max(rest / (own - price));
        }
        if down {
            found[c] = found[c].max(-rest / (own + price));
        }
    }
    (0..parts).map(|c| is_told[c].then_some(found[c])).collect()
}
