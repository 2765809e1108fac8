//! How did the camera move between two pictures, and is it a general motion, one before a wall, or a mere turn?
//!
//! pairs ─▶ [`Matches`] ─▶ essential matrix ─┐
//!                      ─▶ homography ───────┼─▶ which explains them best (GRIC) ─▶ pose, inliers, noise
//!                      ─▶ rotation ─────────┘
//!
//! On the way: wrong matches on their epipolar lines are told by their depth ([`Plausible`]), the noise is measured, and the pose is
//! polished by least squares with weights that end at four times that noise.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::Rng;

use super::epipolar;
use super::essential::{Epipolar, LEVELS, Twisted, is_ahead, residual};
use super::judge::{AGREES, Flat, judge};
use super::matches::{Match, Matches};
use super::plausible::Plausible;
use super::robust::{Candidate, Effort, improved, search};
use super::rotation::median;
use super::transfer::transfer_squared;
use super::{RayPair, RelativePose, Solver};

/// Where Tukey's weights end, in standard deviations: 4.685 is 95 % efficient without outliers; less lets fewer in.
const TUKEY: f64 = 4.0;

/// Options of [`estimate_relative_pose`].
#[derive(Debug, Clone, Copy)]
pub struct RelativePoseOptions {
    /// Which minimal solver draws hypotheses.
    pub solver: Solver,
    /// A match farther than this from what fits exactly disagrees, radians.
    pub limit_rad: f64,
    /// Wanted probability that at least one drawn sample holds inliers only.
    pub confidence: f64,
    /// Most samples drawn.
    pub max_samples: usize,
    /// Which way is up in picture A and in picture B, unit vectors in the camera's frame; only [`Solver::UprightThreePoint`] asks.
    pub ups: Option<[Vector3<f64>; 2]>,
}

impl RelativePoseOptions {
    /// For points that are off by up to a pixel or so, in pictures of this focal length in pixels.
    pub fn for_focal(focal_px: f64) -> Self {
        Self { solver: Solver::default(), limit_rad: 2.5 / focal_px, confidence: 0.999, max_samples: 400, ups: None }
    }
}

/// What sort of motion explains the matches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Any motion before any scene.
    General,
    /// What is seen is one plane.
    BeforePlane,
    /// No parallax is to be seen: the direction is a guess.
    TurnOnly,
}

/// A motion between two pictures.
#[derive(Debug, Clone)]
pub struct RelativePoseFit {
    /// `b_from_a`, unit direction.
    pub pose: RelativePose,
    /// What sort of motion it is.
    pub motion: Motion,
    /// Which pairs agree with it, and are before both cameras.
    pub inliers: Vec<bool>,
    /// Noise of a coordinate at distance 1, as the inliers show it.
    pub sigma: f64,
    /// Median parallax of the inliers, radians.
    pub parallax_rad: f64,
}

/// Relative pose of two calibrated pictures, up to scale; `None` when no sample of matches gives any.
///
/// Rays are unit, camera frame (x right, y down, z forward). The same `rng` state gives the same answer.
pub fn estimate_relative_pose(pairs: &[RayPair], options: &RelativePoseOptions, rng: &mut impl Rng) -> Option<RelativePoseFit> {
    let matches = Matches::of(pairs);
    let kind = Epipolar::of(options.solver, options.ups.as_ref());
    let effort = Effort { limit: options.limit_rad, confidence: options.confidence, least: 200, most: options.max_samples };
    let found = search(&kind, &matches, &effort, rng);
    let best = choose(&kind, found, pairs, &matches, options)?;
    let plausible = Plausible::of(&best, pairs, &matches, options.limit_rad);
    let sigma = noise(&best.essential(), &matches, &plausible, options.limit_rad);
    let pose = polished(best, &matches, &plausible, TUKEY * sigma);
    let (pose, motion) = judge(pose, &Flat::of(&matches, sigma, rng), sigma, pairs, &matches, &plausible);
    Some(fit(&pose, motion, sigma, pairs, &matches))
}

fn fit(pose: &Twisted, motion: Motion, sigma: f64, pairs: &[RayPair], matches: &Matches) -> RelativePoseFit {
    let (mut inliers, essential) = (vec![false; pairs.len()], pose.essential());
    for m in &matches.list {
        inliers[m.pair] = match motion {
            Motion::TurnOnly => transfer_squared(&pose.rotation, m) < 2.0 * (AGREES * sigma).powi(2),
            _ => residual(&essential, m).abs() < AGREES * sigma && is_ahead(&pose.rotation, &pose.direction, &pairs[m.pair]),
        };
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
    let parallax = |(p, _): (&RayPair, &bool)| epipolar::parallax(&rotation, p);
    let parallax_rad = median(pairs.iter().zip(&inliers).filter(|(_, inlier)| **inlier).map(parallax).collect());
    RelativePoseFit { pose: RelativePose { rotation, direction: pose.direction }, motion, inliers, sigma, parallax_rad }
}

/// The candidate, and the one of its four poses, with most weight before both cameras.
fn choose(
    kind: &Epipolar,
    found: Vec<Candidate<Matrix3<f64>>>,
    pairs: &[RayPair],
    matches: &Matches,
    options: &RelativePoseOptions,
) -> Option<Twisted> {
    let limit = options.limit_rad;
    let better = |c: Candidate<Matrix3<f64>>| improved(kind, &c, matches, limit).unwrap_or(c);
    let poses = found.into_iter().map(better).filter_map(|c| Twisted::of(&c.model)).flat_map(|pose| four(&pose));
    let scored = poses.map(|pose| (score(&pose, pairs, matches, limit), pose));
    scored.max_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

fn four(pose: &Twisted) -> [Twisted; 4] {
    let (twin, direction) = (pose.twin(), pose.direction);
    [(pose.rotation, direction), (pose.rotation, -direction), (twin, direction), (twin, -direction)]
        .map(|(rotation, direction)| Twisted { rotation, direction })
}

/// Weight that agrees and is before both cameras.
fn score(pose: &Twisted, pairs: &[RayPair], matches: &Matches, limit: f64) -> f64 {
    let essential = pose.essential();
    let gain = |m: &Match| {
        let share = (residual(&essential, m) / limit).powi(2);
        if share < 1.0 && is_ahead(&pose.rotation, &pose.direction, &pairs[m.pair]) {
            let gains: f64 = LEVELS.iter().map(|level| (1.0 - f64::from(*level) * share).max(0.0)).sum();
            m.weight * gains
        } else {
            0.0
        }
    };
    matches.list.iter().map(gain).sum()
}

/// Standard deviation of what the residuals of those that agree would be alone: cut at 2.5 of it, again and again, and what the cut
/// takes away from a normal distribution put back.
fn noise(essential: &Matrix3<f64>, matches: &Matches, plausible: &Plausible, limit: f64) -> f64 {
    const CUT: f64 = 2.5;
    const LEFT: f64 = 0.911_2;
    let sizes: Vec<f64> = plausible.list(matches).map(|m| residual(essential, m).abs()).filter(|r| *r < limit).collect();
    let mut sigma = 1.4826 * median(sizes.clone());
    for _ in 0..4 {
        let (sum, count) = sizes.iter().filter(|r| **r < CUT * sigma).fold((0.0, 0.0), |(sum, count), r| (sum + r * r, count + 1.0));
        sigma = (sum / f64::max(count, 1.0) / LEFT).sqrt();
    }
    sigma.clamp(0.05 * limit, 0.5 * limit)
}

fn polished(mut pose: Twisted, matches: &Matches, plausible: &Plausible, limit: f64) -> Twisted {
    for _ in 0..8 {
        let before = pose;
        match pose.step(plausible.list(matches), limit) {
            Some(step) if step > 1e-7 => {}
            Some(_) => break,
            None => return before,
        }
    }
    pose
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::scene;
    use planwalk_types::Seed;

    fn estimate(pairs: &[RayPair], solver: Solver, seed: u64) -> Option<RelativePoseFit> {
        let options = RelativePoseOptions { solver, ..RelativePoseOptions::for_focal(500.0) };
        estimate_relative_pose(pairs, &options, &mut Seed(seed).derive("test", 0))
    }

    #[test]
    fn both_solvers_find_the_motion_though_half_of_the_pairs_lie() {
        for solver in [Solver::FivePoint, Solver::EightPoint] {
            for seed in 0..8 {
                let (pairs, truth) = scene::pairs(seed, 150, 0.8, 5e-4, 0.5);
                let fit = estimate(&pairs, solver, seed).expect("75 pairs are right");
                // Half a milliradian of noise over 75 pairs with some 0.15 rad of parallax: tenths of a degree.
                assert!(fit.pose.rotation.angle_to(&truth.rotation).to_degrees() < 0.3, "{solver:?}, seed {seed}");
                assert!(fit.pose.direction.angle(&truth.direction).to_degrees() < 2.0, "{solver:?}, seed {seed}");
                let right = fit.inliers.iter().skip(75).filter(|inlier| **inlier).count();
                // Three standard deviations hold 99.7 %; uniform noise has no tails.
                assert!(right >= 73, "{solver:?}, seed {seed}: {right} of 75");
                assert!((2.5e-4..1e-3).contains(&fit.sigma), "{solver:?}, seed {seed}: {}", fit.sigma);
            }
        }
    }

    /// Up in both frames, each off by a tilt of so many degrees.
    fn ups(seed: u64, truth: &RelativePose, tilt_deg: f64) -> [Vector3<f64>; 2] {
        let way = 1.3 * seed as f64;
        let tilt = |way: f64| UnitQuaternion::from_scaled_axis(Vector3::new(way.cos(), 0.0, way.sin()) * tilt_deg.to_radians());
        [tilt(way) * -Vector3::y(), tilt(2.0 * way) * (truth.rotation * -Vector3::y())]
    }

    #[test]
    fn with_up_known_few_samples_do_though_most_pairs_lie() {
        for (tilt_deg, samples) in [(0.0, 250), (0.5, 400)] {
            let mut off: Vec<(f64, f64)> = Vec::new();
            for seed in 0..20 {
                let (pairs, truth) = scene::pairs(seed, 200, 0.8, 5e-4, 0.7);
                let ups = Some(ups(seed, &truth, tilt_deg));
                let solver = Solver::UprightThreePoint;
                let options = RelativePoseOptions { solver, ups, max_samples: samples, ..RelativePoseOptions::for_focal(500.0) };
                let fit = estimate_relative_pose(&pairs, &options, &mut Seed(seed).derive("test", 0)).unwrap();
                let turn = fit.pose.rotation.angle_to(&truth.rotation).to_degrees();
                off.push((turn, fit.pose.direction.angle(&truth.direction).to_degrees()));
            }
            // As with five points and half of the pairs wrong: what all right pairs say is polished in the end, up or no up. One in
            // twenty may miss: of samples of three that is what 99.9 % and a tilt of a pixel or four leave.
            let good = off.iter().filter(|(turn, way)| *turn < 0.4 && *way < 3.0).count();
            assert!(good >= 19, "{good} of 20 at {tilt_deg}°: {off:.2?}");
        }
    }

    #[test]
    fn where_up_is_not_known_three_points_are_five() {
        let (pairs, _) = scene::pairs(7, 120, 0.8, 5e-4, 0.3);
        let poses = [Solver::UprightThreePoint, Solver::FivePoint].map(|solver| estimate(&pairs, solver, 7).unwrap().pose);
        assert_eq!(poses[0], poses[1]);
    }

    #[test]
    fn exact_pairs_give_the_exact_motion() {
        for seed in 0..8 {
            let (pairs, truth) = scene::pairs(seed, 60, 0.8, 0.0, 0.0);
            let fit = estimate(&pairs, Solver::FivePoint, seed).unwrap();
            assert!(fit.pose.rotation.angle_to(&truth.rotation) < 1e-6 && fit.pose.direction.angle(&truth.direction) < 1e-5, "seed {seed}");
            assert!(fit.inliers.iter().all(|inlier| *inlier), "seed {seed}");
            let options = RelativePoseOptions {
                solver: Solver::UprightThreePoint,
                ups: Some(ups(seed, &truth, 0.0)),
                ..RelativePoseOptions::for_focal(500.0)
            };
            let upright = estimate_relative_pose(&pairs, &options, &mut Seed(seed).derive("test", 0)).unwrap();
            assert!(upright.pose.rotation.angle_to(&truth.rotation) < 1e-6 && upright.pose.direction.angle(&truth.direction) < 1e-5);
        }
    }

    #[test]
    fn too_few_or_senseless_pairs_give_nothing_or_little() {
        let (pairs, _) = scene::pairs(1, 4, 0.8, 0.0, 0.0);
        assert!(estimate(&pairs, Solver::FivePoint, 1).is_none() && estimate(&[], Solver::EightPoint, 1).is_none());
        let (mut wild, _) = scene::pairs(2, 150, 0.8, 0.0, 1.0);
        let agree = |fit: RelativePoseFit| fit.inliers.iter().filter(|inlier| **inlier).count();
        assert!(estimate(&wild, Solver::FivePoint, 2).map_or(0, agree) < 50);
        wild.iter_mut().for_each(|p| p.b.x = f64::NAN);
        assert!(estimate(&wild, Solver::FivePoint, 3).is_none());
        let behind: Vec<RayPair> = wild.iter().map(|p| RayPair { a: -p.a, b: -p.a }).collect();
        assert!(estimate(&behind, Solver::FivePoint, 4).is_none());
    }

    #[test]
    fn the_same_chance_gives_the_same_answer() {
        let (pairs, _) = scene::pairs(5, 150, 0.3, 1e-3, 0.5);
        let poses = [0, 0].map(|_| estimate(&pairs, Solver::FivePoint, 5).unwrap().pose);
        assert_eq!(poses[0], poses[1]);
    }
}
