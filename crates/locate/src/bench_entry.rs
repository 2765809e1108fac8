//! What do benches run? The filter's core alone: odometry and walls, then resampling where it is needed. No public promise.

use nalgebra::Matrix3;
use planwalk_types::{FloorPlan, PlanError, Pt2, Seed, Stamp, Step, Wall};

use crate::filter::LocateOptions;
use crate::likelihood::{Ray, Scorer};
use crate::motion::Motion;
use crate::particles::{Particles, Roughening};
use crate::predict::predict_and_weigh;
use crate::prior::{self, ScalePrior};
use crate::walls::Walls;

/// An office building of 100 m × 60 m on a grid of 5 cm: corridors between rows of rooms of different widths, with doorways.
///
/// # Errors
/// None: the walls are drawn from constants, and are a plan.
pub fn office() -> Result<FloorPlan, PlanError> {
    let mut walls = Vec::new();
    let mut wall = |x0: f64, y0: f64, x1: f64, y1: f64| walls.push(Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) });
    for (from, to) in [((0.0, 0.0), (100.0, 0.0)), ((100.0, 0.0), (100.0, 60.0)), ((100.0, 60.0), (0.0, 60.0)), ((0.0, 60.0), (0.0, 0.0))] {
        wall(from.0, from.1, to.0, to.1);
    }
    // Five corridors of 2 m; rooms of 5 m depth on both sides.
    for block in 0..5 {
        let corridor = 5.0 + 12.0 * f64::from(block);
        for (side, (y, depth)) in [(corridor, -5.0), (corridor + 2.0, 5.0)].into_iter().enumerate() {
            let mut x: f64 = 0.0;
            let mut room = block * 7 + side as i32 * 3;
            while x < 100.0 {
                let width: f64 = [3.0, 4.5, 3.6, 6.0, 2.8][(room % 5) as usize];
                let end = (x + width).min(100.0);
                wall(x, y, x + 0.4, y);
                wall((x + 1.3).min(end), y, end, y);
                wall(end, y, end, y + depth);
                (x, room) = (end, room + 1);
            }
        }
        if block > 0 {
            let y = corridor - 5.0;
            wall(0.0, y, 49.0, y);
            wall(51.0, y, 100.0, y);
        }
    }
    FloorPlan::from_walls(&walls, 0.05, 0.5)
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
        let motion = Motion::none().then(&step, 1.0);
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
