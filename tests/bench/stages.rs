//! Each method, stage by stage, as page and command drive it: the script that `stages.mjs` runs in wasm.

use std::fmt::Write as _;
use std::path::Path;

use cutflow::geometry::Geometry;
use cutflow::mesh::Mesh;
use cutflow::session::{Command, Event, Session, samples};

use crate::{Row, factorisation, seconds};

/// Steps that are timed of runs that would go on.
const STEPS: usize = 30;
/// Vertices beyond which whole runs of cones and developable patches are left out of the table.
const LARGE: usize = 50_000;

/// A sphere with bumps: curvature everywhere, nothing symmetric.
struct Bumpy {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    obj: String,
}

impl Bumpy {
    fn new(frequency: u32) -> Self {
        let soup = samples::icosphere(frequency);
        let bumped = |&[x, y, z]: &[f64; 3]| {
            let wave = (3.1 * x + 0.4).sin() * (2.3 * y).cos();
            let radius = 1.0 + 0.12 * wave + 0.08 * (4.0 * z + x).sin();
            [radius * x, radius * y, radius * z]
        };
        let positions: Vec<[f64; 3]> = soup.positions.iter().map(bumped).collect();
        let triangles: Vec<[u32; 3]> =
            (0..soup.polygon_count()).map(|i| [0, 1, 2].map(|k| soup.polygon(i)[k])).collect();
        let mut obj = String::new();
        for [x, y, z] in &positions {
            let _ = writeln!(obj, "v {x} {y} {z}");
        }
        for [a, b, c] in triangles.iter().map(|t| t.map(|v| v + 1)) {
            let _ = writeln!(obj, "f {a} {b} {c}");
        }
        Self { positions, triangles, obj }
    }

    fn factorisation(&self) -> f64 {
        let mesh = Mesh::new(self.positions.len(), &self.triangles).expect("it is a surface");
        let (geometry, _) = Geometry::unit_area(&mesh, &self.positions).expect("it has an area");
        factorisation(&mesh, &geometry, 5)
    }
}

/// Goes on until it rests, or for so many steps. Gives the steps.
fn advance(session: &mut Session, most: usize) -> usize {
    let mut left = most;
    while left > 0 && session.is_running() {
        session.advance(&mut || {
            left -= 1;
            left > 0
        });
    }
    (most - left).max(1)
}

fn is_refusal(event: &Event) -> bool {
    matches!(event, Event::Error { .. })
}

fn send(session: &mut Session, command: Command) {
    let events = session.handle(command);
    assert!(!events.iter().any(is_refusal), "{events:?}");
}

/// Times of the stages, milliseconds: what is done, and how long it takes.
fn script(text: &str, is_large: bool) -> Vec<(&'static str, f64)> {
    let mut session = Session::new();
    let mut out = Vec::new();
    let load = seconds(|| {
        let events = session.open("bumpy.obj", text.as_bytes());
        assert!(!events.iter().any(is_refusal), "{events:?}");
        advance(&mut session, usize::MAX);
        session.scene();
    });
    out.push(("load", load));

    let mut steps = 1;
    send(&mut session, Command::Run);
    let time = seconds(|| steps = advance(&mut session, STEPS));
    out.push(("cut flow, a step", time / steps as f64));
    send(&mut session, Command::Pause);
    for (name, kind) in [("flatten and UV mesh", "UV mesh (OBJ)"), ("pattern", "Pattern (SVG)")] {
        let time = seconds(|| {
            session.export(kind).expect("it can be flattened");
        });
        out.push((name, time));
    }

    send(&mut session, Command::SetMethod { id: "phasefield".into() });
    send(&mut session, Command::Run);
    let time = seconds(|| steps = advance(&mut session, STEPS));
    out.push(("phase field, an iteration", time / steps as f64));
    send(&mut session, Command::Pause);
    if is_large {
        return out;
    }
    for (name, id) in [
        ("cones, the whole solution", "cones"),
        ("developable patches, the whole run", "developable"),
    ] {
        send(&mut session, Command::SetMethod { id: id.into() });
        send(&mut session, Command::Run);
        let time = seconds(|| {
            advance(&mut session, usize::MAX);
        });
        out.push((name, time));
    }
    out
}

/// The table of stages. **Takes** a folder for the meshes, which wasm is to read.
pub fn rows(is_quick: bool, folder: &Path) -> Vec<Row> {
    let frequencies: &[u32] = if is_quick { &[16, 32] } else { &[16, 32, 64, 128] };
    let mut rows = Vec::new();
    for &frequency in frequencies {
        let bumpy = Bumpy::new(frequency);
        let vertices = bumpy.positions.len();
        #[expect(clippy::disallowed_methods, reason = "asked to leave the meshes for wasm")]
        std::fs::write(folder.join(format!("bumpy-{vertices}.obj")), &bumpy.obj)
            .expect("the folder can be written");
        let unit = bumpy.factorisation();
        for (stage, time) in script(&bumpy.obj, vertices > LARGE) {
            let name = format!("{stage}, {vertices} vertices");
            let value = 1e3 * time;
            rows.push(Row { name: name.clone(), value, unit: "ms", limit: None });
            let name = format!("{name}, over a factorisation");
            rows.push(Row { name, value: time / unit, unit: "factorisations", limit: None });
        }
    }
    rows
}
