//! A part of a surface, opened along cut edges: what one chart is made from.

use std::collections::{BTreeSet, BinaryHeap};

use crate::flatten::small;
use crate::geometry::Geometry;
use crate::mesh::{FaceId, HalfedgeId, Mesh, VertexId};

use super::boundary::{BoundaryProblem, NO_LOOP};

/// Some faces of a mesh with vertices of their own, one for each fan of corners between rims.
///
/// A side of a face is named by its halfedge; it lies on the rim if its edge is cut or has no face of the patch behind it.
#[derive(Clone, Debug, Default)]
pub struct Patch {
    /// The faces.
    pub faces: Vec<FaceId>,
    /// Vertices of the patch at the corners of each face.
    pub corners: Vec<[u32; 3]>,
    /// Mesh vertex of each vertex.
    pub vertices: Vec<VertexId>,
    /// Whether a vertex lies on a rim.
    pub is_rim: Vec<bool>,
    /// Rims with the patch on the left, the outer one first.
    pub loops: Vec<Vec<HalfedgeId>>,
    /// V − E + F.
    pub euler: i64,
}

/// Where a patch can be walked around, virtual cuts between its loops included.
#[derive(Clone, Debug, Default)]
pub struct Outline {
    /// Sides in order.
    pub sides: Vec<HalfedgeId>,
    /// Vertex of the patch where each side begins.
    pub vertices: Vec<u32>,
    /// What is to be solved.
    pub problem: BoundaryProblem,
}

/// Opens patches one after another in the same memory.
#[derive(Clone, Debug)]
pub struct Opener {
    now: u32,
    face_stamps: Vec<u32>,
    /// For each halfedge the patch vertex at its tail, valid if `stamps` says so.
    corner_vertices: Vec<u32>,
    stamps: Vec<u32>,
    /// Rim halfedges that were walked, and virtual cuts.
    walked: Vec<u32>,
    virtual_cuts: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Opener {
    /// Memory for patches of a mesh.
    pub fn new(mesh: &Mesh) -> Self {
        Self {
            now: 0,
            face_stamps: vec![0; mesh.face_count()],
            corner_vertices: vec![0; mesh.halfedge_count()],
            stamps: vec![0; mesh.halfedge_count()],
            walked: vec![0; mesh.halfedge_count()],
            virtual_cuts: vec![0; mesh.edge_count()],
        }
    }

    /// Opens some faces along cut edges. **Costs** O(F) of these faces.
    pub fn open(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        faces: &[FaceId],
        is_cut: &[bool],
    ) -> Patch {
        if self.now == u32::MAX {
            *self = Self::new(mesh);
        }
        self.now += 1;
        for f in faces {
            self.face_stamps[f.index()] = self.now;
        }
        let mut patch = Patch { faces: faces.to_vec(), ..Patch::default() };
        patch.corners.reserve(faces.len());
        for &f in faces {
            let sides = mesh.face_halfedges(f);
            for h in sides {
                if self.stamps[h.index()] != self.now {
                    self.number_fan(mesh, h, is_cut, &mut patch);
                }
            }
            patch.corners.push(sides.map(|h| self.corner_vertices[h.index()]));
        }
        let mut rim_sides = 0;
        for &f in faces {
            for h in mesh.face_halfedges(f) {
                if self.is_border(mesh, h, is_cut) {
                    rim_sides += 1;
                    if self.walked[h.index()] != self.now {
                        let rim = self.walk(mesh, h, is_cut);
                        patch.loops.push(rim);
                    }
                }
            }
        }
        let edges = (3 * faces.len() + rim_sides) / 2;
        patch.euler = patch.vertices.len() as i64 - edges as i64 + faces.len() as i64;
        self.outer_first(mesh, geometry, is_cut, &mut patch);
        patch
    }

    /// Whether a side of a face of the patch lies on its rim.
    fn is_border(&self, mesh: &Mesh, h: HalfedgeId, is_cut: &[bool]) -> bool {
        is_cut[h.edge().index()]
            || mesh.face(h.twin()).is_none_or(|g| self.face_stamps[g.index()] != self.now)
    }

    /// Numbers the vertex at the tail of a side, and all corners of its fan.
    fn number_fan(&mut self, mesh: &Mesh, start: HalfedgeId, is_cut: &[bool], patch: &mut Patch) {
        let vertex = small(patch.vertices.len());
        // Clockwise to where the fan begins, or around.
        let mut first = start;
        let mut is_rim = false;
        loop {
            if self.is_border(mesh, first, is_cut) {
                is_rim = true;
                break;
            }
            first = mesh.next(first.twin());
            if first == start {
                break;
            }
        }
        let mut h = first;
        loop {
            self.corner_vertices[h.index()] = vertex;
            self.stamps[h.index()] = self.now;
            let back = mesh.prev(h);
            if self.is_border(mesh, back, is_cut) {
                break;
            }
            h = back.twin();
            if h == first {
                break;
            }
        }
        patch.vertices.push(mesh.tail(start));
        patch.is_rim.push(is_rim);
    }

    /// The rim that a side lies on, from there.
    fn walk(&mut self, mesh: &Mesh, start: HalfedgeId, is_cut: &[bool]) -> Vec<HalfedgeId> {
        let mut rim = Vec::new();
        let mut h = start;
        loop {
            rim.push(h);
            self.walked[h.index()] = self.now;
            h = mesh.next(h);
            while !self.is_border(mesh, h, is_cut) {
                h = mesh.next(h.twin());
            }
            if h == start {
                return rim;
            }
        }
    }

    /// The outer loop is the one that turns most, and of those that turn alike the longest.
    fn outer_first(&self, mesh: &Mesh, geometry: &Geometry, is_cut: &[bool], patch: &mut Patch) {
        if patch.loops.len() < 2 {
            return;
        }
        let key = |rim: &Vec<HalfedgeId>| {
            let mut turning = 0.0;
            for &h in rim {
                let border = |g| self.is_border(mesh, g, is_cut);
                turning += std::f64::consts::PI - angle_at(mesh, geometry, h, border);
            }
            let length: f64 = rim.iter().map(|h| geometry.edge_length(h.edge())).sum();
            // To nine digits, so that rounding does not decide between loops that turn alike.
            ((turning * 1e9).round(), length)
        };
        let keys: Vec<(f64, f64)> = patch.loops.iter().map(key).collect();
        let mut outer = 0;
        for i in 1..keys.len() {
            let by = keys[i].0.total_cmp(&keys[outer].0).then(keys[i].1.total_cmp(&keys[outer].1));
            if by.is_gt() {
                outer = i;
            }
        }
        patch.loops.swap(0, outer);
    }

    /// The walk around the patch that was opened last, along virtual cuts between its loops.
    ///
    /// Each loop is joined to those before it by the shortest path along inner edges. **Gives** none for a patch without loops, and
    /// for one that virtual cuts do not make a disk. **Costs** O(n), and O(V log V) where there are several loops.
    pub fn outline(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        is_cut: &[bool],
        patch: &Patch,
    ) -> Option<Outline> {
        let loops = patch.loops.len();
        if loops == 0 || patch.euler != 2 - loops as i64 {
            return None;
        }
        let mut loop_of = vec![NO_LOOP; patch.vertices.len()];
        for (i, rim) in patch.loops.iter().enumerate() {
            for h in rim {
                loop_of[self.corner_vertices[h.index()] as usize] = small(i);
            }
        }
        if loops > 1 {
            self.join_loops(mesh, geometry, patch, &mut loop_of)?;
        }
        let mut outline = Outline::default();
        outline.problem.loop_count = loops;
        let mut places = Vec::new();
        let start = patch.loops[0][0];
        let mut h = start;
        loop {
            let is_virtual = !self.is_border(mesh, h, is_cut);
            if is_virtual {
                places.push((h.edge(), small(outline.sides.len())));
            }
            outline.sides.push(h);
            let vertex = self.corner_vertices[h.index()];
            outline.vertices.push(vertex);
            outline.problem.loops.push(if is_virtual { NO_LOOP } else { loop_of[vertex as usize] });
            outline.problem.lengths.push(geometry.edge_length(h.edge()));
            let border = |g: HalfedgeId| {
                self.is_border(mesh, g, is_cut) || self.virtual_cuts[g.edge().index()] == self.now
            };
            outline.problem.angles.push(angle_at(mesh, geometry, h, border));
            h = mesh.next(h);
            while !border(h) {
                h = mesh.next(h.twin());
            }
            if h == start {
                break;
            }
        }
        places.sort_unstable();
        for pair in places.chunks_exact(2) {
            outline.problem.cuts.push([pair[0].1, pair[1].1]);
        }
        Some(outline)
    }

    /// Edges of virtual cuts of the last outline, as halfedges of the walk.
    pub fn is_virtual(&self, h: HalfedgeId) -> bool {
        self.virtual_cuts[h.edge().index()] == self.now
    }

    /// Marks shortest paths that join all loops. A vertex on a path belongs to the loops joined so far.
    fn join_loops(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        patch: &Patch,
        loop_of: &mut [u32],
    ) -> Option<()> {
        let count = patch.vertices.len();
        // Inner edges at each vertex, as sides that leave it.
        let mut starts = vec![0u32; count + 1];
        let all = || patch.faces.iter().flat_map(|&f| mesh.face_halfedges(f));
        for h in all() {
            starts[self.corner_vertices[h.index()] as usize + 1] += 1;
        }
        for v in 0..count {
            starts[v + 1] += starts[v];
        }
        let mut leaving = vec![HalfedgeId::default(); starts[count] as usize];
        let mut next = starts.clone();
        for h in all() {
            let slot = &mut next[self.corner_vertices[h.index()] as usize];
            leaving[*slot as usize] = h;
            *slot += 1;
        }
        let mut is_joined = vec![false; patch.loops.len()];
        is_joined[0] = true;
        let mut on_path = vec![false; count];
        for _ in 1..patch.loops.len() {
            let mut distance = vec![f64::INFINITY; count];
            let mut before = vec![NONE; count];
            let mut queue = BinaryHeap::new();
            for v in 0..count {
                let of = loop_of[v];
                if on_path[v] || (of != NO_LOOP && is_joined[of as usize]) {
                    distance[v] = 0.0;
                    queue.push(Nearest { distance: 0.0, vertex: small(v) });
                }
            }
            let mut found = None;
            while let Some(Nearest { distance: d, vertex }) = queue.pop() {
                let v = vertex as usize;
                if d > distance[v] {
                    continue;
                }
                let of = loop_of[v];
                if of != NO_LOOP && !is_joined[of as usize] {
                    found = Some(v);
                    break;
                }
                for &h in &leaving[starts[v] as usize..starts[v + 1] as usize] {
                    let tip = self.corner_vertices[mesh.next(h).index()] as usize;
                    // Rim sides join vertices of one loop and are never part of a path between loops.
                    let along = d + geometry.edge_length(h.edge());
                    if along < distance[tip] {
                        distance[tip] = along;
                        before[tip] = h.0;
                        queue.push(Nearest { distance: along, vertex: small(tip) });
                    }
                }
            }
            let mut v = found?;
            is_joined[loop_of[v] as usize] = true;
            while before[v] != NONE {
                let h = HalfedgeId(before[v]);
                self.virtual_cuts[h.edge().index()] = self.now;
                on_path[v] = true;
                v = self.corner_vertices[h.index()] as usize;
            }
        }
        Some(())
    }

    /// Vertex of the last patch at the tail of a side.
    pub fn vertex_at(&self, h: HalfedgeId) -> u32 {
        self.corner_vertices[h.index()]
    }
}

impl Patch {
    /// Sum of the face areas.
    pub fn area(&self, geometry: &Geometry) -> f64 {
        self.faces.iter().map(|f| geometry.face_areas[f.index()]).sum()
    }

    /// Edges of the mesh that lie on the rim, each once, in increasing order.
    pub fn rim_edges(&self) -> Vec<crate::mesh::EdgeId> {
        let edges: BTreeSet<_> = self.loops.iter().flatten().map(|h| h.edge()).collect();
        edges.into_iter().collect()
    }
}

/// Sum of the corner angles at the tail of a side, counter-clockwise up to the side that ends there.
pub(super) fn angle_at(
    mesh: &Mesh,
    geometry: &Geometry,
    side: HalfedgeId,
    is_border: impl Fn(HalfedgeId) -> bool,
) -> f64 {
    let mut angle = 0.0;
    let mut h = side;
    // Every halfedge met is a side of a face: the walk ends at a border before it leaves the surface.
    while let Some(face) = mesh.face(h) {
        let corner = mesh.face_halfedges(face).iter().position(|&g| g == h).unwrap_or(0);
        angle += geometry.corner_angles[face.index()][corner];
        let back = mesh.prev(h);
        if is_border(back) {
            break;
        }
        h = back.twin();
        if h == side {
            break;
        }
    }
    angle
}

/// Smallest distance first, ties by vertex.
#[derive(PartialEq)]
pub struct Nearest {
    /// Distance so far.
    pub distance: f64,
    /// Where.
    pub vertex: u32,
}

impl Eq for Nearest {}

impl Ord for Nearest {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.distance.total_cmp(&self.distance).then(other.vertex.cmp(&self.vertex))
    }
}

impl PartialOrd for Nearest {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
