//! PDF to print at home or in a copy shop, in real size.
//!
//! The sheet is cut into pages that overlap. Each page has a frame to trim along, marks that the page across has too, its
//! row and column, and a control square of 50 mm; a cover tells how to print and to join, and an assembly sheet shows all pieces and
//! what is sewn to what. Layers of the drawing are layers of the document.
//!
//! Guaranteed: lengths are true to 0.0001 mm at 100 %; equal sheets give equal bytes (no date, an id from the contents); text is
//! Helvetica, which readers have, or strokes where it lacks a letter. Not guaranteed: that a print dialog does not shrink
//! pages all the same; that is what the squares are for.

mod assembly;
mod canvas;
mod cover;
mod document;
mod ink;
mod letters;
mod marks;
mod room;
mod table;
mod tile_page;
mod tiles;

use super::check::{WriteError, refuse};
use super::sheet::{Layer, Sheet};
use document::Document;
use tile_page::TilePage;
pub use tiles::{Tile, tiles};

/// What is printed on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paper {
    /// 210 × 297 mm.
    A4,
    /// 297 × 420 mm.
    A3,
    /// 8.5 × 11 inches.
    Letter,
    /// 8.5 × 14 inches.
    Legal,
    /// 11 × 17 inches.
    Tabloid,
    /// A page as large as the sheet; more only beyond the 5080 mm that readers take.
    OnePage,
    /// A roll in a plotter: pages as wide, and as long as they need to be.
    Roll {
        /// Width of the roll.
        width_mm: f64,
    },
}

/// How pages lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orientation {
    /// Whichever takes fewer pages.
    #[default]
    Auto,
    /// Upright.
    Portrait,
    /// On their side.
    Landscape,
}

/// A picture: rows from the top, three bytes for each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Red, green, blue of each.
    pub rgb: Vec<u8>,
}

/// What the lists say of a piece.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PieceNote {
    /// How often it is cut: `2`, `1 + 1 mirrored`. Empty for once.
    pub count: String,
    /// Anything else.
    pub note: String,
}

/// How a sheet is printed.
#[derive(Clone, Debug, PartialEq)]
pub struct PdfParams {
    /// On what.
    pub paper: Paper,
    /// Which way round.
    pub orientation: Orientation,
    /// What the printer cannot reach, on all four sides; few reach the last 6.35 mm.
    pub margin_mm: f64,
    /// By how much pages overlap; 0 to trim them and join them edge to edge.
    pub overlap_mm: f64,
    /// Whether pages that lie wholly inside a piece are printed, though they are empty.
    pub keep_inner_pages: bool,
    /// What is drawn.
    pub layers: Vec<Layer>,
    /// Whether there is a cover.
    pub has_cover: bool,
    /// Whether there are assembly sheets.
    pub has_assembly: bool,
    /// More lines for the cover: material, date, scale.
    pub notes: Vec<String>,
    /// For each piece of the sheet; may be shorter.
    pub pieces: Vec<PieceNote>,
    /// The surface, for the cover.
    pub picture: Option<Picture>,
}

impl Default for PdfParams {
    fn default() -> Self {
        Self {
            paper: Paper::A4,
            orientation: Orientation::Auto,
            margin_mm: 10.0,
            overlap_mm: 12.0,
            keep_inner_pages: true,
            layers: Layer::ALL.to_vec(),
            has_cover: true,
            has_assembly: true,
            notes: Vec::new(),
            pieces: Vec::new(),
            picture: None,
        }
    }
}

/// The bytes of a PDF file of the sheet: cover, assembly sheets, pages by row and column.
///
/// **Fails** as [`check`](super::check()) does, where margins and overlap leave no room on the page, for thousands of pages, and for a
/// picture without its pixels. **Costs** O(n) for each way to lay the pages, and for each page what is on it.
pub fn pdf(sheet: &Sheet, params: &PdfParams) -> Result<Vec<u8>, WriteError> {
    refuse(sheet)?;
    if let Some(Picture { width, height, rgb }) = &params.picture {
        let bytes = u64::from(*width) * u64::from(*height) * 3;
        if bytes == 0 || bytes != rgb.len() as u64 {
            let (width, height, bytes) = (*width, *height, rgb.len());
            return Err(WriteError::NoPicture { width, height, bytes });
        }
    }
    let grid = tiles::grid(sheet, params)?;
    let tiles = grid.tiles();
    let marks = marks::marks(&grid);
    let mut document = Document::new();
    // Cover and lists are for the printer on the desk.
    let office = match params.paper {
        Paper::A4 | Paper::A3 | Paper::Letter | Paper::Legal | Paper::Tabloid => params.paper,
        Paper::OnePage | Paper::Roll { .. } => Paper::A4,
    };
    let office = office.upright();
    if params.has_cover || (tiles.is_empty() && !params.has_assembly) {
        document.add(office, &cover::cover(sheet, params, &grid, office));
    }
    if params.has_assembly {
        for canvas in assembly::assembly(sheet, params, office) {
            document.add(office, &canvas);
        }
    }
    for (number, (tile, marks)) in tiles.iter().zip(&marks).enumerate() {
        let (number, count) = (number + 1, tiles.len());
        let page = TilePage { grid: &grid, tile, marks, number, count };
        document.add(grid.page, &page.draw(sheet, params, document::PAGE_LAYER));
    }
    Ok(document.finish(&sheet.title, params.picture.as_ref()))
}

impl PdfParams {
    /// What the lists say of a piece.
    fn note(&self, piece: usize) -> (&str, &str) {
        let note = self.pieces.get(piece);
        let count = note.map_or("", |note| note.count.as_str());
        (if count.is_empty() { "1" } else { count }, note.map_or("", |note| note.note.as_str()))
    }
}
