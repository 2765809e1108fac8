//! Which frames does the map remember, and what do they add to it?

use std::collections::BTreeSet;

use nalgebra::UnitQuaternion;
use planwalk_types::Stamp;

use super::{Stage, VisualOdometry, two_view_options};
use crate::ground::SeenPoint;
use crate::visual::axes::Fix;
use crate::visual::map::{Keyframe, KeyframeId, Landmark, Pose, bundle};
use crate::visual::track::{Track, TrackId};
use crate::visual::two_view::rotation::median;
use crate::visual::two_view::{self, RayPair, epipolar, estimate_relative_pose};

/// New points whose assumed distance counts as that of each alone; of more, it counts as that of so many.
const ASSUMED_TOGETHER: f64 = 4.0;
/// Keyframes are no closer than this, seconds, unless fewer points with a distance are left: a window of frames that follow each
/// other has no baseline.
const KEYFRAME_S: f64 = 0.1;
const KEYFRAME_POINTS: usize = 30;
/// Points under which a picture that shows anything is worth a keyframe.
const FEW_TRACKS: usize = 30;

impl VisualOdometry {
    /// Whether the view has changed enough, by turning, by parallax or by loss of points, to be remembered.
    pub(super) fn wants_keyframe(&self, now: &Pose) -> bool {
        let Some(newest) = self.map.newest() else { return false };
        let keyframe = self.map.pose(newest);
        let seconds = self.posed.last().map_or(0.0, |p| p.stamp.secs_since(self.map.keyframes[newest.0].stamp));
        if seconds < KEYFRAME_S && self.in_view().filter(|l| l.has_depth()).count() >= KEYFRAME_POINTS {
            return false;
        }
        let turned = keyframe.rotation.angle_to(&now.rotation);
        let tracks = self.tracker.tracks().len();
        let lost = (tracks as f64) < 0.75 * self.tracks_at_keyframe as f64;
        // Behind a blank wall, or a hand on the lens, nothing was followed, so nothing can be lost: what is there is to be found.
        let appears = tracks < FEW_TRACKS && self.tracker.view().is_some_and(|view| view.shows());
        let parallax = self.in_view().filter(|l| l.has_depth()).map(|l| {
            let (before, after) = (self.map.direction(l, keyframe), self.map.direction(l, now));
            (keyframe.rotation * before).angle(&(now.rotation * after))
        });
        turned > 0.12 || lost || appears || median(parallax.collect()) > 0.025
    }

    /// Remembers the frame: new points, checked against the keyframe before, and the last few keyframes adjusted.
    pub(super) fn add_keyframe(&mut self, stamp: Stamp, now: Pose, fix: Option<Fix>) {
        let id = KeyframeId(self.map.keyframes.len());
        let turn = self.map.keyframes.last().map_or_else(UnitQuaternion::identity, |k| k.pose.rotation.inverse() * now.rotation);
        self.map.keyframes.push(Keyframe { stamp, pose: now, turn, fix });
        for track in self.tracker.tracks() {
            // What disagrees with this frame's pose must not pull on it.
            if let Some(landmark) = self.map.landmarks.get_mut(&track.id).filter(|l| l.strikes == 0) {
                landmark.seen.push((id, track.ray));
            }
        }
        self.strike_movers(id);
        self.pass();
        self.recall(id, fix);
        let Stage::Tracking(motion) = &self.stage else { return };
        let options = bundle::BundleOptions {
            window: self.options.window,
            sigma_rad: self.sigma_rad(),
            iterations: 8,
            speed_walk: 0.5 * motion.usual_speed.max(0.2 * self.options.walking_speed_m_s),
            past: self.options.window_past,
        };
        self.compass.held(&now.rotation);
        self.keep_unit(id);
        bundle::adjust(&mut self.map, &options);
        self.pair_up(id);
        self.forget_old_rays(id, &options);
        let adjusted = *self.map.pose(id);
        if let Some(posed) = self.posed.last_mut() {
            (posed.reference, posed.reference_from_camera) = (Some(id), Pose::identity());
        }
        if let Stage::Tracking(motion) = &mut self.stage {
            motion.pose = adjusted;
        }
        self.note_seen_points(id);
        self.add_landmarks(id);
        self.tracks_at_keyframe = self.tracker.tracks().len();
    }

    /// Points that break the epipolar geometry of the last two keyframes get a strike: most likely they move by themselves.
    fn strike_movers(&mut self, id: KeyframeId) {
        let before = KeyframeId(id.0 - 1);
        let pairs: Vec<(TrackId, RayPair)> = (self.map.landmarks.iter())
            .filter_map(|(track, l)| Some((*track, RayPair { a: l.ray_in(before)?, b: l.ray_in(id)? })))
            .collect();
        let rays: Vec<RayPair> = pairs.iter().map(|p| p.1).collect();
        let options = two_view_options(&self.camera, &self.options);
        let Some(fit) = estimate_relative_pose(&rays, &options, &mut self.options.seed.derive("keyframe", id.0 as u64)) else { return };
        // Before a plane the motion is two-fold, and the wrong one breaks with all that is off the plane.
        if fit.motion != two_view::Motion::General || fit.parallax_rad < 0.01 {
            return;
        }
        let (essential, limit_rad) = (epipolar::essential_of(&fit.pose), 4.0 * self.sigma_rad());
        for (track, pair) in &pairs {
            let Some(landmark) = self.map.landmarks.get_mut(track) else { continue };
            if epipolar::epipolar_angle(&essential, pair) > limit_rad {
                landmark.strikes += 1;
                landmark.seen.pop();
            }
        }
    }

    /// Rays that no adjustment will look at again, and lost points without any other.
    fn forget_old_rays(&mut self, id: KeyframeId, options: &bundle::BundleOptions) {
        let oldest = id.0.saturating_sub(self.options.window + 3);
        let followed: BTreeSet<TrackId> = self.tracker.tracks().iter().map(|t| t.id).collect();
        bundle::let_go(&mut self.map, options, &followed);
        self.map.landmarks.retain(|track, landmark| {
            landmark.seen.retain(|(k, _)| k.0 >= oldest);
            followed.contains(track) || !landmark.seen.is_empty()
        });
    }

    /// Points with a distance, as seen from this keyframe.
    fn note_seen_points(&mut self, id: KeyframeId) {
        let camera = self.map.pose(id);
        let mut points = Vec::new();
        for landmark in self.in_view().filter(|l| l.sigma_rho < 0.15 * l.rho && l.strikes == 0 && l.seen.len() >= 2) {
            let point = self.map.direction(landmark, camera) / landmark.rho;
            let sigma = landmark.sigma_rho / landmark.rho * point.norm();
            points.push(SeenPoint { stamp: self.map.keyframes[id.0].stamp, point, sigma });
        }
        self.seen_points.extend(points);
    }

    /// New points begin before the floor or the ceiling, else at the usual distance of the points in view, vaguely.
    pub(super) fn add_landmarks(&mut self, id: KeyframeId) {
        let camera = *self.map.pose(id);
        let (usual, up) = (self.usual_rho(&camera), self.compass.up());
        let fresh: Vec<Track> = self.tracker.replenish();
        // What is assumed is assumed of all of them at once: many points must not make it surer than these few would.
        let sigma = 0.8 * usual * (fresh.len() as f64 / ASSUMED_TOGETHER).sqrt().max(1.0);
        for track in fresh {
            let plane = self.map.planes.at_birth(&up, &(camera.rotation * track.ray));
            let born @ (rho, sigma) = plane.unwrap_or((usual, sigma));
            let sigma_rho = sigma.min(0.8 * rho);
            let landmark = Landmark { anchor: id, ray: track.ray, rho, sigma_rho, born, prior: born, seen: Vec::new(), strikes: 0 };
            self.map.landmarks.insert(track.id, landmark);
        }
    }

    /// Inverse distance of a point of which nothing is known: as of those in view, within what rooms have.
    fn usual_rho(&self, camera: &Pose) -> f64 {
        // The unit is about a metre, or as the height of a walker's camera says.
        let metre = self.map.planes.camera_height().map_or(1.0, |height| height / 1.5);
        let known = self.in_view().filter(|l| l.has_depth());
        let usual = median(known.map(|l| l.rho / self.map.direction(l, camera).norm()).collect());
        // Indoors walls are some 4 m away.
        if usual > 0.0 { usual.clamp(0.05 / metre, 2.0 / metre) } else { 0.25 / metre }
    }
}
