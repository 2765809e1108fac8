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

/// Most points that are remembered: 200 bytes each, six minutes of a walk at a hundred new ones a second.
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
