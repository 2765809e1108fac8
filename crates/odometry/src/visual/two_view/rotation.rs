//! Did the camera only turn? The rotation that best explains pairs of rays, robustly.
//!
//! Two pairs give a rotation (Kabsch 1976); RANSAC picks the sample, all inliers give the answer.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};

use super::{RayPair, epipolar};

/// Options of [`estimate_rotation`].
#[derive(Debug, Clone, Copy)]
pub struct RotationOptions {
    /// Largest angle between a turned ray and its partner for an inlier, radians. The default, 4 mrad, is 2 px at f = 500 px.
    pub max_angle_rad: f64,
    /// Samples drawn.
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
    if pairs.len() < 2 {
        return None;
    }
    let limit = options.max_angle_rad;
    let cost = |r: &UnitQuaternion<f64>| pairs.iter().map(|p| (epipolar::parallax(r, p) / limit).powi(2).min(1.0)).sum::<f64>();
    let mut best: Option<(f64, UnitQuaternion<f64>)> = None;
    for _ in 0..options.samples {
        let (i, j) = (rng.random_range(0..pairs.len()), rng.random_range(0..pairs.len()));
        let Some(rotation) = align([pairs[i], pairs[j]].iter()) else { continue };
        let cost = cost(&rotation);
        if best.as_ref().is_none_or(|b| cost < b.0) {
            best = Some((cost, rotation));
        }
    }
    let (mut best_cost, mut rotation) = best?;
    for _ in 0..3 {
        let Some(refined) = align(pairs.iter().filter(|p| epipolar::parallax(&rotation, p) < limit)) else { break };
        let refined_cost = cost(&refined);
        if refined_cost >= best_cost {
            break;
        }
        (best_cost, rotation) = (refined_cost, refined);
    }
    let angles: Vec<f64> = pairs.iter().map(|p| epipolar::parallax(&rotation, p)).collect();
    let inliers = angles.iter().map(|a| *a < limit).collect();
    Some(RotationFit { rotation, inliers, median_parallax_rad: median(angles) })
}

/// The rotation R that minimises Σ |R a − b|² (Kabsch 1976); `None` when the rays do not determine it.
fn align<'a>(pairs: impl Iterator<Item = &'a RayPair>) -> Option<UnitQuaternion<f64>> {
    let mut sum = Matrix3::zeros();
    for pair in pairs {
        sum += pair.b * pair.a.transpose();
    }
    let svd = sum.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    let mut sizes: [f64; 3] = svd.singular_values.into();
    sizes.sort_by(f64::total_cmp);
    // Two directions are needed: with one, any turn about it fits.
    if !(sizes[1] > 1e-6 * sizes[2]) {
        return None;
    }
    let smallest = svd.singular_values.imin();
    let mut flip = Vector3::repeat(1.0);
    flip[smallest] = (u * vt).determinant().signum();
    let rotation = u * Matrix3::from_diagonal(&flip) * vt;
    Some(UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(rotation)))
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
            // 1 mrad of noise over 60 pairs within ±30°: about 0.2 mrad a component.
            assert!(fit.rotation.angle_to(&truth.rotation) < 1e-3, "seed {seed}");
            assert!(fit.inliers.iter().skip(30).filter(|i| **i).count() >= 57, "seed {seed}");
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
