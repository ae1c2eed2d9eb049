//! Angle based flattening, ABF++: the angles of a flat chart that are nearest to those of the surface, and the chart that has them.
//!
//! Unknown are the angles α of all corners. Those of the surface, with sums about interior vertices scaled to 2π, are the aim β.
//! **Minimises** ½ Σ (α − β)² / β² subject to what makes triangles fit together in the plane:
//!
//! * triangles: Σ α = π in each face,
//! * planarity: Σ α = 2π about each interior vertex,
//! * wheels: Σ ln sin α_next − ln sin α_prev = 0 about each interior vertex, so that going around it along shared sides one comes
//!   back with the same length.
//!
//! Each step solves the problem with constraints made linear, Λ d + Jᵀ λ = −Λ (α − β), J d = −C. Λ is diagonal, and a triangle's
//! condition meets only its own angles: both are eliminated face by face, which leaves one positive definite system in the two
//! multipliers of each interior vertex, coupled along mesh edges. The chart then follows from the angles by least squares: it is the LSCM chart of
//! the triangles that have them, exact where they fit.
//!
//! Guaranteed: a developable patch keeps its angles to rounding; angles stay between 0 and π; a defective patch costs no
//! other patch its chart. Not guaranteed: convergence where angles have to change very much ([`AbfAngles::residual`] says how well
//! angles fit); freedom from overlaps.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use super::disks::Disks;
use super::lscm::least_squares;
use super::{Flattening, small};
use crate::geometry::Geometry;
use crate::linalg::{Analysis, Factor, LinalgError, Pattern};
use crate::mesh::{FaceId, Mesh, OpenedMesh, VertexId};

/// Angles aimed at keep this distance from 0 and π (radians, 0.006°): smaller ones would weigh 1e8 times an ordinary one.
const NARROWEST: f64 = 1e-4;

/// In one step an angle goes at most so far of its way to 0 or to π. Steps are exact for linear constraints only; without this
/// bound the first one turns triangles over where the surface is strongly curved.
const BOLDNESS: f64 = 0.7;

/// An angle that has shrunk to less than its aim by this factor resists as if its aim were that much nearer. It changes the way, not the end:
/// with β² throughout, single angles beside a rim of strong curvature run into 0 (a cap that is nearly a whole sphere); with α² at once, every
/// chart takes more steps.
const STIFFENING: f64 = 3.0;

/// Constraints are kept to this many radians: rounding leaves 1e-13 on a hundred thousand faces.
const FITS: f64 = 1e-10;

/// Angles that change less than this (radians) stand still: no measure of distortion sees it.
const STILL: f64 = 1e-8;

/// Steps at most; 3 to 9 are usual. What is left then are single narrow angles that creep.
const STEPS: usize = 30;

/// Angles of a flat chart.
#[derive(Clone, Debug, PartialEq)]
pub struct AbfAngles {
    /// Angle at every corner of every face; of patches without chart, those of the surface.
    pub corner_angles: Vec<[f64; 3]>,
    /// Steps taken.
    pub steps: usize,
    /// Largest violation of a constraint that is left.
    pub residual: f64,
}

/// Angle based flattening of every patch that is a disk.
///
/// **Takes** an opened surface and its measures. **Gives** charts of the area of their patches, in frames of their own,
/// counter-clockwise; u estimated from areas; seam partners are not equally long.
/// **Fails** for lack of memory only; patches that cannot be flattened say so one by one.
/// **Costs** as [`abf_angles`] and [`lscm`](super::lscm::lscm) together.
/// **From** Sheffer et al.: *ABF++: Fast and Robust Angle Based Flattening*, 2005. **Differs**: wheels as sums of logarithms (Zayer, Lévy, Seidel 2007), whose
/// linear form stays good about vertices of many faces.
pub fn abf(opened: &OpenedMesh, geometry: &Geometry) -> Result<Flattening, LinalgError> {
    let (angles, disks) = solve(opened, geometry)?;
    let cotangents: Vec<[f64; 3]> = angles
        .corner_angles
        .iter()
        .map(|a| {
            // What is missing to π after the last step goes to all corners alike.
            let scale = PI / a.iter().sum::<f64>();
            a.map(|a| 1.0 / (a * scale).tan())
        })
        .collect();
    least_squares(disks, &cotangents, &vec![1.0; cotangents.len()])
}

/// The angles of [`abf`]. **Costs** one analysis and, for each step, one factorisation and one solve of two rows for each vertex.
pub fn abf_angles(opened: &OpenedMesh, geometry: &Geometry) -> Result<AbfAngles, LinalgError> {
    Ok(solve(opened, geometry)?.0)
}

fn solve<'a>(
    opened: &'a OpenedMesh,
    geometry: &'a Geometry,
) -> Result<(AbfAngles, Disks<'a>), LinalgError> {
    let mut disks = Disks::new(opened, geometry);
    loop {
        match Wheels::new(&disks).run() {
            Ok(angles) => return Ok((angles, disks)),
            Err(LinalgError::NotPositiveDefinite { row }) => {
                let v = VertexId::from(row % opened.mesh.vertex_count());
                if !disks.is_in(v) {
                    return Err(LinalgError::NotPositiveDefinite { row });
                }
                disks.give_up(disks.vertex_patches[v.index()]);
            }
            Err(error) => return Err(error),
        }
    }
}

/// The angles and what they must satisfy.
struct Wheels<'a> {
    mesh: &'a Mesh,
    faces: Vec<FaceId>,
    /// Whether a vertex has conditions of its own: rows `v` (planarity) and `V + v` (wheel).
    is_free: Vec<bool>,
    aims: Vec<[f64; 3]>,
    angles: Vec<[f64; 3]>,
}

/// A face in the constraints made linear. Local rows: planarity of the three corners, then their wheels.
struct Local {
    /// Rows that exist.
    rows: [Option<usize>; 6],
    /// The constraints' derivatives by the three angles.
    derivatives: [[f64; 3]; 6],
    /// How far each angle gives way to a force: Λ⁻¹.
    give: [f64; 3],
    /// What the energy alone would change: −Λ⁻¹ (α − β) / β².
    pull: [f64; 3],
    /// Σ α + pull − π.
    excess: f64,
}

impl Local {
    /// Derivatives times Λ⁻¹ 1.
    fn slopes(&self) -> [f64; 6] {
        self.derivatives.map(|d| (0..3).map(|k| d[k] * self.give[k]).sum())
    }

    fn total(&self) -> f64 {
        self.give.iter().sum()
    }
}

impl<'a> Wheels<'a> {
    fn new(disks: &Disks<'a>) -> Self {
        let mesh = &disks.opened.mesh;
        let is_free: Vec<bool> =
            mesh.vertices().map(|v| disks.is_in(v) && !mesh.is_boundary_vertex(v)).collect();
        let faces: Vec<FaceId> = mesh.faces().filter(|&f| disks.has_face(f)).collect();
        let mut sums = vec![0.0; mesh.vertex_count()];
        let given = &disks.geometry.corner_angles;
        for &f in &faces {
            for (v, angle) in mesh.face_vertices(f).into_iter().zip(given[f.index()]) {
                sums[v.index()] += angle;
            }
        }
        let mut aims = given.clone();
        for &f in &faces {
            for (v, aim) in mesh.face_vertices(f).into_iter().zip(&mut aims[f.index()]) {
                if is_free[v.index()] {
                    *aim *= TAU / sums[v.index()];
                }
                *aim = aim.clamp(NARROWEST, PI - NARROWEST);
            }
        }
        Self { mesh, faces, is_free, angles: aims.clone(), aims }
    }

    fn run(mut self) -> Result<AbfAngles, LinalgError> {
        let (pattern, slots) = self.pattern();
        let analysis = Arc::new(Analysis::new(pattern)?);
        let mut factor: Option<Factor> = None;
        let (mut steps, mut residual) = (0, self.residual());
        while steps < STEPS {
            let (values, mut multipliers) = self.system(analysis.pattern(), &slots);
            let factor = match &mut factor {
                Some(factor) => {
                    factor.refactor(&values)?;
                    factor
                }
                none => none.insert(Factor::new(analysis.clone(), &values)?),
            };
            factor.solve(&mut multipliers, 1);
            let change = self.advance(&multipliers);
            steps += 1;
            residual = self.residual();
            if residual < FITS && change < STILL {
                break;
            }
        }
        Ok(AbfAngles { corner_angles: self.angles, steps, residual })
    }

    fn local(&self, f: FaceId) -> Local {
        let n = self.mesh.vertex_count();
        let corners = self.mesh.face_vertices(f).map(|v| v.index());
        let mut rows = [None; 6];
        let mut derivatives = [[0.0; 3]; 6];
        for k in 0..3 {
            if self.is_free[corners[k]] {
                rows[k] = Some(corners[k]);
                rows[3 + k] = Some(n + corners[k]);
            }
            let cotangent = 1.0 / self.angles[f.index()][k].tan();
            derivatives[k][k] = 1.0;
            derivatives[3 + (k + 2) % 3][k] = cotangent;
            derivatives[3 + (k + 1) % 3][k] = -cotangent;
        }
        let (angles, aims) = (self.angles[f.index()], self.aims[f.index()]);
        let give = [0, 1, 2].map(|k| aims[k].min(STIFFENING * angles[k]).powi(2));
        let pull = [0, 1, 2].map(|k| give[k] * (aims[k] - angles[k]) / (aims[k] * aims[k]));
        let excess = (0..3).map(|k| angles[k] + pull[k]).sum::<f64>() - PI;
        Local { rows, derivatives, give, pull, excess }
    }

    /// Pairs of local rows that exist, in the order in which [`Self::system`] meets them.
    fn pattern(&self) -> (Pattern, Vec<u32>) {
        let mut pairs = Vec::new();
        for &f in &self.faces {
            let rows = self.local(f).rows;
            for i in 0..6 {
                for j in 0..i {
                    if let (Some(a), Some(b)) = (rows[i], rows[j]) {
                        pairs.push([a, b].map(small));
                    }
                }
            }
        }
        Pattern::new(2 * self.mesh.vertex_count(), &pairs)
    }

    /// The system of the multipliers of vertices.
    fn system(&self, pattern: &Pattern, slots: &[u32]) -> (Vec<f64>, Vec<f64>) {
        let n = self.mesh.vertex_count();
        let mut values = vec![0.0; pattern.entry_count()];
        let mut rhs = vec![0.0; 2 * n];
        for v in 0..n {
            if self.is_free[v] {
                rhs[v] = -TAU;
            } else {
                values[pattern.diagonal(v)] = 1.0;
                values[pattern.diagonal(n + v)] = 1.0;
            }
        }
        let mut slots = slots.iter();
        for &f in &self.faces {
            let local = self.local(f);
            let (slopes, total) = (local.slopes(), local.total());
            let constraints = self.constraints(f);
            for i in 0..6 {
                let Some(row) = local.rows[i] else { continue };
                let d = local.derivatives[i];
                let entry = |j: usize| {
                    let e = local.derivatives[j];
                    let whole: f64 = (0..3).map(|k| d[k] * local.give[k] * e[k]).sum();
                    whole - slopes[i] * slopes[j] / total
                };
                values[pattern.diagonal(row)] += entry(i);
                for j in 0..i {
                    if local.rows[j].is_some()
                        && let Some(&slot) = slots.next()
                    {
                        values[slot as usize] += entry(j);
                    }
                }
                let pulled: f64 = (0..3).map(|k| d[k] * local.pull[k]).sum();
                rhs[row] += constraints[i] + pulled - slopes[i] * local.excess / total;
            }
        }
        (values, rhs)
    }

    /// A face's part in the conditions of its corners: angles, then differences of logarithms.
    fn constraints(&self, f: FaceId) -> [f64; 6] {
        let a = self.angles[f.index()];
        let log = a.map(|a| a.sin().ln());
        let wheel = |k: usize| log[(k + 1) % 3] - log[(k + 2) % 3];
        [a[0], a[1], a[2], wheel(0), wheel(1), wheel(2)]
    }

    /// Moves the angles to where the multipliers want them, as far as is bold. **Gives** the largest change.
    fn advance(&mut self, multipliers: &[f64]) -> f64 {
        let mut change = 0.0f64;
        for index in 0..self.faces.len() {
            let f = self.faces[index];
            let local = self.local(f);
            let at = |i: usize| local.rows[i].map_or(0.0, |row| multipliers[row]);
            let coupled: f64 = local.slopes().iter().enumerate().map(|(i, s)| s * at(i)).sum();
            let own = (local.excess - coupled) / local.total();
            for k in 0..3 {
                let force: f64 = (0..6).map(|i| local.derivatives[i][k] * at(i)).sum::<f64>() + own;
                let angle = &mut self.angles[f.index()][k];
                let wanted = *angle + local.pull[k] - local.give[k] * force;
                let low = *angle * (1.0 - BOLDNESS);
                let high = PI - (PI - *angle) * (1.0 - BOLDNESS);
                // Not a number only if the angle's own row overflowed: then it stays.
                let next = if wanted.is_finite() { wanted.clamp(low, high) } else { *angle };
                change = change.max((next - *angle).abs());
                *angle = next;
            }
        }
        change
    }

    /// Largest violation of a constraint.
    fn residual(&self) -> f64 {
        let n = self.mesh.vertex_count();
        let mut sums = vec![0.0; 2 * n];
        let mut worst = 0.0f64;
        for &f in &self.faces {
            let parts = self.constraints(f);
            worst = worst.max((parts[0] + parts[1] + parts[2] - PI).abs());
            for (k, v) in self.mesh.face_vertices(f).into_iter().enumerate() {
                sums[v.index()] += parts[k];
                sums[n + v.index()] += parts[3 + k];
            }
        }
        for v in (0..n).filter(|&v| self.is_free[v]) {
            worst = worst.max((sums[v] - TAU).abs()).max(sums[n + v].abs());
        }
        worst
    }
}
