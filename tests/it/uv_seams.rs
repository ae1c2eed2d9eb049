//! The seams of an exported texture map, opened again.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use cutflow::mesh::read::{Content, obj};
use cutflow::mesh::{Soup, uv_islands, uv_seams};
use cutflow::session::{
    Charting, Command, Document, Session, Value, cut_from_uv, settings_for, surface_layout,
};

use crate::scripts::{ball, errors, set};

/// The uv.obj of a session, and the ends of its cut's edges as places: what the file must say, in bits.
fn exported(session: &mut Session) -> (Vec<u8>, BTreeSet<[[u64; 3]; 2]>) {
    let bytes = session.export("UV mesh (OBJ)").unwrap().bytes;
    let cut = session.export("Cut curves (OBJ)").unwrap().bytes;
    let text = String::from_utf8(cut).unwrap();
    let mut places = Vec::new();
    let mut edges = BTreeSet::new();
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => {
                places.push([1, 2, 3].map(|i| words[i].parse::<f64>().unwrap().to_bits()));
            }
            Some(&"l") => {
                let points: Vec<_> =
                    words[1..].iter().map(|w| places[w.parse::<usize>().unwrap() - 1]).collect();
                edges.extend(points.windows(2).map(|p| sorted([p[0], p[1]])));
            }
            _ => {}
        }
    }
    (bytes, edges)
}

fn sorted(mut ends: [[u64; 3]; 2]) -> [[u64; 3]; 2] {
    ends.sort_unstable();
    ends
}

fn torus(n: u32, m: u32) -> String {
    let angle = |i: u32, n: u32| TAU * f64::from(i) / f64::from(n);
    let mut text = String::new();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let (a, b) = (angle(i, n), angle(j, m));
        let r = 1.0 + 0.4 * b.cos();
        text += &format!("v {} {} {}\n", r * a.cos(), r * a.sin(), 0.4 * b.sin());
    }
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let at = |i: u32, j: u32| m * (i % n) + j % m + 1;
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text
}

/// The seams of a file as places.
fn seams(soup: &Soup) -> BTreeSet<[[u64; 3]; 2]> {
    let place = |v: u32| soup.positions[v as usize].map(f64::to_bits);
    uv_seams(soup).unwrap().into_iter().map(|ends| sorted(ends.map(place))).collect()
}

fn pieces(soup: &Soup) -> usize {
    uv_islands(soup).unwrap().into_iter().max().map_or(0, |last| last as usize + 1)
}

/// A ball a few steps into a flow, and a torus in two rings, each slit to lie flat.
fn sessions() -> Vec<Session> {
    let mut first = Session::new();
    let events = first.open("ball.obj", ball(8).as_bytes());
    assert_eq!(errors(&events), Vec::<String>::new());
    set(&mut first, "steps", Value::Number(4.0));
    first.handle(Command::Run);
    while first.is_running() {
        first.advance(&mut || true);
    }
    let mut second = Session::new();
    let events = second.open("torus.obj", torus(18, 9).as_bytes());
    assert_eq!(errors(&events), Vec::<String>::new());
    set(&mut second, "init", Value::Text("plane".into()));
    vec![first, second]
}

#[test]
fn a_texture_map_of_ours_says_its_seams_and_gives_the_same_cut_again() {
    for mut session in sessions() {
        let (bytes, cut) = exported(&mut session);
        assert!(cut.len() > 20);
        let Content { soup, .. } = obj::read(&bytes).unwrap();
        assert_eq!(seams(&soup), cut, "the file is torn where the cut runs, and nowhere else");
        let document = Document::from_bytes("uv.obj", &bytes).unwrap();
        let surface = document.surface().unwrap();
        let cut_again = cut_from_uv(surface).unwrap();
        let (_, again) =
            surface_layout(surface, Some(cut_again), &Charting::default(), "none").unwrap();
        let Content { soup: next, .. } = obj::read(&again).unwrap();
        assert_eq!(next.positions, soup.positions, "no new points");
        assert_eq!(pieces(&next), pieces(&soup));
        assert_eq!(seams(&next), cut);
    }
}

#[test]
fn a_flow_that_starts_from_a_texture_map_follows_its_seams_within_half_an_edge() {
    let mut session = sessions().remove(0);
    let (bytes, cut) = exported(&mut session);
    let Content { soup, .. } = obj::read(&bytes).unwrap();
    let document = Document::from_bytes("uv.obj", &bytes).unwrap();
    let mut settings = settings_for(&document);
    settings.set("init", Value::Text("uv".into())).unwrap();
    settings.set("straighten", Value::Truth(false)).unwrap();
    let mut second = Session::new();
    assert!(errors(&second.open_with(Ok(document), settings)).is_empty());
    let (_, started) = exported(&mut second);
    let number = |bits: [u64; 3]| bits.map(f64::from_bits);
    let distance = |p: [f64; 3], [a, b]: [[f64; 3]; 2]| {
        let d = [0, 1, 2].map(|i| b[i] - a[i]);
        let along: f64 = (0..3).map(|i| (p[i] - a[i]) * d[i]).sum();
        let t = (along / d.iter().map(|x| x * x).sum::<f64>()).clamp(0.0, 1.0);
        (0..3).map(|i| (p[i] - a[i] - t * d[i]).powi(2)).sum::<f64>().sqrt()
    };
    let edges: Vec<[[f64; 3]; 2]> = cut.iter().map(|ends| ends.map(number)).collect();
    let worst = started
        .iter()
        .flatten()
        .map(|&p| edges.iter().map(|&e| distance(number(p), e)).fold(f64::INFINITY, f64::min))
        .fold(0.0, f64::max);
    let corners =
        soup.corners.chunks_exact(3).flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]]);
    let lengths: Vec<f64> = corners
        .map(|ends| {
            let [a, b] = ends.map(|v| soup.positions[v as usize]);
            (0..3).map(|i| (b[i] - a[i]).powi(2)).sum::<f64>().sqrt()
        })
        .collect();
    // Labels stand at vertices, and cuts cross edges in their middle where the mesh has slivers, as one of ours has beside its cut.
    let longest = lengths.into_iter().fold(0.0, f64::max);
    assert!(worst < 0.5 * longest, "{worst} of {longest}");
}

#[test]
fn a_mesh_without_a_map_has_no_seams_to_cut_along() {
    let document = Document::from_bytes("ball.obj", ball(3).as_bytes()).unwrap();
    let problem = cut_from_uv(document.surface().unwrap()).unwrap_err();
    assert!(problem.what.contains("no texture coordinates"), "{problem:?}");
}
