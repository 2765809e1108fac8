//! Did the camera only turn? The rotation as a `Kind` of model, and the one that best explains pairs of rays.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::Rng;

use super::matches::{Match, Matches};
use super::robust::{Effort, Kind, finished, search};
use super::transfer::{least_squares, transfer_agrees, transfer_cost};
use super::{RayPair, epipolar};

/// Rotations, as matrices, from two matches.
pub(crate) struct Turn;

impl Kind for Turn {
    type Model = Matrix3<f64>;

    fn sample_size(&self) -> usize {
        2
    }

    fn solve(&self, sample: &[Match], found: &mut Vec<Matrix3<f64>>) {
        let [first, second, ..] = sample else { return };
        let frame = |p: [f64; 2], q: [f64; 2]| {
            let (p, q) = (Vector3::new(p[0], p[1], 1.0).normalize(), Vector3::new(q[0], q[1], 1.0).normalize());
            let (middle, normal) = ((p + q).try_normalize(1e-9)?, p.cross(&q).try_normalize(1e-6)?);
            Some(Matrix3::from_columns(&[middle, normal, middle.cross(&normal)]))
        };
        if let (Some(a), Some(b)) = (frame(first.a, second.a), frame(first.b, second.b)) {
            found.push(b * a.transpose());
        }
    }

    fn cost(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64, enough: f64) -> f64 {
        transfer_cost(model, matches, limit, enough)
    }

    fn agree(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64) -> Vec<bool> {
        transfer_agrees(model, matches, limit)
    }

    fn improve(&self, model: &Matrix3<f64>, matches: &Matches, limit: f64, steps: usize) -> Option<Matrix3<f64>> {
        let mut turn = *model;
        for _ in 0..steps {
            let rows = |_: &Match, p: &Vector3<f64>| {
                // d(R a) = ω × R a, projected.
                let (u, v) = (p.x / p.z, p.y / p.z);
                [[-u * v, 1.0 + u * u, -v], [-(1.0 + v * v), u * v, u]]
            };
            let step = least_squares::<3>(&turn, matches, limit, rows)?;
            turn = Rotation3::from_scaled_axis(Vector3::new(step[0], step[1], step[2])).into_inner() * turn;
            if step.norm() < 1e-8 {
                break;
            }
        }
        Some(turn)
    }
}

/// Options of [`estimate_rotation`].
#[derive(Debug, Clone, Copy)]
pub struct RotationOptions {
    /// Largest angle between a turned ray and its partner for an inlier, radians. The default, 4 mrad, is 2 px at f = 500 px.
    pub max_angle_rad: f64,
    /// Most samples drawn.
    pub samples: usize,
}

impl Default for RotationOptions {
    fn default() -> Self {
        Self { max_angle_rad: 4e-3, samples: 60 }
    }
}

/// A rotation and how well it explains the pairs.
#[derive(Debug, Clone)]
pub struct RotationFit {
    /// `b_from_a`.
    pub rotation: UnitQuaternion<f64>,
    /// Which pairs it explains.
    pub inliers: Vec<bool>,
    /// Median parallax that it leaves over all pairs, radians.
    pub median_parallax_rad: f64,
}

/// The rotation that explains most pairs; `None` with fewer than two pairs or when all rays coincide.
pub fn estimate_rotation(pairs: &[RayPair], options: &RotationOptions, rng: &mut impl Rng) -> Option<RotationFit> {
    let matches = Matches::of(pairs);
    let limit = options.max_angle_rad;
    // Tukey's weights fall before they end: what is to count in full lies well inside.
    let effort = Effort { limit: 2.0 * limit, confidence: 0.999, least: 10, most: options.samples };
    let best = search(&Turn, &matches, &effort, rng).into_iter().next()?;
    let turn = finished(&Turn, best, &matches, effort.limit);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn));
    let angles: Vec<f64> = pairs.iter().map(|p| epipolar::parallax(&rotation, p)).collect();
    let inliers = angles.iter().map(|angle| *angle < limit).collect();
    let median_parallax_rad = median(angles);
    Some(RotationFit { rotation, inliers, median_parallax_rad })
}

/// The median, or 0 of nothing. Not-a-numbers sort last.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene;
    use planwalk_types::Seed;

    #[test]
    fn a_pure_turn_is_found_though_a_third_of_the_pairs_lie() {
        for seed in 0..10 {
            let (pairs, truth) = scene::pairs(seed, 90, 0.0, 1e-3, 0.33);
            let fit = estimate_rotation(&pairs, &RotationOptions::default(), &mut Seed(seed).derive("test", 0)).unwrap();
            let right = fit.inliers.iter().skip(30).filter(|i| **i).count();
            let off = fit.rotation.angle_to(&truth.rotation);
            assert!(right >= 57, "seed {seed}: {right} of 60, {off}");
            // 1 mrad of noise in each ray over 60 pairs: 0.2 mrad across the view, and 0.5 mrad about it, where the points' lever is a
            // third. Three standard deviations.
            assert!(off < 1.6e-3, "seed {seed}: {off}");
            assert!(fit.median_parallax_rad < 3e-3, "seed {seed}: {}", fit.median_parallax_rad);
        }
    }

    #[test]
    fn one_pair_or_one_direction_gives_nothing() {
        let (pairs, _) = scene::pairs(1, 3, 0.0, 0.0, 0.0);
        let rng = &mut Seed(1).derive("test", 0);
        assert!(estimate_rotation(&pairs[..1], &RotationOptions::default(), rng).is_none());
        assert!(estimate_rotation(&[pairs[0]; 5], &RotationOptions::default(), rng).is_none());
    }
}
