//! How does a layout become a building? Lines with doors in them are cut, leaves are hung, and lies are told about the plan.

use planwalk_types::{Plan, Pt2, Seed, StreamRng, Wall};
use rand::RngExt;

use super::room::Room;
use super::{Building, BuildingOptions, Door, RoomKind, lies};

/// From a door to the next corner: frame, light switch.
const DOOR_MARGIN_M: f64 = 0.3;
/// Pieces of wall shorter than this are none: a door that fills its line leaves them.
const PIECE_M: f64 = 1e-6;

/// A wall before its doors are cut out, and the doors' places along it.
pub(super) struct Line {
    pub from: Pt2<Plan>,
    pub to: Pt2<Plan>,
    pub doors: Vec<Pt2<Plan>>,
    /// Whether it parts two rooms that do without it: only such a wall is ever left out.
    pub partition: bool,
}

impl Line {
    pub fn new(x0: f64, y0: f64, x1: f64, y1: f64, doors: Vec<Pt2<Plan>>) -> Self {
        Self { from: Pt2::new(x0, y0), to: Pt2::new(x1, y1), doors, partition: false }
    }

    pub fn partition(x0: f64, y0: f64, x1: f64, y1: f64, doors: Vec<Pt2<Plan>>) -> Self {
        Self { partition: true, ..Self::new(x0, y0, x1, y1, doors) }
    }

    pub fn between(from: Pt2<Plan>, to: Pt2<Plan>) -> Self {
        Self { from, to, doors: Vec::new(), partition: false }
    }
}

/// A layout: rooms, and lines between them.
pub(super) struct Sketch {
    pub rooms: Vec<Room>,
    pub lines: Vec<Line>,
    /// Clear width of the doors, metres.
    pub door_m: f64,
    /// Whether a door between rooms of these kinds always stands open, so that a walk has somewhere to go.
    pub always_open: fn(RoomKind, RoomKind) -> bool,
    /// Whether desks and cupboards are all its furniture.
    pub plain: bool,
}

/// A place for a door between two coordinates, off the corners.
pub(super) fn place(low: f64, high: f64, door_m: f64, rng: &mut StreamRng) -> f64 {
    let margin = DOOR_MARGIN_M + 0.5 * door_m;
    if high - low <= 2.0 * margin { 0.5 * (low + high) } else { rng.random_range(low + margin..high - margin) }
}

impl Sketch {
    /// Cuts, hangs, mirrors by chance, and lies as far as the options say.
    pub fn build(self, options: &BuildingOptions, size_m: (f64, f64), seed: Seed, rng: &mut StreamRng) -> Building {
        let Self { rooms, lines, door_m, always_open, plain } = self;
        let mut building = Building { rooms, plain, ..Building::empty() };
        let mut lies_rng = seed.derive("lies", 0);
        for line in lines {
            let missing = line.partition && lies_rng.random_range(0.0..1.0) < options.lies.missing_share;
            let (pieces, doors) = cut(&line, door_m, always_open, options, &building, rng);
            building.drawn.extend_from_slice(&pieces);
            if !missing {
                building.walls.extend(pieces);
                building.doors.extend(doors);
            }
        }
        let flips = [rng.random_range(0.0..1.0) < 0.5, rng.random_range(0.0..1.0) < 0.5];
        mirror(&mut building, flips, size_m);
        lies::add_walls(&mut building, options.lies.extra_count, &mut lies_rng);
        building
    }
}

/// What is left of a line when its doors are cut out, and the doors with their leaves hung.
fn cut(
    line: &Line,
    door_m: f64,
    always_open: fn(RoomKind, RoomKind) -> bool,
    options: &BuildingOptions,
    building: &Building,
    rng: &mut StreamRng,
) -> (Vec<Wall>, Vec<Door>) {
    let (mut pieces, mut doors) = (Vec::new(), Vec::new());
    let length = line.from.distance(line.to);
    let (ex, ey) = ((line.to.x - line.from.x) / length, (line.to.y - line.from.y) / length);
    let at = |s: f64| Pt2::<Plan>::new(line.from.x + s * ex, line.from.y + s * ey);
    let mut places: Vec<f64> = line.doors.iter().map(|p| (p.x - line.from.x) * ex + (p.y - line.from.y) * ey).collect();
    places.sort_by(f64::total_cmp);
    let mut done = 0.0;
    for s in places {
        let opening = Wall { from: at(s - 0.5 * door_m), to: at(s + 0.5 * door_m) };
        if s - 0.5 * door_m - done > PIECE_M {
            pieces.push(Wall { from: at(done), to: opening.from });
        }
        done = s + 0.5 * door_m;
        let side = |n: f64| building.room_at(Pt2::new(at(s).x - n * ey, at(s).y + n * ex));
        let (left, right) = (side(0.3).unwrap_or(0), side(-0.3).unwrap_or(0));
        let kind = |room: usize| building.rooms.get(room).map_or(RoomKind::Corridor, |r| r.kind);
        let private = |room: usize| kind(room) != RoomKind::Corridor;
        // Leaves swing into rooms, not into the corridor, and hang at the end nearer to the room's corner.
        let swings_into = if private(left) { left } else { right };
        let (room_low, room_high) = building.rooms.get(swings_into).map_or((line.from, line.to), Room::bounds);
        let low = (room_low.x - line.from.x) * ex + (room_low.y - line.from.y) * ey;
        let high = (room_high.x - line.from.x) * ex + (room_high.y - line.from.y) * ey;
        let hinge_at_from = s - low < high - s;
        let open = rng.random_range(0.0..1.0) < options.open_doors || always_open(kind(left), kind(right));
        doors.push(Door { opening, open, swings_into, hinge_at_from });
    }
    if length - done > PIECE_M {
        pieces.push(Wall { from: at(done), to: line.to });
    }
    (pieces, doors)
}

fn mirror(building: &mut Building, [flip_x, flip_y]: [bool; 2], (width, depth): (f64, f64)) {
    let map = |p: Pt2<Plan>| Pt2::<Plan>::new(if flip_x { width - p.x } else { p.x }, if flip_y { depth - p.y } else { p.y });
    let Building { walls, drawn, doors, rooms, .. } = building;
    for wall in walls.iter_mut().chain(drawn).chain(doors.iter_mut().map(|d| &mut d.opening)) {
        *wall = Wall { from: map(wall.from), to: map(wall.to) };
    }
    for room in rooms {
        room.outline.iter_mut().for_each(|p| *p = map(*p));
        if flip_x != flip_y {
            room.outline.reverse();
        }
    }
}
