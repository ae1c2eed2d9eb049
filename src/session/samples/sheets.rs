//! Open surfaces with a formula: a sheet of waves and an uneven tube.
//!
//! Guaranteed: connectivity does not depend on rounding.

use std::f64::consts::TAU;

use nalgebra::Vector3;

use super::grids::{Vertices, staggered_rings};
use crate::mesh::Soup;

/// A square of side 2 with two waves each way, in rows of triangles that are equilateral where it is level.
pub(super) fn sinusoidal_sheet() -> Soup {
    const HEIGHT: f64 = 0.13;
    // 86 steps of 0.0233; rows stand closer by √3/2.
    const COLUMNS: u32 = 86;
    const ROWS: u32 = 100;
    let mut vertices = Vertices::default();
    // Columns are counted in half steps, so that each second row can begin with one.
    let mut at = |row: u32, half: u32| {
        let half = half.min(2 * COLUMNS);
        vertices.at([row, half], || {
            let x = f64::from(half) / f64::from(COLUMNS) - 1.0;
            let z = 1.0 - 2.0 * f64::from(row) / f64::from(ROWS);
            Vector3::new(x, HEIGHT * (TAU * x).sin() * (TAU * z).sin(), z)
        })
    };
    let mut triangles = Vec::new();
    for row in 0..ROWS {
        // The row that has vertices at whole steps, and the one moved by half a step, with both ends added.
        let (whole, moved) = if row % 2 == 0 { (row, row + 1) } else { (row + 1, row) };
        let mut add = |triangle: [[u32; 2]; 3]| {
            let [a, b, c] = triangle.map(|[row, half]| at(row, half));
            triangles.push(if row % 2 == 0 { [a, b, c] } else { [a, c, b] });
        };
        for column in 0..COLUMNS {
            let left = 2 * column;
            add([[whole, left], [whole, left + 2], [moved, left + 1]]);
            add([[whole, left], [moved, left + 1], [moved, left.saturating_sub(1)]]);
        }
        let end = 2 * COLUMNS;
        add([[whole, end], [moved, end], [moved, end - 1]]);
    }
    Soup::from_triangles(vertices.positions, &triangles)
}

/// A tube about the y axis whose radius wanders: a sum of waves, weaker the shorter they are, with phases from
/// `seed`. Open at both ends.
pub(super) fn noisy_cylinder(seed: u64) -> Soup {
    const RADIUS: f64 = 0.58;
    const HEIGHT: f64 = 2.1;
    const ROUGHNESS: f64 = 0.11;
    const AROUND: u32 = 116;
    const BANDS: u32 = 78;
    let mut state = seed;
    let mut waves = Vec::new();
    for around in 0..6 {
        for along in -5..=5 {
            let [m, k] = [around, along].map(f64::from);
            let strength = ROUGHNESS / (1.0 + 0.2 * (m * m + k * k));
            waves.push((m, k, strength, TAU * random(&mut state)));
        }
    }
    let mut positions = Vec::new();
    for ring in 0..=BANDS {
        let t = f64::from(ring) / f64::from(BANDS);
        for column in 0..AROUND {
            let turn = TAU * (f64::from(column) + 0.5 * f64::from(ring % 2)) / f64::from(AROUND);
            let noise = waves
                .iter()
                .map(|(m, k, strength, phase)| strength * (m * turn + 2.5 * k * t + phase).sin());
            let r = RADIUS * (1.0 + noise.sum::<f64>());
            positions.push([r * turn.sin(), HEIGHT * (t - 0.5), r * turn.cos()]);
        }
    }
    let at = |ring: u32, column: u32| ring * AROUND + column % AROUND;
    Soup::from_triangles(positions, &staggered_rings(AROUND, BANDS, at))
}

/// The next number in 0..1 of the generator SplitMix64.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    // 53 bits fill a number exactly.
    ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
}
