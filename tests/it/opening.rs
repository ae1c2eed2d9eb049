//! Opening meshes: what a session says of good, odd and hostile files, what the doctor's repairs make of them, and that a
//! cut runs afterwards.

use std::collections::BTreeMap;
use std::path::PathBuf;

use cutflow::session::{Command, Document, Event, Session, Value, samples};

/// The collection beside the checkout; says so where there is none.
fn folder(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes").join(name);
    if !path.is_dir() {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

/// What must become of a file.
enum Expect {
    /// Opens, with these vertices and faces, and nothing to warn of.
    Ok(usize, usize),
    /// Opens, with a finding or notice of this kind in so many places, and needs repair or not.
    Warn(usize, usize, &'static str, usize, bool),
    /// Is refused with a text that holds this.
    Error(&'static str),
}

use Expect::{Error, Ok as Fine, Warn};

#[rustfmt::skip]
const BAD: &[(&str, Expect)] = &[
    ("empty.obj", Error("empty")),
    ("comments-only.obj", Error("no vertices")),
    ("html.obj", Error("HTML")),
    ("random-bytes.obj", Error("not a")),
    ("random-bytes.stl", Error("")),
    ("stl-named.ply", Fine(162, 320)),
    ("truncated.obj", Warn(162, 200, "incomplete_face", 1, true)),
    ("truncated.ply", Error("126 of 320")),
    ("truncated.stl", Error("200 of 320")),
    ("truncated.glb", Error("2661")),
    ("truncated.off", Error("30 of 42")),
    ("huge-count.ply", Error("ends early")),
    ("huge-count.stl", Error("")),
    ("huge-list.ply", Error("ends early")),
    ("no-end-header.ply", Error("end_header")),
    ("nan-coord.obj", Error("not a finite number")),
    ("inf-coord.ply", Error("not a finite number")),
    ("overflow-coord.obj", Error("not a finite number")),
    ("comma-decimal.obj", Error("decimal comma")),
    ("huge-offset.obj", Warn(162, 320, "far_from_origin", 1, false)),
    ("tiny-scale.obj", Fine(162, 320)),
    ("anisotropic.obj", Warn(162, 320, "slivers", 0, false)),
    ("all-same-point.obj", Error("no extent")),
    ("all-collinear.obj", Error("98 faces have zero area")),
    ("index-out-of-range.obj", Error("999 of 42")),
    ("index-out-of-range.ply", Error("-1 of 42")),
    ("index-out-of-range.glb", Error("60000")),
    ("negative-indices.obj", Fine(54, 83)),
    ("mixed-refs.obj", Warn(6, 4, "texture_out_of_range", 1, false)),
    ("nonmanifold-edge.obj", Warn(5, 3, "non_manifold_edges", 1, true)),
    ("fin-on-sphere.obj", Warn(43, 81, "non_manifold_edges", 1, true)),
    ("bowtie-vertex.obj", Warn(5, 2, "non_manifold_vertices", 1, true)),
    ("two-tetra-one-vertex.obj", Warn(7, 8, "non_manifold_vertices", 1, true)),
    ("touching-holes.obj", Warn(81, 124, "non_manifold_vertices", 1, true)),
    ("flipped-faces.obj", Warn(162, 320, "orientation", 218, true)),
    ("inside-out.obj", Warn(162, 320, "inside_out", 1, false)),
    ("moebius.obj", Warn(200, 320, "not_orientable", 1, true)),
    ("klein-bottle.obj", Warn(512, 1024, "not_orientable", 1, true)),
    ("duplicate-faces.obj", Warn(162, 360, "duplicate_faces", 40, true)),
    ("degenerate-faces.obj", Warn(44, 84, "degenerate_faces", 4, true)),
    ("isolated-vertices.obj", Warn(77, 80, "isolated", 35, false)),
    ("components.obj", Warn(548, 1053, "components", 6, false)),
    ("triangle-dust.obj", Warn(1200, 400, "components", 400, false)),
    ("single-triangle.obj", Fine(3, 1)),
    ("two-spheres-crossing.obj", Warn(324, 640, "components", 2, false)),
    ("polygon-200.obj", Fine(400, 202)),
    ("concave-ngons.obj", Fine(110, 4)),
    ("nonplanar-ngons.obj", Fine(16, 2)),
    ("crlf.obj", Fine(42, 80)),
    ("cr-only.obj", Fine(42, 80)),
    ("bom-tabs-unicode.obj", Fine(42, 80)),
    ("long-line.obj", Fine(42, 80)),
    ("continuation-colours.obj", Fine(42, 80)),
    ("lines-only.obj", Error("no faces")),
    ("UPPER.OBJ", Fine(42, 80)),
    ("solid-binary.stl", Fine(162, 320)),
    ("ascii-two-solids.stl", Warn(84, 160, "components", 2, false)),
    ("jittered.stl", Warn(960, 320, "coincident_vertices", 0, false)),
    ("odd-big-endian.ply", Fine(42, 80)),
    ("crlf-header.ply", Fine(42, 80)),
    ("ascii-one-line.ply", Fine(42, 80)),
    ("tristrips.ply", Fine(60, 90)),
    ("point-cloud.ply", Error("point cloud")),
    ("variants.off", Fine(8, 6)),
    ("draco-required.glb", Error("KHR_draco_mesh_compression")),
    ("meshopt-required.glb", Error("EXT_meshopt_compression")),
    ("accessor-overrun.glb", Error("accessor")),
    ("cyclic-nodes.glb", Error("")),
    ("external-buffer.glb", Error("")),
    ("bad-json.glb", Error("JSON")),
    ("version-1.glb", Error("glTF 1")),
    ("strip-no-indices.glb", Fine(12, 10)),
    ("mirrored-instances.glb", Warn(126, 160, "no_area", 1, false)),
    ("lines-only.glb", Error("no triangles")),
];

fn document(name: &str, bytes: &[u8]) -> Result<Document, String> {
    Document::from_bytes(name, bytes).map_err(|p| {
        assert!(![&p.what, &p.place, &p.what_to_do].iter().any(|text| text.is_empty()), "{name}");
        format!("{} {} {}", p.what, p.place, p.what_to_do)
    })
}

/// Opens a mesh, repairs it where that is needed, and takes some steps; everything on the way must be finite and sound.
fn run_through(name: &str, bytes: &[u8]) -> Session {
    let mut session = Session::new();
    let events = session.open(name, bytes);
    assert!(errors(&events).is_empty(), "{name}: {:?}", errors(&events));
    assert_sound(&mut session, name);
    if !session.info_report().unwrap().solvable {
        assert_eq!(errors(&session.handle(Command::Step)).len(), 1, "{name} refuses with a reason");
        let events = session.handle(Command::RepairAll);
        assert!(errors(&events).is_empty(), "{name}: {:?}", errors(&events));
        let info = session.info_report().unwrap();
        assert!(info.solvable, "{name}: {:?}", info.notices);
        assert_sound(&mut session, name);
    }
    while session.is_running() {
        session.advance(&mut || false);
    }
    for _ in 0..3 {
        let events = session.handle(Command::Step);
        // Parts that no initial cut suits say so; nothing else may go wrong.
        let reasons = errors(&events);
        assert!(reasons.iter().all(|e| e.contains("initial cut")), "{name}: {reasons:?}");
    }
    assert_sound(&mut session, name);
    session
}

fn assert_sound(session: &mut Session, name: &str) {
    let scene = session.scene().unwrap_or_else(|| panic!("{name} is shown"));
    assert!(scene.positions.iter().chain(&scene.normals).all(|x| x.is_finite()), "{name}");
    assert!(scene.mark_points.iter().chain(&scene.mark_segments).all(|x| x.is_finite()), "{name}");
    let count = scene.vertex_patches.len();
    assert!(scene.triangles.iter().all(|&v| (v as usize) < count), "{name}");
    if let Some(row) = session.history().last() {
        assert!(row.total.is_finite() && row.length >= 0.0, "{name}");
    }
}

fn errors(events: &[Event]) -> Vec<String> {
    events
        .iter()
        .filter_map(|event| match event {
            Event::Error { what, .. } => Some(what.clone()),
            _ => None,
        })
        .collect()
}

#[test]
fn every_hostile_file_ends_as_its_table_says() {
    let Some(folder) = folder("bad") else { return };
    let mut faults = Vec::new();
    for (name, expected) in BAD {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let result = document(name, &bytes);
        let fault = match (expected, &result) {
            (Error(text), Err(what)) if what.to_lowercase().contains(&text.to_lowercase()) => None,
            (Error(text), Err(what)) => Some(format!("says “{what}”, not “{text}”")),
            (Error(_), Ok(_)) => Some("opens".to_owned()),
            (_, Err(what)) => Some(format!("is refused: {what}")),
            (Fine(vertices, faces), Ok(d)) => {
                let is = (d.summary.vertices, d.summary.faces, d.surface.is_some());
                (is != (*vertices, *faces, true)).then(|| format!("{is:?} {:?}", d.summary.notices))
            }
            (Warn(vertices, faces, kind, count, blocks), Ok(d)) => {
                let is = (d.summary.vertices, d.summary.faces, d.surface.is_none());
                let found = d.summary.notices.iter().find(|n| n.kind == *kind);
                let is_told = found.is_some_and(|n| *count == 0 || n.count == *count);
                (is != (*vertices, *faces, *blocks) || !is_told)
                    .then(|| format!("{is:?} {:?}", d.summary.notices))
            }
        };
        faults.extend(fault.map(|fault| format!("{name}: {fault}")));
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn every_hostile_file_that_opens_can_be_repaired_and_cut() {
    let Some(folder) = folder("bad") else { return };
    for (name, expected) in BAD {
        if !matches!(expected, Error(_)) {
            run_through(name, &std::fs::read(folder.join(name)).unwrap());
        }
    }
}

#[test]
fn repairs_leave_the_surfaces_that_were_meant() {
    let Some(folder) = folder("bad") else { return };
    // Vertices, faces, components, boundary loops, Euler characteristic after Repair all.
    #[rustfmt::skip]
    let expected: &[(&str, [i64; 5])] = &[
        ("fin-on-sphere.obj", [45, 81, 2, 1, 3]),
        ("bowtie-vertex.obj", [6, 2, 2, 2, 2]),
        ("two-tetra-one-vertex.obj", [8, 8, 2, 0, 4]),
        ("touching-holes.obj", [82, 124, 1, 2, 0]),
        ("flipped-faces.obj", [162, 320, 1, 0, 2]),
        ("duplicate-faces.obj", [162, 320, 1, 0, 2]),
        ("degenerate-faces.obj", [44, 80, 1, 0, 2]),
    ];
    for (name, numbers) in expected {
        let d = document(name, &std::fs::read(folder.join(name)).unwrap()).unwrap();
        let s = d.repaired().unwrap().summary;
        let is = [s.vertices, s.faces, s.components, s.boundary_loops].map(|n| n as i64);
        assert_eq!([is[0], is[1], is[2], is[3], s.euler], *numbers, "{name}");
    }
    for name in ["moebius.obj", "klein-bottle.obj"] {
        let d = document(name, &std::fs::read(folder.join(name)).unwrap()).unwrap();
        assert_eq!(d.summary.genus, None, "{name}");
        let opened = d.repaired().unwrap();
        assert!(opened.surface.is_some() && opened.summary.boundary_loops > 0, "{name}");
    }
    let d = document("jittered.stl", &std::fs::read(folder.join("jittered.stl")).unwrap()).unwrap();
    let welded = d.repaired().unwrap().summary;
    assert_eq!((welded.vertices, welded.faces), (162, 320));
    assert_eq!((welded.components, welded.boundary_loops), (1, 0));
}

#[test]
fn every_mesh_of_the_collection_opens_with_a_truthful_report() {
    let Some(folder) = folder("") else { return };
    // Vertices, faces, components, boundary loops, genus.
    #[rustfmt::skip]
    let expected: &[(&str, [usize; 5])] = &[
        ("spot.obj", [2930, 5856, 1, 0, 0]),
        ("spot-control.obj", [188, 180, 1, 0, 0]),
        ("stanford-bunny.obj", [35947, 69451, 1, 5, 0]),
        ("bunny-closed.obj", [14290, 28576, 1, 0, 0]),
        ("face.obj", [17157, 34144, 1, 1, 0]),
        ("beetle.obj", [30024, 58738, 1, 11, 0]),
        ("hood.obj", [3998, 7660, 1, 2, 0]),
        ("hand.obj", [7993, 15982, 1, 0, 0]),
        ("armadillo.obj", [14587, 29170, 1, 0, 0]),
        ("homer.obj", [6002, 12000, 1, 0, 0]),
        ("cheburashka.obj", [6669, 13334, 1, 0, 0]),
        ("nefertiti.ply", [35002, 70000, 1, 0, 0]),
        ("fandisk.obj", [6475, 12946, 1, 0, 0]),
        ("rocker-arm.obj", [10044, 20088, 1, 0, 1]),
        ("torus.obj", [4608, 9216, 1, 0, 1]),
        ("double-torus.obj", [5644, 11292, 1, 0, 2]),
        ("chair.obj", [7020, 14044, 1, 0, 2]),
        ("fertility.off", [4494, 9000, 1, 0, 4]),
        ("koala.stl", [3560, 7116, 1, 0, 0]),
        ("igea.ply", [134_345, 268_686, 1, 0, 0]),
    ];
    for (name, numbers) in expected {
        let d = document(name, &std::fs::read(folder.join(name)).unwrap()).unwrap();
        let s = &d.summary;
        let genus = s.genus.unwrap_or(usize::MAX);
        assert_eq!(
            [s.vertices, s.faces, s.components, s.boundary_loops, genus],
            *numbers,
            "{name}"
        );
        assert!(d.surface.is_some(), "{name}: {:?}", s.notices);
    }
    let truck = std::fs::read(folder.join("milk-truck.glb")).unwrap();
    let d = document("milk-truck.glb", &truck).unwrap();
    assert_eq!(d.summary.faces, 3624);
    assert_eq!(d.soup.materials.len(), 4);
    let mut session = run_through("milk-truck.glb", &truck);
    assert!(!session.export("UV mesh (OBJ)").unwrap().bytes.is_empty());
}

/// A closed box of 24 × 24 squares a side, as OBJ lines.
fn grid(n: u32, place: impl Fn(u32, u32) -> [f64; 3]) -> String {
    let mut text = String::new();
    for i in 0..=n {
        for j in 0..=n {
            let [x, y, z] = place(i, j);
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for i in 0..n {
        for j in 0..n {
            let at = |i: u32, j: u32| i * (n + 1) + j + 1;
            text +=
                &format!("f {} {} {} {}\n", at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
        }
    }
    text
}

fn icosphere_text(flip: impl Fn(usize) -> bool, shift: usize) -> String {
    let soup = samples::icosphere(6);
    let mut text = String::new();
    for [x, y, z] in &soup.positions {
        text += &format!("v {} {y} {z}\n", x + 3.0 * shift as f64);
    }
    for i in 0..soup.polygon_count() {
        let mut corners: Vec<u32> =
            soup.polygon(i).iter().map(|v| v + 1 + (shift * soup.positions.len()) as u32).collect();
        if flip(i) {
            corners.reverse();
        }
        text += &format!("f {} {} {}\n", corners[0], corners[1], corners[2]);
    }
    text
}

#[test]
fn made_meshes_with_every_blocking_defect_are_repaired_and_cut() {
    let ball = icosphere_text(|_| false, 0);
    let cases = BTreeMap::from([
        ("flipped", icosphere_text(|i| i % 3 == 0, 0)),
        // A teapot's way: parts that touch along an edge, and a doubled patch.
        (
            "teapot-like",
            format!("{ball}v 0 3 0\nv 1 3 1\nf 1 2 363\nf 2 1 364\nf 1 2 3\nf 3 2 1\n"),
        ),
        ("bow-tie", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nf 1 2 3\nf 1 4 5\n".into()),
        // An ogre's way: many closed parts, some inside out, loose vertices, a sliver, faces that repeat a vertex.
        (
            "ogre-like",
            format!(
                "{ball}{}{}v 0 0 9\nf 1 1 2\nf 1 2 2 3\n",
                icosphere_text(|_| true, 1),
                icosphere_text(|_| false, 2)
            ),
        ),
        ("moebius", {
            let mut text = String::new();
            for i in 0..24 {
                let (s, c) = (f64::from(i) * std::f64::consts::TAU / 24.0).sin_cos();
                let (hs, hc) = (f64::from(i) * std::f64::consts::PI / 24.0).sin_cos();
                for w in [-0.3, 0.3] {
                    text +=
                        &format!("v {} {} {}\n", (1.0 + w * hc) * c, w * hs, (1.0 + w * hc) * s);
                }
            }
            for i in 0..24 {
                let [a, b] = [2 * i + 1, 2 * i + 2];
                let [c, d] = if i == 23 { [2, 1] } else { [2 * i + 3, 2 * i + 4] };
                text += &format!("f {a} {c} {d} {b}\n");
            }
            text
        }),
    ]);
    for (name, text) in cases {
        let mut session = run_through(&format!("{name}.obj"), text.as_bytes());
        let events = session.handle(Command::Undo);
        assert!(errors(&events).is_empty(), "{name}");
    }
}

#[test]
fn repairs_are_undone_and_redone() {
    let mut session = Session::new();
    session.open("flipped.obj", icosphere_text(|i| i % 3 == 0, 0).as_bytes());
    let before = session.export("Mesh (OBJ)").unwrap().bytes;
    assert!(!session.info_report().unwrap().solvable);
    session.handle(Command::Repair { id: "orient".into() });
    assert!(session.info_report().unwrap().solvable);
    let after = session.export("Mesh (OBJ)").unwrap().bytes;
    assert_ne!(before, after);
    session.handle(Command::Step);
    session.handle(Command::Undo);
    session.handle(Command::Undo);
    assert_eq!(session.export("Mesh (OBJ)").unwrap().bytes, before);
    session.handle(Command::Redo);
    assert_eq!(session.export("Mesh (OBJ)").unwrap().bytes, after);
    assert_eq!(errors(&session.handle(Command::Repair { id: "orient".into() })).len(), 1);
    assert_eq!(errors(&session.handle(Command::Repair { id: "magic".into() })).len(), 1);
}

#[test]
fn the_unit_and_one_side_give_the_size() {
    let size = |events: &[Event]| {
        events.iter().rev().find_map(|event| match event {
            Event::Size { boxes, display_unit, .. } => Some((*boxes, display_unit.clone())),
            _ => None,
        })
    };
    let text = grid(4, |i, j| [f64::from(i), 2.0 * f64::from(j), 0.1 * f64::from(i * j)]);
    let mut session = Session::new();
    let (boxes, unit) = size(&session.open("sheet.obj", text.as_bytes())).unwrap();
    assert_eq!((boxes[1], unit.as_str()), (300.0, "mm"));
    let (boxes, unit) = size(&session.handle(Command::SetUnit { id: "in".into() })).unwrap();
    assert_eq!((boxes, unit.as_str()), ([4.0, 8.0, 1.6], "inch"));
    let (boxes, _) = size(&session.handle(Command::SetSize { axis: 0, value: 10.0 })).unwrap();
    for (is, exact) in boxes.iter().zip([10.0, 20.0, 4.0]) {
        assert!((is - exact).abs() < 1e-12);
    }
    for kind in ["Mesh (OBJ)", "UV mesh (OBJ)", "Cut curves (OBJ)", "Cut (JSON)"] {
        let text = String::from_utf8(session.export(kind).unwrap().bytes).unwrap();
        // 8 units are 20 inches.
        assert!(text.contains("63.5"), "{kind}");
    }
    let svg = String::from_utf8(session.export("Pattern (SVG)").unwrap().bytes).unwrap();
    assert!(svg.contains("1 unit of the model = 63.5 mm"));
    for (axis, value) in [(0, 0.0), (0, f64::NAN), (1, 1e9), (7, 1.0)] {
        let events = session.handle(Command::SetSize { axis, value });
        assert_eq!(errors(&events).len(), 1);
    }
    let (boxes, _) = size(&session.handle(Command::Undo)).unwrap();
    assert_eq!(boxes, [4.0, 8.0, 1.6]);
}

#[test]
fn every_preparation_gives_another_mesh_that_can_be_cut_and_undone() {
    for (tool, values) in [
        ("subdivide", vec![("rounds", 1.0)]),
        ("refine", vec![("tolerance", 4.0)]),
        ("remesh", vec![("edge", 1.3)]),
        ("decimate", vec![("faces", 500.0)]),
    ] {
        let mut session = Session::new();
        session.open("ball.obj", icosphere_text(|_| false, 0).as_bytes());
        let before = session.export("Mesh (OBJ)").unwrap().bytes;
        let values = values.into_iter().map(|(id, x): (&str, f64)| (id.to_owned(), x)).collect();
        let events = session.handle(Command::Prepare { tool: tool.into(), values });
        assert!(errors(&events).is_empty() && session.is_running(), "{tool}");
        let mut events = Vec::new();
        for _ in 0..100_000 {
            if !session.is_running() {
                break;
            }
            events.extend(session.advance(&mut || false));
        }
        assert!(!session.is_running(), "{tool} ends");
        assert!(events.iter().any(|e| matches!(e, Event::Progress { .. })), "{tool}");
        assert!(errors(&events).is_empty(), "{tool}: {:?}", errors(&events));
        let info = session.info_report().unwrap();
        assert!(info.solvable && info.faces != 720, "{tool}: {}", info.faces);
        assert_eq!((info.components, info.boundary_loops, info.genus), (1, 0, Some(0)), "{tool}");
        assert!(errors(&session.handle(Command::Step)).is_empty(), "{tool}");
        session.handle(Command::Undo);
        session.handle(Command::Undo);
        assert_eq!(session.export("Mesh (OBJ)").unwrap().bytes, before, "{tool}");
    }
}

#[test]
fn a_preparation_that_is_cancelled_leaves_everything_as_it_was() {
    let mut session = Session::new();
    session.open("ball.obj", icosphere_text(|_| false, 0).as_bytes());
    session.handle(Command::Step);
    let before = session.export("UV mesh (OBJ)").unwrap().bytes;
    session.handle(Command::Prepare { tool: "remesh".into(), values: BTreeMap::new() });
    session.advance(&mut || false);
    session.handle(Command::Cancel);
    assert!(!session.is_running());
    assert_eq!(session.export("UV mesh (OBJ)").unwrap().bytes, before);
    let wrong = [("edge", 100.0), ("edge", f64::NAN), ("sharpness", 1.0)];
    for (id, value) in wrong {
        let values = BTreeMap::from([(id.to_owned(), value)]);
        let events = session.handle(Command::Prepare { tool: "remesh".into(), values });
        assert_eq!(errors(&events).len(), 1, "{id}");
    }
    let events =
        session.handle(Command::Prepare { tool: "polish".into(), values: BTreeMap::new() });
    assert_eq!(errors(&events).len(), 1);
}

#[test]
fn findings_are_marked_on_the_surface_and_unmarked() {
    let mut session = Session::new();
    let text = icosphere_text(|_| false, 0) + "v 3 0 0\nv 3 1 0\nv 4 0 0\nf 363 364 365\n";
    session.open("two.obj", text.as_bytes());
    let pieces = session.scene().unwrap();
    session.handle(Command::ShowFinding { id: Some("boundary_loops".into()) });
    let marked = session.scene().unwrap();
    assert_eq!(marked.mark_segments.len(), 3 * 6);
    session.handle(Command::ShowFinding { id: None });
    let again = session.scene().unwrap();
    assert!(again.mark_segments.is_empty() && again.triangles == pieces.triangles);
}

#[test]
fn a_large_mesh_is_shown_before_its_first_cut() {
    let text = grid(170, |i, j| {
        let (x, y) = (f64::from(i) / 170.0, f64::from(j) / 170.0);
        [x, y, 0.3 * (9.0 * x).sin() * (7.0 * y).cos()]
    });
    let mut session = Session::new();
    let events = session.open("large.obj", text.as_bytes());
    assert!(errors(&events).is_empty() && session.is_running());
    let first = session.scene().unwrap();
    assert!(first.charts.iter().all(|x| x.is_nan()), "the mesh, not yet cut");
    while session.is_running() {
        session.advance(&mut || false);
    }
    assert!(session.scene().unwrap().charts.iter().any(|x| x.is_finite()));
    // A mesh too large to be cut in short time is reduced first.
    let mut reduced = Session::new();
    reduced.open("large.obj", text.as_bytes());
    let values = BTreeMap::from([("faces".to_owned(), 4000.0)]);
    reduced.handle(Command::Prepare { tool: "decimate".into(), values });
    let mut first_energy = None;
    while reduced.is_running() {
        reduced.advance(&mut || false);
        if !reduced.history().is_empty() {
            first_energy.get_or_insert(reduced.info_report().unwrap().faces);
        }
    }
    assert_eq!(first_energy, Some(reduced.info_report().unwrap().faces));
    assert!(reduced.info_report().unwrap().faces <= 4000);
    // Whoever does not wait gets the cut all the same.
    let mut hasty = Session::new();
    hasty.open("large.obj", text.as_bytes());
    let events =
        hasty.handle(Command::SetParameter { id: "length".into(), value: Value::Number(3.0) });
    assert!(errors(&events).is_empty() && hasty.is_running());
    let events = hasty.handle(Command::Cancel);
    assert!(errors(&events).is_empty() && !hasty.is_running() && hasty.history().is_empty());
    // The mesh itself needs no cut.
    assert!(!hasty.export("Mesh (OBJ)").unwrap().bytes.is_empty() && hasty.history().is_empty());
    assert!(errors(&hasty.handle(Command::Step)).is_empty() && !hasty.history().is_empty());
}

/// Sides of the box around [`icosphere_text`].
fn size_of_ball() -> [f64; 3] {
    document("ball.obj", icosphere_text(|_| false, 0).as_bytes()).unwrap().size()
}

#[test]
fn dropping_parts_keeps_the_real_size_of_the_others() {
    // Balls of radius 1 and 4.
    let mut text = icosphere_text(|_| false, 0);
    let soup = samples::icosphere(6);
    for [x, y, z] in &soup.positions {
        text += &format!("v {} {} {}\n", 4.0 * x + 20.0, 4.0 * y, 4.0 * z);
    }
    for i in 0..soup.polygon_count() {
        let [a, b, c] = [0, 1, 2].map(|k| soup.polygon(i)[k] + 1 + 362);
        text += &format!("f {a} {b} {c}\n");
    }
    let mut session = Session::new();
    session.open("two.obj", text.as_bytes());
    session.handle(Command::SetUnit { id: "mm".into() });
    // Either part can be kept alone, the larger one is offered first.
    let offered = |session: &Session| session.info_report().unwrap().notices[0].repairs.clone();
    assert_eq!(offered(&session), ["keep_largest", "keep_component:1", "keep_component:0"]);
    session.handle(Command::Repair { id: "keep_component:0".into() });
    assert_eq!(session.info_report().unwrap().size, size_of_ball());
    session.handle(Command::Undo);
    let events = session.handle(Command::Repair { id: "keep_largest".into() });
    assert!(errors(&events).is_empty(), "{:?}", errors(&events));
    let boxes = events.iter().find_map(|event| match event {
        Event::Size { boxes, .. } => Some(*boxes),
        _ => None,
    });
    // An icosphere's vertices reach the poles along y.
    assert!((boxes.unwrap()[1] - 8.0).abs() < 1e-9, "{boxes:?}");
    // What was dropped leaves no vertices behind, and what is written opens at the same size.
    assert_eq!(session.info_report().unwrap().vertices, 362);
    session.handle(Command::SetSize { axis: 1, value: 20.0 });
    let written = session.export("Mesh (OBJ)").unwrap().bytes;
    let events = Session::new().open("again.obj", &written);
    let boxes = events.iter().find_map(|event| match event {
        Event::Size { boxes, is_assumed, .. } => (!is_assumed).then_some(*boxes),
        _ => None,
    });
    assert!((boxes.unwrap()[1] - 20.0).abs() < 1e-9, "{boxes:?}");
}

#[test]
fn only_the_parts_that_are_inside_out_are_turned() {
    let text = icosphere_text(|_| false, 0) + &icosphere_text(|_| true, 1);
    let d = document("two.obj", text.as_bytes()).unwrap();
    let surface = d.surface.as_ref().unwrap();
    for (f, (turned, given)) in surface.mesh.triangles().iter().zip(&d.triangles).enumerate() {
        let is_same = turned.map(|v| v.0) == *given;
        assert_eq!(is_same, f < 720, "face {f}");
    }
    let marked = cutflow::mesh::doctor::FindingKind::InsideOut;
    assert_eq!(d.examination.find(marked).unwrap().count, 1);
}

#[test]
fn faces_without_area_on_axis_aligned_lines_are_drawn() {
    // A vertex in the middle of an edge, and two at one place: normals that do not exist.
    let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 0 0\nv 1 -1 0\nv 2 2 0\nv 3 3 1\nv 0 3 1\n\
        f 5 2 3\nf 5 3 4\nf 5 4 1\nf 1 2 5\nf 1 6 2\nf 4 3 7\nf 4 7 9\nf 7 8 9\n";
    let mut session = Session::new();
    let events = session.open("caps.obj", text.as_bytes());
    assert!(errors(&events).is_empty() && session.info_report().unwrap().solvable);
    for field in ["pieces", "u", "curvature", "area", "angle"] {
        session.handle(Command::ShowField { id: field.into() });
        assert_sound(&mut session, field);
    }
    assert!(errors(&session.handle(Command::Step)).is_empty());
    assert_sound(&mut session, "after a step");
}

#[test]
fn what_changes_nothing_says_so() {
    let mut session = Session::new();
    session.open("ball.obj", icosphere_text(|_| false, 0).as_bytes());
    assert_eq!(errors(&session.handle(Command::RepairAll)).len(), 1);
    let values = BTreeMap::from([("faces".to_owned(), 5000.0)]);
    session.handle(Command::Prepare { tool: "decimate".into(), values });
    let mut events = Vec::new();
    while session.is_running() {
        events.extend(session.advance(&mut || false));
    }
    assert_eq!(errors(&events).len(), 1);
    let values = BTreeMap::from([("edge".to_owned(), 0.25), ("adaptivity".to_owned(), 1.0)]);
    let mut large = Session::new();
    large.handle(Command::OpenSample { name: "plush_bear".into() });
    let events = large.handle(Command::Prepare { tool: "remesh".into(), values });
    assert_eq!(errors(&events).len(), 1, "too many triangles are refused before they are made");
}
