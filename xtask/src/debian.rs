//! Packages of Debian and its relatives.

use anyhow::{Context, Result, bail};

use crate::process;

/// Installs packages, or says how to.
///
/// `why` completes the sentence "… are needed to".
pub fn install(packages: &[&str], why: &str) -> Result<()> {
    let list = packages.join(" ");
    if process::find("apt-get").is_none() {
        bail!("to {why}, install what Debian calls {list} in this system's way, and try again");
    }
    let Some(prefix) = privilege() else {
        bail!(
            "to {why}, install packages, which this account may not do by itself, and try again:\n\n    \
             sudo apt-get update && sudo apt-get install -y {list}\n"
        );
    };
    println!("Installing {list}, needed to {why}.");
    let apt = |arguments: &[&str]| {
        let mut words = prefix.to_vec();
        words.extend(["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"]);
        words.extend(arguments);
        process::run(process::command(words[0]).args(&words[1..]))
    };
    // Without an update a fresh machine knows no packages, or old ones that are gone. It also fails where one of
    // several sources is out of reach, which need not be the one that counts.
    if let Err(error) = apt(&["update"]) {
        eprintln!("warning: {error:#}; going on with the package lists at hand");
    }
    let mut arguments = vec!["install", "-y", "--no-install-recommends"];
    arguments.extend(packages);
    apt(&arguments).with_context(|| format!("could not install {list}, needed to {why}"))
}

/// What to put before a command that only root may run; `None` if nothing helps.
fn privilege() -> Option<&'static [&'static str]> {
    let is_root = process::ask(process::command("id").arg("-u"))? == "0";
    if is_root {
        return Some(&[]);
    }
    process::ask(process::command("sudo").args(["-n", "true"])).map(|_| &["sudo", "-n"][..])
}
