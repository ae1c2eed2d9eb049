//! `cargo xtask test`: all checks, one after the other, and a table at the end.

use std::time::{Duration, Instant};

use anyhow::{Result, bail};

use crate::args::Args;
use crate::build::{BUNDLES, Profile, build};
use crate::compiler::WasmCompiler;
use crate::{browser, dependencies, process, project, readers, tools};

/// Which parts to run.
pub struct Parts {
    native: bool,
    readers: bool,
    wasm: bool,
    browser: bool,
}

impl Parts {
    /// Without a choice all parts run.
    pub fn from_args(args: &mut Args) -> Self {
        let quick = args.flag("--quick");
        let parts = Self {
            native: args.flag("--native") || quick,
            readers: args.flag("--readers"),
            wasm: args.flag("--wasm"),
            browser: args.flag("--browser"),
        };
        if parts.native || parts.readers || parts.wasm || parts.browser {
            parts
        } else {
            Self { native: true, readers: true, wasm: true, browser: true }
        }
    }
}

enum Outcome {
    Passed,
    Skipped(&'static str),
    Failed(anyhow::Error),
}

/// One line of the table.
struct Stage {
    name: &'static str,
    outcome: Outcome,
    time: Duration,
}

/// Runs every stage even after a failure, so that one run tells all.
pub fn test(parts: Parts) -> Result<()> {
    let mut stages = Vec::new();
    let mut stage = |name, check: fn() -> Result<Outcome>| {
        println!("\n══ {name}");
        let start = Instant::now();
        let outcome = check().unwrap_or_else(|error| {
            eprintln!("error: {error:#}");
            Outcome::Failed(error)
        });
        stages.push(Stage { name, outcome, time: start.elapsed() });
    };
    if parts.native {
        stage("format", format);
        stage("lint", lint);
        stage("dependencies", || dependencies::check().map(|()| Outcome::Passed));
        stage("native tests", native);
    }
    if parts.readers {
        stage("readers", || readers::test().map(|()| Outcome::Passed));
    }
    if parts.wasm {
        stage("wasm tests", wasm);
    }
    if parts.browser {
        stage("wasm build", || build(Profile::Release).map(|()| Outcome::Passed));
        stage("browser tests", || browser::test().map(|()| Outcome::Passed));
    }
    report(&stages)
}

fn report(stages: &[Stage]) -> Result<()> {
    println!("\n══ summary");
    for Stage { name, outcome, time } in stages {
        let (word, note) = match outcome {
            Outcome::Passed => ("passed", String::new()),
            Outcome::Skipped(reason) => ("skipped", (*reason).to_owned()),
            // Its first line: all of it stands where it happened.
            Outcome::Failed(error) => {
                ("FAILED", format!("{error:#}").lines().next().unwrap_or_default().to_owned())
            }
        };
        println!(
            "{}",
            format!("{name:<14} {word:<8} {:>6.1} s  {note}", time.as_secs_f64()).trim_end()
        );
    }
    let failed = stages.iter().filter(|stage| matches!(stage.outcome, Outcome::Failed(_))).count();
    if failed > 0 {
        bail!("{failed} of {} stages failed", stages.len());
    }
    Ok(())
}

fn format() -> Result<Outcome> {
    process::run(process::cargo("fmt").args(["--all", "--check"]))?;
    Ok(Outcome::Passed)
}

/// The viewer natively: its unit tests need no canvas.
const VIEWER: [&str; 2] = ["--features", "cutflow/viewer"];

/// Everything native, then the crate as each of the two wasm files sees it.
fn lint() -> Result<Outcome> {
    let deny = ["--", "-D", "warnings"];
    let all = ["--workspace", "--all-targets"];
    process::run(process::cargo("clippy").args(all).args(VIEWER).args(deny))?;
    match WasmCompiler::find()? {
        compiler @ WasmCompiler::Current => {
            for bundle in &BUNDLES {
                let mut cargo = compiler.cargo("clippy");
                cargo.args([
                    "--lib",
                    "--release",
                    "--no-default-features",
                    "--features",
                    bundle.name,
                ]);
                process::run(cargo.args(deny))?;
            }
        }
        // Its clippy is a package of its own, and of another version than the rest of the lints were read by. Most of the
        // code compiles natively as well.
        WasmCompiler::Debian => {
            let engine = ["--lib", "--no-default-features", "--features", "engine"];
            process::run(process::cargo("clippy").args(engine).args(deny))?;
        }
    }
    Ok(Outcome::Passed)
}

fn native() -> Result<Outcome> {
    process::run(process::cargo("test").args(["--workspace", "--no-fail-fast"]).args(VIEWER))?;
    Ok(Outcome::Passed)
}

/// `tests/wasm.rs` in the browser. In the release profile: the engine is compiled once for these tests and the page.
fn wasm() -> Result<Outcome> {
    if !project::root().join("tests/wasm.rs").exists() {
        return Ok(Outcome::Skipped("there is no tests/wasm.rs"));
    }
    let compiler = WasmCompiler::find()?;
    let runner = tools::wasm_bindgen()?.join("wasm-bindgen-test-runner");
    let capabilities = browser::write_webdriver_capabilities()?;
    let mut cargo = compiler.cargo("test");
    cargo.args(["--release", "--no-default-features", "--features", "engine", "--test", "wasm"]);
    cargo
        .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUNNER", runner)
        .env("CHROMEDRIVER", tools::chromedriver()?)
        .env("WASM_BINDGEN_TEST_WEBDRIVER_JSON", capabilities)
        // Only in a browser, where the engine will live; and no faster than a busy machine with two cores can.
        .env("WASM_BINDGEN_TEST_ONLY_WEB", "1")
        .env("WASM_BINDGEN_TEST_TIMEOUT", "300");
    process::run(&mut cargo)?;
    Ok(Outcome::Passed)
}
