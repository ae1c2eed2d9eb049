//! Regions between level sets of mean curvature.

use std::sync::Arc;

use super::clusters::{absorb_small, compact, pieces};
use super::{Levels, Start, out_of_range};
use crate::geometry::{Geometry, Laplacian};
use crate::linalg::{Analysis, Factor};
use crate::mesh::Mesh;
use crate::methods::flow::SolveError;

/// Length over which curvature is smoothed, on a surface of unit area. Half of it leaves bands in tatters on scanned
/// surfaces, twice as much melts ears and fingers.
const SMOOTHING: f64 = 0.05;

/// But at least so many mean edge lengths: curvature of single vertices is noise.
const SMOOTHING_EDGES: f64 = 2.0;

/// Share of its dual area with which a boundary vertex takes part: nearly none, since the Laplacian of positions is no
/// curvature there, and enough for a component that is nothing but boundary.
const BOUNDARY_SHARE: f64 = 1e-6;

/// Curvatures that differ by less than this fraction are equal.
const SAME: f64 = 1e-9;

/// Smoothed mean curvature at the vertices: (M + ℓ² L) H = ½ n·(L x), positive where convex.
///
/// **Means** pointwise, per unit-area length.
pub(super) fn mean_curvatures(mesh: &Mesh, geometry: &Geometry) -> Result<Vec<f64>, SolveError> {
    let Laplacian { pattern, mut values, .. } = Laplacian::new(mesh, geometry);
    let count = mesh.vertex_count();
    let normals = geometry.vertex_normals(mesh);
    let mut curvatures = vec![0.0; count];
    let mut product = vec![0.0; count];
    for axis in 0..3 {
        let x: Vec<f64> = geometry.positions.iter().map(|p| p[axis]).collect();
        pattern.multiply(&values, &x, &mut product);
        for (v, sum) in curvatures.iter_mut().enumerate() {
            *sum += 0.5 * product[v] * normals[v][axis];
        }
    }
    let length = SMOOTHING.max(SMOOTHING_EDGES * geometry.mean_edge_length());
    for value in &mut values {
        *value *= length * length;
    }
    let areas = geometry.vertex_dual_areas(mesh);
    for v in mesh.vertices() {
        let is_rim = mesh.is_boundary_vertex(v);
        if is_rim || mesh.halfedge(v).is_none() {
            curvatures[v.index()] = 0.0;
        }
        let share = if is_rim { BOUNDARY_SHARE } else { 1.0 };
        let area = share * areas[v.index()];
        values[pattern.diagonal(v.index())] += if area > 0.0 { area } else { 1.0 };
    }
    Factor::new(Arc::new(Analysis::new(pattern)?), &values)?.solve(&mut curvatures, 1);
    Ok(curvatures)
}

/// Bands of equal area between level sets of mean curvature; tiny pieces join the band around them.
pub(super) fn curvature_levels(
    mesh: &Mesh,
    geometry: &Geometry,
    regions: u32,
) -> Result<Start, SolveError> {
    if regions < 2 || regions as usize > mesh.vertex_count() {
        let most = mesh.vertex_count() as f64;
        return Err(out_of_range("number of curvature bands", f64::from(regions), 2.0, most));
    }
    let curvatures = mean_curvatures(mesh, geometry)?;
    if !curvatures.iter().all(|x| x.is_finite()) {
        return Err(SolveError::NotFinite);
    }
    let Some(thresholds) = thresholds(mesh, geometry, &curvatures, regions) else {
        return Err(SolveError::EmptyCut { vertices: mesh.vertex_count() });
    };
    let bands: Vec<u32> =
        curvatures.iter().map(|x| thresholds.partition_point(|t| t <= x) as u32).collect();
    let (clusters, count) = pieces(mesh, &bands);
    let mut cluster_bands = vec![0; count];
    for (&cluster, &band) in clusters.iter().zip(&bands) {
        cluster_bands[cluster as usize] = band;
    }
    let ends = absorb_small(mesh, geometry, &clusters, count);
    let labels: Vec<u32> =
        clusters.iter().map(|&c| cluster_bands[ends[c as usize] as usize]).collect();
    // How far a level set is: by its height, over the mean slope where bands meet.
    let (mut rise, mut run) = (0.0, 0.0);
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| v.index());
        if labels[a] != labels[b] {
            rise += (curvatures[a] - curvatures[b]).abs();
            run += geometry.edge_length(e);
        }
    }
    let slope = rise / run.max(1e-300);
    let mean_edge = geometry.mean_edge_length();
    let magnitude = |x: &f64| {
        let height = thresholds.iter().map(|t| (x - t).abs()).fold(f64::INFINITY, f64::min);
        (height / slope.max(1e-300)).clamp(1e-3 * mean_edge, mean_edge)
    };
    let magnitudes = curvatures.iter().map(magnitude).collect();
    Ok(Start::new(compact(&labels), Levels::Vertex(magnitudes)))
}

/// The heights that divide the surface into parts of equal area; `None` if it is equally curved everywhere.
fn thresholds(
    mesh: &Mesh,
    geometry: &Geometry,
    curvatures: &[f64],
    regions: u32,
) -> Option<Vec<f64>> {
    let areas = geometry.vertex_dual_areas(mesh);
    let mut order: Vec<usize> =
        mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()).map(|v| v.index()).collect();
    order.sort_by(|&a, &b| curvatures[a].total_cmp(&curvatures[b]).then(a.cmp(&b)));
    let (lowest, highest) = (curvatures[*order.first()?], curvatures[*order.last()?]);
    if highest - lowest <= SAME * highest.abs().max(lowest.abs()) {
        return None;
    }
    let total: f64 = order.iter().map(|&v| areas[v]).sum();
    let mut result = Vec::with_capacity(regions as usize - 1);
    let mut sum = 0.0;
    for pair in order.windows(2) {
        sum += areas[pair[0]];
        while result.len() + 1 < regions as usize
            && sum * f64::from(regions) >= (result.len() + 1) as f64 * total
        {
            result.push(0.5 * (curvatures[pair[0]] + curvatures[pair[1]]));
        }
    }
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::samples;

    #[test]
    fn a_ball_has_the_mean_curvature_of_its_radius() {
        let ball = samples::icosphere(12);
        let triangles: Vec<[u32; 3]> =
            (0..ball.polygon_count()).map(|i| [0, 1, 2].map(|k| ball.polygon(i)[k])).collect();
        let mesh = Mesh::new(ball.positions.len(), &triangles).unwrap();
        let (geometry, _) = Geometry::unit_area(&mesh, &ball.positions).unwrap();
        let exact = (4.0 * std::f64::consts::PI).sqrt();
        for h in mean_curvatures(&mesh, &geometry).unwrap() {
            // Second order in the edge, 1/12 of 63° here.
            assert!((h / exact - 1.0).abs() < 0.02, "{h} instead of {exact}");
        }
    }
}
