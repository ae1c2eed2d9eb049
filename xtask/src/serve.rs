//! `cargo xtask serve`.

use anyhow::Result;

use crate::build::{Profile, build};
use crate::project;
use crate::server::{Site, start};

const PORT: u16 = 8080;

/// The page and nothing else of the project.
pub fn page() -> Site {
    Site::new(project::root(), &["index.html", "sw.js", "www"])
}

pub fn serve(port: Option<u16>, profile: Profile) -> Result<()> {
    build(profile)?;
    let address = start(page(), port.unwrap_or(PORT))?;
    // By this name rather than by number: a browser's error page and its permissions are kinder to it.
    println!("\nCutflow: http://localhost:{}/   (Ctrl+C ends it)", address.port());
    loop {
        std::thread::park();
    }
}
