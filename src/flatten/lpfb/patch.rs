//! A part of a surface, opened along cut edges: what one chart is made from.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Point2;

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
    /// Vertex of the patch where each side begins, once the patch has been filled.
    pub vertices: Vec<u32>,
    /// What is to be solved.
    pub problem: BoundaryProblem,
}

/// Opens patches one after another in the same memory. A copy begins without, and takes it for its first patch.
#[derive(Debug, Default)]
pub struct Opener {
    now: u32,
    face_stamps: Vec<u32>,
    /// For each halfedge the patch vertex at its tail, valid if `stamps` says so.
    corner_vertices: Vec<u32>,
    stamps: Vec<u32>,
    /// Rim halfedges that were walked, and the number of each among all of them.
    walked: Vec<u32>,
    rim_numbers: Vec<u32>,
    /// Mesh vertices that lie on a rim.
    rim_vertices: Vec<u32>,
    /// Edges of virtual cuts, and the vertices off the rims that they lead through.
    virtual_cuts: Vec<u32>,
    on_path: Vec<u32>,
    /// The first corner at each mesh vertex, faces in order: the same however the surface is opened elsewhere.
    first_corners: Vec<u32>,
    paths: Paths,
}

/// Shortest ways so far to vertices off the rims.
#[derive(Debug, Default)]
struct Paths {
    round: u32,
    stamps: Vec<u32>,
    distances: Vec<f64>,
    /// The side that leads there.
    before: Vec<u32>,
}

/// The bits of a distance, which are ordered like it, the first corner of a vertex, and a side that begins there.
type Step = Reverse<(u64, u32, HalfedgeId)>;

const NONE: u32 = u32::MAX;

impl Clone for Opener {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Opener {
    /// Memory for patches of a mesh. **Costs** O(F).
    fn new(mesh: &Mesh) -> Self {
        Self {
            now: 0,
            face_stamps: vec![0; mesh.face_count()],
            corner_vertices: vec![0; mesh.halfedge_count()],
            stamps: vec![0; mesh.halfedge_count()],
            walked: vec![0; mesh.halfedge_count()],
            rim_numbers: vec![0; mesh.halfedge_count()],
            rim_vertices: vec![0; mesh.vertex_count()],
            virtual_cuts: vec![0; mesh.edge_count()],
            on_path: vec![0; mesh.vertex_count()],
            first_corners: mesh
                .vertices()
                .map(|v| mesh.outgoing(v).map(|h| corner_at(mesh, h)).min().unwrap_or(NONE))
                .collect(),
            paths: Paths {
                round: 0,
                stamps: vec![0; mesh.vertex_count()],
                distances: vec![0.0; mesh.vertex_count()],
                before: vec![0; mesh.vertex_count()],
            },
        }
    }

    /// The rims of some faces along cut edges, the outer one first, and nothing of what lies inside. **Costs** O(F), a small part of [`Opener::fill`].
    pub fn rims(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        faces: &[FaceId],
        is_cut: &[bool],
    ) -> Vec<Vec<HalfedgeId>> {
        if self.now == u32::MAX || self.face_stamps.len() != mesh.face_count() {
            *self = Self::new(mesh);
        }
        self.now += 1;
        for f in faces {
            self.face_stamps[f.index()] = self.now;
        }
        let mut loops = Vec::new();
        for &f in faces {
            for h in mesh.face_halfedges(f) {
                if self.is_border(mesh, h, is_cut) && self.walked[h.index()] != self.now {
                    loops.push(self.walk(mesh, h, is_cut));
                }
            }
        }
        self.outer_first(mesh, geometry, is_cut, &mut loops);
        for (number, h) in loops.iter().flatten().enumerate() {
            self.rim_numbers[h.index()] = small(number);
        }
        loops
    }

    /// The patch whose rims were found last, from these faces and along this cut.
    pub fn fill(
        &mut self,
        mesh: &Mesh,
        faces: &[FaceId],
        is_cut: &[bool],
        loops: Vec<Vec<HalfedgeId>>,
    ) -> Patch {
        let rim_sides: usize = loops.iter().map(Vec::len).sum();
        let mut patch = Patch { faces: faces.to_vec(), loops, ..Patch::default() };
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
        let edges = (3 * faces.len() + rim_sides) / 2;
        patch.euler = patch.vertices.len() as i64 - edges as i64 + faces.len() as i64;
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
            self.rim_vertices[mesh.tail(h).index()] = self.now;
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
    fn outer_first(
        &self,
        mesh: &Mesh,
        geometry: &Geometry,
        is_cut: &[bool],
        loops: &mut [Vec<HalfedgeId>],
    ) {
        if loops.len() < 2 {
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
        let keys: Vec<(f64, f64)> = loops.iter().map(key).collect();
        let mut outer = 0;
        for i in 1..keys.len() {
            let by = keys[i].0.total_cmp(&keys[outer].0).then(keys[i].1.total_cmp(&keys[outer].1));
            if by.is_gt() {
                outer = i;
            }
        }
        loops.swap(0, outer);
    }

    /// The walk around the patch whose rims were found last, along virtual cuts between them; its vertices have no numbers before [`Opener::name`].
    ///
    /// Rims are joined by shortest paths along inner edges, ties by the vertices' first corners. **Gives** none for a patch without
    /// rims, and for one that does not hang together. **Costs** O(n), and where there are several rims what lies between them.
    pub fn outline(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        is_cut: &[bool],
        rims: &[Vec<HalfedgeId>],
    ) -> Option<Outline> {
        let start = *rims.first()?.first()?;
        let mut loop_of = Vec::new();
        for (i, rim) in rims.iter().enumerate() {
            loop_of.resize(loop_of.len() + rim.len(), small(i));
        }
        if rims.len() > 1 {
            self.join_rims(mesh, geometry, is_cut, rims, &loop_of)?;
        }
        let mut outline = Outline::default();
        outline.problem.loop_count = rims.len();
        let mut places = Vec::new();
        let mut h = start;
        loop {
            let is_virtual = !self.is_border(mesh, h, is_cut);
            if is_virtual {
                places.push((h.edge(), small(outline.sides.len())));
            }
            outline.sides.push(h);
            let of = if is_virtual { NO_LOOP } else { loop_of[self.rim_number(h)] };
            outline.problem.loops.push(of);
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

    /// Numbers the vertices of an outline as the patch has them that was filled last.
    pub fn name(&self, outline: &mut Outline) {
        outline.vertices = outline.sides.iter().map(|&h| self.vertex_at(h)).collect();
    }

    fn rim_number(&self, h: HalfedgeId) -> usize {
        self.rim_numbers[h.index()] as usize
    }

    /// The side of a rim that leaves the vertex where a side begins, in the same fan.
    fn rim_side(&self, mesh: &Mesh, side: HalfedgeId, is_cut: &[bool]) -> HalfedgeId {
        let mut h = side;
        while !self.is_border(mesh, h, is_cut) {
            h = mesh.next(h.twin());
        }
        h
    }

    /// The side that leaves a vertex next within the patch, counter-clockwise; none where the fan ends.
    fn next_in_fan(&self, mesh: &Mesh, side: HalfedgeId, is_cut: &[bool]) -> Option<HalfedgeId> {
        let back = mesh.prev(side);
        (!self.is_border(mesh, back, is_cut)).then_some(back.twin())
    }

    /// Marks shortest paths that join all rims. A vertex on a path belongs to the rims joined so far.
    ///
    /// Paths are looked for from the rims that have yet to be joined: holes are shorter than what is about them, and less lies near them.
    fn join_rims(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        is_cut: &[bool],
        rims: &[Vec<HalfedgeId>],
        loop_of: &[u32],
    ) -> Option<()> {
        let sides: Vec<HalfedgeId> = rims.iter().flatten().copied().collect();
        let mut is_joined = vec![false; rims.len()];
        is_joined[0] = true;
        for _ in 1..rims.len() {
            self.paths.begin();
            let mut rim_paths = vec![(f64::INFINITY, NONE); sides.len()];
            let mut queue = BinaryHeap::new();
            for (i, &h) in sides.iter().enumerate() {
                if !is_joined[loop_of[i] as usize] {
                    rim_paths[i].0 = 0.0;
                    queue.push(self.step_to(mesh, h, is_cut, 0.0));
                }
            }
            // The side by which a path meets what is joined.
            let mut found = None;
            while let Some(Reverse((bits, _, side))) = queue.pop() {
                let distance = f64::from_bits(bits);
                let v = mesh.tail(side).index();
                let (least, before, is_met) = if self.rim_vertices[v] == self.now {
                    let i = self.rim_number(side);
                    (rim_paths[i].0, rim_paths[i].1, is_joined[loop_of[i] as usize])
                } else {
                    (self.paths.distances[v], self.paths.before[v], self.on_path[v] == self.now)
                };
                if is_met {
                    found = Some(before);
                    break;
                }
                if distance > least {
                    continue;
                }
                let mut leaving = Some(side);
                while let Some(h) = leaving {
                    leaving = self.next_in_fan(mesh, h, is_cut).filter(|&on| on != side);
                    if self.is_border(mesh, h, is_cut) {
                        continue;
                    }
                    let along = distance + geometry.edge_length(h.edge());
                    let (tip, mut on) = (mesh.tip(h).index(), mesh.next(h));
                    let is_shorter = if self.rim_vertices[tip] == self.now {
                        on = self.rim_side(mesh, on, is_cut);
                        let path = &mut rim_paths[self.rim_numbers[on.index()] as usize];
                        let is_shorter = along < path.0;
                        if is_shorter {
                            *path = (along, h.0);
                        }
                        is_shorter
                    } else {
                        self.paths.shorten(tip, along, h)
                    };
                    if is_shorter {
                        queue.push(self.step_to(mesh, on, is_cut, along));
                    }
                }
            }
            let mut before = found?;
            while before != NONE {
                let h = HalfedgeId(before);
                self.virtual_cuts[h.edge().index()] = self.now;
                let v = mesh.tail(h).index();
                if self.rim_vertices[v] == self.now {
                    is_joined[loop_of[self.rim_number(self.rim_side(mesh, h, is_cut))] as usize] =
                        true;
                    break;
                }
                self.on_path[v] = self.now;
                before = self.paths.before[v];
            }
        }
        Some(())
    }

    /// What the queue of paths holds for one to where a side begins: shortest first, then by the first corner there.
    fn step_to(&self, mesh: &Mesh, side: HalfedgeId, is_cut: &[bool], distance: f64) -> Step {
        let v = mesh.tail(side).index();
        let mut first = self.first_corners[v];
        if self.rim_vertices[v] == self.now {
            // Of its own fan only.
            let fan = std::iter::successors(Some(side), |&h| self.next_in_fan(mesh, h, is_cut));
            first = fan.map(|h| corner_at(mesh, h)).min().unwrap_or(NONE);
        }
        Reverse((distance.to_bits(), first, side))
    }

    /// Vertex of the last patch at the tail of a side.
    pub fn vertex_at(&self, h: HalfedgeId) -> u32 {
        self.corner_vertices[h.index()]
    }
}

impl Paths {
    /// Forgets all ways.
    fn begin(&mut self) {
        if self.round == u32::MAX {
            self.round = 0;
            self.stamps.fill(0);
        }
        self.round += 1;
    }

    /// Takes a way to a vertex if there is none as short, and says whether.
    fn shorten(&mut self, v: usize, distance: f64, by: HalfedgeId) -> bool {
        let is_shorter = self.stamps[v] != self.round || distance < self.distances[v];
        if is_shorter {
            (self.stamps[v], self.distances[v], self.before[v]) = (self.round, distance, by.0);
        }
        is_shorter
    }
}

impl Outline {
    /// Places of all vertices of a patch from those along the walk: NaN off the rim and off virtual cuts.
    pub fn spread(&self, walk: &[Point2<f64>], vertices: usize) -> Vec<Point2<f64>> {
        let mut places = vec![Point2::new(f64::NAN, f64::NAN); vertices];
        for (&v, place) in self.vertices.iter().zip(walk) {
            // Vertices of virtual cuts are met twice, to rounding at the same place: the first counts.
            if !places[v as usize].x.is_finite() {
                places[v as usize] = *place;
            }
        }
        places
    }
}

impl Patch {
    /// Whether virtual cuts between its rims make it a disk.
    pub fn is_opened_by_virtual_cuts(&self) -> bool {
        !self.loops.is_empty() && self.euler == 2 - self.loops.len() as i64
    }
}

/// The number of the corner that a side leaves, three to a face; none outside the surface.
fn corner_at(mesh: &Mesh, side: HalfedgeId) -> u32 {
    let corner = |face| {
        let at = mesh.face_halfedges(face).iter().position(|&h| h == side)?;
        Some(small(3 * face.index() + at))
    };
    mesh.face(side).and_then(corner).unwrap_or(NONE)
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
