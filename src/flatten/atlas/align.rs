//! Turning and shifting charts onto each other.
//!
//! Wanted are rotations r_α (complex, |r| = 1) and shifts t_α with least E = Σ ∫ χ^α χ^β |r_α φ^α + t_α − r_β φ^β − t_β|² over all
//! pairs of charts. With the moments of φ^α and φ^β over their overlap, E and the best place of one chart among the others are closed
//! formulas, so that nothing below depends on the number of vertices. Charts are placed one by one, always the one that overlaps most
//! with those that have their places; then each is placed again among all its neighbours, in turns, while E falls.
//!
//! E falls with every placing, because each is the exact minimum for one chart. It may end in a local minimum.

use std::collections::BTreeMap;

use nalgebra::{Complex, Point2};

use super::{Covered, complex};
use crate::flatten::Flattening;

/// Rounds after which charts are where they are: with a few neighbours each, E changes by less than `ENOUGH` after about ten.
const ROUNDS: usize = 60;
/// Relative fall of E in a round that is not worth another one.
const ENOUGH: f64 = 1e-6;

type C = Complex<f64>;

/// Moments of two charts over their overlap: Σ a, Σ a p, Σ a q, Σ a p̄ q, Σ a |p|², Σ a |q|².
#[derive(Clone, Copy, Debug, Default)]
struct Overlap {
    weight: f64,
    first: C,
    second: C,
    mixed: C,
    squares: [f64; 2],
}

impl Overlap {
    fn add(&mut self, a: f64, p: C, q: C) {
        self.weight += a;
        self.first += p * a;
        self.second += q * a;
        self.mixed += p.conj() * q * a;
        self.squares[0] += a * p.norm_sqr();
        self.squares[1] += a * q.norm_sqr();
    }

    /// The same pair the other way round.
    fn turned(&self) -> Self {
        Self {
            weight: self.weight,
            first: self.second,
            second: self.first,
            mixed: self.mixed.conj(),
            squares: [self.squares[1], self.squares[0]],
        }
    }

    /// Its part of E.
    fn energy(&self, p: Motion, q: Motion) -> f64 {
        let own = |m: Motion, sum: C, square: f64| {
            square + 2.0 * (m.turn * sum * m.shift.conj()).re + self.weight * m.shift.norm_sqr()
        };
        let mixed = p.turn.conj() * q.turn * self.mixed
            + p.turn.conj() * self.first.conj() * q.shift
            + p.shift.conj() * q.turn * self.second
            + p.shift.conj() * q.shift * self.weight;
        own(p, self.first, self.squares[0]) + own(q, self.second, self.squares[1]) - 2.0 * mixed.re
    }
}

/// z ↦ turn · z + shift.
#[derive(Clone, Copy, Debug)]
struct Motion {
    turn: C,
    shift: C,
}

/// Moves the charts of a flattening; gives the root mean square distance that is left.
pub(super) fn align(
    flattening: &mut Flattening,
    vertex_charts: &[u32],
    covered: &[Covered],
) -> f64 {
    centre(flattening, vertex_charts);
    let count = flattening.charts.len();
    let mut pairs: BTreeMap<[usize; 2], Overlap> = BTreeMap::new();
    for_pairs(flattening, covered, |charts, weight, p, q| {
        pairs.entry(charts).or_default().add(weight, p, q);
    });
    let mut neighbours: Vec<Vec<(usize, Overlap)>> = vec![Vec::new(); count];
    for (&[p, q], overlap) in &pairs {
        neighbours[q].push((p, *overlap));
        neighbours[p].push((q, overlap.turned()));
    }
    let mut motions = place(&neighbours);
    let energy = |motions: &[Motion]| -> f64 {
        pairs.iter().map(|(&[p, q], o)| o.energy(motions[p], motions[q])).sum()
    };
    let mut before = energy(&motions);
    for _ in 0..ROUNDS {
        for chart in 0..count {
            if let Some(best) = fit(&neighbours[chart], |p| Some(motions[p])) {
                motions[chart] = best;
            }
        }
        let after = energy(&motions);
        let has_fallen = after < before * (1.0 - ENOUGH);
        before = after;
        if !has_fallen {
            break;
        }
    }
    for (place, &chart) in flattening.uv.iter_mut().zip(vertex_charts) {
        let motion = motions[chart as usize];
        let moved = motion.turn * complex(*place) + motion.shift;
        *place = Point2::new(moved.re, moved.im);
    }
    misfit(flattening, covered)
}

/// √(E / Σ ∫ χ^α χ^β), place by place: from moments it would be lost in rounding below 1e-8.
fn misfit(flattening: &Flattening, covered: &[Covered]) -> f64 {
    let (mut energy, mut weight) = (0.0, 0.0);
    for_pairs(flattening, covered, |_, a, p, q| {
        energy += a * (p - q).norm_sqr();
        weight += a;
    });
    if weight > 0.0 { (energy / weight).sqrt() } else { 0.0 }
}

/// Calls with two charts, the weight a of a corner that both have, and its places in them.
fn for_pairs(
    flattening: &Flattening,
    covered: &[Covered],
    mut call: impl FnMut([usize; 2], f64, C, C),
) {
    for face in covered {
        for (i, first) in face.charts.iter().enumerate() {
            for second in &face.charts[i + 1..] {
                let charts = [first[0].chart as usize, second[0].chart as usize];
                if charts.iter().any(|&c| flattening.charts[c].is_err()) {
                    continue;
                }
                for (a, b) in first.iter().zip(second) {
                    let weight = face.area / 3.0 * a.weight * b.weight;
                    if weight > 0.0 {
                        let [p, q] = [a, b].map(|c| complex(flattening.uv[c.vertex as usize]));
                        call(charts, weight, p, q);
                    }
                }
            }
        }
    }
}

/// Moves the middle of each chart to the origin, where moments lose the least to rounding.
fn centre(flattening: &mut Flattening, vertex_charts: &[u32]) {
    let mut sums = vec![(Point2::origin(), 0.0); flattening.charts.len()];
    for (place, &chart) in flattening.uv.iter().zip(vertex_charts) {
        if place.x.is_finite() {
            let (sum, count): &mut (Point2<f64>, f64) = &mut sums[chart as usize];
            *sum += place.coords;
            *count += 1.0;
        }
    }
    for (place, &chart) in flattening.uv.iter_mut().zip(vertex_charts) {
        let (sum, count) = sums[chart as usize];
        *place -= sum.coords / count;
    }
}

/// Places charts one by one, always the one that overlaps most with those that have their places.
fn place(neighbours: &[Vec<(usize, Overlap)>]) -> Vec<Motion> {
    let mut motions: Vec<Option<Motion>> = vec![None; neighbours.len()];
    for _ in 0..neighbours.len() {
        // How much of a chart's overlaps is settled, and how much it has at all.
        let weight = |chart: usize, settled: bool| -> f64 {
            let counts = |p: usize| !settled || motions[p].is_some();
            neighbours[chart].iter().filter(|(p, _)| counts(*p)).map(|(_, o)| o.weight).sum()
        };
        let best =
            (0..neighbours.len()).filter(|&chart| motions[chart].is_none()).max_by(|&a, &b| {
                let [a_key, b_key] = [a, b].map(|c| [weight(c, true), weight(c, false)]);
                // The first one of equal charts.
                a_key[0].total_cmp(&b_key[0]).then(a_key[1].total_cmp(&b_key[1])).then(b.cmp(&a))
            });
        let Some(chart) = best else { break };
        let still = Motion { turn: C::new(1.0, 0.0), shift: C::new(0.0, 0.0) };
        motions[chart] = Some(fit(&neighbours[chart], |p| motions[p]).unwrap_or(still));
    }
    motions.into_iter().flatten().collect()
}

/// The best motion of a chart (the second one of its pairs) among neighbours that have theirs; none without any.
fn fit(pairs: &[(usize, Overlap)], motion: impl Fn(usize) -> Option<Motion>) -> Option<Motion> {
    let zero = C::new(0.0, 0.0);
    let (mut weight, mut own, mut other, mut mixed) = (0.0, zero, zero, zero);
    for (p, overlap) in pairs {
        let Some(p) = motion(*p) else { continue };
        weight += overlap.weight;
        own += overlap.second;
        other += p.turn * overlap.first + p.shift * overlap.weight;
        mixed += p.turn * overlap.mixed.conj() + p.shift * overlap.second.conj();
    }
    if weight <= 0.0 {
        return None;
    }
    let turn = mixed - own.conj() * other / weight;
    let size = turn.norm();
    // Overlaps that turn any way equally well do not turn it.
    let turn = if size > 0.0 { turn / size } else { C::new(1.0, 0.0) };
    Some(Motion { turn, shift: (other - turn * own) / weight })
}
