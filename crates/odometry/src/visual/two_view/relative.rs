//! How did the camera move between two pictures, and is it a general motion, one before a wall, or a mere turn?
//!
//! pairs ─▶ [`Matches`] ─▶ essential matrix ─┐
//!                      ─▶ homography ───────┼─▶ which explains them best (GRIC) ─▶ pose, inliers, noise
//!                      ─▶ rotation ─────────┘
//!
//! Matches on one plane leave the essential matrix two-fold and ill determined, and without parallax it is not determined at all
//! (Torr, Fitzgibbon & Zisserman 1999): these are told by the geometric robust information criterion (Torr 1998).

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::Rng;

use super::essential::{Epipolar, Twisted, is_ahead, residual};
use super::homography::{self, Plane, Turn, transfer_squared};
use super::matches::{Match, Matches};
use super::robust::{Candidate, Effort, Kind, improved, search};
use super::rotation::median;
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
}

impl RelativePoseOptions {
    /// For points that are off by up to a pixel or so, in pictures of this focal length in pixels.
    pub fn for_focal(focal_px: f64) -> Self {
        Self { solver: Solver::default(), limit_rad: 2.5 / focal_px, confidence: 0.999, max_samples: 400 }
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
}

/// Relative pose of two calibrated pictures, up to scale; `None` when no sample of matches gives any.
///
/// Rays are unit, camera frame (x right, y down, z forward). The same `rng` state gives the same answer.
pub fn estimate_relative_pose(pairs: &[RayPair], options: &RelativePoseOptions, rng: &mut impl Rng) -> Option<RelativePoseFit> {
    let matches = Matches::of(pairs);
    let kind = Epipolar { solver: options.solver };
    let effort = Effort { limit: options.limit_rad, confidence: options.confidence, least: 200, most: options.max_samples };
    let found = search(&kind, &matches, &effort, rng);
    let best = choose(&kind, found, pairs, &matches, options)?;
    let plausible = Plausible::of(&best, pairs, &matches, options.limit_rad);
    let sigma = noise(&best.essential(), &matches, &plausible, options.limit_rad);
    let pose = polished(best, &matches, &plausible, TUKEY * sigma);
    let flat = Flat::of(&matches, sigma, rng);
    Some(judge(pose, flat, sigma, pairs, &matches, &plausible))
}

/// Which matches may be of the scene, whatever their residual: those before both cameras whose parallax others have too. A wrong match
/// is as likely to lie along its epipolar line as anywhere, and then nothing but its depth shows it.
struct Plausible(Vec<bool>);

impl Plausible {
    /// Parallax over so many times what most have at most is nobody's.
    const MOST: f64 = 3.0;

    fn of(pose: &Twisted, pairs: &[RayPair], matches: &Matches, limit: f64) -> Self {
        let essential = pose.essential();
        let parallax: Vec<f64> = matches.list.iter().map(|m| transfer_squared(&pose.rotation, m).sqrt()).collect();
        let ahead: Vec<bool> = matches.list.iter().map(|m| is_ahead(&pose.rotation, &pose.direction, &pairs[m.pair])).collect();
        let agree = |i: &usize| ahead[*i] && residual(&essential, &matches.list[*i]).abs() < limit;
        let mut usual: Vec<f64> = (0..parallax.len()).filter(agree).map(|i| parallax[i]).collect();
        usual.sort_by(f64::total_cmp);
        let most = usual.get(usual.len() * 3 / 4).map_or(f64::INFINITY, |p| Self::MOST * p.max(limit));
        Self(parallax.into_iter().zip(ahead).map(|(p, ahead)| ahead && p < most).collect())
    }

    fn list<'a>(&'a self, matches: &'a Matches) -> impl Iterator<Item = &'a Match> {
        matches.list.iter().zip(&self.0).filter(|(_, plausible)| **plausible).map(|(m, _)| m)
    }
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
            let gains: f64 = super::essential::LEVELS.iter().map(|level| (1.0 - f64::from(*level) * share).max(0.0)).sum();
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

/// The best models without depth: a plane's, and a turn's.
struct Flat {
    plane: Option<Matrix3<f64>>,
    turn: Option<Matrix3<f64>>,
}

impl Flat {
    fn of(matches: &Matches, sigma: f64, rng: &mut impl Rng) -> Self {
        // Noise of both pictures comes together in the one.
        let limit = 4.0 * std::f64::consts::SQRT_2 * sigma;
        let effort = Effort { limit, confidence: 0.99, least: 20, most: 150 };
        let plane = search(&Plane, matches, &effort, rng).into_iter().next();
        let turn = search(&Turn, matches, &effort, rng).into_iter().next();
        Self { plane: plane.map(|c| finished(&Plane, c, matches, limit)), turn: turn.map(|c| finished(&Turn, c, matches, limit)) }
    }
}

fn finished<K: Kind>(kind: &K, from: Candidate<K::Model>, matches: &Matches, limit: f64) -> K::Model {
    let mut best = from;
    while let Some(better) = improved(kind, &best, matches, limit).filter(|better| better.cost < 0.999 * best.cost) {
        best = better;
    }
    best.model
}

/// Torr's criterion: what is left unexplained, what each match's place costs, and what the model's parameters cost. Least is best.
struct Criterion {
    /// Dimension of what a match may still be anywhere in: 3 with depth, 2 without.
    dimension: f64,
    parameters: f64,
}

impl Criterion {
    fn of(&self, squares: impl Iterator<Item = (f64, f64)>) -> f64 {
        const COORDINATES: f64 = 4.0;
        // A match that no model explains costs the same under each: as much as one on a plane may be off at most.
        let place = COORDINATES.ln() * self.dimension;
        let outlier = 2.0 * (COORDINATES - 2.0) + COORDINATES.ln() * 2.0;
        let (mut sum, mut count) = (0.0, 0.0);
        for (square, weight) in squares {
            sum += weight * (square + place).min(outlier);
            count += weight;
        }
        sum + (COORDINATES * f64::max(count, 1.0)).ln() * self.parameters
    }
}

fn judge(general: Twisted, flat: Flat, sigma: f64, pairs: &[RayPair], matches: &Matches, plausible: &Plausible) -> RelativePoseFit {
    let essential = general.essential();
    let variance = sigma * sigma;
    let of_list = |square: &dyn Fn(&Match) -> f64, criterion: Criterion| criterion.of(matches.list.iter().map(|m| (square(m), m.weight)));
    let flat_square = |h: &Matrix3<f64>, m: &Match| transfer_squared(h, m) / (2.0 * variance);
    let by_depth = {
        let square = |(m, plausible): (&Match, &bool)| if *plausible { residual(&essential, m).powi(2) / variance } else { f64::INFINITY };
        let squares = matches.list.iter().zip(&plausible.0).map(|both| (square(both), both.0.weight));
        Criterion { dimension: 3.0, parameters: 5.0 }.of(squares)
    };
    let by_plane = flat.plane.map(|h| (of_list(&|m| flat_square(&h, m), Criterion { dimension: 2.0, parameters: 8.0 }), h));
    let by_turn = flat.turn.map(|r| (of_list(&|m| flat_square(&r, m), Criterion { dimension: 2.0, parameters: 3.0 }), r));
    if std::env::var("DBG2").is_ok() {
        let n = by_plane.map(|p| matches.list.iter().filter(|m| transfer_squared(&p.1, m) < 18.0 * variance).count());
        eprintln!("# depth {by_depth:.1} plane {:?} n {n:?} of {} sigma {:.3}", by_plane.map(|p| p.0), matches.list.iter().filter(|m| residual(&essential, m).abs() < 3.0 * sigma).count(), sigma * 500.0);
    }
    let plane = by_plane.filter(|plane| plane.0 < by_depth);
    let turn = by_turn.filter(|turn| turn.0 < by_depth && plane.is_none_or(|plane| turn.0 <= plane.0));
    let of_plane = |h: Matrix3<f64>| before_plane(&h, &general, sigma, pairs, matches);
    let (pose, motion) = match (turn, plane.and_then(|plane| of_plane(plane.1))) {
        (Some((_, rotation)), _) => (Twisted { rotation, direction: general.direction }, Motion::TurnOnly),
        (None, Some(pose)) => (pose, Motion::BeforePlane),
        (None, None) => (general, Motion::General),
    };
    let mut inliers = vec![false; pairs.len()];
    let essential = pose.essential();
    for m in &matches.list {
        inliers[m.pair] = match motion {
            Motion::TurnOnly => transfer_squared(&pose.rotation, m) < 18.0 * variance,
            _ => residual(&essential, m).abs() < 3.0 * sigma && is_ahead(&pose.rotation, &pose.direction, &pairs[m.pair]),
        };
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(pose.rotation));
    RelativePoseFit { pose: RelativePose { rotation, direction: pose.direction }, motion, inliers, sigma }
}

/// The motion of a homography that has the plane before both cameras; of the two that are left as a rule, what is off the plane
/// decides, and where nothing is, the lesser turn: between pictures of a video a camera turns little.
fn before_plane(h: &Matrix3<f64>, general: &Twisted, sigma: f64, pairs: &[RayPair], matches: &Matches) -> Option<Twisted> {
    let _ = general;
    let on_plane: Vec<&Match> = matches.list.iter().filter(|m| transfer_squared(h, m) < 18.0 * sigma * sigma).collect();
    let faces = |motion: &homography::PlaneMotion| {
        let before = |m: &&&Match| motion.normal.dot(&Vector3::new(m.a[0], m.a[1], 1.0)) > 0.0;
        2 * on_plane.iter().filter(before).count() > on_plane.len()
    };
    let poses = homography::decompose(h).into_iter().filter(faces).filter_map(|motion| {
        let direction = motion.translation.try_normalize(1e-9)?;
        Some(Twisted { rotation: motion.rotation, direction })
    });
    let off_plane = |m: &&Match| transfer_squared(h, m) >= 32.0 * sigma * sigma;
    let rated = poses.map(|pose| {
        if std::env::var("DBG2").is_ok() {
            let w = Rotation3::from_matrix_unchecked(pose.rotation).scaled_axis() * 57.3;
            eprintln!("#c turn {:.2} ({:.1} {:.1} {:.1}) dir {:.2} {:.2} {:.2}", w.norm(), w.x, w.y, w.z, pose.direction.x, pose.direction.y, pose.direction.z);
        }
        let essential = pose.essential();
        let agrees = |m: &&Match| residual(&essential, m).abs() < 3.0 * sigma && is_ahead(&pose.rotation, &pose.direction, &pairs[m.pair]);
        let others: f64 = matches.list.iter().filter(off_plane).filter(agrees).map(|m| m.weight).sum();
        (others, pose.direction.z.abs(), pose)
    });
    rated.max_by(|a, b| (a.1).total_cmp(&b.1)).map(|best| best.2)
}
