//! How is a rotunda laid out? A round hall, a corridor around it, rooms between oblique walls, and a wing at an odd angle.

use planwalk_types::{Plan, Pt2, StreamRng};
use rand::RngExt;

use super::office::{DOOR_M, hall_is_open, place};
use super::sketch::{Line, Sketch};
use super::{Room, RoomKind};

use std::f64::consts::TAU;

/// Largest angle of one side of a ring, radians: at least 56 sides a ring.
const SIDE_RAD: f64 = TAU / 56.0;
/// Half of the width of the wing's corridor, metres.
const WAY_HALF_M: f64 = 1.05;
/// Between the rotunda and the wing's rooms, metres.
const GAP_M: f64 = 0.4;

/// A circle as a polygon: its corners in order, and which of its sides is a doorway or an opening.
struct Ring {
    corners: Vec<(f64, Pt2<Plan>)>,
    doorway: Vec<bool>,
    opening: Vec<bool>,
}

impl Ring {
    /// A ring around `centre` with doors in the middle of sides at these angles, and corners at others. All angles are counted from
    /// the ring's first corner at `start`, 0..2π; the last `opening_rad` of the circle are open.
    fn new(centre: Pt2<Plan>, radius: f64, start: f64, doors: &[f64], corners: &[f64], opening_rad: f64) -> Self {
        let half = libm::asin(0.5 * DOOR_M / radius);
        let end = TAU - opening_rad;
        // Each side that is fixed: where it begins, and whether it is a doorway.
        let mut fixed: Vec<(f64, bool)> = corners.iter().map(|a| (*a, false)).chain([(0.0, false)]).collect();
        fixed.extend(doors.iter().flat_map(|a| [(a - half, true), (a + half, false)]));
        fixed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ring = Self { corners: Vec::new(), doorway: Vec::new(), opening: Vec::new() };
        for (i, (from, doorway)) in fixed.iter().enumerate() {
            let to = fixed.get(i + 1).map_or(end, |next| next.0);
            let pieces = if *doorway { 1 } else { ((to - from) / SIDE_RAD).ceil().max(1.0) as usize };
            for k in 0..pieces {
                ring.push(centre, radius, start, from + (to - from) * k as f64 / pieces as f64, *doorway, false);
            }
        }
        if opening_rad > 0.0 {
            ring.push(centre, radius, start, end, false, true);
        }
        ring
    }

    fn push(&mut self, centre: Pt2<Plan>, radius: f64, start: f64, angle: f64, doorway: bool, opening: bool) {
        let (s, c) = libm::sincos(start + angle);
        self.corners.push((angle, Pt2::new(centre.x + radius * c, centre.y + radius * s)));
        self.doorway.push(doorway);
        self.opening.push(opening);
    }

    fn points(&self) -> Vec<Pt2<Plan>> {
        self.corners.iter().map(|c| c.1).collect()
    }

    /// Its corners between two angles that are corners themselves.
    fn arc(&self, from: f64, to: f64) -> impl DoubleEndedIterator<Item = Pt2<Plan>> + '_ {
        self.corners.iter().filter(move |c| c.0 > from - 1e-9 && c.0 < to + 1e-9).map(|c| c.1)
    }

    fn lines(&self) -> impl Iterator<Item = Line> + '_ {
        let count = self.corners.len();
        (0..count).filter(|i| !self.opening[*i]).map(move |i| {
            let (a, b) = (self.corners[i].1, self.corners[(i + 1) % count].1);
            let middle = Pt2::new(0.5 * (a.x + b.x), 0.5 * (a.y + b.y));
            Line { doors: if self.doorway[i] { vec![middle] } else { vec![] }, ..Line::between(a, b) }
        })
    }
}

/// The layout, and its size.
pub(super) fn layout((width, depth): (f64, f64), rng: &mut StreamRng) -> (Sketch, (f64, f64)) {
    let radius = 0.5 * width;
    let centre = Pt2::<Plan>::new(radius, radius);
    let hall_m = radius * rng.random_range(0.36..0.42);
    let way_m = hall_m + rng.random_range(2.1..2.5);
    // Neither level nor upright nor at 45°.
    let heading = if rng.random_range(0.0..1.0) < 0.5 { rng.random_range(0.25..0.65) } else { rng.random_range(0.92..1.32) };
    let half = |r: f64| libm::asin(WAY_HALF_M / r);
    // Angles are counted from the wing's left side: rooms fill the rest of the circle.
    let count = ((TAU * way_m / 4.6).round() as usize).max(6);
    let share = |k: usize, jitter: f64| (k as f64 + jitter) / count as f64 * TAU;
    let radials: Vec<f64> = (1..count).map(|k| share(k, rng.random_range(-0.16..0.16))).collect();
    // Seen from the wing's axis; each ring has its own start.
    let on_ring = |angle: f64, r: f64| angle - half(r);
    let ends: Vec<f64> = std::iter::once(half(way_m)).chain(radials.iter().copied()).chain([TAU - half(way_m)]).collect();
    let door_angles: Vec<f64> = ends.windows(2).map(|a| on_ring(0.5 * (a[0] + a[1]), way_m)).collect();
    let corners_at = |r: f64| -> Vec<f64> { radials.iter().map(|a| on_ring(*a, r)).collect() };
    let inner = Ring::new(centre, way_m, heading + half(way_m), &door_angles, &corners_at(way_m), 2.0 * half(way_m));
    let outer = Ring::new(centre, radius, heading + half(radius), &[], &corners_at(radius), 2.0 * half(radius));
    let hall_doors: Vec<f64> = (0..4).map(|k| (f64::from(k) + rng.random_range(0.3..0.7)) / 4.0 * TAU).collect();
    let hall = Ring::new(centre, hall_m, heading, &hall_doors, &[], 0.0);

    let mut rooms = vec![Room { kind: RoomKind::Hall, outline: hall.points() }];
    let mut lines: Vec<Line> = hall.lines().chain(inner.lines()).chain(outer.lines()).collect();
    for (k, pair) in ends.windows(2).enumerate() {
        let (first, last) = (k == 0, k + 2 == ends.len());
        let span = |r: f64| (if first { 0.0 } else { on_ring(pair[0], r) }, if last { TAU - 2.0 * half(r) } else { on_ring(pair[1], r) });
        let ((a0, a1), (b0, b1)) = (span(radius), span(way_m));
        let outline = outer.arc(a0, a1).chain(inner.arc(b0, b1).rev()).collect();
        let kind = if k % 5 == 3 { RoomKind::Store } else { RoomKind::Office };
        rooms.push(Room { kind, outline });
        if !last && let (Some(from), Some(to)) = (inner.arc(b1, b1).next(), outer.arc(a1, a1).next()) {
            lines.push(Line { partition: true, ..Line::between(from, to) });
        }
    }
    add_wing(
        centre,
        heading,
        [radius + GAP_M, radius + depth - width],
        libm::sqrt(way_m * way_m - WAY_HALF_M * WAY_HALF_M),
        &mut rooms,
        &mut lines,
        rng,
    );
    let (s, c) = libm::sincos(heading);
    let end = |v: f64| {
        let u = radius + depth - width;
        Pt2::new(centre.x + u * c - v * s, centre.y + u * s + v * c)
    };
    let rim: Vec<Pt2<Plan>> = inner.points().into_iter().chain([end(-WAY_HALF_M), end(WAY_HALF_M)]).collect();
    rooms.push(Room::around(RoomKind::Corridor, &rim, &hall.points()));
    (Sketch { rooms, lines, door_m: DOOR_M, always_open: hall_is_open, plain: false }, (width, depth))
}

/// Rooms on both sides of a corridor that leads away from the rotunda, `u` metres from its centre.
fn add_wing(
    centre: Pt2<Plan>,
    heading: f64,
    [u0, u1]: [f64; 2],
    corridor_u: f64,
    rooms: &mut Vec<Room>,
    lines: &mut Vec<Line>,
    rng: &mut StreamRng,
) {
    let (s, c) = libm::sincos(heading);
    let at = |u: f64, v: f64| Pt2::<Plan>::new(centre.x + u * c - v * s, centre.y + u * s + v * c);
    let rooms_m = rng.random_range(3.8..4.8);
    let rim = WAY_HALF_M + rooms_m;
    for side in [-1.0, 1.0] {
        let mut doors = Vec::new();
        let mut u = u0;
        while u < u1 {
            let wanted = rng.random_range(3.4..5.8);
            let end = if u + wanted > u1 - 2.8 { u1 } else { u + wanted };
            doors.push(at(place(u, end, rng), side * WAY_HALF_M));
            let corners = [(u, WAY_HALF_M), (end, WAY_HALF_M), (end, rim), (u, rim)];
            let mut outline: Vec<Pt2<Plan>> = corners.iter().map(|(u, v)| at(*u, side * v)).collect();
            if side < 0.0 {
                outline.reverse();
            }
            rooms.push(Room { kind: RoomKind::Office, outline });
            if end < u1 {
                lines.push(Line { partition: true, ..Line::between(at(end, side * WAY_HALF_M), at(end, side * rim)) });
            }
            u = end;
        }
        lines.push(Line { doors, ..Line::between(at(corridor_u, side * WAY_HALF_M), at(u1, side * WAY_HALF_M)) });
        lines.push(Line::between(at(u0, side * WAY_HALF_M), at(u0, side * rim)));
        lines.push(Line::between(at(u0, side * rim), at(u1, side * rim)));
    }
    lines.push(Line::between(at(u1, -rim), at(u1, rim)));
}
