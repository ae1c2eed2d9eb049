//! What the wasm files weigh, as they are and as they travel.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use flate2::Compression;
use flate2::write::GzEncoder;

use crate::build::BUNDLES;

/// Bytes of one wasm file after gzip. A phone on a mediocre line (8 Mbit/s) loads it in 1.5 s.
const BUDGET: usize = 1_500_000;

struct Size {
    name: String,
    raw: usize,
    gzip: usize,
}

/// Prints the sizes of the wasm files in a folder.
pub fn print(folder: &Path) -> Result<()> {
    for size in sizes(folder)? {
        println!(
            "{:<16} {:>9} raw {:>9} gzip",
            size.name,
            kilobytes(size.raw),
            kilobytes(size.gzip)
        );
    }
    Ok(())
}

/// Says which of them are heavier than they should be. A page that loads a second later is still a page.
pub fn warn(folder: &Path) -> Result<()> {
    for size in sizes(folder)?.into_iter().filter(|size| size.gzip > BUDGET) {
        eprintln!(
            "warning: {} weighs {} after gzip; the aim is {}",
            size.name,
            kilobytes(size.gzip),
            kilobytes(BUDGET)
        );
    }
    Ok(())
}

fn sizes(folder: &Path) -> Result<Vec<Size>> {
    let size = |name: String| {
        let file = folder.join(&name);
        let bytes =
            std::fs::read(&file).with_context(|| format!("could not read {}", file.display()))?;
        let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
        gzip.write_all(&bytes)?;
        Ok(Size { name, raw: bytes.len(), gzip: gzip.finish()?.len() })
    };
    BUNDLES.iter().map(|bundle| size(format!("{}_bg.wasm", bundle.name))).collect()
}

fn kilobytes(bytes: usize) -> String {
    format!("{} kB", bytes.div_ceil(1000))
}
