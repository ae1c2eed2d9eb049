//! Notches.
