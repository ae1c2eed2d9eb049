//! Conformal maps of closed surfaces without handles to the unit sphere.
//!
//! Without the faces about one vertex the surface is a disk, which is flattened to a round one; the plane is the sphere without a
//! pole, where the vertex goes. The freedom that is left, Möbius transformations of the sphere, is used to bring the centre of mass of the
//! image, each vertex weighing its area on the surface, to the centre of the ball. That determines the map up to rotations.
//!
//! Guaranteed: unit vectors with their centre of mass in the centre. Faces that harmonic coordinates would turn over are mended by positive
//! weights. Not guaranteed: that the projection turns no thin or large face over, which is told; accuracy beside the pole, where a few
//! sides stand for a circle.

use nalgebra::{Matrix3, Point3, Vector3};
use robust::{Coord3D, orient3d};

use super::{Effort, Interior, RimTarget, TargetError, TargetSolver};
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, FaceId, Mesh, VertexId};

/// A surface on the unit sphere.
#[derive(Clone, Debug)]
pub struct SphereMap {
    /// Unit vectors, one for each vertex; z for isolated ones.
    pub positions: Vec<Vector3<f64>>,
    /// Length of the centre of mass, vertices weighing their areas.
    pub off_centre: f64,
    /// Faces whose corners do not run counter-clockwise seen from outside, told exactly.
    pub flipped: Vec<FaceId>,
    /// The vertex that became the pole of the projection.
    pub pole: VertexId,
    /// What was spent.
    pub effort: Effort,
}

/// Rounds of the centring: it converges quadratically from where half the area is on each side.
const ROUNDS: usize = 100;
/// How far from the centre of the ball the centre of mass may stay.
const CENTRED: f64 = 1e-12;

/// Maps a closed surface without handles to the unit sphere.
///
/// **Takes** one component. **Gives** faces counter-clockwise seen from outside, like the surface's. **Fails** for other surfaces, with
/// the numbers that say what they are.
/// **Costs** as [`TargetSolver::flatten`]. **From** [BFF] §6. **Differs**: the pole is the vertex with the best shaped
/// faces; centring by steps of hyperbolic translation.
pub fn flatten_sphere(mesh: &Mesh, geometry: &Geometry) -> Result<SphereMap, TargetError> {
    let topology = mesh.topology();
    let used = mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()).count();
    let euler = used as i64 - mesh.edge_count() as i64 + mesh.face_count() as i64;
    let boundary_loops = mesh.boundary_loops().len();
    let components = topology.components;
    if euler != 2 || boundary_loops != 0 || components != 1 {
        return Err(TargetError::NotASphere { euler, boundary_loops, components });
    }
    let pole = best_pole(mesh, geometry);
    // A mesh of its own without the pole's faces.
    let kept: Vec<_> = mesh.faces().filter(|&f| !mesh.face_vertices(f).contains(&pole)).collect();
    let whole = CutMesh::uncut(mesh);
    let rest = CutMesh {
        triangles: kept.iter().map(|&f| mesh.face_vertices(f).map(|v| v.0)).collect(),
        triangle_faces: kept,
        ..whole
    };
    // A pole that is joined to one vertex twice over leaves something that is no disk.
    let not_a_disk = super::NoChart::NotADisk { euler: euler - 1, boundary_loops: 1 };
    let opened = rest.open().map_err(|_| not_a_disk)?;
    let open_geometry = opened_measures(mesh, geometry, &opened.mesh);
    let mut solver = TargetSolver::new(&opened, &open_geometry, 0)?;
    let chart = solver.flatten(&RimTarget::Disk, Interior::Harmonic)?;
    let mut areas = geometry.vertex_dual_areas(mesh);
    let total: f64 = areas.iter().sum();
    areas.iter_mut().for_each(|a| *a /= total);

    // Half of the area on each side of the equator.
    let middle = chart.places.iter().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>()
        / chart.places.len() as f64;
    let mut radii: Vec<(f64, f64)> = solver
        .vertices()
        .iter()
        .zip(&chart.places)
        .map(|(v, p)| ((p.coords - middle).norm(), areas[v.index()]))
        .collect();
    radii.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = 0.0;
    let half = radii.iter().find(|(_, area)| {
        below += area;
        below >= 0.5
    });
    let radius = half.map_or(1.0, |(r, _)| *r).max(f64::MIN_POSITIVE);
    let mut positions = vec![Vector3::z(); mesh.vertex_count()];
    for (v, p) in solver.vertices().iter().zip(&chart.places) {
        let q = (p.coords - middle) / radius;
        let squared = q.norm_squared();
        // From the north pole to the plane the projection keeps orientation as seen from inside: the mirror image is seen from outside.
        positions[v.index()] = Vector3::new(q.x, -q.y, squared - 1.0).map(|x| x / (squared + 1.0));
        positions[v.index()].x *= 2.0;
        positions[v.index()].y *= 2.0;
    }
    let off_centre = centre(&mut positions, &areas);
    if !(off_centre < 1e-6) {
        return Err(TargetError::NotFinite);
    }
    let corner = |v: VertexId| positions[v.index()];
    let coord = |p: Vector3<f64>| Coord3D { x: p.x, y: p.y, z: p.z };
    let is_flipped = |f: &FaceId| {
        let [a, b, c] = mesh.face_vertices(*f).map(|v| coord(corner(v)));
        // Positive where the centre lies below the face.
        !(orient3d(a, b, c, coord(Vector3::zeros())) > 0.0)
    };
    let flipped = mesh.faces().filter(is_flipped).collect();
    Ok(SphereMap { positions, off_centre, flipped, pole, effort: chart.effort })
}

/// The vertex whose faces have the largest smallest angle.
fn best_pole(mesh: &Mesh, geometry: &Geometry) -> VertexId {
    let mut least = vec![f64::INFINITY; mesh.vertex_count()];
    for f in mesh.faces() {
        let angles = geometry.corner_angles[f.index()];
        let smallest = angles.into_iter().fold(f64::INFINITY, f64::min);
        for v in mesh.face_vertices(f) {
            least[v.index()] = least[v.index()].min(smallest);
        }
    }
    let mut best = VertexId(0);
    let mut most = f64::NEG_INFINITY;
    for v in mesh.vertices().filter(|&v| mesh.halfedge(v).is_some()) {
        if least[v.index()] > most {
            (best, most) = (v, least[v.index()]);
        }
    }
    best
}

/// The measures of a part of a surface whose vertices keep their numbers.
fn opened_measures(mesh: &Mesh, geometry: &Geometry, part: &Mesh) -> Geometry {
    let length = |e: crate::mesh::EdgeId| {
        let [a, b] = part.edge_vertices(e);
        let h = mesh.outgoing(a).find(|&h| mesh.tip(h) == b);
        h.map_or(0.0, |h| geometry.edge_length(h.edge()))
    };
    let from_lengths: Vec<f64> = part.edges().map(length).collect();
    let positions: Vec<Point3<f64>> = geometry.positions.clone();
    // Positions say more about slivers than lengths do, where they belong to them.
    let measured = Geometry::measure(part, positions.clone());
    let agree = measured
        .edge_lengths
        .iter()
        .zip(&from_lengths)
        .all(|(a, b)| (a - b).abs() <= 1e-12 * b.abs());
    if agree { measured } else { Geometry::from_lengths(part, positions, from_lengths) }
}

/// Moves points on the unit sphere by Möbius transformations until their centre of mass is the centre. **Gives** how far it is from there.
///
/// A step is the inversion p ↦ (1 − |c|²) (p + c) / |p + c|² + c, which maps the sphere to itself; to first order it moves p by
/// 2 (c − (c·p) p), so c solves 2 Σ m (1 − p pᵀ) c = −Σ m p.
fn centre(points: &mut [Vector3<f64>], weights: &[f64]) -> f64 {
    let mean = |points: &[Vector3<f64>]| -> Vector3<f64> {
        points.iter().zip(weights).map(|(p, m)| p * *m).sum()
    };
    let mut off = mean(points);
    for _ in 0..ROUNDS {
        if off.norm() <= CENTRED {
            break;
        }
        let spread: Matrix3<f64> = points
            .iter()
            .zip(weights)
            .map(|(p, m)| (Matrix3::identity() - p * p.transpose()) * (2.0 * m))
            .sum();
        let Some(inverse) = spread.try_inverse() else { break };
        let mut c = -(inverse * off);
        // Far from the end full steps overshoot: they must stay inside the ball, and gain.
        if c.norm() > 0.5 {
            c *= 0.5 / c.norm();
        }
        let mut gained = false;
        for _ in 0..30 {
            let moved: Vec<Vector3<f64>> = points.iter().map(|&p| inverted(p, c)).collect();
            let next = mean(&moved);
            if next.norm() < off.norm() {
                points.copy_from_slice(&moved);
                off = next;
                gained = true;
                break;
            }
            c *= 0.5;
        }
        if !gained {
            break;
        }
    }
    off.norm()
}

fn inverted(p: Vector3<f64>, c: Vector3<f64>) -> Vector3<f64> {
    let q = p + c;
    let image = q * ((1.0 - c.norm_squared()) / q.norm_squared()) + c;
    image / image.norm()
}
