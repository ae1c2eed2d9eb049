//! Noise taken out of seams: vertices of seams are moved onto the planes of the charts beside them.
//!
//! Minimised over the vertices v_i on seams is E = Σ over edges ij at them, Σ over the faces f at ij, of (N_f · (v_i − v_j))², N_f the proxy normal of f's
//! chart: an edge should lie in the planes of both its faces' charts. Where two planes meet the seam becomes their line, at a corner of three their point.
//!
//! Not done: straightening within a plane. E does not change when a vertex moves along both planes, so that a zigzag of the seam between two charts of one plane
//! stays as it is; moving seams over the faces is the matter of [`super::RefineFlow`].

use std::sync::Arc;

use nalgebra::{Point3, Vector3};

use crate::geometry::Geometry;
use crate::mesh::{EdgeId, Mesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Options of a [`DenoiseFlow`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DenoiseParams {
    /// Number of sweeps over all vertices on seams.
    pub sweeps: usize,
    /// Length of a step, in 1 / (2 · valence), up to which E falls for certain.
    pub step: f64,
}

impl Default for DenoiseParams {
    fn default() -> Self {
        Self { sweeps: 8, step: 1.0 }
    }
}

impl DenoiseParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        SolveError::within("sweeps over seams", self.sweeps as f64, 0.0, 1e5)?;
        SolveError::within("step of sweeps", self.step, 0.0, 1.0)
    }
}

/// Where the vertices are.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DenoiseState {
    /// All vertices; those that are on no seam are where they were.
    pub positions: Vec<Point3<f64>>,
    /// Sweeps done.
    pub sweeps: usize,
    /// E, see the module.
    pub energy: f64,
    /// The longest way of a vertex from where it was.
    pub farthest: f64,
}

/// Takes noise out of seams, a sweep a step.
///
/// **Minimises** E of the module. **Step** v_i ← v_i + λ_i Σ_j Σ_f N_f N_fᵀ (v_j − v_i) for all vertices on seams at once, λ_i = step / (2 · valence).
/// **Ends** `StepLimit` after the sweeps asked for; `Converged` when nothing moves.
/// **From** [LPFB §2, step 3].
#[derive(Clone)]
pub struct DenoiseFlow {
    mesh: Arc<Mesh>,
    params: DenoiseParams,
    original: Vec<Point3<f64>>,
    face_normals: Vec<Vector3<f64>>,
    vertices: Vec<VertexId>,
    edges: Vec<EdgeId>,
    state: DenoiseState,
    status: Status,
}

impl DenoiseFlow {
    /// Prepares.
    ///
    /// **Takes** a chart for each face, any numbers; all faces of one number count for its plane. **Fails** on parameters out of range.
    /// **Costs** O(F).
    pub fn new(
        mesh: Arc<Mesh>,
        geometry: &Geometry,
        face_charts: &[u32],
        params: DenoiseParams,
    ) -> Result<Self, SolveError> {
        params.validate()?;
        assert_eq!(face_charts.len(), mesh.face_count());
        let face_normals = chart_normals(&mesh, geometry, face_charts);
        let chart = |f: crate::mesh::FaceId| face_charts[f.index()];
        let mut is_on_seam = vec![false; mesh.vertex_count()];
        for e in mesh.edges() {
            let h = e.halfedge();
            let (Some(f), Some(g)) = (mesh.face(h), mesh.face(h.twin())) else { continue };
            if chart(f) != chart(g) {
                for v in mesh.edge_vertices(e) {
                    is_on_seam[v.index()] = true;
                }
            }
        }
        let vertices = mesh.vertices().filter(|v| is_on_seam[v.index()]).collect();
        let is_moved = |e: &EdgeId| mesh.edge_vertices(*e).iter().any(|v| is_on_seam[v.index()]);
        let edges = mesh.edges().filter(is_moved).collect();
        let positions = geometry.positions.clone();
        let state = DenoiseState { positions: positions.clone(), ..DenoiseState::default() };
        let (original, status) = (positions, Status::Running);
        let mut flow =
            Self { mesh, params, original, face_normals, vertices, edges, state, status };
        flow.measure();
        if !flow.state.energy.is_finite() {
            return Err(SolveError::NotFinite);
        }
        Ok(flow)
    }

    /// How it stands.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Goes back to a state of a flow on the same surface with the same charts and options. Later steps repeat bit for bit.
    pub fn restore(&mut self, state: &DenoiseState) {
        self.state = state.clone();
        self.status = Status::Running;
    }

    fn measure(&mut self) {
        let positions = &self.state.positions;
        let mut energy = 0.0;
        for &e in &self.edges {
            let [a, b] = self.mesh.edge_vertices(e).map(|v| positions[v.index()]);
            for f in
                [e.halfedge(), e.halfedge().twin()].into_iter().filter_map(|h| self.mesh.face(h))
            {
                energy += self.face_normals[f.index()].dot(&(b - a)).powi(2);
            }
        }
        self.state.energy = energy;
        let way = |v: &VertexId| (positions[v.index()] - self.original[v.index()]).norm();
        self.state.farthest = self.vertices.iter().map(way).fold(0.0, f64::max);
    }

    fn sweep(&mut self) {
        let (mesh, positions) = (&self.mesh, &self.state.positions);
        let mut moved = positions.clone();
        for &v in &self.vertices {
            let at = positions[v.index()];
            let mut pull = Vector3::zeros();
            let mut valence = 0.0;
            for h in mesh.outgoing(v) {
                let edge = positions[mesh.tip(h).index()] - at;
                for f in [h, h.twin()].into_iter().filter_map(|h| mesh.face(h)) {
                    let normal = self.face_normals[f.index()];
                    pull += normal * normal.dot(&edge);
                }
                valence += 1.0;
            }
            moved[v.index()] = at + pull * (self.params.step / (2.0 * valence));
        }
        let is_still = moved == *positions;
        self.state.positions = moved;
        self.state.sweeps += 1;
        self.measure();
        if is_still {
            self.status = Status::Converged;
        }
    }
}

/// For each face the unit normal of its chart, the mean of its faces' by area; zero where they cancel out.
///
/// **Takes** a chart for each face, any numbers.
pub fn chart_normals(mesh: &Mesh, geometry: &Geometry, face_charts: &[u32]) -> Vec<Vector3<f64>> {
    let mut names = face_charts.to_vec();
    names.sort_unstable();
    names.dedup();
    let number = |f: usize| names.partition_point(|&name| name < face_charts[f]);
    let mut sums = vec![Vector3::zeros(); names.len()];
    for (f, normal) in geometry.face_normals(mesh).into_iter().enumerate() {
        sums[number(f)] += normal * geometry.face_areas[f];
    }
    let unit = |sum: Vector3<f64>| sum.try_normalize(1e-300).unwrap_or_default();
    (0..face_charts.len()).map(|f| unit(sums[number(f)])).collect()
}

impl Flow for DenoiseFlow {
    type State = DenoiseState;

    fn state(&self) -> &DenoiseState {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status == Status::Running && self.state.sweeps >= self.params.sweeps {
            self.status = Status::StepLimit;
        }
        if self.status == Status::Running {
            self.sweep();
        }
        #[expect(clippy::cast_possible_truncation, reason = "a fraction")]
        let progress = (self.state.sweeps as f64 / self.params.sweeps.max(1) as f64) as f32;
        Ok(StepReport {
            step: self.state.sweeps,
            energy: vec![("Σ (N · edge)²", self.state.energy), ("farthest", self.state.farthest)],
            residual: 0.0,
            progress: Some(progress),
            status: self.status,
        })
    }
}
