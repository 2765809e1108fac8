//! Does the walker stand? Where nothing in view moves but by a turn, for a quarter of a second, he does.
//!
//! A view without known distances cannot tell a walk from standing before something far; but indoors nothing is that far, and a person
//! who crossed the picture leaves the speed that was read off him.

use nalgebra::Vector3;
use planwalk_types::Stamp;

use super::{Stage, VisualOdometry};
use crate::visual::map::pose;
use crate::visual::track::Track;
use crate::visual::two_view::{RayPair, RotationOptions, estimate_rotation};

/// For how long a view must stay, seconds.
const STANDS_S: f64 = 0.25;
/// How many points must be in it, by how many of their standard deviations they may stray, and which share of them must not: the others
/// are people.
const STANDS_POINTS: usize = 20;
const STANDS_SIGMAS: f64 = 0.5;
const STANDS_SHARE: f64 = 0.6;
/// Share of the usual freedom of position that is left to one who stands.
const STAYS: f64 = 0.1;

impl VisualOdometry {
    /// Whether all that is in view stays where it was but for a turn.
    pub(super) fn stands(&self, stamp: Stamp) -> bool {
        let Some((_, then)) = self.recent.front().filter(|(then, _)| stamp.secs_since(*then) >= STANDS_S) else { return false };
        let pair = |t: &Track| Some(RayPair { a: *then.get(&t.id)?, b: t.ray });
        let pairs: Vec<RayPair> = self.tracker.tracks().iter().filter_map(pair).collect();
        if pairs.len() < STANDS_POINTS {
            return false;
        }
        let options = RotationOptions { max_angle_rad: STANDS_SIGMAS * self.sigma_rad(), ..RotationOptions::default() };
        let fit = estimate_rotation(&pairs, &options, &mut self.options.seed.derive("stands", self.posed.len() as u64));
        let still = fit.map_or(0, |fit| fit.inliers.iter().filter(|i| **i).count());
        still as f64 > STANDS_SHARE * pairs.len() as f64
    }

    /// Whoever stands is where he was.
    pub(super) fn stand(&mut self, prior: &mut pose::PosePrior) {
        let Stage::Tracking(motion) = &mut self.stage else { return };
        motion.velocity = Vector3::zeros();
        prior.pose.translation = motion.pose.translation;
        prior.sigma_move *= STAYS;
    }

    /// Keeps where the points are now, and forgets all but one of the frames that are old enough to be compared with.
    pub(super) fn remember_rays(&mut self, stamp: Stamp) {
        self.recent.push_back((stamp, self.tracker.tracks().iter().map(|t| (t.id, t.ray)).collect()));
        while self.recent.get(1).is_some_and(|(then, _)| stamp.secs_since(*then) >= STANDS_S) {
            self.recent.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use planwalk_sim::Scene;
    use planwalk_types::{GrayImage, Seed, VideoFrame};
    use rand::RngExt;

    use super::*;
    use crate::visual::odometry::OdometryOptions;

    #[test]
    fn who_walks_does_not_stand_and_who_stands_does() {
        let scene = Scene::demo(Seed(9));
        let mut odometry = VisualOdometry::new(scene.camera().clone(), OdometryOptions::default());
        let truth = scene.truth();
        let speed = |i: usize| (truth[i].1.iso.translation.vector - truth[i - 1].1.iso.translation.vector).norm() * 15.0;
        let mut last = None;
        for (i, frame) in scene.frames().take(50).enumerate() {
            odometry.push(&frame).unwrap();
            assert!(i == 0 || speed(i) < 0.3 || !odometry.stands(frame.stamp), "frame {i} at {} m/s", speed(i));
            last = Some(frame);
        }
        // The same view for a second, with a sensor's noise of its own each time: σ = 3 grey values.
        let (last, mut noise) = (last.expect("fifty frames"), Seed(1).derive("noise", 0));
        let mut stood = 0;
        for i in 50..65 {
            let (width, height) = (last.image.width(), last.image.height());
            let image = GrayImage::from_fn(width, height, |u, v| {
                (f64::from(last.image.row(v)[u]) + noise.random_range(-5.0..5.0)).clamp(0.0, 255.0) as u8
            });
            let frame = VideoFrame { stamp: scene.stamp(i), image };
            odometry.push(&frame).unwrap();
            stood += usize::from(odometry.stands(frame.stamp));
        }
        // A quarter of a second of it must be seen first.
        assert!(stood >= 9, "{stood} of 15 frames");
    }
}
