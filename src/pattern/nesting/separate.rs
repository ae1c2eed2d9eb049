//! Moving overlapping parts apart within stock that is a little too short.
//!
//! Minimises Σ wᵢⱼ √Eᵢⱼ, where Eᵢⱼ adds up how far inscribed disks and points of the rim of either part reach into the other grown
//! by the gap: about an area, its root a length. The root lets few pairs overlap rather than many a little. Parts that overlap are moved one at a time to the best of many places, near and far, each improved by steps down the
//! slope of length f / |∇f|² for f = Σ w √E (Polyak's, for what can be 0); then the weights of pairs that
//! still overlap grow, so that no pair stays caught between others for ever. Between, all parts push one another.

use super::part::{Part, Spot};
use super::plane::{Dice, Turn, cross, minus};
use super::probe::{Meeting, Probe};
use super::room::Bins;
use crate::pattern::piece::Bounds;

/// Places anywhere that are tried for a part, and places near its own.
const FAR: usize = 40;
const NEAR: usize = 10;
/// The best of these are improved, by so many steps at most.
const IMPROVED: usize = 3;
const STEPS: usize = 12;
/// Weights of overlapping pairs grow by factors from the first to the second, by how much they overlap; others shrink by the third.
const WEIGHTS: [f64; 3] = [1.2, 2.0, 0.95];

/// Rounds of pushing that may make it worse, one after the other, before it is left.
const IDLE: usize = 5;
/// Parts that are too close move apart by this part of their size further than the gap, so that they do not come closer and closer
/// to it without end. None has to keep that distance.
const EASE: f64 = 3e-4;

/// Parts on their way apart.
#[derive(Clone, Debug)]
pub(super) struct Separation {
    pub spots: Vec<Spot>,
    pub bins: Bins,
    margin: f64,
    /// What parts move apart to.
    gap: f64,
    /// By how much they may fall short of it.
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
        (bins, margin, gap): (Bins, f64, f64),
        dice: &mut Dice,
    ) -> Self {
        let n = parts.len();
        let pairs = n * n.saturating_sub(1) / 2;
        let scale = parts.iter().map(|p| p.diameter).fold(0.0, f64::max);
        let ease = EASE * (parts.iter().map(|p| p.area).sum::<f64>() / n as f64).sqrt();
        let mut search = Self {
            spots: spots.to_vec(),
            bins,
            margin,
            gap: gap + ease,
            touch: ease + (1e-10 * scale).min(5e-7),
            weights: vec![1.0; pairs],
            overlaps: vec![0.0; pairs],
            work: 0,
        };
        for i in 0..n {
            let spot = search.spots[i];
            let kept = (spot.sheet < bins.sheets).then(|| search.clamped(&spot)).flatten();
            // What is left of the stock is too low for the part as it is turned: anywhere.
            let tries = (0..20).find_map(|_| search.anywhere(&parts[i], dice));
            if let Some(spot) = kept.or(tries) {
                search.spots[i] = spot;
            }
        }
        search.measure_all(probes);
        search
    }

    /// The first part in a spot and the second where it lies.
    fn meeting<'a>(
        &'a self,
        probes: &'a [Probe],
        [i, j]: [usize; 2],
        spot: &'a Spot,
    ) -> Meeting<'a> {
        let (probes, spots) = ([&probes[i], &probes[j]], [spot, &self.spots[j]]);
        Meeting { probes, spots, gap: self.gap, touch: self.touch }
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
        Some(spot.moved(by))
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
        let (extent, middle) = (fit.size(), spot.middle());
        let corner = [0, 1].map(|k| middle[k] - 0.5 * extent[k]);
        self.clamped(&Spot::new(spot.sheet, &fit, corner))
    }

    /// Weighted overlap of a part in a spot with all others, by few samples; more than `most` once it is known to be.
    fn coarse_energy(&mut self, probes: &[Probe], i: usize, spot: &Spot, most: f64) -> f64 {
        let mut sum = 0.0;
        let mut work = 1;
        for j in (0..self.spots.len()).filter(|&j| j != i) {
            let weight = self.weights[pair(i, j)];
            let meeting = self.meeting(probes, [i, j], spot);
            let rest = (most - sum) / weight;
            sum += weight * meeting.overlap(true, rest * rest, &mut work).sqrt();
            if sum > most {
                break;
            }
        }
        self.work += work;
        sum
    }

    /// Weighted overlap of a part in a spot with all others, and its slope against shifts and turns.
    fn energy(&mut self, probes: &[Probe], i: usize, spot: &Spot) -> (f64, [f64; 3]) {
        let mut sum = 0.0;
        let mut slope = [0.0; 3];
        let mut work = 1;
        let middle = spot.middle();
        for j in (0..self.spots.len()).filter(|&j| j != i) {
            let meeting = self.meeting(probes, [i, j], spot);
            if !meeting.is_apart() {
                let weight = self.weights[pair(i, j)];
                let (overlap, along) = meeting.slope(middle, &mut work);
                if overlap > 0.0 {
                    let root = overlap.sqrt();
                    sum += weight * root;
                    (0..3).for_each(|k| slope[k] += 0.5 * weight * along[k] / root);
                }
            }
        }
        self.work += work;
        (sum, slope)
    }

    /// Measures a pair.
    fn measure(&mut self, probes: &[Probe], i: usize, j: usize, work: &mut u64) {
        let meeting = self.meeting(probes, [i, j], &self.spots[i]);
        self.overlaps[pair(i, j)] = meeting.overlap(false, f64::INFINITY, work);
    }

    fn measure_all(&mut self, probes: &[Probe]) {
        let mut work = 0;
        for j in 1..self.spots.len() {
            (0..j).for_each(|i| self.measure(probes, i, j, &mut work));
        }
        self.work += work;
    }

    /// Measures a part against all others, in the order of numbers so that both measure the same.
    fn measure_one(&mut self, probes: &[Probe], i: usize) {
        let mut work = 0;
        for j in (0..self.spots.len()).filter(|&j| j != i) {
            self.measure(probes, i.min(j), i.max(j), &mut work);
        }
        self.work += work;
    }

    /// Parts that overlap another.
    pub fn entangled(&self) -> Vec<usize> {
        let n = self.spots.len();
        let mut is_in = vec![false; n];
        for j in 1..n {
            for i in (0..j).filter(|&i| self.overlaps[pair(i, j)] > 0.0) {
                is_in[i] = true;
                is_in[j] = true;
            }
        }
        (0..n).filter(|&i| is_in[i]).collect()
    }

    /// Moves a part to where it overlaps less, if there is such a place.
    pub fn relocate(&mut self, parts: &[Part], probes: &[Probe], i: usize, dice: &mut Dice) {
        let part = &parts[i];
        let own = self.spots[i];
        let (current, _) = self.energy(probes, i, &own);
        if !(current > 0.0) {
            return;
        }
        let mut best: Vec<(f64, Spot)> = Vec::new();
        for k in 0..NEAR + FAR {
            let spot = if k < NEAR {
                let reach = 0.25 * part.diameter;
                let by = [dice.between(-reach, reach), dice.between(-reach, reach)];
                let fit = part.random_fit(dice);
                self.turned(part, &own.moved(by), fit.turn)
            } else {
                self.anywhere(part, dice)
            };
            let Some(spot) = spot else { continue };
            let most = if best.len() < IMPROVED { f64::INFINITY } else { best[IMPROVED - 1].0 };
            let energy = self.coarse_energy(probes, i, &spot, most);
            if energy < most {
                let at = best.partition_point(|(e, _)| *e <= energy);
                best.insert(at, (energy, spot));
                best.truncate(IMPROVED);
            }
        }
        best.insert(0, (current, own));
        let mut winner = (current, own);
        for &(_, spot) in &best {
            let found = self.descend(part, probes, i, spot);
            if found.0 < winner.0 {
                winner = found;
            }
            if winner.0 <= 0.0 {
                break;
            }
        }
        if winner.0 < current * (1.0 - 1e-9) {
            self.spots[i] = winner.1;
            self.measure_one(probes, i);
        }
    }

    /// Steps down the slope; the best spot on the way.
    fn descend(&mut self, part: &Part, probes: &[Probe], i: usize, from: Spot) -> (f64, Spot) {
        let mut spot = from;
        let mut best = (f64::INFINITY, spot);
        // Lengths of turns: what a turn moves the part's points by, about.
        let arm = if part.turns_freely() { 0.3 * part.diameter } else { f64::INFINITY };
        for _ in 0..STEPS {
            let (energy, [x, y, turn]) = self.energy(probes, i, &spot);
            if energy < best.0 {
                best = (energy, spot);
            }
            let turning = turn / arm;
            let squared = x * x + y * y + turning * turning;
            if !(energy > 0.0 && squared > 0.0) {
                break;
            }
            let reach = 0.2 * part.diameter;
            // A little too far, so that what can be 0 becomes 0.
            let step = (1.05 * energy / squared).min(reach / squared.sqrt());
            if turning != 0.0 {
                let turn = part.turned(spot.turn, -step * turning / arm);
                spot = self.turned(part, &spot, turn).unwrap_or(spot);
            }
            let Some(moved) = self.clamped(&spot.moved([-step * x, -step * y])) else { break };
            spot = moved;
        }
        best
    }

    /// Pushes all parts apart together, as bodies that touch would: for each pair, and each way, the sample that reaches in deepest
    /// moves both parts along the field's slope, turns them where they may, until nothing reaches in or rounds are over. Keeps the
    /// best round.
    pub fn relax(&mut self, parts: &[Part], probes: &[Probe], (rounds, work): (usize, u64)) {
        let end = self.work + work;
        let mut total = self.total();
        let mut idle = 0;
        let mut best = (total, self.spots.clone());
        for _ in 0..rounds {
            if total <= 0.0 || self.work > end {
                break;
            }
            for j in 1..parts.len() {
                for i in 0..j {
                    self.push(parts, probes, [i, j]);
                    self.push(parts, probes, [j, i]);
                }
            }
            self.measure_all(probes);
            total = self.total();
            if total < best.0 {
                best = (total, self.spots.clone());
                idle = 0;
            } else {
                idle += 1;
                if idle > IDLE {
                    break;
                }
            }
        }
        if total > best.0 {
            self.spots = best.1;
            self.measure_all(probes);
        }
    }

    /// Resolves the deepest contact of samples of one part with the field of another.
    fn push(&mut self, parts: &[Part], probes: &[Probe], bodies: [usize; 2]) {
        let [i, j] = bodies;
        let meeting = self.meeting(probes, [i, j], &self.spots[i]);
        if meeting.is_apart() {
            return;
        }
        let mut work = 0;
        let contact = meeting.deepest(&mut work);
        self.work += work;
        let Some(contact) = contact else { return };
        let levers = bodies.map(|body| {
            let arm = minus(contact.at, self.spots[body].middle());
            let inertia = 0.1 * parts[body].diameter * parts[body].diameter;
            let lever = cross(arm, contact.out);
            (lever, if parts[body].turns_freely() { lever / inertia } else { 0.0 })
        });
        let ease: f64 = levers.iter().map(|(lever, turn)| 1.0 + lever * turn).sum();
        // A little further than needed, so that rounding leaves nothing.
        let push = (1.02 * contact.depth + 2.0 * self.touch) / ease;
        for ((body, (_, turn)), sign) in bodies.into_iter().zip(levers).zip([1.0, -1.0]) {
            let mut spot = self.spots[body];
            if turn != 0.0 {
                let turn = parts[body].turned(spot.turn, sign * push * turn);
                spot = self.turned(&parts[body], &spot, turn).unwrap_or(spot);
            }
            if let Some(moved) = self.clamped(&spot.moved(contact.out.map(|x| sign * push * x))) {
                self.spots[body] = moved;
            }
        }
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
    pub fn swap(&mut self, probes: &[Probe], [i, j]: [usize; 2]) {
        let (s, t) = (self.spots[i], self.spots[j]);
        let by = minus(t.middle(), s.middle());
        let [to_t, to_s] = [(s, by, t.sheet), (t, by.map(|x| -x), s.sheet)]
            .map(|(spot, by, sheet)| self.clamped(&Spot { sheet, ..spot.moved(by) }));
        if let (Some(to_t), Some(to_s)) = (to_t, to_s) {
            self.spots[i] = to_t;
            self.spots[j] = to_s;
            self.measure_one(probes, i);
            self.measure_one(probes, j);
        }
    }
}

fn pair(i: usize, j: usize) -> usize {
    let (a, b) = (i.min(j), i.max(j));
    b * (b - 1) / 2 + a
}
