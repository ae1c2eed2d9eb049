//! Exported files are safe to cut: no triangle turned over, nothing covered twice. Checked here from the text of the files alone, in whole
//! numbers, with nothing of what the engine uses for it.

use std::collections::BTreeMap;

use cutflow::session::{Command, Session, Value};

use crate::scripts::{errors, set};

/// Digits after the point that count: coordinates within [0, 1] have 17 at most.
const UNIT: i128 = 1_000_000_000_000_000_000;

/// What overlaps by less is a touch: the two sides of a slit come from different sums. A millionth of a laser's kerf on a sheet of a metre.
const TOUCH: f64 = 1e-10;

type Point = [i128; 2];

/// A decimal number in units of 10⁻¹⁸, exactly.
fn fixed(text: &str) -> i128 {
    let (mantissa, exponent) = match text.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().unwrap()),
        None => (text, 0),
    };
    let (sign, digits) = match mantissa.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, mantissa),
    };
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let value: i128 = format!("{whole}{part}").parse().unwrap();
    let shift = 18 + exponent - part.len() as i32;
    sign * if shift >= 0 {
        value * 10i128.pow(shift as u32)
    } else {
        value / 10i128.pow(shift.unsigned_abs().min(38))
    }
}

fn turn([a, b, c]: [Point; 3]) -> i128 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The triangles of a file in the plane of its texture coordinates, and how many have none.
fn flat_triangles(obj: &str) -> (Vec<[Point; 3]>, usize) {
    let (mut places, mut triangles, mut bare) = (Vec::new(), Vec::new(), 0);
    for line in obj.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vt") => {
                let mut next = || fixed(words.next().unwrap());
                places.push([next(), next()]);
            }
            Some("f") => {
                let corner = |word: &str| -> Option<Point> {
                    let number: usize = word.split('/').nth(1)?.parse().ok()?;
                    Some(places[number - 1])
                };
                let corners: Vec<_> = words.map(corner).collect();
                assert_eq!(corners.len(), 3, "{line}");
                match (corners[0], corners[1], corners[2]) {
                    (Some(a), Some(b), Some(c)) => triangles.push([a, b, c]),
                    _ => bare += 1,
                }
            }
            _ => {}
        }
    }
    (triangles, bare)
}

/// Whether no side of either triangle has the other on its far side.
fn overlap(s: &[Point; 3], t: &[Point; 3]) -> bool {
    let parts = |s: &[Point; 3], t: &[Point; 3]| {
        (0..3).any(|i| {
            let (a, b) = (s[i], s[(i + 1) % 3]);
            let length = ((b[0] - a[0]) as f64).hypot((b[1] - a[1]) as f64);
            t.iter().all(|&p| turn([a, b, p]) as f64 <= TOUCH * length * UNIT as f64)
        })
    };
    !parts(s, t) && !parts(t, s)
}

/// Triangles turned over, and pairs that overlap.
fn faults(triangles: &[[Point; 3]]) -> (usize, usize) {
    let flipped = triangles.iter().filter(|&&t| turn(t) <= 0).count();
    let cells = ((triangles.len() as f64).sqrt() as i128).clamp(1, 1000);
    let cell = |x: i128| (x * cells / (UNIT + 1)).clamp(0, cells - 1);
    let range = |t: &[Point; 3], axis: usize| {
        let of = |i: usize| t[i][axis];
        (cell(of(0).min(of(1)).min(of(2))), cell(of(0).max(of(1)).max(of(2))))
    };
    let mut grid: BTreeMap<(i128, i128), Vec<usize>> = BTreeMap::new();
    for (i, t) in triangles.iter().enumerate() {
        let ((x, to_x), (y, to_y)) = (range(t, 0), range(t, 1));
        for column in x..=to_x {
            for row in y..=to_y {
                grid.entry((column, row)).or_default().push(i);
            }
        }
    }
    let mut pairs = std::collections::BTreeSet::new();
    for members in grid.values() {
        for (k, &i) in members.iter().enumerate() {
            for &j in &members[k + 1..] {
                if overlap(&triangles[i], &triangles[j]) {
                    pairs.insert((i, j));
                }
            }
        }
    }
    (flipped, pairs.len())
}

fn run(session: &mut Session) {
    let mut steps = 0;
    while session.is_running() {
        // Each slice is one step: a flow that has just begun has the most crooked cut.
        let events = session.advance(&mut || false);
        assert!(errors(&events).is_empty(), "{:?}", errors(&events));
        steps += 1;
        if steps == 200 {
            session.handle(Command::Pause);
        }
    }
}

/// Looks at the files that a session exports.
pub fn look(session: &mut Session, name: &str) {
    let file = session.export("UV mesh (OBJ)").unwrap();
    let (triangles, bare) = flat_triangles(std::str::from_utf8(&file.bytes).unwrap());
    assert_eq!(bare, 0, "{name}: triangles without a place");
    assert_eq!(faults(&triangles), (0, 0), "{name}: turned over, covered twice");
}

/// Cuts by the flow and by cones, exports, looks.
fn try_both(name: &str, mut session: Session) {
    if session.document().is_none_or(|document| document.surface().is_err()) {
        session.handle(Command::RepairAll);
    }
    set(&mut session, "steps", Value::Number(6.0));
    session.handle(Command::Run);
    run(&mut session);
    look(&mut session, &format!("{name}, cut flow"));
    session.handle(Command::SetMethod { id: "cones".into() });
    run(&mut session);
    look(&mut session, &format!("{name}, cones"));
}

#[test]
fn the_check_itself_finds_what_is_wrong() {
    let at = |x: f64, y: f64| [(x * UNIT as f64) as i128, (y * UNIT as f64) as i128];
    let square = [at(0.1, 0.1), at(0.6, 0.1), at(0.6, 0.6), at(0.1, 0.6)];
    let [a, b, c, d] = square;
    assert_eq!(faults(&[[a, b, c], [a, c, d]]), (0, 0), "neighbours");
    assert_eq!(faults(&[[a, b, c], [a, d, c]]), (1, 0), "turned over");
    assert_eq!(faults(&[[a, b, c], [a, b, d]]), (0, 1), "on the same side of an edge");
    assert_eq!(faults(&[[a, b, c], [at(0.4, 0.2), at(0.9, 0.2), at(0.9, 0.3)]]), (0, 1));
    assert_eq!(fixed("0.25"), UNIT / 4);
    assert_eq!(fixed("-2.5e-3"), -UNIT / 400);
}

#[test]
fn exported_samples_have_no_triangle_turned_over_and_nothing_covered_twice() {
    for name in ["ball", "torus", "plush_bear", "armchair", "car_hood"] {
        let mut session = Session::new();
        let events = session.handle(Command::OpenSample { name: name.into() });
        assert!(errors(&events).is_empty(), "{name}: {:?}", errors(&events));
        try_both(name, session);
    }
}

fn try_shared(name: &str) {
    let path = format!("{}/../shared/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    #[expect(clippy::disallowed_methods, reason = "tests read their files")]
    let Ok(bytes) = std::fs::read(&path) else {
        let text = format!("SKIPPED: {name} needs ../shared/meshes, which is not there\n");
        std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes()).unwrap();
        return;
    };
    let mut session = Session::new();
    let events = session.open(name, &bytes);
    assert!(errors(&events).is_empty(), "{name}: {:?}", errors(&events));
    try_both(name, session);
}

#[test]
fn exported_meshes_have_no_triangle_turned_over_and_nothing_covered_twice() {
    // Strong cones and slivers; handles; creases; several parts; a boundary; hundreds of cones.
    for name in [
        "cheburashka.obj",
        "rocker-arm.obj",
        "fandisk.obj",
        "milk-truck.glb",
        "hood.obj",
        "chair.obj",
    ] {
        try_shared(name);
    }
}

#[test]
#[ignore = "takes minutes: cargo test --test it -- --ignored all_shared"]
fn all_shared_meshes_have_no_triangle_turned_over_and_nothing_covered_twice() {
    for name in [
        "spot.obj",
        "homer.obj",
        "koala.stl",
        "torus.obj",
        "fertility.off",
        "double-torus.obj",
        "hand.obj",
        "beetle.obj",
        "bunny-closed.obj",
        "face.obj",
        "stanford-bunny.obj",
        "armadillo.obj",
        "spot-control.obj",
        "nefertiti.ply",
        "igea.ply",
    ] {
        try_shared(name);
    }
}
