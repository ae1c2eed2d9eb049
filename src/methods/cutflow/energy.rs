//! The objective on a given cut, its exact derivative with respect to the crossings, and the linear algebra of both.
//!
//! J = w_D uᵀAu + w_H uᵀMu + α |γ| with A u = f on every patch, u = 0 on cut and boundary. Cut points carry u = 0 and drop
//! out: **the unknowns are always the original vertices**, the matrix pattern is that of the mesh's Laplacian (entries
//! between patches become zero), and one symbolic analysis serves the whole run.

use std::sync::Arc;

use nalgebra::Vector2;

use super::cut::{Corner, CrossedFace, Cut, FacePoints, Frames};
use crate::geometry::{Geometry, Laplacian, face_curvatures};
use crate::linalg::{Analysis, Factor, LinalgError};
use crate::mesh::{EdgeId, Mesh, VertexId};

/// Weights of the objective, for a surface of unit area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// w_D of ∫|∇u|².
    pub dirichlet: f64,
    /// w_H of ∫u².
    pub hencky: f64,
    /// α of the cut's length.
    pub length: f64,
}

/// The objective and its terms (unweighted).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// J.
    pub total: f64,
    /// Σ ∫|∇u|².
    pub dirichlet: f64,
    /// Σ ∫u².
    pub hencky: f64,
    /// |γ|.
    pub length: f64,
}

/// Everything that does not change while the cut moves.
pub(super) struct Problem {
    pub mesh: Mesh,
    pub geometry: Geometry,
    pub frames: Frames,
    pub face_curvatures: Vec<f64>,
    pub analysis: Arc<Analysis>,
    edge_slots: Vec<u32>,
    /// A and f of the uncut surface, boundary vertices eliminated.
    base_values: Vec<f64>,
    base_rhs: Vec<f64>,
    is_boundary: Vec<bool>,
    /// Vertices of closed components that the initial cut leaves whole: they take no part.
    inert: Vec<bool>,
    face_components: Vec<u32>,
    /// Components that a cut must not leave whole: closed, and not inert.
    needs_cut: Vec<bool>,
}

/// The Yamabe solution on one cut: u, its energy, and the factor that gave it.
pub(super) struct Solution {
    pub u: Vec<f64>,
    pub energy: Energy,
    /// Largest residual of A u = f over the largest entry of f.
    pub residual: f64,
    factor: Factor,
    values: Vec<f64>,
    rhs: Vec<f64>,
    scratch: Vec<f64>,
}

impl Problem {
    pub fn new(mesh: Mesh, geometry: Geometry) -> Result<Self, LinalgError> {
        let laplacian = Laplacian::new(&mesh, &geometry);
        let face_curvatures = face_curvatures(&mesh, &geometry);
        let is_boundary: Vec<bool> = mesh.vertices().map(|v| mesh.is_boundary_vertex(v)).collect();
        let Laplacian { pattern, edge_slots, values: mut base_values } = laplacian;
        let mut base_rhs = vec![0.0; mesh.vertex_count()];
        for f in mesh.faces() {
            let share = face_curvatures[f.index()] * geometry.face_areas[f.index()] / 3.0;
            for v in mesh.face_vertices(f) {
                base_rhs[v.index()] -= share;
            }
        }
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
            face_curvatures,
            analysis,
            edge_slots,
            base_values,
            base_rhs,
            is_boundary,
            inert,
            face_components: topology.face_components,
            needs_cut,
        };
        for v in problem.mesh.vertices() {
            if problem.is_boundary[v.index()] || problem.mesh.halfedge(v).is_none() {
                problem.pin(v);
            }
        }
        Ok(problem)
    }

    /// Makes a vertex's equation u = 0. Its off-diagonal entries must be zero already or be zeroed by the caller.
    fn pin(&mut self, v: VertexId) {
        let slot = self.analysis.pattern().diagonal(v.index());
        self.base_values[slot] = 1.0;
        self.base_rhs[v.index()] = 0.0;
    }

    /// Takes the closed components that a cut leaves whole out of the problem: on them Δu = −K has no solution with u = 0
    /// anywhere.
    pub fn rest_uncut_components(&mut self, cut: &Cut) {
        let uncut = self.uncut_components(cut);
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
    fn assemble(&self, cut: &Cut, values: &mut Vec<f64>, rhs: &mut Vec<f64>) {
        values.clone_from(&self.base_values);
        rhs.clone_from(&self.base_rhs);
        let pattern = self.analysis.pattern();
        for crossed in &cut.faces {
            let f = crossed.face;
            let vertices = self.mesh.face_vertices(f);
            let free = vertices.map(|v| !self.is_pinned(v));
            let halfedges = self.mesh.face_halfedges(f);
            let cotangents = self.geometry.corner_cotangents[f.index()];
            let curvature = self.face_curvatures[f.index()];
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
    }

    /// Calls `visit` for every (sub-)triangle with its weighted area and the values of u at its corners (0 on the cut); corners that
    /// are vertices come with their id.
    fn for_elements(
        &self,
        cut: &Cut,
        u: &[f64],
        mut visit: impl FnMut(f64, [f64; 3], [Option<VertexId>; 3]),
    ) {
        let mut next_crossed = cut.faces.iter().peekable();
        for f in self.mesh.faces() {
            let vertices = self.mesh.face_vertices(f);
            if next_crossed.peek().is_none_or(|c| c.face != f) {
                visit(
                    self.geometry.face_areas[f.index()],
                    vertices.map(|v| u[v.index()]),
                    vertices.map(Some),
                );
                continue;
            }
            let Some(crossed) = next_crossed.next() else { continue };
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
        }
    }

    /// Solves for u on a cut and measures J; memory of `old` is reused.
    ///
    /// **Fails** where a patch has neither cut nor boundary.
    pub fn solve(
        &self,
        cut: &Cut,
        weights: &Weights,
        old: Option<Solution>,
    ) -> Result<Solution, LinalgError> {
        let mut solution = match old {
            Some(mut solution) => {
                self.assemble(cut, &mut solution.values, &mut solution.rhs);
                solution.factor.refactor(&solution.values)?;
                solution
            }
            None => {
                let (mut values, mut rhs) = (Vec::new(), Vec::new());
                self.assemble(cut, &mut values, &mut rhs);
                let factor = Factor::new(self.analysis.clone(), &values)?;
                let (u, scratch) = (Vec::new(), Vec::new());
                let energy = Energy::default();
                Solution { u, energy, residual: 0.0, factor, values, rhs, scratch }
            }
        };
        solution.u.clone_from(&solution.rhs);
        solution.factor.solve(&mut solution.u, 1);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let dirichlet = dot(&solution.u, &solution.rhs);
        solution.scratch.resize(solution.u.len(), 0.0);
        self.analysis.pattern().multiply(&solution.values, &solution.u, &mut solution.scratch);
        let (mut error, mut size) = (0.0f64, 1e-300f64);
        for (a, b) in solution.scratch.iter().zip(&solution.rhs) {
            error = error.max((a - b).abs());
            size = size.max(b.abs());
        }
        solution.residual = error / size;
        let mut hencky = 0.0;
        self.for_elements(cut, &solution.u, |area, [a, b, c], _| {
            hencky += area / 6.0 * (a * a + b * b + c * c + a * b + b * c + c * a);
        });
        let total =
            weights.dirichlet * dirichlet + weights.hencky * hencky + weights.length * cut.length;
        solution.energy = Energy { total, dirichlet, hencky, length: cut.length };
        Ok(solution)
    }

    /// dJ/dt for every crossing: exact for the discrete J.
    ///
    /// With q = 2 w_D u + A⁻¹(2 w_H M u) the Lagrangian J − qᵀ(A u − f) has the same derivative as J, and every sub-triangle
    /// pulls at its corners with a force that is a polynomial of gradients. **From** [VSC] Table 1 in its discrete form.
    /// **Differs**: the paper recovers a flux on the cut and squares it; differentiating the discrete J instead makes the
    /// predicted decrease the true one. **Costs** one solve if w_H > 0.
    pub fn crossing_forces(
        &self,
        cut: &Cut,
        weights: &Weights,
        solution: &mut Solution,
        forces: &mut Vec<f64>,
    ) {
        forces.clear();
        forces.resize(cut.crossings.len(), 0.0);
        let adjoint = self.adjoint(cut, weights, solution);
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
            for (triangle, _) in points.triangles(crossed.lone) {
                let element = Element::new(&points, triangle);
                let (u, q) = (value(u, triangle), value(&adjoint, triangle));
                pull(triangle, element.stiffness_forces(u, q, weights.dirichlet));
            }
            let curvature = self.face_curvatures[crossed.face.index()];
            for (triangle, weight) in points.weighted_triangles(crossed.lone) {
                let element = Element::new(&points, triangle);
                let (u, q) = (value(u, triangle), value(&adjoint, triangle));
                pull(triangle, element.mass_forces(u, q, weights.hencky, curvature, weight));
            }
            self.add_length_forces(
                crossed,
                &points,
                weights.length,
                &mut side_forces,
                &mut centre_force,
            );
            for (i, h) in self.mesh.face_halfedges(crossed.face).into_iter().enumerate() {
                if crossed.crossings[i] == super::cut::NONE {
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
    }

    /// α × unit segment vectors.
    fn add_length_forces(
        &self,
        crossed: &CrossedFace,
        points: &FacePoints,
        weight: f64,
        side_forces: &mut [Vector2<f64>; 3],
        centre_force: &mut Vector2<f64>,
    ) {
        let pull = |from: Vector2<f64>, to: Vector2<f64>| {
            (to - from).try_normalize(1e-300).unwrap_or_else(Vector2::zeros) * weight
        };
        if crossed.lone == 3 {
            for i in 0..3 {
                let force = pull(points.centre, points.sides[i]);
                side_forces[i] += force;
                *centre_force -= force;
            }
        } else {
            let (x, z) = (crossed.lone as usize, (crossed.lone as usize + 2) % 3);
            let force = pull(points.sides[x], points.sides[z]);
            side_forces[z] += force;
            side_forces[x] -= force;
        }
    }

    /// q = 2 w_D u + A⁻¹(2 w_H M u).
    pub fn adjoint(&self, cut: &Cut, weights: &Weights, solution: &mut Solution) -> Vec<f64> {
        let mut q = vec![0.0; solution.u.len()];
        if weights.hencky > 0.0 {
            let u = std::mem::take(&mut solution.u);
            self.for_elements(cut, &u, |area, values, vertices| {
                let sum: f64 = values.iter().sum();
                for (value, vertex) in values.iter().zip(vertices) {
                    if let Some(v) = vertex {
                        q[v.index()] += weights.hencky * area / 6.0 * (sum + value);
                    }
                }
            });
            for v in self.mesh.vertices() {
                if self.is_pinned(v) {
                    q[v.index()] = 0.0;
                }
            }
            solution.u = u;
            solution.factor.solve(&mut q, 1);
        }
        for (q, u) in q.iter_mut().zip(&solution.u) {
            *q += 2.0 * weights.dirichlet * u;
        }
        q
    }
}

impl Solution {
    /// The factor of the cut surface's Laplacian, for whoever can use it (the flattened preview).
    pub fn factor(&mut self) -> &mut Factor {
        &mut self.factor
    }
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
        let gradient = |values: [f64; 3]| {
            self.gradients[0] * values[0]
                + self.gradients[1] * values[1]
                + self.gradients[2] * values[2]
        };
        let (du, dq) = (gradient(u), gradient(q));
        self.gradients.map(|hat| {
            let d = |a: Vector2<f64>, b: Vector2<f64>| {
                a.dot(&b) * hat - hat.dot(&b) * a - hat.dot(&a) * b
            };
            self.area * (weight * d(du, du) - d(dq, du))
        })
    }

    /// Derivative of `share` · (w_H ∫u² − K ∫q) with respect to the places of the corners.
    fn mass_forces(
        &self,
        u: [f64; 3],
        q: [f64; 3],
        weight: f64,
        curvature: f64,
        share: f64,
    ) -> [Vector2<f64>; 3] {
        let sum: f64 = u.iter().sum();
        let square = (sum * sum + u.iter().map(|u| u * u).sum::<f64>()) / 12.0;
        let pressure = weight * square - curvature / 3.0 * q.iter().sum::<f64>();
        self.gradients.map(|hat| share * self.area * pressure * hat)
    }
}
