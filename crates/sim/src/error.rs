//! Why is there no simulation?

use planwalk_types::{CameraError, PlanError};

/// Why a scene cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimError {
    /// An option outside its range.
    #[error("{what} is {value}, but must lie in {low}..={high}")]
    Option {
        /// Which option, with its unit.
        what: &'static str,
        /// What was given.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
    /// A kind of building that is not known.
    #[error("there is no kind of building named \"{name}\": take office, open_plan, flat, loop or round")]
    NoSuchKind {
        /// What was asked for.
        name: String,
    },
    /// Nowhere to walk, or not far enough.
    #[error(
        "no walk of {wanted_m:.1} m was found in {tries} tries (the longest has {found_m:.1} m): open more doors, walk for a shorter \
         time, or take another seed"
    )]
    NoWalk {
        /// Length wanted, metres.
        wanted_m: f64,
        /// Longest length found, metres.
        found_m: f64,
        /// Routes tried.
        tries: usize,
    },
    /// A plan on which nothing is inside.
    #[error(
        "of the plan's {free_m2:.1} m² of free floor, {inside_m2:.1} m² are inside a building: is the outline closed, and the scale right?"
    )]
    NoInside {
        /// Free floor, m².
        free_m2: f64,
        /// Free floor inside, m².
        inside_m2: f64,
    },
    /// Poses that make no path.
    #[error("pose {index} of {count} makes no path for a camera: {what}; give finite poses in the order of their stamps")]
    Path {
        /// Which pose, counted from 0.
        index: usize,
        /// Poses given.
        count: usize,
        /// What is wrong with it.
        what: &'static str,
    },
    /// The building makes no floor plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The camera is none.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

/// Checks that an option lies in its range; NaN does not.
pub(crate) fn in_range(what: &'static str, value: f64, low: f64, high: f64) -> Result<(), SimError> {
    if value >= low && value <= high { Ok(()) } else { Err(SimError::Option { what, value, low, high }) }
}
