//! One patch, several methods, side by side: the paper's Table 1 \[LPFB\].
//!
//! The engine reads no clock: who wants times takes them around [`Compared::flatten`].

use super::lpfb::rim_errors;
use super::{Flattening, abf, dcp, lpfb, lscm, measure};
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{CutMesh, HalfedgeId, MeshError, OpenedMesh};
use crate::methods::cutgraph::cut_to_disks;

/// A method of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// Length-preserved free boundary and a fixed interior.
    Lpfb,
    /// Discrete conformal with natural boundary, spectral.
    Dcp,
    /// Least squares conformal.
    Lscm,
    /// Angle based flattening.
    Abf,
}

impl Compared {
    /// All of them, in the order of the table.
    pub const ALL: [Self; 4] = [Self::Lpfb, Self::Dcp, Self::Lscm, Self::Abf];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lpfb => "LPFB + interior",
            Self::Dcp => "DCP",
            Self::Lscm => "LSCM",
            Self::Abf => "ABF++",
        }
    }

    /// What the paper's table has a time for. **Takes** a surface that [`Specimen`] prepared.
    pub fn flatten(self, specimen: &Specimen) -> Result<Flattening, LinalgError> {
        let (opened, geometry) = specimen.for_method(self);
        match self {
            Self::Lpfb => Ok(lpfb(opened, geometry)?.0),
            Self::Dcp => dcp(opened, geometry),
            Self::Lscm => lscm(opened, geometry),
            Self::Abf => abf(opened, geometry),
        }
    }
}

/// A surface to be compared on.
#[derive(Clone, Debug)]
pub struct Specimen {
    opened: OpenedMesh,
    geometry: Geometry,
    /// With holes slit: all methods but one want disks.
    slit: Option<(OpenedMesh, Geometry)>,
}

/// One row of the table. All patches of a specimen together, weighted by area or by rim sides.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonRow {
    /// The method.
    pub method: Compared,
    /// Faces that have a chart.
    pub faces: usize,
    /// Sides of all rims.
    pub rim_sides: usize,
    /// Vertices of the opened surface.
    pub vertices: usize,
    /// Raw L² stretch.
    pub l2_stretch: f64,
    /// L² stretch times √(Σ A′ / Σ A).
    pub l2_stretch_normalized: f64,
    /// Σ (A′ − A) / Σ A, signed. 0 for LSCM, DCP and ABF++, whose charts are scaled to the area of their patches.
    pub area_change: f64,
    /// Σ |A′ − A| / Σ A.
    pub area_change_abs: f64,
    /// Π_L: mean of |l − l⁰| over rim sides, over their mean length.
    pub length_error: f64,
    /// Π_θ: mean of |θ − a| over rim corners, radians.
    pub angle_error: f64,
    /// Faces that are turned over.
    pub flipped: usize,
    /// Crossings of rims, or overlapping pairs.
    pub overlaps: usize,
}

impl Specimen {
    /// Prepares a surface. Patches with holes are slit for the methods that want disks, along the cuts of
    /// [`cut_to_disks`]; the slits then count as rims of theirs.
    pub fn new(opened: OpenedMesh, geometry: Geometry) -> Result<Self, MeshError> {
        let is_disk = |shape: &(i64, usize)| *shape == (1, 1);
        let slit = if opened.patch_shapes().iter().all(is_disk) {
            None
        } else {
            let mut cut = CutMesh::uncut(&opened.mesh);
            let disks = cut_to_disks(&mut cut, &geometry.positions)?;
            let places = disks
                .opened
                .vertex_points
                .iter()
                .map(|&p| geometry.positions[p as usize])
                .collect();
            let measured = Geometry::measure(&disks.opened.mesh, places);
            Some((disks.opened, measured))
        };
        Ok(Self { opened, geometry, slit })
    }

    /// The opened surface that a method works on, and its measures.
    pub fn for_method(&self, method: Compared) -> (&OpenedMesh, &Geometry) {
        match (&self.slit, method) {
            (None, _) | (_, Compared::Lpfb) => (&self.opened, &self.geometry),
            (Some((opened, geometry)), _) => (opened, geometry),
        }
    }

    /// What a method's charts are worth.
    pub fn row(&self, method: Compared, charts: &Flattening) -> ComparisonRow {
        let (opened, geometry) = self.for_method(method);
        let measures = measure(opened, geometry, charts);
        let mesh = &opened.mesh;
        let patches = opened.vertex_patches();
        let has_chart =
            |h: HalfedgeId| charts.charts[patches[mesh.tail(h).index()] as usize].is_ok();
        let loops: Vec<Vec<HalfedgeId>> = mesh
            .boundary_loops()
            .iter()
            .filter(|&&h| has_chart(h))
            .map(|&h| {
                let mut rim: Vec<_> = mesh.boundary_loop(h).map(HalfedgeId::twin).collect();
                rim.reverse();
                rim
            })
            .collect();
        let [length_error, angle_error] = rim_errors(opened, geometry, &charts.uv, &loops);
        let rim_sides = loops.iter().map(Vec::len).sum();
        let length: f64 = loops.iter().flatten().map(|h| geometry.edge_length(h.edge())).sum();
        let totals = measures.totals;
        ComparisonRow {
            method,
            faces: totals.faces,
            rim_sides,
            vertices: mesh.vertex_count(),
            l2_stretch: totals.l2_stretch,
            l2_stretch_normalized: totals.l2_stretch_normalized,
            area_change: totals.area_change,
            area_change_abs: totals.area_change_abs,
            length_error: length_error * rim_sides as f64 / length,
            angle_error,
            flipped: totals.flipped,
            overlaps: totals.overlaps,
        }
    }

    /// All rows, without times.
    pub fn compare(&self) -> Result<Vec<ComparisonRow>, LinalgError> {
        Compared::ALL
            .into_iter()
            .map(|method| Ok(self.row(method, &method.flatten(self)?)))
            .collect()
    }
}
