//! The two wasm files and their JavaScript, into `www/pkg/`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::compiler::{TARGET, WasmCompiler};
use crate::{process, project, tools};

/// How much the build may cost.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// Optimised, quickly built: for work and tests.
    Release,
    /// Optimised across crates, then squeezed: for people to download.
    Dist,
}

impl From<bool> for Profile {
    fn from(dist: bool) -> Self {
        if dist { Self::Dist } else { Self::Release }
    }
}

impl Profile {
    fn name(self) -> &'static str {
        match self {
            Self::Release => "release",
            Self::Dist => "dist",
        }
    }
}

/// The crate seen through one of its features: one wasm file.
pub struct Bundle {
    /// The feature, and the name of the files.
    pub name: &'static str,
    /// cargo's optimisation level for people's downloads.
    dist_opt_level: &'static str,
    /// wasm-opt's.
    wasm_opt_level: &'static str,
}

/// The solvers, for speed; the pictures, which the graphics processor draws, for size.
pub const BUNDLES: [Bundle; 2] = [
    Bundle { name: "engine", dist_opt_level: "3", wasm_opt_level: "-O3" },
    Bundle { name: "viewer", dist_opt_level: "s", wasm_opt_level: "-Oz" },
];

/// What rustc may use and wasm-opt must therefore understand: its defaults, and SIMD.
const WASM_FEATURES: [&str; 7] = [
    "--enable-simd",
    "--enable-bulk-memory",
    "--enable-multivalue",
    "--enable-mutable-globals",
    "--enable-nontrapping-float-to-int",
    "--enable-reference-types",
    "--enable-sign-ext",
];

/// The folder of what is built.
pub fn pkg() -> PathBuf {
    project::www().join("pkg")
}

/// Builds both bundles where their sources have changed.
pub fn build(profile: Profile) -> Result<()> {
    let stamp = stamp(profile)?;
    let is_fresh = |bundle: &Bundle| {
        let made = fs::read_to_string(pkg().join(format!("{}.stamp", bundle.name)));
        made.is_ok_and(|made| made == stamp) && bundle.files().iter().all(|file| file.exists())
    };
    let stale: Vec<&Bundle> = BUNDLES.iter().filter(|bundle| !is_fresh(bundle)).collect();
    if stale.is_empty() {
        println!("www/pkg is up to date.");
        return Ok(());
    }
    let compiler = WasmCompiler::find()?;
    let bindgen = tools::wasm_bindgen()?;
    for bundle in stale {
        let made = pkg().join(format!("{}.stamp", bundle.name));
        // A build that is broken off must not pass for a good one.
        if made.exists() {
            fs::remove_file(&made)?;
        }
        bundle.build(profile, &compiler, &bindgen)?;
        fs::write(&made, &stamp).with_context(|| format!("could not write {}", made.display()))?;
    }
    Ok(())
}

impl Bundle {
    /// The JavaScript and the WebAssembly.
    pub fn files(&self) -> [PathBuf; 2] {
        [pkg().join(format!("{}.js", self.name)), pkg().join(format!("{}_bg.wasm", self.name))]
    }

    fn build(&self, profile: Profile, compiler: &WasmCompiler, bindgen: &Path) -> Result<()> {
        println!("── {} ({})", self.name, profile.name());
        let mut cargo = compiler.cargo("build");
        cargo.args(["--lib", "--profile", profile.name(), "--no-default-features"]);
        cargo.args(["--features", self.name]);
        if profile == Profile::Dist {
            cargo.env("CARGO_PROFILE_DIST_OPT_LEVEL", self.dist_opt_level);
        }
        process::run(&mut cargo)?;

        let built = project::wasm_target().join(TARGET).join(profile.name()).join("cutflow.wasm");
        let mut bind = process::command(bindgen.join("wasm-bindgen"));
        bind.args(["--target", "web", "--no-typescript", "--out-name", self.name]);
        bind.arg("--out-dir").arg(pkg());
        if profile == Profile::Dist {
            bind.args(["--remove-name-section", "--remove-producers-section"]);
        }
        process::run(bind.arg(built))?;

        if profile == Profile::Dist {
            self.squeeze()?;
        }
        Ok(())
    }

    fn squeeze(&self) -> Result<()> {
        let [_, wasm] = self.files();
        let wasm_opt = tools::binaryen()?.join("bin/wasm-opt");
        let mut node = process::command("node");
        node.arg(wasm_opt).args(WASM_FEATURES).arg(self.wasm_opt_level);
        process::run(node.arg(&wasm).arg("-o").arg(&wasm))
    }
}

/// One line that changes whenever the result of a build may.
///
/// cargo cannot be asked: both bundles are the same library to it, so that building one makes the other stale.
fn stamp(profile: Profile) -> Result<String> {
    let root = project::root();
    let mut files = project::files_below(&root.join("src"))?;
    files.extend(
        ["Cargo.toml", "Cargo.lock", ".cargo/config.toml", "xtask/src/build.rs"]
            .map(|name| root.join(name))
            .into_iter()
            .filter(|file| file.exists()),
    );
    Ok(format!("{} {:016x}\n", profile.name(), project::hash(&root, &files)?))
}
