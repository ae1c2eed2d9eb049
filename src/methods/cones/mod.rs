//! \[MAD\] Optimal cones: a flat metric with few cone points and little area distortion.
//!
//! Let Ω be the angle defects of a surface, M its lumped mass, L the cotan Laplacian. Angles μ at the vertices and the
//! log scale factor u of the metric with these angle defects solve
//!
//! minimise ½ uᵀM u + λ Σ w_i |μ_i| subject to L u = μ − Ω, low ≤ μ ≤ high,
//!
//! a convex problem whose solution is sparse. [`ConeFlow`] finds it in two ways: `greens`, an active set over Green's functions,
//! for few cones, and `newton`, a semismooth Newton method on the two-ring system, for many; both end in the exact discrete optimum
//! and certify it by the gap to the dual objective (`certificate`). λ and ∫u² have the unit of an area.
//!
//! Guaranteed: surfaces of any genus, with or without boundary, of several components, each closed component with the total angle 2πχ
//! that Gauss–Bonnet asks for; no regularisation is left in the result; the same input gives the same bits. Not guaranteed: that cones
//! are single vertices (a cone between vertices comes out as a cluster), and that angles stay below 2π unless bounded.
//!
//! **From** Soliman, Slepčev, Crane: *Optimal Cone Singularities for Conformal Flattening*, 2018. **Differs**: the energy is halved
//! everywhere; signs are those of a positive semi-definite L; λ is the paper's over about 100.

mod aim;
mod certificate;
mod coarse;
mod debias;
mod edit;
mod error;
mod extent;
mod flow;
mod greedy;
mod greens;
mod newton;
mod params;
mod path;
mod places;
mod problem;
mod rounding;
mod rounds;
mod system;
mod two_ring;
mod weights;

pub use debias::debias;
pub use edit::{ConeEdit, EditError, PlacedCone, edit_cones};
pub use error::{ConeConflict, ConeError};
pub use flow::{ConeCheckpoint, ConeFlow};
pub use greedy::{GreedyCones, GreedyStep, greedy_cones};
pub use params::{
    Cone, ConeBoundary, ConeEvaluation, ConeFields, ConeMethod, ConeParams, ConeState, ConeTarget,
    LEAST_WEIGHT,
};
pub use path::{ConePath, PathPoint};
pub use places::Places;
pub use rounding::{RoundParams, Rounded, round_clusters};
pub use weights::feature_size_weights;
