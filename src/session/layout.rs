//! The cut surface opened, flattened, measured and laid out: what pictures, tables and exports are made of.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::rc::Rc;

use nalgebra::Point3;

use super::charting::{ChartError, Charted, Charting, ConeMetric, Made, Patches, measure_opened};
use super::cones::ConeSet;
use super::report::RefinedReport;
use super::surface::Surface;
use super::text::plural;
use crate::flatten::{Flattening, Measures, Packing, bff_with, measure, measures};
use crate::geometry::Geometry;
use crate::linalg::Factor;
use crate::mesh::{CutMesh, HalfedgeId, Mesh, OpenedMesh};
use crate::methods::cones::Cone;
use crate::methods::cutgraph::{Seams, cut_through, cut_to_disks, part_sectors};
use crate::methods::flow::SolveError;
use crate::methods::straighten::{StraightenParams, Unchanged, finish_cut, snap_to_edges};
use crate::pattern::{CutSurface, UvPackParams};

/// Free space between charts, √area = 1.
const GAP: f64 = 0.02;

/// Everything flat about one cut.
pub struct Layout {
    /// The mesh refined along the cut, added disk cuts included.
    pub cut: CutMesh,
    /// Where its points lie, unit area.
    pub points: Vec<Point3<f64>>,
    /// Opened.
    pub opened: OpenedMesh,
    /// Measured.
    pub geometry: Geometry,
    /// Charts.
    pub flattening: Flattening,
    /// What they are worth.
    pub measures: Measures,
    /// Where they lie.
    pub packing: Packing,
    /// Every opened vertex on the sheet, √area = 1; NaN without chart.
    pub charts: Vec<[f64; 2]>,
    /// Crossings between different charts on the sheet.
    pub overlaps_across: usize,
    /// Length of the cuts added to make disks.
    pub disk_cut_length: f64,
    /// How the charts came about.
    pub made: Made,
    /// What evening them out did.
    pub refined: Option<RefinedReport>,
    /// Patch of every opened vertex.
    pub vertex_patches: Vec<u32>,
    /// What a person should know of how the cut was finished.
    pub notice: Option<String>,
    /// The charts in the unit square of a texture, once a file asked for them.
    pub uv: Option<(UvPackParams, Rc<Vec<[f64; 2]>>)>,
}

/// How a cut at rest is finished.
#[derive(Clone, Copy, Debug, Default)]
pub struct Finish<'a> {
    /// Whether zigzag is taken out.
    pub straighten: bool,
    /// Whether the cut has to run along edges of the mesh.
    pub snap: bool,
    /// How firmly vertices hold the cut beside them; empty for not at all.
    pub pins: &'a [f64],
    /// How charts are made.
    pub charting: Charting,
}

impl Layout {
    /// Flattens a cut, after cutting its patches to disks.
    pub fn full(
        surface: &Surface,
        mut cut: CutMesh,
        charting: &Charting,
        previous: Option<&Packing>,
    ) -> Result<Self, ChartError> {
        let points = place(surface, &cut);
        let disks = cut_to_disks(&mut cut, &points)?;
        Self::whole(surface, cut, points, disks.opened, disks.length, charting, previous)
    }

    /// Takes charts that are there already.
    pub fn of_maps(
        surface: &Surface,
        cut: CutMesh,
        opened: OpenedMesh,
        flattening: Flattening,
        previous: Option<&Packing>,
    ) -> Self {
        let points = place(surface, &cut);
        let geometry = measure_opened(&opened, &points);
        let made = Made { method: "lpfb", ..Made::default() };
        let charted = Charted { cut, points, opened, geometry, flattening, made };
        Self::new(surface, charted, 0.0, previous)
    }

    /// A cut that moves on at once: with charts if it has at most so many patches, without if it has more.
    pub fn sketch(
        surface: &Surface,
        cut: CutMesh,
        charting: &Charting,
        most: usize,
        previous: Option<&Packing>,
    ) -> Result<Self, ChartError> {
        let opened = cut.open()?;
        if opened.patch_count <= most {
            return Self::full(surface, cut, charting, previous);
        }
        let points = place(surface, &cut);
        let geometry = measure_opened(&opened, &points);
        let flattening = Flattening::waiting(&opened);
        let made = Made { method: "none", ..Made::default() };
        let charted = Charted { cut, points, opened, geometry, flattening, made };
        Ok(Self::new(surface, charted, 0.0, previous))
    }

    /// Flattens a cut at rest: finished, with its patches cut to disks.
    ///
    /// A straighter cut is taken only if its charts have no more turned-over triangles than those of the cut as it was.
    pub fn finished(
        surface: &Surface,
        cut: CutMesh,
        finish: &Finish,
        previous: Option<&Packing>,
    ) -> Result<Self, ChartError> {
        let (mesh, geometry) = (&surface.mesh, &surface.geometry);
        let charting = &finish.charting;
        if finish.snap && !cut.cut_edges.is_empty() {
            let snapped = snap_to_edges(mesh, geometry, &cut)?;
            let mut result = Self::full(surface, snapped.cut, charting, previous)?;
            if !snapped.lost.is_empty() {
                result.tell(&format!(
                    "Snapping to mesh edges lost {}: {} too narrow for the triangles there.",
                    plural(snapped.lost.len(), "piece"),
                    if snapped.lost.len() == 1 { "it is" } else { "they are" },
                ));
            } else if !snapped.keeps_shapes {
                result.tell("Snapping to mesh edges changed the shape of a piece.");
            }
            return Ok(result);
        }
        if !finish.straighten {
            return Self::full(surface, cut, charting, previous);
        }
        let mut rough = cut.clone();
        let held = rough.cut_edges.len();
        let points = place(surface, &rough);
        let disks = cut_to_disks(&mut rough, &points)?;
        let params = StraightenParams::default();
        let straight = finish_cut(mesh, geometry, &rough, held, &params, finish.pins)?;
        let as_it_was = |rough, points, notice: Option<String>| -> Result<Self, ChartError> {
            let (opened, length) = (disks.opened, disks.length);
            let mut whole =
                Self::whole(surface, rough, points, opened, length, charting, previous)?;
            if let Some(notice) = notice {
                whole.tell(&notice);
            }
            Ok(whole)
        };
        if let Some(reason) = straight.unchanged {
            let notice = (reason != Unchanged::NoCut)
                .then(|| format!("The outlines were left as they were: {reason}."));
            return as_it_was(rough, points, notice);
        }
        let straight_points = place(surface, &straight.cut);
        let length = length_of(&straight.cut.cut_edges[straight.free_from..], &straight_points);
        let opened = straight.cut.open()?;
        let result = Self::whole(
            surface,
            straight.cut,
            straight_points,
            opened,
            length,
            charting,
            previous,
        )?;
        if result.flips() > 0 {
            let before = as_it_was(rough, points, None)?;
            if before.flips() < result.flips() {
                return Ok(before);
            }
        }
        Ok(result)
    }

    /// Flattens with the scale factors of cones along seams that join them.
    ///
    /// **Takes** what seams cost at each vertex beyond their length; empty for nothing.
    pub fn of_cones(
        surface: &Surface,
        set: &ConeSet,
        seam_cost: &[f64],
        charting: &Charting,
        previous: Option<&Packing>,
    ) -> Result<Self, ChartError> {
        let (mesh, geometry) = (&surface.mesh, &surface.geometry);
        let cones: Vec<Cone> = set.cones.iter().map(|used| used.cone).collect();
        let metric = ConeMetric { cones, u: &set.u };
        let chart = |seams: &Seams| {
            let (cut, opened) = (seams.cut.clone(), seams.opened.clone());
            let points = place(surface, &cut);
            Patches { mesh, cut, points, opened, seam_cost }.chart(charting, Some(&metric))
        };
        let seams = cut_through(mesh, geometry, &set.vertices(), seam_cost)?;
        let mut charted = chart(&seams)?;
        if charted.made.charts_added > 0 {
            // About a cone with more than a full turn, what seams leave together in one sector overlaps for certain.
            let angles: Vec<_> = metric.cones.iter().map(|c| (c.vertex, c.angle)).collect();
            let parted = part_sectors(mesh, geometry, &seams, &angles, seam_cost)?;
            // What there is already is good without.
            if let Ok(other) = chart(&parted.seams)
                && other.opened.patch_count < charted.opened.patch_count
                && other.made.cut_out <= charted.made.cut_out
            {
                charted = other;
            }
        }
        Ok(Self::new(surface, charted, 0.0, previous))
    }

    fn whole(
        surface: &Surface,
        cut: CutMesh,
        points: Vec<Point3<f64>>,
        opened: OpenedMesh,
        disk_cut_length: f64,
        charting: &Charting,
        previous: Option<&Packing>,
    ) -> Result<Self, ChartError> {
        let patches = Patches { mesh: &surface.mesh, cut, points, opened, seam_cost: &[] };
        Ok(Self::new(surface, patches.chart(charting, None)?, disk_cut_length, previous))
    }

    /// Flattens the disks of a running flow with the factor that it has; other patches wait for their charts.
    pub fn preview(
        surface: &Surface,
        cut: CutMesh,
        factor: &mut Factor,
        previous: Option<&Packing>,
    ) -> Result<Self, SolveError> {
        let points = place(surface, &cut);
        let opened = cut.open()?;
        let positions = opened.vertex_points.iter().map(|&p| points[p as usize]).collect();
        let geometry = Geometry::measure_refined(&opened.mesh, positions, &surface.geometry, |f| {
            cut.undivided(&surface.mesh, f)
        });
        let flattening = bff_with(&opened, &geometry, factor)?;
        let made = Made { method: "bff", ..Made::default() };
        let charted = Charted { cut, points, opened, geometry, flattening, made };
        Ok(Self::new(surface, charted, 0.0, previous))
    }

    fn new(
        surface: &Surface,
        charted: Charted,
        disk_cut_length: f64,
        previous: Option<&Packing>,
    ) -> Self {
        let Charted { cut, points, opened, geometry, flattening, made } = charted;
        let measures = measure(&opened, &geometry, &flattening);
        let packing = flattening.pack(&opened, surface.mesh.vertex_count(), GAP, previous);
        let overlaps_across = measures::overlaps_across(&opened, &flattening, &packing);
        let charts = flattening.place(&opened, &packing).iter().map(|p| [p.x, p.y]).collect();
        let vertex_patches = opened.vertex_patches().to_vec();
        let notice = made.notice.clone();
        Self {
            cut,
            points,
            opened,
            geometry,
            flattening,
            measures,
            packing,
            charts,
            overlaps_across,
            disk_cut_length,
            made,
            refined: None,
            vertex_patches,
            notice,
            uv: None,
        }
    }

    /// Takes other charts of the same patches.
    pub fn refine(&mut self, surface: &Surface, flattening: Flattening, report: RefinedReport) {
        self.refined = Some(report);
        self.measures = measure(&self.opened, &self.geometry, &flattening);
        let own = surface.mesh.vertex_count();
        self.packing = flattening.pack(&self.opened, own, GAP, Some(&self.packing));
        self.overlaps_across = measures::overlaps_across(&self.opened, &flattening, &self.packing);
        let places = flattening.place(&self.opened, &self.packing);
        self.charts = places.iter().map(|p| [p.x, p.y]).collect();
        self.flattening = flattening;
        self.uv = None;
    }

    /// Adds a sentence to what a person should know.
    pub fn tell(&mut self, sentence: &str) {
        self.notice = Some(match self.notice.take() {
            Some(before) => format!("{before} {sentence}"),
            None => sentence.to_owned(),
        });
    }

    /// Triangles that are turned over, those that were cut out because nothing else helped included.
    fn flips(&self) -> usize {
        self.measures.totals.flipped + self.made.cut_out
    }

    /// The label of every patch: that of most of its vertices, by the flow's labels. Straightening may leave a vertex beside a cut on
    /// its other side.
    pub fn patch_labels(&self, labels: &[u32]) -> Vec<Option<u32>> {
        let mut votes: Vec<BTreeMap<u32, usize>> = vec![BTreeMap::new(); self.opened.patch_count];
        for (v, &label) in labels.iter().enumerate() {
            // The first copy of a vertex keeps its number.
            *votes[self.vertex_patches[v] as usize].entry(label).or_default() += 1;
        }
        let most = |votes: &BTreeMap<u32, usize>| {
            votes.iter().max_by_key(|(label, count)| (**count, Reverse(**label))).map(|(l, _)| *l)
        };
        votes.iter().map(most).collect()
    }

    /// The labels of the surface's vertices as this cut parts them.
    pub fn labels(&self, labels: &[u32]) -> Vec<u32> {
        let of_patches = self.patch_labels(labels);
        let label =
            |(v, &own): (usize, &u32)| of_patches[self.vertex_patches[v] as usize].unwrap_or(own);
        labels.iter().enumerate().map(label).collect()
    }

    /// The cut surface as the writers of files take it. **Takes** the millimetres of one unit of the file, where they are known.
    pub fn surface<'a>(&'a self, surface: &'a Surface, mm_per_unit: Option<f64>) -> CutSurface<'a> {
        CutSurface {
            soup: &surface.soup,
            soup_vertices: &surface.soup_vertices,
            face_polygons: &surface.face_polygons,
            mm_per_unit,
            mesh: &surface.mesh,
            cut: &self.cut,
            opened: &self.opened,
        }
    }

    /// Whether every patch has a chart.
    pub fn is_complete(&self) -> bool {
        self.flattening.charts.iter().all(Result::is_ok)
    }

    /// Crossings of outlines: with themselves and with each other.
    pub fn overlaps(&self) -> usize {
        self.measures.totals.overlaps + self.overlaps_across
    }

    /// What a person should know of a patch before using its chart.
    pub fn note(&self, patch: usize) -> Option<String> {
        let times = |n: usize| if n == 1 { "once".to_owned() } else { format!("{n} times") };
        match (&self.flattening.charts[patch], &self.measures.charts[patch]) {
            (Err(reason), _) => Some(format!("Not flattened: {reason}.")),
            (Ok(_), Some(m)) if m.flipped > 0 => {
                Some(format!("{} turned over.", plural(m.flipped, "triangle")))
            }
            (Ok(_), Some(m)) if m.overlaps > 0 => {
                Some(format!("The outline crosses itself {}.", times(m.overlaps)))
            }
            (Ok(_), _) => None,
        }
    }

    /// All notes, with their patches.
    pub fn notes(&self) -> impl Iterator<Item = (usize, String)> + '_ {
        (0..self.opened.patch_count).filter_map(|patch| Some((patch, self.note(patch)?)))
    }

    /// Length of all cuts, each counted once.
    pub fn cut_length(&self) -> f64 {
        // The sum of nothing is −0.
        length_of(&self.cut.cut_edges, &self.points) + 0.0
    }

    /// Area of each patch.
    pub fn patch_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.opened.patch_count];
        for (face, &patch) in self.opened.face_patches.iter().enumerate() {
            areas[patch as usize] += self.geometry.face_areas[face];
        }
        areas
    }

    /// Length of the cuts around each patch; a cut inside a patch counts with both sides.
    pub fn seam_lengths(&self) -> Vec<f64> {
        let mut lengths = vec![0.0; self.opened.patch_count];
        for (h, patch) in rim_halfedges(&self.opened) {
            if self.opened.partner(h).is_some() {
                lengths[patch as usize] += self.geometry.edge_length(h.edge());
            }
        }
        lengths
    }

    /// For each patch the patches across its seams.
    pub fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::new(); self.opened.patch_count];
        for (h, patch) in rim_halfedges(&self.opened) {
            let across = self.opened.partner(h).and_then(|p| self.opened.mesh.face(p));
            if let Some(f) = across {
                neighbours[patch as usize].push(self.opened.face_patches[f.index()]);
            }
        }
        for (patch, list) in neighbours.iter_mut().enumerate() {
            list.sort_unstable();
            list.dedup();
            list.retain(|&n| n as usize != patch);
        }
        neighbours
    }
}

/// The rim halfedges inside faces with their patches, in the order of the faces.
pub fn rim_halfedges(opened: &OpenedMesh) -> impl Iterator<Item = (HalfedgeId, u32)> + '_ {
    let mesh: &Mesh = &opened.mesh;
    mesh.faces().flat_map(move |f| {
        mesh.face_halfedges(f)
            .into_iter()
            .filter(|h| mesh.is_boundary_edge(h.edge()))
            .map(move |h| (h, opened.face_patches[f.index()]))
    })
}

/// Length of cut edges.
fn length_of(edges: &[[u32; 2]], points: &[Point3<f64>]) -> f64 {
    let length = |e: &[u32; 2]| {
        let [a, b] = e.map(|p| points[p as usize]);
        (b - a).norm()
    };
    edges.iter().map(length).sum()
}

fn place(surface: &Surface, cut: &CutMesh) -> Vec<Point3<f64>> {
    cut.points.iter().map(|&p| surface.geometry.locate(&surface.mesh, p)).collect()
}
