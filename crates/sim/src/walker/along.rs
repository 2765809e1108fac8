//! How does the camera move along a given path? Smoothly through its poses, which need not come at the video's rate.
//!
//! Positions by cubic Hermite curves whose tangents are those of the parabola through each pose and its neighbours (Catmull–Rom
//! for uneven times), so velocity is continuous; rotations by spherical interpolation. `libm` throughout.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use planwalk_types::{Cam, Plan, Rigid3, Stamp};

use crate::error::SimError;

/// Poses in order, seconds from the first.
#[derive(Debug, Clone)]
pub(super) struct Along {
    times_s: Vec<f64>,
    positions: Vec<Vector3<f64>>,
    velocities: Vec<Vector3<f64>>,
    rotations: Vec<UnitQuaternion<f64>>,
}

impl Along {
    /// The path of the camera that is fixed to a sensor by `mount` (`sensor_from_camera`).
    ///
    /// # Errors
    /// [`SimError::Path`] for fewer than two poses, stamps that do not increase, or numbers that are not finite.
    pub fn new(plan_from_sensor: &[(Stamp, Rigid3<Plan, Cam>)], mount: UnitQuaternion<f64>) -> Result<Self, SimError> {
        let refuse = |index: usize, what: &'static str| Err(SimError::Path { index, count: plan_from_sensor.len(), what });
        let [(first, _), _, ..] = plan_from_sensor else { return refuse(0, "a path needs at least two poses") };
        let finite = |pose: &Rigid3<Plan, Cam>| {
            let q = pose.iso.rotation.coords;
            pose.iso.translation.vector.iter().chain(q.iter()).all(|v| v.is_finite()) && q.norm() > 0.5
        };
        for (index, (_, pose)) in plan_from_sensor.iter().enumerate() {
            if !finite(pose) {
                return refuse(index, "its numbers make no pose");
            }
        }
        if !mount.coords.iter().all(|v| v.is_finite()) {
            return refuse(0, "the mount's rotation is not finite");
        }
        if let Some(index) = plan_from_sensor.windows(2).position(|w| w[1].0 <= w[0].0) {
            return refuse(index + 1, "its stamp is not after the one before");
        }
        let times_s: Vec<f64> = plan_from_sensor.iter().map(|(stamp, _)| stamp.secs_since(*first)).collect();
        let positions: Vec<Vector3<f64>> = plan_from_sensor.iter().map(|(_, pose)| pose.iso.translation.vector).collect();
        let rotations = plan_from_sensor.iter().map(|(_, pose)| pose.iso.rotation * mount).collect();
        let velocities = tangents(&times_s, &positions);
        Ok(Self { times_s, positions, velocities, rotations })
    }

    /// From the first pose to the last, seconds.
    pub fn duration_s(&self) -> f64 {
        self.times_s.last().copied().unwrap_or(0.0)
    }

    /// The camera at a moment; before the first pose and after the last one it stands there.
    pub fn at(&self, time_s: f64) -> Rigid3<Plan, Cam> {
        let last = self.times_s.len() - 1;
        let i = self.times_s.partition_point(|t| *t <= time_s).saturating_sub(1).min(last - 1);
        let span = self.times_s[i + 1] - self.times_s[i];
        let x = ((time_s - self.times_s[i]) / span).clamp(0.0, 1.0);
        let (x2, x3) = (x * x, x * x * x);
        let position = self.positions[i] * (1.0 - 3.0 * x2 + 2.0 * x3)
            + self.positions[i + 1] * (3.0 * x2 - 2.0 * x3)
            + self.velocities[i] * (span * (x - 2.0 * x2 + x3))
            + self.velocities[i + 1] * (span * (x3 - x2));
        Rigid3::from_parts(position, slerp(&self.rotations[i], &self.rotations[i + 1], x))
    }
}

/// Velocity at each pose: the slope there of the parabola through it and its neighbours; at the ends that of the chord.
fn tangents(times_s: &[f64], positions: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let chord = |i: usize| (positions[i + 1] - positions[i]) / (times_s[i + 1] - times_s[i]);
    let last = positions.len() - 1;
    (0..=last)
        .map(|i| match i {
            0 => chord(0),
            i if i == last => chord(last - 1),
            i => {
                let (before, after) = (times_s[i] - times_s[i - 1], times_s[i + 1] - times_s[i]);
                (chord(i - 1) * after + chord(i) * before) / (before + after)
            }
        })
        .collect()
}

/// The rotation a share of the shorter way from one to another.
fn slerp(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    let cos = a.coords.dot(&b.coords);
    let (cos, sign) = if cos < 0.0 { (-cos, -1.0) } else { (cos, 1.0) };
    let angle = libm::acos(cos.min(1.0));
    let (wa, wb) = if angle < 1e-6 {
        (1.0 - share, share)
    } else {
        let sin = libm::sin(angle);
        (libm::sin((1.0 - share) * angle) / sin, libm::sin(share * angle) / sin)
    };
    UnitQuaternion::new_normalize(Quaternion::from(a.coords * wa + b.coords * (wb * sign)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(times: impl Iterator<Item = f64>) -> Vec<(Stamp, Rigid3<Plan, Cam>)> {
        times
            .map(|t| {
                let place = Vector3::new(2.0 * t.cos(), 2.0 * t.sin(), 1.5);
                (Stamp((1e9 * t) as i64 + 7_000_000_000), Rigid3::from_parts(place, UnitQuaternion::from_axis_angle(&Vector3::z_axis(), t)))
            })
            .collect()
    }

    #[test]
    fn a_circle_stays_one_between_its_poses() {
        let along = Along::new(&circle((0..200).map(|i| 0.05 * f64::from(i))), UnitQuaternion::identity()).unwrap();
        // Not in the first and last pieces, whose outer tangents are chords.
        for i in 11..1980 {
            let t = 0.005 * f64::from(i);
            let pose = along.at(t);
            // Tangents from neighbours err by h²/6 of the third derivative: 2 · 0.05² / 6 m/s, over a step of 0.05 s under 1e-4 m.
            assert!((pose.origin().coords - Vector3::new(2.0 * t.cos(), 2.0 * t.sin(), 1.5)).norm() < 1e-4, "at {t} s");
            // Turning evenly is what spherical interpolation does; stamps are cut to nanoseconds.
            assert!(pose.iso.rotation.angle_to(&UnitQuaternion::from_axis_angle(&Vector3::z_axis(), t)) < 1e-7, "at {t} s");
        }
        // Velocity is continuous where two pieces meet.
        let v = |t: f64| (along.at(t + 1e-6).origin().coords - along.at(t - 1e-6).origin().coords) / 2e-6;
        assert!((v(2.0 - 1e-5) - v(2.0 + 1e-5)).norm() < 1e-3);
    }

    #[test]
    fn the_mount_turns_the_camera_on_its_sensor() {
        let mount = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.3);
        let poses = circle([0.0, 1.0].into_iter());
        let along = Along::new(&poses, mount).unwrap();
        assert!(along.at(1.0).iso.rotation.angle_to(&(poses[1].1.iso.rotation * mount)) < 1e-7);
        assert_eq!(along.at(5.0).iso, along.at(1.0).iso, "it stands at the end");
    }

    #[test]
    fn what_is_no_path_is_refused_with_the_place() {
        let poses = circle([0.0, 1.0, 2.0].into_iter());
        let message = |poses: &[_]| Along::new(poses, UnitQuaternion::identity()).unwrap_err().to_string();
        assert!(message(&poses[..1]).contains("two poses"));
        assert!(message(&[poses[0], poses[2], poses[1]]).contains("pose 2"));
        let mut bad = poses.clone();
        bad[1].1.iso.translation.vector.x = f64::NAN;
        assert!(message(&bad).contains("pose 1"));
    }
}
