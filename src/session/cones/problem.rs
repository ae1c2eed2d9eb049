//! The optimisation problem that parameters, layers and edits ask for.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the number of cones is whole and small by its range"
)]

use std::f64::consts::{FRAC_PI_2, PI};

use super::super::inputs::Layers;
use super::super::params::Settings;
use super::super::surface::Surface;
use super::edits::Edits;
use crate::methods::cones::{
    ConeBoundary, ConeFields, ConeMethod, ConeParams, ConeTarget, feature_size_weights,
};

/// Price of the optimum whose merged cones the search for an exact number begins with.
const START: f64 = 0.005;

/// The options of the solver.
pub fn params(settings: &Settings) -> ConeParams {
    let bounds = match settings.text("bounds") {
        "positive" => [0.0, f64::INFINITY],
        "quarter" => [-FRAC_PI_2, FRAC_PI_2],
        "custom" => {
            let bound = |x: f64| if x.abs() < 2.0 { x * PI } else { x * f64::INFINITY };
            ["angle_min", "angle_max"].map(|id| bound(settings.number(id)))
        }
        _ => [f64::NEG_INFINITY, f64::INFINITY],
    };
    ConeParams {
        lambda: settings.number("lambda"),
        boundary: match settings.text("boundary") {
            "optimal" => ConeBoundary::Optimal,
            "polygonal" => ConeBoundary::Polygonal,
            "convex" => ConeBoundary::Convex,
            "polygonal_convex" => ConeBoundary::PolygonalConvex,
            _ => ConeBoundary::Isometric,
        },
        boundary_cost: settings.number("corner_cost"),
        bounds,
        method: match settings.text("cone_method") {
            "greens" => ConeMethod::Greens,
            "newton" => ConeMethod::Newton,
            _ => ConeMethod::Auto,
        },
        multiresolution: settings.is_on("multiresolution"),
    }
}

/// What the solver has to reach.
pub fn target(settings: &Settings) -> ConeTarget {
    match settings.text("choose_by") {
        "count" => {
            let most = settings.number("cone_count") as usize;
            match settings.is_on("round") {
                true => ConeTarget::Merged(most),
                false => ConeTarget::Count(most),
            }
        }
        "exactly" => ConeTarget::Lambda(START),
        "angle" => ConeTarget::TotalAngle(settings.number("angle_target") * PI),
        "distortion" => ConeTarget::Distortion(settings.number("distortion_target")),
        _ => ConeTarget::Lambda(settings.number("lambda")),
    }
}

/// How many cones there are to be, where that is given exactly.
pub fn exact_count(settings: &Settings) -> Option<usize> {
    (settings.text("choose_by") == "exactly").then(|| settings.number("exact_count") as usize)
}

/// Weights, exclusions and cones by hand.
pub fn fields(
    settings: &Settings,
    layers: &Layers,
    edits: &Edits,
    surface: &Surface,
) -> ConeFields {
    let count = surface.mesh.vertex_count();
    let paint = |layer: &[f64], v: usize| layer.get(v).copied().unwrap_or(0.0);
    let (mut distortion_weight, mut cone_cost) = (Vec::new(), Vec::new());
    let strength = settings.number("feature_weight");
    if strength > 0.0 {
        let (mesh, geometry) = surface.given_or_mended();
        (distortion_weight, cone_cost) = feature_size_weights(mesh, geometry, strength);
    }
    if !(layers.importance.is_empty() && layers.unimportant.is_empty()) {
        let most = settings.number("importance");
        distortion_weight.resize(count, 1.0);
        for (v, weight) in distortion_weight.iter_mut().enumerate() {
            *weight *= 1.0 + (most - 1.0) * paint(&layers.importance, v);
            *weight *= 1.0 - paint(&layers.unimportant, v);
        }
    }
    if !layers.cone_cost.is_empty() {
        let most = settings.number("dear_cones");
        cone_cost.resize(count, 1.0);
        for (v, cost) in cone_cost.iter_mut().enumerate() {
            *cost *= 1.0 + (most - 1.0) * paint(&layers.cone_cost, v);
        }
    }
    let excluded = match layers.excluded.is_empty() {
        true => Vec::new(),
        false => (0..count).map(|v| paint(&layers.excluded, v) >= 0.5).collect(),
    };
    let (mut free, mut fixed) = (Vec::new(), Vec::new());
    for placed in &edits.placed {
        match placed.angle {
            Some(angle) => fixed.push((placed.vertex, angle)),
            None => free.push(placed.vertex),
        }
    }
    ConeFields { distortion_weight, cone_cost, excluded, free, fixed }
}
