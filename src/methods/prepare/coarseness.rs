//! How large triangles are against the curvature.

use nalgebra::Point3;

use crate::geometry::{Geometry, angle_defects};
use crate::mesh::{FaceId, Mesh};

/// The [`coarseness`] above which finer triangles should be offered.
///
/// On a surface of curvature K the log scale factor obeys Δu = −K, so that a function linear on triangles of side h misses it by
/// up to h²K/8: at 0.5 by 3 %, an edge of 29° on a sphere, 13 around its equator. At 0.25 meshes that cut well would be complained
/// about (scans lie between 0.15 and 0.4); at 1 the error is 12 %, as large as the distortions that cuts are chosen by.
pub const TOO_COARSE: f64 = 0.5;

/// Longest side of a face times the root of its |Gaussian curvature|: the value that 95 % of the area stays below.
///
/// **Means** roughly the angle in radians that an edge spans; unitless, 0 where everything is developable. One cone point, or a
/// bad patch of less than a twentieth of the area, does not show. **Costs** O(F log F). **See** [`TOO_COARSE`].
pub fn coarseness(mesh: &Mesh, positions: &[Point3<f64>]) -> f64 {
    let geometry = Geometry::measure(mesh, positions.to_vec());
    let curvatures = vertex_curvatures(mesh, &geometry);
    let mut faces: Vec<(f64, f64)> = mesh
        .faces()
        .map(|f| {
            let side = |h: crate::mesh::HalfedgeId| geometry.edge_length(h.edge());
            let longest = mesh.face_halfedges(f).map(side).into_iter().fold(0.0, f64::max);
            let mean =
                mesh.face_vertices(f).map(|v| curvatures[v.index()]).iter().sum::<f64>() / 3.0;
            (longest * mean.sqrt(), geometry.face_areas[f.index()])
        })
        .collect();
    faces.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let bound = 0.95 * geometry.total_area();
    let mut area = 0.0;
    for (value, share) in faces {
        area += share;
        if area >= bound {
            return value;
        }
    }
    0.0
}

/// |K| at the vertices: the angle defects of a vertex and its neighbours over the area that they stand for. Taken over a whole
/// ring because the single defects of a scanned surface are mostly noise, which cancels.
///
/// **Means** pointwise; 0 where no inner vertex is near. **Gives** finite values.
pub(super) fn vertex_curvatures(mesh: &Mesh, geometry: &Geometry) -> Vec<f64> {
    let mut defects = angle_defects(mesh, geometry);
    let mut areas = geometry.vertex_dual_areas(mesh);
    for v in mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v)) {
        // Geodesic curvature of the rim says nothing about the surface.
        (defects[v.index()], areas[v.index()]) = (0.0, 0.0);
    }
    let (mut sums, mut ring_areas) = (defects.clone(), areas.clone());
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| v.index());
        for (to, from) in [(a, b), (b, a)] {
            sums[to] += defects[from];
            ring_areas[to] += areas[from];
        }
    }
    let density = |(sum, area): (f64, f64)| {
        let density = (sum / area).abs();
        if density.is_finite() { density } else { 0.0 }
    };
    sums.into_iter().zip(ring_areas).map(density).collect()
}

/// How much the normal turns per length at the vertices, at most: |n − n′| / |edge| over the edges of a vertex.
///
/// **Means** pointwise, about the larger principal curvature; large along creases. **Gives** finite values.
pub(super) fn vertex_bends(mesh: &Mesh, geometry: &Geometry) -> Vec<f64> {
    let areas = |f: FaceId| geometry.face_areas[f.index()];
    let mut normals = vec![nalgebra::Vector3::zeros(); mesh.vertex_count()];
    for f in mesh.faces().filter(|&f| areas(f) > 0.0) {
        let [a, b, c] = mesh.face_vertices(f).map(|v| geometry.positions[v.index()]);
        let normal = (b - a).cross(&(c - a)).normalize();
        for (v, angle) in mesh.face_vertices(f).iter().zip(geometry.corner_angles[f.index()]) {
            normals[v.index()] += normal * angle;
        }
    }
    for normal in &mut normals {
        *normal = normal.try_normalize(1e-300).unwrap_or_default();
    }
    let mut bends = vec![0.0_f64; mesh.vertex_count()];
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| v.index());
        let bend = (normals[a] - normals[b]).norm() / geometry.edge_length(e);
        if bend.is_finite() {
            bends[a] = bends[a].max(bend);
            bends[b] = bends[b].max(bend);
        }
    }
    bends
}
