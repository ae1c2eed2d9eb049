//! The distortion of phases with sharp borders: L s = K on each, s = 0 on its border, ∫s² as loss.
//!
//! The border runs through triangles where fields change sign; its points carry s = 0 and drop out, so that the unknowns
//! are the mesh's vertices and the one analysis serves. The exact value for a unit hemisphere is 1.183233.

use super::super::domain::Domain;
use crate::linalg::{Factor, LinalgError};
use crate::methods::cutflow::cut::{Corner, Cut, Frames};

/// ∫s² of each label below `count`; infinite where a closed component lies in one label as a whole, which nothing flattens.
///
/// **Costs** one numeric factorisation and one solve for all labels.
pub(in super::super) fn losses(
    domain: &Domain,
    frames: &Frames,
    cut: &Cut,
    labels: &[u32],
    count: usize,
) -> Result<Vec<f64>, LinalgError> {
    let pattern = domain.analysis.pattern();
    let topology = domain.mesh.topology();
    // Components that a border or a boundary reaches.
    let mut is_held = vec![false; topology.components];
    for crossed in &cut.faces {
        is_held[topology.face_components[crossed.face.index()] as usize] = true;
    }
    for (f, t) in domain.triangles.iter().enumerate() {
        if t.iter().any(|&v| domain.is_fixed[v as usize]) {
            is_held[topology.face_components[f] as usize] = true;
        }
    }
    let mut losses = vec![0.0; count];
    let mut is_zero = domain.is_fixed.clone();
    for (f, t) in domain.triangles.iter().enumerate() {
        if !is_held[topology.face_components[f] as usize] {
            losses[labels[t[0] as usize] as usize] = f64::INFINITY;
            for &v in t {
                is_zero[v as usize] = true;
            }
        }
    }

    let mut is_crossed = vec![false; domain.triangles.len()];
    for crossed in &cut.faces {
        is_crossed[crossed.face.index()] = true;
    }
    let mut values = vec![0.0; pattern.entry_count()];
    let whole = |f: usize| if is_crossed[f] { 0.0 } else { 1.0 };
    domain.add_stiffness(&mut values, whole, |v| is_zero[v]);
    for crossed in &cut.faces {
        let f = crossed.face.index();
        let points = cut.face_points(&domain.mesh, frames, crossed);
        for (triangle, _) in points.triangles(crossed.lone) {
            let places = triangle.map(|c| points.at(c));
            let doubled = (places[1] - places[0]).perp(&(places[2] - places[0]));
            let longest = (0..3)
                .map(|i| (places[(i + 1) % 3] - places[i]).norm_squared())
                .fold(f64::MIN_POSITIVE, f64::max);
            for i in 0..3 {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                let [a, b] = [places[i] - places[k], places[j] - places[k]];
                // As in `Geometry::measure`: a sliver may not cost the matrix its digits.
                let weight = 0.5 * a.dot(&b) / doubled.max(1e-8 * longest);
                let [from, to] = [triangle[i], triangle[j]].map(|c| corner(domain, f, c));
                for v in [from, to].into_iter().flatten().filter(|&v| !is_zero[v]) {
                    values[pattern.diagonal(v)] += weight;
                }
                if let (Some(from), Some(to)) = (from, to)
                    && !is_zero[from]
                    && !is_zero[to]
                    && let (Corner::Vertex(x), Corner::Vertex(y)) = (triangle[i], triangle[j])
                {
                    let side = if (x + 1) % 3 == y { x } else { y };
                    values[domain.side_slots[f][side] as usize] -= weight;
                }
            }
        }
    }
    let mut s = vec![0.0; domain.len()];
    for v in 0..domain.len() {
        if is_zero[v] {
            values[pattern.diagonal(v)] = 1.0;
        } else {
            s[v] = domain.defects[v];
        }
    }
    Factor::new(domain.analysis.clone(), &values)?.solve(&mut s, 1);

    // ∫s² over a triangle with linear s.
    let square = |area: f64, s: [f64; 3]| {
        let sum = s[0] + s[1] + s[2];
        area / 12.0 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + sum * sum)
    };
    for (f, t) in domain.triangles.iter().enumerate().filter(|&(f, _)| !is_crossed[f]) {
        let label = labels[t[0] as usize] as usize;
        losses[label] += square(domain.areas[f], t.map(|v| s[v as usize]));
    }
    let to_area = domain.scale * domain.scale;
    for crossed in &cut.faces {
        let f = crossed.face.index();
        let points = cut.face_points(&domain.mesh, frames, crossed);
        for (triangle, _) in points.triangles(crossed.lone) {
            let ends = triangle.map(|c| corner(domain, f, c));
            if let Some(v) = ends.into_iter().flatten().next() {
                let area = to_area * points.area(triangle);
                losses[labels[v] as usize] += square(area, ends.map(|v| v.map_or(0.0, |v| s[v])));
            }
        }
    }
    Ok(losses)
}

/// The vertex at a corner of a sub-triangle; points of the cut are none.
fn corner(domain: &Domain, face: usize, corner: Corner) -> Option<usize> {
    match corner {
        Corner::Vertex(i) => Some(domain.triangles[face][i] as usize),
        Corner::Side(_) | Corner::Centre => None,
    }
}
