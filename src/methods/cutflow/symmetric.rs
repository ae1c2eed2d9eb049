//! Keeping a cut symmetric: the start is made symmetric, and so is every move.
//!
//! A symmetry maps every vertex to a place on the surface and labels to labels: with two regions it may swap them (the seam of a
//! tennis ball needs that), with more every label stays what it is. Moves are averaged, not level sets, so that interpolation
//! between vertices that have no exact partners does not blur the cut step by step.

use std::sync::Arc;

use super::band::LevelSets;
use super::init::Start;
use super::terms::Weights;
use crate::geometry::{Geometry, SymmetryMap};
use crate::mesh::{Mesh, VertexId};
use crate::methods::flow::SolveError;

/// Weights below this do not ask for their corner.
const NO_WEIGHT: f64 = 1e-9;

/// Correlation of a level set with its image below which the two have nothing to do with each other.
const UNRELATED: f64 = 0.2;

/// A group and what it does to labels.
#[derive(Clone, Debug, Default)]
pub(super) struct Symmetric {
    maps: Arc<Vec<SymmetryMap>>,
    /// For each map whether it swaps two regions.
    swaps: Vec<bool>,
}

impl Symmetric {
    /// Makes a start symmetric.
    pub fn new(
        mesh: &Mesh,
        geometry: &Geometry,
        maps: &Arc<Vec<SymmetryMap>>,
        start: Start,
        weights: &Weights,
    ) -> Result<(Self, Start), SolveError> {
        if maps.is_empty() {
            return Ok((Self::default(), start));
        }
        if start.labels.iter().any(|&label| label > 1) {
            let labels = fundamental_labels(mesh, geometry, maps, &start.labels);
            let swaps = vec![false; maps.len()];
            return Ok((Self { maps: maps.clone(), swaps }, Start::of_labels(labels)));
        }
        let mean_edge = geometry.mean_edge_length();
        let levels: Vec<f64> = mesh.vertices().map(|v| start.level(v, 0, mean_edge)).collect();
        let areas = geometry.vertex_dual_areas(mesh);
        let square: f64 = levels.iter().zip(&areas).map(|(x, a)| x * x * a).sum();
        let correlations: Vec<f64> = maps
            .iter()
            .map(|map| {
                let with = |v: VertexId| levels[v.index()] * map.pull(&levels, v);
                let sum: f64 = mesh.vertices().map(|v| with(v) * areas[v.index()]).sum();
                sum / square.max(1e-300)
            })
            .collect();
        // Signs must go together with products of maps. Where one cannot be told, none is taken.
        // Nor where the two regions are not alike.
        let is_clear = correlations.iter().all(|c| c.abs() > UNRELATED)
            && !(weights.one_sided || weights.area > 0.0);
        let swaps: Vec<bool> = correlations.iter().map(|c| is_clear && *c < 0.0).collect();
        let mean = |v: VertexId| {
            let mut sum = levels[v.index()];
            for (map, &swap) in maps.iter().zip(&swaps) {
                let image = map.pull(&levels, v);
                sum += if swap { -image } else { image };
            }
            sum / (maps.len() + 1) as f64
        };
        let symmetric: Vec<f64> = mesh.vertices().map(mean).collect();
        let largest = |values: &[f64]| values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        // What is left of opposites is rounding.
        if largest(&symmetric) < 1e-6 * largest(&levels) {
            return Err(SolveError::NotSymmetric);
        }
        Ok((Self { maps: maps.clone(), swaps }, Start::of_levels(symmetric)))
    }

    pub fn is_empty(&self) -> bool {
        self.maps.is_empty()
    }

    /// The mean of a move of level-set entries over the group. Images outside the band say nothing.
    pub fn average(&self, levels: &LevelSets, moves: &[f64]) -> Vec<f64> {
        let mut result = moves.to_vec();
        for v in levels.band() {
            for (entry, label) in levels.entries(v) {
                let (mut sum, mut count) = (moves[entry], 1.0);
                for (map, &swap) in self.maps.iter().zip(&self.swaps) {
                    let label = if swap { 1 - label } else { label };
                    let (corners, weights) = map.image(v);
                    let mut image = Some(0.0);
                    for (corner, weight) in corners.into_iter().zip(weights) {
                        if weight > NO_WEIGHT {
                            let at = levels.entry(corner, label).map(|e| weight * moves[e]);
                            image = image.zip(at).map(|(sum, x)| sum + x);
                        }
                    }
                    if let Some(x) = image {
                        sum += x;
                        count += 1.0;
                    }
                }
                result[entry] = sum / count;
            }
        }
        result
    }
}

/// Labels that are the same at all images of a place: those of the image that lies farthest in one direction, so that one part of
/// the surface tells the others.
fn fundamental_labels(
    mesh: &Mesh,
    geometry: &Geometry,
    maps: &[SymmetryMap],
    labels: &[u32],
) -> Vec<u32> {
    // No plane or axis of a model is likely to stand in this direction.
    let towards = nalgebra::Vector3::new(0.614, 0.527, 0.587);
    mesh.vertices()
        .map(|v| {
            let mut best = (geometry.positions[v.index()].coords.dot(&towards), v);
            for map in maps {
                let (corners, weights) = map.image(v);
                let place: f64 = (0..3)
                    .map(|i| {
                        geometry.positions[corners[i].index()].coords.dot(&towards) * weights[i]
                    })
                    .sum();
                let heaviest = (0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b]));
                if place > best.0 + 1e-9 {
                    best = (place, corners[heaviest.unwrap_or(0)]);
                }
            }
            labels[best.1.index()]
        })
        .collect()
}
