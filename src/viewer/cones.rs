//! Cones as glyphs: discs of constant size on the screen, their area as the angle, their colour by its sign.
//!
//! Pure, like [`arrays`]: what a scene says of its cones becomes bytes here, and places on the screen.
//! Guaranteed: every cone has one glyph on the surface, and one on the flattened view for each finite place that
//! it has there; the smaller of two lies on top, and what is pointed at above all. Not guaranteed: that a glyph whose
//! vertex is just behind the edge of the surface is hidden to the last pixel.

use super::arrays::{self, NONE};
use super::camera::{Projection, Viewport};
use super::color::{self, Rgb};
use crate::session::scene::Scene;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Bytes per glyph: place `f32 × 3`, radius `f32`, normal `i8 × 4`, colour `u8 × 4`, marks `u8 × 4`.
pub const GLYPH_STRIDE: u64 = 28;
/// Radius of the coloured disc of a cone of π, in CSS pixels: as heavy as a label beside it.
const RADIUS: f32 = 7.0;
/// The smallest disc whose colour can be told, and the largest that hides nothing of interest.
const RADII: [f32; 2] = [2.4, 10.5];
/// Side of a view in CSS pixels below which discs are smaller, and how much smaller at most: on a phone they would hide
/// the surface.
const ROOM: f32 = 400.0;
const CROWDED: f32 = 0.65;
/// Widths of the light ring around the coloured disc and of the dark one around that, in CSS pixels.
pub const RINGS: [f32; 2] = [1.5, 0.8];
/// Glyphs beyond these are left to the depth test of the graphics device, which may cut a disc in two at the edge of
/// the surface; these are looked at one by one, which costs about 5 µs each.
pub const LOOKED_AT: usize = 256;
/// How far a glyph is lifted towards the eye, in radii, where the device decides: as much as the surface rises within
/// it on a slope of 70°.
pub const LIFT: f32 = 3.0;
/// The same where the surface is met by a ray: as far as a vertex may lie within its own dent.
const DENT: f32 = 1.0;
/// Cosine between normal and eye below which the surface turns the glyph away. Below zero, since the normal at a
/// sharp tip stands for all sides of it.
pub const TURNED: f32 = -0.25;

/// Radius of the coloured disc, CSS pixels: its area is proportional to the angle within [`RADII`].
pub fn radius(angle: f32, viewport: Viewport) -> f32 {
    let room = (viewport.size.min_element() / ROOM).clamp(CROWDED, 1.0);
    (RADIUS * room * (angle.abs() / PI).sqrt()).clamp(RADII[0], RADII[1])
}

/// Colour of an angle: the diverging map of signed fields, blue for saddles and red for tops, without its pale middle.
pub fn colour(angle: f32) -> Rgb {
    let strength = 0.45 + 0.55 * (angle.abs() / PI).min(1.0);
    color::diverging(0.5 + 0.5 * strength.copysign(angle))
}

/// What is said of single cones; [`NONE`] for none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Marks {
    /// The one under the pointer.
    pub hover: u32,
    /// The chosen one.
    pub selected: u32,
}

impl Default for Marks {
    fn default() -> Self {
        Self { hover: NONE, selected: NONE }
    }
}

/// A cone on its way to another place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drag {
    /// Which one.
    pub cone: u32,
    /// Where it is now, on the surface.
    pub place: Vec3,
    /// The normal there.
    pub normal: Vec3,
    /// The same place on the charts; NaN without chart.
    pub chart: Vec2,
}

/// A cone in one of its places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glyph {
    /// Which cone.
    pub cone: u32,
    /// Where; z = 0 on the charts.
    pub place: Vec3,
    /// The normal there; zero where the glyph is seen from everywhere.
    pub normal: Vec3,
    /// Whether it is known to be seen, so that nothing hides a part of it.
    pub is_seen: bool,
}

/// How many cones a scene has.
pub fn count(scene: &Scene) -> usize {
    scene.cone_angles.len()
}

/// Angle of a cone, radians; zero for an unknown one.
pub fn angle(scene: &Scene, cone: u32) -> f32 {
    scene.cone_angles.get(cone as usize).copied().unwrap_or(0.0)
}

/// The glyphs on the surface, one for each cone, in their order.
pub fn on_surface(scene: &Scene, drag: Option<Drag>) -> Vec<Glyph> {
    if count(scene) == 0 {
        return Vec::new();
    }
    // Through a hole one sees the inside, and the cones from behind.
    let is_closed = !scene.rim_partners.contains(&NONE);
    let mut normals = vec![Vec3::ZERO; count(scene)];
    for &[vertex, cone] in places(scene) {
        normals[cone as usize] += arrays::normal(scene, vertex);
    }
    (0..)
        .zip(scene.cone_points.as_chunks().0)
        .map(|(cone, &point)| match drag {
            Some(drag) if drag.cone == cone => (cone, drag.place, drag.normal),
            _ => (cone, Vec3::from_array(point), normals[cone as usize]),
        })
        .map(|(cone, place, normal)| {
            let normal = if is_closed { normal.normalize_or_zero() } else { Vec3::ZERO };
            Glyph { cone, place, normal, is_seen: false }
        })
        .collect()
}

/// The glyphs on the flattened view: a cone has one where each of its seams ends.
pub fn on_charts(scene: &Scene, drag: Option<Drag>) -> Vec<Glyph> {
    let glyph = |cone, place: Vec3| Glyph { cone, place, normal: Vec3::ZERO, is_seen: true };
    let dragged = drag.map(|drag| glyph(drag.cone, drag.chart.extend(0.0)));
    places(scene)
        .iter()
        .filter(|&&[_, cone]| dragged.is_none_or(|dragged| dragged.cone != cone))
        .map(|&[vertex, cone]| glyph(cone, arrays::chart(scene, vertex)))
        .chain(dragged)
        .filter(|glyph| glyph.place.is_finite())
        .collect()
}

fn places(scene: &Scene) -> &[[u32; 2]] {
    scene.cone_charts.as_chunks().0
}

/// Glyphs as bytes, in the order in which they are drawn.
pub fn bytes(scene: &Scene, mut glyphs: Vec<Glyph>, marks: Marks, viewport: Viewport) -> Vec<u8> {
    let is_marked = |cone| cone == marks.selected || cone == marks.hover;
    glyphs.sort_by(|a, b| {
        let size = |glyph: &Glyph| angle(scene, glyph.cone).abs();
        is_marked(a.cone).cmp(&is_marked(b.cone)).then(size(b).total_cmp(&size(a)))
    });
    let mut bytes = Vec::with_capacity(glyphs.len() * GLYPH_STRIDE as usize);
    for glyph in glyphs {
        let angle = angle(scene, glyph.cone);
        arrays::push_floats(&mut bytes, &glyph.place.to_array());
        arrays::push_floats(&mut bytes, &[radius(angle, viewport)]);
        let [x, y, z] = glyph.normal.to_array().map(|x| (x * 127.0).round() as i8);
        let hides = i8::from(glyph.normal != Vec3::ZERO) * 127;
        bytes.extend([x, y, z, hides].map(i8::cast_unsigned));
        bytes.extend(colour(angle).bytes());
        let mark = |marked: u32| u8::from(glyph.cone == marked) * u8::MAX;
        let seen = u8::from(glyph.is_seen) * u8::MAX;
        bytes.extend([mark(marks.hover), mark(marks.selected), seen, 0]);
    }
    bytes
}

/// Where a place of the world is seen, in CSS pixels; none behind the eye.
pub fn to_screen(place: Vec3, projection: &Projection, viewport: Viewport) -> Option<Vec2> {
    let clip = projection.world_to_clip * place.extend(1.0);
    let ndc = clip.truncate().truncate() / clip.w;
    let css = (ndc * Vec2::new(0.5, -0.5) + 0.5) * viewport.size;
    (clip.w > 1e-4 && css.is_finite()).then_some(css)
}

/// Which part of the way to the eye may lie between a glyph and the surface that hides it.
pub fn dent(angle: f32, projection: &Projection, viewport: Viewport) -> f32 {
    let is_perspective = f32::from(u8::from(projection.perspective));
    let reach = (radius(angle, viewport) + RINGS[0] + RINGS[1]) * viewport.scale;
    (DENT * reach * projection.pixel * is_perspective).min(0.5)
}

/// Whether the surface under a glyph looks towards the eye, or is one that is seen from both sides.
pub fn faces(glyph: &Glyph, eye: Vec3) -> bool {
    glyph.normal == Vec3::ZERO || glyph.normal.dot((eye - glyph.place).normalize_or_zero()) > TURNED
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{two_squares, unit_ball};
    use super::*;

    const WIDE: Viewport = Viewport { size: Vec2::new(600.0, 500.0), scale: 1.0 };

    /// The two squares with a cone in the corner that both have, and one in a corner of the first.
    fn with_cones() -> Scene {
        Scene {
            cone_points: vec![0.0, 0.0, 0.0, -1.0, 0.0, 0.0],
            cone_angles: vec![0.5 * PI, -0.25 * PI],
            cone_charts: vec![1, 0, 4, 0, 0, 1],
            ..two_squares()
        }
    }

    fn cones_drawn(bytes: &[u8]) -> Vec<[f32; 4]> {
        let numbers = |glyph: &[u8; 28]| {
            [0, 4, 8, 12].map(|at| {
                f32::from_le_bytes([glyph[at], glyph[at + 1], glyph[at + 2], glyph[at + 3]])
            })
        };
        bytes.as_chunks::<28>().0.iter().map(numbers).collect()
    }

    #[test]
    fn a_cone_has_one_glyph_on_the_surface_and_one_for_each_place_on_the_charts() {
        let scene = with_cones();
        let surface: Vec<u32> = on_surface(&scene, None).iter().map(|glyph| glyph.cone).collect();
        assert_eq!(surface, [0, 1]);
        let charts = on_charts(&scene, None);
        let places: Vec<(u32, f32)> =
            charts.iter().map(|glyph| (glyph.cone, glyph.place.x)).collect();
        assert_eq!(places, [(0, 1.0), (0, 1.25), (1, 0.0)]);
        let mut hidden = scene;
        hidden.charts[0] = f32::NAN;
        assert_eq!(on_charts(&hidden, None).len(), 2, "a place without a chart has no glyph");
    }

    #[test]
    fn the_area_of_a_disc_is_as_the_angle() {
        let (small, large) = (radius(0.3 * PI, WIDE), radius(-1.2 * PI, WIDE));
        assert!(((large / small).powi(2) - 4.0).abs() < 1e-4);
        assert!(radius(0.0, WIDE) > 2.0 && radius(100.0, WIDE) < 12.0);
        let phone = Viewport { size: Vec2::new(390.0, 220.0), scale: 3.0 };
        assert!(radius(PI, phone) < 0.7 * radius(PI, WIDE));
    }

    #[test]
    fn tops_are_red_and_saddles_blue_whatever_their_size() {
        for size in [0.01, 0.4, 3.0, 9.0] {
            let ([red, _, blue], [red_below, _, blue_below]) = (colour(size).0, colour(-size).0);
            assert!(red > blue + 0.1, "{size}");
            assert!(blue_below > red_below + 0.1, "-{size}");
        }
    }

    #[test]
    fn every_glyph_has_its_stride_and_the_marked_one_lies_on_top() {
        let scene = with_cones();
        let order = |marks| {
            let drawn = bytes(&scene, on_surface(&scene, None), marks, WIDE);
            assert_eq!(drawn.len(), 2 * GLYPH_STRIDE as usize);
            cones_drawn(&drawn).iter().map(|glyph| glyph[0]).collect::<Vec<f32>>()
        };
        assert_eq!(order(Marks::default()), [0.0, -1.0], "the smaller one is drawn later");
        assert_eq!(order(Marks { selected: 0, ..Marks::default() }), [-1.0, 0.0]);
    }

    #[test]
    fn a_dragged_cone_is_drawn_where_it_is_dragged_in_both_views() {
        let scene = with_cones();
        let place = Vec3::new(0.5, 0.5, 0.0);
        let drag = Drag { cone: 0, place, normal: Vec3::Z, chart: Vec2::new(1.75, 0.5) };
        assert_eq!(on_surface(&scene, Some(drag))[0].place, place);
        let charts = on_charts(&scene, Some(drag));
        assert_eq!(charts.len(), 2, "its old places are gone");
        assert_eq!(charts[1].place, Vec3::new(1.75, 0.5, 0.0));
        let off_chart = Drag { chart: Vec2::NAN, ..drag };
        assert_eq!(on_charts(&scene, Some(off_chart)).len(), 1);
    }

    #[test]
    fn a_glyph_on_a_closed_surface_turns_away_with_it_and_on_an_open_one_does_not() {
        let ball = Scene {
            cone_points: vec![0.0, 0.0, 1.0],
            cone_angles: vec![1.0],
            cone_charts: vec![2, 0],
            ..unit_ball(0, 0)
        };
        let [glyph] = on_surface(&ball, None)[..] else { panic!("one cone") };
        assert_eq!(glyph.normal, Vec3::Z);
        assert!(faces(&glyph, Vec3::Z * 4.0) && !faces(&glyph, Vec3::NEG_Z * 4.0));
        let open = with_cones();
        assert!(on_surface(&open, None).iter().all(|glyph| faces(glyph, Vec3::NEG_Z * 4.0)));
    }
}
