//! ZIP archives of exported files.
//!
//! Guaranteed: equal files give equal bytes (no clock: all are of 1 January 1980, the first day that the format knows); names
//! are UTF-8, name no place outside the folder that one unpacks into, can be made on Windows, and differ also where capitals do not
//! count. Data that gets smaller is deflated, the rest stored. Not written: archives beyond 4 GiB or 65 534 files.

use super::bytes::{FileFault, length_u32};

/// A file to be packed.
#[derive(Clone, Copy, Debug)]
pub struct ZipEntry<'a> {
    /// Its name, with one folder at most before it: `pieces/A.svg`. What cannot stay is replaced, see [`zip_name`].
    pub name: &'a str,
    /// What it holds.
    pub bytes: &'a [u8],
}

/// Version 2.0: deflate and folders; above it the system of the attributes, Unix.
const NEEDED: u16 = 20;
const MADE_BY: u16 = 3 << 8 | NEEDED;
/// Names are UTF-8.
const FLAGS: u16 = 1 << 11;
/// 1 January 1980, midnight.
const TIME_AND_DATE: [u16; 2] = [0, 1 << 5 | 1];
/// A plain file that everybody may read and its owner may write.
const ATTRIBUTES: u32 = 0o100_644 << 16;
const LEVEL: u8 = 6;
/// One less than fits, which says that there is a 64-bit record.
const MOST_FILES: usize = 65_534;

/// Bytes of an archive, files in the given order.
///
/// **Fails** for too many files and too many bytes. Two files of one name keep their order; the second becomes `name-2.ext`.
pub fn zip(entries: &[ZipEntry]) -> Result<Vec<u8>, FileFault> {
    if entries.len() > MOST_FILES {
        return Err(FileFault::TooManyFiles { files: entries.len(), most: MOST_FILES });
    }
    let mut out = Vec::new();
    let mut directory = Vec::new();
    for (name, entry) in names(entries).iter().zip(entries) {
        let offset = length_u32(out.len())?;
        let packed = miniz_oxide::deflate::compress_to_vec(entry.bytes, LEVEL);
        let is_packed = packed.len() < entry.bytes.len();
        let data = if is_packed { &packed } else { entry.bytes };
        let mut common = Vec::new();
        let method = if is_packed { 8 } else { 0 };
        let [time, date] = TIME_AND_DATE;
        push_u16(&mut common, [NEEDED, FLAGS, method, time, date]);
        common.extend(crc32fast::hash(entry.bytes).to_le_bytes());
        common.extend(length_u32(data.len())?.to_le_bytes());
        common.extend(length_u32(entry.bytes.len())?.to_le_bytes());
        push_u16(&mut common, [short(name.len()), 0]);

        out.extend(b"PK\x03\x04");
        out.extend(&common);
        out.extend(name.as_bytes());
        out.extend(data);

        directory.extend(b"PK\x01\x02");
        push_u16(&mut directory, [MADE_BY]);
        directory.extend(&common);
        // No comment, first disk, no statement about text.
        push_u16(&mut directory, [0, 0, 0]);
        directory.extend(ATTRIBUTES.to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = length_u32(out.len())?;
    out.extend(&directory);
    // The end of the directory must lie within the limit as well.
    length_u32(out.len())?;
    out.extend(b"PK\x05\x06");
    let count = short(entries.len());
    push_u16(&mut out, [0, 0, count, count]);
    out.extend(length_u32(directory.len())?.to_le_bytes());
    out.extend(start.to_le_bytes());
    push_u16(&mut out, [0]);
    Ok(out)
}

/// A name that stays in the folder that an archive is unpacked into: one folder at most, no `..`, no drive, no character or
/// device name that Windows forbids, 200 bytes at most; `file` where nothing is left.
pub fn zip_name(name: &str) -> String {
    let parts: Vec<&str> =
        name.split(['/', '\\']).filter(|part| !part.trim_matches(['.', ' ']).is_empty()).collect();
    let tail = parts.len().saturating_sub(2);
    let parts: Vec<String> = parts[tail..].iter().map(|part| one_name(part)).collect();
    if parts.is_empty() { "file".into() } else { parts.join("/") }
}

/// A name of one file or folder.
fn one_name(part: &str) -> String {
    let forbidden = |c: char| c.is_control() || r#"<>:"|?*"#.contains(c);
    let clean: String = part.chars().map(|c| if forbidden(c) { '_' } else { c }).collect();
    // Windows drops points and spaces at the end; a point in front hides a file elsewhere.
    let mut clean = clean.trim().trim_matches(['.', ' ']).to_owned();
    let (stem, extension) = split_name(&clean);
    let is_device = ["con", "prn", "aux", "nul"].contains(&stem.to_lowercase().as_str())
        || ["com", "lpt"].iter().any(|device| {
            let rest = stem.to_lowercase();
            rest.strip_prefix(device)
                .is_some_and(|n| n.len() == 1 && n.as_bytes()[0].is_ascii_digit())
        });
    if is_device {
        clean = format!("{stem}_{extension}");
    }
    if clean.len() > 100 {
        let (stem, extension) = split_name(&clean);
        let extension = if extension.len() > 20 { "" } else { extension };
        let room = 100 - extension.len();
        let end = (0..=room.min(stem.len())).rev().find(|&i| stem.is_char_boundary(i)).unwrap_or(0);
        clean = format!("{}{extension}", stem[..end].trim_end_matches(['.', ' ']));
    }
    if clean.is_empty() { "file".into() } else { clean }
}

/// A name before its first point, and the rest with it.
fn split_name(name: &str) -> (&str, &str) {
    name.split_at(name.find('.').unwrap_or(name.len()))
}

/// Names that differ.
fn names(entries: &[ZipEntry]) -> Vec<String> {
    let mut taken = std::collections::BTreeSet::new();
    // A folder and a file of one name would be in each other's way: folders are taken first.
    let wanted: Vec<String> = entries.iter().map(|entry| zip_name(entry.name)).collect();
    for folder in wanted.iter().filter_map(|name| name.split_once('/')) {
        taken.insert(folder.0.to_lowercase());
    }
    let mut given = Vec::new();
    for name in wanted {
        let (folder, file) = name.rsplit_once('/').map_or(("", name.as_str()), |(a, b)| (a, b));
        let slash = if folder.is_empty() { "" } else { "/" };
        let (stem, extension) = split_name(file);
        let mut candidate = name.clone();
        let mut number = 1;
        while !taken.insert(candidate.to_lowercase()) {
            number += 1;
            candidate = format!("{folder}{slash}{stem}-{number}{extension}");
        }
        given.push(candidate);
    }
    given
}

fn push_u16<const N: usize>(out: &mut Vec<u8>, numbers: [u16; N]) {
    for x in numbers {
        out.extend(x.to_le_bytes());
    }
}

/// A number that was checked to fit.
fn short(x: usize) -> u16 {
    u16::try_from(x).unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn u16_at(bytes: &[u8], at: usize) -> usize {
        usize::from(u16::from_le_bytes(bytes[at..at + 2].try_into().unwrap()))
    }

    fn u32_at(bytes: &[u8], at: usize) -> usize {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
    }

    /// Names and contents as the directory at the end of the archive tells them.
    fn unzip(file: &[u8]) -> Vec<(String, Vec<u8>)> {
        let end = file.len() - 22;
        assert_eq!(file[end..end + 4], *b"PK\x05\x06");
        let mut at = u32_at(file, end + 16);
        assert_eq!(at + u32_at(file, end + 12), end);
        let mut found = Vec::new();
        for _ in 0..u16_at(file, end + 10) {
            assert_eq!(file[at..at + 4], *b"PK\x01\x02");
            let name = file[at + 46..at + 46 + u16_at(file, at + 28)].to_vec();
            let local = u32_at(file, at + 42);
            assert_eq!(file[local..local + 4], *b"PK\x03\x04");
            assert_eq!(file[local + 4..local + 30], file[at + 6..at + 32], "told twice");
            let data = local + 30 + name.len();
            let data = &file[data..data + u32_at(file, at + 20)];
            let data = match u16_at(file, at + 10) {
                0 => data.to_vec(),
                8 => miniz_oxide::inflate::decompress_to_vec(data).unwrap(),
                other => panic!("method {other}"),
            };
            assert_eq!(crc32fast::hash(&data) as usize, u32_at(file, at + 16));
            assert_eq!(data.len(), u32_at(file, at + 24));
            at += 46 + name.len();
            found.push((String::from_utf8(name).unwrap(), data));
        }
        found
    }

    #[test]
    fn files_come_back_under_their_names() {
        let long = b"all the same ".repeat(1000);
        let entries = [
            ZipEntry { name: "Bär.svg", bytes: &long },
            ZipEntry { name: "pieces/A.dxf", bytes: b"x" },
            ZipEntry { name: "empty", bytes: b"" },
        ];
        let file = zip(&entries).unwrap();
        assert!(file.len() < 1000, "deflated: {}", file.len());
        let found = unzip(&file);
        for ((name, bytes), entry) in found.iter().zip(&entries) {
            assert_eq!((name.as_str(), bytes.as_slice()), (entry.name, entry.bytes));
        }
        assert_eq!(found.len(), 3);
        assert_eq!(zip(&entries).unwrap(), file);
        assert_eq!(zip(&[]).unwrap().len(), 22);
    }

    #[test]
    fn no_name_leaves_the_folder() {
        for (name, safe) in [
            ("../../etc/passwd", "etc/passwd"),
            ("/etc/passwd", "etc/passwd"),
            ("a/b/c/d.svg", "c/d.svg"),
            (r"C:\Windows\x.dll", "Windows/x.dll"),
            (r"..\x", "x"),
            ("c:x", "c_x"),
            ("..", "file"),
            ("", "file"),
            ("a/../b.svg", "a/b.svg"),
            (".hidden", "hidden"),
            ("what?.svg", "what_.svg"),
            ("nul.svg", "nul_.svg"),
            ("COM1", "COM1_"),
            ("end. ", "end"),
            ("new\nline", "new_line"),
            ("plüsch bär.svg", "plüsch bär.svg"),
        ] {
            assert_eq!(zip_name(name), safe, "{name}");
            assert_eq!(zip_name(safe), safe, "safe names stay");
        }
        let long = zip_name(&format!("{}.svg", "ä".repeat(300)));
        assert!(long.len() <= 100 && long.ends_with("ä.svg"), "{long}");
    }

    #[test]
    fn names_differ_where_capitals_do_not_count() {
        let entries = ["a.svg", "A.svg", "a-2.svg", "x", "x/y"];
        let entries = entries.map(|name| ZipEntry { name, bytes: b"" });
        let names: Vec<String> = unzip(&zip(&entries).unwrap()).into_iter().map(|f| f.0).collect();
        assert_eq!(names, ["a.svg", "A-2.svg", "a-2-2.svg", "x-2", "x/y"]);
    }
}
