//! The two cameras: a turntable about the surface and a sheet seen from above.
//!
//! The page forwards pointer movements in CSS pixels; everything else about them is decided here, so
//! that it can be tested without a browser. Screen coordinates have their origin at the top left.

mod looks;

pub use looks::Side;

use glam::camera::rh::{proj::directx, view};
use glam::{Mat4, Vec2, Vec3};

/// Vertical field of view: long enough a lens that a ball looks like a ball near the edge.
const FIELD_OF_VIEW: f32 = 28.0 * std::f32::consts::PI / 180.0;
/// How much of the view the surface fills after [`Orbit::fit`].
const FILL: f32 = 0.94;
/// Turning ends above the poles: a hair before them, where heights on the screen still have a direction.
const MAX_PITCH: f32 = std::f32::consts::FRAC_PI_2 - 1e-4;
/// Where the eye of a parallel view is said to stand, in front of its target: far enough for all lines of sight to be one
/// within half a degree, near enough for single precision.
const FAR_EYE: f32 = 100.0;
/// In a parallel view everything lies within this of the target's plane: the target stays within 2 of the origin.
const DEPTH: f32 = 7.0;
/// Distance of the sheet from the edge of its view after [`Sheet::fit`], in CSS pixels: room for the
/// outer half of an outline.
const SHEET_MARGIN: f32 = 4.0;

/// Size of a view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Viewport {
    /// Width and height in CSS pixels.
    pub size: Vec2,
    /// Device pixels per CSS pixel.
    pub scale: f32,
}

impl Viewport {
    /// Whether there is anything to draw on.
    pub fn is_empty(&self) -> bool {
        self.size.min_element() < 1.0 || self.scale <= 0.0
    }

    /// -1 to 1 from left to right and from bottom to top.
    fn to_ndc(self, css: Vec2) -> Vec2 {
        (css / self.size * 2.0 - 1.0) * Vec2::new(1.0, -1.0)
    }

    fn aspect(self) -> f32 {
        self.size.x / self.size.y
    }
}

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it begins.
    pub origin: Vec3,
    /// Where it goes, of any length.
    pub direction: Vec3,
}

/// What the shaders are told of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// World to clip space, depth 0 to 1.
    pub world_to_clip: Mat4,
    /// World to view space, for light that turns with the viewer.
    pub world_to_view: Mat4,
    /// The eye.
    pub eye: Vec3,
    /// World length of one device pixel: at distance 1 from the eye when `perspective`, everywhere otherwise.
    pub pixel: f32,
    /// Whether far things are smaller.
    pub perspective: bool,
}

/// A turntable with its axis along y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    target: Vec3,
    yaw: f32,
    pitch: f32,
    distance: f32,
    /// Target and distance that frame everything.
    home: (Vec3, f32),
    /// Whether lines of sight are parallel: sizes are then those at the target's distance.
    is_orthographic: bool,
}

impl Default for Orbit {
    fn default() -> Self {
        // Three quarters from the front, a little from above.
        let home = (Vec3::ZERO, 1.0);
        let (yaw, pitch) = (0.55, 0.26);
        Self { target: Vec3::ZERO, yaw, pitch, distance: 1.0, home, is_orthographic: false }
    }
}

impl Orbit {
    /// Frames points of the unit ball and keeps the direction.
    ///
    /// The frame is that of everything which the points sweep when the table turns about its axis: closer
    /// than the ball where a surface is flat or long, and nothing leaves the view while it turns.
    pub fn fit(&mut self, points: impl Iterator<Item = Vec3> + Clone, viewport: Viewport) {
        let slope = (FIELD_OF_VIEW / 2.0).tan() * FILL;
        let slopes = Vec2::new(slope * viewport.aspect(), slope);
        let (sin, cos) = self.pitch.sin_cos();
        // A point sweeps a circle about the axis: an ellipse on the screen.
        let sweep = |point: Vec3| (Vec2::new(point.x, point.z).length(), point.y);
        let [low, high] = points.clone().map(sweep).fold([f32::MAX, f32::MIN], |span, circle| {
            let (radius, height) = circle;
            let (middle, reach) = (height * cos, radius * sin.abs());
            [span[0].min(middle - reach), span[1].max(middle + reach)]
        });
        if low > high {
            return;
        }
        // Looked at from the middle of what is seen, up the axis.
        let middle = ((low + high) / 2.0 / cos).clamp(-1.0, 1.0);
        self.target = Vec3::new(0.0, middle, 0.0);
        // From the eye at distance d, a point at x to the side and z towards the eye is within the view
        // if |x| <= slope (d - z). Over a circle the bound on d is largest at √(slope⁻² + cos²) to the
        // side, and at the nearest or farthest point up and down.
        // In a parallel view nearness counts for nothing.
        let near = if self.is_orthographic { 0.0 } else { 1.0 };
        self.distance = points.map(sweep).fold(1e-3, |distance, (radius, height)| {
            let height = height - middle;
            let sideways =
                radius * (slopes.x.powi(-2) + near * cos * cos).sqrt() + near * height * sin;
            let nearest = |side: f32| {
                let up = height * cos - side * radius * sin;
                up.abs() / slopes.y + near * (height * sin + side * radius * cos)
            };
            distance.max(sideways).max(nearest(1.0)).max(nearest(-1.0))
        });
        self.home = (self.target, self.distance);
    }

    /// Turns by a movement of the pointer: half a turn for the shorter side of the view.
    pub fn rotate(&mut self, movement: Vec2, viewport: Viewport) {
        let angle = movement * std::f32::consts::PI / viewport.size.min_element();
        self.yaw = (self.yaw - angle.x).rem_euclid(std::f32::consts::TAU);
        self.pitch = (self.pitch + angle.y).clamp(-MAX_PITCH, MAX_PITCH);
    }

    /// Moves sideways so that what lies at the target's distance follows the pointer.
    pub fn pan(&mut self, movement: Vec2, viewport: Viewport) {
        let step = movement * 2.0 * self.distance * (FIELD_OF_VIEW / 2.0).tan() / viewport.size.y;
        let (right, up) = self.axes();
        self.target = (self.target - right * step.x + up * step.y).clamp_length_max(2.0);
    }

    /// Magnifies by `factor` about `pivot`, a point in space that stays where it is on the screen. About a
    /// point of the surface the eye comes ever closer to it and never through it.
    ///
    /// On the way out the target is led back, so that far enough out everything is in the middle again.
    pub fn zoom(&mut self, factor: f32, pivot: Vec3) {
        let (home, far) = self.home;
        let before = self.distance;
        self.distance = (before / factor).clamp(0.02 * far, 3.0 * far);
        let off_before = self.target.distance(home);
        self.target = pivot + (self.target - pivot) * (self.distance / before);
        if factor < 1.0 {
            // As far off as zooming in to a point of the ball could have led, or a little less than now.
            let allowed = (1.2 * (1.0 - self.distance / far)).max(0.85 * off_before);
            self.target = home + (self.target - home).clamp_length_max(allowed);
        }
    }

    /// Where it stands: yaw and pitch in radians, then the distance and the offset of the target as seen from `framed`,
    /// which frames everything from the same side. The same pose shows the same in a view of another shape.
    pub fn pose(&self, framed: &Self) -> [f32; 6] {
        let off = self.target - framed.target;
        [self.yaw, self.pitch, self.distance / framed.distance, off.x, off.y, off.z]
    }

    /// Takes a pose of finite numbers, within the bounds that hands can reach. **Takes** it for framed as it stood last.
    pub fn set_pose(&mut self, [yaw, pitch, distance, x, y, z]: [f32; 6]) {
        let (home, far) = self.home;
        self.yaw = yaw.rem_euclid(std::f32::consts::TAU);
        self.pitch = pitch.clamp(-MAX_PITCH, MAX_PITCH);
        self.distance = distance.clamp(0.02, 3.0) * far;
        self.target = (home + Vec3::new(x, y, z)).clamp_length_max(2.0);
    }

    /// The point under a place of the screen that is as far away as the target.
    pub fn beside_target(&self, css: Vec2, viewport: Viewport) -> Vec3 {
        let ray = self.ray(css, viewport);
        ray.origin + ray.direction * if self.is_orthographic { DEPTH } else { self.distance }
    }

    /// From the target towards the eye.
    fn backward(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        Vec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch)
    }

    fn axes(&self) -> (Vec3, Vec3) {
        let (sin, cos) = self.yaw.sin_cos();
        let right = Vec3::new(cos, 0.0, -sin);
        (right, self.backward().cross(right))
    }

    fn eye(&self) -> Vec3 {
        let distance = if self.is_orthographic { FAR_EYE } else { self.distance };
        self.target + self.backward() * distance
    }

    /// The ray through a place of the screen.
    pub fn ray(&self, css: Vec2, viewport: Viewport) -> Ray {
        let ndc = viewport.to_ndc(css);
        let half = (FIELD_OF_VIEW / 2.0).tan();
        let (right, up) = self.axes();
        let across = right * (ndc.x * half * viewport.aspect()) + up * (ndc.y * half);
        let backward = self.backward();
        if self.is_orthographic {
            let origin = self.target + across * self.distance + backward * DEPTH;
            return Ray { origin, direction: -backward };
        }
        Ray { origin: self.eye(), direction: across - backward }
    }

    /// For the shaders.
    pub fn projection(&self, viewport: Viewport) -> Projection {
        if self.is_orthographic {
            return self.parallel(viewport);
        }
        let eye = self.eye();
        let world_to_view = view::look_to_mat4(eye, -self.backward(), self.axes().1);
        // Everything lies within the unit ball or on the ground not far from it.
        let reach = eye.length();
        let near = (reach - 2.5).max(0.02 * self.distance).max(1e-3);
        let far = reach + 4.0;
        let clip = directx::perspective(FIELD_OF_VIEW, viewport.aspect(), near, far);
        let pixel = 2.0 * (FIELD_OF_VIEW / 2.0).tan() / (viewport.size.y * viewport.scale);
        Projection {
            world_to_clip: clip * world_to_view,
            world_to_view,
            eye,
            pixel,
            perspective: true,
        }
    }

    /// The same with parallel lines of sight. Shaders that lift lines towards an eye are given one far away.
    fn parallel(&self, viewport: Viewport) -> Projection {
        let half = self.distance * (FIELD_OF_VIEW / 2.0).tan();
        let wide = half * viewport.aspect();
        let world_to_view = view::look_to_mat4(self.target, -self.backward(), self.axes().1);
        let clip = directx::orthographic(-wide, wide, -half, half, -DEPTH, DEPTH);
        Projection {
            world_to_clip: clip * world_to_view,
            world_to_view,
            eye: self.eye(),
            pixel: 2.0 * half / (viewport.size.y * viewport.scale) / FAR_EYE,
            perspective: true,
        }
    }
}

/// A sheet seen from above: y up, no turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    center: Vec2,
    /// CSS pixels per unit.
    scale: f32,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { center: Vec2::ZERO, scale: 100.0 }
    }
}

impl Sheet {
    /// Frames `[x_min, y_min, x_max, y_max]`.
    pub fn fit(&mut self, [x0, y0, x1, y1]: [f32; 4], viewport: Viewport) {
        let (low, high) = (Vec2::new(x0, y0), Vec2::new(x1, y1));
        let extent = high - low;
        if !extent.is_finite() || extent.max_element() <= 0.0 || viewport.is_empty() {
            return;
        }
        let room = (viewport.size - 2.0 * SHEET_MARGIN).max(Vec2::ONE);
        self.center = (low + high) / 2.0;
        self.scale = (room / extent.max(Vec2::splat(1e-9))).min_element();
    }

    /// Moves with the pointer.
    pub fn pan(&mut self, movement: Vec2) {
        self.center += movement * Vec2::new(-1.0, 1.0) / self.scale;
    }

    /// Magnifies by `factor` about a place of the screen, which stays where it is.
    pub fn zoom(&mut self, factor: f32, css: Vec2, viewport: Viewport) {
        let before = self.to_sheet(css, viewport);
        self.scale = (self.scale * factor).clamp(1.0, 1e5);
        self.center += before - self.to_sheet(css, viewport);
    }

    /// CSS pixels per unit of the sheet.
    pub fn pixels_per_unit(&self) -> f32 {
        self.scale
    }

    /// The place of the sheet at a place of the screen.
    pub fn to_sheet(&self, css: Vec2, viewport: Viewport) -> Vec2 {
        self.center + (css - viewport.size / 2.0) * Vec2::new(1.0, -1.0) / self.scale
    }

    /// The place of the screen of a place of the sheet.
    pub fn to_screen(&self, place: Vec2, viewport: Viewport) -> Vec2 {
        (place - self.center) * Vec2::new(1.0, -1.0) * self.scale + viewport.size / 2.0
    }

    /// For the shaders; charts lie in the plane z = 0.
    pub fn projection(&self, viewport: Viewport) -> Projection {
        let half = viewport.size / (2.0 * self.scale);
        let low = self.center - half;
        let high = self.center + half;
        let world_to_clip = directx::orthographic(low.x, high.x, low.y, high.y, -1.0, 1.0);
        Projection {
            world_to_clip,
            world_to_view: Mat4::IDENTITY,
            eye: Vec3::Z,
            pixel: 1.0 / (self.scale * viewport.scale),
            perspective: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWPORT: Viewport = Viewport { size: Vec2::new(600.0, 400.0), scale: 2.0 };

    /// Points of the unit ball, flattened along y.
    fn ball(flatness: f32) -> impl Iterator<Item = Vec3> + Clone {
        (0..4000).map(move |i| {
            let y = 1.0 - (i as f32 + 0.5) / 2000.0;
            let (sin, cos) = (i as f32 * 2.4).sin_cos();
            let radius = (1.0 - y * y).sqrt();
            Vec3::new(radius * cos, y * flatness, radius * sin)
        })
    }

    fn orbit() -> Orbit {
        let mut orbit = Orbit::default();
        orbit.fit(ball(1.0), VIEWPORT);
        orbit
    }

    fn to_screen(projection: &Projection, point: Vec3) -> Vec2 {
        let clip = projection.world_to_clip * point.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        assert!((0.0..=1.0).contains(&ndc.z), "depth {}", ndc.z);
        (ndc.truncate() * Vec2::new(1.0, -1.0) + 1.0) / 2.0 * VIEWPORT.size
    }

    #[test]
    fn what_is_framed_fills_the_view_and_never_leaves_it_while_turning() {
        for (flatness, viewport) in [1.0, 0.3, 0.02].into_iter().flat_map(|f| {
            let tall = Viewport { size: Vec2::new(300.0, 800.0), scale: 1.0 };
            [(f, VIEWPORT), (f, tall)]
        }) {
            let mut orbit = Orbit::default();
            orbit.fit(ball(flatness), viewport);
            let mut most = Vec2::ZERO;
            for turn in 0..4 {
                orbit.yaw = turn as f32 * 0.7;
                let projection = orbit.projection(viewport);
                for point in ball(flatness) {
                    let clip = projection.world_to_clip * point.extend(1.0);
                    most = most.max((clip.truncate().truncate() / clip.w).abs());
                }
            }
            assert!(most.max_element() <= FILL + 1e-3, "{flatness}: up to {most}");
            assert!(most.max_element() > FILL - 0.12, "{flatness}: only up to {most}");
        }
    }

    #[test]
    fn a_ray_meets_what_is_drawn_under_it() {
        let mut orbit = orbit();
        orbit.rotate(Vec2::new(93.0, -41.0), VIEWPORT);
        orbit.pan(Vec2::new(-20.0, 33.0), VIEWPORT);
        let point = Vec3::new(0.3, -0.2, 0.4);
        let css = to_screen(&orbit.projection(VIEWPORT), point);
        let ray = orbit.ray(css, VIEWPORT);
        let along = ray.direction.normalize();
        let off = (point - ray.origin).reject_from(along).length();
        assert!(off < 1e-5, "off by {off}");
        assert!((point - ray.origin).dot(along) > 0.0);
    }

    #[test]
    fn turning_right_shows_the_left_and_never_passes_a_pole() {
        let mut orbit = orbit();
        let before = to_screen(&orbit.projection(VIEWPORT), orbit.backward()).x;
        let marked = orbit.backward();
        orbit.rotate(Vec2::new(40.0, 0.0), VIEWPORT);
        assert!(to_screen(&orbit.projection(VIEWPORT), marked).x > before + 10.0);
        orbit.rotate(Vec2::new(0.0, 1e6), VIEWPORT);
        assert!(orbit.axes().1.is_finite() && orbit.pitch <= MAX_PITCH);
    }

    #[test]
    fn zooming_keeps_the_place_under_the_pointer() {
        let mut orbit = orbit();
        let css = Vec2::new(420.0, 130.0);
        let ray = orbit.ray(css, VIEWPORT);
        let before = orbit;
        let held = ray.origin + ray.direction * (orbit.distance - 0.7);
        orbit.zoom(1.7, held);
        let after = to_screen(&orbit.projection(VIEWPORT), held);
        assert!(after.distance(css) < 0.05, "moved to {after}");
        orbit.zoom(1.0 / 1.7, held);
        assert!((orbit.target - before.target).length() < 1e-4, "out again by the same way");

        let mut sheet = Sheet::default();
        let held = sheet.to_sheet(css, VIEWPORT);
        sheet.zoom(3.0, css, VIEWPORT);
        assert!(sheet.to_screen(held, VIEWPORT).distance(css) < 1e-2);
    }

    #[test]
    fn the_eye_never_passes_what_it_zooms_to_and_comes_home() {
        let mut orbit = orbit();
        let pivot = orbit.backward();
        for _ in 0..40 {
            orbit.zoom(1.3, pivot);
        }
        assert!((orbit.eye() - pivot).dot(pivot) > 0.0);
        assert!(orbit.projection(VIEWPORT).world_to_clip.is_finite());
        orbit.pan(Vec2::new(300.0, 200.0), VIEWPORT);
        for _ in 0..80 {
            orbit.zoom(0.8, orbit.beside_target(Vec2::new(90.0, 40.0), VIEWPORT));
        }
        assert!(orbit.target.distance(orbit.home.0) < 0.1, "{}", orbit.target);
    }

    #[test]
    fn panning_follows_the_pointer() {
        let mut orbit = orbit();
        let center = to_screen(&orbit.projection(VIEWPORT), Vec3::ZERO);
        orbit.pan(Vec2::new(15.0, -9.0), VIEWPORT);
        let moved = to_screen(&orbit.projection(VIEWPORT), Vec3::ZERO) - center;
        assert!(moved.distance(Vec2::new(15.0, -9.0)) < 0.05, "{moved}");
    }

    #[test]
    fn the_sheet_fits_and_its_projection_agrees_with_its_arithmetic() {
        let mut sheet = Sheet::default();
        sheet.fit([-1.0, 2.0, 3.0, 3.0], VIEWPORT);
        assert!((sheet.pixels_per_unit() - (600.0 - 2.0 * SHEET_MARGIN) / 4.0).abs() < 1e-3);
        let corner = Vec2::new(3.0, 3.0);
        let css = to_screen(&sheet.projection(VIEWPORT), corner.extend(0.0));
        assert!(css.distance(sheet.to_screen(corner, VIEWPORT)) < 1e-2);
        assert!((css.x - (600.0 - SHEET_MARGIN)).abs() < 1e-2);
    }

    #[test]
    fn a_pose_brings_the_same_picture_back() {
        let mut orbit = orbit();
        orbit.rotate(Vec2::new(70.0, -40.0), VIEWPORT);
        orbit.zoom(2.5, Vec3::new(0.3, 0.2, 0.1));
        orbit.pan(Vec2::new(12.0, 30.0), VIEWPORT);
        let mut framed = orbit;
        framed.fit(ball(1.0), VIEWPORT);
        let pose = orbit.pose(&framed);
        let mut again = Orbit::default();
        again.set_pose(pose);
        again.fit(ball(1.0), VIEWPORT);
        again.set_pose(pose);
        for point in ball(1.0).step_by(97) {
            let [there, back] =
                [&orbit, &again].map(|o| o.projection(VIEWPORT).world_to_clip * point.extend(1.0));
            assert!((there - back).length() < 1e-4, "{there} {back}");
        }
    }

    #[test]
    fn a_sheet_without_charts_leaves_the_camera_alone() {
        let mut sheet = Sheet::default();
        sheet.fit([0.0; 4], VIEWPORT);
        sheet.fit([f32::NAN; 4], VIEWPORT);
        assert_eq!(sheet, Sheet::default());
    }
}
