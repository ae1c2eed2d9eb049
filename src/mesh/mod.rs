//! Connectivity, and reading and writing of mesh bytes. Knows no metric.

pub mod obj;
mod soup;

pub use soup::Soup;
