//! Fields to begin a split with.

use std::collections::VecDeque;

use nalgebra::{Matrix3, Vector3};

use super::domain::Domain;
use super::params::{PhaseFieldParams, Start};
use super::profile::{STEEPNESS, indicator};
use crate::geometry::geodesic_distances_from;
use crate::linalg::{Factor, LinalgError, dot};
use crate::methods::cutflow::uniform;

/// Correlation length of noise in a segment of area 4π: a few bumps across it. Much shorter, and the first iterations go into
/// islands growing together; much longer, and seeds hardly differ.
const NOISE_LENGTH: f64 = 0.3;

/// One way to begin.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Axis(usize),
    Normal(usize),
    Noise,
    Values,
}

fn way(start: &Start, is_root: bool, attempt: usize) -> Way {
    let auto = |attempt| match attempt {
        0 => Way::Axis(0),
        2 => Way::Axis(1),
        3 => Way::Axis(2),
        _ => Way::Noise,
    };
    match (start, attempt) {
        (Start::Random, _) => Way::Noise,
        (Start::Axes, 0..=2) => Way::Axis(attempt),
        (Start::Normals, 0..=2) => Way::Normal(attempt),
        (Start::Axes | Start::Normals, _) => Way::Noise,
        (Start::Values(_), 0) if is_root => Way::Values,
        (Start::Values(_), _) if is_root => auto(attempt - 1),
        (Start::Auto | Start::Values(_), _) => auto(attempt),
    }
}

/// A field for the split of the segment with weight `w`; `node` makes noise differ from split to split.
pub(super) fn field(
    domain: &Domain,
    params: &PhaseFieldParams,
    w: &[f64],
    node: usize,
    attempt: usize,
) -> Result<Vec<f64>, LinalgError> {
    let mw: Vec<f64> = domain.mass.iter().zip(w).map(|(m, w)| m * w).collect();
    let whole: f64 = mw.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let mut u = match way(&params.start, node == 0, attempt) {
        Way::Values => {
            let Start::Values(values) = &params.start else { return Ok(vec![0.0; w.len()]) };
            let size = (mw.iter().zip(values.iter()).map(|(m, x)| m * x * x).sum::<f64>() / whole)
                .sqrt()
                .max(f64::MIN_POSITIVE);
            values.iter().map(|x| (2.0 * x / size).tanh()).collect()
        }
        Way::Axis(k) => {
            let points: Vec<Vector3<f64>> =
                domain.geometry.positions.iter().map(|p| p.coords * domain.scale).collect();
            across(&points, &mw, whole, k, params, STEEPNESS / params.epsilon)
        }
        Way::Normal(k) => {
            let normals: Vec<Vector3<f64>> = domain.geometry.vertex_normals(&domain.mesh);
            across(&normals, &mw, whole, k, params, 3.0)
        }
        Way::Noise => {
            let seed = params
                .seed
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .wrapping_add((node as u64) << 20)
                .wrapping_add(attempt as u64);
            noise(domain, &mw, whole, seed)?
        }
    };
    for (u, w) in u.iter_mut().zip(w) {
        *u *= w;
    }
    Ok(u)
}

/// Profile across the plane ⟂ the `k`-th axis of the vectors' spread that parts the segment in the fraction asked for.
fn across(
    vectors: &[Vector3<f64>],
    mw: &[f64],
    whole: f64,
    k: usize,
    params: &PhaseFieldParams,
    steepness: f64,
) -> Vec<f64> {
    let mean: Vector3<f64> =
        vectors.iter().zip(mw).map(|(x, m)| x * *m).sum::<Vector3<f64>>() / whole;
    let mut spread = Matrix3::zeros();
    for (x, m) in vectors.iter().zip(mw) {
        let d = x - mean;
        spread += d * d.transpose() * *m;
    }
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let axis = eigen.eigenvectors.column(order[k % 3]).into_owned();
    // Which way an eigenvector points is chance.
    let axis = if axis[axis.iamax()] < 0.0 { -axis } else { axis };
    let heights: Vec<f64> = vectors.iter().map(|x| (x - mean).dot(&axis)).collect();
    above_level(&heights, mw, params.fraction * whole, steepness)
}

/// Profile across the level above which heights have that area.
fn above_level(heights: &[f64], mw: &[f64], target: f64, steepness: f64) -> Vec<f64> {
    let mut by_height: Vec<usize> = (0..heights.len()).collect();
    by_height.sort_by(|&a, &b| heights[b].total_cmp(&heights[a]));
    let mut area = 0.0;
    let mut level = 0.0;
    for &v in &by_height {
        area += mw[v];
        level = heights[v];
        if area >= target {
            break;
        }
    }
    heights.iter().map(|h| (steepness * (h - level)).tanh()).collect()
}

/// Share of a segment that a field may miss before its interface is moved as a whole. Less, and fields are made anew that rounding put off;
/// more, and shifted values leave phases grey.
const FAR_OFF: f64 = 1e-3;

/// A field whose area is about right: the field itself, or the profile across a curve beside its interface, at the same distance everywhere.
/// Shifting values instead would turn whole phases grey.
///
/// **Gives** nothing where a field that is far off has no interface in the segment, or none in a component that is larger than the share.
pub(super) fn moved(
    domain: &Domain,
    params: &PhaseFieldParams,
    w: &[f64],
    u: &[f64],
) -> Option<Vec<f64>> {
    let mw: Vec<f64> = domain.mass.iter().zip(w).map(|(m, w)| m * w).collect();
    let whole: f64 = mw.iter().sum();
    let target = params.fraction * whole;
    let area: f64 = mw.iter().zip(u).map(|(m, &u)| m * indicator(u).0).sum();
    if (area - target).abs() <= FAR_OFF * whole {
        return Some(u.to_vec());
    }
    let u = &without_noise(domain, u);
    let mut near = vec![f64::INFINITY; u.len()];
    for e in domain.mesh.edges() {
        let ends = domain.mesh.edge_vertices(e).map(|v| v.index());
        if (u[ends[0]] >= 0.0) == (u[ends[1]] >= 0.0) || ends.iter().any(|&v| w[v] < 0.5) {
            continue;
        }
        let length = domain.geometry.edge_length(e);
        let share = u[ends[0]] / (u[ends[0]] - u[ends[1]]);
        near[ends[0]] = near[ends[0]].min(length * share);
        near[ends[1]] = near[ends[1]].min(length * (1.0 - share));
    }
    let sources: Vec<_> = domain.mesh.vertices().map(|v| (v, near[v.index()])).collect();
    let sources: Vec<_> = sources.into_iter().filter(|(_, near)| near.is_finite()).collect();
    if sources.is_empty() {
        return None;
    }
    // Components without an interface lie farther than all others.
    let distances = geodesic_distances_from(&domain.mesh, &domain.geometry, &sources);
    let side = |(d, &u): (&f64, &f64)| if u >= 0.0 { *d } else { -d } * domain.scale;
    let heights: Vec<f64> = distances.iter().zip(u).map(side).collect();
    let mut u = above_level(&heights, &mw, target, STEEPNESS / params.epsilon);
    u.iter_mut().zip(w).for_each(|(u, w)| *u *= w);
    u.iter().all(|u| u.is_finite()).then_some(u)
}

/// |u| up to which a sign is noise: outside of a segment a field is about 0. An interface is steep, and has few vertices of smaller values.
const NOISE: f64 = 0.15;

/// A field whose small values have the sign of the nearest larger one, by edges.
fn without_noise(domain: &Domain, u: &[f64]) -> Vec<f64> {
    let mut clear = u.to_vec();
    let mut is_known: Vec<bool> = u.iter().map(|u| u.abs() > NOISE).collect();
    let mut front: VecDeque<_> = domain.mesh.vertices().filter(|v| is_known[v.index()]).collect();
    while let Some(v) = front.pop_front() {
        for w in domain.mesh.outgoing(v).map(|h| domain.mesh.tip(h)) {
            if !is_known[w.index()] {
                is_known[w.index()] = true;
                let size = u[w.index()].abs();
                clear[w.index()] = if clear[v.index()] < 0.0 { -size.max(1e-3) } else { size };
                front.push_back(w);
            }
        }
    }
    clear
}

/// ±1 on every face, smoothed twice by (M + ℓ² L)⁻¹ M, of mean 0 and spread over (−1, 1).
fn noise(domain: &Domain, mw: &[f64], whole: f64, seed: u64) -> Result<Vec<f64>, LinalgError> {
    let mut state = seed;
    let mut field = vec![0.0; domain.len()];
    for (f, t) in domain.triangles.iter().enumerate() {
        let sign = if uniform(&mut state) < 0.5 { -1.0 } else { 1.0 };
        for &v in t {
            field[v as usize] += sign * domain.areas[f] / 3.0;
        }
    }
    let pattern = domain.analysis.pattern();
    let mut values = vec![0.0; pattern.entry_count()];
    let square = NOISE_LENGTH * NOISE_LENGTH * whole / (4.0 * std::f64::consts::PI);
    domain.add_stiffness(&mut values, |_| square, |_| false);
    for (v, m) in domain.mass.iter().enumerate() {
        // Isolated vertices have no area and take no part.
        values[pattern.diagonal(v)] += if *m > 0.0 { *m } else { 1.0 };
    }
    let mut factor = Factor::new(domain.analysis.clone(), &values)?;
    factor.solve(&mut field, 1);
    for (x, m) in field.iter_mut().zip(&domain.mass) {
        *x *= m;
    }
    factor.solve(&mut field, 1);
    let mean = dot(&field, mw) / whole;
    let square: f64 =
        field.iter().zip(mw).map(|(x, m)| m * (x - mean) * (x - mean)).sum::<f64>() / whole;
    let size = square.sqrt().max(f64::MIN_POSITIVE);
    Ok(field.iter().map(|x| (1.5 * (x - mean) / size).tanh()).collect())
}
