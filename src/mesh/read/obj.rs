//! Reading OBJ: text to polygon soup.
//!
//! Guaranteed, besides what [`super`] guarantees: memory of about three times the input at most; the line that each polygon
//! stands on. Texture coordinates and normals are kept corner by corner, groups and materials polygon by polygon.
//!
//! Not guaranteed: that bytes of another format are refused; [`super::read`] finds out what a file is. Material files,
//! lines, points and free-form curves are skipped.

use super::attributes::{self, NONE, Names, or_broken};
use super::number::{coordinate, numbers, quote};
use super::words::{Words, is_blank, without_comment};
use super::{
    Content, Format, Place, ReadError, ReadFault, ReadNotice, check_length, note_incomplete_face,
    to_u32,
};
use crate::mesh::Soup;

/// An index that cannot be valid, whatever follows in the file.
const BAD: u32 = u32::MAX - 1;

/// The polygons of an OBJ file.
///
/// Understood beyond the plain form: polygons of any size; corners `v`, `v/vt`, `v//vn`, `v/vt/vn`, mixed;
/// indices counted backwards from −1, and forwards to vertices that follow later; LF, CRLF and CR; a
/// UTF-8 byte order mark; tabs and leading blanks; a backslash at the end of a `v`, `vt`, `vn` or `f` line;
/// tags in capitals; a fourth coordinate or a colour after the three (ignored).
///
/// The group of a polygon is the last `g` before it, or the last `o` where no `g` followed that; `g` without a name and
/// `g default` are no group of their own.
///
/// **Fails** with the first fault in the file; indices are checked last, when all vertices are known.
/// **Costs** time linear in `bytes.len()`.
pub fn read(bytes: &[u8]) -> Result<Content, ReadError> {
    check_length(bytes)?;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = Reader::with_room_for(bytes);
    let mut words = Words::new(bytes);
    while !words.is_at_end() {
        let line = words.line;
        match words.next() {
            Some(b"v" | b"V") => reader.vertex(&mut words, line)?,
            Some(b"vt" | b"VT") => reader.texture_coordinate(&mut words, line),
            Some(b"vn" | b"VN") => reader.normal(&mut words, line),
            // `fo` is the face of the format's first version.
            Some(b"f" | b"F" | b"fo" | b"FO") => reader.face(&mut words, line)?,
            Some(b"g" | b"G") => {
                reader.group = match without_comment(words.rest_of_line()) {
                    b"" | b"default" => reader.object,
                    name => name,
                };
            }
            Some(b"o" | b"O") => {
                reader.object = without_comment(words.rest_of_line());
                reader.group = reader.object;
            }
            Some(word) if word.eq_ignore_ascii_case(b"usemtl") => {
                reader.material = without_comment(words.rest_of_line());
            }
            Some(b"l" | b"L" | b"p" | b"P") => reader.lines_and_points += 1,
            _ => {}
        }
        words.skip_line();
    }
    reader.finish()
}

/// An index as the file writes it, and how many things there were for it to name.
type Written = (String, usize);

/// What has been read so far.
struct Reader<'a> {
    soup: Soup,
    lines_and_points: usize,
    object: &'a [u8],
    group: &'a [u8],
    material: &'a [u8],
    groups: Names<'a>,
    materials: Names<'a>,
    /// The first index of a kept face that cannot be valid: of a vertex, a texture coordinate, a normal.
    bad: [Option<Written>; 3],
    incomplete_face: Option<ReadNotice>,
    texture_not_finite: Option<ReadNotice>,
    normal_not_finite: Option<ReadNotice>,
}

impl<'a> Reader<'a> {
    /// A reader with arrays of the right size, so that they need not grow: counted, not promised.
    fn with_room_for(bytes: &[u8]) -> Self {
        let [mut vertices, mut textures, mut normals, mut faces, mut corners] = [0; 5];
        for line in bytes.split(|b| matches!(b, b'\n' | b'\r')) {
            match line.trim_ascii_start() {
                // The shortest vertex is `v 0 0 0`: shorter lines get no room.
                [b'v' | b'V', b' ' | b'\t', _, _, _, _, _, ..] => vertices += 1,
                [b'v' | b'V', b't' | b'T', b' ' | b'\t', _, ..] => textures += 1,
                [b'v' | b'V', b'n' | b'N', b' ' | b'\t', _, _, _, _, _, ..] => normals += 1,
                [b'f' | b'F', rest @ ..] => {
                    faces += 1;
                    corners +=
                        rest.windows(2).filter(|b| is_blank(b[0]) && !is_blank(b[1])).count();
                }
                _ => {}
            }
        }
        let mut soup = Soup {
            positions: Vec::with_capacity(vertices),
            corners: Vec::with_capacity(corners),
            starts: Vec::with_capacity(faces + 1),
            lines: Vec::with_capacity(faces),
            texture_coordinates: Vec::with_capacity(textures),
            normals: Vec::with_capacity(normals),
            ..Soup::default()
        };
        soup.starts.push(0);
        Self {
            soup,
            lines_and_points: 0,
            object: b"",
            group: b"",
            material: b"",
            groups: Names::default(),
            materials: Names::default(),
            bad: [const { None }; 3],
            incomplete_face: None,
            texture_not_finite: None,
            normal_not_finite: None,
        }
    }

    fn vertex(&mut self, words: &mut Words<'_>, line: u32) -> Result<(), ReadError> {
        let mut position = [0.0; 3];
        for (found, x) in position.iter_mut().enumerate() {
            let Some(word) = words.next() else {
                return Err(ReadFault::MissingCoordinate { found }.at(line));
            };
            *x = coordinate(word).map_err(|fault| fault.at(line))?;
        }
        self.soup.positions.push(position);
        Ok(())
    }

    fn texture_coordinate(&mut self, words: &mut Words<'_>, line: u32) {
        // One coordinate is allowed: a texture of one dimension.
        let u = words.next().and_then(|word| coordinate(word).ok());
        let v = words.next().map_or(Some(0.0), |word| coordinate(word).ok());
        self.soup.texture_coordinates.push(or_broken(
            u.zip(v).map(|(u, v)| [u, v]),
            &mut self.texture_not_finite,
            "texture_not_finite",
            "vt",
            Place::Line(line),
        ));
    }

    fn normal(&mut self, words: &mut Words<'_>, line: u32) {
        self.soup.normals.push(or_broken(
            numbers(std::iter::from_fn(|| words.next())),
            &mut self.normal_not_finite,
            "normal_not_finite",
            "vn",
            Place::Line(line),
        ));
    }

    fn face(&mut self, words: &mut Words<'_>, line: u32) -> Result<(), ReadError> {
        let Soup {
            positions,
            corners,
            starts,
            lines,
            texture_coordinates,
            texture_corners,
            normals,
            normal_corners,
            polygon_groups,
            polygon_materials,
            ..
        } = &mut self.soup;
        let first = corners.len();
        let counts = [positions.len(), texture_coordinates.len(), normals.len()];
        let mut bad = [None; 3];
        while let Some(word) = words.next() {
            let parts = split_corner(word);
            let mut indices = [NONE; 3];
            for i in 0..3 {
                if i > 0 && parts[i].is_empty() {
                    continue;
                }
                indices[i] = index(parts[i], counts[i])
                    .ok_or_else(|| ReadFault::NotACorner { text: quote(word) }.at(line))?;
                if indices[i] == BAD {
                    bad[i].get_or_insert(parts[i]);
                }
            }
            let [vertex, texture, normal] = indices;
            let (length, room) = (corners.len(), corners.capacity());
            attributes::push(texture_corners, texture, length, room);
            attributes::push(normal_corners, normal, length, room);
            corners.push(vertex);
        }
        let corner_count = corners.len() - first;
        if corner_count < 3 {
            corners.truncate(first);
            texture_corners.truncate(first);
            normal_corners.truncate(first);
            note_incomplete_face(&mut self.incomplete_face, Place::Line(line), corner_count);
            return Ok(());
        }
        let (length, room) = (lines.len(), lines.capacity());
        let group = self.groups.number(self.group);
        attributes::push(polygon_groups, group, length, room);
        let material = self.materials.number(self.material);
        attributes::push(polygon_materials, material, length, room);
        starts.push(to_u32(corners.len()));
        lines.push(line);
        for i in 0..3 {
            if let (None, Some(word)) = (&self.bad[i], bad[i]) {
                self.bad[i] = Some((quote(word), counts[i]));
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<Content, ReadError> {
        let Self { mut soup, lines_and_points, bad, .. } = self;
        let [bad_vertex, bad_texture, bad_normal] = bad;
        let incomplete_faces = self.incomplete_face.as_ref().map_or(0, |notice| notice.count);
        let vertices = soup.positions.len();
        let faces = soup.polygon_count();
        if vertices == 0 {
            return Err(ReadFault::NoVertices { faces }.anywhere());
        }
        if faces == 0 {
            return Err(
                ReadFault::NoFaces { vertices, lines_and_points, incomplete_faces }.anywhere()
            );
        }
        if let Some(corner) = soup.corners.iter().position(|&v| v as usize >= vertices) {
            let (index, vertices) = as_written(soup.corners[corner], vertices, bad_vertex);
            let line = line_of_corner(&soup, corner);
            return Err(ReadFault::VertexOutOfRange { index, vertices }.at(line));
        }
        soup.groups = self.groups.into_names();
        soup.materials = self.materials.into_names();
        let textures = soup.texture_coordinates.len();
        let normals = soup.normals.len();
        let texture = attributes::settle(&mut soup.texture_coordinates, &mut soup.texture_corners);
        let normal = attributes::settle(&mut soup.normals, &mut soup.normal_corners);
        let out_of_range = |kind, tag, total, first: Option<(usize, u32, usize)>, bad| {
            first.map(|(corner, i, count)| {
                let (index, total) = as_written(i, total, bad);
                let place = Place::Line(line_of_corner(&soup, corner));
                ReadNotice {
                    kind,
                    count,
                    place,
                    text: format!("{tag} {index} of {total}, ignored"),
                }
            })
        };
        let mut notices = Vec::from_iter(
            [
                self.incomplete_face,
                out_of_range("texture_out_of_range", "vt", textures, texture, bad_texture),
                self.texture_not_finite,
                out_of_range("normal_out_of_range", "vn", normals, normal, bad_normal),
                self.normal_not_finite,
            ]
            .into_iter()
            .flatten(),
        );
        notices.sort_by_key(|notice| notice.place);
        Ok(Content { format: Format::Obj, soup, notices })
    }
}

/// The index that stands in the file, and the number of things that it could have named, for the first
/// stored index that is out of range. Where it is [`BAD`], it is the first such one, which was remembered.
fn as_written(stored: u32, total: usize, bad: Option<Written>) -> Written {
    match bad {
        // Zero and huge numbers are wrong whatever the count: name the final one.
        Some((index, so_far)) if stored == BAD => {
            let count = if index.starts_with('-') { so_far } else { total };
            (index, count)
        }
        _ => ((u64::from(stored) + 1).to_string(), total),
    }
}

fn line_of_corner(soup: &Soup, corner: usize) -> u32 {
    let polygon = soup.starts.partition_point(|&start| start as usize <= corner) - 1;
    soup.lines[polygon]
}

/// The vertex, texture and normal parts of `v`, `v/vt`, `v//vn` or `v/vt/vn`; empty where there is none.
#[inline]
fn split_corner(word: &[u8]) -> [&[u8]; 3] {
    let mut parts = word.splitn(3, |&b| b == b'/');
    std::array::from_fn(|_| parts.next().unwrap_or_default())
}

/// The index from 0 that a word names when `count` things have been read: possibly one still to come,
/// [`BAD`] where it can never be valid, `None` where the word is no integer.
#[inline]
fn index(word: &[u8], count: usize) -> Option<u32> {
    let (is_relative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    let value = super::number::whole(digits)?;
    let zero_based =
        if is_relative { (count as u64).checked_sub(value) } else { value.checked_sub(1) };
    // −0 is relative, and no index either.
    let zero_based = zero_based.filter(|_| value > 0);
    Some(zero_based.and_then(|i| u32::try_from(i).ok()).map_or(BAD, |i| i.min(BAD)))
}
