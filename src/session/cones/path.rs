//! The optimum as a function of λ, sampled while there is time.

use std::rc::Rc;

use super::super::message::Event;
use super::Cones;
use super::table::ConePathPoint;
use crate::methods::cones::{ConeFields, ConeParams, ConePath, PathPoint};
use crate::methods::flow::SolveError;

/// The prices of the plot go down to this part of the largest that matters: below it hundreds of vertices are cones, and each sample costs more
/// than all before.
const LOWEST: f64 = 0.02;
const SAMPLES: usize = 25;
/// Nor do they go on once so many vertices are cones.
const MOST_CONES: usize = 150;

/// The sampling that is going on.
pub struct Tracing {
    path: ConePath,
}

/// The optimum over λ as far as it is known. Undo keeps it: clones share the problem.
#[derive(Clone, Default)]
pub struct KnownPath {
    /// λ descending.
    points: Vec<PathPoint>,
    /// Whether that is all of it.
    is_whole: bool,
    /// What it was sampled for; λ itself does not count.
    problem: Option<Rc<(ConeParams, ConeFields)>>,
}

impl KnownPath {
    /// Whether it holds for a problem; what holds nothing does.
    pub fn is_of(&self, params: &ConeParams, fields: &ConeFields) -> bool {
        self.problem.as_ref().is_none_or(|problem| {
            let (own, own_fields) = &**problem;
            ConeParams { lambda: params.lambda, ..*own } == *params && own_fields == fields
        })
    }

    /// How many points it has.
    pub fn len(&self) -> usize {
        self.points.len()
    }
}

impl Cones {
    /// Begins to sample the path.
    pub fn begin_path(&mut self) {
        // Both numbers are within their ranges.
        self.tracing = ConePath::new(SAMPLES, LOWEST, MOST_CONES).ok().map(|path| Tracing { path });
        let problem = self.solver.as_ref().map(|s| Rc::new((s.params, s.fields.clone())));
        self.path = KnownPath { problem, ..KnownPath::default() };
    }

    /// The path belongs to another problem.
    pub fn forget_path(&mut self) {
        self.abandon_path();
        self.path = KnownPath::default();
    }

    /// Ends a sampling that goes on; the solver is where it was.
    pub fn abandon_path(&mut self) {
        if let (Some(mut tracing), Some(solver)) = (self.tracing.take(), &mut self.solver) {
            tracing.path.abandon(&mut solver.flow);
        }
    }

    /// One bounded step of it. **Gives** whether there is a new point or an end to tell.
    pub fn trace(&mut self) -> Result<bool, SolveError> {
        let (Some(tracing), Some(solver)) = (&mut self.tracing, &mut self.solver) else {
            self.tracing = None;
            return Ok(true);
        };
        let before = tracing.path.points().len();
        let goes_on = !tracing.path.step(&mut solver.flow)?;
        let points = tracing.path.points();
        let is_news = points.len() != before || !goes_on;
        if is_news {
            self.path.points = points.to_vec();
        }
        if !goes_on {
            self.tracing = None;
            self.path.is_whole = true;
        }
        Ok(is_news)
    }

    /// The path as far as it is known, λ descending.
    pub fn path_points(&self) -> Vec<ConePathPoint> {
        let point = |p: &PathPoint| ConePathPoint {
            lambda: p.lambda,
            count: p.count,
            total_angle: p.total_angle,
            int_u2: p.int_u2,
        };
        self.path.points.iter().map(point).collect()
    }

    /// The same for the page.
    pub fn path_event(&self) -> Event {
        Event::ConePath { points: self.path_points(), is_complete: self.path.is_whole }
    }
}
