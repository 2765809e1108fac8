//! What is known before the first step: where the walk may begin, and how long a unit of odometry is?
//!
//! FloorPlan or StartPrior ──▶ particles that cover it evenly; OdometryScale + Path ──▶ ScalePrior

use planwalk_types::{Cell, FloorPlan, OdometryScale, Path, Pt2, Seed, wrap_angle};

use crate::motion::{normal, uniform};
use crate::particles::Particles;
use crate::walls::Walls;

/// How fast people walk indoors, metres per second: the middle of what a walking camera does on real floors (1.0–1.25 m/s).
const WALKING_SPEED_M_S: f64 = 1.1;
/// Standard deviation of the logarithm of a person's indoor walking speed, with room for odometry that drifts in scale.
const WALKING_SPEED_SIGMA: f64 = 0.35;
/// Calibration error of odometry that is called metric: wheels and visual-inertial systems are within 1–3 %.
const METRIC_SIGMA: f64 = 0.03;
/// Weight of ground that is surely outside, against 1 inside. Outlines are open and walks begin where the plan ends: a scanned
/// corridor's did 1.7 m before its first wall. At 0.05 two runs of six missed that start; at 0.3 none did.
const OUTSIDE_WEIGHT: f64 = 0.3;
/// Weight of ground that the plan says it does not know.
const UNKNOWN_WEIGHT: f64 = 0.05;

/// What is known of the metres in one unit of odometry: a log-normal distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScalePrior {
    /// Median.
    pub metres_per_unit: f64,
    /// Standard deviation of the logarithm.
    pub relative_sigma: f64,
}

impl ScalePrior {
    /// The prior that an odometry's own claim gives; of an unknown unit, the one that makes `path` a person's walk:
    /// its median speed while moving is 1.1 m/s, up to 35 %.
    pub fn of(scale: OdometryScale, path: &Path) -> Self {
        match scale {
            OdometryScale::Metric => Self { metres_per_unit: 1.0, relative_sigma: METRIC_SIGMA },
            OdometryScale::Relative(sigma) => Self { metres_per_unit: 1.0, relative_sigma: sigma },
            OdometryScale::Unknown => match moving_speed(path) {
                Some(speed) => Self { metres_per_unit: WALKING_SPEED_M_S / speed, relative_sigma: WALKING_SPEED_SIGMA },
                // Nobody moved: the scale matters little, and nothing is known of it.
                None => Self { metres_per_unit: 1.0, relative_sigma: 2.0 * WALKING_SPEED_SIGMA },
            },
        }
    }

    pub(crate) fn log_mean(&self) -> f64 {
        libm::log(self.metres_per_unit)
    }
}

/// Median speed while moving, odometry's units per second. Over spans of half a second, because the speed from one video
/// frame to the next is mostly noise; moving is over a fifth of the speed of the fastest tenth.
fn moving_speed(path: &Path) -> Option<f64> {
    let mut speeds = Vec::new();
    let (mut length, mut seconds) = (0.0, 0.0);
    for step in &path.steps {
        length += step.length();
        seconds += step.to.secs_since(step.from);
        if seconds >= 0.5 {
            speeds.push(length / seconds);
            (length, seconds) = (0.0, 0.0);
        }
    }
    if speeds.is_empty() && seconds > 0.0 {
        speeds.push(length / seconds);
    }
    speeds.sort_by(f64::total_cmp);
    let fast = *speeds.get(speeds.len() * 9 / 10)?;
    let moving: Vec<f64> = speeds.into_iter().filter(|v| *v > 0.2 * fast && v.is_finite()).collect();
    moving.get(moving.len() / 2).copied()
}

/// A start that somebody pointed at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartPrior {
    /// Plan, metres.
    pub x: f64,
    /// Plan, metres.
    pub y: f64,
    /// Anticlockwise from the plan's x axis, radians; `None` where only the place is known.
    pub heading_rad: Option<f64>,
    /// Standard deviation of x and of y, metres.
    pub sigma_m: f64,
    /// Standard deviation of the heading, radians.
    pub sigma_rad: f64,
}

/// Metres from the grid's bottom-left corner, and radians.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalPose {
    pub x: f32,
    pub y: f32,
    pub heading: f32,
}

/// How a cell counts as a place to be: walls not at all, outside a little, inside fully.
pub(crate) fn weight(cell: Cell, inside: f32) -> f64 {
    match cell {
        Cell::Wall | Cell::Window => 0.0,
        Cell::Unknown => UNKNOWN_WEIGHT,
        Cell::Free | Cell::Door => OUTSIDE_WEIGHT + (1.0 - OUTSIDE_WEIGHT) * f64::from(inside),
    }
}

/// The weight of a place, local metres; off the grid is outside.
pub(crate) fn weight_at(plan: &FloorPlan, (x, y): (f32, f32)) -> f64 {
    let at = plan.cell_at(Pt2::new(plan.origin().x + f64::from(x), plan.origin().y + f64::from(y)));
    at.map(|(column, row)| row * plan.width() + column).map_or(OUTSIDE_WEIGHT, |i| weight(plan.cells()[i], plan.inside()[i]))
}

/// Floor weighed by how likely one is on it, m².
pub(crate) fn weighted_area_m2(plan: &FloorPlan) -> f64 {
    let sum: f64 = plan.cells().iter().zip(plan.inside()).map(|(cell, inside)| weight(*cell, *inside)).sum();
    sum * plan.cell_m() * plan.cell_m()
}

/// `count` poses that cover the plan evenly by weight, all headings alike.
///
/// One sweep over the cells lays them out at equal shares of the weight (systematic sampling); headings follow the golden
/// ratio along the sweep, so that neighbours look in different directions (a Kronecker sequence).
pub(crate) fn cover(plan: &FloorPlan, count: usize, seed: Seed) -> Vec<LocalPose> {
    let mut rng = seed.derive("cover", count as u64);
    let total: f64 = plan.cells().iter().zip(plan.inside()).map(|(cell, inside)| weight(*cell, *inside)).sum();
    let apart = total / count.max(1) as f64;
    let mut next = apart * uniform(&mut rng);
    let mut heading = uniform(&mut rng);
    let mut swept = 0.0;
    let mut poses = Vec::with_capacity(count);
    for (index, (cell, inside)) in plan.cells().iter().zip(plan.inside()).enumerate() {
        swept += weight(*cell, *inside);
        while swept > next && poses.len() < count {
            next += apart;
            heading = (heading + 0.618_033_988_749_895).fract();
            let (column, row) = ((index % plan.width()) as f64, (index / plan.width()) as f64);
            poses.push(LocalPose {
                x: ((column + uniform(&mut rng)) * plan.cell_m()) as f32,
                y: ((row + uniform(&mut rng)) * plan.cell_m()) as f32,
                heading: wrap_angle(heading * std::f64::consts::TAU) as f32,
            });
        }
    }
    poses
}

/// `count` poses around a known start; draws that fall into walls are drawn anew, a few times.
pub(crate) fn around(start: &StartPrior, plan: &FloorPlan, walls: &Walls, count: usize, seed: Seed) -> Vec<LocalPose> {
    let mut rng = seed.derive("around", count as u64);
    let (x0, y0) = (start.x - plan.origin().x, start.y - plan.origin().y);
    let mut poses = Vec::with_capacity(count);
    for i in 0..count {
        let (mut x, mut y) = (x0 as f32, y0 as f32);
        for _ in 0..20 {
            x = (x0 + start.sigma_m * f64::from(normal(&mut rng))) as f32;
            y = (y0 + start.sigma_m * f64::from(normal(&mut rng))) as f32;
            if !walls.is_wall(x, y) {
                break;
            }
        }
        let heading = match start.heading_rad {
            Some(heading) => heading + start.sigma_rad * f64::from(normal(&mut rng)),
            None => (i as f64 * 0.618_033_988_749_895).fract() * std::f64::consts::TAU,
        };
        poses.push(LocalPose { x, y, heading: wrap_angle(heading) as f32 });
    }
    poses
}

/// Particles at these poses, with scales from the prior.
pub(crate) fn particles(poses: &[LocalPose], scale: &ScalePrior, seed: Seed) -> Particles {
    let mut rng = seed.derive("scale", poses.len() as u64);
    let (mean, sigma) = (scale.log_mean() as f32, scale.relative_sigma as f32);
    let mut particles = Particles::with_capacity(poses.len());
    for pose in poses {
        particles.push(pose.x, pose.y, pose.heading, mean + sigma * normal(&mut rng));
    }
    particles.set_equal_weights();
    particles
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;
    use planwalk_types::{Stamp, Step, Wall};

    fn plan() -> FloorPlan {
        let wall = |x0: f64, y0: f64, x1: f64, y1: f64| Wall { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1) };
        let walls = [wall(0.0, 0.0, 8.0, 0.0), wall(8.0, 0.0, 8.0, 4.0), wall(8.0, 4.0, 0.0, 4.0), wall(0.0, 4.0, 0.0, 0.0)];
        FloorPlan::from_walls(&walls, 0.05, 2.0).unwrap()
    }

    fn walk(speed: f64) -> Path {
        let step = |i: i64, forward: f64| Step {
            from: Stamp(i * 100_000_000),
            to: Stamp((i + 1) * 100_000_000),
            forward,
            left: 0.0,
            turn_rad: 0.0,
            covariance: Matrix3::zeros(),
            unit_change: 0.0,
        };
        // Half of the time standing.
        Path { steps: (0..100).map(|i| step(i, if i < 50 { 0.1 * speed } else { 0.0 })).collect() }
    }

    #[test]
    fn an_unknown_unit_is_the_one_that_makes_it_a_persons_walk() {
        let prior = ScalePrior::of(OdometryScale::Unknown, &walk(2.2));
        assert!((prior.metres_per_unit - 0.5).abs() < 0.02, "{prior:?}");
        let standing = ScalePrior::of(OdometryScale::Unknown, &walk(0.0));
        assert!(standing.metres_per_unit.is_finite() && standing.relative_sigma > prior.relative_sigma);
        assert_eq!(ScalePrior::of(OdometryScale::Relative(0.2), &walk(1.0)).relative_sigma, 0.2);
    }

    #[test]
    fn the_cover_is_even_inside_and_thin_outside() {
        let plan = plan();
        let poses = cover(&plan, 20_000, Seed(1));
        assert_eq!(poses.len(), 20_000);
        let share = |x0: f32, x1: f32| poses.iter().filter(|p| p.x > x0 && p.x < x1 && p.y > 2.5 && p.y < 5.5).count() as f64;
        // The room spans x 2..10 in the grid; two equal halves of it hold equal shares up to 4/√N.
        let (left, right) = (share(2.5, 6.0), share(6.0, 9.5));
        assert!((left / right - 1.0).abs() < 0.06, "{left} against {right}");
        let outside = poses.iter().filter(|p| p.x < 2.0 || p.x > 10.1 || p.y < 2.0 || p.y > 6.1).count();
        // The room has 32 m², the ground around it 64 m².
        let expected = 20_000.0 * 64.0 * OUTSIDE_WEIGHT / (32.0 + 64.0 * OUTSIDE_WEIGHT);
        // Walls take up to 2 % of the ground.
        assert!((outside as f64 / expected - 1.0).abs() < 0.05, "{outside} outside, {expected} expected");
        let east = poses.iter().filter(|p| p.heading.abs() < 0.5).count() as f64 / 20_000.0;
        assert!((east - 1.0 / std::f64::consts::TAU).abs() < 0.01, "a share of {east} looks east");
    }

    #[test]
    fn a_known_start_avoids_walls_and_keeps_its_spread() {
        let plan = plan();
        let walls = Walls::new(&plan, crate::walls::GroundCosts::default());
        let start = StartPrior { x: 4.0, y: 2.0, heading_rad: Some(1.0), sigma_m: 0.5, sigma_rad: 0.1 };
        let poses = around(&start, &plan, &walls, 4000, Seed(2));
        let mean_x = poses.iter().map(|p| f64::from(p.x)).sum::<f64>() / 4000.0 + plan.origin().x;
        assert!((mean_x - 4.0).abs() < 4.0 * 0.5 / 4000f64.sqrt(), "mean x {mean_x}");
        assert!(poses.iter().all(|p| !walls.is_wall(p.x, p.y)));
    }
}
