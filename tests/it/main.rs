//! The integration tests, one binary.

mod cutgraphs;
mod flattening;
mod patterns;
mod reading;
