//! How did the body move on the floor, and what stood around it? From camera poses in space to a path and sightings.
//!
//! camera poses ─▶ [`up`], [`level`] (gravity) ─▶ [`path`] (forward, left, turn) and [`sightings`] (bearing, range)
//!
//! The body looks where the camera looks: its heading is the optical axis on the floor.

use crate::upright::Upright;
use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector3};
use planwalk_types::{CameraPose, Path, Rigid3, Sighting, Stamp, Step, TrackingState, wrap_angle};

/// A point of the map as seen from a keyframe.
#[derive(Debug, Clone, Copy)]
pub struct SeenPoint {
    /// When the keyframe was taken.
    pub stamp: Stamp,
    /// Camera frame, units.
    pub point: Vector3<f64>,
    /// Standard deviation of its distance, units.
    pub sigma: f64,
}

impl SeenPoint {
    /// The same with lengths times `scale`.
    pub fn scaled(&self, scale: f64) -> Self {
        Self { point: self.point * scale, sigma: self.sigma * scale, ..*self }
    }
}

/// Length of the chords whose slope is looked at, units.
const CHORD: f64 = 2.0;

/// Up as people hold cameras and walk ([`Upright`]), over a whole clip.
pub fn up(poses: &[CameraPose]) -> Vector3<f64> {
    let mut upright = Upright::default();
    let share = 1.0 / poses.len().max(1) as f64;
    poses.iter().for_each(|pose| upright.add_camera(&pose.odom_from_camera.iso.rotation, share));
    let chords = chords(poses);
    chords.iter().for_each(|chord| upright.add_way(chord, 1.0 / chords.len() as f64));
    upright.up()
}

/// The rotation that makes the unit vector `up` z and puts x where the first camera looks.
pub fn level(poses: &[CameraPose], up: &Vector3<f64>) -> UnitQuaternion<f64> {
    let ahead = poses.first().map_or(Vector3::z(), |p| p.odom_from_camera.iso.rotation * Vector3::z());
    let forward = ahead - up * ahead.dot(up);
    // A first look straight up or down has no heading; any will do.
    let forward = forward.try_normalize(1e-6).unwrap_or_else(|| crate::visual::two_view::epipolar::tangent_basis(up).0);
    let rows = Matrix3::from_rows(&[forward.transpose(), up.cross(&forward).transpose(), up.transpose()]);
    UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(rows))
}

/// Unit directions between positions at least [`CHORD`] apart.
fn chords(poses: &[CameraPose]) -> Vec<Vector3<f64>> {
    let mut chords = Vec::new();
    let Some(first) = poses.first() else { return chords };
    let mut from = first.odom_from_camera.origin().coords;
    for pose in poses {
        let way = pose.odom_from_camera.origin().coords - from;
        if way.norm() > CHORD {
            chords.push(way.normalize());
            from += way;
        }
    }
    chords
}

/// The poses in the levelled frame, whose origin is the first camera, with lengths times `scale`.
pub fn levelled(poses: &[CameraPose], level: &UnitQuaternion<f64>, scale: f64) -> Vec<CameraPose> {
    let origin = poses.first().map_or_else(Vector3::zeros, |p| p.odom_from_camera.origin().coords);
    let turn = |pose: &CameraPose| {
        let iso = pose.odom_from_camera.iso;
        Rigid3::new(Isometry3::from_parts((level * (iso.translation.vector - origin) * scale).into(), level * iso.rotation))
    };
    poses.iter().map(|p| CameraPose { odom_from_camera: turn(p), ..p.clone() }).collect()
}

/// Heading of the optical axis on the floor, or `None` when it is vertical.
fn heading(pose: &CameraPose) -> Option<f64> {
    let ahead = pose.odom_from_camera.iso.rotation * Vector3::z();
    (ahead.x.hypot(ahead.y) > 0.05).then(|| libm::atan2(ahead.y, ahead.x))
}

/// Length noise of the odometry: its scale walks by this share over one unit.
const LENGTH_WALK: f64 = 0.05;
/// Heading noise over one unit walked: 0.7°.
const TURN_WALK_RAD: f64 = 0.012;
/// Heading noise of a turn, as a share of it: an error of the focal length scales every turn.
const TURN_SHARE: f64 = 0.03;

/// Map points under which a pose holds, but its unit of length may slip, and the share of a step that it is then off.
const SURE_INLIERS: usize = 30;
const UNSURE_SHARE: f64 = 0.1;
/// How fast the unit of length is lost while nothing with a known distance is seen: logarithm per √s. In half a second in
/// front of a blank wall a walk may halve its speed, and the map that is built afterwards believes the old one.
const UNIT_RATE: f64 = 0.6;

/// How far a walk goes while nobody films: units, one standard deviation; and how much the unit differs after it, logarithm.
const CUT_UNITS: f64 = 10.0;
const CUT_UNIT_CHANGE: f64 = 0.3;

/// How fast it wanders while many points are seen: the floor holds it to some 5 %, for which the camera sways and gravity errs.
const UNIT_WANDER: f64 = 0.03;

/// How a camera turns while nothing at all is seen: 40°/s to one side for a third of a second, then to and fro. Measured on 98 gaps of
/// 35 runs: half are within 2° after 0.14 s, 12° after 0.26 s, 11° after half a second, two in three within 6°, 14°, and 20°.
const BLIND_TURN_RAD_S: f64 = 0.7;
const ONE_WAY_S: f64 = 0.3;
/// How well a turn is known that few points, or the picture as a whole, tell: 3.4° per √s (480 such stretches).
const ROTATION_ONLY_TURN: f64 = 0.06;
/// Shares of the way that a walk goes on by itself which it is off, across a whole gap: with nothing in view, and with a view that
/// turns only.
const BLIND_SHARE: f64 = 0.8;
const ROTATION_ONLY_SHARE: f64 = 0.4;

/// For how long, and how far, a walk has gone on without measuring where: its errors over a gap are of one piece, so that variances
/// grow with the square of it, and are the same however many frames there are.
#[derive(Debug, Clone, Copy, Default)]
struct Unmeasured {
    /// Seconds in which nothing said how the camera turned.
    blind_s: f64,
    way: f64,
}

impl Unmeasured {
    /// Goes on by a step, seen as badly as this; returns the variances of its length and of its turn.
    fn go(&mut self, state: TrackingState, seconds: f64, length: f64) -> (f64, f64) {
        let before = *self;
        let share = match state {
            TrackingState::Mapped | TrackingState::Cut => {
                *self = Self::default();
                return (0.0, 0.0);
            }
            TrackingState::RotationOnly => ROTATION_ONLY_SHARE,
            TrackingState::Propagated => BLIND_SHARE,
        };
        let blind = state == TrackingState::Propagated;
        *self = Self { blind_s: if blind { before.blind_s + seconds } else { 0.0 }, way: before.way + length };
        let turned = |blind_s: f64| BLIND_TURN_RAD_S.powi(2) * blind_s * blind_s.min(ONE_WAY_S);
        let turn = if blind { turned(self.blind_s) - turned(before.blind_s) } else { ROTATION_ONLY_TURN.powi(2) * seconds };
        (share * share * (self.way.powi(2) - before.way.powi(2)), turn)
    }
}

/// Levelled poses as steps on the floor, with covariance; in frames that saw little, the covariance says so.
pub fn path(poses: &[CameraPose]) -> Path {
    let mut last_heading = poses.iter().find_map(heading).unwrap_or(0.0);
    let headings: Vec<f64> = poses
        .iter()
        .map(|p| {
            last_heading = heading(p).unwrap_or(last_heading);
            last_heading
        })
        .collect();
    let mut unmeasured = Unmeasured::default();
    let pairs = poses.windows(2).zip(headings.windows(2));
    Path { steps: pairs.map(|(pair, headings)| step(&pair[0], &pair[1], headings[0], headings[1], &mut unmeasured)).collect() }
}

fn step(from: &CameraPose, to: &CameraPose, heading_rad: f64, next_rad: f64, unmeasured: &mut Unmeasured) -> Step {
    let way = to.odom_from_camera.origin().coords - from.odom_from_camera.origin().coords;
    let (s, c) = libm::sincos(heading_rad);
    let (forward, left) = (c * way.x + s * way.y, c * way.y - s * way.x);
    let turn_rad = wrap_angle(next_rad - heading_rad);
    let length = forward.hypot(left);
    let seconds = to.stamp.secs_since(from.stamp);
    // The step out of a gap is as little known as those in it.
    let state = if to.state == TrackingState::Mapped { from.state } else { to.state };
    let (gap_length, gap_turn) = unmeasured.go(state, seconds, length);
    let (share, unit_rate) = match to.state {
        TrackingState::Mapped if to.inliers >= SURE_INLIERS => (0.0, UNIT_WANDER),
        TrackingState::Mapped => (UNSURE_SHARE, UNIT_RATE / 2.0),
        TrackingState::RotationOnly | TrackingState::Propagated => (0.0, UNIT_RATE),
        TrackingState::Cut => return cut(from.stamp, to.stamp),
    };
    let along = LENGTH_WALK.powi(2) * length + (share * length).powi(2) + gap_length;
    let turn = TURN_WALK_RAD.powi(2) * length + (TURN_SHARE * turn_rad).powi(2) + gap_turn;
    let covariance = Matrix3::from_diagonal(&Vector3::new(along, 0.5 * along, turn));
    Step { from: from.stamp, to: to.stamp, forward, left, turn_rad, covariance, unit_change: unit_rate * seconds.sqrt() }
}

/// A step over a cut: nobody knows how far, where to, or in what unit.
fn cut(from: Stamp, to: Stamp) -> Step {
    let covariance = Matrix3::from_diagonal(&Vector3::new(CUT_UNITS.powi(2), CUT_UNITS.powi(2), std::f64::consts::PI.powi(2)));
    Step { from, to, forward: 0.0, left: 0.0, turn_rad: 0.0, covariance, unit_change: CUT_UNIT_CHANGE }
}

/// Points between floor and ceiling as bearings and ranges on the floor.
///
/// The floor is found as the height under which hardly any point lies; without one (no floor in view) only points within
/// ±15° of level are taken.
pub fn sightings(seen: &[(&CameraPose, SeenPoint)]) -> Vec<Sighting> {
    let level = |pose: &CameraPose, point: &Vector3<f64>| pose.odom_from_camera.iso.rotation * point;
    let floor = floor_below(seen.iter().map(|(pose, s)| level(pose, &s.point)));
    let sighting = |(pose, s): &(&CameraPose, SeenPoint)| {
        let offset = level(pose, &s.point);
        let range = offset.x.hypot(offset.y);
        let stands = match floor {
            // A fifth of the camera's height above the floor, and not over the ceiling's edge: lamps are no walls.
            Some(height) => offset.z > -0.8 * height && offset.z < 0.55 * height,
            None => offset.z.abs() < 0.27 * range,
        };
        let bearing_rad = wrap_angle(libm::atan2(offset.y, offset.x) - heading(pose)?);
        let near = range > 1e-3 && range < 40.0;
        (stands && near).then(|| Sighting { stamp: s.stamp, bearing_rad, range, sigma: s.sigma.max(0.01 * range) })
    };
    seen.iter().filter_map(sighting).collect()
}

/// Height of the camera over the floor: where the points below the camera are densest at the bottom; `None` if few are low.
pub fn floor_below(offsets: impl Iterator<Item = Vector3<f64>>) -> Option<f64> {
    let mut below: Vec<f64> = offsets.filter(|o| o.z < -0.3 * o.x.hypot(o.y)).map(|o| -o.z).collect();
    if below.len() < 30 {
        return None;
    }
    below.sort_by(f64::total_cmp);
    // Reflections on a polished floor lie under it: the upper quartile of what is seen steeply below is floor.
    Some(below[below.len() * 3 / 4])
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Cam, Odom};

    /// A camera that walks an L at height 0, pitched 10° down, in a frame that is itself tilted.
    fn walk(tilt: &UnitQuaternion<f64>) -> Vec<CameraPose> {
        let optical = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
        let optical = UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(optical));
        (0..80)
            .map(|i| {
                let i = f64::from(i);
                let (x, y, yaw) = if i < 40.0 { (0.1 * i, 0.0, 0.0) } else { (4.0, 0.1 * (i - 40.0), std::f64::consts::FRAC_PI_2) };
                let body = UnitQuaternion::from_euler_angles(0.0, 0.17, yaw);
                let pose = Isometry3::from_parts((tilt * Vector3::new(x, y, 0.0)).into(), tilt * body * optical);
                let odom_from_camera = Rigid3::<Odom, Cam>::new(pose);
                CameraPose { stamp: Stamp((i * 1e8) as i64), odom_from_camera, state: TrackingState::Mapped, inliers: 50 }
            })
            .collect()
    }

    #[test]
    fn a_tilted_walk_is_levelled_and_keeps_its_shape() {
        let poses = walk(&UnitQuaternion::from_euler_angles(0.4, -0.7, 2.0));
        let flat = levelled(&poses, &level(&poses, &up(&poses)), 1.0);
        // The 10° of pitch pull gravity by (0.05/0.25)² of it against roll and slope: under 0.5°, 3 cm over 4 units.
        assert!(flat.iter().all(|p| p.odom_from_camera.origin().coords.z.abs() < 0.05), "{:?}", flat[79]);
        let path = path(&flat);
        let end = path.poses()[79];
        assert!((end.x - 4.0).abs() < 0.05 && (end.y - 3.9).abs() < 0.05, "{end:?}");
        assert!((end.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 0.02, "{end:?}");
    }

    #[test]
    fn a_point_at_the_left_is_seen_at_the_left() {
        let poses = walk(&UnitQuaternion::identity());
        // Camera frame: x right, z forward; 3 ahead, 3 left, level with the camera after the pitch.
        let pitch = UnitQuaternion::from_euler_angles(0.17, 0.0, 0.0);
        let point = pitch * Vector3::new(-3.0, 0.0, 3.0);
        let seen = [(&poses[0], SeenPoint { stamp: poses[0].stamp, point, sigma: 0.1 })];
        let found = sightings(&seen);
        assert_eq!(found.len(), 1);
        assert!((found[0].bearing_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-9, "{:?}", found[0]);
        assert!((found[0].range - 18f64.sqrt()).abs() < 1e-9, "{:?}", found[0]);
    }

    #[test]
    fn points_on_the_floor_are_no_sightings() {
        let poses = walk(&UnitQuaternion::identity());
        let point = |ahead: f64, up: f64| {
            let camera_from_body = poses[0].odom_from_camera.iso.rotation.inverse();
            camera_from_body * Vector3::new(ahead, 0.1, up)
        };
        let mut seen: Vec<_> =
            (0..60).map(|i| SeenPoint { stamp: poses[0].stamp, point: point(2.0 + 0.02 * f64::from(i), -1.4), sigma: 0.1 }).collect();
        seen.push(SeenPoint { stamp: poses[0].stamp, point: point(3.0, -0.5), sigma: 0.1 });
        let found = sightings(&seen.iter().map(|s| (&poses[0], *s)).collect::<Vec<_>>());
        assert_eq!(found.len(), 1, "{found:?}");
        assert!((found[0].range - 3.0f64.hypot(0.1)).abs() < 1e-9);
    }

    #[test]
    fn steps_that_saw_nothing_are_less_sure() {
        let mut poses = walk(&UnitQuaternion::identity());
        poses[10].state = TrackingState::Propagated;
        let path = path(&poses);
        assert!(path.steps[9].covariance[(2, 2)] > 10.0 * path.steps[8].covariance[(2, 2)]);
        assert!(path.steps[9].covariance[(0, 0)] > 2.0 * path.steps[8].covariance[(0, 0)]);
        assert!(path.steps[10].covariance[(2, 2)] > path.steps[9].covariance[(2, 2)], "the way out of the gap is part of it");
        assert!((path.steps[11].covariance - path.steps[8].covariance).norm() < 1e-12, "then all is known again");
    }

    #[test]
    fn a_gap_costs_the_same_at_any_rate_of_frames() {
        use TrackingState::{Mapped, Propagated, RotationOnly};
        // A unit and a half a second, of which nothing, or only how it turns, is measured from 1 s to 1.6 s.
        let cost = |per_second: i64, state: TrackingState| {
            let pose = |i: i64| {
                let t = i as f64 / per_second as f64;
                let state = if t > 1.0 && t < 1.6 { state } else { Mapped };
                let pose = Isometry3::translation(1.5 * t, 0.0, 0.0);
                CameraPose { stamp: Stamp(i * 1_000_000_000 / per_second), odom_from_camera: Rigid3::new(pose), state, inliers: 50 }
            };
            let steps = path(&(0..2 * per_second).map(pose).collect::<Vec<_>>()).steps;
            steps.iter().fold((0.0, 0.0), |sum, s| (sum.0 + s.covariance[(0, 0)], sum.1 + s.covariance[(2, 2)]))
        };
        for state in [Propagated, RotationOnly] {
            let (slow, fast) = (cost(10, state), cost(60, state));
            // The gap begins and ends with a frame: up to a tenth of a second longer or shorter; a third of it in squares.
            assert!((slow.0 / fast.0 - 1.0).abs() < 0.35 && (slow.1 / fast.1 - 1.0).abs() < 0.35, "{state:?}: {slow:?} {fast:?}");
        }
        let blind = cost(30, Propagated);
        // 0.6 s at 40°/s, of which half may go back, and nine tenths of a unit of which the most part may be wrong.
        assert!((blind.1.sqrt() - 0.30).abs() < 0.03 && (blind.0.sqrt() - 0.72).abs() < 0.08, "{blind:?}");
    }
}
