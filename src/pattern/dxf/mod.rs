//! DXF of release 12, which every shop's software reads: one unit is one millimetre.
//!
//! Two dialects. The plain one is for lasers, knives and drawing programs: a layer for each kind of line, each piece a
//! block that is placed once, or everything as loose entities. The other follows ASTM D6673, as programs for clothing want it:
//! numbered layers, one block for each piece with turn and curve points, notches as points, and nothing that is not a piece.
//!
//! Guaranteed: 7-bit ASCII, fixed-point numbers of four decimals at most, names of capitals, digits, `_`, `-` and `$`, unique
//! whatever the case, every polyline closed by its flag and ended by SEQEND. Curves are written as the polylines that stand for
//! them. Not guaranteed: that a text is as wide as on screen; every program has a font of its own.

mod astm;
mod groups;
mod names;
mod plain;

use super::check::{WriteError, refuse};
use super::drawn::{cutting_order, drawn};
use super::piece::Bounds;
use super::sheet::{Layer, Line, Sheet};

/// Which dialect is written.
#[derive(Clone, Debug, PartialEq)]
pub enum DxfParams {
    /// Layers by name, for machines and drawing programs.
    Plain {
        /// Without blocks, for programs that skip them.
        is_exploded: bool,
        /// Without the two header variables that tell the unit but are younger than release 12.
        is_strict: bool,
    },
    /// Numbered layers of ASTM D6673.
    Astm(AstmParams),
}

impl Default for DxfParams {
    fn default() -> Self {
        Self::Plain { is_exploded: false, is_strict: false }
    }
}

/// What stands in an ASTM file besides the pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AstmParams {
    /// Whether the header is empty, as Gerber's reader wants it, instead of holding the release.
    pub is_gerber: bool,
    /// dd-mm-yyyy; may be empty.
    pub date: String,
    /// hh:mm; may be empty.
    pub time: String,
    /// The name of the one size.
    pub size: String,
    /// The material of all pieces; may be empty.
    pub material: String,
    /// For each piece how many are cut as drawn, and how many mirrored; 1 and 0 where there is none.
    pub quantities: Vec<[usize; 2]>,
}

/// The bytes of a DXF file of the sheet.
///
/// **Fails** as [`check`](super::check()) does, and in ASTM for a piece without a closed cut line. **Costs** O(n log n).
pub fn dxf(sheet: &Sheet, params: &DxfParams) -> Result<Vec<u8>, WriteError> {
    refuse(sheet)?;
    match params {
        DxfParams::Plain { is_exploded, is_strict } => {
            Ok(plain::write(sheet, *is_exploded, *is_strict))
        }
        DxfParams::Astm(params) => astm::write(sheet, params),
    }
}

/// The lines of one piece, or of none: those to be cut first among themselves in an order to cut in.
fn lines_of<'a>(sheet: &'a Sheet, cuts: &[usize], piece: Option<usize>) -> Vec<&'a Line> {
    let own = |line: &&Line| line.piece == piece;
    let cut = cuts.iter().map(|&i| &sheet.lines[i]).filter(own);
    cut.chain(sheet.lines.iter().filter(own).filter(|line| line.layer != Layer::Cut)).collect()
}

/// Around the cut lines of a piece, or all of its lines where it has none; `None` for a piece without lines.
fn piece_bounds(sheet: &Sheet, piece: usize) -> Option<Bounds> {
    let own = |line: &&Line| line.piece == Some(piece);
    let around = |only_cut: bool| {
        let lines = sheet.lines.iter().filter(own);
        let lines = lines.filter(move |line| !only_cut || line.layer == Layer::Cut);
        let points: Vec<[f64; 2]> =
            lines.flat_map(drawn).flat_map(|stroke| stroke.points).collect();
        (!points.is_empty()).then(|| Bounds::around(points))
    };
    around(true).or_else(|| around(false))
}
