//! Who else walks here? People before the camera, towards it, across its way, and some who stand: until they fill the view as asked.
//!
//! camera's way ─▶ trail (with the room beside it) ─▶ candidates, one by one ─▶ taken while the view is emptier than wanted
//!
//! They keep to the camera's own way, ahead of it or against it, or to free lines across it, so walls are not walked through; in
//! narrow places they fall into single file. They are in the pictures alone: neither on the plan nor in the truth.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Vector3};
use planwalk_types::{Pt2, Seed, StreamRng, wrap_angle};
use rand::{Rng, RngExt};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::World;
use super::figure::{Body, Cast, Figure, Posture};
use crate::error::{SimError, in_range};
use crate::render::{Sightline, bin};

/// Distance between points of a trail, metres.
const POINT_M: f64 = 0.1;
/// Half of a person's width with arms, metres: kept from walls.
const HALF_WIDTH_M: f64 = 0.28;
/// Nobody comes closer to the camera than this, metres.
const PERSONAL_M: f64 = 0.7;
/// Way for which one would have walked while turning round, metres.
const TURN_M: f64 = 0.5;
/// Further away than this nobody is drawn, metres.
const FAR_M: f64 = 35.0;
/// People tried before the view is taken as it is.
const CANDIDATES: u64 = 400;
/// A person who fills less of the view than this over the whole walk is not worth drawing.
const WORTH: f64 = 5e-4;

/// How many people walk about, and how. The four weights say how often each kind is drawn; only their ratios count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct People {
    /// Share of the view that people fill on average over the walk, 0..=0.5; 0 is an empty building.
    pub share: f64,
    /// Weight of those who walk ahead of the camera, the same way.
    pub ahead: f64,
    /// Weight of those who come towards it.
    pub oncoming: f64,
    /// Weight of those who go to and fro across its way.
    pub crossing: f64,
    /// Weight of those who stand beside its way.
    pub standing: f64,
}

impl Default for People {
    /// Nobody.
    fn default() -> Self {
        Self { share: 0.0, ahead: 1.0, oncoming: 1.5, crossing: 1.0, standing: 1.0 }
    }
}

impl People {
    /// People who fill this share of the view.
    pub fn filling(share: f64) -> Self {
        Self { share, ..Self::default() }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`SimError::Option`] names what is outside its range.
    pub fn check(&self) -> Result<(), SimError> {
        in_range("the share of the view that people fill", self.share, 0.0, 0.5)?;
        in_range("the weight of people ahead", self.ahead, 0.0, 1e6)?;
        in_range("the weight of oncoming people", self.oncoming, 0.0, 1e6)?;
        in_range("the weight of crossing people", self.crossing, 0.0, 1e6)?;
        in_range("the weight of standing people", self.standing, 0.0, 1e6)?;
        let sum = self.ahead + self.oncoming + self.crossing + self.standing;
        if self.share > 0.0 { in_range("the sum of the weights of people", sum, 1e-6, 4e6) } else { Ok(()) }
    }
}

/// The camera's place on the floor at one moment, ten of them a second.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footing {
    pub x: f64,
    pub y: f64,
    pub heading_rad: f64,
}

/// What the camera looks at at one moment, coarsely: rays, and where walls end them.
pub(crate) struct Watch {
    pub time_s: f64,
    pub plan_from_camera: Isometry3<f64>,
    pub rays: Vec<Sightline>,
}

/// Everybody who is there.
#[derive(Debug, Clone, Default)]
pub(crate) struct Crowd {
    persons: Vec<Person>,
    trail: Trail,
}

#[derive(Debug, Clone)]
struct Person {
    body: Body,
    way: Way,
}

/// Where somebody goes.
#[derive(Debug, Clone, Copy)]
enum Way {
    /// Along the camera's trail, before it.
    Ahead { gap_m: f64, wave_m: f64, hertz: f64, phase: f64, left_m: f64 },
    /// Along the trail against it.
    Toward { meet_s: f64, meet_m: f64, speed_mps: f64, left_m: f64 },
    /// To and fro on a line.
    Across { from: [f64; 2], direction_rad: f64, length_m: f64, speed_mps: f64, phase_m: f64 },
    /// On the spot.
    Stand { at: [f64; 2], heading_rad: f64, phase: f64 },
}

impl Crowd {
    /// Draws people until they fill the share of the view that is asked for, seen from `watches`.
    pub fn gather(people: &People, world: &World, footings: &[Footing], watches: &[Watch], seed: Seed) -> Self {
        let mut crowd = Self::default();
        if people.share <= 0.0 || footings.is_empty() {
            return crowd;
        }
        crowd.trail = Trail::new(world, footings);
        let rays: usize = watches.iter().map(|w| w.rays.len()).sum();
        let mut covered: Vec<Vec<bool>> = watches.iter().map(|w| vec![false; w.rays.len()]).collect();
        let mut filled = 0.0;
        for k in 0..CANDIDATES {
            let mut rng = seed.derive("people", k);
            let Some(person) = crowd.candidate(people, world, &mut rng) else { continue };
            if crowd.jostles(&person, people.share, watches) {
                continue;
            }
            let added: Vec<Vec<usize>> =
                watches.par_iter().zip(&covered).map(|(watch, covered)| crowd.newly_covered(&person, watch, covered)).collect();
            let share = added.iter().map(Vec::len).sum::<usize>() as f64 / rays.max(1) as f64;
            if share < WORTH || filled + share > 1.08 * people.share {
                continue;
            }
            filled += share;
            for (covered, added) in covered.iter_mut().zip(added) {
                added.into_iter().for_each(|i| covered[i] = true);
            }
            crowd.persons.push(person);
            if filled > 0.94 * people.share {
                break;
            }
        }
        crowd
    }

    /// Who can be seen by a camera at a moment.
    pub fn cast(&self, time_s: f64, plan_from_camera: &Isometry3<f64>) -> Cast {
        let eye = plan_from_camera.translation.vector;
        let seen = self.persons.iter().enumerate();
        let mut figures: Vec<Figure> = seen.filter_map(|(k, person)| self.figure(person, k as u32, time_s, plan_from_camera)).collect();
        // Who is near hides others, who then need not be tried.
        figures.sort_by(|a, b| a.distance2([eye.x, eye.y]).total_cmp(&b.distance2([eye.x, eye.y])));
        Cast::new(&figures, [eye.x, eye.y, eye.z])
    }

    /// The figure of a person, where the camera might see it.
    fn figure(&self, person: &Person, id: u32, time_s: f64, plan_from_camera: &Isometry3<f64>) -> Option<Figure> {
        let mut posture = self.trail.posture(person, time_s);
        let eye = plan_from_camera.translation.vector;
        let (mut dx, mut dy) = (posture.x - eye.x, posture.y - eye.y);
        let mut distance = libm::hypot(dx, dy);
        if distance < PERSONAL_M {
            // One gives way.
            let push = PERSONAL_M / distance.max(1e-3);
            (dx, dy, distance) = (dx * push, dy * push, PERSONAL_M);
            (posture.x, posture.y) = (eye.x + dx, eye.y + dy);
        }
        let forward = plan_from_camera.rotation * Vector3::z();
        let behind = (forward.x * dx + forward.y * dy) < -0.35 * distance;
        if distance > FAR_M || (behind && distance > 1.0) {
            return None;
        }
        Some(Figure::new(&person.body, &posture, id))
    }

    /// Rays of a watch that this person alone would end.
    fn newly_covered(&self, person: &Person, watch: &Watch, covered: &[bool]) -> Vec<usize> {
        let Some(figure) = self.figure(person, 0, watch.time_s, &watch.plan_from_camera) else { return Vec::new() };
        let eye = watch.plan_from_camera.translation.vector;
        let cast = Cast::new(&[figure], [eye.x, eye.y, eye.z]);
        let hit = |ray: &Sightline| cast.meet(bin(ray.direction), ray.direction, ray.t).is_some();
        watch.rays.iter().enumerate().filter(|(i, ray)| !covered[*i] && hit(ray)).map(|(i, _)| i).collect()
    }

    /// Whether somebody would walk inside others for more than a moment.
    fn jostles(&self, person: &Person, share: f64, watches: &[Watch]) -> bool {
        // Where they are to fill half of the view they have to crowd.
        let (apart_m, bearable) = if share > 0.2 { (0.35, 0.2) } else { (0.5, 0.05) };
        let meets = |watch: &&Watch| {
            let one = self.trail.posture(person, watch.time_s);
            self.persons.iter().any(|other| {
                let other = self.trail.posture(other, watch.time_s);
                libm::hypot(one.x - other.x, one.y - other.y) < apart_m
            })
        };
        watches.iter().filter(meets).count() as f64 > bearable * watches.len() as f64
    }

    fn candidate(&self, people: &People, world: &World, rng: &mut StreamRng) -> Option<Person> {
        let body = Body { height_m: rng.random_range(1.55..1.92), seed: rng.next_u32() };
        let weights = [people.ahead, people.oncoming, people.crossing, people.standing];
        let mut throw = rng.random_range(0.0..1.0) * weights.iter().sum::<f64>();
        let kind = weights.iter().position(|w| {
            throw -= w;
            throw < 0.0
        });
        let trail = &self.trail;
        let when_s = rng.random_range(0.0..1.0) * trail.duration_s();
        let way = match kind.unwrap_or(0) {
            0 => {
                // The fuller the view is to be, the closer they walk.
                let near_m = 2.8 - 4.2 * people.share;
                let u: f64 = rng.random_range(0.0..1.0);
                Way::Ahead {
                    gap_m: near_m + 4.0 * u * u,
                    wave_m: 0.12 * near_m,
                    hertz: rng.random_range(0.03..0.08),
                    phase: rng.random_range(0.0..TAU),
                    left_m: rng.random_range(-0.75..0.75),
                }
            }
            1 => {
                let side = if rng.random_range(0.0..1.0) < 0.75 { -1.0 } else { 1.0 };
                let meet_s = when_s + rng.random_range(0.0..5.0);
                let left_m = side * rng.random_range(0.5..0.8);
                Way::Toward { meet_s, meet_m: trail.camera_at(meet_s), speed_mps: rng.random_range(0.9..1.5), left_m }
            }
            2 => across(trail.at(trail.camera_at(when_s) + rng.random_range(1.8..5.0)), world, rng)?,
            _ => {
                let along_m = trail.camera_at(when_s) + rng.random_range(1.0..4.0);
                let side = if rng.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 };
                let room_m = trail.room(along_m);
                // Where there is no room beside the way one does not stand.
                if room_m < 0.5 {
                    return None;
                }
                let spot = trail.at(along_m);
                let at = spot.beside(side * room_m.min(1.4));
                let heading_rad = spot.heading_rad - side * rng.random_range(0.6..2.4);
                Way::Stand { at, heading_rad, phase: rng.random_range(0.0..TAU) }
            }
        };
        Some(Person { body, way })
    }
}

/// A free line across the way, if it is long enough to walk on.
fn across(spot: Spot, world: &World, rng: &mut StreamRng) -> Option<Way> {
    let direction_rad = spot.heading_rad + 0.5 * PI + rng.random_range(-0.5..0.5);
    let (s, c) = libm::sincos(direction_rad);
    let free = |sign: f64| {
        let reach = (1..60).take_while(|i| {
            let off = sign * POINT_M * f64::from(*i);
            world.clearance(Pt2::new(spot.x + off * c, spot.y + off * s)) > HALF_WIDTH_M
        });
        POINT_M * reach.count() as f64
    };
    let (back_m, on_m) = (free(-1.0), free(1.0));
    let length_m = back_m + on_m;
    let from = [spot.x - back_m * c, spot.y - back_m * s];
    let (speed_mps, phase_m) = (rng.random_range(0.7..1.3), rng.random_range(0.0..2.0) * length_m);
    (length_m > 1.6).then_some(Way::Across { from, direction_rad, length_m, speed_mps, phase_m })
}

/// A place on the trail.
#[derive(Debug, Clone, Copy)]
struct Spot {
    x: f64,
    y: f64,
    heading_rad: f64,
}

impl Spot {
    fn beside(&self, left_m: f64) -> [f64; 2] {
        let (s, c) = libm::sincos(self.heading_rad);
        [self.x - s * left_m, self.y + c * left_m]
    }
}

/// The camera's way, prolonged at both ends as far as there is room, and the room that people have beside it.
#[derive(Debug, Clone, Default)]
struct Trail {
    spots: Vec<Spot>,
    /// How far to a side one may walk, metres.
    room_m: Vec<f64>,
    /// How far along the trail the camera is, ten times a second, metres.
    camera_m: Vec<f64>,
}

impl Trail {
    fn new(world: &World, footings: &[Footing]) -> Self {
        let (Some(first), Some(last)) = (footings.first(), footings.last()) else { return Self::default() };
        let free = |x: f64, y: f64| world.clearance(Pt2::new(x, y));
        let stretch = |from: &Footing, sign: f64| {
            let (s, c) = libm::sincos(from.heading_rad);
            let at = |i: usize| [from.x + sign * POINT_M * i as f64 * c, from.y + sign * POINT_M * i as f64 * s];
            (1..80).map(at).take_while(|p| free(p[0], p[1]) > HALF_WIDTH_M + 0.1).collect::<Vec<_>>()
        };
        let mut points = stretch(first, -1.0);
        points.reverse();
        points.push([first.x, first.y]);
        let mut camera_m = Vec::with_capacity(footings.len());
        let base_m = POINT_M * (points.len() - 1) as f64;
        let (mut walked_m, mut before) = (0.0, [first.x, first.y]);
        for footing in footings {
            let (dx, dy) = (footing.x - before[0], footing.y - before[1]);
            let step_m = libm::hypot(dx, dy);
            // Points at whole multiples of their distance.
            let done = (points.len() - 1) as f64 * POINT_M - base_m;
            let mut next = done + POINT_M;
            while next <= walked_m + step_m && step_m > 0.0 {
                let share = (next - walked_m) / step_m;
                points.push([before[0] + share * dx, before[1] + share * dy]);
                next += POINT_M;
            }
            walked_m += step_m;
            camera_m.push(base_m + walked_m);
            before = [footing.x, footing.y];
        }
        points.extend(stretch(last, 1.0));
        let heading = |i: usize| {
            let (a, b) = (points[i.saturating_sub(4)], points[(i + 4).min(points.len() - 1)]);
            if a == b { first.heading_rad } else { libm::atan2(b[1] - a[1], b[0] - a[0]) }
        };
        let spots = points.iter().enumerate().map(|(i, p)| Spot { x: p[0], y: p[1], heading_rad: heading(i) }).collect();
        let clear: Vec<f64> = points.iter().map(|p| (free(p[0], p[1]) - HALF_WIDTH_M).max(0.0)).collect();
        let window = |i: usize, values: &[f64]| i.saturating_sub(5)..(i + 6).min(values.len());
        let least: Vec<f64> = (0..clear.len()).map(|i| clear[window(i, &clear)].iter().copied().fold(f64::INFINITY, f64::min)).collect();
        let room_m = (0..least.len()).map(|i| least[window(i, &least)].iter().sum::<f64>() / window(i, &least).len() as f64).collect();
        Self { spots, room_m, camera_m }
    }

    fn duration_s(&self) -> f64 {
        0.1 * self.camera_m.len().saturating_sub(1) as f64
    }

    fn length_m(&self) -> f64 {
        POINT_M * self.spots.len().saturating_sub(1) as f64
    }

    /// How far along the trail the camera is at a moment.
    fn camera_at(&self, time_s: f64) -> f64 {
        between(&self.camera_m, time_s / 0.1)
    }

    fn room(&self, along_m: f64) -> f64 {
        between(&self.room_m, along_m / POINT_M)
    }

    fn at(&self, along_m: f64) -> Spot {
        let place = (along_m / POINT_M).clamp(0.0, self.spots.len().saturating_sub(1) as f64);
        let i = place as usize;
        let (Some(a), Some(b)) = (self.spots.get(i), self.spots.get(i + 1).or(self.spots.get(i))) else {
            return Spot { x: 0.0, y: 0.0, heading_rad: 0.0 };
        };
        let t = place - i as f64;
        let heading_rad = a.heading_rad + t * wrap_angle(b.heading_rad - a.heading_rad);
        Spot { x: a.x + t * (b.x - a.x), y: a.y + t * (b.y - a.y), heading_rad }
    }

    /// A place beside the trail, as far to the left as there is room.
    fn beside(&self, along_m: f64, left_m: f64) -> [f64; 2] {
        let room_m = self.room(along_m);
        self.at(along_m).beside(left_m.clamp(-room_m, room_m))
    }

    /// Somebody at a moment.
    fn posture(&self, person: &Person, time_s: f64) -> Posture {
        let step_m = 0.4 * person.body.height_m;
        match person.way {
            Way::Ahead { gap_m, wave_m, hertz, phase, left_m } => {
                let along = |time_s: f64| self.camera_at(time_s) + gap_m + wave_m * libm::sin(TAU * hertz * time_s + phase);
                self.walking(along, time_s, 1.0, left_m, step_m)
            }
            Way::Toward { meet_s, meet_m, speed_mps, left_m } => {
                self.walking(|time_s| meet_m - speed_mps * (time_s - meet_s), time_s, -1.0, left_m, step_m)
            }
            Way::Across { from, direction_rad, length_m, speed_mps, phase_m } => {
                let walked_m = phase_m + speed_mps * time_s;
                let place = walked_m.rem_euclid(2.0 * length_m);
                let off = if place < length_m { place } else { 2.0 * length_m - place };
                let (s, c) = libm::sincos(direction_rad);
                // Turning round takes the time of half a metre, half of it on either side of the end.
                let turned = if place < 0.5 * length_m {
                    1.5 + (place / TURN_M).min(0.5)
                } else if place < 1.5 * length_m {
                    (0.5 + (place - length_m) / TURN_M).clamp(0.0, 1.0)
                } else {
                    1.5 + ((place - 2.0 * length_m) / TURN_M).max(-0.5)
                };
                Posture {
                    x: from[0] + off * c,
                    y: from[1] + off * s,
                    heading_rad: direction_rad + PI * turned,
                    speed_mps,
                    steps: walked_m / step_m,
                }
            }
            Way::Stand { at, heading_rad, phase } => {
                let heading_rad = heading_rad + 0.25 * libm::sin(0.4 * time_s + phase);
                Posture { x: at[0], y: at[1], heading_rad, speed_mps: 0.0, steps: 0.0 }
            }
        }
    }

    /// Somebody on the trail who faces along it (`sign` 1) or against it (−1).
    fn walking(&self, along: impl Fn(f64) -> f64, time_s: f64, sign: f64, left_m: f64, step_m: f64) -> Posture {
        let clamped = |time_s: f64| along(time_s).clamp(0.0, self.length_m());
        let at = clamped(time_s);
        let (behind, ahead) = (self.beside(at - 0.2 * sign, left_m), self.beside(at + 0.2 * sign, left_m));
        let [x, y] = self.beside(at, left_m);
        let heading_rad = libm::atan2(ahead[1] - behind[1], ahead[0] - behind[0]);
        let speed_mps = (clamped(time_s + 0.15) - clamped(time_s - 0.15)).abs() / 0.3;
        Posture { x, y, heading_rad, speed_mps, steps: sign * at / step_m }
    }
}

/// The value at a fractional place between those of a list; its ends beyond them.
fn between(values: &[f64], place: f64) -> f64 {
    let place = place.clamp(0.0, values.len().saturating_sub(1) as f64);
    let i = place as usize;
    let (Some(a), Some(b)) = (values.get(i), values.get(i + 1).or(values.get(i))) else { return 0.0 };
    a + (place - i as f64) * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::building::{Building, BuildingOptions};
    use crate::look::Look;

    fn straight() -> (World, Trail) {
        let building = Building::generate(&BuildingOptions::default(), Seed(2)).unwrap();
        let world = World::new(&building, &Look::default(), Seed(2));
        let centre = building.rooms.iter().max_by(|a, b| a.area_m2().total_cmp(&b.area_m2())).unwrap().centre();
        let footings: Vec<Footing> =
            (0..20).map(|i| Footing { x: centre.x + 0.05 * f64::from(i), y: centre.y, heading_rad: 0.0 }).collect();
        let trail = Trail::new(&world, &footings);
        (world, trail)
    }

    #[test]
    fn a_trail_tells_where_the_camera_is_and_leads_on_beyond_its_end() {
        let (world, trail) = straight();
        let start = trail.at(trail.camera_at(0.0));
        let end = trail.at(trail.camera_at(1.9));
        assert!((end.x - start.x - 0.95).abs() < 0.051, "{start:?} {end:?}");
        assert!(trail.length_m() > 1.0);
        for i in 0..trail.spots.len() {
            for left_m in [-2.0, 2.0] {
                let [x, y] = trail.beside(POINT_M * i as f64, left_m);
                // On a straight way the room beside it is the clearance less half a person.
                assert!(world.clearance(Pt2::new(x, y)) > HALF_WIDTH_M - 0.1, "in a wall at {x}, {y}");
            }
        }
    }

    #[test]
    fn who_goes_to_and_fro_turns_round_without_a_jump() {
        let (_, trail) = straight();
        let way = Way::Across { from: [1.0, 2.0], direction_rad: 0.4, length_m: 2.0, speed_mps: 1.0, phase_m: 0.3 };
        let person = Person { body: Body { height_m: 1.7, seed: 1 }, way };
        let mut before = trail.posture(&person, 0.0);
        for i in 1..1000 {
            let now = trail.posture(&person, 0.01 * f64::from(i));
            assert!(libm::hypot(now.x - before.x, now.y - before.y) < 0.011);
            // Half a turn in half a second.
            assert!(wrap_angle(now.heading_rad - before.heading_rad).abs() < 0.07, "at {i}: {before:?} {now:?}");
            before = now;
        }
        // He faces where he goes.
        let (a, b) = (trail.posture(&person, 0.5), trail.posture(&person, 0.6));
        assert!(wrap_angle(libm::atan2(b.y - a.y, b.x - a.x) - a.heading_rad).abs() < 1e-6);
    }
}
