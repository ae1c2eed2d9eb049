//! Discrete conformal equivalence: charts with exactly the angles that are asked for.
//!
//! Two sets of edge lengths of a triangulation are *discretely conformally equivalent* if l̃_ij = e^{(v_i + v_j) / 2} l_ij for some log
//! scale factors v. Sought are those with the angle sums Θ* (2π − C at a cone, π − k on a boundary that turns by k): the minimum of a convex
//! energy (`solver`). Where triangle inequalities would fail, edges flip by Ptolemy's theorem (`triangulation`); with that there is a
//! solution for all Θ* > 0 that satisfy Gauss–Bonnet. Flips are then taken back one by one with straight chords for the edges that were
//! there (`develop`), faces laid side by side (`place`), and the few that lie on their backs divided by points on edges (`repair`), or, where that will not do,
//! a corner of theirs moved by their width (`settle`).
//!
//! Two uses: cones on the surface before it is cut, any genus ([`conformal_with_cones`]), and patches by themselves, with rims that keep
//! their lengths or turn as they are told ([`conformal`]).
//!
//! Guaranteed: angles to the tolerance, charts that close, partners of equal length (with cones, and with isometric rims unless the report
//! counts doubled parts), faces on their backs found exactly and counted. Not guaranteed: that the repair helps each of them
//! (it did wherever cones leave angles of half a radian); that charts do not overlap themselves.
//!
//! **From** Springborn, Schröder, Pinkall: *Conformal Equivalence of Triangle Meshes*, 2008; Gillespie, Springborn, Crane: *Discrete Conformal
//! Equivalence of Polyhedral Surfaces*, 2021. **Differs**: the line search looks at slopes, so that angles and not the energy decide when it
//! ends; flips are taken back instead of tracing edges through the flipped triangulation; seams run along the surface's own edges.

mod develop;
mod error;
mod flow;
mod lobachevsky;
mod part;
mod place;
mod repair;
mod round;
mod settle;
mod solver;
mod split;
mod targets;
#[cfg(test)]
mod tests;
mod triangle;
mod triangulation;

use nalgebra::Point3;

use crate::mesh::{CutMesh, Mesh};
use crate::methods::cones::Cone;
use crate::methods::flow::{Flow, Status};

pub use error::ConformalError;
pub use flow::{Conformal, ConformalFlow, ConformalParams, ConformalReport, ConformalState};
pub use targets::{RimCondition, SHARPEST_CONE, cap_cones};

/// Flattens a surface with cones, opened along a cut that passes through them: [`ConformalFlow::on_surface`], to its end.
pub fn conformal_with_cones(
    mesh: &Mesh,
    cut: &CutMesh,
    positions: &[Point3<f64>],
    cones: &[Cone],
    rim: &RimCondition,
    params: &ConformalParams,
) -> Result<Conformal, ConformalError> {
    run(ConformalFlow::on_surface(mesh, cut, positions, cones, rim, params)?)
}

/// Flattens every patch of a cut surface: [`ConformalFlow::on_patches`], to its end.
pub fn conformal(
    mesh: &Mesh,
    cut: &CutMesh,
    positions: &[Point3<f64>],
    rim: &RimCondition,
    params: &ConformalParams,
) -> Result<Conformal, ConformalError> {
    run(ConformalFlow::on_patches(mesh, cut, positions, rim, params)?)
}

fn run(mut flow: ConformalFlow) -> Result<Conformal, ConformalError> {
    loop {
        if flow.step()?.status != Status::Running
            && let Some(result) = flow.result()
        {
            return Ok(result);
        }
    }
}
