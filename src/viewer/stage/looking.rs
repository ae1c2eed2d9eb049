//! How the surface is looked at: flights of the cameras, one piece alone, a plane that cuts away what is in front.

use super::super::arrays::{self, NONE};
use super::super::camera::{Orbit, Sheet, Side};
use super::super::pick::Hit;
use super::{Part, Stage, View};
use glam::{Vec3, Vec4};

/// What a clipping plane is straight to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipAxis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
    /// The line of sight, wherever one looks from.
    View,
}

impl ClipAxis {
    /// From what the page calls it.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "x" => Self::X,
            "y" => Self::Y,
            "z" => Self::Z,
            "view" => Self::View,
            _ => return None,
        })
    }
}

/// A plane that cuts a part of the surface away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Its direction.
    pub axis: ClipAxis,
    /// How much of the surface's extent along the axis is kept, 0 to 1.
    pub kept: f32,
    /// Whether the side of the greater coordinates, or the near one, is kept in place of the other.
    pub is_turned: bool,
}

/// How the surface is looked at, beyond its camera.
#[derive(Debug)]
pub(super) struct Looking {
    /// From where to where the camera flies.
    flight: Option<[Orbit; 2]>,
    sheet_flight: Option<[Sheet; 2]>,
    /// The piece that is shown alone; [`NONE`] for all.
    pub(super) isolated: u32,
    clip: Option<Clip>,
    /// Extent of the surface along the axes, known while something is cut away.
    extent: [Vec3; 2],
}

impl Default for Looking {
    fn default() -> Self {
        let extent = [Vec3::NEG_ONE, Vec3::ONE];
        Self { flight: None, sheet_flight: None, isolated: NONE, clip: None, extent }
    }
}

impl Looking {
    /// A movement by hand ends a flight where it is.
    pub(super) fn end_flight(&mut self, view: View) {
        match view {
            View::Surface => self.flight = None,
            View::Flat => self.sheet_flight = None,
        }
    }
}

impl Stage {
    /// Takes notice of another scene; a piece that is no more cannot stay alone.
    pub(super) fn look_at_scene(&mut self, is_new_mesh: bool) {
        if is_new_mesh {
            self.looking.flight = None;
            self.looking.sheet_flight = None;
        }
        let isolated = self.looking.isolated;
        if isolated != NONE && (is_new_mesh || isolated as usize >= self.scene.patches.len()) {
            self.set_isolated(None);
        }
        if self.looking.clip.is_some() {
            self.measure_extent();
        }
    }

    fn measure_extent(&mut self) {
        let span = [Vec3::MAX, Vec3::MIN];
        let places = self.scene.positions.as_chunks().0.iter().copied().map(Vec3::from_array);
        let [low, high] = places.fold(span, |[low, high], p| [low.min(p), high.max(p)]);
        self.looking.extent =
            if low.x <= high.x { [low, high] } else { [Vec3::NEG_ONE, Vec3::ONE] };
    }

    /// Cuts a part of the surface away; none shows all of it.
    pub fn set_clip(&mut self, clip: Option<Clip>) {
        let clip = clip.filter(|clip| clip.kept.is_finite());
        if clip != self.looking.clip {
            self.looking.clip = clip;
            self.measure_extent();
            self.stamp(true, &[Part::Cones]);
            self.dirty[View::Surface as usize] = true;
        }
    }

    /// Whether a part of the surface is cut away.
    pub fn is_clipped(&self) -> bool {
        self.looking.clip.is_some()
    }

    /// A normal and a number: places with a dot product up to it are kept.
    pub fn clip_plane(&self) -> Vec4 {
        let Some(clip) = self.looking.clip else { return Vec4::new(0.0, 0.0, 0.0, 1.0) };
        let [low, high] = self.looking.extent;
        let (normal, low, high) = match clip.axis {
            ClipAxis::X => (Vec3::X, low.x, high.x),
            ClipAxis::Y => (Vec3::Y, low.y, high.y),
            ClipAxis::Z => (Vec3::Z, low.z, high.z),
            // Every surface fits the unit ball.
            ClipAxis::View => (self.orbit.towards_eye(), -1.0, 1.0),
        };
        // A hair beyond it on either side: all of it is all of it whatever the rounding, and nothing nothing.
        let room = (high - low + 2e-4) * clip.kept.clamp(0.0, 1.0) - 1e-4;
        if clip.is_turned { (-normal).extend(room - high) } else { normal.extend(low + room) }
    }

    /// Whether a place on the surface is not cut away.
    pub(super) fn keeps(&self, place: Vec3) -> bool {
        let plane = self.clip_plane();
        plane.truncate().dot(place) <= plane.w
    }

    /// Whether a hit on the surface is on something that is drawn.
    pub(super) fn shows_patch_of(&self, hit: &Hit) -> bool {
        let corner = arrays::triangles(&self.scene)[hit.triangle as usize][0];
        let isolated = self.isolated();
        isolated.is_none_or(|patch| self.scene.vertex_patches[corner as usize] == patch)
    }

    /// The piece that is shown alone. What blends has no pieces.
    pub fn isolated(&self) -> Option<u32> {
        let isolated = self.looking.isolated;
        (isolated != NONE && !self.shows_layers()).then_some(isolated)
    }

    /// Shows one piece alone on the surface; none shows all of them.
    pub fn set_isolated(&mut self, patch: Option<u32>) {
        let patch = patch.filter(|&patch| (patch as usize) < self.scene.patches.len());
        let patch = patch.unwrap_or(NONE);
        if patch == self.looking.isolated {
            return;
        }
        self.looking.isolated = patch;
        self.stamp_isolation();
        self.dirty = [true; 2];
    }

    /// What is drawn of the surface depends on the piece that is shown alone.
    pub(super) fn stamp_isolation(&mut self) {
        let parts = [Part::Triangles, Part::Cuts, Part::Ghost, Part::Wires, Part::Cones];
        self.stamp(true, &parts);
    }

    /// The triangles of the surface that are drawn.
    pub(super) fn shown_triangles(&self) -> Vec<u8> {
        let triangles = arrays::triangles(&self.scene);
        match self.isolated() {
            None => arrays::indices(triangles),
            Some(patch) => {
                let is_shown =
                    |[a, ..]: &&[u32; 3]| self.scene.vertex_patches[*a as usize] == patch;
                arrays::indices(triangles.iter().filter(is_shown))
            }
        }
    }

    /// Parallel lines of sight, or those of an eye.
    pub fn set_orthographic(&mut self, on: bool) {
        if on == self.orbit.is_orthographic() {
            return;
        }
        self.looking.flight = None;
        self.orbit.set_orthographic(on);
        self.stamp(true, &[Part::Cones]);
        self.dirty[View::Surface as usize] = true;
        if self.orbit_is_fitted {
            self.fit_orbit();
        }
    }

    /// Sends the camera to a side of what is shown; [`Stage::fly`] takes it there.
    pub fn fly_to_side(&mut self, side: Side) {
        let mut there = self.orbit;
        there.look_from(side);
        self.fly_orbit(there, true);
    }

    /// Sends the camera of a view to where it frames everything; the surface keeps its direction.
    pub fn fly_home(&mut self, view: View) {
        match view {
            View::Surface => self.fly_orbit(self.orbit, true),
            View::Flat => {
                let mut there = self.sheet;
                there.fit(self.bounds(), self.viewport(View::Flat));
                self.looking.sheet_flight = Some([self.sheet, there]);
                self.sheet_is_fitted = true;
            }
        }
    }

    /// Sends both cameras to a piece: the surface is seen from the piece's own side. False where there is no such piece.
    pub fn fly_to_patch(&mut self, patch: u32) -> bool {
        if patch as usize >= self.scene.patches.len() {
            return false;
        }
        let mut there = self.orbit;
        self.frame_patch(&mut there, patch, true);
        self.fly_orbit(there, false);
        if let Some(bounds) = self.chart_bounds(patch) {
            let mut there = self.sheet;
            there.frame(bounds, self.viewport(View::Flat));
            self.looking.sheet_flight = Some([self.sheet, there]);
            self.sheet_is_fitted = false;
        }
        true
    }

    fn fly_orbit(&mut self, mut there: Orbit, is_fitted: bool) {
        let viewport = self.viewport(View::Surface);
        if viewport.is_empty() {
            return;
        }
        if is_fitted {
            self.frame_shown(&mut there);
        }
        self.looking.flight = Some([self.orbit, there]);
        self.orbit_is_fitted = is_fitted;
    }

    /// Frames what is shown of the surface.
    pub(super) fn frame_shown(&self, orbit: &mut Orbit) {
        let viewport = self.viewport(View::Surface);
        let points = self.scene.positions.as_chunks().0.iter().copied();
        orbit.fit(points.map(Vec3::from_array), viewport);
        if let Some(patch) = self.isolated() {
            self.frame_patch(orbit, patch, false);
        }
    }

    fn frame_patch(&self, orbit: &mut Orbit, patch: u32, turns: bool) {
        let scene = &self.scene;
        let (mut normal, mut area) = (Vec3::ZERO, 0.0);
        for corners in arrays::triangles(scene) {
            if turns && scene.vertex_patches[corners[0] as usize] == patch {
                let [a, b, c] = corners.map(|vertex| arrays::position(scene, vertex));
                let twice = (b - a).cross(c - a);
                normal += twice / 2.0;
                area += twice.length() / 2.0;
            }
        }
        let points = (0..)
            .zip(&scene.vertex_patches)
            .filter(|(_, of)| **of == patch)
            .map(|(vertex, _)| arrays::position(scene, vertex));
        orbit.frame(points, normal, area, self.viewport(View::Surface));
    }

    /// The extent of a piece's chart, none where it has none or is not shown.
    fn chart_bounds(&self, patch: u32) -> Option<[f32; 4]> {
        let of_patch = (0..).zip(&self.scene.vertex_patches).filter(|(_, of)| **of == patch);
        let places = of_patch.map(|(vertex, _)| arrays::chart(&self.scene, vertex));
        let span = [Vec3::MAX, Vec3::MIN];
        let places = places.filter(|place| place.is_finite() && !self.shows_layers());
        let [low, high] = places.fold(span, |[low, high], p| [low.min(p), high.max(p)]);
        (low.x <= high.x).then_some([low.x, low.y, high.x, high.y])
    }

    /// Takes the cameras to a part of their way, 0 to 1. **Gives** whether there is more of it.
    pub fn fly(&mut self, part: f32) -> bool {
        let is_over = part >= 1.0 || part.is_nan();
        if let Some([here, there]) = self.looking.flight {
            self.orbit = if is_over { there } else { here.towards(&there, part) };
            self.stamp(true, &[Part::Cones]);
            self.dirty[View::Surface as usize] = true;
        }
        if let Some([here, there]) = self.looking.sheet_flight {
            self.sheet = if is_over { there } else { here.towards(&there, part) };
            self.dirty[View::Flat as usize] = true;
        }
        if is_over {
            self.looking.flight = None;
            self.looking.sheet_flight = None;
        }
        self.looking.flight.is_some() || self.looking.sheet_flight.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::fixtures::{two_squares, unit_ball};
    use super::super::tests::stage;
    use super::*;
    use glam::Vec2;

    const MIDDLE: Vec2 = Vec2::new(250.0, 150.0);

    fn clip(axis: ClipAxis, kept: f32) -> Option<Clip> {
        Some(Clip { axis, kept, is_turned: false })
    }

    #[test]
    fn what_is_cut_away_is_not_picked_and_what_is_behind_it_is() {
        let mut stage = stage(unit_ball(3, 0));
        stage.fly_to_side(Side::Front);
        assert!(!stage.fly(1.0));
        let front = stage.pick(View::Surface, MIDDLE).expect("the ball");
        assert!(front.place.z > 0.97);
        stage.set_clip(clip(ClipAxis::Z, 0.5));
        let back = stage.pick(View::Surface, MIDDLE).expect("its inside");
        assert!(back.place.z < -0.97);
        stage.set_clip(Some(Clip { is_turned: true, ..clip(ClipAxis::Z, 0.5).expect("a plane") }));
        assert!(stage.pick(View::Surface, MIDDLE).expect("the front again").place.z > 0.97);
        stage.set_clip(clip(ClipAxis::View, 0.0));
        assert_eq!(stage.pick(View::Surface, MIDDLE), None);
        stage.set_clip(None);
        assert_eq!(stage.pick(View::Surface, MIDDLE), Some(front));
    }

    #[test]
    fn a_whole_extent_keeps_everything_and_half_of_it_the_lower_half() {
        let mut stage = stage(two_squares());
        for (axis, low, high) in [(ClipAxis::X, -1.0, 1.0), (ClipAxis::Y, 0.0, 1.0)] {
            let at = |t: f32| match axis {
                ClipAxis::X => Vec3::X * t,
                _ => Vec3::Y * t,
            };
            for is_turned in [false, true] {
                let plane = |kept| Some(Clip { axis, kept, is_turned });
                stage.set_clip(plane(1.0));
                assert!(stage.keeps(at(low)) && stage.keeps(at(high)));
                stage.set_clip(plane(0.25));
                let [near, far] = if is_turned { [high, low] } else { [low, high] };
                let inside = near + 0.2 * (far - near);
                let outside = near + 0.3 * (far - near);
                assert!(stage.keeps(at(inside)) && !stage.keeps(at(outside)), "{axis:?}");
            }
        }
        stage.set_clip(plane_of_nothing());
        assert!(!stage.is_clipped());
    }

    fn plane_of_nothing() -> Option<Clip> {
        clip(ClipAxis::X, f32::NAN)
    }

    #[test]
    fn a_plane_across_the_line_of_sight_follows_the_camera() {
        let mut stage = stage(unit_ball(2, 0));
        stage.set_clip(clip(ClipAxis::View, 0.5));
        for _ in 0..3 {
            let towards = stage.orbit.towards_eye();
            assert!(stage.clip_plane().truncate().distance(towards) < 1e-6);
            assert!(stage.keeps(-towards) && !stage.keeps(towards));
            stage.rotate(Vec2::new(40.0, 15.0));
        }
    }

    #[test]
    fn a_piece_shown_alone_is_all_that_is_drawn_and_picked() {
        let mut stage = stage(two_squares());
        stage.fly_to_side(Side::Front);
        stage.fly(1.0);
        let place = |stage: &mut Stage, x| {
            let (projection, viewport) =
                (stage.projection(View::Surface), stage.viewport(View::Surface));
            let css = super::super::super::cones::to_screen(
                Vec3::new(x, 0.5, 0.0),
                &projection,
                viewport,
            );
            stage.pick(View::Surface, css.expect("in front")).map(|pick| pick.patch)
        };
        assert_eq!([place(&mut stage, -0.5), place(&mut stage, 0.5)], [Some(0), Some(1)]);
        let whole = stage.bytes(Part::Triangles).len();
        assert!(stage.bytes(Part::Ghost).is_empty());
        let stamp = stage.stamp_of(Part::Triangles);
        stage.set_isolated(Some(1));
        assert!(stage.stamp_of(Part::Triangles) > stamp);
        assert_eq!(stage.bytes(Part::Triangles).len(), whole / 2);
        assert!(!stage.bytes(Part::Ghost).is_empty());
        assert_eq!([place(&mut stage, -0.5), place(&mut stage, 0.5)], [None, Some(1)]);
        stage.set_isolated(Some(7));
        assert_eq!(stage.isolated(), None);
        assert_eq!(stage.bytes(Part::Triangles).len(), whole);
    }

    #[test]
    fn a_piece_is_shown_alone_until_it_is_no_more_or_the_mesh_is_another() {
        let mut stage = stage(two_squares());
        stage.set_isolated(Some(1));
        stage.set_scene(super::super::Scene { revision: 4, ..two_squares() }).expect("a scene");
        assert_eq!(stage.isolated(), Some(1));
        stage.set_scene(two_squares()).expect("a scene");
        assert_eq!(stage.isolated(), None);
    }

    #[test]
    fn a_flight_to_a_piece_frames_it_in_both_views_and_a_hand_on_the_camera_ends_it() {
        let mut stage = stage(two_squares());
        assert!(stage.fly_to_patch(1));
        assert!(stage.fly(0.5));
        let halfway = stage.orbit;
        stage.rotate(Vec2::new(10.0, 0.0));
        assert!(stage.fly(0.6), "the sheet still flies");
        assert_ne!(stage.orbit.towards_eye(), halfway.towards_eye());
        let turned = stage.orbit;
        assert!(!stage.fly(1.0));
        assert_eq!(stage.orbit, turned, "it stays in the hand");
        let css = stage.sheet.to_screen(Vec2::new(1.75, 0.5), stage.viewport(View::Flat));
        assert!(
            css.distance(MIDDLE) < 0.1,
            "the second square is in the middle of the sheet: {css}"
        );
        assert!(stage.fly_to_patch(1));
        stage.fly(1.0);
        assert!(stage.orbit.towards_eye().z > 0.999, "seen from the side that it faces");
        let pick = stage.pick(View::Surface, MIDDLE).expect("the piece");
        assert!(pick.patch == 1 && pick.place.distance(Vec3::new(0.5, 0.5, 0.0)) < 0.01);
        assert!(!stage.fly_to_patch(2));
        stage.fly_home(View::Surface);
        stage.fly_home(View::Flat);
        stage.fly(1.0);
        assert_eq!(stage.pick(View::Flat, MIDDLE), None, "between the squares");
    }
}
