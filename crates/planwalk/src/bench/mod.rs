//! How good is a localiser over many walks? Records of runs, their statistics, tables, and what changed between two benches.
//!
//! (walk, seed, method) ──▶ [`Record`] (a line of `results.jsonl`) ──▶ [`table`] by group and method ──▶ [`mod@compare`] with another bench
//!                                                                                        └──▶ [`target`]: met or missed
//!
//! Walks are the units of chance: every interval says what other walks of the same kind would do. Nothing here runs a
//! localiser or opens a file.

pub mod compare;
pub mod metric;
pub mod record;
pub mod statistics;
pub mod table;
pub mod target;

pub use compare::{Change, compare};
pub use metric::{METRICS, Metric};
pub use record::{Key, Record, RecordError};
pub use target::{Target, Verdict};
