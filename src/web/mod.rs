//! The browser's two entrances: `Engine` in a worker, `Viewer` on the page. Each is built into a wasm file of its own.

#[cfg(feature = "engine")]
mod engine;
#[cfg(all(feature = "viewer", target_arch = "wasm32"))]
mod viewer;

#[cfg(feature = "engine")]
pub use engine::Engine;
#[cfg(all(feature = "viewer", target_arch = "wasm32"))]
pub use viewer::Viewer;
