//! The boundary problem in angle space: the closed polygon of given side lengths whose angles are nearest to given ones.
//!
//! Sides i = 0 … n−1 are walked counter-clockwise, side i leaves its corner at direction φ_i = (i + 1) π − Σ_{b ≤ i} θ_b.
//! **Minimises** ½ Σ (θ − a)² subject to
//!
//! * Σ θ = (n − 2) π,
//! * for each virtual cut edge, walked as sides a < b in opposite directions: Σ_{a < i ≤ b} θ_i = (b − a) π + π,
//! * for each loop of the patch: Σ l_k e^{iφ_k} = 0 over its sides k.
//!
//! Derivatives of the last rows are suffix sums, because θ_i turns all sides from i on: ∂/∂θ_i Σ l cos φ = Σ_{k ≥ i} l sin φ and
//! ∂/∂θ_i Σ l sin φ = −Σ_{k ≥ i} l cos φ.
//!
//! Each iteration solves the problem with constraints made linear: Λ Λᵀ μ = Λ (a − θ) + c, θ⁺ = a − Λᵀ μ. Λ has full rank and few rows; those of the
//! first two kinds never change, nor does their part of the Cholesky factor.

use std::f64::consts::PI;

use nalgebra::Point2;

use crate::flatten::small;
use crate::linalg::dot;
use crate::methods::flow::Status;

/// Angles that change less (radians) stand still, and constraints are kept to it (lengths in units of their mean).
const STILL: f64 = 1e-9;

/// Iterations at most: 3 to 12 are usual, 80 where steps have to be damped.
const ITERATIONS: usize = 200;

/// A polygon that is not closed to this (mean side lengths) when iterations end does not exist as far as the method can tell.
const OPEN: f64 = 1e-6;

/// Side of a virtual cut, which belongs to no loop.
pub const NO_LOOP: u32 = u32::MAX;

/// A polygon to be found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BoundaryProblem {
    /// Length of every side.
    pub lengths: Vec<f64>,
    /// Angle aimed at between the side before and each side, radians.
    pub angles: Vec<f64>,
    /// Loop that each side belongs to, below `loop_count`; [`NO_LOOP`] for sides of virtual cuts. The first side belongs to the outer loop.
    pub loops: Vec<u32>,
    /// Number of loops.
    pub loop_count: usize,
    /// The two sides that walk each virtual cut edge, in increasing order.
    pub cuts: Vec<[u32; 2]>,
}

/// A solver for one polygon, prepared once; iterations allocate nothing.
#[derive(Clone, Debug)]
pub struct BoundarySolver {
    /// Sides in units of their mean.
    lengths: Vec<f64>,
    scale: f64,
    aims: Vec<f64>,
    loops: Vec<u32>,
    cuts: Vec<[u32; 2]>,
    /// Rows that never change: the sum of angles and the virtual cuts.
    linear: usize,
    rows: usize,
    theta: Vec<f64>,
    trial: Vec<f64>,
    step: Vec<f64>,
    /// Sine and cosine of the direction of every side that belongs to a loop, at the angles that constraints were found for last.
    directions: Vec<[f64; 2]>,
    /// The angles that these belong to; NaN where they are to be found anew.
    turned: Vec<f64>,
    /// Values of the constraints.
    values: Vec<f64>,
    /// The rows of the loops, two each, one after the other.
    trig: Vec<f64>,
    /// Prefix sums of a row.
    prefix: Vec<f64>,
    /// Rows of the Cholesky factor of Λ Λᵀ, padded to squares.
    factor: Vec<f64>,
    multipliers: Vec<f64>,
    outcome: BoundaryOutcome,
}

/// How a boundary problem ended, and how good its solution is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryOutcome {
    /// `Converged`; `Running` where what there was was enough; `Infeasible` where no such polygon was found; `Stalled` where it is closed but not proved the nearest.
    pub status: Status,
    /// Iterations done.
    pub iterations: usize,
    /// Whether steps had to be damped.
    pub is_damped: bool,
    /// Largest distance that a loop is open by, over the length of all loops; what virtual cuts miss included.
    pub closure_error: f64,
    /// Π_θ: mean of |θ − a| over all sides, radians.
    pub angle_error: f64,
}

impl BoundarySolver {
    /// Prepares a problem. **Costs** O(n) for each loop and the cube of the number of virtual cut edges.
    pub fn new(problem: &BoundaryProblem) -> Self {
        let n = problem.lengths.len();
        assert!(problem.angles.len() == n && problem.loops.len() == n);
        let scale = problem.lengths.iter().sum::<f64>() / n.max(1) as f64;
        let linear = 1 + problem.cuts.len();
        let rows = linear + 2 * problem.loop_count;
        let mut solver = Self {
            lengths: problem.lengths.iter().map(|l| l / scale).collect(),
            scale,
            aims: problem.angles.clone(),
            loops: problem.loops.clone(),
            cuts: problem.cuts.clone(),
            linear,
            rows,
            theta: problem.angles.clone(),
            trial: vec![0.0; n],
            step: vec![0.0; n + 1],
            directions: vec![[0.0; 2]; n],
            turned: vec![f64::NAN; n],
            values: vec![0.0; rows],
            trig: vec![0.0; 2 * problem.loop_count * n],
            prefix: vec![0.0; n + 1],
            factor: vec![0.0; rows * rows],
            multipliers: vec![0.0; rows],
            outcome: BoundaryOutcome {
                status: Status::Running,
                iterations: 0,
                is_damped: false,
                closure_error: f64::INFINITY,
                angle_error: f64::INFINITY,
            },
        };
        if !solver.can_close(problem.loop_count) || !solver.factor_linear_rows() {
            solver.outcome.status = Status::Infeasible;
        }
        solver
    }

    /// No side is longer than the rest of its loop, and all are positive.
    fn can_close(&self, loop_count: usize) -> bool {
        let mut sums = vec![[0.0f64; 2]; loop_count];
        for (&l, &of) in self.lengths.iter().zip(&self.loops) {
            if !(l > 0.0 && l.is_finite()) {
                return false;
            }
            if let Some([sum, longest]) = sums.get_mut(of as usize) {
                *sum += l;
                *longest = longest.max(l);
            }
        }
        self.lengths.len() >= 3 && sums.iter().all(|[sum, longest]| 2.0 * longest < *sum)
    }

    /// Iterates until the angles stand still. **Costs** O(n) for each loop and iteration.
    pub fn solve(&mut self) -> BoundaryOutcome {
        self.solve_until(ITERATIONS, |_, _| false)
    }

    /// [`BoundarySolver::solve`] for those who want only what is easy to close, and not all of that.
    ///
    /// **Takes** the most iterations, and what is asked whenever a step turns sides by half as much as the one before at most: with what it turns them by (radians)
    /// and the signed area that is enclosed before it (squared lengths) whether that is enough. The outcome is `Running` then. As long as steps go on
    /// shrinking so, sides turn by twice as much in the end at most, and a closed curve of length L whose sides turn by δ changes its area by
    /// δ L² / 4 at most, to first order.
    pub fn solve_until(
        &mut self,
        iterations: usize,
        is_enough: impl Fn(f64, f64) -> bool,
    ) -> BoundaryOutcome {
        if self.outcome.status != Status::Running {
            return self.outcome;
        }
        let (mut grown, mut penalty, mut before) = (0, 0.0f64, f64::INFINITY);
        let mut last_turn = f64::INFINITY;
        while self.outcome.iterations < iterations {
            self.outcome.iterations += 1;
            self.linearise();
            if !self.factor_loop_rows() {
                self.outcome.status = Status::Infeasible;
                break;
            }
            let largest = self.find_step();
            if !largest.is_finite() {
                self.outcome.status = Status::Infeasible;
                break;
            }
            // What has not been moved yet is no polygon: its steps are yet to shrink.
            let turn = self.largest_turn();
            let is_settling = turn <= 0.5 * std::mem::replace(&mut last_turn, turn);
            if is_settling && self.outcome.iterations > 1 && is_enough(turn, self.enclosed_area()) {
                return self.outcome;
            }
            let strongest = self.multipliers.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            penalty = penalty.max(2.0 * strongest);
            let merit = self.merit(penalty);
            grown = if merit > before { grown + 1 } else { 0 };
            before = merit;
            self.outcome.is_damped |= grown >= 2;
            let is_kept = self.values.iter().all(|c| c.abs() <= STILL);
            let is_done = largest <= STILL && is_kept;
            if is_done || !self.outcome.is_damped {
                self.move_by(1.0);
            } else if !self.search(merit, penalty) {
                break;
            }
            if is_done {
                self.outcome.status = Status::Converged;
                break;
            }
        }
        // What is certified carries none of the rounding of earlier turns.
        self.turned.fill(f64::NAN);
        self.linearise();
        self.conclude();
        self.outcome
    }

    /// Angles found.
    pub fn angles(&self) -> &[f64] {
        &self.theta
    }

    /// Where each side begins; the first at the origin. Also where nothing converged.
    pub fn places(&self) -> Vec<Point2<f64>> {
        let mut places = Vec::with_capacity(self.theta.len());
        let (mut at, mut phi) = (Point2::origin(), 0.0);
        for (l, theta) in self.lengths.iter().zip(&self.theta) {
            places.push(at);
            phi += PI - theta;
            let (sin, cos) = phi.sin_cos();
            at.x += l * self.scale * cos;
            at.y += l * self.scale * sin;
        }
        places
    }

    /// The most that the step turns a side by: many angles that change by little turn it far.
    fn largest_turn(&self) -> f64 {
        let (mut turned, mut most) = (0.0f64, 0.0f64);
        for step in &self.step[..self.theta.len()] {
            turned += step;
            most = most.max(turned.abs());
        }
        most
    }

    /// By the directions that constraints were found for last: each loop for itself, as far as it is closed.
    fn enclosed_area(&self) -> f64 {
        let mut doubled = 0.0;
        for of in 0..small((self.rows - self.linear) / 2) {
            let (mut x, mut y) = (0.0, 0.0);
            for (k, l) in self.lengths.iter().enumerate().filter(|(k, _)| self.loops[*k] == of) {
                let [sin, cos] = self.directions[k];
                let (to_x, to_y) = (x + l * cos, y + l * sin);
                doubled += x * to_y - y * to_x;
                (x, y) = (to_x, to_y);
            }
        }
        0.5 * doubled * self.scale * self.scale
    }

    fn conclude(&mut self) {
        let n = self.theta.len() as f64;
        let worst =
            self.values.iter().fold(0.0f64, |m, c| if c.is_nan() { *c } else { m.max(c.abs()) });
        if self.outcome.status == Status::Running {
            let is_closed = worst <= OPEN;
            self.outcome.status = if is_closed { Status::Stalled } else { Status::Infeasible };
        }
        self.outcome.closure_error = worst / n;
        let off: f64 = self.theta.iter().zip(&self.aims).map(|(t, a)| (t - a).abs()).sum();
        self.outcome.angle_error = off / n;
    }

    /// The constraints and the rows of the loops at the present angles.
    fn linearise(&mut self) {
        let n = self.theta.len();
        self.trial.copy_from_slice(&self.theta);
        self.constraints();
        // From the end: suffix sums.
        for p in 0..(self.rows - self.linear) / 2 {
            let (mut sine, mut cosine) = (0.0, 0.0);
            let (first, second) = self.trig[2 * p * n..2 * (p + 1) * n].split_at_mut(n);
            for k in (0..n).rev() {
                if self.loops[k] as usize == p {
                    let [sin, cos] = self.directions[k];
                    sine += self.lengths[k] * sin;
                    cosine += self.lengths[k] * cos;
                }
                first[k] = sine;
                second[k] = -cosine;
            }
        }
    }

    /// The constraints at the angles in `trial`.
    fn constraints(&mut self) {
        let n = self.trial.len();
        let loop_count = (self.rows - self.linear) / 2;
        self.values.fill(0.0);
        // Turning: the direction of each side, and what virtual cuts and the whole walk are told by.
        let mut phi = 0.0;
        self.prefix[0] = 0.0;
        for k in 0..n {
            phi += PI - self.trial[k];
            self.prefix[k + 1] = phi;
            let of = self.loops[k] as usize;
            if of < loop_count {
                let [sin, cos] = turn(self.directions[k], phi - self.turned[k], phi);
                (self.directions[k], self.turned[k]) = ([sin, cos], phi);
                self.values[self.linear + 2 * of] += self.lengths[k] * cos;
                self.values[self.linear + 2 * of + 1] += self.lengths[k] * sin;
            }
        }
        self.values[0] = 2.0 * PI - phi;
        for (value, &[a, b]) in self.values[1..].iter_mut().zip(&self.cuts) {
            *value = -PI - (self.prefix[b as usize + 1] - self.prefix[a as usize + 1]);
        }
    }

    /// The part of the Cholesky factor that never changes.
    fn factor_linear_rows(&mut self) -> bool {
        let n = self.theta.len() as f64;
        let m = self.rows;
        self.factor[0] = n;
        for (i, [a, b]) in self.cuts.iter().enumerate() {
            let row = &mut self.factor[(i + 1) * m..];
            row[0] = f64::from(b - a);
            for (entry, [c, d]) in row[1..].iter_mut().zip(&self.cuts[..=i]) {
                *entry = f64::from(b.min(d).saturating_sub(*a.max(c)));
            }
        }
        (0..self.linear).all(|i| eliminate(&mut self.factor, m, i))
    }

    fn factor_loop_rows(&mut self) -> bool {
        let (n, m) = (self.theta.len(), self.rows);
        for i in self.linear..m {
            let at = (i - self.linear) * n;
            let row = &self.trig[at..at + n];
            let mut sum = 0.0;
            for (k, x) in row.iter().enumerate() {
                sum += x;
                self.prefix[k + 1] = sum;
            }
            self.factor[i * m] = sum;
            for (c, &[a, b]) in self.cuts.iter().enumerate() {
                self.factor[i * m + 1 + c] =
                    self.prefix[b as usize + 1] - self.prefix[a as usize + 1];
            }
            for j in self.linear..=i {
                let other = (j - self.linear) * n;
                self.factor[i * m + j] = dot(row, &self.trig[other..other + n]);
            }
            if !eliminate(&mut self.factor, m, i) {
                return false;
            }
        }
        true
    }

    /// The step to the optimum of the linearised problem; gives its largest entry.
    fn find_step(&mut self) -> f64 {
        let (n, m) = (self.theta.len(), self.rows);
        let mut sum = 0.0;
        for k in 0..n {
            self.step[k] = self.aims[k] - self.theta[k];
            sum += self.step[k];
            self.prefix[k + 1] = sum;
        }
        self.multipliers.copy_from_slice(&self.values);
        self.multipliers[0] += sum;
        for (mu, &[a, b]) in self.multipliers[1..].iter_mut().zip(&self.cuts) {
            *mu += self.prefix[b as usize + 1] - self.prefix[a as usize + 1];
        }
        for i in self.linear..m {
            let at = (i - self.linear) * n;
            self.multipliers[i] += dot(&self.trig[at..at + n], &self.step[..n]);
        }
        for i in 0..m {
            let (row, known) = (&self.factor[i * m..], &self.multipliers);
            let sum: f64 = (0..i).map(|j| row[j] * known[j]).sum();
            self.multipliers[i] = (self.multipliers[i] - sum) / row[i];
        }
        for i in (0..m).rev() {
            let value = self.multipliers[i] / self.factor[i * m + i];
            self.multipliers[i] = value;
            for j in 0..i {
                self.multipliers[j] -= self.factor[i * m + j] * value;
            }
        }
        // δ = a − θ − Λᵀ μ; cuts by the differences of what their ranges add.
        self.prefix.fill(0.0);
        for (mu, &[a, b]) in self.multipliers[1..].iter().zip(&self.cuts) {
            self.prefix[a as usize + 1] += mu;
            self.prefix[b as usize + 1] -= mu;
        }
        let mut pull = self.multipliers[0];
        for k in 0..n {
            pull += self.prefix[k];
            self.step[k] -= pull;
        }
        for i in self.linear..m {
            let (mu, at) = (self.multipliers[i], (i - self.linear) * n);
            for (step, x) in self.step.iter_mut().zip(&self.trig[at..at + n]) {
                *step -= mu * x;
            }
        }
        self.step[..n]
            .iter()
            .fold(0.0f64, |most, d| if d.is_nan() { *d } else { most.max(d.abs()) })
    }

    /// ½ |θ − a|² + ρ |c|₁ at the present angles and constraints.
    fn merit(&self, penalty: f64) -> f64 {
        let off: f64 = self.theta.iter().zip(&self.aims).map(|(t, a)| (t - a) * (t - a)).sum();
        0.5 * off + penalty * self.values.iter().map(|c| c.abs()).sum::<f64>()
    }

    fn move_by(&mut self, length: f64) {
        for (theta, step) in self.theta.iter_mut().zip(&self.step) {
            *theta += length * step;
        }
    }

    /// Halves the step until the merit falls. Gives whether it did.
    fn search(&mut self, merit: f64, penalty: f64) -> bool {
        let mut length = 1.0;
        for _ in 0..40 {
            self.move_by(length);
            self.trial.copy_from_slice(&self.theta);
            self.constraints();
            if self.merit(penalty) < merit {
                return true;
            }
            self.move_by(-length);
            length *= 0.5;
        }
        false
    }
}

/// Sine and cosine of `phi` from those of an angle that is less by `by`: by their series to rounding where that is little, which is most of the time.
fn turn([sin, cos]: [f64; 2], by: f64, phi: f64) -> [f64; 2] {
    // (−1)ᵏ / (2k + 1)! and (−1)ᵏ / (2k)! from the highest on.
    const SINE: [f64; 6] =
        [-1.0 / 39_916_800.0, 1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0, 1.0];
    const COSINE: [f64; 6] =
        [-1.0 / 3_628_800.0, 1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0];
    if by.abs() <= 0.125 {
        let x = by * by;
        let series = |terms: [f64; 6]| terms.into_iter().fold(0.0, |sum, term| sum * x + term);
        let (s, c) = (by * series(SINE), series(COSINE));
        [sin * c + cos * s, cos * c - sin * s]
    } else {
        let (sin, cos) = phi.sin_cos();
        [sin, cos]
    }
}

/// Makes row `i` of a symmetric matrix of `m` rows the row of its Cholesky factor, those before being so already. Gives whether it is
/// positive definite so far.
fn eliminate(factor: &mut [f64], m: usize, i: usize) -> bool {
    let (known, row) = factor.split_at_mut(i * m);
    let full = row[i];
    for j in 0..i {
        let above = &known[j * m..j * m + j];
        let sum: f64 = row[..j].iter().zip(above).map(|(x, y)| x * y).sum();
        row[j] = (row[j] - sum) / known[j * m + j];
    }
    let rest = full - row[..i].iter().map(|x| x * x).sum::<f64>();
    row[i] = rest.max(0.0).sqrt();
    // A pivot below the rounding errors of its own row has no digit.
    rest > 4.0 * f64::EPSILON * full
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of a bumpy closed curve and its angles, disturbed.
    fn bumpy(n: usize) -> BoundaryProblem {
        let lengths = (0..n).map(|i| 1.0 + 0.4 * (i as f64 * 1.7).sin()).collect();
        let angles = (0..n)
            .map(|i| PI - 2.0 * PI / n as f64 + 0.08 * (i as f64 * 0.9).cos() + 0.01)
            .collect();
        BoundaryProblem { lengths, angles, loops: vec![0; n], loop_count: 1, cuts: vec![] }
    }

    #[test]
    fn rows_of_the_loops_are_the_recursions_of_the_appendix() {
        let mut solver = BoundarySolver::new(&bumpy(50));
        solver.linearise();
        let n = 50;
        let phi = |i: usize| (0..=i).map(|b| PI - solver.theta[b]).sum::<f64>();
        let l = &solver.lengths;
        // The start values that the paper does not give, and its recursions.
        let mut first: f64 = (0..n).map(|k| l[k] * phi(k).sin()).sum();
        let mut second: f64 = -(0..n).map(|k| l[k] * phi(k).cos()).sum::<f64>();
        let total: f64 = l.iter().sum();
        for i in 0..n {
            assert!((solver.trig[i] - first).abs() < 1e-14 * total, "row x, angle {i}");
            assert!((solver.trig[n + i] - second).abs() < 1e-14 * total, "row y, angle {i}");
            first -= l[i] * phi(i).sin();
            second += l[i] * phi(i).cos();
        }
    }

    #[test]
    fn rows_are_the_derivatives_of_the_constraints() {
        // Two loops and one virtual cut of two edges: sides 3, 4 and 10, 11 walk it; 5 to 9 are the hole.
        let n = 18;
        let mut problem = bumpy(n);
        problem.loop_count = 2;
        problem.cuts = vec![[3, 11], [4, 10]];
        for k in [3, 4, 10, 11] {
            problem.loops[k] = NO_LOOP;
        }
        (5..10).for_each(|k| problem.loops[k] = 1);
        let mut solver = BoundarySolver::new(&problem);
        solver.linearise();
        let row = |solver: &BoundarySolver, r: usize, i: usize| match r {
            0 => 1.0,
            r if r < solver.linear => {
                let [a, b] = solver.cuts[r - 1];
                f64::from(u8::from(i > a as usize && i <= b as usize))
            }
            r => solver.trig[(r - solver.linear) * n + i],
        };
        let h = 1e-6;
        for i in 0..n {
            let mut at = |step: f64| {
                solver.trial.copy_from_slice(&solver.theta);
                solver.trial[i] += step;
                solver.constraints();
                solver.values.clone()
            };
            let (plus, minus) = (at(h), at(-h));
            for r in 0..solver.rows {
                let slope = (plus[r] - minus[r]) / (2.0 * h);
                // Rounding of sums of 18 lengths over h, and h² of the third derivative.
                assert!((slope - row(&solver, r, i)).abs() < 1e-8, "row {r}, angle {i}");
            }
        }
    }

    #[test]
    fn the_solution_is_closed_and_stationary() {
        let problem = bumpy(200);
        let mut solver = BoundarySolver::new(&problem);
        let outcome = solver.solve();
        assert_eq!(outcome.status, Status::Converged);
        assert!(outcome.closure_error < 1e-13 && outcome.iterations < 15, "{outcome:?}");
        let places = solver.places();
        for (k, place) in places.iter().enumerate() {
            let length = (places[(k + 1) % 200] - place).norm();
            // Rounding of 200 sums.
            assert!((length - problem.lengths[k]).abs() < 1e-11);
        }
        // Stationary: θ − a lies in the span of the rows, so that another step moves nothing.
        solver.linearise();
        assert!(solver.factor_loop_rows() && solver.find_step() < 1e-9);
    }

    #[test]
    fn little_turns_are_exact_to_rounding() {
        for (from, by) in [(0.3f64, 0.1249), (2.0, -0.125), (-4.0, 1e-9), (1.0, 0.0), (0.5, 0.2)] {
            let (sin, cos) = from.sin_cos();
            let found = turn([sin, cos], by, from + by);
            let (sin, cos) = (from + by).sin_cos();
            assert!(
                (found[0] - sin).abs() < 4e-16 && (found[1] - cos).abs() < 4e-16,
                "{from} + {by}"
            );
        }
    }

    #[test]
    fn who_has_seen_enough_is_told_the_area_and_stops_early() {
        let problem = bumpy(200);
        let mut whole = BoundarySolver::new(&problem);
        let asked = std::cell::RefCell::new(Vec::new());
        let outcome = whole.solve_until(ITERATIONS, |change, area| {
            asked.borrow_mut().push([change, area]);
            false
        });
        assert_eq!(outcome.status, Status::Converged);
        let places = whole.places();
        let doubled: f64 =
            (0..200).map(|k| places[k].coords.perp(&places[(k + 1) % 200].coords)).sum();
        let asked = asked.into_inner();
        assert!(asked.len() > 2);
        let last = asked[asked.len() - 1][1];
        assert!((last - 0.5 * doubled).abs() < 1e-9 * doubled.abs(), "{last} {doubled}");
        let mut early = BoundarySolver::new(&problem);
        let stopped = early.solve_until(ITERATIONS, |_, area| (area - last).abs() < 0.05 * last);
        assert_eq!(stopped.status, Status::Running);
        assert!(stopped.iterations < outcome.iterations, "{stopped:?} {outcome:?}");
    }

    #[test]
    fn what_is_told_on_the_way_is_as_near_as_its_steps_say() {
        // Caps and ovals of little and of much curvature, with coarse and fine rims.
        for (n, curvature, bump) in
            [(40, 0.6, 0.0), (1000, 0.6, 0.0), (1000, 0.3, 0.4), (1000, 2.0, 0.4), (300, 4.0, 0.7)]
        {
            let turn = |i: usize| {
                let mean = (2.0 * PI - curvature) / f64::from(n);
                mean * (1.0 + bump * (4.0 * PI * i as f64 / f64::from(n)).cos())
            };
            let count = n as usize;
            let problem = BoundaryProblem {
                lengths: vec![1.0; count],
                angles: (0..count).map(|i| PI - turn(i)).collect(),
                loops: vec![0; count],
                loop_count: 1,
                cuts: vec![],
            };
            let asked = std::cell::RefCell::new(Vec::new());
            let mut solver = BoundarySolver::new(&problem);
            let outcome = solver.solve_until(ITERATIONS, |change, area| {
                asked.borrow_mut().push([change, area]);
                false
            });
            assert_eq!(outcome.status, Status::Converged);
            let places = solver.places();
            let area: f64 = (0..count)
                .map(|k| 0.5 * places[k].coords.perp(&places[(k + 1) % count].coords))
                .sum();
            let asked = asked.into_inner();
            assert!(!asked.is_empty());
            for [change, told] in asked {
                let most = change * f64::from(n * n) / 2.0 + 1e-9 * area;
                assert!((told - area).abs() <= most, "{n} {curvature}: {told} {area} {change}");
            }
        }
    }

    #[test]
    fn polygons_that_cannot_be_closed_are_infeasible() {
        let mut problem = bumpy(12);
        problem.lengths[3] = 100.0;
        assert_eq!(BoundarySolver::new(&problem).solve().status, Status::Infeasible);
        problem.lengths[3] = 0.0;
        assert_eq!(BoundarySolver::new(&problem).solve().status, Status::Infeasible);
        problem.lengths[3] = f64::NAN;
        assert_eq!(BoundarySolver::new(&problem).solve().status, Status::Infeasible);
        let two = BoundaryProblem {
            lengths: vec![1.0; 2],
            angles: vec![0.0; 2],
            loops: vec![0; 2],
            loop_count: 1,
            cuts: vec![],
        };
        assert_eq!(BoundarySolver::new(&two).solve().status, Status::Infeasible);
    }

    #[test]
    fn a_flat_polygon_is_its_own_solution_at_any_scale() {
        for scale in [1e-6, 1.0, 1e6] {
            let problem = BoundaryProblem {
                lengths: [2.0, 1.0, 1.0, 1.0, 1.0, 2.0].map(|l| l * scale).to_vec(),
                angles: [PI / 2.0, PI / 2.0, PI / 2.0, 1.5 * PI, PI / 2.0, PI / 2.0].to_vec(),
                loops: vec![0; 6],
                loop_count: 1,
                cuts: vec![],
            };
            let mut solver = BoundarySolver::new(&problem);
            let outcome = solver.solve();
            assert_eq!((outcome.status, outcome.iterations), (Status::Converged, 1));
            assert!(outcome.angle_error < 1e-15);
        }
    }
}
