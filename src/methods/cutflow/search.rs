//! Searching for the next cut: the gradient, directions, trials.

use super::band::LevelSets;
use super::cut::Cut;
use super::energy::{Problem, Solution};
use super::metric::CurveMetric;
use super::{CutFlow, CutState, Scheme, init, topology};
use crate::linalg::{LinalgError, dot};
use crate::methods::flow::SolveError;

/// How (ℓ, clip) change after each failed line search in a row; when all have failed the run ends.
pub(super) const RETRIES: [(Smoothing, f64); 5] = [
    (Smoothing::Edges(2.0), 3.0),
    (Smoothing::Edges(2.0), 1.0),
    (Smoothing::Edges(8.0), 3.0),
    (Smoothing::Edges(2.0), 0.5),
    (Smoothing::Edges(1.0), 1.5),
];

/// Trials of one line search.
const TRIALS: usize = 12;

/// Smoothing length of the metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Smoothing {
    /// For a surface of unit area.
    Absolute(f64),
    /// In mean edge lengths.
    Edges(f64),
}

impl CutFlow {
    pub(super) fn gradient(&mut self) -> Result<Vec<f64>, LinalgError> {
        let CutState { levels, response, cut, solution } = &mut self.state;
        let (problem, shared) = (&self.problem, &mut self.shared);
        let forces =
            problem.crossing_forces(cut, &levels.labels, &self.weights, solution, shared)?;
        Ok(response.pull_back(problem, cut, levels, &forces))
    }

    /// Moves the level sets by `scale` · `direction` and evaluates; `None` if the result cannot be used at all.
    pub(super) fn try_move(
        &mut self,
        direction: &[f64],
        scale: f64,
    ) -> Result<Option<(LevelSets, Cut, Solution)>, SolveError> {
        let mut levels = self.state.levels.clone();
        if self.symmetric.is_empty() {
            self.state.response.apply(direction, scale, &mut levels.values);
        } else {
            let mut moves = vec![0.0; levels.values.len()];
            self.state.response.apply(direction, scale, &mut moves);
            let moves = self.symmetric.average(&levels, &moves);
            levels.values.iter_mut().zip(moves).for_each(|(value, by)| *value += by);
        }
        let moved = scale * direction.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        self.settle(levels, moved)
    }

    /// Projects level sets that have moved, keeps the patches' topology and evaluates; `None` if the result cannot be used at
    /// all. **Takes** how far the cut `moved` at most.
    pub(super) fn settle(
        &mut self,
        mut levels: LevelSets,
        moved: f64,
    ) -> Result<Option<(LevelSets, Cut, Solution)>, SolveError> {
        levels.project();
        let vanish = self.has_many_regions();
        topology::keep_simple(
            &self.problem.mesh,
            &self.state.levels.labels,
            &mut levels,
            self.params.topology.resolved(vanish),
            vanish,
            self.mean_edge,
            moved,
        );
        match self.evaluate(&levels) {
            // A closed component that lost its cut would look like a bargain: nothing is left to pay for.
            Ok((cut, solution))
                if solution.energy.total.is_finite() && !self.problem.misses_a_component(&cut) =>
            {
                Ok(Some((levels, cut, solution)))
            }
            Ok((_, solution)) => {
                self.spare = Some(solution);
                Ok(None)
            }
            // As above, or a sliver lost its area: a trial to be refused like any other.
            Err(LinalgError::NotPositiveDefinite { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    pub(super) fn accept(&mut self, levels: LevelSets, cut: Cut, solution: Solution) {
        let (levels, response) = LevelSets::rebuild(&self.problem, &cut, levels, self.mean_edge);
        let old = std::mem::replace(&mut self.state, CutState { levels, response, cut, solution });
        self.spare = Some(old.solution);
    }

    /// The seeded smooth disturbance.
    pub(super) fn kick(&mut self, seed: u64) -> Result<(), SolveError> {
        let Problem { mesh, geometry, analysis, .. } = &self.problem;
        let shared = &mut self.shared;
        let field = init::smooth_noise(mesh, geometry, analysis, seed, shared)?;
        let mesh = &self.problem.mesh;
        let mut displacement: Vec<f64> = self
            .state
            .cut
            .crossings
            .iter()
            .map(|c| {
                let [a, b] = mesh.edge_vertices(c.edge).map(|v| field[v.index()]);
                a + (b - a) * c.t
            })
            .collect();
        let largest = displacement.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        if largest > 0.0 {
            for d in &mut displacement {
                *d *= self.params.kick * self.mean_edge / largest;
            }
            if let Some((levels, cut, solution)) = self.try_move(&displacement, 1.0)? {
                self.accept(levels, cut, solution);
            }
        }
        Ok(())
    }

    /// The first step: the disturbance, and descents until J is below `ceiling`, three at most. What it leaves is to be taken
    /// back if J is not.
    pub(super) fn kick_and_descend(&mut self, ceiling: f64) -> Result<(), SolveError> {
        self.kick(self.params.seed)?;
        for _ in 0..3 {
            let moved = match self.params.scheme {
                Scheme::Fast => self.descend(f64::INFINITY)?,
                Scheme::Paper => self.paper_step(f64::INFINITY)?,
            };
            if !moved || self.state.solution.energy.total < ceiling {
                break;
            }
        }
        Ok(())
    }

    /// One descent step from the current state to a J below `ceiling`.
    pub(super) fn descend(&mut self, ceiling: f64) -> Result<bool, SolveError> {
        self.progress.promise = 0.0;
        if self.state.cut.crossings.is_empty() {
            return Ok(false);
        }
        let many = self.has_many_regions();
        let failures = self.progress.failures;
        let (smoothing, clip) = if failures == 0 {
            (if many { Smoothing::Edges(2.0) } else { Smoothing::Absolute(0.085) }, 3.0)
        } else {
            RETRIES[failures - 1]
        };
        let smoothing = match smoothing {
            Smoothing::Absolute(length) => length,
            Smoothing::Edges(count) => count * self.mean_edge,
        };
        let mut metric = CurveMetric::new(&self.state.cut, smoothing, self.mean_edge)?;
        let mut gradient = self.gradient()?;
        if !gradient.iter().all(|g| g.is_finite()) {
            // Triangles without area have no finite derivative of their cotangents: no direction leads down from here.
            return Ok(false);
        }
        metric.clip(&mut gradient, clip, self.mean_edge);
        let z = metric.raise(&gradient);

        let mut direction: Vec<f64> = z.iter().map(|z| -z).collect();
        let mut is_quasi_newton = false;
        if many {
            self.progress.memory.transport(&self.problem, &self.state.cut, &metric, &z);
            if !self.progress.memory.is_empty() {
                let candidate = self.progress.memory.direction(&metric, &z);
                let slope = dot(&gradient, &candidate);
                let size = (dot(&metric.lower(&candidate), &candidate) * dot(&gradient, &z)).sqrt();
                if slope < -1e-3 * size {
                    direction = candidate;
                    is_quasi_newton = true;
                }
            }
        }
        let slope = dot(&gradient, &direction);
        let largest = direction.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        if !(slope < 0.0 && largest > 0.0 && largest.is_finite()) {
            return Ok(false);
        }
        let capped = self.params.cap * self.mean_edge / largest;
        // Only a quasi-Newton direction has a length of its own.
        let mut scale = if is_quasi_newton {
            capped.min(1.0)
        } else if self.progress.scale > 0.0 {
            capped.min(self.progress.scale)
        } else {
            capped
        };
        let start = self.state.solution.energy.total;
        self.progress.promise = -slope * capped;
        for _ in 0..TRIALS {
            if let Some((levels, cut, solution)) = self.try_move(&direction, scale)? {
                let total = solution.energy.total;
                if total < ceiling.min(start + 1e-4 * scale * slope) {
                    if many {
                        let step = direction.iter().map(|d| d * scale).collect();
                        self.progress.memory.record(&self.problem, &self.state.cut, step, z);
                    }
                    self.accept(levels, cut, solution);
                    self.progress.scale = 1.6 * scale;
                    return Ok(true);
                }
                self.spare = Some(solution);
            }
            scale *= 0.4;
        }
        Ok(false)
    }
}
