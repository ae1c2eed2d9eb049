//! Smooth curves.
mod corners;

pub(crate) use corners::reach;
pub use corners::{CORNER, corners, turns};
