//! How did the camera move, and what did it see? Monocular visual odometry for first-person video.
//!
//! frames ─▶ [`visual`] (tracks, two views, map) ─▶ camera poses ─▶ [`ground`] ─▶ path + sightings
//!                                                       └───────▶ [`metres`] ─▶ how long a unit is
//!
//! Lengths are in a unit of its own, which is about a metre for a walking person; the plan gives the rest.
//! Nothing here touches a file, a clock or entropy.

pub mod ground;
pub mod metres;
pub mod upright;
pub mod visual;

pub use metres::{Cue, Evidence, MetricScale};
pub use visual::focal::{FocalEstimate, LensSample};
pub use visual::odometry::{OdometryOptions, VisualOdometry};
pub use visual::outcome::{FrameQuality, FrameReport, Gap, Odometry, OdometryError};
pub use visual::two_view::Solver;
