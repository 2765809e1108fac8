//! How far is a track from the truth? Distances by time, without alignment: the plan is the frame.

use planwalk_types::{Estimate, PlanPose, Stamp, wrap_angle};

/// Distances between a track and the truth, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Moments of the track that the truth covers.
    pub compared: usize,
    /// Median distance.
    pub median_m: f64,
    /// Largest distance.
    pub max_m: f64,
    /// Distance at the last compared moment.
    pub end_m: f64,
    /// Median difference of heading, radians.
    pub median_heading_rad: f64,
    /// Whether the true end lies in the 95 % region of the estimate there.
    pub end_in_region95: bool,
}

/// Compares every estimate with the true pose nearest in time, at most `tolerance_s` away; `None` when they share no time.
pub fn evaluate(track: &[Estimate], truth: &[(Stamp, PlanPose)], tolerance_s: f64) -> Option<Errors> {
    let mut distances = Vec::new();
    let mut headings = Vec::new();
    let mut end = None;
    for estimate in track {
        let later = truth.partition_point(|(stamp, _)| *stamp < estimate.stamp);
        let around = truth[later.saturating_sub(1)..(later + 1).min(truth.len())].iter();
        let away = |t: &&(Stamp, PlanPose)| t.0.secs_since(estimate.stamp).abs();
        let Some((stamp, pose)) = around.min_by(|a, b| away(a).total_cmp(&away(b))) else { continue };
        if stamp.secs_since(estimate.stamp).abs() > tolerance_s {
            continue;
        }
        let distance = estimate.pose.origin().distance(pose.origin());
        distances.push(distance);
        headings.push(wrap_angle(estimate.pose.heading_rad - pose.heading_rad).abs());
        end = Some((distance, distance <= estimate.radius95_m));
    }
    let (end_m, end_in_region95) = end?;
    let compared = distances.len();
    distances.sort_by(f64::total_cmp);
    headings.sort_by(f64::total_cmp);
    let (median_m, max_m, median_heading_rad) = (distances[compared / 2], distances[compared - 1], headings[compared / 2]);
    Some(Errors { compared, median_m, max_m, end_m, median_heading_rad, end_in_region95 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Status;

    fn estimate(seconds: i64, x: f64) -> Estimate {
        let pose = PlanPose::new(x, 0.0, 0.1);
        let covariance = nalgebra::Matrix3::identity();
        Estimate { stamp: Stamp(seconds * 1_000_000_000), pose, covariance, radius95_m: 0.5, probability: 1.0, status: Status::Tracking }
    }

    #[test]
    fn distances_are_taken_at_the_same_moments_only() {
        let track = [estimate(0, 0.0), estimate(1, 1.2), estimate(2, 2.4), estimate(9, 100.0)];
        let truth: Vec<_> = (0..4).map(|i| (Stamp(i * 1_000_000_000 + 1_000_000), PlanPose::new(i as f64, 0.0, 0.0))).collect();
        let errors = evaluate(&track, &truth, 0.01).unwrap();
        assert_eq!(errors.compared, 3, "nothing is known of the truth at 9 s");
        assert!((errors.median_m - 0.2).abs() < 1e-12 && (errors.end_m - 0.4).abs() < 1e-12, "{errors:?}");
        assert!(errors.end_in_region95 && (errors.median_heading_rad - 0.1).abs() < 1e-12);
        assert_eq!(evaluate(&track, &[], 0.01), None);
    }
}
