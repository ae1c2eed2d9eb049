//! Quasi-developable patches [LPFB]: charts are merged as long as the union still flattens without stretching.
//!
//! A *trial* takes the faces of two patches and the cut without some curve between them, finds the length-preserved boundary
//! ([`super::lpfb`]), fills the interior in, and asks for limits on area and stretch, no flips, no crossings. Cuts that are left inside a patch become *darts*.
//!
//! *Best first* (see [`MergeStrategy`]): of all merges that pass, the one with the smallest (A_abs + .01) / ℓ · (a / A)^¼ comes first, ℓ the length of seam that it
//! removes and a the smaller patch's area: good maps first, long seams first, small patches first. Candidates are the curves between two patches one by one, and all of a
//! pair at once. Tips of cuts whose vertex has an angle sum of 2π or more are glued, because a flat chart would overlap there. Where only the change of area is too
//! large, short darts are cut from the most compressed vertex to the rim.
//!
//! Most trials end at the boundary, so that it is looked at before the inside is: rims are walked, joined and laid out without numbering the patch, as far as it takes
//! to see that the change of area is too large or that other trials come first.
//!
//! Guaranteed: at any moment every patch has a map within the limits ([`PatchInfo`] tells exceptions: charts of a face or two that fail, and what the user
//! forced); in the end all patches are flattened anew, by other code, and a patch that then fails is an error. Not guaranteed: the fewest patches.

mod finish;
mod flow;
mod gate;
mod improve;
mod mirror;
mod network;
mod order;
mod params;
mod split;
mod state;
mod trial;
mod ways;

pub use flow::{MergeFlow, ParamsChange};
pub use gate::ChartGate;
pub use mirror::maps_triangles;
pub use params::{AreaMeasure, MergeParams, MergeStrategy, MergeWishes};
pub use state::{MergePhase, MergeState, PatchInfo};
pub use trial::Reject;
