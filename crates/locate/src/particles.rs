//! What is a cloud of guesses, and how does it forget the bad ones?
//!
//! log weights ──normalize──▶ weights ──resample_systematic──▶ equal weights, good guesses repeated ──roughen──▶ told apart again
//!
//! Structure of arrays in f32, sums in f64. Work is cut into chunks of fixed size with a stream of chance each, and sums
//! run over chunks in order: the same bytes on any number of threads.

use planwalk_types::{Seed, wrap_angle};
use rayon::prelude::*;

use crate::approx;
use crate::chance::Chance;
use crate::motion::uniform;
use crate::prior::ScalePrior;

/// Particles a chunk: some 100 kB, enough to be worth a thread's while.
pub(crate) const CHUNK: usize = 4096;

/// Poses in metres from the grid's bottom-left corner and radians, log metres per unit of odometry, weights.
#[derive(Debug, Clone, Default)]
pub(crate) struct Particles {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub heading: Vec<f32>,
    pub log_scale: Vec<f32>,
    /// By how much the odometry turns by itself, in units of [`crate::drift::UNIT_RAD`] a metre.
    pub drift: Vec<i8>,
    /// Up to a common constant.
    pub log_weight: Vec<f32>,
    /// Sums to one after [`Particles::normalize`].
    pub weight: Vec<f32>,
}

/// Standard deviations of the noise that tells copies of a particle apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Roughening {
    pub metres: f32,
    pub heading_rad: f32,
    pub log_scale: f32,
}

impl Particles {
    pub(crate) fn with_capacity(count: usize) -> Self {
        let new = || Vec::with_capacity(count);
        let drift = Vec::with_capacity(count);
        Self { x: new(), y: new(), heading: new(), log_scale: new(), drift, log_weight: new(), weight: new() }
    }

    pub(crate) fn len(&self) -> usize {
        self.x.len()
    }

    pub(crate) fn push(&mut self, x: f32, y: f32, heading: f32, log_scale: f32) {
        self.x.push(x);
        self.y.push(y);
        self.heading.push(heading);
        self.log_scale.push(log_scale);
        self.drift.push(0);
        self.log_weight.push(0.0);
        self.weight.push(0.0);
    }

    pub(crate) fn set_equal_weights(&mut self) {
        let share = 1.0 / self.len().max(1) as f32;
        self.log_weight.fill(0.0);
        self.weight.fill(share);
    }

    /// Weights from log weights.
    pub(crate) fn normalize(&mut self) {
        let maxima: Vec<f32> = self.log_weight.par_chunks(CHUNK).map(largest).collect();
        let max = largest(&maxima);
        if !max.is_finite() {
            // Every guess is impossible to f32: no guess is better than another.
            self.set_equal_weights();
            return;
        }
        let chunks = self.log_weight.par_chunks_mut(CHUNK).zip(self.weight.par_chunks_mut(CHUNK));
        let sums: Vec<f64> = chunks
            .map(|(logs, weights)| {
                for (log, weight) in logs.iter_mut().zip(weights.iter_mut()) {
                    *log -= max;
                    *weight = approx::exp(*log);
                }
                sum_of(weights, |w| w)
            })
            .collect();
        let scale = (1.0 / sums.into_iter().sum::<f64>()) as f32;
        self.weight.par_chunks_mut(CHUNK).for_each(|weights| weights.iter_mut().for_each(|w| *w *= scale));
    }

    /// Effective number of particles as a share of all (Kong, Liu & Wong 1994): 1 when all weigh the same.
    pub(crate) fn effective_share(&self) -> f64 {
        let squares: Vec<f64> = self.weight.par_chunks(CHUNK).map(|c| sum_of(c, |w| w * w)).collect();
        1.0 / (squares.into_iter().sum::<f64>() * self.len().max(1) as f64)
    }

    /// Replaces the cloud by `count` copies in proportion to weight (systematic resampling, Kitagawa 1996) and says which
    /// particle each is a copy of.
    pub(crate) fn resample_systematic(&mut self, count: usize, seed: Seed) -> Vec<u32> {
        let count = count.max(1);
        let ancestors = self.ancestors(count, uniform(&mut seed.derive("resample", 0)));
        // All weights will be equal, so the old ones' memory is free to gather into: each array makes room for the next.
        for values in [&mut self.x, &mut self.y, &mut self.heading, &mut self.log_scale] {
            let room = &mut self.log_weight;
            room.resize(count, 0.0);
            let gather = |(to, from): (&mut [f32], &[u32])| {
                to.iter_mut().zip(from).for_each(|(to, from)| *to = values.get(*from as usize).copied().unwrap_or(0.0));
            };
            room.par_chunks_mut(CHUNK).zip(ancestors.par_chunks(CHUNK)).for_each(gather);
            std::mem::swap(values, room);
        }
        self.drift = ancestors.iter().map(|from| self.drift.get(*from as usize).copied().unwrap_or(0)).collect();
        self.log_weight.resize(count, 0.0);
        self.weight.resize(count, 0.0);
        if count < self.len() / 2 {
            [&mut self.log_weight, &mut self.weight].into_iter().for_each(Vec::shrink_to_fit);
        }
        self.set_equal_weights();
        ancestors
    }

    /// For each tooth of a comb of `count` teeth over the weights, the particle that it hits. The first tooth stands `offset`
    /// (0..1) of their distance from the beginning.
    fn ancestors(&self, count: usize, offset: f64) -> Vec<u32> {
        let sums: Vec<f64> = self.weight.par_chunks(CHUNK).map(|c| sum_of(c, |w| w)).collect();
        let per_weight = count as f64 / sums.iter().sum::<f64>();
        let mut ancestors = vec![0u32; count];
        let mut teeth = Vec::with_capacity(sums.len());
        let (mut rest, mut swept, mut taken) = (ancestors.as_mut_slice(), 0.0, 0);
        for (chunk, sum) in sums.iter().enumerate() {
            let before = swept * per_weight - offset;
            swept += sum;
            // Round-off may leave the last tooth beyond the sum.
            let end = if chunk + 1 == sums.len() { count } else { teeth_up_to(swept * per_weight - offset).clamp(taken, count) };
            let (mine, later) = rest.split_at_mut(end - taken);
            teeth.push((mine, before - taken as f64));
            (rest, taken) = (later, end);
        }
        teeth.into_par_iter().zip(self.weight.par_chunks(CHUNK)).enumerate().for_each(|(chunk, ((teeth, before), weights))| {
            comb(teeth, before, weights, per_weight, (chunk * CHUNK) as u32);
        });
        ancestors
    }

    /// Adds noise that tells copies apart (roughening, Gordon, Salmond & Smith 1993), so that odometry without noise does
    /// not starve the filter.
    ///
    /// Scale is drawn back to its prior so that noise and pull balance at the prior's own spread (an Ornstein–Uhlenbeck
    /// step): scale diffuses enough to follow drift, and cannot wander off where nothing scores it.
    pub(crate) fn roughen(&mut self, by: &Roughening, prior: &ScalePrior, seed: Seed) {
        let mean = prior.log_mean() as f32;
        let spread = (prior.relative_sigma as f32).max(1e-6);
        let jitter = by.log_scale.min(spread);
        let keep = (1.0 - (jitter / spread).powi(2)).max(0.0).sqrt();
        let chance = Chance::new(seed, "roughen");
        let poses = (self.x.par_chunks_mut(CHUNK), self.y.par_chunks_mut(CHUNK));
        (poses.0, poses.1, self.heading.par_chunks_mut(CHUNK), self.log_scale.par_chunks_mut(CHUNK)).into_par_iter().enumerate().for_each(
            |(chunk, (xs, ys, headings, log_scales))| {
                let poses = xs.iter_mut().zip(ys).zip(headings).zip(log_scales);
                for (particle, (((x, y), heading), log_scale)) in ((chunk * CHUNK) as u32..).zip(poses) {
                    let [a, b, c, d] = chance.normals(particle);
                    *x += by.metres * a;
                    *y += by.metres * b;
                    *heading += by.heading_rad * c;
                    *log_scale = mean + keep * (*log_scale - mean) + jitter * d;
                }
            },
        );
    }

    /// Adds other particles, in proportion to their weights; `share` is what they weigh together.
    pub(crate) fn join(&mut self, others: &Particles, share: f64) {
        if others.len() == 0 {
            return;
        }
        self.weight.iter_mut().for_each(|w| *w *= (1.0 - share) as f32);
        self.x.extend_from_slice(&others.x);
        self.y.extend_from_slice(&others.y);
        self.heading.extend_from_slice(&others.heading);
        self.log_scale.extend_from_slice(&others.log_scale);
        self.drift.extend_from_slice(&others.drift);
        let theirs: f64 = others.weight.iter().map(|w| f64::from(*w)).sum();
        self.weight.extend(others.weight.iter().map(|w| (share * f64::from(*w) / theirs) as f32));
        self.log_weight = self.weight.iter().map(|w| libm::logf(w.max(f32::MIN_POSITIVE))).collect();
    }

    /// Mean and spread of the log scale over the whole cloud.
    pub(crate) fn scale(&self) -> (f64, f64) {
        let of = |f: &dyn Fn(f64) -> f64| -> f64 {
            self.weight.iter().zip(&self.log_scale).map(|(w, l)| f64::from(*w) * f(f64::from(*l))).sum()
        };
        let total: f64 = self.weight.iter().map(|w| f64::from(*w)).sum();
        let mean = of(&|l| l) / total;
        (mean, (of(&|l| (l - mean) * (l - mean)) / total).max(0.0).sqrt())
    }
}

/// How many teeth, at 0, 1, 2 …, stand at or before this.
#[inline(always)]
fn teeth_up_to(swept: f64) -> usize {
    (swept + 1.0).max(0.0) as u32 as usize
}

/// Names for each tooth the particle that it hits. `before` is where the chunk begins, counted from its first tooth in distances
/// of teeth; `first` is the index of its first particle.
fn comb(teeth: &mut [u32], before: f64, weights: &[f32], per_weight: f64, first: u32) {
    let (mut swept, mut next) = (before, 0);
    for (particle, weight) in (first..).zip(weights) {
        // Each particle signs for the next tooth until another does, and keeps it when it reaches it: no branch to mispredict.
        let Some(tooth) = teeth.get_mut(next) else { break };
        *tooth = if *weight > 0.0 { particle } else { *tooth };
        swept += f64::from(*weight) * per_weight;
        next = teeth_up_to(swept).max(next);
    }
    // Teeth that a particle jumped over are its own; indices rise, so they are the largest so far. A first one that nobody signed
    // for hangs on particles without weight only: round-off; any of the chunk will do.
    let mut own = first;
    for tooth in teeth {
        own = own.max(*tooth);
        *tooth = own;
    }
}

/// The largest of all; −∞ of none. Eight at a time: a single running maximum waits for itself.
fn largest(values: &[f32]) -> f32 {
    let mut lanes = [f32::NEG_INFINITY; 8];
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        lanes.iter_mut().zip(eight).for_each(|(lane, value)| *lane = if *value > *lane { *value } else { *lane });
    }
    lanes.iter().chain(rest).fold(f32::NEG_INFINITY, |a, b| a.max(*b))
}

/// The sum of `f` over all values, in double precision, eight sums at a time in a fixed order.
fn sum_of(values: &[f32], f: impl Fn(f64) -> f64) -> f64 {
    let mut lanes = [0.0f64; 8];
    let (eights, rest) = values.as_chunks::<8>();
    for eight in eights {
        lanes.iter_mut().zip(eight).for_each(|(lane, value)| *lane += f(f64::from(*value)));
    }
    lanes.iter().sum::<f64>() + rest.iter().map(|v| f(f64::from(*v))).sum::<f64>()
}

/// The angle in (−π, π] nearest to what f32 arithmetic made of it.
pub(crate) fn wrapped(angle: f32) -> f32 {
    wrap_angle(f64::from(angle)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(weights: &[f32]) -> Particles {
        let mut cloud = Particles::default();
        for (i, weight) in weights.iter().enumerate() {
            cloud.push(i as f32, 0.0, 0.0, 0.0);
            if let Some(log) = cloud.log_weight.last_mut() {
                *log = libm::logf(*weight);
            }
        }
        cloud.normalize();
        cloud
    }

    #[test]
    fn each_particle_is_copied_in_proportion_to_its_weight_up_to_one() {
        let weights = [0.05, 0.4, 0.0, 0.3, 0.25];
        let mut cloud = cloud(&weights);
        let ancestors = cloud.resample_systematic(1000, Seed(5));
        for (i, weight) in weights.iter().enumerate() {
            let copies = ancestors.iter().filter(|a| **a as usize == i).count() as f32;
            assert!((copies - 1000.0 * weight).abs() <= 1.0, "{copies} copies of weight {weight}");
        }
    }

    #[test]
    fn a_large_cloud_is_combed_as_one_sweep_would() {
        // Three chunks and a bit, the third without weight, half of the others without.
        let chance = Chance::new(Seed(4), "test");
        let mut cloud = Particles::default();
        for i in 0..3 * CHUNK as u32 + 100 {
            cloud.push(i as f32, 0.0, 0.0, 0.0);
        }
        let weight = |i: usize| if i / CHUNK == 2 { 0.0 } else { chance.normals(i as u32)[0].max(0.0) };
        cloud.weight = (0..cloud.len()).map(weight).collect();
        let total: f64 = cloud.weight.iter().map(|w| f64::from(*w)).sum();
        for (count, offset) in [(10, 0.3), (9_000, 0.999), (30_000, 0.0), (1, 0.5)] {
            let ancestors = cloud.ancestors(count, offset);
            let (mut index, mut swept) = (0, f64::from(cloud.weight[0]));
            let mut differ = 0;
            for (tooth, ancestor) in ancestors.iter().enumerate() {
                while swept < (tooth as f64 + offset) * total / count as f64 && index + 1 < cloud.len() {
                    index += 1;
                    swept += f64::from(cloud.weight[index]);
                }
                differ += usize::from(*ancestor as usize != index);
                assert!(cloud.weight[*ancestor as usize] > 0.0 || offset == 0.0 && tooth == 0, "tooth {tooth} hangs on nothing");
            }
            // Teeth on the border of two particles fall by round-off.
            assert!(differ <= 1 + count / 10_000, "{differ} of {count} teeth differ");
            assert!(ancestors.is_sorted());
        }
    }

    #[test]
    fn the_effective_share_is_one_for_equal_weights_and_small_for_one_winner() {
        assert!((cloud(&[2.0; 8]).effective_share() - 1.0).abs() < 1e-6);
        assert!((cloud(&[1.0, 0.0, 0.0, 0.0]).effective_share() - 0.25).abs() < 1e-6);
    }

    #[test]
    fn a_cloud_of_impossible_guesses_stays_a_cloud() {
        let mut cloud = cloud(&[1.0, 1.0]);
        cloud.log_weight.fill(f32::NEG_INFINITY);
        cloud.normalize();
        assert_eq!(cloud.weight, [0.5, 0.5]);
    }

    #[test]
    fn roughened_scale_keeps_the_priors_spread_however_often() {
        let prior = ScalePrior { metres_per_unit: 2.0, relative_sigma: 0.2 };
        let mut cloud = cloud(&[1.0; 8192]);
        cloud.log_scale.fill(-1.5);
        for i in 0..2000 {
            cloud.roughen(&Roughening { metres: 0.0, heading_rad: 0.0, log_scale: 0.02 }, &prior, Seed(i));
        }
        let (mean, sigma) = cloud.scale();
        // 2000 · (0.02 / 0.2)² / 2 = 10 time constants; then 4 σ/√N and 4 σ/√(2N).
        assert!((mean - prior.log_mean()).abs() < 4.0 * 0.2 / 8192f64.sqrt() + 2.2 * libm::exp(-10.0), "mean {mean}");
        assert!((sigma - 0.2).abs() < 4.0 * 0.2 / 16384f64.sqrt(), "sigma {sigma}");
    }

    #[test]
    fn joined_particles_weigh_their_share() {
        let mut one = cloud(&[1.0, 3.0]);
        one.join(&cloud(&[1.0; 3]), 0.4);
        assert!((one.weight[2..].iter().sum::<f32>() - 0.4).abs() < 1e-6);
        one.normalize();
        assert!((one.weight[1] - 0.45).abs() < 1e-6, "{:?}", one.weight);
    }
}
