//! Coarse to fine: a surface with a fraction of the triangles says where the cones will be.
//!
//! The problem is convex, so the start is a matter of time only: cones of the coarse surface, put on the nearest vertices and mended
//! to satisfy Gauss–Bonnet, are a feasible set of angles close to the optimum.

use super::flow::ConeFlow;
use super::params::{ConeFields, ConeParams};
use super::problem::{ActiveSet, Problem, Stance};
use super::system::NONE;
use crate::geometry::{Geometry, Nearest};
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::{Flow, SolveError, Status};
use crate::methods::prepare::{Attributes, DecimateFlow, DecimateParams, Surface};

/// Surfaces with fewer vertices are solved as they are.
const SMALLEST: usize = 4000;
/// Triangles of the fine surface for one of the coarse one.
const FRACTION: usize = 6;

/// The coarse surface in the making, or the flow on it.
pub(super) struct Coarse {
    decimation: Option<Box<DecimateFlow>>,
    flow: Option<Box<ConeFlow>>,
    target_faces: usize,
    /// Steps so far: what it takes to come here again.
    pub steps: usize,
}

/// How the coarse stage stands.
pub(super) enum Stage {
    Running,
    /// Where to begin; none if the surface cannot be made coarse.
    Over(Option<ActiveSet>),
}

impl Coarse {
    /// None where the surface is small already, or is not what its positions say.
    pub fn new(mesh: &Mesh, geometry: &Geometry) -> Option<Self> {
        if mesh.vertex_count() < SMALLEST {
            return None;
        }
        let target_faces = mesh.face_count() / FRACTION;
        let surface = Surface {
            mesh: mesh.clone(),
            positions: geometry.positions.clone(),
            attributes: Attributes::default(),
        };
        let params = DecimateParams { target_faces, ..DecimateParams::default() };
        let decimation = DecimateFlow::new(surface, &params).ok()?;
        Some(Self { decimation: Some(Box::new(decimation)), flow: None, target_faces, steps: 0 })
    }

    /// One step of decimation, or of the flow on the coarse surface.
    pub fn step(
        &mut self,
        mesh: &Mesh,
        geometry: &Geometry,
        problem: &Problem,
        fields: &ConeFields,
    ) -> Result<Stage, SolveError> {
        self.steps += 1;
        if let Some(flow) = &mut self.flow {
            if flow.step()?.status == Status::Running {
                return Ok(Stage::Running);
            }
            return Ok(Stage::Over(carried(mesh, geometry, problem, flow)));
        }
        let Some(decimation) = &mut self.decimation else { return Ok(Stage::Over(None)) };
        if decimation.step()?.status == Status::Running {
            return Ok(Stage::Running);
        }
        let surface = decimation.state().surface.clone();
        self.decimation = None;
        let Ok(coarse) = Geometry::new(&surface.mesh, surface.positions) else {
            return Ok(Stage::Over(None));
        };
        if surface.mesh.face_count() > 2 * self.target_faces {
            return Ok(Stage::Over(None));
        }
        let coarse_fields = averaged(mesh, geometry, &surface.mesh, &coarse, fields);
        let params = ConeParams { multiresolution: false, ..problem.params };
        // What cannot be asked of the coarse surface is asked of the fine one alone.
        match ConeFlow::new(&surface.mesh, &coarse, &params, &coarse_fields) {
            Ok(flow) => {
                self.flow = Some(Box::new(flow));
                Ok(Stage::Running)
            }
            Err(_) => Ok(Stage::Over(None)),
        }
    }
}

/// For places of one surface, the nearest vertex of another.
fn nearest(
    mesh: &Mesh,
    geometry: &Geometry,
    places: &Geometry,
    of: impl Iterator<Item = VertexId>,
) -> Vec<VertexId> {
    let tree = Nearest::new(mesh, &geometry.positions);
    of.map(|v| {
        tree.find(places.positions[v.index()]).map_or(VertexId(0), |hit| {
            let corner = (0..3).max_by(|&a, &b| hit.weights[a].total_cmp(&hit.weights[b]));
            mesh.face_vertices(hit.face)[corner.unwrap_or(0)]
        })
    })
    .collect()
}

/// What is painted, on the coarse surface.
fn averaged(
    mesh: &Mesh,
    geometry: &Geometry,
    coarse_mesh: &Mesh,
    coarse: &Geometry,
    fields: &ConeFields,
) -> ConeFields {
    let back = nearest(mesh, geometry, coarse, coarse_mesh.vertices());
    fn pick<T: Copy>(field: &[T], back: &[VertexId]) -> Vec<T> {
        if field.is_empty() { Vec::new() } else { back.iter().map(|v| field[v.index()]).collect() }
    }
    let mut is_taken = vec![false; coarse_mesh.vertex_count()];
    let mut excluded = pick(&fields.excluded, &back);
    let mut place = |v: VertexId| {
        let to = nearest(coarse_mesh, coarse, geometry, std::iter::once(v))[0];
        if let Some(excluded) = excluded.get_mut(to.index()) {
            *excluded = false;
        }
        (!std::mem::replace(&mut is_taken[to.index()], true)).then_some(to)
    };
    let fixed = fields.fixed.iter().filter_map(|&(v, angle)| Some((place(v)?, angle))).collect();
    let free = fields.free.iter().filter_map(|&v| place(v)).collect();
    ConeFields {
        distortion_weight: pick(&fields.distortion_weight, &back),
        cone_cost: pick(&fields.cone_cost, &back),
        excluded,
        free,
        fixed,
    }
}

/// Cones of the coarse surface on the nearest vertices of the fine one.
fn carried(
    mesh: &Mesh,
    geometry: &Geometry,
    problem: &Problem,
    flow: &ConeFlow,
) -> Option<ActiveSet> {
    if flow.status() != Status::Converged {
        return None;
    }
    let state = flow.state();
    let cones: Vec<_> = state.cones.iter().chain(&state.corners).collect();
    let places = nearest(mesh, geometry, flow.geometry(), cones.iter().map(|c| c.vertex));
    let mut set = problem.start.clone();
    for i in 0..set.angles.len() {
        if set.stances[i] != Stance::Held {
            (set.angles[i], set.stances[i]) = (0.0, Stance::Zero);
        }
    }
    set.order.clear();
    for (cone, v) in cones.iter().zip(places) {
        let i = problem.system.dof_of[v.index()];
        if i != NONE && set.stances[i as usize] != Stance::Held {
            set.angles[i as usize] += cone.angle;
        }
    }
    for i in 0..set.angles.len() {
        if set.stances[i] == Stance::Held || set.angles[i] == 0.0 {
            continue;
        }
        let angle = set.angles[i].clamp(problem.low[i], problem.high[i]);
        set.angles[i] = angle;
        match problem.stance_at(i, angle) {
            Stance::Zero if angle != 0.0 => set.release(u32::try_from(i).ok()?, angle.signum()),
            stance => set.stances[i] = stance,
        }
    }
    problem.repair(&mut set).then_some(set)
}
