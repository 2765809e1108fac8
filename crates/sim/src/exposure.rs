//! How does brightness become grey levels? Gain, dark corners, noise; and how an automatic exposure follows the scene.

use crate::texture::hash;

/// What the automatic exposure steers the mean brightness to, as a share of white.
const TARGET: f64 = 0.46;
/// Its natural frequency, rad/s: it answers a step within half a second or so.
const PROMPTNESS_RAD_S: f64 = 3.5;
/// Its damping: below 1 it overshoots, here by 16 % (of the logarithm of the gain).
const DAMPING: f64 = 0.5;
/// Between brightness measurements, seconds.
pub(crate) const METER_S: f64 = 0.1;

/// How one frame is exposed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exposure {
    /// Brightness 1 becomes 255 · gain.
    pub gain: f32,
    /// Standard deviation of the noise in the dark, grey levels.
    pub noise_grey: f32,
    /// Standard deviation of the photons' noise at white and gain 1, grey levels.
    pub shot_noise_grey: f32,
    /// How much darker the corners are.
    pub vignetting: f32,
    /// Seed of the frame's noise.
    pub seed: u32,
}

impl Exposure {
    /// The grey level of a pixel; `corner` is its squared distance from the middle, 1 in a corner.
    pub fn grey(&self, value: f32, corner: f32, u: u32, v: u32) -> u8 {
        let bits = hash(u, v, self.seed);
        // Four bytes summed: nearly normal, deviation 2 · 73.9.
        let sum = (bits & 255) + ((bits >> 8) & 255) + ((bits >> 16) & 255) + (bits >> 24);
        let value = if self.vignetting > 0.0 { value * (1.0 - self.vignetting * corner) } else { value };
        // Photons: variance grows with their number; gain multiplies signal and noise alike.
        let shot = self.shot_noise_grey * self.gain;
        let sigma = if shot > 0.0 { (self.noise_grey * self.noise_grey + shot * shot * value.max(0.0)).sqrt() } else { self.noise_grey };
        let noise = (sum as f32 - 510.0) / 147.8 * sigma;
        (255.0 * value * self.gain + noise + 0.5).clamp(0.0, 255.0) as u8
    }
}

/// Gains of an automatic exposure that sees these mean brightnesses, [`METER_S`] apart: a damped oscillator pulled to the gain
/// that would make the mean [`TARGET`]. It starts settled.
pub(crate) fn follow(brightness: &[f32]) -> Vec<f32> {
    let wanted = |b: f32| libm::log(TARGET / f64::from(b).max(0.02)).clamp(-1.6, 1.6);
    let (mut level, mut rate) = (brightness.first().map_or(0.0, |b| wanted(*b)), 0.0);
    let (steps, w) = (10, PROMPTNESS_RAD_S);
    let dt = METER_S / f64::from(steps);
    brightness
        .iter()
        .map(|b| {
            let gain = libm::exp(level) as f32;
            for _ in 0..steps {
                rate += dt * (w * w * (wanted(*b) - level) - 2.0 * DAMPING * w * rate);
                level += dt * rate;
            }
            gain
        })
        .collect()
}

/// The gain at a moment between those of [`follow`]; 1 where there are none.
pub(crate) fn gain_at(gains: &[f32], time_s: f64) -> f32 {
    let place = (time_s / METER_S).clamp(0.0, gains.len().saturating_sub(1) as f64);
    let i = place as usize;
    let (Some(a), Some(b)) = (gains.get(i), gains.get(i + 1).or(gains.get(i))) else { return 1.0 };
    a + (place - i as f64) as f32 * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_automatic_exposure_lags_overshoots_and_settles() {
        let brightness: Vec<f32> = (0..100).map(|i| if i < 20 { 0.46 } else { 0.23 }).collect();
        let gains = follow(&brightness);
        assert!((gains[19] - 1.0).abs() < 1e-3 && gains[22] < 1.5, "it lags: {}", gains[22]);
        let peak = gains.iter().copied().fold(0.0, f32::max);
        // 16 % of ln 2 over twice the gain: 2.23; the coarse steps of time add a little.
        assert!(peak > 2.15 && peak < 2.35, "it overshoots to {peak}");
        assert!((gains[99] - 2.0).abs() < 0.02, "it settles at {}", gains[99]);
    }

    #[test]
    fn photons_make_bright_places_noisier_than_dark_ones() {
        let exposure = Exposure { gain: 1.0, noise_grey: 1.0, shot_noise_grey: 4.0, vignetting: 0.0, seed: 5 };
        let spread = |value: f32| {
            let n = 20_000u32;
            let greys = (0..n).map(|i| f64::from(exposure.grey(value, 0.0, i, 7)) - f64::from(255.0 * value));
            (greys.map(|g| g * g).sum::<f64>() / f64::from(n)).sqrt()
        };
        // √(1 + 16·value + 1/12 of rounding); a deviation from 20 000 draws errs by 0.5 %, and 4 of them are 2 %.
        assert!((spread(0.1) / (1.0f64 + 1.6 + 1.0 / 12.0).sqrt() - 1.0).abs() < 0.03, "{}", spread(0.1));
        assert!((spread(0.8) / (1.0f64 + 12.8 + 1.0 / 12.0).sqrt() - 1.0).abs() < 0.03, "{}", spread(0.8));
    }

    #[test]
    fn corners_darken_by_as_much_as_was_asked_for() {
        let exposure = Exposure { gain: 1.0, noise_grey: 0.0, shot_noise_grey: 0.0, vignetting: 0.3, seed: 5 };
        assert_eq!((exposure.grey(0.8, 0.0, 0, 0), exposure.grey(0.8, 1.0, 0, 0)), (204, 143));
    }
}
