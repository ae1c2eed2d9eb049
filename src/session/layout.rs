//! The cut surface opened, flattened, measured and laid out: what pictures, tables and exports are made of.

use nalgebra::Point3;

use super::surface::Surface;
use super::text::plural;
use crate::flatten::{Flattening, Measures, Packing, bff, bff_with, measure, measures};
use crate::geometry::Geometry;
use crate::linalg::Factor;
use crate::mesh::{CutMesh, HalfedgeId, Mesh, OpenedMesh};
use crate::methods::cutgraph::cut_to_disks;
use crate::methods::flow::SolveError;
use crate::pattern::CutSurface;

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
    /// Patch of every opened vertex.
    pub vertex_patches: Vec<u32>,
}

impl Layout {
    /// Flattens a cut, after cutting its patches to disks.
    pub fn full(
        surface: &Surface,
        mut cut: CutMesh,
        previous: Option<&Packing>,
    ) -> Result<Self, SolveError> {
        let points = place(surface, &cut);
        let disks = cut_to_disks(&mut cut, &points)?;
        let geometry = measure_opened(&disks.opened, &points);
        let flattening = bff(&disks.opened, &geometry)?;
        Ok(Self::new(
            surface,
            cut,
            points,
            disks.opened,
            geometry,
            flattening,
            disks.length,
            previous,
        ))
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
        let geometry = measure_opened(&opened, &points);
        let flattening = bff_with(&opened, &geometry, factor)?;
        Ok(Self::new(surface, cut, points, opened, geometry, flattening, 0.0, previous))
    }

    #[expect(clippy::too_many_arguments, reason = "the two ways of making one")]
    fn new(
        surface: &Surface,
        cut: CutMesh,
        points: Vec<Point3<f64>>,
        opened: OpenedMesh,
        geometry: Geometry,
        flattening: Flattening,
        disk_cut_length: f64,
        previous: Option<&Packing>,
    ) -> Self {
        let measures = measure(&opened, &geometry, &flattening);
        let packing = flattening.pack(&opened, surface.mesh.vertex_count(), GAP, previous);
        let overlaps_across = measures::overlaps_across(&opened, &flattening, &packing);
        let charts = flattening.place(&opened, &packing).iter().map(|p| [p.x, p.y]).collect();
        let vertex_patches = opened.vertex_patches();
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
            vertex_patches,
        }
    }

    /// The cut surface as the writers of files take it. **Takes** the millimetres of one unit of the file, where they are known.
    pub fn surface<'a>(
        &'a self,
        surface: &'a Surface,
        mm_per_unit: Option<f64>,
    ) -> CutSurface<'a> {
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
        self.cut
            .cut_edges
            .iter()
            .map(|e| {
                let [a, b] = e.map(|p| self.points[p as usize]);
                (b - a).norm()
            })
            .sum()
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

fn place(surface: &Surface, cut: &CutMesh) -> Vec<Point3<f64>> {
    cut.points.iter().map(|&p| surface.geometry.locate(&surface.mesh, p)).collect()
}

fn measure_opened(opened: &OpenedMesh, points: &[Point3<f64>]) -> Geometry {
    let positions = opened.vertex_points.iter().map(|&p| points[p as usize]).collect();
    Geometry::measure(&opened.mesh, positions)
}
