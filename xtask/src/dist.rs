//! `cargo xtask dist`: the page as a folder for a static host.
//!
//! ```text
//! index.html
//! sw.js                       keeps the page on the computer of who opens it; beside it, because it reaches no higher
//! cutflow-0123456789abcdef/   all of www/, named after its contents
//! ```
//!
//! All links are relative, so the folder works from any path. The files whose names stay are `index.html` and `sw.js`; all
//! others change their address whenever anything changes, so no browser ever mixes two versions and a host may let them be
//! cached for ever. One name for all of them rather than one each: the modules find each other by relative paths, and
//! none has to be rewritten.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use crate::build::{Profile, build};
use crate::{project, sizes};

const PREFIX: &str = "cutflow-";

/// The service worker.
const WORKER: &str = "sw.js";

pub fn dist(out: Option<&str>) -> Result<()> {
    build(Profile::Dist)?;
    let out = project::root().join(out.unwrap_or("dist"));
    let assets = assemble(&out)?;
    println!("{}", out.join("index.html").display());
    sizes::print(&assets.join("pkg"))?;
    sizes::warn(&assets.join("pkg"))
}

/// Copies what is built into `out` and gives the folder of the assets.
pub fn assemble(out: &Path) -> Result<PathBuf> {
    let www = project::www();
    let files: Vec<PathBuf> = project::files_below(&www)?
        .into_iter()
        .filter(|file| file.extension().is_none_or(|extension| extension != "stamp"))
        .collect();
    let name = format!("{PREFIX}{:016x}", project::hash(&www, &files)?);
    let page = project::root().join("index.html");
    let page =
        fs::read_to_string(&page).with_context(|| format!("could not read {}", page.display()))?;
    let page = relinked(&page, &name)?;
    let names: Vec<String> = files
        .iter()
        .filter_map(|file| file.strip_prefix(&www).ok())
        .map(|file| format!("{name}/{}", file.to_string_lossy().replace('\\', "/")))
        .collect();
    let worker = project::root().join(WORKER);
    let worker = fs::read_to_string(&worker)
        .with_context(|| format!("could not read {}", worker.display()))?;
    let worker = versioned(&worker, &name, &names)?;

    remove_last(out)?;
    for file in &files {
        let copy = out.join(&name).join(file.strip_prefix(&www)?);
        fs::create_dir_all(copy.parent().unwrap_or(out))?;
        fs::copy(file, &copy).with_context(|| format!("could not write {}", copy.display()))?;
    }
    fs::write(out.join("index.html"), page)?;
    fs::write(out.join(WORKER), worker)?;
    Ok(out.join(name))
}

/// Removes what an earlier call left in `out`, and nothing else: the folder may be a checkout of somebody's site.
fn remove_last(out: &Path) -> Result<()> {
    let Ok(entries) = out.read_dir() else { return Ok(()) };
    for entry in entries {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_ours = name.strip_prefix(PREFIX).is_some_and(|hash| {
            hash.len() == 16 && hash.chars().all(|digit| digit.is_ascii_hexdigit())
        });
        if is_ours && path.is_dir() {
            fs::remove_dir_all(&path)?;
        }
    }
    Ok(())
}

/// The page with its links to `www/` led to `name/`.
fn relinked(page: &str, name: &str) -> Result<String> {
    let mut page = page.to_owned();
    for quote in ['"', '\''] {
        for link in ["www/", "./www/"] {
            page = page.replace(&format!("{quote}{link}"), &format!("{quote}{name}/"));
        }
        // A second slash makes it another host, which is somebody's decision and no slip.
        for attribute in ["href", "src"] {
            if let Some((_, after)) = page.split_once(&format!("{attribute}={quote}/"))
                && !after.starts_with('/')
            {
                let link = after.split(quote).next().unwrap_or_default();
                bail!(
                    "index.html links to `/{link}`, which only works at the root of a host: make it relative"
                );
            }
        }
    }
    if page.contains("www/") {
        bail!(
            "index.html names www/ in a way that dist does not understand; write it as \"www/…\""
        );
    }
    Ok(page)
}

/// The service worker with the version that it keeps, and the files of that version.
fn versioned(worker: &str, name: &str, files: &[String]) -> Result<String> {
    let list: Vec<String> = files.iter().map(|file| format!("{file:?}")).collect();
    let mut worker = worker.to_owned();
    for (empty, full) in [
        ("const VERSION = \"\";", format!("const VERSION = {name:?};")),
        ("const FILES = [];", format!("const FILES = [{}];", list.join(", "))),
    ] {
        if worker.matches(empty).count() != 1 {
            bail!("{WORKER} has no line `{empty}` for dist to fill in");
        }
        worker = worker.replace(empty, &full);
    }
    Ok(worker)
}

#[cfg(test)]
mod tests {
    use super::{relinked, versioned};

    #[test]
    fn the_service_worker_is_told_its_version_and_its_files() {
        let worker = "const VERSION = \"\";\nconst FILES = [];\n";
        let files = ["cutflow-1/a.js".to_owned(), "cutflow-1/b.wasm".to_owned()];
        let expected = "const VERSION = \"cutflow-1\";\nconst FILES = [\"cutflow-1/a.js\", \"cutflow-1/b.wasm\"];\n";
        assert_eq!(versioned(worker, "cutflow-1", &files).unwrap(), expected);
        assert!(versioned("const VERSION = \"\";", "cutflow-1", &files).is_err());
        let own = include_str!("../../sw.js");
        assert!(versioned(own, "cutflow-1", &files).is_ok());
    }

    #[test]
    fn links_are_led_to_the_named_folder() {
        let page = "<link href=\"www/style.css\"><script src='./www/main.js'></script>";
        let expected =
            "<link href=\"cutflow-1/style.css\"><script src='cutflow-1/main.js'></script>";
        assert_eq!(relinked(page, "cutflow-1").unwrap(), expected);
    }

    #[test]
    fn links_that_would_break_elsewhere_are_errors() {
        assert!(relinked("<link href=\"/www/style.css\">", "x").is_err());
        assert!(relinked("<script>import(`www/main.js`)</script>", "x").is_err());
        assert!(relinked("<a href=\"https://example.org/\">", "x").is_ok());
    }
}
