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
use crate::cast::BLOCK;
use crate::chance::Chance;
use crate::drift::UNIT_RAD;
use crate::likelihood::View;
use crate::motion::{Motion, MoveSampler};
use crate::options::LocateOptions;
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
        // Who jumped went another way, and met no wall on this one.
        leak_nats: if motion.is_jump() { 0.0 } else { libm::log(options.leak.clamp(1e-9, 1.0)) as f32 },
        drift_rad: UNIT_RAD * motion.length as f32,
    };
    let update = Update { mover, view, temper: options.sightings.temper as f32 };
    let poses = (cloud.x.par_chunks_mut(CHUNK), cloud.y.par_chunks_mut(CHUNK), cloud.heading.par_chunks_mut(CHUNK));
    let (log_scales, weights) = (cloud.log_scale.par_chunks(CHUNK), cloud.weight.par_chunks(CHUNK));
    let drifts = cloud.drift.par_chunks(CHUNK);
    let empty = Survival::new(&options.scale);
    let chunks: Vec<Survival> = (poses.0, poses.1, poses.2, log_scales, drifts, weights, cloud.log_weight.par_chunks_mut(CHUNK))
        .into_par_iter()
        .enumerate()
        .map(|(chunk, (x, y, heading, log_scale, drift, weight, log_weight))| {
            let part = Part { first: (chunk * CHUNK) as u32, x, y, heading, log_scale, drift, weight, log_weight };
            update.apply(part, empty.clone())
        })
        .collect();
    chunks.iter().fold(empty.clone(), |sum, chunk| sum.with(chunk))
}

/// A part of the cloud, one slice an attribute.
struct Part<'a> {
    /// Index of its first particle.
    first: u32,
    x: &'a mut [f32],
    y: &'a mut [f32],
    heading: &'a mut [f32],
    log_scale: &'a [f32],
    drift: &'a [i8],
    weight: &'a [f32],
    log_weight: &'a mut [f32],
}

/// What all particles go through.
struct Update<'a> {
    mover: Mover<'a>,
    view: &'a View<'a>,
    temper: f32,
}

impl Update<'_> {
    /// Takes a part of the cloud through the update, and counts who survived.
    fn apply(&self, part: Part<'_>, survival: Survival) -> Survival {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            #[expect(unsafe_code, reason = "the processor was just asked whether it has what the function is compiled for")]
            // SAFETY: `apply_avx2` is a safe function that needs AVX2, and AVX2 is there.
            return unsafe { self.apply_avx2(part, survival) };
        }
        self.apply_anywhere(part, survival)
    }

    /// The same as [`Update::apply_anywhere`], to the last bit: eight particles at a time where SSE2 takes four. (Fused
    /// multiplications would be other bits; they are not enabled.)
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn apply_avx2(&self, part: Part<'_>, survival: Survival) -> Survival {
        self.apply_anywhere(part, survival)
    }

    #[inline(always)]
    fn apply_anywhere(&self, part: Part<'_>, mut survival: Survival) -> Survival {
        let mut moved = Moved::new();
        for from in (0..part.x.len()).step_by(BLOCK) {
            let block = from..(from + BLOCK).min(part.x.len());
            let (xs, ys, headings) = (&mut part.x[block.clone()], &mut part.y[block.clone()], &mut part.heading[block.clone()]);
            let (log_scales, weights) = (&part.log_scale[block.clone()], &part.weight[block.clone()]);
            let first = part.first.wrapping_add(from as u32);
            self.mover.step(first, (&mut *xs, &mut *ys, &mut *headings), log_scales, &part.drift[block.clone()], &mut moved);
            self.mover.weigh(xs, ys, &mut moved);
            let nats = &mut moved.nats[..xs.len()];
            survival.add_block(log_scales, weights, nats);
            if !self.view.is_empty() {
                self.view.add_nats(xs, ys, headings, log_scales, self.temper, nats);
            }
            part.log_weight[block].iter_mut().zip(nats).for_each(|(sum, nats)| *sum += *nats);
        }
        survival
    }
}

/// A motion, conditioned for the whole cloud.
struct Mover<'a> {
    sampler: MoveSampler,
    chance: Chance,
    walls: &'a Walls,
    /// Nats that each entry into a wall costs (negative).
    leak_nats: f32,
    /// What a unit of drift turns over this motion, radians for a metre a unit of odometry.
    drift_rad: f32,
}

/// What a block's particles did.
struct Moved {
    from_x: [f32; BLOCK],
    from_y: [f32; BLOCK],
    turn: [f32; BLOCK],
    length_m: [f32; BLOCK],
    /// Where they came from …
    from_cell: [u32; BLOCK],
    /// … and where they arrived.
    cell: [u32; BLOCK],
    nats: [f32; BLOCK],
    near: [u8; BLOCK],
}

impl Moved {
    fn new() -> Self {
        let zeros = [0.0; BLOCK];
        Self {
            from_x: zeros,
            from_y: zeros,
            turn: zeros,
            length_m: zeros,
            from_cell: [0; BLOCK],
            cell: [0; BLOCK],
            nats: zeros,
            near: [0; BLOCK],
        }
    }
}

impl Mover<'_> {
    /// Moves a block of poses (x, y, heading) whose first particle has the index `first`.
    #[inline(always)]
    fn step(
        &self,
        first: u32,
        (xs, ys, headings): (&mut [f32], &mut [f32], &mut [f32]),
        log_scales: &[f32],
        drifts: &[i8],
        moved: &mut Moved,
    ) {
        let count = xs.len().min(BLOCK);
        let (xs, ys, headings) = (&mut xs[..count], &mut ys[..count], &mut headings[..count]);
        let (log_scales, drifts) = (&log_scales[..count], &drifts[..count]);
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
            headings[i] = approx::wrap(headings[i] + moved.turn[i] - scale * (self.drift_rad * f32::from(drifts[i])));
            moved.length_m[i] = (dx * dx + dy * dy).sqrt();
        }
        for i in 0..count {
            moved.from_cell[i] = self.walls.cell_or_beyond(moved.from_x[i], moved.from_y[i]);
            moved.cell[i] = self.walls.cell_or_beyond(xs[i], ys[i]);
        }
    }

    /// What walls and ground cost a block that has moved. Most particles arrive farther from any wall than they came: a look at
    /// where they are is enough.
    #[inline(always)]
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
            let length_m = moved.length_m[i];
            if !(length_m < 1000.0) {
                continue; // no walk: see [`Walls::met`]
            }
            let cells = [moved.from_cell[i], moved.cell[i]];
            let met = self.walls.met_on((moved.from_x[i], moved.from_y[i]), (xs[i], ys[i]), cells, length_m);
            let ground = if self.walls.is_held(moved.cell[i]) { moved.nats[i] } else { -self.walls.ground_cost(xs[i], ys[i], length_m) };
            moved.nats[i] = ground + met.walls as f32 * self.leak_nats - met.doors as f32 * self.walls.door_nats();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench_entry::office;
    use crate::likelihood::{Ray, Scorer};
    use crate::prior::{self, ScalePrior};
    use nalgebra::{Matrix3, Vector3};
    use planwalk_types::{Cell, FloorPlan, Pt2, Stamp, Step};

    fn options() -> LocateOptions {
        LocateOptions::new(Seed(1), ScalePrior { metres_per_unit: 0.9, relative_sigma: 0.2 })
    }

    fn motion() -> Motion {
        let covariance = Matrix3::from_diagonal(&Vector3::new(1e-3, 2e-3, 1e-2));
        let step = Step { from: Stamp(0), to: Stamp(1), forward: 0.6, left: 0.1, turn_rad: 0.7, covariance, unit_change: 0.0 };
        Motion::of(&step, 1.0)
    }

    fn cloud(plan: &FloorPlan, count: usize) -> Particles {
        prior::particles(&prior::cover(plan, count, Seed(2)), &options().scale, Seed(3))
    }

    /// The update of one particle as a book has it: no blocks, no short cuts, another library's functions.
    fn by_the_book(before: &Particles, i: usize, motion: &Motion, walls: &Walls, options: &LocateOptions, seed: Seed) -> [f32; 4] {
        let sampler = MoveSampler::new(motion, &options.noise_floor, options.scale.metres_per_unit);
        let [a, b, c, _] = Chance::new(seed, "move").normals(i as u32);
        let [forward, left, turn] = sampler.shape([a, b, c]);
        let scale = libm::expf(before.log_scale[i]);
        let (s, c) = libm::sincosf(before.heading[i]);
        let (dx, dy) = (scale * (c * forward - s * left), scale * (s * forward + c * left));
        let (x, y) = (before.x[i] + dx, before.y[i] + dy);
        let nats = walls.crossings_cell_by_cell(before.x[i], before.y[i], x, y) as f32 * libm::log(options.leak) as f32
            - walls.ground_cost(x, y, dx.hypot(dy));
        let drift = scale * motion.length as f32 * UNIT_RAD * f32::from(before.drift[i]);
        [x, y, before.heading[i] + turn - drift, nats]
    }

    #[test]
    fn the_fast_update_does_what_the_book_says() {
        let plan = office(100.0, 5).unwrap();
        let (options, motion, seed) = (options(), motion(), Seed(9));
        let walls = Walls::new(&plan, options.ground);
        let scorer = Scorer::new(&options.sightings, &walls);
        let mut before = cloud(&plan, 30_001);
        before.drift = (0..30_001).map(|i| (i % 256) as i8).collect();
        let mut after = before.clone();
        after.log_weight.fill(0.0);
        predict_and_weigh(&mut after, &motion, &walls, &scorer.on(&walls, &[]), &options, seed);
        let mut other = 0;
        for i in 0..before.len() {
            let [x, y, heading, nats] = by_the_book(&before, i, &motion, &walls, &options, seed);
            let turn = planwalk_types::wrap_angle(f64::from(after.heading[i]) - f64::from(heading)).abs();
            // 100 m in f32 are good to 8 µm.
            assert!((after.x[i] - x).abs().max((after.y[i] - y).abs()) < 3e-5 && turn < 1e-6, "particle {i}");
            other += usize::from(!((after.log_weight[i] - nats).abs() < 1e-4));
        }
        // A way that grazes a cell's corner by micrometres is on one side of it or the other.
        assert!(other <= 6, "{other} of 30 001 particles met other walls");
    }

    #[test]
    fn the_same_bytes_with_and_without_wide_registers() {
        let plan = office(100.0, 5).unwrap();
        let options = options();
        let walls = Walls::new(&plan, options.ground);
        let scorer = Scorer::new(&options.sightings, &walls);
        let ray = |x: f64, y: f64| Ray { from: (0.1, 0.0), to: (x, y), sigma: 0.1 };
        let view = scorer.on(&walls, &[ray(2.0, 0.3), ray(4.0, -1.0), ray(1.0, 1.5)]);
        let mover = Mover {
            sampler: MoveSampler::new(&motion(), &options.noise_floor, 0.9),
            chance: Chance::new(Seed(5), "move"),
            walls: &walls,
            leak_nats: -3.7,
            drift_rad: 0.001,
        };
        let update = Update { mover, view: &view, temper: 0.12 };
        let clouds = [true, false].map(|wide| {
            let mut cloud = cloud(&plan, 5_003);
            cloud.drift.iter_mut().enumerate().for_each(|(i, drift)| *drift = (i % 256) as i8);
            let Particles { x, y, heading, log_scale, drift, weight, log_weight } = &mut cloud;
            let part = Part { first: 0, x, y, heading, log_scale, drift, weight, log_weight };
            let survival = Survival::new(&options.scale);
            let _ = if wide { update.apply(part, survival) } else { update.apply_anywhere(part, survival) };
            [cloud.x, cloud.y, cloud.heading, cloud.log_weight].map(|values| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        });
        assert!(clouds[0] == clouds[1]);
    }

    #[test]
    fn doorways_cost_what_the_option_says() {
        // Doorways from wall to wall every metre: each walk of 0.6 m goes through at most one of them.
        let cell = |index: usize| match (index % 100, index / 100) {
            (_, 0 | 99) => Cell::Wall,
            (_, row) if row % 10 == 0 => Cell::Door,
            _ => Cell::Free,
        };
        let plan = FloorPlan::new(Pt2::new(0.0, 0.0), 0.1, 100, 100, (0..10_000).map(cell).collect()).unwrap();
        let nats = |door_nats: f64| {
            let mut options = options();
            options.ground.door_nats = door_nats;
            let walls = Walls::new(&plan, options.ground);
            let scorer = Scorer::new(&options.sightings, &walls);
            let mut cloud = cloud(&plan, 10_000);
            predict_and_weigh(&mut cloud, &motion(), &walls, &scorer.on(&walls, &[]), &options, Seed(1));
            cloud.log_weight.iter().map(|w| f64::from(*w)).sum::<f64>() / 10_000.0
        };
        // Of walks of 0.55 m (0.61 units at 0.9 m) in all directions, 0.55 · 2/π meet a line that comes every metre.
        let share = (nats(0.0) - nats(1.0)) / 1.0;
        assert!((share - 0.35).abs() < 0.07, "{share} of the walks paid");
    }
}
