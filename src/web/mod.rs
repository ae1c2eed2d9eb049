//! The browser's two entrances: `Engine` in a worker, `Viewer` on the page. Each is built into a wasm file of its own.

#[cfg(feature = "viewer")]
mod viewer;

#[cfg(feature = "viewer")]
pub use viewer::Viewer;
