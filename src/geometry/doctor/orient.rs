//! Orientation: neighbours that agree, closed parts that face outward.

use super::surface::{Surface, faces_inward};
use crate::mesh::Soup;
use crate::mesh::doctor::{Shape, Sides, turn};

/// Whether each patch has no edge but such with two sides that run in opposite directions once `turned` is turned.
pub(super) fn closed_patches(sides: &Sides, shape: &Shape) -> Vec<bool> {
    let mut is_closed = shape.patch_is_orientable.clone();
    for &edge in shape.boundary.iter().chain(&shape.crowded) {
        for &side in sides.of(edge as usize) {
            is_closed[shape.face_patches[sides.polygons[side as usize] as usize] as usize] = false;
        }
    }
    is_closed
}

/// The polygons to be turned so that neighbours agree, closed patches have positive volume, and in others the fewest
/// are turned.
pub(super) fn to_turn(soup: &Soup, sides: &Sides, shape: &Shape, surface: &Surface) -> Vec<bool> {
    let is_closed = closed_patches(sides, shape);
    let mut volumes = vec![0.0; is_closed.len()];
    let mut areas = vec![0.0; is_closed.len()];
    for polygon in 0..soup.polygon_count() {
        let volume = surface.volume(soup, polygon);
        let patch = shape.face_patches[polygon] as usize;
        areas[patch] += surface.area(soup, polygon);
        volumes[patch] += if shape.turned[polygon] { -volume } else { volume };
    }
    let turned = shape.turned.iter().zip(&shape.face_patches);
    turned
        .map(|(&is_turned, &patch)| {
            let patch = patch as usize;
            is_turned != (is_closed[patch] && faces_inward(volumes[patch], areas[patch]))
        })
        .collect()
}

/// Turns polygons so that neighbours agree where they can, closed parts (those inside others too) have positive volume,
/// and in open parts as few as possible are turned; counts them.
pub fn orient(soup: &Soup) -> (Soup, usize) {
    let sides = Sides::new(soup);
    let shape = Shape::new(soup, &sides);
    let is_turned = to_turn(soup, &sides, &shape, &Surface::new(soup));
    let count = is_turned.iter().filter(|&&turned| turned).count();
    (turn(soup, |i| is_turned[i as usize]), count)
}

/// Turns all polygons.
pub fn turn_inside_out(soup: &Soup) -> (Soup, usize) {
    (turn(soup, |_| true), soup.polygon_count())
}
