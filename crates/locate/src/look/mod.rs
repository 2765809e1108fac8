//! Where on the plan can the last metres have been? Everywhere is looked at, before any particle falls there.
//!
//! window of way + sightings ──estimate for every cell, heading and scale──▶ what may be good ──exact score──▶ leaves ──▶ modes
//!
//! Coarse to fine over four dimensions (x, y, heading, scale), as correlative scan matching does it over three (Olson 2009; Hess
//! et al. 2016). Every third heading and scale sets the bar; groups of nine that come near it are gone through; and only cells
//! that may reach it are scored, ray by ray, until that is decided. The estimate of a cell is a sum of looked-up losses
//! ([`sweep`]), for 32 cells at a time.
//! Departs from the sources in that the estimate is not a strict bound. Strict ones (nearest and farthest wall over all that a cell
//! spans) were tried on a real plan: 85 nats too kind, where random places are 70 to 90 worse than the truth, they ruled out
//! nothing. The estimate errs by about 3 nats; [`sweep::SLACK_NATS`] and [`Sweep::group_slack_nats`] leave room for that, and a test asks
//! every cell one by one. What is skipped is by [`LookOptions::keep_nats`] worse than the best place.
//! The estimate takes some of the sightings, the score four times as many: along corridors, where these fall decides which door
//! one is at. The difference is estimated as that of any sample, and room is left for it.
//! Pitfall: the window must be stiff; over tens of metres odometry drifts, and no rigid placement fits.

mod horizon;
mod sweep;
mod watch;
mod window;

use horizon::Horizon;
pub(crate) use watch::{Due, Watch};
pub(crate) use window::{Scene, Window, evenly, way_of};

use planwalk_types::{FloorPlan, Hypothesis, Path, PlanPose, ScaleEstimate, Seed, Sighting};
use rayon::prelude::*;

use crate::LocateError;
use crate::likelihood::{Pending, Scorer};
use crate::modes::Bins;
use crate::motion::{Motion, uniform};
use crate::options::LocateOptions;
use crate::particles::Particles;
use crate::prior::{self, ScalePrior};
use crate::run;
use crate::walls::Walls;
use sweep::Sweep;

/// Where the last metres of a walk can have been.
#[derive(Debug, Clone)]
pub struct FirstLook {
    /// Separate places, likeliest first, each with its pose at the end of the walk. Their tracks are empty.
    pub places: Vec<Hypothesis>,
    /// Cells of (x, y, heading, scale) that are within [`LookOptions::keep_nats`] of the best one.
    pub kept: usize,
    /// Cells that were scored; the estimate ruled the others out.
    pub scored: usize,
    /// Cells there are.
    pub cells: usize,
}

/// Looks everywhere on the plan for the end of this walk: its last [`LookOptions::way_m`] metres and what was seen on them.
///
/// Nothing is drawn by chance. Nothing seen gives no places: walls that were not hit say too little.
///
/// # Errors
/// [`LocateError`] when the path or the scale make no sense.
pub fn first_look(path: &Path, sightings: &[Sighting], plan: &FloorPlan, options: &LocateOptions) -> Result<FirstLook, LocateError> {
    run::check(path)?;
    options.check(plan)?;
    let walls = Walls::new(plan, options.ground);
    let scorer = Scorer::new(&options.sightings, &walls);
    let atlas = Atlas::new(plan, &walls);
    let mut seen: Vec<Sighting> = sightings.to_vec();
    seen.sort_by_key(|s| s.stamp);
    let (mut window, mut pending, mut motion) = (Window::default(), Pending::default(), Motion::none());
    for (step, now) in run::with_sightings(path, &seen) {
        now.iter().for_each(|sighting| pending.add(sighting, &motion, step));
        motion = motion.then(&Motion::of(step, 1.0));
        if motion.length * options.scale.metres_per_unit >= options.update_distance_m || motion.turned_rad >= options.update_turn_rad {
            let rays = pending.take(options.sightings.rays, &motion);
            window.push(motion, &rays, options.scale.metres_per_unit);
            motion = Motion::none();
        }
    }
    let Some(scene) = window.scene(options.look.way_m, options.scale.metres_per_unit, options.look.rays) else {
        return Ok(FirstLook { places: Vec::new(), kept: 0, scored: 0, cells: 0 });
    };
    let patient = LocateOptions { look: LookOptions { scored_most: usize::MAX, ..options.look }, ..options.clone() };
    let looked = look(&atlas, &walls, &scorer, &scene, &patient).unwrap_or_default();
    let cloud = looked.cloud();
    let modes = Bins::new(plan.size_m()).modes(&cloud);
    let places = modes.modes.iter().map(|m| Hypothesis {
        probability: m.mass,
        pose: PlanPose::new(m.mean.x + plan.origin().x, m.mean.y + plan.origin().y, m.mean.z),
        covariance: m.covariance,
        radius95_m: m.radius95_m,
        scale: ScaleEstimate { metres_per_unit: libm::exp(m.log_scale), relative_sigma: m.log_scale_sigma },
        track: Vec::new(),
    });
    Ok(FirstLook { places: places.collect(), kept: looked.leaves.len(), scored: looked.scored, cells: looked.cells })
}

/// The plan, prepared for looks: made once, used by all.
#[derive(Debug, Clone)]
pub(crate) struct Atlas {
    horizon: Horizon,
    /// Log prior of each cell of the horizon; minus infinity in walls.
    place_nats: Vec<f32>,
}

impl Atlas {
    pub(crate) fn new(plan: &FloorPlan, walls: &Walls) -> Self {
        let horizon = Horizon::new(walls);
        let mut weights = vec![0.0f64; horizon.width * horizon.height];
        for (cell, weight) in weights.iter_mut().enumerate() {
            // Cells of the plan may be wider or narrower than these: both look each other up.
            *weight = prior::weight_at(plan, horizon.centre(cell % horizon.width, cell / horizon.width));
        }
        for (i, (cell, inside)) in plan.cells().iter().zip(plan.inside()).enumerate() {
            let (x, y) = ((i % plan.width()) as f32 + 0.5, (i / plan.width()) as f32 + 0.5);
            if let Some(at) = horizon.cell_at(x * walls.cell_m(), y * walls.cell_m()) {
                weights[at] = weights[at].max(prior::weight(*cell, *inside));
            }
        }
        let near = near_floor(&weights, &horizon);
        weights.iter_mut().zip(near).for_each(|(weight, near)| *weight = if near { *weight } else { 0.0 });
        let place_nats = weights.into_iter().map(|w| if w > 0.0 { libm::log(w) as f32 } else { f32::NEG_INFINITY }).collect();
        Self { horizon, place_nats }
    }
}

/// Which cells have ground within [`FLOOR_WITHIN_M`] on which one is as likely as anywhere.
fn near_floor(weights: &[f64], horizon: &Horizon) -> Vec<bool> {
    let (width, reach) = (horizon.width, (FLOOR_WITHIN_M / f64::from(horizon.cell_m)).ceil() as usize);
    let most = weights.iter().copied().fold(0.0, f64::max);
    let floor: Vec<bool> = weights.iter().map(|weight| *weight >= 0.5 * most).collect();
    // Within a square: along the rows, then along the columns.
    let mut rows = vec![false; floor.len()];
    for (row, out) in floor.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        for at in (0..width).filter(|at| row[*at]) {
            out[at.saturating_sub(reach)..(at + reach + 1).min(width)].fill(true);
        }
    }
    let mut near = vec![false; floor.len()];
    for (row, line) in rows.chunks_exact(width).enumerate() {
        for other in row.saturating_sub(reach)..(row + reach + 1).min(horizon.height) {
            near[other * width..(other + 1) * width].iter_mut().zip(line).for_each(|(near, here)| *near |= here);
        }
    }
    near
}

/// The looks at one plan that were asked for so far: several runs over one walk ask for the same ones.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    atlas: Option<Atlas>,
    made: Vec<(Asked, Option<Looked>)>,
}

/// Looks that are remembered: a kilometre of way, and no more memory on longer ones.
const REMEMBERED: usize = 64;

/// What tells one look from another.
#[derive(Debug, Clone, PartialEq)]
struct Asked {
    scene: Scene,
    scale: ScalePrior,
    keep_nats: f64,
}

impl Looks {
    /// [`look`] or what it gave when this was asked before. The plan must be the same each time.
    pub(crate) fn look(
        &mut self,
        (plan, walls, scorer): (&FloorPlan, &Walls, &Scorer),
        scene: Scene,
        options: &LocateOptions,
    ) -> Option<Looked> {
        let asked = Asked { scene, scale: options.scale, keep_nats: options.look.keep_nats };
        if let Some((_, looked)) = self.made.iter().find(|(made, _)| *made == asked) {
            return looked.clone();
        }
        let atlas = self.atlas.get_or_insert_with(|| Atlas::new(plan, walls));
        let looked = look(atlas, walls, scorer, &asked.scene, options);
        if self.made.len() < REMEMBERED {
            self.made.push((asked, looked.clone()));
        }
        looked
    }
}

/// Options of a look over the whole plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookOptions {
    /// Way that one look takes in, metres: short enough for odometry to be stiff, long enough for corners to be in it.
    pub way_m: f64,
    /// Sightings that are scored …
    pub rays: usize,
    /// … and those of them that the estimate takes.
    pub estimated_rays: usize,
    /// Every place whose likelihood is within so many nats of the best one's is found.
    pub keep_nats: f64,
    /// Way between two looks that only make sure, metres.
    pub every_m: f64,
    /// Nats a sighting of which what is seen falls short, summed up along the way, until the place is doubted and looked for anew.
    /// See [`crate::VerdictOptions::gain_nats`] for what the truth has.
    pub doubt_nats: f64,
    /// Particles that one look puts in, at most.
    pub particles: usize,
    /// Scales are looked at up to so many standard deviations of the prior.
    pub scale_sigmas: f64,
    /// Where more cells than these would have to be scored, the view is of what there is everywhere, and the filter looks again
    /// later, over half as much way again. [`first_look`] looks all the same.
    pub scored_most: usize,
}

impl Default for LookOptions {
    fn default() -> Self {
        Self {
            way_m: 8.0,
            rays: 192,
            estimated_rays: 48,
            keep_nats: 10.0,
            every_m: 20.0,
            doubt_nats: 0.4,
            particles: 50_000,
            scale_sigmas: 2.5,
            scored_most: 500_000,
        }
    }
}

/// Whoever is farther from any floor is not looked for. On unknown ground the way there alone costs about
/// [`LookOptions::keep_nats`]; whoever walks round the building at a distance is left to the particles.
const FLOOR_WITHIN_M: f64 = 4.0;
/// Relative step of scale: at 10 m half of it is 15 cm.
pub(crate) const SCALE_STEP: f64 = 0.03;
/// Groups that are looked into between two raises of the bar.
const BATCH: usize = 8;
/// Rounds in which groups are estimated, and places that are tried after each, to raise the bar.
const ROUNDS: usize = 8;
const PROBES: usize = 64;

/// A pose of the window's end that explains it. Local metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leaf {
    pub x: f32,
    pub y: f32,
    pub heading: f32,
    pub log_scale: f32,
    /// Tempered log-likelihood with the priors of place and scale, up to a common constant.
    pub nats: f32,
}

/// What a look found.
#[derive(Debug, Clone, Default)]
pub(crate) struct Looked {
    /// All cells of (x, y, heading, scale) within [`LookOptions::keep_nats`] of the best, best first; at the window's end.
    pub leaves: Vec<Leaf>,
    /// Cells that were scored exactly, and cells there are.
    pub scored: usize,
    pub cells: usize,
    /// Side of a cell, metres.
    cell_m: f64,
}

impl Looked {
    /// `count` particles among the leaves, spread within their cells. Half of the evidence decides how many each gets, half how
    /// much they weigh: a place that is a little worse over a few metres may be the one.
    pub(crate) fn draw(&self, count: usize, seed: Seed) -> Particles {
        let mut rng = seed.derive("look", 0);
        let best = self.leaves.iter().map(|l| l.nats).fold(f32::NEG_INFINITY, f32::max);
        let shares: Vec<f64> = self.leaves.iter().map(|l| libm::exp(0.5 * f64::from(l.nats - best))).collect();
        let apart = shares.iter().sum::<f64>() / count.max(1) as f64;
        let mut cloud = Particles::with_capacity(count);
        let (mut next, mut swept) = (apart * uniform(&mut rng), 0.0);
        for (leaf, share) in self.leaves.iter().zip(&shares) {
            swept += share;
            while swept > next && cloud.len() < count {
                next += apart;
                let mut off = |width: f64| (width * (uniform(&mut rng) - 0.5)) as f32;
                let (dx, dy) = (off(self.cell_m), off(self.cell_m));
                let (turn, stretch) = (off(std::f64::consts::TAU / horizon::DIRECTIONS as f64), off(SCALE_STEP));
                cloud.push(leaf.x + dx, leaf.y + dy, leaf.heading + turn, leaf.log_scale + stretch);
                if let Some(weight) = cloud.log_weight.last_mut() {
                    *weight = 0.5 * (leaf.nats - best);
                }
            }
        }
        cloud.normalize();
        cloud
    }

    /// Without the leaves for which `known` holds; and the share of the mass of those that are left.
    pub(crate) fn without(&self, known: impl Fn(&Leaf) -> bool) -> (Self, f64) {
        let best = self.leaves.iter().map(|l| l.nats).fold(f32::NEG_INFINITY, f32::max);
        let mass = |leaves: &[Leaf]| leaves.iter().map(|l| libm::exp(f64::from(l.nats - best))).sum::<f64>();
        let leaves: Vec<Leaf> = self.leaves.iter().filter(|l| !known(l)).copied().collect();
        let share = mass(&leaves) / mass(&self.leaves).max(f64::MIN_POSITIVE);
        (Self { leaves, ..*self }, share)
    }

    /// The leaves as a weighted cloud.
    pub(crate) fn cloud(&self) -> Particles {
        let mut cloud = Particles::with_capacity(self.leaves.len());
        for leaf in &self.leaves {
            cloud.push(leaf.x, leaf.y, leaf.heading, leaf.log_scale);
        }
        cloud.log_weight = self.leaves.iter().map(|l| l.nats).collect();
        cloud.normalize();
        cloud
    }
}

/// Looks everywhere; `None` where that would take the score of more than [`LookOptions::scored_most`] cells: such a view tells
/// too little.
pub(crate) fn look(atlas: &Atlas, walls: &Walls, scorer: &Scorer, scene: &Scene, all: &LocateOptions) -> Option<Looked> {
    let (horizon, options) = (&atlas.horizon, &all.look);
    let scales = scales(&all.scale, options.scale_sigmas);
    let sweep = Sweep::new(atlas, walls, scorer, scene, all);
    let lanes = sweep.lanes();
    let groups = groups(&scales);
    let (keep, slack) = (options.keep_nats as f32, sweep.group_slack_nats());
    let (mut tops, mut bar): (Vec<(f32, usize, usize)>, f32) = (Vec::new(), f32::MIN);
    let (mut probes, mut better): (Vec<Leaf>, f32) = (Vec::new(), 0.0);
    // A few groups from everywhere set the bar that spares most of the work in the others.
    for first in 0..ROUNDS {
        let round: Vec<usize> = (first..groups.len()).step_by(ROUNDS).collect();
        let best = |i: &usize| {
            let (nats, cell) = sweep.best(&lanes, groups[*i][0], bar - better - slack);
            (nats, cell, *i)
        };
        let mut found: Vec<_> = round.par_iter().map(best).filter(|(nats, _, _)| *nats > f32::NEG_INFINITY).collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        let probe = |found: &(f32, usize, usize)| sweep.climb(found.1, groups[found.2][0]);
        probes.extend(found.par_iter().take(PROBES).filter_map(probe).collect::<Vec<_>>());
        probes.sort_by(|a, b| b.nats.total_cmp(&a.nats));
        probes.truncate(PROBES);
        bar = probes.first().map_or(bar, |best| best.nats - keep);
        better = better_than_estimated(&sweep, &probes);
        tops.extend(found);
    }
    tops.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
    let mut looked = Looked {
        cells: scales.len() * horizon::DIRECTIONS * horizon.width * horizon.height,
        cell_m: f64::from(horizon.cell_m),
        ..Looked::default()
    };
    for batch in tops.chunks(BATCH) {
        let near: Vec<(usize, Vec<usize>)> = batch
            .par_iter()
            .filter(|(nats, _, _)| *nats >= bar - better - slack)
            .map(|(_, _, i)| (*i, sweep.promising(&lanes, groups[*i][0], bar - better - slack)))
            .collect();
        let pairs: Vec<_> = near.iter().flat_map(|(i, near)| groups[*i].iter().map(move |pair| (*pair, near))).collect();
        let asked: Vec<_> =
            pairs.par_iter().map(|(pair, near)| (*pair, sweep.candidates(near, *pair, bar - better, options.scored_most))).collect();
        looked.scored += asked.iter().map(|(_, cells)| cells.len()).sum::<usize>();
        if looked.scored > options.scored_most {
            return None;
        }
        let found: Vec<Vec<Leaf>> = asked.par_iter().map(|(pair, cells)| sweep.leaves(cells, *pair, bar, better)).collect();
        for leaves in found {
            let best = leaves.iter().map(|l| l.nats).fold(f32::NEG_INFINITY, f32::max);
            bar = bar.max(best - keep);
            looked.leaves.extend(leaves);
        }
    }
    looked.leaves.retain(|l| l.nats >= bar);
    looked.leaves.sort_by(|a, b| b.nats.total_cmp(&a.nats));
    for leaf in &mut looked.leaves {
        sweep.to_end(leaf);
    }
    Some(looked)
}

/// By how much good places score better with all sightings than with those that the estimate takes.
fn better_than_estimated(sweep: &Sweep<'_>, probes: &[Leaf]) -> f32 {
    let some = &probes[..probes.len().min(PROBES / 4)];
    some.iter().map(|probe| sweep.better_than_estimated(probe)).sum::<f32>() / some.len().max(1) as f32
}

fn scales(prior: &ScalePrior, sigmas: f64) -> Vec<f64> {
    let reach = sigmas * prior.relative_sigma;
    let half = (reach / SCALE_STEP).ceil() as i32;
    (-half..=half).map(|i| prior.log_mean() + f64::from(i) * if half > 0 { reach / f64::from(half) } else { 0.0 }).collect()
}

/// Headings and scales in groups of three by three, the middle one first.
fn groups(scales: &[f64]) -> Vec<Vec<(usize, f64)>> {
    let mut groups = Vec::new();
    for scales in scales.chunks(3) {
        for first in (0..horizon::DIRECTIONS).step_by(3) {
            let middle = (first + 1, scales[scales.len() / 2]);
            let all = scales.iter().flat_map(|s| (first..first + 3).map(move |k| (k, *s)));
            groups.push(std::iter::once(middle).chain(all.filter(|pair| *pair != middle)).collect());
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::likelihood::Ray;
    use planwalk_types::{Pt2, Wall};

    /// An L of two rooms with a door, 9 m × 6 m.
    fn plan() -> FloorPlan {
        let wall = |x0: f64, y0: f64, x1: f64, y1: f64| Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) };
        let walls = [
            wall(0.0, 0.0, 9.0, 0.0),
            wall(9.0, 0.0, 9.0, 3.5),
            wall(9.0, 3.5, 4.0, 3.5),
            wall(4.0, 3.5, 4.0, 6.0),
            wall(4.0, 6.0, 0.0, 6.0),
            wall(0.0, 6.0, 0.0, 0.0),
            wall(4.0, 0.0, 4.0, 1.4),
            wall(4.0, 2.4, 4.0, 3.5),
        ];
        FloorPlan::from_walls(&walls, 0.05, 1.0).unwrap()
    }

    /// From (1.5, 1.5) through the door to (5.5, 2), looking about; units of 1/`scale` m; every third thing seen is furniture.
    fn scene(walls: &Walls, scale: f64) -> Scene {
        let (mut rays, mut way) = (Vec::new(), Vec::new());
        for i in 0..8 {
            let (x, y) = (2.5 + 4.0 * f64::from(i) / 7.0, 2.5 + 0.5 * f64::from(i) / 7.0);
            // The reference is in the middle, and looks along x.
            let from = ((x - 4.5) / scale, (y - 2.75) / scale);
            way.push(from);
            for k in -2..=2 {
                let (s, c) = libm::sincos(0.35 * f64::from(k) + 0.2 * f64::from(i % 3 - 1));
                let short = if rays.len() % 3 == 0 { 0.6 } else { 1.0 };
                let range = short * f64::from(walls.cast(x as f32, y as f32, c as f32, s as f32, 12.0)) / scale;
                rays.push(Ray { from, to: (from.0 + range * c, from.1 + range * s), sigma: 0.04 * range });
            }
        }
        // As many as the filter would have used over this way.
        let counted = 8 * rays.len();
        Scene { rays, way, to_end: Motion::none(), counted }
    }

    fn options(relative_sigma: f64) -> LocateOptions {
        LocateOptions::new(Seed(1), ScalePrior { metres_per_unit: 1.0, relative_sigma })
    }

    /// Scores of what a look finds whose estimate takes so many of the 40 sightings, and of all there is, every cell, heading and
    /// scale asked one by one; best first. And the share of cells that the look scored.
    fn found_and_all(estimated_rays: usize) -> (Vec<f32>, Vec<f32>, f64) {
        let (plan, mut options) = (plan(), options(0.03));
        options.look.estimated_rays = estimated_rays;
        let walls = Walls::new(&plan, options.ground);
        let scorer = Scorer::new(&options.sightings, &walls);
        let atlas = Atlas::new(&plan, &walls);
        let scene = scene(&walls, 1.03);
        let looked = look(&atlas, &walls, &scorer, &scene, &options).unwrap();
        let found: Vec<f32> = looked.leaves.iter().map(|leaf| leaf.nats).collect();
        let bar = found[0] - options.look.keep_nats as f32;
        let sweep = Sweep::new(&atlas, &walls, &scorer, &scene, &options);
        let scales = scales(&options.scale, options.look.scale_sigmas);
        let pairs: Vec<(usize, f64)> = scales.iter().flat_map(|s| (0..horizon::DIRECTIONS).map(move |k| (k, *s))).collect();
        let mut all: Vec<f32> = pairs.par_iter().flat_map_iter(|pair| sweep.every_score(*pair, bar)).collect();
        all.sort_by(|a, b| b.total_cmp(a));
        (found, all, looked.scored as f64 / looked.cells as f64)
    }

    #[test]
    fn nothing_that_scores_is_skipped() {
        let (found, all, scored) = found_and_all(40);
        assert!(all.len() > 10 && found == all, "{} of {} found", found.len(), all.len());
        // Most is never scored.
        assert!(scored < 0.05, "{scored}");
    }

    #[test]
    fn an_estimate_from_half_of_the_sightings_skips_none_of_the_good_places() {
        let (found, all, _) = found_and_all(20);
        let good = |nats: &[f32]| nats.iter().filter(|n| **n >= all[0] - 5.0).count();
        // Chance takes some of those that are worse.
        assert!(good(&found) == good(&all) && found.len() * 4 > all.len() * 3, "{found:?} of {all:?}");
    }

    #[test]
    fn the_place_and_the_scale_are_found_wherever_one_looks_from() {
        let (plan, options) = (plan(), options(0.2));
        let walls = Walls::new(&plan, options.ground);
        let scorer = Scorer::new(&options.sightings, &walls);
        let atlas = Atlas::new(&plan, &walls);
        let looked = look(&atlas, &walls, &scorer, &scene(&walls, 1.25), &options).unwrap();
        let best = looked.leaves[0];
        // A cell's half diagonal, and a step of heading and scale.
        assert!((best.x - 4.5).hypot(best.y - 2.75) < 0.3, "{best:?}");
        assert!(best.heading.abs() < 0.07 && (best.log_scale - libm::logf(1.25)).abs() < 0.06, "{best:?}");
    }

    #[test]
    fn particles_are_drawn_where_the_leaves_are() {
        let leaf = |x: f32, nats: f32| Leaf { x, y: 0.0, heading: 0.0, log_scale: 0.0, nats };
        let looked = Looked { leaves: vec![leaf(0.0, 0.0), leaf(5.0, -2.0)], scored: 2, cells: 2, cell_m: 0.2 };
        let cloud = looked.draw(2000, Seed(3));
        let worse: Vec<usize> = (0..cloud.len()).filter(|i| cloud.x[*i] > 2.5).collect();
        let weight: f64 = worse.iter().map(|i| f64::from(cloud.weight[*i])).sum();
        // e⁻¹ : 1 in number, e⁻² : 1 in weight; systematic drawing is off by one particle.
        let (count, mass) = (2000.0 / (1.0 + std::f64::consts::E), 1.0 / (1.0 + libm::exp(2.0)));
        assert!((worse.len() as f64 - count).abs() < 2.0 && (weight - mass).abs() < 2e-3, "{} weigh {weight}", worse.len());
        let (elsewhere, share) = looked.without(|l| l.x < 1.0);
        assert!(elsewhere.leaves.len() == 1 && (share - mass).abs() < 1e-9, "{share}");
    }
}
