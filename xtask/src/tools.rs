//! Programs that the build and the tests call: found, or installed.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::{debian, process, project};

/// The very version of the `wasm-bindgen` crate: the two speak a format of their own that changes with each release.
const WASM_BINDGEN: &str = "0.2.130";

/// npm's `binaryen`, which carries wasm-opt inside the package.
const BINARYEN: &str = "132.0.0";

/// What playwright-core asks for.
const OLDEST_NODE: u32 = 20;

/// The folder that has `wasm-bindgen` and `wasm-bindgen-test-runner`.
pub fn wasm_bindgen() -> Result<PathBuf> {
    let folder = project::tools().join("bin");
    let version = process::ask(process::command(folder.join("wasm-bindgen")).arg("--version"));
    if version.is_some_and(|text| text.split_whitespace().nth(1) == Some(WASM_BINDGEN)) {
        return Ok(folder);
    }
    println!("Installing wasm-bindgen {WASM_BINDGEN} into target/tools (a few minutes, once).");
    let install = |locked: bool| {
        let mut cargo = process::cargo("install");
        cargo.args(["wasm-bindgen-cli", "--version", WASM_BINDGEN, "--force"]);
        cargo.arg("--root").arg(project::tools());
        // Its own folder, so that an interrupted installation goes on where it stopped. No lasting optimisation:
        // it runs for a second, and compiling it is what one waits for.
        cargo.arg("--target-dir").arg(project::tools().join("build"));
        cargo
            .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1")
            .env("CARGO_PROFILE_RELEASE_DEBUG", "none");
        if locked {
            cargo.arg("--locked");
        }
        process::run(&mut cargo)
    };
    // A registry's mirror may not have the very versions yet that the tool was released with; any compatible ones do.
    install(true).or_else(|_| install(false)).context("wasm-bindgen could not be installed")?;
    Ok(folder)
}

/// The folder of wasm-opt as an npm package; its programs are in `bin/`.
pub fn binaryen() -> Result<PathBuf> {
    let package = project::tools().join("node_modules/binaryen");
    let manifest = std::fs::read_to_string(package.join("package.json")).unwrap_or_default();
    if !manifest.contains(&format!("\"version\": \"{BINARYEN}\"")) {
        node()?;
        let mut npm = process::command("npm");
        npm.args([
            "install",
            "--no-save",
            "--no-audit",
            "--no-fund",
            "--ignore-scripts",
            "--prefix",
        ]);
        npm.arg(project::tools()).arg(format!("binaryen@{BINARYEN}"));
        process::run(&mut npm)?;
    }
    Ok(package)
}

/// Makes sure of npm and of a Node that is new enough for what it installs here.
pub fn node() -> Result<()> {
    if process::find("node").is_none() || process::find("npm").is_none() {
        debian::install(&["nodejs", "npm"], "drive a browser")?;
    }
    let version = process::ask(process::command("node").arg("--version")).unwrap_or_default();
    let major =
        version.trim_start_matches('v').split('.').next().and_then(|number| number.parse().ok());
    if major.is_none_or(|major: u32| major < OLDEST_NODE) {
        bail!("Node {OLDEST_NODE} or newer is needed; this is {version}. See https://nodejs.org");
    }
    Ok(())
}

/// Makes sure of the packages that a folder of scripts imports, exactly those of its lock file.
pub fn npm_packages(folder: &Path) -> Result<()> {
    node()?;
    // npm writes this file at the end of an installation.
    let installed = folder.join("node_modules/.package-lock.json");
    if is_newer(&installed, &folder.join("package-lock.json")) {
        return Ok(());
    }
    let mut npm = process::command("npm");
    npm.current_dir(folder).args(["ci", "--no-audit", "--no-fund", "--ignore-scripts"]);
    process::run(&mut npm)
        .with_context(|| format!("the npm packages of {} could not be installed", folder.display()))
}

/// A Python with exactly the packages of a list, in an environment of its own.
pub fn python(requirements: &Path) -> Result<PathBuf> {
    let folder = project::tools().join("readers");
    let python = folder.join("bin/python");
    let wanted = std::fs::read_to_string(requirements)
        .with_context(|| format!("could not read {}", requirements.display()))?;
    // Written at the end of an installation.
    let installed = folder.join("requirements.txt");
    if std::fs::read_to_string(&installed).is_ok_and(|text| text == wanted)
        && process::ask(process::command(&python).arg("--version")).is_some()
    {
        return Ok(python);
    }
    let make = || {
        let mut venv = process::command("python3");
        process::run(venv.args(["-m", "venv", "--clear"]).arg(&folder))
    };
    // Debian has the interpreter without the module, or neither.
    if make().is_err() {
        debian::install(&["python3", "python3-venv"], "read exported files by other programs")?;
        make()?;
    }
    let mut pip = process::command(&python);
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"]);
    process::run(pip.arg(requirements))
        .context("the readers' Python packages were not installed")?;
    std::fs::write(&installed, wanted)
        .with_context(|| format!("could not write {}", installed.display()))?;
    Ok(python)
}

/// Makes sure of programs that other programs' tests call, by the packages that have them.
pub fn programs(needed: &[(&str, &str)], why: &str) -> Result<()> {
    let mut missing: Vec<&str> = needed
        .iter()
        .filter(|(program, _)| process::find(program).is_none())
        .map(|&(_, package)| package)
        .collect();
    missing.dedup();
    if !missing.is_empty() {
        debian::install(&missing, why)?;
    }
    Ok(())
}

/// Chromium or Chrome.
pub fn chromium() -> Result<PathBuf> {
    program("CHROMIUM", &["chromium", "chromium-browser", "google-chrome"], "chromium")
}

/// The WebDriver server of that browser.
pub fn chromedriver() -> Result<PathBuf> {
    program("CHROMEDRIVER", &["chromedriver"], "chromium-driver")
}

fn program(variable: &str, names: &[&str], package: &str) -> Result<PathBuf> {
    if let Some(path) = std::env::var_os(variable) {
        return Ok(path.into());
    }
    let find = || names.iter().find_map(|name| process::find(name));
    if let Some(path) = find() {
        return Ok(path);
    }
    debian::install(&[package], "test in a real browser")
        .with_context(|| format!("no {} on the path, and {variable} names none", names[0]))?;
    find().with_context(|| format!("{package} is installed, but none of {names:?} is on the path"))
}

fn is_newer(file: &Path, than: &Path) -> bool {
    let time = |path: &Path| path.metadata().and_then(|data| data.modified()).ok();
    time(file).zip(time(than)).is_some_and(|(file, than)| file >= than)
}
