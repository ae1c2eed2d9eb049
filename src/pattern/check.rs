//! What cannot be written, and what a person should know before a sheet is cut.

use std::collections::BTreeMap;

use super::drawn::drawn;
use super::piece::{Outline, crossings};
use super::sheet::{Layer, Line, Sheet};

/// Why there is no file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WriteError {
    /// A place is not a number, or infinite.
    #[error("\"{id}\" has a place that is not a number")]
    NotFinite {
        /// The line or text.
        id: String,
    },
    /// The sheet has no size.
    #[error("the sheet is {} × {} mm", size[0], size[1])]
    NoSize {
        /// Width and height, mm.
        size: [f64; 2],
    },
    /// A closed cut line with fewer than two points encloses nothing and cuts nothing.
    #[error("the cut line \"{id}\" has {points} points")]
    FewPoints {
        /// The line.
        id: String,
        /// How many points it has.
        points: usize,
    },
    /// A piece has no closed cut line, and the format demands one.
    #[error("piece {} has no closed outline", piece + 1)]
    NoOutline {
        /// Index of the piece.
        piece: usize,
    },
    /// Margins and overlap leave nothing of the paper.
    #[error("margins and overlap leave {} × {} mm of the page", window[0], window[1])]
    NoRoom {
        /// Width and height that are left, mm; may be negative.
        window: [f64; 2],
    },
    /// Nobody prints that many pages.
    #[error("the sheet would take {pages} pages; {limit} are the most")]
    TooManyPages {
        /// Number of pages.
        pages: usize,
        /// The most that are written.
        limit: usize,
    },
    /// A picture's bytes are not three for each of its pixels.
    #[error("a picture of {width} × {height} pixels came with {bytes} bytes")]
    NoPicture {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Bytes that came.
        bytes: usize,
    },
}

/// What is written differently than it was given, or cannot be cut as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum SheetNotice {
    /// The cut lines of a piece cross one another or themselves: drawn, but not to be cut from one sheet.
    Crosses {
        /// The first cut line of the piece.
        id: String,
        /// How often.
        crossings: usize,
        /// Where first on the sheet, mm.
        at: [f64; 2],
    },
    /// Consecutive points of a line fall together at 0.0001 mm: each place is written once.
    ZeroEdges {
        /// The line.
        id: String,
        /// How many points are left out.
        count: usize,
    },
    /// A closed line has no area, only two ends: it is written as an open line, a slit.
    Slit {
        /// The line.
        id: String,
    },
    /// A line is a single place: nothing is drawn.
    LeftOut {
        /// The line.
        id: String,
    },
}

impl std::fmt::Display for SheetNotice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Crosses { id, crossings, at: [x, y] } => {
                let times = if *crossings == 1 { "" } else { "s" };
                write!(
                    f,
                    "the cut line \"{id}\" crosses itself or another {crossings} time{times}, "
                )?;
                write!(f, "first at {x:.1}, {y:.1} mm")
            }
            Self::ZeroEdges { id, count } => {
                write!(f, "{count} points of \"{id}\" repeat the one before and are left out")
            }
            Self::Slit { id } => write!(f, "\"{id}\" encloses no area and is written as a slit"),
            Self::LeftOut { id } => write!(f, "\"{id}\" has no length and is left out"),
        }
    }
}

/// What is wrong with a sheet, before it is written.
///
/// **Gives** what will be mended or cannot be cut as drawn. **Fails** as every writer does: for places that are not finite, a
/// sheet without size, closed cut lines of fewer than two points. **Costs** O(n log n).
pub fn check(sheet: &Sheet) -> Result<Vec<SheetNotice>, WriteError> {
    refuse(sheet)?;
    let mut notices = Vec::new();
    for line in &sheet.lines {
        let strokes = drawn(line);
        let id = || line.id.clone();
        let kept: usize = strokes.iter().map(|stroke| stroke.points.len()).sum();
        if strokes.is_empty() {
            notices.push(SheetNotice::LeftOut { id: id() });
        } else if line.is_closed && !strokes[0].is_closed {
            notices.push(SheetNotice::Slit { id: id() });
        } else if line.points.len() > 1 && kept < line.points.len() {
            notices.push(SheetNotice::ZeroEdges { id: id(), count: line.points.len() - kept });
        }
    }
    // Cut lines of one piece together; those of no piece each by itself.
    let mut cuts: BTreeMap<(Option<usize>, usize), Vec<&Line>> = BTreeMap::new();
    let closed = |line: &&Line| line.layer == Layer::Cut && line.is_closed;
    for (number, line) in sheet.lines.iter().filter(closed).enumerate() {
        let own = if line.piece.is_some() { 0 } else { number };
        cuts.entry((line.piece, own)).or_default().push(line);
    }
    for lines in cuts.values() {
        let strokes = lines.iter().flat_map(|line| drawn(line)).filter(|stroke| stroke.is_closed);
        let outline = |points| Outline { points, vertices: Vec::new() };
        let outlines: Vec<Outline> = strokes.map(|stroke| outline(stroke.points)).collect();
        let (crossings, at) = crossings(&outlines);
        if crossings > 0 {
            notices.push(SheetNotice::Crosses { id: lines[0].id.clone(), crossings, at });
        }
    }
    Ok(notices)
}

/// Fails for what no format can hold.
pub(super) fn refuse(sheet: &Sheet) -> Result<(), WriteError> {
    let [width, height] = sheet.size;
    if !(width > 0.0 && height > 0.0 && width.is_finite() && height.is_finite()) {
        return Err(WriteError::NoSize { size: sheet.size });
    }
    let is_finite = |p: &[f64; 2]| p.iter().all(|x| x.is_finite() && x.abs() < 1e9);
    for line in &sheet.lines {
        let mut places = line.points.iter().chain(line.curve.iter().flatten());
        if !places.all(is_finite) {
            return Err(WriteError::NotFinite { id: line.id.clone() });
        }
        if line.layer == Layer::Cut && line.is_closed && line.points.len() < 2 {
            return Err(WriteError::FewPoints { id: line.id.clone(), points: line.points.len() });
        }
    }
    for text in &sheet.texts {
        if !(is_finite(&text.at) && text.height.is_finite() && text.height > 0.0) {
            return Err(WriteError::NotFinite { id: text.id.clone() });
        }
    }
    Ok(())
}
