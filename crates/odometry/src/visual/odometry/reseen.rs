//! Which of the points in view were seen before, and what do they say of the place and of the unit of length?
//!
//! keyframe ─▶ corners and followed points, described ─▶ pairs with what is remembered ([`super::super::recall`]) ─▶ pose by them
//! ─▶ distances of the points, the place of a keyframe that nothing else holds, and a [`Link`] for `links` at the end of the walk

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use super::{Stage, VisualOdometry};
use crate::visual::axes::Fix;
use crate::visual::map::{KeyframeId, Landmark, Pose, direction, pose};
use crate::visual::recall::Remembered;
use crate::visual::recall::descriptor::Descriptor;
use crate::visual::recall::matching::{self, Expected, Seen};
use crate::visual::track::TrackId;
use crate::visual::two_view::rotation::median;

/// A keyframe whose place was known again from another one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    /// The keyframe from which most of the points were last seen.
    pub a: KeyframeId,
    /// The keyframe that knows them again.
    pub b: KeyframeId,
    /// Where b was in a's frame, a's unit.
    pub a_from_b: Pose,
    /// How many of a's units one of b's has, if enough points of both say so.
    pub scale: Option<f64>,
    /// Mean distance of the points, a's unit.
    pub far: f64,
}

/// A point of the newest picture: one that is followed, or a corner that might be.
struct Candidate {
    followed: Option<TrackId>,
    pixel: (f64, f64),
    ray: Vector3<f64>,
    looks: Descriptor,
}

/// A remembered point and the point of the newest picture that it is.
struct Pair<'c> {
    was: Remembered,
    is: &'c Candidate,
}

/// Fewest points that make a place, and the share of the pairs that must agree on it: by chance a pose fits five or six of twenty.
const PLACE_POINTS: usize = 12;
const PLACE_SHARE: f64 = 0.6;
/// Points with a distance that hold a frame by themselves.
const HELD: usize = 10;
/// Points of which the distance is known twice that say how long one unit is in the other, and the ratios that are taken for one unit.
const SCALE_POINTS: usize = 5;
const SAME_UNIT: (f64, f64) = (0.75, 1.33);
/// Error of a distance that was known again, besides its own, as a share of it.
const KNOWN_AGAIN: f64 = 0.1;
/// Noise of a ray that was found by its looks, as many times that of a followed one: a corner is not found on the same pixel.
const FOUND_AGAIN: f64 = 2.0;
/// Standard deviations within which a point is looked for, and the widest gate, radians.
const GATE: f64 = 2.5;
const WIDEST_RAD: f64 = 0.6;
/// Rays further from the middle of the picture are in no picture, radians.
const IN_VIEW_RAD: f64 = 1.0;
/// Units of way within which memories share their drift.
const TOGETHER: f64 = 3.0;
/// Drift since, as a share of the points' distance, under which a link says nothing that the window does not know better.
const WORTH: f64 = 0.04;

impl VisualOdometry {
    /// Knows lost points again in a keyframe that was just taken, and remembers those that are in view.
    pub(super) fn recall(&mut self, id: KeyframeId, fix: Option<Fix>) {
        let camera = *self.map.pose(id);
        let up = camera.rotation.inverse() * self.compass.up();
        let candidates = self.candidates(libm::atan2(up.x, -up.y));
        if let Some((pairs, shift)) = self.pairs(&camera, &candidates) {
            self.know_again(id, &camera, fix, &pairs, shift);
        }
        self.remember_followed(id, &candidates);
    }

    fn candidates(&self, roll: f64) -> Vec<Candidate> {
        let tracks = self.tracker.tracks().iter().map(|t| (Some(t.id), t.pixel, t.ray));
        let others = self.tracker.unfollowed().into_iter().map(|(pixel, ray)| (None, pixel, ray));
        let points: Vec<_> = tracks.chain(others).collect();
        let looks = self.tracker.describe(points.iter().map(|p| p.1), roll);
        let described = points.into_iter().zip(looks);
        described.filter_map(|((followed, pixel, ray), looks)| Some(Candidate { followed, pixel, ray, looks: looks? })).collect()
    }

    /// Remembered points that should be in view, and how they should look.
    fn expected(&self, camera: &Pose) -> Vec<(Remembered, Expected)> {
        let followed: BTreeSet<TrackId> = self.tracker.tracks().iter().map(|t| t.id).collect();
        let expect = |point: &Remembered| {
            let (shift, turn) = self.odometer.drift_since(&point.odometer);
            let direction = direction(self.map.pose(point.keyframe), &point.ray, point.rho, camera);
            let (ray, nearer) = (direction.normalize(), 1.0 / direction.norm());
            let gate_rad = (GATE * (turn + shift * point.rho * nearer)).min(WIDEST_RAD);
            let octaves = libm::round(libm::log2(nearer)) as i32;
            let expected = Expected { ray, gate_rad, octaves, looks: point.looks };
            (ray.angle(&Vector3::z()) < IN_VIEW_RAD && octaves.abs() <= 1).then_some((*point, expected))
        };
        self.memory.points().filter(|(id, _)| !followed.contains(id)).filter_map(|(_, point)| expect(point)).collect()
    }

    /// What is known again, all of it last seen on one stretch of the way, and how far odometry may have drifted since, units.
    fn pairs<'c>(&self, camera: &Pose, candidates: &'c [Candidate]) -> Option<(Vec<Pair<'c>>, f64)> {
        let (were, expected): (Vec<Remembered>, Vec<Expected>) = self.expected(camera).into_iter().unzip();
        if were.len() < PLACE_POINTS {
            return None;
        }
        let seen: Vec<Seen> = candidates.iter().map(|c| Seen { ray: c.ray, looks: c.looks }).collect();
        let matches = matching::matches(&expected, &seen);
        let ways: Vec<f64> = matches.iter().map(|(e, _)| were[*e].odometer.way).collect();
        let near = |way: f64| ways.iter().filter(|other| (**other - way).abs() < TOGETHER).count();
        // Of equal stretches the latest.
        let way = ways.iter().copied().max_by(|a, b| near(*a).cmp(&near(*b)).then(a.total_cmp(b)))?;
        let together = matches.iter().filter(|(e, _)| (were[*e].odometer.way - way).abs() < TOGETHER);
        let pairs: Vec<Pair> = together.map(|(e, s)| Pair { was: were[*e], is: &candidates[*s] }).collect();
        let shift = pairs.iter().map(|p| self.odometer.drift_since(&p.was.odometer).0).fold(0.0, f64::max);
        Some((pairs, shift))
    }

    /// The pose by what is known again; if it is one place, its points have distances from the start.
    fn know_again(&mut self, id: KeyframeId, camera: &Pose, fix: Option<Fix>, pairs: &[Pair], shift: f64) {
        let sight = |p: &Pair| {
            let Remembered { keyframe, ray, rho, sigma_rho, .. } = p.was;
            pose::Sight { anchor: *self.map.pose(keyframe), ray, rho, sigma_rho, seen: p.is.ray }
        };
        let sights: Vec<pose::Sight> = pairs.iter().map(sight).collect();
        let turn = pairs.iter().map(|p| self.odometer.drift_since(&p.was.odometer).1).fold(0.0, f64::max);
        let prior = pose::PosePrior { pose: *camera, sigma_move: shift, sigma_turn_rad: turn, fix };
        let fit = pose::solve(&sights, &prior, FOUND_AGAIN * self.sigma_rad());
        let agree: Vec<&Pair> = pairs.iter().zip(&fit.squared).filter(|(_, s)| **s < pose::AGREES).map(|(p, _)| p).collect();
        if agree.len() < PLACE_POINTS || (agree.len() as f64) < PLACE_SHARE * pairs.len() as f64 {
            return;
        }
        let distance = |p: &Pair| direction(self.map.pose(p.was.keyframe), &p.was.ray, p.was.rho, &fit.pose).norm() / p.was.rho;
        let distances: Vec<f64> = agree.iter().map(|p| distance(p)).collect();
        let held = self.in_view().filter(|l| l.has_depth()).count() >= HELD;
        // Whoever has no unit of his own takes that of the place.
        let scale = if held { self.scale(camera, &agree, &distances) } else { Some(1.0) };
        let far = distances.iter().sum::<f64>() / distances.len() as f64;
        if shift > WORTH * far {
            self.link(id, &fit.pose, &agree, far, scale);
        }
        if scale.is_some_and(|s| s < SAME_UNIT.0 || s > SAME_UNIT.1) {
            return;
        }
        if !held {
            let before = KeyframeId(id.0.saturating_sub(1));
            let reached = self.map.pose(before).inverse() * camera;
            if let Some(passage) = self.passages.last_mut() {
                passage.reached = Some(reached);
            }
            self.map.leap(fit.pose);
            if let Stage::Tracking(motion) = &mut self.stage {
                motion.pose = fit.pose;
            }
        }
        for (pair, distance) in agree.iter().zip(&distances) {
            let share = (pair.was.sigma_rho / pair.was.rho).hypot(KNOWN_AGAIN);
            self.give_distance(id, pair.is, (distance.recip(), share * distance.recip()));
        }
    }

    /// How many of the memory's units one of the map's has, by points whose distance both know.
    fn scale(&self, camera: &Pose, agree: &[&Pair], distances: &[f64]) -> Option<f64> {
        let ratio = |(pair, distance): (&&Pair, &f64)| {
            let landmark = self.map.landmarks.get(&pair.is.followed?).filter(|l| l.has_depth())?;
            Some(distance * landmark.rho / self.map.direction(landmark, camera).norm())
        };
        let ratios: Vec<f64> = agree.iter().zip(distances).filter_map(ratio).collect();
        (ratios.len() >= SCALE_POINTS).then(|| median(ratios))
    }

    fn link(&mut self, b: KeyframeId, odom_from_b: &Pose, agree: &[&Pair], far: f64, scale: Option<f64>) {
        let mut counts: BTreeMap<KeyframeId, usize> = BTreeMap::new();
        agree.iter().for_each(|p| *counts.entry(p.was.keyframe).or_default() += 1);
        let Some((a, _)) = counts.into_iter().max_by_key(|(keyframe, count)| (*count, *keyframe)) else { return };
        self.links.push(Link { a, b, a_from_b: self.map.pose(a).inverse() * odom_from_b, scale, far });
    }

    /// A point of this keyframe that was known again has a distance from the start.
    fn give_distance(&mut self, id: KeyframeId, point: &Candidate, born @ (rho, sigma_rho): (f64, f64)) {
        let knows = |track: &TrackId| self.map.landmarks.get(track).is_some_and(Landmark::has_depth);
        let track = match point.followed {
            Some(track) if knows(&track) => return,
            Some(track) => track,
            None => match self.tracker.follow_from(&[point.pixel]).as_slice() {
                [fresh, ..] => fresh.id,
                [] => return,
            },
        };
        let (ray, seen) = (point.ray, Vec::new());
        self.map.landmarks.insert(track, Landmark { anchor: id, ray, rho, sigma_rho, born, prior: born, seen, strikes: 0 });
    }

    /// Remembers the followed points as they are at this keyframe; those that only begin here are as they were remembered.
    fn remember_followed(&mut self, id: KeyframeId, candidates: &[Candidate]) {
        let camera = *self.map.pose(id);
        for (track, candidate) in candidates.iter().filter_map(|c| Some((c.followed?, c))) {
            let sound = |l: &&Landmark| l.has_depth() && l.strikes == 0 && l.anchor != id;
            let Some(landmark) = self.map.landmarks.get(&track).filter(sound) else { continue };
            let nearer = 1.0 / self.map.direction(landmark, &camera).norm();
            let (rho, sigma_rho) = (landmark.rho * nearer, landmark.sigma_rho * nearer);
            let (ray, looks, odometer) = (candidate.ray, candidate.looks, self.odometer);
            self.memory.remember(track, Remembered { keyframe: id, ray, rho, sigma_rho, looks, odometer });
        }
    }
}

#[cfg(test)]
mod tests {
    use planwalk_sim::Scene;
    use planwalk_types::{GrayImage, Seed, Stamp, TrackingState, VideoFrame};

    use super::*;
    use crate::visual::odometry::OdometryOptions;

    /// The walker stops, a hand covers the lens for a second, and the view comes back: twice the same pictures.
    #[test]
    fn behind_a_hand_the_points_and_their_distances_are_known_again() {
        let scene = Scene::demo(Seed(9));
        let mut odometry = VisualOdometry::new(scene.camera().clone(), OdometryOptions::default());
        let frames: Vec<VideoFrame> = scene.frames().take(48).collect();
        let (first, step) = (frames[0].stamp, frames[1].stamp.0 - frames[0].stamp.0);
        let at = |i: usize| Stamp(first.0 + i as i64 * step);
        for frame in &frames {
            odometry.push(frame).unwrap();
        }
        let before = odometry.posed.last().map(|p| odometry.map.pose(p.reference.unwrap()) * p.reference_from_camera).unwrap();
        let (width, height) = (frames[0].image.width(), frames[0].image.height());
        for i in 48..63 {
            let image = GrayImage::from_fn(width, height, |u, v| ((u * 7 + v * 13 + i) % 3) as u8);
            let report = odometry.push(&VideoFrame { stamp: at(i), image }).unwrap();
            assert!(i < 50 || report.state == TrackingState::Propagated, "{i}: {:?}", report.state);
        }
        let links = odometry.links.len();
        let last = &frames[47].image;
        // A grey value more makes it no repeat.
        let image = GrayImage::from_fn(width, height, |u, v| last.row(v)[u].saturating_add(((u + v) % 2) as u8));
        odometry.push(&VideoFrame { stamp: at(63), image }).unwrap();
        let known = odometry.in_view().filter(|l| l.has_depth()).count();
        assert!(known >= PLACE_POINTS, "{known} points with a distance");
        let after = odometry.map.pose(odometry.map.newest().unwrap());
        // Corners are found to a pixel or two: a few thousandths of the distance, and of a radian.
        let moved = (after.translation.vector - before.translation.vector).norm();
        assert!(moved < 0.1 && after.rotation.angle_to(&before.rotation) < 0.01, "{moved}, {}", after.rotation.angle_to(&before.rotation));
        assert_eq!(odometry.links.len(), links + 1);
    }
}
