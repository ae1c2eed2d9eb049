//! Sessions driven by commands, as page and command line drive them.

use cutflow::mesh::read::{Content, obj};
use cutflow::session::{ChangeName, Command, Event, Session, Value};

pub(crate) fn errors(events: &[Event]) -> Vec<String> {
    events
        .iter()
        .filter_map(|event| match event {
            Event::Error { what, place, what_to_do, .. } => {
                assert!(!what.is_empty() && !place.is_empty() && !what_to_do.is_empty());
                Some(what.clone())
            }
            _ => None,
        })
        .collect()
}

pub(crate) fn status(events: &[Event]) -> String {
    let mut texts = events.iter().rev().filter_map(|event| match event {
        Event::Status { text, .. } => Some(text.clone()),
        _ => None,
    });
    texts.next().unwrap()
}

/// The last table of measures: the value now of a row.
pub(crate) fn measure(events: &[Event], label: &str) -> f64 {
    let mut tables = events.iter().rev().filter_map(|event| match event {
        Event::Measures { rows, .. } => Some(rows),
        _ => None,
    });
    let row = tables.next().unwrap().iter().find(|row| row.label == label).unwrap();
    row.now.unwrap()
}

pub(crate) fn set(session: &mut Session, id: &str, value: Value) -> Vec<Event> {
    session.handle(Command::SetParameter { id: id.into(), value })
}

/// A small ball as the text of a file, with a vertex in front that no face uses.
pub(crate) fn ball(n: u32) -> String {
    let soup = cutflow::session::samples::icosphere(n);
    let mut text = String::from("# a ball\nv 9 9 9\n");
    for [x, y, z] in &soup.positions {
        text += &format!("v {x} {y} {z}\n");
    }
    for i in 0..soup.polygon_count() {
        let corners: Vec<String> = soup.polygon(i).iter().map(|v| (v + 2).to_string()).collect();
        text += &format!("f {}\n", corners.join(" "));
    }
    text
}

#[test]
fn open_run_pause_step_export() {
    let mut session = Session::new();
    let text = ball(10);
    let events = session.open("ball.obj", text.as_bytes());
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert_eq!(status(&events), "Ready");
    assert!(session.scene().is_some() && session.scene().is_none(), "a scene is taken once");

    set(&mut session, "init", Value::Text("plane".into()));
    set(&mut session, "dirichlet", Value::Number(10.0));
    let events = set(&mut session, "hencky", Value::Number(0.0));
    assert!(errors(&events).is_empty());
    let start = session.history()[0].total;

    let events = session.handle(Command::Run);
    assert_eq!(status(&events), "Running step 0");
    let mut slices = 5;
    let events = session.advance(&mut || {
        slices -= 1;
        slices > 0
    });
    assert_eq!(status(&events), "Running step 5");
    let preview = session.scene().unwrap();
    assert!(preview.charts.iter().all(|x| x.is_finite()), "both halves are disks: live charts");

    let events = session.handle(Command::Pause);
    assert_eq!(status(&events), "Paused at step 5");
    let events = session.handle(Command::Step);
    assert_eq!(status(&events), "Paused at step 6");
    assert!(session.history().last().unwrap().total < start);
    assert_eq!(measure(&events, "Pieces"), 2.0);
    assert_eq!(measure(&events, "Flipped triangles"), 0.0);
    let length = session.history().last().unwrap().length;
    // At rest the outline is straightened: shorter by what zigzag these large triangles gave it.
    let straight = measure(&events, "Cut length");
    assert!(straight <= length && straight > 0.9 * length, "{straight} {length}");

    // The file's vertices come back first, untouched, the unused one included.
    let file = session.export("UV mesh (OBJ)").unwrap();
    assert_eq!(file.name, "ball-uv.obj");
    let input = obj::read(text.as_bytes()).unwrap().soup;
    let Content { soup: output, notices, .. } = obj::read(&file.bytes).unwrap();
    assert!(notices.is_empty());
    assert_eq!(output.positions[..input.positions.len()], input.positions[..]);
    assert!(output.positions.len() > input.positions.len());
    assert_eq!(output.texture_corners.len(), output.corners.len());
    let svg = String::from_utf8(session.export("Pattern (SVG)").unwrap().bytes).unwrap();
    assert!(svg.contains("mm\"") && svg.contains("viewBox"));
    for kind in ["Cut curves (OBJ)", "Cut (JSON)", "Report (JSON)"] {
        assert!(!session.export(kind).unwrap().bytes.is_empty());
    }
    assert!(session.export("Nothing (XYZ)").is_err());
}

#[test]
fn the_same_script_gives_the_same_bytes() {
    let run = || {
        let mut session = Session::new();
        session.handle(Command::OpenSample { name: "rounded_box".into() });
        for _ in 0..4 {
            session.handle(Command::Step);
        }
        ["UV mesh (OBJ)", "Pattern (SVG)", "Cut (JSON)", "Report (JSON)"]
            .map(|kind| session.export(kind).unwrap().bytes)
    };
    assert_eq!(run(), run());
}

#[test]
fn undo_and_redo_restore_parameters_and_cut() {
    let mut session = Session::new();
    session.open("ball.obj", ball(8).as_bytes());
    set(&mut session, "init", Value::Text("plane".into()));
    session.handle(Command::Step);
    session.handle(Command::Step);
    let labels = session.labels();
    let rows = session.history().to_vec();
    set(&mut session, "length", Value::Number(5.0));
    session.handle(Command::Step);
    assert_ne!(session.history(), rows);
    session.handle(Command::Undo);
    let events = session.handle(Command::Undo);
    assert!(errors(&events).is_empty());
    assert_eq!((session.labels(), session.history().to_vec()), (labels, rows));
    let redo = events.iter().find_map(|event| match event {
        Event::History { redo, .. } => redo.clone(),
        _ => None,
    });
    assert_eq!(redo.as_deref(), Some("change cut length"));
    session.handle(Command::Redo);
    session.handle(Command::Redo);
    assert_eq!(session.history().len(), 4);
}

/// `done`, then `undone`, as they were told last.
fn history(events: &[Event]) -> [Vec<(String, bool)>; 2] {
    let names = |list: &[ChangeName]| -> Vec<(String, bool)> {
        list.iter().map(|change| (change.label.clone(), change.is_other_mesh)).collect()
    };
    let told = events.iter().rev().find_map(|event| match event {
        Event::History { done, undone, .. } => Some([names(done), names(undone)]),
        _ => None,
    });
    told.unwrap()
}

#[test]
fn several_changes_at_once_lead_where_one_after_the_other_would() {
    let prepared = || {
        let mut session = Session::new();
        session.open("first.obj", ball(8).as_bytes());
        set(&mut session, "init", Value::Text("plane".into()));
        session.handle(Command::Step);
        session.open("second.obj", ball(6).as_bytes());
        set(&mut session, "length", Value::Number(5.0));
        let events = session.handle(Command::Step);
        (session, history(&events))
    };
    let (mut leaps, [done, undone]) = prepared();
    let (mut walks, _) = prepared();
    let names: Vec<&str> = done.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        ["step 1", "change cut length", "open second.obj", "step 1", "change initial cut"]
    );
    let meshes: Vec<bool> = done.iter().map(|(_, is_other)| *is_other).collect();
    assert_eq!(meshes, [false, false, true, false, false]);
    assert!(undone.is_empty());

    let there = history(&leaps.handle(Command::Travel { changes: -4 }));
    let mut last = Vec::new();
    for _ in 0..4 {
        last = walks.handle(Command::Undo);
    }
    assert_eq!(there, history(&last));
    assert_eq!(there[0], done[4..]);
    let mut all = done.clone();
    all.reverse();
    assert_eq!(there[1], all[1..]);
    assert_eq!(leaps.labels(), walks.labels());
    assert_eq!(leaps.history(), walks.history());

    // Further than there is, then all the way forth again.
    let [done_at_first, _] = history(&leaps.handle(Command::Travel { changes: -100 }));
    assert!(done_at_first.is_empty());
    let end = leaps.handle(Command::Travel { changes: i32::MAX });
    assert!(errors(&end).is_empty());
    assert_eq!(history(&end), [done, Vec::new()]);
    for _ in 0..4 {
        walks.handle(Command::Redo);
    }
    for kind in ["Cut (JSON)", "Project (JSON)"] {
        assert!(leaps.export(kind).unwrap().bytes == walks.export(kind).unwrap().bytes, "{kind}");
    }
    assert!(errors(&leaps.handle(Command::Travel { changes: 0 })).is_empty());
    assert!(errors(&leaps.handle(Command::Travel { changes: i32::MIN })).is_empty());
}

#[test]
fn a_cut_goes_along_to_a_mesh_that_takes_the_place_of_another() {
    let mut session = Session::new();
    session.open("coarse.obj", ball(8).as_bytes());
    set(&mut session, "init", Value::Text("plane".into()));
    let before: Vec<u32> = session.labels();
    let events = session.open("fine.obj", ball(14).as_bytes());
    let offered = |events: &[Event]| {
        events.iter().find_map(|event| match event {
            Event::KeepOffer { from } => Some(from.clone()),
            _ => None,
        })
    };
    assert_eq!(offered(&events).as_deref(), Some("coarse.obj"));
    assert_eq!(errors(&session.handle(Command::KeepCut)), Vec::<String>::new());
    let share = |labels: &[u32]| {
        labels.iter().filter(|&&label| label == 0).count() as f64 / labels.len() as f64
    };
    // One row of vertices along the plane may fall to either side.
    assert!((share(&session.labels()) - share(&before)).abs() < 0.1);
    assert!(share(&before) > 0.2 && share(&before) < 0.8);
    // It is taken once, and a project holds what it gave.
    assert_eq!(errors(&session.handle(Command::KeepCut)).len(), 1);
    let project = session.export("Project (JSON)").unwrap().bytes;
    let mut again = Session::new();
    again.open("again.json", &project);
    while again.is_running() {
        again.advance(&mut || true);
    }
    assert_eq!(again.labels(), session.labels());
    // A sample has nothing to offer, nor is anything offered to it.
    session.handle(Command::OpenSample { name: "ball".into() });
    assert_eq!(offered(&session.open("other.obj", ball(8).as_bytes())), None);
}

#[test]
fn a_bad_file_leaves_the_document_and_its_run_as_they_were() {
    let mut session = Session::new();
    session.open("ball.obj", ball(8).as_bytes());
    session.handle(Command::Step);
    let before = session.export("UV mesh (OBJ)").unwrap().bytes;
    session.scene().unwrap();
    for (name, bytes) in [
        ("empty.obj", ""),
        ("page.obj", "<!DOCTYPE html><html><body>404</body></html>"),
        ("short.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
        ("point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"),
    ] {
        let events = session.open(name, bytes.as_bytes());
        assert_eq!(errors(&events).len(), 1, "{name}");
        assert!(status(&events).starts_with("Error: "), "{name}");
        assert!(session.scene().is_none(), "{name}");
        let events = session.handle(Command::DismissError);
        assert_eq!(status(&events), "Paused at step 1");
        assert_eq!(session.export("UV mesh (OBJ)").unwrap().bytes, before, "{name}");
    }
}

#[test]
fn commands_without_a_document_say_so() {
    let mut session = Session::new();
    for command in [Command::Run, Command::Step, Command::Reset] {
        assert_eq!(errors(&session.handle(command)), ["No mesh is open."]);
    }
    for command in [Command::Pause, Command::Undo, Command::Redo, Command::Hello] {
        assert!(errors(&session.handle(command)).is_empty());
    }
    assert!(session.export("UV mesh (OBJ)").is_err() && session.scene().is_none());
    assert_eq!(errors(&session.handle(Command::OpenSample { name: "cow".into() })).len(), 1);
}

#[test]
fn an_initial_cut_that_misses_is_refused_and_everything_stays() {
    let mut session = Session::new();
    session.open("ball.obj", ball(8).as_bytes());
    set(&mut session, "init", Value::Text("circle".into()));
    session.handle(Command::Step);
    let before = session.export("UV mesh (OBJ)").unwrap().bytes;
    let (labels, rows) = (session.labels(), session.history().to_vec());
    for (id, value) in [
        // Half a great circle of a ball of unit area is .886: this circle is larger than the ball.
        ("radius", 1.0),
        ("vertex", 5e6),
        ("length", f64::NAN),
    ] {
        let events = set(&mut session, id, Value::Number(value));
        assert_eq!(errors(&events).len(), 1, "{id}");
        assert_eq!((session.labels(), session.history().to_vec()), (labels.clone(), rows.clone()));
        assert_eq!(session.export("UV mesh (OBJ)").unwrap().bytes, before, "{id}");
    }
}

#[test]
fn a_mesh_that_the_initial_cut_does_not_suit_is_opened_all_the_same() {
    // A closed surface whose normals all belong to one cluster does not exist; a mesh of many loose triangles has as
    // many clusters as triangles, and must open at once.
    let mut text = String::new();
    for i in 0..20_000 {
        let (x, y) = (2 * (i % 200), 2 * (i / 200));
        text += &format!("v {x} {y} 0\nv {} {y} 0\nv {x} {} 0\nf -3 -2 -1\n", x + 1, y + 1);
    }
    let mut session = Session::new();
    let events = session.open("dust.obj", text.as_bytes());
    assert!(errors(&events).is_empty());
    assert_eq!(session.info_report().unwrap().components, 20_000);
}

#[test]
fn undo_keeps_the_start_of_a_run() {
    let mut session = Session::new();
    session.open("ball.obj", ball(8).as_bytes());
    let start = |events: &[Event]| {
        let mut tables = events.iter().rev().filter_map(|event| match event {
            Event::Measures { rows, .. } => Some(rows),
            _ => None,
        });
        let row = tables.next().unwrap().iter().find(|row| row.id == "cut_length").cloned();
        row.unwrap().start.unwrap()
    };
    let events = session.handle(Command::Step);
    let clusters = start(&events);
    let events = set(&mut session, "init", Value::Text("plane".into()));
    assert!((start(&events) - clusters).abs() > 0.1);
    let events = session.handle(Command::Undo);
    assert!((start(&events) - clusters).abs() < 1e-12, "the start belongs to the run");
}

#[test]
fn every_field_can_be_painted_on_every_sample() {
    for sample in cutflow::session::samples::SAMPLES {
        let mut session = Session::new();
        let events = session.handle(Command::OpenSample { name: sample.name.into() });
        assert!(errors(&events).is_empty(), "{}: {:?}", sample.name, errors(&events));
        for field in ["u", "curvature", "area", "angle", "pieces"] {
            session.handle(Command::ShowField { id: field.into() });
            let scene = session.scene().unwrap();
            assert_eq!(scene.field.is_some(), field != "pieces");
            assert_eq!(
                scene.values.len(),
                if field == "pieces" { 0 } else { scene.vertex_count() }
            );
            if let Some(legend) = scene.field {
                assert!(legend.range[0] < legend.range[1] && legend.mean.is_finite());
            }
            let count = scene.vertex_patches.len() as u32;
            assert!(scene.triangles.iter().chain(&scene.rims).all(|&v| v < count));
            assert!(scene.positions.iter().chain(&scene.normals).all(|x| x.is_finite()));
        }
    }
}

#[test]
fn partners_across_a_cut_are_equally_long_in_the_charts() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "rounded_box".into() });
    session.handle(Command::Step);
    let layout = session.layout().unwrap();
    assert!(layout.flattening.seams_equal);
    let mesh = &layout.opened.mesh;
    let length = |h| {
        let [a, b]: [[f64; 2]; 2] =
            [mesh.tail(h), mesh.tip(h)].map(|v: cutflow::mesh::VertexId| layout.charts[v.index()]);
        (a[0] - b[0]).hypot(a[1] - b[1])
    };
    for f in mesh.faces() {
        for h in mesh.face_halfedges(f) {
            if let Some(partner) = layout.opened.partner(h) {
                // 1e-10 of the surface's size.
                assert!((length(h) - length(partner)).abs() < 1e-10);
            }
        }
    }
}
