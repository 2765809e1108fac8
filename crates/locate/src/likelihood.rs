//! How well does a pose on the plan explain what was seen?
//!
//! Sighting (bearing, range in odometry's unit) × scale ──▶ end point and the air before it ──▶ nats a sighting
//!
//! A sighting is one of three things: a point on a drawn wall (normal in the end point's distance to the nearest wall,
//! Thrun, Burgard & Fox 2005, §6.4), a point on something that nobody drew (anywhere before the wall), or a mistake
//! (its ray goes through a wall). The densities are per unit of *measured* range: a particle's scale s stretches the
//! measurement, so each sighting counts ln s. Without that term a tiny scale explains everything as clutter near the
//! camera, and scale collapses.
//! Pitfall: sightings of one view are not independent; the sum is tempered.

use planwalk_types::{Sighting, Stamp, Step};

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
    /// Length over which clutter and mistakes are spread, metres: about the depth of a room.
    pub spread_m: f64,
    /// Exponent of the likelihood: the share of a sighting that is independent of its neighbours.
    pub temper: f64,
    /// Most sightings that one update uses.
    pub rays: usize,
}

impl Default for SightingModel {
    fn default() -> Self {
        Self { wall_sigma_m: 0.12, wall: 0.5, clutter: 0.47, through: 0.03, spread_m: 8.0, temper: 0.12, rays: 16 }
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
        let then = motion.then(step, share_of(step, sighting.stamp));
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

/// Widths of the tabled wall densities: from 5 cm in steps of 15 % to 3.8 m.
const SIGMAS: usize = 32;
const SIGMA_MIN_M: f32 = 0.05;
const SIGMA_STEP: f32 = 1.15;

/// The model conditioned on a grid: tables of nats by wall distance.
#[derive(Debug, Clone)]
pub(crate) struct Scorer {
    /// Nats by (sigma, distance key), of ends before a wall and of ends behind it.
    before: Vec<f32>,
    behind: Vec<f32>,
    through_nats: f32,
    furniture_nats: f32,
    wall_sigma_m: f32,
    sigma_index_per_log: f32,
}

impl Scorer {
    pub(crate) fn new(model: &SightingModel, walls: &Walls) -> Self {
        let (mut before, mut behind) = (Vec::with_capacity(SIGMAS * 256), Vec::with_capacity(SIGMAS * 256));
        let total = model.wall + model.clutter + model.through;
        for i in 0..SIGMAS {
            let sigma = f64::from(SIGMA_MIN_M) * libm::pow(f64::from(SIGMA_STEP), i as f64);
            for key in 0..256 {
                // From the centre of a wall cell half a cell is wall.
                let distance = (0.5 * f64::from(key) - 0.5).max(0.0) * f64::from(walls.cell_m());
                let wall = if key == 255 { 0.0 } else { libm::exp(-0.5 * (distance / sigma).powi(2)) / (sigma * 2.506_628) };
                let mixed = |other: f64| libm::log((model.wall * wall + other / model.spread_m) / total) as f32;
                before.push(mixed(model.clutter));
                // Furniture stands before walls, not in them. Were it allowed on both sides, the much that stands close before
                // a wall would draw every pose towards the walls ahead (by 5–15 cm on real plans).
                behind.push(mixed(model.through));
            }
        }
        Self {
            before,
            behind,
            through_nats: libm::log(model.through / model.spread_m / total) as f32,
            furniture_nats: libm::log(model.clutter / model.spread_m / total) as f32,
            wall_sigma_m: model.wall_sigma_m as f32,
            sigma_index_per_log: 1.0 / libm::logf(SIGMA_STEP),
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
                    sigma: ray.sigma as f32,
                }
            })
            .collect();
        View { scorer: self, walls, rays }
    }

    #[inline]
    fn end_nats(&self, key: u8, sigma_m: f32, behind: bool) -> f32 {
        let index = libm::logf(sigma_m / SIGMA_MIN_M) * self.sigma_index_per_log;
        let row = (index.max(0.0) as usize).min(SIGMAS - 1);
        let table = if behind { &self.behind } else { &self.before };
        table[row * 256 + usize::from(key)]
    }
}

#[derive(Debug, Clone, Copy)]
struct ViewRay {
    from: (f32, f32),
    direction: (f32, f32),
    range: f32,
    sigma: f32,
}

/// One update's rays, ready to be scored from any pose.
#[derive(Debug)]
pub(crate) struct View<'a> {
    scorer: &'a Scorer,
    walls: &'a Walls,
    rays: Vec<ViewRay>,
}

enum Fate {
    Through,
    /// At this distance from a wall, before or (a little) behind it.
    Ends {
        key: u8,
        sigma_m: f32,
        behind: bool,
    },
}

impl View<'_> {
    pub(crate) fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    #[inline]
    fn fate(&self, ray: &ViewRay, x: f32, y: f32, (s, c): (f32, f32), scale: f32) -> Fate {
        let turned = |(a, b): (f32, f32)| (c * a - s * b, s * a + c * b);
        let (from, direction) = (turned(ray.from), turned(ray.direction));
        let (x, y) = (x + scale * from.0, y + scale * from.1);
        let range = scale * ray.range;
        let sigma_m = (self.scorer.wall_sigma_m * self.scorer.wall_sigma_m + scale * scale * ray.sigma * ray.sigma).sqrt();
        let met = self.walls.cast(x, y, direction.0, direction.1, range);
        // The last 2.5 σ are not air for sure.
        if met < range - 2.5 * sigma_m - self.walls.cell_m() {
            return Fate::Through;
        }
        let key = self.walls.wall_distance_key(x + range * direction.0, y + range * direction.1);
        Fate::Ends { key, sigma_m, behind: met < range }
    }

    /// Nats of all rays together from this pose, not tempered.
    #[inline]
    pub(crate) fn nats(&self, x: f32, y: f32, heading: f32, log_scale: f32) -> f32 {
        let scale = libm::expf(log_scale);
        let turn = libm::sincosf(heading);
        let mut sum = self.rays.len() as f32 * log_scale;
        for ray in &self.rays {
            sum += match self.fate(ray, x, y, turn, scale) {
                Fate::Through => self.scorer.through_nats,
                Fate::Ends { key, sigma_m, behind } => self.scorer.end_nats(key, sigma_m, behind),
            };
        }
        sum
    }

    /// What this pose makes of the rays, as shares.
    pub(crate) fn explain(&self, x: f32, y: f32, heading: f32, log_scale: f32) -> Explained {
        let count = self.rays.len().max(1) as f64;
        let scale = libm::expf(log_scale);
        let turn = libm::sincosf(heading);
        let furniture = f64::from(self.scorer.furniture_nats) + f64::from(log_scale);
        let gain_nats = f64::from(self.nats(x, y, heading, log_scale)) / count - furniture;
        let mut explained = Explained { gain_nats, ..Explained::default() };
        for ray in &self.rays {
            match self.fate(ray, x, y, turn, scale) {
                Fate::Through => explained.through += 1.0 / count,
                Fate::Ends { key, sigma_m, .. } => {
                    let distance = (0.5 * f32::from(key) - 0.5) * self.walls.cell_m();
                    explained.on_wall += if key < 255 && distance < 2.0 * sigma_m { 1.0 / count } else { 0.0 };
                }
            }
        }
        explained
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::GroundCosts;
    use nalgebra::Matrix3;
    use planwalk_types::{FloorPlan, Pt2, Wall};

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
        let rays = pending.take(8, &Motion::none().then(&step, 1.0));
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
}
