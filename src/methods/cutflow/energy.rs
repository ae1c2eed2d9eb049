//! The objective on a given cut, its exact derivative with respect to the crossings, and the linear algebra of both.
//!
//! J = w_D uᵀAu + w_H ∫b(u) + α |γ| + w_η ∫_γ η − w_A |P₀| with A u = f on every patch, u = 0 on cut and boundary. Cut points carry
//! u = 0 and drop out: **the unknowns are always the original vertices**, the matrix pattern is that of the mesh's Laplacian
//! (entries between patches become zero), and one symbolic analysis serves the whole run.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Vector2;

use super::cut::{Corner, CrossedFace, Cut, FacePoints, Frames, NONE, Node, Segment};
use super::terms::{CutFields, Energy, Pointwise, Source, Weights, mean_square};
use crate::geometry::{Geometry, Laplacian, face_curvatures};
use crate::linalg::{Analysis, Factor, LinalgError, dot};
use crate::mesh::{EdgeId, FaceId, Mesh, VertexId};

/// Everything that does not change while the cut moves.
pub(super) struct Problem {
    pub mesh: Arc<Mesh>,
    pub geometry: Arc<Geometry>,
    pub frames: Frames,
    /// K of every face.
    pub face_sources: Vec<f64>,
    /// η of every vertex, or empty.
    pub penalty: Vec<f64>,
    /// How far each vertex holds the cut, from 0 to 1, or empty.
    pub pins: Vec<f64>,
    /// r³ of every face, or empty while it is not asked for.
    pub scales: Vec<f64>,
    pub analysis: Arc<Analysis>,
    edge_slots: Vec<u32>,
    /// A and f of the uncut surface, boundary vertices eliminated.
    base_values: Vec<f64>,
    base_rhs: Vec<f64>,
    is_boundary: Vec<bool>,
    /// Vertices of closed components that the initial cut leaves whole: they take no part.
    inert: Vec<bool>,
    face_components: Vec<u32>,
    /// Number of the components that they form.
    pub resting: usize,
    /// Components that a cut must not leave whole: closed, and not inert.
    needs_cut: Vec<bool>,
}

/// The Yamabe solution on one cut: u, its energy, and the matrix that gave it.
#[derive(Default)]
pub(super) struct Solution {
    pub u: Vec<f64>,
    pub energy: Energy,
    /// Largest residual of A u = f over the largest entry of f.
    pub residual: f64,
    /// Which matrix it was solved with: see [`SharedFactor`].
    stamp: u64,
    values: Vec<f64>,
    rhs: Vec<f64>,
    scratch: Vec<f64>,
}

/// The one factor of a flow: that of the matrix which was factored last.
///
/// A factor is by far the largest thing that a flow holds, and the next trial overwrites it; a solution that needs its own again,
/// because the trial was refused, has it made anew.
#[derive(Default)]
pub(super) struct SharedFactor {
    factor: Option<Factor>,
    /// The matrix that it holds; 0 while it holds none.
    holds: u64,
    count: u64,
}

impl SharedFactor {
    /// Factors a matrix. **Gives** the stamp by which it is told from others.
    pub fn refactor(
        &mut self,
        analysis: &Arc<Analysis>,
        values: &[f64],
    ) -> Result<u64, LinalgError> {
        self.holds = 0;
        match &mut self.factor {
            Some(factor) => factor.refactor(values)?,
            None => self.factor = Some(Factor::new(analysis.clone(), values)?),
        }
        self.count += 1;
        self.holds = self.count;
        Ok(self.count)
    }

    /// Solves with the matrix that was factored last.
    pub fn solve(&mut self, rhs: &mut [f64]) {
        if let Some(factor) = &mut self.factor {
            factor.solve(rhs, 1);
        }
    }

    /// The factor of a solution's matrix.
    pub fn of(
        &mut self,
        analysis: &Arc<Analysis>,
        solution: &mut Solution,
    ) -> Result<&mut Factor, LinalgError> {
        if self.holds != solution.stamp {
            solution.stamp = self.refactor(analysis, &solution.values)?;
        }
        let size = analysis.pattern().size();
        self.factor.as_mut().ok_or(LinalgError::OutOfMemory { size })
    }

    /// Gives its memory back.
    pub fn release(&mut self) {
        (self.factor, self.holds) = (None, 0);
    }
}

impl Problem {
    pub fn new(mesh: Arc<Mesh>, geometry: Arc<Geometry>) -> Result<Self, LinalgError> {
        let laplacian = Laplacian::new(&mesh, &geometry);
        let is_boundary: Vec<bool> = mesh.vertices().map(|v| mesh.is_boundary_vertex(v)).collect();
        let Laplacian { pattern, edge_slots, values: mut base_values, .. } = laplacian;
        for e in mesh.edges() {
            if mesh.edge_vertices(e).iter().any(|v| is_boundary[v.index()]) {
                base_values[edge_slots[e.index()] as usize] = 0.0;
            }
        }
        let frames = Frames::new(&mesh, &geometry);
        let inert = vec![false; mesh.vertex_count()];
        let topology = mesh.topology();
        let mut needs_cut = vec![true; topology.components];
        for &h in mesh.boundary_loops() {
            if let Some(f) = mesh.face(h.twin()) {
                needs_cut[topology.face_components[f.index()] as usize] = false;
            }
        }
        let analysis = Arc::new(Analysis::new(pattern)?);
        let mut problem = Self {
            mesh,
            geometry,
            frames,
            face_sources: Vec::new(),
            penalty: Vec::new(),
            pins: Vec::new(),
            scales: Vec::new(),
            analysis,
            edge_slots,
            base_values,
            base_rhs: Vec::new(),
            is_boundary,
            inert,
            resting: 0,
            face_components: topology.face_components,
            needs_cut,
        };
        for v in problem.mesh.vertices() {
            if problem.is_boundary[v.index()] || problem.mesh.halfedge(v).is_none() {
                problem.pin(v);
            }
        }
        problem.set_fields(&CutFields::default());
        Ok(problem)
    }

    /// Puts sources and penalties in force. Their shapes have been checked.
    pub fn set_fields(&mut self, fields: &CutFields) {
        let mesh = &self.mesh;
        let areas = &self.geometry.face_areas;
        self.penalty.clone_from(&fields.penalty);
        self.pins.clone_from(&fields.pins);
        self.face_sources = match &fields.source {
            Source::Curvature => face_curvatures(mesh, &self.geometry),
            Source::Uniform => vec![4.0 * PI / self.geometry.total_area(); mesh.face_count()],
            Source::Heat(density) => {
                let means: Vec<f64> = mesh
                    .triangles()
                    .iter()
                    .map(|t| t.iter().map(|v| density[v.index()]).sum::<f64>() / 3.0)
                    .collect();
                let total: f64 = means.iter().zip(areas).map(|(m, a)| m * a).sum();
                means.iter().map(|m| 4.0 * PI * m / total).collect()
            }
        };
        self.base_rhs = vec![0.0; mesh.vertex_count()];
        for f in mesh.faces() {
            let share = self.face_sources[f.index()] * areas[f.index()] / 3.0;
            for v in mesh.face_vertices(f) {
                self.base_rhs[v.index()] -= share;
            }
        }
        for v in mesh.vertices() {
            if self.is_pinned(v) || mesh.halfedge(v).is_none() {
                self.base_rhs[v.index()] = 0.0;
            }
        }
    }

    /// Computes r³ if it is asked for and was not yet.
    pub fn prepare_rescaling(&mut self, weights: &Weights) -> Result<(), LinalgError> {
        if weights.rescaled && self.scales.is_empty() {
            self.scales = feature_scales(&self.mesh, &self.geometry, &self.analysis)?;
        }
        Ok(())
    }

    /// Makes a vertex's equation u = 0. Its off-diagonal entries must be zero already or be zeroed by the caller.
    fn pin(&mut self, v: VertexId) {
        let slot = self.analysis.pattern().diagonal(v.index());
        self.base_values[slot] = 1.0;
        if let Some(x) = self.base_rhs.get_mut(v.index()) {
            *x = 0.0;
        }
    }

    /// Takes the closed components that a cut leaves whole out of the problem: on them Δu = −K has no solution with u = 0
    /// anywhere.
    pub fn rest_uncut_components(&mut self, cut: &Cut) {
        let uncut = self.uncut_components(cut);
        self.resting = uncut.iter().filter(|uncut| **uncut).count();
        for f in self.mesh.faces().filter(|f| uncut[self.face_components[f.index()] as usize]) {
            for h in self.mesh.face_halfedges(f) {
                self.base_values[self.edge_slots[h.edge().index()] as usize] = 0.0;
            }
            for v in self.mesh.face_vertices(f) {
                self.inert[v.index()] = true;
            }
        }
        for v in self.mesh.vertices() {
            if self.inert[v.index()] {
                self.pin(v);
            }
        }
        for (needs, uncut) in self.needs_cut.iter_mut().zip(uncut) {
            *needs &= !uncut;
        }
    }

    /// Whether a cut leaves a component whole that it must not.
    pub fn misses_a_component(&self, cut: &Cut) -> bool {
        self.uncut_components(cut).contains(&true)
    }

    fn uncut_components(&self, cut: &Cut) -> Vec<bool> {
        let mut uncut = self.needs_cut.clone();
        for crossed in &cut.faces {
            uncut[self.face_components[crossed.face.index()] as usize] = false;
        }
        uncut
    }

    /// Whether a vertex is held: u = 0 there whatever the cut.
    pub fn is_pinned(&self, v: VertexId) -> bool {
        self.is_boundary[v.index()] || self.inert[v.index()]
    }

    /// Where the entry of an edge stands in the pattern.
    pub fn edge_slot(&self, e: EdgeId) -> usize {
        self.edge_slots[e.index()] as usize
    }

    /// A and f on the cut surface: those of the uncut one with the crossed faces' parts replaced.
    ///
    /// With one side only, nothing drives u on the other: u = 0 there, and it costs nothing.
    fn assemble(
        &self,
        cut: &Cut,
        labels: &[u32],
        weights: &Weights,
        values: &mut Vec<f64>,
        rhs: &mut Vec<f64>,
    ) {
        values.clone_from(&self.base_values);
        rhs.clone_from(&self.base_rhs);
        let pattern = self.analysis.pattern();
        for crossed in &cut.faces {
            let f = crossed.face;
            let vertices = self.mesh.face_vertices(f);
            let free = vertices.map(|v| !self.is_pinned(v));
            let halfedges = self.mesh.face_halfedges(f);
            let cotangents = self.geometry.corner_cotangents[f.index()];
            let curvature = self.face_sources[f.index()];
            for i in 0..3 {
                let j = (i + 1) % 3;
                let weight = 0.5 * cotangents[(i + 2) % 3];
                if free[i] && free[j] {
                    values[self.edge_slots[halfedges[i].edge().index()] as usize] += weight;
                }
                for k in [i, j] {
                    if free[k] {
                        values[pattern.diagonal(vertices[k].index())] -= weight;
                    }
                }
                if free[i] {
                    rhs[vertices[i].index()] +=
                        curvature * self.geometry.face_areas[f.index()] / 3.0;
                }
            }
            let points = cut.face_points(&self.mesh, &self.frames, crossed);
            for (triangle, weight) in points.weighted_triangles(crossed.lone) {
                let share = weight * curvature * points.area(triangle) / 3.0;
                for corner in triangle {
                    if let Corner::Vertex(i) = corner
                        && free[i]
                    {
                        rhs[vertices[i].index()] -= share;
                    }
                }
            }
            for (triangle, _) in points.triangles(crossed.lone) {
                let element = Element::new(&points, triangle);
                for (a, corner) in triangle.into_iter().enumerate() {
                    let Corner::Vertex(i) = corner else { continue };
                    if !free[i] {
                        continue;
                    }
                    values[pattern.diagonal(vertices[i].index())] += element.stiffness(a, a);
                    let b = (a + 1) % 3;
                    if let Corner::Vertex(j) = triangle[b]
                        && free[j]
                    {
                        let side = if (i + 1) % 3 == j { i } else { j };
                        values[self.edge_slots[halfedges[side].edge().index()] as usize] +=
                            element.stiffness(a, b);
                    }
                }
            }
        }
        // Between patches nothing may be left of the differences above, not even rounding.
        for crossing in &cut.crossings {
            values[self.edge_slots[crossing.edge.index()] as usize] = 0.0;
        }
        if weights.one_sided {
            for (f, &label) in rhs.iter_mut().zip(labels) {
                if label != 0 {
                    *f = 0.0;
                }
            }
        }
    }

    /// Calls `visit` for every (sub-)triangle with its weighted area and the values of u at its corners (0 on the cut); corners that
    /// are vertices come with their id.
    fn for_elements(
        &self,
        cut: &Cut,
        u: &[f64],
        mut visit: impl FnMut(f64, [f64; 3], [Option<VertexId>; 3]),
    ) {
        self.for_faces(cut, |f, vertices, crossed| {
            let Some(crossed) = crossed else {
                let area = self.geometry.face_areas[f.index()];
                visit(area, vertices.map(|v| u[v.index()]), vertices.map(Some));
                return;
            };
            let points = cut.face_points(&self.mesh, &self.frames, crossed);
            for (triangle, weight) in points.weighted_triangles(crossed.lone) {
                let at = triangle.map(|corner| match corner {
                    Corner::Vertex(i) => Some(vertices[i]),
                    _ => None,
                });
                visit(
                    weight * points.area(triangle),
                    at.map(|v| v.map_or(0.0, |v| u[v.index()])),
                    at,
                );
            }
        });
    }

    /// Calls `visit` for every face in order, with what the cut does there.
    fn for_faces(
        &self,
        cut: &Cut,
        mut visit: impl FnMut(FaceId, [VertexId; 3], Option<&CrossedFace>),
    ) {
        let mut next_crossed = cut.faces.iter().peekable();
        for f in self.mesh.faces() {
            let crossed = next_crossed.next_if(|c| c.face == f);
            visit(f, self.mesh.face_vertices(f), crossed);
        }
    }

    /// Area of region 0.
    fn area(&self, cut: &Cut, labels: &[u32]) -> f64 {
        let mut area = 0.0;
        self.for_faces(cut, |f, vertices, crossed| {
            let inside = vertices.map(|v| labels[v.index()] == 0);
            match crossed {
                None if inside[0] => area += self.geometry.face_areas[f.index()],
                Some(crossed) if inside.contains(&true) => {
                    let points = cut.face_points(&self.mesh, &self.frames, crossed);
                    for (triangle, _) in points.triangles(crossed.lone) {
                        if is_inside(triangle, inside) {
                            area += points.area(triangle);
                        }
                    }
                }
                _ => {}
            }
        });
        area
    }

    /// A_a u for the stiffness of ∫r³|∇u|².
    fn rescaled_stiffness(&self, cut: &Cut, u: &[f64]) -> Vec<f64> {
        let mut result = vec![0.0; u.len()];
        self.for_faces(cut, |f, vertices, crossed| {
            let scale = self.scales[f.index()];
            let Some(crossed) = crossed else {
                for i in 0..3 {
                    let (a, b) = (vertices[i].index(), vertices[(i + 1) % 3].index());
                    let cotangent = self.geometry.corner_cotangents[f.index()][(i + 2) % 3];
                    let flow = 0.5 * scale * cotangent * (u[a] - u[b]);
                    result[a] += flow;
                    result[b] -= flow;
                }
                return;
            };
            let points = cut.face_points(&self.mesh, &self.frames, crossed);
            for (triangle, _) in points.triangles(crossed.lone) {
                let element = Element::new(&points, triangle);
                let value = |corner| match corner {
                    Corner::Vertex(i) => u[vertices[i].index()],
                    _ => 0.0,
                };
                let gradient = element.gradient(triangle.map(value));
                for (corner, hat) in triangle.into_iter().zip(&element.gradients) {
                    if let Corner::Vertex(i) = corner {
                        result[vertices[i].index()] += scale * element.area * hat.dot(&gradient);
                    }
                }
            }
        });
        for v in self.mesh.vertices() {
            if self.is_pinned(v) {
                result[v.index()] = 0.0;
            }
        }
        result
    }

    /// η at the crossings; empty where there is none.
    fn crossing_penalties(&self, cut: &Cut) -> Vec<f64> {
        if self.penalty.is_empty() {
            return Vec::new();
        }
        let at = |v: VertexId| self.penalty[v.index()];
        cut.crossings
            .iter()
            .map(|c| {
                let [a, b] = self.mesh.edge_vertices(c.edge).map(at);
                a + (b - a) * c.t
            })
            .collect()
    }

    /// ∫_γ η.
    fn penalty_of(&self, cut: &Cut) -> f64 {
        let at = self.crossing_penalties(cut);
        if at.is_empty() {
            return 0.0;
        }
        cut.segments.iter().map(|s| s.length * mean_penalty(cut, &at, s.ends)).sum()
    }

    /// Solves for u on a cut and measures J; memory of `old` is reused.
    ///
    /// **Fails** where a patch has neither cut nor boundary.
    pub fn solve(
        &self,
        cut: &Cut,
        labels: &[u32],
        weights: &Weights,
        old: Option<Solution>,
        shared: &mut SharedFactor,
    ) -> Result<Solution, LinalgError> {
        let mut solution = old.unwrap_or_default();
        self.assemble(cut, labels, weights, &mut solution.values, &mut solution.rhs);
        solution.stamp = shared.refactor(&self.analysis, &solution.values)?;
        solution.u.clone_from(&solution.rhs);
        shared.solve(&mut solution.u);
        solution.scratch.resize(solution.u.len(), 0.0);
        self.analysis.pattern().multiply(&solution.values, &solution.u, &mut solution.scratch);
        let (mut error, mut size) = (0.0f64, 1e-300f64);
        for (a, b) in solution.scratch.iter().zip(&solution.rhs) {
            error = error.max((a - b).abs());
            size = size.max(b.abs());
        }
        solution.residual = error / size;
        let u = &solution.u;
        let mut energy = Energy {
            dirichlet: dot(u, &solution.rhs),
            length: cut.length,
            penalty: self.penalty_of(cut),
            ..Energy::default()
        };
        let b = weights.pointwise;
        let is_square = b == Pointwise::Square;
        self.for_elements(cut, u, |area, values, _| {
            energy.hencky += area * mean_square(values);
            if !is_square {
                energy.pointwise += area * b.mean(values).0;
            }
        });
        if weights.rescaled {
            energy.rescaled = dot(u, &self.rescaled_stiffness(cut, u));
        }
        if weights.area > 0.0 {
            energy.area = self.area(cut, labels);
        }
        energy.total = weights.total(&energy);
        solution.energy = energy;
        Ok(solution)
    }

    /// dJ/dt for every crossing: exact for the discrete J.
    ///
    /// With the adjoint q the Lagrangian J − qᵀ(A u − f) has the same derivative as J, and every sub-triangle
    /// pulls at its corners with a force that is a polynomial of gradients. **From** [VSC] Table 1 in its discrete form.
    /// **Differs**: the paper recovers a flux on the cut and squares it; differentiating the discrete J instead makes the
    /// predicted decrease the true one. **Costs** one solve if w_H > 0 or energies are rescaled.
    pub fn crossing_forces(
        &self,
        cut: &Cut,
        labels: &[u32],
        weights: &Weights,
        solution: &mut Solution,
        shared: &mut SharedFactor,
    ) -> Result<Vec<f64>, LinalgError> {
        let mut forces = vec![0.0; cut.crossings.len()];
        let adjoint = self.adjoint(cut, weights, solution, shared)?;
        let penalties =
            if weights.penalty > 0.0 { self.crossing_penalties(cut) } else { Vec::new() };
        let u = &solution.u;
        for crossed in &cut.faces {
            let vertices = self.mesh.face_vertices(crossed.face);
            let points = cut.face_points(&self.mesh, &self.frames, crossed);
            let mut side_forces = [Vector2::zeros(); 3];
            let mut centre_force = Vector2::zeros();
            let mut pull = |triangle: [Corner; 3], forces: [Vector2<f64>; 3]| {
                for (corner, force) in triangle.into_iter().zip(forces) {
                    match corner {
                        Corner::Vertex(_) => {}
                        Corner::Side(i) => side_forces[i] += force,
                        Corner::Centre => centre_force += force,
                    }
                }
            };
            let value = |field: &[f64], triangle: [Corner; 3]| {
                triangle.map(|corner| match corner {
                    Corner::Vertex(i) => field[vertices[i].index()],
                    _ => 0.0,
                })
            };
            let stiffness = weights.dirichlet
                * if weights.rescaled { self.scales[crossed.face.index()] } else { 1.0 };
            let inside = vertices.map(|v| labels[v.index()] == 0);
            for (triangle, _) in points.triangles(crossed.lone) {
                let element = Element::new(&points, triangle);
                let (u, q) = (value(u, triangle), value(&adjoint, triangle));
                pull(triangle, element.stiffness_forces(u, q, stiffness));
            }
            let curvature = self.face_sources[crossed.face.index()];
            for (triangle, weight) in points.weighted_triangles(crossed.lone) {
                let element = Element::new(&points, triangle);
                let (u, q) = (value(u, triangle), value(&adjoint, triangle));
                let mut pressure = weights.hencky * weights.pointwise.mean(u).0
                    - curvature / 3.0 * q.iter().sum::<f64>();
                if is_inside(triangle, inside) {
                    pressure -= weights.area;
                }
                pull(triangle, element.mass_forces(weight * pressure));
            }
            let count = if crossed.lone == 3 { 3 } else { 1 };
            let mut tensions = [weights.length; 3];
            if !penalties.is_empty() {
                for (i, tension) in tensions.iter_mut().enumerate().take(count) {
                    let segment = &cut.segments[crossed.first_segment as usize + i];
                    *tension += weights.penalty * mean_penalty(cut, &penalties, segment.ends);
                    self.add_penalty_forces(cut, weights.penalty, segment, &mut forces);
                }
            }
            add_tensions(crossed, &points, tensions, &mut side_forces, &mut centre_force);
            for (i, h) in self.mesh.face_halfedges(crossed.face).into_iter().enumerate() {
                if crossed.crossings[i] == NONE {
                    continue;
                }
                let mut force = side_forces[i];
                if crossed.lone == 3 {
                    force += centre_force / 3.0;
                }
                let along = points.corners[(i + 1) % 3] - points.corners[i];
                let along = if h.0 & 1 == 0 { along } else { -along };
                forces[crossed.crossings[i] as usize] += force.dot(&along);
            }
        }
        Ok(forces)
    }

    /// How ∫η along a segment changes as its ends slide to other values of η.
    fn add_penalty_forces(&self, cut: &Cut, weight: f64, segment: &Segment, forces: &mut [f64]) {
        let mut slide = |c: u32, share: f64| {
            let [a, b] = self.mesh.edge_vertices(cut.crossings[c as usize].edge);
            let slope = self.penalty[b.index()] - self.penalty[a.index()];
            forces[c as usize] += weight * 0.5 * segment.length * share * slope;
        };
        for end in segment.ends {
            match end {
                Node::Crossing(c) => slide(c, 1.0),
                Node::Centre(m) => {
                    let face = &cut.faces[cut.centres[m as usize] as usize];
                    face.crossings.into_iter().for_each(|c| slide(c, 1.0 / 3.0));
                }
            }
        }
    }

    /// q with A q = 2 w_D A_a u + w_H ∫b′(u); where nothing is rescaled the first part is 2 w_D u without a solve.
    pub fn adjoint(
        &self,
        cut: &Cut,
        weights: &Weights,
        solution: &mut Solution,
        shared: &mut SharedFactor,
    ) -> Result<Vec<f64>, LinalgError> {
        let mut q = if weights.rescaled && weights.dirichlet > 0.0 {
            let mut q = self.rescaled_stiffness(cut, &solution.u);
            q.iter_mut().for_each(|q| *q *= 2.0 * weights.dirichlet);
            q
        } else {
            vec![0.0; solution.u.len()]
        };
        if weights.hencky > 0.0 {
            self.for_elements(cut, &solution.u, |area, values, vertices| {
                let (_, slopes) = weights.pointwise.mean(values);
                for (slope, vertex) in slopes.into_iter().zip(vertices) {
                    if let Some(v) = vertex {
                        q[v.index()] += weights.hencky * area * slope;
                    }
                }
            });
            for v in self.mesh.vertices() {
                if self.is_pinned(v) {
                    q[v.index()] = 0.0;
                }
            }
        }
        if weights.hencky > 0.0 || weights.rescaled {
            shared.of(&self.analysis, solution)?.solve(&mut q, 1);
        }
        if !weights.rescaled {
            for (q, u) in q.iter_mut().zip(&solution.u) {
                *q += 2.0 * weights.dirichlet * u;
            }
        }
        Ok(q)
    }
}

/// Whether a sub-triangle lies in region 0, told by the labels of the face's corners.
fn is_inside(triangle: [Corner; 3], inside: [bool; 3]) -> bool {
    triangle.into_iter().any(|corner| matches!(corner, Corner::Vertex(i) if inside[i]))
}

/// Mean of η along a segment. **Takes** η at the crossings.
fn mean_penalty(cut: &Cut, at: &[f64], ends: [Node; 2]) -> f64 {
    let [a, b] = ends.map(|end| match end {
        Node::Crossing(c) => at[c as usize],
        Node::Centre(m) => {
            let face = &cut.faces[cut.centres[m as usize] as usize];
            face.crossings.iter().map(|&c| at[c as usize]).sum::<f64>() / 3.0
        }
    });
    0.5 * (a + b)
}

/// The pull of the segments of a face on its points: tension × unit vectors.
fn add_tensions(
    crossed: &CrossedFace,
    points: &FacePoints,
    tensions: [f64; 3],
    side_forces: &mut [Vector2<f64>; 3],
    centre_force: &mut Vector2<f64>,
) {
    let pull = |from: Vector2<f64>, to: Vector2<f64>, tension: f64| {
        (to - from).try_normalize(1e-300).unwrap_or_else(Vector2::zeros) * tension
    };
    if crossed.lone == 3 {
        for i in 0..3 {
            let force = pull(points.centre, points.sides[i], tensions[i]);
            side_forces[i] += force;
            *centre_force -= force;
        }
    } else {
        let (x, z) = (crossed.lone as usize, (crossed.lone as usize + 2) % 3);
        let force = pull(points.sides[x], points.sides[z], tensions[0]);
        side_forces[z] += force;
        side_forces[x] -= force;
    }
}

/// Smoothing of the feature size, for a surface of unit area.
const FEATURE_SMOOTHING: f64 = 0.02;

/// r³ of every face, r the intrinsic feature size: (M + c L) r = M r⁰, r⁰ = 1/(√|K| + 1).
///
/// **From** [VSC] 3.5.1, eq. 25. The largest feature size is 1, the side of a square of the surface's area.
fn feature_scales(
    mesh: &Mesh,
    geometry: &Geometry,
    analysis: &Arc<Analysis>,
) -> Result<Vec<f64>, LinalgError> {
    let areas = geometry.vertex_dual_areas(mesh);
    let curvatures = face_curvatures(mesh, geometry);
    let mut sizes = vec![0.0; mesh.vertex_count()];
    for f in mesh.faces() {
        let size = 1.0 / (curvatures[f.index()].abs().sqrt() + 1.0);
        for v in mesh.face_vertices(f) {
            sizes[v.index()] += size * geometry.face_areas[f.index()] / 3.0;
        }
    }
    let Laplacian { pattern, mut values, .. } = Laplacian::new(mesh, geometry);
    values.iter_mut().for_each(|value| *value *= FEATURE_SMOOTHING);
    for (v, area) in areas.iter().enumerate() {
        // Isolated vertices have no area and take no part.
        values[pattern.diagonal(v)] += if *area > 0.0 { *area } else { 1.0 };
    }
    Factor::new(analysis.clone(), &values)?.solve(&mut sizes, 1);
    let mean = |t: &[VertexId; 3]| t.iter().map(|v| sizes[v.index()]).sum::<f64>() / 3.0;
    Ok(mesh.triangles().iter().map(|t| mean(t).powi(3)).collect())
}

/// A linear triangle: area and gradients of its hat functions.
pub(super) struct Element {
    pub area: f64,
    gradients: [Vector2<f64>; 3],
}

impl Element {
    pub fn new(points: &FacePoints, triangle: [Corner; 3]) -> Self {
        let p = triangle.map(|corner| points.at(corner));
        let double = (p[1] - p[0]).perp(&(p[2] - p[0]));
        let gradients = [0, 1, 2].map(|i| {
            let side = p[(i + 2) % 3] - p[(i + 1) % 3];
            Vector2::new(-side.y, side.x) / double
        });
        Self { area: 0.5 * double, gradients }
    }

    /// ∫∇φ_a·∇φ_b.
    pub fn stiffness(&self, a: usize, b: usize) -> f64 {
        self.area * self.gradients[a].dot(&self.gradients[b])
    }

    /// Derivative of w_D ∫|∇u|² − ∫∇q·∇u with respect to the places of the corners.
    fn stiffness_forces(&self, u: [f64; 3], q: [f64; 3], weight: f64) -> [Vector2<f64>; 3] {
        let (du, dq) = (self.gradient(u), self.gradient(q));
        self.gradients.map(|hat| {
            let d = |a: Vector2<f64>, b: Vector2<f64>| {
                a.dot(&b) * hat - hat.dot(&b) * a - hat.dot(&a) * b
            };
            self.area * (weight * d(du, du) - d(dq, du))
        })
    }

    /// Derivative of ∫ pressure with respect to the places of the corners.
    fn mass_forces(&self, pressure: f64) -> [Vector2<f64>; 3] {
        self.gradients.map(|hat| self.area * pressure * hat)
    }

    /// Gradient of the linear function with these values at the corners.
    fn gradient(&self, values: [f64; 3]) -> Vector2<f64> {
        self.gradients[0] * values[0]
            + self.gradients[1] * values[1]
            + self.gradients[2] * values[2]
    }
}
