//! Drawing rims: from lengths and exterior angles to corners.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Point2};

use super::super::closing::{MAX_LOG_RATIO, Polygons, Turns};
use super::TargetError;
use crate::linalg::LinalgError;
use crate::mesh::{HalfedgeId, OpenedMesh};

/// Lengths of partners that differ by more, relatively, were not meant to be equal.
const EQUAL: f64 = 1e-10;

/// A rim in the plane.
pub(super) struct Drawn {
    pub corners: Vec<Point2<f64>>,
    /// The largest log ratio by which a length changed.
    pub closing: f64,
    /// The largest angle by which a side turned.
    pub turned: f64,
}

/// Corners of a polygon with exactly these exterior angles, and with the lengths nearest to those given that close it.
/// **Gives** also the largest log ratio by which a length changed.
pub(super) fn draw(
    lengths: &[f64],
    angles: &[f64],
) -> Result<(Vec<Point2<f64>>, f64), TargetError> {
    let mut polygon = Polygons {
        starts: vec![0, lengths.len()],
        side_lengths: (0..lengths.len()).collect(),
        lengths: lengths.to_vec(),
        directions: directions(angles),
    };
    if polygon.close_together(Turns::None, f64::INFINITY)?.is_none() {
        return Err(TargetError::NotFinite);
    }
    Ok((polygon.corners(), largest_change(&polygon.lengths, lengths)))
}

/// The same for scale factors: partners within the rim that are equally long stay so, and directions give way together with lengths, or, if
/// they are to be kept, where lengths alone cannot close it.
pub(super) fn draw_shared(
    opened: &OpenedMesh,
    rim: &[HalfedgeId],
    lengths: &[f64],
    angles: &[f64],
    keeps_angles: bool,
) -> Result<Drawn, LinalgError> {
    let mut position = vec![usize::MAX; opened.mesh.halfedge_count()];
    for (i, h) in rim.iter().enumerate() {
        position[h.index()] = i;
    }
    let mut polygon = Polygons {
        starts: vec![0, lengths.len()],
        side_lengths: vec![usize::MAX; lengths.len()],
        lengths: Vec::new(),
        directions: directions(angles),
    };
    for (i, &h) in rim.iter().enumerate() {
        if polygon.side_lengths[i] != usize::MAX {
            continue;
        }
        polygon.side_lengths[i] = polygon.lengths.len();
        let partner = opened.partner(h).map_or(usize::MAX, |p| position[p.index()]);
        if partner != usize::MAX && (lengths[i] / lengths[partner] - 1.0).abs() < EQUAL {
            polygon.side_lengths[partner] = polygon.lengths.len();
        }
        polygon.lengths.push(lengths[i]);
    }
    let given = polygon.lengths.clone();
    let aimed = polygon.directions.clone();
    // As charts with scaled and isometric rims are closed: lengths alone, then both together; at last each side for itself.
    let closes = keeps_angles && polygon.close_keeping_angles()?.is_some()
        || polygon.close_together(Turns::Free, MAX_LOG_RATIO)?.is_some();
    let closing = if closes {
        largest_change(&polygon.lengths, &given)
    } else {
        polygon.close_apart();
        largest_change(&polygon.lengths, lengths)
    };
    let turns = polygon.directions.iter().zip(&aimed).map(|(a, b)| {
        let turn = a - b;
        (turn - TAU * (turn / TAU).round()).abs()
    });
    let turned = turns.fold(0.0, f64::max);
    Ok(Drawn { corners: polygon.corners(), closing, turned })
}

/// Exterior angles of a circle through sides of these lengths, at the beginning of each side.
pub(super) fn circle_angles(lengths: &[f64]) -> Vec<f64> {
    let total: f64 = lengths.iter().sum();
    let n = lengths.len();
    (0..n).map(|i| TAU * 0.5 * (lengths[(i + n - 1) % n] + lengths[i]) / total).collect()
}

/// Points on a circle, as far apart along it as the lengths say.
pub(super) fn circle(lengths: &[f64]) -> Vec<Point2<f64>> {
    let total: f64 = lengths.iter().sum();
    let radius = total / TAU;
    let mut along = 0.0;
    lengths
        .iter()
        .map(|length| {
            let (sin, cos) = (TAU * along / total).sin_cos();
            along += length;
            Point2::new(radius * cos, radius * sin)
        })
        .collect()
}

/// Angles that were tried and the angles of what they made, for better guesses than the last one (Anderson's mixing): the combination of all
/// that would change least, were the map between them linear. Six plain rounds leave .04 of an angle on face.obj.
#[derive(Default)]
pub(super) struct Mixer {
    tried: Vec<DVector<f64>>,
    made: Vec<DVector<f64>>,
}

impl Mixer {
    /// The next angles to try. Their sum is that of the others.
    pub fn mix(&mut self, tried: Vec<f64>, made: Vec<f64>) -> Vec<f64> {
        self.tried.push(DVector::from_vec(tried));
        self.made.push(DVector::from_vec(made));
        let last = self.made.len() - 1;
        let change = |i: usize| &self.made[i] - &self.tried[i];
        let now = change(last);
        let steps: Vec<DVector<f64>> = (0..last).map(|i| change(i) - &now).collect();
        let size = steps.iter().map(|s| s.norm_squared()).fold(0.0, f64::max);
        let products = DMatrix::from_fn(last, last, |i, j| {
            // A trace on the diagonal keeps steps that are the same apart.
            steps[i].dot(&steps[j]) + if i == j { 1e-14 * size } else { 0.0 }
        });
        let pull = DVector::from_fn(last, |i, _| -steps[i].dot(&now));
        let mut next = self.made[last].clone();
        if let Some(weights) = products.cholesky().map(|c| c.solve(&pull)) {
            for (i, weight) in weights.iter().enumerate() {
                next += (&self.made[i] - &self.made[last]) * *weight;
            }
        }
        // Angles of a circle are positive.
        let is_fine = next.iter().all(|angle| *angle > 0.0);
        if is_fine { next } else { self.made[last].clone() }.iter().copied().collect()
    }
}

/// Directions of sides, the first 0. What the angles miss of a full turn is spread over all.
fn directions(angles: &[f64]) -> Vec<f64> {
    let excess = (angles.iter().sum::<f64>() - TAU) / angles.len() as f64;
    let mut direction = 0.0;
    (0..angles.len())
        .map(|i| {
            if i > 0 {
                // A straight side stays exactly straight where nothing is to be spread.
                direction += angles[i] - if excess.abs() < 1e-12 { 0.0 } else { excess };
            }
            direction
        })
        .collect()
}

fn largest_change(now: &[f64], before: &[f64]) -> f64 {
    now.iter().zip(before).map(|(a, b)| (a / b).ln().abs()).fold(0.0, f64::max)
}
