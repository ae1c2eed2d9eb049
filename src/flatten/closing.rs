//! Closing polygons that share side lengths.
//!
//! BFF prescribes for each chart the lengths of its rim edges and the directions that they have in the plane. Discretised,
//! such a polygon misses its start by a little. Lengths l and directions φ are therefore changed as little as closes all
//! polygons, where both sides of a seam have **one** length:
//!
//! minimise Σ over sides l (σ² + θ²) subject to Σ l e^σ (cos, sin)(φ + θ) = 0 for each polygon,
//!
//! σ being the log of a length ratio (equal for partners) and θ a turn of one side. Why directions may turn: with lengths alone,
//! the two halves of a symmetric surface, which share all their sides, have linearly dependent conditions, and the noise by
//! which they differ is then magnified to length changes of order one. With turns the system's condition number is moderate
//! always, and a polygon without partners closes by the similarity-invariant rule z ← z − l Σz / Σl.

use std::sync::Arc;

use nalgebra::{Point2, Vector2};

use super::turned;
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};

/// Polygons by lengths and directions of their sides.
pub(super) struct Polygons {
    /// Where each polygon's sides begin, and the number of all sides.
    pub starts: Vec<usize>,
    /// For each side which of the lengths it has.
    pub side_lengths: Vec<u32>,
    /// Lengths; one that two sides name is a seam's.
    pub lengths: Vec<f64>,
    /// Direction of each side, radians.
    pub directions: Vec<f64>,
}

/// Newton converges in 2–5 rounds where the polygons nearly close; one that needs more has no solution nearby.
const MAX_ROUNDS: usize = 25;
/// A round changes no log length and no direction by more than this, so that far starts do not overshoot.
const MAX_CHANGE: f64 = 0.5;
/// Log length ratio beyond which a "nearly closed" polygon was not: better closed without its partners.
const MAX_LOG_RATIO: f64 = 1.0;
/// Misclosure left, as a fraction of the perimeter: rounding of a few thousand sides.
const CLOSED: f64 = 1e-14;

impl Polygons {
    /// Closes all polygons, seam lengths shared. **Gives** false, and changes nothing, where no solution is near.
    ///
    /// **Costs** a few factorisations with 2 rows for each polygon.
    pub fn close_together(&mut self) -> Result<bool, LinalgError> {
        if self.starts.len() < 2 {
            return Ok(true);
        }
        let mut system = System::new(self)?;
        let (mut lengths, mut directions) = (self.lengths.clone(), self.directions.clone());
        let mut least = f64::INFINITY;
        for _ in 0..MAX_ROUNDS {
            let sides = self.sides(&lengths, &directions);
            let (gaps, worst) = self.gaps(&sides);
            // Convergence is quadratic until rounding, which long rims may keep above the threshold.
            if worst <= CLOSED || (worst < 1e-11 && worst > 0.5 * least) {
                let ratio = |(new, old): (&f64, &f64)| (new / old).ln().abs();
                if lengths.iter().zip(&self.lengths).map(ratio).fold(0.0, f64::max) > MAX_LOG_RATIO
                {
                    return Ok(false);
                }
                (self.lengths, self.directions) = (lengths, directions);
                return Ok(true);
            }
            least = least.min(worst);
            let Some((stretches, turns)) = system.solve(self, &sides, &lengths, gaps)? else {
                return Ok(false);
            };
            let largest = stretches.iter().chain(&turns).fold(0.0, |m: f64, x| m.max(x.abs()));
            let damping = (MAX_CHANGE / largest).min(1.0);
            for (length, stretch) in lengths.iter_mut().zip(&stretches) {
                *length *= (damping * stretch).exp();
            }
            for (direction, turn) in directions.iter_mut().zip(&turns) {
                *direction += damping * turn;
            }
        }
        Ok(false)
    }

    /// Closes every polygon for itself: z ← z − l Σz / Σl. Never fails, because |Σz| < Σl; partners become unequal.
    pub fn close_apart(&mut self) {
        let mut lengths = Vec::with_capacity(self.directions.len());
        for p in 0..self.starts.len() - 1 {
            let sides = self.starts[p]..self.starts[p + 1];
            let length = |s: usize| self.lengths[self.side_lengths[s] as usize];
            let gap: Vector2<f64> =
                sides.clone().map(|s| direction(self.directions[s]) * length(s)).sum();
            let drift = gap / sides.clone().map(length).sum::<f64>();
            for s in sides {
                let z = (direction(self.directions[s]) - drift) * length(s);
                self.directions[s] = z.y.atan2(z.x);
                lengths.push(z.norm());
            }
        }
        self.side_lengths = (0..lengths.len() as u32).collect();
        self.lengths = lengths;
    }

    /// Where the sides begin, polygon after polygon, each from the origin.
    pub fn corners(&self) -> Vec<Point2<f64>> {
        let mut corners = Vec::with_capacity(self.directions.len());
        for p in 0..self.starts.len() - 1 {
            let mut at = Point2::origin();
            for s in self.starts[p]..self.starts[p + 1] {
                corners.push(at);
                at += direction(self.directions[s]) * self.lengths[self.side_lengths[s] as usize];
            }
        }
        corners
    }

    fn sides(&self, lengths: &[f64], directions: &[f64]) -> Vec<Vector2<f64>> {
        directions
            .iter()
            .zip(&self.side_lengths)
            .map(|(&angle, &l)| direction(angle) * lengths[l as usize])
            .collect()
    }

    /// By how much each polygon misses its start, two numbers each, and the largest miss over its perimeter.
    fn gaps(&self, sides: &[Vector2<f64>]) -> (Vec<f64>, f64) {
        let mut gaps = Vec::with_capacity(2 * self.starts.len());
        let mut worst = 0.0f64;
        for range in self.starts.windows(2) {
            let sides = &sides[range[0]..range[1]];
            let gap: Vector2<f64> = sides.iter().sum();
            worst = worst.max(gap.norm() / sides.iter().map(|z| z.norm()).sum::<f64>());
            gaps.extend([gap.x, gap.y]);
        }
        (gaps, worst)
    }
}

/// One round's linear problem: N (dσ, dθ) = −Jᵀ λ with J N⁻¹ Jᵀ λ = gaps, N = diag(l), 2 l for a shared σ.
struct System {
    side_polygons: Vec<u32>,
    /// The one or two sides that have each length; one alone is named twice.
    owners: Vec<[u32; 2]>,
    analysis: Arc<Analysis>,
    /// Slot of the off-diagonal entry of each polygon's own block.
    own_slots: Vec<u32>,
    /// Slots of the entries xx, xy, yx, yy between the polygons of each length; unused (0) within one polygon.
    mixed_slots: Vec<[u32; 4]>,
    values: Vec<f64>,
    factor: Option<Factor>,
}

impl System {
    fn new(polygons: &Polygons) -> Result<Self, LinalgError> {
        let count = polygons.starts.len() - 1;
        let mut side_polygons = vec![0u32; polygons.side_lengths.len()];
        let mut owners = vec![[u32::MAX; 2]; polygons.lengths.len()];
        for p in 0..count {
            for s in polygons.starts[p]..polygons.starts[p + 1] {
                side_polygons[s] = p as u32;
                let owner = &mut owners[polygons.side_lengths[s] as usize];
                let first = if owner[0] == u32::MAX { s as u32 } else { owner[0] };
                *owner = [first, s as u32];
            }
        }
        let mut pairs: Vec<[u32; 2]> = (0..count as u32).map(|p| [2 * p, 2 * p + 1]).collect();
        for owner in &owners {
            let [p, q] = owner.map(|s| 2 * side_polygons[s as usize]);
            if p != q {
                pairs.extend([[p, q], [p, q + 1], [p + 1, q], [p + 1, q + 1]]);
            }
        }
        let (pattern, slots) = Pattern::new(2 * count, &pairs);
        let mut rest = slots[count..].chunks_exact(4);
        let mixed_slots = owners
            .iter()
            .map(|&[s, t]| match side_polygons[s as usize] == side_polygons[t as usize] {
                true => [0; 4],
                false => rest.next().map_or([0; 4], |c| [c[0], c[1], c[2], c[3]]),
            })
            .collect();
        let values = vec![0.0; pattern.entry_count()];
        let own_slots = slots[..count].to_vec();
        let analysis = Arc::new(Analysis::new(pattern)?);
        Ok(Self { side_polygons, owners, analysis, own_slots, mixed_slots, values, factor: None })
    }

    /// The changes dσ of the lengths and dθ of the directions that close the polygons to first order; none where
    /// the problem is degenerate.
    fn solve(
        &mut self,
        polygons: &Polygons,
        sides: &[Vector2<f64>],
        lengths: &[f64],
        mut gaps: Vec<f64>,
    ) -> Result<Option<(Vec<f64>, Vec<f64>)>, LinalgError> {
        self.assemble(polygons, sides, lengths);
        let solved = match &mut self.factor {
            Some(factor) => factor.refactor(&self.values),
            None => {
                Factor::new(self.analysis.clone(), &self.values).map(|new| self.factor = Some(new))
            }
        };
        match (solved, &mut self.factor) {
            (Ok(()), Some(factor)) => factor.solve(&mut gaps, 1),
            (Err(error @ LinalgError::OutOfMemory { .. }), _) => return Err(error),
            _ => return Ok(None),
        }
        let multiplier = |s: usize| {
            let p = 2 * self.side_polygons[s] as usize;
            Vector2::new(gaps[p], gaps[p + 1])
        };
        let pull = |s: u32| sides[s as usize].dot(&multiplier(s as usize));
        let stretches =
            self.owners.iter().zip(lengths).map(|(&[s, t], l)| -0.5 * (pull(s) + pull(t)) / l);
        let turns = sides.iter().enumerate().map(|(s, &z)| {
            -turned(z).dot(&multiplier(s)) / lengths[polygons.side_lengths[s] as usize]
        });
        Ok(Some((stretches.collect(), turns.collect())))
    }

    /// S = J N⁻¹ Jᵀ.
    fn assemble(&mut self, polygons: &Polygons, sides: &[Vector2<f64>], lengths: &[f64]) {
        let pattern = self.analysis.pattern();
        let (values, own_slots) = (&mut self.values, &self.own_slots);
        values.fill(0.0);
        let mut add_own = |p: u32, z: Vector2<f64>, weight: f64| {
            let p = p as usize;
            values[pattern.diagonal(2 * p)] += weight * z.x * z.x;
            values[own_slots[p] as usize] += weight * z.x * z.y;
            values[pattern.diagonal(2 * p + 1)] += weight * z.y * z.y;
        };
        for (s, &z) in sides.iter().enumerate() {
            let length = lengths[polygons.side_lengths[s] as usize];
            add_own(self.side_polygons[s], turned(z), 1.0 / length);
        }
        for (&[s, t], length) in self.owners.iter().zip(lengths) {
            let [p, q] = [s, t].map(|side| self.side_polygons[side as usize]);
            let [z, w] = [s, t].map(|side| sides[side as usize]);
            if s == t {
                add_own(p, z, 1.0 / length);
            } else if p == q {
                add_own(p, z + w, 0.5 / length);
            } else {
                add_own(p, z, 0.5 / length);
                add_own(q, w, 0.5 / length);
            }
        }
        for ((&[s, t], length), slots) in self.owners.iter().zip(lengths).zip(&self.mixed_slots) {
            if self.side_polygons[s as usize] != self.side_polygons[t as usize] {
                let [z, w] = [s, t].map(|side| sides[side as usize]);
                let products = [z.x * w.x, z.x * w.y, z.y * w.x, z.y * w.y];
                for (product, &slot) in products.iter().zip(slots) {
                    values[slot as usize] += 0.5 / length * product;
                }
            }
        }
    }
}

fn direction(angle: f64) -> Vector2<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector2::new(cos, sin)
}
