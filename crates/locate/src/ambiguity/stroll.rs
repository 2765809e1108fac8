//! Which way would somebody walk from here? Ahead where it is open, now and then to where one wishes, never into a wall.

use planwalk_types::{FloorPlan, PlanPose, StreamRng, wrap_angle};
use rand::RngExt;

use crate::walls::Walls;

/// A pose in metres from the plan's corner, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub x: f64,
    pub y: f64,
    pub heading: f64,
}

impl Pose {
    /// The same in the plan's frame.
    pub(super) fn on(self, plan: &FloorPlan) -> PlanPose {
        PlanPose::new(plan.origin().x + self.x, plan.origin().y + self.y, self.heading)
    }
}

/// Metres of a step.
const STEP_M: f64 = 0.25;
/// Room that a person needs to each side, metres.
const ROOM_M: f64 = 0.25;
/// Directions that are weighed.
const DIRECTIONS: usize = 32;
/// Metres after which one wishes to go elsewhere.
const WISH_M: f64 = 7.0;
/// How far one looks where to go, metres.
const LOOK_M: f64 = 5.0;

/// Whether a person has room here.
pub(super) fn stands(walls: &Walls, x: f64, y: f64) -> bool {
    !walls.is_wall(x as f32, y as f32) && (0..8).all(|i| open_m(walls, x, y, f64::from(i) * std::f64::consts::FRAC_PI_4, 1.0) > ROOM_M)
}

fn open_m(walls: &Walls, x: f64, y: f64, heading: f64, limit_m: f64) -> f64 {
    let (s, c) = libm::sincos(heading);
    f64::from(walls.cast(x as f32, y as f32, c as f32, s as f32, limit_m as f32))
}

/// How far a person of some width can go.
fn way_m(walls: &Walls, at: &Pose, heading: f64) -> f64 {
    let (s, c) = libm::sincos(heading);
    let beside = |side: f64| open_m(walls, at.x - side * s, at.y + side * c, heading, LOOK_M);
    open_m(walls, at.x, at.y, heading, LOOK_M).min(beside(0.8 * ROOM_M)).min(beside(-0.8 * ROOM_M))
}

/// Poses every `every_m` along a walk of `length_m`, the start first.
pub(super) fn walk(walls: &Walls, start: Pose, length_m: f64, every_m: f64, rng: &mut StreamRng) -> Vec<Pose> {
    let mut at = start;
    let mut poses = vec![at];
    let mut wish = at.heading;
    let (mut walked, mut wished) = (0.0, 0.0);
    // One who has no room to step turns on the spot; such looks count as walked, or a walk in a cupboard would never end.
    let steps = (length_m / STEP_M).round() as usize;
    for _ in 0..steps {
        if walked - wished >= WISH_M {
            (wish, wished) = (rng.random_range(0.0..std::f64::consts::TAU), walked);
        }
        at.heading = wrap_angle(turned(walls, &at, wish));
        let (s, c) = libm::sincos(at.heading);
        if open_m(walls, at.x, at.y, at.heading, 1.0) > STEP_M + ROOM_M {
            (at.x, at.y) = (at.x + STEP_M * c, at.y + STEP_M * s);
        }
        walked += STEP_M;
        if walked + 1e-9 >= poses.len() as f64 * every_m {
            poses.push(at);
        }
    }
    poses
}

/// The heading of the next step: towards where it is open, ahead and wished; at most 30° of turn.
fn turned(walls: &Walls, at: &Pose, wish: f64) -> f64 {
    let mut best = (f64::NEG_INFINITY, 0.0);
    for i in 0..DIRECTIONS {
        let turn = wrap_angle(i as f64 * std::f64::consts::TAU / DIRECTIONS as f64);
        let heading = at.heading + turn;
        let way = way_m(walls, at, heading);
        // A way of a step is none; beyond that ahead is better than wished, and wished better than far.
        let closed = if way < STEP_M + ROOM_M { 10.0 } else { 0.0 };
        let score = 0.4 * way - 1.1 * turn.abs() + 0.7 * libm::cos(heading - wish) - closed;
        if score > best.0 {
            best = (score, turn);
        }
    }
    at.heading + best.1.clamp(-0.53, 0.53)
}
