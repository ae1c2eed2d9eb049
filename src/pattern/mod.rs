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
mod check;
mod drawn;
mod dxf;
mod json;
mod labels;
mod number;
mod obj;
mod pdf;
mod piece;
mod seam;
mod sheet;
pub mod stroke_font;
mod style;
mod svg;
mod transliterate;

pub use check::{SheetNotice, WriteError, check};
pub use dxf::{AstmParams, DxfParams, dxf};
pub use json::cut_json;
pub use obj::{CutSurface, cut_obj, mesh_obj, uv_obj};
pub use pdf::{Orientation, Paper, PdfParams, Picture, PieceNote, Tile, pdf, tiles};
pub use piece::{Bounds, Notice, Outline, Pattern, Piece, piece_name};
pub use seam::{Partner, Seam};
pub use sheet::{Layer, Line, Sheet, SheetParams, Text};
pub use svg::{SvgParams, SvgProfile, svg};
