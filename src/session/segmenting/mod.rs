//! Methods that part the surface by a flow of their own, phase fields and developable patches: what driving them has in common.
//!
//! Everything follows from parameters, painted layers and the flow's checkpoint, which is what Undo keeps.

mod develop;
mod driving;
mod hands;
mod phase;
mod report;
mod run;
mod specs;
mod tree;

use super::document::Document;
use super::inputs::Layers;
use super::layout::Layout;
use super::message::{Event, Row};
use super::method::Method;
use super::params::Settings;
use super::surface::Surface;
use super::text::Problem;
use super::work::Work;
use crate::mesh::CutMesh;
use crate::methods::flow::{SolveError, Status};

pub use develop::{DevelopCheckpoint, DevelopStage, DevelopTable, Developable};
pub use phase::{PhaseCheckpoint, PhaseField};
pub use report::{DevelopReport, DevelopSeconds, PhaseFieldReport};
pub use specs::{develop_specs, phase_specs};
pub use tree::{Segment, SegmentTree};

/// More patches than that are shown without charts while a flow runs: flattening them takes longer than its steps.
pub(super) const SHOWN_FLAT: usize = 48;

/// What a segmentation is asked for, and of what.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'a> {
    pub surface: &'a Surface,
    pub settings: &'a Settings,
    pub layers: &'a Layers,
}

impl<'a> Inputs<'a> {
    pub fn new(
        document: &'a Document,
        settings: &'a Settings,
        layers: &'a Layers,
    ) -> Result<Self, Problem> {
        Ok(Self { surface: document.surface()?, settings, layers })
    }
}

/// A method that parts the surface step by step.
pub(super) trait Segmentation {
    /// Sees to it that there is a flow, and that it knows the parameters and what was painted.
    ///
    /// **Gives** whether anything has changed.
    fn prepare(&mut self, inputs: &Inputs) -> Result<bool, Problem>;
    /// Forgets the flow.
    fn begin_again(&mut self);
    /// One step.
    fn step(&mut self, inputs: &Inputs) -> Result<(), Problem>;
    /// Steps so far.
    fn steps(&self) -> usize;
    /// How the flow stands; `None` without one.
    fn status(&self) -> Option<Status>;
    /// What it is doing, for the status line; may be empty.
    fn doing(&self) -> String;
    /// A label for each vertex, where there is a flow.
    fn labels(&self) -> Option<Vec<u32>>;
    /// The cut on the surface as it was given, where there is a flow.
    fn cut(&self, surface: &Surface) -> Option<CutMesh>;
    /// The objective and its terms so far.
    fn curve(&self) -> &[Event];
    /// Rows for the table of measures. **Takes** the layout at rest, if it is.
    fn rows(&self, layout: Option<&Layout>) -> Vec<Row>;
    /// One value for each vertex of a field; `None` for fields of others.
    fn field(&self, id: &str) -> Result<Option<Vec<f64>>, SolveError>;
    /// What a person should know.
    fn notes(&self) -> Vec<String>;
    /// What a panel of its own shows.
    fn told(&self) -> Option<Event>;
}

impl Work {
    /// The segmentation at work, if the method is one.
    pub(super) fn segmentation(&self) -> Option<&dyn Segmentation> {
        match self.method {
            Method::PhaseField => Some(&self.phase),
            Method::Developable => Some(&self.develop),
            Method::CutFlow | Method::Cones => None,
        }
    }

    /// The segmentation at work, to be changed, and what it is asked for.
    fn segmentation_mut(&mut self) -> Result<Option<(&mut dyn Segmentation, Inputs<'_>)>, Problem> {
        let inputs = Inputs::new(&self.document, &self.settings, &self.layers)?;
        Ok(match self.method {
            Method::PhaseField => Some((&mut self.phase, inputs)),
            Method::Developable => Some((&mut self.develop, inputs)),
            Method::CutFlow | Method::Cones => None,
        })
    }
}
