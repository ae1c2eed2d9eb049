//! From the cut edges of a refined mesh to a network of crossings.
//!
//! A curve that runs through vertices is pushed off them: each point of the cut where more than a plain crossing happens becomes a junction
//! in one of the faces around, and its arms wind around the point, nested, to the sector that they leave in. Nothing moves but by
//! a small fraction of the way to the next point, and no order changes, so the network is the old one up to a motion of the
//! surface. What is fixed stays a point.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::collections::BTreeSet;

use nalgebra::Rotation2;

use super::StraightenParams;
use super::flat::{Flat, Place};
use super::network::{Anchor, Network};
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, EdgeId, FaceId, Mesh, SurfacePoint, VertexId};

/// How far junctions are pushed off, as a fraction of the way to the next point.
const PUSH: f64 = 0.1;

const NONE: u32 = u32::MAX;

/// A cut edge and where it runs.
struct Stretch {
    ends: [u32; 2],
    face: FaceId,
    is_free: bool,
    /// The mesh edge that it runs along.
    edge: Option<EdgeId>,
}

/// What surrounds a point: spokes, and the faces between them counter-clockwise.
struct Ring {
    spokes: Vec<Spoke>,
    sectors: Vec<(FaceId, f64)>,
    is_closed: bool,
}

/// A piece of an edge that leaves a point.
#[derive(Clone, Copy)]
struct Spoke {
    edge: EdgeId,
    /// Where the point lies on the edge.
    from: f64,
    /// 1 towards the tip of the edge, −1 towards its tail.
    sign: f64,
}

/// An arm of a point: the stretch, the sector that it leaves in, its angle in that sector and in the whole ring.
#[derive(Clone, Copy)]
struct Arm {
    stretch: u32,
    sector: usize,
    angle: f64,
    key: f64,
}

struct Builder<'a, 'b> {
    network: Network<'a>,
    cut: &'b CutMesh,
    stretches: Vec<Stretch>,
    /// For each end of each stretch the node that it ends at.
    terminals: Vec<[u32; 2]>,
    /// For each edge the places of points of the cut on it.
    marks: Vec<Vec<f64>>,
    reach: f64,
}

/// Makes the network of a cut. `None` where cut edges are no edges of the triangulation, or the push would run together.
pub(super) fn build<'a>(
    mesh: &'a Mesh,
    geometry: &'a Geometry,
    cut: &CutMesh,
    params: &StraightenParams,
    pins: &[f64],
) -> Option<Network<'a>> {
    let flat = Flat::new(mesh, geometry);
    let stretches = stretches(&flat, cut, params.free_from)?;
    let network = Network::empty(flat);
    let mut marks = vec![Vec::new(); mesh.edge_count()];
    let mut used: Vec<u32> = stretches.iter().flat_map(|s| s.ends).collect();
    used.sort_unstable();
    used.dedup();
    for &p in &used {
        if let SurfacePoint::Edge(e, t) = cut.points[p as usize] {
            marks[e.index()].push(t);
        }
    }
    let terminals = vec![[NONE; 2]; stretches.len()];
    let reach = params.reach * geometry.mean_edge_length();
    let mut builder = Builder { network, cut, stretches, terminals, marks, reach };
    builder.raise_walls(geometry, params);
    let mut arms: Vec<(u32, u32)> = Vec::new();
    for (i, s) in builder.stretches.iter().enumerate() {
        if !s.edge.is_some_and(|e| builder.network.is_wall[e.index()]) {
            arms.extend(s.ends.map(|p| (p, i as u32)));
        }
    }
    arms.sort_unstable();
    for group in arms.chunk_by(|a, b| a.0 == b.0) {
        let stretches: Vec<u32> = group.iter().map(|a| a.1).collect();
        builder.add_point(group[0].0, &stretches, pins)?;
    }
    for i in 0..builder.stretches.len() {
        let ends = builder.terminals[i];
        if ends[0] != NONE && ends[1] != NONE && ends[0] != ends[1] {
            let Stretch { face, is_free, .. } = builder.stretches[i];
            builder.network.add_segment(ends, face, is_free);
        }
    }
    Some(builder.network)
}

/// The faces that the cut edges run in.
fn stretches(flat: &Flat, cut: &CutMesh, free_from: usize) -> Option<Vec<Stretch>> {
    let mesh = flat.mesh;
    let mut sides: Vec<([u32; 2], FaceId)> = Vec::with_capacity(3 * cut.triangles.len());
    for (t, &face) in cut.triangles.iter().zip(&cut.triangle_faces) {
        sides.extend((0..3).map(|i| (sorted([t[i], t[(i + 1) % 3]]), face)));
    }
    sides.sort_unstable();
    let mut stretches = Vec::new();
    let mut seen = BTreeSet::new();
    for (i, &ends) in cut.cut_edges.iter().enumerate() {
        let key = sorted(ends);
        if !seen.insert(key) {
            continue;
        }
        let first = sides.partition_point(|s| s.0 < key);
        let beside: Vec<FaceId> =
            sides[first..].iter().take_while(|s| s.0 == key).map(|s| s.1).collect();
        let is_free = i >= free_from;
        match beside[..] {
            [f, g] if f == g => stretches.push(Stretch { ends, face: f, is_free, edge: None }),
            [f, g] => {
                let shared = mesh.face_halfedges(f).into_iter().find(|h| {
                    mesh.face(h.twin()) == Some(g) && {
                        let on = |p: u32| lies_on(mesh, cut.points[p as usize], h.edge());
                        on(ends[0]) && on(ends[1])
                    }
                })?;
                let face = mesh.face(shared.edge().halfedge())?;
                stretches.push(Stretch { ends, face, is_free, edge: Some(shared.edge()) });
            }
            // The boundary is cut anyway.
            [_] => {}
            _ => return None,
        }
    }
    Some(stretches)
}

fn lies_on(mesh: &Mesh, point: SurfacePoint, edge: EdgeId) -> bool {
    match point {
        SurfacePoint::Vertex(v) => mesh.edge_vertices(edge).contains(&v),
        SurfacePoint::Edge(e, _) => e == edge,
        SurfacePoint::Face(..) => false,
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Builder<'_, '_> {
    fn place(&self, p: u32) -> Place {
        match self.cut.points[p as usize] {
            SurfacePoint::Vertex(v) => Place::Vertex(v),
            SurfacePoint::Edge(e, t) => Place::Edge(e, t),
            SurfacePoint::Face(f, w) => Place::Face(f, self.network.flat.place_of_weights(f, w)),
        }
    }

    /// Cuts along sharp edges stay there.
    fn raise_walls(&mut self, geometry: &Geometry, params: &StraightenParams) {
        let mesh = self.network.flat.mesh;
        let normals = geometry.face_normals(mesh);
        for s in &self.stretches {
            let (Some(e), Some(ends)) = (s.edge, vertices(self.cut, s.ends)) else { continue };
            let h = e.halfedge();
            let (Some(f), Some(g)) = (mesh.face(h), mesh.face(h.twin())) else { continue };
            let (m, n) = (normals[f.index()], normals[g.index()]);
            if m.cross(&n).norm().atan2(m.dot(&n)) > params.feature_angle {
                self.network.walls.push((e, s.is_free));
                self.network.is_wall[e.index()] = true;
                for v in ends {
                    self.network.is_occupied[v.index()] = true;
                }
            }
        }
    }

    /// Makes the nodes of a point of the cut.
    fn add_point(&mut self, p: u32, stretches: &[u32], pins: &[f64]) -> Option<()> {
        let place = self.place(p);
        let mesh = self.network.flat.mesh;
        let is_free = stretches.iter().any(|&s| self.stretches[s as usize].is_free);
        match place {
            Place::Face(f, _) => {
                let node = self.network.add_node(place);
                self.network.nodes[node as usize].is_fixed = stretches.len() == 1;
                for &s in stretches {
                    self.set_terminal(s, p, node);
                }
                debug_assert!(stretches.iter().all(|&s| self.stretches[s as usize].face == f));
                return Some(());
            }
            Place::Vertex(v) => {
                let dangles = stretches.len() == 1 && !mesh.is_boundary_vertex(v);
                let is_pinned = pins.get(v.index()).is_some_and(|&pin| pin > 0.0);
                if dangles || is_pinned || self.network.is_occupied[v.index()] {
                    self.network.is_occupied[v.index()] = true;
                    let node = self.network.add_node(place);
                    self.network.nodes[node as usize].is_fixed = true;
                    for &s in stretches {
                        self.set_terminal(s, p, node);
                    }
                    return Some(());
                }
            }
            Place::Edge(e, t) => {
                let h = e.halfedge();
                let mut faces: Vec<Option<FaceId>> =
                    stretches.iter().map(|&s| Some(self.stretches[s as usize].face)).collect();
                faces.sort_unstable();
                let mut expected = vec![mesh.face(h), mesh.face(h.twin())];
                expected.retain(Option::is_some);
                expected.sort_unstable();
                let is_plain = stretches.iter().all(|&s| self.stretches[s as usize].edge.is_none());
                if is_plain && faces == expected {
                    let node = self.network.add_node(place);
                    let holds = |v: VertexId| pins.get(v.index()).is_some_and(|&pin| pin > 0.0);
                    self.network.nodes[node as usize].is_fixed =
                        mesh.edge_vertices(e).into_iter().any(holds);
                    if !is_free {
                        self.anchor(node, t);
                    }
                    for &s in stretches {
                        self.set_terminal(s, p, node);
                    }
                    return Some(());
                }
            }
        }
        let ring = self.ring(place)?;
        let arms = self.arms(p, place, &ring, stretches)?;
        let push = PUSH * self.room(p, place, &ring, stretches);
        if !(push > 0.0) {
            return None;
        }
        if ring.is_closed {
            self.push_off(p, place, &ring, arms, push)
        } else {
            self.spread(p, &ring, &arms, push);
            Some(())
        }
    }

    fn set_terminal(&mut self, stretch: u32, p: u32, node: u32) {
        let ends = self.stretches[stretch as usize].ends;
        self.terminals[stretch as usize][usize::from(ends[0] != p)] = node;
    }

    fn anchor(&mut self, node: u32, origin: f64) {
        let anchor = Anchor { origin, target: origin, stiffness: 0.0, reach: self.reach };
        self.network.nodes[node as usize].anchor = Some(anchor);
    }

    fn ring(&self, place: Place) -> Option<Ring> {
        let flat = &self.network.flat;
        let mesh = flat.mesh;
        match place {
            Place::Vertex(v) => {
                let (mut spokes, mut sectors) = (Vec::new(), Vec::new());
                for h in mesh.outgoing(v) {
                    let is_tail = h.0 & 1 == 0;
                    let from = if is_tail { 0.0 } else { 1.0 };
                    spokes.push(Spoke { edge: h.edge(), from, sign: 1.0 - 2.0 * from });
                    if let Some(f) = mesh.face(h) {
                        let far = mesh.tail(mesh.prev(h));
                        sectors.push((f, flat.angle(f, v, h.edge(), Place::Vertex(far))));
                    }
                }
                Some(Ring { spokes, sectors, is_closed: !mesh.is_boundary_vertex(v) })
            }
            Place::Edge(edge, from) => {
                let h = edge.halfedge();
                let spokes = [1.0, -1.0].map(|sign| Spoke { edge, from, sign }).to_vec();
                let faces = [mesh.face(h), mesh.face(h.twin())].into_iter().flatten();
                let sectors: Vec<_> = faces.map(|f| (f, std::f64::consts::PI)).collect();
                let is_closed = sectors.len() == 2;
                Some(Ring { spokes, sectors, is_closed })
            }
            Place::Face(..) => None,
        }
    }

    /// The arms of a point, counter-clockwise.
    fn arms(&self, p: u32, place: Place, ring: &Ring, stretches: &[u32]) -> Option<Vec<Arm>> {
        let flat = &self.network.flat;
        let mut starts = vec![0.0];
        for &(_, angle) in &ring.sectors {
            starts.push(starts[starts.len() - 1] + angle);
        }
        let mut arms = Vec::new();
        for &s in stretches {
            let Stretch { ends, face, .. } = self.stretches[s as usize];
            let target = self.place(if ends[0] == p { ends[1] } else { ends[0] });
            let sector = ring.sectors.iter().position(|&(f, _)| f == face)?;
            let spoke = ring.spokes[sector];
            let origin = flat.at(face, place);
            let tip = Place::Edge(spoke.edge, if spoke.sign > 0.0 { 1.0 } else { 0.0 });
            let (a, b) = (flat.at(face, tip) - origin, flat.at(face, target) - origin);
            let angle = a.perp(&b).atan2(a.dot(&b)).clamp(0.0, ring.sectors[sector].1);
            arms.push(Arm { stretch: s, sector, angle, key: starts[sector] + angle });
        }
        arms.sort_by(|a, b| a.key.total_cmp(&b.key));
        Some(arms)
    }

    /// Distance to the nearest other point.
    fn room(&self, p: u32, place: Place, ring: &Ring, stretches: &[u32]) -> f64 {
        let flat = &self.network.flat;
        let mut room = f64::INFINITY;
        for spoke in &ring.spokes {
            let end = if spoke.sign > 0.0 { 1.0 } else { 0.0 };
            let mut nearest = (end - spoke.from).abs();
            for t in &self.marks[spoke.edge.index()] {
                let ahead = (t - spoke.from) * spoke.sign;
                if ahead > 0.0 {
                    nearest = nearest.min(ahead);
                }
            }
            room = room.min(nearest * flat.length(spoke.edge));
        }
        for &s in stretches {
            let Stretch { ends, face, .. } = self.stretches[s as usize];
            let target = self.place(if ends[0] == p { ends[1] } else { ends[0] });
            room = room.min((flat.at(face, target) - flat.at(face, place)).norm());
        }
        room
    }

    /// A crossing on a spoke, this far from the point.
    fn cross(&mut self, spoke: Spoke, distance: f64, anchored: bool) -> u32 {
        let step = distance / self.network.flat.length(spoke.edge);
        let node = self.network.add_node(Place::Edge(spoke.edge, spoke.from + spoke.sign * step));
        if anchored {
            self.anchor(node, spoke.from);
        }
        node
    }

    /// Makes a junction in a face beside a point, whose arms wind around the point.
    fn push_off(
        &mut self,
        p: u32,
        place: Place,
        ring: &Ring,
        mut arms: Vec<Arm>,
        push: f64,
    ) -> Option<()> {
        let whole: f64 = ring.sectors.iter().map(|s| s.1).sum();
        let count = ring.sectors.len();
        // Beside a curve that stays, if there is one.
        let is_free = |arm: &Arm| self.stretches[arm.stretch as usize].is_free;
        let first = arms.iter().position(|arm| !is_free(arm)).unwrap_or(0);
        arms.rotate_left(first);
        let base = arms[0];
        let (face, wide) = ring.sectors[base.sector];
        let spoke = ring.spokes[base.sector];
        let flat = &self.network.flat;
        let origin = flat.at(face, place);
        let tip = flat.at(face, Place::Edge(spoke.edge, if spoke.sign > 0.0 { 1.0 } else { 0.0 }));
        let direction = (tip - origin).try_normalize(0.0)?;
        let turned = Rotation2::new(base.angle.clamp(0.1 * wide, 0.9 * wide)) * direction;
        let mut x = origin + turned * push;
        // A sliver may be thinner than the push.
        let mut left = 60;
        while flat.weights(face, x).iter().any(|&w| !(w > 0.0)) {
            x = nalgebra::center(&x.into(), &origin.into()).coords;
            left -= 1;
            if left == 0 {
                return None;
            }
        }
        let junction = self.network.add_node(Place::Face(face, x));
        self.network.nodes[junction as usize].is_fixed = arms.len() == 1;
        let turn = |arm: &Arm| (arm.key - base.key).rem_euclid(whole);
        let (ahead, mut behind): (Vec<Arm>, Vec<Arm>) =
            arms.iter().partition(|arm| turn(arm) <= 0.5 * whole);
        behind.reverse();
        for (side, group) in [ahead, behind].into_iter().enumerate() {
            let winding: Vec<(Arm, usize)> = group
                .iter()
                .map(|&arm| {
                    let steps = if side == 0 {
                        (arm.sector + count - base.sector) % count
                    } else {
                        (base.sector + count - arm.sector) % count
                    };
                    (arm, steps)
                })
                .collect();
            let total = winding.iter().filter(|w| w.1 > 0).count() as f64;
            let mut rank = 0.0;
            for (arm, steps) in winding {
                let is_free = self.stretches[arm.stretch as usize].is_free;
                rank += if steps > 0 { 1.0 } else { 0.0 };
                // Arms that go farther pass on the inner side.
                let distance = push * (1.0 - rank / (total + 1.0));
                let mut node = junction;
                for step in 0..steps {
                    let (spoke, sector) = if side == 0 {
                        ((base.sector + step + 1) % count, (base.sector + step) % count)
                    } else {
                        let sector = (base.sector + count - step) % count;
                        (sector, sector)
                    };
                    let next = self.cross(ring.spokes[spoke], distance, !is_free);
                    self.network.add_segment([node, next], ring.sectors[sector].0, is_free);
                    node = next;
                }
                self.set_terminal(arm.stretch, p, node);
            }
        }
        Some(())
    }

    /// Lets curves that end in one point of the boundary end beside each other.
    fn spread(&mut self, p: u32, ring: &Ring, arms: &[Arm], push: f64) {
        let whole: f64 = ring.sectors.iter().map(|s| s.1).sum();
        let last = ring.sectors.len();
        let (low, high): (Vec<Arm>, Vec<Arm>) = arms.iter().partition(|a| a.key <= 0.5 * whole);
        for (side, group) in [low, high].into_iter().enumerate() {
            let total = group.len() as f64;
            for (i, arm) in group.iter().enumerate() {
                let is_free = self.stretches[arm.stretch as usize].is_free;
                let outer = if side == 0 { i as f64 } else { total - 1.0 - i as f64 };
                let distance = push * (1.0 - outer / (total + 1.0));
                let spokes: Vec<usize> = if side == 0 {
                    (0..=arm.sector).collect()
                } else {
                    (arm.sector + 1..=last).rev().collect()
                };
                let mut node = None;
                for &spoke in &spokes {
                    let next = self.cross(ring.spokes[spoke], distance, !is_free);
                    if let Some(node) = node {
                        // The sector between the last spoke and this one.
                        let sector = if side == 0 { spoke - 1 } else { spoke };
                        self.network.add_segment([node, next], ring.sectors[sector].0, is_free);
                    }
                    node = Some(next);
                }
                if let Some(node) = node {
                    self.set_terminal(arm.stretch, p, node);
                }
            }
        }
    }
}

fn vertices(cut: &CutMesh, ends: [u32; 2]) -> Option<[VertexId; 2]> {
    match ends.map(|p| cut.points[p as usize]) {
        [SurfacePoint::Vertex(a), SurfacePoint::Vertex(b)] => Some([a, b]),
        _ => None,
    }
}
