//! How good is a place on the plan? Errors without alignment, when the answer came, and whether its doubt was honest.
//!
//! Circular errors (CE50, CE95) as in ISO/IEC 18305: quantiles of the horizontal error. Calibration: is the truth inside the
//! 90 % region 90 % of the time? NEES (Bar-Shalom, Li & Kirubarajan 2001, §5.4) should be near its degrees of freedom.

use planwalk_types::{Estimate, PlanPose, Stamp, Status};
use serde::{Deserialize, Serialize};

use super::EvaluateError;
use super::associate::AssociateOptions;
use super::causal::{CausalScores, KidnapScores, causal, found_again};
use super::curves::{Curves, Moment, coverage, curves, recall};
use super::scale::ScaleScores;
use super::statistics::{mean, quantile, rmse, share};

/// Options of [`score`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceOptions {
    /// How moments are brought together.
    pub associate: AssociateOptions,
    /// Whether the truth says where the walker faced.
    pub truth_faces: bool,
    /// Error up to which an answer is right, metres. The default, 1 m, tells one room from the next.
    pub right_m: f64,
    /// Error above which an answer is wrong, metres. The default is 2 m.
    pub wrong_m: f64,
    /// When the walker was carried elsewhere without walking: the stamp of the first true pose there.
    pub carried_at: Option<Stamp>,
}

impl Default for PlaceOptions {
    fn default() -> Self {
        Self { associate: AssociateOptions::default(), truth_faces: true, right_m: 1.0, wrong_m: 2.0, carried_at: None }
    }
}

/// Scores of a walk that was found on a plan. SI units; `None` where a figure is not defined.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlaceScores {
    /// Seconds from the first to the last compared moment of the track.
    pub duration_s: f64,
    /// Metres walked between them, along the truth.
    pub length_m: f64,
    /// The smoothed track, which knows the whole walk.
    pub track: AnswerScores,
    /// The causal answer, which knows no future; `None` where there is none.
    pub filter: Option<CausalScores>,
    /// The listed places; `None` where there are none, or where the truth ends before the walk.
    pub hypotheses: Option<HypothesisScores>,
    /// How well metres per unit were known; `None` where the truth of it was not given.
    #[serde(default)]
    pub scale: Option<ScaleScores>,
    /// Of a walker who was carried elsewhere on the way.
    #[serde(default)]
    pub kidnap: Option<KidnapScores>,
}

/// Errors and honesty of one answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AnswerScores {
    /// Moments compared.
    pub compared: usize,
    /// Median error (= CE50), metres.
    pub median_m: f64,
    /// Mean error, metres.
    pub mean_m: f64,
    /// Root of the mean square error, metres.
    pub rmse_m: f64,
    /// Error that 95 % of the moments keep below (CE95), metres.
    pub ce95_m: f64,
    /// Largest error, metres.
    pub max_m: f64,
    /// Error at the last compared moment, metres.
    pub end_m: f64,
    /// Whether that is at most [`PlaceOptions::right_m`].
    pub end_right: bool,
    /// Whether the true end lies within the claimed `radius95_m`.
    pub end_in_radius95: bool,
    /// Median difference of heading, radians; `None` where the truth does not say it.
    pub heading_median_rad: Option<f64>,
    /// Root of the mean square difference of heading, radians.
    pub heading_rmse_rad: Option<f64>,
    /// Shares within 0.5, 1 and 2 m.
    pub recall: Vec<Recall>,
    /// Whether the doubt was honest; `None` where none was claimed.
    pub calibration: Option<Calibration>,
    /// The same for the moments that claim to be tracking; `None` where there are none.
    #[serde(default)]
    pub calibration_tracking: Option<Calibration>,
}

/// How much of a walk was answered within a distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Recall {
    /// Metres.
    pub within_m: f64,
    /// Share of the moments, 0..=1.
    pub of_moments: f64,
    /// Share of the metres walked, 0..=1.
    pub of_distance: f64,
}

/// How honest the claimed regions were.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// How often the truth lies in the Gaussian 50, 90 and 95 % regions of the covariance.
    pub regions: Vec<Coverage>,
    /// How often it lies within `radius95_m`: 0.95 is honest.
    pub radius95: f64,
    /// Mean normalised squared error of position: 2 is honest, more is too sure, less is too shy.
    pub nees_position: Option<f64>,
    /// The same with the heading: 3 is honest.
    pub nees_pose: Option<f64>,
    /// Moments whose covariance is none (not positive definite): outside of every region, and not in the means.
    pub without_region: usize,
}

/// Claimed and real share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// What is claimed, 0..=1.
    pub nominal: f64,
    /// What holds, 0..=1.
    pub empirical: f64,
}

/// Whether the truth is among the listed places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HypothesisScores {
    /// Places listed.
    pub listed: usize,
    /// Distance of the nearest from the true end, metres.
    pub nearest_m: f64,
    /// Whether one lies within [`PlaceOptions::right_m`].
    pub any_right: bool,
    /// Probability that was given to all that do.
    pub probability_right: f64,
    /// Places that hold at least a fifth of the mass: the answers that somebody would act on.
    #[serde(default)]
    pub held: usize,
    /// Whether one of those lies within [`PlaceOptions::right_m`].
    #[serde(default)]
    pub held_right: bool,
}

/// Distances of [`AnswerScores::recall`], metres.
const RECALL_M: [f64; 3] = [0.5, 1.0, 2.0];
/// Regions of [`Calibration::regions`].
const REGIONS: [f64; 3] = [0.5, 0.9, 0.95];
/// Mass from which a place is one that somebody would act on.
const HELD: f64 = 0.2;

/// Scores a walk found on a plan; `filter` may be empty. [`PlaceScores::hypotheses`] is left to [`hypotheses`], and
/// [`PlaceScores::scale`] to [`super::scale::score`].
///
/// # Errors
/// As [`curves()`].
pub fn score(
    track: &[Estimate],
    filter: &[Estimate],
    truth: &[(Stamp, PlanPose)],
    options: &PlaceOptions,
) -> Result<PlaceScores, EvaluateError> {
    scores_of(&curves(track, filter, truth, options)?, options).ok_or(EvaluateError::TooFewPoses { what: "track", got: 0 })
}

/// The scores of curves that are there already; `None` of an empty track.
pub fn scores_of(curves: &Curves, options: &PlaceOptions) -> Option<PlaceScores> {
    let (first, last) = curves.track.first().zip(curves.track.last())?;
    Some(PlaceScores {
        duration_s: last.stamp.secs_since(first.stamp),
        length_m: last.distance_m - first.distance_m,
        track: answer(&curves.track, options)?,
        filter: causal(&curves.filter, options),
        hypotheses: None,
        scale: None,
        kidnap: options.carried_at.and_then(|at| found_again(&curves.filter, at, options.right_m)),
    })
}

pub(super) fn answer(moments: &[Moment], options: &PlaceOptions) -> Option<AnswerScores> {
    let errors: Vec<f64> = moments.iter().map(|m| m.error_m).collect();
    let headings: Vec<f64> = moments.iter().filter_map(|m| m.heading_error_rad).collect();
    let tracking: Vec<Moment> = moments.iter().filter(|m| m.status == Status::Tracking).copied().collect();
    let last = moments.last()?;
    let within = |within_m: f64| {
        let point = recall(moments, within_m);
        Recall { within_m, of_moments: point.of_moments, of_distance: point.of_distance }
    };
    Some(AnswerScores {
        compared: moments.len(),
        median_m: quantile(&errors, 0.5)?,
        mean_m: mean(&errors)?,
        rmse_m: rmse(&errors)?,
        ce95_m: quantile(&errors, 0.95)?,
        max_m: quantile(&errors, 1.0)?,
        end_m: last.error_m,
        end_right: last.error_m <= options.right_m,
        end_in_radius95: last.error_m <= last.radius95_m,
        heading_median_rad: quantile(&headings, 0.5),
        heading_rmse_rad: rmse(&headings),
        recall: RECALL_M.map(within).to_vec(),
        calibration: calibration(moments),
        calibration_tracking: calibration(&tracking),
    })
}

fn calibration(moments: &[Moment]) -> Option<Calibration> {
    let region = |nominal: f64| Some(Coverage { nominal, empirical: coverage(moments, nominal)? });
    let position: Vec<f64> = moments.iter().filter_map(|m| m.position_d2).collect();
    let pose: Vec<f64> = moments.iter().filter_map(|m| m.pose_d2).collect();
    Some(Calibration {
        regions: REGIONS.into_iter().map(region).collect::<Option<Vec<_>>>()?,
        radius95: share(moments.iter().map(|m| m.error_m <= m.radius95_m)),
        nees_position: mean(&position),
        nees_pose: mean(&pose),
        without_region: moments.len() - position.len(),
    })
}

/// Longest time between a walk's end and the truth that is taken for it, seconds: half a step of a walker.
const END_WITHIN_S: f64 = 0.5;

/// Whether a listed place (probability, pose at the end of the walk) is where the walk truly ended. `None` without places, or
/// when the truth nearest to `end` is more than half a second away.
pub fn hypotheses(places: &[(f64, PlanPose)], end: Stamp, truth: &[(Stamp, PlanPose)], options: &PlaceOptions) -> Option<HypothesisScores> {
    let end_s = |stamp: &Stamp| (stamp.secs_since(end) - options.associate.time_offset_s).abs();
    let (stamp, true_end) = truth.iter().min_by(|a, b| end_s(&a.0).total_cmp(&end_s(&b.0)))?;
    if end_s(stamp) > END_WITHIN_S || places.is_empty() {
        return None;
    }
    let away: Vec<(f64, f64)> = places.iter().map(|(p, pose)| (*p, pose.origin().distance(true_end.origin()))).collect();
    let right = |(_, distance): &&(f64, f64)| *distance <= options.right_m;
    let held = || away.iter().filter(|(p, _)| *p >= HELD);
    Some(HypothesisScores {
        listed: places.len(),
        nearest_m: away.iter().map(|(_, d)| *d).fold(f64::INFINITY, f64::min),
        any_right: away.iter().any(|a| right(&a)),
        probability_right: away.iter().filter(right).fold(0.0, |sum, (p, _)| sum + p),
        held: held().count(),
        held_right: held().any(|a| right(&a)),
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    /// A walk along x at 1 m/s (every second moment claims to be tracking) whose answer is off to the side by these metres, second by second.
    pub fn walk(off_m: &[f64], sigma_m: f64) -> (Vec<Estimate>, Vec<(Stamp, PlanPose)>) {
        let at = |i: usize| Stamp(i as i64 * 1_000_000_000);
        let estimate = |(i, off): (usize, &f64)| Estimate {
            stamp: at(i),
            pose: PlanPose::new(i as f64, *off, 0.1),
            covariance: Matrix3::from_diagonal(&Vector3::new(sigma_m, sigma_m, 0.1).map(|s| s * s)),
            radius95_m: 2.5 * sigma_m,
            probability: 1.0,
            status: if i % 2 == 0 { Status::Tracking } else { Status::Ambiguous },
            scale: None,
        };
        let truth = (0..off_m.len()).map(|i| (at(i), PlanPose::new(i as f64, 0.0, 0.0))).collect();
        (off_m.iter().enumerate().map(estimate).collect(), truth)
    }

    pub fn scored(off_m: &[f64], sigma_m: f64) -> PlaceScores {
        let (track, truth) = walk(off_m, sigma_m);
        score(&track, &track, &truth, &PlaceOptions::default()).unwrap()
    }

    #[test]
    fn recall_counts_moments_and_metres() {
        let recall = &scored(&[3.0, 0.8, 0.4, 0.3], 0.5).track.recall;
        let of: Vec<_> = recall.iter().map(|r| (r.within_m, r.of_moments)).collect();
        assert_eq!(of, [(0.5, 0.5), (1.0, 0.75), (2.0, 0.75)]);
        // Half a metre belongs to the first moment and to the last one.
        assert!((recall[0].of_distance - 1.5 / 3.0).abs() < 1e-12 && (recall[1].of_distance - 2.5 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn regions_of_a_gaussian_error_are_honest() {
        // Quantiles of the normal error of one axis, in both axes, by a grid: the Gaussian itself without chance.
        let n = 60;
        let step = |i: usize| (i as f64 + 0.5) / n as f64;
        let (mut track, mut truth) = (Vec::new(), Vec::new());
        for i in 0..n * n {
            let (radius, angle) = ((-2.0 * (1.0 - step(i / n)).ln()).sqrt(), std::f64::consts::TAU * step(i % n));
            let (off, _) = walk(&[0.0], 1.0);
            let stamp = Stamp(i as i64);
            let pose = PlanPose::new(radius * angle.cos(), radius * angle.sin(), 0.0);
            track.push(Estimate { stamp, pose, ..off[0].clone() });
            truth.push((stamp, PlanPose::new(0.0, 0.0, 0.0)));
        }
        let calibration = score(&track, &[], &truth, &PlaceOptions::default()).unwrap().track.calibration.unwrap();
        for region in &calibration.regions {
            // The grid has 60 radii.
            assert!((region.empirical - region.nominal).abs() < 1.0 / n as f64, "{region:?}");
        }
        // E d² = 2; the grid misses the tail beyond its last radius.
        assert!((calibration.nees_position.unwrap() - 2.0).abs() < 0.05, "{calibration:?}");
    }

    #[test]
    fn no_covariance_is_no_claim_and_a_collapsed_one_is_a_false_one() {
        let (mut track, truth) = walk(&[0.1, 0.1, 0.1], 0.5);
        track[1].covariance = Matrix3::zeros();
        let one = score(&track, &[], &truth, &PlaceOptions::default()).unwrap().track.calibration.unwrap();
        assert_eq!((one.without_region, one.regions[2].empirical), (1, 2.0 / 3.0));
        // The collapsed one did not claim to be tracking.
        let tracking = score(&track, &[], &truth, &PlaceOptions::default()).unwrap().track.calibration_tracking.unwrap();
        assert_eq!((tracking.without_region, tracking.regions[2].empirical), (0, 1.0));
        for estimate in &mut track {
            estimate.covariance = Matrix3::zeros();
        }
        assert_eq!(score(&track, &[], &truth, &PlaceOptions::default()).unwrap().track.calibration, None);
    }

    #[test]
    fn a_truth_without_headings_gives_no_heading_errors() {
        let (track, truth) = walk(&[0.1, 0.1, 0.1], 0.5);
        let options = PlaceOptions { truth_faces: false, ..PlaceOptions::default() };
        let scores = score(&track, &[], &truth, &options).unwrap();
        assert_eq!((scores.track.heading_median_rad, scores.filter), (None, None));
        assert_eq!(scores.track.calibration.unwrap().nees_pose, None);
    }

    #[test]
    fn listed_places_are_held_against_the_true_end() {
        let (track, truth) = walk(&[0.1, 0.1, 0.1], 0.5);
        let places = [(0.7, PlanPose::new(9.0, 0.0, 0.0)), (0.2, PlanPose::new(2.0, 0.6, 0.0))];
        let end = track[2].stamp;
        let found = hypotheses(&places, end, &truth, &PlaceOptions::default()).unwrap();
        assert_eq!((found.held, found.held_right), (2, true), "a fifth is enough");
        assert!(found.any_right && (found.nearest_m - 0.6).abs() < 1e-12 && (found.probability_right - 0.2).abs() < 1e-12);
        assert_eq!(hypotheses(&places, Stamp(9_000_000_000), &truth, &PlaceOptions::default()), None);
        assert_eq!(hypotheses(&[], end, &truth, &PlaceOptions::default()), None);
    }
}
