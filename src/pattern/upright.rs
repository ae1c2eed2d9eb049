//! Which way is up on a piece: how the direction of the model that runs along the grain lies in its chart.

use nalgebra::Vector2;

use super::laid::LaidSurface;

/// Below this share of what it could be, a mean direction is none: it points every way, as on a cap about the axis.
const FAINT: f64 = 0.02;

/// Turns that bring the pieces of all patches upright.
///
/// c is a coordinate of the model. Its mean gradient over a chart, Σ A ∇c, is the direction in which it grows; turned by the angle that is given, it
/// points along +y. Where it has none (a cap about the axis) the other two coordinates are asked in turn.
///
/// **Takes** the axis, 0, 1 or 2. **Gives** an angle in radians, counter-clockwise, for each patch; 0 without chart.
pub fn uprights(surface: &LaidSurface, axis: usize) -> Vec<f64> {
    let opened = surface.opened;
    let mut sums = vec![[(Vector2::zeros(), 0.0); 3]; opened.patch_count];
    for face in opened.mesh.faces() {
        let corners = opened.mesh.face_vertices(face);
        let [a, b, c] = corners.map(|v| Vector2::from(surface.charts[v.index()]));
        let doubled = (b - a).perp(&(c - a));
        if !(doubled.is_finite() && doubled > 0.0) {
            continue;
        }
        let places = corners.map(|v| surface.position(v));
        for (axis, (sum, size)) in
            sums[opened.face_patches[face.index()] as usize].iter_mut().enumerate()
        {
            // Twice the area times the gradient: Σ of values times the opposite sides, turned by a right angle.
            let gradient = [(0, c - b), (1, a - c), (2, b - a)]
                .map(|(i, side)| Vector2::new(-side.y, side.x) * places[i][axis])
                .iter()
                .sum::<Vector2<f64>>();
            *sum += gradient;
            *size += gradient.norm();
        }
    }
    let angle = |sums: &[(Vector2<f64>, f64); 3]| {
        let mut axes = (axis..axis + 3).map(|axis| sums[axis % 3]);
        // Of the model's directions in a flat sheet one at least is not faint.
        let found = axes.find(|(sum, size)| sum.norm() > FAINT * size && *size > 0.0);
        found.map_or(0.0, |(sum, _)| std::f64::consts::FRAC_PI_2 - sum.y.atan2(sum.x))
    };
    sums.iter().map(angle).collect()
}
