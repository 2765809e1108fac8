//! What does `eval.json` say? The scores for programs; the schema is versioned.

use serde::{Deserialize, Serialize};

use super::{OdometryScores, PlaceScores};
use crate::result::{InputEntry, OptionEntry};

/// Name and version of the schema. A field may be added under the same number; what changes or goes raises it.
pub const SCHEMA: &str = "planwalk-eval/1";

/// The whole of `eval.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// [`SCHEMA`].
    pub schema: String,
    /// Version of the program.
    pub version: String,
    /// What was scored, for titles.
    pub name: String,
    /// The walk on the plan; `None` where only an odometry was scored.
    pub place: Option<PlaceScores>,
    /// The odometry by itself; `None` where there was none.
    pub odometry: Option<OdometryScores>,
    /// What went in.
    pub inputs: Vec<InputEntry>,
    /// Options in force, named as on the command line.
    pub options: Vec<OptionEntry>,
    /// What a person should know: assumptions made, oddities met.
    pub notes: Vec<String>,
}

impl Evaluation {
    /// Scores that say nothing yet.
    pub fn new(name: &str) -> Self {
        Self {
            schema: SCHEMA.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            name: name.to_owned(),
            place: None,
            odometry: None,
            inputs: Vec::new(),
            options: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Pretty JSON with a newline at the end.
    pub fn to_json(&self) -> String {
        // Every field is a number, a string or a list of them: nothing here can fail to be written.
        serde_json::to_string_pretty(self).map(|text| text + "\n").unwrap_or_default()
    }
}
