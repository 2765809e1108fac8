//! The command as a person runs it.

mod stories;
mod support;
