//! How does the map begin? Wait until two frames have parallax, then take their relative pose and the first points from it.
//!
//! Until then the camera is followed by rotation alone: a walk may begin with a look around.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};
use planwalk_types::{Seed, Stamp};

use super::track::{Track, TrackId};
use super::two_view::{Motion, RayPair, RelativePoseFit, RelativePoseOptions, RotationOptions};
use super::two_view::{epipolar, estimate_relative_pose, estimate_rotation};

/// A frame from before the map.
#[derive(Debug, Clone)]
pub struct EarlyFrame {
    /// When it was taken.
    pub stamp: Stamp,
    /// `odom ← camera`, as chained from frame to frame.
    pub rotation: UnitQuaternion<f64>,
    /// What was followed in it: unit rays.
    pub rays: BTreeMap<TrackId, Vector3<f64>>,
}

/// Two frames with parallax, and the points that they see.
#[derive(Debug, Clone)]
pub struct FirstViews {
    /// `now ← base`, direction of unit length.
    pub fit: RelativePoseFit,
    /// Points by track: inverse distance from the base frame along its ray, in baselines, and its standard deviation.
    pub points: BTreeMap<TrackId, (f64, f64)>,
}

/// Fewest common points for a trustworthy first pose.
const FEWEST: usize = 25;
/// Frames after which a base without parallax is given up: the tracks that last so long see little but the middle.
const PATIENCE: usize = 60;

/// Frames from before the map; the base is the oldest one whose rays are kept.
#[derive(Debug)]
pub struct Beginning {
    options: RelativePoseOptions,
    min_parallax_rad: f64,
    seed: Seed,
    frames: Vec<EarlyFrame>,
    base: usize,
}

impl Beginning {
    /// Nothing seen yet. The first views need this much parallax, radians.
    pub fn new(options: RelativePoseOptions, min_parallax_rad: f64, seed: Seed) -> Self {
        Self { options, min_parallax_rad, seed, frames: Vec::new(), base: 0 }
    }

    /// All frames so far, the ones before [`Beginning::base`] without rays.
    pub fn frames(&self) -> &[EarlyFrame] {
        &self.frames
    }

    /// The frame that the next ones are compared with.
    pub fn base(&self) -> usize {
        self.base
    }

    /// Takes in a frame. Gives the first views once this frame and the base have parallax.
    pub fn push(&mut self, stamp: Stamp, tracks: &[Track]) -> Option<FirstViews> {
        let rays: BTreeMap<TrackId, Vector3<f64>> = tracks.iter().map(|t| (t.id, t.ray)).collect();
        let step = self.frames.len() as u64;
        let rotation = self.frames.last().map_or_else(UnitQuaternion::identity, |last| {
            let pairs: Vec<RayPair> = pairs(&last.rays, &rays).map(|(_, p)| p).collect();
            let fit = estimate_rotation(&pairs, &RotationOptions::default(), &mut self.seed.derive("first rotation", step));
            last.rotation * fit.map_or_else(UnitQuaternion::identity, |f| f.rotation.inverse())
        });
        self.frames.push(EarlyFrame { stamp, rotation, rays });
        let found = self.compare(step);
        if found.is_none() {
            self.move_base();
        }
        found
    }

    fn compare(&self, step: u64) -> Option<FirstViews> {
        let (base, now) = (self.frames.get(self.base)?, self.frames.last()?);
        let common: Vec<(TrackId, RayPair)> = pairs(&base.rays, &now.rays).collect();
        if common.len() < FEWEST || self.frames.len() < self.base + 2 {
            return None;
        }
        let rays: Vec<RayPair> = common.iter().map(|c| c.1).collect();
        let turned = estimate_rotation(&rays, &RotationOptions::default(), &mut self.seed.derive("rotation only", step))?;
        // A rotation alone takes up part of a real parallax: half of what is asked of the essential matrix is enough to try.
        if turned.median_parallax_rad < 0.5 * self.min_parallax_rad {
            return None;
        }
        let fit = estimate_relative_pose(&rays, &self.options, &mut self.seed.derive("first views", step))?;
        let inliers = fit.inliers.iter().filter(|i| **i).count();
        if fit.motion == Motion::TurnOnly || fit.parallax_rad < self.min_parallax_rad || inliers < FEWEST.max(common.len() / 2) {
            return None;
        }
        // Tracks drift while they are followed, neighbours together: more than the noise of the pairs shows.
        let sigma_rad = self.options.limit_rad;
        let points = common.iter().zip(&fit.inliers).filter(|(_, inlier)| **inlier).filter_map(|((id, pair), _)| {
            let across = fit.pose.direction.cross(&(fit.pose.rotation * pair.a)).norm().max(1e-3);
            let rho = epipolar::depths(&fit.pose, pair).map_or(0.0, |(a, _)| 1.0 / a);
            // Parallax = ρ · baseline across the ray, so its noise is that of two rays over the baseline across.
            Some((*id, (rho.max(0.0), sigma_rad / across))).filter(|(_, (rho, _))| rho.is_finite())
        });
        let points = points.collect();
        Some(FirstViews { fit, points })
    }

    /// Gives up a base that shares too little with the present, or that is too old.
    fn move_base(&mut self) {
        let newest = self.frames.len() - 1;
        let shared = pairs(&self.frames[self.base].rays, &self.frames[newest].rays).count();
        if (shared < 2 * FEWEST && newest > self.base) || newest - self.base >= PATIENCE {
            for frame in &mut self.frames[self.base..newest] {
                frame.rays.clear();
            }
            self.base = newest;
        }
    }

    /// Adds points that were found in the newest frame after it was pushed.
    pub fn add_rays(&mut self, fresh: &[Track]) {
        if let Some(last) = self.frames.last_mut() {
            last.rays.extend(fresh.iter().map(|t| (t.id, t.ray)));
        }
    }
}

fn pairs<'a>(
    a: &'a BTreeMap<TrackId, Vector3<f64>>,
    b: &'a BTreeMap<TrackId, Vector3<f64>>,
) -> impl Iterator<Item = (TrackId, RayPair)> + 'a {
    a.iter().filter_map(|(id, ray)| b.get(id).map(|other| (*id, RayPair { a: *ray, b: *other })))
}
