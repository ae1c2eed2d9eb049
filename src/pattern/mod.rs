//! From charts to files: pieces in millimetres, their seams, and the bytes of OBJ, SVG and JSON.
//!
//! A chart is unitless; here it gets a size. A [`Piece`] is a chart's outline in millimetres, seen from outside the
//! surface, y up, with its [`Seam`]s: runs of the outline that are sewn to a run of the same length on the surface. A
//! [`Sheet`] says what is drawn of the pieces, as plain lines and texts in layers, so that all drawing formats
//! show the same. Meshes are written in the user's own coordinates, the vertices of the file first and unchanged to the
//! last bit.
//!
//! Guaranteed: outlines are the exact rims of the charts, never simplified; equal input gives equal bytes; numbers never
//! depend on a locale; nothing that is not finite is written. What cannot be drawn, or be cut as it is drawn, is told by a
//! [`Notice`]. Not guaranteed: that outlines do not overlap on the sheet (layout comes from the caller); that the two sides of a
//! seam are equally long in the plane (both lengths are at hand; the difference is the ease).

mod attributes;
mod json;
mod labels;
mod nesting;
mod number;
mod obj;
mod piece;
mod seam;
mod sheet;
mod svg;

pub use json::cut_json;
pub use nesting::{
    CHECK_TOLERANCE_MM, NestFault, NestFlow, NestNotice, NestParams, NestPose, NestShape,
    NestState, Rotations, Stock, UvPackParams, UvPacking, check, pack_uv,
};
pub use obj::{CutSurface, cut_obj, mesh_obj, uv_obj};
pub use piece::{Bounds, Notice, Outline, Pattern, Piece, piece_name};
pub use seam::{Partner, Seam};
pub use sheet::{Layer, Line, Sheet, SheetParams, Text};
pub use svg::svg;
