//! Phase fields and developable patches through the session: run, change, undo, hand over, export.

use std::collections::BTreeMap;

use cutflow::session::{
    Brought, Command, Document, Event, Method, SegmentTree, Session, Settings, Value,
};

use crate::exported;

fn open(method: &str, sample: &str, values: &[(&str, Value)]) -> Session {
    let mut session = Session::new();
    session.handle(Command::SetMethod { id: method.into() });
    let document = Document::from_sample(sample);
    let mut settings = Settings::for_sample(Some(sample));
    for (id, value) in values {
        settings.set(id, value.clone()).unwrap();
    }
    let events = session.open_with(document, settings);
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    session
}

fn errors(events: &[Event]) -> Vec<String> {
    let what = |event: &Event| match event {
        Event::Error { what, .. } => Some(what.clone()),
        _ => None,
    };
    events.iter().filter_map(what).collect()
}

fn run(session: &mut Session) -> Vec<Event> {
    let mut events = session.handle(Command::Run);
    go_on(session, &mut events);
    events
}

fn go_on(session: &mut Session, events: &mut Vec<Event>) {
    let mut slices = 0;
    while session.is_running() {
        events.extend(session.advance(&mut || false));
        slices += 1;
        assert!(slices < 20_000, "it never ends");
    }
    assert!(errors(events).is_empty(), "{:?}", errors(events));
}

fn tree(events: &[Event]) -> SegmentTree {
    let found = events.iter().rev().find_map(|event| match event {
        Event::Segments(tree) => Some(tree.clone()),
        _ => None,
    });
    found.unwrap()
}

fn status(events: &[Event]) -> String {
    let found = events.iter().rev().find_map(|event| match event {
        Event::Status { text, .. } => Some(text.clone()),
        _ => None,
    });
    found.unwrap()
}

fn number(x: f64) -> Value {
    Value::Number(x)
}

/// A ball in four, by perimeter alone: quick.
fn quarters() -> Session {
    open("phasefield", "ball", &[("levels", number(2.0)), ("omega", number(0.0))])
}

#[test]
fn a_ball_falls_into_four_equal_segments_with_a_tree_of_seven() {
    let mut session = quarters();
    let events = run(&mut session);
    assert!(status(&events).starts_with("Converged after "), "{}", status(&events));
    let tree = tree(&events);
    assert_eq!(tree.nodes.len(), 7);
    let labels: Vec<&str> = tree.nodes.iter().map(|segment| segment.label.as_str()).collect();
    assert_eq!(labels, ["Whole", "1", "2", "1.1", "1.2", "2.1", "2.2"]);
    // A great circle of the unit sphere, over the root of its area.
    let whole = tree.nodes[0].length.unwrap();
    let circle = std::f64::consts::TAU / (4.0 * std::f64::consts::PI).sqrt();
    assert!((whole / circle - 1.0).abs() < 2e-3, "{whole}");
    for segment in tree.nodes.iter().filter(|segment| segment.is_leaf) {
        assert!((segment.area_fraction - 0.25).abs() < 1e-4, "{segment:?}");
        assert_eq!(segment.components, 1);
    }
    let report = session.phase_report(None).unwrap();
    assert_eq!(report.status, "converged");
    assert_eq!(report.components, 4);
    assert_eq!(report.flattening.charts.len(), 4);
    assert_eq!(report.history.len(), report.steps + 1);
    // Two halves of a circle meet the first one: π + 2π in all, over √4π.
    let circles = 2.0 * std::f64::consts::TAU / (4.0 * std::f64::consts::PI).sqrt();
    assert!((report.perimeter / circles - 1.0).abs() < 5e-3, "{}", report.perimeter);
}

#[test]
fn fewer_levels_take_divisions_back_and_more_go_on_from_what_is_there() {
    let mut session = quarters();
    run(&mut session);
    let set = |levels: f64| Command::SetParameter { id: "levels".into(), value: number(levels) };
    let mut events = session.handle(set(1.0));
    go_on(&mut session, &mut events);
    assert_eq!(tree(&events).nodes.len(), 3);
    let mut events = session.handle(set(3.0));
    assert!(session.is_running(), "what has run goes on by itself");
    go_on(&mut session, &mut events);
    assert_eq!(tree(&events).nodes.len(), 15);
}

#[test]
fn undo_brings_the_segments_before_back_bit_for_bit() {
    let mut session = quarters();
    run(&mut session);
    let before = session.labels();
    let value = number(70.0);
    let mut events = session.handle(Command::SetParameter { id: "fraction".into(), value });
    go_on(&mut session, &mut events);
    assert_ne!(session.labels(), before);
    session.handle(Command::Undo);
    assert_eq!(session.labels(), before);
    session.handle(Command::Redo);
    assert_ne!(session.labels(), before);
    for _ in 0..8 {
        session.handle(Command::Undo);
    }
    assert!(!session.is_running());
}

#[test]
fn a_segment_that_is_chosen_is_shown_with_its_weight() {
    let mut session = quarters();
    run(&mut session);
    session.handle(Command::ShowField { id: "weight".into() });
    let events = session.handle(Command::SelectSegment { node: 1 });
    assert_eq!(tree(&events).selected, 1);
    let scene = session.scene().unwrap();
    let field = scene.field.unwrap();
    assert_eq!(field.id, "weight");
    assert!(field.extremes[0] >= 0.0 && field.extremes[1] <= 1.0 + 1e-6);
    // Half of the surface has the weight 1.
    assert!((field.mean - 0.5).abs() < 0.02, "{}", field.mean);
    let events = session.handle(Command::SelectSegment { node: 99 });
    assert_eq!(errors(&events).len(), 1);
}

#[test]
fn the_atlas_of_the_segments_covers_the_surface_with_weights_that_add_up_to_one() {
    let mut session = quarters();
    run(&mut session);
    let scene = session.scene().unwrap();
    let layers = scene.layers.unwrap();
    assert_eq!(layers.charts.len(), 4);
    let mut sums: BTreeMap<[u32; 3], f32> = BTreeMap::new();
    for (place, weight) in layers.positions.chunks_exact(3).zip(layers.weights.chunks_exact(4)) {
        // A place occurs once for each chart and for each set of neighbours: the first of a chart counts.
        let key = [place[0], place[1], place[2]].map(f32::to_bits);
        let entry = sums.entry(key).or_insert(0.0);
        *entry = entry.max(weight.iter().filter(|w| **w >= 0.0).sum());
    }
    // Four values of 32 bits.
    assert!(sums.values().all(|sum| (sum - 1.0).abs() < 1e-6));
    assert!(sums.len() > 1000);
}

#[test]
fn a_phase_field_is_where_a_cut_flow_can_start() {
    let mut session = quarters();
    run(&mut session);
    let segments = session.labels();
    let events = session.handle(Command::HandOver);
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert_eq!(session.method(), Method::CutFlow);
    assert_eq!(session.labels(), segments);
    let start = session.history()[0].total;
    for _ in 0..3 {
        session.handle(Command::Step);
    }
    assert!(session.history().last().unwrap().total <= start);
    session.handle(Command::SetMethod { id: "phasefield".into() });
    assert_eq!(session.labels(), segments);
}

#[test]
fn an_interface_thinner_than_two_edges_is_as_wide_as_they_are() {
    let mut session = open(
        "phasefield",
        "ball",
        &[("epsilon", number(0.01)), ("levels", number(1.0)), ("omega", number(0.0))],
    );
    let events = run(&mut session);
    let report = session.phase_report(None).unwrap();
    assert!(report.epsilon > 0.02, "{}", report.epsilon);
    // The page tells it as well, beneath the measures.
    let note = events.iter().rev().find_map(|event| match event {
        Event::Measures { note, .. } => note.clone(),
        _ => None,
    });
    assert!(note.unwrap().contains("two edges of this mesh"));
}

#[test]
fn painted_regions_that_are_not_there_are_no_start() {
    let mut session = open("phasefield", "ball", &[]);
    let mut events = session.handle(Command::SetParameter {
        id: "phase_start".into(),
        value: Value::Text("painted".into()),
    });
    events.extend(session.handle(Command::Run));
    while session.is_running() {
        events.extend(session.advance(&mut || false));
    }
    let found = errors(&events);
    assert!(found.iter().any(|error| error.contains("no regions are painted")), "{found:?}");
    session.handle(Command::SetParameter {
        id: "phase_start".into(),
        value: Value::Text("axes".into()),
    });
    assert!(status(&run(&mut session)).starts_with("Converged after "));
}

#[test]
fn patches_of_a_chair_lie_flat_keep_their_seams_and_are_exported_as_they_were_accepted() {
    let mut session = open("developable", "armchair", &[]);
    let events = run(&mut session);
    assert!(status(&events).starts_with("Converged after "), "{}", status(&events));
    let report = session.develop_report(None).unwrap();
    assert!(report.patches.len() < report.vsa_charts, "{report:?}");
    for patch in &report.patches {
        assert!(!patch.overlap && patch.area_change_abs <= 0.1 + 1e-9, "{patch:?}");
        assert!(patch.l2_stretch <= 2.0);
    }
    assert_eq!(report.flattening.method, "lpfb");
    assert_eq!(report.flattening.totals.flipped, 0);
    assert_eq!(report.flattening.totals.overlaps, 0);
    assert_eq!(report.flattening.validity.overlapping_pairs, 0);
    exported::look(&mut session, "armchair");
    // Boundaries of true length are what the pieces have: asked for by name they stay.
    session
        .handle(Command::SetParameter { id: "flatten".into(), value: Value::Text("lpfb".into()) });
    run(&mut session);
    let again = session.develop_report(None).unwrap();
    assert_eq!(again.flattening.totals, report.flattening.totals);
    assert_eq!(again.patches.len(), report.patches.len());
}

#[test]
fn first_pieces_are_sketched_and_flattened_whole_for_a_file_only() {
    let mut session = open("developable", "armchair", &[]);
    session.handle(Command::Step);
    assert_eq!(session.develop_stage(), Some("vsa"));
    let pieces = session.labels().into_iter().max().unwrap() as usize + 1;
    assert_eq!(session.scene().unwrap().patches.len(), pieces);
    let has_settled = |session: &mut Session| {
        let project = session.export("Project (JSON)").unwrap().bytes;
        String::from_utf8(project).unwrap().contains("\"settle\"")
    };
    assert!(!has_settled(&mut session));
    exported::look(&mut session, "first pieces");
    assert!(has_settled(&mut session));
    assert_eq!(session.layout().unwrap().measures.totals.overlaps, 0);
    // The flow goes on from the pieces, however they were parted for the file.
    session.handle(Command::Step);
    let pieces = session.labels().into_iter().max().unwrap() as usize + 1;
    assert_eq!(session.scene().unwrap().patches.len(), pieces);
}

#[test]
fn stages_are_told_one_after_the_other_and_undo_goes_back_to_any_of_them() {
    let mut session = open("developable", "ball", &[]);
    let mut seen = Vec::new();
    let mut events = session.handle(Command::Run);
    let mut halfway = Vec::new();
    while session.is_running() {
        let stage = session.develop_stage().unwrap();
        if seen.last() != Some(&stage) {
            seen.push(stage);
            if stage == "merge" {
                session.handle(Command::Pause);
                halfway = session.labels();
                session.handle(Command::Run);
            }
        }
        events.extend(session.advance(&mut || false));
    }
    assert_eq!(seen, ["vsa", "refine", "merge"]);
    assert_ne!(session.labels(), halfway);
    session.handle(Command::Undo);
    assert_eq!(session.labels(), halfway);
}

#[test]
fn looser_limits_go_on_merging_and_two_pieces_can_be_kept_apart() {
    let mut session = open("developable", "ball", &[("area_limit", number(4.0))]);
    run(&mut session);
    let tight = session.develop_report(None).unwrap().patches.len();
    let value = number(20.0);
    let mut events = session.handle(Command::SetParameter { id: "area_limit".into(), value });
    go_on(&mut session, &mut events);
    let loose = session.develop_report(None).unwrap().patches.len();
    assert!(loose < tight, "{tight} then {loose}");
    let went_on = |session: &mut Session| {
        let notices = session.develop_report(None).unwrap().notices;
        notices.iter().any(|notice| notice.text.starts_with("Looser limits went on"))
    };
    assert!(went_on(&mut session), "a fresh run may be better");
    let limit =
        |percent: f64| Command::SetParameter { id: "area_limit".into(), value: number(percent) };
    let mut events = session.handle(limit(4.0));
    go_on(&mut session, &mut events);
    assert!(!went_on(&mut session), "this began anew");
    let labels = session.labels();
    let of = |label: u32| labels.iter().position(|&l| l == label).unwrap();
    let apart = [of(0), of(1)];
    let mut events = session.handle(Command::Sew { patches: [0, 1], joins: false });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    go_on(&mut session, &mut events);
    // Without limits they would be one.
    let mut events = session.handle(limit(50.0));
    go_on(&mut session, &mut events);
    let labels = session.labels();
    assert_ne!(labels[apart[0]], labels[apart[1]]);
    let events = session.handle(Command::Sew { patches: [0, 0], joins: true });
    assert_eq!(errors(&events).len(), 1);
    let is_history = |event: &&Event| matches!(event, Event::History { .. });
    assert_eq!(events.iter().find(is_history), None, "a refusal is nothing to take back");
}

#[test]
fn two_pieces_are_joined_by_hand_beyond_the_limits() {
    let mut session = open("developable", "ball", &[("area_limit", number(4.0))]);
    run(&mut session);
    let before = session.develop_report(None).unwrap().patches.len();
    let neighbour = session.layout().unwrap().neighbours()[0][0] as usize;
    let mut events = session.handle(Command::Sew { patches: [0, neighbour], joins: true });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    go_on(&mut session, &mut events);
    let after = session.develop_report(None).unwrap();
    let said: Vec<&str> = after.notices.iter().map(|notice| notice.text.as_str()).collect();
    let is_joined = said.iter().any(|text| text.contains("joined by hand"));
    assert!(is_joined, "{said:?}, {before} then {}", after.patches.len());
    assert_eq!(after.flattening.totals.flipped, 0);
}

#[test]
fn a_slider_moved_before_the_run_is_as_good_as_having_begun_with_it() {
    let start = [("levels", number(1.0)), ("omega", number(0.0))];
    let wanted = [("fraction", number(30.0)), ("epsilon", number(0.2))];
    let mut moved = open("phasefield", "ball", &start);
    for (id, value) in wanted.clone() {
        moved.handle(Command::SetParameter { id: id.into(), value });
    }
    run(&mut moved);
    let mut begun = open("phasefield", "ball", &[start, wanted].concat());
    run(&mut begun);
    assert_eq!(moved.labels(), begun.labels());
    let report = moved.phase_report(None).unwrap();
    assert!((report.area_fraction - 0.3).abs() < 1e-4);
}

#[test]
fn regions_that_are_painted_start_a_division_and_seams_that_are_painted_stay() {
    let mut session =
        open("phasefield", "ball", &[("levels", number(1.0)), ("omega", number(0.0))]);
    let count = session.info_report().unwrap().vertices;
    let values: Vec<f64> = (0..count).map(|v| f64::from(u8::from(v % 2 == 0))).collect();
    let events = session.bring(Brought::Layer { channel: "region", values: &values });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    assert_eq!(session.method(), Method::PhaseField);
    run(&mut session);
    let mut session = open("developable", "ball", &[("vsa_tolerance", number(0.1))]);
    let all = vec![1.0; count];
    let events = session.bring(Brought::Layer { channel: "seam_paint", values: &all });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    run(&mut session);
    let report = session.develop_report(None).unwrap();
    assert!(report.patches.len() >= report.vsa_charts, "no seam may go: {report:?}");
    // With none to keep, a seam where it is drawn.
    let mut session = open("developable", "ball", &[("vsa_tolerance", number(0.1))]);
    run(&mut session);
    let before = session.develop_report(None).unwrap();
    let places = Document::from_sample("ball").unwrap().soup.positions.clone();
    let radius = places.iter().map(|p| p[2]).fold(0.0, f64::max);
    let band: Vec<f64> =
        places.iter().map(|p| f64::from(u8::from(p[2].abs() < 0.1 * radius))).collect();
    let cut = |session: &mut Session| {
        String::from_utf8(session.export("Cut curves (OBJ)").unwrap().bytes).unwrap()
    };
    // Length of the cut inside the band.
    let within = |text: &str| -> f64 {
        let numbers = |line: &str| -> Vec<f64> {
            line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect()
        };
        let points: Vec<Vec<f64>> =
            text.lines().filter(|l| l.starts_with("v ")).map(numbers).collect();
        let length = |pair: &[f64]| {
            let [a, b] = [pair[0], pair[1]].map(|i| &points[i as usize - 1]);
            let is_in = [a, b].iter().all(|p| p[2].abs() < 0.11 * radius);
            let square: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
            if is_in { square.sqrt() } else { 0.0 }
        };
        let lines = text.lines().filter(|l| l.starts_with("l ")).map(numbers);
        lines.map(|line| line.windows(2).map(length).sum::<f64>()).sum()
    };
    let without = cut(&mut session);
    let events = session.bring(Brought::Layer { channel: "drawn_seam", values: &band });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    run(&mut session);
    let after = session.develop_report(None).unwrap();
    assert_eq!(after.vsa_charts, before.vsa_charts, "first pieces are the same");
    let text = cut(&mut session);
    let (without, with) = (within(&without), within(&text));
    let around = std::f64::consts::TAU * radius;
    assert!(without < 0.5 * around && with > 0.95 * around, "{without} {with} of {around}");
}

#[test]
fn a_mesh_that_is_too_coarse_for_an_interface_says_so_and_stays_usable() {
    let tetrahedron =
        b"v 1 1 1\nv 1 -1 -1\nv -1 1 -1\nv -1 -1 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n";
    let mut session = Session::new();
    let events = session.open("tetrahedron.obj", tetrahedron);
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let events = session.handle(Command::SetMethod { id: "phasefield".into() });
    let said = errors(&events);
    assert!(said.len() == 1 && said[0].contains("too thin"), "{said:?}");
    assert_eq!(session.method(), Method::PhaseField);
    let events = session.handle(Command::SetMethod { id: "developable".into() });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    run(&mut session);
    assert_eq!(session.develop_report(None).unwrap().flattening.totals.flipped, 0);
}

/// Edges of the cut whose images in a plane x = const are none, and all of them.
fn unmatched(session: &mut Session) -> (usize, usize) {
    let text = session.export("Cut curves (OBJ)").unwrap().bytes;
    let text = String::from_utf8(text).unwrap();
    let numbers = |line: &str| -> Vec<f64> {
        line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect()
    };
    let points: Vec<Vec<f64>> = text.lines().filter(|l| l.starts_with("v ")).map(numbers).collect();
    let middle = |pair: &[f64]| -> [f64; 3] {
        let [a, b] = [pair[0], pair[1]].map(|i| &points[i as usize - 1]);
        [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))
    };
    let lines = text.lines().filter(|line| line.starts_with("l "));
    let middles: Vec<[f64; 3]> =
        lines.flat_map(|line| numbers(line).windows(2).map(middle).collect::<Vec<_>>()).collect();
    let has_no_image = |m: &&[f64; 3]| {
        let near = |other: &[f64; 3]| {
            (other[0] + m[0]).abs() + (other[1] - m[1]).abs() + (other[2] - m[2]).abs() < 1e-4
        };
        !middles.iter().any(near)
    };
    (middles.iter().filter(has_no_image).count(), middles.len())
}

#[test]
fn patches_of_a_chair_are_the_same_left_and_right_where_that_is_asked_for() {
    let mut session = open("developable", "armchair", &[]);
    run(&mut session);
    let (free, _) = unmatched(&mut session);
    assert!(free > 20, "nothing to see: {free}");
    let events = session.handle(Command::FindSymmetries);
    let offered = |events: &[Event]| {
        let told = events.iter().rev().find_map(|event| match event {
            Event::Symmetries { options, serves: "patches", .. } => {
                Some(options.iter().map(|c| (c.id.clone(), c.on)).collect::<Vec<_>>())
            }
            _ => None,
        });
        told.unwrap()
    };
    assert_eq!(offered(&events), [("mirror-1".to_owned(), false)]);
    let choose = |session: &mut Session, ids: &[&str]| {
        let ids = ids.iter().map(|&id| id.to_owned()).collect();
        session.handle(Command::SetSymmetry { ids })
    };
    let mut events = choose(&mut session, &["mirror-1"]);
    assert_eq!(offered(&events), [("mirror-1".to_owned(), true)]);
    assert!(session.is_running(), "it merges anew");
    go_on(&mut session, &mut events);
    let (wrong, all) = unmatched(&mut session);
    // A ring about the chair, its own image, is opened on one side.
    assert!(wrong < all / 50 && wrong < free / 4, "{wrong} of {all}, {free} before");
    let report = session.develop_report(None).unwrap();
    assert_eq!(report.symmetry, ["mirror-1"]);
    assert!(report.patches.iter().all(|patch| !patch.overlap));
    assert_eq!(report.flattening.totals.flipped, 0);

    // The project has it, Undo takes it back, and other methods have symmetries of their own.
    let project = session.export("Project (JSON)").unwrap().bytes;
    let mut again = Session::new();
    let mut events = again.open("again.json", &project);
    go_on(&mut again, &mut events);
    assert_eq!(unmatched(&mut again), (wrong, all));
    assert_eq!(errors(&choose(&mut session, &["mirror-1", "mirror-1"])).len(), 1);
    assert_eq!(errors(&choose(&mut session, &["mirror-9"])).len(), 1);
    let events = session.handle(Command::Undo);
    assert_eq!(offered(&events), [("mirror-1".to_owned(), false)]);
    let events = session.handle(Command::SetMethod { id: "cutflow".into() });
    let is_told = |event: &Event| matches!(event, Event::Symmetries { serves: "cut", .. });
    assert!(events.iter().any(is_told));
}

#[test]
fn a_surface_that_is_symmetric_with_triangles_that_are_not_says_so() {
    // A cube whose right side has a vertex in its middle and whose left side has none.
    let cube = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\nv 1 0 0\n\
        f 1 5 7\nf 1 7 3\nf 2 4 9\nf 4 8 9\nf 8 6 9\nf 6 2 9\nf 1 2 6\nf 1 6 5\nf 3 7 4\nf 7 8 4\nf 1 3 4\nf 1 4 2\nf 5 6 7\nf 6 8 7\n";
    let mut session = Session::new();
    session.handle(Command::SetMethod { id: "developable".into() });
    let events = session.open("cube.obj", cube.as_bytes());
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    session.handle(Command::FindSymmetries);
    let before = session.digest();
    let mut refused = 0;
    for choice in session.symmetry_choices() {
        let told = errors(&session.handle(Command::SetSymmetry { ids: vec![choice.id] }));
        if told.is_empty() {
            session.handle(Command::Undo);
        } else {
            assert!(told[0].contains("its triangles are not"), "{told:?}");
            refused += 1;
        }
        assert_eq!(session.digest(), before);
    }
    assert!(refused > 0);
}

#[test]
fn a_painted_start_gives_way_with_the_triangles_that_it_was_painted_on() {
    let mut session =
        open("phasefield", "ball", &[("levels", number(1.0)), ("omega", number(0.0))]);
    let count = session.info_report().unwrap().vertices;
    let values: Vec<f64> = (0..count).map(|v| f64::from(u8::from(2 * v > count))).collect();
    let events = session.bring(Brought::Layer { channel: "region", values: &values });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    run(&mut session);
    let values = [("faces".to_owned(), 2000.0)].into();
    session.handle(Command::Prepare { tool: "decimate".into(), values });
    let mut events = Vec::new();
    while session.is_running() {
        events.extend(session.advance(&mut || false));
    }
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let notices = session.info_report().unwrap().notices;
    assert!(notices.iter().any(|n| n.text.contains("axes of inertia")), "{notices:?}");
    // Run finds another start.
    assert!(errors(&run(&mut session)).is_empty());
    assert_eq!(session.phase_report(None).unwrap().segments.len(), 3);
}
