//! Results side by side: each is what its method gives alone, comes back as it was, and leaves the document in peace.

use std::collections::BTreeMap;
use std::process::Command as Process;

use cutflow::session::{Command, Event, ResultCard, ResultTable, RunRequest, Session, Value};

use crate::scripts::{ball, errors, measure, set, status};

const CUT: &str = "Cut (JSON)";

fn number(x: f64) -> Value {
    Value::Number(x)
}

/// A small ball whose runs are short.
fn opened() -> Session {
    let mut session = Session::new();
    let events = session.open("ball.obj", ball(6).as_bytes());
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    set(&mut session, "steps", number(12.0));
    set(&mut session, "saddle_tests", number(0.0));
    session
}

/// Runs what is to be run, in slices of a few steps.
fn to_rest(session: &mut Session) -> Vec<Event> {
    let mut all = Vec::new();
    while session.is_running() {
        let mut left = 5;
        all.extend(session.advance(&mut || {
            left -= 1;
            left > 0
        }));
    }
    all
}

fn run(method: &str, values: &[(&str, f64)]) -> RunRequest {
    let values = values.iter().map(|&(id, x)| (id.to_owned(), number(x)));
    RunRequest { method: method.into(), values: values.collect(), name: None }
}

fn compare(session: &mut Session, runs: Vec<RunRequest>) -> ResultTable {
    let events = session.handle(Command::Compare { runs, steps: Some(40), waits: false });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let events = to_rest(session);
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    session.result_table()
}

fn bytes(session: &mut Session, kind: &str) -> Vec<u8> {
    session.export(kind).unwrap().bytes
}

/// What a method gives by itself: the measures and the cut.
fn alone(method: &str, values: &[(&str, f64)]) -> (BTreeMap<String, f64>, Vec<u8>) {
    let mut session = opened();
    for (id, x) in values {
        set(&mut session, id, number(*x));
    }
    session.handle(Command::SetMethod { id: method.into() });
    session.handle(Command::Reset);
    session.handle(Command::Run);
    if method != "cones" {
        let mut left = 40;
        while session.is_running() && left > 0 {
            session.advance(&mut || {
                left -= 1;
                left > 0
            });
        }
        session.handle(Command::Pause);
    }
    to_rest(&mut session);
    let cut = bytes(&mut session, CUT);
    let events = session.handle(Command::KeepResult { name: None, seconds: None });
    let table = events.iter().find_map(|event| match event {
        Event::Comparison(table) => Some(table.clone()),
        _ => None,
    });
    (table.unwrap().results[0].measures.clone(), cut)
}

fn card<'a>(table: &'a ResultTable, name: &str) -> &'a ResultCard {
    table.results.iter().find(|result| result.name == name).unwrap()
}

#[test]
fn every_method_has_the_numbers_that_it_has_alone_and_comes_back_to_the_same_cut() {
    let mut session = opened();
    let before = bytes(&mut session, CUT);
    let table = compare(&mut session, Vec::new());
    let names: Vec<&str> = table.results.iter().map(|result| &*result.name).collect();
    assert_eq!(names, ["Cut flow", "Cones", "Phase field", "Developable patches"]);
    assert!(before == bytes(&mut session, CUT), "the document is what it was");
    assert_eq!(table.current, None);
    for result in &table.results {
        assert!(result.has_result, "{}: {:?}", result.name, result.note);
        let (measures, cut) = alone(&result.method, &[]);
        assert_eq!(result.measures, measures, "{}", result.name);
        for id in
            ["pieces", "cut_length", "area_distortion", "angle_distortion", "flipped", "overlaps"]
        {
            assert!(measures.contains_key(id), "{} has no {id}", result.name);
        }
        let events = session.handle(Command::RestoreResult { id: result.id });
        assert!(errors(&events).is_empty(), "{:?}", errors(&events));
        to_rest(&mut session);
        assert_eq!(session.result_table().current, Some(result.id));
        assert_eq!(session.method().id(), result.method);
        assert!(cut == bytes(&mut session, CUT), "another cut of {}", result.name);
    }
    // One change each, the last first.
    for _ in &table.results {
        session.handle(Command::Undo);
        to_rest(&mut session);
    }
    assert!(before == bytes(&mut session, CUT));
    // Rows that a method cannot have are empty, and so is time that nobody measured.
    let hencky = table.rows.iter().find(|row| row.id == "hencky").unwrap();
    assert_eq!(
        hencky.values.iter().map(Option::is_some).collect::<Vec<_>>(),
        [true, false, false, false]
    );
    assert!(!hencky.best.contains(&true), "nothing to beat");
    assert!(table.rows.iter().all(|row| row.id != "seconds"));
}

#[test]
fn settings_of_one_method_are_told_apart_and_the_parameters_stay_what_they_were() {
    let mut session = opened();
    let runs = vec![run("cutflow", &[("length", 1.0)]), run("cutflow", &[("length", 6.0)])];
    let table = compare(&mut session, runs);
    let [one, other] = [card(&table, "Cut flow"), card(&table, "Cut flow 2")];
    for (result, length) in [(one, 1.0), (other, 6.0)] {
        assert_eq!(result.measures, alone("cutflow", &[("length", length)]).0);
        let told = result.settings.iter().find(|setting| setting.id == "length").unwrap();
        assert_eq!(told.value, number(length));
        assert!(told.text.starts_with(&length.to_string()), "{}", told.text);
    }
    let lengths = table.rows.iter().find(|row| row.id == "cut_length").unwrap();
    assert_ne!(lengths.values[0], lengths.values[1]);
    assert_eq!((lengths.best.iter().filter(|best| **best).count(), lengths.word), (1, "shortest"));
    let changed = set(&mut session, "length", number(6.0));
    assert!(
        changed.iter().any(|e| matches!(e, Event::History { undo: Some(_), .. })),
        "it was not 6 before"
    );
}

#[test]
fn a_run_that_fails_is_noted_and_the_others_go_on() {
    let mut session = opened();
    // A painted start without paint.
    let failing = RunRequest {
        method: "cutflow".into(),
        values: [("init".to_owned(), Value::Text("painted".into()))].into(),
        name: Some("Painted".into()),
    };
    let table = compare(&mut session, vec![failing, run("cones", &[])]);
    let painted = card(&table, "Painted");
    assert!(!painted.has_result && painted.measures.is_empty() && painted.steps.is_none());
    assert!(painted.note.as_ref().is_some_and(|note| note.len() > 20), "{:?}", painted.note);
    assert!(card(&table, "Cones").has_result);
    let events = session.handle(Command::RestoreResult { id: painted.id });
    assert!(errors(&events)[0].contains("Painted"));
    let csv = String::from_utf8(bytes(&mut session, "Comparison (CSV)")).unwrap();
    assert!(csv.lines().nth(1).unwrap().contains("Painted,Cut flow,"), "{csv}");
}

#[test]
fn what_cannot_be_understood_is_refused_before_anything_runs() {
    let mut session = opened();
    for runs in [
        vec![run("magic", &[])],
        vec![run("cutflow", &[("nonsense", 1.0)])],
        vec![run("cones", &[("lambda", -1.0)])],
    ] {
        let events = session.handle(Command::Compare { runs, steps: None, waits: false });
        assert_eq!(errors(&events).len(), 1);
        assert!(!session.is_running());
    }
    for command in [
        Command::RestoreResult { id: 7 },
        Command::RemoveResult { id: 7 },
        Command::RenameResult { id: 7, name: "x".into() },
    ] {
        assert!(errors(&session.handle(command))[0].contains("no result 7"));
    }
    let mut empty = Session::new();
    for command in [
        Command::KeepResult { name: None, seconds: None },
        Command::Compare { runs: Vec::new(), steps: None, waits: false },
    ] {
        assert!(errors(&empty.handle(command))[0].contains("No mesh is open"));
    }
    assert!(session.export("Comparison (CSV)").is_err(), "nothing was kept");
}

#[test]
fn a_comparison_pauses_goes_on_waits_to_be_seen_and_can_be_given_up() {
    let mut session = opened();
    let before = bytes(&mut session, CUT);
    let runs = vec![run("cutflow", &[]), run("cutflow", &[("length", 5.0)])];
    session.handle(Command::Compare { runs: runs.clone(), steps: None, waits: true });
    let mut left = 6;
    let events = session.advance(&mut || {
        left -= 1;
        left > 0
    });
    assert!(
        status(&events).starts_with("Running step 0: comparing, Cut flow, 1 of 2"),
        "{}",
        status(&events)
    );
    session.advance(&mut || false);
    let events = session.handle(Command::Pause);
    assert!(status(&events).starts_with("Paused at step "), "{}", status(&events));
    assert!(!session.is_running());
    session.handle(Command::Run);
    to_rest(&mut session);
    // The first result is there, and waits to be looked at.
    let table = session.result_table();
    let progress = table.progress.unwrap();
    assert_eq!((table.results.len(), progress.waits_for), (1, Some(table.results[0].id)));
    assert_eq!((progress.at, &*progress.label), (1, "Cut flow"), "the run that has just ended");
    assert!(session.scene().is_some(), "its picture is there");
    assert_eq!(table.results[0].measures, alone("cutflow", &[]).0, "pausing changes nothing");
    session.handle(Command::NextResult);
    session.advance(&mut || false);
    assert!(session.is_running());
    // Whatever changes the document ends it: what stood comes back first.
    session.handle(Command::Cancel);
    to_rest(&mut session);
    let table = session.result_table();
    assert_eq!((table.results.len(), table.progress), (1, None));
    assert!(before == bytes(&mut session, CUT));
    session.handle(Command::Compare { runs, steps: None, waits: false });
    session.advance(&mut || false);
    let events = session.handle(Command::Undo);
    assert!(errors(&events).is_empty());
    assert_eq!(session.result_table().progress, None);
    session.open("other.obj", ball(4).as_bytes());
    assert!(session.result_table().results.is_empty(), "results go with their mesh");
}

#[test]
fn time_that_the_driver_measured_belongs_to_the_run_that_took_it() {
    let mut session = opened();
    let runs = vec![run("cutflow", &[]), run("cones", &[])];
    session.handle(Command::Compare { runs, steps: None, waits: false });
    let mut spent = 0.0;
    while session.is_running() {
        session.advance(&mut || false);
        session.spend(0.5);
        spent += 0.5;
    }
    let table = session.result_table();
    let times: Vec<f64> = table.results.iter().map(|result| result.seconds.unwrap()).collect();
    assert!(times.iter().all(|time| *time >= 1.0));
    // All but the slice that brought the document back.
    assert_eq!(times.iter().sum::<f64>(), spent - 0.5);
    session.handle(Command::KeepResult { name: None, seconds: Some(f64::NAN) });
    assert_eq!(session.result_table().results[2].seconds, None);
}

#[test]
fn a_project_saved_after_showing_a_result_replays_to_it() {
    let mut session = opened();
    session.handle(Command::Step);
    let table = compare(
        &mut session,
        vec![run("cutflow", &[("length", 4.0)]), run("cones", &[]), run("developable", &[])],
    );
    for result in &table.results {
        session.handle(Command::RestoreResult { id: result.id });
        to_rest(&mut session);
        let project = bytes(&mut session, "Project (JSON)");
        let mut again = Session::new();
        assert!(errors(&again.open("p.json", &project)).is_empty());
        assert!(errors(&to_rest(&mut again)).is_empty());
        assert_eq!(again.method().id(), result.method);
        for kind in [CUT, "Cut curves (OBJ)"] {
            assert!(
                bytes(&mut session, kind) == bytes(&mut again, kind),
                "{kind} of {} differs",
                result.name
            );
        }
        assert!(again.result_table().results.is_empty(), "a project holds no results");
    }
    // What is done after goes on from there.
    session.handle(Command::RestoreResult { id: table.results[0].id });
    set(&mut session, "steps", number(14.0));
    session.handle(Command::Step);
    let project = bytes(&mut session, "Project (JSON)");
    let mut again = Session::new();
    again.open("p.json", &project);
    to_rest(&mut again);
    assert!(bytes(&mut session, CUT) == bytes(&mut again, CUT));
}

#[test]
fn keeping_renaming_and_removing_change_nothing_but_the_comparison() {
    let mut session = opened();
    session.handle(Command::Run);
    session.advance(&mut || false);
    let events =
        session.handle(Command::KeepResult { name: Some("  mine\n".into()), seconds: Some(2.5) });
    let length = measure(&events, "Cut length");
    let project = bytes(&mut session, "Project (JSON)");
    let table = session.result_table();
    let mine = card(&table, "mine");
    assert_eq!(
        (mine.measures["cut_length"], mine.seconds, mine.steps),
        (length, Some(2.5), Some(1))
    );
    assert_eq!(table.current, Some(mine.id));
    assert!(mine.status.starts_with("Paused at step 1"));
    session.handle(Command::RenameResult { id: mine.id, name: "=a, \"b\"\r\nc".into() });
    let csv = String::from_utf8(bytes(&mut session, "Comparison (CSV)")).unwrap();
    let lines: Vec<&str> = csv.split("\r\n").collect();
    assert!(
        lines[0].starts_with("Name,Method,Settings,Status,Steps,Time (s),Pieces,Cut length (√A),"),
        "{}",
        lines[0]
    );
    assert!(lines[1].starts_with("\"=a, \"\"b\"\"  c\",Cut flow,"), "{}", lines[1]);
    assert!(lines[1].contains(&format!(",{length},")), "all digits: {}", lines[1]);
    assert_eq!((lines.len(), lines[2]), (3, ""));
    let report = String::from_utf8(bytes(&mut session, "Report (JSON)")).unwrap();
    assert!(report.contains("\"comparison\""));
    assert_eq!(
        errors(&session.handle(Command::RenameResult { id: mine.id, name: " ".into() })).len(),
        1
    );
    let events = session.handle(Command::RemoveResult { id: mine.id });
    assert!(
        events
            .iter()
            .any(|event| matches!(event, Event::Comparison(table) if table.results.is_empty()))
    );
    assert!(project == bytes(&mut session, "Project (JSON)"));
    assert!(
        !String::from_utf8(bytes(&mut session, "Report (JSON)"))
            .unwrap()
            .contains("\"comparison\"")
    );
    // A change makes it another state, Undo the same again.
    session.handle(Command::KeepResult { name: None, seconds: None });
    session.handle(Command::Step);
    assert_eq!(session.result_table().current, None);
    session.handle(Command::Undo);
    assert!(session.result_table().current.is_some());
}

#[test]
fn the_archive_holds_the_table_where_there_is_one() {
    let mut session = Session::new();
    session.open("ball.obj", ball(3).as_bytes());
    set(&mut session, "init", Value::Text("plane".into()));
    let name = b"ball-comparison.csv";
    for is_kept in [false, true] {
        let archive = bytes(&mut session, "All files (ZIP)");
        assert_eq!(archive.windows(name.len()).any(|part| part == name), is_kept);
        session.handle(Command::KeepResult { name: None, seconds: None });
    }
}

fn cutflow(args: &[&str]) -> (bool, String, String) {
    let output = Process::new(env!("CARGO_BIN_EXE_cutflow")).args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.success(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_command_prints_the_table_and_writes_it() {
    let folder = std::env::temp_dir().join(format!("cutflow-comparing-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mesh = folder.join("ball.obj");
    std::fs::write(&mesh, ball(5)).unwrap();
    let (mesh, out) = (mesh.to_str().unwrap(), folder.join("out"));
    let (ok, table, error) = cutflow(&[
        "compare",
        mesh,
        "--methods",
        "cones,developable",
        "--set",
        "cones.lambda=0.01",
        "--run",
        "cutflow,length=3",
        "--run",
        "cutflow,init=painted",
        "--steps",
        "5",
        "-o",
        out.to_str().unwrap(),
    ]);
    assert!(ok, "{error}");
    let lines: Vec<&str> = table.lines().collect();
    for name in ["Cones", "Developable patches", "cutflow,length=3"] {
        assert!(lines[0].contains(name), "{}", lines[0]);
    }
    for row in [
        "Pieces",
        "Cut length, √A",
        "Area distortion",
        "Angle distortion",
        "Flipped triangles",
        "Overlaps",
        "Hencky",
        "Time, s",
    ] {
        assert!(lines.iter().any(|line| line.starts_with(row)), "{row} in {table}");
    }
    assert!(
        table.contains('*') && table.contains("cutflow,init=painted: Failed\n  note: "),
        "{table}"
    );
    let csv = std::fs::read_to_string(out.join("comparison.csv")).unwrap();
    assert_eq!(csv.split("\r\n").count(), 6, "{csv}");
    let json = std::fs::read_to_string(out.join("comparison.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let results = json["results"].as_array().unwrap();
    assert_eq!(results.len(), 4);
    assert!(
        results[0]["seconds"].as_f64().unwrap() > 0.0
            && results[0]["measures"]["pieces"].is_number()
    );
    for (args, word) in [
        (&["compare", mesh, "--methods", "magic"][..], "no method called"),
        (&["compare", mesh, "--set", "length=2"], "names no method"),
        (&["compare", mesh, "--set", "cutflow.nonsense=2"], "no parameter called"),
        (&["compare", mesh, "--methods", "cones", "--set", "cutflow.length=2"], "not compared"),
        (&["compare", mesh, "--run", "cutflow,init=painted"], "No method gave a result"),
    ] {
        let (ok, _, error) = cutflow(args);
        assert!(!ok && error.contains(word) && error.contains("what to do: "), "{error}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
