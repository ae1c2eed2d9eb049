//! The brush: the ring that shows where it lies, and the places that a stroke passes.
//!
//! Guaranteed: places of a stroke are in the order of the drag and nowhere further apart than a radius as long as
//! the surface under the drag is smooth, so that discs of that radius leave no gap. Not guaranteed: that the ring is what the
//! engine paints to the last triangle; it lies on the surface at that distance in space, the engine
//! decides what belongs to a dab.

use super::camera::{Projection, Ray};
use glam::{Vec2, Vec3};

/// Points of the ring. Half as many are a polygon to the eye where the ring fills the view.
const POINTS: usize = 64;
/// How far above the tangent plane rays to the surface start, in radii. Less misses the near side of a limb that is
/// as thick as the brush; more meets limbs beside it.
const HEIGHT: f32 = 0.8;
/// Distance along the drag at which the surface is looked at, in radii.
const LOOK: f32 = 0.2;
/// Distance of two dabs from which the later one is worth its price, in radii. Under a half a slow drag would flood the
/// engine; near one the edge of a stroke would be scalloped.
const SPACING: f32 = 0.5;
/// Looks along one movement of the pointer: more than a jump across the screen needs with a brush that can be seen.
const MOST: usize = 256;

/// The ring about a place: `POINTS` places on the surface, in the tangent plane where there is none under it.
///
/// `cast` gives the nearest place on a ray and its multiple of the direction.
pub fn ring(
    place: Vec3,
    normal: Vec3,
    radius: f32,
    mut cast: impl FnMut(Ray) -> Option<(f32, Vec3)>,
) -> Vec<Vec3> {
    let normal = normal.try_normalize().unwrap_or(Vec3::Y);
    let (across, along) = normal.any_orthonormal_pair();
    (0..POINTS)
        .map(|i| {
            let (sin, cos) = (i as f32 * std::f32::consts::TAU / POINTS as f32).sin_cos();
            let flat = place + radius * (cos * across + sin * along);
            let ray = Ray { origin: flat + HEIGHT * radius * normal, direction: -radius * normal };
            match cast(ray) {
                Some((distance, on_surface)) if distance <= 2.0 * HEIGHT + 0.2 => on_surface,
                _ => flat,
            }
        })
        .collect()
}

/// A drag of the brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    css: Vec2,
    /// Where its last dab lies.
    last: Option<Vec3>,
}

impl Stroke {
    /// Begins under a place of the screen.
    pub fn new(css: Vec2) -> Self {
        Self { css, last: None }
    }

    /// Moves on to `css`; gives the dabs that this adds, in order.
    ///
    /// `pixels` is the radius on the screen; `pick` says what lies under a place of it, and where.
    pub fn extend<P>(
        &mut self,
        css: Vec2,
        radius: f32,
        pixels: f32,
        mut pick: impl FnMut(Vec2) -> Option<(Vec3, P)>,
    ) -> Vec<P> {
        let from = std::mem::replace(&mut self.css, css);
        let looks = (from.distance(css) / (LOOK * pixels)).ceil();
        let looks = if looks.is_finite() { (looks as usize).clamp(1, MOST) } else { 1 };
        let mut dabs = Vec::new();
        for i in 1..=looks {
            let Some((place, picked)) = pick(from.lerp(css, i as f32 / looks as f32)) else {
                continue;
            };
            if self.last.is_none_or(|last| last.distance(place) >= SPACING * radius) {
                self.last = Some(place);
                dabs.push(picked);
            }
        }
        dabs
    }
}

/// CSS pixels that a length at `place` takes on the screen where it is seen straight on.
pub fn pixels(length: f32, place: Vec3, projection: &Projection, scale: f32) -> f32 {
    let unit = if projection.perspective { projection.eye.distance(place) } else { 1.0 };
    length / (projection.pixel * scale * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The unit ball, met from outside.
    fn cast(ray: Ray) -> Option<(f32, Vec3)> {
        let (a, b) = (ray.direction.length_squared(), ray.origin.dot(ray.direction));
        let root = b * b - a * (ray.origin.length_squared() - 1.0);
        let distance = (-b - root.max(0.0).sqrt()) / a;
        (root >= 0.0 && distance >= 0.0).then(|| (distance, ray.origin + distance * ray.direction))
    }

    #[test]
    fn the_ring_lies_on_the_surface_around_its_place() {
        let ring = ring(Vec3::Z, Vec3::Z * 3.0, 0.2, cast);
        assert_eq!(ring.len(), POINTS);
        for point in &ring {
            assert!((point.length() - 1.0).abs() < 1e-5, "{point} is not on the ball");
            assert!((point.truncate().length() - 0.2).abs() < 1e-5, "{point} is not on the ring");
        }
    }

    #[test]
    fn where_there_is_no_surface_the_ring_is_flat() {
        // As wide as the ball itself: its points pass beside.
        let ring = ring(Vec3::Z, Vec3::Z, 1.5, cast);
        assert!(ring.iter().all(|point| (point.z - 1.0).abs() < 1e-5));
    }

    /// A plane at one unit for a hundred pixels, with a gap from 300 to 400.
    fn plane(css: Vec2) -> Option<(Vec3, f32)> {
        let place = (css / 100.0).extend(0.0);
        (!(300.0..400.0).contains(&css.x)).then_some((place, place.x))
    }

    #[test]
    fn a_stroke_leaves_no_gap_and_no_crowd_however_the_pointer_jumps() {
        let radius = 0.1;
        for jumps in [1, 7, 400] {
            let mut stroke = Stroke::new(Vec2::ZERO);
            let mut dabs = stroke.extend(Vec2::ZERO, radius, 10.0, plane);
            for i in 1..=jumps {
                let css = Vec2::new(200.0 * i as f32 / jumps as f32, 0.0);
                dabs.extend(stroke.extend(css, radius, 10.0, plane));
            }
            assert!(dabs[0].abs() < 1e-6);
            assert!(2.0 - dabs[dabs.len() - 1] < radius, "the end is painted");
            for pair in dabs.windows(2) {
                let step = pair[1] - pair[0];
                // A look further than the spacing, and rounding.
                let most = (SPACING + LOOK) * radius;
                assert!(step >= SPACING * radius - 1e-5 && step <= most + 1e-5, "{jumps}: {step}");
            }
        }
    }

    #[test]
    fn a_stroke_goes_on_behind_a_gap_and_survives_nonsense() {
        let mut stroke = Stroke::new(Vec2::new(290.0, 0.0));
        let dabs = stroke.extend(Vec2::new(410.0, 0.0), 0.1, 10.0, plane);
        assert!(dabs.iter().all(|x| !(3.0..4.0).contains(x)));
        assert!(dabs.last().is_some_and(|x| *x >= 4.0));
        assert!(stroke.extend(Vec2::new(410.0, 0.0), 0.1, 0.0, plane).is_empty());
        // A radius of no known size on the screen: one look.
        assert!(stroke.extend(Vec2::new(500.0, 0.0), 0.1, f32::NAN, plane).len() == 1);
    }
}
