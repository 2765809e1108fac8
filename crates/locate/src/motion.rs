//! How does a step of odometry move a particle, in the particle's own scale?
//!
//! `Step` ──compose──▶ Motion (since the last update) ──▶ MoveSampler ──▶ (forward, left, turn) a particle
//!
//! Lengths are in the odometry's unit until the particle's scale makes them metres. Covariances compose to first order
//! (Smith & Cheeseman 1986), so that the filter's cost does not grow with the frame rate.

use nalgebra::{Matrix3, Vector3};
use planwalk_types::{Step, wrap_angle};
use rand::Rng;

/// The body's motion over some steps, seen from where it began; odometry's unit, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Motion {
    pub forward: f64,
    pub left: f64,
    pub turn_rad: f64,
    /// Covariance of (forward, left, turn).
    pub covariance: Matrix3<f64>,
    /// Way gone, which is longer than the distance made.
    pub length: f64,
    /// Sum of absolute turns.
    pub turned_rad: f64,
    /// Variance of the logarithm of the change of unit (see [`Step::unit_change`]).
    pub unit_variance: f64,
}

/// Motions whose end is less known than this, and than they are long, are jumps, units: no gap of odometry that goes on grows so far.
const JUMP: f64 = 3.0;

impl Motion {
    pub(crate) fn none() -> Self {
        Self { forward: 0.0, left: 0.0, turn_rad: 0.0, covariance: Matrix3::zeros(), length: 0.0, turned_rad: 0.0, unit_variance: 0.0 }
    }

    /// The motion of `share` of a step.
    pub(crate) fn of(step: &Step, share: f64) -> Self {
        let (forward, left, turn_rad) = (share * step.forward, share * step.left, share * step.turn_rad);
        let unit_variance = share * step.unit_change * step.unit_change;
        let covariance = step.covariance * share;
        Self { forward, left, turn_rad, covariance, length: forward.hypot(left), turned_rad: turn_rad.abs(), unit_variance }
    }

    /// This motion followed by another.
    pub(crate) fn then(&self, next: &Motion) -> Self {
        let (s, c) = libm::sincos(self.turn_rad);
        let moved = (c * next.forward - s * next.left, s * next.forward + c * next.left);
        let by_start = Matrix3::new(1.0, 0.0, -moved.1, 0.0, 1.0, moved.0, 0.0, 0.0, 1.0);
        let by_next = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        Self {
            forward: self.forward + moved.0,
            left: self.left + moved.1,
            turn_rad: self.turn_rad + next.turn_rad,
            covariance: by_start * self.covariance * by_start.transpose() + by_next * next.covariance * by_next.transpose(),
            length: self.length + next.length,
            turned_rad: self.turned_rad + next.turned_rad,
            unit_variance: self.unit_variance + next.unit_variance,
        }
    }

    /// Whether nobody knows where it led, as over a cut of the film: it may have gone round any wall.
    pub(crate) fn is_jump(&self) -> bool {
        let variance = self.covariance[(0, 0)].max(self.covariance[(1, 1)]);
        variance > JUMP.powi(2) && variance > self.length.powi(2)
    }

    /// This motion as it would have been without a drift of the heading of so many radians a unit of way.
    pub(crate) fn without_drift(&self, drift_rad: f64) -> Self {
        Self { turn_rad: self.turn_rad - drift_rad * self.length, ..*self }
    }

    /// A point of the end's body frame in the start's.
    pub(crate) fn start_from_end(&self, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = libm::sincos(self.turn_rad);
        (self.forward + c * x - s * y, self.left + s * x + c * y)
    }

    /// A point of the start's body frame in the end's.
    pub(crate) fn end_from_start(&self, x: f64, y: f64) -> (f64, f64) {
        let (s, c) = libm::sincos(self.turn_rad);
        let (dx, dy) = (x - self.forward, y - self.left);
        (c * dx + s * dy, -s * dx + c * dy)
    }

    /// The pose (x, y, heading) moved by this, at `scale` metres a unit.
    pub(crate) fn applied_to(&self, pose: Vector3<f64>, scale: f64) -> Vector3<f64> {
        let (s, c) = libm::sincos(pose.z);
        let (forward, left) = (scale * self.forward, scale * self.left);
        Vector3::new(pose.x + c * forward - s * left, pose.y + s * forward + c * left, wrap_angle(pose.z + self.turn_rad))
    }
}

/// Smallest noise that a motion is taken to have. Odometry that claims to be perfect is not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseFloor {
    /// Standard deviation of a motion's length, as a share of it.
    pub length_relative: f64,
    /// Heading, radians per √m.
    pub turn_per_sqrt_m_rad: f64,
}

impl Default for NoiseFloor {
    /// 1 % of length and 0.3°/√m: what good visual odometry drifts by.
    fn default() -> Self {
        Self { length_relative: 0.01, turn_per_sqrt_m_rad: 0.3f64.to_radians() }
    }
}

/// A motion conditioned for many draws.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MoveSampler {
    mean: [f32; 3],
    /// Lower triangle of the covariance's square root: (0,0), (1,0), (1,1), (2,0), (2,1), (2,2).
    root: [f32; 6],
}

impl MoveSampler {
    pub(crate) fn new(motion: &Motion, floor: &NoiseFloor, metres_per_unit: f64) -> Self {
        let mut covariance = motion.covariance;
        let along = (floor.length_relative * motion.length).powi(2);
        covariance[(0, 0)] += along;
        covariance[(1, 1)] += along;
        covariance[(2, 2)] += floor.turn_per_sqrt_m_rad.powi(2) * motion.length * metres_per_unit;
        let root = root_of(&covariance);
        let mean = [motion.forward as f32, motion.left as f32, motion.turn_rad as f32];
        let root = [root[(0, 0)], root[(1, 0)], root[(1, 1)], root[(2, 0)], root[(2, 1)], root[(2, 2)]].map(|v| v as f32);
        Self { mean, root }
    }

    /// (forward, left, turn) for three standard normal numbers; odometry's unit and radians.
    #[inline(always)]
    pub(crate) fn shape(&self, [a, b, c]: [f32; 3]) -> [f32; 3] {
        let root = &self.root;
        [self.mean[0] + root[0] * a, self.mean[1] + root[1] * a + root[2] * b, self.mean[2] + root[3] * a + root[4] * b + root[5] * c]
    }
}

/// A lower triangle L with L·Lᵀ = covariance; what is no covariance keeps its diagonal only.
pub(crate) fn root_of(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let finite = covariance.map(|v| if v.is_finite() { v } else { 0.0 });
    // A tiny share of the trace makes semidefinite ones (a straight, turn-free step) definite.
    let nudged = finite + Matrix3::identity() * (1e-9 * finite.trace().abs() + 1e-18);
    match nudged.cholesky() {
        Some(root) => root.l(),
        None => Matrix3::from_diagonal(&nudged.diagonal().map(|v| v.max(0.0).sqrt())),
    }
}

/// A normal number, near enough: the sum of four uniform ones, scaled to variance 1 (excess kurtosis −0.3, at most 3.5 σ).
/// One 64-bit draw, no transcendental function: the same bits on every platform.
#[inline]
pub(crate) fn normal(rng: &mut impl Rng) -> f32 {
    let bits = rng.next_u64();
    let sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
    // Mean of the sum: 4 · 65535 / 2. Standard deviation: 65536 · √(4 / 12).
    (sum as f32 - 131_070.0) * (1.732_050_8 / 65_536.0)
}

/// A uniform number in [0, 1).
#[inline]
pub(crate) fn uniform(rng: &mut impl Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use planwalk_types::{Seed, Stamp};

    fn step(forward: f64, left: f64, turn_rad: f64) -> Step {
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.01, 0.02, 0.003));
        Step { from: Stamp(0), to: Stamp(1), forward, left, turn_rad, covariance, unit_change: 0.0 }
    }

    #[test]
    fn composed_steps_are_the_steps_composed() {
        let steps = [step(1.0, 0.1, 0.3), step(0.5, -0.2, -1.0), step(0.2, 0.0, 2.0)];
        let motion = steps.iter().fold(Motion::none(), |m, s| m.then(&Motion::of(s, 1.0)));
        let pose = steps[0].start_from_end() * steps[1].start_from_end() * steps[2].start_from_end();
        assert!((motion.forward - pose.x).abs() < 1e-12 && (motion.left - pose.y).abs() < 1e-12);
        assert!(wrap_angle(motion.turn_rad - pose.heading_rad).abs() < 1e-12);
        let (x, y) = motion.start_from_end(0.7, -0.4);
        let back = motion.end_from_start(x, y);
        assert!((back.0 - 0.7).abs() < 1e-12 && (back.1 + 0.4).abs() < 1e-12);
    }

    #[test]
    fn drawn_motions_have_the_stated_covariance() {
        let motion = Motion::of(&step(1.0, 0.0, 0.2), 1.0).then(&Motion::of(&step(1.0, 0.0, 0.0), 1.0));
        let none = NoiseFloor { length_relative: 0.0, turn_per_sqrt_m_rad: 0.0 };
        let sampler = MoveSampler::new(&motion, &none, 1.0);
        let chance = Chance::new(Seed(3), "test");
        const N: usize = 40_000;
        let mut sum = Matrix3::zeros();
        for i in 0..N as u32 {
            let [a, b, c, _] = chance.normals(i);
            let draw = sampler.shape([a, b, c]);
            let off =
                Vector3::new(f64::from(draw[0]) - motion.forward, f64::from(draw[1]) - motion.left, f64::from(draw[2]) - motion.turn_rad);
            sum += off * off.transpose() / N as f64;
        }
        for i in 0..3 {
            for j in 0..3 {
                // A sample covariance is off by √((c_ii c_jj + c_ij²) / N); four of these.
                let c = &motion.covariance;
                let tolerance = 4.0 * ((c[(i, i)] * c[(j, j)] + c[(i, j)].powi(2)) / N as f64).sqrt() + 1e-9;
                assert!((sum[(i, j)] - c[(i, j)]).abs() < tolerance, "{sum} against {c}");
            }
        }
    }

    #[test]
    fn a_cut_is_a_jump_and_no_gap_is_one() {
        let with = |sigma: f64, forward: f64| {
            Motion::of(
                &Step { covariance: Matrix3::from_diagonal(&Vector3::new(sigma * sigma, sigma * sigma, 9.0)), ..step(forward, 0.0, 0.0) },
                1.0,
            )
        };
        assert!(with(10.0, 0.0).is_jump(), "nobody filmed");
        assert!(with(10.0, 0.0).then(&Motion::of(&step(0.3, 0.0, 0.1), 1.0)).is_jump(), "and what follows it is one with it");
        assert!(!with(1.5, 2.0).is_jump(), "two seconds in the dark");
        assert!(!with(4.0, 40.0).is_jump(), "a tenth of a long way");
    }

    #[test]
    fn a_covariance_that_is_none_yields_finite_noise() {
        let broken = Matrix3::new(f64::NAN, 5.0, 0.0, 5.0, -1.0, 0.0, 0.0, 0.0, f64::INFINITY);
        assert!(root_of(&broken).iter().all(|v| v.is_finite()));
    }
}
