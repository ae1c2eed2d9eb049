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
use cutflow::methods::cutflow::{CutFlow, CutFlowParams, Initial};
use cutflow::methods::cutgraph::{cut_through, cut_to_disks};
use cutflow::methods::flow::{Flow, Status};
use nalgebra::{Point2, Point3};

use crate::surfaces::Surface;

mod patches;
mod refused;
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

/// Claims about all charts, from coordinates alone: no face on its back, partners of one length.
fn check_charts(found: &Conformal, flipped: usize) {
    let Conformal { opened, flattening, .. } = found;
    let mesh = &opened.mesh;
    let place = |v: VertexId| flattening.uv[v.index()];
    let mut on_back = 0;
    let mut size: f64 = 0.0;
    for f in mesh.faces() {
        assert!(flattening.charts[opened.face_patches[f.index()] as usize].is_ok());
        let [a, b, c] = mesh.face_vertices(f).map(place);
        on_back += usize::from(!(orientation(a, b, c) > 0.0));
        size = size.max(a.coords.norm());
    }
    assert_eq!(on_back, flipped, "{:?}", found.report);
    assert_eq!(found.report.flipped_after, flipped);
    for h in mesh.faces().flat_map(|f| mesh.face_halfedges(f)) {
        let length = |h| (place(mesh.tip(h)) - place(mesh.tail(h))).norm();
        if let Some(partner) = opened.partner(h) {
            // Roundings of places, the length of a path of faces: 1e-15 each.
            assert!((length(h) - length(partner)).abs() < 1e-12 * size, "{:?}", found.report);
        }
    }
}

/// Sum of the angles of charts at every point, over all its copies.
fn angle_sums(found: &Conformal) -> Vec<f64> {
    let mut sums = vec![0.0; found.cut.points.len()];
    for f in found.opened.mesh.faces() {
        let corners = found.opened.mesh.face_vertices(f);
        let places = corners.map(|v| found.flattening.uv[v.index()]);
        for i in 0..3 {
            let [u, v] = [1, 2].map(|k| places[(i + k) % 3] - places[i]);
            let point = found.opened.vertex_points[corners[i].index()];
            sums[point as usize] += (u.x * v.y - u.y * v.x).atan2(u.dot(&v));
        }
    }
    sums
}

/// By how much an outline turns to the left at each corner.
fn turning(outline: &[Point2<f64>]) -> Vec<f64> {
    let n = outline.len();
    (0..n)
        .map(|i| {
            let u = outline[i] - outline[(i + n - 1) % n];
            let v = outline[(i + 1) % n] - outline[i];
            (u.x * v.y - u.y * v.x).atan2(u.dot(&v))
        })
        .collect()
}

fn shoelace(outline: &[Point2<f64>]) -> f64 {
    let n = outline.len();
    (0..n).map(|i| 0.5 * outline[i].coords.perp(&outline[(i + 1) % n].coords)).sum()
}

/// A report on the terminal.
fn print(title: &str, found: &Conformal) {
    let positions =
        found.opened.vertex_points.iter().map(|&p| found.positions[p as usize]).collect();
    let geometry = Geometry::measure(&found.opened.mesh, positions);
    let totals = measure(&found.opened, &geometry, &found.flattening).totals;
    println!("{title}: angle {:.4} {:?}", totals.angle_distortion, found.report);
}
