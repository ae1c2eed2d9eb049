//! Seams that run where a cut is cheapest: minimum cuts between adjacent charts \[KT03\].
//!
//! For one pair of charts after the other, the faces within some rings of their seam may change sides. The new seam is the minimum cut of
//! their dual graph between what lies behind the band on both sides; an edge costs its length, less at creases, least in valleys, times what the user
//! asks for there. What the two border on elsewhere stays: an edge to a third chart is a seam whichever of the two has it. So the cost of
//! all seams falls with every change.
//!
//! Guaranteed: charts stay connected and keep faces; no seam gets longer unless that is allowed. Not guaranteed: that charts remain as flat as they
//! were: see [`RefineParams::tolerance`] and the gate of [`RefineFlow::step_if`].

mod capacity;
mod cut;

use std::collections::BTreeSet;
use std::sync::Arc;

use nalgebra::Vector3;

use super::{connected_charts, small};
use crate::geometry::Geometry;
use crate::mesh::{FaceId, Mesh};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};
use capacity::Capacities;
use cut::Scratch;

/// Options of a [`RefineFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefineParams {
    /// How many rings of faces on each side of a seam may change sides.
    pub rings: usize,
    /// How much of the angle of a convex crease counts; of a concave one all.
    pub convex: f64,
    /// How often every pair has its turn, at most.
    pub passes: usize,
    /// Largest error Σ a |n − N|² that a chart may come to have, as a fraction of the surface's area; one that has more may not have more still.
    pub tolerance: f64,
    /// Whether seams may get longer where creases are cheaper.
    pub may_lengthen: bool,
}

impl Default for RefineParams {
    fn default() -> Self {
        Self { rings: 3, convex: 0.15, passes: 4, tolerance: f64::INFINITY, may_lengthen: false }
    }
}

impl RefineParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        within("rings about seams", self.rings as f64, 1.0, 100.0)?;
        within("weight of convex creases", self.convex, 0.0, 1.0)?;
        within("passes over seams", self.passes as f64, 0.0, 1000.0)?;
        within("tolerance of refined charts", self.tolerance, 0.0, f64::INFINITY)
    }
}

/// The charts so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RefineState {
    /// For each face its chart.
    pub face_charts: Vec<u32>,
    /// Number of charts.
    pub charts: usize,
    /// What all seams cost.
    pub cost: f64,
    /// Their length.
    pub length: f64,
    /// Pairs whose seam was moved, over all passes.
    pub moved: usize,
    /// Pairs whose cheaper seam was refused, over all passes.
    pub refused: usize,
    /// Passes begun.
    pub pass: usize,
    /// The pair of the last step.
    pub pair: Option<[u32; 2]>,
}

/// Moves seams to where a cut is cheapest, one pair of charts a step.
///
/// **Minimises** Σ over seam edges of length · price / (1 + d / mean d), see the module. **Step** one pair of charts: a maximum flow on the faces near their
/// seam. **Ends** `Converged` when no pair gives a cheaper seam that is accepted; `StepLimit` after so many passes.
#[derive(Clone)]
pub struct RefineFlow {
    mesh: Arc<Mesh>,
    params: RefineParams,
    capacities: Capacities,
    normals: Vec<Vector3<f64>>,
    areas: Vec<f64>,
    total_area: f64,
    scratch: Scratch,
    progress: RefineCheckpoint,
}

/// Where a [`RefineFlow`] can go back to.
#[derive(Clone, Debug, PartialEq)]
pub struct RefineCheckpoint {
    state: RefineState,
    chart_faces: Vec<Vec<FaceId>>,
    /// Pairs to be tried in this pass, the next one last.
    queue: Vec<[u32; 2]>,
    /// Pairs of the next pass: those beside something that has changed.
    next: BTreeSet<[u32; 2]>,
    step: usize,
    status: Status,
}

impl RefineFlow {
    /// Prepares.
    ///
    /// **Takes** a label for each face, any numbers: the connected parts of each are the charts, numbered by first face; and what a seam along each edge costs
    /// beyond its length, ≥ 0, 1 for nothing special (empty: 1 everywhere).
    /// **Fails** on parameters out of range and on prices that are negative or not finite. **Costs** O(F).
    pub fn new(
        mesh: Arc<Mesh>,
        geometry: &Geometry,
        labels: &[u32],
        params: RefineParams,
        prices: &[f64],
    ) -> Result<Self, SolveError> {
        params.validate()?;
        assert!(prices.is_empty() || prices.len() == mesh.edge_count());
        for &price in prices {
            SolveError::within("price of seams", price, 0.0, f64::MAX)?;
        }
        let capacities = Capacities::new(&mesh, geometry, params.convex, prices);
        let (face_charts, charts) = connected_charts(&mesh, labels);
        let mut chart_faces = vec![Vec::new(); charts];
        for f in mesh.faces() {
            chart_faces[face_charts[f.index()] as usize].push(f);
        }
        let state = RefineState { face_charts, charts, ..RefineState::default() };
        let mut flow = Self {
            normals: geometry.face_normals(&mesh),
            areas: geometry.face_areas.clone(),
            total_area: geometry.total_area(),
            scratch: Scratch::new(mesh.face_count()),
            mesh,
            params,
            capacities,
            progress: RefineCheckpoint {
                state,
                chart_faces,
                queue: Vec::new(),
                next: BTreeSet::new(),
                step: 0,
                status: Status::Running,
            },
        };
        flow.progress.next = flow.pairs(|_| true);
        flow.measure();
        if !flow.progress.state.cost.is_finite() {
            return Err(SolveError::NotFinite);
        }
        Ok(flow)
    }

    /// Options in force.
    pub fn params(&self) -> &RefineParams {
        &self.params
    }

    /// How it stands.
    pub fn status(&self) -> Status {
        self.progress.status
    }

    /// What it takes to come back to where it is.
    pub fn checkpoint(&self) -> RefineCheckpoint {
        self.progress.clone()
    }

    /// Goes back to a checkpoint of a flow on the same surface with the same options. Later steps repeat bit for bit, given the same answers.
    pub fn restore(&mut self, checkpoint: &RefineCheckpoint) {
        self.progress = checkpoint.clone();
    }

    /// A step whose change is made only if it is accepted.
    ///
    /// **Takes** a gate, asked with the charts as they would be and the pair that differs, at most once.
    pub fn step_if(
        &mut self,
        accepts: &mut dyn FnMut(&[u32], [u32; 2]) -> bool,
    ) -> Result<StepReport, SolveError> {
        if self.progress.status == Status::Running {
            self.advance(accepts);
            self.progress.step += 1;
        }
        let state = &self.progress.state;
        Ok(StepReport {
            step: self.progress.step,
            energy: vec![("cost of seams", state.cost), ("length of seams", state.length)],
            residual: 0.0,
            progress: None,
            status: self.progress.status,
        })
    }

    fn advance(&mut self, accepts: &mut dyn FnMut(&[u32], [u32; 2]) -> bool) {
        if self.progress.queue.is_empty() {
            let next = std::mem::take(&mut self.progress.next);
            if next.is_empty() {
                self.progress.status = Status::Converged;
                return;
            }
            if self.progress.state.pass >= self.params.passes {
                self.progress.next = next;
                self.progress.status = Status::StepLimit;
                return;
            }
            self.progress.state.pass += 1;
            self.progress.queue = next.into_iter().rev().collect();
        }
        let Some(pair) = self.progress.queue.pop() else { return };
        self.progress.state.pair = Some(pair);
        let progress = &mut self.progress;
        let [a, b] = pair.map(|c| progress.chart_faces[c as usize].as_slice());
        let rings = small(self.params.rings);
        let charts = &progress.state.face_charts;
        let (mesh, capacities) = (&self.mesh, &self.capacities);
        let found = self.scratch.cheaper(mesh, capacities, charts, pair, [a, b], rings);
        let Some(moved) = found else { return };
        // Rounding of two sums of the same kind.
        let may_be =
            self.params.may_lengthen || moved.lengths[1] <= moved.lengths[0] * (1.0 + 1e-12);
        let before = pair.map(|c| self.error(&self.progress.chart_faces[c as usize]));
        self.swap(&moved.faces, pair);
        let faces = self.faces_of(pair);
        if may_be
            && self.is_sound(pair, &faces, before)
            && accepts(&self.progress.state.face_charts, pair)
        {
            let [a, b] = faces;
            self.progress.chart_faces[pair[0] as usize] = a;
            self.progress.chart_faces[pair[1] as usize] = b;
            self.progress.state.moved += 1;
            self.measure();
            let near = self.pairs(|c| pair.contains(&c));
            self.progress.next.extend(near);
        } else {
            self.swap(&moved.faces, pair);
            self.progress.state.refused += 1;
        }
    }

    /// Lets faces change sides.
    fn swap(&mut self, faces: &[FaceId], [a, b]: [u32; 2]) {
        for f in faces {
            let chart = &mut self.progress.state.face_charts[f.index()];
            *chart = if *chart == a { b } else { a };
        }
    }

    /// The faces of a pair as they are labelled now, in increasing order.
    fn faces_of(&self, pair: [u32; 2]) -> [Vec<FaceId>; 2] {
        let charts = &self.progress.state.face_charts;
        let mut both: Vec<FaceId> =
            pair.iter().flat_map(|&c| self.progress.chart_faces[c as usize].clone()).collect();
        both.sort_unstable();
        pair.map(|c| both.iter().copied().filter(|f| charts[f.index()] == c).collect())
    }

    /// Whether both charts of a pair are connected, have faces, and are as flat as is asked for.
    fn is_sound(&self, pair: [u32; 2], faces: &[Vec<FaceId>; 2], before: [f64; 2]) -> bool {
        let limit = self.params.tolerance * self.total_area;
        (0..2).all(|i| {
            self.is_connected(pair[i], &faces[i])
                && (limit.is_infinite() || self.error(&faces[i]) <= limit.max(before[i]))
        })
    }

    fn is_connected(&self, chart: u32, faces: &[FaceId]) -> bool {
        let Some(&first) = faces.first() else { return false };
        let charts = &self.progress.state.face_charts;
        let mut is_seen = vec![false; faces.len()];
        is_seen[0] = true;
        let mut stack = vec![first];
        let mut count = 1;
        while let Some(f) = stack.pop() {
            for g in
                self.mesh.face_halfedges(f).into_iter().filter_map(|h| self.mesh.face(h.twin()))
            {
                if charts[g.index()] != chart {
                    continue;
                }
                let Ok(at) = faces.binary_search(&g) else { continue };
                if !std::mem::replace(&mut is_seen[at], true) {
                    count += 1;
                    stack.push(g);
                }
            }
        }
        count == faces.len()
    }

    /// Σ a |n − N|² = 2 (Σ a − |Σ a n|).
    fn error(&self, faces: &[FaceId]) -> f64 {
        let mut area = 0.0;
        let mut sum = Vector3::zeros();
        for f in faces {
            area += self.areas[f.index()];
            sum += self.normals[f.index()] * self.areas[f.index()];
        }
        2.0 * (area - sum.norm())
    }

    /// Adjacent charts, one of them as wanted.
    fn pairs(&self, is_wanted: impl Fn(u32) -> bool) -> BTreeSet<[u32; 2]> {
        let charts = &self.progress.state.face_charts;
        let mut pairs = BTreeSet::new();
        for e in self.mesh.edges() {
            let h = e.halfedge();
            let (Some(f), Some(g)) = (self.mesh.face(h), self.mesh.face(h.twin())) else {
                continue;
            };
            let [a, b] = [charts[f.index()], charts[g.index()]];
            if a != b && (is_wanted(a) || is_wanted(b)) {
                pairs.insert([a.min(b), a.max(b)]);
            }
        }
        pairs
    }

    /// Cost and length of all seams.
    fn measure(&mut self) {
        let charts = &self.progress.state.face_charts;
        let (mut cost, mut length) = (0.0, 0.0);
        for e in self.mesh.edges() {
            let h = e.halfedge();
            let (Some(f), Some(g)) = (self.mesh.face(h), self.mesh.face(h.twin())) else {
                continue;
            };
            if charts[f.index()] != charts[g.index()] {
                cost += self.capacities.edge_costs[e.index()];
                length += self.capacities.lengths[e.index()];
            }
        }
        self.progress.state.cost = cost;
        self.progress.state.length = length;
    }
}

impl Flow for RefineFlow {
    type State = RefineState;

    fn state(&self) -> &RefineState {
        &self.progress.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        self.step_if(&mut |_, _| true)
    }
}
