//! Optimal cones at work: the solver of the open surface, what was done by hand, and the cones as they are used.
//!
//! Everything follows from the parameters, the painted layers and [`Edits`]: Undo keeps these and solves again, starting from
//! where the solver is.

mod commands;
mod edits;
mod file;
mod measures;
mod path;
mod problem;
mod report;
mod specs;
mod table;

use super::document::Document;
use super::inputs::Layers;
use super::params::Settings;
use super::surface::Surface;
use super::text::Problem;
use crate::methods::cones::{Cone, ConeFields, ConeFlow, ConeParams, ConeTarget, PathPoint};
use crate::methods::flow::{Flow, Status};

pub use edits::Edits;
pub use file::is_cones_file;
pub use path::Tracing;
pub use report::{ConeReport, ConesReport, RoundedReport};
pub use specs::specs;
pub use table::{ConeComparisonRow, ConePathPoint, ConeRow, ConeTable};

/// Cones of a document. Nothing is solved before the method is chosen.
#[derive(Default)]
pub struct Cones {
    solver: Option<Solver>,
    /// What was done by hand.
    pub edits: Edits,
    /// The cones as they are used; none before the first solution.
    pub set: Option<ConeSet>,
    /// The optimum over λ as far as it is known, λ descending.
    pub path: Vec<PathPoint>,
    /// The sampling of the path that is going on.
    pub tracing: Option<Tracing>,
    /// Other choices of as many cones.
    pub comparison: Vec<ConeComparisonRow>,
    /// Whether to solve as soon as there is time.
    pub is_due: bool,
    /// Whether changes by hand gave way to another optimum.
    pub has_dropped: bool,
    /// Rounds of the present solution.
    pub rounds: usize,
}

/// A solver and the problem that it was made for.
struct Solver {
    flow: ConeFlow,
    params: ConeParams,
    fields: ConeFields,
    /// What it was asked to reach.
    target: ConeTarget,
}

/// Cones as they are used, and their flattening's scale factors.
pub struct ConeSet {
    /// Ascending by vertex.
    pub cones: Vec<UsedCone>,
    /// Log scale factor at each vertex of the mesh.
    pub u: Vec<f64>,
    /// ∫u².
    pub int_u2: f64,
    /// Σ|angle|.
    pub total_angle: f64,
    /// ‖u − u*‖ / ‖u*‖ against the optimum u*, where the cones stand for it: the exact value of what the stability theorem
    /// ([MAD] C.5) bounds.
    pub change: Option<f64>,
}

/// A cone that is used.
#[derive(Clone, Debug, PartialEq)]
pub struct UsedCone {
    /// Where and how much.
    pub cone: Cone,
    /// How it came about.
    pub kind: ConeKind,
    /// Vertices of the optimum that it stands for.
    pub members: usize,
}

/// How a cone came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConeKind {
    /// A vertex of the optimum.
    Optimal,
    /// Stands for several vertices of the optimum.
    Merged,
    /// Put there by hand, with the angle that is best.
    Free,
    /// Moved by hand, with the angle that it had.
    Moved,
    /// Given its angle by hand.
    Fixed,
}

impl Cones {
    /// Whether there is a solution to show.
    pub fn is_solved(&self) -> bool {
        self.set.is_some()
    }

    /// How the solver stands.
    pub fn status(&self) -> Option<Status> {
        self.solver.as_ref().map(|solver| solver.flow.status())
    }

    /// The optimum as far as it is known.
    pub fn flow(&self) -> Option<&ConeFlow> {
        self.solver.as_ref().map(|solver| &solver.flow)
    }

    /// The solver, to ask it for more.
    pub fn flow_mut(&mut self) -> Option<&mut ConeFlow> {
        self.solver.as_mut().map(|solver| &mut solver.flow)
    }

    /// Takes over the solver of the same surface, and what it knows.
    pub fn keep_solver(&mut self, old: Self) {
        self.solver = old.solver;
        self.path = old.path;
        self.set = old.set;
    }

    /// Whether the solver has these fields already.
    pub fn is_for(&self, fields: &ConeFields) -> bool {
        self.solver.as_ref().is_some_and(|solver| solver.fields == *fields)
    }

    /// Forgets the solution.
    pub fn begin_again(&mut self) {
        let edits = std::mem::take(&mut self.edits);
        *self = Self { edits: Edits { changed: None, ..edits }, ..Self::default() };
    }

    /// What the solver needed so far: factorisations and solves.
    pub fn costs(&self) -> Option<[usize; 2]> {
        self.flow().map(|flow| [flow.factorisations(), flow.solves()])
    }

    /// Brings the solver up to the parameters, layers and edits.
    fn prepare(
        &mut self,
        document: &Document,
        settings: &Settings,
        layers: &Layers,
    ) -> Result<&mut ConeFlow, Problem> {
        let surface = document.surface()?;
        let params = problem::params(settings);
        let fields = problem::fields(settings, layers, &self.edits, surface);
        let wrong = |error| Problem::solve(&document.name, &error);
        // λ is followed by the solver; everything else is another problem.
        self.abandon_path();
        let is_same = self.solver.as_ref().is_some_and(|solver| {
            solver.fields == fields
                && ConeParams { lambda: params.lambda, ..solver.params } == params
        });
        if !is_same {
            let (mesh, geometry) = surface.given_or_mended();
            let flow = ConeFlow::new(mesh, geometry, &params, &fields).map_err(wrong)?;
            self.path.clear();
            self.tracing = None;
            let target = ConeTarget::Lambda(params.lambda);
            self.solver = Some(Solver { flow, params, fields, target });
            self.rounds = 0;
        }
        let solver = self.solver.as_mut().ok_or_else(super::nothing_open)?;
        let target = problem::target(settings);
        if solver.target != target {
            solver.flow.aim(target).map_err(wrong)?;
            solver.target = target;
            self.rounds = 0;
        }
        Ok(&mut solver.flow)
    }

    /// One round of the solver; the cones that are used follow.
    ///
    /// **Gives** whether the solution has been reached.
    fn round(
        &mut self,
        document: &Document,
        settings: &Settings,
        layers: &Layers,
    ) -> Result<bool, Problem> {
        let wrong = |error| Problem::solve(&document.name, &error);
        let flow = self.prepare(document, settings, layers)?;
        let status = match flow.status() {
            Status::Running => flow.step().map_err(wrong)?.status,
            status => status,
        };
        self.rounds += 1;
        self.use_cones(document, settings)?;
        Ok(status != Status::Running)
    }

    /// Makes the cones that are used from the optimum, or from what was changed by hand.
    fn use_cones(&mut self, document: &Document, settings: &Settings) -> Result<(), Problem> {
        let surface = document.surface()?;
        let Some(solver) = &mut self.solver else { return Ok(()) };
        let wrong = |error| Problem::solve(&document.name, &error);
        let set = match &self.edits.changed {
            Some(cones) => measures::evaluated(&mut solver.flow, cones.clone()),
            None => measures::of_optimum(&mut solver.flow, settings, &self.edits, surface),
        };
        self.set = Some(set.map_err(wrong)?);
        Ok(())
    }
}

impl ConeSet {
    /// The vertices of the cones.
    pub fn vertices(&self) -> Vec<crate::mesh::VertexId> {
        self.cones.iter().map(|used| used.cone.vertex).collect()
    }
}

/// Where each vertex of the file is in the mesh's scene.
fn place_of(surface: &Surface, cone: &Cone) -> [f64; 3] {
    let place = surface.geometry.positions[cone.vertex.index()].coords / surface.radius();
    place.into()
}
