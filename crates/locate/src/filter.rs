//! Where on the floor plan is the walker? A particle filter over plan poses, scale and heading drift, one step at a time.
//!
//! Step + sightings ──gather until the body has moved──▶ predict ──▶ weigh by walls and sightings ──▶ modes, verdict ──▶ resample
//!
//! Frames: poses are `Plan ← Body`. Source: Thrun, Burgard & Fox 2005, ch. 8; scale as a state with a log-normal prior.
//! Pitfall: scale must not collapse. Small walks cross no walls; so scale has an anchor (its prior, to which resampling
//! draws it back) and a score (sightings are densities in the odometry's own unit, see [`crate::likelihood`]).

use nalgebra::{Matrix3, Vector3};
use planwalk_types::{Estimate, FloorPlan, PlanPose, Pt2, ScaleEstimate, Seed, Sighting, Stamp, Status, Step, wrap_angle};

use crate::LocateError;
use crate::drift::SteadyTurn;
use crate::history::{History, NO_PARENT};
use crate::likelihood::{Pending, Scorer, View};
use crate::look::{Due, Leaf, Looks, SCALE_STEP, Watch, Window, way_of};
use crate::modes::{Bins, Modes};
use crate::motion::Motion;
use crate::options::LocateOptions;
use crate::particles::{Particles, Roughening};
use crate::predict::predict_and_weigh;
use crate::prior::{self, ScalePrior};
use crate::verdict::{Evidence, verdict};
use crate::walls::Walls;

/// Variance of the logarithm of the odometry's unit over which the cloud must spread its scales at once: 5 %.
const UNIT_CHANGED: f64 = 0.05 * 0.05;
/// Particles that say what the best mode makes of what is seen: their mean is good to a few hundredths of a nat.
const GAIN_FROM: usize = 512;
/// Width of a bin of the logarithm of scale.
const SCALE_BIN: f64 = 0.1;
/// A cloud above this size waits twice as long between updates.
const LARGE: usize = 200_000;

/// Where a moment of the path lies between updates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    pub stamp: Stamp,
    /// The last update before it.
    pub generation: usize,
    /// Motion since.
    pub since: Motion,
}

/// The cloud as observers see it: one slice an attribute.
#[derive(Debug, Clone, Copy)]
pub struct FilterView<'a> {
    /// When.
    pub stamp: Stamp,
    /// Plan coordinates of local (0, 0).
    pub origin: Pt2<planwalk_types::Plan>,
    /// Metres right of the origin.
    pub x: &'a [f32],
    /// Metres above the origin.
    pub y: &'a [f32],
    /// Radians, anticlockwise.
    pub heading_rad: &'a [f32],
    /// Natural logarithm of metres per unit of odometry.
    pub log_scale: &'a [f32],
    /// Weights; they sum to one.
    pub weight: &'a [f32],
    /// Separate places with at least 1 % of the mass.
    pub modes: usize,
    /// The verdict.
    pub status: Status,
    /// See [`crate::VerdictOptions::gain_nats`].
    pub gain_nats: f64,
}

/// The filter, fed step by step. It knows nothing of the future.
#[derive(Debug)]
pub struct Localizer<'a> {
    pub(crate) plan: &'a FloorPlan,
    pub(crate) options: LocateOptions,
    pub(crate) walls: Walls,
    pub(crate) scorer: Scorer,
    pub(crate) bins: Bins,
    pub(crate) cloud: Particles,
    /// For each particle its index in the newest generation.
    parents: Vec<u32>,
    roughened: Option<Roughening>,
    window: Motion,
    pending: Pending,
    pub(crate) modes: Modes,
    pub(crate) status: Status,
    pub(crate) evidence: Evidence,
    pub(crate) history: History,
    pub(crate) moments: Vec<Moment>,
    pub(crate) estimates: Vec<Estimate>,
    updates: u64,
    pub(crate) particles_most: usize,
    /// Metres walked since the last resampling, over which scale drifted.
    since_resampling_m: f64,
    /// Variance of the changes of the odometry's unit since then.
    unit_variance: f64,
    /// The plan prepared for looks, and those made so far.
    pub(crate) looks: Looks,
    /// What the last update makes look over the whole plan, and the chance of it.
    due: Option<(Due, Seed)>,
    /// Mean and standard deviation of the log scale when the place was believed last.
    known_scale: Option<(f64, f64)>,
    /// Way since something was seen, the odometry's unit.
    unseen: f64,
    /// Way since the oldest generation that is kept, metres at the prior's scale.
    remembered_m: f64,
    steady_turn: SteadyTurn,
    near_past: Window,
    watch: Watch,
}

impl<'a> Localizer<'a> {
    /// The filter before the first step.
    ///
    /// # Errors
    /// [`LocateError`] when the start or the scale make no sense on this plan.
    pub fn new(plan: &'a FloorPlan, options: &LocateOptions) -> Result<Self, LocateError> {
        options.check(plan)?;
        let options = options.clone();
        let walls = Walls::new(plan, options.ground);
        let scorer = Scorer::new(&options.sightings, &walls);
        let bins = Bins::new(plan.size_m());
        let (least, most) = (options.particles_min.max(1), options.particles_max.max(options.particles_min).max(1));
        let by_area = |area_m2: f64| ((area_m2 * options.particles_per_m2) as usize).clamp(least, most);
        let poses = match &options.start {
            Some(start) => {
                // Three sigmas of ground; every heading is looked at only where it is unknown.
                let ground_m2 = 9.0 * std::f64::consts::PI * start.sigma_m * start.sigma_m;
                let headings = if start.heading_rad.is_some() { start.sigma_rad.min(1.0) } else { 1.0 };
                prior::around(start, plan, &walls, by_area(4.0 * ground_m2 * headings).max(2 * least).min(most), options.seed)
            }
            None => {
                let most = if options.relocalise { most.min(options.particles_seeing) } else { most };
                prior::cover(plan, by_area(prior::weighted_area_m2(plan)).max(50_000).min(most), options.seed)
            }
        };
        let mut cloud = prior::particles(&poses, &options.scale, options.seed);
        let steady_turn = SteadyTurn::new(&options.heading_drift);
        cloud.drift = steady_turn.draw(cloud.len(), options.seed);
        let mut history = History::default();
        history.push(&cloud, vec![NO_PARENT; cloud.len()], Motion::none(), None, Vec::new());
        let start_known = options.start.is_some();
        let modes = bins.modes(&cloud);
        let status = verdict(&modes, &Evidence::default(), start_known, &options.verdict);
        Ok(Self {
            parents: (0..cloud.len() as u32).collect(),
            particles_most: cloud.len(),
            plan,
            options,
            walls,
            scorer,
            bins,
            cloud,
            roughened: None,
            window: Motion::none(),
            pending: Pending::default(),
            modes,
            status,
            evidence: Evidence::default(),
            history,
            moments: Vec::new(),
            estimates: Vec::new(),
            updates: 0,
            since_resampling_m: 0.0,
            unit_variance: 0.0,
            looks: Looks::default(),
            due: None,
            known_scale: None,
            unseen: 0.0,
            remembered_m: 0.0,
            steady_turn,
            near_past: Window::default(),
            watch: Watch::default(),
        })
    }

    /// Takes one step and what was seen during it (the first step's sightings include those of its start).
    ///
    /// A step that is not finite is taken as standing still.
    pub fn push(&mut self, step: &Step, sightings: &[Sighting]) -> Estimate {
        self.advance(step, sightings);
        let mut looks = std::mem::take(&mut self.looks);
        self.look_if_due(&mut looks);
        self.looks = looks;
        self.arrive(step.to)
    }

    /// The first part of [`Localizer::push`]: all but the look over the whole plan, which several filters may share.
    pub(crate) fn advance(&mut self, step: &Step, sightings: &[Sighting]) {
        if self.moments.is_empty() {
            self.moments.push(Moment { stamp: step.from, generation: 0, since: Motion::none() });
            let first = self.estimate(step.from);
            self.estimates.push(first);
        }
        let finite = [step.forward, step.left, step.turn_rad].iter().all(|v| v.is_finite());
        let step = if finite { *step } else { Step { forward: 0.0, left: 0.0, turn_rad: 0.0, ..*step } };
        for sighting in sightings {
            self.pending.add(sighting, &self.window, &step);
        }
        self.window = self.window.then(&Motion::of(&step, 1.0));
        self.steady_turn.add(&step, self.options.scale.metres_per_unit);
        // A cloud that covers a floor is too coarse to feel a quarter of a metre.
        let patience = if self.cloud.len() > LARGE { 2.0 } else { 1.0 };
        let far = self.window.length * self.options.scale.metres_per_unit >= patience * self.options.update_distance_m;
        if far || self.window.turned_rad >= patience * self.options.update_turn_rad {
            self.update();
        }
    }

    /// The second: looks over the whole plan if the update asks for it. The plan of `looks` must be this one.
    pub(crate) fn look_if_due(&mut self, looks: &mut Looks) {
        if let Some((due, seed)) = self.due.take() {
            self.look_around(due, seed, looks);
        }
    }

    /// The last: what is known at this moment.
    pub(crate) fn arrive(&mut self, stamp: Stamp) -> Estimate {
        self.moments.push(Moment { stamp, generation: self.history.generations.len() - 1, since: self.window });
        let estimate = self.estimate(stamp);
        self.estimates.push(estimate.clone());
        estimate
    }

    /// How often the cloud was updated so far.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// The cloud as it is now, for drawing.
    pub fn view(&self) -> FilterView<'_> {
        FilterView {
            stamp: self.moments.last().map_or(Stamp(0), |m| m.stamp),
            origin: self.plan.origin(),
            x: &self.cloud.x,
            y: &self.cloud.y,
            heading_rad: &self.cloud.heading,
            log_scale: &self.cloud.log_scale,
            weight: &self.cloud.weight,
            modes: self.modes.modes.iter().filter(|m| m.mass >= 0.01).count(),
            status: self.status,
            gain_nats: self.evidence.gain_nats,
        }
    }

    /// Takes in what is left since the last update.
    pub(crate) fn advance_rest(&mut self) {
        if self.window != Motion::none() || !self.pending.is_empty() {
            self.update();
        }
    }

    /// After [`Localizer::advance_rest`]: the last moment's estimate then knows that too.
    pub(crate) fn arrive_at_end(&mut self) {
        let generation = self.history.generations.len() - 1;
        let Some(moment) = self.moments.last_mut() else { return };
        *moment = Moment { stamp: moment.stamp, generation, since: Motion::none() };
        let stamp = moment.stamp;
        let estimate = self.estimate(stamp);
        if let Some(last) = self.estimates.last_mut() {
            *last = estimate;
        }
    }

    /// One update: predict, weigh by walls and sightings, judge, and resample when few particles carry the weight.
    fn update(&mut self) {
        let motion = std::mem::replace(&mut self.window, Motion::none());
        let rays = self.pending.take(self.rays_affordable(), &motion);
        let seed = self.options.seed.child("update", self.updates);
        self.unseen += motion.length;
        let believed_scale = libm::exp(self.modes.modes.first().map_or(self.options.scale.log_mean(), |m| m.log_scale));
        let moved_m = motion.length * believed_scale;
        {
            let view = self.scorer.on(&self.walls, &rays);
            let survival = predict_and_weigh(&mut self.cloud, &motion, &self.walls, &view, &self.options, seed);
            survival.make_fair(&mut self.cloud, self.modes.filled_bins);
        }
        self.cloud.normalize();
        self.modes = self.bins.modes(&self.cloud);
        let view = self.scorer.on(&self.walls, &rays);
        let gain = if view.is_empty() { 0.0 } else { self.gain(&view) };
        if !view.is_empty() {
            self.evidence.add(gain, self.unseen * believed_scale, &self.options.verdict);
        }
        let way_here = if motion.is_jump() { self.begin_anew() } else { motion.without_drift(self.believed_drift()) };
        self.near_past.push(way_here, &rays, self.options.scale.metres_per_unit);
        // At the prior's scale: runs with other draws then look at the same moments.
        let way_m = self.unseen * self.options.scale.metres_per_unit;
        let due = if self.looks_about() && !rays.is_empty() { self.watch.add(gain, way_m, &self.options.look) } else { None };
        if !rays.is_empty() {
            self.unseen = 0.0;
        }
        self.status = self.judge();
        if self.status == Status::Tracking {
            self.known_scale = Some(self.cloud.scale());
        }
        let parents = std::mem::take(&mut self.parents);
        self.history.push(&self.cloud, parents, motion, self.roughened.take(), rays);
        self.parents = (0..self.cloud.len() as u32).collect();
        self.since_resampling_m += moved_m;
        self.unit_variance += motion.unit_variance;
        let few = self.cloud.effective_share() < self.options.resample_below;
        // What a look finds joins a cloud whose weights are even.
        if few || self.unit_variance > UNIT_CHANGED || due.is_some() {
            self.resample(seed);
        }
        self.due = due.map(|due| (due, seed));
        self.updates += 1;
        self.forget(&motion);
    }

    /// After a jump the walker may be anywhere: the plan is looked over again, by what is seen from here on.
    fn begin_anew(&mut self) -> Motion {
        (self.near_past, self.watch) = (Window::default(), Watch::default());
        Motion::none()
    }

    /// Forgets what lies too far back, a quarter of what is remembered at a time.
    fn forget(&mut self, newest: &Motion) {
        let Some(remember_m) = self.options.remember_m else { return };
        let (mut way_m, metres_per_unit) = (0.0, self.options.scale.metres_per_unit);
        self.remembered_m += way_of(newest, metres_per_unit);
        if self.remembered_m < 1.25 * remember_m {
            return;
        }
        let recent = self.history.generations.iter().rev().take_while(|generation| {
            way_m += way_of(&generation.motion, metres_per_unit);
            way_m <= remember_m
        });
        let forgotten = self.history.generations.len() - recent.count().max(1);
        self.history.forget(forgotten);
        let gone = self.moments.partition_point(|moment| moment.generation < forgotten);
        self.moments.drain(..gone);
        self.estimates.drain(..gone);
        self.moments.iter_mut().for_each(|moment| moment.generation -= forgotten);
        self.remembered_m = remember_m;
    }

    /// The verdict on the cloud. Whoever has not looked everywhere yet cannot know that no other place is as good; nor is a place
    /// believed that does not explain what is being seen.
    fn judge(&self) -> Status {
        let status = verdict(&self.modes, &self.evidence, self.options.start.is_some(), &self.options.verdict);
        if status == Status::Tracking && self.looks_about() && (!self.watch.has_looked() || self.watch.in_doubt()) {
            Status::Ambiguous
        } else {
            status
        }
    }

    fn looks_about(&self) -> bool {
        self.options.relocalise && self.options.start.is_none()
    }

    /// Looks over the whole plan for places that explain the last metres, and gives them a share of the cloud.
    fn look_around(&mut self, due: Due, seed: Seed, looks: &mut Looks) {
        let (look_options, metres_per_unit) = (self.options.look, self.options.scale.metres_per_unit);
        let way_m = self.watch.way_m(&look_options);
        let Some(scene) = self.near_past.scene(way_m, metres_per_unit, look_options.rays) else { return };
        let options = self.options_of_look(due);
        let Some(looked) = looks.look((self.plan, &self.walls, &self.scorer), scene, &options) else {
            return self.watch.unclear();
        };
        self.watch.told();
        let (elsewhere, mass) = looked.without(|leaf| due != Due::First && self.is_believed(leaf));
        // The place that is believed has more to speak for it than the last metres.
        let (most, count) = match due {
            Due::First | Due::Doubt => (0.9, look_options.particles),
            Due::Check => (0.1, look_options.particles / 5),
        };
        let share = mass.min(most);
        if elsewhere.leaves.is_empty() || share < 0.01 {
            return;
        }
        let mut found = elsewhere.draw(count, seed);
        // How much the odometry drifts has nothing to do with where one is.
        let (known, drawn) = (self.cloud.len(), found.len());
        found.drift.iter_mut().enumerate().for_each(|(i, drift)| *drift = self.cloud.drift[i * known / drawn]);
        self.cloud.join(&found, share);
        self.parents.resize(self.cloud.len(), NO_PARENT);
        self.particles_most = self.particles_most.max(self.cloud.len());
        if due == Due::Doubt && share > 0.5 {
            self.evidence = Evidence::default();
        }
    }

    /// By how much the odometry turns by itself where the walker is believed to be, radians a unit of way; 0 where nothing is. In
    /// steps, as scales are.
    fn believed_drift(&self) -> f64 {
        const STEP_RAD: f64 = 0.008;
        let believed = self.modes.modes.first().filter(|mode| mode.mass >= 0.5);
        believed.map_or(0.0, |mode| STEP_RAD * (mode.drift_rad_per_m / STEP_RAD).round() * self.options.scale.metres_per_unit)
    }

    /// Only to make sure, scales are tried near the one that is believed, and only rivals as good count. In doubt too they are tried
    /// there at first: whoever was carried elsewhere keeps the unit. Else all are.
    fn options_of_look(&self, due: Due) -> LocateOptions {
        let mut options = self.options.clone();
        let known = match due {
            Due::First => None,
            Due::Doubt => self.known_scale.filter(|_| !self.watch.in_long_doubt()).map(|(log_scale, sigma)| {
                // As it was before doubt began; it has drifted since.
                (log_scale, sigma.hypot(options.scale_drift_per_sqrt_m * self.watch.doubt_m().sqrt()))
            }),
            Due::Check => Some(self.cloud.scale()),
        };
        if let Some((log_scale, sigma)) = known {
            // In steps, so that runs that agree ask for the same look.
            let log_scale = SCALE_STEP * (log_scale / SCALE_STEP).round();
            let relative_sigma = (0.5 * SCALE_STEP * (sigma / (0.5 * SCALE_STEP)).ceil().max(2.0)).min(options.scale.relative_sigma);
            options.scale = ScalePrior { metres_per_unit: libm::exp(log_scale), relative_sigma };
        }
        if due == Due::Check {
            options.look.keep_nats *= 0.3;
        }
        options
    }

    /// Whether this is where the heaviest mode is.
    fn is_believed(&self, leaf: &Leaf) -> bool {
        self.modes.modes.first().is_some_and(|mode| {
            let (dx, dy) = (f64::from(leaf.x) - mode.mean.x, f64::from(leaf.y) - mode.mean.y);
            dx.hypot(dy) < 1.5 && wrap_angle(f64::from(leaf.heading) - mode.mean.z).abs() < 0.5
        })
    }

    /// A million particles look at fewer things than a thousand: the work of an update stays bounded.
    fn rays_affordable(&self) -> usize {
        let most = self.options.sightings.rays;
        (6_000_000 / self.cloud.len().max(1)).clamp(most.min(8), most)
    }

    /// Nats a sighting by which the best mode beats calling everything furniture.
    fn gain(&self, view: &View<'_>) -> f64 {
        let stride = (self.cloud.len() / GAIN_FROM).max(1);
        let (mut nats, mut weight) = (0.0, 0.0);
        for i in (0..self.cloud.len()).step_by(stride) {
            let (x, y, heading) = (self.cloud.x[i], self.cloud.y[i], self.cloud.heading[i]);
            if self.modes.of(&self.bins, x, y, heading) == Some(0) {
                let w = f64::from(self.cloud.weight[i]);
                nats += w * view.explain(x, y, heading, self.cloud.log_scale[i]).gain_nats;
                weight += w;
            }
        }
        if weight > 0.0 { nats / weight } else { 0.0 }
    }

    fn resample(&mut self, seed: Seed) {
        let wanted = (self.options.particles_per_bin * self.modes.filled_bins * self.scale_bins()) as usize;
        let least = self.options.particles_min.max(1);
        let count = wanted.clamp(least, self.cloud.len().max(least));
        self.parents = self.cloud.resample_systematic(count, seed);
        let mut by = roughening(count, self.modes.filled_bins);
        let drift = self.options.scale_drift_per_sqrt_m.max(0.0) * self.since_resampling_m.max(0.0).sqrt();
        let drift = drift.hypot(self.unit_variance.max(0.0).sqrt());
        self.unit_variance = 0.0;
        by.log_scale = f64::from(by.log_scale).hypot(drift) as f32;
        self.since_resampling_m = 0.0;
        self.cloud.roughen(&by, &self.options.scale, seed);
        self.steady_turn.roughen(&mut self.cloud.drift, seed);
        self.roughened = Some(by);
    }

    /// Over how many bins of scale a place spreads. One where looks bring back what was thinned out; where none will, scale is a
    /// dimension like the others: along a straight corridor any scale fits, and which is right shows at its end.
    fn scale_bins(&self) -> f64 {
        if self.options.relocalise {
            return 1.0;
        }
        let mass: f64 = self.modes.modes.iter().map(|m| m.mass).sum();
        let sigma = self.modes.modes.iter().map(|m| m.mass * m.log_scale_sigma).sum::<f64>() / mass.max(f64::MIN_POSITIVE);
        // What spreads evenly has a standard deviation of its width over √12.
        (sigma * 12f64.sqrt() / SCALE_BIN).max(1.0)
    }

    /// What is known now.
    fn estimate(&self, stamp: Stamp) -> Estimate {
        let prior = &self.options.scale;
        let nowhere = || (Vector3::zeros(), Matrix3::identity() * 1e6, 1e3, 0.0, prior.log_mean());
        let (mean, covariance, radius95_m, probability, log_scale) =
            self.modes.modes.first().map_or_else(nowhere, |m| (m.mean, m.covariance, m.radius95_m, m.mass, m.log_scale));
        let relative_sigma = self.modes.modes.first().map_or(prior.relative_sigma, |m| m.log_scale_sigma);
        let scale = libm::exp(log_scale);
        let pose = self.window.applied_to(mean, scale);
        let carried = carry(&covariance, &self.window, mean.z, scale);
        let probability = probability.clamp(0.0, 1.0);
        let known = Some(ScaleEstimate { metres_per_unit: scale, relative_sigma });
        Estimate { stamp, pose: self.to_plan(&pose), covariance: carried, radius95_m, probability, status: self.status, scale: known }
    }

    pub(crate) fn to_plan(&self, pose: &Vector3<f64>) -> PlanPose {
        PlanPose::new(pose.x + self.plan.origin().x, pose.y + self.plan.origin().y, pose.z)
    }
}

/// The covariance of a pose after a motion, to first order.
pub(crate) fn carry(covariance: &Matrix3<f64>, motion: &Motion, heading_rad: f64, scale: f64) -> Matrix3<f64> {
    let (s, c) = libm::sincos(heading_rad);
    let (dx, dy) = (scale * (c * motion.forward - s * motion.left), scale * (s * motion.forward + c * motion.left));
    let by_pose = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
    let by_motion = Matrix3::new(scale * c, -scale * s, 0.0, scale * s, scale * c, 0.0, 0.0, 0.0, 1.0);
    by_pose * covariance * by_pose.transpose() + by_motion * motion.covariance * by_motion.transpose()
}

/// How far copies are moved apart: a third of the distance between neighbours in a filled bin, in the four dimensions of
/// the state (a bin is 0.5 m, 0.5 m, 15° and about 10 % of scale).
fn roughening(count: usize, filled_bins: f64) -> Roughening {
    let per_bin = (count as f64 / filled_bins.max(1.0)).max(1.0);
    let apart = 0.3 * libm::pow(per_bin, -0.25);
    Roughening { metres: (0.5 * apart) as f32, heading_rad: (15f64.to_radians() * apart) as f32, log_scale: (0.1 * apart) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::Wall;
    use planwalk_types::path::StepNoise;

    #[test]
    fn way_on_which_nothing_was_seen_counts_when_something_is() {
        let wall = |x0: f64, y0: f64, x1: f64, y1: f64| Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) };
        let walls = [wall(0.0, 0.0, 20.0, 0.0), wall(20.0, 0.0, 20.0, 3.0), wall(20.0, 3.0, 0.0, 3.0), wall(0.0, 3.0, 0.0, 0.0)];
        let plan = FloorPlan::from_walls(&walls, 0.05, 1.0).unwrap();
        let options = LocateOptions::new(Seed(1), ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.0 });
        let mut localizer = Localizer::new(&plan, &options).unwrap();
        for second in 0..12i64 {
            let (from, to) = (Stamp(second * 1_000_000_000), Stamp((second + 1) * 1_000_000_000));
            let step = StepNoise::default().step(from, to, 0.6, 0.0, 0.0);
            let aside = |bearing_rad: f64| Sighting { stamp: to, bearing_rad, range: 1.5, sigma: 0.05 };
            let seen = if second % 3 == 2 { vec![aside(1.57), aside(-1.57)] } else { Vec::new() };
            localizer.push(&step, &seen);
        }
        // Each step is an update of its own; every third sees something.
        assert_eq!(localizer.updates(), 12);
        // Scales are single precision.
        assert!((localizer.evidence.seen_m - 12.0 * 0.6).abs() < 1e-6, "{}", localizer.evidence.seen_m);
    }
}
