//! `cargo xtask bench`: the figures, each beside its limit.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use crate::args::Args;
use crate::build::{BUNDLES, Profile, build, pkg};
use crate::{process, project, sizes, tools};

/// The row of the benchmark that wasm is compared with.
const NATIVE_STEP: &str = "session step, ball, native";

/// How much slower than natively the engine may be in a browser.
const WASM_LIMIT: f64 = 2.2;

/// Measures natively, then the same script in wasm, then the sizes of the wasm files.
pub fn bench(mut args: Args) -> Result<()> {
    let quick = args.flag("--quick");
    let wanted = args.value("--json")?.map(PathBuf::from);
    args.finish()?;
    let file = wanted
        .map_or_else(|| project::target().join("figures.json"), |name| project::root().join(name));

    let mut cargo = process::cargo("bench");
    cargo.args(["--bench", "ratios", "--", "--json"]).arg(&file);
    if quick {
        cargo.arg("--quick");
    }
    process::run(&mut cargo)?;

    // What is built is measured; what people download after `build --dist`.
    if !BUNDLES.iter().flat_map(|bundle| bundle.files()).all(|file| file.exists()) {
        build(Profile::Release)?;
    }
    wasm_step(&file)?;
    sizes::print(&pkg())
}

/// Adds the time of a step in wasm to the figures.
fn wasm_step(file: &Path) -> Result<()> {
    tools::node()?;
    let script = project::root().join("tests/bench/engine.mjs");
    let answer = process::ask(process::command("node").arg(script))
        .context("the engine did not run in Node; `node tests/bench/engine.mjs` says why")?;
    let wasm: f64 = answer.parse().with_context(|| format!("`{answer}` is no time"))?;

    let text = std::fs::read_to_string(file)
        .with_context(|| format!("could not read {}", file.display()))?;
    let mut rows: Vec<Value> = serde_json::from_str(&text)?;
    let native = rows
        .iter()
        .find(|row| row["name"] == NATIVE_STEP)
        .and_then(|row| row["value"].as_f64())
        .with_context(|| format!("the benchmark gave no `{NATIVE_STEP}`"))?;
    let ratio = wasm / native;
    let verdict = if ratio <= WASM_LIMIT { "met" } else { "MISSED" };
    println!("{:<56} {wasm:>9.3} ms", "session step, ball, wasm in Node");
    println!(
        "{:<56} {ratio:>9.3} {:<15} ≤ {WASM_LIMIT}: {verdict}",
        "session step, ball, wasm", "× native"
    );
    rows.push(json!({ "name": "session step, ball, wasm in Node", "value": wasm, "unit": "ms", "limit": null }));
    rows.push(json!({ "name": "session step, ball, wasm", "value": ratio, "unit": "× native", "limit": WASM_LIMIT }));
    std::fs::write(file, serde_json::to_string_pretty(&rows)?)
        .with_context(|| format!("could not write {}", file.display()))
}
