//! How long is a unit here, if the eyes are as high over the floor, and as far under the ceiling, as elsewhere?
//!
//! points seen around each keyframe ─▶ heights that most of them share, [`Yardstick`]s ─▶ an [`Edge`] for each, for `links`
//!
//! While it walks, odometry asks the floor only where all points with a distance were lost (`unit`), for a floor that is asked all the
//! time bends the map. Over the whole walk each moment's floor is one measure among others, and what creeps between two of them is
//! shared out (Song & Chandraker 2014 correct frame by frame).
//!
//! Pitfall: a table is no floor, and another room's ceiling is another height: such an edge lies, and is doubted.

use std::ops::Range;

use nalgebra::Vector3;

use super::VisualOdometry;
use super::yardstick::{Yardstick, around, edges};
use crate::visual::graph::{Edge, EdgeKind};
use crate::visual::map::KeyframeId;
use crate::visual::map::planes::{LEAST_SINE, SharedHeight, shared_height};
use crate::visual::two_view::rotation::median;

/// Half of the time over which points are gathered, seconds: within it the unit is one.
const AROUND_S: f64 = 0.35;
/// Fewest points under, or over, the camera.
const ENOUGH: f64 = 20.0;
/// Most points beyond a level, as a share of all: under a floor there is nothing but errors.
const MOST_BEYOND: f64 = 0.05;

/// A kind of level.
struct Level {
    /// +1 over the camera, −1 under it.
    side: f64,
    /// Least share of the points on that side that lie on it.
    share: f64,
    /// Logarithm of the camera's distance from it, one standard deviation.
    sigma: f64,
}

/// Much stands on floors; eyes go up and down by 5 % of their height, and gravity errs.
const FLOOR: Level = Level { side: -1.0, share: 0.3, sigma: 0.08 };
/// Little hangs from ceilings, so that what few points share there is the top of a shelf; and not all rooms are alike.
const CEILING: Level = Level { side: 1.0, share: 0.6, sigma: 0.15 };

impl VisualOdometry {
    /// What the floor and the ceiling say of the unit of each keyframe, `up` being where it is in odom.
    pub(super) fn level_edges(&self, up: &Vector3<f64>) -> Vec<Edge> {
        let seen = self.seen_from(up);
        [FLOOR, CEILING].iter().flat_map(|level| self.edges_of(level, &seen)).collect()
    }

    fn edges_of(&self, level: &Level, seen: &[Vec<(f64, f64)>]) -> Vec<Edge> {
        let of = |k: usize| {
            let near = around(&self.map.keyframes, k, AROUND_S);
            let length = clear_height(level, seen, &near)?;
            Some(Yardstick { keyframe: KeyframeId(k), length, shared: near.len() })
        };
        let heights: Vec<Yardstick> = (0..seen.len()).filter_map(of).collect();
        let usual = median(heights.iter().map(|h| h.length).collect());
        edges(&heights, usual, |_| level.sigma, EdgeKind::Level)
    }

    /// Points seen from each keyframe, not near the horizon: height over the camera, units, and its relative standard deviation.
    fn seen_from(&self, up: &Vector3<f64>) -> Vec<Vec<(f64, f64)>> {
        let keyframes = &self.map.keyframes;
        let mut seen = vec![Vec::new(); keyframes.len()];
        for s in &self.seen_points {
            let Ok(at) = keyframes.binary_search_by_key(&s.stamp, |k| k.stamp) else { continue };
            let (height, distance) = (up.dot(&(keyframes[at].pose.rotation * s.point)), s.point.norm());
            if height.abs() > LEAST_SINE * distance {
                seen[at].push((height, s.sigma / distance));
            }
        }
        seen
    }
}

/// How far most points around a keyframe are under, or over, the camera, if that is clear.
fn clear_height(level: &Level, seen: &[Vec<(f64, f64)>], near: &Range<usize>) -> Option<f64> {
    let side = seen[near.clone()].iter().flatten().filter(|(height, _)| height * level.side > 0.0);
    let SharedHeight { height, points, of, beyond } = shared_height(side.map(|(height, relative)| (height.abs(), *relative)))?;
    (of >= ENOUGH && points >= level.share * of && beyond < MOST_BEYOND * of).then_some(height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ground::SeenPoint;
    use crate::visual::odometry::walks::{straight, up, way};

    /// Six points a keyframe on a level so far over the camera, in a stretch whose unit is `factor` times as long.
    fn see(odometry: &mut VisualOdometry, keyframes: Range<usize>, over: f64, factor: f64) {
        for keyframe in &odometry.map.keyframes[keyframes] {
            for i in 0..6 {
                let point = Vector3::new(f64::from(i) - 2.5, -over, 3.0) * factor;
                odometry.seen_points.push(SeenPoint { stamp: keyframe.stamp, point, sigma: 0.03 * point.norm() });
            }
        }
        odometry.seen_points.sort_by_key(|s| s.stamp);
    }

    /// From 8 s to 12 s lengths are longer by this factor, and few points hold the unit there.
    fn creeping(factor: f64) -> VisualOdometry {
        let speed = |t: f64| if (8.0..12.0).contains(&t) { factor } else { 1.0 };
        straight(speed, |k| if (60..100).contains(&k) { 12 } else { 60 })
    }

    /// Speeds in that stretch and before it.
    fn speeds(odometry: &VisualOdometry) -> (f64, f64) {
        (way(odometry, 68, 92) / 3.0, way(odometry, 8, 56) / 6.0)
    }

    #[test]
    fn a_stretch_from_which_the_floor_seems_farther_is_made_as_long_as_the_others() {
        for over in [-1.5, 1.2] {
            let mut odometry = creeping(1.3);
            for (stretch, factor) in [(0..64, 1.0), (64..96, 1.3), (96..160, 1.0)] {
                see(&mut odometry, stretch, over, factor);
            }
            odometry.close_links(&up());
            let (there, before) = speeds(&odometry);
            // Four seconds of floor know the unit to 0.08 · √(6/32) = 3.5 %, of ceiling to 6.5 %; twelve points hand it on to 8 % each.
            assert!((there / before - 1.0).abs() < 0.1, "{over} over the camera: {there} against {before} units a second");
        }
    }

    #[test]
    fn a_table_is_not_believed_against_what_points_say() {
        let mut odometry = straight(|_| 1.0, |_| 60);
        for (stretch, over) in [(0..64, -1.5), (64..80, -0.5), (80..160, -1.5)] {
            see(&mut odometry, stretch, over, 1.0);
        }
        odometry.close_links(&up());
        let (there, before) = (way(&odometry, 64, 80) / 2.0, way(&odometry, 8, 56) / 6.0);
        // Sixty points hand on the unit to 1.6 % a keyframe; a third of the height is 13 sigma off.
        assert!((there / before - 1.0).abs() < 0.1, "{there} against {before} units a second");
    }

    #[test]
    fn what_is_not_clear_says_nothing() {
        let few = straight(|_| 1.0, |_| 60);
        assert!(few.level_edges(&up()).is_empty(), "nothing was seen");
        let mut two = straight(|_| 1.0, |_| 60);
        see(&mut two, 0..160, -0.8, 1.0);
        see(&mut two, 0..160, -1.5, 1.0);
        assert!(two.level_edges(&up()).iter().all(|e| (e.a_from_b.scale - 1.0).abs() < 0.05), "of a table and a floor the floor is meant");
        let mut mixed = straight(|_| 1.0, |_| 60);
        for (i, over) in [0.5, 0.7, 0.9, 1.2].into_iter().enumerate() {
            see(&mut mixed, i..160, over, 1.0);
        }
        assert!(mixed.level_edges(&up()).is_empty(), "shelves are no ceiling");
    }
}
