//! `cargo xtask bench`: the figures.

use anyhow::{Context, Result};

use crate::build::{BUNDLES, pkg};
use crate::{process, project, sizes};

/// Hands `arguments` on to the native benchmark, then measures wasm where it is built.
pub fn bench(arguments: Vec<String>) -> Result<()> {
    let json = project::target().join("bench.json");
    let wanted = arguments.iter().position(|a| a == "--json").and_then(|i| arguments.get(i + 1));
    let mut cargo = process::cargo("bench");
    cargo.args(["--bench", "ratios", "--"]).args(&arguments);
    let path = match wanted {
        Some(path) => project::root().join(path),
        None => {
            cargo.arg("--json").arg(&json);
            json
        }
    };
    process::run(&mut cargo)?;
    let is_built = BUNDLES.iter().flat_map(|bundle| bundle.files()).all(|file| file.exists());
    if !is_built {
        println!(
            "The wasm files are not built; `cargo xtask build --dist` does that, and the next run measures them."
        );
        return Ok(());
    }
    let native = native_step(&path)?;
    let script = project::root().join("tests/bench/engine.mjs");
    let output = process::command("node").arg(script).output().context("could not run node")?;
    anyhow::ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let wasm: f64 = String::from_utf8_lossy(&output.stdout).trim().parse()?;
    let verdict = if wasm <= 3.0 * native { "met" } else { "MISSED" };
    println!("{:<56} {wasm:>9.3} ms", "session step, ball, wasm in Node");
    println!(
        "{:<56} {:>9.3} {:<15} ≤ 3: {verdict}",
        "wasm step over native step",
        wasm / native,
        ""
    );
    sizes::print(&pkg())
}

/// The native time of the script that Node repeats, milliseconds.
fn native_step(path: &std::path::Path) -> Result<f64> {
    let text = std::fs::read_to_string(path)
        .with_context(|| format!("could not read {}", path.display()))?;
    // One row per object; the names are ours, so that no JSON reader is needed for one number.
    let row = text.split('{').find(|row| row.contains("session step, ball, native"));
    let value = row.and_then(|row| row.split("\"value\":").nth(1)).and_then(|rest| {
        rest.split([',', '}', '\n']).next().and_then(|number| number.trim().parse().ok())
    });
    value.context("the benchmark wrote no time of a session step")
}
