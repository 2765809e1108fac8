//! How good is an odometry? Absolute and relative errors after alignment, as evo computes them, and drift by path length.
//!
//! ATE: distance of aligned positions. RPE: what goes wrong from one pose to the next, by frame and by metre
//! (Sturm et al. 2012). Drift: the same over stretches of 5, 10, 20, … metres, in per cent (Geiger, Lenz & Urtasun 2012).

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use planwalk_types::{Rigid3, Stamp};
use serde::{Deserialize, Serialize};

use super::align::{Alignment, align};
use super::associate::{AssociateOptions, associate};
use super::statistics::{Summary, mean};
use super::{EvaluateError, Match};

/// Options of [`score`].
#[derive(Debug, Clone, PartialEq)]
pub struct OdometryScoreOptions {
    /// How moments are brought together.
    pub associate: AssociateOptions,
    /// Whether the truth says where the body faced; without, only positions are scored.
    pub truth_faces: bool,
    /// Path length of the estimate from pose to pose of the relative error, in the truth's unit. The default is 1 m.
    pub delta_m: f64,
    /// Lengths of the stretches over which drift is measured, metres along the truth.
    pub drift_lengths_m: Vec<f64>,
}

impl Default for OdometryScoreOptions {
    /// Lengths from a room to a drive through a town; those longer than the walk are left out.
    fn default() -> Self {
        let drift_lengths_m = vec![5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 400.0, 800.0];
        Self { associate: AssociateOptions::default(), truth_faces: true, delta_m: 1.0, drift_lengths_m }
    }
}

/// Scores of an odometry. Lengths in the truth's unit (metres), angles in degrees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OdometryScores {
    /// What was free.
    pub alignment: Alignment,
    /// Moments compared.
    pub compared: usize,
    /// Seconds from the first to the last compared moment.
    pub duration_s: f64,
    /// Length of the true path through the compared moments, metres.
    pub length_m: f64,
    /// Share of the truth's time that the estimate covers; gaps of more than five usual steps between compared moments do not count.
    pub posed_share: f64,
    /// Truth's unit per unit of the estimate, 1 where the scale was not free.
    pub scale: f64,
    /// Absolute error of position (ATE), metres.
    pub ate_m: Summary,
    /// Its root mean square as a share of the true path, per cent; `None` when nobody moved.
    pub ate_percent: Option<f64>,
    /// Absolute error of rotation, degrees; `None` when the truth does not say where the body faced.
    pub rotation_deg: Option<Summary>,
    /// Relative error from frame to frame.
    pub rpe_frame: Option<RelativeError>,
    /// Relative error from metre to metre.
    pub rpe_metre: Option<RelativeError>,
    /// Drift over stretches.
    pub drift: Vec<Drift>,
}

/// Relative error of consecutive pairs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RelativeError {
    /// Pairs.
    pub pairs: usize,
    /// Metres a pair.
    pub translation_m: Summary,
    /// Degrees a pair.
    pub rotation_deg: Summary,
}

/// Mean drift over all stretches of one length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    /// Length of the stretches, metres.
    pub length_m: f64,
    /// How many there were.
    pub stretches: usize,
    /// Error of position as a share of the length, per cent.
    pub translation_percent: f64,
    /// Error of rotation, degrees a metre.
    pub rotation_deg_per_m: f64,
}

/// A pose of the estimate, aligned, and the true one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignedPair {
    /// The estimate's own stamp.
    pub stamp: Stamp,
    /// The estimate in the truth's frame.
    pub estimate: Isometry3<f64>,
    /// The truth.
    pub truth: Isometry3<f64>,
}

/// Pairs in one frame, and the scale that it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Aligned {
    /// In time order.
    pub pairs: Vec<AlignedPair>,
    /// Truth's unit per unit of the estimate.
    pub scale: f64,
}

/// Scores an odometry whose frame is its own. Both must be poses of the same thing (body, or camera).
///
/// # Errors
/// [`EvaluateError`]: nothing in common, numbers that are none, positions that define no alignment.
pub fn score<A, B, T>(
    estimate: &[(Stamp, Rigid3<A, B>)],
    truth: &[(Stamp, Rigid3<T, B>)],
    alignment: Alignment,
    options: &OdometryScoreOptions,
) -> Result<OdometryScores, EvaluateError> {
    if !(options.delta_m > 0.0) {
        return Err(EvaluateError::BadOption { name: "delta", value: options.delta_m, must: "it must be a length above 0" });
    }
    let aligned = pairs(estimate, truth, alignment, &options.associate)?;
    let pairs = &aligned.pairs;
    let errors: Vec<f64> = pairs.iter().map(|p| (p.estimate.translation.vector - p.truth.translation.vector).norm()).collect();
    // Pairs there are: association would have refused fewer than two.
    let too_few = EvaluateError::TooFewPoses { what: "track", got: 0 };
    let (Some(ate_m), Some(first), Some(last)) = (Summary::of(&errors), pairs.first(), pairs.last()) else { return Err(too_few) };
    let length_m = path(pairs, |p| &p.truth).last().copied().unwrap_or(0.0);
    let faces = options.truth_faces;
    let rotations: Vec<f64> = pairs.iter().map(|p| p.estimate.rotation.angle_to(&p.truth.rotation).to_degrees()).collect();
    let by_frame: Vec<(usize, usize)> = (1..pairs.len()).map(|i| (i - 1, i)).collect();
    Ok(OdometryScores {
        alignment,
        compared: pairs.len(),
        duration_s: last.stamp.secs_since(first.stamp),
        length_m,
        posed_share: posed_share(pairs, truth),
        scale: aligned.scale,
        ate_m,
        ate_percent: (length_m > 0.0).then(|| 100.0 * ate_m.rmse / length_m),
        rotation_deg: if faces { Summary::of(&rotations) } else { None },
        rpe_frame: if faces { relative(pairs, &by_frame) } else { None },
        rpe_metre: if faces { relative(pairs, &by_path(pairs, options.delta_m)) } else { None },
        drift: if faces { drift(pairs, &options.drift_lengths_m) } else { Vec::new() },
    })
}

/// Brings both together and the estimate into the truth's frame.
///
/// # Errors
/// As [`score`].
pub fn pairs<A, B, T>(
    estimate: &[(Stamp, Rigid3<A, B>)],
    truth: &[(Stamp, Rigid3<T, B>)],
    alignment: Alignment,
    options: &AssociateOptions,
) -> Result<Aligned, EvaluateError> {
    check_finite("track", estimate)?;
    check_finite("truth", truth)?;
    let of_estimate: Vec<Stamp> = estimate.iter().map(|(stamp, _)| *stamp).collect();
    let of_truth: Vec<Stamp> = truth.iter().map(|(stamp, _)| *stamp).collect();
    // Three positions are the least that can disagree with an alignment.
    let need = if alignment == Alignment::None { 2 } else { 3 };
    let matches = associate(&of_estimate, &of_truth, options, need)?;
    let flat = |pose: Isometry3<f64>| if alignment.planar() { on_floor(&pose) } else { pose };
    let pair = |m: &Match| {
        let (stamp, pose) = &estimate[m.estimate];
        AlignedPair { stamp: *stamp, estimate: flat(pose.iso), truth: flat(m.in_space(truth).iso) }
    };
    let mut pairs: Vec<AlignedPair> = matches.iter().map(pair).collect();
    let at = |of: &dyn Fn(&AlignedPair) -> Vector3<f64>| pairs.iter().map(of).collect::<Vec<_>>();
    let truth_from_estimate = align(&at(&|p| p.estimate.translation.vector), &at(&|p| p.truth.translation.vector), alignment)?;
    for pair in &mut pairs {
        pair.estimate = truth_from_estimate.apply(&pair.estimate);
    }
    Ok(Aligned { pairs, scale: truth_from_estimate.scale })
}

fn check_finite<A, B>(what: &'static str, poses: &[(Stamp, Rigid3<A, B>)]) -> Result<(), EvaluateError> {
    let finite = |pose: &Rigid3<A, B>| pose.iso.translation.vector.iter().chain(pose.iso.rotation.coords.iter()).all(|v| v.is_finite());
    match poses.iter().position(|(_, pose)| !finite(pose)) {
        Some(index) => Err(EvaluateError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// The pose's shadow on the floor, facing where its x axis points.
fn on_floor(pose: &Isometry3<f64>) -> Isometry3<f64> {
    let (at, ahead) = (pose.translation.vector, pose.rotation * Vector3::x());
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), ahead.y.atan2(ahead.x));
    Isometry3::from_parts(Vector3::new(at.x, at.y, 0.0).into(), turn)
}

/// Share of the truth's time between compared moments that lie no more than a few usual steps apart: the pairs' steps, or the
/// truth's where those are longer (stamps may come in bursts).
fn posed_share<T>(pairs: &[AlignedPair], truth: &[(Stamp, T)]) -> f64 {
    let steps: Vec<f64> = pairs.windows(2).map(|w| w[1].stamp.secs_since(w[0].stamp)).collect();
    let of_truth: Vec<f64> = truth.windows(2).map(|w| w[1].0.secs_since(w[0].0)).collect();
    let usual = |steps: &[f64]| super::statistics::quantile(steps, 0.5).unwrap_or(0.0);
    let usual_s = usual(&steps).max(usual(&of_truth));
    let covered_s: f64 = steps.iter().filter(|s| **s <= 5.0 * usual_s).sum();
    let whole_s = truth.first().zip(truth.last()).map_or(0.0, |(a, b)| b.0.secs_since(a.0));
    if whole_s > 0.0 { (covered_s / whole_s).min(1.0) } else { 0.0 }
}

/// Length of the path up to each pose.
fn path(pairs: &[AlignedPair], of: impl Fn(&AlignedPair) -> &Isometry3<f64>) -> Vec<f64> {
    let mut sum = 0.0;
    let mut lengths = Vec::with_capacity(pairs.len());
    for (i, pair) in pairs.iter().enumerate() {
        if i > 0 {
            sum += (of(pair).translation.vector - of(&pairs[i - 1]).translation.vector).norm();
        }
        lengths.push(sum);
    }
    lengths
}

/// Consecutive pairs that are `delta_m` apart along the *estimate*, as evo takes them (`-d 1 -u m`).
fn by_path(pairs: &[AlignedPair], delta_m: f64) -> Vec<(usize, usize)> {
    let (mut ids, mut walked) = (vec![0], 0.0);
    for i in 1..pairs.len() {
        walked += (pairs[i].estimate.translation.vector - pairs[i - 1].estimate.translation.vector).norm();
        if walked >= delta_m {
            ids.push(i);
            walked = 0.0;
        }
    }
    ids.windows(2).map(|w| (w[0], w[1])).collect()
}

/// What the estimate's motion from pose i to pose j does beyond the true one.
fn motion_error(pairs: &[AlignedPair], (i, j): (usize, usize)) -> Isometry3<f64> {
    let moved = |a: &Isometry3<f64>, b: &Isometry3<f64>| a.inverse() * b;
    moved(&pairs[i].truth, &pairs[j].truth).inverse() * moved(&pairs[i].estimate, &pairs[j].estimate)
}

fn relative(pairs: &[AlignedPair], ids: &[(usize, usize)]) -> Option<RelativeError> {
    let errors: Vec<Isometry3<f64>> = ids.iter().map(|ij| motion_error(pairs, *ij)).collect();
    let translations: Vec<f64> = errors.iter().map(|e| e.translation.vector.norm()).collect();
    let rotations: Vec<f64> = errors.iter().map(|e| e.rotation.angle().to_degrees()).collect();
    Some(RelativeError { pairs: ids.len(), translation_m: Summary::of(&translations)?, rotation_deg: Summary::of(&rotations)? })
}

/// Stretches begin a metre apart, whatever the rate of the poses.
const DRIFT_EVERY_M: f64 = 1.0;

fn drift(pairs: &[AlignedPair], lengths_m: &[f64]) -> Vec<Drift> {
    let walked = path(pairs, |p| &p.truth);
    let whole = walked.last().copied().unwrap_or(0.0);
    let starts = (0..).map(|i| DRIFT_EVERY_M * f64::from(i)).take_while(|at| *at < whole);
    let starts: Vec<usize> = starts.map(|at| walked.partition_point(|w| *w < at)).collect();
    let of_length = |length_m: f64| {
        let end = |from: usize| {
            let to = walked.partition_point(|w| *w < walked[from] + length_m);
            (to < walked.len() && to > from).then_some((from, to))
        };
        let errors: Vec<Isometry3<f64>> = starts.iter().filter_map(|from| end(*from)).map(|ij| motion_error(pairs, ij)).collect();
        let translations: Vec<f64> = errors.iter().map(|e| e.translation.vector.norm() / length_m).collect();
        let rotations: Vec<f64> = errors.iter().map(|e| e.rotation.angle().to_degrees() / length_m).collect();
        let translation_percent = 100.0 * mean(&translations)?;
        Some(Drift { length_m, stretches: errors.len(), translation_percent, rotation_deg_per_m: mean(&rotations)? })
    };
    lengths_m.iter().filter(|length| **length > 0.0).filter_map(|length| of_length(*length)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Body, Odom, Plan};

    fn walk<A>(scale: f64, drift_rad_per_m: f64) -> Vec<(Stamp, Rigid3<A, Body>)> {
        let (mut at, mut heading, mut poses) = (Vector3::zeros(), 0.0f64, Vec::new());
        for i in 0..200 {
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading);
            poses.push((Stamp(i * 100_000_000), Rigid3::from_parts(at, turn)));
            at += scale * 0.1 * (turn * Vector3::x());
            heading += 0.1 * drift_rad_per_m + if (80..100).contains(&i) { 0.08 } else { 0.0 };
        }
        poses
    }

    #[test]
    fn a_walk_of_another_unit_is_exact_once_scaled() {
        let truth = walk::<Plan>(1.0, 0.0);
        let scores = score(&walk::<Odom>(0.25, 0.0), &truth, Alignment::Sim2, &OdometryScoreOptions::default()).unwrap();
        // Round-off over 20 m.
        assert!((scores.scale - 4.0).abs() < 1e-9 && scores.ate_m.max < 1e-9, "{scores:?}");
        assert!((scores.length_m - 19.9).abs() < 1e-9 && (scores.posed_share - 1.0).abs() < 1e-9);
        assert_eq!(scores.drift.iter().map(|d| d.length_m).collect::<Vec<_>>(), [5.0, 10.0]);
    }

    #[test]
    fn a_heading_that_drifts_shows_in_drift_by_the_metre() {
        let truth = walk::<Plan>(1.0, 0.0);
        let scores = score(&walk::<Odom>(1.0, 0.01), &truth, Alignment::Se2, &OdometryScoreOptions::default()).unwrap();
        let degrees = 0.01f64.to_degrees();
        for drift in &scores.drift {
            // A stretch is cut at whole steps of 0.1 m.
            assert!((drift.rotation_deg_per_m - degrees).abs() < 0.03 * degrees, "{drift:?}");
        }
        let metre = scores.rpe_metre.unwrap();
        assert!((metre.rotation_deg.mean - degrees).abs() < 0.1 * degrees + 1e-9, "{metre:?}");
    }

    #[test]
    fn without_headings_only_positions_are_scored() {
        let options = OdometryScoreOptions { truth_faces: false, ..OdometryScoreOptions::default() };
        let scores = score(&walk::<Odom>(1.0, 0.0), &walk::<Plan>(1.0, 0.0), Alignment::Se2, &options).unwrap();
        assert!(scores.rotation_deg.is_none() && scores.rpe_frame.is_none() && scores.drift.is_empty());
    }

    #[test]
    fn a_gap_in_the_odometry_is_not_posed() {
        let mut estimate = walk::<Odom>(1.0, 0.0);
        estimate.drain(50..150);
        let scores = score(&estimate, &walk::<Plan>(1.0, 0.0), Alignment::Se2, &OdometryScoreOptions::default()).unwrap();
        assert!((scores.posed_share - 0.492).abs() < 0.01, "{}", scores.posed_share);
    }

    #[test]
    fn a_pose_that_is_no_number_is_named() {
        let mut estimate = walk::<Odom>(1.0, 0.0);
        estimate[7].1.iso.translation.vector.y = f64::NAN;
        let why = score(&estimate, &walk::<Plan>(1.0, 0.0), Alignment::None, &OdometryScoreOptions::default()).unwrap_err();
        assert_eq!(why, EvaluateError::NotFinite { what: "track", index: 7 });
    }
}
