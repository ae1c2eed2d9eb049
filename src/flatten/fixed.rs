//! Maps with the whole rim fixed: the interior between given places of all rim vertices.
//!
//! Needed wherever the rim is decided first, as when boundary lengths are preserved [LPFB]. Patches are taken as they are, uncut, with any
//! number of rims: holes are held like outlines. Three interiors, each from the intrinsic metric of the surface alone:
//!
//! * *harmonic*: A_II x = −A_IB x_B with the cotan Laplacian A, both coordinates with one factor. Obtuse triangles make weights negative, and
//!   then faces may turn over even where the rim is convex.
//! * *as rigid as possible*: from there some steps of the local/global iteration with the same factor; each turns every face
//!   to where it fits best and solves for places nearest to these. Nearer to isometric, no safer.
//! * *mean value*: each interior vertex is a mean of its neighbours with positive weights (tan ½γ + tan ½δ) / l. No face turns over where one rim is
//!   fixed that is convex (Floater 2003), if no inner edge joins two vertices on one straight side.
//!
//! Guaranteed: rim vertices lie where they were asked to; flips are counted by exact predicates, and which interior each patch got is said. Not
//! guaranteed: freedom from flips on rims that are not convex.

use std::sync::Arc;

use nalgebra::{Complex, Point2};

use super::disks::{Disks, log_scales};
use super::overlap::orientation;
use super::{Flattening, rims, small};
use crate::geometry::Geometry;
use crate::linalg::{Analysis, Factor, LinalgError, Pattern, worse};
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh, VertexId};

/// tan ½γ stays below this: an angle of π has no neighbour that far away to lean on.
const STEEPEST: f64 = 1e8;

/// Corrections of the mean-value solution. The normal equations have the square of the system's condition; each correction by
/// the system's own residual wins back what that costs, and two leave rounding.
const CORRECTIONS: usize = 2;

/// How the interior of a patch follows from its rim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interior {
    /// Both coordinates are harmonic.
    Harmonic,
    /// As rigid as possible from the harmonic map, by so many steps.
    Rigid {
        /// Steps; 3 come near the end.
        steps: usize,
    },
    /// Means of neighbours with positive weights.
    MeanValue,
}

/// Charts with given rims.
#[derive(Clone, Debug)]
pub struct FixedMap {
    /// Place of every vertex; NaN in patches without map.
    pub uv: Vec<Point2<f64>>,
    /// For each patch the interior that it got; none where a patch has no rim, its places are not finite, or a face has no usable shape.
    pub interiors: Vec<Option<Interior>>,
    /// For each patch the faces that are turned over or have no area in the plane.
    pub flipped: Vec<usize>,
    /// For each patch the vertex at which its system broke down, if it did.
    pub singular: Vec<Option<VertexId>>,
    /// Largest relative residual of the systems that gave places.
    pub residual: f64,
}

/// Fills in every patch between the places of its rim vertices.
///
/// **Takes** a place for each opened vertex, of which those on rims count; the interiors to try for each patch, in this order, until
/// one has no flips. If all have some, the one with the fewest is kept.
/// **Gives** a map of every patch that has a rim, holes or not.
/// **Fails** for lack of memory only. **Costs** one factorisation of the interior's Laplacian for harmonic and rigid interiors together, with one solve of two
/// columns and one more for each rigid step; a factorisation over two-rings, some three times as much, where mean values are asked for and needed.
pub fn fixed_rim(
    opened: &OpenedMesh,
    geometry: &Geometry,
    places: &[Point2<f64>],
    order: &[Interior],
) -> Result<FixedMap, LinalgError> {
    assert_eq!(places.len(), opened.mesh.vertex_count());
    let mut problem = Problem::new(opened, geometry, places);
    let patch_count = opened.patch_count;
    let nowhere = Point2::new(f64::NAN, f64::NAN);
    let mut map = FixedMap {
        uv: vec![nowhere; places.len()],
        interiors: vec![None; patch_count],
        flipped: vec![0; patch_count],
        singular: Vec::new(),
        residual: 0.0,
    };
    let mut harmonic: Option<(System, Vec<Complex<f64>>)> = None;
    for &interior in order {
        // Patches that are content stand aside where that saves a factorisation.
        let wanted: Vec<bool> = (0..patch_count)
            .map(|p| problem.usable[p] && (map.interiors[p].is_none() || map.flipped[p] > 0))
            .collect();
        if !wanted.contains(&true) {
            break;
        }
        let found = match interior {
            Interior::MeanValue => problem.mean_value(&wanted)?,
            Interior::Harmonic | Interior::Rigid { .. } => {
                let (system, found) = match &mut harmonic {
                    Some(known) => known,
                    none => none.insert(problem.harmonic()?),
                };
                match interior {
                    Interior::Rigid { steps } => problem.rigid(system, found, steps),
                    _ => found.clone(),
                }
            }
        };
        problem.keep_better(interior, &found, &wanted, &mut map);
    }
    (map.singular, map.residual) = (problem.singular, problem.residual);
    Ok(map)
}

impl FixedMap {
    /// The maps of disks as charts, with log scales from areas. [`Flattening::seams_equal`] says whether the given rims were so, to ten digits.
    pub fn flattening(&self, opened: &OpenedMesh, geometry: &Geometry) -> Flattening {
        let mut disks = Disks::new(opened, geometry);
        for patch in 0..opened.patch_count {
            if self.interiors[patch].is_none() && disks.charts[patch].is_ok() {
                match self.singular[patch] {
                    Some(vertex) => disks.break_down(vertex),
                    None => disks.give_up(small(patch)),
                }
            }
        }
        let place = |v: VertexId| {
            if disks.is_in(v) { self.uv[v.index()] } else { Point2::new(f64::NAN, f64::NAN) }
        };
        let uv: Vec<_> = opened.mesh.vertices().map(place).collect();
        let seams_equal = seam_difference(opened, &uv) < 1e-10;
        let u = log_scales(opened, geometry, &uv);
        let (charts, residual) = (disks.charts, self.residual);
        Flattening::of_places(charts, uv, u, seams_equal, residual)
    }
}

/// Largest |a − b| / ½(a + b) over seam partners of lengths a, b in charts; 0 without seams.
pub fn seam_difference(opened: &OpenedMesh, uv: &[Point2<f64>]) -> f64 {
    let length =
        |h: HalfedgeId| (uv[opened.mesh.tip(h).index()] - uv[opened.mesh.tail(h).index()]).norm();
    let mut worst = 0.0f64;
    for h in rims(opened).into_iter().flatten().flatten() {
        if let Some(partner) = opened.partner(h) {
            let (a, b) = (length(h), length(partner));
            if (a + b) > 0.0 {
                worst = worst.max((a - b).abs() / (0.5 * (a + b)));
            }
        }
    }
    worst
}

struct Problem<'a> {
    opened: &'a OpenedMesh,
    geometry: &'a Geometry,
    places: Vec<Complex<f64>>,
    vertex_patches: &'a [u32],
    usable: Vec<bool>,
    /// Whether the place of each vertex is sought: off the rims of patches in use.
    unknown: Vec<bool>,
    singular: Vec<Option<VertexId>>,
    residual: f64,
}

/// A matrix and its factor.
struct System {
    factor: Factor,
    values: Vec<f64>,
}

impl<'a> Problem<'a> {
    fn new(opened: &'a OpenedMesh, geometry: &'a Geometry, places: &[Point2<f64>]) -> Self {
        let mesh = &opened.mesh;
        let vertex_patches = opened.vertex_patches();
        let mut usable = vec![false; opened.patch_count];
        for &h in mesh.boundary_loops() {
            usable[vertex_patches[mesh.tail(h).index()] as usize] = true;
        }
        for v in mesh.vertices().filter(|&v| mesh.is_boundary_vertex(v)) {
            let place = places[v.index()];
            usable[vertex_patches[v.index()] as usize] &= place.iter().all(|x| x.is_finite());
        }
        for f in mesh.faces() {
            let shaped = geometry.corner_cotangents[f.index()].iter().all(|c| c.is_finite())
                && mesh.face_halfedges(f).iter().all(|h| geometry.edge_length(h.edge()) > 0.0);
            usable[opened.face_patches[f.index()] as usize] &= shaped;
        }
        let places = places.iter().map(|p| Complex::new(p.x, p.y)).collect();
        let singular = vec![None; usable.len()];
        let mut problem = Self {
            opened,
            geometry,
            places,
            vertex_patches,
            usable,
            unknown: Vec::new(),
            singular,
            residual: 0.0,
        };
        problem.find_unknown();
        problem
    }

    /// Brings `unknown` up to date with the patches in use.
    fn find_unknown(&mut self) {
        let mesh = &self.opened.mesh;
        let is_unknown = |v: VertexId| {
            mesh.halfedge(v).is_some()
                && !mesh.is_boundary_vertex(v)
                && self.usable[self.vertex_patches[v.index()] as usize]
        };
        self.unknown = mesh.vertices().map(is_unknown).collect();
    }

    fn is_unknown(&self, v: VertexId) -> bool {
        self.unknown[v.index()]
    }

    /// Whether a face lies in a patch with a map.
    fn is_used(&self, f: FaceId) -> bool {
        self.usable[self.opened.face_patches[f.index()] as usize]
    }

    /// Halfedges of faces in patches with a map, with the cotangent opposite.
    fn sides(&self) -> impl Iterator<Item = (FaceId, usize, [VertexId; 2], f64)> + '_ {
        let mesh = &self.opened.mesh;
        mesh.faces().filter(|f| self.is_used(*f)).flat_map(move |f| {
            let corners = mesh.face_vertices(f);
            let cotangents = self.geometry.corner_cotangents[f.index()];
            (0..3).map(move |i| (f, i, [corners[i], corners[(i + 1) % 3]], cotangents[(i + 2) % 3]))
        })
    }

    /// The harmonic map and the factor that made it. Patches whose system cannot be factored are out of use from then on.
    fn harmonic(&mut self) -> Result<(System, Vec<Complex<f64>>), LinalgError> {
        loop {
            let (pattern, values) = self.laplacian();
            match Factor::new(Arc::new(Analysis::new(pattern)?), &values) {
                Ok(factor) => {
                    let nothing = vec![Complex::default(); self.places.len()];
                    let mut system = System { factor, values };
                    let found = self.solve(&mut system, &nothing);
                    return Ok((system, found));
                }
                Err(LinalgError::NotPositiveDefinite { row }) => self.give_up(row)?,
                Err(error) => return Err(error),
            }
        }
    }

    fn give_up(&mut self, row: usize) -> Result<(), LinalgError> {
        if !self.is_unknown(VertexId::from(row)) {
            return Err(LinalgError::NotPositiveDefinite { row });
        }
        let patch = self.vertex_patches[row] as usize;
        self.usable[patch] = false;
        self.singular[patch] = Some(VertexId::from(row));
        self.find_unknown();
        Ok(())
    }

    /// Half the cotangents opposite each edge, summed over its faces in use.
    fn edge_weights(&self) -> Vec<f64> {
        let mesh = &self.opened.mesh;
        let mut weights = vec![0.0; mesh.edge_count()];
        for f in mesh.faces().filter(|f| self.is_used(*f)) {
            let cotangents = self.geometry.corner_cotangents[f.index()];
            for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
                weights[h.edge().index()] += 0.5 * cotangents[(i + 2) % 3];
            }
        }
        weights
    }

    fn laplacian(&self) -> (Pattern, Vec<f64>) {
        let (mesh, n) = (&self.opened.mesh, self.places.len());
        let mut pairs = Vec::with_capacity(mesh.edge_count());
        let mut weights = Vec::with_capacity(mesh.edge_count());
        let mut diagonal = vec![0.0; n];
        for (e, weight) in mesh.edges().zip(self.edge_weights()) {
            let [a, b] = mesh.edge_vertices(e);
            diagonal[a.index()] += weight;
            diagonal[b.index()] += weight;
            if self.is_unknown(a) && self.is_unknown(b) {
                pairs.push([a.0, b.0]);
                weights.push(weight);
            }
        }
        let (pattern, slots) = Pattern::new(n, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        for (slot, weight) in slots.into_iter().zip(weights) {
            values[slot as usize] -= weight;
        }
        for (v, weight) in diagonal.into_iter().enumerate() {
            values[pattern.diagonal(v)] = if self.unknown[v] { weight } else { 1.0 };
        }
        (pattern, values)
    }

    /// Solves A_II x = loads − A_IB x_B; places of rims are the given ones.
    fn solve(&mut self, system: &mut System, loads: &[Complex<f64>]) -> Vec<Complex<f64>> {
        let n = self.places.len();
        let mut rhs = self.places.clone();
        for v in (0..n).filter(|&v| self.unknown[v]) {
            rhs[v] = loads[v];
        }
        for (_, _, [a, b], cotangent) in self.sides() {
            for [inside, rim] in [[a, b], [b, a]] {
                if self.is_unknown(inside) && !self.is_unknown(rim) {
                    rhs[inside.index()] += self.places[rim.index()] * (0.5 * cotangent);
                }
            }
        }
        let mut x: Vec<f64> = rhs.iter().map(|z| z.re).chain(rhs.iter().map(|z| z.im)).collect();
        let residual = system.factor.solve_measured(&system.values, &mut x, 2);
        self.residual = worse(self.residual, residual);
        (0..n).map(|v| Complex::new(x[v], x[n + v])).collect()
    }

    /// Local/global steps: each face turned to fit its image, then places nearest to the turned faces.
    fn rigid(
        &mut self,
        system: &mut System,
        start: &[Complex<f64>],
        steps: usize,
    ) -> Vec<Complex<f64>> {
        let opened = self.opened;
        let mesh = &opened.mesh;
        let mut x = start.to_vec();
        let rests: Vec<[Complex<f64>; 3]> = mesh.faces().map(|f| self.rest(f)).collect();
        for _ in 0..steps {
            let mut fits = vec![Complex::new(0.0, 0.0); mesh.face_count()];
            for (f, i, [a, b], cotangent) in self.sides() {
                let image = x[b.index()] - x[a.index()];
                fits[f.index()] += image * rests[f.index()][i].conj() * cotangent;
            }
            let mut loads = vec![Complex::default(); x.len()];
            for (f, i, [a, b], cotangent) in self.sides() {
                let fit = fits[f.index()];
                // A face that has shrunk to a point fits any way round.
                let turn = if fit.norm() > 0.0 { fit / fit.norm() } else { Complex::new(1.0, 0.0) };
                let pull = turn * rests[f.index()][i] * (0.5 * cotangent);
                loads[a.index()] -= pull;
                loads[b.index()] += pull;
            }
            x = self.solve(system, &loads);
        }
        x
    }

    /// Sides of a face in the plane, its first along the x axis.
    fn rest(&self, f: FaceId) -> [Complex<f64>; 3] {
        let [first, _, third] =
            self.opened.mesh.face_halfedges(f).map(|h| self.geometry.edge_length(h.edge()));
        let angle = self.geometry.corner_angles[f.index()][0];
        let (first, third) = (Complex::new(first, 0.0), -Complex::from_polar(third, angle));
        [first, -third - first, third]
    }

    /// Rows of means: for each unknown vertex its neighbours and their weights, which sum to 1.
    fn mean_value_rows(&self) -> Vec<Vec<(usize, f64)>> {
        let mesh = &self.opened.mesh;
        let mut rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.places.len()];
        for v in mesh.vertices().filter(|&v| self.is_unknown(v)) {
            for h in mesh.outgoing(v) {
                let half = |f: Option<FaceId>| {
                    let Some(f) = f else { return 0.0 };
                    let corner = mesh.face_vertices(f).iter().position(|&w| w == v).unwrap_or(0);
                    (0.5 * self.geometry.corner_angles[f.index()][corner])
                        .tan()
                        .clamp(0.0, STEEPEST)
                };
                let weight = half(mesh.face(h)) + half(mesh.face(h.twin()));
                let weight = weight / self.geometry.edge_length(h.edge());
                rows[v.index()].push((mesh.tip(h).index(), weight));
            }
            let sum: f64 = rows[v.index()].iter().map(|r| r.1).sum();
            rows[v.index()].iter_mut().for_each(|r| r.1 /= sum);
        }
        rows
    }

    /// Solves A x = b, A = 1 − means, by normal equations.
    fn mean_value(&mut self, wanted: &[bool]) -> Result<Vec<Complex<f64>>, LinalgError> {
        let before = self.usable.clone();
        self.usable = self.usable.iter().zip(wanted).map(|(u, w)| *u && *w).collect();
        self.find_unknown();
        let n = self.places.len();
        let (rows, mut factor) = loop {
            let rows = self.mean_value_rows();
            let (pattern, values) = self.normal_matrix(&rows);
            match Factor::new(Arc::new(Analysis::new(pattern)?), &values) {
                Ok(factor) => break (rows, factor),
                Err(LinalgError::NotPositiveDefinite { row }) => self.give_up(row)?,
                Err(error) => return Err(error),
            }
        };
        let mut x = self.places.clone();
        let unknown: Vec<usize> = (0..n).filter(|&v| self.unknown[v]).collect();
        unknown.iter().for_each(|&v| x[v] = Complex::default());
        for _ in 0..=CORRECTIONS {
            let mut rhs = vec![0.0; 2 * n];
            for &v in &unknown {
                let mean: Complex<f64> = rows[v].iter().map(|&(w, weight)| x[w] * weight).sum();
                let missing = mean - x[v];
                rhs[v] += missing.re;
                rhs[n + v] += missing.im;
                for &(w, weight) in &rows[v] {
                    if self.is_unknown(VertexId::from(w)) {
                        rhs[w] -= weight * missing.re;
                        rhs[n + w] -= weight * missing.im;
                    }
                }
            }
            factor.solve(&mut rhs, 2);
            for &v in &unknown {
                x[v] += Complex::new(rhs[v], rhs[n + v]);
            }
        }
        let size = unknown.iter().map(|&v| x[v].norm()).fold(0.0, f64::max);
        for &v in &unknown {
            let mean: Complex<f64> = rows[v].iter().map(|&(w, weight)| x[w] * weight).sum();
            let off = (mean - x[v]).norm();
            if !(off <= 0.0) {
                self.residual = worse(self.residual, off / size);
            }
        }
        // Patches that failed here alone keep the interior that they have.
        for (v, x) in x.iter_mut().enumerate() {
            if !self.usable[self.vertex_patches[v] as usize] {
                *x = Complex::new(f64::NAN, f64::NAN);
            }
        }
        self.usable = before;
        self.find_unknown();
        Ok(x)
    }

    /// AᵀA over the unknown vertices.
    fn normal_matrix(&self, rows: &[Vec<(usize, f64)>]) -> (Pattern, Vec<f64>) {
        let n = rows.len();
        let (mut pairs, mut products) = (Vec::new(), Vec::new());
        let mut diagonal: Vec<f64> =
            self.unknown.iter().map(|unknown| f64::from(u8::from(!unknown))).collect();
        for (v, row) in rows.iter().enumerate().filter(|(_, row)| !row.is_empty()) {
            let mut entries = vec![(v, 1.0)];
            let inside = row.iter().filter(|r| self.is_unknown(VertexId::from(r.0)));
            entries.extend(inside.map(|&(w, weight)| (w, -weight)));
            for (i, &(a, x)) in entries.iter().enumerate() {
                diagonal[a] += x * x;
                for &(b, y) in &entries[..i] {
                    pairs.push([a, b].map(small));
                    products.push(x * y);
                }
            }
        }
        let (pattern, slots) = Pattern::new(n, &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        for (slot, product) in slots.into_iter().zip(products) {
            values[slot as usize] += product;
        }
        for (v, value) in diagonal.into_iter().enumerate() {
            values[pattern.diagonal(v)] = value;
        }
        (pattern, values)
    }

    /// Takes over the places of the wanted patches that have fewer flips than before.
    fn keep_better(
        &self,
        interior: Interior,
        found: &[Complex<f64>],
        wanted: &[bool],
        map: &mut FixedMap,
    ) {
        let mesh = &self.opened.mesh;
        let point = |v: VertexId| Point2::new(found[v.index()].re, found[v.index()].im);
        let mut flipped = vec![0; wanted.len()];
        let mut finite = wanted.to_vec();
        for f in mesh.faces() {
            let patch = self.opened.face_patches[f.index()] as usize;
            let [a, b, c] = mesh.face_vertices(f).map(point);
            let is_finite = [a, b, c].iter().all(|p| (p.x + p.y).is_finite());
            finite[patch] &= is_finite && self.usable[patch];
            flipped[patch] += usize::from(is_finite && orientation(a, b, c) <= 0.0);
        }
        for patch in 0..wanted.len() {
            let better = map.interiors[patch].is_none() || flipped[patch] < map.flipped[patch];
            finite[patch] &= better;
            if finite[patch] {
                map.interiors[patch] = Some(interior);
                map.flipped[patch] = flipped[patch];
            }
        }
        for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
            if finite[self.vertex_patches[v.index()] as usize] {
                map.uv[v.index()] = point(v);
            }
        }
    }
}
