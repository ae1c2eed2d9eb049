//! Cuts that turn every patch of a cut surface into a disk.
//!
//! Let S be a patch: a connected surface with boundary ∂S. A graph G of interior edges *cuts S to a disk* when S opened along
//! G is one. Two trees give such a graph: T, of edges, reaches every interior vertex from ∂S; C joins all faces across edges
//! that are not in T. Opened along everything that C does not cross, S is faces glued along a tree: a disk. It remains one when
//! branches of T that end inside are sewn up again. What is left are 1 − χ(S) edges in neither tree and the paths
//! in T from their ends to ∂S. Looked for is a short G.
//!
//! * **Boundary**: the greedy system of arcs. T is the forest of shortest paths from ∂S, of length d. An edge uv off T closes the arc
//!   path(u) + uv + path(v) of length d(u) + |uv| + d(v). C is a maximum spanning tree by that length, so the arcs left are,
//!   taken one by one, the shortest that leave S connected.
//! * **No boundary, handles**: the same from one vertex instead of ∂S (greedy system of loops, 2g of them). The path from that
//!   vertex may end inside and is sewn up too. Several base vertices are tried.
//! * **Sphere**: a path between two far vertices.
//!
//! Arcs share edges and G is not the shortest graph (finding that is NP-hard). Where there are handles each stretch of G
//! between two junctions is then taken out, which leaves an annulus, and the annulus is cut along its shortest crossing. Where
//! there are only holes the arcs are a shortest spanning tree of the boundary loops, and nothing was ever gained.
//!
//! Seams that pass through given points ([`cut_through`]) are the same problem with those points as further holes, shrunk to nothing.
//!
//! Guaranteed: every patch is a disk afterwards; no edge of the mesh's boundary or of the cut that was there is touched; the
//! same input gives the same cut. Not guaranteed: a shortest cut; a cut shorter than one along edges of the triangulation.

mod exchange;
mod seams;
mod sectors;
mod surgeon;

use nalgebra::Point3;

use crate::mesh::{CutMesh, FaceId, MeshError, OpenedMesh, VertexId};

pub use seams::{Seams, cut_through};
pub use sectors::{Parted, WIDEST, part_sectors};
use surgeon::{Patch, Surgeon};

/// What [`cut_to_disks`] added.
#[derive(Clone, Debug)]
pub struct DiskCuts {
    /// The surface opened along old and new cuts: every patch a disk.
    pub opened: OpenedMesh,
    /// The edges added, as pairs of points: the last ones of [`CutMesh::cut_edges`].
    pub edges: Vec<[u32; 2]>,
    /// Their length, in the unit of the positions.
    pub length: f64,
    /// Number of patches that were no disks.
    pub patches: usize,
}

/// Adds cuts until every patch is a disk: Euler characteristic 1, one boundary loop.
///
/// **Takes** a refined mesh, cut or not, and where its points lie in space, in any unit. A dangling cut should have two edges
/// or more (one alone opens nothing).
/// **Gives** the cuts added, also appended to `cut.cut_edges`. They run along edges of the triangulation, begin and end on
/// the boundary of their patch or on each other, and never run along it.
/// **Fails** if the triangles form no manifold. **Costs** O(n log n) for a patch without handles, else O(n log n) for each of its
/// arcs; no more than opening where all patches are disks already.
/// **From** [EW05] (Erickson, Whittlesey: Greedy optimal homotopy and homology generators). **Differs**: arcs from the whole boundary
/// at once, and the replacing of stretches.
///
/// ```
/// use cutflow::mesh::{CutMesh, Mesh};
/// use cutflow::methods::cutgraph::cut_to_disks;
/// use nalgebra::Point3;
/// // The octahedron is a sphere: two edges cut it to a disk.
/// let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
/// let mut cut = CutMesh::uncut(&Mesh::new(6, &faces)?);
/// let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
/// let added = cut_to_disks(&mut cut, &[x, -x, y, -y, z, -z])?;
/// assert_eq!(added.edges.len(), 2);
/// assert_eq!(added.opened.patch_shapes(), [(1, 1)]);
/// # Ok::<(), cutflow::mesh::MeshError>(())
/// ```
pub fn cut_to_disks(cut: &mut CutMesh, positions: &[Point3<f64>]) -> Result<DiskCuts, MeshError> {
    assert_eq!(positions.len(), cut.points.len());
    let opened = cut.open()?;
    let shapes = opened.patch_shapes();
    let mut faces: Vec<Vec<FaceId>> = vec![Vec::new(); shapes.len()];
    for (f, &patch) in opened.face_patches.iter().enumerate() {
        if shapes[patch as usize] != (1, 1) {
            faces[patch as usize].push(FaceId::from(f));
        }
    }
    let patches = faces.iter().filter(|faces| !faces.is_empty()).count();
    if patches == 0 {
        return Ok(DiskCuts { opened, edges: Vec::new(), length: 0.0, patches });
    }
    let point = |v: VertexId| opened.vertex_points[v.index()];
    let lengths = opened.mesh.edges().map(|e| {
        let [a, b] = opened.mesh.edge_vertices(e).map(|v| positions[point(v) as usize]);
        (b - a).norm()
    });
    let mut surgeon = Surgeon::new(&opened.mesh, lengths.collect());
    let mut added = Vec::new();
    for (faces, shape) in faces.into_iter().zip(shapes).filter(|(faces, _)| !faces.is_empty()) {
        let patch = Patch::new(&opened.mesh, faces);
        added.extend(surgeon.cut(&patch, shape));
    }
    let length = surgeon.total_length(&added);
    let edges: Vec<[u32; 2]> =
        added.into_iter().map(|e| opened.mesh.edge_vertices(e).map(point)).collect();
    cut.cut_edges.extend_from_slice(&edges);
    let opened = cut.open()?;
    Ok(DiskCuts { opened, edges, length, patches })
}
