//! Which bench, on what, and which part of it?

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;

use super::{Common, MethodName};

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Suite: smoke, sim, locate, real, odometry, speed, or a TOML file
    #[arg(value_name = "SUITE")]
    pub suite: String,
    /// Folder that the suite's paths start from
    #[arg(long, value_name = "DIR", env = "PLANWALK_DATA", default_value = "../shared/data")]
    pub data: PathBuf,
    /// Localiser to run; may be given more than once [default: as the suite says, else both]
    #[arg(long = "method", value_enum, value_name = "NAME")]
    pub methods: Vec<MethodName>,
    /// Seeds of each walk [default: as the suite says]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000), conflicts_with = "seed")]
    pub seeds: Option<u64>,
    /// Only walks whose names hold this text
    #[arg(long, value_name = "TEXT")]
    pub only: Option<String>,
    /// Only every n-th job, from the i-th: for several machines
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Go on with the bench in DIR: what its results.jsonl has is not run again
    #[arg(long)]
    pub resume: bool,
    /// Results of another bench: say what changed since, and whether it is noise
    #[arg(long, value_name = "JSONL")]
    pub compare: Option<PathBuf>,
    /// Name the walks and do nothing
    #[arg(long)]
    pub list: bool,
    /// Shared arguments; a seed here runs that one only
    #[command(flatten)]
    pub common: Common,
}

/// A part of a bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which part, counted from 1.
    pub part: usize,
    /// Of how many.
    pub of: usize,
}

impl FromStr for Shard {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(part, of)| Some((part.trim().parse().ok()?, of.trim().parse().ok()?)));
        match parts {
            Some((part, of)) if (1..=of).contains(&part) => Ok(Self { part, of }),
            _ => Err("give the part and the number of parts, e.g. 2/8 for the second of eight".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_parts_of_a_whole() {
        assert_eq!("2/8".parse(), Ok(Shard { part: 2, of: 8 }));
        assert!(["0/8", "9/8", "1", "1/0", "a/b", "-1/2"].iter().all(|text| text.parse::<Shard>().is_err()));
    }
}
