//! Boundary first flattening [BFF] of all patches at once, with isometric rims.
//!
//! A conformal map with scale e^u takes Gaussian curvature K to 0 if Δu = −K, and geodesic curvature k ds of the rim to
//! k̃ ds̃ = k ds + ∂u/∂n ds. With u = 0 on the rim, its lengths stay and k̃ follows from one Poisson problem: the rim is known before
//! anything else, and the interior is filled in by two harmonic coordinates. Patches only meet at rims, where nothing is
//! unknown, so all of them together are **one** system A_II, factored once.
//!
//! 1. A_II u = −Ω_I with angle defects Ω.
//! 2. k̃ = k + (A u)_B = k − h, h = −A_BI u; Σ k̃ = 2π for each chart (Gauss–Bonnet).
//! 3. Closing: lengths l, directions Σ k̃. Partners across a seam share one length (see the source of `closing`).
//! 4. A_II x = −A_IB x_B for both coordinates.
//!
//! With scale factors given on the rim ([`bff_scaled`]) step 1 is A_II u = −Ω_I − A_IB u_B, step 2 k̃ = k + (A u)_B, and rim lengths
//! are l e^{(u_a + u_b) / 2}. If u solves A u = μ − Ω on the uncut surface, the copies of a point on seams have interior angles that add up
//! to 2π − μ, because each edge's weight is the sum of those of its sides: charts of a *cone metric*.
//!
//! Guaranteed: developable patches become isometric charts to rounding; a triangle or a strip too; a defective patch costs
//! no other patch its chart. Not guaranteed: freedom from flips and overlaps; accuracy of u on triangulations with very
//! obtuse angles.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::Point2;

use super::closing::{MAX_LOG_RATIO, Polygons, Turns};
use super::{Flattening, NoChart, rims};
use crate::geometry::{Geometry, angle_defects};
use crate::linalg::{Analysis, Factor, LinalgError, Pattern, worse};
use crate::mesh::{EdgeId, HalfedgeId, Mesh, OpenedMesh, VertexId};

/// Flattens every patch that is a disk, keeping the lengths of its rim as far as it can be closed (u = 0 on rims).
///
/// **Takes** an opened surface and its measures ([`Geometry::measure`] lets slivers along cuts pass).
/// **Gives** charts in frames of their own, counter-clockwise, in the unit of the positions.
/// **Fails** for lack of memory only; patches that cannot be flattened say so one by one.
/// **Costs** one symbolic analysis, one factorisation and three solves of A_II.
/// **From** [BFF] §4–6. **Differs**: closing lets rim directions give way together with lengths, and seam partners share
/// a length. **See** [`bff_with`].
pub fn bff(opened: &OpenedMesh, geometry: &Geometry) -> Result<Flattening, LinalgError> {
    Problem::new(opened, geometry, None).factor_and_solve()
}

/// Flattens every patch that is a disk, with given log scale factors on its rim.
///
/// **Takes** an opened surface and its measures, and u for each of its vertices, of which those on rims count. Along seams u is the
/// solution of A u = μ − Ω on the uncut surface, the same at all copies of a point (see the module); along the surface's own
/// boundary it is free.
/// **Gives** charts like [`bff`], whose angles about points on seams add up to 2π − μ, to the accuracy that u has as a solution, and
/// whose own boundaries turn as u demands. [`Flattening::angles_exact`] is false where charts could not be closed like that: then
/// rim directions gave way as in [`bff`].
/// **Fails** for lack of memory only; patches that cannot be flattened say so one by one, a patch whose rim would get lengths that are
/// not positive numbers among them.
/// **Costs** as [`bff`].
/// **From** [BFF] §5–6. **Differs**: closing changes lengths by the least relative entropy; where that is not possible, or by
/// more than a tenth, partners turn together (see the source of `closing`).
pub fn bff_scaled(
    opened: &OpenedMesh,
    geometry: &Geometry,
    rim_u: &[f64],
) -> Result<Flattening, LinalgError> {
    assert_eq!(rim_u.len(), opened.mesh.vertex_count());
    Problem::new(opened, geometry, Some(rim_u)).factor_and_solve()
}

/// [`bff`] with a factor that is at hand: the live preview of a cut flow.
///
/// **Takes** a factor of a matrix whose row `v` is, for each interior vertex `v` of a disk patch, that vertex' row of A_II.
/// Other rows may be anything that does not couple to those. A cut flow factors such a matrix on the vertices of the uncut
/// mesh in each step: they keep their numbers in the opened mesh, and those that a cut has made rim vertices are crossings,
/// with higher numbers. That holds before patches are cut to disks, so other patches wait for their charts.
/// **Costs** three solves. **See** [`bff`].
pub fn bff_with(
    opened: &OpenedMesh,
    geometry: &Geometry,
    interior: &mut Factor,
) -> Result<Flattening, LinalgError> {
    Problem::new(opened, geometry, None).solve(interior, None)
}

/// What a vertex is to the problem.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Isolated, or in a patch without chart.
    Outside,
    Interior,
    Rim,
}

struct Problem<'a> {
    opened: &'a OpenedMesh,
    mesh: &'a Mesh,
    geometry: &'a Geometry,
    charts: Vec<Result<Vec<HalfedgeId>, NoChart>>,
    vertex_patches: &'a [u32],
    roles: Vec<Role>,
    /// ½ (cot α + cot β) for each edge.
    edge_weights: Vec<f64>,
    /// Given log scale factors, which count on rims; 0 there if none are given.
    rim_u: Option<&'a [f64]>,
}

impl<'a> Problem<'a> {
    fn new(opened: &'a OpenedMesh, geometry: &'a Geometry, rim_u: Option<&'a [f64]>) -> Self {
        let mesh = &opened.mesh;
        let mut charts = rims(opened);
        let mut edge_weights = vec![0.0; mesh.edge_count()];
        for face in mesh.faces() {
            let cotangents = geometry.corner_cotangents[face.index()];
            let mut usable = cotangents.iter().all(|c| c.is_finite());
            for (i, h) in mesh.face_halfedges(face).into_iter().enumerate() {
                edge_weights[h.edge().index()] += 0.5 * cotangents[(i + 2) % 3];
                usable &= geometry.edge_length(h.edge()) > 0.0;
                if mesh.is_boundary_edge(h.edge()) {
                    let length = scaled_length(mesh, geometry, rim_u, h);
                    usable &= length > 0.0 && length.is_finite();
                }
            }
            let chart = &mut charts[opened.face_patches[face.index()] as usize];
            if !usable && chart.is_ok() {
                *chart = Err(NoChart::Degenerate { face });
            }
        }
        let vertex_patches = opened.vertex_patches();
        let roles = mesh
            .vertices()
            .map(|v| match mesh.halfedge(v) {
                Some(_) if charts[vertex_patches[v.index()] as usize].is_err() => Role::Outside,
                Some(_) if mesh.is_boundary_vertex(v) => Role::Rim,
                Some(_) => Role::Interior,
                None => Role::Outside,
            })
            .collect();
        Self { opened, mesh, geometry, charts, vertex_patches, roles, edge_weights, rim_u }
    }

    fn factor_and_solve(mut self) -> Result<Flattening, LinalgError> {
        let (pattern, slots) = self.interior_pattern();
        let analysis = Arc::new(Analysis::new(pattern)?);
        loop {
            let values = self.interior_values(analysis.pattern(), &slots);
            match Factor::new(analysis.clone(), &values) {
                Ok(mut factor) => return self.solve(&mut factor, Some(&values)),
                // Rounding in extreme slivers: the patch loses its chart, the others do not.
                Err(LinalgError::NotPositiveDefinite { row }) => self.give_up(VertexId::from(row)),
                Err(error) => return Err(error),
            }
        }
    }

    /// Log scale factor of a rim vertex.
    fn given(&self, v: VertexId) -> f64 {
        self.rim_u.map_or(0.0, |u| u[v.index()])
    }

    fn length(&self, h: HalfedgeId) -> f64 {
        scaled_length(self.mesh, self.geometry, self.rim_u, h)
    }

    fn is_interior(&self, v: VertexId) -> bool {
        self.roles[v.index()] == Role::Interior
    }

    /// The edges with both ends inside, as pairs.
    fn interior_pairs(&self) -> impl Iterator<Item = (usize, [VertexId; 2])> + '_ {
        self.mesh
            .edges()
            .map(|e| (e.index(), self.mesh.edge_vertices(e)))
            .filter(|(_, ends)| ends.iter().all(|&v| self.is_interior(v)))
    }

    /// Rows are vertices; those that are not interior stand alone. The slot of an edge with both ends inside follows
    /// those before it.
    fn interior_pattern(&self) -> (Pattern, Vec<u32>) {
        let mut slots = vec![0; self.mesh.edge_count()];
        let (edges, pairs): (Vec<usize>, Vec<[u32; 2]>) =
            self.interior_pairs().map(|(e, ends)| (e, ends.map(|v| v.0))).unzip();
        let (pattern, pair_slots) = Pattern::new(self.mesh.vertex_count(), &pairs);
        for (e, slot) in edges.into_iter().zip(pair_slots) {
            slots[e] = slot;
        }
        (pattern, slots)
    }

    fn interior_values(&self, pattern: &Pattern, slots: &[u32]) -> Vec<f64> {
        let mut values = vec![0.0; pattern.entry_count()];
        for v in self.mesh.vertices().filter(|&v| !self.is_interior(v)) {
            values[pattern.diagonal(v.index())] = 1.0;
        }
        for (e, ends) in self.interior_pairs() {
            values[slots[e] as usize] -= self.edge_weights[e];
            for v in ends {
                values[pattern.diagonal(v.index())] += self.edge_weights[e];
            }
        }
        for (inside, _, weight) in self.rim_edges() {
            values[pattern.diagonal(inside.index())] += weight;
        }
        values
    }

    /// Every edge that joins an interior vertex to a rim vertex, and its weight.
    fn rim_edges(&self) -> Vec<(VertexId, VertexId, f64)> {
        let mut edges = Vec::new();
        for &h in self.charts.iter().flatten().flatten() {
            let rim = self.mesh.tail(h);
            let leaving = self.mesh.outgoing(rim);
            edges.extend(leaving.map(|h| (h.edge(), self.mesh.tip(h), rim)));
        }
        edges.retain(|&(_, v, _)| self.is_interior(v));
        edges.sort_unstable();
        let weighed =
            |(e, inside, rim): (EdgeId, _, _)| (inside, rim, self.edge_weights[e.index()]);
        edges.into_iter().map(weighed).collect()
    }

    /// Calls with every edge that joins two rim vertices, and its weight.
    fn for_edges_on_rims(&self, mut call: impl FnMut([VertexId; 2], f64)) {
        for e in self.mesh.edges() {
            let ends = self.mesh.edge_vertices(e);
            if ends.iter().all(|v| self.roles[v.index()] == Role::Rim) {
                call(ends, self.edge_weights[e.index()]);
            }
        }
    }

    /// Takes the patch of a vertex out of the problem, because of that vertex.
    fn give_up(&mut self, v: VertexId) {
        let patch = self.vertex_patches[v.index()];
        self.charts[patch as usize] = Err(NoChart::Singular { vertex: v });
        for (role, &p) in self.roles.iter_mut().zip(self.vertex_patches) {
            if p == patch {
                *role = Role::Outside;
            }
        }
    }

    /// **Takes** the values of the factored matrix, where solutions are to be measured.
    fn solve(
        mut self,
        factor: &mut Factor,
        values: Option<&[f64]>,
    ) -> Result<Flattening, LinalgError> {
        let mut residual = 0.0;
        let mut solve = |factor: &mut Factor, x: &mut [f64], columns: usize| match values {
            Some(values) => {
                residual = worse(residual, factor.solve_measured(values, x, columns));
            }
            None => factor.solve(x, columns),
        };
        let rows = factor.analysis().pattern().size();
        let inside: Vec<VertexId> = self.mesh.vertices().filter(|&v| self.is_interior(v)).collect();
        debug_assert!(inside.iter().all(|v| v.index() < rows));

        let curvatures = angle_defects(self.mesh, self.geometry);
        let mut u = vec![0.0; rows];
        for v in &inside {
            u[v.index()] = -curvatures[v.index()];
        }
        let rim_edges = self.rim_edges();
        for &(inside, rim, weight) in &rim_edges {
            u[inside.index()] += weight * self.given(rim);
        }
        solve(factor, &mut u, 1);

        let mut rim_curvatures = curvatures;
        for &(inside, rim, weight) in &rim_edges {
            rim_curvatures[rim.index()] += weight * (self.given(rim) - u[inside.index()]);
        }
        if self.rim_u.is_some() {
            self.for_edges_on_rims(|ends, weight| {
                let flux = weight * (self.given(ends[0]) - self.given(ends[1]));
                rim_curvatures[ends[0].index()] += flux;
                rim_curvatures[ends[1].index()] -= flux;
            });
        }
        let Closed { places, seams_equal, angles_exact, closing } =
            self.close_rims(&rim_curvatures)?;

        let mut coordinates = vec![0.0; 2 * rows];
        for &(inside, rim, weight) in &rim_edges {
            coordinates[inside.index()] += weight * places[rim.index()].x;
            coordinates[rows + inside.index()] += weight * places[rim.index()].y;
        }
        solve(factor, &mut coordinates, 2);

        let mut uv = places;
        let mut scale_factors = vec![f64::NAN; self.mesh.vertex_count()];
        for v in self.mesh.vertices() {
            let i = v.index();
            match self.roles[i] {
                Role::Interior => {
                    uv[i] = Point2::new(coordinates[i], coordinates[rows + i]);
                    scale_factors[i] = u[i];
                }
                Role::Rim => scale_factors[i] = self.given(v),
                Role::Outside => {}
            }
        }
        let broken = |v: &VertexId| !(uv[v.index()].x + uv[v.index()].y).is_finite();
        for v in inside.into_iter().filter(broken).collect::<Vec<_>>() {
            if self.is_interior(v) {
                self.give_up(v);
            }
        }
        for (i, role) in self.roles.iter().enumerate() {
            if *role == Role::Outside {
                uv[i] = Point2::new(f64::NAN, f64::NAN);
                scale_factors[i] = f64::NAN;
            }
        }
        let charts = self.charts;
        Ok(Flattening {
            charts,
            uv,
            u: scale_factors,
            seams_equal,
            angles_exact,
            closing,
            residual,
        })
    }

    /// Places of the rim vertices.
    fn close_rims(&self, rim_curvatures: &[f64]) -> Result<Closed, LinalgError> {
        let mut polygons = Polygons {
            starts: vec![0],
            side_lengths: Vec::new(),
            lengths: Vec::new(),
            directions: Vec::new(),
        };
        let mut edge_lengths = vec![usize::MAX; self.mesh.edge_count()];
        for rim in self.charts.iter().flatten() {
            for &h in rim {
                // The first of two partners makes the length; the other one finds it.
                let shared = self.opened.partner(h).map_or(h, |p| p.min(h)).edge();
                let slot = &mut edge_lengths[shared.index()];
                if *slot == usize::MAX {
                    *slot = polygons.lengths.len();
                    polygons.lengths.push(self.length(h));
                }
                polygons.side_lengths.push(*slot);
            }
            self.push_directions(rim, rim_curvatures, &mut polygons.directions);
            polygons.starts.push(polygons.directions.len());
        }
        let keeping = if self.rim_u.is_some() { polygons.close_keeping_angles()? } else { None };
        let angles_exact = keeping.is_some();
        let closing = match keeping {
            Some(closing) => Some(closing),
            None => polygons.close_together(Turns::Free, MAX_LOG_RATIO)?,
        };
        let seams_equal = closing.is_some();
        if !seams_equal {
            polygons.close_apart();
        }
        let mut places = vec![Point2::new(f64::NAN, f64::NAN); self.mesh.vertex_count()];
        for (h, corner) in self.charts.iter().flatten().flatten().zip(polygons.corners()) {
            places[self.mesh.tail(*h).index()] = corner;
        }
        Ok(Closed { places, seams_equal, angles_exact, closing: closing.unwrap_or(0.0) })
    }

    /// Directions of a rim's sides, the first 0, each turned left from the one before by the curvature between them.
    ///
    /// A total that is not 2π (the factor's matrix is not exactly the one of these measures) is corrected evenly.
    fn push_directions(&self, rim: &[HalfedgeId], curvatures: &[f64], directions: &mut Vec<f64>) {
        let curvature = |h: &HalfedgeId| curvatures[self.mesh.tail(*h).index()];
        let length = |h: &HalfedgeId| self.length(*h);
        let perimeter: f64 = rim.iter().map(length).sum();
        let excess = (rim.iter().map(curvature).sum::<f64>() - TAU) / perimeter;
        let mut direction = 0.0;
        for (i, h) in rim.iter().enumerate() {
            if i > 0 {
                let dual_length = 0.5 * (length(&rim[i - 1]) + length(h));
                direction += curvature(h) - excess * dual_length;
            }
            directions.push(direction);
        }
    }
}

/// Rims in the plane.
struct Closed {
    /// Of the rim vertices; NaN elsewhere.
    places: Vec<Point2<f64>>,
    seams_equal: bool,
    angles_exact: bool,
    closing: f64,
}

/// l e^{(u_a + u_b) / 2}, or l without u.
fn scaled_length(mesh: &Mesh, geometry: &Geometry, u: Option<&[f64]>, h: HalfedgeId) -> f64 {
    let length = geometry.edge_length(h.edge());
    let scale = |u: &[f64]| (0.5 * (u[mesh.tail(h).index()] + u[mesh.tip(h).index()])).exp();
    u.map_or(length, |u| length * scale(u))
}
