//! What do benches run? The filter's core alone: odometry and walls, then resampling where it is needed. No public promise.

use nalgebra::Matrix3;
use planwalk_types::{FloorPlan, Path, PlanError, Pt2, Seed, Sighting, Stamp, Step, Wall};

use crate::likelihood::{Ray, Scorer};
use crate::motion::Motion;
use crate::options::LocateOptions;
use crate::particles::{Particles, Roughening};
use crate::predict::predict_and_weigh;
use crate::prior::{self, ScalePrior};
use crate::walls::{GroundCosts, Walls};

/// An office building of `width_m` × 12 m a block, on a grid of 5 cm: corridors between rows of rooms of different widths, with
/// doorways. The usual bench has 100 m and five blocks.
///
/// # Errors
/// [`PlanError`] for a size that is none.
pub fn office(width_m: f64, blocks: i32) -> Result<FloorPlan, PlanError> {
    let mut walls = Vec::new();
    let mut wall = |x0: f64, y0: f64, x1: f64, y1: f64| walls.push(Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) });
    let height_m = 12.0 * f64::from(blocks);
    wall(0.0, 0.0, width_m, 0.0);
    wall(width_m, 0.0, width_m, height_m);
    wall(width_m, height_m, 0.0, height_m);
    wall(0.0, height_m, 0.0, 0.0);
    // A corridor of 2 m in each block; rooms of 5 m depth on both sides.
    for block in 0..blocks {
        let corridor = 5.0 + 12.0 * f64::from(block);
        for (side, (y, depth)) in [(corridor, -5.0), (corridor + 2.0, 5.0)].into_iter().enumerate() {
            let mut x: f64 = 0.0;
            let mut room = block * 7 + side as i32 * 3;
            while x < width_m {
                let width: f64 = [3.0, 4.5, 3.6, 6.0, 2.8][(room % 5) as usize];
                let end = (x + width).min(width_m);
                wall(x, y, x + 0.4, y);
                wall((x + 1.3).min(end), y, end, y);
                wall(end, y, end, y + depth);
                (x, room) = (end, room + 1);
            }
        }
        if block > 0 {
            let y = corridor - 5.0;
            wall(0.0, y, 0.49 * width_m, y);
            wall(0.51 * width_m, y, width_m, y);
        }
    }
    FloorPlan::from_walls(&walls, 0.05, 0.5)
}

/// A walk of 8 m along the first corridor of [`office`] and what is seen on it, a third of it furniture.
pub fn corridor_walk(plan: &FloorPlan) -> (Path, Vec<Sighting>) {
    let walls = Walls::new(plan, GroundCosts::default());
    let stamp = |i: i64| Stamp(200_000_000 * i);
    let covariance = Matrix3::from_diagonal(&nalgebra::Vector3::new(4e-4, 4e-4, 3e-4));
    let (mut path, mut seen) = (Path::default(), Vec::new());
    for i in 0..48 {
        path.steps.push(Step { from: stamp(i), to: stamp(i + 1), forward: 0.2, left: 0.0, turn_rad: 0.0, covariance, unit_change: 0.0 });
        let (x, y) = (10.0 + 0.2 * i as f64 - plan.origin().x, 6.1 - plan.origin().y);
        for k in 0..24 {
            let bearing_rad = 0.05 * (f64::from(k) - 11.5);
            let (s, c) = libm::sincos(bearing_rad);
            let short = if (k + i as i32) % 3 == 0 { 0.6 } else { 1.0 };
            let range = short * f64::from(walls.cast(x as f32, y as f32, c as f32, s as f32, 15.0));
            seen.push(Sighting { stamp: stamp(i + 1), bearing_rad, range, sigma: 0.04 * range });
        }
    }
    (path, seen)
}

/// A cloud in a plan.
pub struct Cloud {
    walls: Walls,
    scorer: Scorer,
    options: LocateOptions,
    particles: Particles,
    steps: u64,
    /// How often it was resampled.
    pub resampled: u64,
}

impl Cloud {
    /// So many particles all over the plan.
    pub fn new(plan: &FloorPlan, count: usize) -> Self {
        let options = LocateOptions::new(Seed(1), ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.1 });
        let walls = Walls::new(plan, options.ground);
        let scorer = Scorer::new(&options.sightings, &walls);
        let particles = prior::particles(&prior::cover(plan, count, options.seed), &options.scale, options.seed);
        Self { walls, scorer, options, particles, steps: 0, resampled: 0 }
    }

    /// One step of 0.25–0.7 m with a turn now and then, weighed by walls and by `rays` sightings; resamples where few carry the
    /// weight.
    pub fn step(&mut self, rays: usize) {
        let i = self.steps as f64;
        let covariance = Matrix3::from_diagonal(&nalgebra::Vector3::new(4e-4, 4e-4, 3e-4));
        let forward = 0.475 + 0.225 * libm::sin(1.7 * i);
        let turn_rad = if self.steps % 8 == 7 { 1.5 } else { 0.02 * libm::sin(2.3 * i) };
        let step = Step { from: Stamp(0), to: Stamp(1), forward, left: 0.0, turn_rad, covariance, unit_change: 0.0 };
        let motion = Motion::of(&step, 1.0);
        let seed = self.options.seed.child("step", self.steps);
        let look = |k: usize| {
            let (s, c) = libm::sincos(1.2 * ((k as f64 + 0.5) / rays as f64 - 0.5));
            let range = 1.5 + 0.7 * (k % 5) as f64;
            Ray { from: (0.0, 0.0), to: (range * c, range * s), sigma: 0.04 * range }
        };
        let rays: Vec<Ray> = (0..rays).map(look).collect();
        let view = self.scorer.on(&self.walls, &rays);
        predict_and_weigh(&mut self.particles, &motion, &self.walls, &view, &self.options, seed);
        self.particles.normalize();
        if self.particles.effective_share() < self.options.resample_below {
            self.particles.resample_systematic(self.particles.len(), seed);
            let by = Roughening { metres: 0.05, heading_rad: 0.02, log_scale: 0.01 };
            self.particles.roughen(&by, &self.options.scale, seed);
            self.resampled += 1;
        }
        self.steps += 1;
    }

    /// A number that depends on every particle.
    pub fn checksum(&self) -> f64 {
        let sum = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>();
        sum(&self.particles.x) + sum(&self.particles.heading) + sum(&self.particles.weight)
    }
}
