//! What does the whole walk say? The filter over all steps, then the smoother, then the answer.
//!
//! Path + sightings ──[`Localizer::push`] for each step──▶ [`Localizer::finish`] ──▶ [`Localization`]

use planwalk_types::{Estimate, FloorPlan, Hypothesis, Path, ScaleEstimate, Sighting, Status, Step};
use rayon::prelude::*;

use crate::LocateError;
use crate::attempts::{self, Attempt};
use crate::contradicted::{self, ContradictedWall};
use crate::discriminate::{self, Apart};
use crate::filter::{FilterView, Localizer};
use crate::likelihood::Explained;
use crate::look::Looks;
use crate::options::LocateOptions;
use crate::smooth::{self, Smoothed};

/// Hypotheses below this share of the mass are not reported, unless none is above it.
pub(crate) const HYPOTHESIS_MIN: f64 = 0.01;
/// Most hypotheses that are reported.
pub(crate) const HYPOTHESES_MAX: usize = 6;
/// Backward trajectories of the best hypothesis; 95 % radii from 200 are good to about 10 %. The others get a quarter.
const TRAJECTORIES: usize = 200;

/// How well the answer holds up.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Quality {
    /// Share of the sightings used that drawn walls explain along the track, 0..=1. The rest is furniture, people, mistakes.
    pub seen_explained: f64,
    /// Share of the sightings used whose ray goes through a drawn wall along the track.
    pub seen_through_walls: f64,
    /// Sightings used.
    pub seen: usize,
    /// Nats a sighting by which the best place beat calling everything furniture, at the end (see
    /// [`crate::VerdictOptions::gain_nats`]).
    pub gain_nats: f64,
    /// How often the track enters a wall.
    pub wall_crossings: usize,
    /// Steps of the path.
    pub steps: usize,
    /// Updates of the filter: steps are gathered until the body has moved.
    pub updates: usize,
    /// Most particles at any time.
    pub particles_max: usize,
    /// Particles at the end.
    pub particles_end: usize,
    /// Nats by which the track beats calling everything seen furniture, walls crossed taken off, tempered as in the filter.
    pub score_nats: f64,
    /// Independent runs over the walk.
    pub attempts: usize,
    /// The run whose best place this is, counted from 0.
    pub attempt: usize,
    /// How far the plan draws walls off from where they were seen, all of one place together: standard deviation, metres.
    /// Measured from the residuals along the track, with a weak prior; `None` where too little was seen on walls.
    pub plan_sigma_m: Option<f64>,
}

/// The posterior of a walk.
#[derive(Debug, Clone)]
pub struct Localization {
    /// What was known at each moment: the start, then the end of each step. Always of the first run: picking another by what
    /// came later would not be causal.
    pub filter: Vec<Estimate>,
    /// The whole walk under the best hypothesis, known from its end; the same moments.
    pub track: Vec<Estimate>,
    /// What explains the walk, likeliest first; at least one.
    pub hypotheses: Vec<Hypothesis>,
    /// The verdict at the end.
    pub status: Status,
    /// Metres per unit of odometry, over all hypotheses.
    pub scale: ScaleEstimate,
    /// How well the answer holds up.
    pub quality: Quality,
    /// Drawn walls that the walk went or saw through, in order of the walk.
    pub contradicted: Vec<ContradictedWall>,
    /// What would tell the likeliest hypothesis from each other one, where the verdict is ambiguous.
    pub apart: Vec<Apart>,
}

/// Localises a walk on a plan. `progress` is told the share done, 0..=1, in rising order.
///
/// Sightings belong to the step during which they were made; they may come in any order, and those outside of the path's time
/// are left out.
///
/// # Errors
/// [`LocateError`] when the path, the start or the scale make no sense. Not knowing where the walker is, is no error.
pub fn localize(
    path: &Path,
    sightings: &[Sighting],
    plan: &FloorPlan,
    options: &LocateOptions,
    progress: &mut dyn FnMut(f64),
) -> Result<Localization, LocateError> {
    localize_observed(path, sightings, plan, options, progress, &mut |_, _| {})
}

/// As [`localize`]; `observer` sees the cloud after every update, and is told which run it belongs to.
///
/// # Errors
/// As [`localize`].
pub fn localize_observed(
    path: &Path,
    sightings: &[Sighting],
    plan: &FloorPlan,
    options: &LocateOptions,
    progress: &mut dyn FnMut(f64),
    observer: &mut dyn FnMut(usize, &FilterView<'_>),
) -> Result<Localization, LocateError> {
    check(path)?;
    let mut sightings: Vec<Sighting> = sightings.to_vec();
    sightings.sort_by_key(|s| s.stamp);
    let most = if options.start.is_some() || sightings.is_empty() { 1 } else { options.attempts.max(1) };
    // Where nothing is seen, no look finds anything: many particles have to do.
    let options = &LocateOptions { relocalise: options.relocalise && !sightings.is_empty(), ..options.clone() };
    let mut runs: Vec<Attempt> = Vec::new();
    let mut looks = Looks::default();
    while runs.len() < most && !attempts::settled(&runs, &options.verdict) {
        let first = runs.len();
        // Two at least must agree.
        let last = if first == 0 { most.min(2) } else { first + 1 };
        let seed_of = |index: usize| if index == 0 { options.seed } else { options.seed.child("attempt", index as u64) };
        let each: Vec<_> = (first..last).map(|index| LocateOptions { seed: seed_of(index), ..options.clone() }).collect();
        // Two runs are usual; further ones squeeze into what is left of the bar.
        let done_after = |runs: usize| match runs {
            0 => 0.0,
            all if all == most => 1.0,
            some => 1.0 - 0.25f64.powi(some as i32 - 1),
        };
        let (from, to) = (done_after(first), done_after(last));
        let mut share = |done: f64| progress(from + (to - from) * done);
        let found = run_together(path, &sightings, plan, &each, &mut looks, &mut share, &mut |run, view| observer(first + run, view))?;
        runs.extend(found.into_iter().enumerate().map(|(run, found)| Attempt { index: first + run, found }));
    }
    progress(1.0);
    let mut found = attempts::merge(runs, &options.verdict).ok_or(LocateError::EmptyPath { steps: 0 })?;
    if found.status == Status::Ambiguous {
        found.apart = discriminate::apart(plan, &found.hypotheses);
    }
    Ok(found)
}

/// A filter each over the whole walk, step by step beside each other; sightings in time order.
///
/// A filter that knows its place has too few particles for two threads, two filters have enough. They look in turn, with all
/// threads: what one looks at, the other asks for at the same step.
fn run_together(
    path: &Path,
    sightings: &[Sighting],
    plan: &FloorPlan,
    options: &[LocateOptions],
    looks: &mut Looks,
    progress: &mut dyn FnMut(f64),
    observer: &mut dyn FnMut(usize, &FilterView<'_>),
) -> Result<Vec<Localization>, LocateError> {
    let mut localizers = options.par_iter().map(|options| Localizer::new(plan, options)).collect::<Result<Vec<_>, _>>()?;
    for (index, (step, now)) in with_sightings(path, sightings).enumerate() {
        let updates: Vec<u64> = localizers.iter().map(Localizer::updates).collect();
        localizers.par_iter_mut().for_each(|localizer| localizer.advance(step, now));
        for localizer in &mut localizers {
            localizer.look_if_due(looks);
            localizer.arrive(step.to);
        }
        for (run, localizer) in localizers.iter().enumerate().filter(|(run, l)| l.updates() > updates[*run]) {
            observer(run, &localizer.view());
        }
        progress(0.95 * (index + 1) as f64 / path.steps.len() as f64);
    }
    localizers.par_iter_mut().for_each(Localizer::advance_rest);
    localizers.iter_mut().for_each(|localizer| localizer.look_if_due(looks));
    localizers.into_par_iter().map(Localizer::answer).collect()
}

/// Each step with what was seen during it, of sightings in time order (the first step's include those of its start).
pub(crate) fn with_sightings<'a>(path: &'a Path, sightings: &'a [Sighting]) -> impl Iterator<Item = (&'a Step, &'a [Sighting])> {
    let before = path.steps.first().map_or(0, |step| sightings.partition_point(|s| s.stamp < step.from));
    let mut seen = &sightings[before..];
    path.steps.iter().map(move |step| {
        let (now, later) = seen.split_at(seen.partition_point(|s| s.stamp <= step.to));
        seen = later;
        (step, now)
    })
}

pub(crate) fn check(path: &Path) -> Result<(), LocateError> {
    if path.steps.is_empty() {
        return Err(LocateError::EmptyPath { steps: 0 });
    }
    let mut last = None;
    for (index, step) in path.steps.iter().enumerate() {
        let covariance_finite = step.covariance.iter().all(|v| v.is_finite());
        if !([step.forward, step.left, step.turn_rad].iter().all(|v| v.is_finite()) && covariance_finite) {
            return Err(LocateError::NotFinite { index });
        }
        if step.to <= step.from || last.is_some_and(|last| step.from < last) {
            return Err(LocateError::StepsGoBack { index, from_s: step.from.as_secs(), to_s: step.to.as_secs() });
        }
        last = Some(step.to);
    }
    Ok(())
}

impl Localizer<'_> {
    /// Ends the walk: smooths it, and says what it was.
    ///
    /// # Errors
    /// [`LocateError::EmptyPath`] when no step was pushed.
    pub fn finish(mut self) -> Result<Localization, LocateError> {
        self.advance_rest();
        let mut looks = std::mem::take(&mut self.looks);
        self.look_if_due(&mut looks);
        self.answer()
    }

    /// What the walk was, all of which was taken in.
    fn answer(mut self) -> Result<Localization, LocateError> {
        if self.moments.is_empty() {
            return Err(LocateError::EmptyPath { steps: 0 });
        }
        self.arrive_at_end();
        let reported = self.modes.modes.iter().filter(|m| m.mass >= HYPOTHESIS_MIN).count().clamp(1, HYPOTHESES_MAX);
        let mut hypotheses = Vec::with_capacity(reported);
        let mut best: Vec<Smoothed> = Vec::new();
        let mut walk_of_best: Vec<Smoothed> = Vec::new();
        let mut plan_sigma_m = None;
        for mode in 0..reported.min(self.modes.modes.len()) {
            let count = if mode == 0 { TRAJECTORIES } else { TRAJECTORIES / 4 };
            let smoothed = smooth::smooth(&self, mode, count);
            let moments = smooth::at_moments(&self, &smoothed.walk);
            hypotheses.push(self.hypothesis(mode, &moments));
            if mode == 0 {
                (best, walk_of_best) = (moments, smoothed.walk);
                plan_sigma_m = smoothed.calibration.map(|c| c.plan_sigma_m);
            }
        }
        let quality = Quality { plan_sigma_m, ..self.quality(&walk_of_best, &best) };
        let contradicted = contradicted::find(&self, &walk_of_best, &best);
        let track = self.track(&best);
        let (log_scale, relative_sigma) = self.cloud.scale();
        let scale = ScaleEstimate { metres_per_unit: libm::exp(log_scale), relative_sigma };
        Ok(Localization { filter: self.estimates, track, hypotheses, status: self.status, scale, quality, contradicted, apart: Vec::new() })
    }

    fn hypothesis(&self, index: usize, moments: &[Smoothed]) -> Hypothesis {
        let mode = &self.modes.modes[index];
        let track = self.moments.iter().zip(moments).map(|(m, s)| (m.stamp, self.to_plan(&s.mean))).collect();
        let probability = mode.mass.clamp(0.0, 1.0);
        let Some(end) = moments.last() else {
            let scale = ScaleEstimate { metres_per_unit: libm::exp(mode.log_scale), relative_sigma: mode.log_scale_sigma };
            let (pose, covariance, radius95_m) = (self.to_plan(&mode.mean), mode.covariance, mode.radius95_m);
            return Hypothesis { probability, pose, covariance, radius95_m, scale, track };
        };
        // The smoothed walk's end, so that a hypothesis and the track say the same of it.
        Hypothesis {
            probability,
            pose: self.to_plan(&end.mean),
            covariance: end.covariance,
            radius95_m: end.radius95_m,
            scale: ScaleEstimate { metres_per_unit: libm::exp(end.log_scale), relative_sigma: end.log_scale_variance.max(0.0).sqrt() },
            track,
        }
    }

    /// The best hypothesis as estimates; its probability and the verdict are those of the end.
    fn track(&self, moments: &[Smoothed]) -> Vec<Estimate> {
        let probability = self.modes.modes.first().map_or(0.0, |m| m.mass.clamp(0.0, 1.0));
        let relative_sigma = self.modes.modes.first().map_or(self.options.scale.relative_sigma, |m| m.log_scale_sigma);
        let estimate = |(moment, smoothed): (&crate::filter::Moment, &Smoothed)| Estimate {
            stamp: moment.stamp,
            pose: self.to_plan(&smoothed.mean),
            covariance: smoothed.covariance,
            radius95_m: smoothed.radius95_m,
            probability,
            status: self.status,
            scale: Some(ScaleEstimate { metres_per_unit: libm::exp(smoothed.log_scale), relative_sigma }),
        };
        self.moments.iter().zip(moments).map(estimate).collect()
    }

    fn quality(&self, walk: &[Smoothed], moments: &[Smoothed]) -> Quality {
        let mut sum = Explained::default();
        let (mut seen, mut nats) = (0, 0.0);
        for (generation, smoothed) in self.history.generations.iter().zip(walk) {
            let rays = generation.rays.len();
            let view = self.scorer.on(&self.walls, &generation.rays);
            let [x, y, heading] = [smoothed.mean.x, smoothed.mean.y, smoothed.mean.z].map(|v| v as f32);
            let explained = view.explain(x, y, heading, smoothed.log_scale as f32);
            // Runs differ in how many rays they could afford; the score takes as many for each.
            nats += if rays > 0 { explained.gain_nats * self.options.sightings.rays as f64 } else { 0.0 };
            sum.on_wall += explained.on_wall * rays as f64;
            sum.through += explained.through * rays as f64;
            seen += rays;
        }
        let entries = |pair: &[Smoothed]| {
            let [x0, y0, x1, y1] = [pair[0].mean.x, pair[0].mean.y, pair[1].mean.x, pair[1].mean.y].map(|v| v as f32);
            self.walls.crossings(x0, y0, x1, y1) as usize
        };
        let share = |of: f64| if seen > 0 { of / seen as f64 } else { 0.0 };
        let wall_crossings: usize = moments.windows(2).map(entries).sum();
        let crossed_nats = wall_crossings as f64 * libm::log(self.options.leak.clamp(1e-9, 1.0));
        Quality {
            seen_explained: share(sum.on_wall),
            seen_through_walls: share(sum.through),
            seen,
            gain_nats: self.evidence.gain_nats,
            wall_crossings,
            score_nats: self.options.sightings.temper * nats + crossed_nats,
            attempts: 1,
            attempt: 0,
            plan_sigma_m: None,
            steps: self.moments.len().saturating_sub(1),
            updates: self.history.generations.len().saturating_sub(1),
            particles_max: self.particles_most,
            particles_end: self.cloud.len(),
        }
    }
}
