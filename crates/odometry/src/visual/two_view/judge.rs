//! Is it a general motion, one before a single plane, or a mere turn? Torr's criterion, and what follows from each answer.
//!
//! Matches on one plane leave the essential matrix two-fold and ill determined, and without parallax it is not determined at all (Torr,
//! Fitzgibbon & Zisserman 1999). The geometric robust information criterion (Torr 1998) tells: what a model leaves unexplained, what the
//! place of each match costs under it, and what its parameters cost. Here a match that no model explains costs the same under each;
//! with Torr's own bounds it costs the plane more, and 50 % of wrong matches would hide any plane.

use nalgebra::{Matrix3, Vector3};
use rand::Rng;

use super::essential::{Twisted, is_ahead, residual};
use super::homography::{Plane, PlaneMotion, decompose};
use super::matches::{Match, Matches};
use super::plausible::Plausible;
use super::robust::{Effort, finished, search};
use super::rotation::{Turn, median};
use super::transfer::transfer_squared;
use super::{Motion, RayPair};

/// Matches agree up to so many standard deviations.
pub(super) const AGREES: f64 = 3.0;

/// The best models without depth: a plane's, and a turn's.
pub(super) struct Flat {
    plane: Option<Matrix3<f64>>,
    turn: Option<Matrix3<f64>>,
}

impl Flat {
    /// Of matches whose coordinates have this noise.
    pub fn of(matches: &Matches, sigma: f64, rng: &mut impl Rng) -> Self {
        // Noise of both pictures comes together in the one.
        let limit = 4.0 * std::f64::consts::SQRT_2 * sigma;
        let effort = Effort { limit, confidence: 0.99, least: 20, most: 150 };
        let plane = search(&Plane, matches, &effort, rng).into_iter().next();
        let turn = search(&Turn, matches, &effort, rng).into_iter().next();
        Self {
            plane: plane.map(|best| finished(&Plane, best, matches, limit)),
            turn: turn.map(|best| finished(&Turn, best, matches, limit)),
        }
    }
}

/// Coordinates of a match.
const COORDINATES: f64 = 4.0;
/// What each dimension costs in which a match may be anywhere. A match off the plane then counts as much as 2.3 on it: a plane is believed
/// until 30 % of what agrees is off it. (Torr takes ln 4 = 1.39, and 19 %.)
const PLACE: f64 = 1.6;

/// Torr's criterion of a model; least is best.
struct Criterion {
    /// Dimension of what a match may still be anywhere in: 3 with depth, 2 without.
    dimension: f64,
    parameters: f64,
}

impl Criterion {
    fn of(&self, squares: impl Iterator<Item = (f64, f64)>) -> f64 {
        // A match that no model explains costs the same under each: as much as one on a plane may be off at most.
        let place = PLACE * self.dimension;
        let outlier = 2.0 * (COORDINATES - 2.0) + PLACE * 2.0;
        let (mut sum, mut count) = (0.0, 0.0);
        for (square, weight) in squares {
            sum += weight * (square + place).min(outlier);
            count += weight;
        }
        sum + (COORDINATES * f64::max(count, 1.0)).ln() * self.parameters
    }
}

/// Variance of a coordinate by which both kinds of model are measured: that of the plane's own matches, where it is a little larger.
/// The essential matrix goes on bending until what is left of the noise is too little.
fn pooled(variance: f64, plane: &Matrix3<f64>, matches: &Matches) -> f64 {
    const MOST: f64 = 1.7;
    let squares = matches.list.iter().map(|m| transfer_squared(plane, m)).filter(|square| *square < 2.0 * 9.0 * MOST * variance);
    // Half of the squares of two coordinates, each with the noise of two points, are under 2 ln 2 · 2 σ².
    (median(squares.collect()) / (4.0 * std::f64::consts::LN_2)).clamp(variance, MOST * variance)
}

/// What sort of motion it is, and that motion.
pub(super) fn judge(
    general: Twisted,
    flat: &Flat,
    sigma: f64,
    pairs: &[RayPair],
    matches: &Matches,
    plausible: &Plausible,
) -> (Twisted, Motion) {
    let variance = flat.plane.map_or(sigma * sigma, |h| pooled(sigma * sigma, &h, matches));
    let essential = general.essential();
    let square = |(m, plausible): (&Match, &bool)| if *plausible { residual(&essential, m).powi(2) / variance } else { f64::INFINITY };
    let squares = matches.list.iter().zip(&plausible.0).map(|both| (square(both), both.0.weight));
    let by_depth = Criterion { dimension: 3.0, parameters: 5.0 }.of(squares);
    let flat_cost = |h: &Matrix3<f64>, parameters: f64| {
        let squares = matches.list.iter().map(|m| (transfer_squared(h, m) / (2.0 * variance), m.weight));
        Criterion { dimension: 2.0, parameters }.of(squares)
    };
    let by_plane = flat.plane.map(|h| (flat_cost(&h, 8.0), h)).filter(|plane| plane.0 < by_depth);
    let by_turn = flat.turn.map(|r| (flat_cost(&r, 3.0), r)).filter(|turn| turn.0 < by_plane.map_or(by_depth, |plane| plane.0));
    if let Some((_, rotation)) = by_turn {
        return (Twisted { rotation, direction: general.direction }, Motion::TurnOnly);
    }
    match by_plane.and_then(|plane| before_plane(&plane.1, sigma, pairs, matches)) {
        Some(pose) => (pose, Motion::BeforePlane),
        None => (general, Motion::General),
    }
}

/// The motion of a homography that has the plane before both cameras. Two are left as a rule, as if the way and the plane's normal had
/// changed places: what is off the plane decides; where nothing is, that which goes more along the view, as a walker does.
fn before_plane(h: &Matrix3<f64>, sigma: f64, pairs: &[RayPair], matches: &Matches) -> Option<Twisted> {
    let variance = 2.0 * sigma * sigma;
    let on_plane: Vec<&Match> = matches.list.iter().filter(|m| transfer_squared(h, m) < AGREES.powi(2) * variance).collect();
    let faces = |motion: &PlaneMotion| {
        let before = |m: &&&Match| motion.normal.dot(&Vector3::new(m.a[0], m.a[1], 1.0)) > 0.0;
        2 * on_plane.iter().filter(before).count() > on_plane.len()
    };
    let pose = |motion: PlaneMotion| Some(Twisted { rotation: motion.rotation, direction: motion.translation.try_normalize(1e-9)? });
    let others = |pose: &Twisted| -> usize {
        let essential = pose.essential();
        let is_off_plane = |m: &&Match| transfer_squared(h, m) >= 16.0 * variance;
        let agrees =
            |m: &&Match| residual(&essential, m).abs() < AGREES * sigma && is_ahead(&pose.rotation, &pose.direction, &pairs[m.pair]);
        matches.list.iter().filter(is_off_plane).filter(agrees).count()
    };
    let poses: Vec<Twisted> = decompose(h).into_iter().filter(faces).filter_map(pose).collect();
    let counts: Vec<usize> = poses.iter().map(others).collect();
    let most = counts.iter().copied().max()?;
    // Wrong matches agree with either by chance, some more with the one: that decides nothing.
    let chance = 3 + (2.0 * (most as f64).sqrt()) as usize;
    let left = poses.into_iter().zip(counts).filter(|(_, count)| count + chance >= most).map(|(pose, _)| pose);
    left.max_by(|a, b| a.direction.z.abs().total_cmp(&b.direction.z.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visual::two_view::{RelativePoseOptions, epipolar, estimate_relative_pose, scene};
    use planwalk_types::Seed;

    /// Pairs of points on a plane 3 m ahead, slanted; the camera walks along its view and turns.
    fn wall(seed: u64, noise_rad: f64, wild_share: f64) -> (Vec<RayPair>, crate::visual::two_view::RelativePose) {
        let (pairs, _) = scene::pairs(seed, 150, 0.0, 0.0, 0.0);
        let rotation = nalgebra::UnitQuaternion::from_scaled_axis(Vector3::new(0.02, 0.09, -0.01));
        let direction = Vector3::new(0.1, -0.03, -1.0).normalize();
        let normal = Vector3::new(0.5, 0.1, 1.0).normalize();
        let mut rng = Seed(seed).derive("wall", 0);
        let mut bend =
            |ray: Vector3<f64>| (ray.normalize() + Vector3::from_fn(|_, _| scene::uniform(&mut rng, -1.7, 1.7) * noise_rad)).normalize();
        let count = pairs.len() as f64;
        let walked = pairs.iter().enumerate().map(|(i, p)| {
            let point = p.a * (3.0 / p.a.dot(&normal));
            let seen = rotation * point + direction * 0.5;
            let wild = (i as f64) < wild_share * count;
            RayPair { a: bend(p.a), b: bend(if wild { pairs[(i * 37 + 11) % pairs.len()].a } else { seen }) }
        });
        (walked.collect(), crate::visual::two_view::RelativePose { rotation, direction })
    }

    #[test]
    fn a_walk_before_a_wall_is_told_and_found() {
        for seed in 0..6 {
            let (pairs, truth) = wall(seed, 5e-4, 0.3);
            let fit = estimate_relative_pose(&pairs, &RelativePoseOptions::for_focal(500.0), &mut Seed(seed).derive("test", 0)).unwrap();
            assert_eq!(fit.motion, Motion::BeforePlane, "seed {seed}");
            // Half a milliradian over 100 points whose parallax is some 0.1 rad.
            assert!(fit.pose.rotation.angle_to(&truth.rotation).to_degrees() < 0.5, "seed {seed}");
            assert!(fit.pose.direction.angle(&truth.direction).to_degrees() < 3.0, "seed {seed}");
        }
    }

    #[test]
    fn a_room_full_of_depth_is_no_plane_and_a_turn_is_a_turn() {
        for seed in 0..6 {
            for (baseline, expected) in [(0.6, Motion::General), (0.0, Motion::TurnOnly)] {
                let (pairs, truth) = scene::pairs(seed, 150, baseline, 5e-4, 0.3);
                let options = RelativePoseOptions::for_focal(500.0);
                let fit = estimate_relative_pose(&pairs, &options, &mut Seed(seed).derive("test", 0)).unwrap();
                assert_eq!(fit.motion, expected, "seed {seed}");
                assert!(fit.pose.rotation.angle_to(&truth.rotation).to_degrees() < 0.3, "seed {seed}");
                assert!(baseline > 0.0 || fit.parallax_rad < 2e-3 && epipolar::parallax(&fit.pose.rotation, &pairs[149]) < 5e-3);
            }
        }
    }
}
