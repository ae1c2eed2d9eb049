//! The integration tests, one binary.

mod cutgraphs;
mod patterns;
mod reading;
