//! The compiler for WebAssembly.
//!
//! It needs a standard library for its target. In this order: the one beside the current compiler; the one that rustup
//! can add to it; Debian's compiler, which comes with the library's source and builds it (about a minute, once).

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::{debian, process, project};

pub const TARGET: &str = "wasm32-unknown-unknown";

/// The crate's `rust-version`.
const OLDEST: (u32, u32) = (1, 95);

const DEBIAN_PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld"];

/// A compiler that can build for [`TARGET`].
pub enum WasmCompiler {
    /// The toolchain that runs this.
    Current,
    /// Debian's, with a standard library from source.
    Debian,
}

impl WasmCompiler {
    pub fn find() -> Result<Self> {
        let wants_debian = std::env::var("CUTFLOW_WASM").is_ok_and(|choice| choice == "debian");
        if !wants_debian {
            if has_target() {
                return Ok(Self::Current);
            }
            if process::find("rustup").is_some() {
                let added =
                    process::run(process::command("rustup").args(["target", "add", TARGET]));
                match added {
                    Ok(()) if has_target() => return Ok(Self::Current),
                    Ok(()) => {
                        eprintln!("rustup added the target to another toolchain than this one.")
                    }
                    Err(_) => eprintln!("rustup could not add the target."),
                }
            }
        }
        if !debian_is_complete() {
            debian::install(&DEBIAN_PACKAGES, "compile to WebAssembly").with_context(|| {
                format!("no standard library for {TARGET}; `rustup target add {TARGET}` is the simplest way to one")
            })?;
            if !debian_is_complete() {
                bail!(
                    "Debian's compiler is older than {}.{}: `rustup target add {TARGET}` on a machine that reaches \
                     rustup's server",
                    OLDEST.0,
                    OLDEST.1
                );
            }
        }
        println!("WebAssembly: Debian's compiler, with a standard library built from source.");
        Ok(Self::Debian)
    }

    /// `cargo SUBCOMMAND` for the target, in the wasm builds' own folder.
    ///
    /// The target's flags are in `.cargo/config.toml`; `RUSTFLAGS` would silently replace them.
    pub fn cargo(&self, subcommand: &str) -> Command {
        let mut cargo = match self {
            Self::Current => process::cargo(subcommand),
            Self::Debian => {
                let mut cargo = process::command(DEBIAN_CARGO);
                // What the rustup toolchain that runs this has left in the environment.
                for name in ["CARGO", "RUSTUP_TOOLCHAIN", "LD_LIBRARY_PATH"] {
                    cargo.env_remove(name);
                }
                cargo
                    .env("RUSTC", DEBIAN_RUSTC)
                    .env("RUSTDOC", "/usr/bin/rustdoc")
                    .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld")
                    // Building the standard library is an unstable feature of cargo.
                    .env("RUSTC_BOOTSTRAP", "1")
                    .args([subcommand, "-Zbuild-std=std,panic_abort"]);
                cargo
            }
        };
        cargo.env_remove("RUSTFLAGS").args(["--target", TARGET]);
        cargo.arg("--target-dir").arg(project::wasm_target());
        cargo
    }
}

const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";

/// Whether the current compiler has a standard library for the target beside it.
fn has_target() -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let libraries = process::ask(process::command(rustc).args([
        "--print",
        "target-libdir",
        "--target",
        TARGET,
    ]));
    let Some(folder) = libraries.map(PathBuf::from) else { return false };
    folder.read_dir().is_ok_and(|files| {
        files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libstd-"))
    })
}

/// Whether all of [`DEBIAN_PACKAGES`] are here, and new enough.
fn debian_is_complete() -> bool {
    let version = process::ask(process::command(DEBIAN_RUSTC).arg("--version"));
    version.as_deref().and_then(release).is_some_and(|found| found >= OLDEST)
        && Path::new(DEBIAN_CARGO).exists()
        && Path::new("/usr/lib/rustlib/src/rust/library/std/Cargo.toml").exists()
        && process::find("wasm-ld").is_some()
}

/// Major and minor version out of `rustc 1.96.0 (… )`.
fn release(version: &str) -> Option<(u32, u32)> {
    let mut numbers = version.split_whitespace().nth(1)?.split('.');
    Some((numbers.next()?.parse().ok()?, numbers.next()?.parse().ok()?))
}

#[cfg(test)]
mod tests {
    use super::release;

    #[test]
    fn versions_compare_as_numbers() {
        assert_eq!(release("rustc 1.96.0 (ac68faa20 2026-05-25)"), Some((1, 96)));
        assert!(release("rustc 1.100.0-nightly (x)") > release("rustc 1.96.0"));
        assert_eq!(release("not a compiler"), None);
    }
}
