//! Which of the points in view were seen before, and what do they say of the place and of the unit of length?

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::{Stage, VisualOdometry};
use crate::visual::axes::Fix;
use crate::visual::map::{KeyframeId, Landmark, Pose, direction, pose};
use crate::visual::recall::descriptor::Descriptor;
use crate::visual::recall::matching::{self, Expected, Seen};
use crate::visual::recall::{Odometer, Remembered};
use crate::visual::track::TrackId;

/// A point of the newest picture: one that is followed, or a corner that might be.
struct Candidate {
    followed: Option<TrackId>,
    pixel: (f64, f64),
    ray: Vector3<f64>,
    looks: Descriptor,
}

/// Fewest points that make a place, and the share of the pairs that must agree on it.
const PLACE_POINTS: usize = 12;
const PLACE_SHARE: f64 = 0.6;
/// Points with a distance that hold a frame by themselves.
const HELD: usize = 10;
/// Error of a distance that was known again, besides its own, as a share of it.
const KNOWN_AGAIN: f64 = 0.1;
/// Standard deviations within which a point is looked for, and the widest gate, radians.
const GATE: f64 = 2.5;
const WIDEST_RAD: f64 = 0.6;
/// Units of way within which memories share their drift.
const TOGETHER: f64 = 3.0;

impl VisualOdometry {
    /// Knows lost points again in a keyframe that was just taken, and remembers those that are in view.
    pub(super) fn recall(&mut self, id: KeyframeId, fix: Option<Fix>) {
        let camera = *self.map.pose(id);
        let up = camera.rotation.inverse() * self.compass.up();
        let roll = libm::atan2(up.x, -up.y);
        let candidates = self.candidates(roll);
        self.know_again(id, &camera, &candidates, fix);
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

    fn remember_followed(&mut self, id: KeyframeId, candidates: &[Candidate]) {
        let camera = *self.map.pose(id);
        for (track, candidate) in candidates.iter().filter_map(|c| Some((c.followed?, c))) {
            let Some(landmark) = self.map.landmarks.get(&track).filter(|l| l.has_depth() && l.strikes == 0) else { continue };
            // Landmarks that only begin are as they were remembered.
            if landmark.anchor == id {
                continue;
            }
            let nearer = 1.0 / self.map.direction(landmark, &camera).norm();
            let (rho, sigma_rho) = (landmark.rho * nearer, landmark.sigma_rho * nearer);
            let (ray, looks, odometer) = (candidate.ray, candidate.looks, self.odometer);
            self.memory.remember(track, Remembered { keyframe: id, ray, rho, sigma_rho, looks, odometer });
        }
    }

    /// Remembered points that should be in view, and how they should look.
    fn expected(&self, camera: &Pose) -> Vec<(TrackId, Remembered, Expected)> {
        let followed: BTreeSet<TrackId> = self.tracker.tracks().iter().map(|t| t.id).collect();
        let expect = |(id, point): (TrackId, &Remembered)| {
            let (shift, turn) = self.odometer.drift_since(&point.odometer);
            let direction = direction(self.map.pose(point.keyframe), &point.ray, point.rho, camera);
            let (ray, nearer) = (direction.normalize(), 1.0 / direction.norm());
            let gate_rad = (GATE * (turn + shift * point.rho * nearer)).min(WIDEST_RAD);
            let octaves = libm::round(libm::log2(nearer)) as i32;
            let axis = ray.angle(&Vector3::z());
            let expected = Expected { ray, gate_rad, octaves, looks: point.looks };
            (axis < 1.0 && octaves.abs() <= 1).then_some((id, *point, expected))
        };
        self.memory.points().filter(|(id, _)| !followed.contains(id)).filter_map(expect).collect()
    }

    fn know_again(&mut self, id: KeyframeId, camera: &Pose, candidates: &[Candidate], fix: Option<Fix>) {
        let expected = self.expected(camera);
        if expected.len() < PLACE_POINTS {
            return;
        }
        let wanted: Vec<Expected> = expected.iter().map(|e| e.2).collect();
        let seen: Vec<Seen> = candidates.iter().map(|c| Seen { ray: c.ray, looks: c.looks }).collect();
        let pairs = matching::matches(&wanted, &seen);
        // The stretch of way from which most are known again.
        let way_of = |pair: &(usize, usize)| expected[pair.0].1.odometer.way;
        let near = |way: f64| pairs.iter().copied().filter(|pair| (way_of(pair) - way).abs() < TOGETHER).collect::<Vec<_>>();
        let Some(way) = pairs.iter().map(way_of).max_by_key(|way| (near(*way).len(), (way * 1e3) as i64)) else { return };
        let pairs = near(way);
        let (shift, turn) = pairs.iter().fold((0.0, 0.0), |(shift, turn): (f64, f64), (e, _)| {
            let drift = self.odometer.drift_since(&expected[*e].1.odometer);
            (shift.max(drift.0), turn.max(drift.1))
        });
        let sights: Vec<pose::Sight> = pairs
            .iter()
            .map(|(e, s)| {
                let point = &expected[*e].1;
                let anchor = *self.map.pose(point.keyframe);
                pose::Sight { anchor, ray: point.ray, rho: point.rho, sigma_rho: point.sigma_rho, seen: candidates[*s].ray }
            })
            .collect();
        let prior = pose::PosePrior { pose: *camera, sigma_move: shift, sigma_turn_rad: turn, fix };
        let fit = pose::solve(&sights, &prior, 2.0 * self.sigma_rad());
        let agree: Vec<usize> = (0..pairs.len()).filter(|i| fit.squared[*i] < pose::AGREES).collect();
        let known = self.in_view().filter(|l| l.has_depth()).count();
        if std::env::var("DBGR").is_ok() && pairs.len() >= 8 {
            let d = pose::difference(camera, &fit.pose);
            let ratios: Vec<f64> = agree.iter().filter_map(|i| {
                let (e, s) = pairs[*i];
                let l = self.map.landmarks.get(&candidates[s].followed?)?;
                if !l.has_depth() { return None; }
                let p = &expected[e].1;
                let old = p.rho / direction(self.map.pose(p.keyframe), &p.ray, p.rho, &fit.pose).norm();
                let now = l.rho / self.map.direction(l, camera).norm();
                Some(old / now)
            }).collect();
            let n = ratios.len();
            eprintln!("R {:.2} kf {} expected {} seen {} pairs {} agree {} known {} dway {:.2} drift {:.2} {:.3} moved {:.3} turned {:.3} ratio {:.3} of {}", self.map.keyframes[id.0].stamp.as_secs(), id.0, expected.len(), seen.len(), pairs.len(), agree.len(), known, self.odometer.way - way, shift, turn, d.fixed_rows::<3>(3).norm(), d.fixed_rows::<3>(0).norm(), crate::visual::two_view::rotation::median(ratios), n);
        }
        if agree.len() < PLACE_POINTS || (agree.len() as f64) < PLACE_SHARE * pairs.len() as f64 {
            return;
        }
        let known = self.in_view().filter(|l| l.has_depth()).count();
        if known < HELD {
            self.map.keyframes[id.0].pose = fit.pose;
            if let Stage::Tracking(motion) = &mut self.stage {
                motion.pose = fit.pose;
            }
        }
        for (e, s) in agree.into_iter().map(|i| pairs[i]) {
            let (point, candidate) = (&expected[e].1, &candidates[s]);
            let nearer = 1.0 / direction(self.map.pose(point.keyframe), &point.ray, point.rho, &fit.pose).norm();
            let rho = point.rho * nearer;
            self.give_distance(id, candidate, (rho, (point.sigma_rho * nearer).hypot(KNOWN_AGAIN * rho)));
        }
    }

    /// A point of this keyframe that was known again has a distance from the start.
    fn give_distance(&mut self, id: KeyframeId, candidate: &Candidate, born @ (rho, sigma_rho): (f64, f64)) {
        let knows = |track: &TrackId| self.map.landmarks.get(track).is_some_and(Landmark::has_depth);
        let track = match candidate.followed {
            Some(track) if knows(&track) => return,
            Some(track) => track,
            None => match self.tracker.follow_from(&[candidate.pixel]).as_slice() {
                [fresh, ..] => fresh.id,
                [] => return,
            },
        };
        let (ray, seen) = (candidate.ray, Vec::new());
        self.map.landmarks.insert(track, Landmark { anchor: id, ray, rho, sigma_rho, born, prior: born, seen, strikes: 0 });
    }
}
