//! Grids of triangles and rings of points, which the parametric samples are put together from.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::Vector3;

/// Points on a closed curve over 0..2π, about `step` apart along it and all equally far; the first one `shift`
/// of a step from the start.
pub(super) fn evenly_spaced(
    curve: impl Fn(f64) -> Vector3<f64>,
    step: f64,
    shift: f64,
) -> Vec<Vector3<f64>> {
    const PIECES: u32 = 720;
    let turn = |i: u32| TAU * f64::from(i) / f64::from(PIECES);
    let mut lengths = vec![0.0];
    let mut length = 0.0;
    for i in 0..PIECES {
        length += (curve(turn(i + 1)) - curve(turn(i))).norm();
        lengths.push(length);
    }
    let count = whole(length / step).max(5);
    let at = |k: u32| {
        let s = length * (f64::from(k) + shift) / f64::from(count);
        let i = lengths.partition_point(|&l| l < s).clamp(1, lengths.len() - 1);
        let t = (s - lengths[i - 1]) / (lengths[i] - lengths[i - 1]);
        curve(TAU * ((i - 1) as f64 + t) / f64::from(PIECES))
    };
    (0..count).map(at).collect()
}

/// Fills the band between two closed rings of vertices that run the same way, seen from outside with `above` to
/// the left of the way: always along the shorter of the two diagonals. A ring may be one vertex.
pub(super) fn join_rings(
    positions: &[[f64; 3]],
    below: std::ops::Range<usize>,
    above: std::ops::Range<usize>,
    triangles: &mut Vec<[u32; 3]>,
) {
    let distance = |a: usize, b: usize| {
        (Vector3::from(positions[a]) - Vector3::from(positions[b])).norm_squared()
    };
    let nearest = above
        .clone()
        .min_by(|&a, &b| distance(below.start, a).total_cmp(&distance(below.start, b)));
    let start = nearest.unwrap_or(above.start) - above.start;
    let low = |i: usize| below.start + i % below.len();
    let high = |j: usize| above.start + (start + j) % above.len();
    // A single vertex has no edges to walk along.
    let steps_below = if below.len() > 1 { below.len() } else { 0 };
    let (mut i, mut j) = (0, 0);
    while i < steps_below || j < above.len() {
        let goes_below = j == above.len()
            || i < steps_below && distance(low(i + 1), high(j)) < distance(low(i), high(j + 1));
        if goes_below {
            triangles.push([low(i), low(i + 1), high(j)].map(to_u32));
            i += 1;
        } else {
            triangles.push([low(i), high(j + 1), high(j)].map(to_u32));
            j += 1;
        }
    }
}

/// The triangles of a triangle whose sides are divided into `n`; `at` gives the vertex for the shares of the three
/// corners, which add up to `n`.
pub(super) fn triangular_grid(n: u32, mut at: impl FnMut([u32; 3]) -> u32) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for k in 0..n {
        for j in 0..n - k {
            let i = n - k - j;
            let (here, right, above) =
                (at([i, j, k]), at([i - 1, j + 1, k]), at([i - 1, j, k + 1]));
            triangles.push([here, right, above]);
            if i > 1 {
                triangles.push([right, at([i - 2, j + 1, k + 1]), above]);
            }
        }
    }
    triangles
}

/// The triangles of `bands` bands between closed rings of `around` vertices, every second ring moved ahead by half a
/// step; `at` gives the vertex for ring and column.
pub(super) fn staggered_rings(
    around: u32,
    bands: u32,
    at: impl Fn(u32, u32) -> u32,
) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for ring in 0..bands {
        for column in 0..around {
            let (here, right) = (at(ring, column), at(ring, column + 1));
            let (above, above_right) = (at(ring + 1, column), at(ring + 1, column + 1));
            // The vertex of the same column stands half a step ahead above an even ring, behind above an odd one.
            if ring % 2 == 0 {
                triangles.extend([[here, right, above], [right, above_right, above]]);
            } else {
                triangles.extend([[here, right, above_right], [here, above_right, above]]);
            }
        }
    }
    triangles
}

/// The triangles of a rectangle of `columns` × `rows` cells, halved along diagonals that change their direction
/// from cell to cell, so that none is preferred.
pub(super) fn square_grid(
    columns: i32,
    rows: i32,
    mut at: impl FnMut(i32, i32) -> u32,
) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if (i + j) % 2 == 0 {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    triangles
}

/// Vertices that are made once for each key.
pub(super) struct Vertices<Key> {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) known: BTreeMap<Key, u32>,
}

impl<Key> Default for Vertices<Key> {
    fn default() -> Self {
        Self { positions: Vec::new(), known: BTreeMap::new() }
    }
}

impl<Key: Ord> Vertices<Key> {
    pub(super) fn at(&mut self, key: Key, position: impl FnOnce() -> Vector3<f64>) -> u32 {
        *self.known.entry(key).or_insert_with(|| {
            self.positions.push(position().into());
            to_u32(self.positions.len() - 1)
        })
    }
}

/// A length in steps, rounded.
#[allow(clippy::cast_possible_truncation, reason = "a few thousand at most; saturates")]
pub(super) fn whole(x: f64) -> u32 {
    x.round() as u32
}

/// A vertex number of a sample, far below 2³².
pub(super) fn to_u32(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}
