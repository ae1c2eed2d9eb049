//! Commands in, events out.

pub mod samples;
pub mod scene;
