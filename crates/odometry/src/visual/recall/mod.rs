//! Was this point seen before? What is remembered of points that left the view, and how they are known again.
//!
//! followed points at a keyframe ─▶ [`descriptor`] ─▶ [`Memory`] ─▶ expected in a later picture ─▶ [`matching`] ─▶ pairs
//!
//! A person who walks past, a blank wall, or a glance aside loses points whose distances were known; known again, they hold the unit of
//! length and the place (Klein & Murray 2007 and Mur-Artal & Tardós 2017 track their whole map so).

pub mod descriptor;
pub mod matching;

use std::collections::BTreeMap;

use nalgebra::Vector3;
use planwalk_types::TrackingState;

use crate::visual::map::KeyframeId;
use crate::visual::track::TrackId;
use descriptor::Descriptor;

/// Most points that are remembered: 200 bytes each, five minutes of a walk that sees a hundred new ones a second.
const MOST: usize = 30_000;

/// How far and how blindly odometry went since the walk began: what of a memory may have drifted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Odometer {
    /// Length of the way, units.
    pub way: f64,
    /// Units of it that no point with a distance measured.
    pub adrift: f64,
    /// Seconds in which nothing said how the camera turned.
    pub blind_s: f64,
}

/// What a cut counts as: units of way that nothing measured, and seconds of turning that nothing told.
const CUT: (f64, f64) = (3.0, 5.0);
/// Share of the usual speed at which a walk that nothing measures goes on, for all that is known.
const UNSEEN_SPEED: f64 = 0.5;

impl Odometer {
    /// Goes on by a frame.
    pub fn go(&mut self, state: TrackingState, seconds: f64, way: f64, usual_speed: f64) {
        self.way += way;
        if state != TrackingState::Mapped {
            self.adrift += way.max(UNSEEN_SPEED * usual_speed * seconds);
        }
        if state == TrackingState::Propagated {
            self.blind_s += seconds;
        }
    }

    /// Goes on past a cut.
    pub fn cut(&mut self) {
        self.adrift += CUT.0;
        self.blind_s += CUT.1;
    }

    /// Standard deviations of position (units) and of rotation (radians) since `then`.
    pub fn drift_since(&self, then: &Self) -> (f64, f64) {
        let shift = 0.05 + 0.03 * (self.way - then.way) + 0.7 * (self.adrift - then.adrift);
        (shift, 0.01 + 0.1 * (self.blind_s - then.blind_s))
    }
}

/// A point as it was when it was last seen from a keyframe.
#[derive(Debug, Clone, Copy)]
pub struct Remembered {
    /// That keyframe.
    pub keyframe: KeyframeId,
    /// Unit ray there, camera frame.
    pub ray: Vector3<f64>,
    /// Inverse distance from there, 1 / unit.
    pub rho: f64,
    /// Standard deviation of it.
    pub sigma_rho: f64,
    /// How it looked.
    pub looks: Descriptor,
    /// When, in the walk's own measure.
    pub odometer: Odometer,
}

/// Points that had a distance.
#[derive(Debug, Clone, Default)]
pub struct Memory {
    points: BTreeMap<TrackId, Remembered>,
}

impl Memory {
    /// Remembers the point as it is now.
    pub fn remember(&mut self, id: TrackId, point: Remembered) {
        if self.points.len() >= MOST && !self.points.contains_key(&id) {
            self.points.pop_first();
        }
        self.points.insert(id, point);
    }

    /// Forgets a point: it moves by itself.
    pub fn forget(&mut self, id: TrackId) {
        self.points.remove(&id);
    }

    /// All remembered points, oldest first.
    pub fn points(&self) -> impl Iterator<Item = (TrackId, &Remembered)> {
        self.points.iter().map(|(id, point)| (*id, point))
    }

    /// Multiplies the distances of what was last seen since this keyframe by `factor`.
    pub fn rescale(&mut self, factor: f64, since: KeyframeId) {
        for point in self.points.values_mut().filter(|p| p.keyframe >= since) {
            (point.rho, point.sigma_rho) = (point.rho / factor, point.sigma_rho / factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use planwalk_types::GrayImage;

    use super::*;
    use crate::visual::image::Pyramid;
    use descriptor::Pattern;

    fn point(keyframe: usize) -> Remembered {
        let pyramid = Pyramid::new(&GrayImage::from_fn(128, 128, |u, v| (u * 3 + v) as u8), 3);
        let looks = Pattern::new(0.0).describe(&pyramid, (64.0, 64.0)).expect("inside");
        let (ray, odometer) = (Vector3::z(), Odometer::default());
        Remembered { keyframe: KeyframeId(keyframe), ray, rho: 0.5, sigma_rho: 0.1, looks, odometer }
    }

    #[test]
    fn memory_is_bounded_and_forgets_the_oldest_first() {
        let (mut memory, one) = (Memory::default(), point(0));
        (0..MOST as u64 + 5).for_each(|id| memory.remember(TrackId(id), one));
        assert_eq!((memory.points().count(), memory.points().next().map(|p| p.0)), (MOST, Some(TrackId(5))));
        memory.remember(TrackId(5), one);
        memory.forget(TrackId(9));
        assert_eq!(memory.points().count(), MOST - 1, "one that is known takes no place, one that moves none at all");
    }

    #[test]
    fn distances_since_a_keyframe_are_in_its_unit() {
        let mut memory = Memory::default();
        (0..4).for_each(|k| memory.remember(TrackId(k), point(k as usize)));
        memory.rescale(2.0, KeyframeId(2));
        let found: Vec<(f64, f64)> = memory.points().map(|(_, p)| (p.rho, p.sigma_rho)).collect();
        assert_eq!(found, [(0.5, 0.1), (0.5, 0.1), (0.25, 0.05), (0.25, 0.05)]);
    }

    #[test]
    fn what_nothing_measured_may_have_drifted_further() {
        let (start, mut walked, mut blind) = (Odometer::default(), Odometer::default(), Odometer::default());
        for _ in 0..30 {
            walked.go(TrackingState::Mapped, 0.033, 0.04, 1.2);
            blind.go(TrackingState::Propagated, 0.033, 0.0, 1.2);
        }
        assert!((walked.way - 1.2).abs() < 1e-9 && walked.adrift == 0.0 && walked.blind_s == 0.0);
        // Nobody saw it move, but at half its usual speed it may have.
        assert!((blind.adrift - 0.6 * 0.99).abs() < 1e-9 && (blind.blind_s - 0.99).abs() < 1e-9);
        let (seen, unseen) = (walked.drift_since(&start), blind.drift_since(&start));
        assert!(unseen.0 > 3.0 * seen.0 && unseen.1 > 5.0 * seen.1);
        let mut parted = start;
        parted.cut();
        assert!(parted.drift_since(&start) > (2.0, 0.5), "after a cut it may be a room further on");
    }
}
