//! What can each cell of the plan make of the window, for one heading and one scale? An estimate for all, the score for the few.

use planwalk_types::wrap_angle;

use super::horizon::{self, DIRECTIONS, Horizon, LANES, REACH_M, UNIT_M};
use super::window::{Scene, evenly};
use super::{Atlas, Leaf};
use crate::likelihood::{Ray, Scorer, SightingModel, View};
use crate::motion::Motion;
use crate::options::LocateOptions;
use crate::prior::ScalePrior;
use crate::walls::Walls;
use nalgebra::Vector3;

/// Way between two places at which walls in the way are looked for, metres.
const WAY_STEP_M: f64 = 0.8;
/// Rays between two looks at whether a lane of cells is worth going on.
const PATIENCE: usize = 8;
/// What the sweep may think too little of a cell, nats: rays that pass a door post on either side …
pub(super) const SLACK_NATS: f32 = 5.0;
/// … and what it says of some of the sightings, not of all: by how much one differs from another over good places, tempered. On
/// corridors whose doors alone tell places apart, windows of 304 to 640 sightings of which 48 were estimated and 192 scored had
/// deviations of 2.4 to 6.7 nats, beyond what is common to good places ([`Sweep::better_than_estimated`]): 0.08 a sighting.
const SIGHTING_NATS: f64 = 0.08;
/// Standard deviations that are left for it.
const SAMPLING_SIGMAS: f64 = 2.0;
/// How much worse than its best member the middle of a group may be, nats.
const GROUP_SLACK_NATS: f32 = 8.0;
/// How far the ends of a group's rays lie apart, as a share of their length: a step of heading and one of scale, together.
const GROUP_REACH: f64 = 0.04;
/// A pose on the grid is off by up to half a cell: that blurs what it sees by this share of the cell.
const GRID_SIGMA: f64 = 0.4;

/// The window conditioned for sweeping.
pub(super) struct Sweep<'a> {
    horizon: &'a Horizon,
    /// Log prior of each cell; minus infinity where nobody can be.
    place_nats: &'a [f32],
    walls: &'a Walls,
    /// All sightings, and those that the estimate takes.
    all: Seen<'a>,
    some: Seen<'a>,
    scene: &'a Scene,
    scale: ScalePrior,
    /// What the estimate may think too little of a place because of the sightings that it leaves out, nats.
    sampling_nats: f32,
    leak_nats: f64,
    rays: Vec<Bearing>,
    model: SightingModel,
    /// Nats in a unit of loss.
    unit: f64,
    /// What a ray loses that ends in a cell, by class of its spread.
    losses: Vec<Vec<u8>>,
}

/// Sightings, and what one of them counts for: the fewer they are, the more each stands for.
struct Seen<'a> {
    view: View<'a>,
    temper: f64,
}

impl Seen<'_> {
    /// Tempered nats of a pose; `None` where they are below `floor`.
    fn nats(&self, [x, y, heading, log_scale]: [f32; 4], floor: f32) -> Option<f32> {
        let temper = self.temper as f32;
        Some(temper * self.view.nats_at_least(x, y, heading, log_scale, floor / temper)?)
    }
}

/// A ray, or a piece of way, for bounding.
#[derive(Debug, Clone, Copy)]
struct Bearing {
    from: (f64, f64),
    angle: f64,
    range: f64,
    sigma: f64,
    is_way: bool,
}

/// A ray for one heading and scale.
#[derive(Debug, Clone, Copy)]
struct Test {
    direction: usize,
    /// Cells from the reference to where the ray begins, and to where it ends.
    from: (isize, isize),
    to: (isize, isize),
    /// The farther the wall is below this, the more is lost, at most `through`: the ray went through it.
    low: u8,
    through: u8,
    /// Which losses count at its end; none for a piece of way.
    losses: Option<usize>,
}

impl<'a> Sweep<'a> {
    pub(super) fn new(atlas: &'a Atlas, walls: &'a Walls, scorer: &'a Scorer, scene: &'a Scene, options: &LocateOptions) -> Self {
        let (scale, model) = (&options.scale, &options.sightings);
        let bearing = |from: (f64, f64), to: (f64, f64), sigma: f64, is_way: bool| {
            let (dx, dy) = (to.0 - from.0, to.1 - from.1);
            Bearing { from, angle: libm::atan2(dy, dx), range: dx.hypot(dy), sigma, is_way }
        };
        let take = scene.rays.len().min(options.look.estimated_rays);
        let some: Vec<usize> = evenly(take, scene.rays.len()).collect();
        let of = |i: &usize| bearing(scene.rays[*i].from, scene.rays[*i].to, scene.rays[*i].sigma, false);
        let mut rays: Vec<Bearing> = some.iter().map(of).collect();
        // Bits of the same scene lie next to each other: spread, so that the first few already tell.
        let stride = rays.len().div_ceil(PATIENCE).max(1);
        rays = (0..stride).flat_map(|o| rays.iter().skip(o).step_by(stride).copied().collect::<Vec<_>>()).collect();
        let mut last = scene.way.first().copied().unwrap_or((0.0, 0.0));
        for point in &scene.way {
            if (point.0 - last.0).hypot(point.1 - last.1) * scale.metres_per_unit >= WAY_STEP_M {
                rays.push(bearing(last, *point, 0.0, true));
                last = *point;
            }
        }
        let blurred: Vec<Ray> = scene
            .rays
            .iter()
            .map(|r| Ray { sigma: r.sigma.hypot(GRID_SIGMA * f64::from(atlas.horizon.cell_m) / scale.metres_per_unit), ..*r })
            .collect();
        let worth = model.temper * scene.counted as f64;
        let seen = |rays: &[Ray]| Seen { view: scorer.on(walls, rays), temper: worth / rays.len().max(1) as f64 };
        let mut sweep = Self {
            horizon: &atlas.horizon,
            place_nats: &atlas.place_nats,
            walls,
            all: seen(&blurred),
            some: seen(&some.iter().map(|i| blurred[*i]).collect::<Vec<_>>()),
            scene,
            scale: *scale,
            sampling_nats: sampling_nats(scene.counted, take, scene.rays.len()),
            leak_nats: libm::log(options.leak.clamp(1e-9, 1.0)),
            rays,
            model: *model,
            // A byte must hold what the best place loses, and all that others may lose beyond that.
            unit: (2.0 * worth).max(1.4 * worth + options.look.keep_nats + f64::from(GROUP_SLACK_NATS)) / 254.0,
            losses: Vec::new(),
        };
        sweep.losses = (0..CLASSES).map(|class| sweep.losses_of(class)).collect();
        sweep
    }

    /// What a ray of this spread loses that ends in each cell, before all walls.
    fn losses_of(&self, class: usize) -> Vec<u8> {
        let sigma_m = sigma_of(class);
        let best = self.end_nats(0.0, sigma_m);
        let lost = |key: u8| {
            let distance_m = (0.5 * f64::from(key) - 0.5).max(0.0) * f64::from(self.walls.cell_m());
            let nats = self.end_nats(if key == u8::MAX { f64::INFINITY } else { distance_m }, sigma_m);
            (self.some.temper * (best - nats) / self.unit).round().clamp(0.0, 255.0) as u8
        };
        let by_key: Vec<u8> = (0..=u8::MAX).map(lost).collect();
        let at = |cell: usize| {
            let (x, y) = self.horizon.centre(cell % self.horizon.width, cell / self.horizon.width);
            by_key[usize::from(self.walls.wall_distance_key(x, y))]
        };
        (0..self.horizon.width * self.horizon.height).map(at).collect()
    }

    /// Nats of a ray that ends so far from a wall, before it; untempered.
    fn end_nats(&self, distance_m: f64, sigma_m: f64) -> f64 {
        let m = &self.model;
        let wall = m.wall * libm::exp(-0.5 * (distance_m / sigma_m).powi(2)) / (sigma_m * 2.506_628);
        libm::log((wall + m.clutter / m.spread_m) / (m.wall + m.clutter + m.through))
    }

    fn log_prior(&self, log_scale: f64) -> f64 {
        let z = (log_scale - self.scale.log_mean()) / self.scale.relative_sigma.max(1e-3);
        -0.5 * z * z
    }

    /// The tests for one heading and scale and the score of a cell that fails none; or for all of a group around them, of which
    /// a ray's end spreads by `reach` of its length.
    fn tests(&self, (direction, log_scale): (usize, f64), reach: f64) -> (Vec<Test>, f64) {
        let scale = libm::exp(log_scale);
        let m = &self.model;
        let through_nats = libm::log(m.through / m.spread_m / (m.wall + m.clutter + m.through));
        let count = self.rays.iter().filter(|r| !r.is_way).count() as f64;
        let (s, c) = libm::sincos(f64::from(horizon::angle(direction)));
        let mut base = self.log_prior(log_scale) + self.some.temper * count * log_scale;
        let tests = self
            .rays
            .iter()
            .map(|ray| {
                let range = scale * ray.range;
                let (x, y) = (scale * (c * ray.from.0 - s * ray.from.1), scale * (s * ray.from.0 + c * ray.from.1));
                let steps = (ray.angle / std::f64::consts::TAU * DIRECTIONS as f64).round() as isize;
                let towards = (direction as isize + steps).rem_euclid(DIRECTIONS as isize) as usize;
                // Bounded: what is farther off than any plan is off it.
                let cell = |v: f64| (v / f64::from(self.horizon.cell_m)).round().clamp(-1e8, 1e8) as isize;
                let cells = |x: f64, y: f64| (cell(x), cell(y));
                let (sin, cos) = libm::sincos(f64::from(horizon::angle(direction)) + ray.angle);
                let (from, to) = (cells(x, y), cells(x + range * cos, y + range * sin));
                let low = |metres: f64| (metres.min(f64::from(REACH_M - UNIT_M)) / f64::from(UNIT_M)).clamp(0.0, 255.0) as u8;
                if ray.is_way {
                    let through = (-self.leak_nats / self.unit) as u8;
                    return Test { direction: towards, from, to, low: low(range - 0.1), through, losses: None };
                }
                let sigma_m = self.model.wall_sigma_m.hypot(GRID_SIGMA * f64::from(self.horizon.cell_m)).hypot(scale * ray.sigma);
                let best = self.end_nats(0.0, sigma_of(class_of(sigma_m)));
                base += self.some.temper * best;
                let through = (self.some.temper * (best - through_nats) / self.unit).min(255.0) as u8;
                let class = class_of(sigma_m.hypot(reach * range));
                Test { direction: towards, from, to, low: low(range * (1.0 - reach) - 2.0 * sigma_m - 0.1), through, losses: Some(class) }
            })
            .collect();
        (tests, base)
    }

    /// How much worse than its best member a group's estimate may be, nats.
    pub(super) fn group_slack_nats(&self) -> f32 {
        GROUP_SLACK_NATS + self.sampling_nats
    }

    /// The lanes in which somebody can be, by their first cells.
    pub(super) fn lanes(&self) -> Vec<usize> {
        let somewhere = |at: &usize| self.place_nats[*at..at + LANES].iter().any(|p| *p > f32::NEG_INFINITY);
        (0..self.place_nats.len()).step_by(LANES).filter(somewhere).collect()
    }

    /// Estimates lanes of cells; `see` gets the first cell of each lane and what its cells lose, and says how much more is
    /// bearable. Lanes that lose more than `bearable` everywhere are left out.
    fn sweep(&self, lanes: &[usize], tests: &[Test], bearable: u8, see: impl FnMut(usize, &[u8; LANES]) -> u8) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            #[expect(unsafe_code, reason = "the processor was just asked whether it has what the function is compiled for")]
            // SAFETY: `sweep_avx2` is a safe function that needs AVX2, and AVX2 is there.
            return unsafe { self.sweep_avx2(lanes, tests, bearable, see) };
        }
        self.sweep_anywhere(lanes, tests, bearable, see);
    }

    /// The same as [`Sweep::sweep_anywhere`], 32 cells an instruction where SSE2 takes 16.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn sweep_avx2(&self, lanes: &[usize], tests: &[Test], bearable: u8, see: impl FnMut(usize, &[u8; LANES]) -> u8) {
        self.sweep_anywhere(lanes, tests, bearable, see);
    }

    #[inline(always)]
    fn sweep_anywhere(&self, lanes: &[usize], tests: &[Test], mut bearable: u8, mut see: impl FnMut(usize, &[u8; LANES]) -> u8) {
        let (width, height) = (self.horizon.width, self.horizon.height);
        let images: Vec<(&[u8], Option<&[u8]>)> =
            tests.iter().map(|t| (self.horizon.image(t.direction), t.losses.map(|class| self.losses[class].as_slice()))).collect();
        for at in lanes.iter().copied() {
            let (column, row) = (at % width, at / width);
            let mut lost = [0u8; LANES];
            let mut hopeless = false;
            for (group, images) in tests.chunks(PATIENCE).zip(images.chunks(PATIENCE)) {
                for (test, (horizon, losses)) in group.iter().zip(images) {
                    let wall = Lane::of(horizon, (width, height), (column, row), test.from);
                    match losses {
                        Some(losses) => {
                            let ends = Lane::of(losses, (width, height), (column, row), test.to);
                            add_losses(&mut lost, wall.get(), ends.get(), test);
                        }
                        None => add_losses(&mut lost, wall.get(), &[0; LANES], test),
                    }
                }
                if lost.iter().all(|l| *l > bearable) {
                    hopeless = true;
                    break;
                }
            }
            if !hopeless {
                bearable = see(at, &lost);
            }
        }
    }

    /// The best estimate for the group around a heading and scale, and which cell's it is; minus infinity where no cell may reach
    /// `bar`.
    pub(super) fn best(&self, lanes: &[usize], pair: (usize, f64), bar: f32) -> (f32, usize) {
        let (tests, base) = self.tests(pair, GROUP_REACH);
        let Some(bearable) = self.bearable(base, bar) else { return (f32::NEG_INFINITY, 0) };
        let (mut least, mut best) = (bearable.saturating_add(1), 0);
        self.sweep(lanes, &tests, bearable, |at, lost| {
            for (lane, l) in lost.iter().enumerate() {
                if *l < least && self.place_nats[at + lane] > f32::NEG_INFINITY {
                    (least, best) = (*l, at + lane);
                }
            }
            least.saturating_sub(1)
        });
        let nats = if least > bearable { f64::NEG_INFINITY } else { base - self.unit * f64::from(least) };
        (nats as f32, best)
    }

    /// The lanes with a cell whose estimate for the group reaches `bar`.
    pub(super) fn promising(&self, lanes: &[usize], pair: (usize, f64), bar: f32) -> Vec<usize> {
        let (tests, base) = self.tests(pair, GROUP_REACH);
        let Some(bearable) = self.bearable(base, bar) else { return Vec::new() };
        let mut found = Vec::new();
        self.sweep(lanes, &tests, bearable, |at, _| {
            found.push(at);
            bearable
        });
        found
    }

    /// The cells of these lanes whose estimate allows `bar`; where they are more than `most`, some of them.
    pub(super) fn candidates(&self, lanes: &[usize], pair: (usize, f64), bar: f32, most: usize) -> Vec<u32> {
        let (tests, base) = self.tests(pair, 0.0);
        let mut cells = Vec::new();
        let Some(bearable) = self.bearable(base, bar - SLACK_NATS - self.sampling_nats) else { return cells };
        self.sweep(lanes, &tests, bearable, |at, lost| {
            if cells.len() <= most {
                let may = |lane: &usize| lost[*lane] <= bearable && self.place_nats[at + lane] > f32::NEG_INFINITY;
                cells.extend((0..LANES).filter(may).map(|lane| (at + lane) as u32));
            }
            bearable
        });
        cells
    }

    /// Those of these cells that score at least `bar`, and with the estimate's sightings alone by `better` less, give or take.
    pub(super) fn leaves(&self, cells: &[u32], (direction, log_scale): (usize, f64), bar: f32, better: f32) -> Vec<Leaf> {
        let leaf = |cell: &u32| {
            let pose = self.pose(*cell as usize, (direction, log_scale));
            self.leaf(&self.some, pose, bar - better - self.sampling_nats)?;
            self.leaf(&self.all, pose, bar)
        };
        cells.iter().filter_map(leaf).collect()
    }

    /// The scores of all cells that reach `bar`, asked one by one.
    #[cfg(test)]
    pub(super) fn every_score(&self, pair: (usize, f64), bar: f32) -> Vec<f32> {
        let cells = (0..self.place_nats.len()).filter(|cell| self.place_nats[*cell] > f32::NEG_INFINITY);
        cells.filter_map(|cell| self.leaf(&self.all, self.pose(cell, pair), bar)).map(|leaf| leaf.nats).collect()
    }

    /// Units that a cell may lose and still reach the bar; none where it cannot.
    fn bearable(&self, base: f64, bar: f32) -> Option<u8> {
        let units = (base - f64::from(bar)) / self.unit;
        (units >= 0.0).then_some(units.min(254.0) as u8)
    }

    /// The pose of the reference in the middle of a cell.
    fn pose(&self, cell: usize, (direction, log_scale): (usize, f64)) -> [f32; 4] {
        let (x, y) = self.horizon.centre(cell % self.horizon.width, cell / self.horizon.width);
        [x, y, horizon::angle(direction), log_scale as f32]
    }

    /// A pose of the reference with the score that these sightings give it; `None` where that is below `bar`.
    fn leaf(&self, seen: &Seen<'_>, pose: [f32; 4], bar: f32) -> Option<Leaf> {
        let [x, y, heading, log_scale] = pose;
        let prior = self.log_prior(f64::from(log_scale)) as f32 + self.place(x, y);
        let nats = seen.nats(pose, bar - prior)? + prior - self.way_cost(x, y, heading, libm::expf(log_scale));
        (nats >= bar).then_some(Leaf { x, y, heading, log_scale, nats })
    }

    /// What the way costs among walls and grounds, nats.
    fn way_cost(&self, x: f32, y: f32, heading: f32, scale: f32) -> f32 {
        let (s, c) = libm::sincosf(heading);
        let (mut cost, mut last) = (0.0, None);
        for point in &self.scene.way {
            let (a, b) = (scale * point.0 as f32, scale * point.1 as f32);
            let here: (f32, f32) = (x + c * a - s * b, y + s * a + c * b);
            if let Some(from) = last.replace(here) {
                cost -= self.walls.crossings(from.0, from.1, here.0, here.1) as f32 * self.leak_nats as f32;
                cost += self.walls.ground_cost(here.0, here.1, (here.0 - from.0).hypot(here.1 - from.1));
            }
        }
        cost
    }

    fn place(&self, x: f32, y: f32) -> f32 {
        self.horizon.cell_at(x, y).map_or(f32::NEG_INFINITY, |cell| self.place_nats[cell])
    }

    /// By how much a pose scores better with all sightings than with those that the estimate takes.
    pub(super) fn better_than_estimated(&self, leaf: &Leaf) -> f32 {
        let pose = [leaf.x, leaf.y, leaf.heading, leaf.log_scale];
        let nats = |seen: &Seen<'_>| seen.nats(pose, f32::MIN).unwrap_or(0.0);
        nats(&self.all) - nats(&self.some)
    }

    /// The top of the hill that this cell is on; `None` where nobody can be.
    pub(super) fn climb(&self, cell: usize, pair: (usize, f64)) -> Option<Leaf> {
        let mut best = self.leaf(&self.all, self.pose(cell, pair), f32::MIN)?;
        let cell_m = self.horizon.cell_m;
        for step in [1.0f32, 0.5] {
            for (axis, by) in [0.5 * cell_m, 0.5 * cell_m, 0.02, 0.02].into_iter().enumerate() {
                for by in [-step * by, step * by] {
                    let mut pose = [best.x, best.y, best.heading, best.log_scale];
                    pose[axis] += by;
                    best = self.leaf(&self.all, pose, best.nats).unwrap_or(best);
                }
            }
        }
        Some(best)
    }

    /// From the reference pose to the window's end.
    pub(super) fn to_end(&self, leaf: &mut Leaf) {
        let motion: &Motion = &self.scene.to_end;
        let start = Vector3::new(f64::from(leaf.x), f64::from(leaf.y), f64::from(leaf.heading));
        let end = motion.applied_to(start, libm::exp(f64::from(leaf.log_scale)));
        (leaf.x, leaf.y, leaf.heading) = (end.x as f32, end.y as f32, wrap_angle(end.z) as f32);
    }
}

/// What the sum over `some` of `all` sightings, each scaled up to `counted`, may differ by: of samples without replacement the mean
/// has the variance σ² (1/some − 1/all).
fn sampling_nats(counted: usize, some: usize, all: usize) -> f32 {
    let apart = (1.0 / some.max(1) as f64 - 1.0 / all.max(1) as f64).max(0.0);
    (SAMPLING_SIGMAS * SIGHTING_NATS * counted as f64 * apart.sqrt()) as f32
}

/// Cells of an image next to each other.
enum Lane<'a> {
    Inside(&'a [u8; LANES]),
    /// Partly or wholly beyond the image.
    Edge([u8; LANES]),
}

impl<'a> Lane<'a> {
    /// The lane `by` cells from (column, row). Whoever is farther off the plan than the images reach sees no walls.
    #[inline(always)]
    fn of(image: &'a [u8], (width, height): (usize, usize), (column, row): (usize, usize), by: (isize, isize)) -> Self {
        let (x, y) = (column as isize + by.0, row as isize + by.1);
        if y >= 0 && y < height as isize && x >= 0 && x + LANES as isize <= width as isize {
            let at = y as usize * width + x as usize;
            if let Some(Ok(lane)) = image.get(at..at + LANES).map(TryFrom::try_from) {
                return Self::Inside(lane);
            }
        }
        let mut lane = [u8::MAX; LANES];
        if y >= 0 && y < height as isize {
            for (i, value) in lane.iter_mut().enumerate() {
                let x = x + i as isize;
                if x >= 0 && x < width as isize {
                    *value = image[y as usize * width + x as usize];
                }
            }
        }
        Self::Edge(lane)
    }

    #[inline(always)]
    fn get(&self) -> &[u8; LANES] {
        match self {
            Self::Inside(lane) => lane,
            Self::Edge(lane) => lane,
        }
    }
}

/// A ray that went through a wall loses that, whatever it ends at. The loss grows with how deep it is behind.
#[inline(always)]
fn add_losses(lost: &mut [u8; LANES], wall: &[u8; LANES], ends: &[u8; LANES], test: &Test) {
    for lane in 0..LANES {
        let behind = test.low.saturating_sub(wall[lane]);
        let behind = behind.saturating_add(behind);
        let through = behind.saturating_add(behind).min(test.through);
        lost[lane] = lost[lane].saturating_add(through.max(ends[lane]));
    }
}

/// Spreads of ranges are told apart by a quarter.
const CLASSES: usize = 12;

fn sigma_of(class: usize) -> f64 {
    0.1 * libm::pow(1.25, class as f64)
}

fn class_of(sigma_m: f64) -> usize {
    (libm::log(sigma_m / 0.1) / libm::log(1.25)).round().clamp(0.0, (CLASSES - 1) as f64) as usize
}
