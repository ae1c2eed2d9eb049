//! Discrete conformal equivalence: exact angles, closed charts, no face on its back, and what flat surfaces do not have.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use cutflow::flatten::conformal::{
    Conformal, ConformalError, ConformalFlow, ConformalParams, RimCondition, SHARPEST_CONE,
    cap_cones, conformal, conformal_with_cones,
};
use cutflow::flatten::overlap::orientation;
use cutflow::flatten::{NoChart, measure};
use cutflow::geometry::Geometry;
use cutflow::mesh::{CutMesh, Mesh, VertexId};
use cutflow::methods::cones::{
    Cone, ConeFields, ConeFlow, ConeParams, RoundParams, round_clusters,
};
use cutflow::methods::cutgraph::{cut_through, cut_to_disks};
use cutflow::methods::flow::{Flow, Status};
use nalgebra::{Complex, Point2, Point3};

use crate::surfaces::Surface;

mod table;

/// Optimal cones at a price; clusters merged and capped if asked for.
fn cones_of(surface: &Surface, lambda: f64, merged: bool) -> Vec<Cone> {
    let params = ConeParams { lambda, ..ConeParams::default() };
    let mut flow =
        ConeFlow::new(&surface.mesh, &surface.geometry, &params, &ConeFields::default()).unwrap();
    while flow.step().unwrap().status == Status::Running {}
    assert_eq!(flow.status(), Status::Converged);
    let cones = flow.state().cones.clone();
    if !merged {
        return cones;
    }
    let merging = RoundParams { small: 10.0, small_angle: 100.0, ..RoundParams::default() };
    let rounded = round_clusters(&surface.mesh, &surface.geometry, &cones, &merging);
    cap_cones(&surface.mesh, &surface.geometry, &rounded.cones, SHARPEST_CONE)
}

/// Cones on a whole surface, seams through them, charts.
fn with_cones(surface: &Surface, cones: &[Cone], rim: &RimCondition) -> Conformal {
    let vertices: Vec<VertexId> = cones.iter().map(|c| c.vertex).collect();
    let seams = cut_through(&surface.mesh, &surface.geometry, &vertices, &[]).unwrap();
    conformal_with_cones(
        &surface.mesh,
        &seams.cut,
        &surface.geometry.positions,
        cones,
        rim,
        &ConformalParams::default(),
    )
    .unwrap()
}
