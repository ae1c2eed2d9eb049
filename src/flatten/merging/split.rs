//! Splits charts that fail by the normals of their faces: two proxies, flooded and fitted in turn.

use std::collections::BinaryHeap;

use nalgebra::Vector3;

use crate::flatten::small;
use crate::mesh::{EdgeId, FaceId, HalfedgeId, Mesh};

/// Floods; the border stands still after a few.
const FLOODS: usize = 8;

/// The largest error comes last, ties by number of entry.
struct Entry {
    error: f64,
    order: u32,
    face: u32,
    region: u8,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.error.total_cmp(&self.error).then(other.order.cmp(&self.order))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Two connected halves of a chart, both connected otherwise than across edges that `parts` accepts. None for a chart of one face.
///
/// **Minimises**, by turns, Σ A |n − N|² over the halves, N the normalised mean normal of each. **Costs** O(F log F).
pub fn bisect(
    mesh: &Mesh,
    normals: &[Vector3<f64>],
    areas: &[f64],
    faces: &[FaceId],
    parts: impl Fn(EdgeId) -> bool,
) -> Option<[Vec<FaceId>; 2]> {
    if faces.len() < 2 {
        return None;
    }
    let mut local = std::collections::BTreeMap::new();
    for (i, &f) in faces.iter().enumerate() {
        local.insert(f, small(i));
    }
    let neighbours: Vec<[Option<u32>; 3]> = faces
        .iter()
        .map(|&f| {
            let across = |h: HalfedgeId| mesh.face(h.twin()).filter(|_| !parts(h.edge()));
            mesh.face_halfedges(f).map(|h| across(h).and_then(|g| local.get(&g).copied()))
        })
        .collect();
    let normal = |i: usize| normals[faces[i].index()];
    let error = |i: usize, proxy: &Vector3<f64>| {
        areas[faces[i].index()] * (normal(i) - proxy).norm_squared()
    };
    let mean: Vector3<f64> = (0..faces.len()).map(|i| normal(i) * areas[faces[i].index()]).sum();
    let farthest = |from: &Vector3<f64>, but: usize| {
        let mut best = (f64::NEG_INFINITY, 0);
        for i in (0..faces.len()).filter(|&i| i != but) {
            let off = (normal(i) - from).norm_squared();
            if off > best.0 {
                best = (off, i);
            }
        }
        best.1
    };
    let first = farthest(&mean.try_normalize(0.0).unwrap_or_default(), usize::MAX);
    let mut seeds = [first, farthest(&normal(first), first)];
    let mut regions = vec![u8::MAX; faces.len()];
    for round in 0..FLOODS {
        let mut proxies = seeds.map(normal);
        if round > 0 {
            for (region, proxy) in proxies.iter_mut().enumerate() {
                let sum: Vector3<f64> = (0..faces.len())
                    .filter(|&i| usize::from(regions[i]) == region)
                    .map(|i| normal(i) * areas[faces[i].index()])
                    .sum();
                *proxy = sum.try_normalize(0.0).unwrap_or(*proxy);
                let mut best = (f64::INFINITY, seeds[region]);
                for i in (0..faces.len()).filter(|&i| usize::from(regions[i]) == region) {
                    let off = (normal(i) - *proxy).norm_squared();
                    if off < best.0 {
                        best = (off, i);
                    }
                }
                seeds[region] = best.1;
            }
        }
        regions.fill(u8::MAX);
        let mut queue = BinaryHeap::new();
        let mut order = 0;
        for region in 0..2u8 {
            let face = small(seeds[usize::from(region)]);
            queue.push(Entry { error: -1.0, order, face, region });
            order += 1;
        }
        while let Some(Entry { face, region, .. }) = queue.pop() {
            let i = face as usize;
            if regions[i] != u8::MAX {
                continue;
            }
            regions[i] = region;
            for g in neighbours[i].iter().flatten().copied() {
                if regions[g as usize] == u8::MAX {
                    let error = error(g as usize, &proxies[usize::from(region)]);
                    queue.push(Entry { error, order, face: g, region });
                    order += 1;
                }
            }
        }
    }
    let half = |region: u8| {
        let of = |(f, r): (&FaceId, &u8)| (*r == region).then_some(*f);
        faces.iter().zip(&regions).filter_map(of).collect::<Vec<FaceId>>()
    };
    let halves = [half(0), half(1)];
    halves.iter().all(|h| !h.is_empty()).then_some(halves)
}
