//! Where on the plan, how sure, and where else?

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use crate::rigid::Rigid2;
use crate::space::{Body, Plan};
use crate::time::Stamp;

/// Where the body is on the plan: metres, radians.
pub type PlanPose = Rigid2<Plan, Body>;

/// The verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// One place holds the mass, and it explains what was seen.
    Tracking,
    /// Several places explain the walk.
    Ambiguous,
    /// No place explains the walk.
    Lost,
}

impl std::fmt::Display for Status {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Status::Tracking => "tracking",
            Status::Ambiguous => "ambiguous",
            Status::Lost => "lost",
        })
    }
}

/// What is known at one moment.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// The moment.
    pub stamp: Stamp,
    /// Mean pose of the likeliest mode.
    pub pose: PlanPose,
    /// Covariance of (x, y, heading) of that mode: m², m·rad, rad².
    pub covariance: Matrix3<f64>,
    /// Radius around the mean that holds 95 % of the mode's mass, metres.
    pub radius95_m: f64,
    /// Share of the whole mass that the mode holds, 0..=1.
    pub probability: f64,
    /// The verdict at this moment.
    pub status: Status,
    /// Metres per unit of odometry in that mode; `None` where nothing is said of it (a track from elsewhere, a table).
    pub scale: Option<ScaleEstimate>,
}

/// Metres per unit of odometry.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScaleEstimate {
    /// Median.
    pub metres_per_unit: f64,
    /// Relative standard deviation (of the logarithm).
    pub relative_sigma: f64,
}

/// One place that explains the walk.
#[derive(Debug, Clone)]
pub struct Hypothesis {
    /// Share of the whole mass, 0..=1.
    pub probability: f64,
    /// Mean pose at the walk's end.
    pub pose: PlanPose,
    /// Covariance of (x, y, heading) at the end.
    pub covariance: Matrix3<f64>,
    /// Radius that holds 95 % of its mass at the end, metres.
    pub radius95_m: f64,
    /// Metres per unit of odometry under this hypothesis.
    pub scale: ScaleEstimate,
    /// The whole walk under this hypothesis, one pose a step; as long as the walk's moments.
    pub track: Vec<(Stamp, PlanPose)>,
}
