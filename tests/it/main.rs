//! The integration tests, one binary.

mod cutgraphs;
mod cutting;
mod flattening;
mod golden;
mod measuring;
mod patterns;
mod reading;
mod scripts;
mod surfaces;
mod tidy;
