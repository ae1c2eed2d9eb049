//! `cargo xtask`: builds, serves, tests, packs and measures Cutflow, and sets up what each of these needs.
//!
//! Every command starts from whatever the machine has. What is missing is installed where that is possible without
//! asking; otherwise the error says which command installs it. Nothing outside the project's folder changes, except
//! through the system's package manager and rustup.

// The bans keep the engine pure. This is the tool around it, which is made of files, clocks and processes.
#![allow(clippy::disallowed_methods)]

mod args;
mod bench;
mod browser;
mod build;
mod compiler;
mod debian;
mod dependencies;
mod dist;
mod process;
mod project;
mod readers;
mod serve;
mod server;
mod sizes;
mod soak;
mod test;
mod tools;

use std::process::ExitCode;

use anyhow::{Result, bail};

use crate::args::Args;

const HELP: &str = "\
cargo xtask COMMAND

  serve [--port N] [--dist]   build the page and serve it on this machine; open the address it prints
  test  [--quick]             everything: format, lints, native tests, exported files in other programs,
                              wasm tests, the page in a real browser
        [--native] [--readers] [--wasm] [--browser]
                              only these parts; --quick is everything that needs no browser
  build [--dist]              build www/pkg/: engine and viewer as WebAssembly
  dist  [--out DIR]           a static folder (default: dist) that works from any path of any static host
  bench [--quick] [--json FILE] [--only GROUP]
                              the figures, as ratios, natively and in wasm, and the sizes of the wasm files; or one
                              group of native ones: memory, flow, growth, convergence, spheres, values, session,
                              cones, charts, phasefield, develop, patterns, import, stages
  soak  [--executions N] [--sequences N] [--cycles N] [--seed S] [--sequence NUMBER]
        [--hours H] [--only degenerate|cycles|fuzzing|sequences|browser]
                              hard use for hours: commands in any order, damaged files, surfaces that
                              hardly are any, a thousand runs in one session, two hours of steps in one page; prints
                              what was done and what was found
  help                        this text

--dist builds what people download: link-time optimised and squeezed, several minutes.

Environment: CUTFLOW_WASM=debian uses Debian's compiler for WebAssembly even where rustup has the target;
CHROMIUM and CHROMEDRIVER name the browser and its driver.";

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let command = words.next().unwrap_or_else(|| "help".into());
    let mut args = Args::new(words.collect());
    match command.as_str() {
        "build" => {
            let profile = build::Profile::from(args.flag("--dist"));
            args.finish()?;
            build::build(profile)?;
            sizes::print(&build::pkg())
        }
        "serve" => {
            let port = args.number("--port")?;
            let profile = build::Profile::from(args.flag("--dist"));
            args.finish()?;
            serve::serve(port, profile)
        }
        "test" => {
            let parts = test::Parts::from_args(&mut args);
            args.finish()?;
            test::test(parts)
        }
        "dist" => {
            let out = args.value("--out")?;
            args.finish()?;
            dist::dist(out.as_deref())
        }
        "bench" => bench::bench(args),
        "soak" => soak::soak(args),
        "help" | "--help" | "-h" => {
            println!("{HELP}");
            Ok(())
        }
        other => bail!("there is no command `{other}`\n\n{HELP}"),
    }
}
