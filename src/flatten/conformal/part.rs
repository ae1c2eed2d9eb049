//! One connected surface: from a mesh to a solver and back.

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

use std::f64::consts::TAU;

use super::develop::{Developed, rewind};
use super::solver::{Progress, Solver};
use super::targets::Condition;
use super::triangulation::{NONE, Triangulation};
use crate::flatten::NoChart;
use crate::geometry::FLAT;
use crate::linalg::LinalgError;
use crate::mesh::{EdgeId, FaceId, Mesh, VertexId};

/// When a solver stops.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    pub tolerance: f64,
    pub most_steps: usize,
}

/// A component of the surface that is solved on, with its own numbering.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub faces: Vec<FaceId>,
    /// The mesh vertex of each of its own.
    pub vertices: Vec<VertexId>,
    /// The mesh edge of each of its own.
    edges: Vec<EdgeId>,
    /// Its halfedge for each side of each of its faces.
    sides: Vec<[u32; 3]>,
    /// Connectivity and lengths as given.
    given: Triangulation,
    limits: Limits,
    /// `Err` if there is nothing to solve.
    pub solver: Result<Solver, NoChart>,
    pub is_doubled: bool,
    /// Whether no scale factor is given: the size is free.
    pub is_floating: bool,
}

/// The components of a mesh, by their first face.
pub(super) fn components(mesh: &Mesh) -> Vec<Vec<FaceId>> {
    let topology = mesh.topology();
    let mut parts = vec![Vec::new(); topology.components];
    for (f, &c) in topology.face_components.iter().enumerate() {
        parts[c as usize].push(FaceId::from(f));
    }
    parts
}

/// Vertices of a component with whether they lie on its boundary, and 2πχ.
pub(super) fn shape_of(mesh: &Mesh, faces: &[FaceId]) -> (Vec<(VertexId, bool)>, f64) {
    let mut vertices: Vec<VertexId> = faces.iter().flat_map(|&f| mesh.face_vertices(f)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let boundary = faces
        .iter()
        .flat_map(|&f| mesh.face_halfedges(f))
        .filter(|h| mesh.is_boundary_edge(h.edge()))
        .count();
    let edges = (3 * faces.len() + boundary) / 2;
    let euler = vertices.len() as f64 - edges as f64 + faces.len() as f64;
    let rims = vertices.into_iter().map(|v| (v, mesh.is_boundary_vertex(v))).collect();
    (rims, TAU * euler)
}

impl Part {
    /// **Takes** lengths of all mesh edges as given, what is asked for at all mesh vertices, and log scale factors to begin with.
    /// `mollified` is added to every length. With a reason why not, nothing is solved.
    #[expect(clippy::too_many_arguments, reason = "called in one place")]
    pub fn new(
        mesh: &Mesh,
        faces: Vec<FaceId>,
        lengths: &[f64],
        mollified: f64,
        conditions: &[Condition],
        start: &[f64],
        limits: Limits,
        no_chart: Option<NoChart>,
    ) -> Self {
        let mut vertices: Vec<VertexId> =
            faces.iter().flat_map(|&f| mesh.face_vertices(f)).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut edges: Vec<EdgeId> =
            faces.iter().flat_map(|&f| mesh.face_halfedges(f)).map(|h| h.edge()).collect();
        edges.sort_unstable();
        edges.dedup();
        let own_vertex = |v: VertexId| vertices.binary_search(&v).unwrap_or(0) as u32;
        let mut given = Triangulation {
            next: vec![NONE; 2 * edges.len()],
            tail: vec![NONE; 2 * edges.len()],
            face: vec![NONE; 2 * edges.len()],
            face_halfedge: Vec::with_capacity(faces.len()),
            ..Triangulation::default()
        };
        for (e, &edge) in edges.iter().enumerate() {
            let ends = mesh.edge_vertices(edge);
            for s in 0..2 {
                given.tail[2 * e + s] = own_vertex(ends[s]);
            }
            given.x.push((lengths[edge.index()] + mollified).ln());
        }
        let mut sides = Vec::with_capacity(faces.len());
        for (f, &face) in faces.iter().enumerate() {
            let own = mesh
                .face_halfedges(face)
                .map(|h| 2 * edges.binary_search(&h.edge()).unwrap_or(0) as u32 + (h.0 & 1));
            for i in 0..3 {
                given.next[own[i] as usize] = own[(i + 1) % 3];
                given.face[own[i] as usize] = f as u32;
            }
            given.face_halfedge.push(own[0]);
            sides.push(own);
        }
        let mut part = Self {
            faces,
            vertices,
            edges,
            sides,
            given,
            limits,
            solver: Err(NoChart::Degenerate { face: FaceId(0) }),
            is_doubled: false,
            is_floating: false,
        };
        let asked: Vec<Condition> = part.vertices.iter().map(|v| conditions[v.index()]).collect();
        part.is_floating = asked.iter().all(|c| matches!(c, Condition::Angle(_)));
        let unusable =
            || part.unusable_face(mesh, lengths).map(|face| NoChart::Degenerate { face });
        part.solver = match no_chart.or_else(unusable) {
            Some(reason) => Err(reason),
            None => {
                let start: Vec<f64> = part.vertices.iter().map(|v| start[v.index()]).collect();
                Ok(part.solver_on(part.given.clone(), &asked, &start))
            }
        };
        part
    }

    /// A face to blame if the part has no metric: a length that is none, or no face with an area.
    fn unusable_face(&self, mesh: &Mesh, lengths: &[f64]) -> Option<FaceId> {
        let mut has_area = false;
        for &face in &self.faces {
            let mut sides = mesh.face_halfedges(face).map(|h| lengths[h.edge().index()]);
            if !sides.iter().all(|l| l.is_finite() && *l < 1e100) {
                return Some(face);
            }
            sides.sort_unstable_by(|a, b| b.total_cmp(a));
            let [a, b, c] = sides;
            // Sixteen times the squared area, by Kahan; the height over the longest side is √ of it over 2 a.
            let squared = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
            has_area |= squared > (2.0 * FLAT * a * a).powi(2);
        }
        if has_area { None } else { self.faces.first().copied() }
    }

    fn solver_on(&self, tri: Triangulation, asked: &[Condition], start: &[f64]) -> Solver {
        let is_given: Vec<bool> = asked.iter().map(|c| matches!(c, Condition::Scale(_))).collect();
        let (mut v, mut targets) = (Vec::new(), Vec::new());
        for (condition, &start) in asked.iter().zip(start) {
            match *condition {
                Condition::Angle(angle) => {
                    targets.push(angle);
                    v.push(start);
                }
                Condition::Scale(scale) => {
                    targets.push(TAU);
                    v.push(scale);
                }
            }
        }
        Solver::new(tri, v, targets, &is_given, self.limits.tolerance, self.limits.most_steps)
    }

    pub fn is_running(&self) -> bool {
        self.solver.as_ref().is_ok_and(|s| s.progress == Progress::Running)
    }

    /// One step of Newton's method.
    pub fn step(&mut self) -> Result<(), LinalgError> {
        match &mut self.solver {
            Ok(solver) => solver.step(),
            Err(_) => Ok(()),
        }
    }

    /// Why there is no flat metric, once nothing runs any more.
    pub fn failure(&self) -> Option<NoChart> {
        match &self.solver {
            Err(reason) => Some(*reason),
            Ok(s) if s.progress == Progress::Failed => {
                Some(NoChart::NotConverged { angle_error: s.evaluation.error })
            }
            Ok(_) => None,
        }
    }

    /// The mesh edges on the boundary at which a triangle ended without inequality: there a flat metric has not been found.
    pub fn degenerate_edges(&self) -> Vec<EdgeId> {
        let Ok(solver) = &self.solver else { return Vec::new() };
        if self.is_doubled {
            return Vec::new();
        }
        solver.degenerate_boundary_edges().into_iter().map(|e| self.edges[e]).collect()
    }

    pub fn has_boundary(&self) -> bool {
        (0..self.given.edge_count()).any(|e| self.given.is_boundary(e))
    }

    /// Begins again on the surface glued to its mirror image, where edges of the boundary can flip. The solution is symmetric, the
    /// boundary a geodesic.
    pub fn double(&mut self, conditions: &[Condition]) {
        let Ok(solver) = &self.solver else { return };
        let one = &self.given;
        let edges = one.edge_count();
        // The mirror image of an inner edge is an edge of its own.
        let mut image = vec![NONE; edges];
        let mut count = edges as u32;
        for (e, image) in image.iter_mut().enumerate().filter(|(e, _)| !one.is_boundary(*e)) {
            debug_assert!(e < edges);
            *image = count;
            count += 1;
        }
        let mut vertex_image: Vec<u32> = (0..self.vertices.len() as u32).collect();
        let mut is_rim = vec![false; self.vertices.len()];
        for e in (0..edges).filter(|&e| one.is_boundary(e)) {
            is_rim[one.tail[2 * e] as usize] = true;
            is_rim[one.tail[2 * e + 1] as usize] = true;
        }
        let mut asked: Vec<Condition> =
            self.vertices.iter().map(|v| conditions[v.index()]).collect();
        let mut start = solver.v.clone();
        // A direct solution with degenerate triangles may be far away.
        if !start.iter().all(|v| v.abs() < 5.0) {
            start.fill(0.0);
        }
        for v in 0..self.vertices.len() {
            if is_rim[v] {
                if let Condition::Angle(angle) = &mut asked[v] {
                    *angle *= 2.0;
                }
            } else {
                vertex_image[v] = asked.len() as u32;
                asked.push(asked[v]);
                start.push(start[v]);
            }
        }
        // A halfedge's image runs the other way.
        let mirror = |h: u32| match image[(h >> 1) as usize] {
            NONE => h ^ 1,
            e => 2 * e + (h & 1),
        };
        let mut two = one.clone();
        let n = count as usize;
        two.next.resize(2 * n, NONE);
        two.tail.resize(2 * n, NONE);
        two.face.resize(2 * n, NONE);
        two.x.resize(n, 0.0);
        for e in 0..edges {
            if image[e] != NONE {
                two.x[image[e] as usize] = one.x[e];
            }
        }
        for f in 0..one.face_count() {
            let own = one.sides(f);
            for i in 0..3 {
                let (h, before) = (own[i], own[(i + 2) % 3]);
                two.next[mirror(h) as usize] = mirror(before);
                two.tail[mirror(h) as usize] = vertex_image[one.tip(h) as usize];
                two.face[mirror(h) as usize] = (one.face_count() + f) as u32;
            }
            two.face_halfedge.push(mirror(own[0]));
        }
        let mut doubled = self.solver_on(two, &asked, &start);
        doubled.add_counts(solver);
        self.solver = Ok(doubled);
        self.is_doubled = true;
    }

    /// Its faces laid flat, in the connectivity that was given; entry `i` is face `faces[i]`.
    pub fn develop(&self) -> Option<Vec<[Developed; 3]>> {
        let solver = self.solver.as_ref().ok().filter(|s| s.progress == Progress::Done)?;
        let sides = rewind(&solver.triangulation, &solver.v);
        Some(self.sides.iter().map(|own| own.map(|h| sides[h as usize])).collect())
    }
}
