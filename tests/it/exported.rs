//! Exported files are safe to cut: no triangle turned over, nothing covered twice. Checked here from the bytes of the files alone, in whole
//! numbers, with nothing of what the engine uses for it.

use std::collections::BTreeMap;

use cutflow::session::{Command, Session, Value};

use crate::scripts::{errors, set};

/// Digits after the point that count: coordinates within [0, 1] have 17 at most.
const UNIT: i128 = 1_000_000_000_000_000_000;

/// Steps of a flow whose cut is as crooked as it gets.
const FEW: f64 = 6.0;

/// What overlaps by less is a touch: the two sides of a slit come from different sums. A millionth of a laser's kerf on a sheet of a metre.
const TOUCH: f64 = 1e-10;

/// The same where coordinates have 24 bits.
const TOUCH_32: f64 = 2e-7;

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
fn overlap(s: &[Point; 3], t: &[Point; 3], touch: f64) -> bool {
    let parts = |s: &[Point; 3], t: &[Point; 3]| {
        (0..3).any(|i| {
            let (a, b) = (s[i], s[(i + 1) % 3]);
            let length = ((b[0] - a[0]) as f64).hypot((b[1] - a[1]) as f64);
            t.iter().all(|&p| turn([a, b, p]) as f64 <= touch * length * UNIT as f64)
        })
    };
    !parts(s, t) && !parts(t, s)
}

/// Triangles turned over, and pairs that overlap.
fn faults(triangles: &[[Point; 3]], touch: f64) -> (usize, usize) {
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
                if overlap(&triangles[i], &triangles[j], touch) {
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
        if steps == 2000 {
            session.handle(Command::Pause);
        }
    }
}

/// The triangles of a GLB file in the plane of its texture coordinates, whose v points down.
fn glb_triangles(bytes: &[u8]) -> Vec<[Point; 3]> {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let json = 20..20 + word(12);
    let binary = json.end + 8;
    let root: serde_json::Value = serde_json::from_slice(&bytes[json]).unwrap();
    // Where the values of an accessor begin, how far they are apart, how many there are, and of what type.
    let accessor = |number: &serde_json::Value, size: usize| {
        let accessor = &root["accessors"][number.as_u64().unwrap() as usize];
        let view = &root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let whole = |value: &serde_json::Value| value.as_u64().unwrap_or(0) as usize;
        let begin = binary + whole(&view["byteOffset"]) + whole(&accessor["byteOffset"]);
        let stride = whole(&view["byteStride"]).max(size);
        (begin, stride, whole(&accessor["count"]), whole(&accessor["componentType"]))
    };
    let mut triangles = Vec::new();
    let meshes = root["meshes"].as_array().unwrap().iter();
    for primitive in meshes.flat_map(|mesh| mesh["primitives"].as_array().unwrap()) {
        let (begin, stride, count, kind) = accessor(&primitive["attributes"]["TEXCOORD_0"], 8);
        assert_eq!(kind, 5126, "32-bit numbers");
        // Exact in units of 2⁻⁶⁰, which are about those of texts.
        let exact =
            |at: usize| (f64::from(f32::from_bits(word(at) as u32)) * 2f64.powi(60)) as i128;
        let one = 1i128 << 60;
        let places: Vec<Point> = (0..count)
            .map(|i| begin + i * stride)
            .map(|at| [exact(at), one - exact(at + 4)])
            .collect();
        let (begin, _, count, kind) = accessor(&primitive["indices"], 0);
        let index = |i: usize| match kind {
            5123 => {
                usize::from(u16::from_le_bytes([bytes[begin + 2 * i], bytes[begin + 2 * i + 1]]))
            }
            5125 => word(begin + 4 * i),
            _ => panic!("indices of kind {kind}"),
        };
        let corner = |i: usize| places[index(i)];
        triangles.extend((0..count / 3).map(|t| [0, 1, 2].map(|k| corner(3 * t + k))));
    }
    triangles
}

/// The outlines that an SVG pattern is cut along, in units of .1 µm.
fn cut_outlines(svg: &str) -> Vec<Vec<Point>> {
    let mut outlines = Vec::new();
    let cut = svg.split_once("<g id=\"cut\"").unwrap().1;
    let cut = cut.split_once("</g>").unwrap().0;
    for path in cut.split("<path ").skip(1) {
        let d = path.split_once(" d=\"").unwrap().1.split_once('"').unwrap().0;
        for part in d.split('Z').filter(|part| !part.trim().is_empty()) {
            let numbers: Vec<&str> = part
                .split(|c: char| c.is_whitespace() || c == ',')
                .map(|word| word.trim_start_matches(['M', 'L']))
                .filter(|word| !word.is_empty())
                .collect();
            let unit = UNIT / 10_000;
            let exact = |text: &str| fixed(text) / unit;
            outlines.push(numbers.chunks(2).map(|p| [exact(p[0]), exact(p[1])]).collect());
        }
    }
    outlines
}

/// Pairs of sides of closed outlines that cross by more than a hundredth of a millimetre.
fn crossings(outlines: &[Vec<Point>]) -> usize {
    let tolerance = 100.0;
    let mut sides = Vec::new();
    for outline in outlines {
        for (i, &a) in outline.iter().enumerate() {
            let b = outline[(i + 1) % outline.len()];
            if a != b {
                sides.push([a, b]);
            }
        }
    }
    sides.sort_by_key(|[a, b]| a[0].min(b[0]));
    let off = |[a, b]: [Point; 2], p: Point| {
        turn([a, b, p]) as f64 / ((b[0] - a[0]) as f64).hypot((b[1] - a[1]) as f64)
    };
    let parted = |s: [Point; 2], t: [Point; 2]| {
        let [p, q] = t.map(|p| off(s, p));
        p.min(q) < -tolerance && p.max(q) > tolerance
    };
    let mut count = 0;
    for (i, &s) in sides.iter().enumerate() {
        let end = s[0][0].max(s[1][0]);
        let near = sides[i + 1..].iter().take_while(|t| t[0][0].min(t[1][0]) <= end);
        count += near.filter(|&&t| parted(s, t) && parted(t, s)).count();
    }
    count
}

/// Outlines that lie within another one.
fn swallowed(outlines: &[Vec<Point>]) -> usize {
    // The midpoint of a side, doubled: a corner may touch.
    let inside = |p: Point, outline: &[Point]| {
        let mut is_inside = false;
        for (i, a) in outline.iter().enumerate() {
            let (a, b) = (a.map(|x| 2 * x), outline[(i + 1) % outline.len()].map(|x| 2 * x));
            if (a[1] > p[1]) != (b[1] > p[1]) {
                let is_left = turn([a, b, p]) > 0;
                is_inside ^= is_left == (b[1] > a[1]);
            }
        }
        is_inside
    };
    let pairs = outlines.iter().enumerate().flat_map(|(i, s)| {
        outlines.iter().enumerate().filter(move |(j, _)| *j != i).map(move |(_, t)| (s, t))
    });
    pairs.filter(|(s, t)| inside([s[0][0] + s[1][0], s[0][1] + s[1][1]], t)).count()
}

/// Looks at the files that a session exports.
pub fn look(session: &mut Session, name: &str) {
    let bytes = |session: &mut Session, kind: &str| session.export(kind).unwrap().bytes;
    let obj = bytes(session, "UV mesh (OBJ)");
    let (triangles, bare) = flat_triangles(std::str::from_utf8(&obj).unwrap());
    assert_eq!(bare, 0, "{name}: triangles without a place");
    assert_eq!(faults(&triangles, TOUCH), (0, 0), "{name}, OBJ: turned over, covered twice");
    let glb = glb_triangles(&bytes(session, "UV mesh (GLB)"));
    assert_eq!(glb.len(), triangles.len(), "{name}, GLB");
    assert_eq!(faults(&glb, TOUCH_32), (0, 0), "{name}, GLB: turned over, covered twice");
    let svg = bytes(session, "Pattern (SVG)");
    let outlines = cut_outlines(std::str::from_utf8(&svg).unwrap());
    let found = (outlines.is_empty(), crossings(&outlines), swallowed(&outlines));
    assert_eq!(found, (false, 0, 0), "{name}, SVG: outlines cross, lie in others");
}

/// Cuts by so many steps of the flow, or all that it takes, and by cones, exports, looks.
fn try_both(name: &str, mut session: Session, steps: f64) {
    if session.document().is_none_or(|document| document.surface().is_err()) {
        session.handle(Command::RepairAll);
    }
    set(&mut session, "steps", Value::Number(steps));
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
    assert_eq!(faults(&[[a, b, c], [a, c, d]], TOUCH), (0, 0), "neighbours");
    assert_eq!(faults(&[[a, b, c], [a, d, c]], TOUCH), (1, 0), "turned over");
    assert_eq!(faults(&[[a, b, c], [a, b, d]], TOUCH), (0, 1), "on the same side of an edge");
    assert_eq!(faults(&[[a, b, c], [at(0.4, 0.2), at(0.9, 0.2), at(0.9, 0.3)]], TOUCH), (0, 1));
    assert_eq!(fixed("0.25"), UNIT / 4);
    assert_eq!(fixed("-2.5e-3"), -UNIT / 400);
    // Of a pattern: squares of a centimetre beside each other, across each other, within each other, and a bow tie.
    let square = |x: i128, size: i128| -> Vec<Point> {
        [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| [x + size * i, x + size * j]).to_vec()
    };
    let (one, far) = (square(0, 100_000), square(100_000, 100_000));
    assert_eq!(crossings(&[one.clone(), far]), 0);
    assert_eq!(crossings(&[one.clone(), square(50_000, 100_000)]), 2);
    assert_eq!(crossings(&[vec![one[0], one[2], one[1], one[3]]]), 1);
    assert_eq!(swallowed(&[one.clone(), square(20_000, 10_000)]), 1);
    assert_eq!(swallowed(&[one, square(200_000, 10_000)]), 0);
}

#[test]
fn exported_samples_have_no_triangle_turned_over_and_nothing_covered_twice() {
    for name in ["ball", "torus", "plush_bear", "armchair", "car_hood"] {
        let mut session = Session::new();
        let events = session.handle(Command::OpenSample { name: name.into() });
        assert!(errors(&events).is_empty(), "{name}: {:?}", errors(&events));
        try_both(name, session, FEW);
    }
}

fn try_shared(name: &str, steps: f64) {
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
    try_both(name, session, steps);
}

/// Strong cones and slivers; handles; creases; several parts; a boundary; hundreds of cones.
const SOME: [&str; 6] =
    ["cheburashka.obj", "rocker-arm.obj", "fandisk.obj", "milk-truck.glb", "hood.obj", "chair.obj"];

const OTHERS: [&str; 15] = [
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
];

#[test]
fn exported_meshes_have_no_triangle_turned_over_and_nothing_covered_twice() {
    SOME.iter().for_each(|name| try_shared(name, FEW));
}

#[test]
#[ignore = "takes minutes: cargo test --test it -- --ignored all_shared"]
fn all_shared_meshes_have_no_triangle_turned_over_and_nothing_covered_twice() {
    OTHERS.iter().for_each(|name| try_shared(name, FEW));
}

#[test]
#[ignore = "takes half an hour: cargo test --test it -- --ignored whole_flows"]
fn whole_flows_on_shared_meshes_have_no_triangle_turned_over_and_nothing_covered_twice() {
    SOME.iter().chain(&OTHERS).for_each(|name| try_shared(name, 100.0));
}
