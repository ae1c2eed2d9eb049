//! One trial: flattens some faces and says whether they may be a patch. Cheap tests go first.

use std::cell::Cell;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Point2;

use super::params::{AreaMeasure, MergeParams};
use crate::flatten::lpfb::boundary::{BoundaryOutcome, BoundarySolver, NO_LOOP};
use crate::flatten::lpfb::interior::{InteriorSystem, PatchMeasures, Stiffness};
use crate::flatten::lpfb::patch::{Opener, Outline, Patch};
use crate::flatten::overlap::{contacts, overlapping_triangles};
use crate::flatten::small;
use crate::geometry::{Geometry, angle_sums};
use crate::linalg::LinalgError;
use crate::mesh::{EdgeId, FaceId, Mesh, VertexId};
use crate::methods::flow::Status;

/// Angle sums this close to 2π are flat: a cut that ends there opens nothing.
const FLAT: f64 = 1e-9;

/// Iterations for a boundary. A hemisphere takes 11; what takes more has no chart within any limit worth its while, and may take hundreds.
const EASY: usize = 30;

/// Relative residual of the inside beyond which a map is not to be trusted: good triangles leave 1e-13.
const WORST_RESIDUAL: f64 = 1e-6;

/// Longest dart, in roots of its patch's area.
const DART_LENGTH: f64 = 0.4;

/// Steps towards true lengths are taken where the harmonic map's change of area is at most so many times its limit.
const STEPS_HOPE: f64 = 1.5;

/// Darts are tried where the change of area is at most so many times its limit: what is further off needs more than two.
const DART_HOPE: f64 = 4.0;

/// Why some faces may not be a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reject {
    /// Virtual cuts do not make them a disk.
    Topology,
    /// They would be larger than a patch may be (fraction of the surface).
    Size(f64),
    /// No closed boundary was found.
    Boundary,
    /// The boundary turns back on itself at a corner.
    Turning,
    /// The boundary crosses itself.
    Crossing,
    /// The interior cannot be solved for.
    Degenerate,
    /// So many faces turn over.
    Flipped(usize),
    /// Faces overlap where the boundary touches itself.
    Overlap,
    /// The change of area is too large: at least this much, as far as its boundary was followed.
    Area(f64),
    /// The L² stretch is too large.
    Stretch(f64),
    /// A_tot is so large already that other trials come first.
    Later(f64),
}

/// What is asked of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub measure: AreaMeasure,
    pub area: f64,
    pub l2: f64,
    pub rigid_steps: usize,
    /// Whether darts are to be found where the change of area is too large.
    pub wants_darts: bool,
    /// A_tot from which on the trial may wait.
    pub enough: f64,
}

impl Limits {
    pub fn of(params: &MergeParams) -> Self {
        Self {
            measure: params.measure,
            area: params.area_limit,
            l2: params.l2_limit,
            rigid_steps: params.rigid_steps,
            wants_darts: false,
            enough: f64::INFINITY,
        }
    }

    /// No limits but injectivity.
    pub fn none(params: &MergeParams) -> Self {
        Self { area: f64::INFINITY, l2: f64::INFINITY, ..Self::of(params) }
    }

    /// Whether faces that were rejected so would be rejected under these limits, darts or not.
    pub fn still_reject(&self, reject: &Reject) -> bool {
        match *reject {
            Reject::Area(change) => {
                // Steps towards true lengths lower it again, and darts more so.
                let hope = match (self.wants_darts, self.rigid_steps) {
                    (true, _) => DART_HOPE,
                    (false, 0) => 1.0,
                    (false, _) => STEPS_HOPE,
                };
                change > self.area * hope
            }
            Reject::Stretch(stretch) => stretch > self.l2,
            _ => true,
        }
    }

    pub fn area_of(&self, measures: &PatchMeasures) -> f64 {
        match self.measure {
            AreaMeasure::Total => measures.area_total,
            AreaMeasure::Absolute => measures.area_absolute,
        }
    }
}

/// A map of some faces.
#[derive(Clone, Debug)]
pub struct Map {
    pub measures: PatchMeasures,
    pub angle_error: f64,
    pub closure_error: f64,
    pub loops: usize,
    /// Edges that make the patch a disk.
    pub virtual_edges: Vec<EdgeId>,
    /// Where the corners of each face lie, in the order of the faces.
    pub places: Vec<[Point2<f64>; 3]>,
}

/// Why there is no map, and the darts of which one may help: from the vertex of the largest angle defect, and from the most compressed one.
#[derive(Clone)]
pub struct Failure {
    pub reject: Reject,
    pub darts: [Option<Vec<EdgeId>>; 2],
}

impl From<Reject> for Failure {
    fn from(reject: Reject) -> Self {
        Self { reject, darts: [None, None] }
    }
}

/// The surface, and memory for trials.
#[derive(Clone)]
pub struct Bench {
    pub mesh: Arc<Mesh>,
    pub geometry: Arc<Geometry>,
    opener: Opener,
    stiffness: Arc<Stiffness>,
    angle_sums: Vec<f64>,
    /// Number of cut edges at each vertex.
    valences: Vec<u32>,
    /// Cut edges, those between patches included.
    is_cut: Vec<bool>,
    /// Edges that stay cut.
    pub is_kept: Vec<bool>,
    pub trials: usize,
}

impl Bench {
    pub fn new(mesh: Arc<Mesh>, geometry: Arc<Geometry>) -> Result<Self, LinalgError> {
        Ok(Self {
            opener: Opener::default(),
            stiffness: Arc::new(Stiffness::new(&mesh, &geometry)?),
            angle_sums: angle_sums(&mesh, &geometry),
            valences: vec![0; mesh.vertex_count()],
            is_cut: vec![false; mesh.edge_count()],
            is_kept: vec![false; mesh.edge_count()],
            trials: 0,
            mesh,
            geometry,
        })
    }

    pub fn is_cut(&self) -> &[bool] {
        &self.is_cut
    }

    pub fn valence(&self, v: VertexId) -> u32 {
        self.valences[v.index()]
    }

    pub fn set_cut(&mut self, e: EdgeId, cut: bool) {
        if self.is_cut[e.index()] == cut {
            return;
        }
        self.is_cut[e.index()] = cut;
        for v in self.mesh.edge_vertices(e) {
            if cut {
                self.valences[v.index()] += 1;
            } else {
                self.valences[v.index()] -= 1;
            }
        }
    }

    /// Removes edges from the cut, those that stay excepted. **Gives** those that were removed.
    pub fn remove(&mut self, edges: &[EdgeId]) -> Vec<EdgeId> {
        let removed: Vec<EdgeId> = edges
            .iter()
            .copied()
            .filter(|e| self.is_cut[e.index()] && !self.is_kept[e.index()])
            .collect();
        removed.iter().for_each(|&e| self.set_cut(e, false));
        removed
    }

    /// Glues tips of cuts from where edges were removed on: a cut that ends at a vertex with an angle sum of 2π or more would overlap there.
    pub fn zip(&mut self, removed: &mut Vec<EdgeId>) {
        let mut next = 0;
        while next < removed.len() {
            let e = removed[next];
            next += 1;
            for mut v in self.mesh.edge_vertices(e) {
                while let Some(tip) = self.tip_at(v) {
                    if self.angle_sums[v.index()] < TAU - FLAT || self.is_kept[tip.index()] {
                        break;
                    }
                    self.set_cut(tip, false);
                    removed.push(tip);
                    let [a, b] = self.mesh.edge_vertices(tip);
                    v = if a == v { b } else { a };
                }
            }
        }
    }

    /// The only cut edge at a vertex inside the surface.
    pub fn tip_at(&self, v: VertexId) -> Option<EdgeId> {
        if self.valences[v.index()] != 1 || self.mesh.is_boundary_vertex(v) {
            return None;
        }
        self.mesh.outgoing(v).map(|h| h.edge()).find(|e| self.is_cut[e.index()])
    }

    /// Flattens some faces along the present cut.
    pub fn flatten(&mut self, faces: &[FaceId], limits: &Limits) -> Result<Map, Failure> {
        self.trials += 1;
        let (mesh, geometry) = (self.mesh.clone(), self.geometry.clone());
        let rims = self.opener.rims(&mesh, &geometry, faces, &self.is_cut);
        let area: f64 = faces.iter().map(|f| geometry.face_areas[f.index()]).sum();
        let outline = self.opener.outline(&mesh, &geometry, &self.is_cut, &rims);
        let mut outline = outline.ok_or(Reject::Topology)?;
        let Walk { places: walk, total, outcome } = boundary(&outline, area, limits)?;
        if turns_back(&outline, &walk) {
            return Err(Reject::Turning.into());
        }
        let mut loops: Vec<Vec<Point2<f64>>> = vec![Vec::new(); rims.len()];
        for (&of, place) in outline.problem.loops.iter().zip(&walk) {
            if of != NO_LOOP {
                loops[of as usize].push(*place);
            }
        }
        let contacts = contacts(&loops.iter().map(Vec::as_slice).collect::<Vec<_>>());
        if !contacts.crossings.is_empty() {
            return Err(Reject::Crossing.into());
        }
        // The boundary leaves hope: now for what lies inside.
        let patch = self.opener.fill(&mesh, faces, &self.is_cut, rims);
        if !patch.is_opened_by_virtual_cuts() {
            return Err(Reject::Topology.into());
        }
        self.opener.name(&mut outline);
        let mut places = outline.spread(&walk, patch.vertices.len());
        let stiffness = self.stiffness.clone();
        let mut system = InteriorSystem::new(&patch, &mesh, &geometry, &stiffness)
            .map_err(|_| Reject::Degenerate)?;
        system.fill(&mut places);
        // Steps towards true lengths bring the absolute change down by a tenth or two, never by so much.
        let hope = if limits.wants_darts { DART_HOPE } else { STEPS_HOPE };
        let harmonic = match limits.measure {
            // Whatever lies inside.
            AreaMeasure::Total => None,
            AreaMeasure::Absolute => Some(system.measure(&places)),
        };
        let is_near = match harmonic {
            // No step changes the total; sums over faces differ from it by rounding.
            None => total <= limits.area * (1.0 + 1e-9),
            Some(measures) => measures.area_absolute <= limits.area * hope,
        };
        let is_refined = limits.rigid_steps > 0 && is_near;
        if is_refined {
            system.refine(&mut places, limits.rigid_steps);
        }
        if !(system.residual() <= WORST_RESIDUAL) {
            return Err(Reject::Degenerate.into());
        }
        let measures = match harmonic {
            Some(measures) if !is_refined => measures,
            _ => system.measure(&places),
        };
        let change = limits.area_of(&measures);
        if !(change <= limits.area) {
            let darts = if limits.wants_darts && change <= DART_HOPE * limits.area {
                self.darts(&patch, &places, area)
            } else {
                [None, None]
            };
            return Err(Failure { reject: Reject::Area(change), darts });
        }
        if measures.flipped > 0 {
            return Err(Reject::Flipped(measures.flipped).into());
        }
        if !(measures.l2_stretch <= limits.l2) {
            return Err(Reject::Stretch(measures.l2_stretch).into());
        }
        let corners: Vec<[Point2<f64>; 3]> =
            patch.corners.iter().map(|c| c.map(|v| places[v as usize])).collect();
        if !contacts.touches.is_empty() && !overlapping_triangles(&corners).is_empty() {
            return Err(Reject::Overlap.into());
        }
        let mut virtual_edges: Vec<EdgeId> =
            outline.problem.cuts.iter().map(|c| outline.sides[c[0] as usize].edge()).collect();
        virtual_edges.sort_unstable();
        Ok(Map {
            measures,
            angle_error: outcome.angle_error,
            closure_error: outcome.closure_error,
            loops: patch.loops.len(),
            virtual_edges,
            places: corners,
        })
    }

    /// Two darts that may help: from the inner vertex of the smallest angle sum, and from the one of positive curvature that is most compressed.
    fn darts(&self, patch: &Patch, places: &[Point2<f64>], area: f64) -> [Option<Vec<EdgeId>>; 2] {
        let mut sums = vec![[0.0f64; 2]; patch.vertices.len()];
        for (corners, f) in patch.corners.iter().zip(&patch.faces) {
            let [a, b, c] = corners.map(|v| places[v as usize]);
            let flat = 0.5 * (b - a).perp(&(c - a));
            for v in corners {
                sums[*v as usize][0] += flat;
                sums[*v as usize][1] += self.geometry.face_areas[f.index()];
            }
        }
        let mut best: [Option<(f64, usize)>; 2] = [None, None];
        for (v, [flat, true_area]) in sums.iter().enumerate() {
            let angle_sum = self.angle_sums[patch.vertices[v].index()];
            if patch.is_rim[v] || angle_sum >= TAU - FLAT {
                continue;
            }
            for (best, ratio) in best.iter_mut().zip([angle_sum / TAU, flat / true_area]) {
                if ratio < best.map_or(1.0, |b| b.0) {
                    *best = Some((ratio, v));
                }
            }
        }
        best.map(|best| self.way_to_rim(patch, best?.1, area))
    }

    /// The shortest way from an inner vertex to the rim, if it is short.
    fn way_to_rim(&self, patch: &Patch, start: usize, area: f64) -> Option<Vec<EdgeId>> {
        let (mesh, geometry) = (&*self.mesh, &*self.geometry);
        let reach = DART_LENGTH * area.sqrt();
        let mut distances = vec![f64::INFINITY; patch.vertices.len()];
        let mut before: Vec<Option<(EdgeId, u32)>> = vec![None; patch.vertices.len()];
        let mut queue = BinaryHeap::new();
        distances[start] = 0.0;
        queue.push(Reverse((0.0f64.to_bits(), small(start))));
        while let Some(Reverse((bits, vertex))) = queue.pop() {
            let (distance, v) = (f64::from_bits(bits), vertex as usize);
            if distance > distances[v] {
                continue;
            }
            if patch.is_rim[v] {
                let mut path = Vec::new();
                let mut at = v;
                while let Some((e, from)) = before[at] {
                    path.push(e);
                    at = from as usize;
                }
                return Some(path);
            }
            // Off the rim, all that leaves the mesh vertex lies inside the patch.
            for h in mesh.outgoing(patch.vertices[v]) {
                let tip = self.opener.vertex_at(mesh.next(h));
                let along = distance + geometry.edge_length(h.edge());
                if along <= reach && along < distances[tip as usize] {
                    distances[tip as usize] = along;
                    before[tip as usize] = Some((h.edge(), vertex));
                    queue.push(Reverse((along.to_bits(), tip)));
                }
            }
        }
        None
    }
}

/// A boundary that leaves hope.
struct Walk {
    /// Where each side of the outline begins.
    places: Vec<Point2<f64>>,
    /// A_tot.
    total: f64,
    outcome: BoundaryOutcome,
}

/// Solves for a boundary as far as it takes to see that it is none.
///
/// The polygon alone tells the total change of area, which the absolute one is never below.
fn boundary(outline: &Outline, area: f64, limits: &Limits) -> Result<Walk, Reject> {
    let mut solver = BoundarySolver::new(&outline.problem);
    let most = if limits.wants_darts { DART_HOPE * limits.area } else { limits.area };
    let total_of = |flat: f64| (flat - area).abs() / area;
    let look = |total: f64| match total {
        _ if !(total <= most) => Some(Reject::Area(total)),
        _ if total > limits.enough => Some(Reject::Later(total)),
        _ => None,
    };
    let perimeter: f64 = {
        let of = outline.problem.loops.iter().zip(&outline.problem.lengths);
        of.filter(|(of, _)| **of != NO_LOOP).map(|(_, length)| length).sum()
    };
    let rough = Cell::new(None);
    let outcome = solver.solve_until(EASY, |change, flat| {
        // What the area may change by until the polygon is found: see `solve_until`.
        let least = total_of(flat) - change * perimeter * perimeter / (2.0 * area);
        rough.set(look(least));
        rough.get().is_some()
    });
    match outcome.status {
        Status::Converged => {}
        Status::Running => return Err(rough.get().unwrap_or(Reject::Boundary)),
        _ => return Err(Reject::Boundary),
    }
    let places = solver.places();
    let total = total_of(shoelace(&places));
    look(total).map_or(Ok(Walk { places, total, outcome }), Err)
}

/// Signed area within a polygon; virtual cuts cancel.
fn shoelace(places: &[Point2<f64>]) -> f64 {
    let n = places.len();
    let from = |i: usize| places[i % n] - places[0];
    (0..n).map(|i| 0.5 * from(i).perp(&from(i + 1))).sum()
}

/// Whether the outline of a disk turns by half a turn or more at a corner, so that all turns, each told up to full turns, do not add up to
/// a full one: it overlaps itself there. Outlines with virtual cuts are left to the search for crossings.
fn turns_back(outline: &Outline, places: &[Point2<f64>]) -> bool {
    let n = places.len();
    let at = |i: usize| places[i % n];
    let turn = |i: usize| {
        let (before, on) = (at(i) - at(i + n - 1), at(i + 1) - at(i));
        before.perp(&on).atan2(before.dot(&on))
    };
    outline.problem.cuts.is_empty() && ((0..n).map(turn).sum::<f64>() - TAU).abs() > 1.0
}
