//! How is a bench run? A suite's walks become jobs, jobs become records, and an interrupted bench goes on where it ended.
//!
//! suite (TOML) ──▶ jobs ──▶ [`walk`] (read, followed, or [`simulated`]) ──▶ each method ──▶ scores ──▶ a line of `results.jsonl`

pub mod run;
pub mod simulated;
pub mod suite;
pub mod walk;
