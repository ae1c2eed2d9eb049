//! The price of a phase in several parts.
//!
//! C = 2 Σ_{p<q} d_pq W_p W_q over the connected parts of {u > e₁}, e₁ = 1 − √ε: W is a part's area, weighed by H(u), and d the length of the
//! shortest path between two parts where a face costs F(u) = (u − e₁)² below e₁. The gradient widens those paths.
//! **From** [PF] §3. **Differs**: H is a smooth step that is 0 where a part is born, so that C is continuous; parts are
//! contracted and one Dijkstra tree for each serves all its pairs, by sums over subtrees.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use super::super::domain::{Domain, NONE};
use super::super::profile::smoothstep;

/// Parts that are looked at in one evaluation, largest first: the others wait until these have grown together. Keeps an
/// evaluation bounded when noise has hundreds.
const MOST_PARTS: usize = 64;

/// Layers of faces that may come to a phase between two fields, or nearly so, before its connection is proved anew.
const ROUNDS: usize = 8;

/// Above this, values are dear again: nothing is gained by u ≫ 1.
const TOP: f64 = 1.5;

/// Where a part begins.
pub(in super::super) fn edge(epsilon: f64) -> f64 {
    1.0 - epsilon.sqrt()
}

/// A face's price and its derivative.
fn price(u: f64, e1: f64) -> (f64, f64) {
    let d = if u < e1 {
        u - e1
    } else if u > TOP {
        u - TOP
    } else {
        0.0
    };
    (d * d, 2.0 * d)
}

/// Parts of {u > e₁} and of {u < −e₁}: for each face its part among those of its phase, or [`NONE`], and their numbers.
pub(in super::super) struct Parts {
    of: Vec<u32>,
    pub counts: [usize; 2],
}

impl Parts {
    /// Finds them. **Costs** one pass over the faces.
    pub fn new(domain: &Domain, u: &[f64], e1: f64) -> Self {
        let mut of = vec![NONE; u.len()];
        let mut stack = Vec::new();
        let mut counts = [0u32; 2];
        for start in 0..u.len() {
            if of[start] != NONE || !(u[start].abs() > e1) {
                continue;
            }
            let sign = u[start].signum();
            let count = &mut counts[usize::from(sign < 0.0)];
            of[start] = *count;
            stack.push(start);
            while let Some(f) = stack.pop() {
                for g in domain.neighbours[f] {
                    if g != NONE && of[g as usize] == NONE && sign * u[g as usize] > e1 {
                        of[g as usize] = *count;
                        stack.push(g as usize);
                    }
                }
            }
            *count += 1;
        }
        Self { of, counts: counts.map(|c| c as usize) }
    }
}

/// A proof that either phase is in one part, carried from field to field: every face of a phase but its first has a neighbour in it that
/// came before. Few faces change sides between two fields; only those are looked at.
#[derive(Clone, Default)]
pub(in super::super) struct Proof {
    /// 1 above e₁, −1 below −e₁, else 0.
    sides: Vec<i8>,
    /// The neighbour that came before; [`NONE`] for a first face and outside of the phases.
    parents: Vec<u32>,
    /// When a face came.
    times: Vec<u32>,
    now: u32,
    firsts: [u32; 2],
}

impl Proof {
    /// Whether the phases of a field, given by means over faces, are still proved to be in one part each. Where not, they may be all the same.
    /// **Costs** some passes over the faces.
    pub fn holds(&mut self, mean: impl Fn(usize) -> f64, e1: f64, domain: &Domain) -> bool {
        let holds = self.sides.len() == domain.areas.len() && self.carry(mean, e1, domain);
        if !holds {
            self.sides.clear();
        }
        holds
    }

    fn carry(&mut self, mean: impl Fn(usize) -> f64, e1: f64, domain: &Domain) -> bool {
        for (f, old) in self.sides.iter_mut().enumerate() {
            let side = side_of(mean(f), e1);
            if side != *old {
                *old = side;
                self.parents[f] = NONE;
                self.times[f] = NONE;
            }
        }
        // Those whose neighbour has left, and those that came.
        let mut loose = Vec::new();
        for (f, &side) in self.sides.iter().enumerate() {
            let parent = self.parents[f];
            let hangs_on = parent != NONE && self.sides[parent as usize] == side;
            if side != 0 && !hangs_on && !self.firsts.contains(&(f as u32)) {
                self.parents[f] = NONE;
                loose.push(f);
            }
        }
        let is_first_there = self.firsts.iter().zip([1, -1]).all(|(&f, side)| {
            if f == NONE { !self.sides.contains(&side) } else { self.sides[f as usize] == side }
        });
        // More rounds than that are no small change.
        for _ in 0..ROUNDS {
            if is_first_there && !loose.is_empty() {
                loose.retain(|&f| !self.hang_on(f, domain));
            }
        }
        is_first_there && loose.is_empty()
    }

    /// Finds a neighbour that came before, for a face that has just come any.
    fn hang_on(&mut self, f: usize, domain: &Domain) -> bool {
        let hangs = |g: u32| self.parents[g as usize] != NONE || self.firsts.contains(&g);
        let is_before = |g: u32| self.times[f] == NONE || self.times[g as usize] < self.times[f];
        let found = domain.neighbours[f].into_iter().filter(|&g| {
            g != NONE && self.sides[g as usize] == self.sides[f] && hangs(g) && is_before(g)
        });
        // The first to come is furthest inside, and the last to leave.
        let Some(parent) = found.min_by_key(|&g| self.times[g as usize]) else { return false };
        self.parents[f] = parent;
        if self.times[f] == NONE {
            self.times[f] = self.now;
            self.now += 1;
        }
        true
    }

    /// Begins anew from phases in at most one part each.
    pub fn renew(&mut self, u: &[f64], e1: f64, domain: &Domain) {
        self.sides = u.iter().map(|&u| side_of(u, e1)).collect();
        self.parents = vec![NONE; u.len()];
        self.times = vec![NONE; u.len()];
        self.now = 0;
        for (side, first) in [(1i8, 0), (-1, 1)] {
            // Far inside: it stays.
            let best = (0..u.len())
                .filter(|&f| self.sides[f] == side)
                .max_by(|&f, &g| u[f].abs().total_cmp(&u[g].abs()));
            self.firsts[first] = best.map_or(NONE, |f| f as u32);
            let mut queue: VecDeque<usize> = best.into_iter().collect();
            for &f in &queue {
                self.times[f] = self.now;
                self.now += 1;
            }
            while let Some(f) = queue.pop_front() {
                for g in domain.neighbours[f].into_iter().filter(|&g| g != NONE) {
                    let g = g as usize;
                    if self.sides[g] == side && self.times[g] == NONE {
                        self.times[g] = self.now;
                        self.now += 1;
                        self.parents[g] = f as u32;
                        queue.push_back(g);
                    }
                }
            }
        }
    }
}

fn side_of(u: f64, e1: f64) -> i8 {
    i8::from(u > e1) - i8::from(u < -e1)
}

/// Shortest paths over faces from one part, in reused memory.
struct Paths {
    distances: Vec<f64>,
    parents: Vec<u32>,
    is_done: Vec<bool>,
    order: Vec<u32>,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
}

/// C of one phase; adds its gradient, times `factor`, by the values and the weights of faces.
///
/// **Takes** the field and the weights in (0, 1] at faces, the field's parts, and the sign of the phase. **Costs** nothing where there is one part, else a
/// Dijkstra tree for each part but the last.
pub(in super::super) fn add(
    domain: &Domain,
    [field, w]: [&[f64]; 2],
    parts: &Parts,
    sign: f64,
    epsilon: f64,
    factor: f64,
    [by_value, by_weight]: [&mut [f64]; 2],
) -> f64 {
    let count = parts.counts[usize::from(sign < 0.0)];
    if count < 2 {
        return 0.0;
    }
    let e1 = edge(epsilon);
    let u: Vec<f64> = field.iter().map(|u| sign * u).collect();
    let part: Vec<u32> =
        parts.of.iter().zip(&u).map(|(&p, &u)| if u > e1 { p } else { NONE }).collect();
    let span = (1.0 - e1) / 2.0;
    let height = |f: usize| {
        let (h, slope) = smoothstep((u[f] - e1) / span);
        (h, slope / span)
    };
    let mut sizes = vec![0.0; count];
    for f in 0..u.len() {
        if part[f] != NONE {
            sizes[part[f] as usize] += domain.areas[f] * w[f] * height(f).0;
        }
    }
    let mut chosen: Vec<u32> = (0..count as u32).collect();
    chosen.sort_by(|&p, &q| sizes[q as usize].total_cmp(&sizes[p as usize]).then(p.cmp(&q)));
    chosen.truncate(MOST_PARTS);
    let mut rank = vec![NONE; count];
    for (i, &p) in chosen.iter().enumerate() {
        rank[p as usize] = i as u32;
    }
    // The rims of the chosen parts: a front leaves through them only.
    let mut rims: Vec<Vec<u32>> = vec![Vec::new(); chosen.len()];
    for f in 0..u.len() {
        if part[f] == NONE || rank[part[f] as usize] == NONE {
            continue;
        }
        if domain.neighbours[f].iter().any(|&g| g != NONE && part[g as usize] != part[f]) {
            rims[rank[part[f] as usize] as usize].push(f as u32);
        }
    }

    let cost: Vec<f64> = (0..u.len()).map(|f| price(u[f], e1).0 / (w[f] + 1e-6)).collect();
    let length = |f: usize, g: usize| {
        0.25 * (domain.diameters[f] + domain.diameters[g]) * (cost[f] + cost[g])
    };
    let faces = u.len();
    let mut paths = Paths {
        distances: vec![f64::INFINITY; faces],
        parents: vec![NONE; faces],
        is_done: vec![false; faces],
        order: Vec::new(),
        queue: BinaryHeap::new(),
    };
    let mut load = vec![0.0; faces];
    let mut by_size = vec![0.0; count];
    // Derivative by the cost of each face.
    let mut by_cost = vec![0.0; faces];
    let mut total = 0.0;
    for (i, &p) in chosen.iter().enumerate().take(chosen.len() - 1) {
        let size = sizes[p as usize];
        if !(size > 0.0) {
            break;
        }
        // The first face of every part further down, at its distance.
        let mut reached = vec![false; chosen.len()];
        let wanted = chosen.len() - 1 - i;
        let mut found = 0;
        for &f in &rims[i] {
            paths.distances[f as usize] = 0.0;
            paths.queue.push(Reverse((0, f)));
        }
        while let Some(Reverse((_, f))) = paths.queue.pop() {
            let f = f as usize;
            if paths.is_done[f] {
                continue;
            }
            paths.is_done[f] = true;
            paths.order.push(f as u32);
            if part[f] != NONE {
                let q = rank[part[f] as usize];
                if q != NONE && q as usize > i && !reached[q as usize] {
                    reached[q as usize] = true;
                    found += 1;
                    let d = paths.distances[f];
                    let other = sizes[part[f] as usize];
                    load[f] = other;
                    total += 2.0 * d * size * other;
                    by_size[p as usize] += 2.0 * d * other;
                    by_size[part[f] as usize] += 2.0 * d * size;
                    if found == wanted {
                        break;
                    }
                }
            }
            for g in domain.neighbours[f] {
                if g == NONE || paths.is_done[g as usize] {
                    continue;
                }
                let distance = paths.distances[f] + length(f, g as usize);
                if distance < paths.distances[g as usize] {
                    paths.distances[g as usize] = distance;
                    paths.parents[g as usize] = f as u32;
                    // Distances are finite and not negative: their bits sort like their values.
                    paths.queue.push(Reverse((distance.to_bits(), g)));
                }
            }
        }
        for &f in paths.order.iter().rev() {
            let f = f as usize;
            let (parent, carried) = (paths.parents[f], load[f]);
            if carried > 0.0 && parent != NONE {
                let g = parent as usize;
                load[g] += carried;
                let slope =
                    2.0 * size * carried * 0.25 * (domain.diameters[f] + domain.diameters[g]);
                by_cost[f] += slope;
                by_cost[g] += slope;
            }
            load[f] = 0.0;
        }
        paths.clear();
    }
    for f in 0..faces {
        let (value, slope) = price(u[f], e1);
        let weight = w[f] + 1e-6;
        by_value[f] += sign * factor * by_cost[f] * slope / weight;
        by_weight[f] -= factor * by_cost[f] * value / (weight * weight);
        if part[f] != NONE {
            let change = factor * by_size[part[f] as usize] * domain.areas[f];
            let (h, h_slope) = height(f);
            by_value[f] += sign * change * w[f] * h_slope;
            by_weight[f] += change * h;
        }
    }
    total
}

impl Paths {
    fn clear(&mut self) {
        self.distances.fill(f64::INFINITY);
        self.parents.fill(NONE);
        self.is_done.fill(false);
        self.order.clear();
        self.queue.clear();
    }
}
