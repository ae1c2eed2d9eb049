//! Cones placed by hand, with Gauss–Bonnet kept.
//!
//! A component *balances* its cones if their angles must add up to 2πχ: closed components do, and those with cones on the boundary,
//! which then are its corners. On other components the boundary takes up what is left, and nothing but the edited cone changes.
//!
//! **The rule**: what an edit adds to the sum of a balanced component is taken from its cones that were not fixed by hand, and not by this edit, in
//! proportion to their |angle| (evenly if all are 0). A cone that was given an angle is fixed by hand from then on; one without
//! begins with 0 and takes no share, until [`super::debias`] finds its angle.

use std::f64::consts::{PI, TAU};

use super::Cone;
use crate::mesh::{Mesh, VertexId};

/// A cone, and whether its angle was fixed by hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedCone {
    /// Where and how strong.
    pub cone: Cone,
    /// Whether other edits leave its angle alone.
    pub is_fixed: bool,
}

/// What a hand does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConeEdit {
    /// A new cone, of this angle (fixed) or, without one, of angle 0 (free).
    Add {
        /// Where.
        vertex: VertexId,
        /// Radians.
        angle: Option<f64>,
    },
    /// A cone goes somewhere else with its angle, fixed or not as it was.
    Move {
        /// From where.
        from: VertexId,
        /// To where.
        to: VertexId,
    },
    /// An angle, fixed from now on.
    SetAngle {
        /// Of which cone.
        vertex: VertexId,
        /// Radians.
        angle: f64,
    },
    /// An angle that was fixed takes its share again.
    Release {
        /// Of which cone.
        vertex: VertexId,
    },
    /// No cone there any more.
    Remove {
        /// Which.
        vertex: VertexId,
    },
}

/// Why cones cannot be edited like that.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// A vertex that is not there, or that no face has.
    #[error("there is no vertex {} among {vertices}", .vertex.0)]
    NoSuchVertex {
        /// What was asked for.
        vertex: VertexId,
        /// Number of vertices of the surface.
        vertices: usize,
    },
    /// There is no cone to edit.
    #[error("there is no cone at vertex {}", .vertex.0)]
    NoCone {
        /// Where.
        vertex: VertexId,
    },
    /// There is a cone already.
    #[error("there is a cone at vertex {} already", .vertex.0)]
    Occupied {
        /// Where.
        vertex: VertexId,
    },
    /// An angle that a flat metric cannot have, asked for or as the share of a cone.
    #[error("the cone at vertex {} would have the angle {angle}; it must lie between {least} and {most}", .vertex.0)]
    OutOfRange {
        /// Which cone.
        vertex: VertexId,
        /// Radians.
        angle: f64,
        /// Lower bound, itself excluded.
        least: f64,
        /// Upper bound, itself excluded.
        most: f64,
    },
    /// Angles that must add up to something else, and none of them is free to change.
    #[error(
        "the cones on the part of vertex {} add up to {total} and must add up to {needed} (Gauss–Bonnet), and none is free to change",
        .vertex.0
    )]
    AllFixed {
        /// A vertex of the component.
        vertex: VertexId,
        /// Their sum, radians.
        total: f64,
        /// What it has to be, radians.
        needed: f64,
    },
}

/// The cones after an edit.
///
/// **Takes** cones at different vertices, whose angles need not balance yet. **Gives** cones by ascending vertex, balanced on the components
/// of the edit, where every angle that changed lies in (−2π, 2π), in (−2π, π) on the boundary. **Fails** with numbers where that cannot be; the cones are then as they were. **Costs** O(V).
pub fn edit_cones(
    mesh: &Mesh,
    cones: &[PlacedCone],
    edit: ConeEdit,
) -> Result<Vec<PlacedCone>, EditError> {
    let mut edited = cones.to_vec();
    let find = |vertex: VertexId| {
        cones.iter().position(|c| c.cone.vertex == vertex).ok_or(EditError::NoCone { vertex })
    };
    let check_free = |vertex: VertexId| {
        let vertices = mesh.vertex_count();
        if vertex.index() >= vertices || mesh.halfedge(vertex).is_none() {
            Err(EditError::NoSuchVertex { vertex, vertices })
        } else if find(vertex).is_ok() {
            Err(EditError::Occupied { vertex })
        } else {
            Ok(())
        }
    };
    // The vertex whose cone does not give way, and one on every component whose sum changes.
    let mut touched = None;
    let mut places = Vec::new();
    match edit {
        ConeEdit::Add { vertex, angle } => {
            check_free(vertex)?;
            touched = Some(vertex);
            places.push(vertex);
            let cone = Cone { vertex, angle: angle.unwrap_or(0.0) };
            edited.push(PlacedCone { cone, is_fixed: angle.is_some() });
        }
        ConeEdit::Move { from, to } => {
            let i = find(from)?;
            if from != to {
                check_free(to)?;
            }
            touched = Some(to);
            places.extend([from, to]);
            edited[i].cone.vertex = to;
        }
        ConeEdit::SetAngle { vertex, angle } => {
            let i = find(vertex)?;
            touched = Some(vertex);
            places.push(vertex);
            edited[i] = PlacedCone { cone: Cone { vertex, angle }, is_fixed: true };
        }
        ConeEdit::Release { vertex } => {
            edited[find(vertex)?].is_fixed = false;
            places.push(vertex);
        }
        ConeEdit::Remove { vertex } => {
            places.push(vertex);
            edited.remove(find(vertex)?);
        }
    }
    if let Some(touched) = touched {
        edited.iter().filter(|c| c.cone.vertex == touched).try_for_each(|c| check(mesh, c.cone))?;
    }
    balance(mesh, &mut edited, touched, &places)?;
    edited.sort_by_key(|c| c.cone.vertex);
    Ok(edited)
}

/// Whether a flat metric can have a cone of that angle there.
fn check(mesh: &Mesh, Cone { vertex, angle }: Cone) -> Result<(), EditError> {
    let [least, most] = [-TAU, if mesh.is_boundary_vertex(vertex) { PI } else { TAU }];
    if angle > least && angle < most {
        Ok(())
    } else {
        Err(EditError::OutOfRange { vertex, angle, least, most })
    }
}

/// Brings the sums on the components of `places` to 2πχ. **Takes** the vertex whose cone does not give way.
fn balance(
    mesh: &Mesh,
    cones: &mut [PlacedCone],
    touched: Option<VertexId>,
    places: &[VertexId],
) -> Result<(), EditError> {
    for part in parts(mesh) {
        let own = |v: VertexId| part.vertices.binary_search(&v).is_ok();
        if !places.iter().any(|&v| own(v)) {
            continue;
        }
        let members: Vec<usize> = (0..cones.len()).filter(|&i| own(cones[i].cone.vertex)).collect();
        let has_corners = members.iter().any(|&i| mesh.is_boundary_vertex(cones[i].cone.vertex));
        if !(part.is_closed || has_corners) {
            continue;
        }
        let needed = TAU * part.euler as f64;
        let total: f64 = members.iter().map(|&i| cones[i].cone.angle).sum();
        let missing = needed - total;
        // Sums of a thousand angles round to that.
        if missing.abs() < 1e-12 {
            continue;
        }
        let free: Vec<usize> = members
            .into_iter()
            .filter(|&i| !cones[i].is_fixed && Some(cones[i].cone.vertex) != touched)
            .collect();
        let weight: f64 = free.iter().map(|&i| cones[i].cone.angle.abs()).sum();
        if free.is_empty() {
            return Err(EditError::AllFixed { vertex: part.vertices[0], total, needed });
        }
        for &i in &free {
            let cone = &mut cones[i].cone;
            let share =
                if weight > 0.0 { cone.angle.abs() / weight } else { 1.0 / free.len() as f64 };
            cone.angle += missing * share;
        }
        free.iter().try_for_each(|&i| check(mesh, cones[i].cone))?;
    }
    Ok(())
}

struct Part {
    /// Ascending.
    vertices: Vec<VertexId>,
    euler: i64,
    is_closed: bool,
}

/// The components of a surface.
fn parts(mesh: &Mesh) -> Vec<Part> {
    let topology = mesh.topology();
    let mut component = vec![usize::MAX; mesh.vertex_count()];
    let mut parts: Vec<Part> = (0..topology.components)
        .map(|_| Part { vertices: Vec::new(), euler: 0, is_closed: true })
        .collect();
    for f in mesh.faces() {
        let c = topology.face_components[f.index()] as usize;
        parts[c].euler += 1;
        for v in mesh.face_vertices(f) {
            component[v.index()] = c;
        }
    }
    for e in mesh.edges() {
        let part = &mut parts[component[mesh.tail(e.halfedge()).index()]];
        part.euler -= 1;
        part.is_closed &= !mesh.is_boundary_edge(e);
    }
    for v in mesh.vertices().filter(|v| component[v.index()] != usize::MAX) {
        let part = &mut parts[component[v.index()]];
        part.euler += 1;
        part.vertices.push(v);
    }
    parts
}
