//! Reading OFF: its variants, where its lines end, and what is refused.

use std::fmt::Write as _;

use cutflow::mesh::Soup;
use cutflow::mesh::read::off;
use cutflow::session::samples;

use super::reading::{Outcome, loads, loads_with, refused};

fn outcome(bytes: &[u8]) -> Outcome {
    super::reading::outcome("test.off", bytes)
}

fn read(text: &str) -> Soup {
    let content = off::read(text.as_bytes()).unwrap();
    assert!(content.notices.is_empty(), "{:?}", content.notices);
    content.soup
}

/// An icosphere of 42 vertices on lines 3 to 44 and 80 faces on lines 45 to 124.
fn sphere() -> String {
    let soup = samples::icosphere(2);
    let mut text = String::from("OFF\n42 80 120\n");
    for [x, y, z] in &soup.positions {
        writeln!(text, "{x} {y} {z}").unwrap();
    }
    for face in soup.corners.chunks(3) {
        writeln!(text, "3 {} {} {}", face[0], face[1], face[2]).unwrap();
    }
    text
}

/// A cube of quadrilaterals with comments, counts without edges, and colours of all kinds.
const CUBE: &str = "COFF # colours\n# a comment\n8 6\n0 0 0  255 128 0 255\n1 0 0  255 128 0 255\n\
    0 1 0  255 128 0 255\n\n1 1 0  255 128 0 255 # corner\n0 0 1  255 128 0 255\n1 0 1  255 128 0 255\n\
    0 1 1  255 128 0 255\n1 1 1  255 128 0 255\n4 0 2 3 1\n4 4 5 7 6  255 0 0\n4 0 1 5 4\n\
    4 2 6 7 3  0.5 0.5 0.5\n4 0 4 6 2\n4 1 3 7 5";

/// A square of two triangles with all attributes.
const SQUARE: &str = "STCNOFF\n4 2 5\n0 0 0 0 0 1 1 0 0 1 0 0\n1 0 0 0 0 1 255 0 0 1 0\n1 1 0 0 0 1 1 1\n\
    0 1 0 0 0 1 0.5 0.5 0.5 0.5 0 1\n3 0 1 2\n3 0 2 3 7\n";

/// Files with all that the reader understands, to be damaged.
pub fn good_files() -> Vec<Vec<u8>> {
    vec![sphere().into_bytes(), CUBE.into(), SQUARE.into()]
}

#[test]
fn all_forms_of_the_text_give_the_same_mesh() {
    let plain = sphere();
    let expected = samples::icosphere(2);
    let variants = [
        plain.clone(),
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.replace('\n', " # comment 1 2\n\n"),
        plain.replace(' ', "\t"),
        plain.trim_end().to_owned(),
        format!("\u{feff}# first\n  {plain}"),
        plain.replacen("OFF\n", "OFF ", 1),
        plain.replacen("OFF\n", "", 1),
        plain.replacen("OFF\n", "off\n", 1),
        plain.replacen("42 80 120\n", "42 80\n", 1),
        plain.replacen("42 80 120\n", "42\n80 120\n", 1),
        plain.replacen("42 80 120\n", "42\n80\n120\n", 1),
        plain.replacen("42 80 120\n", "42 80 0 # edges\n", 1),
        plain
            .replacen("OFF\n42 80 120\n", "COFF 42 80 120\n", 1)
            .replace("\n3 ", " 0.5 0.5 1 1\n3 "),
        plain.replace("\n3 ", " 0.1 0.2\n3 "),
        plain.replace("\n3 ", "\n3\n"),
        plain.clone() + "what follows is of no concern",
    ];
    for text in variants {
        let soup = read(&text);
        assert_eq!(
            (&soup.positions, &soup.corners),
            (&expected.positions, &expected.corners),
            "{text:.80}"
        );
    }
    assert_eq!(read(&plain).lines, Vec::from_iter(45..125));
}

#[test]
fn colours_and_comments_are_passed_over() {
    let soup = read(CUBE);
    assert_eq!((soup.positions.len(), soup.polygon_count()), (8, 6));
    assert_eq!(soup.polygon(3), [2, 6, 7, 3]);
    assert_eq!(soup.positions[7], [1.0; 3]);
    assert_eq!(soup.lines, [13, 14, 15, 16, 17, 18]);
}

#[test]
fn normals_and_texture_coordinates_of_vertices_become_those_of_corners() {
    let soup = read(SQUARE);
    assert_eq!(soup.normals, [[0.0, 0.0, 1.0]; 4]);
    assert_eq!(soup.texture_coordinates, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!((&soup.normal_corners, &soup.texture_corners), (&soup.corners, &soup.corners));
    let broken =
        SQUARE.replacen("1 0 0 0 0 1 255", "1 0 0 0 nan 1 255", 1).replacen("1 1\n", "1 inf\n", 1);
    let content = off::read(broken.as_bytes()).unwrap();
    let texts = Vec::from_iter(content.notices.iter().map(ToString::to_string));
    assert_eq!(
        texts,
        [
            "line 4: normal is not a number, ignored",
            "line 5: texture coordinate is not a number, ignored"
        ]
    );
    assert_eq!(content.soup.normal_corners, [0, u32::MAX, 2, 0, 2, 3]);
    assert_eq!(content.soup.texture_corners, [0, 1, u32::MAX, 0, u32::MAX, 3]);
}

#[test]
fn bad_lines_are_refused_by_number() {
    let cases = [
        ("42 80", "x 80", "line 2: x is not a count"),
        ("42 80", "-42 80", "line 2: -42 is not a count"),
        ("\n3 ", "\nx ", "line 45: x is not a count"),
        ("\n3 ", "\n-3 ", "line 45: -3 is not a count"),
        ("\n3 ", "\n3 42 ", "line 45: vertex 42 of 42"),
        ("\n3 ", "\n3 -1 ", "line 45: vertex -1 of 42"),
        ("\n3 ", "\n3 99999999999999999999 ", "line 45: vertex 99999999999999999999 of 42"),
        ("\n3 ", "\n3 1.0 ", "line 45: 1.0 is not a face corner"),
        ("\n3 ", "\n4294967295 ", "ends early: 0 of 80 faces"),
        ("120\n", "120\nnan 0 0\n", "line 3: coordinate nan is not a finite number"),
        ("120\n", "120\n0 -1e39 0\n", "line 3: coordinate -1e39 is too large (more than 3.4e38)"),
        ("120\n", "120\n0,5 1 2\n", "line 3: 0,5 is not a number (decimal comma?)"),
        ("120\n", "120\n0 1\n", "line 3: vertex with 2 of 3 coordinates"),
        ("42 80", "43 80", "ends early: 79 of 80 faces"),
        ("42 80", "42 81", "ends early: 80 of 81 faces"),
        ("42 80", "42 4000000000", "ends early: 80 of 4000000000 faces"),
        ("42 80", "18446744073709551616 80", "ends early: 122 of 18446744073709551615 vertices"),
        ("42 80", "42 0", "no faces (point cloud)"),
        ("42 80", "0 0", "no vertices, no faces"),
        ("OFF\n", "4OFF\n", "line 1: needs 4OFF (coordinates of another space), not supported"),
        ("OFF\n", "nOFF\n3\n", "line 1: needs nOFF (coordinates of another space), not supported"),
        ("OFF\n", "OFF BINARY\n", "line 1: needs binary OFF, not supported"),
    ];
    for (part, instead, text) in cases {
        assert_eq!(outcome(sphere().replacen(part, instead, 1).as_bytes()), refused(text));
    }
    assert_eq!(outcome(b"OFF"), refused("ends early: 0 of 2 counts"));
    assert_eq!(outcome(b"OFF 3"), refused("ends early: 1 of 2 counts"));
    assert_eq!(outcome(b"# nothing"), refused("no vertices, no faces"));
    let binary = [&b"OFF BINARY\n"[..], &[0, 0, 0, 8, 0, 0, 0, 6]].concat();
    assert_eq!(outcome(&binary), refused("line 1: needs binary OFF, not supported"));
}

#[test]
fn files_that_end_early_are_refused_with_what_is_there() {
    let text = sphere();
    let start = |line: usize| text.lines().take(line - 1).map(|line| line.len() + 1).sum::<usize>();
    assert_eq!(outcome(&text.as_bytes()[..start(33)]), refused("ends early: 30 of 42 vertices"));
    let in_line = start(33) + text.lines().nth(32).unwrap().find(' ').unwrap();
    assert_eq!(outcome(&text.as_bytes()[..in_line]), refused("ends early: 30 of 42 vertices"));
    assert_eq!(outcome(&text.as_bytes()[..start(50) + 2]), refused("ends early: 5 of 80 faces"));
    for end in 0..text.len() {
        outcome(&text.as_bytes()[..end]);
    }
}

#[test]
fn incomplete_faces_are_noted() {
    let text = "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n1 2\n";
    let notice = "line 6: face with 2 corners ignored (and 1 more)";
    assert_eq!(outcome(text.as_bytes()), loads_with(3, 1, notice));
    assert_eq!(
        outcome(text.replacen("2 0 1", "3 2 1 0", 1).as_bytes()),
        loads_with(3, 2, "line 8: face with 1 corner ignored")
    );
    let none = text.replacen("3 0 1 2", "0", 1);
    assert_eq!(
        outcome(none.as_bytes()),
        refused("no faces, only 3 vertices and 3 incomplete faces")
    );
    assert_eq!(outcome(sphere().as_bytes()), loads(42, 80));
}
