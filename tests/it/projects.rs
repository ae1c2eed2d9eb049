//! Projects: what was done is done again, to the same bytes.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "tests may panic")]

use cutflow::session::{Command, Event, Session, Value};

const PROJECT: &str = "Project (JSON)";

fn run(session: &mut Session, most: usize) {
    let mut left = most;
    while session.is_running() && left > 0 {
        session.advance(&mut || {
            left -= 1;
            left > 0
        });
    }
}

fn replayed(project: &[u8]) -> Session {
    let mut again = Session::new();
    let events = again.open("a-project.json", project);
    assert!(!events.iter().any(|event| matches!(event, Event::Error { .. })), "{events:?}");
    while again.is_running() {
        let events = again.advance(&mut || true);
        assert!(!events.iter().any(|event| matches!(event, Event::Error { .. })), "{events:?}");
    }
    again
}

fn assert_same(session: &mut Session, kinds: &[&str]) {
    let project = session.export(PROJECT).unwrap().bytes;
    let mut again = replayed(&project);
    for kind in kinds {
        let [own, other] = [&mut *session, &mut again].map(|s| s.export(kind).unwrap().bytes);
        assert!(own == other, "{kind} differs");
    }
    // What was replayed is a project of its own, and the same one but for the pause that ends it.
    assert!(again.export(PROJECT).unwrap().bytes.len() >= project.len());
}

fn set(session: &mut Session, id: &str, value: Value) {
    session.handle(Command::SetParameter { id: id.into(), value });
}

#[test]
fn a_cut_that_was_steered_by_hand_comes_back_to_the_last_bit() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "ball".into() });
    session.handle(Command::Run);
    run(&mut session, 7);
    set(&mut session, "length", Value::Number(1.5));
    run(&mut session, 4);
    session.handle(Command::Pause);
    set(&mut session, "hencky", Value::Number(100.0));
    session.handle(Command::Undo);
    session.handle(Command::Step);
    assert_same(&mut session, &["Cut (JSON)", "Cut curves (OBJ)"]);
    // In the middle of a run.
    session.handle(Command::Run);
    run(&mut session, 3);
    assert_same(&mut session, &["Cut (JSON)", "Cut curves (OBJ)"]);
}

#[test]
fn what_undo_took_back_is_in_no_project() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "ball".into() });
    session.handle(Command::Run);
    run(&mut session, 5);
    session.handle(Command::Pause);
    session.handle(Command::Undo);
    let text = String::from_utf8(session.export(PROJECT).unwrap().bytes).unwrap();
    assert!(!text.contains("\"run\""), "{text}");
    session.handle(Command::Redo);
    assert_same(&mut session, &["Cut (JSON)"]);
}

#[test]
fn a_mesh_of_ones_own_is_in_the_project_bit_for_bit() {
    let source = "o thing\nv 0 0 0.1\nv 1 0 -0.3333333333333333\nv 1 1 1e-300\nv 0 1 0\nv 9 9 9\ng left\nf 1 2 3\ng right\nf 1 3 4\n";
    let mut session = Session::new();
    session.open("thing.obj", source.as_bytes());
    set(&mut session, "size", Value::Number(123.0));
    assert_same(&mut session, &["Mesh (OBJ)", "UV mesh (OBJ)"]);
}

#[test]
fn projects_that_cannot_be_read_are_refused_in_three_parts_and_lose_nothing() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "ball".into() });
    let before = session.export("Mesh (OBJ)").unwrap().bytes;
    for (text, word) in [
        ("{\"cutflow_project\": 99, \"mesh\": 7}", "newer"),
        ("{\"cutflow_project\": 1, \"mesh\": {\"name\": \"x.obj\"}}", "holds no mesh"),
        ("{\"cutflow_project\": 1, \"mesh\": {\"name\": \"x\", \"sample\": \"moon\"}}", "moon"),
        ("{\"cutflow_project\": 1,", "not a complete project"),
    ] {
        let events = session.open("p.json", text.as_bytes());
        let told = events.iter().find_map(|event| match event {
            Event::Error { what, place, what_to_do } => Some([what, place, what_to_do]),
            _ => None,
        });
        let told = told.unwrap();
        assert!(told[0].contains(word), "{told:?}");
        assert!(told.iter().all(|part| !part.is_empty()));
        assert_eq!(session.export("Mesh (OBJ)").unwrap().bytes, before);
    }
}

#[test]
fn a_cut_that_was_laid_out_as_it_is_comes_back() {
    let mut first = Session::new();
    first.handle(Command::OpenSample { name: "ball".into() });
    first.handle(Command::Run);
    run(&mut first, 5);
    first.handle(Command::Pause);
    let cut = first.export("Cut (JSON)").unwrap().bytes;

    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "ball".into() });
    session.lay_out_cut("cut.json", &cut).unwrap();
    assert_same(&mut session, &["Cut (JSON)", "UV mesh (OBJ)"]);
    // Another cut than the one that the sample starts with.
    let mut fresh = Session::new();
    fresh.handle(Command::OpenSample { name: "ball".into() });
    assert!(
        fresh.export("Cut (JSON)").unwrap().bytes != session.export("Cut (JSON)").unwrap().bytes
    );
}

#[test]
fn uv_seams_that_were_laid_out_as_they_are_come_back() {
    let mesh = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\nf 1/1 2/2 3/3\nf 1/4 3/5 4/1\n";
    let mut session = Session::new();
    session.open("square.obj", mesh.as_bytes());
    session.lay_out_uv_seams().unwrap();
    assert_eq!(session.layout().unwrap().opened.patch_count, 2);
    assert_same(&mut session, &["Cut (JSON)"]);
}

#[test]
fn what_an_export_catches_up_with_is_done_again() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "ball".into() });
    set(&mut session, "init", Value::Text("painted".into()));
    for (face, place) in [(0, [0.0, 1.0, 0.0]), (1, [0.2, 0.9, 0.1])] {
        session.handle(Command::Paint {
            channel: "region".into(),
            face,
            place,
            radius: 0.7,
            value: 1.0,
            begins: face == 0,
        });
    }
    // In the middle of the stroke.
    session.export("Cut (JSON)").unwrap();
    session.handle(Command::Run);
    run(&mut session, 3);
    assert_same(&mut session, &["Cut (JSON)"]);
}

#[test]
fn keys_of_later_versions_are_passed_over_and_what_cannot_be_done_again_is_told() {
    let mut session = Session::new();
    session.open("two.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    set(&mut session, "size", Value::Number(123.0));
    let text = String::from_utf8(session.export(PROJECT).unwrap().bytes).unwrap();
    let more = text.replacen('{', "{\"colour\": [1, {\"a\": null}], \"of_tomorrow\": true,", 1);
    let mut again = replayed(more.as_bytes());
    assert_eq!(again.export("Mesh (OBJ)").unwrap(), session.export("Mesh (OBJ)").unwrap());
    // A command that there is not yet.
    let unknown = text.replacen("set_parameter", "set_fire", 1);
    assert_ne!(unknown, text);
    let mut fresh = Session::new();
    let events = fresh.open("p.json", unknown.as_bytes());
    let is_told = |e: &Event| matches!(e, Event::Error { what, .. } if what.contains("set_fire"));
    assert!(events.iter().any(is_told), "{events:?}");
    assert!(fresh.document().is_none());
}

#[test]
fn a_project_that_is_cut_off_anywhere_is_refused_in_words() {
    let mut session = Session::new();
    session.open("two.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    set(&mut session, "size", Value::Number(123.0));
    let whole = session.export(PROJECT).unwrap().bytes;
    let end = whole.trim_ascii_end().len();
    let before = session.digest();
    for length in (1..end).step_by(7).chain([end - 1]) {
        let events = session.open("p.json", &whole[..length]);
        let told = events.iter().find_map(|event| match event {
            Event::Error { what, place, what_to_do } => Some([what, place, what_to_do]),
            _ => None,
        });
        let told = told.unwrap_or_else(|| panic!("{length} of {end} bytes are taken"));
        assert!(told.iter().all(|part| !part.is_empty()), "{told:?}");
        assert_eq!(session.digest(), before, "{length} of {end} bytes");
    }
}

#[test]
fn what_was_done_after_a_step_that_failed_is_done_again() {
    let mut session = Session::new();
    session.open("two.obj", b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    // Two triangles cannot become fewer: the tool says so, and changes nothing.
    let values = [("faces".to_owned(), 4.0)].into();
    session.handle(Command::Prepare { tool: "decimate".into(), values });
    let mut told = Vec::new();
    while session.is_running() {
        told.extend(session.advance(&mut || true));
    }
    assert!(told.iter().any(|event| matches!(event, Event::Error { .. })), "{told:?}");
    set(&mut session, "size", Value::Number(123.0));
    let project = session.export(PROJECT).unwrap().bytes;
    let mut again = Session::new();
    again.open("a-project.json", &project);
    while again.is_running() {
        again.advance(&mut || true);
    }
    assert_eq!(again.digests(), session.digests());
}

#[test]
fn what_a_refused_command_put_an_end_to_is_at_an_end_in_a_replay_too() {
    let start = || {
        let mut session = Session::new();
        session.handle(Command::OpenSample { name: "ball".into() });
        session
    };
    // A mesh that was being made anew.
    let mut session = start();
    let values =
        [("edge".to_owned(), 2.0), ("adaptivity".to_owned(), 0.0), ("crease".to_owned(), 40.0)];
    session.handle(Command::Prepare { tool: "remesh".into(), values: values.into() });
    run(&mut session, 1);
    session.handle(Command::OpenSample { name: "nothing of that name".into() });
    session.handle(Command::Run);
    run(&mut session, 3);
    session.handle(Command::Pause);
    assert_same(&mut session, &["Mesh (OBJ)", "Cut (JSON)"]);
    // A stroke.
    let mut session = start();
    let (face, place) = (0, [0.0, 1.0, 0.0]);
    let channel = "region".into();
    session.handle(Command::Paint { channel, face, place, radius: 0.7, value: 1.0, begins: true });
    session.handle(Command::ApplyPreset { id: "nothing of that name".into() });
    run(&mut session, 3);
    assert_same(&mut session, &["Cut (JSON)"]);
}
