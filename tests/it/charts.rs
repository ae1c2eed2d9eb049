//! Charts as sessions make them: the choice of a flattening, evening out, outlines, splitting.

use cutflow::session::{
    Charting, Command, Document, Event, Outline, Session, Value, surface_layout,
};

use crate::scripts::{errors, measure, set, status};

fn text(value: &str) -> Value {
    Value::Text(value.into())
}

fn run(session: &mut Session) -> Vec<Event> {
    let mut events = Vec::new();
    while session.is_running() {
        events.extend(session.advance(&mut || false));
    }
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    events
}

/// A sample at the start of its flow.
fn opened(sample: &str) -> Session {
    let mut session = Session::new();
    let events = session.handle(Command::OpenSample { name: sample.into() });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    session
}

/// `flattening` of the session's report.
fn flattening(session: &mut Session) -> serde_json::Value {
    let bytes = session.export("Report (JSON)").unwrap().bytes;
    let report: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    let method = if report.get("cut").is_some() { "cut" } else { "cones" };
    report[method]["flattening"].clone()
}

#[test]
fn every_flattening_can_be_chosen_and_is_named_in_the_report() {
    let mut session = opened("plush_bear");
    let before = flattening(&mut session);
    assert_eq!(before["method"], "bff", "nothing turns over here: the fast way is enough");
    for method in ["conformal", "lscm", "dcp", "abf", "bff"] {
        let events = set(&mut session, "flatten", text(method));
        assert!(errors(&events).is_empty(), "{method}: {:?}", errors(&events));
        let report = flattening(&mut session);
        assert_eq!(report["method"], method);
        let conformality = report["totals"]["angle_distortion"].as_f64().unwrap();
        assert!((1.0..1.1).contains(&conformality), "{method}: {conformality}");
        let keeps_seams = ["bff", "conformal"].contains(&method);
        assert_eq!(report["seams_equal"], keeps_seams, "{method}");
    }
    let events = session.handle(Command::Undo);
    assert!(errors(&events).is_empty());
    // Changes of one parameter after another are one change.
    assert_eq!(flattening(&mut session)["method"], "bff");
    session.handle(Command::Redo);
    assert_eq!(flattening(&mut session)["method"], "bff");
}

#[test]
fn conformal_charts_of_cones_have_their_angles_to_rounding() {
    let mut session = opened("plush_bear");
    session.handle(Command::SetMethod { id: "cones".into() });
    run(&mut session);
    set(&mut session, "flatten", text("conformal"));
    run(&mut session);
    let report = flattening(&mut session);
    assert_eq!(report["method"], "conformal");
    assert_eq!(report["angles_exact"], true);
    assert!(report["conformal"]["angle_error"].as_f64().unwrap() < 1e-10);
    assert_eq!(report["validity"]["flipped"], 0);
    assert_eq!(report["validity"]["overlapping_pairs"], 0);
    assert!(report["validity"]["smallest"]["signed_area"].as_f64().unwrap() > 0.0);
}

#[test]
fn evening_out_goes_step_by_step_lowers_the_stretch_and_can_be_taken_back() {
    let mut session = opened("plush_bear");
    let rough = flattening(&mut session)["totals"]["symmetric_dirichlet"].as_f64().unwrap();
    let events = set(&mut session, "refine", text("dirichlet"));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert!(session.is_running());
    let events = session.advance(&mut || false);
    assert!(status(&events).starts_with("Running step"), "{}", status(&events));
    assert!(session.scene().is_some(), "each step is a picture");
    let events = session.handle(Command::Pause);
    assert!(!session.is_running(), "{}", status(&events));
    // A file is made of charts that are evened out to the end.
    set(&mut session, "refine", text("none"));
    set(&mut session, "refine", text("dirichlet"));
    let report = flattening(&mut session);
    let refined = &report["refined"];
    assert_eq!(refined["energy"], "dirichlet");
    assert!(refined["after"].as_f64().unwrap() < refined["before"].as_f64().unwrap());
    assert!(report["totals"]["symmetric_dirichlet"].as_f64().unwrap() < rough);
    // A tenth of a millimetre in a metre.
    assert!(refined["seam_difference"].as_f64().unwrap() <= 1e-4, "{refined}");
    assert_eq!(report["validity"]["flipped"], 0);
    assert!(!session.is_running(), "that was all of it");
    session.handle(Command::Undo);
    assert!(flattening(&mut session).get("refined").is_none());
}

#[test]
fn outlines_can_be_round_or_rectangular() {
    let mut session = opened("sinusoidal_sheet");
    for outline in ["disk", "rectangle", "length"] {
        let events = set(&mut session, "outline", text(outline));
        assert!(errors(&events).is_empty(), "{outline}: {:?}", errors(&events));
        assert!(measure(&events, "Flipped triangles") < 0.5, "{outline}");
        assert!(measure(&events, "Overlaps") < 0.5, "{outline}");
        let report = flattening(&mut session);
        assert_eq!(report["seams_equal"], outline == "length", "{outline}");
    }
    // A long strip is no disk, and an ear is flat on the side of a rectangle.
    let mut strip = String::new();
    for i in 0..=80 {
        let bend = 0.1 * f64::from(i).sin();
        strip += &format!("v {i} 0 0\nv {i} 2 {bend}\nv {i} 4 0\n");
    }
    for i in 0..80 {
        for a in [3 * i + 1, 3 * i + 2] {
            strip += &format!("f {a} {} {} {}\n", a + 3, a + 4, a + 1);
        }
    }
    // A triangle beside the middle of one side.
    strip += "v 40.5 -0.5 0\nf 121 244 124\n";
    let strip = Document::from_bytes("strip.obj", strip.as_bytes()).unwrap();
    let surface = strip.surface().unwrap();
    for (outline, told) in [
        (Outline::Disk, "distorts angles"),
        (Outline::Rectangle, "1 triangle lies flat on a straight side"),
        (Outline::TrueLength, ""),
    ] {
        let charting = Charting { outline, ..Charting::default() };
        let (layout, _) = surface_layout(surface, None, &charting, "none").unwrap();
        let notice = layout.notice.unwrap_or_default();
        assert!(
            notice.contains(told) && notice.is_empty() == told.is_empty(),
            "{outline:?}: {notice}"
        );
    }
}

#[test]
fn charts_that_overlap_themselves_are_split_unless_that_is_not_wanted() {
    let mut session = opened("plush_bear");
    session.handle(Command::SetMethod { id: "cones".into() });
    set(&mut session, "lambda", Value::Number(0.001));
    run(&mut session);
    let report = flattening(&mut session);
    assert!(report["split"]["charts_added"].as_u64().unwrap() > 0, "{}", report["split"]);
    assert_eq!(report["totals"]["overlaps"], 0);
    let mut events = set(&mut session, "split", Value::Truth(false));
    events.extend(run(&mut session));
    let report = flattening(&mut session);
    assert!(report.get("split").is_none());
    assert!(report["totals"]["overlaps"].as_u64().unwrap() > 0);
    assert!(report["validity"]["worst_pair"]["area"].as_f64().unwrap() > 0.0);
    assert!(measure(&events, "Overlaps") > 0.5, "and the page says so");
}
