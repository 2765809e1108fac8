//! Walks of keyframes alone, for tests of what evens out the unit of length.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Camera, Stamp};

use super::links::Passage;
use super::pairs::WindowPair;
use super::{OdometryOptions, VisualOdometry};
use crate::visual::map::{Keyframe, KeyframeId, Pose};
use crate::visual::recall::Odometer;

/// Fewest points of a pair, and how far away they are, units.
const PAIRED: usize = 15;
const FAR: f64 = 4.0;

/// Twenty seconds straight ahead, eight keyframes a second, at these speeds; so many points join each keyframe with the one before. From
/// one keyframe to the next the camera sees an eighth of its points for the last time.
pub fn straight(speed: impl Fn(f64) -> f64, known: impl Fn(usize) -> usize) -> VisualOdometry {
    let mut odometry = VisualOdometry::new(Camera::phone_prior(640, 480), OdometryOptions::default());
    let mut ahead = 0.0;
    for k in 0..160 {
        ahead += speed(k as f64 / 8.0) / 8.0;
        let (stamp, pose) = (Stamp(k as i64 * 125_000_000), Pose::translation(0.0, 0.0, ahead));
        odometry.map.keyframes.push(Keyframe { stamp, pose, turn: UnitQuaternion::identity(), fix: None });
        let odometer = Odometer { way: ahead, ..Odometer::default() };
        odometry.passages.push(Passage { odometer, known: known(k), reached: None });
    }
    let window = odometry.options.window;
    let pairs = (0..160usize).flat_map(|a| (a + 2..(a + window).min(160)).map(move |b| (a, b)));
    let shared = |a: usize, b: usize| (a + 1..=b).map(&known).min().unwrap_or(0) * (window + 1 + a - b) / window;
    let pair = |(a, b)| WindowPair { a: KeyframeId(a), b: KeyframeId(b), shared: shared(a, b), far: FAR };
    odometry.window_pairs = pairs.map(pair).filter(|pair| pair.shared >= PAIRED).collect();
    odometry
}

/// Up in odom: pictures' y goes down.
pub fn up() -> Vector3<f64> {
    -Vector3::y()
}

/// Length of the walk between two keyframes.
pub fn way(odometry: &VisualOdometry, from: usize, to: usize) -> f64 {
    (odometry.map.pose(KeyframeId(to)).translation.vector - odometry.map.pose(KeyframeId(from)).translation.vector).norm()
}
