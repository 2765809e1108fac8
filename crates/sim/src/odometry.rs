//! What would odometry have said? A path and sightings straight from the truth, with a stated noise, without any picture.
//!
//! For tests and studies of localisers: thousands of walks a minute, and every error is known. Each noise has a stream of its own,
//! so switching one off leaves the others as they were.

use nalgebra::{Matrix3, Vector3};
use planwalk_types::{Path, PlanPose, Seed, Sighting, Stamp, Step, StreamRng, Wall};
use rand::RngExt;
use serde::{Deserialize, Serialize};

use crate::cast::Caster;

/// How the odometry errs. All lengths are the truth's metres; the path and the sightings come out in the odometry's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OdometryNoise {
    /// Metres in one unit of odometry at the start: the median over walks.
    pub metres_per_unit: f64,
    /// Standard deviation of its logarithm from walk to walk: nobody tells the localiser what was drawn.
    pub scale_sigma: f64,
    /// Where given, it is drawn between so many times that median instead, evenly in the logarithm: `[0.7, 1.3]`.
    pub scale_range: Option<[f64; 2]>,
    /// Random walk of the logarithm of the scale, per √metre.
    pub scale_walk_per_sqrt_m: f64,
    /// Random walk of the heading, radians per √metre.
    pub heading_walk_rad_per_sqrt_m: f64,
    /// Steady drift of the heading, radians per metre.
    pub heading_drift_rad_per_m: f64,
    /// Deviation of a step's length and side slip, as a share of the step.
    pub step_relative: f64,
    /// Deviation of a step's turn, as a share of the turn.
    pub turn_relative: f64,
    /// Points seen at a moment at which the map is looked at.
    pub sightings_per_look: usize,
    /// Steps from one such moment to the next; 0 looks never.
    pub steps_per_look: usize,
    /// Horizontal field of view, radians.
    pub view_rad: f64,
    /// Points farther away are not in the map, metres.
    pub max_range_m: f64,
    /// Deviation of a range, as a share of it.
    pub range_relative: f64,
    /// Deviation of a bearing, radians.
    pub bearing_sigma_rad: f64,
    /// Share of the points that lie on something before the wall: furniture, people, open leaves.
    pub furniture_share: f64,
}

impl Default for OdometryNoise {
    /// A good visual odometry of one camera in a furnished building.
    fn default() -> Self {
        Self {
            metres_per_unit: 1.0,
            scale_sigma: 0.0,
            scale_range: None,
            scale_walk_per_sqrt_m: 0.01,
            heading_walk_rad_per_sqrt_m: 0.6f64.to_radians(),
            heading_drift_rad_per_m: 0.0,
            step_relative: 0.05,
            turn_relative: 0.01,
            sightings_per_look: 12,
            steps_per_look: 5,
            view_rad: 64f64.to_radians(),
            max_range_m: 12.0,
            range_relative: 0.05,
            bearing_sigma_rad: 0.2f64.to_radians(),
            furniture_share: 0.3,
        }
    }
}

impl OdometryNoise {
    /// A hand-held camera by itself: a unit that is off by up to a third and slips, heading that drifts, half of what is seen not
    /// on the plan. The figures are those of monocular odometry on real walks (0.3°/√m and 0.03°/m of heading, 1 %/√m of scale).
    pub fn monocular() -> Self {
        Self {
            scale_sigma: 0.15,
            heading_walk_rad_per_sqrt_m: 0.3f64.to_radians(),
            heading_drift_rad_per_m: 0.03f64.to_radians(),
            step_relative: 0.02,
            sightings_per_look: 24,
            steps_per_look: 2,
            range_relative: 0.04,
            furniture_share: 0.5,
            ..Self::default()
        }
    }

    /// Exact odometry in metres, exact sightings of walls only.
    pub fn none() -> Self {
        Self {
            scale_walk_per_sqrt_m: 0.0,
            heading_walk_rad_per_sqrt_m: 0.0,
            step_relative: 0.0,
            turn_relative: 0.0,
            range_relative: 0.0,
            bearing_sigma_rad: 0.0,
            furniture_share: 0.0,
            ..Self::default()
        }
    }

    /// Logarithm of how far this walk's unit is off its median.
    fn first_log_unit(&self, rng: &mut StreamRng) -> f64 {
        match self.scale_range {
            Some([low, high]) => {
                let (low, high) = (libm::log(low), libm::log(high));
                low + (high - low) * rng.random_range(0.0..1.0)
            }
            None if self.scale_sigma > 0.0 => self.scale_sigma * normal(rng),
            None => 0.0,
        }
    }

    /// The covariance that an honest odometry states for this step, in its own unit.
    fn covariance(&self, length: f64, length_m: f64, turn_rad: f64) -> Matrix3<f64> {
        // Never quite zero: a localiser may invert it.
        let along = (self.step_relative * length).powi(2) + 1e-12;
        let turn = self.heading_walk_rad_per_sqrt_m.powi(2) * length_m
            + (self.heading_drift_rad_per_m * length_m).powi(2)
            + (self.turn_relative * turn_rad).powi(2)
            + 1e-12;
        Matrix3::from_diagonal(&Vector3::new(along, along, turn))
    }
}

/// A walk as odometry would tell it, and as it was.
#[derive(Debug, Clone)]
pub struct SimulatedOdometry {
    /// Where the body was, and where the camera looked.
    pub truth: Vec<(Stamp, PlanPose)>,
    /// Its steps, in the odometry's unit.
    pub path: Path,
    /// What it saw, same unit.
    pub sightings: Vec<Sighting>,
    /// Metres in one unit at each moment of the truth.
    pub metres_per_unit: Vec<f64>,
}

/// Odometry of a true walk among walls: the path in the odometry's unit, and points of walls (and of furniture) in the body frame.
///
/// Steps lead from each true pose to the next; sightings are stamped with the pose from which they were seen. A field of `noise` that is
/// not finite or makes no sense is the caller's affair: the numbers that come out are as senseless, but nothing panics.
pub fn simulate_odometry(truth: &[(Stamp, PlanPose)], walls: &[Wall], noise: &OdometryNoise, seed: Seed) -> (Path, Vec<Sighting>) {
    let simulated = simulate_carried(truth.to_vec(), &[], walls, noise, seed);
    (simulated.path, simulated.sightings)
}

/// As [`simulate_odometry`], of somebody who is carried about: the ways to the poses whose indices are in `carried` are not felt.
/// That is the kidnapped walker: the odometry says that it stood, and the body is somewhere else.
pub fn simulate_carried(
    truth: Vec<(Stamp, PlanPose)>,
    carried: &[usize],
    walls: &[Wall],
    noise: &OdometryNoise,
    seed: Seed,
) -> SimulatedOdometry {
    let mut streams = Streams::new(seed);
    let walls = Caster::new(walls);
    // From here on, how the logarithm of the number of units in a metre has changed.
    let mut log_scale = -noise.first_log_unit(&mut streams.unit);
    let mut metres_per_unit = Vec::with_capacity(truth.len());
    let mut steps = Vec::with_capacity(truth.len().saturating_sub(1));
    let mut sightings = Vec::new();
    for (index, pair) in truth.windows(2).enumerate() {
        let units_per_metre = libm::exp(log_scale) / noise.metres_per_unit;
        look(index, pair[0], &walls, noise, units_per_metre, &mut streams, &mut sightings);
        metres_per_unit.push(1.0 / units_per_metre);
        let felt = if carried.contains(&(index + 1)) { [pair[0], (pair[1].0, pair[0].1)] } else { [pair[0], pair[1]] };
        steps.push(step(&felt, noise, units_per_metre, &mut streams));
        let length_m = felt[0].1.origin().distance(felt[1].1.origin());
        log_scale += noise.scale_walk_per_sqrt_m * length_m.sqrt() * normal(&mut streams.scale);
    }
    if let Some(last) = truth.last() {
        let units_per_metre = libm::exp(log_scale) / noise.metres_per_unit;
        look(truth.len() - 1, *last, &walls, noise, units_per_metre, &mut streams, &mut sightings);
        metres_per_unit.push(1.0 / units_per_metre);
    }
    SimulatedOdometry { truth, path: Path { steps }, sightings, metres_per_unit }
}

/// One stream of chance for each noise.
struct Streams {
    unit: StreamRng,
    scale: StreamRng,
    step: StreamRng,
    heading: StreamRng,
    place: StreamRng,
    range: StreamRng,
    furniture: StreamRng,
}

impl Streams {
    fn new(seed: Seed) -> Self {
        let of = |name: &str| seed.derive(name, 0);
        Self {
            unit: of("odometry unit"),
            scale: of("odometry scale"),
            step: of("odometry step"),
            heading: of("odometry heading"),
            place: of("sighting place"),
            range: of("sighting range"),
            furniture: of("sighting furniture"),
        }
    }
}

fn step(pair: &[(Stamp, PlanPose)], noise: &OdometryNoise, units_per_metre: f64, streams: &mut Streams) -> Step {
    let start_from_end = pair[0].1.inverse() * pair[1].1;
    let length_m = libm::hypot(start_from_end.x, start_from_end.y);
    let slip = noise.step_relative * length_m;
    let forward = (start_from_end.x + slip * normal(&mut streams.step)) * units_per_metre;
    let left = (start_from_end.y + slip * normal(&mut streams.step)) * units_per_metre;
    let turn_rad = start_from_end.heading_rad
        + noise.turn_relative * start_from_end.heading_rad * normal(&mut streams.heading)
        + noise.heading_walk_rad_per_sqrt_m * length_m.sqrt() * normal(&mut streams.heading)
        + noise.heading_drift_rad_per_m * length_m;
    let covariance = noise.covariance(length_m * units_per_metre, length_m, turn_rad);
    Step { from: pair[0].0, to: pair[1].0, forward, left, turn_rad, covariance, unit_change: 0.0 }
}

/// Adds what is seen from a pose, if this is a moment to look.
fn look(
    index: usize,
    (stamp, pose): (Stamp, PlanPose),
    walls: &Caster,
    noise: &OdometryNoise,
    units_per_metre: f64,
    streams: &mut Streams,
    sightings: &mut Vec<Sighting>,
) {
    if noise.steps_per_look == 0 || !index.is_multiple_of(noise.steps_per_look) {
        return;
    }
    for _ in 0..noise.sightings_per_look {
        let bearing_rad = (streams.place.random_range(0.0..1.0) - 0.5) * noise.view_rad;
        let (covered, share) = (streams.furniture.random_range(0.0..1.0), streams.furniture.random_range(0.15..0.95));
        let (range_error, bearing_error) = (normal(&mut streams.range), normal(&mut streams.range));
        let wall_m = walls.range_m(pose.origin(), pose.heading_rad + bearing_rad, noise.max_range_m);
        if wall_m > noise.max_range_m {
            continue;
        }
        let seen_m = if covered < noise.furniture_share { share * wall_m } else { wall_m };
        // A range cannot be negative, however noisy: at least a tenth of the truth.
        let range_m = seen_m * (1.0 + noise.range_relative * range_error).max(0.1);
        sightings.push(Sighting {
            stamp,
            bearing_rad: bearing_rad + noise.bearing_sigma_rad * bearing_error,
            range: range_m * units_per_metre,
            sigma: (noise.range_relative * seen_m * units_per_metre).max(1e-6),
        });
    }
}

/// A standard normal number (Box & Muller 1958); always two uniforms, so that streams stay in step.
fn normal(rng: &mut StreamRng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
    (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cast::tests::room;

    #[test]
    fn nothing_walked_is_nothing_said() {
        let (path, sightings) = simulate_odometry(&[], &room(), &OdometryNoise::default(), Seed(1));
        assert!(path.steps.is_empty() && sightings.is_empty());
    }

    #[test]
    fn the_unit_differs_from_walk_to_walk_by_as_much_as_is_said() {
        let truth: Vec<_> = (0..2).map(|i| (Stamp(i * 1_000_000_000), PlanPose::new(i as f64, 0.0, 0.0))).collect();
        let noise = OdometryNoise { scale_sigma: 0.2, ..OdometryNoise::none() };
        const N: u64 = 2000;
        let logs: Vec<f64> =
            (0..N).map(|seed| libm::log(simulate_odometry(&truth, &room(), &noise, Seed(seed)).0.steps[0].forward)).collect();
        let mean = logs.iter().sum::<f64>() / N as f64;
        let sigma = (logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / N as f64).sqrt();
        let even = OdometryNoise { scale_range: Some([0.5, 2.0]), ..OdometryNoise::none() };
        let units: Vec<f64> =
            (0..N).map(|seed| simulate_carried(truth.clone(), &[], &room(), &even, Seed(seed)).metres_per_unit[0]).collect();
        // Evenly in the logarithm: half of them below one. Four standard errors of a share.
        let below = units.iter().filter(|u| **u < 1.0).count() as f64 / N as f64;
        assert!((below - 0.5).abs() < 2.0 / (N as f64).sqrt() && units.iter().all(|u| (0.5..=2.0).contains(u)), "{below}");
        // Four standard errors of a mean, and of a standard deviation.
        assert!(mean.abs() < 4.0 * 0.2 / (N as f64).sqrt() && (sigma - 0.2).abs() < 4.0 * 0.2 / (2.0 * N as f64).sqrt(), "{mean} {sigma}");
    }

    #[test]
    fn who_is_carried_feels_nothing_and_sees_the_new_place() {
        let at = |i: i64, x: f64| (Stamp(i * 1_000_000_000), PlanPose::new(x, 0.0, 0.0));
        let truth: Vec<_> = (0..6).map(|i| at(i, -1.5 + 0.1 * i as f64 + if i < 3 { 0.0 } else { 1.0 })).collect();
        let noise = OdometryNoise { scale_range: Some([2.0, 2.0]), steps_per_look: 1, ..OdometryNoise::none() };
        let simulated = simulate_carried(truth.clone(), &[3], &room(), &noise, Seed(4));
        let lengths: Vec<f64> = simulated.path.steps.iter().map(|s| s.forward).collect();
        for (index, length) in lengths.iter().enumerate() {
            let expected = if index == 2 { 0.0 } else { 0.05 };
            // Exact but for round-off of metres.
            assert!((length - expected).abs() < 1e-12, "step {index}: {length}");
        }
        assert!(simulated.metres_per_unit.len() == 6 && simulated.metres_per_unit.iter().all(|m| (m - 2.0).abs() < 1e-12));
        let farthest = |stamp: Stamp| {
            let seen = simulated.sightings.iter().filter(|s| s.stamp == stamp).map(|s| s.range * s.bearing_rad.cos());
            2.0 * seen.fold(0.0, f64::max)
        };
        // Straight ahead the wall is nearer by as much as the walker was carried.
        let nearer_m = farthest(truth[2].0) - farthest(truth[3].0);
        assert!((nearer_m - 1.1).abs() < 1e-9, "{nearer_m}");
    }
}
