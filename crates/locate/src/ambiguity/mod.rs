//! How far must one walk on this plan to know where one is, and where would the plan fool anyone?
//!
//! walks from places all over the floor ──▶ what a camera would see of the walls every metre ──▶ all poses of the plan from which the
//! same walk shows the same, as well as the localiser's noise can tell ──▶ metres until none is left elsewhere ──▶ figures, map, pairs
//!
//! No filter is run: the question is what the plan allows, not what an algorithm achieves. Each walk is compared with every pose of a
//! grid (`profiles`) at several scales, because a single camera does not know its unit; poses that still fit are walked along and
//! compared again. A pose that ends up where the walk truly is is no rival, wherever it began.
//! Pitfall: furniture is not on the plan. What tells rooms apart for a person may not be drawn; what is drawn may be hidden.

mod profiles;
mod stroll;

use planwalk_types::{FloorPlan, PlanPose, Seed, wrap_angle};
use rayon::prelude::*;

use crate::walls::{GroundCosts, Walls};
use profiles::{DIRECTIONS, Profiles, View};

/// Options of [`ambiguity`].
#[derive(Debug, Clone, PartialEq)]
pub struct AmbiguityOptions {
    /// Places from which walks begin, evenly over the floor; two walks from each.
    pub places: usize,
    /// How far each walk goes, metres.
    pub length_m: f64,
    /// How far the unit of length may be off, a share: 0.3 tries ×0.7 to ×1.3.
    pub scale_spread: f64,
    /// Standard deviation of a seen distance, metres, at no distance.
    pub range_sigma_m: f64,
    /// What is added to it, as a share of the distance.
    pub range_sigma_share: f64,
    /// How far the camera sees walls, metres.
    pub reach_m: f64,
}

impl Default for AmbiguityOptions {
    /// 140 places, 32 m, the noise of the localiser's sightings.
    fn default() -> Self {
        Self { places: 140, length_m: 32.0, scale_spread: 0.3, range_sigma_m: 0.12, range_sigma_share: 0.04, reach_m: 12.0 }
    }
}

/// One walk, and how long it stayed alike others.
#[derive(Debug, Clone, PartialEq)]
pub struct TriedWalk {
    /// Where it began.
    pub start: PlanPose,
    /// Metres walked until no other place shows the same; `None` when the walk ended before.
    pub known_after_m: Option<f64>,
    /// Share of the plan's poses elsewhere that still fit, at each of [`Ambiguity::lengths_m`].
    pub alike: Vec<f64>,
    /// The start of the walk elsewhere that stayed alike longest; `None` where there was none from the first look on.
    pub rival: Option<PlanPose>,
    /// Whether the true place was among those that fit to the end: what the comparison's own roundings cost.
    pub kept_itself: bool,
}

/// Two poses from which a walk looks the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConfusablePair {
    /// One start.
    pub a: PlanPose,
    /// The other.
    pub b: PlanPose,
    /// Metres walked from both before they differ.
    pub alike_m: f64,
    /// Whether they still looked the same when the walk ended.
    pub to_the_end: bool,
}

/// How ambiguous a plan is.
#[derive(Debug, Clone, PartialEq)]
pub struct Ambiguity {
    /// Where shares are counted, metres: 0, 1, 2, 4, 8, …
    pub lengths_m: Vec<f64>,
    /// All walks, two from each place.
    pub walks: Vec<TriedWalk>,
    /// Metres after which half of the walks know their place; `None` when fewer ever do.
    pub median_m: Option<f64>,
    /// The same for nine of ten.
    pub p90_m: Option<f64>,
    /// Share of the walks that do not know their place at their end, 0..=1.
    pub never: f64,
    /// Poses that are confused longest, worst first.
    pub pairs: Vec<ConfusablePair>,
    /// Distance between the places from which walks began, metres.
    pub spacing_m: f64,
    /// Distance between the poses that were compared, metres.
    pub pitch_m: f64,
}

/// A pose is elsewhere when it is farther than this from the true one (what the verdict still calls one place), …
const ELSEWHERE_M: f64 = 3.0;
/// … or turned by more than this, radians.
const ELSEWHERE_RAD: f64 = 0.35;
/// Metres between two looks.
const LOOK_M: f64 = 1.0;
/// Scales tried.
const SCALES: usize = 5;
/// How far a pose may be pulled to a better neighbour, as a share of the way since the last look: drift, and what the grid rounds.
const PULL: f64 = 0.06;
/// Rays that may disagree over a whole walk: at the start, and for each look. A door's edge is met now and then; who disagrees all the
/// time is elsewhere.
const MISSED: (f64, f64) = (3.0, 0.7);
/// Pairs that are reported.
const PAIRS: usize = 10;
/// Pairs are of different places: farther apart than this, metres.
const PAIRS_APART_M: f64 = 4.0;
/// Walks compared between two reports of progress.
const BATCH: usize = 8;

/// How ambiguous the plan is, by trying. The seed chooses directions of walks; `progress` is told the share done.
///
/// The same seed gives the same bytes on any number of threads. A plan without floor inside of it has no walks.
pub fn ambiguity(plan: &FloorPlan, options: &AmbiguityOptions, seed: Seed, progress: &mut dyn FnMut(f64)) -> Ambiguity {
    let walls = Walls::new(plan, GroundCosts::default());
    let profiles = Profiles::new(plan, &walls, options);
    let (starts, spacing_m) = starts(plan, &walls, options, seed);
    let lengths_m = lengths(options.length_m);
    let mut walks = Vec::with_capacity(starts.len());
    for (batch, group) in starts.chunks(BATCH).enumerate() {
        let tried = group.par_iter().enumerate().map(|(i, start)| {
            let mut rng = seed.derive("stroll", (batch * BATCH + i) as u64);
            let way = stroll::walk(&walls, *start, options.length_m, LOOK_M, &mut rng);
            Compared::new(&profiles, &walls, &way, options).tried(&lengths_m, plan)
        });
        walks.extend(tried.collect::<Vec<TriedWalk>>());
        progress((walks.len() as f64 / starts.len() as f64).min(1.0));
    }
    let mut known: Vec<f64> = walks.iter().map(|walk| walk.known_after_m.unwrap_or(f64::INFINITY)).collect();
    known.sort_by(f64::total_cmp);
    let at = |share: f64| known.get(((known.len() as f64 * share).ceil() as usize).saturating_sub(1)).copied().filter(|m| m.is_finite());
    let never = known.iter().filter(|m| m.is_infinite()).count() as f64 / known.len().max(1) as f64;
    let pairs = pairs(&walks, options.length_m);
    Ambiguity { lengths_m, median_m: at(0.5), p90_m: at(0.9), never, pairs, walks, spacing_m, pitch_m: profiles.pitch_m() }
}

/// 0, 1, 2, 4, … up to the whole length.
fn lengths(length_m: f64) -> Vec<f64> {
    let doubled = (0..16).map(|i| f64::from(1 << i)).take_while(|m| *m < length_m);
    std::iter::once(0.0).chain(doubled).chain((length_m > 0.0).then_some(length_m)).collect()
}

/// Poses from which to walk: a lattice over the floor inside, two headings at each place, in plan metres from the grid's corner.
fn starts(plan: &FloorPlan, walls: &Walls, options: &AmbiguityOptions, seed: Seed) -> (Vec<stroll::Pose>, f64) {
    use rand::RngExt;
    let (width, height) = plan.size_m();
    let spacing_m = (plan.inside_area_m2() / options.places.max(1) as f64).sqrt().max(0.3);
    let mut rng = seed.derive("ambiguity starts", 0);
    let mut poses = Vec::new();
    let count = |size: f64| (size / spacing_m).ceil() as usize;
    for row in 0..count(height) {
        for column in 0..count(width) {
            let middle = ((column as f64 + 0.5) * spacing_m, (row as f64 + 0.5) * spacing_m);
            // The heading is drawn for every lattice cell, so that a wall moved elsewhere changes nothing here.
            let heading = rng.random_range(0.0..std::f64::consts::TAU);
            if let Some((x, y)) = standing_place(plan, walls, middle, spacing_m) {
                poses.push(stroll::Pose { x, y, heading });
                poses.push(stroll::Pose { x, y, heading: wrap_angle(heading + std::f64::consts::PI) });
            }
        }
    }
    (poses, spacing_m)
}

/// The place nearest to the middle of a lattice cell where a person can stand inside.
fn standing_place(plan: &FloorPlan, walls: &Walls, (x, y): (f64, f64), spacing_m: f64) -> Option<(f64, f64)> {
    let cell_m = plan.cell_m();
    let mut best: Option<(f64, f64, f64)> = None;
    let reach = 0.5 * spacing_m;
    let steps = (2.0 * reach / 0.2).ceil().max(1.0) as i64;
    for i in 0..=steps {
        for j in 0..=steps {
            let (dx, dy) = (reach * (2.0 * i as f64 / steps as f64 - 1.0), reach * (2.0 * j as f64 / steps as f64 - 1.0));
            let (column, row) = ((x + dx) / cell_m, (y + dy) / cell_m);
            if !(column >= 0.0 && row >= 0.0 && column < plan.width() as f64 && row < plan.height() as f64) {
                continue;
            }
            let index = row as usize * plan.width() + column as usize;
            let far = dx.hypot(dy);
            let open = plan.inside()[index] > 0.5 && stroll::stands(walls, x + dx, y + dy);
            if open && best.is_none_or(|(least, ..)| far < least) {
                best = Some((far, x + dx, y + dy));
            }
        }
    }
    best.map(|(_, x, y)| (x, y))
}

/// A pose that still fits: where it began, where it is now, and at which scale.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    x: f32,
    y: f32,
    heading: f32,
    scale: f32,
    start: [f32; 3],
    matched: u8,
    /// Rays that did not agree so far.
    missed: u16,
}

/// A walk compared with all poses of the plan.
struct Compared<'a> {
    profiles: &'a Profiles,
    way: &'a [stroll::Pose],
    views: Vec<View>,
    left: Vec<Candidate>,
}

impl<'a> Compared<'a> {
    fn new(profiles: &'a Profiles, walls: &Walls, way: &'a [stroll::Pose], options: &AmbiguityOptions) -> Self {
        let views = way.iter().map(|pose| View::from(walls, pose.x, pose.y, pose.heading, options.reach_m)).collect();
        Self { profiles, way, views, left: Vec::new() }
    }

    /// Walks on until the end or until nothing fits.
    fn tried(mut self, lengths_m: &[f64], plan: &FloorPlan) -> TriedWalk {
        let poses = (self.profiles.places() * DIRECTIONS) as f64;
        let mut elsewhere = Vec::with_capacity(self.way.len());
        let mut rival = None;
        self.first_look();
        for look in 0..self.way.len() {
            if look > 0 {
                self.walk_on(look);
            }
            let truth = self.way[look];
            // Who began at the walk's own start and is elsewhere now only has the wrong scale.
            let began = self.way[0];
            let others = || self.left.iter().filter(|c| is_elsewhere([c.x, c.y, c.heading], &truth) && is_elsewhere(c.start, &began));
            let counted = lengths_m.iter().any(|m| (m / LOOK_M).round() as usize == look) || look + 1 == self.way.len();
            // Only what is told is counted in full.
            elsewhere.push(if counted { distinct(others(), self.profiles.pitch_m()) } else { others().take(1).count() });
            // Of those that last longest the one that fits best; the first of equals.
            let best =
                others().fold(None, |best: Option<&Candidate>, c| if best.is_none_or(|b| c.matched > b.matched) { Some(c) } else { best });
            rival = best.map(|c| c.start).or(rival);
        }
        let known = elsewhere.iter().rposition(|n| *n > 0).map_or(0, |last| last + 1);
        let end = self.way[self.way.len() - 1];
        let alike = |m: &f64| elsewhere.get((m / LOOK_M).round() as usize).or(elsewhere.last()).map_or(0.0, |n| *n as f64 / poses);
        TriedWalk {
            start: self.way[0].on(plan),
            known_after_m: (known < self.way.len()).then_some(known as f64 * LOOK_M),
            alike: lengths_m.iter().map(alike).collect(),
            rival: rival.map(|[x, y, heading]| stroll::Pose { x: x.into(), y: y.into(), heading: heading.into() }.on(plan)),
            kept_itself: self.left.iter().any(|c| !is_elsewhere([c.x, c.y, c.heading], &end)),
        }
    }

    /// All poses and scales that show what is seen at the start.
    fn first_look(&mut self) {
        let heading = self.way[0].heading;
        for scale in self.profiles.scales() {
            let bounds = self.profiles.bounds(&self.views[0], scale);
            for turn in 0..DIRECTIONS {
                let facing = heading + turn as f64 * std::f64::consts::TAU / DIRECTIONS as f64;
                self.profiles.all_that_show(&bounds, facing, &mut |x, y, matched| {
                    let start = [x, y, wrap_angle(facing) as f32];
                    self.left.push(Candidate {
                        x,
                        y,
                        heading: facing as f32,
                        scale: scale as f32,
                        start,
                        matched,
                        missed: profiles::missed(matched),
                    });
                });
            }
        }
    }

    /// Moves all poses as the walker moved, and keeps those that show what he sees then.
    fn walk_on(&mut self, look: usize) {
        let (from, to) = (self.way[look - 1], self.way[look]);
        let (sin, cos) = libm::sincos(from.heading);
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let (ahead, left, turn) =
            ((cos * dx + sin * dy) as f32, (cos * dy - sin * dx) as f32, wrap_angle(to.heading - from.heading) as f32);
        let bounds: Vec<_> = self.profiles.scales().map(|scale| (scale as f32, self.profiles.bounds(&self.views[look], scale))).collect();
        let pull = PULL as f32 * ahead.hypot(left).max(0.2);
        let profiles = self.profiles;
        self.left.retain_mut(|c| {
            let (s, k) = libm::sincosf(c.heading);
            c.x += c.scale * (k * ahead - s * left);
            c.y += c.scale * (s * ahead + k * left);
            c.heading += turn;
            let Some((_, bounds)) = bounds.iter().find(|(scale, _)| *scale == c.scale) else { return false };
            let Some((x, y, matched)) = profiles.best_near(bounds, c.x, c.y, c.heading) else { return false };
            if let Some((x, y)) = (x != c.x || y != c.y).then_some((x - c.x, y - c.y)) {
                let by = (pull / x.hypot(y).max(1e-6)).min(1.0);
                c.x += by * x;
                c.y += by * y;
            }
            c.matched = matched;
            c.missed += profiles::missed(matched);
            f64::from(c.missed) <= MISSED.0 + MISSED.1 * look as f64
        });
    }
}

fn is_elsewhere([x, y, heading]: [f32; 3], truth: &stroll::Pose) -> bool {
    let (dx, dy) = (f64::from(x) - truth.x, f64::from(y) - truth.y);
    dx * dx + dy * dy > ELSEWHERE_M * ELSEWHERE_M || wrap_angle(f64::from(heading) - truth.heading).abs() > ELSEWHERE_RAD
}

/// How many different poses of the grid these are, whatever their scales.
fn distinct<'a>(candidates: impl Iterator<Item = &'a Candidate>, pitch_m: f64) -> usize {
    let sector = |heading: f32| (wrap_angle(heading.into()) / std::f64::consts::TAU * DIRECTIONS as f64).round() as i32;
    let cell = |v: f32| (f64::from(v) / pitch_m).round() as i32;
    let mut keys: Vec<_> = candidates.map(|c| (cell(c.x), cell(c.y), sector(c.heading))).collect();
    keys.sort_unstable();
    keys.dedup();
    keys.len()
}

/// The pairs that stay alike longest, each of other places than those before.
fn pairs(walks: &[TriedWalk], length_m: f64) -> Vec<ConfusablePair> {
    let pair = |walk: &TriedWalk| {
        let alike_m = walk.known_after_m.map_or(length_m, |m| (m - LOOK_M).max(0.0));
        walk.rival.map(|b| ConfusablePair { a: walk.start, b, alike_m, to_the_end: walk.known_after_m.is_none() })
    };
    let mut all: Vec<ConfusablePair> = walks.iter().filter_map(pair).collect();
    all.sort_by(|a, b| b.alike_m.total_cmp(&a.alike_m));
    let mut chosen: Vec<ConfusablePair> = Vec::new();
    for pair in all {
        let near = |p: &ConfusablePair| {
            [p.a, p.b]
                .iter()
                .any(|q| q.origin().distance(pair.a.origin()) < PAIRS_APART_M || q.origin().distance(pair.b.origin()) < PAIRS_APART_M)
        };
        if chosen.len() < PAIRS && !chosen.iter().any(near) {
            chosen.push(pair);
        }
    }
    chosen
}

#[cfg(test)]
mod tests;
