//! How a document's cut is laid out flat: as it moves, at rest, and for those who only look.

use super::charting::{Charting, FlattenBy};
use super::layout::{Finish, Layout};
use super::method::Method;
use super::segmenting::SHOWN_FLAT;
use super::surface::Surface;
use super::text::Problem;
use super::work::Work;
use crate::mesh::CutMesh;

impl Work {
    /// The layout of a running flow: with the flow's own factor where all patches are disks, whole otherwise.
    pub fn preview(&mut self) -> Result<(), Problem> {
        if self.method == Method::Cones {
            // The charts of the cones before stay until there is time for new ones.
            return Ok(());
        }
        let surface = self.document.surface()?;
        let wrong = |error| Problem::solve(&surface.name, &error);
        if self.segmentation().is_some() {
            let layout = self.sketched(surface)?;
            self.put_layout(layout);
            return Ok(());
        }
        let packing = self.layout.as_ref().map(|l| &l.packing);
        // The flow's factor belongs to the triangles that it solves on.
        if let Some(flow) = self.flow.as_mut().filter(|_| surface.solving.is_none()) {
            let cut = flow.cut_mesh();
            let factor = flow.factor().map_err(|error| wrong(error.into()))?;
            let layout = Layout::preview(surface, cut, factor, packing).map_err(wrong)?;
            if layout.is_complete() {
                self.put_layout(layout);
                return Ok(());
            }
        }
        // Nothing is repaired while the cut moves: that would be another cut.
        let by = FlattenBy::Bff;
        let charting = Charting { by, splits: false, ..Charting::default() };
        let layout = Layout::full(surface, self.cut_mesh(surface), &charting, packing)
            .map_err(|error| error.problem(&surface.name))?;
        self.put_layout(layout);
        Ok(())
    }

    /// The pieces of a segmentation with charts as they come, or without where there are many.
    fn sketched(&self, surface: &Surface) -> Result<Layout, Problem> {
        let packing = self.layout.as_ref().map(|l| &l.packing);
        let by = FlattenBy::Bff;
        let charting = Charting { by, splits: false, ..Charting::default() };
        Layout::sketch(surface, self.cut_mesh(surface), &charting, SHOWN_FLAT, packing)
            .map_err(|error| error.problem(&surface.name))
    }

    /// A layout at rest for those who only look: whoever wants a pattern or a file has it made whole.
    pub fn sketch(&mut self) -> Result<(), Problem> {
        let layout = self.sketched(self.document.surface()?)?;
        // Allowances belong to the seams of the whole one.
        self.show(layout);
        (self.is_settled, self.is_sketched) = (true, true);
        Ok(())
    }

    fn put_layout(&mut self, layout: Layout) {
        // Seams of another cut have other numbers.
        if self.seam_edges != layout.cut.cut_edges {
            self.seam_allowances.clear();
            self.seam_edges.clone_from(&layout.cut.cut_edges);
        }
        self.show(layout);
    }

    /// A fold belongs to the layout that it was made of, and so does a refinement.
    fn show(&mut self, layout: Layout) {
        self.layout = Some(layout);
        self.drop_pattern();
        self.atlas = None;
        self.fold = None;
        self.refinement = None;
    }

    /// Whether the cut is that of developable pieces whose first borders are still being found.
    pub fn has_first_pieces_only(&self) -> bool {
        let is_first = self.develop.stage() == Some("vsa");
        self.method == Method::Developable && self.given.is_none() && is_first
    }

    pub fn settle(&mut self) -> Result<(), Problem> {
        let surface = self.document.surface()?;
        self.is_sketched = false;
        if self.method == Method::Cones {
            let packing = self.layout.as_ref().map(|l| &l.packing);
            let Some(set) = &self.cones.set else { return Ok(()) };
            let charting = Charting::of(&self.settings);
            let layout = Layout::of_cones(surface, set, &self.seam_cost(), &charting, packing)
                .map_err(|error| error.problem(&surface.name))?;
            self.put_layout(layout);
            self.is_settled = true;
            self.begin_refinement();
            return Ok(());
        }
        if self.method == Method::Developable
            && matches!(Charting::of(&self.settings).by, FlattenBy::Auto | FlattenBy::Lpfb)
            && let Some((cut, opened, flattening)) = self.develop.maps()
        {
            // The very maps that pieces were accepted with.
            let packing = self.layout.as_ref().map(|l| &l.packing);
            let layout = Layout::of_maps(surface, cut, opened, flattening, packing);
            self.put_layout(layout);
            self.is_settled = true;
            if self.start.is_none() {
                self.start = Some(self.rows());
            }
            self.begin_refinement();
            return Ok(());
        }
        // The whole layout takes the most memory of all: what it does not need makes room for it.
        if let Some(flow) = &mut self.flow {
            flow.rest();
        }
        let cut = self.cut_mesh(surface);
        let packing = self.layout.take().map(|layout| layout.packing);
        // Patches of triangles end at edges of the mesh as it is.
        let is_free = self.method != Method::Developable && self.given.is_none();
        let mut charting = Charting::of(&self.settings);
        // First pieces are often too far from flat for rims of true length.
        let is_nearly_flat = self.method == Method::Developable && !self.has_first_pieces_only();
        if is_nearly_flat && charting.by == FlattenBy::Auto {
            charting.by = FlattenBy::Lpfb;
        }
        let finish = Finish {
            straighten: is_free && self.settings.is_on("straighten"),
            snap: is_free && self.settings.is_on("snap"),
            pins: &self.layers.pin,
            charting,
        };
        let layout = Layout::finished(surface, cut, &finish, packing.as_ref())
            .map_err(|error| error.problem(&surface.name))?;
        self.put_layout(layout);
        self.is_settled = true;
        // Before there are patches the uncut surface is no start to compare with.
        if self.start.is_none() && self.method != Method::Developable {
            self.start = Some(self.rows());
        }
        self.begin_refinement();
        Ok(())
    }

    /// Cuts are finished another way: what was laid out is laid out anew, also what other methods show.
    pub fn finish_anew(&mut self) {
        self.is_settled = false;
        self.shelf.values_mut().for_each(|shelf| shelf.is_settled = false);
    }

    /// Flattens a cut as it is.
    pub fn lay_out(&mut self, cut: CutMesh) -> Result<(), Problem> {
        self.given = Some(cut);
        self.first_cut_is_due = false;
        self.settle()
    }
}
