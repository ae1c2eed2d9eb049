//! Where a weight is positive, in whole faces and connected parts.
//!
//! A vertex with a positive weight has all its faces in the domain, and they hang together around it. So a weight lives on one component
//! only, and components as charts of their own share it without changing any sum.

use super::{AtlasNotice, AtlasParams};
use crate::flatten::small;
use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh, VertexId};

/// A component of the domain of a weight array.
pub(super) struct Domain {
    /// The weight array.
    pub source: usize,
    /// In increasing order.
    pub faces: Vec<FaceId>,
    /// ∫ χ / area of the surface.
    pub share: f64,
}

/// The domains of all weight arrays, and their weights without those of what was given up, divided by their sums.
pub(super) fn domains(
    mesh: &Mesh,
    geometry: &Geometry,
    weights: &mut [Vec<f64>],
    params: &AtlasParams,
    notices: &mut Vec<AtlasNotice>,
) -> Vec<Domain> {
    let mut all: Vec<Domain> = Vec::new();
    let total: f64 = geometry.face_areas.iter().sum();
    for (source, array) in weights.iter().enumerate() {
        all.extend(components(mesh, array).into_iter().map(|faces| {
            let integral = |f: &FaceId| {
                let sum: f64 = mesh.face_vertices(*f).iter().map(|v| array[v.index()]).sum();
                geometry.face_areas[f.index()] * sum / 3.0
            };
            Domain { source, share: faces.iter().map(integral).sum::<f64>() / total, faces }
        }));
    }
    let mut order: Vec<usize> =
        (0..all.len()).filter(|&i| all[i].share < params.least_share).collect();
    order.sort_by(|&i, &j| all[i].share.total_cmp(&all[j].share).then(i.cmp(&j)));
    let mut gave_up = vec![(0, 0.0); weights.len()];
    let mut is_gone = vec![false; all.len()];
    for i in order {
        is_gone[i] = give_up(mesh, weights, &all[i]);
        if is_gone[i] {
            gave_up[all[i].source].0 += 1;
            gave_up[all[i].source].1 += all[i].share;
        }
    }
    let mut gone = is_gone.into_iter();
    all.retain(|_| gone.next() == Some(false));
    normalise(mesh, weights);
    for (source, (components, share)) in gave_up.into_iter().enumerate() {
        if components > 0 {
            notices.push(AtlasNotice::GaveUp { source, components, share });
        }
        match all.iter().filter(|d| d.source == source).count() {
            0 => notices.push(AtlasNotice::Vanished { source }),
            1 => {}
            charts => notices.push(AtlasNotice::Parted { source, charts }),
        }
    }
    all
}

/// The faces with a positive weight at some corner, by components across edges, each in increasing order.
fn components(mesh: &Mesh, weights: &[f64]) -> Vec<Vec<FaceId>> {
    let is_in = |f: FaceId| mesh.face_vertices(f).iter().any(|v| weights[v.index()] > 0.0);
    let mut waits: Vec<bool> = mesh.faces().map(is_in).collect();
    let mut components = Vec::new();
    for start in mesh.faces() {
        if !std::mem::take(&mut waits[start.index()]) {
            continue;
        }
        let mut faces = vec![start];
        let mut next = 0;
        while next < faces.len() {
            for h in mesh.face_halfedges(faces[next]) {
                if let Some(across) = mesh.face(h.twin())
                    && std::mem::take(&mut waits[across.index()])
                {
                    faces.push(across);
                }
            }
            next += 1;
        }
        faces.sort_unstable();
        components.push(faces);
    }
    components
}

/// Takes the weight of a component away if others are left wherever it has any; says whether it did.
fn give_up(mesh: &Mesh, weights: &mut [Vec<f64>], domain: &Domain) -> bool {
    let own = |weights: &[Vec<f64>], v: VertexId| weights[domain.source][v.index()];
    let mut vertices: Vec<VertexId> =
        domain.faces.iter().flat_map(|&f| mesh.face_vertices(f)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.retain(|&v| own(weights, v) > 0.0);
    let is_covered = |&v: &VertexId| {
        let others = weights.iter().enumerate().filter(|(i, _)| *i != domain.source);
        others.map(|(_, array)| array[v.index()]).sum::<f64>() > 0.0
    };
    let can = vertices.iter().all(is_covered);
    for v in vertices.into_iter().filter(|_| can) {
        weights[domain.source][v.index()] = 0.0;
    }
    can
}

fn normalise(mesh: &Mesh, weights: &mut [Vec<f64>]) {
    for v in mesh.vertices() {
        let sum: f64 = weights.iter().map(|array| array[v.index()]).sum();
        if sum > 0.0 {
            weights.iter_mut().for_each(|array| array[v.index()] /= sum);
        }
    }
}

impl Domain {
    /// The domain as a surface of its own: triangles, and the vertex of the surface of each of its vertices.
    ///
    /// Where parts of it touch in a vertex alone, each gets a copy: corners are one vertex if a fan of faces joins them.
    pub(super) fn surface(&self, mesh: &Mesh) -> (Vec<[u32; 3]>, Vec<VertexId>) {
        let number = |f: FaceId| self.faces.binary_search(&f).ok();
        let mut parents: Vec<usize> = (0..3 * self.faces.len()).collect();
        for (i, &f) in self.faces.iter().enumerate() {
            for h in mesh.face_halfedges(f) {
                let Some(across) = mesh.face(h.twin()) else { continue };
                let Some(j) = number(across).filter(|&j| j > i) else { continue };
                for v in [mesh.tail(h), mesh.tip(h)] {
                    let corner = |f: FaceId| mesh.face_vertices(f).iter().position(|&w| w == v);
                    if let (Some(a), Some(b)) = (corner(f), corner(across)) {
                        let [a, b] = [3 * i + a, 3 * j + b].map(|c| root(&mut parents, c));
                        parents[a.max(b)] = a.min(b);
                    }
                }
            }
        }
        let mut numbers = vec![u32::MAX; parents.len()];
        let mut vertices = Vec::new();
        let mut triangles = Vec::with_capacity(self.faces.len());
        for (i, &f) in self.faces.iter().enumerate() {
            let corners = mesh.face_vertices(f);
            triangles.push([0, 1, 2].map(|c| {
                let first = root(&mut parents, 3 * i + c);
                if numbers[first] == u32::MAX {
                    numbers[first] = small(vertices.len());
                    vertices.push(corners[c]);
                }
                numbers[first]
            }));
        }
        (triangles, vertices)
    }
}

fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}
