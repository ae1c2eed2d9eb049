//! Initial cuts: from a plane, a circle, curvature, chance, a click, a painted surface or a known design to labels and the
//! places where they meet.
//!
//! Guaranteed: one label for each vertex; the same for the same input; neighbouring clusters differ. Not guaranteed: that a
//! region is a disk, or survives the flow. What was left out is said: [`Start::lost`], [`Start::whole`].

#![expect(
    clippy::cast_possible_truncation,
    reason = "elements are numbered in 32 bits: `Mesh::new` refuses larger meshes"
)]

mod cells;
mod clusters;
mod curvature;
mod faces;
mod noise;
mod volleyball;

pub(super) use clusters::pieces;

use nalgebra::{Point3, Vector3};

use crate::geometry::{Geometry, geodesic_distances};
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;

pub(super) use noise::smooth_noise;
pub(in super::super) use noise::uniform;

/// Where a run starts. Places and lengths are those of the unit-area geometry.
#[derive(Clone, Debug, PartialEq)]
pub enum Initial {
    /// Two regions, on either side of a plane.
    Plane {
        /// A point of the plane.
        point: Point3<f64>,
        /// Its normal, of any length; region 0 lies behind it.
        normal: Vector3<f64>,
    },
    /// Two regions, inside (0) and outside a geodesic circle.
    Circle {
        /// Its centre.
        vertex: VertexId,
        /// Its geodesic radius.
        radius: f64,
    },
    /// Connected clusters of vertices whose normals differ from a seed's by less than an angle, coloured with a number of
    /// labels so that clusters near one another differ.
    NormalClusters {
        /// Largest angle to the seed's normal, radians.
        angle: f64,
        /// Number of labels.
        regions: u32,
    },
    /// Two regions: the sign of a function given at the vertices, region 0 where it is negative.
    Levels(Vec<f64>),
    /// One label for each vertex.
    Labels(Vec<u32>),
    /// One label for each vertex, and where they meet: for each vertex levels of the labels nearby, negative for its own, as
    /// distances, `entries[starts[v]..starts[v + 1]]`. What another method has found.
    LabelLevels {
        /// One label for each vertex.
        labels: Vec<u32>,
        /// Where each vertex's entries begin, and the end of all.
        starts: Vec<u32>,
        /// Labels with their levels.
        entries: Vec<(u32, f64)>,
    },
    /// Bands of equal area between level sets of smoothed mean curvature, labelled from hollow to convex; two of them are
    /// parted by the median. Pieces below 0.2 % of the area join the band around them.
    CurvatureLevels {
        /// Number of bands.
        regions: u32,
    },
    /// Geodesic Voronoi cells of well-spread random vertices, coloured like normal clusters.
    Random {
        /// Number of labels.
        regions: u32,
        /// Number of cells.
        cells: u32,
        /// Chooses among all such cuts.
        seed: u64,
    },
    /// Geodesic Voronoi cells of vertices, one label for each; the cut runs where distances are equal. A seed alone is the
    /// centre of a geodesic circle of radius 0.3, or of half the way to the farthest vertex if that is less.
    Seeds(Vec<VertexId>),
    /// One region for each face, by any number: islands of the texture map, groups, materials, paint. Labels are numbered
    /// in the order of those numbers.
    Faces(Vec<u32>),
    /// The 18 panels of a classic volleyball, seen from the centre of area: the six sides of a cube, three parallel panels
    /// each, which run along the next axis. Any surface takes it; one that bulges out of sight of the centre gets panels in
    /// several pieces, each a region of its own.
    Volleyball {
        /// Axes of the cube, of any length.
        axes: [Vector3<f64>; 3],
    },
}

/// Labels, and how far each vertex lies from the cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// One label for each vertex.
    pub labels: Vec<u32>,
    /// What was asked for and is not there: with [`Initial::Faces`] the number of every connected region of faces that was
    /// too narrow for a vertex, with [`Initial::Seeds`] a seed that coincides with another one.
    pub lost: Vec<u32>,
    /// The first vertex of every closed component that lies in one region as a whole: nothing cuts it.
    pub whole: Vec<VertexId>,
    levels: Levels,
}

/// Where a first cut crosses the edges.
#[derive(Clone, Debug, PartialEq)]
enum Levels {
    /// In the middle.
    Middle,
    /// As distances from the cut at each vertex say.
    Vertex(Vec<f64>),
    /// As level sets say: for each vertex, those of the labels nearby.
    Label { starts: Vec<u32>, entries: Vec<(u32, f64)> },
}

impl Start {
    fn new(labels: Vec<u32>, levels: Levels) -> Self {
        Self { labels, lost: Vec::new(), whole: Vec::new(), levels }
    }

    /// Labels with the cut in the middle of edges.
    pub(super) fn of_labels(labels: Vec<u32>) -> Self {
        Self::new(labels, Levels::Middle)
    }

    /// Two regions by the sign of a function.
    pub(super) fn of_levels(levels: Vec<f64>) -> Self {
        two_regions(levels)
    }

    /// Labels with level sets for each vertex: those of the labels nearby, `entries[starts[v]..starts[v + 1]]`.
    pub(super) fn of_entries(labels: Vec<u32>, starts: Vec<u32>, entries: Vec<(u32, f64)>) -> Self {
        Self::new(labels, Levels::Label { starts, entries })
    }

    /// φ_label at a vertex, negative for its own label: of the given function, or half an edge, which puts crossings at the
    /// middle of edges.
    pub(super) fn level(&self, v: VertexId, label: u32, mean_edge: f64) -> f64 {
        let sign = if self.labels[v.index()] == label { -1.0 } else { 1.0 };
        let size = match &self.levels {
            Levels::Middle => 0.5 * mean_edge,
            Levels::Vertex(distances) => distances[v.index()].abs(),
            Levels::Label { starts, entries } => {
                let range = starts[v.index()] as usize..starts[v.index() + 1] as usize;
                let known = entries[range].iter().find(|e| e.0 == label);
                // A vertex that went to a neighbouring cell contradicts its distances.
                known.map_or(0.5 * mean_edge, |e| (sign * e.1).max(1e-3 * mean_edge))
            }
        };
        sign * size
    }
}

/// The labels that an initial cut gives.
///
/// **Fails** if a plane has no normal, a radius, angle or number makes no sense, a vertex does not exist, an array has the
/// wrong length, or if one of the computed cuts cuts nothing.
pub fn initial_labels(
    mesh: &Mesh,
    geometry: &Geometry,
    initial: &Initial,
) -> Result<Start, SolveError> {
    let mut start = match initial {
        Initial::Plane { point, normal } => {
            let length = normal.norm();
            let Some(normal) = normal.try_normalize(1e-300) else {
                return Err(too_small("plane normal length", length, 0.0));
            };
            let levels = geometry.positions.iter().map(|p| (p - point).dot(&normal)).collect();
            two_regions(levels)
        }
        Initial::Circle { vertex, radius } => {
            if !(*radius > 0.0 && radius.is_finite()) {
                return Err(too_small("circle radius", *radius, 0.0));
            }
            check_vertex(mesh, *vertex)?;
            let distances = geodesic_distances(mesh, geometry, &[*vertex]);
            // Other components lie outside, far away but at a finite distance.
            two_regions(distances.into_iter().map(|d| d.min(1e3) - radius).collect())
        }
        Initial::NormalClusters { angle, regions } => {
            if !(*angle > 0.0 && *angle <= std::f64::consts::PI) {
                return Err(too_small("cluster angle", *angle, 0.0));
            }
            let clusters = clusters::normal_clusters(mesh, geometry, *angle);
            Start::new(clusters::colour(mesh, &clusters, *regions), Levels::Middle)
        }
        Initial::Levels(levels) => {
            if levels.len() != mesh.vertex_count() || !levels.iter().all(|x| x.is_finite()) {
                let name = "number of finite level-set values";
                return Err(too_small(name, levels.len() as f64, mesh.vertex_count() as f64));
            }
            two_regions(levels.clone())
        }
        Initial::Labels(labels) => {
            if labels.len() != mesh.vertex_count() {
                let name = "number of labels";
                return Err(too_small(name, labels.len() as f64, mesh.vertex_count() as f64));
            }
            Start::new(labels.clone(), Levels::Middle)
        }
        Initial::LabelLevels { labels, starts, entries } => {
            let (count, vertices) = (labels.len() as f64, mesh.vertex_count());
            let is_ordered = starts.len() == vertices + 1
                && starts.windows(2).all(|s| s[0] <= s[1])
                && starts[vertices] as usize <= entries.len();
            if labels.len() != vertices || !is_ordered {
                return Err(too_small("number of labels with levels", count, vertices as f64));
            }
            if !entries.iter().all(|e| e.1.is_finite()) {
                return Err(too_small("level", f64::NAN, f64::MIN));
            }
            Start::of_entries(labels.clone(), starts.clone(), entries.clone())
        }
        Initial::CurvatureLevels { regions } => {
            cuts_something(mesh, curvature::curvature_levels(mesh, geometry, *regions)?)?
        }
        Initial::Random { regions, cells, seed } => {
            cuts_something(mesh, cells::random(mesh, geometry, *regions, *cells, *seed)?)?
        }
        Initial::Seeds(seeds) => cuts_something(mesh, cells::seeds(mesh, geometry, seeds)?)?,
        Initial::Faces(regions) => cuts_something(mesh, faces::faces(mesh, geometry, regions)?)?,
        Initial::Volleyball { axes } => {
            cuts_something(mesh, volleyball::volleyball(mesh, geometry, axes)?)?
        }
    };
    start.whole = whole_components(mesh, &start.labels);
    Ok(start)
}

/// Regions of the two signs of a function.
fn two_regions(levels: Vec<f64>) -> Start {
    let labels = levels.iter().map(|&x| u32::from(x >= 0.0)).collect();
    Start::new(labels, Levels::Vertex(levels))
}

/// Refuses labels that are the same along every edge.
fn cuts_something(mesh: &Mesh, start: Start) -> Result<Start, SolveError> {
    let is_crossed = |e| {
        let [a, b] = mesh.edge_vertices(e).map(|v| start.labels[v.index()]);
        a != b
    };
    if mesh.edges().any(is_crossed) {
        Ok(start)
    } else {
        Err(SolveError::EmptyCut { vertices: mesh.vertex_count() })
    }
}

/// The first vertex of every closed component whose vertices all have one label.
fn whole_components(mesh: &Mesh, labels: &[u32]) -> Vec<VertexId> {
    let (components, count) = clusters::grow(mesh, |_, _| true);
    let mut firsts: Vec<Option<VertexId>> = vec![None; count];
    let mut is_whole = vec![true; count];
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        let component = components[v.index()] as usize;
        let first = *firsts[component].get_or_insert(v);
        is_whole[component] &=
            labels[first.index()] == labels[v.index()] && !mesh.is_boundary_vertex(v);
    }
    firsts.into_iter().zip(is_whole).filter(|(_, whole)| *whole).filter_map(|(v, _)| v).collect()
}

/// Refuses a vertex that no face has.
fn check_vertex(mesh: &Mesh, vertex: VertexId) -> Result<(), SolveError> {
    let vertices = mesh.vertex_count();
    if vertex.index() < vertices && mesh.halfedge(vertex).is_some() {
        Ok(())
    } else {
        Err(SolveError::NoSuchVertex { vertex, vertices })
    }
}

fn too_small(name: &'static str, value: f64, min: f64) -> SolveError {
    SolveError::Parameter { name, value, min, max: f64::MAX }
}

fn out_of_range(name: &'static str, value: f64, min: f64, max: f64) -> SolveError {
    SolveError::Parameter { name, value, min, max }
}
