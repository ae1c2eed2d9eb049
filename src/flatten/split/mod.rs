//! Charts that overlap themselves become several that do not.
//!
//! Where a chart covers a part of the plane twice, two *sheets* lie on each other: connected sets of faces that overlap others. The
//! shortest set of mesh edges that separates the two is a minimum cut of the dual graph, and in a disk it runs from rim to rim, so that
//! both parts are disks again. The two sheets that have most area in common are separated first; then the parts, until none overlaps
//! itself. Where a sheet lies on itself (a spiral, or a sector of more than 2π about a cone), the two faces that have most in common are
//! separated, each with the faces of the sheet that are clearly nearer to it.
//!
//! Parts keep their places in the plane: no new layout is needed, though they may move apart.
//!
//! Guaranteed: no two faces of a chart overlap afterwards, but for those that [`Split::left`] names; every part is a disk; the same
//! input gives the same cuts. Not guaranteed: the least number or length of cuts in all. A face that is turned over overlaps its
//! neighbours wherever one cuts: see [`Flips`].

mod pieces;

use crate::geometry::Geometry;
use crate::mesh::{CutMesh, FaceId, MeshError, OpenedMesh};

use super::overlap::{for_overlapping, orientation};
use super::validity::{FacePair, face_places};
use super::{Flattening, rims};
use crate::methods::cutgraph::cut_to_disks;
use nalgebra::Point2;
use pieces::Pieces;

/// What becomes of faces that are turned over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Flips {
    /// They stay; what they overlap in their neighbourhood (faces that share a corner with them) stays too, and is reported.
    #[default]
    Leave,
    /// They are cut out, and parts that are all turned over are mirrored. Charts become valid at the price of tiny pieces; faces without
    /// area stay.
    CutOut,
}

/// Options of [`split_overlaps`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SplitParams {
    /// Pairs of faces with less than this in common do not count, as a fraction of their chart's area in the plane. With 0, the two sides
    /// of a slit in a flat surface are separated where rounding has laid them on each other; much larger, and overlaps stay
    /// that a blade would meet: on a chart of a thousand edges' width, 1e-12 is a millionth of an edge.
    pub tolerance: f64,
    /// What becomes of faces that are turned over.
    pub flips: Flips,
    /// No more charts than this are added; what overlaps then is reported.
    pub most_added: usize,
}

impl Default for SplitParams {
    fn default() -> Self {
        Self { tolerance: 1e-12, flips: Flips::Leave, most_added: 500 }
    }
}

/// A face that is turned over or has no area in the plane, and what lies about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flip {
    /// The face.
    pub face: FaceId,
    /// The faces that share a corner with it, in increasing order.
    pub neighbourhood: Vec<FaceId>,
}

/// A flattening after [`split_overlaps`].
#[derive(Clone, Debug)]
pub struct Split {
    /// The cut, with the edges that were added last.
    pub cut: CutMesh,
    /// Opened along it; faces keep their numbers.
    pub opened: OpenedMesh,
    /// The charts: faces keep their places.
    pub flattening: Flattening,
    /// Edges added, as pairs of points.
    pub edges: Vec<[u32; 2]>,
    /// Their length on the surface.
    pub length: f64,
    /// How many charts there are more than before.
    pub added: usize,
    /// How many charts overlapped themselves.
    pub split: usize,
    /// Pairs of faces of one chart that overlap still: about flipped faces, or because no more cuts were allowed.
    pub left: Vec<FacePair>,
    /// The faces that are turned over still.
    pub flips: Vec<Flip>,
    /// Number and area of pairs below the tolerance.
    pub ignored: (usize, f64),
}

/// Splits charts until none overlaps itself.
///
/// **Takes** a cut, the surface opened along it with its measures, charts, and for each point of the cut how much a seam through it costs
/// beside its length (a path costs ∫ (1 + cost); empty for nothing). **Gives** the same charts with more cuts along edges of the
/// triangulation. Patches without chart stay as they are.
/// **Fails** never for a cut that was opened. **Costs** the pairs that overlap, and for each cut a maximum flow on the faces of its chart.
/// **See** [`super::validate`].
pub fn split_overlaps(
    cut: &CutMesh,
    opened: &OpenedMesh,
    geometry: &Geometry,
    flattening: &Flattening,
    cost: &[f64],
    params: &SplitParams,
) -> Result<Split, MeshError> {
    assert!(cost.is_empty() || cost.len() == cut.points.len());
    let mesh = &opened.mesh;
    let signs: Vec<f64> = mesh
        .faces()
        .map(|f| {
            let [a, b, c] = face_places(opened, &flattening.uv, f);
            if a.x.is_finite() { orientation(a, b, c) } else { f64::NAN }
        })
        .collect();
    let flips: Vec<Flip> = mesh
        .faces()
        .filter(|f| signs[f.index()] <= 0.0)
        .map(|face| Flip { face, neighbourhood: around(opened, face) })
        .collect();

    let about = flips_about(&flips, mesh.face_count());

    let point = |v: crate::mesh::VertexId| opened.vertex_points[v.index()] as usize;
    let price = |e| {
        let [a, b] = mesh.edge_vertices(e).map(|v| cost.get(point(v)).copied().unwrap_or(0.0));
        geometry.edge_length(e) * (1.0 + 0.5 * (a + b))
    };
    let mut pieces = Pieces::new(opened, geometry, mesh.edges().map(price).collect());
    let mut ignored = (0, 0.0);
    let mut left = Vec::new();
    let mut charts: Vec<Vec<FaceId>> = vec![Vec::new(); flattening.charts.len()];
    for f in mesh.faces().filter(|f| signs[f.index()].is_finite()) {
        charts[opened.face_patches[f.index()] as usize].push(f);
    }
    let mut split = 0;
    let mut room = params.most_added;
    for faces in charts.iter().filter(|faces| !faces.is_empty()) {
        let least =
            params.tolerance * faces.iter().map(|f| 0.5 * signs[f.index()].abs()).sum::<f64>();
        let mut pairs = Vec::new();
        for pair in pairs_of(opened, &flattening.uv, faces) {
            let [f, g] = pair.faces;
            if params.flips == Flips::Leave
                && about[f.index()].iter().any(|flip| about[g.index()].contains(flip))
            {
                left.push(pair);
            } else if pair.area > least {
                pairs.push(pair);
            } else {
                ignored.0 += 1;
                ignored.1 += pair.area;
            }
        }
        split += usize::from(!pairs.is_empty());
        if params.flips == Flips::CutOut {
            pieces.part_by(faces, |f| signs[f.index()] < 0.0);
        }
        left.extend(pieces.split(faces, pairs, &mut room));
    }

    let mut cut = cut.clone();
    let before = cut.cut_edges.len();
    let edge_points = |e| mesh.edge_vertices(e).map(|v| opened.vertex_points[v.index()]);
    cut.cut_edges.extend(pieces.cuts().map(edge_points));
    // The sum of nothing is −0.
    let mut length = pieces.cuts().fold(0.0, |sum, e| sum + geometry.edge_length(e));
    let mut now = cut.open()?;
    if cut.cut_edges.len() > before {
        let disks = part_to_disks(&now, opened, geometry)?;
        length += disks.1;
        if !disks.0.is_empty() {
            cut.cut_edges.extend(disks.0);
            now = cut.open()?;
        }
    }
    let flattening = carry(opened, flattening, &now, &signs, params.flips);
    let flips = flips
        .into_iter()
        .filter(|flip| {
            let [a, b, c] = face_places(&now, &flattening.uv, flip.face);
            !(orientation(a, b, c) > 0.0)
        })
        .collect();
    // Cuts between other faces may have parted them.
    left.retain(|pair| {
        let [p, q] = pair.faces.map(|f| now.face_patches[f.index()]);
        p == q
    });
    left.sort_unstable_by_key(|pair| pair.faces);
    Ok(Split {
        edges: cut.cut_edges[before..].to_vec(),
        cut,
        length,
        added: now.patch_count - opened.patch_count,
        split,
        opened: now,
        flattening,
        left,
        flips,
        ignored,
    })
}

/// The pairs of a chart's faces that overlap, in increasing order.
fn pairs_of(opened: &OpenedMesh, uv: &[Point2<f64>], faces: &[FaceId]) -> Vec<FacePair> {
    let triangles: Vec<_> = faces.iter().map(|&f| face_places(opened, uv, f)).collect();
    let mut pairs = Vec::new();
    for_overlapping(
        &triangles,
        |_, _| true,
        |pair| {
            let faces = pair.triangles.map(|t| faces[t as usize]);
            pairs.push(FacePair { faces, area: pair.area });
        },
    );
    pairs.sort_unstable_by_key(|pair| pair.faces);
    pairs
}

/// The faces that share a corner with a face.
fn around(opened: &OpenedMesh, face: FaceId) -> Vec<FaceId> {
    let mesh = &opened.mesh;
    let corners = mesh.face_vertices(face).into_iter();
    let mut faces: Vec<FaceId> =
        corners.flat_map(|v| mesh.outgoing(v)).filter_map(|h| mesh.face(h)).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.retain(|&f| f != face);
    faces
}

/// For each face the faces turned over that it is, or whose neighbourhood it is in, in increasing order.
fn flips_about(flips: &[Flip], faces: usize) -> Vec<Vec<FaceId>> {
    let mut about = vec![Vec::new(); faces];
    for flip in flips {
        for f in flip.neighbourhood.iter().chain([&flip.face]) {
            about[f.index()].push(flip.face);
        }
    }
    about
}

/// Cuts that make disks of the parts that are none, and their length. Patches that were none before stay as they are.
fn part_to_disks(
    now: &OpenedMesh,
    opened: &OpenedMesh,
    geometry: &Geometry,
) -> Result<(Vec<[u32; 2]>, f64), MeshError> {
    let shapes = now.patch_shapes();
    let old_shapes = opened.patch_shapes();
    let is_wanted = |f: FaceId| {
        let disk = (1, 1);
        shapes[now.face_patches[f.index()] as usize] != disk
            && old_shapes[opened.face_patches[f.index()] as usize] == disk
    };
    let faces: Vec<FaceId> = now.mesh.faces().filter(|&f| is_wanted(f)).collect();
    if faces.is_empty() {
        return Ok((Vec::new(), 0.0));
    }
    // A mesh of its own, whose points are vertices of the opened one.
    let mut positions = vec![nalgebra::Point3::origin(); now.mesh.vertex_count()];
    for &f in &faces {
        let old = opened.mesh.face_vertices(f);
        for (v, w) in now.mesh.face_vertices(f).into_iter().zip(old) {
            positions[v.index()] = geometry.positions[w.index()];
        }
    }
    let mut part = CutMesh {
        points: now.mesh.vertices().map(crate::mesh::SurfacePoint::Vertex).collect(),
        triangles: faces.iter().map(|&f| now.mesh.face_vertices(f).map(|v| v.0)).collect(),
        triangle_faces: faces,
        cut_edges: Vec::new(),
    };
    let disks = cut_to_disks(&mut part, &positions)?;
    let point = |v: u32| now.vertex_points[v as usize];
    Ok((disks.edges.iter().map(|edge| edge.map(point)).collect(), disks.length))
}

/// The charts by the vertices of a mesh that is opened further.
fn carry(
    opened: &OpenedMesh,
    flattening: &Flattening,
    now: &OpenedMesh,
    signs: &[f64],
    flips: Flips,
) -> Flattening {
    let mut uv = vec![Point2::new(f64::NAN, f64::NAN); now.mesh.vertex_count()];
    let mut u = vec![f64::NAN; now.mesh.vertex_count()];
    let mut charts = rims(now);
    let mut is_mirrored = vec![flips == Flips::CutOut; now.patch_count];
    for f in now.mesh.faces() {
        let patch = now.face_patches[f.index()] as usize;
        if let Err(reason) = flattening.charts[opened.face_patches[f.index()] as usize] {
            charts[patch] = Err(reason);
        }
        is_mirrored[patch] &= signs[f.index()] < 0.0;
    }
    for f in now.mesh.faces() {
        let old = opened.mesh.face_vertices(f);
        let patch = now.face_patches[f.index()] as usize;
        for (v, w) in now.mesh.face_vertices(f).into_iter().zip(old) {
            let place = flattening.uv[w.index()];
            let sign = if is_mirrored[patch] { -1.0 } else { 1.0 };
            uv[v.index()] = Point2::new(sign * place.x, place.y);
            u[v.index()] = flattening.u[w.index()];
        }
    }
    Flattening {
        charts,
        uv,
        u,
        seams_equal: flattening.seams_equal,
        angles_exact: flattening.angles_exact,
        closing: flattening.closing,
        residual: flattening.residual,
    }
}
