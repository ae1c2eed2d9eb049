//! The inside of one patch between places of its rim, numbered for itself: harmonic, then as rigid as possible with the same factor.

use std::sync::Arc;

use nalgebra::{Complex, Point2};

use crate::flatten::overlap::orientation;
use crate::flatten::small;
use crate::geometry::Geometry;
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};
use crate::mesh::Mesh;

use super::patch::Patch;

const NONE: u32 = u32::MAX;

/// What a map of one patch is worth: the measures that decide whether patches are merged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchMeasures {
    /// Number of faces.
    pub faces: usize,
    /// Area on the surface.
    pub area: f64,
    /// A_tot = |Σ (A′ − A)| / Σ A with A′ the signed area in the plane.
    pub area_total: f64,
    /// A_abs = Σ |A′ − A| / Σ A.
    pub area_absolute: f64,
    /// L² stretch of [SSGH01], raw, over faces that are not turned over.
    pub l2_stretch: f64,
    /// L² stretch times √(Σ A′ / Σ A) over the same faces.
    pub l2_stretch_normalized: f64,
    /// Faces that are turned over or have no area in the plane, by exact predicates.
    pub flipped: usize,
}

/// What all patches of a surface have in common.
#[derive(Clone, Debug)]
pub struct Stiffness {
    /// Half the cotangents opposite each edge, summed.
    edges: Vec<f64>,
    /// Each side of each face laid into the plane, the first along the x axis, times half the cotangent opposite.
    pulls: Vec<[Complex<f64>; 3]>,
    /// When each vertex is eliminated from the whole surface; patches keep that order. What fills in there fills in here at most, because all
    /// paths within a patch are paths on the surface.
    places: Vec<u32>,
}

impl Stiffness {
    /// **Fails** for lack of memory. **Costs** O(F), and the ordering of one factorisation.
    pub fn new(mesh: &Mesh, geometry: &Geometry) -> Result<Self, LinalgError> {
        let mut edges = vec![0.0; mesh.edge_count()];
        let mut pulls = Vec::with_capacity(mesh.face_count());
        for f in mesh.faces() {
            let sides = mesh.face_halfedges(f);
            let weights = [2, 0, 1].map(|i| 0.5 * geometry.corner_cotangents[f.index()][i]);
            for (h, weight) in sides.iter().zip(weights) {
                edges[h.edge().index()] += weight;
            }
            let [first, _, third] = sides.map(|h| geometry.edge_length(h.edge()));
            let angle = geometry.corner_angles[f.index()][0];
            let (first, third) = (Complex::new(first, 0.0), -Complex::from_polar(third, angle));
            let rest = [first, -third - first, third];
            pulls.push([0, 1, 2].map(|i| rest[i] * weights[i]));
        }
        let pairs: Vec<[u32; 2]> =
            mesh.edges().map(|e| mesh.edge_vertices(e).map(|v| v.0)).collect();
        let (pattern, _) = Pattern::new(mesh.vertex_count(), &pairs);
        let places = Analysis::new(pattern)?.order().places().to_vec();
        Ok(Self { edges, pulls, places })
    }
}

/// The system of one patch: rows are its vertices off the rim.
pub struct InteriorSystem<'a> {
    patch: &'a Patch,
    geometry: &'a Geometry,
    stiffness: &'a Stiffness,
    /// Row of each vertex.
    rows: Vec<u32>,
    count: usize,
    /// Rows that are joined to the rim, the vertex there, and the weight.
    at_rim: Vec<(u32, u32, f64)>,
    factor: Option<Factor>,
    values: Vec<f64>,
    residual: f64,
}

impl<'a> InteriorSystem<'a> {
    /// Assembles and factors. **Costs** one factorisation of as many rows as there are vertices off the rim, without an ordering.
    pub fn new(
        patch: &'a Patch,
        mesh: &'a Mesh,
        geometry: &'a Geometry,
        stiffness: &'a Stiffness,
    ) -> Result<Self, LinalgError> {
        let mut order: Vec<(u32, u32)> = (0..small(patch.vertices.len()))
            .filter(|&v| !patch.is_rim[v as usize])
            .map(|v| (stiffness.places[patch.vertices[v as usize].index()], v))
            .collect();
        order.sort_unstable();
        let count = order.len();
        let mut rows = vec![NONE; patch.vertices.len()];
        for (row, &(_, v)) in order.iter().enumerate() {
            rows[v as usize] = small(row);
        }
        let mut at_rim = Vec::new();
        let (mut factor, mut kept) = (None, Vec::new());
        if count > 0 {
            let mut pairs = Vec::with_capacity(3 * count);
            let mut weights = Vec::with_capacity(3 * count);
            let mut diagonal = vec![0.0; count];
            for (corners, &f) in patch.corners.iter().zip(&patch.faces) {
                for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
                    let (from, to) = (corners[i], corners[(i + 1) % 3]);
                    let row = rows[from as usize];
                    // Off the rim both sides of every edge lie in the patch: each is met from both ends.
                    if row == NONE {
                        continue;
                    }
                    let weight = stiffness.edges[h.edge().index()];
                    diagonal[row as usize] += weight;
                    match rows[to as usize] {
                        NONE => at_rim.push((row, to, weight)),
                        other if row < other => {
                            pairs.push([row, other]);
                            weights.push(weight);
                        }
                        _ => {}
                    }
                }
            }
            let (pattern, slots) = Pattern::new(count, &pairs);
            let mut values = vec![0.0; pattern.entry_count()];
            for (slot, weight) in slots.into_iter().zip(weights) {
                values[slot as usize] -= weight;
            }
            for (row, weight) in diagonal.into_iter().enumerate() {
                values[pattern.diagonal(row)] = weight;
            }
            factor = Some(Factor::new(Arc::new(Analysis::in_place(pattern)?), &values)?);
            kept = values;
        }
        Ok(Self {
            patch,
            geometry,
            stiffness,
            rows,
            count,
            at_rim,
            factor,
            values: kept,
            residual: 0.0,
        })
    }

    /// Places off the rim for the given right-hand side without what the rim adds, one column for each coordinate.
    fn solve(&mut self, places: &mut [Point2<f64>], x: &mut [f64]) {
        let n = self.count;
        for &(row, rim, weight) in &self.at_rim {
            x[row as usize] += weight * places[rim as usize].x;
            x[n + row as usize] += weight * places[rim as usize].y;
        }
        let Some(factor) = &mut self.factor else { return };
        self.residual = factor.solve_measured(&self.values, x, 2);
        for (&row, place) in self.rows.iter().zip(places) {
            if row != NONE {
                *place = Point2::new(x[row as usize], x[n + row as usize]);
            }
        }
    }

    /// Fills the places off the rim in with the harmonic map.
    ///
    /// **Takes** a place for each vertex of the patch, of which those on the rim count. **Costs** a solve of two columns.
    pub fn fill(&mut self, places: &mut [Point2<f64>]) {
        let mut x = vec![0.0; 2 * self.count];
        self.solve(places, &mut x);
    }

    /// Relative residual of the last solve; 0 before the first and without unknowns.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// Local/global steps towards true lengths from a map that is there. **Costs** a solve of two columns for each.
    pub fn refine(&mut self, places: &mut [Point2<f64>], rigid_steps: usize) {
        let n = self.count;
        let mut x = vec![0.0; 2 * n];
        for _ in 0..rigid_steps {
            x.fill(0.0);
            for (corners, f) in self.patch.corners.iter().zip(&self.patch.faces) {
                let pulls = self.stiffness.pulls[f.index()];
                let [a, b, c] = corners.map(|v| places[v as usize]);
                let images = [b - a, c - b, a - c].map(|d| Complex::new(d.x, d.y));
                let fit: Complex<f64> = (0..3).map(|i| images[i] * pulls[i].conj()).sum();
                // A face that has shrunk to a point fits any way round.
                let size = fit.norm_sqr().sqrt();
                let turn = if size > 0.0 { fit / size } else { Complex::new(1.0, 0.0) };
                let pulls = pulls.map(|pull| turn * pull);
                for i in 0..3 {
                    let row = self.rows[corners[i] as usize];
                    if row != NONE {
                        // From the side that arrives, away from the one that leaves.
                        let load = pulls[(i + 2) % 3] - pulls[i];
                        x[row as usize] += load.re;
                        x[n + row as usize] += load.im;
                    }
                }
            }
            self.solve(places, &mut x);
        }
    }

    /// What a map is worth. **Costs** O(F).
    pub fn measure(&self, places: &[Point2<f64>]) -> PatchMeasures {
        let mut sums = PatchMeasures { faces: self.patch.faces.len(), ..Default::default() };
        let (mut flat, mut off, mut weight, mut flat_weight, mut stretch) =
            (0.0, 0.0, 0.0, 0.0, 0.0);
        for (f, corners) in self.patch.corners.iter().enumerate() {
            let area = self.geometry.face_areas[self.patch.faces[f].index()];
            let [a, b, c] = corners.map(|v| places[v as usize]);
            let doubled = orientation(a, b, c);
            sums.area += area;
            flat += 0.5 * doubled;
            off += (0.5 * doubled - area).abs();
            if !(doubled > 0.0) {
                sums.flipped += 1;
                continue;
            }
            if area > 0.0 {
                // |f_x|² + |f_y|² = Σ cot |image of the side|² / 2A, the Dirichlet energy of the face.
                let cotangents = self.geometry.corner_cotangents[self.patch.faces[f].index()];
                let lengths = [(b - a), (c - b), (a - c)].map(|d| d.norm_squared());
                let dirichlet: f64 =
                    (0..3).map(|i| lengths[i] * cotangents[(i + 2) % 3]).sum::<f64>()
                        / (2.0 * area);
                let ratio = 0.5 * doubled / area;
                stretch += area * 0.5 * dirichlet / (ratio * ratio);
                weight += area;
                flat_weight += 0.5 * doubled;
            }
        }
        sums.area_total = (flat - sums.area).abs() / sums.area;
        sums.area_absolute = off / sums.area;
        sums.l2_stretch = (stretch / weight).sqrt();
        sums.l2_stretch_normalized = sums.l2_stretch * (flat_weight / weight).sqrt();
        sums
    }
}
