//! Cuts and regions that come with files, finishing and schedules, and the command that offers all of it.

use std::path::{Path, PathBuf};
use std::process::Command as Process;

use cutflow::mesh::read::obj;
use cutflow::session::{Command, Event, Session, Value};

use crate::scripts::{ball, errors, measure, set};

fn opened(n: u32) -> Session {
    let mut session = Session::new();
    let events = session.open("ball.obj", ball(n).as_bytes());
    assert_eq!(errors(&events), Vec::<String>::new());
    set(&mut session, "coarse", Value::Truth(false));
    session
}

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

fn value(events: &[Event], id: &str) -> Value {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::Parameters { values, .. } => Some(values[id].clone()),
        _ => None,
    });
    told.next().unwrap()
}

fn undo_label(events: &[Event]) -> Option<String> {
    let mut told = events.iter().rev().filter_map(|event| match event {
        Event::History { undo, .. } => Some(undo.clone()),
        _ => None,
    });
    told.next().unwrap()
}

fn file_labels(bytes: &[u8]) -> Vec<u32> {
    let json: serde_json::Value = serde_json::from_slice(bytes).unwrap();
    let list = json["vertex_labels"].as_array().unwrap();
    list.iter().filter_map(|label| label.as_u64()).map(|label| label as u32).collect()
}

#[test]
fn a_cut_is_brought_to_the_mesh_that_it_was_made_for_and_to_no_other() {
    let mut first = opened(8);
    steps(&mut first, 5);
    let cut = first.export("Cut (JSON)").unwrap().bytes;

    let mut second = opened(8);
    let start = second.labels();
    let events = second.open("cut.json", &cut);
    assert_eq!(errors(&events), Vec::<String>::new());
    assert_eq!(value(&events, "init"), Value::Text("file".into()));
    assert_eq!(second.labels(), file_labels(&cut));
    assert_eq!(undo_label(&events).as_deref(), Some("bring a cut"));
    steps(&mut second, 2);
    second.handle(Command::Reset);
    assert_eq!(second.labels(), file_labels(&cut), "Reset goes back to what was brought");
    for _ in 0..3 {
        assert_eq!(errors(&second.handle(Command::Undo)), Vec::<String>::new());
    }
    assert_eq!(second.labels(), start);

    let mut other = opened(7);
    other.handle(Command::Step);
    other.handle(Command::Step);
    other.handle(Command::Undo);
    let before = (other.labels(), other.history().to_vec());
    let text = String::from_utf8(cut.clone()).unwrap();
    let newer = text.replacen("\"cutflow_cut\": 1", "\"cutflow_cut\": 2", 1);
    let newer = newer.replacen("\"cutflow_cut\":1", "\"cutflow_cut\":2", 1);
    assert_ne!(newer, text);
    for bytes in [&cut[..], &cut[..cut.len() / 2], newer.as_bytes()] {
        let events = other.open("cut.json", bytes);
        assert_eq!(errors(&events).len(), 1);
        assert_eq!((other.labels(), other.history().to_vec()), before);
    }
    // There is nothing to take back, and Redo is still there.
    let events = other.handle(Command::Redo);
    assert_eq!(undo_label(&events).as_deref(), Some("step 2"));
    assert_eq!(other.history().len(), before.1.len() + 1);
    // Without a mesh a cut is no mesh.
    assert_eq!(errors(&Session::new().open("cut.json", &cut)).len(), 1);
}

#[test]
fn a_cut_that_cuts_nothing_or_has_absurd_labels_is_refused() {
    let mut session = opened(6);
    steps(&mut session, 2);
    let cut = session.export("Cut (JSON)").unwrap().bytes;
    let before = (session.labels(), session.history().to_vec());
    for label in [serde_json::json!(0), serde_json::json!(4_000_000_000u32)] {
        let mut json: serde_json::Value = serde_json::from_slice(&cut).unwrap();
        for own in json["vertex_labels"].as_array_mut().unwrap() {
            if !own.is_null() {
                *own = label.clone();
            }
        }
        let events = session.open("cut.json", &serde_json::to_vec(&json).unwrap());
        assert_eq!(errors(&events).len(), 1, "{label}");
        assert_eq!((session.labels(), session.history().to_vec()), before);
    }
}

#[test]
fn regions_that_the_file_does_not_have_are_refused_and_those_it_has_are_cut_along() {
    let mut session = opened(8);
    session.handle(Command::Step);
    let before = (session.labels(), session.history().to_vec());
    let bytes = session.export("UV mesh (OBJ)").unwrap().bytes;
    for init in ["uv", "groups", "materials", "seeds", "painted", "file"] {
        let events = set(&mut session, "init", Value::Text(init.into()));
        assert_eq!(errors(&events).len(), 1, "{init}");
        assert_eq!((session.labels(), session.history().to_vec()), before, "{init}");
        assert_eq!(session.export("UV mesh (OBJ)").unwrap().bytes, bytes, "{init}");
    }
    // Our own UV mesh has islands where its pieces are.
    let events = Session::new().open("uv.obj", &bytes);
    assert_eq!(errors(&events), Vec::<String>::new());

    // The same ball in two materials and two groups, one for each half.
    let plain = ball(8);
    let soup = obj::read(plain.as_bytes()).unwrap().soup;
    let mut text = String::new();
    for line in plain.lines().filter(|line| !line.starts_with('f')) {
        text += &format!("{line}\n");
    }
    for upper in [true, false] {
        let name = if upper { "top" } else { "bottom" };
        text += &format!("g {name}\nusemtl {name}\n");
        for i in 0..soup.polygon_count() {
            let z: f64 = soup.polygon(i).iter().map(|&v| soup.positions[v as usize][2]).sum();
            if (z > 0.0) == upper {
                let corners: Vec<_> = soup.polygon(i).iter().map(|v| (v + 1).to_string()).collect();
                text += &format!("f {}\n", corners.join(" "));
            }
        }
    }
    for init in ["groups", "materials"] {
        let mut session = Session::new();
        session.open("halves.obj", text.as_bytes());
        let events = set(&mut session, "init", Value::Text(init.into()));
        assert_eq!(errors(&events), Vec::<String>::new());
        assert_eq!(measure(&events, "Pieces"), 2.0, "{init}");
        // An equator of a ball of unit area: √π.
        assert!((measure(&events, "Cut length") - 1.7725).abs() < 0.1);
    }
}

#[test]
fn snapping_adds_no_vertices_and_straightening_no_length() {
    let mut session = opened(10);
    steps(&mut session, 6);
    let state = (session.labels(), session.history().to_vec());
    let on = session.layout().unwrap().cut_length();
    set(&mut session, "straighten", Value::Truth(false));
    let off = session.layout().unwrap().cut_length();
    assert!(on <= off, "{on} {off}");
    let input = obj::read(ball(10).as_bytes()).unwrap().soup;
    let count = |session: &mut Session| {
        let bytes = session.export("UV mesh (OBJ)").unwrap().bytes;
        obj::read(&bytes).unwrap().soup.positions.len()
    };
    assert!(count(&mut session) > input.positions.len());
    let events = set(&mut session, "snap", Value::Truth(true));
    assert_eq!(errors(&events), Vec::<String>::new());
    assert_eq!(count(&mut session), input.positions.len());
    assert!(measure(&events, "Pieces") >= 2.0);
    assert_eq!((session.labels(), session.history().to_vec()), state, "the flow stays");
}

#[test]
fn a_falling_length_weight_counts_at_each_step_as_it_was() {
    let mut session = opened(10);
    set(&mut session, "init", Value::Text("circle".into()));
    set(&mut session, "dirichlet", Value::Number(3.0));
    set(&mut session, "hencky", Value::Number(0.0));
    set(&mut session, "length_end", Value::Number(0.1));
    set(&mut session, "length_steps", Value::Number(10.0));
    set(&mut session, "schedule", Value::Text("changing".into()));
    steps(&mut session, 6);
    let follows = |session: &Session| {
        assert!(session.history().len() > 5);
        for row in session.history() {
            let weight = 2.0 * (0.1f64 / 2.0).powf(row.step as f64 / 10.0);
            // Sums of two terms of size 1.
            assert!((row.total - row.distortion - weight * row.length).abs() < 1e-9, "{row:?}");
        }
        assert!(session.history().windows(2).all(|w| w[1].total < w[0].total));
    };
    follows(&session);
    // Measured anew, each step still has its own weight.
    set(&mut session, "tolerance", Value::Number(1e-3));
    follows(&session);
    let events = set(&mut session, "dirichlet", Value::Number(4.0));
    follows(&session);
    let curve: Vec<(f64, f64)> = events
        .iter()
        .filter_map(|event| match event {
            Event::Energy { total, terms, .. } => {
                Some((*total, terms.iter().map(|t| t.value).sum()))
            }
            _ => None,
        })
        .collect();
    assert_eq!(curve.len(), session.history().len());
    assert!(curve.iter().all(|(total, sum)| (total - sum).abs() < 1e-9), "{curve:?}");
}

#[test]
fn the_papers_flow_runs_and_falls() {
    let mut session = opened(10);
    set(&mut session, "init", Value::Text("plane".into()));
    set(&mut session, "offset", Value::Number(20.0));
    set(&mut session, "dirichlet", Value::Number(3.0));
    set(&mut session, "hencky", Value::Number(0.0));
    set(&mut session, "scheme", Value::Text("paper".into()));
    steps(&mut session, 8);
    let rows = session.history();
    assert!(rows.len() > 4);
    assert!(rows.windows(2).all(|w| w[1].total < w[0].total), "{rows:?}");
}

/// A folder of the test's own with a ball in it.
fn folder(name: &str, n: u32) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("studio-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("ball.obj"), ball(n)).unwrap();
    folder
}

/// Runs `cutflow cut` in a folder. **Gives** what it printed.
fn cut(folder: &Path, arguments: &str) -> Result<String, String> {
    command(folder, "cut", arguments)
}

fn command(folder: &Path, name: &str, arguments: &str) -> Result<String, String> {
    let output = Process::new(env!("CARGO_BIN_EXE_cutflow"))
        .current_dir(folder)
        .arg(name)
        .args(arguments.split(' '))
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
}

fn report(folder: &Path, arguments: &str) -> serde_json::Value {
    let text = cut(folder, &format!("{arguments} --json -")).unwrap();
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{arguments}: {e}: {text}"))
}

fn total(report: &serde_json::Value, row: usize) -> f64 {
    report["history"][row]["total"].as_f64().unwrap()
}

#[test]
fn the_command_takes_presets_starts_and_energies() {
    let folder = folder("starts", 8);
    let ball = report(&folder, "sample:ball --preset ball --steps 5");
    assert_eq!((ball["steps"].as_u64(), ball["regions"].as_u64()), (Some(5), Some(2)));
    assert!(total(&ball, 5) < total(&ball, 0));
    for (arguments, regions) in [
        ("--init random --regions 8 --set cells=20", 8),
        ("--init curvature --regions 3", 3),
        ("--init volleyball", 18),
        ("--init seeds --seeds 1,60,300", 3),
    ] {
        let mesh = if arguments.contains("curvature") { "sample:torus" } else { "ball.obj" };
        let report = report(&folder, &format!("{mesh} {arguments} --steps 0"));
        assert_eq!(report["steps"], 0, "{arguments}");
        let found = report["regions"].as_u64().unwrap();
        assert!(found >= 2 && found <= regions, "{arguments}: {found}");
    }
    let report = report(&folder, "ball.obj --init plane --energy rescaled --steps 4");
    assert!(total(&report, 4) < total(&report, 0));
    let growth = "ball.obj --init circle --vertex 5 --one-sided --area 25 --steps 4";
    let report = self::report(&folder, growth);
    assert!(report["region_area"].as_f64().unwrap() > 0.0);
    let merge = "ball.obj --set topology=merge --set scheme=paper --steps 3";
    assert_eq!(self::report(&folder, merge)["steps"], 3);
    let help = cut(&folder, "ball.obj --set help").unwrap();
    for spec in cutflow::session::specs() {
        assert!(help.contains(&format!("{}  (", spec.id)), "{}", spec.id);
    }
}

#[test]
fn developable_pieces_leave_the_command_as_files_for_every_machine() {
    let folder = folder("developable", 6);
    command(&folder, "develop", "sample:armchair -o out").unwrap();
    let text = |name: &str| {
        let bytes = std::fs::read(folder.join("out").join(name)).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    assert!(text("pattern.pdf").starts_with("%PDF-"));
    assert!(text("pattern.svg").contains("<svg "));
    let dxf = text("pattern.dxf");
    let words: Vec<&str> = dxf.split_whitespace().take(4).collect();
    assert_eq!(words, ["0", "SECTION", "2", "HEADER"]);
    assert!(dxf.trim_end().ends_with("EOF"));
}

#[test]
fn the_command_takes_cuts_layers_and_places() {
    let folder = folder("layers", 8);
    cut(&folder, "ball.obj --init plane --steps 5 -o out").unwrap();
    for name in ["cut.json", "uv.obj", "cut.obj", "pattern.svg"] {
        assert!(std::fs::metadata(folder.join("out").join(name)).unwrap().len() > 100, "{name}");
    }
    let again = report(&folder, "ball.obj --init out/cut.json --steps 0");
    assert_eq!((again["steps"].as_u64(), again["regions"].as_u64()), (Some(0), Some(2)));

    // The first line of the file is a vertex that no face uses.
    let places: Vec<[f64; 3]> = obj::read(ball(8).as_bytes()).unwrap().soup.positions;
    let write = |name: &str, of: &dyn Fn([f64; 3]) -> f64| {
        let lines: Vec<String> = places.iter().map(|&p| of(p).to_string()).collect();
        std::fs::write(folder.join(name), lines.join("\n")).unwrap();
    };
    write("spare.txt", &|p| (0.5 + 0.5 * p[0]).min(1.0));
    write("half.txt", &|p| f64::from(p[2] > 0.1));
    let plain = report(&folder, "ball.obj --init plane --steps 0");
    let spare = "ball.obj --init plane --energy dirichlet --weight 1 --set eta=20 --paint penalty=spare.txt";
    let spared = report(&folder, &format!("{spare} --steps 0"));
    assert_eq!(plain["penalty"], 0.0);
    assert!(spared["penalty"].as_f64().unwrap() > 0.1);
    let moved = report(&folder, &format!("{spare} --steps 15"));
    assert!(moved["penalty"].as_f64() < spared["penalty"].as_f64());
    let half = report(&folder, "ball.obj --paint region=half.txt --steps 0");
    assert_eq!(half["regions"], 2);
    let heat = "ball.obj --init plane --set source=heat --paint heat=half.txt --steps 0";
    assert_ne!(total(&report(&folder, heat), 0), total(&plain, 0));
    let hidden = report(&folder, "ball.obj --init plane --hide-from 0,-5,0 --steps 0");
    assert!(hidden["penalty"].as_f64().unwrap() > 0.1);

    let list = cut(&folder, "ball.obj --init plane --symmetry list --steps 0").unwrap();
    assert!(list.contains("mirror-1  ") && list.contains("axis5-1  "), "{list}");
    let all = report(&folder, "ball.obj --init volleyball --symmetry all --steps 0");
    assert_eq!(all["symmetry"].as_array().unwrap().len(), 46, "15 planes and 31 axes");
    let one = report(&folder, "ball.obj --init plane --symmetry mirror-1 --steps 2");
    assert_eq!(one["symmetry"], serde_json::json!(["mirror-1"]));

    let folded = report(&folder, "ball.obj --init plane --steps 2 --fold -o folded");
    assert!(folded["fold"]["distance_mean"].as_f64().unwrap() > 0.0);
    let bytes = std::fs::read(folder.join("folded/folded.obj")).unwrap();
    let soup = obj::read(&bytes).unwrap().soup;
    assert!(soup.positions.iter().flatten().all(|x| x.is_finite()) && soup.polygon_count() > 1280);
}

#[test]
fn what_the_command_cannot_do_it_says_in_three_parts() {
    let folder = folder("wrong", 6);
    cut(&folder, "ball.obj --init plane --steps 1 -o out").unwrap();
    std::fs::write(folder.join("short.txt"), "0 1 0").unwrap();
    std::fs::write(folder.join("words.txt"), "zero one").unwrap();
    let count = obj::read(ball(6).as_bytes()).unwrap().soup.positions.len();
    std::fs::write(folder.join("nan.txt"), "nan ".repeat(count)).unwrap();
    std::fs::write(folder.join("zero.txt"), "0 ".repeat(count)).unwrap();
    for arguments in [
        "ball.obj --preset nonsense",
        "ball.obj --init nonsense",
        "ball.obj --init ball.obj",
        "sample:torus --init out/cut.json",
        "ball.obj --init uv",
        "ball.obj --init seeds",
        "ball.obj --init seeds --seeds 3,1.5",
        "ball.obj --init seeds --seeds 3,99999",
        "ball.obj --init seeds --seeds 3,3",
        "ball.obj --paint penalty",
        "ball.obj --paint penalty=absent.txt",
        "ball.obj --paint penalty=short.txt",
        "ball.obj --paint penalty=words.txt",
        "ball.obj --paint penalty=nan.txt",
        "ball.obj --paint region=zero.txt",
        "ball.obj --paint nonsense=zero.txt",
        "ball.obj --hide-from 1,2",
        "ball.obj --hide-from nan,0,0",
        "ball.obj --symmetry mirror-99",
        "ball.obj --set nonsense=1",
        "ball.obj --set topology=nonsense",
        "ball.obj --set length=nan",
        "ball.obj --set snap=perhaps",
        "ball.obj --set length",
        "ball.obj --area -1",
        "ball.obj --regions 1.5",
    ] {
        let told = cut(&folder, &format!("{arguments} --steps 1"));
        let Err(text) = told else { panic!("{arguments} was done: {told:?}") };
        let parts: Vec<&str> = text.lines().collect();
        let is_clap = text.contains("Usage:");
        assert!(
            is_clap && arguments.contains("--area")
                || parts.len() >= 3
                    && parts[0].starts_with("error: ")
                    && parts[1].starts_with("where: ")
                    && parts[2].starts_with("what to do: "),
            "{arguments}: {text}"
        );
        // By the number that was given: the file has a vertex in front that the mesh has not.
        assert!(!arguments.ends_with("3,3") || text.contains("Vertex 3 "), "{text}");
    }
}

#[test]
fn the_list_of_parameters_needs_no_mesh_and_an_unknown_start_is_answered_with_those_there_are() {
    let folder = folder("words", 2);
    for arguments in ["--set help", "--set=help", "absent.obj --set help"] {
        let text = cut(&folder, arguments).unwrap();
        assert!(text.contains("topology  (adaptive, preserve, merge, free)"), "{text}");
    }
    let text = cut(&folder, "ball.obj --init normal").unwrap_err();
    assert!(text.contains("normals") && text.contains("volleyball") && text.contains("cut.json"));
}

#[test]
fn a_mesh_too_coarse_for_its_curvature_is_cut_with_a_notice_that_says_what_to_do() {
    // Edges of 63°, of 32°, of 8°.
    for (n, is_coarse) in [(1, true), (2, true), (8, false)] {
        let folder = folder(&format!("coarse-{n}"), n);
        let report = report(&folder, "ball.obj --init plane --offset 5 --steps 2");
        let notices = report["notices"].as_array().unwrap();
        let told = notices.iter().find(|notice| notice["kind"] == "coarse_mesh");
        assert_eq!(told.is_some(), is_coarse, "{n}: {notices:?}");
        let mut session = Session::new();
        let events = session.open("ball.obj", ball(n).as_bytes());
        let note = events.iter().find_map(|event| match event {
            Event::Measures { note, .. } => Some(note.clone().unwrap_or_default()),
            _ => None,
        });
        let note = note.unwrap();
        assert_eq!(note.contains("Refine it under Prepare"), is_coarse, "{n}: {note}");
    }
}

/// Points and pieces of a `cut.json`, in an order that does not depend on numbers. Places inside faces are told by weights, which are
/// rounded when they are read.
fn lines_of(bytes: &[u8]) -> Vec<[String; 2]> {
    let json: serde_json::Value = serde_json::from_slice(bytes).unwrap();
    let place = |point: &serde_json::Value| match point["weights"].as_array() {
        None => point.to_string(),
        Some(weights) => {
            let weights: Vec<String> =
                weights.iter().map(|w| format!("{:.12}", w.as_f64().unwrap())).collect();
            format!("{} {weights:?}", point["face"])
        }
    };
    let points: Vec<String> = json["points"].as_array().unwrap().iter().map(place).collect();
    let segments = json["segments"].as_array().unwrap().iter();
    let mut lines: Vec<[String; 2]> = segments
        .map(|s| {
            let mut ends =
                [0, 1].map(|k| points[usize::try_from(s[k].as_u64().unwrap()).unwrap()].clone());
            ends.sort();
            ends
        })
        .collect();
    lines.sort();
    lines
}

#[test]
fn a_cut_file_of_every_method_is_laid_out_line_by_line() {
    for (sample, method) in [
        ("ball", "cutflow"),
        ("wavy_vase", "cones"),
        ("torus", "cutflow"),
        ("rounded_box", "phasefield"),
        ("rounded_box", "developable"),
    ] {
        let mut first = Session::new();
        first.handle(Command::OpenSample { name: sample.into() });
        first.handle(Command::SetMethod { id: method.into() });
        if method == "cones" {
            // Few cones, and seams that end in them.
            set(&mut first, "lambda", Value::Number(0.1));
        }
        first.handle(Command::Run);
        for _ in 0..60 {
            if first.is_running() {
                first.advance(&mut || false);
            }
        }
        first.handle(Command::Pause);
        let cut = first.export("Cut (JSON)").unwrap().bytes;
        let wanted = lines_of(&cut);
        assert!(wanted.len() > 20, "{sample}, {method}: {}", wanted.len());

        let mut second = Session::new();
        second.handle(Command::OpenSample { name: sample.into() });
        second.lay_out_cut("cut.json", &cut).unwrap();
        let again = lines_of(&second.export("Cut (JSON)").unwrap().bytes);
        assert!(again == wanted, "{sample}, {method}: {} and {} lines", again.len(), wanted.len());
    }
}

#[test]
fn the_command_writes_over_no_file_of_its_own() {
    let folder = folder("over", 6);
    let before = std::fs::read(folder.join("ball.obj")).unwrap();
    let run = |line: &str| {
        let words = line.split_whitespace();
        let out = Process::new(env!("CARGO_BIN_EXE_cutflow"))
            .current_dir(&folder)
            .args(words)
            .output()
            .unwrap();
        (out.status.success(), String::from_utf8(out.stderr).unwrap())
    };
    let (is_done, told) = run("flatten ball.obj -o ball.obj");
    assert!(!is_done && told.contains("would be lost") && told.contains("what to do"), "{told}");
    assert_eq!(std::fs::read(folder.join("ball.obj")).unwrap(), before);
    let (is_done, told) = run("flatten ball.obj -o new.obj --json new.obj");
    assert!(!is_done && told.contains("would be lost"), "{told}");
    assert!(std::fs::read_to_string(folder.join("new.obj")).unwrap().contains("\nvt "));
    let (is_done, told) = run("cut ball.obj --steps 0 -o out.json");
    assert!(!is_done && told.contains("folder"), "{told}");
    assert!(!folder.join("out.json").exists());
    // Saying nothing is answered by what can be said.
    let (is_done, told) = run("");
    assert!(!is_done && told.contains("Usage") && !told.contains("error"), "{told}");
}

#[test]
fn lines_of_a_cut_file_that_cannot_be_laid_are_refused_and_doubled_ones_are_one() {
    let mut session = opened(8);
    steps(&mut session, 3);
    let cut = session.export("Cut (JSON)").unwrap().bytes;
    let json: serde_json::Value = serde_json::from_slice(&cut).unwrap();
    let lay = |json: &serde_json::Value| {
        let mut other = opened(8);
        other.lay_out_cut("cut.json", &serde_json::to_vec(json).unwrap())?;
        Ok::<_, cutflow::session::Problem>(lines_of(&other.export("Cut (JSON)").unwrap().bytes))
    };
    let mut doubled = json.clone();
    let lines = doubled["segments"].as_array_mut().unwrap();
    let [first, second] = [lines[0].clone(), lines[1].clone()];
    lines.push(serde_json::json!([first[1], first[0], 0, 1]));
    lines.push(serde_json::json!([second[0], second[0], 0, 1]));
    assert_eq!(lay(&doubled).unwrap(), lines_of(&cut));

    let mut silent = json.clone();
    silent.as_object_mut().unwrap().remove("segments");
    assert!(lay(&silent).unwrap_err().what.contains("where the cut runs"));

    // A line inside a face that leads nowhere, and places that are in no face.
    let soup = obj::read(ball(8).as_bytes()).unwrap().soup;
    let face = soup.polygon(0);
    let within = |weights: [[f64; 3]; 2]| {
        let mut other = json.clone();
        let points = other["points"].as_array_mut().unwrap();
        let n = points.len();
        points.extend(weights.map(|w| serde_json::json!({ "face": face, "weights": w })));
        other["segments"] = serde_json::json!([[n, n + 1, 0, 0]]);
        lay(&other).unwrap_err().what
    };
    assert!(within([[0.2, 0.3, 0.5], [0.4, 0.3, 0.3]]).contains("do not lie on the mesh"));
    assert!(within([[0.9, 0.9, 0.9], [0.4, 0.3, 0.3]]).contains("no place inside a face"));
}
