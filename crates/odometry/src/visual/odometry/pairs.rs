//! How do keyframes of one window lie against each other, as the points say that both of them saw?
//!
//! window of keyframes, adjusted ─▶ for the one that leaves it: [`WindowPair`] with each later one that sees the same points ─▶ `links`
//!
//! Relative motions of any pairs in the window (Chu 2013, §3.2.1). A chain of neighbours bends alike everywhere; pairs that share
//! points over a whole window keep it stiff where much was seen, so that it bends where little was.

use std::collections::BTreeMap;

use super::VisualOdometry;
use crate::visual::graph::{Edge, EdgeKind, information};
use crate::visual::map::{KeyframeId, Pose};
use planwalk_types::Similarity;

/// Two keyframes of a window, not neighbours, that saw the same points.
#[derive(Debug, Clone, Copy)]
pub(super) struct WindowPair {
    pub a: KeyframeId,
    pub b: KeyframeId,
    /// Points with a distance that both saw.
    pub shared: usize,
    /// Their mean distance from a, a's unit.
    pub far: f64,
}

/// Fewest points that two keyframes share.
const SHARED: usize = 15;
/// Error of a pair: units, and shares of the points' distance and radians, of which n points leave the root of the n-th part.
const PAIR_STILL: f64 = 2e-3;
const PAIR_FAR: f64 = 0.02;
const PAIR_TURN_RAD: f64 = 0.03;
/// Logarithm of the unit's error from one to the other; n points leave the (n + 1)th part.
const PAIR_UNIT: f64 = 0.5;

impl WindowPair {
    /// What the pair says, if its points put a and b here.
    pub(super) fn edge(&self, a: &Pose, b: &Pose) -> Edge {
        let root = (self.shared as f64).sqrt();
        let sigma_move = PAIR_STILL + PAIR_FAR * self.far / root;
        let information = information(sigma_move, PAIR_TURN_RAD, PAIR_UNIT / (self.shared + 1) as f64);
        Edge { a: self.a, b: self.b, a_from_b: Similarity::from(&(a.inverse() * b)), information, kind: EdgeKind::Pair }
    }
}

impl VisualOdometry {
    /// Notes how the keyframe that the window has just left lies against the others, neighbours aside.
    pub(super) fn pair_up(&mut self, newest: KeyframeId) {
        if let Some(leaving) = newest.0.checked_sub(self.options.window) {
            self.pair(KeyframeId(leaving));
        }
    }

    /// The same for all that never left it.
    pub(super) fn pair_up_the_rest(&mut self) {
        let Some(newest) = self.map.newest() else { return };
        for left in (newest.0 + 1).saturating_sub(self.options.window)..newest.0 {
            self.pair(KeyframeId(left));
        }
    }

    fn pair(&mut self, a: KeyframeId) {
        let mut shared: BTreeMap<KeyframeId, Vec<f64>> = BTreeMap::new();
        for landmark in self.map.landmarks.values().filter(|l| l.has_depth() && l.strikes == 0 && l.anchor <= a) {
            if landmark.ray_in(a).is_none() {
                continue;
            }
            let distance = self.map.direction(landmark, self.map.pose(a)).norm() / landmark.rho;
            for (b, _) in landmark.seen.iter().filter(|(b, _)| b.0 > a.0 + 1) {
                shared.entry(*b).or_default().push(distance);
            }
        }
        for (b, distances) in shared.into_iter().filter(|(_, distances)| distances.len() >= SHARED) {
            let far = distances.iter().sum::<f64>() / distances.len() as f64;
            self.window_pairs.push(WindowPair { a, b, shared: distances.len(), far });
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};
    use planwalk_types::{Camera, Stamp};

    use super::*;
    use crate::visual::map::{Keyframe, Landmark, direction};
    use crate::visual::odometry::OdometryOptions;
    use crate::visual::track::TrackId;

    /// Keyframes a tenth of a unit apart, and points of which each is seen in these keyframes.
    fn walk(keyframes: usize, points: usize, seen_in: impl Fn(usize, usize) -> bool) -> VisualOdometry {
        let mut odometry = VisualOdometry::new(Camera::phone_prior(640, 480), OdometryOptions::default());
        for k in 0..keyframes {
            let pose = Pose::translation(0.0, 0.0, 0.1 * k as f64);
            odometry.map.keyframes.push(Keyframe { stamp: Stamp(k as i64), pose, turn: UnitQuaternion::identity(), fix: None });
        }
        for i in 0..points {
            let seen: Vec<KeyframeId> = (0..keyframes).filter(|k| seen_in(i, *k)).map(KeyframeId).collect();
            let [anchor, later @ ..] = seen.as_slice() else { continue };
            let (ray, rho) = (Vector3::new(0.01 * i as f64, 0.1, 1.0).normalize(), 0.25);
            let ray_in = |k: &KeyframeId| direction(odometry.map.pose(*anchor), &ray, rho, odometry.map.pose(*k)).normalize();
            let seen = later.iter().map(|k| (*k, ray_in(k))).collect();
            let landmark = Landmark { anchor: *anchor, ray, rho, sigma_rho: 0.01, born: (rho, 1.0), prior: (rho, 1.0), seen, strikes: 0 };
            odometry.map.landmarks.insert(TrackId(i as u64), landmark);
        }
        odometry
    }

    #[test]
    fn the_keyframe_that_leaves_is_paired_with_all_that_share_enough_points() {
        // Twenty points are seen up to keyframe 5, thirty others up to keyframe 3.
        let mut odometry = walk(9, 50, |point, k| k <= if point < 20 { 5 } else { 3 });
        odometry.pair_up(KeyframeId(7));
        assert!(odometry.window_pairs.is_empty(), "the window of eight has all of them");
        odometry.pair_up(KeyframeId(8));
        let found: Vec<(usize, usize, usize)> = odometry.window_pairs.iter().map(|p| (p.a.0, p.b.0, p.shared)).collect();
        assert_eq!(found, [(0, 2, 50), (0, 3, 50), (0, 4, 20), (0, 5, 20)]);
        assert!(odometry.window_pairs.iter().all(|p| (p.far - 4.0).abs() < 1e-9), "all of them are four units away");
        odometry.pair_up_the_rest();
        assert!(odometry.window_pairs.iter().all(|p| p.b.0 > p.a.0 + 1 && p.b.0 <= 5));
        assert_eq!(odometry.window_pairs.len(), 4 + 3 + 2 + 1, "from 1, 2, and 3 too, each pair once");
    }

    #[test]
    fn what_few_points_join_is_no_pair() {
        let mut odometry = walk(9, SHARED - 1, |_, _| true);
        odometry.pair_up_the_rest();
        assert!(odometry.window_pairs.is_empty());
    }

    #[test]
    fn more_points_make_a_pair_stiffer() {
        let (a, b) = (Pose::identity(), Pose::translation(0.0, 0.0, 0.4));
        let pair = |shared| WindowPair { a: KeyframeId(0), b: KeyframeId(4), shared, far: 4.0 }.edge(&a, &b);
        let (few, many) = (pair(16), pair(64));
        assert!((0..7).all(|i| many.information[(i, i)] >= few.information[(i, i)]));
        // 2 mm and 2 % of four units by the root of sixteen.
        assert!((few.information[(0, 0)].powf(-0.5) - 0.022).abs() < 1e-9, "{}", few.information[(0, 0)].powf(-0.5));
        assert_eq!(few.a_from_b.translation.z, 0.4);
    }
}
