//! The two cameras: turned, moved, magnified, fitted.

use super::super::camera::{Projection, Viewport};
use super::{Part, Stage, View};
use glam::{Vec2, Vec3};

impl Stage {
    /// Size of a view. What nobody has moved is fitted again.
    pub fn resize(&mut self, view: View, viewport: Viewport) {
        let was_empty = self.viewport(view).is_empty();
        if viewport == self.viewport(view) {
            return;
        }
        self.viewports[view as usize] = viewport;
        self.dirty[view as usize] = true;
        self.stamp(true, &[Part::Cones, Part::ChartCones]);
        if viewport.is_empty() {
            return;
        }
        match view {
            View::Surface if was_empty || self.orbit_is_fitted => self.fit_orbit(),
            View::Flat if was_empty || self.sheet_is_fitted => {
                self.sheet.fit(self.bounds(), viewport);
            }
            _ => {}
        }
    }

    /// Size of a view.
    pub fn viewport(&self, view: View) -> Viewport {
        self.viewports[view as usize]
    }

    /// Turns the surface by a movement in CSS pixels.
    pub fn rotate(&mut self, movement: Vec2) {
        if let Some(viewport) = self.usable(View::Surface, movement) {
            self.orbit.rotate(movement, viewport);
        }
    }

    /// Moves a picture with the pointer.
    pub fn pan(&mut self, view: View, movement: Vec2) {
        let Some(viewport) = self.usable(view, movement) else { return };
        match view {
            View::Surface => {
                self.orbit.pan(movement, viewport);
                self.orbit_is_fitted = false;
            }
            View::Flat => {
                self.sheet.pan(movement);
                self.sheet_is_fitted = false;
            }
        }
    }

    /// Magnifies a picture by `factor` about a place of the screen.
    pub fn zoom(&mut self, view: View, factor: f32, css: Vec2) {
        let Some(viewport) = self.usable(view, css) else { return };
        if !(factor.is_finite() && factor > 0.0) {
            return;
        }
        match view {
            View::Surface => {
                let pivot = match self.pick(view, css) {
                    Some(pick) => pick.place,
                    None => self.orbit.beside_target(css, viewport),
                };
                self.orbit.zoom(factor, pivot);
                self.orbit_is_fitted = false;
            }
            View::Flat => {
                self.sheet.zoom(factor, css, viewport);
                self.sheet_is_fitted = false;
            }
        }
    }

    /// Frames everything; the surface keeps its direction.
    pub fn fit(&mut self, view: View) {
        let Some(viewport) = self.usable(view, Vec2::ZERO) else { return };
        match view {
            View::Surface => self.fit_orbit(),
            View::Flat => {
                self.sheet.fit(self.bounds(), viewport);
                self.sheet_is_fitted = true;
            }
        }
    }

    /// Where the camera of the surface stands, see [`Orbit::pose`].
    pub fn pose(&self) -> [f32; 6] {
        let mut framed = self.orbit;
        if !self.orbit_is_fitted {
            framed.fit(self.points(), self.viewport(View::Surface));
        }
        self.orbit.pose(&framed)
    }

    /// Puts the camera of the surface somewhere.
    pub fn set_pose(&mut self, pose: [f32; 6]) {
        if self.usable(View::Surface, Vec2::ZERO).is_none() || !pose.iter().all(|x| x.is_finite()) {
            return;
        }
        // What frames everything is another distance for each pitch.
        self.orbit.set_pose(pose);
        self.fit_orbit();
        self.orbit.set_pose(pose);
        self.orbit_is_fitted = pose[2..] == [1.0, 0.0, 0.0, 0.0];
    }

    pub(super) fn points(&self) -> impl Iterator<Item = Vec3> + Clone {
        self.scene.positions.as_chunks().0.iter().copied().map(Vec3::from_array)
    }

    pub(super) fn fit_orbit(&mut self) {
        let viewport = self.viewport(View::Surface);
        if !viewport.is_empty() {
            let mut orbit = self.orbit;
            self.frame_shown(&mut orbit);
            self.orbit = orbit;
            self.orbit_is_fitted = true;
        }
    }

    /// The viewport of a view that is about to move, marked dirty; none for an empty view or a
    /// movement that is no number.
    pub(super) fn usable(&mut self, view: View, movement: Vec2) -> Option<Viewport> {
        let viewport = self.viewport(view);
        if viewport.is_empty() || !movement.is_finite() {
            return None;
        }
        self.dirty[view as usize] = true;
        self.looking.end_flight(view);
        // What hides a cone depends on where one looks from.
        self.stamp(view == View::Surface, &[Part::Cones]);
        Some(viewport)
    }

    /// The camera of a view.
    pub fn projection(&self, view: View) -> Projection {
        match view {
            View::Surface => self.orbit.projection(self.viewport(view)),
            View::Flat => self.sheet.projection(self.viewport(view)),
        }
    }

    /// Where the eye stands, in the frame of the scene.
    pub fn eye(&self) -> Vec3 {
        self.projection(View::Surface).eye
    }
}
