//! Reading OFF: the object file format of Geomview, in its text form.
//!
//! Guaranteed, besides what [`super`] guarantees: the line that each polygon stands on; normals and texture coordinates of
//! the vertices, as those of their corners. Not guaranteed: anything of colours, which are skipped.

use super::attributes::{self, or_broken};
use super::number::{coordinate, numbers, quote, whole};
use super::words::Words;
use super::{
    Content, Format, Place, ReadError, ReadFault, ReadNotice, check_length, note_incomplete_face,
    to_u32,
};
use crate::mesh::Soup;

/// What stands in each line of a vertex, besides the coordinates and a colour.
struct Keyword {
    has_texture: bool,
    has_normals: bool,
}

/// Whether a word is `OFF` with prefixes of its variants, or without.
pub(super) fn is_keyword(word: &[u8]) -> bool {
    prefixes(word).is_some()
}

/// Whether `ST`, `C`, `N`, `4` and `n` stand before `OFF`, in that order.
fn prefixes(word: &[u8]) -> Option<[bool; 5]> {
    let mut rest = word.strip_suffix(b"OFF").or_else(|| word.strip_suffix(b"off"))?;
    let found = [&b"ST"[..], b"C", b"N", b"4", b"n"].map(|prefix| {
        let stripped = rest.strip_prefix(prefix);
        rest = stripped.unwrap_or(rest);
        stripped.is_some()
    });
    rest.is_empty().then_some(found)
}

/// The polygons of an OFF file.
///
/// Understood beyond the plain form: the prefixes `ST`, `C`, `N`; counts on the line of the keyword or on later ones, without
/// the number of edges; comments; colours after a vertex or a face; no keyword at all.
///
/// **Fails** with the first fault in the file: coordinates of four or more dimensions and the binary form among them.
/// **Costs** time linear in `bytes.len()`.
pub fn read(bytes: &[u8]) -> Result<Content, ReadError> {
    check_length(bytes)?;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut words = Words::new(bytes);
    let keyword = keyword(&mut words)?;
    let [vertices, faces] = counts(&mut words)?;
    let mut reader = Reader { soup: Soup::default(), broken: [const { None }; 2] };
    reader.vertices(&mut words, &keyword, vertices)?;
    reader.faces(&mut words, faces)
}

fn keyword(words: &mut Words<'_>) -> Result<Keyword, ReadError> {
    let start = *words;
    let Some(first) = words.next_on_any_line() else {
        return Err(ReadFault::NoVertices { faces: 0 }.anywhere());
    };
    let line = words.line;
    let Some([has_texture, _, has_normals, is_4, is_n]) = prefixes(first) else {
        // Some programs leave the keyword out.
        *words = start;
        return match whole(first) {
            Some(_) => Ok(Keyword { has_texture: false, has_normals: false }),
            None => Err(ReadFault::NoHeader { format: Format::Off }.at(line)),
        };
    };
    if is_4 || is_n {
        let feature = format!("{} (coordinates of another space)", quote(first));
        return Err(ReadFault::Unsupported { feature }.at(line));
    }
    let after = *words;
    if words.next() == Some(b"BINARY") {
        return Err(ReadFault::Unsupported { feature: "binary OFF".into() }.at(line));
    }
    *words = after;
    Ok(Keyword { has_texture, has_normals })
}

/// The numbers of vertices and faces. That of edges is passed over: it is seldom right, and need not be there.
fn counts(words: &mut Words<'_>) -> Result<[u64; 2], ReadError> {
    let mut counts = [0; 2];
    for (found, count) in counts.iter_mut().enumerate() {
        let Some(word) = words.next_on_any_line() else {
            let fault = ReadFault::EndsEarly { what: "counts", found: found as u64, promised: 2 };
            return Err(fault.anywhere());
        };
        *count =
            whole(word).ok_or_else(|| ReadFault::NotACount { text: quote(word) }.at(words.line))?;
    }
    if words.next().is_none() {
        // A number alone on the next line is that of edges.
        let mut next = *words;
        if next.next_on_any_line().is_some() && next.next().is_none() {
            *words = next;
        } else {
            return Ok(counts);
        }
    }
    words.skip_line();
    Ok(counts)
}

struct Reader {
    soup: Soup,
    /// Texture coordinates and normals that are no numbers.
    broken: [Option<ReadNotice>; 2],
}

impl Reader {
    fn vertices(
        &mut self,
        words: &mut Words<'_>,
        keyword: &Keyword,
        promised: u64,
    ) -> Result<(), ReadError> {
        let Soup { positions, normals, texture_coordinates, .. } = &mut self.soup;
        // The shortest vertex is `0 0 0` and the end of its line.
        let room = usize::try_from(promised).unwrap_or(usize::MAX).min(words.left() / 6 + 1);
        positions.reserve(room);
        normals.reserve(if keyword.has_normals { room } else { 0 });
        texture_coordinates.reserve(if keyword.has_texture { room } else { 0 });
        let [broken_texture, broken_normal] = &mut self.broken;
        for found in 0..promised {
            let ends_early = ReadFault::EndsEarly { what: "vertices", found, promised };
            let mut word = words.next_on_any_line();
            let line = words.line;
            let place = Place::Line(line);
            let mut position = [0.0; 3];
            for (found, x) in position.iter_mut().enumerate() {
                let Some(text) = word else {
                    // The last line may be cut short, others not.
                    let mut rest = *words;
                    return Err(match rest.next_on_any_line() {
                        None => ends_early.anywhere(),
                        Some(_) => ReadFault::MissingCoordinate { found }.at(line),
                    });
                };
                *x = coordinate(text).map_err(|fault| fault.at(line))?;
                if found < 2 {
                    word = words.next();
                }
            }
            positions.push(position);
            if keyword.has_normals {
                let normal = numbers(std::iter::from_fn(|| words.next()));
                normals.push(or_broken(
                    normal,
                    broken_normal,
                    "normal_not_finite",
                    "normal",
                    place,
                ));
            }
            if keyword.has_texture {
                // Colours of any length may stand before.
                let mut last = [None, words.next()];
                while let Some(word) = words.next() {
                    last = [last[1], Some(word)];
                }
                let uv = numbers(last.into_iter().flatten());
                texture_coordinates.push(or_broken(
                    uv,
                    broken_texture,
                    "texture_not_finite",
                    "texture coordinate",
                    place,
                ));
            }
            words.skip_line();
        }
        Ok(())
    }

    fn faces(mut self, words: &mut Words<'_>, promised: u64) -> Result<Content, ReadError> {
        let vertices = self.soup.positions.len();
        let Soup { corners, starts, lines, .. } = &mut self.soup;
        // The shortest face that is kept is `3 0 0 0` and the end of its line.
        let room = usize::try_from(promised).unwrap_or(usize::MAX).min(words.left() / 8 + 1);
        lines.reserve(room);
        starts.reserve(room + 1);
        starts.push(0);
        let mut incomplete = None;
        for found in 0..promised {
            let ends_early = || ReadFault::EndsEarly { what: "faces", found, promised }.anywhere();
            let word = words.next_on_any_line().ok_or_else(ends_early)?;
            let line = words.line;
            let corner_count =
                whole(word).ok_or_else(|| ReadFault::NotACount { text: quote(word) }.at(line))?;
            if corner_count > words.left() as u64 {
                return Err(ends_early());
            }
            let first = corners.len();
            for _ in 0..corner_count {
                let word = words.next_on_any_line().ok_or_else(ends_early)?;
                let digits = word.strip_prefix(b"-").unwrap_or(word);
                let index = whole(digits)
                    .ok_or_else(|| ReadFault::NotACorner { text: quote(word) }.at(words.line))?;
                if digits.len() < word.len() || index >= vertices as u64 {
                    let index = quote(word);
                    return Err(ReadFault::VertexOutOfRange { index, vertices }.at(words.line));
                }
                corners.push(to_u32(usize::try_from(index).unwrap_or(usize::MAX)));
            }
            words.skip_line();
            if corner_count < 3 {
                let count = corners.len() - first;
                corners.truncate(first);
                note_incomplete_face(&mut incomplete, Place::Line(line), count);
                continue;
            }
            starts.push(to_u32(corners.len()));
            lines.push(line);
        }
        let faces = lines.len();
        if vertices == 0 {
            return Err(ReadFault::NoVertices { faces }.anywhere());
        }
        if promised == 0 {
            return Err(ReadFault::PointCloud.anywhere());
        }
        if faces == 0 {
            let incomplete_faces = incomplete.map_or(0, |notice| notice.count);
            let fault = ReadFault::NoFaces { vertices, lines_and_points: 0, incomplete_faces };
            return Err(fault.anywhere());
        }
        let Self { mut soup, broken: [texture, normal] } = self;
        attributes::of_vertices(&mut soup);
        let mut notices = Vec::from_iter([texture, normal, incomplete].into_iter().flatten());
        notices.sort_by_key(|notice| notice.place);
        Ok(Content { format: Format::Off, soup, notices })
    }
}
