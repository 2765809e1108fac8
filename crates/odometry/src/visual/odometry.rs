//! Where was the camera at every frame? Tracking against the map, keyframe by keyframe, and never a reset.
//!
//! frame ─▶ follow points ─▶ (no map yet: [`begin`](super::begin)) ─▶ pose against the map ─▶ distances ─▶ keyframe? ─▶ bundle
//!
//! Pitfall: at the corner of a corridor the view is a blank wall and the motion a near-pure rotation. Points there begin as
//! bearings, which give the rotation at once; the speed of the walk carries the translation until they have distances.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Camera, Seed, Stamp, TrackingState, VideoFrame};

use super::axes::Fix;
use super::begin::{Beginning, FirstViews};
use super::compass::Compass;
use super::lines::Edge;
use super::map::{self, Keyframe, KeyframeId, Landmark, Map, Pose, bundle, depth, pose};
use super::motion::Motion;
use super::outcome::{FrameReport, Odometry, OdometryError, gaps};
use super::posed::{Posed, place};
use super::repeat::Repeats;
use super::track::{Track, TrackId, Tracker};
use super::two_view;
use super::two_view::rotation::median;
use super::two_view::{RayPair, RelativePoseOptions, Solver, epipolar, estimate_relative_pose};
use crate::ground::{self, SeenPoint};

/// Options of [`VisualOdometry`].
#[derive(Debug, Clone, Copy)]
pub struct OdometryOptions {
    /// Solver of the relative pose between two views.
    pub solver: Solver,
    /// What chance grows from.
    pub seed: Seed,
    /// Noise of a followed point, pixels.
    pub sigma_px: f64,
    /// Keyframes that bundle adjustment moves.
    pub window: usize,
    /// How fast a person walks, m/s: it sets the length of the first baseline, and so the unit, to about a metre.
    pub walking_speed_m_s: f64,
}

impl Default for OdometryOptions {
    fn default() -> Self {
        Self { solver: Solver::default(), seed: Seed(0), sigma_px: 1.0, window: 8, walking_speed_m_s: 1.1 }
    }
}

enum Stage {
    Beginning(Beginning),
    Tracking(Motion),
}

/// Monocular visual odometry, frame by frame; holds one frame, the map and a pose a frame.
pub struct VisualOdometry {
    camera: Camera,
    options: OdometryOptions,
    tracker: Tracker,
    map: Map,
    stage: Stage,
    posed: Vec<Posed>,
    repeats: Repeats,
    compass: Compass,
    unit_lost: Option<KeyframeId>,
    seen_points: Vec<SeenPoint>,
    most_tracks: usize,
    /// Points followed when the newest keyframe was taken.
    tracks_at_keyframe: usize,
}

/// Parallax of the first two keyframes. A tenth of a radian would be better still, but a walk down a corridor takes seconds to get there.
const FIRST_PARALLAX_RAD: f64 = 0.018;
/// New points whose assumed distance counts as that of each alone; of more, it counts as that of so many.
const ASSUMED_TOGETHER: f64 = 4.0;
/// Turns of the whole picture that differ from the expected one by more standard deviations are not believed.
const LEAP: f64 = 3.0;
/// Keyframes are no closer than this, seconds, unless fewer points with a distance are left: a window of frames that follow each
/// other has no baseline.
const KEYFRAME_S: f64 = 0.1;
const KEYFRAME_POINTS: usize = 30;
/// Points with a distance that hold the unit of length.
const UNIT_NEEDS: usize = 10;
/// A keyframe's rotation is as the building's edges say within this.
const SOUND_RAD: f64 = 0.05;
/// Strikes in a row after which a point is taken to move by itself.
const STRIKES: u32 = 3;

impl VisualOdometry {
    /// Odometry for images of this camera.
    pub fn new(camera: Camera, options: OdometryOptions) -> Self {
        let two_view = two_view_options(&camera, &options);
        Self {
            tracker: Tracker::new(camera.clone()),
            camera,
            options,
            map: Map::default(),
            stage: Stage::Beginning(Beginning::new(two_view, FIRST_PARALLAX_RAD, options.seed)),
            posed: Vec::new(),
            repeats: Repeats::default(),
            compass: Compass::default(),
            unit_lost: None,
            seen_points: Vec::new(),
            most_tracks: 0,
            tracks_at_keyframe: 0,
        }
    }

    /// Noise of a ray, radians.
    fn sigma_rad(&self) -> f64 {
        self.options.sigma_px / self.camera.focal_px()
    }

    /// Takes in the next frame.
    ///
    /// # Errors
    /// [`OdometryError::SizeChanged`] and [`OdometryError::StampsGoBack`]; the frame is then ignored and the next may be pushed.
    pub fn push(&mut self, frame: &VideoFrame) -> Result<FrameReport, OdometryError> {
        self.check(frame)?;
        if self.repeats.is_repeat(&frame.image) && matches!(self.stage, Stage::Tracking(_)) {
            return Ok(self.repeat(frame.stamp));
        }
        let mut predicted = match &self.stage {
            Stage::Tracking(motion) => Some(motion.predict(frame.stamp)),
            Stage::Beginning(_) => None,
        };
        let turn_seen = self.follow(frame, predicted.as_mut());
        self.most_tracks = self.most_tracks.max(self.tracker.tracks().len());
        match predicted {
            Some(mut prior) => {
                let edges = self.tracker.edges();
                prior.fix = self.compass.fix(&edges, &prior.pose.rotation);
                self.track(frame.stamp, &prior, turn_seen, &edges);
            }
            None => self.begin(frame.stamp),
        }
        Ok(self.report(frame.stamp))
    }

    /// The frame shows the picture before it once more: it says nothing.
    fn repeat(&mut self, stamp: Stamp) -> FrameReport {
        if let Some(last) = self.posed.last() {
            let repeated = Posed { stamp, repeat: true, ..last.clone() };
            self.posed.push(repeated);
        }
        self.report(stamp)
    }

    fn report(&self, stamp: Stamp) -> FrameReport {
        let (state, inliers) = self.posed.last().map_or((TrackingState::Propagated, 0), |p| (p.state, p.inliers));
        FrameReport { stamp, state, tracks: self.tracker.tracks().len(), inliers }
    }

    fn check(&self, frame: &VideoFrame) -> Result<(), OdometryError> {
        let index = self.posed.len();
        let (width, height) = (frame.image.width(), frame.image.height());
        let (camera_width, camera_height) = (self.camera.width, self.camera.height);
        if (width, height) != (camera_width, camera_height) {
            return Err(OdometryError::SizeChanged { index, width, height, camera_width, camera_height });
        }
        if self.posed.last().is_some_and(|p| p.stamp >= frame.stamp) {
            return Err(OdometryError::StampsGoBack { index, at_s: frame.stamp.as_secs() });
        }
        Ok(())
    }

    /// Follows all points into the frame, each looked for where the predicted pose puts it; the pictures' own turn corrects
    /// the prediction first.
    ///
    /// Returns whether the pictures were alike enough to tell a turn.
    fn follow(&mut self, frame: &VideoFrame, predicted: Option<&mut pose::PosePrior>) -> bool {
        let (map, camera) = (&self.map, &self.camera);
        let last = match &self.stage {
            Stage::Tracking(motion) => motion.pose.rotation,
            Stage::Beginning(_) => UnitQuaternion::identity(),
        };
        let expected_turn = predicted.as_ref().map_or_else(UnitQuaternion::identity, |prior| prior.pose.rotation.inverse() * last);
        let mut turn_seen = false;
        self.tracker.advance(&frame.image, expected_turn, |turn| {
            let prior = predicted.map(|prior| {
                // A head that leaps is a picture that deceives: a person before the lens, or a codec's blocks on a blank wall.
                let believed = |turn: &UnitQuaternion<f64>| turn.angle_to(&expected_turn) < LEAP * prior.sigma_turn_rad;
                if let Some(now_from_last) = turn.filter(believed) {
                    prior.pose.rotation = last * now_from_last.inverse();
                    // A walk's own parallax goes into the pictures' turn: a degree or two.
                    prior.sigma_turn_rad = prior.sigma_turn_rad.min(0.04);
                    turn_seen = true;
                }
                *prior
            });
            move |track: &Track| {
                let direction = match (&prior, map.landmarks.get(&track.id)) {
                    (Some(prior), Some(landmark)) => map.direction(landmark, &prior.pose),
                    (Some(prior), None) => prior.pose.rotation.inverse() * (last * track.ray),
                    (None, _) => turn? * track.ray,
                };
                let pixel = camera.project(&direction)?;
                let inside = pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < camera.width as f64 && pixel.y < camera.height as f64;
                inside.then_some((pixel.x, pixel.y))
            }
        });
        turn_seen
    }

    /// No map yet: turns are followed; the first parallax begins the map.
    fn begin(&mut self, stamp: Stamp) {
        let Stage::Beginning(beginning) = &mut self.stage else { return };
        let first = beginning.push(stamp, self.tracker.tracks());
        let rotation = beginning.frames().last().map_or_else(UnitQuaternion::identity, |f| f.rotation);
        let inliers = self.tracker.tracks().len();
        let state = if inliers >= 8 { TrackingState::RotationOnly } else { TrackingState::Propagated };
        let reference_from_camera = Pose::from_parts(Vector3::zeros().into(), rotation);
        self.posed.push(Posed { stamp, reference: None, reference_from_camera, state, inliers, repeat: false });
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
        let velocity = (now.translation.vector - base.translation.vector) / seconds;
        let turn_rate = (base.rotation.inverse() * now.rotation).scaled_axis() / seconds;
        self.stage = Stage::Tracking(Motion { pose: now, stamp, velocity, turn_rate, usual_speed: self.options.walking_speed_m_s });
        self.pose_early_frames(base_index, &frames, &base, &now);
        let dead: Vec<TrackId> = self.tracker.tracks().iter().map(|t| t.id).filter(|id| !self.map.landmarks.contains_key(id)).collect();
        self.tracker.drop_tracks(|id| dead.contains(&id));
        self.add_landmarks(KeyframeId(1));
        self.tracks_at_keyframe = self.tracker.tracks().len();
    }

    /// Poses of the frames between the first two keyframes, against the points that these gave.
    fn pose_early_frames(&mut self, base_index: usize, frames: &[super::begin::EarlyFrame], base: &Pose, now: &Pose) {
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

    fn sights(&self, rays: impl Iterator<Item = (TrackId, Vector3<f64>)>) -> Vec<(TrackId, pose::Sight)> {
        let sight = |(id, seen)| {
            let landmark = self.map.landmarks.get(&id)?;
            let anchor = *self.map.pose(landmark.anchor);
            Some((id, pose::Sight { anchor, ray: landmark.ray, rho: landmark.rho, sigma_rho: landmark.sigma_rho, seen }))
        };
        rays.filter_map(sight).collect()
    }

    /// One frame against the map.
    fn track(&mut self, stamp: Stamp, prior: &pose::PosePrior, turn_seen: bool, edges: &[Edge]) {
        let sights = self.sights(self.tracker.tracks().iter().map(|t| (t.id, t.ray)));
        let only: Vec<pose::Sight> = sights.iter().map(|s| s.1).collect();
        let fit = pose::solve(&only, prior, self.sigma_rad());
        let (mut inliers, mut with_depth) = (0, 0);
        let turn_noise = fit.covariance.fixed_view::<3, 3>(0, 0).trace() / 3.0;
        let sigma_rad = (self.sigma_rad().powi(2) + turn_noise).sqrt();
        for ((id, sight), squared) in sights.iter().zip(&fit.squared) {
            let Some(landmark) = self.map.landmarks.get_mut(id) else { continue };
            if *squared > pose::AGREES {
                landmark.strikes += 1;
                continue;
            }
            landmark.strikes = 0;
            inliers += 1;
            with_depth += usize::from(landmark.has_depth());
            let now = (landmark.rho, landmark.sigma_rho);
            if let Some((rho, sigma)) = depth::update(&sight.anchor, &sight.ray, now, &fit.pose, &sight.seen, 1.5 * sigma_rad) {
                (landmark.rho, landmark.sigma_rho) = (rho, sigma);
            }
        }
        let state = match (with_depth, inliers) {
            (10.., _) => TrackingState::Mapped,
            (_, 8..) => TrackingState::RotationOnly,
            _ if turn_seen => TrackingState::RotationOnly,
            _ => TrackingState::Propagated,
        };
        let reference = self.map.newest();
        let reference_from_camera = reference.map_or(fit.pose, |k| self.map.pose(k).inverse() * fit.pose);
        self.posed.push(Posed { stamp, reference, reference_from_camera, state, inliers, repeat: false });
        self.drop_movers();
        if let Stage::Tracking(motion) = &mut self.stage {
            motion.go_on(stamp, fit.pose, state, inliers);
        }
        let fix = self.steer(edges, &fit.pose.rotation, inliers);
        let Stage::Tracking(Motion { pose: now, .. }) = self.stage else { return };
        if self.wants_keyframe(&now) {
            self.add_keyframe(stamp, now, fix);
        }
    }

    /// Turns the map back towards the building's axes; returns what the edges say of this frame.
    fn steer(&mut self, edges: &[Edge], rotation: &UnitQuaternion<f64>, inliers: usize) -> Option<Fix> {
        let seconds = match self.posed.as_slice() {
            [.., before, now] => now.stamp.secs_since(before.stamp),
            _ => 0.0,
        };
        let steering = self.compass.steer(edges, rotation, seconds, inliers)?;
        let oldest = self.map.oldest_live(self.options.window);
        // What went wrong went wrong after the last keyframe that the edges agree with.
        let unsound = self.map.after_last_sound(SOUND_RAD);
        let oldest = if Some(unsound) <= self.map.newest() { oldest.max(unsound) } else { oldest };
        if let Stage::Tracking(motion) = &mut self.stage {
            self.map.turn_about(&motion.pose.translation.vector, &steering.turn, oldest);
            motion.pose.rotation = steering.turn * motion.pose.rotation;
            motion.velocity = steering.turn * motion.velocity;
        }
        Some(steering.fix)
    }

    /// Stops following what moves by itself, and forgets it: its rays must not pull on any keyframe.
    ///
    /// Points that were lost from view stay: their rays hold the keyframes of the window in place.
    fn drop_movers(&mut self) {
        let landmarks = &mut self.map.landmarks;
        self.tracker.drop_tracks(|id| landmarks.get(&id).is_none_or(|l| l.strikes >= STRIKES));
        landmarks.retain(|_, l| l.strikes < STRIKES);
    }

    /// Landmarks that are in view.
    fn in_view(&self) -> impl Iterator<Item = &Landmark> {
        self.tracker.tracks().iter().filter_map(|t| self.map.landmarks.get(&t.id))
    }

    /// Whether the view has changed enough, by turning, by parallax or by loss of points, to be remembered.
    fn wants_keyframe(&self, now: &Pose) -> bool {
        let Some(newest) = self.map.newest() else { return false };
        let keyframe = self.map.pose(newest);
        let seconds = self.posed.last().map_or(0.0, |p| p.stamp.secs_since(self.map.keyframes[newest.0].stamp));
        if seconds < KEYFRAME_S && self.in_view().filter(|l| l.has_depth()).count() >= KEYFRAME_POINTS {
            return false;
        }
        let turned = keyframe.rotation.angle_to(&now.rotation);
        let lost = (self.tracker.tracks().len() as f64) < 0.75 * self.tracks_at_keyframe as f64;
        let parallax = self.in_view().filter(|l| l.has_depth()).map(|l| {
            let (before, after) = (self.map.direction(l, keyframe), self.map.direction(l, now));
            (keyframe.rotation * before).angle(&(now.rotation * after))
        });
        turned > 0.12 || lost || median(parallax.collect()) > 0.025
    }

    /// Remembers the frame: new points, checked against the keyframe before, and the last few keyframes adjusted.
    fn add_keyframe(&mut self, stamp: Stamp, now: Pose, fix: Option<Fix>) {
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
        let Stage::Tracking(motion) = &self.stage else { return };
        let options = bundle::BundleOptions {
            window: self.options.window,
            sigma_rad: self.sigma_rad(),
            iterations: 8,
            speed_walk: 0.5 * motion.usual_speed.max(0.2 * self.options.walking_speed_m_s),
        };
        self.compass.held(&now.rotation);
        self.keep_unit(id);
        bundle::adjust(&mut self.map, &options);
        self.forget_old_rays(id);
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

    /// Lays points on the floor and the ceiling; where these say that the unit of length was lost, it is put right.
    fn keep_unit(&mut self, id: KeyframeId) {
        let up = self.compass.up();
        if self.in_view().filter(|l| l.has_depth()).count() < UNIT_NEEDS {
            self.map.planes.lose();
            self.unit_lost.get_or_insert(id);
        }
        let in_view: Vec<TrackId> = self.tracker.tracks().iter().map(|t| t.id).collect();
        if let Some(factor) = self.map.learn_planes(&up, &in_view) {
            if factor != 1.0 {
                self.regain_unit(factor);
            }
            self.unit_lost = None;
        }
        self.map.lay_on_planes(&up);
    }

    /// The floor is nearer, or farther, than it was: since nothing with a distance was seen, lengths are in another unit.
    fn regain_unit(&mut self, factor: f64) {
        let oldest = self.map.oldest_live(self.options.window);
        let since = self.unit_lost.unwrap_or(oldest);
        self.map.rescale(factor, since);
        for posed in self.posed.iter_mut().rev().take_while(|p| p.reference >= Some(since)) {
            posed.reference_from_camera.translation.vector *= factor;
        }
        let stamp = self.map.keyframes[since.0].stamp;
        for seen in self.seen_points.iter_mut().rev().take_while(|s| s.stamp >= stamp) {
            *seen = seen.scaled(factor);
        }
        if let (Stage::Tracking(motion), Some(newest)) = (&mut self.stage, self.map.keyframes.last()) {
            motion.pose.translation = newest.pose.translation;
        }
        if let Stage::Tracking(motion) = &mut self.stage {
            motion.velocity *= factor;
            motion.usual_speed *= factor;
        }
    }

    /// Points that break the epipolar geometry of the last two keyframes get a strike: most likely they move by themselves.
    fn strike_movers(&mut self, id: KeyframeId) {
        let before = KeyframeId(id.0 - 1);
        let ray_in = |l: &Landmark, k: KeyframeId| {
            if l.anchor == k { Some(l.ray) } else { l.seen.iter().rev().find(|s| s.0 == k).map(|s| s.1) }
        };
        let pairs: Vec<(TrackId, RayPair)> = (self.map.landmarks.iter())
            .filter_map(|(track, l)| Some((*track, RayPair { a: ray_in(l, before)?, b: ray_in(l, id)? })))
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
    fn forget_old_rays(&mut self, id: KeyframeId) {
        let oldest = id.0.saturating_sub(self.options.window + 3);
        let followed: BTreeSet<TrackId> = self.tracker.tracks().iter().map(|t| t.id).collect();
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
    fn add_landmarks(&mut self, id: KeyframeId) {
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

    /// The whole clip's odometry.
    ///
    /// # Errors
    /// [`OdometryError::TooFewFrames`] and [`OdometryError::NothingToTrack`], when there is nothing to give.
    pub fn finish(self) -> Result<Odometry, OdometryError> {
        if self.posed.len() < 2 {
            return Err(OdometryError::TooFewFrames { got: self.posed.len() });
        }
        if self.most_tracks < 8 {
            return Err(OdometryError::NothingToTrack { frames: self.posed.len(), most: self.most_tracks });
        }
        let poses = place(&self.posed, &self.map);
        let up = self.compass.level().unwrap_or_else(|| ground::up(&poses));
        let level = ground::level(&poses, &up);
        let scale = ground::metres_by_walking(&poses, self.options.walking_speed_m_s);
        let poses = ground::levelled(&poses, &level, scale);
        let by_stamp: BTreeMap<Stamp, usize> = poses.iter().enumerate().map(|(i, p)| (p.stamp, i)).collect();
        let seen = self.seen_points.iter().filter_map(|s| by_stamp.get(&s.stamp).map(|i| (&poses[*i], s.scaled(scale))));
        let sightings = ground::sightings(&seen.collect::<Vec<_>>());
        let path = ground::path(&poses);
        let gaps = gaps(&poses);
        Ok(Odometry { poses, path, sightings, gaps })
    }
}

fn two_view_options(camera: &Camera, options: &OdometryOptions) -> RelativePoseOptions {
    RelativePoseOptions { solver: options.solver, ..RelativePoseOptions::for_focal(camera.focal_px() / options.sigma_px) }
}
