//! What the pointer shows in both views: the place under it, the seam beside it, pinned values, a measured way.
//!
//! Nothing here costs anything until somebody points: seams are found along the rims when they are asked for.

use super::super::arrays::{self, NONE};
use super::super::brush;
use super::super::camera::{Projection, Ray};
use super::super::cones;
use super::super::pick::Hit;
use super::{Part, Pick, Stage, View};
use crate::session::scene::Scene;
use glam::{Vec2, Vec3};

/// Points along the thread from one side of a seam to the other.
const THREAD: usize = 24;
/// How far a thread bows out, as a part of its length: enough to be told from an outline.
const BOW: f32 = 0.16;
/// A point this far behind the surface is hidden by it, in the unit of the scene.
const HIDDEN: f32 = 0.015;
/// Pins that can be set.
pub const MOST_PINS: usize = 8;

/// A point of the surface that is found again in later scenes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Anchor {
    triangle: u32,
    weights: [f32; 3],
    face: u32,
    /// Where it was set.
    place: Vec3,
}

impl Anchor {
    fn corners(&self, scene: &Scene) -> [(u32, f32); 3] {
        let corners = arrays::triangles(scene)[self.triangle as usize];
        [0, 1, 2].map(|i| (corners[i], self.weights[i]))
    }

    fn place(&self, scene: &Scene) -> Vec3 {
        self.corners(scene).map(|(v, weight)| arrays::position(scene, v) * weight).into_iter().sum()
    }

    /// NaN where there is no chart.
    fn chart(&self, scene: &Scene) -> Vec3 {
        self.corners(scene).map(|(v, weight)| arrays::chart(scene, v) * weight).into_iter().sum()
    }

    fn patch(&self, scene: &Scene) -> u32 {
        scene.vertex_patches[self.corners(scene)[0].0 as usize]
    }

    /// NaN where there is no field, or none here.
    fn value(&self, scene: &Scene) -> f32 {
        let value = |(v, weight): (u32, f32)| {
            scene.values.get(v as usize).map_or(f32::NAN, |value| value * weight)
        };
        self.corners(scene).map(value).into_iter().sum()
    }

    /// The same point in a scene with other triangles: the one of its face that it lies in, or nearest to.
    fn found_again(&self, scene: &Scene) -> Option<Self> {
        let mut best: Option<(f32, Self)> = None;
        for (triangle, &face) in (0..).zip(&scene.triangle_faces) {
            if face != self.face {
                continue;
            }
            let corners = arrays::triangles(scene)[triangle as usize];
            let [a, b, c] = corners.map(|v| arrays::position(scene, v));
            let normal = (b - a).cross(c - a);
            let weight = |p: Vec3, q: Vec3| (p - self.place).cross(q - self.place).dot(normal);
            let weights = [weight(b, c), weight(c, a), weight(a, b)];
            let sum: f32 = weights.iter().sum();
            if sum <= 0.0 {
                continue;
            }
            let weights = weights.map(|w| w / sum);
            let least = weights[0].min(weights[1]).min(weights[2]);
            if best.is_none_or(|(known, _)| least > known) {
                // Beside all of them by rounding, or because the cut has moved: onto the rim.
                let inside = weights.map(|w| w.max(0.0));
                let sum: f32 = inside.iter().sum();
                let weights = inside.map(|w| w / sum);
                best = Some((least, Self { triangle, weights, ..*self }));
            }
        }
        best.map(|(_, anchor)| anchor)
    }
}

/// A stretch of cut from one junction to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Seam {
    /// Rim segments of one side, in order.
    segments: Vec<u32>,
    /// The pieces that it joins, the one under the pointer first; one and the same for a dart.
    pub patches: [u32; 2],
    /// Its length on the surface, in the unit of the scene.
    pub length: f32,
}

/// What is under the pointer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pointed {
    /// The place, where there is one.
    pub pick: Option<Pick>,
    /// The field's value there; NaN where there is none.
    pub value: f32,
    /// The seam beside it.
    pub seam: Option<Seam>,
}

/// A pinned value as a view shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinLabel {
    /// Which pin.
    pub pin: u32,
    /// Where it is, in CSS pixels.
    pub place: Vec2,
    /// The field's value there.
    pub value: f32,
    /// Whether the surface hides the point.
    pub is_hidden: bool,
}

/// What is pointed at.
#[derive(Debug, Default)]
pub(super) struct Pointing {
    /// The place under the pointer, marked in the view that the pointer is not over.
    probe: Option<(View, Anchor)>,
    seam: Option<Seam>,
    pins: Vec<(u32, Anchor)>,
    last_pin: u32,
    /// The ends of what is measured.
    ends: Vec<Anchor>,
    /// The way between them along the surface.
    path: Vec<Vec3>,
}

impl Pointing {
    pub(super) fn has_seam(&self) -> bool {
        self.seam.is_some()
    }
}

impl Stage {
    /// Takes notice of another scene: points are found again, what cannot be is given up.
    pub(super) fn point_at_scene(&mut self, is_new_mesh: bool, triangles: bool, rims: bool) {
        let scene = &self.scene;
        let pointing = &mut self.pointing;
        let was_pointed = pointing.probe.is_some() || pointing.seam.is_some();
        let was_measured = !pointing.ends.is_empty();
        if is_new_mesh {
            pointing.pins.clear();
            pointing.ends.clear();
        } else if triangles {
            let find = |anchor: &Anchor| anchor.found_again(scene);
            pointing.pins = pointing
                .pins
                .iter()
                .filter_map(|(pin, anchor)| Some((*pin, find(anchor)?)))
                .collect();
            pointing.ends = pointing.ends.iter().filter_map(find).collect();
        }
        if pointing.ends.len() < 2 {
            pointing.path.clear();
        }
        if triangles || is_new_mesh {
            pointing.probe = None;
        }
        if triangles || rims || is_new_mesh {
            pointing.seam = None;
        }
        // Its points may lie elsewhere now, on the surface or on the sheet.
        self.stamp(was_pointed, &POINTED);
        self.stamp(was_pointed, &[Part::Outline, Part::ChartOutline]);
        self.stamp(was_measured, &MEASURED);
    }

    fn anchor_of(&self, hit: Hit) -> Anchor {
        let face = self.scene.triangle_faces[hit.triangle as usize];
        let place = self.on_surface(hit);
        Anchor { triangle: hit.triangle, weights: hit.weights, face, place }
    }

    /// Points at a place of the screen: what lies there is marked in the other view, and a seam within `reach` CSS pixels in both.
    pub fn point(&mut self, view: View, css: Vec2, reach: f32) -> Pointed {
        let hit = self.hit(view, css);
        let anchor = hit.map(|hit| self.anchor_of(hit));
        let seam = self.seam_near(view, css, hit, reach);
        let value = anchor.map_or(f32::NAN, |anchor| anchor.value(&self.scene));
        self.show_pointed(anchor.map(|anchor| (view, anchor)), seam.clone());
        Pointed { pick: hit.map(|hit| self.pick_of(hit)), value, seam }
    }

    /// Points at nothing.
    pub fn point_away(&mut self) {
        self.show_pointed(None, None);
    }

    fn show_pointed(&mut self, probe: Option<(View, Anchor)>, seam: Option<Seam>) {
        if probe != self.pointing.probe {
            // Each view marks what the pointer is on in the other one.
            for (from, _) in [self.pointing.probe, probe].into_iter().flatten() {
                let (part, other) = match from {
                    View::Surface => (Part::ChartMarker, View::Flat),
                    View::Flat => (Part::Marker, View::Surface),
                };
                self.stamp(true, &[part]);
                self.dirty[other as usize] = true;
            }
            self.pointing.probe = probe;
        }
        if seam != self.pointing.seam {
            self.pointing.seam = seam;
            // Outlines make room for the seam.
            self.stamp(true, &POINTED);
            self.stamp(true, &[Part::Outline, Part::ChartOutline]);
            self.dirty = [true; 2];
        }
    }

    /// The seam beside a place: of the piece under it, or on the sheet of any.
    fn seam_near(&self, view: View, css: Vec2, hit: Option<Hit>, reach: f32) -> Option<Seam> {
        let (scene, viewport) = (&self.scene, self.viewport(view));
        if !css.is_finite() || viewport.is_empty() || self.shows_layers() {
            return None;
        }
        let (point, reach, only) = match view {
            View::Surface => {
                let pick = self.pick_of(hit?);
                let pixels = brush::pixels(1.0, pick.place, &self.projection(view), viewport.scale);
                (pick.place, reach / pixels, Some(pick.patch))
            }
            View::Flat => {
                let place = self.sheet.to_sheet(css, viewport).extend(0.0);
                (place, reach / self.sheet.pixels_per_unit(), None)
            }
        };
        let mut best: Option<(f32, u32)> = None;
        for (segment, &[a, b]) in (0..).zip(arrays::rims(scene)) {
            let is_cut = scene.rim_partners[segment as usize] != NONE;
            if !is_cut || only.is_some_and(|only| scene.vertex_patches[a as usize] != only) {
                continue;
            }
            let [a, b] = [a, b].map(|vertex| match view {
                View::Surface => arrays::position(scene, vertex),
                View::Flat => arrays::chart(scene, vertex),
            });
            let (along, off) = (b - a, point - a);
            let t = (off.dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
            let distance = (off - along * t).length();
            // A chart that is missing is nowhere near.
            if distance <= reach && best.is_none_or(|(known, _)| distance < known) {
                best = Some((distance, segment));
            }
        }
        best.map(|(_, segment)| self.seam_of(segment))
    }

    /// The whole seam that a rim segment is a part of: on from segment to segment as long as the segments across follow each
    /// other as well.
    fn seam_of(&self, segment: u32) -> Seam {
        let scene = &self.scene;
        let across = |segment: u32| scene.rim_partners[segment as usize];
        let neighbour = |segment: u32, side: usize| self.neighbours[segment as usize][side];
        let follows = |segment: u32, next: u32| {
            let is_cut = next != NONE && across(next) != NONE && across(segment) != NONE;
            is_cut && neighbour(across(segment), 0) == across(next)
        };
        let mut segments = vec![segment];
        let mut last = segment;
        loop {
            let next = neighbour(last, 1);
            if next == segment || segments.len() > scene.rims.len() || !follows(last, next) {
                break;
            }
            segments.push(next);
            last = next;
        }
        let is_closed = neighbour(last, 1) == segment && follows(last, segment);
        let mut before = Vec::new();
        let mut first = segment;
        while !is_closed && before.len() <= scene.rims.len() {
            let previous = neighbour(first, 0);
            if previous == NONE || previous == segment || !follows(previous, first) {
                break;
            }
            before.push(previous);
            first = previous;
        }
        before.reverse();
        before.extend(segments);
        let rims = arrays::rims(scene);
        let length = |&segment: &u32| {
            let [a, b] = rims[segment as usize].map(|vertex| arrays::position(scene, vertex));
            a.distance(b)
        };
        let patch = |segment: u32| scene.vertex_patches[rims[segment as usize][0] as usize];
        Seam {
            length: before.iter().map(length).sum(),
            patches: [patch(segment), patch(across(segment))],
            segments: before,
        }
    }

    /// A side of the seam as a line, in the direction of its first side.
    fn seam_line(&self, is_far: bool, place: impl Fn(u32) -> Vec3) -> Vec<Vec3> {
        let Some(seam) = &self.pointing.seam else { return Vec::new() };
        let rims = arrays::rims(&self.scene);
        let ends = |&segment: &u32| {
            let near = rims[segment as usize];
            let [from, to] = if is_far {
                let [to, from] = rims[self.scene.rim_partners[segment as usize] as usize];
                [from, to]
            } else {
                near
            };
            [place(from), place(to)]
        };
        let mut line: Vec<Vec3> = seam.segments.iter().take(1).map(|s| ends(s)[0]).collect();
        line.extend(seam.segments.iter().map(|segment| ends(segment)[1]));
        if line.iter().all(|place| place.is_finite()) { line } else { Vec::new() }
    }

    /// A bow from the middle of one side of the seam to that of the other.
    fn thread(&self) -> Vec<Vec3> {
        let side = |is_far| middle_of(&self.seam_line(is_far, |v| arrays::chart(&self.scene, v)));
        let (Some(from), Some(to)) = (side(false), side(true)) else { return Vec::new() };
        let way = to - from;
        if way.length() < 1e-4 {
            return Vec::new();
        }
        let bow = (from + to) / 2.0 + Vec3::new(-way.y, way.x, 0.0) * BOW;
        let at = |i: usize| {
            let t = i as f32 / THREAD as f32;
            from.lerp(bow, t).lerp(bow.lerp(to, t), t)
        };
        (0..=THREAD).map(at).collect()
    }

    /// Pins the value at a place of the screen. **Gives** the pin, none where there is nothing to pin.
    pub fn add_pin(&mut self, view: View, css: Vec2) -> Option<u32> {
        let hit = self.hit(view, css).filter(|_| self.shows_field())?;
        let anchor = self.anchor_of(hit);
        let pointing = &mut self.pointing;
        pointing.last_pin += 1;
        pointing.pins.push((pointing.last_pin, anchor));
        if pointing.pins.len() > MOST_PINS {
            pointing.pins.remove(0);
        }
        let pin = pointing.last_pin;
        self.dirty = [true; 2];
        Some(pin)
    }

    /// Takes a pin away.
    pub fn remove_pin(&mut self, pin: u32) {
        self.pointing.pins.retain(|(other, _)| *other != pin);
        self.dirty = [true; 2];
    }

    /// The pins that lie within a view. There are none while no field is shown.
    pub fn pin_labels(&mut self, view: View) -> Vec<PinLabel> {
        if !self.shows_field() {
            return Vec::new();
        }
        let (projection, viewport) = (self.projection(view), self.viewport(view));
        let mut labels = Vec::new();
        for (pin, anchor) in self.pointing.pins.clone() {
            let value = anchor.value(&self.scene);
            let Some((css, is_hidden)) = self.on_screen(view, &anchor, &projection) else {
                continue;
            };
            let is_inside = css.cmpge(Vec2::ZERO).all() && css.cmple(viewport.size).all();
            if is_inside {
                labels.push(PinLabel { pin, place: css, value, is_hidden });
            }
        }
        labels
    }

    /// Where a point is on the screen, and whether the surface hides it; none where it is not drawn at all.
    fn on_screen(
        &mut self,
        view: View,
        anchor: &Anchor,
        projection: &Projection,
    ) -> Option<(Vec2, bool)> {
        let viewport = self.viewport(view);
        let place = match view {
            View::Surface => anchor.place(&self.scene),
            View::Flat => anchor.chart(&self.scene),
        };
        let css = place.is_finite().then(|| cones::to_screen(place, projection, viewport))??;
        if view == View::Flat {
            return (!self.shows_layers()).then_some((css, false));
        }
        let is_alone = self.isolated().is_none_or(|patch| anchor.patch(&self.scene) == patch);
        if !is_alone || !self.keeps(place) {
            return None;
        }
        let direction = place - projection.eye;
        let ray = Ray { origin: projection.eye, direction };
        let distance = self.cast(View::Surface, ray).map_or(f32::MAX, |hit| hit.distance);
        Some((css, (1.0 - distance) * direction.length() > HIDDEN))
    }

    /// Sets an end of what is to be measured; a third one begins anew. **Gives** what lies there.
    pub fn add_end(&mut self, view: View, css: Vec2) -> Option<Pick> {
        let hit = self.hit(view, css)?;
        if self.pointing.ends.len() != 1 {
            self.clear_measure();
        }
        let anchor = self.anchor_of(hit);
        self.pointing.ends.push(anchor);
        self.stamp(true, &MEASURED);
        self.dirty = [true; 2];
        Some(self.pick_of(hit))
    }

    /// The way along the surface between both ends, as the engine found it.
    pub fn set_path(&mut self, path: Vec<Vec3>) {
        if self.pointing.ends.len() == 2 && path.iter().all(|place| place.is_finite()) {
            self.pointing.path = path;
            self.stamp(true, &MEASURED);
            self.dirty = [true; 2];
        }
    }

    /// Measures nothing.
    pub fn clear_measure(&mut self) {
        if !self.pointing.ends.is_empty() {
            self.pointing.ends.clear();
            self.pointing.path.clear();
            self.stamp(true, &MEASURED);
            self.dirty = [true; 2];
        }
    }

    /// How many ends of what is measured there are.
    pub fn end_count(&self) -> usize {
        self.pointing.ends.len()
    }

    /// The straight line on the chart between both ends, where they lie on one.
    fn chart_path(&self) -> Option<[Vec3; 2]> {
        let [from, to] = &self.pointing.ends[..] else { return None };
        let is_one = from.patch(&self.scene) == to.patch(&self.scene);
        let line = [from, to].map(|end| end.chart(&self.scene));
        (is_one && line.iter().all(|place| place.is_finite())).then_some(line)
    }

    /// Length of the straight line on the chart between both ends, in the unit of the scene; NaN where they lie on two charts.
    pub fn chart_length(&self) -> f32 {
        self.chart_path().map_or(f32::NAN, |[from, to]| from.distance(to))
    }

    /// Where the label of what is measured stands in a view, in CSS pixels: the middle of its line.
    pub fn measure_label(&self, view: View) -> Option<Vec2> {
        let middle = match view {
            View::Surface => middle_of(&self.pointing.path)?,
            View::Flat => middle_of(&self.chart_path()?)?,
        };
        let viewport = self.viewport(view);
        let css = cones::to_screen(middle, &self.projection(view), viewport)?;
        (css.cmpge(Vec2::ZERO).all() && css.cmple(viewport.size).all()).then_some(css)
    }

    /// The bytes of the parts of this module.
    pub(super) fn pointed_bytes(&self, part: Part) -> Vec<u8> {
        let scene = &self.scene;
        let marker = |over: View| match self.pointing.probe {
            Some((view, anchor)) if view == over => {
                let place = match over {
                    View::Surface => anchor.chart(scene),
                    View::Flat => anchor.place(scene),
                };
                if place.is_finite() { arrays::disc_ribbons(&[place]) } else { Vec::new() }
            }
            _ => Vec::new(),
        };
        let ends = |place: &dyn Fn(&Anchor) -> Vec3| -> Vec<u8> {
            let places = self.pointing.ends.iter().map(place).filter(|place| place.is_finite());
            arrays::disc_ribbons(&places.collect::<Vec<_>>())
        };
        match part {
            Part::Marker => marker(View::Flat),
            Part::ChartMarker => marker(View::Surface),
            Part::Seam => {
                arrays::line_ribbons(&self.seam_line(false, |v| arrays::position(scene, v)))
            }
            Part::ChartSeam => [false, true]
                .map(|is_far| {
                    arrays::line_ribbons(&self.seam_line(is_far, |v| arrays::chart(scene, v)))
                })
                .concat(),
            Part::SeamThread => arrays::line_ribbons(&self.thread()),
            Part::Path => arrays::line_ribbons(&self.pointing.path),
            Part::ChartPath => arrays::line_ribbons(self.chart_path().as_ref().map_or(&[], |l| l)),
            Part::PathEnds => ends(&|end| end.place(scene)),
            Part::ChartPathEnds => ends(&|end| end.chart(scene)),
            _ => Vec::new(),
        }
    }
}

/// What shows the place under the pointer and the seam beside it.
const POINTED: [Part; 5] =
    [Part::Marker, Part::ChartMarker, Part::Seam, Part::ChartSeam, Part::SeamThread];
/// What shows a measured way.
const MEASURED: [Part; 4] = [Part::Path, Part::ChartPath, Part::PathEnds, Part::ChartPathEnds];

/// The point halfway along a line.
fn middle_of(line: &[Vec3]) -> Option<Vec3> {
    let total: f32 = line.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    let mut left = total / 2.0;
    for pair in line.windows(2) {
        let length = pair[0].distance(pair[1]);
        if left <= length {
            return Some(pair[0].lerp(pair[1], left / length.max(1e-30)));
        }
        left -= length;
    }
    line.last().copied()
}

#[cfg(test)]
mod tests {
    use super::super::super::camera::{Side, Viewport};
    use super::super::super::fixtures::two_squares;
    use super::super::tests::stage;
    use super::*;
    use crate::session::scene::FieldScene;

    fn flat(stage: &Stage, x: f32, y: f32) -> Vec2 {
        stage.sheet.to_screen(Vec2::new(x, y), stage.viewport(View::Flat))
    }

    fn from_front() -> Stage {
        let mut stage = stage(two_squares());
        stage.fly_to_side(Side::Front);
        stage.fly(1.0);
        stage
    }

    fn on_surface(stage: &Stage, place: Vec3) -> Vec2 {
        let (projection, viewport) =
            (stage.projection(View::Surface), stage.viewport(View::Surface));
        cones::to_screen(place, &projection, viewport).expect("in front")
    }

    fn floats(bytes: &[u8]) -> Vec<f32> {
        bytes.as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect()
    }

    #[test]
    fn what_is_pointed_at_in_one_view_is_marked_in_the_other() {
        let mut stage = from_front();
        let pointed = stage.point(View::Flat, flat(&stage, 1.75, 0.25), 6.0);
        assert_eq!(pointed.pick.map(|pick| pick.patch), Some(1));
        assert!(pointed.value.is_nan() && pointed.seam.is_none());
        let place = floats(&stage.bytes(Part::Marker));
        assert!(Vec3::from_slice(&place).distance(Vec3::new(0.5, 0.25, 0.0)) < 1e-3);
        assert!(stage.bytes(Part::ChartMarker).is_empty());
        let css = on_surface(&stage, Vec3::new(-0.5, 0.25, 0.0));
        stage.point(View::Surface, css, 6.0);
        let place = floats(&stage.bytes(Part::ChartMarker));
        assert!(Vec3::from_slice(&place).distance(Vec3::new(0.5, 0.25, 0.0)) < 1e-2);
        assert!(stage.bytes(Part::Marker).is_empty());
        stage.take_dirty(View::Surface);
        stage.take_dirty(View::Flat);
        stage.point_away();
        assert!(stage.bytes(Part::ChartMarker).is_empty());
        assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [false, true]);
    }

    #[test]
    fn near_a_cut_both_sides_of_the_seam_are_shown_with_a_thread_between_them() {
        let mut stage = from_front();
        let css = flat(&stage, 1.0, 0.5) + Vec2::new(-2.0, 0.0);
        let seam = stage.point(View::Flat, css, 6.0).seam.expect("the cut");
        assert_eq!(seam.patches, [0, 1]);
        assert!((seam.length - 1.0).abs() < 1e-6);
        assert_eq!(stage.bytes(Part::Seam).len(), 60);
        assert_eq!(stage.bytes(Part::ChartSeam).len(), 120);
        let thread = floats(&stage.bytes(Part::SeamThread));
        let ends = [&thread[3..], &thread[thread.len() - 9..]].map(Vec3::from_slice);
        assert!(ends[0].distance(Vec3::new(1.0, 0.5, 0.0)) < 1e-5, "{ends:?}");
        assert!(ends[1].distance(Vec3::new(1.25, 0.5, 0.0)) < 1e-5, "{ends:?}");
        // Beside the charts as well, and from the surface.
        assert!(stage.point(View::Flat, flat(&stage, 1.24, 0.4), 6.0).seam.is_some());
        let css = on_surface(&stage, Vec3::new(0.01, 0.5, 0.0));
        let seam = stage.point(View::Surface, css, 6.0).seam.expect("the cut");
        assert_eq!(seam.patches, [1, 0]);
        // The mesh's own boundary is no seam, and the middle of a piece is near none.
        assert_eq!(stage.point(View::Flat, flat(&stage, 0.01, 0.5), 6.0).seam, None);
        assert_eq!(stage.point(View::Flat, flat(&stage, 0.5, 0.5), 6.0).seam, None);
        assert!(stage.bytes(Part::SeamThread).is_empty());
    }

    #[test]
    fn a_seam_runs_on_to_the_next_junction_and_not_beyond() {
        // A strip of three segments across from two pieces: two of one seam, the third with another partner.
        let mut scene = two_squares();
        scene.positions.extend([0.0, 2.0, 0.0, 0.0, 3.0, 0.0].repeat(2));
        scene.normals.extend([0.0, 0.0, 1.0].repeat(4));
        scene.charts.extend([1.0, 2.0, 1.0, 3.0, 1.25, 2.0, 1.25, 3.0]);
        scene.vertex_patches.extend([0, 0, 1, 1]);
        // On from vertex 2 of the first square and back to vertex 7 of the second.
        scene.rims = vec![1, 2, 2, 8, 8, 9, 11, 10, 10, 7, 7, 4];
        scene.rim_partners = vec![5, 4, 3, 2, 1, 0];
        let mut stage = stage(scene.clone());
        let all = stage.point(View::Flat, flat(&stage, 1.0, 1.5), 6.0).seam.expect("a seam");
        assert!((all.length - 3.0).abs() < 1e-6, "{all:?}");
        // Across, the third segment does not follow the second.
        scene.rims.splice(6..8, [3, 0]);
        scene.revision = 1;
        stage.set_scene(scene).expect("a scene");
        let two = stage.point(View::Flat, flat(&stage, 1.0, 1.5), 6.0).seam.expect("a seam");
        assert!((two.length - 2.0).abs() < 1e-6, "{two:?}");
    }

    #[test]
    fn a_pin_stays_with_its_point_and_tells_the_value_there() {
        let mut stage = from_front();
        let css = on_surface(&stage, Vec3::new(-0.75, 0.5, 0.0));
        assert_eq!(stage.add_pin(View::Surface, css), None, "there is no value to pin");
        let field = Some(FieldScene { range: [0.0, 1.0], ..FieldScene::default() });
        let values = vec![0.0, 1.0, 1.0, 0.0, 5.0, 5.0, 5.0, 5.0];
        let scene = Scene { revision: 1, field, values, ..two_squares() };
        stage.set_scene(scene.clone()).expect("a scene");
        let pin = stage.add_pin(View::Surface, css).expect("a pin");
        let [label] = stage.pin_labels(View::Surface)[..] else { panic!("one label") };
        assert!(label.pin == pin && label.place.distance(css) < 0.1 && !label.is_hidden);
        assert!((label.value - 0.25).abs() < 1e-2);
        let [label] = stage.pin_labels(View::Flat)[..] else { panic!("one label") };
        assert!(label.place.distance(flat(&stage, 0.25, 0.5)) < 1.0);
        stage.rotate(Vec2::new(30.0, 10.0));
        let [label] = stage.pin_labels(View::Surface)[..] else { panic!("one label") };
        let turned = on_surface(&stage, Vec3::new(-0.75, 0.5, 0.0));
        assert!(label.place.distance(turned) < 0.5);
        // Other triangles of the same face, as after a step: the point is found again.
        let triangles = vec![1, 2, 3, 1, 3, 0, 4, 5, 6, 4, 6, 7];
        let other = Scene { triangles, revision: 2, ..scene.clone() };
        stage.set_scene(other).expect("a scene");
        let [label] = stage.pin_labels(View::Surface)[..] else { panic!("one label") };
        assert!(label.place.distance(turned) < 0.5 && (label.value - 0.25).abs() < 1e-2);
        for _ in 0..2 * MOST_PINS {
            stage.add_pin(View::Flat, flat(&stage, 1.5, 0.5));
        }
        assert_eq!(stage.pin_labels(View::Flat).len(), MOST_PINS);
        stage.set_scene(Scene { revision: 0, ..scene }).expect("a scene");
        assert!(stage.pin_labels(View::Flat).is_empty(), "another mesh has none");
    }

    #[test]
    fn a_measured_way_has_two_ends_and_a_line_on_the_chart_that_both_lie_on() {
        let mut stage = from_front();
        let at = |stage: &Stage, x| on_surface(stage, Vec3::new(x, 0.5, 0.0));
        let far = stage.add_end(View::Surface, at(&stage, -0.9)).expect("an end");
        assert_eq!(far.patch, 0);
        assert_eq!(stage.add_end(View::Surface, Vec2::new(2.0, 2.0)), None);
        stage.set_path(vec![Vec3::ZERO, Vec3::X]);
        assert!(stage.bytes(Part::Path).is_empty(), "one end is no way");
        stage.add_end(View::Surface, at(&stage, -0.1));
        stage.set_path(vec![Vec3::new(-0.9, 0.5, 0.0), Vec3::new(-0.1, 0.5, 0.0)]);
        assert_eq!(stage.bytes(Part::Path).len(), 60);
        assert!((stage.chart_length() - 0.8).abs() < 1e-2);
        let label = stage.measure_label(View::Surface).expect("a label");
        assert!(label.distance(at(&stage, -0.5)) < 0.1);
        assert!(stage.measure_label(View::Flat).is_some());
        stage.add_end(View::Surface, at(&stage, -0.5));
        assert_eq!((stage.end_count(), stage.bytes(Part::Path).len()), (1, 0));
        stage.add_end(View::Surface, at(&stage, 0.5));
        assert!(stage.chart_length().is_nan(), "two charts");
        stage.clear_measure();
        assert!(stage.bytes(Part::PathEnds).is_empty());
        stage.resize(View::Surface, Viewport::default());
    }
}
