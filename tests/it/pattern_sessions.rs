//! Patterns of a session: what is asked for is on the sheet, what is shown is what is written, what cannot be had is told.
#![allow(
    clippy::unwrap_used,
    clippy::float_cmp,
    reason = "tests may panic, and compare what must be equal"
)]

use cutflow::pattern::{Layer, Sheet};
use cutflow::session::{Command, Event, PatternView, Session, Value};

use crate::scripts::{errors, set};

fn ball() -> Session {
    let mut session = Session::new();
    assert!(errors(&session.handle(Command::OpenSample { name: "ball".into() })).is_empty());
    session
}

fn text(word: &str) -> Value {
    Value::Text(word.into())
}

fn shown(events: &[Event]) -> Option<PatternView> {
    events.iter().rev().find_map(|event| match event {
        Event::Pattern(view) => Some(view.clone()),
        _ => None,
    })
}

fn written(session: &mut Session, kind: &str) -> Vec<u8> {
    session.export(kind).unwrap().bytes
}

/// A drawing without the width of its lines: what is shown has lines wide enough to be seen.
fn plain(svg: &str) -> String {
    let mut parts = svg.split("stroke-width=\"");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + part.split_once('"').unwrap().1)
}

fn drawing(session: &mut Session) -> String {
    plain(&String::from_utf8(written(session, "Pattern (SVG)")).unwrap())
}

fn count(sheet: &Sheet, layer: Layer) -> usize {
    sheet.lines.iter().filter(|line| line.layer == layer).count()
}

#[test]
fn every_option_changes_what_is_shown_and_that_is_what_is_written() {
    let mut session = ball();
    let first = shown(&session.handle(Command::ShowPattern { is_shown: true })).unwrap();
    assert_eq!(plain(&first.svg), drawing(&mut session));
    let mut last = first.svg;
    for (id, value, changes_drawing) in [
        ("allowance", Value::Number(8.0), true),
        ("corner", text("round"), false),
        ("notches", text("slit"), true),
        ("notches", text("v"), true),
        ("notches", text("t"), true),
        ("notch_spacing", Value::Number(30.0), true),
        ("grain", text("both"), true),
        ("grain", text("nap"), true),
        ("hints", Value::Truth(true), true),
        ("seam_labels", Value::Truth(false), true),
        ("piece_labels", Value::Truth(false), true),
        ("marks", Value::Truth(false), true),
        ("outlines", text("smooth"), true),
        ("curve_tolerance", Value::Number(0.5), true),
        ("copies", Value::Number(2.0), true),
        ("mirrored", Value::Truth(true), true),
        ("allowance", Value::Number(0.0), true),
        ("kerf", Value::Number(0.4), true),
        ("flaps", text("alternate"), true),
        ("flap_depth", Value::Number(1.0), true),
        ("folds", Value::Truth(true), false),
        ("stock", text("roll"), true),
        ("stock_width", Value::Number(300.0), true),
        ("gap", Value::Number(12.0), true),
        ("stock", text("sheet"), true),
        ("stock_height", Value::Number(200.0), true),
        ("turns", text("none"), true),
        ("svg_profile", text("laser"), true),
        ("size", Value::Number(120.0), true),
        ("dxf_profile", text("astm"), false),
        ("paper", text("a3"), false),
    ] {
        let events = session.handle(Command::SetParameter { id: id.into(), value: value.clone() });
        assert!(errors(&events).is_empty(), "{id} {value:?}: {:?}", errors(&events));
        let view = shown(&events).unwrap_or_else(|| panic!("{id} {value:?} shows nothing"));
        assert_eq!(plain(&view.svg), drawing(&mut session), "{id} {value:?}");
        assert!(!view.svg.contains("NaN") && !view.svg.contains("inf"));
        if changes_drawing {
            assert_ne!(view.svg, last, "{id} {value:?} changes nothing");
        }
        last = view.svg;
    }
    for kind in ["Pattern (DXF)", "Pattern (PDF)"] {
        assert!(written(&mut session, kind).len() > 1000);
    }
}

#[test]
fn sizes_on_the_sheet_are_those_of_the_model_and_partners_meet() {
    let mut session = ball();
    session.handle(Command::ApplyTrade { id: "garment".into() });
    set(&mut session, "stock", text("free"));
    let sheet = session.pattern_sheet().unwrap();
    let report = session.pattern_report().unwrap();
    assert_eq!((report.pieces.len(), report.seams.len()), (2, 1));
    let seam = &report.seams[0];
    assert!((seam.flat_mm[0] - seam.flat_mm[1]).abs() < 0.1, "{seam:?}");
    assert!((seam.flat_mm[0] - seam.length_mm).abs() < 0.1, "{seam:?}");
    assert!(seam.length_mm > 150.0 && seam.length_mm < 400.0, "a ball of 67 mm");
    assert!(seam.notches.len() > 1);
    // As many notches on one side as on the other.
    let of = |piece: usize| {
        let notches = sheet.lines.iter().filter(|line| line.layer == Layer::Notch);
        notches.filter(|line| line.piece == Some(piece)).count()
    };
    assert!(of(0) > 1 && of(0) == of(1));
    // The sewing lines that are written are as long as each other, although each was made smooth by itself.
    let lengths: Vec<f64> = sheet
        .lines
        .iter()
        .filter(|line| line.layer == Layer::Sew)
        .map(|line| {
            let next = line.points.iter().cycle().skip(1);
            line.points.iter().zip(next).map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1])).sum()
        })
        .collect();
    assert_eq!(lengths.len(), 2);
    assert!((lengths[0] - lengths[1]).abs() < 0.1, "{lengths:?}");
}

#[test]
fn trades_can_be_chosen_and_left_again() {
    let mut session = ball();
    let plain = written(&mut session, "Pattern (SVG)");
    for id in ["plush", "garment", "upholstery", "leather", "paper", "sheet_metal"] {
        let events = session.handle(Command::ApplyTrade { id: id.into() });
        assert!(errors(&events).is_empty());
        let current = events.iter().find_map(|event| match event {
            Event::Trades { current, .. } => current.clone(),
            _ => None,
        });
        assert_eq!(current.as_deref(), Some(id));
        assert_ne!(written(&mut session, "Pattern (SVG)"), plain, "{id}");
    }
    session.handle(Command::ApplyTrade { id: "plain".into() });
    assert_eq!(written(&mut session, "Pattern (SVG)"), plain);
    assert_eq!(errors(&session.handle(Command::ApplyTrade { id: "magic".into() })).len(), 1);
}

#[test]
fn paper_models_have_folds_and_flaps_instead_of_allowances() {
    let mut session = Session::new();
    // A cube: cut to a net along edges of the mesh.
    let corners = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2));
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\nf 3 1 5 7\n";
    session.open("cube.obj", (corners.collect::<String>() + faces).as_bytes());
    set(&mut session, "size", Value::Number(60.0));
    session.handle(Command::SetMethod { id: "developable".into() });
    session.handle(Command::Run);
    while session.is_running() {
        session.advance(&mut || true);
    }
    session.handle(Command::ApplyTrade { id: "paper".into() });
    let sheet = session.pattern_sheet().unwrap();
    assert!(count(&sheet, Layer::FoldMountain) > 0, "edges of the cube, and of flaps");
    assert_eq!(count(&sheet, Layer::Sew), 0);
    assert_eq!(sheet.frames.len(), 1);
}

#[test]
fn a_seam_can_have_an_allowance_of_its_own_until_the_cut_is_another() {
    let mut session = ball();
    session.handle(Command::ShowPattern { is_shown: true });
    set(&mut session, "allowance", Value::Number(5.0));
    let before = written(&mut session, "Pattern (SVG)");
    let events = session.handle(Command::SetSeamAllowance { seam: 1, mm: Some(12.0) });
    let view = shown(&events).unwrap();
    assert_eq!(view.report.seams[0].allowance_mm, 12.0);
    assert_ne!(view.svg.as_bytes(), before);
    session.handle(Command::Undo);
    assert_eq!(written(&mut session, "Pattern (SVG)"), before);
    session.handle(Command::Redo);
    assert_eq!(session.pattern_report().unwrap().seams[0].allowance_mm, 12.0);
    // Another cut has other seams.
    session.handle(Command::Step);
    assert_eq!(session.pattern_report().unwrap().seams[0].allowance_mm, 5.0);
    for (seam, mm) in [(0, Some(3.0)), (99, Some(3.0)), (1, Some(-1.0)), (1, Some(f64::NAN))] {
        assert_eq!(errors(&session.handle(Command::SetSeamAllowance { seam, mm })).len(), 1);
    }
}

#[test]
fn what_cannot_be_had_is_told_and_the_rest_is_made() {
    let mut session = ball();
    set(&mut session, "stock", text("sheet"));
    set(&mut session, "stock_width", Value::Number(80.0));
    set(&mut session, "stock_height", Value::Number(80.0));
    let report = session.pattern_report().unwrap();
    let told = |report: &[String], word: &str| report.iter().any(|notice| notice.contains(word));
    assert!(told(&report.notices, "larger than the material"), "{:?}", report.notices);
    assert!(written(&mut session, "Pattern (PDF)").len() > 1000);
    // An allowance as large as the piece.
    session.handle(Command::ApplyTrade { id: "plain".into() });
    set(&mut session, "size", Value::Number(10.0));
    set(&mut session, "allowance", Value::Number(30.0));
    let report = session.pattern_report().unwrap();
    assert!(told(&report.notices, "wider than the piece"), "{:?}", report.notices);
    for (id, value) in [("size", 0.0), ("allowance", -1.0), ("allowance", 1e9), ("copies", 1.5)] {
        let value = Value::Number(value);
        let events = session.handle(Command::SetParameter { id: id.into(), value });
        assert_eq!(errors(&events).len(), 1, "{id}");
    }
}

#[test]
fn nesting_goes_on_until_it_is_paused_and_never_wastes_more() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "tennis_ball".into() });
    // Shorter is then less waste: without limits it is the side of a square that is made small.
    set(&mut session, "stock", text("roll"));
    session.handle(Command::ShowPattern { is_shown: true });
    let used = |session: &mut Session| session.pattern_report().unwrap().utilisation;
    let before = used(&mut session);
    session.handle(Command::Nest);
    for _ in 0..12 {
        assert!(session.is_running());
        session.advance(&mut || false);
    }
    assert!(session.pattern_report().unwrap().nesting_steps > 10);
    session.handle(Command::Pause);
    assert!(!session.is_running());
    assert!(used(&mut session) >= before);
    // What lies where is what is written.
    let sheet = session.pattern_sheet().unwrap();
    let svg = String::from_utf8(written(&mut session, "Pattern (SVG)")).unwrap();
    assert!(svg.contains(&format!("id=\"{}\"", sheet.lines[0].id)));
}

#[test]
fn every_file_can_be_had_and_all_are_in_one_archive() {
    let mut session = ball();
    for (kind, head) in [
        ("UV mesh (OBJ)", &b"# Cutflow"[..]),
        ("UV mesh (GLB)", b"glTF"),
        ("Cut surface (PLY)", b"ply"),
        ("Flat mesh (OBJ)", b"# Cutflow"),
        ("Pattern (SVG)", b"<?xml"),
        ("Pattern (DXF)", b"  0"),
        ("Pattern (PDF)", b"%PDF-1."),
        ("Project (JSON)", b"{\"cutflow_project\""),
        ("All files (ZIP)", b"PK"),
    ] {
        let file = session.export(kind).unwrap();
        assert!(file.bytes.starts_with(head), "{kind}: {:?}", &file.bytes[..12]);
        assert_eq!(file.bytes, session.export(kind).unwrap().bytes, "{kind} is the same again");
    }
    let zip = written(&mut session, "All files (ZIP)");
    // Pictures are drawn by the engine, the same for page and command: in the archive, and on the cover of the PDF.
    let listed = String::from_utf8_lossy(&zip);
    assert!(listed.contains("-surface.png") && listed.contains("-pattern.png"), "no pictures");
    let pdf = written(&mut session, "Pattern (PDF)");
    assert!(String::from_utf8_lossy(&pdf).contains("/Subtype /Image"), "no picture on the cover");
    for name in [
        "pattern.svg",
        "pattern_mm.dxf",
        "pattern.pdf",
        "uv.glb",
        "flat.obj",
        "report.json",
        "project.json",
        "pattern.json",
    ] {
        let is_there = zip.windows(name.len()).any(|window| window == name.as_bytes());
        assert!(is_there, "{name} is missing");
    }
    // Baked pieces instead of checks.
    let checks = written(&mut session, "UV mesh (GLB)");
    set(&mut session, "uv_texture", text("atlas"));
    assert!(written(&mut session, "UV mesh (GLB)").len() > checks.len());
}

#[test]
fn each_method_has_its_own_pattern() {
    let mut session = ball();
    let first = written(&mut session, "Pattern (SVG)");
    session.handle(Command::SetMethod { id: "developable".into() });
    session.handle(Command::Run);
    while session.is_running() {
        session.advance(&mut || true);
    }
    assert_ne!(written(&mut session, "Pattern (SVG)"), first);
    session.handle(Command::SetMethod { id: "cutflow".into() });
    assert_eq!(written(&mut session, "Pattern (SVG)"), first);
}

#[test]
fn an_allowance_of_its_own_stays_while_charts_of_the_same_cut_change() {
    let mut session = ball();
    session.handle(Command::SetSeamAllowance { seam: 1, mm: Some(12.0) });
    set(&mut session, "refine", text("dirichlet"));
    assert_eq!(session.pattern_report().unwrap().seams[0].allowance_mm, 12.0);
}

#[test]
fn a_given_cut_is_laid_out_as_it_is_whatever_charts_are_made_of_it() {
    let mut session = ball();
    for _ in 0..3 {
        session.handle(Command::Step);
    }
    let cut = written(&mut session, "Cut (JSON)");
    let mut other = ball();
    let before = other.pattern_report().unwrap().seams[0].length_mm;
    other.lay_out_cut("cut.json", &cut).unwrap();
    let given = other.pattern_report().unwrap().seams[0].length_mm;
    assert!((given - before).abs() > 0.5, "three steps move the cut");
    set(&mut other, "flatten", text("lscm"));
    let again = other.pattern_report().unwrap();
    // The same way on the surface; outlines of this flattening need not have its length.
    assert!((again.seams[0].length_mm - given).abs() < 1e-9 * given);
}

#[test]
fn stopping_says_so_and_what_is_only_drawn_differently_keeps_the_layout() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "tennis_ball".into() });
    session.handle(Command::ShowPattern { is_shown: true });
    session.handle(Command::Nest);
    for _ in 0..4 {
        session.advance(&mut || false);
    }
    let view = shown(&session.handle(Command::Pause)).unwrap();
    assert!(!view.is_nesting);
    let steps = view.report.nesting_steps;
    for (id, value) in
        [("svg_profile", text("laser")), ("paper", text("a3")), ("hints", Value::Truth(true))]
    {
        let view = shown(&set(&mut session, id, value)).unwrap();
        assert_eq!(view.report.nesting_steps, steps, "{id}");
    }
    let view = shown(&set(&mut session, "gap", Value::Number(9.0))).unwrap();
    assert!(view.report.nesting_steps < steps, "another gap is another layout");
}

#[test]
fn margins_that_leave_no_room_and_sizes_for_no_printer_are_told() {
    let mut session = ball();
    session.handle(Command::ShowPattern { is_shown: true });
    set(&mut session, "stock", text("roll"));
    set(&mut session, "stock_margin", Value::Number(100.0));
    let view = shown(&set(&mut session, "stock_width", Value::Number(150.0))).unwrap();
    assert!(
        view.report.notices.iter().any(|n| n.contains("leave no room")),
        "{:?}",
        view.report.notices
    );
    session.handle(Command::ApplyTrade { id: "plain".into() });
    let view = shown(&set(&mut session, "size", Value::Number(1e5))).unwrap();
    assert!(view.report.notices.iter().any(|n| n.contains("no PDF")), "{:?}", view.report.notices);
}
