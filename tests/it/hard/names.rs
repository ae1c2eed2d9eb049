//! Names that want to be more than names: in files they are text, and nothing else; on disk they stay in their folder.

use cutflow::session::{Command, File, Session, Value};

use super::documents;
use super::sound::KINDS;

/// Names that have broken programs.
const NAMES: [&str; 9] = [
    "../../etc/passwd",
    "..\\..\\x",
    "<script>alert(1)</script>",
    "\" onload=\"x()",
    "]]><svg onload=x()>&amp;&#0;",
    "a\r\n0\r\nEOF\r\nf 1 2 3",
    "\u{202e}gpj.exe\u{2066}",
    "(\\) Tj ET Q BT",
    "con",
];

/// A tetrahedron whose object, groups and material have this name; line breaks end a line of an OBJ, so they are left out there.
fn named(name: &str) -> Vec<u8> {
    let line = name.replace(['\r', '\n'], " ");
    let text = String::from_utf8(documents::tetrahedron().obj()).unwrap();
    let text = text.replacen("f ", &format!("o {line}\ng {line}\nusemtl {line}\nf "), 1);
    text.into_bytes()
}

/// All files of a session with a mesh of this name.
fn files(name: &str) -> Vec<(&'static str, File)> {
    let mut session = Session::new();
    session.open(&format!("{name}.obj"), &named(name));
    assert!(session.document().is_some(), "{name:?}");
    session.handle(Command::Step);
    for id in ["piece_labels", "seam_labels", "marks"] {
        session.handle(Command::SetParameter { id: id.into(), value: Value::Truth(true) });
    }
    KINDS.into_iter().filter_map(|kind| Some((kind, session.export(kind).ok()?))).collect()
}

/// Whether tags of an XML text open and close in order, and its text has nothing that begins a tag.
fn is_well_formed(xml: &str) -> Result<(), String> {
    let mut open = Vec::new();
    let mut rest = xml;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').ok_or("a tag without an end")?;
        let tag = &rest[..end];
        if tag.contains('<') {
            return Err(format!("a tag within a tag: {tag}"));
        }
        rest = &rest[end + 1..];
        if tag.starts_with(['?', '!']) || tag.ends_with('/') {
            continue;
        }
        let name = |tag: &str| tag.split_whitespace().next().unwrap_or_default().to_owned();
        match tag.strip_prefix('/') {
            Some(closed) if open.pop() == Some(name(closed)) => {}
            Some(closed) => return Err(format!("{closed} closes what is not open")),
            None => open.push(name(tag)),
        }
    }
    if open.is_empty() { Ok(()) } else { Err(format!("{open:?} stay open")) }
}

/// The names of the files in an archive.
fn archived(zip: &[u8]) -> Vec<String> {
    let mut names = Vec::new();
    let mut at = 0;
    while zip[at..].starts_with(b"PK\x03\x04") {
        let word = |i: usize| usize::from(u16::from_le_bytes([zip[at + i], zip[at + i + 1]]));
        let size = u32::from_le_bytes([zip[at + 18], zip[at + 19], zip[at + 20], zip[at + 21]]);
        let (length, extra) = (word(26), word(28));
        names.push(String::from_utf8(zip[at + 30..at + 30 + length].to_vec()).unwrap());
        at += 30 + length + extra + size as usize;
    }
    names
}

#[test]
fn names_that_want_to_be_more_are_text_in_every_file() {
    for name in NAMES {
        let files = files(name);
        assert!(files.len() >= 10, "{name:?}: {}", files.len());
        for (kind, file) in &files {
            super::sound::check_file(kind, file).unwrap();
            assert!(file.name.len() <= 120, "{name:?}: {}", file.name);
            let is_plain = |c: char| c.is_alphanumeric() || "-_. ".contains(c);
            assert!(file.name.chars().all(is_plain), "{name:?}: {}", file.name);
            assert!(!file.name.starts_with('.') && !file.name.contains(".."), "{}", file.name);
            match *kind {
                "Pattern (SVG)" => {
                    let text = std::str::from_utf8(&file.bytes).unwrap();
                    is_well_formed(text).unwrap_or_else(|what| panic!("{name:?}: {what}"));
                    let is_allowed = |c: char| !c.is_control() || c == '\n';
                    assert!(text.chars().all(is_allowed), "{name:?}");
                    assert!(!text.contains(BIDI), "{name:?}: text that runs the other way");
                    for word in ["<script", "onload=x()>", "&#0;"] {
                        assert!(!text.contains(word), "{name:?}: {word}");
                    }
                }
                "Pattern (DXF)" => {
                    let text = std::str::from_utf8(&file.bytes).unwrap();
                    // Pairs of lines, a code and a value, one end.
                    let lines: Vec<&str> = text.lines().collect();
                    assert_eq!(lines.len() % 2, 0, "{name:?}");
                    let codes = lines.iter().step_by(2).map(|code| code.trim().parse::<u16>());
                    assert!(codes.into_iter().all(|code| code.is_ok()), "{name:?}");
                    assert_eq!(lines.iter().filter(|line| **line == "EOF").count(), 1, "{name:?}");
                }
                "UV mesh (OBJ)" | "Mesh (OBJ)" | "Flat mesh (OBJ)" => {
                    let text = std::str::from_utf8(&file.bytes).unwrap();
                    let faces = text.lines().filter(|line| line.starts_with("f ")).count();
                    assert!(faces >= 4, "{name:?}");
                    let known = ["v", "vt", "vn", "f", "o", "g", "usemtl", "mtllib", "s", "#", ""];
                    let key = |line: &str| line.split(' ').next().unwrap_or_default().to_owned();
                    let odd = text.lines().find(|line| !known.contains(&key(line).as_str()));
                    assert_eq!(odd, None, "{name:?}, {kind}");
                }
                "All files (ZIP)" => {
                    let names = archived(&file.bytes);
                    assert!(names.len() >= 8, "{names:?}");
                    for name in names {
                        let parts: Vec<&str> = name.split('/').collect();
                        let is_inside = |part: &&str| {
                            !part.is_empty()
                                && !part.starts_with('.')
                                && !part.contains(['\\', ':'])
                        };
                        assert!(parts.len() <= 2 && parts.iter().all(is_inside), "{name}");
                        assert!(!name.contains(char::is_control) && name.len() <= 201, "{name}");
                    }
                }
                _ => {}
            }
        }
    }
}

/// Characters that turn the direction of text.
const BIDI: [char; 9] = [
    '\u{202a}', '\u{202b}', '\u{202c}', '\u{202d}', '\u{202e}', '\u{2066}', '\u{2067}', '\u{2068}',
    '\u{2069}',
];

#[test]
fn a_name_of_ten_thousand_letters_is_cut_where_it_is_written_and_told() {
    let name = "n".repeat(10_000);
    for (kind, file) in files(&name) {
        super::sound::check_file(kind, &file).unwrap();
        assert!(file.name.len() <= 120, "{kind}: {} bytes", file.name.len());
    }
    let mut session = Session::new();
    let events = session.open(&format!("{name}.obj"), b"f 1 2 3\n");
    let told = events.iter().find_map(|event| match event {
        cutflow::session::Event::Error { place, .. } => Some(place.clone()),
        _ => None,
    });
    let told = told.unwrap();
    assert!(told.len() < 400, "{} bytes", told.len());
}

#[test]
fn a_file_is_called_by_a_name_that_can_be_shown() {
    for name in NAMES {
        let mut session = Session::new();
        session.open(&format!("{name}.obj"), &named(name));
        let shown = &session.document().unwrap().name;
        assert!(!shown.is_empty() && !shown.contains(char::is_control), "{shown:?}");
        assert!(!shown.contains(BIDI), "{shown:?}");
    }
}
