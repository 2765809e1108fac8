//! How do a camera's poses become a body's, with z up?
//!
//! A camera's world may have any axis up: a first camera's own axes (y down: KITTI, ORB-SLAM), a phone's (y up: ARKit), a
//! plan's (z up). People hold cameras upright most of the time, so the mean of the camera's upward direction tells.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use planwalk_types::{Body, Odom, Rigid3, Stamp};

use super::RawPose;

/// Cosine of the angle within which the mean upward direction is one of the world's axes: 37°, for a phone held tilted.
const AXIS_COS: f64 = 0.8;

/// Poses `odom ← body` in time order.
type Timed = Vec<(Stamp, Rigid3<Odom, Body>)>;

/// `odom ← body` of poses `world ← camera`, and whether their world had to be turned; the body stands where the camera is.
pub(super) fn body_from_camera(poses: &[RawPose], notes: &mut Vec<String>) -> (Timed, bool) {
    // Columns are the body's axes in the camera frame: forward is z, left is −x, up is −y.
    let camera_from_body = from_columns([0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
    let up = mean_up(poses, &(camera_from_body * Vector3::z()));
    let (odom_from_world, said) = levelling(&up);
    notes.push(format!("poses are the camera's; {said}"));
    let convert = |pose: &RawPose| {
        let iso = pose.world_from_thing.iso;
        let rotation = odom_from_world * iso.rotation * camera_from_body;
        (pose.stamp, Rigid3::from_parts(odom_from_world * iso.translation.vector, rotation))
    };
    (poses.iter().map(convert).collect(), odom_from_world.angle() > 0.0)
}

/// Tells when poses that are taken as a body's do not stand upright.
pub(super) fn note_if_not_upright(poses: &[RawPose], notes: &mut Vec<String>) {
    let up = mean_up(poses, &Vector3::z());
    if up.z < 0.5 {
        let deg = up.z.clamp(-1.0, 1.0).acos().to_degrees();
        notes.push(format!(
            "the body's z axis is {deg:.0}° off the vertical on average: if these are a camera's poses, say --poses-frame camera"
        ));
    }
}

/// Mean direction, in the world, of a direction of the thing; not of unit length: short where it varies.
fn mean_up(poses: &[RawPose], up_in_thing: &Vector3<f64>) -> Vector3<f64> {
    poses.iter().map(|p| p.world_from_thing.iso.rotation * up_in_thing).sum::<Vector3<f64>>() / poses.len().max(1) as f64
}

/// The rotation that brings `up` to z, and what was understood.
fn levelling(up: &Vector3<f64>) -> (UnitQuaternion<f64>, String) {
    let Some(up) = up.try_normalize(1e-6) else {
        return (UnitQuaternion::identity(), "no direction is up on average: z is taken as up".to_owned());
    };
    if up.z > AXIS_COS {
        return (UnitQuaternion::identity(), "their world has z up".to_owned());
    }
    if up.y < -AXIS_COS {
        // A first camera's axes become a body's: forward is forward.
        let turn = from_columns([0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
        return (turn, "their world has y down, and is turned to z up".to_owned());
    }
    if up.y > AXIS_COS {
        // ARKit: −z is the first heading.
        let turn = from_columns([0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]);
        return (turn, "their world has y up, and is turned to z up".to_owned());
    }
    // Half a turn has no shortest way; any will do.
    let turn = UnitQuaternion::rotation_between(&up, &Vector3::z())
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    (turn, format!("no axis of their world is up; the camera's mean upward direction ({:.2}, {:.2}, {:.2}) is", up.x, up.y, up.z))
}

/// The rotation whose columns are these unit axes.
fn from_columns(x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> UnitQuaternion<f64> {
    let matrix = Matrix3::from_columns(&[Vector3::from(x), Vector3::from(y), Vector3::from(z)]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A walk of a body that turns left, seen as poses of its camera in a world turned by `world_from_odom`.
    fn camera_poses(world_from_odom: UnitQuaternion<f64>) -> (Vec<Rigid3<Odom, Body>>, Vec<RawPose>) {
        let body_from_camera = from_columns([0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
        let bodies: Vec<Rigid3<Odom, Body>> = (0..20)
            .map(|i| {
                let t = f64::from(i);
                Rigid3::from_parts(Vector3::new(t, 0.1 * t * t, 0.0), UnitQuaternion::from_euler_angles(0.05, 0.1, 0.15 * t))
            })
            .collect();
        let raw = |(i, body): (usize, &Rigid3<Odom, Body>)| RawPose {
            line: i,
            stamp: Stamp(i as i64),
            world_from_thing: Rigid3::from_parts(
                world_from_odom * body.iso.translation.vector,
                world_from_odom * body.iso.rotation * body_from_camera,
            ),
        };
        (bodies.clone(), bodies.iter().enumerate().map(raw).collect())
    }

    #[test]
    fn cameras_walk_as_their_bodies_did_whatever_axis_was_up() {
        let y_down = from_columns([0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
        let y_up = from_columns([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        for (world_from_odom, said) in [(UnitQuaternion::identity(), "z up"), (y_down, "y down"), (y_up, "y up")] {
            let (bodies, poses) = camera_poses(world_from_odom);
            let mut notes = Vec::new();
            let (got, turned) = body_from_camera(&poses, &mut notes);
            assert_eq!(turned, said != "z up");
            for ((_, got), body) in got.iter().zip(&bodies) {
                let off = got.iso.inverse() * body.iso;
                // Round-off over some 40 m of path.
                assert!(off.translation.vector.norm() < 1e-12 && off.rotation.angle() < 1e-7, "{said}: {got:?} for {body:?}");
            }
            assert!(notes[0].contains(said), "{notes:?}");
        }
    }

    #[test]
    fn a_world_with_no_axis_up_is_levelled() {
        let (_, poses) = camera_poses(UnitQuaternion::from_euler_angles(0.8, 0.3, 0.0));
        let mut notes = Vec::new();
        let (got, turned) = body_from_camera(&poses, &mut notes);
        assert!(turned);
        let up = got.iter().map(|(_, p)| p.iso.rotation * Vector3::z()).sum::<Vector3<f64>>().normalize();
        assert!(up.z > 1.0 - 1e-12, "{up}");
    }

    #[test]
    fn a_cameras_poses_taken_for_a_bodys_are_suspected() {
        let (_, poses) = camera_poses(UnitQuaternion::identity());
        let mut notes = Vec::new();
        note_if_not_upright(&poses, &mut notes);
        assert!(notes[0].contains("--poses-frame camera"), "{notes:?}");
    }
}
