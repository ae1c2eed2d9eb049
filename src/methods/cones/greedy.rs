//! Cones one after the other, where the scale is worst: the common practice, to compare optimal cones with.
//!
//! With u = 0 at the cones (and on the boundary) and L u = −Ω elsewhere, the angles follow as μ = Ω + L u. The next cone comes where
//! |u| is largest. One factor serves all cones: with G the Green's functions of the first places, u = u₀ + Σ μ_c G_c, and u = 0 at the
//! cones is a dense system of their number.
//!
//! **From** \[CETM\], Ben-Chen et al. (*Conformal Flattening by Curvature Prescription and Metric Scaling*, 2008), and \[BFF\] §6.

use super::Cone;
use crate::geometry::{Geometry, Laplacian, angle_defects};
use crate::linalg::{Analysis, DenseCholesky, Factor, Pattern};
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Cones as they were placed, and what each number of them is worth.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GreedyCones {
    /// By ascending vertex.
    pub cones: Vec<Cone>,
    /// Log scale factor at every vertex, on closed components with mean 0.
    pub u: Vec<f64>,
    /// After each cone, in their order; first cones of several closed components are one step.
    pub history: Vec<GreedyStep>,
}

/// What cones are worth after one was added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GreedyStep {
    /// Where.
    pub vertex: VertexId,
    /// Number of cones.
    pub count: usize,
    /// Σ|μ|, radians.
    pub total_angle: f64,
    /// ∫u², lumped, on closed components for the best constant.
    pub int_u2: f64,
}

const NONE: u32 = u32::MAX;

/// Places `count` cones one by one.
///
/// The first cone of each closed component lies at its largest |Ω| (there has to be one); all further ones where |u| is largest.
///
/// **Takes** at least one cone for each closed component, else there are as many. **Gives** fewer cones where none is left to place: u
/// is 0 everywhere. Angles are what they are: with few cones they may exceed 2π. **Costs** one factorisation and a solve for each cone.
pub fn greedy_cones(
    mesh: &Mesh,
    geometry: &Geometry,
    count: usize,
) -> Result<GreedyCones, SolveError> {
    let mut greedy = Greedy::new(mesh, geometry)?;
    let mut angles = greedy.update();
    let mut history = Vec::new();
    if let Some(&vertex) = greedy.firsts.last() {
        history.push(greedy.report(vertex, &angles));
    }
    while angles.len() < count {
        let Some(vertex) = greedy.worst() else { break };
        if !greedy.add(vertex) {
            break;
        }
        angles = greedy.update();
        history.push(greedy.report(vertex, &angles));
    }
    angles.sort_by_key(|c| c.vertex);
    Ok(GreedyCones { cones: angles, u: greedy.centred(), history })
}

struct Greedy {
    laplacian: Laplacian,
    curvatures: Vec<f64>,
    masses: Vec<f64>,
    /// Component of every vertex.
    parts: Vec<u32>,
    /// Mass of every closed component, 0 for others.
    closed_masses: Vec<f64>,
    firsts: Vec<VertexId>,
    /// Row of every vertex in the factored matrix; none at first cones and on the boundary.
    rows: Vec<u32>,
    factor: Option<Factor>,
    row_count: usize,
    places: Vec<VertexId>,
    columns: Vec<Vec<f64>>,
    dense: DenseCholesky,
    /// u without further cones.
    base: Vec<f64>,
    u: Vec<f64>,
}

impl Greedy {
    fn new(mesh: &Mesh, geometry: &Geometry) -> Result<Self, SolveError> {
        let laplacian = Laplacian::new(mesh, geometry);
        let curvatures = angle_defects(mesh, geometry);
        let masses = geometry.vertex_dual_areas(mesh);
        let topology = mesh.topology();
        let mut parts = vec![NONE; mesh.vertex_count()];
        for f in mesh.faces() {
            for v in mesh.face_vertices(f) {
                parts[v.index()] = topology.face_components[f.index()];
            }
        }
        let mut is_closed = vec![true; topology.components];
        let mut first = vec![None; topology.components];
        let mut closed_masses = vec![0.0; topology.components];
        for v in mesh.vertices().filter(|v| parts[v.index()] != NONE) {
            let c = parts[v.index()] as usize;
            is_closed[c] &= !mesh.is_boundary_vertex(v);
            closed_masses[c] += masses[v.index()];
            let size = |v: VertexId| curvatures[v.index()].abs();
            if first[c].is_none_or(|w| size(v) > size(w)) {
                first[c] = Some(v);
            }
        }
        for (mass, &closed) in closed_masses.iter_mut().zip(&is_closed) {
            *mass *= f64::from(u8::from(closed));
        }
        let firsts: Vec<VertexId> =
            first.iter().zip(&is_closed).filter(|p| *p.1).filter_map(|p| *p.0).collect();
        let is_inside: Vec<bool> = mesh
            .vertices()
            .map(|v| parts[v.index()] != NONE && !mesh.is_boundary_vertex(v))
            .collect();
        let mut rows = vec![NONE; mesh.vertex_count()];
        let mut row_count = 0;
        for v in mesh.vertices() {
            if is_inside[v.index()] && !firsts.contains(&v) {
                rows[v.index()] = row_count;
                row_count += 1;
            }
        }
        let row_count = row_count as usize;
        let mut pairs = Vec::new();
        let mut entries = Vec::new();
        for e in mesh.edges() {
            let pair = mesh.edge_vertices(e).map(|v| rows[v.index()]);
            if !pair.contains(&NONE) {
                pairs.push(pair);
                entries.push(laplacian.values[laplacian.edge_slots[e.index()] as usize]);
            }
        }
        let (pattern, slots) = Pattern::new(row_count, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        for (&slot, entry) in slots.iter().zip(entries) {
            values[slot as usize] = entry;
        }
        for (v, &row) in rows.iter().enumerate().filter(|p| *p.1 != NONE) {
            values[pattern.diagonal(row as usize)] =
                laplacian.values[laplacian.pattern.diagonal(v)];
        }
        let factor = match row_count {
            0 => None,
            _ => Some(Factor::new(std::sync::Arc::new(Analysis::new(pattern)?), &values)?),
        };
        let mut greedy = Self {
            laplacian,
            curvatures,
            masses,
            parts,
            closed_masses,
            firsts,
            rows,
            factor,
            row_count,
            places: Vec::new(),
            columns: Vec::new(),
            dense: DenseCholesky::new(),
            base: Vec::new(),
            u: Vec::new(),
        };
        let rhs: Vec<f64> = greedy.curvatures.iter().map(|k| -k).collect();
        greedy.base = greedy.solve(&rhs);
        greedy.u.clone_from(&greedy.base);
        Ok(greedy)
    }

    fn solve(&mut self, rhs: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.row_count];
        for (&row, value) in self.rows.iter().zip(rhs) {
            if row != NONE {
                x[row as usize] = *value;
            }
        }
        if let Some(factor) = &mut self.factor {
            factor.solve(&mut x, 1);
        }
        self.rows.iter().map(|&row| if row == NONE { 0.0 } else { x[row as usize] }).collect()
    }

    /// The vertex with the largest |u|, the first of equals; none where u is 0.
    fn worst(&self) -> Option<VertexId> {
        let candidates = (0..self.u.len()).rev().filter(|&v| self.rows[v] != NONE);
        let size = |v: usize| self.u[v].abs();
        let v = candidates.max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        // Rounding of scale factors of size 1.
        (size(v) > 1e-11).then_some(VertexId::from(v))
    }

    /// Adds a place; false where rounding cannot tell it from the others.
    fn add(&mut self, vertex: VertexId) -> bool {
        let mut rhs = vec![0.0; self.rows.len()];
        rhs[vertex.index()] = 1.0;
        let column = self.solve(&rhs);
        let row: Vec<f64> =
            self.places.iter().chain([&vertex]).map(|v| column[v.index()]).collect();
        if !self.dense.push(&row) {
            return false;
        }
        self.places.push(vertex);
        self.columns.push(column);
        true
    }

    /// u = 0 at all places; the cones that this makes.
    fn update(&mut self) -> Vec<Cone> {
        let mut further: Vec<f64> = self.places.iter().map(|v| -self.base[v.index()]).collect();
        self.dense.solve(&mut further);
        self.u.clone_from(&self.base);
        for (column, angle) in self.columns.iter().zip(&further) {
            for (u, g) in self.u.iter_mut().zip(column) {
                *u += angle * g;
            }
        }
        for v in &self.places {
            self.u[v.index()] = 0.0;
        }
        let mut flux = vec![0.0; self.u.len()];
        self.laplacian.pattern.multiply(&self.laplacian.values, &self.u, &mut flux);
        let first = self
            .firsts
            .iter()
            .map(|&vertex| (vertex, self.curvatures[vertex.index()] + flux[vertex.index()]));
        let all = first.chain(self.places.iter().copied().zip(further));
        all.map(|(vertex, angle)| Cone { vertex, angle }).collect()
    }

    /// u with mean 0 on closed components.
    fn centred(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.closed_masses.len()];
        for (v, u) in self.u.iter().enumerate().filter(|p| self.parts[p.0] != NONE) {
            sums[self.parts[v] as usize] += u * self.masses[v];
        }
        let mean = |c: usize| match self.closed_masses[c] {
            mass if mass > 0.0 => sums[c] / mass,
            _ => 0.0,
        };
        let part = |v: usize| self.parts[v];
        (0..self.u.len())
            .map(|v| if part(v) == NONE { 0.0 } else { self.u[v] - mean(part(v) as usize) })
            .collect()
    }

    fn report(&self, vertex: VertexId, cones: &[Cone]) -> GreedyStep {
        GreedyStep {
            vertex,
            count: cones.len(),
            total_angle: cones.iter().fold(0.0, |sum, c| sum + c.angle.abs()),
            int_u2: self.centred().iter().zip(&self.masses).map(|(u, m)| m * u * u).sum(),
        }
    }
}
