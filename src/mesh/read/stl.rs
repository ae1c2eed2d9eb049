//! Reading STL, text or binary: facets with three corners each, and nothing that says which corners are one vertex.
//!
//! Guaranteed, besides what [`super`] promises: corners with equal coordinates are one vertex ([`Welder`]); binary
//! files are known by their size and not by the word `solid`, which many programs write into them; each solid of a text is
//! a group. Normals, colours and attribute bytes are passed over: the order of the corners says which side is outside.
//!
//! Not guaranteed: that corners which merely almost coincide are joined, or that the facets close up.

#![expect(clippy::cast_possible_truncation, reason = "elements are numbered in 32 bits")]

use thiserror::Error;

use super::number::{LARGEST, name, parse, quote};
use super::words::Words;
use super::{Content, Format, Place, ReadError, ReadFault, ReadNotice, check_length, note};
use crate::mesh::{Soup, Welder};

/// Bytes of a binary file before the first facet: 80 of any content, then the number of facets.
const HEAD: usize = 84;
/// Bytes of a binary facet: normal, three corners, two bytes of attributes.
const FACET: usize = 50;

/// What is wrong with an STL file that was refused.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum StlFault {
    /// Neither text with facets nor a size that fits a number of facets.
    #[error("not an STL file")]
    NotStl,
    /// All is well but for the facets.
    #[error("no facets")]
    NoFacets,
    /// A coordinate that cannot be used.
    #[error("facet {facet}: coordinate {text} {problem}")]
    Coordinate {
        /// The facet, counted from 0.
        facet: u64,
        /// The coordinate as it stands in the file, or as it would be written.
        text: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A facet of a text with fewer than three corners, or a corner with fewer than three coordinates.
    #[error("facet {facet}: {found} of 3 {what}")]
    Incomplete {
        /// The facet, counted from 0.
        facet: u64,
        /// `corners` or `coordinates`.
        what: &'static str,
        /// Number that is there.
        found: usize,
    },
    /// A word of a text where another should be.
    #[error("facet {facet}: {text} where {expected} should be")]
    Word {
        /// The facet, counted from 0.
        facet: u64,
        /// What should be there.
        expected: &'static str,
        /// The word.
        text: String,
    },
    /// A text that ends inside a facet.
    #[error("ends early, inside facet {facet}")]
    CutShort {
        /// The facet, counted from 0.
        facet: u64,
    },
}

impl StlFault {
    /// What a person can do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::NotStl => {
                "Choose an STL file; if this was a download, check what the link gives."
            }
            Self::NoFacets => "Export a surface: this file holds no triangles.",
            Self::Coordinate { text, .. } if text.contains(',') => {
                "Export with a decimal point, not a comma: many programs follow the language of the system."
            }
            Self::Coordinate { .. } | Self::Incomplete { .. } | Self::Word { .. } => {
                "Repair the mesh in a modelling program and export it again; the file may be damaged here."
            }
            Self::CutShort { .. } => "Export or download the file again: its end is missing.",
        }
    }
}

/// Reads an STL file.
///
/// **Fails** with [`ReadFault::Empty`], [`ReadFault::TooLong`], [`ReadFault::EndsEarly`] or a [`StlFault`]. **Costs** linear time.
pub fn read(bytes: &[u8]) -> Result<Content, ReadError> {
    check_length(bytes)?;
    let promised =
        bytes.get(80..HEAD).map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])));
    let there = (bytes.len().saturating_sub(HEAD) / FACET) as u64;
    let size = |facets: u64| HEAD as u64 + FACET as u64 * facets;
    let is_exact = promised.is_some_and(|facets| size(facets) == bytes.len() as u64);
    if !is_exact && is_text(bytes) {
        return text(bytes);
    }
    let Some(promised) = promised.filter(|_| is_exact || is_plausible(bytes)) else {
        return Err(at(Place::File, StlFault::NotStl.into()));
    };
    if promised > there {
        let fault = ReadFault::EndsEarly { what: "facets", found: there, promised };
        return Err(fault.anywhere());
    }
    binary(bytes, promised)
}

/// Whether the file begins with `solid`, in any case, and does not look binary.
fn is_text(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let bytes = bytes.trim_ascii_start();
    let head = &bytes[..bytes.len().min(1024)];
    head.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && head.get(5).is_none_or(u8::is_ascii_whitespace)
        && head.iter().all(|&b| b >= b' ' || b.is_ascii_whitespace())
}

/// Whether a file whose size does not fit its number of facets is still STL, cut short or with something appended: its
/// header is text, or its first facets have coordinates that could be meant and normals no longer than 1.
fn is_plausible(bytes: &[u8]) -> bool {
    let header = &bytes[..80];
    let is_text = |b: &u8| *b == 0 || (b' '..0x7f).contains(b) || b.is_ascii_whitespace();
    // A quarter of all words of random bytes are such numbers, so that ten facets leave no doubt.
    let mut facets = bytes[HEAD..].as_chunks::<FACET>().0.iter().take(10).peekable();
    let is_any = facets.peek().is_some();
    let is_sane = is_any
        && facets.all(|facet| {
            let [normal, corners @ ..] = vectors(facet);
            let is_number =
                |c: f32| c.is_finite() && (c == 0.0 || c.abs() > 1e-30 && c.abs() < 1e30);
            corners.as_flattened().iter().all(|&c| is_number(c))
                && normal.iter().all(|&c| c.abs() < 1.001)
        });
    is_sane || header.iter().all(is_text) && header.iter().any(|&b| b != 0)
}

/// Normal and corners of a binary facet.
fn vectors(facet: &[u8; FACET]) -> [[f32; 3]; 4] {
    let float =
        |at: usize| f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]);
    [0, 12, 24, 36].map(|at| [float(at), float(at + 4), float(at + 8)])
}

fn binary(bytes: &[u8], promised: u64) -> Result<Content, ReadError> {
    let (facets, _) = bytes[HEAD..].as_chunks::<FACET>();
    let facets = &facets[..facets.len().min(promised as usize)];
    if facets.is_empty() {
        return Err(at(Place::File, StlFault::NoFacets.into()));
    }
    let mut welder = Welder::default();
    let mut soup = Soup { corners: Vec::with_capacity(3 * facets.len()), ..Soup::default() };
    for (facet, index) in facets.iter().zip(0_u64..) {
        let [_, corners @ ..] = vectors(facet);
        for corner in corners {
            if let Some(bad) = corner.iter().find(|c| !c.is_finite()) {
                let problem = "is not a finite number";
                let fault = StlFault::Coordinate { facet: index, text: bad.to_string(), problem };
                let byte = HEAD as u64 + FACET as u64 * index;
                return Err(at(Place::Byte(byte), fault.into()));
            }
            soup.corners.push(welder.add(corner.map(f64::from)));
        }
    }
    soup.starts = (0..=facets.len() as u32).map(|i| 3 * i).collect();
    let mut notices = Vec::new();
    let rest = bytes.len() - HEAD - FACET * facets.len();
    if rest > 0 {
        notices.push(ReadNotice {
            kind: "trailing_bytes",
            count: 1,
            place: Place::Byte((bytes.len() - rest) as u64),
            text: format!("{rest} bytes after the last facet ignored"),
        });
    }
    Ok(finish(soup, welder, notices))
}

fn text(bytes: &[u8]) -> Result<Content, ReadError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut words = Words::new(bytes);
    let mut welder = Welder::default();
    let mut soup = Soup { starts: vec![0], ..Soup::default() };
    let mut ignored: Option<ReadNotice> = None;
    let mut is_open = false;
    while let Some(word) = words.next_on_any_line() {
        let line = words.line;
        if word.eq_ignore_ascii_case(b"facet") {
            if soup.groups.is_empty() {
                soup.groups.push("solid 1".into());
            }
            facet(&mut words, line, &mut welder, &mut soup)?;
        } else if word.eq_ignore_ascii_case(b"solid") {
            let rest = words.rest_of_line().trim_ascii();
            let number = soup.groups.len() + 1;
            let is_named = !rest.is_empty();
            soup.groups.push(if is_named { name(rest) } else { format!("solid {number}") });
            is_open = true;
        } else if word.eq_ignore_ascii_case(b"endsolid") {
            words.skip_line();
            is_open = false;
        } else {
            words.skip_line();
            note(&mut ignored, "unknown_line", Place::Line(line), || {
                format!("line with {} ignored", quote(word))
            });
        }
    }
    if soup.polygon_count() == 0 {
        let fault = if ignored.is_some() { StlFault::NotStl } else { StlFault::NoFacets };
        return Err(at(Place::File, fault.into()));
    }
    let mut notices: Vec<_> = ignored.into_iter().collect();
    if is_open {
        notices.push(ReadNotice {
            kind: "no_end",
            count: 1,
            place: Place::Line(words.line),
            text: "no endsolid, the file may be cut short".into(),
        });
    }
    let lines = std::mem::take(&mut soup.lines);
    let mut content = finish(soup, welder, notices);
    content.soup.lines = lines;
    Ok(content)
}

/// A facet of a text, from after its first word to `endfacet`.
fn facet(
    words: &mut Words<'_>,
    line: u32,
    welder: &mut Welder,
    soup: &mut Soup,
) -> Result<(), ReadError> {
    let facet = soup.polygon_count() as u64;
    let cut_short = at(Place::Line(line), StlFault::CutShort { facet }.into());
    let first = soup.corners.len();
    // The normal may be anything, `nan` or missing.
    loop {
        let word = words.next_on_any_line().ok_or_else(|| cut_short.clone())?;
        if word.eq_ignore_ascii_case(b"loop") {
            break;
        }
    }
    loop {
        let word = words.next_on_any_line().ok_or_else(|| cut_short.clone())?;
        if word.eq_ignore_ascii_case(b"vertex") {
            let line = words.line;
            let mut position = [0.0; 3];
            for (i, coordinate) in position.iter_mut().enumerate() {
                let word = words.next_on_any_line().ok_or_else(|| cut_short.clone())?;
                *coordinate =
                    number(word, facet, i).map_err(|f| at(Place::Line(line), f.into()))?;
            }
            soup.corners.push(welder.add(position));
        } else if word.eq_ignore_ascii_case(b"endloop") {
            break;
        } else {
            let fault = StlFault::Word { facet, expected: "vertex or endloop", text: quote(word) };
            return Err(at(Place::Line(words.line), fault.into()));
        }
    }
    let found = soup.corners.len() - first;
    if found < 3 {
        let fault = StlFault::Incomplete { facet, what: "corners", found };
        return Err(at(Place::Line(line), fault.into()));
    }
    match words.next_on_any_line() {
        Some(word) if word.eq_ignore_ascii_case(b"endfacet") => {}
        Some(word) => {
            let fault = StlFault::Word { facet, expected: "endfacet", text: quote(word) };
            return Err(at(Place::Line(words.line), fault.into()));
        }
        None => return Err(cut_short),
    }
    soup.starts.push(soup.corners.len() as u32);
    soup.lines.push(line);
    soup.polygon_groups.push(soup.groups.len() as u32 - 1);
    Ok(())
}

fn number(word: &[u8], facet: u64, found: usize) -> Result<f64, StlFault> {
    let problem = match parse(word) {
        Some(number) if number.abs() <= LARGEST => return Ok(number),
        Some(number) if number.is_finite() => "is too large (more than 3.4e38)",
        Some(_) => "is not a finite number",
        None if word.eq_ignore_ascii_case(b"vertex") || word.eq_ignore_ascii_case(b"endloop") => {
            return Err(StlFault::Incomplete { facet, what: "coordinates", found });
        }
        None => "is not a number",
    };
    Err(StlFault::Coordinate { facet, text: quote(word), problem })
}

fn finish(soup: Soup, welder: Welder, mut notices: Vec<ReadNotice>) -> Content {
    let corners = soup.corners.len();
    let positions = welder.into_places();
    notices.insert(
        0,
        ReadNotice {
            kind: "welded",
            count: 1,
            place: Place::File,
            text: format!("{corners} corners at {} places", positions.len()),
        },
    );
    Content { format: Format::Stl, soup: Soup { positions, ..soup }, notices }
}

fn at(place: Place, fault: ReadFault) -> ReadError {
    ReadError { place, fault }
}
