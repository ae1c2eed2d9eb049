//! The flow: one step of Newton's method on all parts, then charts, then perhaps another round.

use nalgebra::Point3;

use super::error::ConformalError;
use super::part::Limits;
use super::round::{CutSurface, Layout, Round};
use super::solver::Progress;
use super::targets::{RimCondition, conditions};
use crate::flatten::Flattening;
use crate::mesh::{CutMesh, Mesh, MeshError, OpenedMesh};
use crate::methods::cones::Cone;
use crate::methods::flow::{Flow, SolveError, Status, StepReport};

/// Options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConformalParams {
    /// Largest error of an angle sum, radians.
    pub tolerance: f64,
    /// Steps of Newton's method in one round.
    pub most_steps: usize,
    /// How often faces that no point turns over are refined and all is solved again.
    pub rounds: usize,
    /// Whether points are inserted at all. Without, the surface keeps its triangles, and faces may lie on their backs.
    pub repair: bool,
}

impl Default for ConformalParams {
    fn default() -> Self {
        Self { tolerance: 1e-10, most_steps: 100, rounds: 3, repair: true }
    }
}

impl ConformalParams {
    /// Checks every option against its range.
    pub fn validate(&self) -> Result<(), SolveError> {
        let within = SolveError::within;
        // Below 1e-12 no mesh of some thousand vertices gets; above 1e-3 charts do not close.
        within("angle tolerance", self.tolerance, 1e-12, 1e-3)?;
        within("steps", self.most_steps as f64, 1.0, 1e4)?;
        within("rounds", self.rounds as f64, 0.0, 10.0)
    }
}

/// What was done and how good it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConformalReport {
    /// Steps of Newton's method, all rounds together. Parts step side by side.
    pub newton_steps: usize,
    /// Numeric factorisations: in each step those of the part that needed most.
    pub factorisations: usize,
    /// Symbolic analyses, counted alike: one whenever edges had flipped.
    pub analyses: usize,
    /// Trials of the line search that were rejected.
    pub rejected: usize,
    /// Euclidean flips, to make the surface's own triangulation Delaunay.
    pub surface_flips: usize,
    /// Ptolemy flips, underway.
    pub conformal_flips: usize,
    /// Largest error of an angle sum in charts that were made.
    pub angle_error: f64,
    /// Triangles of the final triangulation without triangle inequality: 0 in a flat metric.
    pub degenerate: usize,
    /// By how much charts do not close, over their diameters.
    pub closure: f64,
    /// Largest relative difference of partners' lengths; sides shorter than the mean seam side count as that.
    pub partner_mismatch: f64,
    /// Faces on their backs after the first round, before any repair.
    pub flipped_before: usize,
    /// Faces on their backs in what is given.
    pub flipped_after: usize,
    /// Points that were put on edges.
    pub points_inserted: usize,
    /// Vertices inside charts that were moved a little where no point would do.
    pub vertices_moved: usize,
    /// Rounds after the first.
    pub rounds: usize,
    /// Least and largest log scale factor.
    pub scale_range: [f64; 2],
    /// Parts that were solved together with their mirror images.
    pub doubled: usize,
    /// Length that was added to every edge so that all triangles have an area.
    pub mollified: f64,
}

/// Charts, and the surface that they are charts of.
#[derive(Clone, Debug)]
pub struct Conformal {
    /// The cut surface; more points than were given if any had to be inserted, the given ones first.
    pub cut: CutMesh,
    /// Where its points lie in space.
    pub positions: Vec<Point3<f64>>,
    /// Opened along its cut.
    pub opened: OpenedMesh,
    /// Its charts; `u` is the log scale factor v.
    pub flattening: Flattening,
    /// What was done.
    pub report: ConformalReport,
}

/// How far a [`ConformalFlow`] is.
#[derive(Clone, Debug, Default)]
pub struct ConformalState {
    /// Log scale factor at every vertex of the surface that is solved on: points of the cut mesh, or vertices of the opened one. NaN
    /// where there is none.
    pub v: Vec<f64>,
    /// Counts so far; measures of charts are 0 until the end.
    pub report: ConformalReport,
}

/// Discrete conformal flattening, step by step. See the [module](super). A clone is a checkpoint.
///
/// **Minimises** the energy of the source of `solver`, part by part. **Step**: one of Newton's method on every part that is not solved;
/// when all are, one for the charts, after which a part may begin again doubled, or all on a finer triangulation: then the energy,
/// being that of another problem, may rise. **Ends** `Converged` if every part is solved, else `Stalled`; charts are given either way.
#[derive(Clone, Debug)]
pub struct ConformalFlow {
    base: Mesh,
    params: ConformalParams,
    round: Round,
    best: Option<Layout>,
    first_flipped: Option<usize>,
    given_points: usize,
    state: ConformalState,
    status: Status,
}

impl ConformalFlow {
    /// Cones on the surface before it is cut.
    ///
    /// **Takes** the mesh, a cut of it whose points lie at `positions`, and cones at vertices of the mesh, each of them on the cut. Rim
    /// conditions are on the surface's own boundary, numbered by points. Where no scale factor is given, cones and exterior angles
    /// of each connected part add up to 2πχ; charts then have the area of the surface.
    /// **Fails** for targets that no flat surface has.
    pub fn on_surface(
        mesh: &Mesh,
        cut: &CutMesh,
        positions: &[Point3<f64>],
        cones: &[Cone],
        rim: &RimCondition,
        params: &ConformalParams,
    ) -> Result<Self, ConformalError> {
        params.validate()?;
        let (surface, whole) = prepare(cut, positions)?;
        let vertices = mesh.vertex_count().min(whole.vertex_count());
        let mut angles = vec![0.0; whole.vertex_count()];
        let mut is_taken = vec![false; whole.vertex_count()];
        for &Cone { vertex, angle } in cones {
            if vertex.index() >= vertices || whole.halfedge(vertex).is_none() {
                return Err(ConformalError::NoSuchVertex { vertex, vertices });
            }
            if std::mem::replace(&mut is_taken[vertex.index()], true) {
                return Err(ConformalError::Twice { vertex });
            }
            // The first copy of a point keeps its number, and a cut that passes makes it one of the rim.
            if angle != 0.0 && !surface.opened.mesh.is_boundary_vertex(vertex) {
                return Err(ConformalError::ConeOffSeam { vertex });
            }
            angles[vertex.index()] = angle;
        }
        let conditions = conditions(&whole, &angles, rim)?;
        Self::begin(mesh, surface, whole, false, conditions, params)
    }

    /// Every patch of a cut surface by itself.
    ///
    /// **Takes** the mesh and a cut of it as [`ConformalFlow::on_surface`]. Rim conditions are numbered by vertices of the cut mesh opened. With
    /// isometric rims, or scale factors that are the same at all copies of a point, partners are equally long. Exterior angles of a
    /// patch add up to 2π; its chart has the area of the patch. **Fails** for targets that no flat surface has; patches that
    /// are no disks or have no area have no chart, and cost no other its own.
    pub fn on_patches(
        mesh: &Mesh,
        cut: &CutMesh,
        positions: &[Point3<f64>],
        rim: &RimCondition,
        params: &ConformalParams,
    ) -> Result<Self, ConformalError> {
        params.validate()?;
        let (surface, whole) = prepare(cut, positions)?;
        let angles = vec![0.0; surface.opened.mesh.vertex_count()];
        let conditions = conditions(&surface.opened.mesh, &angles, rim)?;
        Self::begin(mesh, surface, whole, true, conditions, params)
    }

    fn begin(
        mesh: &Mesh,
        surface: CutSurface,
        whole: Mesh,
        by_patch: bool,
        conditions: Vec<super::targets::Condition>,
        params: &ConformalParams,
    ) -> Result<Self, ConformalError> {
        let start = vec![0.0; conditions.len()];
        let positions = surface.positions.len();
        let limits = Limits { tolerance: params.tolerance, most_steps: params.most_steps };
        let round = Round::new(surface, whole, by_patch, conditions, &start, limits)?;
        let mut flow = Self {
            base: mesh.clone(),
            params: *params,
            round,
            best: None,
            first_flipped: None,
            given_points: positions,
            state: ConformalState::default(),
            status: Status::Running,
        };
        flow.take_stock();
        Ok(flow)
    }

    fn limits(&self) -> Limits {
        Limits { tolerance: self.params.tolerance, most_steps: self.params.most_steps }
    }

    /// How the flow stands.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Charts, once the flow has ended.
    pub fn result(&self) -> Option<Conformal> {
        let layout = self.best.as_ref().filter(|_| self.status != Status::Running)?;
        Some(Conformal {
            cut: layout.surface.cut.clone(),
            positions: layout.surface.positions.clone(),
            opened: layout.surface.opened.clone(),
            flattening: layout.flattening.clone(),
            report: self.state.report.clone(),
        })
    }

    /// Updates the state from the parts.
    fn take_stock(&mut self) {
        self.state.v = self.round.scale_factors();
        let report = &mut self.state.report;
        report.mollified = self.round.mollified;
        [report.surface_flips, report.conformal_flips, report.degenerate, report.doubled] = [0; 4];
        report.angle_error = 0.0;
        for part in &self.round.parts {
            report.doubled += usize::from(part.is_doubled);
            let Ok(solver) = &part.solver else { continue };
            let triangulation = &solver.triangulation;
            report.surface_flips += triangulation.surface_flips;
            report.conformal_flips += triangulation.flipped.len() - triangulation.surface_flips;
            if solver.progress != Progress::Failed {
                report.angle_error = report.angle_error.max(solver.evaluation.error);
            }
            if solver.progress == Progress::Done {
                report.degenerate += solver.degenerate_faces();
            }
        }
    }

    /// One step of Newton's method on all parts that run.
    fn newton(&mut self) -> Result<(), SolveError> {
        let mut most = [0; 3];
        for part in self.round.parts.iter_mut().filter(|p| p.is_running()) {
            let counts = |part: &super::part::Part| {
                let solver = part.solver.as_ref().ok();
                solver.map_or([0; 3], |s| [s.factorisations, s.analyses, s.rejected])
            };
            let before = counts(part);
            part.step()?;
            for (most, (after, before)) in most.iter_mut().zip(counts(part).iter().zip(before)) {
                *most = (*most).max(after - before);
            }
        }
        let report = &mut self.state.report;
        report.newton_steps += 1;
        report.factorisations += most[0];
        report.analyses += most[1];
        report.rejected += most[2];
        Ok(())
    }

    /// All parts are solved or given up: what comes next.
    fn conclude(&mut self) -> Result<(), ConformalError> {
        let may_refine = self.params.repair && self.state.report.rounds < self.params.rounds;
        let seams = self.round.degenerate_seams();
        if may_refine && !seams.is_empty() {
            return self.refine(&seams);
        }
        if self.round.double() {
            return Ok(());
        }
        let layout = self.round.lay_out(&self.base, self.params.repair)?;
        self.first_flipped.get_or_insert(layout.flipped_before);
        let sides: Vec<usize> =
            layout.left.iter().flat_map(|f| [0, 1, 2].map(|i| 3 * f.index() + i)).collect();
        let is_better = |best: &Layout| layout.flipped_after < best.flipped_after;
        let is_clean = layout.flipped_after == 0;
        if self.best.as_ref().is_none_or(is_better) {
            self.keep(layout);
        }
        if may_refine && !is_clean && !sides.is_empty() {
            return self.refine(&sides);
        }
        let all_solved = self.round.parts.iter().all(|p| p.failure().is_none());
        self.status = if all_solved { Status::Converged } else { Status::Stalled };
        Ok(())
    }

    fn refine(&mut self, sides: &[usize]) -> Result<(), ConformalError> {
        self.round = self.round.refined(&self.base, sides, self.limits())?;
        self.state.report.rounds += 1;
        Ok(())
    }

    fn keep(&mut self, layout: Layout) {
        let report = &mut self.state.report;
        report.closure = layout.closure;
        report.partner_mismatch = layout.partner_mismatch;
        report.flipped_before = self.first_flipped.unwrap_or(layout.flipped_before);
        report.flipped_after = layout.flipped_after;
        report.scale_range = layout.scale_range;
        report.vertices_moved = layout.moved;
        report.points_inserted = layout.surface.positions.len() - self.given_points;
        self.best = Some(layout);
    }

    fn report(&self) -> StepReport {
        StepReport {
            step: self.state.report.newton_steps,
            // The energy would take as long as the angles, and near the end its decrease is below its rounding.
            energy: vec![("angle error", self.state.report.angle_error)],
            residual: self.state.report.angle_error,
            progress: None,
            status: self.status,
        }
    }
}

impl Flow for ConformalFlow {
    type State = ConformalState;

    fn state(&self) -> &ConformalState {
        &self.state
    }

    fn step(&mut self) -> Result<StepReport, SolveError> {
        if self.status == Status::Running {
            if self.round.parts.iter().any(super::part::Part::is_running) {
                self.newton()?;
            } else {
                self.conclude().map_err(as_solve_error)?;
            }
            self.take_stock();
        }
        Ok(self.report())
    }
}

/// Targets of a refined surface are those of the one before: only its connectivity can fail.
fn as_solve_error(error: ConformalError) -> SolveError {
    match error {
        ConformalError::Solve(error) => error,
        ConformalError::Mesh(error) => SolveError::Mesh(error),
        _ => SolveError::NotFinite,
    }
}

fn prepare(cut: &CutMesh, positions: &[Point3<f64>]) -> Result<(CutSurface, Mesh), ConformalError> {
    let points = cut.points.len();
    if positions.len() != points {
        let (name, given) = ("positions", positions.len());
        return Err(ConformalError::WrongLength { name, given, vertices: points });
    }
    let whole: Result<Mesh, MeshError> = Mesh::new(points, &cut.triangles);
    let surface =
        CutSurface { cut: cut.clone(), positions: positions.to_vec(), opened: cut.open()? };
    Ok((surface, whole?))
}
