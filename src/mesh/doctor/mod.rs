//! What can be wrong with polygon soup, and what can be done about it: the words, and all that needs connectivity only.
//!
//! The surface that a soup describes is a set of polygons glued along sides that name the same two vertices. The methods
//! need a manifold: at most two sides at an edge, one fan of polygons at a vertex, sides that run in opposite directions.
//! [`Sides`] and [`Shape`] find out where a soup is none; the repairs here and in [`crate::geometry::doctor`] make it one.
//!
//! Guaranteed: coordinates are handed on bit for bit and read for nothing but equality; vertices keep their numbers (new
//! ones are appended, ones that nothing uses any more stay; [`drop_isolated`] alone renumbers); texture coordinates,
//! normals, groups, materials and lines stay with their polygons and corners; lists are in increasing order; time
//! O(n log n). All take soups with indices in range, as the readers give them.
//!
//! Not guaranteed: that a repair does what the maker of the mesh had in mind.

mod finding;
mod rebuild;
mod repairs;
mod shape;
mod sides;

pub use finding::{Finding, FindingKind, Repair, Severity};
pub use rebuild::{Corner, Rebuild};
pub use repairs::{
    drop_duplicates, drop_isolated, drop_repeated, duplicates, keep_polygons, open_one_sided,
    repeated, separate, split_vertices, turn, without_repetitions,
};
pub use shape::{Loop, Shape};
pub use sides::{Groups, Sides};
