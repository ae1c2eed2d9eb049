//! What the project rests on: pinned, from the registry, under licences that allow shipping it. The rules are those of `.deny.toml`; cargo-deny
//! itself checks them, and known faults besides, where it is installed.

use std::collections::BTreeSet;
use std::path::Path;

use anyhow::{Context, Result, bail};
use serde_json::Value;

use crate::{process, project};

/// What is built and shipped: natively and in the browser.
const TARGETS: [&str; 2] = ["x86_64-unknown-linux-gnu", "wasm32-unknown-unknown"];

const REGISTRY: &str = "registry+https://github.com/rust-lang/crates.io-index";

/// Checks all of it; what cannot be checked here is said aloud.
pub fn check() -> Result<()> {
    let root = project::root();
    for lock in ["Cargo.lock", "tests/browser/package-lock.json"] {
        if !root.join(lock).is_file() {
            bail!("{lock} is missing: versions are pinned");
        }
    }
    let text = std::fs::read_to_string(root.join(".deny.toml")).context(".deny.toml")?;
    let rules = Rules::of(&text);
    let mut faults = BTreeSet::new();
    for target in TARGETS {
        let mut cargo = process::cargo("metadata");
        cargo.args(["--format-version", "1", "--all-features", "--locked", "--filter-platform"]);
        let answer = process::ask(cargo.arg(target))
            .context("`cargo metadata --locked` failed: is Cargo.lock up to date?")?;
        faults.extend(rules.faults(&serde_json::from_str(&answer)?));
    }
    if !faults.is_empty() {
        bail!("dependencies:\n  {}", Vec::from_iter(faults).join("\n  "));
    }
    println!("dependencies: pinned, from the registry, under licences of .deny.toml");
    if process::ask(process::cargo("deny").arg("--version")).is_some() {
        process::run(process::cargo("deny").args(["check", "--config", ".deny.toml"]))?;
    } else {
        println!("SKIPPED: cargo deny is not installed: known faults of crates were not asked for");
    }
    audit(&root.join("tests/browser"))
}

/// Known faults of what Node loads. The page itself loads none of it: only tests do.
fn audit(folder: &Path) -> Result<()> {
    let mut npm = process::command("npm");
    npm.current_dir(folder).args(["audit", "--omit=dev", "--json", "--fetch-retries=0"]);
    let skipped = |why: &str| println!("SKIPPED: npm audit could not run: {why}");
    let Ok(output) = npm.output() else {
        skipped("there is no npm");
        return Ok(());
    };
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
    match answer["metadata"]["vulnerabilities"]["total"].as_u64() {
        Some(0) => println!("npm audit: nothing known"),
        Some(n) => bail!("npm audit knows {n} faults; `npm audit --omit=dev` in tests/browser"),
        None => skipped("the registry did not answer"),
    }
    Ok(())
}

/// The part of `.deny.toml` that needs no database.
struct Rules {
    licences: Vec<String>,
    banned: Vec<String>,
}

impl Rules {
    fn of(text: &str) -> Self {
        let quoted = |text: &str| -> Vec<String> {
            text.split('"').skip(1).step_by(2).map(str::to_owned).collect()
        };
        let allowed = text.lines().find(|line| line.trim_start().starts_with("allow = ["));
        let banned = text.lines().filter(|line| line.contains("crate = \""));
        Self {
            licences: allowed.map(quoted).unwrap_or_default(),
            banned: banned.filter_map(|line| quoted(line).into_iter().next()).collect(),
        }
    }

    /// Whether an expression of licences can be met: `(MIT OR Apache-2.0) AND Unicode-3.0`.
    fn allows(&self, expression: &str) -> bool {
        let is_met = |part: &str| {
            let one = part.trim_matches(['(', ')', ' ']).replace('/', " OR ");
            one.split(" OR ").any(|name| self.licences.iter().any(|known| known == name.trim()))
        };
        expression.split(" AND ").all(is_met)
    }

    /// What is wrong with the packages that are shipped.
    fn faults(&self, metadata: &Value) -> Vec<String> {
        let shipped = shipped(metadata);
        let packages = metadata["packages"].as_array().into_iter().flatten();
        let mut faults = Vec::new();
        for package in packages.filter(|p| p["id"].as_str().is_some_and(|id| shipped.contains(id)))
        {
            let name = package["name"].as_str().unwrap_or_default();
            let licence = package["license"].as_str().unwrap_or("none");
            if !self.allows(licence) {
                faults.push(format!("{name}: licence {licence}"));
            }
            if package["source"].as_str().is_some_and(|source| source != REGISTRY) {
                faults.push(format!("{name}: not from crates.io"));
            }
            if self.banned.iter().any(|banned| banned == name) {
                faults.push(format!("{name}: banned by .deny.toml"));
            }
        }
        faults
    }
}

/// Packages that the crate needs to run or to be built; what only tests and the tools around it need is not among them.
fn shipped(metadata: &Value) -> BTreeSet<&str> {
    let nodes = metadata["resolve"]["nodes"].as_array().map_or(&[][..], Vec::as_slice);
    let mut found = BTreeSet::new();
    let mut next: Vec<&str> = metadata["resolve"]["root"].as_str().into_iter().collect();
    while let Some(id) = next.pop() {
        if !found.insert(id) {
            continue;
        }
        let node = nodes.iter().find(|node| node["id"] == id);
        let needed = node.and_then(|node| node["deps"].as_array()).into_iter().flatten();
        let is_needed = |dep: &&Value| {
            let kinds = dep["dep_kinds"].as_array();
            kinds.is_none_or(|kinds| kinds.iter().any(|kind| kind["kind"] != "dev"))
        };
        next.extend(needed.filter(is_needed).filter_map(|dep| dep["pkg"].as_str()));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const TEXT: &str = "[licenses]\nallow = [\"MIT\", \"Unicode-3.0\"]\n[bans]\ndeny = [\n    { crate = \"rayon\", reason = \"x\" },\n]\n";

    #[test]
    fn licences_are_met_by_one_of_a_choice_and_all_of_a_sum() {
        let rules = Rules::of(TEXT);
        for good in ["MIT", "MIT OR GPL-3.0", "Apache-2.0/MIT", "(GPL-3.0 OR MIT) AND Unicode-3.0"]
        {
            assert!(rules.allows(good), "{good}");
        }
        for bad in ["GPL-3.0", "none", "", "MIT AND GPL-3.0"] {
            assert!(!rules.allows(bad), "{bad}");
        }
    }

    #[test]
    fn strange_sources_banned_crates_and_licences_are_found_and_tests_own_are_left_out() {
        let package = |id: &str, licence: &str, source: &str| json!({ "id": id, "name": id, "license": licence, "source": source });
        let dep = |id: &str, kind: Value| json!({ "pkg": id, "dep_kinds": [{ "kind": kind }] });
        let metadata = json!({
            "packages": [
                { "id": "own", "name": "own", "license": "MIT", "source": null },
                package("good", "MIT", REGISTRY),
                package("rayon", "MIT", REGISTRY),
                package("far", "MIT", "git+https://example.org/far"),
                package("closed", "GPL-3.0", REGISTRY),
                package("only-tests", "GPL-3.0", REGISTRY),
            ],
            "resolve": { "root": "own", "nodes": [
                { "id": "own", "deps": [dep("good", Value::Null), dep("only-tests", "dev".into())] },
                { "id": "good", "deps": [dep("rayon", Value::Null), dep("far", "build".into()), dep("closed", Value::Null)] },
            ] },
        });
        let faults = Rules::of(TEXT).faults(&metadata);
        assert_eq!(faults.len(), 3, "{faults:?}");
        for word in ["rayon: banned", "far: not from", "closed: licence GPL-3.0"] {
            assert!(faults.iter().any(|fault| fault.contains(word)), "{word}: {faults:?}");
        }
    }

    #[test]
    fn the_rules_of_the_project_are_understood() {
        let text = std::fs::read_to_string(project::root().join(".deny.toml")).unwrap();
        let rules = Rules::of(&text);
        assert!(rules.allows("MIT OR Apache-2.0") && rules.banned.contains(&"rayon".to_owned()));
    }
}
