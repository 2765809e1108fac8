//! How well does a pose on the plan explain what was seen?
//!
//! Sighting (bearing, range in odometry's unit) × scale ──▶ end point and the air before it ──▶ nats a sighting
//!
//! A sighting is one of three things: a point on a drawn wall (normal in the end point's distance to the nearest wall,
//! Thrun, Burgard & Fox 2005, §6.4), a point on something that nobody drew (anywhere before the wall), or a mistake
//! (its ray goes through a wall). The densities are per unit of *measured* range: a particle's scale s stretches the
//! measurement, so each sighting counts ln s. Without that term a tiny scale explains everything as clutter near the
//! camera, and scale collapses.
//! A ray may end at a doorway or a window as at a wall (a shut leaf, a frame, a blind), or go on through it at a small cost.
//! Pitfall: sightings of one view are not independent; the sum is tempered.

use planwalk_types::{Sighting, Stamp, Step};

use crate::approx;
use crate::cast::{self, BLOCK, Rays};
use crate::motion::Motion;
use crate::walls::Walls;

/// The mixture for one sighting. Weights are relative to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightingModel {
    /// Standard deviation that is added to the sighting's own, metres: walls stand some centimetres off the plan.
    pub wall_sigma_m: f64,
    /// Weight of a point on a drawn wall.
    pub wall: f64,
    /// Weight of a point on something that nobody drew, before the wall.
    pub clutter: f64,
    /// Weight of a point behind a wall.
    pub through: f64,
    /// Share of the rays towards a doorway or window that go on through it: the door is open, the glass clear.
    pub through_opening: f64,
    /// Length over which clutter and mistakes are spread, metres: about the depth of a room.
    pub spread_m: f64,
    /// Exponent of the likelihood: the share of a sighting that is independent of its neighbours.
    pub temper: f64,
    /// Most sightings that one update uses.
    pub rays: usize,
}

impl Default for SightingModel {
    fn default() -> Self {
        Self { wall_sigma_m: 0.12, wall: 0.5, clutter: 0.47, through: 0.03, through_opening: 0.5, spread_m: 8.0, temper: 0.12, rays: 16 }
    }
}

/// A sighting in the body frame of some moment, odometry's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ray {
    /// Where the camera was.
    pub from: (f64, f64),
    /// What it saw.
    pub to: (f64, f64),
    /// Standard deviation of the range.
    pub sigma: f64,
}

/// Sightings since the last update, as rays in the body frame of that update. Bounded: see [`Pending::LIMIT`].
#[derive(Debug, Clone, Default)]
pub(crate) struct Pending {
    rays: Vec<Ray>,
}

impl Pending {
    /// More than any update uses; a camera that stands and looks must not fill the memory.
    const LIMIT: usize = 1024;

    pub(crate) fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// Adds a sighting that was made during `step`, before which the body had moved by `motion`.
    pub(crate) fn add(&mut self, sighting: &Sighting, motion: &Motion, step: &Step) {
        let usable = sighting.bearing_rad.is_finite() && sighting.range.is_finite() && sighting.range > 0.0;
        if !(usable && sighting.sigma.is_finite() && sighting.sigma >= 0.0) {
            return;
        }
        let then = motion.then(&Motion::of(step, share_of(step, sighting.stamp)));
        let (s, c) = libm::sincos(sighting.bearing_rad);
        let from = (then.forward, then.left);
        let to = then.start_from_end(sighting.range * c, sighting.range * s);
        self.rays.push(Ray { from, to, sigma: sighting.sigma });
        if self.rays.len() > Self::LIMIT {
            let mut index = 0;
            self.rays.retain(|_| {
                index += 1;
                index % 2 == 0
            });
        }
    }

    /// At most `count` of the rays, spread evenly over time and view, in the body frame at the end of `motion`.
    pub(crate) fn take(&mut self, count: usize, motion: &Motion) -> Vec<Ray> {
        let have = self.rays.len();
        let take = have.min(count);
        let chosen = (0..take).map(|i| self.rays[(2 * i + 1) * have / (2 * take)]);
        let moved = chosen
            .map(|ray| Ray { from: motion.end_from_start(ray.from.0, ray.from.1), to: motion.end_from_start(ray.to.0, ray.to.1), ..ray })
            .collect();
        self.rays.clear();
        moved
    }
}

/// How much of the step had passed at this moment, 0..=1.
fn share_of(step: &Step, stamp: Stamp) -> f64 {
    let whole = step.to.secs_since(step.from);
    if whole > 0.0 { (stamp.secs_since(step.from) / whole).clamp(0.0, 1.0) } else { 1.0 }
}

/// What a pose makes of the rays.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Explained {
    /// Mean log-likelihood of a ray over that of its being furniture, nats, not tempered.
    pub gain_nats: f64,
    /// Rays that end at a drawn wall, after nothing but air.
    pub on_wall: f64,
    /// Rays that go through a wall.
    pub through: f64,
}

/// Widths of the tabled wall densities: rows of variance, four an octave, from (5 cm)² to (3.8 m)². The upper bits of an f32 are
/// such a scale: its exponent, and the first two bits after the leading one.
const ROWS: u32 = 50;
const ROW_SHIFT: u32 = 21;
const VARIANCE_MIN_M2: f32 = 0.0025;

/// Which row tables this variance.
#[inline(always)]
fn row_of(variance_m2: f32) -> u32 {
    let row = ((variance_m2.to_bits() >> ROW_SHIFT) as i32).wrapping_sub((VARIANCE_MIN_M2.to_bits() >> ROW_SHIFT) as i32);
    let row = if row > 0 { row } else { 0 };
    (if row < ROWS as i32 { row } else { ROWS as i32 - 1 }) as u32
}

/// The standard deviation in the middle of a row, metres.
fn sigma_of(row: u32) -> f64 {
    let middle = (((VARIANCE_MIN_M2.to_bits() >> ROW_SHIFT) + row) << ROW_SHIFT) | 1 << (ROW_SHIFT - 1);
    f64::from(f32::from_bits(middle)).sqrt()
}

/// The model conditioned on a grid: tables of nats by wall distance.
#[derive(Debug, Clone)]
pub(crate) struct Scorer {
    /// Nats by (row of variance, before or behind a wall, distance key).
    ends: Vec<f32>,
    /// For each row of variance, the last cells of a ray that are not air for sure: 2.5 σ and a cell.
    unsure_cells: Vec<f32>,
    through_nats: f32,
    opening_nats: f32,
    furniture_nats: f32,
    wall_variance_m2: f32,
}

impl Scorer {
    pub(crate) fn new(model: &SightingModel, walls: &Walls) -> Self {
        let (mut ends, mut unsure_cells) = (Vec::with_capacity(ROWS as usize * 512), Vec::with_capacity(ROWS as usize));
        let total = model.wall + model.clutter + model.through;
        let cell_m = f64::from(walls.cell_m());
        for row in 0..ROWS {
            let sigma = sigma_of(row);
            unsure_cells.push((2.5 * sigma / cell_m + 1.0) as f32);
            // Furniture stands before walls, not in them. Were it allowed on both sides, the much that stands close before
            // a wall would draw every pose towards the walls ahead (by 5–15 cm on real plans).
            for other in [model.clutter, model.through] {
                for key in 0..256 {
                    // From the centre of a wall cell half a cell is wall.
                    let distance = (0.5 * f64::from(key) - 0.5).max(0.0) * cell_m;
                    let wall = if key == 255 { 0.0 } else { libm::exp(-0.5 * (distance / sigma).powi(2)) / (sigma * 2.506_628) };
                    ends.push(libm::log((model.wall * wall + other / model.spread_m) / total) as f32);
                }
            }
        }
        Self {
            ends,
            unsure_cells,
            through_nats: libm::log(model.through / model.spread_m / total) as f32,
            opening_nats: libm::log(model.through_opening.clamp(1e-9, 1.0)) as f32,
            furniture_nats: libm::log(model.clutter / model.spread_m / total) as f32,
            wall_variance_m2: (model.wall_sigma_m * model.wall_sigma_m) as f32,
        }
    }

    /// Conditions the score on one update's rays.
    pub(crate) fn on<'a>(&'a self, walls: &'a Walls, rays: &[Ray]) -> View<'a> {
        let rays = rays
            .iter()
            .map(|ray| {
                let (dx, dy) = (ray.to.0 - ray.from.0, ray.to.1 - ray.from.1);
                let range = dx.hypot(dy).max(1e-9);
                ViewRay {
                    from: (ray.from.0 as f32, ray.from.1 as f32),
                    direction: ((dx / range) as f32, (dy / range) as f32),
                    range: range as f32,
                    variance: (ray.sigma * ray.sigma) as f32,
                }
            })
            .collect();
        View { scorer: self, walls, rays }
    }

    /// What a ray that has stopped says.
    #[inline(always)]
    fn fate(&self, walls: &Walls, ray: &mut cast::Ray, limit: f32, row: u32, end_cell: u32) -> Fate {
        let sure = limit - self.unsure_cells[row as usize];
        let passed = walls.see_through(ray, sure);
        let through = ray.has_met() & (ray.along < sure);
        let key = walls.key(end_cell);
        let end = self.ends[row as usize * 512 + usize::from(ray.has_met()) * 256 + usize::from(key)];
        let nats = if through { self.through_nats } else { end + self.opening_nats * passed as f32 };
        Fate { nats, through, key, row }
    }
}

#[derive(Debug, Clone, Copy)]
struct ViewRay {
    from: (f32, f32),
    direction: (f32, f32),
    range: f32,
    variance: f32,
}

/// One update's rays, ready to be scored from any pose.
#[derive(Debug)]
pub(crate) struct View<'a> {
    scorer: &'a Scorer,
    walls: &'a Walls,
    rays: Vec<ViewRay>,
}

struct Fate {
    nats: f32,
    through: bool,
    /// Distance key of the end point.
    key: u8,
    row: u32,
}

/// A ray as it lies on the plan, seen from one pose: metres.
struct Aim {
    x: f32,
    y: f32,
    dx: f32,
    dy: f32,
    range: f32,
    row: u32,
}

impl View<'_> {
    pub(crate) fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    #[inline(always)]
    fn aim(&self, ray: &ViewRay, x: f32, y: f32, (s, c): (f32, f32), scale: f32) -> Aim {
        let turned = |(a, b): (f32, f32)| (c * a - s * b, s * a + c * b);
        let (from, (dx, dy)) = (turned(ray.from), turned(ray.direction));
        let row = row_of(self.scorer.wall_variance_m2 + scale * scale * ray.variance);
        Aim { x: x + scale * from.0, y: y + scale * from.1, dx, dy, range: scale * ray.range, row }
    }

    #[inline(always)]
    fn end_cell(&self, aim: &Aim) -> u32 {
        self.walls.cell_or_beyond(aim.x + aim.range * aim.dx, aim.y + aim.range * aim.dy)
    }

    fn fate(&self, ray: &ViewRay, x: f32, y: f32, turn: (f32, f32), scale: f32) -> Fate {
        let aim = self.aim(ray, x, y, turn, scale);
        let mut cast = self.walls.ray(aim.x, aim.y, aim.dx, aim.dy, aim.range);
        self.walls.run(&mut cast);
        self.scorer.fate(self.walls, &mut cast, aim.range * self.walls.per_m, aim.row, self.end_cell(&aim))
    }

    /// Nats of all rays together from this pose, not tempered: what [`View::add_nats`] must come to.
    #[cfg(test)]
    pub(crate) fn nats(&self, x: f32, y: f32, heading: f32, log_scale: f32) -> f32 {
        let (scale, turn) = (approx::exp(log_scale), approx::sin_cos(heading));
        let sum = self.rays.len() as f32 * log_scale;
        self.rays.iter().fold(sum, |sum, ray| sum + self.fate(ray, x, y, turn, scale).nats)
    }

    /// Nats of all rays together from this pose, not tempered; `None` where that is below `floor`. No ray is worth more than its end would be after nothing but air;
    /// from that sum the rays are cast one by one until it is decided.
    pub(crate) fn nats_at_least(&self, x: f32, y: f32, heading: f32, log_scale: f32, floor: f32) -> Option<f32> {
        let (scale, turn) = (approx::exp(log_scale), approx::sin_cos(heading));
        let best = |ray: &ViewRay| {
            let aim = self.aim(ray, x, y, turn, scale);
            self.scorer.ends[aim.row as usize * 512 + usize::from(self.walls.key(self.end_cell(&aim)))]
        };
        let mut sum = self.rays.iter().fold(self.rays.len() as f32 * log_scale, |sum, ray| sum + best(ray));
        for ray in &self.rays {
            if sum < floor {
                return None;
            }
            sum += self.fate(ray, x, y, turn, scale).nats - best(ray);
        }
        (sum >= floor).then_some(sum)
    }

    /// Adds `temper` times the nats of all rays together to `sums`, for at most [`BLOCK`] poses at once.
    #[inline(always)]
    pub(crate) fn add_nats(&self, xs: &[f32], ys: &[f32], headings: &[f32], log_scales: &[f32], temper: f32, sums: &mut [f32]) {
        let count = sums.len().min(BLOCK);
        let (xs, ys, headings, log_scales) = (&xs[..count], &ys[..count], &headings[..count], &log_scales[..count]);
        let (mut scale, mut sin, mut cos, mut nats) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        for i in 0..count {
            (sin[i], cos[i]) = approx::sin_cos(headings[i]);
            scale[i] = approx::exp(log_scales[i]);
            nats[i] = self.rays.len() as f32 * log_scales[i];
        }
        let mut rays = Rays::new();
        let (mut row, mut end_cell, mut limit, mut along) = ([0; BLOCK], [0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
        let mut casts = [cast::Ray::default(); BLOCK];
        for ray in &self.rays {
            for i in 0..count {
                let aim = self.aim(ray, xs[i], ys[i], (sin[i], cos[i]), scale[i]);
                rays.set(i, self.walls.ray(aim.x, aim.y, aim.dx, aim.dy, aim.range));
                (row[i], end_cell[i], limit[i]) = (aim.row, self.end_cell(&aim), aim.range * self.walls.per_m);
            }
            (0..count).for_each(|i| casts[i] = rays.get(i));
            self.walls.run_all(&mut rays, count, &mut along);
            for i in 0..count {
                casts[i].along = along[i];
                nats[i] += self.scorer.fate(self.walls, &mut casts[i], limit[i], row[i], end_cell[i]).nats;
            }
        }
        sums.iter_mut().zip(&nats).for_each(|(sum, nats)| *sum += temper * nats);
    }

    /// What this pose makes of the rays, as shares.
    pub(crate) fn explain(&self, x: f32, y: f32, heading: f32, log_scale: f32) -> Explained {
        let count = self.rays.len().max(1) as f64;
        let (scale, turn) = (approx::exp(log_scale), approx::sin_cos(heading));
        let furniture = f64::from(self.scorer.furniture_nats) + f64::from(log_scale);
        let mut nats = self.rays.len() as f32 * log_scale;
        let mut explained = Explained::default();
        for ray in &self.rays {
            let fate = self.fate(ray, x, y, turn, scale);
            nats += fate.nats;
            let distance = f64::from(0.5 * f32::from(fate.key) - 0.5) * f64::from(self.walls.cell_m());
            let on_wall = !fate.through && fate.key < 255 && distance < 2.0 * sigma_of(fate.row);
            explained.through += f64::from(u8::from(fate.through)) / count;
            explained.on_wall += f64::from(u8::from(on_wall)) / count;
        }
        explained.gain_nats = f64::from(nats) / count - furniture;
        explained
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::GroundCosts;
    use nalgebra::Matrix3;
    use planwalk_types::{Cell, FloorPlan, Pt2, Wall};

    /// A room of 8 m × 4 m; local coordinates begin 2 m outside.
    fn room() -> Walls {
        let wall = |x0: f64, y0: f64, x1: f64, y1: f64| Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) };
        let walls = [wall(0.0, 0.0, 8.0, 0.0), wall(8.0, 0.0, 8.0, 4.0), wall(8.0, 4.0, 0.0, 4.0), wall(0.0, 4.0, 0.0, 0.0)];
        Walls::new(&FloorPlan::from_walls(&walls, 0.05, 2.0).unwrap(), GroundCosts::default())
    }

    /// What is seen from (4, 2) in the grid, looking along x: the walls around, in units of half a metre.
    fn seen(walls: &Walls) -> Vec<Ray> {
        (-6..=6)
            .map(|i| {
                let (s, c) = libm::sincos(f64::from(i) * 0.1);
                let range = 2.0 * f64::from(walls.cast(4.0, 4.0, c as f32, s as f32, 20.0));
                Ray { from: (0.0, 0.0), to: (range * c, range * s), sigma: 0.08 }
            })
            .collect()
    }

    #[test]
    fn the_true_pose_and_scale_explain_best() {
        let walls = room();
        let scorer = Scorer::new(&SightingModel::default(), &walls);
        let rays = seen(&walls);
        let view = scorer.on(&walls, &rays);
        let truth = view.nats(4.0, 4.0, 0.0, libm::logf(0.5));
        let others = [
            (4.5, 4.0, 0.0, 0.5),
            (4.0, 4.0, 0.3, 0.5),
            (4.0, 4.0, 3.1, 0.5),
            (4.0, 4.0, 0.0, 0.35),
            (4.0, 4.0, 0.0, 0.7),
            (1.0, 1.0, 0.0, 0.5),
        ];
        for (x, y, heading, scale) in others {
            let other = view.nats(x, y, heading, libm::logf(scale));
            assert!(other < truth - 1.0, "({x}, {y}, {heading}) at {scale}: {other} against {truth} nats");
        }
        let explained = view.explain(4.0, 4.0, 0.0, libm::logf(0.5));
        assert!(explained.on_wall > 0.99 && explained.through < 0.01, "{explained:?}");
    }

    #[test]
    fn a_tiny_scale_does_not_explain_everything_as_clutter() {
        let walls = room();
        let scorer = Scorer::new(&SightingModel::default(), &walls);
        let rays = seen(&walls);
        let view = scorer.on(&walls, &rays);
        let nats = |scale: f32| view.nats(4.0, 4.0, 0.0, libm::logf(scale));
        assert!(nats(0.05) < nats(0.2) && nats(0.2) < nats(0.5), "{} {} {}", nats(0.05), nats(0.2), nats(0.5));
    }

    #[test]
    fn sightings_wait_in_the_frame_of_the_last_update() {
        let step =
            Step { from: Stamp(0), to: Stamp(100), forward: 1.0, left: 0.0, turn_rad: 0.5, covariance: Matrix3::zeros(), unit_change: 0.0 };
        let mut pending = Pending::default();
        pending.add(&Sighting { stamp: Stamp(100), bearing_rad: 0.3, range: 2.0, sigma: 0.1 }, &Motion::none(), &step);
        let rays = pending.take(8, &Motion::of(&step, 1.0));
        let (s, c) = libm::sincos(0.3);
        // Seen at the step's end, it comes back unchanged there.
        assert!((rays[0].to.0 - 2.0 * c).abs() < 1e-12 && (rays[0].to.1 - 2.0 * s).abs() < 1e-12, "{rays:?}");
        assert!(pending.take(8, &Motion::none()).is_empty(), "each sighting counts once");
    }

    #[test]
    fn broken_sightings_are_left_out_and_many_are_thinned() {
        let step =
            Step { from: Stamp(0), to: Stamp(100), forward: 0.0, left: 0.0, turn_rad: 0.0, covariance: Matrix3::zeros(), unit_change: 0.0 };
        let mut pending = Pending::default();
        for range in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
            pending.add(&Sighting { stamp: Stamp(50), bearing_rad: 0.0, range, sigma: 0.1 }, &Motion::none(), &step);
        }
        assert!(pending.rays.is_empty());
        for _ in 0..5000 {
            pending.add(&Sighting { stamp: Stamp(50), bearing_rad: 0.0, range: 1.0, sigma: 0.1 }, &Motion::none(), &step);
        }
        assert!(pending.rays.len() <= Pending::LIMIT);
        assert_eq!(pending.take(16, &Motion::none()).len(), 16);
    }

    /// A wall across the room at x = 6 in the grid, of which the middle third is `opening`; 10 cm cells, 12 m × 6 m.
    fn divided(opening: Cell) -> Walls {
        let cell = |index: usize| match (index % 120, index / 120) {
            (0 | 119, _) | (_, 0 | 59) => Cell::Wall,
            (60, 20..40) => opening,
            (60, _) => Cell::Wall,
            _ => Cell::Free,
        };
        let plan = FloorPlan::new(Pt2::new(0.0, 0.0), 0.1, 120, 60, (0..7200).map(cell).collect()).unwrap();
        Walls::new(&plan, GroundCosts::default())
    }

    /// Nats and shares of one ray of this length from (3, 3) along x.
    fn of_ray(opening: Cell, range: f64) -> (f64, Explained) {
        let walls = divided(opening);
        let scorer = Scorer::new(&SightingModel::default(), &walls);
        let view = scorer.on(&walls, &[Ray { from: (0.0, 0.0), to: (range, 0.0), sigma: 0.05 }]);
        (f64::from(view.nats(3.0, 3.0, 0.0, 0.0)), view.explain(3.0, 3.0, 0.0, 0.0))
    }

    #[test]
    fn doors_and_windows_are_seen_or_seen_through() {
        let (on_wall, behind_wall, free) = (of_ray(Cell::Wall, 3.05), of_ray(Cell::Wall, 8.9), of_ray(Cell::Free, 8.9));
        assert!(behind_wall.1.through > 0.99 && free.1.on_wall > 0.99);
        for opening in [Cell::Door, Cell::Window] {
            // A shut leaf, a blind: what ends there is explained as at a wall.
            let seen = of_ray(opening, 3.05);
            assert!((seen.0 - on_wall.0).abs() < 0.1 && seen.1.on_wall > 0.99, "{opening:?}: {} for {}", seen.0, on_wall.0);
            // Open, or clear: what is behind is explained at the cost of a half.
            let seen_through = of_ray(opening, 8.9);
            let cost = SightingModel::default().through_opening.ln();
            assert!((seen_through.0 - free.0 - cost).abs() < 1e-3, "{opening:?}: {} for {}", seen_through.0, free.0);
            assert!(seen_through.1.through < 0.01 && seen_through.1.on_wall > 0.99);
        }
    }

    #[test]
    fn how_often_doors_are_open_matters() {
        let walls = divided(Cell::Door);
        let nats = |through_opening: f64| {
            let scorer = Scorer::new(&SightingModel { through_opening, ..SightingModel::default() }, &walls);
            let ray = Ray { from: (0.0, 0.0), to: (8.9, 0.0), sigma: 0.05 };
            scorer.on(&walls, &[ray]).nats(3.0, 3.0, 0.0, 0.0)
        };
        assert!(nats(0.9) > nats(0.1) + 2.0);
    }

    #[test]
    fn many_poses_at_once_score_as_each_alone() {
        for walls in [room(), divided(Cell::Door), divided(Cell::Window)] {
            let scorer = Scorer::new(&SightingModel::default(), &walls);
            let view_rays = seen(&room());
            let view = scorer.on(&walls, &view_rays);
            let pose = |i: usize| (0.1 * i as f32 - 1.0, 3.0 + 2.0 * libm::sinf(i as f32), 0.7 * i as f32 - 40.0, 0.01 * i as f32 - 1.2);
            let poses: Vec<_> = (0..BLOCK - 3).map(pose).collect();
            let of = |f: fn(&(f32, f32, f32, f32)) -> f32| poses.iter().map(f).collect::<Vec<f32>>();
            let mut sums = vec![0.25; poses.len()];
            view.add_nats(&of(|p| p.0), &of(|p| p.1), &of(|p| p.2), &of(|p| p.3), 0.5, &mut sums);
            for (sum, (x, y, heading, log_scale)) in sums.iter().zip(&poses) {
                assert_eq!(*sum, 0.25 + 0.5 * view.nats(*x, *y, *heading, *log_scale), "at ({x}, {y})");
            }
        }
    }

    #[test]
    fn tabled_spreads_are_those_asked_for() {
        for sigma in [0.05f32, 0.12, 0.3, 1.0, 3.0] {
            // Four rows an octave of variance: the middle of a row is at most 12.5 % of variance off.
            let off = sigma_of(row_of(sigma * sigma)) / f64::from(sigma) - 1.0;
            assert!(off.abs() < 0.07, "{sigma} m is tabled {off} off");
        }
        assert_eq!([row_of(0.0), row_of(f32::INFINITY), row_of(f32::NAN)], [0, ROWS - 1, ROWS - 1]);
    }
}
