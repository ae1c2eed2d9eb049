//! Hard use: commands in any order, damaged files, surfaces that hardly are any. Short as tests here, long by `cargo xtask soak`.

pub mod commands;
pub mod cycles;
pub mod degenerate;
pub mod documents;
pub mod fuzzing;
pub mod names;
pub mod sequences;
pub mod sound;

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Processor time of this thread so far; `None` where the system does not tell.
pub fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/stat").ok()?;
    // After the name in brackets: state, then ten numbers, then user and system time in hundredths.
    let rest = text.rsplit_once(')')?.1;
    let mut times = rest.split_whitespace().skip(11).map(str::parse::<f64>);
    Some((times.next()?.ok()? + times.next()?.ok()?) / 100.0)
}

/// What a piece of work says, or the words of its panic.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(format!("panic: {}", text.unwrap_or("without words")))
    })
}
