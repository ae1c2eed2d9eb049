//! The best angles at given places.
//!
//! The price of angles makes cones smaller than they would be where they are, and merging moves them: with the places fixed,
//!
//! minimise ½ uᵀM u over the angles, each within its bounds, adding up to 2πχ on closed components,
//!
//! is a small dense least-squares problem over the Green's functions that the flow has, solved by the active set of [`super::greens`]
//! with price 0.

use std::f64::consts::PI;

use super::greens;
use super::params::FREE_BOUND;
use super::problem::{ActiveSet, Stance};
use super::system::NONE;
use super::{Cone, ConeFlow};
use crate::mesh::VertexId;
use crate::methods::flow::SolveError;

/// Largest angle that is given to a cone inside, radians: a quarter turn is left about it. Without this limit one of the four cones of rocker
/// arm at λ = .05 goes to 2π, which is a spike that no chart can hold, for 2 % less distortion.
pub(super) const MOST: f64 = 1.5 * PI;

/// Rounds of the dense problem; the second one takes away what rounding left, further ones nothing.
const ROUNDS: usize = 3;

/// Rounding of φ, over its largest value.
pub(super) const TOLERANCE: f64 = 1e-12;

/// The angles at the places of some cones that distort least, within the flow's bounds and (−2π, 3π/2), (−2π, π) at corners.
///
/// **Takes** cones that [`ConeFlow::evaluate`] takes; vertices whose angles are not to change. **Gives** as many cones at the same
/// vertices, by ascending vertex. The flow is as before afterwards.
/// **Fails** as [`ConeFlow::evaluate`]. **Costs** two solves for each place whose Green's function the flow has not computed yet (those of
/// an active set are), and three responses.
pub fn debias(
    flow: &mut ConeFlow,
    cones: &[Cone],
    held: &[VertexId],
) -> Result<Vec<Cone>, SolveError> {
    // Says what is wrong with the cones, if anything.
    flow.evaluate(cones)?;
    let dof_of = &flow.problem.system.dof_of;
    let dofs = flow.problem.system.len();
    let mut set = ActiveSet {
        angles: vec![0.0; dofs],
        stances: vec![Stance::Held; dofs],
        signs: vec![1.0; dofs],
        order: Vec::new(),
    };
    let mut has_corners = false;
    for cone in cones {
        let i = dof_of[cone.vertex.index()];
        debug_assert!(i != NONE);
        set.angles[i as usize] += cone.angle;
        has_corners |= !flow.problem.is_inside[i as usize];
        if !held.contains(&cone.vertex) && set.stances[i as usize] == Stance::Held {
            set.release(i, 1.0);
        }
    }
    if !has_corners {
        for i in (0..dofs).filter(|&i| !flow.problem.is_inside[i]) {
            set.angles[i] = flow.progress.set.angles[i];
        }
    }

    let (mut low, mut high) = (vec![0.0; dofs], vec![0.0; dofs]);
    for i in 0..dofs {
        let angle = set.angles[i];
        let [least, most] = if flow.problem.is_inside[i] {
            flow.problem.params.bounds
        } else {
            [flow.problem.low[i], PI * (1.0 - 1e-6)]
        };
        // What is out of bounds may stay there but not go farther.
        low[i] = least.max(-FREE_BOUND).min(angle);
        high[i] = most.min(MOST).max(angle);
    }
    let mut dictionary = flow.dictionary.clone();
    let problem = &mut flow.problem;
    let missing = dictionary.missing(&set.order);
    dictionary.add(problem, &missing);
    let prices = std::mem::replace(&mut problem.prices, vec![0.0; dofs]);
    std::mem::swap(&mut problem.low, &mut low);
    std::mem::swap(&mut problem.high, &mut high);
    let mut response = flow.response.clone();
    for _ in 0..ROUNDS {
        response = problem.exact_response(&set.angles, &response);
        let phi = greens::shifted(problem, &set, &response);
        let size = phi.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let tolerance = TOLERANCE * size;
        if greens::settle(problem, &dictionary, &mut set, &phi, tolerance).moved == 0.0 {
            break;
        }
    }
    problem.prices = prices;
    (problem.low, problem.high) = (low, high);

    let mut vertices: Vec<VertexId> = cones.iter().map(|c| c.vertex).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let angle = |v: VertexId| set.angles[flow.problem.system.dof_of[v.index()] as usize];
    Ok(vertices.into_iter().map(|v| Cone { vertex: v, angle: angle(v) }).collect())
}
