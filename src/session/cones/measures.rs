//! The cones that are used, and what they are worth.

use super::super::params::Settings;
use super::super::surface::Surface;
use super::edits::Edits;
use super::table::ConeComparisonRow;
use super::{ConeKind, ConeSet, UsedCone};
use crate::mesh::VertexId;
use crate::methods::cones::{
    Cone, ConeFlow, Places, RoundParams, debias, greedy_cones, round_clusters,
};
use crate::methods::flow::{Flow, SolveError, Status};

/// More cones than that are merged and refitted only once the solution has been reached.
const QUICK: usize = 150;

/// Cones of the optimum, merged and refitted as the parameters say.
pub fn of_optimum(
    flow: &mut ConeFlow,
    settings: &Settings,
    edits: &Edits,
    surface: &Surface,
) -> Result<ConeSet, SolveError> {
    let state = flow.state();
    let is_over = flow.status() != Status::Running;
    if state.is_convex {
        // A cone at every vertex says nothing: cones are left to those who want some.
        return Ok(none(flow));
    }
    let (optimum, corners, best_u) = (state.cones.clone(), state.corners.clone(), state.u.clone());
    let (best_int_u2, best_angle) = (state.int_u2, state.total_angle);
    let alone =
        |cone: &Cone| UsedCone { cone: *cone, kind: edits.kind(cone.vertex, 1), members: 1 };
    let mut used: Vec<UsedCone> = optimum.iter().map(alone).collect();
    if settings.is_on("round") && (is_over || used.len() <= QUICK) {
        // Cones that were placed by hand stay where they are.
        let (by_hand, others): (Vec<UsedCone>, Vec<UsedCone>) =
            used.into_iter().partition(|used| edits.placed_at(used.cone.vertex).is_some());
        let others: Vec<Cone> = others.into_iter().map(|used| used.cone).collect();
        let params = RoundParams { bounds: flow.params().bounds, ..RoundParams::default() };
        let rounded = round_clusters(&surface.mesh, &surface.geometry, &others, &params);
        used = by_hand;
        for (cone, cluster) in rounded.cones.iter().zip(&rounded.clusters) {
            let members = cluster.len();
            used.push(UsedCone { cone: *cone, kind: edits.kind(cone.vertex, members), members });
        }
    }
    used.sort_by_key(|used| used.cone.vertex);
    if settings.is_on("debias") && is_over {
        let cones: Vec<Cone> = used.iter().map(|used| used.cone).collect();
        let is_held = |used: &&UsedCone| used.kind == ConeKind::Fixed;
        let held: Vec<VertexId> =
            used.iter().filter(is_held).map(|used| used.cone.vertex).collect();
        let fitted = debias(flow, &cones, &held)?;
        used.iter_mut().zip(fitted).for_each(|(used, cone)| used.cone = cone);
    }
    let is_optimum = used.iter().map(|used| used.cone).eq(optimum);
    let corner = |&cone: &Cone| UsedCone { cone, kind: ConeKind::Corner, members: 1 };
    used.extend(corners.iter().map(corner));
    used.sort_by_key(|used| used.cone.vertex);
    if is_optimum {
        return Ok(ConeSet {
            cones: used,
            u: best_u,
            int_u2: best_int_u2,
            total_angle: best_angle,
            change: None,
        });
    }
    let mut set = evaluated(flow, used)?;
    let areas = surface.geometry.vertex_dual_areas(&surface.mesh);
    let norm = |u: &dyn Fn(usize) -> f64| {
        let squares = |(v, area): (usize, &f64)| area * u(v) * u(v);
        areas.iter().enumerate().map(squares).sum::<f64>().sqrt()
    };
    let difference = norm(&|v| set.u[v] - best_u[v]);
    set.change = Some(difference / norm(&|v| best_u[v]).max(f64::MIN_POSITIVE));
    Ok(set)
}

/// The search for the places of so many cones, begun with the merged cones of the optimum; where that is the curvature of every vertex with some
/// far from one another.
pub fn places(
    flow: &mut ConeFlow,
    count: usize,
    edits: &Edits,
    surface: &Surface,
) -> Result<Places, SolveError> {
    let by_hand = |is_fixed: bool| -> Vec<VertexId> {
        let placed = edits.placed.iter().filter(|placed| placed.angle.is_some() == is_fixed);
        placed.map(|placed| placed.vertex).collect()
    };
    let (free, fixed) = (by_hand(false), by_hand(true));
    if flow.state().is_convex {
        return Places::new(flow, &[], &free, &fixed, count);
    }
    let (mine, others): (Vec<Cone>, Vec<Cone>) =
        flow.state().cones.iter().partition(|cone| edits.placed_at(cone.vertex).is_some());
    let params = RoundParams { bounds: flow.params().bounds, ..RoundParams::default() };
    let merged = round_clusters(&surface.mesh, &surface.geometry, &others, &params).cones;
    Places::new(flow, &[mine, merged].concat(), &free, &fixed, count)
}

/// An exact number of cones, where they do most.
pub fn of_places(
    flow: &mut ConeFlow,
    places: &Places,
    edits: &Edits,
) -> Result<ConeSet, SolveError> {
    let kind = |vertex| match edits.kind(vertex, 1) {
        ConeKind::Optimal => ConeKind::Placed,
        by_hand => by_hand,
    };
    let corners = flow.state().corners.clone();
    let cones = places.cones(flow).into_iter();
    let mut used: Vec<UsedCone> =
        cones.map(|cone| UsedCone { cone, kind: kind(cone.vertex), members: 1 }).collect();
    used.extend(corners.iter().map(|&cone| UsedCone { cone, kind: ConeKind::Corner, members: 1 }));
    used.sort_by_key(|used| used.cone.vertex);
    evaluated(flow, used)
}

/// No cones: all curvature stays where it is.
fn none(flow: &ConeFlow) -> ConeSet {
    let u = vec![0.0; flow.state().u.len()];
    ConeSet { cones: Vec::new(), u, int_u2: 0.0, total_angle: 0.0, change: None }
}

/// Any cones with the scale factors that belong to them. None on a convex surface are those of its optimum.
pub fn evaluated(flow: &mut ConeFlow, used: Vec<UsedCone>) -> Result<ConeSet, SolveError> {
    if used.is_empty() && flow.state().is_convex {
        return Ok(none(flow));
    }
    let cones: Vec<Cone> = used.iter().map(|used| used.cone).collect();
    let found = flow.evaluate(&cones)?;
    Ok(ConeSet {
        cones: used,
        u: found.u,
        int_u2: found.int_u2,
        total_angle: found.total_angle,
        change: None,
    })
}

/// The same places with the angles that distort least, whatever they add up to.
pub fn refitted(flow: &mut ConeFlow, mut used: Vec<UsedCone>) -> Result<ConeSet, SolveError> {
    let cones: Vec<Cone> = used.iter().map(|used| used.cone).collect();
    let fitted = debias(flow, &cones, &[])?;
    used.sort_by_key(|used| used.cone.vertex);
    used.iter_mut().zip(fitted).for_each(|(used, cone)| used.cone = cone);
    evaluated(flow, used)
}

/// As many cones by the greedy strategy of older work.
pub fn greedy(surface: &Surface, count: usize) -> Result<ConeSet, SolveError> {
    let (mesh, geometry) = surface.given_or_mended();
    let found = greedy_cones(mesh, geometry, count)?;
    let used = |&cone: &Cone| UsedCone { cone, kind: ConeKind::Optimal, members: 1 };
    let last = found.history.last();
    Ok(ConeSet {
        cones: found.cones.iter().map(used).collect(),
        int_u2: last.map_or(0.0, |step| step.int_u2),
        total_angle: last.map_or(0.0, |step| step.total_angle),
        u: found.u,
        change: None,
    })
}

/// A row of the comparison; charts are measured elsewhere.
pub fn row(label: String, set: &ConeSet) -> ConeComparisonRow {
    ConeComparisonRow {
        label,
        count: set.count(),
        total_angle: set.total_angle,
        int_u2: set.int_u2,
        // The surface has unit area.
        rms_u: set.int_u2.sqrt(),
        max_abs_u: set.u.iter().filter(|u| u.is_finite()).fold(0.0, |m: f64, u| m.max(u.abs())),
        chart_angle: None,
        chart_area: None,
    }
}
