//! How far is it from the truth? Scores of odometry and of tracks on the plan, and whether what was claimed held.
//!
//! estimate + truth ──[`associate()`] by time──▶ pairs ──┬─[`align()`]──▶ [`odometry::score`]: ATE, RPE, drift (the odometry's frame is its own)
//!                                                  └──▶ [`curves()`] ──▶ [`place::score`]: errors, recall, calibration (the plan is the frame);
//!                                                               [`scale::score`]: metres per unit
//!
//! Everything is pure: poses in, numbers out. Pitfalls: two files may run on two clocks ([`EvaluateError::NoOverlap`]), and a
//! truth clicked once a second is far from most frames ([`AssociateOptions::max_gap_s`]).

pub mod align;
pub mod associate;
pub mod causal;
pub mod curves;
pub mod file;
pub mod odometry;
pub mod place;
pub mod scale;
pub mod statistics;
pub mod words;

pub use align::{Alignment, align};
pub use associate::{AssociateOptions, Match, associate};
pub use causal::{CausalScores, Convergence, KidnapScores, Stay};
pub use curves::{Curves, Moment, curves};
pub use file::{Evaluation, Pace, Timing};
pub use odometry::{OdometryScoreOptions, OdometryScores};
pub use place::{PlaceOptions, PlaceScores};
pub use scale::ScaleScores;
pub use statistics::Summary;

/// Why there is nothing to score.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EvaluateError {
    /// Two clocks, or two walks.
    #[error(
        "they share no time: the truth spans {truth_from_s:.3} to {truth_to_s:.3} s, the track {track_from_s:.3} to {track_to_s:.3} s; \
         if they began together on two clocks, give --time-offset {offset_s:.3}"
    )]
    NoOverlap {
        /// First moment of the truth, seconds.
        truth_from_s: f64,
        /// Last moment of the truth, seconds.
        truth_to_s: f64,
        /// First moment of the track, offset included, seconds.
        track_from_s: f64,
        /// Last moment of the track, offset included, seconds.
        track_to_s: f64,
        /// Offset that makes both begin together, seconds.
        offset_s: f64,
    },
    /// The same time, but few common moments.
    #[error(
        "{got} moments in common, but {need} are needed: the nearest two stamps are {nearest_s:.3} s apart, and --max-diff is \
         {max_diff_s} s; give a larger one, or --interpolate-truth for a truth that is sampled coarsely"
    )]
    TooFewPairs {
        /// Pairs found.
        got: usize,
        /// Pairs needed.
        need: usize,
        /// Smallest distance in time, seconds.
        nearest_s: f64,
        /// [`AssociateOptions::max_diff_s`].
        max_diff_s: f64,
    },
    /// Nothing to go by.
    #[error("the {what} has {got} poses, but 2 are needed at least")]
    TooFewPoses {
        /// Truth or track.
        what: &'static str,
        /// How many there are.
        got: usize,
    },
    /// A coordinate that is no number.
    #[error("pose {index} of the {what} is not finite: leave out what was not measured")]
    NotFinite {
        /// Truth or track.
        what: &'static str,
        /// Which pose, counted from 0.
        index: usize,
    },
    /// A clock that does not run forward.
    #[error("stamps of the {what} go back at pose {index}, {at_s:.6} s: sort them by time and drop repeated ones")]
    StampsGoBack {
        /// Truth or track.
        what: &'static str,
        /// Which pose, counted from 0.
        index: usize,
        /// Its stamp, seconds.
        at_s: f64,
    },
    /// All positions on a line or in a point.
    #[error("{alignment} alignment is not defined: the {pairs} positions lie {shape}; use {instead}")]
    Degenerate {
        /// What was asked for.
        alignment: Alignment,
        /// How many positions.
        pairs: usize,
        /// How they lie.
        shape: &'static str,
        /// What would be defined.
        instead: &'static str,
    },
    /// An option outside its range.
    #[error("{name} is {value}, but {must}")]
    BadOption {
        /// As on the command line.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
}
