//! How does the map begin? Turns until there is parallax; then two keyframes, their points, and the frames between them.

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Stamp, TrackingState};

use super::{OdometryOptions, Stage, VisualOdometry};
use crate::visual::begin::{EarlyFrame, FirstViews};
use crate::visual::map::{self, Keyframe, KeyframeId, Landmark, Pose, pose};
use crate::visual::motion::Motion;
use crate::visual::posed::Posed;
use crate::visual::track::{FEW, TrackId};

impl VisualOdometry {
    /// No map yet: turns are followed; the first parallax begins the map.
    pub(super) fn begin(&mut self, stamp: Stamp) {
        let Stage::Beginning(beginning) = &mut self.stage else { return };
        let first = beginning.push(stamp, self.tracker.tracks());
        let rotation = beginning.frames().last().map_or_else(UnitQuaternion::identity, |f| f.rotation);
        let inliers = self.tracker.tracks().len();
        let state = if inliers >= FEW { TrackingState::RotationOnly } else { TrackingState::Propagated };
        let reference_from_camera = Pose::from_parts(Vector3::zeros().into(), rotation);
        let (quality, blind) = self.quality(state, &[], 0.0);
        self.posed.push(Posed { stamp, reference: None, reference_from_camera, state, inliers, repeat: false, quality, blind });
        match first {
            Some(first) => self.start_map(stamp, &first),
            None => {
                let fresh = self.tracker.replenish();
                if let Stage::Beginning(beginning) = &mut self.stage {
                    beginning.add_rays(&fresh);
                }
            }
        }
    }

    /// Two keyframes and their points; then the frames between them, and the motion.
    fn start_map(&mut self, stamp: Stamp, first: &FirstViews) {
        let Stage::Beginning(beginning) = &self.stage else { return };
        let base_index = beginning.base();
        let frames = beginning.frames()[base_index..].to_vec();
        let base = Pose::from_parts(Vector3::zeros().into(), frames[0].rotation);
        let seconds = stamp.secs_since(frames[0].stamp);
        let baseline = self.options.walking_speed_m_s * seconds;
        let now_from_base = Pose::from_parts((first.fit.pose.direction * baseline).into(), first.fit.pose.rotation);
        let now = base * now_from_base.inverse();
        self.map.keyframes.push(Keyframe { stamp: frames[0].stamp, pose: base, turn: UnitQuaternion::identity(), fix: None });
        self.map.keyframes.push(Keyframe { stamp, pose: now, turn: base.rotation.inverse() * now.rotation, fix: None });
        let now_rays = &frames[frames.len() - 1].rays;
        for (id, (rho, sigma_rho)) in &first.points {
            let (Some(ray), Some(seen)) = (frames[0].rays.get(id), now_rays.get(id)) else { continue };
            let (rho, sigma_rho) = ((rho / baseline).max(map::MIN_RHO), sigma_rho / baseline);
            let landmark = Landmark {
                anchor: KeyframeId(0),
                ray: *ray,
                rho,
                sigma_rho,
                born: (rho, 3.0 * sigma_rho + 0.3 * rho),
                prior: (rho, 3.0 * sigma_rho + 0.3 * rho),
                seen: vec![(KeyframeId(1), *seen)],
                strikes: 0,
            };
            self.map.landmarks.insert(*id, landmark);
        }
        let OdometryOptions { walking_speed_m_s, prediction, .. } = self.options;
        self.stage = Stage::Tracking(Motion::between(&base, now, stamp, seconds, walking_speed_m_s, prediction));
        self.pose_early_frames(base_index, &frames, &base, &now);
        let dead: Vec<TrackId> = self.tracker.tracks().iter().map(|t| t.id).filter(|id| !self.map.landmarks.contains_key(id)).collect();
        self.tracker.drop_tracks(|id| dead.contains(&id));
        self.add_landmarks(KeyframeId(1));
        // Both of the first two.
        (0..2).for_each(|_| self.pass());
        self.tracks_at_keyframe = self.tracker.tracks().len();
    }

    /// Poses of the frames between the first two keyframes, against the points that these gave.
    fn pose_early_frames(&mut self, base_index: usize, frames: &[EarlyFrame], base: &Pose, now: &Pose) {
        let span = frames[frames.len() - 1].stamp.secs_since(frames[0].stamp);
        for (k, frame) in frames.iter().enumerate() {
            let t = frame.stamp.secs_since(frames[0].stamp) / span;
            let between = base.lerp_slerp(now, t);
            let prior =
                pose::PosePrior { pose: between, sigma_move: 0.2 * self.options.walking_speed_m_s * span, sigma_turn_rad: 0.2, fix: None };
            let sights: Vec<pose::Sight> = self.sights(frame.rays.iter().map(|(id, ray)| (*id, *ray))).into_iter().map(|s| s.1).collect();
            let fitted = match k {
                0 => *base,
                k if k + 1 == frames.len() => *now,
                _ => pose::solve(&sights, &prior, self.sigma_rad()).pose,
            };
            if let Some(posed) = self.posed.get_mut(base_index + k) {
                posed.reference = Some(KeyframeId(0));
                posed.reference_from_camera = base.inverse() * fitted;
                posed.state = TrackingState::Mapped;
            }
        }
    }
}
