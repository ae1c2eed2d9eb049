//! Where things are.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// The folder of the top-level Cargo.toml.
pub fn root() -> PathBuf {
    // `cargo run` says where it is now; where this was compiled may be another checkout that shares its target folder.
    let here = std::env::var("CARGO_MANIFEST_DIR");
    let here = PathBuf::from(here.as_deref().unwrap_or(env!("CARGO_MANIFEST_DIR")));
    here.parent().unwrap_or(&here).to_path_buf()
}

/// Where native builds go: what cargo itself would use.
pub fn target() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => root().join(folder),
        None => root().join("target"),
    }
}

/// Where wasm builds go. A folder of their own: two compilers that share one rebuild everything at each change of turn.
pub fn wasm_target() -> PathBuf {
    target().join("wasm")
}

/// Where tools are installed that only this project uses.
pub fn tools() -> PathBuf {
    root().join("target/tools")
}

/// The page's folder.
pub fn www() -> PathBuf {
    root().join("www")
}

/// The folder of the browser tests, which is also their npm package.
pub fn browser_tests() -> PathBuf {
    root().join("tests/browser")
}

/// The folder of what reads exported files, which is also its npm package.
pub fn readers() -> PathBuf {
    root().join("tests/readers")
}

/// All files in a folder and its folders, sorted. Names that start with a dot are left out.
pub fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        let entries =
            folder.read_dir().with_context(|| format!("could not read {}", folder.display()))?;
        for entry in entries {
            let path = entry?.path();
            let is_hidden =
                path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            if is_hidden {
                continue;
            }
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    Ok(files)
}

/// FNV-1a of names (relative to `base`) and contents: the same on every machine and with every compiler.
pub fn hash(base: &Path, files: &[PathBuf]) -> Result<u64> {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |bytes: &[u8]| {
        for byte in bytes {
            hash = (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    for file in files {
        let name = file.strip_prefix(base).unwrap_or(file).to_string_lossy().replace('\\', "/");
        let bytes =
            std::fs::read(file).with_context(|| format!("could not read {}", file.display()))?;
        // The length keeps `ab` + `c` apart from `a` + `bc`.
        add(name.as_bytes());
        add(&bytes.len().to_le_bytes());
        add(&bytes);
    }
    Ok(hash)
}
