//! Reading PLY: the polygon format of Stanford, as text or bytes of either order.
//!
//! Guaranteed, besides what [`super`] guarantees: the line that each polygon stands on, in text files; normals and texture
//! coordinates of vertices, as those of their corners, and texture coordinates of faces corner by corner. Not guaranteed:
//! anything of colours, edges and other elements, which are skipped.

mod header;
mod source;

use header::{Element, Encoding, Header, Scalar, Shape};
use source::{Binary, Source, Stop, Text};

use super::attributes::or_broken;
use super::words::Words;
use super::{
    Content, Format, Place, ReadError, ReadFault, ReadNotice, attributes, check_length, note,
    note_incomplete_face, number, to_u32,
};
use crate::mesh::Soup;

/// What the list of the corners of a face is called.
const INDICES: [&[u8]; 2] = [b"vertex_indices", b"vertex_index"];
/// What the list of two texture coordinates for each corner of a face is called.
const FACE_TEXTURE: [&[u8]; 1] = [b"texcoord"];
const NORMAL: [&[u8]; 3] = [b"nx", b"ny", b"nz"];
/// What the texture coordinates of a vertex are called, by different programs.
const TEXTURE: [[&[u8]; 2]; 4] =
    [[b"u", b"v"], [b"s", b"t"], [b"texture_u", b"texture_v"], [b"texture_s", b"texture_t"]];

/// The polygons of a PLY file.
///
/// Understood beyond the plain form: properties of any type in any order, lists anywhere, other elements before, between and
/// after; `tristrips` with −1 between strips; headers with LF, CRLF or CR; text with all numbers on one line, or on many.
///
/// Triangles of a strip that name a vertex twice are how strips turn corners, and are dropped without a notice.
///
/// **Fails** with the first fault in the file. Faces and vertices of binary files are named by number, from 0.
/// **Costs** time linear in `bytes.len()`.
pub fn read(bytes: &[u8]) -> Result<Content, ReadError> {
    check_length(bytes)?;
    let header = Header::read(bytes)?;
    let bytes = header.body;
    match header.encoding {
        Encoding::Text => {
            let words = Words { line: header.body_line, ..Words::new(bytes) };
            Reader::new(&header).read(Text { words }, &header)
        }
        Encoding::LittleEndian => Reader::new(&header).read(Binary::<'_, false> { bytes }, &header),
        Encoding::BigEndian => Reader::new(&header).read(Binary::<'_, true> { bytes }, &header),
    }
}

/// What a property of a vertex or face is to us.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Skip,
    /// x, y, z: 0 to 2.
    Coordinate(usize),
    /// Normal 0 to 2, texture coordinate 3 and 4.
    Attribute(usize),
    Indices,
    FaceTexture,
}

struct Reader {
    soup: Soup,
    /// Number of vertices that the header promises: what an index may name.
    vertices: u64,
    /// Texture coordinates of the corners of a face, until their indices are known.
    face_texture: Vec<f64>,
    incomplete_face: Option<ReadNotice>,
    normal_not_finite: Option<ReadNotice>,
    texture_not_finite: Option<ReadNotice>,
    texture_incomplete: Option<ReadNotice>,
}

impl Reader {
    fn new(header: &Header<'_>) -> Self {
        let vertices = header.elements.iter().find(|e| e.name == b"vertex").map_or(0, |e| e.count);
        Self {
            soup: Soup { starts: vec![0], ..Soup::default() },
            vertices,
            face_texture: Vec::new(),
            incomplete_face: None,
            normal_not_finite: None,
            texture_not_finite: None,
            texture_incomplete: None,
        }
    }

    fn read(mut self, mut source: impl Source, header: &Header<'_>) -> Result<Content, ReadError> {
        let is_face = |e: &Element<'_>| matches!(e.name, b"face" | b"tristrips");
        let has_face_texture =
            header.elements.iter().any(|e| e.name == b"face" && e.has_list(&FACE_TEXTURE));
        let is_known = |e: &Element<'_>| e.name == b"vertex" || is_face(e);
        // What follows the last element that matters may be cut short.
        let end = header.elements.iter().rposition(is_known).map_or(0, |last| last + 1);
        let mut has_vertices = false;
        for element in &header.elements[..end] {
            match element.name {
                b"vertex" if !has_vertices => {
                    has_vertices = true;
                    self.vertices(&mut source, element, has_face_texture)?;
                }
                b"face" | b"tristrips" => self.faces(&mut source, element)?,
                _ => skip(&mut source, element)?,
            }
        }
        let faces = self.soup.polygon_count();
        let vertices = self.soup.positions.len();
        if vertices == 0 {
            return Err(ReadFault::NoVertices { faces }.anywhere());
        }
        if header.elements.iter().filter(|e| is_face(e)).all(|e| e.count == 0) {
            return Err(ReadFault::PointCloud.anywhere());
        }
        if faces == 0 {
            let incomplete_faces = self.incomplete_face.map_or(0, |notice| notice.count);
            let fault = ReadFault::NoFaces { vertices, lines_and_points: 0, incomplete_faces };
            return Err(fault.anywhere());
        }
        attributes::of_vertices(&mut self.soup);
        let mut notices = Vec::from_iter(
            [
                self.incomplete_face,
                self.normal_not_finite,
                self.texture_not_finite,
                self.texture_incomplete,
            ]
            .into_iter()
            .flatten(),
        );
        notices.sort_by_key(|notice| notice.place);
        Ok(Content { format: Format::Ply, soup: self.soup, notices })
    }

    fn vertices(
        &mut self,
        source: &mut impl Source,
        element: &Element<'_>,
        has_face_texture: bool,
    ) -> Result<(), ReadError> {
        for (name, property) in [(&b"x"[..], "x"), (b"y", "y"), (b"z", "z")] {
            if element.count > 0 && !element.has_number(name) {
                return Err(ReadFault::MissingProperty { element: "vertex", property }.anywhere());
            }
        }
        let has_normals = NORMAL.iter().all(|name| element.has_number(name));
        let texture = TEXTURE
            .iter()
            .find(|pair| !has_face_texture && pair.iter().all(|name| element.has_number(name)));
        let roles = Vec::from_iter(element.properties.iter().map(|property| {
            let place = |names: &[&[u8]]| names.iter().position(|name| *name == property.name);
            if let Shape::List { .. } = property.shape {
                Role::Skip
            } else if let Some(i) = place(&[b"x", b"y", b"z"]) {
                Role::Coordinate(i)
            } else if let Some(i) = place(&NORMAL).filter(|_| has_normals) {
                Role::Attribute(i)
            } else if let Some(i) = texture.and_then(|pair| place(pair)) {
                Role::Attribute(3 + i)
            } else {
                Role::Skip
            }
        }));
        let room = room_for(source, element);
        self.soup.positions.reserve(room);
        self.soup.normals.reserve(if has_normals { room } else { 0 });
        self.soup.texture_coordinates.reserve(if texture.is_some() { room } else { 0 });
        for i in 0..element.count {
            let mut position = [0.0; 3];
            let mut attributes = [0.0; 5];
            for (property, role) in element.properties.iter().zip(&roles) {
                let result = match (property.shape, *role) {
                    (Shape::One(kind), Role::Coordinate(axis)) => {
                        source.coordinate(kind).map(|x| position[axis] = x)
                    }
                    (Shape::One(kind), Role::Attribute(slot)) => {
                        source.number(kind).map(|x| attributes[slot] = x)
                    }
                    (shape, _) => skip_property(source, shape),
                };
                result.map_err(|stop| stopped(source, stop, element, i))?;
            }
            self.soup.positions.push(position);
            if has_normals || texture.is_some() {
                let place = source.line().map_or(Place::Vertex(i), Place::Line);
                let [nx, ny, nz, u, v] = attributes;
                if has_normals {
                    let notice = &mut self.normal_not_finite;
                    let normal = finite([nx, ny, nz]);
                    let normal = or_broken(normal, notice, "normal_not_finite", "normal", place);
                    self.soup.normals.push(normal);
                }
                if texture.is_some() {
                    self.soup.texture_coordinates.push(or_broken(
                        finite([u, v]),
                        &mut self.texture_not_finite,
                        "texture_not_finite",
                        "texture coordinate",
                        place,
                    ));
                }
            }
        }
        Ok(())
    }

    fn faces(&mut self, source: &mut impl Source, element: &Element<'_>) -> Result<(), ReadError> {
        let is_strips = element.name == b"tristrips";
        if element.count > 0 && !element.has_list(&INDICES) {
            let element = if is_strips { "tristrips" } else { "face" };
            let property = "vertex_indices";
            return Err(ReadFault::MissingProperty { element, property }.anywhere());
        }
        let mut entry_size = 1;
        let roles =
            Vec::from_iter(element.properties.iter().map(|property| match property.shape {
                Shape::List { entry, .. } if INDICES.contains(&property.name) => {
                    entry_size = source.least_size(entry);
                    Role::Indices
                }
                Shape::List { .. } if FACE_TEXTURE.contains(&property.name) && !is_strips => {
                    Role::FaceTexture
                }
                _ => Role::Skip,
            }));
        let room = if is_strips { 0 } else { room_for(source, element) };
        self.soup.starts.reserve(room);
        self.soup.lines.reserve(if source.line().is_some() { room } else { 0 });
        self.soup.corners.reserve((3 * room).min(source.left() / entry_size));
        for i in 0..element.count {
            let first = self.soup.corners.len();
            let mut line = None;
            self.face_texture.clear();
            for (property, role) in element.properties.iter().zip(&roles) {
                let result = match (property.shape, *role) {
                    (Shape::List { count, entry }, Role::Indices) => {
                        let result = source.list(count, entry);
                        line = source.line();
                        result.and_then(|n| match is_strips {
                            true => self.strip(source, n, entry),
                            false => self.polygon(source, n, entry),
                        })
                    }
                    (Shape::List { count, entry }, Role::FaceTexture) => {
                        source.list(count, entry).and_then(|n| {
                            for _ in 0..n {
                                self.face_texture.push(source.number(entry)?);
                            }
                            Ok(())
                        })
                    }
                    (shape, _) => skip_property(source, shape),
                };
                result.map_err(|stop| stopped(source, stop, element, i))?;
            }
            if is_strips {
                if let Some(line) = line {
                    self.soup.lines.resize(self.soup.polygon_count(), line);
                }
            } else {
                self.finish_face(first, line.map_or(Place::Face(i), Place::Line));
            }
        }
        Ok(())
    }

    /// Appends the corners of a face.
    #[inline]
    fn polygon(&mut self, source: &mut impl Source, n: u64, entry: Scalar) -> Result<(), Stop> {
        for _ in 0..n {
            let index = source.number(entry)?;
            self.soup.corners.push(vertex(index, self.vertices)?);
        }
        Ok(())
    }

    /// Appends the triangles of strips: each corner makes one with the two before it, every other one turned.
    fn strip(&mut self, source: &mut impl Source, n: u64, entry: Scalar) -> Result<(), Stop> {
        let mut before = [None; 2];
        let mut is_turned = false;
        for _ in 0..n {
            let index = source.number(entry)?;
            // −1, or what is left of it in 32 bits without a sign, ends a strip.
            if [-1.0, f64::from(u32::MAX)].contains(&index) {
                before = [None; 2];
                is_turned = false;
                continue;
            }
            let c = vertex(index, self.vertices)?;
            if let [Some(a), Some(b)] = before {
                if a != b && b != c && c != a {
                    self.soup.corners.extend(if is_turned { [b, a, c] } else { [a, b, c] });
                    self.soup.starts.push(to_u32(self.soup.corners.len()));
                }
                is_turned = !is_turned;
            }
            before = [before[1], Some(c)];
        }
        Ok(())
    }

    /// Makes a polygon of the corners from `first` on.
    fn finish_face(&mut self, first: usize, place: Place) {
        let soup = &mut self.soup;
        let corner_count = soup.corners.len() - first;
        if corner_count < 3 {
            soup.corners.truncate(first);
            note_incomplete_face(&mut self.incomplete_face, place, corner_count);
            return;
        }
        soup.starts.push(to_u32(soup.corners.len()));
        if let Place::Line(line) = place {
            soup.lines.push(line);
        }
        let is_whole = self.face_texture.len() == 2 * corner_count;
        if !is_whole && !self.face_texture.is_empty() {
            let numbers = self.face_texture.len();
            note(&mut self.texture_incomplete, "texture_incomplete", place, || {
                format!("{numbers} texture coordinates for {corner_count} corners, ignored")
            });
        }
        for i in 0..corner_count {
            let length = first + i;
            let mut index = attributes::NONE;
            if is_whole {
                index = to_u32(soup.texture_coordinates.len());
                let uv = [self.face_texture[2 * i], self.face_texture[2 * i + 1]];
                soup.texture_coordinates.push(or_broken(
                    finite(uv),
                    &mut self.texture_not_finite,
                    "texture_not_finite",
                    "texture coordinate",
                    place,
                ));
            }
            attributes::push(&mut soup.texture_corners, index, length, soup.corners.capacity());
        }
    }
}

/// An index, if it names one of the vertices.
#[expect(
    clippy::cast_possible_truncation,
    clippy::float_cmp,
    reason = "an index is a number that the cast does not change"
)]
#[inline]
fn vertex(index: f64, vertices: u64) -> Result<u32, ReadFault> {
    let i = index as u32;
    if f64::from(i) == index && u64::from(i) < vertices {
        return Ok(i);
    }
    let vertices = usize::try_from(vertices).unwrap_or(usize::MAX);
    Err(ReadFault::VertexOutOfRange { index: index.to_string(), vertices })
}

/// The numbers, if all are finite.
fn finite<const N: usize>(numbers: [f64; N]) -> Option<[f64; N]> {
    numbers.iter().all(|&x| number::finite(x).is_ok()).then_some(numbers)
}

fn skip(source: &mut impl Source, element: &Element<'_>) -> Result<(), ReadError> {
    // Elements without properties take no room, however many they are.
    if element.properties.is_empty() {
        return Ok(());
    }
    for i in 0..element.count {
        for property in &element.properties {
            skip_property(source, property.shape)
                .map_err(|stop| stopped(source, stop, element, i))?;
        }
    }
    Ok(())
}

#[inline]
fn skip_property(source: &mut impl Source, shape: Shape) -> Result<(), Stop> {
    match shape {
        Shape::One(kind) => source.skip(1, kind),
        Shape::List { count, entry } => {
            let n = source.list(count, entry)?;
            source.skip(n, entry)
        }
    }
}

/// As many elements as the header promises, or as can be there.
fn room_for(source: &impl Source, element: &Element<'_>) -> usize {
    let least = |shape| match shape {
        Shape::One(kind) | Shape::List { count: kind, .. } => source.least_size(kind),
    };
    let size = element.properties.iter().map(|property| least(property.shape)).sum::<usize>();
    usize::try_from(element.count).unwrap_or(usize::MAX).min(source.left() / size.max(1) + 1)
}

/// The error of an element that could not be read.
fn stopped(source: &impl Source, stop: Stop, element: &Element<'_>, i: u64) -> ReadError {
    let what = match element.name {
        b"vertex" => "vertices",
        b"face" => "faces",
        b"tristrips" => "strips",
        _ => "other elements",
    };
    match stop {
        Stop::End => ReadFault::EndsEarly { what, found: i, promised: element.count }.anywhere(),
        Stop::Fault(fault) => {
            let place = match what {
                "vertices" => Place::Vertex(i),
                "faces" | "strips" => Place::Face(i),
                _ => Place::File,
            };
            ReadError { place: source.line().map_or(place, Place::Line), fault }
        }
    }
}
