//! The classic volleyball: six sides of a cube, three parallel panels each.

use nalgebra::{Point3, Vector3};

use super::clusters::{absorb_small, colour, pieces};
use super::{Levels, Start, out_of_range};
use crate::geometry::Geometry;
use crate::mesh::Mesh;
use crate::methods::flow::SolveError;

/// Panels of the ball, and the number of labels that their copies on other surfaces are coloured with.
const PANELS: u32 = 18;

/// Least volume that three unit axes may span: with less they are no axes of a cube, not even of a sheared one.
const LEAST_VOLUME: f64 = 0.1;

/// Seen from the centre of area, each side of a cube is divided into three panels of equal angle. Panels of a side of axis
/// i run along axis i + 1: those of opposite sides are parallel, and each bar of a T meets the middle of the next side.
pub(super) fn volleyball(
    mesh: &Mesh,
    geometry: &Geometry,
    axes: &[Vector3<f64>; 3],
) -> Result<Start, SolveError> {
    let axes = axes.map(|a| a.try_normalize(1e-300).unwrap_or_else(Vector3::zeros));
    let volume = axes[0].cross(&axes[1]).dot(&axes[2]).abs();
    if !(volume >= LEAST_VOLUME) {
        return Err(out_of_range("volume of the volleyball's axes", volume, LEAST_VOLUME, 1.0));
    }
    let centre = centre_of_area(mesh, geometry);
    let least = 1e-3 * geometry.mean_edge_length();
    let (panels, magnitudes): (Vec<u32>, Vec<f64>) = geometry
        .positions
        .iter()
        .map(|p| {
            let arm = p - centre;
            let (panel, angle) = panel(axes.map(|a| a.dot(&arm)));
            (panel, (angle * arm.norm()).max(least))
        })
        .unzip();
    // On other shapes than balls a panel may fall into several pieces, some of them tiny.
    let (clusters, count) = pieces(mesh, &panels);
    let ends = absorb_small(mesh, geometry, &clusters, count);
    let clusters: Vec<u32> = clusters.iter().map(|&c| ends[c as usize]).collect();
    Ok(Start::new(colour(mesh, &clusters, PANELS), Levels::Vertex(magnitudes)))
}

/// The panel that a direction points to, and about the angle to the nearest border of it.
fn panel(direction: [f64; 3]) -> (u32, f64) {
    let size = direction.map(f64::abs);
    let axis = (0..3).fold(0, |best, i| if size[i] > size[best] { i } else { best });
    let angle = |i: usize| (direction[i] / size[axis].max(1e-300)).atan();
    let (along, across) = (angle((axis + 1) % 3), angle((axis + 2) % 3));
    let half = std::f64::consts::FRAC_PI_4;
    let third = half / 3.0;
    let stripe = u32::from(across > -third) + u32::from(across > third);
    let side = 2 * axis as u32 + u32::from(direction[axis] < 0.0);
    let to_side = half - along.abs().max(across.abs());
    let to_stripe = (across.abs() - third).abs();
    (3 * side + stripe, to_side.min(to_stripe).max(0.0))
}

fn centre_of_area(mesh: &Mesh, geometry: &Geometry) -> Point3<f64> {
    let mut sum = Vector3::zeros();
    for f in mesh.faces() {
        for v in mesh.face_vertices(f) {
            sum += geometry.positions[v.index()].coords * (geometry.face_areas[f.index()] / 3.0);
        }
    }
    Point3::from(sum / geometry.total_area().max(1e-300))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_of_a_side_run_across_those_of_its_neighbours() {
        let of = |x, y, z| panel([x, y, z]).0;
        // The side of x: three panels along y, told apart by z.
        assert_eq!(of(1.0, -0.9, 0.0), of(1.0, 0.9, 0.0));
        assert_ne!(of(1.0, 0.0, -0.9), of(1.0, 0.0, 0.0));
        assert_ne!(of(1.0, 0.0, 0.9), of(1.0, 0.0, 0.0));
        // The opposite side likewise, the side of y along z.
        assert_eq!(of(-1.0, -0.9, 0.5), of(-1.0, 0.9, 0.5));
        assert_eq!(of(0.0, 1.0, -0.9), of(0.0, 1.0, 0.9));
        assert_ne!(of(-0.9, 1.0, 0.0), of(0.0, 1.0, 0.0));
        assert_ne!(of(1.0, 0.0, 0.0), of(-1.0, 0.0, 0.0));
    }

    #[test]
    fn the_way_to_the_border_is_an_angle() {
        let middle = panel([0.0, 0.0, 2.0]).1;
        assert!((middle - std::f64::consts::PI / 12.0).abs() < 1e-12);
        assert!(panel([1.0, 1.0, 0.2]).1 < 1e-12, "on an edge of the cube");
    }
}
