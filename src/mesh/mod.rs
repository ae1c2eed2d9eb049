//! Connectivity of triangulated surfaces, and reading and writing of mesh bytes. Knows no metric: what lies in a file as
//! coordinates passes through unread.
//!
//! A [`Mesh`] is an oriented manifold, with or without boundary, of any genus and any number of components. Everything
//! above relies on that and none of it checks again; [`Mesh::new`] refuses anything else and names the defects by id.
//!
//! Not guaranteed: that a component is connected to another, that it has interior vertices, or any minimal size.

mod chains;
mod cut_mesh;
pub mod doctor;
mod halfedge;
mod islands;
pub mod read;
mod soup;
mod weld;

pub use chains::chains;
pub use cut_mesh::{CutMesh, OpenedMesh, SurfacePoint};
pub use halfedge::{EdgeId, FaceId, HalfedgeId, Mesh, MeshError, Topology, VertexId};
pub use islands::{uv_islands, uv_seams};
pub use soup::Soup;
pub use weld::Welder;
