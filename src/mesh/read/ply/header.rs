//! The header of a PLY file: which elements follow, and of what they are made.
//!
//! Guaranteed: counts are what the file says, and nothing is reserved for them. Not guaranteed: that they are true.

use crate::mesh::read::number::{quote, whole};
use crate::mesh::read::{Format, ReadError, ReadFault};

/// How the numbers after the header are written.
#[derive(Clone, Copy)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// A type of number.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Number of bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// One number, or a count and so many numbers.
#[derive(Clone, Copy)]
pub(super) enum Shape {
    One(Scalar),
    List { count: Scalar, entry: Scalar },
}

pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    pub(super) shape: Shape,
}

pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    pub(super) count: u64,
    pub(super) properties: Vec<Property<'a>>,
}

impl Element<'_> {
    /// Whether there is a number (not a list) of this name.
    pub(super) fn has_number(&self, name: &[u8]) -> bool {
        self.properties.iter().any(|p| p.name == name && matches!(p.shape, Shape::One(_)))
    }

    /// Whether there is a list of one of these names.
    pub(super) fn has_list(&self, names: &[&[u8]]) -> bool {
        self.properties
            .iter()
            .any(|p| names.contains(&p.name) && matches!(p.shape, Shape::List { .. }))
    }
}

pub(super) struct Header<'a> {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element<'a>>,
    /// What follows the header.
    pub(super) body: &'a [u8],
    /// The line on which the body begins, counted from 1.
    pub(super) body_line: u32,
}

impl<'a> Header<'a> {
    /// The header of a file. Its first line shows how all its lines end: LF, CRLF or CR.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, ReadError> {
        let end = bytes.iter().position(|b| matches!(b, b'\r' | b'\n')).unwrap_or(bytes.len());
        if bytes[..end].trim_ascii_end() != b"ply" {
            return Err(ReadFault::NoHeader { format: Format::Ply }.anywhere());
        }
        let ends_with_cr = bytes[end..].starts_with(b"\r") && !bytes[end..].starts_with(b"\r\n");
        let line_end = if ends_with_cr { b'\r' } else { b'\n' };
        let mut encoding = None;
        let mut elements: Vec<Element<'a>> = Vec::new();
        // Without its last line the header may run into the numbers: that is the fault to tell.
        let mut fault = None;
        let mut rest = bytes;
        for line in 1u32.. {
            let Some(end) = rest.iter().position(|&b| b == line_end) else {
                if rest.trim_ascii() == b"end_header" {
                    return finish(fault, encoding, elements, &[], line + 1);
                }
                return Err(ReadFault::NoEndHeader.anywhere());
            };
            let (text, after) = (rest[..end].trim_ascii(), &rest[end + 1..]);
            rest = after;
            if text == b"end_header" {
                return finish(fault, encoding, elements, rest, line + 1);
            }
            if fault.is_none()
                && let Err(found) = read_line(text, line == 1, &mut encoding, &mut elements)
            {
                fault = Some(found.at(line));
            }
        }
        Err(ReadFault::NoEndHeader.anywhere())
    }
}

fn finish<'a>(
    fault: Option<ReadError>,
    encoding: Option<Encoding>,
    elements: Vec<Element<'a>>,
    body: &'a [u8],
    body_line: u32,
) -> Result<Header<'a>, ReadError> {
    match (fault, encoding) {
        (Some(error), _) => Err(error),
        (None, Some(encoding)) => Ok(Header { encoding, elements, body, body_line }),
        (None, None) => Err(ReadFault::NoFormatLine.anywhere()),
    }
}

fn read_line<'a>(
    text: &'a [u8],
    is_first: bool,
    encoding: &mut Option<Encoding>,
    elements: &mut Vec<Element<'a>>,
) -> Result<(), ReadFault> {
    let not_understood = || ReadFault::HeaderLine { text: quote(text) };
    let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    match words.next() {
        None | Some(b"comment" | b"obj_info") => {}
        Some(b"ply") if is_first => {}
        Some(b"format") => {
            *encoding = Some(match words.next() {
                Some(b"ascii") => Encoding::Text,
                Some(b"binary_little_endian") => Encoding::LittleEndian,
                Some(b"binary_big_endian") => Encoding::BigEndian,
                _ => return Err(not_understood()),
            });
        }
        Some(b"element") => {
            let name = words.next().ok_or_else(not_understood)?;
            let count = words.next().and_then(whole).ok_or_else(not_understood)?;
            elements.push(Element { name, count, properties: Vec::new() });
        }
        Some(b"property") => {
            let scalar = |word| Scalar::named(word).ok_or_else(not_understood);
            let shape = match words.next() {
                Some(b"list") => Shape::List {
                    count: scalar(words.next().unwrap_or_default())?,
                    entry: scalar(words.next().unwrap_or_default())?,
                },
                word => Shape::One(scalar(word.unwrap_or_default())?),
            };
            let name = words.next().ok_or_else(not_understood)?;
            let element = elements.last_mut().ok_or_else(not_understood)?;
            element.properties.push(Property { name, shape });
        }
        Some(_) => return Err(not_understood()),
    }
    Ok(())
}
