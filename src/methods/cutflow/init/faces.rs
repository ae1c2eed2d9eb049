//! From one region for each face to one label for each vertex.
//!
//! Regions of faces meet along edges, those of a cut along vertices' halves. A vertex whose faces are all of one region
//! belongs to it; one on a border goes where most of its area lies. That may tear a narrow region, which is mended with the
//! shortest ways through its own border vertices.

use std::collections::VecDeque;

use super::clusters::{absorb, compact, pieces};
use super::{Levels, Start, out_of_range};
use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh, VertexId};
use crate::methods::flow::SolveError;

const NONE: u32 = u32::MAX;

/// How far inside its region a vertex on a border counts, in mean edge lengths; others half an edge. The cut follows the
/// given border within a tenth of an edge.
const ON_BORDER: f64 = 0.05;

/// The labels of face regions, numbered in the order of the given values.
///
/// **Gives** in `lost` the value of every connected region of faces that no vertex is left for.
pub(super) fn faces(
    mesh: &Mesh,
    geometry: &Geometry,
    regions: &[u32],
) -> Result<Start, SolveError> {
    if regions.len() != mesh.face_count() {
        let count = mesh.face_count() as f64;
        return Err(out_of_range("number of face regions", regions.len() as f64, count, count));
    }
    let parts = Parts::new(mesh, regions);
    let (mut owners, is_inner) = majority(mesh, geometry, &parts);
    mend(mesh, geometry, &parts, &is_inner, &mut owners);

    // What is still in pieces keeps its largest one and those with something inside.
    let (clusters, count) = pieces(mesh, &owners);
    let areas = geometry.vertex_dual_areas(mesh);
    let mut cluster_areas = vec![0.0; count];
    let mut cluster_owners = vec![0; count];
    let mut stays = vec![false; count];
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        let cluster = clusters[v.index()] as usize;
        cluster_areas[cluster] += areas[v.index()];
        cluster_owners[cluster] = owners[v.index()];
        stays[cluster] |= is_inner[v.index()];
    }
    let mut largest = vec![NONE; parts.values.len()];
    for cluster in 0..count as u32 {
        let best = &mut largest[cluster_owners[cluster as usize] as usize];
        if *best == NONE || cluster_areas[cluster as usize] > cluster_areas[*best as usize] {
            *best = cluster;
        }
    }
    for &cluster in largest.iter().filter(|c| **c != NONE) {
        stays[cluster as usize] = true;
    }
    let ends = absorb(mesh, geometry, &clusters, count, |c, _| stays[c as usize]);
    let mut values = Vec::with_capacity(mesh.vertex_count());
    let mut is_alive = vec![false; parts.values.len()];
    for &cluster in &clusters {
        let owner = cluster_owners[ends[cluster as usize] as usize];
        is_alive[owner as usize] = true;
        values.push(parts.values[owner as usize]);
    }
    let lost = parts.values.iter().zip(is_alive).filter(|(_, alive)| !alive);
    let lost: Vec<u32> = lost.map(|(&value, _)| value).collect();
    let mean_edge = geometry.mean_edge_length();
    let magnitude = |&inner: &bool| if inner { 0.5 * mean_edge } else { ON_BORDER * mean_edge };
    let magnitudes = is_inner.iter().map(magnitude).collect();
    Ok(Start { lost, ..Start::new(compact(&values), Levels::Vertex(magnitudes)) })
}

/// Connected regions of faces.
struct Parts {
    of_faces: Vec<u32>,
    /// The given value of each.
    values: Vec<u32>,
}

impl Parts {
    fn new(mesh: &Mesh, regions: &[u32]) -> Self {
        let mut of_faces = vec![NONE; regions.len()];
        let mut values = Vec::new();
        let mut stack = Vec::new();
        for seed in mesh.faces() {
            if of_faces[seed.index()] != NONE {
                continue;
            }
            let part = values.len() as u32;
            values.push(regions[seed.index()]);
            of_faces[seed.index()] = part;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                for g in mesh.face_halfedges(f).into_iter().filter_map(|h| mesh.face(h.twin())) {
                    if of_faces[g.index()] == NONE && regions[g.index()] == regions[f.index()] {
                        of_faces[g.index()] = part;
                        stack.push(g);
                    }
                }
            }
        }
        Self { of_faces, values }
    }

    fn at(&self, f: FaceId) -> u32 {
        self.of_faces[f.index()]
    }
}

/// For each vertex the part with most of the area around it, and whether there is no other.
fn majority(mesh: &Mesh, geometry: &Geometry, parts: &Parts) -> (Vec<u32>, Vec<bool>) {
    let mut owners = vec![0; mesh.vertex_count()];
    let mut is_inner = vec![true; mesh.vertex_count()];
    let mut shares: Vec<(u32, f64)> = Vec::new();
    for v in mesh.vertices() {
        shares.clear();
        for f in mesh.outgoing(v).filter_map(|h| mesh.face(h)) {
            let (part, area) = (parts.at(f), geometry.face_areas[f.index()]);
            match shares.iter_mut().find(|s| s.0 == part) {
                Some(share) => share.1 += area,
                None => shares.push((part, area)),
            }
        }
        let largest = shares.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        if let Some(&(part, _)) = largest {
            owners[v.index()] = part;
        }
        is_inner[v.index()] = shares.len() <= 1;
    }
    (owners, is_inner)
}

/// Joins the pieces of each part by ways through its border vertices, the smallest part first.
///
/// Inner vertices of other parts are never taken, nor what joins a part already.
fn mend(mesh: &Mesh, geometry: &Geometry, parts: &Parts, is_inner: &[bool], owners: &mut [u32]) {
    let mut part_areas = vec![0.0; parts.values.len()];
    for (part, area) in parts.of_faces.iter().zip(&geometry.face_areas) {
        part_areas[*part as usize] += area;
    }
    let mut part_faces: Vec<Vec<FaceId>> = vec![Vec::new(); parts.values.len()];
    for f in mesh.faces() {
        part_faces[parts.at(f) as usize].push(f);
    }
    let mut order: Vec<u32> = (0..parts.values.len() as u32).collect();
    order.sort_by(|&a, &b| {
        part_areas[a as usize].total_cmp(&part_areas[b as usize]).then(a.cmp(&b))
    });
    let mut is_taken = vec![false; owners.len()];
    // Piece of each vertex of the part at hand, and the vertex that its search came from.
    let mut piece = vec![NONE; owners.len()];
    let mut from = vec![NONE; owners.len()];
    for part in order {
        let mut vertices: Vec<VertexId> =
            part_faces[part as usize].iter().flat_map(|&f| mesh.face_vertices(f)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut sizes: Vec<usize> = Vec::new();
        let mut stack = Vec::new();
        for &seed in &vertices {
            if owners[seed.index()] != part || piece[seed.index()] != NONE {
                continue;
            }
            let number = sizes.len() as u32;
            sizes.push(0);
            piece[seed.index()] = number;
            stack.push(seed);
            while let Some(v) = stack.pop() {
                sizes[number as usize] += 1;
                for w in mesh.outgoing(v).map(|h| mesh.tip(h)) {
                    if owners[w.index()] == part && piece[w.index()] == NONE {
                        piece[w.index()] = number;
                        stack.push(w);
                    }
                }
            }
        }
        if sizes.len() > 1 {
            let largest = (0..sizes.len()).fold(0, |b, i| if sizes[i] > sizes[b] { i } else { b });
            let mut is_joined = vec![false; sizes.len()];
            is_joined[largest] = true;
            let mut queue = VecDeque::new();
            for &v in vertices.iter().filter(|v| piece[v.index()] == largest as u32) {
                from[v.index()] = v.0;
                queue.push_back(v);
            }
            while let Some(v) = queue.pop_front() {
                for h in mesh.outgoing(v) {
                    // Along edges of the part's faces only.
                    let sides = [mesh.face(h), mesh.face(h.twin())];
                    let w = mesh.tip(h);
                    let is_open =
                        owners[w.index()] == part || (!is_taken[w.index()] && !is_inner[w.index()]);
                    if from[w.index()] != NONE
                        || !is_open
                        || !sides.into_iter().flatten().any(|f| parts.at(f) == part)
                    {
                        continue;
                    }
                    from[w.index()] = v.0;
                    queue.push_back(w);
                    let reached = piece[w.index()];
                    if reached != NONE && !std::mem::replace(&mut is_joined[reached as usize], true)
                    {
                        let mut at = w;
                        while from[at.index()] != at.0 {
                            at = VertexId(from[at.index()]);
                            if owners[at.index()] != part {
                                owners[at.index()] = part;
                                is_taken[at.index()] = true;
                            }
                        }
                    }
                }
            }
        }
        for v in vertices {
            piece[v.index()] = NONE;
            from[v.index()] = NONE;
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// A square of n × n cells, each halved.
    fn sheet(n: u32) -> (Mesh, Geometry) {
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let mut triangles = Vec::new();
        for j in 0..n {
            for i in 0..n {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        let mesh = Mesh::new(((n + 1) * (n + 1)) as usize, &triangles).unwrap();
        let positions = (0..=n)
            .flat_map(|j| (0..=n).map(move |i| Point3::new(f64::from(i), f64::from(j), 0.0)))
            .collect();
        let geometry = Geometry::new(&mesh, positions).unwrap();
        (mesh, geometry)
    }

    /// Two faces for each cell (i, j).
    fn regions(n: u32, value: impl Fn(u32, u32) -> u32) -> Vec<u32> {
        (0..n * n).flat_map(|cell| [value(cell % n, cell / n); 2]).collect()
    }

    #[test]
    fn halves_stay_halves_and_labels_follow_the_values() {
        let (mesh, geometry) = sheet(8);
        let start = faces(&mesh, &geometry, &regions(8, |i, _| if i < 4 { 7 } else { 3 })).unwrap();
        assert!(start.lost.is_empty());
        for (v, &label) in start.labels.iter().enumerate() {
            match v % 9 {
                0..=3 => assert_eq!(label, 1),
                5.. => assert_eq!(label, 0),
                _ => {}
            }
        }
    }

    #[test]
    fn a_strip_one_face_wide_stays_in_one_piece() {
        let (mesh, geometry) = sheet(12);
        // Two blocks joined by one row of cells, which has no vertex of its own.
        let joined =
            |i: u32, j: u32| u32::from((1..4).contains(&i) || (8..11).contains(&i) || j == 6);
        let start = faces(&mesh, &geometry, &regions(12, joined)).unwrap();
        let ones: Vec<u32> = start.labels.iter().map(|&l| u32::from(l != 1)).collect();
        let (clusters, _) = pieces(&mesh, &ones);
        let mut found: Vec<u32> =
            clusters.iter().zip(&ones).filter(|(_, o)| **o == 0).map(|(c, _)| *c).collect();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), 1);
    }

    #[test]
    fn a_region_of_one_face_among_larger_ones_is_lost_and_named() {
        let (mesh, geometry) = sheet(6);
        let mut values = regions(6, |i, _| u32::from(i >= 3));
        values[14] = 9;
        let start = faces(&mesh, &geometry, &values).unwrap();
        assert_eq!(start.lost, [9]);
        assert_eq!(start.labels.iter().max(), Some(&1));
    }

    #[test]
    fn every_region_with_a_vertex_inside_survives() {
        let (mesh, geometry) = sheet(12);
        // Blocks of two by two cells have exactly one vertex inside.
        let start = faces(&mesh, &geometry, &regions(12, |i, j| 6 * (j / 2) + i / 2)).unwrap();
        assert!(start.lost.is_empty());
        assert_eq!(start.labels.iter().max(), Some(&35));
    }
}
