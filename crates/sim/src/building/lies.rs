//! What was built that nobody drew? Stub walls and screens, where they bar no way.

use planwalk_types::{Plan, Pt2, StreamRng, Wall};
use rand::RngExt;

use super::{Building, RoomKind, distance_to_wall};

/// Free way that is kept around an added wall, metres: one passes it on at least one side, and every door.
const WAY_M: f64 = 1.3;
/// Places tried for each added wall.
const TRIES: usize = 60;

/// Adds walls to what is built, not to what is drawn: fewer than `count` where there is no room for them.
///
/// Each stands in one room, at right angles to one of its sides, and ends a way's width before anything else.
pub(super) fn add_walls(building: &mut Building, count: usize, rng: &mut StreamRng) {
    for _ in 0..count {
        for _ in 0..TRIES {
            let Some(wall) = stub(building, rng) else { continue };
            building.walls.push(wall);
            break;
        }
    }
}

/// A wall that starts on a side of a room and ends somewhere in it, if it leaves ways free.
fn stub(building: &Building, rng: &mut StreamRng) -> Option<Wall> {
    let usable: Vec<usize> = (0..building.rooms.len()).filter(|r| building.rooms[*r].kind != RoomKind::Corridor).collect();
    if usable.is_empty() {
        return None;
    }
    let room = &building.rooms[usable[rng.random_range(0..usable.len())]];
    let sides: Vec<_> = room.sides().collect();
    let (a, b) = sides[rng.random_range(0..sides.len())];
    let (share, length_m) = (rng.random_range(0.15..0.85), rng.random_range(1.0..2.6));
    let side_m = a.distance(b);
    let (ex, ey) = ((b.x - a.x) / side_m, (b.y - a.y) / side_m);
    let from = Pt2::<Plan>::new(a.x + share * side_m * ex, a.y + share * side_m * ey);
    // The room lies to the left of its outline.
    let at = |s: f64| Pt2::<Plan>::new(from.x - s * ey, from.y + s * ex);
    let wall = Wall { from, to: at(length_m) };
    let beyond = Wall { from: at(0.05), to: at(length_m + WAY_M) };
    let inside = room.holds(at(0.05)) && room.holds(at(0.5 * length_m)) && room.holds(beyond.to);
    let off_others = building.walls.iter().filter(|w| distance_to_wall(from, w) > 0.01).all(|w| distance_between(&wall, w) > WAY_M);
    let on_a_wall = building.walls.iter().any(|w| distance_to_wall(from, w) < 1e-6);
    let off_doors = building.doors.iter().all(|d| distance_to_wall(d.centre(), &wall) > WAY_M);
    (inside && on_a_wall && off_others && off_doors).then_some(wall)
}

/// Least distance of two lines that do not cross, metres.
fn distance_between(one: &Wall, other: &Wall) -> f64 {
    let ends = [distance_to_wall(one.from, other), distance_to_wall(one.to, other)];
    ends.into_iter().chain([distance_to_wall(other.from, one), distance_to_wall(other.to, one)]).fold(f64::INFINITY, f64::min)
}
