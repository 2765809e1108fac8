//! Where was the camera before the map began? The same odometry, backwards.
//!
//! pictures from the first on to a while after the map's beginning ─▶ a second odometry, last picture first ─▶ its poses, laid over ours
//! where both have a map ─▶ poses of the frames before the first keyframe
//!
//! A map begins where there is parallax. Behind a person, or before a bare wall, that may take seconds in which the walker walks; who
//! comes from the other side brings a map along.

use std::collections::VecDeque;

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{CameraPose, Similarity, Stamp, TrackingState, VideoFrame};

use super::{Stage, VisualOdometry};
use crate::visual::map::{KeyframeId, Pose};

/// Grey values that are kept at most, half of them of before the map's beginning and half of after it: five seconds each of VGA at 30 frames/s.
const MOST_BYTES: usize = 96_000_000;
/// For how long after the beginning pictures are kept, seconds: the map that looks back must begin, and settle, within them. (Over half of
/// it the two maps disagree by a quarter of the way, over all of it mostly by a tenth.)
const AFTER_S: f64 = 3.0;
/// A shorter time before the first keyframe is not worth it, seconds.
const LEAST_S: f64 = 0.2;
/// Fewest frames that both have on their maps, and how far the two may disagree in them, as a share of how far they are spread.
const COMMON: usize = 8;
const MOST_OFF: f64 = 0.3;

/// The newest pictures, until the frames before the first keyframe are posed.
#[derive(Debug, Default)]
pub(super) struct Early {
    frames: VecDeque<VideoFrame>,
}

impl VisualOdometry {
    /// Keeps a picture, as long as there may be need of it.
    pub(super) fn keep_early(&mut self, frame: &VideoFrame) {
        let half = self.most_early();
        let Some(early) = &mut self.early else { return };
        if early.frames.len() >= half && matches!(self.stage, Stage::Beginning(_)) {
            early.frames.pop_front();
        }
        early.frames.push_back(frame.clone());
    }

    /// Pictures that are kept at most of either side of the beginning.
    fn most_early(&self) -> usize {
        MOST_BYTES / 2 / (self.camera.width * self.camera.height).max(1)
    }

    /// Looks back as soon as there is enough of a map to look back from.
    pub(super) fn look_back_in_time(&mut self) {
        let (Some(early), [first, second, ..]) = (&self.early, self.map.keyframes.as_slice()) else { return };
        let (Some(oldest), Some(newest)) = (early.frames.front(), self.posed.last()) else { return };
        let seen_s = newest.stamp.secs_since(second.stamp);
        if first.stamp.secs_since(oldest.stamp) < LEAST_S {
            self.early = None;
        } else if seen_s >= AFTER_S || newest.state == TrackingState::Cut || early.frames.len() >= 2 * self.most_early() {
            self.look_back();
        }
    }

    /// Poses the frames before the first keyframe, if what looks back from after it agrees with what looked ahead.
    pub(super) fn look_back(&mut self) {
        let (Some(early), Some(base)) = (self.early.take(), self.map.keyframes.first().map(|k| k.stamp)) else { return };
        let mut ours = self.placed();
        ours.drain(..ours.len().saturating_sub(early.frames.len()));
        let theirs = self.backwards(early);
        let Some(ours_from_theirs) = laid_over(&ours, &theirs) else { return };
        let keyframe = *self.map.pose(KeyframeId(0));
        // From the first keyframe back, to the oldest picture or to a cut: of what came before only turns are known.
        let mut theirs = theirs.iter().rev().skip_while(|their| their.stamp >= base).take_while(|their| their.state != TrackingState::Cut);
        let mut began = keyframe.translation;
        for posed in self.posed.iter_mut().rev().skip_while(|posed| posed.stamp >= base) {
            let pose = match theirs.next() {
                Some(their) => {
                    (posed.state, posed.inliers) = (their.state, their.inliers);
                    ours_from_theirs.apply(&their.odom_from_camera.iso)
                }
                None => Pose::from_parts(began, posed.reference_from_camera.rotation),
            };
            began = pose.translation;
            (posed.reference, posed.reference_from_camera) = (Some(KeyframeId(0)), keyframe.inverse() * pose);
        }
    }

    /// Poses of the pictures, in their order, by an odometry that saw the last one first.
    fn backwards(&self, early: Early) -> Vec<CameraPose> {
        let mut back = Self { early: None, ..Self::new(self.camera.clone(), self.options) };
        for frame in early.frames.into_iter().rev() {
            // Sizes are one, and stamps that went on go back: nothing is refused, but at the end of time.
            let _ = back.push(&VideoFrame { stamp: Stamp(frame.stamp.0.saturating_neg()), ..frame });
        }
        // The lengths of before the beginning are as sure as those of after it, by which they are laid over ours.
        let up = back.up();
        back.settle(&up);
        let forwards = |pose: CameraPose| CameraPose { stamp: Stamp(pose.stamp.0.saturating_neg()), ..pose };
        back.placed().into_iter().rev().map(forwards).collect()
    }
}

/// What lays their poses over ours where both are on a map; `None` where these are few, or do not go the same way.
fn laid_over(ours: &[CameraPose], theirs: &[CameraPose]) -> Option<Similarity> {
    let mapped = |p: &CameraPose| p.state == TrackingState::Mapped;
    let common: Vec<(Pose, Pose)> = (ours.iter().zip(theirs).filter(|(a, b)| mapped(a) && mapped(b)))
        .map(|(a, b)| (a.odom_from_camera.iso, b.odom_from_camera.iso))
        .collect();
    if common.len() < COMMON || ours.len() != theirs.len() {
        return None;
    }
    let first = common[0].0.rotation * common[0].1.rotation.inverse();
    let off = |(a, b): &(Pose, Pose)| (first.inverse() * a.rotation * b.rotation.inverse()).scaled_axis();
    // Of turns that differ by some degrees.
    let rotation = first * UnitQuaternion::from_scaled_axis(common.iter().map(off).sum::<Vector3<f64>>() / common.len() as f64);
    let mean = |of: fn(&(Pose, Pose)) -> Vector3<f64>| common.iter().map(of).sum::<Vector3<f64>>() / common.len() as f64;
    let (a_mean, b_mean) = (mean(|c| c.0.translation.vector), mean(|c| c.1.translation.vector));
    let pairs = || common.iter().map(|(a, b)| (a.translation.vector - a_mean, rotation * (b.translation.vector - b_mean)));
    let (a_spread, b_spread) = pairs().fold((0.0, 0.0), |sum, (a, b)| (sum.0 + a.norm_squared(), sum.1 + b.norm_squared()));
    let scale = (a_spread / b_spread).sqrt();
    let off: f64 = pairs().map(|(a, b)| (a - b * scale).norm_squared()).sum();
    let agrees = scale.is_finite() && scale > 0.0 && off < MOST_OFF.powi(2) * a_spread;
    agrees.then(|| Similarity { rotation, translation: a_mean - rotation * b_mean * scale, scale })
}

#[cfg(test)]
mod tests {
    use planwalk_sim::Scene;
    use planwalk_types::{Rigid3, Seed};

    use super::*;
    use crate::visual::odometry::OdometryOptions;
    use crate::visual::outcome::FrameQuality;
    use crate::visual::posed::Posed;

    /// Frames of a walk that is under way, and those of them of which nothing is known when the map begins.
    const FRAMES: usize = 90;
    const UNKNOWN: usize = 15;

    #[test]
    fn a_walk_before_its_map_is_found_by_who_comes_from_the_other_side() {
        let scene = Scene::demo(Seed(9));
        let frames: Vec<VideoFrame> = scene.frames().skip(30).take(FRAMES).collect();
        let mut odometry = VisualOdometry::new(scene.camera().clone(), OdometryOptions::default());
        for frame in &frames[..UNKNOWN] {
            odometry.keep_early(frame);
            let Stage::Beginning(beginning) = &mut odometry.stage else { panic!("nothing was followed") };
            assert!(beginning.push(frame.stamp, &[]).is_none());
            let (state, reference_from_camera, quality) = (TrackingState::Propagated, Pose::identity(), FrameQuality::default());
            let posed = Posed {
                stamp: frame.stamp,
                reference: None,
                reference_from_camera,
                state,
                inliers: 0,
                repeat: false,
                quality,
                blind: None,
            };
            odometry.posed.push(posed);
        }
        for frame in &frames[UNKNOWN..] {
            odometry.push(frame).unwrap();
        }
        assert!(odometry.early.is_none(), "no picture is kept for longer than needed");
        let found: Vec<Vector3<f64>> = odometry.placed().iter().map(|p| p.odom_from_camera.origin().coords).collect();
        let truth: Vec<Vector3<f64>> = scene.truth()[30..30 + FRAMES].iter().map(|(_, p)| p.iso.translation.vector).collect();
        let way = |at: &[Vector3<f64>], from: usize, to: usize| (at[to] - at[from]).norm();
        let unit = way(&found, UNKNOWN, FRAMES - 1) / way(&truth, UNKNOWN, FRAMES - 1);
        let (ours, true_way) = (way(&found, 0, UNKNOWN) / unit, way(&truth, 0, UNKNOWN));
        // A second of walking; the two maps' units agree to a tenth.
        assert!(true_way > 0.5 && (ours / true_way - 1.0).abs() < 0.2, "{ours} m for {true_way} m");
        assert!(odometry.posed[..UNKNOWN].iter().all(|p| p.reference == Some(KeyframeId(0)) && p.state == TrackingState::Mapped));
    }

    #[test]
    fn walks_that_do_not_agree_are_not_laid_over_each_other() {
        let pose = |i: usize, x: f64, state| CameraPose {
            stamp: Stamp(i as i64),
            odom_from_camera: Rigid3::new(Pose::translation(x, 0.3 * i as f64, 0.0)),
            state,
            inliers: 50,
        };
        let walk = |x: fn(usize) -> f64, state| -> Vec<CameraPose> { (0..20).map(|i| pose(i, x(i), state)).collect() };
        let ahead = walk(|i| i as f64, TrackingState::Mapped);
        assert!(laid_over(&ahead, &ahead).is_some_and(|s| (s.scale - 1.0).abs() < 1e-9 && s.translation.norm() < 1e-9));
        assert!(laid_over(&ahead, &walk(|i| -(i as f64), TrackingState::Mapped)).is_none(), "the other way");
        assert!(laid_over(&ahead, &walk(|i| i as f64, TrackingState::RotationOnly)).is_none(), "nothing in common");
        let standing: Vec<CameraPose> = (0..20).map(|i| CameraPose { stamp: Stamp(i), ..pose(0, 0.0, TrackingState::Mapped) }).collect();
        assert!(laid_over(&ahead, &standing).is_none(), "a stand has no scale");
    }
}
