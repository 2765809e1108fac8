//! How is a home laid out? A narrow hall, day rooms and bath along it, bedrooms at its end.
//!
//! ```text
//!  ┌────────┬────┬───────┬───────┐ depth    Small flats have no study and no second bedroom.
//!  │kitchen │bath│bedroom│ study │
//!  ├────────┴────┴───────┤       │ c1
//!  │ hall                ├───────┤ c0
//!  ├────────────┬────────┤bedroom│
//!  │ living     │bedroom │       │
//!  └────────────┴────────┴───────┘ 0
//!  0            l        v       width
//! ```

use planwalk_types::{Pt2, StreamRng};
use rand::RngExt;

use super::sketch::{Line, Sketch, place};
use super::{Room, RoomKind};

/// Narrower flats have two rooms above the hall and one below it, metres.
const NARROW_M: f64 = 10.5;

/// The layout, and its true size.
pub(super) fn layout((width, depth): (f64, f64), rng: &mut StreamRng) -> (Sketch, (f64, f64)) {
    let door_m = rng.random_range(0.85..0.90);
    let c0 = depth * rng.random_range(0.43..0.48);
    let c1 = c0 + rng.random_range(1.25..1.5);
    let v = width * rng.random_range(0.64..0.70);
    // The bedroom at the hall's end reaches past its upper or its lower side.
    let r = if rng.random_range(0.0..1.0) < 0.5 { c1 + rng.random_range(0.1..0.5) } else { c0 - rng.random_range(0.1..0.5) };
    let room = |kind, x0: f64, y0: f64, x1: f64, y1: f64| Room::rectangle(kind, Pt2::new(x0, y0), Pt2::new(x1, y1));
    let narrow = width < NARROW_M;
    let bath = rng.random_range(2.0..2.4);
    let upper = if narrow { vec![0.0, v - bath, v] } else { vec![0.0, v * 0.37, v * 0.37 + bath, v] };
    let lower = if narrow { vec![0.0, v] } else { vec![0.0, v * rng.random_range(0.56..0.64), v] };
    let mut rooms = vec![
        room(RoomKind::Corridor, 0.0, c0, v, c1),
        room(RoomKind::Bedroom, v, 0.0, width, r),
        room(RoomKind::Bedroom, v, r, width, depth),
    ];
    let mut door = |low: f64, high: f64| place(low, high, door_m, rng);
    let (near_end, far_end) = if r > c1 { (c0, c1) } else { (c0.max(r), c1) };
    let mut lines = vec![
        Line::new(0.0, 0.0, width, 0.0, vec![]),
        Line::new(0.0, depth, width, depth, vec![]),
        Line::new(0.0, 0.0, 0.0, depth, vec![]),
        Line::new(width, 0.0, width, depth, vec![]),
        Line::new(v, 0.0, v, depth, vec![Pt2::new(v, 0.5 * (near_end + far_end))]),
        Line::partition(v, r, width, r, vec![Pt2::new(door(v, width), r)]),
    ];
    let doors = upper.windows(2).map(|x| Pt2::new(door(x[0], x[1]), c1)).collect();
    lines.push(Line::new(0.0, c1, v, c1, doors));
    let doors = lower.windows(2).map(|x| Pt2::new(door(x[0], x[1]), c0)).collect();
    lines.push(Line::new(0.0, c0, v, c0, doors));
    for (i, x) in upper.windows(2).enumerate() {
        rooms.push(room([RoomKind::Kitchen, RoomKind::Bath, RoomKind::Bedroom][i.min(2)], x[0], c1, x[1], depth));
        if i > 0 {
            lines.push(Line::new(x[0], c1, x[0], depth, vec![]));
        }
    }
    for (i, x) in lower.windows(2).enumerate() {
        rooms.push(room([RoomKind::Living, RoomKind::Bedroom][i.min(1)], x[0], 0.0, x[1], c0));
        if i > 0 {
            lines.push(Line::partition(x[0], 0.0, x[0], c0, vec![Pt2::new(x[0], door(0.0, c0))]));
        }
    }
    (Sketch { rooms, lines, door_m, always_open, plain: false }, (width, depth))
}

/// Living room and kitchen are open to the hall: nobody shuts these doors by day.
fn always_open(left: RoomKind, right: RoomKind) -> bool {
    let by_day = |kind| matches!(kind, RoomKind::Living | RoomKind::Kitchen);
    (by_day(left) && right == RoomKind::Corridor) || (by_day(right) && left == RoomKind::Corridor)
}
