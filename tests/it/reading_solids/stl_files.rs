//! STL: what is recognised, what is welded, what is refused.

use cutflow::mesh::read::stl;

use super::{SplitMix64, assert_sound, binary_stl, refusal, sphere, text_stl, texts, volume};

#[test]
fn binary_stl_is_known_by_its_size_and_welded() {
    let triangles = sphere(2, [0.0; 3]);
    for header in ["", "binary", "solid exported-by-cad (this is binary)", "COLOR=\u{1}\u{2}\u{3}"]
    {
        let content = stl::read(&binary_stl(header, &triangles)).unwrap();
        assert_eq!((content.soup.positions.len(), content.soup.polygon_count()), (162, 320));
        assert_eq!(texts(&content), ["960 corners at 162 places"]);
        assert_sound(&content);
        assert!(volume(&content.soup, 0) > 0.0);
    }
}

#[test]
fn bytes_after_the_last_facet_are_passed_over() {
    let mut bytes = binary_stl("binary", &sphere(1, [0.0; 3]));
    bytes.extend(b"some tail");
    let content = stl::read(&bytes).unwrap();
    assert_eq!(content.soup.polygon_count(), 80);
    assert_eq!(texts(&content)[1], "9 bytes after the last facet ignored");
}

#[test]
fn binary_stl_that_ends_early_says_how_much_is_there() {
    let bytes = binary_stl("binary", &sphere(2, [0.0; 3]));
    assert_eq!(refusal(stl::read(&bytes[..10107])), "ends early: 200 of 320 facets");
    assert_eq!(refusal(stl::read(&bytes[..84])), "ends early: 0 of 320 facets");
    // Without any header, normals and coordinates give it away.
    let bare = binary_stl("", &sphere(2, [0.0; 3]));
    assert_eq!(refusal(stl::read(&bare[..10107])), "ends early: 200 of 320 facets");
    let mut huge = binary_stl("count says 4294967295 facets", &sphere(0, [0.0; 3])[..4]);
    huge[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(refusal(stl::read(&huge)), "ends early: 4 of 4294967295 facets");
}

#[test]
fn coordinates_of_stl_that_are_no_finite_numbers_are_refused_with_their_facet() {
    let mut triangles = sphere(1, [0.0; 3]);
    triangles[7][1][2] = f32::NAN;
    let error = refusal(stl::read(&binary_stl("", &triangles)));
    assert_eq!(error, "byte 434: facet 7: coordinate NaN is not a finite number");
    let text = text_stl("", &sphere(0, [0.0; 3]));
    for (number, problem) in [
        ("nan", "is not a finite number"),
        ("-1e999", "is not a finite number"),
        ("1e39", "is too large (more than 3.4e38)"),
        ("0,5", "is not a number"),
        ("1.2.3", "is not a number"),
    ] {
        let text = text.replacen("vertex 0e0", &format!("vertex {number}"), 1);
        let expected = format!("line 4: facet 0: coordinate {number} {problem}");
        assert_eq!(refusal(stl::read(text.as_bytes())), expected);
    }
}

#[test]
fn each_solid_of_a_text_is_a_group() {
    let first = text_stl("first part", &sphere(1, [0.0; 3]));
    let second = text_stl("", &sphere(1, [5.0; 3])).to_uppercase();
    let content = stl::read((first + &second).as_bytes()).unwrap();
    let soup = &content.soup;
    assert_eq!((soup.positions.len(), soup.polygon_count()), (84, 160));
    assert_eq!(soup.groups, ["first part", "solid 2"]);
    assert_eq!((soup.polygon_groups[79], soup.polygon_groups[80]), (0, 1));
    assert_eq!(soup.lines[..2], [2, 9]);
    assert_eq!(texts(&content), ["480 corners at 84 places"]);
    assert_sound(&content);
    // Names may hold number signs and end in a backslash; comments are no unknown lines.
    let odd = text_stl("part # 3 \\", &sphere(0, [0.0; 3])) + "# made by hand\n";
    let content = stl::read(odd.as_bytes()).unwrap();
    assert_eq!(content.soup.groups, ["part # 3 \\"]);
    assert_eq!(texts(&content), ["60 corners at 12 places"]);
}

#[test]
fn all_forms_of_text_stl_give_the_same_mesh() {
    let text = text_stl("a", &sphere(1, [0.0; 3]));
    let plain = stl::read(text.as_bytes()).unwrap();
    for other in [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace("      vertex", "\t vertex \t"),
        text.replace("facet normal 0 0 0", "facet normal nan -1.#IND 7"),
        text.replace("normal 0 0 0", ""),
        text.to_uppercase().replace("SOLID A", "SOLID a"),
        format!("\u{feff}\n\n  {text}"),
    ] {
        let content = stl::read(other.as_bytes()).unwrap();
        assert_eq!(content.soup.positions, plain.soup.positions, "{}", &other[..100]);
        assert_eq!(content.soup.corners, plain.soup.corners);
        assert_eq!(content.soup.groups, plain.soup.groups);
    }
}

#[test]
fn text_stl_that_is_cut_short_or_broken_is_refused_with_its_place() {
    let text = text_stl("a", &sphere(0, [0.0; 3]));
    let cut = text.find("endfacet").unwrap();
    assert_eq!(refusal(stl::read(&text.as_bytes()[..cut])), "line 2: ends early, inside facet 0");
    let without_end = text.replace("endsolid a\n", "");
    let content = stl::read(without_end.as_bytes()).unwrap();
    assert_eq!(texts(&content)[1], "no endsolid, the file may be cut short");
    let short = text.replacen("endloop", "vertex 1 2\nendloop", 1);
    assert_eq!(refusal(stl::read(short.as_bytes())), "line 7: facet 0: 2 of 3 coordinates");
    let line = text.lines().nth(4).unwrap();
    let two = text.replacen(line, "", 1);
    assert_eq!(refusal(stl::read(two.as_bytes())), "line 2: facet 0: 2 of 3 corners");
    let word = text.replacen("endloop", "endlop", 1);
    let expected = "line 7: facet 0: endlop where vertex or endloop should be";
    assert_eq!(refusal(stl::read(word.as_bytes())), expected);
}

#[test]
fn what_is_no_stl_is_refused() {
    let mut random = SplitMix64::new(4);
    let noise: Vec<u8> = (0..6000).map(|_| random.next() as u8).collect();
    assert_eq!(refusal(stl::read(&noise)), "not an STL file");
    assert_eq!(refusal(stl::read(b"")), "the file is empty");
    assert_eq!(refusal(stl::read(b"solid")), "no facets");
    assert_eq!(refusal(stl::read(b"solid water\nis ice\n")), "not an STL file");
    assert_eq!(refusal(stl::read(b"v 0 0 0")), "not an STL file");
    assert_eq!(refusal(stl::read(&binary_stl("binary", &[]))), "no facets");
}
