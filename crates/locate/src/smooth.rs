//! Where was the walker all along, now that the whole walk is known?
//!
//! generations ──backward simulation from one final mode──▶ trajectories ──polish──▶ mean, covariance and radius for each moment
//!
//! Source: Godsill, Doucet & West 2004 (backward simulation). Each trajectory picks its past anew at every generation, by
//! weight times the density of the motion that leads on; it always may pick its own parent, so it never breaks off.
//! Departs from the book in two ways: only guesses with descendants some updates later are looked at (the others would hardly
//! be picked), and static scale is given a small spread, for else a particle could have come from its own parent only.

use nalgebra::{Matrix3, Vector3, Vector4};
use planwalk_types::{Seed, wrap_angle};
use rayon::prelude::*;

use crate::approx;
use crate::calibrate::Calibration;
use crate::drift::UNIT_RAD;
use crate::filter::{Localizer, carry};
use crate::history::{Generation, NO_PARENT};
use crate::look::evenly;
use crate::modes::weighted_quantile;
use crate::motion::{Motion, NoiseFloor, uniform};
use crate::particles::Roughening;
use crate::polish::{Link, Problem};

/// Most candidates that a trajectory chooses from at a generation.
const CANDIDATES: usize = 1024;
/// Standard deviation of where walls stand against where the plan draws them, where nothing was seen that could measure it
/// (where it could, see [`crate::calibrate`]).
const PLAN_SIGMA_M: f64 = 0.1;
/// Draws of the posterior that are polished besides the mean: places that do not merge stay visible as spread.
const DRAWS: usize = 5;
/// Smallest spreads of the backward kernel: metres, radians, log scale.
const KERNEL_M: f64 = 0.02;
const KERNEL_RAD: f64 = 0.006;
const KERNEL_LOG_SCALE: f64 = 0.005;

/// The walk at one generation or moment. Local metres.
#[derive(Debug, Clone)]
pub(crate) struct Smoothed {
    pub mean: Vector3<f64>,
    pub covariance: Matrix3<f64>,
    pub radius95_m: f64,
    pub log_scale: f64,
    pub log_scale_variance: f64,
    /// By how much the odometry turned by itself, radians a unit of way.
    pub drift_rad: f64,
}

/// A walk smoothed, and what its polish measured, if there was anything to polish against.
#[derive(Debug, Clone, Default)]
pub(crate) struct SmoothedWalk {
    /// One entry a generation; empty when no particle is in the mode.
    pub walk: Vec<Smoothed>,
    pub calibration: Option<Calibration>,
}

/// The walk that ends in mode `mode`, smoothed over the particles and polished against the plan.
pub(crate) fn smooth(localizer: &Localizer<'_>, mode: usize, trajectories: usize) -> SmoothedWalk {
    let (walk, draws) = backward(localizer, mode, trajectories);
    let mean: Vec<Vector4<f64>> = walk.iter().map(|s| Vector4::new(s.mean.x, s.mean.y, s.mean.z, s.log_scale)).collect();
    if mean.is_empty() {
        return SmoothedWalk::default();
    }
    let links = localizer.history.generations.iter().zip(&walk);
    let links = links.map(|(g, s)| Link { motion: g.motion.without_drift(s.drift_rad), rays: &g.rays }).collect();
    let mut problem = Problem::new(links, &mean, localizer.plan, &localizer.walls, &localizer.options);
    // Other places are a second thought: their spread is that of one hill.
    let draws = if mode == 0 { &draws[..] } else { &[] };
    match problem.polish(&mean, draws) {
        Some(polished) => SmoothedWalk { walk: polished.walk, calibration: Some(polished.calibration) },
        None => SmoothedWalk { walk, calibration: None },
    }
}

/// Mean and spread at every generation, and a few of the trajectories.
fn backward(localizer: &Localizer<'_>, mode: usize, trajectories: usize) -> (Vec<Smoothed>, Vec<Vec<Vector4<f64>>>) {
    let generations = &localizer.history.generations;
    let Some(last) = generations.last() else { return Default::default() };
    let ends = draw_ends(localizer, last, mode, trajectories);
    if ends.is_empty() {
        return Default::default();
    }
    let seed = localizer.options.seed.child("backward", mode as u64);
    let mut nodes: Vec<Node> = ends.into_iter().map(|i| Node::of(last, i)).collect();
    let mut walk = vec![summarise(&nodes)];
    let kept: Vec<usize> = evenly(DRAWS, nodes.len()).collect();
    let mut draws: Vec<Vec<Vector4<f64>>> = kept.iter().map(|i| vec![Vector4::from(nodes[*i].state)]).collect();
    for g in (1..generations.len()).rev() {
        let (before, here) = (&generations[g - 1], &generations[g]);
        let kernel = Kernel::new(here, &localizer.options.noise_floor);
        let seed = seed.child("step", g as u64);
        let candidates = kernel.candidates(before, seed);
        nodes.par_iter_mut().enumerate().for_each(|(i, node)| {
            *node = match node.particle.and_then(|child| choose(before, here, child, &kernel, &candidates, seed.child("walk", i as u64))) {
                Some(particle) => Node::of(before, particle),
                // Put in anew after a loss: before that, dead reckoning.
                None => Node { particle: None, state: reckon_back(&here.motion.without_drift(node.drift_rad), node.state), ..*node },
            };
        });
        walk.push(summarise(&nodes));
        draws.iter_mut().zip(&kept).for_each(|(draw, i)| draw.push(Vector4::from(nodes[*i].state)));
    }
    walk.reverse();
    draws.iter_mut().for_each(|draw| draw.reverse());
    (walk, draws)
}

/// Where a trajectory is at a generation: (x, y, heading, log scale), and which particle that is.
#[derive(Debug, Clone, Copy)]
struct Node {
    particle: Option<usize>,
    state: [f64; 4],
    /// Radians a unit of way.
    drift_rad: f64,
}

impl Node {
    fn of(generation: &Generation, i: usize) -> Self {
        Self { particle: Some(i), state: state(generation, i), drift_rad: drift_rad(generation, i) }
    }
}

/// Particles of the last generation in this mode, in proportion to weight.
fn draw_ends(localizer: &Localizer<'_>, last: &Generation, mode: usize, count: usize) -> Vec<usize> {
    let in_mode = |i: &usize| localizer.modes.of(&localizer.bins, last.x[*i], last.y[*i], last.heading[*i]) == Some(mode);
    let members: Vec<usize> = (0..last.len()).filter(in_mode).collect();
    let total: f64 = members.iter().map(|i| f64::from(last.weight[*i])).sum();
    let mut ends = Vec::with_capacity(count);
    let mut swept = 0.0;
    for i in members {
        swept += f64::from(last.weight[i]);
        while ends.len() < count && swept > (ends.len() as f64 + 0.5) * total / count as f64 {
            ends.push(i);
        }
    }
    ends
}

fn state(generation: &Generation, i: usize) -> [f64; 4] {
    [generation.x[i], generation.y[i], generation.heading[i], generation.log_scale[i]].map(f64::from)
}

fn drift_rad(generation: &Generation, i: usize) -> f64 {
    f64::from(UNIT_RAD) * f64::from(generation.drift[i]) * libm::exp(f64::from(generation.log_scale[i]))
}

/// The state before `motion` that leads to `after` without noise.
fn reckon_back(motion: &Motion, after: [f64; 4]) -> [f64; 4] {
    let heading = wrap_angle(after[2] - motion.turn_rad);
    let end = motion.applied_to(Vector3::new(0.0, 0.0, heading), libm::exp(after[3]));
    [after[0] - end.x, after[1] - end.y, heading, after[3]]
}

/// The predecessor of particle `child`: drawn by weight times motion density, its own parent among the candidates.
fn choose(before: &Generation, here: &Generation, child: usize, kernel: &Kernel, candidates: &[Candidate], seed: Seed) -> Option<usize> {
    let parent = here.parent[child];
    if parent == NO_PARENT {
        return None;
    }
    let parent = parent as usize;
    let to = state(here, child);
    let mut rng = seed.derive("pick", 0);
    let mut total = kernel.weight(&kernel.candidate(before, parent), &to) + f64::MIN_POSITIVE;
    let mut chosen = parent;
    // A draw in one pass: each candidate takes over in proportion to its weight (Chao 1982, for one winner).
    for candidate in candidates.iter().filter(|c| c.particle != parent) {
        let weight = kernel.weight(candidate, &to);
        if weight > 0.0 {
            total += weight;
            if uniform(&mut rng) * total < weight {
                chosen = candidate.particle;
            }
        }
    }
    Some(chosen)
}

/// A particle of the generation before, moved without noise.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    particle: usize,
    expected: Vector3<f64>,
    /// Cosine and sine of the heading that it moved from.
    cos: f64,
    sin: f64,
    log_scale: f64,
    /// One over the variances ahead and aside, 1/m².
    precision: [f64; 2],
    weight: f64,
}

/// Density, up to a constant, that a particle of the generation before moved to a given state.
struct Kernel {
    motion: Motion,
    variance_m: f64,
    /// Of the motion, unit²; it is stretched by the candidate's scale.
    variance_unit: [f64; 2],
    precision_rad: f64,
    precision_log_scale: f64,
}

impl Kernel {
    fn new(here: &Generation, floor: &NoiseFloor) -> Self {
        let rough = here.roughening.unwrap_or(Roughening { metres: 0.0, heading_rad: 0.0, log_scale: 0.0 });
        let square = |a: f64, b: f32| a * a + f64::from(b) * f64::from(b);
        let motion = here.motion;
        let along = (floor.length_relative * motion.length).powi(2);
        let turn = floor.turn_per_sqrt_m_rad.powi(2) * motion.length;
        Self {
            motion,
            variance_m: square(KERNEL_M, rough.metres),
            variance_unit: [0, 1].map(|i| motion.covariance[(i, i)].max(0.0) + along),
            precision_rad: 1.0 / (square(KERNEL_RAD, rough.heading_rad) + motion.covariance[(2, 2)].max(0.0) + turn),
            precision_log_scale: 1.0 / square(KERNEL_LOG_SCALE, rough.log_scale),
        }
    }

    /// Candidates from everywhere in the generation, at most [`CANDIDATES`].
    fn candidates(&self, before: &Generation, seed: Seed) -> Vec<Candidate> {
        let stride = before.len().div_ceil(CANDIDATES).max(1);
        let offset = (uniform(&mut seed.derive("offset", 0)) * stride as f64) as usize;
        (offset..before.len()).step_by(stride).map(|j| self.candidate(before, j)).collect()
    }

    fn candidate(&self, before: &Generation, j: usize) -> Candidate {
        let [x, y, heading, log_scale] = state(before, j);
        let scale = libm::exp(log_scale);
        let (sin, cos) = libm::sincos(heading);
        let precision = self.variance_unit.map(|unit| 1.0 / (self.variance_m + scale * scale * unit));
        let expected = self.motion.without_drift(drift_rad(before, j)).applied_to(Vector3::new(x, y, heading), scale);
        Candidate { particle: j, expected, cos, sin, log_scale, precision, weight: f64::from(before.weight[j]) }
    }

    fn weight(&self, from: &Candidate, to: &[f64; 4]) -> f64 {
        let (dx, dy) = (to[0] - from.expected.x, to[1] - from.expected.y);
        let (ahead, aside) = (from.cos * dx + from.sin * dy, -from.sin * dx + from.cos * dy);
        let metres = ahead * ahead * from.precision[0] + aside * aside * from.precision[1];
        // Beyond five sigmas: spares most candidates the rest.
        if !(metres < 25.0) {
            return 0.0;
        }
        let turn = wrap_angle(to[2] - from.expected.z);
        let stretch = to[3] - from.log_scale;
        let exponent = metres + turn * turn * self.precision_rad + stretch * stretch * self.precision_log_scale;
        if exponent < 50.0 { from.weight * f64::from(approx::exp(-0.5 * exponent as f32)) } else { 0.0 }
    }
}

/// Mean, covariance and 95 % radius of equally likely states.
fn summarise(nodes: &[Node]) -> Smoothed {
    let count = nodes.len().max(1) as f64;
    let (mut x, mut y, mut s, mut c, mut log_scale, mut drift) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for Node { state, drift_rad, .. } in nodes {
        drift += drift_rad / count;
        let (sin, cos) = libm::sincos(state[2]);
        (x, y, s, c, log_scale) = (x + state[0], y + state[1], s + sin, c + cos, log_scale + state[3]);
    }
    let mean = Vector3::new(x / count, y / count, libm::atan2(s, c));
    let mut covariance = Matrix3::zeros();
    let mut distances = Vec::with_capacity(nodes.len());
    let log_scale = log_scale / count;
    let log_scale_variance = nodes.iter().map(|n| (n.state[3] - log_scale).powi(2)).sum::<f64>() / count;
    for Node { state, .. } in nodes {
        let off = Vector3::new(state[0] - mean.x, state[1] - mean.y, wrap_angle(state[2] - mean.z));
        covariance += off * off.transpose() / count;
        distances.push((off.x.hypot(off.y), 1.0));
    }
    // However sharp the cloud, the walls stand off their plan by centimetres, all that are seen from a place together.
    let plan = PLAN_SIGMA_M * PLAN_SIGMA_M;
    covariance += Matrix3::from_diagonal(&Vector3::new(plan, plan, KERNEL_RAD * KERNEL_RAD));
    let radius95_m = weighted_quantile(&mut distances, 0.95).hypot(2.448 * PLAN_SIGMA_M);
    Smoothed { mean, covariance, radius95_m, log_scale, log_scale_variance, drift_rad: drift }
}

/// Radius around the first place that holds 95 % of equally likely Gaussians of one covariance around all of `places`.
pub(crate) fn radius95(places: &[(f64, f64)], covariance: &Matrix3<f64>) -> f64 {
    const DIRECTIONS: usize = 24;
    let Some(centre) = places.first() else { return 0.0 };
    let (a, b, c) = (covariance[(0, 0)].max(0.0), covariance[(0, 1)], covariance[(1, 1)].max(0.0));
    let root = a.sqrt().max(1e-12);
    let (low, corner) = (b / root, (c - b * b / (root * root)).max(0.0).sqrt());
    let spokes: Vec<(f64, f64)> = (0..DIRECTIONS)
        .map(|i| {
            let (s, c) = libm::sincos((i as f64 + 0.5) * std::f64::consts::TAU / DIRECTIONS as f64);
            (root * c, low * c + corner * s)
        })
        .collect();
    // Mass within a circle, spoke by spoke: along a spoke the distance in sigmas is Rayleigh's.
    let beyond = |sigmas: f64| libm::exp(-0.5 * sigmas.max(0.0).powi(2));
    let within = |radius: f64| {
        let mut mass = 0.0;
        for place in places {
            let (dx, dy) = (place.0 - centre.0, place.1 - centre.1);
            for spoke in &spokes {
                let long = (spoke.0 * spoke.0 + spoke.1 * spoke.1).max(1e-24);
                let half = dx * spoke.0 + dy * spoke.1;
                let inside = half * half - long * (dx * dx + dy * dy - radius * radius);
                if inside > 0.0 {
                    let reach = inside.sqrt();
                    mass += beyond((-half - reach) / long) - beyond((-half + reach) / long);
                }
            }
        }
        mass / (places.len() * DIRECTIONS) as f64
    };
    let farthest = places.iter().map(|p| (p.0 - centre.0).hypot(p.1 - centre.1)).fold(0.0, f64::max);
    let (mut short, mut long) = (0.0, farthest + 5.0 * (a + c).sqrt() + 1e-9);
    for _ in 0..30 {
        let middle = 0.5 * (short + long);
        if within(middle) < 0.95 { short = middle } else { long = middle }
    }
    0.5 * (short + long)
}

/// The smoothed walk at every moment of the path: between generations the odometry, bent to meet both.
pub(crate) fn at_moments(localizer: &Localizer<'_>, walk: &[Smoothed]) -> Vec<Smoothed> {
    let generations = &localizer.history.generations;
    let between = |moment: &crate::filter::Moment| {
        let from = walk.get(moment.generation)?;
        let scale = libm::exp(from.log_scale);
        let mut mean = moment.since.applied_to(from.mean, scale);
        let Some((to, whole)) = walk.get(moment.generation + 1).zip(generations.get(moment.generation + 1)) else {
            let covariance = carry(&from.covariance, &moment.since, from.mean.z, scale);
            return Some(Smoothed { mean, covariance, ..from.clone() });
        };
        let whole = whole.motion;
        let share =
            if whole.length > 1e-9 { moment.since.length / whole.length } else { moment.since.turned_rad / whole.turned_rad.max(1e-9) };
        let share = share.clamp(0.0, 1.0);
        let reckoned = whole.applied_to(from.mean, scale);
        mean.x += share * (to.mean.x - reckoned.x);
        mean.y += share * (to.mean.y - reckoned.y);
        mean.z = wrap_angle(mean.z + share * wrap_angle(to.mean.z - reckoned.z));
        let mix = |a: f64, b: f64| a + share * (b - a);
        Some(Smoothed {
            mean,
            covariance: from.covariance * (1.0 - share) + to.covariance * share,
            radius95_m: mix(from.radius95_m, to.radius95_m),
            log_scale: mix(from.log_scale, to.log_scale),
            log_scale_variance: mix(from.log_scale_variance, to.log_scale_variance),
            drift_rad: from.drift_rad,
        })
    };
    localizer.moments.iter().filter_map(between).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_radius_of_one_place_is_that_of_its_gaussian() {
        let round = Matrix3::from_diagonal(&Vector3::new(0.04, 0.04, 1.0));
        // √(χ²₂(0.95)) = 2.4477.
        assert!((radius95(&[(3.0, 4.0)], &round) - 0.2 * 2.4477).abs() < 1e-4);
        let long = Matrix3::from_diagonal(&Vector3::new(1.0, 1e-8, 1.0));
        // On a line: 1.96 σ. 24 directions stand for all.
        assert!((radius95(&[(0.0, 0.0)], &long) - 1.96).abs() < 0.05, "{}", radius95(&[(0.0, 0.0)], &long));
    }

    #[test]
    fn a_second_place_widens_the_radius_until_it_is_reached() {
        let narrow = Matrix3::from_diagonal(&Vector3::new(0.01, 0.01, 1.0));
        let radius = radius95(&[(0.0, 0.0), (3.0, 0.0)], &narrow);
        assert!(radius > 3.0 && radius < 3.3, "{radius}");
        assert!(radius95(&[(0.0, 0.0)], &Matrix3::zeros()) < 1e-6);
    }
}
