//! What would odometry have said? A path and sightings straight from the truth, with a stated noise, without any picture.
//!
//! For tests and studies of localisers: thousands of walks a minute, and every error is known. Each noise has a stream of its own,
//! so switching one off leaves the others as they were.

use nalgebra::{Matrix3, Vector3};
use planwalk_types::{Path, Plan, PlanPose, Pt2, Seed, Sighting, Stamp, Step, StreamRng, Wall};
use rand::RngExt;

/// How the odometry errs. All lengths are the truth's metres; the path and the sightings come out in the odometry's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OdometryNoise {
    /// Metres in one unit of odometry at the start.
    pub metres_per_unit: f64,
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

/// Odometry of a true walk among walls: the path in the odometry's unit, and points of walls (and of furniture) in the body frame.
///
/// Steps lead from each true pose to the next; sightings are stamped with the pose from which they were seen. A field of `noise` that is
/// not finite or makes no sense is the caller's affair: the numbers that come out are as senseless, but nothing panics.
pub fn simulate_odometry(truth: &[(Stamp, PlanPose)], walls: &[Wall], noise: &OdometryNoise, seed: Seed) -> (Path, Vec<Sighting>) {
    let mut streams = Streams::new(seed);
    let mut log_scale = 0.0;
    let mut steps = Vec::with_capacity(truth.len().saturating_sub(1));
    let mut sightings = Vec::new();
    for (index, pair) in truth.windows(2).enumerate() {
        let units_per_metre = libm::exp(log_scale) / noise.metres_per_unit;
        look(index, pair[0], walls, noise, units_per_metre, &mut streams, &mut sightings);
        steps.push(step(pair, noise, units_per_metre, &mut streams));
        let length_m = pair[0].1.origin().distance(pair[1].1.origin());
        log_scale += noise.scale_walk_per_sqrt_m * length_m.sqrt() * normal(&mut streams.scale);
    }
    if let Some(last) = truth.last() {
        let units_per_metre = libm::exp(log_scale) / noise.metres_per_unit;
        look(truth.len() - 1, *last, walls, noise, units_per_metre, &mut streams, &mut sightings);
    }
    (Path { steps }, sightings)
}

/// One stream of chance for each noise.
struct Streams {
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
    walls: &[Wall],
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
        let wall_m = cast(pose.origin(), pose.heading_rad + bearing_rad, walls);
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

/// Distance to the first wall in a direction, metres; infinite where there is none.
fn cast(from: Pt2<Plan>, heading_rad: f64, walls: &[Wall]) -> f64 {
    let (s, c) = libm::sincos(heading_rad);
    let mut nearest = f64::INFINITY;
    for wall in walls {
        let (ex, ey) = (wall.to.x - wall.from.x, wall.to.y - wall.from.y);
        let (ax, ay) = (wall.from.x - from.x, wall.from.y - from.y);
        let det = ex * s - ey * c;
        let (range, along) = ((ex * ay - ey * ax) / det, (c * ay - s * ax) / det);
        // A ray along the wall gives NaN, and NaN is in no range.
        if range > 0.0 && (0.0..=1.0).contains(&along) {
            nearest = nearest.min(range);
        }
    }
    nearest
}

/// A standard normal number (Box & Muller 1958); always two uniforms, so that streams stay in step.
fn normal(rng: &mut StreamRng) -> f64 {
    let (u, v): (f64, f64) = (rng.random_range(0.0..1.0), rng.random_range(0.0..1.0));
    (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of 4 m × 2 m around the origin.
    fn room() -> Vec<Wall> {
        let corners = [(-2.0, -1.0), (2.0, -1.0), (2.0, 1.0), (-2.0, 1.0)].map(|(x, y)| Pt2::new(x, y));
        (0..4).map(|i| Wall { from: corners[i], to: corners[(i + 1) % 4] }).collect()
    }

    #[test]
    fn a_ray_ends_at_the_first_wall() {
        let walls = room();
        let from = Pt2::new(0.5, 0.0);
        for (heading, range) in
            [(0.0, 1.5), (std::f64::consts::FRAC_PI_2, 1.0), (std::f64::consts::PI, 2.5), (-0.5 * std::f64::consts::PI, 1.0)]
        {
            assert!((cast(from, heading, &walls) - range).abs() < 1e-12);
        }
        assert_eq!(cast(from, 0.3, &[]), f64::INFINITY);
    }

    #[test]
    fn nothing_walked_is_nothing_said() {
        let (path, sightings) = simulate_odometry(&[], &room(), &OdometryNoise::default(), Seed(1));
        assert!(path.steps.is_empty() && sightings.is_empty());
    }

    #[test]
    fn a_degenerate_wall_is_not_seen() {
        let point = Pt2::new(1.0, 0.0);
        assert_eq!(cast(Pt2::new(0.0, 0.0), 0.0, &[Wall { from: point, to: point }]), f64::INFINITY);
    }
}
