//! How does the body follow the route? It walks towards a point a little ahead, and slows down where it has to turn.
//!
//! Pure pursuit of a body that turns and accelerates as people do: at a bend it slows, at a dead end it turns round in small steps.

use planwalk_types::{Pt2, Seed, wrap_angle};
use rand::RngExt;

use super::WalkOptions;
use super::habits::{self, Habits};
use super::route::Route;
use crate::world::World;

/// Time between states, seconds.
pub(super) const TICK_S: f64 = 0.01;
/// How far ahead one walks to in the open, metres.
const AHEAD_M: f64 = 0.5;
/// The same as a share of the free space around, where that is less: in a doorway one keeps to the way.
const AHEAD_SHARE: f64 = 0.7;
/// Closer to anything than this the body does not go, metres: the clearance, and the sway.
const STOP_M: f64 = super::CLEARANCE_M + 0.03;
/// How far beyond that one looks for bends, metres.
const PREVIEW_M: f64 = 0.6;
/// Speed of a step aside, m/s.
const ASIDE_MPS: f64 = 0.3;
/// How far beyond a corner one looks to when turning on the spot, metres.
const SPOT_BEYOND_M: f64 = 0.9;
/// Speed while turning round, as a share of the pace.
const SMALL_STEPS: f64 = 0.25;
/// Largest change of speed, m/s².
const SPEEDING_MPS2: f64 = 1.1;
/// Largest change of the rate of turning, rad/s².
const TWISTING_RAD_S2: f64 = 4.0;

/// The body at one moment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stride {
    pub time_s: f64,
    pub x: f64,
    pub y: f64,
    /// Where the body points, radians; not wrapped, so that it can be interpolated.
    pub heading_rad: f64,
    pub turn_rate_rad_s: f64,
    pub speed_mps: f64,
    /// Steps taken so far; whole numbers are footfalls.
    pub steps: f64,
}

/// Walks the route for as long as the options say; stands before its end if there is time left.
pub(super) fn walk(route: &Route, world: &World, options: &WalkOptions, habits: &Habits, seed: Seed) -> Vec<Stride> {
    let mut rng = seed.derive("pace", 0);
    let rhythm: [f64; 2] = [rng.random_range(0.0..std::f64::consts::TAU), rng.random_range(0.07..0.13)];
    let (start, ahead) = (route.at(0.0), route.at(AHEAD_M));
    let heading_rad = libm::atan2(ahead[1] - start[1], ahead[0] - start[0]);
    let mut now = Stride { time_s: 0.0, x: start[0], y: start[1], heading_rad, turn_rate_rad_s: 0.0, speed_mps: 0.0, steps: 0.0 };
    let mut along_m: f64 = 0.0;
    let mut spots = Spots::new(habits::chosen(corners(route), options.turn_on_spot, seed));
    let count = (options.duration_s / TICK_S).ceil() as usize;
    let mut strides = Vec::with_capacity(count + 1);
    strides.push(now);
    for _ in 0..count {
        let free_m = world.clearance(Pt2::new(now.x, now.y));
        along_m = lead(route, &now, along_m, AHEAD_M.min(AHEAD_SHARE * free_m));
        let spot = spots.target(route, &now, along_m);
        // People are never quite steady; and they come to a stop by the end.
        let steady = 1.0 + options.speed_wander * libm::sin(rhythm[0] + std::f64::consts::TAU * rhythm[1] * now.time_s);
        let left_s = options.duration_s - 0.3 - now.time_s;
        let stop = (SPEEDING_MPS2 * left_s).max(0.0);
        let room_m = (route.length_m() - along_m + AHEAD_M - 0.3).max(0.0);
        let pace = (habits.pace_mps * steady).min(stop).min((2.0 * SPEEDING_MPS2 * room_m).sqrt());
        let pace = if spot.is_some() || habits.stands(now.time_s) { 0.0 } else { pace };
        let next = advance(now, route, spot.unwrap_or(along_m), pace, options.turn_rate_rad_s);
        let next_free_m = world.clearance(Pt2::new(next.x, next.y));
        // Too close, and coming closer: step aside and turn on towards the way.
        now = if next_free_m < STOP_M && next_free_m < free_m { step_aside(now, next, world) } else { next };
        strides.push(now);
    }
    strides
}

/// Where the route turns by more than 50° within 1.2 m: the sharpest place of each such bend, metres along the route.
fn corners(route: &Route) -> Vec<f64> {
    let bend = |at: f64| {
        let [a, b, c] = [at - 0.6, at, at + 0.6].map(|s| route.at(s));
        wrap_angle(libm::atan2(c[1] - b[1], c[0] - b[0]) - libm::atan2(b[1] - a[1], b[0] - a[0])).abs()
    };
    let bends: Vec<(f64, f64)> = (6..(route.length_m() / 0.1) as usize).map(|i| (0.1 * i as f64, bend(0.1 * i as f64))).collect();
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for (at, bend) in bends.into_iter().filter(|(_, bend)| *bend > 50f64.to_radians()) {
        match corners.last_mut() {
            Some(last) if at - last.0 < 1.5 => {
                if bend > last.1 {
                    *last = (at, bend);
                }
            }
            _ => corners.push((at, bend)),
        }
    }
    corners.into_iter().map(|(at, _)| at).collect()
}

/// Corners that are turned on the spot, one after the other.
struct Spots {
    corners: Vec<f64>,
    next: usize,
    /// Since when one turns, seconds.
    since_s: Option<f64>,
}

impl Spots {
    fn new(corners: Vec<f64>) -> Self {
        Self { corners, next: 0, since_s: None }
    }

    /// The place on the route to turn to, while one stands at a corner.
    fn target(&mut self, route: &Route, now: &Stride, along_m: f64) -> Option<f64> {
        let corner = *self.corners.get(self.next)?;
        // The way ahead has come round the corner: the body is close before it.
        if self.since_s.is_none() && along_m > corner + 0.15 {
            self.since_s = Some(now.time_s);
        }
        let since_s = self.since_s?;
        let beyond = corner + SPOT_BEYOND_M;
        let p = route.at(beyond);
        let error = wrap_angle(libm::atan2(p[1] - now.y, p[0] - now.x) - now.heading_rad);
        if error.abs() < 0.12 || now.time_s - since_s > 5.0 {
            (self.next, self.since_s) = (self.next + 1, None);
            return None;
        }
        Some(beyond)
    }
}

/// The place on the route that one walks to: it runs ahead until it is `ahead_m` away. Where the way turns back, it comes past the
/// body, and the body turns round; the place nearest to the body would be stuck there.
fn lead(route: &Route, now: &Stride, from_m: f64, ahead_m: f64) -> f64 {
    let mut along_m = from_m;
    // At most 5 cm a tick, so that a way that comes back beside itself is not cut short at once.
    for _ in 0..5 {
        let p = route.at(along_m);
        if libm::hypot(p[0] - now.x, p[1] - now.y) >= ahead_m {
            break;
        }
        along_m = (along_m + 0.01).min(route.length_m());
    }
    along_m
}

/// The next state of a body that must not go on: away from the nearest thing at [`ASIDE_MPS`], turning as it would have.
fn step_aside(now: Stride, next: Stride, world: &World) -> Stride {
    let slope = |dx: f64, dy: f64| world.clearance(Pt2::new(now.x + dx, now.y + dy)) - world.clearance(Pt2::new(now.x - dx, now.y - dy));
    let (gx, gy) = (slope(0.01, 0.0), slope(0.0, 0.01));
    let step = ASIDE_MPS * TICK_S / libm::hypot(gx, gy).max(1e-9);
    Stride { x: now.x + step * gx, y: now.y + step * gy, speed_mps: now.speed_mps.min(ASIDE_MPS), ..next }
}

fn advance(now: Stride, route: &Route, along_m: f64, pace: f64, turn_rate_limit: f64) -> Stride {
    let error_to = |ahead: f64| {
        let p = route.at(along_m + ahead);
        let (dx, dy) = (p[0] - now.x, p[1] - now.y);
        // Standing on the goal there is nowhere to turn to.
        if libm::hypot(dx, dy) < 0.05 { 0.0 } else { wrap_angle(libm::atan2(dy, dx) - now.heading_rad) }
    };
    let (error, bend) = (error_to(0.0), error_to(PREVIEW_M));
    // Full speed ahead, two thirds when a bend of 45° is near; where the way is behind one turns in a tight arc of small steps.
    let slow = (1.0 - 0.5 * (bend.abs() - 0.12).clamp(0.0, 1.3)) * ((1.35 - error.abs()) / 1.0).clamp(0.0, 1.0);
    let slow = slow.max(SMALL_STEPS);
    let speed_change = SPEEDING_MPS2 * TICK_S;
    let speed_mps = now.speed_mps + (pace * slow - now.speed_mps).clamp(-2.0 * speed_change, speed_change);
    let wanted = (3.0 * error).clamp(-turn_rate_limit, turn_rate_limit);
    let twist = TWISTING_RAD_S2 * TICK_S;
    let turn_rate_rad_s = now.turn_rate_rad_s + (wanted - now.turn_rate_rad_s).clamp(-twist, twist);
    let heading_rad = now.heading_rad + turn_rate_rad_s * TICK_S;
    let (s, c) = libm::sincos(heading_rad);
    // Cadence grows with the root of speed: slower walkers take shorter steps, too (1.9 steps/s at 1.15 m/s).
    let cadence = if speed_mps > 0.05 { 1.9 * (speed_mps / 1.15).sqrt() } else { 0.0 };
    Stride {
        time_s: now.time_s + TICK_S,
        x: now.x + c * speed_mps * TICK_S,
        y: now.y + s * speed_mps * TICK_S,
        heading_rad,
        turn_rate_rad_s,
        speed_mps,
        steps: now.steps + cadence * TICK_S,
    }
}

/// The body at any time, between the states around it.
pub(super) fn between(strides: &[Stride], time_s: f64) -> Stride {
    let place = (time_s / TICK_S).clamp(0.0, strides.len().saturating_sub(1) as f64);
    let i = (place as usize).min(strides.len().saturating_sub(2));
    let (a, b) = match strides.get(i..i + 2) {
        Some([a, b]) => (a, b),
        _ => return strides.first().copied().unwrap_or(STANDING),
    };
    let t = place - i as f64;
    let mix = |a: f64, b: f64| a + t * (b - a);
    Stride {
        time_s: mix(a.time_s, b.time_s),
        x: mix(a.x, b.x),
        y: mix(a.y, b.y),
        heading_rad: mix(a.heading_rad, b.heading_rad),
        turn_rate_rad_s: mix(a.turn_rate_rad_s, b.turn_rate_rad_s),
        speed_mps: mix(a.speed_mps, b.speed_mps),
        steps: mix(a.steps, b.steps),
    }
}

/// Nobody walks.
pub(super) const STANDING: Stride =
    Stride { time_s: 0.0, x: 0.0, y: 0.0, heading_rad: 0.0, turn_rate_rad_s: 0.0, speed_mps: 0.0, steps: 0.0 };
