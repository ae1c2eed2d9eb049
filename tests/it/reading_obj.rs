//! Reading OBJ: what loads, what is passed over, what is refused and with which words.

use std::fmt::Write as _;

use cutflow::mesh::Soup;
use cutflow::mesh::read::{Place, ReadFault, ReadNotice, obj};
use cutflow::session::samples;

use super::reading::{Outcome, loads, loads_with, memory, refused};

fn outcome(bytes: &[u8]) -> Outcome {
    super::reading::outcome("test.obj", bytes)
}

fn read(text: &str) -> (Soup, Vec<ReadNotice>) {
    let content = obj::read(text.as_bytes()).unwrap();
    (content.soup, content.notices)
}

/// An icosphere of 42 vertices and 80 faces: vertices on lines 1 to 42, faces on lines 43 to 122.
pub fn sphere() -> String {
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
    let text = "vt 77 of 1, ignored".to_owned();
    let kind = "texture_out_of_range";
    assert_eq!(notices[0], ReadNotice { kind, count: 3, place: Place::Line(5), text });
    assert_eq!(notices[0].to_string(), "line 5: vt 77 of 1, ignored (and 2 more)");
    assert_eq!(notices[1].to_string(), "line 5: vn 88 of 0, ignored");
    assert_eq!(notices.len(), 2);

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
        (soup.groups, soup.polygon_groups) = Default::default();
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
fn normals_are_kept_by_corner_and_forgiven() {
    let text = after_three_vertices(
        "vn 0 0 1\nvn 0 1 0\nvn 1 0\nvn nan 0 0\nvt 0 0\nf 1 2 3\nf 1//1 2//2 3//-4\nf 1/1/3 2/1/4 3/1/9\n",
    );
    let (soup, notices) = read(&text);
    const NO: u32 = u32::MAX;
    assert_eq!(soup.normals, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0; 3], [0.0; 3]]);
    assert_eq!(soup.normal_corners, [NO, NO, NO, 0, 1, 0, NO, NO, NO]);
    assert_eq!(soup.texture_corners, [NO, NO, NO, NO, NO, NO, 0, 0, 0]);
    let texts = Vec::from_iter(notices.iter().map(ToString::to_string));
    assert_eq!(
        texts,
        ["line 6: vn is not a number, ignored (and 1 more)", "line 11: vn 9 of 4, ignored"]
    );
}

#[test]
fn a_polygon_has_the_last_group_or_object_before_it() {
    let f = "f 1 2 3\n";
    let text = after_three_vertices(&format!(
        "{f}o Körper #3\n{f}g left arm # comment\n{f}{f}g\n{f}o hat\n{f}g default\n{f}g left arm\n{f}g unused\n"
    ));
    let (soup, notices) = read(&text);
    assert!(notices.is_empty());
    assert_eq!(soup.groups, ["Körper #3", "left arm", "hat"]);
    assert_eq!(soup.polygon_groups, [u32::MAX, 0, 1, 1, 0, 2, 2, 1]);
    assert!(soup.materials.is_empty() && soup.polygon_materials.is_empty());
}

#[test]
fn a_polygon_has_the_last_material_before_it() {
    let f = "f 1 2 3\n";
    let text = after_three_vertices(&format!(
        "mtllib a b.mtl\n{f}usemtl red\n{f}usemtl\n{f}USEMTL blue\n{f}usemtl red\nf 1 2\n{f}"
    ));
    let (soup, _) = read(&text);
    assert_eq!(soup.materials, ["red", "blue"]);
    assert_eq!(soup.polygon_materials, [u32::MAX, 0, u32::MAX, 1, 0]);
    assert!(soup.groups.is_empty() && soup.polygon_groups.is_empty());
}

#[test]
fn a_long_or_unprintable_name_is_shortened() {
    let text = format!("g {}\nf 1 2 3\ng a\u{7}b\nf 1 2 3\n", "x".repeat(10_000));
    let (soup, _) = read(&after_three_vertices(&text));
    assert_eq!(soup.groups, ["x".repeat(120) + "…", "a\u{fffd}b".to_owned()]);
    // Three bytes for each letter.
    let (soup, _) = read(&after_three_vertices(&format!("g {}\nf 1 2 3\n", "頭".repeat(200))));
    assert_eq!(soup.groups, ["頭".repeat(120) + "…"]);
}

#[test]
fn memory_is_at_most_three_times_the_file() {
    let full = String::from_utf8(good_files()[1].clone()).unwrap();
    let shortest = "v 0 0 0\n".repeat(999) + &"f 1 2 3\n".repeat(999);
    let with_all = "v 0 0 0\nvt 0 0\nvn 0 0 0\n".repeat(999) + &"f 1/1/1 2/2/2 3/3/3\n".repeat(999);
    for text in [sphere(), full, shortest, with_all] {
        let (soup, _) = read(&text);
        assert!(memory(&soup) <= 3 * text.len() + 64, "{} of {}", memory(&soup), text.len());
    }
}

/// Files with all that the reader understands, to be damaged.
pub fn good_files() -> Vec<Vec<u8>> {
    let sphere = sphere();
    let full = sphere
        .replace("\nv ", "\nvt 0.25 0.5\nvn 0 0.6 0.8\nv ")
        .replace("\nf 1", "\ng part 1\nusemtl red\no thing\nf 1")
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(rest) => format!("f {}\n", rest.replace(' ', "/3/-2 \\\n")),
            None => format!("{line}\n"),
        })
        .collect::<String>();
    let small = after_three_vertices("vt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3/-1\nl 1 2\nf -1 -2 -3\r\n");
    vec![sphere.into_bytes(), full.into_bytes(), small.into_bytes()]
}

#[test]
fn long_names_that_alternate_take_no_longer_than_their_letters() {
    // A group without a name returns to the object: comparing whole names would read 20 000 × 4 MB.
    let name = "n".repeat(4_000_000);
    let mut text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\no {name}\n");
    for _ in 0..20_000 {
        text += "g x\nf 1 2 3\ng\nf 1 2 3\n";
    }
    let soup = obj::read(text.as_bytes()).unwrap().soup;
    assert_eq!(soup.polygon_count(), 40_000);
    assert!(soup.groups.iter().all(|group| group.len() <= 256));
}
