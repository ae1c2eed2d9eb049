//! Surfaces made by our own code.
