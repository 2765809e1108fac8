//! How far off was the answer at each moment of the walk, and how far did it claim to be?

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use planwalk_types::{Estimate, PlanPose, Stamp, Status, wrap_angle};

use super::EvaluateError;
use super::associate::{Match, associate};
use super::place::PlaceOptions;

/// An answer and the truth at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The estimate's own stamp.
    pub stamp: Stamp,
    /// Metres walked since the first compared moment, along the truth.
    pub distance_m: f64,
    /// Horizontal distance from the truth, metres.
    pub error_m: f64,
    /// Difference of heading, 0..=π; `None` where the truth does not say it.
    pub heading_error_rad: Option<f64>,
    /// Squared distance in standard deviations of position (Mahalanobis, 2 degrees of freedom); `None` where the covariance is
    /// none (not positive definite).
    pub position_d2: Option<f64>,
    /// The same with the heading (3 degrees of freedom).
    pub pose_d2: Option<f64>,
    /// Radius that was claimed to hold the truth with 95 %, metres.
    pub radius95_m: f64,
    /// What was claimed.
    pub status: Status,
    /// Claimed metres per unit of odometry; `None` where nothing was said.
    pub metres_per_unit: Option<f64>,
}

/// Every compared moment of both answers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// The smoothed track: what is known at the end of every moment.
    pub track: Vec<Moment>,
    /// The causal answer: what was known at each moment; may be empty.
    pub filter: Vec<Moment>,
}

/// A point of the recall curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecallPoint {
    /// Metres.
    pub within_m: f64,
    /// Share of the moments with no larger error.
    pub of_moments: f64,
    /// Share of the distance walked with no larger error.
    pub of_distance: f64,
}

/// Compares both answers with the truth, moment by moment. No alignment: the plan is the frame. `filter` may be empty.
///
/// # Errors
/// [`EvaluateError`]: nothing in common, numbers that are none, options out of range.
pub fn curves(
    track: &[Estimate],
    filter: &[Estimate],
    truth: &[(Stamp, PlanPose)],
    options: &PlaceOptions,
) -> Result<Curves, EvaluateError> {
    let finite = |p: &PlanPose| p.x.is_finite() && p.y.is_finite() && p.heading_rad.is_finite();
    if let Some(index) = truth.iter().position(|(_, pose)| !finite(pose)) {
        return Err(EvaluateError::NotFinite { what: "truth", index });
    }
    for estimates in [track, filter] {
        if let Some(index) = estimates.iter().position(|e| !finite(&e.pose)) {
            return Err(EvaluateError::NotFinite { what: "track", index });
        }
    }
    let walked = walked(truth, options.carried_at);
    let mut track = moments(track, truth, &walked, options)?;
    let mut filter = if filter.is_empty() { Vec::new() } else { moments(filter, truth, &walked, options)? };
    // One origin for both, so that distances mean the same.
    let origin = track.first().into_iter().chain(filter.first()).map(|m| m.distance_m).fold(f64::INFINITY, f64::min);
    for moment in track.iter_mut().chain(&mut filter) {
        moment.distance_m -= origin;
    }
    Ok(Curves { track, filter })
}

/// Metres along the truth up to each of its poses. Who is carried to the pose of `carried_at` does not walk there.
fn walked(truth: &[(Stamp, PlanPose)], carried_at: Option<Stamp>) -> Vec<f64> {
    let mut sum = 0.0;
    let mut out = Vec::with_capacity(truth.len());
    for (i, (stamp, pose)) in truth.iter().enumerate() {
        if i > 0 && Some(*stamp) != carried_at {
            sum += pose.origin().distance(truth[i - 1].1.origin());
        }
        out.push(sum);
    }
    out
}

fn moments(
    estimates: &[Estimate],
    truth: &[(Stamp, PlanPose)],
    walked: &[f64],
    options: &PlaceOptions,
) -> Result<Vec<Moment>, EvaluateError> {
    let stamps: Vec<Stamp> = estimates.iter().map(|e| e.stamp).collect();
    let of_truth: Vec<Stamp> = truth.iter().map(|(s, _)| *s).collect();
    let matches = associate(&stamps, &of_truth, &options.associate, 2)?;
    let moment = |m: &Match| {
        let distance_m = walked[m.before] + m.share * (walked[m.after] - walked[m.before]);
        moment(&estimates[m.estimate], m.on_plan(truth), distance_m, options.truth_faces)
    };
    Ok(matches.iter().map(moment).collect())
}

fn moment(estimate: &Estimate, truth: PlanPose, distance_m: f64, faces: bool) -> Moment {
    let off = Vector2::new(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
    let turn = wrap_angle(estimate.pose.heading_rad - truth.heading_rad);
    let c: &Matrix3<f64> = &estimate.covariance;
    let position: Matrix2<f64> = c.fixed_view::<2, 2>(0, 0).into();
    let position_d2 = position.cholesky().map(|l| off.dot(&l.solve(&off))).filter(|d| d.is_finite());
    let pose_off = Vector3::new(off.x, off.y, turn);
    let pose_d2 = c.cholesky().map(|l| pose_off.dot(&l.solve(&pose_off))).filter(|d| faces && d.is_finite());
    Moment {
        stamp: estimate.stamp,
        distance_m,
        error_m: off.norm(),
        heading_error_rad: faces.then_some(turn.abs()),
        position_d2,
        pose_d2,
        radius95_m: estimate.radius95_m,
        status: estimate.status,
        metres_per_unit: estimate.scale.map(|s| s.metres_per_unit),
    }
}

/// Metres of the walk that each moment stands for: half of the way to each neighbour.
pub(super) fn metres_of(moments: &[Moment]) -> Vec<f64> {
    let step = |a: Option<&Moment>, b: Option<&Moment>| a.zip(b).map_or(0.0, |(a, b)| 0.5 * (b.distance_m - a.distance_m).max(0.0));
    let around = |i: usize| step(i.checked_sub(1).and_then(|j| moments.get(j)), moments.get(i)) + step(moments.get(i), moments.get(i + 1));
    (0..moments.len()).map(around).collect()
}

/// Share of moments, and of metres walked, with an error of at most `within_m`.
pub fn recall(moments: &[Moment], within_m: f64) -> RecallPoint {
    let metres = metres_of(moments);
    let right = |m: &Moment| m.error_m <= within_m;
    let of_moments = super::statistics::share(moments.iter().map(right));
    let whole: f64 = metres.iter().sum();
    // From 0: a sum of nothing is −0, which would be written so.
    let walked = moments.iter().zip(&metres).filter(|(m, _)| right(m)).fold(0.0, |sum, (_, metres)| sum + metres);
    // Who stood still is where the moments say.
    let of_distance = if whole > 0.0 { walked / whole } else { of_moments };
    RecallPoint { within_m, of_moments, of_distance }
}

/// Share of the moments whose truth lies inside the Gaussian region that claims to hold it with probability `nominal`; moments
/// without a covariance count as outside. `None` when no moment has one.
pub fn coverage(moments: &[Moment], nominal: f64) -> Option<f64> {
    moments.iter().any(|m| m.position_d2.is_some()).then(|| {
        // χ² with two degrees of freedom: P(d² ≤ q) = 1 − exp(−q/2).
        let inside = |m: &Moment| m.position_d2.is_some_and(|d2| -(-0.5 * d2).exp_m1() <= nominal);
        super::statistics::share(moments.iter().map(inside))
    })
}
