//! How does this path walk? Speed, bobbing, steps and turning of any camera's path, simulated or real, by the same sums.
//!
//! poses ─▶ resampled at 20 Hz ─▶ speed over half a second, turning over a tenth, height above its own slow drift and its spectrum
//!
//! Frames: z up; the camera looks along its z axis. Metres, seconds; angles in degrees, as people read them.

use planwalk_types::{Cam, Plan, Rigid3, Stamp, wrap_angle};
use serde::{Deserialize, Serialize};

use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::TAU;

use super::along::Along;

/// Rate at which paths are compared, Hz.
const RATE_HZ: f64 = 20.0;

/// What a path tells of its walker.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WalkStatistics {
    /// From the first pose to the last, seconds.
    pub duration_s: f64,
    /// Way on the floor, metres: of places half a second apart, so that sway and noise do not add to it.
    pub length_m: f64,
    /// Speed on the floor over half a second: 5 %, 50 % and 95 % quantiles, m/s.
    pub speed_mps: [f64; 3],
    /// Share of the time at under 0.2 m/s.
    pub standing_share: f64,
    /// Mean height, metres.
    pub height_m: f64,
    /// Standard deviation of the height about its mean over 1.5 s, metres: the bobbing.
    pub bobbing_m: f64,
    /// Strongest frequency of the bobbing between 1 and 3 Hz, Hz: steps a second.
    pub gait_hz: f64,
    /// Share of the power between 1 and 3 Hz that lies within 0.15 Hz of it: near 1 for a metronome.
    pub gait_clarity: f64,
    /// Rate of the heading over a tenth of a second, either way: 50 %, 95 % and 99 % quantiles, degrees/s.
    pub yaw_rate_deg_s: [f64; 3],
    /// Rate of the whole rotation over a tenth of a second: 50 %, 95 % and 99 % quantiles, degrees/s.
    pub turn_rate_deg_s: [f64; 3],
    /// Mean pitch, degrees, looking up positive.
    pub pitch_mean_deg: f64,
    /// Standard deviation of the pitch, degrees.
    pub pitch_deg: f64,
    /// Standard deviation of the roll about its mean, degrees.
    pub roll_deg: f64,
    /// Standard deviation of the heading against the way walked, degrees, while walking: looking around.
    pub look_around_deg: f64,
}

/// Measures a path. `None` for what is no path ([`super::Walk::along`] says why) or lasts under three seconds or over a day.
pub fn walk_statistics(poses: &[(Stamp, Rigid3<Plan, Cam>)]) -> Option<WalkStatistics> {
    let along = Along::new(poses, UnitQuaternion::identity()).ok()?;
    let duration_s = along.duration_s();
    if !(3.0..=86_400.0).contains(&duration_s) {
        return None;
    }
    let count = (duration_s * RATE_HZ).floor() as usize;
    let path: Vec<Rigid3<Plan, Cam>> = (0..=count).map(|i| along.at(i as f64 / RATE_HZ)).collect();
    let half_second = path.windows(11).map(|w| floor_distance(&w[0], &w[10]) / 0.5);
    let speeds = sorted(half_second.collect());
    let standing = speeds.iter().filter(|v| **v < 0.2).count();
    let heights: Vec<f64> = path.iter().map(|p| p.origin().coords.z).collect();
    let bobbing = above_drift(&heights);
    let (gait_hz, gait_clarity) = rhythm(&bobbing);
    let forward: Vec<Vector3<f64>> = path.iter().map(|p| p.iso.rotation * Vector3::z()).collect();
    let headings: Vec<f64> = forward.iter().map(|f| libm::atan2(f.y, f.x)).collect();
    let pitches: Vec<f64> = forward.iter().map(|f| libm::asin(f.z.clamp(-1.0, 1.0)).to_degrees()).collect();
    let yaw_rates = sorted(headings.windows(3).map(|w| (wrap_angle(w[2] - w[0]) * 0.5 * RATE_HZ).abs().to_degrees()).collect());
    let turn = |w: &[Rigid3<Plan, Cam>]| 2.0 * libm::asin((w[0].iso.rotation.inverse() * w[2].iso.rotation).coords.xyz().norm().min(1.0));
    let turn_rates = sorted(path.windows(3).map(|w| (turn(w) * 0.5 * RATE_HZ).to_degrees()).collect());
    Some(WalkStatistics {
        duration_s,
        length_m: path.iter().step_by(10).zip(path.iter().step_by(10).skip(1)).map(|(a, b)| floor_distance(a, b)).sum(),
        speed_mps: [0.05, 0.5, 0.95].map(|q| quantile(&speeds, q)),
        standing_share: standing as f64 / speeds.len().max(1) as f64,
        height_m: mean(&heights),
        bobbing_m: deviation(&bobbing),
        gait_hz,
        gait_clarity,
        yaw_rate_deg_s: [0.5, 0.95, 0.99].map(|q| quantile(&yaw_rates, q)),
        turn_rate_deg_s: [0.5, 0.95, 0.99].map(|q| quantile(&turn_rates, q)),
        pitch_mean_deg: mean(&pitches),
        pitch_deg: deviation(&pitches),
        roll_deg: circular_deviation(&path.iter().map(roll).collect::<Vec<_>>()).to_degrees(),
        look_around_deg: looking_around(&path, &headings).to_degrees(),
    })
}

fn floor_distance(a: &Rigid3<Plan, Cam>, b: &Rigid3<Plan, Cam>) -> f64 {
    let d = b.origin().coords - a.origin().coords;
    libm::hypot(d.x, d.y)
}

/// How far the camera's x axis is turned out of the level, about the view's axis.
fn roll(pose: &Rigid3<Plan, Cam>) -> f64 {
    let (right, down) = (pose.iso.rotation * Vector3::x(), pose.iso.rotation * Vector3::y());
    libm::atan2(-right.z, -down.z)
}

/// Deviation of the heading from the way over one second, where one walks.
fn looking_around(path: &[Rigid3<Plan, Cam>], headings: &[f64]) -> f64 {
    let angle = |(i, w): (usize, &[Rigid3<Plan, Cam>])| {
        let d = w[20].origin().coords - w[0].origin().coords;
        (libm::hypot(d.x, d.y) > 0.4).then(|| wrap_angle(headings[i + 10] - libm::atan2(d.y, d.x)))
    };
    circular_deviation(&path.windows(21).enumerate().filter_map(angle).collect::<Vec<_>>())
}

/// Less the mean over 1.5 s: slow drift, stairs and stooping are no gait. Ends that have no such mean are left out.
fn above_drift(heights: &[f64]) -> Vec<f64> {
    heights.windows(31).map(|w| w[15] - mean(w)).collect()
}

/// The strongest frequency between 1 and 3 Hz and how much of that band's power lies near it: windowed (Hann) Fourier sums over
/// pieces of a minute, added (Welch 1967, without overlap) after each is scaled to the same power: a jump of an estimated path is
/// one minute's matter.
fn rhythm(values: &[f64]) -> (f64, f64) {
    let piece = values.len().clamp(2, 60 * RATE_HZ as usize);
    let fine_hz = (RATE_HZ / piece as f64).min(0.02);
    let mut lines: Vec<(f64, f64)> = (0..(2.0 / fine_hz) as usize).map(|i| (1.0 + fine_hz * i as f64, 0.0)).collect();
    for values in values.chunks_exact(piece) {
        let powers: Vec<f64> = lines.iter().map(|(hertz, _)| power(values, *hertz)).collect();
        let all = powers.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        lines.iter_mut().zip(powers).for_each(|(line, power)| line.1 += power / all);
    }
    let total: f64 = lines.iter().map(|(_, p)| p).sum();
    let near = |hertz: f64, reach: f64| lines.iter().filter(|(f, _)| (f - hertz).abs() <= reach).map(|(_, p)| p).sum::<f64>();
    // One line is an accident of the piece; a tenth of a hertz of them is a rhythm.
    let peak = (0..=40).map(|i| 1.0 + 0.05 * f64::from(i)).max_by(|a, b| near(*a, 0.05).total_cmp(&near(*b, 0.05))).unwrap_or(0.0);
    (peak, if total > 0.0 { near(peak, 0.15) / total } else { 0.0 })
}

/// Power of one frequency in a piece.
fn power(values: &[f64], hertz: f64) -> f64 {
    let n = values.len() as f64;
    let (mut re, mut im) = (0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let window = 0.5 - 0.5 * libm::cos(TAU * i as f64 / (n - 1.0));
        let (s, c) = libm::sincos(TAU * hertz * i as f64 / RATE_HZ);
        re += window * value * c;
        im += window * value * s;
    }
    re * re + im * im
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * sorted.len().saturating_sub(1) as f64;
    sorted.get(place.round() as usize).copied().unwrap_or(0.0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    (values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Standard deviation of angles about their mean direction, radians.
fn circular_deviation(angles: &[f64]) -> f64 {
    let (mut s, mut c) = (0.0, 0.0);
    for angle in angles {
        let (sin, cos) = libm::sincos(*angle);
        (s, c) = (s + sin, c + cos);
    }
    let middle = libm::atan2(s, c);
    let squares: f64 = angles.iter().map(|a| wrap_angle(a - middle)).map(|d| d * d).sum();
    (squares / angles.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Camera axes (right, down, forward) for a camera that looks along +x.
    fn level() -> UnitQuaternion<f64> {
        UnitQuaternion::new_normalize(nalgebra::Quaternion::new(0.5, -0.5, 0.5, -0.5))
    }

    #[test]
    fn a_known_walk_gives_its_own_numbers() {
        let poses: Vec<_> = (0..1800)
            .map(|i| {
                let t = f64::from(i) / 30.0;
                let place = Vector3::new(1.1 * t, 0.0, 1.4 + 0.02 * (TAU * 1.8 * t).sin());
                let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.2 * (TAU * 0.1 * t).sin());
                (Stamp((1e9 * t) as i64), Rigid3::from_parts(place, yaw * level()))
            })
            .collect();
        let found = walk_statistics(&poses).unwrap();
        assert!((found.length_m - 1.1 * found.duration_s).abs() < 0.6, "{found:?}");
        assert!(found.speed_mps.iter().all(|v| (v - 1.1).abs() < 1e-3) && found.standing_share == 0.0, "{found:?}");
        // A sine of 2 cm deviates by 1.414 cm; 2.8 of its periods in the mean that is taken off leave 93 % of it.
        assert!((found.bobbing_m - 0.93 * 0.01414).abs() < 0.0003, "{found:?}");
        assert!((found.gait_hz - 1.8).abs() < 0.051 && found.gait_clarity > 0.95, "{found:?}");
        // The fastest turn of 0.2 rad at 0.1 Hz is 7.2 °/s; the median of a cosine's size is cos 45° of that.
        assert!((found.yaw_rate_deg_s[0] - 5.09).abs() < 0.1 && (found.yaw_rate_deg_s[2] - 7.2).abs() < 0.1, "{found:?}");
        assert!((found.look_around_deg - 0.1414f64.to_degrees()).abs() < 0.4, "{found:?}");
        assert!(found.pitch_deg < 1e-6 && found.roll_deg < 1e-6 && found.pitch_mean_deg.abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn what_is_too_short_has_no_statistics() {
        assert!(walk_statistics(&[]).is_none());
        let pose = |s: i64| (Stamp(s * 1_000_000_000), Rigid3::from_parts(Vector3::zeros(), level()));
        assert!(walk_statistics(&[pose(0), pose(2)]).is_none());
    }
}
