//! Peak memory of a whole run: file in, cut, pieces, files out, in a process of its own.

use std::process::Command as Process;

use cutflow::session::{Command, Session, Value, samples};

use crate::Row;

/// The argument with which the benchmark calls itself.
pub const RUN: &str = "--memory-run";

/// Vertices: 10 n² + 2.
const FREQUENCY: u32 = 71;

/// Measures; nothing where the system does not tell.
pub fn rows() -> Vec<Row> {
    let measure = || -> Option<f64> {
        let output = Process::new(std::env::current_exe().ok()?).arg(RUN).output().ok()?;
        String::from_utf8_lossy(&output.stdout).trim().parse().ok()
    };
    measure()
        .map(|megabytes| Row {
            name: format!("peak memory of a run on {} vertices", 10 * FREQUENCY * FREQUENCY + 2),
            value: megabytes,
            unit: "MB",
            limit: Some(150.0),
        })
        .into_iter()
        .collect()
}

/// The run; prints the most memory that the process ever held, in megabytes.
pub fn run() {
    let soup = samples::icosphere(FREQUENCY);
    let mut text = String::new();
    for [x, y, z] in &soup.positions {
        text += &format!("v {x:.9} {y:.9} {z:.9}\n");
    }
    for i in 0..soup.polygon_count() {
        let corners = soup.polygon(i);
        text += &format!("f {} {} {}\n", corners[0] + 1, corners[1] + 1, corners[2] + 1);
    }
    drop(soup);
    let mut session = Session::new();
    session.open("sphere.obj", text.as_bytes());
    drop(text);
    for (id, value) in [
        ("init", Value::Text("plane".into())),
        ("hencky", Value::Number(0.0)),
        ("dirichlet", Value::Number(10.0)),
        ("steps", Value::Number(12.0)),
    ] {
        session.handle(Command::SetParameter { id: id.into(), value });
    }
    session.handle(Command::Run);
    while session.is_running() {
        session.advance(&mut || true);
        // What the page looks at meanwhile.
        let _ = session.scene();
    }
    assert!(session.history().len() > 1, "the run took no step");
    for kind in ["UV mesh (OBJ)", "Pattern (SVG)"] {
        session.export(kind).expect("the pieces can be written");
    }
    #[expect(clippy::disallowed_methods, reason = "asks the system about itself")]
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = peak.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    if let Some(kilobytes) = kilobytes {
        println!("{}", kilobytes / 1024.0);
    }
}
