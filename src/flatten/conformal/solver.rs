//! Newton's method on the convex energy of one connected surface.
//!
//! E(v) = Σ Θ*_i v_i + Σ_faces [2 Σ (θ_k x̃_ij + Л(θ_k)) − π (x̃_ij + x̃_jk + x̃_ki)], x̃_ij = x_ij + (v_i + v_j) / 2, has the gradient Θ* − Θ(v) and
//! the cotan Laplacian of the scaled metric as Hessian. With the triangulation always Delaunay for v, kept so by Ptolemy flips, it is
//! twice differentiable and convex on all of ℝⱽ. Near the end the decrease of E is below its rounding; the slope along the step is not,
//! and convexity makes it a test: where E still falls, every point before was higher.

use std::sync::Arc;

use super::triangle::{Triangle, face_energy, twice_arctangents};
use super::triangulation::{Keeps, NONE, Triangulation};
use crate::linalg::{Analysis, Elimination, Factor, LinalgError, Pattern, dot, worse};

/// Largest change of a log scale factor in one step. Without it thin ellipsoids (30 : 1) send v out of the range of numbers.
const LONGEST_STEP: f64 = 5.0;

/// Trials of one line search. Each shortens the step by half at least: what 60 halvings do not help is rounding.
const TRIALS: usize = 60;

/// 2π − its f64.
const TAU_REST: f64 = 2.449_293_598_294_706_4e-16;

/// Solves with the last factor after the last step, none of which costs a factorisation.
const POLISHINGS: usize = 3;

/// An angle error that is rounding: nothing is gained below it.
const POLISHED: f64 = 1e-13;

/// A residual, over the right-hand side, at which a solve needs no refinement.
const SOLVED: f64 = 1e-12;

/// An angle error that is rounding where no step lowers it: on thin ellipsoids (300 : 1) angles cannot be told to more digits.
const ACCEPTABLE: f64 = 1e-8;

/// How a solver stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    Running,
    Done,
    /// No step lowers the energy, or too many were taken.
    Failed,
}

/// Once one edge in so many has flipped, rows are put into a new order. A few flips hardly add to the factor, and an order costs
/// half a factorisation or more.
const EDGES_PER_FLIP: usize = 20;

/// Angles of a state.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluation {
    /// Angles of every face, opposite its sides.
    pub angles: Vec<[f64; 3]>,
    /// Cotangent of the angle opposite every halfedge; 0 outside.
    pub cotangents: Vec<f64>,
    /// Θ* − Θ at vertices whose v is sought, 0 elsewhere.
    pub gradient: Vec<f64>,
    /// Largest entry of it; NaN if one is.
    pub error: f64,
}

/// Analysis and factor of the last Hessian, for as long as its pattern stays. A clone begins without.
#[derive(Default)]
struct Cache(Option<Cached>);

struct Cached {
    /// Number of flips at which the pattern was made.
    flips: usize,
    slots: Vec<u32>,
    factor: Factor,
}

impl Clone for Cache {
    fn clone(&self) -> Self {
        Self(None)
    }
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.0.is_some() { "Cache(full)" } else { "Cache(empty)" })
    }
}

/// The problem and how far it has come.
#[derive(Clone, Debug)]
pub(super) struct Solver {
    pub triangulation: Triangulation,
    pub v: Vec<f64>,
    /// Angle sum Θ* asked for at every vertex; counts where v is sought.
    pub targets: Vec<f64>,
    /// Row of every vertex in the Hessian; `NONE` where v is given.
    rows: Vec<u32>,
    row_count: usize,
    /// Whether v is given nowhere but at the one vertex that is held.
    is_floating: bool,
    is_rim: Vec<bool>,
    pub evaluation: Evaluation,
    pub progress: Progress,
    pub steps: usize,
    pub factorisations: usize,
    pub analyses: usize,
    /// Number of flips at the last of them.
    analysed_at: Option<usize>,
    /// The order of the rows, and the number of flips when it was found. Clones go on with it.
    order: Option<(usize, Elimination)>,
    /// Steps of the line search that were rejected.
    pub rejected: usize,
    tolerance: f64,
    most_steps: usize,
    cache: Cache,
    /// An analysis that no factor has yet, with the number of flips at which its pattern was made, and the slots of its pairs.
    ready: Option<(usize, Arc<Analysis>, Vec<u32>)>,
}

impl Solver {
    /// Makes a triangulation Delaunay (first its surface, then for v) and evaluates.
    ///
    /// **Takes** whether v is given at each vertex; where it is nowhere, the first vertex is held.
    pub fn new(
        mut triangulation: Triangulation,
        v: Vec<f64>,
        targets: Vec<f64>,
        is_given: &[bool],
        tolerance: f64,
        most_steps: usize,
    ) -> Self {
        let mut is_given = is_given.to_vec();
        let is_floating = is_given.iter().all(|g| !g);
        if is_floating {
            // Not at a cone if it can be helped: its own error is the sum of all others.
            let flat = |t: &f64| (t - std::f64::consts::TAU).abs() < 1e-9;
            let held = targets.iter().position(flat).unwrap_or(0);
            is_given[held] = true;
        }
        let mut rows = vec![NONE; v.len()];
        let mut row_count = 0;
        for (row, _) in rows.iter_mut().zip(&is_given).filter(|(_, given)| !**given) {
            *row = row_count;
            row_count += 1;
        }
        let mut is_rim = vec![false; v.len()];
        for e in (0..triangulation.edge_count()).filter(|e| triangulation.is_boundary(*e)) {
            for end in [triangulation.tail[2 * e], triangulation.tail[2 * e + 1]] {
                is_rim[end as usize] = true;
            }
        }
        let flat = vec![0.0; v.len()];
        let settled = triangulation.make_delaunay(&flat, Keeps::Surface)
            && triangulation.make_delaunay(&v, Keeps::Conformal);
        let mut solver = Self {
            triangulation,
            v,
            targets,
            rows,
            row_count: row_count as usize,
            is_floating,
            is_rim,
            evaluation: Evaluation::default(),
            progress: Progress::Running,
            steps: 0,
            factorisations: 0,
            analyses: 0,
            analysed_at: None,
            order: None,
            rejected: 0,
            tolerance,
            most_steps,
            cache: Cache(None),
            ready: None,
        };
        solver.evaluation = solver.evaluate(&solver.v);
        solver.judge();
        if !settled {
            solver.progress = Progress::Failed;
        }
        if solver.progress == Progress::Running {
            // Where memory does not suffice the first step says so.
            solver.ready = solver.structure(&solver.pairs()).ok();
        }
        solver
    }

    /// Angle sums and cotangents at v in the triangulation as it stands.
    ///
    /// Sums carry their rounding along, and 2π is more than its f64: 2.4e-16 too little at each of 10 000 vertices would add up to
    /// charts that do not close by 1e-12. On a surface of free size what is left over goes to all vertices alike.
    pub fn evaluate(&self, v: &[f64]) -> Evaluation {
        let tri = &self.triangulation;
        let lengths = tri.scaled_lengths(v);
        let mut angles: Vec<[f64; 3]> = Vec::with_capacity(tri.face_count());
        let mut cotangents = vec![0.0; tri.tail.len()];
        let mut gradient = self.targets.clone();
        let mut lost: Vec<f64> =
            self.is_rim.iter().map(|r| if *r { 0.5 * TAU_REST } else { TAU_REST }).collect();
        for f in 0..tri.face_count() {
            let sides = tri.sides(f);
            let triangle = Triangle::of_half_tangents(sides.map(|h| lengths[(h >> 1) as usize]));
            angles.push(triangle.angles);
            for i in 0..3 {
                cotangents[sides[i] as usize] = triangle.cotangents[i];
            }
        }
        twice_arctangents(angles.as_flattened_mut());
        for (f, angles) in angles.iter().enumerate() {
            let sides = tri.sides(f);
            for i in 0..3 {
                // Opposite side i lies the tail of the side before.
                let corner = tri.tail[sides[(i + 2) % 3] as usize] as usize;
                let (before, angle) = (gradient[corner], angles[i]);
                let after = before - angle;
                let taken = before - after;
                lost[corner] += (before - (after + taken)) + (taken - angle);
                gradient[corner] = after;
            }
        }
        for (g, lost) in gradient.iter_mut().zip(&lost) {
            *g += lost;
        }
        if self.is_floating {
            let rest = gradient.iter().sum::<f64>() / gradient.len() as f64;
            gradient.iter_mut().for_each(|g| *g -= rest);
        }
        let mut error: f64 = 0.0;
        for (g, &row) in gradient.iter_mut().zip(&self.rows) {
            if row != NONE || self.is_floating {
                error = if g.abs() <= error { error } else { g.abs() };
            }
            if row == NONE {
                *g = 0.0;
            }
        }
        if gradient.iter().any(|g| g.is_nan()) {
            error = f64::NAN;
        }
        Evaluation { angles, cotangents, gradient, error }
    }

    /// E at v, whose angles are at hand, in the triangulation as it stands.
    pub fn energy(&self, evaluation: &Evaluation, v: &[f64]) -> f64 {
        let x = self.triangulation.scaled(v);
        let faces: f64 = evaluation
            .angles
            .iter()
            .enumerate()
            .map(|(f, angles)| {
                let sides = self.triangulation.sides(f);
                face_energy(*angles, sides.map(|h| x[(h >> 1) as usize]))
            })
            .sum();
        // Given scale factors do not move: their share is a constant.
        let moving = self.targets.iter().zip(v).zip(&self.rows).filter(|(_, row)| **row != NONE);
        faces + moving.map(|((target, v), _)| target * v).sum::<f64>()
    }

    /// Faces on the boundary whose triangle inequality fails, by the edges there.
    pub fn degenerate_boundary_edges(&self) -> Vec<usize> {
        let tri = &self.triangulation;
        let mut edges = Vec::new();
        for f in (0..tri.face_count()).filter(|&f| self.is_degenerate(f)) {
            let sides = tri.sides(f).map(|h| (h >> 1) as usize);
            edges.extend(sides.into_iter().filter(|&e| tri.is_boundary(e)));
        }
        edges
    }

    /// Number of faces whose triangle inequality fails.
    pub fn degenerate_faces(&self) -> usize {
        (0..self.triangulation.face_count()).filter(|&f| self.is_degenerate(f)).count()
    }

    /// Whether the triangle inequality of a face fails: only then are two of its angles 0.
    fn is_degenerate(&self, f: usize) -> bool {
        self.evaluation.angles[f].iter().any(|&angle| angle <= 0.0)
    }

    fn judge(&mut self) {
        if self.evaluation.error < self.tolerance {
            self.progress = Progress::Done;
        } else if self.steps >= self.most_steps {
            self.give_up();
        }
    }

    /// What is left may be rounding.
    fn give_up(&mut self) {
        let good_enough = self.evaluation.error < ACCEPTABLE;
        self.progress = if good_enough { Progress::Done } else { Progress::Failed };
    }

    /// One step of Newton's method.
    pub fn step(&mut self) -> Result<(), LinalgError> {
        if self.progress != Progress::Running {
            return Ok(());
        }
        if !self.evaluation.error.is_finite() {
            self.progress = Progress::Failed;
            return Ok(());
        }
        let direction = self.direction()?;
        let before = dot(&self.evaluation.gradient, &direction);
        let longest = direction.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        if !(before < 0.0 && longest.is_finite()) {
            self.give_up();
            return Ok(());
        }
        let start = self.evaluation.error;
        let mut length = (LONGEST_STEP / longest).min(1.0);
        for _ in 0..TRIALS {
            let trial: Vec<f64> =
                self.v.iter().zip(&direction).map(|(v, d)| v + length * d).collect();
            let settled = self.triangulation.make_delaunay(&trial, Keeps::Conformal);
            let evaluation = self.evaluate(&trial);
            let after = dot(&evaluation.gradient, &direction);
            let is_sound = settled && evaluation.error.is_finite();
            let accepted = if is_sound
                && (after <= 0.0
                    || evaluation.error < self.tolerance
                    || (evaluation.error < 0.5 * start && evaluation.error < 1e-6))
            {
                Some(evaluation)
            } else if is_sound && after <= -0.9 * before {
                self.where_lower(&trial, 1e-4 * length * before)
            } else {
                None
            };
            if let Some(evaluation) = accepted {
                // So near the end a step gains digits by the dozen; one that gains none meets rounding.
                let is_rounding = start < ACCEPTABLE && evaluation.error > 0.5 * start;
                self.v = trial;
                self.evaluation = evaluation;
                self.steps += 1;
                self.judge();
                if is_rounding {
                    self.give_up();
                }
                if self.progress == Progress::Done {
                    self.polish();
                }
                return Ok(());
            }
            self.rejected += 1;
            let secant = -before / (after - before);
            length *= if secant.is_finite() { secant.clamp(0.1, 0.5) } else { 0.1 };
        }
        // Trials have flipped edges: back to what belongs to v.
        self.triangulation.make_delaunay(&self.v, Keeps::Conformal);
        self.evaluation = self.evaluate(&self.v);
        self.give_up();
        Ok(())
    }

    /// The angles at a trial if E is lower there than at v by at least so much (below 0). Each has its own triangulation; that of the
    /// trial stays.
    pub(super) fn where_lower(&mut self, trial: &[f64], by: f64) -> Option<Evaluation> {
        let [(before, _), (after, evaluation)] = [self.v.clone(), trial.to_vec()].map(|v| {
            self.triangulation.make_delaunay(&v, Keeps::Conformal);
            let evaluation = self.evaluate(&v);
            (self.energy(&evaluation, &v), evaluation)
        });
        (after <= before + by).then_some(evaluation)
    }

    /// Takes angles to rounding with the factor that is at hand: at the end the Hessian hardly changes.
    fn polish(&mut self) {
        let Some(mut cached) = self.cache.0.take() else { return };
        for _ in 0..POLISHINGS {
            if self.evaluation.error < POLISHED {
                break;
            }
            let mut d = vec![0.0; self.row_count];
            for (g, &row) in self.evaluation.gradient.iter().zip(&self.rows) {
                if row != NONE {
                    d[row as usize] = -g;
                }
            }
            cached.factor.solve(&mut d, 1);
            let mut trial = self.v.clone();
            for (v, &row) in trial.iter_mut().zip(&self.rows) {
                if row != NONE {
                    *v += d[row as usize];
                }
            }
            let settled = self.triangulation.make_delaunay(&trial, Keeps::Conformal);
            let evaluation = self.evaluate(&trial);
            if !(settled && evaluation.error < 0.5 * self.evaluation.error) {
                self.triangulation.make_delaunay(&self.v, Keeps::Conformal);
                self.evaluation = self.evaluate(&self.v);
                break;
            }
            self.v = trial;
            self.evaluation = evaluation;
        }
    }

    /// The pattern of the Hessian in the triangulation as it stands, analysed.
    fn structure(
        &mut self,
        pairs: &[(usize, [u32; 2])],
    ) -> Result<(usize, Arc<Analysis>, Vec<u32>), LinalgError> {
        let flips = self.triangulation.flipped.len();
        let ends: Vec<[u32; 2]> = pairs.iter().map(|p| p.1).collect();
        let (pattern, slots) = Pattern::new(self.row_count, &ends);
        // A clone analyses again what counts once.
        self.analyses += usize::from(self.analysed_at.replace(flips) != Some(flips));
        Ok((flips, Arc::new(self.analyse(pattern, flips)?), slots))
    }

    /// −H⁻¹ g, refined where that helps.
    fn direction(&mut self) -> Result<Vec<f64>, LinalgError> {
        let flips = self.triangulation.flipped.len();
        let pairs = self.pairs();
        let (analysis, slots, old) = match self.cache.0.take() {
            Some(cached) if cached.flips == flips => {
                (cached.factor.analysis().clone(), cached.slots, Some(cached.factor))
            }
            _ => {
                let ready = self.ready.take().filter(|ready| ready.0 == flips);
                let (_, analysis, slots) = match ready {
                    Some(ready) => ready,
                    None => self.structure(&pairs)?,
                };
                (analysis, slots, None)
            }
        };
        let pattern = analysis.pattern();
        let values = self.hessian(pattern, &pairs, &slots);
        let mut factor = self.factor(&analysis, old, &values)?;
        let mut right: Vec<f64> = vec![0.0; self.row_count];
        for (g, &row) in self.evaluation.gradient.iter().zip(&self.rows) {
            if row != NONE {
                right[row as usize] = -g;
            }
        }
        let mut d = right.clone();
        factor.solve(&mut d, 1);
        let mut residual = vec![0.0; self.row_count];
        pattern.multiply(&values, &d, &mut residual);
        let (mut error, mut size) = (0.0f64, 0.0f64);
        for (r, b) in residual.iter_mut().zip(&right) {
            *r = b - *r;
            (error, size) = (worse(error, r.abs()), worse(size, b.abs()));
        }
        if error <= SOLVED * size {
            residual.fill(0.0);
        } else {
            factor.solve(&mut residual, 1);
        }
        self.cache = Cache(Some(Cached { flips, slots, factor }));
        let of = |&row: &u32| match row {
            NONE => 0.0,
            row => d[row as usize] + residual[row as usize],
        };
        Ok(self.rows.iter().map(of).collect())
    }

    /// Analyses a pattern in the order that there is, or in a new one where many edges have flipped since.
    fn analyse(&mut self, pattern: Pattern, flips: usize) -> Result<Analysis, LinalgError> {
        let few = self.triangulation.edge_count() / EDGES_PER_FLIP;
        if let Some((before, order)) = &self.order
            && flips - before <= few
        {
            return Analysis::ordered(pattern, order);
        }
        let analysis = Analysis::new(pattern)?;
        self.order = Some((flips, analysis.order()));
        Ok(analysis)
    }

    /// Edges with both ends sought, by their rows.
    fn pairs(&self) -> Vec<(usize, [u32; 2])> {
        let tri = &self.triangulation;
        (0..tri.edge_count())
            .map(|e| (e, [0, 1].map(|s| self.rows[tri.tail[2 * e + s] as usize])))
            .filter(|(_, [i, j])| *i != NONE && *j != NONE && i != j)
            .collect()
    }

    fn hessian(&self, pattern: &Pattern, pairs: &[(usize, [u32; 2])], slots: &[u32]) -> Vec<f64> {
        let tri = &self.triangulation;
        let cotangents = &self.evaluation.cotangents;
        let weight = |e: usize| 0.5 * (cotangents[2 * e] + cotangents[2 * e + 1]);
        let mut values = vec![0.0; pattern.entry_count()];
        for ((e, _), &slot) in pairs.iter().zip(slots) {
            values[slot as usize] -= weight(*e);
        }
        for e in 0..tri.edge_count() {
            let ends = [tri.tail[2 * e], tri.tail[2 * e + 1]];
            // What joins a vertex to itself scales with it.
            if ends[0] != ends[1] {
                for row in ends.map(|v| self.rows[v as usize]).into_iter().filter(|r| *r != NONE) {
                    values[pattern.diagonal(row as usize)] += weight(e);
                }
            }
        }
        values
    }

    /// Factors the Hessian; what rounding or degenerate triangles make singular gets the smallest shift that helps.
    fn factor(
        &mut self,
        analysis: &Arc<Analysis>,
        mut old: Option<Factor>,
        values: &[f64],
    ) -> Result<Factor, LinalgError> {
        let mut shifted = values.to_vec();
        let mut shift = 1e-10;
        loop {
            self.factorisations += 1;
            let result = match old.take() {
                Some(mut factor) => factor.refactor(&shifted).map(|()| factor),
                None => Factor::new(analysis.clone(), &shifted),
            };
            match result {
                Err(LinalgError::NotPositiveDefinite { .. }) if shift < 1e10 => {
                    shifted.copy_from_slice(values);
                    for i in 0..self.row_count {
                        shifted[analysis.pattern().diagonal(i)] += shift;
                    }
                    shift *= 100.0;
                }
                result => return result,
            }
        }
    }

    /// Whether v is sought at a vertex.
    #[cfg(test)]
    pub fn is_sought(&self, v: usize) -> bool {
        self.rows[v] != NONE
    }

    /// H d.
    #[cfg(test)]
    pub fn hessian_times(&self, d: &[f64]) -> Vec<f64> {
        let pairs = self.pairs();
        let ends: Vec<[u32; 2]> = pairs.iter().map(|p| p.1).collect();
        let (pattern, slots) = Pattern::new(self.row_count, &ends);
        let values = self.hessian(&pattern, &pairs, &slots);
        let mut x = vec![0.0; self.row_count];
        for (d, &row) in d.iter().zip(&self.rows).filter(|(_, row)| **row != NONE) {
            x[row as usize] = *d;
        }
        let mut y = vec![0.0; self.row_count];
        pattern.multiply(&values, &x, &mut y);
        self.rows.iter().map(|&row| if row == NONE { 0.0 } else { y[row as usize] }).collect()
    }

    /// Takes over what was spent before.
    pub fn add_counts(&mut self, earlier: &Self) {
        self.steps += earlier.steps;
        self.most_steps += earlier.steps;
        self.factorisations += earlier.factorisations;
        self.analyses += earlier.analyses;
        self.rejected += earlier.rejected;
    }
}
