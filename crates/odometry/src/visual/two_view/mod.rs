//! How did the camera move between two pictures? Relative rotation and direction from rays alone.
//!
//! pairs of rays ─▶ [`matches`]: weights, likeliest first ─▶ `robust` search: [`five_point`], [`eight_point`] or [`upright`], homography,
//! rotation ─▶ `relative`: which of them, polished
//!
//! Convention: `b_from_a`: a point X in camera A is R·X + t in camera B, |t| = 1; E = \[t\]× R; b·E·a = 0.
//! Pitfall: at low parallax any direction fits and a cheirality vote chooses at random: then it is [`Motion::TurnOnly`].

pub mod eight_point;
pub mod epipolar;
pub(crate) mod essential;
pub mod five_point;
mod homography;
mod judge;
pub(crate) mod matches;
mod plausible;
mod polynomial;
mod relative;
mod robust;
pub mod rotation;
mod transfer;
pub mod upright;

pub use relative::{Motion, RelativePoseFit, RelativePoseOptions, estimate_relative_pose};
pub use rotation::{RotationFit, RotationOptions, estimate_rotation};

use nalgebra::{UnitQuaternion, Vector3};

/// Which solver draws hypotheses from minimal samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// Nistér 2004: calibrated, five pairs, up to ten answers a sample; planes are no problem.
    #[default]
    FivePoint,
    /// Hartley 1997: eight pairs, linear, normalised; one answer a sample; a plane alone leaves it undetermined.
    EightPoint,
    /// Fraundorfer, Tanskanen & Pollefeys 2010: three pairs and up in both pictures, up to four answers a sample. Where
    /// [`RelativePoseOptions::ups`] does not say which way is up, it is [`Solver::FivePoint`].
    UprightThreePoint,
}

/// One point seen from both cameras: unit rays, camera frame (x right, y down, z forward).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayPair {
    /// From camera A.
    pub a: Vector3<f64>,
    /// From camera B.
    pub b: Vector3<f64>,
}

/// Relative pose up to scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativePose {
    /// Rotation of `b_from_a`.
    pub rotation: UnitQuaternion<f64>,
    /// Translation of `b_from_a`, unit length.
    pub direction: Vector3<f64>,
}

/// Simulated pairs for the tests of this module.
#[cfg(test)]
pub(crate) mod scene {
    use super::*;
    use planwalk_types::Seed;
    use rand::{Rng, RngExt};

    /// A number in [low, high).
    pub fn uniform(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
        low + (high - low) * rng.random::<f64>()
    }

    /// `count` points 2–8 m before a camera that moves by `baseline` m with a 10° turn; a share of wild pairs; noise in radians.
    pub fn pairs(seed: u64, count: usize, baseline: f64, noise_rad: f64, wild_share: f64) -> (Vec<RayPair>, RelativePose) {
        let mut rng = Seed(seed).derive("scene", 0);
        let axis = Vector3::new(uniform(&mut rng, -1.0, 1.0), 2.0, uniform(&mut rng, -1.0, 1.0)).normalize();
        let rotation = UnitQuaternion::from_scaled_axis(axis * 0.17);
        let direction = Vector3::new(uniform(&mut rng, -1.0, 1.0), uniform(&mut rng, -0.3, 0.3), uniform(&mut rng, -1.0, 1.0)).normalize();
        let bend = |ray: Vector3<f64>, rng: &mut planwalk_types::StreamRng| {
            let push = Vector3::from_fn(|_, _| uniform(rng, -1.7, 1.7) * noise_rad);
            (ray.normalize() + push).normalize()
        };
        let pairs = (0..count).map(|i| {
            let depth = uniform(&mut rng, 2.0, 8.0);
            let point = Vector3::new(uniform(&mut rng, -0.6, 0.6) * depth, uniform(&mut rng, -0.45, 0.45) * depth, depth);
            let seen = rotation * point + direction * baseline;
            let wild = (i as f64) < wild_share * count as f64;
            let other = Vector3::new(uniform(&mut rng, -0.6, 0.6), uniform(&mut rng, -0.45, 0.45), 1.0);
            RayPair { a: bend(point, &mut rng), b: bend(if wild { other } else { seen }, &mut rng) }
        });
        (pairs.collect(), RelativePose { rotation, direction })
    }
}
