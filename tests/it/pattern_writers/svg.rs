//! Drawings for printers and lasers.

use std::collections::BTreeMap;

use cutflow::pattern::{Layer, SvgParams, SvgProfile};

use super::{attribute, drawing, small};

#[test]
fn a_drawing_for_a_laser_has_its_colours_hairlines_and_no_text_nor_dashes() {
    let params = SvgParams { profile: SvgProfile::Laser, ..SvgParams::default() };
    let drawn = drawing(&small(), &params);
    for unwanted in ["<text", "dasharray", "<rect", "transform", "style=", "NaN"] {
        assert!(!drawn.contains(unwanted), "{unwanted}");
    }
    let groups: BTreeMap<&str, &str> = drawn
        .lines()
        .filter(|line| line.starts_with("<g "))
        .map(|line| {
            assert_eq!(attribute(line, "stroke-width"), Some("0.0254"));
            (attribute(line, "id").unwrap(), attribute(line, "stroke").unwrap())
        })
        .collect();
    let expected = [
        ("cut", "#ff0000"),
        ("sew", "#0000ff"),
        ("notch", "#0000ff"),
        ("grain", "#000000"),
        ("fold_m", "#0000ff"),
        ("fold_v", "#0000ff"),
        ("score", "#0000ff"),
        ("drill", "#0000ff"),
        ("text", "#000000"),
        ("control", "#000000"),
    ];
    assert_eq!(groups, BTreeMap::from(expected), "only groups with content");
    // Cut last, and holes before what is around them.
    assert!(drawn.rfind("<g ").unwrap() == drawn.find("<g id=\"cut\"").unwrap());
    for name in ["A", "B", "C"] {
        let [hole, cut] = ["hole-1", "cut"].map(|end| drawn.find(&format!("id=\"{name}-{end}\"")));
        assert!(hole.unwrap() < cut.unwrap());
    }
    // A circle stays four cubic curves.
    let hole = drawn.lines().find(|line| line.contains("A-hole-1")).unwrap();
    let d = attribute(hole, "d").unwrap();
    let numbers = d.replace(['M', 'C', 'Z', ','], " ").split_whitespace().count();
    assert!(d.contains(" C ") && d.ends_with(" Z") && numbers == 2 + 4 * 6, "{d}");
}

#[test]
fn a_piece_in_the_hole_of_another_is_cut_first() {
    let mut sheet = small();
    // The last piece, small, into the hole of the first: its cut must come before that hole.
    let hole = sheet.lines.iter().find(|line| line.id == "A-hole-1").unwrap().points.clone();
    let middle = [0, 1].map(|a| hole.iter().map(|p| p[a]).sum::<f64>() / hole.len() as f64);
    let own = sheet.lines.iter_mut().find(|line| line.id == "C-cut").unwrap();
    own.points = vec![middle, [middle[0] + 2.0, middle[1]], [middle[0], middle[1] + 2.0]];
    sheet.lines.retain(|line| line.id != "C-hole-1");
    let params = SvgParams { profile: SvgProfile::Laser, ..SvgParams::default() };
    let drawn = drawing(&sheet, &params);
    let place = |id: &str| drawn.find(&format!("id=\"{id}\"")).unwrap();
    assert!(place("C-cut") < place("A-hole-1") && place("A-hole-1") < place("A-cut"));
}

#[test]
fn a_perforation_cuts_folds_in_short_pieces() {
    let params =
        SvgParams { profile: SvgProfile::Laser, perforation: true, ..SvgParams::default() };
    let drawn = drawing(&small(), &params);
    let fold = drawn.lines().find(|line| line.contains("\"A-fold-1\"")).unwrap();
    // 60 mm long: a cut of 2 mm for every 4 mm.
    assert_eq!(attribute(fold, "d").unwrap().matches('M').count(), 15);
    let group = drawn.lines().find(|line| line.starts_with("<g id=\"fold_m\"")).unwrap();
    assert_eq!(attribute(group, "stroke"), Some("#ff0000"));
}

#[test]
fn a_drawing_in_print_has_dashes_and_seams_keep_their_partners() {
    let own = vec![(Layer::Cut, [1, 2, 3])];
    let drawn = drawing(&small(), &SvgParams { colours: own, ..SvgParams::default() });
    let group =
        |id: &str| drawn.lines().find(|line| line.starts_with(&format!("<g id=\"{id}\""))).unwrap();
    assert_eq!(attribute(group("fold_m"), "stroke-dasharray"), Some("6 2 0.1 2"));
    assert_eq!(attribute(group("fold_v"), "stroke-dasharray"), Some("4 2"));
    assert_eq!(attribute(group("cut"), "stroke-dasharray"), None);
    assert_eq!(attribute(group("cut"), "stroke"), Some("#010203"));
    assert!(drawn.contains("<text") && drawn.contains("Möbel &amp; Co"));
    let sew = drawn.lines().find(|line| line.contains("\"A-sew\"")).unwrap();
    assert_eq!(
        [attribute(sew, "data-seam"), attribute(sew, "data-partner")],
        [Some("1"), Some("B")]
    );
    assert!(attribute(sew, "data-length-mm").is_some_and(|l| l.parse::<f64>().unwrap() > 100.0));
    let paths = drawing(&small(), &SvgParams { text_as_paths: true, ..SvgParams::default() });
    assert!(!paths.contains("<text") && paths.contains("<path id=\"A-name\""));
}
