//! The four methods and what they share.
//!
//! All of them answer one question, where to cut, and hand on a labelled or cut surface; none of them needs a layout.

pub mod cones;
pub mod cutflow;
pub mod cutgraph;
pub mod developable;
pub mod flow;
pub(crate) mod maxflow;
pub mod phasefield;
pub mod prepare;
pub mod straighten;
