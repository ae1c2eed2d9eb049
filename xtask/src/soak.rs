//! `cargo xtask soak`: hard use, as often as asked.

use anyhow::{Context, Result, bail};

use crate::args::Args;
use crate::build::{Profile, build};
use crate::{browser, process};

/// What may be told to the harness, beside the part that is wanted.
const NUMBERS: [&str; 5] = ["--executions", "--sequences", "--cycles", "--seed", "--sequence"];

/// The part that needs a browser.
const BROWSER: &str = "browser";

/// Runs the harness of `tests/soak` natively, in a profile of release speed that still checks sums for overflow; then the page's long
/// run in a browser.
pub fn soak(mut args: Args) -> Result<()> {
    let mut told = Vec::new();
    for name in NUMBERS {
        if let Some(word) = args.value(name)? {
            word.parse::<u64>().with_context(|| format!("{name} {word}: not a whole number"))?;
            told.extend([name.to_owned(), word]);
        }
    }
    let hours = match args.value("--hours")? {
        None => None,
        Some(word) => match word.parse::<f64>() {
            Ok(hours) if hours > 0.0 && hours <= 100.0 => Some(hours),
            _ => bail!("--hours {word}: not a number of hours"),
        },
    };
    let only = args.value("--only")?;
    args.finish()?;
    // Who asks for one part, or says how much of the native ones, waits for no others.
    let is_whole = only.is_none() && told.is_empty();
    let wants_browser = only.as_deref() == Some(BROWSER) || hours.is_some() || is_whole;
    let mut native = Ok(());
    if only.as_deref() != Some(BROWSER) {
        let mut cargo = process::cargo("bench");
        cargo.args(["--bench", "soak", "--profile", "soak", "--"]).args(told);
        if let Some(part) = &only {
            cargo.args(["--only", part]);
        }
        native = process::run(&mut cargo);
    }
    if wants_browser {
        build(Profile::Release)?;
        browser::soak(hours.unwrap_or(2.0))?;
    }
    native
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(line: &str) -> String {
        let args = Args::new(line.split_whitespace().map(str::to_owned).collect());
        soak(args).unwrap_err().to_string()
    }

    #[test]
    fn numbers_that_are_none_are_refused_before_anything_is_built() {
        assert!(refused("--executions many").contains("--executions many"));
        assert!(refused("--sequences -1").contains("--sequences"));
        assert!(refused("--seed x").contains("--seed x"));
        assert!(refused("--hours 0").contains("--hours 0"));
        assert!(refused("--days 3").contains("--days"));
    }
}
