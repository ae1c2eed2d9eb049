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

/// The system of one patch: rows are its vertices off the rim.
pub struct InteriorSystem<'a> {
    patch: &'a Patch,
    mesh: &'a Mesh,
    geometry: &'a Geometry,
    /// Row of each vertex.
    rows: Vec<u32>,
    count: usize,
    factor: Option<Factor>,
    values: Vec<f64>,
    residual: f64,
}

impl<'a> InteriorSystem<'a> {
    /// Assembles and factors. **Costs** one analysis and one factorisation of as many rows as there are vertices off the rim.
    pub fn new(
        patch: &'a Patch,
        mesh: &'a Mesh,
        geometry: &'a Geometry,
    ) -> Result<Self, LinalgError> {
        let mut rows = vec![NONE; patch.vertices.len()];
        let mut count = 0;
        for (row, is_rim) in rows.iter_mut().zip(&patch.is_rim) {
            if !is_rim {
                *row = small(count);
                count += 1;
            }
        }
        let (factor, values, residual) = (None, Vec::new(), 0.0);
        let mut system = Self { patch, mesh, geometry, rows, count, factor, values, residual };
        if count > 0 {
            let mut pairs = Vec::with_capacity(3 * patch.faces.len());
            let mut weights = Vec::with_capacity(3 * patch.faces.len());
            let mut diagonal = vec![0.0; count];
            system.for_sides(|_, _, [a, b], weight| {
                let [i, j] = [a, b].map(|v| system.rows[v]);
                for row in [i, j] {
                    if row != NONE {
                        diagonal[row as usize] += weight;
                    }
                }
                if i != NONE && j != NONE {
                    pairs.push([i, j]);
                    weights.push(weight);
                }
            });
            let (pattern, slots) = Pattern::new(count, &pairs);
            let mut values = vec![0.0; pattern.entry_count()];
            for (slot, weight) in slots.into_iter().zip(weights) {
                values[slot as usize] -= weight;
            }
            for (row, weight) in diagonal.into_iter().enumerate() {
                values[pattern.diagonal(row)] = weight;
            }
            system.factor = Some(Factor::new(Arc::new(Analysis::new(pattern)?), &values)?);
            system.values = values;
        }
        Ok(system)
    }

    /// Calls with each side of each face: face, side, its ends, and half the cotangent opposite.
    fn for_sides(&self, mut call: impl FnMut(usize, usize, [usize; 2], f64)) {
        for (f, corners) in self.patch.corners.iter().enumerate() {
            let cotangents = self.geometry.corner_cotangents[self.patch.faces[f].index()];
            for i in 0..3 {
                let ends = [corners[i] as usize, corners[(i + 1) % 3] as usize];
                call(f, i, ends, 0.5 * cotangents[(i + 2) % 3]);
            }
        }
    }

    /// Places with the given loads; those of the rim stay.
    fn solve(&mut self, places: &mut [Complex<f64>], loads: &[Complex<f64>]) {
        let n = self.count;
        let mut x = vec![0.0; 2 * n];
        for (&row, load) in self.rows.iter().zip(loads) {
            if row != NONE {
                x[row as usize] = load.re;
                x[n + row as usize] = load.im;
            }
        }
        self.for_sides(|_, _, [a, b], weight| {
            for [inside, rim] in [[a, b], [b, a]] {
                let row = self.rows[inside];
                if row != NONE && self.rows[rim] == NONE {
                    x[row as usize] += weight * places[rim].re;
                    x[n + row as usize] += weight * places[rim].im;
                }
            }
        });
        let Some(factor) = &mut self.factor else { return };
        self.residual = factor.solve_measured(&self.values, &mut x, 2);
        for (&row, place) in self.rows.iter().zip(places) {
            if row != NONE {
                *place = Complex::new(x[row as usize], x[n + row as usize]);
            }
        }
    }

    /// Fills the places off the rim in: the harmonic map, then so many local/global steps towards true lengths.
    ///
    /// **Takes** a place for each vertex of the patch, of which those on the rim count. **Costs** a solve of two columns for the map and for each step.
    pub fn fill(&mut self, places: &mut [Point2<f64>], rigid_steps: usize) {
        let mut x: Vec<Complex<f64>> = places.iter().map(|p| Complex::new(p.x, p.y)).collect();
        let loads = vec![Complex::default(); x.len()];
        self.solve(&mut x, &loads);
        for (place, z) in places.iter_mut().zip(x) {
            *place = Point2::new(z.re, z.im);
        }
        self.refine(places, rigid_steps);
    }

    /// Relative residual of the last solve; 0 before the first and without unknowns.
    pub fn residual(&self) -> f64 {
        self.residual
    }

    /// Local/global steps towards true lengths from a map that is there.
    pub fn refine(&mut self, places: &mut [Point2<f64>], rigid_steps: usize) {
        if rigid_steps == 0 {
            return;
        }
        let mut x: Vec<Complex<f64>> = places.iter().map(|p| Complex::new(p.x, p.y)).collect();
        let mut loads = vec![Complex::default(); x.len()];
        let rests: Vec<[Complex<f64>; 3]> =
            (0..self.patch.faces.len()).map(|f| self.rest(f)).collect();
        for _ in 0..rigid_steps {
            loads.fill(Complex::default());
            for (f, corners) in self.patch.corners.iter().enumerate() {
                let cotangents = self.geometry.corner_cotangents[self.patch.faces[f].index()];
                let [a, b, c] = corners.map(|v| v as usize);
                let images = [x[b] - x[a], x[c] - x[b], x[a] - x[c]];
                let mut fit = Complex::new(0.0, 0.0);
                for i in 0..3 {
                    fit += images[i] * rests[f][i].conj() * cotangents[(i + 2) % 3];
                }
                // A face that has shrunk to a point fits any way round.
                let size = fit.norm();
                let turn = if size > 0.0 { fit / size } else { Complex::new(1.0, 0.0) };
                for (i, [from, to]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                    let pull = turn * rests[f][i] * (0.5 * cotangents[(i + 2) % 3]);
                    loads[from] -= pull;
                    loads[to] += pull;
                }
            }
            self.solve(&mut x, &loads);
        }
        for (place, z) in places.iter_mut().zip(x) {
            *place = Point2::new(z.re, z.im);
        }
    }

    /// Sides of a face laid into the plane, its first along the x axis.
    fn rest(&self, f: usize) -> [Complex<f64>; 3] {
        let face = self.patch.faces[f];
        let [first, _, third] =
            self.mesh.face_halfedges(face).map(|h| self.geometry.edge_length(h.edge()));
        let angle = self.geometry.corner_angles[face.index()][0];
        let (first, third) = (Complex::new(first, 0.0), -Complex::from_polar(third, angle));
        [first, -third - first, third]
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
