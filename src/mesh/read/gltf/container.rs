//! The outside of a glTF file: the chunks of a GLB, the JSON, and the bytes of buffers.
//!
//! Guaranteed: the JSON is parsed with bounded depth and a bounded number of objects, and no buffer is anything but bytes
//! of the file itself. Not guaranteed: that what the JSON says agrees with itself; the other modules check what they use.

use std::borrow::Cow;
use std::cell::{Cell, OnceCell};

use gltf::json::{Buffer, Root};

use super::super::number::{name, quote};
use super::super::{ReadError, ReadFault};
use super::version::told;
use super::{GltfFault, GltfNote, Notes};

/// Objects of JSON that are read. Each takes up to about half a kilobyte, while `{}` in the file takes three bytes: without
/// a limit a few megabytes could ask for gigabytes. Large scenes have some hundred thousand.
const MOST_OBJECTS: usize = 1_000_000;

/// The two parts of a file.
pub(super) struct Parts<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
    /// Whether the JSON is a chunk of a GLB.
    is_chunk: bool,
}

/// Takes a GLB apart; any other file is JSON as a whole.
pub(super) fn split<'a>(bytes: &'a [u8], notes: &mut Notes) -> Result<Parts<'a>, ReadError> {
    if !bytes.starts_with(b"glTF") {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        if json.trim_ascii_start().first() != Some(&b'{') {
            return Err(GltfFault::NotGltf.anywhere());
        }
        return Ok(Parts { json, binary: None, is_chunk: false });
    }
    let Some(&[_, _, _, _, v0, v1, v2, v3, l0, l1, l2, l3]) = bytes.first_chunk::<12>() else {
        let found = bytes.len() as u64;
        let fault = ReadFault::EndsEarly { what: "bytes of the header", found, promised: 12 };
        return Err(fault.anywhere());
    };
    let version = u32::from_le_bytes([v0, v1, v2, v3]);
    if version != 2 {
        return Err(GltfFault::Version { version: version.to_string() }.at_byte(4));
    }
    let promised = u32::from_le_bytes([l0, l1, l2, l3]);
    let Some(bytes_of_container) = usize::try_from(promised).ok().and_then(|l| bytes.get(..l))
    else {
        let (found, promised) = (bytes.len() as u64, u64::from(promised));
        return Err(GltfFault::Length { found, promised }.anywhere());
    };
    notes.add(GltfNote::TrailingBytes, bytes.len() - bytes_of_container.len());
    let mut at = 12;
    let (mut json, mut binary) = (None, None);
    while let Some(head) = bytes_of_container.get(at..).and_then(|rest| rest.first_chunk::<8>()) {
        let &[l0, l1, l2, l3, kind @ ..] = head;
        let length = u32::from_le_bytes([l0, l1, l2, l3]);
        let start = at + 8;
        let end = usize::try_from(length).ok().and_then(|l| start.checked_add(l));
        let Some(chunk) = end.and_then(|end| bytes_of_container.get(start..end)) else {
            let found = (bytes_of_container.len() - start) as u64;
            return Err(GltfFault::Chunk { found, promised: length }.at_byte(at as u64));
        };
        match &kind {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            // Chunks of other kinds are to be passed over.
            _ => {}
        }
        at = start + chunk.len();
    }
    match json {
        Some(json) => Ok(Parts { json, binary, is_chunk: true }),
        None => Err(GltfFault::NoJson.anywhere()),
    }
}

/// Parses the JSON, and refuses what another version or an extension wrote that is not understood.
pub(super) fn parse(parts: &Parts) -> Result<Root, ReadError> {
    let objects = parts.json.iter().filter(|&&b| b == b'{').count();
    if objects > MOST_OBJECTS {
        return Err(GltfFault::TooManyObjects { objects, most: MOST_OBJECTS }.anywhere());
    }
    let root = Root::from_slice(parts.json).map_err(|error| {
        // glTF 1 has other types in the same places; its version must be told, not the first of them.
        if let Some(told) = told(parts.json).filter(|_| error.is_data()) {
            if !told.has_asset {
                return GltfFault::NotGltf.anywhere();
            }
            let version = told.version.map(name).or(told.has_named_nodes.then(|| "1".into()));
            if let Some(version) = version.filter(|v| !is_second(v)) {
                return version_fault(&version);
            }
        }
        let text = name(error.to_string().as_bytes());
        GltfFault::Json { part: if parts.is_chunk { "JSON chunk" } else { "JSON" }, text }
            .anywhere()
    })?;
    let asset = &root.asset;
    if !is_second(&asset.version) {
        return Err(version_fault(&asset.version));
    }
    if let Some(version) = asset.min_version.as_deref().filter(|v| !matches!(*v, "2.0" | "2")) {
        return Err(GltfFault::Version { version: quote(version.as_bytes()) }.anywhere());
    }
    match root.extensions_required.iter().find(|name| !is_harmless(name)) {
        Some(name) => Err(unsupported(name)),
        None => Ok(root),
    }
}

fn is_second(version: &str) -> bool {
    version == "2" || version.starts_with("2.")
}

fn version_fault(version: &str) -> ReadError {
    let version = version.strip_suffix(".0").unwrap_or(version);
    GltfFault::Version { version: quote(version.as_bytes()) }.anywhere()
}

/// Whether a file that requires this extension can be read without regard to it: it changes the look only, or it is
/// understood.
fn is_harmless(extension: &str) -> bool {
    matches!(extension, "KHR_mesh_quantization" | "KHR_xmp" | "KHR_xmp_json_ld")
        || ["_materials_", "_texture_", "_lights_", "_animation_"]
            .iter()
            .any(|w| extension.contains(w))
}

/// The refusal of a file that needs an extension.
pub(super) fn unsupported(extension: &str) -> ReadError {
    ReadFault::Unsupported { feature: quote(extension.as_bytes()) }.anywhere()
}

/// The bytes of all buffers, decoded when they are first asked for, and once only even where that fails.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    binary: Option<&'a [u8]>,
    bytes: Vec<OnceCell<Result<Cow<'a, [u8]>, ReadError>>>,
    /// Sparse elements that may still be read.
    budget: Cell<u64>,
}

impl<'a> Buffers<'a> {
    /// **Takes** the number of sparse elements that may be read in all.
    pub(super) fn new(root: &'a Root, binary: Option<&'a [u8]>, budget: u64) -> Self {
        let bytes = root.buffers.iter().map(|_| OnceCell::new()).collect();
        Self { root, binary, bytes, budget: Cell::new(budget) }
    }

    /// Counts sparse elements that are read.
    pub(super) fn spend(&self, elements: u64) -> Result<(), ReadError> {
        let left = self.budget.get().checked_sub(elements);
        self.budget.set(left.ok_or_else(|| GltfFault::TooManySparse.anywhere())?);
        Ok(())
    }

    /// The bytes of a buffer view.
    ///
    /// **Fails** where the view does not exist, is compressed, or is not wholly within bytes of the file.
    pub(super) fn view(&self, index: usize) -> Result<&[u8], ReadError> {
        let fault = |problem: String| GltfFault::element("buffer view", index, problem);
        let view =
            self.root.buffer_views.get(index).ok_or_else(|| fault("does not exist".into()))?;
        let buffer_index = view.buffer.value();
        let Some(buffer) = self.root.buffers.get(buffer_index) else {
            return Err(fault(format!("buffer {buffer_index} does not exist")));
        };
        let is_stored = buffer.uri.is_some() || buffer_index == 0 && self.binary.is_some();
        if let (false, Some(compression)) = (is_stored, compression(self.root)) {
            return Err(unsupported(compression));
        }
        let bytes = self.bytes[buffer_index].get_or_init(|| self.load(buffer_index, buffer));
        let bytes = bytes.as_ref().map_err(Clone::clone)?;
        let offset = view.byte_offset.map_or(0, |o| o.0);
        let length = view.byte_length.0;
        let range = usize::try_from(offset).ok().zip(offset.checked_add(length));
        let range = range.and_then(|(start, end)| Some(start..usize::try_from(end).ok()?));
        range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            let there = bytes.len();
            fault(format!(
                "{length} bytes from byte {offset} of buffer {buffer_index}, which has {there}"
            ))
        })
    }

    fn load(&self, index: usize, buffer: &'a Buffer) -> Result<Cow<'a, [u8]>, ReadError> {
        let fault = |problem: &str| GltfFault::element("buffer", index, problem.into());
        let bytes = match (&buffer.uri, self.binary) {
            (Some(uri), _) => {
                let Some(data) = uri.strip_prefix("data:") else {
                    return Err(GltfFault::External { buffer: index, uri: quote(uri.as_bytes()) }
                        .anywhere());
                };
                let Some((_, text)) = data.split_once(";base64,") else {
                    return Err(fault("its data URI is not in base64"));
                };
                let bytes = from_base64(text.as_bytes());
                Cow::Owned(bytes.ok_or_else(|| fault("its data URI is not valid base64"))?)
            }
            // The chunk may be longer than the buffer, by what fills it up to a multiple of four.
            (None, Some(bytes)) if index == 0 => Cow::Borrowed(bytes),
            (None, _) => return Err(fault("has neither bytes nor the name of a file")),
        };
        let length = usize::try_from(buffer.byte_length.0).unwrap_or(usize::MAX);
        Ok(match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[..bytes.len().min(length)]),
            Cow::Owned(mut bytes) => {
                bytes.truncate(length);
                Cow::Owned(bytes)
            }
        })
    }
}

/// The extension that may stand in for bytes of buffers that are not there, if any.
fn compression(root: &Root) -> Option<&'static str> {
    ["EXT_meshopt_compression", "KHR_meshopt_compression"].into_iter().find(|name| uses(root, name))
}

/// Whether a file says that it uses an extension.
pub(super) fn uses(root: &Root, extension: &str) -> bool {
    root.extensions_used.iter().any(|used| used == extension)
}

/// Decodes base64 with the standard alphabet, with or without padding; `None` where it is anything else.
fn from_base64(text: &[u8]) -> Option<Vec<u8>> {
    let text = text.strip_suffix(b"==").or_else(|| text.strip_suffix(b"=")).unwrap_or(text);
    let sextet = |b: u8| match b {
        b'A'..=b'Z' => Some(b - b'A'),
        b'a'..=b'z' => Some(b - b'a' + 26),
        b'0'..=b'9' => Some(b - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for four in text.chunks(4) {
        let mut group = 0_u32;
        for &b in four {
            group = group << 6 | u32::from(sextet(b)?);
        }
        group <<= 6 * (4 - four.len());
        let [_, group @ ..] = group.to_be_bytes();
        // One character alone is not even a byte.
        bytes.extend_from_slice(group.get(..four.len() - 1).filter(|g| !g.is_empty())?);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::from_base64;

    #[test]
    fn base64_is_decoded_with_and_without_padding() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zg", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYg==", b"foob"),
            ("+/+/", b"\xfb\xff\xbf"),
        ] {
            assert_eq!(from_base64(text.as_bytes()).as_deref(), Some(bytes), "{text}");
        }
        for text in ["Z", "Zm9vZ", "Zm 9v", "Zm9v-_", "Z===", "ä"] {
            assert_eq!(from_base64(text.as_bytes()), None, "{text}");
        }
    }
}
