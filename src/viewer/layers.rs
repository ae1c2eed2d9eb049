//! Overlapping charts on the surface and side by side: from the layers of a scene to bytes.
//!
//! On the surface each place is drawn once for each chart that covers it: first black, with depth, then the share of each chart added
//! where the depth is the same. The vertices of a place are the same bits in each chart, and so is its depth.

use super::arrays::{self, SceneError, push_floats};
use super::occlusion::Occlusion;
use crate::session::scene::{LayerScene, Scene};
use glam::{Vec2, Vec3};

/// Bytes per vertex of [`vertices`]: position `f32 × 3`, normal and openness `i16 × 4`, two colours of the texture `u8 × 4`, place in the
/// texture and on the sheet `f32 × 2`, weights `f32 × 4`.
pub const LAYER_STRIDE: u64 = 60;

/// How overlapping charts are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerMode {
    /// Not at all: the pieces of the cut are.
    Pieces,
    /// Each with its weight.
    #[default]
    Blended,
    /// The one with the largest weight.
    Hard,
}

impl LayerMode {
    /// From what the page calls it.
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "pieces" => Self::Pieces,
            "blended" => Self::Blended,
            "hard" => Self::Hard,
            _ => return None,
        })
    }
}

/// Checks everything that the builders below rely on, so that they cannot panic.
pub fn check(layers: &LayerScene) -> Result<(), SceneError> {
    let vertices = layers.vertex_charts.len();
    for (array, found, expected) in [
        ("layers.positions", layers.positions.len(), 3 * vertices),
        ("layers.normals", layers.normals.len(), 3 * vertices),
        ("layers.uvs", layers.uvs.len(), 2 * vertices),
        ("layers.places", layers.places.len(), 2 * vertices),
        ("layers.weights", layers.weights.len(), 4 * vertices),
        ("layers.triangles", layers.triangles.len(), layers.triangles.len() / 3 * 3),
        ("layers.rims", layers.rims.len(), layers.rims.len() / 2 * 2),
    ] {
        if found != expected {
            return Err(SceneError::Length { array, found, expected });
        }
    }
    for (array, indices, count) in [
        ("layers.triangles", &layers.triangles, vertices),
        ("layers.rims", &layers.rims, vertices),
        ("layers.vertex_charts", &layers.vertex_charts, layers.charts.len()),
    ] {
        if let Some(&index) = indices.iter().find(|i| **i as usize >= count) {
            return Err(SceneError::Index { array, index, count });
        }
    }
    for (array, numbers) in [
        ("layers.positions", &layers.positions),
        ("layers.normals", &layers.normals),
        ("layers.uvs", &layers.uvs),
        ("layers.weights", &layers.weights),
    ] {
        if let Some(at) = numbers.iter().position(|x| !x.is_finite()) {
            return Err(SceneError::NotFinite { array, at });
        }
    }
    Ok(())
}

/// All that is known of the vertices of the layers.
pub fn vertices(scene: &Scene, occlusion: &mut Occlusion) -> Vec<u8> {
    let Some(layers) = &scene.layers else { return Vec::new() };
    let colours = arrays::piece_colours(&layers.charts);
    let mut bytes = Vec::with_capacity(layers.vertex_charts.len() * LAYER_STRIDE as usize);
    for (v, &chart) in layers.vertex_charts.iter().enumerate() {
        let position = Vec3::from_slice(&layers.positions[3 * v..]);
        let normal = Vec3::from_slice(&layers.normals[3 * v..]);
        arrays::push_place(&mut bytes, position, normal, occlusion.openness(position, normal));
        bytes.extend(colours[chart as usize].as_flattened());
        push_floats(&mut bytes, &layers.uvs[2 * v..2 * v + 2]);
        // Shaders must not meet NaN; triangles without a place are not drawn.
        let place = place(layers, v as u32);
        push_floats(&mut bytes, &if place.is_finite() { place } else { Vec2::ZERO }.to_array());
        push_floats(&mut bytes, &layers.weights[4 * v..4 * v + 4]);
    }
    bytes
}

fn place(layers: &LayerScene, vertex: u32) -> Vec2 {
    Vec2::from_slice(&layers.places[2 * vertex as usize..])
}

/// The triangles of all layers, as indices; those alone that have a place on the sheet if asked to.
pub fn triangles(scene: &Scene, on_sheet: bool) -> Vec<u8> {
    let Some(layers) = &scene.layers else { return Vec::new() };
    let triangles: &[[u32; 3]] = layers.triangles.as_chunks().0;
    let is_there = |t: &&[u32; 3]| t.iter().all(|&v| place(layers, v).is_finite());
    arrays::indices(triangles.iter().filter(|t| !on_sheet || is_there(t)))
}

/// The rims of all charts on the sheet.
pub fn rim_ribbons(scene: &Scene) -> Vec<u8> {
    let Some(layers) = &scene.layers else { return Vec::new() };
    let rims: &[[u32; 2]] = layers.rims.as_chunks().0;
    let lines = rims.iter().map(|rim| rim.map(|v| place(layers, v).extend(0.0)));
    arrays::lone_ribbons(lines.filter(|line| line.iter().all(|p| p.is_finite())))
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{overlapping_squares, two_squares};
    use super::*;

    #[test]
    fn every_array_has_its_stride() {
        let scene = overlapping_squares();
        let bytes = vertices(&scene, &mut Occlusion::new(&scene));
        assert_eq!(bytes.len(), 8 * LAYER_STRIDE as usize);
        assert_eq!(triangles(&scene, false).len(), 4 * 12);
        assert_eq!(rim_ribbons(&scene).len(), 8 * 60);
        let none = two_squares();
        assert!(vertices(&none, &mut Occlusion::new(&none)).is_empty());
        assert!(triangles(&none, true).is_empty() && rim_ribbons(&none).is_empty());
    }

    #[test]
    fn what_has_no_chart_is_on_the_surface_alone() {
        let mut scene = overlapping_squares();
        if let Some(layers) = &mut scene.layers {
            layers.places[..8].fill(f32::NAN);
        }
        assert_eq!((triangles(&scene, false).len(), triangles(&scene, true).len()), (48, 24));
        assert_eq!(rim_ribbons(&scene).len(), 4 * 60);
        let bytes = vertices(&scene, &mut Occlusion::new(&scene));
        let (numbers, _) = bytes.as_chunks();
        assert!(numbers.iter().skip(9).step_by(15).all(|&b| f32::from_le_bytes(b).is_finite()));
    }

    #[test]
    fn broken_layers_are_refused_with_their_array() {
        let scene = overlapping_squares();
        let layers = scene.layers.expect("layers");
        assert_eq!(check(&layers), Ok(()));
        let broken = LayerScene { triangles: vec![0, 1, 8], ..layers.clone() };
        let index = SceneError::Index { array: "layers.triangles", index: 8, count: 8 };
        assert_eq!(check(&broken), Err(index));
        let mut broken = layers.clone();
        broken.weights.pop();
        let length = SceneError::Length { array: "layers.weights", found: 31, expected: 32 };
        assert_eq!(check(&broken), Err(length));
        let mut broken = layers;
        broken.uvs[3] = f32::NAN;
        assert_eq!(check(&broken), Err(SceneError::NotFinite { array: "layers.uvs", at: 3 }));
    }
}
