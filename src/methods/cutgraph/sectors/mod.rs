//! Seams that leave no sector of a full turn about a cone.
//!
//! About a cone of angle Θ > 2π the plane is covered more than once, however the surface is laid out, unless seams divide Θ into
//! sectors below 2π: ⌈Θ / 2π⌉ seams at least have to end there. Where there are too few, a sector is divided by a shortest path from the cone to
//! other seams. That parts the surface's disk in two, which are joined again across a stretch of seam between them that nothing needs: the
//! network of seams is led *through* the cone instead of past it.

mod network;

use std::f64::consts::{PI, TAU};

use super::Seams;
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;
use network::{Network, Sector};

/// What [`part_sectors`] gives.
#[derive(Clone, Debug)]
pub struct Parted {
    /// The seams as they are now.
    pub seams: Seams,
    /// How many paths were added.
    pub paths: usize,
    /// For how many of them no stretch could be given up: so many more disks there are.
    pub added: usize,
    /// Cones that have a sector of 2π or more still, with its angle: there is no edge to divide it.
    pub wide: Vec<(VertexId, f64)>,
}

/// Widest sector that is not divided, radians. A full turn overlaps for certain, and a little less than one soon does, where the sides of
/// the sector come near each other.
pub const WIDEST: f64 = 1.75 * PI;

/// Divides the sectors about cones of negative curvature.
///
/// Angles of the flat metric are taken to be those of the surface times Θ over their sum, as conformal maps have it.
///
/// **Takes** seams along edges of the mesh that open it to disks; cones with their curvature μ, so that Θ = 2π − μ inside and π − μ
/// on the boundary (others may be among them: they stay on seams); what a seam costs at each vertex beside its length, or nothing.
/// **Gives** seams that divide every Θ > 2π into sectors below 2π, all components disks, as many as before where stretches could be
/// given up. **Fails** if a vertex is not there. **Costs** O(F log F) for each path. **From** the notes on prevention of overlaps.
pub fn part_sectors(
    mesh: &Mesh,
    geometry: &Geometry,
    seams: &Seams,
    cones: &[(VertexId, f64)],
    cost: &[f64],
) -> Result<Parted, SolveError> {
    let vertices = mesh.vertex_count();
    assert!(cost.is_empty() || cost.len() == vertices);
    let is_there = |v: VertexId| v.index() < vertices && mesh.halfedge(v).is_some();
    if let Some(&(vertex, _)) = cones.iter().find(|c| !is_there(c.0)) {
        return Err(SolveError::NoSuchVertex { vertex, vertices });
    }
    let mut network = Network::new(mesh, geometry, seams, cones, cost);
    let mut wanted: Vec<VertexId> = cones.iter().map(|c| c.0).collect();
    wanted.sort_by(|a, b| network.total(*b).total_cmp(&network.total(*a)).then(a.cmp(b)));
    wanted.dedup();
    let (mut paths, mut added) = (0, 0);
    for &v in &wanted {
        while !network.is_parted(v) {
            let Some(has_joined) = network.divide(v) else { break };
            paths += 1;
            added += usize::from(!has_joined);
        }
    }
    let mut wide: Vec<(VertexId, f64)> = Vec::new();
    wanted.sort_unstable();
    for v in wanted {
        let widest = network.sectors(v).iter().map(Sector::angle).fold(0.0, f64::max);
        if widest >= TAU {
            wide.push((v, widest));
        }
    }
    let edges = || mesh.edges().filter(|e| network.is_cut[e.index()]);
    let mut cut = seams.cut.clone();
    cut.cut_edges = edges().map(|e| mesh.edge_vertices(e).map(|v| v.0)).collect();
    let length = edges().fold(0.0, |sum, e| sum + geometry.edge_length(e));
    let opened = cut.open()?;
    Ok(Parted { seams: Seams { cut, opened, length }, paths, added, wide })
}
