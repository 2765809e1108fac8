//! Where will the camera be at the next frame? It goes on as it did, and nobody knows exactly how.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Stamp, TrackingState};

use super::map::Pose;
use super::map::pose::PosePrior;
#[cfg(doc)]
use super::track::FEW;

/// Velocity of the camera: units and radians a second.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    pub pose: Pose,
    pub stamp: Stamp,
    pub velocity: Vector3<f64>,
    pub turn_rate: Vector3<f64>,
    /// Usual speed of the walk, units/s.
    pub usual_speed: f64,
}

/// Seconds in which a turn that nothing confirms dies away: heads stop within half a second.
const TURN_LASTS_S: f64 = 0.1;
/// Seconds in which a walk that nothing confirms dies away.
const WALK_LASTS_S: f64 = 4.0;

impl Motion {
    /// The pose at `stamp` if the camera goes on as it did; how far it may differ grows with time.
    pub fn predict(&self, stamp: Stamp) -> PosePrior {
        let seconds = stamp.secs_since(self.stamp).clamp(1e-3, 1.0);
        let turn = UnitQuaternion::from_scaled_axis(self.turn_rate * seconds);
        let position = self.pose.translation.vector + self.velocity * seconds;
        // Speeds change by their own size in a second and a half, heads start to turn at some 6 rad/s²; the last velocity is itself noisy.
        let sigma_move = self.usual_speed.max(0.1) * seconds * (0.8 * seconds.sqrt() + 0.1);
        let sigma_turn_rad = 6.0 * libm::pow(seconds, 1.5) + 0.01;
        PosePrior { pose: Pose::from_parts(position.into(), self.pose.rotation * turn), sigma_move, sigma_turn_rad, fix: None }
    }

    /// Stands still from here: nothing says how the camera moves.
    pub fn stand(&mut self, stamp: Stamp) {
        (self.velocity, self.turn_rate, self.stamp) = (Vector3::zeros(), Vector3::zeros(), stamp);
    }

    /// Velocity from the last pose to this one; where nothing says it, it dies away, and so does the turn where fewer than [`FEW`]
    /// points say it: that of the picture as a whole is a walk's parallax too, and must not be carried on.
    pub fn go_on(&mut self, stamp: Stamp, now: Pose, state: TrackingState, turn_known: bool) {
        let seconds = stamp.secs_since(self.stamp).max(1e-3);
        let (turn_before, last) = (self.turn_rate, self.pose);
        self.velocity = (now.translation.vector - last.translation.vector) / seconds;
        self.turn_rate = (last.rotation.inverse() * now.rotation).scaled_axis() / seconds;
        if !turn_known {
            self.turn_rate = turn_before * libm::exp(-seconds / TURN_LASTS_S);
        }
        if state == TrackingState::Propagated {
            self.velocity *= libm::exp(-seconds / WALK_LASTS_S);
        } else {
            let share = (seconds / 3.0).min(0.5);
            self.usual_speed += share * (self.velocity.norm() - self.usual_speed);
        }
        (self.pose, self.stamp) = (now, stamp);
    }
}
