//! Localisation of a path and its sightings on a floor plan.
//!
//! path + sightings × plan ──▶ [`localize`]: a particle filter over pose and scale ──▶ posterior, hypotheses, smoothed track, verdict
//! path × plan ──▶ [`place`]: every start from which a path, perfect or drifting, hits no wall, and every end
//! plan ──▶ [`ambiguity`]: how far one must walk to know where one is, and where the plan would fool anyone
//!
//! The filter is causal and can be fed live ([`Localizer`]); smoothing comes after. "Don't know" is an answer
//! ([`planwalk_types::Status`]), not an error. Nothing here touches a file, a clock or entropy; the same seed gives the same
//! bytes on any number of threads.

mod ambiguity;
mod approx;
mod attempts;
mod banded;
#[doc(hidden)]
pub mod bench_entry;
mod calibrate;
mod cast;
mod chance;
mod contradicted;
mod discriminate;
mod drift;
mod faces;
mod field;
mod filter;
mod history;
mod likelihood;
mod look;
mod modes;
mod motion;
mod options;
mod particles;
mod placement;
mod polish;
mod predict;
mod prior;
mod report;
mod run;
mod smooth;
mod survival;
mod verdict;
mod walls;

pub use ambiguity::{Ambiguity, AmbiguityOptions, ConfusablePair, TriedWalk, ambiguity};
pub use cast::Look;
pub use contradicted::{ContradictedKind, ContradictedWall};
pub use discriminate::{Apart, Going, View as ApartView};
pub use drift::HeadingDrift;
pub use filter::{FilterView, Localizer};
pub use likelihood::SightingModel;
pub use look::{FirstLook, LookOptions, first_look};
pub use motion::NoiseFloor;
pub use options::LocateOptions;
pub use placement::{PlaceOptions, Placement, PlacementMode, Tolerance, place};
pub use prior::{ScalePrior, StartPrior};
pub use report::{ReportOptions, localize_by_report};
pub use run::{Localization, Quality, localize, localize_observed};
pub use verdict::VerdictOptions;
pub use walls::{GroundCosts, Met, Walls};

/// Why there is no answer at all.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LocateError {
    /// Nothing to localise.
    #[error("the path has {steps} steps, but localisation needs at least 1: was anything tracked?")]
    EmptyPath {
        /// How many there are.
        steps: usize,
    },
    /// A step that is no motion.
    #[error("step {index} is not finite: remove it, or repair the poses that it comes from")]
    NotFinite {
        /// Which step, counted from 0.
        index: usize,
    },
    /// Steps must follow each other.
    #[error("step {index} begins at {from_s:.6} s and ends at {to_s:.6} s: steps must go forward in time, one after the other")]
    StepsGoBack {
        /// Which step, counted from 0.
        index: usize,
        /// Where it begins, seconds.
        from_s: f64,
        /// Where it ends, seconds.
        to_s: f64,
    },
    /// A scale that no odometry has.
    #[error("a scale of {metres_per_unit} metres a unit, within {relative_sigma}, is none: it must be positive, the spread from 0 to 3")]
    BadScalePrior {
        /// Median, metres a unit.
        metres_per_unit: f64,
        /// Standard deviation of the logarithm.
        relative_sigma: f64,
    },
    /// A start that is no place.
    #[error("the start ({x}, {y}) within {sigma_m} m and {sigma_rad} rad is no place: all must be finite, the spreads not negative")]
    BadStart {
        /// Plan, metres.
        x: f64,
        /// Plan, metres.
        y: f64,
        /// Spread of the place, metres.
        sigma_m: f64,
        /// Spread of the heading, radians.
        sigma_rad: f64,
    },
    /// A start that is not on this plan.
    #[error(
        "the start ({x}, {y}) is {off_m:.1} m off the plan, which spans x {:.1}..{:.1} m, y {:.1}..{:.1} m: is it in metres, and y up?",
        span[0], span[1], span[2], span[3]
    )]
    StartOffPlan {
        /// Plan, metres.
        x: f64,
        /// Plan, metres.
        y: f64,
        /// Distance to the plan, metres.
        off_m: f64,
        /// The plan's x from, x to, y from, y to, metres.
        span: [f64; 4],
    },
    /// A range of scales or headings that holds nothing to try.
    #[error("scales from {low} to {high} m a unit hold nothing to try: both must be positive and finite, in this order")]
    BadScaleRange {
        /// Lowest, metres a unit.
        low: f64,
        /// Highest, metres a unit.
        high: f64,
    },
    /// A tolerance that is none, or so large that anything fits.
    #[error(
        "a drift of {:.3}°/√m with a length error of {:.1} % cannot be placed: give at most {:.1}°/√m and {:.0} %, none negative",
        drift_rad_per_sqrt_m.to_degrees(), 100.0 * length_error, most_drift.to_degrees(), 100.0 * most_length_error
    )]
    BadTolerance {
        /// Heading drift, radians per √metre.
        drift_rad_per_sqrt_m: f64,
        /// Most that can be placed.
        most_drift: f64,
        /// Error of a step's length, a share of it.
        length_error: f64,
        /// Most that can be placed.
        most_length_error: f64,
    },
}
