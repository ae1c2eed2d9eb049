//! Seams through given points.

use super::surgeon::{Patch, Surgeon};
use crate::geometry::Geometry;
use crate::mesh::{CutMesh, FaceId, Mesh, OpenedMesh, VertexId};
use crate::methods::flow::SolveError;

/// What [`cut_through`] gives.
#[derive(Clone, Debug)]
pub struct Seams {
    /// The mesh as it was, with its seams.
    pub cut: CutMesh,
    /// Opened along them: every component one disk.
    pub opened: OpenedMesh,
    /// Their length, in the unit of the measures.
    pub length: f64,
}

/// Seams along mesh edges that open every component of a surface to one disk with given vertices on its rim.
///
/// On each component the seams are a Steiner tree of the given vertices and the boundary loops, or, with handles, a network that
/// cuts those too: greedy arcs (see the [module](super)), then local exchanges. A given vertex on the boundary needs no seam. A
/// sphere with fewer than two given vertices is slit, from the given one to one far away.
///
/// **Takes** the vertices, in any order; for each vertex how much a seam through it costs beside its length: a path costs
/// ∫ (1 + cost) along it. Empty for nothing; a visibility, several times over, hides seams from where it was taken.
/// **Gives** a refinement without new points: seams run along edges, and cones stay vertices.
/// **Fails** for a vertex that is not there, and costs below 0 or not finite.
/// **Costs** O(n log n) for n vertices and again for a few tens of exchanges around handles; others look at their surroundings only.
/// **Differs** from the paper, which leaves seams open.
///
/// ```
/// use cutflow::geometry::Geometry;
/// use cutflow::mesh::{Mesh, VertexId};
/// use cutflow::methods::cutgraph::cut_through;
/// use nalgebra::Point3;
/// // The corners of a tetrahedron: a star of three edges.
/// let mesh = Mesh::new(4, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])?;
/// let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
/// let geometry = Geometry::new(&mesh, corners.map(Point3::from).to_vec())?;
/// let seams = cut_through(&mesh, &geometry, &[0, 1, 2, 3].map(VertexId), &[])?;
/// assert_eq!(seams.cut.cut_edges.len(), 3);
/// assert_eq!(seams.opened.patch_shapes(), [(1, 1)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn cut_through(
    mesh: &Mesh,
    geometry: &Geometry,
    cones: &[VertexId],
    cost: &[f64],
) -> Result<Seams, SolveError> {
    let vertices = mesh.vertex_count();
    assert!(cost.is_empty() || cost.len() == vertices);
    let is_there = |v: VertexId| v.index() < vertices && mesh.halfedge(v).is_some();
    if let Some(&vertex) = cones.iter().find(|&&v| !is_there(v)) {
        return Err(SolveError::NoSuchVertex { vertex, vertices });
    }
    if let Some(&value) = cost.iter().find(|c| !(**c >= 0.0 && c.is_finite())) {
        return Err(SolveError::Parameter { name: "seam cost", value, min: 0.0, max: f64::MAX });
    }
    let price = |v: VertexId| cost.get(v.index()).copied().unwrap_or(0.0);
    let lengths = mesh.edges().map(|e| {
        let [a, b] = mesh.edge_vertices(e).map(price);
        geometry.edge_length(e) * (1.0 + 0.5 * (a + b))
    });
    let mut surgeon = Surgeon::new(mesh, lengths.collect());
    for v in cones {
        surgeon.is_terminal[v.index()] = !mesh.is_boundary_vertex(*v);
    }

    let mut cut = CutMesh::uncut(mesh);
    let whole = cut.open()?;
    let mut faces: Vec<Vec<FaceId>> = vec![Vec::new(); whole.patch_count];
    for (f, &component) in whole.face_patches.iter().enumerate() {
        faces[component as usize].push(FaceId::from(f));
    }
    let mut seams = Vec::new();
    for (faces, shape) in faces.into_iter().zip(whole.patch_shapes()) {
        seams.extend(surgeon.cut(&Patch::new(mesh, faces), shape));
    }
    // The sum of nothing is −0.
    let length = seams.iter().fold(0.0, |sum, &e| sum + geometry.edge_length(e));
    cut.cut_edges = seams.iter().map(|&e| mesh.edge_vertices(e).map(|v| v.0)).collect();
    let opened = cut.open()?;
    Ok(Seams { cut, opened, length })
}
