//! Moving overlapping parts apart within stock that is a little too short.
//!
//! Minimises Σ wᵢⱼ Eᵢⱼ, where Eᵢⱼ adds up how far inscribed disks and points of the rim of either part reach into the other grown
//! by the gap. Parts that overlap are moved one at a time to the best of many places, near and far, each improved by a pattern search;
//! then the weights of pairs that still overlap grow, so that no pair stays caught between others for ever.

use super::field::Field;
use super::part::{Part, Spot};
use super::plane::{self, Dice, Turn, minus, size};
use super::room::Bins;
use crate::pattern::piece::Bounds;

/// Places anywhere that are tried for a part, and places near its own.
const FAR: usize = 24;
const NEAR: usize = 10;
/// The best of these are improved.
const IMPROVED: usize = 3;
/// Tries of a pattern search at most.
const TRIES: usize = 40;
/// It ends with steps of this part of the size of a part.
const FINEST: f64 = 2e-4;
/// Weights of overlapping pairs grow by factors from the first to the second, by how much they overlap; others shrink by the third.
const WEIGHTS: [f64; 3] = [1.2, 2.0, 0.95];
/// Disks within a part.
const DISKS: usize = 12;
/// Points along a rim, at least.
const RIM: f64 = 32.0;

/// A place of a part that must keep away from others by its radius and the gap.
#[derive(Clone, Copy, Debug)]
struct Sample {
    at: [f64; 2],
    radius: f64,
    /// How much counts how far it reaches in: length of rim.
    weight: f64,
}

/// What the search knows of a part.
#[derive(Clone, Debug)]
pub(super) struct Probe {
    field: Field,
    samples: Vec<Sample>,
    slack: f64,
}

impl Probe {
    /// **Costs** the most of all preparations: about 2000 cells times the points of the rim.
    pub fn new(part: &Part, gap: f64, most_slack: f64) -> Self {
        let exact = [gap + part.slack, gap + part.slack + most_slack];
        let field = Field::new(&part.rim, exact, exact[1] + 0.1 * part.diameter);
        let mut samples: Vec<Sample> = field
            .disks(DISKS)
            .into_iter()
            // Smaller than they are: fields of others are not exact where disks meet them.
            .map(|(at, radius)| Sample { at, radius: 0.8 * radius, weight: 2.0 * radius })
            .collect();
        let lengths = part.rim.iter().flat_map(|outline| plane::sides(outline));
        let length: f64 = lengths.map(|[a, b]| size(minus(b, a))).sum();
        let step = length / RIM;
        for [a, b] in part.rim.iter().flat_map(|outline| plane::sides(outline)) {
            let along = minus(b, a);
            let parts = (size(along) / step).ceil().max(1.0);
            let weight = (size(along) / parts).max(0.25 * step);
            let mut k = 0.0;
            while k < parts {
                let at = [0, 1].map(|axis| a[axis] + k / parts * along[axis]);
                samples.push(Sample { at, radius: 0.0, weight });
                k += 1.0;
            }
        }
        Self { field, samples, slack: part.slack }
    }

    /// One more place on the rim, where the others missed that another part reaches in.
    pub fn add(&mut self, at: [f64; 2]) {
        let weight = self.samples.last().map_or(1.0, |sample| sample.weight);
        self.samples.push(Sample { at, radius: 0.0, weight });
    }
}

/// Parts on their way apart.
#[derive(Clone, Debug)]
pub(super) struct Separation {
    pub spots: Vec<Spot>,
    pub bins: Bins,
    margin: f64,
    gap: f64,
    /// Reaching in less than this is rounding.
    touch: f64,
    /// For pairs i < j at j (j − 1) / 2 + i.
    weights: Vec<f64>,
    overlaps: Vec<f64>,
    /// Samples looked up so far.
    pub work: u64,
}

impl Separation {
    /// Parts as they lie, moved into the stock given.
    pub fn new(
        parts: &[Part],
        probes: &[Probe],
        spots: &[Spot],
        bins: Bins,
        margin: f64,
        gap: f64,
        dice: &mut Dice,
    ) -> Self {
        let n = parts.len();
        let pairs = n * n.saturating_sub(1) / 2;
        let scale = parts.iter().map(|p| p.diameter).fold(0.0, f64::max);
        let mut search = Self {
            spots: spots.to_vec(),
            bins,
            margin,
            gap,
            touch: (1e-10 * scale).min(5e-7),
            weights: vec![1.0; pairs],
            overlaps: vec![0.0; pairs],
            work: 0,
        };
        for i in 0..n {
            let spot = search.spots[i];
            let kept = (spot.sheet < bins.sheets).then(|| search.clamped(&spot)).flatten();
            // What is left of the stock is too low for the part as it is turned: anywhere.
            let spot = kept.or_else(|| search.anywhere(&parts[i], dice));
            if let Some(spot) = spot {
                search.spots[i] = spot;
            }
        }
        for i in 0..n {
            search.measure(probes, i);
        }
        search
    }

    /// All overlaps, unweighted; 0 where parts keep their distance.
    pub fn total(&self) -> f64 {
        self.overlaps.iter().sum()
    }

    /// Whether all parts lie within the stock: not where one was too high for what is left of it.
    pub fn is_within(&self) -> bool {
        self.spots.iter().all(|spot| {
            spot.sheet < self.bins.sheets && self.clamped(spot).is_some_and(|c| c == *spot)
        })
    }

    /// The places that a part of an extent may have its low corner in.
    fn range(&self, sheet: usize, extent: [f64; 2]) -> Option<Bounds> {
        let low = [self.margin; 2];
        let stock = [self.bins.width, self.bins.height_of(sheet)];
        let high = [0, 1].map(|k| {
            let high = stock[k] - self.margin - extent[k];
            // Rounding of what fits exactly.
            if high < low[k] && high > low[k] - 1e-10 * extent[k] { low[k] } else { high }
        });
        (high[0] >= low[0] && high[1] >= low[1]).then_some(Bounds { low, high })
    }

    /// The spot moved into the stock.
    fn clamped(&self, spot: &Spot) -> Option<Spot> {
        let Bounds { low, high } = spot.bounds;
        let range = self.range(spot.sheet, minus(high, low))?;
        let by = [0, 1].map(|k| low[k].clamp(range.low[k], range.high[k]) - low[k]);
        Some(if by == [0.0; 2] { *spot } else { spot.moved(by) })
    }

    /// A random spot; `None` if the turn drawn fits nowhere.
    fn anywhere(&self, part: &Part, dice: &mut Dice) -> Option<Spot> {
        let fit = part.random_fit(dice);
        let sheet = dice.below(self.bins.sheets);
        let range = self.range(sheet, fit.size())?;
        let corner = [0, 1].map(|k| dice.between(range.low[k], range.high[k]));
        Some(Spot::new(sheet, &fit, corner))
    }

    /// A spot with another turn about the middle of its extent.
    fn turned(&self, part: &Part, spot: &Spot, turn: Turn) -> Option<Spot> {
        let fit = part.fit(turn);
        let extent = fit.size();
        let Bounds { low, high } = spot.bounds;
        let corner = [0, 1].map(|k| 0.5 * (low[k] + high[k] - extent[k]));
        self.clamped(&Spot::new(spot.sheet, &fit, corner))
    }

    /// How far one part reaches into another and the other way.
    fn overlap(&self, [a, b]: [&Probe; 2], [s, t]: [&Spot; 2], most: f64, work: &mut u64) -> f64 {
        let gap = self.gap + a.slack + b.slack;
        let is_apart = |k: usize| {
            s.bounds.low[k] >= t.bounds.high[k] + gap || t.bounds.low[k] >= s.bounds.high[k] + gap
        };
        if s.sheet != t.sheet || is_apart(0) || is_apart(1) {
            return 0.0;
        }
        let mut sum = 0.0;
        for [(a, s), (b, t)] in [[(a, s), (b, t)], [(b, t), (a, s)]] {
            let [p, q, r, u] = s.turn.relative_to(&t.turn);
            let [x, y] = t.turn.undo(minus(s.at, t.at));
            for sample in &a.samples {
                let [px, py] = sample.at;
                let at = [p * px + q * py + x, r * px + u * py + y];
                let inside = gap + sample.radius - b.field.distance(at);
                if inside > self.touch {
                    sum += sample.weight * inside;
                    if sum > most {
                        return sum;
                    }
                }
            }
            *work += a.samples.len() as u64;
        }
        sum
    }

    /// Weighted overlap of a part in a spot with all others; more than `most` once it is known to be.
    fn energy(&mut self, probes: &[Probe], i: usize, spot: &Spot, most: f64) -> f64 {
        let mut sum = 0.0;
        let mut work = 0;
        for (j, other) in self.spots.iter().enumerate() {
            if j != i {
                let weight = self.weights[pair(i, j)];
                let rest = (most - sum) / weight;
                sum +=
                    weight * self.overlap([&probes[i], &probes[j]], [spot, other], rest, &mut work);
                if sum > most {
                    break;
                }
            }
        }
        self.work += work + 1;
        sum
    }

    /// Measures a part against those before and after it.
    fn measure(&mut self, probes: &[Probe], i: usize) {
        let mut work = 0;
        for j in (0..self.spots.len()).filter(|&j| j != i) {
            // In the order of numbers, so that both measure the same.
            let (a, b) = (i.min(j), i.max(j));
            let spots = [&self.spots[a], &self.spots[b]];
            let overlap = self.overlap([&probes[a], &probes[b]], spots, f64::INFINITY, &mut work);
            self.overlaps[pair(i, j)] = overlap;
        }
        self.work += work;
    }

    /// Parts that overlap another.
    pub fn entangled(&self) -> Vec<usize> {
        let n = self.spots.len();
        let mut is_in = vec![false; n];
        for j in 1..n {
            for i in 0..j {
                if self.overlaps[pair(i, j)] > 0.0 {
                    is_in[i] = true;
                    is_in[j] = true;
                }
            }
        }
        (0..n).filter(|&i| is_in[i]).collect()
    }

    /// Moves a part to where it overlaps less, if there is such a place.
    pub fn relocate(&mut self, parts: &[Part], probes: &[Probe], i: usize, dice: &mut Dice) {
        let part = &parts[i];
        let own = self.spots[i];
        let current = self.energy(probes, i, &own, f64::INFINITY);
        if !(current > 0.0) {
            return;
        }
        let mut best: Vec<(f64, Spot)> = vec![(current, own)];
        for k in 0..FAR + NEAR {
            let spot = if k < NEAR {
                let reach = 0.25 * part.diameter;
                let by = [dice.between(-reach, reach), dice.between(-reach, reach)];
                let moved = own.moved(by);
                if k % 2 == 0 {
                    self.clamped(&moved)
                } else {
                    let fit = part.random_fit(dice);
                    self.turned(part, &moved, fit.turn)
                }
            } else {
                self.anywhere(part, dice)
            };
            let Some(spot) = spot else { continue };
            let most = if best.len() > IMPROVED { best[IMPROVED].0 } else { f64::INFINITY };
            let energy = self.energy(probes, i, &spot, most);
            if energy < most {
                let at = best.partition_point(|(e, _)| *e <= energy);
                best.insert(at, (energy, spot));
                best.truncate(IMPROVED + 1);
            }
        }
        let mut winner = (current, own);
        for &(energy, spot) in &best {
            let found = self.improve(part, probes, i, (energy, spot), dice);
            if found.0 < winner.0 {
                winner = found;
            }
            if winner.0 <= 0.0 {
                break;
            }
        }
        if winner.0 < current * (1.0 - 1e-9) {
            self.spots[i] = winner.1;
            self.measure(probes, i);
        }
    }

    /// Pattern search: steps along axes and diagonals, and turns, longer after success and shorter after failure.
    fn improve(
        &mut self,
        part: &Part,
        probes: &[Probe],
        i: usize,
        (mut energy, mut spot): (f64, Spot),
        dice: &mut Dice,
    ) -> (f64, Spot) {
        let mut step = 0.05 * part.diameter;
        let mut turn = 0.1;
        let ways = if part.turns_freely() { 5 } else { 4 };
        for _ in 0..TRIES {
            if energy <= 0.0 || step < FINEST * part.diameter {
                break;
            }
            let way = dice.below(ways);
            let along = [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, -1.0], [0.0, 0.0]][way];
            let mut is_better = false;
            for sign in [-1.0, 1.0] {
                let trial = if way == 4 {
                    self.turned(part, &spot, part.turned(spot.turn, sign * turn))
                } else {
                    self.clamped(&spot.moved(along.map(|x| x * sign * step)))
                };
                let Some(trial) = trial else { continue };
                let found = self.energy(probes, i, &trial, energy);
                if found < energy {
                    (energy, spot) = (found, trial);
                    is_better = true;
                    break;
                }
            }
            let factor = if is_better { 1.1 } else { 0.5 };
            if way == 4 {
                turn *= factor;
            } else {
                step *= factor;
            }
        }
        (energy, spot)
    }

    /// Pushes all parts apart together, as bodies that touch would: for each pair, and each way, the sample that reaches in deepest
    /// moves both parts along the field's gradient, turns them where they may, until nothing reaches in or rounds are over. Keeps the
    /// best round.
    pub fn relax(&mut self, parts: &[Part], probes: &[Probe], rounds: usize) {
        let n = parts.len();
        let mut total = self.total();
        let mut best = (total, self.spots.clone());
        for _ in 0..rounds {
            if total <= 0.0 {
                break;
            }
            for j in 1..n {
                for i in 0..j {
                    for [a, b] in [[i, j], [j, i]] {
                        self.push(parts, probes, [a, b]);
                    }
                }
            }
            (0..n).for_each(|i| self.measure_before(probes, i));
            total = self.total();
            if total < best.0 {
                best = (total, self.spots.clone());
            }
        }
        if total > best.0 {
            self.spots = best.1;
            (0..n).for_each(|i| self.measure_before(probes, i));
        }
    }

    /// Resolves the deepest contact of samples of one part with the field of another.
    fn push(&mut self, parts: &[Part], probes: &[Probe], [i, j]: [usize; 2]) {
        let (s, t) = (self.spots[i], self.spots[j]);
        let (a, b) = (&probes[i], &probes[j]);
        let gap = self.gap + a.slack + b.slack;
        let is_apart = |k: usize| {
            s.bounds.low[k] >= t.bounds.high[k] + gap || t.bounds.low[k] >= s.bounds.high[k] + gap
        };
        if s.sheet != t.sheet || is_apart(0) || is_apart(1) {
            return;
        }
        let [p, q, r, u] = s.turn.relative_to(&t.turn);
        let [x, y] = t.turn.undo(minus(s.at, t.at));
        let place = |[px, py]: [f64; 2]| [p * px + q * py + x, r * px + u * py + y];
        self.work += a.samples.len() as u64;
        let mut deepest = (self.touch, [0.0; 2], [0.0; 2]);
        for sample in &a.samples {
            let at = place(sample.at);
            let inside = gap + sample.radius - b.field.distance(at);
            if inside > deepest.0 {
                deepest = (inside, at, sample.at);
            }
        }
        let (depth, at, own) = deepest;
        if depth <= self.touch {
            return;
        }
        let Some(out) = b.field.gradient(at) else { return };
        let out = t.turn.apply(out);
        // From the middle of each part to the contact, across the direction of the push.
        let lever = |spot: &Spot, from: [f64; 2]| {
            let Bounds { low, high } = spot.bounds;
            let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
            let at = spot.turn.apply(from);
            plane::cross(minus([at[0] + spot.at[0], at[1] + spot.at[1]], middle), out)
        };
        let levers = [lever(&s, own), lever(&t, at)];
        let bodies = [i, j];
        let ease = |k: usize| {
            let part = &parts[bodies[k]];
            let inertia = 0.1 * part.diameter * part.diameter;
            if part.turns_freely() { levers[k] / inertia } else { 0.0 }
        };
        let turns = [ease(0), ease(1)];
        // A little further than needed, so that rounding leaves nothing.
        let push =
            (1.02 * depth + 2.0 * self.touch) / (2.0 + turns[0] * levers[0] + turns[1] * levers[1]);
        for (k, sign) in [(0, 1.0), (1, -1.0)] {
            let body = bodies[k];
            let mut spot = self.spots[body];
            if turns[k] != 0.0
                && let turn = parts[body].turned(spot.turn, sign * push * turns[k])
                && let Some(turned) = self.turned(&parts[body], &spot, turn)
            {
                spot = turned;
            }
            let moved = spot.moved(out.map(|x| sign * push * x));
            if let Some(moved) = self.clamped(&moved) {
                self.spots[body] = moved;
            }
        }
    }

    /// Measures a part against those before it.
    fn measure_before(&mut self, probes: &[Probe], i: usize) {
        let mut work = 0;
        for j in 0..i {
            let spots = [&self.spots[j], &self.spots[i]];
            let overlap = self.overlap([&probes[j], &probes[i]], spots, f64::INFINITY, &mut work);
            self.overlaps[pair(i, j)] = overlap;
        }
        self.work += work;
    }

    /// After a round: what still overlaps weighs more.
    pub fn weigh(&mut self) {
        let most = self.overlaps.iter().copied().fold(0.0, f64::max);
        let [least, greatest, shrink] = WEIGHTS;
        for (weight, overlap) in self.weights.iter_mut().zip(&self.overlaps) {
            if *overlap > 0.0 {
                // Far from the range of numbers even after long searches.
                *weight = (*weight * (least + (greatest - least) * overlap / most)).min(1e12);
            } else {
                *weight = (*weight * shrink).max(1.0);
            }
        }
    }

    /// Puts two parts into the places of each other.
    pub fn swap(&mut self, parts: &[Part], probes: &[Probe], [i, j]: [usize; 2]) {
        let middle = |spot: &Spot| {
            let Bounds { low, high } = spot.bounds;
            [0, 1].map(|k| 0.5 * (low[k] + high[k]))
        };
        let (s, t) = (self.spots[i], self.spots[j]);
        let by = minus(middle(&t), middle(&s));
        let [to_t, to_s] = [(s, by, t.sheet), (t, by.map(|x| -x), s.sheet)]
            .map(|(spot, by, sheet)| self.clamped(&Spot { sheet, ..spot.moved(by) }));
        debug_assert_eq!(parts.len(), self.spots.len());
        if let (Some(to_t), Some(to_s)) = (to_t, to_s) {
            self.spots[i] = to_t;
            self.spots[j] = to_s;
            self.measure(probes, i);
            self.measure(probes, j);
        }
    }
}

fn pair(i: usize, j: usize) -> usize {
    let (a, b) = (i.min(j), i.max(j));
    b * (b - 1) / 2 + a
}
