//! How many of the particles of each scale survive a step among walls, and is that news about the scale?
//!
//! Small walks cross no walls. While the cloud is spread over the plan, the tiny among its walks would win for that alone:
//! measured on real plans, scale sinks to half of the truth within 100 m, and every place is wrong. But the walker *saw*
//! the walls and walked around them; that a walk avoids walls is no merit of its scale. So walls weigh particles against
//! others **of the same scale**: each is divided by the mean survival of its scale, down to a floor. Below the floor most of
//! the walks of that scale end in a wall at once: what the walls say of the scale is then news (a corridor's end that comes
//! too soon), and counts. It counts in full once the cloud has gathered at one place.

use rayon::prelude::*;

use crate::approx;
use crate::cast::BLOCK;
use crate::particles::{CHUNK, Particles};
use crate::prior::ScalePrior;

/// Bins over ± 4 σ of the prior.
const BINS: usize = 32;
/// Mean survival of one update below which walls speak about scale. In a cloud spread over rooms and corridors, 5–30 % of
/// the walks of a wrong place hit a wall in 0.25 m; when half do, at once, it is one place that they hit.
const FLOOR: f64 = 0.5;

/// A cloud that fills fewer bins is at one place, and walls tell its scale as they tell its place …
const GATHERED: f64 = 30.0;
/// … and one that fills more is spread over many.
const SPREAD: f64 = 300.0;

/// Mean survival by scale, as weighted sums.
#[derive(Debug, Clone)]
pub(crate) struct Survival {
    low: f32,
    per_log: f32,
    before: [f64; BINS],
    after: [f64; BINS],
}

impl Survival {
    pub(crate) fn new(prior: &ScalePrior) -> Self {
        let sigma = prior.relative_sigma.max(1e-3);
        let low = (prior.log_mean() - 4.0 * sigma) as f32;
        Self { low, per_log: (BINS as f64 / (8.0 * sigma)) as f32, before: [0.0; BINS], after: [0.0; BINS] }
    }

    #[inline(always)]
    fn bin(&self, log_scale: f32) -> i32 {
        let bin = (log_scale - self.low) * self.per_log;
        let bin = if bin > 0.0 { bin } else { 0.0 };
        approx::floor(if bin < BINS as f32 { bin } else { BINS as f32 - 1.0 })
    }

    /// Particles of these weights, at most [`BLOCK`], met walls and ground that cost them `nats` (at most 0).
    #[inline(always)]
    pub(crate) fn add_block(&mut self, log_scales: &[f32], weights: &[f32], nats: &[f32]) {
        let count = nats.len().min(BLOCK);
        let (log_scales, weights, nats) = (&log_scales[..count], &weights[..count], &nats[..count]);
        let (mut bins, mut after) = ([0; BLOCK], [0.0; BLOCK]);
        for i in 0..count {
            bins[i] = self.bin(log_scales[i]);
            after[i] = weights[i] * approx::exp(nats[i]);
        }
        for i in 0..count {
            let bin = bins[i] as usize % BINS;
            self.before[bin] += f64::from(weights[i]);
            self.after[bin] += f64::from(after[i]);
        }
    }

    pub(crate) fn with(mut self, other: &Self) -> Self {
        for bin in 0..BINS {
            self.before[bin] += other.before[bin];
            self.after[bin] += other.after[bin];
        }
        self
    }

    /// Nats that every particle of a bin gets back, from a cloud that fills so many bins of (0.5 m, 0.5 m, 15°).
    fn back(&self, filled_bins: f64) -> [f32; BINS] {
        let share = (libm::log(filled_bins.max(1.0) / GATHERED) / libm::log(SPREAD / GATHERED)).clamp(0.0, 1.0);
        let total: f64 = self.before.iter().sum();
        let mut back = [0.0; BINS];
        for (bin, slot) in back.iter_mut().enumerate() {
            // The few of a rare scale are no statistics: they are judged with their neighbours.
            let (mut before, mut after) = (self.before[bin], self.after[bin]);
            for reach in 1..BINS {
                if before > 1e-3 * total {
                    break;
                }
                let near = bin.saturating_sub(reach)..=(bin + reach).min(BINS - 1);
                before = near.clone().map(|i| self.before[i]).sum();
                after = near.map(|i| self.after[i]).sum();
            }
            if before > 0.0 {
                *slot = -(share * libm::log((after / before).clamp(FLOOR, 1.0))) as f32;
            }
        }
        back
    }

    /// Takes from each particle's loss what its scale lost on average.
    pub(crate) fn make_fair(&self, cloud: &mut Particles, filled_bins: f64) {
        let back = self.back(filled_bins);
        if back.iter().all(|b| *b == 0.0) {
            return;
        }
        cloud.log_weight.par_chunks_mut(CHUNK).zip(cloud.log_scale.par_chunks(CHUNK)).for_each(|(weights, scales)| {
            for (weight, scale) in weights.iter_mut().zip(scales) {
                *weight += back[self.bin(*scale) as usize % BINS];
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRIOR: ScalePrior = ScalePrior { metres_per_unit: 1.0, relative_sigma: 0.3 };

    /// Small walks lose `small`, large ones `large` of their weight on average: half of each meets a wall.
    fn cloud_after(small: f32, large: f32) -> Particles {
        let mut cloud = Particles::default();
        let mut survival = Survival::new(&PRIOR);
        for i in 0..4000 {
            let (log_scale, survives) = if i % 2 == 0 { (-0.5, small) } else { (0.5, large) };
            let nats = if i % 4 < 2 { 0.0 } else { libm::logf((2.0 * survives - 1.0).max(1e-3)) };
            cloud.push(0.0, 0.0, 0.0, log_scale);
            cloud.log_weight[i] = nats;
            survival.add_block(&[log_scale], &[1.0 / 4000.0], &[nats]);
        }
        survival.make_fair(&mut cloud, 1000.0);
        cloud.normalize();
        cloud
    }

    fn share_of_small(cloud: &Particles) -> f64 {
        cloud.weight.iter().zip(&cloud.log_scale).filter(|(_, s)| **s < 0.0).map(|(w, _)| f64::from(*w)).sum()
    }

    #[test]
    fn avoiding_walls_is_no_merit_of_a_small_scale() {
        let share = share_of_small(&cloud_after(0.99, 0.7));
        // f32 sums of 4000 weights.
        assert!((share - 0.5).abs() < 1e-4, "small walks hold {share}");
    }

    #[test]
    fn within_a_scale_walls_still_tell_places_apart() {
        let cloud = cloud_after(0.99, 0.7);
        assert!(cloud.weight[1] > 2.0 * cloud.weight[3], "free {} against crossing {}", cloud.weight[1], cloud.weight[3]);
    }

    #[test]
    fn a_scale_at_which_most_walks_end_in_a_wall_at_once_loses() {
        let mut cloud = Particles::default();
        let mut survival = Survival::new(&PRIOR);
        for i in 0..1000 {
            let (log_scale, nats) = if i % 2 == 0 { (0.0, 0.0) } else { (0.5, -3.7) };
            cloud.push(0.0, 0.0, 0.0, log_scale);
            cloud.log_weight[i] = nats;
            survival.add_block(&[log_scale], &[1e-3], &[nats]);
        }
        survival.make_fair(&mut cloud, 1000.0);
        cloud.normalize();
        let large: f64 = cloud.weight.iter().skip(1).step_by(2).map(|w| f64::from(*w)).sum();
        assert!(large < 0.1, "the impossible scale holds {large}");
    }
}
