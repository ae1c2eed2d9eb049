//! Closing polygons that share side lengths.
//!
//! BFF prescribes for each chart the lengths of its rim edges and the directions that they have in the plane. Discretised,
//! such a polygon misses its start by a little. Lengths l and directions φ are therefore changed as little as closes all
//! polygons, where both sides of a seam have **one** length:
//!
//! minimise Σ over sides l (σ² + θ²) subject to Σ l e^σ (cos, sin)(φ + θ) = 0 for each polygon,
//!
//! σ being the log of a length ratio (equal for partners) and θ a turn of one side. A polygon without partners then closes by
//! the similarity-invariant rule z ← z − l Σz / Σl.
//!
//! Why directions may turn: with lengths alone, the two halves of a symmetric surface, which share all their sides, have linearly
//! dependent conditions, and rounding decides the result. Cut along its plane of symmetry, a cow could not be closed at all
//! with lengths alone, and at the equator of a sphere with 10 000 vertices lengths had to change by 14 %; with turns it is 0.2 %
//! and below 0.01 %, in two rounds.
//!
//! Where cones are prescribed directions must not give way one by one, because they are what the cones' angles are made of. The
//! angles about a point on seams are differences of directions of partners, over the two sides of each corner; they do not change if
//! no direction does ([`Turns::None`]), nor if both partners turn by the same angle, each in its chart ([`Turns::Shared`]; sides
//! without partner keep theirs). The first is a convex problem: with l e^σ for the lengths, the rounds are Newton's method for the dual of
//!
//! minimise Σ l̃ ln(l̃ / l) − l̃ subject to Σ l̃ (cos, sin) φ = 0,
//!
//! and lengths stay positive whatever happens.

use std::sync::Arc;

use nalgebra::{Point2, Vector2};

use super::{small, turned};
use crate::linalg::{Analysis, Factor, LinalgError, Pattern, worse};

/// Which directions may change when polygons are closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turns {
    /// None.
    None,
    /// Those of partners, both by one angle: the angles about points on seams stay.
    Shared,
    /// All, each for itself.
    Free,
}

/// Polygons by lengths and directions of their sides.
pub(super) struct Polygons {
    /// Where each polygon's sides begin, and the number of all sides.
    pub starts: Vec<usize>,
    /// For each side which of the lengths it has.
    pub side_lengths: Vec<usize>,
    /// Lengths; one that two sides name is a seam's.
    pub lengths: Vec<f64>,
    /// Direction of each side, radians.
    pub directions: Vec<f64>,
}

/// Newton converges in 2–5 rounds where the polygons nearly close; one that needs more has no solution nearby.
const MAX_ROUNDS: usize = 25;
/// A round changes no log length and no direction by more than this, so that far starts do not overshoot.
const MAX_CHANGE: f64 = 0.5;
/// How much lengths may change, as a log ratio, before partners turn together instead. Smaller, and directions change that need not;
/// larger, and a few sides become much longer or shorter than their scale factors say.
const MAX_STRETCH: f64 = 0.1;
/// Log length ratio beyond which a "nearly closed" polygon was not: better closed without its partners.
pub(super) const MAX_LOG_RATIO: f64 = 1.0;
/// Misclosure left, as a fraction of the perimeter: rounding of a few thousand sides.
const CLOSED: f64 = 1e-14;

impl Polygons {
    /// Closes all polygons, seam lengths shared. **Gives** the largest change of a log length or a direction, none where no solution
    /// is near and nothing was changed: lengths would change by more than a factor e^`max_log_ratio`.
    ///
    /// **Costs** a few factorisations with 2 rows for each polygon.
    pub fn close_together(
        &mut self,
        turns: Turns,
        max_log_ratio: f64,
    ) -> Result<Option<f64>, LinalgError> {
        if self.starts.len() < 2 {
            return Ok(Some(0.0));
        }
        let mut system = System::new(self, turns)?;
        let (mut lengths, mut directions) = (self.lengths.clone(), self.directions.clone());
        let mut least = f64::INFINITY;
        for _ in 0..MAX_ROUNDS {
            let sides = self.sides(&lengths, &directions);
            let (gaps, worst) = self.gaps(&sides);
            // Convergence is quadratic until rounding, which long rims may keep above the threshold.
            if worst <= CLOSED || (worst < 1e-11 && worst > 0.5 * least) {
                let ratio = |(new, old): (&f64, &f64)| (new / old).ln().abs();
                let stretch = lengths.iter().zip(&self.lengths).map(ratio).fold(0.0, worse);
                if !(stretch <= max_log_ratio) {
                    return Ok(None);
                }
                let turn = |(new, old): (&f64, &f64)| (new - old).abs();
                let turned = directions.iter().zip(&self.directions).map(turn).fold(stretch, worse);
                (self.lengths, self.directions) = (lengths, directions);
                return Ok(Some(turned));
            }
            least = least.min(worst);
            let Some(changes) = system.solve(self, &sides, &lengths, gaps)? else {
                return Ok(None);
            };
            let all = changes.stretches.iter().chain(&changes.turns);
            let damping = (MAX_CHANGE / all.fold(0.0, |m: f64, x| m.max(x.abs()))).min(1.0);
            for (length, stretch) in lengths.iter_mut().zip(&changes.stretches) {
                *length *= (damping * stretch).exp();
            }
            for (direction, turn) in directions.iter_mut().zip(&changes.turns) {
                *direction += damping * turn;
            }
        }
        Ok(None)
    }

    /// The same with the angles about points on seams kept: by lengths alone where that changes them little, else by turns of partners, at
    /// last by lengths that change much.
    pub fn close_keeping_angles(&mut self) -> Result<Option<f64>, LinalgError> {
        for (turns, most) in [
            (Turns::None, MAX_STRETCH),
            (Turns::Shared, MAX_LOG_RATIO),
            (Turns::None, MAX_LOG_RATIO),
        ] {
            let closing = self.close_together(turns, most)?;
            if closing.is_some() {
                return Ok(closing);
            }
        }
        Ok(None)
    }

    /// Closes every polygon for itself: z ← z − l Σz / Σl. Never fails, because |Σz| < Σl; partners become unequal.
    pub fn close_apart(&mut self) {
        let mut lengths = Vec::with_capacity(self.directions.len());
        for p in 0..self.starts.len() - 1 {
            let sides = self.starts[p]..self.starts[p + 1];
            let length = |s: usize| self.lengths[self.side_lengths[s]];
            let gap: Vector2<f64> =
                sides.clone().map(|s| direction(self.directions[s]) * length(s)).sum();
            let drift = gap / sides.clone().map(length).sum::<f64>();
            for s in sides {
                let z = (direction(self.directions[s]) - drift) * length(s);
                self.directions[s] = z.y.atan2(z.x);
                lengths.push(z.norm());
            }
        }
        self.side_lengths = (0..lengths.len()).collect();
        self.lengths = lengths;
    }

    /// Where the sides begin, polygon after polygon, each from the origin.
    pub fn corners(&self) -> Vec<Point2<f64>> {
        let mut corners = Vec::with_capacity(self.directions.len());
        for p in 0..self.starts.len() - 1 {
            let mut at = Point2::origin();
            for s in self.starts[p]..self.starts[p + 1] {
                corners.push(at);
                at += direction(self.directions[s]) * self.lengths[self.side_lengths[s]];
            }
        }
        corners
    }

    fn sides(&self, lengths: &[f64], directions: &[f64]) -> Vec<Vector2<f64>> {
        directions
            .iter()
            .zip(&self.side_lengths)
            .map(|(&angle, &l)| direction(angle) * lengths[l])
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

/// What one round changes.
struct Changes {
    /// dσ of each length.
    stretches: Vec<f64>,
    /// dθ of each direction.
    turns: Vec<f64>,
}

/// One round's linear problem: N (dσ, dθ) = −Jᵀ λ with J N⁻¹ Jᵀ λ = gaps, N = diag(l), 2 l for a shared σ.
struct System {
    side_polygons: Vec<usize>,
    /// The one or two sides that have each length; one alone is named twice.
    owners: Vec<[usize; 2]>,
    analysis: Arc<Analysis>,
    /// Slot of the off-diagonal entry of each polygon's own block.
    own_slots: Vec<u32>,
    /// Slots of the entries xx, xy, yx, yy between the polygons of each length; unused (0) within one polygon.
    mixed_slots: Vec<[u32; 4]>,
    values: Vec<f64>,
    factor: Option<Factor>,
    turns: Turns,
}

impl System {
    fn new(polygons: &Polygons, turns: Turns) -> Result<Self, LinalgError> {
        let count = polygons.starts.len() - 1;
        let mut side_polygons = vec![0; polygons.side_lengths.len()];
        let mut owners = vec![[usize::MAX; 2]; polygons.lengths.len()];
        for p in 0..count {
            for s in polygons.starts[p]..polygons.starts[p + 1] {
                side_polygons[s] = p;
                let owner = &mut owners[polygons.side_lengths[s]];
                let first = if owner[0] == usize::MAX { s } else { owner[0] };
                *owner = [first, s];
            }
        }
        let mut pairs: Vec<[u32; 2]> = (0..small(count)).map(|p| [2 * p, 2 * p + 1]).collect();
        for owner in &owners {
            let [p, q] = owner.map(|s| 2 * small(side_polygons[s]));
            if p != q {
                pairs.extend([[p, q], [p, q + 1], [p + 1, q], [p + 1, q + 1]]);
            }
        }
        let (pattern, slots) = Pattern::new(2 * count, &pairs);
        let mut rest = slots[count..].chunks_exact(4);
        let mixed_slots = owners
            .iter()
            .map(|&[s, t]| match side_polygons[s] == side_polygons[t] {
                true => [0; 4],
                false => rest.next().map_or([0; 4], |c| [c[0], c[1], c[2], c[3]]),
            })
            .collect();
        let values = vec![0.0; pattern.entry_count()];
        let own_slots = slots[..count].to_vec();
        let analysis = Arc::new(Analysis::new(pattern)?);
        let factor = None;
        Ok(Self { side_polygons, owners, analysis, own_slots, mixed_slots, values, factor, turns })
    }

    /// The changes that close the polygons to first order; none where the problem is degenerate.
    fn solve(
        &mut self,
        polygons: &Polygons,
        sides: &[Vector2<f64>],
        lengths: &[f64],
        mut gaps: Vec<f64>,
    ) -> Result<Option<Changes>, LinalgError> {
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
            let p = 2 * self.side_polygons[s];
            Vector2::new(gaps[p], gaps[p + 1])
        };
        let pull = |s: usize| sides[s].dot(&multiplier(s));
        let stretches =
            self.owners.iter().zip(lengths).map(|(&[s, t], l)| -0.5 * (pull(s) + pull(t)) / l);
        let torque = |s: usize| turned(sides[s]).dot(&multiplier(s));
        let turn = |s: usize| {
            let l = polygons.side_lengths[s];
            match self.turns {
                Turns::None => 0.0,
                Turns::Free => -torque(s) / lengths[l],
                Turns::Shared => match self.owners[l] {
                    [first, last] if first == last => 0.0,
                    [first, last] => -0.5 * (torque(first) + torque(last)) / lengths[l],
                },
            }
        };
        let turns = (0..sides.len()).map(turn).collect();
        Ok(Some(Changes { stretches: stretches.collect(), turns }))
    }

    /// S = J N⁻¹ Jᵀ.
    fn assemble(&mut self, polygons: &Polygons, sides: &[Vector2<f64>], lengths: &[f64]) {
        let pattern = self.analysis.pattern();
        let (values, own_slots) = (&mut self.values, &self.own_slots);
        values.fill(0.0);
        let mut add_own = |p: usize, z: Vector2<f64>, weight: f64| {
            values[pattern.diagonal(2 * p)] += weight * z.x * z.x;
            values[own_slots[p] as usize] += weight * z.x * z.y;
            values[pattern.diagonal(2 * p + 1)] += weight * z.y * z.y;
        };
        if self.turns == Turns::Free {
            for (s, &z) in sides.iter().enumerate() {
                let length = lengths[polygons.side_lengths[s]];
                add_own(self.side_polygons[s], turned(z), 1.0 / length);
            }
        }
        let shares_turns = self.turns == Turns::Shared;
        for (&[s, t], length) in self.owners.iter().zip(lengths) {
            let [p, q] = [s, t].map(|side| self.side_polygons[side]);
            let [z, w] = [s, t].map(|side| sides[side]);
            if s == t {
                add_own(p, z, 1.0 / length);
            } else if p == q {
                add_own(p, z + w, 0.5 / length);
                if shares_turns {
                    add_own(p, turned(z + w), 0.5 / length);
                }
            } else {
                add_own(p, z, 0.5 / length);
                add_own(q, w, 0.5 / length);
                if shares_turns {
                    add_own(p, turned(z), 0.5 / length);
                    add_own(q, turned(w), 0.5 / length);
                }
            }
        }
        for ((&[s, t], length), slots) in self.owners.iter().zip(lengths).zip(&self.mixed_slots) {
            if self.side_polygons[s] == self.side_polygons[t] {
                continue;
            }
            let [z, w] = [s, t].map(|side| sides[side]);
            let mut add = |z: Vector2<f64>, w: Vector2<f64>| {
                let products = [z.x * w.x, z.x * w.y, z.y * w.x, z.y * w.y];
                for (product, &slot) in products.iter().zip(slots) {
                    values[slot as usize] += 0.5 / length * product;
                }
            };
            add(z, w);
            if shares_turns {
                add(turned(z), turned(w));
            }
        }
    }
}

fn direction(angle: f64) -> Vector2<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector2::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// Two n-gons, the second one a mirror image of the first with all sides shared; directions off by `noise`.
    fn mirrored(n: usize, noise: f64) -> Polygons {
        let angle = |i: usize| TAU * i as f64 / n as f64;
        let wobble = |i: usize| noise * (3.7 * i as f64).sin();
        let directions =
            (0..n).map(|i| angle(i) + wobble(i)).chain((0..n).map(|i| angle(i) + wobble(i + n)));
        Polygons {
            starts: vec![0, n, 2 * n],
            side_lengths: (0..n).chain((0..n).rev()).collect(),
            lengths: (0..n).map(|i| 1.0 + 0.3 * (2.0 * angle(i)).cos()).collect(),
            directions: directions.collect(),
        }
    }

    #[test]
    fn mirror_images_that_share_all_sides_close_with_small_changes() {
        for noise in [0.0, 1e-9, 1e-3, 0.1] {
            let mut polygons = mirrored(60, noise);
            let (before, aimed) = (polygons.lengths.clone(), polygons.directions.clone());
            let told = polygons.close_together(Turns::Free, MAX_LOG_RATIO).unwrap().unwrap();
            let stretches = polygons.lengths.iter().zip(&before).map(|(a, b)| (a / b).ln().abs());
            let turns = polygons.directions.iter().zip(&aimed).map(|(a, b)| (a - b).abs());
            let most = stretches.chain(turns).fold(0.0, f64::max);
            assert!((told - most).abs() < 1e-15, "{told} {most}");
            let sides = polygons.sides(&polygons.lengths, &polygons.directions);
            assert!(polygons.gaps(&sides).1 < 1e-13);
            for (new, old) in polygons.lengths.iter().zip(&before) {
                // As large as the noise, whatever the noise.
                assert!((new / old).ln().abs() <= noise + 1e-13, "{noise}");
            }
        }
    }

    #[test]
    fn changes_are_the_least_that_close_a_lone_polygon() {
        // Without partners the minimiser of the linearised problem is z (1 − (gap / perimeter) / direction).
        let mut polygons = mirrored(40, 1e-5);
        polygons.starts.pop();
        polygons.side_lengths.truncate(40);
        polygons.directions.truncate(40);
        let mut apart = Polygons {
            starts: polygons.starts.clone(),
            side_lengths: polygons.side_lengths.clone(),
            lengths: polygons.lengths.clone(),
            directions: polygons.directions.clone(),
        };
        assert!(polygons.close_together(Turns::Free, MAX_LOG_RATIO).unwrap().is_some());
        apart.close_apart();
        for (p, q) in polygons.corners().iter().zip(apart.corners()) {
            // They differ by the square of the noise.
            assert!((p - q).norm() < 1e-9);
        }
    }

    #[test]
    fn hopeless_polygons_are_left_alone_and_still_close_apart() {
        // One turns by half a turn only: its sides share no length with a closed polygon nearby.
        let mut polygons = mirrored(60, 0.0);
        for (i, direction) in polygons.directions[60..].iter_mut().enumerate() {
            *direction = 0.01 * PI * i as f64 / 60.0;
        }
        let (lengths, directions) = (polygons.lengths.clone(), polygons.directions.clone());
        assert!(polygons.close_together(Turns::Free, MAX_LOG_RATIO).unwrap().is_none());
        assert_eq!((&polygons.lengths, &polygons.directions), (&lengths, &directions));
        polygons.close_apart();
        let sides = polygons.sides(&polygons.lengths, &polygons.directions);
        assert!(polygons.gaps(&sides).1 < 1e-12);
        assert!(polygons.lengths.iter().all(|&l| l > 0.0));
    }

    /// A polygon whose sides s and n − 1 − s are partners, turned against each other by different angles, with four sides of its own.
    fn folded(n: usize, miss: f64) -> Polygons {
        let side = |s: usize| if s < n { s } else { 2 * n - 1 - s };
        let mut directions: Vec<f64> = (0..2 * n)
            .map(|s| {
                let x = side(s) as f64 / n as f64;
                let along = 0.7 * (5.0 * x).sin();
                if s < n { along } else { PI + along + 1.2 + 1.5 * x }
            })
            .collect();
        directions.extend([1.0, 2.0, 2.6, 3.2].map(|angle: f64| angle + miss));
        Polygons {
            starts: vec![0, 2 * n + 4],
            side_lengths: (0..2 * n).map(side).chain(n..n + 4).collect(),
            lengths: (0..n)
                .map(|i| 1.0 / n as f64 * (1.0 + 0.3 * (i as f64).cos()))
                .chain([0.5; 4])
                .collect(),
            directions,
        }
    }

    #[test]
    fn lengths_alone_close_a_folded_rim_and_are_nearest_by_relative_entropy() {
        let mut polygons = folded(30, 0.0);
        let before = polygons.lengths.clone();
        let directions = polygons.directions.clone();
        assert!(polygons.close_together(Turns::None, 3.0).unwrap().is_some());
        assert_eq!(polygons.directions, directions);
        let sides = polygons.sides(&polygons.lengths, &polygons.directions);
        assert!(polygons.gaps(&sides).1 < 1e-13);
        // Stationary: each log ratio, times the number of its sides, is one linear function of the sum of its directions.
        let rows: Vec<(Vector2<f64>, f64)> = (0..polygons.lengths.len())
            .map(|l| {
                let sides: Vec<usize> =
                    (0..directions.len()).filter(|&s| polygons.side_lengths[s] == l).collect();
                let sum = sides.iter().map(|&s| direction(directions[s])).sum();
                (sum, (polygons.lengths[l] / before[l]).ln() * sides.len() as f64)
            })
            .collect();
        let normal: nalgebra::Matrix2<f64> = rows.iter().map(|(t, _)| t * t.transpose()).sum();
        let multiplier =
            normal.try_inverse().unwrap() * rows.iter().map(|(t, r)| t * *r).sum::<Vector2<f64>>();
        for (t, ratio) in rows {
            assert!((t.dot(&multiplier) - ratio).abs() < 1e-12);
        }
    }

    #[test]
    fn partners_that_turn_together_keep_the_angles_between_them() {
        // Mirror images: dependent for lengths alone.
        let mut polygons = mirrored(60, 1e-3);
        let before = polygons.directions.clone();
        assert!(polygons.close_together(Turns::Shared, MAX_LOG_RATIO).unwrap().is_some());
        let sides = polygons.sides(&polygons.lengths, &polygons.directions);
        assert!(polygons.gaps(&sides).1 < 1e-13);
        for s in 0..60 {
            let turn = |s: usize| polygons.directions[s] - before[s];
            // Directions up to 2π, rounded in each of a few rounds.
            assert!((turn(s) - turn(119 - s)).abs() < 1e-14);
        }
        // Sides without partner keep their directions.
        let mut polygons = folded(30, 0.2);
        let before = polygons.directions.clone();
        assert!(polygons.close_together(Turns::Shared, 3.0).unwrap().is_some());
        assert_eq!(polygons.directions[60..], before[60..]);
        let turn = |s: usize| polygons.directions[s] - before[s];
        assert!((0..60).all(|s| (turn(s) - turn(59 - s)).abs() < 1e-14));
        assert!((0..60).any(|s| turn(s).abs() > 1e-3), "they had to turn");
    }
}
