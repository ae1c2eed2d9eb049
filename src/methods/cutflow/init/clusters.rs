//! Connected clusters of vertices: grown, merged, coloured.

use std::collections::{BTreeMap, VecDeque};

use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};

const NONE: u32 = u32::MAX;

/// Clusters smaller than this fraction of the area join a neighbour: they would vanish in the first steps.
pub(super) const SMALLEST_CLUSTER: f64 = 2e-3;

/// Connected clusters: every pair of neighbours that `joins(seed, vertex)` accepts for the seed of the growing one.
///
/// **Gives** a cluster for each vertex, numbered by first vertex, and their number; isolated vertices are of cluster 0.
pub(super) fn grow(mesh: &Mesh, joins: impl Fn(VertexId, VertexId) -> bool) -> (Vec<u32>, usize) {
    let mut clusters = vec![NONE; mesh.vertex_count()];
    let mut count = 0;
    let mut queue = VecDeque::new();
    for seed in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        if clusters[seed.index()] != NONE {
            continue;
        }
        clusters[seed.index()] = count;
        queue.push_back(seed);
        while let Some(v) = queue.pop_front() {
            for h in mesh.outgoing(v) {
                let w = mesh.tip(h);
                if clusters[w.index()] == NONE && joins(seed, w) {
                    clusters[w.index()] = count;
                    queue.push_back(w);
                }
            }
        }
        count += 1;
    }
    for cluster in clusters.iter_mut().filter(|c| **c == NONE) {
        *cluster = 0;
    }
    (clusters, count as usize)
}

/// The connected pieces of labels, numbered by first vertex, and their number.
pub(in crate::methods::cutflow) fn pieces(mesh: &Mesh, labels: &[u32]) -> (Vec<u32>, usize) {
    grow(mesh, |seed, v| labels[seed.index()] == labels[v.index()])
}

/// Clusters of vertices whose normals differ from the seed's by less than `angle`, without tiny ones.
pub(super) fn normal_clusters(mesh: &Mesh, geometry: &Geometry, angle: f64) -> Vec<u32> {
    let normals = geometry.vertex_normals(mesh);
    let least = angle.cos();
    let (clusters, count) =
        grow(mesh, |seed, v| normals[v.index()].dot(&normals[seed.index()]) > least);
    let targets = absorb_small(mesh, geometry, &clusters, count);
    clusters.iter().map(|&c| targets[c as usize]).collect()
}

/// [`absorb`] of all clusters below [`SMALLEST_CLUSTER`].
pub(super) fn absorb_small(
    mesh: &Mesh,
    geometry: &Geometry,
    clusters: &[u32],
    count: usize,
) -> Vec<u32> {
    let least = SMALLEST_CLUSTER * geometry.total_area();
    absorb(mesh, geometry, clusters, count, |_, area| area >= least)
}

/// Lets clusters join a neighbour, the one with the longest common border, smallest first.
///
/// **Takes** `stays(cluster, area)`: whether a cluster stays, asked when its turn comes, with what has joined it before.
/// **Gives** for each cluster the one that it ends in. A cluster without neighbours stays.
pub(super) fn absorb(
    mesh: &Mesh,
    geometry: &Geometry,
    clusters: &[u32],
    count: usize,
    stays: impl Fn(u32, f64) -> bool,
) -> Vec<u32> {
    let areas = geometry.vertex_dual_areas(mesh);
    let mut cluster_areas = vec![0.0; count];
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        cluster_areas[clusters[v.index()] as usize] += areas[v.index()];
    }
    let mut borders: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); count];
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| clusters[v.index()]);
        if a != b {
            *borders[a as usize].entry(b).or_default() += geometry.edge_length(e);
            *borders[b as usize].entry(a).or_default() += geometry.edge_length(e);
        }
    }
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by(|&a, &b| cluster_areas[a as usize].total_cmp(&cluster_areas[b as usize]));
    let mut targets: Vec<u32> = (0..count as u32).collect();
    for small in order {
        if stays(small, cluster_areas[small as usize]) {
            continue;
        }
        let own = std::mem::take(&mut borders[small as usize]);
        let longest = own.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
        let Some((&target, _)) = longest else { continue };
        for (&neighbour, &length) in &own {
            borders[neighbour as usize].remove(&small);
            if neighbour != target {
                *borders[neighbour as usize].entry(target).or_default() += length;
                *borders[target as usize].entry(neighbour).or_default() += length;
            }
        }
        cluster_areas[target as usize] += std::mem::take(&mut cluster_areas[small as usize]);
        targets[small as usize] = target;
    }
    let end = |mut cluster: u32| {
        while targets[cluster as usize] != cluster {
            cluster = targets[cluster as usize];
        }
        cluster
    };
    (0..count as u32).map(end).collect()
}

/// Numbers the values that occur from 0, in their order.
pub(super) fn compact(labels: &[u32]) -> Vec<u32> {
    let mut values = labels.to_vec();
    values.sort_unstable();
    values.dedup();
    labels.iter().map(|label| values.partition_point(|v| v < label) as u32).collect()
}

/// Gives clusters labels so that neighbours differ, and neighbours of neighbours too where `regions` labels suffice. Uses
/// further labels rather than let two neighbours melt.
pub(super) fn colour(mesh: &Mesh, clusters: &[u32], regions: u32) -> Vec<u32> {
    let count = clusters.iter().max().map_or(0, |&c| c as usize + 1);
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); count];
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| clusters[v.index()]);
        if a != b {
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    let mut colours = vec![NONE; count];
    let mut uses: Vec<u32> = vec![0; regions as usize];
    for &cluster in clusters {
        if colours[cluster as usize] != NONE {
            continue;
        }
        let near = &neighbours[cluster as usize];
        let is_near = |c: u32| near.iter().any(|&n| colours[n as usize] == c);
        let is_second = |c: u32| {
            near.iter().any(|&n| neighbours[n as usize].iter().any(|&m| colours[m as usize] == c))
        };
        let pick = |taken: &dyn Fn(u32) -> bool| {
            (0..uses.len() as u32).filter(|&c| !taken(c)).min_by_key(|&c| (uses[c as usize], c))
        };
        let colour = pick(&|c| is_near(c) || is_second(c))
            .or_else(|| pick(&is_near))
            .unwrap_or(uses.len() as u32);
        if colour as usize == uses.len() {
            uses.push(0);
        }
        uses[colour as usize] += 1;
        colours[cluster as usize] = colour;
    }
    clusters.iter().map(|&c| colours[c as usize]).collect()
}
