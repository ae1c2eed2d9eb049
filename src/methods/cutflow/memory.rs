//! Limited-memory BFGS on a set of unknowns that changes from step to step.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use nalgebra::Point3;

use super::band::crossing_place;
use super::cut::Cut;
use super::energy::Problem;
use super::metric::CurveMetric;
use crate::linalg::{add, dot};

/// Pairs kept.
const PAIRS: usize = 8;

/// Old crossings that a new crossing takes its values from.
const NEIGHBOURS: usize = 3;

/// The last steps and changes of gradient, carried from cut to cut.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    pairs: Vec<(Vec<f64>, Vec<f64>)>,
    /// The last accepted displacement and the P-gradient before it, awaiting the next gradient.
    pending: Option<(Vec<f64>, Vec<f64>)>,
    places: Vec<Point3<f64>>,
    labels: Vec<[u32; 2]>,
}

impl Memory {
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Remembers where the unknowns of the vectors are, and the step just taken there.
    pub fn record(&mut self, problem: &Problem, cut: &Cut, step: Vec<f64>, gradient: Vec<f64>) {
        self.places = cut.crossings.iter().map(|c| crossing_place(problem, c)).collect();
        self.labels = cut.crossings.iter().map(|c| c.labels).collect();
        self.pending = Some((step, gradient));
    }

    /// Moves everything to the crossings of `cut`, by inverse distance over the nearest old crossings of the same pair of
    /// labels (0 where there are none), and closes the pending pair with the new P-gradient.
    pub fn transport(&mut self, problem: &Problem, cut: &Cut, metric: &CurveMetric, z: &[f64]) {
        let Some((step, old_gradient)) = self.pending.take() else { return };
        let mut order: Vec<u32> = (0..self.labels.len() as u32).collect();
        order.sort_by_key(|&i| self.labels[i as usize]);
        let weights: Vec<[(u32, f64); NEIGHBOURS]> = cut
            .crossings
            .iter()
            .map(|c| {
                let place = crossing_place(problem, c);
                let begin = order.partition_point(|&i| self.labels[i as usize] < c.labels);
                let end = order.partition_point(|&i| self.labels[i as usize] <= c.labels);
                let mut best = [(u32::MAX, f64::INFINITY); NEIGHBOURS];
                for &i in &order[begin..end] {
                    let distance = (self.places[i as usize] - place).norm();
                    let mut entry = (i, distance);
                    for slot in &mut best {
                        if entry.1 < slot.1 {
                            std::mem::swap(&mut entry, slot);
                        }
                    }
                }
                let weigh = |distance: f64| {
                    if distance.is_finite() { 1.0 / (distance + 1e-12) } else { 0.0 }
                };
                let sum: f64 = best.iter().map(|b| weigh(b.1)).sum();
                best.map(|(i, distance)| (i, if sum > 0.0 { weigh(distance) / sum } else { 0.0 }))
            })
            .collect();
        let carry = |old: &[f64]| -> Vec<f64> {
            weights
                .iter()
                .map(|row| {
                    row.iter()
                        .filter(|(i, _)| *i != u32::MAX)
                        .map(|&(i, w)| w * old[i as usize])
                        .sum()
                })
                .collect()
        };
        for (s, y) in &mut self.pairs {
            *s = carry(s);
            *y = carry(y);
        }
        let s = carry(&step);
        let y: Vec<f64> = carry(&old_gradient).iter().zip(z).map(|(old, new)| new - old).collect();
        let ps = metric.lower(&s);
        let py = metric.lower(&y);
        if dot(&ps, &y) > 1e-3 * (dot(&ps, &s) * dot(&py, &y)).sqrt() {
            if self.pairs.len() == PAIRS {
                self.pairs.remove(0);
            }
            self.pairs.push((s, y));
        }
    }

    /// −H z by the two-loop recursion, all inner products aᵀP b.
    pub fn direction(&self, metric: &CurveMetric, z: &[f64]) -> Vec<f64> {
        let mut d: Vec<f64> = z.iter().map(|z| -z).collect();
        let lowered: Vec<(Vec<f64>, Vec<f64>, f64)> = self
            .pairs
            .iter()
            .map(|(s, y)| {
                let (ps, py) = (metric.lower(s), metric.lower(y));
                let rho = 1.0 / dot(&ps, y);
                (ps, py, rho)
            })
            .collect();
        // Transport may have turned a pair around; such pairs say nothing about curvature any more.
        let usable = |i: usize| lowered[i].2.is_finite() && lowered[i].2 > 0.0;
        let mut alphas = vec![0.0; self.pairs.len()];
        for i in (0..self.pairs.len()).rev().filter(|&i| usable(i)) {
            let (ps, _, rho) = &lowered[i];
            alphas[i] = rho * dot(ps, &d);
            add(&mut d, -alphas[i], &self.pairs[i].1);
        }
        if let Some(i) = (0..self.pairs.len()).rev().find(|&i| usable(i)) {
            let (_, py, rho) = &lowered[i];
            let gamma = 1.0 / (rho * dot(py, &self.pairs[i].1));
            for d in &mut d {
                *d *= gamma;
            }
        }
        for i in (0..self.pairs.len()).filter(|&i| usable(i)) {
            let (_, py, rho) = &lowered[i];
            let beta = rho * dot(py, &d);
            add(&mut d, alphas[i] - beta, &self.pairs[i].0);
        }
        d
    }

    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }
}
