//! Cones as they are seen, pointed at and dragged.

use super::super::arrays;
use super::super::camera::Ray;
use super::super::cones::{self, Drag, Glyph, Marks};
use super::super::pick::Hit;
use super::{Part, Pick, Stage, View};
use glam::{Vec2, Vec3};

/// Cones of the surface view that may have a label: more would hide the surface.
const CONE_LABELS: usize = 48;

impl Stage {
    /// Marks cones in both views.
    pub fn set_cone_marks(&mut self, marks: Marks) {
        if marks != self.cone_marks {
            self.cone_marks = marks;
            self.redraw_cones();
        }
    }

    pub(super) fn redraw_cones(&mut self) {
        self.stamp(true, &[Part::Cones, Part::ChartCones]);
        self.dirty = [true; 2];
    }

    pub(super) fn glyphs(&self, view: View) -> Vec<Glyph> {
        match view {
            View::Surface => {
                let mut glyphs = cones::on_surface(&self.scene, self.drag);
                if let Some(patch) = self.isolated() {
                    let is_there = |&&[vertex, _]: &&[u32; 2]| {
                        self.scene.vertex_patches[vertex as usize] == patch
                    };
                    let places: &[[u32; 2]] = self.scene.cone_charts.as_chunks().0;
                    let there: Vec<u32> =
                        places.iter().filter(is_there).map(|&[_, cone]| cone).collect();
                    glyphs.retain(|glyph| there.contains(&glyph.cone));
                }
                glyphs
            }
            View::Flat => cones::on_charts(&self.scene, self.drag),
        }
    }

    /// The glyphs of the surface view without those that the surface hides, as far as it is worth to look at each.
    pub(super) fn glyphs_in_sight(&mut self) -> Vec<Glyph> {
        let mut glyphs = self.glyphs(View::Surface);
        glyphs.sort_by(|a, b| {
            let size = |glyph: &Glyph| cones::angle(&self.scene, glyph.cone).abs();
            size(b).total_cmp(&size(a))
        });
        let far = glyphs.split_off(glyphs.len().min(cones::LOOKED_AT));
        glyphs.retain_mut(|glyph| {
            glyph.is_seen = self.glyph_on_screen(View::Surface, glyph).is_some();
            glyph.is_seen
        });
        glyphs.extend(far);
        glyphs
    }

    /// Where a glyph is seen, and the radius of its disc, in CSS pixels; none where the surface hides it.
    pub(super) fn glyph_on_screen(&mut self, view: View, glyph: &Glyph) -> Option<(Vec2, f32)> {
        let (projection, viewport) = (self.projection(view), self.viewport(view));
        let angle = cones::angle(&self.scene, glyph.cone);
        let css = cones::to_screen(glyph.place, &projection, viewport)?;
        if view == View::Surface {
            let direction = glyph.place - projection.eye;
            let is_behind =
                |hit: Hit| hit.distance < 1.0 - cones::dent(angle, &projection, viewport);
            let ray = Ray { origin: projection.eye, direction };
            let is_turned = !cones::faces(glyph, projection.eye);
            if is_turned || !self.keeps(glyph.place) || self.cast(view, ray).is_some_and(is_behind)
            {
                return None;
            }
        }
        Some((css, cones::radius(angle, viewport)))
    }

    /// The cone whose glyph is seen within `slop` CSS pixels of a place of the screen, the nearest of several.
    pub fn pick_cone(&mut self, view: View, css: Vec2, slop: f32) -> Option<u32> {
        let (projection, viewport) = (self.projection(view), self.viewport(view));
        if viewport.is_empty() || !css.is_finite() {
            return None;
        }
        let mut near: Vec<(f32, Glyph)> = self
            .glyphs(view)
            .into_iter()
            .filter_map(|glyph| {
                let distance = cones::to_screen(glyph.place, &projection, viewport)?.distance(css);
                let reach = cones::radius(cones::angle(&self.scene, glyph.cone), viewport) + slop;
                (distance <= reach).then_some((distance, glyph))
            })
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.into_iter()
            .map(|(_, glyph)| glyph)
            .find(|glyph| self.glyph_on_screen(view, glyph).is_some())
            .map(|glyph| glyph.cone)
    }

    /// Draws a cone at a place of the screen, until a scene has other cones or it is dropped.
    ///
    /// **Gives** what lies there; where there is nothing, the cone stays where it was drawn last.
    pub fn drag_cone(&mut self, cone: u32, view: View, css: Vec2) -> Option<Pick> {
        let hit = self.hit(view, css)?;
        let pick = self.pick_of(hit);
        let corners = arrays::triangles(&self.scene)[pick.triangle as usize];
        let weighted = |place: &dyn Fn(u32) -> Vec3| -> Vec3 {
            corners.into_iter().zip(hit.weights).map(|(v, weight)| place(v) * weight).sum()
        };
        let normal = weighted(&|vertex| arrays::normal(&self.scene, vertex));
        let chart = weighted(&|vertex| arrays::chart(&self.scene, vertex)).truncate();
        self.drag = Some(Drag { cone, place: pick.place, normal, chart });
        self.redraw_cones();
        Some(pick)
    }

    /// Draws all cones where the scene has them again.
    pub fn drop_cone(&mut self) {
        if self.drag.take().is_some() {
            self.redraw_cones();
        }
    }

    /// `[cone, x, y, radius]` in CSS pixels of the glyphs that are seen and may have a label, the most important first:
    /// marked ones, then, on the surface, the largest.
    pub fn cone_labels(&mut self, view: View) -> Vec<[f32; 4]> {
        let viewport = self.viewport(view);
        let marks = self.cone_marks;
        let is_marked = |glyph: &Glyph| [marks.hover, marks.selected].contains(&glyph.cone);
        let mut glyphs = self.glyphs(view);
        glyphs.sort_by(|a, b| {
            let size = |glyph: &Glyph| cones::angle(&self.scene, glyph.cone).abs();
            is_marked(b).cmp(&is_marked(a)).then(size(b).total_cmp(&size(a)))
        });
        let most = if view == View::Surface { CONE_LABELS } else { 0 };
        let mut labels = Vec::new();
        for (i, glyph) in glyphs.iter().enumerate() {
            if i >= most && !is_marked(glyph) {
                break;
            }
            if let Some((css, radius)) = self.glyph_on_screen(view, glyph)
                && css.cmpge(Vec2::ZERO).all()
                && css.cmple(viewport.size).all()
            {
                labels.push([glyph.cone as f32, css.x, css.y, radius]);
            }
        }
        labels
    }
}
