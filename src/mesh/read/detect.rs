//! What a file is, by its content.
//!
//! Guaranteed: linear time; a file that begins as its format says is recognised whatever its name. Not guaranteed: that
//! what is recognised can be read, or that a text without any mark is recognised at all.

use super::number::whole;
use super::words::Words;
use super::{Format, ReadError, ReadFault};

/// What certainly is no mesh in one of the known formats, by its first bytes.
const OTHER: [(&[u8], &str); 24] = [
    (b"\xff\xfe", "text in UTF-16"),
    (b"\xfe\xff", "text in UTF-16"),
    (b"Kaydara FBX", "FBX"),
    (b"; FBX", "FBX"),
    (b"ISO-10303-21", "STEP"),
    (b"BLENDER", "a Blender file"),
    (b"3D Geometry File Format", "a Rhino file"),
    (b"#VRML", "VRML"),
    (b"# vtk DataFile", "VTK"),
    (b"$MeshFormat", "a Gmsh file"),
    (b"MeshVersionFormatted", "a Medit file"),
    (b"PK\x03\x04", "a ZIP archive"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"BZh", "a bzip2 archive"),
    (b"\xfd7zXZ", "an XZ archive"),
    (b"7z\xbc\xaf", "a 7-Zip archive"),
    (b"Rar!", "a RAR archive"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard archive or a compressed Blender file"),
    (b"%PDF", "PDF"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"GIF8", "a picture"),
    (b"RIFF", "a picture or sound"),
    (b"version https://git-lfs", "a Git LFS pointer"),
];

/// What content shows.
enum Sign {
    /// One of ours.
    Mesh(Format),
    /// Something else.
    Other(&'static str),
    /// Bytes that are no text.
    Binary,
    /// Text of any kind.
    Text,
}

/// The format that content alone shows, if any.
///
/// **Costs** time linear in `bytes.len()`.
pub fn sniff(bytes: &[u8]) -> Option<Format> {
    match sign(bytes) {
        Sign::Mesh(format) => Some(format),
        _ => None,
    }
}

/// The format to read a file as: content first, then the extension of its name.
pub(super) fn detect(name: &str, bytes: &[u8]) -> Result<Format, ReadError> {
    let looks_like = match (sign(bytes), by_extension(name)) {
        (Sign::Mesh(format), _) => return Ok(format),
        // A binary STL begins with anything, and one that is cut short does not fit its count.
        (Sign::Binary, Some(Format::Stl)) => return Ok(Format::Stl),
        (Sign::Text, Some(format)) => return Ok(format),
        (Sign::Other(name), _) => name,
        (Sign::Binary, _) => "binary data",
        (Sign::Text, None) => "text",
    };
    Err(ReadFault::NotAMesh { looks_like }.anywhere())
}

fn by_extension(name: &str) -> Option<Format> {
    let (_, extension) = name.rsplit_once('.')?;
    let is = |known: &str| extension.trim_ascii_end().eq_ignore_ascii_case(known);
    if is("obj") {
        Some(Format::Obj)
    } else if is("ply") {
        Some(Format::Ply)
    } else if is("stl") {
        Some(Format::Stl)
    } else if is("off") {
        Some(Format::Off)
    } else if is("glb") || is("gltf") {
        Some(Format::Gltf)
    } else {
        None
    }
}

fn sign(bytes: &[u8]) -> Sign {
    // The size of a binary STL fits its count of facets. Its header may begin like any other format; no text fits, because
    // four letters are a count of more than 400 million.
    if let Some(facets) = bytes.get(80..84) {
        let facets = facets.iter().rev().fold(0, |sum, &b| sum << 8 | u64::from(b));
        if bytes.len() as u64 == 84 + 50 * facets {
            return Sign::Mesh(Format::Stl);
        }
    }
    if bytes.starts_with(b"glTF") {
        return Sign::Mesh(Format::Gltf);
    }
    if let [b'p', b'l', b'y', b' ' | b'\t' | b'\r' | b'\n', ..] | b"ply" = bytes {
        return Sign::Mesh(Format::Ply);
    }
    if let Some((_, name)) = OTHER.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        let is_3mf = name.contains("ZIP") && contains(bytes, b"3dmodel.model");
        return Sign::Other(if is_3mf { "3MF" } else { name });
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = bytes.trim_ascii_start();
    if let [b'<', rest @ ..] = text {
        let is = |tag: &[u8]| rest.get(..tag.len()).is_some_and(|s| s.eq_ignore_ascii_case(tag));
        return Sign::Other(if is(b"!doctype html") || is(b"html") { "HTML" } else { "XML" });
    }
    if text.starts_with(b"{") {
        let is_gltf = contains(text, b"\"asset\"");
        return if is_gltf { Sign::Mesh(Format::Gltf) } else { Sign::Other("JSON") };
    }
    let first = Words::new(bytes).next_on_any_line().unwrap_or_default();
    if super::off::is_keyword(first) {
        return Sign::Mesh(Format::Off);
    }
    if first.eq_ignore_ascii_case(b"solid") && text.len() > 6 {
        return Sign::Mesh(Format::Stl);
    }
    // Text has next to no control characters, and no zeros; one byte in ten of random data is one.
    let sample = &bytes[..bytes.len().min(4096)];
    let is_control = |&&b: &&u8| b.is_ascii_control() && !matches!(b, b'\t'..=b'\r' | 0x1a);
    let controls = sample.iter().filter(is_control).count();
    if sample.contains(&0) || 32 * controls > sample.len() {
        return Sign::Binary;
    }
    if has_obj_lines(bytes) {
        return Sign::Mesh(Format::Obj);
    }
    if is_off_without_keyword(bytes) { Sign::Mesh(Format::Off) } else { Sign::Text }
}

fn contains(bytes: &[u8], word: &[u8]) -> bool {
    bytes.windows(word.len()).any(|part| part == word)
}

/// Whether there is a vertex or a face as OBJ writes them.
fn has_obj_lines(bytes: &[u8]) -> bool {
    let mut words = Words::new(bytes);
    while !words.is_at_end() {
        if let Some(b"v" | b"V" | b"f" | b"F") = words.next() {
            let mut is_number = || {
                words.next().is_some_and(|word| {
                    matches!(word[0], b'-' | b'+' | b'.' | b'0'..=b'9')
                        && word.iter().any(u8::is_ascii_digit)
                })
            };
            if is_number() && is_number() && is_number() {
                return true;
            }
        }
        words.skip_line();
    }
    false
}

/// Whether a text begins as OFF does after its keyword: a line of two or three counts, a line of three or more numbers.
fn is_off_without_keyword(bytes: &[u8]) -> bool {
    let mut lines = [const { Vec::new() }; 2];
    let mut words = Words::new(bytes);
    for line in &mut lines {
        let Some(first) = words.next_on_any_line() else { return false };
        line.push(first);
        // A long line is none of these.
        while let Some(word) = words.next()
            && line.len() < 16
        {
            line.push(word);
        }
    }
    let [counts, vertex] = lines;
    let counts = Vec::from_iter(counts.iter().map(|word| whole(word).unwrap_or(0)));
    (2..=3).contains(&counts.len())
        && counts[0] >= 3
        && counts[1] >= 1
        && (3..16).contains(&vertex.len())
        && vertex.iter().all(|word| super::number::parse(word).is_some())
}
