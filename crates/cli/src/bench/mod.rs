//! How is a bench run? A suite's walks become jobs, jobs become records, and an interrupted bench goes on where it ended.
//!
//! suite (TOML) ──▶ jobs ──▶ [`walk`] (read, simulate, follow) ──▶ each method ──▶ scores ──▶ a line of `results.jsonl`

pub mod run;
pub mod suite;
pub mod walk;
