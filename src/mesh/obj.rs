//! Reading OBJ: text to polygon soup.
//!
//! Guaranteed, whatever the bytes are: an answer in linear time, without a panic, with memory of a few
//! times the input (nothing is reserved because a file promises it); coordinates correctly rounded,
//! finite, and within the range of `f32`; every vertex index in range; vertices and polygons in the order
//! of the file, with the line that each polygon stands on. Texture coordinates are kept corner by corner,
//! and only they are forgiven: what is wrong with them becomes a [`ReadNotice`].
//!
//! Not guaranteed: that the polygons make a surface. A polygon may name a vertex twice, have no area, or
//! share an edge with five others; building connectivity finds that out. Normals, groups, materials,
//! lines, points and free-form curves are skipped.

use std::fmt;

use thiserror::Error;

use super::Soup;

/// "No texture coordinate", as [`Soup::texture_corners`] has it.
const NONE: u32 = u32::MAX;
/// An index that cannot be valid, whatever follows in the file.
const BAD: u32 = u32::MAX - 1;
/// Coordinates beyond this become infinite on the way to the graphics card.
const LARGEST: f64 = f32::MAX as f64;

/// Why a file was refused.
///
/// Three texts can be made of it: what is wrong ([`ReadError::fault`], displayed), where
/// ([`ReadError::line`]), and what to do ([`ReadFault::advice`]). Displayed whole, it says the first two.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}{fault}", Place(*line))]
pub struct ReadError {
    /// The line at fault, counted from 1; `None` where it is the whole file.
    pub line: Option<u32>,
    /// What is wrong.
    pub fault: ReadFault,
}

/// What is wrong with a file that was refused. Texts are quoted from the file, shortened and printable.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ReadFault {
    /// No bytes at all.
    #[error("the file is empty")]
    Empty,
    /// Lines and indices are counted in 32 bits.
    #[error("the file has {bytes} bytes, more than 4 GiB")]
    TooLong {
        /// Length of the file.
        bytes: usize,
    },
    /// Something else, by its first bytes.
    #[error("not an OBJ file (looks like {looks_like})")]
    NotObj {
        /// What it seems to be.
        looks_like: &'static str,
    },
    /// There is no `v` line.
    #[error("no vertices, {}", if *.faces == 0 { "no faces".into() } else { count(*.faces, "face") })]
    NoVertices {
        /// Number of faces, which can have no meaning.
        faces: usize,
    },
    /// There is no `f` line with three corners.
    #[error("no faces, only {}", list_of_the_rest(*.vertices, *.lines_and_points, *.incomplete_faces))]
    NoFaces {
        /// Number of vertices.
        vertices: usize,
        /// Number of `l` and `p` lines.
        lines_and_points: usize,
        /// Number of faces with fewer than three corners.
        incomplete_faces: usize,
    },
    /// A `v` line ends early.
    #[error("vertex with {found} of 3 coordinates")]
    MissingCoordinate {
        /// Number of coordinates there.
        found: usize,
    },
    /// A coordinate cannot be read.
    #[error("{text} is not a number{}", if .text.contains(',') { " (decimal comma?)" } else { "" })]
    NotANumber {
        /// The coordinate.
        text: String,
    },
    /// A coordinate is infinite or not a number.
    #[error("coordinate {text} is not a finite number")]
    NotFinite {
        /// The coordinate.
        text: String,
    },
    /// A coordinate is finite but cannot be drawn.
    #[error("coordinate {text} is too large (more than 3.4e38)")]
    TooLarge {
        /// The coordinate.
        text: String,
    },
    /// A corner of a face has none of the forms `1`, `1/2`, `1//3`, `1/2/3`.
    #[error("{text} is not a face corner")]
    NotACorner {
        /// The corner.
        text: String,
    },
    /// A face uses a vertex that does not exist.
    #[error("vertex {index} of {vertices}")]
    VertexOutOfRange {
        /// The index as it stands in the file: counted from 1, or backwards from −1.
        index: String,
        /// Number of vertices that the index could have named.
        vertices: usize,
    },
}

impl ReadFault {
    /// What a person can do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Self::Empty => "Export or download the file again, or choose another one.",
            Self::TooLong { .. } => "Reduce the mesh in a modelling program and export it again.",
            Self::NotObj { .. } => {
                "Choose a Wavefront OBJ file: text with lines that begin with v and f. \
                 If this was a download, check what the link gives."
            }
            Self::NoVertices { .. } => {
                "Choose an OBJ file that holds a mesh; this one may be a material file, or cut short."
            }
            Self::NoFaces { .. } => {
                "Export a surface mesh with faces: points and lines alone cannot be cut or flattened."
            }
            Self::MissingCoordinate { .. } => {
                "Write three numbers after each v; the file may be cut short or damaged here."
            }
            Self::NotANumber { text } if text.contains(',') => {
                "Export with a decimal point, not a comma: many programs follow the language of the system."
            }
            Self::NotANumber { .. } => "Correct this line, or export the file again.",
            Self::NotFinite { .. } | Self::TooLarge { .. } => {
                "Remove the broken vertex in a modelling program and export the file again."
            }
            Self::NotACorner { .. } => {
                "Write each corner as a vertex number, with texture and normal numbers after slashes if at all."
            }
            Self::VertexOutOfRange { .. } => {
                "Export the file again: vertices are missing, or the file was put together from several."
            }
        }
    }

    fn at(self, line: u32) -> ReadError {
        ReadError { line: Some(line), fault: self }
    }

    fn anywhere(self) -> ReadError {
        ReadError { line: None, fault: self }
    }
}

/// Something in a file that was passed over, and how often.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadNotice {
    /// What was found, with the values of the first time.
    pub kind: ReadNoticeKind,
    /// How many times.
    pub count: usize,
    /// The line of the first time, counted from 1.
    pub first_line: u32,
}

/// What was passed over.
#[derive(Clone, Debug, PartialEq)]
pub enum ReadNoticeKind {
    /// A face with fewer than three corners was left out.
    IncompleteFace {
        /// Number of its corners.
        corners: usize,
    },
    /// A corner names a texture coordinate that does not exist; it has none.
    TextureOutOfRange {
        /// The index as it stands in the file.
        index: String,
        /// Number of texture coordinates that it could have named.
        texture_coordinates: usize,
    },
    /// A `vt` line without finite numbers; the corners that use it have no texture coordinate.
    TextureNotFinite,
}

impl fmt::Display for ReadNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", Place(Some(self.first_line)))?;
        match &self.kind {
            ReadNoticeKind::IncompleteFace { corners } => {
                write!(f, "face with {} ignored", count(*corners, "corner"))?;
            }
            ReadNoticeKind::TextureOutOfRange { index, texture_coordinates } => {
                write!(f, "vt {index} of {texture_coordinates}, ignored")?;
            }
            ReadNoticeKind::TextureNotFinite => write!(f, "vt is not a number, ignored")?,
        }
        match self.count {
            0 | 1 => Ok(()),
            n => write!(f, " (and {} more)", n - 1),
        }
    }
}

/// The polygons of an OBJ file, and what was passed over, in order of first lines.
///
/// Understood beyond the plain form: polygons of any size; corners `v`, `v/vt`, `v//vn`, `v/vt/vn`, mixed;
/// indices counted backwards from −1, and forwards to vertices that follow later; LF, CRLF and CR; a
/// UTF-8 byte order mark; tabs and leading blanks; a backslash at the end of a `v`, `vt` or `f` line;
/// tags in capitals; a fourth coordinate or a colour after the three (ignored).
///
/// **Fails** with the first fault in the file; indices are checked last, when all vertices are known.
/// **Costs** time linear in `bytes.len()`.
pub fn read(bytes: &[u8]) -> Result<(Soup, Vec<ReadNotice>), ReadError> {
    if bytes.is_empty() {
        return Err(ReadFault::Empty.anywhere());
    }
    if u32::try_from(bytes.len()).is_err() {
        return Err(ReadFault::TooLong { bytes: bytes.len() }.anywhere());
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if let Some(looks_like) = other_format(bytes) {
        return Err(ReadFault::NotObj { looks_like }.anywhere());
    }
    let mut reader = Reader::with_room_for(bytes);
    let mut words = Words { bytes, at: 0, line: 1 };
    while words.at < bytes.len() {
        let line = words.line;
        match words.next() {
            Some(b"v" | b"V") => reader.vertex(&mut words, line)?,
            Some(b"vt" | b"VT") => reader.texture_coordinate(&mut words, line),
            // `fo` is the face of the format's first version.
            Some(b"f" | b"F" | b"fo" | b"FO") => reader.face(&mut words, line)?,
            Some(b"l" | b"L" | b"p" | b"P") => reader.lines_and_points += 1,
            _ => {}
        }
        words.skip_line();
    }
    reader.finish()
}

/// What has been read so far.
struct Reader {
    soup: Soup,
    lines_and_points: usize,
    /// The first corner of a kept face that cannot be valid: its index, and how many vertices there were.
    bad_vertex: Option<(String, usize)>,
    bad_texture: Option<(String, usize)>,
    incomplete_face: Option<ReadNotice>,
    texture_not_finite: Option<ReadNotice>,
}

impl Reader {
    /// A reader with arrays of the right size, so that they need not grow: counted, not promised.
    fn with_room_for(bytes: &[u8]) -> Self {
        let (mut vertices, mut textures, mut faces, mut corners) = (0, 0, 0, 0);
        for line in bytes.split(|b| matches!(b, b'\n' | b'\r')) {
            match line.trim_ascii_start() {
                // The shortest vertex is `v 0 0 0`: shorter lines get no room.
                [b'v' | b'V', b' ' | b'\t', _, _, _, _, _, ..] => vertices += 1,
                [b'v' | b'V', b't' | b'T', b' ' | b'\t', _, ..] => textures += 1,
                [b'f' | b'F', rest @ ..] => {
                    faces += 1;
                    corners += rest.split(|&b| is_blank(b)).filter(|word| !word.is_empty()).count();
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
            ..Soup::default()
        };
        soup.starts.push(0);
        Self {
            soup,
            lines_and_points: 0,
            bad_vertex: None,
            bad_texture: None,
            incomplete_face: None,
            texture_not_finite: None,
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
        match (u, v) {
            (Some(u), Some(v)) => self.soup.texture_coordinates.push([u, v]),
            _ => {
                note(&mut self.texture_not_finite, line, || ReadNoticeKind::TextureNotFinite);
                self.soup.texture_coordinates.push([f64::NAN; 2]);
            }
        }
    }

    fn face(&mut self, words: &mut Words<'_>, line: u32) -> Result<(), ReadError> {
        let Soup {
            positions, corners, starts, lines, texture_coordinates, texture_corners, ..
        } = &mut self.soup;
        let first = corners.len();
        let (mut bad_vertex, mut bad_texture) = (None, None);
        while let Some(word) = words.next() {
            let (vertex, texture) = split_corner(word);
            let not_a_corner = || ReadFault::NotACorner { text: quote(word) }.at(line);
            let v = index(vertex, positions.len()).ok_or_else(not_a_corner)?;
            let t = match texture {
                [] => NONE,
                _ => index(texture, texture_coordinates.len()).ok_or_else(not_a_corner)?,
            };
            if v == BAD {
                bad_vertex.get_or_insert((vertex, positions.len()));
            }
            if t == BAD {
                bad_texture.get_or_insert((texture, texture_coordinates.len()));
            }
            if t != NONE && texture_corners.is_empty() {
                texture_corners.reserve(corners.capacity());
                texture_corners.resize(corners.len(), NONE);
            }
            // Empty means that no corner so far had a texture coordinate.
            if t != NONE || !texture_corners.is_empty() {
                texture_corners.push(t);
            }
            corners.push(v);
        }
        let corner_count = corners.len() - first;
        if corner_count < 3 {
            corners.truncate(first);
            texture_corners.truncate(first);
            note(&mut self.incomplete_face, line, || ReadNoticeKind::IncompleteFace {
                corners: corner_count,
            });
            return Ok(());
        }
        starts.push(to_u32(corners.len()));
        lines.push(line);
        let remember = |(word, count): (&[u8], usize)| (quote(word), count);
        self.bad_vertex = self.bad_vertex.take().or(bad_vertex.map(remember));
        self.bad_texture = self.bad_texture.take().or(bad_texture.map(remember));
        Ok(())
    }

    fn finish(self) -> Result<(Soup, Vec<ReadNotice>), ReadError> {
        let Self { mut soup, lines_and_points, bad_vertex, bad_texture, .. } = self;
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
        let texture_out_of_range = settle_texture_corners(&mut soup, bad_texture);
        let mut notices = Vec::from_iter(
            [self.incomplete_face, texture_out_of_range, self.texture_not_finite]
                .into_iter()
                .flatten(),
        );
        notices.sort_by_key(|notice| notice.first_line);
        Ok((soup, notices))
    }
}

/// Takes the texture coordinate away from each corner whose index is out of range or whose coordinate is
/// not finite; counts the first kind.
fn settle_texture_corners(soup: &mut Soup, bad: Option<(String, usize)>) -> Option<ReadNotice> {
    let texture_coordinates = soup.texture_coordinates.len();
    let mut first = None;
    let mut count = 0;
    for (corner, t) in soup.texture_corners.iter_mut().enumerate() {
        if *t == NONE {
            continue;
        }
        match soup.texture_coordinates.get(*t as usize) {
            Some(uv) if !uv[0].is_nan() => {}
            Some(_) => *t = NONE,
            None => {
                first.get_or_insert((corner, *t));
                count += 1;
                *t = NONE;
            }
        }
    }
    for uv in &mut soup.texture_coordinates {
        if uv[0].is_nan() {
            *uv = [0.0; 2];
        }
    }
    if texture_coordinates == 0 {
        soup.texture_corners.clear();
    }
    first.map(|(corner, t)| {
        let (index, texture_coordinates) = as_written(t, texture_coordinates, bad);
        let kind = ReadNoticeKind::TextureOutOfRange { index, texture_coordinates };
        ReadNotice { kind, count, first_line: line_of_corner(soup, corner) }
    })
}

/// The index that stands in the file, and the number of things that it could have named, for the first
/// stored index that is out of range. Where it is [`BAD`], it is the first such one, which was remembered.
fn as_written(stored: u32, total: usize, bad: Option<(String, usize)>) -> (String, usize) {
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

/// Adds one to a notice, made when it is the first.
fn note(notice: &mut Option<ReadNotice>, line: u32, kind: impl FnOnce() -> ReadNoticeKind) {
    notice.get_or_insert_with(|| ReadNotice { kind: kind(), count: 0, first_line: line }).count +=
        1;
}

/// The words of a text, line by line.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The line that `at` is on, counted from 1.
    line: u32,
}

impl<'a> Words<'a> {
    /// The next word of the line, `None` at its end or at a comment. Steps over a backslash that ends a line.
    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            match *self.bytes.get(self.at)? {
                b if is_blank(b) => self.at += 1,
                b'\n' | b'\r' | b'#' => return None,
                b'\\' if self.is_line_end(self.at + 1) => {
                    self.at += 1;
                    self.skip_line();
                }
                _ => break,
            }
        }
        let start = self.at;
        while let Some(&b) = self.bytes.get(self.at) {
            if is_blank(b) || matches!(b, b'\n' | b'\r') {
                break;
            }
            if b == b'\\' && self.is_line_end(self.at + 1) {
                break;
            }
            self.at += 1;
        }
        Some(&self.bytes[start..self.at])
    }

    /// Steps to the beginning of the next line. A backslash joins no lines here, so that a comment or a
    /// path that ends in one does not swallow the line below.
    fn skip_line(&mut self) {
        let rest = &self.bytes[self.at..];
        match rest.iter().position(|b| matches!(b, b'\n' | b'\r')) {
            Some(end) => {
                self.at += end + if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
                self.line += 1;
            }
            None => self.at = self.bytes.len(),
        }
    }

    fn is_line_end(&self, at: usize) -> bool {
        matches!(self.bytes.get(at), None | Some(b'\n' | b'\r'))
    }
}

fn is_blank(b: u8) -> bool {
    matches!(b, b' ' | b'\t' | b'\x0b' | b'\x0c')
}

fn coordinate(word: &[u8]) -> Result<f64, ReadFault> {
    let value = std::str::from_utf8(word).ok().and_then(|text| text.parse::<f64>().ok());
    match value {
        Some(x) if x.abs() <= LARGEST => Ok(x),
        Some(x) if x.is_finite() => Err(ReadFault::TooLarge { text: quote(word) }),
        Some(_) => Err(ReadFault::NotFinite { text: quote(word) }),
        // Old Microsoft libraries write `1.#INF` and `-1.#IND`.
        None if word.windows(2).any(|pair| pair == b".#") => {
            Err(ReadFault::NotFinite { text: quote(word) })
        }
        None => Err(ReadFault::NotANumber { text: quote(word) }),
    }
}

/// The vertex and the texture part of `v`, `v/vt`, `v//vn` or `v/vt/vn`; empty where there is none.
fn split_corner(word: &[u8]) -> (&[u8], &[u8]) {
    let mut parts = word.splitn(3, |&b| b == b'/');
    (parts.next().unwrap_or_default(), parts.next().unwrap_or_default())
}

/// The index from 0 that a word names when `count` things have been read: possibly one still to come,
/// [`BAD`] where it can never be valid, `None` where the word is no integer.
fn index(word: &[u8], count: usize) -> Option<u32> {
    let (is_relative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0u64;
    for digit in digits {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value.saturating_mul(10).saturating_add(u64::from(digit));
    }
    let zero_based =
        if is_relative { (count as u64).checked_sub(value) } else { value.checked_sub(1) };
    // −0 is relative, and no index either.
    let zero_based = zero_based.filter(|_| value > 0);
    Some(zero_based.and_then(|i| u32::try_from(i).ok()).map_or(BAD, |i| i.min(BAD)))
}

/// What bytes are that are certainly no OBJ file.
fn other_format(bytes: &[u8]) -> Option<&'static str> {
    const MAGIC: [(&[u8], &str); 19] = [
        (b"\xff\xfe", "text in UTF-16"),
        (b"\xfe\xff", "text in UTF-16"),
        (b"glTF", "GLB"),
        (b"ply\n", "PLY"),
        (b"ply\r", "PLY"),
        (b"solid ", "STL"),
        (b"OFF", "OFF"),
        (b"COFF", "OFF"),
        (b"NOFF", "OFF"),
        (b"STOFF", "OFF"),
        (b"Kaydara FBX", "FBX"),
        (b"ISO-10303-21", "STEP"),
        (b"BLENDER", "a Blender file"),
        (b"3D Geometry File Format", "a Rhino file"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"%PDF", "PDF"),
        (b"\x89PNG", "a picture"),
        (b"version https://git-lfs", "a Git LFS pointer"),
    ];
    if let Some((_, name)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some(name);
    }
    let text = bytes.trim_ascii_start();
    if let [b'<', rest @ ..] = text {
        let is = |tag: &[u8]| rest.get(..tag.len()).is_some_and(|s| s.eq_ignore_ascii_case(tag));
        return Some(if is(b"!doctype html") || is(b"html") { "HTML" } else { "XML" });
    }
    if text.starts_with(b"{") {
        return Some("JSON");
    }
    if let Some(facets) = bytes.get(80..84) {
        let facets = facets.iter().rev().fold(0, |sum, &b| sum << 8 | u64::from(b));
        if bytes.len() as u64 == 84 + 50 * facets {
            return Some("STL");
        }
    }
    // Text has next to no control characters, and no zeros; one byte in ten of random data is one.
    let sample = &bytes[..bytes.len().min(4096)];
    let is_control = |&&b: &&u8| b.is_ascii_control() && !matches!(b, b'\t'..=b'\r' | 0x1a);
    let controls = sample.iter().filter(is_control).count();
    (sample.contains(&0) || 32 * controls > sample.len()).then_some("binary data")
}

/// A word of the file that can be shown: printable and short.
fn quote(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let start = &word[..word.len().min(4 * LONGEST)];
    let mut text = String::new();
    for (i, c) in String::from_utf8_lossy(start).chars().enumerate() {
        if i == LONGEST {
            text.push('…');
            break;
        }
        text.push(if c.is_control() { char::REPLACEMENT_CHARACTER } else { c });
    }
    text
}

/// `line 7: `, or nothing.
struct Place(Option<u32>);

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |line| write!(f, "line {line}: "))
    }
}

/// `1 face`, `2 faces`.
fn count(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

fn list_of_the_rest(vertices: usize, lines_and_points: usize, incomplete_faces: usize) -> String {
    let mut list = format!("{vertices} {}", if vertices == 1 { "vertex" } else { "vertices" });
    if lines_and_points > 0 {
        list += &format!(" and {}", count(lines_and_points, "line or point element"));
    }
    if incomplete_faces > 0 {
        list += &format!(" and {}", count(incomplete_faces, "incomplete face"));
    }
    list
}

/// Counts of things in the file, which has at most `u32::MAX` bytes and more bytes than things.
fn to_u32(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}
