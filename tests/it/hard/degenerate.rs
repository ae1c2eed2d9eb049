//! Surfaces that hardly are any, through every method: something valid, or a reason.

use cutflow::session::{Command, Event, ParamKind, Session, Value, all_specs};

use super::documents::{self, Shape, ball, plate, sheet, triangle, tube, two_triangles};
use super::guarded;
use super::sound::{KINDS, check_events, check_file, check_scene, check_session};

/// A surface and the methods that it goes through.
pub struct Case {
    pub name: String,
    file: Vec<u8>,
    method: Way,
    /// Steps that a method may make, and kinds of files that are written.
    steps: usize,
    kinds: &'static [&'static str],
    /// Whether every way to flatten writes a file: each nests its charts anew, which takes seconds.
    is_long: bool,
}

/// How a surface is cut and flattened.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Cut,
    Cones,
    PhaseField,
    Developable,
    /// Flattened one way after the other, as it is.
    Flatten,
}

const WAYS: [Way; 5] = [Way::Cut, Way::Cones, Way::PhaseField, Way::Developable, Way::Flatten];

/// What the short run writes of cuts, and of charts: one of every sort in all.
const OF_CUTS: [&str; 3] = ["Cut (JSON)", "Pattern (SVG)", "Report (JSON)"];
const OF_CHARTS: [&str; 2] = ["UV mesh (OBJ)", "Pattern (PDF)"];

/// Squares whose columns are thinner and thinner, down to an angle of so many degrees.
fn slivers(degrees: f64) -> Shape {
    let thin = degrees.to_radians().tan() / 6.0;
    sheet(6, 6, |x, y| {
        let squeezed = if x > 0.5 { 0.5 + thin * (x - 0.5) } else { x };
        [squeezed, y, 0.2 * (6.0 * y).sin()]
    })
}

/// A cone of so many long triangles.
fn needles(count: u32, length: f64) -> Shape {
    let rim = (0..count).map(|i| {
        let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(count)).sin_cos();
        [0.001 * c, 0.001 * s, length]
    });
    let points = std::iter::once([0.0; 3]).chain(rim).collect();
    let triangles: Vec<[u32; 3]> = (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect();
    Shape::triangles(points, &triangles)
}

/// A ball that has a second copy of each point, used by half of the triangles.
fn doubled() -> Shape {
    let mut shape = ball(2);
    let n = shape.points.len() as u32;
    shape.points.extend_from_within(..);
    for face in shape.faces.iter_mut().step_by(2) {
        face.iter_mut().for_each(|v| *v += n);
    }
    shape
}

/// A sheet with two holes that meet in a point.
fn touching_holes() -> Shape {
    let mut shape = sheet(6, 6, |x, y| [x, y, 0.1 * (5.0 * x * y).sin()]);
    let is_kept = |cell: usize| ![14, 21].contains(&cell);
    let faces = std::mem::take(&mut shape.faces);
    shape.faces = faces
        .chunks(2)
        .enumerate()
        .filter(|(c, _)| is_kept(*c))
        .flat_map(|(_, f)| f.to_vec())
        .collect();
    shape
}

/// Shapes by name; the long run has larger ones.
fn shapes(is_long: bool) -> Vec<(&'static str, Shape)> {
    let scaled = |shape: Shape, by: f64| shape.moved(|p| p.map(|x| by * x));
    let parts = if is_long { 500 } else { 60 };
    let many = (0..parts).fold(Shape::default(), |all, i| {
        let place =
            |p: [f64; 3]| [p[0] + 3.0 * f64::from(i % 25), p[1] + 3.0 * f64::from(i / 25), p[2]];
        all.with(&documents::tetrahedron().moved(place))
    });
    let flat_part = sheet(2, 2, |x, _| [x, 0.0, 5.0]);
    let line = Shape::triangles(vec![[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]], &[[0, 1, 2]]);
    let mut shapes = vec![
        ("slivers of 0.01°", slivers(0.01)),
        ("slivers of 1e-7°", slivers(1e-7)),
        ("needles", needles(7, 1.0)),
        ("longer needles", needles(5, 1e5)),
        ("duplicate points", doubled()),
        ("coordinates at 1e9", ball(3).moved(|p| [p[0] + 1e9, p[1] - 1e9, p[2] + 1e9])),
        ("size 1e9", scaled(ball(2), 1e9)),
        ("size 1e-6", scaled(ball(2), 1e-6)),
        ("size 1e-30", scaled(ball(2), 1e-30)),
        ("size 1e30", scaled(ball(2), 1e30)),
        ("flat", sheet(5, 5, |x, y| [x, y, 0.0])),
        ("flat part", ball(2).with(&sheet(3, 3, |x, y| [x, y, 3.0]))),
        ("collinear part", ball(2).with(&flat_part)),
        ("collinear", line),
        ("part of no area", ball(2).with(&triangle().moved(|_| [2.0; 3]))),
        ("folded onto itself", sheet(6, 4, |x, y| [(x - 0.5).abs(), y, 0.0])),
        ("holes that touch", touching_holes()),
        ("one triangle", triangle()),
        ("two triangles", two_triangles()),
        ("tetrahedron", documents::tetrahedron()),
        ("squashed ball", ball(3).moved(|p| [p[0], p[1], 1e-9 * p[2]])),
        ("tube of three sides", tube(3, 1)),
        ("many components", many),
        ("genus 3", plate(3)),
    ];
    if is_long {
        shapes.push(("genus 31", plate(31)));
    }
    shapes
}

/// All cases: every shape through every method.
pub fn cases(is_long: bool) -> Vec<Case> {
    let shapes = shapes(is_long);
    let case = |(name, shape): &(&str, Shape), method: Way| Case {
        name: format!("{name}, {method:?}"),
        file: shape.obj(),
        method,
        steps: if is_long { 200 } else { 8 },
        kinds: match (is_long, method) {
            (true, _) => &KINDS,
            (false, Way::Flatten) => &OF_CHARTS,
            (false, _) => &OF_CUTS,
        },
        is_long,
    };
    shapes.iter().flat_map(|shape| WAYS.map(|way| case(shape, way))).collect()
}

/// What came of it: `cut`, `refused: …`.
pub fn run(case: &Case) -> Result<String, String> {
    guarded(|| through(case)).map_err(|what| format!("{}: {what}", case.name))
}

/// All ways to flatten that can be chosen.
fn ways_to_flatten() -> Vec<String> {
    let specs = all_specs();
    let kind = specs.iter().find(|spec| spec.id == "flatten").map(|spec| &spec.kind);
    match kind {
        Some(ParamKind::Choice { options }) => options.iter().map(|o| o.id.clone()).collect(),
        _ => panic!("there is no choice of ways to flatten"),
    }
}

fn problem_of(events: &[Event]) -> Option<String> {
    events.iter().find_map(|event| match event {
        Event::Error { what, .. } => Some(what.clone()),
        _ => None,
    })
}

fn through(case: &Case) -> Result<String, String> {
    let mut session = Session::new();
    let mut told = Vec::new();
    let mut check = |events: Vec<Event>| -> Result<(), String> {
        check_events(&events)?;
        told.extend(problem_of(&events));
        Ok(())
    };
    check(session.open("thing.obj", &case.file))?;
    if session.document().is_none() {
        return Ok(format!("refused: {}", told.join(" ")));
    }
    if session.document().is_some_and(|d| d.surface.is_none()) {
        check(session.handle(Command::RepairAll))?;
        if session.document().is_some_and(|d| d.surface.is_none()) {
            let summary = session.document().map(|d| format!("{:?}", d.summary.notices.first()));
            return Ok(format!("not repaired: {}", summary.unwrap_or_default()));
        }
    }
    let method = match case.method {
        Way::Cut | Way::Flatten => "cutflow",
        Way::Cones => "cones",
        Way::PhaseField => "phasefield",
        Way::Developable => "developable",
    };
    check(session.handle(Command::SetMethod { id: method.into() }))?;
    let ways = if case.method == Way::Flatten { ways_to_flatten() } else { Vec::new() };
    if case.method != Way::Flatten {
        check(session.handle(Command::Run))?;
        let mut left = case.steps;
        while session.is_running() && left > 0 {
            left -= 1;
            check(session.advance(&mut || false))?;
        }
        check(session.handle(Command::Pause))?;
    }
    for way in ways {
        let value = Value::Text(way);
        let events = session.handle(Command::SetParameter { id: "flatten".into(), value });
        check_events(&events)?;
        let mut left = 60;
        while session.is_running() && left > 0 {
            left -= 1;
            check(session.advance(&mut || false))?;
        }
        check_session(&mut session)?;
        if case.is_long
            && let Ok(file) = session.export("UV mesh (OBJ)")
        {
            check_file("UV mesh (OBJ)", &file)?;
        }
    }
    if let Some(scene) = session.scene() {
        check_scene(&scene)?;
    }
    check_session(&mut session)?;
    let mut written = 0;
    for kind in case.kinds {
        if let Ok(file) = session.export(kind) {
            check_file(kind, &file)?;
            written += 1;
        }
    }
    check(session.handle(Command::ShowPattern { is_shown: true }))?;
    let pieces = session.layout().map_or(0, |layout| layout.opened.patch_count);
    told.truncate(1);
    Ok(format!(
        "{pieces} pieces, {written} files{}{}",
        if told.is_empty() { "" } else { "; " },
        told.join(" ")
    ))
}

#[test]
#[ignore = "its time is not known yet: `cargo xtask soak --only degenerate` runs all of it"]
fn surfaces_that_hardly_are_any_are_flattened_or_refused_with_a_reason() {
    let mut faults = Vec::new();
    for case in cases(false) {
        let start = super::processor_seconds();
        let result = run(&case);
        if let (Some(start), Some(end)) = (start, super::processor_seconds()) {
            println!("{:<36} {:>6.2} s", case.name, end - start);
        }
        match result {
            Ok(end) => assert!(!end.is_empty() && end != "refused: ", "{}", case.name),
            Err(what) => faults.push(what),
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
