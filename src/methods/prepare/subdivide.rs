//! Finer triangles on the same surface.
//!
//! New vertices lie in the middle of edges and nothing is smoothed, so that the surface as a point set, its metric, and the angle
//! defects of the old vertices stay; new vertices are flat. What gets finer is the space of functions on the vertices.
//!
//! A bound on the curvature *per face* cannot be met that way: a defect stays where it is and is shared among the faces around
//! its vertex, whose number hardly changes. What can be met is a bound on the side of a face against the radius of curvature,
//! h² K, with K from the given surface, as if that were a sample of a smooth one.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::Point3;

use super::coarseness::{TOO_COARSE, vertex_curvatures};
use super::triangles::Triangles;
use super::{Attributes, NONE, Prepared, Surface, check};
use crate::geometry::Geometry;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Which triangles are split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SubdivideRule {
    /// All of them, one into four, so many times.
    Midpoint {
        /// Number of times.
        rounds: u32,
    },
    /// Those with longest side · √|K| above a tolerance, each halved at its longest side, and neighbours as needed.
    Curvature {
        /// Largest h √|K|: about the angle in radians that an edge may span.
        tolerance: f64,
    },
}

/// Options of [`SubdivideFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SubdivideParams {
    /// Which triangles are split.
    pub rule: SubdivideRule,
    /// No more faces than this are made; a round that would make more is not begun. Two million is about what a browser tab
    /// can hold together with the solvers.
    pub max_faces: usize,
}

impl Default for SubdivideParams {
    fn default() -> Self {
        // Half of what is too coarse: an error of less than 1 %.
        let rule = SubdivideRule::Curvature { tolerance: 0.5 * TOO_COARSE };
        Self { rule, max_faces: 2_000_000 }
    }
}

impl SubdivideParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        match self.rule {
            SubdivideRule::Midpoint { rounds } => check("rounds", f64::from(rounds), 1.0, 10.0)?,
            SubdivideRule::Curvature { tolerance } => check("tolerance", tolerance, 1e-3, 10.0)?,
        }
        check("largest number of faces", self.max_faces as f64, 1.0, 1e8)
    }
}

/// Splits triangles.
///
/// **Step** one round of 1 → 4, or halvings that add up to an eighth of the faces, at least 4096, worst first.
/// **Ends** `Converged` when the rule is met, `StepLimit` at the largest number of faces.
/// **Takes** any surface. **Gives** old vertices first, all of them; area and texture area unchanged to rounding; no vertex inside
/// an edge; by curvature, no angle below half the smallest one given.
/// **Fails** on coordinates that are not finite. **Costs** O(F) a round; O(log F) a halving on ordinary meshes.
/// **From** Rivara 1984 (longest-edge bisection), [VSC] §6.1. **Differs**: the bound is on h √|K|, see the module.
pub struct SubdivideFlow {
    params: SubdivideParams,
    triangles: Triangles,
    attributes: Attributes,
    /// |K| at the vertices, linear along edges that were split; empty for the midpoint rule.
    curvatures: Vec<f64>,
    /// Faces by h² K, with the vertices by which to tell that they have changed since.
    queue: BinaryHeap<(u64, Reverse<u32>, [u32; 3])>,
    rounds: u32,
    steps: usize,
    status: Status,
    state: Prepared,
}

impl SubdivideFlow {
    /// Measures the curvature.
    pub fn new(surface: Surface, params: &SubdivideParams) -> Result<Self, SolveError> {
        params.validate()?;
        surface.check_finite()?;
        let triangles = Triangles::new(&surface);
        let state = export(&triangles, &surface.attributes)?;
        let mut flow = Self {
            params: *params,
            triangles,
            curvatures: Vec::new(),
            queue: BinaryHeap::new(),
            rounds: 0,
            steps: 0,
            status: Status::Running,
            state,
            attributes: surface.attributes,
        };
        if matches!(params.rule, SubdivideRule::Curvature { .. }) {
            let geometry = Geometry::measure(&surface.mesh, surface.positions);
            flow.curvatures = vertex_curvatures(&surface.mesh, &geometry);
            for f in 0..flow.triangles.faces.len() as u32 {
                flow.enqueue(f);
            }
        }
        Ok(flow)
    }

    fn step_midpoint(&mut self, rounds: u32) {
        let triangles = &mut self.triangles;
        if self.params.max_faces / 4 < triangles.face_count {
            self.status = Status::StepLimit;
            return;
        }
        quarter(triangles);
        self.rounds += 1;
        if self.rounds >= rounds {
            self.status = Status::Converged;
        }
    }

    fn step_curvature(&mut self, tolerance: f64) {
        let goal = self.triangles.face_count + (self.triangles.face_count / 8).max(4096);
        while self.triangles.face_count < goal {
            let Some((bits, Reverse(f), vertices)) = self.queue.pop() else {
                self.status = Status::Converged;
                return;
            };
            if self.triangles.faces[f as usize] != vertices {
                continue;
            }
            if !(f64::from_bits(bits) > tolerance * tolerance) {
                self.status = Status::Converged;
                return;
            }
            if self.triangles.face_count + 2 > self.params.max_faces {
                self.status = Status::StepLimit;
                return;
            }
            self.halve(f);
        }
    }

    /// Halves the longest edge that the way from a face over ever longer neighbours leads to.
    fn halve(&mut self, start: u32) {
        let mut f = start;
        let [a, b] = loop {
            let [a, b] = longest(&self.triangles, f);
            let across =
                self.triangles.edge_faces(a, b).as_slice().iter().copied().find(|&g| g != f);
            match across {
                Some(g) if longest(&self.triangles, g) != [a, b] => f = g,
                _ => break [a, b],
            }
        };
        let place = middle(&self.triangles, a, b);
        if [a, b].iter().any(|&v| self.triangles.positions[v as usize] == place) {
            // The edge is as short as numbers get: `start` is given up.
            return;
        }
        let m = self.triangles.split(a, b, place);
        let curvature = [a, b].map(|v| 0.5 * self.curvatures[v as usize]).iter().sum();
        self.curvatures.push(curvature);
        for i in 0..self.triangles.fans[m as usize].len() {
            self.enqueue(self.triangles.fans[m as usize][i]);
        }
        // If another edge was halved, the face that asked for it is still there.
        if self.triangles.faces[start as usize].iter().all(|&v| v != m) {
            self.enqueue(start);
        }
    }

    fn enqueue(&mut self, f: u32) {
        let vertices = self.triangles.faces[f as usize];
        let [a, b] = longest(&self.triangles, f);
        let curvature =
            vertices.map(|v| self.curvatures[v as usize]).into_iter().fold(0.0, f64::max);
        let value = squared(&self.triangles, a, b) * curvature;
        if value > 0.0 && value.is_finite() {
            // Bits of numbers above zero sort like the numbers.
            self.queue.push((value.to_bits(), Reverse(f), vertices));
        }
    }

    fn progress(&self) -> Option<f32> {
        if self.status != Status::Running {
            return Some(1.0);
        }
        match self.params.rule {
            SubdivideRule::Midpoint { rounds } => Some(self.rounds as f32 / rounds as f32),
            SubdivideRule::Curvature { .. } => None,
        }
    }
}

impl Flow for SubdivideFlow {
    type State = Prepared;

    fn state(&self) -> &Prepared {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status == Status::Running {
            let before = self.triangles.face_count;
            match self.params.rule {
                SubdivideRule::Midpoint { rounds } => self.step_midpoint(rounds),
                SubdivideRule::Curvature { tolerance } => self.step_curvature(tolerance),
            }
            if self.triangles.face_count > before {
                self.state = export(&self.triangles, &self.attributes)?;
                self.steps += 1;
            }
        }
        let worst = self.queue.peek().map_or(0.0, |top| f64::from_bits(top.0).sqrt());
        Ok(StepReport {
            step: self.steps,
            energy: vec![("coarseness", worst), ("faces", self.triangles.face_count as f64)],
            residual: 0.0,
            progress: self.progress(),
            status: self.status,
        })
    }
}

fn export(triangles: &Triangles, attributes: &Attributes) -> Result<Prepared, SolveError> {
    let uvs = |f: u32| triangles.uvs.get(f as usize).copied().unwrap_or_default();
    Ok(triangles.export(attributes, |f| triangles.tags[f as usize], uvs)?)
}

fn squared(triangles: &Triangles, a: u32, b: u32) -> f64 {
    (triangles.positions[a as usize] - triangles.positions[b as usize]).norm_squared()
}

fn middle(triangles: &Triangles, a: u32, b: u32) -> Point3<f64> {
    let [a, b] = [a, b].map(|v| triangles.positions[v as usize].coords);
    Point3::from(a * 0.5 + b * 0.5)
}

/// The longest side of a face, the smaller vertex first; among equal ones the one of the smallest vertices, so that all faces agree
/// on the order and the way over neighbours ends.
fn longest(triangles: &Triangles, f: u32) -> [u32; 2] {
    let face = triangles.faces[f as usize];
    let side = |i: usize| {
        let (a, b) = (face[i], face[(i + 1) % 3]);
        let ends = [a.min(b), a.max(b)];
        (squared(triangles, ends[0], ends[1]), Reverse(ends))
    };
    let mut best = side(0);
    for i in 1..3 {
        let other = side(i);
        if other.0.total_cmp(&best.0).then(other.1.cmp(&best.1)).is_gt() {
            best = other;
        }
    }
    best.1.0
}

/// One triangle into four.
fn quarter(triangles: &mut Triangles) {
    // Splitting every edge of the old mesh once leaves three cuts in each old face; which faces they make depends on the order, so
    // the four are written down afresh from the midpoints.
    let old = triangles.faces.clone();
    let edges = triangles.edges();
    let first = triangles.positions.len() as u32;
    for &[a, b] in &edges {
        let place = middle(triangles, a, b);
        triangles.positions.push(place);
        triangles.is_old.push(false);
    }
    let uvs = std::mem::take(&mut triangles.uvs);
    let tags = std::mem::take(&mut triangles.tags);
    triangles.faces.clear();
    triangles.fans = vec![Vec::with_capacity(6); triangles.positions.len()];
    for (f, face) in old.iter().enumerate() {
        let m = [0, 1, 2].map(|i| {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            let index = edges.partition_point(|e| *e < [a.min(b), a.max(b)]);
            first + index as u32
        });
        let parts = [[face[0], m[0], m[2]], [m[0], face[1], m[1]], [m[2], m[1], face[2]], m];
        for part in parts {
            for v in part {
                triangles.fans[v as usize].push(triangles.faces.len() as u32);
            }
            triangles.faces.push(part);
            triangles.tags.push(tags[f]);
        }
        if let Some(&uv) = uvs.get(f) {
            let m = [0, 1, 2].map(|i| super::triangles::midway(uv[i], uv[(i + 1) % 3]));
            triangles.uvs.extend([
                [uv[0], m[0], m[2]],
                [m[0], uv[1], m[1]],
                [m[2], m[1], uv[2]],
                m,
            ]);
        }
    }
    triangles.face_count = triangles.faces.len();
    triangles.marks = vec![[NONE; 3]; triangles.faces.len()];
}
