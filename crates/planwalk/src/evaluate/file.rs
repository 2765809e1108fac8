//! What do `eval.json` and `timing.json` say? The scores for programs; the schema is versioned.

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
    /// Seconds of work in a second of walk, where the run wrote them down.
    #[serde(default)]
    pub pace: Option<Pace>,
    /// What went in.
    pub inputs: Vec<InputEntry>,
    /// Options in force, named as on the command line.
    pub options: Vec<OptionEntry>,
    /// What a person should know: assumptions made, oddities met.
    pub notes: Vec<String>,
}

/// `timing.json`: how long a run took. Beside the results and not in them, because those are the same bytes for the same seed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Threads that it had.
    pub threads: usize,
    /// From the first moment of the walk to the last, seconds.
    pub walk_s: f64,
    /// Reading, decoding and following of a video, seconds.
    pub odometry_s: Option<f64>,
    /// Localisation, seconds.
    pub locate_s: Option<f64>,
}

/// Seconds of work in a second of walk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pace {
    /// Threads that it had.
    pub threads: usize,
    /// Of reading, decoding and following a video.
    pub odometry: Option<f64>,
    /// Of localisation.
    pub locate: Option<f64>,
}

impl Timing {
    /// By second of walk; `None` of a walk without any.
    pub fn pace(&self) -> Option<Pace> {
        let per = |seconds: Option<f64>| seconds.map(|s| s / self.walk_s);
        let Self { threads, .. } = *self;
        (self.walk_s > 0.0).then(|| Pace { threads, odometry: per(self.odometry_s), locate: per(self.locate_s) })
    }
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
            pace: None,
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
