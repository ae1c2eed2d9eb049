//! The sparse range: an active set over Green's functions.
//!
//! φ depends on the angles linearly, φ(μ) = φ(0) − G μ, and column i of G takes one solve with B. Only the entries between
//! vertices that were ever free are kept (k² numbers, not k functions); φ everywhere is computed afresh after every round, so that
//! no error adds up. The dense problem over these vertices is solved exactly by a primal active-set method: from feasible angles
//! towards the optimum of the free ones, until the first would change its sign or pass its bound, which stops being free. The
//! objective falls with every such move, so it ends.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use super::problem::{ActiveSet, Problem};
use super::system::{NONE, Response};
use crate::linalg::DenseCholesky;

/// Entries of G between vertices that were free at some time. They depend on the surface, the boundary mode and the weights of the
/// distortion only: every later λ reuses them.
#[derive(Clone, Debug, Default)]
pub(super) struct Dictionary {
    members: Vec<u32>,
    /// Place of every dof among the members.
    places: Vec<u32>,
    /// Row `a` has the entries with all members.
    gram: Vec<Vec<f64>>,
    /// Where the batches begin that the columns were computed in.
    batches: Vec<usize>,
}

/// Columns solved for at once. More fill the registers no better and only need memory.
const BATCH: usize = 16;

impl Dictionary {
    pub fn new(dofs: usize) -> Self {
        Self { places: vec![NONE; dofs], ..Self::default() }
    }

    pub fn len(&self) -> usize {
        self.members.len()
    }

    fn entry(&self, a: usize, b: usize) -> f64 {
        self.gram[a][b]
    }

    fn place(&self, i: u32) -> usize {
        self.places[i as usize] as usize
    }

    /// Row `i` of G times angles at some members.
    pub fn product(&self, i: u32, members: &[u32], angles: &[f64]) -> f64 {
        let row = &self.gram[self.place(i)];
        members.iter().zip(angles).map(|(&j, angle)| row[self.place(j)] * angle).sum()
    }

    /// The diagonal of the inverse of G between some members, floating components held by 1 1ᵀ; infinite where rounding cannot tell a
    /// member from the others.
    pub fn inverse_diagonal(&self, problem: &Problem, members: &[u32]) -> Vec<f64> {
        let part = |i: u32| problem.system.component_of[i as usize];
        let entry = |i: u32, j: u32| {
            let is_held =
                part(i) == part(j) && problem.system.components[part(i) as usize].is_floating;
            let own = self.entry(self.place(i), self.place(i));
            self.entry(self.place(i), self.place(j)) + if is_held { own } else { 0.0 }
        };
        let mut factor = DenseCholesky::new();
        let mut order: Vec<u32> = Vec::new();
        for &i in members {
            order.push(i);
            let row: Vec<f64> = order.iter().map(|&j| entry(j, i)).collect();
            if !factor.push(&row) {
                order.pop();
            }
        }
        let mut found = vec![f64::INFINITY; members.len()];
        for (at, i) in order.iter().enumerate() {
            let mut unit = vec![0.0; order.len()];
            unit[at] = 1.0;
            factor.solve(&mut unit);
            if let Ok(k) = members.binary_search(i) {
                found[k] = unit[at];
            }
        }
        found
    }

    /// Which of these have no column yet.
    pub fn missing(&self, dofs: &[u32]) -> Vec<u32> {
        dofs.iter().copied().filter(|&i| self.places[i as usize] == NONE).collect()
    }

    /// Computes columns that are missing.
    pub fn add(&mut self, problem: &mut Problem, missing: &[u32]) {
        for batch in missing.chunks(BATCH) {
            self.add_batch(problem, batch);
        }
    }

    /// Forgets all but some members.
    pub fn retain(&mut self, problem: &mut Problem, dofs: &[u32]) {
        let mut kept = Self::new(problem.system.len());
        for &i in dofs.iter().filter(|&&i| self.places[i as usize] != NONE) {
            kept.places[i as usize] = u32::try_from(kept.members.len()).unwrap_or(NONE);
            kept.members.push(i);
        }
        let row = |i: u32| -> Vec<f64> {
            kept.members.iter().map(|&j| self.entry(self.place(i), self.place(j))).collect()
        };
        kept.gram = kept.members.iter().map(|&i| row(i)).collect();
        kept.batches = (0..kept.members.len()).step_by(BATCH).collect();
        *self = kept;
    }

    fn add_batch(&mut self, problem: &mut Problem, batch: &[u32]) {
        self.batches.push(self.members.len());
        let columns = problem.system.greens(batch);
        for (&i, column) in batch.iter().zip(columns.chunks_exact(problem.system.len())) {
            self.places[i as usize] = u32::try_from(self.members.len()).unwrap_or(NONE);
            self.members.push(i);
            let row: Vec<f64> = self.members.iter().map(|&j| column[j as usize]).collect();
            for (other, value) in self.gram.iter_mut().zip(&row) {
                other.push(*value);
            }
            self.gram.push(row);
        }
    }

    /// The members, batch by batch: what makes the same dictionary again, to the bit.
    pub fn history(&self) -> Vec<Vec<u32>> {
        let ends = self.batches.iter().skip(1).copied().chain([self.members.len()]);
        self.batches.iter().zip(ends).map(|(&a, b)| self.members[a..b].to_vec()).collect()
    }

    /// Goes back or forth to a history: what is missing is computed in the same batches.
    pub fn recall(&mut self, problem: &mut Problem, history: &[Vec<u32>]) {
        let own = self.history();
        let common = own.iter().zip(history).take_while(|(a, b)| a == b).count();
        let kept: usize = own[..common].iter().map(Vec::len).sum();
        for &i in &self.members[kept..] {
            self.places[i as usize] = NONE;
        }
        self.members.truncate(kept);
        self.gram.truncate(kept);
        self.gram.iter_mut().for_each(|row| row.truncate(kept));
        self.batches.truncate(common);
        for batch in &history[common..] {
            self.add_batch(problem, batch);
        }
    }
}

/// The free angles' matrix, factored, and φ at the members of the dictionary.
struct Dense<'a> {
    problem: &'a Problem,
    dictionary: &'a Dictionary,
    factor: DenseCholesky,
    /// Multiple of 1 1ᵀ that is added on every floating component, where only changes of sum 0 are made: the matrix is then
    /// positive definite without any doubt, and the solution the same.
    added: Vec<f64>,
    /// φ at the members when it was last computed in full.
    base: Vec<f64>,
    /// φ at the members; between full steps at the free ones only.
    phi: Vec<f64>,
    /// What angles and constants have changed by since `base`.
    changes: Vec<f64>,
    constants: Vec<f64>,
    /// How often each member was let free.
    entries: Vec<u8>,
}

/// How often an angle may be let free in one round: more is rounding going in circles.
const MOST_ENTRIES: u8 = 4;

/// What became of a round of the dense problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Settled {
    /// Longest relative step that was made: 0 if no angle changed.
    pub moved: f64,
    /// Whether no move is left within the dictionary.
    pub is_done: bool,
}

impl Dense<'_> {
    fn row(&mut self, order: &[u32], i: u32) -> Vec<f64> {
        let c = self.problem.system.component_of[i as usize] as usize;
        let place = self.dictionary.place(i);
        if self.problem.system.components[c].is_floating && self.added[c] == 0.0 {
            self.added[c] = self.dictionary.entry(place, place);
        }
        let added = self.added[c];
        order
            .iter()
            .map(|&j| {
                let same = self.problem.system.component_of[j as usize] as usize == c;
                self.dictionary.entry(place, self.dictionary.place(j))
                    + if same { added } else { 0.0 }
            })
            .collect()
    }

    /// Changes of the free angles that bring φ to its targets, and the constants that φ falls by along.
    fn direction(&self, set: &ActiveSet) -> (Vec<f64>, Vec<f64>) {
        let system = &self.problem.system;
        let parts = system.components.len();
        let mut change: Vec<f64> = set
            .order
            .iter()
            .map(|&i| self.phi[self.dictionary.place(i)] - self.problem.target(set, i as usize))
            .collect();
        self.factor.solve(&mut change);
        let mut constants = vec![0.0; parts];
        let part = |i: u32| system.component_of[i as usize] as usize;
        if set.order.iter().any(|&i| system.components[part(i)].is_floating) {
            let mut ones: Vec<f64> = set
                .order
                .iter()
                .map(|&i| f64::from(u8::from(system.components[part(i)].is_floating)))
                .collect();
            self.factor.solve(&mut ones);
            let mut sums = vec![(0.0, 0.0); parts];
            for (k, &i) in set.order.iter().enumerate() {
                let sum = &mut sums[part(i)];
                *sum = (sum.0 + change[k], sum.1 + ones[k]);
            }
            for (c, (a, b)) in sums.into_iter().enumerate() {
                if system.components[c].is_floating && b > 0.0 {
                    constants[c] = a / b;
                }
            }
            for (k, &i) in set.order.iter().enumerate() {
                change[k] -= constants[part(i)] * ones[k];
            }
        }
        (change, constants)
    }

    /// Moves the free angles by a fraction of a change.
    fn apply(&mut self, set: &mut ActiveSet, change: &[f64], constants: &[f64], fraction: f64) {
        for (k, &i) in set.order.iter().enumerate() {
            set.angles[i as usize] += fraction * change[k];
        }
        for (k, &i) in set.order.iter().enumerate() {
            let place = self.dictionary.place(i);
            self.changes[place] += fraction * change[k];
            let off = self.phi[place] - self.problem.target(set, i as usize);
            self.phi[place] -= fraction * off;
        }
        for (sum, c) in self.constants.iter_mut().zip(constants) {
            *sum += fraction * c;
        }
    }

    /// Computes φ at all members from what has changed.
    fn refresh(&mut self) {
        let moved: Vec<usize> =
            (0..self.changes.len()).filter(|&a| self.changes[a] != 0.0).collect();
        for a in 0..self.base.len() {
            let c = self.problem.system.component_of[self.dictionary.members[a] as usize];
            let sum: f64 =
                moved.iter().map(|&b| self.dictionary.entry(a, b) * self.changes[b]).sum();
            self.base[a] -= sum + self.constants[c as usize];
        }
        self.phi.copy_from_slice(&self.base);
        self.changes.fill(0.0);
        self.constants.fill(0.0);
    }

    /// Moves until nothing is left to move.
    fn descend(&mut self, set: &mut ActiveSet, tolerance: f64) -> Settled {
        let (problem, dictionary) = (self.problem, self.dictionary);
        let dense = self;
        let mut moved: f64 = 0.0;
        // Every move lowers the objective, so none repeats; the limit is for rounding.
        for _ in 0..20 * dictionary.len() + 100 {
            let (change, constants) = dense.direction(set);
            let mut fraction = 1.0;
            let mut blocking = None;
            for (k, &i) in set.order.iter().enumerate() {
                let [low, high] = problem.interval(set, i as usize);
                let (angle, d) = (set.angles[i as usize], change[k]);
                let room = if d > 0.0 { high - angle } else { angle - low };
                if d != 0.0 && room < fraction * d.abs() {
                    fraction = (room / d.abs()).max(0.0);
                    blocking = Some((k, if d > 0.0 { high } else { low }));
                }
            }
            dense.apply(set, &change, &constants, fraction);
            if change.iter().any(|d| *d != 0.0) {
                moved = moved.max(fraction);
            }
            if let Some((k, bound)) = blocking {
                let i = set.order.remove(k) as usize;
                dense.factor.remove(k);
                set.angles[i] = bound;
                set.stances[i] = problem.stance_at(i, bound);
                continue;
            }
            dense.refresh();
            let mut worst = (tolerance, None);
            for (a, &i) in dictionary.members.iter().enumerate() {
                let (excess, sign) = problem.excess(set, i as usize, dense.phi[a]);
                if excess > worst.0 && dense.entries[a] < MOST_ENTRIES {
                    worst = (excess, Some((i, sign)));
                }
            }
            let Some((i, sign)) = worst.1 else { return Settled { moved, is_done: true } };
            set.release(i, sign);
            dense.entries[dictionary.place(i)] += 1;
            let row = dense.row(&set.order, i);
            if !dense.factor.push(&row) {
                set.order.pop();
                set.stances[i as usize] = problem.stance_at(i as usize, set.angles[i as usize]);
                return Settled { moved, is_done: true };
            }
        }
        Settled { moved, is_done: false }
    }
}

/// Solves the problem over the members of the dictionary, in place.
///
/// **Takes** feasible angles and their φ at every dof, shifted or not. Every free angle is a member.
pub(super) fn settle(
    problem: &Problem,
    dictionary: &Dictionary,
    set: &mut ActiveSet,
    phi: &[f64],
    tolerance: f64,
) -> Settled {
    let base: Vec<f64> = dictionary.members.iter().map(|&i| phi[i as usize]).collect();
    let mut dense = Dense {
        problem,
        dictionary,
        factor: DenseCholesky::new(),
        added: vec![0.0; problem.system.components.len()],
        phi: base.clone(),
        changes: vec![0.0; base.len()],
        constants: vec![0.0; problem.system.components.len()],
        entries: vec![0; base.len()],
        base,
    };
    // Angles that rounding cannot tell from the others stay as they are.
    let mut parked = Vec::new();
    let order = std::mem::take(&mut set.order);
    for i in order {
        set.order.push(i);
        let row = dense.row(&set.order, i);
        if !dense.factor.push(&row) {
            set.order.pop();
            parked.push(i);
        }
    }
    let settled = dense.descend(set, tolerance);
    set.order.extend(parked);
    settled
}

/// The angles to be let free next: where the excess is larger than at all neighbours, the largest first, at most `limit`.
///
/// **Takes** φ at every dof, shifted.
pub(super) fn entering(
    problem: &Problem,
    set: &ActiveSet,
    phi: &[f64],
    tolerance: f64,
    limit: usize,
) -> Vec<(u32, f64)> {
    let system = &problem.system;
    let excess: Vec<(f64, f64)> =
        phi.iter().enumerate().map(|(i, &p)| problem.excess(set, i, p)).collect();
    let mut found: Vec<usize> = (0..excess.len())
        .filter(|&i| excess[i].0 > tolerance)
        .filter(|&i| {
            let ring = &system.neighbours[system.starts[i] as usize..system.starts[i + 1] as usize];
            ring.iter().all(|&j| {
                let other = excess[j as usize].0;
                other < excess[i].0 || (other <= excess[i].0 && i < j as usize)
            })
        })
        .collect();
    found.sort_by(|&a, &b| excess[b].0.total_cmp(&excess[a].0).then(a.cmp(&b)));
    found.truncate(limit);
    found.into_iter().map(|i| (i as u32, excess[i].1)).collect()
}

/// φ of a response, with its constants.
pub(super) fn shifted(problem: &Problem, set: &ActiveSet, response: &Response) -> Vec<f64> {
    let mut phi = response.phi.clone();
    problem.shift(set, &mut phi);
    phi
}
