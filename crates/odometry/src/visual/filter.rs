//! How did the camera move, all frames together? An extended Kalman filter forward, and a smoother back (Chu 2013, §3.2.1).
//!
//! poses as measured, each with its noise, or not at all ─▶ [`smooth`] ─▶ poses; or frame by frame ─▶ [`State`] ─▶ [`super::motion`]
//!
//! The error state is (turn, camera frame; position, odom; turn rate, camera frame; velocity, odom), 12 numbers (Solà 2017,
//! “Quaternion kinematics for the error-state Kalman filter”), with constant rates driven by white acceleration; then Rauch, Tung &
//! Striebel 1965. A good measurement is hardly moved; a frame without one lies where the motion before and after it would have it.
//!
//! Pitfall: a measured pose after a gap hangs on what was guessed in the gap. The smoother makes the way between believable, but knows
//! no better where it ends.

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, UnitQuaternion, Vector3};
use planwalk_types::{Stamp, TrackingState};

use super::map::Pose;
use super::map::pose::{difference, moved};

/// Of (turn, position, turn rate, velocity), as in [`State`].
pub(super) type Covariance = SMatrix<f64, 12, 12>;

/// Noise of a pose against the map, radians and units, from one frame to the next: what frames share, they share with the map.
const MAPPED: (f64, f64) = (1e-3, 5e-3);
/// The same of a rotation that few points, or the picture as a whole, say.
const TURNED_RAD: f64 = 0.01;
/// The same of what was guessed.
const GUESSED: (f64, f64) = (0.05, 0.05);

/// Noise of the pose of a frame that was followed like this: of a component of its rotation, radians, and of a coordinate, units.
pub(super) fn noise_of(state: TrackingState) -> (f64, f64) {
    match state {
        TrackingState::Mapped | TrackingState::Cut => MAPPED,
        TrackingState::RotationOnly => (TURNED_RAD, GUESSED.1),
        TrackingState::Propagated => GUESSED,
    }
}

/// A frame's pose as it was found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measured {
    pub stamp: Stamp,
    pub pose: Pose,
    /// Standard deviation of a component of the rotation, radians; `None` where it was only guessed.
    pub turn_rad: Option<f64>,
    /// Standard deviation of a coordinate of the position, units; `None` where it was only guessed.
    pub shift: Option<f64>,
}

/// White acceleration of heads, (rad/s²)²/Hz, and of walks, (units/s²)²/Hz: within a frame heads start to turn at some 6 rad/s², and
/// within half a second people stop, or set off.
const TURN_NOISE: f64 = 100.0;
const WALK_NOISE: f64 = 2.0;
/// Rates before anything is seen of them, rad/s and units/s.
const FIRST_RATES: (f64, f64) = (2.0, 1.5);
/// What is not measured at all: a standard deviation that is as good as infinite, radians and units.
const NOT_AT_ALL: f64 = 1e4;
/// States are kept of every so many-th frame, and found again between them: clips may last for hours.
const BLOCK: usize = 256;

/// Pose and rates, and how well they are known.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub pose: Pose,
    /// Radians a second, camera frame.
    pub turn_rate: Vector3<f64>,
    /// Units a second, odom.
    pub velocity: Vector3<f64>,
    pub covariance: Covariance,
}

impl State {
    /// A pose whose rates nobody has seen.
    pub fn first(measured: &Measured) -> Self {
        let mut covariance = Covariance::zeros();
        covariance.fixed_view_mut::<6, 6>(0, 0).copy_from(&noise(measured));
        for axis in 6..12 {
            let sigma = if axis < 9 { FIRST_RATES.0 } else { FIRST_RATES.1 };
            covariance[(axis, axis)] = sigma * sigma;
        }
        Self { pose: measured.pose, turn_rate: Vector3::zeros(), velocity: Vector3::zeros(), covariance }
    }

    /// What becomes of the error state.
    fn transition(&self, seconds: f64) -> Covariance {
        let mut step = Covariance::identity();
        let back = UnitQuaternion::from_scaled_axis(self.turn_rate * -seconds).to_rotation_matrix();
        step.fixed_view_mut::<3, 3>(0, 0).copy_from(back.matrix());
        step.fixed_view_mut::<3, 3>(0, 6).copy_from(&(Matrix3::identity() * seconds));
        step.fixed_view_mut::<3, 3>(3, 9).copy_from(&(Matrix3::identity() * seconds));
        step
    }

    /// So many seconds later, if nothing but white acceleration changes the rates.
    pub fn predicted(&self, seconds: f64) -> Self {
        let turn = UnitQuaternion::from_scaled_axis(self.turn_rate * seconds);
        let position = self.pose.translation.vector + self.velocity * seconds;
        let step = self.transition(seconds);
        let mut covariance = step * self.covariance * step.transpose();
        for (pose, rate, noise) in [(0, 6, TURN_NOISE), (3, 9, WALK_NOISE)] {
            for axis in 0..3 {
                let (p, r) = (pose + axis, rate + axis);
                covariance[(p, p)] += noise * seconds.powi(3) / 3.0;
                covariance[(p, r)] += noise * seconds.powi(2) / 2.0;
                covariance[(r, p)] += noise * seconds.powi(2) / 2.0;
                covariance[(r, r)] += noise * seconds;
            }
        }
        Self { pose: Pose::from_parts(position.into(), self.pose.rotation * turn), covariance, ..*self }
    }

    /// This state, given a pose as it was found at its time.
    pub fn updated(self, measured: &Measured) -> Self {
        if measured.turn_rad.is_none() && measured.shift.is_none() {
            return self;
        }
        let by_pose = self.covariance.fixed_columns::<6>(0).into_owned();
        let innovation = self.covariance.fixed_view::<6, 6>(0, 0) + noise(measured);
        let Some(inverse) = innovation.try_inverse() else { return self };
        let gain = by_pose * inverse;
        let covariance = self.covariance - gain * by_pose.transpose();
        let covariance = (covariance + covariance.transpose()) * 0.5;
        Self { covariance, ..self.corrected(&(gain * difference(&self.pose, &measured.pose))) }
    }

    fn corrected(&self, by: &SVector<f64, 12>) -> Self {
        Self {
            pose: moved(&self.pose, &by.fixed_rows::<6>(0).into_owned()),
            turn_rate: self.turn_rate + by.fixed_rows::<3>(6),
            velocity: self.velocity + by.fixed_rows::<3>(9),
            covariance: self.covariance,
        }
    }

    /// From this state to that one.
    fn difference(&self, to: &Self) -> SVector<f64, 12> {
        let mut off = SVector::<f64, 12>::zeros();
        off.fixed_rows_mut::<6>(0).copy_from(&difference(&self.pose, &to.pose));
        off.fixed_rows_mut::<3>(6).copy_from(&(to.turn_rate - self.turn_rate));
        off.fixed_rows_mut::<3>(9).copy_from(&(to.velocity - self.velocity));
        off
    }

    /// This state, given what the next one turned out to be.
    fn smoothed(&self, next: &Self, seconds: f64) -> Self {
        let predicted = self.predicted(seconds);
        let Some(inverse) = predicted.covariance.try_inverse() else { return *self };
        let gain = self.covariance * self.transition(seconds).transpose() * inverse;
        let covariance = self.covariance + gain * (next.covariance - predicted.covariance) * gain.transpose();
        Self { covariance, ..self.corrected(&(gain * predicted.difference(next))) }
    }
}

fn noise(measured: &Measured) -> Matrix6<f64> {
    let (turn, shift) = (measured.turn_rad.unwrap_or(NOT_AT_ALL), measured.shift.unwrap_or(NOT_AT_ALL));
    Matrix6::from_fn(|i, j| if i != j { 0.0 } else { if i < 3 { turn } else { shift }.powi(2) })
}

/// The poses of frames in time order, and the covariance of each: (turn in the camera frame, position in odom).
pub(super) fn smooth(frames: &[Measured]) -> Vec<(Pose, Matrix6<f64>)> {
    let Some(first) = frames.first() else { return Vec::new() };
    let seconds = |i: usize| frames[i + 1].stamp.secs_since(frames[i].stamp);
    let forward = |state: &State, i: usize| state.predicted(seconds(i)).updated(&frames[i + 1]);
    let mut kept = vec![State::first(first)];
    let mut now = kept[0];
    for i in 0..frames.len() - 1 {
        now = forward(&now, i);
        if (i + 1).is_multiple_of(BLOCK) {
            kept.push(now);
        }
    }
    let mut poses = vec![(now.pose, pose_covariance(&now)); frames.len()];
    for (block, start) in kept.iter().enumerate().rev() {
        let (begin, end) = (block * BLOCK, ((block + 1) * BLOCK).min(frames.len() - 1));
        let mut states = vec![*start];
        for i in begin..end.saturating_sub(1) {
            let next = forward(&states[i - begin], i);
            states.push(next);
        }
        for i in (begin..end).rev() {
            now = states[i - begin].smoothed(&now, seconds(i));
            poses[i] = (now.pose, pose_covariance(&now));
        }
    }
    poses
}

/// Standard deviations of a component of the rotation, radians, and of a coordinate of the position, units.
pub(super) fn sigmas(covariance: &Matrix6<f64>) -> (f64, f64) {
    let axis = |from: usize| (covariance.fixed_view::<3, 3>(from, from).trace() / 3.0).max(0.0).sqrt();
    (axis(0), axis(3))
}

/// Of (turn, position) alone.
pub(super) fn pose_covariance(state: &State) -> Matrix6<f64> {
    state.covariance.fixed_view::<6, 6>(0, 0).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A walk round a corner at 30 frames/s: 1.2 units/s, turning by 90° between the first second and the second one.
    fn walk(count: usize) -> Vec<Measured> {
        let frame = |i: usize| {
            let t = i as f64 / 30.0;
            let yaw = 0.25 * std::f64::consts::PI * (1.0 - (std::f64::consts::PI * (t - 1.0).clamp(0.0, 1.0)).cos());
            let at = Vector3::new(1.2 * t, 0.03 * (11.0 * t).sin(), 0.3 * t * t);
            let pose = Pose::from_parts(at.into(), UnitQuaternion::from_scaled_axis(Vector3::y() * yaw));
            Measured { stamp: Stamp((t * 1e9) as i64), pose, turn_rad: Some(1e-3), shift: Some(5e-3) }
        };
        (0..count).map(frame).collect()
    }

    fn worst(found: &[(Pose, Matrix6<f64>)], truth: &[Measured]) -> (f64, f64) {
        let off = found.iter().zip(truth).map(|(f, t)| difference(&f.0, &t.pose));
        off.fold((0.0, 0.0), |worst, d| (f64::max(worst.0, d.fixed_rows::<3>(0).norm()), f64::max(worst.1, d.fixed_rows::<3>(3).norm())))
    }

    #[test]
    fn good_measurements_stay_and_no_block_shows() {
        // Longer than two blocks, one frame over.
        let frames = walk(2 * BLOCK + 2);
        let found = smooth(&frames);
        let (turn, shift) = worst(&found, &frames);
        // A tenth of what they are measured to: the corner and the sway are within the accelerations of people.
        assert!(turn < 1e-4 && shift < 1e-3, "{turn} rad, {shift}");
        assert!(found.iter().all(|(_, p)| p[(0, 0)] < 1.1e-6 && p[(3, 3)] < 2.6e-5 && p[(3, 3)] > 0.0));
        assert!(smooth(&[]).is_empty() && smooth(&frames[..1]).len() == 1);
    }

    #[test]
    fn a_gap_is_as_the_motion_around_it_and_knows_that_it_was_not_seen() {
        let truth = walk(120);
        let mut frames = truth.clone();
        for frame in &mut frames[35..50] {
            // Half a second in the corner, guessed wildly.
            let guess = Pose::from_parts(Vector3::new(9.0, 9.0, 9.0).into(), UnitQuaternion::identity());
            *frame = Measured { pose: guess, turn_rad: None, shift: None, ..*frame };
        }
        let found = smooth(&frames);
        let (turn, shift) = worst(&found, &truth);
        // A cubic through half a second of a turn that speeds up to 140°/s: 5° by its change of acceleration; the sway is lost.
        assert!(turn < 0.09 && shift < 0.07, "{turn} rad, {shift}");
        let sigma = |i: usize| (found[i].1[(0, 0)].sqrt(), found[i].1[(3, 3)].sqrt());
        assert!(sigma(42).0 > 20.0 * sigma(60).0 && sigma(42).1 > 5.0 * sigma(60).1, "{:?} {:?}", sigma(42), sigma(60));
        assert!(turn < 4.0 * sigma(42).0 && shift < 4.0 * sigma(42).1, "what it says of itself covers");
    }

    #[test]
    fn noise_is_smoothed_where_it_is_larger_than_what_people_do() {
        let truth = walk(200);
        let mut frames = truth.clone();
        for (i, frame) in frames.iter_mut().enumerate() {
            // Shaken by 5 cm every other frame: no walker does that.
            frame.pose.translation.vector.y += if i % 2 == 0 { 0.05 } else { -0.05 };
            frame.shift = Some(0.05);
        }
        let found = smooth(&frames);
        let inner = worst(&found[10..190], &truth[10..190]).1;
        assert!(inner < 0.02, "{inner} of 0.05 is left");
    }
}
