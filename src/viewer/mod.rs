//! The pictures: a surface in space and its charts on a sheet, drawn by wgpu.
//!
//! The only thing known of the rest of the crate is [`Scene`](crate::session::scene::Scene): arrays of
//! numbers. There is no geometry processing here and no browser; a canvas comes in through
//! `canvas`, which exists for wasm only, and the class that the page talks to is
//! [`web::Viewer`](crate::web).
//!
//! From the ground up: [`color`] and [`camera`] are arithmetic, [`pick`] finds the triangle under the
//! pointer, [`brush`] where a stroke passes, [`occlusion`] computes soft shade, [`arrays`] turns a scene into bytes, [`cones`] does so with its cones and [`layers`] with overlapping charts, [`pixels`] are textures, [`stage`] holds
//! all that a picture depends on, and [`painter`] puts one view of a stage on a texture. All but the
//! last are pure and tested natively.
//!
//! Guaranteed: the same picture from WebGPU and WebGL2 up to rounding (colours are encoded by the
//! shaders, onto canvases that are not sRGB); nothing beyond WebGL2's limits (no storage buffers, no
//! compute, no wide lines); nothing uploaded that has not changed; no panic for any scene, a broken
//! one is refused. Not guaranteed: order of blending among ribbons that cross on the screen.

#![expect(
    clippy::cast_possible_truncation,
    reason = "numbers become bytes and cells, where `as` saturates; scenes count in u32"
)]

pub mod arrays;
pub mod brush;
pub mod camera;
#[cfg(target_arch = "wasm32")]
pub mod canvas;
pub mod color;
pub mod cones;
#[cfg(test)]
mod fixtures;
pub mod layers;
pub mod occlusion;
pub mod painter;
pub mod pick;
pub mod pixels;
pub mod stage;
