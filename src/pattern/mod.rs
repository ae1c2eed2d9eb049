//! From charts to what a workshop cuts, and to files.
//!
//! A chart is unitless; here it gets a size. A [`Piece`] is a chart's outline in millimetres, seen from outside the
//! surface, y up, with its [`Seam`]s: runs of the outline that are sewn to a run of the same length on the surface. [`blanks`] makes pieces ready:
//! [`allowance`], [`notches`], [`folds`](folds()), [`flaps`](flaps()), [`marks`](marks()), smooth outlines ([`curve`]). [`nesting`] says where they lie on their material. A
//! [`Sheet`] says what is drawn, as plain lines and texts in layers, so that [`svg`](svg()), [`dxf`](dxf()) and [`pdf`](pdf()) show the
//! same. Meshes are written in the user's own coordinates, the vertices of the file first and unchanged to the last bit.
//!
//! Guaranteed: outlines are the exact rims of the charts unless smooth curves are asked for; a cut line never enters its piece, and a layout has the gaps
//! that it should, or a notice says where not; equal input gives equal bytes; numbers never depend on a locale; nothing that is not finite is
//! written. Not guaranteed: that the two sides of a seam are equally long in the plane (both lengths are at hand; the difference is the
//! ease); that a layout is the shortest.

pub mod allowance;
mod atlas_image;
mod attributes;
mod blank;
mod bytes;
mod check;
pub mod curve;
mod drawn;
mod dxf;
mod flaps;
mod flat_obj;
mod folds;
mod glb;
mod grain;
mod grid;
mod hints;
mod json;
mod kerf;
mod labels;
mod laid;
mod marks;
mod moved;
pub mod nesting;
pub mod notches;
mod number;
mod obj;
mod pdf;
mod piece;
mod plane;
mod ply;
mod png;
mod portrait;
mod seam;
mod sheet;
mod split;
pub mod stroke_font;
mod style;
mod svg;
mod transliterate;
mod upright;
mod uv_map;
mod zip;

pub use atlas_image::{AtlasImageParams, atlas_image};
pub use blank::{Blank, BlankParams, Blanks, Word, blanks};
pub use bytes::FileFault;
pub use check::{SheetNotice, WriteError, check};
pub use dxf::{AstmParams, DxfParams, dxf};
pub use flaps::{
    Base, Flap, FlapLabel, FlapNotice, FlapParams, FlapSide, cut_with_flaps, flap_labels, flaps,
};
pub use flat_obj::flat_obj;
pub use folds::{Fold, FoldParams, fold_layer, fold_shortening_mm, folds};
pub use glb::{Texture, uv_glb};
pub use grain::{Grain, GrainParams, grain};
pub use hints::{Ease, HintParams, Hints, PieceHints, hints};
pub use json::cut_json;
pub use kerf::kerf;
pub use laid::LaidSurface;
pub use marks::{Dart, Mark, MarkKind, MarkParams, darts, marks};
pub use nesting::{
    CHECK_TOLERANCE_MM, NestFault, NestFlow, NestNotice, NestParams, NestPose, NestShape,
    NestState, Rotations, Stock, UvPackParams, UvPacking, pack_uv,
};
pub use obj::{CutSurface, cut_obj, mesh_obj, uv_obj};
pub use pdf::{Orientation, Paper, PdfParams, Picture, PieceNote, Tile, pdf, tiles};
pub use piece::{Bounds, Notice, Outline, Pattern, Piece, piece_name};
pub use ply::uv_ply;
pub use png::{Channels, png};
pub use portrait::{PortraitParams, portrait, side_by_side};
pub use seam::{Partner, Seam};
pub use sheet::{Layer, Line, Placed, Sheet, SheetParams, Text};
pub use svg::{SvgParams, SvgProfile, svg};
pub use upright::uprights;
pub use zip::{ZipEntry, zip, zip_name};
