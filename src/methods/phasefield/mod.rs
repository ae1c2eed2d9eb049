//! [PF] Phase-field segmentation: split a surface in two by a smooth field, and the parts again.
//!
//! **Minimises** P_ε[u] + ω J[u] + ε^−κ (C[u] + C[−u]) over fields u whose positive phase has a given share of the area: P is the diffuse length of
//! the interface (Modica–Mortola), J the distortion of both phases by their diffuse scale factors, C the price of a phase in several
//! parts. The sides of a split are split again with the segment's diffuse indicator as weight, so that the indicators of the leaves are a
//! partition of unity. Phases thresholded at 0 are an ordinary cut.
//!
//! Guaranteed: areas are kept exactly at every step; the objective of one start never rises, except where the price of unconnected phases
//! comes in after the warm-up, and at the end, where islands are given up; indicators of the leaves add up to 1. Not guaranteed: the global minimum (starts differ, the best is
//! kept); connected phases, which the price makes likely; anything where ε is not at least twice the edge length ([`epsilon_floor`]).
//!
//! All lengths, ε among them, are those of the surface scaled to area 4π. P is about √2 times the length of the interface, which
//! [`PhaseMeasures::length`] gives with far less bias.
//!
//! **Differs** from the paper: each term's file says how; areas are kept exactly instead of by a penalty; where connected phases are
//! asked for, islands in which a field reaches neither phase are given to what lies around them in the end; [`Screening::Outside`] is not in the paper.

mod cut;
mod domain;
mod flow;
mod lbfgs;
mod objective;
mod params;
mod profile;
mod start;
mod state;
mod terms;
#[cfg(test)]
mod tests;

pub use cut::PhaseMeasures;
pub use flow::{
    EpsilonTooSmall, PhaseFieldCheckpoint, PhaseFieldFlow, epsilon_floor, length_scale,
};
pub use objective::SplitTerms;
pub use params::{PhaseFieldParams, Screening, Start};
pub use state::{PhaseFieldState, PhaseNode};
