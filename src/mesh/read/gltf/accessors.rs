//! Accessors: arrays of numbers within the bytes of buffers.
//!
//! Guaranteed: [`Accessor::new`] has compared every promise with the bytes that are there, so that reading cannot leave
//! them; one without bytes of its own has no more elements than the file has bytes. Not guaranteed: finite numbers.

use std::collections::BTreeMap;

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{self, Root};

use super::super::ReadError;
use super::GltfFault;
use super::container::Buffers;

/// What an accessor is read for: what its elements have to be.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Use {
    Positions,
    Normals,
    TextureCoordinates,
    Indices,
}

impl Use {
    fn fits(self, kind: Type, component: ComponentType) -> bool {
        use ComponentType::{U8, U16, U32};
        match self {
            Self::Positions | Self::Normals => kind == Type::Vec3 && component != U32,
            Self::TextureCoordinates => kind == Type::Vec2 && component != U32,
            Self::Indices => kind == Type::Scalar && matches!(component, U8 | U16 | U32),
        }
    }

    fn expected(self) -> &'static str {
        match self {
            Self::Positions => "positions should be three floats or short integers each",
            Self::Normals => "normals should be three floats or short integers each",
            Self::TextureCoordinates => {
                "texture coordinates should be two floats or short integers each"
            }
            Self::Indices => "indices should be single unsigned integers",
        }
    }
}

/// An accessor whose bytes are known to be there.
pub(super) struct Accessor<'a> {
    /// Number of elements.
    pub(super) count: usize,
    component: ComponentType,
    is_normalized: bool,
    stride: usize,
    /// From the first element on; `None` for zeros.
    bytes: Option<&'a [u8]>,
    /// Elements that differ: where each lies in its own bytes.
    sparse: Option<(BTreeMap<u32, usize>, &'a [u8])>,
}

impl<'a> Accessor<'a> {
    /// **Takes** the number of bytes of the file: a bound for zeros, which need none.
    pub(super) fn new(
        root: &Root,
        buffers: &'a Buffers,
        index: usize,
        purpose: Use,
        file_bytes: usize,
    ) -> Result<Self, ReadError> {
        let fault = |problem: String| GltfFault::element("accessor", index, problem);
        let accessor = root.accessors.get(index).ok_or_else(|| fault("does not exist".into()))?;
        let (Checked::Valid(component), Checked::Valid(kind)) =
            (accessor.component_type, accessor.type_)
        else {
            return Err(fault("its type is unknown".into()));
        };
        let component = component.0;
        if !purpose.fits(kind, component) {
            return Err(fault(purpose.expected().into()));
        }
        let size = component.size() * kind.multiplicity();
        let stride_of_view = |view: &json::buffer::View| view.byte_stride.map_or(0, |s| s.0);
        let (bytes, stride) = match accessor.buffer_view {
            Some(view) => {
                let bytes = buffers.view(view.value())?;
                let stride = match root.buffer_views.get(view.value()).map_or(0, stride_of_view) {
                    0 => size,
                    stride if stride < size => {
                        let problem = format!("elements of {size} bytes every {stride} bytes");
                        return Err(fault(problem));
                    }
                    stride => stride,
                };
                let offset = accessor.byte_offset.map_or(0, |o| o.0);
                let bytes = within(bytes, offset, accessor.count.0, stride, size).map_err(fault)?;
                (Some(bytes), stride)
            }
            None if accessor.sparse.is_none() => {
                return Err(fault("has no buffer view".into()));
            }
            None => (None, size),
        };
        if bytes.is_none() && accessor.count.0 > file_bytes as u64 {
            return Err(fault(format!("{} elements without bytes", accessor.count.0)));
        }
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        let mut result = Self {
            count,
            component,
            is_normalized: accessor.normalized,
            stride,
            bytes,
            sparse: None,
        };
        if let Some(sparse) = &accessor.sparse {
            result.sparse =
                Some(substitutes(buffers, sparse, size, count).map_err(|error| match error {
                    Problem::Here(problem) => fault(problem),
                    Problem::Elsewhere(error) => error,
                })?);
        }
        Ok(result)
    }

    /// Index `i`.
    ///
    /// **Takes** an accessor made for [`Use::Indices`] and `i < count`.
    pub(super) fn index(&self, i: usize) -> u32 {
        let (bytes, at) = self.element(i);
        match (self.component, bytes.get(at..)) {
            (ComponentType::U8, Some([a, ..])) => u32::from(*a),
            (ComponentType::U16, Some([a, b, ..])) => u32::from(u16::from_le_bytes([*a, *b])),
            (_, Some([a, b, c, d, ..])) => u32::from_le_bytes([*a, *b, *c, *d]),
            _ => 0,
        }
    }

    /// The largest number of the type: it begins a new strip or fan.
    pub(super) fn restart(&self) -> u32 {
        match self.component {
            ComponentType::U8 => 0xff,
            ComponentType::U16 => 0xffff,
            _ => u32::MAX,
        }
    }

    /// The first `N` numbers of element `i`.
    ///
    /// **Takes** `i < count` and no more than the type of the accessor has.
    pub(super) fn vector<const N: usize>(&self, i: usize) -> [f64; N] {
        let (bytes, at) = self.element(i);
        let size = self.component.size();
        let scale = |largest: f64| if self.is_normalized { largest } else { 1.0 };
        let mut vector = [0.0; N];
        for (k, number) in vector.iter_mut().enumerate() {
            let Some(bytes) = bytes.get(at + k * size..) else { continue };
            *number = match (self.component, bytes) {
                (ComponentType::I8, [a, ..]) => f64::from(a.cast_signed()) / scale(127.0),
                (ComponentType::U8, [a, ..]) => f64::from(*a) / scale(255.0),
                (ComponentType::I16, [a, b, ..]) => {
                    f64::from(i16::from_le_bytes([*a, *b])) / scale(32767.0)
                }
                (ComponentType::U16, [a, b, ..]) => {
                    f64::from(u16::from_le_bytes([*a, *b])) / scale(65535.0)
                }
                (ComponentType::F32, [a, b, c, d, ..]) => {
                    f64::from(f32::from_le_bytes([*a, *b, *c, *d]))
                }
                _ => 0.0,
            };
            let is_signed = matches!(self.component, ComponentType::I8 | ComponentType::I16);
            if self.is_normalized && is_signed {
                // The least integer and the one after it are both −1.
                *number = number.max(-1.0);
            }
        }
        vector
    }

    /// Where element `i` begins.
    fn element(&self, i: usize) -> (&[u8], usize) {
        if let Some((places, values)) = &self.sparse
            && let Some(&at) = u32::try_from(i).ok().and_then(|i| places.get(&i))
        {
            return (values, at);
        }
        (self.bytes.unwrap_or_default(), i * self.stride)
    }
}

enum Problem {
    Here(String),
    Elsewhere(ReadError),
}

/// The elements of a sparse accessor that differ, by number, with the bytes that they lie in.
fn substitutes<'a>(
    buffers: &'a Buffers,
    sparse: &json::accessor::sparse::Sparse,
    size: usize,
    count: usize,
) -> Result<(BTreeMap<u32, usize>, &'a [u8]), Problem> {
    let Checked::Valid(component) = sparse.indices.component_type else {
        return Err(Problem::Here("the type of its sparse indices is unknown".into()));
    };
    let component = component.0;
    let view = |index: usize| buffers.view(index).map_err(Problem::Elsewhere);
    let (wanted, width) = (sparse.count.0, component.size());
    // Any number of accessors may share the same sparse elements.
    buffers.spend(wanted).map_err(Problem::Elsewhere)?;
    let indices = view(sparse.indices.buffer_view.value())?;
    let indices = within(indices, sparse.indices.byte_offset.0, wanted, width, width);
    let indices = indices.map_err(Problem::Here)?;
    let values = view(sparse.values.buffer_view.value())?;
    let values = within(values, sparse.values.byte_offset.0, wanted, size, size);
    let values = values.map_err(Problem::Here)?;
    let mut places = BTreeMap::new();
    for (index, k) in indices.chunks_exact(width).zip(0..) {
        let index = index.iter().rev().fold(0, |sum, &b| sum << 8 | u32::from(b));
        if index as usize >= count {
            return Err(Problem::Here(format!("its sparse element {index} is one of {count}")));
        }
        places.insert(index, size * k);
    }
    Ok((places, values))
}

/// The bytes of `count` elements, the last one whole; or what is wrong.
fn within(
    bytes: &[u8],
    offset: u64,
    count: u64,
    stride: usize,
    size: usize,
) -> Result<&[u8], String> {
    let needed = match count {
        0 => Some(0),
        count => (count - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(size as u64)),
    };
    let end = needed.and_then(|n| n.checked_add(offset));
    let range = end.and_then(|end| Some(usize::try_from(offset).ok()?..usize::try_from(end).ok()?));
    range.and_then(|range| bytes.get(range)).ok_or_else(|| {
        let there = bytes.len();
        format!("{count} elements of {size} bytes from byte {offset} of a view of {there} bytes")
    })
}
