//! `cargo xtask bench`: the figures.

use anyhow::Result;

use crate::build::{BUNDLES, pkg};
use crate::{process, sizes};

/// Hands `arguments` on to the benchmark.
pub fn bench(arguments: Vec<String>) -> Result<()> {
    process::run(process::cargo("bench").args(["--bench", "ratios", "--"]).args(arguments))?;
    let is_built = BUNDLES.iter().flat_map(|bundle| bundle.files()).all(|file| file.exists());
    if is_built {
        sizes::print(&pkg())
    } else {
        println!(
            "The wasm files are not built; `cargo xtask build --dist` does that and prints their sizes."
        );
        Ok(())
    }
}
