//! Reading PLY: all forms of the same sphere, strips, attributes, and headers that lie.

use std::fmt::Write as _;

use cutflow::mesh::Soup;
use cutflow::mesh::read::{Place, ReadFault, ply};
use cutflow::session::samples;

use super::reading::{Outcome, loads, loads_with, memory, refused};

fn outcome(bytes: &[u8]) -> Outcome {
    super::reading::outcome("test.ply", bytes)
}

fn read(bytes: &[u8]) -> Soup {
    let content = ply::read(bytes).unwrap();
    assert!(content.notices.is_empty(), "{:?}", content.notices);
    content.soup
}

/// A text file with this header after the first two lines, and this body.
fn text(header: &str, body: &str) -> Vec<u8> {
    format!("ply\nformat ascii 1.0\n{header}\nend_header\n{body}").into_bytes()
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const LIST: &str = "property list uchar int vertex_indices";

/// A text file of three vertices and these faces.
fn three_vertices(faces: usize, body: &str) -> Vec<u8> {
    text(
        &format!("element vertex 3\n{XYZ}element face {faces}\n{LIST}"),
        &format!("0 0 0\n1 0 0\n0 1 0\n{body}"),
    )
}

/// Numbers as bytes of one order.
struct Bytes {
    out: Vec<u8>,
    is_big: bool,
}

impl Bytes {
    fn put<const N: usize>(&mut self, mut little_endian: [u8; N]) {
        if self.is_big {
            little_endian.reverse();
        }
        self.out.extend(little_endian);
    }
}

/// An icosphere of 42 vertices and 80 faces in the common binary form.
fn sphere(is_big: bool) -> Vec<u8> {
    let soup = samples::icosphere(2);
    let order = if is_big { "big" } else { "little" };
    let header = format!(
        "ply\nformat binary_{order}_endian 1.0\ncomment a ball\nelement vertex 42\n{XYZ}element face 80\n{LIST}\nend_header\n"
    );
    let mut bytes = Bytes { out: header.into_bytes(), is_big };
    for x in soup.positions.iter().flatten() {
        bytes.put((*x as f32).to_le_bytes());
    }
    for face in soup.corners.chunks(3) {
        bytes.put([3]);
        for &v in face {
            bytes.put((v as i32).to_le_bytes());
        }
    }
    bytes.out
}

/// The same sphere with everything in unusual places and types.
fn odd_sphere(is_big: bool) -> Vec<u8> {
    let soup = samples::icosphere(2);
    let order = if is_big { "big" } else { "little" };
    let header = format!(
        "ply\nformat binary_{order}_endian 1.0\nobj_info cols 1\nelement camera 1\nproperty list ushort double \
         params\nproperty short id\nelement nothing 4000000000\nelement vertex 42\nproperty uint8 quality\nproperty \
         double z\nproperty float32 nx\nproperty float64 x\nproperty double y\nproperty list uchar ushort \
         tags\nelement face 80\nproperty int16 group\nproperty list uint32 ushort vertex_index\nproperty float \
         area\nelement edge 2\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    );
    let mut bytes = Bytes { out: header.into_bytes(), is_big };
    bytes.put(2u16.to_le_bytes());
    bytes.put(1.0f64.to_le_bytes());
    bytes.put(2.0f64.to_le_bytes());
    bytes.put(7i16.to_le_bytes());
    for (i, [x, y, z]) in soup.positions.iter().enumerate() {
        bytes.put([9]);
        bytes.put(z.to_le_bytes());
        bytes.put(f32::NAN.to_le_bytes());
        bytes.put(x.to_le_bytes());
        bytes.put(y.to_le_bytes());
        bytes.put([(i % 3) as u8]);
        for _ in 0..i % 3 {
            bytes.put(5u16.to_le_bytes());
        }
    }
    for face in soup.corners.chunks(3) {
        bytes.put(3i16.to_le_bytes());
        bytes.put(3u32.to_le_bytes());
        for &v in face {
            bytes.put((v as u16).to_le_bytes());
        }
        bytes.put(0.5f32.to_le_bytes());
    }
    // The edges are cut short, and of no concern.
    bytes.put(1i32.to_le_bytes());
    bytes.out
}

/// The same sphere as text, with blanks and line ends as given.
fn text_sphere(number_end: &str, line_end: &str) -> Vec<u8> {
    let soup = samples::icosphere(2);
    let mut body = String::new();
    for x in soup.positions.iter().flatten() {
        write!(body, "{x}{number_end}").unwrap();
    }
    for face in soup.corners.chunks(3) {
        write!(body, "3 {} {} {}{line_end}", face[0], face[1], face[2]).unwrap();
    }
    text(&format!("element vertex 42\n{XYZ}element face 80\n{LIST}"), body.trim_end())
}

/// A flat strip of two rows, and one triangle after a restart.
fn strips() -> Vec<u8> {
    let mut bytes = Bytes { out: Vec::new(), is_big: false };
    bytes.out.extend(
        format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex 6\n{XYZ}element tristrips 1\nproperty list int int \
             vertex_indices\nend_header\n"
        )
        .bytes(),
    );
    for i in 0..6 {
        for x in [(i / 2) as f32, (i % 2) as f32, 0.0] {
            bytes.put(x.to_le_bytes());
        }
    }
    let indices = [0, 2, 1, 3, 3, 5, -1, 2, 4, 3, -1, 1, -1];
    bytes.put((indices.len() as i32).to_le_bytes());
    for index in indices {
        bytes.put(i32::to_le_bytes(index));
    }
    bytes.out
}

/// A text with texture coordinates and normals of vertices, polygons and a colour.
fn attributes() -> Vec<u8> {
    text(
        &format!(
            "element vertex 4\n{XYZ}property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty \
             float t\nproperty uchar red\nelement face 2\n{LIST}"
        ),
        "0 0 0 0 0 1 0 0 255\n1 0 0 0 0 1 1 0 255\n1 1 0 0 0 1 1 1 255\n0 1 0 0 0 1 0 1 255\n4 0 1 2 3\n3 0 2 3\n",
    )
}

/// A text with texture coordinates of corners.
fn face_texture(lists: [&str; 2]) -> Vec<u8> {
    text(
        &format!(
            "element vertex 3\n{XYZ}property float u\nproperty float v\nelement face 2\nproperty list uchar float \
             texcoord\n{LIST}\nproperty int texnumber"
        ),
        &format!(
            "0 0 0 9 9\n1 0 0 9 9\n0 1 0 9 9\n{} 3 0 1 2 0\n{} 3 2 1 0 0\n",
            lists[0], lists[1]
        ),
    )
}

/// Files with all that the reader understands, to be damaged.
pub fn good_files() -> Vec<Vec<u8>> {
    vec![
        sphere(false),
        sphere(true),
        odd_sphere(true),
        text_sphere(" ", "\n"),
        strips(),
        attributes(),
        face_texture(["6 0 0 1 0 0 1", "0"]),
    ]
}

#[test]
fn all_forms_give_the_same_sphere() {
    let expected = samples::icosphere(2);
    for bytes in
        [odd_sphere(false), odd_sphere(true), text_sphere(" ", "\n"), text_sphere("\r\n", "\r\n")]
    {
        let soup = read(&bytes);
        assert_eq!(
            (soup.positions, soup.corners),
            (expected.positions.clone(), expected.corners.clone())
        );
        assert!(soup.normals.is_empty(), "nx alone is no normal");
    }
    for bytes in [sphere(false), sphere(true)] {
        let soup = read(&bytes);
        assert_eq!(soup.corners, expected.corners);
        let exact = expected.positions.iter().flatten();
        // Half a unit in the last place of an `f32` below 1.
        assert!(soup.positions.iter().flatten().zip(exact).all(|(a, b)| (a - b).abs() <= 3e-8));
        assert!(soup.lines.is_empty());
    }
    let on_one_line = text_sphere(" ", " ");
    assert_eq!(outcome(&on_one_line), loads(42, 80));
    assert!(read(&on_one_line).lines.iter().all(|&line| line == 10));
    assert_eq!(read(&text_sphere(" ", "\n")).lines, Vec::from_iter(10..90));
}

#[test]
fn header_lines_may_end_in_any_way() {
    for bytes in [sphere(false), sphere(true), odd_sphere(false), strips(), attributes()] {
        let expected = outcome(&bytes);
        assert!(matches!(expected, Outcome::Loads(..)));
        let end = bytes.windows(11).position(|part| part == b"end_header\n").unwrap() + 11;
        let header = String::from_utf8(bytes[..end].to_vec()).unwrap();
        for line_end in ["\r\n", "\r", "  \n", "\ncomment ü \n"] {
            let mut other = header.trim_end().replace('\n', line_end).into_bytes();
            other.extend(line_end.split("comment").next().unwrap().bytes());
            // The numbers may begin with what would be a line end.
            other.extend(&bytes[end..]);
            assert_eq!(outcome(&other), expected, "{line_end:?}");
        }
    }
}

#[test]
fn strips_become_triangles_that_all_look_one_way() {
    let soup = read(&strips());
    assert_eq!(soup.corners, [0, 2, 1, 1, 2, 3, 2, 4, 3]);
    // As text, with the restart as an unsigned number; strips carry their line.
    let strip = text_of_strips("7 0 1 2 4294967295 2 1 3");
    let soup = read(&strip);
    assert_eq!((soup.corners, soup.lines), (vec![0, 1, 2, 2, 1, 3], vec![14, 14]));
    assert_eq!(
        outcome(&text_of_strips("3 0 1 -2")),
        refused("line 14: vertex -2 of 4"),
        "only −1 ends a strip"
    );
    assert_eq!(outcome(&text_of_strips("3 0 1 1")), refused("no faces, only 4 vertices"));
}

fn text_of_strips(strip: &str) -> Vec<u8> {
    text(
        &format!("element vertex 4\n{XYZ}element tristrips 1\n{LIST}"),
        &format!("0 0 0\n1 0 0\n0 1 0\n1 1 0\n{strip}\n"),
    )
}

#[test]
fn polygons_of_any_size_are_kept_and_incomplete_ones_noted() {
    let corners = " 0 1 2".repeat(1000);
    let bytes =
        String::from_utf8(three_vertices(4, &format!("3000{corners}\n2 0 1\n3 0 1 2\n0\n")))
            .unwrap();
    let content = ply::read(bytes.replace("uchar int", "int uint8").as_bytes()).unwrap();
    assert_eq!(content.soup.polygon(0).len(), 3000);
    assert_eq!(content.soup.polygon(1), [0, 1, 2]);
    assert_eq!(content.soup.lines, [13, 15]);
    assert_eq!(
        outcome(bytes.as_bytes()),
        loads_with(3, 2, "line 14: face with 2 corners ignored (and 1 more)")
    );
}

#[test]
fn normals_and_texture_coordinates_of_vertices_become_those_of_corners() {
    let soup = read(&attributes());
    assert_eq!(soup.corners, [0, 1, 2, 3, 0, 2, 3]);
    assert_eq!((&soup.normal_corners, &soup.texture_corners), (&soup.corners, &soup.corners));
    assert_eq!(soup.normals, [[0.0, 0.0, 1.0]; 4]);
    assert_eq!(soup.texture_coordinates, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let named = String::from_utf8(attributes()).unwrap();
    for [u, v] in [["u", "v"], ["texture_u", "texture_v"]] {
        let named = named.replace("float s\n", &format!("float {u}\n"));
        let named = named.replace("float t\n", &format!("float {v}\n"));
        assert_eq!(read(named.as_bytes()), soup);
    }
    let broken = named.replacen("0 0 1 1 0 255", "0 nan 1 x 0 255", 1);
    let content = ply::read(broken.as_bytes()).unwrap();
    let texts = Vec::from_iter(content.notices.iter().map(ToString::to_string));
    assert_eq!(
        texts,
        [
            "line 17: normal is not a number, ignored",
            "line 17: texture coordinate is not a number, ignored"
        ]
    );
    assert_eq!(content.soup.normal_corners, [0, u32::MAX, 2, 3, 0, 2, 3]);
    assert_eq!(content.soup.texture_corners, [0, u32::MAX, 2, 3, 0, 2, 3]);
}

#[test]
fn texture_coordinates_of_faces_win_over_those_of_vertices() {
    let soup = read(&face_texture(["6 0 0 1 0 0 1", "0"]));
    const NO: u32 = u32::MAX;
    assert_eq!(soup.texture_corners, [0, 1, 2, NO, NO, NO]);
    assert_eq!(soup.texture_coordinates, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    let broken = face_texture(["4 0 0 1 0", "6 0 0 1 inf 0 1"]);
    let content = ply::read(&broken).unwrap();
    assert_eq!(content.soup.texture_corners, [NO, NO, NO, 0, NO, 2]);
    assert_eq!(
        super::reading::outcome("test.ply", &broken),
        Outcome::Loads(
            3,
            2,
            vec![
                "line 17: 4 texture coordinates for 3 corners, ignored".into(),
                "line 18: texture coordinate is not a number, ignored".into(),
            ]
        )
    );
}

#[test]
fn files_that_end_early_are_refused_with_what_is_there() {
    let whole = sphere(false);
    let end = whole.len() - 80 * 13;
    let cut = |length: usize| outcome(&whole[..length]);
    assert_eq!(cut(end + 13 * 50 + 12), refused("ends early: 50 of 80 faces"));
    assert_eq!(cut(whole.len() - 1), refused("ends early: 79 of 80 faces"));
    assert_eq!(cut(end), refused("ends early: 0 of 80 faces"));
    assert_eq!(cut(end - 1), refused("ends early: 41 of 42 vertices"));
    for length in 0..whole.len() {
        assert!(matches!(outcome(&whole[..length]), Outcome::Refused(_)));
    }
    assert_eq!(outcome(&three_vertices(2, "3 0 1 2\n3 0 1")), refused("ends early: 1 of 2 faces"));
}

#[test]
fn promises_that_no_file_could_keep_cost_nothing() {
    let header = |encoding: &str, list: &str| {
        format!(
            "ply\nformat {encoding} 1.0\nelement vertex 4000000000\n{XYZ}element face 4000000000\n{list}\nend_header\n"
        )
        .into_bytes()
    };
    for encoding in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let mut bytes = header(encoding, LIST);
        bytes.extend(b"0 0 0\n1 0 0\n".repeat(10));
        let found = if encoding == "ascii" { 20 } else { 10 };
        assert_eq!(
            outcome(&bytes),
            refused(&format!("ends early: {found} of 4000000000 vertices"))
        );
    }
    let long = String::from_utf8(three_vertices(1, "4294967295 0 1 2\n")).unwrap();
    assert_eq!(
        outcome(long.replace("uchar int", "uint int").as_bytes()),
        refused("ends early: 0 of 1 faces")
    );
    let count = "18446744073709551616";
    let many = String::from_utf8(three_vertices(1, "3 0 1 2\n")).unwrap();
    let many =
        many.replace("element face 1", &format!("element nothing {count}\nelement face {count}"));
    assert_eq!(outcome(many.as_bytes()), refused("ends early: 1 of 18446744073709551615 faces"));
    let honest = read(&sphere(false));
    assert!(memory(&honest) < 3 * sphere(false).len(), "{}", memory(&honest));
}

#[test]
fn broken_headers_are_refused_with_their_line() {
    let good = String::from_utf8(three_vertices(1, "3 0 1 2\n")).unwrap();
    assert_eq!(outcome(good.as_bytes()), loads(3, 1));
    let cases = [
        ("end_header\n", "", "header has no end_header"),
        ("format ascii 1.0\n", "", "header has no format line"),
        ("ascii", "utf8", "line 2: header line “format utf8 1.0” is not understood"),
        (
            "element vertex 3",
            "element vertex",
            "line 3: header line “element vertex” is not understood",
        ),
        ("vertex 3", "vertex -3", "line 3: header line “element vertex -3” is not understood"),
        ("float x", "quad x", "line 4: header line “property quad x” is not understood"),
        ("float x", "float", "line 4: header line “property float” is not understood"),
        (
            "list uchar int",
            "list uchar",
            "line 8: header line “property list uchar vertex_indices” is not understood",
        ),
        (
            "ascii 1.0\n",
            "ascii 1.0\nproperty int a\n",
            "line 3: header line “property int a” is not understood",
        ),
        (
            "ascii 1.0\n",
            "ascii 1.0\nwhat\u{1b}?\n",
            "line 3: header line “what\u{fffd}?” is not understood",
        ),
        ("float y", "float why", "the element vertex has no property y"),
        ("property float z", "property list uchar float z", "the element vertex has no property z"),
        ("vertex_indices", "corners", "the element face has no property vertex_indices"),
        ("list uchar int", "int", "the element face has no property vertex_indices"),
    ];
    for (part, instead, text) in cases {
        assert_eq!(outcome(good.replacen(part, instead, 1).as_bytes()), refused(text));
    }
    assert_eq!(outcome(b"plywood"), refused("no PLY header"));
    assert_eq!(outcome(b"ply\n"), refused("header has no end_header"));
    assert_eq!(outcome(b"ply\nformat ascii 1.0\nend_header"), refused("no vertices, no faces"));
}

#[test]
fn files_without_faces_or_vertices_say_so() {
    let points = text(&format!("element vertex 2\n{XYZ}"), "0 0 0\n1 1 1\n");
    assert_eq!(outcome(&points), refused("no faces (point cloud)"));
    assert_eq!(outcome(&three_vertices(0, "")), refused("no faces (point cloud)"));
    assert_eq!(
        outcome(&three_vertices(1, "2 0 1\n")),
        refused("no faces, only 3 vertices and 1 incomplete face")
    );
    let none = text(&format!("element vertex 0\n{XYZ}element face 0\n{LIST}"), "");
    assert_eq!(outcome(&none), refused("no vertices, no faces"));
    let faces = text(&format!("element face 1\n{LIST}"), "3 0 1 2\n");
    assert_eq!(outcome(&faces), refused("line 6: vertex 0 of 0"));
}

#[test]
fn bad_numbers_are_refused_with_vertex_face_or_line() {
    let good = String::from_utf8(three_vertices(1, "3 0 1 2\n")).unwrap();
    let cases = [
        ("1 0 0", "1 nan 0", "line 11: coordinate nan is not a finite number"),
        ("1 0 0", "1e39 0 0", "line 11: coordinate 1e39 is too large (more than 3.4e38)"),
        ("1 0 0", "1,5 0 0", "line 11: 1,5 is not a number (decimal comma?)"),
        ("3 0 1 2", "3 0 1 3", "line 13: vertex 3 of 3"),
        ("3 0 1 2", "3 0 1 -1", "line 13: vertex -1 of 3"),
        ("3 0 1 2", "3 0 1 1.5", "line 13: vertex 1.5 of 3"),
        ("3 0 1 2", "3 0 1 99999999999", "line 13: vertex 99999999999 of 3"),
        ("3 0 1 2", "x 0 1 2", "line 13: x is not a count"),
        ("3 0 1 2", "-3 0 1 2", "line 13: -3 is not a count"),
    ];
    for (part, instead, text) in cases {
        assert_eq!(outcome(good.replacen(part, instead, 1).as_bytes()), refused(text));
    }
    for is_big in [false, true] {
        let whole = sphere(is_big);
        let faces = whole.len() - 80 * 13;
        let vertices = faces - 42 * 12;
        let with = |at: usize, value: [u8; 4]| {
            let mut bytes = whole.clone();
            bytes[at..at + 4].copy_from_slice(&value);
            if is_big {
                bytes[at..at + 4].reverse();
            }
            bytes
        };
        let infinite = with(vertices + 5 * 12 + 4, f32::NEG_INFINITY.to_le_bytes());
        assert_eq!(outcome(&infinite), refused("vertex 5: coordinate -inf is not a finite number"));
        let error = ply::read(&infinite).unwrap_err();
        assert_eq!(error.place, Place::Vertex(5));
        assert_eq!(error.fault, ReadFault::NotFinite { text: "-inf".into() });
        let negative = with(faces + 3 * 13 + 5, (-1i32).to_le_bytes());
        assert_eq!(outcome(&negative), refused("face 3: vertex -1 of 42"));
        let large = with(faces + 4 * 13 + 9, 4242i32.to_le_bytes());
        assert_eq!(outcome(&large), refused("face 4: vertex 4242 of 42"));
    }
}
