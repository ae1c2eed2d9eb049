//! Initial cuts.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use crate::geometry::{Geometry, Laplacian, geodesic_distances};
use crate::linalg::{Analysis, Factor, LinalgError};
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Where a run starts. Places and lengths are those of the unit-area geometry.
#[derive(Clone, Debug, PartialEq)]
pub enum Initial {
    /// Two regions, on either side of a plane.
    Plane {
        /// A point of the plane.
        point: Point3<f64>,
        /// Its normal, of any length; region 0 lies behind it.
        normal: Vector3<f64>,
    },
    /// Two regions, inside (0) and outside a geodesic circle.
    Circle {
        /// Its centre.
        vertex: VertexId,
        /// Its geodesic radius.
        radius: f64,
    },
    /// Connected clusters of vertices whose normals differ from a seed's by less than an angle, coloured with a number of
    /// labels so that clusters near one another differ.
    NormalClusters {
        /// Largest angle to the seed's normal, radians.
        angle: f64,
        /// Number of labels.
        regions: u32,
    },
    /// Two regions: the sign of a function given at the vertices, region 0 where it is negative.
    Levels(Vec<f64>),
    /// One label for each vertex.
    Labels(Vec<u32>),
}

/// Labels and, with two regions, how far each vertex lies from the cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// One label for each vertex.
    pub labels: Vec<u32>,
    levels: Option<Vec<f64>>,
}

impl Start {
    /// |φ| at a vertex: of the given function, or half an edge, which puts crossings at the middle of edges.
    pub(super) fn magnitude(&self, v: VertexId, mean_edge: f64) -> f64 {
        self.levels.as_ref().map_or(0.5 * mean_edge, |levels| levels[v.index()].abs())
    }
}

/// The labels that an initial cut gives.
///
/// **Fails** if a plane has no normal, a radius or angle makes no sense, or an array has the wrong length.
pub fn initial_labels(
    mesh: &Mesh,
    geometry: &Geometry,
    initial: &Initial,
) -> Result<Start, SolveError> {
    let two_regions = |levels: Vec<f64>| Start {
        labels: levels.iter().map(|&x| u32::from(x >= 0.0)).collect(),
        levels: Some(levels),
    };
    match initial {
        Initial::Plane { point, normal } => {
            let length = normal.norm();
            let Some(normal) = normal.try_normalize(1e-300) else {
                return Err(out_of_range("plane normal length", length, 0.0));
            };
            let levels = geometry.positions.iter().map(|p| (p - point).dot(&normal)).collect();
            Ok(two_regions(levels))
        }
        Initial::Circle { vertex, radius } => {
            if !(*radius > 0.0 && radius.is_finite()) {
                return Err(out_of_range("circle radius", *radius, 0.0));
            }
            let distances = geodesic_distances(mesh, geometry, &[*vertex]);
            // Other components lie outside, far away but at a finite distance.
            Ok(two_regions(distances.into_iter().map(|d| d.min(1e3) - radius).collect()))
        }
        Initial::NormalClusters { angle, regions } => {
            if !(*angle > 0.0 && *angle <= std::f64::consts::PI) {
                return Err(out_of_range("cluster angle", *angle, 0.0));
            }
            let clusters = normal_clusters(mesh, geometry, *angle);
            Ok(Start { labels: colour(mesh, &clusters, *regions), levels: None })
        }
        Initial::Levels(levels) => {
            if levels.len() != mesh.vertex_count() || !levels.iter().all(|x| x.is_finite()) {
                let name = "number of finite level-set values";
                return Err(out_of_range(name, levels.len() as f64, mesh.vertex_count() as f64));
            }
            Ok(two_regions(levels.clone()))
        }
        Initial::Labels(labels) => {
            if labels.len() != mesh.vertex_count() {
                let name = "number of labels";
                return Err(out_of_range(name, labels.len() as f64, mesh.vertex_count() as f64));
            }
            Ok(Start { labels: labels.clone(), levels: None })
        }
    }
}

fn out_of_range(name: &'static str, value: f64, min: f64) -> SolveError {
    SolveError::Parameter { name, value, min, max: f64::MAX }
}

/// Clusters smaller than this fraction of the area join a neighbour: they would vanish in the first steps.
const SMALLEST_CLUSTER: f64 = 2e-3;

/// Grows connected clusters from seeds, each until normals turn away from its seed's by more than `angle`.
///
/// **Gives** a cluster for each vertex, numbered by first vertex.
fn normal_clusters(mesh: &Mesh, geometry: &Geometry, angle: f64) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let normals = geometry.vertex_normals(mesh);
    let areas = geometry.vertex_dual_areas(mesh);
    let least = angle.cos();
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
                if clusters[w.index()] == NONE
                    && normals[w.index()].dot(&normals[seed.index()]) > least
                {
                    clusters[w.index()] = count;
                    queue.push_back(w);
                }
            }
        }
        count += 1;
    }
    let count = count as usize;
    let mut cluster_areas = vec![0.0; count];
    for v in mesh.vertices().filter(|&v| clusters[v.index()] != NONE) {
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
    // Merge the small ones, smallest first, into the neighbour with the longest common border.
    let total: f64 = areas.iter().sum();
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by(|&a, &b| cluster_areas[a as usize].total_cmp(&cluster_areas[b as usize]));
    let mut targets: Vec<u32> = (0..count as u32).collect();
    for small in order {
        if cluster_areas[small as usize] >= SMALLEST_CLUSTER * total {
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
    let merged = |mut cluster: u32| {
        while targets[cluster as usize] != cluster {
            cluster = targets[cluster as usize];
        }
        cluster
    };
    let merged: Vec<u32> = (0..count as u32).map(merged).collect();
    clusters.iter().map(|&c| if c == NONE { 0 } else { merged[c as usize] }).collect()
}

/// Gives clusters labels so that neighbours differ, and neighbours of neighbours too where `regions` labels suffice. Uses
/// further labels rather than let two neighbours melt.
fn colour(mesh: &Mesh, clusters: &[u32], regions: u32) -> Vec<u32> {
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
    const NONE: u32 = u32::MAX;
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

/// Correlation length of the kick for a surface of unit area.
const KICK_LENGTH: f64 = 0.08;

/// S M S ξ with S = (M + ℓ² L)⁻¹ and ξ seeded noise: a smooth random field, the same for the same seed.
pub(super) fn smooth_noise(
    mesh: &Mesh,
    geometry: &Geometry,
    analysis: &Arc<Analysis>,
    seed: u64,
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
    let mut factor = Factor::new(analysis.clone(), &values)?;
    let mut state = seed;
    let mut field: Vec<f64> = (0..mesh.vertex_count()).map(|_| noise(&mut state)).collect();
    factor.solve(&mut field, 1);
    for (x, area) in field.iter_mut().zip(&areas) {
        *x *= area;
    }
    factor.solve(&mut field, 1);
    Ok(field)
}

/// Nearly normal noise: the centred sum of four uniform numbers of a SplitMix64 sequence.
fn noise(state: &mut u64) -> f64 {
    let mut sum = -2.0;
    for _ in 0..4 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        sum += (z >> 11) as f64 / (1u64 << 53) as f64;
    }
    sum
}
