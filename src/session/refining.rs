//! Evening out charts: a flow on the charts at rest, whose every step is a picture.

use super::charting::Charting;
use super::layout::Layout;
use super::message::Event;
use super::method::Method;
use super::outlines::Outline;
use super::report::RefinedReport;
use super::surface::Surface;
use super::text::Problem;
use super::work::Work;
use super::{Session, nothing_open};
use crate::flatten::isometric::{Distortion, IsometricFlow, IsometricParams};
use crate::mesh::{SurfacePoint, VertexId};
use crate::methods::flow::{Flow, SolveError, Status};

/// Steps after which charts rest whatever is left: nearly all of the stretch that can go has gone long before.
const STEPS: usize = 200;

/// Pins as strong as this hold.
const HELD: f64 = 0.5;

/// Why charts are not evened out, or no further.
fn untold(error: &SolveError) -> String {
    format!("Evening out ended early: {error}.")
}

/// Charts that are being evened out.
pub(super) struct Refinement {
    flow: IsometricFlow,
    energy: &'static str,
    before: f64,
    /// Whether there is more to do.
    pub is_running: bool,
}

impl Refinement {
    /// From the charts of a layout. **Takes** what is to be evened out (`none` or `dirichlet`) and how firmly vertices of
    /// the surface are pinned; empty for not at all. **Gives** nothing where nothing is asked for.
    pub fn begin(layout: &Layout, energy: &str, pins: &[f64]) -> Result<Option<Self>, SolveError> {
        let (energy, distortion) = match energy {
            "dirichlet" => ("dirichlet", Distortion::SymmetricDirichlet),
            _ => return Ok(None),
        };
        let params = IsometricParams { distortion, ..IsometricParams::default() };
        let (opened, geometry) = (&layout.opened, &layout.geometry);
        let mut flow = IsometricFlow::new(opened, geometry, &layout.flattening, params)?;
        let is_pinned = |&v: &usize| match layout.cut.points[opened.vertex_points[v] as usize] {
            SurfacePoint::Vertex(own) => pins.get(own.index()).is_some_and(|pin| *pin >= HELD),
            _ => false,
        };
        let starts = flow.starts().to_vec();
        let place = |v: usize| {
            let takes_part = starts[layout.vertex_patches[v] as usize].is_refined();
            let id = VertexId(u32::try_from(v).ok()?);
            takes_part.then(|| (id, flow.state().place(id)))
        };
        let held: Vec<_> =
            (0..opened.mesh.vertex_count()).filter(is_pinned).filter_map(place).collect();
        flow.set_pins(&held)?;
        let before = flow.state().energy().distortion;
        let is_running = flow.status() == Status::Running;
        Ok(Some(Self { flow, energy, before, is_running }))
    }

    /// One step; the layout follows. What goes wrong ends the run, and the charts stay as they are, which the layout tells.
    pub fn step(&mut self, surface: &Surface, layout: &mut Layout) {
        if let Err(error) = self.advance() {
            layout.tell(&untold(&error));
        }
        self.show(surface, layout);
    }

    /// Whether no step is left.
    pub fn is_over(&self) -> bool {
        self.flow.status() != Status::Running || self.flow.steps() >= STEPS
    }

    /// All steps that are left, after a pause too; the layout follows once.
    /// **Gives** whether there were any.
    pub fn finish(&mut self, surface: &Surface, layout: &mut Layout) -> bool {
        self.is_running = !self.is_over();
        if !self.is_running {
            return false;
        }
        while self.is_running {
            if let Err(error) = self.advance() {
                layout.tell(&untold(&error));
            }
        }
        self.show(surface, layout);
        true
    }

    fn advance(&mut self) -> Result<(), SolveError> {
        let report = self.flow.step();
        let goes_on = matches!(&report, Ok(report) if report.status == Status::Running);
        self.is_running = goes_on && self.flow.steps() < STEPS;
        report.map(|_| ())
    }

    fn show(&self, surface: &Surface, layout: &mut Layout) {
        let state = self.flow.state();
        let report = RefinedReport {
            energy: self.energy,
            steps: self.flow.steps(),
            before: self.before,
            after: state.energy().distortion,
            seam_difference: state.seam_difference(),
            seams_met: state.seam_difference() <= self.flow.params().seam_tolerance,
        };
        layout.refine(surface, self.flow.flattening(), report);
        if !self.is_running && !report.seams_met {
            layout.tell(&format!(
                "Evening out left both sides of a seam unequal by {:.2} %.",
                100.0 * report.seam_difference
            ));
        }
    }

    /// Steps made.
    pub fn steps(&self) -> usize {
        self.flow.steps()
    }
}

impl Work {
    /// Begins to even out charts at rest, if that is asked for. Where it cannot be done they stay as they are, which the layout tells.
    pub(super) fn begin_refinement(&mut self) {
        let Some(layout) = &mut self.layout else { return };
        // An outline that was asked for would not be kept.
        let is_shaped = self.method == Method::CutFlow
            && Charting::of(&self.settings).outline != Outline::TrueLength;
        let energy = if is_shaped { "none" } else { self.settings.text("refine") };
        match Refinement::begin(layout, energy, &self.layers.pin) {
            Ok(refinement) => {
                if let Some(refinement) = &refinement
                    && refinement.is_over()
                    && let Ok(surface) = self.document.surface()
                {
                    // There is nothing to even out, which the report says.
                    refinement.show(surface, layout);
                }
                self.refinement = refinement;
            }
            Err(error) => layout.tell(&untold(&error)),
        }
    }

    /// Evens out to the end.
    pub(super) fn finish_refinement(&mut self) -> Result<(), Problem> {
        if let (Some(refinement), Some(layout)) = (&mut self.refinement, &mut self.layout)
            && refinement.finish(self.document.surface()?, layout)
        {
            self.patterning = None;
        }
        Ok(())
    }
}

impl Session {
    pub(super) fn is_refining(&self) -> bool {
        let refinement = self.work.as_ref().and_then(|work| work.refinement.as_ref());
        !self.is_running && refinement.is_some_and(|refinement| refinement.is_running)
    }

    pub(super) fn refine_on(&mut self, events: &mut Vec<Event>) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let (Some(refinement), Some(layout)) = (&mut work.refinement, &mut work.layout) else {
            return Ok(());
        };
        let surface = work.document.surface()?;
        refinement.step(surface, layout);
        work.drop_pattern();
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        self.scene_is_new = true;
        events.push(work.measures());
        Ok(())
    }
}
