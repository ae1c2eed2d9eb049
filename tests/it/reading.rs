//! Reading OBJ: what loads, what is passed over, what is refused and with which words.
//!
//! The first half makes its own hostile files and always runs; the second reads the collection beside the
//! checkout, and says so where there is none.
#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "tests read files, and may panic"
)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use cutflow::geometry::polygon::triangulate;
use cutflow::mesh::Soup;
use cutflow::mesh::obj::{self, ReadError, ReadFault, ReadNotice, ReadNoticeKind};
use cutflow::session::samples;

/// What a reader makes of a file.
#[derive(Debug, PartialEq)]
enum Outcome {
    /// Vertices, faces, and the texts of the notices.
    Loads(usize, usize, Vec<String>),
    /// The text of the error.
    Refused(String),
}

fn loads(vertices: usize, faces: usize) -> Outcome {
    Outcome::Loads(vertices, faces, Vec::new())
}

fn loads_with(vertices: usize, faces: usize, notice: &str) -> Outcome {
    Outcome::Loads(vertices, faces, vec![notice.to_owned()])
}

fn refused(text: &str) -> Outcome {
    Outcome::Refused(text.to_owned())
}

fn outcome(bytes: &[u8]) -> Outcome {
    match obj::read(bytes) {
        Ok((soup, notices)) => {
            assert_sound(&soup);
            let notices = notices.iter().map(ToString::to_string).collect();
            Outcome::Loads(soup.positions.len(), soup.polygon_count(), notices)
        }
        Err(error) => {
            assert!(!error.fault.advice().is_empty());
            Outcome::Refused(error.to_string())
        }
    }
}

fn read(text: &str) -> (Soup, Vec<ReadNotice>) {
    obj::read(text.as_bytes()).unwrap()
}

/// All that the reader guarantees of a soup.
fn assert_sound(soup: &Soup) {
    assert!(soup.positions.iter().flatten().all(|x| x.abs() <= f64::from(f32::MAX)));
    assert_eq!(soup.starts.first(), Some(&0));
    assert_eq!(soup.starts.last().map(|&end| end as usize), Some(soup.corners.len()));
    assert!(soup.starts.windows(2).all(|pair| pair[1] >= pair[0] + 3));
    assert_eq!(soup.lines.len(), soup.polygon_count());
    assert!(soup.lines.windows(2).all(|pair| pair[0] <= pair[1]));
    assert!(soup.corners.iter().all(|&v| (v as usize) < soup.positions.len()));
    assert!(soup.texture_coordinates.iter().flatten().all(|x| x.is_finite()));
    assert!(soup.texture_corners.is_empty() || soup.texture_corners.len() == soup.corners.len());
    let is_known = |t: u32| t == u32::MAX || (t as usize) < soup.texture_coordinates.len();
    assert!(soup.texture_corners.iter().all(|&t| is_known(t)));
}

/// An icosphere of 42 vertices and 80 faces: vertices on lines 1 to 42, faces on lines 43 to 122.
fn sphere() -> String {
    let soup = samples::icosphere(2);
    let mut text = String::new();
    for [x, y, z] in &soup.positions {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for face in soup.corners.chunks(3) {
        writeln!(text, "f {} {} {}", face[0] + 1, face[1] + 1, face[2] + 1).unwrap();
    }
    text
}

/// `text` with another line `number`, counted from 1.
fn with_line(text: &str, number: usize, line: &str) -> String {
    let mut lines = Vec::from_iter(text.lines());
    lines[number - 1] = line;
    lines.join("\n")
}

/// Three vertices and these lines: faces of them begin on line 4.
fn after_three_vertices(lines: &str) -> String {
    format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{lines}")
}

#[test]
fn files_without_a_mesh_are_refused_by_name() {
    let mut binary_stl = vec![b' '; 80];
    binary_stl.extend(4u32.to_le_bytes());
    binary_stl.extend([b'7'; 200]);
    let noise = Vec::from_iter(noise(1).take(6000));
    let cases: [(&[u8], &str); 22] = [
        (b"", "the file is empty"),
        (b"\n \n", "no vertices, no faces"),
        (b"# nothing\r\n\r\n# here\r\n", "no vertices, no faces"),
        (b"newmtl red\nKd 1 0 0\n", "no vertices, no faces"),
        (b"f 1 2 3\nf 1 3 2\n", "no vertices, 2 faces"),
        (
            b"v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\np 1\n",
            "no faces, only 3 vertices and 2 line or point elements",
        ),
        (b"v 0 0 0\n", "no faces, only 1 vertex"),
        (b"v 0 0 0\nv 1 0 0\nf 1 2", "no faces, only 2 vertices and 1 incomplete face"),
        (b"\n <!DOCTYPE html>\n<pre>\nf 1 2 3\nv 1 2\n", "not an OBJ file (looks like HTML)"),
        (b"<?xml version=\"1.0\"?><COLLADA>", "not an OBJ file (looks like XML)"),
        (b"{\"asset\": {\"version\": \"2.0\"}}", "not an OBJ file (looks like JSON)"),
        (b"ply\nformat ascii 1.0\n", "not an OBJ file (looks like PLY)"),
        (b"OFF\n3 1 0\n0 0 0\n", "not an OBJ file (looks like OFF)"),
        (b"solid thing\n facet normal 0 0 1\n", "not an OBJ file (looks like STL)"),
        (&binary_stl, "not an OBJ file (looks like STL)"),
        (b"glTF\x02\0\0\0", "not an OBJ file (looks like GLB)"),
        (b"PK\x03\x04....", "not an OBJ file (looks like a ZIP archive)"),
        (b"\x1f\x8b\x08....", "not an OBJ file (looks like a gzip archive)"),
        (b"\xff\xfev\0 \x000\0", "not an OBJ file (looks like text in UTF-16)"),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "not an OBJ file (looks like a Git LFS pointer)",
        ),
        (b"v 0 0 0\0\0\0\0", "not an OBJ file (looks like binary data)"),
        (&noise, "not an OBJ file (looks like binary data)"),
    ];
    for (bytes, text) in cases {
        assert_eq!(
            outcome(bytes),
            refused(text),
            "{}",
            String::from_utf8_lossy(&bytes[..bytes.len().min(40)])
        );
    }
}

#[test]
fn coordinates_that_are_no_finite_numbers_are_refused_with_their_line() {
    let cases = [
        ("v -0,525731 0,850651 0,000000", "-0,525731 is not a number (decimal comma?)"),
        ("v 0, 1, 2", "0, is not a number (decimal comma?)"),
        ("v 1 2 x", "x is not a number"),
        ("v 1 2 1d5", "1d5 is not a number"),
        ("v 1 2 \u{1b}[31m", "\u{fffd}[31m is not a number"),
        ("v", "vertex with 0 of 3 coordinates"),
        ("v 1 2", "vertex with 2 of 3 coordinates"),
        ("v 1 # 2 3", "vertex with 1 of 3 coordinates"),
        ("v nan 0.1 0.2", "coordinate nan is not a finite number"),
        ("v 0 -nan 0.2", "coordinate -nan is not a finite number"),
        ("v 0 0 -Infinity", "coordinate -Infinity is not a finite number"),
        ("v 0 0 -1.#IND", "coordinate -1.#IND is not a finite number"),
        ("v 1e400 0 0", "coordinate 1e400 is not a finite number"),
        ("v 0 -1e39 0", "coordinate -1e39 is too large (more than 3.4e38)"),
    ];
    for (line, text) in cases {
        let file = with_line(&sphere(), 11, line);
        assert_eq!(outcome(file.as_bytes()), refused(&format!("line 11: {text}")));
    }
}

#[test]
fn a_long_word_is_quoted_in_part() {
    let file = format!("v {} 0 0\n", "x".repeat(100_000));
    let error = obj::read(file.as_bytes()).unwrap_err();
    assert_eq!(error.fault, ReadFault::NotANumber { text: "x".repeat(40) + "…" });
}

#[test]
fn coordinates_are_read_as_the_nearest_number() {
    let (soup, _) = read(
        "v 0.1 -.5 5.\nv +1e-3 1E2 -0\nv 0.30000000000000004 123456789.123456789 1e-400\nf 1 2 3",
    );
    let expected = [[0.1, -0.5, 5.0], [1e-3, 100.0, 0.0], [0.1 + 0.2, 123_456_789.123_456_79, 0.0]];
    assert_eq!(soup.positions, expected);
    let many_digits = format!("v 0.{}1 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3", "0".repeat(1_000_000));
    assert_eq!(outcome(many_digits.as_bytes()), loads(3, 1));
}

#[test]
fn vertices_out_of_range_are_refused_with_line_and_count() {
    let cases = [
        ("f 1 999 3", "vertex 999 of 42"),
        ("f 1 43 3", "vertex 43 of 42"),
        ("f 0 2 3", "vertex 0 of 42"),
        ("f -0 2 3", "vertex -0 of 42"),
        ("f 1 2 -43", "vertex -43 of 42"),
        ("f 1 2 4294967295", "vertex 4294967295 of 42"),
        ("f 1 2 4294967296", "vertex 4294967296 of 42"),
        ("f 1 2 99999999999999999999", "vertex 99999999999999999999 of 42"),
        ("f 1 2 -99999999999999999999", "vertex -99999999999999999999 of 42"),
        ("f a b c", "a is not a face corner"),
        ("f 1.0 2.0 3.0", "1.0 is not a face corner"),
        ("f 1/x 2 3", "1/x is not a face corner"),
        ("f /1 /2 /3", "/1 is not a face corner"),
        ("f 1 2 -", "- is not a face corner"),
    ];
    for (line, text) in cases {
        let file = with_line(&sphere(), 51, line);
        assert_eq!(outcome(file.as_bytes()), refused(&format!("line 51: {text}")));
    }
}

#[test]
fn of_several_bad_indices_the_first_in_the_file_is_named() {
    let file = with_line(&sphere(), 60, "f 0 1 2");
    let file = with_line(&file, 70, "f 1 2 77777777777777");
    assert_eq!(outcome(file.as_bytes()), refused("line 60: vertex 0 of 42"));
    let file = with_line(&file, 55, "f 1 2 43");
    assert_eq!(outcome(file.as_bytes()), refused("line 55: vertex 43 of 42"));
    // An incomplete face is left out before its indices matter.
    let file = with_line(&sphere(), 60, "f 0 1");
    assert_eq!(
        outcome(file.as_bytes()),
        loads_with(42, 79, "line 60: face with 2 corners ignored")
    );
}

#[test]
fn relative_indices_count_backwards_from_where_they_stand() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nf -3/-2 -2/-1 -1/1\n\
                v 5 0 0\nv 6 0 0\nv 5 1 0\nvt .5 .5\nf -3/-1 -2/-1 -1/-1\n";
    let (soup, notices) = read(text);
    assert!(notices.is_empty());
    assert_eq!(soup.corners, [0, 1, 2, 3, 4, 5]);
    assert_eq!(soup.texture_corners, [0, 1, 0, 2, 2, 2]);
    assert_eq!(soup.lines, [6, 11]);
    // Relative indices cannot reach forward, absolute ones can.
    assert_eq!(
        outcome(b"v 0 0 0\nf -1 -2 -3\nv 1 0 0\nv 0 1 0\n"),
        refused("line 2: vertex -2 of 1")
    );
    assert_eq!(outcome(b"f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"), loads(3, 1));
}

#[test]
fn corner_forms_may_be_mixed_and_texture_is_kept_by_corner() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0.5\nvt 0.25\nvn 0 0 1\n\
                f 1 2 3\nf 1/1 3/3 4/2\nf 2//1 3//1 4//1\nf 1/3/1 2 3/2/ 4/ \n";
    let (soup, notices) = read(text);
    assert!(notices.is_empty());
    const NO: u32 = u32::MAX;
    assert_eq!(soup.texture_coordinates, [[0.0, 0.0], [1.0, 0.0], [0.25, 0.0]]);
    assert_eq!(soup.texture_corners, [NO, NO, NO, 0, 2, 1, NO, NO, NO, 2, NO, 1, NO]);
    assert_eq!(soup.polygon(3), [0, 1, 2, 3]);
}

#[test]
fn texture_coordinates_out_of_range_are_passed_over() {
    let text = after_three_vertices("vt 0 0\nf 1/1 2/77/88 3/1\nf 1/-2 2/0 3/1\n");
    let (soup, notices) = read(&text);
    const NO: u32 = u32::MAX;
    assert_eq!(soup.texture_corners, [0, NO, 0, NO, NO, 0]);
    let kind = ReadNoticeKind::TextureOutOfRange { index: "77".into(), texture_coordinates: 1 };
    assert_eq!(notices, [ReadNotice { kind, count: 3, first_line: 5 }]);
    assert_eq!(notices[0].to_string(), "line 5: vt 77 of 1, ignored (and 2 more)");

    let (soup, notices) = read(&after_three_vertices("f 1/1 2/1 3/-1\n"));
    assert!(soup.texture_corners.is_empty(), "no vt line, no texture");
    assert_eq!(notices[0].to_string(), "line 4: vt 1 of 0, ignored (and 2 more)");

    let (soup, notices) = read(&after_three_vertices("vt nan 0\nvt 1 1\nvt\nf 1/1 2/2 3/3\n"));
    assert_eq!(soup.texture_corners, [NO, 1, NO]);
    assert_eq!(notices[0].to_string(), "line 4: vt is not a number, ignored (and 1 more)");
}

#[test]
fn a_last_line_cut_short_is_passed_over() {
    let whole = sphere();
    let last = whole.trim_end().rfind(' ').unwrap();
    assert_eq!(
        outcome(&whole.as_bytes()[..last]),
        loads_with(42, 79, "line 122: face with 2 corners ignored")
    );
    for end in 0..whole.len() {
        // Refused or loaded, but never a panic.
        outcome(&whole.as_bytes()[..end]);
    }
}

#[test]
fn all_forms_of_the_text_give_the_same_mesh() {
    let plain = sphere();
    let (expected, _) = read(&plain);
    let long_blank = " ".repeat(100_000);
    let variants = [
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.trim_end().to_owned(),
        format!("\u{feff}{plain}"),
        plain.replace(' ', "\t"),
        plain.replace("\nf", "\n \t f"),
        plain.replace("\nf ", "\nF ").replace("\nv ", "\nV "),
        plain.replace('\n', " # comment 1 2 3\n"),
        plain.replace('\n', " \n"),
        plain.replacen("\nf ", &format!("\nf {long_blank}"), 1),
    ];
    for text in variants {
        let (soup, notices) = read(&text);
        assert_eq!((soup, notices), (expected.clone(), Vec::new()), "{:.60}", text);
    }
    // These have more lines, so that only the line numbers differ.
    let variants = [
        plain.replace("\nf ", "\nf \\\n"),
        plain.replace("\nf ", "\nf\\\r\n"),
        plain.replace('\n', "\n\n"),
        format!("# Übung 形状 \\\n# {}\no Körper Ä\n{plain}", "x".repeat(100_000)),
        format!(
            "mtllib C:\\my files\\\nusemtl\ns off\ng a b\ncstype bezier\nvp 1 2\n{plain}l 1 2\np 1\n"
        ),
        // A latin-1 name is no UTF-8.
        format!("call me\ncurv2 1 2 \\\n 3 4\n{plain}end\n\u{1a}"),
    ];
    for text in variants {
        let (mut soup, notices) = read(&text);
        assert!(soup.lines.iter().zip(&expected.lines).all(|(a, b)| a >= b));
        soup.lines.clone_from(&expected.lines);
        assert_eq!((soup, notices), (expected.clone(), Vec::new()), "{:.60}", text);
    }
    let mut latin1 = b"o K\xf6rper\n".to_vec();
    latin1.extend(plain.bytes());
    assert_eq!(outcome(&latin1), loads(42, 80));
}

#[test]
fn a_weight_or_a_colour_after_the_coordinates_is_ignored() {
    let text = sphere().replace("\nv ", " 1.0\nv ").replacen(
        "v 0",
        "v 0.25 0.5 0.75 0.2 0.4 0.9 \\\n1 #",
        1,
    );
    assert_eq!(outcome(text.as_bytes()), loads(42, 80));
}

#[test]
fn a_polygon_may_have_any_number_of_corners() {
    let mut text = String::new();
    let mut face = String::from("f");
    for i in 0..100_000 {
        writeln!(text, "v {} {} 0", f64::from(i).sin(), f64::from(i).cos()).unwrap();
        write!(face, " {}", i + 1).unwrap();
    }
    let (soup, _) = read(&(text + &face));
    assert_eq!((soup.polygon_count(), soup.polygon(0).len()), (1, 100_000));
}

#[test]
fn no_bytes_make_the_reader_panic() {
    let words: [&[u8]; 24] = [
        b"v ",
        b"vt ",
        b"vn ",
        b"f ",
        b"f",
        b"l ",
        b"0",
        b"1",
        b"-1",
        b"2/3",
        b"//",
        b"/",
        b"1e9",
        b"nan",
        b" ",
        b"\t",
        b"\n",
        b"\n",
        b"\r",
        b"\\",
        b"#",
        b"\xff",
        b"\n",
        b"f 1 2 3\nv 1 2 3\n",
    ];
    let mut noise = noise(7);
    for _ in 0..20_000 {
        let mut text = Vec::new();
        for _ in 0..noise.next().unwrap_or(0) % 64 {
            text.extend(words[usize::from(noise.next().unwrap_or(0)) % words.len()]);
        }
        outcome(&text);
    }
    let sphere = sphere().into_bytes();
    for _ in 0..2_000 {
        let mut text = sphere.clone();
        for _ in 0..1 + noise.next().unwrap_or(0) % 8 {
            let pick = noise.by_ref().take(2).fold(0, |sum, b| sum << 8 | usize::from(b));
            text[pick % sphere.len()] = noise.next().unwrap_or(0);
        }
        outcome(&text);
    }
}

/// Bytes of a small generator: the same ones each time.
fn noise(seed: u64) -> impl Iterator<Item = u8> {
    let mut state = seed;
    std::iter::repeat_with(move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state.to_be_bytes()[0]
    })
}

// The collection beside the checkout.

/// A folder beside the checkout, or nothing, said aloud.
fn shared(folder: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared").join(folder);
    if !path.is_dir() {
        eprintln!("SKIPPED: there is no {}", path.display());
        return None;
    }
    Some(path)
}

fn obj_files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")) {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            files.insert(name, std::fs::read(&path).unwrap());
        }
    }
    files
}

#[test]
fn each_hostile_file_has_its_expected_outcome() {
    let Some(folder) = shared("meshes/bad") else { return };
    let mut expected = BTreeMap::from([
        ("empty.obj", refused("the file is empty")),
        ("comments-only.obj", refused("no vertices, no faces")),
        ("html.obj", refused("not an OBJ file (looks like HTML)")),
        ("random-bytes.obj", refused("not an OBJ file (looks like binary data)")),
        ("truncated.obj", loads_with(162, 200, "line 363: face with 1 corner ignored")),
        ("nan-coord.obj", refused("line 11: coordinate nan is not a finite number")),
        ("overflow-coord.obj", refused("line 21: coordinate 1e400 is not a finite number")),
        ("comma-decimal.obj", refused("line 1: -0,525731 is not a number (decimal comma?)")),
        ("huge-offset.obj", loads(162, 320)),
        ("tiny-scale.obj", loads(162, 320)),
        ("anisotropic.obj", loads(162, 320)),
        ("all-same-point.obj", loads(12, 20)),
        ("all-collinear.obj", loads(64, 98)),
        ("index-out-of-range.obj", refused("line 51: vertex 999 of 42")),
        ("negative-indices.obj", loads(54, 83)),
        ("mixed-refs.obj", loads_with(6, 4, "line 14: vt 77 of 3, ignored")),
        ("nonmanifold-edge.obj", loads(5, 3)),
        ("fin-on-sphere.obj", loads(43, 81)),
        ("bowtie-vertex.obj", loads(5, 2)),
        ("two-tetra-one-vertex.obj", loads(7, 8)),
        ("touching-holes.obj", loads(81, 124)),
        ("flipped-faces.obj", loads(162, 320)),
        ("inside-out.obj", loads(162, 320)),
        ("moebius.obj", loads(200, 320)),
        ("klein-bottle.obj", loads(512, 1024)),
        ("duplicate-faces.obj", loads(162, 360)),
        ("degenerate-faces.obj", loads(44, 84)),
        ("isolated-vertices.obj", loads(77, 80)),
        ("components.obj", loads(548, 1053)),
        ("triangle-dust.obj", loads(1200, 400)),
        ("single-triangle.obj", loads(3, 1)),
        ("two-spheres-crossing.obj", loads(324, 640)),
        ("polygon-200.obj", loads(400, 202)),
        ("concave-ngons.obj", loads(110, 4)),
        ("nonplanar-ngons.obj", loads(16, 2)),
        ("crlf.obj", loads(42, 80)),
        ("cr-only.obj", loads(42, 80)),
        ("bom-tabs-unicode.obj", loads(42, 80)),
        ("long-line.obj", loads(42, 80)),
        ("continuation-colours.obj", loads(42, 80)),
        ("lines-only.obj", refused("no faces, only 3 vertices and 2 line or point elements")),
        ("UPPER.OBJ", loads(42, 80)),
    ]);
    for (name, bytes) in obj_files(&folder) {
        let expected =
            expected.remove(&*name).unwrap_or_else(|| panic!("{name} is not in the table"));
        assert_eq!(outcome(&bytes), expected, "{name}");
    }
    assert!(expected.is_empty(), "not in the folder: {expected:?}");
}

#[test]
fn meshes_in_other_formats_are_named() {
    let Some(folder) = shared("meshes") else { return };
    for (name, looks_like) in [
        ("koala.stl", "STL"),
        ("nefertiti.ply", "PLY"),
        ("fertility.off", "OFF"),
        ("milk-truck.glb", "GLB"),
        ("bad/ascii-two-solids.stl", "STL"),
        ("bad/solid-binary.stl", "STL"),
        ("bad/random-bytes.stl", "binary data"),
        ("bad/variants.off", "OFF"),
    ] {
        let error = obj::read(&std::fs::read(folder.join(name)).unwrap()).unwrap_err();
        let expected = ReadError { line: None, fault: ReadFault::NotObj { looks_like } };
        assert_eq!(error, expected, "{name}");
    }
}

#[test]
fn the_good_meshes_load_with_their_counts() {
    let Some(folder) = shared("meshes") else { return };
    let files = obj_files(&folder);
    for (name, vertices, faces) in [
        ("spot.obj", 2930, 5856),
        ("spot-control.obj", 188, 180),
        ("stanford-bunny.obj", 35947, 69451),
        ("bunny-closed.obj", 14290, 28576),
        ("face.obj", 17157, 34144),
        ("beetle.obj", 30024, 58738),
        ("hood.obj", 3998, 7660),
        ("hand.obj", 7993, 15982),
        ("armadillo.obj", 14587, 29170),
        ("homer.obj", 6002, 12000),
        ("cheburashka.obj", 6669, 13334),
        ("fandisk.obj", 6475, 12946),
        ("rocker-arm.obj", 10044, 20088),
        ("torus.obj", 4608, 9216),
        ("double-torus.obj", 5644, 11292),
        ("chair.obj", 7020, 14044),
    ] {
        assert_eq!(outcome(&files[name]), loads(vertices, faces), "{name}");
    }
    let (spot, _) = obj::read(&files["spot.obj"]).unwrap();
    assert_eq!(spot.texture_coordinates.len(), 3225);
    assert!(spot.texture_corners.iter().all(|&t| t != u32::MAX));
}

/// All triangles of a soup, face by face.
fn triangles_of_faces(soup: &Soup) -> Vec<Vec<[u32; 3]>> {
    let triangles = |i| {
        let mut out = Vec::new();
        triangulate(&soup.positions, soup.polygon(i), &mut out);
        out
    };
    (0..soup.polygon_count()).map(triangles).collect()
}

fn signed_area_xy(soup: &Soup, triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| soup.positions[v as usize]);
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
}

#[test]
fn polygons_of_files_become_all_their_triangles() {
    let Some(folder) = shared("meshes") else { return };
    for (name, triangles) in [
        ("spot-control.obj", 372),
        ("bad/polygon-200.obj", 796),
        ("bad/concave-ngons.obj", 102),
        ("bad/nonplanar-ngons.obj", 12),
    ] {
        let (soup, _) = obj::read(&std::fs::read(folder.join(name)).unwrap()).unwrap();
        let faces = triangles_of_faces(&soup);
        assert_eq!(faces.iter().map(Vec::len).sum::<usize>(), triangles, "{name}");
        for (i, face) in faces.iter().enumerate() {
            let mut used = face.concat();
            let mut corners = soup.polygon(i).to_vec();
            used.sort_unstable();
            used.dedup();
            corners.sort_unstable();
            assert_eq!(used, corners, "{name}: each corner of face {i} is used");
        }
    }
}

#[test]
fn concave_polygons_of_a_file_have_their_exact_areas() {
    let Some(folder) = shared("meshes/bad") else { return };
    let (soup, _) = obj::read(&std::fs::read(folder.join("concave-ngons.obj")).unwrap()).unwrap();
    // The areas in the head of the file, to their six digits.
    for (face, expected) in triangles_of_faces(&soup).iter().zip([0.759297, 5.11, 1.231161, 1.2]) {
        let areas = Vec::from_iter(face.iter().map(|&t| signed_area_xy(&soup, t)));
        assert!(areas.iter().all(|&area| area > 0.0), "no triangle is turned over: {areas:?}");
        assert!(
            (areas.iter().sum::<f64>() - expected).abs() < 1e-6,
            "{}",
            areas.iter().sum::<f64>()
        );
    }
}
