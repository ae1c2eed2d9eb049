//! Cutflow: where to cut a curved surface so that it flattens with little distortion.

pub mod flatten;
pub mod geometry;
pub mod linalg;
pub mod mesh;
pub mod methods;
pub mod pattern;
pub mod session;
#[cfg(feature = "viewer")]
pub mod viewer;
#[cfg(any(feature = "engine", feature = "viewer"))]
pub mod web;
