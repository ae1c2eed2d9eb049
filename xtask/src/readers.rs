//! Readers that are not ours: programs and libraries that open what Cutflow exports, and measure it.

use std::env::consts::EXE_EXTENSION;
use std::fs;

use anyhow::{Context, Result};

use crate::{browser, process, project, tools};

/// Programs, and the packages of Debian that have them.
const PROGRAMS: [(&str, &str); 4] = [
    ("pdfinfo", "poppler-utils"),
    ("pdffonts", "poppler-utils"),
    ("pdftoppm", "poppler-utils"),
    ("librecad", "librecad"),
];

/// The test that writes files through the library.
const WRITER: &str = "reader_files::files_for_readers_that_are_not_ours";

/// Writes files of every kind, by the library and by the command, and has them read.
pub fn test() -> Result<()> {
    let folder = project::readers();
    tools::programs(&PROGRAMS, "read exported files by other programs")?;
    tools::npm_packages(&folder)?;
    tools::npm_packages(&project::browser_tests())?;
    let chromium = tools::chromium()?;
    let python = tools::python(&folder.join("requirements.txt"))?;

    let files = project::target().join("readers");
    // What an older version wrote must not pass for what this one forgets.
    if files.exists() {
        fs::remove_dir_all(&files)
            .with_context(|| format!("could not remove {}", files.display()))?;
    }
    // The whole workspace, whose features are those of the native tests: nothing is compiled for this alone.
    let mut writer = process::cargo("test");
    writer.args(["--workspace", "--test", "it", "--", "--ignored", "--exact", WRITER]);
    process::run(writer.env("CUTFLOW_READER_FILES", &files))?;
    // Built with the tests, which run it as well.
    let command = project::target().join("debug/cutflow").with_extension(EXE_EXTENSION);
    let mut command = process::command(command);
    command.args(["cut", "sample:ball", "--steps", "3", "-o"]);
    process::run(command.arg(files.join("command")))?;

    // Both, so that one run tells all.
    let mut node = process::command("node");
    node.arg(folder.join("check.mjs")).arg(&files);
    node.env("CHROMIUM", chromium).env("CHROMIUM_FLAGS", browser::FLAGS.join(" "));
    let by_node = process::run(&mut node);
    process::run(process::command(python).arg(folder.join("check.py")).arg(&files))?;
    by_node
}
