//! How did the body move on the floor, step by step?
//!
//! Any source will do: a camera, a phone's step counter, wheels. The unit of length is the odometry's own.

use nalgebra::{Matrix3, Vector3};

use crate::rigid::{Rigid2, Rigid3};
use crate::space::{Body, Odom};
use crate::time::Stamp;

/// What is known beforehand of the metres in one unit of odometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OdometryScale {
    /// One unit is one metre, up to a small calibration error.
    Metric,
    /// A single camera: the unit says nothing by itself.
    Unknown,
    /// One unit is one metre up to this relative standard deviation.
    Relative(f64),
}

/// A motion of the body between two moments, seen from where it started.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Start.
    pub from: Stamp,
    /// End; later than the start.
    pub to: Stamp,
    /// Metres-to-be ahead, in the odometry's unit.
    pub forward: f64,
    /// To the left, same unit.
    pub left: f64,
    /// Anticlockwise, radians.
    pub turn_rad: f64,
    /// Covariance of (forward, left, turn): unit², unit·rad, rad².
    pub covariance: Matrix3<f64>,
    /// How much the unit of length itself may have changed during the step, for good: standard deviation of its logarithm.
    /// Zero for wheels; a single camera loses its unit while it sees nothing whose distance it knows.
    pub unit_change: f64,
}

impl Step {
    /// The step as a transform: `start ← end`, both the body's.
    pub fn start_from_end(&self) -> Rigid2<Body, Body> {
        Rigid2::new(self.forward, self.left, self.turn_rad)
    }

    /// Length on the floor, in the odometry's unit.
    pub fn length(&self) -> f64 {
        self.forward.hypot(self.left)
    }
}

/// A walk as consecutive steps: each begins when the one before ended.
#[derive(Debug, Clone, Default)]
pub struct Path {
    /// The steps in time order.
    pub steps: Vec<Step>,
}

impl Path {
    /// Length on the floor, in the odometry's unit.
    pub fn length(&self) -> f64 {
        self.steps.iter().map(Step::length).sum()
    }

    /// The moments of the path: the start of the first step, then the end of each.
    pub fn stamps(&self) -> impl Iterator<Item = Stamp> + '_ {
        self.steps.first().map(|s| s.from).into_iter().chain(self.steps.iter().map(|s| s.to))
    }

    /// Poses `start ← body` at [`Path::stamps`], the first one identity.
    pub fn poses(&self) -> Vec<Rigid2<Odom, Body>> {
        let mut poses = Vec::with_capacity(self.steps.len() + 1);
        let mut pose = Rigid2::identity();
        poses.push(pose);
        for step in &self.steps {
            pose = pose * step.start_from_end();
            poses.push(pose);
        }
        poses
    }
}

/// Why poses make no trajectory.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// Fewer than two poses.
    #[error("{got} poses, but a trajectory needs at least 2")]
    TooFewPoses {
        /// How many there are.
        got: usize,
    },
    /// A stamp does not come after the one before.
    #[error("stamps go back: pose {index} at {at_s:.6} s comes after {before_s:.6} s; sort the poses by time and drop repeated ones")]
    StampsGoBack {
        /// Which pose, counted from 0.
        index: usize,
        /// Its stamp, seconds.
        at_s: f64,
        /// The stamp before, seconds.
        before_s: f64,
    },
    /// A coordinate is not a finite number.
    #[error("pose {index} is not finite")]
    NotFinite {
        /// Which pose, counted from 0.
        index: usize,
    },
}

/// Timed poses `odom ← body` in space: strictly increasing stamps, finite, at least two.
#[derive(Debug, Clone)]
pub struct Trajectory<B = Body> {
    poses: Vec<(Stamp, Rigid3<Odom, B>)>,
}

impl<B> Trajectory<B> {
    /// Checks and keeps the poses.
    ///
    /// # Errors
    /// [`TrajectoryError`] names the first pose that breaks a rule.
    pub fn new(poses: Vec<(Stamp, Rigid3<Odom, B>)>) -> Result<Self, TrajectoryError> {
        if poses.len() < 2 {
            return Err(TrajectoryError::TooFewPoses { got: poses.len() });
        }
        for (index, (_, pose)) in poses.iter().enumerate() {
            let finite = pose.iso.translation.vector.iter().chain(pose.iso.rotation.coords.iter()).all(|c| c.is_finite());
            if !finite {
                return Err(TrajectoryError::NotFinite { index });
            }
        }
        for (index, pair) in poses.windows(2).enumerate() {
            if pair[1].0 <= pair[0].0 {
                let (at_s, before_s) = (pair[1].0.as_secs(), pair[0].0.as_secs());
                return Err(TrajectoryError::StampsGoBack { index: index + 1, at_s, before_s });
            }
        }
        Ok(Self { poses })
    }

    /// The poses in time order.
    pub fn poses(&self) -> &[(Stamp, Rigid3<Odom, B>)] {
        &self.poses
    }
}

impl Trajectory<Body> {
    /// The trajectory on the floor as a path. Roll and pitch are dropped; noise is `noise` per step.
    ///
    /// Heading is the direction of the body's x axis on the floor; where that axis is vertical, the heading before it is kept.
    pub fn to_path(&self, noise: &StepNoise) -> Path {
        let mut heading_rad = 0.0;
        let mut flat = Vec::with_capacity(self.poses.len());
        for (stamp, pose) in &self.poses {
            let ahead = pose.iso.rotation * Vector3::x();
            if ahead.x.hypot(ahead.y) > 1e-6 {
                heading_rad = libm::atan2(ahead.y, ahead.x);
            }
            let at = pose.iso.translation.vector;
            flat.push((*stamp, Rigid2::<Odom, Body>::new(at.x, at.y, heading_rad)));
        }
        let steps = flat
            .windows(2)
            .map(|pair| {
                let start_from_end = pair[0].1.inverse() * pair[1].1;
                noise.step(pair[0].0, pair[1].0, start_from_end.x, start_from_end.y, start_from_end.heading_rad)
            })
            .collect();
        Path { steps }
    }
}

/// How noisy steps from a source without covariance are taken to be (Thrun, Burgard & Fox 2005, §5.4, as standard deviations).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepNoise {
    /// Standard deviation of a step's length, as a share of it.
    pub length_relative: f64,
    /// Heading noise from moving: radians per √unit walked.
    pub turn_per_sqrt_unit_rad: f64,
    /// Heading noise from turning, as a share of the turn.
    pub turn_relative: f64,
}

impl Default for StepNoise {
    /// Walking phones and robots' wheels: 5 % of length, 2°/√m (the Intel robot's are off by 2.2, drift taken off), 3 % of a turn.
    fn default() -> Self {
        Self { length_relative: 0.05, turn_per_sqrt_unit_rad: 2f64.to_radians(), turn_relative: 0.03 }
    }
}

impl StepNoise {
    /// The step with this motion and the covariance that the noise gives it.
    pub fn step(&self, from: Stamp, to: Stamp, forward: f64, left: f64, turn_rad: f64) -> Step {
        let length = forward.hypot(left);
        let along = (self.length_relative * length).powi(2);
        let turn = self.turn_per_sqrt_unit_rad.powi(2) * length + (self.turn_relative * turn_rad).powi(2);
        Step { from, to, forward, left, turn_rad, covariance: Matrix3::from_diagonal(&Vector3::new(along, along, turn)), unit_change: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    fn pose(x: f64, y: f64, yaw: f64) -> Rigid3<Odom, Body> {
        Rigid3::from_parts(Vector3::new(x, y, 1.4), UnitQuaternion::from_euler_angles(0.1, -0.2, yaw))
    }

    #[test]
    fn a_path_retraces_its_trajectory() {
        let truth = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.3), (1.5, 0.8, 1.6), (1.5, 0.8, -3.0)];
        let poses = truth.iter().zip(0..).map(|(&(x, y, h), i)| (Stamp(i * 1_000_000_000), pose(x, y, h))).collect();
        let path = Trajectory::new(poses).unwrap().to_path(&StepNoise::default());
        for (pose, (x, y, h)) in path.poses().iter().zip(truth) {
            assert!(pose.origin().distance(crate::Pt2::new(x, y)) < 1e-12, "{pose:?}");
            assert!(crate::wrap_angle(pose.heading_rad - h).abs() < 1e-12, "{pose:?}");
        }
    }

    #[test]
    fn broken_trajectories_are_named() {
        let at = |t: i64, x: f64| (Stamp(t), pose(x, 0.0, 0.0));
        assert_eq!(Trajectory::new(vec![at(0, 0.0)]).unwrap_err(), TrajectoryError::TooFewPoses { got: 1 });
        assert_eq!(Trajectory::new(vec![at(0, 0.0), at(1, f64::NAN)]).unwrap_err(), TrajectoryError::NotFinite { index: 1 });
        assert!(matches!(Trajectory::new(vec![at(5, 0.0), at(5, 1.0)]), Err(TrajectoryError::StampsGoBack { index: 1, .. })));
    }
}
