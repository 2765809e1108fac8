//! How does a cloud take one update: each particle moves, and pays for walls, ground and what it does not explain?
//!
//! particles × motion ──draw──▶ moved ──ground and distance where they arrive──▶ the few near a wall: what they met ──▶ sightings
//!
//! The inner loop of the filter. Threads take chunks; within one, blocks that stay in the innermost cache go through one pass
//! after the other, so that the arithmetic is SIMD and the looks into the plan overlap. Chance is a function of the particle's
//! index: chunks and blocks change nothing.

use planwalk_types::Seed;
use rayon::prelude::*;

use crate::approx;
use crate::chance::Chance;
use crate::filter::LocateOptions;
use crate::likelihood::{BLOCK, View};
use crate::motion::{Motion, MoveSampler};
use crate::particles::{CHUNK, Particles};
use crate::survival::Survival;
use crate::walls::Walls;

/// The inner loop: each particle draws its motion, and pays for walls, ground and what it does not explain.
pub(crate) fn predict_and_weigh(
    cloud: &mut Particles,
    motion: &Motion,
    walls: &Walls,
    view: &View<'_>,
    options: &LocateOptions,
    seed: Seed,
) -> Survival {
    let mover = Mover {
        sampler: MoveSampler::new(motion, &options.noise_floor, options.scale.metres_per_unit),
        chance: Chance::new(seed, "move"),
        walls,
        leak_nats: libm::log(options.leak.clamp(1e-9, 1.0)) as f32,
    };
    let temper = options.sightings.temper as f32;
    let poses = (cloud.x.par_chunks_mut(CHUNK), cloud.y.par_chunks_mut(CHUNK), cloud.heading.par_chunks_mut(CHUNK));
    let (log_scales, weights) = (cloud.log_scale.par_chunks(CHUNK), cloud.weight.par_chunks(CHUNK));
    let empty = Survival::new(&options.scale);
    let chunks: Vec<Survival> = (poses.0, poses.1, poses.2, log_scales, weights, cloud.log_weight.par_chunks_mut(CHUNK))
        .into_par_iter()
        .enumerate()
        .map(|(chunk, (xs, ys, headings, log_scales, weights, log_weights))| {
            let mut survival = empty.clone();
            let mut moved = Moved::new();
            for from in (0..xs.len()).step_by(BLOCK) {
                let block = from..(from + BLOCK).min(xs.len());
                let (xs, ys, headings) = (&mut xs[block.clone()], &mut ys[block.clone()], &mut headings[block.clone()]);
                let (log_scales, weights) = (&log_scales[block.clone()], &weights[block.clone()]);
                mover.step((chunk * CHUNK + from) as u32, xs, ys, headings, log_scales, &mut moved);
                mover.weigh(xs, ys, &mut moved);
                let nats = &mut moved.nats[..xs.len()];
                survival.add_block(log_scales, weights, nats);
                if !view.is_empty() {
                    view.add_nats(xs, ys, headings, log_scales, temper, nats);
                }
                log_weights[block].iter_mut().zip(nats).for_each(|(sum, nats)| *sum += *nats);
            }
            survival
        })
        .collect();
    chunks.iter().fold(empty.clone(), |sum, chunk| sum.with(chunk))
}

/// A motion, conditioned for the whole cloud.
struct Mover<'a> {
    sampler: MoveSampler,
    chance: Chance,
    walls: &'a Walls,
    /// Nats that each entry into a wall costs (negative).
    leak_nats: f32,
}

/// What a block's particles did.
struct Moved {
    from_x: [f32; BLOCK],
    from_y: [f32; BLOCK],
    turn: [f32; BLOCK],
    length_m: [f32; BLOCK],
    /// Where they arrived.
    cell: [u32; BLOCK],
    nats: [f32; BLOCK],
    near: [u8; BLOCK],
}

impl Moved {
    fn new() -> Self {
        let zeros = [0.0; BLOCK];
        Self { from_x: zeros, from_y: zeros, turn: zeros, length_m: zeros, cell: [0; BLOCK], nats: zeros, near: [0; BLOCK] }
    }
}

impl Mover<'_> {
    /// Moves a block whose first particle has the index `first`.
    fn step(&self, first: u32, xs: &mut [f32], ys: &mut [f32], headings: &mut [f32], log_scales: &[f32], moved: &mut Moved) {
        let count = xs.len().min(BLOCK);
        let (xs, ys, headings, log_scales) = (&mut xs[..count], &mut ys[..count], &mut headings[..count], &log_scales[..count]);
        // Two loops: one would need more registers than there are.
        for i in 0..count {
            let [a, b, c, _] = self.chance.normals(first.wrapping_add(i as u32));
            [moved.from_x[i], moved.from_y[i], moved.turn[i]] = self.sampler.shape([a, b, c]);
        }
        for i in 0..count {
            let (forward, left) = (moved.from_x[i], moved.from_y[i]);
            let scale = approx::exp(log_scales[i]);
            let (s, c) = approx::sin_cos(headings[i]);
            let (dx, dy) = (scale * (c * forward - s * left), scale * (s * forward + c * left));
            (moved.from_x[i], moved.from_y[i]) = (xs[i], ys[i]);
            (xs[i], ys[i]) = (xs[i] + dx, ys[i] + dy);
            headings[i] = approx::wrap(headings[i] + moved.turn[i]);
            moved.length_m[i] = (dx * dx + dy * dy).sqrt();
            moved.cell[i] = self.walls.cell_or_beyond(xs[i], ys[i]);
        }
    }

    /// What walls and ground cost a block that has moved. Most particles arrive farther from any wall than they came: a look at
    /// where they are is enough.
    fn weigh(&self, xs: &[f32], ys: &[f32], moved: &mut Moved) {
        let count = xs.len().min(BLOCK);
        let mut near = 0;
        for i in 0..count {
            let (cost, clear) = self.walls.arrival(moved.cell[i], moved.length_m[i]);
            moved.nats[i] = -cost;
            moved.near[near] = i as u8;
            near += usize::from(!clear);
        }
        for j in 0..near {
            let i = usize::from(moved.near[j]) % BLOCK;
            moved.nats[i] = self.nats(moved.from_x[i], moved.from_y[i], xs[i], ys[i], moved.length_m[i]);
        }
    }

    /// What walls and ground cost one particle on its way.
    fn nats(&self, x0: f32, y0: f32, x: f32, y: f32, length_m: f32) -> f32 {
        let met = self.walls.met(x0, y0, x, y);
        met.walls as f32 * self.leak_nats - met.doors as f32 * self.walls.door_nats() - self.walls.ground_cost(x, y, length_m)
    }
}
