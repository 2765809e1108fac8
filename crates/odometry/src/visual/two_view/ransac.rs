//! Which motion do most pairs agree on? RANSAC over a minimal solver, an MSAC score, refinement on the inliers.
//!
//! Fischler & Bolles 1981; truncated quadratic score of Torr & Zisserman 2000; local optimisation of Chum et al. 2003.

use nalgebra::{Matrix3, SMatrix, SVector, UnitQuaternion, Vector3};
use rand::Rng;

use super::rotation::median;
use super::{RayPair, RelativePose, Solver, eight_point, epipolar, five_point};

/// Options of [`estimate_essential`].
#[derive(Debug, Clone, Copy)]
pub struct EssentialOptions {
    /// Which minimal solver draws hypotheses.
    pub solver: Solver,
    /// Largest angle from a ray to its epipolar plane for an inlier, radians. The default, 2 mrad, is 1 px at f = 500 px.
    pub max_angle_rad: f64,
    /// Wanted probability that at least one drawn sample holds inliers only.
    pub confidence: f64,
    /// Most samples drawn.
    pub max_samples: usize,
    /// Median parallax of the inliers under which the direction is not trusted, radians.
    pub min_parallax_rad: f64,
}

impl Default for EssentialOptions {
    fn default() -> Self {
        Self { solver: Solver::default(), max_angle_rad: 2e-3, confidence: 0.999, max_samples: 500, min_parallax_rad: 8e-3 }
    }
}

/// A relative pose and the pairs that agree with it.
#[derive(Debug, Clone)]
pub struct EssentialFit {
    /// `b_from_a`, unit direction.
    pub pose: RelativePose,
    /// Which pairs lie within the angle of their epipolar planes and before both cameras.
    pub inliers: Vec<bool>,
    /// Median parallax of the inliers, radians.
    pub median_parallax_rad: f64,
}

/// Why there is no relative pose.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TwoViewError {
    /// The camera only turned, as far as can be told.
    #[error("parallax {median_rad:.4} rad is under {min_rad:.4} rad: the camera only turned")]
    LowParallax {
        /// Median parallax of the inliers.
        median_rad: f64,
        /// What is needed.
        min_rad: f64,
    },
    /// Not enough to solve from.
    #[error("{got} ray pairs, but the solver needs at least {need}")]
    TooFewPairs {
        /// Pairs given.
        got: usize,
        /// Pairs needed.
        need: usize,
    },
    /// No motion that a third of the pairs agree on.
    #[error("only {inliers} of {pairs} ray pairs agree on any motion")]
    NoAgreement {
        /// Most pairs that agreed.
        inliers: usize,
        /// Pairs given.
        pairs: usize,
    },
}

/// Relative rotation and direction between two views, up to scale, by the chosen solver inside RANSAC.
///
/// Rays are unit, camera frame (x right, y down, z forward). The same `rng` state gives the same answer.
///
/// # Errors
/// [`TwoViewError::LowParallax`] when the camera only turned: keep the tracks and try a later frame.
pub fn estimate_essential(pairs: &[RayPair], options: &EssentialOptions, rng: &mut impl Rng) -> Result<EssentialFit, TwoViewError> {
    let size = match options.solver {
        Solver::FivePoint => 5,
        Solver::EightPoint => 8,
    };
    // One pair more than the sample, so that something can disagree.
    if pairs.len() <= size {
        return Err(TwoViewError::TooFewPairs { got: pairs.len(), need: size + 1 });
    }
    let Some(best) = sample(pairs, size, options, rng) else {
        return Err(TwoViewError::NoAgreement { inliers: 0, pairs: pairs.len() });
    };
    let pose = refine(&choose(&best, pairs, options)?, pairs, options);
    let essential = epipolar::essential_of(&pose);
    let inliers: Vec<bool> = pairs.iter().map(|p| agrees(&essential, &pose, p, options)).collect();
    let count = inliers.iter().filter(|i| **i).count();
    if 3 * count < pairs.len() || count <= size {
        return Err(TwoViewError::NoAgreement { inliers: count, pairs: pairs.len() });
    }
    let median_parallax_rad = parallax_of(&pose, pairs, |i| inliers[i]);
    if median_parallax_rad < options.min_parallax_rad {
        return Err(TwoViewError::LowParallax { median_rad: median_parallax_rad, min_rad: options.min_parallax_rad });
    }
    Ok(EssentialFit { pose, inliers, median_parallax_rad })
}

fn cost(essential: &Matrix3<f64>, pairs: &[RayPair], limit: f64) -> f64 {
    pairs.iter().map(|p| (epipolar::epipolar_angle(essential, p) / limit).powi(2).min(1.0)).sum()
}

/// The essential matrix of least truncated cost among the drawn samples.
fn sample(pairs: &[RayPair], size: usize, options: &EssentialOptions, rng: &mut impl Rng) -> Option<Matrix3<f64>> {
    let mut best: Option<(f64, Matrix3<f64>)> = None;
    let mut needed = options.max_samples as f64;
    let mut drawn = 0;
    while (drawn as f64) < needed.min(options.max_samples as f64) {
        drawn += 1;
        let chosen = rand::seq::index::sample(rng, pairs.len(), size);
        let minimal: Vec<RayPair> = chosen.iter().map(|i| pairs[i]).collect();
        let answers = match options.solver {
            Solver::FivePoint => {
                let mut found = Vec::new();
                five_point::solve_into(&super::matches::Matches::of(&minimal).list, &mut found);
                found
            }
            Solver::EightPoint => eight_point::solve(&minimal).into_iter().collect(),
        };
        for essential in answers {
            let cost = cost(&essential, pairs, options.max_angle_rad);
            if best.as_ref().is_some_and(|b| cost >= b.0) {
                continue;
            }
            // The truncated cost is at least the outliers' number; so this underestimates the inliers, and draws enough.
            let share = (1.0 - cost / pairs.len() as f64).clamp(0.0, 1.0 - 1e-9);
            needed = ((1.0 - options.confidence).ln() / (1.0 - share.powi(size as i32)).ln()).max(20.0);
            best = Some((cost, essential));
        }
    }
    best.map(|b| b.1)
}

/// The one of the four poses with most agreeing pairs before both cameras, weighed by their parallax.
///
/// Pairs without parallax have no side to be on and take no part; when none has any, the camera only turned.
fn choose(essential: &Matrix3<f64>, pairs: &[RayPair], options: &EssentialOptions) -> Result<RelativePose, TwoViewError> {
    let none = TwoViewError::NoAgreement { inliers: 0, pairs: pairs.len() };
    let poses = epipolar::decompose(essential).ok_or(none)?;
    let close: Vec<&RayPair> = pairs.iter().filter(|p| epipolar::epipolar_angle(essential, p) < options.max_angle_rad).collect();
    let votes = poses.map(|pose| {
        let vote = |p: &&RayPair| {
            let ahead = epipolar::depths(&pose, p).is_some_and(|(a, b)| a > 0.0 && b > 0.0);
            let weight = epipolar::parallax(&pose.rotation, p).min(0.1);
            if ahead && weight > 1.5 * options.max_angle_rad { weight } else { 0.0 }
        };
        close.iter().map(vote).sum::<f64>()
    });
    let best = (0..4).max_by(|a, b| votes[*a].total_cmp(&votes[*b])).unwrap_or(0);
    if votes[best] == 0.0 {
        let median_rad = parallax_of(&poses[best], pairs, |_| true);
        return Err(TwoViewError::LowParallax { median_rad, min_rad: options.min_parallax_rad });
    }
    Ok(poses[best])
}

fn agrees(essential: &Matrix3<f64>, pose: &RelativePose, pair: &RayPair, options: &EssentialOptions) -> bool {
    if epipolar::epipolar_angle(essential, pair) >= options.max_angle_rad {
        return false;
    }
    // A far point's depth is noise, its sign too: only what has parallax can be behind.
    let parallax = epipolar::parallax(&pose.rotation, pair);
    parallax < 1.5 * options.max_angle_rad || epipolar::depths(pose, pair).is_some_and(|(a, b)| a > 0.0 && b > 0.0)
}

fn parallax_of(pose: &RelativePose, pairs: &[RayPair], keep: impl Fn(usize) -> bool) -> f64 {
    median(pairs.iter().enumerate().filter(|(i, _)| keep(*i)).map(|(_, p)| epipolar::parallax(&pose.rotation, p)).collect())
}

/// Gauss–Newton on rotation and direction (5 degrees of freedom) over the angles to the epipolar planes, Geman–McClure weights.
pub fn refine(start: &RelativePose, pairs: &[RayPair], options: &EssentialOptions) -> RelativePose {
    let mut pose = *start;
    let mut best = (cost(&epipolar::essential_of(&pose), pairs, options.max_angle_rad), pose);
    for _ in 0..10 {
        let (u, v) = tangent_basis(&pose.direction);
        let essential = epipolar::essential_of(&pose);
        let (mut normal, mut gradient) = (SMatrix::<f64, 5, 5>::zeros(), SVector::<f64, 5>::zeros());
        for pair in pairs {
            let turned = pose.rotation * pair.a;
            let norm = (essential * pair.a).norm().min(essential.tr_mul(&pair.b).norm());
            let error = pair.b.dot(&pose.direction.cross(&turned)) / norm;
            if norm < 1e-6 || error.abs() > 3.0 * options.max_angle_rad {
                continue;
            }
            let weight = (1.0 + (error / options.max_angle_rad).powi(2)).powi(-2);
            let by_turn = turned.cross(&pair.b.cross(&pose.direction));
            let by_move = turned.cross(&pair.b);
            let row = SVector::<f64, 5>::new(by_turn.x, by_turn.y, by_turn.z, by_move.dot(&u), by_move.dot(&v)) / norm;
            normal += weight * row * row.transpose();
            gradient += weight * error * row;
        }
        let damping = 1e-9 * normal.trace().max(1e-30);
        let Some(factor) = (normal + SMatrix::identity() * damping).cholesky() else { break };
        let step = -factor.solve(&gradient);
        pose.rotation = UnitQuaternion::from_scaled_axis(Vector3::new(step[0], step[1], step[2])) * pose.rotation;
        pose.direction = (pose.direction + u * step[3] + v * step[4]).normalize();
        let now = cost(&epipolar::essential_of(&pose), pairs, options.max_angle_rad);
        if now < best.0 {
            best = (now, pose);
        }
        if step.norm() < 1e-9 {
            break;
        }
    }
    best.1
}

/// Two unit vectors that make a right-handed frame with `axis`.
pub(crate) fn tangent_basis(axis: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let other = if axis.x.abs() < 0.7 { Vector3::x() } else { Vector3::y() };
    let u = axis.cross(&other).normalize();
    (u, axis.cross(&u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene;
    use planwalk_types::Seed;

    fn fit(seed: u64, solver: Solver, baseline: f64, noise_rad: f64, wild: f64) -> (Result<EssentialFit, TwoViewError>, RelativePose) {
        let (pairs, truth) = scene::pairs(seed, 150, baseline, noise_rad, wild);
        let options = EssentialOptions { solver, max_samples: 2000, ..Default::default() };
        (estimate_essential(&pairs, &options, &mut Seed(seed).derive("test", 0)), truth)
    }

    #[test]
    fn both_solvers_find_the_motion_though_a_third_of_the_pairs_lie() {
        for solver in [Solver::FivePoint, Solver::EightPoint] {
            for seed in 0..8 {
                let (found, truth) = fit(seed, solver, 0.8, 5e-4, 0.3);
                let pose = found.unwrap_or_else(|e| panic!("{solver:?}, seed {seed}: {e}")).pose;
                // Half a milliradian of noise over 100 pairs with some 0.15 rad of parallax: tenths of a degree.
                assert!(pose.rotation.angle_to(&truth.rotation).to_degrees() < 0.3, "{solver:?}, seed {seed}");
                assert!(pose.direction.angle(&truth.direction).to_degrees() < 2.0, "{solver:?}, seed {seed}");
            }
        }
    }

    #[test]
    fn a_camera_that_only_turned_is_told_so() {
        for seed in 0..8 {
            let (found, _) = fit(seed, Solver::FivePoint, 0.0, 5e-4, 0.0);
            assert!(matches!(found, Err(TwoViewError::LowParallax { .. })), "seed {seed}: {found:?}");
        }
    }

    #[test]
    fn too_few_or_senseless_pairs_are_errors() {
        let (pairs, _) = scene::pairs(1, 5, 0.8, 0.0, 0.0);
        let rng = &mut Seed(1).derive("test", 0);
        assert_eq!(
            estimate_essential(&pairs, &EssentialOptions::default(), rng).unwrap_err(),
            TwoViewError::TooFewPairs { got: 5, need: 6 }
        );
        let (found, _) = fit(2, Solver::FivePoint, 0.8, 0.0, 1.0);
        assert!(found.is_err());
    }

    #[test]
    fn refinement_only_ever_improves() {
        let (pairs, truth) = scene::pairs(3, 100, 0.8, 5e-4, 0.2);
        let options = EssentialOptions::default();
        let off = RelativePose {
            rotation: UnitQuaternion::from_scaled_axis(Vector3::new(0.002, -0.001, 0.002)) * truth.rotation,
            direction: (truth.direction + Vector3::new(0.02, 0.01, -0.02)).normalize(),
        };
        let refined = refine(&off, &pairs, &options);
        let score = |p: &RelativePose| cost(&epipolar::essential_of(p), &pairs, options.max_angle_rad);
        assert!(score(&refined) < score(&off));
        assert!(refined.rotation.angle_to(&truth.rotation) < off.rotation.angle_to(&truth.rotation));
    }
}
