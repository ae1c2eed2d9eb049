//! The Laplacian of one patch, with its Dirichlet and Neumann problems.

use std::sync::Arc;

use nalgebra::Point2;

use super::super::overlap::orientation;
use super::super::{NoChart, small};
use super::{Effort, TargetError};
use crate::geometry::{Geometry, angle_defects};
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};
use crate::mesh::{FaceId, HalfedgeId, OpenedMesh, VertexId};

/// A with names of its own for the vertices of the patch.
pub(super) struct System {
    /// Ascending.
    pub vertices: Vec<VertexId>,
    pub rim: Vec<HalfedgeId>,
    pub effort: Effort,
    /// Names of the rim vertices.
    rim_names: Vec<u32>,
    is_rim: Vec<bool>,
    faces: Vec<(FaceId, [u32; 3])>,
    edges: Vec<[u32; 2]>,
    weights: Vec<f64>,
    /// Ω inside, k on the rim.
    curvatures: Vec<f64>,
    rim_lengths: Vec<f64>,
    dual_areas: Vec<f64>,
    inner: Option<Factor>,
    whole: Option<Factor>,
}

/// Least weights of edges where harmonic coordinates turn faces over, tried in turn: those of opposite angles of 89°, 87° and 74°. Smaller ones change less, larger ones leave less to
/// rounding.
const RAISED: [f64; 3] = [0.01, 0.05, 0.289];

/// Whether an outline goes around once and never turns to the right. Rounding may bend straight sides.
fn is_convex(outline: &[Point2<f64>]) -> bool {
    const STRAIGHT: f64 = 1e-9;
    let n = outline.len();
    let turn = |i: usize| {
        let [a, b, c] = [i, (i + 1) % n, (i + 2) % n].map(|i| outline[i]);
        (b - a).perp(&(c - b)).atan2((b - a).dot(&(c - b)))
    };
    let turns: Vec<f64> = (0..n).map(turn).collect();
    let once = (turns.iter().sum::<f64>() - std::f64::consts::TAU).abs() < 1e-3;
    once && turns.iter().all(|turn| *turn > -STRAIGHT)
}

impl System {
    pub fn new(
        opened: &OpenedMesh,
        geometry: &Geometry,
        patch: usize,
        rim: Vec<HalfedgeId>,
    ) -> Result<Self, TargetError> {
        let mesh = &opened.mesh;
        let is_here = |f: &FaceId| opened.face_patches[f.index()] as usize == patch;
        let mut names = vec![u32::MAX; mesh.vertex_count()];
        let mut edge_names = vec![usize::MAX; mesh.edge_count()];
        for v in mesh.faces().filter(is_here).flat_map(|f| mesh.face_vertices(f)) {
            names[v.index()] = 0;
        }
        let vertices: Vec<VertexId> =
            mesh.vertices().filter(|v| names[v.index()] != u32::MAX).collect();
        for (i, v) in vertices.iter().enumerate() {
            names[v.index()] = small(i);
        }
        let name = |v: VertexId| names[v.index()];
        let (mut edges, mut weights) = (Vec::new(), Vec::new());
        let mut faces = Vec::new();
        let mut dual_areas = vec![0.0; vertices.len()];
        for f in mesh.faces().filter(is_here) {
            let cotangents = geometry.corner_cotangents[f.index()];
            let corners = mesh.face_vertices(f).map(name);
            for (i, h) in mesh.face_halfedges(f).into_iter().enumerate() {
                let usable = cotangents[i].is_finite() && geometry.edge_length(h.edge()) > 0.0;
                if !usable {
                    return Err(NoChart::Degenerate { face: f }.into());
                }
                let slot = &mut edge_names[h.edge().index()];
                if *slot == usize::MAX {
                    *slot = edges.len();
                    edges.push(mesh.edge_vertices(h.edge()).map(name));
                    weights.push(0.0);
                }
                weights[*slot] += 0.5 * cotangents[(i + 2) % 3];
                dual_areas[corners[i] as usize] += geometry.face_areas[f.index()] / 3.0;
            }
            faces.push((f, corners));
        }
        let defects = angle_defects(mesh, geometry);
        let rim_names: Vec<u32> = rim.iter().map(|&h| name(mesh.tail(h))).collect();
        let mut is_rim = vec![false; vertices.len()];
        rim_names.iter().for_each(|&v| is_rim[v as usize] = true);
        Ok(Self {
            rim_lengths: rim.iter().map(|h| geometry.edge_length(h.edge())).collect(),
            curvatures: vertices.iter().map(|v| defects[v.index()]).collect(),
            vertices,
            rim,
            effort: Effort::default(),
            rim_names,
            is_rim,
            faces,
            edges,
            weights,
            dual_areas,
            inner: None,
            whole: None,
        })
    }

    pub fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.vertices.len()]
    }

    /// The faces and their corners' names.
    pub fn triangles(&self) -> impl Iterator<Item = (FaceId, [u32; 3])> + '_ {
        self.faces.iter().copied()
    }

    /// Lengths of the rim's sides, scaled.
    pub fn scaled_lengths(&self, u: &[f64]) -> Vec<f64> {
        let n = self.rim.len();
        let at = |i: usize| u[self.rim_names[i % n] as usize];
        (0..n).map(|i| self.rim_lengths[i] * (0.5 * (at(i) + at(i + 1))).exp()).collect()
    }

    /// Scale factors at rim vertices from lengths of sides: the mean of the log ratios of the two sides, the shorter one counting less.
    pub fn scales_of(&self, lengths: &[f64]) -> Vec<f64> {
        let n = lengths.len();
        let ratio = |i: usize| (lengths[i] / self.rim_lengths[i]).ln();
        (0..n)
            .map(|i| {
                let sides = [(i + n - 1) % n, i];
                let total: f64 = sides.iter().map(|&s| self.rim_lengths[s]).sum();
                sides.iter().map(|&s| self.rim_lengths[s] * ratio(s)).sum::<f64>() / total
            })
            .collect()
    }

    /// Takes the mean over the area from scale factors.
    pub fn centre(&self, u: &mut [f64]) {
        let sum: f64 = u.iter().zip(&self.dual_areas).map(|(u, m)| u * m).sum();
        let mean = sum / self.dual_areas.iter().sum::<f64>();
        u.iter_mut().for_each(|u| *u -= mean);
    }

    /// Scale factors everywhere and exterior angles, from scale factors on the rim.
    pub fn angles_of(&mut self, rim_u: &[f64]) -> Result<(Vec<f64>, Vec<f64>), TargetError> {
        let mut u = self.zeros();
        for (&v, &value) in self.rim_names.iter().zip(rim_u) {
            u[v as usize] = value;
        }
        let sources: Vec<f64> = self.curvatures.iter().map(|c| -c).collect();
        self.extend(&mut u, &sources)?;
        let flux = self.multiply(&u);
        let angle = |&v: &u32| self.curvatures[v as usize] + flux[v as usize];
        let angles = self.rim_names.iter().map(angle).collect();
        Ok((u, angles))
    }

    /// Scale factors from exterior angles, up to a constant.
    pub fn scales_for(&mut self, angles: &[f64]) -> Result<Vec<f64>, TargetError> {
        let mut sources: Vec<f64> = self.curvatures.iter().map(|c| -c).collect();
        for (&v, angle) in self.rim_names.iter().zip(angles) {
            sources[v as usize] += angle;
        }
        self.release(&mut sources)?;
        Ok(sources)
    }

    /// Harmonic coordinates inside a rim. Where they turn faces over inside a convex one, edges of small or negative weight get more of it: with
    /// positive weights every vertex lies among its neighbours, and nothing is turned over (Tutte, Floater).
    ///
    /// **Gives** the places, and whether weights were raised.
    pub fn fill(&mut self, rim: &[Point2<f64>]) -> Result<(Vec<Point2<f64>>, bool), TargetError> {
        let mut places = self.fill_harmonic(rim)?;
        let mut turned = self.turned_over(&places);
        let mut is_raised = false;
        for least in RAISED {
            if turned == 0 || !is_convex(rim) {
                break;
            }
            let raised = self.weights.iter().map(|w| w.max(least)).collect();
            let weights = std::mem::replace(&mut self.weights, raised);
            let own = self.inner.take();
            let found = self.fill_harmonic(rim);
            self.weights = weights;
            self.inner = own;
            // What was found before is still a chart.
            let Ok(found) = found else { break };
            let count = self.turned_over(&found);
            if count >= turned {
                break;
            }
            (places, turned, is_raised) = (found, count, true);
        }
        Ok((places, is_raised))
    }

    /// Number of faces that are turned over or flat, those with all corners on the rim apart.
    fn turned_over(&self, places: &[Point2<f64>]) -> usize {
        let is_inside = |t: &[u32; 3]| !t.iter().all(|&v| self.is_rim[v as usize]);
        let is_over = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| places[v as usize]);
            !(orientation(a, b, c) > 0.0)
        };
        self.faces.iter().filter(|(_, t)| is_inside(t) && is_over(t)).count()
    }

    fn fill_harmonic(&mut self, rim: &[Point2<f64>]) -> Result<Vec<Point2<f64>>, TargetError> {
        let none = self.zeros();
        let [x, y] = [0, 1].map(|axis| self.on_rim(rim, axis));
        let (mut x, mut y) = (x, y);
        self.extend(&mut x, &none)?;
        self.extend(&mut y, &none)?;
        Ok(x.into_iter().zip(y).map(|(x, y)| Point2::new(x, y)).collect())
    }

    /// A harmonic coordinate x inside a rim, and y with ∂y/∂n = −∂x/∂t along it.
    pub fn fill_conjugate(&mut self, rim: &[Point2<f64>]) -> Result<Vec<Point2<f64>>, TargetError> {
        let none = self.zeros();
        let mut x = self.on_rim(rim, 0);
        self.extend(&mut x, &none)?;
        let mut y = self.zeros();
        let n = rim.len();
        for (i, &v) in self.rim_names.iter().enumerate() {
            y[v as usize] = -0.5 * (rim[(i + 1) % n].x - rim[(i + n - 1) % n].x);
        }
        self.release(&mut y)?;
        Ok(x.into_iter().zip(y).map(|(x, y)| Point2::new(x, y)).collect())
    }

    fn on_rim(&self, rim: &[Point2<f64>], axis: usize) -> Vec<f64> {
        let mut values = self.zeros();
        for (&v, p) in self.rim_names.iter().zip(rim) {
            values[v as usize] = p[axis];
        }
        values
    }

    /// A x.
    fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = self.zeros();
        for (&[a, b], weight) in self.edges.iter().zip(&self.weights) {
            let flux = weight * (x[a as usize] - x[b as usize]);
            y[a as usize] += flux;
            y[b as usize] -= flux;
        }
        y
    }

    /// Solves A_II x_I = f_I − A_IB x_B: the Dirichlet problem.
    fn extend(&mut self, x: &mut [f64], sources: &[f64]) -> Result<(), TargetError> {
        let mut rhs = sources.to_vec();
        for (&[a, b], weight) in self.edges.iter().zip(&self.weights) {
            for (v, w) in [(a, b), (b, a)] {
                if !self.is_rim[v as usize] && self.is_rim[w as usize] {
                    rhs[v as usize] += weight * x[w as usize];
                }
            }
        }
        if self.inner.is_none() {
            self.inner = Some(self.factor(|v| self.is_rim[v as usize])?);
            self.effort.factorisations += 1;
        }
        if let Some(factor) = &mut self.inner {
            factor.solve(&mut rhs, 1);
            self.effort.solves += 1;
        }
        for (i, value) in rhs.into_iter().enumerate().filter(|(i, _)| !self.is_rim[*i]) {
            x[i] = value;
        }
        Ok(())
    }

    /// Solves A x = f with Σf = 0 in place, x = 0 at the first rim vertex: the Neumann problem.
    fn release(&mut self, f: &mut [f64]) -> Result<(), TargetError> {
        let pin = self.rim_names[0];
        if self.whole.is_none() {
            self.whole = Some(self.factor(|v| v == pin)?);
            self.effort.factorisations += 1;
        }
        f[pin as usize] = 0.0;
        if let Some(factor) = &mut self.whole {
            factor.solve(f, 1);
            self.effort.solves += 1;
        }
        Ok(())
    }

    /// A without the rows and columns of some vertices, which stand alone.
    fn factor(&self, is_out: impl Fn(u32) -> bool) -> Result<Factor, TargetError> {
        let is_pair = |[a, b]: &[u32; 2]| !is_out(*a) && !is_out(*b);
        let pairs: Vec<[u32; 2]> = self.edges.iter().copied().filter(is_pair).collect();
        let (pattern, slots) = Pattern::new(self.vertices.len(), &pairs);
        let mut values = vec![0.0; pattern.entry_count()];
        let mut slot = slots.into_iter();
        for (edge, weight) in self.edges.iter().zip(&self.weights) {
            if is_pair(edge)
                && let Some(slot) = slot.next()
            {
                values[slot as usize] -= weight;
            }
            for &v in edge.iter().filter(|&&v| !is_out(v)) {
                values[pattern.diagonal(v as usize)] += weight;
            }
        }
        for v in (0..self.vertices.len()).filter(|&v| is_out(small(v))) {
            values[pattern.diagonal(v)] = 1.0;
        }
        let analysis = Arc::new(Analysis::new(pattern)?);
        Factor::new(analysis, &values).map_err(|error| match error {
            LinalgError::NotPositiveDefinite { row } => {
                NoChart::Singular { vertex: self.vertices[row] }.into()
            }
            error => error.into(),
        })
    }
}
