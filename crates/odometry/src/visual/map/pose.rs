//! Where is this frame, given the landmarks? Perspective-n-point by robust least squares from a predicted pose.
//!
//! Each landmark's own uncertainty of distance widens its residual along its epipolar line: one with a vague distance still
//! measures the rotation, and the translation across the line. The prediction is a prior, so that a view with too little in
//! it (a blank wall, a person before the lens) moves on instead of breaking.

use nalgebra::{Matrix2, Matrix6, UnitQuaternion, Vector3, Vector6};

use super::{Pose, Residual, direction};
use crate::visual::axes::Fix;
use crate::visual::two_view::rotation::median;

/// A landmark as seen now.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    /// Pose of its anchor keyframe.
    pub anchor: Pose,
    /// Its unit ray there.
    pub ray: Vector3<f64>,
    /// Inverse distance.
    pub rho: f64,
    /// Standard deviation of it.
    pub sigma_rho: f64,
    /// Its unit ray now.
    pub seen: Vector3<f64>,
}

/// What is known of the pose before anything is seen.
#[derive(Debug, Clone, Copy)]
pub struct PosePrior {
    /// The predicted pose.
    pub pose: Pose,
    /// Standard deviation of each coordinate of the position, units.
    pub sigma_move: f64,
    /// Standard deviation of each component of the rotation, radians.
    pub sigma_turn_rad: f64,
    /// What the building's edges say of the rotation.
    pub fix: Option<Fix>,
}

/// The pose that explains most.
#[derive(Debug, Clone)]
pub struct PoseFit {
    /// `odom ← camera`.
    pub pose: Pose,
    /// Covariance of (turn in the camera frame, position in odom).
    pub covariance: Matrix6<f64>,
    /// Squared Mahalanobis distance of each sight (2 degrees of freedom); infinite for one behind the camera.
    pub squared: Vec<f64>,
}

/// Squared Mahalanobis distance up to which a sight agrees: 99.9 % of a 2-degree chi-square.
pub const AGREES: f64 = 13.8;

/// Standard deviations of the prior by which the rotation may differ from it, or from what the edges say.
const MOST_TURN: f64 = 5.0;

/// Robust Gauss–Newton (Geman–McClure, annealed) from the prior's pose. `sigma_rad` is the noise of a ray.
pub fn solve(sights: &[Sight], prior: &PosePrior, sigma_rad: f64) -> PoseFit {
    let mut pose = prior.pose;
    let mut covariance = prior_information(prior).try_inverse().unwrap_or_else(Matrix6::identity);
    for iteration in 0..12 {
        let weighed: Vec<_> = sights.iter().map(|s| (s, weigh(s, &pose, sigma_rad))).collect();
        let squares = weighed.iter().filter_map(|(_, w)| w.as_ref()).map(|(r, w)| (r.error.transpose() * w * r.error).x);
        // The kernel follows the median: wide while the prediction's error is in all of them, 2.5 σ at the end.
        let kernel = (2.0 * median(squares.collect())).max(2.5f64.powi(2));
        let (mut normal, mut gradient) = prior_terms(&pose, prior);
        for (sight, weighed) in weighed {
            let Some((residual, weight)) = weighed else { continue };
            let squared = (residual.error.transpose() * weight * residual.error).x;
            let robust = (kernel / (kernel + squared)).powi(2);
            let (turn, shift) = (residual.by_turn(), residual.by_move(&pose.rotation, sight.rho));
            let mut jacobian = nalgebra::Matrix2x6::zeros();
            jacobian.fixed_view_mut::<2, 3>(0, 0).copy_from(&turn);
            jacobian.fixed_view_mut::<2, 3>(0, 3).copy_from(&shift);
            let weighted = jacobian.transpose() * weight * robust;
            normal += weighted * jacobian;
            gradient += weighted * residual.error;
        }
        let Some(factor) = normal.cholesky() else { break };
        let step = -factor.solve(&gradient);
        covariance = factor.inverse();
        pose = moved(&pose, &step);
        if step.norm() < 1e-7 && iteration > 5 {
            break;
        }
    }
    if !plausible(&pose, prior) {
        (pose, covariance) = (prior.pose, prior_information(prior).try_inverse().unwrap_or_else(Matrix6::identity));
    }
    let squared =
        sights.iter().map(|s| weigh(s, &pose, sigma_rad).map_or(f64::INFINITY, |(r, w)| (r.error.transpose() * w * r.error).x)).collect();
    PoseFit { pose, covariance, squared }
}

/// Whether a head turns so: a single point that slipped, on a hand before the lens, explains itself by any turn.
fn plausible(pose: &Pose, prior: &PosePrior) -> bool {
    let starts = [Some(prior.pose.rotation), prior.fix.map(|fix| fix.rotation)];
    starts.iter().flatten().any(|start| start.angle_to(&pose.rotation) < MOST_TURN * prior.sigma_turn_rad)
}

/// The pose after a step (turn on the right, move in odom).
pub(in crate::visual) fn moved(pose: &Pose, step: &Vector6<f64>) -> Pose {
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(step[0], step[1], step[2]));
    let mut rotation = pose.rotation * turn;
    rotation.renormalize_fast();
    Pose::from_parts((pose.translation.vector + Vector3::new(step[3], step[4], step[5])).into(), rotation)
}

/// The step of [`moved`] from one pose to another.
pub(in crate::visual) fn difference(from: &Pose, to: &Pose) -> Vector6<f64> {
    let turn = (from.rotation.inverse() * to.rotation).scaled_axis();
    let way = to.translation.vector - from.translation.vector;
    Vector6::new(turn.x, turn.y, turn.z, way.x, way.y, way.z)
}

/// Residual and inverse covariance of a sight: ray noise, and the distance's uncertainty along the epipolar line.
fn weigh(sight: &Sight, pose: &Pose, sigma_rad: f64) -> Option<(Residual, Matrix2<f64>)> {
    let residual = Residual::new(direction(&sight.anchor, &sight.ray, sight.rho, pose), &sight.seen)?;
    let along = residual.by_rho(&sight.anchor, pose) * sight.sigma_rho;
    let covariance = Matrix2::identity() * (sigma_rad * sigma_rad) + along * along.transpose();
    Some((residual, covariance.try_inverse()?))
}

fn prior_information(prior: &PosePrior) -> Matrix6<f64> {
    let (turn, shift) = (prior.sigma_turn_rad.powi(-2), prior.sigma_move.powi(-2));
    Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift))
}

fn prior_terms(pose: &Pose, prior: &PosePrior) -> (Matrix6<f64>, Vector6<f64>) {
    let mut information = prior_information(prior);
    let mut gradient = information * difference(&prior.pose, pose);
    if let Some(fix) = &prior.fix {
        let mut block = information.fixed_view_mut::<3, 3>(0, 0);
        block += fix.information;
        let mut pull = gradient.fixed_rows_mut::<3>(0);
        pull += fix.information * fix.error(&pose.rotation);
    }
    (information, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene::uniform;
    use planwalk_types::Seed;

    fn sights(seed: u64, truth: &Pose, count: usize, wild: usize, noise_rad: f64, known: bool) -> Vec<Sight> {
        let mut rng = Seed(seed).derive("sights", 0);
        let anchor = Pose::identity();
        let sight = |i: usize| {
            let distance = uniform(&mut rng, 2.0, 8.0);
            let ray = Vector3::new(uniform(&mut rng, -0.6, 0.6), uniform(&mut rng, -0.4, 0.4), 1.0).normalize();
            let exact = direction(&anchor, &ray, 1.0 / distance, truth).normalize();
            let off = if i < wild { 0.2 } else { noise_rad };
            let seen = (exact + Vector3::from_fn(|_, _| uniform(&mut rng, -1.7, 1.7) * off)).normalize();
            let (rho, sigma_rho) = if known { (1.0 / distance, 0.01 / distance) } else { (0.25, 0.25) };
            Sight { anchor, ray, rho, sigma_rho, seen }
        };
        (0..count).map(sight).collect()
    }

    fn prior() -> PosePrior {
        PosePrior { pose: Pose::identity(), sigma_move: 0.5, sigma_turn_rad: 0.3, fix: None }
    }

    fn truth() -> Pose {
        Pose::from_parts(Vector3::new(0.1, 0.02, 0.25).into(), UnitQuaternion::from_scaled_axis(Vector3::new(0.02, 0.08, -0.01)))
    }

    #[test]
    fn known_landmarks_give_the_pose_though_a_third_of_them_move() {
        for seed in 0..10 {
            let fit = solve(&sights(seed, &truth(), 120, 40, 1e-3, true), &prior(), 1e-3);
            // 1 mrad over 80 points 5 units away, and 1 % of distance: millimetres and tenths of a milliradian, times 4.
            assert!((fit.pose.translation.vector - truth().translation.vector).norm() < 0.02, "seed {seed}: {}", fit.pose);
            assert!(fit.pose.rotation.angle_to(&truth().rotation) < 2e-3, "seed {seed}: {}", fit.pose);
            assert!(fit.squared[40..].iter().filter(|s| **s < AGREES).count() > 70, "seed {seed}");
        }
    }

    #[test]
    fn landmarks_without_distance_still_give_the_rotation() {
        let turned = Pose::from_parts(Vector3::zeros().into(), truth().rotation);
        let fit = solve(&sights(3, &turned, 80, 0, 1e-3, false), &prior(), 1e-3);
        assert!(fit.pose.rotation.angle_to(&turned.rotation) < 3e-3, "{}", fit.pose);
    }

    #[test]
    fn points_that_slipped_on_a_hand_before_the_lens_turn_nobody() {
        for seed in 0..20 {
            // One to three points, anywhere but where they were.
            let wild = 1 + seed as usize % 3;
            let fit = solve(&sights(seed, &Pose::identity(), wild, wild, 0.0, true), &PosePrior { sigma_turn_rad: 0.1, ..prior() }, 2e-3);
            assert!(fit.pose.rotation.angle() < 0.5, "seed {seed}: turned by {} rad", fit.pose.rotation.angle());
        }
    }

    #[test]
    fn a_fix_holds_the_rotation_where_nothing_is_seen_and_only_about_its_axes() {
        let told = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.1, 0.0));
        let information = nalgebra::Matrix3::from_diagonal(&Vector3::new(1e6, 0.0, 0.0));
        let fix = Fix { rotation: told, information, edges: 9, upright: 3, heading: false };
        let fit = solve(&[], &PosePrior { fix: Some(fix), ..prior() }, 1e-3);
        let turned = fit.pose.rotation.scaled_axis();
        // Sure to a milliradian about x against a prediction of 0.3 rad; nothing is said of y, but that turns do not commute.
        assert!((turned.x - 0.1).abs() < 1e-3 && turned.y.abs() < 0.01, "{turned}");
    }

    #[test]
    fn nothing_seen_leaves_the_prediction_and_its_uncertainty() {
        let fit = solve(&[], &prior(), 1e-3);
        assert_eq!(fit.pose, Pose::identity());
        assert!((fit.covariance[(3, 3)].sqrt() - 0.5).abs() < 1e-9 && (fit.covariance[(0, 0)].sqrt() - 0.3).abs() < 1e-9);
    }
}
