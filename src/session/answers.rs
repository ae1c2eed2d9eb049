//! What a session gives when it is asked: pictures, files, reports, charts.

use super::refining::Refinement;
use super::work::Pending;
use super::{
    ConesReport, CutReport, Document, Entry, File, HistoryRow, InfoReport, Layout, Method, Problem,
    Scene, Session, Work, cut_from_json, cut_from_uv, doctor, error_event, exporting, nothing_open,
    picture,
};

/// The export that holds everything.
const PROJECT: &str = "Project (JSON)";

/// Results side by side.
const COMPARISON: &str = "Comparison (CSV)";

/// All files that there are of a cut.
const ARCHIVE: &str = "All files (ZIP)";

impl Session {
    /// The newest picture, if there is one that was not taken yet. Made here, when somebody wants to see it.
    pub fn scene(&mut self) -> Option<Scene> {
        if !std::mem::take(&mut self.scene_is_new) {
            return None;
        }
        let work = self.work.as_mut()?;
        let is_uncut = work.layout.is_none() && !work.has_cut();
        if work.document.surface.is_none() || is_uncut || self.shown.is_some() {
            let scene = doctor::scene(&work.document, self.shown.as_deref(), work.revision);
            work.revision += 1;
            return Some(scene);
        }
        if !work.is_settled && work.has_cut() {
            match work.preview() {
                Ok(()) => self.late.push(work.measures()),
                Err(problem) => {
                    // The flow itself goes on; the picture stays the last one.
                    self.late.push(error_event(problem));
                    return None;
                }
            }
        }
        let values = match work.vertex_field(&self.field) {
            Ok(values) => values,
            Err(problem) => {
                self.late.push(error_event(problem));
                None
            }
        };
        self.late.extend(work.stage_numbers(&self.field));
        let layout = work.layout.as_ref()?;
        let surface = work.document.surface.as_ref()?;
        let labels = work.labels();
        let colours = picture::patch_colours(layout, &labels);
        let folded = work.fold.as_ref().map(|fold| fold.flow.positions());
        let field = values.as_deref().map(|values| picture::Painted::new(&self.field, values));
        let u = work.u();
        let is_heated = self.field == "u"
            && work.method == Method::CutFlow
            && work.settings.text("source") != "curvature";
        let mut scene = picture::scene(
            surface,
            layout,
            &colours,
            &u,
            if is_heated { picture::TEMPERATURE } else { &self.field },
            field,
            folded,
            work.revision,
        );
        if let Some(set) = work.cones.set.as_ref().filter(|_| work.method == Method::Cones) {
            picture::put_cones(&mut scene, surface, layout, set, folded);
        }
        let is_flat = folded.is_none();
        if is_flat && !self.is_running {
            scene.layers = work.atlas_layers();
        }
        work.revision += 1;
        Some(scene)
    }

    /// The bytes of an export, by the name of its menu item.
    pub fn export(&mut self, kind: &str) -> Result<File, Problem> {
        if kind == PROJECT {
            return self.project();
        }
        if kind == COMPARISON {
            return self.comparison_file();
        }
        if kind != exporting::MESH {
            self.settled()?;
        }
        let compared = self.compared_results();
        if kind == ARCHIVE {
            let mut files = vec![self.project()?];
            if !compared.is_empty() {
                files.push(self.comparison_file()?);
            }
            let Some(work) = &mut self.work else { return Err(nothing_open()) };
            work.compared = compared;
            return work.archive(files);
        }
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        work.compared = compared;
        work.export(kind)
    }

    /// The open document.
    pub fn document(&self) -> Option<&Document> {
        self.work.as_ref().map(|work| &*work.document)
    }

    /// The report of `cutflow info`.
    pub fn info_report(&self) -> Option<InfoReport> {
        self.document().map(InfoReport::new)
    }

    /// The report of `cutflow cut`. **Takes** the time that the driver measured.
    pub fn cut_report(&mut self, seconds: Option<f64>) -> Result<CutReport, Problem> {
        self.settled()?.cut_report(seconds)
    }

    /// The report of `cutflow cones`. **Takes** the time that the driver measured.
    pub fn cones_report(&mut self, seconds: Option<f64>) -> Result<ConesReport, Problem> {
        self.settled()?.cones_report(seconds)
    }

    /// λ_max of the cones at hand, solved for where only an estimate is known.
    pub fn find_lambda_max(&mut self) -> Result<f64, Problem> {
        self.settled()?.find_lambda_max()
    }

    /// The layout at rest, of the current cut.
    pub fn layout(&mut self) -> Result<&Layout, Problem> {
        self.settled()?.layout.as_ref().ok_or_else(nothing_open)
    }

    /// Lays out the very cut of a `cut.json`, without making it the start of a flow: what a pattern of it is made of.
    pub fn lay_out_cut(&mut self, name: &str, bytes: &[u8]) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let cut = cut_from_json(work.document.surface()?, name, bytes)?;
        work.lay_out(cut)?;
        let text = String::from_utf8_lossy(bytes).into_owned();
        self.log.push(Entry::LayOut { name: name.to_owned(), cut: text });
        Ok(())
    }

    /// Lays out the very UV seams of the mesh, along its edges: a flow that starts from them follows them within half an edge.
    pub fn lay_out_uv_seams(&mut self) -> Result<(), Problem> {
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        let cut = cut_from_uv(work.document.surface()?)?;
        work.lay_out(cut)?;
        self.log.push(Entry::LayOutUvSeams);
        Ok(())
    }

    /// Whether something waits that has to be done before a cut can be flattened whole.
    fn is_unsettled(&self) -> bool {
        let Some(work) = &self.work else { return false };
        let is_refined = work.refinement.as_ref().is_none_or(Refinement::is_over);
        let are_cones_due = work.method == Method::Cones && work.cones.is_unsettled();
        work.first_cut_is_due
            || work.pending != Pending::None
            || are_cones_due
            || !work.is_settled
            || work.is_sketched
            || !is_refined
    }

    /// The work with a cut that is flattened whole.
    pub(super) fn settled(&mut self) -> Result<&mut Work, Problem> {
        if self.is_unsettled() {
            self.log.push(Entry::Settle);
        }
        if self.first_cut_is_due() {
            let mut events = Vec::new();
            self.make_first_cut(&mut events);
            self.late.extend(events);
        }
        self.end_stroke();
        if self.is_behind() {
            let mut events = Vec::new();
            self.catch_up(&mut events)?;
            self.late.extend(events);
        }
        if self.method() == Method::Cones {
            self.settled_cones()?;
        }
        let Some(work) = &mut self.work else { return Err(nothing_open()) };
        if !work.is_settled || work.is_sketched {
            work.settle()?;
        }
        work.finish_refinement()?;
        Ok(work)
    }

    /// Labels of the mesh's vertices now.
    pub fn labels(&self) -> Vec<u32> {
        self.work.as_ref().map_or_else(Vec::new, Work::labels)
    }

    /// The running flow's energies so far.
    pub fn history(&self) -> &[HistoryRow] {
        self.work.as_ref().map_or(&[], |work| &work.history)
    }
}
