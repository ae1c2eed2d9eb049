//! Overlapping charts with weights: an atlas whose textures blend into each other.
//!
//! A *partition of unity* gives each chart α a weight χ^α ≥ 0 at every vertex, Σ_α χ^α = 1. The domain of a chart is {χ^α > 0} grown to
//! whole faces; domains overlap where weights pass from one chart to the next. Each is flattened for itself by φ^α, and a texture f comes
//! back to the surface as Σ_α χ^α f(φ^α), without seams.
//!
//! 1. Weights that nobody would see are set to 0, components of a domain become charts of their own, crumbs among them that other
//!    charts cover are given up, and what is left at each vertex is divided by its sum.
//! 2. All domains together are one mesh that covers the surface several times: one [`cut_to_disks`], one flattening.
//! 3. Charts are turned and shifted onto each other where they overlap (see the source of `align`), so that patterns run on.
//!
//! A domain with holes or handles is cut open along a short graph. On that line the chart has two places for one point of the surface, and
//! its weight there is whatever it is: the texture has a seam, which [`AtlasNotice::CutOpen`] tells.
//!
//! Guaranteed: weights at every vertex of a face add up to 1 within 1e-14; every face lies in a chart; the same input gives the same
//! bits. Not guaranteed: that directions agree in overlaps, which curvature forbids; injective charts, which [`AtlasChart::validity`] tells.

mod align;
mod domain;

use nalgebra::{Complex, Point2, Point3};

use super::{
    ChartMeasures, ChartValidity, Flattening, NoChart, Packing, bff, lscm, measure, validate,
};
use crate::geometry::Geometry;
use crate::linalg::LinalgError;
use crate::mesh::{CutMesh, FaceId, Mesh, MeshError, OpenedMesh, VertexId};
use crate::methods::cutgraph::cut_to_disks;

use domain::Domain;

/// How charts are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtlasMethod {
    /// Boundary first flattening with isometric rims: overlaps lie at rims, where it keeps lengths.
    #[default]
    Bff,
    /// Least squares conformal maps, of the area of their domains.
    Lscm,
}

/// What an atlas leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtlasParams {
    /// How charts are made.
    pub method: AtlasMethod,
    /// Weights up to this count as 0. Below a step of eight bits (1/256) nobody sees them, but charts would grow to reach
    /// them, and larger charts are more distorted.
    pub least_weight: f64,
    /// A component whose share of the surface, ∫ χ / area, is below this is given up if other charts cover it.
    pub least_share: f64,
}

impl Default for AtlasParams {
    fn default() -> Self {
        Self { method: AtlasMethod::Bff, least_weight: 2e-3, least_share: 1e-3 }
    }
}

/// Why there is no atlas.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AtlasError {
    /// No chart, or a weight array of the wrong length.
    #[error("chart {chart} has {found} weights, the surface {expected} vertices")]
    Length {
        /// The chart.
        chart: usize,
        /// Its weights.
        found: usize,
        /// Vertices of the surface.
        expected: usize,
    },
    /// A weight that is negative, infinite or NaN.
    #[error("the weight of chart {chart} at vertex {} is {weight}", .vertex.0)]
    Weight {
        /// The chart.
        chart: usize,
        /// The vertex.
        vertex: VertexId,
        /// Its weight.
        weight: f64,
    },
    /// Weights that do not add up to 1 within [`SLACK`].
    #[error("the weights at vertex {} add up to {sum}", .vertex.0)]
    NoPartition {
        /// The vertex.
        vertex: VertexId,
        /// The sum of its weights.
        sum: f64,
    },
    /// A parameter out of range.
    #[error("{name} is {value}, but must be from 0 to below 0.5")]
    Parameter {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The domains form no manifold: a bug, since domains of a manifold do.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// For lack of memory.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
}

/// Something to know of an atlas.
#[derive(Clone, Debug, PartialEq)]
pub enum AtlasNotice {
    /// All weights of a chart are 0, or too small to be seen.
    Vanished {
        /// The weight array.
        source: usize,
    },
    /// The domain of a weight array has several components, which became charts of their own.
    Parted {
        /// The weight array.
        source: usize,
        /// How many charts it has.
        charts: usize,
    },
    /// Components too small to be charts were given up; the others took their weight over.
    GaveUp {
        /// The weight array.
        source: usize,
        /// How many.
        components: usize,
        /// Their share of the surface, ∫ χ / area.
        share: f64,
    },
    /// The domain is no disk and was cut open: its texture has a seam there.
    CutOpen {
        /// The chart, an index into [`Atlas::charts`].
        chart: usize,
        /// Length of the cut.
        length: f64,
    },
    /// A chart could not be made.
    NoChart {
        /// The chart, an index into [`Atlas::charts`].
        chart: usize,
        /// Why.
        reason: NoChart,
    },
}

/// One chart of an atlas.
#[derive(Clone, Debug)]
pub struct AtlasChart {
    /// The weight array that it comes from; several charts may share one.
    pub source: usize,
    /// Faces of the surface that it covers, in increasing order.
    pub faces: Vec<FaceId>,
    /// The same faces in local vertices, corner by corner.
    pub triangles: Vec<[u32; 3]>,
    /// For each local vertex the vertex of the surface; along cuts several are copies of one.
    pub vertices: Vec<VertexId>,
    /// Place of each local vertex, in the unit of the positions, turned and shifted to agree with the neighbours; NaN without chart.
    pub uv: Vec<Point2<f64>>,
    /// Weight of each local vertex.
    pub weights: Vec<f64>,
    /// ∫ χ / area of the surface.
    pub share: f64,
    /// What the chart is worth; none without one.
    pub measures: Option<ChartMeasures>,
    /// Whether it folds or covers anything twice; none without chart.
    pub validity: Option<ChartValidity>,
}

/// Overlapping charts that cover a surface.
#[derive(Clone, Debug)]
pub struct Atlas {
    /// The charts, by source, then by first face.
    pub charts: Vec<AtlasChart>,
    /// All domains side by side as one opened surface; patch `i` is chart `i`.
    pub opened: OpenedMesh,
    /// Its flattening, aligned.
    pub flattening: Flattening,
    /// Root mean square distance of the places that two charts give the same point, weighted by χ^α χ^β: 0 if a texture fits as if
    /// there were one chart.
    pub misfit: f64,
    /// What there is to know.
    pub notices: Vec<AtlasNotice>,
}

/// How far sums of weights may be from 1 before they are no partition of unity: anything smaller is rounding of somebody who
/// computed in 32 bits, and is divided out.
pub const SLACK: f64 = 1e-5;

impl Atlas {
    /// Makes the charts of a partition of unity.
    ///
    /// **Takes** an array of weights for each chart, one for each vertex of the surface; any kind of weights, whatever they come from.
    /// Isolated vertices may have any.
    /// **Gives** charts that cover the surface. Their weights are the given ones up to what [`AtlasParams`] leaves out.
    /// **Fails** if the weights are no partition of unity. Charts that cannot be made say so one by one.
    /// **Costs** as flattening a surface of the size of all domains together.
    /// **From** [PF] §5, Fig. 5. **Differs**: charts are cut to disks where they are none, and aligned; the paper leaves each in a frame of
    /// its own, so that the lines of a texture cross where they blend.
    pub fn new(
        mesh: &Mesh,
        geometry: &Geometry,
        weights: &[Vec<f64>],
        params: &AtlasParams,
    ) -> Result<Self, AtlasError> {
        check(mesh, weights, params)?;
        let mut notices = Vec::new();
        let mut weights = visible(mesh, weights, params.least_weight);
        let domains = domain::domains(mesh, geometry, &mut weights, params, &mut notices);
        let sheet = Sheet::new(mesh, geometry, &domains)?;
        let mut flattening = match params.method {
            AtlasMethod::Bff => bff(&sheet.opened, &sheet.geometry)?,
            AtlasMethod::Lscm => lscm(&sheet.opened, &sheet.geometry)?,
        };
        let corners = sheet.corners(geometry, &domains, &weights);
        let misfit = align::align(&mut flattening, sheet.opened.vertex_patches(), &corners);
        let measures = measure(&sheet.opened, &sheet.geometry, &flattening).charts;
        let validity = validate(&sheet.opened, &flattening, None).charts;
        for (chart, length) in sheet.cut_lengths.iter().enumerate() {
            if let Some(length) = *length {
                notices.push(AtlasNotice::CutOpen { chart, length });
            }
            if let Err(reason) = flattening.charts[chart] {
                notices.push(AtlasNotice::NoChart { chart, reason });
            }
        }
        let mut charts = sheet.charts(&domains, &weights, &flattening);
        for ((chart, measures), validity) in charts.iter_mut().zip(measures).zip(validity) {
            (chart.measures, chart.validity) = (measures, validity);
        }
        Ok(Self { charts, opened: sheet.opened, flattening, misfit, notices })
    }

    /// Lays the charts side by side.
    ///
    /// **Takes** the gap between them. **Gives** the layout and, chart by chart, where its local vertices lie; NaN without chart.
    pub fn pack(&self, gap: f64) -> (Packing, Vec<Vec<Point2<f64>>>) {
        let packing = self.flattening.pack(&self.opened, 0, gap, None);
        let places = self.charts.iter().zip(&packing.poses);
        let places = places.map(|(chart, pose)| chart.uv.iter().map(|&p| pose.apply(p)).collect());
        let places = places.collect();
        (packing, places)
    }
}

/// For each vertex the array with the largest weight, the first of equal ones: the partition that is cut in place of blended.
///
/// **Takes** arrays as [`Atlas::new`] does.
pub fn largest_weights(weights: &[Vec<f64>], vertex_count: usize) -> Vec<u32> {
    let mut labels = vec![0; vertex_count];
    for (v, label) in labels.iter_mut().enumerate() {
        for chart in 1..weights.len() {
            if weights[chart][v] > weights[*label as usize][v] {
                *label = super::small(chart);
            }
        }
    }
    labels
}

fn check(mesh: &Mesh, weights: &[Vec<f64>], params: &AtlasParams) -> Result<(), AtlasError> {
    let range = 0.0..0.5;
    for (name, value) in
        [("least_weight", params.least_weight), ("least_share", params.least_share)]
    {
        if !range.contains(&value) {
            return Err(AtlasError::Parameter { name, value });
        }
    }
    let expected = mesh.vertex_count();
    if weights.is_empty() {
        return Err(AtlasError::Length { chart: 0, found: 0, expected });
    }
    for (chart, array) in weights.iter().enumerate() {
        if array.len() != expected {
            return Err(AtlasError::Length { chart, found: array.len(), expected });
        }
    }
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        let mut sum = 0.0;
        for (chart, array) in weights.iter().enumerate() {
            let weight = array[v.index()];
            if !(weight >= 0.0 && weight.is_finite()) {
                return Err(AtlasError::Weight { chart, vertex: v, weight });
            }
            sum += weight;
        }
        if (sum - 1.0).abs() > SLACK {
            return Err(AtlasError::NoPartition { vertex: v, sum });
        }
    }
    Ok(())
}

/// Weights without those that nobody would see. The largest of a vertex always stays.
fn visible(mesh: &Mesh, weights: &[Vec<f64>], least: f64) -> Vec<Vec<f64>> {
    let largest = largest_weights(weights, mesh.vertex_count());
    let keep = |chart: usize, v: usize, w: f64| w > least || largest[v] as usize == chart;
    let array = |(chart, array): (usize, &Vec<f64>)| {
        array.iter().enumerate().map(|(v, &w)| if keep(chart, v, w) { w } else { 0.0 }).collect()
    };
    weights.iter().enumerate().map(array).collect()
}

/// A corner of a face of the surface as one chart has it.
struct Corner {
    /// The chart.
    chart: u32,
    /// The vertex of the opened surface.
    vertex: u32,
    weight: f64,
}

/// The corners of one face of the surface, by chart, and its area.
struct Covered {
    area: f64,
    charts: Vec<[Corner; 3]>,
}

/// All domains as one surface, opened into disks.
struct Sheet {
    opened: OpenedMesh,
    geometry: Geometry,
    /// For each vertex of the opened surface the vertex of the surface.
    vertices: Vec<VertexId>,
    /// For each chart the length of the cut that made it a disk, if it was none.
    cut_lengths: Vec<Option<f64>>,
    /// For each chart its first face.
    first_faces: Vec<usize>,
}

impl Sheet {
    fn new(mesh: &Mesh, geometry: &Geometry, domains: &[Domain]) -> Result<Self, AtlasError> {
        let (mut triangles, mut points, mut point_charts) = (Vec::new(), Vec::new(), Vec::new());
        let mut first_faces = Vec::with_capacity(domains.len());
        for (chart, domain) in domains.iter().enumerate() {
            first_faces.push(triangles.len());
            let (local, vertices) = domain.surface(mesh);
            let before = super::small(points.len());
            triangles.extend(local.iter().map(|t| t.map(|v| v + before)));
            point_charts.resize(points.len() + vertices.len(), chart);
            points.extend(vertices);
        }
        let place = |v: &VertexId| geometry.positions[v.index()];
        let positions: Vec<Point3<f64>> = points.iter().map(place).collect();
        let mut cut = CutMesh::uncut(&Mesh::new(points.len(), &triangles)?);
        let disks = cut_to_disks(&mut cut, &positions)?;
        let mut cut_lengths = vec![None; domains.len()];
        for edge in disks.edges {
            let [a, b] = edge.map(|p| positions[p as usize]);
            *cut_lengths[point_charts[edge[0] as usize]].get_or_insert(0.0) += (b - a).norm();
        }
        let opened = disks.opened;
        let vertices: Vec<VertexId> =
            opened.vertex_points.iter().map(|&p| points[p as usize]).collect();
        let geometry = Geometry::measure(&opened.mesh, vertices.iter().map(place).collect());
        Ok(Self { opened, geometry, vertices, cut_lengths, first_faces })
    }

    /// For each face of the surface that several charts cover, its corners in each.
    fn corners(
        &self,
        geometry: &Geometry,
        domains: &[Domain],
        weights: &[Vec<f64>],
    ) -> Vec<Covered> {
        let mut covered: Vec<Vec<[Corner; 3]>> =
            geometry.face_areas.iter().map(|_| Vec::new()).collect();
        for (chart, (domain, &first)) in domains.iter().zip(&self.first_faces).enumerate() {
            for (i, &face) in domain.faces.iter().enumerate() {
                let corners = self.opened.mesh.face_vertices(FaceId::from(first + i));
                covered[face.index()].push(corners.map(|v| Corner {
                    chart: super::small(chart),
                    vertex: v.0,
                    weight: weights[domain.source][self.vertices[v.index()].index()],
                }));
            }
        }
        let with_area = covered.into_iter().zip(&geometry.face_areas);
        with_area
            .filter(|(charts, _)| charts.len() > 1)
            .map(|(charts, &area)| Covered { area, charts })
            .collect()
    }

    fn charts(
        &self,
        domains: &[Domain],
        weights: &[Vec<f64>],
        flattening: &Flattening,
    ) -> Vec<AtlasChart> {
        let mut numbers = vec![u32::MAX; self.vertices.len()];
        let mut charts = Vec::with_capacity(domains.len());
        for (domain, &first) in domains.iter().zip(&self.first_faces) {
            let mut copies: Vec<usize> = Vec::new();
            let mut triangles = Vec::with_capacity(domain.faces.len());
            for i in 0..domain.faces.len() {
                triangles.push(self.opened.mesh.face_vertices(FaceId::from(first + i)).map(|v| {
                    let number = &mut numbers[v.index()];
                    if *number == u32::MAX {
                        *number = super::small(copies.len());
                        copies.push(v.index());
                    }
                    *number
                }));
            }
            let vertices: Vec<VertexId> = copies.iter().map(|&v| self.vertices[v]).collect();
            charts.push(AtlasChart {
                source: domain.source,
                faces: domain.faces.clone(),
                triangles,
                uv: copies.iter().map(|&v| flattening.uv[v]).collect(),
                weights: vertices.iter().map(|v| weights[domain.source][v.index()]).collect(),
                vertices,
                share: domain.share,
                measures: None,
                validity: None,
            });
        }
        charts
    }
}

/// A place as a complex number.
fn complex(p: Point2<f64>) -> Complex<f64> {
    Complex::new(p.x, p.y)
}
