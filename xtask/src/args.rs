//! The words after the command.

use anyhow::{Context, Result, bail};

/// Words not yet understood. Each question takes its answer away, so that `finish` finds the misspelt ones.
pub struct Args(Vec<String>);

impl Args {
    pub fn new(words: Vec<String>) -> Self {
        Self(words)
    }

    pub fn flag(&mut self, name: &str) -> bool {
        let before = self.0.len();
        self.0.retain(|word| word != name);
        self.0.len() < before
    }

    /// The word after `name`, or after its `=`.
    pub fn value(&mut self, name: &str) -> Result<Option<String>> {
        let is_it = |word: &String| {
            word.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('='))
        };
        let Some(at) = self.0.iter().position(is_it) else { return Ok(None) };
        let word = self.0.remove(at);
        if let Some((_, value)) = word.split_once('=') {
            return Ok(Some(value.into()));
        }
        if at == self.0.len() || self.0[at].starts_with("--") {
            bail!("{name} needs a value after it");
        }
        Ok(Some(self.0.remove(at)))
    }

    pub fn number(&mut self, name: &str) -> Result<Option<u16>> {
        self.value(name)?
            .map(|word| {
                word.parse().with_context(|| format!("{name} {word}: not a number up to 65535"))
            })
            .transpose()
    }

    pub fn finish(self) -> Result<()> {
        match self.0.first() {
            None => Ok(()),
            Some(word) => bail!("unknown argument `{word}`; see `cargo xtask help`"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Args;

    fn args(line: &str) -> Args {
        Args::new(line.split_whitespace().map(str::to_owned).collect())
    }

    #[test]
    fn a_value_follows_its_name_or_its_equals_sign() {
        assert_eq!(args("--port 81").number("--port").unwrap(), Some(81));
        assert_eq!(args("--port=81").number("--port").unwrap(), Some(81));
        assert_eq!(args("--dist").number("--port").unwrap(), None);
    }

    #[test]
    fn what_nobody_asked_for_is_an_error() {
        let mut given = args("--dist --prot 81");
        assert!(given.flag("--dist"));
        assert_eq!(given.number("--port").unwrap(), None);
        assert!(given.finish().unwrap_err().to_string().contains("--prot"));
    }

    #[test]
    fn a_missing_or_senseless_value_is_an_error() {
        assert!(args("--port").number("--port").is_err());
        assert!(args("--port --dist").number("--port").is_err());
        assert!(args("--port eighty").number("--port").is_err());
    }
}
