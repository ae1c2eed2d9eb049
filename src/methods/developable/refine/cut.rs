//! The cheapest seam between two charts near the one that there is.

use super::capacity::Capacities;
use crate::mesh::{FaceId, HalfedgeId, Mesh};
use crate::methods::developable::small;
use crate::methods::maxflow::Network;

const NONE: u32 = u32::MAX;

/// Steps of capacity on the dearest edge: sums over all edges of a mesh stay far below 2⁶⁴.
const STEPS: f64 = (1u64 << 30) as f64;

/// A new seam must be cheaper by this fraction: less is rounding of capacities.
const GAIN: f64 = 1e-7;

/// Numbers for the faces of the pair that is worked on. Clean between calls.
#[derive(Clone)]
pub(super) struct Scratch {
    /// How many rings away from the seam; NONE far away.
    rings: Vec<u32>,
    /// Name in the network.
    names: Vec<u32>,
    touched: Vec<FaceId>,
}

/// What a cheaper seam changes.
pub(super) struct Moved {
    /// Faces that change sides.
    pub faces: Vec<FaceId>,
    /// Length of the old seam within the band, and of the new one.
    pub lengths: [f64; 2],
}

impl Scratch {
    pub fn new(faces: usize) -> Self {
        Self { rings: vec![NONE; faces], names: vec![NONE; faces], touched: Vec::new() }
    }

    /// The cheapest seam between two charts within `rings` rings of faces about the present one.
    ///
    /// **Takes** the faces of both. A chart that is all within the rings keeps its innermost ring. **Gives** none if no other seam is cheaper.
    pub fn cheaper(
        &mut self,
        mesh: &Mesh,
        capacities: &Capacities,
        charts: &[u32],
        pair: [u32; 2],
        faces: [&[FaceId]; 2],
        rings: u32,
    ) -> Option<Moved> {
        let moved = self.search(mesh, capacities, charts, pair, faces, rings);
        for f in self.touched.drain(..) {
            self.rings[f.index()] = NONE;
            self.names[f.index()] = NONE;
        }
        moved
    }

    fn search(
        &mut self,
        mesh: &Mesh,
        capacities: &Capacities,
        charts: &[u32],
        pair: [u32; 2],
        faces: [&[FaceId]; 2],
        rings: u32,
    ) -> Option<Moved> {
        let band = self.band(mesh, charts, pair, faces, rings);
        if band.is_empty() {
            return None;
        }
        let is_ours = |f: FaceId| pair.contains(&charts[f.index()]);
        let across = |h: HalfedgeId| mesh.face(h.twin()).filter(|&g| is_ours(g));

        // The band and what lies behind it on either side.
        let mut nodes = band.clone();
        for (i, f) in band.iter().enumerate() {
            self.names[f.index()] = small(i);
        }
        let mut ends: [Vec<u32>; 2] = [Vec::new(), Vec::new()];
        for &f in &band {
            for g in mesh.face_halfedges(f).into_iter().filter_map(across) {
                if self.names[g.index()] == NONE {
                    let name = small(nodes.len());
                    self.names[g.index()] = name;
                    self.touched.push(g);
                    nodes.push(g);
                    ends[usize::from(charts[g.index()] == pair[1])].push(name);
                }
            }
        }
        if ends.iter().any(Vec::is_empty) {
            return None;
        }
        let mut edges = Vec::new();
        for (i, &f) in nodes.iter().enumerate() {
            for h in mesh.face_halfedges(f) {
                let Some(g) = across(h) else { continue };
                let j = self.names[g.index()];
                // Two faces behind the band are joined only where they are on different sides: that seam stays whatever happens.
                let is_inner = i < band.len() || (j as usize) < band.len();
                if j != NONE && small(i) < j && is_inner {
                    edges.push((small(i), j, h.edge()));
                }
            }
        }
        let cost = |e: crate::mesh::EdgeId| capacities.edge_costs[e.index()];
        let dearest = edges.iter().fold(0.0, |most: f64, e| most.max(cost(e.2)));
        if !(dearest > 0.0) {
            return None;
        }
        let mut network = Network::new(nodes.len());
        for &(i, j, e) in &edges {
            network.join(i, j, whole(cost(e) / dearest * STEPS) + 1);
        }
        let is_first = network.cut(&ends[0], &ends[1]);

        let (mut costs, mut lengths) = ([0.0; 2], [0.0; 2]);
        for &(i, j, e) in &edges {
            let was = charts[nodes[i as usize].index()] != charts[nodes[j as usize].index()];
            let is = is_first[i as usize] != is_first[j as usize];
            for (k, counts) in [was, is].into_iter().enumerate() {
                if counts {
                    costs[k] += cost(e);
                    lengths[k] += capacities.lengths[e.index()];
                }
            }
        }
        let faces: Vec<FaceId> = (0..band.len())
            .filter(|&i| is_first[i] != (charts[band[i].index()] == pair[0]))
            .map(|i| band[i])
            .collect();
        (!faces.is_empty() && costs[1] < costs[0] * (1.0 - GAIN))
            .then_some(Moved { faces, lengths })
    }

    /// The faces within some rings of the seam of a pair, each chart's innermost ring excepted.
    fn band(
        &mut self,
        mesh: &Mesh,
        charts: &[u32],
        pair: [u32; 2],
        faces: [&[FaceId]; 2],
        rings: u32,
    ) -> Vec<FaceId> {
        let is_ours = |f: FaceId| pair.contains(&charts[f.index()]);
        let mut ring = Vec::new();
        let smaller = if faces[0].len() <= faces[1].len() { 0 } else { 1 };
        for &f in faces[smaller] {
            for h in mesh.face_halfedges(f) {
                let Some(g) = mesh.face(h.twin()) else { continue };
                if charts[g.index()] == pair[1 - smaller] {
                    ring.extend([mesh.tail(h), mesh.tip(h)]);
                }
            }
        }
        let first = self.touched.len();
        // One ring more than wanted tells whether anything is left behind the band.
        for number in 1..=rings + 1 {
            let begin = self.touched.len();
            for &v in &ring {
                for f in mesh.outgoing(v).filter_map(|h| mesh.face(h)).filter(|&f| is_ours(f)) {
                    if self.rings[f.index()] == NONE {
                        self.rings[f.index()] = number;
                        self.touched.push(f);
                    }
                }
            }
            ring.clear();
            ring.extend(self.touched[begin..].iter().flat_map(|&f| mesh.face_vertices(f)));
        }
        let near = &self.touched[first..];
        let depth = pair.map(|chart| {
            let own = near.iter().filter(|f| charts[f.index()] == chart);
            let deepest = own.map(|f| self.rings[f.index()]).max().unwrap_or(0);
            deepest.saturating_sub(1).min(rings)
        });
        let mut band: Vec<FaceId> = near
            .iter()
            .copied()
            .filter(|f| self.rings[f.index()] <= depth[usize::from(charts[f.index()] == pair[1])])
            .collect();
        band.sort_unstable();
        band
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
fn whole(x: f64) -> u64 {
    x as u64
}
