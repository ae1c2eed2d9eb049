//! Sessions driven by the commands of the studio: presets, brush, symmetry, fold, fields, cuts that are brought along.

use cutflow::geometry::{SymmetryKind, find_symmetries, symmetry_group};
use cutflow::mesh::VertexId;
use cutflow::session::{Brought, Command, Event, Scene, Session, Surface, SymmetryChoice, Value};
use nalgebra::Point3;
use std::collections::BTreeMap;

use crate::scripts::{ball, errors, set, status};

/// Values of the parameters by the last event that tells them.
fn values(events: &[Event]) -> BTreeMap<String, Value> {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::Parameters { values, .. } => Some(values.clone()),
        _ => None,
    });
    told.next().unwrap()
}

fn text(events: &[Event], id: &str) -> String {
    match &values(events)[id] {
        Value::Text(text) => text.clone(),
        other => panic!("{other:?}"),
    }
}

fn current_preset(events: &[Event]) -> Option<String> {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::Presets { current, .. } => Some(current.clone()),
        _ => None,
    });
    told.next().unwrap()
}

/// Channels that something is painted in.
fn painted(events: &[Event]) -> Vec<String> {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::PaintChannels { options } => Some(options),
        _ => None,
    });
    let all = told.next().unwrap();
    all.iter().filter(|c| !c.is_empty).map(|c| c.id.clone()).collect()
}

fn undo_label(events: &[Event]) -> Option<String> {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::History { undo, .. } => Some(undo.clone()),
        _ => None,
    });
    told.next().unwrap()
}

/// A term of J after the last step that is told.
fn term(events: &[Event], name: &str) -> Option<f64> {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::Energy { terms, .. } => Some(terms),
        _ => None,
    });
    told.next()?.iter().find(|t| t.name == name).map(|t| t.value)
}

fn surface(session: &Session) -> &Surface {
    session.document().unwrap().surface.as_ref().unwrap()
}

/// Places of the mesh's vertices in the scene.
fn places(session: &Session) -> Vec<Point3<f64>> {
    let s = surface(session);
    s.geometry.positions.iter().map(|p| p / s.radius()).collect()
}

/// The face whose middle is next to a place of the scene.
fn face_at(session: &Session, place: [f64; 3]) -> u32 {
    let at = places(session);
    let faces = surface(session).mesh.triangles();
    let away = |t: &[VertexId; 3]| {
        let middle = t.iter().map(|v| at[v.index()].coords).sum::<nalgebra::Vector3<f64>>() / 3.0;
        (middle - Point3::from(place).coords).norm()
    };
    let nearest = (0..faces.len()).min_by(|&a, &b| away(&faces[a]).total_cmp(&away(&faces[b])));
    nearest.unwrap() as u32
}

fn distances(session: &Session, place: [f64; 3]) -> Vec<f64> {
    places(session).iter().map(|p| (p - Point3::from(place)).norm()).collect()
}

fn dab(session: &Session, channel: &str, place: [f64; 3], radius: f64, value: f64) -> Command {
    let face = face_at(session, place);
    Command::Paint { channel: channel.into(), face, place, radius, value, begins: true }
}

/// A stroke of one dab, not yet seen by the flow.
fn stroke(
    session: &mut Session,
    channel: &str,
    place: [f64; 3],
    radius: f64,
    value: f64,
) -> Vec<Event> {
    let command = dab(session, channel, place, radius, value);
    session.handle(command)
}

/// The same, and the flow has caught up.
fn paint(
    session: &mut Session,
    channel: &str,
    place: [f64; 3],
    radius: f64,
    value: f64,
) -> Vec<Event> {
    let mut events = stroke(session, channel, place, radius, value);
    events.extend(session.handle(Command::EndStroke));
    assert!(session.is_running(), "painting is something to catch up with");
    events.extend(session.advance(&mut || true));
    assert!(!session.is_running());
    assert_eq!(errors(&events), Vec::<String>::new());
    events
}

/// That many steps of a run, without a picture.
fn steps(session: &mut Session, count: usize) -> Vec<Event> {
    let mut events = session.handle(Command::Run);
    let end = session.history().last().unwrap().step + count;
    while session.is_running() && session.history().last().unwrap().step < end {
        events.extend(session.advance(&mut || false));
    }
    events.extend(session.handle(Command::Pause));
    assert_eq!(errors(&events), Vec::<String>::new());
    events
}

/// A ball that a plane x = 0 cuts.
fn halves(n: u32) -> Session {
    let mut session = Session::new();
    let events = session.open("ball.obj", ball(n).as_bytes());
    assert_eq!(errors(&events), Vec::<String>::new());
    set(&mut session, "init", Value::Text("plane".into()));
    set(&mut session, "coarse", Value::Truth(false));
    session
}

fn shown(session: &mut Session, field: &str) -> Scene {
    session.handle(Command::ShowField { id: field.into() });
    session.scene().unwrap()
}

const EAST: [f64; 3] = [0.0, 1.0, 0.0];
const WEST: [f64; 3] = [0.0, -1.0, 0.0];
const FRONT: [f64; 3] = [1.0, 0.0, 0.0];

#[test]
fn every_preset_suits_its_sample_and_one_undo_takes_it_back() {
    let mut session = Session::new();
    let events = session.handle(Command::Hello);
    let presets = events.iter().find_map(|event| match event {
        Event::Presets { options, .. } => Some(options.clone()),
        _ => None,
    });
    let presets = presets.unwrap();
    assert_eq!(presets.len(), 7);
    for preset in presets {
        let id = preset.id;
        let before = values(&session.handle(Command::OpenSample { name: preset.sample }));
        let events = session.handle(Command::ApplyPreset { id: id.clone() });
        assert_eq!(errors(&events), Vec::<String>::new(), "{id}");
        assert_eq!(current_preset(&events).as_ref(), Some(&id));
        assert!(undo_label(&events).unwrap().starts_with("preset "), "{id}");
        let after = values(&events);
        for kept in ["unit", "size"] {
            assert_eq!(before[kept], after[kept], "{id}");
        }
        let events = session.handle(Command::Undo);
        assert_eq!(values(&events), before, "{id}");
        let events = session.handle(Command::Redo);
        assert_eq!(values(&events), after, "{id}");
        assert_eq!(current_preset(&events).as_ref(), Some(&id));

        steps(&mut session, 4);
        let rows = session.history();
        // Steps of the coarse copy count as steps too.
        assert!(rows.len() > 2, "{id}: {} rows", rows.len());
        // A falling schedule lowers J all the more.
        assert!(rows.windows(2).all(|w| w[1].total < w[0].total), "{id}: {rows:?}");
    }
    let events = session.handle(Command::ApplyPreset { id: "nonsense".into() });
    assert_eq!(errors(&events).len(), 1);
}

#[test]
fn strokes_of_regions_start_the_cut_anew_and_are_taken_back_one_by_one() {
    let mut session = halves(10);
    session.handle(Command::Step);
    let at_first = (session.labels(), session.history().to_vec());
    let events = stroke(&mut session, "region", FRONT, 0.4, 3.0);
    assert_eq!(text(&events, "init"), "painted");
    assert_eq!(undo_label(&events).as_deref(), Some("paint regions"));
    assert!(!session.is_running() && session.labels() == at_first.0, "not before the stroke ends");
    // More dabs of the same stroke.
    for i in 1..10 {
        let place = [1.0, 0.02 * f64::from(i), 0.0];
        let Command::Paint { channel, face, radius, value, .. } =
            dab(&session, "region", place, 0.4, 3.0)
        else {
            unreachable!()
        };
        session.handle(Command::Paint { channel, face, place, radius, value, begins: false });
    }
    session.handle(Command::EndStroke);
    let events = session.advance(&mut || true);
    assert!(!session.is_running() && errors(&events).is_empty());
    assert_eq!(status(&events), "Ready");
    let one = session.labels();
    let (near, far) = (distances(&session, FRONT), distances(&session, [1.0, 0.18, 0.0]));
    for v in 0..one.len() {
        // The brush reaches along the surface up to its radius; its middle walks 0.18 to the side.
        assert!(near[v] > 0.39 || one[v] == 3, "{v}");
        assert!(near[v] < 0.41 || far[v] < 0.41 || one[v] != 3, "{v}");
        assert!(one[v] == 3 || one[v] == at_first.0[v], "the rest of the cut is as it was");
    }
    paint(&mut session, "region", WEST, 0.4, 4.0);
    let two = session.labels();
    assert!(two.contains(&4) && two.contains(&3));

    let events = session.handle(Command::Undo);
    assert_eq!(errors(&events), Vec::<String>::new());
    assert_eq!((session.labels(), painted(&events)), (one.clone(), vec!["region".to_owned()]));
    let events = session.handle(Command::Undo);
    assert_eq!((session.labels(), session.history().to_vec()), at_first);
    assert_eq!((text(&events, "init").as_str(), painted(&events)), ("plane", vec![]));
    assert_eq!(undo_label(&events).as_deref(), Some("step 1"));
    session.handle(Command::Redo);
    session.handle(Command::Redo);
    assert_eq!(session.labels(), two);
}

#[test]
fn a_stroke_that_the_flow_has_not_seen_survives_undo_and_redo_and_exports_see_it() {
    let mut session = halves(8);
    stroke(&mut session, "region", FRONT, 0.4, 3.0);
    session.handle(Command::Undo);
    assert!(!session.is_running() && !session.labels().contains(&3));
    session.handle(Command::Redo);
    let file = session.export("Cut (JSON)").unwrap();
    assert!(session.labels().contains(&3) && !session.is_running());
    let json: serde_json::Value = serde_json::from_slice(&file.bytes).unwrap();
    let labels = json["vertex_labels"].as_array().unwrap();
    assert!(labels.iter().any(|label| label == 3));
}

#[test]
fn undo_needs_no_paint_that_has_been_cleared() {
    let mut session = halves(8);
    paint(&mut session, "region", FRONT, 0.4, 3.0);
    let labels = session.labels();
    let events = session.handle(Command::ClearPaint { channel: "region".into() });
    assert!(errors(&events).is_empty() && painted(&events).is_empty());
    // The cut that is there can go on; the next start is another one.
    assert_eq!(text(&events, "init"), "normals");
    paint(&mut session, "penalty", EAST, 0.4, 1.0);
    assert_eq!(session.labels(), labels);
    for left in [vec![], vec!["region".to_owned()], vec![]] {
        let events = session.handle(Command::Undo);
        assert_eq!((errors(&events), painted(&events)), (vec![], left));
    }
    // All of one region is no cut.
    let mut session = halves(8);
    let events = stroke(&mut session, "region", FRONT, 9.0, 3.0);
    assert!(errors(&events).is_empty());
    let labels = session.labels();
    session.handle(Command::EndStroke);
    assert_eq!(errors(&session.advance(&mut || true)).len(), 1);
    assert!(!session.is_running() && session.labels() == labels);
    paint(&mut session, "penalty", EAST, 0.4, 1.0);
    for _ in 0..2 {
        assert_eq!(errors(&session.handle(Command::Undo)), Vec::<String>::new());
    }
    assert_eq!(session.labels(), labels);
}

#[test]
fn seeds_are_set_and_taken_away() {
    let mut session = halves(10);
    let before = session.labels();
    // To take one away where there is none changes no cut.
    let events = stroke(&mut session, "seed", EAST, 0.1, 0.0);
    assert!(errors(&events).is_empty() && !session.is_running());
    session.handle(Command::Undo);
    // A single seed is the centre of a circle of geodesic radius 0.3 √A: an angle of 61°.
    let events = paint(&mut session, "seed", EAST, 0.1, 1.0);
    assert_eq!(painted(&events), ["seed"]);
    let (near, circle) = (distances(&session, EAST), session.labels());
    let is_in = |v: usize| circle[v] == circle[(0..near.len()).find(|&v| near[v] < 0.1).unwrap()];
    assert!((0..near.len()).all(|v| is_in(v) == (near[v] < 1.01) || (near[v] - 1.01).abs() < 0.1));
    assert_eq!(text(&events, "init"), "seeds");
    paint(&mut session, "seed", WEST, 0.1, 1.0);
    let (east, west, two) =
        (distances(&session, EAST), distances(&session, WEST), session.labels());
    let label = |d: &[f64]| two[(0..d.len()).min_by(|&a, &b| d[a].total_cmp(&d[b])).unwrap()];
    for v in 0..two.len() {
        // An edge of this ball is 0.11 long.
        if (east[v] - west[v]).abs() > 0.2 {
            assert_eq!(two[v], if east[v] < west[v] { label(&east) } else { label(&west) });
        }
    }
    paint(&mut session, "seed", FRONT, 0.1, 1.0);
    let count = |labels: &[u32]| labels.iter().copied().collect::<std::collections::BTreeSet<_>>();
    assert_eq!(count(&session.labels()).len(), 3);
    // The nearest one goes, wherever exactly the click was.
    paint(&mut session, "seed", [0.9, 0.3, 0.0], 0.1, 0.0);
    assert_eq!(session.labels(), two);
    paint(&mut session, "seed", WEST, 0.1, 0.0);
    assert_eq!(session.labels(), circle);
    // Without any seed the cut stays.
    let events = stroke(&mut session, "seed", EAST, 0.1, 0.0);
    assert!(errors(&events).is_empty() && painted(&events).is_empty() && !session.is_running());
    assert_eq!(session.labels(), circle);
    for _ in 0..6 {
        assert_eq!(errors(&session.handle(Command::Undo)), Vec::<String>::new());
    }
    assert_eq!(session.labels(), before);
}

#[test]
fn painted_heat_becomes_the_source() {
    let mut session = halves(10);
    set(&mut session, "dirichlet", Value::Number(1.0));
    let field = shown(&mut session, "u").values;
    let before = session.history().last().unwrap().total;
    let events = paint(&mut session, "heat", FRONT, 0.5, 1.0);
    assert_eq!(text(&events, "source"), "heat");
    assert!((session.history().last().unwrap().total - before).abs() > 1e-3 * before);
    let scene = shown(&mut session, "u");
    assert!(scene.values != field, "u is the temperature now");
    assert_eq!(scene.field.unwrap().label, "Temperature u");
    let scene = shown(&mut session, "heat");
    let near = distances(&session, FRONT);
    for (v, d) in near.iter().enumerate() {
        let heat = scene.values[v];
        assert!((0.0..=1.0).contains(&heat));
        assert!(*d > 0.25 || heat == 1.0, "flat within half the radius");
        assert!(*d < 0.5 || heat == 0.0, "nothing beyond the radius");
    }
    // More heat there, another J.
    let now = session.history().last().unwrap().total;
    set(&mut session, "heat", Value::Number(100.0));
    assert!((session.history().last().unwrap().total - now).abs() > 1e-3 * now);
    let events = session.handle(Command::ClearPaint { channel: "heat".into() });
    assert!(painted(&events).is_empty());
    session.advance(&mut || true);
    assert!(shown(&mut session, "heat").values.iter().all(|x| *x == 0.0));
}

#[test]
fn a_cut_leaves_what_is_painted_to_be_spared() {
    let mut session = halves(12);
    set(&mut session, "eta", Value::Number(20.0));
    let events = paint(&mut session, "penalty", EAST, 0.4, 1.0);
    let before = term(&events, "Penalty").unwrap();
    // The plane's cut runs through the middle of the paint, 2 · 0.4 · 0.28 long where a radius is 0.28 √A.
    assert!(before > 20.0 * 0.1, "{before}");
    let events = steps(&mut session, 40);
    let after = term(&events, "Penalty").unwrap_or(0.0);
    assert!(after < 0.3 * before, "{after} {before}");
    let row = session.history().last().unwrap();
    assert!(
        (row.total - row.distortion - after - term(&events, "Length α|γ|").unwrap()).abs() < 1e-9
    );
}

#[test]
fn a_cut_stays_where_it_is_pinned() {
    let mut session = halves(12);
    set(&mut session, "dirichlet", Value::Number(10.0));
    set(&mut session, "hencky", Value::Number(0.0));
    set(&mut session, "offset", Value::Number(7.0));
    paint(&mut session, "pin", EAST, 0.6, 1.0);
    let before = session.labels();
    steps(&mut session, 10);
    let (near, after) = (distances(&session, EAST), session.labels());
    let moved: Vec<usize> = (0..after.len()).filter(|&v| after[v] != before[v]).collect();
    assert!(!moved.is_empty(), "the rest moves");
    let held: Vec<f64> = moved.iter().map(|&v| near[v]).filter(|d| *d <= 0.3).collect();
    assert!(held.is_empty(), "{held:?} of {}", moved.len());
}

#[test]
fn what_cannot_be_painted_is_refused_and_changes_nothing() {
    let mut session = halves(8);
    session.handle(Command::Step);
    paint(&mut session, "penalty", EAST, 0.4, 1.0);
    let undo = undo_label(&session.handle(Command::Run));
    session.handle(Command::Pause);
    let state = |session: &Session| (session.labels(), session.history().to_vec());
    let before = state(&session);
    let faces = surface(&session).mesh.face_count() as u32;
    for (channel, face, place, radius, value) in [
        ("nonsense", 0, EAST, 0.1, 1.0),
        ("region", faces, EAST, 0.1, 1.0),
        ("region", 0, EAST, 0.1, 256.0),
        ("region", 0, EAST, 0.1, -1.0),
        ("penalty", 0, [f64::NAN, 0.0, 0.0], 0.1, 1.0),
        ("penalty", 0, [0.0, f64::INFINITY, 0.0], 0.1, 1.0),
        ("heat", 0, EAST, 0.0, 1.0),
        ("heat", 0, EAST, f64::NAN, 1.0),
        ("heat", 0, EAST, -1.0, 1.0),
        ("pin", 0, EAST, 0.1, 2.0),
        ("seed", 0, EAST, 0.1, f64::NAN),
    ] {
        let command =
            Command::Paint { channel: channel.into(), face, place, radius, value, begins: true };
        let events = session.handle(command);
        assert_eq!(errors(&events).len(), 1, "{channel} {face} {place:?} {radius} {value}");
        assert!(!session.is_running() && state(&session) == before);
    }
    for command in [
        Command::ClearPaint { channel: "nonsense".into() },
        Command::PlaceCircle { face: faces, place: EAST },
        Command::PlaceCircle { face: 0, place: [f64::NAN; 3] },
        Command::HideFromCamera { eye: [0.0, f64::NAN, 3.0] },
        Command::SetSymmetry { ids: vec!["mirror-99".into()] },
    ] {
        assert_eq!(errors(&session.handle(command.clone())).len(), 1, "{command:?}");
        assert!(!session.is_running() && state(&session) == before);
    }
    let events = session.bring(Brought::Eye([f64::NAN, 0.0, 0.0]));
    assert_eq!(errors(&events).len(), 1);
    // Nothing of it can be undone: the last change is the one before.
    let events = session.handle(Command::Undo);
    assert_eq!(undo, Some("run from step 1".into()));
    assert!(errors(&events).is_empty());
    assert_eq!(undo_label(&events).as_deref(), Some("paint hide"));

    let mut empty = Session::new();
    let paint = Command::Paint {
        channel: "pin".into(),
        face: 0,
        place: EAST,
        radius: 0.1,
        value: 1.0,
        begins: true,
    };
    for command in [
        paint,
        Command::ClearPaint { channel: "pin".into() },
        Command::PlaceCircle { face: 0, place: EAST },
        Command::HideFromCamera { eye: EAST },
        Command::ApplyPreset { id: "ball".into() },
        Command::FindSymmetries,
        Command::SetSymmetry { ids: Vec::new() },
        Command::Fold,
    ] {
        assert_eq!(errors(&empty.handle(command)), ["No mesh is open."]);
    }
    assert_eq!(errors(&empty.handle(Command::Unfold)), Vec::<String>::new());
}

#[test]
fn painting_does_not_stop_a_run() {
    let mut session = halves(10);
    session.handle(Command::Run);
    for _ in 0..3 {
        session.advance(&mut || false);
    }
    let step = session.history().last().unwrap().step;
    let before = session.history().last().unwrap().total;
    stroke(&mut session, "penalty", EAST, 0.5, 1.0);
    let events = session.advance(&mut || false);
    assert!(session.is_running() && errors(&events).is_empty());
    let measured = session.history().last().unwrap();
    assert_eq!(measured.step, step, "first the flow looks at the paint");
    assert!(measured.total > before + 0.1 && term(&events, "Penalty").is_some());
    let measured = measured.total;
    session.advance(&mut || false);
    let row = session.history().last().unwrap();
    assert!(session.is_running() && row.step == step + 1 && row.total < measured);
    // A region starts the run anew, and it goes on.
    stroke(&mut session, "region", FRONT, 0.4, 3.0);
    session.handle(Command::EndStroke);
    session.advance(&mut || false);
    assert!(session.is_running() && session.history().len() == 1);
    session.advance(&mut || false);
    assert!(session.is_running());
}

#[test]
fn cuts_hide_from_the_camera_and_circles_are_placed_by_hand() {
    let mut session = halves(12);
    let events = session.handle(Command::HideFromCamera { eye: [0.0, 3.0, 0.0] });
    assert_eq!(painted(&events), ["penalty"]);
    assert_eq!(undo_label(&events).as_deref(), Some("hide seams from the camera"));
    session.advance(&mut || true);
    let scene = shown(&mut session, "penalty");
    let (near, far) = (distances(&session, EAST), distances(&session, WEST));
    for v in 0..near.len() {
        let x = scene.values[v];
        assert!((0.0..=1.0).contains(&x));
        assert!(near[v] > 0.5 || x > 0.7, "in front: {x}");
        // The visibility is smoothed over two edges, 0.2 here: beyond the horizon little is left, at the far pole nothing.
        assert!(far[v] > 0.9 || x < 1e-3, "behind: {x}");
    }
    let face = face_at(&session, EAST);
    let events = session.handle(Command::PlaceCircle { face, place: EAST });
    assert_eq!(errors(&events), Vec::<String>::new());
    assert_eq!(text(&events, "init"), "circle");
    let nearest = (0..near.len()).min_by(|&a, &b| near[a].total_cmp(&near[b])).unwrap();
    // The file has a vertex that no face uses in front.
    assert_eq!(values(&events)["vertex"], Value::Number(nearest as f64 + 1.0));
    let labels = session.labels();
    let inside = labels[nearest];
    // A circle of geodesic radius 0.3 √A on a ball of radius 0.282 √A: an angle of 61°, a chord of 1.01.
    assert!((0..labels.len()).all(|v| near[v] < 1.1 || labels[v] != inside));
    assert!((0..labels.len()).all(|v| near[v] > 0.9 || labels[v] == inside));
}

/// Edges whose image is cut where they are not, or the other way round, and edges in all.
fn asymmetry(session: &Session, pick: &dyn Fn(usize) -> bool) -> (usize, usize) {
    let s = surface(session);
    let found = find_symmetries(&s.mesh, &s.geometry, 0.02);
    let mirrors: Vec<_> = found.iter().filter(|x| x.kind == SymmetryKind::Mirror).collect();
    let labels = session.labels();
    let (mut wrong, mut cut) = (0, 0);
    for (_, mirror) in mirrors.iter().enumerate().filter(|(i, _)| pick(*i)) {
        let group = symmetry_group(&s.mesh, &s.geometry, &[**mirror], 2).unwrap();
        let image = |v: VertexId| {
            let (corners, weights) = group[0].image(v);
            corners[(0..3).max_by(|&a, &b| weights[a].total_cmp(&weights[b])).unwrap()]
        };
        for t in s.mesh.triangles() {
            for i in 0..3 {
                let [a, b] = [t[i], t[(i + 1) % 3]];
                let is_cut = |a: VertexId, b: VertexId| labels[a.index()] != labels[b.index()];
                wrong += usize::from(is_cut(a, b) != is_cut(image(a), image(b)));
                cut += usize::from(is_cut(a, b));
            }
        }
    }
    (wrong, cut)
}

fn choices(events: &[Event]) -> Vec<SymmetryChoice> {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::Symmetries { options, is_searched: true, .. } => Some(options.clone()),
        _ => None,
    });
    told.next().unwrap()
}

#[test]
fn the_cut_of_a_chair_stays_the_same_left_and_right() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "armchair".into() });
    let found = choices(&session.handle(Command::FindSymmetries));
    assert_eq!(found.iter().map(|c| c.id.as_str()).collect::<Vec<_>>(), ["mirror-1"]);
    // It is made of two halves.
    assert!(found[0].deviation < 1e-6 && !found[0].on);
    let events = session.handle(Command::SetSymmetry { ids: vec!["mirror-1".into()] });
    assert_eq!(errors(&events), Vec::<String>::new());
    assert!(choices(&events)[0].on);
    steps(&mut session, 8);
    let (wrong, cut) = asymmetry(&session, &|_| true);
    // A few vertices on the plane itself go to one of two sides.
    assert!(cut > 100 && wrong < cut / 50, "{wrong} of {cut}");
    // Undo sets it free again.
    session.handle(Command::Undo);
    let events = session.handle(Command::Undo);
    assert!(!choices(&events)[0].on);
}

#[test]
fn the_cut_of_a_ball_keeps_the_mirrors_that_are_chosen() {
    let mut session = halves(8);
    set(&mut session, "offset", Value::Number(15.0));
    set(&mut session, "dirichlet", Value::Number(3.0));
    set(&mut session, "hencky", Value::Number(0.0));
    steps(&mut session, 8);
    // A mirror whose plane the circle of the start crosses: it leaves the cut free to move.
    let s = surface(&session);
    let found = find_symmetries(&s.mesh, &s.geometry, 0.02);
    let mirrors: Vec<_> = found.iter().filter(|x| x.kind == SymmetryKind::Mirror).collect();
    let chosen = mirrors.iter().position(|m| m.direction.x.abs() < 1e-9).unwrap();
    let (free, _) = asymmetry(&session, &|i| i == chosen);
    let id = format!("mirror-{}", chosen + 1);
    let events = session.handle(Command::SetSymmetry { ids: vec![id.clone()] });
    assert_eq!(errors(&events), Vec::<String>::new());
    assert!(choices(&events).iter().all(|c| c.on == (c.id == id)));
    assert_eq!(session.history().len(), 1, "from a new start");
    steps(&mut session, 8);
    let rows = session.history();
    assert!(rows.len() > 4 && rows.last().unwrap().total < rows[0].total, "{rows:?}");
    let (wrong, cut) = asymmetry(&session, &|i| i == chosen);
    // Vertices on the plane itself go to one of two sides.
    assert!(wrong <= cut / 20 && wrong <= free, "{wrong} of {cut}, {free} without");
    // Another mesh in between forgets nothing.
    session.open("other.obj", ball(6).as_bytes());
    assert!(session.symmetry_choices().is_empty());
    let events = session.handle(Command::Undo);
    assert!(choices(&events).iter().all(|c| c.on == (c.id == id)));
    let events = session.handle(Command::SetSymmetry { ids: Vec::new() });
    assert!(choices(&events).iter().all(|c| !c.on));
}

fn fold(events: &[Event]) -> (bool, usize) {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::Fold { is_on, step, distance_mean, distance_max, stretch } => {
            assert!(distance_mean.is_finite() && distance_max.is_finite() && stretch.is_finite());
            assert!(*distance_mean <= *distance_max && *distance_mean >= 0.0 && *stretch >= 0.0);
            Some((*is_on, *step))
        }
        _ => None,
    });
    told.next().unwrap()
}

#[test]
fn a_fold_is_shown_until_something_else_is() {
    let mut session = halves(8);
    steps(&mut session, 3);
    let flat = session.scene().unwrap();
    let state = (session.labels(), session.history().to_vec());
    let events = session.handle(Command::Fold);
    assert_eq!((errors(&events), fold(&events)), (vec![], (true, 0)));
    assert!(session.is_running());
    let mut slices = 5;
    let events = session.advance(&mut || {
        slices -= 1;
        slices > 0
    });
    assert_eq!(fold(&events), (true, 5));
    assert_eq!(status(&events), "Running step 5 of the fold preview");
    let folded = session.scene().unwrap();
    assert_eq!(folded.positions.len(), flat.positions.len());
    assert!(folded.positions.iter().chain(&folded.normals).all(|x| x.is_finite()));
    assert_ne!(folded.positions, flat.positions);
    // Pause holds it where it is.
    session.handle(Command::Pause);
    assert!(!session.is_running());
    let report = session.fold_report().unwrap();
    assert!(report.steps == 5 && report.distance_mean > 0.0);
    assert!(!session.export("Folded surface (OBJ)").unwrap().bytes.is_empty());
    assert_eq!((session.labels(), session.history().to_vec()), state);
    let events = session.handle(Command::Unfold);
    assert_eq!(fold(&events), (false, 0));
    assert_eq!(session.scene().unwrap().positions, flat.positions);
    assert!(session.export("Folded surface (OBJ)").is_err() && session.fold_report().is_err());

    // Whatever changes the cut ends the preview, and says so.
    let region = dab(&session, "region", FRONT, 0.4, 3.0);
    for command in [
        Command::SetParameter { id: "axis".into(), value: Value::Text("z".into()) },
        Command::SetParameter { id: "straighten".into(), value: Value::Truth(false) },
        Command::SetParameter { id: "snap".into(), value: Value::Truth(true) },
        Command::ApplyPreset { id: "upholstery".into() },
        Command::SetSymmetry { ids: vec!["mirror-1".into()] },
        region,
        Command::Reset,
        Command::Step,
        Command::Run,
        Command::Undo,
        Command::Redo,
    ] {
        session.handle(Command::Fold);
        session.advance(&mut || false);
        session.scene().unwrap();
        let mut events = session.handle(command.clone());
        events.extend(session.advance(&mut || false));
        assert_eq!(errors(&events), Vec::<String>::new(), "{command:?}");
        assert!(!fold(&events).0, "{command:?}");
        let scene = session.scene().unwrap();
        assert!(scene.positions.iter().all(|x| x.is_finite()));
        session.handle(Command::Pause);
    }
}

#[test]
fn every_field_has_values_and_looking_at_it_changes_nothing() {
    let stages = ["flux", "velocity", "extension", "level", "moved", "redistanced"];
    for name in ["ball", "plush_bear"] {
        let start = || {
            let mut session = Session::new();
            session.handle(Command::OpenSample { name: name.into() });
            set(&mut session, "coarse", Value::Truth(false));
            steps(&mut session, 1);
            session
        };
        let (mut looked, mut blind) = (start(), start());
        let events = looked.handle(Command::ShowField { id: "pieces".into() });
        let fields = events.iter().find_map(|event| match event {
            Event::Fields { options, .. } => Some(options.clone()),
            _ => None,
        });
        let fields = fields.unwrap();
        assert_eq!(fields.len(), 18);
        for field in &fields {
            let scene = shown(&mut looked, &field.id);
            if field.id == "pieces" {
                assert!(scene.field.is_none() && scene.values.is_empty());
                continue;
            }
            assert_eq!(scene.values.len(), scene.vertex_count(), "{}", field.id);
            assert!(scene.values.iter().any(|x| x.is_finite()), "{}", field.id);
            assert!(scene.values.iter().all(|x| !x.is_infinite()), "{}", field.id);
            let legend = scene.field.unwrap();
            assert!(legend.id == field.id && legend.label.starts_with(&field.label));
            assert!(legend.range[0] < legend.range[1] && legend.mean.is_finite());
            let told = looked.handle(Command::DismissError).into_iter().find_map(|e| match e {
                Event::Stages { step, stages } => Some((step, stages)),
                _ => None,
            });
            assert_eq!(told.is_some(), stages.contains(&field.id.as_str()), "{}", field.id);
            if let Some((step, stages)) = told {
                assert_eq!(step, 2);
                let number = |label: &str| {
                    let all = stages.iter().flat_map(|s| &s.numbers);
                    all.into_iter().find(|n| n.label == label).unwrap().value.unwrap()
                };
                assert!(number("Crossings of the cut") > 10.0 && number("Time step τ") > 0.0);
                assert!(
                    (number("J before") - looked.history()[1].total).abs()
                        < 1e-9 * number("J before")
                );
                assert!(number("J after") <= number("J before"));
            }
        }
        steps(&mut looked, 2);
        steps(&mut blind, 2);
        assert_eq!(looked.labels(), blind.labels(), "{name}");
        assert_eq!(looked.history(), blind.history(), "{name}");
    }
}

#[test]
fn undo_and_redo_go_through_everything() {
    let mut session = halves(8);
    let regions = dab(&session, "region", FRONT, 0.4, 3.0);
    let pin = dab(&session, "pin", EAST, 0.4, 1.0);
    let heat = dab(&session, "heat", WEST, 0.4, 1.0);
    let face = face_at(&session, WEST);
    let mut commands = vec![
        Command::Step,
        pin,
        Command::Step,
        regions,
        Command::HideFromCamera { eye: [0.0, 0.0, 3.0] },
        Command::SetSymmetry { ids: vec!["mirror-2".into()] },
        Command::Step,
        heat,
        Command::PlaceCircle { face, place: WEST },
        Command::ClearPaint { channel: "pin".into() },
        Command::ApplyPreset { id: "plush".into() },
        Command::Step,
        Command::Reset,
    ];
    let told = |session: &mut Session, mut events: Vec<Event>| {
        events.extend(session.handle(Command::EndStroke));
        events.extend(session.advance(&mut || true));
        assert_eq!(errors(&events), Vec::<String>::new());
        let kept: Vec<String> =
            session.symmetry_choices().into_iter().filter(|c| c.on).map(|c| c.id).collect();
        (session.labels(), session.history().to_vec(), kept)
    };
    let mut states = vec![told(&mut session, Vec::new())];
    let mut layers: Vec<Vec<String>> = Vec::new();
    for command in commands.drain(..) {
        let events = session.handle(command);
        let state = told(&mut session, events);
        states.push(state);
    }
    for i in (0..states.len() - 1).rev() {
        let events = session.handle(Command::Undo);
        layers.push(painted(&events));
        assert_eq!(told(&mut session, events), states[i], "back to {i}");
    }
    assert_eq!(layers.last().unwrap(), &Vec::<String>::new());
    assert_eq!(layers[0], ["region", "penalty", "heat"]);
    for (i, state) in states.iter().enumerate().skip(1) {
        let events = session.handle(Command::Redo);
        let now = painted(&events);
        if let Some(expected) = layers.iter().rev().nth(i) {
            assert_eq!(&now, expected);
        }
        assert_eq!(&told(&mut session, events), state, "forth to {i}");
    }
}
