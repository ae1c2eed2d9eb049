//! Optimal cones at work: the solver of the open surface, what was done by hand, and the cones as they are used.
//!
//! Everything follows from the parameters, the painted layers and [`Edits`]: Undo keeps these and solves again, starting from
//! where the solver is.

mod driving;
mod edits;
mod file;
mod hands;
mod measures;
mod path;
mod problem;
mod report;
mod specs;
mod table;
mod telling;

use std::f64::consts::TAU;

use super::document::Document;
use super::inputs::Layers;
use super::params::Settings;
use super::surface::Surface;
use super::text::Problem;
use crate::methods::cones::{
    Cone, ConeFields, ConeFlow, ConeParams, ConeState, ConeTarget, Places,
};
use crate::methods::flow::{Flow, Status};

use edits::{cone_problem, too_large};

pub use edits::Edits;
pub use file::is_cones_file;
pub use path::{KnownPath, Tracing};
pub use report::{ConeReport, ConesReport, RoundedReport};
pub use specs::specs;
pub use table::{ConeComparisonRow, ConePathPoint, ConeRow, ConeTable};

/// Rounds of a solution whose results are not shown one by one: merging and measuring them takes longer than they do.
const SHORT: usize = 8;

/// Cones of a document. Nothing is solved before the method is chosen.
#[derive(Default)]
pub struct Cones {
    solver: Option<Solver>,
    /// What was done by hand.
    pub edits: Edits,
    /// The cones as they are used; none before the first solution.
    pub set: Option<ConeSet>,
    /// Whether these are shown only until those of the state that Undo led to are there.
    pub is_set_passed: bool,
    /// The optimum over λ as far as it is known.
    pub path: KnownPath,
    /// The sampling of the path that is going on.
    pub tracing: Option<Tracing>,
    /// Other choices of as many cones.
    pub comparison: Vec<ConeComparisonRow>,
    /// The optimum that they were made of.
    pub optimum: Option<ConeState>,
    /// Whether the solver has not reached what the parameters ask for.
    pub is_stale: bool,
    /// Whether it waits until it is told to go on.
    pub is_held: bool,
    /// What is wanted once the solution is there.
    pub wanted: Wanted,
    /// How often cones were made anew.
    pub pictures: usize,
    /// Rounds of the present solution.
    pub rounds: usize,
    /// The search for places of an exact number of cones.
    placing: Option<Places>,
}

/// Something to be computed beside the solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wanted {
    /// Nothing.
    #[default]
    Nothing,
    /// The path over λ.
    Path,
    /// The greedy strategy.
    Comparison,
}

/// A solver and the problem that it was made for.
struct Solver {
    flow: ConeFlow,
    params: ConeParams,
    fields: ConeFields,
    /// What it was asked to reach.
    target: Option<ConeTarget>,
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
    /// Where it does most, of an exact number.
    Placed,
    /// Put there by hand, with the angle that is best.
    Free,
    /// A corner of the flattened boundary.
    Corner,
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

    /// Whether to solve as soon as there is time.
    pub fn is_due(&self) -> bool {
        self.is_stale && !self.is_held
    }

    /// Whether a path is being sampled, or more than the solution is wanted.
    pub fn asks_more(&self) -> bool {
        self.tracing.is_some() || self.wanted != Wanted::Nothing
    }

    /// Whether they are not the solution that was asked for, or a path is being sampled.
    pub fn is_unsettled(&self) -> bool {
        self.is_stale || !self.is_solved() || self.tracing.is_some()
    }

    /// Solve as soon as there is time.
    pub fn ask_again(&mut self) {
        self.comparison.clear();
        self.wanted = Wanted::Nothing;
        self.placing = None;
        self.is_stale = true;
        self.is_held = false;
    }

    /// Whether a path is known or being sampled.
    pub fn has_path(&self) -> bool {
        self.tracing.is_some() || self.path.len() > 0
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
    pub fn keep_solver(&mut self, mut old: Self) {
        old.abandon_path();
        self.solver = old.solver;
        self.is_set_passed = old.set.is_some();
        self.set = old.set;
        self.optimum = old.optimum;
    }

    /// Finds out whether the solver can take these fields. It has taken them then.
    pub fn try_fields(&mut self, surface: &Surface, fields: &ConeFields) -> Result<(), Problem> {
        if let Some(i) = fields.fixed.iter().position(|(_, angle)| !(angle.abs() < TAU)) {
            let (vertex, angle) = fields.fixed[i];
            let number = surface.soup_vertices[vertex.index()];
            let place = format!("{}, vertex {number} (counted from 0).", surface.name);
            return Err(too_large(place, angle));
        }
        let Some(solver) = self.solver.as_mut().filter(|solver| solver.fields != *fields) else {
            return Ok(());
        };
        solver.flow.set_fields(fields).map_err(|error| cone_problem(surface, &error))?;
        solver.fields = fields.clone();
        solver.target = None;
        Ok(())
    }

    /// Whether the solver has these fields already.
    pub fn is_for(&self, fields: &ConeFields) -> bool {
        self.solver.as_ref().is_some_and(|solver| solver.fields == *fields)
    }

    /// Forgets the solution.
    pub fn begin_again(&mut self) {
        let edits = std::mem::take(&mut self.edits);
        *self = Self {
            edits: Edits { changed: None, has_dropped: false, ..edits },
            is_stale: true,
            is_held: true,
            ..Self::default()
        };
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
        let target = problem::target(settings);
        let wrong = |error| cone_problem(surface, &error);
        self.abandon_path();
        // λ is part of the target; another one is no other problem.
        let is_same = self
            .solver
            .as_ref()
            .is_some_and(|s| ConeParams { lambda: params.lambda, ..s.params } == params);
        if self.solver.is_none() {
            let (mesh, geometry) = surface.given_or_mended();
            let flow = ConeFlow::new(mesh, geometry, &params, &fields).map_err(wrong)?;
            self.solver = Some(Solver { flow, params, fields: fields.clone(), target: None });
        } else if !is_same && let Some(solver) = &mut self.solver {
            solver.flow.set_params(&params).map_err(wrong)?;
            solver.params = params;
            solver.target = None;
        }
        if !self.path.is_of(&params, &fields) {
            self.forget_path();
        }
        self.try_fields(surface, &fields)?;
        let solver = self.solver.as_mut().ok_or_else(super::nothing_open)?;
        if solver.target != Some(target) {
            solver.flow.aim(target).map_err(wrong)?;
            solver.target = Some(target);
            self.rounds = 0;
        }
        Ok(&mut solver.flow)
    }

    /// One round of the solver; the cones that are used follow.
    ///
    /// **Gives** whether the solution has been reached.
    pub fn round(
        &mut self,
        document: &Document,
        settings: &Settings,
        layers: &Layers,
    ) -> Result<bool, Problem> {
        let surface = document.surface()?;
        let is_running = self.prepare(document, settings, layers)?.status() == Status::Running;
        let exactly = problem::exact_count(settings).filter(|_| self.edits.changed.is_none());
        match (exactly, &mut self.solver) {
            (Some(count), _) if !is_running => self.place(count, surface)?,
            (_, Some(solver)) if is_running => {
                solver.flow.step().map_err(|error| cone_problem(surface, &error))?;
            }
            _ => {}
        }
        self.rounds += usize::from(is_running || exactly.is_some());
        self.is_stale = match exactly {
            Some(_) => !self.is_placed(),
            None => self.status() == Some(Status::Running),
        };
        // A slider's move takes a few rounds: only their end is shown, until they take long.
        if !self.is_stale || !self.is_solved() || self.rounds > SHORT {
            self.use_cones(surface, settings)?;
        }
        Ok(!self.is_stale)
    }

    /// One piece of the search for the places of so many cones.
    fn place(&mut self, count: usize, surface: &Surface) -> Result<(), Problem> {
        let Some(solver) = &mut self.solver else { return Ok(()) };
        let wrong = |error| cone_problem(surface, &error);
        match &mut self.placing {
            Some(places) => places.step(&mut solver.flow).map_err(wrong),
            None => {
                let begun = measures::places(&mut solver.flow, count, &self.edits, surface);
                self.placing = Some(begun.map_err(wrong)?);
                self.rounds = 0;
                Ok(())
            }
        }
    }

    /// Whether the cones are an exact number at the best places found.
    pub fn is_placed(&self) -> bool {
        self.placing.as_ref().is_some_and(Places::is_done) && self.edits.changed.is_none()
    }

    /// These are the cones that are used.
    pub fn put(&mut self, set: ConeSet) {
        self.set = Some(set);
        self.is_set_passed = false;
    }

    /// Makes the cones that are used from the optimum, or from what was changed by hand.
    fn use_cones(&mut self, surface: &Surface, settings: &Settings) -> Result<(), Problem> {
        let Some(solver) = &mut self.solver else { return Ok(()) };
        let set = match &self.edits.changed {
            Some(cones) => measures::evaluated(&mut solver.flow, cones.clone()),
            None => match &self.placing {
                Some(places) => measures::of_places(&mut solver.flow, places, &self.edits),
                None => measures::of_optimum(&mut solver.flow, settings, &self.edits, surface),
            },
        };
        let set = set.map_err(|error| cone_problem(surface, &error))?;
        self.optimum = Some(solver.flow.state().clone());
        self.put(set);
        self.pictures += 1;
        Ok(())
    }
}

impl ConeSet {
    /// Whether the scale factors belong to these cones, and not to the curvature itself.
    pub fn is_of_cones(&self) -> bool {
        !self.cones.is_empty() || self.u.iter().any(|u| u.abs() > 0.0)
    }

    /// Cones, corners of the boundary left out.
    pub fn count(&self) -> usize {
        self.cones.iter().filter(|used| used.kind != ConeKind::Corner).count()
    }

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
