//! Clusters of cones to single cones.
//!
//! The optimum likes a cone best where no vertex is, and makes a *cluster* of neighbouring vertices of it; where curvature runs along a
//! curve, it follows the curve. A cluster that is small against the surface acts like one cone at its centre of gravity (what is left
//! are moments of second order), so it becomes one; a long one is parted along its length into cones of a quarter turn at most.
//!
//! Guaranteed: the angles of each connected component add up to what they did, to rounding; cones that have no neighbour among the
//! cones stay as they are; every cone of several vertices lies at one of them, with an angle within the bounds and
//! in (−2π, 2π), in (−2π, π) on the boundary. Not guaranteed: the best places.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::Cone;
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};

/// Options of [`round_clusters`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundParams {
    /// A cluster is small up to this length, in square roots of the area.
    pub small: f64,
    /// Largest angle that a small cluster may have as one cone, radians.
    pub small_angle: f64,
    /// Largest angle of a part of another cluster that has several vertices, radians.
    pub part_angle: f64,
    /// Bounds of the angles inside, as those of [`super::ConeParams`].
    pub bounds: [f64; 2],
}

impl Default for RoundParams {
    fn default() -> Self {
        Self {
            small: 0.06,
            small_angle: PI,
            part_angle: FRAC_PI_2,
            bounds: [f64::NEG_INFINITY, f64::INFINITY],
        }
    }
}

/// What [`round_clusters`] made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rounded {
    /// The cones, by ascending vertex.
    pub cones: Vec<Cone>,
    /// For each of them the vertices that it stands for, ascending; it alone where nothing was done.
    pub clusters: Vec<Vec<VertexId>>,
}

/// Larger clusters stay as they are: on parts that are convex everywhere all vertices are one, and no few cones stand for them. Their
/// table of distances would take more than 8 MB.
const MOST: usize = 1000;

/// Divisions of a cluster that are tried, from the least number of parts that its angle needs. Where none of them keeps every part below the
/// limit its vertices are too heavy for that.
const TRIES: usize = 24;

/// Angles that differ by less are the same where a place is chosen, radians.
const GRAIN: f64 = 1e-9;

/// Bound of |angle| of a cone: with 2π there is no angle left about it.
const LIMIT: f64 = TAU * (1.0 - 1e-6);

/// Merges clusters of cones.
///
/// A cluster is a set of cones of one sign, all inside or all on the boundary, that hang together by edges of the mesh (by edges of the
/// boundary there): cones of opposite signs side by side are a dipole, which a merged cone could not stand for. The place of a merged
/// cone is the member with the least Σ |angle| d² to all members, d along edges within the cluster. Parts of a long cluster are what is
/// nearest to each of several members, moved to the centres of their parts until nothing changes.
///
/// A cone with |angle| ≥ 2π, which no flat metric has, is shared out between its vertex and the nearest vertices that are no cones.
///
/// **Takes** cones at different vertices. **Costs** O(m² log m) for clusters of m vertices; those of more than a thousand are left as they are.
pub fn round_clusters(
    mesh: &Mesh,
    geometry: &Geometry,
    cones: &[Cone],
    params: &RoundParams,
) -> Rounded {
    let unit = geometry.total_area().sqrt();
    let mut found = Vec::new();
    for cluster in clusters(mesh, cones) {
        if cluster.len() > MOST {
            found.extend(cluster.iter().map(|&cone| (cone, vec![cone.vertex])));
            continue;
        }
        let members = Cluster::new(mesh, geometry, &cluster);
        for part in members.parts(params, unit) {
            let angle: f64 = part.iter().map(|&i| cluster[i].angle).sum();
            let vertex = cluster[members.centre(&part)].vertex;
            let mut names: Vec<VertexId> = part.iter().map(|&i| cluster[i].vertex).collect();
            names.sort_unstable();
            found.push((Cone { vertex, angle }, names));
        }
    }
    share_out(mesh, geometry, &mut found);
    found.sort_by_key(|(cone, _)| cone.vertex);
    let (cones, clusters) = found.into_iter().unzip();
    Rounded { cones, clusters }
}

/// Cones that hang together, each cluster and the clusters by ascending vertex.
fn clusters(mesh: &Mesh, cones: &[Cone]) -> Vec<Vec<Cone>> {
    let mut sorted: Vec<Cone> = cones.to_vec();
    sorted.sort_by_key(|c| c.vertex);
    let mut is_seen = vec![false; sorted.len()];
    let mut clusters = Vec::new();
    for seed in 0..sorted.len() {
        if std::mem::replace(&mut is_seen[seed], true) {
            continue;
        }
        let mut cluster = vec![sorted[seed]];
        let mut next = 0;
        while let Some(&cone) = cluster.get(next) {
            next += 1;
            for (_, tip) in steps(mesh, cone.vertex) {
                let Ok(at) = sorted.binary_search_by_key(&tip, |c| c.vertex) else { continue };
                let is_alike = (sorted[at].angle > 0.0) == (cone.angle > 0.0);
                if is_alike && !std::mem::replace(&mut is_seen[at], true) {
                    cluster.push(sorted[at]);
                }
            }
        }
        cluster.sort_by_key(|c| c.vertex);
        clusters.push(cluster);
    }
    clusters
}

/// The edges from a vertex inside to others inside, or from one on the boundary along the boundary, with where they lead.
fn steps(mesh: &Mesh, v: VertexId) -> impl Iterator<Item = (usize, VertexId)> + '_ {
    let is_rim = mesh.is_boundary_vertex(v);
    mesh.outgoing(v)
        .map(move |h| (h.edge(), mesh.tip(h)))
        .filter(
            move |&(e, tip)| {
                if is_rim { mesh.is_boundary_edge(e) } else { !mesh.is_boundary_vertex(tip) }
            },
        )
        .map(|(e, tip)| (e.index(), tip))
}

/// Some cones and the distances between them.
struct Cluster {
    weights: Vec<f64>,
    /// The same in whole grains: places do not depend on the last digits, which differ from one way to the optimum to another.
    masses: Vec<f64>,
    is_positive: bool,
    is_rim: bool,
    /// Along edges between members.
    distances: Vec<Vec<f64>>,
}

impl Cluster {
    fn new(mesh: &Mesh, geometry: &Geometry, cones: &[Cone]) -> Self {
        let links: Vec<Vec<(usize, f64)>> = cones
            .iter()
            .map(|c| {
                steps(mesh, c.vertex)
                    .filter_map(|(e, tip)| {
                        let at = cones.binary_search_by_key(&tip, |c| c.vertex).ok()?;
                        Some((at, geometry.edge_lengths[e]))
                    })
                    .collect()
            })
            .collect();
        let weights: Vec<f64> = cones.iter().map(|c| c.angle.abs()).collect();
        Self {
            masses: weights.iter().map(|w| (w / GRAIN).round()).collect(),
            weights,
            is_positive: cones[0].angle > 0.0,
            is_rim: mesh.is_boundary_vertex(cones[0].vertex),
            distances: (0..cones.len()).map(|i| distances_from(i, &links)).collect(),
        }
    }

    fn weight(&self, part: &[usize]) -> f64 {
        part.iter().map(|&i| self.weights[i]).sum()
    }

    /// The member of a part that is nearest to all of it in the mean of squares, the first of equals.
    fn centre(&self, part: &[usize]) -> usize {
        let spread = |&i: &usize| -> f64 {
            part.iter().map(|&j| self.masses[j] * self.distances[i][j].powi(2)).sum()
        };
        part.iter().copied().min_by(|a, b| spread(a).total_cmp(&spread(b))).unwrap_or(0)
    }

    /// The parts that become one cone each.
    fn parts(&self, params: &RoundParams, unit: f64) -> Vec<Vec<usize>> {
        let all: Vec<usize> = (0..self.weights.len()).collect();
        if all.len() == 1 {
            return vec![all];
        }
        // Angles beyond the bounds are merged no more than is asked for.
        let bound = match (self.is_rim, self.is_positive) {
            (true, true) => PI * (1.0 - 1e-6),
            (true, false) => LIMIT,
            (false, true) => params.bounds[1].min(LIMIT),
            (false, false) => (-params.bounds[0]).min(LIMIT),
        };
        let length = self.distances.iter().flatten().fold(0.0, |m: f64, &d| m.max(d));
        if length <= params.small * unit && self.weight(&all) <= params.small_angle.min(bound) {
            return vec![all];
        }
        let limit = params.part_angle.min(bound);
        let least = (2..all.len()).find(|&count| self.weight(&all) <= count as f64 * limit);
        let least = least.unwrap_or(all.len());
        for count in (least..all.len()).take(TRIES) {
            let parts = self.split(count);
            if parts.iter().all(|p| p.len() == 1 || self.weight(p) <= limit) {
                return parts;
            }
        }
        all.into_iter().map(|i| vec![i]).collect()
    }

    /// Parts around so many centres.
    fn split(&self, count: usize) -> Vec<Vec<usize>> {
        let all: Vec<usize> = (0..self.weights.len()).collect();
        let farthest = |centres: &[usize]| {
            let distance = |i: usize| {
                centres.iter().fold(f64::INFINITY, |m: f64, &c| m.min(self.distances[c][i]))
            };
            let far = all.iter().rev().copied();
            far.max_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
        };
        let mut centres = vec![farthest(&[self.centre(&all)])];
        while centres.len() < count {
            centres.push(farthest(&centres));
        }
        let mut parts = Vec::new();
        // Lloyd's iteration; it settles within a few rounds, and none is needed for a valid result.
        for _ in 0..20 {
            parts = vec![Vec::new(); count];
            for &i in &all {
                let near = (0..count)
                    .min_by(|&a, &b| {
                        self.distances[centres[a]][i].total_cmp(&self.distances[centres[b]][i])
                    })
                    .unwrap_or(0);
                parts[near].push(i);
            }
            let moved: Vec<usize> = parts.iter().map(|p| self.centre(p)).collect();
            if moved == centres {
                break;
            }
            centres = moved;
        }
        parts
    }
}

/// Shortest paths from one member along links (Dijkstra on few vertices).
fn distances_from(start: usize, links: &[Vec<(usize, f64)>]) -> Vec<f64> {
    let mut distances = vec![f64::INFINITY; links.len()];
    distances[start] = 0.0;
    let mut heap = std::collections::BinaryHeap::from([(std::cmp::Reverse(0u64), start)]);
    while let Some((std::cmp::Reverse(bits), i)) = heap.pop() {
        let distance = f64::from_bits(bits);
        if distance > distances[i] {
            continue;
        }
        for &(j, length) in &links[i] {
            let candidate = distance + length;
            if candidate < distances[j] {
                distances[j] = candidate;
                heap.push((std::cmp::Reverse(candidate.to_bits()), j));
            }
        }
    }
    distances
}

/// Gives cones with |angle| ≥ 2π further vertices, so many that each has at most π.
fn share_out(mesh: &Mesh, geometry: &Geometry, found: &mut Vec<(Cone, Vec<VertexId>)>) {
    for k in 0..found.len() {
        let Cone { vertex, angle } = found[k].0;
        if angle.abs() < LIMIT {
            continue;
        }
        let needed = (angle.abs() / PI).ceil();
        let mut near = vec![vertex];
        let mut distances = vec![0.0];
        let mut next = 0;
        // A vertex may have fewer free neighbours than are needed: then theirs.
        while let Some(&v) = near.get(next)
            && (near.len() as f64) < needed
        {
            let mut ring: Vec<(f64, VertexId)> = steps(mesh, v)
                .filter(|(_, tip)| {
                    !near.contains(tip) && found.iter().all(|(c, _)| c.vertex != *tip)
                })
                .map(|(e, tip)| (distances[next] + geometry.edge_lengths[e], tip))
                .collect();
            ring.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (distance, tip) in ring {
                if (near.len() as f64) < needed {
                    near.push(tip);
                    distances.push(distance);
                }
            }
            next += 1;
        }
        let share = angle / near.len() as f64;
        found[k].0.angle = share;
        for &v in &near[1..] {
            found.push((Cone { vertex: v, angle: share }, vec![vertex]));
        }
    }
}
