//! What is asked for, and whether any flat surface has it.

use std::f64::consts::{PI, TAU};

use super::error::ConformalError;
use crate::geometry::Geometry;
use crate::mesh::{Mesh, VertexId};
use crate::methods::cones::Cone;

/// Largest cone that is of use, radians. Up to 2π there is a solution, but scale factors grow like (1 − C / 2π)⁻¹: with an angle of .1 π
/// left they reach e²⁰ to e⁵⁵, more than coordinates have digits for.
pub const SHARPEST_CONE: f64 = 1.75 * PI;

/// A sum of angles that is off by no more is spread over the cones; by more, it was meant otherwise.
const ROUNDING: f64 = 1e-6;

/// What happens at boundaries: of the surface, or of each patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RimCondition {
    /// Sides keep their lengths: v = 0. The outline turns as it must.
    #[default]
    Isometric,
    /// Log scale factors v at every vertex; those on boundaries count.
    LogScales(Vec<f64>),
    /// By how much the outline turns to the left at every vertex, radians; those on boundaries count. The sum of a disk is 2π.
    ExteriorAngles(Vec<f64>),
}

/// What is asked for at a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Condition {
    /// This angle sum.
    Angle(f64),
    /// This log scale factor.
    Scale(f64),
}

/// Conditions at all vertices of the surface that is solved on.
///
/// **Takes** cone angles at every vertex.
pub(super) fn conditions(
    mesh: &Mesh,
    cones: &[f64],
    rim: &RimCondition,
) -> Result<Vec<Condition>, ConformalError> {
    let vertices = mesh.vertex_count();
    let given = match rim {
        RimCondition::Isometric => None,
        RimCondition::LogScales(v) => Some(("log scale factors", v)),
        RimCondition::ExteriorAngles(k) => Some(("exterior angles", k)),
    };
    if let Some((name, list)) = given
        && list.len() != vertices
    {
        return Err(ConformalError::WrongLength { name, given: list.len(), vertices });
    }
    let finite = |name, vertex, value: f64| match value.abs() < 1e6 {
        true => Ok(value),
        false => Err(ConformalError::NotFinite { name, vertex, value }),
    };
    let mut conditions = Vec::with_capacity(vertices);
    for vertex in mesh.vertices() {
        let angle = finite("the cone angle", vertex, cones[vertex.index()])?;
        if !mesh.is_boundary_vertex(vertex) {
            if angle >= TAU {
                return Err(ConformalError::ConeTooSharp { vertex, angle, largest: SHARPEST_CONE });
            }
            conditions.push(Condition::Angle(TAU - angle));
            continue;
        }
        if angle != 0.0 {
            return Err(ConformalError::ConeOnBoundary { vertex });
        }
        conditions.push(match rim {
            RimCondition::Isometric => Condition::Scale(0.0),
            RimCondition::LogScales(v) => {
                Condition::Scale(finite("the log scale factor", vertex, v[vertex.index()])?)
            }
            RimCondition::ExteriorAngles(k) => {
                let angle = finite("the exterior angle", vertex, k[vertex.index()])?;
                if angle >= PI {
                    let largest = 0.95 * PI;
                    return Err(ConformalError::CornerTooSharp { vertex, angle, largest });
                }
                Condition::Angle(PI - angle)
            }
        });
    }
    Ok(conditions)
}

/// Checks Gauss–Bonnet on a connected part where no scale factor is given, and spreads what is rounding.
///
/// **Takes** the part's vertices, whether each is on the boundary, and 2πχ.
pub(super) fn balance(
    conditions: &mut [Condition],
    part: &[(VertexId, bool)],
    needed: f64,
) -> Result<(), ConformalError> {
    let flat = |is_rim: bool| if is_rim { PI } else { TAU };
    let mut total = 0.0;
    let mut bent = Vec::new();
    for &(v, is_rim) in part {
        let Condition::Angle(angle) = conditions[v.index()] else { return Ok(()) };
        total += flat(is_rim) - angle;
        if (angle - flat(is_rim)).abs() > 0.0 {
            bent.push(v);
        }
    }
    let Some(&(vertex, _)) = part.first() else { return Ok(()) };
    if !((total - needed).abs() <= ROUNDING) {
        return Err(ConformalError::GaussBonnet { vertex, total, needed });
    }
    if bent.is_empty() {
        bent.extend(part.iter().map(|p| p.0));
    }
    let share = (total - needed) / bent.len() as f64;
    for v in bent {
        if let Condition::Angle(angle) = &mut conditions[v.index()] {
            *angle += share;
        }
    }
    Ok(())
}

/// Cones of at most so large an angle, and the same sum: what a cone has too much it shares with its neighbours in equal parts.
///
/// Clusters merged to one cone can exceed 2π, which no flat metric has; halves of them at two neighbours do nearly as well.
///
/// **Takes** cones inside, and the largest angle ([`SHARPEST_CONE`] where nothing speaks against it), above 0. **Gives** cones by ascending
/// vertex. Each sharp one keeps the vertex and is joined by as few of the nearest vertices that are no cones as bring all of them to
/// half of 2π or less; where there are none to be had it stays as it is.
pub fn cap_cones(mesh: &Mesh, geometry: &Geometry, cones: &[Cone], largest: f64) -> Vec<Cone> {
    let mut is_taken = vec![false; mesh.vertex_count()];
    for cone in cones.iter().filter(|c| c.vertex.index() < mesh.vertex_count()) {
        is_taken[cone.vertex.index()] = true;
    }
    let mut capped = Vec::with_capacity(cones.len());
    for cone in cones {
        let is_there = cone.vertex.index() < mesh.vertex_count();
        if !is_there || !(cone.angle > largest) || !cone.angle.is_finite() || !(largest > 0.0) {
            capped.push(*cone);
            continue;
        }
        let share_of = largest.min(PI);
        let mut members = vec![(cone.vertex, 0.0)];
        let mut next = 0;
        while next < members.len() && cone.angle > share_of * members.len() as f64 {
            let (v, distance) = members[next];
            next += 1;
            let mut ring: Vec<(f64, VertexId)> = mesh
                .outgoing(v)
                .map(|h| (distance + geometry.edge_length(h.edge()), mesh.tip(h)))
                .filter(|(_, tip)| !is_taken[tip.index()] && !mesh.is_boundary_vertex(*tip))
                .collect();
            ring.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for (distance, tip) in ring {
                if cone.angle > share_of * members.len() as f64 {
                    is_taken[tip.index()] = true;
                    members.push((tip, distance));
                }
            }
        }
        let angle = cone.angle / members.len() as f64;
        capped.extend(members.iter().map(|&(vertex, _)| Cone { vertex, angle }));
    }
    capped.sort_by_key(|c| c.vertex);
    capped
}
