//! The viewer for JavaScript.
