//! Nearest points.
