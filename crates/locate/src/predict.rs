//! How does a cloud take one update: each particle moves, and pays for walls, ground and what it does not explain?
//!
//! particles × motion ──draw──▶ moved ──walls, ground, sightings──▶ nats a particle
//!
//! The inner loop of the filter. Work is cut into chunks with a stream of chance each.

use planwalk_types::Seed;
use rayon::prelude::*;

use crate::filter::LocateOptions;
use crate::likelihood::View;
use crate::motion::{Motion, MoveSampler};
use crate::particles::{CHUNK, Particles, wrapped};
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
    let sampler = MoveSampler::new(motion, &options.noise_floor, options.scale.metres_per_unit);
    let leak_nats = libm::log(options.leak.clamp(1e-9, 1.0)) as f32;
    let temper = options.sightings.temper as f32;
    let poses = (cloud.x.par_chunks_mut(CHUNK), cloud.y.par_chunks_mut(CHUNK), cloud.heading.par_chunks_mut(CHUNK));
    let (log_scales, weights) = (cloud.log_scale.par_chunks(CHUNK), cloud.weight.par_chunks(CHUNK));
    let empty = Survival::new(&options.scale);
    let chunks: Vec<Survival> = (poses.0, poses.1, poses.2, log_scales, weights, cloud.log_weight.par_chunks_mut(CHUNK))
        .into_par_iter()
        .enumerate()
        .map(|(chunk, (xs, ys, headings, log_scales, weights, log_weights))| {
            let mut rng = seed.derive("move", chunk as u64);
            let mut survival = empty.clone();
            for i in 0..xs.len() {
                let [forward, left, turn] = sampler.draw(&mut rng);
                let scale = libm::expf(log_scales[i]);
                let (s, c) = libm::sincosf(headings[i]);
                let (dx, dy) = (scale * (c * forward - s * left), scale * (s * forward + c * left));
                let (x, y) = (xs[i] + dx, ys[i] + dy);
                let mut nats = walls.crossings(xs[i], ys[i], x, y) as f32 * leak_nats;
                nats -= walls.ground_cost(x, y, (dx * dx + dy * dy).sqrt());
                (xs[i], ys[i], headings[i]) = (x, y, wrapped(headings[i] + turn));
                survival.add(log_scales[i], weights[i], nats);
                if !view.is_empty() {
                    nats += temper * view.nats(x, y, headings[i], log_scales[i]);
                }
                log_weights[i] += nats;
            }
            survival
        })
        .collect();
    chunks.iter().fold(empty.clone(), |sum, chunk| sum.with(chunk))
}
