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

/// What a piece of work says, or the words of its panic.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(format!("panic: {}", text.unwrap_or("without words")))
    })
}
