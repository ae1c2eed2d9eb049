//! Quadrics.
