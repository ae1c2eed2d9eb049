//! The house keeps its order: floors look down only, and what must be absent is absent.

use std::fs;
use std::path::{Path, PathBuf};

/// Module, and what it may use besides itself.
const FLOORS: &[(&str, &[&str])] = &[
    ("linalg", &[]),
    ("mesh", &[]),
    ("geometry", &["mesh", "linalg"]),
    ("methods", &["geometry", "mesh", "linalg"]),
    ("flatten", &["methods", "geometry", "mesh", "linalg"]),
    ("pattern", &["flatten", "methods", "geometry", "mesh", "linalg"]),
    ("session", &["pattern", "flatten", "methods", "geometry", "mesh", "linalg"]),
    ("viewer", &["session::scene"]),
    ("web", &["session", "viewer"]),
    ("bin", &["session"]),
];

/// Words that must not occur outside the places named, each with its reason.
const ABSENT: &[(&str, &[&str], &str)] = &[
    ("faer::", &["linalg"], "only linalg names a linear-algebra crate"),
    ("serde", &["session", "web", "bin"], "nothing below session is serialisable"),
    ("std::fs", &["bin"], "the engine opens no file"),
    ("std::thread", &[], "the engine starts no thread"),
    ("Instant::now", &["bin"], "the engine reads no clock"),
    ("SystemTime", &[], "the engine reads no clock"),
    ("web_sys", &["web", "viewer"], "nothing below web knows a browser"),
    ("js_sys", &["web"], "nothing below web knows a browser"),
    ("wgpu::", &["viewer", "web"], "only the viewer draws"),
    ("static mut", &[], "there is no global state"),
    ("thread_local!", &[], "there is no global state"),
    (".partial_cmp(", &[], "NaN breaks sorts silently: total_cmp"),
    ("todo!", &[], "unfinished work does not land"),
    ("unimplemented!", &[], "unfinished work does not land"),
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Lines of code with their numbers: comments and unit tests at the end of a file left out.
fn code(path: &Path) -> Vec<(usize, String)> {
    let text = fs::read_to_string(path).unwrap();
    text.lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim().to_owned()))
        .take_while(|(_, line)| line != "#[cfg(test)]")
        .filter(|(_, line)| !line.starts_with("//"))
        .collect()
}

fn all() -> Vec<(String, PathBuf)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    sources(&root, &mut found);
    found
        .into_iter()
        .map(|path| {
            let inner = path.strip_prefix(&root).unwrap();
            let first = inner.components().next().unwrap().as_os_str().to_string_lossy();
            (first.trim_end_matches(".rs").to_owned(), path)
        })
        .collect()
}

#[test]
fn floors_look_down_only() {
    let mut faults = Vec::new();
    for (module, path) in all() {
        let Some((_, allowed)) = FLOORS.iter().find(|(name, _)| *name == module) else { continue };
        for (number, line) in code(&path) {
            // The command stands outside the library and names it.
            let root = if module == "bin" { "cutflow::" } else { "crate::" };
            for (at, _) in line.match_indices(root) {
                let rest = &line[at + root.len()..];
                let is_own = rest == module || rest.starts_with(&format!("{module}::"));
                let is_allowed = allowed.iter().any(|a| {
                    rest.strip_prefix(a).is_some_and(|r| !r.starts_with(char::is_alphanumeric))
                });
                if !is_own && !is_allowed && !rest.starts_with('{') {
                    faults.push(format!("{}:{number}: {module} uses {line}", path.display()));
                } else if rest.starts_with('{') {
                    faults.push(format!("{}:{number}: name the floor: {line}", path.display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn what_must_be_absent_is_absent() {
    let mut faults = Vec::new();
    for (module, path) in all() {
        for (number, line) in code(&path) {
            for (word, places, reason) in ABSENT {
                if line.contains(word) && !places.contains(&module.as_str()) {
                    faults.push(format!("{}:{number}: {word}: {reason}", path.display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn every_module_opens_with_its_problem() {
    for (_, path) in all() {
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("//!"), "{} has no opening comment", path.display());
    }
}
