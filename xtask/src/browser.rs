//! A real browser: what it is started with, and the tests that drive the page in it.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::server::{Site, start};
use crate::{dist, process, project, serve, tools};

/// A browser that looks after nothing but the page under test, as any user, root included.
pub const FLAGS: [&str; 7] = [
    "--headless=new",
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
];

/// Where in a host the packed page is put, to see that it works anywhere.
const DEEP: &str = "people/somebody/cutflow";

/// Drives the page, as served to work on and as packed for a host, in Chromium with each graphics backend.
pub fn test() -> Result<()> {
    drive("run.mjs", None)
}

/// Steps in one page for so many hours: memory stays flat.
pub fn soak(hours: f64) -> Result<()> {
    drive("long.test.mjs", Some(hours))
}

fn drive(script: &str, hours: Option<f64>) -> Result<()> {
    tools::npm_packages(&project::browser_tests())?;
    let chromium = tools::chromium()?;
    let host = project::target().join("host");
    dist::assemble(&host.join(DEEP))?;
    let page = start(serve::page(), 0)?;
    let packed = start(Site::new(host, &[]), 0)?;
    let screenshots = project::target().join("screenshots");
    fs::create_dir_all(&screenshots)?;

    let mut node = process::command("node");
    node.current_dir(project::browser_tests());
    node.args(["--test-reporter=./reporter.mjs", script]);
    node.env("CUTFLOW_URL", format!("http://127.0.0.1:{}/", page.port()))
        .env("CUTFLOW_PACKED_URL", format!("http://127.0.0.1:{}/{DEEP}/", packed.port()))
        .env("CUTFLOW_SCREENSHOTS", screenshots)
        .env("CHROMIUM", chromium)
        .env("CHROMIUM_FLAGS", FLAGS.join(" "));
    if let Some(hours) = hours {
        node.env("CUTFLOW_HOURS", hours.to_string());
    }
    process::run(&mut node)
}

/// Tells wasm-bindgen's test runner which browser to start, and how. Gives the file to point it to.
pub fn write_webdriver_capabilities() -> Result<PathBuf> {
    let chromium = tools::chromium()?;
    let flags = FLAGS.map(|flag| format!("{flag:?}")).join(", ");
    let json = format!(
        "{{\"goog:chromeOptions\": {{\"binary\": {:?}, \"args\": [{flags}]}}}}\n",
        chromium.to_string_lossy()
    );
    let file = project::target().join("webdriver.json");
    fs::write(&file, json).with_context(|| format!("could not write {}", file.display()))?;
    Ok(file)
}
