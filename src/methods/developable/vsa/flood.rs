//! Flooding: faces join the region whose proxy their normal is nearest to, nearest first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Vector3;

use crate::geometry::Geometry;
use crate::mesh::Mesh;

/// No face, no region.
pub(super) const NONE: u32 = u32::MAX;

/// What flooding reads of a surface, and its queue.
pub(super) struct Flood {
    /// Of each face the faces across its sides.
    pub neighbours: Vec<[u32; 3]>,
    /// Unit normals; 0 where a face has none.
    pub normals: Vec<Vector3<f64>>,
    pub areas: Vec<f64>,
    pub total_area: f64,
    queue: BinaryHeap<Reverse<Candidate>>,
}

/// A face that a region could take.
#[derive(PartialEq)]
struct Candidate {
    error: f64,
    face: u32,
    region: u32,
}

impl Eq for Candidate {}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let ids = |c: &Self| (c.face, c.region);
        self.error.total_cmp(&other.error).then_with(|| ids(self).cmp(&ids(other)))
    }
}

impl Flood {
    pub fn new(mesh: &Mesh, geometry: &Geometry) -> Self {
        let across = |f| mesh.face_halfedges(f).map(|h| mesh.face(h.twin()).map_or(NONE, |g| g.0));
        let proper = |n: Vector3<f64>| if n.norm().is_finite() { n } else { Vector3::zeros() };
        Self {
            neighbours: mesh.faces().map(across).collect(),
            normals: geometry.face_normals(mesh).into_iter().map(proper).collect(),
            areas: geometry.face_areas.clone(),
            total_area: geometry.total_area(),
            queue: BinaryHeap::new(),
        }
    }

    /// |n − N|².
    pub fn distance(&self, face: u32, proxy: &Vector3<f64>) -> f64 {
        (self.normals[face as usize] - proxy).norm_squared()
    }

    /// The error that a face adds.
    pub fn error(&self, face: u32, proxy: &Vector3<f64>) -> f64 {
        self.areas[face as usize] * self.distance(face, proxy)
    }

    /// Gives every face without a region (`NONE`) one, from the seeds of some regions. Faces that have one stand in the way.
    ///
    /// **Takes** seeds that have no region yet, each for its region.
    pub fn run(
        &mut self,
        charts: &mut [u32],
        seeds: impl Iterator<Item = (u32, u32)>,
        proxies: &[Vector3<f64>],
    ) {
        let mut queue = std::mem::take(&mut self.queue);
        for (face, region) in seeds {
            // Below all errors: no seed is taken by another region.
            queue.push(Reverse(Candidate { error: -1.0, face, region }));
        }
        while let Some(Reverse(Candidate { face, region, .. })) = queue.pop() {
            if charts[face as usize] != NONE {
                continue;
            }
            charts[face as usize] = region;
            for next in self.neighbours[face as usize] {
                if next != NONE && charts[next as usize] == NONE {
                    let error = self.error(next, &proxies[region as usize]);
                    queue.push(Reverse(Candidate { error, face: next, region }));
                }
            }
        }
        self.queue = queue;
    }
}
