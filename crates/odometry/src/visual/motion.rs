//! Where will the camera be at the next frame? It goes on as it did, and nobody knows exactly how.
//!
//! poses frame by frame ─▶ `Motion` ─▶ [`PosePrior`] of the next one, by the [`Prediction`] that was chosen

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Stamp, TrackingState};

use super::filter::{Covariance, Measured, State, noise_of, pose_covariance, sigmas};
use super::map::Pose;
use super::map::pose::PosePrior;
#[cfg(doc)]
use super::track::FEW;

/// What is the next frame looked for by?
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Prediction {
    /// The step from the last frame but one to the last, with the freedom that heads and walkers have.
    #[default]
    LastStep,
    /// The rates of an extended Kalman filter over all frames so far, with the freedom of its covariance (Chu 2013, §3.2.1; `visual/filter.rs`).
    Filtered,
}

/// Pose and velocity of the camera: units and radians a second.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    pub pose: Pose,
    pub stamp: Stamp,
    pub velocity: Vector3<f64>,
    pub turn_rate: Vector3<f64>,
    /// Usual speed of the walk, units/s.
    pub usual_speed: f64,
    /// How well all of it is known, where a filter says so: it is then the state's, and whoever moves the pose moves the state's.
    covariance: Option<Box<Covariance>>,
}

/// Seconds in which a turn that nothing confirms dies away: heads stop within half a second.
const TURN_LASTS_S: f64 = 0.1;
/// Seconds in which a walk that nothing confirms dies away.
const WALK_LASTS_S: f64 = 4.0;

impl Motion {
    /// From one pose to another within so many seconds.
    pub fn between(base: &Pose, now: Pose, stamp: Stamp, seconds: f64, usual_speed: f64, prediction: Prediction) -> Self {
        let (velocity, turn_rate) = rates(base, &now, seconds);
        let covariance = match prediction {
            Prediction::LastStep => None,
            Prediction::Filtered => Some(unseen(stamp, now)),
        };
        Self { pose: now, stamp, velocity, turn_rate, usual_speed, covariance }
    }

    /// The pose at `stamp` if the camera goes on as it did; how far it may differ grows with time.
    pub fn predict(&self, stamp: Stamp) -> PosePrior {
        let seconds = stamp.secs_since(self.stamp).clamp(1e-3, 1.0);
        if let Some(state) = self.state() {
            let predicted = state.predicted(seconds);
            let (sigma_turn_rad, sigma_move) = sigmas(&pose_covariance(&predicted));
            return PosePrior { pose: predicted.pose, sigma_move, sigma_turn_rad, fix: None };
        }
        let turn = UnitQuaternion::from_scaled_axis(self.turn_rate * seconds);
        let position = self.pose.translation.vector + self.velocity * seconds;
        // Speeds change by their own size in a second and a half, heads start to turn at some 6 rad/s²; the last velocity is itself noisy.
        let sigma_move = self.usual_speed.max(0.1) * seconds * (0.8 * seconds.sqrt() + 0.1);
        let sigma_turn_rad = 6.0 * libm::pow(seconds, 1.5) + 0.01;
        PosePrior { pose: Pose::from_parts(position.into(), self.pose.rotation * turn), sigma_move, sigma_turn_rad, fix: None }
    }

    fn state(&self) -> Option<State> {
        let covariance = **self.covariance.as_ref()?;
        Some(State { pose: self.pose, turn_rate: self.turn_rate, velocity: self.velocity, covariance })
    }

    /// Stands still from here: nothing says how the camera moves.
    pub fn stand(&mut self, stamp: Stamp) {
        (self.velocity, self.turn_rate, self.stamp) = (Vector3::zeros(), Vector3::zeros(), stamp);
        self.covariance = self.covariance.take().map(|_| unseen(stamp, self.pose));
    }

    /// Velocity from the last pose to this one; where nothing says it, it dies away, and so does the turn where fewer than [`FEW`]
    /// points say it: that of the picture as a whole is a walk's parallax too, and must not be carried on.
    pub fn go_on(&mut self, stamp: Stamp, now: Pose, state: TrackingState, turn_known: bool) {
        let seconds = stamp.secs_since(self.stamp).max(1e-3);
        let (turn_before, (velocity, turn_rate)) = (self.turn_rate, rates(&self.pose, &now, seconds));
        let filtered = self.state().map(|before| before.predicted(seconds).updated(&measured(stamp, now, state, turn_known)));
        (self.velocity, self.turn_rate) = filtered.map_or((velocity, turn_rate), |f| (f.velocity, f.turn_rate));
        self.covariance = filtered.map(|f| Box::new(f.covariance));
        if !turn_known {
            self.turn_rate = turn_before * libm::exp(-seconds / TURN_LASTS_S);
        }
        if state == TrackingState::Propagated {
            self.velocity *= libm::exp(-seconds / WALK_LASTS_S);
        } else {
            let share = (seconds / 3.0).min(0.5);
            self.usual_speed += share * (velocity.norm() - self.usual_speed);
        }
        (self.pose, self.stamp) = (now, stamp);
    }
}

/// Velocity and turn rate from one pose to another.
fn rates(from: &Pose, to: &Pose, seconds: f64) -> (Vector3<f64>, Vector3<f64>) {
    let way = to.translation.vector - from.translation.vector;
    (way / seconds, (from.rotation.inverse() * to.rotation).scaled_axis() / seconds)
}

/// How well a motion is known of which only a pose was seen.
fn unseen(stamp: Stamp, pose: Pose) -> Box<Covariance> {
    Box::new(State::first(&measured(stamp, pose, TrackingState::Mapped, true)).covariance)
}

/// What a frame's pose says of the motion: where nothing was seen it is only what was predicted.
fn measured(stamp: Stamp, pose: Pose, state: TrackingState, turn_known: bool) -> Measured {
    let (turn, shift) = noise_of(state);
    let placed = matches!(state, TrackingState::Mapped | TrackingState::Cut);
    Measured { stamp, pose, turn_rad: turn_known.then_some(turn), shift: placed.then_some(shift) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::map::pose::difference;

    const HZ: f64 = 30.0;

    fn stamp(i: usize) -> Stamp {
        Stamp((i as f64 / HZ * 1e9).round() as i64)
    }

    /// Straight ahead at 1.2 units/s, turning left at 0.5 rad/s, every other frame this far aside.
    fn pose(i: usize, aside: f64) -> Pose {
        let t = i as f64 / HZ;
        let jitter = if i.is_multiple_of(2) { aside } else { -aside };
        Pose::from_parts(Vector3::new(jitter, 0.0, 1.2 * t).into(), UnitQuaternion::from_scaled_axis(Vector3::y() * (-0.5 * t)))
    }

    fn walked(prediction: Prediction, frames: usize, aside: f64) -> Motion {
        let mut motion = Motion::between(&pose(0, aside), pose(1, aside), stamp(1), 1.0 / HZ, 1.1, prediction);
        for i in 2..frames {
            motion.go_on(stamp(i), pose(i, aside), TrackingState::Mapped, true);
        }
        motion
    }

    #[test]
    fn a_steady_walk_is_predicted_by_both() {
        for prediction in [Prediction::LastStep, Prediction::Filtered] {
            let off = difference(&walked(prediction, 90, 0.0).predict(stamp(90)).pose, &pose(90, 0.0));
            // The filter follows a turn with constant rates exactly, in the limit: a thousandth of a frame's 4 cm and 1° is left.
            assert!(off.norm() < 1e-4, "{prediction:?}: {off}");
        }
    }

    #[test]
    fn a_filter_is_not_led_by_one_frame() {
        let off = |prediction| (walked(prediction, 91, 0.005).predict(stamp(91)).pose.translation.x - pose(91, 0.0).translation.x).abs();
        let (last_step, filtered) = (off(Prediction::LastStep), off(Prediction::Filtered));
        // From 5 mm on one side the last step goes on by 10 mm; of a speed that comes and goes the filter, told of noise of 5 mm, believes half.
        assert!((last_step - 0.015).abs() < 1e-9 && filtered < 0.005 + 0.6 * 0.01, "{last_step} and {filtered}");
    }

    #[test]
    fn what_is_not_seen_dies_away_and_is_known_less() {
        for prediction in [Prediction::LastStep, Prediction::Filtered] {
            let mut motion = walked(prediction, 90, 0.0);
            let seen = motion.predict(stamp(90));
            let mut freedom = seen.sigma_move;
            for i in 90..105 {
                let guess = motion.predict(stamp(i));
                assert!(prediction == Prediction::LastStep || guess.sigma_move >= freedom, "frame {i}");
                freedom = guess.sigma_move;
                motion.go_on(stamp(i), guess.pose, TrackingState::Propagated, false);
            }
            // Half a second: a turn of 0.5 rad/s by e⁻⁵, a walk by e^(−1/8).
            assert!(motion.turn_rate.norm() < 0.01 && (motion.velocity.norm() - 1.2 * libm::exp(-0.125)).abs() < 0.05, "{motion:?}");
            motion.stand(stamp(105));
            assert_eq!(motion.predict(stamp(106)).pose, motion.pose, "who stands stays");
        }
    }

    #[test]
    fn whoever_moves_the_pose_moves_what_is_predicted() {
        let mut motion = walked(Prediction::Filtered, 90, 0.0);
        let before = motion.predict(stamp(90)).pose;
        motion.pose.translation.vector += Vector3::new(3.0, 0.0, -1.0);
        motion.velocity *= 2.0;
        let way = motion.predict(stamp(90)).pose.translation.vector - before.translation.vector;
        assert!((way - Vector3::new(3.0, 0.0, -1.0 + 1.2 / HZ)).norm() < 1e-3, "{way}");
    }
}
