//! Geodesic Voronoi cells: of vertices that were chosen, or drawn.

use super::clusters::{absorb, colour, pieces};
use super::noise::uniform;
use super::{Levels, Start, out_of_range, two_regions};
use crate::geometry::{GeodesicFront, Geometry, geodesic_distances};
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Radius of the circle around a seed that is alone, unless its component is too small for it: then half the way to the
/// farthest vertex. The side of a square of the surface's area is 1.
pub(super) const SEED_RADIUS: f64 = 0.3;

/// Places drawn for each random cell; the one farthest from the cells before is taken. One leaves cells of very different
/// size, a hundred would make a nearly regular pattern of them.
const DRAWS: usize = 8;

/// Two cells meet where their distances are equal; vertices of the faces that are crossed there are told apart by the
/// distances from both. Twice an edge is the most that they can differ by; the rest covers the error of fast marching.
const REACH: f64 = 3.0;

/// One region for each seed, or a circle around the only one.
pub(super) fn seeds(
    mesh: &Mesh,
    geometry: &Geometry,
    seeds: &[VertexId],
) -> Result<Start, SolveError> {
    for (i, &seed) in seeds.iter().enumerate() {
        super::check_vertex(mesh, seed)?;
        if seeds[..i].contains(&seed) {
            return Err(SolveError::SeedTwice { vertex: seed });
        }
    }
    match seeds {
        [] => Err(out_of_range("number of seeds", 0.0, 1.0, mesh.vertex_count() as f64)),
        [seed] => {
            let distances = geodesic_distances(mesh, geometry, &[*seed]);
            let farthest =
                distances.iter().filter(|d| d.is_finite()).fold(0.0f64, |m, d| m.max(*d));
            let radius = SEED_RADIUS.min(0.5 * farthest);
            Ok(two_regions(distances.into_iter().map(|d| d.min(1e3) - radius).collect()))
        }
        _ => {
            let cells = Cells::new(mesh, geometry, seeds);
            let mut has_vertices = vec![false; seeds.len()];
            for &cell in &cells.owners {
                has_vertices[cell as usize] = true;
            }
            let lost = (0..seeds.len() as u32).filter(|&k| !has_vertices[k as usize]).collect();
            let labels = cells.owners.clone();
            Ok(Start { lost, ..cells.start(labels, |cell| cell) })
        }
    }
}

/// Cells of drawn vertices with a number of labels.
pub(super) fn random(
    mesh: &Mesh,
    geometry: &Geometry,
    regions: u32,
    cells: u32,
    seed: u64,
) -> Result<Start, SolveError> {
    let used = mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()).count();
    if cells < 2 || cells as usize > used {
        return Err(out_of_range("number of cells", f64::from(cells), 2.0, used as f64));
    }
    if regions < 2 || regions > cells {
        let (value, max) = (f64::from(regions), f64::from(cells));
        return Err(out_of_range("number of labels", value, 2.0, max));
    }
    let seeds = spread_vertices(mesh, geometry, cells, seed);
    let cells = Cells::new(mesh, geometry, &seeds);
    let mut cell_labels = vec![0; seeds.len()];
    let labels = colour(mesh, &cells.owners, regions);
    for (&cell, &label) in cells.owners.iter().zip(&labels) {
        cell_labels[cell as usize] = label;
    }
    Ok(cells.start(labels, |cell| cell_labels[cell as usize]))
}

/// Draws vertices by area, each the farthest from those before of [`DRAWS`] tries.
fn spread_vertices(mesh: &Mesh, geometry: &Geometry, count: u32, seed: u64) -> Vec<VertexId> {
    let mut sums = geometry.vertex_dual_areas(mesh);
    let mut total = 0.0;
    for sum in &mut sums {
        total += *sum;
        *sum = total;
    }
    let mut state = seed;
    let mut distances = vec![f64::INFINITY; mesh.vertex_count()];
    let mut front = GeodesicFront::new(mesh.vertex_count());
    let mut chosen = Vec::with_capacity(count as usize);
    let is_used = |v: &VertexId| mesh.halfedge(*v).is_some();
    let farther = |distances: &[f64], a: VertexId, b: VertexId| {
        distances[a.index()].total_cmp(&distances[b.index()]).then(b.cmp(&a))
    };
    for _ in 0..count {
        let draws = (0..DRAWS).map(|_| {
            let wanted = uniform(&mut state) * total;
            VertexId::from(sums.partition_point(|&s| s <= wanted).min(sums.len() - 1))
        });
        let drawn: Vec<VertexId> = draws.filter(is_used).collect();
        let best = drawn.into_iter().max_by(|&a, &b| farther(&distances, a, b));
        let next = best.filter(|v| distances[v.index()] > 0.0).or_else(|| {
            // All tries hit cells that are there already.
            mesh.vertices().filter(is_used).max_by(|&a, &b| farther(&distances, a, b))
        });
        let Some(next) = next else { break };
        chosen.push(next);
        front.spread(mesh, geometry, &[(next, 0.0)], |v, d| d < distances[v.index()]);
        for &v in front.reached() {
            let distance = &mut distances[v.index()];
            *distance = distance.min(front.distance(v));
        }
    }
    chosen
}

/// Which cell every vertex belongs to, and the distances from the seeds of the cells nearby.
struct Cells {
    owners: Vec<u32>,
    /// Vertex, cell and distance, ordered.
    near: Vec<(u32, u32, f64)>,
}

impl Cells {
    fn new(mesh: &Mesh, geometry: &Geometry, seeds: &[VertexId]) -> Self {
        let mut limits = geodesic_distances(mesh, geometry, seeds);
        for v in mesh.vertices() {
            let edges = mesh.outgoing(v).map(|h| geometry.edge_length(h.edge()));
            limits[v.index()] += REACH * edges.fold(0.0, f64::max);
        }
        let mut front = GeodesicFront::new(mesh.vertex_count());
        let mut near: Vec<(u32, u32, f64)> = Vec::new();
        for (k, &seed) in seeds.iter().enumerate() {
            front.spread(mesh, geometry, &[(seed, 0.0)], |v, d| d <= limits[v.index()]);
            for &v in front.reached().iter().filter(|&&v| front.distance(v) <= limits[v.index()]) {
                near.push((v.0, k as u32, front.distance(v)));
            }
        }
        near.sort_unstable_by_key(|&(v, cell, _)| (v, cell));
        let mut owners = vec![0; mesh.vertex_count()];
        for at_vertex in near.chunk_by(|a, b| a.0 == b.0) {
            // The first of equals, so that the lower cell wins a tie.
            if let Some(nearest) = at_vertex.iter().min_by(|a, b| a.2.total_cmp(&b.2)) {
                owners[nearest.0 as usize] = nearest.1;
            }
        }
        // Rounding, or a component without any seed, may leave a vertex apart from its seed: it goes to a neighbour.
        let (clusters, count) = pieces(mesh, &owners);
        let mut has_seed = vec![false; count];
        let mut cluster_owners = vec![0; count];
        for (k, seed) in seeds.iter().enumerate() {
            has_seed[clusters[seed.index()] as usize] |= owners[seed.index()] == k as u32;
        }
        for (&cluster, &owner) in clusters.iter().zip(&owners) {
            cluster_owners[cluster as usize] = owner;
        }
        let ends = absorb(mesh, geometry, &clusters, count, |c, _| has_seed[c as usize]);
        for (owner, &cluster) in owners.iter_mut().zip(&clusters) {
            *owner = cluster_owners[ends[cluster as usize] as usize];
        }
        Self { owners, near }
    }

    /// Level sets φ_k = d_k − (d_1 + d_2)/2 with the two smallest d: differences are those of the distances.
    fn start(self, labels: Vec<u32>, label_of: impl Fn(u32) -> u32) -> Start {
        let mut entries: Vec<(u32, u32, f64)> = Vec::with_capacity(self.near.len());
        for at_vertex in self.near.chunk_by(|a, b| a.0 == b.0) {
            let first = entries.len();
            for &(v, cell, distance) in at_vertex {
                let label = label_of(cell);
                match entries[first..].iter_mut().find(|e| e.1 == label) {
                    Some(known) => known.2 = known.2.min(distance),
                    None => entries.push((v, label, distance)),
                }
            }
            let (mut least, mut second) = (f64::INFINITY, f64::INFINITY);
            for entry in &entries[first..] {
                second = second.min(entry.2.max(least));
                least = least.min(entry.2);
            }
            if entries.len() - first < 2 {
                // Far from any border: nothing to tell.
                entries.truncate(first);
            }
            for entry in &mut entries[first..] {
                entry.2 -= 0.5 * (least + second);
            }
        }
        let mut starts = vec![0; labels.len() + 1];
        for entry in &entries {
            starts[entry.0 as usize + 1] += 1;
        }
        for v in 0..labels.len() {
            starts[v + 1] += starts[v];
        }
        let entries = entries.into_iter().map(|(_, label, value)| (label, value)).collect();
        Start::new(labels, Levels::Label { starts, entries })
    }
}
