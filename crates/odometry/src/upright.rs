//! Which way is up, as people hold cameras and walk?
//!
//! camera rotations, and directions walked ─▶ [`Upright`] ─▶ up
//!
//! Gravity is the direction most nearly at right angles to the camera's x axis, to where it looks, and to where the path goes,
//! each weighed by how level it is with people who walk: the least eigenvector of a 3×3.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// People hold cameras upright: the camera's x axis is level within this, radians, one standard deviation.
const ROLL_RAD: f64 = 0.05;
/// They look ahead: the optical axis is level within this.
const PITCH_RAD: f64 = 0.25;
/// They walk on a floor: the way from here to two units further on is level within this (gait, and the odometry's own drift).
const SLOPE_RAD: f64 = 0.05;

/// What speaks for one direction being up.
#[derive(Debug, Clone)]
pub struct Upright {
    /// Σ w d dᵀ/σ² over directions d that are level.
    level: Matrix3<f64>,
    /// Sum of the cameras' y axes.
    down: Vector3<f64>,
}

impl Default for Upright {
    fn default() -> Self {
        Self { level: Matrix3::zeros(), down: Vector3::zeros() }
    }
}

impl Upright {
    /// Takes in a camera's rotation (`world ← camera`) with this weight.
    pub fn add_camera(&mut self, rotation: &UnitQuaternion<f64>, weight: f64) {
        let (x, y, z) = (rotation * Vector3::x(), rotation * Vector3::y(), rotation * Vector3::z());
        self.level += (x * x.transpose() / ROLL_RAD.powi(2) + z * z.transpose() / PITCH_RAD.powi(2)) * weight;
        self.down += y * weight;
    }

    /// Takes in a unit direction that was walked.
    pub fn add_way(&mut self, way: &Vector3<f64>, weight: f64) {
        self.level += way * way.transpose() * (weight / SLOPE_RAD.powi(2));
    }

    /// Forgets a share of what was taken in.
    pub fn fade(&mut self, keeps: f64) {
        self.level *= keeps;
        self.down *= keeps;
    }

    /// The unit vector that points up; that of the first camera's −y where nothing was taken in.
    pub fn up(&self) -> Vector3<f64> {
        if self.down == Vector3::zeros() {
            return -Vector3::y();
        }
        let eigen = self.level.symmetric_eigen();
        let gravity: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
        if gravity.dot(&self.down) > 0.0 { -gravity } else { gravity }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_where_no_camera_rolls_to() {
        let mut upright = Upright::default();
        assert_eq!(upright.up(), -Vector3::y(), "nothing known: as the first camera was held");
        for i in 0..40 {
            // Looking about by 20° a frame, and down by 0 to 8°.
            let i = f64::from(i);
            let yaw = UnitQuaternion::from_scaled_axis(Vector3::y() * (0.35 * i));
            let pitch = UnitQuaternion::from_scaled_axis(Vector3::x() * (-0.14 * (i % 2.0)));
            upright.add_camera(&(yaw * pitch), 1.0);
        }
        // All around: the pitch cancels.
        assert!(upright.up().angle(&-Vector3::y()) < 0.01, "{}", upright.up());
        upright.fade(0.5);
        assert!(upright.up().angle(&-Vector3::y()) < 0.01);
    }
}
