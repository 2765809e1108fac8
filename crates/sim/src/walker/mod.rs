//! How does somebody walk here with a camera? A route through open doors, a natural speed, a gait, and a turning head.
//!
//! rooms ─▶ route over free space ─▶ pursuit (bounded speed, turning, acceleration) ─▶ gait and gaze ─▶ pose of the camera, any time
//!
//! Frames: plan metres, z up; `plan_from_camera`. Time: seconds from the start of the walk.

mod along;
mod gait;
mod habits;
mod pursuit;
mod route;
pub mod statistics;

use nalgebra::UnitQuaternion;
use planwalk_types::{Cam, Plan, PlanPose, Pt2, Rigid3, Seed, Stamp};
use serde::{Deserialize, Serialize};

use crate::building::Building;
use crate::error::{SimError, in_range};
use crate::world::{Footing, World};
use along::Along;
use gait::Gait;
use habits::Habits;
use pursuit::Stride;

/// Least distance of the walker's centre from anything, metres: half of a person's width and a hand.
pub const CLEARANCE_M: f64 = 0.35;

/// How long, how fast and how lively one walks. Every habit has a chance stream of its own; 0 turns it off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WalkOptions {
    /// Duration, seconds.
    pub duration_s: f64,
    /// Speed on straight ways, m/s; people walk at 0.6 to 1.6 indoors.
    pub speed_mps: f64,
    /// How far from that the walk's own speed is drawn, m/s, up or down.
    pub speed_spread_mps: f64,
    /// How far the speed wanders within a walk, as a share of it.
    pub speed_wander: f64,
    /// Height of the camera, metres; mean over the gait.
    pub camera_height_m: f64,
    /// Largest rate of turning of the body, rad/s; the head adds a little.
    pub turn_rate_rad_s: f64,
    /// How far the head looks around while walking, slowly, radians (amplitude).
    pub look_around_rad: f64,
    /// How strong the gait's bobbing and sway are; 1 is a person, 0 a trolley.
    pub gait: f64,
    /// Share of the corners at which one stops, turns on the spot, and goes on.
    pub turn_on_spot: f64,
    /// Stops of one to four seconds, a minute.
    pub stops_per_minute: f64,
    /// Glances to a side for a second or two, a minute.
    pub glances_per_minute: f64,
    /// How far to the side the widest of them go, radians.
    pub glance_rad: f64,
    /// Times a minute that the phone is tilted down for a few seconds.
    pub tilts_per_minute: f64,
    /// How far down the deepest of these go, radians.
    pub tilt_rad: f64,
    /// Trembling of the hand, radians (standard deviation of each of yaw, pitch and roll).
    pub tremor_rad: f64,
    /// Slow wandering of the hand, radians (standard deviation of each of pitch and roll).
    pub hand_drift_rad: f64,
}

impl Default for WalkOptions {
    /// Half a minute at an easy pace, camera at eye level, and nothing but walking.
    fn default() -> Self {
        Self {
            duration_s: 30.0,
            speed_mps: 1.2,
            speed_spread_mps: 0.0,
            speed_wander: 0.06,
            camera_height_m: 1.52,
            turn_rate_rad_s: 1.0,
            look_around_rad: 0.12,
            gait: 1.0,
            turn_on_spot: 0.0,
            stops_per_minute: 0.0,
            glances_per_minute: 0.0,
            glance_rad: 1.4,
            tilts_per_minute: 0.0,
            tilt_rad: 0.55,
            tremor_rad: 0.0,
            hand_drift_rad: 0.0,
        }
    }
}

impl WalkOptions {
    /// A walker with every habit that real ones have, in the measure of hand-held walks with known truth (`walk_statistics` of both
    /// side by side): phone at breast height, own pace, stops, glances, tilts, corners turned on the spot, a wandering, trembling hand.
    pub fn lively() -> Self {
        Self {
            duration_s: 60.0,
            speed_mps: 1.2,
            speed_spread_mps: 0.4,
            speed_wander: 0.12,
            camera_height_m: 1.42,
            turn_rate_rad_s: 1.7,
            look_around_rad: 0.2,
            gait: 1.5,
            turn_on_spot: 0.25,
            stops_per_minute: 0.6,
            glances_per_minute: 3.0,
            tilts_per_minute: 1.2,
            tremor_rad: 0.015,
            hand_drift_rad: 0.05,
            ..Self::default()
        }
    }

    fn check(&self) -> Result<(), SimError> {
        in_range("the duration in seconds", self.duration_s, 1.0, 3600.0)?;
        in_range("the walking speed in m/s", self.speed_mps, 0.3, 2.0)?;
        in_range("the spread of the walking speed in m/s", self.speed_spread_mps, 0.0, self.speed_mps - 0.3)?;
        in_range("the wandering of the speed", self.speed_wander, 0.0, 0.5)?;
        in_range("the camera height in metres", self.camera_height_m, 0.5, 2.3)?;
        in_range("the turn rate in rad/s", self.turn_rate_rad_s, 0.3, 4.0)?;
        in_range("looking around in radians", self.look_around_rad, 0.0, 0.8)?;
        in_range("the strength of the gait", self.gait, 0.0, 3.0)?;
        in_range("the share of corners turned on the spot", self.turn_on_spot, 0.0, 1.0)?;
        in_range("the stops a minute", self.stops_per_minute, 0.0, 20.0)?;
        in_range("the glances a minute", self.glances_per_minute, 0.0, 30.0)?;
        in_range("the width of glances in radians", self.glance_rad, 0.0, 2.0)?;
        in_range("the tilts a minute", self.tilts_per_minute, 0.0, 20.0)?;
        in_range("the depth of tilts in radians", self.tilt_rad, 0.0, 1.4)?;
        in_range("the tremor in radians", self.tremor_rad, 0.0, 0.2)?;
        in_range("the wandering of the hand in radians", self.hand_drift_rad, 0.0, 0.5)
    }
}

/// The camera at one moment.
#[derive(Debug, Clone, Copy)]
pub struct WalkPose {
    /// The camera in space.
    pub plan_from_camera: Rigid3<Plan, Cam>,
    /// The same on the floor; its heading is where the camera looks.
    pub on_floor: PlanPose,
}

/// A walk: a pose for every moment of it.
#[derive(Debug, Clone)]
pub struct Walk {
    duration_s: f64,
    course: Course,
    doors_passed: usize,
    turns: usize,
}

/// Where the poses come from.
#[derive(Debug, Clone)]
enum Course {
    /// A body that walks, and a camera on it.
    Walker { strides: Vec<Stride>, gait: Box<Gait> },
    /// Given poses.
    Given(Along),
}

/// Longest walk that can be given, seconds: stamps in another unit than is meant would ask for years of video.
const LONGEST_S: f64 = 36_000.0;
/// Routes tried before giving up. One in two is good enough, so 60 fail about once in 10¹⁸ where there is a way at all.
const TRIES: usize = 60;
/// Possible walks from which the one that tells most is taken.
const GOOD_ENOUGH: usize = 10;

impl Walk {
    /// A walk through the building: from room to room through open doors, never closer than [`CLEARANCE_M`] to anything.
    ///
    /// # Errors
    /// [`SimError::NoWalk`] when the rooms that can be reached do not allow one of this length, [`SimError::Option`].
    pub(crate) fn new(building: &Building, world: &World, options: &WalkOptions, seed: Seed) -> Result<Self, SimError> {
        options.check()?;
        let map = route::FreeMap::new(building, world);
        let habits = Habits::new(options, seed);
        // Enough way for the whole time at full speed; what is too much is not walked.
        let wanted_m = 1.05 * habits.pace_mps * options.duration_s;
        let gait = Gait::new(options, habits.clone(), seed);
        let (mut best, mut best_score, mut found_m): (Option<Self>, f64, f64) = (None, f64::NEG_INFINITY, 0.0);
        let mut good = 0;
        for attempt in 0..TRIES {
            let mut rng = seed.derive("route", attempt as u64);
            let Some(route) = map.route(wanted_m, &mut rng) else { continue };
            found_m = found_m.max(route.length_m());
            if route.length_m() < wanted_m {
                continue;
            }
            let strides = pursuit::walk(&route, world, options, &habits, seed);
            // Every 5 cm or so.
            let every = (0.05 / habits.pace_mps / pursuit::TICK_S).max(1.0) as usize;
            let clearance = |stride: &Stride| world.clearance(gait.pose(stride).on_floor.origin());
            if strides.iter().step_by(every).map(clearance).any(|free_m| free_m < CLEARANCE_M) {
                continue;
            }
            let (doors_passed, turns) = (doors_passed(building, &strides), turns(&strides));
            let score = score(building, &strides, doors_passed, turns);
            let course = Course::Walker { strides, gait: Box::new(gait.clone()) };
            let walk = Self { duration_s: options.duration_s, course, doors_passed, turns };
            if score > best_score {
                (best, best_score) = (Some(walk), score);
            }
            good += 1;
            if good == GOOD_ENOUGH {
                break;
            }
        }
        best.ok_or(SimError::NoWalk { wanted_m, found_m, tries: TRIES })
    }

    /// A walk along given poses of a sensor to which the camera is fixed, turned by `mount` (`sensor_from_camera`; the identity where
    /// the poses are the camera's own: x right, y down, z forward). Any rate, any height, any way up; time counts from the first pose,
    /// and the frame rate is the camera's. Whether the path leads through walls is not checked.
    ///
    /// # Errors
    /// [`SimError::Path`] for fewer than two poses, stamps that do not increase, or numbers that are not finite; [`SimError::Option`]
    /// for a walk of more than ten hours.
    pub fn along(plan_from_sensor: &[(Stamp, Rigid3<Plan, Cam>)], mount: UnitQuaternion<f64>) -> Result<Self, SimError> {
        let along = Along::new(plan_from_sensor, mount)?;
        in_range("the duration of the given walk in seconds", along.duration_s(), 0.0, LONGEST_S)?;
        let mut walk = Self { duration_s: along.duration_s(), course: Course::Given(along), doors_passed: 0, turns: 0 };
        walk.turns = turns(&walk.floor_line());
        Ok(walk)
    }

    /// Counts the doors of a building that the walk goes through.
    pub(crate) fn count_doors(&mut self, building: &Building) {
        self.doors_passed = doors_passed(building, &self.floor_line());
    }

    /// How long it takes, seconds.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Doors walked through.
    pub fn doors_passed(&self) -> usize {
        self.doors_passed
    }

    /// Bends of more than 60° within two metres.
    pub fn turns(&self) -> usize {
        self.turns
    }

    /// Length on the floor, metres; without the sway where a body walks, of the smoothed path where poses are given.
    pub fn length_m(&self) -> f64 {
        let line = match &self.course {
            Course::Walker { strides, .. } => strides,
            Course::Given(_) => &self.floor_line(),
        };
        line.windows(2).map(|w| libm::hypot(w[1].x - w[0].x, w[1].y - w[0].y)).sum()
    }

    /// The camera at `seconds` from the start; before and after the walk it is where the walk began or ended.
    pub fn at(&self, seconds: f64) -> WalkPose {
        match &self.course {
            Course::Walker { strides, gait } => gait.pose(&pursuit::between(strides, seconds)),
            Course::Given(along) => {
                let plan_from_camera = along.at(seconds);
                WalkPose { plan_from_camera, on_floor: plan_from_camera.body().on_floor() }
            }
        }
    }

    /// The camera's way on the floor, ten places a second: what other people go by.
    pub(crate) fn footings(&self) -> Vec<Footing> {
        self.floor_line().iter().map(|s| Footing { x: s.x, y: s.y, heading_rad: s.heading_rad }).collect()
    }

    /// The camera's way on the floor, ten times a second, each place the mean over a second: what the feet did, more or less.
    fn floor_line(&self) -> Vec<Stride> {
        let count = (self.duration_s * 10.0).floor() as usize;
        let places: Vec<[f64; 2]> = (0..=count).map(|i| self.at(0.1 * i as f64).on_floor).map(|p| [p.x, p.y]).collect();
        let mean = |i: usize| {
            let window = &places[i.saturating_sub(5)..(i + 6).min(places.len())];
            let sum = window.iter().fold([0.0, 0.0], |s, p| [s[0] + p[0], s[1] + p[1]]);
            [sum[0] / window.len() as f64, sum[1] / window.len() as f64]
        };
        let smooth: Vec<[f64; 2]> = (0..places.len()).map(mean).collect();
        let mut heading_rad = 0.0;
        (0..smooth.len())
            .map(|i| {
                let (a, b) = (smooth[i.saturating_sub(1)], smooth[(i + 1).min(smooth.len() - 1)]);
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                // Who stands keeps the heading that he came with; headings are not wrapped.
                if libm::hypot(dx, dy) > 0.02 {
                    heading_rad += planwalk_types::wrap_angle(libm::atan2(dy, dx) - heading_rad);
                }
                Stride { time_s: 0.1 * i as f64, x: smooth[i][0], y: smooth[i][1], heading_rad, ..pursuit::STANDING }
            })
            .collect()
    }
}

/// How much a walk tells: rooms seen, doors passed, ways not walked twice, little time spent on turning round.
fn score(building: &Building, strides: &[Stride], doors_passed: usize, turns: usize) -> f64 {
    let mut rooms = vec![false; building.rooms.len()];
    let mut cells = std::collections::BTreeSet::new();
    for stride in strides {
        if let Some(room) = building.room_at(Pt2::new(stride.x, stride.y)) {
            rooms[room] = true;
        }
        cells.insert(((stride.x * 2.0) as i64, (stride.y * 2.0) as i64));
    }
    let rooms = rooms.iter().filter(|r| **r).count() as f64;
    let length_m: f64 = strides.windows(2).map(|w| libm::hypot(w[1].x - w[0].x, w[1].y - w[0].y)).sum();
    // Half-metre cells entered for each metre walked: near 2 when no way is walked twice.
    let fresh = cells.len() as f64 / length_m.max(1.0);
    let slow_s = strides.iter().filter(|s| s.speed_mps < 0.35).count() as f64 * pursuit::TICK_S;
    let duration_s = strides.last().map_or(1.0, |s| s.time_s).max(1.0);
    rooms + doors_passed as f64 + 0.5 * turns.min(4) as f64 + 6.0 * fresh - 15.0 * slow_s / duration_s
}

/// How many doors a walk goes through.
fn doors_passed(building: &Building, strides: &[Stride]) -> usize {
    let crosses = |a: &Stride, b: &Stride, from: Pt2<Plan>, to: Pt2<Plan>| {
        let side = |p: (f64, f64), q: (f64, f64), r: (f64, f64)| (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0);
        let (a, b, from, to) = ((a.x, a.y), (b.x, b.y), (from.x, from.y), (to.x, to.y));
        side(a, b, from) * side(a, b, to) < 0.0 && side(from, to, a) * side(from, to, b) < 0.0
    };
    let through = |from, to| strides.windows(2).filter(|w| crosses(&w[0], &w[1], from, to)).count();
    building.doors.iter().map(|door| through(door.opening.from, door.opening.to)).sum()
}

/// Bends of more than 60° within two metres of way.
fn turns(strides: &[Stride]) -> usize {
    let (mut count, mut since_m, mut from_rad) = (0, 0.0, strides.first().map_or(0.0, |s| s.heading_rad));
    for pair in strides.windows(2) {
        since_m += libm::hypot(pair[1].x - pair[0].x, pair[1].y - pair[0].y);
        if since_m > 2.0 {
            count += usize::from((pair[1].heading_rad - from_rad).abs() > std::f64::consts::FRAC_PI_3);
            (since_m, from_rad) = (0.0, pair[1].heading_rad);
        }
    }
    count
}
