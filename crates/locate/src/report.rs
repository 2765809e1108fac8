//! What would the recipe of 2013 have said? Kinematics and walls, nothing else: the baseline that every gain is measured against.
//!
//! uniform cover ──▶ for each motion: draw with replacement ──▶ move with noise ──▶ weight 0 in a wall ──▶ normalise
//!
//! Source: Chu 2013, §2.1 (Monte Carlo localisation by ego-motion alone): a fixed number of particles, scale taken as true, no
//! sightings, no smoothing. Where it is silent we are kind to it: the whole way is tested for walls and not only its end; heading
//! is uniform, because nobody told it; steps are gathered as in [`crate::Localizer`]; and it is let say `ambiguous` while the
//! heaviest place holds little of the mass. It has no means to doubt a place that holds all of it.

use nalgebra::{Matrix3, Vector3};
use planwalk_types::{Body, Estimate, FloorPlan, Hypothesis, Odom, Path, PlanPose, Rigid2, ScaleEstimate, Seed, Stamp, Status};
use rayon::prelude::*;

use crate::LocateError;
use crate::chance::Chance;
use crate::filter::carry;
use crate::modes::{Bins, Modes};
use crate::motion::{Motion, MoveSampler, NoiseFloor};
use crate::options::LocateOptions;
use crate::particles::{CHUNK, Particles, wrapped};
use crate::prior::{self, ScalePrior, StartPrior};
use crate::run::{HYPOTHESES_MAX, HYPOTHESIS_MIN, Localization, Quality, check};
use crate::verdict::VerdictOptions;
use crate::walls::{GroundCosts, Walls};

/// Options of [`localize_by_report`].
#[derive(Debug, Clone, PartialEq)]
pub struct ReportOptions {
    /// Where chance comes from.
    pub seed: Seed,
    /// Where the walk begins, if somebody knows.
    pub start: Option<StartPrior>,
    /// Metres in a unit of odometry, taken as true.
    pub metres_per_unit: f64,
    /// Particles, from the first step to the last. 40 000 are what published pedestrian filters afford.
    pub particles: usize,
    /// Noise of the motion, on top of what the odometry states.
    pub noise_floor: NoiseFloor,
    /// Steps are gathered until the body has moved so far, metres …
    pub update_distance_m: f64,
    /// … or has turned by so much, radians.
    pub update_turn_rad: f64,
}

impl ReportOptions {
    /// The recipe's defaults: a unit is a metre.
    pub fn new(seed: Seed) -> Self {
        let ours = LocateOptions::new(seed, ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.0 });
        Self {
            seed,
            start: None,
            metres_per_unit: 1.0,
            particles: 40_000,
            noise_floor: ours.noise_floor,
            update_distance_m: ours.update_distance_m,
            update_turn_rad: ours.update_turn_rad,
        }
    }
}

/// Localises a walk by the recipe. The track is the causal one: the recipe does not look back.
///
/// # Errors
/// [`LocateError`] when the path, the start or the scale make no sense.
pub fn localize_by_report(
    path: &Path,
    plan: &FloorPlan,
    options: &ReportOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<Localization, LocateError> {
    check(path)?;
    let scale = ScalePrior { metres_per_unit: options.metres_per_unit, relative_sigma: 0.0 };
    LocateOptions { start: options.start, ..LocateOptions::new(options.seed, scale) }.check(plan)?;
    let mut recipe = Recipe::new(plan, options, &scale);
    let mut estimates = Vec::with_capacity(path.steps.len() + 1);
    estimates.extend(path.steps.first().map(|step| recipe.estimate(step.from)));
    for (index, step) in path.steps.iter().enumerate() {
        recipe.window = recipe.window.then(&Motion::of(step, 1.0));
        let far = recipe.window.length * options.metres_per_unit >= options.update_distance_m;
        if far || recipe.window.turned_rad >= options.update_turn_rad || index + 1 == path.steps.len() {
            recipe.update();
        }
        estimates.push(recipe.estimate(step.to));
        progress((index + 1) as f64 / path.steps.len() as f64);
    }
    Ok(recipe.answer(path, estimates))
}

/// The cloud and what is known of it.
struct Recipe<'a> {
    plan: &'a FloorPlan,
    options: &'a ReportOptions,
    walls: Walls,
    bins: Bins,
    cloud: Particles,
    modes: Modes,
    window: Motion,
    updates: u64,
    /// Every particle met a wall in the same update: there is nothing to normalise, and nothing brings the place back.
    dead: bool,
}

impl<'a> Recipe<'a> {
    fn new(plan: &'a FloorPlan, options: &'a ReportOptions, scale: &ScalePrior) -> Self {
        let walls = Walls::new(plan, GroundCosts::default());
        let count = options.particles.max(1);
        let poses = match &options.start {
            Some(start) => prior::around(start, plan, &walls, count, options.seed),
            None => prior::cover(plan, count, options.seed),
        };
        let bins = Bins::new(plan.size_m());
        let cloud = prior::particles(&poses, scale, options.seed);
        let modes = bins.modes(&cloud);
        Self { plan, options, walls, bins, cloud, modes, window: Motion::none(), updates: 0, dead: false }
    }

    /// Draw with replacement, move, weigh, normalise.
    fn update(&mut self) {
        let motion = std::mem::replace(&mut self.window, Motion::none());
        let seed = self.options.seed.child("report", self.updates);
        self.updates += 1;
        if self.updates > 1 {
            self.cloud.resample_systematic(self.options.particles.max(1), seed);
        }
        self.predict_and_weigh(&motion, seed);
        self.dead |= self.cloud.log_weight.iter().all(|w| *w == f32::NEG_INFINITY);
        self.cloud.normalize();
        self.modes = self.bins.modes(&self.cloud);
    }

    fn predict_and_weigh(&mut self, motion: &Motion, seed: Seed) {
        let sampler = MoveSampler::new(motion, &self.options.noise_floor, self.options.metres_per_unit);
        let chance = Chance::new(seed, "move");
        let (walls, scale) = (&self.walls, self.options.metres_per_unit as f32);
        let cloud = &mut self.cloud;
        let poses = (cloud.x.par_chunks_mut(CHUNK), cloud.y.par_chunks_mut(CHUNK), cloud.heading.par_chunks_mut(CHUNK));
        (poses.0, poses.1, poses.2, cloud.log_weight.par_chunks_mut(CHUNK)).into_par_iter().enumerate().for_each(
            |(chunk, (xs, ys, headings, log_weights))| {
                for i in 0..xs.len() {
                    let [a, b, c, _] = chance.normals((chunk * CHUNK + i) as u32);
                    let [forward, left, turn] = sampler.shape([a, b, c]);
                    let (s, c) = libm::sincosf(headings[i]);
                    let x = xs[i] + scale * (c * forward - s * left);
                    let y = ys[i] + scale * (s * forward + c * left);
                    if walls.is_wall(x, y) || walls.crossings(xs[i], ys[i], x, y) > 0 {
                        log_weights[i] = f32::NEG_INFINITY;
                    }
                    (xs[i], ys[i], headings[i]) = (x, y, wrapped(headings[i] + turn));
                }
            },
        );
    }

    fn status(&self) -> Status {
        let believed = VerdictOptions::default();
        match self.modes.modes.first() {
            None => Status::Lost,
            _ if self.dead => Status::Lost,
            Some(best) if best.mass >= believed.mass && best.radius95_m <= believed.radius_m => Status::Tracking,
            Some(_) => Status::Ambiguous,
        }
    }

    fn estimate(&self, stamp: Stamp) -> Estimate {
        let nowhere = || (Vector3::zeros(), Matrix3::identity() * 1e6, 1e3, 0.0);
        let (mean, covariance, radius95_m, mass) =
            self.modes.modes.first().map_or_else(nowhere, |m| (m.mean, m.covariance, m.radius95_m, m.mass));
        let scale = self.options.metres_per_unit;
        let pose = self.on_plan(&self.window.applied_to(mean, scale));
        let covariance = carry(&covariance, &self.window, mean.z, scale);
        let known = ScaleEstimate { metres_per_unit: scale, relative_sigma: 0.0 };
        Estimate { stamp, pose, covariance, radius95_m, probability: mass.clamp(0.0, 1.0), status: self.status(), scale: Some(known) }
    }

    fn on_plan(&self, pose: &Vector3<f64>) -> PlanPose {
        PlanPose::new(pose.x + self.plan.origin().x, pose.y + self.plan.origin().y, pose.z)
    }

    fn answer(&self, path: &Path, estimates: Vec<Estimate>) -> Localization {
        let scale = ScaleEstimate { metres_per_unit: self.options.metres_per_unit, relative_sigma: 0.0 };
        let reported = self.modes.modes.iter().filter(|m| m.mass >= HYPOTHESIS_MIN).count().clamp(1, HYPOTHESES_MAX);
        let hypotheses = self.modes.modes.iter().take(reported).map(|mode| {
            let (pose, covariance) = (self.on_plan(&mode.mean), mode.covariance);
            let (probability, radius95_m) = (mode.mass.clamp(0.0, 1.0), mode.radius95_m);
            Hypothesis { probability, pose, covariance, radius95_m, scale, track: ending_at(path, pose, scale.metres_per_unit) }
        });
        let quality = Quality {
            steps: path.steps.len(),
            updates: self.updates as usize,
            particles_max: self.cloud.len(),
            particles_end: self.cloud.len(),
            attempts: 1,
            ..Quality::default()
        };
        let hypotheses = hypotheses.collect();
        Localization {
            filter: estimates.clone(),
            track: estimates,
            hypotheses,
            status: self.status(),
            scale,
            quality,
            contradicted: Vec::new(),
            apart: Vec::new(),
        }
    }
}

/// The path as odometry has it, laid so that it ends at a pose.
fn ending_at(path: &Path, end: PlanPose, metres_per_unit: f64) -> Vec<(Stamp, PlanPose)> {
    let metric = |pose: &Rigid2<Odom, Body>| Rigid2::new(pose.x * metres_per_unit, pose.y * metres_per_unit, pose.heading_rad);
    let poses: Vec<Rigid2<Odom, Body>> = path.poses().iter().map(metric).collect();
    let Some(last) = poses.last() else { return Vec::new() };
    let plan_from_odom = end * last.inverse();
    path.stamps().zip(&poses).map(|(stamp, pose)| (stamp, plan_from_odom * *pose)).collect()
}
