//! Where a camera can be sent: straight views from six sides, a part of the surface, and the way there.

use super::{FIELD_OF_VIEW, FILL, MAX_PITCH, Orbit, SHEET_MARGIN, Sheet, Viewport};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// How much of the room a part is given when it is framed alone: what is around it stays in sight.
const PART_FILL: f32 = 0.72;
/// A part whose normals cancel to less than this fraction of its area has no side of its own to be looked at from.
const FACING: f32 = 0.25;

/// A side to look from, y up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// From +z.
    Front,
    /// From −z.
    Back,
    /// From −x.
    Left,
    /// From +x.
    Right,
    /// From +y.
    Top,
    /// From −y.
    Bottom,
}

impl Side {
    /// From what the page calls it.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "front" => Self::Front,
            "back" => Self::Back,
            "left" => Self::Left,
            "right" => Self::Right,
            "top" => Self::Top,
            "bottom" => Self::Bottom,
            _ => return None,
        })
    }

    /// Yaw and pitch.
    fn angles(self) -> [f32; 2] {
        match self {
            Self::Front => [0.0, 0.0],
            Self::Back => [PI, 0.0],
            Self::Left => [-FRAC_PI_2, 0.0],
            Self::Right => [FRAC_PI_2, 0.0],
            Self::Top => [0.0, MAX_PITCH],
            Self::Bottom => [0.0, -MAX_PITCH],
        }
    }
}

impl Orbit {
    /// Whether lines of sight are parallel.
    pub fn is_orthographic(&self) -> bool {
        self.is_orthographic
    }

    /// Parallel lines of sight, or those of an eye. What lies at the target's distance keeps its size.
    pub fn set_orthographic(&mut self, on: bool) {
        self.is_orthographic = on;
    }

    /// The unit direction in which the eye lies.
    pub fn towards_eye(&self) -> Vec3 {
        self.backward()
    }

    /// Turns to a side.
    pub fn look_from(&mut self, side: Side) {
        [self.yaw, self.pitch] = side.angles();
    }

    /// Frames a part of the surface, seen from where `normal`, the integral of its normals over an area of `area`, points.
    pub fn frame(
        &mut self,
        points: impl Iterator<Item = Vec3> + Clone,
        normal: Vec3,
        area: f32,
        viewport: Viewport,
    ) {
        let span = (Vec3::MAX, Vec3::MIN);
        let (low, high) = points.clone().fold(span, |(low, high), p| (low.min(p), high.max(p)));
        if !(low.cmple(high).all() && low.is_finite() && high.is_finite()) {
            return;
        }
        if normal.length() > FACING * area {
            let [x, y, z] = normal.normalize().to_array();
            // Straight up or down a turntable has no side: it keeps the one that it has.
            if x.hypot(z) > 0.05 {
                self.yaw = x.atan2(z);
            }
            self.pitch = y.clamp(-1.0, 1.0).asin().clamp(-1.3, 1.3);
        }
        self.target = (low + high) / 2.0;
        let slope = (FIELD_OF_VIEW / 2.0).tan() * FILL * PART_FILL;
        let slopes = Vec2::new(slope * viewport.aspect(), slope);
        let ((right, up), backward) = (self.axes(), self.backward());
        let near = if self.is_orthographic { 0.0 } else { 1.0 };
        let distance = points.map(|point| point - self.target).fold(1e-3, |distance: f32, off| {
            let off_axis = Vec2::new(off.dot(right), off.dot(up)).abs() / slopes;
            distance.max(off_axis.max_element() + near * off.dot(backward))
        });
        self.distance = distance.clamp(0.02 * self.home.1, 3.0 * self.home.1);
    }

    /// The camera at a part of the way from here to there, 0 to 1, with a soft start and end.
    pub fn towards(&self, there: &Self, part: f32) -> Self {
        let t = eased(part);
        // The shorter way around.
        let turn = (there.yaw - self.yaw + PI).rem_euclid(TAU) - PI;
        Self {
            target: self.target.lerp(there.target, t),
            yaw: self.yaw + turn * t,
            pitch: self.pitch + (there.pitch - self.pitch) * t,
            distance: self.distance * (there.distance / self.distance).powf(t),
            home: there.home,
            is_orthographic: there.is_orthographic,
        }
    }
}

impl Sheet {
    /// Frames a part of the sheet, `[x_min, y_min, x_max, y_max]`.
    pub fn frame(&mut self, bounds: [f32; 4], viewport: Viewport) {
        self.fit(bounds, viewport);
        let room = (viewport.size - 2.0 * SHEET_MARGIN).max(Vec2::ONE);
        self.scale *= PART_FILL * (room / viewport.size).min_element();
    }

    /// The sheet at a part of the way from here to there, 0 to 1, with a soft start and end.
    pub fn towards(&self, there: &Self, part: f32) -> Self {
        let t = eased(part);
        Self {
            center: self.center.lerp(there.center, t),
            scale: self.scale * (there.scale / self.scale).powf(t),
        }
    }
}

fn eased(part: f32) -> f32 {
    let t = part.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::super::Projection;
    use super::*;

    const VIEWPORT: Viewport = Viewport { size: Vec2::new(600.0, 400.0), scale: 2.0 };

    fn ball() -> impl Iterator<Item = Vec3> + Clone {
        (0..2000).map(|i| {
            let y = 1.0 - (i as f32 + 0.5) / 1000.0;
            let (sin, cos) = (i as f32 * 2.4).sin_cos();
            let radius = (1.0 - y * y).sqrt();
            Vec3::new(radius * cos, y, radius * sin)
        })
    }

    fn orbit(is_orthographic: bool) -> Orbit {
        let mut orbit = Orbit { is_orthographic, ..Orbit::default() };
        orbit.fit(ball(), VIEWPORT);
        orbit
    }

    fn ndc(projection: &Projection, point: Vec3) -> Vec3 {
        let clip = projection.world_to_clip * point.extend(1.0);
        clip.truncate() / clip.w
    }

    #[test]
    fn each_side_shows_its_axis_towards_the_eye_and_up_is_up() {
        let sides = [
            (Side::Front, Vec3::Z, Vec3::X, Vec3::Y),
            (Side::Back, Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y),
            (Side::Left, Vec3::NEG_X, Vec3::Z, Vec3::Y),
            (Side::Right, Vec3::X, Vec3::NEG_Z, Vec3::Y),
            (Side::Top, Vec3::Y, Vec3::X, Vec3::NEG_Z),
            (Side::Bottom, Vec3::NEG_Y, Vec3::X, Vec3::Z),
        ];
        for (side, towards, right, up) in sides {
            let mut orbit = orbit(true);
            orbit.look_from(side);
            assert!(orbit.towards_eye().distance(towards) < 1e-3, "{side:?}");
            let projection = orbit.projection(VIEWPORT);
            let middle = ndc(&projection, Vec3::ZERO);
            let [to_right, to_up] = [right, up].map(|axis| ndc(&projection, axis) - middle);
            assert!(to_right.x > 0.1 && to_right.y.abs() < 1e-3, "{side:?}: {to_right}");
            assert!(to_up.y > 0.1 && to_up.x.abs() < 1e-3, "{side:?}: {to_up}");
            assert!(ndc(&projection, towards).z < middle.z, "{side:?}");
        }
    }

    #[test]
    fn parallel_lines_of_sight_show_equal_lengths_equally_whatever_their_distance() {
        let mut orbit = orbit(true);
        orbit.look_from(Side::Front);
        let projection = orbit.projection(VIEWPORT);
        let width = |z: f32| {
            ndc(&projection, Vec3::new(0.4, 0.0, z)).x - ndc(&projection, Vec3::new(0.0, 0.0, z)).x
        };
        assert!((width(0.9) - width(-0.9)).abs() < 1e-6);
        // A length across as many device pixels as it should be, which is what lines are lifted by.
        let pixel = projection.pixel * projection.eye.length();
        let pixels = width(0.0) / 2.0 * VIEWPORT.size.x * VIEWPORT.scale;
        assert!((0.4 / pixel / pixels - 1.0).abs() < 0.02, "{pixels}");
        for point in ball() {
            let ndc = ndc(&projection, point);
            assert!(ndc.abs().max_element() <= 1.0 && ndc.z > 0.0, "{point} is out of sight");
        }
    }

    #[test]
    fn a_ray_of_a_parallel_view_meets_what_is_drawn_under_it_and_zooming_holds_it() {
        let mut orbit = orbit(true);
        orbit.rotate(Vec2::new(93.0, -41.0), VIEWPORT);
        orbit.pan(Vec2::new(-20.0, 33.0), VIEWPORT);
        let point = Vec3::new(0.3, -0.2, 0.4);
        let to_css = |orbit: &Orbit| {
            let ndc = ndc(&orbit.projection(VIEWPORT), point);
            (ndc.truncate() * Vec2::new(1.0, -1.0) + 1.0) / 2.0 * VIEWPORT.size
        };
        let css = to_css(&orbit);
        let ray = orbit.ray(css, VIEWPORT);
        let off = (point - ray.origin).reject_from(ray.direction.normalize()).length();
        assert!(off < 1e-5 && (point - ray.origin).dot(ray.direction) > 0.0, "off by {off}");
        let pivot = orbit.beside_target(css, VIEWPORT);
        orbit.zoom(1.8, pivot);
        assert!(to_css(&orbit).distance(css) < 0.05);
    }

    #[test]
    fn a_part_that_is_framed_fills_most_of_the_view_from_its_own_side() {
        for is_orthographic in [false, true] {
            let mut orbit = orbit(is_orthographic);
            let part = ball().filter(|p| p.x < -0.8);
            orbit.frame(part.clone(), Vec3::NEG_X * 2.0, 2.0, VIEWPORT);
            assert!(orbit.towards_eye().x < -0.99);
            let projection = orbit.projection(VIEWPORT);
            let most = part.map(|p| ndc(&projection, p).truncate().abs().max_element());
            let most = most.fold(0.0, f32::max);
            assert!(most < PART_FILL && most > PART_FILL * FILL - 0.05, "{most}");
        }
    }

    #[test]
    fn a_part_that_goes_around_keeps_the_direction_and_nothing_at_all_keeps_everything() {
        let mut orbit = orbit(false);
        let before = orbit;
        orbit.frame(ball(), Vec3::splat(0.01), 12.0, VIEWPORT);
        assert_eq!(orbit.towards_eye(), before.towards_eye());
        let framed = orbit;
        orbit.frame(std::iter::empty(), Vec3::X, 1.0, VIEWPORT);
        assert_eq!(orbit, framed);
    }

    #[test]
    fn a_flight_begins_here_ends_there_and_turns_the_shorter_way() {
        let (mut here, mut there) = (orbit(false), orbit(false));
        here.yaw = 0.2;
        there.yaw = TAU - 0.2;
        there.distance *= 0.25;
        assert!(here.towards(&there, 0.0).backward().distance(here.backward()) < 1e-6);
        assert!(here.towards(&there, 1.0).backward().distance(there.backward()) < 1e-6);
        let middle = here.towards(&there, 0.5);
        assert!(middle.backward().x.abs() < 1e-5 && middle.backward().z > 0.0);
        assert!((middle.distance / here.distance - 0.5).abs() < 1e-5, "halfway by ratio");
        let mut sheet = Sheet::default();
        sheet.frame([1.0, 1.0, 2.0, 3.0], VIEWPORT);
        let last = Sheet::default().towards(&sheet, 1.0);
        assert!(
            last.center.distance(sheet.center) < 1e-5
                && (last.scale / sheet.scale - 1.0).abs() < 1e-5
        );
    }
}
