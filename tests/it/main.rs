//! The integration tests, one binary.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    clippy::disallowed_methods,
    reason = "a test may stop where it meets what it does not expect, and reads and writes files"
)]

mod atlases;
mod baselines;
mod charts;
mod closed_curves;
mod comparing;
mod cone_sessions;
mod cones;
mod conformal;
mod cutgraphs;
mod cutting;
mod developable;
mod doctoring;
mod exported;
mod flattening;
mod folding;
mod golden;
mod hard;
mod isometric;
mod lpfb;
mod measuring;
mod merging;
mod mutation;
mod opening;
mod packing;
mod paper;
mod pattern_allowance;
mod pattern_curve;
mod pattern_files;
mod pattern_flaps;
mod pattern_folds;
mod pattern_marks;
mod pattern_nesting;
mod pattern_notches;
mod pattern_sessions;
mod pattern_writers;
mod patterns;
mod phasefield;
mod placing;
mod preparing;
mod projects;
mod reader_files;
mod reading;
mod reading_obj;
mod reading_off;
mod reading_ply;
mod reading_solids;
mod rounding;
mod scripts;
mod seams;
mod sectors;
mod segmenting;
mod solving;
mod splitting;
mod starts;
mod straightening;
mod studio;
mod studio_files;
mod surfaces;
mod symmetries;
mod targets;
mod tidy;
mod uv_seams;
mod validity;
mod weaknesses;
