//! `cargo xtask soak`: hard use, as often as asked.

use anyhow::{Context, Result};

use crate::args::Args;
use crate::process;

/// What may be told to the harness, beside the part that is wanted.
const NUMBERS: [&str; 5] = ["--executions", "--sequences", "--cycles", "--seed", "--sequence"];

/// Runs the harness of `tests/soak` natively, in a profile of release speed that still checks sums for overflow.
pub fn soak(mut args: Args) -> Result<()> {
    let mut told = Vec::new();
    for name in NUMBERS {
        if let Some(word) = args.value(name)? {
            word.parse::<u64>().with_context(|| format!("{name} {word}: not a whole number"))?;
            told.extend([name.to_owned(), word]);
        }
    }
    if let Some(part) = args.value("--only")? {
        told.extend(["--only".into(), part]);
    }
    args.finish()?;
    let mut cargo = process::cargo("bench");
    cargo.args(["--bench", "soak", "--profile", "soak", "--"]).args(told);
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
        assert!(refused("--executions many").contains("--executions many"));
        assert!(refused("--sequences -1").contains("--sequences"));
        assert!(refused("--seed x").contains("--seed x"));
        assert!(refused("--hours 3").contains("--hours"));
    }
}
