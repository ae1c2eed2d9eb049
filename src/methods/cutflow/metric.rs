//! The H¹ metric on the crossings, in which the flow descends.
//!
//! P = M_lump / ℓ² + L_1D, with Q in place of L_1D at triple points: smooth displacements are cheap, so that a step moves
//! whole stretches of the cut and does not follow the mesh's noise. Only ratios matter; a step's length is set elsewhere.

use std::sync::Arc;

use super::band::CentreResponse;
use super::cut::{Cut, Node};
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};

/// Segments shorter than this (in mean edge lengths) would tie their ends together.
const SHORTEST: f64 = 0.05;

/// P of one cut, factored.
pub(super) struct CurveMetric {
    /// Half the length of the segments at each crossing.
    pub dual_lengths: Vec<f64>,
    pattern: Pattern,
    values: Vec<f64>,
    factor: Factor,
}

impl CurveMetric {
    /// **Takes** the smoothing length ℓ. **Costs** O(crossings).
    pub fn new(cut: &Cut, smoothing: f64, mean_edge: f64) -> Result<Self, LinalgError> {
        let count = cut.crossings.len();
        let mut dual_lengths = vec![0.0; count];
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for segment in &cut.segments {
            for end in segment.ends {
                if let Node::Crossing(c) = end {
                    dual_lengths[c as usize] += 0.5 * segment.length;
                }
            }
            if let [Node::Crossing(a), Node::Crossing(b)] = segment.ends {
                pairs.push([a, b]);
            }
        }
        let responses: Vec<CentreResponse> =
            (0..cut.centres.len()).map(|i| CentreResponse::new(cut, i, mean_edge)).collect();
        for response in &responses {
            let [a, b, c] = response.crossings;
            pairs.extend([[a, b], [b, c], [c, a]]);
        }
        let (pattern, slots) = Pattern::new(count, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        let shortest = SHORTEST * mean_edge;
        for (i, length) in dual_lengths.iter().enumerate() {
            values[pattern.diagonal(i)] += length.max(shortest) / (smoothing * smoothing);
        }
        let mut next_slot = slots.iter();
        let mut add = |values: &mut Vec<f64>, amount: f64| {
            if let Some(&slot) = next_slot.next() {
                values[slot as usize] += amount;
            }
        };
        for segment in &cut.segments {
            if let [Node::Crossing(a), Node::Crossing(b)] = segment.ends {
                let stiffness = 1.0 / segment.length.max(shortest);
                add(&mut values, -stiffness);
                values[pattern.diagonal(a as usize)] += stiffness;
                values[pattern.diagonal(b as usize)] += stiffness;
            }
        }
        for response in &responses {
            for i in 0..3 {
                add(&mut values, response.stiffness[i][(i + 1) % 3]);
                values[pattern.diagonal(response.crossings[i] as usize)] +=
                    response.stiffness[i][i];
            }
        }
        let analysis = Arc::new(Analysis::new(pattern.clone())?);
        let factor = Factor::new(analysis, &values)?;
        Ok(Self { dual_lengths, pattern, values, factor })
    }

    /// P⁻¹ g.
    pub fn raise(&mut self, gradient: &[f64]) -> Vec<f64> {
        let mut z = gradient.to_vec();
        self.factor.solve(&mut z, 1);
        z
    }

    /// P a.
    pub fn lower(&self, a: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; a.len()];
        self.pattern.multiply(&self.values, a, &mut result);
        result
    }

    /// Limits each |g_c| to `factor` times the 90th percentile of |g| / ℓ̃, times ℓ̃_c, ℓ̃ the dual length but at least .3 mean
    /// edges. Harmless on smooth cuts; with slivers and dying patches a few crossings would otherwise use up the step.
    pub fn clip(&self, gradient: &mut [f64], factor: f64, mean_edge: f64) {
        let length = |c: usize| self.dual_lengths[c].max(0.3 * mean_edge);
        let mut densities: Vec<f64> =
            gradient.iter().enumerate().map(|(c, g)| g.abs() / length(c)).collect();
        if densities.is_empty() {
            return;
        }
        let rank = (densities.len() - 1) * 9 / 10;
        let (_, &mut percentile, _) = densities.select_nth_unstable_by(rank, f64::total_cmp);
        for (c, g) in gradient.iter_mut().enumerate() {
            let limit = factor * percentile * length(c);
            *g = g.clamp(-limit, limit);
        }
    }
}
