//! Which way is up, and how far has odometry turned away from the building? A compass whose north is a wall.
//!
//! edges of the first second ─▶ [`Axes`] ─▶ edges of a frame ─▶ [`Fix`] ─▶ a Kalman filter of odometry's error ─▶ [`Steering`]
//!
//! Until the axes show, and where the building has none, up is as people hold cameras ([`Upright`]) and nothing is steered.
//!
//! Pitfall: a wing that stands askew has axes of its own. Where most edges keep to no axis for seconds, the axes are forgotten and
//! found again, beside odometry as it then is: they pull at nothing that lies between.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::axes::{Axes, Fix};
use super::lines::Edge;
use super::track::FEW;
use crate::upright::Upright;

/// Points under which a frame's rotation may be wrong for all that they say.
const WEAK: usize = 25;
/// Squared Mahalanobis distance up to which odometry may have turned: 99 % of a 3-degree chi-square. The stripes of a poster agree
/// on many a rotation.
const POSSIBLE: f64 = 11.3;
/// A camera is never held further from upright than this, 45°: of the rotations that the edges of a box allow, the others lie on its
/// side.
const UPRIGHT_RAD: f64 = 0.785;
/// Seconds of agreement after a weak frame until a fix may no longer be searched for: a wing that stands askew must not be taken
/// for a lost turn.
const SEARCH_S: f64 = 3.0;
/// Edges that are collected before the axes are looked for, and frames that they come from at least.
const COLLECTED: usize = 500;
const COLLECTED_FRAMES: usize = 15;
/// Turns about the vertical that are tried when odometry may have turned far, and tilts: beyond 45° the next quarter is as good.
const YAWS_DEG: [f64; 9] = [0.0, -10.0, 10.0, -20.0, 20.0, -30.0, 30.0, -40.0, 40.0];
const TILTS_DEG: [f64; 5] = [0.0, -10.0, 10.0, -20.0, 20.0];
/// Share of a frame's edges under which a fix is doubted, and over which one that was searched for is believed.
const DOUBTED: f64 = 0.35;
const SURE: f64 = 0.55;
/// Fewest edges that can be doubted, or believed.
const ENOUGH: usize = 15;
/// Doubted frames, less the others, after which the axes are those of another place.
const PATIENCE: u32 = 150;
/// How odometry's rotation drifts: 2° a √second. Mostly it is less; before a near wall alone, whose motion is two-fold, it is more.
const DRIFT_RAD2_S: f64 = 1.2e-3;
/// The same while few points or none are seen, and heads go on turning: 20° a √second.
const BLIND_RAD2_S: f64 = 0.12;
/// A fix further off than this was searched for, 8°; odometry may then have turned far: 30°.
const FAR_RAD: f64 = 0.14;
const FAR_RAD2: f64 = 0.25;
/// After a cut it may look anywhere: 60°, of which only the part within a quarter turn can ever be told.
const CUT_RAD2: f64 = 1.0;
/// Error of a fix besides its information, 0.6°, which lasts as long as the view does.
const SHARED_RAD2: f64 = 1.1e-4;
const SHARED_S: f64 = 1.0;
/// How well up is known as people hold cameras, 9°.
const HELD_RAD: f64 = 0.16;
/// Share of what was seen of gravity that is kept from one keyframe to the next: odometry's own frame tilts within a minute.
const UPRIGHT_KEEPS: f64 = 0.97;

/// Up and heading, held by the building's edges.
#[derive(Debug, Clone, Default)]
pub struct Compass {
    upright: Upright,
    axes: Option<Axes>,
    collected: Vec<Edge>,
    frames: usize,
    doubted: u32,
    /// Seconds, since a weak frame, in which the edges agreed with odometry.
    sound_s: f64,
    covariance: Matrix3<f64>,
    /// Sum of the axes' up over the frames that they fixed.
    ups: Vector3<f64>,
}

/// What a frame's edges say to odometry.
#[derive(Debug, Clone, Copy)]
pub struct Steering {
    /// What to turn everything by, odom's frame.
    pub turn: UnitQuaternion<f64>,
    /// The frame's rotation.
    pub fix: Fix,
}

impl Compass {
    /// The unit vector that points up, odom's frame: as the building's edges say, else as people hold cameras.
    pub fn up(&self) -> Vector3<f64> {
        self.axes.map_or_else(|| self.upright.up(), |a| a.0[0])
    }

    /// Up in the mean of the frames that the building's edges fixed; `None` if they fixed none.
    pub fn level(&self) -> Option<Vector3<f64>> {
        self.ups.try_normalize(0.5)
    }

    /// How sure up is in the newest frame: standard deviation of its direction, radians.
    pub fn tilt_sigma_rad(&self) -> f64 {
        let Some(axes) = &self.axes else { return HELD_RAD };
        self.tilt_variance(&axes.0[0]).max(0.0).sqrt().min(HELD_RAD)
    }

    /// Variance of a tilt: turns about the vertical leave up where it is.
    fn tilt_variance(&self, up: &Vector3<f64>) -> f64 {
        0.5 * (self.covariance.trace() - (up.transpose() * self.covariance * up).x)
    }

    /// Takes in how a keyframe's camera was held.
    pub fn held(&mut self, rotation: &UnitQuaternion<f64>) {
        self.upright.fade(UPRIGHT_KEEPS);
        self.upright.add_camera(rotation, 1.0);
    }

    /// The frame's rotation by its edges, near the predicted one; or far from it, if odometry was weak and most edges agree there.
    pub fn fix(&self, edges: &[Edge], predicted: &UnitQuaternion<f64>) -> Option<Fix> {
        let axes = self.axes.as_ref()?;
        let near = axes.fix(edges, predicted);
        if !doubted(&near, edges) {
            return near;
        }
        if self.sound_s > SEARCH_S {
            return None;
        }
        let from = |yaw: f64, pitch: f64, roll: f64| {
            let turned = UnitQuaternion::from_scaled_axis(axes.0[0] * yaw.to_radians()) * predicted;
            turned * UnitQuaternion::from_scaled_axis(Vector3::new(pitch.to_radians(), 0.0, roll.to_radians()))
        };
        let tilts = TILTS_DEG.iter().flat_map(|pitch| TILTS_DEG.map(|roll| (*pitch, roll)));
        let tried = tilts.flat_map(|(pitch, roll)| YAWS_DEG.map(|yaw| from(yaw, pitch, roll)));
        let spread = self.covariance.try_inverse()?;
        let possible = |fix: &Fix| {
            let off = (fix.rotation * predicted.inverse()).scaled_axis();
            let upright = (fix.rotation.inverse() * axes.0[0]).angle(&-Vector3::y()) < UPRIGHT_RAD;
            upright && (off.transpose() * spread * off).x < POSSIBLE
        };
        let best = tried.filter_map(|start| axes.fix(edges, &start)).filter(possible).max_by_key(|f| f.edges);
        best.filter(|f| f.edges >= ENOUGH && f.edges as f64 > SURE * edges.len() as f64 && f.heading)
    }

    /// What the edges say of a frame that odometry posed at `rotation` by so many `points`, `seconds` after the one before.
    /// `None` where they say nothing.
    pub fn steer(&mut self, edges: &[Edge], rotation: &UnitQuaternion<f64>, seconds: f64, points: usize) -> Option<Steering> {
        self.drift(seconds * if points < FEW { BLIND_RAD2_S } else { DRIFT_RAD2_S });
        if self.axes.is_none() {
            self.collect(edges, rotation);
        }
        let fix = self.fix(edges, rotation);
        self.doubt(fix.is_some(), edges);
        self.sound_s = match fix {
            _ if points < WEAK => 0.0,
            Some(_) => self.sound_s + seconds,
            None => self.sound_s,
        };
        let fix = fix?;
        self.ups += self.up();
        let off = (fix.rotation * rotation.inverse()).scaled_axis();
        if off.norm() > FAR_RAD {
            self.covariance += Matrix3::identity() * FAR_RAD2;
        }
        let turn = rotation.to_rotation_matrix();
        let own = (fix.information + Matrix3::identity()).try_inverse()?;
        let own = turn.matrix() * own * turn.matrix().transpose() + Matrix3::identity() * SHARED_RAD2;
        // Fixes of one view err together: thirty in its second count as one.
        let noise = own * (SHARED_S / seconds.max(1e-3)).max(1.0);
        let gain = self.covariance * (self.covariance + noise).try_inverse()?;
        self.covariance -= gain * self.covariance;
        Some(Steering { turn: UnitQuaternion::from_scaled_axis(gain * off), fix })
    }

    /// Odometry turns away by this variance; up, only until it is known as people hold cameras.
    fn drift(&mut self, variance: f64) {
        let up = self.up();
        let about = up * up.transpose();
        let tilt = variance.min((HELD_RAD * HELD_RAD - self.tilt_variance(&up)).max(0.0));
        self.covariance += about * variance + (Matrix3::identity() - about) * tilt;
    }

    /// The video was cut: the camera may look anywhere, and the next edges that agree are to be believed.
    pub fn cut(&mut self) {
        self.drift(CUT_RAD2);
        self.sound_s = 0.0;
    }

    /// Collects edges until the building's axes show.
    fn collect(&mut self, edges: &[Edge], rotation: &UnitQuaternion<f64>) {
        self.collected.extend(edges.iter().map(|e| e.turned(rotation)));
        self.frames += 1;
        if self.collected.len() < COLLECTED || self.frames < COLLECTED_FRAMES {
            return;
        }
        self.axes = Axes::find(&self.collected, &self.upright.up());
        // No axes in these: perhaps with the next ones.
        self.collected.drain(..self.collected.len() / 2);
        self.frames /= 2;
    }

    /// Forgets the axes when most edges have kept to none of them for long.
    fn doubt(&mut self, fixed: bool, edges: &[Edge]) {
        if edges.len() < ENOUGH || self.axes.is_none() {
            return;
        }
        self.doubted = if fixed { self.doubted.saturating_sub(1) } else { self.doubted + 1 };
        if self.doubted > PATIENCE {
            *self = Self { upright: self.upright.clone(), covariance: self.covariance, ups: self.ups, ..Self::default() };
        }
    }
}

/// Whether most edges disagree with the fix: of those that are not upright, because upright ones agree in any wing.
fn doubted(fix: &Option<Fix>, edges: &[Edge]) -> bool {
    let (agree, upright) = fix.map_or((0, 0), |f| (f.edges, f.upright));
    let level = edges.len() - upright;
    level >= ENOUGH && ((agree - upright) as f64) < DOUBTED * level as f64
}

#[cfg(test)]
mod tests {
    use super::super::axes::tests::{box_edges, seen_from};
    use super::*;

    fn turned(yaw: f64, pitch: f64) -> UnitQuaternion<f64> {
        // Camera axes: x right, y down, z forward; up is −y.
        UnitQuaternion::from_scaled_axis(Vector3::y() * yaw) * UnitQuaternion::from_scaled_axis(Vector3::x() * pitch)
    }

    /// A compass that has looked about for four seconds.
    fn settled(seed: u64) -> Compass {
        let mut compass = Compass::default();
        for i in 0..120 {
            let rotation = turned(0.01 * f64::from(i), 0.1);
            compass.held(&rotation);
            compass.steer(&seen_from(&box_edges(seed + u64::from(i as u32), 60, 0.0), &rotation, 1e-3, seed), &rotation, 1.0 / 30.0, 60);
        }
        compass
    }

    #[test]
    fn a_drift_is_steered_back() {
        let mut compass = settled(1);
        let up = compass.up();
        assert!(up.angle(&-Vector3::y()) < 0.009, "gravity to half a degree: {up}");
        let mut drift = UnitQuaternion::identity();
        for i in 0..300u32 {
            // Half a degree a second, for ten seconds.
            drift = UnitQuaternion::from_scaled_axis(Vector3::y() * (0.5f64.to_radians() / 30.0)) * drift;
            let truth = turned(1.2 + 0.01 * f64::from(i), 0.05);
            let posed = drift * truth;
            let edges = seen_from(&box_edges(u64::from(i), 40, 0.3), &truth, 1e-3, u64::from(i));
            if let Some(steering) = compass.steer(&edges, &posed, 1.0 / 30.0, 60) {
                drift = steering.turn * drift;
            }
        }
        // The filter lags by a second of drift at most.
        assert!(drift.angle() < 0.01, "{}°", drift.angle().to_degrees());
    }

    #[test]
    fn a_turn_that_was_lost_is_found_again_when_most_edges_agree() {
        let mut compass = settled(2);
        let truth = turned(0.3, 0.0);
        let lost = UnitQuaternion::from_scaled_axis(Vector3::new(0.15, 0.45, -0.1)) * truth;
        let edges = seen_from(&box_edges(5, 80, 0.1), &truth, 1e-3, 5);
        assert!(compass.fix(&edges, &lost).is_none_or(|f| f.rotation.angle_to(&truth) > 0.2), "nothing was lost yet");
        assert!(compass.steer(&[], &lost, 1.0 / 30.0, 3).is_none());
        assert!(compass.fix(&edges, &lost).is_none(), "in a single frame no head turns by 28°");
        for _ in 0..15 {
            assert!(compass.steer(&[], &lost, 1.0 / 30.0, 3).is_none());
        }
        let fix = compass.fix(&edges, &lost).unwrap();
        assert!(fix.rotation.angle_to(&truth) < 0.01, "{}", fix.rotation.angle_to(&truth));
        let steering = compass.steer(&edges, &lost, 1.0 / 30.0, 3).unwrap();
        // One frame is not believed at once, but by most.
        assert!((steering.turn * lost).angle_to(&truth) < 0.2 * lost.angle_to(&truth));
    }

    #[test]
    fn another_wing_gets_axes_of_its_own() {
        let mut compass = settled(3);
        let askew = UnitQuaternion::from_scaled_axis(Vector3::y() * 0.5);
        for i in 0..400u32 {
            let posed = turned(0.01 * f64::from(i), 0.05);
            // A building turned by 29° against the one that the compass knows.
            let edges = seen_from(&box_edges(u64::from(i), 60, 0.0), &(askew.inverse() * posed), 1e-3, u64::from(i));
            compass.held(&posed);
            let steering = compass.steer(&edges, &posed, 1.0 / 30.0, 60);
            let pulled = steering.map_or(0.0, |s| s.turn.angle());
            assert!(pulled < 0.035, "frame {i} is turned by {pulled} rad");
        }
        let last = turned(4.0, 0.05);
        let fix = compass.fix(&seen_from(&box_edges(9, 60, 0.0), &(askew.inverse() * last), 1e-3, 9), &last).unwrap();
        assert!(fix.rotation.angle_to(&last) < 0.02, "the new wing's north is where odometry has it");
    }
}
