//! `cargo xtask soak`: hard use for as long as asked.

use anyhow::{Context, Result};

use crate::args::Args;
use crate::process;

/// Minutes, where nobody says how many.
const MINUTES: f64 = 60.0;

/// Runs the harness of `tests/soak` natively. In the dev profile, whose engine is optimised and still checks sums for overflow.
pub fn soak(mut args: Args) -> Result<()> {
    let number = |args: &mut Args, name: &str| -> Result<Option<f64>> {
        let Some(word) = args.value(name)? else { return Ok(None) };
        let value = word.parse::<f64>().ok().filter(|x| x.is_finite() && *x >= 0.0);
        value.map(Some).with_context(|| format!("{name} {word}: not a number from 0 on"))
    };
    let minutes = number(&mut args, "--minutes")?.unwrap_or(MINUTES);
    let seed = args.value("--seed")?.unwrap_or_else(|| "1".into());
    seed.parse::<u64>().with_context(|| format!("--seed {seed}: not a whole number"))?;
    let only = args.value("--only")?;
    args.finish()?;
    let mut cargo = process::cargo("bench");
    cargo.args(["--bench", "soak", "--profile", "dev", "--"]);
    cargo.args(["--minutes", &minutes.to_string(), "--seed", &seed]);
    if let Some(part) = only {
        cargo.args(["--only", &part]);
    }
    process::run(&mut cargo)
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
        assert!(refused("--minutes soon").contains("--minutes soon"));
        assert!(refused("--minutes -1").contains("--minutes"));
        assert!(refused("--seed x").contains("--seed x"));
        assert!(refused("--hours 3").contains("--hours"));
    }
}
