//! How long is a unit here, if people walk here as fast as elsewhere?
//!
//! keyframes ─▶ speed around each, a [`Yardstick`] ─▶ an [`Edge`] for each, for `links`
//!
//! Where all points with a distance were lost, the unit of length may have become another: behind a person who filled the view, or a blank
//! wall. Who walks three times as fast until the next such place does not; who walks half as fast may well. Where points held the unit,
//! they hold it far better than this does, so that a walk that is seen may have any speed. (Hu et al. 2013 take the metres of a whole walk
//! from how people walk; here it is one stretch against the others.)

use super::VisualOdometry;
use super::yardstick::{Yardstick, around, edges};
use crate::visual::graph::{Edge, EdgeKind};
use crate::visual::map::{Keyframe, KeyframeId};
use crate::visual::two_view::rotation::median;

/// Half of the time over which a speed is taken, seconds: a step or two.
const AROUND_S: f64 = 1.0;
/// Logarithm of how much faster, and how much slower, people walk for a second or two than they usually do. While they walk, the logarithm
/// of the speed over two seconds has a standard deviation of 0.10 to 0.34 in 25 simulated walks and of 0.15 to 0.34 in six real ones; who is
/// not at the usual speed is slower, mostly, and is so where he turns.
const FASTER: f64 = 0.1;
const SLOWER: f64 = 0.3;
/// Who is slower than this share of the usual speed stands, or turns on the spot.
const STANDS: f64 = 0.3;

/// Way of the second or two around each keyframe, units a second.
fn paces(keyframes: &[Keyframe]) -> Vec<Yardstick> {
    let around = |k: usize| {
        let near = around(keyframes, k, AROUND_S);
        let (first, last) = (near.start, near.end - 1);
        let way: f64 =
            keyframes[first..=last].windows(2).map(|w| (w[1].pose.translation.vector - w[0].pose.translation.vector).norm()).sum();
        let seconds = keyframes[last].stamp.secs_since(keyframes[first].stamp);
        (seconds > 0.5 * AROUND_S).then(|| Yardstick { keyframe: KeyframeId(k), length: way / seconds, shared: near.len() })
    };
    (0..keyframes.len()).filter_map(around).collect()
}

impl VisualOdometry {
    /// What the usual speed of walking says of the unit of each keyframe against that of one where it was walked at that speed.
    pub(super) fn pace_edges(&self) -> Vec<Edge> {
        let paces = paces(&self.map.keyframes);
        let fast = median(paces.iter().map(|p| p.length).collect());
        let usual = median(paces.iter().map(|p| p.length).filter(|s| *s > STANDS * fast).collect());
        let walking: Vec<Yardstick> = paces.into_iter().filter(|p| p.length > STANDS * usual).collect();
        edges(&walking, usual, |off| if off < 0.0 { FASTER } else { SLOWER }, EdgeKind::Pair)
    }
}

#[cfg(test)]
mod tests {
    use crate::visual::odometry::walks::{straight, up, way};

    #[test]
    fn a_stretch_between_two_losses_of_the_unit_is_walked_at_about_the_usual_speed() {
        // From 8 s to 12 s lengths are three times, or a third of, what they were.
        for factor in [3.0, 1.0 / 3.0] {
            let speed = |t: f64| if (8.0..12.0).contains(&t) { factor } else { 1.0 };
            let lost = |k: usize| if (64..66).contains(&k) || (96..98).contains(&k) { 0 } else { 60 };
            let mut odometry = straight(speed, lost);
            odometry.close_links(&up());
            let found = way(&odometry, 68, 92) / 3.0;
            // Points lost twice at each end leave the unit 1.4 in logarithm; four seconds of hurrying know it to 0.07, of strolling to 0.21:
            // nearly all and most of the factor goes.
            let limit = if factor > 1.0 { 1.4 } else { 2.2 };
            assert!(libm::log(found).abs() < libm::log(limit), "{factor}: {found} units a second");
            assert!((way(&odometry, 8, 56) / 6.0 - 1.0).abs() < 0.05, "what was right stays");
        }
    }

    #[test]
    fn who_is_seen_to_hurry_or_to_stroll_does() {
        let speed = |t: f64| {
            if t < 10.0 {
                1.0
            } else if t < 15.0 {
                1.6
            } else {
                0.5
            }
        };
        let mut odometry = straight(speed, |_| 60);
        odometry.close_links(&up());
        // Sixty points that a whole window saw know the unit to 1 %.
        let speeds = [way(&odometry, 8, 72) / 8.0, way(&odometry, 84, 116) / 4.0, way(&odometry, 124, 156) / 4.0];
        assert!((speeds[1] / speeds[0] / 1.6 - 1.0).abs() < 0.1 && (speeds[2] / speeds[0] / 0.5 - 1.0).abs() < 0.1, "{speeds:?}");
    }

    #[test]
    fn who_stands_says_nothing_of_the_unit() {
        let odometry = straight(|t| if t < 10.0 { 1.0 } else { 0.01 }, |_| 60);
        let edges = odometry.pace_edges();
        assert!(!edges.is_empty() && edges.iter().all(|e| e.b.0 < 88), "from 11 s on nobody walks");
        assert!(straight(|_| 0.0, |_| 60).pace_edges().is_empty(), "nobody walks at all");
    }
}
