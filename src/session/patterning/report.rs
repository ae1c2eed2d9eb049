//! What is told of a pattern: to the page beside its picture, to the command line, to reports.

use serde::Serialize;

/// The sheet of a pattern as it would be written now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatternView {
    /// The SVG that the export writes, with lines wide enough to be seen when the whole sheet is.
    pub svg: String,
    /// Pages that the PDF would have, on the sheet.
    pub pages: Vec<PageView>,
    /// Numbers.
    pub report: PatternReport,
    /// Whether a better layout is being looked for.
    pub is_nesting: bool,
}

/// A page of the PDF on the sheet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageView {
    /// Row letter and column number.
    pub name: String,
    /// Left, top, width and height in millimetres from the upper left corner of the sheet.
    pub frame: [f64; 4],
}

/// The report of `cutflow pattern`. Lengths in millimetres.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatternReport {
    /// Width and height of the drawing.
    pub sheet_mm: [f64; 2],
    /// Sheets of stock.
    pub sheets: usize,
    /// Part of the material that pieces fill.
    pub utilisation: f64,
    /// Length of the roll that is used; 0 without a roll.
    pub roll_length_mm: f64,
    /// Steps of nesting.
    pub nesting_steps: usize,
    /// All pieces.
    pub pieces: Vec<PatternPieceReport>,
    /// All seams.
    pub seams: Vec<PatternSeamReport>,
    /// What a person should know before cutting.
    pub notices: Vec<String>,
}

/// A piece of the pattern.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatternPieceReport {
    /// Letters.
    pub name: String,
    /// Its patch, counted from 0.
    pub patch: usize,
    /// Width and height of what is cut, in the frame of its chart.
    pub size_mm: [f64; 2],
    /// Area within its sewing line.
    pub area_mm2: f64,
    /// Copies, and mirrored copies.
    pub copies: [usize; 2],
    /// What it has to stretch and bend.
    pub hint: String,
}

/// A seam of the pattern.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatternSeamReport {
    /// Its number.
    pub number: usize,
    /// Names of the pieces on both sides.
    pub pieces: [String; 2],
    /// Length on the surface.
    pub length_mm: f64,
    /// Lengths of both sides in the plane.
    pub flat_mm: [f64; 2],
    /// Its allowance.
    pub allowance_mm: f64,
    /// Notches: distances along the surface from the beginning of the seam, and how many marks stand there.
    pub notches: Vec<(f64, usize)>,
}
