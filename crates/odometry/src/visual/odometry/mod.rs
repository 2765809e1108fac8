//! Where was the camera at every frame? Tracking against the map, keyframe by keyframe, and never a reset.
//!
//! frame ─▶ follow points ─▶ (no map yet: `start`) ─▶ pose against the map ─▶ distances ─▶ `keyframes` ─▶ `reseen`, `unit`, bundle
//! ─▶ once after the beginning `early` (the frames before it); at the end `links` (pose graph)
//!
//! Pitfall: at the corner of a corridor the view is a blank wall and the motion a near-pure rotation. Points there begin as
//! bearings, which give the rotation at once; the speed of the walk carries the translation until they have distances.

mod early;
mod keyframes;
mod levels;
mod links;
mod pace;
mod pairs;
mod reseen;
mod stand;
mod start;
mod unit;
#[cfg(test)]
mod walks;
mod yardstick;

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Camera, CameraPose, Seed, Stamp, TrackingState, VideoFrame};

use crate::ground::{self, SeenPoint};
use crate::metres::metric_scale;
use crate::visual::axes::Fix;
use crate::visual::begin::Beginning;
use crate::visual::compass::Compass;
use crate::visual::graph::GraphSolver;
use crate::visual::lines::Edge;
use crate::visual::map::bundle::WindowPast;
use crate::visual::map::{KeyframeId, Landmark, Map, Pose, depth, knows_depth, pose};
use crate::visual::motion::{Motion, Prediction};
use crate::visual::outcome::{FrameQuality, FrameReport, Odometry, OdometryError, gaps};
use crate::visual::posed::{Posed, place};
use crate::visual::recall::{Memory, Odometer};
use crate::visual::repeat::Repeats;
use crate::visual::track::{FEW, Track, TrackId, Tracker};
use crate::visual::two_view::rotation::median;
use crate::visual::two_view::{RelativePoseOptions, Solver};
use crate::visual::view::Views;

/// Options of [`VisualOdometry`].
#[derive(Debug, Clone, Copy)]
pub struct OdometryOptions {
    /// Solver of the relative pose between two views.
    pub solver: Solver,
    /// Solver of the pose graph that joins places which are seen again.
    pub graph_solver: GraphSolver,
    /// What chance grows from.
    pub seed: Seed,
    /// Noise of a followed point, pixels.
    pub sigma_px: f64,
    /// Keyframes that bundle adjustment moves.
    pub window: usize,
    /// What holds these to all that was before them.
    pub window_past: WindowPast,
    /// What the next frame is looked for by.
    pub prediction: Prediction,
    /// How fast a person walks, m/s: it sets the length of the first baseline, and so the unit, to about a metre.
    pub walking_speed_m_s: f64,
}

impl Default for OdometryOptions {
    fn default() -> Self {
        let (solver, graph_solver) = (Solver::default(), GraphSolver::default());
        let (window_past, prediction) = (WindowPast::default(), Prediction::default());
        Self { solver, graph_solver, seed: Seed(0), sigma_px: 1.0, window: 8, window_past, prediction, walking_speed_m_s: 1.1 }
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
    views: Views,
    compass: Compass,
    unit_lost: Option<KeyframeId>,
    /// Where the unit was lost before the floor was known.
    first_unit_ends: Option<KeyframeId>,
    /// Where the points were seen in the last quarter of a second, frame by frame.
    recent: VecDeque<(Stamp, BTreeMap<TrackId, Vector3<f64>>)>,
    seen_points: Vec<SeenPoint>,
    /// The pictures of the walk's beginning, until it is known.
    early: Option<early::Early>,
    memory: Memory,
    odometer: Odometer,
    /// How each keyframe was reached.
    passages: Vec<links::Passage>,
    links: Vec<reseen::Link>,
    window_pairs: Vec<pairs::WindowPair>,
    most_tracks: usize,
    /// Points followed when the newest keyframe was taken.
    tracks_at_keyframe: usize,
}

/// Parallax of the first two keyframes. A tenth of a radian would be better still, but a walk down a corridor takes seconds to get there.
const FIRST_PARALLAX_RAD: f64 = 0.018;
/// Turns of the whole picture that differ from the expected one by more standard deviations are not believed.
const LEAP: f64 = 3.0;
/// Two pictures are parted by a cut if no turn makes one of the other, and of this many points less than this share is followed.
const CUT_POINTS: usize = 30;
const CUT_FOLLOWED: f64 = 0.15;
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
            views: Views::default(),
            compass: Compass::default(),
            unit_lost: None,
            first_unit_ends: None,
            recent: VecDeque::new(),
            seen_points: Vec::new(),
            early: Some(early::Early::default()),
            memory: Memory::default(),
            odometer: Odometer::default(),
            passages: Vec::new(),
            links: Vec::new(),
            window_pairs: Vec::new(),
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
        self.keep_early(frame);
        let report = self.take_in(frame);
        self.look_back_in_time();
        Ok(report)
    }

    fn take_in(&mut self, frame: &VideoFrame) -> FrameReport {
        // Where nothing is followed, pictures that are alike are a blank wall's.
        let follows = self.tracker.tracks().len() >= FEW && matches!(self.stage, Stage::Tracking(_));
        if self.repeats.is_repeat(&frame.image) && follows {
            return self.repeat(frame.stamp);
        }
        let mut predicted = match &self.stage {
            Stage::Tracking(motion) => Some(motion.predict(frame.stamp)),
            Stage::Beginning(_) => None,
        };
        let points_before = self.tracker.tracks().len();
        let turn_seen = self.follow(frame, predicted.as_mut());
        if predicted.is_some() && self.is_cut(points_before) {
            self.cut(frame.stamp);
            return self.report(frame.stamp);
        }
        self.most_tracks = self.most_tracks.max(self.tracker.tracks().len());
        match predicted {
            Some(mut prior) => {
                let edges = self.tracker.edges();
                prior.fix = self.compass.fix(&edges, &prior.pose.rotation);
                if self.stands(frame.stamp) {
                    self.stand(&mut prior);
                }
                self.remember_rays(frame.stamp);
                self.track(frame.stamp, &prior, turn_seen, &edges);
            }
            None => self.begin(frame.stamp),
        }
        self.report(frame.stamp)
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
    fn follow(&mut self, frame: &VideoFrame, mut predicted: Option<&mut pose::PosePrior>) -> bool {
        let (map, camera) = (&self.map, &self.camera);
        let last = match &self.stage {
            Stage::Tracking(motion) => motion.pose.rotation,
            Stage::Beginning(_) => UnitQuaternion::identity(),
        };
        let expected_turn = predicted.as_ref().map_or_else(UnitQuaternion::identity, |prior| prior.pose.rotation.inverse() * last);
        let mut turn_seen = false;
        self.tracker.advance(&frame.image, expected_turn, |turn| {
            let prior = predicted.as_deref_mut().map(|prior| {
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
        if let (Some(turn), Some(prior)) = (self.tracker.leap(), predicted) {
            prior.pose.rotation = last * turn.inverse();
            prior.sigma_turn_rad = prior.sigma_turn_rad.min(0.04);
            turn_seen = true;
        }
        turn_seen
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
            (_, FEW..) => TrackingState::RotationOnly,
            _ if turn_seen => TrackingState::RotationOnly,
            _ => TrackingState::Propagated,
        };
        let reference = self.map.newest();
        let reference_from_camera = reference.map_or(fit.pose, |k| self.map.pose(k).inverse() * fit.pose);
        let (quality, blind) = self.quality(state, &fit.squared, self.parallax_rad_s(stamp, &fit.pose, &only));
        self.posed.push(Posed { stamp, reference, reference_from_camera, state, inliers, repeat: false, quality, blind });
        self.drop_movers();
        if let Stage::Tracking(motion) = &mut self.stage {
            let (seconds, way) = (stamp.secs_since(motion.stamp), (fit.pose.translation.vector - motion.pose.translation.vector).norm());
            self.odometer.go(state, seconds, way, motion.usual_speed);
            motion.go_on(stamp, fit.pose, state, inliers >= FEW || self.tracker.leap().is_some());
        }
        let fix = self.steer(edges, &fit.pose.rotation, inliers);
        let Stage::Tracking(Motion { pose: now, .. }) = self.stage else { return };
        if self.wants_keyframe(&now) {
            self.add_keyframe(stamp, now, fix);
        }
    }

    /// Whether the newest picture has nothing in common with the one before it, though both show enough to follow.
    fn is_cut(&self, points_before: usize) -> bool {
        let followed = self.tracker.tracks().len() as f64;
        self.tracker.parted() && points_before >= CUT_POINTS && followed < CUT_FOLLOWED * points_before as f64
    }

    /// Goes on after a cut: same path, same map's frame, but nothing that was followed is there any more.
    fn cut(&mut self, stamp: Stamp) {
        let Stage::Tracking(motion) = &mut self.stage else { return };
        motion.stand(stamp);
        let now = motion.pose;
        self.map.landmarks.clear();
        self.tracker.drop_tracks(|_| true);
        self.compass.cut();
        self.odometer.cut();
        let (quality, _) = self.quality(TrackingState::Cut, &[], 0.0);
        let (state, reference_from_camera) = (TrackingState::Cut, Pose::identity());
        let reference = Some(KeyframeId(self.map.keyframes.len()));
        self.posed.push(Posed { stamp, reference, reference_from_camera, state, inliers: 0, repeat: false, quality, blind: None });
        self.add_keyframe(stamp, now, None);
    }

    /// How well the newest frame was followed, and why not, where it was not; `squared` are the distances of the map's points.
    fn quality(&mut self, state: TrackingState, squared: &[f64], parallax_rad_s: f64) -> (FrameQuality, Option<String>) {
        let points = self.tracker.tracks().len();
        let Some(view) = self.tracker.view() else { return (FrameQuality::default(), None) };
        let astray = squared.iter().filter(|s| **s > pose::AGREES).count();
        let movers = astray as f64 / squared.len().max(1) as f64;
        let (sharpness, tilt_sigma_rad) = (view.sharpness, self.compass.tilt_sigma_rad());
        if state == TrackingState::Mapped {
            self.views.usual(&view);
        }
        let blind = (state == TrackingState::Propagated).then(|| self.views.why_blind(&view, points));
        (FrameQuality { points, movers, parallax_rad_s, sharpness, tilt_sigma_rad, ..FrameQuality::default() }, blind)
    }

    /// How fast points at the usual distance go by when the camera goes from the last pose to this one.
    fn parallax_rad_s(&self, stamp: Stamp, now: &Pose, sights: &[pose::Sight]) -> f64 {
        let Stage::Tracking(motion) = &self.stage else { return 0.0 };
        let rho = median(sights.iter().filter(|s| knows_depth(s.rho, s.sigma_rho)).map(|s| s.rho).collect());
        let way = (now.translation.vector - motion.pose.translation.vector).norm();
        way * rho / stamp.secs_since(motion.stamp).max(1e-3)
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
        let memory = &mut self.memory;
        landmarks.retain(|id, l| {
            if l.strikes >= STRIKES {
                memory.forget(*id);
            }
            l.strikes < STRIKES
        });
    }

    /// Landmarks that are in view.
    fn in_view(&self) -> impl Iterator<Item = &Landmark> {
        self.tracker.tracks().iter().filter_map(|t| self.map.landmarks.get(&t.id))
    }

    /// Where the frames were, on the keyframes as they are; how well that is known is noted of each.
    fn placed(&mut self) -> Vec<CameraPose> {
        let placed = place(&self.posed, &self.map);
        for (posed, placed) in self.posed.iter_mut().zip(&placed) {
            (posed.quality.turn_sigma_rad, posed.quality.shift_sigma) = (placed.turn_sigma_rad, placed.shift_sigma);
        }
        placed.into_iter().map(|p| p.pose).collect()
    }

    /// Up, in odom.
    fn up(&mut self) -> Vector3<f64> {
        self.compass.level().unwrap_or_else(|| ground::up(&self.placed()))
    }

    /// Puts right, at the end of a walk, what only the whole of it tells; returns by how much lengths changed, in the median.
    fn settle(&mut self, up: &Vector3<f64>) -> f64 {
        self.right_first_unit(up);
        self.pair_up_the_rest();
        self.close_links(up)
    }

    /// The whole clip's odometry.
    ///
    /// # Errors
    /// [`OdometryError::TooFewFrames`] and [`OdometryError::NothingToTrack`], when there is nothing to give.
    pub fn finish(mut self) -> Result<Odometry, OdometryError> {
        if self.posed.len() < 2 {
            return Err(OdometryError::TooFewFrames { got: self.posed.len() });
        }
        if self.most_tracks < FEW {
            return Err(OdometryError::NothingToTrack { frames: self.posed.len(), most: self.most_tracks });
        }
        self.look_back();
        let up = self.up();
        let rescaled = self.settle(&up);
        let poses = self.placed();
        let level = ground::level(&poses, &up);
        let poses = ground::levelled(&poses, &level, 1.0);
        let unit = metric_scale(&poses, self.map.planes.camera_height().map(|h| h * rescaled), self.options.walking_speed_m_s);
        let poses = ground::levelled(&poses, &UnitQuaternion::identity(), unit.metres_per_unit);
        let by_stamp: BTreeMap<Stamp, usize> = poses.iter().enumerate().map(|(i, p)| (p.stamp, i)).collect();
        let seen = self.seen_points.iter().filter_map(|s| by_stamp.get(&s.stamp).map(|i| (&poses[*i], s.scaled(unit.metres_per_unit))));
        let sightings = ground::sightings(&seen.collect::<Vec<_>>());
        let path = ground::path(&poses);
        let gaps = gaps(&self.posed);
        let quality = self.posed.iter().map(|p| p.quality.scaled(unit.metres_per_unit)).collect();
        Ok(Odometry { poses, path, sightings, gaps, quality, unit: unit.applied() })
    }
}

fn two_view_options(camera: &Camera, options: &OdometryOptions) -> RelativePoseOptions {
    RelativePoseOptions { solver: options.solver, ..RelativePoseOptions::for_focal(camera.focal_px() / options.sigma_px) }
}
