//! `cargo xtask bench`: the figures, each beside its limit, and the stages of each method natively, in Node and in Chromium.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::{Value, json};

use crate::args::Args;
use crate::build::{BUNDLES, Profile, build, pkg};
use crate::{browser, process, project, sizes, tools};

/// The row of the benchmark whose wasm has a limit.
const STEP: &str = "session step, ball";

/// How much slower than natively the engine may be in a browser.
const WASM_LIMIT: f64 = 2.2;

/// Measures natively, then the same scripts in wasm, then the sizes of the wasm files; one group of native figures alone where
/// `--only` names it.
pub fn bench(mut args: Args) -> Result<()> {
    let quick = args.flag("--quick");
    let only = args.value("--only")?;
    let wanted = args.value("--json")?.map(PathBuf::from);
    args.finish()?;
    let file = wanted
        .map_or_else(|| project::target().join("figures.json"), |name| project::root().join(name));
    let meshes = project::target().join("bench-meshes");
    // Meshes of another size would be measured in wasm alone.
    if meshes.exists() {
        std::fs::remove_dir_all(&meshes)?;
    }
    std::fs::create_dir_all(&meshes)?;

    let mut cargo = process::cargo("bench");
    cargo.args(["--bench", "ratios", "--", "--json"]).arg(&file).arg("--meshes").arg(&meshes);
    if quick {
        cargo.arg("--quick");
    }
    if let Some(word) = only {
        cargo.arg("--only").arg(word);
        return process::run(&mut cargo);
    }
    process::run(&mut cargo)?;

    // What is built is measured; what people download after `build --dist`.
    if !BUNDLES.iter().flat_map(|bundle| bundle.files()).all(|file| file.exists()) {
        build(Profile::Release)?;
    }
    let text = std::fs::read_to_string(&file)
        .with_context(|| format!("could not read {}", file.display()))?;
    let mut figures = Figures { rows: serde_json::from_str(&text)? };
    tools::node()?;
    figures.add("Node", &wasm(&meshes, None)?)?;
    tools::npm_packages(&project::browser_tests())?;
    figures.add("Chromium", &wasm(&meshes, Some(&tools::chromium()?))?)?;
    std::fs::write(&file, serde_json::to_string_pretty(&figures.rows)?)
        .with_context(|| format!("could not write {}", file.display()))?;

    let table = figures.table();
    let beside = file.with_extension("md");
    std::fs::write(&beside, &table)
        .with_context(|| format!("could not write {}", beside.display()))?;
    println!("\n{table}\n{}", beside.display());
    sizes::print(&pkg())
}

/// Milliseconds and megabytes of the scripts in wasm: in Node, or in the browser that is given.
fn wasm(meshes: &Path, chromium: Option<&Path>) -> Result<Vec<(String, f64)>> {
    let mut node = process::command("node");
    node.arg(project::root().join("tests/bench/engine.mjs")).arg(meshes);
    if let Some(chromium) = chromium {
        node.arg(chromium).args(browser::FLAGS);
    }
    let answer = process::ask(&mut node).context("the engine did not run in wasm")?;
    serde_json::from_str(&answer).with_context(|| format!("`{answer}` is no list of times"))
}

/// Rows `{name, value, unit, limit}`.
struct Figures {
    rows: Vec<Value>,
}

impl Figures {
    fn value(&self, name: &str) -> Option<f64> {
        self.rows.iter().find(|row| row["name"] == name)?["value"].as_f64()
    }

    /// Takes times in wasm in, and their ratios to the native ones.
    fn add(&mut self, place: &str, times: &[(String, f64)]) -> Result<()> {
        for (name, value) in times {
            let unit = if name.starts_with("memory") { "MB" } else { "ms" };
            self.push(&format!("{name}, wasm in {place}"), *value, unit, None);
            if unit == "MB" {
                continue;
            }
            let native = self
                .value(name)
                .or_else(|| self.value(&format!("{name}, native")))
                .with_context(|| format!("the benchmark gave no `{name}`"))?;
            let limit = (name == STEP).then_some(WASM_LIMIT);
            self.push(&format!("{name}, {place}"), value / native, "× native", limit);
        }
        Ok(())
    }

    fn push(&mut self, name: &str, value: f64, unit: &str, limit: Option<f64>) {
        if let Some(limit) = limit {
            let verdict = if value <= limit { "met" } else { "MISSED" };
            println!("{name:<56} {value:>9.3} {unit:<15} ≤ {limit}: {verdict}");
        }
        self.rows.push(json!({ "name": name, "value": value, "unit": unit, "limit": limit }));
    }

    /// The stages as a table in Markdown.
    fn table(&self) -> String {
        let mut table = String::from(
            "| stage | native, ms | over a factorisation | Node, × native | Chromium, × native |\n|---|---|---|---|---|\n",
        );
        for row in &self.rows {
            let name = row["name"].as_str().unwrap_or_default();
            let (Some(ratio), Some(value)) =
                (self.value(&format!("{name}, over a factorisation")), row["value"].as_f64())
            else {
                continue;
            };
            let beside = |place: &str| {
                let value = self.value(&format!("{name}, {place}"));
                value.map_or_else(String::new, |value| format!("{value:.2}"))
            };
            let (node, chromium) = (beside("Node"), beside("Chromium"));
            let _ = writeln!(table, "| {name} | {value:.1} | {ratio:.2} | {node} | {chromium} |");
        }
        table
    }
}
