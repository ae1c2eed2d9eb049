//! Sessions that look for cones, as page and command line drive them.

use std::f64::consts::PI;

use cutflow::session::{Brought, Command, ConeTable, Event, Method, Session, Value};

use crate::scripts::{errors, measure, set, status};

fn run(session: &mut Session) -> Vec<Event> {
    let mut events = Vec::new();
    while session.is_running() {
        events.extend(session.advance(&mut || true));
    }
    events
}

fn cones(events: &[Event]) -> ConeTable {
    let mut tables = events.iter().rev().filter_map(|event| match event {
        Event::Cones(table) => Some(table.clone()),
        _ => None,
    });
    tables.next().expect("cones are told of")
}

/// A session with a sample whose cones are found.
fn solved(sample: &str) -> (Session, Vec<Event>) {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: sample.into() });
    let mut events = session.handle(Command::SetMethod { id: "cones".into() });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    (session, events)
}

fn total(table: &ConeTable) -> f64 {
    table.cones.iter().map(|cone| cone.angle).sum()
}

#[test]
fn choosing_the_method_finds_cones_joins_them_and_flattens() {
    let (mut session, events) = solved("plush_bear");
    assert!(status(&events).starts_with("Converged after"), "{}", status(&events));
    let table = cones(&events);
    assert!(table.cones.len() >= 3 && table.raw_count >= table.cones.len());
    assert!(table.kkt_residual < 1e-8, "{:e}", table.kkt_residual);
    // A closed surface of genus 0; rounding of a hundred angles.
    assert!((total(&table) - 4.0 * PI).abs() < 1e-9);
    // One disk, or more where it overlapped itself.
    assert!(measure(&events, "Pieces") >= 1.0);
    assert!(measure(&events, "Overlaps") < 0.5);
    assert!(measure(&events, "Cut length") > 0.0);
    assert!(measure(&events, "Flipped triangles") < 0.5);
    let scene = session.scene().unwrap();
    assert_eq!(scene.cone_angles.len(), table.cones.len());
    assert_eq!(scene.cone_points.len(), 3 * table.cones.len());
    // Every cone is on a rim, so that it has a place on the chart.
    for cone in 0..table.cones.len() as u32 {
        assert!(scene.cone_charts.chunks(2).any(|pair| pair[1] == cone), "cone {cone}");
    }
    assert_eq!(scene.field.unwrap().id, "u");
    for kind in ["UV mesh (OBJ)", "Cut curves (OBJ)", "Pattern (SVG)", "Cones (JSON)", "Cut (JSON)"]
    {
        assert!(!session.export(kind).unwrap().bytes.is_empty(), "{kind}");
    }
}

#[test]
fn a_cheaper_angle_brings_more_cones_and_undo_takes_them_back() {
    let (mut session, events) = solved("plush_bear");
    let few = cones(&events);
    let mut events = set(&mut session, "lambda", Value::Number(0.003));
    events.extend(run(&mut session));
    let many = cones(&events);
    assert!(few.raw_count < many.raw_count);
    assert!(few.raw_int_u2 > many.raw_int_u2);
    let mut events = session.handle(Command::Undo);
    events.extend(run(&mut session));
    let again = cones(&events);
    assert_eq!(again.raw_count, few.raw_count);
    // The optimum is unique; the way to it was another.
    assert!((again.raw_int_u2 - few.raw_int_u2).abs() < 1e-9 * few.raw_int_u2);
}

#[test]
fn a_held_slider_moves_cones_and_makes_charts_when_it_is_let_go() {
    let (mut session, events) = solved("plush_bear");
    let before = cones(&events).cones.len();
    let cut_length = measure(&events, "Cut length");
    session.handle(Command::Hold { is_held: true });
    let mut events = set(&mut session, "lambda", Value::Number(0.003));
    events.extend(run(&mut session));
    assert!(cones(&events).cones.len() > before);
    assert!(!events.iter().any(|event| matches!(event, Event::Measures { .. })), "no new charts");
    assert!(status(&events).starts_with("Converged after"), "{}", status(&events));
    session.handle(Command::Hold { is_held: false });
    assert!(session.is_running(), "charts are due");
    let events = run(&mut session);
    assert!(measure(&events, "Cut length") > cut_length);
}

#[test]
fn cones_can_be_chosen_by_their_number_by_total_angle_and_by_distortion() {
    let (mut session, events) = solved("plush_bear");
    let start = cones(&events);
    set(&mut session, "choose_by", Value::Text("angle".into()));
    let mut events = set(&mut session, "angle_target", Value::Number(6.0));
    events.extend(run(&mut session));
    let table = cones(&events);
    assert!((table.total_angle / PI - 6.0).abs() < 0.3, "{}", table.total_angle / PI);
    set(&mut session, "choose_by", Value::Text("distortion".into()));
    let wanted = 0.5 * start.raw_int_u2;
    let mut events = set(&mut session, "distortion_target", Value::Number(wanted));
    events.extend(run(&mut session));
    let table = cones(&events);
    assert!(table.raw_int_u2 <= wanted * 1.01 && table.raw_int_u2 > 0.8 * wanted);
    set(&mut session, "choose_by", Value::Text("count".into()));
    let mut events = set(&mut session, "cone_count", Value::Number(12.0));
    events.extend(run(&mut session));
    let table = cones(&events);
    assert!(table.cones.len() <= 12 && table.cones.len() >= 3, "{}", table.cones.len());
}

#[test]
fn angles_typed_by_hand_keep_gauss_bonnet_and_are_exact_on_the_chart() {
    let (mut session, events) = solved("plush_bear");
    let before = cones(&events);
    let wanted = 0.75 * PI;
    let mut events = session.handle(Command::SetConeAngle { cone: 1, angle: Some(wanted) });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    events.extend(run(&mut session));
    let table = cones(&events);
    assert!((table.cones[1].angle - wanted).abs() < 1e-12);
    assert_eq!(table.cones[1].kind, "fixed");
    assert!(table.is_edited);
    assert!((total(&table) - total(&before)).abs() < 1e-9);
    // What is left of the full turn is the angle of the chart around the cone, over all its places.
    let scene_angle = session.layout().map(chart_angle_at(table.cones[1].vertex)).unwrap();
    assert!((scene_angle - (2.0 * PI - wanted)).abs() < 1e-9, "{scene_angle}");
    // More than a full turn cannot be taken out of a surface.
    let refused = session.handle(Command::SetConeAngle { cone: 1, angle: Some(7.0) });
    assert_eq!(errors(&refused).len(), 1);
    let mut events = session.handle(Command::ClearCones);
    events.extend(run(&mut session));
    assert!(!cones(&events).is_edited);
    assert_eq!(cones(&events).cones.len(), before.cones.len());
}

/// The angle that charts have around a vertex of the mesh, over all its copies.
fn chart_angle_at(vertex: u32) -> impl FnOnce(&cutflow::session::Layout) -> f64 {
    move |layout| {
        let opened = &layout.opened;
        let mut sum = 0.0;
        for face in opened.mesh.faces() {
            let corners = opened.mesh.face_vertices(face);
            for i in 0..3 {
                if opened.vertex_points[corners[i].index()] != vertex {
                    continue;
                }
                let [a, b, c] =
                    [0, 1, 2].map(|k| layout.flattening.uv[corners[(i + k) % 3].index()]);
                let (p, q) = (b - a, c - a);
                sum += p.perp(&q).atan2(p.dot(&q));
            }
        }
        sum
    }
}

#[test]
fn cones_are_added_moved_and_removed() {
    let (mut session, events) = solved("plush_bear");
    let before = cones(&events);
    let scene = session.scene().unwrap();
    let face = 40;
    let corner = scene.triangles[3 * face] as usize;
    let place = [0, 1, 2].map(|i| f64::from(scene.positions[3 * corner + i]));
    let face = scene.triangle_faces[face];
    let mut events = session.handle(Command::AddCone { face, place, angle: None });
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let table = cones(&events);
    let free = table.cones.iter().find(|cone| cone.kind == "free").unwrap();
    // Angle that costs nothing is used.
    assert!(free.angle.abs() > 1e-6);
    let (added, vertex) = (free.cone, free.vertex);
    let other = table.cones.iter().find(|cone| cone.kind != "free").unwrap();
    let target = scene.triangle_faces[scene.triangle_faces.len() / 2];
    let at = 3 * scene.triangles[3 * (scene.triangle_faces.len() / 2)] as usize;
    let place = [0, 1, 2].map(|i| f64::from(scene.positions[at + i]));
    let mut events = session.handle(Command::MoveCone { cone: other.cone, face: target, place });
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let moved = cones(&events);
    assert_eq!(moved.cones.len(), table.cones.len());
    assert!(moved.cones.iter().all(|cone| cone.vertex != other.vertex));
    assert!((total(&moved) - total(&before)).abs() < 1e-9);
    let free = moved.cones.iter().find(|cone| cone.vertex == vertex).unwrap();
    let mut events = session.handle(Command::RemoveCone { cone: free.cone });
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert!(cones(&events).cones.iter().all(|cone| cone.vertex != vertex), "{added}");
    assert!((total(&cones(&events)) - total(&before)).abs() < 1e-9);
}

#[test]
fn the_path_over_lambda_falls_in_angle_and_rises_in_distortion() {
    let (mut session, _) = solved("plush_bear");
    let mut events = session.handle(Command::TracePath);
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let (points, is_complete) = events
        .iter()
        .rev()
        .find_map(|event| match event {
            Event::ConePath { points, is_complete } => Some((points.clone(), *is_complete)),
            _ => None,
        })
        .unwrap();
    // The path ends where hundreds of vertices are cones.
    assert!(is_complete && points.len() >= 4, "{}", points.len());
    // It begins at the largest λ, which is known from then on.
    let table = cones(&events);
    assert!(table.is_lambda_max_exact && (table.lambda_max - points[0].lambda).abs() < 1e-9);
    for pair in points.windows(2) {
        assert!(pair[0].lambda > pair[1].lambda);
        assert!(pair[1].total_angle >= pair[0].total_angle - 1e-9);
        assert!(pair[1].int_u2 <= pair[0].int_u2 + 1e-9);
    }
}

#[test]
fn the_greedy_baseline_is_worse_at_more_angle_or_more_distortion() {
    let (mut session, _) = solved("plush_bear");
    let mut events = session.handle(Command::CompareCones);
    events.extend(run(&mut session));
    let rows = events
        .iter()
        .find_map(|event| match event {
            Event::ConeComparison { rows } => Some(rows.clone()),
            _ => None,
        })
        .unwrap();
    assert_eq!(rows.len(), 3);
    assert!(rows[2].int_u2 <= rows[0].int_u2 * (1.0 + 1e-9));
    assert_eq!(rows[0].count, rows[1].count);
    assert!(rows[1].int_u2 > rows[0].int_u2 || rows[1].total_angle > rows[0].total_angle);
    assert!(rows.iter().all(|row| row.chart_angle.is_some_and(|x| x >= 1.0)));
}

fn known_path(events: &[Event]) -> Option<(usize, bool)> {
    events.iter().rev().find_map(|event| match event {
        Event::ConePath { points, is_complete } => Some((points.len(), *is_complete)),
        _ => None,
    })
}

fn compared(events: &[Event]) -> Option<usize> {
    events.iter().rev().find_map(|event| match event {
        Event::ConeComparison { rows } => Some(rows.len()),
        _ => None,
    })
}

#[test]
fn undo_brings_the_path_and_the_comparison_of_the_cones_back() {
    let (mut session, _) = solved("plush_bear");
    let mut events = session.handle(Command::TracePath);
    events.extend(run(&mut session));
    let path = known_path(&events).unwrap();
    assert!(path.0 > 3 && path.1, "{path:?}");
    let mut events = session.handle(Command::CompareCones);
    events.extend(run(&mut session));
    assert_eq!(compared(&events), Some(3));
    // Another price is another choice along the same path; other bounds are another problem.
    for (id, value, is_same_problem) in
        [("lambda", Value::Number(0.02), true), ("bounds", Value::Text("quarter".into()), false)]
    {
        let mut events = set(&mut session, id, value);
        events.extend(run(&mut session));
        assert!(errors(&events).is_empty(), "{id}: {:?}", errors(&events));
        let report = session.cones_report(None).unwrap();
        assert!(report.comparison.is_empty(), "{id}: of other cones");
        assert_eq!(!report.path.is_empty(), is_same_problem, "{id}");
        let mut events = session.handle(Command::Undo);
        events.extend(run(&mut session));
        assert_eq!(known_path(&events), Some(path), "{id}");
        assert_eq!(compared(&events), Some(3), "{id}");
        let report = session.cones_report(None).unwrap();
        assert_eq!((report.path.len(), report.comparison.len()), (path.0, 3), "{id}");
    }
}

#[test]
fn places_painted_as_forbidden_hold_no_cones_and_important_ones_less_distortion() {
    let (mut session, events) = solved("plush_bear");
    let first = cones(&events).cones[0].clone();
    let count = session.document().unwrap().soup.positions.len();
    let mut values = vec![0.0; count];
    values[first.vertex as usize] = 1.0;
    let mut events = session.bring(Brought::Layer { channel: "excluded", values: &values });
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert!(cones(&events).cones.iter().all(|cone| cone.vertex != first.vertex));
}

#[test]
fn a_file_of_cones_is_used_as_it_is() {
    let (mut session, events) = solved("plush_bear");
    let table = cones(&events);
    let bytes = session.export("Cones (JSON)").unwrap().bytes;
    let mut other = Session::new();
    other.handle(Command::OpenSample { name: "plush_bear".into() });
    let mut events = other.open("cones.json", &bytes);
    events.extend(run(&mut other));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert_eq!(other.method(), Method::Cones);
    let again = cones(&events);
    assert_eq!(again.cones.len(), table.cones.len());
    assert!((again.int_u2 - table.int_u2).abs() < 1e-9 * table.int_u2);
    // A surface that it was not made for.
    let mut other = Session::new();
    other.handle(Command::OpenSample { name: "ball".into() });
    assert_eq!(errors(&other.open("cones.json", &bytes)).len(), 1);
}

#[test]
fn a_file_of_no_cones_is_read_where_it_was_written() {
    // Convex everywhere: none are chosen, though a surface like that cannot be without.
    let (mut session, events) = solved("ball");
    assert!(cones(&events).cones.is_empty());
    let bytes = session.export("Cones (JSON)").unwrap().bytes;
    let own = session.export("Cut (JSON)").unwrap();
    let mut events = session.open("cones.json", &bytes);
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert!(cones(&events).cones.is_empty());
    assert_eq!(session.export("Cones (JSON)").unwrap().bytes, bytes);
    assert_eq!(session.export("Cut (JSON)").unwrap(), own);
    // Elsewhere they have to add up.
    let (mut bear, _) = solved("plush_bear");
    let text = String::from_utf8(bear.export("Cones (JSON)").unwrap().bytes).unwrap();
    let start = text.find("\"cones\":").unwrap();
    let empty = format!("{}\"cones\": []}}", &text[..start]);
    assert_eq!(errors(&bear.open("cones.json", empty.as_bytes())).len(), 1);
}

#[test]
fn surfaces_that_are_flat_convex_or_open_say_what_it_means_for_cones() {
    let (_, events) = solved("ball");
    assert!(cones(&events).note.unwrap().contains("convex"), "the ball");
    let mut session = Session::new();
    session.handle(Command::SetMethod { id: "cones".into() });
    let mut events = session.open("tube.obj", tube().as_bytes());
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let table = cones(&events);
    assert!(table.cones.is_empty() && table.note.is_some(), "the tube");
    let (_, events) = solved("car_hood");
    assert!(errors(&events).is_empty());
}

#[test]
fn going_back_while_a_path_is_traced_leaves_the_price_that_was_asked_for() {
    let (mut session, events) = solved("plush_bear");
    let before = cones(&events);
    set(&mut session, "lambda", Value::Number(0.006));
    run(&mut session);
    session.handle(Command::TracePath);
    // A few samples only.
    for _ in 0..6 {
        session.advance(&mut || false);
    }
    let mut events = session.handle(Command::Undo);
    events.extend(run(&mut session));
    let after = cones(&events);
    assert_eq!((after.lambda, after.raw_count), (before.lambda, before.raw_count));
    assert_eq!(after.cones.len(), before.cones.len());
}

#[test]
fn what_cannot_be_placed_is_refused_and_leaves_everything_as_it_was() {
    let mut session = Session::new();
    session.handle(Command::SetMethod { id: "cones".into() });
    let mut events = session.open("tube.obj", tube().as_bytes());
    events.extend(run(&mut session));
    // On the boundary, whose lengths are given; twice at a vertex; more than a full turn.
    for (vertex, angle) in [(0.0, None), (30.0, Some(20.0)), (1e9, None), (30.5, None)] {
        let events = session.bring(Brought::Cone { vertex, angle });
        assert_eq!(errors(&events).len(), 1, "{vertex}");
        assert!(!session.is_running());
    }
    let mut events = session.bring(Brought::Cone { vertex: 30.0, angle: Some(1.0) });
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    // The optimum may add others around it.
    let fixed = cones(&events).cones.into_iter().find(|cone| cone.kind == "fixed").unwrap();
    assert_eq!((fixed.vertex, fixed.angle), (30, 1.0));
    assert_eq!(errors(&session.bring(Brought::Cone { vertex: 30.0, angle: None })).len(), 1);
    // Cones of one method are not changed while another one is at work.
    session.handle(Command::SetMethod { id: "cutflow".into() });
    run(&mut session);
    assert_eq!(errors(&session.handle(Command::RemoveCone { cone: 0 })).len(), 1);
    assert!(!session.is_running());
}

#[test]
fn corners_of_a_polygonal_boundary_are_cones_that_can_be_turned() {
    let (mut session, _) = solved("car_hood");
    set(&mut session, "lambda", Value::Number(0.0001));
    let mut events = set(&mut session, "boundary", Value::Text("polygonal".into()));
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let table = cones(&events);
    let corner = table.cones.iter().find(|cone| cone.kind == "corner").unwrap();
    let wanted = 0.9 * corner.angle;
    let mut events =
        session.handle(Command::SetConeAngle { cone: corner.cone, angle: Some(wanted) });
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let after = cones(&events);
    assert!((after.cones[corner.cone].angle - wanted).abs() < 1e-12);
    // Gauss–Bonnet, corners included.
    assert!((total(&after) - total(&table)).abs() < 1e-9, "{}", total(&after));
    // The same from a file.
    let bytes = session.export("Cones (JSON)").unwrap().bytes;
    let mut other = Session::new();
    other.handle(Command::OpenSample { name: "car_hood".into() });
    let mut events = other.open("cones.json", &bytes);
    events.extend(run(&mut other));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert!((cones(&events).int_u2 - after.int_u2).abs() < 1e-9 * after.int_u2.max(1e-6));
}

/// A tube without ends, which is flat.
fn tube() -> String {
    let mut text = String::new();
    for ring in 0..6 {
        for i in 0..12 {
            let (y, x) = (f64::from(i) * PI / 6.0).sin_cos();
            text += &format!("v {x} {y} {}\n", 0.5 * f64::from(ring));
        }
    }
    for ring in 0..5 {
        for i in 0..12 {
            let at = |ring: i32, i: i32| 12 * ring + i % 12 + 1;
            let [a, b] = [at(ring, i), at(ring, i + 1)];
            let [c, d] = [at(ring + 1, i + 1), at(ring + 1, i)];
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

#[test]
fn impossible_bounds_are_refused_with_a_way_on() {
    let (mut session, _) = solved("plush_bear");
    set(&mut session, "bounds", Value::Text("custom".into()));
    let mut events = set(&mut session, "angle_max", Value::Number(0.0));
    events.extend(run(&mut session));
    assert_eq!(errors(&events).len(), 1, "{:?}", errors(&events));
    let mut events = set(&mut session, "bounds", Value::Text("positive".into()));
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty());
    assert!(cones(&events).cones.iter().all(|cone| cone.angle > 0.0));
}

#[test]
fn methods_keep_what_they_have_made() {
    let mut session = Session::new();
    session.handle(Command::OpenSample { name: "rounded_box".into() });
    session.handle(Command::Step);
    let cut = session.export("Cut (JSON)").unwrap().bytes;
    session.handle(Command::SetMethod { id: "cones".into() });
    run(&mut session);
    assert_eq!(session.method(), Method::Cones);
    let mut events = session.handle(Command::SetMethod { id: "cutflow".into() });
    events.extend(run(&mut session));
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert_eq!(session.export("Cut (JSON)").unwrap().bytes, cut);
    session.handle(Command::Undo);
    assert_eq!(session.method(), Method::Cones);
    assert_eq!(errors(&session.handle(Command::SetMethod { id: "magic".into() })).len(), 1);
}

#[test]
fn a_method_chosen_before_there_is_a_mesh_shows_its_own_field() {
    let mut session = Session::new();
    session.handle(Command::SetMethod { id: "cones".into() });
    let events = session.handle(Command::OpenSample { name: "car_hood".into() });
    let current = events.iter().rev().find_map(|event| match event {
        Event::Fields { current, .. } => Some(current.as_str()),
        _ => None,
    });
    assert_eq!(current, Some("u"));
}
