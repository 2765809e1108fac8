//! Stories of files: what is in them comes out, and what is wrong with them is said.

mod stories;
mod support;
