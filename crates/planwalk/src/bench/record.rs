//! What is kept of one run? A line of `results.jsonl`: which walk, which seed, which method, and every score.

use planwalk_types::Status;
use serde::{Deserialize, Serialize};

use crate::evaluate::{OdometryScores, PlaceScores};

/// Name and version of a record's layout. A field may be added under the same number; what changes or goes raises it.
pub const SCHEMA: &str = "planwalk-bench/1";

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// [`SCHEMA`].
    pub schema: String,
    /// Suite.
    pub suite: String,
    /// Row of the table that it counts in.
    pub group: String,
    /// The walk.
    pub case: String,
    /// The localiser, or whose answer it is.
    pub method: String,
    /// What chance grew from.
    pub seed: u64,
    /// Version of the program.
    pub version: String,
    /// Hash of everything that the walk and the method were given, so that a changed suite is not taken for the same.
    pub given: String,
    /// Length of the walk in time, seconds.
    pub walk_s: f64,
    /// Time taken by the odometry, seconds.
    pub odometry_s: Option<f64>,
    /// Time taken by the localisation, seconds.
    pub locate_s: Option<f64>,
    /// The verdict at the end.
    pub status: Option<Status>,
    /// How often the track enters a wall.
    #[serde(default)]
    pub wall_crossings: Option<usize>,
    /// How the place was found.
    pub place: Option<PlaceScores>,
    /// How the odometry followed.
    pub odometry: Option<OdometryScores>,
    /// Why there are no scores.
    pub error: Option<String>,
}

/// Which run a record is of.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The walk.
    pub case: String,
    /// What chance grew from.
    pub seed: u64,
    /// The localiser.
    pub method: String,
}

/// Why a line is no record.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Not JSON, or not a record.
    #[error("line {line} is no record of a bench: {source}")]
    Line {
        /// Counted from 1.
        line: usize,
        /// What the parser says.
        source: serde_json::Error,
    },
    /// Of a version that cannot be read.
    #[error("line {line} has the layout \"{schema}\", and this program reads {SCHEMA}: run the bench again")]
    Schema {
        /// Counted from 1.
        line: usize,
        /// What it says.
        schema: String,
    },
}

impl Record {
    /// Which run this is of.
    pub fn key(&self) -> Key {
        Key { case: self.case.clone(), seed: self.seed, method: self.method.clone() }
    }

    /// As a line, without its end.
    pub fn to_line(&self) -> String {
        // A record has no maps with keys that are not text, and so always becomes JSON.
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// The records of a `results.jsonl`. A last line without its end is what an interrupted run leaves, and is passed over.
///
/// # Errors
/// [`RecordError`] names the line.
pub fn parse(text: &str) -> Result<Vec<Record>, RecordError> {
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let lines = whole.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(index, row)| {
            let line = index + 1;
            let record: Record = serde_json::from_str(row).map_err(|source| RecordError::Line { line, source })?;
            if record.schema == SCHEMA { Ok(record) } else { Err(RecordError::Schema { line, schema: record.schema }) }
        })
        .collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::evaluate::place::{AnswerScores, Recall};

    /// A run without scores.
    pub fn record(case: &str, seed: u64, method: &str) -> Record {
        Record {
            schema: SCHEMA.to_owned(),
            suite: "test".to_owned(),
            group: "walks".to_owned(),
            case: case.to_owned(),
            method: method.to_owned(),
            seed,
            version: "0".to_owned(),
            given: String::new(),
            walk_s: 10.0,
            odometry_s: None,
            locate_s: Some(2.0),
            status: Some(Status::Tracking),
            wall_crossings: None,
            place: None,
            odometry: None,
            error: None,
        }
    }

    /// The same with a track that is off by so much all along.
    pub fn with_end(record: Record, end_m: f64) -> Record {
        let track = AnswerScores {
            compared: 10,
            median_m: end_m,
            mean_m: end_m,
            rmse_m: end_m,
            ce95_m: end_m,
            max_m: end_m,
            end_m,
            end_right: end_m <= 1.0,
            end_in_radius95: true,
            heading_median_rad: None,
            heading_rmse_rad: None,
            recall: vec![Recall { within_m: 1.0, of_moments: 1.0, of_distance: 1.0 }],
            calibration: None,
            calibration_tracking: None,
        };
        let place = PlaceScores { duration_s: 10.0, length_m: 12.0, track, filter: None, hypotheses: None, scale: None, kidnap: None };
        Record { place: Some(place), ..record }
    }

    #[test]
    fn records_survive_the_trip_through_their_lines_to_the_bit() {
        let records = [with_end(record("a", 1, "m"), 0.1 + 0.2), record("b", 2, "m")];
        let text: String = records.iter().map(|r| r.to_line() + "\n").collect();
        assert_eq!(parse(&text).unwrap(), records);
        // A line without its end is what an interrupted run leaves.
        assert_eq!(parse(&text[..text.len() - 10]).unwrap().len(), 1);
        assert_eq!(parse("").unwrap(), []);
    }

    #[test]
    fn what_is_no_record_is_named_by_its_line() {
        let good = record("a", 1, "m").to_line() + "\n";
        assert!(parse(&format!("{good}{{}}\n")).unwrap_err().to_string().contains("line 2"));
        let old = good.replace(SCHEMA, "planwalk-bench/0");
        assert!(parse(&old).unwrap_err().to_string().contains("planwalk-bench/0"));
    }
}
