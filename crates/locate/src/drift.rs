//! How much does the odometry turn by itself, a metre?
//!
//! steps ──curvature of every two metres──▶ [`SteadyTurn`]: the commonest one ──▶ where drifting particles are drawn to
//!
//! Wheels that wear unevenly, a gyro's bias: heading drifts steadily (the Intel lab's robot by −3.3° a metre). Nobody says so
//! beforehand, and it cannot be read off the path alone either: whoever walks a round corridor turns as steadily. Hence each
//! particle has a drift of its own. Most have next to none; a few have what would make the path as straight as can be, since
//! people and robots walk straight most of the time. The plan decides between them.
//! The path says it only roughly: the Intel robot's it takes for −4 to −5° where −3.3° is right. So the spread stays wide, and
//! each that drifts varies its own a little.
//! Departs from an augmented state (Thrun, Burgard & Fox 2005, §5.4 with a bias) in that the drifting particles' values follow the
//! path's own evidence instead of being found by survival: that would take a dozen times the particles.

use planwalk_types::{Seed, Step};
use rayon::prelude::*;

use crate::chance::Chance;
use crate::particles::CHUNK;

/// What a particle's drift is counted in, radians a metre: 0.05°. 8 bits reach ±6.35°.
pub(crate) const UNIT_RAD: f32 = 0.000_872_664_6;
/// Drift beyond which a particle counts as drifting, units: 0.4° a metre is four sigmas of those that do not.
const DRIFTING: i32 = 8;
/// When the cloud is resampled, one in so many varies its drift a little, and one in so many draws it anew.
const VARIED: u32 = 8;
const ANEW: u32 = 64;
/// Standard deviation of a small change, units.
const CHANGE: f32 = 6.0;
/// Way whose curvature is one piece of evidence, metres.
const PIECE_M: f64 = 2.0;
/// Standard deviation that no path takes away, units: straight is never that straight, and drift changes on the way.
const SURE: f64 = 30.0;
/// Half of the grid of candidates, units.
const REACH: i32 = 127;
/// Widths of the curvature of straight ways, degrees a metre: a steady camera's, and a rough drive's.
const WIDTHS_DEG: [f64; 2] = [0.5, 3.0];
/// Share of pieces that are turns, of any curvature up to a turn on the spot.
const TURNS: f64 = 0.3;
const TURNS_WITHIN_DEG: f64 = 180.0;

/// How much the heading of an odometry may drift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadingDrift {
    /// Standard deviation of a good odometry's drift, radians a metre.
    pub usual_rad_per_m: f64,
    /// Share of particles that try for more.
    pub drifting_share: f64,
    /// Standard deviation of theirs.
    pub drifting_rad_per_m: f64,
}

impl Default for HeadingDrift {
    /// 0.1° a metre; one in eight tries up to some 3°.
    fn default() -> Self {
        Self { usual_rad_per_m: 0.1f64.to_radians(), drifting_share: 0.25, drifting_rad_per_m: 3f64.to_radians() }
    }
}

/// The drift that makes the path so far as straight as can be.
#[derive(Debug, Clone)]
pub(crate) struct SteadyTurn {
    /// Log-probability of each candidate, −[`REACH`] ..= [`REACH`] units.
    nats: Vec<f64>,
    prior: HeadingDrift,
    /// Of the piece that is being walked: metres, radians.
    walked: (f64, f64),
    /// Mean and standard deviation, units.
    mean: f32,
    sigma: f32,
}

impl SteadyTurn {
    pub(crate) fn new(prior: &HeadingDrift) -> Self {
        let sigma = (prior.drifting_rad_per_m / f64::from(UNIT_RAD)).max(1.0);
        let nats = (-REACH..=REACH).map(|d| -0.5 * (f64::from(d) / sigma).powi(2)).collect();
        Self { nats, prior: *prior, walked: (0.0, 0.0), mean: 0.0, sigma: sigma as f32 }
    }

    /// Takes in a step; `metres_per_unit` is the prior's.
    pub(crate) fn add(&mut self, step: &Step, metres_per_unit: f64) {
        let (way_m, turn) = &mut self.walked;
        *way_m += step.forward.hypot(step.left) * metres_per_unit;
        *turn += step.turn_rad;
        if *way_m >= PIECE_M {
            let curvature = *turn / *way_m;
            self.walked = (0.0, 0.0);
            // Of lengths beyond what numbers hold there is none.
            if curvature.is_finite() {
                self.learn(curvature);
            }
        }
    }

    /// One more piece of way, of this curvature in radians a metre.
    fn learn(&mut self, curvature: f64) {
        let unit_deg = f64::from(UNIT_RAD).to_degrees();
        for (d, nats) in (-REACH..=REACH).zip(&mut self.nats) {
            let off = curvature.to_degrees() - f64::from(d) * unit_deg;
            let straight = WIDTHS_DEG.map(|w| 0.5 * w / (std::f64::consts::PI * (w * w + off * off)));
            *nats += libm::log((1.0 - TURNS) * (straight[0] + straight[1]) + TURNS / (2.0 * TURNS_WITHIN_DEG));
        }
        let best = self.nats.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut first, mut second) = (0.0, 0.0, 0.0);
        for (d, nats) in (-REACH..=REACH).zip(&mut self.nats) {
            *nats -= best;
            let weight = libm::exp(*nats);
            sum += weight;
            first += weight * f64::from(d);
            second += weight * f64::from(d) * f64::from(d);
        }
        let mean = first / sum;
        self.sigma = (second / sum - mean * mean).max(SURE * SURE).sqrt() as f32;
        self.mean = mean as f32;
    }

    /// The drifts of a new cloud.
    pub(crate) fn draw(&self, count: usize, seed: Seed) -> Vec<i8> {
        let chance = Chance::new(seed, "drift");
        let usual = (self.prior.usual_rad_per_m / f64::from(UNIT_RAD)) as f32;
        // Every so many-th: which particles drift has nothing to do with where they are.
        let every = if self.prior.drifting_share > 0.0 { (1.0 / self.prior.drifting_share.min(1.0)) as usize } else { usize::MAX };
        let one = |i: usize| {
            let [a, b, ..] = chance.normals(i as u32);
            let value = if i % every == every / 2 { self.mean + self.sigma * a } else { usual * a };
            rounded(value, b)
        };
        (0..count).into_par_iter().with_min_len(CHUNK).map(one).collect()
    }

    /// Tells copies apart: a few draw anew, from what those like them have.
    pub(crate) fn roughen(&self, drifts: &mut [i8], seed: Seed) {
        let chance = Chance::new(seed, "drift");
        let usual = (self.prior.usual_rad_per_m / f64::from(UNIT_RAD)) as f32;
        drifts.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, drifts)| {
            for (particle, drift) in ((chunk * CHUNK) as u32..).zip(drifts).filter(|(particle, _)| particle % VARIED == 0) {
                let [a, b, ..] = chance.normals(particle);
                let drifting = i32::from(*drift).abs() > DRIFTING;
                let drawn = match (drifting, particle % ANEW == 0) {
                    (true, false) => f32::from(*drift) + CHANGE * a,
                    (true, true) => self.mean + self.sigma * a,
                    (false, _) => usual * a,
                };
                let drawn = rounded(drawn, b);
                // Who drifts goes on drifting, so that the path may change its mind.
                *drift = if drifting && i32::from(drawn).abs() <= DRIFTING { *drift } else { drawn };
            }
        });
    }
}

/// Rounded up or down by chance, so that on average nothing is lost. `chance` is a normal number: its sign and size will do.
fn rounded(value: f32, chance: f32) -> i8 {
    let up = 0.5 + 0.29 * chance;
    (value + up.clamp(0.0, 1.0)).floor().clamp(-REACH as f32, REACH as f32) as i8
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;
    use planwalk_types::Stamp;

    /// 0.5 m at a time, straight for 6 m, then round a corner; `drift_deg` a metre on top.
    fn walk(steady: &mut SteadyTurn, metres: usize, drift_deg: f64) {
        for i in 0..2 * metres {
            let corner = if i % 16 >= 12 { 0.4 } else { 0.0 };
            let turn_rad = corner + 0.5 * drift_deg.to_radians();
            let (from, to) = (Stamp(i as i64), Stamp(i as i64 + 1));
            steady.add(&Step { from, to, forward: 0.5, left: 0.0, turn_rad, covariance: Matrix3::zeros(), unit_change: 0.0 }, 1.0);
        }
    }

    #[test]
    fn the_commonest_curvature_is_found_among_corners_of_one_hand() {
        for drift_deg in [-2.5, 0.0, 1.2] {
            let mut steady = SteadyTurn::new(&HeadingDrift::default());
            walk(&mut steady, 60, drift_deg);
            let found = f64::from(steady.mean * UNIT_RAD).to_degrees();
            assert!((found - drift_deg).abs() < 0.2, "{found}° a metre for {drift_deg}");
            assert!(f64::from(steady.sigma) <= SURE);
        }
    }

    #[test]
    fn few_drift_and_they_follow_the_path() {
        let mut steady = SteadyTurn::new(&HeadingDrift::default());
        let mut drifts = steady.draw(8000, Seed(4));
        walk(&mut steady, 60, -2.5);
        // Copies are found at other places each time.
        (0..300).for_each(|i| {
            steady.roughen(&mut drifts, Seed(i));
            drifts.rotate_left(5);
        });
        let deg = |d: &i8| f64::from(f32::from(*d) * UNIT_RAD).to_degrees();
        let (drifting, usual): (Vec<f64>, Vec<f64>) = drifts.iter().map(deg).partition(|d| d.abs() > 0.45);
        let share = drifting.len() as f64 / 8000.0;
        // One in four, less the tenth of them whose first draw was small.
        assert!((0.2..0.25).contains(&share), "{share}");
        // ±1.5° around −2.5°; without those within 0.4° of none the mean is −2.7°, and what each varies spreads it.
        let mean = drifting.iter().sum::<f64>() / drifting.len() as f64;
        assert!((mean + 2.7).abs() < 0.3, "{mean}");
        let spread = (usual.iter().map(|d| d * d).sum::<f64>() / usual.len() as f64).sqrt();
        // 0.1°, and rounding to 0.05°.
        assert!((spread - 0.1).abs() < 0.03, "{spread}");
    }
}
