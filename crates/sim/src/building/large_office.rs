//! How is a large office laid out? Parallel corridors, legs between them, and rooms along all of them.
//!
//! ```text
//!  ┌────┬─────┬───┬──────┬───┐      n corridors from left to right, each with a row of rooms below and above it.
//!  ├────┴─────┴───┴──────┴───┤      Between two corridors, rows stand back to back, and legs join the corridors.
//!  │ corridor                │      With one corridor alone the legs are dead ends.
//!  ├───┬───┐  ┌────┬──────┬──┤
//!  ├───┴─┬─┤  ├──┬─┴──┬───┴──┤
//!  │     └─┘  └──┘           │
//!  ├──────┬────┬──┬────┬─────┤
//!  └──────┴────┴──┴────┴─────┘
//! ```

use planwalk_types::{Pt2, StreamRng};
use rand::RngExt;

use super::office::{DOOR_M, hall_is_open, place};
use super::sketch::{Line, Sketch};
use super::{Room, RoomKind};

/// From one corridor to the next, about, metres: two rows of rooms and the corridor.
const PITCH_M: f64 = 14.0;
/// A narrow room is a store now and then, metres.
const STORE_M: f64 = 3.9;

/// One row of rooms: where it lies, and on which side its corridor is.
struct Row {
    y: [f64; 2],
    /// Height of the wall to the corridor, one of the two above.
    front: f64,
    /// Its blocks between legs.
    blocks: Vec<[f64; 2]>,
}

/// The layout, and its true size.
pub(super) fn layout((width, depth): (f64, f64), rng: &mut StreamRng) -> (Sketch, (f64, f64)) {
    let width = width * rng.random_range(0.97..1.03);
    let depth = depth * rng.random_range(0.97..1.03);
    let count = ((depth / PITCH_M).round() as usize).max(1);
    let corridors: Vec<[f64; 2]> = (0..count)
        .map(|j| {
            let middle = depth * (j as f64 + 0.5) / count as f64 + rng.random_range(-0.6..0.6);
            let half = rng.random_range(0.9..1.1);
            [middle - half, middle + half]
        })
        .collect();
    let mut rooms: Vec<Room> = corridors.iter().map(|c| rectangle(RoomKind::Corridor, [0.0, width], *c)).collect();
    let mut lines = vec![
        Line::new(0.0, 0.0, width, 0.0, vec![]),
        Line::new(0.0, depth, width, depth, vec![]),
        Line::new(0.0, 0.0, 0.0, depth, vec![]),
        Line::new(width, 0.0, width, depth, vec![]),
    ];
    let mut rows = Vec::new();
    for j in 0..=count {
        let below = if j == 0 { 0.0 } else { corridors[j - 1][1] };
        let above = if j == count { depth } else { corridors[j][0] };
        // A single corridor has its legs above it.
        let legs = if (j > 0 && j < count) || (count == 1 && j == 1) { draw_legs(width, count, rng) } else { vec![] };
        for leg in &legs {
            rooms.push(rectangle(RoomKind::Corridor, *leg, [below, above]));
            for x in leg {
                let doors =
                    if rng.random_range(0.0..1.0) < 0.4 { vec![Pt2::new(*x, place(below, 0.5 * (below + above), rng))] } else { vec![] };
                lines.push(Line::new(*x, below, *x, above, doors));
            }
        }
        let blocks = between(&legs, width);
        if j == 0 {
            rows.push(Row { y: [below, above], front: above, blocks });
        } else if j == count {
            rows.push(Row { y: [below, above], front: below, blocks });
        } else {
            let middle = 0.5 * (below + above) + rng.random_range(-0.6..0.6);
            lines.extend(blocks.iter().map(|b| Line::new(b[0], middle, b[1], middle, vec![])));
            rows.push(Row { y: [below, middle], front: below, blocks: blocks.clone() });
            rows.push(Row { y: [middle, above], front: above, blocks });
        }
    }
    for (i, row) in rows.iter().enumerate() {
        for (k, block) in row.blocks.iter().enumerate() {
            fill(row, *block, i == 0 && k == 0, &mut rooms, &mut lines, rng);
        }
    }
    (Sketch { rooms, lines, door_m: DOOR_M, always_open: hall_is_open, plain: false }, (width, depth))
}

fn rectangle(kind: RoomKind, x: [f64; 2], y: [f64; 2]) -> Room {
    Room::rectangle(kind, Pt2::new(x[0], y[0]), Pt2::new(x[1], y[1]))
}

/// Where the legs between two corridors are.
fn draw_legs(width: f64, corridors: usize, rng: &mut StreamRng) -> Vec<[f64; 2]> {
    let count = ((width / 24.0).round() as usize).max(if corridors > 1 { 2 } else { 1 });
    (0..count)
        .map(|k| {
            let middle = width * (k as f64 + 0.5 + rng.random_range(-0.22..0.22)) / count as f64;
            let half = rng.random_range(0.85..1.05);
            [middle - half, middle + half]
        })
        .collect()
}

fn between(legs: &[[f64; 2]], width: f64) -> Vec<[f64; 2]> {
    let starts = std::iter::once(0.0).chain(legs.iter().map(|leg| leg[1]));
    let ends = legs.iter().map(|leg| leg[0]).chain([width]);
    starts.zip(ends).map(|(a, b)| [a, b]).collect()
}

/// Cuts a block into rooms, each with a door to the corridor, some with one to the next room.
fn fill(row: &Row, [x0, x1]: [f64; 2], with_hall: bool, rooms: &mut Vec<Room>, lines: &mut Vec<Line>, rng: &mut StreamRng) {
    let mut cuts = vec![x0];
    let mut doors = Vec::new();
    let mut at = x0;
    while at < x1 {
        let hall = with_hall && cuts.len() == 1;
        let wanted = if hall { rng.random_range(7.0..9.5) } else { rng.random_range(3.0..7.5) };
        // What would leave a sliver takes the rest.
        let end = if at + wanted > x1 - 2.8 { x1 } else { at + wanted };
        let kind = match end - at {
            _ if hall => RoomKind::Hall,
            w if w < STORE_M && rng.random_range(0.0..1.0) < 0.5 => RoomKind::Store,
            w if w > 6.0 && rng.random_range(0.0..1.0) < 0.35 => RoomKind::Meeting,
            _ => RoomKind::Office,
        };
        rooms.push(rectangle(kind, [at, end], row.y));
        doors.push(Pt2::new(place(at, end, rng), row.front));
        if end < x1 {
            let through = rng.random_range(0.0..1.0) < 0.3;
            let doors = if through { vec![Pt2::new(end, place(row.y[0], row.y[1], rng))] } else { vec![] };
            lines.push(Line::partition(end, row.y[0], end, row.y[1], doors));
        }
        cuts.push(end);
        at = end;
    }
    lines.push(Line::new(x0, row.front, x1, row.front, doors));
}
