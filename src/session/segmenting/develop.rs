//! Developable patches at work.

use serde::Serialize;

use super::super::message::{Event, Row};
use super::super::surface::Surface;
use super::super::text::Problem;
use super::super::work::Work;
use super::report::not_divided;
use super::{DevelopReport, DevelopSeconds, Inputs, Segmentation};
use crate::mesh::CutMesh;
use crate::methods::flow::Status;

/// How patches come about, stage by stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DevelopTable {
    /// In their order.
    pub stages: Vec<DevelopStage>,
}

/// A stage in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DevelopStage {
    /// What a person calls it.
    pub label: String,
    /// Pieces after it, or so far.
    pub pieces: Option<usize>,
    /// Length of all seams then, √area = 1.
    pub seam: Option<f64>,
    /// Whether it goes on.
    pub is_active: bool,
}

#[derive(Default)]
pub struct Developable {}

#[derive(Clone)]
pub struct DevelopCheckpoint {}

impl Developable {
    pub fn checkpoint(&self) -> Option<DevelopCheckpoint> {
        None
    }
    pub fn put_back(&mut self, _: Option<DevelopCheckpoint>) {}
    pub fn keep(&mut self, _: Self) {}
    pub fn cut_start(&self) -> Option<crate::methods::cutflow::Initial> {
        None
    }
    pub fn stage(&self) -> Option<&'static str> {
        None
    }
}

impl Segmentation for Developable {
    fn prepare(&mut self, _: &Inputs) -> Result<bool, Problem> {
        Ok(false)
    }
    fn begin_again(&mut self) {}
    fn step(&mut self, _: &Inputs) -> Result<(), Problem> {
        Ok(())
    }
    fn steps(&self) -> usize {
        0
    }
    fn status(&self) -> Option<Status> {
        None
    }
    fn doing(&self) -> String {
        String::new()
    }
    fn labels(&self) -> Option<Vec<u32>> {
        None
    }
    fn cut(&self, _: &Surface) -> Result<Option<CutMesh>, Problem> {
        Ok(None)
    }
    fn curve(&self) -> &[Event] {
        &[]
    }
    fn rows(&self) -> Vec<Row> {
        Vec::new()
    }
    fn field(&self, _: &str) -> Option<Vec<f64>> {
        None
    }
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
    fn told(&self) -> Option<Event> {
        None
    }
}

impl Work {
    pub(in super::super) fn develop_report(
        &self,
        _: Option<DevelopSeconds>,
    ) -> Result<DevelopReport, Problem> {
        Err(not_divided(self))
    }
}
