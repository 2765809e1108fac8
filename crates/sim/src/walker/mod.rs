//! How does somebody walk here with a camera? A route through open doors, a natural speed, a gait, and a turning head.
//!
//! rooms ─▶ route over free space ─▶ pursuit (bounded speed, turning, acceleration) ─▶ gait and gaze ─▶ pose of the camera, any time
//!
//! Frames: plan metres, z up; `plan_from_camera`. Time: seconds from the start of the walk.

mod gait;
mod pursuit;
mod route;

use planwalk_types::{Cam, Plan, PlanPose, Pt2, Rigid3, Seed};

use crate::building::Building;
use crate::error::{SimError, in_range};
use crate::world::World;
use gait::Gait;
use pursuit::Stride;

/// Least distance of the walker's centre from anything, metres: half of a person's width and a hand.
pub const CLEARANCE_M: f64 = 0.35;

/// How long, how fast and how lively one walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WalkOptions {
    /// Duration, seconds.
    pub duration_s: f64,
    /// Frames per second.
    pub fps: f64,
    /// Speed on straight ways, m/s; people walk at 0.8 to 1.4 indoors.
    pub speed_mps: f64,
    /// Height of the camera, metres; mean over the gait.
    pub camera_height_m: f64,
    /// Largest rate of turning of the body, rad/s; the head adds a little.
    pub turn_rate_rad_s: f64,
    /// How far the head looks around, radians (amplitude).
    pub look_around_rad: f64,
    /// How strong the gait's bobbing and sway are; 1 is a person, 0 a trolley.
    pub gait: f64,
}

impl Default for WalkOptions {
    /// Half a minute at 15 frames/s and an easy pace, camera at eye level.
    fn default() -> Self {
        Self { duration_s: 30.0, fps: 15.0, speed_mps: 1.2, camera_height_m: 1.52, turn_rate_rad_s: 1.0, look_around_rad: 0.12, gait: 1.0 }
    }
}

impl WalkOptions {
    fn check(&self) -> Result<(), SimError> {
        in_range("the duration in seconds", self.duration_s, 1.0, 3600.0)?;
        in_range("the frame rate in frames per second", self.fps, 0.5, 1000.0)?;
        in_range("the walking speed in m/s", self.speed_mps, 0.3, 2.0)?;
        in_range("the camera height in metres", self.camera_height_m, 0.5, 2.3)?;
        in_range("the turn rate in rad/s", self.turn_rate_rad_s, 0.3, 4.0)?;
        in_range("looking around in radians", self.look_around_rad, 0.0, 0.8)?;
        in_range("the strength of the gait", self.gait, 0.0, 3.0)
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
    options: WalkOptions,
    strides: Vec<Stride>,
    gait: Gait,
    doors_passed: usize,
    turns: usize,
}

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
        // Enough way for the whole time at full speed; what is too much is not walked.
        let wanted_m = 1.05 * options.speed_mps * options.duration_s;
        let gait = Gait::new(options, seed);
        let (mut best, mut best_score, mut found_m): (Option<Self>, f64, f64) = (None, f64::NEG_INFINITY, 0.0);
        let mut good = 0;
        for attempt in 0..TRIES {
            let mut rng = seed.derive("route", attempt as u64);
            let Some(route) = map.route(wanted_m, &mut rng) else { continue };
            found_m = found_m.max(route.length_m());
            if route.length_m() < wanted_m {
                continue;
            }
            let strides = pursuit::walk(&route, world, options, seed);
            let (doors_passed, turns) = (doors_passed(building, &strides), turns(&strides));
            let walk = Self { options: *options, strides, gait: gait.clone(), doors_passed, turns };
            if walk.least_clearance_m(world) < CLEARANCE_M {
                continue;
            }
            let score = walk.score(building);
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

    /// The options it was made with.
    pub fn options(&self) -> &WalkOptions {
        &self.options
    }

    /// Doors walked through.
    pub fn doors_passed(&self) -> usize {
        self.doors_passed
    }

    /// Bends of more than 60° within two metres.
    pub fn turns(&self) -> usize {
        self.turns
    }

    /// Length on the floor, without the sway, metres.
    pub fn length_m(&self) -> f64 {
        self.strides.windows(2).map(|w| libm::hypot(w[1].x - w[0].x, w[1].y - w[0].y)).sum()
    }

    /// The camera at `seconds` from the start; before and after the walk it is where the walk began or ended.
    pub fn at(&self, seconds: f64) -> WalkPose {
        self.gait.pose(&pursuit::between(&self.strides, seconds))
    }

    /// Least distance of the camera to anything that is in the way, metres.
    fn least_clearance_m(&self, world: &World) -> f64 {
        // Every 5 cm or so.
        let every = (0.05 / self.options.speed_mps / pursuit::TICK_S).max(1.0) as usize;
        self.strides
            .iter()
            .step_by(every)
            .map(|stride| world.clearance(self.gait.pose(stride).on_floor.origin()))
            .fold(f64::INFINITY, f64::min)
    }

    /// How much a walk tells: rooms seen, doors passed, ways not walked twice, little time spent on turning round.
    fn score(&self, building: &Building) -> f64 {
        let mut rooms = vec![false; building.rooms.len()];
        let mut cells = std::collections::BTreeSet::new();
        for stride in &self.strides {
            if let Some(room) = building.room_at(Pt2::new(stride.x, stride.y)) {
                rooms[room] = true;
            }
            cells.insert(((stride.x * 2.0) as i64, (stride.y * 2.0) as i64));
        }
        let rooms = rooms.iter().filter(|r| **r).count() as f64;
        // Half-metre cells entered for each metre walked: near 2 when no way is walked twice.
        let fresh = cells.len() as f64 / self.length_m().max(1.0);
        let slow_s = self.strides.iter().filter(|s| s.speed_mps < 0.35).count() as f64 * pursuit::TICK_S;
        rooms + self.doors_passed as f64 + 0.5 * self.turns.min(4) as f64 + 6.0 * fresh - 15.0 * slow_s / self.options.duration_s
    }
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
