//! Why did it end without an answer? A message (what, why, what to do; the path last) and an exit code.

use std::fmt::Display;
use std::path::Path;

/// The end of a command that did not do what it was asked to.
#[derive(Debug, PartialEq, Eq)]
pub struct Failure {
    /// What happened, why, and what to do.
    pub message: String,
    /// Exit code.
    pub code: u8,
}

/// Wrong use: arguments, or an output folder that is not empty.
pub const USAGE: u8 = 2;
/// An input that cannot be used.
pub const INPUT: u8 = 4;
/// Inputs that say nothing at all.
pub const NO_ANSWER: u8 = 5;

impl Failure {
    /// Wrong use.
    pub fn usage(message: impl Display) -> Self {
        Self { message: message.to_string(), code: USAGE }
    }

    /// An input that cannot be used.
    pub fn input(what: &str, why: impl Display, path: &Path) -> Self {
        Self { message: format!("{what} cannot be used: {why}\n  {}", path.display()), code: INPUT }
    }

    /// No answer at all.
    pub fn no_answer(message: impl Display) -> Self {
        Self { message: message.to_string(), code: NO_ANSWER }
    }

    /// A result that could not be written.
    pub fn output(why: impl Display, path: &Path) -> Self {
        Self { message: format!("cannot write: {why}; is the disk full, or the folder protected?\n  {}", path.display()), code: INPUT }
    }
}
