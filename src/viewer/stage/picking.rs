//! What lies under a place of the screen, and the brush that is laid there.

use super::super::arrays;
use super::super::brush::{self, Stroke};
use super::super::camera::Ray;
use super::super::pick::{Hierarchy, Hit};
use super::{Part, Stage, View};
use glam::{Vec2, Vec3};

/// What lies under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Its patch.
    pub patch: u32,
    /// Its scene triangle.
    pub triangle: u32,
    /// The input face that the triangle is a part of.
    pub face: u32,
    /// The place on the surface, also when picked on a chart.
    pub place: Vec3,
}

impl Stage {
    /// What lies under a place of the screen.
    pub fn pick(&mut self, view: View, css: Vec2) -> Option<Pick> {
        let hit = self.hit(view, css)?;
        Some(self.pick_of(hit))
    }

    pub(super) fn pick_of(&self, hit: Hit) -> Pick {
        let scene = &self.scene;
        let corners = arrays::triangles(scene)[hit.triangle as usize];
        Pick {
            patch: scene.vertex_patches[corners[0] as usize],
            triangle: hit.triangle,
            face: scene.triangle_faces[hit.triangle as usize],
            place: self.on_surface(hit),
        }
    }

    /// The triangle under a place of the screen.
    pub(super) fn hit(&mut self, view: View, css: Vec2) -> Option<Hit> {
        let viewport = self.viewport(view);
        // Overlapping charts are no pieces: there is nothing to point at.
        let has_pieces = view == View::Surface || !self.shows_layers();
        if viewport.is_empty() || !css.is_finite() || !has_pieces {
            return None;
        }
        let ray = match view {
            View::Surface => self.orbit.ray(css, viewport),
            View::Flat => {
                let origin = self.sheet.to_sheet(css, viewport).extend(1.0);
                Ray { origin, direction: Vec3::NEG_Z }
            }
        };
        self.cast(view, ray)
    }

    /// What a ray meets in a view.
    pub(super) fn cast(&mut self, view: View, ray: Ray) -> Option<Hit> {
        let scene = &self.scene;
        let triangles = arrays::triangles(scene);
        let place: &dyn Fn(u32) -> Vec3 = match view {
            View::Surface => &|vertex| arrays::position(scene, vertex),
            View::Flat => &|vertex| arrays::chart(scene, vertex),
        };
        self.hierarchies[view as usize].get_or_insert_with(|| Hierarchy::new(triangles, place));
        let hierarchy = self.hierarchies[view as usize].as_ref()?;
        hierarchy.cast_where(ray, triangles, place, |hit| {
            // Through what is cut away or hidden one sees what is behind it.
            let met = ray.origin + ray.direction * hit.distance;
            view == View::Flat || (self.keeps(met) && self.shows_patch_of(hit))
        })
    }

    /// The place on the surface of a hit in either view.
    pub(super) fn on_surface(&self, hit: Hit) -> Vec3 {
        let corners = arrays::triangles(&self.scene)[hit.triangle as usize];
        let point = |(vertex, weight)| arrays::position(&self.scene, vertex) * weight;
        corners.into_iter().zip(hit.weights).map(point).sum()
    }

    /// Lays the brush on what is under a place of the screen; a radius that is not above 0 takes it away.
    ///
    /// **Gives** whether it lies anywhere.
    pub fn set_brush(&mut self, css: Vec2, radius: f32) -> bool {
        let pick = if radius > 0.0 { self.pick(View::Surface, css) } else { None };
        let ring = match pick {
            Some(pick) => {
                let corners = arrays::triangles(&self.scene)[pick.triangle as usize];
                let normal = corners.map(|v| arrays::normal(&self.scene, v)).into_iter().sum();
                brush::ring(pick.place, normal, radius, |ray| {
                    let hit = self.cast(View::Surface, ray)?;
                    Some((hit.distance, self.on_surface(hit)))
                })
            }
            None => Vec::new(),
        };
        if ring != self.ring {
            self.ring = ring;
            self.stamp(true, &[Part::Brush]);
            self.dirty[View::Surface as usize] = true;
        }
        !self.ring.is_empty()
    }

    /// Draws the brush to a place of the screen, or puts it down there where a stroke `begins`.
    ///
    /// **Gives** the dabs that this adds, in order; see [`brush`].
    pub fn stroke(&mut self, css: Vec2, radius: f32, begins: bool) -> Vec<Pick> {
        if !css.is_finite() {
            return Vec::new();
        }
        let mut stroke = self.stroke.take().filter(|_| !begins).unwrap_or(Stroke::new(css));
        let place = self.pick(View::Surface, css).map_or(Vec3::ZERO, |pick| pick.place);
        let scale = self.viewport(View::Surface).scale;
        let pixels = brush::pixels(radius, place, &self.projection(View::Surface), scale);
        let dabs = stroke.extend(css, radius, pixels, |css| {
            self.pick(View::Surface, css).map(|pick| (pick.place, pick))
        });
        self.stroke = Some(stroke);
        dabs
    }
}
