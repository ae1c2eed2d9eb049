//! The linear side: from cone angles μ to scale factors and to the dual variable.
//!
//! Unknown angles sit at the *dofs*: the vertices inside, and those on the boundary where its curvature is an unknown. A component is
//! *grounded* where scale factors are bound by the boundary and *floating* where they are fixed up to a constant, which then is the
//! one of least distortion. With L_D the rows of the cotan Laplacian at the dofs, W the vertices where u may differ from 0, and
//! f = Ω − μ:
//!
//! L_DW u = f, L_WD φ = M u, hence B φ = f with B = L_DW M⁻¹ L_WD.
//!
//! Where W = D, a solve with B is two solves with L_DD, whose factor is a fraction of B's; where the boundary's u is free (W ⊃ D), B
//! itself is factored. One vertex of every floating component is left out of the factored matrix; right-hand sides there sum to
//! zero, so that this fixes a constant and regularises nothing.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::sync::Arc;

use super::params::{ConeBoundary, LEAST_WEIGHT};
use super::two_ring::TwoRing;
use crate::geometry::{Geometry, Laplacian};
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};
use crate::mesh::{Mesh, VertexId};

pub(super) const NONE: u32 = u32::MAX;

/// A connected part of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Component {
    /// Whether its scale factors are fixed up to a constant only.
    pub is_floating: bool,
    /// The dof left out of the factored matrix of a floating component.
    pub ground: u32,
    /// Sum of the weighted masses.
    pub mass: f64,
    /// Sum of the curvatures at its dofs: what the angles of a floating component add up to.
    pub total: f64,
    pub has_boundary: bool,
}

/// Scale factors and dual variable that belong to one set of angles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Response {
    /// At every vertex, in the sign of the equations: minus the log scale factor.
    pub u: Vec<f64>,
    /// At every dof; on floating components up to a constant.
    pub phi: Vec<f64>,
}

enum Kind {
    /// The factor of L_DD without grounds.
    Poisson,
    /// The factor of B without grounds.
    TwoRing(Box<TwoRing>),
}

/// Operators, masses, curvatures and one factorisation.
pub(super) struct System {
    pub laplacian: Laplacian,
    /// Lumped mass times w_E.
    pub mass: Vec<f64>,
    /// Lumped mass.
    pub plain_mass: Vec<f64>,
    /// Where u may differ from 0.
    pub is_live: Vec<bool>,
    pub is_boundary: Vec<bool>,
    /// The vertex of every dof, ascending.
    pub dofs: Vec<u32>,
    /// The dof of every vertex.
    pub dof_of: Vec<u32>,
    /// Ω, and κ on the boundary, at every dof.
    pub curvatures: Vec<f64>,
    /// The component of every dof.
    pub component_of: Vec<u32>,
    pub components: Vec<Component>,
    /// Neighbouring dofs of dof `i`: `neighbours[starts[i]..starts[i + 1]]`.
    pub starts: Vec<u32>,
    pub neighbours: Vec<u32>,
    kind: Kind,
    factor: Option<Factor>,
    /// Row of every dof in the factored matrix of L; none for grounds.
    rows: Vec<u32>,
    row_count: usize,
    /// Right-hand sides solved for with L (or with B, where that is factored).
    pub solves: usize,
    pub factorisations: usize,
    scratch: [Vec<f64>; 2],
}

impl System {
    pub fn new(
        mesh: &Mesh,
        geometry: &Geometry,
        boundary: ConeBoundary,
        weights: &[f64],
    ) -> Result<Self, LinalgError> {
        let vertices = mesh.vertex_count();
        let laplacian = Laplacian::new(mesh, geometry);
        let (mass, plain_mass) = masses(mesh, geometry, weights);
        let topology = mesh.topology();
        let mut part = vec![NONE; vertices];
        for f in mesh.faces() {
            for v in mesh.face_vertices(f) {
                part[v.index()] = topology.face_components[f.index()];
            }
        }
        let is_boundary: Vec<bool> = mesh.vertices().map(|v| mesh.is_boundary_vertex(v)).collect();
        let mut components = vec![
            Component {
                is_floating: true,
                ground: NONE,
                mass: 0.0,
                total: 0.0,
                has_boundary: false
            };
            topology.components
        ];
        for v in 0..vertices {
            if is_boundary[v] {
                let component = &mut components[part[v] as usize];
                component.is_floating = boundary.has_corners();
                component.has_boundary = true;
            }
        }
        let mut dofs = Vec::new();
        let mut dof_of = vec![NONE; vertices];
        let mut component_of = Vec::new();
        let mut is_live = vec![false; vertices];
        for v in 0..vertices {
            if part[v] == NONE {
                continue;
            }
            let component = &mut components[part[v] as usize];
            let is_dof = component.is_floating || !is_boundary[v];
            is_live[v] = is_dof || boundary == ConeBoundary::Optimal;
            if is_dof {
                component.mass += mass[v];
                dof_of[v] = dofs.len() as u32;
                dofs.push(v as u32);
                component_of.push(part[v]);
            }
        }
        let defects = crate::geometry::angle_defects(mesh, geometry);
        let curvatures: Vec<f64> = dofs.iter().map(|&v| defects[v as usize]).collect();
        for (i, &c) in component_of.iter().enumerate() {
            components[c as usize].total += curvatures[i];
        }
        // The ground is the vertex with the most neighbours: leaving it out spares the most entries.
        let (starts, neighbours) = adjacency(mesh, &dof_of, dofs.len());
        for (i, &c) in component_of.iter().enumerate() {
            let component = &mut components[c as usize];
            let degree = |i: usize| starts[i + 1] - starts[i];
            if component.is_floating
                && (component.ground == NONE || degree(i) > degree(component.ground as usize))
            {
                component.ground = i as u32;
            }
        }
        let mut rows = vec![NONE; dofs.len()];
        let mut row_count = 0;
        for (i, row) in rows.iter_mut().enumerate() {
            if components[component_of[i] as usize].ground != i as u32 {
                *row = row_count;
                row_count += 1;
            }
        }
        let mut system = Self {
            laplacian,
            mass,
            plain_mass,
            is_live,
            is_boundary,
            dofs,
            dof_of,
            curvatures,
            component_of,
            components,
            starts,
            neighbours,
            kind: Kind::Poisson,
            factor: None,
            rows,
            row_count: row_count as usize,
            solves: 0,
            factorisations: 0,
            scratch: [vec![0.0; vertices], vec![0.0; vertices]],
        };
        if system.row_count > 0 {
            if boundary == ConeBoundary::Optimal && system.components.iter().any(|c| !c.is_floating)
            {
                let mut two_ring = TwoRing::new(&system)?;
                let grounds = system.grounds();
                two_ring.factor(&vec![0.0; system.len()], &grounds)?;
                system.kind = Kind::TwoRing(Box::new(two_ring));
            } else {
                system.factor = Some(system.poisson_factor(mesh)?);
            }
            system.factorisations = 1;
        }
        Ok(system)
    }

    /// The factor of L_DD without the rows of the grounds.
    fn poisson_factor(&self, mesh: &Mesh) -> Result<Factor, LinalgError> {
        let row_of = |v: VertexId| match self.dof_of[v.index()] {
            NONE => NONE,
            i => self.rows[i as usize],
        };
        let mut pairs = Vec::new();
        let mut sources = Vec::new();
        for e in mesh.edges() {
            let pair = mesh.edge_vertices(e).map(row_of);
            if pair[0] != NONE && pair[1] != NONE {
                pairs.push(pair);
                sources.push(self.laplacian.edge_slots[e.index()]);
            }
        }
        let (pattern, slots) = Pattern::new(self.row_count, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        for (&slot, &source) in slots.iter().zip(&sources) {
            values[slot as usize] = self.laplacian.values[source as usize];
        }
        for (i, &row) in self.rows.iter().enumerate() {
            if row != NONE {
                let v = self.dofs[i] as usize;
                values[pattern.diagonal(row as usize)] =
                    self.laplacian.values[self.laplacian.pattern.diagonal(v)];
            }
        }
        Factor::new(Arc::new(Analysis::new(pattern)?), &values)
    }

    /// Number of dofs.
    pub fn len(&self) -> usize {
        self.dofs.len()
    }

    /// Which dofs are grounds.
    pub fn grounds(&self) -> Vec<bool> {
        self.rows.iter().map(|&row| row == NONE).collect()
    }

    /// The two-ring matrix, where that is what is factored.
    pub fn two_ring(&self) -> Option<&TwoRing> {
        match &self.kind {
            Kind::TwoRing(two_ring) => Some(two_ring),
            Kind::Poisson => None,
        }
    }

    /// Number of entries of the factor that [`System::respond`] solves with, and how many solves a response takes.
    pub fn factor_size(&self) -> (usize, usize) {
        match &self.kind {
            Kind::TwoRing(two_ring) => (two_ring.factor_entries(), 1),
            Kind::Poisson => (self.factor.as_ref().map_or(0, |f| f.analysis().factor_entries()), 2),
        }
    }

    /// L_WD φ divided by the mass: the u, at every vertex, that belongs to a dual variable.
    pub fn scale_of(&mut self, phi: &[f64], u: &mut [f64]) {
        let [full, _] = &mut self.scratch;
        full.fill(0.0);
        for (&v, &value) in self.dofs.iter().zip(phi) {
            full[v as usize] = value;
        }
        self.laplacian.pattern.multiply(&self.laplacian.values, full, u);
        for (v, value) in u.iter_mut().enumerate() {
            *value = if self.is_live[v] { *value / self.mass[v] } else { 0.0 };
        }
    }

    /// L_DW u at every dof: the curvature that scale factors take away. **Takes** u that is 0 outside W.
    pub fn curvature_of(&mut self, u: &[f64], f: &mut [f64]) {
        let [_, full] = &mut self.scratch;
        self.laplacian.pattern.multiply(&self.laplacian.values, u, full);
        for (&v, value) in self.dofs.iter().zip(f) {
            *value = full[v as usize];
        }
    }

    /// Dual variables of right-hand sides: φ = B⁺ f, columns one after the other, in place.
    ///
    /// On floating components f is first brought to sum 0 and φ to weighted mean 0 (both by the mass, so that the operator stays
    /// symmetric and positive semi-definite).
    fn duals(&mut self, f: &mut [f64], columns: usize) {
        if self.row_count == 0 {
            f.fill(0.0);
            return;
        }
        self.balance(f);
        if let Kind::TwoRing(two_ring) = &mut self.kind {
            two_ring.solve(f, columns);
            self.solves += columns;
        } else {
            self.poisson(f, columns);
            self.centre(f);
            for column in f.chunks_exact_mut(self.dofs.len()) {
                for (&v, value) in self.dofs.iter().zip(column) {
                    *value *= self.mass[v as usize];
                }
            }
            self.poisson(f, columns);
        }
        self.centre(f);
    }

    /// x with L_DD x = f, in place, 0 at grounds.
    fn poisson(&mut self, f: &mut [f64], columns: usize) {
        let Some(factor) = &mut self.factor else { return };
        let n = self.dofs.len();
        let mut x = vec![0.0; self.row_count * columns];
        for (column, target) in f.chunks_exact(n).zip(x.chunks_exact_mut(self.row_count)) {
            for (&row, &value) in self.rows.iter().zip(column) {
                if row != NONE {
                    target[row as usize] = value;
                }
            }
        }
        factor.solve(&mut x, columns);
        self.solves += columns;
        for (column, source) in f.chunks_exact_mut(n).zip(x.chunks_exact(self.row_count)) {
            for (&row, value) in self.rows.iter().zip(column) {
                *value = if row == NONE { 0.0 } else { source[row as usize] };
            }
        }
    }

    /// Whether any component is floating.
    fn floats(&self) -> bool {
        self.components.iter().any(|component| component.is_floating)
    }

    /// Takes the sum away from right-hand sides on floating components, in proportion to the mass.
    fn balance(&self, f: &mut [f64]) {
        if !self.floats() {
            return;
        }
        for column in f.chunks_exact_mut(self.dofs.len()) {
            let mut sums = vec![0.0; self.components.len()];
            for (i, value) in column.iter().enumerate() {
                sums[self.component_of[i] as usize] += value;
            }
            for (i, value) in column.iter_mut().enumerate() {
                let c = self.component_of[i] as usize;
                if self.components[c].is_floating {
                    *value -= sums[c] * self.mass[self.dofs[i] as usize] / self.components[c].mass;
                }
            }
        }
    }

    /// Takes the weighted mean away from functions on floating components.
    pub fn centre(&self, x: &mut [f64]) {
        if !self.floats() {
            return;
        }
        for column in x.chunks_exact_mut(self.dofs.len()) {
            let mut sums = vec![0.0; self.components.len()];
            for (i, value) in column.iter().enumerate() {
                sums[self.component_of[i] as usize] += value * self.mass[self.dofs[i] as usize];
            }
            for (i, value) in column.iter_mut().enumerate() {
                let c = self.component_of[i] as usize;
                if self.components[c].is_floating {
                    *value -= sums[c] / self.components[c].mass;
                }
            }
        }
    }

    /// Columns of B⁺ at the given dofs, one after the other.
    pub fn greens(&mut self, at: &[u32]) -> Vec<f64> {
        let n = self.len();
        let mut f = vec![0.0; n * at.len()];
        for (column, &i) in f.chunks_exact_mut(n).zip(at) {
            column[i as usize] = 1.0;
        }
        self.duals(&mut f, at.len());
        f
    }

    /// u and φ of the angles `mu`.
    ///
    /// **Takes** angles that add up to `total` on every floating component, up to rounding. **Costs** two solves where L is factored,
    /// two with the larger factor where B is.
    pub fn respond(&mut self, mu: &[f64]) -> Response {
        let nothing = Response { u: vec![0.0; self.mass.len()], phi: vec![0.0; self.len()] };
        self.follow(mu, &nothing).0
    }

    /// The same from the response to other angles, and how much had to change: ‖change of u‖ / ‖u‖.
    ///
    /// Solves for what is left over, which is a step of iterative refinement when the angles are the same. Errors are those of the
    /// change, so that none add up.
    pub fn follow(&mut self, mu: &[f64], old: &Response) -> (Response, f64) {
        let n = self.len();
        let mut response = old.clone();
        if self.row_count == 0 {
            return (response, 0.0);
        }
        let mut f: Vec<f64> = self.curvatures.iter().zip(mu).map(|(k, m)| k - m).collect();
        self.balance(&mut f);
        let Response { u, phi } = &mut response;
        if let Kind::TwoRing(_) = self.kind {
            self.refine_both(&f, u, phi);
        } else {
            let mut rest = vec![0.0; n];
            self.curvature_of(u, &mut rest);
            rest.iter_mut().zip(&f).for_each(|(r, f)| *r = f - *r);
            self.poisson(&mut rest, 1);
            let mut inner: Vec<f64> =
                rest.iter().zip(&self.dofs).map(|(d, &v)| u[v as usize] + d).collect();
            self.centre(&mut inner);
            let mut full = vec![0.0; u.len()];
            for ((&v, value), &dual) in self.dofs.iter().zip(&inner).zip(phi.iter()) {
                u[v as usize] = *value;
                full[v as usize] = dual;
            }
            self.curvature_of(&full, &mut rest);
            for (i, rest) in rest.iter_mut().enumerate() {
                *rest = inner[i] * self.mass[self.dofs[i] as usize] - *rest;
            }
            self.poisson(&mut rest, 1);
            phi.iter_mut().zip(&rest).for_each(|(p, d)| *p += d);
            self.centre(phi);
        }
        let square = |u: &mut dyn Iterator<Item = f64>| -> f64 {
            u.zip(&self.mass).map(|(u, m)| m * u * u).sum()
        };
        let size = square(&mut response.u.iter().copied());
        let change = square(&mut response.u.iter().zip(&old.u).map(|(new, old)| new - old));
        let share = if change > 0.0 { (change / size).sqrt() } else { 0.0 };
        (response, share)
    }

    /// L u = f and L φ = M u side by side, where B is factored: its condition is the square of L's, and M⁻¹ L φ loses as many digits
    /// again.
    fn refine_both(&mut self, f: &[f64], u: &mut [f64], phi: &mut [f64]) {
        let n = self.len();
        let (mut rest, mut change) = (vec![0.0; n], vec![0.0; u.len()]);
        let mut off = vec![0.0; n];
        for _ in 0..2 {
            self.curvature_of(u, &mut rest);
            self.scale_of(phi, &mut change);
            let miss: Vec<f64> = u.iter().zip(&change).map(|(u, c)| u - c).collect();
            self.curvature_of(&miss, &mut off);
            for i in 0..n {
                rest[i] = f[i] - rest[i] + off[i];
            }
            self.duals(&mut rest, 1);
            self.scale_of(&rest, &mut change);
            for v in 0..u.len() {
                u[v] += change[v] - miss[v];
            }
            phi.iter_mut().zip(&rest).for_each(|(p, d)| *p += d);
        }
    }
}

/// Lumped masses, weighted and plain. No mass is zero: vertices whose triangles have no area get a trace of it.
fn masses(mesh: &Mesh, geometry: &Geometry, weights: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let plain = geometry.vertex_dual_areas(mesh);
    let floor = 1e-9 * geometry.total_area() / mesh.vertex_count() as f64;
    let largest = weights.iter().fold(0.0, |m: f64, w| m.max(*w));
    let weight = |v: usize| match weights.get(v) {
        Some(w) if largest > 0.0 => w.max(LEAST_WEIGHT * largest),
        _ => 1.0,
    };
    let mass = plain.iter().enumerate().map(|(v, a)| a.max(floor) * weight(v)).collect();
    (mass, plain)
}

/// Which dofs share an edge.
fn adjacency(mesh: &Mesh, dof_of: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let pairs: Vec<[usize; 2]> = mesh
        .edges()
        .map(|e| mesh.edge_vertices(e).map(|v| dof_of[v.index()]))
        .filter(|p| p[0] != NONE && p[1] != NONE)
        .map(|p| p.map(|i| i as usize))
        .collect();
    let mut starts = vec![0u32; count + 1];
    for &[a, b] in &pairs {
        starts[a + 1] += 1;
        starts[b + 1] += 1;
    }
    for i in 0..count {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut neighbours = vec![0u32; 2 * pairs.len()];
    for &[a, b] in &pairs {
        for (a, b) in [(a, b), (b, a)] {
            neighbours[next[a] as usize] = b as u32;
            next[a] += 1;
        }
    }
    (starts, neighbours)
}
