//! Where is the camera on this body? It bobs with every step, sways with every second one, and the head looks around.
//!
//! Amplitudes at 1 m/s: ± 2.5 cm up and down at step frequency, ± 2 cm sideways at half of it, fading as one stops.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use planwalk_types::{PlanPose, Rigid3, Seed};
use rand::RngExt;

use super::habits::Habits;
use super::pursuit::Stride;
use super::{WalkOptions, WalkPose};

use std::f64::consts::{PI, TAU};

/// Bobbing, metres.
const BOB_M: f64 = 0.025;
/// Sway, metres.
const SWAY_M: f64 = 0.02;
/// How far ahead of the body the gaze is in a turn, seconds.
const GAZE_LEAD_S: f64 = 0.25;

/// A slow wave.
#[derive(Debug, Clone, Copy)]
struct Wave {
    hertz: f64,
    phase: f64,
}

impl Wave {
    fn at(&self, time_s: f64) -> f64 {
        libm::sin(TAU * self.hertz * time_s + self.phase)
    }
}

/// How this walker carries the camera.
#[derive(Debug, Clone)]
pub(super) struct Gait {
    height_m: f64,
    strength: f64,
    look_around_rad: f64,
    pitch_down_rad: f64,
    /// Two for yaw, one for pitch, one for roll: no common period.
    waves: [Wave; 4],
    habits: Habits,
}

impl Gait {
    pub fn new(options: &WalkOptions, habits: Habits, seed: Seed) -> Self {
        let mut rng = seed.derive("gait", 0);
        let wave = |rng: &mut planwalk_types::StreamRng, low: f64, high: f64| Wave {
            hertz: rng.random_range(low..high),
            phase: rng.random_range(0.0..TAU),
        };
        let waves = [wave(&mut rng, 0.06, 0.10), wave(&mut rng, 0.15, 0.22), wave(&mut rng, 0.08, 0.15), wave(&mut rng, 0.1, 0.2)];
        Self {
            height_m: options.camera_height_m,
            strength: options.gait,
            look_around_rad: options.look_around_rad,
            pitch_down_rad: rng.random_range(3.0..6.0f64).to_radians(),
            waves,
            habits,
        }
    }

    /// The camera on this body.
    pub fn pose(&self, stride: &Stride) -> WalkPose {
        let amount = self.strength * stride.speed_mps.min(1.3);
        let (bob, sway) = (libm::cos(TAU * stride.steps), libm::sin(PI * stride.steps));
        let (s, c) = libm::sincos(stride.heading_rad);
        let left_m = amount * SWAY_M * sway;
        let (x, y) = (stride.x - s * left_m, stride.y + c * left_m);
        let z = self.height_m + amount * BOB_M * bob;
        let drift = self.waves.map(|wave| wave.at(stride.time_s));
        let (tremor, hand) = (self.habits.tremor_rad(stride.time_s), self.habits.drift_rad(stride.time_s));
        let yaw = stride.heading_rad
            + GAZE_LEAD_S * stride.turn_rate_rad_s
            + self.look_around_rad * (0.65 * drift[0] + 0.35 * drift[1])
            + amount * 0.006 * sway
            + self.habits.glance_rad(stride.time_s)
            + tremor[0];
        let pitch_down = self.pitch_down_rad
            + self.strength * 0.02 * drift[2]
            + amount * 0.006 * bob
            + self.habits.tilt_rad(stride.time_s)
            + tremor[1]
            + hand[0];
        let roll = self.strength * 0.012 * drift[3] + amount * 0.01 * sway + tremor[2] + hand[1];
        let rotation = turn(Vector3::z(), yaw) * turn(Vector3::y(), pitch_down) * turn(Vector3::x(), roll) * body_from_camera();
        WalkPose { plan_from_camera: Rigid3::from_parts(Vector3::new(x, y, z), rotation), on_floor: PlanPose::new(x, y, yaw) }
    }
}

/// Rotation about a unit axis.
fn turn(axis: Vector3<f64>, angle_rad: f64) -> UnitQuaternion<f64> {
    let (s, c) = libm::sincos(0.5 * angle_rad);
    UnitQuaternion::new_unchecked(Quaternion::new(c, s * axis.x, s * axis.y, s * axis.z))
}

/// Camera axes (right, down, forward) to body axes (forward, left, up).
fn body_from_camera() -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(0.5, -0.5, 0.5, -0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_looks_where_the_floor_pose_says() {
        let options = WalkOptions::default();
        let gait = Gait::new(&options, Habits::new(&options, Seed(4)), Seed(4));
        let stride = Stride { time_s: 3.0, x: 2.0, y: -1.0, heading_rad: 2.2, turn_rate_rad_s: 0.4, speed_mps: 1.1, steps: 5.3 };
        let pose = gait.pose(&stride);
        let forward = pose.plan_from_camera.iso.rotation * Vector3::z();
        let error = planwalk_types::wrap_angle(libm::atan2(forward.y, forward.x) - pose.on_floor.heading_rad);
        // Round-off of four rotations.
        assert!(error.abs() < 1e-12, "{error:e} rad");
        assert!(forward.z < 0.0, "it looks a little down");
        let down = pose.plan_from_camera.iso.rotation * Vector3::y();
        assert!(down.z < -0.98, "its y axis points down");
    }

    #[test]
    fn a_trolley_does_not_bob() {
        let options = WalkOptions { gait: 0.0, look_around_rad: 0.0, ..Default::default() };
        let gait = Gait::new(&options, Habits::new(&options, Seed(4)), Seed(4));
        let stride = |steps: f64| Stride { time_s: 0.0, x: 0.0, y: 0.0, heading_rad: 0.0, turn_rate_rad_s: 0.0, speed_mps: 1.0, steps };
        let heights: Vec<f64> = (0..20).map(|i| gait.pose(&stride(0.1 * i as f64)).plan_from_camera.origin().coords.z).collect();
        assert!(heights.iter().all(|z| *z == options.camera_height_m), "{heights:?}");
    }
}
