//! How is a building laid out that looks the same from both ends? A ring of corridors with rooms at regular distances.
//!
//! ```text
//!  ┌──┬──┬──┬──┬──┬──┬──┬──┐    Turned by 180° it is almost the same; what tells the ends apart: one double room (the hall),
//!  ├──┴──┴──┴──┴──┴──┴──┴──┤    a few doors between rooms, small differences of the walls' places.
//!  ├─┐ ┌──┬──┬──┬──┬──┐ ┌──┤
//!  ├─┤ ├──┼──┼──┼──┼──┤ ├──┤
//!  ├─┘ └──┴──┴──┴──┴──┘ └──┤
//!  ├──┬──┬──┬──┬──┬──┬──┬──┤
//!  └──┴──┴──┴──┴──┴──┴──┴──┘
//! ```

use planwalk_types::{Plan, Pt2, StreamRng};
use rand::RngExt;

use super::office::{DOOR_M, hall_is_open};
use super::sketch::{Line, Sketch};
use super::{Room, RoomKind};

/// Width of the rooms, about, metres.
const PITCH_M: f64 = 5.0;
/// How far walls and doors are off their regular places, metres: what a person would not see.
const JITTER_M: f64 = 0.12;

/// A side of the ring seen as if it lay below: `map` turns (along, across) into the plan.
struct Side<'a> {
    /// Ends of the row of rooms, and of its wall to the corridor.
    row: [f64; 2],
    front: [f64; 2],
    /// Far wall and corridor wall.
    back: f64,
    face: f64,
    map: &'a dyn Fn(f64, f64) -> Pt2<Plan>,
}

/// The layout, and its true size.
pub(super) fn layout((width, depth): (f64, f64), rng: &mut StreamRng) -> (Sketch, (f64, f64)) {
    let pt = Pt2::<Plan>::new;
    let rooms_m = (0.2 * depth).clamp(4.0, 5.6);
    let way_m = rng.random_range(1.9..2.3);
    let inner_m = rooms_m + way_m;
    let rectangle = |m: f64| [pt(m, m), pt(width - m, m), pt(width - m, depth - m), pt(m, depth - m)];
    let mut rooms = vec![Room::around(RoomKind::Corridor, &rectangle(rooms_m), &rectangle(inner_m))];
    let mut lines = Vec::new();
    for m in [0.0, inner_m] {
        let corners = rectangle(m);
        // The core's long sides have doors: they are drawn with its rooms.
        lines.extend((0..4).filter(|k| m == 0.0 || k % 2 == 1).map(|k| Line::between(corners[k], corners[(k + 1) % 4])));
    }
    type Map<'a> = &'a dyn Fn(f64, f64) -> Pt2<Plan>;
    let sides: [(f64, Map<'_>); 4] =
        [(width, &|s, t| pt(s, t)), (width, &|s, t| pt(s, depth - t)), (depth, &|s, t| pt(t, s)), (depth, &|s, t| pt(width - t, s))];
    for (k, (length, map)) in sides.into_iter().enumerate() {
        let front = [rooms_m, length - rooms_m];
        // The long rows reach into the corners.
        let row = if k < 2 { [0.0, length] } else { front };
        add_rooms(&Side { row, front, back: 0.0, face: rooms_m, map }, k == 0, &mut rooms, &mut lines, rng);
    }
    // The rows at both ends share their outer walls with the long ones.
    for (x, y) in [(0.0, rooms_m), (0.0, depth - rooms_m), (width - rooms_m, rooms_m), (width - rooms_m, depth - rooms_m)] {
        lines.push(Line::new(x, y, x + rooms_m, y, vec![]));
    }
    // The core: two rows back to back.
    let middle = 0.5 * depth;
    let core = |face: f64| [[inner_m, width - inner_m], [middle, face]];
    for [x, y] in [core(inner_m), core(depth - inner_m)] {
        let map = |s: f64, t: f64| pt(s, t);
        let side = Side { row: x, front: x, back: y[0], face: y[1], map: &map };
        add_rooms(&side, false, &mut rooms, &mut lines, rng);
    }
    lines.push(Line::new(inner_m, middle, width - inner_m, middle, vec![]));
    (Sketch { rooms, lines, door_m: DOOR_M, always_open: hall_is_open, plain: false }, (width, depth))
}

/// A row of rooms with a door each to the corridor; the first and the last one reach to the row's ends.
fn add_rooms(side: &Side<'_>, with_hall: bool, rooms: &mut Vec<Room>, lines: &mut Vec<Line>, rng: &mut StreamRng) {
    let length = side.front[1] - side.front[0];
    let count = ((length / PITCH_M).round() as usize).max(1);
    // Two neighbours without a wall between them.
    let hall = if with_hall && count > 2 { rng.random_range(1..count - 1) } else { usize::MAX };
    let mut doors = Vec::new();
    let mut start = side.row[0];
    let mut first = 0;
    for k in 0..count {
        let regular = |k: usize| side.front[0] + length * k as f64 / count as f64;
        let door = 0.5 * (regular(k) + regular(k + 1)) + rng.random_range(-JITTER_M..JITTER_M);
        if k != hall {
            doors.push((side.map)(door, side.face));
        }
        let end = if k + 1 == count { side.row[1] } else { regular(k + 1) + rng.random_range(-JITTER_M..JITTER_M) };
        let through = rng.random_range(0.0..1.0) < 0.12;
        if k == hall {
            continue;
        }
        let (p, q) = ((side.map)(start, side.back), (side.map)(end, side.face));
        let (low, high) = (Pt2::new(p.x.min(q.x), p.y.min(q.y)), Pt2::new(p.x.max(q.x), p.y.max(q.y)));
        let kind = if k > first { RoomKind::Hall } else { RoomKind::Office };
        rooms.push(Room::rectangle(kind, low, high));
        if k + 1 < count {
            let (from, to) = ((side.map)(end, side.back), (side.map)(end, side.face));
            let middle = Pt2::new(0.5 * (from.x + to.x), 0.5 * (from.y + to.y));
            let doors = if through { vec![middle] } else { vec![] };
            lines.push(Line { doors, partition: true, ..Line::between(from, to) });
        }
        (start, first) = (end, k + 1);
    }
    let (from, to) = ((side.map)(side.front[0], side.face), (side.map)(side.front[1], side.face));
    lines.push(Line { doors, ..Line::between(from, to) });
}
