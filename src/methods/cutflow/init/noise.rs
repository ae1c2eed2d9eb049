//! Seeded randomness: the disturbance of a first step, and numbers to draw places with.

use std::sync::Arc;

use crate::geometry::{Geometry, Laplacian};
use crate::linalg::{Analysis, LinalgError};
use crate::mesh::Mesh;
use crate::methods::cutflow::energy::SharedFactor;

/// Correlation length of the kick for a surface of unit area.
const KICK_LENGTH: f64 = 0.08;

/// S M S ξ with S = (M + ℓ² L)⁻¹ and ξ seeded noise: a smooth random field, the same for the same seed.
pub(in crate::methods::cutflow) fn smooth_noise(
    mesh: &Mesh,
    geometry: &Geometry,
    analysis: &Arc<Analysis>,
    seed: u64,
    shared: &mut SharedFactor,
) -> Result<Vec<f64>, LinalgError> {
    let areas = geometry.vertex_dual_areas(mesh);
    let Laplacian { pattern, mut values, .. } = Laplacian::new(mesh, geometry);
    for value in &mut values {
        *value *= KICK_LENGTH * KICK_LENGTH;
    }
    for (v, area) in areas.iter().enumerate() {
        // Isolated vertices have no area and take no part.
        values[pattern.diagonal(v)] += if *area > 0.0 { *area } else { 1.0 };
    }
    shared.refactor(analysis, &values)?;
    let mut state = seed;
    let mut field: Vec<f64> = (0..mesh.vertex_count()).map(|_| noise(&mut state)).collect();
    shared.solve(&mut field);
    for (x, area) in field.iter_mut().zip(&areas) {
        *x *= area;
    }
    shared.solve(&mut field);
    Ok(field)
}

/// Nearly normal noise: the centred sum of four uniform numbers.
fn noise(state: &mut u64) -> f64 {
    let mut sum = -2.0;
    for _ in 0..4 {
        sum += uniform(state);
    }
    sum
}

/// The next number of a SplitMix64 sequence, uniform in [0, 1).
pub(in super::super::super) fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1u64 << 53) as f64
}
